/* SPDX-License-Identifier: MIT */
/*
 * The reader against slaves that lie: replies of every wrong length, index, toggle and count, lists and segments
 * without an end, mailboxes and EEPROMs of garbage, wires that lose frames. Whatever the slave does, each call returns
 * within its limit, writes no byte beyond its buffers (the sanitizers watch), and a JSON text stays one.
 */
#define _GNU_SOURCE
#include <cjson/cJSON.h>
#include <stdlib.h>
#include <string.h>

#include "facts/facts.h"
#include "reader/reader.h"
#include "seams/device.h"
#include "support/liar.h"
#include "support/testdev.h"

enum { COE = 3, EOE = 2, EMERGENCY = 1, REQUEST = 2, RESPONSE = 3, INFO = 8, UPLOAD = 2, SEGMENT = 3 };
enum { LIST = 1, OBJECT = 3, ENTRY = 5, INCOMPLETE = 0x80, MORE_THAN_ROOM = 4097, INIT = 1, PREOP = 2 };

static ect_reader_t reader;
static uint8_t image[ECT_READER_SII];

static bool is_upload(const uint8_t *r)
{
    return (r[5] & 0xF) == COE && r[7] >> 4 == REQUEST && r[8] >> 5 == UPLOAD;
}

static bool is_segment(const uint8_t *r)
{
    return (r[5] & 0xF) == COE && r[7] >> 4 == REQUEST && r[8] >> 5 == SEGMENT;
}

static bool is_info(const uint8_t *r, unsigned int opcode)
{
    return (r[5] & 0xF) == COE && r[7] >> 4 == INFO && (opcode == 0 || (r[8] & 0x7F) == opcode);
}

/* A reply to an upload: command, the index and sub-index of the request, a number, and `length` more bytes. */
static liar_mail_t set_upload(liar_t *l, const uint8_t *r, uint8_t command, uint32_t number, size_t length)
{
    uint8_t reply[1500] = {command, r[9], r[10], r[11]};
    ect_store_le32(reply + 4, number);
    liar_set_coe_mail(l, RESPONSE, reply, 8 + length);
    return LIAR_REPLIES;
}

static liar_mail_t set_segment(liar_t *l, uint8_t command, size_t length)
{
    uint8_t reply[1500] = {command};
    liar_set_coe_mail(l, RESPONSE, reply, 1 + length);
    return LIAR_REPLIES;
}

static liar_mail_t set_info(liar_t *l, uint8_t opcode, const void *data, size_t length)
{
    uint8_t reply[1500] = {opcode};
    memcpy(reply + 4, data, length);
    liar_set_coe_mail(l, INFO, reply, 4 + length);
    return LIAR_REPLIES;
}

/* --- uploads ------------------------------------------------------------------------------------------------------ */

static liar_mail_t of_size(liar_t *l, const uint8_t *r, uint32_t size)
{
    return is_upload(r) ? set_upload(l, r, 0x41, size, 100) : LIAR_PASSES;
}

static liar_mail_t size_4g(liar_t *l, const uint8_t *r)
{
    return of_size(l, r, UINT32_MAX);
}

static liar_mail_t size_2g(liar_t *l, const uint8_t *r)
{
    return of_size(l, r, INT32_MAX);
}

static liar_mail_t size_over(liar_t *l, const uint8_t *r)
{
    return of_size(l, r, MORE_THAN_ROOM);
}

static liar_mail_t size_zero(liar_t *l, const uint8_t *r)
{
    return of_size(l, r, 0);
}

static liar_mail_t size_less(liar_t *l, const uint8_t *r)
{
    return of_size(l, r, 1);
}

static liar_mail_t segmented(liar_t *l, const uint8_t *r, uint8_t command, size_t length)
{
    if (is_upload(r))
        return set_upload(l, r, 0x41, 1000, 10);
    return is_segment(r) ? set_segment(l, command, length) : LIAR_PASSES;
}

static liar_mail_t segments_empty(liar_t *l, const uint8_t *r)
{
    return segmented(l, r, (uint8_t)(r[8] & 0x10), 0);
}

static liar_mail_t segments_short(liar_t *l, const uint8_t *r)
{
    return segmented(l, r, (uint8_t)((r[8] & 0x10) | 0x0E), 7);
}

static liar_mail_t segments_endless(liar_t *l, const uint8_t *r)
{
    return segmented(l, r, (uint8_t)(r[8] & 0x10), 90);
}

static liar_mail_t segments_of_one(liar_t *l, const uint8_t *r)
{
    return segmented(l, r, (uint8_t)((r[8] & 0x10) | 0x0C), 7);
}

static liar_mail_t toggle_stuck(liar_t *l, const uint8_t *r)
{
    return segmented(l, r, 0x00, 50);
}

static liar_mail_t toggle_inverted(liar_t *l, const uint8_t *r)
{
    return segmented(l, r, (uint8_t)(~r[8] & 0x10), 50);
}

static liar_mail_t segment_last_at_once(liar_t *l, const uint8_t *r)
{
    return segmented(l, r, (uint8_t)((r[8] & 0x10) | 1), 50);
}

static liar_mail_t segment_none(liar_t *l, const uint8_t *r)
{
    if (is_upload(r))
        return set_upload(l, r, 0x41, 1000, 10);
    return is_segment(r) ? LIAR_SWALLOWS : LIAR_PASSES;
}

static liar_mail_t segment_without_a_command(liar_t *l, const uint8_t *r)
{
    if (!is_segment(r))
        return segmented(l, r, 0, 0);
    liar_set_coe_mail(l, RESPONSE, "", 0);
    return LIAR_REPLIES;
}

static liar_mail_t wrong_index(liar_t *l, const uint8_t *r)
{
    uint8_t other[12];
    memcpy(other, r, sizeof other);
    other[9] ^= 1;
    return is_upload(r) ? set_upload(l, other, 0x43, 7, 0) : LIAR_PASSES;
}

