/* SPDX-License-Identifier: MIT */
/* One base unit driven by SOEM.  usage: test_base_unit IFACE NAME INPUT_BYTES OUTPUT_BYTES [TEST] */
#include <stdlib.h>
#include <string.h>

#include "soem.h"

static const char *iface;
static const char *name;
static unsigned int input_bytes, output_bytes;
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

static void identity_from_sii_and_coe(void **state)
{
    (void)state;
    char text[64] = "";
    int size = sizeof text - 1;
    assert_string_equal(master.slaves[1].name, name);
    assert_int_equal(soem_read(&master, 1, 0x1008, 0, false, text, &size), 0);
    assert_string_equal(text, name);
    const uint32 sii[] = {master.slaves[1].eep_man, master.slaves[1].eep_id, master.slaves[1].eep_rev};
    for (uint8 sub = 1; sub <= 3; sub++) {
        uint32 value = 0;
        size = sizeof value;
        assert_int_equal(soem_read(&master, 1, 0x1018, sub, false, &value, &size), 0);
        assert_int_equal(value, sii[sub - 1]);
    }
}

static void sizes(void)
{
    assert_int_equal(master.slaves[1].Ibytes, input_bytes);
    assert_int_equal(master.slaves[1].Obytes, output_bytes);
}

static void sizes_from_coe(void **state)
{
    (void)state;
    soem_map(&master);
    sizes();
}

static void sizes_without_complete_access(void **state)
{
    (void)state;
    master.slaves[1].CoEdetails &= (uint8)~ECT_COEDET_SDOCA;
    soem_map(&master);
    sizes();
}

static void sizes_from_sii(void **state)
{
    (void)state;
    master.slaves[1].mbx_proto = 0;
    soem_map(&master);
    sizes();
    soem_operational(&master);
    assert_int_equal(soem_cycle(&master), soem_expected_wkc(&master));
}

static void up_and_down(void **state)
{
    static const uint16 walk[] = {EC_STATE_SAFE_OP, EC_STATE_PRE_OP, EC_STATE_INIT};
    (void)state;
    soem_map(&master);
    soem_operational(&master);
    soem_go(&master, 1, EC_STATE_SAFE_OP);
    soem_cycle(&master);
    soem_operational(&master);
    for (size_t i = 0; i < sizeof walk / sizeof walk[0]; i++)
        soem_go(&master, 1, walk[i]);
}

static void no_lost_frames(void **state)
{
    (void)state;
    soem_map(&master);
    soem_operational(&master);
    for (int i = 0; i < 1000; i++)
        assert_int_equal(soem_cycle(&master), soem_expected_wkc(&master));
    ecx_readstate(&master.context);
    assert_int_equal(master.slaves[1].state, EC_STATE_OPERATIONAL);
}

static uint8 pci_start;

static bool pci_moved(soem_t *m)
{
    return m->slaves[1].inputs[0] != pci_start;
}

static bool acknowledged(soem_t *m)
{
    const uint8 *in = m->slaves[1].inputs;
    const uint8 *out = m->slaves[1].outputs;
    return in[3] == out[1] && in[2] == out[0];
}

static void counters(void **state)
{
    (void)state;
    soem_map(&master);
    soem_operational(&master);
    pci_start = master.slaves[1].inputs[0];
    assert_true(soem_until(&master, pci_moved, 2000));
    if (output_bytes == 0)
        return;
    master.slaves[1].outputs[0] = 0x42; /* PCO */
    master.slaves[1].outputs[1]++;      /* CCO */
    assert_true(soem_until(&master, acknowledged, 1000));
}

/* 2002h and 2003h show the bytes that the master writes at an offset: the image is TS-0007's, byte for byte. */
static void output_offsets(void **state)
{
    static const struct {
        uint16 index;
        uint8 subindex;
        uint8 offset;
        uint8 bytes;
    } fields[] = {
        {0x2002, 1, 0, 1},   {0x2002, 2, 1, 1},  {0x2002, 3, 2, 1},  {0x2002, 4, 3, 1},    {0x2002, 5, 4, 2},
        {0x2002, 6, 6, 8},   {0x2002, 7, 14, 8}, {0x2002, 8, 22, 2}, {0x2002, 9, 24, 2},   {0x2002, 10, 26, 1},
        {0x2002, 11, 27, 1}, {0x2003, 1, 28, 8}, {0x2003, 2, 36, 8}, {0x2003, 13, 124, 8}, {0x2003, 25, 220, 8},
    };
    (void)state;
    soem_map(&master);
    soem_operational(&master);
    for (unsigned int i = 0; i < output_bytes; i++)
        master.slaves[1].outputs[i] = (uint8)(i ^ 0x5A);
    for (int i = 0; i < 5; i++)
        soem_cycle(&master);
    for (size_t i = 0; i < sizeof fields / sizeof fields[0]; i++) {
        uint8 data[16];
        int size = sizeof data;
        if (fields[i].offset >= output_bytes)
            continue;
        assert_int_equal(soem_read(&master, 1, fields[i].index, fields[i].subindex, false, data, &size), 0);
        assert_int_equal(size, fields[i].bytes);
        assert_memory_equal(data, master.slaves[1].outputs + fields[i].offset, fields[i].bytes);
        soem_cycle(&master);
    }
}

