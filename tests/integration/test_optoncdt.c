/* SPDX-License-Identifier: MIT */
/*
 * The requirements of A 7.2.5, A 7.2.6 and public pages of the manual, tested by SOEM on the wire and in real time; the
 * test plays the plant through the control socket.
 * usage: test_optoncdt IFACE [TEST [no-plant]]     no-plant: a board, without signals; it is as at power-on
 */
#define _DEFAULT_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "plant.h"
#include "soem.h"

enum { PATIENCE = 20000 /* cycles that a change may take on a busy machine */ };
enum { VALUES = 13, FIRST_CHOICE = 4, MM = 1000000, SM3 = 3 };
enum { COUNTER = 1 << 1, TIMESTAMP = 1 << 2, INTENSITY = 1 << 4, DISTANCE1 = 1 << 5, DISTANCE2 = 1 << 7, ALL = 0x1FFF };

static const char *iface;
static bool played = true;
static soem_t master;

static const char defaults[] = "laser=1 range=20 exposure=50 temperature=25 rate=10000 laser_power=0 default_user=0 "
                               "surface1.present=1 surface1.distance=10 surface1.source=0 surface1.noise=0 "
                               "surface1.intensity=50 surface1.fault=0 surface2.present=0 row_clear=1 seed=1";

/* --- helpers ------------------------------------------------------------------------------------------------------ */

static uint32 read_number(uint16 index, uint8 subindex, uint32 *value)
{
    int size = sizeof *value;
    *value = 0;
    return soem_read(&master, 1, index, subindex, false, value, &size);
}

static uint32 number(uint16 index, uint8 subindex)
{
    uint32 value;
    uint32 code = read_number(index, subindex, &value);
    if (code != 0)
        fail_msg("%04Xh:%u cannot be read: %08X", index, subindex, code);
    return value;
}

static uint32 write_number(uint16 index, uint8 subindex, uint32 value, int size)
{
    uint32 wire = htoel(value);
    return soem_write(&master, 1, index, subindex, false, &wire, size);
}

static void set(uint16 index, uint8 subindex, uint32 value, int size)
{
    uint32 code = write_number(index, subindex, value, size);
    if (code != 0)
        fail_msg("%04Xh:%u := %u: %08X", index, subindex, value, code);
}

static uint32 log_in(const char *password)
{
    return soem_write(&master, 1, 0x2001, 2, false, password, (int)strlen(password));
}

/* In PREOP: the measurements of the mask are sent, `samples` records at a time. */
static void choose(uint32 measurements, uint8 samples)
{
    set(0x1C13, 0, 0, 1);
    for (uint8 n = 0; n < VALUES; n++)
        set(0x21B0, (uint8)(FIRST_CHOICE + n), measurements >> n & 1, 1);
    for (uint8 n = 0; n < samples; n++)
        set(0x1C13, (uint8)(n + 1), 0x1A00u + n, 2);
    set(0x1C13, 0, samples, 1);
}

static int32_t value(unsigned int n)
{
    int32 wire;
    assert_true((n + 1) * sizeof wire <= master.slaves[1].Ibytes);
    memcpy(&wire, master.slaves[1].inputs + n * sizeof wire, sizeof wire);
    return (int32_t)etohl((uint32)wire);
}

/* Cycles until value `n` of the process data is `want`. */
static void await(unsigned int n, int32_t want)
{
    int left = PATIENCE;
    do
        soem_cycle(&master);
    while (value(n) != want && left-- > 0);
    if (left < 0)
        fail_msg("value %u: expected %d (%08X), in vain; it is %d (%08X)", n, want, (uint32_t)want, value(n),
                 (uint32_t)value(n));
}

static int open_master(void **state)
{
    (void)state;
    soem_open(&master, iface, 1);
    if (played)
        plant_set_all(defaults);
    return 0;
}

/* PREOP, the expert logged in, and the mapping of the factory. */
static int open_expert(void **state)
{
    open_master(state);
    assert_int_equal(log_in("000"), 0);
    choose(DISTANCE1 | DISTANCE2, 1);
    return 0;
}

static int open_operational(void **state)
{
    open_expert(state);
    soem_map(&master);
    soem_operational(&master);
    await(0, 10 * MM);
    return 0;
}

static int close_master(void **state)
{
    (void)state;
    soem_close(&master);
    return 0;
}

/* --- states ------------------------------------------------------------------------------------------------------- */