static liar_mail_t wrong_subindex(liar_t *l, const uint8_t *r)
{
    uint8_t other[12];
    memcpy(other, r, sizeof other);
    other[11] ^= 0x80;
    return is_upload(r) ? set_upload(l, other, 0x43, 7, 0) : LIAR_PASSES;
}

static liar_mail_t wrong_command(liar_t *l, const uint8_t *r)
{
    return is_upload(r) ? set_upload(l, r, 0xE3, 7, 0) : LIAR_PASSES;
}

static liar_mail_t download_reply(liar_t *l, const uint8_t *r)
{
    return is_upload(r) ? set_upload(l, r, 0x60, 0, 0) : LIAR_PASSES;
}

static liar_mail_t never_uploads(liar_t *l, const uint8_t *r)
{
    (void)l;
    return is_upload(r) ? LIAR_SWALLOWS : LIAR_PASSES;
}

static liar_mail_t always_aborts(liar_t *l, const uint8_t *r)
{
    return is_upload(r) ? set_upload(l, r, 0x80, 0x08000000, 0) : LIAR_PASSES;
}

static liar_mail_t aborts_another(liar_t *l, const uint8_t *r)
{
    uint8_t other[12];
    memcpy(other, r, sizeof other);
    other[10] ^= 1;
    return is_upload(r) ? set_upload(l, other, 0x80, 0x08000000, 0) : LIAR_PASSES;
}

static liar_mail_t upload_cut(liar_t *l, const uint8_t *r)
{
    static const uint8_t reply[] = {0x43, 0, 0, 0, 0};
    if (!is_upload(r))
        return LIAR_PASSES;
    liar_set_coe_mail(l, RESPONSE, reply, sizeof reply);
    return LIAR_REPLIES;
}

static liar_mail_t count_255(liar_t *l, const uint8_t *r)
{
    if (is_info(r, 0))
        return set_info(l, 7, "\x04\x00\x01\x06", 4);
    if (!is_upload(r))
        return LIAR_PASSES;
    return set_upload(l, r, 0x43, r[11] == 0 ? 255u : 0x1A00u + r[11], 0);
}

static liar_mail_t count_huge(liar_t *l, const uint8_t *r)
{
    if (is_info(r, 0))
        return set_info(l, 7, "\x04\x00\x01\x06", 4);
    return is_upload(r) ? set_upload(l, r, 0x43, UINT32_MAX, 0) : LIAR_PASSES;
}

/* --- mails -------------------------------------------------------------------------------------------------------- */

static liar_mail_t mail_error(liar_t *l, const uint8_t *r)
{
    (void)r;
    liar_set_mail(l, 0, "\x01\x00\x05\x00", 4);
    return LIAR_REPLIES;
}

static liar_mail_t mail_error_cut(liar_t *l, const uint8_t *r)
{
    (void)r;
    liar_set_mail(l, 0, "\x01", 1);
    return LIAR_REPLIES;
}

static liar_mail_t mail_empty(liar_t *l, const uint8_t *r)
{
    (void)r;
    liar_set_mail(l, COE, "", 0);
    return LIAR_REPLIES;
}

static liar_mail_t mail_header_alone(liar_t *l, const uint8_t *r)
{
    (void)r;
    liar_set_mail(l, COE, "\x00\x30", 2);
    return LIAR_REPLIES;
}

static void length_of(uint8_t *mail, uint16_t length)
{
    ect_store_le16(mail, length);
}

static void length_64k(liar_t *l, uint8_t *mail)
{
    (void)l;
    length_of(mail, UINT16_MAX);
}

static void length_over(liar_t *l, uint8_t *mail)
{
    length_of(mail, (uint16_t)(l->in_size - 6 + 1));
}

static void length_whole_mailbox(liar_t *l, uint8_t *mail)
{
    length_of(mail, (uint16_t)(l->in_size - 6));
}

static void length_none(liar_t *l, uint8_t *mail)
{
    (void)l;
    length_of(mail, 0);
}

static void length_one_less(liar_t *l, uint8_t *mail)
{
    (void)l;
    length_of(mail, (uint16_t)(ect_load_le16(mail) - 1));
}

static void type_eoe(liar_t *l, uint8_t *mail)
{
    (void)l;
    mail[5] = (uint8_t)((mail[5] & 0xF0) | EOE);
}

static void counter_none(liar_t *l, uint8_t *mail)
{
    (void)l;
    mail[5] &= 0x8F;
}

static void counter_stuck(liar_t *l, uint8_t *mail)
{
    (void)l;
    mail[5] = (uint8_t)((mail[5] & 0x8F) | 0x30);
}

static void counter_reserved_bit(liar_t *l, uint8_t *mail)
{
    (void)l;
    mail[5] |= 0x80;
}

static void service_wrong(liar_t *l, uint8_t *mail)
{
    (void)l;
    mail[7] = (uint8_t)((mail[7] & 0x0F) | 0x70);
}

static void noise(liar_t *l, uint8_t *mail)
{
    for (unsigned int i = 0; i < l->in_size; i++) {
        l->number = l->number * 6364136223846793005u + 1442695040888963407u;
        mail[i] = (uint8_t)(l->number >> 56);
    }
}

/* One bit of each reply is wrong, another one each time. */
static void one_bit(liar_t *l, uint8_t *mail)
{
    const uint64_t bit = l->number++ * 7 % 160;
    mail[bit / 8] ^= (uint8_t)(1u << bit % 8);
}

static liar_mail_t emergencies(liar_t *l, const uint8_t *r)
{
    (void)r;
    liar_set_coe_mail(l, EMERGENCY, "\x00\x10\x00\x00\x00\x00\x00\x00", 8);
    return LIAR_REPLIES;
}

static bool another_emergency(liar_t *l)
{
    liar_set_coe_mail(l, EMERGENCY, "\x00\x10\x00\x00\x00\x00\x00\x00", 8);
    return true;
}

static liar_mail_t frames_of_eoe(liar_t *l, const uint8_t *r)
{
    (void)r;
    liar_set_mail(l, EOE, "\x00\x00\x00\x00", 4);
    return LIAR_REPLIES;
}

static bool same_again(liar_t *l)
{
    (void)l;
    return true;
}

