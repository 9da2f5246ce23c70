/* SPDX-License-Identifier: MIT */
/*
 * Access to the dictionary by the program that runs the slave, as an SDO server carries it out for a master: the same
 * checks and the same calls of services and device, one value in one piece. A file of its own, so that the code of the
 * server in a firmware does not depend on it.
 */
#include <string.h>

#include "slave/internal.h"

static ect_reason_t find_entry(ect_slave_t *s, uint16_t index, uint8_t subindex, ect_direction_t direction,
                               const ect_entry_t **entry)
{
    const ect_device_t *device = s->config.device;
    const ect_object_t *object = NULL;
    if (ect_slave_in_transfer(s))
        return ECT_REASON_LOCAL_CONTROL;
    ect_slave_requested(s, index);
    ect_reason_t reason =
        device->sdo_request ? device->sdo_request(s->config.instance, index, subindex) : (ect_reason_t)ECT_OK;
    if (reason == ECT_OK)
        reason = ect_od_lookup(&s->od, index, subindex, &object, entry);
    return reason == ECT_OK ? ect_od_check_access(*entry, direction, s->state) : reason;
}

ect_reason_t ect_slave_upload(ect_slave_t *s, uint16_t index, uint8_t subindex, uint8_t *to, uint16_t room,
                              uint16_t *size)
{
    const ect_device_t *device = s->config.device;
    const ect_entry_t *entry = NULL;
    ect_span_t instead = {0};
    ECT_ASSERT(to && room > 0);
    ect_reason_t reason = find_entry(s, index, subindex, ECT_UPLOAD, &entry);
    if (reason == ECT_OK && device->sdo_read)
        reason = device->sdo_read(s->config.instance, index, subindex, &instead);
    if (reason != ECT_OK)
        return reason;
    *size = instead.data ? instead.size : ect_od_upload_size(&s->od, entry);
    uint16_t piece = *size < room ? *size : room;
    if (instead.data)
        memcpy(to, instead.data, piece);
    else
        ect_od_read(&s->od, entry, 0, to, piece);
    return ECT_OK;
}

static ect_reason_t check_value(ect_slave_t *s, const ect_entry_t *entry, uint16_t index, const uint8_t *data,
                                uint16_t size)
{
    const ect_device_t *device = s->config.device;
    const ect_download_t download = {index, (uint8_t)entry->subindex, false, data, size};
    const uint16_t whole = ect_od_bytes(entry);
    if (size > whole)
        return ECT_REASON_TOO_LONG;
    if (size < whole && (!ect_od_is_string(entry) || size == 0))
        return ECT_REASON_TOO_SHORT;
    ect_reason_t reason = size == whole ? ect_od_check_limit(&s->od, index, entry, data) : (ect_reason_t)ECT_OK;
    if (reason == ECT_OK)
        reason = ect_services_write(s, &download);
    if (reason != ECT_OK || !device->sdo_write)
        return reason;
    return device->sdo_write(s->config.instance, index, (uint8_t)entry->subindex, data, size);
}

ect_reason_t ect_slave_download(ect_slave_t *s, uint16_t index, uint8_t subindex, const uint8_t *data, uint16_t size)
{
    const ect_device_t *device = s->config.device;
    const ect_entry_t *entry = NULL;
    ect_reason_t reason = find_entry(s, index, subindex, ECT_DOWNLOAD, &entry);
    if (reason == ECT_OK)
        reason = check_value(s, entry, index, data, size);
    if (reason == ECT_OK && (entry->access & ECT_ACCESS_COMMAND) == 0)
        reason = ect_od_write(&s->od, entry, 0, data, size);
    if (reason != ECT_OK)
        return reason;
    if (device->sdo_written)
        device->sdo_written(s->config.instance, index, subindex, s->now_ns);
    ect_slave_wake(s);
    return ect_services_written(s, index, subindex, false);
}
