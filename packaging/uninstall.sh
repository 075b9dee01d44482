#!/bin/bash
# Takes away what `make install` put below ROOT: the files that its manifest lists, then the folders of PhysMAS that are empty.
#   uninstall.sh ROOT
set -eu
manifest=share/physmas/manifest
[ -e "$1/$manifest" ] || { echo "$1/$manifest is not there: nothing is installed below $1" >&2; exit 1; }
cd -- "$1"
mapfile -t files <$manifest
rm -f -- "${files[@]}"
printf '%s\n' "${files[@]%/*}" | grep -E '^share/(doc/)?physmas' | sort -ru | while read -r folder; do
  [ ! -d "$folder" ] || rmdir --ignore-fail-on-non-empty -- "$folder"
done
