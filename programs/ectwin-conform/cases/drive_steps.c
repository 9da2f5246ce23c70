/* SPDX-License-Identifier: MIT */
#include "cases/drive_steps.h"

#include <string.h>

enum { ASSIGNMENTS = 0x1C10, CYCLE_MS = 1, STOP_CYCLES = 300, MODE_BITS = 32 };

static uint16_t object(const drive_t *d, uint16_t index)
{
    return (uint16_t)(index + DRIVE_AXIS * d->axis);
}

/* --- the image ---------------------------------------------------------------------------------------------------- */

static const drive_entry_t *find(const drive_map_t *map, uint16_t index, uint8_t sub)
{
    for (unsigned int i = 0; i < map->count; i++) {
        if (map->entries[i].index == index && map->entries[i].sub == sub)
            return &map->entries[i];
    }
    return NULL;
}

static void put_bits(uint8_t *image, const drive_entry_t *e, uint64_t value)
{
    for (unsigned int i = 0; i < e->bits; i++) {
        const uint32_t at = e->at + i;
        const uint64_t bit = i < 64 ? value >> i & 1u : 0;
        image[at / 8] = (uint8_t)((image[at / 8] & ~(1u << at % 8)) | (bit != 0 ? 1u << at % 8 : 0u));
    }
}

static int64_t extended(uint64_t value, unsigned int bits)
{
    if (bits == 0 || bits >= 64)
        return (int64_t)value;
    const uint64_t sign = UINT64_C(1) << (bits - 1);
    return (int64_t)(((value & (2 * sign - 1)) ^ sign) - sign);
}

static int64_t get_bits(const uint8_t *image, const drive_entry_t *e)
{
    uint64_t value = 0;
    for (unsigned int i = 0; i < e->bits && i < 64; i++)
        value |= (uint64_t)((unsigned int)image[(e->at + i) / 8] >> (e->at + i) % 8 & 1u) << i;
    return extended(value, e->bits);
}

static void read_pdo(cf_t *c, drive_map_t *map, uint16_t pdo, uint32_t *bits)
{
    const unsigned int entries = (unsigned int)cf_upload_number(c, pdo, 0);
    for (unsigned int i = 1; i <= entries; i++) {
        const uint32_t word = (uint32_t)cf_upload_number(c, pdo, (uint8_t)i);
        if (map->count < DRIVE_ENTRIES)
            map->entries[map->count++] =
                (drive_entry_t){(uint16_t)(word >> 16), (uint8_t)(word >> 8), (uint8_t)word, *bits};
        *bits += word & 0xFF;
    }
}

/* The images of several SyncManagers follow one another at whole bytes, as in ::cf_set_process_data. */
static void read_map(cf_t *c, drive_map_t *map, uint8_t type)
{
    uint32_t first = 0;
    map->count = 0;
    for (unsigned int n = 0; n < c->facts.sm_count; n++) {
        uint32_t code, bits = first;
        const uint16_t assignment = (uint16_t)(ASSIGNMENTS + n);
        if (c->facts.sm[n].type != type || !cf_object_exists(c, assignment, 0, &code))
            continue;
        const unsigned int count = (unsigned int)cf_upload_number(c, assignment, 0);
        for (unsigned int i = 1; i <= count; i++)
            read_pdo(c, map, (uint16_t)cf_upload_number(c, assignment, (uint8_t)i), &bits);
        first += 8u * c->facts.sm[n].length;
    }
}

/* --- objects ------------------------------------------------------------------------------------------------------ */

static const drive_entry_t *output(const drive_t *d, uint16_t index, uint8_t sub)
{
    return find(&d->outputs, object(d, index), sub);
}

static const drive_entry_t *input(const drive_t *d, uint16_t index, uint8_t sub)
{
    return find(&d->inputs, object(d, index), sub);
}

bool drive_maps_input(const drive_t *d, uint16_t index)
{
    return input(d, index, 0) != NULL;
}

bool drive_maps_output(const drive_t *d, uint16_t index, uint8_t sub)
{
    return output(d, index, sub) != NULL;
}

bool drive_has(drive_t *d, uint16_t index, uint8_t sub)
{
    uint32_t code;
    return output(d, index, sub) || input(d, index, sub) || cf_object_exists(d->c, object(d, index), sub, &code);
}

static uint32_t load(drive_t *d, uint16_t index, uint8_t sub, int64_t *value, size_t *size)
{
    uint8_t data[8] = {0};
    *size = sizeof data;
    const uint32_t code = cf_upload(d->c, object(d, index), sub, false, data, size);
    *value = code == 0 ? extended(ect_load_le64(data), 8 * (unsigned int)*size) : 0;
    return code;
}

