#!/bin/bash
# without_cuda.sh SITE_PACKAGES: PyPI's torch wants 2.5 GB of CUDA libraries before it can be loaded. On a processor none of them is
# ever called but the runtime, of 2 MB: in the place of the others torch gets a library that only has their names, and ends who
# calls one.
set -euo pipefail
lib=$1/torch/lib
work=$(mktemp -d)
trap 'rm -rf -- "$work"' EXIT
# NAME@VERSION, and names without.
nm -D --undefined-only "$lib"/*.so | awk '{ print $NF }' | grep -E '@lib(cu|nv)|@NVSHMEM|^(cu|nccl|nvshmem)' | grep -v '@libcudart' | sort -u >"$work/wanted"
sed 's/@.*//; s/.*/void &(void) { __builtin_trap(); }/' "$work/wanted" | sort -u >"$work/absent.c"
sed -n 's/.*@//p' "$work/wanted" | sort -u | while read -r version; do
  echo "$version { global: $(sed -n "s/@$version\$/;/p" "$work/wanted" | tr '\n' ' ')};"
done >"$work/absent.map"
gcc -w -shared -fPIC -o "$lib/libabsent.so" "$work/absent.c" "-Wl,--version-script=$work/absent.map"
# Where torch looks last.
readelf -d "$lib"/*.so | grep -oE '\[lib(cu|nv|nccl)[A-Za-z_]*\.so\.[0-9]+\]' | tr -d '[]' | sort -u | grep -v '^libcudart\.' | while read -r name; do
  ln -sf libabsent.so "$lib/$name"
done
