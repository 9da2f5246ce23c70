/* SPDX-License-Identifier: MIT */
/* G. CoE, part one: objects, transfers, aborts, Complete Access. */
#include "steps/coe_walk.h"

#include <string.h>

enum { PLENTY = 65536 };
enum {
    TOGGLE_ERROR = 0x05030000,
    UNKNOWN_COMMAND = 0x05040001,
    WRITE_ONLY = 0x06010001,
    READ_ONLY = 0x06010002,
    NO_OBJECT = 0x06020000,
    TYPE_LENGTH = 0x06070010,
    TOO_LONG = 0x06070012,
    TOO_SHORT = 0x06070013,
    NO_SUBINDEX = 0x06090011,
};

/* Buffer of the present upload, too large for the stack. */
static uint8_t value[PLENTY];

/* --- objects ------------------------------------------------------------------------------------------------------ */

static void must_exist(cf_t *c, uint16_t index, uint8_t sub)
{
    uint32_t code;
    if (!cf_object_exists(c, index, sub, &code))
        cf_fail(c, "%04Xh:%02X: expected to exist, got abort 0x%08X", index, sub, code);
}

/* @return whether the SII has a DC mode, which then requires 1C32h and 1C33h */
static bool claims_sync(const cf_t *c)
{
    size_t length;
    const uint8_t *data = cf_sii_category(c, 60, &length);
    for (size_t at = 0; data && at + 24 <= length; at += 24) {
        if (ect_load_le16(data + at + 14) != 0)
            return true;
    }
    return false;
}

static void mandatory(cf_t *c)
{
    static const uint16_t names[] = {0x1008, 0x1009, 0x100A};
    uint32_t code;
    cf_go(c, CF_PREOP);
    must_exist(c, 0x1000, 0);
    cf_expect_range(c, "entries of 1018h", 4, 4, cf_upload_number(c, 0x1018, 0));
    for (uint8_t sub = 1; sub <= 4; sub++)
        must_exist(c, 0x1018, sub);
    uint64_t sms = cf_upload_number(c, 0x1C00, 0);
    cf_expect_range(c, "entries of 1C00h", c->facts.sm_count, c->facts.sms, sms);
    bool sync = claims_sync(c);
    for (uint8_t n = 0; n < c->facts.sm_count; n++) {
        uint8_t type = c->facts.sm[n].type;
        cf_expect(c, "type of a SyncManager in 1C00h", type, cf_upload_number(c, 0x1C00, (uint8_t)(n + 1)));
        if (type < ECT_SM_OUTPUTS || c->facts.sm[n].length == 0)
            continue;
        must_exist(c, (uint16_t)(0x1C10 + n), 1);
        if (sync)
            must_exist(c, type == ECT_SM_OUTPUTS ? 0x1C32 : 0x1C33, 1);
    }
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        if (!cf_object_exists(c, names[i], 0, &code))
            cf_warn(c, "%04Xh: usual, got abort 0x%08X", names[i], code);
    }
}

static void check_count(cf_t *c, const coe_object_t *o)
{
    uint64_t count = 0;
    if (o->code != COE_VAR) {
        size_t size = sizeof value;
        uint32_t code = cf_upload(c, o->index, 0, false, value, &size);
        cf_expect_that(c, code == 0 && size == 1, "%04Xh:00: expected one byte, got %zu, abort 0x%08X", o->index, size,
                       code);
        count = value[0];
        cf_expect_that(c, count <= o->most, "%04Xh:00: expected at most %u as in its description, got %u", o->index,
                       o->most, (unsigned int)count);
    }
    if (o->most == 0xFF)
        return;
    size_t size = sizeof value;
    uint32_t code = cf_upload(c, o->index, (uint8_t)(o->most + 1), false, value, &size);
    cf_expect_that(c, code == NO_SUBINDEX, "%04Xh:%02X, after the last: expected abort 0x06090011, got 0x%08X",
                   o->index, o->most + 1u, code);
}

