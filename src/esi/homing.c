/* SPDX-License-Identifier: MIT */
/*
 * S-0-0148, the homing procedure of a SoE drive: S-0-0147 selects a reference run of CiA 402, which the axis executes.
 * The drive obeys its set values again after the command is cleared, or in the next OP.
 */
#include <string.h>

#include "esi/internal.h"

#include "profiles/cia402/drive.h"
#include "wire/bytes.h"

enum {
    HOMING_SPEED = 41,
    HOMING_ACCELERATION = 42,
    REFERENCE_DISTANCE = 52,
    PARAMETER = 147,
    HOME_SWITCH = 400,
    HOMED = 403,
};

/* Bits of S-0-0147. */
enum {
    NEGATIVE = 0x0001,
    FALLING_EDGE = 0x0002,
    SWITCH_AT_DRIVE = 0x0004,
    WITHOUT_SWITCH = 0x0020,
    WITHOUT_MARKER = 0x0040,
};

/* S-0-0403: the feedback in use, feedback 1. */
enum { ALL_HOMED = 0x0003 };

/* Bits 13 to 15 of S-0-0134: without one of them a run ends. */
enum { ALL_ENABLED = 0xE000 };

/* Reference runs of CiA 402. */
enum { TO_MARKER_DOWN = 33, TO_MARKER_UP = 34, AT_PLACE = 37, NO_METHOD = 0 };

/* Phases of a run, ect_esi_words_t::homing. The axis ignores a start bit that comes with the mode. */
enum { NO_RUN, ENTERS, STARTS, RUNS, HOLDS };

static ect_esi_words_t *words_of(const ect_esi_dialect_t *dialect, void *instance)
{
    return (ect_esi_words_t *)(void *)((uint8_t *)instance + dialect->words);
}

bool ect_esi_homing_find(const ect_build_t *build, ect_esi_dialect_t *dialect)
{
    const ect_build_idn_t *command = ect_build_idn(build, dialect->drive, ECT_ESI_HOMING);
    if (command == NULL || (command->row.attribute & ECT_SOE_COMMAND) == 0)
        return false;
    dialect->homing = command->row.offset;
    dialect->parameter = ect_esi_dialect_link(build, dialect->drive, PARAMETER);
    dialect->distance = ect_esi_dialect_link(build, dialect->drive, REFERENCE_DISTANCE);
    dialect->home_switch = ect_esi_dialect_link(build, dialect->drive, HOME_SWITCH);
    dialect->homed = ect_esi_dialect_link(build, dialect->drive, HOMED);
    return true;
}

/* A start reads these values, which process data never change. */
static ect_402_link_t setting(ect_402_link_t link)
{
    link.output = false;
    return link;
}

void ect_esi_homing_links(const ect_build_t *build, const ect_esi_dialect_t *dialect, ect_402_link_t *links)
{
    const ect_402_link_t speed = setting(ect_esi_dialect_link(build, dialect->drive, HOMING_SPEED));
    if (!dialect->homes)
        return;
    links[ECT_402_V_HOME_SEARCH] = links[ECT_402_V_HOME_ZERO] = speed;
    links[ECT_402_V_HOME_ACCELERATION] = setting(ect_esi_dialect_link(build, dialect->drive, HOMING_ACCELERATION));
    links[ECT_402_V_HOME_METHOD] =
        (ect_402_link_t){.offset = (uint32_t)(dialect->words + offsetof(ect_esi_words_t, method)),
                         .bytes = sizeof(int8_t),
                         .is_signed = true};
    links[ECT_402_V_HOME_OFFSET] =
        (ect_402_link_t){.offset = (uint32_t)(dialect->words + offsetof(ect_esi_words_t, home)),
                         .bytes = sizeof(int32_t),
                         .is_signed = true};
}

/* --- the command -------------------------------------------------------------------------------------------------- */

