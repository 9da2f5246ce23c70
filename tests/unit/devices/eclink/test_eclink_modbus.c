/* SPDX-License-Identifier: MIT */
/* The base unit over Modbus: the tables of TS-0007 §5.2 with the corrections EC-C2, EC-C3 and EC-C17, and the owner of
 * the unit when both sides access it. */
#include <string.h>

#include "support/base_unit.h"
#include "support/every.h"

enum { MIRROR = 2048, MOST_REGISTERS = 114, MOST_BITS = 2000 };

#define COILS    ECT_MODBUS_COILS
#define DISCRETE ECT_MODBUS_DISCRETE_INPUTS
#define INPUT    ECT_MODBUS_INPUT_REGISTERS
#define HOLDING  ECT_MODBUS_HOLDING_REGISTERS

static const ect_modbus_t *side(bu_rig_t *r, void **instance)
{
    const ect_modbus_t *modbus = ect_chain_modbus(r->w.chain, 0, instance);
    assert_non_null(modbus);
    return modbus;
}

static void wake(bu_rig_t *r)
{
    ect_chain_wake(r->w.chain, 0);
    wire_poll(&r->w);
}

static ect_modbus_result_t try_read(bu_rig_t *r, ect_modbus_table_t table, unsigned int first, unsigned int count,
                                    uint16_t *values)
{
    void *instance;
    const ect_modbus_range_t range = {table, (uint16_t)first, (uint16_t)count};
    ect_modbus_result_t result = side(r, &instance)->read(instance, &range, values, r->w.now_ns);
    wake(r);
    return result;
}

static ect_modbus_result_t try_write(bu_rig_t *r, ect_modbus_table_t table, unsigned int first, unsigned int count,
                                     const uint16_t *values)
{
    void *instance;
    const ect_modbus_range_t range = {table, (uint16_t)first, (uint16_t)count};
    const ect_modbus_t *modbus = side(r, &instance);
    ect_modbus_result_t result = modbus->may_write(instance, &range);
    if (result == ECT_MODBUS_DONE)
        modbus->write(instance, &range, values, r->w.now_ns);
    wake(r);
    return result;
}

static void get(bu_rig_t *r, ect_modbus_table_t table, unsigned int first, unsigned int count, uint16_t *values)
{
    assert_int_equal(try_read(r, table, first, count, values), ECT_MODBUS_DONE);
}

static void put(bu_rig_t *r, unsigned int first, uint16_t value)
{
    assert_int_equal(try_write(r, HOLDING, first, 1, &value), ECT_MODBUS_DONE);
}

static uint16_t get_one(bu_rig_t *r, unsigned int at)
{
    uint16_t value;
    get(r, INPUT, at, 1, &value);
    return value;
}

/* --- the tables --------------------------------------------------------------------------------------------------- */

static const struct size {
    uint16_t inputs, outputs; /* bytes */
} sizes[BU_NODES] = {{66, 0}, {66, 24}, {66, 228}, {142, 228}};

/* Each table begins at `first` and has `count` items; no address exists before or after it. */
static void expect_table(bu_rig_t *r, const char *name, ect_modbus_table_t table, unsigned int first,
                         unsigned int count)
{
    uint16_t values[MOST_BITS];
    const struct {
        unsigned int first, count;
        bool there;
    } rows[] = {{first, count, true},
                {first + count - 1, 1, true},
                {first, count + 1, false},
                {first + count, 1, false},
                {first + count - 1, 2, false},
                {first > 0 ? first - 1 : 65535, 1, false},
                {first > 0 ? first - 1 : 65535, 2, false}};
    for (size_t i = count > 0 ? 0 : 2; i < COUNT(rows); i++) {
        ect_modbus_result_t got = try_read(r, table, rows[i].first, rows[i].count, values);
        if (got != (rows[i].there ? ECT_MODBUS_DONE : ECT_MODBUS_NO_ADDRESS))
            fail_msg("%s, %s, %u items from %u: expected them to be %s, got exception %d", r->node->device->type_name,
                     name, rows[i].count, rows[i].first, rows[i].there ? "there" : "missing", (int)got);
    }
}

