/* SPDX-License-Identifier: MIT */
/*
 * A firmware that is started again has the values that it stored for 1010h.
 * usage: test_kept IFACE store|find     the slave is a PMCtendo; each of the two with a start of its own
 */
#include <stdio.h>
#include <string.h>

#include "soem.h"

enum { WINDOW = 0x6067, STORE = 0x1010, OURS = 471100, ANOTHER = 815 };

static const char *iface;
static soem_t master;

static int open_master(void **state)
{
    (void)state;
    soem_open(&master, iface, 1);
    return 0;
}

static int close_master(void **state)
{
    (void)state;
    soem_close(&master);
    return 0;
}

static void write_window(uint32 value)
{
    uint32 wire = htoel(value);
    assert_int_equal(soem_write(&master, 1, WINDOW, 0, false, &wire, sizeof wire), 0);
}

static void keep(uint32 value)
{
    write_window(value);
    assert_int_equal(soem_write(&master, 1, STORE, 1, false, "save", 4), 0);
}

/* A value written after the save is not stored. */
static void store(void **state)
{
    (void)state;
    keep(OURS);
    write_window(ANOTHER);
}

/* Leaves another value, so that the next run cannot find the value of this run. */
static void find(void **state)
{
    uint32 wire = 0;
    int size = sizeof wire;
    (void)state;
    assert_int_equal(soem_read(&master, 1, WINDOW, 0, false, &wire, &size), 0);
    assert_int_equal(etohl(wire), OURS);
    keep(ANOTHER);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest stores[] = {{"CF-081: a firmware stores", store, open_master, close_master, NULL}};
    const struct CMUnitTest finds[] = {
        {"CF-081: stored values are restored at power-on", find, open_master, close_master, NULL}};
    if (argc != 3) {
        fprintf(stderr, "usage: test_kept IFACE store|find\n");
        return 2;
    }
    iface = argv[1];
    if (strcmp(argv[2], "store") == 0)
        return cmocka_run_group_tests_name("stored", stores, NULL, NULL);
    return cmocka_run_group_tests_name("kept", finds, NULL, NULL);
}
