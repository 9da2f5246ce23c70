#!/usr/bin/env bash
# --modbus: the address of a base unit's Modbus server, its replies, refusals and cost.
# usage: modbus.sh ECTWIN [CASE]
# Runs everything inside namespaces of its own; needs no root where user namespaces are allowed.
set -u
ectwin=$1
only=${2:-}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# shellcheck source=tests/support/check.sh
. "$(dirname "$0")/../support/check.sh"
on_failure() { echo "  alone: $0 $ectwin $case_name"; }

# ask.py HOST PORT: reads VLAPs, the upper half of input register 11; prints what came.
script=$work/ask.py
cat >"$script" <<'END'
import socket
import sys

try:
    with socket.create_connection((sys.argv[1], int(sys.argv[2])), 60) as connection:
        connection.sendall(bytes.fromhex("00 01 00 00 00 06 ff 04 00 0b 00 01"))
        answer = b""
        while len(answer) < 11 and (more := connection.recv(11 - len(answer))):
            answer += more
        print("VLAPs", answer[9])
except OSError as error:
    print(error.strerror)
END

# in_network SCRIPT: with loopback and 10.9.8.7; $ectwin and $work are there. start ARGUMENT...: runs a twin, $pid, until it is ready.
in_network() {
  ectwin=$ectwin work=$work script=$script XDG_RUNTIME_DIR=$work timeout 300 unshare -Urn bash -c '
    ip link set lo up && ip address add 10.9.8.7/32 dev lo || exit 9
    start() {
      : >"$work/ready"
      "$ectwin" run "$@" >"$work/ready" 2>"$work/err" & pid=$!
      for _ in $(seq 1200); do [ -s "$work/ready" ] && break; [ -e /proc/$pid ] || break; sleep 0.1; done
    }
    stop() { kill $pid; wait $pid; echo $?; }
    ask() { for _ in $(seq 1200); do answer=$(python3 "$script" "$@"); [ "$answer" = "VLAPs 0" ] || break; sleep 0.1; done; echo "$answer"; }
    '"$1"
}

# ECL-070: a base unit over Modbus TCP alone, without any EtherCAT
without_ethercat() {
  in_network 'start --modbus 1502 vr-bu-ect-map7; cat "$work/ready"; ask 127.0.0.1 1502; ask 10.9.8.7 1502
    "$ectwin" get bu.message; stop; start --modbus 1502 vr-bu-ect-map1; ask 127.0.0.1 1502; stop' >"$work/out"
  check "run: ready, at loopback only, the display, its end, the next one" '{"event":"ready","modbus":"127.0.0.1:1502","slaves":1}
VLAPs 3
Connection refused
bu.message=EC: No Data
0
VLAPs 3
0' "$(cat "$work/out")"
}

addresses() {
  in_network 'start --modbus 10.9.8.7:1502 vr-bu-ect-map3; cat "$work/ready"; ask 10.9.8.7 1502; ask 127.0.0.1 1502; stop
    start --modbus "[::1]:1503" vr-bu-ect-map3; cat "$work/ready"; ask ::1 1503; stop
    start --modbus 0 vr-bu-ect-map3; ask 127.0.0.1 "$(grep -o "[0-9]*\"," "$work/ready" | tr -d "\",")"; stop' >"$work/out"
  check "run: an address, one of IPv6, any port" '{"event":"ready","modbus":"10.9.8.7:1502","slaves":1}
VLAPs 3
Connection refused
0
{"event":"ready","modbus":"[::1]:1503","slaves":1}
VLAPs 3
0
VLAPs 3
0' "$(cat "$work/out")"
}

# refused STATUS PATTERN ARGUMENT...
refused() {
  local status=$1 pattern=$2
  shift 2
  timeout 300 unshare -Un "$ectwin" "$@" >/dev/null 2>"$work/err"
  check "'$*': status" "$status" $?
  grep -q -- "$pattern" "$work/err" || check "'$*': it says why" "$pattern" "$(cat "$work/err")"
}

