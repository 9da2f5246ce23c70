/* SPDX-License-Identifier: MIT */
/*
 * The requirements of the manual 1002906 on a PMCtendo DD5, tested with SOEM on the wire and in real time; the control
 * socket sets the signals of the machine.  usage: test_pmctendo IFACE [TEST]
 *
 * The axis is that of examples/motion. tests/unit/devices/pmctendo has the numbers to the count.
 */
#define _DEFAULT_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "axis.h"
#include "plant.h"
#include "soem.h"

#define TURN 1048576
enum { PATIENCE = 20000 /* cycles that a change may take on a busy machine */ };
enum { CONTROL = 0, POSITION = 2, LATCH = 6 };                       /* 1720h */
enum { AT = 0, LATCH2 = 8, LATCH1 = 20, STATUS = 24, LATCHED = 28 }; /* 1B25h */
#define COUNT(array) (sizeof(array) / sizeof((array)[0]))

static const char *iface;
static soem_t master;
static const uint8 *in;
static uint8 *out;

static const char defaults[] = "power=1 enable=1 sto=0 di1=0 di2=0 di3=1 di4=1 load=0 load_inertia=0 friction=0.05 "
                               "probe_width=0 home_width=0 quirk_pilz_reply=0 quirk_pilz_codes=0 sync_patience=0 "
                               "sync_tolerance=0 sync_timeout=2000 index_at=0";

/* --- by mailbox and register -------------------------------------------------------------------------------------- */

static uint32 write_number(uint16 index, uint8 subindex, uint32 value, int size)
{
    uint32 wire = htoel(value);
    return soem_write(&master, 1, index, subindex, false, &wire, size);
}

static uint32 read_number(uint16 index, uint8 subindex)
{
    uint32 value = 0;
    int size = sizeof value;
    uint32 abort = soem_read(&master, 1, index, subindex, false, &value, &size);
    if (abort != 0)
        fail_msg("%04X:%u: abort %08X", index, subindex, abort);
    return etohl(value);
}

static void get(uint16 address, void *data, uint16 length)
{
    assert_int_equal(ecx_FPRD(&master.port, master.slaves[1].configadr, address, length, data, EC_TIMEOUTRET3), 1);
}

static uint8 get8(uint16 address)
{
    uint8 value = 0;
    get(address, &value, 1);
    return value;
}

/* --- state changes ------------------------------------------------------------------------------------------------ */

static int open_preop(void **state)
{
    (void)state;
    soem_open(&master, iface, 1);
    soem_watchdog(&master, 0);
    plant_set_all(defaults);
    return 0;
}

static void assign(uint16 object, uint16 pdo)
{
    assert_int_equal(write_number(object, 0, 0, 1), 0);
    assert_int_equal(write_number(object, 1, pdo, 2), 0);
    assert_int_equal(write_number(object, 0, 1, 1), 0);
}

static void to_safeop(void)
{
    assign(0x1C12, 0x1720);
    assign(0x1C13, 0x1B25);
    soem_map(&master);
    assert_int_equal(master.slaves[1].Obytes, AXIS_OUT);
    assert_int_equal(master.slaves[1].Ibytes, AXIS_IN);
    in = master.slaves[1].inputs;
    out = master.slaves[1].outputs;
    memset(out, 0, AXIS_OUT);
}

static void to_op(void)
{
    to_safeop();
    soem_operational(&master);
    for (int i = 0; i < 5; i++)
        soem_cycle(&master);
}

static int open_operational(void **state)
{
    open_preop(state);
    to_op();
    return 0;
}

static int close_master(void **state)
{
    (void)state;
    soem_close(&master);
    return 0;
}

/* --- process data ------------------------------------------------------------------------------------------------- */

static uint16 get16(unsigned int at)
{
    return (uint16)(in[at] | in[at + 1] << 8);
}

static int32 get32(unsigned int at)
{
    return (int32)(get16(at) | (uint32)get16(at + 2) << 16);
}

static void put(unsigned int at, uint16 value)
{
    out[at] = (uint8)value;
    out[at + 1] = (uint8)(value >> 8);
}

static void put32(unsigned int at, int32 value)
{
    put(at, (uint16)value);
    put(at + 2, (uint16)((uint32)value >> 16));
}

