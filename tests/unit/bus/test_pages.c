/* SPDX-License-Identifier: MIT */
/* Huge pages for a block of memory: the content and everything around the block stay as they are. */
#define _GNU_SOURCE
#include "bus/pages.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>

#include "support/wire.h"

enum { HUGE = ECT_PAGES_HUGE, ROOM = 6 * HUGE, PATTERN = 512 };

static uint8_t *room; /* begins at a huge page */

static void map_room(void)
{
    uint8_t *mapped = mmap(NULL, ROOM + HUGE, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    assert_ptr_not_equal(mapped, MAP_FAILED);
    room = mapped + (HUGE - (uintptr_t)mapped % HUGE) % HUGE;
    for (size_t at = 0; at < ROOM; at += PATTERN)
        room[at] = (uint8_t)(at / PATTERN + at / 4096);
}

static void unmap_room(void)
{
    assert_int_equal(munmap(room, ROOM), 0);
}

/* Bytes of the mapping around an address that are in huge pages, from /proc/self/smaps. */
static size_t bytes_in_huge_pages(const void *of)
{
    FILE *file = fopen("/proc/self/smaps", "r");
    char line[512];
    uintptr_t begin, end;
    bool inside = false;
    size_t kilobytes, all = 0;
    assert_non_null(file);
    while (fgets(line, sizeof line, file) != NULL) {
        if (sscanf(line, "%" SCNxPTR "-%" SCNxPTR " ", &begin, &end) == 2)
            inside = begin < (uintptr_t)of + ROOM && end > (uintptr_t)of;
        else if (inside && sscanf(line, "AnonHugePages: %zu kB", &kilobytes) == 1)
            all += kilobytes * 1024;
    }
    assert_int_equal(fclose(file), 0);
    return all;
}

static bool system_has_huge_pages(void)
{
    FILE *file = fopen("/sys/kernel/mm/transparent_hugepage/enabled", "r");
    char line[64] = "[never]";
    if (file == NULL)
        return false;
    const bool read = fgets(line, sizeof line, file) != NULL;
    assert_int_equal(fclose(file), 0);
    return read && strstr(line, "[never]") == NULL;
}

static void unchanged(void **state)
{
    static const struct {
        const char *title;
        size_t at, size;
        size_t huge; /* most bytes in huge pages afterwards */
    } rows[] = {
        {"no bytes", HUGE, 0, 0},
        {"less than a huge page", HUGE, HUGE - 1, 0},
        {"two halves of huge pages", HUGE / 2, HUGE, 0},
        {"one byte less than two huge pages", 1, 2 * HUGE - 1, HUGE},
        {"one huge page, and unaligned ends", HUGE - 3, HUGE + 6, HUGE},
        {"three huge pages", HUGE, 3 * HUGE, 3 * HUGE},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        map_room();
        assert_int_equal(madvise(room, ROOM, MADV_NOHUGEPAGE), 0);
        errno = 77;
        ect_pages_make_huge(room + rows[i].at, rows[i].size);
        assert_int_equal(errno, 77);
        if (bytes_in_huge_pages(room) > rows[i].huge)
            fail_msg("%s: %zu bytes in huge pages, at most %zu expected", rows[i].title, bytes_in_huge_pages(room),
                     rows[i].huge);
        for (size_t at = 0; at < ROOM; at += PATTERN)
            if (room[at] != (uint8_t)(at / PATTERN + at / 4096))
                fail_msg("%s: another byte at %zu", rows[i].title, at);
        unmap_room();
    }
}

/* The pages below are empty before: a system with huge pages gives one at the first write. */
static void huge_at_next_use(void **state)
{
    (void)state;
    if (!system_has_huge_pages())
        skip();
    map_room();
    assert_int_equal(madvise(room, ROOM, MADV_DONTNEED), 0);
    ect_pages_make_huge(room, ROOM);
    for (size_t at = 0; at < ROOM; at += PATTERN)
        room[at] = 1;
    assert_true(bytes_in_huge_pages(room) > 0);
    unmap_room();
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"the content of a block, its surroundings and errno stay unchanged", unchanged, NULL, NULL, NULL},
        {"an empty page of a block is a huge one from its next use", huge_at_next_use, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Huge pages", tests, NULL, NULL);
}
