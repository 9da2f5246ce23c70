#!/usr/bin/env bash
# Clients of a running twin: get, set, watch, list-signals, files, the Python module; and the sockets that they refuse.
# usage: control.sh ECTWIN [CASE]       Needs no root; cases with a second user are left out without root, with a line.
set -u
ectwin=$1
only=${2:-}
here=$(cd "$(dirname "$0")" && pwd)

# shellcheck source=tests/support/check.sh
. "$(dirname "$0")/../support/check.sh"
on_failure() { echo "  alone: $0 $ectwin $case_name"; }

has() { # TITLE PART FILE
  check "$1" "$2" "$(grep -qF -- "$2" "$3" && echo "$2" || cat "$3")"
}

# Runs a script with an FZM1 beside it; what it prints is in $work/out, what goes wrong in $work/err.
beside_an_fzm1() {
  "$ectwin" with fzm1 -- sh -c "$1" >"$work/out" 2>"$work/err"
}

set_is_atomic() {
  beside_an_fzm1 "'$ectwin' set output_period=40 output_time=30 && '$ectwin' set output_time=300 output_period=400
    '$ectwin' set data1=7 output_time=401; echo \$?; '$ectwin' set data1=7 nosuch=1; echo \$?; '$ectwin' get data1
    '$ectwin' get 'output_[pt]*'; '$ectwin' set scene=010; '$ectwin' get scene"
  check "set: all or nothing, in any order; decimal" "1 1 data1=0 output_period=400 output_time=300 scene=10" \
    "$(xargs <"$work/out")"
}

tables() {
  printf '\xef\xbb\xbf"row1";row_add\r\n 1,5 ;1\r\n' >"$work/comma.csv"
  printf 'comment1;comment2\n"a; ""b""";  two words  \n\n' >"$work/semicolons.csv"
  beside_an_fzm1 "'$ectwin' set --csv '$work/comma.csv'; echo \$?; '$ectwin' set --csv '$work/semicolons.csv'; echo \$?
    '$ectwin' get 'comment[12]'; printf 'data1\tdata2\n1\t2\n' | '$ectwin' set --csv -; '$ectwin' get 'data[12]'"
  check "set: --csv with semicolons, quotes, tabs, from standard input" \
    '1|0|comment1=a; "b"|comment2=two words|data1=1|data2=2|' "$(tr '\n' '|' <"$work/out")"
  has "set: --csv names the line that is refused" "line 2 of" "$work/err"
}

# No value is truncated: a row is set as a whole, or refused and not set at all.
tables_that_are_refused() {
  { printf 'data1'; printf ',ru%d' $(seq 200); echo; } >"$work/columns.csv"
  { printf 'data1\n1'; head -c 20000 /dev/zero | tr '\0' '0'; echo; } >"$work/long.csv"
  printf 'data1,data2\n1,2\n3,4,5\n' >"$work/more.csv"
  printf 'data1\n1\0002\n' >"$work/zero.csv"
  printf 'comment1\n"open\n' >"$work/quote.csv"
  printf 'comment1\n"a"b\n' >"$work/behind.csv"
  printf 'data1,busy\n9,1\n' >"$work/row.csv"
  while read -r file want; do
    beside_an_fzm1 "'$ectwin' set --csv '$file'; echo \$?; '$ectwin' get data1"
    check "set: --csv $file is refused" "1 data1=${want%% *}" "$(xargs <"$work/out")"
    has "set: --csv $file, and why" "${want#* }" "$work/err"
  done <<EOF
$work/columns.csv 0 more than 128 cells
$work/long.csv 0 longer than 16383
$work/more.csv 1 line 3
$work/zero.csv 0 zero byte
$work/quote.csv 0 not closed
$work/behind.csv 0 follows a closing quote
$work/row.csv 0 the twin's own
/dev/zero 0 zero byte
EOF
}

signals_of_a_device() {
  "$ectwin" list-signals fzm1 >"$work/offline"
  beside_an_fzm1 "'$ectwin' list-signals"
  check "list-signals DEVICE: the same as of a running one" same \
    "$(cmp -s "$work/out" "$work/offline" && echo same || diff "$work/out" "$work/offline")"
  check "list-signals DEVICE PATTERN" "ru1.id ru8.id" "$("$ectwin" list-signals vr-bu-ect-map7 'ru[18].id' | awk '{print $1}' | xargs)"
  "$ectwin" list-signals fzm1 'nosuch*' 2>"$work/err"
  check "list-signals: nothing matches" 1 $?
  has "list-signals: it says so" "no signal of fzm1 matches 'nosuch*'" "$work/err"
}