static void tables_end_with_the_data(void **state)
{
    (void)state;
    FOR_EACH_NODE(node)
    {
        const struct size *size = &sizes[node - bu_nodes];
        bu_rig_t r;
        bu_power_on(&r, node);
        expect_table(&r, "coils", COILS, 0, size->outputs * 8u);
        expect_table(&r, "discrete inputs", DISCRETE, 0, size->inputs * 8u);
        expect_table(&r, "input registers", INPUT, 0, size->inputs / 2u);
        expect_table(&r, "holding registers of outputs", HOLDING, 0, size->outputs / 2u);
        expect_table(&r, "holding registers of inputs", HOLDING, MIRROR, size->inputs / 2u);
        wire_close(&r.w);
    }
}

static void only_outputs_can_be_written(void **state)
{
    static const struct {
        const char *what;
        ect_modbus_table_t table;
        uint16_t first, count;
        ect_modbus_result_t result[BU_NODES];
    } rows[] = {
        {"first coil", COILS, 0, 1, {2, 0, 0, 0}},
        {"last coil of commands", COILS, 191, 1, {2, 0, 0, 0}},
        {"first coil behind them", COILS, 192, 1, {2, 2, 0, 0}},
        {"last coil", COILS, 1823, 1, {2, 2, 0, 0}},
        {"coil behind it", COILS, 1824, 1, {2, 2, 2, 2}},
        {"first holding register", HOLDING, 0, 1, {2, 0, 0, 0}},
        {"those of commands", HOLDING, 0, 12, {2, 0, 0, 0}},
        {"one more", HOLDING, 0, 13, {2, 2, 0, 0}},
        {"all", HOLDING, 0, 114, {2, 2, 0, 0}},
        {"one more than all", HOLDING, 0, 115, {2, 2, 2, 2}},
        {"inputs as holding registers", HOLDING, MIRROR, 1, {2, 2, 2, 2}},
        {"discrete inputs", DISCRETE, 0, 1, {2, 2, 2, 2}},
        {"input registers", INPUT, 0, 1, {2, 2, 2, 2}},
        {"no table has it", HOLDING, 65535, 1, {2, 2, 2, 2}},
        {"beyond the last address", HOLDING, 65535, 2, {2, 2, 2, 2}},
    };
    (void)state;
    for (unsigned int n = 0; n < BU_NODES; n++) {
        bu_rig_t r;
        bu_power_on(&r, &bu_nodes[n]);
        for (size_t i = 0; i < COUNT(rows); i++) {
            const uint16_t zeros[MOST_REGISTERS + 1] = {0};
            ect_modbus_result_t got = try_write(&r, rows[i].table, rows[i].first, rows[i].count, zeros);
            if (got != rows[i].result[n])
                fail_msg("%s, %s: expected exception %d, got %d", bu_nodes[n].device->type_name, rows[i].what,
                         (int)rows[i].result[n], (int)got);
        }
        wire_close(&r.w);
    }
}

/* Fields of 16 bits, as chapters 8 and 9 have them; all others are bytes. */
static bool is_number(bool inputs, unsigned int byte)
{
    if (!inputs)
        return byte == 4 || byte == 22 || byte == 24;
    unsigned int of_ru = byte >= REMOTE ? (byte - REMOTE) % STRIDE : byte;
    if (byte < REMOTE)
        return byte == 4;
    return of_ru == 0 || (of_ru >= 10 && of_ru < 34) || of_ru == 36;
}

static uint16_t as_register(bool inputs, const uint8_t *bytes, unsigned int at)
{
    const uint8_t *two = bytes + (size_t)2 * at;
    return (uint16_t)(is_number(inputs, 2 * at) ? two[0] << 8 | two[1] : two[1] << 8 | two[0]);
}

