#!/usr/bin/env bash
# Installs the missing packages of a job.  usage: tools/bootstrap.sh run|kernel|board|bench|package|test
#
#   run   build ectwin and run the demo: compiler, CMake, libnl, cJSON, libseccomp, libxml2, libyaml, libmodbus, libwebsockets, and SOEM for
#         the demo's master
#   kernel run, and the packages for --in-kernel: libbpf, clang, bpftool
#   board run, and the packages for board firmware: compilers for ARM, with their C libraries, and RISC-V; QEMU and
#         iproute2 to run it
#   bench run, and the packages for tools/dev/bench/run.py: valgrind, iproute2, util-linux
#   package run, and the packages for tools/package.sh
#   test  all except bench, and the packages of the tests: CMocka, clang for the fuzz targets, gcovr, iperf3, and from PyPI
#         pymodbus, FMPy, and the sources of SOEM for examples/fuzz-master; Chromium with its driver, which the panel's page is tested in
#
# Debian and Ubuntu packages, as root or through sudo. SOEM: an installed version (find_package) is used if the programs of this
# tree compile with it; else pip downloads the source package pyecm 0.0.3 with SOEM 1.4.0 from PyPI, checks its pinned hash, and
# builds it below ~/.cache/ectwin, where pymodbus and FMPy are stored as well. The script may be run repeatedly; it has no effect if
# no package is missing.
set -eu

run_packages="gcc libc6-dev cmake ninja-build pkg-config libnl-route-3-dev libcjson-dev libseccomp-dev libxml2-dev libmodbus-dev libyaml-dev
  libwebsockets-dev"
soem_packages="python3 python3-pip python3-venv ca-certificates"
board_packages="binutils gcc-arm-none-eabi libnewlib-arm-none-eabi gcc-riscv64-unknown-elf gcc-aarch64-linux-gnu libc6-dev-arm64-cross
  gcc-arm-linux-gnueabihf libc6-dev-armhf-cross qemu-system-arm iproute2 python3"
kernel_packages="libbpf-dev clang bpftool"
package_packages="dpkg-dev file git python3 python3-pip python3-venv ca-certificates"
bench_packages="valgrind iproute2 util-linux python3"
test_packages="libcmocka-dev clang gcovr libxml2-utils doxygen iperf3"
browser_packages="chromium chromium-driver" # Ubuntu has these only as snaps
lint_packages="clang-format-19 clang-tidy-19" # one version everywhere, for each finds something else; not every release has it

soem_prefix="$HOME/.cache/ectwin/soem-1.4.0"
soem_sources="$HOME/.cache/ectwin/soem-1.4.0-source"
soem_package="pyecm==0.0.3"
soem_sha256="5dbe908a5a4742be331e7a1a5e858ec39bd8a0e650ecd0ad3421d875a8ae3b9f"

pymodbus_wheel="pymodbus-3.16.1-py3-none-any.whl"
pymodbus_sha256="bb433f7417280bdea1190d95495aa6fb8e1fa8e0d720c436922b270bc378024c"

fmpy_folder="$HOME/.cache/ectwin/fmpy-0.3.32"
fmpy_requirements="fmpy==0.3.32 --hash=sha256:b379deb9417b842028003a288d00c1c5f138d1580e1ff12cc6c42a98719cecf0
attrs==24.2.0 --hash=sha256:81921eb96de3191c8258c199618104dd27ac608d9366f5e35d011eae1867ede2"
fmpy_libraries="numpy==2.1.3 lxml==5.3.0" # another file for each Python and machine

say() { printf 'bootstrap: %s\n' "$*" >&2; }
die() { say "$*"; exit 1; }

as_root() {
  if [ "$(id -u)" -eq 0 ]; then
    "$@"
  else
    command -v sudo >/dev/null || die "installing packages needs root: run this as root, or install sudo"
    sudo "$@"
  fi
}

