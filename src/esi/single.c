/* SPDX-License-Identifier: MIT */
/* A model without an ESI file, as a file with one device. */
#include "esi/single.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "esi/internal.h"

/* PDOs made for a SyncManager without PDOs, and the mapped objects. */
enum {
    FIRST_RXPDO = 0x1600,
    FIRST_TXPDO = 0x1A00,
    BYTES_OF_OUTPUTS = 0x7000,
    BYTES_OF_INPUTS = 0x6000,
    ENTRIES_MOST = 254,
    BYTE_BITS = 8
};

ect_esi_pdo_t *ect_esi_append_pdo(ect_arena_t *arena, ect_esi_device_t *device)
{
    ect_esi_pdo_t *pdos = (ect_esi_pdo_t *)(uintptr_t)device->pdos; /* ours, growing */
    pdos = ect_arena_grow(arena, pdos, device->pdo_count, sizeof *pdos);
    device->pdos = pdos;
    return &pdos[device->pdo_count++];
}

/* Adds a PDO for bytes `first` to `end` - 1 of a SyncManager. */
static void add_bytes(ect_esi_t *esi, const char *source, int n, bool tx, uint16_t number, size_t first, size_t end)
{
    size_t count = end - first;
    ect_esi_entry_t *entries = ect_arena_alloc(&esi->arena, count * sizeof *entries);
    ECT_ASSERT(count > 0 && count <= ENTRIES_MOST);
    for (size_t i = 0; i < count; i++)
        entries[i] = (ect_esi_entry_t){
            .index = (uint16_t)((tx ? BYTES_OF_INPUTS : BYTES_OF_OUTPUTS) + number),
            .subindex = (uint8_t)(i + 1),
            .bits = BYTE_BITS,
            .name = ect_arena_print(&esi->arena, "Byte %zu", first + i),
            .type = "USINT",
        };
    *ect_esi_append_pdo(&esi->arena, esi->device) = (ect_esi_pdo_t){
        .index = (uint16_t)((tx ? FIRST_TXPDO : FIRST_RXPDO) + number),
        .name = ect_arena_print(&esi->arena, "SyncManager %d, which no PDO of the %s describes", n, source),
        .tx = tx,
        .fixed = true,
        .sm = n,
        .samples = 1,
        .entries = entries,
        .entry_count = count,
    };
}

static void describe_bytes(ect_esi_t *esi, const char *source, int n)
{
    const ect_esi_sm_t *sm = &esi->device->sms[n];
    bool tx = strcmp(sm->type, "Inputs") == 0;
    if ((!tx && strcmp(sm->type, "Outputs") != 0) || sm->virtual_sm)
        return;
    size_t length = (size_t)sm->size.value;
    uint16_t number = 0;
    for (size_t i = 0; i < esi->device->pdo_count; i++) {
        if (esi->device->pdos[i].tx == tx)
            return;
    }
    for (size_t at = 0; at < length; at += ENTRIES_MOST)
        add_bytes(esi, source, n, tx, number++, at, at + ENTRIES_MOST < length ? at + ENTRIES_MOST : length);
}

ect_esi_t *ect_esi_single_begin(const char *name, char *text, size_t room)
{
    ect_esi_t *esi = calloc(1, sizeof *esi);
    if (esi == NULL) {
        (void)snprintf(text, room, "%s: no memory left", name);
        return NULL;
    }
    ect_esi_device_t *device = ect_arena_alloc(&esi->arena, sizeof *device);
    device->vendor_name = device->type = device->name = device->group_type = device->group_name = "";
    device->physics = device->dictionary_file = "";
    device->esi = esi;
    esi->file = ect_arena_copy(&esi->arena, name, strlen(name));
    esi->device = device;
    return esi;
}

ect_esi_device_t *ect_esi_single_device(ect_esi_t *esi, ect_arena_t **arena)
{
    ECT_ASSERT(esi->device != NULL);
    *arena = &esi->arena;
    return esi->device;
}

void ect_esi_single_end(ect_esi_t *esi, const char *source)
{
    ect_esi_device_t *device = esi->device;
    for (int i = 0; i < (int)device->sm_count; i++)
        describe_bytes(esi, source, i);
    if (*device->type == '\0')
        device->type = ect_arena_print(&esi->arena, "0x%08" PRIX32, device->product_code);
    esi->heads = ect_arena_alloc(&esi->arena, sizeof *esi->heads);
    esi->nodes = ect_arena_alloc(&esi->arena, sizeof *esi->nodes);
    esi->count = 1;
    *esi->heads = (ect_esi_head_t){.type = device->type,
                                   .name = device->name,
                                   .product_code = device->product_code,
                                   .revision = device->revision,
                                   .extras = ""};
}