/* Each field differs from its neighbours. */
static void fill_inputs(bu_rig_t *r)
{
    unsigned int armed = r->node == &bu_nodes[3] ? 3 : 1;
    for (unsigned int ru = 1; ru <= armed; ru++) {
        bu_set_ru(r, ru, "id", 0x1200 + (long)ru);
        bu_arm(r, ru);
        bu_set_ru(r, ru, "battery", 10 + (long)ru);
        bu_set_ru(r, ru, "rssi", 20 + (long)ru);
        bu_set_ru(r, ru, "docked", 1);
        bu_set_ru(r, ru, "joystick1", -1000 + (long)ru);
        bu_set_ru(r, ru, "joystick4", 258);
        bu_set_ru(r, ru, "fitted3", 3);
        bu_set_ru(r, ru, "switch3", -1);
        bu_set_ru(r, ru, "fitted8", 4);
        bu_set_ru(r, ru, "switch8", 513 + (long)ru);
        bu_set_ru(r, ru, "encoder", 200 + (long)ru);
        bu_set_ru(r, ru, "encoder_switch", 1);
    }
    bu_set(r, "bu.vlaps", "3");
    bu_set(r, "bu.eg_link", "1");
}

/* EtherCAT shows the same data, byte by byte. */
static void inputs_as_registers_and_bits(void **state)
{
    (void)state;
    for (unsigned int n = 1; n < BU_NODES; n++) {
        uint16_t registers[MOST_INPUTS / 2], mirror[MOST_INPUTS / 2], bits[MOST_INPUTS * 8];
        unsigned int bytes = sizes[n].inputs;
        bu_rig_t r;
        bu_in_order(&r, &bu_nodes[n], false);
        fill_inputs(&r);
        bu_command_shown(&r);
        bu_update(&r);
        get(&r, INPUT, 0, bytes / 2, registers);
        get(&r, HOLDING, MIRROR, bytes / 2, mirror);
        get(&r, DISCRETE, 0, bytes * 8, bits);
        assert_int_equal(registers[14], 0x1201); /* Armed RU */
        assert_int_equal((int16_t)registers[19], -999);
        for (unsigned int i = 0; i < bytes / 2; i++) {
            uint16_t wanted = as_register(true, r.in, i);
            if (registers[i] != wanted || mirror[i] != wanted)
                fail_msg("%s, bytes %u and %u are %02X %02X: expected register 0x%04X, got 0x%04X, mirrored 0x%04X",
                         r.node->device->type_name, 2 * i, 2 * i + 1, r.in[2 * i], r.in[2 * i + 1], wanted,
                         registers[i], mirror[i]);
        }
        for (unsigned int i = 0; i < bytes * 8; i++) {
            if (bits[i] != (r.in[i / 8] >> i % 8 & 1))
                fail_msg("%s: discrete input %u is %u, byte %u is 0x%02X", r.node->device->type_name, i, bits[i], i / 8,
                         r.in[i / 8]);
        }
        wire_close(&r.w);
    }
}

/* Any range equals the same part of the whole table. */
static void any_part_of_a_table(void **state)
{
    uint16_t all[MOST_INPUTS / 2], part[MOST_INPUTS / 2];
    bu_rig_t r;
    (void)state;
    bu_in_order(&r, &bu_nodes[3], false);
    fill_inputs(&r);
    bu_update(&r);
    get(&r, INPUT, 0, MOST_INPUTS / 2, all);
    for (unsigned int first = 0; first < MOST_INPUTS / 2; first++) {
        for (unsigned int count = 1; first + count <= MOST_INPUTS / 2; count++) {
            get(&r, first % 2 == 0 ? INPUT : HOLDING, first + (first % 2 == 0 ? 0 : MIRROR), count, part);
            if (memcmp(part, all + first, count * sizeof part[0]) != 0)
                fail_msg("%u registers from %u differ from those of the whole", count, first);
        }
    }
    wire_close(&r.w);
}

