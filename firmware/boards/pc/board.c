/* SPDX-License-Identifier: MIT */
/* A PC as the board: the software ESC of ports/soes_hal, at the interface that -i names. */
#define _POSIX_C_SOURCE 200809L
#include "board.h"

#include <stdlib.h>
#include <time.h>
#include <unistd.h>

static char **arguments;

void board_init(int argc, char **argv)
{
    (void)argc;
    arguments = argv;
}

uint64_t board_now_ns(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
}

const ect_pdi_t *board_pdi(void)
{
    return NULL;
}

void board_turn(uint64_t until_ns)
{
    (void)until_ns; /* the software ESC waits where it is read */
}

void board_reset(void)
{
    execv("/proc/self/exe", arguments);
    abort();
}

const ect_storage_t *board_storage(void)
{
    return NULL;
}

uint16_t board_switches(void)
{
    return 0;
}

uint32_t board_serial(void)
{
    return 0;
}

const ect_leds_t *board_leds(void)
{
    static const ect_leds_t none;
    return &none;
}
