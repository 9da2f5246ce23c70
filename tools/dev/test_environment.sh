# The environment of the tests; to be sourced after tools/bootstrap.sh.

# python3 of a version manager is a script that starts the interpreter: 50 ms more for each of hundreds of starts.
PATH=$(dirname "$(python3 -c 'import sys; print(sys.executable)')"):$PATH

# A folder in memory for the temporary files of tests, where /dev/shm has room for them. It is removed at the end of the script.
#
# The tests make and remove some ten thousand files: ext4 passes by the inodes of the last minutes one by one for each new file.

memory_folder() {
  local folder
  [ -z "${TMPDIR:-}" ] && [ "$(stat -f -c %T /dev/shm 2>/dev/null)" = tmpfs ] || return 0
  [ $(($(stat -f -c '%a * %S' /dev/shm))) -ge 4000000000 ] || return 0
  folder=$(mktemp -d /dev/shm/ectwin.XXXXXX) || return 0
  # shellcheck disable=SC2064
  trap "rm -rf '$folder'" EXIT
  chmod 1777 "$folder" # tests with a second user
  if install -m 755 "$(type -P true)" "$folder/true" && "$folder/true"; then # a mount may forbid programs
    export TMPDIR=$folder
  fi 2>/dev/null
}
memory_folder
