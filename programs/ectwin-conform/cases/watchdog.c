/* SPDX-License-Identifier: MIT */
/* E. Watchdogs, in SAFEOP, where only the chip reacts. */
#include "steps/case.h"

enum { DIVIDER_100US = 2498, DIVIDER_200US = 4998, LATE_NS = 5000000, LIMIT_MS = 5000 };
enum { PDI_OK = 0x0002, COUNTER_PDI = ECT_REG_WD_COUNTER_PD + 1, MAILS = 20 };

/* @return the output SyncManager that triggers the watchdog; skips the case when there is none */
static const cf_sm_t *watched(cf_t *c)
{
    for (unsigned int n = 0; n < c->facts.sm_count; n++) {
        const cf_sm_t *sm = &c->facts.sm[n];
        if (sm->type == ECT_SM_OUTPUTS && sm->length > 0 && (sm->control & ECT_SM_CONTROL_WATCHDOG) != 0)
            return sm;
    }
    cf_skip(c, "the SII's output SyncManager does not trigger the watchdog");
}

static void trigger(cf_t *c)
{
    uint16_t wkc = cf_cycle(c, NULL, NULL);
    cf_expect_that(c, wkc > 0, "WKC of process data in SAFEOP: expected more than 0, got 0");
}

static bool expired(cf_t *c)
{
    return (cf_get8(c, ECT_REG_WD_STATUS_PD) & 1) == 0;
}

/* The watchdog must expire neither before its time nor noticeably later. Delays of the PC do not affect the verdict,
 * and pauses between polls, made only until the time is near, do not affect the measured time. */
static void check_time(cf_t *c, uint16_t divider, uint16_t ticks)
{
    const uint64_t time_ns = (divider + UINT64_C(2)) * 40 * ticks, tick_ns = (divider + UINT64_C(2)) * 40;
    cf_step(c, "divider %u, %u ticks: %llu us", divider, ticks, (unsigned long long)(time_ns / 1000));
    cf_put16(c, ECT_REG_WD_DIVIDER, divider);
    cf_put16(c, ECT_REG_WD_TIME_PD, ticks);
    uint64_t before = cf_now_ns();
    trigger(c);
    uint64_t after = cf_now_ns(), asked = after;
    while (!expired(c)) {
        cf_expect_that(c, asked < after + time_ns + tick_ns + time_ns / 10 + LATE_NS,
                       "watchdog of %llu us: expected to have expired, got running after %llu us",
                       (unsigned long long)(time_ns / 1000), (unsigned long long)((asked - after) / 1000));
        if (asked < after + time_ns - time_ns / 10)
            cf_poll_pause(c);
        asked = cf_now_ns();
    }
    uint64_t took = cf_now_ns() - before;
    cf_expect_that(c, took >= time_ns - time_ns / 20, "watchdog of %llu us: expected to run, got expired after %llu us",
                   (unsigned long long)(time_ns / 1000), (unsigned long long)(took / 1000));
}

static void times(cf_t *c)
{
    (void)watched(c);
    cf_go(c, CF_SAFEOP);
    check_time(c, DIVIDER_100US, 200);
    check_time(c, DIVIDER_100US, 500);
    check_time(c, DIVIDER_200US, 200);
    cf_step(c, "0 ticks: off");
    cf_put16(c, ECT_REG_WD_DIVIDER, DIVIDER_100US);
    cf_put16(c, ECT_REG_WD_TIME_PD, 0);
    trigger(c);
    cf_sleep_ms(c, 60);
    cf_expect(c, "watchdog status (0x0440) with the watchdog off", 1, cf_get8(c, ECT_REG_WD_STATUS_PD) & 1);
}

static void wait_expired(cf_t *c)
{
    if (!cf_wait_bits(c, ECT_REG_WD_STATUS_PD, 1, 0, LIMIT_MS, NULL))
        cf_fail(c, "watchdog: expected to expire within %d ms, got 0x0440 = 1", (int)LIMIT_MS);
}

