/* SPDX-License-Identifier: MIT */
/*
 * The requirements of Q179, tested by SOEM on the wire and in real time; the test plays the plant through the control
 * socket.
 * usage: test_fzm1 IFACE [TEST]
 *
 * The PLC is the example's (examples/plc). That times are kept to the microsecond is tests/unit/test_fzm1_*.c; here
 * they have to come.
 */
#define _DEFAULT_SOURCE
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "fzm1_plc.h"
#include "lamps.h"
#include "plant.h"
#include "soem.h"

enum { PATIENCE = 20000 /* cycles that a change may take on a busy machine */ };

static const char *iface;
static soem_t master;
static fzm1_plc_t plc;
static const uint8 *in;
static uint8 *out;
static int32_t data[64][FZM1_PLC_DATA];
static unsigned int data_count;

static void on_data(void *ctx, const int32_t values[FZM1_PLC_DATA])
{
    (void)ctx;
    memcpy(data[data_count++ % 64], values, sizeof data[0]);
}

static void cycle(void)
{
    if (soem_cycle(&master) > 0)
        fzm1_plc_cycle(&plc, in, out, soem_now());
}

/* Cycles until the condition holds; a failure prints it. */
#define AWAIT(condition)                                                                                               \
    do {                                                                                                               \
        int left = PATIENCE;                                                                                           \
        while (!(condition) && left-- > 0)                                                                             \
            cycle();                                                                                                   \
        if (left < 0)                                                                                                  \
            fail_msg("expected, in vain: %s   (control signals %05X, exe %d)", #condition, plc.signals, plc.exe);      \
    } while (0)

static void to_op(void)
{
    soem_map(&master);
    in = master.slaves[1].inputs;
    out = master.slaves[1].outputs;
    soem_operational(&master);
    fzm1_plc_start(&plc);
    for (int i = 0; i < 5; i++)
        cycle();
}

static int open_master(void **state)
{
    (void)state;
    soem_open(&master, iface, 1);
    plc = (fzm1_plc_t){.step_hold_ns = 200000000, .exe_retry_ns = 2000000000, .on_data = on_data};
    data_count = 0;
    return 0;
}

static void measure(void)
{
    AWAIT(fzm1_plc_measure(&plc));
    AWAIT(!plc.step_wanted && !plc.step);
}

/* @return response code */
static int command(uint32_t code, int32_t p1, int32_t p2, int32_t p3)
{
    AWAIT(fzm1_plc_command(&plc, code, p1, p2, p3));
    AWAIT(plc.done);
    uint32_t echo;
    memcpy(&echo, in + 4, sizeof echo);
    assert_int_equal(etohl(echo), code);
    return (int)plc.result;
}

static const char defaults[] =
    "run=1 err=0 judgement=0 camera=0 output_control=0 output_time=10 output_period=100 output_time=50 "
    "output_format=0 output_repeat=0 timeout=100 image_input=5000 processing=20000 sdo_abort=0 "
    "exe_timeout=0 node_address=0 start_time=300";

static int open_operational(void **state)
{
    open_master(state);
    plant_set_all(defaults);
    to_op();
    AWAIT(plc.signals == (PLC_READY | PLC_RUN));
    return 0;
}

static int open_handshaking(void **state)
{
    const uint8 one = 1;
    open_master(state);
    plant_set_all(defaults);
    assert_int_equal(soem_write(&master, 1, 0x2400, 1, false, &one, 1), 0);
    plc.handshaking = true;
    to_op();
    AWAIT((plc.signals & (PLC_READY | PLC_BUSY)) == PLC_READY);
    assert_int_equal(command(PLC_CLEAR, 0, 0, 0), 0); /* what the test before has left */
    AWAIT((plc.signals & PLC_GATE) == 0);
    data_count = 0;
    return 0;
}

static int close_master(void **state)
{
    (void)state;
    soem_close(&master);
    return 0;
}

/* --- states, SDO, clocks ------------------------------------------------------------------------------------------ */

static uint32 read_number(uint16 index, uint8 subindex, uint32 *value)
{
    int size = sizeof *value;
    *value = 0;
    return soem_read(&master, 1, index, subindex, false, value, &size);
}

static uint32 write_number(uint16 index, uint8 subindex, uint32 value, int size)
{
    uint32 wire = htoel(value);
    return soem_write(&master, 1, index, subindex, false, &wire, size);
}

static void states(void **state)
{
    (void)state;
    uint32 value;
    uint8 mail[128] = {0x0A, 0, 0, 0, 0, 0x13, 0, 0x20, 0x40, 0x18, 0x10, 1};
    uint16 station = master.slaves[1].configadr;
    ecx_readstate(&master.context);
    assert_int_equal(master.slaves[1].state, EC_STATE_PRE_OP); /* where SOEM took it, and no further */
    soem_go(&master, 1, EC_STATE_INIT);
    (void)ecx_FPWR(&master.port, station, 0x1000, sizeof mail, mail, EC_TIMEOUTRET3);
    osal_usleep(20000);
    uint8 status = 0xFF;
    assert_int_equal(ecx_FPRD(&master.port, station, ECT_REG_SM1 + 5, 1, &status, EC_TIMEOUTRET3), 1);
    assert_int_equal(status & 0x08, 0); /* INIT: a request has no answer */
    soem_go(&master, 1, EC_STATE_PRE_OP);
    assert_int_equal(read_number(0x1018, 1, &value), 0);
    assert_int_equal(value, master.slaves[1].eep_man);
    soem_map(&master);
    in = master.slaves[1].inputs;
    assert_int_equal(master.slaves[1].Obytes, 20);
    assert_int_equal(master.slaves[1].Ibytes, 48);
    soem_cycle(&master);
    soem_cycle(&master);
    assert_int_equal(in[0], PLC_READY | PLC_RUN); /* SAFEOP: inputs are valid ... */
    master.slaves[1].outputs[0] = PLC_STEP;
    for (int i = 0; i < 50; i++)
        soem_cycle(&master);
    assert_int_equal(in[0], PLC_READY | PLC_RUN); /* ... and outputs are not taken */
    master.slaves[1].outputs[0] = 0;
    soem_operational(&master);
    assert_int_equal(read_number(0x1018, 1, &value), 0);
    soem_cycle(&master);
    for (int i = 0; i < PATIENCE && (in[0] & PLC_BUSY) == 0; i++) {
        master.slaves[1].outputs[0] = PLC_STEP; /* OP: they are */
        soem_cycle(&master);
    }
    assert_true((in[0] & PLC_BUSY) != 0);
    soem_go(&master, 1, EC_STATE_INIT);
}

static void sdo(void **state)
{
    static const struct {
        uint16 index;
        uint8 subindex;
        int size;
        uint32 value, code;
    } rows[] = {{0x1C12, 0, 1, 0, 0x06010002},   {0x1600, 1, 4, 0, 0x06010002},   {0x2100, 1, 4, 0, 0x06010002},
                {0x2400, 1, 1, 2, 0x06090030},   {0x2400, 2, 2, 19, 0x06090032},  {0x2400, 2, 2, 50001, 0x06090031},
                {0x2400, 3, 2, 100, 0x06040043}, {0x2400, 4, 4, 100, 0x06070012}, {0x2400, 4, 1, 100, 0x06070013},
                {0x2400, 6, 2, 0, 0x06090011},   {0x6040, 0, 2, 0, 0x06020000},   {0x2400, 4, 2, 100, 0}};
    (void)state;
    uint32 value;
    plant_set_all(defaults);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint32 code = write_number(rows[i].index, rows[i].subindex, rows[i].value, rows[i].size);
        if (code != rows[i].code)
            fail_msg("%04X:%u := %u: expected %08X, got %08X", rows[i].index, rows[i].subindex, rows[i].value,
                     rows[i].code, code);
    }
    assert_int_equal(read_number(0x2401, 0, &value), 0x06010001);
    plant_set("sdo_abort", "0x06060000");
    assert_int_equal(write_number(0x2400, 4, 100, 2), 0x06060000);
    plant_set("sdo_abort", "0x08000021"); /* an upload too, of whatever object */
    assert_int_equal(read_number(0x6040, 0, &value), 0x08000021);
    assert_int_equal(read_number(0x6040, 0, &value), 0x06020000);
    soem_map(&master); /* settings can be written in SAFEOP and OP too */
    assert_int_equal(write_number(0x2400, 4, 100, 2), 0);
    soem_operational(&master);
    assert_int_equal(write_number(0x2400, 4, 99, 2), 0);
    assert_int_equal(read_number(0x2400, 4, &value), 0);
    assert_int_equal(value, 99);
}

