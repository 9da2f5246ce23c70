/* SPDX-License-Identifier: MIT */
#include "wiring_args.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bus_place.h"
#include "check/check.h"
#include "commands.h"
#include "esc/personality.h"
#include "grow.h"
#include "seams/random.h"
#include "sii/fit.h"
#include "text/argument.h"
#include "text/number.h"
#include "twin_names.h"

enum {
    KEY_ESC = 0x200,
    KEY_DRIFT,
    KEY_CABLE,
    KEY_WIRE,
    KEY_EEPROM,
    KEY_LIKE,
    KEY_AL,
    KEY_MAILBOX,
    KEY_JITTER,
    KEY_DC_JITTER
};

static const struct argp_option options[] = {
    {"esc", KEY_ESC, "[N:]NAME", 0,
     "ESC chip of twin N, or of all twins without N (default: that of the device); 'help' lists the chips", 2},
    {"drift", KEY_DRIFT, "[N:]PPM", 0,
     "Deviation of the oscillator of twin N, -1000 to 1000, above 0: fast. Without N: a random deviation of each "
     "twin, at most PPM, from --seed (default 0)",
     2},
    {"cable", KEY_CABLE, "[N:]METRES", 0,
     "Length of the cable at the input of twin N, or of all twins without N, 0 to 1000 metres (default 1). The "
     "length adds to the propagation delays of distributed clocks",
     2},
    {"eeprom-times", KEY_EEPROM, "[N:]TIMES", 0,
     "Duration of the EEPROM commands of twin N, or of all twins without N: 'chip', as with an I2C EEPROM, 0.3 to "
     "1.2 ms and 5 ms after a written word, or 'short', 20 us (default: short). May be repeated",
     2},
    {"like", KEY_LIKE, "[N:]BOARD", 0,
     "Board that twin N imitates, or all twins without N: the ESC chip, the memory layout, the duration of "
     "accesses to the ESC, and --eeprom-times chip; 'help' lists the boards",
     2},
    {"al-delay", KEY_AL, "[N:]RANGE", 0,
     "Time from a request in AL control until twin N, or each twin without N, processes it: MIN[..MAX] ms, 0 to "
     "60000, at random from --seed (default 0). May be repeated",
     2},
    {"mailbox-delay", KEY_MAILBOX, "[N:]RANGE", 0,
     "Time from a mail until twin N, or each twin without N, reads it and replies: MIN[..MAX] ms, 0 to 60000, at "
     "random from --seed (default 0). May be repeated",
     2},
    {"jitter", KEY_JITTER, "[N:]RANGE", 0,
     "Time from every event, process data included, until twin N, or each twin without N, processes it: MIN[..MAX] "
     "us, 0 to 1000000, at random from --seed (default 0). May be repeated",
     2},
    {"dc-jitter", KEY_DC_JITTER, "[N:]NS", 0,
     "Maximum delay of the receive times of distributed clocks of twin N, or of each twin without N: 0 to NS ns, 0 "
     "to 100000, at random from --seed (default 0). May be repeated",
     2},
    {"wire", KEY_WIRE, "N:M.PORT", 0,
     "Connect the input of twin N to port 1, 2 or 3 of a preceding twin M (default: port 1 of the previous twin). "
     "May be repeated",
     2},
    {0},
};

static void list_chips(void)
{
    for (size_t i = 0; ect_esc_personality_at(i); i++) {
        const ect_esc_personality_t *p = ect_esc_personality_at(i);
        printf("%-13s %u FMMUs, %u SyncManagers, %2u KB\n", p->name, p->fmmu_count, p->sm_count, p->ram_kb);
    }
    exit(EXIT_CLEAN);
}

static void list_boards(void)
{
    for (size_t i = 0; ect_board_at(i); i++)
        printf("%-13s %s\n", ect_board_at(i)->name, ect_board_at(i)->summary);
    exit(EXIT_CLEAN);
}

static void add(wiring_args_t *args, const struct argp_state *state, int key, const char *text)
{
    args->settings = grow(state, args->settings, args->count, sizeof *args->settings);
    wiring_setting_t *setting = &args->settings[args->count++];
    *setting = (wiring_setting_t){.key = key, .text = text};
}

static error_t parse(int key, char *text, struct argp_state *state)
{
    switch (key) {
    case KEY_ESC:
        if (strcmp(text, "help") == 0)
            list_chips();
        break;
    case KEY_LIKE:
        if (strcmp(text, "help") == 0)
            list_boards();
        break;
    case KEY_DRIFT:
    case KEY_CABLE:
    case KEY_WIRE:
    case KEY_EEPROM:
    case KEY_AL:
    case KEY_MAILBOX:
    case KEY_JITTER:
    case KEY_DC_JITTER:
        break;
    default:
        return ARGP_ERR_UNKNOWN;
    }
    add(state->input, state, key, text);
    return 0;
}