/* Written over Modbus, shown by 2002h and 2003h as the bytes of chapter 9. */
static void outputs_as_registers(void **state)
{
    (void)state;
    for (unsigned int n = 1; n < BU_NODES; n++) {
        uint16_t values[MOST_REGISTERS], back[MOST_REGISTERS], bits[MOST_OUTPUTS * 8];
        unsigned int count = sizes[n].outputs / 2;
        bu_rig_t r;
        bu_power_on(&r, &bu_nodes[n]);
        for (unsigned int i = 0; i < count; i++)
            values[i] = (uint16_t)(0x0102 * (i + 1) + 0x8000);
        assert_int_equal(try_write(&r, HOLDING, 0, count, values), ECT_MODBUS_DONE);
        get(&r, HOLDING, 0, count, back);
        assert_memory_equal(back, values, count * sizeof values[0]);
        get(&r, COILS, 0, count * 16, bits);
        for (unsigned int i = 0; i < count * 16; i++)
            r.out[i / 8] = (uint8_t)(r.out[i / 8] | bits[i] << i % 8);
        for (unsigned int i = 0; i < count; i++) {
            if (as_register(false, r.out, i) != values[i])
                fail_msg("%s: register %u is 0x%04X, its bytes are %02X %02X", r.node->device->type_name, i, values[i],
                         r.out[2 * i], r.out[2 * i + 1]);
        }
        uint8_t field[2];
        size_t size = sizeof field;
        wire_go(&r.w, 0, ECT_STATE_PREOP);
        assert_int_equal(wire_sdo_upload(&r.w, 0, 0x2002, 5, false, field, &size), 0);
        assert_int_equal(ect_load_be16(field), values[2]); /* Command RU ID */
        wire_close(&r.w);
    }
}

static void coils_alone(void **state)
{
    static const unsigned int coils[] = {0, 7, 8, 33, 191, 1023, 1816, 1823};
    uint16_t before[MOST_OUTPUTS * 8], after[MOST_OUTPUTS * 8];
    bu_rig_t r;
    (void)state;
    bu_power_on(&r, &bu_nodes[2]);
    for (unsigned int n = 0; n < 2 * COUNT(coils); n++) {
        unsigned int at = coils[n % COUNT(coils)];
        uint16_t value = n < COUNT(coils);
        get(&r, COILS, 0, MOST_OUTPUTS * 8, before);
        assert_int_equal(try_write(&r, COILS, at, 1, &value), ECT_MODBUS_DONE);
        get(&r, COILS, 0, MOST_OUTPUTS * 8, after);
        for (unsigned int i = 0; i < MOST_OUTPUTS * 8; i++) {
            uint16_t wanted = i == at ? value : before[i];
            if (after[i] != wanted)
                fail_msg("coil %u := %u: expected coil %u to be %u, got %u", at, value, i, wanted, after[i]);
        }
    }
    wire_close(&r.w);
}

/* --- a controller over Modbus ------------------------------------------------------------------------------------- */

/* PCO and CCO, PAO and CAO: register 0 and 1. */
static void write_counters(bu_rig_t *r, uint8_t pco, uint8_t cco, uint8_t cao)
{
    const uint16_t counters[2] = {(uint16_t)(cco << 8 | pco), (uint16_t)(cao << 8)};
    assert_int_equal(try_write(r, HOLDING, 0, 2, counters), ECT_MODBUS_DONE);
}

/* PCO counts every 10 ms; in Input Only inputs are read. */
static void work(bu_rig_t *r, uint64_t ns)
{
    for (uint64_t end = r->w.now_ns + ns; r->w.now_ns < end;) {
        wire_advance(&r->w, 10 * MS);
        r->out[PCO]++;
        if (r->node->duties == 0)
            (void)get_one(r, 0);
        else
            write_counters(r, r->out[PCO], r->out[CCO], r->out[CAO]);
    }
}

static void in_order(bu_rig_t *r, const bu_node_t *node)
{
    bu_power_on(r, node);
    work(r, 300 * MS);
    bu_expect(r, "a controller works over Modbus", DISARMED, OPERATIONAL);
}

