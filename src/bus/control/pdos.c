/* SPDX-License-Identifier: MIT */
#include "bus/control/pdos.h"

#include "bus/control/objects.h"

/* Bits of a place. */
enum { SM = 16, PDO = 8, PART = 0xFF };

/* An entry of a PDO. */
typedef struct mapped {
    unsigned int sm;
    uint32_t pdo, mapping;
} mapped_t;

const char *ect_pdos_place(const cJSON *request, uint32_t *place)
{
    return ect_object_number(request, "place", 0xFFFFFF, place) ? NULL : "\"place\" is that of a line, plus 1";
}

/* @return a number in an assignment or mapping; 0: none */
static uint32_t number_at(const ect_od_t *od, uint32_t index, uint32_t subindex)
{
    uint32_t value = 0;
    (void)ect_od_number(od, (uint16_t)index, (uint8_t)subindex, &value);
    return value;
}

static bool has_pdos(const ect_slave_t *slave, unsigned int sm)
{
    return ect_device_sm_is_process(slave->config.device, sm) &&
           ect_od_find(ect_slave_dictionary(slave), (uint16_t)(ECT_OD_ASSIGNMENT + sm)) != NULL;
}

/* Finds the entry at a place, or advances the place by a PDO or a SyncManager. @return whether an entry was found */
static bool find(const ect_slave_t *slave, uint32_t *place, mapped_t *mapped)
{
    const ect_od_t *od = ect_slave_dictionary(slave);
    const unsigned int sm = *place >> SM;
    const uint32_t pdo = (*place >> PDO & PART) + ((*place >> PDO & PART) == 0);
    const uint32_t entry = (*place & PART) + ((*place & PART) == 0);
    if (!has_pdos(slave, sm) || pdo > number_at(od, ECT_OD_ASSIGNMENT + sm, 0)) {
        *place = (sm + 1u) << SM;
        return false;
    }
    const uint32_t index = number_at(od, ECT_OD_ASSIGNMENT + sm, pdo);
    if (entry > number_at(od, index, 0)) {
        *place = (sm << SM) + (pdo << PDO) + (1u << PDO);
        return false;
    }
    *mapped = (mapped_t){.sm = sm, .pdo = index, .mapping = number_at(od, index, entry)};
    *place = sm << SM | pdo << PDO | entry;
    return true;
}

static void put_name(ect_line_t *line, const char *key, const char *name)
{
    if (name)
        ect_line_string(line, key, name);
}

/* Writes the value in the memory of the device. */
static void put_entry(ect_line_t *line, const ect_od_t *od, const ect_object_t *object, const ect_entry_t *entry)
{
    uint8_t bytes[ECT_OBJECT_BYTES + 1] = {0};
    const uint16_t size = ect_od_bytes(entry);
    const uint16_t shown = size < ECT_OBJECT_BYTES ? size : (uint16_t)ECT_OBJECT_BYTES;
    ect_od_read(od, entry, 0, bytes, shown);
    put_name(line, "object", object->name);
    put_name(line, "name", entry->name);
    ect_line_string(line, "type", ect_object_type(entry->data_type));
    ect_object_put_value(line, entry->data_type, bytes, shown);
}

static void put_mapped(ect_line_t *line, const ect_slave_t *slave, const mapped_t *mapped)
{
    const ect_od_t *od = ect_slave_dictionary(slave);
    const ect_object_t *pdo = ect_od_find(od, (uint16_t)mapped->pdo), *object;
    const ect_entry_t *entry;
    const uint32_t index = mapped->mapping >> 16, subindex = mapped->mapping >> 8 & 0xFF;
    const bool outputs = ect_sm_role(&slave->config.device->sm[mapped->sm]) == ECT_SM_OUTPUTS;
    ect_line_string(line, "direction", outputs ? "outputs" : "inputs");
    ect_line_number(line, "sm", mapped->sm);
    ect_line_number(line, "pdo", mapped->pdo);
    put_name(line, "pdo_name", pdo ? pdo->name : NULL);
    ect_line_number(line, "index", index);
    ect_line_number(line, "sub", subindex);
    ect_line_number(line, "bits", mapped->mapping & 0xFF);
    if (ect_od_lookup(od, (uint16_t)index, (uint8_t)subindex, &object, &entry) == ECT_OK)
        put_entry(line, od, object, entry);
}

bool ect_pdos_next(const ect_slave_t *slave, size_t number, uint32_t *place, ect_line_t *line)
{
    mapped_t mapped;
    while (*place >> SM < slave->config.device->sm_count) {
        if (!find(slave, place, &mapped))
            continue;
        ect_line_begin(line);
        ect_line_number(line, "slave", number);
        ect_line_number(line, "place", (*place)++);
        put_mapped(line, slave, &mapped);
        ect_line_end(line);
        return true;
    }
    return false;
}
