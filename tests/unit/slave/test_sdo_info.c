/* SPDX-License-Identifier: MIT */
/* SDO information: object lists, object and entry descriptions, errors (spec E.5, E.6). */
#include <string.h>

#include "support/every.h"
#include "support/testdev.h"
#include "support/wire.h"

enum { HEADER = 6, SHORTEST_IN = 34, LONGEST_IN = 256, MOST_OBJECTS = 300 };
enum { NO_MAIL = -1, MAILBOX_ERROR = -2 };

/* --- a session: SM1 of any length --------------------------------------------------------------------------------- */

typedef struct session {
    wire_t w;
    uint16_t in_length;
    uint8_t mail[1486]; /* the last one, from the CoE header on */
} session_t;

static void open_session(session_t *s, const ect_device_t *device, uint16_t in_length)
{
    s->in_length = in_length;
    wire_open_one(&s->w, device);
    wire_set_sm(&s->w, 0, 0, device->sm[0].start, device->sm[0].length, device->sm[0].control);
    wire_set_sm(&s->w, 0, 1, device->sm[1].start, in_length, device->sm[1].control);
    assert_int_equal(wire_al(&s->w, 0, ECT_STATE_PREOP, NULL), ECT_STATE_PREOP);
}

static void put(session_t *s, const uint8_t *payload, uint16_t length)
{
    uint8_t mail[256] = {0};
    s->w.mail_counter = (uint8_t)(s->w.mail_counter % 7 + 1);
    ect_store_le16(mail, length);
    mail[5] = (uint8_t)(3 | (s->w.mail_counter << 4));
    memcpy(mail + HEADER, payload, length);
    assert_int_equal(wire_mail_send(&s->w, 0, mail, (uint16_t)(HEADER + length)), 1);
}

static int fetch(session_t *s)
{
    uint8_t mail[1486] = {0};
    if ((wire_read8(&s->w, 0, ECT_REG_SM + ECT_SM_SIZE + ECT_SM_STATUS) & ECT_SM_STATUS_FULL) == 0)
        return NO_MAIL;
    assert_int_equal(wire_read(&s->w, 0, wire_device(&s->w, 0)->sm[1].start, mail, s->in_length), 1);
    memcpy(s->mail, mail + HEADER, sizeof mail - HEADER);
    int length = ect_load_le16(mail);
    assert_true(length <= s->in_length - HEADER);
    return (mail[5] & 0x0F) == 3 ? length : MAILBOX_ERROR;
}

/* An information request: opcode and its data. */
static void put_info(session_t *s, uint8_t opcode, const uint8_t *data, uint16_t length)
{
    uint8_t request[64] = {0x00, 0x80, opcode};
    memcpy(request + 6, data, length);
    put(s, request, (uint16_t)(6 + length));
}

static int ask(session_t *s, uint8_t opcode, uint16_t index, uint8_t subindex, uint8_t value_info)
{
    uint8_t data[4] = {0, 0, subindex, value_info};
    ect_store_le16(data, index);
    put_info(s, opcode, data, opcode == 5 ? 4 : 2);
    return fetch(s);
}

static void expect_error(session_t *s, const char *what, int length, uint32_t code)
{
    static const uint8_t header[6] = {0x00, 0x80, 0x07, 0x00, 0x00, 0x00};
    if (length < 10 || memcmp(s->mail, header, sizeof header) != 0 || ect_load_le32(s->mail + 6) != code)
        fail_msg("%s: expected information error %08X, got opcode %02X, length %d, code %08X", what, code, s->mail[2],
                 length, ect_load_le32(s->mail + 6));
}

/* --- lists -------------------------------------------------------------------------------------------------------- */

/* The rule of each list, over the entries: mappable, backup, setting as SDO information defines them. */
static bool belongs(const ect_object_t *object, uint16_t list)
{
    static const uint16_t bit[] = {0, 0, 0x0040, 0x0080, 0x0100, 0x0200};
    const ect_entry_t *e = object->entries;
    for (;; e++) {
        if (list == 1 || (e->access & bit[list]) != 0)
            return true;
        if (e->subindex == object->max_subindex)
            return false;
    }
}

static uint16_t expected_list(const ect_device_t *device, uint16_t list, uint16_t *indices)
{
    uint16_t count = 0;
    for (uint16_t i = 0; i < device->object_count; i++) {
        if (belongs(&device->objects[i], list))
            indices[count++] = device->objects[i].index;
    }
    return count;
}

