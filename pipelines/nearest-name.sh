#!/bin/bash
# nearest-name.sh NAME KNOWN...: the known name that NAME was most likely meant to be, by the fewest letters that are added,
# lost, changed or swapped with their neighbour; nothing where none is near. Upper and lower case are the same.
name=$1
shift
printf '%s\n' "$@" | NAME=$name awk '
  function smaller(a, b) { return a < b ? a : b }
  function distance(a, b,   i, j, cost) {
    for (i = 0; i <= length(a); ++i) d[i, 0] = i
    for (j = 0; j <= length(b); ++j) d[0, j] = j
    for (i = 1; i <= length(a); ++i) {
      for (j = 1; j <= length(b); ++j) {
        cost = substr(a, i, 1) != substr(b, j, 1)
        d[i, j] = smaller(smaller(d[i - 1, j], d[i, j - 1]) + 1, d[i - 1, j - 1] + cost)
        if (i > 1 && j > 1 && substr(a, i, 1) == substr(b, j - 1, 1) && substr(a, i - 1, 1) == substr(b, j, 1))
          d[i, j] = smaller(d[i, j], d[i - 2, j - 2] + cost)
      }
    }
    return d[length(a), length(b)]
  }
  BEGIN { name = toupper(substr(ENVIRON["NAME"], 1, 64)); best = int(smaller(3, (length(name) + 1) / 2)) + 1 }
  { far = distance(name, toupper($0)); if (far < best) { best = far; nearest = $0 } }
  END { if (nearest != "") print nearest }'
