/* SPDX-License-Identifier: MIT */
/* The EC-Link base units: each field of TS-0007 chapters 8 and 9 in the mapping, in the dictionary and on the wire. */
#include <string.h>

#include "devices/eclink/eclink.h"
#include "devices/eclink/instance.h"
#include "support/wire.h"

enum { RU_BYTES = 38, MOST_FIELDS = 256, INPUT_RECORD = 0x2001, OUTPUT_RECORD = 0x2002, PERIODIC = 0x2003 };

/* Offset, size and a word of the name; transcribed from the tables of TS-0007 chapter 8 and 9. */
typedef struct field {
    uint16_t offset, size;
    const char *word;
} field_t;

static const field_t input_head[] = {
    {0, 1, "PCI"},
    {1, 1, "CCI"},
    {2, 1, "PAI"},
    {3, 1, "CAI"},
    {4, 2, "Command RU"},
    {6, 8, "from RU 0..7"},
    {14, 8, "from RU 8..15"},
    {22, 1, "BU state"},
    {23, 1, "VLAP"},
    {24, 1, "Unarmed"},
    {25, 1, "EG-Link"},
    {26, 1, "EC-Link"},
    {27, 1, "pare"},
};
static const field_t remote[] = {
    {28, 2, "Armed"},      {30, 1, "state"},         {31, 1, "battery"},        {32, 1, "RSSI"},
    {33, 1, "cable"},      {34, 1, "docked"},        {35, 1, "disabled"},       {36, 1, "C-Link status"},
    {37, 1, "G-Link"},     {38, 2, "joystick 1"},    {40, 2, "joystick 2"},     {42, 2, "joystick 3"},
    {44, 2, "joystick 4"}, {46, 2, "switch 1"},      {48, 2, "switch 2"},       {50, 2, "switch 3"},
    {52, 2, "switch 4"},   {54, 2, "switch 5"},      {56, 2, "switch 6"},       {58, 2, "switch 7"},
    {60, 2, "switch 8"},   {62, 1, "encoder value"}, {63, 1, "encoder switch"}, {64, 2, "pare"},
};
static const field_t command_output[] = {
    {0, 1, "PCO"},        {1, 1, "CCO"},        {2, 1, "PAO"},          {3, 1, "CAO"},
    {4, 2, "Command RU"}, {6, 8, "to RU 0..7"}, {14, 8, "to RU 8..15"}, {22, 2, "pare"},
};
static const field_t periodic_output[] = {{24, 2, "size"}, {26, 1, "block"}, {27, 1, "pare"}};

typedef struct node {
    const ect_device_t *device;
    const char *name;
    uint16_t input_bytes, output_bytes;
    unsigned int remotes;
} node_t;

static const node_t nodes[] = {
    {&ect_eclink_map1, "VR-BU-ECT-Map1", 66, 0, 1},
    {&ect_eclink_map3, "VR-BU-ECT-Map3", 66, 24, 1},
    {&ect_eclink_map7, "VR-BU-ECT-Map7", 66, 228, 1},
    {&ect_eclink_multiarm, "VR-BU-ECT-MultiArm", 142, 228, 3},
};

#define FOR_EACH_NODE(node) for (const node_t *node = nodes; node < nodes + sizeof nodes / sizeof nodes[0]; node++)
#define COUNT(table)        (sizeof(table) / sizeof((table)[0]))

/* A field of the mapping: its record and entry, and its position in the image. */
typedef struct expected {
    field_t field;
    uint16_t index;
    uint8_t subindex;
} expected_t;

static size_t add(expected_t *list, size_t count, const field_t *fields, size_t n, uint16_t index, uint16_t shift)
{
    for (size_t i = 0; i < n; i++, count++) {
        list[count].field = fields[i];
        list[count].field.offset = (uint16_t)(fields[i].offset + shift);
        list[count].index = index;
        list[count].subindex = (uint8_t)(count + 1);
    }
    return count;
}

