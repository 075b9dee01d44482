#!/usr/bin/env bats
# Servers of https that are not who they should be, or speak something else: no word of ours reaches them, least of all the key.
load stages

setup() {
  make_scene
  "$make_fixture" views scene.json
  export PM_API_KEY=pmkey-0123456789
  unset http_proxy HTTP_PROXY https_proxy HTTPS_PROXY all_proxy ALL_PROXY
}

teardown() { stop_tls; }

certificate() { # NAME OPTION...: NAME.pem and NAME.key, signed by itself
  local name=$1
  shift
  openssl req -x509 -newkey rsa:2048 -nodes -keyout "$name.key" -out "$name.pem" -subj /CN=localhost "$@" 2>/dev/null
}

serve_tls() { # MODE [CERTIFICATE]
  rm -f port told hold
  mkfifo hold
  python3 "$root/tests/tools/tls_server.py" port told "$1" ${2:+"$2.pem" "$2.key"} <hold 3>&- &
  server=$!
  exec 9>hold
  for _ in $(seq 200); do
    [ -s port ] && break
    sleep 0.02
  done
  url=https://127.0.0.1:$(cat port)
}

stop_tls() {
  exec 9>&- || true
  if [ -n "${server:-}" ]; then wait "$server" || true; fi
  server=
}

ask() { material --agent "$url" --model tester --timeout 1 --budget 3 --retries 1 --backoff 0.05 "$@"; }

# Exit code 4 with one line; the server has read neither the key nor a request.
says_nothing_to_it() { # TEXT...
  fails_with 4 ask -- "$@"
  [ ! -e evidence.json ]
  stop_tls
  [ -s told ]
  refute grep -aE "$PM_API_KEY|POST|chat/completions" told
}

@test "tls: a certificate that nobody vouches for" {
  certificate own -addext subjectAltName=IP:127.0.0.1
  serve_tls certified own
  # Who trusts it is served: the test's server works.
  python3 -c 'import ssl, sys, urllib.request
urllib.request.urlopen(sys.argv[1], context=ssl.create_default_context(cafile="own.pem")).read()' "$url/POST"
  grep -aq POST told
  serve_tls certified own
  says_nothing_to_it certificate
}

@test "tls: bytes that are no handshake, plain http, a handshake that is cut, and none" {
  for mode in garbage plain cut shut; do
    serve_tls $mode
    says_nothing_to_it "$url" || { echo "$mode"; return 1; }
  done
}

@test "tls: a server that never answers the handshake is given up in time" {
  serve_tls silent
  SECONDS=0
  says_nothing_to_it "$url"
  [ "$SECONDS" -lt 20 ]
}
