/* SPDX-License-Identifier: MIT */
/* The reader of a slave against honest slaves: every device of the house, in every state, over a wire that loses
 * frames. */
#define _GNU_SOURCE
#include "reader/reader.h"

#include <cjson/cJSON.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "od/od.h"
#include "seams/device.h"
#include "support/every.h"
#include "support/liar.h"
#include "support/testdev.h"

enum { INIT = 1, PREOP = 2, SAFEOP = 4, OP = 8, ABORT_NO_SUBINDEX = 0x06090011, ABORT_NO_OBJECT = 0x06020000 };

static ect_reader_t reader;
static uint8_t image[ECT_READER_SII];

static void open_reader(liar_t *l, const ect_device_t *device, const liar_kind_t *kind)
{
    liar_open(l, device, kind);
    assert_int_equal(ect_reader_open(&reader, &l->link, NULL), ECT_READER_OK);
}

static void close_reader(liar_t *l)
{
    ect_reader_close(&reader);
    liar_close(l);
}

/* The dictionary of a slave as JSON text, for free(). `number`: liar_t::number at its begin */
static char *json_of(const ect_device_t *device, const liar_kind_t *kind, uint64_t number, ect_reader_values_t values)
{
    char *json = NULL;
    size_t length;
    liar_t l;
    open_reader(&l, device, kind);
    l.number = number;
    FILE *file = open_memstream(&json, &length);
    assert_int_equal(ect_reader_json(&reader, values, file), ECT_READER_OK);
    assert_int_equal(fclose(file), 0);
    close_reader(&l);
    return json;
}

/* --- EEPROM ------------------------------------------------------------------------------------------------------- */

static void the_eeprom_of_every_device_is_read(void **state)
{
    (void)state;
    for (size_t i = 0; every_device(i) != NULL; i++) {
        const ect_device_t *device = every_device(i);
        liar_t l;
        size_t size;
        open_reader(&l, device, NULL);
        assert_int_equal(reader.count, 1);
        assert_int_equal(reader.vendor, device->identity.vendor_id);
        assert_int_equal(reader.product, device->identity.product_code);
        assert_int_equal(reader.revision, device->identity.revision);
        assert_int_equal(reader.protocols, device->mailbox_protocols);
        assert_int_equal(ect_reader_sii(&reader, image, 0, &size), ECT_READER_OK);
        assert_int_equal(size, device->sii_size);
        assert_memory_equal(image, ect_chain_esc(l.w.chain, 0)->config.sii, size);
        assert_string_equal(reader.text, "");
        close_reader(&l);
    }
}

static void a_part_of_the_eeprom_is_read(void **state)
{
    liar_t l;
    size_t size;
    (void)state;
    open_reader(&l, &testdev, NULL);
    memset(image, 0x5A, sizeof image);
    assert_int_equal(ect_reader_sii(&reader, image, 20, &size), ECT_READER_OK);
    assert_int_equal(size, 20);
    assert_memory_equal(image, ect_chain_esc(l.w.chain, 0)->config.sii, 20);
    assert_int_equal(image[20], 0x5A);
    close_reader(&l);
}

/* Size in the header, or 0: that of the device; a copy of the EEPROM with it. */
static void the_content_of_an_eeprom_ends_at_the_end_mark(void **state)
{
    static const struct {
        const char *title;
        uint16_t size_word; /* 0xFFFF: larger than any reader takes */
        size_t mark;        /* byte of the end mark; 0: none */
        size_t expected;
    } cases[] = {
        {"end mark right behind the header", 7, 0x80, 0x84}, {"end mark behind a category of one word", 7, 0x86, 0x8C},
        {"end mark in the last word", 0, 0xFC, 0x100},       {"no end mark", 1, 0, 0x100},
        {"a size that is garbage", 0xFFFF, 0x90, 0x94},
    };
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        uint8_t sii[1024] = {0};
        const size_t bytes = cases[i].mark > 0 ? cases[i].mark : 0x100;
        ect_esc_t *esc;
        liar_t l;
        size_t size;
        liar_open(&l, &testdev, NULL);
        esc = ect_chain_esc(l.w.chain, 0);
        memcpy(sii, esc->config.sii, 0x80);
        ect_store_le16(sii + 0x7C, cases[i].size_word != 0 ? cases[i].size_word : 1);
        for (size_t at = 0x80; at < bytes; at += 4 + 2 * (size_t)ect_load_le16(sii + at + 2)) {
            ect_store_le16(sii + at, 30);
            ect_store_le16(sii + at + 2, (uint16_t)((bytes - at) % 4 != 0 ? 1 : 0));
        }
        if (cases[i].mark > 0)
            ect_store_le16(sii + cases[i].mark, 0xFFFF);
        esc->config.sii = sii;
        esc->config.sii_size = sizeof sii;
        assert_int_equal(ect_reader_open(&reader, &l.link, NULL), ECT_READER_OK);
        memset(image, 0x5A, sizeof image);
        assert_int_equal(ect_reader_sii_content(&reader, image, &size), ECT_READER_OK);
        if (size != cases[i].expected)
            fail_msg("%s: expected %zu bytes, got %zu", cases[i].title, cases[i].expected, size);
        assert_memory_equal(image, sii, size);
        assert_int_equal(image[size], 0x5A);
        close_reader(&l);
    }
}

static void the_pdi_gets_the_eeprom_back(void **state)
{
    liar_t l;
    (void)state;
    liar_open(&l, &testdev, NULL);
    assert_int_equal(wire_write8(&l.w, 0, ECT_REG_SII_CONFIG, 1), 1);
    assert_int_equal(ect_reader_open(&reader, &l.link, NULL), ECT_READER_OK);
    assert_int_equal(wire_read8(&l.w, 0, ECT_REG_SII_CONFIG) & 1, 0);
    ect_reader_close(&reader);
    assert_int_equal(wire_read8(&l.w, 0, ECT_REG_SII_CONFIG) & 1, 1);
    assert_int_equal(wire_write8(&l.w, 0, ECT_REG_SII_CONFIG, 0), 1);
    ect_reader_close(&reader);
    assert_int_equal(wire_read8(&l.w, 0, ECT_REG_SII_CONFIG) & 1, 0); /* returned once */
    liar_close(&l);
}

/* Sets an error of the command before, in the number; counts the writes of zeros that clear it in the upper half. */
static bool has_failed(liar_t *l, uint8_t *d, uint16_t ado, uint8_t *data, uint16_t length, uint8_t *wkc)
{
    (void)wkc;
    if (ado != ECT_REG_SII_CONTROL)
        return true;
    if (d[0] == APRD && l->number < 0x10000)
        data[1] |= (uint8_t)(l->number >> 8);
    if (d[0] == APWR && length == 2 && ect_load_le16(data) == 0)
        l->number += 0x10000;
    return true;
}

/* ETG.1000.4 clause 6.4: a command is refused while an error of the previous command is pending. */
static void an_error_of_the_eeprom_is_cleared_before_a_command(void **state)
{
    static const uint16_t errors[] = {0x0000, 0x2000, 0x4000, 0x6000, 0x1800};
    static const liar_kind_t kind = {.datagram = has_failed};
    (void)state;
    for (size_t i = 0; i < sizeof errors / sizeof errors[0]; i++) {
        size_t size;
        liar_t l;
        open_reader(&l, &testdev, &kind);
        l.number = errors[i];
        assert_int_equal(ect_reader_sii(&reader, image, 4, &size), ECT_READER_OK);
        if (l.number >> 16 != ((errors[i] & 0x6000) != 0))
            fail_msg("0x%04X: cleared %u times", errors[i], (unsigned int)(l.number >> 16));
        l.kind = NULL;
        close_reader(&l);
    }
}

