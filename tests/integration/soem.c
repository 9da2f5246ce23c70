/* SPDX-License-Identifier: MIT */
#define _DEFAULT_SOURCE
#include "soem.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* A reply that a busy machine delivers late is not a lost one. */
enum {
    STATE_TIMEOUT_US = 60000000,
    REPLY_TIMEOUT_US = 20000000,
    IN_PROCESS_US = 1000000, /* there only a lost reply is late */
    TRIES = 30000,           /* of 1 ms */
    CYCLE_US = 1000,
    WATCHDOG_MS = 60000,
};

uint64_t soem_now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (uint64_t)t.tv_sec * 1000000000u + (uint64_t)t.tv_nsec;
}

static bool is_in_process(void)
{
    return getenv("ECTWIN_INPROCESS") != NULL;
}

/* Time in which this process has run, microseconds: a machine that stands still, or leaves the processor to others,
 * makes no reply late. Each call counts this much at most since the previous one. */
static uint64_t running_us(void)
{
    enum { STEP_US = 20000 };
    static uint64_t last_us, sum_us;
    uint64_t now_us = soem_now() / 1000, step_us = now_us - last_us;
    last_us = now_us;
    sum_us += step_us < STEP_US ? step_us : STEP_US;
    return sum_us;
}

/* SOEM waits 2 ms for a frame, repeats it twice, and then regards it as lost: on a busy machine the reply is late. Our
 * tests' SOEM has more patience, on a clock of its own (the link option --wrap puts both in place of SOEM's own); what
 * a master makes of a lost frame is tested where frames are lost on purpose. */
void __real_osal_timer_start(osal_timert *timer, uint32 timeout_us);
void __wrap_osal_timer_start(osal_timert *timer, uint32 timeout_us);
boolean __real_osal_timer_is_expired(osal_timert *timer);
boolean __wrap_osal_timer_is_expired(osal_timert *timer);

static uint32 patience = 200;

void soem_patience(unsigned int times)
{
    patience = times;
}

void __wrap_osal_timer_start(osal_timert *timer, uint32 timeout_us)
{
    enum { FOR_SHORTER_US = 1000000, MOST_US = 5000000, S_US = 1000000 };
    if (is_in_process()) { /* no reply is late in this process */
        __real_osal_timer_start(timer, timeout_us);
        return;
    }
    uint32 longer_us = timeout_us < MOST_US / patience ? timeout_us * patience : MOST_US;
    uint64_t end_us = running_us() + (timeout_us < FOR_SHORTER_US ? longer_us : timeout_us);
    timer->stop_time.sec = (uint32)(end_us / S_US);
    timer->stop_time.usec = (uint32)(end_us % S_US);
}

boolean __wrap_osal_timer_is_expired(osal_timert *timer)
{
    enum { S_US = 1000000 };
    if (is_in_process())
        return __real_osal_timer_is_expired(timer);
    return running_us() >= (uint64_t)timer->stop_time.sec * S_US + timer->stop_time.usec;
}

static void wire_context(soem_t *m)
{
    memset(m, 0, sizeof *m);
    m->context = (ecx_contextt){
        .port = &m->port,
        .slavelist = m->slaves,
        .slavecount = &m->slave_count,
        .maxslave = EC_MAXSLAVE,
        .grouplist = m->groups,
        .maxgroup = EC_MAXGROUP,
        .esibuf = m->sii_buffer,
        .esimap = m->sii_map,
        .elist = &m->errors,
        .idxstack = &m->index_stack,
        .ecaterror = &m->error,
        .DCtime = &m->dc_time,
        .SMcommtype = m->sm_types,
        .PDOassign = m->assignments,
        .PDOdesc = m->descriptions,
        .eepSM = &m->sii_sm,
        .eepFMMU = &m->sii_fmmu,
        .manualstatechange = 1,
    };
}

