/* SPDX-License-Identifier: MIT */
/* Masters as they start, enable and reset a drive of an ESI file. A turn has 10 000 counts, a cycle is 1 ms. */
#include "drive_of_file.h"

/* --- enabling and resetting --------------------------------------------------------------------------------------- */

/* A control word, held until the status word has these bits. */
typedef struct step_of_master {
    uint16_t control, mask, value;
} step_of_master_t;
enum { STEPS = 8 };

static void play(const char *what, unsigned int axes, const step_of_master_t *steps)
{
    for (size_t k = 0; k < STEPS && steps[k].mask != 0; k++) {
        const step_of_master_t *s = &steps[k];
        for (unsigned int axis = 0; axis < axes; axis++) {
            const uint16_t more = (uint16_t)(0x800 * axis);
            put((uint16_t)(CONTROL + more), s->control);
            put((uint16_t)(TARGET + more), get((uint16_t)(ACTUAL + more)));
        }
        cycles(1);
        for (unsigned int axis = 0; axis < axes; axis++) {
            const uint16_t status = (uint16_t)(STATUS + 0x800 * axis);
            for (unsigned int n = 0; n < 100 && (get(status) & s->mask) != s->value; n++)
                cycles(1);
            if ((get(status) & s->mask) != s->value)
                fail_msg("%s: axis %u hangs at step %zu, status word is %04X", what, axis + 1, k + 1,
                         (unsigned int)get(status));
        }
    }
}

static void sequences(void **state)
{
    static const struct {
        const char *what;
        bool fault; /* present before */
        step_of_master_t steps[STEPS];
    } rows[] = {
        {"DRV-604 KickCAT", false, {{0x06, 0x11, 0x11}, {0x0F, 0x37, 0x37}, {0x00, 0x40, 0x40}}},
        {"DRV-605 KickCAT's reset",
         true,
         {{0x00, 0x08, 0x08}, {0x80, 0x08, 0}, {0x00, 0x40, 0x40}, {0x06, 0x11, 0x11}}},
        {"DRV-610 hal-cia402", false, {{0x06, 0x01, 0x01}, {0x07, 0x02, 0x02}, {0x0F, 0x04, 0x04}, {0x04, 0x40, 0x40}}},
        {"DRV-612 hal-cia402's reset", true, {{0x04, 0x08, 0x08}, {0x84, 0x08, 0}, {0x06, 0x01, 0x01}}},
        {"DRV-613 ros2", false, {{0x06, 0x6F, 0x21}, {0x07, 0x6F, 0x23}, {0x0F, 0x6F, 0x27}}},
        {"DRV-615 ros2's reset",
         true,
         {{0x0F, 0x4F, 0x08},
          {0x8F, 0x4F, 0x40},
          {0x8F, 0x4F, 0x40},
          {0x0E, 0x6F, 0x21},
          {0x07, 0x6F, 0x23},
          {0x0F, 0x6F, 0x27}}},
        {"DRV-621 TwinCAT", false, {{0x06, 0x6F, 0x21}, {0x07, 0x6F, 0x23}, {0x0F, 0x106F, 0x1027}}},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        servo(CSP, 10000);
        if (rows[i].fault) {
            set("axis1.fault", "16912");
            cycles(2);
        }
        play(rows[i].what, 1, rows[i].steps);
        close_drive(state);
    }
}

/* --- starting ----------------------------------------------------------------------------------------------------- */

static void start_sync0(uint32_t cycle_ns)
{
    uint8_t bytes[8];
    assert_int_equal(wire_write16(&wire, 0, ECT_REG_DC_CYCLIC_CONTROL, 0), 1);
    assert_int_equal(wire_read(&wire, 0, ECT_REG_DC_SYSTEM_TIME, bytes, 8), 1);
    ect_store_le64(bytes, ect_load_le64(bytes) + 10 * MS);
    assert_int_equal(wire_write(&wire, 0, ECT_REG_DC_START_TIME, bytes, 8), 1);
    ect_store_le32(bytes, cycle_ns);
    assert_int_equal(wire_write(&wire, 0, ECT_REG_DC_SYNC0_CYCLE, bytes, 4), 1);
    assert_int_equal(wire_write16(&wire, 0, ECT_REG_DC_CYCLIC_CONTROL, 0x0300), 1);
}

