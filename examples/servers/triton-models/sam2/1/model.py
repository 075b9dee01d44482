import os
import sys

# Some builds of Triton's Python back end do not look at it themselves.
sys.path += [path for path in os.environ.get("PYTHONPATH", "").split(os.pathsep) if path]

from triton_model import TritonPythonModel  # noqa: E402, F401
