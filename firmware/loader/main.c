/* SPDX-License-Identifier: MIT */
/*
 * The loader of a board with two slots: copies a complete image received by FoE to the address that it runs from,
 * unless it is already there, and starts the firmware.
 */
#include <string.h>

#include "cpu.h"
#include "update.h"

int main(void)
{
    const update_slots_t *slots = board_slots();
    uint32_t length = update_image(slots);
    const uint8_t *image = slots->second + UPDATE_HEADER;
    void *run = (void *)(uintptr_t)slots->run;
    if (length > 0 && memcmp(run, image, length) != 0)
        memcpy(run, image, length); /* this board's flash is written like memory */
    cpu_run(slots->run);
}
