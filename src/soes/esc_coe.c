/* SPDX-License-Identifier: MIT */
/* The object list of an application, for SOES's API. */
#include "soes/esc_coe.h"

#include <string.h>

#include "seams/device.h"
#include "soes/internal.h"
#include "wire/bytes.h"

_SMmap SMmap2[MAX_MAPPINGS_SM2 > 0 ? MAX_MAPPINGS_SM2 : 1];
_SMmap SMmap3[MAX_MAPPINGS_SM3 > 0 ? MAX_MAPPINGS_SM3 : 1];

/* Marks "no object": the end of SOES's list is an element of the list, which may be in any memory. */
static ect_od_t dictionary(void)
{
    return ect_soes.slave.od;
}

static const ect_entry_t *as_entry(const _objd *entry)
{
    return (const ect_entry_t *)(const void *)entry;
}

int32_t SDO_findobject(uint16_t index)
{
    int32_t n = 0;
    while (SDOobjects[n].index < index)
        n++;
    return SDOobjects[n].index == index && index != 0xFFFF ? n : -1;
}

int16_t SDO_findsubindex(int32_t nidx, uint8_t subindex)
{
    const ect_object_t *object = (const ect_object_t *)(const void *)&SDOobjects[nidx];
    const ect_entry_t *entry = ect_od_entry(object, subindex);
    return entry ? (int16_t)(entry - object->entries) : -1;
}

static uint32_t number(uint16_t index, uint8_t subindex)
{
    ect_od_t od = dictionary();
    uint32_t value = 0;
    (void)ect_od_number(&od, index, subindex, &value);
    return value;
}

uint8_t COE_maxSub(uint16_t index)
{
    return (uint8_t)number(index, 0);
}

/* --- process data ------------------------------------------------------------------------------------------------- */

/* Finds the entry of a mapping value, or a gap. @return false: no such entry, or it is longer than its mapping */
static bool resolve(uint32_t mapping, _SMmap *to)
{
    int32_t object = SDO_findobject((uint16_t)(mapping >> 16));
    int16_t entry = object >= 0 ? SDO_findsubindex(object, (uint8_t)(mapping >> 8)) : (int16_t)-1;
    to->obj = entry >= 0 ? &SDOobjects[object].objdesc[entry] : NULL;
    to->objectlistitem = entry >= 0 ? &SDOobjects[object] : NULL;
    return to->obj ? to->obj->bitlength <= (mapping & 0xFF) : mapping >> 8 == 0;
}

/* Adds a PDO's entries. @return false: too many entries, or an entry that does not exist */
static bool add_pdo(uint16_t pdo, _SMmap *sm, int max_mappings, int *count, uint32_t *bits)
{
    uint8_t entries = COE_maxSub(pdo);
    for (uint8_t n = 1; n <= entries && n != 0; n++) {
        uint32_t mapping = number(pdo, n);
        if (max_mappings > 0) {
            if (*count == max_mappings || !resolve(mapping, &sm[*count]))
                return false;
            sm[(*count)++].offset = *bits;
        }
        *bits += mapping & 0xFF;
    }
    return true;
}

uint16_t sizeOfPDO(uint16_t index, int *nmappings, _SMmap *sm, int max_mappings)
{
    uint32_t bits = 0;
    int count = 0;
    *nmappings = 0;
    if (index != RX_PDO_OBJIDX && index != TX_PDO_OBJIDX)
        return 0;
    uint8_t pdos = COE_maxSub(index);
    for (uint8_t n = 1; n <= pdos && n != 0; n++) {
        if (!add_pdo((uint16_t)number(index, n), sm, max_mappings, &count, &bits)) {
            *nmappings = -1;
            return 0;
        }
    }
    *nmappings = count;
    return (uint16_t)((bits + 7) / 8);
}

enum { WIRE = 32 /* a mapped entry has at most 255 bits */ };

static uint16_t mapped_bytes(const _objd *entry)
{
    return MIN(ect_od_bytes(as_entry(entry)), WIRE);
}