static void normal_over_modbus(void **state)
{
    (void)state;
    FOR_EACH_NODE(node)
    {
        bu_rig_t r;
        bu_power_on(&r, node);
        wire_advance(&r.w, 5000 * MS);
        bu_expect(&r, "nobody came", INITIAL, NO_LINK);
        assert_int_equal(bu_number(&r, "bu.modbus"), 0);
        if (node->duties != 0) {
            uint16_t value;
            get(&r, INPUT, 0, 1, &value);
            get(&r, HOLDING, 0, 1, &value);
            bu_expect(&r, "data were read only", INITIAL, NO_LINK);
            write_counters(&r, 0, 0, 0);
        } else {
            (void)get_one(&r, 0);
        }
        if ((node->duties & PERIODIC) != 0) {
            bu_expect(&r, "PCO has not moved", INITIAL, DATA_ERROR);
            write_counters(&r, 1, 0, 0);
        }
        bu_expect(&r, "the duties of the mode", DISARMED, OPERATIONAL);
        assert_int_equal(bu_number(&r, "bu.modbus"), 1);
        wire_advance(&r.w, 125 * MS);
        assert_int_equal(get_one(&r, 11) & 0xFF, DISARMED); /* BU state, VLAPs */
        assert_int_equal(get_one(&r, 13), OPERATIONAL);     /* EC-Link status, spare */
        wire_close(&r.w);
    }
}

static void dies_after_two_seconds(void **state)
{
    (void)state;
    FOR_EACH_NODE(node)
    {
        bu_rig_t r;
        in_order(&r, node);
        bu_arm(&r, 1);
        bu_expect(&r, "armed", ARMED, OPERATIONAL);
        wire_advance(&r.w, 2000 * MS - 1);
        bu_expect(&r, "1 ns before 2000 ms without a request", ARMED, OPERATIONAL);
        wire_advance(&r.w, 1);
        bu_expect(&r, "2000 ms without a request", LINK_ERROR, NO_LINK);
        assert_int_equal(bu_number(&r, "bu.modbus"), 0);
        work(&r, 20 * MS);
        bu_expect(&r, "it came back", ARMED, OPERATIONAL);
        wire_close(&r.w);
    }
}

static void pco_does_not_change(void **state)
{
    (void)state;
    for (unsigned int n = 1; n < BU_NODES; n++) {
        bool watched = (bu_nodes[n].duties & PERIODIC) != 0;
        bu_rig_t r;
        in_order(&r, &bu_nodes[n]);
        for (unsigned int ms = 0; ms < 1990; ms += 10) {
            wire_advance(&r.w, 10 * MS);
            put(&r, 1, 0);
        }
        bu_expect(&r, "1990 ms without PCO, other outputs are written", DISARMED, OPERATIONAL);
        wire_advance(&r.w, 10 * MS);
        bu_expect(&r, "2000 ms", watched ? LINK_ERROR : DISARMED, watched ? DATA_ERROR : OPERATIONAL);
        put(&r, 0, (uint16_t)(r.out[PCO] + 1));
        bu_expect(&r, "PCO counts again", DISARMED, OPERATIONAL);
        wire_close(&r.w);
    }
}