# A package counts as installed if dpkg lists it, or if its command has another source.
is_there() {
  case "$1" in
    gcc | cmake | clang | clang-format-19 | clang-tidy-19 | doxygen | gcovr | iperf3 | python3) command -v "$1" >/dev/null && return 0 ;;
    ninja-build) command -v ninja >/dev/null && return 0 ;;
    binutils) command -v objdump >/dev/null && return 0 ;;
    pkg-config) command -v pkg-config >/dev/null && return 0 ;;
    gcc-arm-none-eabi) command -v arm-none-eabi-gcc >/dev/null && return 0 ;;
    gcc-riscv64-unknown-elf) command -v riscv64-unknown-elf-gcc >/dev/null && return 0 ;;
    qemu-system-arm) command -v qemu-system-arm >/dev/null && return 0 ;;
    libnewlib-arm-none-eabi) echo '#include <assert.h>' | arm-none-eabi-gcc -E - >/dev/null 2>&1 && return 0 ;;
    iproute2) command -v ip >/dev/null && return 0 ;;
    util-linux) command -v taskset >/dev/null && command -v unshare >/dev/null && return 0 ;;
    valgrind) command -v valgrind >/dev/null && return 0 ;;
    chromium) command -v chromium >/dev/null && return 0 ;;
    chromium-driver) command -v chromedriver >/dev/null && return 0 ;;
    git) command -v git >/dev/null && return 0 ;;
    python3-pip) python3 -m pip --version >/dev/null 2>&1 && return 0 ;;
    python3-venv) python3 -c 'import venv, ensurepip' >/dev/null 2>&1 && return 0 ;;
  esac
  dpkg-query -W -f='${Status}' "$1" 2>/dev/null | grep -q 'install ok installed'
}

install_packages() {
  local missing=""
  for package in "$@"; do
    is_there "$package" || missing="$missing $package"
  done
  [ -z "$missing" ] && return 0
  command -v apt-get >/dev/null || die "this machine has no apt-get; please install:$missing"
  say "installing$missing"
  as_root apt-get update -qq
  # shellcheck disable=SC2086
  as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $missing >/dev/null
}

# The sanitizer and fuzzer runtimes are in a separate package with clang's version in its name.
install_clang_runtime() {
  local version
  version=$(clang -dumpversion | cut -d. -f1)
  echo 'int main(void){return 0;}' >"$work/a.c"
  clang -fsanitize=address,undefined "$work/a.c" -o "$work/a" 2>/dev/null || install_packages "libclang-rt-$version-dev"
}

# Checks for SOEM of the required version: cmake/soem.cmake compiles a program with it.
soem_is_installed() {
  mkdir -p "$work/find"
  cat >"$work/find/CMakeLists.txt" <<CMAKE
cmake_minimum_required(VERSION 3.22)
project(find_soem LANGUAGES C)
include($root/cmake/soem.cmake)
if(NOT soem_FOUND)
  message(FATAL_ERROR "not there")
endif()
CMAKE
  cmake -G Ninja -S "$work/find" -B "$work/find/build" >"$work/log" 2>&1 && return 0
  sed -n 's/^-- The SOEM/bootstrap: the SOEM/p' "$work/log" >&2
  return 1
}

# Unpacks SOEM below $work.
fetch_soem() {
  # shellcheck disable=SC2086
  install_packages $soem_packages
  echo "$soem_package --hash=sha256:$soem_sha256" >"$work/requirements.txt"
  python3 -m pip download --quiet --disable-pip-version-check --no-deps --no-binary pyecm --require-hashes \
    -r "$work/requirements.txt" -d "$work/pip" >"$work/log" 2>&1 || { cat "$work/log" >&2; die "pip could not fetch $soem_package"; }
  echo "$soem_sha256  $(echo "$work"/pip/pyecm-0.0.3.tar.gz)" | sha256sum --check --quiet || die "pip fetched another $soem_package"
  tar -xzf "$work/pip/pyecm-0.0.3.tar.gz" -C "$work"
}

install_soem_sources() {
  [ -e "$soem_sources/soem/ethercatmain.c" ] && return 0
  say "fetching the sources of SOEM 1.4.0 into $soem_sources"
  fetch_soem
  rm -rf "$soem_sources"
  mkdir -p "$(dirname "$soem_sources")"
  mv "$work/pyecm-0.0.3/ext/SOEM" "$soem_sources"
}

