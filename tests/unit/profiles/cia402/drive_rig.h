/* SPDX-License-Identifier: MIT */
/* A drive over entries of 32 bits with a sign, in cycles of 1 ms. */
#ifndef TESTS_UNIT_PROFILES_CIA402_DRIVE_RIG_H
#define TESTS_UNIT_PROFILES_CIA402_DRIVE_RIG_H

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "profiles/cia402/drive.h"

#define COUNT(array) (sizeof(array) / sizeof((array)[0]))
#define MS           1000000ull
enum { VALUES = ECT_402_VALUE_COUNT, STATE_MASK = 0x6F };

/* A drive whose entries are all there, 32 bits with a sign. */
typedef struct rig {
    ect_402_drive_t d;
    ect_402_surroundings_t around;
    ect_402_link_t links[VALUES];
    int32_t value[VALUES];
    ect_host_t host;
    uint64_t now_ns;
    unsigned int emergencies;
    uint16_t code;
    uint8_t error_register;
} rig_t;

static rig_t r;

static inline void emergency(void *ctx, uint16_t code, uint8_t error_register, const uint8_t data[5])
{
    rig_t *rig = ctx;
    (void)data;
    rig->emergencies++;
    rig->code = code;
    rig->error_register = error_register;
}

static inline void prepare(void)
{
    memset(&r, 0, sizeof r);
    r.host = (ect_host_t){.ctx = &r, .emergency = emergency};
    r.now_ns = 1000 * MS;
    for (unsigned int i = 0; i < VALUES; i++)
        r.links[i] = (ect_402_link_t){.offset = (uint32_t)(i * sizeof r.value[0]),
                                      .bytes = 4,
                                      .is_signed = true,
                                      .output = ect_402_object((ect_402_value_t)i)->kind == ECT_402_COMMAND};
}

static inline void power_on(void)
{
    ect_402_drive_init(&r.d, r.links, &r.around, r.value, &r.host, r.now_ns);
    ect_402_drive_enter_op(&r.d, r.now_ns);
}

static inline void cycle(unsigned int ms)
{
    for (unsigned int i = 0; i < ms; i++) {
        r.now_ns += MS;
        ect_402_drive_outputs(&r.d, r.now_ns);
        ect_402_drive_advance(&r.d, r.now_ns);
        ect_402_drive_publish(&r.d);
    }
}

static inline unsigned int state(void)
{
    return (unsigned int)r.value[ECT_402_V_STATUS] & STATE_MASK;
}

static inline void control(int32_t word)
{
    r.value[ECT_402_V_CONTROL] = word;
    cycle(2);
}

static inline void enable(void)
{
    r.value[ECT_402_V_MODE] = ECT_402_CSV;
    control(0x06);
    control(0x07);
    control(0x0F);
    assert_int_equal(state(), 0x27);
}

/* A drive in PREOP whose entries are all there; a turn has 2^20 increments. */
static inline void preop(void)
{
    prepare();
    ect_402_drive_init(&r.d, r.links, &r.around, r.value, &r.host, r.now_ns);
    ect_402_drive_below_op(&r.d, ECT_STATE_PREOP);
}

#endif