static liar_mail_t reply_of_before(liar_t *l, const uint8_t *r)
{
    return is_upload(r) ? set_upload(l, r, 0x43, 7, 0) : LIAR_PASSES;
}

/* --- SDO information ---------------------------------------------------------------------------------------------- */

static liar_mail_t info_none(liar_t *l, const uint8_t *r)
{
    (void)l;
    return is_info(r, 0) ? LIAR_SWALLOWS : LIAR_PASSES;
}

static liar_mail_t info_cut(liar_t *l, const uint8_t *r)
{
    static const uint8_t reply[] = {2, 0};
    if (!is_info(r, 0))
        return LIAR_PASSES;
    liar_set_coe_mail(l, INFO, reply, sizeof reply);
    return LIAR_REPLIES;
}

static liar_mail_t info_error_cut(liar_t *l, const uint8_t *r)
{
    return is_info(r, 0) ? set_info(l, 7, "", 0) : LIAR_PASSES;
}

static liar_mail_t list_empty(liar_t *l, const uint8_t *r)
{
    return is_info(r, LIST) ? set_info(l, LIST + 1, "\x01\x00", 2) : LIAR_PASSES;
}

static liar_mail_t list_wrong(liar_t *l, const uint8_t *r)
{
    return is_info(r, LIST) ? set_info(l, LIST + 1, "\x02\x00\x00\x10", 4) : LIAR_PASSES;
}

static liar_mail_t list_without_an_end(liar_t *l, const uint8_t *r)
{
    return is_info(r, LIST) ? set_info(l, LIST + 1 + INCOMPLETE, "\x01\x00\x00\x10", 4) : LIAR_PASSES;
}

static bool more_of_the_list(liar_t *l)
{
    uint8_t indices[100];
    for (unsigned int i = 0; i < sizeof indices; i += 2)
        ect_store_le16(indices + i, (uint16_t)l->number++);
    (void)set_info(l, LIST + 1 + INCOMPLETE, indices, sizeof indices);
    return true;
}

static liar_mail_t list_of_empty_fragments(liar_t *l, const uint8_t *r)
{
    return is_info(r, LIST) ? set_info(l, LIST + 1 + INCOMPLETE, "\x01\x00", 2) : LIAR_PASSES;
}

static bool empty_fragment(liar_t *l)
{
    (void)set_info(l, LIST + 1 + INCOMPLETE, "", 0);
    return true;
}

static liar_mail_t list_ends_early(liar_t *l, const uint8_t *r)
{
    return is_info(r, LIST) ? set_info(l, LIST + 1 + INCOMPLETE, "\x01\x00\x00\x10\x08", 5) : LIAR_PASSES;
}

/* Every index there is, 50 a fragment. */
static bool every_index(liar_t *l)
{
    uint8_t indices[100];
    if (l->number >= 65500)
        return false;
    for (unsigned int i = 0; i < sizeof indices; i += 2)
        ect_store_le16(indices + i, (uint16_t)l->number++);
    (void)set_info(l, (uint8_t)(LIST + 1 + (l->number < 65500 ? INCOMPLETE : 0)), indices, sizeof indices);
    return true;
}

static liar_mail_t list_of_everything(liar_t *l, const uint8_t *r)
{
    if (is_info(r, LIST)) {
        l->number = 0;
        return set_info(l, LIST + 1 + INCOMPLETE, "\x01\x00", 2);
    }
    if (is_info(r, OBJECT)) {
        const uint8_t object[] = {r[12], r[13], 7, 0, 255, 9, 'x'};
        return set_info(l, OBJECT + 1, object, sizeof object);
    }
    if (!is_info(r, ENTRY))
        return LIAR_PASSES;
    const uint8_t entry[] = {r[12], r[13], r[14], 0, 7, 0, 32, 0, 63, 0, 'y'};
    return set_info(l, ENTRY + 1, entry, sizeof entry);
}

static liar_mail_t object_cut(liar_t *l, const uint8_t *r)
{
    return is_info(r, OBJECT) ? set_info(l, OBJECT + 1, r + 12, 2) : LIAR_PASSES;
}

static liar_mail_t object_of_another(liar_t *l, const uint8_t *r)
{
    const uint8_t other[] = {(uint8_t)(r[12] ^ 1), r[13], 7, 0, 0, 7};
    return is_info(r, OBJECT) ? set_info(l, OBJECT + 1, other, sizeof other) : LIAR_PASSES;
}

static liar_mail_t object_of_letters(liar_t *l, const uint8_t *r)
{
    const uint8_t object[] = {r[12], r[13], 7, 0, 0, 7, '"', '\\', 1, 0xE4, '\n', 0x7F, 0, 'x'};
    return is_info(r, OBJECT) ? set_info(l, OBJECT + 1, object, sizeof object) : LIAR_PASSES;
}

static liar_mail_t description_without_an_end(liar_t *l, const uint8_t *r)
{
    const uint8_t object[] = {r[12], r[13], 7, 0, 0, 7};
    return is_info(r, OBJECT) ? set_info(l, OBJECT + 1 + INCOMPLETE, object, sizeof object) : LIAR_PASSES;
}

static bool more_of_the_name(liar_t *l)
{
    (void)set_info(l, OBJECT + 1 + INCOMPLETE, "a name without an end", 21);
    return true;
}

static liar_mail_t entry_cut(liar_t *l, const uint8_t *r)
{
    return is_info(r, ENTRY) ? set_info(l, ENTRY + 1, r + 12, 9) : LIAR_PASSES;
}

static liar_mail_t entry_of_8k(liar_t *l, const uint8_t *r)
{
    const uint8_t entry[] = {r[12], r[13], r[14], 0x7F, 7, 0, 0xFF, 0xFF, 63, 0, 1, 2, 3};
    return is_info(r, ENTRY) ? set_info(l, ENTRY + 1, entry, sizeof entry) : LIAR_PASSES;
}