static void counts(cf_t *c)
{
    cf_go(c, CF_PREOP);
    unsigned int objects = coe_walk(c, check_count);
    cf_note(c, "%u objects", objects);
}

/* --- transfers ---------------------------------------------------------------------------------------------------- */

static unsigned int entries_seen;

static void check_size(cf_t *c, const coe_object_t *o)
{
    for (unsigned int sub = 0; sub <= o->most && entries_seen < COE_ENTRIES_MOST; sub++) {
        coe_entry_t e;
        size_t size = sizeof value;
        if (!coe_entry(c, o, (uint8_t)sub, &e) || (e.access & COE_READ_PREOP) == 0)
            continue;
        uint32_t code = cf_upload(c, o->index, (uint8_t)sub, false, value, &size);
        entries_seen++;
        if (code != 0)
            continue; /* may be temporary; another case checks the existence */
        bool text = e.type >= COE_VISIBLE_STRING && e.type <= COE_UNICODE_STRING;
        size_t bytes = (e.bits + 7u) / 8;
        cf_expect_that(c, size == bytes || (text && size <= bytes) || e.bits == 0,
                       "upload of %04Xh:%02X: expected %zu bytes as in its description, got %zu", o->index, sub, bytes,
                       size);
    }
}

/* Checks the size bits of an expedited reply. */
static void check_expedited(cf_t *c)
{
    cf_mail_t mail;
    cf_step(c, "4 bytes, and 1 byte, expedited");
    cf_send_sdo(c, 0x40, 0x1000, 0, 0);
    cf_receive_coe(c, &mail);
    cf_expect_that(c, mail.data[2] == 0x43 || (mail.data[2] == 0x41 && ect_load_le32(mail.data + 6) == 4),
                   "command of an upload of 4 bytes: expected 0x43, got 0x%02X", mail.data[2]);
    cf_send_sdo(c, 0x40, 0x1018, 0, 0);
    cf_receive_coe(c, &mail);
    cf_expect_that(c, mail.data[2] == 0x4F || (mail.data[2] == 0x41 && ect_load_le32(mail.data + 6) == 1),
                   "command of an upload of 1 byte: expected 0x4F, got 0x%02X", mail.data[2]);
}

static void uploads(cf_t *c)
{
    entries_seen = 0;
    cf_go(c, CF_PREOP);
    check_expedited(c);
    (void)coe_walk(c, check_size);
    cf_note(c, "%u entries", entries_seen);
}

/* A writable number, or a write-only entry. */
typedef struct found {
    uint16_t index;
    uint8_t sub;
    size_t bytes;
} found_t;
static found_t writable, write_only;

/* @return whether writing the entry has no effect: no command, no mapping, no count */
static bool is_plain_number(const coe_object_t *o, unsigned int sub, const coe_entry_t *e)
{
    bool mapping = o->index >= 0x1600 && o->index < 0x1C40, count = sub == 0 && o->code != COE_VAR;
    bool number = e->type >= 2 && e->type <= 7 && e->bits >= 16 && e->bits <= 32 && e->bits % 8 == 0;
    return number && !mapping && !count;
}

static void take_entry(const coe_object_t *o, unsigned int sub, const coe_entry_t *e)
{
    const found_t f = {o->index, (uint8_t)sub, (e->bits + 7u) / 8};
    if ((e->access & COE_READ_PREOP) == 0)
        write_only = write_only.index == 0 ? f : write_only;
    else if (is_plain_number(o, sub, e))
        writable = writable.index == 0 ? f : writable;
}

static void find_entries(cf_t *c, const coe_object_t *o)
{
    coe_entry_t e;
    if (o->index == 0x1010 || o->index == 0x1011 || o->index == 0x10F3)
        return; /* writing has an effect */
    for (unsigned int sub = 0; sub <= o->most && (writable.index == 0 || write_only.index == 0); sub++) {
        if (coe_entry(c, o, (uint8_t)sub, &e) && (e.access & COE_WRITE_PREOP) != 0)
            take_entry(o, sub, &e);
    }
}

