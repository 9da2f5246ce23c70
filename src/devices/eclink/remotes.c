/* SPDX-License-Identifier: MIT */
/* Remote units: arming, states, links, and their part of the input data (TS-0007 §8.3 to §8.5, §10.5, §10.6). */
#include <string.h>

#include "devices/eclink/instance.h"
#include "wire/bytes.h"

static unsigned int most_armed(const eclink_t *unit)
{
    return (unit->fmap & ECLINK_FMAP_MULTIARM) != 0 ? ECLINK_MOST_ARMED : 1;
}

static void list_add(eclink_list_t *list, unsigned int number)
{
    list->numbers[list->count++] = (uint8_t)number;
}

static void list_remove(eclink_list_t *list, unsigned int number)
{
    uint8_t kept = 0;
    for (uint8_t i = 0; i < list->count; i++) {
        if (list->numbers[i] != number)
            list->numbers[kept++] = list->numbers[i];
    }
    list->count = kept;
}

/* Releases the VLAP of a remote. */
static void disarm(eclink_t *unit, unsigned int number)
{
    unit->remotes_due |= unit->ru[number].armed;
    list_remove(&unit->armed, number);
    unit->ru[number].armed = 0;
}

const char *eclink_why_unreachable(const eclink_ru_t *ru)
{
    if (!ru->on)
        return "this remote unit is not switched on: set its 'on' first";
    if (!eclink_reachable(ru))
        return "this remote unit is out of communication: neither G-Link nor a VLAP nor the cable reaches it";
    return NULL;
}

/* @return whether C-Link is usable for arming, fallback and the reported status: a VLAP, a signal, no error */
static bool c_link_works(const eclink_ru_t *ru, bool has_vlap)
{
    return has_vlap && ru->rssi > 0 && !eclink_is_error(ru->forced_c_link);
}

static unsigned int reserved_vlaps(const eclink_t *unit)
{
    unsigned int count = 0;
    for (unsigned int i = 0; i < unit->armed.count; i++)
        count += unit->ru[unit->armed.numbers[i]].cable == 0;
    return count;
}

/* @return the reason why a reachable remote cannot be armed; NULL: it can be armed */
static const char *why_not_armed(const eclink_t *unit, const eclink_ru_t *ru)
{
    if (unit->bu.state == ECLINK_BU_INITIAL)
        return "the base unit is Initial, not fully operative yet (TS-0007 8.1, 11): read 'bu.cause'";
    if (unit->bu.state == ECLINK_BU_LINK_ERROR)
        return "there is an External link error, no normal operation (TS-0007 8.1, 11): read 'bu.cause'";
    if (unit->bu.state == ECLINK_BU_FAILED)
        return "the base unit has failed (TS-0007 8.1): set 'bu.failed' to 0";
    if (unit->armed.count == most_armed(unit))
        return most_armed(unit) == 1 ? "another remote unit is armed, and without MultiArm there can be only one"
                                     : "three remote units are armed already";
    if (!ru->cable && reserved_vlaps(unit) >= unit->bu.vlaps)
        return "no VLAP is left for it: each armed remote unit without cable reserves one of 'bu.vlaps' (TS-0007 10.6)";
    if (!ru->cable && !c_link_works(ru, true))
        return "its C-Link does not work: set 'rssi' above 0, and 'c_link' to -1 (TS-0007 10.6)";
    return NULL;
}

/* A rearmed remote is no longer lost. Without a free place an armed remote replaces the remote that was lost first. */
const char *eclink_arm(eclink_t *unit, unsigned int number, bool armed)
{
    eclink_ru_t *ru = &unit->ru[number];
    if (!armed) {
        disarm(unit, number);
        return NULL;
    }
    const char *refusal = eclink_why_unreachable(ru);
    if (!refusal && ru->armed)
        return NULL;
    if (!refusal)
        refusal = why_not_armed(unit, ru);
    if (refusal)
        return refusal;
    list_add(&unit->armed, number);
    ru->armed = 1;
    list_remove(&unit->lost, number);
    if (unit->armed.count + unit->lost.count > most_armed(unit))
        list_remove(&unit->lost, unit->lost.numbers[0]);
    return NULL;
}

/* Handles a loss of communication: commands and data on their way are lost. An armed remote blocks the unit until it is
 * rearmed (§8.1). */
static void lose(eclink_t *unit, unsigned int number)
{
    unit->ru[number].commands_dropped += unit->ru[number].to_ru.count;
    unit->ru[number].to_ru.count = 0;
    unit->ru[number].periodic_waits = false;
    unit->ru[number].sent = 0;
    if (!unit->ru[number].armed)
        return;
    disarm(unit, number);
    list_add(&unit->lost, number);
}

static uint8_t ru_state(const eclink_ru_t *ru)
{
    if (!ru->armed)
        return ECLINK_RU_INITIAL;
    if (ru->failed)
        return ECLINK_RU_FAILED;
    if (ru->stop || ru->shock)
        return ECLINK_RU_STOPPED;
    return ru->disabled != 0 ? ECLINK_RU_ARMED : ECLINK_RU_ENABLED;
}

bool eclink_reachable(const eclink_ru_t *ru)
{
    return ru->path != ECLINK_PATH_NONE;
}

static bool take(unsigned int *vlaps)
{
    if (*vlaps == 0)
        return false;
    (*vlaps)--;
    return true;
}

/* A forced status determines the state of the radio. */
static bool g_link_works(const eclink_ru_t *ru)
{
    if (ru->forced_g_link == ECLINK_NOT_FORCED)
        return !ru->g_link_lost;
    return !eclink_is_error(ru->forced_g_link) && ru->forced_g_link != ECLINK_LINK_FALLBACK;
}

