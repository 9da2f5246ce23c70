/* SPDX-License-Identifier: MIT */
/*
 * Two slots in memory, because this board has no flash: the second one outlasts a reset, not a power-off. It is in the
 * PSRAM, the first one after the loader. QEMU loads the images of its command line again at each reset, and the loader
 * then the update.
 */
#include <string.h>

#include "update.h"

enum { RUN = 0x00004000, SECOND = 0x21000000, SIZE = 0x00400000 };

static uint8_t *second(void)
{
    return (uint8_t *)(uintptr_t)SECOND;
}

static bool erase(void)
{
    memset(second(), 0xFF, UPDATE_HEADER);
    return true;
}

static bool write(uint32_t offset, const void *data, uint32_t length)
{
    memcpy(second() + offset, data, length);
    return true;
}

const update_slots_t *board_slots(void)
{
    static const update_slots_t slots = {
        .run = RUN, .second = (const uint8_t *)SECOND, .size = SIZE, .erase = erase, .write = write};
    return &slots;
}
