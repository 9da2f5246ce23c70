/* SPDX-License-Identifier: MIT */
/* The object dictionary: lookups, rights, wire form of every type, limits, abort codes (od.h, spec E.4 to E.6). */
#include "od/od.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

#include "od/link.h"
#include "seams/standard.h"
#include "support/wire.h"

enum { MOST = 70 };

/* --- abort codes -------------------------------------------------------------------------------------------------- */

static const struct {
    ect_reason_t reason;
    uint32_t code;
    bool fzm; /* in the list of Q179 section 1-1 */
} reasons[] = {
    {ECT_REASON_TOGGLE, 0x05030000, true},
    {ECT_REASON_TIMEOUT, 0x05040000, true},
    {ECT_REASON_COMMAND, 0x05040001, true},
    {ECT_REASON_MEMORY, 0x05040005, true},
    {ECT_REASON_UNSUPPORTED, 0x06010000, true},
    {ECT_REASON_WRITE_ONLY, 0x06010001, true},
    {ECT_REASON_READ_ONLY, 0x06010002, true},
    {ECT_REASON_SUBINDEX0, 0x06010003, false},
    {ECT_REASON_VARIABLE_LENGTH, 0x06010004, false},
    {ECT_REASON_MAILBOX_SIZE, 0x06010005, false},
    {ECT_REASON_MAPPED, 0x06010006, false},
    {ECT_REASON_NO_OBJECT, 0x06020000, true},
    {ECT_REASON_NOT_MAPPABLE, 0x06040041, true},
    {ECT_REASON_PDO_LENGTH, 0x06040042, true},
    {ECT_REASON_INCOMPATIBLE, 0x06040043, true},
    {ECT_REASON_INTERNAL, 0x06040047, true},
    {ECT_REASON_HARDWARE, 0x06060000, true},
    {ECT_REASON_LENGTH, 0x06070010, true},
    {ECT_REASON_TOO_LONG, 0x06070012, true},
    {ECT_REASON_TOO_SHORT, 0x06070013, true},
    {ECT_REASON_NO_SUBINDEX, 0x06090011, true},
    {ECT_REASON_RANGE, 0x06090030, true},
    {ECT_REASON_TOO_HIGH, 0x06090031, true},
    {ECT_REASON_TOO_LOW, 0x06090032, true},
    {ECT_REASON_MODULES, 0x06090033, false},
    {ECT_REASON_MIN_MAX, 0x06090036, true},
    {ECT_REASON_RESOURCE, 0x060A0023, false},
    {ECT_REASON_GENERAL, 0x08000000, true},
    {ECT_REASON_STORE, 0x08000020, true},
    {ECT_REASON_LOCAL_CONTROL, 0x08000021, true},
    {ECT_REASON_STATE, 0x08000022, true},
    {ECT_REASON_NO_DICTIONARY, 0x08000023, true},
    {ECT_REASON_NO_DATA, 0x08000024, false},
};

static void abort_codes(void **state)
{
    unsigned int of_the_list = 0;
    (void)state;
    assert_int_equal(sizeof reasons / sizeof reasons[0], ECT_REASON_COUNT - 1);
    for (size_t i = 0; i < sizeof reasons / sizeof reasons[0]; i++) {
        uint32_t got = ect_abort_code(reasons[i].reason);
        if (got != reasons[i].code)
            fail_msg("reason %d: expected %08X, got %08X", (int)reasons[i].reason, reasons[i].code, got);
        of_the_list += reasons[i].fzm;
    }
    assert_int_equal(of_the_list, 26);
    assert_int_equal(ect_abort_code(ECT_OK), 0x08000000);
    assert_int_equal(ect_abort_code(ECT_REASON_COUNT), 0x08000000);
    assert_int_equal(ect_abort_code((ect_reason_t)1000), 0x08000000);
    assert_int_equal(ect_abort_code(0x0609FFFF), 0x0609FFFF); /* a code of the device itself */
}

/* --- SOES --------------------------------------------------------------------------------------------------------- */

/* The two descriptors of SOES's esc_coe.h, as its applications fill them. */
typedef struct soes_entry {
    uint16_t subindex, datatype, bitlength, flags;
    const char *name;
    uint32_t value;
    void *data;
} soes_entry_t;
typedef struct soes_object {
    uint16_t index, objtype;
    uint8_t maxsub, pad1;
    const char *name;
    const soes_entry_t *objdesc;
} soes_object_t;

#define SAME(ours, our_member, theirs, their_member)                                                                   \
    _Static_assert(offsetof(ours, our_member) == offsetof(theirs, their_member) &&                                     \
                       sizeof(((ours *)0)->our_member) == sizeof(((theirs *)0)->their_member),                         \
                   "a SOES list is used by cast")
_Static_assert(sizeof(ect_entry_t) == sizeof(soes_entry_t) && sizeof(ect_object_t) == sizeof(soes_object_t),
               "a SOES list is used by cast");
SAME(ect_entry_t, subindex, soes_entry_t, subindex);
SAME(ect_entry_t, data_type, soes_entry_t, datatype);
SAME(ect_entry_t, bit_length, soes_entry_t, bitlength);
SAME(ect_entry_t, access, soes_entry_t, flags);
SAME(ect_entry_t, name, soes_entry_t, name);
SAME(ect_entry_t, value, soes_entry_t, value);
SAME(ect_entry_t, data, soes_entry_t, data);
SAME(ect_object_t, index, soes_object_t, index);
SAME(ect_object_t, object_code, soes_object_t, objtype);
SAME(ect_object_t, max_subindex, soes_object_t, maxsub);
SAME(ect_object_t, last, soes_object_t, pad1);
SAME(ect_object_t, name, soes_object_t, name);
SAME(ect_object_t, entries, soes_object_t, objdesc);

/* --- lookups ------------------------------------------------------------------------------------------------------ */

static const ect_entry_t one_entry[] = {{0, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, "E", 1, NULL}};
static const ect_entry_t sparse[] = {{0, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, "Count", 255, NULL},
                                     {1, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, "1", 11, NULL},
                                     {4, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, "4", 44, NULL},
                                     {5, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, "5", 55, NULL},
                                     {255, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, "255", 99, NULL}};
static const ect_entry_t no_count[] = {{2, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, "2", 2, NULL},
                                       {3, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, "3", 3, NULL}};