void soem_watchdog(soem_t *m, unsigned int ms)
{
    enum { DIVIDER_1_MS = 24998 }; /* of 25 MHz, two less */
    uint16 divider = htoes(DIVIDER_1_MS), ticks = htoes((uint16)ms);
    assert_int_equal(ecx_BWR(&m->port, 0, 0x0400, sizeof divider, &divider, EC_TIMEOUTRET3), m->slave_count);
    assert_int_equal(ecx_BWR(&m->port, 0, 0x0420, sizeof ticks, &ticks, EC_TIMEOUTRET3), m->slave_count);
}

static void configure(soem_t *m, int expected)
{
    assert_int_equal(ecx_config_init(&m->context, FALSE), expected);
    soem_watchdog(m, WATCHDOG_MS);
    soem_go(m, 0, EC_STATE_PRE_OP);
}

void soem_open(soem_t *m, const char *iface, int expected)
{
    wire_context(m);
    assert_true(ecx_init(&m->context, iface) > 0);
    configure(m, expected);
}

void soem_open_redundant(soem_t *m, const char *iface, const char *second, int expected)
{
    char name[16];
    snprintf(name, sizeof name, "%s", second);
    wire_context(m);
    assert_true(ecx_init_redundant(&m->context, &m->second_port, iface, name) > 0);
    configure(m, expected);
}

void soem_close(soem_t *m)
{
    m->slaves[0].state = EC_STATE_INIT;
    ecx_writestate(&m->context, 0);
    ecx_close(&m->context);
}

/* ecx_statecheck is content with a state whose error flag is set; a slave that is not in our process takes a while
 * until it has seen the acknowledge, and until then its controller takes no other request. */
static bool no_error(soem_t *m, uint16 slave)
{
    for (int tries = 0; tries < TRIES; tries++) {
        bool error = false;
        ecx_readstate(&m->context);
        for (int i = 1; i <= m->slave_count; i++)
            error |= (slave == 0 || i == slave) && (m->slaves[i].state & EC_STATE_ERROR) != 0;
        if (!error)
            return true;
        osal_usleep(1000);
    }
    return false;
}

void soem_go(soem_t *m, uint16 slave, uint16 state)
{
    m->slaves[slave].state = state | EC_STATE_ACK;
    ecx_writestate(&m->context, slave);
    uint16 reached = ecx_statecheck(&m->context, slave, state, STATE_TIMEOUT_US);
    if (reached != state || !no_error(m, slave)) {
        ecx_readstate(&m->context);
        uint16 shown = slave == 0 ? 1 : slave;
        fail_msg("slave %u asked for state %u is in 0x%02X, AL status code 0x%04X", slave, state,
                 m->slaves[shown].state, m->slaves[shown].ALstatuscode);
    }
}

uint16 soem_request(soem_t *m, uint16 slave, uint16 state, uint16 *code)
{
    m->slaves[slave].state = state;
    ecx_writestate(&m->context, slave);
    for (int tries = 0; tries < TRIES; tries++) {
        osal_usleep(1000);
        ecx_readstate(&m->context);
        if ((m->slaves[slave].state & EC_STATE_ERROR) != 0 || m->slaves[slave].state == state)
            break;
    }
    *code = m->slaves[slave].ALstatuscode;
    return m->slaves[slave].state;
}

uint16 soem_await(soem_t *m, uint16 slave, uint16 state)
{
    for (int tries = 0; tries < TRIES; tries++) {
        ecx_readstate(&m->context);
        if (m->slaves[slave].state == state)
            break;
        osal_usleep(1000);
    }
    return m->slaves[slave].state;
}

