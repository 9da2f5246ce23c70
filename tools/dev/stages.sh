# Stages of a script, each with its name and its time. Source this file.
#
#   stage NAME COMMAND...   runs COMMAND with its output in build/logs/NAME.log; prints the log when COMMAND fails, and ends the script
#   shown NAME COMMAND...   likewise, with the output on the terminal
#
# Status 77 is "skipped": the last line of the output is the reason. A line every 20 s indicates a running stage.

export CTEST_OUTPUT_ON_FAILURE=1
jobs=$(nproc)
mkdir -p build/logs

alive() { # NAME
  local seconds=0
  while sleep 20; do
    seconds=$((seconds + 20))
    echo "  $1: $seconds s ..."
  done
}

ended() { # NAME STATUS SECONDS LOG
  case $2 in
    0) echo "$1: passed, $3 s" ;;
    77) echo "$1: skipped, $3 s: $(tail -n 1 "$4" 2>/dev/null)" ;;
    *)
      [ ! -s "$4" ] || tail -n 60 "$4"
      echo "$1: FAILED, $3 s (status $2)"
      exit 1
      ;;
  esac
}

run_stage() { # LOG NAME COMMAND...
  local log=$1 name=$2 status=0 before=$SECONDS watch
  shift 2
  echo "$name"
  alive "$name" &
  watch=$!
  if [ "$log" = /dev/stdout ]; then
    "$@" || status=$?
  else
    "$@" >"$log" 2>&1 || status=$?
  fi
  kill $watch 2>/dev/null
  wait $watch 2>/dev/null || true
  ended "$name" $status $((SECONDS - before)) "$log"
}

stage() { run_stage "build/logs/${1//[^a-z0-9_]/-}.log" "$@"; }
shown() { run_stage /dev/stdout "$@"; }

preset() { # NAME: configures and builds
  cmake --preset "$1" && cmake --build --preset "$1"
}