static void every_object(void **state)
{
    static ec_ODlistt list;
    static ec_OElistt entries;
    (void)state;
    static const struct {
        uint16 index;
        uint8 count;
        uint32 first, last;
    } fixed[] = {{0x1600, 5, 0x21000120, 0x21000520},
                 {0x1A00, 4, 0x22000120, 0x22000420},
                 {0x1A01, 8, 0x23000120, 0x23000820},
                 {0x1C12, 1, 0x1600, 0x1600},
                 {0x1C13, 2, 0x1A00, 0x1A01}};
    for (size_t i = 0; i < sizeof fixed / sizeof fixed[0]; i++) {
        uint32 count, first, last;
        assert_int_equal(read_number(fixed[i].index, 0, &count), 0);
        assert_int_equal(read_number(fixed[i].index, 1, &first), 0);
        assert_int_equal(read_number(fixed[i].index, fixed[i].count, &last), 0);
        assert_int_equal(count, fixed[i].count);
        assert_int_equal(first, fixed[i].first);
        assert_int_equal(last, fixed[i].last);
    }
    memset(&list, 0, sizeof list);
    list.Slave = 1;
    assert_true(ecx_readODlist(&master.context, 1, &list) > 0);
    assert_int_equal(list.Entries, 19);
    for (uint16 i = 0; i < list.Entries; i++) {
        assert_true(ecx_readODdescription(&master.context, i, &list) > 0);
        assert_true(ecx_readOEsingle(&master.context, i, 0, &list, &entries) > 0);
        uint8 value[64];
        int size = sizeof value;
        for (uint16 sub = 1; sub <= list.MaxSub[i]; sub++) /* gaps are described too: no error ends a scan */
            assert_true(ecx_readOEsingle(&master.context, i, (uint8)sub, &list, &entries) > 0);
        bool gap = list.Index[i] == 0x1C32 || list.Index[i] == 0x1C33;
        assert_int_equal(gap ? entries.DataType[3] | entries.BitLength[3] : 0, 0);
        bool write_only = list.Index[i] == 0x2401;
        assert_int_equal(soem_read(&master, 1, list.Index[i], 0, false, value, &size), write_only ? 0x06010001 : 0);
    }
}

