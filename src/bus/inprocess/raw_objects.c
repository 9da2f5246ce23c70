/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bus/inprocess/raw_objects.h"

#include <link.h>
#include <string.h>

enum { WINDOW = 64 };

/* @return whether an instruction loads RAX: `mov $imm,%eax` with a small number, `xor %eax,%eax`, `push $imm; pop
 * %rax`, or a move from a register or from memory */
static bool loads_number(const uint8_t *at)
{
    switch (at[0]) {
    case 0xB8:
        return at[2] <= 2 && at[3] == 0 && at[4] == 0;
    case 0x31:
        return at[1] == 0xC0;
    case 0x6A:
        return at[2] == 0x58;
    case 0x89:
        return (at[1] & 0xC7) == 0xC0;
    case 0x8B:
        return (at[1] & 0x38) == 0 && at[1] < 0xC0;
    case 0x63:
        return (at[1] & 0xF8) == 0xC0;
    default:
        return false;
    }
}

/* @return whether the bytes are part of an offset: of 16 bits, followed by bytes with which no instruction after a
 * system call begins, or of 24 bits in a call or jump */
static bool is_offset(const uint8_t *text, size_t at, size_t length)
{
    const uint8_t *behind = text + at + 2;
    if (length - at < 4 || behind[0] == 0 || (behind[0] == 0xFF && behind[1] == 0xFF))
        return true;
    bool jumps = at > 0 && (text[at - 1] == 0xE8 || text[at - 1] == 0xE9);
    return jumps && (behind[1] == 0 || behind[1] == 0xFF);
}

/* @return whether the bytes are rt_sigreturn: libgcc contains them as a constant, and a restorer alone never blocks */
static bool is_return(const uint8_t *text, size_t at)
{
    return at >= 4 && memcmp(text + at - 4, "\x0F\0\0", 4) == 0;
}

static bool is_call(const uint8_t *text, size_t at, size_t length)
{
    if (text[at] != 0x0F || is_offset(text, at, length) || is_return(text, at))
        return false;
    for (size_t before = at > WINDOW ? at - WINDOW : 0; before < at; before++) {
        if (loads_number(text + before))
            return true;
    }
    return false;
}

bool ect_text_has_call(const uint8_t *text, size_t length)
{
    size_t from = 1;
    while (from < length) {
        const uint8_t *second = memchr(text + from, 0x05, length - from);
        if (!second)
            return false;
        size_t at = (size_t)(second - text) - 1;
        if (is_call(text, at, length))
            return true;
        from = at + 2;
    }
    return false;
}

typedef enum kind { PROGRAM, C_LIBRARY, PASSED, OWN } kind_t;

static kind_t kind_of(const char *path)
{
    static const struct {
        const char *name;
        kind_t kind;
    } kinds[] = {{"libc.so.", C_LIBRARY}, {"ld-linux", PASSED},   {"linux-vdso", PASSED},  {"libasan.so", PASSED},
                 {"libtsan.so", PASSED},  {"liblsan.so", PASSED}, {"libubsan.so", PASSED}, {"libectwin", OWN}};
    const char *slash = strrchr(path, '/');
    const char *name = slash ? slash + 1 : path;
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
        if (strncmp(name, kinds[i].name, strlen(kinds[i].name)) == 0)
            return kinds[i].kind;
    }
    return PROGRAM;
}

static void add_text(ect_objects_t *its, kind_t kind, ect_text_t text)
{
    if (kind == C_LIBRARY)
        its->c_library = text;
    else if (kind == PASSED && its->passed_count < ECT_TEXTS_MOST)
        its->passed[its->passed_count++] = text;
    else if (kind == PROGRAM && !its->has_calls)
        its->has_calls = ect_text_has_call((const uint8_t *)text.begin, text.end - text.begin);
}

typedef struct search {
    ect_objects_t *its;
    unsigned long long before; /* number of objects at the last search */
} search_t;

static int add_object(struct dl_phdr_info *info, size_t size, void *ctx)
{
    search_t *search = ctx;
    (void)size;
    if (info->dlpi_adds == search->before)
        return 1;
    search->its->adds = info->dlpi_adds;
    for (size_t i = 0; i < info->dlpi_phnum; i++) {
        const ElfW(Phdr) *part = &info->dlpi_phdr[i];
        uintptr_t begin = info->dlpi_addr + part->p_vaddr;
        if (part->p_type == PT_LOAD && (part->p_flags & PF_X) != 0 && (part->p_flags & PF_R) != 0)
            add_text(search->its, kind_of(info->dlpi_name), (ect_text_t){begin, begin + part->p_filesz});
    }
    return 0;
}

void ect_objects_search(ect_objects_t *its)
{
    ect_objects_t fresh = {.has_calls = its->has_calls};
    search_t search = {.its = &fresh, .before = its->adds};
    (void)dl_iterate_phdr(add_object, &search);
    if (fresh.adds != 0)
        *its = fresh;
}

bool ect_objects_pass(const ect_objects_t *its, const void *address)
{
    for (size_t i = 0; i < its->passed_count; i++) {
        if ((uintptr_t)address >= its->passed[i].begin && (uintptr_t)address <= its->passed[i].end)
            return true;
    }
    return false;
}