void COE_pdoPack(uint8_t *buffer, int nmappings, _SMmap *sm)
{
    ect_od_t od = dictionary();
    for (int n = 0; n < nmappings; n++) {
        uint8_t wire[WIRE];
        if (!sm[n].obj)
            continue;
        uint16_t bytes = mapped_bytes(sm[n].obj);
        ect_od_read(&od, as_entry(sm[n].obj), 0, wire, bytes);
        ect_copy_bits(buffer, sm[n].offset, wire, 0, MIN(sm[n].obj->bitlength, 8u * bytes));
    }
}

void COE_pdoUnpack(uint8_t *buffer, int nmappings, _SMmap *sm)
{
    ect_od_t od = dictionary();
    for (int n = 0; n < nmappings; n++) {
        uint8_t wire[WIRE] = {0};
        if (!sm[n].obj)
            continue;
        uint16_t bytes = mapped_bytes(sm[n].obj);
        ect_copy_bits(wire, 0, buffer, sm[n].offset, MIN(sm[n].obj->bitlength, 8u * bytes));
        (void)ect_od_write(&od, as_entry(sm[n].obj), 0, wire, bytes);
    }
}

/* --- defaults, hooks ---------------------------------------------------------------------------------------------- */

static void set_default(const ect_od_t *od, const ect_entry_t *entry)
{
    uint16_t bytes = ect_od_bytes(entry);
    uint8_t wire[8];
    bool is_number = entry->data_type != ECT_TYPE_VISIBLE_STRING && entry->data_type != ECT_TYPE_OCTET_STRING &&
                     entry->data_type != DTYPE_UNICODE_STRING && entry->data_type < DTYPE_ARRAY_OF_INT;
    if (!entry->data || !is_number || bytes > sizeof wire || bytes == 0)
        return;
    ect_store_le64(wire, entry->value);
    (void)ect_od_write(od, entry, 0, wire, bytes);
}

void COE_initDefaultValues(void)
{
    ect_od_t od = dictionary();
    if (ESCvar.skip_default_initialization)
        return;
    for (uint16_t i = 0; i < od.count; i++) {
        const ect_object_t *object = &od.objects[i];
        for (const ect_entry_t *entry = object->entries; entry; entry = ect_od_next(object, entry))
            set_default(&od, entry);
    }
    if (ESCvar.set_defaults_hook)
        ESCvar.set_defaults_hook();
}

/* While mapping and assignment count elements, these must not change (ETG.1000.6 §5.6.7.4). */
static bool is_fixed_now(uint16_t index, uint8_t subindex, uint16_t flags)
{
    bool config = (index >= 0x1600 && index < 0x1800) || (index >= 0x1A00 && index < 0x1C00) ||
                  index == RX_PDO_OBJIDX || index == TX_PDO_OBJIDX;
    return config && subindex > 0 && (flags & COMPLETE_ACCESS_FLAG) == 0 && COE_maxSub(index) != 0;
}

uint32_t ESC_download_pre_objecthandler(uint16_t index, uint8_t subindex, void *data, size_t size, uint16_t flags)
{
    if (is_fixed_now(index, subindex, flags))
        return ABORT_SUBINDEX0_NOT_ZERO;
    return ESCvar.pre_object_download_hook ? ESCvar.pre_object_download_hook(index, subindex, data, size, flags) : 0;
}

uint32_t ESC_download_post_objecthandler(uint16_t index, uint8_t subindex, uint16_t flags)
{
    return ESCvar.post_object_download_hook ? ESCvar.post_object_download_hook(index, subindex, flags) : 0;
}

uint32_t ESC_upload_pre_objecthandler(uint16_t index, uint8_t subindex, void *data, size_t *size, uint16_t flags)
{
    return ESCvar.pre_object_upload_hook ? ESCvar.pre_object_upload_hook(index, subindex, data, size, flags) : 0;
}

uint32_t ESC_upload_post_objecthandler(uint16_t index, uint8_t subindex, uint16_t flags)
{
    return ESCvar.post_object_upload_hook ? ESCvar.post_object_upload_hook(index, subindex, flags) : 0;
}