/* A reply of the mailbox: its length and value. */
static void expect_answer(const char *what, uint16_t index, uint8_t subindex, size_t size, int64_t value)
{
    uint8_t bytes[8] = {0};
    uint8_t want[8];
    size_t got = sizeof bytes;
    const uint32_t abort = wire_sdo_upload(&wire, 0, index, subindex, false, bytes, &got);
    ect_store_le64(want, (uint64_t)value);
    if (abort != 0 || got != size || memcmp(bytes, want, size) != 0)
        fail_msg("%s: %04X:%u: expected %zu bytes of %lld; abort %08X, %zu bytes of %lld", what, index, subindex, size,
                 (long long)value, (unsigned int)abort, got, (long long)ect_load_le64(bytes));
}

enum { MOST = 12 };

typedef struct mailbox_step {
    uint16_t index;
    uint8_t subindex, size;
    int64_t value;
} mailbox_step_t;

typedef struct master {
    const char *what, *type;
    mailbox_step_t reads[MOST], writes[MOST];
    uint32_t outputs[MOST], inputs[MOST]; /* entries of 1600h and 1A00h, none: as the file has them */
    unsigned int target_at;               /* the byte of 607Ah, after this mapping */
    unsigned int without_mode;            /* cycles with mode 0 */
    bool sync0;
    step_of_master_t steps[STEPS];
} master_t;

static const master_t masters[] = {
    {.what = "DRV-603 KickCAT",
     .type = "SERVO",
     .writes = {{0x60C2, 1, 1, 1}, {0x60C2, 2, 1, -3}, {0x6072, 0, 2, 1000}},
     .target_at = 4,
     .without_mode = 500,
     .steps = {{0x00, 0x6F, 0x40}, {0x06, 0x11, 0x11}, {0x0F, 0x37, 0x37}}},
    {.what = "DRV-607 LinuxCNC's lcec, without padding",
     .type = "SERVO",
     .outputs = {0x60400010, 0x60600008, 0x60810020, 0x607A0020, 0x60710010, 0x60FF0020},
     .inputs = {0x60410010, 0x60640020, 0x606C0020, 0x60610008},
     .target_at = 7,
     .steps = {{0x06, 0x6F, 0x21}, {0x07, 0x6F, 0x23}, {0x0F, 0x6F, 0x27}}},
    {.what = "DRV-607 LinuxCNC's lcec, two axes",
     .type = "DUAL",
     .target_at = 2,
     .steps = {{0x06, 0x6F, 0x21}, {0x07, 0x6F, 0x23}, {0x0F, 0x6F, 0x27}}},
    {.what = "DRV-608 LinuxCNC's lcec, start",
     .type = "SERVO",
     .reads = {{0x6502, 0, 4, 0x3ED},
               {0x6040, 0, 2, 0},
               {0x6060, 0, 1, 0},
               {0x607A, 0, 4, 0},
               {0x60FF, 0, 4, 0},
               {0x6071, 0, 2, 0}},
     .writes = {{0x605A, 0, 2, 6},
                {0x605B, 0, 2, 1},
                {0x605C, 0, 2, 1},
                {0x605D, 0, 2, 2},
                {0x605E, 0, 2, 2},
                {0x6007, 0, 2, 3},
                {0x60F2, 0, 2, 1},
                {0x607C, 0, 4, 500},
                {0x607D, 1, 4, -100000},
                {0x607D, 2, 4, 100000}},
     .target_at = 4,
     .steps = {{0x06, 0x6F, 0x21}, {0x07, 0x6F, 0x23}, {0x0F, 0x6F, 0x27}, {0x0B, 0x6F, 0x07}, {0x0F, 0x6F, 0x27}}},
    {.what = "DRV-614 ros2",
     .type = "SERVO",
     .writes = {{0x60C2, 1, 1, 1}, {0x60C2, 2, 1, -3}},
     .target_at = 4,
     .without_mode = 20,
     .sync0 = true,
     .steps = {{0x06, 0x6F, 0x21}, {0x07, 0x6F, 0x23}, {0x0F, 0x6F, 0x27}}},
    {.what = "DRV-620 TwinCAT",
     .type = "SERVO",
     .writes = {{0x6060, 0, 1, 8}, {0x60C2, 1, 1, 1}, {0x60C2, 2, 1, -3}},
     .outputs = {0x60400010, 0x607A0020, 0x60600008},
     .inputs = {0x60410010, 0x60640020, 0x60610008, 0x60F40020},
     .target_at = 2,
     .sync0 = true,
     .steps = {{0x06, 0x6F, 0x21}, {0x07, 0x6F, 0x23}, {0x0F, 0x106F, 0x1027}}},
};

