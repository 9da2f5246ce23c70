/* SPDX-License-Identifier: MIT */
/* J. The slave as a whole. */
#include "cases/beyond.h"

enum { LED_RUN_ON = 0x0F, LED_RUN_BLINKS = 0x0D, LED_RUN_FLASHES = 0x01, FUZZ_ROUNDS = 40, FUZZ_ROUND = 32 };
enum { LONG_ROUNDS = 1000, LONG_ROUND = 1000, LONG_MS = 3600000, PULLED_MS = 300, WATCHDOG_TICKS = 1000 };

/* The RUN indicator by the chip's register, if there is one: off, blinking, single flash, on. */
static void indicators(cf_t *c)
{
    static const struct {
        uint8_t state, run;
    } expected[] = {{CF_PREOP, LED_RUN_BLINKS}, {CF_SAFEOP, LED_RUN_FLASHES}, {CF_OP, LED_RUN_ON}};
    uint8_t run;
    cf_go(c, CF_OP);
    if (cf_read(c, ECT_REG_LED_RUN, &run, 1) != 1 || (run & 0x0F) != LED_RUN_ON)
        cf_skip(c, "the chip has no RUN indicator register (0x0138)");
    cf_go(c, CF_INIT);
    cf_expect_bits(c, "RUN in INIT", 0x0F, 0, cf_get8(c, ECT_REG_LED_RUN));
    for (size_t i = 0; i < sizeof expected / sizeof expected[0]; i++) {
        cf_go(c, expected[i].state);
        cf_expect_bits(c, "RUN in PREOP, SAFEOP, OP", 0x0F, expected[i].run, cf_get8(c, ECT_REG_LED_RUN));
    }
}

static void survives(cf_t *c)
{
    if (c->whole)
        cf_extend(c, LONG_MS);
    unsigned long thrown = cf_sweep(c);
    cf_known_state(c);
    thrown += c->whole ? cf_fuzz_rounds(c, LONG_ROUNDS, LONG_ROUND) : cf_fuzz_rounds(c, FUZZ_ROUNDS, FUZZ_ROUND);
    cf_note(c, "%lu mails, frames and requests%s", thrown, c->whole ? "" : "; --long throws a million");
}

/* SOEM uses only SII and CoE. */
static void soem(cf_t *c)
{
    char what[200];
    cf_step(c, "SOEM: configuration, mapping, SAFEOP, OP");
    bool reached = cf_soem_to_op(c, what, sizeof what);
    cf_expect_that(c, reached, "SOEM on its way to OP: %s", what);
}

/* A slave without its station address keeps its state and can be reached by position. */
static void lose_address(cf_t *c, uint8_t state)
{
    uint8_t byte, zero[2] = {0}, address[2];
    cf_go(c, state);
    cf_step(c, "loss of the station address in %s", cf_state_name(state));
    cf_put(c, ECT_REG_STATION_ADDRESS, zero, sizeof zero);
    uint16_t wkc = cf_read(c, ECT_REG_TYPE, &byte, 1);
    ect_store_le16(address, c->facts.station);
    uint16_t found = cf_command(c, CF_APWR, c->facts.ring, ECT_REG_STATION_ADDRESS, address, sizeof address);
    cf_expect_wkc(c, "a read by the lost station address", 0, wkc);
    cf_expect_wkc(c, "write of the new station address, by position", 1, found);
    cf_expect(c, "AL status afterwards", state, cf_get16(c, ECT_REG_AL_STATUS) & 0x1F);
}

/* Expects of a slave that was unreachable: the same state, or a lower one with the error flag and a code. */
static void expect_kept_or_reported(cf_t *c, uint8_t state)
{
    uint8_t bytes[6] = {0};
    uint16_t wkc = cf_command(c, CF_APRD, c->facts.ring, ECT_REG_AL_STATUS, bytes, sizeof bytes);
    const uint16_t status = ect_load_le16(bytes) & 0x1F, code = ect_load_le16(bytes + 4);
    cf_expect_wkc(c, "AL status, by position", 1, wkc);
    cf_expect_that(c, status == state || ((status & ECT_AL_ERROR) != 0 && code != 0),
                   "AL status after reconnection: expected %s, or an error with a code, got %s with code 0x%04X",
                   cf_state_name(state), cf_state_name(status), code);
}

static void lost_links_clear(cf_t *c)
{
    const uint8_t zero = 0;
    (void)cf_write(c, ECT_REG_LOST_LINK, &zero, 1);
}

/* Only a pulled plug certainly loses the link: a port closed by the previous slave keeps the link, as do some
 * interfaces that are down. */
static void expect_lost_link(cf_t *c)
{
    uint8_t lost[4] = {0};
    (void)cf_command(c, CF_APRD, c->facts.ring, ECT_REG_LOST_LINK, lost, sizeof lost);
    cf_expect_that(c, !c->plug || (lost[0] | lost[1] | lost[2] | lost[3]) != 0,
                   "lost link counters (0x0310) after --plug: expected at least 1, got 0");
}

/* @return false: not possible here */
static bool pulled_in(cf_t *c, uint8_t state, const char **why)
{
    cf_go(c, state);
    cf_step(c, "plug pulled in %s for %d ms", cf_state_name(state), (int)PULLED_MS);
    if (state == CF_OP) {
        cf_put16(c, ECT_REG_WD_TIME_PD, WATCHDOG_TICKS); /* 100 ms, as usual with controllers */
        (void)cf_cycle(c, NULL, NULL);
    }
    lost_links_clear(c);
    if (!cf_pull_plug(c, PULLED_MS, why))
        return false;
    expect_lost_link(c);
    expect_kept_or_reported(c, state);
    cf_step(c, "configured again");
    cf_known_state(c);
    cf_go(c, state);
    return true;
}

static void switched_off_in(cf_t *c, uint8_t state)
{
    cf_go(c, state);
    cf_power_cycle(c);
    cf_expect(c, "AL status after power-on", CF_INIT, cf_get16(c, ECT_REG_AL_STATUS) & 0x1F);
    cf_known_state(c);
    cf_go(c, state);
}

static void found_again(cf_t *c)
{
    static const uint8_t states[] = {CF_INIT, CF_PREOP, CF_SAFEOP, CF_OP};
    const char *why = NULL;
    for (size_t i = 0; i < sizeof states; i++)
        lose_address(c, states[i]);
    for (size_t i = 0; i < sizeof states && !why; i++) {
        cf_known_state(c);
        (void)pulled_in(c, states[i], &why);
    }
    for (size_t i = 0; i < sizeof states && c->power; i++) {
        cf_known_state(c);
        switched_off_in(c, states[i]);
    }
    cf_note(c, "address lost; plug pulled%s%s%s", why ? " not: " : "", why ? why : "",
            c->power ? "; power off and on" : "; no power cycle: give a command with --power");
}

static const cf_case_t cases[] = {
    {"CF-093", "The RUN indicator corresponds to the state", 'T', 0, 0, indicators},
    {"CF-094", "A start-up succeeds after every command, header field and length, and after random frames", 'F', 0,
     120000, survives},
    {"CF-095", "SOEM takes the slave to OP from SII and CoE alone", 'F', CF_SII, 60000, soem},
    {"CF-096", "A slave is found again in every state after losing its address, its link or its power", 'F', 0, 60000,
     found_again},
};

CF_SECTION(cf_system, 'J', "System", cases);
