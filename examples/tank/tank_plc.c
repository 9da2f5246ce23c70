/* SPDX-License-Identifier: MIT */
/*
 * A PLC that keeps the level of a tank between two limits, on SOEM: slave 1 has the valves, slave 2 the sensor
 * (tank.yaml).
 *
 *   ectwin-tank-plc IFACE [--low MM] [--high MM] [--seconds N] [--cycle-us N]
 *
 * The inlet opens below --low and closes above --high; the outlet is always open. Prints one line of JSON at each
 * change of the inlet and at the end. Exit code 0: after the first filling, the level has stayed within 20 mm of the
 * limits.
 *
 * This file is MIT; the program is linked with SOEM and thereby covered by SOEM's licence.
 */
#include <stdbool.h>
#include <stdio.h>

#include "master.h"

enum { VALVES = 1, SENSOR = 2, INLET = 1, OUTLET = 2, HEIGHT_MM = 1000, TOLERANCE_MM = 20 };

typedef struct settings {
    const char *iface;
    unsigned int low, high, seconds, cycle_us;
} settings_t;

typedef struct control {
    bool inlet;
    bool filled; /* the level has been above --high */
    unsigned int least, most, switched;
} control_t;

static unsigned int level(void)
{
    const uint8 *bytes = ec_slave[SENSOR].inputs;
    return bytes[0] | (unsigned int)bytes[1] << 8;
}

static void show(const char *event, unsigned int now, unsigned int mm)
{
    printf("{\"event\":\"%s\",\"cycle\":%u,\"level\":%u}\n", event, now, mm);
}

/* Executes one cycle: reads the level, sets the valves. */
static void regulate(control_t *c, const settings_t *s, unsigned int cycle)
{
    const unsigned int mm = level();
    const bool inlet = c->inlet ? mm <= s->high : mm < s->low;
    if (inlet != c->inlet) {
        show(inlet ? "inlet opens" : "inlet closes", cycle, mm);
        c->switched++;
    }
    c->filled |= c->inlet && !inlet;
    c->inlet = inlet;
    if (c->filled) {
        c->least = mm < c->least ? mm : c->least;
        c->most = mm > c->most ? mm : c->most;
    }
    ec_slave[VALVES].outputs[0] = (uint8)(OUTLET | (inlet ? INLET : 0));
}

static bool fail(const char *why)
{
    fprintf(stderr, "%s\n", why);
    return false;
}

static bool is_tank(void)
{
    return ec_slavecount == 2 && ec_slave[VALVES].Obytes == 1 && ec_slave[SENSOR].Ibytes == 2;
}

static bool run(const settings_t *s)
{
    const master_start_t way = {.fits = is_tank};
    control_t c = {.least = HEIGHT_MM};
    uint64_t next_ns = 0;
    const unsigned int cycles = (unsigned int)((uint64_t)s->seconds * 1000000 / s->cycle_us);
    if (!master_to_op(&way))
        return fail(is_tank() ? "the slaves do not reach OP"
                              : "slave 1 has no valves, or slave 2 no level: start the twins of tank.yaml");
    for (unsigned int cycle = 0; cycle < cycles && !master_ended; cycle++) {
        if (master_exchange() > 0)
            regulate(&c, s, cycle);
        master_pace(&next_ns, s->cycle_us);
    }
    printf("{\"event\":\"end\",\"switched\":%u,\"least\":%u,\"most\":%u}\n", c.switched, c.least, c.most);
    const bool good = c.filled && c.least + TOLERANCE_MM >= s->low && c.most <= s->high + TOLERANCE_MM;
    return good ||
           fail(c.filled ? "the level has left its limits" : "the tank was never filled: start its plant, tank.py");
}

static error_t parse(int key, char *text, struct argp_state *state)
{
    settings_t *s = state->input;
    switch (key) {
    case 'l':
        s->low = master_number(state, "--low", text, 1, HEIGHT_MM);
        return 0;
    case 'h':
        s->high = master_number(state, "--high", text, 1, HEIGHT_MM);
        return 0;
    case 's':
        s->seconds = master_number(state, "--seconds", text, 1, 3600);
        return 0;
    case 'c':
        s->cycle_us = master_number(state, "--cycle-us", text, 100, 1000000);
        return 0;
    case ARGP_KEY_END:
        if (s->low >= s->high)
            argp_error(state, "--low is below --high");
        return master_parse_iface(key, text, state, &s->iface);
    default:
        return master_parse_iface(key, text, state, &s->iface);
    }
}

int main(int argc, char **argv)
{
    static const struct argp_option options[] = {
        {"low", 'l', "MM", 0, "The inlet opens below this level (default 400)", 0},
        {"high", 'h', "MM", 0, "The inlet closes above this level (default 600)", 0},
        {"seconds", 's', "N", 0, "Duration (default 30)", 0},
        {"cycle-us", 'c', "N", 0, "Cycle in microseconds (default 1000)", 0},
        {0},
    };
    static const struct argp argp = {.options = options,
                                     .parser = parse,
                                     .args_doc = "IFACE",
                                     .doc =
                                         "A PLC that keeps the level of the tank of examples/tank between two limits."};
    settings_t s = {.low = 400, .high = 600, .seconds = 30, .cycle_us = 1000};
    argp_err_exit_status = MASTER_USAGE;
    setvbuf(stdout, NULL, _IOLBF, 0);
    argp_parse(&argp, argc, argv, 0, NULL, &s);
    master_catch_signals();
    if (!master_open(argv[0], s.iface))
        return MASTER_OPEN;
    const bool good = run(&s);
    master_close();
    return good ? 0 : MASTER_FAILED;
}
