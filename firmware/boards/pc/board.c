/* SPDX-License-Identifier: MIT */
/* A PC as the board: the software ESC of ports/soes_hal, at the interface of -i; --store DIR: its non-volatile memory.
 */
#define _POSIX_C_SOURCE 200809L
#include "board.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "bus/storage/memory.h"

static char **arguments;
static ect_memory_t *memory;

/* NULL: memory that ends with the process. */
static void open_memory(const char *folder)
{
    char path[ECT_MEMORY_PATH], message[ECT_MEMORY_MESSAGE];
    if (folder && (*folder == 0 || snprintf(path, sizeof path, "%s/firmware", folder) >= (int)sizeof path)) {
        fprintf(stderr, "%s: --store: the name of the folder is missing or too long\n", arguments[0]);
        exit(1);
    }
    memory = ect_memory_open(folder ? path : NULL, message);
    if (message[0] != 0)
        fprintf(stderr, "%s: %s\n", arguments[0], message);
    if (!memory)
        exit(2);
}

void board_init(int argc, char **argv)
{
    const char *folder = NULL;
    arguments = argv;
    for (int n = 1; n < argc; n++) {
        if (strcmp(argv[n], "--store") == 0)
            folder = n + 1 < argc ? argv[n + 1] : "";
        else if (strncmp(argv[n], "--store=", 8) == 0)
            folder = argv[n] + 8;
    }
    open_memory(folder);
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
    (void)until_ns; /* the software ESC waits in its reads */
}

void board_reset(void)
{
    execv("/proc/self/exe", arguments);
    abort();
}

const ect_storage_t *board_storage(void)
{
    return ect_memory_storage(memory);
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