/* A size beyond 128 KiB is none: the header is all that is read. */
static void the_largest_eeprom_is_read_whole(void **state)
{
    static const struct {
        uint16_t size_word;
        size_t size;
    } rows[] = {{ECT_READER_SII / 128 - 1, ECT_READER_SII}, {ECT_READER_SII / 128, ECT_READER_HEADER}};
    static uint8_t sii[1024];
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        size_t size;
        liar_t l;
        open_reader(&l, &testdev, NULL);
        ect_esc_t *esc = ect_chain_esc(l.w.chain, 0);
        memcpy(sii, esc->config.sii, 0x80);
        ect_store_le16(sii + 0x7C, rows[i].size_word);
        esc->config.sii = sii;
        esc->config.sii_size = sizeof sii;
        assert_int_equal(ect_reader_sii(&reader, image, 0, &size), ECT_READER_OK);
        assert_int_equal(size, rows[i].size);
        close_reader(&l);
    }
}

/* A slave whose PDI owns the interface, or uses it: the bytes at 0500h and 0501h, the low half of the number. The high
 * half has the writes of the reader, one digit for each byte, and the value plus one. */
static bool says_who_owns(liar_t *l, uint8_t *d, uint16_t ado, uint8_t *data, uint16_t length, uint8_t *wkc)
{
    (void)wkc;
    if (ado != ECT_REG_SII_CONFIG)
        return true;
    if (d[0] == APRD)
        ect_store_le16(data, (uint16_t)l->number);
    for (uint16_t i = 0; d[0] == APWR && i < length; i++)
        l->number = (l->number >> 16 << 20) | (uint64_t)(data[i] + 1u) << 16 | (l->number & 0xFFFF);
    return true;
}

static void the_eeprom_is_taken_from_a_pdi_that_uses_it(void **state)
{
    static const struct {
        uint16_t owner;
        uint64_t written;
    } rows[] = {{0x0000, 0}, {0x0001, 0x1}, {0x0100, 0x31}, {0x0101, 0x31}, {0xFE00, 0}, {0x00FE, 0}, {0x0300, 0x31}};
    static const liar_kind_t kind = {.datagram = says_who_owns};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        size_t size;
        liar_t l;
        open_reader(&l, &testdev, &kind);
        l.number = rows[i].owner;
        assert_int_equal(ect_reader_sii(&reader, image, 128, &size), ECT_READER_OK);
        if (l.number >> 16 != rows[i].written)
            fail_msg("0x%04X: expected %" PRIx64 ", got %" PRIx64, rows[i].owner, rows[i].written, l.number >> 16);
        l.kind = NULL;
        close_reader(&l);
    }
}

/* --- states ------------------------------------------------------------------------------------------------------- */

static void a_slave_in_init_returns_to_init_with_the_sync_managers_it_had(void **state)
{
    uint8_t before[16], after[16], value[4];
    size_t size = sizeof value;
    liar_t l;
    (void)state;
    liar_open(&l, &testdev, NULL);
    wire_set_sm(&l.w, 0, 0, 0x1234, 0, 0);
    assert_int_equal(wire_read(&l.w, 0, ECT_REG_SM, before, sizeof before), 1);
    assert_int_equal(ect_reader_open(&reader, &l.link, NULL), ECT_READER_OK);
    assert_int_equal(wire_read8(&l.w, 0, ECT_REG_AL_STATUS), INIT); /* to read the EEPROM needs no state */
    assert_int_equal(ect_reader_upload(&reader, 0x1018, 1, false, value, &size), ECT_READER_OK);
    assert_int_equal(wire_read8(&l.w, 0, ECT_REG_AL_STATUS), PREOP);
    wire_advance(&l.w, 3600 * 1000ull * MS); /* the limit of the end counts from then */
    ect_reader_close(&reader);
    assert_int_equal(wire_read8(&l.w, 0, ECT_REG_AL_STATUS), INIT);
    assert_int_equal(wire_read(&l.w, 0, ECT_REG_SM, after, sizeof after), 1);
    before[ECT_SM_STATUS] = after[ECT_SM_STATUS] = 0;
    before[8 + ECT_SM_STATUS] = after[8 + ECT_SM_STATUS] = 0;
    assert_memory_equal(before, after, sizeof before);
    liar_close(&l);
}

static void a_slave_at_work_stays_in_its_state(void **state)
{
    static const uint8_t states[] = {PREOP, SAFEOP, OP};
    (void)state;
    for (size_t i = 0; i < sizeof states; i++) {
        uint8_t value[4];
        size_t size = sizeof value;
        liar_t l;
        liar_open(&l, &testdev, NULL);
        wire_go(&l.w, 0, states[i]);
        assert_int_equal(ect_reader_open(&reader, &l.link, NULL), ECT_READER_OK);
        assert_int_equal(ect_reader_upload(&reader, 0x1018, 1, false, value, &size), ECT_READER_OK);
        assert_int_equal(ect_load_le32(value), testdev.identity.vendor_id);
        assert_int_equal(wire_read8(&l.w, 0, ECT_REG_AL_STATUS), states[i]);
        ect_reader_close(&reader);
        assert_int_equal(wire_read8(&l.w, 0, ECT_REG_AL_STATUS), states[i]);
        liar_close(&l);
    }
}

static void a_slave_with_the_error_flag_is_acknowledged(void **state)
{
    uint8_t value[4];
    uint16_t code;
    size_t size = sizeof value;
    liar_t l;
    (void)state;
    liar_open(&l, &testdev, NULL);
    assert_int_equal(wire_al(&l.w, 0, OP, &code), INIT | ECT_AL_ERROR);
    assert_int_equal(ect_reader_open(&reader, &l.link, NULL), ECT_READER_OK);
    assert_int_equal(reader.found_status, INIT | ECT_AL_ERROR);
    assert_int_equal(ect_reader_upload(&reader, 0x1018, 1, false, value, &size), ECT_READER_OK);
    close_reader(&l);
}

static void a_refused_state_is_reported_with_its_code(void **state)
{
    uint8_t value[4];
    size_t size = sizeof value;
    liar_t l;
    (void)state;
    open_reader(&l, &testdev, NULL);
    testdev_of(&l.w, 0)->state_change_answer = 0x8123;
    assert_int_equal(ect_reader_upload(&reader, 0x1018, 1, false, value, &size), ECT_READER_REFUSED);
    assert_int_equal(reader.code, 0x8123);
    assert_string_equal(reader.text, "the slave refuses PREOP with AL status code 0x8123");
    assert_int_equal(size, 0);
    ect_reader_close(&reader);
    assert_string_equal(reader.text, "the slave refuses PREOP with AL status code 0x8123");
    liar_close(&l);
}

