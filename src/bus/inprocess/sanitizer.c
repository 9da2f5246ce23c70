/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bus/inprocess/sanitizer.h"

#include <link.h>
#include <stdint.h>
#include <string.h>

typedef struct range {
    uintptr_t begin, end;
} range_t;

static int find(struct dl_phdr_info *info, size_t size, void *ctx)
{
    range_t *found = ctx;
    (void)size;
    if (!strstr(info->dlpi_name, "/libasan.so") && !strstr(info->dlpi_name, "/libtsan.so") &&
        !strstr(info->dlpi_name, "/liblsan.so"))
        return 0;
    for (size_t i = 0; i < info->dlpi_phnum; i++) {
        uintptr_t begin = info->dlpi_addr + info->dlpi_phdr[i].p_vaddr;
        if (info->dlpi_phdr[i].p_type == PT_LOAD && (info->dlpi_phdr[i].p_flags & PF_X) != 0)
            *found = (range_t){begin, begin + info->dlpi_phdr[i].p_memsz};
    }
    return 1;
}

static range_t code(void)
{
    static bool searched;
    static range_t its;
    if (!searched) {
        searched = true;
        (void)dl_iterate_phdr(find, &its);
    }
    return its;
}

bool ect_sanitizer_is_loaded(void)
{
    return code().end != 0;
}

bool ect_sanitizer_has(const void *address)
{
    range_t its = code();
    return (uintptr_t)address >= its.begin && (uintptr_t)address < its.end;
}
