/* SPDX-License-Identifier: MIT */
/* CF-S01 to CF-S06: servo drive profile over EtherCAT, with any drive: the list of its IDNs is S-0-0017. */
#include <string.h>

#include "cases/beyond.h"

enum { READ = 1, WRITE = 3, OPERATION = 0x07, INCOMPLETE = 0x08, FAILED = 0x10, HEADER = 4, LENGTHS = 4, DRIVES = 8 };
enum { STATE = 0x01, NAME = 0x02, ATTRIBUTE = 0x04, MINIMUM = 0x10, MAXIMUM = 0x20, VALUE = 0x40, ALL = 0xFF };
enum { AT_LIST = 16, ALL_IDNS = 17, MDT_LIST = 24, NO_IDN = 0xFFFF };
enum { UNKNOWN_IDN = 0x1001, TOO_SHORT = 0x7002, TOO_LONG = 0x7003, TOO_LOW = 0x7006, TOO_HIGH = 0x7007 };
enum { INVALID = 0x7008, NO_DRIVE = 0x800A, ERROR_TOO_SHORT = 6, GENERAL = 30, CHANNELS = 8 };
enum { LIST = 1 << 18, COMMAND = 1 << 19, KIND = 7 << 20, UNSIGNED = 1 << 20, SIGNED = 2 << 20, LOCK_PREOP = 1 << 28 };
enum { ROOM = 4096, QUIET_MS = 20 };

/* An element, or several, of an IDN of a drive. */
typedef struct place {
    uint8_t drive, elements;
    uint16_t idn;
} place_t;

/* The reply to a read, in one mail or several. */
typedef struct answer {
    uint16_t length;
    uint8_t elements;
    unsigned int mails;
    bool counted; /* each mail but the last one has the number of those behind it */
    uint8_t data[ROOM];
} answer_t;

static void need(cf_t *c)
{
    if ((c->facts.protocols & CF_PROTO_SOE) == 0)
        cf_skip(c, "the slave has no SoE");
    cf_go(c, CF_PREOP);
}

/* @return the number of drives that the SII names */
static unsigned int drives_of(const cf_t *c)
{
    size_t length = 0;
    const uint8_t *general = cf_sii_category(c, GENERAL, &length);
    return general && length > CHANNELS && general[CHANNELS] != 0 ? general[CHANNELS] : 1;
}

static void send(cf_t *c, const place_t *p, uint8_t operation, const uint8_t *value, size_t length)
{
    uint8_t mail[CF_MAX_MAIL] = {0};
    mail[0] = (uint8_t)(operation | p->drive << 5);
    mail[1] = p->elements;
    ect_store_le16(mail + 2, p->idn);
    if (length > 0)
        memcpy(mail + HEADER, value, length);
    cf_send_mail(c, CF_MBX_SOE, mail, (uint16_t)(HEADER + length));
}

/* Receives a mail of the reply. @return the error code, 0: none */
static uint16_t receive(cf_t *c, const place_t *p, uint8_t operation, cf_mail_t *mail)
{
    cf_receive(c, CF_MBX_SOE, mail);
    cf_expect_range(c, "bytes of the reply", HEADER, CF_MAX_MAIL, mail->length);
    cf_expect(c, "operation of the reply", operation + 1u, mail->data[0] & OPERATION);
    cf_expect(c, "drive of the reply", p->drive, mail->data[0] >> 5);
    if ((mail->data[0] & INCOMPLETE) == 0)
        cf_expect(c, "IDN of the reply", p->idn, ect_load_le16(mail->data + 2));
    if ((mail->data[0] & FAILED) == 0)
        return 0;
    cf_expect(c, "bytes of a reply with an error", HEADER + 2, mail->length);
    return ect_load_le16(mail->data + HEADER);
}

static void append(cf_t *c, answer_t *a, const cf_mail_t *mail)
{
    const uint16_t bytes = (uint16_t)(mail->length - HEADER);
    cf_expect_range(c, "bytes of all mails of the reply", 0, ROOM, (uint64_t)a->length + bytes);
    memcpy(a->data + a->length, mail->data + HEADER, bytes);
    a->length = (uint16_t)(a->length + bytes);
    a->mails++;
}