static void the_third_of_three_slaves_is_read_and_the_others_are_left_alone(void **state)
{
    const ect_device_t *const devices[] = {&testdev, &testdev, &testdev};
    const ect_reader_config_t third = {.position = 2}, fourth = {.position = 3};
    uint8_t value[4];
    size_t size = sizeof value;
    liar_t l = {0};
    (void)state;
    wire_open(&l.w, devices, 3);
    liar_attach(&l, NULL);
    assert_int_equal(ect_reader_open(&reader, &l.link, &third), ECT_READER_OK);
    assert_int_equal(reader.count, 3);
    testdev_of(&l.w, 2)->u32 = 77;
    assert_int_equal(ect_reader_upload(&reader, 0x2000, 0, false, value, &size), ECT_READER_OK);
    assert_int_equal(ect_load_le32(value), 77);
    assert_int_equal(wire_read8(&l.w, 0, ECT_REG_AL_STATUS), INIT);
    assert_int_equal(wire_read8(&l.w, 1, ECT_REG_AL_STATUS), INIT);
    ect_reader_close(&reader);
    assert_int_equal(ect_reader_open(&reader, &l.link, &fourth), ECT_READER_LOST);
    assert_string_equal(reader.text, "the segment has only 3 slaves");
    close_reader(&l);
}

static void a_slave_is_addressed_by_its_station_address(void **state)
{
    const ect_device_t *const devices[] = {&testdev, &testdev, &testdev};
    const ect_reader_config_t third = {.station = WIRE_STATION + 2}, unknown = {.station = WIRE_STATION + 3};
    uint8_t value[4];
    size_t size = sizeof value;
    liar_t l = {0};
    (void)state;
    wire_open(&l.w, devices, 3);
    liar_attach(&l, NULL);
    assert_int_equal(ect_reader_open(&reader, &l.link, &third), ECT_READER_OK);
    testdev_of(&l.w, 2)->u32 = 77;
    assert_int_equal(ect_reader_upload(&reader, 0x2000, 0, false, value, &size), ECT_READER_OK);
    assert_int_equal(ect_load_le32(value), 77);
    assert_int_equal(wire_read8(&l.w, 0, ECT_REG_AL_STATUS), INIT);
    assert_int_equal(wire_read8(&l.w, 2, ECT_REG_AL_STATUS), PREOP);
    ect_reader_close(&reader);
    assert_int_equal(wire_read8(&l.w, 2, ECT_REG_AL_STATUS), INIT);
    assert_int_equal(ect_reader_open(&reader, &l.link, &unknown), ECT_READER_LOST);
    close_reader(&l);
}

static bool keep_frame(liar_t *l, uint8_t *d, uint16_t ado, uint8_t *data, uint16_t length, uint8_t *wkc)
{
    (void)length;
    (void)wkc;
    if (d[0] == APWR && ado == ECT_REG_AL_CONTROL)
        l->number = ect_load_le16(data);
    assert_int_not_equal(d[1], l->mail[0]); /* a late frame differs in its index from the frame that is due */
    l->mail[0] = d[1];
    return true;
}

/* The controller replies to any destination; a source that is a group address would make it no Ethernet frame. */
static void frames_are_broadcasts_from_a_local_address(void **state)
{
    static const uint8_t header[14] = {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0x02, 0, 0, 0, 0, 1, 0x88, 0xA4};
    static const liar_kind_t kind = {.datagram = keep_frame};
    liar_t l;
    (void)state;
    open_reader(&l, &testdev, &kind);
    assert_memory_equal(reader.frame, header, sizeof header);
    assert_int_equal(ect_reader_preop(&reader), ECT_READER_OK);
    assert_int_equal(l.number, PREOP | ECT_AL_ACKNOWLEDGE); /* the upper byte is reserved */
    assert_int_equal(wire_read8(&l.w, 0, ECT_REG_SII_CONFIG), 0);
    close_reader(&l);
}

/* The data of a read that the reader has just sent, in reader.frame. */
static bool sends_zeros_in_reads(liar_t *l, uint8_t *d, uint16_t ado, uint8_t *data, uint16_t length, uint8_t *wkc)
{
    static const uint8_t zeros[ECT_READER_MAIL];
    (void)ado;
    (void)data;
    (void)wkc;
    if (d[0] == APRD) {
        assert_memory_equal(reader.frame + 26, zeros, length);
        l->number++;
    }
    return true;
}

/* A slave that does not process a datagram returns its data: the previous content of a buffer is no reply. */
static void the_data_of_a_read_are_sent_as_zeros(void **state)
{
    static const liar_kind_t kind = {.datagram = sends_zeros_in_reads};
    uint8_t bytes[8];
    liar_t l;
    (void)state;
    open_reader(&l, &testdev, &kind);
    memset(bytes, 0x5A, sizeof bytes);
    l.number = 0;
    assert_int_equal(ect_reader_registers(&reader, 0x0000, bytes, sizeof bytes), ECT_READER_OK);
    assert_int_equal(l.number, 1);
    close_reader(&l);
}

/* --- uploads ------------------------------------------------------------------------------------------------------ */

static void uploads_of_every_length_arrive_whole(void **state)
{
    uint8_t value[1000];
    liar_t l;
    (void)state;
    open_reader(&l, &testdev, NULL);
    assert_int_equal(ect_reader_preop(&reader), ECT_READER_OK);
    testdev_t *t = testdev_of(&l.w, 0);
    for (size_t i = 0; i < sizeof t->octets; i++)
        t->octets[i] = (uint8_t)(i * 7 + i / 256);
    const struct {
        uint16_t index;
        uint8_t subindex;
        size_t size;
        const void *data;
    } entries[] = {{0x2006, 1, 1, &t->record_bool},
                   {0x2007, 4, 2, &t->array[3]},
                   {0x1018, 1, 4, &testdev.identity.vendor_id},
                   {0x2009, 0, 8, &t->u64},
                   {0x1008, 0, 18, "ectwin test device"},
                   {0x2002, 0, 1000, t->octets}};
    t->array[3] = 0x1234;
    t->u64 = 0x1122334455667788u;
    for (size_t i = 0; i < sizeof entries / sizeof entries[0]; i++) {
        size_t size = sizeof value;
        assert_int_equal(ect_reader_upload(&reader, entries[i].index, entries[i].subindex, false, value, &size),
                         ECT_READER_OK);
        assert_int_equal(size, entries[i].size);
        assert_memory_equal(value, entries[i].data, size);
        size--; /* no room for the last byte */
        const size_t room = size;
        memset(value, 0xA5, sizeof value);
        assert_int_equal(ect_reader_upload(&reader, entries[i].index, entries[i].subindex, false, value, &size),
                         ECT_READER_TOO_LONG);
        assert_int_equal(size, room + 1);
        assert_int_equal(value[room], 0xA5);
    }
    close_reader(&l);
}

static void an_object_is_uploaded_by_complete_access(void **state)
{
    uint8_t value[64];
    size_t size = sizeof value;
    liar_t l;
    (void)state;
    open_reader(&l, &testdev, NULL);
    assert_int_equal(ect_reader_preop(&reader), ECT_READER_OK);
    for (unsigned int i = 0; i < 4; i++)
        testdev_of(&l.w, 0)->array[i] = (uint16_t)(0x1111 * (i + 1));
    assert_int_equal(ect_reader_upload(&reader, 0x2007, 0, true, value, &size), ECT_READER_OK);
    assert_int_equal(size, 10); /* sub-index 0 takes two bytes */
    assert_int_equal(value[0], 4);
    assert_int_equal(ect_load_le16(value + 8), 0x4444);
    size = sizeof value;
    assert_int_equal(ect_reader_upload(&reader, 0x2007, 1, true, value, &size), ECT_READER_OK);
    assert_int_equal(size, 8);
    assert_int_equal(ect_load_le16(value), 0x1111);
    close_reader(&l);
}