numbers_are_numbers() {
  beside_an_fzm1 "timeout 300 '$ectwin' watch 'data1' | head -1; timeout 300 '$ectwin' watch comment1 | head -1"
  check "watch: a number, and a text" 'int str' \
    "$(python3 -c 'import json, sys; print(*(type(json.loads(l)["value"]).__name__ for l in sys.stdin))' <"$work/out")"
}

# A reader that ends, ends the watch: at once, though no signal changes.
watch_ends_with_its_reader() {
  # shellcheck disable=SC2016
  "$ectwin" with fzm1 -- bash -c 'timeout 300 "$1" watch data1 | head -1; echo "${PIPESTATUS[0]}"' bash "$ectwin" >"$work/out" 2>"$work/err"
  check "watch: 'head -1' ends it, without a word" '0 {"event":"ready","iface":"ecat0","slaves":1}' \
    "$(tail -1 "$work/out") $(cat "$work/err")"
}

# A folder in which a name has brackets, and one whose sockets have longer paths than an address of a socket.
odd_and_long_folders() {
  local long="$work/a [b] c/$(printf 'x%.0s' $(seq 120))"
  mkdir -p "$long"
  check "get: a long path with brackets" "data1=0" "$(XDG_RUNTIME_DIR=$long "$ectwin" with fzm1 -- \
    sh -c "unset ECTWIN_SOCKET; '$ectwin' get data1" 2>/dev/null)"
  check "get: the name of the socket goes with the twin" "" "$(ls "$long/ectwin")"
}

no_twin() {
  mkdir "$work/empty"
  XDG_RUNTIME_DIR=$work/empty "$ectwin" get 2>"$work/err"
  check "get: no twin" 2 $?
  has "get: it says how to start one" "no twin of yours is running: start one with" "$work/err"
}

# The twin may be stopped, for good or for a while; a backlog may be full.
a_stopped_twin() {
  rm -f "$work/asks"
  # shellcheck disable=SC2016
  "$ectwin" with fzm1 -- sh -c 'until [ -e "$2" ]; do sleep 0.05; done
    "$1" get data1; echo $?; rm "$2"; while [ ! -e "$2" ]; do sleep 0.05; done; "$1" get data1' sh "$ectwin" "$work/asks" \
    >"$work/out" 2>"$work/err" &
  local twin=$!
  for _ in $(seq 1200); do grep -q ready "$work/err" && break; sleep 0.1; done
  kill -STOP $twin
  touch "$work/asks"
  while [ -e "$work/asks" ]; do sleep 0.1; done
  kill -CONT $twin
  touch "$work/asks"
  wait $twin
  check "get: a stopped twin is not waited for, and answers when it goes on" "3 data1=0" "$(xargs <"$work/out")"
  has "get: it says so" "the twin does not answer" "$work/err"
}

# A socket of another program, whose replies must not control the terminal.
escapes() {
  cat >"$work/hostile.py" <<'EOF'
import json, socket, sys
server = socket.socket(socket.AF_UNIX)
server.bind(sys.argv[1])
server.listen()
print("ready", flush=True)
for _ in range(3):
    client, _ = server.accept()
    request = json.loads(client.makefile().readline())
    line = {"slave": 1, "name": "\x1b]0;owned\x07", "value": "\x9b31m\x7f", "time": 1}
    client.sendall(json.dumps(line).encode() + b"\n")
    if request["op"] == "watch":
        client.sendall(b'{"ok":true}\n{"\x1b[31m":1}\n')
    else:
        client.sendall(json.dumps({"ok": False, "message": "\x1b[2Jno"}).encode() + b"\n")
    client.close()
EOF
  python3 "$work/hostile.py" "$work/hostile.sock" >"$work/ready" &
  local server=$!
  for _ in $(seq 1200); do [ -s "$work/ready" ] && break; sleep 0.1; done
  for command in get list-signals watch; do
    "$ectwin" $command -s "$work/hostile.sock" >>"$work/said" 2>&1
  done
  wait $server
  check "text from a twin is printed without control characters" "" "$(LC_ALL=C grep -n "[^ -~]" "$work/said" | cat -v)"
  has "and can still be read" '\x1b]0;owned\x07' "$work/said"
}