static void map_all(uint16_t pdo, const uint32_t *entries)
{
    uint8_t count = 0;
    if (entries[0] == 0)
        return;
    map(pdo, 0, 0, 0);
    for (; entries[count] != 0; count++)
        map(pdo, (uint8_t)(count + 1), entries[count], 0);
    map(pdo, 0, count, 0);
    remapped[pdo == 0x1600 ? 0 : 1] = entries;
}

static void modes(unsigned int axes, int8_t mode)
{
    for (unsigned int axis = 0; axis < axes; axis++)
        put((uint16_t)(MODE + 0x800 * axis), mode);
}

static unsigned int axes_of(const master_t *m)
{
    return strcmp(m->type, "DUAL") == 0 ? 2 : 1;
}

static void prepare(const master_t *m)
{
    unsigned int at = 0;
    open_drive(m->type);
    signals("axis1.resolution", 10000);
    if (axes_of(m) == 2)
        signals("axis2.resolution", 10000);
    for (const mailbox_step_t *s = m->reads; s->index != 0; s++)
        expect_answer(m->what, s->index, s->subindex, s->size, s->value);
    for (const mailbox_step_t *s = m->writes; s->index != 0; s++) {
        assert_int_equal(write_sdo(s->index, s->subindex, s->value, s->size), 0);
        expect_answer(m->what, s->index, s->subindex, s->size, s->value);
    }
    map_all(0x1600, m->outputs);
    map_all(0x1A00, m->inputs);
    assert_int_equal(place(0x1C12, TARGET, &at), 4);
    assert_int_equal(at, m->target_at);
}

static void follows(const char *what, unsigned int axes)
{
    for (int32_t n = 1; n <= 200; n++) {
        for (unsigned int axis = 0; axis < axes; axis++)
            put((uint16_t)(TARGET + 0x800 * axis), 50 * n);
        cycles(1);
    }
    cycles(300);
    for (unsigned int axis = 0; axis < axes; axis++)
        expect_near(what, 10000, 2, (double)get((uint16_t)(ACTUAL + 0x800 * axis)));
}

static void starts(void **state)
{
    for (size_t i = 0; i < COUNT(masters); i++) {
        const master_t *m = &masters[i];
        const unsigned int axes = axes_of(m);
        prepare(m);
        if (m->sync0)
            start_sync0(MS);
        next_state(SAFEOP);
        modes(axes, m->without_mode > 0 ? 0 : CSP);
        next_state(OP);
        if (m->without_mode > 0) {
            cycles(m->without_mode);
            assert_int_equal(get(SHOWN), 0);
            assert_int_equal(state_of(get(STATUS)), SOD);
        }
        modes(axes, CSP);
        cycles(1);
        play(m->what, axes, m->steps);
        for (unsigned int axis = 0; axis < axes; axis++)
            assert_int_equal(get((uint16_t)(SHOWN + 0x800 * axis)), CSP);
        follows(m->what, axes);
        close_drive(state);
    }
}

/* SERVO with SYNC0 among the AL events (0151h bit 3), unlike in its file. */
static void open_with_sync0_event(void)
{
    enum { SYNC_CONFIG = 6 };
    static const char config[] = "0504034464000000";
    static char text[200000];
    char why[300] = "";
    FILE *file = fopen(ESI_FILES "/drives.xml", "r");
    assert_non_null(file);
    const size_t length = fread(text, 1, sizeof text - 1, file);
    text[length] = '\0';
    (void)fclose(file);
    for (char *at = strstr(text, config); at != NULL; at = strstr(at, config))
        memcpy(at + SYNC_CONFIG, "CC", 2);
    twin = ect_esi_twin_take(ect_esi_parse("drives.xml", text, length, why, sizeof why), "SERVO", NULL, 0, why,
                             sizeof why);
    if (twin == NULL || !ect_esi_twin_behave(twin, ECT_BEHAVIOUR_BY_FILE, why, sizeof why))
        fail_msg("expected a twin, got: %s", why);
    open_twin();
}

