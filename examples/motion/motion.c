/* SPDX-License-Identifier: MIT */
/*
 * A motion program for one PMCtendo DD5, on SOEM: settings by mailbox, then enable, reference run, trapezoid, touch
 * probe by axis.h.
 *
 *   ectwin-motion IFACE [--way COUNTS] [--speed COUNTS] [--acceleration COUNTS] [--method N] [--dc] [--cycle-us N]
 *
 * Prints one line of CSV for each cycle on standard output, and the result as one line of JSON on standard error. Exit
 * code 0: the axis has completed its motion.
 *
 * This file is MIT; the program is linked with SOEM and thereby covered by SOEM's licence.
 */
#include <inttypes.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

#include "axis.h"
#include "csv.h"
#include "master.h"

enum { PATIENT = 200 /* SYNC0 events without outputs tolerated by the drive, because the timing of a PC varies */ };

#define TURN 1048576.0 /* counts */

typedef struct settings {
    const char *iface;
    double way, speed, acceleration;
    uint8 method;
    unsigned int cycle_us;
    bool dc;
} settings_t;

static settings_t settings = {
    .way = 10.0 * TURN, .speed = 10.0 * TURN, .acceleration = 100.0 * TURN, .method = 35, .cycle_us = 1000};

static bool write_object(uint16 slave, uint16 index, uint8 subindex, uint32 value, int size)
{
    uint8 bytes[4] = {(uint8)value, (uint8)(value >> 8), (uint8)(value >> 16), (uint8)(value >> 24)};
    return ec_SDOwrite(slave, index, subindex, FALSE, size, bytes, EC_TIMEOUTRXM) > 0;
}

static bool assign(uint16 slave, uint16 index, uint16 pdo)
{
    return write_object(slave, index, 0, 0, 1) && write_object(slave, index, 1, pdo, 2) &&
           write_object(slave, index, 0, 1, 1);
}

/* In PREOP: PDOs in the sequence of the manual, cycle time in units of 10 us, mode 8, homing method. */
static int configure(uint16 slave)
{
    const settings_t *s = &settings;
    bool good = assign(slave, 0x1C12, 0x1720) && assign(slave, 0x1C13, 0x1B25) &&
                write_object(slave, 0x60C2, 1, s->cycle_us / 250 * 25, 1) && write_object(slave, 0x60C2, 2, 0xFB, 1) &&
                write_object(slave, 0x10F1, 2, PATIENT, 2) && write_object(slave, 0x6060, 0, 8, 1) &&
                write_object(slave, 0x6098, 0, s->method, 1);
    if (!good)
        fprintf(stderr, "the drive refuses its settings: check --method and --cycle-us\n");
    return good;
}

static bool is_axis(void)
{
    return ec_slave[1].Obytes == AXIS_OUT && ec_slave[1].Ibytes == AXIS_IN;
}

/* Runs cycles until the axis has finished; a cycle with a lost frame does not count. */
static void run(const settings_t *s, axis_t *axis)
{
    uint64_t start = master_now(), next = start;
    csv_head();
    while (axis->phase < AXIS_DONE) {
        if (master_exchange() > 0) {
            axis_cycle(axis, ec_slave[1].inputs, ec_slave[1].outputs);
            csv_line(axis, (double)(master_now() - start) / 1e6);
        }
        master_pace(&next, s->cycle_us);
    }
    master_exchange();
}

static int drive(const settings_t *s)
{
    axis_t axis = {.cycle_s = s->cycle_us / 1e6, .way = s->way, .speed = s->speed, .acceleration = s->acceleration};
    const master_start_t way = {
        .configure = configure, .clocks = true, .sync0_ns = s->dc ? s->cycle_us * 1000 : 0, .fits = is_axis};
    if (!master_to_op(&way)) {
        ec_readstate();
        fprintf(stderr, "no PMCtendo DD5 reached OP on '%s' (%d slaves, AL status 0x%02X, code 0x%04X)\n", s->iface,
                ec_slavecount, ec_slave[1].state, ec_slave[1].ALstatuscode);
        return MASTER_FAILED;
    }
    run(s, &axis);
    fprintf(stderr, "{\"event\":\"end\",\"done\":%s,\"position\":%" PRId32 ",\"probed\":%s,\"probe\":%" PRId32 "}\n",
            axis.phase == AXIS_DONE ? "true" : "false", axis.position, axis.probed ? "true" : "false", axis.probe);
    if (axis.failure)
        fprintf(stderr, "%s (status 0x%04X)\n", axis.failure, axis.status);
    return axis.phase == AXIS_DONE ? 0 : MASTER_FAILED;
}

/* --- command line ------------------------------------------------------------------------------------------------- */

static const char *complaint(const settings_t *s)
{
    if (s->cycle_us < 250 || s->cycle_us % 250 != 0 || s->cycle_us > 2500)
        return "--cycle-us takes 250, 500 and so on up to 2500";
    return s->speed > 0 && s->acceleration > 0 ? NULL : "--speed and --acceleration take numbers above 0";
}

static double real(const struct argp_state *state, const char *name, const char *text, double most)
{
    char *end;
    double value = strtod(text, &end);
    if (end == text || *end != 0 || !(value >= -most && value <= most))
        argp_error(state, "%s takes a number up to %.0f, not '%s'", name, most, text);
    return value;
}

static error_t parse(int key, char *text, struct argp_state *state)
{
    settings_t *s = state->input;
    switch (key) {
    case 'w':
        s->way = real(state, "--way", text, INT32_MAX);
        return 0;
    case 's':
        s->speed = real(state, "--speed", text, INT32_MAX);
        return 0;
    case 'a':
        s->acceleration = real(state, "--acceleration", text, UINT32_MAX);
        return 0;
    case 'm':
        s->method = (uint8)master_number(state, "--method", text, 0, INT8_MAX);
        return 0;
    case 'c':
        s->cycle_us = master_number(state, "--cycle-us", text, 0, 2500);
        return 0;
    case 'd':
        s->dc = true;
        return 0;
    case ARGP_KEY_END:
        if (s->iface && complaint(s))
            argp_error(state, "%s", complaint(s));
        return master_parse_iface(key, text, state, &s->iface);
    default:
        return master_parse_iface(key, text, state, &s->iface);
    }
}

int main(int argc, char **argv)
{
    static const struct argp_option options[] = {
        {"way", 'w', "COUNTS", 0, "Distance from the reference point, 2^20 counts per turn (default 10 turns)", 0},
        {"speed", 's', "COUNTS", 0, "Speed in counts per second (default 10 turns)", 0},
        {"acceleration", 'a', "COUNTS", 0, "Acceleration in counts per second squared (default 100 turns)", 0},
        {"method", 'm', "N", 0, "Homing method, 6098h (default 35: the present position)", 0},
        {"cycle-us", 'c', "N", 0, "Cycle time in microseconds: 250 to 2500 in steps of 250 (default 1000)", 0},
        {"dc", 'd', NULL, 0, "Use SYNC0 with this cycle time", 0},
        {0},
    };
    static const struct argp argp = {
        .options = options,
        .parser = parse,
        .args_doc = "IFACE",
        .doc =
            "Enables one PMCtendo DD5 on IFACE, runs a reference run and a trapezoid with the touch probe armed, and "
            "prints a line of CSV for each cycle."};
    argp_err_exit_status = MASTER_USAGE;
    argp_parse(&argp, argc, argv, 0, NULL, &settings);
    if (!master_open(argv[0], settings.iface))
        return MASTER_OPEN;
    int status = drive(&settings);
    master_close();
    return status;
}