/* Fetches the fragments of a list and checks each header. @return the indices */
static uint16_t fetch_list(session_t *s, uint16_t list, uint16_t elements, uint16_t *indices)
{
    uint16_t per_fragment = (uint16_t)((s->in_length - 12) / 2);
    uint16_t fragments = (uint16_t)((elements + per_fragment - 1) / per_fragment);
    uint16_t count = 0;
    for (uint16_t left = fragments; left-- > 0;) {
        int length = fetch(s);
        const uint8_t *m = s->mail;
        uint8_t opcode = left > 0 ? 0x82 : 0x02;
        if (length < 6 || length % 2 != 0 || m[0] != 0 || m[1] != 0x80 || m[2] != opcode || m[3] != 0 ||
            ect_load_le16(m + 4) != left)
            fail_msg(
                "list %u, SM1 of %u: %u fragments should follow, got length %d, header %02X %02X %02X %02X, left %u",
                list, s->in_length, left, length, m[0], m[1], m[2], m[3], ect_load_le16(m + 4));
        assert_true(left == 0 || length == 6 + 2 * per_fragment);
        for (int at = 6; at < length; at += 2)
            indices[count++] = ect_load_le16(m + at);
    }
    assert_int_equal(fetch(s), NO_MAIL);
    assert_int_equal(indices[0], list);
    return count;
}

/* A mailbox of 16 bytes is too small for it. */
static bool has_info(const ect_device_t *device)
{
    return (device->coe_details & ECT_COE_SDO_INFO) != 0;
}

static void check_lists(const ect_device_t *device, uint16_t in_length)
{
    session_t s;
    uint16_t want[MOST_OBJECTS], got[MOST_OBJECTS];
    uint8_t lengths[10];
    open_session(&s, device, in_length);
    for (uint16_t list = 1; list <= 5; list++) {
        uint8_t data[2] = {(uint8_t)list, 0};
        uint16_t count = expected_list(device, list, want);
        ect_store_le16(lengths + 2 * (list - 1), count);
        put_info(&s, 1, data, 2);
        uint16_t elements = fetch_list(&s, list, (uint16_t)(count + 1), got);
        if (elements != count + 1 || memcmp(got + 1, want, 2u * count) != 0)
            fail_msg("%s, list %u, SM1 of %u: expected %u indices, got %u, or others", device->name, list, in_length,
                     count, elements - 1);
    }
    static const uint8_t header[8] = {0x00, 0x80, 0x02, 0x00, 0x00, 0x00, 0x00, 0x00};
    assert_int_equal(ask(&s, 1, 0, 0, 0), 18);
    assert_memory_equal(s.mail, header, sizeof header);
    assert_memory_equal(s.mail + 8, lengths, sizeof lengths);
    wire_close(&s.w);
}

static void lists_of_the_test_device(void **state)
{
    (void)state;
    for (uint16_t in_length = SHORTEST_IN; in_length <= LONGEST_IN; in_length++)
        check_lists(&testdev, in_length);
}

static void lists_of_the_catalogue(void **state)
{
    (void)state;
    for (size_t i = 0; every_product(i); i++) {
        if (has_info(every_product(i)))
            check_lists(every_product(i), every_product(i)->sm[1].length);
    }
}

/* The content written out, as a second source besides the loop above. */
static void lists_by_hand(void **state)
{
    static const struct {
        uint8_t list;
        uint16_t count;
        uint16_t indices[3];
    } table[] = {{2, 1, {0x7000}}, {3, 1, {0x6000}}, {4, 1, {0x2000}}, {5, 1, {0x2004}}};
    session_t s;
    (void)state;
    open_session(&s, &testdev, 128);
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        uint16_t got[MOST_OBJECTS];
        uint8_t data[2] = {table[i].list, 0};
        put_info(&s, 1, data, 2);
        assert_int_equal(fetch_list(&s, table[i].list, (uint16_t)(table[i].count + 1), got), table[i].count + 1);
        assert_memory_equal(got + 1, table[i].indices, 2u * table[i].count);
    }
    wire_close(&s.w);
}