/* Lists of 0 to 70 objects at every third index from `first`: each is found, each neighbour is not. */
static void lookup_of_objects(void **state)
{
    static ect_object_t objects[MOST];
    static const uint16_t firsts[] = {0, 0x1000, (uint16_t)(0xFFFF - 3 * (MOST - 1))};
    (void)state;
    for (size_t f = 0; f < sizeof firsts / sizeof firsts[0]; f++) {
        for (uint16_t i = 0; i < MOST; i++)
            objects[i] = (ect_object_t){(uint16_t)(firsts[f] + 3 * i), ECT_OBJECT_VAR, 0, 0, "O", one_entry};
        for (uint16_t count = 0; count <= MOST; count++) {
            ect_od_t od = {.objects = objects, .count = count};
            for (uint32_t index = firsts[f]; index < firsts[f] + 3u * MOST && index <= 0xFFFF; index++) {
                uint32_t position = (index - firsts[f]) / 3;
                bool there = (index - firsts[f]) % 3 == 0 && position < count;
                const ect_object_t *got = ect_od_find(&od, (uint16_t)index);
                if (got != (there ? &objects[position] : NULL))
                    fail_msg("%u objects from %04Xh: %04Xh is %sfound", count, firsts[f], index, got ? "" : "not ");
            }
        }
    }
}

/* In memory of exactly the existing entries: no access goes beyond them. */
static void counted_entries(void **state)
{
    (void)state;
    for (uint8_t count = 1; count <= 5; count++) {
        ect_entry_t *entries = malloc(count * sizeof *entries);
        assert_non_null(entries);
        memcpy(entries, sparse, count * sizeof *entries);
        for (unsigned int max = 0; max <= 255; max++) {
            const ect_object_t object = {0x2000, ECT_OBJECT_RECORD, (uint8_t)max, (uint8_t)(count - 1), "O", entries};
            if (count == 1 && max > 0)
                continue; /* not counted */
            unsigned int seen = 0;
            for (const ect_entry_t *e = entries; e; e = ect_od_next(&object, e))
                seen++;
            assert_true(seen <= count);
            for (unsigned int sub = 0; sub <= 255; sub++) {
                const ect_entry_t *got = ect_od_entry(&object, (uint8_t)sub);
                if (got && (got->subindex != sub || got >= entries + count))
                    fail_msg("%u entries, max_subindex %u: sub-index %u is not one of them", count, max, sub);
            }
        }
        free(entries);
    }
}

static void lookup_of_entries(void **state)
{
    static const ect_object_t objects[] = {{0x2000, ECT_OBJECT_VAR, 0, 0, "VAR", one_entry},
                                           {0x2001, ECT_OBJECT_RECORD, 255, 4, "Sparse", sparse},
                                           {0x2002, ECT_OBJECT_RECORD, 1, 0, "No count", no_count},
                                           {0x2003, ECT_OBJECT_RECORD, 4, 0, "Sparse, of SOES", sparse}};
    const ect_od_t od = {.objects = objects, .count = 4};
    (void)state;
    for (uint16_t index = 0x1FFF; index <= 0x2004; index++) {
        for (unsigned int sub = 0; sub <= 255; sub++) {
            const ect_object_t *object = NULL;
            const ect_entry_t *entry = NULL;
            uint32_t number = 12345;
            bool there = (index == 0x2000 && sub == 0) ||
                         ((index == 0x2001 || index == 0x2003) &&
                          (sub == 0 || sub == 1 || sub == 4 || sub == 5 || sub == 255)) ||
                         (index == 0x2002 && (sub == 2 || sub == 3));
            ect_reason_t want = index < 0x2000 || index > 0x2003 ? ECT_REASON_NO_OBJECT
                                : there                          ? ECT_OK
                                                                 : ECT_REASON_NO_SUBINDEX;
            ect_reason_t got = ect_od_lookup(&od, index, (uint8_t)sub, &object, &entry);
            if (got != want || (entry != NULL) != there || (object != NULL) != (want != ECT_REASON_NO_OBJECT) ||
                (there && entry->subindex != sub))
                fail_msg("%04Xh:%u: expected reason %d, got %d", index, sub, (int)want, (int)got);
            assert_int_equal(ect_od_number(&od, index, (uint8_t)sub, &number), want);
            assert_int_equal(number, there ? entry->value : 12345);
            if (want != ECT_REASON_NO_OBJECT)
                assert_ptr_equal(ect_od_entry(ect_od_find(&od, index), (uint8_t)sub), entry);
        }
    }
}

/* --- rights ------------------------------------------------------------------------------------------------------- */

static ect_reason_t expected_right(uint16_t access, bool write, uint8_t al_state)
{
    bool preop = (access & (write ? 0x08 : 0x01)) != 0;
    bool safeop = (access & (write ? 0x10 : 0x02)) != 0;
    bool op = (access & (write ? 0x20 : 0x04)) != 0;
    if (!preop && !safeop && !op)
        return write ? ECT_REASON_READ_ONLY : ECT_REASON_WRITE_ONLY;
    if ((al_state == 2 && preop) || (al_state == 4 && safeop) || (al_state == 8 && op))
        return ECT_OK;
    return ECT_REASON_STATE;
}

static void rights(void **state)
{
    (void)state;
    for (unsigned int access = 0; access <= 0xFFFF; access = access == 0x0FFF ? 0x8000 : access + 1) {
        const ect_entry_t entry = {0, ECT_TYPE_UNSIGNED8, 8, (uint16_t)access, "E", 0, NULL};
        for (uint8_t al_state = 0; al_state < 16; al_state++) {
            for (unsigned int write = 0; write <= 1; write++) {
                ect_reason_t want = expected_right((uint16_t)access, write != 0, al_state);
                ect_reason_t got = ect_od_check_access(&entry, write != 0 ? ECT_DOWNLOAD : ECT_UPLOAD, al_state);
                if (got != want)
                    fail_msg("access %04X, %s in state %u: expected reason %d, got %d", access,
                             write != 0 ? "write" : "read", al_state, (int)want, (int)got);
            }
        }
        if (access == 0x8FFF)
            break;
    }
}

/* --- wire form ---------------------------------------------------------------------------------------------------- */

typedef struct instance {
    uint32_t zero; /* offset 0 belongs to no entry */
    union {
        uint8_t bytes[24];
        uint16_t u16;
        int16_t i16;
        uint32_t u32;
        int32_t i32;
        uint64_t u64;
        int64_t i64;
        float f32;
        double f64;
    } v;
} instance_t;

typedef struct form {
    const char *name;
    uint16_t type, bits, bytes;
    bool is_bits, is_string;
    uint8_t wire[16];
} form_t;

