#!/bin/bash
# sweep.sh RUN: takes away what killed tools left in a run: files .NAME.PID.tmp, also with an ending behind, whose process is gone.
find "$1" -maxdepth 4 -type f -regex '.*/[.][^/]*[.][0-9]+[.]tmp[^/]*' -print0 2>/dev/null | while IFS= read -r -d '' file; do
  [[ ${file##*/} =~ \.([0-9]+)\.tmp[^/]*$ ]] && [ ! -d "/proc/${BASH_REMATCH[1]}" ] && rm -f -- "$file"
done
exit 0
