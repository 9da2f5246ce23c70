/* SPDX-License-Identifier: MIT */
/* The chip's own control of the RUN and ERR LEDs, and its override by a register (data sheet II §2.5.4, §2.5.5). */
#include "esc/internal.h"

enum { STATE_PREOP = 2, STATE_BOOT = 3, STATE_SAFEOP = 4, STATE_OP = 8 };

enum { OFF = 0, SINGLE_FLASH = 0x1, BLINKING = 0xD, FLICKERING = 0xE, ON = 0xF, CODE = 0x0F, OVERRIDE = 0x10 };

/* Codes of the ERR LED that the chip sets by itself. */
enum { LOCAL_ERROR = 0x1, WATCHDOG = 0x2, NO_CONFIGURATION = 0xE, PDI_DEAD = 0xF };

static uint8_t state_of(const ect_esc_t *esc)
{
    return esc->memory[ECT_REG_AL_STATUS] & ECT_AL_STATE_MASK;
}

static uint8_t run_code(const ect_esc_t *esc)
{
    switch (state_of(esc)) {
    case STATE_PREOP:
        return BLINKING;
    case STATE_BOOT:
        return FLICKERING;
    case STATE_SAFEOP:
        return SINGLE_FLASH;
    case STATE_OP:
        return ON;
    default:
        return OFF;
    }
}

/* The most severe first. A watchdog counts in OP only, because before OP nothing needs to trigger it. */
static uint8_t err_code(const ect_esc_t *esc)
{
    if (esc->pdi_late)
        return PDI_DEAD;
    if (!esc->sii_valid)
        return NO_CONFIGURATION;
    if (state_of(esc) == STATE_OP && esc->watchdog_ns == UINT64_MAX && esc->memory[ECT_REG_WD_COUNTER_PD] != 0 &&
        (esc->memory[ECT_REG_WD_STATUS_PD] & 1) == 0)
        return WATCHDOG;
    bool error = (esc->memory[ECT_REG_AL_STATUS] & ECT_AL_ERROR) != 0;
    return error && !ect_esc_emulates(esc) ? LOCAL_ERROR : OFF;
}

void ect_esc_led_state(ect_esc_t *esc)
{
    if (ect_esc_has(esc, ECT_UNIT_LED_RUN))
        esc->memory[ECT_REG_LED_RUN] = run_code(esc);
    ect_esc_led_errors(esc);
}

void ect_esc_led_errors(ect_esc_t *esc)
{
    uint8_t *led = esc->memory + ECT_REG_LED_ERR;
    if (!ect_esc_has(esc, ECT_UNIT_LED_ERR))
        return;
    uint8_t code = err_code(esc);
    bool fires = code != OFF && code != esc->err_code;
    esc->err_code = code;
    if (fires || (*led & OVERRIDE) == 0)
        *led = code;
}

void ect_esc_led_write(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    for (uint16_t i = 0; i < length; i++) {
        uint16_t at = (uint16_t)(address + i);
        ECT_ASSERT(at == ECT_REG_LED_RUN || at == ECT_REG_LED_ERR);
        uint8_t value = access->data[i];
        uint8_t own = at == ECT_REG_LED_RUN ? run_code(esc) : esc->err_code;
        esc->memory[at] = (value & OVERRIDE) != 0 ? value & (OVERRIDE | CODE) : own;
    }
}