static void exact_fragments(void **state)
{
    /* SM1 of 34: 22 bytes of data in a mail, so 11 elements; with the list's type 11, 12, 22, 23 and 1 elements. */
    static const uint16_t counts[] = {10, 11, 21, 22, 0, 1, 255};
    static ect_object_t objects[256];
    static const ect_entry_t entry[] = {{0, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, "E", 0, NULL}};
    (void)state;
    for (uint16_t i = 0; i < 256; i++)
        objects[i] = (ect_object_t){(uint16_t)(0x2000 + i), ECT_OBJECT_VAR, 0, 0, "O", entry};
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; i++) {
        ect_device_t device = testdev;
        device.objects = objects;
        device.object_count = counts[i];
        check_lists(&device, SHORTEST_IN);
        check_lists(&device, SHORTEST_IN + 1);
    }
}

static void unknown_list(void **state)
{
    static const uint16_t lists[] = {6, 7, 0x80, 0x0100, 0xFFFF};
    session_t s;
    (void)state;
    open_session(&s, &testdev, SHORTEST_IN);
    for (size_t i = 0; i < sizeof lists / sizeof lists[0]; i++)
        expect_error(&s, "unknown list", ask(&s, 1, lists[i], 0, 0), 0x06010000);
    wire_close(&s.w);
}

/* --- a list under way --------------------------------------------------------------------------------------------- */

static void a_new_request_ends_a_list(void **state)
{
    session_t s;
    (void)state;
    open_session(&s, &testdev, SHORTEST_IN);
    put_info(&s, 1, (const uint8_t *)"\x01\x00", 2); /* 21 objects: 2 fragments */
    assert_int_equal(fetch(&s), 6 + 22);
    assert_int_equal(s.mail[2], 0x82);
    put_info(&s, 3, (const uint8_t *)"\x00\x20", 2); /* while the second one is in SM1 */
    assert_int_equal(fetch(&s), 6 + 22);
    assert_int_equal(s.mail[2], 0x02);
    assert_true(fetch(&s) > 0);
    assert_int_equal(s.mail[2], 0x04);
    assert_int_equal(fetch(&s), NO_MAIL);
    wire_close(&s.w);
}

static void a_new_request_ends_a_long_list(void **state)
{
    static ect_object_t objects[100];
    static const ect_entry_t entry[] = {{0, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, "E", 0, NULL}};
    ect_device_t device = testdev;
    session_t s;
    (void)state;
    for (uint16_t i = 0; i < 100; i++)
        objects[i] = (ect_object_t){(uint16_t)(0x2000 + i), ECT_OBJECT_VAR, 0, 0, "O", entry};
    device.objects = objects;
    device.object_count = 100;
    open_session(&s, &device, SHORTEST_IN);
    put_info(&s, 1, (const uint8_t *)"\x01\x00", 2); /* 10 fragments */
    assert_int_equal(fetch(&s), 28);
    put_info(&s, 3, (const uint8_t *)"\x05\x20", 2); /* the second one is in SM1 */
    unsigned int fragments = 1;
    while (fetch(&s) > 0 && (s.mail[2] & 0x7F) == 2)
        fragments++;
    assert_int_equal(s.mail[2], 0x04);
    assert_int_equal(ect_load_le16(s.mail + 6), 0x2005);
    if (fragments != 2)
        fail_msg("a request while fragment 2 of 10 is in SM1: expected its reply next, got %u more fragments first",
                 fragments - 2);
    assert_int_equal(fetch(&s), NO_MAIL);
    wire_close(&s.w);
}

static void init_ends_a_list(void **state)
{
    session_t s;
    (void)state;
    open_session(&s, &testdev, SHORTEST_IN);
    put_info(&s, 1, (const uint8_t *)"\x01\x00", 2);
    assert_int_equal(wire_al(&s.w, 0, ECT_STATE_INIT, NULL), ECT_STATE_INIT);
    wire_configure_mailbox(&s.w, 0);
    assert_int_equal(wire_al(&s.w, 0, ECT_STATE_PREOP, NULL), ECT_STATE_PREOP);
    s.in_length = 128;
    wire_poll(&s.w);
    assert_int_equal(fetch(&s), NO_MAIL);
    wire_close(&s.w);
}

static void an_sdo_after_a_list(void **state)
{
    static const uint8_t upload[10] = {0x00, 0x20, 0x40, 0x00, 0x20};
    session_t s;
    (void)state;
    open_session(&s, &testdev, SHORTEST_IN);
    put_info(&s, 1, (const uint8_t *)"\x01\x00", 2);
    put(&s, upload, sizeof upload);
    assert_int_equal(fetch(&s), 28);
    assert_int_equal(s.mail[2], 0x82);
    assert_int_equal(fetch(&s), 10);
    assert_int_equal(s.mail[1], 0x30);
    assert_int_equal(s.mail[2], 0x43);
    assert_int_equal(fetch(&s), 28);
    assert_int_equal(s.mail[2], 0x02);
    wire_close(&s.w);
}