/* @return the error code, 0: none */
static uint16_t read_idn(cf_t *c, const place_t *p, answer_t *a)
{
    cf_mail_t mail;
    unsigned int behind = 0;
    a->length = 0;
    a->mails = 0;
    a->counted = true;
    send(c, p, READ, NULL, 0);
    for (bool more = true; more;) {
        const uint16_t code = receive(c, p, READ, &mail);
        if (code != 0)
            return code;
        more = (mail.data[0] & INCOMPLETE) != 0;
        const unsigned int count = more ? ect_load_le16(mail.data + 2) : 0;
        a->counted = a->counted && (a->mails == 0 ? more == (count > 0) : count + 1 == behind);
        behind = count;
        append(c, a, &mail);
    }
    a->elements = mail.data[1];
    return 0;
}

static void expect_read(cf_t *c, const place_t *p, answer_t *a)
{
    const uint16_t code = read_idn(c, p, a);
    cf_expect_that(c, code == 0, "read of IDN %04Xh, drive %u, elements %02Xh: expected no error, got 0x%04X", p->idn,
                   p->drive, p->elements, code);
}

static uint16_t write_idn(cf_t *c, const place_t *p, const uint8_t *value, size_t length)
{
    cf_mail_t mail;
    send(c, p, WRITE, value, length);
    return receive(c, p, WRITE, &mail);
}

static unsigned int width_of(uint32_t attribute)
{
    return 1u << (attribute >> 16 & 3u);
}

/* S-0-0017 of a drive. @return its number of IDNs; those behind the 4 bytes of lengths in `a` */
static unsigned int list_idns(cf_t *c, uint8_t drive, answer_t *a)
{
    expect_read(c, &(place_t){drive, VALUE, ALL_IDNS}, a);
    cf_expect_range(c, "bytes of S-0-0017", LENGTHS, ROOM, a->length);
    cf_expect(c, "present length of S-0-0017", (uint64_t)a->length - LENGTHS, ect_load_le16(a->data));
    return ect_load_le16(a->data) / 2u;
}

static uint16_t idn_at(const answer_t *list, unsigned int n)
{
    return ect_load_le16(list->data + LENGTHS + 2u * (size_t)n);
}

/* Whether a drive has S-0-0017, which is not every one's. */
static bool has_list(cf_t *c, uint8_t drive, answer_t *a)
{
    return read_idn(c, &(place_t){drive, VALUE, ALL_IDNS}, a) == 0 && list_idns(c, drive, a) > 0;
}

static void need_list(cf_t *c, answer_t *a)
{
    need(c);
    if (!has_list(c, 0, a))
        cf_skip(c, "drive 0 has no list of its IDNs, S-0-0017");
}

/* --- CF-S01 ------------------------------------------------------------------------------------------------------- */

void cf_soe_refusals(cf_t *c)
{
    answer_t a;
    cf_mail_t mail;
    need_list(c, &a);
    cf_step(c, "a read of an IDN that no drive has");
    cf_expect(c, "error code", UNKNOWN_IDN, read_idn(c, &(place_t){0, VALUE, NO_IDN}, &a));
    cf_step(c, "a read of no element");
    const uint16_t code = read_idn(c, &(place_t){0, 0, ALL_IDNS}, &a);
    cf_expect_that(c, code != 0, "a read of no element: expected an error, got 0x0000");
    cf_step(c, "a mail of 3 bytes");
    cf_send_mail(c, CF_MBX_SOE, (const uint8_t[]){READ, VALUE, ALL_IDNS}, 3);
    cf_expect_mail_error(c, ERROR_TOO_SHORT);
    cf_step(c, "operation 7");
    send(c, &(place_t){0, VALUE, ALL_IDNS}, OPERATION, NULL, 0);
    cf_receive(c, CF_MBX_ERROR, &mail);
    cf_step(c, "a read after them");
    (void)list_idns(c, 0, &a);
}

/* --- CF-S02 ------------------------------------------------------------------------------------------------------- */

/* The attribute, then a value of the length that it states. */
static void expect_lengths(cf_t *c, uint16_t idn, const answer_t *a)
{
    cf_expect_range(c, "bytes of attribute and value", LENGTHS + 1, ROOM, a->length);
    const uint32_t attribute = ect_load_le32(a->data);
    const unsigned int bytes = a->length - 4u;
    if ((attribute & LIST) == 0) {
        cf_expect_that(c, bytes == width_of(attribute), "IDN %04Xh: expected %u bytes of value, got %u", idn,
                       width_of(attribute), bytes);
        return;
    }
    cf_expect_range(c, "bytes of a list with its lengths", LENGTHS, ROOM, bytes);
    const unsigned int used = ect_load_le16(a->data + 4);
    cf_expect_that(c, used == bytes - LENGTHS && used <= ect_load_le16(a->data + 6) && used % width_of(attribute) == 0,
                   "IDN %04Xh: a list of %u of at most %u bytes, but %u follow", idn, used, ect_load_le16(a->data + 6),
                   bytes - LENGTHS);
}