/* host() builds the representation in memory; REAL32 is 1.5, REAL64 -2.0. */
static const form_t forms[] = {
    {"BOOLEAN", 0x01, 1, 1, true, false, {1}},
    {"INTEGER8", 0x02, 8, 1, false, false, {0x80}},
    {"INTEGER16", 0x03, 16, 2, false, false, {0xFE, 0xFF}},
    {"INTEGER32", 0x04, 32, 4, false, false, {0xFD, 0xFF, 0xFF, 0xFF}},
    {"UNSIGNED8", 0x05, 8, 1, false, false, {0xA5}},
    {"UNSIGNED16", 0x06, 16, 2, false, false, {0x34, 0x12}},
    {"UNSIGNED32", 0x07, 32, 4, false, false, {0x78, 0x56, 0x34, 0x12}},
    {"REAL32", 0x08, 32, 4, false, false, {0x00, 0x00, 0xC0, 0x3F}},
    {"VISIBLE_STRING", 0x09, 64, 8, false, true, "ABCDEFGH"},
    {"OCTET_STRING", 0x0A, 80, 10, false, false, {1, 0, 2, 0, 3, 0, 4, 0, 5, 6}},
    {"REAL64", 0x11, 64, 8, false, false, {0, 0, 0, 0, 0, 0, 0x00, 0xC0}},
    {"INTEGER64", 0x15, 64, 8, false, false, {0xFC, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF}},
    {"UNSIGNED64", 0x1B, 64, 8, false, false, {0x88, 0x77, 0x66, 0x55, 0x44, 0x33, 0x22, 0x11}},
    {"a structure, 0x20", 0x20, 64, 8, false, false, {1, 2, 3, 4, 5, 6, 7, 8}}, /* behind the numbers */
    {"BITARR8", 0x2D, 8, 1, false, false, {0xC3}},
    {"BITARR16", 0x2E, 16, 2, false, false, {0x34, 0x12}},
    {"BITARR32", 0x2F, 32, 4, false, false, {0x78, 0x56, 0x34, 0x12}},
    {"BIT1", 0x30, 1, 1, true, false, {1}},
    {"BIT2", 0x31, 2, 1, true, false, {3}},
    {"BIT3", 0x32, 3, 1, true, false, {5}},
    {"BIT4", 0x33, 4, 1, true, false, {9}},
    {"BIT5", 0x34, 5, 1, true, false, {0x11}},
    {"BIT6", 0x35, 6, 1, true, false, {0x21}},
    {"BIT7", 0x36, 7, 1, true, false, {0x41}},
    {"BIT8", 0x37, 8, 1, true, false, {0x81}},
};

static void host(const form_t *form, instance_t *instance)
{
    memset(instance, 0, sizeof *instance);
    switch (form->type) {
    case 0x03:
        instance->v.i16 = -2;
        break;
    case 0x04:
        instance->v.i32 = -3;
        break;
    case 0x06:
    case 0x2E:
        instance->v.u16 = 0x1234;
        break;
    case 0x07:
    case 0x2F:
        instance->v.u32 = 0x12345678;
        break;
    case 0x08:
        instance->v.f32 = 1.5F;
        break;
    case 0x11:
        instance->v.f64 = -2.0;
        break;
    case 0x15:
        instance->v.i64 = -4;
        break;
    case 0x1B:
        instance->v.u64 = 0x1122334455667788u;
        break;
    default:
        memcpy(instance->v.bytes, form->wire, form->bytes);
        break;
    }
}

static void wire_form(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof forms / sizeof forms[0]; i++) {
        const form_t *f = &forms[i];
        const ect_entry_t entry = {1, f->type, f->bits, ECT_ACCESS_RW, f->name, 0, ECT_OFFSET(instance_t, v)};
        instance_t from, to = {0};
        host(f, &from);
        ect_od_t od = {.base = &from};
        assert_int_equal(ect_od_bytes(&entry), f->bytes);
        assert_int_equal(ect_od_upload_size(&od, &entry), f->bytes);
        assert_int_equal(ect_od_is_bits(&entry), f->is_bits);
        assert_int_equal(ect_od_is_string(&entry), f->is_string);
        assert_ptr_equal(ect_od_data(&od, &entry), &from.v);
        for (uint16_t offset = 0; offset <= f->bytes; offset++) {
            for (uint16_t length = 0; length <= f->bytes - offset; length++) {
                uint8_t got[24];
                memset(got, 0xEE, sizeof got);
                ect_od_read(&od, &entry, offset, got, length);
                if (memcmp(got, f->wire + offset, length) != 0 || got[length] != 0xEE)
                    fail_msg("%s: bytes %u..+%u are not as on the wire", f->name, offset, length);
            }
        }
        od.base = &to;
        assert_int_equal(ect_od_write(&od, &entry, 0, f->wire, f->bytes), ECT_OK);
        if (memcmp(&to, &from, sizeof to) != 0)
            fail_msg("%s: the value read is not the value written", f->name);
    }
}

static void bits_of_a_byte(void **state)
{
    (void)state;
    for (unsigned int bits = 1; bits <= 8; bits++) {
        const ect_entry_t entry = {1, (uint16_t)(0x2F + bits),  (uint16_t)bits, ECT_ACCESS_RW, "B",
                                   0, ECT_OFFSET(instance_t, v)};
        for (unsigned int value = 0; value < 256; value++) {
            instance_t instance = {.v.bytes = {(uint8_t)value, 0xEE}};
            const ect_od_t od = {.base = &instance};
            uint8_t got = 0, byte = (uint8_t)value;
            ect_od_read(&od, &entry, 0, &got, 1);
            assert_int_equal(got, value & ((1u << bits) - 1));
            assert_int_equal(ect_od_write(&od, &entry, 0, &byte, 1), ECT_OK);
            assert_int_equal(instance.v.bytes[0], value & ((1u << bits) - 1));
            assert_int_equal(instance.v.bytes[1], 0xEE);
        }
    }
}

static void a_boolean_is_a_bit(void **state)
{
    const ect_entry_t entry = {1, ECT_TYPE_BOOLEAN, 1, ECT_ACCESS_RW, "B", 0, ECT_OFFSET(instance_t, v)};
    (void)state;
    for (unsigned int value = 0; value < 256; value++) {
        instance_t instance = {.v.bytes = {0, 0xEE}};
        const ect_od_t od = {.base = &instance};
        uint8_t byte = (uint8_t)value;
        assert_int_equal(ect_od_write(&od, &entry, 0, &byte, 1), ECT_OK);
        if (instance.v.bytes[0] != (value & 1) || instance.v.bytes[1] != 0xEE)
            fail_msg("%02Xh written to a BOOLEAN: expected %u, got %u", value, value & 1, instance.v.bytes[0]);
    }
}

