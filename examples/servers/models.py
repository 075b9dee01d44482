"""Adapters of public models: Grounding DINO and SAM 2 (masks), CLIP (CLIP similarity), CoTracker3 (tracks).

Weights are names on the Hugging Face hub or local folders, as transformers takes them; CoTracker3's is a folder with its
repository (github.com/facebookresearch/co-tracker), as torch.hub takes it. All of them run on a GPU where there is one.
"""

import numpy as np
import torch

from adapter import picture_of, text_of, texts

DEVICE = "cuda" if torch.cuda.is_available() else "cpu"


class GroundingDino:
    name = "grounding-dino"
    inputs = {"image": ("BYTES", [1]), "prompt": ("BYTES", [1])}
    outputs = {"boxes": ("FP32", [-1, 4]), "scores": ("FP32", [-1]), "phrases": ("BYTES", [-1])}

    def __init__(self, weights="IDEA-Research/grounding-dino-tiny"):
        from transformers import AutoModelForZeroShotObjectDetection, AutoProcessor

        self.processor = AutoProcessor.from_pretrained(weights)
        self.model = AutoModelForZeroShotObjectDetection.from_pretrained(weights).to(DEVICE).eval()

    @torch.inference_mode()
    def __call__(self, tensors):
        picture = picture_of(tensors["image"][0])
        # The model was trained on lower-case phrases that end with a dot.
        text = text_of(tensors["prompt"][0]).lower().rstrip(". ") + "."
        inputs = self.processor(images=picture, text=text, return_tensors="pt").to(DEVICE)
        found = self.processor.post_process_grounded_object_detection(
            self.model(**inputs), inputs["input_ids"], threshold=0.25, text_threshold=0.25, target_sizes=[picture.size[::-1]]
        )[0]
        labels = found.get("text_labels", found["labels"])
        return {
            "boxes": found["boxes"].cpu().numpy().astype(np.float32).reshape(-1, 4),
            "scores": found["scores"].cpu().numpy().astype(np.float32),
            "phrases": texts([str(label) for label in labels]),
        }


class Sam2:
    name = "sam2"
    inputs = {"image": ("BYTES", [1]), "boxes": ("FP32", [-1, 4])}
    outputs = {"masks": ("BOOL", [-1, -1, -1]), "scores": ("FP32", [-1])}

    def __init__(self, weights="facebook/sam2.1-hiera-tiny"):
        from transformers import Sam2Model, Sam2Processor

        self.processor = Sam2Processor.from_pretrained(weights)
        self.model = Sam2Model.from_pretrained(weights).to(DEVICE).eval()

    @torch.inference_mode()
    def __call__(self, tensors):
        picture = picture_of(tensors["image"][0])
        boxes = np.asarray(tensors["boxes"], dtype=np.float32).reshape(-1, 4)
        inputs = self.processor(images=picture, input_boxes=[boxes.tolist()], return_tensors="pt").to(DEVICE)
        found = self.model(**inputs, multimask_output=False)
        masks = self.processor.post_process_masks(found.pred_masks.cpu(), inputs["original_sizes"].cpu())[0]
        return {
            "masks": masks[:, 0].numpy().astype(np.bool_),
            "scores": found.iou_scores[0, :, 0].clamp(0, 1).cpu().numpy().astype(np.float32),
        }


class ClipText:
    name = "clip-text"
    inputs = {"input_ids": ("INT64", [1, 77])}
    outputs = {"text_embeds": ("FP32", [1, -1])}

    def __init__(self, weights="openai/clip-vit-base-patch32"):
        from transformers import CLIPTextModelWithProjection

        self.model = CLIPTextModelWithProjection.from_pretrained(weights).to(DEVICE).eval()

    @torch.inference_mode()
    def __call__(self, tensors):
        ids = torch.tensor(np.asarray(tensors["input_ids"], dtype=np.int64).reshape(1, 77), device=DEVICE)
        return {"text_embeds": self.model(input_ids=ids).text_embeds.float().cpu().numpy()}


class ClipImage:
    name = "clip-image"
    inputs = {"pixel_values": ("FP32", [1, 3, 224, 224])}
    outputs = {"image_embeds": ("FP32", [1, -1])}

    def __init__(self, weights="openai/clip-vit-base-patch32"):
        from transformers import CLIPVisionModelWithProjection

        self.model = CLIPVisionModelWithProjection.from_pretrained(weights).to(DEVICE).eval()

    @torch.inference_mode()
    def __call__(self, tensors):
        pixels = torch.tensor(np.asarray(tensors["pixel_values"], dtype=np.float32).reshape(1, 3, 224, 224), device=DEVICE)
        return {"image_embeds": self.model(pixel_values=pixels).image_embeds.float().cpu().numpy()}


class CoTracker3:
    name = "cotracker3"
    inputs = {"frames": ("BYTES", [-1]), "queries": ("FP32", [1, -1, 3])}
    outputs = {"tracks": ("FP32", [1, -1, -1, 2]), "visibility": ("FP32", [1, -1, -1])}

    def __init__(self, weights="co-tracker"):
        self.model = torch.hub.load(weights, "cotracker3_offline", source="local").to(DEVICE).eval()

    @torch.inference_mode()
    def __call__(self, tensors):
        frames = np.stack([np.asarray(picture_of(frame)) for frame in tensors["frames"]])
        video = torch.tensor(frames, device=DEVICE).permute(0, 3, 1, 2)[None].float()
        # A query is a frame's number and a pixel, x before y.
        queries = torch.tensor(np.asarray(tensors["queries"], dtype=np.float32).reshape(1, -1, 3), device=DEVICE)
        tracks, visibility = self.model(video, queries=queries)
        return {"tracks": tracks.float().cpu().numpy(), "visibility": visibility.float().cpu().numpy()}
