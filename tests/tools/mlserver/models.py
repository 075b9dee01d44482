"""Small models for MLServer: what the protocol tests of tests/cli/mlserver.bats serve.

Their answers are fixed functions of the request, so that the tests know them. The predictor counts the crops (E_mean)
and gives evidence to Foam; the detector knows where ball and box of the toy are, whatever the picture; every mask of
the segmenter is its box.
"""

import struct

from mlserver import MLModel
from mlserver.codecs import NumpyCodec, StringCodec
from mlserver.types import InferenceResponse
import numpy as np


class Predictor(MLModel):
    async def load(self):
        return True

    async def predict(self, payload):
        crops = self.decode(payload.inputs[0])
        assert all(bytes(crop).startswith(b"\x89PNG") for crop in crops), "crops are not PNG files"
        n = len(crops)
        evidence = np.zeros((n, 14), dtype=np.float32)
        evidence[:, 13] = 0.5
        values = {
            "E_mean": np.full(n, -float(n)),
            "E_uncertainty": np.full(n, 0.25),
            "nu_mean": np.full(n, -1.0),
            "nu_uncertainty": np.full(n, 0.03),
        }
        outputs = [NumpyCodec.encode_output(k, v.astype(np.float32)) for k, v in values.items()]
        outputs.append(NumpyCodec.encode_output("label_evidence", evidence))
        return InferenceResponse(model_name=self.name, outputs=outputs)


def size_of(png):
    assert bytes(png).startswith(b"\x89PNG"), "the image is not a PNG file"
    return struct.unpack(">II", bytes(png)[16:24])


class Detector(MLModel):
    # In fractions of the picture.
    PLACES = {"toy": (0.2, 0.1, 0.8, 0.9), "ball": (0.3, 0.1, 0.7, 0.5), "box": (0.2, 0.5, 0.8, 0.9)}

    async def load(self):
        return True

    async def predict(self, payload):
        width, height = size_of(self.decode(payload.inputs[0])[0])
        text = self.decode(payload.inputs[1])[0]
        found = [self.PLACES[text]] if text in self.PLACES else []
        boxes = np.array(found, dtype=np.float32).reshape(-1, 4) * np.array([width, height] * 2, dtype=np.float32)
        return InferenceResponse(
            model_name=self.name,
            outputs=[
                NumpyCodec.encode_output("boxes", boxes),
                NumpyCodec.encode_output("scores", np.full(len(found), 0.8, dtype=np.float32)),
                StringCodec.encode_output("phrases", [text] * len(found)),
            ],
        )


class Segmenter(MLModel):
    async def load(self):
        return True

    async def predict(self, payload):
        width, height = size_of(self.decode(payload.inputs[0])[0])
        boxes = NumpyCodec.decode_input(payload.inputs[1])
        masks = np.zeros((len(boxes), height, width), dtype=bool)
        for mask, (x0, y0, x1, y1) in zip(masks, boxes.astype(int)):
            mask[y0:y1, x0:x1] = True
        return InferenceResponse(
            model_name=self.name,
            outputs=[
                NumpyCodec.encode_output("masks", masks),
                NumpyCodec.encode_output("scores", np.full(len(boxes), 0.5, dtype=np.float32)),
            ],
        )