/* --- descriptions ------------------------------------------------------------------------------------------------- */

static uint16_t expected_type(const ect_object_t *o)
{
    if (o->object_code == ECT_OBJECT_RECORD) {
        if (o->index == 0x1018)
            return 0x0023;
        if (o->index == 0x1C32 || o->index == 0x1C33)
            return 0x0029;
        return o->index >= 0x1600 && o->index < 0x1C00 ? 0x0021 : 0x002A;
    }
    const ect_entry_t *e = o->entries; /* type of the elements: that of the last one */
    while (e->subindex != o->max_subindex)
        e++;
    return e->data_type;
}

static void check_object(session_t *s, const ect_object_t *o)
{
    uint8_t want[300] = {0x00, 0x80, 0x04};
    size_t room = (size_t)s->in_length - HEADER - 12;
    size_t name = strlen(o->name) < room ? strlen(o->name) : room;
    ect_store_le16(want + 6, o->index);
    ect_store_le16(want + 8, expected_type(o));
    want[10] = o->max_subindex;
    want[11] = (uint8_t)o->object_code;
    memcpy(want + 12, o->name, name);
    int length = ask(s, 3, o->index, 0, 0);
    if (length != (int)(12 + name) || memcmp(s->mail, want, 12 + name) != 0)
        fail_msg("description of %04Xh, SM1 of %u: length %d, type %04X, max %u, code %u, name %.*s", o->index,
                 s->in_length, length, ect_load_le16(s->mail + 8), s->mail[10], s->mail[11], length - 12,
                 (const char *)s->mail + 12);
}

/* A text of the description has its own length. */
static uint16_t bits_of(session_t *s, const ect_entry_t *e)
{
    const ect_od_t od = ect_device_od(wire_device(&s->w, 0), NULL);
    bool text = (e->access & ECT_ACCESS_DESCRIPTION) != 0 && e->data_type == ECT_TYPE_VISIBLE_STRING;
    return text ? (uint16_t)(8 * strlen(ect_od_data(&od, e))) : e->bit_length;
}

static void check_entry(session_t *s, const ect_object_t *o, const ect_entry_t *e)
{
    uint8_t want[300] = {0x00, 0x80, 0x06};
    size_t room = (size_t)s->in_length - HEADER - 16;
    size_t name = strlen(e->name) < room ? strlen(e->name) : room;
    ect_store_le16(want + 6, o->index);
    want[8] = (uint8_t)e->subindex;
    want[9] = 0x07;
    ect_store_le16(want + 10, e->data_type);
    ect_store_le16(want + 12, bits_of(s, e));
    ect_store_le16(want + 14, e->access & 0x0FFF);
    memcpy(want + 16, e->name, name);
    int length = ask(s, 5, o->index, (uint8_t)e->subindex, 0x07);
    if (length != (int)(16 + name) || memcmp(s->mail, want, 16 + name) != 0)
        fail_msg("description of %04Xh:%u, SM1 of %u: length %d, info %02X, type %04X, %u bits, access %04X, name %.*s",
                 o->index, e->subindex, s->in_length, length, s->mail[9], ect_load_le16(s->mail + 10),
                 ect_load_le16(s->mail + 12), ect_load_le16(s->mail + 14), length - 16, (const char *)s->mail + 16);
}

/* A gap between sub-indices: data type 0, no bits, no rights, no name. */
static void check_gap(session_t *s, uint16_t index, uint8_t subindex)
{
    uint8_t want[16] = {0x00, 0x80, 0x06};
    ect_store_le16(want + 6, index);
    want[8] = subindex;
    want[9] = 0x07;
    int length = ask(s, 5, index, subindex, 0x07);
    if (length != (int)sizeof want || memcmp(s->mail, want, sizeof want) != 0)
        fail_msg("gap %04Xh:%u: opcode %02X, length %d, type %04X, %u bits", index, subindex, s->mail[2], length,
                 ect_load_le16(s->mail + 10), ect_load_le16(s->mail + 12));
}