/* SYNC0 of 1 ms: its order does not matter, another 60C2h ends OP after a time. */
static void orders_of_sync0(void **state)
{
    enum { BEFORE_MAPPING, IN_PREOP, IN_SAFEOP };
    static const uint32_t outputs[MOST] = {0x60400010, 0x60600008, 0x607A0020};
    static const struct {
        const char *what;
        int order;
        uint8_t cycle_ms, al;
        bool event;
    } rows[] = {{"before the mapping", BEFORE_MAPPING, 1, OP, false},
                {"in PREOP", IN_PREOP, 1, OP, false},
                {"in SAFEOP", IN_SAFEOP, 1, OP, false},
                {"60C2h, before the mapping", BEFORE_MAPPING, 2, SAFEOP, false},
                {"60C2h, in PREOP", IN_PREOP, 2, SAFEOP, false},
                {"60C2h, in SAFEOP", IN_SAFEOP, 2, SAFEOP, false},
                {"an event, before the mapping", BEFORE_MAPPING, 1, OP, true},
                {"an event, in PREOP", IN_PREOP, 1, OP, true},
                {"an event, in SAFEOP", IN_SAFEOP, 1, OP, true},
                {"an event, 60C2h, before the mapping", BEFORE_MAPPING, 2, SAFEOP, true},
                {"an event, 60C2h, in PREOP", IN_PREOP, 2, SAFEOP, true},
                {"an event, 60C2h, in SAFEOP", IN_SAFEOP, 2, SAFEOP, true}};
    for (size_t i = 0; i < COUNT(rows); i++) {
        if (rows[i].event)
            open_with_sync0_event();
        else
            open_drive("SERVO");
        set("axis1.sync_check", "1");
        if (rows[i].order == BEFORE_MAPPING)
            start_sync0(MS);
        assert_int_equal(write_sdo(0x60C2, 1, rows[i].cycle_ms, 1), 0);
        assert_int_equal(write_sdo(0x60C2, 2, -3, 1), 0);
        map_all(0x1600, outputs);
        if (rows[i].order == IN_PREOP)
            start_sync0(MS);
        next_state(SAFEOP);
        if (rows[i].order == IN_SAFEOP)
            start_sync0(MS);
        put(MODE, CSP);
        next_state(OP);
        cycles(100);
        if ((wire_read8(&wire, 0, ECT_REG_AL_STATUS) & 0x0F) != rows[i].al)
            fail_msg("%s: AL status %02X", rows[i].what, wire_read8(&wire, 0, ECT_REG_AL_STATUS));
        close_drive(state);
    }
}

/* Frames arrive each millisecond, SYNC0 occurs every 10 ms: of ten set values only the one before SYNC0 counts. */
static void set_values_at_sync0(void **state)
{
    enum { CYCLE_MS = 10, CYCLES = 60, STEP = 1000, IGNORED = 500000 };
    (void)state;
    open_with_sync0_event();
    set("axis1.sync_check", "0");
    assert_int_equal(write_sdo(0x60C2, 1, CYCLE_MS, 1), 0);
    assert_int_equal(write_sdo(0x60C2, 2, -3, 1), 0);
    next_state(SAFEOP);
    start_sync0(CYCLE_MS * MS);
    const uint64_t start_ns = wire.now_ns;
    put(MODE, CSP);
    next_state(OP);
    enable(0);
    int64_t taken = 0;
    for (unsigned int n = 1; n <= CYCLES; n++) {
        const bool before_sync0 = (wire.now_ns - start_ns) / MS % CYCLE_MS == CYCLE_MS - 1;
        const int64_t reached = taken;
        taken += before_sync0 ? STEP : 0;
        put(TARGET, before_sync0 || taken == 0 ? taken : IGNORED);
        cycles(1);
        const int64_t demand = read_sdo(0x6062, 0);
        if (reached == 0) /* before the first SYNC0, set values count at once */
            continue;
        if (demand < reached - STEP || demand > reached || (before_sync0 && demand != reached))
            fail_msg("ms %u: expected a demand on the way to %lld, got %lld", n, (long long)reached, (long long)demand);
    }
    assert_true(taken > 4 * (int64_t)STEP);
}

/* --- LinuxCNC ----------------------------------------------------------------------------------------------------- */

