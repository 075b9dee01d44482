"""tritonserver itself, as pytriton's wheel carries it, on a model repository: serve_repository.py PORT REPOSITORY"""

import glob
import os
import shutil
import sys

import pytriton

port, repository = int(sys.argv[1]), sys.argv[2]
wheel = os.path.join(os.path.dirname(pytriton.__file__), "tritonserver")
site = os.path.dirname(os.path.dirname(pytriton.__file__))
# The back end wants the stub of this Python beside it.
shutil.copytree(os.path.join(wheel, "backends"), "backends")
stub = "python_backend_stubs/%d.%d/triton_python_backend_stub" % sys.version_info[:2]
shutil.copy(os.path.join(wheel, stub), "backends/python")
os.environ["LD_LIBRARY_PATH"] = os.path.join(site, "nvidia_pytriton.libs")
# The stub takes no word of the environment, and writes byte code beside what it reads.
os.mkdir("modules")
for folder in os.environ["PYTHONPATH"].split(os.pathsep):
    for module in glob.glob(os.path.join(folder, "*.py")):
        shutil.copy(module, "modules")
os.environ["PYTHONPATH"] = os.pathsep.join([os.path.abspath("modules"), site])
server = os.path.join(wheel, "bin", "tritonserver")
os.execv(
    server,
    [server, "--model-repository=" + repository, "--backend-directory=backends", "--http-address=127.0.0.1", "--allow-grpc=false", "--allow-metrics=false", "--http-port=%d" % port],
)