static unsigned int sync_counter(uint8 subindex)
{
    uint16 value = 0;
    int size = sizeof value;
    assert_int_equal(soem_read(&master, 1, 0x1C32, subindex, false, &value, &size), 0);
    return etohs(value);
}

/* SYNC0 and these cycles are not synchronised, and the sensor's oscillator is wrong: they slide over each other. */
static void await_sync_events(void)
{
    for (int left = PATIENCE; left > 0 && sync_counter(11) + sync_counter(12) == 0; left -= 20) {
        for (int i = 0; i < 20; i++)
            soem_cycle(&master);
    }
    if (sync_counter(11) + sync_counter(12) == 0)
        fail_msg("SYNC0 and outputs are always in step: expected 1C32h:11 or 1C32h:12 to move");
}

static void clocks(void **state)
{
    static const struct {
        uint32 cycle;
        bool accepted;
    } rows[] = {{250000, true}, {500000, true}, {1000000, true}, {2000000, true}, {4000000, true}, {3000000, false}};
    (void)state;
    assert_true(master.slaves[1].hasdc);
    assert_true(ecx_configdc(&master.context));
    ecx_config_map_group(&master.context, master.image, 0);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint64 before = 0, after = 0, start = 0;
        uint16 station = master.slaves[1].configadr, code;
        ecx_dcsync0(&master.context, 1, TRUE, rows[i].cycle, 0);
        assert_int_equal(ecx_FPRD(&master.port, station, ECT_REG_DCSYSTIME, 8, &before, EC_TIMEOUTRET3), 1);
        osal_usleep(2000);
        assert_int_equal(ecx_FPRD(&master.port, station, ECT_REG_DCSYSTIME, 8, &after, EC_TIMEOUTRET3), 1);
        assert_in_range(after - before, 2000000, 10000000000);
        assert_int_equal(ecx_FPRD(&master.port, station, ECT_REG_DCSTART0, 8, &start, EC_TIMEOUTRET3), 1);
        assert_true(start >= after);
        uint16 reached = soem_request(&master, 1, EC_STATE_SAFE_OP, &code);
        assert_int_equal(reached, rows[i].accepted ? EC_STATE_SAFE_OP : EC_STATE_PRE_OP | EC_STATE_ERROR);
        assert_int_equal(code, rows[i].accepted ? 0 : 0x0036);
        soem_go(&master, 1, EC_STATE_PRE_OP);
    }
    ecx_dcsync0(&master.context, 1, TRUE, 1000000, 0);
    soem_go(&master, 1, EC_STATE_SAFE_OP);
    in = master.slaves[1].inputs;
    out = master.slaves[1].outputs;
    soem_operational(&master);
    await_sync_events();
    fzm1_plc_start(&plc);
    cycle();
    measure();
    AWAIT((plc.signals & (PLC_BUSY | PLC_READY)) == PLC_READY);
}

/* --- measurement -------------------------------------------------------------------------------------------------- */