static void entries_without_memory(void **state)
{
    static const uint8_t wire[16] = {0x78, 0x56, 0x34, 0x12};
    static const uint16_t bits[] = {1, 3, 8, 16, 24, 32, 64, 128};
    instance_t instance = {0};
    (void)state;
    for (size_t i = 0; i < sizeof bits / sizeof bits[0]; i++) {
        uint16_t type = bits[i] < 8 ? (uint16_t)(0x2F + bits[i]) : ECT_TYPE_OCTET_STRING;
        const ect_entry_t entry = {1, type, bits[i], ECT_ACCESS_RW, "Constant", 0x12345678, NULL};
        const ect_od_t od = {.base = &instance};
        uint16_t bytes = ect_od_bytes(&entry);
        assert_null(ect_od_data(&od, &entry));
        assert_int_equal(ect_od_upload_size(&od, &entry), bytes);
        for (uint16_t offset = 0; offset < bytes; offset++) {
            for (uint16_t length = 0; length <= bytes - offset; length++) {
                uint8_t got[24], want[16];
                memset(got, 0xEE, sizeof got);
                memcpy(want, wire, sizeof want);
                if (bits[i] < 8)
                    want[0] &= (uint8_t)((1u << bits[i]) - 1);
                ect_od_read(&od, &entry, offset, got, length);
                if (memcmp(got, want + offset, length) != 0 || got[length] != 0xEE)
                    fail_msg("constant of %u bits: bytes %u..+%u", bits[i], offset, length);
            }
        }
        assert_int_equal(ect_od_write(&od, &entry, 0, wire, bytes), ECT_REASON_READ_ONLY);
    }
    const ect_entry_t text = {0, ECT_TYPE_VISIBLE_STRING, 64, ECT_ACCESS_RO, "T", 0, NULL};
    assert_int_equal(ect_od_upload_size(&(ect_od_t){.base = &instance}, &text), 8);
}

static void addresses_and_offsets(void **state)
{
    static char shared[] = "shared";
    instance_t a = {.v.u32 = 1}, b = {.v.u32 = 2};
    uint32_t number = 3;
    const ect_entry_t offset = {0, ECT_TYPE_UNSIGNED32, 32, ECT_ACCESS_RW, "O", 0, ECT_OFFSET(instance_t, v)};
    const ect_entry_t address = {0, ECT_TYPE_UNSIGNED32, 32, ECT_ACCESS_RW, "A", 0, &number};
    const ect_entry_t text = {0, ECT_TYPE_VISIBLE_STRING, 48, ECT_ACCESS_RW | ECT_ACCESS_SHARED, "S", 0, shared};
    (void)state;
    assert_ptr_equal(ect_od_data(&(ect_od_t){.base = &a}, &offset), &a.v);
    assert_ptr_equal(ect_od_data(&(ect_od_t){.base = &b}, &offset), &b.v);
    assert_ptr_equal(ect_od_data(&(ect_od_t){.base = NULL}, &address), &number);
    assert_ptr_equal(ect_od_data(&(ect_od_t){.base = &a}, &text), shared);
    assert_int_equal(ect_od_write(&(ect_od_t){.base = &b}, &offset, 0, "\x0A\x0B\x0C\x0D", 4), ECT_OK);
    assert_int_equal(b.v.u32, 0x0D0C0B0A);
    assert_int_equal(a.v.u32, 1);
    assert_int_equal(ect_od_write(&(ect_od_t){.base = &a}, &text, 0, "SHARED", 6), ECT_REASON_READ_ONLY);
    assert_string_equal(shared, "shared");
}

static void texts(void **state)
{
    const ect_entry_t entry = {0, ECT_TYPE_VISIBLE_STRING, 64, ECT_ACCESS_RW, "T", 0, ECT_OFFSET(instance_t, v)};
    (void)state;
    for (uint16_t size = 0; size <= 8; size++) {
        for (uint16_t first = 0; first <= size; first++) {
            instance_t instance;
            const ect_od_t od = {.base = &instance};
            uint8_t got[8];
            memset(&instance, 'Z', sizeof instance);
            assert_int_equal(ect_od_write(&od, &entry, 0, "ABCDEFGH", first), ECT_OK);
            assert_int_equal(ect_od_write(&od, &entry, first, &"ABCDEFGH"[first], (uint16_t)(size - first)), ECT_OK);
            assert_int_equal(ect_od_upload_size(&od, &entry), size);
            ect_od_read(&od, &entry, 0, got, size);
            assert_memory_equal(got, "ABCDEFGH", size);
            assert_int_equal(instance.v.bytes[8], 'Z');
        }
    }
}

static void octets_in_pieces(void **state)
{
    const ect_entry_t entry = {0, ECT_TYPE_OCTET_STRING, 80, ECT_ACCESS_RW, "O", 0, ECT_OFFSET(instance_t, v)};
    (void)state;
    for (uint16_t first = 0; first <= 10; first++) {
        instance_t instance;
        const ect_od_t od = {.base = &instance};
        memset(&instance, 'Z', sizeof instance);
        assert_int_equal(ect_od_write(&od, &entry, 0, "0123456789", first), ECT_OK);
        assert_int_equal(instance.v.bytes[first], 'Z');
        assert_int_equal(ect_od_write(&od, &entry, first, &"0123456789"[first], (uint16_t)(10 - first)), ECT_OK);
        assert_memory_equal(instance.v.bytes, "0123456789ZZ", 12);
        assert_int_equal(ect_od_upload_size(&od, &entry), 10);
    }
}

/* --- numbers ------------------------------------------------------------------------------------------------------ */

static void numbers(void **state)
{
    static const struct {
        uint16_t type, bits;
        uint32_t want;
    } table[] = {{ECT_TYPE_UNSIGNED8, 8, 0xF8},         {ECT_TYPE_UNSIGNED16, 16, 0xE7F8},
                 {ECT_TYPE_UNSIGNED32, 32, 0xC5D6E7F8}, {ECT_TYPE_UNSIGNED64, 64, 0xC5D6E7F8},
                 {ECT_TYPE_BIT1 + 3, 4, 0x8},           {ECT_TYPE_INTEGER16, 16, 0xE7F8}};
    instance_t instance = {.v.u64 = 0x8192A3B4C5D6E7F8u};
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        const ect_entry_t entry = {0, table[i].type, table[i].bits, ECT_ACCESS_RO, "N", 0, ECT_OFFSET(instance_t, v)};
        const ect_object_t object = {0x2000, ECT_OBJECT_VAR, 0, 0, "O", &entry};
        const ect_od_t od = {.objects = &object, .count = 1, .base = &instance};
        uint32_t got = 0;
        assert_int_equal(ect_od_number(&od, 0x2000, 0, &got), ECT_OK);
        assert_int_equal(got, table[i].want);
    }
}

/* --- defaults ----------------------------------------------------------------------------------------------------- */

typedef struct defaulted {
    uint32_t none; /* offset 0 is no entry */
    uint8_t u8;
    int16_t i16;
    uint32_t u32;
    uint64_t u64;
    double real;
    char text[8];
    char whole[4];
    uint8_t octets[5];
    uint8_t bit;
    uint16_t untouched;
} defaulted_t;