/* Cycles until the condition holds; a failure prints it. */
#define AWAIT(condition)                                                                                               \
    do {                                                                                                               \
        int left = PATIENCE;                                                                                           \
        do                                                                                                             \
            soem_cycle(&master);                                                                                       \
        while (!(condition) && left-- > 0);                                                                            \
        if (left < 0)                                                                                                  \
            fail_msg("expected, in vain: %s   (status %04X, latch status %04X, display '%s')", #condition,             \
                     get16(STATUS), get16(LATCHED), plant_get("display"));                                             \
    } while (0)

static void control(uint16 word, uint16 mask, uint16 want)
{
    put(CONTROL, word);
    AWAIT((get16(STATUS) & mask) == want);
}

static void enable(void)
{
    put32(POSITION, get32(AT));
    control(0x06, 0x6F, 0x21);
    control(0x07, 0x6F, 0x23);
    put32(POSITION, get32(AT));
    control(0x0F, 0x6F, 0x27);
}

/* --- mailbox ------------------------------------------------------------------------------------------------------ */

static void telegram(const uint8 request[16], uint8 reply[16])
{
    uint8 mail[16];
    memcpy(mail, request, sizeof mail);
    assert_int_equal(ecx_FPWR(&master.port, master.slaves[1].configadr, 0x1800, sizeof mail, mail, EC_TIMEOUTRET3), 1);
    for (int tries = 0; tries < 2000 && (get8(0x080D) & 0x08) == 0; tries++)
        osal_usleep(500);
    get(0x1C00, reply, 16);
    reply[5] &= 0x0F;
}

static void mailbox(void **state)
{
    static const uint8 none[16] = {10, 0, 0, 0, 0, 3, 0, 0x20, 0x2F, 0x12, 0x1C};
    static const uint8 example[16] = {0x0A, 0, 0, 0, 0, 3, 0, 0x20, 0x2B, 0x12, 0x1C, 1, 4, 0x17, 0, 0};
    static const uint8 standard[16] = {10, 0, 0, 0, 0, 3, 0, 0x30, 0x60, 0x12, 0x1C, 1};
    static const uint8 printed[16] = {0x0E, 0, 0, 0, 0, 3, 0, 0x20, 0x60, 0x12, 0x1C, 1};
    static const uint8 aoe[16] = {10, 0, 0, 0, 0, 1, 0, 0x20, 0x40};
    uint8 reply[16];
    (void)state;
    for (int quirk = 0; quirk < 2; quirk++) {
        plant_set("quirk_pilz_reply", quirk ? "1" : "0");
        telegram(none, reply);
        telegram(example, reply);
        assert_memory_equal(reply, quirk ? printed : standard, sizeof reply);
    }
    telegram(aoe, reply);
    assert_int_equal(reply[5], 0); /* a mailbox error */
    plant_set("quirk_pilz_reply", "0");
    assert_int_equal(read_number(0x1C12, 1), 0x1704);
    char name[32] = {0};
    int size = sizeof name;
    assert_int_equal(soem_read(&master, 1, 0x1008, 0, false, name, &size), 0);
    assert_string_equal(name, "PMCtendo DD5");
}

/* Mail and AL Event in one frame: the event comes with the end of the frame, before the drive can reply. */
static void mail_event(void **state)
{
    uint8 mail[16] = {10, 0, 0, 0, 0, 3, 0, 0x20, 0x40, 0x41, 0x60}, event[2] = {0}, reply[16];
    ecx_portt *port = &master.port;
    uint16 station = master.slaves[1].configadr;
    (void)state;
    uint8 index = (uint8)ecx_getindex(port);
    ecx_setupdatagram(port, &port->txbuf[index], EC_CMD_FPWR, index, station, 0x1800, sizeof mail, mail);
    int at =
        ecx_adddatagram(port, &port->txbuf[index], EC_CMD_FPRD, index, FALSE, station, 0x0220, sizeof event, event);
    assert_true(ecx_srconfirm(port, index, EC_TIMEOUTRET3) > 0);
    memcpy(event, port->rxbuf[index] + at, sizeof event);
    ecx_setbufstat(port, index, EC_BUF_EMPTY);
    assert_int_equal(event[1] & 0x03, 0x00);
    for (int tries = 0; tries < 2000 && (get8(0x080D) & 0x08) == 0; tries++)
        osal_usleep(500);
    assert_int_equal(get8(0x0221) & 0x01, 0);
    assert_int_equal(get8(0x0805) & 0x08, 0); /* Mail Out is free again */
    get(0x1C00, reply, sizeof reply);
    assert_int_equal(reply[8], 0x4B);
    assert_int_equal(reply[9] | reply[10] << 8, 0x6041);
}

