/* SPDX-License-Identifier: MIT */
/* The device with one file more than it has by itself: its firmware. */
#include "update.h"

#include FIRMWARE_DEVICE_HEADER
#include "firmware.h"
#include "seams/foe.h"
#include "wire/registers.h"

enum { PROTOCOLS = 8, BOOT = ECT_STATE_BOOT };
enum { SHORT_MAIL = 64, MAIL = 256 };

static ect_device_t device;
static const ect_protocol_t *protocols[PROTOCOLS + 1];
static ect_foe_t files;
static const ect_host_t *host;
static uint32_t written;
static bool complete; /* there is a new firmware, and the master knows */

/* --- the file
 * --------------------------------------------------------------------------------------------------------- */

static uint32_t open_file(const ect_foe_t *foe, void *instance, const ect_foe_wish_t *wish, const char **text)
{
    (void)foe;
    (void)instance;
    (void)text;
    if (!wish->write)
        return ECT_FOE_NOT_FOUND;
    written = 0;
    complete = false;
    return board_slots()->erase() ? ECT_FOE_OK : ECT_FOE_PROGRAM_ERROR;
}

static uint32_t write_file(const ect_foe_t *foe, void *instance, uint32_t offset, const void *data, uint16_t length,
                           bool last, const char **text)
{
    const update_slots_t *slots = board_slots();
    (void)foe;
    (void)instance;
    if (offset > slots->size || length > slots->size - offset)
        return ECT_FOE_DISK_FULL;
    if (length > 0 && !slots->write(offset, data, length))
        return ECT_FOE_PROGRAM_ERROR;
    written = offset + length;
    if (!last || (written > UPDATE_HEADER && update_image(slots) == written - UPDATE_HEADER))
        return ECT_FOE_OK;
    *text = "no firmware for this board, or damaged";
    (void)slots->erase();
    return ECT_FOE_CHECKSUM;
}

static void closed(const ect_foe_t *foe, void *instance, bool whole)
{
    (void)foe;
    (void)instance;
    complete = whole;
    if (!whole)
        (void)board_slots()->erase();
}

/* --- the device
 * ------------------------------------------------------------------------------------------------------- */

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
 * The mailboxes of BOOT are the usual ones, which SOEM's firm_update leaves as they are. Where a file's name does not
 * fit those, they are others: in BOOT nothing else is in the ESC's RAM.
 */
static void lay_out_boot(void)
{
    const ect_sm_t *out = &device.sm[0], *in = &device.sm[1];
    bool fit = out->length >= SHORT_MAIL && in->length >= SHORT_MAIL;
    device.boot_out = fit ? (ect_boot_mailbox_t){out->start, out->length} : (ect_boot_mailbox_t){ECT_RAM, MAIL};
    device.boot_in = fit ? (ect_boot_mailbox_t){in->start, in->length} : (ect_boot_mailbox_t){ECT_RAM + MAIL, MAIL};
}

/* Anew at each call: the firmware and the EEPROM ask once each. */
const ect_device_t *firmware_device(void)
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
    lay_out_boot();
    device.init = init;
    device.state_change = state_change;
    return &device;
}
