#!/usr/bin/env bash
# The demo: builds ectwin, and SOEM takes two base units from INIT to OP on a private network. Needs no hardware, and root only for
# the installation of missing packages.
set -eu
cd "$(dirname "$0")/.."
tools/bootstrap.sh run
[ -x build/release/ectwin ] || echo "demo: the first start builds ectwin and its example masters in build/release: one to three minutes" >&2
cmake --preset release >build.log 2>&1 || { cat build.log; exit 1; }
cmake --build --preset release >build.log 2>&1 || { cat build.log; exit 1; }
rm -f build.log
exec build/release/ectwin with vr-bu-ect-map7,vr-bu-ect-multiarm -- build/release/ectwin-demo-master '{}'