static void homing_of_linuxcnc(void **state)
{
    (void)state;
    servo(CSP, 10000);
    enable(0);
    assert_int_equal(write_sdo(0x6098, 0, 34, 1), 0);
    set("axis1.index_at", "3000");
    put(MODE, HM);
    cycles(1);
    assert_int_equal(get(SHOWN), HM);
    put(CONTROL, START);
    unsigned int held = 0;
    for (unsigned int n = 0; n < 20000 && held < 100; n++) {
        cycles(1);
        held = (get(STATUS) & 0x1400) == 0x1400 ? held + 1 : 0;
    }
    assert_int_equal(held, 100);
    put(TARGET, get(ACTUAL));
    put(CONTROL, ENABLE);
    put(MODE, CSP);
    cycles(50);
    assert_int_equal(state_of(get(STATUS)), ENABLED);
    assert_true(llabs(get(ACTUAL)) <= 1);
}

static void inputs_and_outputs_of_lcec(void **state)
{
    static const struct {
        const char *signal, *value;
        uint32_t bits;
    } inputs[] = {{"axis1.negative_free", "0", 0x01},
                  {"axis1.positive_free", "0", 0x03},
                  {"axis1.home", "1", 0x20007},
                  {"axis1.sto", "1", 0x2000F},
                  {"axis1.probe", "1", 0x3000F}};
    (void)state;
    servo(CSV, 10000);
    set("axis1.brake", "100");
    enable(0);
    put(0x60FF, 20000);
    cycles(500);
    expect_near("the brake is open", 20000, 200, (double)get(0x606C));
    assert_int_equal(write_sdo(0x60FE, 2, 0x10001, 4), 0);
    assert_int_equal(write_sdo(0x60FE, 1, 0x10001, 4), 0);
    cycles(500);
    expect_answer("60FEh", 0x60FE, 1, 4, 0x10001);
    expect_near("bit 0 closes it", 0, 20, (double)get(0x606C));
    put(CONTROL, 0);
    cycles(10);
    for (size_t i = 0; i < COUNT(inputs); i++) {
        set(inputs[i].signal, inputs[i].value);
        cycles(1);
        expect_answer(inputs[i].signal, 0x60FD, 0, 4, inputs[i].bits);
    }
}

static void pairs_of_lcec(void **state)
{
    static const uint16_t pairs[] = {0x608F, 0x6091, 0x6092};
    uint8_t bytes[8];
    size_t size = sizeof bytes;
    (void)state;
    open_drive("SCREW");
    for (size_t i = 0; i < COUNT(pairs); i++) {
        for (uint8_t s = 1; s <= 2; s++)
            expect_answer("a pair", pairs[i], s, 4, value_of(pairs[i], s));
    }
    assert_int_equal(wire_sdo_upload(&wire, 0, 0x6093, 1, false, bytes, &size), 0x06020000);
}

/* --- CODESYS ------------------------------------------------------------------------------------------------------ */

/* SoftMotion Light without 6040h in its PDO: pp by control words of the mailbox, in OP. */
static void control_by_mailbox(void **state)
{
    static const uint32_t outputs[MOST] = {0x607A0020, 0x60600008};
    static const mailbox_step_t objects[] = {{0x6040, 0, 2, 0},      {0x6060, 0, 1, 0},      {0x6061, 0, 1, 0},
                                             {0x6064, 0, 4, 0},      {0x607A, 0, 4, 0},      {0x607C, 0, 4, 0},
                                             {0x60FF, 0, 4, 0},      {0x605A, 0, 2, 2},      {0x605D, 0, 2, 1},
                                             {0x6081, 0, 4, 50000},  {0x6083, 0, 4, 100000}, {0x6084, 0, 4, 100000},
                                             {0x6085, 0, 4, 500000}, {0x6086, 0, 2, 0}};
    static const struct {
        uint16_t control;
        unsigned int state;
    } words[] = {{SHUTDOWN, READY}, {SWITCH_ON, SWITCHED_ON}, {ENABLE, ENABLED}, {START, ENABLED}};
    (void)state;
    open_drive("SERVO");
    signals("axis1.resolution", 10000);
    settings(50000, 100000);
    for (size_t i = 0; i < COUNT(objects); i++)
        expect_answer("CODESYS", objects[i].index, 0, objects[i].size, objects[i].value);
    map_all(0x1600, outputs);
    next_state(SAFEOP);
    put(MODE, PP);
    put(TARGET, 10000);
    next_state(OP);
    for (size_t i = 0; i < COUNT(words); i++) {
        assert_int_equal(write_sdo(CONTROL, 0, words[i].control, 2), 0);
        cycles(2);
        until(0, words[i].state);
    }
    for (unsigned int n = 0; n < 5000 && (get(STATUS) & 0x0400) == 0; n++)
        cycles(1);
    expect_near("the set-point", 10000, 20, (double)get(ACTUAL));
}