static void states(void **state)
{
    (void)state;
    uint32 vendor;
    uint8 mail[256] = {0x0A, 0, 0, 0, 0, 0x13, 0, 0x20, 0x40, 0x18, 0x10, 1};
    uint16 station = master.slaves[1].configadr;
    uint8 status = 0xFF, type = 0;
    ecx_readstate(&master.context);
    assert_int_equal(master.slaves[1].state, EC_STATE_PRE_OP); /* where SOEM took it, and no further */
    soem_go(&master, 1, EC_STATE_INIT);
    assert_int_equal(ecx_FPRD(&master.port, station, 0x0000, 1, &type, EC_TIMEOUTRET3), 1); /* registers can be read */
    (void)ecx_FPWR(&master.port, station, 0x1000, sizeof mail, mail, EC_TIMEOUTRET3);
    osal_usleep(20000);
    assert_int_equal(ecx_FPRD(&master.port, station, ECT_REG_SM1 + 5, 1, &status, EC_TIMEOUTRET3), 1);
    assert_int_equal(status & 0x08, 0); /* INIT: a request has no reply */
    soem_go(&master, 1, EC_STATE_PRE_OP);
    assert_int_equal(read_number(0x1018, 1, &vendor), 0);
    assert_int_equal(vendor, master.slaves[1].eep_man);
    soem_map(&master);
    assert_int_equal(master.slaves[1].Obytes, 0);
    assert_int_equal(master.slaves[1].Ibytes, 8);
    await(0, 10 * MM); /* SAFEOP: inputs run, and so does the mailbox */
    assert_int_equal(read_number(0x1018, 1, &vendor), 0);
    soem_operational(&master);
    plant_set("surface1.distance", "11");
    await(0, 11 * MM);
    assert_int_equal(read_number(0x1018, 1, &vendor), 0);
}

/* SM2 is unused: SOEM leaves it off because of its type. SM3 with another configuration than described is refused. */
static void sync_managers(void **state)
{
    (void)state;
    uint16 station = master.slaves[1].configadr, code = 0;
    uint8 activate = 0xFF;
    assert_int_equal(number(0x1C00, 3), 0);
    assert_int_equal(number(0x1C00, 4), 4);
    soem_map(&master);
    assert_int_equal(ecx_FPRD(&master.port, station, ECT_REG_SM0 + 2 * 8 + 6, 1, &activate, EC_TIMEOUTRET3), 1);
    assert_int_equal(activate & 1, 0);
    soem_go(&master, 1, EC_STATE_PRE_OP);
    uint8 off[] = {0}, shorter[] = {4, 0, 0x20, 0, 1};
    assert_int_equal(ecx_FPWR(&master.port, station, ECT_REG_SM0 + SM3 * 8 + 6, 1, off, EC_TIMEOUTRET3), 1);
    assert_int_equal(ecx_FPWR(&master.port, station, ECT_REG_SM0 + SM3 * 8 + 2, 5, shorter, EC_TIMEOUTRET3), 1);
    assert_int_equal(soem_request(&master, 1, EC_STATE_SAFE_OP, &code), EC_STATE_PRE_OP | EC_STATE_ERROR);
    assert_int_equal(code, 0x001E);
    soem_go(&master, 1, EC_STATE_PRE_OP);
}

/* --- object directory --------------------------------------------------------------------------------------------- */

static void every_object(void **state)
{
    static ec_ODlistt list;
    static ec_OElistt entries;
    (void)state;
    memset(&list, 0, sizeof list);
    list.Slave = 1;
    assert_true(ecx_readODlist(&master.context, 1, &list) > 0);
    assert_int_equal(list.Entries, 117);
    for (uint16 i = 0; i < list.Entries; i++) {
        if (list.Index[i] > 0x1A02 && list.Index[i] < 0x1A62)
            continue; /* all alike */
        assert_true(ecx_readODdescription(&master.context, i, &list) > 0);
        uint8 first[64];
        int size = sizeof first;
        assert_int_equal(soem_read(&master, 1, list.Index[i], 0, false, first, &size), 0);
        for (uint16 sub = 0; sub <= list.MaxSub[i]; sub++)
            assert_true(ecx_readOEsingle(&master.context, i, (uint8)sub, &list, &entries) > 0);
    }
    static const struct {
        uint16 index;
        uint8 subindex;
        uint32 code;
    } refused[] = {{0x2005, 1, 0x06090011}, {0x6040, 0, 0x06020000}, {0x2001, 2, 0x06010001}, {0x1C12, 1, 0x06090011}};
    for (size_t i = 0; i < sizeof refused / sizeof refused[0]; i++) {
        uint32 got;
        assert_int_equal(read_number(refused[i].index, refused[i].subindex, &got), refused[i].code);
    }
    assert_int_equal(number(0x2005, 2), 0x41A00000); /* 20.0 mm */
    assert_int_equal(write_number(0x1A00, 0, 1, 1), 0x06010002);
    assert_int_equal(number(0x1018, 2), master.slaves[1].eep_id);
    assert_int_equal(number(0x1018, 3), master.slaves[1].eep_rev);
}

