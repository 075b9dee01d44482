"""Serves adapters from MLServer: pip install mlserver

    python serve_mlserver.py models:GroundingDino models:Sam2 --port 8001

It writes what MLServer reads (a settings.json, and a model-settings.json per model) into a folder, by default mlserver-models, and
starts it there.
"""

import json
import os
import sys

import numpy as np
from mlserver import MLModel
from mlserver.codecs import NumpyCodec, StringCodec
from mlserver.types import InferenceResponse, MetadataTensor

from adapter import arguments, load


class Served(MLModel):
    async def load(self):
        extra = self.settings.parameters.extra
        (self.adapter,) = load([extra["adapter"]], extra["weights"])
        return True

    async def predict(self, payload):
        tensors = {t.name: np.asarray(self.decode(t)) for t in payload.inputs}
        found = self.adapter(tensors)
        outputs = []
        for name, (kind, _) in self.adapter.outputs.items():
            value = found[name]
            if kind == "BYTES":
                outputs.append(StringCodec.encode_output(name, [v.decode() for v in value]))
            else:
                outputs.append(NumpyCodec.encode_output(name, np.asarray(value)))
        return InferenceResponse(model_name=self.name, outputs=outputs)


def main():
    options, adapters = arguments(__doc__)
    weights = dict(w.split("=", 1) for w in options.weights)
    folder = os.path.abspath(os.environ.get("MLSERVER_MODELS", "mlserver-models"))
    os.makedirs(folder, exist_ok=True)
    settings = {"host": "127.0.0.1", "http_port": options.port, "grpc_port": options.port + 1, "metrics_port": options.port + 2, "parallel_workers": 0}
    with open(os.path.join(folder, "settings.json"), "w") as f:
        json.dump(settings, f)
    for name, adapter in zip(options.adapters, adapters):

        def declared(tensors, pictures):
            for key, (kind, shape) in tensors.items():
                content = {"content_type": "base64" if key in pictures else "str"} if kind == "BYTES" else {}
                yield MetadataTensor(name=key, datatype=kind, shape=shape, parameters=content or None).model_dump(exclude_none=True)

        model = {
            "name": adapter.name,
            "implementation": "serve_mlserver.Served",
            "inputs": list(declared(adapter.inputs, ("image", "crops", "frames"))),
            "outputs": list(declared(adapter.outputs, ())),
            "parameters": {"extra": {"adapter": name, "weights": weights}},
        }
        os.makedirs(os.path.join(folder, adapter.name), exist_ok=True)
        with open(os.path.join(folder, adapter.name, "model-settings.json"), "w") as f:
            json.dump(model, f, indent=2)
    here = os.path.dirname(os.path.abspath(__file__))
    os.environ["PYTHONPATH"] = os.pathsep.join([here, os.getcwd(), os.environ.get("PYTHONPATH", "")])
    os.execv(sys.executable, [sys.executable, "-m", "mlserver.cli.main", "start", folder])


if __name__ == "__main__":
    main()
