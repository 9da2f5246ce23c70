/* SPDX-License-Identifier: MIT */
/*
 * The demo's master: takes the base units on the wire from INIT to OP step by step, prints each state and what the
 * units report, exchanges process data for some seconds, sends one command and requests INIT.
 *
 * This file is MIT; the program is linked with SOEM and thereby covered by SOEM's licence.
 */
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "master.h"

enum { CYCLE_US = 2000, STATE_TIMEOUT_US = 5000000, REPLY_TIMEOUT_US = 20000 };
/* Cycles in succession: a busy PC may stop each program for longer than REPLY_TIMEOUT_US. */
enum { MISSED_MOST = 10 };
enum { PCO_CYCLES = 125, LINES = 12, COMMAND_CYCLE = 500, CYCLES_A_SECOND = 500, SECONDS = 3, LONGEST = 86400 };
/* TS-0007 chapters 8 and 9. */
enum { PCI = 0, CAI = 3, PCO = 0, CCO = 1, COMMAND = 6, COMMAND_BYTES = 16 };

typedef struct settings {
    const char *iface;
    unsigned int seconds;
} settings_t;

static uint8 image[4096];

static const char *state_name(uint16 state)
{
    switch (state & 0x0F) {
    case EC_STATE_INIT:
        return "INIT";
    case EC_STATE_PRE_OP:
        return "PREOP";
    case EC_STATE_SAFE_OP:
        return "SAFEOP";
    case EC_STATE_OPERATIONAL:
        return "OP";
    default:
        return "?";
    }
}

static int reached(uint16 state)
{
    ec_statecheck(0, state, STATE_TIMEOUT_US);
    ec_readstate();
    for (int i = 1; i <= ec_slavecount; i++) {
        if (ec_slave[i].state != state) {
            printf("slave %d stays in %s, AL status code 0x%04X: %s\n", i, state_name(ec_slave[i].state),
                   ec_slave[i].ALstatuscode, ec_ALstatuscode2string(ec_slave[i].ALstatuscode));
            return 0;
        }
    }
    printf("all %d slaves are in %s\n", ec_slavecount, state_name(state));
    return 1;
}

static void show_slave(int i)
{
    const ec_slavet *s = &ec_slave[i];
    char software[32] = "";
    int size = (int)sizeof software - 1;
    uint32 serial = 0;
    int serial_size = (int)sizeof serial;
    ec_SDOread((uint16)i, 0x100A, 0, FALSE, &size, software, EC_TIMEOUTRXM);
    ec_SDOread((uint16)i, 0x1018, 4, FALSE, &serial_size, &serial, EC_TIMEOUTRXM);
    printf("  slave %d  %-20s %3u bytes in, %3u bytes out   vendor 0x%08X product 0x%08X revision 0x%08X "
           "serial %" PRIu32 ", software %s\n",
           i, s->name, s->Ibytes, s->Obytes, s->eep_man, s->eep_id, s->eep_rev, serial, software);
}

/* @return the working counter; -1: no reply in time */
static int cycle(void)
{
    static uint64_t next_ns;
    ec_send_processdata();
    int wkc = ec_receive_processdata(REPLY_TIMEOUT_US);
    master_pace(&next_ns, CYCLE_US);
    return wkc;
}

/* Exchanges process data, again after a late reply. @return whether the working counter is the expected one */
static bool complete(int expected)
{
    for (int missed = 0; missed < MISSED_MOST; missed++) {
        int wkc = cycle();
        if (wkc == expected)
            return true;
        printf("working counter %d instead of %d\n", wkc, expected);
    }
    return false;
}

static void show_counters(int n, int wkc)
{
    printf("  cycle %4d  working counter %d", n, wkc);
    for (int i = 1; i <= ec_slavecount; i++)
        printf("   slave %d: PCI %3u CAI %u", i, ec_slave[i].inputs[PCI], ec_slave[i].inputs[CAI]);
    printf("\n");
}

static void send_commands(void)
{
    printf("sending a command to the remote units (CCO 0 -> 1)\n");
    for (int i = 1; i <= ec_slavecount; i++) {
        memset(ec_slave[i].outputs + COMMAND, 0xA5, COMMAND_BYTES);
        ec_slave[i].outputs[CCO]++;
    }
}

/* @return the number of slaves that acknowledged the command; -1: process data were lost */
static int exchange(int expected, int cycles)
{
    int acknowledged = 0;
    for (int n = 1; n <= cycles; n++) {
        if (n == COMMAND_CYCLE)
            send_commands();
        for (int i = 1; i <= ec_slavecount; i++)
            ec_slave[i].outputs[PCO] = (uint8)(n / PCO_CYCLES);
        if (!complete(expected))
            return -1;
        if (n % (cycles / LINES) == 0)
            show_counters(n, expected);
    }
    for (int i = 1; i <= ec_slavecount; i++)
        acknowledged += ec_slave[i].inputs[CAI] == ec_slave[i].outputs[CCO];
    printf("%d of %d slaves acknowledged the command in CAI\n", acknowledged, ec_slavecount);
    return acknowledged;
}

static int to_operational(int expected)
{
    ec_slave[0].state = EC_STATE_OPERATIONAL;
    cycle();
    ec_writestate(0);
    for (int tries = 0; tries < 500 && ec_slave[0].state != EC_STATE_OPERATIONAL; tries++) {
        cycle();
        ec_statecheck(0, EC_STATE_OPERATIONAL, 1000);
    }
    return reached(EC_STATE_OPERATIONAL) && complete(expected);
}

static int request(uint16 state)
{
    ec_slave[0].state = state;
    ec_writestate(0);
    return reached(state);
}

static int run(const settings_t *s)
{
    if (ec_config_init(FALSE) <= 0) {
        printf("no slaves found\n");
        return MASTER_FAILED;
    }
    if (!reached(EC_STATE_INIT) || !request(EC_STATE_PRE_OP))
        return MASTER_FAILED;
    int bytes = ec_config_map(image);
    if (!request(EC_STATE_SAFE_OP))
        return MASTER_FAILED;
    for (int i = 1; i <= ec_slavecount; i++)
        show_slave(i);
    int expected = master_expected();
    printf("process image: %d bytes, expected working counter %d\n", bytes, expected);
    if (!to_operational(expected) || exchange(expected, (int)s->seconds * CYCLES_A_SECOND) != ec_slavecount)
        return MASTER_FAILED;
    return request(EC_STATE_INIT) ? 0 : MASTER_FAILED;
}

static error_t parse(int key, char *text, struct argp_state *state)
{
    settings_t *s = state->input;
    if (key == ARGP_KEY_ARG && s->iface) {
        s->seconds = master_number(state, "SECONDS", text, SECONDS, LONGEST);
        return 0;
    }
    return master_parse_iface(key, text, state, &s->iface);
}

int main(int argc, char **argv)
{
    static const struct argp argp = {
        .parser = parse,
        .args_doc = "IFACE [SECONDS]",
        .doc = "The demo's master: takes base units to OP, exchanges process data for SECONDS (3 to 86400, default 3), "
               "sends one command, and requests INIT."};
    settings_t s = {.seconds = SECONDS};
    argp_err_exit_status = MASTER_USAGE;
    setvbuf(stdout, NULL, _IOLBF, 0);
    argp_parse(&argp, argc, argv, 0, NULL, &s);
    if (!master_open(argv[0], s.iface))
        return MASTER_OPEN;
    ecx_context.manualstatechange = 1;
    printf("SOEM is looking for slaves on %s\n", s.iface);
    int status = run(&s);
    ec_close();
    printf(status == 0 ? "done\n" : "failed\n");
    return status;
}