static void an_abort_is_reported_with_its_code_and_the_next_upload_works(void **state)
{
    uint8_t value[4];
    size_t size = sizeof value;
    liar_t l;
    (void)state;
    open_reader(&l, &testdev, NULL);
    assert_int_equal(ect_reader_upload(&reader, 0x4711, 2, false, value, &size), ECT_READER_ABORTED);
    assert_int_equal(reader.code, ABORT_NO_OBJECT);
    assert_string_equal(reader.text, "4711:02: the slave aborts with 0x06020000");
    size = sizeof value;
    assert_int_equal(ect_reader_upload(&reader, 0x1018, 9, false, value, &size), ECT_READER_ABORTED);
    assert_int_equal(reader.code, ABORT_NO_SUBINDEX);
    size = sizeof value;
    assert_int_equal(ect_reader_upload(&reader, 0x1018, 2, false, value, &size), ECT_READER_OK);
    assert_int_equal(ect_load_le32(value), testdev.identity.product_code);
    assert_int_equal(reader.result, ECT_READER_OK);
    assert_string_equal(reader.text, "");
    close_reader(&l);
}

/* --- descriptions ------------------------------------------------------------------------------------------------- */

static void objects_and_entries_are_described(void **state)
{
    ect_reader_object_t object;
    ect_reader_entry_t entry;
    size_t count;
    liar_t l;
    (void)state;
    open_reader(&l, &testdev, NULL);
    assert_int_equal(ect_reader_list(&reader, &count), ECT_READER_OK);
    assert_int_equal(count, testdev.object_count);
    for (uint16_t i = 0; i < testdev.object_count; i++)
        assert_true((reader.objects[testdev.objects[i].index / 8] >> testdev.objects[i].index % 8 & 1) != 0);
    assert_int_equal(ect_reader_object(&reader, 0x2008, &object), ECT_READER_OK);
    assert_true(object.described);
    assert_int_equal(object.most, 5);
    assert_int_equal(object.code, 9);
    assert_int_equal(object.name.length, 13);
    assert_memory_equal(object.name.data, "Sparse record", 13);
    assert_int_equal(ect_reader_entry(&reader, 0x2005, 0, &entry), ECT_READER_OK);
    assert_int_equal(entry.type, ECT_TYPE_INTEGER16);
    assert_int_equal(entry.bits, 16);
    assert_int_equal(entry.access, ECT_ACCESS_RW);
    assert_int_equal(ect_load_le16(entry.unit.data), 0x2D);
    assert_int_equal((int16_t)ect_load_le16(entry.minimum.data), -100);
    assert_int_equal(ect_load_le16(entry.maximum.data), 200);
    assert_int_equal(ect_load_le16(entry.preset.data), 5);
    assert_memory_equal(entry.name.data, "Limited", 7);
    assert_null(entry.value.data);
    assert_int_equal(ect_reader_entry(&reader, 0x2008, 2, &entry), ECT_READER_OK); /* a gap */
    assert_int_equal(entry.type, 0);
    assert_int_equal(ect_reader_entry(&reader, 0x2008, 6, &entry), ECT_READER_ABORTED);
    assert_int_equal(ect_reader_object(&reader, 0x2999, &object), ECT_READER_ABORTED);
    assert_int_equal(reader.code, ABORT_NO_OBJECT);
    close_reader(&l);
}

/* --- dictionary --------------------------------------------------------------------------------------------------- */

typedef struct seen {
    const ect_device_t *device;
    bool described;
    size_t objects, entries, values;
    unsigned int last;
} seen_t;

static void see_begin(void *ctx, bool described)
{
    ((seen_t *)ctx)->described = described;
}

static void see_object(void *ctx, const ect_reader_object_t *object)
{
    seen_t *s = ctx;
    const ect_od_t od = ect_device_od(s->device, NULL);
    const ect_object_t *expected = ect_od_find(&od, object->index);
    assert_non_null(expected);
    assert_true(object->index > s->last || !s->described);
    assert_int_equal(object->described, s->described);
    assert_int_equal(object->code, s->described ? expected->object_code : 0);
    if (object->name.data != NULL)
        assert_memory_equal(object->name.data, expected->name, object->name.length);
    s->last = object->index;
    s->objects++;
}

static void see_entry(void *ctx, const ect_reader_object_t *object, const ect_reader_entry_t *entry)
{
    seen_t *s = ctx;
    const ect_od_t od = ect_device_od(s->device, NULL);
    const ect_entry_t *expected = ect_od_entry(ect_od_find(&od, object->index), entry->subindex);
    assert_non_null(expected);
    assert_int_equal(entry->type, s->described ? expected->data_type : 0);
    assert_int_equal(entry->bits, s->described ? ect_od_bits(&od, expected) : 0);
    s->entries++;
    s->values += entry->value.data != NULL;
}

static size_t entries_of(const ect_device_t *device)
{
    size_t count = 0;
    for (uint16_t i = 0; i < device->object_count; i++) {
        for (const ect_entry_t *e = device->objects[i].entries; e; e = ect_od_next(&device->objects[i], e))
            count++;
    }
    return count;
}

static void the_dictionary_of_every_device_is_read(void **state)
{
    (void)state;
    for (size_t i = 0; every_device(i) != NULL; i++) {
        seen_t s = {.device = every_device(i)};
        const ect_reader_sink_t sink = {.ctx = &s, .begin = see_begin, .object = see_object, .entry = see_entry};
        liar_t l;
        open_reader(&l, s.device, NULL);
        assert_int_equal(ect_reader_dictionary(&reader, ECT_READER_IDENTITY_AND_PDOS, &sink), ECT_READER_OK);
        assert_int_equal(s.described, has_coe(s.device) && (s.device->coe_details & ECT_COE_SDO_INFO) != 0);
        if (s.described || !has_coe(s.device)) {
            assert_int_equal(s.objects, s.described ? s.device->object_count : 0);
            assert_int_equal(s.entries, s.described ? entries_of(s.device) : 0);
        } else {
            assert_true(s.objects >= 3 && s.entries == s.values);
        }
        close_reader(&l);
    }
}

static void all_values_are_uploaded_when_wanted(void **state)
{
    seen_t few = {.device = &testdev}, all = {.device = &testdev};
    ect_reader_sink_t sink = {.ctx = &few, .begin = see_begin, .object = see_object, .entry = see_entry};
    liar_t l;
    (void)state;
    open_reader(&l, &testdev, NULL);
    assert_int_equal(ect_reader_dictionary(&reader, ECT_READER_IDENTITY_AND_PDOS, &sink), ECT_READER_OK);
    sink.ctx = &all;
    assert_int_equal(ect_reader_dictionary(&reader, ECT_READER_ALL_VALUES, &sink), ECT_READER_OK);
    /* 1000h, 1008h, 1018h:0..4, two mappings of 0..3, two assignments of 0..1 */
    assert_int_equal(few.values, 1 + 1 + 5 + 2 * 4 + 2 * 2);
    assert_int_equal(all.values, all.entries - 1); /* 2003h is write only */
    close_reader(&l);
}

static liar_mail_t no_information(liar_t *l, const uint8_t *r)
{
    static const uint8_t unsupported[4] = {1, 0, 2, 0};
    if (r[7] >> 4 != 8)
        return LIAR_PASSES;
    liar_set_mail(l, 0, unsupported, sizeof unsupported);
    return LIAR_REPLIES;
}