/* --- states ------------------------------------------------------------------------------------------------------- */

static void registers(void **state)
{
    static const uint16 sms[][2] = {{0x0800, 0x1800}, {0x0808, 0x1C00}, {0x0810, 0x1100}, {0x0818, 0x1140}};
    uint16 code;
    (void)state;
    assert_int_equal(get8(0x0205), 0x01); /* PREOP: Mail Out */
    to_safeop();
    assert_int_equal(get8(0x0205), 0x0D); /* Pro Out, Pro In */
    for (size_t i = 0; i < COUNT(sms); i++) {
        uint8 bytes[8];
        get(sms[i][0], bytes, sizeof bytes);
        assert_int_equal(bytes[0] | bytes[1] << 8, sms[i][1]);
    }
    assert_int_equal(get8(0x0120) & 0x0F, EC_STATE_SAFE_OP);
    assert_int_equal(get8(0x0130), EC_STATE_SAFE_OP);
    assert_int_equal(soem_request(&master, 1, EC_STATE_BOOT, &code), EC_STATE_SAFE_OP | EC_STATE_ERROR);
    assert_int_equal(code, 0x0011);
    soem_go(&master, 1, EC_STATE_PRE_OP);
    assert_int_equal(get8(0x0205), 0x01);
    soem_go(&master, 1, EC_STATE_INIT);
    assert_int_equal(get8(0x0205), 0x00);
    assert_int_equal(get8(0x0204) & 0x01, 0x01);
}

static void no_sync(void **state)
{
    (void)state;
    assert_string_equal(plant_get("display"), "n17");
    to_safeop();
    assert_string_equal(plant_get("display"), "n17");
    AWAIT(strcmp(plant_get("display"), "") == 0);
    put(CONTROL, 0x06);
    for (int i = 0; i < 20; i++)
        soem_cycle(&master);
    assert_int_equal(get16(STATUS) & 0x4F, 0x40); /* SAFEOP: status word, but no control word */
    soem_operational(&master);
    AWAIT((get16(STATUS) & 0x6F) == 0x21); /* OP: it counts */
    soem_go(&master, 1, EC_STATE_SAFE_OP);
    AWAIT((get16(STATUS) & 0x4F) == 0x40);
    soem_go(&master, 1, EC_STATE_PRE_OP);
    assert_string_equal(plant_get("display"), "n17");
}

/* SYNC0 with the cycle of 60C2h, down to 0.25 ms; with another one: n17, then F28 and 001Ah. */
static void clocks(void **state)
{
    static const struct {
        uint32 ns;
        uint8 units; /* 10 us */
        bool good;
    } rows[] = {{250000, 25, true}, {1000000, 100, true}, {2000000, 200, true}, {1000000, 200, false}};
    (void)state;
    plant_set("sync_timeout", "300");
    assert_true(ecx_configdc(&master.context));
    to_safeop();
    for (size_t i = 0; i < COUNT(rows); i++) {
        uint16 code;
        soem_go(&master, 1, EC_STATE_PRE_OP);
        assert_int_equal(write_number(0x10F1, 2, 0, 2), 0); /* this is no controller that keeps time */
        assert_int_equal(write_number(0x60C2, 1, rows[i].units, 1), 0);
        assert_int_equal(write_number(0x60C2, 2, 0xFB, 1), 0);
        ecx_dcsync0(&master.context, 1, TRUE, rows[i].ns, 0);
        soem_go(&master, 1, EC_STATE_SAFE_OP);
        if (rows[i].good) {
            AWAIT(strcmp(plant_get("display"), "") == 0);
            soem_operational(&master);
            continue;
        }
        for (int n = 0; n < 200; n++) /* SYNC0 begins 100 ms later at the earliest */
            soem_cycle(&master);
        assert_string_equal(plant_get("display"), "n17");
        (void)soem_request(&master, 1, EC_STATE_OPERATIONAL, &code);
        for (int n = 0; n < PATIENCE && strcmp(plant_get("display"), "F28") != 0; n++)
            soem_cycle(&master);
        assert_string_equal(plant_get("display"), "F28");
        ecx_readstate(&master.context);
        assert_int_equal(master.slaves[1].state, EC_STATE_SAFE_OP | EC_STATE_ERROR);
        assert_int_equal(master.slaves[1].ALstatuscode, 0x001A);
    }
    ecx_dcsync0(&master.context, 1, FALSE, 0, 0);
}

/* --- the state machine -------------------------------------------------------------------------------------------- */