static size_t inputs_of(const node_t *node, expected_t *list)
{
    size_t count = add(list, 0, input_head, COUNT(input_head), INPUT_RECORD, 0);
    for (unsigned int r = 0; r < node->remotes; r++)
        count = add(list, count, remote, COUNT(remote), INPUT_RECORD, (uint16_t)(RU_BYTES * r));
    return count;
}

static size_t outputs_of(const node_t *node, expected_t *list)
{
    if (node->output_bytes == 0)
        return 0;
    size_t count = add(list, 0, command_output, COUNT(command_output), OUTPUT_RECORD, 0);
    if (node->output_bytes == 24)
        return count;
    count = add(list, count, periodic_output, COUNT(periodic_output), OUTPUT_RECORD, 0);
    for (uint8_t n = 1; n <= 25; n++)
        list[count++] = (expected_t){{(uint16_t)(20 + 8 * n), 8, "Periodic data"}, PERIODIC, n};
    return count;
}

/* --- access ------------------------------------------------------------------------------------------------------- */

static uint32_t try_upload(wire_t *w, uint16_t index, uint8_t subindex, uint8_t *data, size_t *size)
{
    *size = 64;
    memset(data, 0, 64);
    return wire_sdo_upload(w, 0, index, subindex, false, data, size);
}

static uint32_t upload_number(wire_t *w, uint16_t index, uint8_t subindex)
{
    uint8_t data[64];
    size_t size;
    uint32_t code = try_upload(w, index, subindex, data, &size);
    if (code != 0)
        fail_msg("%04Xh:%u: abort %08X", index, subindex, code);
    return ect_load_le32(data);
}

static eclink_t *unit(wire_t *w)
{
    return ect_chain_slave(w->chain, 0)->config.instance;
}

static void inputs_on_the_wire(wire_t *w, const node_t *node, uint8_t *image)
{
    assert_int_equal(wire_read(w, 0, 0x2800, image, node->input_bytes), 1);
}

/* Triggers the output watchdog while time passes. */
static void exchange(wire_t *w, const node_t *node, const uint8_t *outputs, uint8_t *inputs)
{
    if (node->output_bytes > 0)
        assert_int_equal(wire_write(w, 0, 0x1000, outputs, node->output_bytes), 1);
    wire_poll(w);
    inputs_on_the_wire(w, node, inputs);
}

/* --- standard objects --------------------------------------------------------------------------------------------- */

static void error_register(void **state)
{
    (void)state;
    FOR_EACH_NODE(node)
    {
        uint8_t data[64];
        size_t size;
        wire_t w;
        wire_open_one(&w, node->device);
        wire_go(&w, 0, ECT_STATE_PREOP);
        assert_int_equal(try_upload(&w, 0x1001, 0, data, &size), 0);
        assert_int_equal(size, 1);
        assert_int_equal(data[0], 0);
        wire_close(&w);
    }
}

/* A PLC makes a variable of each name. */
static void names_are_unique(void **state)
{
    (void)state;
    FOR_EACH_NODE(node)
    {
        for (uint16_t n = 0; n < node->device->object_count; n++) {
            const ect_object_t *object = &node->device->objects[n];
            bool record = object->index >= 0x2000;
            for (unsigned int i = 0; record && i <= object->max_subindex; i++) {
                for (unsigned int k = 0; k < i; k++) {
                    if (strcmp(object->entries[i].name, object->entries[k].name) == 0)
                        fail_msg("%s, %04Xh: sub-indices %u and %u are both '%s'", node->name, object->index, k, i,
                                 object->entries[i].name);
                }
            }
        }
    }
}

/* --- tables ------------------------------------------------------------------------------------------------------- */