static void steps(void **state)
{
    (void)state;
    long long before = plant_number("measurements");
    plant_set_all("image_input=50000 processing=100000");
    AWAIT(fzm1_plc_measure(&plc));
    AWAIT((plc.signals & (PLC_BUSY | PLC_READY)) == PLC_BUSY);
    AWAIT((plc.signals & (PLC_BUSY | PLC_READY)) == (PLC_BUSY | PLC_READY)); /* the next image may come */
    measure();
    AWAIT((plc.signals & (PLC_BUSY | PLC_READY)) == PLC_READY);
    assert_int_equal(plant_number("measurements"), before + 2);
    out[0] = PLC_STEP;
    for (int i = 0; i < 300; i++) {
        soem_cycle(&master);
        out[0] = PLC_STEP; /* a level */
    }
    assert_int_equal(plant_number("measurements"), before + 3);
}

static void queue(void **state)
{
    static const struct {
        const char *camera;
        unsigned int room;
    } rows[] = {{"camera=0", 16}, {"camera=1", 4}, {"camera=2", 1}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        plant_set_all("image_input=1000 processing=60000000");
        plant_set_all(rows[i].camera);
        for (unsigned int n = 0; n < rows[i].room; n++)
            measure();
        AWAIT(plant_number("images") == rows[i].room && (plc.signals & PLC_READY) == 0);
        for (int n = 0; n < 20; n++)
            cycle();
        assert_false(fzm1_plc_measure(&plc));
        plant_set("restart", "1"); /* a minute each would be too long */
        osal_usleep(500000);
        ecx_close(&master.context);
        open_operational(state);
        assert_int_equal(plant_number("measurements"), 0);
    }
}

static void judgement_and_window(void **state)
{
    (void)state;
    plant_set("judgement1", "-1");
    measure();
    AWAIT((plc.signals & PLC_OR) != 0);
    plant_set("judgement1", "1");
    measure();
    AWAIT((plc.signals & PLC_OR) == 0);
    plant_set("run", "0");
    AWAIT((plc.signals & (PLC_RUN | PLC_READY)) == 0);
    plant_set("run", "1");
    AWAIT((plc.signals & (PLC_RUN | PLC_READY)) == (PLC_RUN | PLC_READY));
    plant_set("trigger", "1");
    AWAIT((plc.signals & PLC_BUSY) != 0);
    AWAIT((plc.signals & PLC_BUSY) == 0);
}

static void continuous(void **state)
{
    (void)state;
    long long before = plant_number("measurements");
    assert_int_equal(command(PLC_START_CONTINUOUS, 0, 0, 0), 0);
    AWAIT(plant_number("measurements") >= before + 5);
    assert_int_equal(plc.signals & (PLC_BUSY | PLC_READY), PLC_BUSY);
    assert_int_equal(command(PLC_END_CONTINUOUS, 0, 0, 0), 0);
    AWAIT((plc.signals & (PLC_BUSY | PLC_READY)) == PLC_READY);
}

/* --- commands ----------------------------------------------------------------------------------------------------- */

static void every_command(void **state)
{
    static const struct {
        uint32_t code;
        int32_t p1, p2, p3;
        int result;
        int32_t data;
    } rows[] = {
        {PLC_SWITCH_SCENE, 12, 0, 0, 0, 0},
        {PLC_GET_SCENE, 0, 0, 0, 0, 12},
        {PLC_SWITCH_SCENE, 128, 0, 0, -1, 0},
        {PLC_SWITCH_GROUP, 3, 0, 0, 0, 0},
        {PLC_GET_GROUP, 0, 0, 0, 0, 3},
        {PLC_GET_SCENE, 0, 0, 0, 0, 0},
        {PLC_SWITCH_GROUP, 32, 0, 0, -1, 0},
        {PLC_GET_UNIT_DATA, 3, 0, 0, 0, 0},
        {PLC_SET_UNIT_DATA, 3, 150, 1000, 0, 0},
        {PLC_GET_UNIT_DATA, 3, 150, 0, 0, 1000},
        {PLC_SET_UNIT_DATA, 3, 150, 0, 0, 0},
        {PLC_SET_UNIT_DATA, 3, 5, 0, -1, 0},
        {PLC_GET_UNIT_DATA, 9, 0, 0, -1, 0},
        {PLC_GET_UNIT_DATA, 3, 13, 0, -1, 0},
        {PLC_SAVE, 0, 0, 0, 0, 0},
        {0x12345678, 0, 0, 0, -1, 0},
        {PLC_SWITCH_GROUP, 0, 0, 0, 0, 0},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        int result = command(rows[i].code, rows[i].p1, rows[i].p2, rows[i].p3);
        if (result != rows[i].result || plc.data != rows[i].data)
            fail_msg("row %zu, %08X: expected %d with %d, got %d with %d", i, rows[i].code, rows[i].result,
                     rows[i].data, result, plc.data);
    }
    plant_set_all("data1=1.5 data2=6 data3=7 data4=8 data5=9 data6=10 data7=11 data8=12");
    measure();
    AWAIT((plc.signals & PLC_BUSY) == 0);
    assert_int_equal(command(PLC_GET_UNIT_DATA, 3, 0, 0), 0);
    assert_int_equal(plc.data, 1000);
    for (int number = 5; number <= 12; number++) {
        assert_int_equal(command(PLC_GET_UNIT_DATA, 3, number, 0), 0);
        assert_int_equal(plc.data, number == 5 ? 1500 : number * 1000);
    }
    assert_int_equal(command(PLC_CLEAR, 0, 0, 0), 0);
    assert_int_equal(command(PLC_GET_UNIT_DATA, 3, 0, 0), 0);
    assert_int_equal(plc.data, 0);
}

