# What the files of a batch are, in BATCH: ROOT, name below it, bytes and time of the last change, tab-separated, a line each. Sourced.

# Of the runs that stdin names, NUL-terminated; not those that each call writes again.
files_of_runs() {
  find -files0-from - -maxdepth 5 -type f \
    ! -name log.txt ! -name batch.status ! \( -path '*/.stamps/*' \( -name '*.log' -o -name 'phase*.mk' -o -name 'settled*' -o -name begun -o -name now -o -name work -o -name '*.job*' \) \) \
    -printf '%H\t%P\t%s\t%T@\n'
}

# Of files and folders that lie elsewhere.
files_elsewhere() { find -L -files0-from - -maxdepth 5 -path "$(pwd -P)/*" -prune -o -type f -printf '%H\t%P\t%s\t%T@\n'; }
