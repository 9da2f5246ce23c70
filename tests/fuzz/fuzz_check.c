/* SPDX-License-Identifier: MIT */
/*
 * Descriptions with anything in them that is no pointer: a copy of a device, each table in memory of just its size,
 * changed by the input, then passed to ect_device_check. A copy that it accepts must be safe to run: SII, a twin up to
 * OP, every entry by SDO and SDO information.
 *
 * The input: a byte that chooses the device, then steps of 8 bytes: which table, two bytes that choose the element,
 * which member, four bytes of value.
 */
#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "bus/chain/chain.h"
#include "check/check.h"
#include "devices/eclink/eclink.h"
#include "devices/fzm1/fzm1.h"
#include "sii/sii.h"
#include "support/confdev.h"
#include "support/copy.h"
#include "support/gauge.h"
#include "support/terminal.h"
#include "support/testdev.h"
#include "wire/bytes.h"
#include "wire/registers.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { STEP = 8, STATION = 0x1001, FPRD = 4, FPWR = 5, APWR = 2, MOST_INSTANCE = 1 << 20 };

static const ect_device_t *const devices[] = {&testdev, &confdev, &terminal, &gauge, &ect_eclink_map3, &ect_fzm1};

/* --- what is changed ---------------------------------------------------------------------------------------------- */

typedef struct member {
    uint16_t offset;
    uint8_t size;
} member_t;

#define MEMBER(type, member)              {offsetof(type, member), sizeof(((type *)0)->member)}
#define CHANGE(members, at, which, value) change(members, sizeof members / sizeof members[0], at, which, value)

static void change(const member_t *members, size_t count, void *at, uint8_t which, uint32_t value)
{
    const member_t *m = &members[which % count];
    uint64_t wide = m->size == 8 ? (uint64_t)(int64_t)(int32_t)value : value;
    memcpy((uint8_t *)at + m->offset, &wide, m->size);
}

static uint16_t least(uint16_t value, uint16_t most)
{
    return value < most ? value : most;
}

/* Counts only decrease, because the length of an array is unknown. */
static void change_counts(copy_t *c, uint8_t which, uint32_t value)
{
    ect_device_t *d = &c->device;
    switch (which % 6) {
    case 0:
        d->object_count = least((uint16_t)value, d->object_count);
        break;
    case 1:
        d->detail_count = least((uint16_t)value, d->detail_count);
        break;
    case 2:
        d->dc_mode_count = (uint8_t)least((uint8_t)value, d->dc_mode_count);
        break;
    case 3:
        d->sync.dc_cycle_count = (uint8_t)least((uint8_t)value, d->sync.dc_cycle_count);
        break;
    case 4:
        d->instance_size = value % MOST_INSTANCE;
        break;
    default:
        d->esc = value % 3 == 0 ? "np40" : value % 3 == 1 ? "et1100" : "lan9252";
        break;
    }
}

static void change_device(copy_t *c, uint8_t which, uint32_t value)
{
    static const member_t members[] = {MEMBER(ect_device_t, sii_size),
                                       MEMBER(ect_device_t, sm_count),
                                       MEMBER(ect_device_t, fmmu_count),
                                       MEMBER(ect_device_t, boot_out.start),
                                       MEMBER(ect_device_t, boot_out.length),
                                       MEMBER(ect_device_t, boot_in.start),
                                       MEMBER(ect_device_t, boot_in.length),
                                       MEMBER(ect_device_t, mailbox_protocols),
                                       MEMBER(ect_device_t, coe_details),
                                       MEMBER(ect_device_t, sync.supported),
                                       MEMBER(ect_device_t, sync.minimum_cycle_ns),
                                       MEMBER(ect_device_t, timeouts.preop_ms),
                                       MEMBER(ect_device_t, timeouts.safeop_op_ms),
                                       MEMBER(ect_device_t, identity.vendor_id),
                                       MEMBER(ect_device_t, identity.serial)};
    CHANGE(members, &c->device, which, value);
}

static void change_sm(copy_t *c, uint8_t n, uint8_t which, uint32_t value)
{
    static const member_t members[] = {MEMBER(ect_sm_t, start),   MEMBER(ect_sm_t, length),  MEMBER(ect_sm_t, minimum),
                                       MEMBER(ect_sm_t, maximum), MEMBER(ect_sm_t, control), MEMBER(ect_sm_t, type)};
    CHANGE(members, &c->device.sm[n % ECT_SMS], which, value);
    c->device.fmmu[n % ECT_FMMUS] ^= (uint8_t)(which == 0xFF ? value : 0);
}