static void defaults(void **state)
{
    static const uint8_t u64[8] = {1, 2, 3, 4, 5, 6, 7, 8}, real[8] = {0, 0, 0, 0, 0, 0, 0xF8, 0x3F}; /* 1.5 */
    static const ect_entry_t entries[] = {
        ECT_ENTRY(0, UNSIGNED8, 8, ECT_ACCESS_RO, "U8", 200, defaulted_t, u8),
        ECT_ENTRY(1, INTEGER16, 16, ECT_ACCESS_RO, "I16", (uint32_t)-5, defaulted_t, i16),
        ECT_ENTRY(2, UNSIGNED32, 32, ECT_ACCESS_RO, "U32", 0x89ABCDEF, defaulted_t, u32),
        ECT_ENTRY(3, UNSIGNED64, 64, ECT_ACCESS_RO, "U64", 0, defaulted_t, u64),
        ECT_ENTRY(4, REAL64, 64, ECT_ACCESS_RO, "REAL64", 0, defaulted_t, real),
        ECT_ENTRY(5, VISIBLE_STRING, 64, ECT_ACCESS_RO, "Text", 0, defaulted_t, text),
        ECT_ENTRY(6, VISIBLE_STRING, 32, ECT_ACCESS_RO, "Whole", 0, defaulted_t, whole),
        ECT_ENTRY(7, OCTET_STRING, 40, ECT_ACCESS_RO, "Octets", 0, defaulted_t, octets),
        ECT_ENTRY(8, BOOLEAN, 1, ECT_ACCESS_RO, "Bit", 1, defaulted_t, bit),
        ECT_ENTRY(9, UNSIGNED16, 16, ECT_ACCESS_RO, "Zero", 0, defaulted_t, untouched),
        {10, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RO, "No memory", 7, NULL},
    };
    static const ect_object_t object = ECT_RECORD(0x2000, "Everything", entries);
    static const ect_detail_t details[] = {{.index = 0x2000, .subindex = 3, .initial = u64},
                                           {.index = 0x2000, .subindex = 4, .initial = real},
                                           {.index = 0x2000, .subindex = 5, .initial = "abc"},
                                           {.index = 0x2000, .subindex = 6, .initial = "wxyz"},
                                           {.index = 0x2000, .subindex = 7, .initial = "12345"}};
    defaulted_t d = {.untouched = 0x5555};
    const ect_od_t od = {.objects = &object, .count = 1, .details = details, .detail_count = 5, .base = &d};
    (void)state;
    ect_od_set_defaults(&od);
    assert_int_equal(d.u8, 200);
    assert_int_equal(d.i16, -5);
    assert_int_equal(d.u32, 0x89ABCDEF);
    assert_true(d.u64 == 0x0807060504030201u);
    assert_true(d.real == 1.5);
    assert_string_equal(d.text, "abc");
    assert_memory_equal(d.whole, "wxyz", 4);
    assert_memory_equal(d.octets, "12345", 5);
    assert_int_equal(d.bit, 1);
    assert_int_equal(d.untouched, 0x5555);
}

/* 1000h, 1008h to 100Ah, 1018h and 1C00h of a device that repeats nothing of its description. */
static void described(void **state)
{
    static const ect_object_t objects[] = {
        ECT_OBJECT_DEVICE_TYPE,      ECT_OBJECT_ERROR_REGISTER, ECT_OBJECT_DEVICE_NAME, ECT_OBJECT_HARDWARE_VERSION,
        ECT_OBJECT_SOFTWARE_VERSION, ECT_OBJECT_IDENTITY,       ECT_OBJECT_SM_TYPES(3)};
    static const struct {
        uint16_t index;
        const char *text;
    } texts[] = {{0x1008, "A name"}, {0x1009, "v1"}, {0x100A, ""}};
    ect_device_t device = {.objects = objects,
                           .object_count = 7,
                           .type_name = "A name",
                           .hardware_version = "v1",
                           .software_version = "",
                           .device_type = 0x87654321,
                           .sm = {{.type = 3}, {.type = 4}, {.type = 4}},
                           .sm_count = 3};
    ect_standard_t instance = {.identity = {1, 2, 3, 0xFFFFFFFF}, .error_register = 9};
    const ect_od_t od = ect_device_od(&device, &instance);
    static const struct {
        uint16_t index;
        uint8_t subindex;
        uint32_t want;
    } rows[] = {{0x1000, 0, 0x87654321}, {0x1001, 0, 9}, {0x1018, 0, 4}, {0x1018, 1, 1}, {0x1018, 4, 0xFFFFFFFF},
                {0x1C00, 0, 3},          {0x1C00, 1, 3}, {0x1C00, 2, 4}, {0x1C00, 3, 4}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint32_t got = 0;
        assert_int_equal(ect_od_number(&od, rows[i].index, rows[i].subindex, &got), ECT_OK);
        if (got != rows[i].want)
            fail_msg("%04Xh:%u: expected %X, got %X", rows[i].index, rows[i].subindex, rows[i].want, got);
    }
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++) {
        const ect_entry_t *e = ect_od_find(&od, texts[i].index)->entries;
        char got[41] = "";
        uint16_t size = ect_od_upload_size(&od, e);
        ect_od_read(&od, e, 0, got, size);
        assert_string_equal(got, texts[i].text);
        assert_int_equal(ect_od_bits(&od, e), 8 * strlen(texts[i].text));
        assert_int_equal(ect_od_write(&od, e, 0, "x", 1), ECT_REASON_READ_ONLY);
    }
    assert_null(ect_od_entry(ect_od_find(&od, 0x1C00), 4));
    ect_od_set_defaults(&od);
    assert_string_equal(device.type_name, "A name");
}

/* --- limits ------------------------------------------------------------------------------------------------------- */

static void limits_are_found(void **state)
{
    static ect_detail_t limits[MOST];
    (void)state;
    for (uint16_t i = 0; i < MOST; i++)
        limits[i] = (ect_detail_t){.index = (uint16_t)(0x2000 + i / 10), .subindex = (uint8_t)(25 * (i % 10))};
    for (uint16_t count = 0; count <= MOST; count++) {
        ect_od_t od = {.details = limits, .detail_count = count};
        for (uint16_t index = 0x1FFF; index <= 0x2000 + MOST / 10; index++) {
            for (unsigned int sub = 0; sub <= 255; sub++) {
                unsigned int position = (index - 0x2000u) * 10u + sub / 25u;
                bool there = index >= 0x2000 && sub % 25 == 0 && sub < 250 && position < count;
                const ect_detail_t *got = ect_od_detail(&od, index, (uint8_t)sub);
                if (got != (there ? &limits[position] : NULL))
                    fail_msg("%u limits: %04Xh:%u is %sfound", count, index, sub, got ? "" : "not ");
            }
        }
    }
    assert_null(ect_od_detail(&(ect_od_t){.details = NULL, .detail_count = 5}, 0x2000, 0));
}