static liar_mail_t entry_with_all_details_and_none(liar_t *l, const uint8_t *r)
{
    const uint8_t entry[] = {r[12], r[13], r[14], 0xFF, 7, 0, 32, 0, 63, 0};
    return is_info(r, ENTRY) ? set_info(l, ENTRY + 1, entry, sizeof entry) : LIAR_PASSES;
}

/* --- controller and wire ------------------------------------------------------------------------------------------ */

typedef uint8_t bytes_t;

static bool mailbox_never_emptied(liar_t *l, bytes_t *d, uint16_t ado, bytes_t *data, uint16_t length, bytes_t *wkc)
{
    (void)data;
    (void)length;
    if (d[0] == APWR && ado == l->out_start)
        ect_store_le16(wkc, 0);
    return true;
}

static bool mailbox_full_and_unreadable(liar_t *l, bytes_t *d, uint16_t ado, bytes_t *data, uint16_t length,
                                        bytes_t *wkc)
{
    (void)length;
    if (ado == ECT_REG_SM + ECT_SM_SIZE + ECT_SM_STATUS)
        data[0] |= ECT_SM_STATUS_FULL;
    if (d[0] == APRD && ado == l->in_start)
        ect_store_le16(wkc, 0);
    return true;
}

static bool lost_after_200(liar_t *l, bytes_t *d, uint16_t ado, bytes_t *data, uint16_t length, bytes_t *wkc)
{
    (void)d;
    (void)ado;
    (void)data;
    (void)length;
    if (l->frames > 200)
        ect_store_le16(wkc, 0);
    return true;
}

static bool silent_after_200(liar_t *l, bytes_t *d, uint16_t ado, bytes_t *data, uint16_t length, bytes_t *wkc)
{
    (void)d;
    (void)ado;
    (void)data;
    (void)length;
    (void)wkc;
    return l->frames <= 200;
}

static bool other_frames(liar_t *l, bytes_t *d, uint16_t ado, bytes_t *data, uint16_t length, bytes_t *wkc)
{
    (void)ado;
    (void)data;
    (void)length;
    (void)wkc;
    d[1] ^= l->frames > 30; /* another index: a frame that came late */
    return true;
}

static bool counted_twice(liar_t *l, bytes_t *d, uint16_t ado, bytes_t *data, uint16_t length, bytes_t *wkc)
{
    (void)ado;
    (void)data;
    (void)length;
    if (d[0] != BRD && l->frames > 30)
        ect_store_le16(wkc, 2);
    return true;
}

static bool status_of(uint16_t ado, bytes_t *data, uint16_t status, uint16_t code)
{
    if (ado == ECT_REG_AL_STATUS) {
        ect_store_le16(data, status);
        ect_store_le16(data + 4, code);
    }
    return true;
}

static bool state_stuck(liar_t *l, bytes_t *d, uint16_t ado, bytes_t *data, uint16_t length, bytes_t *wkc)
{
    (void)l;
    (void)d;
    (void)length;
    (void)wkc;
    return status_of(ado, data, INIT, 0);
}

static bool state_error(liar_t *l, bytes_t *d, uint16_t ado, bytes_t *data, uint16_t length, bytes_t *wkc)
{
    (void)l;
    (void)d;
    (void)length;
    (void)wkc;
    return status_of(ado, data, INIT | ECT_AL_ERROR, 0x0016);
}

static bool state_impossible(liar_t *l, bytes_t *d, uint16_t ado, bytes_t *data, uint16_t length, bytes_t *wkc)
{
    (void)l;
    (void)d;
    (void)length;
    (void)wkc;
    return status_of(ado, data, 0xFFEF, 0xFFFF);
}

static bool state_wanders(liar_t *l, bytes_t *d, uint16_t ado, bytes_t *data, uint16_t length, bytes_t *wkc)
{
    (void)d;
    (void)length;
    (void)wkc;
    return status_of(ado, data, (uint16_t)(l->number++ % 2 == 0 ? INIT : PREOP), 0);
}

static bool eeprom(uint16_t ado, bytes_t *data, uint16_t length, uint16_t control, uint8_t byte)
{
    if (ado == ECT_REG_SII_CONTROL && length == 2)
        ect_store_le16(data, control);
    if (ado == ECT_REG_SII_DATA)
        memset(data, byte, length);
    return true;
}

static bool eeprom_busy(liar_t *l, bytes_t *d, uint16_t ado, bytes_t *data, uint16_t length, bytes_t *wkc)
{
    (void)l;
    (void)d;
    (void)wkc;
    return eeprom(ado, data, length, 0x8000, 0);
}

static bool eeprom_without_acknowledge(liar_t *l, bytes_t *d, uint16_t ado, bytes_t *data, uint16_t length,
                                       bytes_t *wkc)
{
    (void)l;
    (void)d;
    (void)wkc;
    return eeprom(ado, data, length, 0x2000, 0);
}

static bool eeprom_of_ff(liar_t *l, bytes_t *d, uint16_t ado, bytes_t *data, uint16_t length, bytes_t *wkc)
{
    (void)l;
    (void)d;
    (void)wkc;
    return eeprom(ado, data, length, 0, 0xFF);
}

static bool eeprom_of_zeros(liar_t *l, bytes_t *d, uint16_t ado, bytes_t *data, uint16_t length, bytes_t *wkc)
{
    (void)l;
    (void)d;
    (void)wkc;
    return eeprom(ado, data, length, 0, 0);
}

/* 0x03030303: 99 KiB, mailboxes of 771 bytes at 0303h, categories of type 771 that lead into each other. */
static bool eeprom_of_threes(liar_t *l, bytes_t *d, uint16_t ado, bytes_t *data, uint16_t length, bytes_t *wkc)
{
    (void)l;
    (void)d;
    (void)wkc;
    return eeprom(ado, data, length, 0, 3);
}

static bool eeprom_of_noise(liar_t *l, bytes_t *d, uint16_t ado, bytes_t *data, uint16_t length, bytes_t *wkc)
{
    (void)d;
    (void)wkc;
    l->number = l->number * 6364136223846793005u + 1442695040888963407u;
    return eeprom(ado, data, length, 0x0040, (uint8_t)(l->number >> 56));
}