static void without_sdo_information_identity_and_pdos_are_read(void **state)
{
    static const liar_kind_t kind = {.request = no_information};
    static const uint16_t expected[] = {0x1000, 0x1008, 0x1018, 0x1C12, 0x1600, 0x1C13, 0x1A00};
    size_t i = 0;
    (void)state;
    char *json = json_of(&testdev, &kind, 0, ECT_READER_IDENTITY_AND_PDOS);
    cJSON *root = cJSON_Parse(json);
    assert_true(cJSON_IsFalse(cJSON_GetObjectItem(root, "described")));
    assert_true(cJSON_IsTrue(cJSON_GetObjectItem(root, "complete")));
    const cJSON *object;
    cJSON_ArrayForEach(object, cJSON_GetObjectItem(root, "objects"))
    {
        assert_int_equal(cJSON_GetObjectItem(object, "index")->valueint, expected[i++]);
        assert_null(cJSON_GetObjectItem(object, "code"));
    }
    assert_int_equal(i, sizeof expected / sizeof expected[0]);
    object = cJSON_GetArrayItem(cJSON_GetObjectItem(root, "objects"), 4);
    const cJSON *entry = cJSON_GetArrayItem(cJSON_GetObjectItem(object, "entries"), 3);
    assert_string_equal(cJSON_GetStringValue(cJSON_GetObjectItem(entry, "value")), "10020070");
    cJSON_Delete(root);
    free(json);
}

static void the_pdos_of_some_sync_managers_are_read(void **state)
{
    static const struct {
        uint32_t sms;
        uint16_t expected[5]; /* 0: end */
    } cases[] = {{1u << 2, {0x1C12, 0x1600}},
                 {1u << 3, {0x1C13, 0x1A00}},
                 {1u << 2 | 1u << 3, {0x1C12, 0x1600, 0x1C13, 0x1A00}},
                 {UINT32_MAX, {0x1C12, 0x1600, 0x1C13, 0x1A00}},
                 {1u << 31, {0}}};
    liar_t l;
    (void)state;
    open_reader(&l, &testdev, NULL);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char *json = NULL;
        size_t length, n = 0;
        FILE *file = open_memstream(&json, &length);
        assert_int_equal(ect_reader_json_assigned(&reader, cases[i].sms, file), ECT_READER_OK);
        assert_int_equal(fclose(file), 0);
        cJSON *root = cJSON_Parse(json);
        assert_int_equal(cJSON_GetObjectItem(root, "slave")->valuedouble, 1);
        assert_true(cJSON_IsFalse(cJSON_GetObjectItem(root, "described")));
        assert_true(cJSON_IsTrue(cJSON_GetObjectItem(root, "complete")));
        const cJSON *object;
        cJSON_ArrayForEach(object, cJSON_GetObjectItem(root, "objects"))
            assert_int_equal(cJSON_GetObjectItem(object, "index")->valueint, cases[i].expected[n++]);
        assert_int_equal(cases[i].expected[n], 0);
        cJSON_Delete(root);
        free(json);
    }
    close_reader(&l);
}

static liar_mail_t one_object(liar_t *l, const uint8_t *r)
{
    static const uint8_t list[6] = {2, 0, 0, 0, 1, 0};
    uint8_t reply[8];
    if (r[7] >> 4 != 8 || (r[8] & 0x7F) != 1)
        return LIAR_PASSES;
    memcpy(reply, list, sizeof list);
    ect_store_le16(reply + 6, 0x1000);
    liar_set_coe_mail(l, 8, reply, sizeof reply);
    return LIAR_REPLIES;
}

static void a_list_of_one_object_is_a_description(void **state)
{
    static const liar_kind_t kind = {.request = one_object};
    (void)state;
    char *json = json_of(&testdev, &kind, 0, ECT_READER_IDENTITY_AND_PDOS);
    assert_non_null(strstr(json, "\"described\": true, \"objects\": [\n  {\"index\": 4096, \"type\": 7"));
    assert_null(strstr(json, "4104"));
    free(json);
}

/* A list of 1008h in a mail of another service, then that of 1000h. */
static liar_mail_t another_service(liar_t *l, const uint8_t *r)
{
    static const uint8_t list[] = {2, 0, 0, 0, 1, 0, 0x08, 0x10};
    if (r[7] >> 4 != 8 || (r[8] & 0x7F) != 1)
        return LIAR_PASSES;
    liar_set_coe_mail(l, 3, list, sizeof list);
    l->number = 1;
    return LIAR_REPLIES;
}

/* Then one that ends in its header. */
static bool then_a_short_one_and_the_list(liar_t *l)
{
    static const uint8_t list[] = {2, 0, 0, 0, 1, 0, 0x00, 0x10};
    if (l->number == 0 || l->number > 2)
        return false;
    liar_set_coe_mail(l, 8, list, l->number == 1 ? 3 : sizeof list);
    l->number++;
    return true;
}

static void mails_of_another_service_are_no_list(void **state)
{
    static const liar_kind_t kind = {.request = another_service, .next = then_a_short_one_and_the_list};
    size_t count = 0;
    liar_t l;
    (void)state;
    open_reader(&l, &testdev, &kind);
    assert_int_equal(ect_reader_preop(&reader), ECT_READER_OK);
    assert_int_equal(ect_reader_list(&reader, &count), ECT_READER_OK);
    assert_int_equal(count, 1);
    assert_int_equal(reader.objects[0x1000 / 8], 1);
    assert_int_equal(reader.objects[0x1008 / 8], 0);
    assert_int_equal(reader.skipped, 2);
    close_reader(&l);
}

/* The entry of 1000h without a type, or without a length: not a gap, because a gap has neither. */
static void change_entry(liar_t *l, uint8_t *mail)
{
    if (mail[7] >> 4 != 8 || (mail[8] & 0x7F) != 6 || ect_load_le16(mail + 12) != 0x1000)
        return;
    if ((l->number & 1) != 0)
        ect_store_le16(mail + 16, 0);
    if ((l->number & 2) != 0)
        ect_store_le16(mail + 18, 0);
}

static void a_gap_has_neither_type_nor_length(void **state)
{
    static const char *const entries[] = {"{\"subindex\": 0, \"type\": 7, \"bits\": 32,",
                                          "{\"subindex\": 0, \"type\": 0, \"bits\": 32,",
                                          "{\"subindex\": 0, \"type\": 7, \"bits\": 0,", NULL};
    static const liar_kind_t kind = {.request = one_object, .reply = change_entry};
    (void)state;
    for (size_t i = 0; i < 4; i++) {
        char *json = json_of(&testdev, &kind, i, ECT_READER_IDENTITY_AND_PDOS);
        assert_int_equal(strstr(json, "subindex") != NULL, entries[i] != NULL);
        if (entries[i] != NULL)
            assert_non_null(strstr(json, entries[i]));
        free(json);
    }
}

/* The name of 1000h begins with every kind of letter that must be escaped in JSON or on a terminal. */
static void change_name(liar_t *l, uint8_t *mail)
{
    static const uint8_t letters[] = {0x01, 0x1F, ' ', '~', 0x7F, 0xE9, '"', '\\'};
    (void)l;
    if (mail[7] >> 4 == 8 && (mail[8] & 0x7F) == 4 && ect_load_le16(mail + 12) == 0x1000)
        memcpy(mail + 18, letters, sizeof letters);
}