static void exe_handshake(void **state)
{
    (void)state;
    AWAIT(fzm1_plc_command(&plc, PLC_SWITCH_SCENE, 1, 0, 0));
    AWAIT((plc.signals & PLC_BUSY) != 0 && (plc.signals & (PLC_READY | PLC_FLG)) == 0);
    AWAIT((plc.signals & PLC_FLG) != 0);
    assert_int_equal(plc.signals & PLC_BUSY, 0);
    AWAIT(plc.done);
    for (unsigned int bit = 2; bit < 32; bit++) {
        if (bit == 16)
            continue;
        memset(out, 0, 4);
        out[bit / 8] = (uint8)(1u << bit % 8);
        for (int i = 0; i < 3; i++)
            soem_cycle(&master);
        assert_int_equal(in[0] | in[1] << 8 | in[2] << 16 | in[3] << 24, PLC_READY | PLC_RUN); /* unnamed bits */
    }
    memset(out, 0, 4);
    measure();
    soem_cycle(&master);
    out[0] = PLC_EXE; /* while BUSY: ignored until it falls */
    for (int i = 0; i < 200; i++) {
        soem_cycle(&master);
        assert_int_equal(in[0] & PLC_FLG, 0);
    }
    assert_int_equal(command(PLC_GET_SCENE, 0, 0, 0), 0);
}

/* --- data output -------------------------------------------------------------------------------------------------- */

static void values(void **state)
{
    (void)state;
    plant_set_all("data1=12.345 data2=-12.345 data8=999999999");
    measure();
    AWAIT(data_count == 1);
    assert_int_equal(data[0][0], 12345);
    assert_int_equal(data[0][1], -12345);
    assert_int_equal(data[0][7], INT32_MAX);
    assert_int_equal(command(PLC_SET_UNIT_DATA, 3, 150, 1000), 0);
    measure();
    AWAIT(data_count == 2);
    float single = 12.345f;
    assert_memory_equal(&data[1][0], &single, sizeof single);
}

static void one_output_a_step(void **state)
{
    (void)state;
    plant_set_all("image_input=1000 processing=1000 output_period=400 output_time=200");
    for (int n = 1; n <= 10; n++) {
        char setting[32];
        snprintf(setting, sizeof setting, "data1=%d", n);
        plant_set_all(setting);
        measure();
        AWAIT((plc.signals & PLC_BUSY) == 0);
    }
    AWAIT(data_count >= 10);
    for (int i = 0; i < 100; i++)
        cycle();
    assert_int_equal(data_count, 10);
    for (int n = 0; n < 10; n++)
        assert_int_equal(data[n][0], 1000 * (n + 1));
}

static void fetched_by_dsa(void **state)
{
    (void)state;
    plant_set_all("image_input=1000 processing=1000");
    for (int n = 1; n <= 10; n++) {
        char setting[32];
        snprintf(setting, sizeof setting, "data1=%d", n);
        plant_set_all(setting);
        measure();
    }
    AWAIT(data_count == 10);
    for (int n = 0; n < 10; n++)
        assert_int_equal(data[n][0], 1000 * (n + 1));
    AWAIT((plc.signals & PLC_GATE) == 0);
    assert_int_equal(plc.signals & PLC_ERR, 0);
}

static void no_dsa(void **state)
{
    (void)state;
    const uint8 one = 1;
    plant_set("timeout", "5");
    plc.handshaking = false; /* a program that forgets DSA */
    plc.dsa = false;
    cycle();
    measure();
    AWAIT((plc.signals & PLC_ERR) != 0);
    assert_int_equal(data_count, 0);
    assert_int_equal(soem_write(&master, 1, 0x2401, 0, false, &one, 1), 0);
    AWAIT((plc.signals & PLC_ERR) == 0);
    plc.handshaking = true;
    measure();
    AWAIT(data_count == 1);
}

