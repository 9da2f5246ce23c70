#!/usr/bin/env bash
# The manual pages of a build are silent under mandoc -T lint, and each installed program has one.  usage: man.sh BUILD
# Exits with 77 without mandoc.
set -eu
command -v mandoc >/dev/null || { echo "mandoc is not installed (apt-get install mandoc)"; exit 77; }
build=$1
cd "$build/share/man/man1"
status=0
programs=$(grep -rhoE 'TYPE EXECUTABLE FILES "[^"]+"' --include=cmake_install.cmake "$build" | sed -E 's/.*"(.*)"/\1/')
[ -n "$programs" ] || { echo "FAILED $build installs no program"; status=1; }
for program in $programs; do
  [ -s "$(basename "$program").1" ] || { echo "FAILED $(basename "$program") has no manual page"; status=1; }
done
mandoc -T lint ./*.1 || status=1 # in this folder, in which references to other pages are found
for command in $("$build/ectwin" --help | grep -o 'ectwin  *[a-z-]*' | awk '$2 ~ /^[a-z]/ {print $2}' | sort -u); do
  grep -q "^\.Ss ectwin $command\$" ectwin.1 || { echo "FAILED ectwin.1 has no section for ectwin $command"; status=1; }
done
exit $status
