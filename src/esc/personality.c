/* SPDX-License-Identifier: MIT */
#include "esc/personality.h"

#include <stddef.h>
#include <string.h>

enum {
    DC = ECT_FEATURE_DC | ECT_FEATURE_DC64,
    BECKHOFF = DC | ECT_FEATURE_EBUS | ECT_FEATURE_LINK_MII | ECT_FEATURE_FCS,
    IP_CORE = DC | ECT_FEATURE_LINK_MII | ECT_FEATURE_FCS | ECT_FEATURE_SYNC,
    TWO_MII = 0x0F,
};

/* Units of all chips, and units of the IP core and of chips derived from it. */
enum {
    ALL = ECT_UNIT_PROTECTION | ECT_UNIT_RESET_ECAT | ECT_UNIT_SM_TIMES,
    NEWER =
        ALL | ECT_UNIT_RESET_PDI | ECT_UNIT_LED_RUN | ECT_UNIT_LED_ERR | ECT_UNIT_PDI_INFORMATION | ECT_UNIT_LATCH_PIN,
};

static const ect_esc_personality_t personalities[] = {
    {.name = "np40",
     .type = 0x05,
     .revision = 0x00,
     .build = 0x0001,
     .fmmu_count = 4,
     .sm_count = 4,
     .ram_kb = 16,
     .port_types = TWO_MII,
     .ports = 0x3,
     .features = IP_CORE,
     .units = NEWER,
     .sii_read = 8,
     .processing_ns = 340,
     .forwarding_ns = 300},
    {.name = "et1100",
     .type = 0x11,
     .revision = 0x00,
     .build = 0x0003,
     .fmmu_count = 8,
     .sm_count = 8,
     .ram_kb = 8,
     .port_types = TWO_MII,
     .ports = 0xF,
     .features = BECKHOFF,
     .units = ALL,
     .sii_read = 8,
     .processing_ns = 320,
     .forwarding_ns = 300},
    {.name = "et1200",
     .type = 0x12,
     .revision = 0x01,
     .build = 0x0001,
     .fmmu_count = 3,
     .sm_count = 4,
     .ram_kb = 1,
     .port_types = TWO_MII,
     .ports = 0xB,
     .features = BECKHOFF | ECT_FEATURE_SYNC, /* as reported by terminals with this chip, contrary to the data sheet */
     .units = ALL | ECT_UNIT_LATCH_MODE,
     .sii_read = 8,
     .processing_ns = 320,
     .forwarding_ns = 300},
    {.name = "lan9252",
     .type = 0xC0,
     .revision = 0x02,
     .build = 0x0000,
     .fmmu_count = 3,
     .sm_count = 4,
     .ram_kb = 4,
     .port_types = TWO_MII | 0x10, /* port 2 exists and is not configured */
     .ports = 0x7,
     .features = IP_CORE,
     .units = NEWER,
     .sii_read = 4,
     .processing_ns = 340,
     .forwarding_ns = 300},
    {.name = "lan9253",
     .type = 0xC0,
     .revision = 0x03,
     .build = 0x0000,
     .fmmu_count = 8,
     .sm_count = 8,
     .ram_kb = 8,
     .port_types = TWO_MII | 0x10,
     .ports = 0x7,
     .features = IP_CORE,
     .units = NEWER,
     .sii_read = 8,
     .processing_ns = 340,
     .forwarding_ns = 300},
    {.name = "xmc4800",
     .type = 0x98,
     .revision = 0x01,
     .build = 0x0000,
     .fmmu_count = 8,
     .sm_count = 8,
     .ram_kb = 8,
     .port_types = TWO_MII,
     .ports = 0x3,
     .features = IP_CORE,
     .units = NEWER | ECT_UNIT_SII_EMULATION,
     .sii_read = 4,
     .processing_ns = 340,
     .forwarding_ns = 300},
    {.name = "ax58100",
     .type = 0xC8,
     .revision = 0x00,
     .build = 0x0000,
     .fmmu_count = 8,
     .sm_count = 8,
     .ram_kb = 9,
     .port_types = TWO_MII | 0x10,
     .ports = 0x7,
     .features = IP_CORE,
     .units = NEWER,
     .sii_read = 8,
     .processing_ns = 340,
     .forwarding_ns = 300},
    {.name = "ipcore",
     .type = 0x04,
     .revision = 0x04,
     .build = 0x0000,
     .fmmu_count = 8,
     .sm_count = 8,
     .ram_kb = 60,
     .port_types = TWO_MII,
     .ports = 0x7,
     .features = IP_CORE | ECT_FEATURE_SEQUENTIAL,
     .units = NEWER | ECT_UNIT_SII_EMULATION,
     .sii_read = 8,
     .processing_ns = 340,
     .forwarding_ns = 300},
    {.name = "ipcore-small",
     .type = 0x04,
     .revision = 0x02,
     .build = 0x0043,
     .fmmu_count = 3,
     .sm_count = 4,
     .ram_kb = 4,
     .port_types = TWO_MII,
     .ports = 0x3,
     .features = ECT_FEATURE_FCS | ECT_FEATURE_SYNC,
     .units = NEWER | ECT_UNIT_SII_EMULATION,
     .sii_read = 4,
     .processing_ns = 340,
     .forwarding_ns = 300},
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
