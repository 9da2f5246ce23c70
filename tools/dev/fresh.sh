#!/usr/bin/env bash
# Runs the README's commands on a fresh machine: a bare Debian or Ubuntu, a normal user with sudo, and the present files of this
# tree that git tracks.  usage, as root: tools/dev/fresh.sh [RELEASE [COMMAND]]
# (default bookworm, 'tools/demo.sh && tools/test.sh')
#
# Exits with COMMAND's status, or with 77 and a reason if such a machine cannot be made. Needs root, mmdebstrap and a mirror, and
# for Ubuntu its keyring (/usr/share/keyrings/ubuntu-archive-keyring.gpg); $FRESH_FILES names further files, and bare systems are
# kept in ~/.cache/ectwin. Resolver, certificates and proxy settings are those of this machine. Other files are removed.
set -eu
cd "$(dirname "$0")/../.."
release=${1:-bookworm}
command=${2:-tools/demo.sh && tools/test.sh}

cannot() { echo "fresh: no fresh machine ($release) is tried: $*"; exit 77; }
[ "$(id -u)" -eq 0 ] || cannot "this needs root"
command -v mmdebstrap >/dev/null || cannot "mmdebstrap is not installed (apt-get install mmdebstrap)"
unshare --mount --pid --fork true 2>/dev/null || cannot "namespaces for mounts and processes are refused here"
git -c safe.directory="$PWD" ls-files --error-unmatch "$0" >/dev/null 2>&1 || cannot "this is no git checkout"

work=$(mktemp -d)
trap 'rm -rf --one-file-system "$work"' EXIT
machine=$work/machine
bare=$HOME/.cache/ectwin/bare-$release.tar
if [ ! -s "$bare" ]; then
  mkdir -p "${bare%/*}"
  case "$release" in
    jammy | noble) components=main,universe ;; # Ubuntu has libmodbus and cJSON in universe
    *) components=main ;;
  esac
  mmdebstrap -q --variant=minbase --components=$components --include=apt,ca-certificates,git,sudo "$release" "$work/bare.tar" 2>"$work/log" ||
    cannot "mmdebstrap: $(tail -n 1 "$work/log")"
  mv "$work/bare.tar" "$bare"
fi
mkdir "$machine"
tar -C "$machine" -xf "$bare" --exclude './dev/*'

cp -L /etc/resolv.conf "$machine/etc/resolv.conf"
certificates=/etc/ssl/certs/ca-certificates.crt
[ ! -e "$certificates" ] || cp -L "$certificates" "$machine$certificates"
echo "127.0.0.1 localhost $(hostname)" >"$machine/etc/hosts"
echo 'user ALL=(ALL) NOPASSWD: ALL' >"$machine/etc/sudoers.d/user"
chroot "$machine" useradd -m -s /bin/bash user
project=$machine/home/user/project
mkdir "$project"
git -c safe.directory="$PWD" ls-files -z | tar --null -T - -cf - | tar -C "$project" -xf -
[ -z "${FRESH_FILES:-}" ] || tar -cf - $FRESH_FILES | tar -C "$project" -xf -
chroot "$machine" chown -R user:user /home/user

# The profile of a login shell. Programs with their own certificates are configured for the machine's.
{
  for name in http_proxy https_proxy no_proxy; do
    [ -z "${!name:-}" ] || printf 'export %s=%q\n' "$name" "${!name}"
  done
  printf 'export SSL_CERT_FILE=%s PIP_CERT=%s\n' "$certificates" "$certificates"
  printf 'cd ~/project\n%s\n' "$command"
} >"$machine/home/user/commands"

# A separate root, not a chroot, in which the kernel refuses user namespaces. All processes end with the command or this script.
unshare --mount --pid --fork --kill-child --propagation private bash -euc '
  mount --bind "$1" "$1"
  cd "$1"
  mkdir -p proc sys dev before
  mount -t proc proc proc
  mount --rbind /sys sys
  mount --rbind /dev dev
  pivot_root . before
  cd /
  umount -l /before
  su - user -c "bash -e commands" || exit $?' fresh "$machine" &
trap 'kill -KILL $! 2>/dev/null; exit 130' INT TERM
wait $!