static void mapping(void **state)
{
    static const struct {
        uint32 measurements;
        uint8 count;
        uint32 last;
    } rows[] = {{DISTANCE1 | DISTANCE2, 2, 0x60650720}, {ALL, 13, 0x60651020}, {COUNTER | DISTANCE1, 2, 0x60650520}};
    (void)state;
    assert_int_equal(number(0x1A00, 0), 2);
    assert_int_equal(number(0x1A00, 1), 0x60650520);
    assert_int_equal(number(0x1A00, 2), 0x60650720);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        choose(rows[i].measurements, 1);
        assert_int_equal(number(0x1A00, 0), rows[i].count);
        assert_int_equal(number(0x1A00, rows[i].count), rows[i].last);
        soem_map(&master);
        assert_int_equal(master.slaves[1].Ibytes, 4 * rows[i].count);
        assert_int_equal(write_number(0x21B0, 9, 0, 1), 0x08000022); /* in PREOP only */
        soem_operational(&master);
        await(rows[i].measurements == ALL ? 5 : (unsigned int)(rows[i].measurements == (COUNTER | DISTANCE1)), 10 * MM);
        soem_close(&master);
        soem_open(&master, iface, 1);
    }
}

static void user_level(void **state)
{
    (void)state;
    plant_set("user", "0");
    assert_int_equal(number(0x2001, 1), 0);
    assert_int_equal(write_number(0x2250, 1, 5000, 4), 0x08000021);
    assert_int_equal(write_number(0x21B0, 9, 1, 1), 0x08000021);
    assert_int_equal(log_in("001"), 0x08000020);
    assert_int_equal(write_number(0x2250, 1, 5000, 4), 0x08000021);
    assert_int_equal(log_in("000"), 0);
    assert_int_equal(number(0x2001, 1), 1);
    set(0x2250, 1, 5000, 4);
    assert_int_equal(plant_number("rate"), 5000);
    assert_int_equal(write_number(0x2250, 1, 5001, 4), 0x06090030);
    set(0x2001, 3, 1, 1);
    assert_int_equal(number(0x2001, 1), 0);
    assert_int_equal(write_number(0x2250, 1, 5000, 4), 0x08000021);
}

/* --- values ------------------------------------------------------------------------------------------------------- */

static void errors(void **state)
{
    static const struct {
        const char *name, *wrong, *right;
        int32_t code;
    } rows[] = {{"surface1.present", "0", "1", 0x7FFFFFFB},
                {"surface1.distance", "-1", "10", 0x7FFFFFFA},
                {"surface1.distance", "21", "10", 0x7FFFFFF9},
                {"surface1.fault", "8", "0", 0x7FFFFFF8},
                {"surface1.fault", "7", "0", 0x7FFFFFF7},
                {"surface1.fault", "6", "0", 0x7FFFFFF6},
                {"laser", "0", "1", 0x7FFFFFF5}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        plant_set(rows[i].name, rows[i].wrong);
        await(0, rows[i].code);
        plant_set(rows[i].name, rows[i].right);
        await(0, 10 * MM);
    }
    plant_set_all("surface2.distance=15 surface2.present=1");
    await(1, 15 * MM);
}

/* The counter goes on by the measuring rate, and the timestamps with it, whatever the cycle is. */
static void rates(void **state)
{
    static const struct {
        uint32 hz, period_ns;
    } rows[] = {{1500, 666667}, {20000, 50000}, {49140, 20350}};
    (void)state;
    choose(COUNTER | TIMESTAMP | INTENSITY | DISTANCE1, 1);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        set(0x2250, 1, rows[i].hz, 4);
        soem_map(&master);
        soem_operational(&master);
        for (int n = 0; n < 20; n++)
            soem_cycle(&master);
        uint32_t records = (uint32_t)value(0), us = (uint32_t)value(1);
        assert_int_equal(value(2), 512);
        for (int n = 0; n < 200; n++)
            soem_cycle(&master);
        records = (uint32_t)value(0) - records;
        us = (uint32_t)value(1) - us;
        double want_us = records * (rows[i].period_ns / 1000.0);
        if (records == 0 || us < want_us - 1 || us > want_us + 1)
            fail_msg("%u Hz: %u records in %u us", rows[i].hz, records, us);
        soem_go(&master, 1, EC_STATE_PRE_OP);
    }
}

