/* SPDX-License-Identifier: MIT */
#define _DEFAULT_SOURCE
#include "master.h"

#include <errno.h>
#include <net/if.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

static char image[4096];

volatile sig_atomic_t master_ended;

static void on_signal(int number)
{
    (void)number;
    master_ended = 1;
}

void master_catch_signals(void)
{
    signal(SIGINT, on_signal);
    signal(SIGTERM, on_signal);
}

uint64_t master_now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (uint64_t)t.tv_sec * 1000000000u + (uint64_t)t.tv_nsec;
}

bool master_open(const char *program, const char *iface)
{
    if (if_nametoindex(iface) == 0)
        fprintf(stderr, "%s: there is no network interface '%s': 'ip -br link' lists all interfaces\n", program, iface);
    else if (ec_init(iface))
        return true;
    else
        fprintf(stderr,
                "%s: cannot open '%s' for EtherCAT: this needs CAP_NET_RAW (sudo, or run it by 'ectwin with') and an "
                "Ethernet interface\n",
                program, iface);
    return false;
}

void master_close(void)
{
    ec_slave[0].state = EC_STATE_INIT;
    ec_writestate(0);
    ec_close();
}

int master_exchange(void)
{
    ec_send_processdata();
    return ec_receive_processdata(EC_TIMEOUTRET);
}

int master_expected(void)
{
    return ec_group[0].outputsWKC * 2 + ec_group[0].inputsWKC;
}

/* Takes the bus from INIT to SAFEOP: slaves, settings, clocks, process data. */
static bool to_safeop(const master_start_t *start)
{
    if (ec_config_init(FALSE) < 1)
        return false;
    ec_slave[1].PO2SOconfig = start->configure;
    if (start->clocks)
        ec_configdc();
    if (start->sync0_ns > 0)
        ec_dcsync0(1, TRUE, start->sync0_ns, 0);
    ec_config_map(image);
    bool fits = !start->fits || start->fits();
    return fits && ec_statecheck(0, EC_STATE_SAFE_OP, EC_TIMEOUTSTATE) == EC_STATE_SAFE_OP;
}

/* Requests OP again from slaves that have left it because frames were late, as on a busy machine. */
static void return_to_op(void)
{
    enum { WATCHDOG = 0x001B };
    ec_readstate();
    for (int i = 1; i <= ec_slavecount; i++) {
        if ((ec_slave[i].state & EC_STATE_ERROR) == 0 || ec_slave[i].ALstatuscode != WATCHDOG)
            continue;
        ec_slave[i].state = EC_STATE_OPERATIONAL | EC_STATE_ACK;
        ec_writestate((uint16)i);
    }
}

/* Takes the bus to OP, with running outputs, which a slave requires. */
bool master_to_op(const master_start_t *start)
{
    enum { TRIES = 1000, WAIT_US = 2000 };
    if (!to_safeop(start))
        return false;
    master_exchange();
    ec_slave[0].state = EC_STATE_OPERATIONAL;
    ec_writestate(0);
    for (int tries = 0; tries < TRIES && !master_ended; tries++) {
        master_exchange();
        if (ec_statecheck(0, EC_STATE_OPERATIONAL, WAIT_US) == EC_STATE_OPERATIONAL)
            return true;
        if ((ec_slave[0].state & EC_STATE_ERROR) != 0)
            return_to_op();
    }
    return false;
}

void master_pace(uint64_t *next_ns, uint32_t cycle_us)
{
    uint64_t now = master_now();
    *next_ns += cycle_us * 1000ull;
    if (*next_ns > now)
        osal_usleep((uint32)((*next_ns - now) / 1000));
    else
        *next_ns = now;
}

error_t master_parse_iface(int key, char *text, struct argp_state *state, const char **iface)
{
    if (key == ARGP_KEY_ARG) {
        if (*iface)
            argp_error(state, "one interface is enough");
        *iface = text;
        return 0;
    }
    if (key != ARGP_KEY_END)
        return ARGP_ERR_UNKNOWN;
    if (!*iface)
        argp_error(state, "name the interface");
    return 0;
}

unsigned int master_number(const struct argp_state *state, const char *option, const char *text, unsigned int least,
                           unsigned int most)
{
    char *end;
    errno = 0;
    unsigned long value = strtoul(text, &end, 10);
    bool number = *text >= '0' && *text <= '9' && *end == 0 && errno == 0;
    if (!number || value > most)
        argp_error(state, "%s takes a number up to %u, not '%s'", option, most, text);
    if (value < least)
        argp_error(state, "%s takes a number from %u to %u, not '%s'", option, least, most, text);
    return (unsigned int)value;
}
