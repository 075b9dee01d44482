"""llama.cpp's server with a model of a few kilobytes, made here: tiny_chat.py PORT [--blind]

The model knows nothing but whether the last token opened a list; every token has a fixed preference then, so what it says is the shortest
text that the server's grammar lets through (empty lists and texts, quotes before letters). At temperature 1 it wavers in one thing, whether a name goes on
with "/" or ends, and a seed decides. Its eye, a vision tower with random weights, is there unless --blind is given.
"""

import sys
import time

import gguf
import numpy as np
import xllamacpp

WIDTH, CONTEXT = 32, 8192
TEMPLATE = (
    "{% for m in messages %}<{{ m['role'] }}>{% if m['content'] is string %}{{ m['content'] }}{% else %}"
    "{% for p in m['content'] %}{{ p['text'] }}{% endfor %}{% endif %}</s>{% endfor %}<assistant>"
)


def vocabulary():
    tokens = ["<unk>", "<s>", "</s>"] + ["<0x%02X>" % b for b in range(256)] + [chr(c) for c in range(33, 127)]
    kinds = [2, 3, 3] + [6] * 256 + [1] * 94
    return tokens, kinds


def preference(token, in_new_list):
    """The more, the earlier it is said where several may be."""
    order = ["</s>", '"', "]", "}", ",", ":", "{", "["] + list("rgbnt0")
    if in_new_list and token == "]":
        return 700.0
    if token in order:
        return 600.0 - 20 * order.index(token)
    if token == "/":
        return preference('"', in_new_list) - 1
    if len(token) == 1 and token.isalnum():
        return 200.0 - ord(token)
    return 0.0


def write_model(path):
    tokens, kinds = vocabulary()
    w = gguf.GGUFWriter(path, "llama")
    w.add_context_length(CONTEXT)
    w.add_embedding_length(WIDTH)
    w.add_block_count(1)
    w.add_feed_forward_length(WIDTH)
    w.add_head_count(2)
    w.add_head_count_kv(2)
    w.add_layer_norm_rms_eps(1e-5)
    w.add_rope_dimension_count(WIDTH // 2)
    w.add_vocab_size(len(tokens))
    w.add_tokenizer_model("llama")
    w.add_token_list(tokens)
    w.add_token_scores([0.0] * len(tokens))
    w.add_token_types(kinds)
    w.add_bos_token_id(1)
    w.add_eos_token_id(2)
    w.add_unk_token_id(0)
    w.add_chat_template(TEMPLATE)
    # The first half of the state says that a list was opened, the second that none was; whichever it is has norm 1 afterwards.
    half = WIDTH // 2
    embedded = np.zeros((len(tokens), WIDTH), dtype=np.float32)
    scores = np.zeros((len(tokens), WIDTH), dtype=np.float32)
    for i, token in enumerate(tokens):
        embedded[i, slice(0, half) if token == "[" else slice(half, WIDTH)] = 1
        scores[i, :half], scores[i, half:] = preference(token, True), preference(token, False)
    w.add_tensor("token_embd.weight", embedded)
    w.add_tensor("output.weight", scores / (half * 2**0.5))
    w.add_tensor("output_norm.weight", np.ones(WIDTH, dtype=np.float32))
    zeros = np.zeros((WIDTH, WIDTH), dtype=np.float32)
    for name in ("attn_q", "attn_k", "attn_v", "attn_output", "ffn_gate", "ffn_up", "ffn_down"):
        w.add_tensor("blk.0.%s.weight" % name, zeros)
    for name in ("attn_norm", "ffn_norm"):
        w.add_tensor("blk.0.%s.weight" % name, np.ones(WIDTH, dtype=np.float32))
    w.write_header_to_file()
    w.write_kv_data_to_file()
    w.write_tensors_to_file()
    w.close()


def write_eye(path):
    random = np.random.default_rng(1)

    def tensor(*shape):
        return (random.standard_normal(shape) * 0.05).astype(np.float32)

    w = gguf.GGUFWriter(path, "clip")
    w.add_bool("clip.has_vision_encoder", True)
    w.add_string("clip.projector_type", "mlp")
    w.add_bool("clip.use_gelu", True)
    for key, value in {"image_size": 28, "patch_size": 14, "embedding_length": WIDTH, "feed_forward_length": WIDTH, "projection_dim": WIDTH, "block_count": 1}.items():
        w.add_uint32("clip.vision." + key, value)
    w.add_uint32("clip.vision.attention.head_count", 2)
    w.add_float32("clip.vision.attention.layer_norm_epsilon", 1e-5)
    w.add_array("clip.vision.image_mean", [0.5, 0.5, 0.5])
    w.add_array("clip.vision.image_std", [0.5, 0.5, 0.5])
    w.add_tensor("v.class_embd", tensor(WIDTH))
    w.add_tensor("v.patch_embd.weight", tensor(WIDTH, 3, 14, 14))
    w.add_tensor("v.position_embd.weight", tensor(5, WIDTH))
    for name in ("v.pre_ln", "v.post_ln", "v.blk.0.ln1", "v.blk.0.ln2"):
        w.add_tensor(name + ".weight", np.ones(WIDTH, dtype=np.float32))
        w.add_tensor(name + ".bias", np.zeros(WIDTH, dtype=np.float32))
    for name in ("attn_q", "attn_k", "attn_v", "attn_out", "ffn_up", "ffn_down"):
        w.add_tensor("v.blk.0.%s.weight" % name, tensor(WIDTH, WIDTH))
        w.add_tensor("v.blk.0.%s.bias" % name, np.zeros(WIDTH, dtype=np.float32))
    for name in ("mm.0", "mm.2"):
        w.add_tensor(name + ".weight", tensor(WIDTH, WIDTH))
        w.add_tensor(name + ".bias", np.zeros(WIDTH, dtype=np.float32))
    w.write_header_to_file()
    w.write_kv_data_to_file()
    w.write_tensors_to_file()
    w.close()


write_model("tiny.gguf")
params = xllamacpp.CommonParams()
params.model.path = "tiny.gguf"
params.model_alias = ["tiny"] if not isinstance(params.model_alias, str) else "tiny"
params.hostnames = ["127.0.0.1"]
params.port = int(sys.argv[1])
params.n_ctx = CONTEXT
params.n_parallel = 1
params.warmup = False
params.cpuparams.n_threads = 1
if "--blind" not in sys.argv:
    write_eye("eye.gguf")
    params.mmproj.path = "eye.gguf"
server = xllamacpp.Server(params)
print("serving on", server.listening_address, file=sys.stderr, flush=True)
while True:
    time.sleep(60)
