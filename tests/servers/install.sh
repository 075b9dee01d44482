#!/bin/bash
# install.sh FOLDER [NAME...]: real model servers from PyPI, each in a virtual environment of its own below FOLDER, for `make
# test-servers`. One that is there in the version that is asked for stays. Triton's Python stub wants the system's Python 3.11.
set -euo pipefail
here=$(cd -- "${BASH_SOURCE[0]%/*}" && pwd)
folder=$1
shift
declare -A packages=(
  [triton]="nvidia-pytriton==0.7.0"
  [mlserver]="mlserver==1.7.1"
  # Serves the adapters of public models as well: with what torch needs but CUDA.
  [kserve]="kserve==0.21.0 transformers==5.24.0 pillow filelock typing-extensions sympy networkx jinja2 fsspec setuptools"
  [llamacpp]="xllamacpp==2026.10.11549 gguf==0.19.0"
)
declare -A without_dependencies=([kserve]="torch==2.15.0 torchvision==0.29.2 nvidia-cuda-runtime==13.2.86")
python=/usr/bin/python3.11
[ -x $python ] || python=python3
[ $# -gt 0 ] || set -- "${!packages[@]}"

install() { # NAME
  local place=$folder/$1 start=$SECONDS all="${packages[$1]} ${without_dependencies[$1]:-}"
  if [ "$(cat "$place/installed" 2>/dev/null)" = "$all" ]; then return; fi
  rm -rf "$place"
  $python -m venv "$place" 2>/dev/null || { echo "no virtual environments: apt-get install python3-venv" >&2; return 1; }
  # What is compiled when it is first imported is the smaller part.
  local pip=("$place/bin/pip" install -q --no-cache-dir --no-compile --disable-pip-version-check)
  # shellcheck disable=SC2086
  "${pip[@]}" ${packages[$1]} || return
  if [ -n "${without_dependencies[$1]:-}" ]; then
    # shellcheck disable=SC2086
    "${pip[@]}" --no-deps ${without_dependencies[$1]} || return
    bash "$here/without_cuda.sh" "$place"/lib/python3*/site-packages || return
  fi
  echo "$all" >"$place/installed"
  echo "  $1: $all ($((SECONDS - start)) s, $(du -sm "$place" | cut -f1) MB)"
}

# Beside each other: what one downloads another unpacks.
installing=()
for name in "$@"; do
  install "$name" &
  installing+=($!)
done
status=0
for one in "${installing[@]}"; do wait "$one" || status=1; done
exit $status
