/* SPDX-License-Identifier: MIT */
#include "esc/personality.h"

#include <stddef.h>
#include <string.h>

/* The distributed clocks of the real NP40 and LAN9252 are left out: their feature bits say so. */
static const ect_esc_personality_t personalities[] = {
    {.name = "np40",
     .type = 0x05,
     .revision = 0x00,
     .build = 0x0001,
     .fmmu_count = 4,
     .sm_count = 4,
     .ram_kb = 16,
     .port_types = 0x0F,
     .features = 0x0000,
     .sii_read = 8,
     .sii_read_ns = 0,
     .sii_write_ns = 0},
    {.name = "et1100",
     .type = 0x11,
     .revision = 0x00,
     .build = 0x0003,
     .fmmu_count = 8,
     .sm_count = 8,
     .ram_kb = 8,
     .port_types = 0x0F,
     .features = ECT_FEATURE_DC | ECT_FEATURE_DC64,
     .sii_read = 8,
     .sii_read_ns = 0,
     .sii_write_ns = 0},
    {.name = "lan9252",
     .type = 0xC0,
     .revision = 0x02,
     .build = 0x0000,
     .fmmu_count = 3,
     .sm_count = 4,
     .ram_kb = 4,
     .port_types = 0x0F,
     .features = 0x0000,
     .sii_read = 4,
     .sii_read_ns = 0,
     .sii_write_ns = 0},
    {.name = "ipcore",
     .type = 0x04,
     .revision = 0x02,
     .build = 0x0043,
     .fmmu_count = 8,
     .sm_count = 8,
     .ram_kb = 60,
     .port_types = 0x0F,
     .features = ECT_FEATURE_DC | ECT_FEATURE_DC64,
     .sii_read = 8,
     .sii_read_ns = 0,
     .sii_write_ns = 0},
};

const ect_esc_personality_t *ect_esc_personality(const char *name)
{
    for (size_t i = 0; i < sizeof personalities / sizeof personalities[0]; i++) {
        if (strcmp(personalities[i].name, name) == 0)
            return &personalities[i];
    }
    return NULL;
}

const ect_esc_personality_t *ect_esc_personality_at(size_t i)
{
    return i < sizeof personalities / sizeof personalities[0] ? &personalities[i] : NULL;
}