static void sizes_and_names(void **state)
{
    (void)state;
    FOR_EACH_NODE(node)
    {
        wire_t w;
        uint8_t text[64];
        size_t size;
        assert_string_equal(node->device->type_name, node->name);
        assert_int_equal(ect_device_sm_bytes(node->device, 2), node->output_bytes);
        assert_int_equal(ect_device_sm_bytes(node->device, 3), node->input_bytes);
        wire_open_one(&w, node->device);
        wire_go(&w, 0, ECT_STATE_OP);
        assert_int_equal(try_upload(&w, 0x1008, 0, text, &size), 0);
        assert_int_equal(size, strlen(node->name));
        assert_memory_equal(text, node->name, size);
        wire_close(&w);
    }
}

/* Decided layout of the data link: NP40, mailboxes 4000h/4800h of 276 bytes, SM2 1000h, SM3 2800h. */
static void data_link(void **state)
{
    static const struct {
        uint16_t start;
        uint8_t control;
    } sms[4] = {{0x4000, 0x26}, {0x4800, 0x22}, {0x1000, 0x64}, {0x2800, 0x20}};
    (void)state;
    FOR_EACH_NODE(node)
    {
        const ect_device_t *d = node->device;
        const uint16_t lengths[4] = {276, 276, node->output_bytes, node->input_bytes};
        assert_int_equal(d->sm_count, 4);
        for (size_t i = 0; i < 4; i++) {
            assert_int_equal(d->sm[i].start, sms[i].start);
            assert_int_equal(d->sm[i].control, sms[i].control);
            assert_int_equal(ect_device_sm_bytes(d, (unsigned int)i), lengths[i]);
        }
        wire_t w;
        wire_open_one(&w, d);
        assert_int_equal(wire_read8(&w, 0, 0x0004), 4);
        assert_int_equal(wire_read8(&w, 0, 0x0005), 4);
        assert_int_equal(wire_read8(&w, 0, 0x0006), 16);
        wire_close(&w);
        assert_int_equal(d->timeouts.preop_ms, 1000);
        assert_int_equal(d->timeouts.safeop_op_ms, 5000);
        assert_int_equal(d->timeouts.back_to_init_ms, 1000);
        assert_int_equal(d->timeouts.back_to_safeop_ms, 200);
        assert_int_equal(d->coe_details, ECT_COE_SDO | ECT_COE_SDO_INFO | ECT_COE_PDO_UPLOAD | ECT_COE_COMPLETE_ACCESS);
        assert_int_equal(d->sync.supported, 1);
        assert_int_equal(d->sync.minimum_cycle_ns, 100000);
    }
}

/* Masters read at most so many entries of a PDO, of at most so many bits. */
enum { MOST_ENTRIES = 64, WIDEST_BITS = 64 };

/* The entries of the assigned PDOs, one after the other, are the expected ones. */
static void expect_mapping(wire_t *w, const node_t *node, uint16_t assignment, uint32_t pdos, const expected_t *list,
                           size_t count, uint16_t bytes)
{
    uint32_t at = 0;
    size_t n = 0;
    assert_int_equal(upload_number(w, assignment, 0), pdos);
    for (uint8_t p = 1; p <= pdos; p++) {
        uint16_t mapping = (uint16_t)upload_number(w, assignment, p);
        uint32_t entries = upload_number(w, mapping, 0);
        assert_int_equal(mapping, (assignment == 0x1C12 ? 0x1600 : 0x1A00) + p - 1);
        assert_in_range(entries, 1, MOST_ENTRIES);
        for (uint8_t i = 1; i <= entries; i++, n++) {
            const expected_t *e = &list[n];
            assert_true(n < count);
            uint32_t want = (uint32_t)e->index << 16 | (uint32_t)e->subindex << 8 | 8u * e->field.size;
            uint32_t got = upload_number(w, mapping, i);
            if (got != want || at != 8u * e->field.offset || (got & 0xFF) > WIDEST_BITS)
                fail_msg("%s %04Xh:%u (%s): expected %08X at byte %u, got %08X at bit %u", node->name, mapping, i,
                         e->field.word, want, e->field.offset, got, at);
            at += got & 0xFF;
        }
    }
    assert_int_equal(n, count);
    assert_int_equal(at, 8u * bytes);
}

