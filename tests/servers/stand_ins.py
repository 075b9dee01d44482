"""Stand-ins for models: fixed functions of the request, so that tests know their answers. Served by examples/servers."""

import struct

import numpy as np

from adapter import png_of, text_of, texts


def size_of(element):
    return struct.unpack(">II", png_of(element)[16:24])


class Predictor:
    """E_mean counts the crops, evidence goes to Foam."""

    name = "predictor"
    inputs = {"crops": ("BYTES", [-1])}
    outputs = {
        "E_mean": ("FP32", [-1]),
        "E_uncertainty": ("FP32", [-1]),
        "nu_mean": ("FP32", [-1]),
        "nu_uncertainty": ("FP32", [-1]),
        "label_evidence": ("FP32", [-1, 14]),
    }

    def __call__(self, tensors):
        crops = [png_of(c) for c in np.asarray(tensors["crops"]).reshape(-1)]
        assert all(crop.startswith(b"\x89PNG") for crop in crops)
        n = len(crops)
        evidence = np.zeros((n, 14), dtype=np.float32)
        evidence[:, 13] = 0.5
        return {
            "E_mean": np.full(n, -float(n), dtype=np.float32),
            "E_uncertainty": np.full(n, 0.25, dtype=np.float32),
            "nu_mean": np.full(n, float("nan"), dtype=np.float32),
            "nu_uncertainty": np.full(n, 0.03, dtype=np.float32),
            "label_evidence": evidence,
        }


class HalfPredictor(Predictor):
    """Speaks FP16, which JSON does not have."""

    name = "half"
    outputs = {name: ("FP16", shape) for name, (_, shape) in Predictor.outputs.items()}

    def __call__(self, tensors):
        return {k: v.astype(np.float16) for k, v in super().__call__(tensors).items()}


class Detector:
    """Knows where ball and box of the toy are, whatever the picture."""

    name = "grounding-dino"
    inputs = {"image": ("BYTES", [1]), "prompt": ("BYTES", [1])}
    outputs = {"boxes": ("FP32", [-1, 4]), "scores": ("FP32", [-1]), "phrases": ("BYTES", [-1])}
    PLACES = {"toy": (0.2, 0.1, 0.8, 0.9), "ball": (0.3, 0.1, 0.7, 0.5), "box": (0.2, 0.5, 0.8, 0.9)}

    def __call__(self, tensors):
        width, height = size_of(np.asarray(tensors["image"]).reshape(-1)[0])
        text = text_of(np.asarray(tensors["prompt"]).reshape(-1)[0])
        if text == "crash":
            raise RuntimeError("out of memory in the detector")
        found = [self.PLACES[text]] if text in self.PLACES else []
        boxes = np.array(found, dtype=np.float32).reshape(-1, 4) * np.array([width, height] * 2, dtype=np.float32)
        return {"boxes": boxes, "scores": np.full(len(found), 0.8, dtype=np.float32), "phrases": texts([text] * len(found))}


class Segmenter:
    """Every mask is its box."""

    name = "sam2"
    inputs = {"image": ("BYTES", [1]), "boxes": ("FP32", [-1, 4])}
    outputs = {"masks": ("BOOL", [-1, -1, -1]), "scores": ("FP32", [-1])}

    def __call__(self, tensors):
        width, height = size_of(np.asarray(tensors["image"]).reshape(-1)[0])
        boxes = np.asarray(tensors["boxes"]).reshape(-1, 4)
        masks = np.zeros((len(boxes), height, width), dtype=bool)
        for mask, (x0, y0, x1, y1) in zip(masks, boxes.astype(int)):
            mask[y0:y1, x0:x1] = True
        return {"masks": masks, "scores": np.full(len(boxes), 0.5, dtype=np.float32)}
