#!/usr/bin/env bash
# clang-tidy reports nothing on the project (.clang-tidy).  usage: tidy.sh BUILD
# A file that has not changed since it passed is not checked again. One version, as for the layout; exits with 77 if it is not installed.
set -eu
build=$1
root=$(cd "$(dirname "$0")/../.." && pwd)
command -v clang-tidy-19 >/dev/null || { echo "clang-tidy-19 is not installed: nothing is checked"; exit 77; }
mkdir -p "$build/tidy"
export root build

# preprocessed FILE: all that is compiled with it; nothing and an error where it is not
preprocessed() {
  python3 - "$build/compile_commands.json" "$1" <<'END'
import json
import shlex
import subprocess
import sys

its = next((c for c in json.load(open(sys.argv[1])) if c["file"] == sys.argv[2]), None) or sys.exit(1)
words = shlex.split(its["command"])
del words[words.index("-o"):words.index("-o") + 2]
sys.exit(subprocess.run([*(w for w in words if w != "-c"), "-E", "-P"], cwd=its["directory"]).returncode)
END
}

# check_file FILE [CHECKS]: what runs on a board with all checks, what runs on a host without two kinds. A program of the kernel is built
# for its own processor, by a command that compile_commands.json does not have.
check_file() {
  local code stamp target=()
  [[ $1 != *.bpf.c ]] || target=(-- --target=bpf -std=gnu11 -ffreestanding -I "$root/src" -idirafter "/usr/include/$(uname -m)-linux-gnu")
  code=$(preprocessed "$1") || code=$RANDOM$RANDOM # checked each time
  stamp=$build/tidy/$(echo "$(cat "$root/.clang-tidy") ${2-} $code" | sha256sum | cut -d' ' -f1)
  [ ! -e "$stamp" ] || return 0
  clang-tidy-19 -p "$build" --quiet ${2:+"--checks=$2"} "$1" "${target[@]}" 2>/dev/null && touch "$stamp"
}
export -f preprocessed check_file

# All files are checked before the result is given: a finding in one half does not hide those in the other.
found=0
printf '%s\0' "$root"/src/{od,esc,slave,sii}/*.c "$root"/src/{profiles,devices,ports}/*/*.c |
  xargs -0 -P "$(nproc)" -I{} bash -c 'check_file "$1"' check_file {} || found=1
skipped='/src/bus/kernel/(kernel|answer[.]bpf)[.]c$' # neither is built without libbpf, nor are its headers there
! grep -q '"file": .*/bus/kernel/kernel[.]c"' "$build/compile_commands.json" || skipped='^$'
printf '%s\0' "$root"/src/{bus,bus/*,buses,check,csv,devfile,eni,esi,facts,reader,soes,yaml}/*.c "$root"/{programs/*,programs/*/*,examples/{controller,demo,eoe,master,motion,plc},tools/dev/bench}/*.c |
  grep -zvE "$skipped" |
  xargs -0 -P "$(nproc)" -I{} bash -c 'check_file "$1" "-clang-analyzer-*,-readability-non-const-parameter"' check_file {} || found=1
[ "$found" = 0 ] || exit 1
echo "clang-tidy has nothing to say"
