/* SPDX-License-Identifier: MIT */
/* What a base unit does with its process data (TS-0007 §10). */
#include <string.h>

#include "devices/eclink/instance.h"
#include "wire/bytes.h"

enum { UPDATE_NS = 125000000 }; /* §10.3: new input data every 125 ms */

void eclink_init(void *instance, const ect_identity_t *identity, const ect_host_t *host, uint64_t now_ns)
{
    eclink_t *bu = instance;
    (void)host;
    bu->standard.identity = *identity;
    bu->update_ns = now_ns + UPDATE_NS;
}

void eclink_outputs(void *instance, uint64_t now_ns)
{
    eclink_t *bu = instance;
    (void)now_ns;
    bu->inputs[ECLINK_IN_CAI] = bu->outputs[ECLINK_OUT_CCO];
    bu->inputs[ECLINK_IN_PAI] = bu->outputs[ECLINK_OUT_PCO];
}

/* Late calls do not shift the rhythm, and do not make up for missed updates. */
uint64_t eclink_tick(void *instance, uint64_t now_ns)
{
    eclink_t *bu = instance;
    if (now_ns >= bu->update_ns) {
        bu->inputs[ECLINK_IN_PCI]++;
        bu->update_ns += UPDATE_NS;
        if (bu->update_ns <= now_ns)
            bu->update_ns = now_ns + UPDATE_NS;
    }
    return bu->update_ns;
}

/* Where the fields stand is what the entries of the object say. */
static void decode(uint8_t *numbers, const uint8_t *bytes, uintptr_t base, const ect_object_t *object)
{
    for (unsigned int i = 1; i <= object->max_subindex; i++) {
        const ect_entry_t *entry = &object->entries[i];
        size_t offset = (uintptr_t)entry->data - base;
        uint16_t number = ect_load_be16(bytes + offset);
        if (entry->bit_length == 16)
            memcpy(numbers + offset, &number, sizeof number);
        else
            memcpy(numbers + offset, bytes + offset, ect_od_bytes(entry));
    }
}

void eclink_sdo_read(void *instance, uint16_t index)
{
    eclink_t *bu = instance;
    const ect_device_t *device = bu->standard.device;
    const ect_od_t od = {.objects = device->objects, .count = device->object_count};
    if (index == 0x3001)
        decode(bu->input_numbers, bu->inputs, offsetof(eclink_t, input_numbers), ect_od_find(&od, index));
    else if (index == 0x3002)
        decode(bu->output_numbers, bu->outputs, offsetof(eclink_t, output_numbers), ect_od_find(&od, index));
}