static void sequence(void **state)
{
    static const uint16 in_the_middle[] = {0x07, 0x0F, 0x0B, 0x80F};
    (void)state;
    for (size_t i = 0; i < COUNT(in_the_middle); i++) {
        put32(POSITION, 1000000);
        put(CONTROL, in_the_middle[i]);
        for (int n = 0; n < 20; n++)
            soem_cycle(&master);
        assert_int_equal(get16(STATUS) & 0x4F, 0x40);
        assert_int_equal(plant_number("powered"), 0);
    }
    int32 at = get32(AT);
    enable();
    control(0x0B, 0x4F, 0x40); /* quick stop, at a standstill: at once */
    enable();
    control(0x0D, 0x4F, 0x40); /* disable voltage */
    enable();
    control(0x0E, 0x6F, 0x21); /* shutdown */
    control(0x0F, 0x6F, 0x23); /* bit 3 rises before Switched On is reached: the axis stays in it */
    control(0x07, 0x6F, 0x23);
    control(0x0F, 0x6F, 0x27);
    control(0x07, 0x6F, 0x23); /* disable operation */
    assert_true(abs(get32(AT) - at) < 1000);
    control(0x0F, 0x6F, 0x27);
    plant_set("sto", "1");
    AWAIT((get16(STATUS) & 0x4F) == 0x08);
    assert_string_equal(plant_get("display"), "F27");
    plant_set("sto", "0");
    control(0x00, 0x4F, 0x08);
    control(0x80, 0x4F, 0x40); /* reset */
}

static void status_bits(void **state)
{
    (void)state;
    enable();
    assert_int_equal(get16(STATUS) & 0x0A10, 0x0210); /* voltage, remote, no limit */
    plant_set("di3", "0");
    AWAIT((get16(STATUS) & 0x0880) == 0x0880); /* limit and warning */
    assert_string_equal(plant_get("display"), "n10");
    plant_set("di3", "1");
    AWAIT((get16(STATUS) & 0x0880) == 0);
    assert_int_equal(write_number(0x607A, 0, TURN, 4), 0);
    assert_int_equal(write_number(0x6060, 0, 1, 1), 0);
    control(0x5F, 0x8000, 0x8000); /* a motion task, relative */
    AWAIT((get16(STATUS) & 0x8400) == 0x0400);
    assert_int_equal(write_number(0x6060, 0, 8, 1), 0);
    put32(POSITION, get32(AT));
    control(0x0F, 0x6F, 0x27);
    for (int n = 0; n < 20; n++)
        soem_cycle(&master);
    control(0x80F, 0x1000, 0x1000); /* a reference run: here */
    AWAIT((get16(STATUS) & 0x3400) == 0x0400);
    put32(POSITION, 0);
    control(0x0F, 0x6F, 0x27);
    long long saves = plant_number("saves");
    control(0x100F, 0x6F, 0x27); /* SAVE */
    AWAIT(plant_number("saves") == saves + 1);
}

/* --- latches ------------------------------------------------------------------------------------------------------ */

static void latches(void **state)
{
    static const struct {
        const char *input, *from, *to;
        uint16 enable, read, shows; /* shows: the input's bit 12 to 15 afterwards */
    } rows[] = {{"di1", "0", "1", 0x01, 0x0100, 0x8000},
                {"di1", "1", "0", 0x02, 0x0200, 0x0000},
                {"di2", "0", "1", 0x04, 0x0300, 0x4000},
                {"di2", "1", "0", 0x08, 0x0400, 0x0000}};
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        plant_set(rows[i].input, rows[i].from);
        put(LATCH, 0);
        AWAIT((get16(LATCHED) & 0x0F1F) == 0);
        put(LATCH, rows[i].enable);
        for (int n = 0; n < 20; n++)
            soem_cycle(&master);
        assert_int_equal(get16(LATCHED) & 0x0F1F, 0);
        plant_set(rows[i].input, rows[i].to);
        AWAIT((get16(LATCHED) & 0x001F) == rows[i].enable);
        put(LATCH, rows[i].enable | rows[i].read);
        AWAIT((get16(LATCHED) & 0x0F1F) == (rows[i].enable | rows[i].read));
        assert_int_equal(get16(LATCHED) & 0xC000, rows[i].shows);
    }
    plant_set("di4", "0");
    AWAIT((get16(LATCHED) & 0x3000) == 0x2000);
    plant_set("di3", "0");
    AWAIT((get16(LATCHED) & 0x3000) == 0x0000);
}