/* The mailboxes for BOOT are those of the SII. */
static void set_boot_mailbox(soem_t *m, uint16 slave, unsigned int sm, uint16 word)
{
    ec_slavet *s = &m->slaves[slave];
    uint32 entry = ecx_readeeprom(&m->context, slave, word, EC_TIMEOUTEEP);
    s->SM[sm].StartAddr = htoes((uint16)(entry & 0xFFFF));
    s->SM[sm].SMlength = htoes((uint16)(entry >> 16));
    if (sm == 0) {
        s->mbx_wo = (uint16)(entry & 0xFFFF);
        s->mbx_l = (uint16)(entry >> 16);
    } else {
        s->mbx_ro = (uint16)(entry & 0xFFFF);
        s->mbx_rl = (uint16)(entry >> 16);
    }
    assert_true(entry >> 16 > 0);
    uint8 off = 0; /* one that is on cannot be moved */
    ecx_FPWR(&m->port, s->configadr, (uint16)(ECT_REG_SM0 + 8 * sm + 6), 1, &off, EC_TIMEOUTSAFE);
    ecx_FPWR(&m->port, s->configadr, (uint16)(ECT_REG_SM0 + 8 * sm), sizeof(ec_smt), &s->SM[sm], EC_TIMEOUTRET3);
}

void soem_boot(soem_t *m, uint16 slave)
{
    soem_go(m, slave, EC_STATE_INIT);
    set_boot_mailbox(m, slave, 0, ECT_SII_BOOTRXMBX);
    set_boot_mailbox(m, slave, 1, ECT_SII_BOOTTXMBX);
    soem_go(m, slave, EC_STATE_BOOT);
}

void soem_map(soem_t *m)
{
    ecx_config_map_group(&m->context, m->image, 0);
    soem_go(m, 0, EC_STATE_SAFE_OP);
}

int soem_expected_wkc(const soem_t *m)
{
    return m->groups[0].outputsWKC * 2 + m->groups[0].inputsWKC;
}

int soem_exchange(soem_t *m)
{
    ecx_send_processdata(&m->context);
    return ecx_receive_processdata(&m->context, is_in_process() ? IN_PROCESS_US : REPLY_TIMEOUT_US);
}

int soem_cycle(soem_t *m)
{
    int wkc = soem_exchange(m);
    osal_usleep(CYCLE_US);
    return wkc;
}

void soem_operational(soem_t *m)
{
    soem_cycle(m);
    m->slaves[0].state = EC_STATE_OPERATIONAL;
    ecx_writestate(&m->context, 0);
    for (int tries = 0; tries < 2000; tries++) {
        soem_cycle(m);
        if (ecx_statecheck(&m->context, 0, EC_STATE_OPERATIONAL, 500) == EC_STATE_OPERATIONAL)
            return;
    }
    soem_go(m, 0, EC_STATE_OPERATIONAL);
}

bool soem_until(soem_t *m, bool (*holds)(soem_t *m), unsigned int ms)
{
    for (unsigned int i = 0; i < ms; i++) {
        soem_cycle(m);
        if (holds(m))
            return true;
    }
    return false;
}

/* The last SDO error that SOEM reports: its abort code, 0xFFFFFFFF for anything else. */
static uint32 last_error(soem_t *m)
{
    ec_errort error;
    uint32 result = 0xFFFFFFFF;
    while (ecx_poperror(&m->context, &error)) {
        if (error.Etype == EC_ERR_TYPE_SDO_ERROR)
            result = (uint32)error.AbortCode;
    }
    return result;
}

uint32 soem_read(soem_t *m, uint16 slave, uint16 index, uint8 subindex, bool complete, void *data, int *size)
{
    int wkc = ecx_SDOread(&m->context, slave, index, subindex, complete, size, data, EC_TIMEOUTRXM);
    return wkc > 0 ? 0 : last_error(m);
}

uint32 soem_write(soem_t *m, uint16 slave, uint16 index, uint8 subindex, bool complete, const void *data, int size)
{
    uint8 copy[EC_MAXMBX];
    memcpy(copy, data, (size_t)size);
    int wkc = ecx_SDOwrite(&m->context, slave, index, subindex, complete, size, copy, EC_TIMEOUTRXM);
    return wkc > 0 ? 0 : last_error(m);
}