int64_t drive_get(drive_t *d, uint16_t index, uint8_t sub)
{
    size_t size;
    int64_t value;
    const drive_entry_t *e = input(d, index, sub);
    if (e && d->in_op)
        return get_bits(d->in, e);
    const uint32_t code = load(d, index, sub, &value, &size);
    if (code != 0)
        cf_fail(d->c, "upload of %04Xh:%02X: expected data, got abort 0x%08X", object(d, index), sub, code);
    return value;
}

/* Commands, which need no restoring: control word and set values. */
static bool is_command(uint16_t index)
{
    return index == DRIVE_CONTROL || index == DRIVE_TARGET || index == DRIVE_TARGET_SPEED ||
           index == DRIVE_TARGET_TORQUE || index == DRIVE_RECORD;
}

uint32_t drive_set(drive_t *d, uint16_t index, uint8_t sub, int64_t value)
{
    size_t size;
    int64_t old;
    uint8_t data[8];
    const drive_entry_t *e = output(d, index, sub);
    if (e && d->in_op) {
        put_bits(d->out, e, (uint64_t)value);
        return 0;
    }
    const uint32_t code = load(d, index, sub, &old, &size);
    if (code != 0 || (old == value && index != DRIVE_CONTROL))
        return code;
    ect_store_le64(data, (uint64_t)value);
    return is_command(index) ? cf_download(d->c, object(d, index), sub, false, data, size)
                             : cf_change(d->c, object(d, index), sub, data, size);
}

/* --- cycles ------------------------------------------------------------------------------------------------------- */

static void exchange(drive_t *d)
{
    cf_t *c = d->c;
    if (d->inputs_only)
        cf_expect_wkc(c, "inputs", 1, cf_read_inputs(c, d->in));
    else
        cf_expect_wkc(c, "process data", cf_cycle_wkc(c), cf_cycle(c, d->out, d->in));
}

/* Stops the axis with a quick stop before the case fails. */
static _Noreturn void runs_away(drive_t *d, int64_t way)
{
    d->guarded = false;
    (void)drive_set(d, DRIVE_CONTROL, 0, DRIVE_QUICK_STOP);
    drive_cycles(d, STOP_CYCLES);
    cf_fail(d->c, "axis %u: travel (6064h): expected at most %lld units of --move, got %lld", d->axis + 1,
            (long long)d->c->move.distance, (long long)way);
}

static void record(drive_t *d)
{
    const drive_entry_t *e = input(d, DRIVE_ACTUAL, 0);
    if (!e)
        return;
    const int64_t now = get_bits(d->in, e);
    d->history[d->cycles % DRIVE_HISTORY] = now;
    d->history_ns[d->cycles % DRIVE_HISTORY] = cf_now_ns();
    d->cycles++;
    if (!d->guarded)
        return;
    const int64_t way = extended((uint64_t)now - (uint64_t)d->origin, e->bits);
    if (way > d->c->move.distance || way < -d->c->move.distance)
        runs_away(d, way);
}

void drive_cycle(drive_t *d)
{
    cf_sleep_ms(d->c, CYCLE_MS);
    exchange(d);
    record(d);
}

void drive_cycles(drive_t *d, unsigned int count)
{
    while (count-- > 0)
        drive_cycle(d);
}

static void idle(cf_t *c, void *ctx)
{
    (void)c;
    drive_cycle(ctx);
}

/* --- states ------------------------------------------------------------------------------------------------------- */

uint16_t drive_status(drive_t *d)
{
    return (uint16_t)drive_get(d, DRIVE_STATUS, 0);
}

drive_state_t drive_state(uint16_t status)
{
    static const struct {
        uint16_t mask, bits;
    } rows[] = {{0x4F, DRIVE_NOT_READY}, {0x4F, DRIVE_DISABLED}, {0x6F, DRIVE_READY},    {0x6F, DRIVE_SWITCHED_ON},
                {0x6F, DRIVE_ENABLED},   {0x6F, DRIVE_STOPPING}, {0x4F, DRIVE_REACTION}, {0x4F, DRIVE_FAULT}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        if ((status & rows[i].mask) == rows[i].bits)
            return (drive_state_t)rows[i].bits;
    }
    return DRIVE_NO_STATE;
}

