# wait_for PID: waits for a child, however often a signal that has a trap ends the waiting; `status` is the child's. Sourced.
wait_for() {
  while true; do
    wait "$1"
    status=$?
    if ! kill -0 "$1" 2>/dev/null; then break; fi
  done
}