static void wrong_length(cf_t *c, size_t length)
{
    uint8_t old[8] = {0};
    size_t size = sizeof old;
    (void)cf_upload(c, writable.index, writable.sub, false, old, &size);
    cf_step(c, "%zu bytes into %04Xh:%02X of %zu", length, writable.index, writable.sub, writable.bytes);
    uint32_t code = cf_change(c, writable.index, writable.sub, old, length);
    cf_expect_that(c, code == TYPE_LENGTH || code == TOO_LONG || code == TOO_SHORT,
                   "download of %zu bytes into %04Xh:%02X of %zu: expected abort 0x06070010, 12 or 13, got 0x%08X",
                   length, writable.index, writable.sub, writable.bytes, code);
}

static uint32_t try_upload(cf_t *c, uint16_t index, uint8_t sub)
{
    size_t size = sizeof value;
    return cf_upload(c, index, sub, false, value, &size);
}

static uint16_t missing_index(cf_t *c)
{
    static const uint16_t candidates[] = {0x0FFF, 0x6FFF, 0x5FFE, 0x3ABC};
    for (size_t i = 0; i < sizeof candidates / sizeof candidates[0]; i++) {
        if (try_upload(c, candidates[i], 0) != 0)
            return candidates[i];
    }
    cf_skip(c, "all tested indices exist");
}

static void refusals(cf_t *c)
{
    uint8_t data[8] = {1, 2, 3, 4};
    writable = write_only = (found_t){0};
    cf_go(c, CF_PREOP);
    uint16_t none = missing_index(c);
    cf_expect(c, "abort of an upload of a non-existent index", NO_OBJECT, try_upload(c, none, 0));
    cf_expect(c, "abort of a download to a non-existent index", NO_OBJECT, cf_download(c, none, 0, false, data, 4));
    cf_expect(c, "abort of an upload of 1018h:05", NO_SUBINDEX, try_upload(c, 0x1018, 5));
    cf_expect(c, "abort of a download to 1018h:05", NO_SUBINDEX, cf_download(c, 0x1018, 5, false, data, 4));
    cf_expect(c, "abort of a download to 1000h, which is read-only", READ_ONLY,
              cf_download(c, 0x1000, 0, false, data, 4));
    cf_expect(c, "abort of a download to 1018h:01", READ_ONLY, cf_download(c, 0x1018, 1, false, data, 4));
    if ((c->facts.has & CF_SDO_INFO) != 0)
        (void)coe_walk(c, find_entries);
    if (write_only.index != 0)
        cf_expect(c, "abort of an upload of a write-only entry", WRITE_ONLY,
                  try_upload(c, write_only.index, write_only.sub));
    if (writable.index == 0) {
        cf_note(c, "wrong lengths not tested: no writable number was found");
        return;
    }
    wrong_length(c, writable.bytes + 4);
    wrong_length(c, writable.bytes - 1);
}

static void aborts(cf_t *c)
{
    cf_go(c, CF_PREOP);
    uint16_t none = missing_index(c);
    cf_send_sdo(c, 0x40, none, 3, 0);
    cf_expect_abort(c, none, 3, NO_OBJECT);
    cf_send_sdo(c, 0x40, 0x1018, 0x55, 0);
    cf_expect_abort(c, 0x1018, 0x55, NO_SUBINDEX);
    cf_send_sdo(c, 0x23, 0x1000, 0, 0);
    cf_expect_abort(c, 0x1000, 0, READ_ONLY);
}

/* --- the protocol of transfers ------------------------------------------------------------------------------------ */

static found_t longest;

static void find_longest(cf_t *c, const coe_object_t *o)
{
    for (unsigned int sub = 0; sub <= o->most; sub++) {
        coe_entry_t e;
        if (coe_entry(c, o, (uint8_t)sub, &e) && (e.access & COE_READ_PREOP) != 0 && (e.bits + 7u) / 8 > longest.bytes)
            longest = (found_t){o->index, (uint8_t)sub, (e.bits + 7u) / 8};
    }
}