const struct argp wiring_argp = {.options = options, .parser = parse};

/* Sets the chip, in which the device must fit. */
static void set_esc(const struct argp_state *state, ect_twin_config_t *twin, size_t position, const char *name)
{
    char why[ECT_CHECK_TEXT];
    ect_device_t other = *twin->device;
    other.esc = name;
    if (!ect_esc_personality(name))
        argp_error(state, "there is no chip '%s'; '--esc help' lists all chips", name);
    if (!ect_device_check(&other, why, sizeof why))
        argp_failure(state, EXIT_USAGE, 0, "twin %zu, %s, cannot have the chip %s: %s", position, twin->device->name,
                     name, why);
    twin->esc = name;
}

static double parse_within(const struct argp_state *state, const char *option, const char *text, double limit)
{
    char *end;
    double value = strtod(text, &end);
    if (end == text || *end != 0 || !(value >= -limit && value <= limit))
        argp_error(state, "%s takes a number up to %.0f, not '%s'", option, limit, text);
    return value;
}

/* For one twin the exact deviation; for all twins a random one up to the limit. */
static void set_drift(const struct argp_state *state, ect_twin_config_t *twin, const wiring_setting_t *setting,
                      uint32_t *seed)
{
    int32_t ppb =
        (int32_t)(parse_within(state, "--drift", setting->text, (double)ECT_ESC_MAX_DRIFT_PPB / 1000.0) * 1000.0);
    uint32_t most = (uint32_t)(ppb < 0 ? -ppb : ppb);
    twin->drift_ppb = setting->twin != 0 ? ppb : (int32_t)(ect_random_next(seed) % (2 * most + 1)) - (int32_t)most;
}

static void set_cable(const struct argp_state *state, ect_twin_config_t *twin, const char *text)
{
    double metres = parse_within(state, "--cable", text, 1000);
    if (metres < 0 || metres != (double)(uint16_t)metres)
        argp_error(state, "--cable takes whole metres from 0 to 1000, not '%s'", text);
    twin->cable_m = (uint16_t)metres;
}

static void set_eeprom(const struct argp_state *state, ect_twin_config_t *twin, const char *text)
{
    bool chip = strcmp(text, "chip") == 0;
    if (!chip && strcmp(text, "short") != 0)
        argp_error(state, "--eeprom-times takes chip or short, not '%s'", text);
    twin->eeprom_ns = chip ? (uint32_t)ECT_ESC_SII_I2C : (uint32_t)ECT_TWIN_EEPROM_NS;
}

static void set_wire(const ect_names_t *names, const struct argp_state *state, ect_twin_config_t *twin,
                     const wiring_setting_t *setting)
{
    uint64_t up = ect_names_find(names, setting->text, strcspn(setting->text, "."));
    const char *end = up != 0 ? strchr(setting->text, '.') : ect_number_begins(setting->text, 1, UINT16_MAX, &up);
    if (!end || setting->twin < 2 || end[0] != '.' || end[1] < '1' || end[1] > '3' || end[2] != 0)
        argp_error(state, "--wire takes N:M.PORT, as in 3:1.2 for twin 3 at port 2 of twin 1, not '%s'", setting->text);
    twin->up = (size_t)up - 1;
    twin->up_port = (uint8_t)(end[1] - '0');
}

/* @return a description that is freed with the arguments */
static ect_device_t *new_device(wiring_args_t *args, const struct argp_state *state)
{
    args->fitted = grow(state, args->fitted, args->fitted_count, sizeof(ect_device_t *));
    ect_device_t *device = grow(state, NULL, 0, sizeof *device);
    args->fitted[args->fitted_count++] = device;
    return device;
}

static void set_board(wiring_args_t *args, const struct argp_state *state, ect_twin_config_t *twin, size_t position,
                      const char *name)
{
    const ect_board_t *board = ect_board(name);
    if (!board)
        argp_error(state, "there is no board '%s'; '--like help' lists all boards", name);
    ect_device_t *device = new_device(args, state);
    if (!ect_fit(twin->device, board->controller, device))
        argp_failure(
            state, EXIT_USAGE, 0,
            "twin %zu, %s, does not fit into the ESC of %s: it has too many SyncManagers or FMMUs, or needs more "
            "process RAM; use another board, or --jitter alone",
            position, twin->device->name, name);
    twin->device = device;
    twin->esc = device->esc;
    twin->slow.board = board;
    twin->slow.cycle_ns = ect_board_ns(ect_board_cycle(device->name));
    twin->eeprom_ns = (uint32_t)ECT_ESC_SII_I2C;
}