/* @return NO_METHOD: the control unit reports the switch in a real-time bit, which the twin does not have */
static int8_t method_of(uint16_t parameter)
{
    static const int8_t to_switch[] = {24, 28, 26, 30}; /* by NEGATIVE and FALLING_EDGE */
    enum { WITH_MARKER = 16 /* from a method without a marker to the method with a marker */ };
    const bool marker = (parameter & WITHOUT_MARKER) == 0;
    if ((parameter & WITHOUT_SWITCH) == 0 && (parameter & SWITCH_AT_DRIVE) == 0)
        return NO_METHOD;
    if ((parameter & WITHOUT_SWITCH) == 0)
        return (int8_t)(to_switch[parameter & (NEGATIVE | FALLING_EDGE)] - (marker ? WITH_MARKER : 0));
    if (!marker)
        return AT_PLACE;
    return (parameter & NEGATIVE) != 0 ? TO_MARKER_DOWN : TO_MARKER_UP;
}

static bool is_enabled(const ect_esi_dialect_t *dialect, const void *instance, const ect_402_drive_t *d)
{
    uint16_t control;
    memcpy(&control, (const uint8_t *)instance + dialect->control, sizeof control);
    return d->al == ECT_STATE_OP && d->axis.state == ECT_402_OPERATION_ENABLED &&
           (control & ALL_ENABLED) == ALL_ENABLED;
}

uint16_t ect_esi_homing_start(const ect_esi_dialect_t *dialect, void *instance, ect_402_drive_t *d, bool *runs)
{
    ect_esi_words_t *words = words_of(dialect, instance);
    const ect_402_link_t *parameter = &dialect->parameter;
    const int64_t selected = parameter->bytes != 0 ? ect_402_load(instance, parameter) : SWITCH_AT_DRIVE;
    *runs = false;
    if (!is_enabled(dialect, instance, d))
        return ECT_SOE_COMMAND_NOT_NOW;
    words->method = method_of((uint16_t)selected);
    words->home = ect_402_saturated(-(double)ect_402_load(instance, &dialect->distance));
    ect_402_drive_read(d, true);
    *runs = words->method != NO_METHOD;
    words->homing = *runs ? ENTERS : NO_RUN;
    return ECT_SOE_OK;
}

void ect_esi_homing_cancel(const ect_esi_dialect_t *dialect, void *instance)
{
    words_of(dialect, instance)->homing = NO_RUN;
}

static bool is_cleared(const ect_esi_dialect_t *dialect, const void *instance)
{
    const ect_soe_command_t *command = (const void *)((const uint8_t *)instance + dialect->homing);
    return command->state == ECT_SOE_COMMAND_CLEARED;
}

/* --- the run ------------------------------------------------------------------------------------------------------ */

void ect_esi_homing_in(const ect_esi_dialect_t *dialect, void *instance)
{
    ect_esi_words_t *words = words_of(dialect, instance);
    if (words->homing == HOLDS && is_cleared(dialect, instance))
        words->homing = NO_RUN;
    if (words->homing == NO_RUN)
        return;
    words->mode = ECT_402_HM;
    if (words->homing == STARTS || words->homing == RUNS)
        words->control |= ECT_402_START;
}

bool ect_esi_homing_ends(const ect_esi_dialect_t *dialect, void *instance, const ect_402_drive_t *d, bool *success)
{
    ect_esi_words_t *words = words_of(dialect, instance);
    const bool begun = (d->axis.set.control & ECT_402_START) != 0;
    const bool under_way = words->homing != NO_RUN && words->homing != HOLDS;
    *success = words->homing == RUNS && d->axis.homing.done;
    if (words->homing == ENTERS && d->axis.mode_running == ECT_402_HM && !begun)
        words->homing = STARTS;
    else if (words->homing == STARTS && begun)
        words->homing = RUNS;
    const bool over = words->homing == RUNS && !d->axis.homing.active;
    const bool ends = under_way && (over || !is_enabled(dialect, instance, d));
    if (ends)
        words->homing = HOLDS;
    if (d->al != ECT_STATE_OP)
        words->homing = NO_RUN;
    return ends;
}

void ect_esi_homing_out(const ect_esi_dialect_t *dialect, void *instance, const ect_402_drive_t *d)
{
    if (!dialect->homes)
        return;
    ect_402_store(instance, &dialect->home_switch, d->axis.level[ECT_402_HOME]);
    ect_402_store(instance, &dialect->homed, d->axis.homed ? ALL_HOMED : 0);
}
