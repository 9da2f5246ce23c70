#!/usr/bin/env bash
# A device links the mailbox protocols and object services that it names, and no others.  usage: linked.sh SRC
set -eu
src=$1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
status=0
compile="${CC:-cc} -std=c11 -O1 -DNDEBUG -I$src"
for source in "$src"/{od,slave}/*.c; do
  $compile -c "$source" -o "$work/$(basename "$(dirname "$source")")_$(basename "$source" .c).o"
done
ar rcs "$work/stack.a" "$work"/*.o
all=$(cd "$src" && grep -ohP 'extern const ect_(protocol|service)_t \Kect_\w+' seams/mailbox.h seams/services.h | sort)
[ "$(echo "$all" | wc -l)" -ge 7 ] || { echo "hardly a protocol or service in seams/"; exit 1; }

# names WANTED...: a firmware whose device names these has these, no others, and no CoE without a protocol of it.
names() {
  cat >"$work/main.c" <<END
#include "slave/slave.h"
static const ect_protocol_t *const protocols[] = {$(printf '&%s, ' "$@" | grep -o '&ect_protocol_[a-z_]*, ' | tr -d '\n') NULL};
static const ect_service_t *const services[] = {$(printf '&%s, ' "$@" | grep -o '&ect_service_[a-z_]*, ' | tr -d '\n') NULL};
static const ect_device_t device = {.protocols = protocols, .services = services};
int main(void)
{
    static ect_slave_t slave;
    return ect_slave_init(&slave, &(ect_slave_config_t){.device = &device}, 0) + (int)ect_slave_poll(&slave, 1);
}
END
  $compile "$work/main.c" "$work/stack.a" -o "$work/main"
  local found wanted
  found=$(nm "$work/main" | awk '{print $NF}' | grep -E '^ect_(protocol|service)_' | sort)
  wanted=$(printf '%s\n' "$@" | sed '/^$/d' | sort)
  if [ "$found" != "$wanted" ]; then
    echo "named: ${wanted:-nothing}; linked: ${found:-nothing}"
    status=1
  fi
  case "$*" in *ect_protocol_*) ;; *)
    if nm "$work/main" | grep -qE ' ect_coe_'; then
      echo "no protocol is named, and CoE is linked all the same"
      status=1
    fi ;;
  esac
}

names ''
for one in $all; do
  names "$one"
done
# shellcheck disable=SC2086
names $all
exit $status