typedef struct limit_row {
    const char *name;
    uint16_t type, bits;
    int64_t minimum, maximum;
    uint64_t value;
    ect_reason_t want;
} limit_row_t;

static const limit_row_t limit_rows[] = {
    {"U8 at its highest", ECT_TYPE_UNSIGNED8, 8, 1, 200, 200, ECT_OK},
    {"U8 one above", ECT_TYPE_UNSIGNED8, 8, 1, 200, 201, ECT_REASON_TOO_HIGH},
    {"U8 is not signed", ECT_TYPE_UNSIGNED8, 8, 1, 200, 0xFF, ECT_REASON_TOO_HIGH},
    {"U8 at its lowest", ECT_TYPE_UNSIGNED8, 8, 1, 200, 1, ECT_OK},
    {"U8 one below", ECT_TYPE_UNSIGNED8, 8, 1, 200, 0, ECT_REASON_TOO_LOW},
    {"I8 negative", ECT_TYPE_INTEGER8, 8, -3, 3, 0xFD, ECT_OK},
    {"I8 one below", ECT_TYPE_INTEGER8, 8, -3, 3, 0xFC, ECT_REASON_TOO_LOW},
    {"I8 one above", ECT_TYPE_INTEGER8, 8, -3, 3, 4, ECT_REASON_TOO_HIGH},
    {"I16 negative", ECT_TYPE_INTEGER16, 16, -1000, 1000, 0xFC18, ECT_OK},
    {"I16 one below", ECT_TYPE_INTEGER16, 16, -1000, 1000, 0xFC17, ECT_REASON_TOO_LOW},
    {"I16 lowest of all", ECT_TYPE_INTEGER16, 16, -1000, 1000, 0x8000, ECT_REASON_TOO_LOW},
    {"I16 one above", ECT_TYPE_INTEGER16, 16, -1000, 1000, 1001, ECT_REASON_TOO_HIGH},
    {"U16 not signed", ECT_TYPE_UNSIGNED16, 16, 0, 0x8000, 0x8001, ECT_REASON_TOO_HIGH},
    {"I32 negative", ECT_TYPE_INTEGER32, 32, -1, 0, 0xFFFFFFFF, ECT_OK},
    {"I32 one below", ECT_TYPE_INTEGER32, 32, -1, 0, 0xFFFFFFFE, ECT_REASON_TOO_LOW},
    {"U32 not signed", ECT_TYPE_UNSIGNED32, 32, 0, 0x7FFFFFFF, 0x80000000, ECT_REASON_TOO_HIGH},
    {"U32 the highest of all", ECT_TYPE_UNSIGNED32, 32, 0, 0xFFFFFFFF, 0xFFFFFFFF, ECT_OK},
    {"I64 the lowest of all", ECT_TYPE_INTEGER64, 64, INT64_MIN, 0, 0x8000000000000000u, ECT_OK},
    {"I64 one below", ECT_TYPE_INTEGER64, 64, -5, 5, (uint64_t)-6, ECT_REASON_TOO_LOW},
    {"I64 one above", ECT_TYPE_INTEGER64, 64, -5, 5, 6, ECT_REASON_TOO_HIGH},
    {"U64 one above", ECT_TYPE_UNSIGNED64, 64, 0, 100, 101, ECT_REASON_TOO_HIGH},
    {"U64 largest signed", ECT_TYPE_UNSIGNED64, 64, 0, INT64_MAX, INT64_MAX, ECT_OK},
    {"BITARR8 one above", ECT_TYPE_BITARR8, 8, 0, 0x7F, 0x80, ECT_REASON_TOO_HIGH},
    {"BITARR32 one above", ECT_TYPE_BITARR32, 32, 0, 0x7F, 0x80, ECT_REASON_TOO_HIGH},
    {"BIT2 one above", ECT_TYPE_BIT1 + 1, 2, 0, 1, 2, ECT_REASON_TOO_HIGH},
    {"equal limits are none", ECT_TYPE_UNSIGNED8, 8, 5, 5, 6, ECT_OK},
    {"limits of 0 are none", ECT_TYPE_UNSIGNED8, 8, 0, 0, 1, ECT_OK},
    {"BIT3 one above", ECT_TYPE_BIT1 + 2, 3, 0, 4, 5, ECT_REASON_TOO_HIGH},
    {"BIT3 within", ECT_TYPE_BIT1 + 2, 3, 0, 4, 4, ECT_OK},
    {"U64 beyond the signed range", ECT_TYPE_UNSIGNED64, 64, 0, 100, UINT64_MAX, ECT_REASON_TOO_HIGH},
    {"U64 2^63", ECT_TYPE_UNSIGNED64, 64, 0, INT64_MAX, 0x8000000000000000u, ECT_REASON_TOO_HIGH},
};

static const limit_row_t other_rows[] = {
    {"no number: octets", ECT_TYPE_OCTET_STRING, 16, 0, 5, 0xFFFF, ECT_OK},
    {"no number: text", ECT_TYPE_VISIBLE_STRING, 32, 0, 5, 0x41424344, ECT_OK},
    {"longer than a number", ECT_TYPE_OCTET_STRING, 128, 0, 5, 0x41424344, ECT_OK},
    {"no integer: REAL32", ECT_TYPE_REAL32, 32, 0, 5, 0x41424344, ECT_OK},
    {"no integer: REAL64", ECT_TYPE_REAL64, 64, 0, 5, 0x41424344, ECT_OK},
    {"the last type of a set of bits: 0x1F", 0x1F, 16, 0, 5, 0x4344, ECT_OK},
    {"the first type behind a set of bits: 0x20", 0x20, 16, 0, 5, 0x4344, ECT_OK},
    {"a type between the numbers: 0x2C", 0x2C, 16, 0, 5, 0x4344, ECT_OK},
    {"a type above all that are known: 0x38", 0x38, 9, 0, 5, 0x44, ECT_OK},
    {"length not known", ECT_TYPE_OCTET_STRING, 0, 0, 5, 0x41424344, ECT_OK},
};

