/* SPDX-License-Identifier: MIT */
/*
 * A PLC for one FZM1, on SOEM: settings by SDO, then commands and measurements by the handshakes of fzm1_plc.h.
 *
 *   ectwin-plc IFACE [--measurements N] [--handshaking] [--scene N] [--dc NS] [--cycle-us N]
 *
 * Prints one line of JSON an event; data as fixed point. Exit code 0: all measurements had their data.
 */
#define _DEFAULT_SOURCE
#include <argp.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "ethercat.h"
#include "fzm1_plc.h"
#include "number.h"
#include "open_bus.h"

enum { EXIT_USAGE = 1, EXIT_OPEN = 2, EXIT_FAILED = 3, PATIENCE_S = 20 };

typedef struct settings {
    const char *iface;
    unsigned int measurements, scene, dc_ns, cycle_us;
    bool handshaking;
} settings_t;

static char image[4096];
static fzm1_plc_t plc;
static unsigned int received;

static uint64_t now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (uint64_t)t.tv_sec * 1000000000u + (uint64_t)t.tv_nsec;
}

static void on_data(void *ctx, const int32_t data[FZM1_PLC_DATA])
{
    (void)ctx;
    received++;
    printf("{\"event\":\"data\",\"data\":[");
    for (unsigned int i = 0; i < FZM1_PLC_DATA; i++)
        printf("%s%.3f", i > 0 ? "," : "", data[i] / 1000.0); /* fixed point: thousandths */
    printf("]}\n");
}

static void cycle(const settings_t *s)
{
    ec_send_processdata();
    if (ec_receive_processdata(EC_TIMEOUTRET) > 0)
        fzm1_plc_cycle(&plc, ec_slave[1].inputs, ec_slave[1].outputs, now());
    osal_usleep(s->cycle_us);
}

/* In PREOP: what the "EtherCAT" window of the controller sets. */
static int configure(uint16 slave)
{
    const settings_t *s = plc.ctx;
    uint8 control = s->handshaking;
    return ec_SDOwrite(slave, 0x2400, 1, FALSE, sizeof control, &control, EC_TIMEOUTRXM);
}

static bool to_op(const settings_t *s)
{
    if (ec_config_init(FALSE) < 1)
        return false;
    ec_slave[1].PO2SOconfig = configure;
    ec_configdc();
    if (s->dc_ns > 0)
        ec_dcsync0(1, TRUE, s->dc_ns, 0);
    ec_config_map(&image);
    if (ec_slave[1].Obytes != FZM1_PLC_OUT || ec_slave[1].Ibytes != FZM1_PLC_IN ||
        ec_statecheck(0, EC_STATE_SAFE_OP, EC_TIMEOUTSTATE) != EC_STATE_SAFE_OP)
        return false;
    ec_send_processdata();
    ec_receive_processdata(EC_TIMEOUTRET);
    ec_slave[0].state = EC_STATE_OPERATIONAL;
    ec_writestate(0);
    for (unsigned int i = 0; i < 1000; i++) {
        ec_send_processdata();
        ec_receive_processdata(EC_TIMEOUTRET);
        if (ec_statecheck(0, EC_STATE_OPERATIONAL, 2000) == EC_STATE_OPERATIONAL)
            return true;
    }
    return false;
}

/* Why nothing goes on any more. */
static bool fail(const char *why)
{
    ec_readstate();
    fprintf(stderr, "%s (signals %05X, AL status 0x%02X, code 0x%04X)\n", why, plc.signals, ec_slave[1].state,
            ec_slave[1].ALstatuscode);
    return false;
}

/* @return whether the sensor has answered OK */
static bool command(const settings_t *s, const char *name, uint32_t code, int32_t p1)
{
    uint64_t end = now() + PATIENCE_S * 1000000000ull;
    while (!fzm1_plc_command(&plc, code, p1, 0, 0)) {
        cycle(s);
        if (now() >= end)
            return fail("the sensor stays busy");
    }
    while (!plc.done && now() < end)
        cycle(s);
    printf("{\"event\":\"command\",\"name\":\"%s\",\"done\":%s,\"result\":%d,\"data\":%d}\n", name,
           plc.done ? "true" : "false", (int)plc.result, plc.data);
    if (!plc.done)
        return fail("no FLG");
    return plc.result == 0 || fail("the sensor has refused the command");
}