static void wrong_requests(void **state)
{
    static const struct {
        uint16 request, status, code;
    } rows[] = {
        {EC_STATE_OPERATIONAL, EC_STATE_PRE_OP | EC_STATE_ERROR, 0x0011},
        {EC_STATE_BOOT, EC_STATE_PRE_OP | EC_STATE_ERROR, 0x0011},
        {0x0F, EC_STATE_PRE_OP | EC_STATE_ERROR, 0x0012},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint16 code;
        assert_int_equal(soem_request(&master, 1, rows[i].request, &code), rows[i].status);
        assert_int_equal(code, rows[i].code);
        soem_go(&master, 1, EC_STATE_PRE_OP);
    }
    bool has_boot =
        ecx_readeeprom(&master.context, 1, ECT_SII_BOOTRXMBX, EC_TIMEOUTEEP) >> 16 != 0; /* a board that is updated */
    soem_go(&master, 1, EC_STATE_INIT);
    uint16 code;
    assert_int_equal(soem_request(&master, 1, EC_STATE_BOOT, &code),
                     has_boot ? EC_STATE_BOOT : EC_STATE_INIT | EC_STATE_ERROR);
    assert_int_equal(code, has_boot ? 0 : 0x0013);
}

static void write_sm_length(uint16 sm, uint16 length)
{
    uint16 station = master.slaves[1].configadr;
    uint8 off = 0, on = 1;
    ecx_FPWR(&master.port, station, (uint16)(ECT_REG_SM0 + 8 * sm + 6), 1, &off, EC_TIMEOUTRET3);
    ecx_FPWRw(&master.port, station, (uint16)(ECT_REG_SM0 + 8 * sm + 2), htoes(length), EC_TIMEOUTRET3);
    ecx_FPWR(&master.port, station, (uint16)(ECT_REG_SM0 + 8 * sm + 6), 1, &on, EC_TIMEOUTRET3);
}

static void wrong_lengths(void **state)
{
    (void)state;
    uint16 code;
    ecx_config_map_group(&master.context, master.image, 0);
    if (output_bytes > 0) {
        write_sm_length(2, (uint16)(output_bytes + 1));
        assert_int_equal(soem_request(&master, 1, EC_STATE_SAFE_OP, &code), EC_STATE_PRE_OP | EC_STATE_ERROR);
        assert_int_equal(code, 0x001D);
        write_sm_length(2, (uint16)output_bytes);
        soem_go(&master, 1, EC_STATE_PRE_OP);
    }
    write_sm_length(3, (uint16)(input_bytes - 1));
    assert_int_equal(soem_request(&master, 1, EC_STATE_SAFE_OP, &code), EC_STATE_PRE_OP | EC_STATE_ERROR);
    assert_int_equal(code, 0x001E);
    soem_go(&master, 1, EC_STATE_INIT);
    write_sm_length(0, 8);
    assert_int_equal(soem_request(&master, 1, EC_STATE_PRE_OP, &code), EC_STATE_INIT | EC_STATE_ERROR);
    assert_int_equal(code, 0x0016);
}