/* SoftMotion Light: 605Dh 2, a quick stop that stays, 6086h 0, home offset added. */
static void settings_of_codesys(void **state)
{
    (void)state;
    servo(HM, 10000);
    set("axis1.home_offset_added", "1");
    assert_int_equal(write_sdo(0x605D, 0, 2, 2), 0);
    assert_int_equal(write_sdo(0x605A, 0, 6, 2), 0);
    assert_int_equal(write_sdo(0x6086, 0, 0, 2), 0);
    enable(0);
    assert_int_equal(home(37, 1000), 5);
    assert_int_equal(get(ACTUAL), 1000);
    put(CONTROL, ENABLE);
    put(MODE, PV);
    put(0x60FF, 20000);
    cycles(500);
    expect_near("increments a second", 20000, 200, (double)get(0x606C));
    put(CONTROL, 0x10F); /* halt, on 6085h */
    cycles(50);
    expect_near("halted", 0, 20, (double)get(0x606C));
    command(0, 0x0B, STOPPING);
    cycles(1000);
    assert_int_equal(state_of(get(STATUS)), STOPPING);
    command(0, ENABLE, ENABLED);
}

/* The user's source of both probes, index pulses, is kept when CODESYS arms them. */
static void probes_of_codesys(void **state)
{
    enum { SOURCE = 0x0404, ARMED = 0x1111 };
    (void)state;
    servo(CSP, 10000);
    signals("axis1.index_at", 1500);
    assert_int_equal(write_sdo(0x60B8, 0, SOURCE, 2), 0);
    enable(0);
    assert_int_equal(write_sdo(0x60B8, 0, read_sdo(0x60B8, 0) | ARMED, 2), 0);
    expect_answer("60B8h", 0x60B8, 0, 2, SOURCE | ARMED);
    set("axis1.probe", "1"); /* not the source */
    follows("csp", 1);
    expect_answer("positive edges of both", 0x60B9, 0, 2, 0x0303);
    expect_answer("probe 1", 0x60BA, 0, 4, 1500);
    expect_answer("probe 2", 0x60BC, 0, 4, 1500);
    assert_int_equal(write_sdo(0x60B8, 0, read_sdo(0x60B8, 0) & ~ARMED, 2), 0);
    expect_answer("60B8h", 0x60B8, 0, 2, SOURCE);
    expect_answer("off", 0x60B9, 0, 2, 0);
}

int main(void)
{
#define TEST(title, function) {title, function, NULL, close_drive, NULL}
    const struct CMUnitTest tests[] = {
        TEST("DRV-604 DRV-605 DRV-610 DRV-612 DRV-613 DRV-615 DRV-621 the enabling and resetting of masters",
             sequences),
        TEST("DRV-603 DRV-607 DRV-608 DRV-614 DRV-620 masters from the mailbox to a motion in csp", starts),
        TEST("DRV-624 SYNC0 starts at any time below OP; a wrong 60C2h ends OP after a time", orders_of_sync0),
        TEST("DRV-255 set values are taken at SYNC0, if it is an AL event", set_values_at_sync0),
        TEST("DRV-611 DRV-272 the homing of LinuxCNC", homing_of_linuxcnc),
        TEST("DRV-609 the digital inputs and outputs of LinuxCNC", inputs_and_outputs_of_lcec),
        TEST("DRV-609 the pairs of LinuxCNC, without 6093h", pairs_of_lcec),
        TEST("DRV-616 CODESYS commands by the mailbox where 6040h is not mapped", control_by_mailbox),
        TEST("DRV-617 the settings of CODESYS", settings_of_codesys),
        TEST("DRV-619 CODESYS arms probes and keeps their sources", probes_of_codesys),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