install_soem() {
  [ -e "$soem_prefix/share/soem/LICENSE" ] && return 0
  soem_is_installed && return 0
  say "fetching and building SOEM 1.4.0 below $soem_prefix"
  fetch_soem
  { cmake -G Ninja -S "$work/pyecm-0.0.3/ext/SOEM" -B "$work/soem" -DCMAKE_BUILD_TYPE=Release -DCMAKE_C_FLAGS=-w \
      -DCMAKE_INSTALL_PREFIX="$soem_prefix.new" &&
    cmake --build "$work/soem" && cmake --install "$work/soem" &&
    cp "$work/pyecm-0.0.3/ext/SOEM/LICENSE" "$soem_prefix.new/share/soem/"; } >"$work/log" 2>&1 ||
    { cat "$work/log" >&2; die "SOEM did not build"; }
  rm -rf "$soem_prefix"
  mv "$soem_prefix.new" "$soem_prefix" # complete or not at all
}

# Pure Python: the package is imported from the downloaded file.
install_pymodbus() {
  [ -e "$HOME/.cache/ectwin/$pymodbus_wheel" ] && return 0
  # shellcheck disable=SC2086
  install_packages $soem_packages
  say "fetching $pymodbus_wheel into $HOME/.cache/ectwin"
  echo "pymodbus==3.16.1 --hash=sha256:$pymodbus_sha256" >"$work/requirements.txt"
  python3 -m pip download --quiet --disable-pip-version-check --no-deps --only-binary :all: --require-hashes \
    -r "$work/requirements.txt" -d "$work/pip" >"$work/log" 2>&1 || return 1
  mkdir -p "$HOME/.cache/ectwin"
  mv "$work/pip/$pymodbus_wheel" "$HOME/.cache/ectwin/"
}

# FMPy with the requirements of a simulation: 28 MB, for this Python.
install_fmpy() {
  PYTHONPATH="$fmpy_folder" python3 -c 'import fmpy.fmi2, fmpy.fmi3' 2>/dev/null && return 0
  # shellcheck disable=SC2086
  install_packages $soem_packages
  say "fetching FMPy 0.3.32 into $fmpy_folder"
  echo "$fmpy_requirements" >"$work/requirements.txt"
  local pip="python3 -m pip install --quiet --disable-pip-version-check --no-deps --only-binary :all: --target $work/fmpy"
  # shellcheck disable=SC2086
  { $pip --require-hashes -r "$work/requirements.txt" && $pip $fmpy_libraries; } >"$work/log" 2>&1 || return 1
  mkdir -p "$HOME/.cache/ectwin"
  rm -rf "$fmpy_folder"
  mv "$work/fmpy" "$fmpy_folder"
}

job=${1:-}
root=$(cd "$(dirname "$0")/.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
case "$job" in
  run) install_packages $run_packages ;;
  kernel) install_packages $run_packages $kernel_packages ;;
  board) install_packages $run_packages $board_packages ;;
  bench) install_packages $run_packages $bench_packages ;;
  package) install_packages $run_packages $package_packages ;;
  test)
    # shellcheck disable=SC2086
    install_packages $run_packages $board_packages $test_packages
    install_clang_runtime
    # shellcheck disable=SC2086
    (install_packages $kernel_packages) || say "without $kernel_packages twins are built and tested without --in-kernel"
    # shellcheck disable=SC2086
    (install_packages $browser_packages) || say "without $browser_packages the panel's page is not tested"
    # shellcheck disable=SC2086
    (install_packages $lint_packages) || say "without $lint_packages the layout of the files and what clang-tidy says are not checked"
    ;;
  *) die "usage: tools/bootstrap.sh run|kernel|board|bench|package|test" ;;
esac
install_soem
[ "$job" != test ] || (install_pymodbus) || say "without pymodbus from PyPI the base unit's Modbus side is not tested over the wire"
[ "$job" != test ] || (install_fmpy) || say "without FMPy from PyPI ectwin-fmu is not tested with models"
[ "$job" != test ] || (install_soem_sources) || say "without the sources of SOEM from PyPI examples/fuzz-master is not tested"
