"""An adapter as a model of Triton's Python back end, for a model repository: triton-models/NAME/1/model.py imports it.

config.pbtxt says which adapter (parameter "adapter", MODULE:CLASS) and, if not its own, which weights (parameter "weights"). This folder
has to be on PYTHONPATH of tritonserver.
"""

import json

import numpy as np
import triton_python_backend_utils as triton

from adapter import load


class TritonPythonModel:
    def initialize(self, args):
        parameters = json.loads(args["model_config"])["parameters"]
        said = {key: value["string_value"] for key, value in parameters.items()}
        name = args["model_name"]
        (self.adapter,) = load([said["adapter"]], {name: said["weights"]} if said.get("weights") else {})

    def execute(self, requests):
        return [self.answer(request) for request in requests]

    def answer(self, request):
        try:
            found = self.adapter({name: triton.get_input_tensor_by_name(request, name).as_numpy() for name in self.adapter.inputs})
        except Exception as error:  # the client is told, and the model goes on
            return triton.InferenceResponse(error=triton.TritonError("%s: %s" % (type(error).__name__, error)))
        outputs = []
        for name, (kind, _) in self.adapter.outputs.items():
            value = np.asarray(found[name])
            outputs.append(triton.Tensor(name, value.astype(np.object_) if kind == "BYTES" else value))
        return triton.InferenceResponse(outputs)
