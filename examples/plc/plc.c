/* SPDX-License-Identifier: MIT */
/*
 * A PLC for one FZM1, on SOEM: settings by SDO, then commands and measurements by the handshakes of fzm1_plc.h.
 *
 *   ectwin-plc IFACE [--measurements N] [--handshaking] [--scene N] [--dc NS] [--cycle-us N]
 *
 * Prints one line of JSON for each event; data as fixed point. Exit code 0: all measurements had their data.
 */
#include <stdbool.h>
#include <stdio.h>

#include "fzm1_plc.h"
#include "master.h"

enum { PATIENCE_S = 20 };

typedef struct settings {
    const char *iface;
    unsigned int measurements, scene, dc_ns, cycle_us;
    bool handshaking;
} settings_t;

static fzm1_plc_t plc;
static unsigned int received;

static void on_data(void *ctx, const int32_t data[FZM1_PLC_DATA])
{
    (void)ctx;
    received++;
    printf("{\"event\":\"data\",\"data\":[");
    for (unsigned int i = 0; i < FZM1_PLC_DATA; i++)
        printf("%s%.3f", i > 0 ? "," : "", data[i] / 1000.0); /* fixed point, in units of 1/1000 */
    printf("]}\n");
}

static void cycle(const settings_t *s)
{
    static uint64_t next_ns;
    if (master_exchange() > 0)
        fzm1_plc_cycle(&plc, ec_slave[1].inputs, ec_slave[1].outputs, master_now());
    master_pace(&next_ns, s->cycle_us);
}

/* The settings of the controller's "EtherCAT" window, in PREOP. */
static int configure(uint16 slave)
{
    const settings_t *s = plc.ctx;
    uint8 control = s->handshaking;
    return ec_SDOwrite(slave, 0x2400, 1, FALSE, sizeof control, &control, EC_TIMEOUTRXM);
}

static bool is_sensor(void)
{
    return ec_slave[1].Obytes == FZM1_PLC_OUT && ec_slave[1].Ibytes == FZM1_PLC_IN;
}

/* Prints the reason for the end of the program. */
static bool fail(const char *why)
{
    ec_readstate();
    fprintf(stderr, "%s (signals %05X, AL status 0x%02X, code 0x%04X)\n", why, plc.signals, ec_slave[1].state,
            ec_slave[1].ALstatuscode);
    return false;
}

/* @return whether the response is OK */
static bool command(const settings_t *s, const char *name, uint32_t code, int32_t p1)
{
    uint64_t end = master_now() + PATIENCE_S * 1000000000ull;
    while (!fzm1_plc_command(&plc, code, p1, 0, 0)) {
        cycle(s);
        if (master_now() >= end)
            return fail("the sensor stays busy");
    }
    while (!plc.done && master_now() < end)
        cycle(s);
    printf("{\"event\":\"command\",\"name\":\"%s\",\"done\":%s,\"result\":%d,\"data\":%d}\n", name,
           plc.done ? "true" : "false", (int)plc.result, plc.data);
    if (!plc.done)
        return fail("no FLG");
    return plc.result == 0 || fail("the sensor has refused the command");
}

static bool measure_all(const settings_t *s)
{
    uint64_t end = master_now() + PATIENCE_S * 1000000000ull;
    unsigned int steps = 0, before = 0;
    while (received < s->measurements && master_now() < end) {
        if (steps < s->measurements && fzm1_plc_measure(&plc))
            steps++;
        cycle(s);
        if (steps + received != before)
            end = master_now() + PATIENCE_S * 1000000000ull;
        before = steps + received;
        if (steps == 0 && (plc.signals & PLC_RUN) == 0)
            return fail("READY is off: the sensor does not show its RUN window");
    }
    printf("{\"event\":\"end\",\"steps\":%u,\"data\":%u,\"error\":%s}\n", steps, received,
           (plc.signals & PLC_ERR) != 0 ? "true" : "false");
    return received == s->measurements ||
           fail(s->handshaking ? "data are missing"
                               : "data are missing: is GATE shorter than a cycle? --handshaking waits");
}

/* @return false: the reason is on standard error */
static bool start(const settings_t *s)
{
    const master_start_t way = {.configure = configure, .clocks = true, .sync0_ns = s->dc_ns, .fits = is_sensor};
    if (master_to_op(&way))
        return true;
    if (ec_slavecount < 1) {
        fprintf(stderr, "no slave answers on '%s'\n", s->iface);
        return false;
    }
    return fail(is_sensor() || ec_slave[1].Obytes == 0 ? "the FZM1 does not reach OP" : "the first slave is no FZM1");
}

static int run(const settings_t *s)
{
    plc = (fzm1_plc_t){.handshaking = s->handshaking,
                       .step_hold_ns = 50000000,
                       .exe_retry_ns = 500000000,
                       .on_data = on_data,
                       .ctx = (void *)(uintptr_t)s};
    if (!start(s))
        return MASTER_FAILED;
    fzm1_plc_start(&plc);
    for (unsigned int i = 0; i < 10; i++)
        cycle(s);
    bool good = command(s, "switch scene", PLC_SWITCH_SCENE, (int32_t)s->scene) &&
                command(s, "get scene", PLC_GET_SCENE, 0) && measure_all(s);
    return good ? 0 : MASTER_FAILED;
}

static error_t parse(int key, char *text, struct argp_state *state)
{
    settings_t *s = state->input;
    switch (key) {
    case 'm':
        s->measurements = master_number(state, "--measurements", text, 0, UINT32_MAX);
        return 0;
    case 'h':
        s->handshaking = true;
        return 0;
    case 'n':
        s->scene = master_number(state, "--scene", text, 0, INT32_MAX);
        return 0;
    case 'd':
        s->dc_ns = master_number(state, "--dc", text, 0, UINT32_MAX);
        return 0;
    case 'c':
        s->cycle_us = master_number(state, "--cycle-us", text, 0, 1000000);
        return 0;
    default:
        return master_parse_iface(key, text, state, &s->iface);
    }
}

int main(int argc, char **argv)
{
    static const struct argp_option options[] = {
        {"measurements", 'm', "N", 0, "Number of measurements (default 10)", 0},
        {"handshaking", 'h', NULL, 0, "Fetch data with DSA and GATE (default: without handshaking)", 0},
        {"scene", 'n', "N", 0, "Scene to switch to before measuring (default 0)", 0},
        {"dc", 'd', "NS", 0, "SYNC0 cycle in nanoseconds (default: no SYNC0)", 0},
        {"cycle-us", 'c', "N", 0, "Cycle in microseconds (default 500)", 0},
        {0},
    };
    static const struct argp argp = {
        .options = options,
        .parser = parse,
        .args_doc = "IFACE",
        .doc = "A PLC for one FZM1: switches to a scene, measures, and prints a line of JSON for each event."};
    settings_t s = {.measurements = 10, .cycle_us = 500};
    argp_err_exit_status = MASTER_USAGE;
    setvbuf(stdout, NULL, _IOLBF, 0); /* each event at its time */
    argp_parse(&argp, argc, argv, 0, NULL, &s);
    if (!master_open(argv[0], s.iface))
        return MASTER_OPEN;
    int status = run(&s);
    master_close();
    return status;
}