static void mappings(void **state)
{
    (void)state;
    FOR_EACH_NODE(node)
    {
        wire_t w;
        expected_t list[MOST_FIELDS];
        wire_open_one(&w, node->device);
        wire_go(&w, 0, ECT_STATE_PREOP);
        expect_mapping(&w, node, 0x1C13, node->remotes, list, inputs_of(node, list), node->input_bytes);
        if (node->output_bytes > 0)
            expect_mapping(&w, node, 0x1C12, 1, list, outputs_of(node, list), node->output_bytes);
        wire_close(&w);
    }
}

static void no_outputs_in_map1(void **state)
{
    static const uint16_t missing[] = {0x1600, OUTPUT_RECORD, PERIODIC};
    wire_t w;
    uint8_t data[64];
    size_t size;
    (void)state;
    wire_open_one(&w, &ect_eclink_map1);
    wire_go(&w, 0, ECT_STATE_OP);
    assert_int_equal(upload_number(&w, 0x1C12, 0), 0);
    assert_int_equal(try_upload(&w, 0x1C12, 1, data, &size), 0x06090011);
    for (size_t i = 0; i < COUNT(missing); i++)
        assert_int_equal(try_upload(&w, missing[i], 0, data, &size), 0x06020000);
    assert_int_equal(wire_read8(&w, 0, ECT_REG_SM + 2 * ECT_SM_SIZE + ECT_SM_ACTIVATE) & ECT_SM_ACTIVATE_ENABLE, 0);
    wire_close(&w);
}

static void mapping_is_fixed(void **state)
{
    (void)state;
    FOR_EACH_NODE(node)
    {
        wire_t w;
        wire_open_one(&w, node->device);
        wire_go(&w, 0, ECT_STATE_PREOP);
        assert_int_equal(wire_sdo_download(&w, 0, 0x1A00, 0, false, "\0", 1), 0x06010002);
        assert_int_equal(wire_sdo_download(&w, 0, 0x1A00, 1, false, "\0\0\0\0", 4), 0x06010002);
        assert_int_equal(wire_sdo_download(&w, 0, 0x1C12, 0, false, "\0", 1), 0x06010002);
        assert_int_equal(wire_sdo_download(&w, 0, 0x1C13, 0, false, "\0", 1), 0x06010002);
        assert_int_equal(wire_sdo_download(&w, 0, 0x1C13, 1, false, "\0\0", 2), 0x06010002);
        if (node->output_bytes > 0)
            assert_int_equal(wire_sdo_download(&w, 0, 0x1600, 0, false, "\0", 1), 0x06010002);
        wire_close(&w);
    }
}

/* Type, length, direction and name of each field, as SDO information gives them. */
static void expect_description(wire_t *w, const node_t *node, const expected_t *e, uint16_t pdo_bit)
{
    const uint8_t request[10] = {0x00, 0x80, 5, 0, 0, 0, (uint8_t)e->index, (uint8_t)(e->index >> 8), e->subindex, 7};
    uint8_t reply[300] = {0};
    int length = wire_coe(w, 0, request, sizeof request, reply, sizeof reply - 1);
    uint16_t type = e->field.size == 1 ? ECT_TYPE_UNSIGNED8 : ECT_TYPE_OCTET_STRING;
    reply[length > 0 ? length : 0] = 0;
    const char *name = (const char *)reply + 16;
    if (length < 17 || reply[2] != 6 || ect_load_le16(reply + 10) != type ||
        ect_load_le16(reply + 12) != 8 * e->field.size || (ect_load_le16(reply + 14) & 0x00C7) != (pdo_bit | 7) ||
        !strstr(name, e->field.word))
        fail_msg(
            "%s %04Xh:%u: expected type %04X, %u bits, PDO access %04X, a name with \"%s\"; got %04X, %u, %04X, \"%s\"",
            node->name, e->index, e->subindex, type, 8 * e->field.size, pdo_bit, e->field.word,
            ect_load_le16(reply + 10), ect_load_le16(reply + 12), ect_load_le16(reply + 14), name);
}

