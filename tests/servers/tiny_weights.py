"""Weights of the right form and no meaning for examples/servers/models.py: tiny_weights.py FOLDER

Small random models of transformers' own classes, as their hub would give them, and a repository in CoTracker3's place.
"""

import os
import string
import sys

import torch
from transformers import (
    BertConfig,
    BertTokenizer,
    CLIPTextConfig,
    CLIPTextModelWithProjection,
    CLIPVisionConfig,
    CLIPVisionModelWithProjection,
    GroundingDinoConfig,
    GroundingDinoForObjectDetection,
    GroundingDinoImageProcessor,
    GroundingDinoProcessor,
    Sam2Config,
    Sam2HieraDetConfig,
    Sam2Model,
    Sam2Processor,
    Sam2VisionConfig,
    SwinConfig,
)
from transformers.models.sam2.image_processing_sam2 import Sam2ImageProcessor

torch.manual_seed(1)
folder = sys.argv[1]
os.makedirs(folder, exist_ok=True)


def place(name):
    return os.path.join(folder, name)


words = ["[PAD]", "[UNK]", "[CLS]", "[SEP]", "[MASK]", ".", "red", "square", "ball", "box", "toy"]
words += list(string.ascii_lowercase) + ["##" + c for c in string.ascii_lowercase]
with open(place("vocab.txt"), "w") as f:
    f.write("\n".join(words))

swin = SwinConfig(image_size=64, patch_size=4, embed_dim=16, depths=[1, 1, 1, 1], num_heads=[1, 2, 2, 2], window_size=4, out_features=["stage2", "stage3", "stage4"])
bert = BertConfig(vocab_size=len(words), hidden_size=32, num_hidden_layers=1, num_attention_heads=2, intermediate_size=64)
dino = GroundingDinoConfig(
    backbone_config=swin,
    text_config=bert,
    num_queries=16,
    d_model=32,
    encoder_layers=1,
    decoder_layers=2,
    encoder_attention_heads=2,
    decoder_attention_heads=2,
    encoder_ffn_dim=32,
    decoder_ffn_dim=32,
)
GroundingDinoForObjectDetection(dino).save_pretrained(place("dino"))
pictures = GroundingDinoImageProcessor(size={"shortest_edge": 128, "longest_edge": 160})
GroundingDinoProcessor(pictures, BertTokenizer(place("vocab.txt"))).save_pretrained(place("dino"))

# Its pictures keep their 1024 pixels.
widths = [16, 32, 64, 128]
hiera = Sam2HieraDetConfig(hidden_size=16, blocks_per_stage=[1, 1, 2, 1], embed_dim_per_stage=widths, num_attention_heads_per_stage=[1] * 4, global_attention_blocks=[3])
eye = Sam2VisionConfig(backbone_config=hiera, backbone_channel_list=widths[::-1])
Sam2Model(Sam2Config(vision_config=eye)).save_pretrained(place("sam2"))
Sam2Processor(Sam2ImageProcessor()).save_pretrained(place("sam2"))

clip = dict(hidden_size=32, intermediate_size=32, num_hidden_layers=1, num_attention_heads=2, projection_dim=16)
CLIPTextModelWithProjection(CLIPTextConfig(**clip)).save_pretrained(place("clip-text"))
CLIPVisionModelWithProjection(CLIPVisionConfig(**clip)).save_pretrained(place("clip-image"))

# What torch.hub finds in the repository: a model that follows every query by a pixel to the right per frame.
os.makedirs(place("co-tracker"), exist_ok=True)
with open(place("co-tracker/hubconf.py"), "w") as f:
    f.write(
        '''import torch


class Tracker(torch.nn.Module):
    def forward(self, video, queries):
        assert video.shape[2] == 3 and queries.shape[2] == 3
        steps = torch.arange(video.shape[1], device=video.device).float()
        tracks = queries[:, None, :, 1:].repeat(1, len(steps), 1, 1)
        tracks[..., 0] += steps[None, :, None]
        return tracks, torch.ones(tracks.shape[:3], dtype=torch.bool, device=video.device)


def cotracker3_offline(pretrained=True):
    return Tracker()
'''
    )
