/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A run of ectwin-conform without a wire: cf_port_exchange is wrapped and reads and writes `memory`, a chip of plain
 * bytes. Include after cmocka.h.
 */
#ifndef CONFORM_SUPPORT_H
#define CONFORM_SUPPORT_H

#include <sys/socket.h>

#include "catalogue.h"
#include "report/report.h"
#include "runner.h"
#include "wire/registers.h"

/** The chip. Every address takes writes, but AL status follows AL control. */
static uint8_t memory[65536];
/** Called before each datagram; NULL: none. @return false: the frame does not return */
static bool (*on_datagram)(cf_datagram_t *d);
static unsigned int frames_sent;

bool __wrap_cf_port_exchange(cf_port_t *port, cf_datagram_t *d, size_t count, uint32_t timeout_ms);

static bool is_read(uint8_t command)
{
    return command == CF_FPRD || command == CF_APRD || command == CF_BRD;
}

bool __wrap_cf_port_exchange(cf_port_t *port, cf_datagram_t *d, size_t count, uint32_t timeout_ms)
{
    const uint8_t frame[60] = {(uint8_t)frames_sent, (uint8_t)(frames_sent >> 8)};
    (void)port;
    (void)timeout_ms;
    frames_sent++;
    (void)send(-1, frame, sizeof frame, 0); /* the record takes it, no socket does */
    for (size_t i = 0; i < count; i++) {
        uint8_t *at = memory + (d[i].address >> 16);
        if (on_datagram && !on_datagram(&d[i]))
            return false;
        if (is_read(d[i].command))
            memcpy(d[i].data, at, d[i].length);
        else
            memcpy(at, d[i].data, d[i].length);
        memory[ECT_REG_AL_STATUS] = memory[ECT_REG_AL_CONTROL] & ECT_AL_STATE_MASK;
        d[i].wkc = 1;
    }
    return true;
}

/** A run with its engine, of a slave without a mailbox in INIT. */
static inline void start_run(cf_run_t *run)
{
    *run =
        (cf_run_t){.iface = "test0", .version = "1.2.3", .command = "ectwin-conform -i test0", .started = "2026-01-02"};
    run->c.engine = &run->engine;
    run->c.facts.station = CF_STATION;
    run->c.facts.slaves = 1;
    run->c.facts.has = CF_APPLICATION;
    run->c.facts.ram_kb = 8;
    run->engine.seed = 1;
    memset(memory, 0, sizeof memory);
    memory[ECT_REG_AL_CONTROL] = memory[ECT_REG_AL_STATUS] = CF_INIT;
    on_datagram = NULL;
    frames_sent = 0;
    cf_record_open(NULL);
}

/** Ends a run of results on the stack. */
static inline void end_run(cf_run_t *run)
{
    cf_engine_free(&run->engine);
    cf_record_close();
}

/** Runs one function as a case. @return its verdict; the reason is in *result, whose evidence is freed */
static inline cf_verdict_t run_one(cf_run_t *run, void (*function)(cf_t *c), uint32_t needs, cf_result_t *result)
{
    const cf_case_t entry = {"CF-900", "A case of a test", 'R', needs, 0, function};
    const cf_section_t section = {'Z', "Tests", &entry, 1};
    cf_run_case(run, &section, &entry, result);
    cf_evidence_free(&result->evidence);
    result->entry = NULL;
    result->section = NULL;
    return result->verdict;
}

#endif