/* All elements together are those of the single reads. */
static void expect_elements(cf_t *c, uint16_t idn, answer_t *a)
{
    answer_t all;
    unsigned int at = 0;
    expect_read(c, &(place_t){0, ALL, idn}, &all);
    for (unsigned int element = 0; element < 8; element++) {
        const place_t one = {0, (uint8_t)(1u << element), idn};
        const uint16_t code = read_idn(c, &one, a);
        cf_expect_that(c, (code == 0) == ((all.elements & one.elements) != 0),
                       "IDN %04Xh, element %u: error 0x%04X alone, but elements %02Xh together", idn, element + 1, code,
                       all.elements);
        if (code != 0)
            continue;
        cf_expect_that(c, a->length <= all.length - at, "IDN %04Xh: element %u is shorter together", idn, element + 1);
        if (one.elements != VALUE && one.elements != STATE) /* these change */
            cf_expect_bytes(c, "an element together with others", a->data, all.data + at, a->length);
        at += a->length;
    }
    cf_expect_that(c, at == all.length, "IDN %04Xh: expected %u bytes of all elements, got %u", idn, at, all.length);
}

void cf_soe_elements(cf_t *c)
{
    answer_t list, a;
    need_list(c, &list);
    const unsigned int count = list_idns(c, 0, &list);
    for (unsigned int n = 0; n < count; n++) {
        const uint16_t idn = idn_at(&list, n);
        cf_step(c, "IDN %04Xh", idn);
        cf_expect_that(c, n == 0 || idn_at(&list, n - 1) < idn, "S-0-0017: IDN %04Xh is not above the one before", idn);
        expect_read(c, &(place_t){0, ATTRIBUTE | VALUE, idn}, &a);
        expect_lengths(c, idn, &a);
        expect_elements(c, idn, &a);
    }
    cf_note(c, "%u IDNs", count);
}

/* --- CF-S03 ------------------------------------------------------------------------------------------------------- */

/* A writable number with at least two bytes, attribute and value in `a`. @return its IDN, NO_IDN: none */
static uint16_t find_number(cf_t *c, const answer_t *list, unsigned int count, answer_t *a)
{
    for (unsigned int n = 0; n < count; n++) {
        const place_t p = {0, ATTRIBUTE | VALUE, idn_at(list, n)};
        expect_read(c, &p, a);
        const uint32_t attribute = ect_load_le32(a->data);
        const bool number = (attribute & (LIST | COMMAND | LOCK_PREOP)) == 0 && width_of(attribute) >= 2;
        if (number && write_idn(c, &(place_t){0, VALUE, p.idn}, a->data + 4, width_of(attribute)) == 0)
            return p.idn;
    }
    return NO_IDN;
}

static void expect_unchanged(cf_t *c, uint16_t idn, const uint8_t *value, unsigned int width)
{
    answer_t a;
    expect_read(c, &(place_t){0, VALUE, idn}, &a);
    cf_expect(c, "bytes of the value after a refused write", width, a.length);
    cf_expect_bytes(c, "value after a refused write", value, a.data, width);
}

/* Writes one beyond the limit of an element, where numbers have one more. */
static void beyond_limit(cf_t *c, uint16_t idn, uint8_t element, uint32_t attribute)
{
    answer_t limit;
    const unsigned int width = width_of(attribute);
    const unsigned int kind = attribute & KIND;
    if ((kind != UNSIGNED && kind != SIGNED) || read_idn(c, &(place_t){0, element, idn}, &limit) != 0)
        return;
    const uint64_t all = width == 8 ? UINT64_MAX : (1ull << 8 * width) - 1;
    const uint64_t lowest = kind == SIGNED ? all / 2 + 1 : 0;
    uint8_t value[8] = {0};
    memcpy(value, limit.data, width);
    uint64_t number = ect_load_le64(value);
    if (number == (element == MINIMUM ? lowest : (lowest - 1) & all))
        return;
    number = element == MINIMUM ? number - 1 : number + 1;
    ect_store_le64(value, number);
    cf_step(c, "a value beyond the %s of IDN %04Xh", element == MINIMUM ? "minimum" : "maximum", idn);
    cf_expect(c, "error code", element == MINIMUM ? TOO_LOW : TOO_HIGH,
              write_idn(c, &(place_t){0, VALUE, idn}, value, width));
}

