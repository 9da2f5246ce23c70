/* SPDX-License-Identifier: MIT */
/* The readers of SII images with any bytes, any category, any string; facts about a device; a twin of the image; and a
 * chip that boots. */
#include <stdlib.h>
#include <string.h>

#include "esc/esc.h"
#include "esi/image.h"
#include "esi/twin.h"
#include "facts/facts.h"
#include "sii/sii.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void boot(const uint8_t *data, size_t size)
{
    static uint8_t memory[ECT_ESC_MEMORY_SIZE(8)];
    ect_esc_t esc;
    uint8_t *sii = malloc(size);
    if (!sii)
        return;
    memcpy(sii, data, size);
    const ect_esc_config_t config = {
        .personality = ect_esc_personality("et1100"), .memory = memory, .sii = sii, .sii_size = (uint32_t)size};
    (void)ect_esc_init(&esc, &config, 1);
    free(sii);
}

static void make_twin(const uint8_t *data, size_t size)
{
    char why[400];
    ect_esi_t *esi = ect_esi_of_image("input", data, size, why, sizeof why);
    ect_esi_twin_t *twin = ect_esi_twin_take(esi, "", NULL, 0, why, sizeof why);
    if (twin)
        (void)ect_esi_twin_behave(twin, ECT_BEHAVIOUR_BY_FILE, why, sizeof why);
    ect_esi_twin_free(twin);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    unsigned int sum = 0;
    for (uint16_t category = 0; category < 64; category++) {
        size_t length = 0;
        const uint8_t *found = ect_sii_category(data, size, category, &length);
        for (size_t i = 0; found && i < length; i++)
            sum += found[i];
    }
    for (unsigned int index = 0; index < 256; index++) {
        uint8_t length = 0;
        const char *text = ect_sii_string(data, size, (uint8_t)index, &length);
        for (unsigned int i = 0; text && i < length; i++)
            sum += (unsigned int)text[i];
    }
    ect_facts_t facts = {.source = "input"};
    ect_facts_of_sii(&facts, data, size);
    ect_facts_free(&facts);
    make_twin(data, size);
    if (size > 0)
        boot(data, size);
    return sum == 0xFFFFFFFF ? -1 : 0;
}