/* The header's mailboxes: words 18h to 1Bh. */
static bool mailbox_of(liar_t *l, uint16_t ado, bytes_t *data, uint16_t length, uint16_t start, uint16_t size)
{
    if (ado == ECT_REG_SII_ADDRESS)
        return true;
    if (ado == ECT_REG_SII_DATA && (l->number == 0x18 || l->number == 0x1A)) {
        ect_store_le16(data, start);
        ect_store_le16(data + 2, size);
    }
    (void)length;
    return true;
}

static bool mailbox_huge(liar_t *l, bytes_t *d, uint16_t ado, bytes_t *data, uint16_t length, bytes_t *wkc)
{
    (void)wkc;
    if (d[0] == APWR && ado == ECT_REG_SII_CONTROL && length == 6)
        l->number = ect_load_le16(data + 2);
    return mailbox_of(l, ado, data, length, 0x1000, 0xFFFF);
}

static bool mailbox_in_registers(liar_t *l, bytes_t *d, uint16_t ado, bytes_t *data, uint16_t length, bytes_t *wkc)
{
    (void)wkc;
    if (d[0] == APWR && ado == ECT_REG_SII_CONTROL && length == 6)
        l->number = ect_load_le16(data + 2);
    return mailbox_of(l, ado, data, length, 0x0120, 128);
}

static bool mailbox_beyond_memory(liar_t *l, bytes_t *d, uint16_t ado, bytes_t *data, uint16_t length, bytes_t *wkc)
{
    (void)wkc;
    if (d[0] == APWR && ado == ECT_REG_SII_CONTROL && length == 6)
        l->number = ect_load_le16(data + 2);
    return mailbox_of(l, ado, data, length, 0xFFF0, 128);
}

static bool mailbox_at_the_end(liar_t *l, bytes_t *d, uint16_t ado, bytes_t *data, uint16_t length, bytes_t *wkc)
{
    (void)wkc;
    if (d[0] == APWR && ado == ECT_REG_SII_CONTROL && length == 6)
        l->number = ect_load_le16(data + 2);
    return mailbox_of(l, ado, data, length, 0x10000 - 128, 128);
}

static bool mailbox_of_no_bytes(liar_t *l, bytes_t *d, uint16_t ado, bytes_t *data, uint16_t length, bytes_t *wkc)
{
    (void)wkc;
    if (d[0] == APWR && ado == ECT_REG_SII_CONTROL && length == 6)
        l->number = ect_load_le16(data + 2);
    return mailbox_of(l, ado, data, length, 0x1000, 0);
}

/* --- the table ---------------------------------------------------------------------------------------------------- */

#define OK       ECT_READER_OK
#define ABORTED  ECT_READER_ABORTED
#define REFUSED  ECT_READER_REFUSED
#define SILENT   ECT_READER_SILENT
#define WRONG    ECT_READER_WRONG
#define TOO_LONG ECT_READER_TOO_LONG
#define LOST     ECT_READER_LOST
#define STOPPED  ECT_READER_STOPPED
enum { ANY = -1 };

