#!/bin/bash
# url-credentials.sh URL: "credential" where the URL's query has a parameter that looks like one, by its name or its value; nothing
# where it has none. lib/remote/address.h says the same to the tools; tests/data/addresses.txt holds both to it.
set -uf
LC_ALL=C
query=${1#*\?}
[ "$query" != "$1" ] || exit 0
# Percent signs stand for characters; a backslash for itself.
plain() {
  local text=${1//\\/\\\\} out=
  while [[ $text =~ ^([^%]*)%([0-9A-Fa-f]{2})(.*)$ ]]; do
    out+=${BASH_REMATCH[1]}\\x${BASH_REMATCH[2]}
    text=${BASH_REMATCH[3]}
  done
  printf '%b' "$out$text" | tr -d '\000'
}
is_key() { # TEXT: as long without a break, and as mixed, as only keys are
  local run
  while IFS= read -r run; do
    if [[ ${#run} -ge 20 && $run = *[A-Za-z]* && $run = *[0-9]* ]]; then return 0; fi
  done < <(tr -c 'A-Za-z0-9+/=_' '\n' <<<"$1")
  return 1
}
IFS='&;' read -r -d '' -a parameters < <(printf '%s\0' "$query")
for parameter in "${parameters[@]}"; do
  name=$(plain "${parameter%%=*}") value=
  [[ $parameter != *=* ]] || value=$(plain "${parameter#*=}")
  letters=$(tr -cd 'A-Za-z' <<<"$name" | tr 'A-Z' 'a-z')
  case $letters in
    *key* | *token* | *secret* | *passw* | *pwd* | *credential* | *signature* | *auth* | *bearer* | *jwt* | *session* | *cookie* | \
      sig | code | sas | pass | pin | otp) echo credential; exit ;;
  esac
  if is_key "$name" || is_key "$value"; then echo credential; exit; fi
done
