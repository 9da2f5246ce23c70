#!/usr/bin/env bash
# Completion in bash as readline calls it, in zsh on a terminal, and in fish: the line so far, and the words that are offered. A shell
# that is not installed is left out.
# usage: completion.sh ECTWIN
set -u
ectwin=$1
folder=$(cd "$(dirname "$0")/../.." && pwd)/packaging/completion
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/runtime" "$work/home" "$work/empty"
export XDG_RUNTIME_DIR=$work/runtime HOME=$work/home PATH="${ectwin%/*}:$PATH"
failed=0

cat >"$work/ask.bash" <<'EOS'
compopt() { :; } # works within a completion only
. "$1/ectwin.bash"
unset ECTWIN_SOCKET
while IFS='>' read -r line; do
  COMP_LINE=$line COMP_POINT=${#line} COMP_WORDS=() COMPREPLY=()
  # readline splits at blanks and at '=' and ':'
  read -r -a words <<<"$(sed 's/\([=:]\)/ \1 /g' <<<"$line")"
  [ "${line: -1}" != ' ' ] || words+=('')
  [ "${line: -1}" != '=' ] || words+=('')
  COMP_WORDS=("${words[@]}") COMP_CWORD=$((${#words[@]} - 1))
  _ectwin
  typed=${line##* }
  printf '%s\n' "${COMPREPLY[@]/#/${typed%"${COMP_WORDS[-1]}"}}" | sort | sed "1s/^/$line> /" | xargs
done
EOS

# A zsh on a terminal of its own, which writes the words that each Tab offers to a file.
cat >"$work/ask.zsh" <<'EOS'
unset ECTWIN_SOCKET
zmodload zsh/zpty
export OFFERED=$PWD/offered
zpty z "PS1= TERM=dumb zsh -f -i"
zpty -w z "fpath=(${(q)1} \$fpath); autoload -Uz compinit; compinit -D -u; unsetopt beep"
zpty -w z 'compadd() { local -a hits; builtin compadd -O hits "$@"; print -rl -- $hits >>$OFFERED; builtin compadd "$@" }'
zpty -w z 'finish() { BUFFER=; print done" "now }; zle -N finish; bindkey ^X finish; print ready" "now'
zpty -r -m z output '*ready now*'
while IFS='>' read -r line; do
  : >$OFFERED
  zpty -w -n z "$line"$'\t\x18' # no line ends: the terminal stays zle's
  zpty -r -m z output '*done now*'
  print -r -- "$line>" $(sort $OFFERED)
done
zpty -d z
EOS

cat >"$work/ask.fish" <<'EOS'
set -e ECTWIN_SOCKET
source $argv[1]/ectwin.fish
while read -l line
    set -l offered (complete -C $line | sort)
    echo "$line> $offered"
end
EOS

cat >"$work/want" <<'EOS'
ectwin wa> wait watch
ectwin with fz> fzm1
ectwin with fzm1,optonc> fzm1,optoncdt2300
ectwin doc pm> pmctendo-dd5
ectwin with --virt> --virtual-time
ectwin run --set> --set=
ectwin fault d> damage delay drop duplicate
ectwin get comment8> comment8
ectwin set comment8> comment8=
ectwin set bus>
ectwin get -s ben> bench
ectwin wait edit.expression8> edit.expression8
EOS
cd "$work/empty" || exit 1 # no file is offered
for shell in bash zsh fish; do
  command -v $shell >/dev/null || { echo "$shell is not installed: its completion is not tried"; continue; }
  options=(bash)
  [ $shell != zsh ] || options=(zsh -f)
  [ $shell != fish ] || options=(fish --no-config)
  sed 's/>.*//' "$work/want" | LC_ALL=C.UTF-8 timeout 50 "$ectwin" with --name bench fzm1 -- "${options[@]}" "$work/ask.$shell" "$folder" 2>"$work/log" |
    sed 's/ *$//' >"$work/got"
  diff "$work/want" "$work/got" || { cat "$work/log"; echo "FAILED in $shell"; failed=1; }
done
[ "$("$ectwin" complete get '' | wc -l)" = 0 ] || { echo "signals without a twin"; failed=1; }
exit $failed