static void commands_both_ways(void **state)
{
    static const uint8_t sent[16] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16};
    (void)state;
    for (unsigned int n = 1; n < BU_NODES; n++) {
        uint16_t command[9] = {5}; /* to remote 5 */
        char received[ECT_SIGNAL_TEXT_ROOM];
        bu_rig_t r;
        in_order(&r, &bu_nodes[n]);
        bu_set(&r, "ru5.on", "1");
        bu_set(&r, "ru4.on", "1");
        for (unsigned int i = 0; i < 8; i++)
            command[1 + i] = (uint16_t)(sent[2 * i + 1] << 8 | sent[2 * i]);
        assert_int_equal(try_write(&r, HOLDING, 2, 9, command), ECT_MODBUS_DONE);
        r.out[CCO]++;
        work(&r, 250 * MS);
        bu_get(&r, "ru5.received", received);
        assert_string_equal(received, "0102030405060708090a0b0c0d0e0f10");
        assert_int_equal(bu_number(&r, "ru4.received_count"), 0);
        assert_int_equal(get_one(&r, 1) >> 8, r.out[CCO]); /* CAI */

        bu_set(&r, "ru4.command", "f0f1f2f3f4f5f6f7f8f9fafbfcfdfeff");
        work(&r, 130 * MS);
        uint16_t inputs[11];
        get(&r, INPUT, 0, 11, inputs);
        assert_int_equal(inputs[0] >> 8, 1); /* CCI */
        assert_int_equal(inputs[2], 4);      /* Command RU ID */
        for (unsigned int i = 0; i < 8; i++)
            assert_int_equal(inputs[3 + i], 0xF1F0 + 0x0202 * i);
        work(&r, 2000 * MS);
        bu_expect(&r, "CAO does not follow", LINK_ERROR, DATA_ERROR);
        r.out[CAO] = 1;
        work(&r, 10 * MS);
        bu_expect(&r, "CAO has followed", DISARMED, OPERATIONAL);
        wire_close(&r.w);
    }
}

static void periodic_blocks(void **state)
{
    bu_rig_t r;
    (void)state;
    in_order(&r, &bu_nodes[2]);
    for (unsigned int block = 0; block < 2; block++) {
        uint16_t all[MOST_REGISTERS] = {0};
        all[0] = ++r.out[PCO];
        all[12] = 300; /* size, a number */
        all[13] = (uint16_t)block;
        for (unsigned int i = 0; i < 100; i++)
            all[14 + i] = (uint16_t)((uint8_t)(2 * (100 * block + i) + 1) << 8 | (uint8_t)(2 * (100 * block + i)));
        assert_int_equal(try_write(&r, HOLDING, 0, MOST_REGISTERS, all), ECT_MODBUS_DONE);
    }
    assert_int_equal(bu_number(&r, "bu.periodic_sets"), 1);
    assert_int_equal(bu_number(&r, "bu.periodic_size"), 300);
    ect_bulk_t set = ect_chain_bulk(r.w.chain, 0);
    for (unsigned int i = 0; i < 300; i++)
        assert_int_equal(set.data[i], (uint8_t)i);
    wire_close(&r.w);
}

/* --- from both sides ---------------------------------------------------------------------------------------------- */

static void ethercat_has_it(void **state)
{
    (void)state;
    for (unsigned int n = 1; n < BU_NODES; n++) {
        const uint16_t one = 1;
        uint16_t value;
        bu_rig_t r;
        int good = bu_in_order(&r, &bu_nodes[n], false);
        assert_int_equal(try_write(&r, HOLDING, 0, 1, &one), ECT_MODBUS_BUSY);
        assert_int_equal(try_write(&r, COILS, 0, 1, &one), ECT_MODBUS_BUSY);
        assert_int_equal(try_write(&r, HOLDING, 114, 1, &one), ECT_MODBUS_NO_ADDRESS);
        bu_cycle(&r);
        get(&r, HOLDING, 0, 1, &value);
        assert_int_equal(value & 0xFF, r.out[PCO]); /* as written by the EtherCAT master */
        assert_int_equal(get_one(&r, 0) & 0xFF, r.in[PCI]);
        bu_expect(&r, "Modbus has tried to write", good, OPERATIONAL);
        assert_int_equal(wire_al(&r.w, 0, ECT_STATE_SAFEOP, NULL), ECT_STATE_SAFEOP);
        bu_expect(&r, "EtherCAT has left OP", LINK_ERROR, NO_LINK);
        assert_int_equal(try_write(&r, HOLDING, 0, 1, &one), ECT_MODBUS_BUSY);
        wire_advance(&r.w, 2000 * MS - 1);
        assert_int_equal(try_write(&r, HOLDING, 0, 1, &one), ECT_MODBUS_BUSY);
        bu_expect(&r, "1 ns before 2000 ms outside OP", LINK_ERROR, NO_LINK);
        wire_advance(&r.w, 1);
        work(&r, 20 * MS);
        bu_expect(&r, "Modbus goes on", DISARMED, OPERATIONAL);
        wire_close(&r.w);
    }
}

