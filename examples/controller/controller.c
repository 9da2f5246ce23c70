/* SPDX-License-Identifier: MIT */
/*
 * A machine controller for one base unit, over SOEM: TS-0007 chapter 6.1 from the first step to the last.
 *
 *   ectwin-controller IFACE [--seconds N] [--restart-every N] [--commands N] [--periodic BYTES] [--seed N] [--counters
 * FILE]
 *
 * Prints what it does, one line of JSON an event; commands from the remotes are answered by nothing but CAO. With
 * --commands it sends so many numbered commands to all remotes; with --restart-every it closes the bus at random, N
 * seconds apart in the mean, and comes back with its counters kept. A controller whose process may die keeps them in a
 * file (--counters): without them it cannot know whether the last command was done. Ends by SIGINT too.
 *
 * This file is MIT; the program is linked with SOEM and thereby covered by SOEM's licence.
 */
#define _DEFAULT_SOURCE
#include <argp.h>
#include <inttypes.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bu_controller.h"
#include "ethercat.h"
#include "number.h"
#include "open_bus.h"

#define GIVE_UP_NS 2000000000ull /* without an answer: the slave has to be found anew */
enum { CYCLE_US = 2000, EXIT_USAGE = 1, EXIT_OPEN = 2, EXIT_RUN = 3 };

typedef struct settings {
    char *iface;
    unsigned int seconds, restart_every, commands, periodic, seed;
    const char *counters;
} settings_t;

static volatile sig_atomic_t ended;
static uint8 image[4096];
static uint8_t screen[51200];
static uint32_t received;
static uint32_t restarts;
static uint32_t lost_cycles;

static void on_signal(int number)
{
    (void)number;
    ended = 1;
}

static uint64_t now(void)
{
    ec_timet t = osal_current_time();
    return ((uint64_t)t.sec * 1000000u + t.usec) * 1000u;
}

static void print_hex(const uint8_t *bytes)
{
    for (int i = 0; i < BU_COMMAND_BYTES; i++)
        printf("%02x", bytes[i]);
}

static void on_command(void *ctx, uint16_t ru, const uint8_t *command)
{
    (void)ctx;
    received++;
    printf("{\"event\":\"command\",\"ru\":%u,\"data\":\"", ru);
    print_hex(command);
    printf("\"}\n");
    fflush(stdout);
}

/* Whether what was found can be a base unit, by its sizes: product codes may be anybody's. 0 in: not known yet. */
static bool maybe_base_unit(void)
{
    uint32 in = ec_slave[1].Ibytes;
    uint32 out = ec_slave[1].Obytes;
    return in == 0 || (in == 66 && (out == 0 || out == 24 || out == 228)) || (in == 142 && out == 228);
}

/* INIT to OP. Frames may be lost on the way: it is tried again until the bus is there. */
static int to_op(void)
{
    if (ec_config_init(FALSE) <= 0)
        return 0;
    ec_config_map(image);
    if (!ec_slave[1].inputs || ec_slave[1].Ibytes < BU_INPUT_BYTES)
        return 0; /* an answer was lost and the size is not known */
    if (ec_statecheck(0, EC_STATE_SAFE_OP, EC_TIMEOUTSTATE) != EC_STATE_SAFE_OP)
        return 0;
    ec_send_processdata();
    ec_receive_processdata(EC_TIMEOUTRET);
    ec_slave[0].state = EC_STATE_OPERATIONAL;
    ec_writestate(0);
    for (int tries = 0; tries < 500 && !ended; tries++) {
        ec_send_processdata();
        ec_receive_processdata(EC_TIMEOUTRET);
        if (ec_statecheck(0, EC_STATE_OPERATIONAL, 2000) == EC_STATE_OPERATIONAL)
            return 1;
    }
    return 0;
}

/* A watchdog that ran out because frames were lost: acknowledge, and go on. */
static void recover(void)
{
    ec_readstate();
    if (ec_slave[1].state == EC_STATE_OPERATIONAL)
        return;
    ec_slave[1].state = EC_STATE_OPERATIONAL | EC_STATE_ACK;
    ec_writestate(1);
}