/* An armed remote reserves a VLAP, in the order of arming; an unarmed one needs it only on fallback. */
static eclink_path_t path_of(eclink_ru_t *ru, unsigned int *vlaps)
{
    ru->vlap = false;
    if (!ru->on)
        return ECLINK_PATH_NONE;
    if (ru->cable)
        return ECLINK_PATH_FULL;
    bool works = g_link_works(ru);
    ru->vlap = (ru->armed || !works) && take(vlaps);
    if (works)
        return ECLINK_PATH_FULL;
    return c_link_works(ru, ru->vlap) ? ECLINK_PATH_C_LINK : ECLINK_PATH_NONE;
}

/* On cable the remote needs no VLAP. */
static uint8_t c_link(const eclink_ru_t *ru)
{
    if (!ru->on)
        return ECLINK_LINK_UNUSED;
    if (!ru->armed)
        return ECLINK_LINK_PASSIVE;
    return ru->cable || c_link_works(ru, ru->vlap) ? ECLINK_LINK_OPERATIONAL : ECLINK_LINK_NONE;
}

static uint8_t g_link(const eclink_ru_t *ru)
{
    static const uint8_t status[] = {[ECLINK_PATH_NONE] = ECLINK_LINK_NONE,
                                     [ECLINK_PATH_C_LINK] = ECLINK_LINK_FALLBACK,
                                     [ECLINK_PATH_FULL] = ECLINK_LINK_OPERATIONAL};
    return ru->on ? status[ru->path] : (uint8_t)ECLINK_LINK_UNUSED;
}

static void update_one(eclink_t *unit, unsigned int number)
{
    eclink_ru_t *ru = &unit->ru[number];
    if (ru->path == ECLINK_PATH_NONE)
        lose(unit, number);
    ru->c_link = ru->forced_c_link != ECLINK_NOT_FORCED ? ru->forced_c_link : c_link(ru);
    ru->g_link = ru->forced_g_link != ECLINK_NOT_FORCED ? ru->forced_g_link : g_link(ru);
    ru->state = ru_state(ru);
    unit->bu.unarmed = (uint8_t)(unit->bu.unarmed + (eclink_reachable(ru) && !ru->armed));
}

static void update_all(eclink_t *unit)
{
    unsigned int vlaps = unit->bu.vlaps;
    unit->remotes_due = false;
    for (unsigned int i = 0; i < unit->armed.count; i++)
        unit->ru[unit->armed.numbers[i]].path = path_of(&unit->ru[unit->armed.numbers[i]], &vlaps);
    for (unsigned int i = 0; i < ECLINK_RUS; i++) {
        if (!unit->ru[i].armed)
            unit->ru[i].path = path_of(&unit->ru[i], &vlaps);
    }
    unit->bu.unarmed = 0;
    for (unsigned int i = 0; i < ECLINK_RUS; i++)
        update_one(unit, i);
    unit->bu.armed = unit->armed.count;
}

/* Each pass reduces the number of armed remotes by one, or is the last. */
void eclink_remotes_update(eclink_t *unit)
{
    while (unit->remotes_due)
        update_all(unit);
}

/* Movements are permitted only in Enabled (§8.3): in other states a joystick is passive, 0 (§8.4). */
static void publish_one(const eclink_ru_t *ru, uint8_t *to)
{
    bool enabled = ru->state == ECLINK_RU_ENABLED;
    ect_store_be16(to + ECLINK_RU_ID, ru->id);
    to[ECLINK_RU_STATE] = ru->state;
    to[ECLINK_RU_BATTERY] = ru->battery;
    to[ECLINK_RU_RSSI] = ru->rssi;
    to[ECLINK_RU_CABLE] = ru->cable;
    to[ECLINK_RU_DOCKED] = ru->docked;
    to[ECLINK_RU_DISABLED] = ru->disabled;
    to[ECLINK_RU_C_LINK] = (uint8_t)ru->c_link;
    to[ECLINK_RU_G_LINK] = (uint8_t)ru->g_link;
    for (unsigned int i = 0; i < ECLINK_JOYSTICKS; i++)
        ect_store_be16(to + ECLINK_RU_JOYSTICK + (size_t)2 * i, enabled ? (uint16_t)ru->joystick[i] : 0);
    for (unsigned int i = 0; i < ECLINK_SWITCHES; i++)
        ect_store_be16(to + ECLINK_RU_SWITCH + (size_t)2 * i, (uint16_t)ru->switches[i]);
    to[ECLINK_RU_ENCODER] = ru->encoder;
    to[ECLINK_RU_ENCODER_SWITCH] = ru->encoder_switch;
}

/* Without an armed remote all fields are 0 (§8); byte 36 can report "passive" instead (EC-C9). */
void eclink_remotes_publish(const eclink_t *unit, uint8_t *inputs)
{
    memset(inputs + ECLINK_IN_RU, 0, ECLINK_INPUT_BYTES - ECLINK_IN_RU);
    for (unsigned int i = 0; i < unit->armed.count; i++)
        publish_one(&unit->ru[unit->armed.numbers[i]], inputs + ECLINK_IN_RU + (size_t)i * ECLINK_IN_RU_STRIDE);
    if (unit->armed.count == 0 && unit->bu.report_passive)
        inputs[ECLINK_IN_RU + ECLINK_RU_C_LINK] = ECLINK_LINK_PASSIVE;
}
