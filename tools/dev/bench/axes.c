/* SPDX-License-Identifier: MIT */
/* Drives over their own memory: a millisecond consists of a frame with outputs and inputs, and four steps of each
 * plant. */
#define _GNU_SOURCE
#include "axes.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "profiles/cia402/drive.h"

enum { VALUES = ECT_402_VALUE_COUNT, MS_NS = 1000000, ENABLING_MS = 16, COUNTS_A_MS = 1000 };

typedef struct axis {
    ect_402_drive_t drive;
    ect_402_surroundings_t around;
    int32_t value[VALUES];
} axis_t;

static void emergency(void *ctx, uint16_t code, uint8_t error_register, const uint8_t data[5])
{
    (void)ctx;
    (void)code;
    (void)error_register;
    (void)data;
}

static void outputs(axis_t *a, int ms)
{
    static const int32_t words[] = {0x06, 0x07, 0x0F, 0x0F};
    a->value[ECT_402_V_MODE] = ECT_402_CSP;
    a->value[ECT_402_V_CONTROL] = words[ms < ENABLING_MS ? ms / 4 : 3];
    a->value[ECT_402_V_TARGET_POSITION] = ms < ENABLING_MS ? 0 : (ms - ENABLING_MS) * COUNTS_A_MS;
}

static void millisecond(axis_t *a, int ms, uint64_t now_ns)
{
    outputs(a, ms);
    ect_402_drive_advance(&a->drive, now_ns);
    ect_402_drive_outputs(&a->drive, now_ns);
    ect_402_drive_publish(&a->drive);
}

static double processor_ns(void)
{
    struct timespec t;
    (void)clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec * 1e9 + (double)t.tv_nsec;
}

int axes(char **argument)
{
    static const ect_host_t host = {.emergency = emergency};
    int count = (int)strtol(argument[0], NULL, 10);
    int duration = (int)strtol(argument[1], NULL, 10);
    axis_t *all = count > 0 && duration > 0 ? calloc((size_t)count, sizeof *all) : NULL;
    ect_402_link_t links[VALUES];
    uint64_t now_ns = MS_NS;
    if (all == NULL) {
        (void)fprintf(stderr, "ectwin-bench axes: AXES and MS are numbers from 1 on\n");
        return 2;
    }
    for (unsigned int i = 0; i < VALUES; i++)
        links[i] = (ect_402_link_t){.offset = i * (uint32_t)sizeof all->value[0],
                                    .bytes = sizeof all->value[0],
                                    .is_signed = true,
                                    .output = ect_402_object((ect_402_value_t)i)->kind == ECT_402_COMMAND};
    for (int n = 0; n < count; n++) {
        ect_402_drive_init(&all[n].drive, links, &all[n].around, all[n].value, &host, now_ns);
        ect_402_drive_enter_op(&all[n].drive, now_ns);
    }
    double before = 0;
    for (int ms = 0; ms < ENABLING_MS + duration; ms++) {
        if (ms == ENABLING_MS)
            before = processor_ns();
        now_ns += MS_NS;
        for (int n = 0; n < count; n++)
            millisecond(&all[n], ms, now_ns);
    }
    double ns = (processor_ns() - before) / duration / count;
    bool moves = all[0].value[ECT_402_V_POSITION] > 0 || duration < 10;
    (void)printf("{\"axis_ms_ns\": %.0f, \"axes_at_1_khz\": %.0f}\n", ns, (double)MS_NS / ns);
    free(all);
    return moves ? 0 : 1;
}
