/* SPDX-License-Identifier: MIT */
/*
 * A machine controller for one base unit, over SOEM: all steps of TS-0007 chapter 6.1.
 *
 *   ectwin-controller IFACE [--seconds N] [--restart-every N] [--commands N] [--periodic BYTES] [--seed N] [--counters
 * FILE]
 *
 * Prints one line of JSON for each event; commands from remotes are acknowledged by CAO only. --commands sends numbered
 * commands to all remotes; --restart-every closes the bus at random, every N seconds on average, and starts the bus
 * again with the same counters. A controller whose process may end stores the counters in a file (--counters): without
 * them it is unknown whether the last command was executed. A process killed between a command and the storing of its
 * counters executes this command again. SIGINT ends the program.
 *
 * This file is MIT; the program is linked with SOEM and thereby covered by SOEM's licence.
 */
#define _DEFAULT_SOURCE
#include <inttypes.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

#include "bu_controller.h"
#include "master.h"

#define GIVE_UP_NS 2000000000ull /* without a reply: the slave is lost, the bus must be started again */
enum { CYCLE_US = 2000, CHECK_CYCLES = 50 /* between two reads of the AL status */ };

typedef struct settings {
    const char *iface;
    unsigned int seconds, restart_every, commands, periodic, seed;
    const char *counters;
} settings_t;

static uint8_t screen[51200];
static uint32_t received;
static uint32_t restarts;
static uint32_t lost_cycles;

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
}

/* Identifies a base unit by its sizes, because an installation may override product codes. Without a size a reply was
 * lost. */
static bool maybe_base_unit(void)
{
    uint32 in = ec_slave[1].Ibytes;
    uint32 out = ec_slave[1].Obytes;
    return in == 0 || (in == 66 && (out == 0 || out == 24 || out == 228)) || (in == 142 && out == 228);
}

static bool has_inputs(void)
{
    return ec_slave[1].inputs && ec_slave[1].Ibytes >= BU_INPUT_BYTES;
}

/* Acknowledges the error of a unit that has left OP, after lost frames or by itself, and requests OP again. */
static void recover(void)
{
    ec_readstate();
    if (ec_slave[1].state == EC_STATE_OPERATIONAL)
        return;
    ec_slave[1].state = EC_STATE_OPERATIONAL | EC_STATE_ACK;
    ec_writestate(1);
}

/* Reads CCO and CAO of the last process, if the file exists. */
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

/* Replaces the content by one write: three digits for each counter. */
static void record(const settings_t *s, const bu_controller_t *c)
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

static void report_safe(int *safe, const bu_controller_t *c)
{
    if (*safe == c->safe)
        return;
    *safe = c->safe;
    printf("{\"event\":\"%s\",\"bu_state\":%u}\n", c->safe ? "safe" : "enabled", ec_slave[1].inputs[22]);
}

/* Runs cycles until `until_ns`. The controller's timeouts also run without a bus. */
static void run_bus(bu_controller_t *c, uint32_t *sent, const settings_t *s, uint64_t until_ns)
{
    int safe = -1;
    unsigned int cycle = 0;
    uint64_t next_ns = master_now(), last_reply_ns = next_ns;
    bu_controller_start(c);
    while (!master_ended && master_now() < until_ns && master_now() < last_reply_ns + GIVE_UP_NS) {
        bool complete = master_exchange() == master_expected();
        bu_controller_step(c, ec_slave[1].inputs, ec_slave[1].outputs, master_now());
        record(s, c);
        if (complete) {
            send_numbered(c, sent, s->commands);
            last_reply_ns = master_now();
        } else {
            lost_cycles++;
        }
        if (!complete || ++cycle % CHECK_CYCLES == 0) /* a unit in SAFEOP also exchanges process data */
            recover();
        report_safe(&safe, c);
        master_pace(&next_ns, CYCLE_US);
    }
}

static uint64_t next_restart(const settings_t *s, uint64_t end_ns)
{
    if (s->restart_every == 0)
        return end_ns;
    uint64_t at = master_now() + (uint64_t)(random() % (2000L * s->restart_every) + 500) * 1000000u;
    return at < end_ns ? at : end_ns;
}