static const struct row {
    liar_kind_t kind;
    int open, upload, dictionary; /* results; the upload is that of 1018h:1 */
} rows[] = {
    {{.name = "honest"}, OK, OK, OK},
    {{"upload of 4 GiB", .request = size_4g}, OK, TOO_LONG, TOO_LONG},
    {{"upload of 2 GiB", .request = size_2g}, OK, TOO_LONG, TOO_LONG},
    {{"upload of one byte more than fits", .request = size_over}, OK, TOO_LONG, TOO_LONG},
    {{"upload of no bytes", .request = size_zero}, OK, OK, OK},
    {{"upload longer than announced", .request = size_less}, OK, OK, OK},
    {{"empty segments", .request = segments_empty}, OK, TOO_LONG, WRONG},
    {{"short segments without bytes", .request = segments_short}, OK, TOO_LONG, WRONG},
    {{"segments of one byte", .request = segments_of_one}, OK, TOO_LONG, WRONG},
    {{"segments without an end", .request = segments_endless}, OK, TOO_LONG, WRONG},
    {{"toggle bit stuck", .request = toggle_stuck}, OK, TOO_LONG, WRONG},
    {{"toggle bit inverted", .request = toggle_inverted}, OK, TOO_LONG, WRONG},
    {{"last segment too early", .request = segment_last_at_once}, OK, TOO_LONG, OK},
    {{"segment without a reply", .request = segment_none}, OK, TOO_LONG, SILENT},
    {{"segment without a command", .request = segment_without_a_command}, OK, TOO_LONG, WRONG},
    {{"upload of another index", .request = wrong_index}, OK, WRONG, WRONG},
    {{"upload of another sub-index", .request = wrong_subindex}, OK, WRONG, WRONG},
    {{"unknown command", .request = wrong_command}, OK, WRONG, WRONG},
    {{"reply to a download", .request = download_reply}, OK, WRONG, WRONG},
    {{"uploads without a reply", .request = never_uploads}, OK, SILENT, SILENT},
    {{"every upload aborted", .request = always_aborts}, OK, ABORTED, OK},
    {{"abort of another object", .request = aborts_another}, OK, WRONG, WRONG},
    {{"upload reply cut off", .request = upload_cut}, OK, WRONG, WRONG},
    {{"255 entries and PDOs everywhere", .request = count_255}, OK, OK, OK},
    {{"counts of 4 thousand million", .request = count_huge}, OK, OK, OK},
    {{"mailbox error for everything", .request = mail_error}, OK, REFUSED, OK},
    {{"mailbox error cut off", .request = mail_error_cut}, OK, REFUSED, OK},
    {{"empty mails", .request = mail_empty}, OK, WRONG, WRONG},
    {{"mails of a header alone", .request = mail_header_alone}, OK, WRONG, WRONG},
    {{"mail length 65535", .reply = length_64k}, OK, WRONG, WRONG},
    {{"mail length one beyond the mailbox", .reply = length_over}, OK, WRONG, WRONG},
    {{"mail length of the whole mailbox", .reply = length_whole_mailbox}, OK, OK, ANY},
    {{"mail length 0", .reply = length_none}, OK, WRONG, WRONG},
    {{"mail length one too short", .reply = length_one_less}, OK, WRONG, WRONG},
    {{"every mail of type EoE", .reply = type_eoe}, OK, WRONG, WRONG},
    {{"counter 0", .reply = counter_none}, OK, OK, OK},
    {{"counter stuck", .reply = counter_stuck}, OK, OK, OK},
    {{"reserved bit of the counter", .reply = counter_reserved_bit}, OK, OK, OK},
    {{"unknown CoE service", .reply = service_wrong}, OK, WRONG, WRONG},
    {{"mails of noise", .reply = noise}, OK, ANY, ANY},
    {{"one bit of each mail wrong", .reply = one_bit}, OK, ANY, ANY},
    {{"emergencies without an end", .request = emergencies, .next = another_emergency}, OK, WRONG, WRONG},
    {{"EoE frames for every request", .request = frames_of_eoe}, OK, WRONG, WRONG},
    {{"the same mail again and again", .request = reply_of_before, .next = same_again}, OK, OK, ANY},
    {{"SDO information without a reply", .request = info_none}, OK, OK, SILENT},
    {{"SDO information cut off", .request = info_cut}, OK, OK, WRONG},
    {{"SDO information error cut off", .request = info_error_cut}, OK, OK, OK},
    {{"empty list", .request = list_empty}, OK, OK, OK},
    {{"another list", .request = list_wrong}, OK, OK, WRONG},
    {{"list without an end", .request = list_without_an_end, .next = more_of_the_list}, OK, OK, WRONG},
    {{"list of empty fragments", .request = list_of_empty_fragments, .next = empty_fragment}, OK, OK, WRONG},
    {{"list that ends early", .request = list_ends_early}, OK, OK, SILENT},
    {{"list of every index", .request = list_of_everything, .next = every_index}, OK, OK, STOPPED},
    {{"object description cut off", .request = object_cut}, OK, OK, WRONG},
    {{"description of another object", .request = object_of_another}, OK, OK, WRONG},
    {{"names of any bytes", .request = object_of_letters}, OK, OK, OK},
    {{"description without an end", .request = description_without_an_end, .next = more_of_the_name}, OK, OK, WRONG},
    {{"entry description cut off", .request = entry_cut}, OK, OK, WRONG},
    {{"entries of 65535 bits", .request = entry_of_8k}, OK, OK, OK},
    {{"entries without the details announced", .request = entry_with_all_details_and_none}, OK, OK, OK},
    {{"mailbox never emptied", .datagram = mailbox_never_emptied}, OK, SILENT, SILENT},
    {{"mailbox full and unreadable", .datagram = mailbox_full_and_unreadable}, OK, SILENT, SILENT},
    {{"gone after 200 frames", .datagram = lost_after_200}, OK, ANY, LOST},
    {{"silent after 200 frames", .datagram = silent_after_200}, OK, ANY, LOST},
    {{"frames of another index", .datagram = other_frames}, LOST, ANY, ANY},
    {{"working counter 2", .datagram = counted_twice}, LOST, ANY, ANY},
    {{"state that never changes", .datagram = state_stuck}, OK, SILENT, SILENT},
    {{"state that is refused", .datagram = state_error}, OK, REFUSED, REFUSED},
    {{"impossible state", .datagram = state_impossible}, OK, SILENT, SILENT},
    {{"state that wanders", .datagram = state_wanders}, OK, ANY, ANY},
    {{"EEPROM always busy", .datagram = eeprom_busy}, SILENT, ANY, ANY},
    {{"EEPROM without acknowledge", .datagram = eeprom_without_acknowledge}, WRONG, ANY, ANY},
    {{"EEPROM of FFh", .datagram = eeprom_of_ff}, OK, WRONG, WRONG},
    {{"EEPROM of zeros", .datagram = eeprom_of_zeros}, OK, WRONG, OK},
    {{"EEPROM of 03h", .datagram = eeprom_of_threes}, OK, WRONG, OK},
    {{"EEPROM of noise", .datagram = eeprom_of_noise}, OK, ANY, ANY},
    {{"mailbox of 65535 bytes", .datagram = mailbox_huge}, OK, WRONG, WRONG},
    {{"mailbox over AL control", .datagram = mailbox_in_registers}, OK, WRONG, WRONG},
    {{"mailbox beyond the memory", .datagram = mailbox_beyond_memory}, OK, WRONG, WRONG},
    {{"mailbox at the last addresses", .datagram = mailbox_at_the_end}, OK, REFUSED, REFUSED},
    {{"mailbox of no bytes", .datagram = mailbox_of_no_bytes}, OK, WRONG, WRONG},
};

static void expect(const struct row *row, const char *call, int expected, ect_reader_result_t result)
{
    if (expected != ANY && expected != (int)result)
        fail_msg("%s: %s returned %d (%s), expected %d", row->kind.name, call, (int)result, reader.text, expected);
    if ((result == OK) != (reader.text[0] == '\0'))
        fail_msg("%s: %s returned %d with the text '%s'", row->kind.name, call, (int)result, reader.text);
}

/* The result of `ectwin verify`: facts, from any replies. */
static void make_facts(size_t size, const char *json)
{
    ect_facts_t known = {.source = "EEPROM"}, found = {.source = "dictionary"};
    FILE *nowhere = fopen("/dev/null", "w");
    ect_facts_of_sii(&known, image, size);
    assert_true(ect_facts_of_dictionary(&found, json));
    (void)ect_facts_compare(&known, &found, nowhere);
    (void)fclose(nowhere);
    ect_facts_free(&known);
    ect_facts_free(&found);
}

enum { LIMIT_MS = 6000, CLOSING_MS = 2000 };

