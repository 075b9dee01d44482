"""The stand-ins from Triton with batching, which puts an axis in front of every tensor: serve_batching.py PORT"""

import sys

import numpy as np
from pytriton.model_config import ModelConfig, Tensor
from pytriton.triton import Triton, TritonConfig

from adapter import DTYPES
from stand_ins import Detector, Predictor, Segmenter

port = int(sys.argv[1])
addresses = {"http_address": "127.0.0.1", "grpc_address": "127.0.0.1", "metrics_address": "127.0.0.1"}
ports = {"http_port": port, "grpc_port": port + 1, "metrics_port": port + 2}


def not_empty(value):
    value = np.asarray(value)
    return value if value.size else np.zeros((1,) + value.shape[1:], value.dtype)


def answers_of(adapter):
    def answer(requests):
        return [{k: not_empty(v)[None] for k, v in adapter({k: v[0] for k, v in dict(r).items()}).items()} for r in requests]

    return answer


def tensors(declared):
    return [Tensor(name=name, dtype=DTYPES[kind], shape=tuple(shape)) for name, (kind, shape) in declared.items()]


with Triton(config=TritonConfig(**addresses, **ports)) as triton:
    for adapter in (Predictor(), Detector(), Segmenter()):
        triton.bind(adapter.name, answers_of(adapter), tensors(adapter.inputs), tensors(adapter.outputs), config=ModelConfig(batching=True))
    triton.serve()
