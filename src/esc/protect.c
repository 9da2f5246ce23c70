/* SPDX-License-Identifier: MIT */
/*
 * Protection against accidental writes of a master, and the sequences that reset the chip (data sheet II §2.3).
 * Protection applies to the master's writes only: the microcontroller is part of the device.
 */
#include "esc/internal.h"

enum { STEPS = 3 };

static bool on(const ect_esc_t *esc, uint16_t address)
{
    return (esc->memory[address] & 0x01) != 0;
}

static bool locked(const ect_esc_t *esc, uint16_t protection, uint16_t enable)
{
    return on(esc, protection) && !on(esc, enable);
}

static bool all_locked(const ect_esc_t *esc)
{
    return locked(esc, ECT_REG_ESC_WRITE_PROTECTION, ECT_REG_ESC_WRITE_ENABLE);
}

uint32_t ect_esc_first_writable(const ect_esc_t *esc)
{
    if (all_locked(esc))
        return UINT32_MAX;
    return locked(esc, ECT_REG_WRITE_PROTECTION, ECT_REG_WRITE_ENABLE) ? ECT_REG_USER_RAM : 0;
}

/* The next frame ends it, even if it does not address this slave. */
static void await_frame(ect_esc_t *esc)
{
    esc->per_frame |= ECT_FRAME_BEGINS;
    esc->routing++;
}

/* Any value enables writes for this frame. Without protection there is nothing to enable. */
static bool enable(ect_esc_t *esc, uint16_t enable_register, uint16_t protection)
{
    esc->memory[enable_register] = on(esc, protection) ? 1 : 0;
    await_frame(esc);
    return true;
}

bool ect_esc_unlock(ect_esc_t *esc, uint16_t address, uint16_t length)
{
    uint32_t end = (uint32_t)address + length;
    bool any = false;
    if (ect_esc_within(address, end, ECT_REG_ESC_WRITE_ENABLE))
        any = enable(esc, ECT_REG_ESC_WRITE_ENABLE, ECT_REG_ESC_WRITE_PROTECTION);
    if (!all_locked(esc) && ect_esc_within(address, end, ECT_REG_WRITE_ENABLE))
        any = enable(esc, ECT_REG_WRITE_ENABLE, ECT_REG_WRITE_PROTECTION);
    return any;
}

bool ect_esc_protect_write(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    (void)ect_esc_unlock(esc, address, length);
    esc->routing++;
    for (uint16_t i = 0; i < length; i++) {
        uint16_t at = (uint16_t)(address + i);
        if (at == ECT_REG_WRITE_PROTECTION || at == ECT_REG_ESC_WRITE_PROTECTION)
            esc->memory[at] = access->data[i] & 0x01;
    }
    return true;
}

/* The right byte advances the sequence; any other byte restarts or cancels it. */
bool ect_esc_reset_write(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    static const uint8_t sequence[STEPS] = {'R', 'E', 'S'};
    ect_side_t side = access->side;
    uint8_t value = access->data[0];
    uint8_t *step = &esc->reset_step[side];
    (void)length;
    ECT_ASSERT(*step < STEPS);
    if (value == sequence[*step])
        (*step)++;
    else
        *step = value == sequence[0] ? 1 : 0;
    esc->memory[address] = *step;
    esc->reset_moved[side] = true;
    await_frame(esc);
    return true;
}

static void forget_sequence(ect_esc_t *esc, ect_side_t side)
{
    if (!esc->reset_moved[side])
        esc->memory[side == ECT_SIDE_ECAT ? ECT_REG_RESET_ECAT : ECT_REG_RESET_PDI] = esc->reset_step[side] = 0;
    esc->reset_moved[side] = false;
}

/* The next step must come in the very next frame, so every frame matters while a sequence is under way. */
void ect_esc_protect_begins(ect_esc_t *esc, ect_side_t side)
{
    forget_sequence(esc, side);
    if (side != ECT_SIDE_ECAT)
        return;
    esc->memory[ECT_REG_WRITE_ENABLE] = esc->memory[ECT_REG_ESC_WRITE_ENABLE] = 0;
    if (esc->reset_step[ECT_SIDE_ECAT] == 0)
        esc->per_frame &= (uint8_t)~ECT_FRAME_BEGINS;
    esc->routing++;
}

bool ect_esc_reset_due(const ect_esc_t *esc)
{
    return esc->reset_step[ECT_SIDE_ECAT] == STEPS || esc->reset_step[ECT_SIDE_PDI] == STEPS;
}