static void check_descriptions(const ect_device_t *device, uint16_t in_length)
{
    session_t s;
    open_session(&s, device, in_length);
    for (uint16_t i = 0; i < device->object_count; i++) {
        const ect_object_t *o = &device->objects[i];
        check_object(&s, o);
        const ect_entry_t *e = o->entries;
        for (unsigned int sub = 0; sub <= o->max_subindex + 1u && sub <= 255; sub++) {
            if (sub <= o->max_subindex && e->subindex == sub) {
                check_entry(&s, o, e++);
                continue;
            }
            if (sub < o->max_subindex)
                check_gap(&s, o->index, (uint8_t)sub);
            else
                expect_error(&s, "sub-index beyond the last", ask(&s, 5, o->index, (uint8_t)sub, 7), 0x06090011);
        }
    }
    wire_close(&s.w);
}

static void descriptions(void **state)
{
    (void)state;
    for (size_t i = 0; every_product(i); i++) {
        if (has_info(every_product(i)))
            check_descriptions(every_product(i), every_product(i)->sm[1].length);
    }
    check_descriptions(&testdev, LONGEST_IN);
    check_descriptions(&testdev, 35);
    check_descriptions(&testdev, SHORTEST_IN);
}

static void descriptions_by_hand(void **state)
{
    static const struct {
        const char *what;
        uint8_t opcode;
        uint16_t index;
        uint8_t subindex;
        uint16_t length;
        uint8_t want[40];
    } table[] = {
        {"U32", 3, 0x2000, 0, 15, "\x00\x80\x04\x00\x00\x00\x00\x20\x07\x00\x00\x07U32"},
        {"array", 3, 0x2007, 0, 17,
         "\x00\x80\x04\x00\x00\x00\x07\x20\x06\x00\x04\x08"
         "Array"},
        {"sparse record", 3, 0x2008, 0, 25, "\x00\x80\x04\x00\x00\x00\x08\x20\x2A\x00\x05\x09Sparse record"},
        {"identity", 3, 0x1018, 0, 20, "\x00\x80\x04\x00\x00\x00\x18\x10\x23\x00\x04\x09Identity"},
        {"rw with backup", 5, 0x2000, 0, 19, "\x00\x80\x06\x00\x00\x00\x00\x20\x00\x07\x07\x00\x20\x00\x3F\x01U32"},
        {"write-only", 5, 0x2003, 0, 26, "\x00\x80\x06\x00\x00\x00\x03\x20\x00\x07\x06\x00\x10\x00\x38\x00Write only"},
        {"rw in PREOP", 5, 0x2004, 0, 26, "\x00\x80\x06\x00\x00\x00\x04\x20\x00\x07\x06\x00\x10\x00\x0F\x02PREOP only"},
        {"bits", 5, 0x6000, 2, 26, "\x00\x80\x06\x00\x00\x00\x00\x60\x02\x07\x32\x00\x03\x00\x87\x00Input bits"},
        {"output bit", 5, 0x7000, 1, 26, "\x00\x80\x06\x00\x00\x00\x00\x70\x01\x07\x01\x00\x01\x00\x7F\x00Output bit"},
    };
    session_t s;
    (void)state;
    open_session(&s, &testdev, 128);
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        int length = ask(&s, table[i].opcode, table[i].index, table[i].subindex, 0x07);
        if (length != table[i].length || memcmp(s.mail, table[i].want, table[i].length) != 0)
            fail_msg("%s: description of %04Xh:%u is not as expected (length %d, expected %u)", table[i].what,
                     table[i].index, table[i].subindex, length, table[i].length);
    }
    wire_close(&s.w);
}

/* --- value info --------------------------------------------------------------------------------------------------- */

/* Default, minimum and maximum written out; a length of 0 bytes: the entry has none. */
typedef struct details {
    uint16_t index;
    uint8_t subindex;
    uint8_t unit_bytes, default_bytes, limit_bytes;
    uint8_t unit[2], standard[8], minimum[8], maximum[8];
    const char *name;
} details_t;

