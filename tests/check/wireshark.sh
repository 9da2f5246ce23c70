#!/usr/bin/env bash
# Wireshark as an independent judge of tests/vectors: its dissector must report nothing on frames of both directions, detect
# EtherCAT in each, and find all fifteen commands; it must report frames that are broken on purpose, and nothing malformed in the
# slave's replies to mails (some requests are malformed on purpose).
# usage: wireshark.sh TEST_VECTORS      Exits with 77 (skipped) where tshark is not installed.
set -eu
command -v tshark >/dev/null || { echo "skipped: tshark is not installed"; exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# record NAME FILTER: the frames of some vectors.  look NAME TSHARK-ARGUMENT...: Wireshark's report on them
record() { "$vectors" --pcap "$work/$1.pcap" "$2" >"$work/log" 2>&1 || { cat "$work/log"; exit 1; }; }
look() { tshark -r "$work/$1.pcap" "${@:2}" 2>/dev/null; }
vectors=$1

record frames 'frames:*'
frames=$(look frames | wc -l)
[ "$frames" -gt 200 ] || { echo "only $frames frames"; exit 1; }
bad=$(look frames -Y '_ws.malformed || _ws.expert || not ecat')
[ -z "$bad" ] || { printf 'frames that Wireshark does not like:\n%s\n' "$bad"; exit 1; }
commands=$(look frames -T fields -e ecat.cmd | tr ',' '\n' | sort -u | grep -c '0x0[0-9a-e]')
[ "$commands" -eq 15 ] || { echo "only $commands of 15 commands are there"; exit 1; }

record broken 'frames_bad:*'
found=$(look broken -Y '_ws.malformed || _ws.expert || not ecat' | wc -l)
[ "$found" -ge 12 ] || { echo "Wireshark finds only $found frames broken: does it look?"; exit 1; }

record mails '*'
mails=$(look mails -Y ecat_mailbox | wc -l)
[ "$mails" -gt 100 ] || { echo "only $mails frames with a mailbox"; exit 1; }
bad=$(look mails -Y '(_ws.malformed || _ws.expert.severity == error) && ecat.cmd == 4')
[ -z "$bad" ] || { printf 'malformed:\n%s\n' "$bad"; exit 1; }
echo "$frames frames and $mails mails: nothing to say; $found broken ones noticed"