static void lie(const struct row *row)
{
    const ect_reader_config_t config = {.limit_ms = LIMIT_MS, .reply_ms = 100, .state_ms = 500};
    uint8_t value[4];
    size_t bytes = sizeof value, size = 0, length = 0;
    char *json = NULL;
    liar_t l;
    liar_open(&l, &testdev, &row->kind);
    const uint64_t begin = l.w.now_ns;
    expect(row, "open", row->open, ect_reader_open(&reader, &l.link, &config));
    (void)ect_reader_sii_content(&reader, image, &size);
    (void)ect_reader_sii(&reader, image, 0, &size);
    expect(row, "upload", row->upload, ect_reader_upload(&reader, 0x1018, 1, false, value, &bytes));
    FILE *file = open_memstream(&json, &length);
    const ect_reader_result_t result = ect_reader_json(&reader, ECT_READER_IDENTITY_AND_PDOS, file);
    assert_int_equal(fclose(file), 0);
    expect(row, "dictionary", row->dictionary, result);
    cJSON *root = cJSON_Parse(json);
    if (root == NULL)
        fail_msg("%s: no JSON: %s", row->kind.name, json);
    assert_int_equal(cJSON_IsTrue(cJSON_GetObjectItem(root, "complete")), result == OK);
    cJSON_Delete(root);
    make_facts(size, json);
    free(json);
    ect_reader_close(&reader);
    if (l.w.now_ns - begin > (uint64_t)(LIMIT_MS + CLOSING_MS) * MS)
        fail_msg("%s: took %u ms", row->kind.name, (unsigned int)((l.w.now_ns - begin) / MS));
    liar_close(&l);
}

static void whatever_a_slave_does_the_reader_ends_in_time(void **state)
{
    (void)state;
    assert_true(sizeof rows / sizeof rows[0] >= 38);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
        lie(&rows[i]);
}

static void any_bytes_in_any_mail_are_survived(void **state)
{
    static const struct row row = {{"noise", .reply = noise}, OK, ANY, ANY};
    (void)state;
    for (unsigned int i = 0; i < 20; i++)
        lie(&row);
}

/* --- patience ----------------------------------------------------------------------------------------------------- */

/* The first reply again, with its counter, then the second. */
static liar_mail_t first_again(liar_t *l, const uint8_t *r)
{
    if (!is_upload(r))
        return LIAR_PASSES;
    return l->number++ == 0 ? set_upload(l, r, 0x43, 1, 0) : LIAR_REPLIES;
}

static bool then_second(liar_t *l)
{
    static const uint8_t second[] = {0x43, 0x18, 0x10, 1, 2, 0, 0, 0};
    if (l->number++ != 2)
        return false;
    liar_set_coe_mail(l, RESPONSE, second, sizeof second);
    return true;
}

static void a_mail_that_is_sent_again_is_no_reply(void **state)
{
    static const liar_kind_t kind = {"again", .request = first_again, .next = then_second};
    uint8_t value[4];
    liar_t l;
    (void)state;
    liar_open(&l, &testdev, &kind);
    assert_int_equal(ect_reader_open(&reader, &l.link, NULL), OK);
    for (uint32_t upload = 1; upload <= 2; upload++) {
        size_t size = sizeof value;
        assert_int_equal(ect_reader_upload(&reader, 0x1018, 1, false, value, &size), OK);
        assert_int_equal(ect_load_le32(value), upload);
        l.number = upload == 1 ? 1 : l.number; /* the end of the first mail counted, too */
    }
    assert_int_equal(reader.skipped, 1);
    ect_reader_close(&reader);
    liar_close(&l);
}

static void ignore_object(void *ctx, const ect_reader_object_t *object)
{
    (void)object;
    (*(unsigned int *)ctx)++;
}

static void ignore_entry(void *ctx, const ect_reader_object_t *object, const ect_reader_entry_t *entry)
{
    (void)ctx;
    (void)object;
    (void)entry;
}

static liar_mail_t silent_from_mail_10(liar_t *l, const uint8_t *r)
{
    (void)r;
    return l->mails > 10 ? LIAR_SWALLOWS : LIAR_PASSES;
}

static void three_requests_without_a_reply_end_a_dictionary(void **state)
{
    static const liar_kind_t kind = {"silent", .request = silent_from_mail_10};
    unsigned int objects = 0;
    const ect_reader_sink_t sink = {.ctx = &objects, .object = ignore_object, .entry = ignore_entry};
    liar_t l;
    (void)state;
    liar_open(&l, &testdev, &kind);
    assert_int_equal(ect_reader_open(&reader, &l.link, NULL), OK);
    assert_int_equal(ect_reader_dictionary(&reader, ECT_READER_IDENTITY_AND_PDOS, &sink), SILENT);
    assert_true(objects > 0);
    assert_int_equal(l.mails, 10 + 3 * 3); /* three tries of three requests */
    ect_reader_close(&reader);
    liar_close(&l);
}

/* Two of three uploads stay without a reply: never three in succession. */
static liar_mail_t two_of_three_silent(liar_t *l, const uint8_t *r)
{
    if (!is_upload(r))
        return LIAR_PASSES;
    return l->number++ % 3 == 2 ? LIAR_PASSES : LIAR_SWALLOWS;
}

static void values_are_given_up_after_three_uploads_in_a_row_only(void **state)
{
    static const liar_kind_t some = {"some", .request = two_of_three_silent}, none = {"none", .request = never_uploads};
    const ect_reader_config_t once = {.tries = 1, .reply_ms = 20};
    const struct {
        const liar_kind_t *kind;
        unsigned int uploads;
    } cases[] = {{NULL, 19}, {&some, 19}, {&none, 3}};
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        unsigned int objects = 0;
        const ect_reader_sink_t sink = {.ctx = &objects, .object = ignore_object, .entry = ignore_entry};
        liar_t l, without;
        liar_open(&without, &testdev, cases[i].kind);
        assert_int_equal(ect_reader_open(&reader, &without.link, &once), OK);
        (void)ect_reader_dictionary(&reader, ECT_READER_IDENTITY_AND_PDOS, &sink);
        assert_int_equal(objects, testdev.object_count);
        ect_reader_close(&reader);
        const unsigned int mails = without.mails;
        liar_close(&without);
        liar_open(&l, &testdev, NULL); /* the mails of an honest slave, less its 19 uploads */
        assert_int_equal(ect_reader_open(&reader, &l.link, &once), OK);
        assert_int_equal(ect_reader_dictionary(&reader, ECT_READER_IDENTITY_AND_PDOS, &sink), OK);
        ect_reader_close(&reader);
        assert_int_equal(mails, l.mails - 19 + cases[i].uploads);
        liar_close(&l);
    }
}

