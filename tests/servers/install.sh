#!/bin/bash
# install.sh FOLDER [NAME...]: real model servers from PyPI, each in a virtual environment of its own below FOLDER, for `make
# test-servers`. One that is there in the version that is asked for stays. Triton's Python stub wants the system's Python 3.11.
set -euo pipefail
folder=$1
shift
declare -A packages=(
  [triton]="nvidia-pytriton==0.7.0"
  [mlserver]="mlserver==1.7.1"
  [kserve]="kserve==0.21.0"
  [llamacpp]="xllamacpp==2026.10.11549 gguf==0.19.0"
  [transformers]="torch==2.15.0 torchvision transformers==5.24.0 pillow scipy kserve==0.21.0"
)
python=/usr/bin/python3.11
[ -x $python ] || python=python3
[ $# -gt 0 ] || set -- "${!packages[@]}"
for name in "$@"; do
  place=$folder/$name
  if [ "$(cat "$place/installed" 2>/dev/null)" = "${packages[$name]}" ]; then continue; fi
  rm -rf "$place"
  start=$SECONDS
  $python -m venv "$place" 2>/dev/null || { echo "no virtual environments: apt-get install python3-venv" >&2; exit 1; }
  # shellcheck disable=SC2086
  "$place/bin/pip" install -q --no-cache-dir --disable-pip-version-check ${packages[$name]}
  echo "${packages[$name]}" >"$place/installed"
  echo "  $name: ${packages[$name]} ($((SECONDS - start)) s, $(du -sm "$place" | cut -f1) MB)"
done