static const details_t details[] = {
    {0x2005, 0, 2, 2, 2, {0x2D, 0x00}, {0x05, 0x00}, {0x9C, 0xFF}, {0xC8, 0x00}, "Limited"},
    {0x2000, 0, 0, 4, 0, {0}, {0x44, 0x33, 0x22, 0x11}, {0}, {0}, "U32"},
    {0x2004, 0, 0, 2, 0, {0}, {0x07, 0x00}, {0}, {0}, "PREOP only"},
    {0x2009, 0, 0, 8, 0, {0}, {0}, {0}, {0}, "U64"},
    {0x2006, 0, 0, 1, 0, {0}, {0x06}, {0}, {0}, "Number of entries"},
    {0x2001, 0, 0, 0, 0, {0}, {0}, {0}, {0}, "Text"},
    {0x2002, 0, 0, 0, 0, {0}, {0}, {0}, {0}, "Octets"},
};

static void check_details(session_t *s, const details_t *d, uint8_t value_info)
{
    uint8_t want[64];
    size_t used = 0;
    uint8_t given = value_info & 0x07;
    const struct {
        uint8_t bit, bytes;
        const uint8_t *value;
    } fields[] = {{0x08, d->unit_bytes, d->unit},
                  {0x10, d->default_bytes, d->standard},
                  {0x20, d->limit_bytes, d->minimum},
                  {0x40, d->limit_bytes, d->maximum}};
    for (size_t i = 0; i < 4; i++) {
        if ((value_info & fields[i].bit) == 0 || fields[i].bytes == 0)
            continue;
        given |= fields[i].bit;
        memcpy(want + used, fields[i].value, fields[i].bytes);
        used += fields[i].bytes;
    }
    memcpy(want + used, d->name, strlen(d->name));
    used += strlen(d->name);
    int length = ask(s, 5, d->index, d->subindex, value_info);
    if (length != (int)(16 + used) || s->mail[9] != given || memcmp(s->mail + 16, want, used) != 0)
        fail_msg("%04Xh:%u with value info %02X: expected info %02X and %zu bytes, got %02X and %d bytes, or others",
                 d->index, d->subindex, value_info, given, used, s->mail[9], length - 16);
}

static void value_info(void **state)
{
    session_t s;
    (void)state;
    open_session(&s, &testdev, 128);
    for (size_t i = 0; i < sizeof details / sizeof details[0]; i++) {
        for (unsigned int info = 0; info < 0x80; info++)
            check_details(&s, &details[i], (uint8_t)info);
    }
    wire_close(&s.w);
}

static void no_unit(void **state)
{
    static const ect_detail_t limits[] = {ECT_LIMITS(0x2005, 0, 0, -100, 200)};
    ect_device_t device = testdev;
    session_t s;
    (void)state;
    device.details = limits;
    device.detail_count = 1;
    open_session(&s, &device, 128);
    assert_true(ask(&s, 5, 0x2005, 0, 0x68) >= 20); /* unit, minimum, maximum */
    assert_int_equal(s.mail[9], 0x60);
    assert_int_equal((int16_t)ect_load_le16(s.mail + 16), -100);
    assert_int_equal((int16_t)ect_load_le16(s.mail + 18), 200);
    wire_close(&s.w);
}

/* Octets that would fit into the mailbox. */
static void octets_without_default(void **state)
{
    static const ect_entry_t entry[] = {
        {0, ECT_TYPE_OCTET_STRING, 8 * 9, ECT_ACCESS_RW, "O", 0, ECT_OFFSET(testdev_t, octets)}};
    static const ect_object_t objects[] = {ECT_VAR(0x3000, "O", entry)};
    ect_device_t device = testdev;
    session_t s;
    (void)state;
    device.objects = objects;
    device.object_count = 1;
    device.detail_count = 0;
    open_session(&s, &device, 128);
    assert_int_equal(ask(&s, 5, 0x3000, 0, 0x70), 16 + 1);
    assert_int_equal(s.mail[9], 0);
    wire_close(&s.w);
}

static void long_default(void **state)
{
    static const uint8_t initial[8] = {0x11, 0x22, 0x33, 0x44, 0x55, 0x66, 0x77, 0x88};
    static const ect_detail_t detail[] = {{.index = 0x2009, .subindex = 0, .initial = initial}};
    ect_device_t device = testdev;
    session_t s;
    (void)state;
    device.details = detail;
    device.detail_count = 1;
    open_session(&s, &device, 128);
    assert_int_equal(ask(&s, 5, 0x2009, 0, 0x10), 16 + 8 + 3);
    assert_int_equal(s.mail[9], 0x10);
    assert_memory_equal(s.mail + 16, initial, 8);
    wire_close(&s.w);
}

