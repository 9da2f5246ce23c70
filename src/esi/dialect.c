/* SPDX-License-Identifier: MIT */
/*
 * The words of a SoE drive, S-0-0134 and S-0-0135, over an axis of CiA 402: its set values, actual values and operation
 * modes are those of the standard IDNs; state machine and plant are the same.
 */
#include "esi/internal.h"

#include "profiles/cia402/drive.h"
#include "wire/bytes.h"

enum {
    CONTROL_WORD = 134,
    STATUS_WORD = 135,
    OPERATION_MODE = 32, /* of the primary mode; three more follow */
    CLASS_1 = 11,
    NO_IDN = 0,
};

/* Bits of S-0-0134. */
enum {
    CONTROL_MODE_LOW = 8,
    CONTROL_MODE_HIGH = 0x0800,
    CONTROL_GO = 0x2000,
    CONTROL_ENABLE = 0x4000,
    CONTROL_ON = 0x8000
};

/* Bits of S-0-0135. */
enum { STATUS_FOLLOWS = 0x0008, STATUS_MODE = 8, STATUS_CLASS_1 = 0x2000, STATUS_POWER = 14 };

/* Values of bits 15 and 14 of S-0-0135. */
enum { NOT_READY, READY_FOR_POWER, READY_TO_ENABLE, ENABLED };

/* Operation modes, bits 0 to 2 of S-0-0032 to S-0-0035. */
enum { MODE_TORQUE = 1, MODE_SPEED = 2, MODE_POSITION_1 = 3, MODE_POSITION_12 = 5 };

/* Phases of a reset by S-0-0099, ect_esi_words_t::reset. */
enum { RESET_NONE, RESET_WANTED, RESET_SENT };

/* Values of CiA 402 that correspond to an IDN. */
static const struct {
    uint8_t value;
    uint16_t idn;
} same[] = {
    {ECT_402_V_TARGET_SPEED, 36}, {ECT_402_V_TARGET_POSITION, 47}, {ECT_402_V_TARGET_TORQUE, 80},
    {ECT_402_V_SPEED, 40},        {ECT_402_V_POSITION, 51},        {ECT_402_V_TORQUE, 84},
    {ECT_402_V_INCREMENTS, 79},   {ECT_402_V_ERROR_CODE, 390},     {ECT_402_V_FOLLOWING_ERROR, 189},
};

ect_402_link_t ect_esi_dialect_link(const ect_build_t *build, uint8_t drive, uint16_t idn)
{
    const ect_build_idn_t *of = ect_build_idn(build, drive, idn);
    if (of == NULL || of->row.offset == 0 || (of->row.attribute & (ECT_SOE_LIST | ECT_SOE_COMMAND)) != 0)
        return (ect_402_link_t){0};
    return (ect_402_link_t){.offset = (uint32_t)of->row.offset,
                            .bytes = (uint8_t)ect_soe_width(of->row.attribute),
                            .is_signed = true,
                            .is_real = (of->row.attribute & ECT_SOE_KIND) == ECT_SOE_FLOAT,
                            .output = true,
                            .given = of->row.initial != 0};
}

#define WORD(words, member, signedness)                                                                                \
    (ect_402_link_t)                                                                                                   \
    {                                                                                                                  \
        .offset = (uint32_t)((words) + offsetof(ect_esi_words_t, member)),                                             \
        .bytes = sizeof((ect_esi_words_t *)NULL)->member, .is_signed = signedness, .output = true                      \
    }

bool ect_esi_dialect_find(const ect_build_t *build, uint8_t drive, ect_esi_dialect_t *dialect)
{
    const ect_402_link_t control = ect_esi_dialect_link(build, drive, CONTROL_WORD);
    const ect_402_link_t status = ect_esi_dialect_link(build, drive, STATUS_WORD);
    *dialect = (ect_esi_dialect_t){.drive = drive, .follows = build->model->mailbox.soe_follows};
    if (control.bytes != sizeof(uint16_t) || status.bytes != sizeof(uint16_t))
        return false;
    dialect->control = control.offset;
    dialect->status = status.offset;
    for (unsigned int i = 0; i < sizeof dialect->modes / sizeof dialect->modes[0]; i++)
        dialect->modes[i] = ect_esi_dialect_link(build, drive, (uint16_t)(OPERATION_MODE + i));
    dialect->class_1 = ect_esi_dialect_link(build, drive, CLASS_1);
    dialect->class_1.is_signed = false; /* bit 15 is one of its bits */
    return true;
}

void ect_esi_dialect_links(const ect_build_t *build, ect_esi_dialect_t *dialect, size_t words, ect_402_link_t *links)
{
    dialect->words = words;
    for (unsigned int i = 0; i < ECT_402_VALUE_COUNT; i++)
        links[i] = (ect_402_link_t){0};
    for (unsigned int i = 0; i < sizeof same / sizeof same[0]; i++)
        links[same[i].value] = ect_esi_dialect_link(build, dialect->drive, same[i].idn);
    links[ECT_402_V_CONTROL] = WORD(words, control, false);
    links[ECT_402_V_STATUS] = WORD(words, status, false);
    links[ECT_402_V_MODE] = WORD(words, mode, true);
    links[ECT_402_V_MODE_DISPLAY] = WORD(words, shown, true);
}

/* --- to the axis -------------------------------------------------------------------------------------------------- */

static ect_esi_words_t *words_of(const ect_esi_dialect_t *dialect, void *instance)
{
    return (ect_esi_words_t *)(void *)((uint8_t *)instance + dialect->words);
}

static uint16_t *word_at(void *instance, size_t offset)
{
    return (uint16_t *)(void *)((uint8_t *)instance + offset);
}