/* --- the wire ends at each step ----------------------------------------------------------------------------------- */

static bool cut_from(liar_t *l, bytes_t *d, uint16_t ado, bytes_t *data, uint16_t length, bytes_t *wkc)
{
    (void)d;
    (void)ado;
    (void)data;
    (void)length;
    (void)wkc;
    return l->frames < l->number;
}

static bool lost_once(liar_t *l, bytes_t *d, uint16_t ado, bytes_t *data, uint16_t length, bytes_t *wkc)
{
    (void)d;
    (void)ado;
    (void)data;
    (void)length;
    (void)wkc;
    return l->frames != l->number;
}

/* @return the first result that is not ECT_READER_OK, else that */
static ect_reader_result_t read_all(liar_t *l, const ect_reader_config_t *config)
{
    uint8_t value[1000];
    size_t bytes = sizeof value, size = 0;
    FILE *nowhere = fopen("/dev/null", "w");
    assert_non_null(nowhere);
    ect_reader_result_t result = ect_reader_open(&reader, &l->link, config);
    if (result == OK)
        result = ect_reader_sii(&reader, image, 64, &size);
    if (result == OK)
        result = ect_reader_upload(&reader, 0x2002, 0, false, value, &bytes);
    if (result == OK)
        result = ect_reader_json(&reader, ECT_READER_IDENTITY_AND_PDOS, nowhere);
    assert_int_equal(fclose(nowhere), 0);
    assert_true((result == OK) == (reader.text[0] == '\0'));
    ect_reader_close(&reader);
    assert_false(reader.brought_up);
    return result;
}

/* Each of the first frames, then some on the way. */
static unsigned int next_step(unsigned int frame)
{
    return frame < 300 ? frame + 1 : frame + 61;
}

static void at_each_frame(bool (*datagram)(liar_t *, bytes_t *, uint16_t, bytes_t *, uint16_t, bytes_t *),
                          unsigned int tries, bool must_fail)
{
    const liar_kind_t kind = {.name = "cut", .datagram = datagram};
    const ect_reader_config_t config = {
        .tries = tries, .frame_ms = 1, .reply_ms = 5, .state_ms = 10, .limit_ms = 60000};
    unsigned int frames = 0;
    liar_t l;
    liar_open(&l, &testdev, NULL);
    assert_int_equal(read_all(&l, &config), OK);
    frames = l.frames - 10; /* the last ones close the reader */
    liar_close(&l);
    for (unsigned int frame = 1; frame < frames; frame = next_step(frame)) {
        liar_open(&l, &testdev, &kind);
        l.number = frame;
        const ect_reader_result_t result = read_all(&l, &config);
        if (must_fail && result == OK)
            fail_msg("a wire that is cut at frame %u of %u: nothing was noticed", frame, frames);
        if (!must_fail && tries > 1 && result != OK)
            fail_msg("frame %u of %u was lost: %s", frame, frames, reader.text);
        liar_close(&l);
    }
}

static void a_wire_that_is_cut_at_any_frame_is_noticed(void **state)
{
    (void)state;
    at_each_frame(cut_from, 1, true);
}

static void any_one_frame_may_be_lost(void **state)
{
    (void)state;
    at_each_frame(lost_once, 1, false);
    at_each_frame(lost_once, 3, false);
}

static void a_limit_may_pass_at_any_time(void **state)
{
    (void)state;
    for (uint32_t limit = 1; limit < 25; limit++) {
        const ect_reader_config_t config = {.limit_ms = limit};
        liar_t l;
        liar_open(&l, &testdev, NULL);
        const uint64_t begin = l.w.now_ns;
        const ect_reader_result_t result = read_all(&l, &config);
        assert_true(result == OK || result == STOPPED);
        if (result == STOPPED)
            assert_non_null(strstr(reader.text, "not finished within"));
        assert_true(l.w.now_ns - begin < (limit + 10) * MS);
        liar_close(&l);
    }
}

/* Category headers that lead nowhere, into themselves, or beyond the end. */
static void images_of_any_bytes_are_facts_or_nothing(void **state)
{
    static const uint16_t lengths[] = {0, 1, 0x0FFF, 0x7FFF, 0x8000, 0xFFFE, 0xFFFF};
    static const uint16_t types[] = {10, 30, 40, 41, 50, 51, 60, 0, 0x8000, 0xFFFE};
    (void)state;
    for (size_t t = 0; t < sizeof types / sizeof types[0]; t++) {
        for (size_t n = 0; n < sizeof lengths / sizeof lengths[0]; n++) {
            for (size_t at = 0; at + 4 <= 4096; at += 4) {
                ect_store_le16(image + at, types[t]);
                ect_store_le16(image + at + 2, lengths[n]);
            }
            for (size_t size = 0; size <= 4096; size = size == 0 ? 127 : size * 2 + (size & 1))
                make_facts(size, "{\"objects\": []}");
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(whatever_a_slave_does_the_reader_ends_in_time),
        cmocka_unit_test(any_bytes_in_any_mail_are_survived),
        cmocka_unit_test(a_mail_that_is_sent_again_is_no_reply),
        cmocka_unit_test(three_requests_without_a_reply_end_a_dictionary),
        cmocka_unit_test(values_are_given_up_after_three_uploads_in_a_row_only),
        cmocka_unit_test(a_wire_that_is_cut_at_any_frame_is_noticed),
        cmocka_unit_test(any_one_frame_may_be_lost),
        cmocka_unit_test(a_limit_may_pass_at_any_time),
        cmocka_unit_test(images_of_any_bytes_are_facts_or_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
