#!/usr/bin/env bash
# Other projects against an installed ectwin: the device and the board of examples/, by CMake, by pkg-config, and for a Cortex-M4.
# usage: outside.sh BUILD SLAVEINFO [FLAGS]     SLAVEINFO: of SOEM, if installed; FLAGS: what BUILD was compiled with
set -eu
build=$1
slaveinfo=$2
flags="-Wall -Wextra -Wconversion -Wshadow -Werror ${3:-}"
root=$(cd "$(dirname "$0")/../.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# shellcheck source=tests/support/check.sh
. "$(dirname "$0")/../support/check.sh"

quietly() { "$@" >"$work/log" 2>&1 || { cat "$work/log"; echo "FAILED $*"; exit 1; }; }

# project SOURCE NAME ARGUMENT...: configured and built below NAME
project() {
  local source=$1 name=$2
  shift 2
  quietly cmake -G Ninja -S "$source" -B "$work/$name" "$@"
  quietly cmake --build "$work/$name"
}

quietly cmake --install "$build" --prefix "$work/prefix"

# A device outside the tree: its own tests, and the whole command with it.
cp -r "$root/examples" "$work/examples" # nothing beside it
project "$work/examples/device" device -DCMAKE_PREFIX_PATH="$work/prefix" -DCMAKE_C_FLAGS="$flags"
quietly "$work/device/test_heater"
heater=$work/device/ectwin-heater
check "list" "fzm1 heater" "$("$heater" list | awk '{print $1}' | grep -E '^(fzm1|heater)$' | xargs)"
check "list: bytes" "3/2" "$("$heater" list | awk '$1 == "heater" {print $2}')"
if [ -x "$slaveinfo" ]; then
  map=$(map_of "$heater" with heater -- "$slaveinfo" '{}' -map)
  check "with: SAFEOP" 4 "$(sed -n 's/ State: //p' <<<"$map")"
  check "with: sizes" "16bits 24bits" "$(sed -n 's/ \(Output\|Input\) size: //p' <<<"$map" | xargs)"
  check "with: entries" "Set point Temperature Power" "$(sed -n 's/^  \[0x.*0x.. [A-Z0-9]* *//p' <<<"$map" | xargs)"
fi
check "set, get" "sensed=215" "$("$heater" with heater -- sh -c "'$heater' set sensed=215; '$heater' get sensed" 2>/dev/null)"
mirror=$work/device/ectwin-mirror
check "the mirror: conformance" "0 fail" \
  "$("$mirror" with mirror -- "$build/ectwin-conform" -i '{}' --only 'CF-033,CF-05*,CF-06*' 2>/dev/null | sed -n 's/.* cases in .* \([0-9]* fail\), .*/\1/p')"
check "docs/DEVICE.md: the number of cases" "$("$build/ectwin-conform" --list | wc -l)" \
  "$(sed -n 's/^[0-9]* of \([0-9]*\) cases in .*/\1/p' "$root/docs/DEVICE.md")"
check "the heater: EEPROM and mailbox agree on VoE" "0 fail" \
  "$("$heater" with heater -- "$build/ectwin-conform" -i '{}' --only 'CF-058,CF-086' 2>/dev/null | sed -n 's/.* cases in .* \([0-9]* fail\), .*/\1/p')"
check "sii" 2048 "$("$heater" sii heater | wc -c)"

# By pkg-config.
export PKG_CONFIG_PATH=$work/prefix/lib/pkgconfig
# shellcheck disable=SC2046,SC2086
quietly ${CC:-cc} -std=c11 $flags "$work"/examples/device/{main,heater,heater_plant}.c $(pkg-config --cflags --libs ectwin-host) \
  -o "$work/by-pkg-config"
check "pkg-config: list" "3/2" "$("$work/by-pkg-config" list | awk '$1 == "heater" {print $2}')"

# A SOES application outside the tree, over SOES's API and as a twin by our hardware file: by CMake, and by pkg-config.
mkdir "$work/soes"
cp "$root"/tests/soes/{app.c,app.h,ecat_options.h,main.c} "$work/soes"
cat >"$work/soes/CMakeLists.txt" <<'CMAKE'
cmake_minimum_required(VERSION 3.22)
project(my_firmware LANGUAGES C)
find_package(ectwin REQUIRED COMPONENTS soes soes_hal)
add_executable(my_firmware main.c app.c)
target_include_directories(my_firmware PRIVATE .)
target_link_libraries(my_firmware PRIVATE ectwin::soes ectwin::soes_hal)
CMAKE
project "$work/soes" soes-by-cmake -DCMAKE_PREFIX_PATH="$work/prefix" -DCMAKE_C_FLAGS="$flags"
api=$(pkg-config --variable=soes ectwin-core)
# shellcheck disable=SC2046,SC2086
quietly ${CC:-cc} -std=c11 $flags -I"$work/soes" -I"$api" "$work"/soes/{main,app}.c "$api"/*.c \
  "$(pkg-config --variable=soes_hal ectwin-core)/esc_hw.c" $(pkg-config --cflags --libs ectwin-soes_hal) -o "$work/soes-by-pkg-config"
for program in "$work/soes-by-cmake/my_firmware" "$work/soes-by-pkg-config"; do
  [ -x "$slaveinfo" ] || continue
  map=$(map_of "$heater" with --external "$program" -- "$slaveinfo" '{}' -map)
  check "$program: SAFEOP" 4 "$(sed -n 's/ State: //p' <<<"$map")"
  check "$program: sizes" "24bits 24bits" "$(sed -n 's/ \(Output\|Input\) size: //p' <<<"$map" | xargs)"
done

# A separate stack, by its sources, which calls an emulated EEPROM: ectwin's hardware file supplies the functions that it needs.
mkdir "$work/foreign"
cp "$root"/tests/soes/{app.c,app.h,ecat_options.h,main.c} "$work/foreign"
cat >"$work/foreign/stack.c" <<'STACK'
#include "ecat_slv.h"
#include "esc_eep.h"
_ESCvar ESCvar;
void ecat_slv_init(esc_cfg_t *config)
{
    EEP_init();
    ESC_init(config);
}
void ecat_slv(void)
{
    uint8_t data[8];
    (void)EEP_read(0, data, EEP_write(0, data, 2) == 0);
}
STACK
sed -e 's/COMPONENTS soes soes_hal/COMPONENTS soes_hal/; s/ectwin::soes ectwin::soes_hal/ectwin::soes_hal/; s/main.c app.c/main.c app.c stack.c/' \
  -e 's|PRIVATE \.)|PRIVATE . ${SOES})|' "$work/soes/CMakeLists.txt" >"$work/foreign/CMakeLists.txt"
project "$work/foreign" foreign-by-cmake -DCMAKE_PREFIX_PATH="$work/prefix" -DCMAKE_C_FLAGS="$flags" -DSOES="$api"
check "a stack by its sources links" yes "$([ -x "$work/foreign-by-cmake/my_firmware" ] && echo yes)"

# Two devices of one name are one too many.
sed -i 's/\.name = "heater"/.name = "fzm1"/' "$work/examples/device/heater.c"
quietly cmake --build "$work/device"
check "a name that is taken" "3 ectwin: two devices have the name 'fzm1'; give this program's another one" \
  "$("$heater" list >"$work/out" 2>&1; echo $? "$(cat "$work/out")")"

# The core alone, and the board with the same device.
arm="-DCMAKE_BUILD_TYPE=MinSizeRel -DCMAKE_TOOLCHAIN_FILE=$root/examples/board/cortex-m4.cmake"
core=$root/build/mps2-an385 # for a Cortex-M3, which a Cortex-M4 executes; the test board_image builds it
if [ ! -e "$core/build.ninja" ]; then
  core=$work/core
  # shellcheck disable=SC2086
  project "$root" core $arm -DCMAKE_BUILD_TYPE=None -DECTWIN_HOST=OFF # installed and linked is the subject, not optimised
fi
quietly cmake --install "$core" --prefix "$work/arm"
# shellcheck disable=SC2086
project "$work/examples/board" board $arm -DCMAKE_PREFIX_PATH="$work/arm"
check "the firmware is there" yes "$([ -s "$work/board/heater-firmware" ] && echo yes)"

# Its buffers are as large as the description asks for: on an imagined board it gets as far as the ESC.
cat >"$work/board.c" <<'BOARD'
#include <stdlib.h>
#include "board.h"
static uint32_t load(void *ctx, unsigned int reg)
{
    (void)ctx;
    exit(reg == ECT_WINDOW_COMMAND ? 42 : 2);
}
static void store(void *ctx, unsigned int reg, uint32_t value)
{
    (void)ctx;
    exit(reg == value ? 3 : 4);
}
const ect_window_t board_window = {.load = load, .store = store, .patience = 1};
uint64_t board_now_ns(void) { return 0; }
int16_t board_temperature(void) { return 0; }
void board_heat(uint8_t percent) { (void)percent; }
void board_alive(void) { }
void board_reset(void) { }
BOARD
# shellcheck disable=SC2046,SC2086
quietly ${CC:-cc} -std=c11 $flags -I"$work/examples/device" -I"$work/examples/board" "$work"/examples/{board/main,device/heater}.c \
  "$work/board.c" $(pkg-config --cflags --libs ectwin-core) -o "$work/firmware"
check "the firmware reaches the ESC" 42 "$("$work/firmware"; echo $?)"

# shellcheck disable=SC2086
cmake -G Ninja -S "$work/examples/device" -B "$work/no-host" $arm -DCMAKE_PREFIX_PATH="$work/arm" >"$work/log" 2>&1 || true
check "find_package without the host part says so" yes "$(grep -q 'without its host part' "$work/log" && echo yes)"
exit $failed