/* CCO and CAO as they were when the process ended, or nothing. */
static void recall(const settings_t *s, bu_controller_t *c)
{
    FILE *file = s->counters ? fopen(s->counters, "r") : NULL;
    unsigned int cco, cao;
    c->counters_known = file && fscanf(file, "%u %u", &cco, &cao) == 2 && cco <= 255 && cao <= 255;
    if (c->counters_known) {
        c->cco = (uint8_t)cco;
        c->cao = (uint8_t)cao;
    }
    if (file)
        fclose(file);
}

/* One write replaces all: three digits each. */
static void remember(const settings_t *s, const bu_controller_t *c)
{
    static int cco = -1, cao = -1;
    if (!s->counters || !c->counters_known || (cco == c->cco && cao == c->cao))
        return;
    cco = c->cco;
    cao = c->cao;
    FILE *file = fopen(s->counters, "r+");
    file = file ? file : fopen(s->counters, "w");
    if (!file)
        return;
    fprintf(file, "%3d %3d\n", cco, cao);
    fclose(file);
}

static void send_numbered(bu_controller_t *c, uint32_t *sent, uint32_t wanted)
{
    uint8_t command[BU_COMMAND_BYTES] = "controller";
    command[12] = (uint8_t)((*sent + 1) >> 24);
    command[13] = (uint8_t)((*sent + 1) >> 16);
    command[14] = (uint8_t)((*sent + 1) >> 8);
    command[15] = (uint8_t)(*sent + 1);
    if (*sent < wanted && bu_controller_send(c, 0, command))
        (*sent)++;
}

/* Cycles until `until_ns`; safe state is reported when it changes. */
static void run_bus(bu_controller_t *c, uint32_t *sent, const settings_t *s, uint64_t until_ns)
{
    int safe = -1;
    uint64_t heard_ns = now();
    int expected = ec_group[0].outputsWKC * 2 + ec_group[0].inputsWKC;
    bu_controller_start(c);
    while (!ended && now() < until_ns && now() < heard_ns + GIVE_UP_NS) {
        ec_send_processdata();
        bool complete = ec_receive_processdata(EC_TIMEOUTRET) == expected;
        bu_controller_step(c, ec_slave[1].inputs, ec_slave[1].outputs, now()); /* its time-outs run without a bus too */
        remember(s, c);
        if (complete) {
            send_numbered(c, sent, s->commands);
            heard_ns = now();
        } else {
            lost_cycles++;
            recover();
        }
        if (safe != c->safe) {
            safe = c->safe;
            printf("{\"event\":\"%s\",\"bu_state\":%u}\n", safe ? "safe" : "enabled", ec_slave[1].inputs[22]);
            fflush(stdout);
        }
        osal_usleep(CYCLE_US);
    }
}

static uint64_t next_restart(const settings_t *s, uint64_t end_ns)
{
    if (s->restart_every == 0)
        return end_ns;
    uint64_t at = now() + (uint64_t)(random() % (2000L * s->restart_every) + 500) * 1000000u;
    return at < end_ns ? at : end_ns;
}

/* Why OP was never reached. */
static void say_why(const settings_t *s)
{
    if (ec_slavecount < 1)
        fprintf(stderr, "no slave answers on '%s'\n", s->iface);
    else if (!maybe_base_unit())
        fprintf(stderr, "the first slave on '%s' is '%s' with %u bytes in and %u out: no base unit\n", s->iface,
                ec_slave[1].name, (unsigned int)ec_slave[1].Ibytes, (unsigned int)ec_slave[1].Obytes);
    else
        fprintf(stderr, "the base unit did not reach OP on '%s'\n", s->iface);
}

