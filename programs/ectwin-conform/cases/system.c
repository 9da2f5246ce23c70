/* SPDX-License-Identifier: MIT */
/* J. The slave as a whole. */
#include "cases/beyond.h"

enum { LED_RUN_ON = 0x0F, LED_RUN_BLINKS = 0x0D, LED_RUN_FLASHES = 0x01, FUZZ_ROUNDS = 40, FUZZ_ROUND = 32 };
enum { LONG_ROUNDS = 1000, LONG_ROUND = 1000, LONG_MS = 3600000, PULLED_MS = 300, WATCHDOG_TICKS = 1000 };

/* RUN as the chip shows it, where it has the register: off, blinking, single flash, on. */
static void indicators(cf_t *c)
{
    static const struct {
        uint8_t state, run;
    } expected[] = {{CF_PREOP, LED_RUN_BLINKS}, {CF_SAFEOP, LED_RUN_FLASHES}, {CF_OP, LED_RUN_ON}};
    uint8_t run;
    cf_go(c, CF_OP);
    if (cf_read(c, ECT_REG_LED_RUN, &run, 1) != 1 || (run & 0x0F) != LED_RUN_ON)
        cf_skip(c, "the chip does not show the RUN indicator in 0x0138");
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

/* SOEM uses the SII and CoE only. */
static void soem(cf_t *c)
{
    char what[200];
    cf_step(c, "SOEM: configuration, mapping, SAFEOP, OP");
    bool reached = cf_soem_to_op(c, what, sizeof what);
    cf_expect_that(c, reached, "SOEM on its way to OP: %s", what);
}

/* A slave without its station address keeps its state and is reached by its position. */
static void lose_address(cf_t *c, uint8_t state)
{
    uint8_t byte, zero[2] = {0}, address[2];
    cf_go(c, state);
    cf_step(c, "the station address is lost in %s", cf_state_name(state));
    cf_put(c, ECT_REG_STATION_ADDRESS, zero, sizeof zero);
    uint16_t wkc = cf_read(c, ECT_REG_TYPE, &byte, 1);
    ect_store_le16(address, c->facts.station);
    uint16_t found = cf_command(c, CF_APWR, c->facts.ring, ECT_REG_STATION_ADDRESS, address, sizeof address);
    cf_expect_wkc(c, "a read of the address that is lost", 0, wkc);
    cf_expect_wkc(c, "the new address, by position", 1, found);
    cf_expect(c, "AL status afterwards", state, cf_get16(c, ECT_REG_AL_STATUS) & 0x1F);
}

/* State of a slave that was unreachable for a while: the same, or a lower one with the error flag and a code. */
static void expect_kept_or_reported(cf_t *c, uint8_t state)
{
    uint8_t bytes[6] = {0};
    uint16_t wkc = cf_command(c, CF_APRD, c->facts.ring, ECT_REG_AL_STATUS, bytes, sizeof bytes);
    const uint16_t status = ect_load_le16(bytes) & 0x1F, code = ect_load_le16(bytes + 4);
    cf_expect_wkc(c, "AL status, by position", 1, wkc);
    cf_expect_that(c, status == state || ((status & ECT_AL_ERROR) != 0 && code != 0),
                   "AL status with the plug back: expected %s, or an error with its code, got %s with code 0x%04X",
                   cf_state_name(state), cf_state_name(status), code);
}

static void lost_links_clear(cf_t *c)
{
    const uint8_t zero = 0;
    (void)cf_write(c, ECT_REG_LOST_LINK, &zero, 1);
}

/* Only a real plug loses the link for certain: a port that the slave before closes keeps it, and so do some interfaces
 * that are down. */
static void expect_lost_link(cf_t *c)
{
    uint8_t lost[4] = {0};
    (void)cf_command(c, CF_APRD, c->facts.ring, ECT_REG_LOST_LINK, lost, sizeof lost);
    cf_expect_that(c, !c->plug || (lost[0] | lost[1] | lost[2] | lost[3]) != 0,
                   "lost link counters (0x0310) after --plug: expected 1 or more, got 0");
}

/* @return whether it can be done here */
static bool pulled_in(cf_t *c, uint8_t state, const char **why)
{
    cf_go(c, state);
    cf_step(c, "the plug is pulled in %s for %d ms", cf_state_name(state), (int)PULLED_MS);
    if (state == CF_OP) {
        cf_put16(c, ECT_REG_WD_TIME_PD, WATCHDOG_TICKS); /* 100 ms: what a controller has */
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
            c->power ? "; power off and on" : "; power off and on: --power names the command for it");
}

static const cf_case_t cases[] = {
    {"CF-093", "The RUN indicator shows the state", 'T', 0, 0, indicators},
    {"CF-094", "After every command, header field and length, and random frames, a start-up succeeds", 'F', 0, 120000,
     survives},
    {"CF-095", "SOEM takes the slave to OP from SII and CoE alone", 'F', CF_SII, 60000, soem},
    {"CF-096", "A slave without its address, after a lost link or power, is found again in every state", 'F', 0, 60000,
     found_again},
};

CF_SECTION(cf_system, 'J', "System", cases);