static void once(cf_t *c)
{
    (void)watched(c);
    cf_go(c, CF_SAFEOP);
    cf_put16(c, ECT_REG_WD_TIME_PD, 100);
    trigger(c);
    wait_expired(c);
    cf_put8(c, ECT_REG_WD_COUNTER_PD, 0);
    cf_expect(c, "watchdog counter after a write", 0, cf_get8(c, ECT_REG_WD_COUNTER_PD));
    for (uint8_t times_ = 1; times_ <= 3; times_++) {
        cf_step(c, "expiry %u", times_);
        trigger(c);
        wait_expired(c);
        cf_sleep_ms(c, 40);
        cf_expect(c, "watchdog counter after four times the watchdog time", times_, cf_get8(c, ECT_REG_WD_COUNTER_PD));
    }
    cf_step(c, "off");
    cf_put16(c, ECT_REG_WD_TIME_PD, 0);
    trigger(c);
    cf_sleep_ms(c, 40);
    cf_expect(c, "watchdog counter with the watchdog off", 3, cf_get8(c, ECT_REG_WD_COUNTER_PD));
}

static void partly(cf_t *c)
{
    const cf_sm_t *sm = watched(c);
    uint8_t zeros[CF_MAX_DATA] = {0};
    if (sm->length < 2)
        cf_skip(c, "the outputs are one byte: a partial write is impossible");
    cf_go(c, CF_SAFEOP);
    cf_put16(c, ECT_REG_WD_TIME_PD, 500);
    trigger(c);
    cf_step(c, "repeated writes of the outputs without the last byte");
    uint64_t end = cf_now_ns() + LIMIT_MS * UINT64_C(1000000);
    while (!expired(c)) {
        cf_expect_that(c, cf_now_ns() < end, "watchdog of 50 ms: expected to expire, got running for %d ms",
                       (int)LIMIT_MS);
        (void)cf_write(c, sm->start, zeros, sm->length - 1u);
        cf_poll_pause(c);
    }
    cf_step(c, "the last byte of the outputs");
    cf_expect_wkc(c, "a write of all outputs", 1, cf_write(c, sm->start, zeros, sm->length));
    cf_expect(c, "watchdog status (0x0440) after a whole write", 1, cf_get8(c, ECT_REG_WD_STATUS_PD) & 1);
}

/* A working slave triggers the PDI watchdog, and causes no PDI errors. */
static void pdi(cf_t *c)
{
    cf_mail_t mail;
    cf_go(c, CF_PREOP);
    uint8_t errors = cf_get8(c, ECT_REG_PDI_ERROR), count = cf_get8(c, COUNTER_PDI);
    for (int i = 0; i < MAILS; i++) {
        cf_send_mail(c, 9, "", 0);
        cf_receive(c, CF_MBX_ERROR, &mail);
        cf_expect_bits(c, "DL status: PDI watchdog", PDI_OK, PDI_OK, cf_get16(c, ECT_REG_DL_STATUS));
    }
    cf_expect(c, "PDI error counter, during mailbox traffic", errors, cf_get8(c, ECT_REG_PDI_ERROR));
    cf_expect(c, "PDI watchdog counter, during mailbox traffic", count, cf_get8(c, COUNTER_PDI));
}

static const cf_case_t cases[] = {
    {"CF-050", "The process data watchdog expires after divider times time; 0 disables it", 'R',
     CF_APPLICATION | CF_OUTPUTS | CF_REAL_TIME, 0, times},
    {"CF-051", "Each expiry is counted once; a disabled watchdog counts nothing", 'R',
     CF_APPLICATION | CF_OUTPUTS | CF_REAL_TIME, 0, once},
    {"CF-052", "A partial write of the outputs does not trigger the watchdog", 'R',
     CF_APPLICATION | CF_OUTPUTS | CF_REAL_TIME, 0, partly},
    {"CF-053", "PDI watchdog and PDI error counter report no error while the slave works", 'T',
     CF_APPLICATION | CF_MAILBOX, 0, pdi},
};

CF_SECTION(cf_watchdog, 'E', "Watchdogs and PDI", cases);
