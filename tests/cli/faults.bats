# Calls of the system that fail, a sample of what `make hardening-faults` walks through.
load common

@test "faults: a failed call of the system ends in the right bytes or in a clear error" {
  [ "${PM_SAN:-0}" = 0 ] || skip "the sanitizer wants to be loaded first"
  library=${PM_TEST_BIN:-$bin/../test}/failing_calls.so
  "$root/tests/faults/walk.py" "$bin" "$library" --sample 2 --kinds open,write,short,sync,rename,close,thread
  "$root/tests/faults/walk.py" "$bin" "$library" --sample 12 --kinds memory,map --tools pm-lift,pm-render
}

@test "faults: every write of a state fails in turn" {
  [ "${PM_SAN:-0}" = 0 ] || skip "the sanitizer wants to be loaded first"
  "$root/tests/faults/walk.py" "$bin" "${PM_TEST_BIN:-$bin/../test}/failing_calls.so" --kinds write,short,close --tools pm-lift
}
