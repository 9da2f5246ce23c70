/* SPDX-License-Identifier: MIT */
/* Remote units: arming, states, links, and their part of the input data (TS-0007 §8.3 to §8.5, §10.5, §10.6). */
#include <string.h>

#include "devices/eclink/instance.h"
#include "wire/bytes.h"

static unsigned int most_armed(const eclink_t *unit)
{
    return (unit->fmap & ECLINK_FMAP_MULTIARM) != 0 ? ECLINK_MOST_ARMED : 1;
}

static void disarm(eclink_t *unit, unsigned int number)
{
    uint8_t kept = 0;
    for (uint8_t i = 0; i < unit->armed_count; i++) {
        if (unit->armed[i] != number)
            unit->armed[kept++] = unit->armed[i];
    }
    unit->armed_count = kept;
    unit->ru[number].armed = 0;
}

const char *eclink_why_unreachable(eclink_t *unit, unsigned int number)
{
    const eclink_ru_t *ru = &unit->ru[number];
    eclink_remotes_update(unit); /* what was set last may not have been evaluated yet */
    if (!ru->on)
        return "this remote unit is not switched on: set its 'on' first";
    if (!eclink_reachable(ru))
        return "this remote unit is out of communication: neither G-Link nor a VLAP nor the cable reaches it";
    return NULL;
}

const char *eclink_arm(eclink_t *unit, unsigned int number, bool armed)
{
    eclink_ru_t *ru = &unit->ru[number];
    if (!armed) {
        disarm(unit, number);
        return NULL;
    }
    const char *refusal = eclink_why_unreachable(unit, number);
    if (refusal)
        return refusal;
    if (ru->armed)
        return NULL;
    if (unit->armed_count == most_armed(unit))
        return most_armed(unit) == 1 ? "another remote unit is armed, and without MultiArm there can be only one"
                                     : "three remote units are armed already";
    unit->armed[unit->armed_count++] = (uint8_t)number;
    ru->armed = 1;
    unit->blocked = (uint8_t)(unit->blocked & ~(1u << number)); /* rearmed */
    return NULL;
}

/* Out of sight: what was on its way to it is gone. While armed, the base unit blocks until it is armed again (§8.1). */
void eclink_lose(eclink_t *unit, unsigned int number)
{
    unit->ru[number].to_ru.count = 0;
    unit->ru[number].periodic_waits = false;
    unit->ru[number].sent = 0;
    if (!unit->ru[number].armed)
        return;
    disarm(unit, number);
    unit->blocked = (uint8_t)(unit->blocked | (1u << number));
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
    return ru->on && ru->g_link != ECLINK_LINK_NONE;
}

static bool take(unsigned int *vlaps)
{
    if (*vlaps == 0)
        return false;
    (*vlaps)--;
    return true;
}

/* An armed remote reserves a VLAP, in the order of arming; an unarmed one needs it only on fallback. */
static uint8_t g_link(const eclink_ru_t *ru, unsigned int *vlaps)
{
    if (!ru->on)
        return ECLINK_LINK_UNUSED;
    if (ru->cable)
        return ECLINK_LINK_OPERATIONAL;
    bool has_vlap = (ru->armed || ru->g_link_lost) && take(vlaps);
    if (!ru->g_link_lost)
        return ECLINK_LINK_OPERATIONAL;
    return has_vlap ? ECLINK_LINK_FALLBACK : ECLINK_LINK_NONE;
}

void eclink_remotes_update(eclink_t *unit)
{
    unsigned int vlaps = unit->bu.vlaps;
    unit->bu.unarmed = 0;
    for (unsigned int i = 0; i < unit->armed_count; i++)
        unit->ru[unit->armed[i]].g_link = g_link(&unit->ru[unit->armed[i]], &vlaps);
    for (unsigned int i = 0; i < ECLINK_RUS; i++) {
        eclink_ru_t *ru = &unit->ru[i];
        if (!ru->armed)
            ru->g_link = g_link(ru, &vlaps);
        if (ru->g_link == ECLINK_LINK_NONE)
            eclink_lose(unit, i);
        ru->c_link = !ru->on ? ECLINK_LINK_UNUSED : ru->armed ? ECLINK_LINK_OPERATIONAL : ECLINK_LINK_PASSIVE;
        ru->state = ru_state(ru);
        unit->bu.unarmed = (uint8_t)(unit->bu.unarmed + (eclink_reachable(ru) && !ru->armed));
    }
    unit->bu.armed = unit->armed_count;
}

static void publish_one(const eclink_ru_t *ru, uint8_t *to)
{
    ect_store_be16(to + ECLINK_RU_ID, ru->id);
    to[ECLINK_RU_STATE] = ru->state;
    to[ECLINK_RU_BATTERY] = ru->battery;
    to[ECLINK_RU_RSSI] = ru->rssi;
    to[ECLINK_RU_CABLE] = ru->cable;
    to[ECLINK_RU_DOCKED] = ru->docked;
    to[ECLINK_RU_DISABLED] = ru->disabled;
    to[ECLINK_RU_C_LINK] = ru->c_link;
    to[ECLINK_RU_G_LINK] = ru->g_link;
    for (unsigned int i = 0; i < ECLINK_JOYSTICKS; i++)
        ect_store_be16(to + ECLINK_RU_JOYSTICK + (size_t)2 * i, (uint16_t)ru->joystick[i]);
    for (unsigned int i = 0; i < ECLINK_SWITCHES; i++)
        ect_store_be16(to + ECLINK_RU_SWITCH + (size_t)2 * i, (uint16_t)ru->switches[i]);
    to[ECLINK_RU_ENCODER] = ru->encoder;
    to[ECLINK_RU_ENCODER_SWITCH] = ru->encoder_switch;
}

/* No remote armed: all its fields are 0 (§8), but for byte 36 where the installation wants "passive" there (EC-C9). */
void eclink_remotes_publish(const eclink_t *unit, uint8_t *inputs)
{
    memset(inputs + ECLINK_IN_RU, 0, ECLINK_INPUT_BYTES - ECLINK_IN_RU);
    for (unsigned int i = 0; i < unit->armed_count; i++)
        publish_one(&unit->ru[unit->armed[i]], inputs + ECLINK_IN_RU + (size_t)i * ECLINK_IN_RU_STRIDE);
    if (unit->armed_count == 0 && unit->bu.report_passive)
        inputs[ECLINK_IN_RU + ECLINK_RU_C_LINK] = ECLINK_LINK_PASSIVE;
}
