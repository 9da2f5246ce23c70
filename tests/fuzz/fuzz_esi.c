/* SPDX-License-Identifier: MIT */
/*
 * ESI files with anything in them. Each device of a file becomes a twin or is refused with a line; one that is taken is
 * powered on, its EEPROM is written and every entry of its dictionary read.
 */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

#include "bus/chain/chain.h"
#include "esi/twin.h"
#include "sii/sii.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { DEVICES_MOST = 4, MESSAGE = 300 };

static void read_all(const ect_od_t *od)
{
    for (uint16_t i = 0; i < od->count; i++) {
        for (const ect_entry_t *e = od->objects[i].entries; e != NULL; e = ect_od_next(&od->objects[i], e)) {
            uint8_t *bytes = malloc(ect_od_bytes(e) + 1u);
            if (bytes != NULL)
                ect_od_read(od, e, 0, bytes, ect_od_upload_size(od, e));
            free(bytes);
        }
    }
}

static void run(const ect_product_t *product)
{
    ect_twin_config_t config = ect_twin_default(product->device, product->plant);
    uint8_t *image = malloc(product->device->sii_size);
    if (image == NULL || ect_sii_write(product->device, NULL, 0, image, product->device->sii_size) < 0)
        abort(); /* it was written once when the twin was made */
    free(image);
    ect_chain_t *chain = ect_chain_new(&config, 1, 1);
    if (chain == NULL)
        return;
    (void)ect_chain_poll(chain, 2);
    read_all(&ect_chain_slave(chain, 0)->od);
    ect_chain_free(chain);
}

static void try_device(ect_esi_t *esi, const ect_esi_head_t *head)
{
    char text[MESSAGE] = "";
    char selector[32];
    (void)snprintf(selector, sizeof selector, "@%" PRIu32 "/%" PRIu32, head->product_code, head->revision);
    const ect_esi_device_t *model = ect_esi_select(esi, selector, text, sizeof text);
    ect_esi_twin_t *twin = model != NULL ? ect_esi_twin_of(esi, model, NULL, 0, text, sizeof text) : NULL;
    if (twin != NULL && !ect_esi_twin_behave(twin, ECT_BEHAVIOUR_BY_FILE, text, sizeof text))
        abort(); /* a shell at least */
    if (twin != NULL)
        run(ect_esi_twin_product(twin));
    else if (text[0] == '\0')
        abort(); /* refused without a word */
    ect_esi_twin_free(twin);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char text[MESSAGE];
    size_t count = 0;
    ect_esi_t *esi = ect_esi_parse("input", data, size, text, sizeof text);
    const ect_esi_head_t *heads = esi != NULL ? ect_esi_heads(esi, &count) : NULL;
    for (size_t i = 0; i < count && i < DEVICES_MOST; i++)
        try_device(esi, &heads[i]);
    ect_esi_close(esi);
    return 0;
}