static void modbus_has_it(void **state)
{
    (void)state;
    for (unsigned int n = 1; n < BU_NODES; n++) {
        uint16_t code;
        bu_rig_t r;
        in_order(&r, &bu_nodes[n]);
        wire_go(&r.w, 0, ECT_STATE_SAFEOP);
        bu_write_outputs(&r);
        assert_int_equal(wire_al(&r.w, 0, ECT_STATE_OP, &code), ECT_STATE_SAFEOP | 0x10);
        assert_int_equal(code, ECT_AL_UNSPECIFIED);
        bu_expect(&r, "an EtherCAT master requested OP", DISARMED, OPERATIONAL);
        assert_int_equal(wire_al(&r.w, 0, ECT_STATE_SAFEOP | 0x10, NULL), ECT_STATE_SAFEOP);
        work(&r, 130 * MS);
        assert_int_equal(wire_read(&r.w, 0, INPUTS_AT, r.in, sizes[n].inputs), 1);
        assert_int_equal(r.in[BU_STATE], DISARMED); /* reading is free */
        wire_advance(&r.w, 2000 * MS);
        bu_expect(&r, "Modbus has stopped", LINK_ERROR, NO_LINK);
        bu_write_outputs(&r);
        assert_int_equal(wire_al(&r.w, 0, ECT_STATE_OP, NULL), ECT_STATE_OP);
        r.counting = true;
        bu_run(&r, 20 * MS);
        bu_expect(&r, "EtherCAT has it", DISARMED, OPERATIONAL);
        wire_close(&r.w);
    }
}

static void both_read_in_input_only(void **state)
{
    bu_rig_t r;
    (void)state;
    in_order(&r, &bu_nodes[0]);
    bu_to_op(&r);
    for (unsigned int i = 0; i < 300; i++) {
        wire_advance(&r.w, 10 * MS);
        (void)get_one(&r, 0);
    }
    bu_expect(&r, "3 s: Modbus alone reads, EtherCAT is in OP", DISARMED, OPERATIONAL);
    bu_run(&r, 3000 * MS);
    bu_expect(&r, "3 s: EtherCAT alone reads", DISARMED, OPERATIONAL);
    work(&r, 100 * MS);
    assert_int_equal(wire_al(&r.w, 0, ECT_STATE_SAFEOP, NULL), ECT_STATE_SAFEOP);
    bu_expect(&r, "EtherCAT has left OP, Modbus reads", DISARMED, OPERATIONAL);
    wire_advance(&r.w, 2000 * MS - 1);
    bu_expect(&r, "1 ns before 2000 ms", DISARMED, OPERATIONAL);
    wire_advance(&r.w, 1);
    bu_expect(&r, "nobody reads", LINK_ERROR, NO_LINK);
    bu_to_op(&r);
    bu_run(&r, 100 * MS);
    work(&r, 10 * MS);
    wire_advance(&r.w, 2000 * MS);
    bu_expect(&r, "in OP, and no read", LINK_ERROR, NO_LINK);
    wire_close(&r.w);
}

/* --- no reply ----------------------------------------------------------------------------------------------------- */

static void disabled_and_hung(void **state)
{
    const ect_fault_t hang = {.kind = ECT_FAULT_HANG, .slave = 1}, resume = {.kind = ECT_FAULT_RESUME, .slave = 1};
    void *instance;
    bu_rig_t r;
    (void)state;
    in_order(&r, &bu_nodes[2]);
    bu_set(&r, "bu.enabled", "0");
    assert_null(ect_chain_modbus(r.w.chain, 0, &instance));
    bu_set(&r, "bu.enabled", "1");
    work(&r, 20 * MS);
    ect_chain_fault(r.w.chain, &hang, r.w.now_ns);
    assert_null(ect_chain_modbus(r.w.chain, 0, &instance));
    ect_chain_fault(r.w.chain, &resume, r.w.now_ns);
    (void)side(&r, &instance);
    wire_close(&r.w);
}

