"""What a model server and a model have to say to each other: tensors in, tensors out, by name.

An adapter is a class with a `name`, `inputs` and `outputs` ({name: (datatype, shape)}, as docs/providers.md has them), and
`__call__`, which takes and gives {name: numpy array}. serve_triton.py, serve_kserve.py and serve_mlserver.py serve any of them.
"""

import base64
import importlib
import io

import numpy as np

DTYPES = {"FP16": np.float16, "FP32": np.float32, "INT64": np.int64, "UINT8": np.uint8, "BOOL": np.bool_, "BYTES": np.bytes_}


def png_of(element):
    """A picture's bytes. In JSON it comes as base64 text, with the binary tensor extension as it is."""
    data = element.encode() if isinstance(element, str) else bytes(element)
    return data if data.startswith(b"\x89PNG") else base64.b64decode(data, validate=True)


def text_of(element):
    return element if isinstance(element, str) else bytes(element).decode()


def picture_of(element):
    """An RGB picture (needs Pillow)."""
    from PIL import Image

    return Image.open(io.BytesIO(png_of(element))).convert("RGB")


def texts(values):
    """A BYTES tensor."""
    return np.array([v.encode() for v in values], dtype=np.bytes_)


def load(names, weights):
    """Adapters from "MODULE:CLASS", each with the weights given for its name, or its own: {"sam2": "facebook/sam2.1-hiera-tiny"}."""
    adapters = []
    for name in names:
        module, _, cls = name.partition(":")
        made = getattr(importlib.import_module(module), cls)
        adapters.append(made(weights[made.name]) if made.name in weights else made())
    return adapters


def arguments(description):
    """The command line that the servers share: adapters, weights, port."""
    import argparse

    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("adapters", nargs="+", metavar="MODULE:CLASS", help="what is served: models:GroundingDino models:Sam2")
    parser.add_argument("--weights", nargs="*", default=[], metavar="NAME=PATH", help="other weights than an adapter's own")
    parser.add_argument("--port", type=int, default=8001)
    options = parser.parse_args()
    return options, load(options.adapters, dict(w.split("=", 1) for w in options.weights))