static bool measure_all(const settings_t *s)
{
    uint64_t end = now() + PATIENCE_S * 1000000000ull;
    unsigned int steps = 0, before = 0;
    while (received < s->measurements && now() < end) {
        if (steps < s->measurements && fzm1_plc_measure(&plc))
            steps++;
        cycle(s);
        if (steps + received != before)
            end = now() + PATIENCE_S * 1000000000ull;
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

static int run(const settings_t *s)
{
    plc = (fzm1_plc_t){.handshaking = s->handshaking,
                       .step_hold_ns = 50000000,
                       .exe_retry_ns = 500000000,
                       .on_data = on_data,
                       .ctx = (void *)(uintptr_t)s};
    if (!to_op(s)) {
        if (ec_slavecount < 1) {
            fprintf(stderr, "no slave answers on '%s'\n", s->iface);
            return EXIT_FAILED;
        }
        bool sensor = ec_slave[1].Obytes == FZM1_PLC_OUT && ec_slave[1].Ibytes == FZM1_PLC_IN;
        fail(sensor || ec_slave[1].Obytes == 0 ? "the FZM1 does not reach OP" : "the first slave is no FZM1");
        return EXIT_FAILED;
    }
    fzm1_plc_start(&plc);
    for (unsigned int i = 0; i < 10; i++)
        cycle(s);
    bool good = command(s, "switch scene", PLC_SWITCH_SCENE, (int32_t)s->scene) &&
                command(s, "get scene", PLC_GET_SCENE, 0) && measure_all(s);
    return good ? 0 : EXIT_FAILED;
}

static error_t parse(int key, char *text, struct argp_state *state)
{
    settings_t *s = state->input;
    switch (key) {
    case 'm':
        s->measurements = number_of(state, "--measurements", text, UINT32_MAX);
        return 0;
    case 'h':
        s->handshaking = true;
        return 0;
    case 'n':
        s->scene = number_of(state, "--scene", text, INT32_MAX);
        return 0;
    case 'd':
        s->dc_ns = number_of(state, "--dc", text, UINT32_MAX);
        return 0;
    case 'c':
        s->cycle_us = number_of(state, "--cycle-us", text, 1000000);
        return 0;
    case ARGP_KEY_ARG:
        if (s->iface)
            argp_error(state, "one interface is enough");
        s->iface = text;
        return 0;
    case ARGP_KEY_END:
        if (!s->iface)
            argp_error(state, "name the interface");
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

int main(int argc, char **argv)
{
    static const struct argp_option options[] = {
        {"measurements", 'm', "N", 0, "How many (default 10)", 0},
        {"handshaking", 'h', NULL, 0, "Fetch data with DSA and GATE (default: without handshaking)", 0},
        {"scene", 'n', "N", 0, "Scene to switch to (default 0)", 0},
        {"dc", 'd', "NS", 0, "SYNC0 cycle in nanoseconds (default: no SYNC0)", 0},
        {"cycle-us", 'c', "N", 0, "Pause between cycles (default 500)", 0},
        {0},
    };
    static const struct argp argp = {
        .options = options, .parser = parse, .args_doc = "IFACE", .doc = "A PLC for one FZM1."};
    settings_t s = {.measurements = 10, .cycle_us = 500};
    argp_err_exit_status = EXIT_USAGE;
    setvbuf(stdout, NULL, _IOLBF, 0); /* an event is told when it happens */
    argp_parse(&argp, argc, argv, 0, NULL, &s);
    if (!open_bus(argv[0], s.iface))
        return EXIT_OPEN;
    int status = run(&s);
    ec_slave[0].state = EC_STATE_INIT;
    ec_writestate(0);
    ec_close();
    return status;
}