/* Without DSA sixteen results wait, one more is lost, and commands still get their responses. */
static void full_queue(void **state)
{
    (void)state;
    plc.handshaking = plc.dsa = false; /* DSA stays off */
    AWAIT(plant_number("dsa") == 0);
    plant_set_all("timeout=1200 image_input=100 processing=100");
    long long lost = plant_number("lost");
    for (int n = 0; n < 17; n++) {
        measure();
        AWAIT((plc.signals & (PLC_READY | PLC_BUSY)) == PLC_READY);
    }
    AWAIT((plc.signals & PLC_ERR) != 0);
    assert_int_equal(plant_number("pending"), 16);
    assert_int_equal(plant_number("lost"), lost + 1);
    assert_string_equal(plant_get("error_cause"), "results lost: 16 wait already");
    assert_int_equal(command(PLC_GET_SCENE, 0, 0, 0), 0);
    assert_int_equal(command(PLC_START_CONTINUOUS, 0, 0, 0), 0);
    assert_int_equal(command(PLC_CLEAR, 0, 0, 0), 0); /* while a continuous measurement runs */
    assert_int_equal(command(PLC_END_CONTINUOUS, 0, 0, 0), 0);
    AWAIT((plc.signals & PLC_BUSY) == 0);
    assert_int_equal(command(PLC_CLEAR, 0, 0, 0), 0);
    AWAIT((plc.signals & PLC_ERR) == 0);
    assert_int_equal(plant_number("pending"), 0);
}

/* A result waits, and DSA is on when OP begins: no request, and no timeout before OP. */
static void dsa_when_op_begins(void **state)
{
    (void)state;
    soem_go(&master, 1, EC_STATE_SAFE_OP);
    plant_set_all("timeout=5 trigger=1");
    osal_usleep(800000);
    assert_int_equal(plant_number("pending"), 1);
    assert_int_equal(plant_number("err"), 0);
    plant_set("timeout", "1200");
    memset(out, 0, FZM1_PLC_OUT);
    out[2] = 1;
    soem_operational(&master);
    for (int i = 0; i < 50; i++) {
        soem_cycle(&master);
        assert_int_equal(in[2] & 1, 0);
    }
    for (int on = 0; on < 2; on++) {
        out[2] = (uint8)on;
        for (int i = 0; i < 50; i++)
            soem_cycle(&master);
    }
    assert_int_equal(in[2] & 1, 1);
}

/* The program pauses while the sensor waits for DSA to fall: the sensor gives GATE back, and both find together again.
 */
static void paused_program(void **state)
{
    (void)state;
    plant_set("timeout", "5");
    soem_watchdog(&master, 0);
    AWAIT(plc.dsa);
    measure();
    for (int i = 0; i < 200 && (in[2] & 1) == 0; i++)
        soem_cycle(&master); /* GATE is on, and the program does not look */
    osal_usleep(1000000);
    AWAIT((plc.signals & PLC_ERR) != 0 || data_count > 0);
    unsigned int before = data_count;
    for (int n = 0; n < 3; n++)
        measure();
    AWAIT(data_count == before + 3);
    AWAIT((plc.signals & PLC_ERR) == 0);
}

/* A trigger at the sensor makes it BUSY just when EXE comes. */
static void trigger_against_commands(void **state)
{
    (void)state;
    plc.exe_retry_ns = 100000000;
    for (int n = 0; n < 30; n++) {
        AWAIT(fzm1_plc_command(&plc, PLC_GET_SCENE, 0, 0, 0));
        for (int i = 0; i < n % 5; i++)
            cycle();
        if (plant_number("ready"))
            plant_set("trigger", "1");
        AWAIT(plc.done);
        assert_int_equal(plc.result, 0);
    }
}

/* The twin is stopped while the master goes on: it must not reply to frames whose timeout has expired, since the master
 * would accept these replies as replies to newer frames. */
static void held_up(void **state)
{
    pid_t twin = getppid();
    (void)state;
    assert_true(twin > 1); /* 1: in a namespace of its own; --leave-children runs it without */
    soem_watchdog(&master, 0);
    kill(twin, SIGSTOP);
    for (int i = 0; i < 300; i++) {
        ecx_send_processdata(&master.context);
        ecx_receive_processdata(&master.context, 1000);
    }
    kill(twin, SIGCONT);
    for (int i = 0; i < 20; i++)
        cycle();
    AWAIT(fzm1_plc_command(&plc, PLC_GET_SCENE, 0, 0, 0));
    int cycles = 0;
    for (; !plc.done && cycles < 1000; cycles++)
        cycle();
    assert_in_range(cycles, 1, 100);
}