# Somebody has made the folder of a user's sockets before the user did, or serves a socket in it.
squatters() {
  if [ "$(id -u)" != 0 ] || ! setpriv --reuid 65534 --clear-groups /usr/bin/python3 -c '' 2>/dev/null; then
    echo "squatters: left out, it needs root to play a second user, and python3 for that one"
    return
  fi
  mkdir -p "$work/squatted/ectwin" && chown 65534 "$work/squatted/ectwin" && chmod 755 "$work" "$work/squatted"
  XDG_RUNTIME_DIR=$work/squatted "$ectwin" get 2>"$work/err"
  check "get: a folder of another user" 2 $?
  has "get: it is not trusted" "belongs to another user" "$work/err"
  XDG_RUNTIME_DIR=$work/squatted "$ectwin" with fzm1 -- true 2>"$work/err"
  has "with: no socket in a folder of another user" "not a folder of your own" "$work/err"
  XDG_RUNTIME_DIR=$work/squatted python3 -c "
import sys; sys.path.insert(0, '$here/../../python')
import ectwin
try: ectwin.connect()
except ectwin.Error as e: print(e)" >"$work/out" 2>&1
  has "python: nor by the module" "belongs to another user" "$work/out"
  mkdir -m 777 "$work/open"
  setpriv --reuid 65534 --clear-groups /usr/bin/python3 -c "
import os, socket, time
s = socket.socket(socket.AF_UNIX); s.bind('$work/open/9.sock'); s.listen(); os.chmod('$work/open/9.sock', 0o777)
print('ready', flush=True); time.sleep(20)" >"$work/ready2" &
  local server=$!
  for _ in $(seq 1200); do [ -s "$work/ready2" ] && break; sleep 0.1; done
  cp "$ectwin" "$work/open/ectwin"
  setpriv --reuid 65533 --clear-groups "$work/open/ectwin" get -s "$work/open/9.sock" 2>"$work/err"
  check "get: a socket that a third user serves" 2 $?
  has "get: it is not trusted either" "not by you: not trusted" "$work/err"
  kill $server
  wait $server 2>/dev/null
  unset XDG_RUNTIME_DIR
  mkdir -m 700 /tmp/ectwin-64999 && chown 64999 /tmp/ectwin-64999
  setpriv --reuid 64998 --clear-groups "$work/open/ectwin" get 2>"$work/err"
  check "get: no twin of one's own" 2 $?
  rmdir /tmp/ectwin-64999
  export XDG_RUNTIME_DIR=$work/runtime
  has "get: the line names the user with twins" "user 64999 may have some, in /tmp/ectwin-64999: run the command as that user, or with sudo" \
    "$work/err"
}

# Two twins of one user, and one of another.
several_twins() {
  # shellcheck disable=SC2016
  "$ectwin" with --name first --set data1=1 fzm1 -- "$ectwin" with --iface tw5 --name second --set data1=2 fzm1,fzm1 -- sh -c '
    unset ECTWIN_SOCKET
    "$1" ps --json | sort; "$1" ps | sed -n 1p; "$1" get -s first data1; "$1" get -i tw5 data1
    "$1" get data1; "$1" get -s third; "$1" get -i tw9; "$1" with --name first fzm1 -- true; echo $?
    ' sh "$ectwin" >"$work/out" 2>"$work/err"
  check "ps, -s, -i: of several twins" 'first fzm1 ecat0 1 INIT|second fzm1,fzm1 tw5 2 INIT|PID NAME|data1=1|data1=2|2|' \
    "$(sed -E 's/.*"name":"([^"]*)","devices":"([^"]*)","iface":"([^"]*)","slaves":([0-9]+),.*"state":"([^"]*)".*/\1 \2 \3 \4 \5/; s/(PID) +(NAME) .*/\1 \2/' \
      "$work/out" | tr '\n' '|')"
  has "get: which one of several" "several twins are running: 'ectwin ps' lists them; choose one with -s" "$work/err"
  has "get: no such name" "no twin of yours has the name or the process id 'third'" "$work/err"
  has "get: no such interface" "no twin of yours answers on 'tw9'" "$work/err"
  has "with: a name that is in use" "a twin of yours with the name 'first' is running: end it, or choose another" "$work/err"
  check "with, ps: no socket stays" "" "$(ls -A "$work/runtime/ectwin")"
  "$ectwin" with --name 1st fzm1 -- true 2>"$work/err"
  check "with: a name begins with a letter" 1 $?
}

