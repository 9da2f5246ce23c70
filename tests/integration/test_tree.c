/* SPDX-License-Identifier: MIT */
/*
 * SOEM's own scan of a tree of twins: the parent of each twin, the number of its open ports; and its result while a
 * wire is cut.
 *
 * usage: test_tree IFACE ECTWIN      with twins wired as in tests/integration/CMakeLists.txt
 */
#define _DEFAULT_SOURCE
#include <stdio.h>
#include <stdlib.h>

#include "soem.h"

enum { TWINS = 5 };

static const char *iface, *ectwin;

/* As wired: 2 behind port 3 of 1, 3 behind 2, 4 behind port 1 of 1, 5 behind port 2 of 1. */
static const struct {
    int parent, ports;
} tree[TWINS + 1] = {{0, 0}, {0, 4}, {1, 2}, {2, 1}, {1, 1}, {1, 1}};

static void command(const char *what)
{
    char line[512];
    snprintf(line, sizeof line, "'%s' %s", ectwin, what);
    assert_int_equal(system(line), 0);
}

static void expect_tree(soem_t *m)
{
    for (int i = 1; i <= TWINS; i++) {
        if (m->slaves[i].parent != tree[i].parent || m->slaves[i].topology != tree[i].ports)
            fail_msg("slave %d: expected parent %d and %d open ports, got %d and %d", i, tree[i].parent, tree[i].ports,
                     m->slaves[i].parent, m->slaves[i].topology);
    }
}

static void scanned(void **state)
{
    static soem_t m;
    (void)state;
    soem_open(&m, iface, TWINS);
    expect_tree(&m);
    soem_close(&m);
}

static void cut_and_mended(void **state)
{
    static const struct {
        const char *cut, *mend;
        int left;
    } rows[] = {
        {"cut 1.3", "mend 1.3", 3}, {"cut 3.0", "mend 3.0", 4}, {"unplug 2", "plug 2", 3}, {"cut 1.2", "mend 1.2", 4}};
    static soem_t m;
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        command(rows[i].cut);
        soem_open(&m, iface, rows[i].left);
        soem_close(&m);
        command(rows[i].mend);
        soem_open(&m, iface, TWINS);
        expect_tree(&m);
        soem_close(&m);
    }
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"CF-010: SOEM finds the tree that is wired", scanned, NULL, NULL, NULL},
        {"CF-096: SOEM finds those that are left, and all of them once the wire is mended", cut_and_mended, NULL, NULL,
         NULL},
    };
    if (argc < 3)
        return 2;
    iface = argv[1];
    ectwin = argv[2];
    return cmocka_run_group_tests_name("SOEM and a tree", tests, NULL, NULL);
}
