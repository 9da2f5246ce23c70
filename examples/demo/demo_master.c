/* SPDX-License-Identifier: MIT */
/*
 * The demo's master: takes whatever base units are on the wire from INIT to OP with SOEM, shows what it reads from
 * them, exchanges process data (for 3 s unless told otherwise), sends one command and goes back to INIT.
 *
 * This file is MIT; the program is linked with SOEM and thereby covered by SOEM's licence.
 */
#include <inttypes.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ethercat.h"
#include "open_bus.h"

enum { EXIT_CLEAN = 0, EXIT_USAGE = 1, EXIT_OPEN = 2, EXIT_RUN = 3 };
enum { CYCLE_US = 2000, STATE_TIMEOUT_US = 5000000, REPLY_TIMEOUT_US = 20000 };
enum { PCO_CYCLES = 125, SHOWN = 12, COMMAND_CYCLE = 500, CYCLES_A_SECOND = 500, SECONDS = 3, LONGEST = 86400 };
/* TS-0007 chapters 8 and 9. */
enum { PCI = 0, CAI = 3, PCO = 0, CCO = 1, COMMAND = 6, COMMAND_BYTES = 16 };

static uint8 image[4096];
static int total_cycles = SECONDS * CYCLES_A_SECOND;

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

static int cycle(void)
{
    ec_send_processdata();
    int wkc = ec_receive_processdata(REPLY_TIMEOUT_US);
    osal_usleep(CYCLE_US);
    return wkc;
}

static void show_counters(int n, int wkc)
{
    printf("  cycle %4d  working counter %d", n, wkc);
    for (int i = 1; i <= ec_slavecount; i++)
        printf("   slave %d: PCI %3u CAI %u", i, ec_slave[i].inputs[PCI], ec_slave[i].inputs[CAI]);
    printf("\n");
}

/* Returns the number of slaves that acknowledged the command, or -1 when process data was lost. */
static int exchange(int expected)
{
    int acknowledged = 0;
    for (int n = 1; n <= total_cycles; n++) {
        if (n == COMMAND_CYCLE) {
            printf("sending a command to the remote units (CCO 0 -> 1)\n");
            for (int i = 1; i <= ec_slavecount; i++) {
                memset(ec_slave[i].outputs + COMMAND, 0xA5, COMMAND_BYTES);
                ec_slave[i].outputs[CCO]++;
            }
        }
        for (int i = 1; i <= ec_slavecount; i++)
            ec_slave[i].outputs[PCO] = (uint8)(n / PCO_CYCLES);
        int wkc = cycle();
        if (wkc != expected) {
            printf("cycle %d: working counter %d instead of %d\n", n, wkc, expected);
            return -1;
        }
        if (n % (total_cycles / SHOWN) == 0)
            show_counters(n, wkc);
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
    return reached(EC_STATE_OPERATIONAL) && cycle() == expected;
}

static int run(void)
{
    if (ec_config_init(FALSE) <= 0) {
        printf("no slaves found\n");
        return EXIT_RUN;
    }
    if (!reached(EC_STATE_INIT))
        return EXIT_RUN;
    ec_slave[0].state = EC_STATE_PRE_OP;
    ec_writestate(0);
    if (!reached(EC_STATE_PRE_OP))
        return EXIT_RUN;
    int bytes = ec_config_map(image);
    ec_slave[0].state = EC_STATE_SAFE_OP;
    ec_writestate(0);
    if (!reached(EC_STATE_SAFE_OP))
        return EXIT_RUN;
    for (int i = 1; i <= ec_slavecount; i++)
        show_slave(i);
    int expected = ec_group[0].outputsWKC * 2 + ec_group[0].inputsWKC;
    printf("process image: %d bytes, expected working counter %d\n", bytes, expected);
    if (!to_operational(expected) || exchange(expected) != ec_slavecount)
        return EXIT_RUN;
    ec_slave[0].state = EC_STATE_INIT;
    ec_writestate(0);
    return reached(EC_STATE_INIT) ? EXIT_CLEAN : EXIT_RUN;
}

/* How long process data are exchanged. @return false: that is no number of seconds */
static bool set_seconds(const char *text)
{
    char *end;
    long seconds = strtol(text, &end, 10);
    if (*text == '\0' || *end != '\0' || seconds < SECONDS || seconds > LONGEST)
        return false;
    total_cycles = (int)seconds * CYCLES_A_SECOND;
    return true;
}

int main(int argc, char **argv)
{
    setvbuf(stdout, NULL, _IOLBF, 0);
    if (argc < 2 || argc > 3 || (argc == 3 && !set_seconds(argv[2]))) {
        fprintf(stderr, "usage: %s IFACE [SECONDS]     %d to %d seconds in OP\n", argv[0], SECONDS, LONGEST);
        return EXIT_USAGE;
    }
    if (!open_bus(argv[0], argv[1]))
        return EXIT_OPEN;
    ecx_context.manualstatechange = 1;
    printf("SOEM is looking for slaves on %s\n", argv[1]);
    int status = run();
    ec_close();
    printf(status == EXIT_CLEAN ? "done\n" : "failed\n");
    return status;
}
