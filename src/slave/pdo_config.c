/* SPDX-License-Identifier: MIT */
/* Changeable mapping and assignment: 16xxh, 1Axxh, 1C12h, 1C13h (CF-074, CF-075). */
#include "slave/internal.h"

/* Whether an index is the assignment of a SyncManager with process data. */
static bool is_assignment(const ect_slave_t *s, uint16_t index)
{
    return index >= ECT_OD_ASSIGNMENT &&
           ect_device_sm_is_process(s->config.device, index - (unsigned int)ECT_OD_ASSIGNMENT);
}

static bool is_config(const ect_slave_t *s, uint16_t index)
{
    return is_assignment(s, index) || ect_od_is_rxpdo(index) || ect_od_is_txpdo(index);
}

static bool is_outputs(const ect_slave_t *s, uint16_t index)
{
    return is_assignment(s, index) ? s->config.device->sm[index - ECT_OD_ASSIGNMENT].type == ECT_SM_OUTPUTS
                                   : ect_od_is_rxpdo(index);
}

static uint32_t number(const ect_slave_t *s, uint16_t index, uint8_t subindex)
{
    uint32_t value = 0;
    (void)ect_od_number(&s->od, index, subindex, &value);
    return value;
}

static ect_reason_t check_mapping(const ect_slave_t *s, uint16_t pdo, uint32_t mapping)
{
    const ect_object_t *object;
    const ect_entry_t *entry;
    uint16_t direction = is_outputs(s, pdo) ? ECT_ACCESS_RXPDO : ECT_ACCESS_TXPDO;
    if (mapping >> 16 == 0)
        return ECT_OK; /* a gap */
    ect_reason_t reason = ect_od_lookup(&s->od, (uint16_t)(mapping >> 16), (uint8_t)(mapping >> 8), &object, &entry);
    if (reason != ECT_OK)
        return reason;
    return (entry->access & direction) != 0 && entry->bit_length == (mapping & 0xFF) ? ECT_OK : ECT_REASON_NOT_MAPPABLE;
}

static ect_reason_t check_assigned(const ect_slave_t *s, uint16_t assignment, uint32_t pdo)
{
    if (is_outputs(s, assignment) ? !ect_od_is_rxpdo((uint16_t)pdo) : !ect_od_is_txpdo((uint16_t)pdo))
        return ECT_REASON_NOT_MAPPABLE;
    return ect_od_find(&s->od, (uint16_t)pdo) ? ECT_OK : ECT_REASON_NO_OBJECT;
}

static uint32_t pdo_bits(const ect_slave_t *s, uint16_t pdo, uint32_t count)
{
    uint32_t bits = 0;
    for (uint32_t i = 1; i <= count; i++)
        bits += number(s, pdo, (uint8_t)i) & 0xFF;
    return bits;
}

static bool excluded(const ect_slave_t *s, uint16_t pdo, uint16_t other)
{
    const ect_device_t *device = s->config.device;
    for (unsigned int i = 0; i < device->pdo_count; i++) {
        const uint16_t *list = device->pdos[i].index == pdo ? device->pdos[i].excludes : NULL;
        for (; list && *list != 0; list++) {
            if (*list == other)
                return true;
        }
    }
    return false;
}

/* Each PDO may occur once, none may exclude another, and all must fit into the SyncManager. */
static ect_reason_t check_assignment(const ect_slave_t *s, uint16_t assignment, uint32_t count, uint32_t room_bits)
{
    uint32_t bits = 0;
    for (uint32_t i = 1; i <= count; i++) {
        uint16_t pdo = (uint16_t)number(s, assignment, (uint8_t)i);
        for (uint32_t k = 1; k < i; k++) {
            uint16_t other = (uint16_t)number(s, assignment, (uint8_t)k);
            if (other == pdo)
                return ECT_REASON_INCOMPATIBLE;
            if (excluded(s, pdo, other) || excluded(s, other, pdo))
                return ECT_REASON_INTERNAL;
        }
        bits += pdo_bits(s, pdo, number(s, pdo, 0));
    }
    return bits > room_bits ? ECT_REASON_PDO_LENGTH : ECT_OK;
}

/* Greatest length of an assignment's SyncManager, bits; for a mapping the greatest of its direction. */
static uint32_t room_of(const ect_slave_t *s, uint16_t index)
{
    const ect_device_t *device = s->config.device;
    uint8_t type = is_outputs(s, index) ? ECT_SM_OUTPUTS : ECT_SM_INPUTS;
    uint32_t most = 0;
    if (is_assignment(s, index))
        return 8u * ect_sm_room(device, index - (unsigned int)ECT_OD_ASSIGNMENT);
    for (unsigned int n = 0; n < device->sm_count; n++) {
        uint32_t room = device->sm[n].type == type ? 8u * ect_sm_room(device, n) : 0u;
        most = room > most ? room : most;
    }
    return most;
}

/* Whether `count` elements, as they are in the dictionary now, may become valid. */
static ect_reason_t check_count(const ect_slave_t *s, uint16_t index, uint32_t count)
{
    uint32_t room_bits = room_of(s, index);
    const ect_object_t *object = ect_od_find(&s->od, index);
    ECT_ASSERT(object != NULL && count <= UINT8_MAX);
    if (!ect_od_entry(object, (uint8_t)count))
        return ECT_REASON_TOO_HIGH;
    for (uint32_t i = 1; i <= count; i++) {
        uint32_t value = number(s, index, (uint8_t)i);
        ect_reason_t reason =
            is_assignment(s, index) ? check_assigned(s, index, value) : check_mapping(s, index, value);
        if (reason != ECT_OK)
            return reason;
    }
    if (is_assignment(s, index))
        return check_assignment(s, index, count, room_bits);
    return pdo_bits(s, index, count) > room_bits ? ECT_REASON_PDO_LENGTH : ECT_OK;
}

static ect_reason_t write_config(ect_slave_t *s, const ect_download_t *d)
{
    if (!is_config(s, d->index))
        return ECT_OK;
    uint32_t value = d->size == 1 ? d->data[0] : d->size == 2 ? ect_load_le16(d->data) : ect_load_le32(d->data);
    if (d->subindex == 0) /* with Complete Access the elements follow: ::written_config checks the whole object */
        return d->complete ? ECT_OK : check_count(s, d->index, value);
    if (!d->complete && number(s, d->index, 0) != 0)
        return ECT_REASON_SUBINDEX0;
    return is_assignment(s, d->index) ? check_assigned(s, d->index, value) : check_mapping(s, d->index, value);
}

/* An invalid whole object becomes an empty one, never a mapping that the master did not write. */
static ect_reason_t written_config(ect_slave_t *s, uint16_t index, uint8_t subindex, bool complete)
{
    (void)subindex;
    if (!complete || !is_config(s, index))
        return ECT_OK;
    ect_reason_t reason = check_count(s, index, number(s, index, 0));
    if (reason != ECT_OK) {
        const uint8_t none = 0;
        (void)ect_od_write(&s->od, ect_od_find(&s->od, index)->entries, 0, &none, 1);
    }
    return reason;
}

const ect_service_t ect_service_pdo_config = {.write = write_config, .written = written_config};