static int control(const settings_t *s)
{
    bu_controller_t c = {.on_command = on_command, .periodic = screen, .periodic_size = (uint16_t)s->periodic};
    uint32_t sent = 0;
    int reached = 0;
    int strange = 0;
    recall(s, &c);
    uint64_t end_ns = now() + (uint64_t)s->seconds * 1000000000u;
    while (!ended && now() < end_ns) {
        bool found = to_op();
        strange = maybe_base_unit() ? 0 : strange + 1;
        if (!reached && strange == 3) /* sizes from answers that came late are wrong once */
            break;
        if (found && strange == 0) {
            c.output_bytes = ec_slave[1].Obytes;
            reached = 1;
            printf("{\"event\":\"operational\",\"name\":\"%s\"}\n", ec_slave[1].name);
            fflush(stdout);
            run_bus(&c, &sent, s, next_restart(s, end_ns));
            restarts++;
        }
        if (ended || now() >= end_ns)
            break; /* the end is an orderly one: the bus goes to INIT */
        ec_close();
        if (!ec_init(s->iface))
            return EXIT_OPEN;
    }
    printf("{\"event\":\"end\",\"commands_received\":%" PRIu32 ",\"commands_sent\":%" PRIu32 ",\"sets_sent\":%" PRIu32
           ",\"starts\":%" PRIu32 ",\"lost_cycles\":%" PRIu32 ",\"cco\":%u,\"cao\":%u}\n",
           received, sent, c.sets_sent, restarts, lost_cycles, c.cco, c.cao);
    if (!reached)
        say_why(s);
    return reached ? 0 : EXIT_RUN;
}

static error_t parse(int key, char *text, struct argp_state *state)
{
    settings_t *s = state->input;
    const struct {
        int key;
        const char *option;
        unsigned int *value, most;
    } numbers[] = {{'s', "--seconds", &s->seconds, 1000000},
                   {'r', "--restart-every", &s->restart_every, 1000000},
                   {'c', "--commands", &s->commands, INT32_MAX},
                   {'p', "--periodic", &s->periodic, sizeof screen},
                   {'e', "--seed", &s->seed, INT32_MAX}};
    for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; i++) {
        if (key == numbers[i].key) {
            *numbers[i].value = number_of(state, numbers[i].option, text, numbers[i].most);
            return 0;
        }
    }
    if (key == 'k') {
        s->counters = text;
        return 0;
    }
    if (key == ARGP_KEY_ARG && !s->iface) {
        s->iface = text;
        return 0;
    }
    if (key == ARGP_KEY_END && !s->iface)
        argp_error(state, "name the interface");
    return ARGP_ERR_UNKNOWN;
}

int main(int argc, char **argv)
{
    static const struct argp_option options[] = {
        {"seconds", 's', "N", 0, "How long (default 10)", 0},
        {"restart-every", 'r', "N", 0, "Close the bus every N seconds in the mean (default never)", 0},
        {"commands", 'c', "N", 0, "Commands to send to all remotes (default 0)", 0},
        {"periodic", 'p', "BYTES", 0, "Periodic data, 0 to 51200 (default 450)", 0},
        {"seed", 'e', "N", 0, "Of the random restarts (default 1)", 0},
        {"counters", 'k', "FILE", 0, "Keep CCO and CAO over the end of the process (default: not)", 0},
        {0},
    };
    static const struct argp argp = {
        .options = options, .parser = parse, .args_doc = "IFACE", .doc = "A machine controller for one base unit."};
    settings_t s = {.seconds = 10, .periodic = 450, .seed = 1};
    argp_err_exit_status = EXIT_USAGE;
    argp_parse(&argp, argc, argv, 0, NULL, &s);
    srandom(s.seed);
    for (size_t i = 0; i < sizeof screen; i++)
        screen[i] = (uint8_t)(i * 7);
    signal(SIGINT, on_signal);
    signal(SIGTERM, on_signal);
    if (!open_bus(argv[0], s.iface))
        return EXIT_OPEN;
    int status = control(&s);
    ec_slave[0].state = EC_STATE_INIT;
    ec_writestate(0);
    ec_close();
    return status;
}
