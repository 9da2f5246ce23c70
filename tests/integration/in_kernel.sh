#!/usr/bin/env bash
# --in-kernel: replies in the kernel, the line without the rights, options that exclude it.  usage: in_kernel.sh ECTWIN BASE_UNIT FZM1
# Most of it needs root with CAP_BPF; without these the test is skipped with its reason (77).
set -u
ectwin=$1 base_unit=$2 fzm1=$3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export XDG_RUNTIME_DIR=$work
# shellcheck source=tests/support/check.sh
. "$(dirname "$0")/../support/check.sh"

refuses() { # TITLE CODE TEXT WORD...
  local title=$1 code=$2 text=$3
  shift 3
  timeout 60 "$@" >"$work/out" 2>"$work/err"
  check "$title: exit code" "$code" "$?"
  check "$title: one line" 1 "$(grep -c "^ectwin with: .*$text" "$work/err")"
}

refuses "with UDP" 1 "--in-kernel excludes --udp" "$ectwin" with --in-kernel --udp 0 fzm1 -- true
refuses "polling" 1 "--in-kernel excludes" "$ectwin" with --in-kernel --busy-poll fzm1 -- true
if unshare -Ur true 2>/dev/null; then
  refuses "without the rights, or the parts of the build" 2 "--in-kernel" unshare -Ur "$ectwin" with --in-kernel fzm1 -- true
fi
[ $failed = 0 ] || exit 1
if ! "$ectwin" with --in-kernel fzm1 -- true 2>"$work/err"; then
  echo "skipped: $(grep in-kernel "$work/err")"
  exit 77
fi

refuses "two interfaces" 2 "--in-kernel needs one interface" "$ectwin" with --in-kernel --iface a,b fzm1 -- true

counted() { # NAME: a counter of the last run
  sed -n "s/.*\"$1\":\([0-9]*\).*/\1/p" "$work/stats"
}

# shellcheck disable=SC2016
"$ectwin" with --in-kernel vr-bu-ect-map7 -- sh -c '"$1" "$2" VR-BU-ECT-Map7 66 228 && "$0" stats --json >"$3/stats" && "$0" stats >"$3/text"' \
  "$ectwin" "$base_unit" '{}' "$work" >"$work/out" 2>&1
check "SOEM reaches OP and exchanges process data" 0 "$?"
[ "$failed" = 0 ] || cat "$work/out"
check "most of its cycles get their replies in the kernel" yes "$([ "$(counted in_kernel)" -gt 500 ] && echo yes)"
check "each frame gets its reply" "$(counted frames)" "$(counted answered)"
check "at the generic hook" 1 "$(grep -c '"hook":"generic"' "$work/stats")"
check "the histogram of the kernel's replies has all of them" "$(counted in_kernel)" \
  "$(($(sed -n 's/.*"kernel_answers":\[\([0-9,]*\)\].*/\1/p' "$work/stats" | tr , +)))"
check "the way in words" 1 "$(grep -c '^in the kernel, generic XDP: plans for [0-9]' "$work/text")"
check "both histograms" 2 "$(grep -c '^answers .*:$' "$work/text")"

for title in '*FZM-067*' '*FZM-071: DSA*' '*FZM-075*'; do
  "$ectwin" with --in-kernel fzm1 -- "$fzm1" '{}' "$title" >"$work/out" 2>&1
  check "a PLC's handshakes while the kernel replies: $title" 0 "$?"
  [ "$failed" = 0 ] || cat "$work/out"
done

# shellcheck disable=SC2016
"$ectwin" with --in-kernel --pcap "$work/a.pcapng" vr-bu-ect-map7 -- sh -c '"$1" "$2" VR-BU-ECT-Map7 66 228 "ECL-001*"; "$0" stats --json >"$3/stats"' \
  "$ectwin" "$base_unit" '{}' "$work" >"$work/out" 2>&1
check "with a capture all replies come from the process" 0 "$(counted in_kernel)"
exit $failed