/* Fields that do not fit are omitted and not announced; the mail never exceeds the mailbox. */
static void value_info_in_a_small_mailbox(void **state)
{
    static const ect_entry_t entry[] = {
        {0, ECT_TYPE_INTEGER64, 64, ECT_ACCESS_RW, "A name", 0x01020304, ECT_OFFSET(testdev_t, u64)}};
    static const ect_object_t objects[] = {{0x3000, ECT_OBJECT_VAR, 0, 0, "O", entry}};
    static const ect_detail_t limits[] = {ECT_LIMITS(0x3000, 0, 0x00FD, -2, 2)};
    (void)state;
    for (uint16_t in_length = SHORTEST_IN; in_length < 64; in_length++) {
        session_t s;
        ect_device_t device = testdev;
        device.objects = objects;
        device.object_count = 1;
        device.details = limits;
        device.detail_count = 1;
        open_session(&s, &device, in_length);
        int length = ask(&s, 5, 0x3000, 0, 0x7F);
        uint8_t given = s.mail[9];
        int fields = ((given & 8) != 0 ? 2 : 0) + ((given & 0x10) != 0 ? 8 : 0) + ((given & 0x20) != 0 ? 8 : 0) +
                     ((given & 0x40) != 0 ? 8 : 0);
        int room = in_length - HEADER - 16 - fields;
        int name = room < 6 ? room : 6;
        if (name < 0 || length != 16 + fields + name || memcmp(s.mail + 16 + fields, "A name", (size_t)name) != 0)
            fail_msg("SM1 of %u: info %02X, length %d", in_length, given, length);
        assert_int_equal(given & 0x0F, 0x0F);
        wire_close(&s.w);
    }
}

static void names_are_cut_at_the_mailbox(void **state)
{
    static const ect_entry_t entry[] = {{0, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO,
                                         "A name of an entry that is longer than some mailboxes are", 0, NULL}};
    static const ect_entry_t nameless[] = {{0, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, NULL, 0, NULL}};
    static const ect_object_t objects[] = {
        {0x3000, ECT_OBJECT_VAR, 0, 0, "A name of an object that is longer than some mailboxes are", entry},
        {0x3001, ECT_OBJECT_VAR, 0, 0, "", nameless}};
    ect_device_t device = testdev;
    (void)state;
    device.objects = objects;
    device.object_count = 2;
    for (uint16_t in_length = SHORTEST_IN; in_length < 90; in_length++) {
        session_t s;
        open_session(&s, &device, in_length);
        check_object(&s, &objects[0]);
        check_entry(&s, &objects[0], &entry[0]);
        check_object(&s, &objects[1]);
        assert_int_equal(ask(&s, 5, 0x3001, 0, 0x07), 16);
        wire_close(&s.w);
    }
}

static void types_of_records(void **state)
{
    static const ect_entry_t entries[] = {{0, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, "Count", 1, NULL},
                                          {1, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RO, "E", 0, NULL}};
    static const uint16_t indices[] = {0x1018, 0x15FF, 0x1600, 0x17FF, 0x1A00, 0x1BFF, 0x1C00, 0x1C32, 0x1C33, 0x2000};
    ect_object_t objects[sizeof indices / sizeof indices[0]];
    ect_device_t device = testdev;
    session_t s;
    (void)state;
    for (size_t i = 0; i < sizeof indices / sizeof indices[0]; i++)
        objects[i] = (ect_object_t){indices[i], ECT_OBJECT_RECORD, 1, 0, "R", entries};
    device.objects = objects;
    device.object_count = sizeof indices / sizeof indices[0];
    open_session(&s, &device, 128);
    for (size_t i = 0; i < sizeof indices / sizeof indices[0]; i++)
        check_object(&s, &objects[i]);
    wire_close(&s.w);
}

/* --- errors ------------------------------------------------------------------------------------------------------- */

static void information_errors(void **state)
{
    static const uint8_t data[4] = {0x00, 0x20, 0x00, 0x07};
    session_t s;
    (void)state;
    open_session(&s, &testdev, 128);
    expect_error(&s, "no such object", ask(&s, 3, 0x200A, 0, 0), 0x06020000);
    expect_error(&s, "entry of no object", ask(&s, 5, 0x200A, 0, 7), 0x06020000);
    check_gap(&s, 0x2008, 2);
    expect_error(&s, "entry beyond the last", ask(&s, 5, 0x2008, 6, 7), 0x06090011);
    for (unsigned int opcode = 0; opcode < 0x80; opcode++) {
        if (opcode == 1 || opcode == 3 || opcode == 5)
            continue;
        put_info(&s, (uint8_t)opcode, data, 4);
        expect_error(&s, "unknown opcode", fetch(&s), 0x05040001);
    }
    assert_true(ask(&s, 3, 0x2000, 0, 0) > 0);
    assert_int_equal(s.mail[2], 0x04);
    wire_close(&s.w);
}