/* Ten records an exchange: inside it they follow one another. */
static void oversampling(void **state)
{
    enum { SAMPLES = 10 };
    (void)state;
    set(0x2250, 1, 10000, 4);
    choose(COUNTER | DISTANCE1, SAMPLES);
    plant_set_all("surface1.amplitude=5 surface1.period=1000000 surface1.source=1");
    soem_map(&master);
    assert_int_equal(master.slaves[1].Ibytes, 2 * 4 * SAMPLES);
    soem_operational(&master);
    for (int cycle = 0; cycle < 300; cycle++) {
        soem_cycle(&master);
        for (unsigned int n = 1; n < SAMPLES; n++) {
            if (value(2 * n) != value(0) + (int32_t)n)
                fail_msg("cycle %d, record %u: counter %d after %d", cycle, n, value(2 * n), value(0));
            int32_t step = value(2 * n + 1) - value(2 * n - 1);
            assert_true((step >= 499 && step <= 501) || step < -4 * MM); /* 5 mm in a second, and the fall */
        }
    }
}

/* A CSV file's rows go by; a missing surface has no distance. */
static void table(void **state)
{
    (void)state;
    plant_set_all("row1=3 row_present=1 row_add=1 row1=4 row_add=1 row_present=0 row_add=1 row_time=200000");
    assert_int_equal(plant_number("rows"), 3);
    plant_set("surface1.source", "3");
    for (int round = 0; round < 2; round++) {
        await(0, 3 * MM);
        await(0, 4 * MM);
        await(0, 0x7FFFFFFB);
    }
}

/* --- distributed clocks ------------------------------------------------------------------------------------------- */

static void clocks(void **state)
{
    static const struct {
        uint32 cycle;
        bool accepted;
    } rows[] = {{100000, true}, {200000, true}, {1333334, true}, {1000000, false}, {400000, true}};
    (void)state;
    uint16 code;
    choose(COUNTER | TIMESTAMP, 1);
    assert_true(master.slaves[1].hasdc);
    assert_true(ecx_configdc(&master.context));
    ecx_config_map_group(&master.context, master.image, 0);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ecx_dcsync0(&master.context, 1, TRUE, rows[i].cycle, 0);
        uint16 reached = soem_request(&master, 1, EC_STATE_SAFE_OP, &code);
        assert_int_equal(reached, rows[i].accepted ? EC_STATE_SAFE_OP : EC_STATE_PRE_OP | EC_STATE_ERROR);
        assert_int_equal(code, rows[i].accepted ? 0 : 0x0036);
        soem_go(&master, 1, EC_STATE_PRE_OP);
    }
    ecx_dcsync0(&master.context, 1, TRUE, 400000, 0);
    soem_go(&master, 1, EC_STATE_SAFE_OP);
    soem_operational(&master);
    int left = PATIENCE;
    while (plant_number("synchronised") == 0 && left-- > 0)
        soem_cycle(&master);
    assert_true(left > 0);
    for (int n = 0; n < 20; n++)
        soem_cycle(&master);
    uint32_t records = (uint32_t)value(0), us = (uint32_t)value(1);
    for (int n = 0; n < 200; n++)
        soem_cycle(&master);
    assert_int_equal((uint32_t)value(1) - us, ((uint32_t)value(0) - records) * 400);
    soem_go(&master, 1, EC_STATE_INIT);
    ecx_dcsync0(&master.context, 1, FALSE, 0, 0);
}

int main(int argc, char **argv)
{
#define M(title, function) {title, function, open_master, close_master, NULL}
#define E(title, function) {title, function, open_expert, close_master, NULL}
#define O(title, function) {title, function, open_operational, close_master, NULL}
    const struct CMUnitTest tests[] = {
        M("OPT-001 OPT-002 OPT-003 OPT-005 OPT-006: INIT, PREOP, SAFEOP and OP permit their services", states),
        M("OPT-004 OPT-009: SM3 as long as the mapping, SM2 unused (public manual, p. 151)", sync_managers),
        M("OPT-007 OPT-008 OPT-012: the object directory (public manual, pp. 157, 161, 172)", every_object),
        E("OPT-010 OPT-011: 1A00h by default, and as chosen in 21B0h (public manual, pp. 153, 157)", mapping),
        M("OPT-014: settings require the user level expert (public manual, pp. 131, 161)", user_level),
        O("OPT-013: each error in place of a distance (public manual, p. 98)", errors),
        E("OPT-006: measuring rates", rates),
        E("OPT-006: several records in an exchange (public manual, p. 174)", oversampling),
        O("OPT-006 OPT-013: a table of what goes by", table),
        E("SYNC0 with the period of a measuring rate (public manual, p. 182)", clocks),
    };
    if (argc < 2) {
        fprintf(stderr, "usage: test_optoncdt IFACE [TEST [no-plant]]\n");
        return 2;
    }
    iface = argv[1];
    if (argc > 2)
        cmocka_set_test_filter(argv[2]);
    played = argc < 4;
    return cmocka_run_group_tests(tests, NULL, NULL);
}
