/* SPDX-License-Identifier: MIT */
/*
 * A board's firmware is renewed over FoE, as SOEM's firm_update does it.
 *
 * usage: test_update IFACE FILE BEFORE AFTER [TEST]
 * The slave is called BEFORE, and AFTER when it runs what is in FILE. The tests follow each other.
 */
#include <stdio.h>
#include <string.h>

#include "soem.h"

enum { SLAVE = 1, MOST = 1 << 20, TIMEOUT_US = 5000000, HEADER = 16 };

static const char *iface, *before, *after;
static char file_name[] = "firmware";
static soem_t master;
static uint8_t file[MOST];
static int size;

static void expect_name(const char *name)
{
    soem_open(&master, iface, 1);
    assert_string_equal(master.slaves[SLAVE].name, name);
}

static int send(int bytes)
{
    expect_name(before);
    soem_boot(&master, SLAVE);
    int result = ecx_FOEwrite(&master.context, SLAVE, file_name, 0, bytes, file, TIMEOUT_US);
    soem_close(&master);
    return result;
}

/* None of these counts: the slave stays what it is, through the way back to INIT. */
static void damaged(void **state)
{
    static const struct {
        const char *what;
        int at; /* which byte is another one */
        int less;
    } rows[] = {{"its magic number", 0, 0},
                {"the address that it is for", 13, 0},
                {"its first byte", HEADER, 0},
                {"a byte in it", HEADER + 5000, 0},
                {"its end", -1, 100}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        if (rows[i].at >= 0)
            file[rows[i].at] ^= 0x10;
        if (send(size - rows[i].less) > 0)
            fail_msg("a file that lacks %s was taken", rows[i].what);
        if (rows[i].at >= 0)
            file[rows[i].at] ^= 0x10;
    }
    expect_name(before);
    soem_close(&master);
}

static bool is_there(void)
{
    bool found = false;
    if (ecx_init(&master.context, iface) > 0)
        found = ecx_config_init(&master.context, FALSE) == 1;
    ecx_close(&master.context);
    return found;
}

static void renewed(void **state)
{
    (void)state;
    assert_true(send(size) > 0);
    for (int tries = 0; tries < 100 && !is_there(); tries++)
        osal_usleep(50000);
    expect_name(after);
    soem_map(&master);
    soem_operational(&master);
    for (int n = 0; n < 100; n++)
        assert_int_equal(soem_cycle(&master), soem_expected_wkc(&master));
    soem_close(&master);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"FoE onto a board: a damaged firmware is refused, and the old one stays", damaged, NULL, NULL, NULL},
        {"FoE onto a board: a new firmware runs after the way back to INIT", renewed, NULL, NULL, NULL},
    };
    if (argc < 5)
        return 1;
    iface = argv[1];
    before = argv[3];
    after = argv[4];
    FILE *from = fopen(argv[2], "rb");
    size = from ? (int)fread(file, 1, sizeof file, from) : 0;
    if (from)
        (void)fclose(from);
    if (argc > 5)
        cmocka_set_test_filter(argv[5]);
    return cmocka_run_group_tests_name("update", tests, NULL, NULL);
}
