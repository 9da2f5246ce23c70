/* SPDX-License-Identifier: MIT */
/* A master over SOEM that brings slaves back: takes the bus to OP, and each slave that leaves OP or the bus again.
 * usage: panel_master IFACE [BYTE [CYCLE_US]]      Until SIGTERM. Prints each value of the two input bytes from BYTE
 * on, big-endian; the cycle is 2000 us by default. */
#include "master.h"

#include <stdio.h>
#include <stdlib.h>

enum { CYCLE_US = 2000, CHECK_CYCLES = 50, STEP_US = 20000 };

/* One step on the way back. */
static void bring_back(uint16 slave)
{
    uint16 state = ec_slave[slave].state;
    if (state == EC_STATE_OPERATIONAL)
        return;
    if (state == EC_STATE_NONE) {
        (void)ec_recover_slave(slave, STEP_US);
    } else if (state == EC_STATE_SAFE_OP) {
        ec_slave[slave].state = EC_STATE_OPERATIONAL;
        ec_writestate(slave);
    } else if (state == EC_STATE_SAFE_OP + EC_STATE_ERROR) {
        ec_slave[slave].state = EC_STATE_SAFE_OP + EC_STATE_ACK;
        ec_writestate(slave);
    } else {
        (void)ec_reconfig_slave(slave, STEP_US);
    }
}

static void check_slaves(void)
{
    ec_readstate();
    for (uint16 slave = 1; slave <= ec_slavecount; slave++)
        bring_back(slave);
}

static void print_input(size_t byte)
{
    static int last;
    if (byte + 2 > ec_slave[1].Ibytes)
        return;
    const uint8 *at = ec_slave[1].inputs + byte;
    int value = (int16)(at[0] << 8 | at[1]);
    if (value == last)
        return;
    last = value;
    printf("%d\n", value);
    fflush(stdout);
}

int main(int argc, char **argv)
{
    static const master_start_t start = {0};
    const size_t byte = argc > 2 ? strtoul(argv[2], NULL, 10) : SIZE_MAX - 2;
    const uint32_t cycle_us = argc > 3 ? (uint32_t)strtoul(argv[3], NULL, 10) : CYCLE_US;
    if (argc < 2 || argc > 4 || !master_open("panel_master", argv[1]))
        return MASTER_OPEN;
    master_catch_signals();
    while (!master_to_op(&start) && !master_ended) /* on a busy machine replies are late */
        osal_usleep(STEP_US);
    uint64_t next_ns = master_now();
    for (unsigned int cycle = 0; !master_ended; cycle++) {
        (void)master_exchange();
        print_input(byte);
        if (cycle % CHECK_CYCLES == 0) /* the working counter of a slave in SAFEOP is that of one in OP */
            check_slaves();
        master_pace(&next_ns, cycle_us);
    }
    master_close();
    return 0;
}