const char *drive_state_name(drive_state_t state)
{
    switch (state) {
    case DRIVE_NOT_READY:
        return "Not ready to switch on";
    case DRIVE_DISABLED:
        return "Switch on disabled";
    case DRIVE_READY:
        return "Ready to switch on";
    case DRIVE_SWITCHED_ON:
        return "Switched on";
    case DRIVE_ENABLED:
        return "Operation enabled";
    case DRIVE_STOPPING:
        return "Quick stop active";
    case DRIVE_REACTION:
        return "Fault reaction active";
    case DRIVE_FAULT:
        return "Fault";
    default:
        return "no state";
    }
}

void drive_command(drive_t *d, uint16_t control)
{
    const uint32_t code = drive_set(d, DRIVE_CONTROL, 0, control);
    if (code != 0)
        cf_fail(d->c, "download to %04Xh, which no PDO maps: abort 0x%08X", object(d, DRIVE_CONTROL), code);
    drive_cycle(d);
}

bool drive_wait(drive_t *d, uint16_t mask, uint16_t wanted, uint32_t ms)
{
    const uint64_t until = cf_now_ns() + ms * UINT64_C(1000000);
    for (;;) {
        const bool over = cf_now_ns() >= until;
        drive_cycle(d);
        if ((drive_status(d) & mask) == wanted)
            return true;
        if (over)
            return false;
    }
}

void drive_expect_state(drive_t *d, drive_state_t state, uint32_t ms, const char *cause)
{
    const uint64_t until = cf_now_ns() + ms * UINT64_C(1000000);
    uint16_t status = drive_status(d);
    while (drive_state(status) != state && cf_now_ns() < until) {
        drive_cycle(d);
        status = drive_status(d);
    }
    cf_expect_that(d->c, drive_state(status) == state, "axis %u, %s: expected %s within %u ms, got %s (6041h 0x%04X)",
                   d->axis + 1, cause, drive_state_name(state), ms, drive_state_name(drive_state(status)), status);
}

static const char *command_name(uint16_t control)
{
    switch (control) {
    case 0:
        return "Disable voltage (00h)";
    case DRIVE_QUICK_STOP:
        return "Quick stop (02h)";
    case DRIVE_SHUTDOWN:
        return "Shutdown (06h)";
    case DRIVE_SWITCH_ON:
        return "Switch on, Disable operation (07h)";
    case DRIVE_ENABLE:
        return "Enable operation (0Fh)";
    case DRIVE_RESET:
        return "Fault reset (80h)";
    default:
        return "a control word";
    }
}

void drive_go(drive_t *d, uint16_t control, drive_state_t state)
{
    cf_step(d->c, "axis %u: %s", d->axis + 1, command_name(control));
    drive_command(d, control);
    drive_expect_state(d, state, DRIVE_WAIT_MS, command_name(control));
}

void drive_expect_stays(drive_t *d, uint16_t control, drive_state_t state)
{
    cf_step(d->c, "axis %u: %s, which %s ignores", d->axis + 1, command_name(control), drive_state_name(state));
    drive_command(d, control);
    drive_cycles(d, DRIVE_SETTLE_MS);
    const uint16_t status = drive_status(d);
    cf_expect_that(d->c, drive_state(status) == state, "axis %u, %s: expected still %s, got %s (6041h 0x%04X)",
                   d->axis + 1, command_name(control), drive_state_name(state), drive_state_name(drive_state(status)),
                   status);
}

/* --- modes -------------------------------------------------------------------------------------------------------- */

bool drive_supports(drive_t *d, int8_t mode)
{
    if (!drive_has(d, DRIVE_MODES, 0))
        return mode == DRIVE_CSP && output(d, DRIVE_TARGET, 0);
    return ((uint64_t)drive_get(d, DRIVE_MODES, 0) >> (mode - 1) & 1u) != 0;
}

static void show_mode(drive_t *d, int8_t mode)
{
    const uint64_t until = cf_now_ns() + DRIVE_WAIT_MS * UINT64_C(1000000);
    int64_t shown = drive_get(d, DRIVE_MODE_DISPLAY, 0);
    while (shown != mode && cf_now_ns() < until) {
        drive_cycle(d);
        shown = drive_get(d, DRIVE_MODE_DISPLAY, 0);
    }
    cf_expect_that(d->c, shown == mode, "axis %u, modes of operation display (6061h): expected %d, got %lld",
                   d->axis + 1, mode, (long long)shown);
}

