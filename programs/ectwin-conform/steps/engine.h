/* SPDX-License-Identifier: MIT */
/** @file The state behind the steps: port, time limit, verdict, changes. Not for cases. */
#ifndef ECTWIN_CONFORM_ENGINE_H
#define ECTWIN_CONFORM_ENGINE_H

#include <setjmp.h>

#include "steps/case.h"
#include "steps/record.h"

typedef enum cf_verdict {
    CF_PASS,
    CF_WARN,
    CF_FAIL,
    CF_SKIPPED,
    CF_UNJUDGED, /**< the canary before the case failed: an earlier case left the slave unable to reply */
    CF_INTERRUPTED
} cf_verdict_t;

enum { CF_REASON = 400, CF_STEP = 120 };

/** The step between the preparation of the slave and the function of the case. */
#define CF_CASE_BEGINS "the case begins"

/** A lasting change of a case, with the old value. */
typedef struct cf_undo {
    enum { CF_UNDO_OBJECT, CF_UNDO_SII, CF_UNDO_FILE, CF_UNDO_CALL } what;
    uint16_t index; /**< index of the object, or word of the EEPROM */
    uint8_t sub;
    uint8_t state; /**< AL state for writing the file */
    size_t size;
    uint8_t data[CF_CHANGE_MOST];
    uint8_t *file; /**< content of the file; freed with the change */
    void (*put_back)(cf_t *c, const uint8_t *data, size_t size);
} cf_undo_t;

enum { CF_UNDO_MOST = 64 };

/** A histogram of up to CF_VALUES_MOST values. */
typedef struct cf_series {
    const char *name;
    uint32_t count;
    uint64_t *values_ns; /**< CF_VALUES_MOST values; owned by the engine */
} cf_series_t;

enum { CF_VALUES_MOST = 2000 };

typedef struct cf_engine {
    cf_port_t *port;
    jmp_buf leave;
    bool running;         /**< a case runs; `leave` is set */
    uint64_t deadline_ns; /**< of the case */
    uint32_t limit_ms;
    cf_verdict_t verdict;
    char reason[CF_REASON];
    char step[CF_STEP];
    uint32_t frame;
    cf_undo_t undo[CF_UNDO_MOST]; /**< in the order of the changes */
    size_t undo_count;
    void (*idle)(cf_t *c, void *ctx); /**< called while a step waits */
    void *idle_ctx;
    bool in_idle;
    uint64_t seed;
    cf_series_t series[CF_SERIES_MOST];
    size_t series_count;
    uint8_t *room[2];     /**< of ::cf_room; NULL: not used yet */
    bool pulled;          /**< the slave's plug is pulled, to be reinserted */
    uint8_t port_control; /**< old value of 0x0101 of the slave before it; unused for the first slave */
    bool silent;          /**< the last frame was lost: the next one gets a shorter timeout */
    bool stuck;           /**< the slave did not return to INIT: INIT gets a shorter timeout */
} cf_engine_t;

/** Puts a pulled plug back and waits until all slaves reply. */
void cf_put_plug_back(cf_t *c);

/** Leaves the case, or the preparation of the slave, with that verdict. */
_Noreturn void cf_leave(cf_t *c, cf_verdict_t verdict, const char *reason);
void cf_sii_write_word(cf_t *c, uint16_t word, uint16_t value);
/** Appends a change to the list. Leaves the case when the list is full. */
cf_undo_t *cf_new_undo(cf_t *c);
/** Frees buffers, histograms and the list of changes. The engine is then empty, and can be used again. */
void cf_engine_free(cf_engine_t *e);
/** Frees all changes of the list, undone or not. */
void cf_forget_changes(cf_engine_t *e);
/** Restores the slave: plug, INIT, changes in reverse order, INIT. Leaves by longjmp, as a step does, on failure. */
void cf_put_back(cf_t *c);
/** Leaves the case at the end of its time limit and on Ctrl-C. */
void cf_check_time(cf_t *c);

#endif