static void types_and_names(void **state)
{
    (void)state;
    FOR_EACH_NODE(node)
    {
        wire_t w;
        expected_t list[MOST_FIELDS];
        wire_open_one(&w, node->device);
        wire_go(&w, 0, ECT_STATE_PREOP);
        size_t count = inputs_of(node, list);
        for (size_t i = 0; i < count; i++)
            expect_description(&w, node, &list[i], 0x0080);
        count = outputs_of(node, list);
        for (size_t i = 0; i < count; i++)
            expect_description(&w, node, &list[i], 0x0040);
        wire_close(&w);
    }
}

/* --- values ------------------------------------------------------------------------------------------------------- */

static void expect_fields(wire_t *w, const node_t *node, const expected_t *list, size_t count, const uint8_t *image)
{
    for (size_t i = 0; i < count; i++) {
        uint8_t data[64];
        size_t size;
        const expected_t *e = &list[i];
        uint32_t code = try_upload(w, e->index, e->subindex, data, &size);
        if (code != 0 || size != e->field.size || memcmp(data, image + e->field.offset, size) != 0)
            fail_msg("%s %04Xh:%u (%s) is not bytes %u..+%u of the process image (abort %08X)", node->name, e->index,
                     e->subindex, e->field.word, e->field.offset, e->field.size, code);
    }
}

static void inputs_byte_for_byte(void **state)
{
    (void)state;
    FOR_EACH_NODE(node)
    {
        wire_t w;
        expected_t list[MOST_FIELDS];
        uint8_t image[ECLINK_INPUT_BYTES];
        wire_open_one(&w, node->device);
        wire_go(&w, 0, ECT_STATE_PREOP);
        for (unsigned int i = 0; i < ECLINK_INPUT_BYTES; i++)
            unit(&w)->inputs[i] = (uint8_t)(i + 1);
        wire_configure_process_data(&w, 0);
        assert_int_equal(wire_al(&w, 0, ECT_STATE_SAFEOP, NULL), ECT_STATE_SAFEOP);
        inputs_on_the_wire(&w, node, image);
        for (unsigned int i = 0; i < node->input_bytes; i++)
            assert_int_equal(image[i], i + 1);
        expect_fields(&w, node, list, inputs_of(node, list), image);
        wire_close(&w);
    }
}

static void outputs_byte_for_byte(void **state)
{
    (void)state;
    FOR_EACH_NODE(node)
    {
        wire_t w;
        expected_t list[MOST_FIELDS];
        uint8_t outputs[ECLINK_OUTPUT_BYTES], inputs[ECLINK_INPUT_BYTES];
        if (node->output_bytes == 0)
            continue;
        wire_open_one(&w, node->device);
        wire_go(&w, 0, ECT_STATE_OP);
        for (unsigned int i = 0; i < ECLINK_OUTPUT_BYTES; i++)
            outputs[i] = (uint8_t)(255 - i);
        exchange(&w, node, outputs, inputs);
        expect_fields(&w, node, list, outputs_of(node, list), outputs);
        wire_close(&w);
    }
}

static void spares_and_unarmed(void **state)
{
    (void)state;
    FOR_EACH_NODE(node)
    {
        wire_t w;
        uint8_t outputs[ECLINK_OUTPUT_BYTES], inputs[ECLINK_INPUT_BYTES];
        wire_open_one(&w, node->device);
        wire_go(&w, 0, ECT_STATE_OP);
        memset(outputs, 0xFF, sizeof outputs);
        for (unsigned int n = 0; n < 20; n++) {
            exchange(&w, node, outputs, inputs);
            assert_int_equal(inputs[27], 0);
            for (unsigned int i = 28; i < node->input_bytes; i++) {
                if (inputs[i] != 0)
                    fail_msg("%s: no RU is armed, yet byte %u is %u", node->name, i, inputs[i]);
            }
            wire_advance(&w, 50 * MS);
        }
        wire_close(&w);
    }
}

