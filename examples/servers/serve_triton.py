"""Serves adapters from Triton, through nvidia-pytriton: pip install nvidia-pytriton

    python serve_triton.py models:GroundingDino models:Sam2 --port 8001
"""

import sys

import numpy as np
from pytriton.model_config import ModelConfig, Tensor
from pytriton.triton import Triton, TritonConfig

from adapter import DTYPES, arguments


def tensors(declared):
    return [Tensor(name=name, dtype=DTYPES[kind], shape=tuple(shape)) for name, (kind, shape) in declared.items()]


def not_empty(value):
    """pytriton carries no tensor without elements: one entry of zeros instead, which with a score of 0 is none."""
    value = np.asarray(value)
    return value if value.size else np.zeros((1,) + value.shape[1:], value.dtype)


def answers_of(adapter):
    def answer(requests):
        return [{k: not_empty(v) for k, v in adapter(dict(request)).items()} for request in requests]

    return answer


options, adapters = arguments(__doc__)
config = TritonConfig(
    http_address="127.0.0.1",
    http_port=options.port,
    grpc_address="127.0.0.1",
    grpc_port=options.port + 1,
    metrics_address="127.0.0.1",
    metrics_port=options.port + 2,
)
with Triton(config=config) as triton:
    for adapter in adapters:
        # Without batching, tensors have the shapes that the adapter says; with it, they would have an axis more in front.
        triton.bind(adapter.name, answers_of(adapter), tensors(adapter.inputs), tensors(adapter.outputs), config=ModelConfig(batching=False))
    print("serving", ", ".join(a.name for a in adapters), file=sys.stderr)
    triton.serve()