static void good_upload(cf_t *c)
{
    cf_expect(c, "the next transfer, 1018h:01", c->facts.vendor, cf_upload_number(c, 0x1018, 1));
}

/* Starts a segmented upload. @return false: no object is long enough */
static bool begin_segments(cf_t *c)
{
    cf_mail_t mail;
    cf_send_sdo(c, 0x40, longest.index, longest.sub, 0);
    cf_receive_coe(c, &mail);
    return (mail.data[2] & 0xE3) == 0x41 && mail.length - 10u < ect_load_le32(mail.data + 6);
}

static void toggles(cf_t *c)
{
    cf_mail_t mail;
    longest = (found_t){0};
    if ((c->facts.has & CF_SDO_INFO) != 0)
        (void)coe_walk(c, find_longest);
    if (longest.bytes + 16 <= c->mailbox.in_size || !begin_segments(c)) {
        cf_note(c, "without segments: no object is longer than the mailbox");
        return;
    }
    cf_step(c, "a request for the first segment with the toggle bit of the second");
    cf_send_sdo(c, 0x70, 0, 0, 0);
    cf_receive_coe(c, &mail);
    cf_expect(c, "SDO command after a wrong toggle", 0x80, mail.data[2]);
    cf_expect(c, "abort code after a wrong toggle", TOGGLE_ERROR, ect_load_le32(mail.data + 6));
    cf_step(c, "the master aborts a transfer");
    cf_expect_that(c, begin_segments(c), "upload of %04Xh:%02X: expected in segments, got in one reply", longest.index,
                   longest.sub);
    cf_send_sdo(c, 0x80, longest.index, longest.sub, 0x08000000);
    cf_step(c, "a request for the next segment of the aborted transfer");
    cf_send_sdo(c, 0x60, 0, 0, 0);
    cf_receive_coe(c, &mail);
    cf_expect(c, "SDO command after a segment request for an aborted transfer", 0x80, mail.data[2]);
    good_upload(c);
}

static void protocol(cf_t *c)
{
    uint8_t data[8] = {0x40, 0x18, 0x10, 1};
    cf_mail_t mail;
    cf_go(c, CF_PREOP);
    cf_step(c, "an unknown SDO command");
    cf_send_sdo(c, 0xE0, 0x1018, 1, 0);
    cf_expect_abort(c, 0x1018, 1, UNKNOWN_COMMAND);
    good_upload(c);
    cf_step(c, "a segment without a transfer");
    cf_send_sdo(c, 0x60, 0, 0, 0);
    cf_receive_coe(c, &mail);
    cf_expect(c, "SDO command after a segment without a transfer", 0x80, mail.data[2]);
    good_upload(c);
    cf_step(c, "an unknown CoE service");
    cf_send_coe(c, 15, data, sizeof data);
    if (cf_receive_mail(c, &mail, 200))
        cf_expect_that(c, mail.type == CF_MBX_ERROR || mail.data[2] == 0x80,
                       "an unknown CoE service: expected an error, got mailbox type %u", mail.type);
    good_upload(c);
    toggles(c);
}

/* --- complete access ---------------------------------------------------------------------------------------------- */

/* Assembles the content of a Complete Access upload from single uploads: sub-index 0 as 16 bits, then each entry.
 * @return bytes; 0: entries of less than a byte, or an unreadable entry */
static size_t assemble(cf_t *c, const coe_object_t *o, uint8_t *all)
{
    size_t used = 2;
    uint8_t count = (uint8_t)cf_upload_number(c, o->index, 0);
    ect_store_le16(all, count);
    for (unsigned int sub = 1; sub <= count; sub++) {
        coe_entry_t e;
        size_t size = 256;
        if (!coe_entry(c, o, (uint8_t)sub, &e))
            continue;
        if (e.bits % 8 != 0 || used + size > PLENTY ||
            cf_upload(c, o->index, (uint8_t)sub, false, all + used, &size) != 0 || size != e.bits / 8)
            return 0;
        used += size;
    }
    return used;
}