static void expect_pci(wire_t *w, const node_t *node, uint64_t since_ns)
{
    uint8_t inputs[ECLINK_INPUT_BYTES];
    uint8_t want = (uint8_t)((w->now_ns - since_ns) / (125 * MS));
    inputs_on_the_wire(w, node, inputs);
    if (inputs[0] != want)
        fail_msg("%s: %llu us after power-on: expected PCI %u, got %u", node->name,
                 (unsigned long long)((w->now_ns - since_ns) / 1000), want, inputs[0]);
}

static void pci_counts(void **state)
{
    (void)state;
    FOR_EACH_NODE(node)
    {
        wire_t w;
        wire_open_one(&w, node->device);
        uint64_t since_ns = w.now_ns;
        wire_go(&w, 0, ECT_STATE_SAFEOP);
        expect_pci(&w, node, since_ns);
        for (unsigned int n = 0; n < 600; n++) { /* twice around */
            wire_advance(&w, 125 * MS - 1);
            expect_pci(&w, node, since_ns);
            wire_advance(&w, 1);
            expect_pci(&w, node, since_ns);
        }
        wire_close(&w);
    }
}

/* A late call neither makes up for missed updates nor shifts the following ones. */
static void pci_after_a_pause(void **state)
{
    const node_t *node = &nodes[2];
    wire_t w;
    uint8_t inputs[ECLINK_INPUT_BYTES];
    (void)state;
    wire_open_one(&w, node->device);
    wire_go(&w, 0, ECT_STATE_SAFEOP);
    w.now_ns += 130 * MS;
    wire_poll(&w);
    inputs_on_the_wire(&w, node, inputs);
    assert_int_equal(inputs[0], 1);
    w.now_ns += 120 * MS;
    wire_poll(&w);
    inputs_on_the_wire(&w, node, inputs);
    assert_int_equal(inputs[0], 2);
    w.now_ns += 10000 * MS;
    wire_poll(&w);
    inputs_on_the_wire(&w, node, inputs);
    assert_int_equal(inputs[0], 3);
    wire_advance(&w, 125 * MS);
    inputs_on_the_wire(&w, node, inputs);
    assert_int_equal(inputs[0], 4);
    wire_close(&w);
}

static void acknowledges(void **state)
{
    (void)state;
    FOR_EACH_NODE(node)
    {
        wire_t w;
        uint8_t outputs[ECLINK_OUTPUT_BYTES] = {0}, inputs[ECLINK_INPUT_BYTES];
        if (node->output_bytes == 0)
            continue;
        wire_open_one(&w, node->device);
        wire_go(&w, 0, ECT_STATE_OP);
        for (unsigned int n = 0; n < 600; n++) {
            outputs[0] = (uint8_t)(3 * n);                   /* PCO */
            outputs[1] = (uint8_t)n;                         /* CCO */
            for (unsigned int ms = 0; ms <= 125; ms += 25) { /* acknowledged with the next input data */
                exchange(&w, node, outputs, inputs);
                wire_advance(&w, 25 * MS);
            }
            if (inputs[2] != outputs[0] || inputs[3] != outputs[1])
                fail_msg("%s: PCO %u, CCO %u: expected them in PAI and CAI, got %u and %u", node->name, outputs[0],
                         outputs[1], inputs[2], inputs[3]);
        }
        wire_close(&w);
    }
}

