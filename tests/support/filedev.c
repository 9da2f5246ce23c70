/* SPDX-License-Identifier: MIT */
#include "support/filedev.h"

#include <string.h>

static const struct {
    const char *name;
    uint32_t password;
    bool writable;
} files[FILEDEV_FILES] = {
    {"data", 0, true}, {"secret", FILEDEV_PASSWORD, true}, {"constant", 0, false}, {"checked", 0, true}};

/* The operation that the previous call started, or its completion. */
static uint32_t begun(const filedev_t *d)
{
    return d->late > 0 ? ECT_FOE_LATER : ECT_FOE_OK;
}

static uint32_t open_file(const ect_foe_t *self, void *instance, const ect_foe_file_t *wish, const char **text)
{
    filedev_t *d = instance;
    uint8_t n = 0;
    (void)self;
    while (n < FILEDEV_FILES &&
           (strlen(files[n].name) != wish->length || memcmp(files[n].name, wish->name, wish->length) != 0))
        n++;
    if (n == FILEDEV_FILES) {
        *text = "no such file";
        return ECT_FOE_NOT_FOUND;
    }
    if (wish->password != files[n].password)
        return ECT_FOE_ACCESS;
    if (wish->write && !files[n].writable)
        return ECT_FOE_NO_RIGHTS;
    d->open = n;
    d->draft_length = 0;
    d->opened++;
    return begun(d);
}

static uint32_t read_file(const ect_foe_t *self, void *instance, uint32_t offset, void *data, uint16_t *length,
                          const char **text)
{
    filedev_t *d = instance;
    uint32_t left = d->length[d->open] - offset;
    (void)self;
    if (d->late > 0)
        return ECT_FOE_LATER;
    if (d->read_error != 0) {
        *text = "torn";
        return d->read_error;
    }
    *length = (uint16_t)(left < *length ? left : *length);
    memcpy(data, d->content[d->open] + offset, *length);
    return ECT_FOE_OK;
}

static uint32_t write_file(const ect_foe_t *self, void *instance, uint32_t offset, const void *data, uint16_t length,
                           bool last, const char **text)
{
    filedev_t *d = instance;
    (void)self;
    if (offset + length > FILEDEV_ROOM)
        return ECT_FOE_DISK_FULL;
    memcpy(d->draft + offset, data, length);
    d->draft_length = offset + length;
    d->written++;
    if (last && d->open == FILEDEV_CHECKED && d->draft_length > 0 && d->draft[0] == 0xFF) {
        *text = "check value";
        return ECT_FOE_CHECKSUM;
    }
    return begun(d);
}

static uint32_t ready(const ect_foe_t *self, void *instance, const char **text)
{
    filedev_t *d = instance;
    (void)self;
    d->requests++;
    if (d->late > 0)
        d->late--;
    if (d->late > 0)
        return ECT_FOE_LATER;
    *text = d->ready_error != 0 ? "late error" : NULL;
    return d->ready_error;
}

static void close_file(const ect_foe_t *self, void *instance, bool whole)
{
    filedev_t *d = instance;
    (void)self;
    d->closed_whole += whole;
    d->closed_broken += !whole;
    if (!whole || d->written == 0)
        return;
    memcpy(d->content[d->open], d->draft, d->draft_length);
    d->length[d->open] = (uint16_t)d->draft_length;
}

static ect_foe_t foe;

ect_foe_t *filedev_entry(void)
{
    return &foe;
}

const ect_device_t *filedev_in(uint16_t read_states, uint16_t write_states, uint32_t busy_ms)
{
    static ect_device_t device;
    static const ect_protocol_t *protocols[TESTDEV_PROTOCOLS];
    foe = (ect_foe_t){.protocol = ECT_FOE_PROTOCOL,
                      .offset = offsetof(filedev_t, transfer),
                      .read_states = read_states,
                      .write_states = write_states,
                      .timeout_ms = 2000,
                      .busy_ms = busy_ms,
                      .open = open_file,
                      .read = read_file,
                      .write = write_file,
                      .ready = ready,
                      .close = close_file};
    device = testdev_with(&foe.protocol, protocols, ECT_MAILBOX_FOE, sizeof(filedev_t));
    device.name = "filedev";
    device.boot_out = (ect_boot_mailbox_t){testdev.sm[0].start, testdev.sm[0].length};
    device.boot_in = (ect_boot_mailbox_t){testdev.sm[1].start, testdev.sm[1].length};
    return &device;
}

const ect_device_t *filedev(void)
{
    const uint16_t everywhere = ECT_IN_PREOP_AND_ABOVE | ECT_IN(ECT_STATE_BOOT);
    return filedev_in(everywhere, everywhere, 0);
}

static uint16_t put_off(const ect_protocol_t *self, ect_slave_t *slave, const uint8_t *data, uint16_t length)
{
    enum { ACK = 4, ERROR = 5, BUSY = 6 };
    filedev_t *d = ect_mailbox_instance(slave);
    const size_t head = sizeof d->put_off;
    bool repeated = length >= head && memcmp(d->put_off, data, head) == 0;
    memset(d->put_off, 0, head);
    if (repeated || length < head || data[0] == ACK || data[0] == ERROR)
        return ect_foe_request(self, slave, data, length);
    memcpy(d->put_off, data, head);
    ect_mailbox_build(slave)[0] = BUSY;
    ect_mailbox_send(slave, ECT_MAILBOX_TYPE_FOE, (uint16_t)head);
    return ECT_MAILBOX_OK;
}

const ect_device_t *filedev_hesitant(void)
{
    static ect_device_t device;
    device = *filedev();
    device.name = "hesitant";
    foe.protocol.request = put_off;
    return &device;
}
