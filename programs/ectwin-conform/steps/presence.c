/* SPDX-License-Identifier: MIT */
/* Plug and power of the slave. */
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <sys/wait.h>

#include "steps/engine.h"

enum { PORT_CONTROL = ECT_REG_DL_CONTROL + 1, CLOSED = 3, PORTS = 4, PROBE_MS = 100, POWER_MS = 60000 };

/* @return number of slaves that reply; 0: no frame returns */
static uint16_t count(cf_t *c)
{
    uint8_t byte = 0;
    cf_datagram_t probe = {.command = CF_BRD, .address = CF_AT(0, ECT_REG_TYPE), .length = 1, .data = &byte};
    return cf_port_exchange(c->engine->port, &probe, 1, PROBE_MS) ? probe.wkc : 0;
}

static void wait_found(cf_t *c, const char *after)
{
    uint64_t until = cf_now_ns() + CF_FOUND_MS * UINT64_C(1000000);
    uint16_t found;
    while ((found = count(c)) != c->facts.slaves) {
        cf_check_time(c);
        if (cf_now_ns() >= until)
            cf_fail(c, "%s: expected %u slaves on the segment within %d s, got %u", after, c->facts.slaves,
                    (int)CF_FOUND_MS / 1000, found);
        cf_poll_pause(c);
    }
    c->engine->silent = false;
}

/* --- the plug ----------------------------------------------------------------------------------------------------- */

static uint16_t before(const cf_t *c)
{
    return (uint16_t)(c->facts.ring + 1);
}

/* Sets DL control of the previous slave, by position: station addresses may be lost. */
static void set_ports(cf_t *c, uint8_t control)
{
    uint16_t wkc = cf_command(c, CF_APWR, before(c), PORT_CONTROL, &control, 1);
    cf_expect_wkc(c, "DL control of the ports (0x0101) of the previous slave", 1, wkc);
}

/* Closes the ports of the previous slave one by one until the slave under test is unreachable. */
static bool close_port(cf_t *c)
{
    cf_engine_t *e = c->engine;
    uint16_t wkc = cf_command(c, CF_APRD, before(c), PORT_CONTROL, &e->port_control, 1);
    cf_expect_wkc(c, "DL control of the ports (0x0101) of the previous slave", 1, wkc);
    for (unsigned int port = 1; port < PORTS; port++) {
        e->pulled = true;
        set_ports(c, (uint8_t)(e->port_control | CLOSED << 2 * port));
        uint8_t byte = 0;
        if (cf_command(c, CF_APRD, c->facts.ring, ECT_REG_TYPE, &byte, 1) == 0)
            return true;
        set_ports(c, e->port_control);
        e->pulled = false;
    }
    return false;
}

static bool pull(cf_t *c, const char **why)
{
    if (c->facts.position > 0)
        *why = close_port(c) ? NULL : "no port of the slave before cuts it off";
    else
        *why = cf_port_link(c->engine->port, false);
    c->engine->pulled = *why == NULL;
    return *why == NULL;
}

void cf_put_plug_back(cf_t *c)
{
    cf_engine_t *e = c->engine;
    if (!e->pulled)
        return;
    e->pulled = false;
    if (c->facts.position > 0) {
        set_ports(c, e->port_control);
    } else {
        const char *error = cf_port_link(e->port, true);
        if (error)
            cf_fail(c, "the interface cannot be brought up again: %s", error);
    }
    wait_found(c, "plug reinserted");
}

static void run_command(cf_t *c, const char *option, const char *command)
{
    (void)fflush(NULL);
    int status = system(command); /* the user's own words, run with the user's rights. NOLINT(cert-env33-c) */
    if (status == -1 || !WIFEXITED(status) || WEXITSTATUS(status) != 0)
        cf_fail(c, "%s '%s': expected exit code 0, got %d", option, command,
                status != -1 && WIFEXITED(status) ? WEXITSTATUS(status) : -1);
}

bool cf_pull_plug(cf_t *c, uint32_t ms, const char **why)
{
    if (c->plug) {
        cf_extend(c, POWER_MS);
        cf_step(c, "plug pulled and reinserted: %s", c->plug);
        run_command(c, "--plug", c->plug);
        wait_found(c, "plug reinserted");
        return true;
    }
    if (!pull(c, why))
        return false;
    cf_sleep_ms(c, ms);
    cf_put_plug_back(c);
    return true;
}

/* --- power -------------------------------------------------------------------------------------------------------- */

/* @return whether a slave without a station address replies; it may disconnect at any time */
static bool is_fresh(cf_t *c)
{
    uint8_t address[2] = {0};
    cf_datagram_t probe = {.command = CF_APRD,
                           .address = CF_AT(c->facts.ring, ECT_REG_STATION_ADDRESS),
                           .length = sizeof address,
                           .data = address};
    return cf_port_exchange(c->engine->port, &probe, 1, PROBE_MS) && probe.wkc == 1 &&
           ect_load_le16(address) != c->facts.station;
}

/* The command may return before the slave is on again, or even before the slave is off. */
static void wait_fresh(cf_t *c)
{
    uint64_t until = cf_now_ns() + CF_FOUND_MS * UINT64_C(1000000);
    while (!is_fresh(c)) {
        cf_check_time(c);
        if (cf_now_ns() >= until)
            cf_fail(c,
                    "switched off and on: expected a slave without its station address within %d s: check that --power "
                    "switches this slave",
                    (int)CF_FOUND_MS / 1000);
        cf_poll_pause(c);
    }
    wait_found(c, "switched off and on");
}

/* Sets all station addresses: other slaves may have been switched off too. */
static void address_all(cf_t *c)
{
    for (uint16_t n = 0; n < c->facts.slaves; n++) {
        uint8_t address[2];
        ect_store_le16(address, (uint16_t)(CF_STATION + n));
        cf_expect_wkc(c, "a new station address, by position", 1,
                      cf_command(c, CF_APWR, (uint16_t)-n, ECT_REG_STATION_ADDRESS, address, sizeof address));
    }
}

void cf_power_cycle(cf_t *c)
{
    cf_extend(c, POWER_MS);
    cf_step(c, "power off and on: %s", c->power);
    run_command(c, "--power", c->power);
    wait_fresh(c);
    address_all(c);
}
