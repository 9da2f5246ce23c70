#!/usr/bin/env bash
# Builds every package of the current commit twice, in two folders, the second time with another umask, locale and time zone, and
# compares the bytes; then stores packages, bill of materials and check sums in build/release-VERSION.
# usage: tools/dev/release.sh [KIND]      KIND: deb, wheel, all (default)
set -eu
cd "$(dirname "$0")/../.."
kind=${1:-all}
[ -z "$(git status --porcelain --untracked-files=no)" ] || { echo "release: commit or undo the changes of this tree first" >&2; exit 1; }
version=$(sed -n 's/^project(ectwin VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)
grep -q "^## $version" CHANGELOG.md || { echo "release: CHANGELOG.md has no section $version" >&2; exit 1; }
SOURCE_DATE_EPOCH=$(git log -1 --format=%ct)
export SOURCE_DATE_EPOCH
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
build() { # NAME: a clone of that name, its packages, their sums
  git clone -q . "$work/$1"
  "$work/$1/tools/package.sh" "$kind"
  (cd "$work/$1/build/packages" && LC_ALL=C sha256sum -- *) >"$work/$1.sums"
}
build first
(umask 077 && export LC_ALL=C LANG=C TZ=Asia/Kathmandu && build another-name)
diff "$work/first.sums" "$work/another-name.sums" || { echo "release: two builds differ" >&2; exit 1; }
out=build/release-$version
mkdir -p build
rm -rf "$out"
mv "$work/first/build/packages" "$out"
cp "$work/first.sums" "$out/SHA256SUMS"
echo "release: two builds are equal"
cat "$out/SHA256SUMS"