void cf_soe_writes(cf_t *c)
{
    answer_t list, a;
    uint8_t value[9] = {0};
    need_list(c, &list);
    const uint16_t idn = find_number(c, &list, list_idns(c, 0, &list), &a);
    if (idn == NO_IDN)
        cf_skip(c, "drive 0 has no number of 16 bits or more that can be written in PREOP");
    const uint32_t attribute = ect_load_le32(a.data);
    const unsigned int width = width_of(attribute);
    const place_t p = {0, VALUE, idn};
    memcpy(value, a.data + 4, width);
    cf_step(c, "a byte less than IDN %04Xh has", idn);
    cf_expect(c, "error code", TOO_SHORT, write_idn(c, &p, value, width - 1));
    cf_step(c, "a byte more than IDN %04Xh has", idn);
    cf_expect(c, "error code", TOO_LONG, write_idn(c, &p, value, width + 1));
    beyond_limit(c, idn, MINIMUM, attribute);
    beyond_limit(c, idn, MAXIMUM, attribute);
    cf_step(c, "a name for IDN %04Xh", idn);
    const uint16_t code = write_idn(c, &(place_t){0, NAME, idn}, (const uint8_t[LENGTHS]){0}, LENGTHS);
    cf_expect_that(c, code != 0, "a write of the name: expected an error, got 0x0000");
    expect_unchanged(c, idn, value, width);
    cf_note(c, "IDN %04Xh", idn);
}

/* --- CF-S04 ------------------------------------------------------------------------------------------------------- */

void cf_soe_drives(cf_t *c)
{
    static const uint16_t lists[] = {MDT_LIST, AT_LIST};
    answer_t a;
    need(c);
    const unsigned int drives = drives_of(c);
    for (unsigned int drive = 0; drive < DRIVES; drive++) {
        for (size_t i = 0; i < 2; i++) {
            cf_step(c, "S-0-%04u of drive %u of %u", lists[i], drive, drives);
            const uint16_t code = read_idn(c, &(place_t){(uint8_t)drive, VALUE, lists[i]}, &a);
            if (drive < drives)
                cf_expect_that(c, code != NO_DRIVE, "drive %u of %u: expected no error 0x800A", drive, drives);
            else
                cf_expect(c, "error code of a drive that the slave does not have", NO_DRIVE, code);
        }
    }
    cf_note(c, "%u drives", drives);
}

/* --- CF-S05 ------------------------------------------------------------------------------------------------------- */

/* An IDN whose elements do not fit one mail. @return whether there is one */
static bool find_long(cf_t *c, answer_t *a, place_t *p)
{
    answer_t list;
    const unsigned int count = list_idns(c, 0, &list);
    for (unsigned int n = 0; n < count; n++) {
        *p = (place_t){0, ALL, idn_at(&list, n)};
        expect_read(c, p, a);
        cf_expect_that(c, a->counted, "IDN %04Xh: the mails of its reply do not count down", p->idn);
        if (a->mails > 1)
            return true;
    }
    return false;
}

/* A read that begins before the reply to another has been fetched: a mail of that reply may have been under way. */
static void read_in_between(cf_t *c, const place_t *longer)
{
    const place_t next = {0, ATTRIBUTE, ALL_IDNS};
    cf_mail_t mail;
    cf_step(c, "a read while the reply to another is in pieces");
    send(c, longer, READ, NULL, 0);
    (void)receive(c, longer, READ, &mail);
    send(c, &next, READ, NULL, 0);
    cf_receive(c, CF_MBX_SOE, &mail);
    if (mail.data[1] != next.elements)
        (void)receive(c, &next, READ, &mail);
    cf_expect(c, "elements of the reply to the second read", next.elements, mail.data[1]);
    cf_expect(c, "IDN of the reply to the second read", next.idn, ect_load_le16(mail.data + 2));
    cf_expect_no_mail(c, QUIET_MS);
}