static void change_object(copy_t *c, uint8_t i, uint8_t which, uint32_t value)
{
    static const member_t members[] = {MEMBER(ect_object_t, index), MEMBER(ect_object_t, object_code),
                                       MEMBER(ect_object_t, max_subindex), MEMBER(ect_object_t, last)};
    ect_object_t *o = &c->objects[i % c->device.object_count];
    uint8_t last = o->last;
    CHANGE(members, o, which, value);
    o->last = (uint8_t)least(o->last, last);
}

/* The data of a shared entry are a pointer, and stay one. */
static void change_entry(copy_t *c, uint8_t i, uint8_t k, uint8_t which, uint32_t value)
{
    static const member_t members[] = {MEMBER(ect_entry_t, subindex),   MEMBER(ect_entry_t, data_type),
                                       MEMBER(ect_entry_t, bit_length), MEMBER(ect_entry_t, access),
                                       MEMBER(ect_entry_t, value),      MEMBER(ect_entry_t, data)};
    unsigned int object = i % c->device.object_count;
    ect_entry_t *e = &c->entries[object][k % (c->objects[object].last + 1u)];
    uint16_t shared = e->access & ECT_ACCESS_SHARED;
    if (shared != 0 && which % 6 == 5)
        return;
    CHANGE(members, e, which, value);
    e->access = (uint16_t)((e->access & ~ECT_ACCESS_SHARED) | shared);
}

static void change_tables(copy_t *c, uint8_t i, uint8_t which, uint32_t value)
{
    static const uint8_t initial[8192];
    static const member_t members[] = {MEMBER(ect_detail_t, index), MEMBER(ect_detail_t, subindex),
                                       MEMBER(ect_detail_t, minimum), MEMBER(ect_detail_t, maximum)};
    static const member_t modes[] = {MEMBER(ect_dc_mode_t, assign_activate), MEMBER(ect_dc_mode_t, cycle_sync0_ns)};
    if (c->device.detail_count > 0 && which < 128) {
        CHANGE(members, &c->details[i % c->device.detail_count], which, value);
        c->details[i % c->device.detail_count].initial = (value & 0x10000) != 0 ? initial : NULL;
    } else if (c->device.dc_mode_count > 0) {
        CHANGE(modes, &c->dc_modes[i % c->device.dc_mode_count], which, value);
    }
}

static void mutate(copy_t *c, const uint8_t *b)
{
    uint32_t value = ect_load_le32(b + 4);
    if (c->device.object_count == 0)
        return;
    switch (b[0] % 8) {
    case 0:
        change_counts(c, b[3], value);
        break;
    case 1:
        change_device(c, b[3], value);
        break;
    case 2:
        change_sm(c, b[1], b[3], value);
        break;
    case 3:
        change_object(c, b[1], b[3], value);
        break;
    case 4:
        change_tables(c, b[1], b[3], value);
        break;
    default:
        change_entry(c, b[1], b[2], b[3], value);
        break;
    }
}

/* --- what is accepted runs ---------------------------------------------------------------------------------------- */

typedef struct session {
    ect_chain_t *chain;
    const ect_device_t *device;
    uint64_t now_ns;
    uint8_t counter;
} session_t;

static bool command(session_t *s, uint8_t cmd, uint16_t adp, uint16_t ado, void *data, uint16_t length)
{
    uint8_t frame[1514] = {[12] = 0x88, [13] = 0xA4};
    uint8_t *d = frame + 16;
    ect_store_le16(frame + 14, (uint16_t)(0x1000 | (12 + length)));
    d[0] = cmd;
    ect_store_le16(d + 2, adp);
    ect_store_le16(d + 4, ado);
    ect_store_le16(d + 6, length);
    memcpy(d + 10, data, length);
    s->now_ns += 10000;
    if (!ect_chain_process(s->chain, frame, 28u + length, s->now_ns))
        return false;
    (void)ect_chain_poll(s->chain, s->now_ns);
    memcpy(data, d + 10, length);
    return ect_load_le16(d + 10 + length) != 0;
}

static void set_sms(session_t *s, bool process)
{
    for (unsigned int n = 0; n < s->device->sm_count; n++) {
        uint8_t registers[8] = {0};
        uint16_t bytes = ect_device_sm_bytes(s->device, n);
        if (s->device->sm[n].type == ECT_SM_UNUSED || ect_device_sm_is_process(s->device, n) != process)
            continue;
        ect_store_le16(registers, s->device->sm[n].start);
        ect_store_le16(registers + 2, bytes);
        registers[4] = s->device->sm[n].control;
        registers[6] = bytes > 0;
        (void)command(s, FPWR, STATION, (uint16_t)(ECT_REG_SM + 8 * n), registers, sizeof registers);
    }
}

