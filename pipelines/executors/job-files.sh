# What the scripts of the executor `slurm` share: who is alive, and the note of a job. Sourced.

# A job's note (.stamps/NAME.job) is what its node works from, and its lease: a node whose note is gone or is another's ends the tool.
# Fields end with NUL: token, who waits (host, process, its start), the job's name in Slurm, stage, seconds, folder, then counted lists:
# inputs as size and name, outputs, NAME=value of the environment; and the command.

# start_of PID: when the process started, in ticks since boot: with it a number names one process. Nothing where there is none.
start_of() {
  local stat
  { stat=$(<"/proc/$1/stat"); } 2>/dev/null || return 0
  stat=${stat##*) }
  read -ra stat <<<"$stat"
  # A process that has ended and waits for its parent is gone.
  [ "${stat[0]}" = Z ] || printf '%s' "${stat[19]}"
}

# lives PID START
lives() { [ -n "$2" ] && [ "$(start_of "$1")" = "$2" ]; }

# token_in NOTE: nothing where there is none.
token_in() {
  local token=
  { IFS= read -r -d '' token <"$1"; } 2>/dev/null || true
  printf '%s' "$token"
}

# no_slurm: its configuration was named and is gone, as after a test.
no_slurm() { [ -n "${SLURM_CONF:-}" ] && [ ! -e "$SLURM_CONF" ]; }

# cancel NAME: the job or step that is called so, for as long as that takes, beside what goes on here.
cancel() { setsid bash "${BASH_SOURCE[0]%/*}/slurm-cancel.sh" "$1" </dev/null >/dev/null 2>&1 & }

# nap SECONDS: without a process.
nap() { read -rt "$1" -u "$napping" || true; }
exec {napping}<> <(:)

# let_go_of_pipes: nobody shall wait for this process because it holds the end of a pipe. Bash reads its script from 255.
let_go_of_pipes() {
  local fd
  for fd in /proc/self/fd/*; do
    fd=${fd##*/}
    if [ "$fd" -gt 2 ] && [ "$fd" -ne 255 ] && [ "$fd" -ne "$napping" ]; then eval "exec $fd>&-"; fi
  done
}