# Another user's twin is neither listed nor reached by its name.
twins_of_another_user() {
  if [ "$(id -u)" != 0 ]; then
    echo "twins_of_another_user: left out, it needs root to play a second user"
    return
  fi
  chmod 755 "$work"
  mkdir -p -m 777 "$work/bin"
  cp "$ectwin" "$work/bin/ectwin"
  # shellcheck disable=SC2016
  "$ectwin" with --name shared fzm1 -- sh -c 'unset ECTWIN_SOCKET
    "$1" ps --json; "$1" get -s shared data1' sh "$ectwin" >"$work/out" 2>/dev/null
  check "ps: one's own" "shared data1=0" "$(sed -E 's/.*"name":"([^"]*)".*/\1/' "$work/out" | xargs)"
  # shellcheck disable=SC2016
  "$ectwin" with --leave-children --name shared fzm1 -- sleep 20 2>"$work/err" &
  local twin=$!
  for _ in $(seq 1200); do grep -qs ready "$work/err" && break; sleep 0.1; done
  # shellcheck disable=SC2016
  env -u XDG_RUNTIME_DIR setpriv --reuid 64997 --clear-groups sh -c '"$1" ps; "$1" get -s shared data1' sh \
    "$work/bin/ectwin" >"$work/out" 2>"$work/err"
  setpriv --reuid 64997 --clear-groups "$work/bin/ectwin" ps >>"$work/out" 2>"$work/err2"
  kill $twin
  wait $twin 2>/dev/null
  has "ps: nor in a folder of another user" "belongs to another user" "$work/err2"
  check "ps: not another user's" "" "$(cat "$work/out")"
  has "get -s: nor by its name" "no twin of yours has the name or the process id 'shared'" "$work/err"
}

# A second command in the network of a twin: its interface, its folder, its status; without root where it can be tried.
enter() {
  # shellcheck disable=SC2016
  "$ectwin" with --leave-children --name inside --iface ecat7 fzm1 -- sleep 20 2>"$work/err" &
  local twin=$!
  for _ in $(seq 1200); do grep -qs ready "$work/err" && break; sleep 0.1; done
  (cd /usr && "$ectwin" enter -s inside -- sh -c 'pwd; echo {} "$ECTWIN_IFACE"; ls /sys/class/net; "$1" get data1; exit 7' \
    sh "$ectwin") >"$work/out" 2>"$work/err"
  check "enter: the status of CMD" 7 $?
  check "enter: the folder, the interfaces, the signals" "/usr ecat7 ecat7 ecat7 ectwin0 lo data1=0" "$(xargs <"$work/out")"
  "$ectwin" enter -s inside -- /nosuch 2>"$work/err"
  check "enter: a command that is not there" 127 $?
  "$ectwin" enter -s inside 2>"$work/err"
  check "enter: no command" 1 $?
  kill $twin
  wait $twin 2>/dev/null
  "$ectwin" enter -s inside -- true 2>"$work/err"
  check "enter: no twin" 2 $?
}

# Each row: the condition, the status, for a signal that is 2.5, one that is a text, and one that is not there.
waits() {
  local rows='data1=2.5 0|data1=0x3 3|data1!=2.5 3|data1!=3 0|data1>2 0|data1<2.5 3|data1=text 3|comment1=a text 0|comment1!=a text 3|comment1=b 3|nosuch=1 1|data1 1|=1 1|data1!3 1|data1<x 1|data*=1 1|'
  # shellcheck disable=SC2016
  "$ectwin" with fzm1 -- bash -c '"$1" set data1=2.5 "comment1=a text"; printf %s "$2" | while read -r -d "|" row; do
    "$1" wait -t 0.05 "${row% *}"; echo "${row% *} $?|"; done' bash "$ectwin" "$rows" >"$work/out" 2>"$work/err"
  check "wait: conditions" "$(echo "$rows" | tr '|' '\n' | sed '/^$/d')" "$(tr -d '|' <"$work/out")"
  has "wait: the value that the signal has" "data1 is still 2.5 after 0.05 s, not data1!=2.5" "$work/err"
  # The twin's own pulses, too short for a look every 10 ms.
  beside_an_fzm1 "'$ectwin' set image_input=100 processing=100
    while :; do '$ectwin' set trigger=1; '$ectwin' set trigger=0; sleep 0.1; done & '$ectwin' wait busy=1 && echo busy; kill \$!"
  check "wait: a condition that holds for 0.2 ms" busy "$(cat "$work/out")"
  beside_an_fzm1 "'$ectwin' watch data2 --until data1=7 >'$work/watch' &
    until grep -q data1 '$work/watch' && grep -q data2 '$work/watch'; do sleep 0.05; done
    '$ectwin' set data2=1 data1=7; wait; cat '$work/watch'; '$ectwin' watch --until data1=7"
  check "watch --until: ends with the change" "data1=0 data1=7 data1=7 data2=0" \
    "$(grep -v '"data2","value":1' "$work/out" | sed -E 's/.*"name":"([^"]*)","value":([^,]*),.*/\1=\2/' | sort | xargs)"
}

counts() {
  check "DEVICE*N: twins" "3 fzm1*2,optoncdt2300" "$("$ectwin" with 'fzm1*2,optoncdt2300' -- "$ectwin" ps --json 2>/dev/null |
    sed -E 's/.*"devices":"([^"]*)".*"slaves":([0-9]+).*/\2 \1/')"
  for count in 0 a 65536 '' 1,fzm1*65535; do
    "$ectwin" with "fzm1*$count" -- true 2>"$work/err"
    check "DEVICE*$count is refused" 1 $?
  done
}

# In a network of its own: the pair exists until a signal, and needs a right.
pair() {
  # shellcheck disable=SC2016
  unshare -Urn sh -c '"$1" veth tw >"$2/pair" & pair=$!; for _ in $(seq 1200); do [ -s "$2/pair" ] && break; sleep 0.1; done
    cat "$2/pair"; ip -br link show up | sed "s/@.*//" | sort | xargs; "$1" veth tw; echo $?
    "$1" run -i tw-twin fzm1 >"$2/run" & run=$!; for _ in $(seq 1200); do [ -s "$2/run" ] && break; sleep 0.1; done
    cat "$2/run"; kill $run $pair; wait; ip -br link | sed "s/[@ ].*//" | xargs' \
    sh "$ectwin" "$work" >"$work/out" 2>"$work/err"
  check "veth: the pair, a second one, a twin on it, its end" \
    '{"event":"ready","iface":"tw","twin":"tw-twin"}|tw tw-twin|2|{"event":"ready","iface":"tw-twin","slaves":1}|lo|' \
    "$(tr '\n' '|' <"$work/out")"
  has "veth: a name that is taken" "'tw' or 'tw-twin' exists already: choose another name, or 'sudo ip link del tw'" "$work/err"
  # shellcheck disable=SC2016
  unshare -Urn sh -c '"$1" veth tw >"$2/other" & pair=$!; for _ in $(seq 1200); do [ -s "$2/other" ] && break; sleep 0.1; done
    ip link del tw; kill $pair; wait $pair; echo $?' sh "$ectwin" "$work" >"$work/out" 2>"$work/err"
  check "veth: a pair that another program has removed" \
    "3 ectwin veth: 'tw' could not be removed: was it removed already? Else 'sudo ip link del tw'" "$(cat "$work/out") $(cat "$work/err")"
  unshare -Ur --map-user=1000 "$ectwin" veth 2>"$work/err"
  check "veth: without a right" 2 $?
  has "veth: the right" "needs CAP_NET_ADMIN: run 'sudo ectwin veth ecat0'" "$work/err"
  "$ectwin" veth 12345678901 2>"$work/err"
  check "veth: a name that is too long" 1 $?
}

# The namespace that CMD gets cannot be private: a limit of this user forbids another one.
require_private() {
  if [ "$(id -u)" != 0 ]; then
    echo "require_private: left out, only root runs CMD without a user namespace"
    return
  fi
  local limited='echo 0 >/proc/sys/user/max_user_namespaces; '
  # shellcheck disable=SC2016
  unshare -Urm sh -c "$limited"'"$1" with --require-private fzm1 -- echo ran; echo $?; "$1" with fzm1 -- echo ran' sh "$ectwin" \
    >"$work/out" 2>"$work/err"
  check "with --require-private: CMD does not run" "2 ran" "$(xargs <"$work/out")"
  has "with --require-private: the reason" "CMD is not run, because of --require-private" "$work/err"
}

# In a network of its own, as `run` needs an interface.
python_module() {
  "$ectwin" with fzm1 -- python3 "$here/test_python.py" --beside >"$work/out" 2>&1
  check "python: beside a twin" 0 "$?$(grep -v '^{"event"' "$work/out" | grep -A20 -E '^(FAIL|ERROR)')"
  unshare -Urn sh -c 'ip link add name tw0 type veth peer name tw1 && ip link set tw1 up && exec python3 "$1" --start "$2" tw0' \
    sh "$here/test_python.py" "$ectwin" >"$work/out" 2>&1
  check "python: start a twin" 0 "$?$(grep -A20 -E '^(FAIL|ERROR)' "$work/out")"
}

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
run_cases set_is_atomic tables tables_that_are_refused signals_of_a_device numbers_are_numbers watch_ends_with_its_reader odd_and_long_folders \
  no_twin a_stopped_twin escapes squatters several_twins twins_of_another_user enter waits counts pair require_private python_module