static void power_cycle(void **state)
{
    uint16_t value;
    bu_rig_t r;
    (void)state;
    in_order(&r, &bu_nodes[2]);
    put(&r, 113, 0x1234);
    bu_set(&r, "bu.restart", "1");
    get(&r, HOLDING, 113, 1, &value);
    assert_int_equal(value, 0);
    assert_int_equal(bu_number(&r, "bu.modbus"), 0);
    bu_expect(&r, "after power-on", INITIAL, NO_LINK);
    work(&r, 20 * MS);
    bu_expect(&r, "Modbus goes on", DISARMED, OPERATIONAL);
    wire_close(&r.w);
}

static void others_have_none(void **state)
{
    static const char *const with[] = {"vr-bu-ect-map1", "vr-bu-ect-map3", "vr-bu-ect-map7", "vr-bu-ect-multiarm"};
    (void)state;
    const ect_device_t *device;
    for (size_t i = 0; (device = every_product(i)) != NULL; i++) {
        bool wanted = false;
        for (size_t n = 0; n < COUNT(with); n++)
            wanted |= strcmp(device->name, with[n]) == 0;
        if ((plant_of(device)->modbus != NULL) != wanted)
            fail_msg("%s %s a Modbus side", device->name, wanted ? "lacks" : "has");
    }
    assert_int_equal(plant_of(&ect_eclink_map7)->modbus->connections, 4);
}

#define TEST(title, function) {title, function, NULL, NULL, NULL}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        TEST("ECL-070 ECL-071 EC-C2 EC-C3 EC-C20: the four tables have the data of the mode, inputs also as holding "
             "registers from 2048, and nothing else",
             tables_end_with_the_data),
        TEST("ECL-071: only coils and holding registers of outputs can be written", only_outputs_can_be_written),
        TEST("ECL-070 ECL-071 EC-C17: input registers, their mirror and discrete inputs show the input data; bytes the "
             "first one low, fields of 16 bits as numbers",
             inputs_as_registers_and_bits),
        TEST("ECL-070: each range equals the same part of the whole table", any_part_of_a_table),
        TEST("ECL-070 ECL-071 EC-C17: holding registers and coils are the output data", outputs_as_registers),
        TEST("ECL-070: a coil is one bit of the output data, its neighbours are unchanged", coils_alone),
        TEST("ECL-018 ECL-019 ECL-058 ECL-066 EC-C6: over Modbus the BU is in order as soon as the duties of its mode "
             "are fulfilled: writing outputs, or in Input Only reading inputs",
             normal_over_modbus),
        TEST("ECL-066 ECL-029: a Modbus controller that is silent for 2000 ms is No Data, relays open; before it is in "
             "order",
             dies_after_two_seconds),
        TEST("ECL-057 ECL-067: PCO over Modbus, unchanged for 2000 ms, is Bad data", pco_does_not_change),
        TEST("ECL-023 ECL-025 ECL-050 ECL-056: commands in both directions over Modbus; CAO that does not follow is "
             "Bad data",
             commands_both_ways),
        TEST("ECL-054 ECL-059: periodic data in blocks over Modbus", periodic_blocks),
        TEST("Both sides: while an EtherCAT master is in OP, Modbus may read, and writes are refused as busy",
             ethercat_has_it),
        TEST("Both sides: while a Modbus controller writes an EtherCAT master reads, and OP is refused; 2000 ms after "
             "the "
             "last request it is not",
             modbus_has_it),
        TEST("Both sides, Input Only: both may read, and one of them is sufficient", both_read_in_input_only),
        TEST("ECL-002: no reply over Modbus in mode Disabled, or while the unit hangs", disabled_and_hung),
        TEST("After a power cycle the outputs are zero and the controller starts again", power_cycle),
        TEST("ECL-070: the base units have a Modbus side with four connections, the other products none",
             others_have_none),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("EC-Link over Modbus", tests, NULL, NULL);
}