static void letters_of_a_name_are_escaped(void **state)
{
    static const liar_kind_t kind = {.request = one_object, .reply = change_name};
    (void)state;
    char *json = json_of(&testdev, &kind, 0, ECT_READER_IDENTITY_AND_PDOS);
    assert_non_null(strstr(json, "\"name\": \"\\u0001\\u001f ~\\u007f\\u00e9\\u0022\\u005c"));
    free(json);
}

/* Ten bytes with the reply to the start; the only segment after it ends the transfer without data. */
static liar_mail_t last_segment_without_bytes(liar_t *l, const uint8_t *r)
{
    static const uint8_t start[18] = {0x41, 0x18, 0x10, 1,   12,  0,   0,   0,   'a',
                                      'b',  'c',  'd',  'e', 'f', 'g', 'h', 'i', 'j'};
    static const uint8_t last[1] = {1};
    if (r[7] >> 4 != 2)
        return LIAR_PASSES;
    liar_set_coe_mail(l, 3, r[8] >> 5 == 2 ? start : last, r[8] >> 5 == 2 ? sizeof start : sizeof last);
    return LIAR_REPLIES;
}

static void the_last_segment_may_be_empty(void **state)
{
    static const liar_kind_t kind = {.request = last_segment_without_bytes};
    uint8_t value[20];
    size_t size = sizeof value;
    liar_t l;
    (void)state;
    open_reader(&l, &testdev, &kind);
    assert_int_equal(ect_reader_upload(&reader, 0x1018, 1, false, value, &size), ECT_READER_OK);
    assert_int_equal(size, 10);
    assert_memory_equal(value, "abcdefghij", 10);
    close_reader(&l);
}

/* Mails are numbered 1 to 7, and 1 again; 0 would be a mail without a number (ETG.1000.4 clause 5.6). */
static liar_mail_t keeps_counters(liar_t *l, const uint8_t *r)
{
    assert_int_equal(r[5] >> 4, l->number % 7 + 1);
    l->number = r[5] >> 4;
    return LIAR_PASSES;
}

static void mails_are_numbered_from_1_to_7(void **state)
{
    static const liar_kind_t kind = {.request = keeps_counters};
    liar_t l;
    (void)state;
    open_reader(&l, &testdev, &kind);
    for (unsigned int i = 0; i < 9; i++) {
        uint8_t value[4];
        size_t size = sizeof value;
        assert_int_equal(ect_reader_upload(&reader, 0x1018, 1, false, value, &size), ECT_READER_OK);
        assert_int_equal(l.number, i % 7 + 1);
    }
    close_reader(&l);
}

/* A slave takes a mail with the counter of the mail before it for a repeat. */
static void the_first_mail_continues_the_counter_of_the_mail_before(void **state)
{
    static const uint8_t before[] = {0, 1, 6, 7};
    (void)state;
    for (size_t i = 0; i < sizeof before; i++) {
        const ect_reader_config_t config = {.counter = before[i]};
        uint8_t value[4];
        size_t size = sizeof value;
        liar_t l;
        liar_open(&l, &testdev, NULL);
        assert_int_equal(ect_reader_open(&reader, &l.link, &config), ECT_READER_OK);
        assert_int_equal(ect_reader_upload(&reader, 0x1018, 1, false, value, &size), ECT_READER_OK);
        assert_int_equal(reader.counter, before[i] % 7 + 1);
        close_reader(&l);
    }
}

static void the_json_text_has_every_field(void **state)
{
    (void)state;
    char *json = json_of(&testdev, NULL, 0, ECT_READER_ALL_VALUES);
    assert_non_null(strstr(json, "{\"slave\": 1, \"described\": true, \"objects\": ["));
    assert_non_null(strstr(json, "{\"index\": 8197, \"type\": 3, \"code\": 7, \"name\": \"Limited\", \"entries\": [\n"
                                 "    {\"subindex\": 0, \"type\": 3, \"bits\": 16, \"access\": 63, \"unit\": \"2d00\", "
                                 "\"default\": \"0500\", \"minimum\": \"9cff\", \"maximum\": \"c800\", "
                                 "\"name\": \"Limited\", \"value\": \"0500\"}]},"));
    assert_non_null(strstr(json, "\n], \"complete\": true}\n"));
    free(json);
}

/* --- wire --------------------------------------------------------------------------------------------------------- */

static bool lose_some(liar_t *l, uint8_t *d, uint16_t ado, uint8_t *data, uint16_t length, uint8_t *wkc)
{
    (void)d;
    (void)ado;
    (void)data;
    (void)length;
    (void)wkc;
    return l->frames % 5 != 0;
}

static void a_wire_that_loses_a_fifth_of_the_frames_changes_nothing(void **state)
{
    static const liar_kind_t kind = {.datagram = lose_some};
    seen_t s = {.device = &testdev};
    const ect_reader_sink_t sink = {.ctx = &s, .begin = see_begin, .object = see_object, .entry = see_entry};
    const ect_reader_config_t patient = {.tries = 10};
    size_t size;
    liar_t l;
    (void)state;
    liar_open(&l, &testdev, &kind);
    assert_int_equal(ect_reader_open(&reader, &l.link, &patient), ECT_READER_OK);
    assert_int_equal(ect_reader_sii(&reader, image, 0, &size), ECT_READER_OK);
    assert_memory_equal(image, ect_chain_esc(l.w.chain, 0)->config.sii, size);
    assert_int_equal(ect_reader_dictionary(&reader, ECT_READER_IDENTITY_AND_PDOS, &sink), ECT_READER_OK);
    assert_int_equal(s.objects, testdev.object_count);
    assert_int_equal(s.entries, entries_of(&testdev));
    close_reader(&l);
}

/* --- frames ------------------------------------------------------------------------------------------------------- */

/* A link whose replies are given by their lengths, one for each receive(). 0: none comes until the timeout; WHOLE: the
 * length of the frame that was sent. Each is the frame that was sent, processed by one slave. */
typedef struct scripted {
    const size_t *lengths;
    size_t changed; /* byte of the first reply with another value; 0: none */
    unsigned int sends, receives;
    uint64_t now_ns;
    size_t sent_length;
    uint8_t sent[ECT_READER_FRAME];
} scripted_t;

static const size_t WHOLE = SIZE_MAX;

static void scripted_send(void *ctx, const uint8_t *frame, size_t length)
{
    scripted_t *s = ctx;
    memcpy(s->sent, frame, length);
    s->sent_length = length;
    s->sends++;
}

static size_t scripted_receive(void *ctx, uint8_t *frame, size_t room, uint64_t until_ns)
{
    enum { AT_LENGTH = 22, AT_DATA = 26 };
    scripted_t *s = ctx;
    const size_t length = s->lengths[s->receives++];
    if (length == 0) {
        s->now_ns = until_ns;
        return 0;
    }
    assert_true(s->sent_length <= room);
    memcpy(frame, s->sent, s->sent_length);
    if (s->changed > 0 && s->receives == 1)
        frame[s->changed] ^= 1;
    ect_store_le16(frame + AT_DATA + (ect_load_le16(frame + AT_LENGTH) & 0x7FF), 1);
    return length == WHOLE ? s->sent_length : length;
}

static uint64_t scripted_now(void *ctx)
{
    return ((const scripted_t *)ctx)->now_ns;
}