/* @return the number of the mode that the control word selects: 0 the primary one, S-0-0032 */
static unsigned int selected(uint16_t control)
{
    return (control >> CONTROL_MODE_LOW & 3u) | ((control & CONTROL_MODE_HIGH) != 0 ? 4u : 0u);
}

static int8_t mode_of(const ect_esi_dialect_t *dialect, const void *instance, uint16_t control)
{
    enum { KINDS = 7 };
    const unsigned int number = selected(control);
    const bool known = number < sizeof dialect->modes / sizeof dialect->modes[0];
    const int64_t kind = known ? ect_402_load(instance, &dialect->modes[number]) & KINDS : 0;
    if (kind >= MODE_POSITION_1 && kind <= MODE_POSITION_12)
        return ECT_402_CSP;
    return kind == MODE_SPEED ? ECT_402_CSV : kind == MODE_TORQUE ? ECT_402_CST : ECT_402_NO_MODE;
}

/* Bit 14 clear removes the torque at once; only bit 15 clear stops the drive on the ramp of the quick stop; the
 * transition to enabled has a command for each state. */
static uint16_t command_of(ect_402_state_t state, uint16_t control)
{
    const uint16_t shutdown = ECT_402_VOLTAGE | ECT_402_NO_QUICK;
    const uint16_t switch_on = shutdown | ECT_402_SWITCH_ON;
    const bool moving = state == ECT_402_OPERATION_ENABLED || state == ECT_402_QUICK_STOP;
    if ((control & CONTROL_ENABLE) == 0)
        return 0;
    if ((control & CONTROL_ON) == 0)
        return moving ? ECT_402_VOLTAGE : shutdown;
    if (state == ECT_402_READY)
        return switch_on;
    if (state != ECT_402_SWITCHED_ON && state != ECT_402_OPERATION_ENABLED)
        return shutdown;
    return (uint16_t)(switch_on | ECT_402_ENABLE | ((control & CONTROL_GO) == 0 ? ECT_402_HALT : 0));
}

void ect_esi_dialect_in(const ect_esi_dialect_t *dialect, void *instance, const ect_402_drive_t *d)
{
    ect_esi_words_t *words = words_of(dialect, instance);
    const uint16_t control = *word_at(instance, dialect->control);
    words->mode = mode_of(dialect, instance, control);
    words->control = command_of(d->axis.state, control);
    if (words->reset == RESET_WANTED)
        words->control |= ECT_402_RESET;
}

/* --- to the master ------------------------------------------------------------------------------------------------ */

static uint16_t power_of(const ect_402_drive_t *d)
{
    const ect_402_state_t state = d->axis.state;
    const bool supplied = d->around->power && d->around->enable && !d->around->sto;
    if (state == ECT_402_NOT_READY || state == ECT_402_FAULT || state == ECT_402_FAULT_REACTION)
        return NOT_READY;
    if (state == ECT_402_OPERATION_ENABLED || state == ECT_402_QUICK_STOP)
        return ENABLED;
    return supplied ? READY_TO_ENABLE : READY_FOR_POWER;
}

/* S-0-0011: over-current, over-voltage, under-voltage, temperatures, following error, communication; else bit 15. */
static uint16_t class_1_of(uint16_t code)
{
    static const struct {
        uint16_t mask, code, bits;
    } rows[] = {
        {0xFFFF, 0, 0},
        {0xF000, 0x2000, 1u << 7},
        {0xFFFF, 0x3220, 1u << 9},
        {0xFF00, 0x3200, 1u << 8},
        {0xFF00, 0x4300, 1u << 1},
        {0xFF00, 0x7300, 1u << 5},
        {0xFF00, 0x7500, 1u << 12},
        {0xFF00, 0x8100, 1u << 12},
        {0xFFFF, 0x8611, 1u << 11},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        if ((code & rows[i].mask) == rows[i].code)
            return rows[i].bits;
    }
    return 1u << 15;
}

void ect_esi_dialect_out(const ect_esi_dialect_t *dialect, void *instance, const ect_402_drive_t *d)
{
    const ect_esi_words_t *words = words_of(dialect, instance);
    const uint16_t control = *word_at(instance, dialect->control);
    const bool follows = dialect->follows && (words->status & ECT_402_STATUS_ATTAINED) != 0;
    *word_at(instance, dialect->status) =
        (uint16_t)((unsigned int)power_of(d) << STATUS_POWER | (d->error_code != 0 ? STATUS_CLASS_1 : 0u) |
                   selected(control) << STATUS_MODE | (follows ? STATUS_FOLLOWS : 0u));
    ect_402_store(instance, &dialect->class_1, class_1_of(d->error_code));
}

bool ect_esi_dialect_writes(const ect_esi_dialect_t *dialect, size_t offset)
{
    const ect_402_link_t *links[] = {&dialect->class_1, &dialect->home_switch, &dialect->homed};
    bool writes = offset == dialect->status;
    for (unsigned int i = 0; i < sizeof links / sizeof links[0]; i++)
        writes |= links[i]->bytes != 0 && links[i]->offset == offset;
    return writes;
}

/* --- S-0-0099 ----------------------------------------------------------------------------------------------------- */

void ect_esi_dialect_reset(const ect_esi_dialect_t *dialect, void *instance, bool start)
{
    words_of(dialect, instance)->reset = start ? RESET_WANTED : RESET_NONE;
}

bool ect_esi_dialect_ends(const ect_esi_dialect_t *dialect, void *instance)
{
    ect_esi_words_t *words = words_of(dialect, instance);
    const bool sent = words->reset == RESET_SENT;
    words->reset = words->reset == RESET_WANTED ? RESET_SENT : RESET_NONE;
    return sent;
}
