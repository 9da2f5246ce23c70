/* SPDX-License-Identifier: MIT */
/* The device with one more file: its firmware. */
#include "update.h"

#include <string.h>

#include FIRMWARE_DEVICE_HEADER
#include "firmware.h"
#include "seams/foe.h"
#include "wire/registers.h"

enum { PROTOCOLS = 8, BOOT = ECT_STATE_BOOT };

static ect_device_t device;
static const ect_protocol_t *protocols[PROTOCOLS + 1];
static ect_foe_t files;
static const ect_host_t *host;
static uint8_t header[UPDATE_HEADER]; /* of the file under way */
static uint32_t written;
static bool complete; /* the second slot has a new firmware, and the master has received the acknowledge */

/* --- the file ----------------------------------------------------------------------------------------------------- */

static uint32_t open_file(const ect_foe_t *foe, void *instance, const ect_foe_file_t *wish, const char **text)
{
    (void)foe;
    (void)instance;
    (void)text;
    if (!wish->write)
        return ECT_FOE_NOT_FOUND;
    written = 0;
    complete = false;
    return ECT_FOE_OK;
}

/* Checks the header before the slot is erased. */
static uint32_t take_header(const char **text)
{
    const update_slots_t *slots = board_slots();
    const ect_identity_t *identity = &FIRMWARE_DEVICE.identity;
    if (!update_header_good(slots, header)) {
        *text = "no firmware for this board";
        return ECT_FOE_ILLEGAL;
    }
    if (ect_load_le32(header + 16) != identity->vendor_id || ect_load_le32(header + 20) != identity->product_code) {
        *text = "firmware of another product";
        return ECT_FOE_ILLEGAL;
    }
    return slots->erase() && slots->write(0, header, UPDATE_HEADER) ? ECT_FOE_OK : ECT_FOE_PROGRAM_ERROR;
}

static uint32_t write_image(const uint8_t *data, uint32_t length)
{
    const update_slots_t *slots = board_slots();
    if (length > slots->size - written)
        return ECT_FOE_DISK_FULL;
    if (length > 0 && !slots->write(written, data, length))
        return ECT_FOE_PROGRAM_ERROR;
    written += length;
    return ECT_FOE_OK;
}

/* Collects the header, which a short mailbox transfers in several pieces. */
static uint32_t write_piece(const uint8_t *data, uint16_t length, const char **text)
{
    uint32_t missing = written < UPDATE_HEADER ? UPDATE_HEADER - written : 0;
    uint32_t part = length < missing ? length : missing;
    memcpy(header + UPDATE_HEADER - missing, data, part);
    written += part;
    if (part > 0 && part == missing) {
        uint32_t error = take_header(text);
        if (error != ECT_FOE_OK)
            return error;
    }
    return write_image(data + part, length - part);
}

static uint32_t write_file(const ect_foe_t *foe, void *instance, uint32_t offset, const void *data, uint16_t length,
                           bool last, const char **text)
{
    const update_slots_t *slots = board_slots();
    (void)foe;
    (void)instance;
    (void)offset;
    uint32_t error = write_piece(data, length, text);
    if (error != ECT_FOE_OK || !last)
        return error;
    if (written > UPDATE_HEADER && update_image(slots) == written - UPDATE_HEADER)
        return ECT_FOE_OK;
    *text = "damaged firmware";
    (void)slots->erase();
    return ECT_FOE_CHECKSUM;
}

static void closed(const ect_foe_t *foe, void *instance, bool whole)
{
    (void)foe;
    (void)instance;
    complete = whole;
    if (!whole && written >= UPDATE_HEADER)
        (void)board_slots()->erase();
}

/* --- the device --------------------------------------------------------------------------------------------------- */

static void init(void *instance, const ect_host_t *its_host, uint64_t now_ns)
{
    host = its_host;
    if (FIRMWARE_DEVICE.init)
        FIRMWARE_DEVICE.init(instance, its_host, now_ns);
}

static uint16_t state_change(void *instance, uint8_t from, uint8_t to, uint64_t now_ns)
{
    if (from == BOOT && complete)
        host->restart(host->ctx);
    return FIRMWARE_DEVICE.state_change ? FIRMWARE_DEVICE.state_change(instance, from, to, now_ns) : 0;
}

/*
 * BOOT has the mailboxes of the other states, even if these are short: SOEM's firm_update writes SM0 and SM1 while they
 * are enabled, and an ESC then ignores another address or length.
 */
static void lay_out_boot(void)
{
    const ect_sm_t *out = &device.sm[0], *in = &device.sm[1];
    device.boot_out = (ect_boot_mailbox_t){out->start, out->length};
    device.boot_in = (ect_boot_mailbox_t){in->start, in->length};
}

/* Returns the same device at each call; called once for the firmware and once for the EEPROM. */
const ect_device_t *firmware_described(void)
{
    const size_t aligned = sizeof(max_align_t);
    size_t count = 0;
    device = FIRMWARE_DEVICE;
    files = (ect_foe_t){.protocol = ECT_FOE_PROTOCOL,
                        .offset = (device.instance_size + aligned - 1) / aligned * aligned,
                        .write_states = ECT_IN(BOOT),
                        .open = open_file,
                        .write = write_file,
                        .close = closed};
    for (const ect_protocol_t *const *p = device.protocols; p && *p; p++) {
        if (count == PROTOCOLS - 1)
            firmware_stop();
        protocols[count++] = *p;
    }
    protocols[count] = &files.protocol;
    device.protocols = protocols;
    device.mailbox_protocols |= ECT_MAILBOX_FOE;
    device.instance_size = files.offset + sizeof(ect_foe_transfer_t);
    if (FIRMWARE_VERSION[0] != 0)
        device.software_version = FIRMWARE_VERSION;
    lay_out_boot();
    device.init = init;
    device.state_change = state_change;
    return &device;
}