static void a_frame_is_sent_again_after_its_timeout_only(void **state)
{
    static const struct {
        const char *title;
        size_t lengths[3];
        unsigned int sends, receives, ms;
    } rows[] = {
        {"a reply", {WHOLE}, 1, 1, 0},
        {"one byte of a reply, then all of it", {1, WHOLE}, 1, 2, 0},
        {"a reply without the last byte of its working counter, then all of it", {28, WHOLE}, 1, 2, 0},
        {"a reply with the last byte of its working counter", {29}, 1, 1, 0},
        {"a frame that was cut, then a reply", {ECT_READER_FRAME + 1, WHOLE}, 1, 2, 0},
        {"none, then a reply", {0, WHOLE}, 2, 2, 7},
        {"one byte of a reply, none, then a reply", {1, 0, WHOLE}, 2, 3, 7},
    };
    static const ect_reader_config_t second = {.position = 1, .frame_ms = 7};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        scripted_t s = {.lengths = rows[i].lengths};
        const ect_reader_link_t link = {
            .ctx = &s, .send = scripted_send, .receive = scripted_receive, .now = scripted_now};
        assert_int_equal(ect_reader_open(&reader, &link, &second), ECT_READER_LOST);
        assert_string_equal(reader.text, "the segment has only 1 slave");
        if (s.sends != rows[i].sends || s.receives != rows[i].receives || s.now_ns != rows[i].ms * UINT64_C(1000000))
            fail_msg("%s: %u sent, %u received, %" PRIu64 " ns", rows[i].title, s.sends, s.receives, s.now_ns);
    }
}

/* A wire that delivers every reply, in order, this long after its request: a busy machine. */
typedef struct slow {
    liar_t l;
    uint64_t delay_ns;
    struct {
        uint8_t frame[LIAR_FRAME];
        size_t length;
        uint64_t at_ns;
    } replies[16];
    unsigned int sent, received;
} slow_t;

static void slow_send(void *ctx, const uint8_t *frame, size_t length)
{
    slow_t *s = ctx;
    const size_t slot = s->sent++ % (sizeof s->replies / sizeof s->replies[0]);
    assert_true(s->sent - s->received <= sizeof s->replies / sizeof s->replies[0]);
    s->l.link.send(&s->l, frame, length);
    s->replies[slot].length = s->l.link.receive(&s->l, s->replies[slot].frame, LIAR_FRAME, 0);
    s->replies[slot].at_ns = s->l.link.now(&s->l) + s->delay_ns;
}

static size_t slow_receive(void *ctx, uint8_t *frame, size_t room, uint64_t until_ns)
{
    slow_t *s = ctx;
    const size_t slot = s->received % (sizeof s->replies / sizeof s->replies[0]);
    const bool comes = s->received < s->sent && s->replies[slot].at_ns <= until_ns;
    const uint64_t at_ns = comes ? s->replies[slot].at_ns : until_ns;
    if (at_ns > s->l.link.now(&s->l))
        s->l.link.wait(&s->l, at_ns);
    if (!comes)
        return 0;
    assert_true(s->replies[slot].length <= room);
    memcpy(frame, s->replies[slot].frame, s->replies[slot].length);
    s->received++;
    return s->replies[slot].length;
}

static uint64_t slow_now(void *ctx)
{
    slow_t *s = ctx;
    return s->l.link.now(&s->l);
}

static void slow_wait(void *ctx, uint64_t until_ns)
{
    slow_t *s = ctx;
    s->l.link.wait(&s->l, until_ns);
}

static void a_slave_is_read_while_every_reply_is_late(void **state)
{
    static const struct {
        unsigned int delay_ms;
        ect_reader_result_t result;
    } rows[] = {
        {0, ECT_READER_OK}, {250, ECT_READER_OK}, {600, ECT_READER_OK}, {1499, ECT_READER_OK}, {1501, ECT_READER_LOST}};
    static slow_t slow;
    static const ect_reader_link_t link = {
        .ctx = &slow, .send = slow_send, .receive = slow_receive, .now = slow_now, .wait = slow_wait};
    static const ect_reader_config_t patient = {.limit_ms = 36000000};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        seen_t s = {.device = &testdev};
        const ect_reader_sink_t sink = {.ctx = &s, .begin = see_begin, .object = see_object, .entry = see_entry};
        ect_reader_result_t result;
        size_t size;
        memset(&slow, 0, sizeof slow);
        liar_open(&slow.l, &testdev, NULL);
        slow.delay_ns = rows[i].delay_ms * UINT64_C(1000000);
        result = ect_reader_open(&reader, &link, &patient);
        if (result == ECT_READER_OK)
            result = ect_reader_sii(&reader, image, 0, &size);
        if (result == ECT_READER_OK)
            result = ect_reader_dictionary(&reader, ECT_READER_ALL_VALUES, &sink);
        if (result != rows[i].result)
            fail_msg("%u ms: %d (%s), %d expected", rows[i].delay_ms, result, reader.text, rows[i].result);
        if (result == ECT_READER_OK)
            assert_int_equal(s.entries, entries_of(&testdev));
        close_reader(&slow.l);
    }
}

/* A slave changes its position, the data and the working counter of a datagram, and nothing else. */
static void a_reply_has_the_request_s_command_index_and_address(void **state)
{
    static const size_t lengths[] = {SIZE_MAX, SIZE_MAX};
    static const struct {
        const char *title;
        size_t changed;
        bool reply;
    } rows[] = {
        {"sender", 11, true},
        {"EtherType, first byte", 12, false},
        {"EtherType, second byte", 13, false},
        {"command", 16, false},
        {"index", 17, false},
        {"position, low byte", 18, true},
        {"position, high byte", 19, true},
        {"address, low byte", 20, false},
        {"address, high byte", 21, false},
        {"length", 22, false},
        {"circulating frame", 23, false},
        {"event", 24, true},
        {"data", 26, true},
    };
    static const ect_reader_config_t second = {.position = 1};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        scripted_t s = {.lengths = lengths, .changed = rows[i].changed};
        const ect_reader_link_t link = {
            .ctx = &s, .send = scripted_send, .receive = scripted_receive, .now = scripted_now};
        assert_int_equal(ect_reader_open(&reader, &link, &second), ECT_READER_LOST);
        if (s.receives != (rows[i].reply ? 1 : 2))
            fail_msg("%s: %s", rows[i].title, rows[i].reply ? "no reply" : "taken for a reply");
    }
}

static void zeros_of_the_configuration_are_the_defaults(void **state)
{
    static const size_t lengths[] = {SIZE_MAX};
    static const ect_reader_config_t given = {
        .position = 1, .frame_ms = 1, .reply_ms = 2, .state_ms = 3, .limit_ms = 4, .tries = 5};
    (void)state;
    for (unsigned int n = 0; n < 2; n++) {
        scripted_t s = {.lengths = lengths};
        const ect_reader_link_t link = {
            .ctx = &s, .send = scripted_send, .receive = scripted_receive, .now = scripted_now};
        const ect_reader_config_t second = {.position = 1};
        (void)ect_reader_open(&reader, &link, n == 0 ? &second : &given);
        assert_int_equal(reader.config.frame_ms, n == 0 ? 500 : 1);
        assert_int_equal(reader.config.reply_ms, n == 0 ? 2000 : 2);
        assert_int_equal(reader.config.state_ms, n == 0 ? 5000 : 3);
        assert_int_equal(reader.config.limit_ms, n == 0 ? 600000 : 4);
        assert_int_equal(reader.config.tries, n == 0 ? 3 : 5);
    }
}