refused_arguments() {
  refused 1 "this device has no Modbus interface; devices with one: vr-bu-ect-map1, " run --modbus 0.0.0.0:0 fzm1
  refused 1 "one address serves one device" run --modbus 0.0.0.0:0 vr-bu-ect-map7,vr-bu-ect-map7
  refused 1 "is no \[ADDRESS:\]PORT" run --modbus nonsense vr-bu-ect-map7
  refused 1 "is no \[ADDRESS:\]PORT" run --modbus localhost:1502 vr-bu-ect-map7
  refused 1 "no interface: name it with -i IFACE" run vr-bu-ect-map7
  refused 1 "no interface: name it with -i IFACE" run -o x --modbus 0.0.0.0:0 vr-bu-ect-map7
  refused 1 "a slave of your own" with --modbus 0.0.0.0:0 --external /bin/true -- true
  refused 2 "below 1024 needs CAP_NET_BIND_SERVICE" run --modbus 0.0.0.0:502 vr-bu-ect-map7
  in_network 'start --modbus 1502 vr-bu-ect-map7
    for at in 1502 192.0.2.1:1502; do timeout 300 "$ectwin" run --modbus $at vr-bu-ect-map7 2>&1; echo $?; done; stop' >"$work/out"
  check "run: the port is taken, the address is somebody else's" "\
ectwin run: --modbus: cannot listen at '1502': the port is in use: choose another port, or 0 for any free port
2
ectwin run: --modbus: cannot listen at '192.0.2.1:1502': this machine does not have the address; 'ip -br address' lists its addresses
2
0" "$(cat "$work/out")"
}

# Beside EtherCAT, in the network of CMD: any port is free there.
with_a_command() {
  # shellcheck disable=SC2016
  check "with: CMD reaches it" '{"event":"ready","iface":"ecat0","modbus":"127.0.0.1:502","slaves":1}
127.0.0.1:502
VLAPs 3' "$("$ectwin" with --modbus 502 vr-bu-ect-multiarm -- sh -c 'echo $ECTWIN_MODBUS; until python3 "$1" 127.0.0.1 502 | grep 3; do :; done' sh "$script" 2>&1)"
}

# Rights on the machine: no more than without --modbus.
rights() {
  in_network 'for option in "--modbus 1502" ""; do
      ip link add name tw0 type veth peer name tw1 && ip link set tw0 up && ip link set tw1 up
      start -i tw0 $option vr-bu-ect-map7
      [ -n "$option" ] && ask 127.0.0.1 1502 >/dev/null
      grep -E "^(CapEff|CapPrm|CapBnd|NoNewPrivs|Seccomp):" /proc/$pid/status | xargs
      stop >/dev/null; ip link delete tw0
    done' >"$work/out"
  check "rights: the same as without Modbus" 1 "$(sort -u "$work/out" | wc -l)"
  check "rights: no capabilities" "CapPrm: 0000000000000000 CapEff: 0000000000000000" "$(grep -o 'CapPrm: [0-9a-f]* CapEff: [0-9a-f]*' "$work/out" | sort -u)"
}

# Four idle connections. One clock tick of processor time in two seconds is 0.5 %.
idle_uses_no_processor_time() {
  in_network 'start --modbus 1502 vr-bu-ect-map7
    exec 3<>/dev/tcp/127.0.0.1/1502 4<>/dev/tcp/127.0.0.1/1502 5<>/dev/tcp/127.0.0.1/1502 6<>/dev/tcp/127.0.0.1/1502
    sleep 0.5
    a=$(cut -d" " -f14,15 /proc/$pid/stat); sleep 2; b=$(cut -d" " -f14,15 /proc/$pid/stat)
    set -- $a $b; echo $(($3 + $4 - $1 - $2)); stop >/dev/null' >"$work/out"
  check "idle: at most 1 % processor (2 ticks of 10 ms in 2 s)" yes "$([ "$(cat "$work/out")" -le 2 ] && echo yes)"
}

run_cases without_ethercat addresses refused_arguments with_a_command rights idle_uses_no_processor_time