/* Half a turn around the index pulse. */
static void index_latch(void **state)
{
    (void)state;
    enable();
    int32 from = get32(AT);
    double machine = strtod(plant_get("machine_position"), NULL);
    char text[32];
    snprintf(text, sizeof text, "%d", (int)machine + TURN / 4);
    plant_set("index_at", text);
    put(LATCH, 0x0010);
    for (int n = 0; n <= 256; n++) {
        put32(POSITION, from + n * (TURN / 512));
        soem_cycle(&master);
    }
    AWAIT((get16(LATCHED) & 0x001F) == 0x0010);
    put(LATCH, 0x0510);
    AWAIT((get16(LATCHED) & 0x0F1F) == 0x0510);
    if (abs(get32(LATCH1) - (from + TURN / 4)) > 2)
        fail_msg("latch C: expected %d, got %d", from + TURN / 4, get32(LATCH1));
}

/* --- the example -------------------------------------------------------------------------------------------------- */

/* The machine of the manual, relative to the present position of the shaft. */
static void build_machine(int32 here)
{
    char text[96];
    snprintf(text, sizeof text, "home_at=%d home_width=524288 probe_at=%d probe_width=1000", here + 2 * TURN,
             here + 4 * TURN);
    plant_set_all(text);
}

static void motion(void **state)
{
    axis_t axis = {.cycle_s = 0.002, .way = 4.0 * TURN, .speed = 10.0 * TURN, .acceleration = 100.0 * TURN};
    (void)state;
    build_machine((int32)strtod(plant_get("machine_position"), NULL));
    assert_int_equal(write_number(0x6060, 0, 8, 1), 0);
    assert_int_equal(write_number(0x6098, 0, 20, 1), 0);
    assert_int_equal(write_number(0x60C2, 1, 2, 1), 0);
    assert_int_equal(write_number(0x60C2, 2, 0xFD, 1), 0);
    to_op();
    for (int n = 0; n < PATIENCE && axis.phase < AXIS_DONE; n++) {
        if (soem_cycle(&master) > 0)
            axis_cycle(&axis, in, out);
    }
    if (axis.phase != AXIS_DONE)
        fail_msg("the axis stays %s: %s (status %04X)", axis_phase_name(axis.phase),
                 axis.failure ? axis.failure : "no reason", axis.status);
    assert_true(axis.probed);
    assert_int_equal(axis.probe, 2 * TURN);
    assert_true(abs(axis.position - 4 * TURN) < 1000);
    assert_int_equal(plant_number("homed"), 1);
}

#define FROM_PREOP(title, function) {title, function, open_preop, close_master, NULL}
#define TEST(title, function)       {title, function, open_operational, close_master, NULL}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        FROM_PREOP("PLZ-007 PLZ-008 PLZ-010 PLZ-012 PLZ-027 PLZ-028 PLZ-029 PLZ-030: the worked example, 1C12:1 = "
                   "1704h, and its reply; a mail that is not CoE gets a reply",
                   mailbox),
        FROM_PREOP(
            "PLZ-009 PLZ-011 PLZ-014: a mail raises SM0's event after its frame, is read and makes room for the next",
            mail_event),
        FROM_PREOP("PLZ-013 PLZ-015 PLZ-016 PLZ-018: registers, and which events are enabled in which state",
                   registers),
        FROM_PREOP("PLZ-017 PLZ-019 PLZ-020: n17, what SAFEOP and OP let through", no_sync),
        FROM_PREOP("PLZ-017 PLZ-025: SYNC0 from 0.25 ms on, at 60C2h's cycle; F28 at another", clocks),
        TEST("PLZ-021 PLZ-022 PLZ-031: enabled by the whole sequence alone; quick stop, STO, reset", sequence),
        TEST("PLZ-023 PLZ-024: status bits 10 to 15, the bits that start and save", status_bits),
        TEST("PLZ-001 PLZ-002 PLZ-004 PLZ-005 PLZ-006: external latches and digital inputs", latches),
        TEST("PLZ-003 PLZ-006: internal latch C", index_latch),
        FROM_PREOP("PLZ-019 PLZ-023: the motion program: reference run, trapezoid, touch probe", motion),
    };
    if (argc < 2)
        return 1;
    iface = argv[1];
    if (argc > 2)
        cmocka_set_test_filter(argv[2]);
    return cmocka_run_group_tests_name("PMCtendo DD5", tests, NULL, NULL);
}
