#!/usr/bin/env bash
# ectwin-board with a virtual LAN9252 under it, driven by SOEM over a veth pair.
# usage: lan9252.sh BOARD_OF_TESTS TEST_BASE_UNIT [CASE]
set -u
board=$1
base_unit=$2
only=${3:-}
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# shellcheck source=tests/support/check.sh
. "$(dirname "$0")/../support/check.sh"
on_failure() {
  echo "  alone: $0 $board $base_unit $case_name"
  cat "$work/err" "$work/master" 2>/dev/null
}

# drive TITLE MODE INPUT_BYTES OUTPUT_BYTES ARGUMENT...: SOEM's tests of a base unit against the board; then the board ends well.
drive() {
  local title=$1 mode=$2 in=$3 out=$4
  shift 4
  board=$board work=$work here=$here base_unit=$base_unit mode=$mode in=$in out=$out unshare -Urn bash -c '
    ip link add name tw0 type veth peer name tw1 && ip link set tw0 up && ip link set tw1 up || exit 9
    rm -f "$work/ready" # that of the run before would end the wait
    "$board" tw0 --spi /dev/spidev7.1 "$@" "vr-bu-ect-${mode,,}" >"$work/ready" 2>"$work/err" & pid=$!
    for _ in $(seq 1200); do [ -s "$work/ready" ] && break; sleep 0.1; done
    cat "$work/ready"
    if [ -n "${RESETS:-}" ]; then # the master takes the board to OP, and resets its ESC
      "$base_unit" tw1 "VR-BU-ECT-$mode" "$in" "$out" >"$work/master" 2>&1 || echo "before the reset"
      python3 "$here/reset_esc.py" tw1
      for _ in $(seq 1200); do grep -q "was reset" "$work/err" && break; sleep 0.1; done
    fi
    if [ -n "${FAULTS_MS:-}" ]; then # with any result, and at any time
      sleep "$((FAULTS_MS / 1000 + 2))" & over=$!
      timeout "$((FAULTS_MS / 1000 + 1))" "$base_unit" tw1 "VR-BU-ECT-$mode" "$in" "$out" >"$work/faults" 2>&1
      wait $over
    fi
    "$base_unit" tw1 "VR-BU-ECT-$mode" "$in" "$out" >"$work/master" 2>&1; echo "master $?"
    kill $pid; wait $pid; echo "board $?"' bash "$@" >"$work/out"
  check "$title" '{"event":"ready","spi":"/dev/spidev7.1","device":"vr-bu-ect-'"${mode,,}"'"} master 0 board 0' "$(xargs -0 <"$work/out" | tr '\n' ' ' | sed 's/ *$//')"
}

prints_nothing() {
  check "$1: it prints nothing on standard error" "" "$(cat "$work/err")"
}

polled() {
  drive "SOEM takes Map7 to OP and through its tests, polled" Map7 66 228 --store "$work/store"
  prints_nothing "polled, with a folder"
}

by_the_interrupt_pin() {
  drive "SOEM takes Map7 to OP and through its tests, by the interrupt pin" Map7 66 228 --irq gpiochip9:25
  prints_nothing "by the interrupt pin"
}

by_an_interrupt_pin_that_is_active_high() {
  drive "SOEM takes Map7 to OP and through its tests, by an interrupt pin that is active high" Map7 66 228 --irq gpiochip9:25 --irq-high
}

reset_by_the_master() {
  RESETS=1 drive "a reset by the master (0x0040), behind the interrupt pin: the board starts again, and all tests pass" Map7 66 228 \
    --irq gpiochip9:25
  grep -q "was reset, by the master" "$work/err" || check "a reset by the master: it says so" "was reset, by the master" "$(cat "$work/err")"
}

reset_by_the_master_polled() {
  RESETS=1 drive "a reset by the master (0x0040), polled: the board starts again, and all tests pass" Map7 66 228
}

a_slow_chip() {
  CSR_LASTS=12 WORD_LASTS=9 LATE=20000 drive "a chip that is slow, late, and reset by its pin" Map3 66 24 \
    --irq gpiochip9:25 --reset gpiochip9:24
}

a_chip_with_faults() {
  FAULTS_MS=8000 drive "bits flip and the chip hangs for 8 s: afterwards the slave is as good as new" Map7 66 228
}

# alone STATUS PATTERN ARGUMENT...: the board with its virtual chip, and no master.
alone() {
  local status=$1 pattern=$2
  shift 2
  board=$board work=$work timeout 300 unshare -Urn bash -c '
    ip link add name tw0 type veth peer name tw1 && ip link set tw0 up && ip link set tw1 up || exit 9
    "$board" tw0 --spi /dev/spidev7.1 "$@" fzm1 2>"$work/err"' bash "$@" >/dev/null
  check "'$*' with a chip" "$status" $?
  grep -q -- "$pattern" "$work/err" || check "'$*' with a chip: it says so" "$pattern" "$(cat "$work/err")"
}

registers_of_a_chip() {
  alone 2 "'gpio25' names no GPIO line: CHIP:LINE" --irq gpio25
  alone 2 "cannot take line 3 of '/dev/gpiochip9'" --irq gpiochip9:3
  alone 2 "cannot take line 25 of '/dev/gpiochip77': No such file" --irq gpiochip77:25
  alone 2 "cannot keep what is saved" --store /dev/null/folder
  LATE=4000000000 alone 2 "does not get ready"
  CSR_LASTS=4000000000 alone 2 "does not carry out accesses"
}

# A save that is under way when a signal ends the command
a_save_under_way() {
  board=$board work=$work SAVE=1 timeout 300 unshare -Urn bash -c '
    ip link add name tw0 type veth peer name tw1 && ip link set tw0 up && ip link set tw1 up || exit 9
    "$board" tw0 --spi /dev/spidev7.1 --store "$work/store" fzm1 >"$work/ready" 2>"$work/err" & pid=$!
    for _ in $(seq 1200); do grep -q saving "$work/err" && break; sleep 0.1; done
    cat "$work/store"/* | grep -ac FZM1
    kill $pid; wait $pid; echo "board $?"
    cat "$work/store"/* | grep -ac FZM1' >"$work/out"
  check "a save under way is done before the end: records before, board, records after" "0 board 0 1" "$(xargs <"$work/out")"
}

run_cases a_chip_with_faults reset_by_the_master reset_by_the_master_polled a_slow_chip polled by_the_interrupt_pin by_an_interrupt_pin_that_is_active_high \
  registers_of_a_chip a_save_under_way
