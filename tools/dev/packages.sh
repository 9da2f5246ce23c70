#!/usr/bin/env bash
# Tests the packages on fresh machines: bare Debian or Ubuntu systems with a normal user.
# usage, as root: tools/dev/packages.sh RELEASE [PART...]      RELEASE: bookworm, trixie, noble; PART: those below (all)
#
#   deb        apt install of build/packages/ectwin_*.deb; a master reaches OP over a wire
#   wheel      pip install of build/packages/*.whl; a master reaches OP in process
#   container  the lines of packaging/container/Containerfile, then its user runs a master
#   action     the lines of action.yml, which build the package there
#   gitlab     the lines of packaging/ci/gitlab.yml, as root
#   workflow   the lines of .github/workflows/packages.yml, which build both packages there, as root
#
# Run tools/package.sh all first. Exits with 77 and a reason if such a machine cannot be made.
set -eu
cd "$(dirname "$0")/../.."
release=${1:?usage: tools/dev/packages.sh RELEASE [PART...]}
shift
in_op='ectwin with vr-bu-ect-map7 -- ectwin-controller {} --seconds 2 | grep operational'

part() { # NAME: the commands of a part
  case $1 in
    deb) echo "sudo apt-get update -qq; sudo apt-get install -y -qq ./build/packages/ectwin_*.deb >/dev/null; $in_op; zcat /usr/share/man/man1/ectwin.1.gz | grep -c . ; cc=\$(ls /usr/share/ectwin/esi | wc -l); test \"\$cc\" -ge 11" ;;
    wheel) echo "sudo apt-get update -qq; sudo apt-get install -y -qq python3-venv >/dev/null; python3 -m venv /tmp/venv; /tmp/venv/bin/pip install -q build/packages/ectwin-*.whl; PATH=/tmp/venv/bin:\$PATH; $in_op; python3 -c 'import ectwin'; ectwin with --in-process --virtual-time fzm1 -- ectwin-plc {} -m 2 | grep '\"data\":2'" ;;
    container) tools/dev/ci_lines.py packaging/container/Containerfile; echo "sudo -u ectwin -i sh -c 'cd && ${in_op//\'/}'" ;;
    action) echo "export GITHUB_ACTION_PATH=\$PWD DEVICES=vr-bu-ect-map7 OPTIONS= COMMAND='ectwin-controller \$ECTWIN_IFACE --seconds 2 | grep operational'"
      tools/dev/ci_lines.py action.yml ;;
    gitlab) echo "git init -q && git add -A && git -c user.name=x -c user.email=x@x.example commit -qm x && export ECTWIN_REPOSITORY=\$PWD"
      printf 'sudo -E bash -ec %q\n' "git config --global safe.directory '*'; cd /tmp; $(tools/dev/ci_lines.py packaging/ci/gitlab.yml)" ;;
    workflow) printf 'sudo -E bash -ec %q\n' "$(tools/dev/ci_lines.py .github/workflows/packages.yml)" ;;
    *) echo "packages.sh: no part is named '$1'" >&2; exit 1 ;;
  esac
}

for name in ${*:-deb wheel container action gitlab workflow}; do
  commands=$(part "$name")
  status=0
  FRESH_FILES='build/packages' tools/dev/fresh.sh "$release" "$commands" || status=$?
  [ $status -ne 77 ] || exit 77
  [ $status -eq 0 ] || { echo "$release, $name: FAILED (status $status)"; exit $status; }
  echo "$release, $name: passed"
done