/* EXE while BUSY gets no FLG, and -1 is a response: both are counted, with their causes. */
static void causes_of_ignored_commands(void **state)
{
    (void)state;
    plant_set_all("image_input=300000 processing=300000");
    long long ignored = plant_number("exes_ignored"), refused = plant_number("commands_refused");
    measure();
    memset(out, 0, FZM1_PLC_OUT);
    out[0] = PLC_EXE;
    for (int i = 0; i < 20; i++)
        soem_cycle(&master);
    assert_int_equal(plant_number("exes_ignored"), ignored + 1);
    assert_string_equal(plant_get("exe_ignored_cause"), "BUSY is on: a measurement runs");
    out[0] = 0;
    for (int i = 0; i < 20; i++)
        soem_cycle(&master);
    AWAIT((plc.signals & PLC_BUSY) == 0);
    assert_int_equal(command(PLC_SWITCH_SCENE, 128, 0, 0), -1);
    assert_int_equal(plant_number("commands_refused"), refused + 1);
    assert_string_equal(plant_get("command_refused_cause"), "there is no such scene");
}

/* A scene of another group, with an expression, before the program switches to it; then one by hand. */
static void scenes(void **state)
{
    (void)state;
    plant_set_all("switch_time=200000 edit.group=2 edit.scene=5 edit.data1=21 edit.expression3=2*D1+JG");
    assert_int_equal(command(PLC_SWITCH_GROUP, 2, 0, 0), 0);
    assert_int_equal(command(PLC_SWITCH_SCENE, 5, 0, 0), 0);
    data_count = 0;
    measure();
    AWAIT(data_count == 1);
    assert_int_equal(data[0][0], 21000);
    assert_int_equal(data[0][2], 43000);
    plant_set("scene", "6");
    AWAIT((plc.signals & (PLC_READY | PLC_BUSY)) == PLC_BUSY);
    AWAIT((plc.signals & (PLC_READY | PLC_BUSY)) == PLC_READY);
    plant_set_all("edit.clear=1 switch_time=100000");
    assert_int_equal(command(PLC_SWITCH_GROUP, 0, 0, 0), 0);
}

/* --- restart ------------------------------------------------------------------------------------------------------ */

static void restarts(void **state)
{
    (void)state;
    plant_set_all("scene=5 data1=1 save=1 data1=2 node_address=7");
    AWAIT(fzm1_plc_command(&plc, PLC_RESTART, 0, 0, 0));
    int wkc = 1;
    for (int i = 0; i < PATIENCE && wkc > 0; i++) {
        wkc = soem_cycle(&master);
        if (wkc > 0)
            fzm1_plc_cycle(&plc, in, out, soem_now());
    }
    assert_true(wkc <= 0); /* off the bus, without an answer to the command */
    assert_false(plc.done);
    assert_int_equal(plc.signals & (PLC_READY | PLC_RUN | PLC_FLG), 0);
    int slaves = 0;
    for (int i = 0; i < 200 && slaves < 1; i++) {
        osal_usleep(50000);
        uint16 status = 0;
        slaves = ecx_BRD(&master.port, 0, ECT_REG_ALSTAT, 2, &status, EC_TIMEOUTRET);
        if (slaves > 0)
            assert_int_equal(etohs(status), EC_STATE_INIT);
    }
    ecx_close(&master.context);
    open_master(state);
    assert_int_equal(master.slaves[1].aliasadr, 7);
    assert_int_equal(plant_number("scene"), 5);
    assert_int_equal(plant_number("data1"), 1);
    plant_set("node_address", "0");
    to_op();
    AWAIT(plc.signals == (PLC_READY | PLC_RUN));
    plant_set_all("scene=0 save=1 fieldbus=0 restart=1");
    osal_usleep(600000);
    uint16 status = 0;
    for (int i = 0; i < 200 && ecx_BRD(&master.port, 0, ECT_REG_ALSTAT, 2, &status, EC_TIMEOUTRET) <= 0; i++)
        osal_usleep(50000); /* fieldbus was not saved: it comes back */
    assert_int_equal(etohs(status), EC_STATE_INIT);
}

static void fast_cycles(void **state)
{
    (void)state;
    plant_set_all("command_time=0 image_input=100 processing=100 output_time=10 output_period=20");
    long long before = plant_number("measurements");
    unsigned int commands = 0, measured = 0;
    enum { CYCLES = 8000, MOST = 5000000, ENOUGH = 11 };
    /* as fast as the machine can; a busy one gives the twin fewer turns between them */
    for (int i = 0; i < CYCLES || (i < MOST && (commands < ENOUGH || measured < ENOUGH)); i++) {
        ecx_send_processdata(&master.context);
        if (ecx_receive_processdata(&master.context, EC_TIMEOUTRET3) <= 0)
            continue;
        fzm1_plc_cycle(&plc, in, out, soem_now());
        if (measured > commands)
            commands += fzm1_plc_command(&plc, PLC_GET_SCENE, 0, 0, 0);
        else
            measured += fzm1_plc_measure(&plc);
    }
    AWAIT(!plc.step_wanted && !plc.step && plc.exe == PLC_EXE_IDLE);
    AWAIT((plc.signals & (PLC_READY | PLC_BUSY)) == PLC_READY);
    assert_true(commands >= ENOUGH && measured >= ENOUGH);
    assert_int_equal(plant_number("measurements") - before, measured);
    plant_set("command_time", "1000");
}

