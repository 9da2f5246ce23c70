/* SPDX-License-Identifier: MIT */
/*
 * The first thing that runs on a board with two slots: an image that came over FoE and is whole goes to where it runs
 * from, unless it exists already; then the firmware begins.
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