/* --- mailbox ------------------------------------------------------------------------------------------------------ */

static uint8_t sms_written[2 * ECT_SM_SIZE];

static bool record_sms(liar_t *l, uint8_t *d, uint16_t ado, uint8_t *data, uint16_t length, uint8_t *wkc)
{
    (void)wkc;
    if (d[0] == 2 && ado == ECT_REG_SM && length == sizeof sms_written && l->number++ == 0)
        memcpy(sms_written, data, length);
    return true;
}

/* Control as the ESI schema's mailboxes have it: one buffer, direction, event to the PDI. */
static void sync_managers_are_written_whole_and_reserved_bits_are_zero(void **state)
{
    static const liar_kind_t kind = {.datagram = record_sms};
    uint8_t want[2 * ECT_SM_SIZE] = {[4] = 0x26, [6] = 0x01, [12] = 0x22, [14] = 0x01};
    liar_t l;
    (void)state;
    open_reader(&l, &testdev, &kind);
    assert_int_equal(ect_reader_preop(&reader), ECT_READER_OK);
    ect_store_le16(want, reader.out_start);
    ect_store_le16(want + 2, reader.out_size);
    ect_store_le16(want + 8, reader.in_start);
    ect_store_le16(want + 10, reader.in_size);
    assert_memory_equal(sms_written, want, sizeof want);
    close_reader(&l);
}

static bool one_more(liar_t *l)
{
    return ++l->number < 1000;
}

static liar_mail_t passes(liar_t *l, const uint8_t *mail)
{
    (void)mail;
    assert_int_equal(l->fetched, 64);
    return LIAR_PASSES;
}

static void at_most_64_old_mails_are_discarded_before_a_request(void **state)
{
    static const liar_kind_t kind = {.request = passes, .next = one_more};
    uint8_t value[4];
    size_t size = sizeof value;
    liar_t l;
    (void)state;
    open_reader(&l, &testdev, &kind);
    assert_int_equal(ect_reader_preop(&reader), ECT_READER_OK);
    liar_set_coe_mail(&l, 1, "\x00\x10\x00\x00\x00\x00\x00\x00", 8);
    l.has_mail = true;
    assert_int_equal(ect_reader_upload(&reader, 0x1000, 0, false, value, &size), ECT_READER_OK);
    assert_int_equal(reader.skipped, 64);
    close_reader(&l);
}

typedef struct stop {
    unsigned int calls, after;
    char what[20];
    unsigned int all;
} stop_t;

static bool stop_after(void *ctx, const char *what, unsigned int done, unsigned int all)
{
    stop_t *s = ctx;
    assert_true(done < all);
    snprintf(s->what, sizeof s->what, "%s", what);
    s->all = all;
    return s->calls++ < s->after;
}

static void the_callback_shows_progress_and_stops(void **state)
{
    for (unsigned int after = 3; after < 30; after += 9) {
        stop_t stop = {.after = after};
        const ect_reader_config_t config = {.progress = stop_after, .progress_ctx = &stop};
        seen_t s = {.device = &testdev};
        const ect_reader_sink_t to = {.ctx = &s, .begin = see_begin, .object = see_object, .entry = see_entry};
        size_t size;
        liar_t l;
        liar_open(&l, &testdev, NULL);
        assert_int_equal(ect_reader_open(&reader, &l.link, &config), ECT_READER_OK);
        assert_int_equal(ect_reader_sii(&reader, image, 0, &size), ECT_READER_OK);
        assert_string_equal(stop.what, "EEPROM");
        const ect_reader_result_t result = ect_reader_dictionary(&reader, ECT_READER_IDENTITY_AND_PDOS, &to);
        assert_string_equal(stop.what, "objects");
        assert_int_equal(stop.all, testdev.object_count);
        const unsigned int blocks = 1 + 2; /* the header, and two of 1 KiB */
        if (after < blocks + testdev.object_count) {
            assert_int_equal(result, ECT_READER_STOPPED);
            assert_string_equal(reader.text, "stopped by the user");
            assert_int_equal(s.objects, after - blocks);
        } else {
            assert_int_equal(result, ECT_READER_OK);
        }
        close_reader(&l);
    }
    (void)state;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_eeprom_of_every_device_is_read),
        cmocka_unit_test(a_part_of_the_eeprom_is_read),
        cmocka_unit_test(the_content_of_an_eeprom_ends_at_the_end_mark),
        cmocka_unit_test(the_pdi_gets_the_eeprom_back),
        cmocka_unit_test(an_error_of_the_eeprom_is_cleared_before_a_command),
        cmocka_unit_test(the_largest_eeprom_is_read_whole),
        cmocka_unit_test(the_eeprom_is_taken_from_a_pdi_that_uses_it),
        cmocka_unit_test(a_slave_in_init_returns_to_init_with_the_sync_managers_it_had),
        cmocka_unit_test(a_slave_at_work_stays_in_its_state),
        cmocka_unit_test(a_slave_with_the_error_flag_is_acknowledged),
        cmocka_unit_test(a_refused_state_is_reported_with_its_code),
        cmocka_unit_test(the_third_of_three_slaves_is_read_and_the_others_are_left_alone),
        cmocka_unit_test(a_slave_is_addressed_by_its_station_address),
        cmocka_unit_test(frames_are_broadcasts_from_a_local_address),
        cmocka_unit_test(the_data_of_a_read_are_sent_as_zeros),
        cmocka_unit_test(uploads_of_every_length_arrive_whole),
        cmocka_unit_test(an_object_is_uploaded_by_complete_access),
        cmocka_unit_test(an_abort_is_reported_with_its_code_and_the_next_upload_works),
        cmocka_unit_test(objects_and_entries_are_described),
        cmocka_unit_test(the_dictionary_of_every_device_is_read),
        cmocka_unit_test(all_values_are_uploaded_when_wanted),
        cmocka_unit_test(without_sdo_information_identity_and_pdos_are_read),
        cmocka_unit_test(the_pdos_of_some_sync_managers_are_read),
        cmocka_unit_test(a_list_of_one_object_is_a_description),
        cmocka_unit_test(mails_of_another_service_are_no_list),
        cmocka_unit_test(a_gap_has_neither_type_nor_length),
        cmocka_unit_test(letters_of_a_name_are_escaped),
        cmocka_unit_test(the_last_segment_may_be_empty),
        cmocka_unit_test(mails_are_numbered_from_1_to_7),
        cmocka_unit_test(the_first_mail_continues_the_counter_of_the_mail_before),
        cmocka_unit_test(the_json_text_has_every_field),
        cmocka_unit_test(a_wire_that_loses_a_fifth_of_the_frames_changes_nothing),
        cmocka_unit_test(a_frame_is_sent_again_after_its_timeout_only),
        cmocka_unit_test(a_slave_is_read_while_every_reply_is_late),
        cmocka_unit_test(a_reply_has_the_request_s_command_index_and_address),
        cmocka_unit_test(zeros_of_the_configuration_are_the_defaults),
        cmocka_unit_test(sync_managers_are_written_whole_and_reserved_bits_are_zero),
        cmocka_unit_test(at_most_64_old_mails_are_discarded_before_a_request),
        cmocka_unit_test(the_callback_shows_progress_and_stops),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
