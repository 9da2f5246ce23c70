#!/usr/bin/env bash
# Wireshark as an independent judge: its dissector must find nothing malformed in what the slave answers (some requests are
# malformed on purpose).
# usage: wireshark.sh TEST_VECTORS      Exits with 77 (skipped) where tshark is not installed.
set -eu
command -v tshark >/dev/null || { echo "skipped: tshark is not installed"; exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$1" --pcap "$work/vectors.pcap" >"$work/log" 2>&1
frames=$(tshark -r "$work/vectors.pcap" -Y ecat_mailbox 2>/dev/null | wc -l)
[ "$frames" -gt 100 ] || { echo "only $frames frames with a mailbox"; exit 1; }
bad=$(tshark -r "$work/vectors.pcap" -Y '(_ws.malformed || _ws.expert.severity == error) && ecat.cmd == 4' 2>/dev/null)
[ -z "$bad" ] || { printf 'malformed:\n%s\n' "$bad"; exit 1; }
echo "$frames mailbox frames, no answer malformed"