/* Prints the reason why OP was never reached. */
static void report_failure(const settings_t *s)
{
    if (ec_slavecount < 1) {
        fprintf(stderr, "no slave answers on '%s'\n", s->iface);
    } else if (!maybe_base_unit()) {
        fprintf(stderr, "the first slave on '%s' is '%s' with %u bytes in and %u out: no base unit\n", s->iface,
                ec_slave[1].name, (unsigned int)ec_slave[1].Ibytes, (unsigned int)ec_slave[1].Obytes);
    } else {
        ec_readstate();
        fprintf(stderr, "the base unit did not reach OP on '%s': AL status 0x%02x, code 0x%04x (%s)\n", s->iface,
                ec_slave[1].state, ec_slave[1].ALstatuscode, ec_ALstatuscode2string(ec_slave[1].ALstatuscode));
    }
}

static bool is_over(uint64_t end_ns)
{
    return master_ended || master_now() >= end_ns;
}

/* @return the exit code */
static int report_end(const settings_t *s, const bu_controller_t *c, uint32_t sent)
{
    printf("{\"event\":\"end\",\"commands_received\":%" PRIu32 ",\"commands_sent\":%" PRIu32 ",\"sets_sent\":%" PRIu32
           ",\"starts\":%" PRIu32 ",\"lost_cycles\":%" PRIu32 ",\"cco\":%u,\"cao\":%u}\n",
           received, sent, c->sets_sent, restarts, lost_cycles, c->cco, c->cao);
    if (restarts > 0)
        return 0;
    report_failure(s);
    return MASTER_FAILED;
}

/* Starts the bus, and restarts it after each end, until the time is over. main() ends the bus in INIT.
 */
static int control(const settings_t *s)
{
    enum { STRANGE_MOST = 3 }; /* successive starts, because a late reply can cause a wrong size once */
    static const master_start_t start = {.fits = has_inputs};
    bu_controller_t c = {.on_command = on_command, .periodic = screen, .periodic_size = (uint16_t)s->periodic};
    uint32_t sent = 0;
    int strange = 0;
    recall(s, &c);
    uint64_t end_ns = master_now() + (uint64_t)s->seconds * 1000000000u;
    while (!is_over(end_ns)) {
        bool found = master_to_op(&start);
        strange = maybe_base_unit() ? 0 : strange + 1;
        if (restarts == 0 && strange == STRANGE_MOST)
            break;
        if (found && strange == 0) {
            c.output_bytes = ec_slave[1].Obytes;
            printf("{\"event\":\"operational\",\"name\":\"%s\"}\n", ec_slave[1].name);
            run_bus(&c, &sent, s, next_restart(s, end_ns));
            restarts++;
        }
        if (is_over(end_ns))
            break;
        ec_close();
        if (!ec_init(s->iface))
            return MASTER_OPEN;
    }
    return report_end(s, &c, sent);
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
            *numbers[i].value = master_number(state, numbers[i].option, text, 0, numbers[i].most);
            return 0;
        }
    }
    if (key == 'k') {
        s->counters = text;
        return 0;
    }
    return master_parse_iface(key, text, state, &s->iface);
}

int main(int argc, char **argv)
{
    static const struct argp_option options[] = {
        {"seconds", 's', "N", 0, "Seconds to run (default 10)", 0},
        {"restart-every", 'r', "N", 0, "Restart the bus at random, on average every N seconds; 0: never (default)", 0},
        {"commands", 'c', "N", 0, "Number of commands to send to all remotes (default 0)", 0},
        {"periodic", 'p', "BYTES", 0, "Size of the periodic data, 0 to 51200 (default 450)", 0},
        {"seed", 'e', "N", 0, "Seed of the random restarts (default 1)", 0},
        {"counters", 'k', "FILE", 0, "File that stores CCO and CAO after the end of the process (default: none)", 0},
        {0},
    };
    static const struct argp argp = {
        .options = options,
        .parser = parse,
        .args_doc = "IFACE",
        .doc = "A machine controller for one base unit: takes and sends commands, sends periodic data, and reports "
               "when the machine must be safe. Prints a line of JSON for each event."};
    settings_t s = {.seconds = 10, .periodic = 450, .seed = 1};
    argp_err_exit_status = MASTER_USAGE;
    setvbuf(stdout, NULL, _IOLBF, 0); /* each event at its time */
    argp_parse(&argp, argc, argv, 0, NULL, &s);
    srandom(s.seed);
    for (size_t i = 0; i < sizeof screen; i++)
        screen[i] = (uint8_t)(i * 7);
    master_catch_signals();
    if (!master_open(argv[0], s.iface))
        return MASTER_OPEN;
    int status = control(&s);
    master_close();
    return status;
}