void drive_choose(drive_t *d, int8_t mode)
{
    if (!drive_has(d, DRIVE_MODE, 0))
        return;
    const uint32_t code = drive_set(d, DRIVE_MODE, 0, mode);
    if (code != 0)
        cf_fail(d->c, "axis %u: mode %d of 6502h in 6060h: abort 0x%08X", d->axis + 1, mode, code);
    drive_cycle(d);
    if (drive_has(d, DRIVE_MODE_DISPLAY, 0))
        show_mode(d, mode);
}

void drive_set_position(drive_t *d, int64_t position)
{
    if (output(d, DRIVE_TARGET, 0))
        (void)drive_set(d, DRIVE_TARGET, 0, position);
    if (output(d, DRIVE_RECORD, 1))
        (void)drive_set(d, DRIVE_RECORD, 1, position);
}

void drive_hold(drive_t *d)
{
    if (drive_has(d, DRIVE_ACTUAL, 0))
        drive_set_position(d, drive_get(d, DRIVE_ACTUAL, 0));
    (void)drive_set(d, DRIVE_TARGET_SPEED, 0, 0);
    (void)drive_set(d, DRIVE_TARGET_TORQUE, 0, 0);
}

void drive_enable(drive_t *d)
{
    drive_hold(d);
    drive_go(d, DRIVE_SHUTDOWN, DRIVE_READY);
    drive_hold(d);
    drive_go(d, DRIVE_SWITCH_ON, DRIVE_SWITCHED_ON);
    drive_hold(d);
    drive_go(d, DRIVE_ENABLE, DRIVE_ENABLED);
}

/* --- an axis ------------------------------------------------------------------------------------------------------ */

drive_t *drive_open(cf_t *c)
{
    static drive_t drive; /* too large for a stack */
    drive_t *d = &drive;
    uint32_t code;
    memset(d, 0, sizeof *d);
    d->c = c;
    cf_go(c, CF_PREOP);
    read_map(c, &d->outputs, ECT_SM_OUTPUTS);
    read_map(c, &d->inputs, ECT_SM_INPUTS);
    for (unsigned int axis = 0; axis < DRIVE_AXES; axis++) {
        const uint16_t shift = (uint16_t)(DRIVE_AXIS * axis);
        if (cf_object_exists(c, (uint16_t)(DRIVE_STATUS + shift), 0, &code) &&
            cf_object_exists(c, (uint16_t)(DRIVE_CONTROL + shift), 0, &code))
            d->axes |= 1u << axis;
    }
    return d;
}

/* Mapped outputs begin with the values of their objects, except control words: a limit of 0 would hold the axis. */
static void fill_outputs(drive_t *d)
{
    uint8_t data[8];
    for (unsigned int i = 0; i < d->outputs.count; i++) {
        const drive_entry_t *e = &d->outputs.entries[i];
        const bool command = e->index >= DRIVE_CONTROL && (e->index - DRIVE_CONTROL) % DRIVE_AXIS == 0;
        size_t size = sizeof data;
        memset(data, 0, sizeof data);
        if (e->index != 0 && !command && e->bits <= 64 && cf_upload(d->c, e->index, e->sub, false, data, &size) == 0)
            put_bits(d->out, e, ect_load_le64(data));
    }
}

/* A fault of an earlier case is reset. */
static void reset_fault(drive_t *d)
{
    drive_command(d, 0);
    drive_cycles(d, DRIVE_SETTLE_MS);
    if (drive_state(drive_status(d)) == DRIVE_FAULT) {
        drive_command(d, DRIVE_RESET);
        drive_cycles(d, DRIVE_SETTLE_MS);
        drive_command(d, 0);
    }
    drive_expect_state(d, DRIVE_DISABLED, DRIVE_WAIT_MS, "control word 0 in OP");
}

static void begin_axis(drive_t *d)
{
    drive_hold(d);
    reset_fault(d);
    d->cycles = 0;
    d->guarded = d->c->move.distance > 0 && drive_maps_input(d, DRIVE_ACTUAL);
    if (d->guarded)
        d->origin = drive_get(d, DRIVE_ACTUAL, 0);
}

const drive_t *drive_each_axis(cf_t *c, void (*run)(drive_t *d))
{
    drive_t *d = drive_open(c);
    fill_outputs(d);
    cf_go(c, CF_OP);
    d->in_op = true;
    cf_while_waiting(c, idle, d);
    drive_cycle(d);
    for (d->axis = 0; d->axis < DRIVE_AXES; d->axis++) {
        if ((d->axes & 1u << d->axis) == 0)
            continue;
        begin_axis(d);
        run(d);
        drive_go(d, 0, DRIVE_DISABLED);
        d->guarded = false;
    }
    cf_while_waiting(c, NULL, NULL);
    return d;
}