static void run_limits(const limit_row_t *rows, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        const limit_row_t *row = &rows[i];
        const ect_entry_t entry = {3, row->type, row->bits, ECT_ACCESS_RW, "E", 0, NULL};
        const ect_detail_t limit = {.index = 0x2000, .subindex = 3, .minimum = row->minimum, .maximum = row->maximum};
        const ect_od_t od = {.details = &limit, .detail_count = 1};
        uint8_t wire[16] = {0};
        ect_store_le64(wire, row->value);
        ect_reason_t got = ect_od_check_limit(&od, 0x2000, &entry, wire);
        if (got != row->want)
            fail_msg("%s: expected reason %d, got %d", row->name, (int)row->want, (int)got);
        assert_int_equal(ect_od_check_limit(&od, 0x2001, &entry, wire), ECT_OK);
    }
}

static void limits(void **state)
{
    (void)state;
    run_limits(limit_rows, sizeof limit_rows / sizeof limit_rows[0] - 2);
}

static void limits_of_large_numbers(void **state)
{
    (void)state;
    run_limits(limit_rows + sizeof limit_rows / sizeof limit_rows[0] - 2, 2);
}

static void limits_of_other_types(void **state)
{
    (void)state;
    run_limits(other_rows, sizeof other_rows / sizeof other_rows[0]);
}

/* --- links to numbers --------------------------------------------------------------------------------------------- */

enum { LINK_AT = 4, LINK_ROOM = 16 };

/* A number with memory has a link of its bytes; any other entry has none. */
static void entries_with_a_link(void **state)
{
    enum { UNSIGNED24 = 0x0016, UNSIGNED56 = 0x001A, RX = ECT_ACCESS_RXPDO, TX = ECT_ACCESS_TXPDO };
    static const struct {
        const char *what;
        uint16_t type, bits, access;
        uint32_t value;
        uintptr_t at;
        ect_link_t want;
    } rows[] = {
        {"INTEGER8", ECT_TYPE_INTEGER8, 8, RX, 0, 5, {5, 1, true, false, true, false}},
        {"INTEGER16", ECT_TYPE_INTEGER16, 16, TX, 7, 6, {6, 2, true, false, false, true}},
        {"INTEGER32", ECT_TYPE_INTEGER32, 32, RX | TX, 1, 8, {8, 4, true, false, true, true}},
        {"INTEGER64", ECT_TYPE_INTEGER64, 64, 0, 0, 16, {16, 8, true, false, false, false}},
        {"UNSIGNED8", ECT_TYPE_UNSIGNED8, 8, 0, 0, 300, {300, 1, false, false, false, false}},
        {"UNSIGNED16", ECT_TYPE_UNSIGNED16, 16, 0, 0, 6, {6, 2, false, false, false, false}},
        {"UNSIGNED32", ECT_TYPE_UNSIGNED32, 32, 0, 0, 6, {6, 4, false, false, false, false}},
        {"UNSIGNED64", ECT_TYPE_UNSIGNED64, 64, 0, 0, 6, {6, 8, false, false, false, false}},
        {"REAL32", ECT_TYPE_REAL32, 32, 0, 0, 6, {6, 4, false, true, false, false}},
        {"REAL64", ECT_TYPE_REAL64, 64, 0, 0, 6, {6, 8, false, true, false, false}},
        {"3 bytes", UNSIGNED24, 24, 0, 0, 6, {0}},
        {"7 bytes", UNSIGNED56, 56, 0, 0, 6, {0}},
        {"a text of 4 bytes", ECT_TYPE_VISIBLE_STRING, 32, 0, 0, 6, {0}},
        {"4 octets", ECT_TYPE_OCTET_STRING, 32, 0, 0, 6, {0}},
        {"no memory", ECT_TYPE_UNSIGNED32, 32, RX, 5, 0, {0}},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const ect_entry_t entry = {0,   rows[i].type,  rows[i].bits,      rows[i].access,
                                   "E", rows[i].value, (void *)rows[i].at};
        const ect_object_t object = {0x2000, ECT_OBJECT_VAR, 0, 0, "O", &entry};
        const ect_od_t od = {.objects = &object, .count = 1, .base = (void *)(uintptr_t)1};
        const ect_link_t got = ect_link_to(&od, 0x2000, 0), want = rows[i].want;
        if (got.offset != want.offset || got.bytes != want.bytes || got.is_signed != want.is_signed ||
            got.is_real != want.is_real || got.output != want.output || got.given != want.given)
            fail_msg("%s: expected %u bytes at %u, got %u at %u: signed %d, real %d, output %d, given %d", rows[i].what,
                     want.bytes, want.offset, got.bytes, got.offset, got.is_signed, got.is_real, got.output, got.given);
        assert_int_equal(ect_link_to(&od, 0x2001, 0).bytes, 0);
        assert_int_equal(ect_link_to(&od, 0x2000, 1).bytes, 0);
    }
}

/* Elements count from 0: that of a variable is its value, that of another object the sub-index behind its number. */
static void elements_with_a_link(void **state)
{
    static const ect_entry_t one[] = {{0, ECT_TYPE_UNSIGNED16, 16, 0, "E", 0, (void *)0x20}};
    static const ect_entry_t several[] = {{0, ECT_TYPE_UNSIGNED8, 8, 0, "N", 0, (void *)0x40},
                                          {1, ECT_TYPE_UNSIGNED16, 16, 0, "1", 0, (void *)0x41},
                                          {2, ECT_TYPE_UNSIGNED16, 16, 0, "2", 0, (void *)0x43},
                                          {255, ECT_TYPE_UNSIGNED16, 16, 0, "255", 0, (void *)0x45}};
    static const ect_object_t objects[] = {{0x2000, ECT_OBJECT_VAR, 0, 0, "V", one},
                                           {0x2001, ECT_OBJECT_RECORD, 255, 3, "R", several}};
    static const struct {
        uint16_t index;
        unsigned int number;
        uint32_t offset; /* 0: no link */
    } rows[] = {{0x2000, 0, 0x20},   {0x2000, 1, 0},   {0x2001, 0, 0x41}, {0x2001, 1, 0x43}, {0x2001, 2, 0},
                {0x2001, 254, 0x45}, {0x2001, 255, 0}, {0x2001, 256, 0},  {0x2002, 0, 0}};
    const ect_od_t od = {.objects = objects, .count = 2, .base = (void *)(uintptr_t)1};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const ect_link_t got = ect_link_to_element(&od, rows[i].index, rows[i].number);
        if (got.offset != rows[i].offset || (got.bytes != 0) != (rows[i].offset != 0))
            fail_msg("element %u of %04X: expected the offset %u, got %u with %u bytes", rows[i].number, rows[i].index,
                     rows[i].offset, got.offset, got.bytes);
    }
}

