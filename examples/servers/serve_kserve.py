"""Serves adapters from KServe's own model server, as a custom runtime of a cluster runs it: pip install kserve

    python serve_kserve.py models:GroundingDino models:Sam2 --port 8001
"""

import sys

import kserve
import numpy as np
from kserve import InferOutput, InferResponse

from adapter import arguments


def array_of(tensor):
    """A tensor as numpy; texts stay what they are."""
    return np.array(tensor.data, dtype=np.object_).reshape(-1) if tensor.datatype == "BYTES" else tensor.as_numpy()


def output_of(name, kind, value):
    value = np.asarray(value)
    output = InferOutput(name, list(value.shape), kind)
    if kind == "BYTES":
        output.data = [v.decode() for v in value.reshape(-1)]
    else:
        output.set_data_from_numpy(value, binary_data=False)
    return output


class Served(kserve.Model):
    def __init__(self, adapter):
        super().__init__(adapter.name)
        self.adapter = adapter
        self.ready = True

    async def predict(self, payload, headers=None, response_headers=None):
        found = self.adapter({t.name: array_of(t) for t in payload.inputs})
        outputs = [output_of(name, kind, found[name]) for name, (kind, _) in self.adapter.outputs.items()]
        return InferResponse(payload.id or "", self.name, outputs)


options, adapters = arguments(__doc__)
print("serving", ", ".join(a.name for a in adapters), file=sys.stderr)
kserve.ModelServer(http_port=options.port, enable_grpc=False, workers=1).start([Served(a) for a in adapters])