static void outputs_count_in_op_only(void **state)
{
    const node_t *node = &nodes[2];
    wire_t w;
    uint8_t outputs[ECLINK_OUTPUT_BYTES] = {9, 8, 7, 6}, inputs[ECLINK_INPUT_BYTES];
    (void)state;
    wire_open_one(&w, node->device);
    wire_go(&w, 0, ECT_STATE_SAFEOP);
    exchange(&w, node, outputs, inputs);
    exchange(&w, node, outputs, inputs);
    assert_int_equal(inputs[2], 0);
    assert_int_equal(inputs[3], 0);
    assert_int_equal(upload_number(&w, OUTPUT_RECORD, 1), 0);
    wire_close(&w);
}

/* 3001h and 3002h: the same fields as ordinary little-endian numbers. */
static void decoded_fields(void **state)
{
    wire_t w;
    uint8_t data[64];
    size_t size = 0;
    (void)state;
    wire_open_one(&w, &ect_eclink_map7);
    wire_go(&w, 0, ECT_STATE_PREOP);
    unit(&w)->inputs[38] = 0xFC; /* joystick 1: -1000 */
    unit(&w)->inputs[39] = 0x18;
    uint32_t in = try_upload(&w, 0x3001, 0, data, &size);
    uint32_t out = try_upload(&w, 0x3002, 0, data, &size);
    if (in != 0 || out != 0)
        fail_msg("the decoded fields 3001h and 3002h: expected to be there, got aborts %08X and %08X", in, out);
    assert_int_equal(try_upload(&w, 0x3001, 23, data, &size), 0); /* sub-indices as in 2001h */
    assert_int_equal(size, 2);
    assert_int_equal(ect_load_le16(data), 0xFC18);
    wire_close(&w);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"ECL-001 ECL-006..009: four nodes of 66/0, 66/24, 66/228 and 142/228 bytes, under their names",
         sizes_and_names, NULL, NULL, NULL},
        {"ECL-010: DS301's error register 1001h is there, and 0 without emergencies", error_register, NULL, NULL, NULL},
        {"ECL-035 ECL-053: no two fields of a record have the same name", names_are_unique, NULL, NULL, NULL},
        {"ECL-011: the data link of the base units", data_link, NULL, NULL, NULL},
        {"ECL-006 ECL-007 ECL-008 ECL-009: the assigned PDOs map every field at its offset and size, at most 64 "
         "entries each, none wider than 64 bits",
         mappings, NULL, NULL, NULL},
        {"ECL-006: Map1 has no RxPDO, 1C12h:0 is 0 and SM2 stays off in OP", no_outputs_in_map1, NULL, NULL, NULL},
        {"ECL-006 ECL-007 ECL-008 ECL-009: mapping and assignment are read-only", mapping_is_fixed, NULL, NULL, NULL},
        {"ECL-003 ECL-013: one byte is an UNSIGNED8, 2 and 8 bytes are octets; names and PDO direction",
         types_and_names, NULL, NULL, NULL},
        {"ECL-003 ECL-047: each input field is its bytes of the process image, in their order", inputs_byte_for_byte,
         NULL, NULL, NULL},
        {"ECL-003 ECL-055: each output field is its bytes of the process image, in their order", outputs_byte_for_byte,
         NULL, NULL, NULL},
        {"ECL-035 ECL-036 ECL-053: spare bytes and the fields of an RU that is not armed are 0", spares_and_unarmed,
         NULL, NULL, NULL},
        {"ECL-020 ECL-021: PCI counts every 125 ms and wraps", pci_counts, NULL, NULL, NULL},
        {"ECL-020: PCI continues to count by one after a pause", pci_after_a_pause, NULL, NULL, NULL},
        {"ECL-024 ECL-025: PCO is acknowledged in PAI, CCO in CAI", acknowledges, NULL, NULL, NULL},
        {"ECL-024 ECL-025: in SAFEOP outputs are not used", outputs_count_in_op_only, NULL, NULL, NULL},
        {"ECL-003 ECL-013: 3001h and 3002h show the fields as ordinary numbers", decoded_fields, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("EC-Link tables", tests, NULL, NULL);
}