static unsigned int compared;
static uint8_t before[PLENTY], after[PLENTY];

/* Compares only bytes that were equal before and after: inputs and counters may change meanwhile. */
static void compare(cf_t *c, const coe_object_t *o, const uint8_t *got, size_t first, size_t bytes)
{
    for (size_t i = first; i < bytes; i++) {
        if (before[i] == after[i] && got[i - first] != before[i])
            cf_fail(c, "complete upload of %04Xh: byte %zu: expected 0x%02X as in a single upload, got 0x%02X",
                    o->index, i - first, before[i], got[i - first]);
    }
}

/* @return whether an object has no gaps, and no messages that may arrive meanwhile */
static bool comparable(const coe_object_t *o)
{
    return o->code != COE_VAR && o->index >= 0x1018 && o->index != 0x10F3 && o->index != 0x1C32 && o->index != 0x1C33;
}

static void complete_upload(cf_t *c, uint16_t index, uint8_t sub, uint8_t *to, size_t expected)
{
    size_t size = PLENTY;
    uint32_t code = cf_upload(c, index, sub, true, to, &size);
    cf_expect_that(c, code == 0 && size == expected,
                   "complete upload of %04Xh from sub-index %u: expected %zu bytes, got %zu, abort 0x%08X", index, sub,
                   expected, size, code);
}

static void check_complete(cf_t *c, const coe_object_t *o)
{
    static uint8_t from_1[PLENTY];
    if (!comparable(o) || compared >= COE_OBJECTS_MOST / 8)
        return;
    size_t bytes = assemble(c, o, before);
    if (bytes == 0)
        return;
    complete_upload(c, o->index, 0, value, bytes);
    if (bytes > 2) /* there is a sub-index 1 */
        complete_upload(c, o->index, 1, from_1, bytes - 2);
    if (assemble(c, o, after) != bytes)
        return;
    compare(c, o, value, 0, bytes);
    compare(c, o, from_1, 2, bytes);
    compared++;
}

static void complete(cf_t *c)
{
    uint8_t data[64] = {0};
    size_t size = sizeof value;
    compared = 0;
    cf_go(c, CF_PREOP);
    (void)coe_walk(c, check_complete);
    cf_step(c, "from sub-index 2, of a read-only object, of a non-existent object");
    uint32_t code = cf_upload(c, 0x1018, 2, true, value, &size);
    cf_expect_that(c, code != 0, "complete upload from sub-index 2: expected an abort, got %zu bytes", size);
    code = cf_download(c, 0x1018, 0, true, data, 18);
    cf_expect_that(c, code != 0, "complete download to 1018h, read-only: expected an abort, got a response");
    size = sizeof value;
    cf_expect(c, "abort of a complete upload of a non-existent index", NO_OBJECT,
              cf_upload(c, missing_index(c), 0, true, value, &size));
    cf_note(c, "%u objects", compared);
}

static const cf_case_t cases[] = {
    {"CF-067", "The mandatory objects exist", 'F', CF_COE, 0, mandatory},
    {"CF-068", "Sub-index 0 counts the entries; after the last one the abort code is 0x06090011", 'F', CF_COE, 60000,
     counts},
    {"CF-069", "Uploads have the sizes of their descriptions, expedited, normal and in segments", 'F',
     CF_COE | CF_SDO_INFO, 60000, uploads},
    {"CF-070", "Wrong lengths, rights, indices and sub-indices are refused with their codes", 'F', CF_COE, 60000,
     refusals},
    {"CF-071", "An abort is command 0x80 in service 2 with index, sub-index and code", 'R', CF_COE, 0, aborts},
    {"CF-072", "Wrong toggles, commands and services are refused, and the next transfer works", 'R', CF_COE, 60000,
     protocol},
    {"CF-073", "Complete Access returns the same values as single uploads", 'F', CF_COE | CF_COMPLETE, 60000, complete},
};

CF_SECTION(cf_coe, 'G', "CoE: objects and transfers", cases);