/* The same list again, two bytes a mail; SOEM counts one piece too many. */
static void write_in_pieces(cf_t *c, uint16_t idn)
{
    answer_t a, after;
    const place_t p = {0, VALUE, idn};
    cf_mail_t mail;
    if (read_idn(c, &p, &a) != 0 || a.length <= LENGTHS || write_idn(c, &p, a.data, a.length) != 0)
        return;
    cf_step(c, "a write to S-0-%04u in pieces", idn);
    for (unsigned int at = 0; at < a.length; at += 2) {
        const unsigned int left = a.length - at;
        const place_t piece = {0, VALUE, left <= 2 ? idn : (uint16_t)(left / 2)};
        send(c, &piece, left <= 2 ? WRITE : WRITE | INCOMPLETE, a.data + at, left < 2 ? left : 2);
        if (left > 2)
            cf_expect_no_mail(c, 1);
    }
    cf_expect(c, "error code of the write in pieces", 0, receive(c, &p, WRITE, &mail));
    expect_read(c, &p, &after);
    cf_expect(c, "bytes of the list that was written", a.length, after.length);
    cf_expect_bytes(c, "the list that was written", a.data, after.data, a.length);
}

void cf_soe_pieces(cf_t *c)
{
    answer_t a;
    place_t longer;
    need_list(c, &a);
    write_in_pieces(c, MDT_LIST);
    write_in_pieces(c, AT_LIST);
    if (find_long(c, &a, &longer)) {
        cf_note(c, "a reply of %u bytes in %u mails", a.length, a.mails);
        read_in_between(c, &longer);
    } else {
        cf_warn(c, "no reply is longer than a mail: replies in pieces cannot be judged");
    }
}

/* --- CF-S06 ------------------------------------------------------------------------------------------------------- */

/* Bits of a drive's MDT or AT as SOEM counts them: the word, and each IDN of the list that is no list itself. */
static unsigned int count_bits(cf_t *c, uint8_t drive, uint16_t list)
{
    answer_t a, attribute;
    unsigned int bits = 16;
    if (read_idn(c, &(place_t){drive, VALUE, list}, &a) != 0 || a.length <= LENGTHS)
        return 0;
    for (unsigned int n = 0; n < (a.length - (unsigned int)LENGTHS) / 2; n++) {
        expect_read(c, &(place_t){drive, ATTRIBUTE, idn_at(&a, n)}, &attribute);
        cf_expect(c, "bytes of an attribute", 4, attribute.length);
        const uint32_t value = ect_load_le32(attribute.data);
        bits += (value & LIST) != 0 ? 0 : 8 * width_of(value);
    }
    return bits;
}

/* S-0-0017 itself cannot be process data: it is a list. */
static void refuse_list(cf_t *c, uint16_t list)
{
    static const uint8_t wrong[] = {2, 0, 2, 0, ALL_IDNS, 0};
    answer_t before, after;
    const place_t p = {0, VALUE, list};
    if (read_idn(c, &p, &before) != 0 || write_idn(c, &p, before.data, before.length) != 0)
        return;
    cf_step(c, "S-0-0017 as process data in S-0-%04u", list);
    cf_expect(c, "error code", INVALID, write_idn(c, &p, wrong, sizeof wrong));
    expect_read(c, &p, &after);
    cf_expect(c, "bytes of the list after a refused write", before.length, after.length);
    cf_expect_bytes(c, "the list after a refused write", before.data, after.data, before.length);
}

void cf_soe_process_data(cf_t *c)
{
    unsigned int out = 0, in = 0;
    need(c);
    for (unsigned int drive = 0; drive < drives_of(c); drive++) {
        out += count_bits(c, (uint8_t)drive, MDT_LIST);
        in += count_bits(c, (uint8_t)drive, AT_LIST);
    }
    if (out == 0 && in == 0)
        cf_skip(c, "no drive has S-0-0016 or S-0-0024 with an IDN");
    cf_step(c, "the sizes from S-0-0024 and S-0-0016 of all drives");
    cf_expect(c, "bytes of the outputs", c->facts.output_bytes, (out + 7) / 8);
    cf_expect(c, "bytes of the inputs", c->facts.input_bytes, (in + 7) / 8);
    refuse_list(c, MDT_LIST);
    refuse_list(c, AT_LIST);
    cf_go(c, CF_OP);
}
