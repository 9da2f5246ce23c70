/* SPDX-License-Identifier: MIT */
/*
 * A device with three SoE drives (tests/support/soedev.h) under SOEM: its own reads, writes and mapping by SoE.
 * usage: test_soe_wire IFACE [TEST]
 */
#include <string.h>

#include "soem.h"

enum { SLAVE = 1, VALUE = 0x40, TIMEOUT_US = 3000000, LONG = 300 };

static const char *iface;
static soem_t master;

static uint16 get16(const uint8 *bytes)
{
    return (uint16)(bytes[0] | bytes[1] << 8);
}

static bool write_idn(uint8 drive, uint16 idn, void *data, int size)
{
    return ecx_SoEwrite(&master.context, SLAVE, drive, VALUE, idn, size, data, TIMEOUT_US) > 0 &&
           !ecx_iserror(&master.context);
}

/* @return bytes of the elements, 0: an error */
static int read_idn(uint8 drive, uint8 elements, uint16 idn, uint8 *data, int room)
{
    int size = room;
    const int counter = ecx_SoEread(&master.context, SLAVE, drive, elements, idn, &size, data, TIMEOUT_US);
    return counter > 0 && !ecx_iserror(&master.context) ? size : 0;
}

/* The error code that SOEM has recorded for the last request. */
static uint16 last_error(void)
{
    ec_errort error;
    uint16_t code = 0;
    while (ecx_poperror(&master.context, &error))
        code = error.ErrorCode;
    return code;
}

static void maps_and_runs(void **state)
{
    (void)state;
    soem_open(&master, iface, 1);
    assert_int_equal(master.slaves[SLAVE].mbx_proto, ECT_MBXPROT_SOE);
    soem_map(&master);
    assert_int_equal(master.slaves[SLAVE].Obits, 2 * 80);
    assert_int_equal(master.slaves[SLAVE].Ibits, 2 * 80);
    soem_operational(&master);
    for (uint8 n = 1; n < 100; n++) {
        for (uint8 i = 0; i < 20; i++)
            master.slaves[SLAVE].outputs[i] = (uint8)(n + i);
        assert_int_equal(soem_cycle(&master), soem_expected_wkc(&master));
        osal_usleep(1000);
        assert_int_equal(soem_cycle(&master), soem_expected_wkc(&master));
        for (uint8 drive = 0; drive < 2; drive++)
            assert_memory_equal(master.slaves[SLAVE].inputs + 10 * drive + 2,
                                master.slaves[SLAVE].outputs + 10 * drive + 2, 8);
    }
    soem_close(&master);
}

/* Other lists, written as a configuration tool does, before the mapping is read. */
static void maps_what_was_written(void **state)
{
    uint8 at[] = {6, 0, 6, 0, 84, 0, 40, 0, 51, 0}, mdt[] = {2, 0, 2, 0, 47, 0}, none[] = {2, 0, 2, 0, 99, 0};
    uint8 cycle[] = {0xE8, 0x03};
    (void)state;
    soem_open(&master, iface, 1);
    assert_true(write_idn(0, 1, cycle, sizeof cycle));
    assert_true(write_idn(0, 16, at, sizeof at));
    assert_true(write_idn(1, 24, mdt, sizeof mdt));
    assert_false(write_idn(1, 24, none, sizeof none));
    (void)last_error();
    soem_map(&master);
    assert_int_equal(master.slaves[SLAVE].Obits, 80 + 48);
    assert_int_equal(master.slaves[SLAVE].Ibits, 96 + 80);
    soem_operational(&master);
    soem_close(&master);
}

static void reads_and_writes(void **state)
{
    uint8 data[LONG] = {0}, got[LONG + 8], one[] = {1, 0};
    (void)state;
    soem_open(&master, iface, 1);
    assert_int_equal(read_idn(0, 0x02, 1, got, sizeof got), 4 + 13);
    assert_memory_equal(got + 4, "NC cycle time", 13);
    assert_int_equal(read_idn(1, 0x44, 36, got, sizeof got), 8);
    assert_int_equal(get16(got), 1); /* attribute 60220001h */
    assert_int_equal(get16(got + 2), 0x6022);
    data[0] = (LONG - 4) & 0xFF;
    data[1] = (LONG - 4) >> 8;
    for (unsigned int i = 4; i < LONG; i += 2)
        data[i] = 51;
    assert_true(write_idn(2, 16, data, LONG));
    memset(got, 0xFF, sizeof got);
    assert_int_equal(read_idn(2, VALUE, 16, got, sizeof got), LONG);
    assert_memory_equal(got + 4, data + 4, LONG - 4);
    assert_int_equal(read_idn(0, VALUE, 999, got, sizeof got), 0);
    assert_int_equal(last_error(), 0x1001);
    assert_int_equal(read_idn(7, VALUE, 16, got, sizeof got), 0);
    assert_int_equal(last_error(), 0x800A);
    assert_false(write_idn(0, 1, one, sizeof one));
    soem_close(&master);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"SOE-036 SOE-037 SOEM maps drives by S-0-0024 and S-0-0016 and brings them to OP", maps_and_runs, NULL, NULL,
         NULL},
        {"SOE-034 SOE-038 SOEM maps the lists that were written", maps_what_was_written, NULL, NULL, NULL},
        {"SOE-004 SOE-013 SOE-014 SOEM reads and writes, in pieces too", reads_and_writes, NULL, NULL, NULL},
    };
    if (argc < 2)
        return 2;
    iface = argv[1];
    if (argc > 2)
        cmocka_set_test_filter(argv[2]);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
