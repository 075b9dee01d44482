"""A small property model for MLServer: what the protocol test of tests/cli/mlserver.bats serves.

Its "prediction" is a fixed function of the crops, so that the test knows the answer: E_mean is the number of crops, and
evidence goes to Foam.
"""

from mlserver import MLModel
from mlserver.codecs import NumpyCodec
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