static void request(session_t *s, uint8_t state)
{
    uint8_t bytes[2] = {state, 0};
    (void)command(s, FPWR, STATION, ECT_REG_AL_CONTROL, bytes, 2);
}

/* A request, and all its replies. */
static void exchange(session_t *s, uint8_t kind, const uint8_t *payload, uint16_t length)
{
    uint8_t mail[1486] = {0};
    uint16_t out = s->device->sm[0].length, in = s->device->sm[1].length;
    s->counter = (uint8_t)(s->counter % 7 + 1);
    ect_store_le16(mail, (uint16_t)(2 + length));
    mail[5] = (uint8_t)(3 | s->counter << 4);
    mail[7] = (uint8_t)(kind << 4);
    memcpy(mail + 8, payload, length);
    (void)command(s, FPWR, STATION, s->device->sm[0].start, mail, out);
    while (command(s, FPRD, STATION, s->device->sm[1].start, mail, in))
        ;
}

static void ask_for(session_t *s, uint16_t index, uint8_t subindex)
{
    uint8_t upload[8] = {0x40}, download[8] = {0x22}, describe[8] = {5, 0, 0, 0, 0, 0, 0, 0x7F};
    ect_store_le16(upload + 1, index);
    ect_store_le16(download + 1, index);
    ect_store_le16(describe + 4, index);
    upload[3] = download[3] = describe[6] = subindex;
    exchange(s, 2, upload, 8);
    upload[0] = 0x60;
    exchange(s, 2, upload, 8);
    exchange(s, 2, download, 8);
    exchange(s, 8, describe, 8);
    upload[0] = subindex == 0 ? 0x50 : 0x80;
    exchange(s, 2, upload, 8);
}

static void ask_for_all(session_t *s)
{
    for (uint16_t i = 0; i < s->device->object_count; i++) {
        const ect_object_t *o = &s->device->objects[i];
        for (const ect_entry_t *e = o->entries; e; e = ect_od_next(o, e))
            ask_for(s, o->index, (uint8_t)e->subindex);
        ask_for(s, o->index, (uint8_t)(o->max_subindex + 1u));
    }
}

static void climb(session_t *s)
{
    uint8_t station[2] = {STATION & 0xFF, STATION >> 8};
    (void)command(s, APWR, 0, ECT_REG_STATION_ADDRESS, station, 2);
    set_sms(s, false);
    request(s, ECT_STATE_PREOP);
    if ((s->device->mailbox_protocols & ECT_MAILBOX_COE) != 0)
        ask_for_all(s);
    set_sms(s, true);
    request(s, ECT_STATE_SAFEOP);
    for (unsigned int n = 0; n < s->device->sm_count; n++) {
        uint8_t image[1486] = {0};
        if (s->device->sm[n].type == ECT_SM_OUTPUTS)
            (void)command(s, FPWR, STATION, s->device->sm[n].start, image, ect_device_sm_bytes(s->device, n));
    }
    request(s, ECT_STATE_OP);
    s->now_ns += 1000000000u;
    (void)ect_chain_poll(s->chain, s->now_ns);
}

static void run(const ect_device_t *device)
{
    const ect_twin_config_t twin = ect_twin_default(device, NULL);
    session_t s = {.device = device, .now_ns = 1};
    s.chain = ect_chain_new(&twin, 1, s.now_ns);
    assert(s.chain);
    climb(&s);
    ect_chain_free(s.chain);
}

/* The functions of the device, all from init on, rely on an instance of their own type. */
static void without_behaviour(ect_device_t *d)
{
    memset((uint8_t *)d + offsetof(ect_device_t, init), 0, sizeof *d - offsetof(ect_device_t, init));
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char text[ECT_CHECK_TEXT];
    if (size == 0)
        return 0;
    copy_t *c = copy_device(devices[data[0] % (sizeof devices / sizeof devices[0])]);
    uint16_t objects = c->device.object_count;
    without_behaviour(&c->device);
    for (size_t at = 1; at + STEP <= size; at += STEP)
        mutate(c, data + at);
    bool good = ect_device_check(&c->device, text, sizeof text);
    assert(good == (text[0] == 0));
    if (good)
        run(&c->device);
    c->device.object_count = objects;
    copy_free(c);
    return 0;
}