/* Every object that SDO information lists, every sub-index: singly, and as a whole where it has no strings. */
static void every_object(void **state)
{
    static ec_ODlistt list;
    static ec_OElistt entries;
    (void)state;
    memset(&list, 0, sizeof list);
    list.Slave = 1;
    assert_true(ecx_readODlist(&master.context, 1, &list) > 0);
    assert_true(list.Entries >= 10);
    for (uint16 i = 0; i < list.Entries; i++) {
        assert_true(ecx_readODdescription(&master.context, i, &list) > 0);
        assert_true(ecx_readOE(&master.context, i, &list, &entries) > 0);
        uint8 whole[1024] = {0};
        int size = sizeof whole;
        uint32 abort_code = soem_read(&master, 1, list.Index[i], 0, true, whole, &size);
        bool text = entries.DataType[0] == ECT_VISIBLE_STRING;
        assert_int_equal(abort_code, text ? 0x06010004 : 0);
        size_t at = list.ObjectCode[i] == 7 ? 0 : 2;
        for (unsigned int sub = 0; sub <= list.MaxSub[i]; sub++) {
            uint8 data[256] = {0};
            size = sizeof data;
            assert_int_equal(soem_read(&master, 1, list.Index[i], (uint8)sub, false, data, &size), 0);
            bool live = list.Index[i] == 0x2001 || list.Index[i] == 0x3001; /* inputs: change every 125 ms */
            if (!text && sub > 0 && !live)
                assert_memory_equal(whole + at, data, (size_t)size);
            at += sub > 0 ? (size_t)size : 0;
        }
    }
}

static void refused_sdos(void **state)
{
    (void)state;
    uint8 data[8] = {0};
    int size = sizeof data;
    assert_int_equal(soem_write(&master, 1, 0x1000, 0, false, data, 4), 0x06010002);
    assert_int_equal(soem_write(&master, 1, 0x1C12, 0, false, data, 1), 0x06010002);
    assert_int_equal(soem_write(&master, 1, 0x1A00, 1, false, data, 4), 0x06010002);
    assert_int_equal(soem_read(&master, 1, 0x5555, 0, false, data, &size), 0x06020000);
    assert_int_equal(soem_read(&master, 1, 0x1018, 5, false, data, &size), 0x06090011);
    size = 4;
    assert_int_equal(soem_read(&master, 1, 0x1018, 1, false, data, &size), 0);
}

static void sdo_traffic_under_process_data(void **state)
{
    (void)state;
    soem_map(&master);
    soem_operational(&master);
    for (int i = 0; i < 500; i++) {
        uint32 value = 0;
        int size = sizeof value;
        uint8 sub = (uint8)(1 + i % 3);
        assert_int_equal(soem_exchange(&master), soem_expected_wkc(&master));
        assert_int_equal(soem_read(&master, 1, 0x1018, sub, false, &value, &size), 0);
        uint32 want = sub == 1   ? master.slaves[1].eep_man
                      : sub == 2 ? master.slaves[1].eep_id
                                 : master.slaves[1].eep_rev;
        assert_int_equal(value, want);
    }
}

#define TEST(title, function) {title, function, open_master, close_master, NULL}

int main(int argc, char **argv)
{
    if (argc < 5)
        return 1;
    iface = argv[1];
    name = argv[2];
    input_bytes = (unsigned int)atoi(argv[3]);
    output_bytes = (unsigned int)atoi(argv[4]);
    if (argc > 5)
        cmocka_set_test_filter(argv[5]);
    const struct CMUnitTest tests[] = {
        TEST("ECL-001 CF-057: name and identity in the SII equal 1008h and 1018h", identity_from_sii_and_coe),
        TEST("ECL-006..009 ECL-010: sizes from CoE by Complete Access", sizes_from_coe),
        TEST("ECL-006..009: sizes from CoE by single accesses", sizes_without_complete_access),
        TEST("ECL-006..009 CF-061: sizes from the SII alone, and OP with them", sizes_from_sii),
        TEST("CF-033: every transition up and down", up_and_down),
        TEST("ECL-011 ECL-012: by position and station to OP, then 1000 logical cycles, none lost", no_lost_frames),
        TEST("ECL-020 ECL-024 ECL-025: PCI counts, PCO and CCO are acknowledged", counters),
        TEST("ECL-050..055: outputs are at TS-0007's offsets", output_offsets),
        TEST("CF-034 CF-035: wrong state requests are refused with 0x0011, 0x0012, 0x0013", wrong_requests),
        TEST("CF-036 CF-037: wrong SM lengths are refused with 0x0016, 0x001D, 0x001E", wrong_lengths),
        TEST("CF-067 CF-073 CF-076: every object is described and readable, singly and as a whole", every_object),
        TEST("CF-070: read-only, unknown object and unknown sub-index give their abort codes", refused_sdos),
        TEST("CF-083: 500 SDOs between process data, none lost or mixed", sdo_traffic_under_process_data),
    };
    return cmocka_run_group_tests_name(name, tests, NULL, NULL);
}