static void too_short_requests(void **state)
{
    static const struct {
        uint8_t opcode;
        uint16_t shortest; /* bytes behind the information header */
    } table[] = {{1, 2}, {3, 2}, {5, 4}};
    session_t s;
    (void)state;
    open_session(&s, &testdev, 128);
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        uint8_t request[16] = {0x00, 0x80, table[i].opcode, 0, 0, 0, 0x00, 0x20};
        for (uint16_t length = 3; length < 6 + table[i].shortest; length++) {
            put(&s, request, length);
            assert_int_equal(fetch(&s), MAILBOX_ERROR);
            assert_int_equal(ect_load_le16(s.mail), 1);
            assert_int_equal(ect_load_le16(s.mail + 2), 6);
        }
        put(&s, request, (uint16_t)(6 + table[i].shortest));
        while (fetch(&s) > 0) {
        }
    }
    wire_close(&s.w);
}

static void no_information_offered(void **state)
{
    ect_device_t device = testdev;
    session_t s;
    (void)state;
    static const ect_protocol_t *const sdo_only[] = {&ect_protocol_sdo, NULL};
    device.protocols = sdo_only;
    open_session(&s, &device, 128);
    assert_int_equal(ask(&s, 3, 0x2000, 0, 0), MAILBOX_ERROR);
    assert_int_equal(ect_load_le16(s.mail + 2), 4);
    wire_close(&s.w);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"CF-076: lists 0 to 5 of the test device, in fragments of an SM1 of 34 to 256 bytes", lists_of_the_test_device,
         NULL, NULL, NULL},
        {"CF-076: lists 0 to 5 of every device of the catalogue", lists_of_the_catalogue, NULL, NULL, NULL},
        {"CF-076: lists 2 to 5 of the test device hold the objects that its header names", lists_by_hand, NULL, NULL,
         NULL},
        {"CF-076: a list that just fills its fragments has no empty one", exact_fragments, NULL, NULL, NULL},
        {"CF-076: an unknown list gets an information error", unknown_list, NULL, NULL, NULL},
        {"CF-076: a request while the last fragment is in SM1 gets the next reply", a_new_request_ends_a_list, NULL,
         NULL, NULL},
        {"CF-076: INIT ends an active list", init_ends_a_list, NULL, NULL, NULL},
        {"CF-076: an SDO request during a list gets its reply between two fragments, and the list continues",
         an_sdo_after_a_list, NULL, NULL, NULL},
        {"CF-076: every object and entry of every device is described as in its tables", descriptions, NULL, NULL,
         NULL},
        {"CF-076: descriptions byte by byte", descriptions_by_hand, NULL, NULL, NULL},
        {"CF-076: an entry description contains the unit, default, minimum and maximum if requested", value_info, NULL,
         NULL, NULL},
        {"CF-076: an entry without a unit describes none, although it has limits", no_unit, NULL, NULL, NULL},
        {"CF-076: an entry longer than a number is described without a default", octets_without_default, NULL, NULL,
         NULL},
        {"CF-076: a default of more than 32 bits is described whole", long_default, NULL, NULL, NULL},
        {"CF-076: value info that does not fit into the mailbox is omitted", value_info_in_a_small_mailbox, NULL, NULL,
         NULL},
        {"CF-076: names are truncated at the end of the mailbox", names_are_cut_at_the_mailbox, NULL, NULL, NULL},
        {"CF-076: records have the data type of their structure", types_of_records, NULL, NULL, NULL},
        {"CF-076: unknown objects, entries and opcodes get an information error", information_errors, NULL, NULL, NULL},
        {"CF-076: a truncated request gets a mailbox error", too_short_requests, NULL, NULL, NULL},
        {"CF-076: a device without SDO information replies with a mailbox error", no_information_offered, NULL, NULL,
         NULL},
        {"CF-076: a new request ends an active list", a_new_request_ends_a_long_list, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("SDO information", tests, NULL, NULL);
}