static void lamps(void **state)
{
    (void)state;
    lamps_follow(&master);
}

#define FROM_PREOP(title, function)  {title, function, open_master, close_master, NULL}
#define TEST(title, function)        {title, function, open_operational, close_master, NULL}
#define HANDSHAKING(title, function) {title, function, open_handshaking, close_master, NULL}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        FROM_PREOP("FZM-001 FZM-002 FZM-003 FZM-004 FZM-005 FZM-018: each state permits its services; 20 and 48 bytes",
                   states),
        FROM_PREOP("FZM-008 FZM-009 FZM-010 FZM-011 FZM-012 FZM-013 FZM-014 FZM-026 FZM-027 FZM-028 FZM-029: settings "
                   "by SDO, and refusals",
                   sdo),
        FROM_PREOP("FZM-020 FZM-021 FZM-022: ECAT RUN, ECAT ERR and L/A lamps by state, error and traffic", lamps),
        FROM_PREOP("FZM-006 FZM-007 FZM-009 FZM-010: SDO information lists every object, each can be read",
                   every_object),
        FROM_PREOP("FZM-015 FZM-016 CF-082 CF-092: SOEM's configdc and dcsync0; five cycle times and no other; what "
                   "SYNC0 misses is "
                   "counted",
                   clocks),
        TEST("FZM-037 FZM-041 FZM-044 FZM-046 FZM-063 FZM-064 FZM-065 FZM-066 FZM-068: STEP, READY, BUSY", steps),
        TEST("FZM-067: 16, 4 and 1 images may wait", queue),
        TEST("FZM-047 FZM-049 FZM-069: OR, RUN, and a trigger at the sensor", judgement_and_window),
        TEST("FZM-053 FZM-054: continuous measurement", continuous),
        TEST("FZM-033 FZM-034 FZM-035 FZM-050 FZM-051 FZM-055 FZM-056 FZM-057 FZM-058 FZM-060 FZM-061 FZM-062: every "
             "command",
             every_command),
        TEST("FZM-036 FZM-038 FZM-040 FZM-043 FZM-044 FZM-059 FZM-070: EXE, FLG, BUSY", exe_handshake),
        TEST("FZM-030 FZM-031 FZM-032 FZM-039: fixed point, clamped, and single precision", values),
        TEST("FZM-026 FZM-027 FZM-028 FZM-073: without handshaking each STEP is one output", one_output_a_step),
        HANDSHAKING("FZM-042 FZM-045 FZM-071: DSA fetches each result once, in order", fetched_by_dsa),
        HANDSHAKING("FZM-045 FZM-072: a program that pauses while GATE is on finds back", paused_program),
        HANDSHAKING("FZM-043 FZM-048 FZM-055 FZM-066 FZM-069: while sixteen results wait, commands get their "
                    "responses, and a further result is lost",
                    full_queue),
        HANDSHAKING("FZM-004 FZM-071 FZM-072: DSA that is on when OP begins is no request", dsa_when_op_begins),
        TEST("FZM-043 FZM-044 FZM-069: commands during triggers at the sensor: each gets its response in the end",
             trigger_against_commands),
        HANDSHAKING("FZM-029 FZM-048 FZM-072: no DSA: time-out and ERR, and back", no_dsa),
        TEST("FZM-040 FZM-062: EXE that begins nothing and -1 are counted, with their causes",
             causes_of_ignored_commands),
        TEST("FZM-030 FZM-044 FZM-058 FZM-059: a scene prepared before, with an expression; BUSY when switched by hand",
             scenes),
        TEST("FZM-075: handshakes in cycles as fast as they get", fast_cycles),
        TEST("a twin that was held up does not leave the master behind", held_up),
        TEST("FZM-019 FZM-024 FZM-052 FZM-056 FZM-077: Restart: off the bus, INIT, node address, saved settings",
             restarts),
    };
    if (argc < 2)
        return 1;
    iface = argv[1];
    if (argc > 2)
        cmocka_set_test_filter(argv[2]);
    return cmocka_run_group_tests_name("FZM1", tests, NULL, NULL);
}