static ect_slow_range_t parse_span(const struct argp_state *state, const char *option, const char *text, uint64_t most,
                                   uint64_t unit_ns)
{
    uint64_t minimum = 0;
    const char *end = ect_number_begins(text, 0, most, &minimum);
    uint64_t maximum = minimum;
    if (end && strncmp(end, "..", 2) == 0)
        end = ect_number_begins(end + 2, minimum, most, &maximum);
    if (!end || *end != 0)
        argp_error(state, "%s takes MIN or MIN..MAX, whole numbers from 0 to %llu, not '%s'", option,
                   (unsigned long long)most, text);
    return (ect_slow_range_t){minimum * unit_ns, maximum * unit_ns};
}

/* @return whether the option is one of them */
static bool set_times(const wiring_setting_t *setting, const struct argp_state *state, ect_slow_config_t *slow)
{
    enum { MOST_MS = 60000, MOST_US = 1000000, MOST_NS = 100000, MS_NS = 1000000, US_NS = 1000 };
    switch (setting->key) {
    case KEY_AL:
        slow->al = parse_span(state, "--al-delay", setting->text, MOST_MS, MS_NS);
        return true;
    case KEY_MAILBOX:
        slow->mailbox = parse_span(state, "--mailbox-delay", setting->text, MOST_MS, MS_NS);
        return true;
    case KEY_JITTER:
        slow->jitter = parse_span(state, "--jitter", setting->text, MOST_US, US_NS);
        return true;
    case KEY_DC_JITTER:
        slow->receive_ns = (uint32_t)ect_argument_number(state, "--dc-jitter", setting->text, 0, MOST_NS);
        return true;
    default:
        return false;
    }
}

static void apply_setting(wiring_args_t *args, const wiring_setting_t *setting, const struct argp_state *state,
                          ect_twin_config_t *twins, size_t i, uint32_t *seed)
{
    if (set_times(setting, state, &twins[i].slow))
        return;
    switch (setting->key) {
    case KEY_LIKE:
        set_board(args, state, &twins[i], i + 1, setting->text);
        return;
    case KEY_ESC:
        set_esc(state, &twins[i], i + 1, setting->text);
        return;
    case KEY_EEPROM:
        set_eeprom(state, &twins[i], setting->text);
        return;
    case KEY_DRIFT:
        set_drift(state, &twins[i], setting, seed);
        return;
    case KEY_CABLE:
        set_cable(state, &twins[i], setting->text);
        return;
    default:
        set_wire(args->names, state, &twins[i], setting);
    }
}

static void take_twin(const ect_names_t *names, const struct argp_state *state, wiring_setting_t *setting)
{
    const char *text = setting->text;
    setting->twin = twin_of(names, &setting->text, 0);
    if (setting->text != text && setting->twin == 0)
        argp_error(state, "%s: twins are counted from 1", text);
}

/* The place of the last --wire of a twin; without one: of the twin. */
static const struct argp_state *at_wire(bus_place_t *place, const wiring_args_t *args, const struct argp_state *state,
                                        size_t twin)
{
    for (size_t w = args->count; w-- > 0;) {
        if (args->settings[w].key == KEY_WIRE && args->settings[w].twin == twin)
            return bus_place_at(place, state, args->settings[w].text);
    }
    return bus_place_at_twin(place, state, twin);
}

void wiring_args_apply(wiring_args_t *args, const struct argp_state *parser, ect_twin_config_t *twins, size_t count,
                       uint32_t seed)
{
    bus_place_t place;
    for (size_t w = 0; w < args->count; w++) {
        wiring_setting_t *setting = &args->settings[w];
        const struct argp_state *state = bus_place_at(&place, parser, setting->text);
        take_twin(args->names, state, setting);
        if (setting->twin > count || (setting->key == KEY_WIRE && setting->twin == 0))
            argp_error(state, "%zu:%s: twins are counted from 1 to %zu", setting->twin, setting->text, count);
        for (size_t i = 0; i < count; i++) {
            if (setting->twin == 0 || setting->twin == i + 1)
                apply_setting(args, setting, state, twins, i, &seed);
        }
    }
    for (size_t i = 0; i < count; i++)
        twins[i].slow.seed = seed + (uint32_t)i;
    size_t wrong = ect_chain_check_wires(twins, count);
    if (wrong < count)
        argp_failure(at_wire(&place, args, parser, wrong + 1), EXIT_USAGE, 0,
                     "twin %zu cannot be connected to port %u of twin %zu: that twin does not come before it, has no "
                     "such port, or "
                     "another twin is connected there (port 1 is for the next twin, unless --wire moves that)",
                     wrong + 1, twins[wrong].up_port ? twins[wrong].up_port : 1u,
                     twins[wrong].up_port ? twins[wrong].up + 1 : wrong);
}

void wiring_args_free(wiring_args_t *args)
{
    for (size_t i = 0; i < args->fitted_count; i++)
        free(args->fitted[i]);
    free(args->fitted);
    free(args->settings);
}