/* A value that is stored is limited to the type, and no byte beside it changes. */
static void linked_integers(void **state)
{
    enum { MOST_EXACT = 53 }; /* bits of a number that is loaded */
    static const struct {
        uint8_t bytes;
        bool is_signed;
        int64_t value, want;
    } rows[] = {
        {1, false, 0, 0},
        {1, false, 255, 255},
        {1, false, 256, 255},
        {1, false, -1, 0},
        {1, true, 127, 127},
        {1, true, 128, 127},
        {1, true, -128, -128},
        {1, true, -129, -128},
        {2, false, 65535, 65535},
        {2, false, 65536, 65535},
        {2, false, INT64_MIN, 0},
        {2, true, 32767, 32767},
        {2, true, 32768, 32767},
        {2, true, -32768, -32768},
        {2, true, -32769, -32768},
        {4, false, UINT32_MAX, UINT32_MAX},
        {4, false, (int64_t)UINT32_MAX + 1, UINT32_MAX},
        {4, false, -5, 0},
        {4, true, INT32_MAX, INT32_MAX},
        {4, true, (int64_t)INT32_MAX + 1, INT32_MAX},
        {4, true, INT32_MIN, INT32_MIN},
        {4, true, (int64_t)INT32_MIN - 1, INT32_MIN},
        {8, true, (INT64_C(1) << MOST_EXACT) - 1, (INT64_C(1) << MOST_EXACT) - 1},
        {8, true, (INT64_C(1) << MOST_EXACT) + 1, INT64_C(1) << MOST_EXACT},
        {8, true, -(INT64_C(1) << MOST_EXACT) - 1, -(INT64_C(1) << MOST_EXACT)},
        {8, false, 12345678901, 12345678901},
        {0, false, 5, 0},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const ect_link_t link = {.offset = LINK_AT, .bytes = rows[i].bytes, .is_signed = rows[i].is_signed};
        uint8_t instance[LINK_ROOM];
        memset(instance, 0x5A, sizeof instance);
        ect_link_store(instance, &link, rows[i].value);
        const int64_t got = ect_link_load(instance, &link);
        if (got != rows[i].want)
            fail_msg("row %zu: expected %lld, got %lld", i, (long long)rows[i].want, (long long)got);
        assert_true(ect_link_load_real(instance, &link) == (double)rows[i].want);
        for (size_t k = 0; k < sizeof instance; k++)
            assert_true(instance[k] == 0x5A || (k >= LINK_AT && k < LINK_AT + (size_t)rows[i].bytes));
        memset(instance, 0x5A, sizeof instance);
        ect_link_store_real(instance, &link, (double)rows[i].value);
        assert_true(ect_link_load(instance, &link) == rows[i].want || rows[i].bytes == 8);
    }
}

/* With a fraction for a floating-point entry, rounded for others. */
static void linked_reals(void **state)
{
    static const struct {
        uint8_t bytes;
        bool is_real;
        double value, want;
        int64_t rounded;
    } rows[] = {
        {4, true, 1.25, 1.25, 1},
        {4, true, -1.5, -1.5, -2},
        {4, true, 1e300, (double)FLT_MAX, INT64_C(1) << 53},
        {4, true, -1e300, -(double)FLT_MAX, -(INT64_C(1) << 53)},
        {8, true, 2.5, 2.5, 3},
        {8, true, 1e300, 1e300, INT64_C(1) << 53},
        {8, true, -1e300, -1e300, -(INT64_C(1) << 53)},
        {2, false, 1.4, 1, 1},
        {2, false, 1.6, 2, 2},
        {2, false, -0.6, 0, 0},
        {0, true, 1.5, 0, 0},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const ect_link_t link = {.offset = LINK_AT, .bytes = rows[i].bytes, .is_real = rows[i].is_real};
        uint8_t instance[LINK_ROOM] = {0};
        ect_link_store_real(instance, &link, rows[i].value);
        if (ect_link_load_real(instance, &link) != rows[i].want || ect_link_load(instance, &link) != rows[i].rounded)
            fail_msg("row %zu: got %g, rounded %lld", i, ect_link_load_real(instance, &link),
                     (long long)ect_link_load(instance, &link));
        ect_link_store(instance, &link, 3);
        assert_true(ect_link_load_real(instance, &link) == (rows[i].bytes == 0 ? 0 : 3));
    }
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"FZM-011 FZM-012 FZM-013 FZM-014: each reason has its abort code; 26 of them are the sensor's list",
         abort_codes, NULL, NULL, NULL},
        {"FZM-010 FZM-012: an index is found in a list of any length if and only if it exists", lookup_of_objects, NULL,
         NULL, NULL},
        {"FZM-012 CF-068: a sub-index is found if and only if it exists, with gaps too", lookup_of_entries, NULL, NULL,
         NULL},
        {"FZM-012 FZM-014 CF-078: every access word in every state and direction has the right result", rights, NULL,
         NULL, NULL},
        {"CF-077: every data type is little-endian on the wire, whole and in slices", wire_form, NULL, NULL, NULL},
        {"CF-077: BIT1 to BIT8 read and store their bits only", bits_of_a_byte, NULL, NULL, NULL},
        {"CF-077: a write to a BOOLEAN stores bit 0", a_boolean_is_a_bit, NULL, NULL, NULL},
        {"CF-077: an entry without memory reads as its value and cannot be written", entries_without_memory, NULL, NULL,
         NULL},
        {"CF-077: one table serves many instances; a shared constant cannot be written", addresses_and_offsets, NULL,
         NULL, NULL},
        {"CF-069: a text shorter than its room is terminated and uploads its characters", texts, NULL, NULL, NULL},
        {"CF-069: octets are written in any two pieces", octets_in_pieces, NULL, NULL, NULL},
        {"CF-077: an entry reads as a number of at most 32 bits", numbers, NULL, NULL, NULL},
        {"CF-068: counted entries end there, whatever max_subindex is", counted_entries, NULL, NULL, NULL},
        {"CF-077: defaults of every type, short and long, are in the instance", defaults, NULL, NULL, NULL},
        {"CF-057 CF-077: type, name, versions, identity and SyncManagers are read from the description", described,
         NULL, NULL, NULL},
        {"FZM-013: a limit is found if and only if it exists", limits_are_found, NULL, NULL, NULL},
        {"FZM-013 CF-070: a value above or below its limits is refused with its reason", limits, NULL, NULL, NULL},
        {"FZM-013: an UNSIGNED64 above 2^63 is too high, not too low", limits_of_large_numbers, NULL, NULL, NULL},
        {"FZM-013: an entry that is no number has no limits", limits_of_other_types, NULL, NULL, NULL},
        {"a linked integer has the range of its type", linked_integers, NULL, NULL, NULL},
        {"a number with memory has a link, any other entry none", entries_with_a_link, NULL, NULL, NULL},
        {"the elements of an object have links by their number", elements_with_a_link, NULL, NULL, NULL},
        {"a linked floating-point number keeps its fraction, others are rounded", linked_reals, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Object dictionary", tests, NULL, NULL);
}
