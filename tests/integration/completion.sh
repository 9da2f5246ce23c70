#!/usr/bin/env bash
# Completion in bash, as readline calls it: what is on the line so far, and the words that are offered.
# usage: completion.sh ECTWIN
set -u
ectwin=$1
folder=$(cd "$(dirname "$0")/../.." && pwd)/packaging/completion
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/runtime"
export XDG_RUNTIME_DIR=$work/runtime
failed=0

cat >"$work/ask.sh" <<'EOF'
compopt() { :; } # works within a completion only
. "$1/ectwin.bash"
ectwin() { "$ECTWIN" "$@"; }
unset ECTWIN_SOCKET
while IFS='>' read -r line; do
  COMP_LINE=$line COMP_POINT=${#line} COMP_WORDS=() COMPREPLY=()
  # readline splits at blanks and at '=' and ':'
  read -r -a words <<<"$(sed 's/\([=:]\)/ \1 /g' <<<"$line")"
  [ "${line: -1}" != ' ' ] || words+=('')
  [ "${line: -1}" != '=' ] || words+=('')
  COMP_WORDS=("${words[@]}") COMP_CWORD=$((${#words[@]} - 1))
  COMP_WORDS[0]=$ECTWIN
  _ectwin
  echo "$line> ${COMPREPLY[*]-}"
done
EOF

cat >"$work/want" <<'EOF'
ectwin wa> watch wait
ectwin with fz> fzm1
ectwin with fzm1,optonc> fzm1,optoncdt2300
ectwin doc pm> pmctendo-dd5
ectwin with --virt> --virtual-time
ectwin run --set> --set=
ectwin fault d> drop damage delay duplicate
ectwin get comment8> comment8
ectwin set comment8> comment8=
ectwin set bus>
ectwin get -s ben> bench
ectwin wait edit.expression8> edit.expression8
EOF
sed 's/>.*//' "$work/want" | ECTWIN=$ectwin "$ectwin" with --name bench fzm1 -- bash "$work/ask.sh" "$folder" 2>/dev/null |
  tr '\n' '@' | sed 's/ @/@/g' | tr '@' '\n' >"$work/got"
diff "$work/want" "$work/got" || failed=1
[ "$("$ectwin" complete get '' | wc -l)" = 0 ] || { echo "signals without a twin"; failed=1; }
exit $failed
