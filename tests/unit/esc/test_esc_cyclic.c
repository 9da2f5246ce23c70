/* SPDX-License-Identifier: MIT */
/* The effect of a controller on frames of process data, computed in advance, against the reference. */
#include <stdlib.h>
#include <string.h>

#include "esc/cyclic.h"
#include "support/chip.h"

enum { INPUTS = 0x1400, OUTPUTS = 0x1100, IN_BYTES = 6, OUT_BYTES = 4, DATA = 10, LONGEST = 40 };
#define LOGICAL 0x00012345u /* of the inputs; the outputs begin 10 bytes behind */

static void set_fmmu(chip_t *c, unsigned int n, uint32_t logical, uint16_t length, uint16_t physical, uint8_t type)
{
    uint8_t fmmu[16] = {[7] = 7, [11] = type, [12] = 1};
    ect_store_le32(fmmu, logical);
    ect_store_le16(fmmu + 4, length);
    ect_store_le16(fmmu + 8, physical);
    assert_int_equal(chip_send(c, APWR, (uint16_t)(0x0600 + 16 * n), fmmu, sizeof fmmu), 1);
}

static chip_t *mapped(const char *name)
{
    chip_t *c = chip_new(name);
    chip_set_sm(c, 2, OUTPUTS, OUT_BYTES, 0x24, 1);
    chip_set_sm(c, 3, INPUTS, IN_BYTES, 0x20, 1);
    set_fmmu(c, 0, LOGICAL, IN_BYTES, INPUTS, 1);
    set_fmmu(c, 1, LOGICAL + 10, OUT_BYTES, OUTPUTS, 2);
    chip_pdi_write(c, INPUTS, 0x060504030201, IN_BYTES);
    return c;
}

/* Compares a certain effect with the datagram itself. */
static void expect_as_computed(chip_t *c, const char *what, uint8_t command, uint32_t logical, uint16_t length,
                               const ect_esc_cyclic_t *effect)
{
    uint8_t data[LONGEST], expected[LONGEST];
    memset(data, 0xA5, sizeof data);
    memset(expected, 0xA5, sizeof expected);
    for (unsigned int i = 0; i < effect->piece_count; i++)
        memcpy(expected + effect->pieces[i].at, effect->pieces[i].from, effect->pieces[i].length);
    wire_build(&c->w, command, (uint16_t)logical, (uint16_t)(logical >> 16), data, length);
    chip_transmit(c);
    if (wire_wkc(&c->w, 0) != effect->gain || memcmp(wire_datagram(&c->w, 0) + DATA, expected, length) != 0)
        fail_msg("%s: the datagram has another effect, its working counter is %u", what, wire_wkc(&c->w, 0));
}

static void windows(void **state)
{
    static const struct {
        const char *what;
        uint8_t command;
        int offset; /* of the datagram, from the inputs */
        uint16_t length;
        bool certain;
        unsigned int gain, pieces;
        uint16_t at;
    } rows[] = {
        {"LRD of the inputs", LRD, 0, 6, true, 1, 1, 0},
        {"LRD with bytes before and behind", LRD, -5, 16, true, 1, 1, 5},
        {"LRD that begins within the inputs", LRD, 1, 6, false, 0, 0, 0},
        {"LRD that ends within the inputs", LRD, -1, 6, false, 0, 0, 0},
        {"LRD before the inputs", LRD, -5, 5, true, 0, 0, 0},
        {"LRD behind the inputs", LRD, 6, 10, true, 0, 0, 0},
        {"LWR of the outputs", LWR, 10, 4, true, 1, 0, 0},
        {"LWR of all", LWR, 0, 20, true, 1, 0, 0},
        {"LWR of the inputs", LWR, 0, 6, true, 0, 0, 0},
        {"LWR of a part of the outputs", LWR, 10, 3, false, 0, 0, 0},
        {"LRW of all", LRW, 0, 14, true, 3, 1, 0},
        {"LRW of all, with bytes before", LRW, -3, 17, true, 3, 1, 3},
        {"LRW of the inputs", LRW, 0, 6, true, 1, 1, 0},
        {"LRW of the outputs", LRW, 10, 4, true, 2, 0, 0},
        {"LRW between both", LRW, 6, 4, true, 0, 0, 0},
        {"LRW of a part of the outputs", LRW, 0, 13, false, 0, 0, 0},
        {"LRW of a part of the inputs", LRW, 2, 12, false, 0, 0, 0},
        {"BRW", BRW, 0, 6, false, 0, 0, 0},
        {"ARMW", ARMW, 0, 6, false, 0, 0, 0},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        chip_t *c = mapped("et1100");
        const uint32_t logical = LOGICAL + (uint32_t)rows[i].offset;
        ect_esc_cyclic_t effect;
        const bool certain = ect_esc_cyclic(&c->esc, rows[i].command, logical, rows[i].length, &effect);
        if (certain != rows[i].certain)
            fail_msg("%s: expected %s", rows[i].what, rows[i].certain ? "a certain effect" : "none that is certain");
        if (certain) {
            if (effect.gain != rows[i].gain || effect.piece_count != rows[i].pieces)
                fail_msg("%s: expected gain %u, %u pieces, got %u, %u", rows[i].what, rows[i].gain, rows[i].pieces,
                         effect.gain, effect.piece_count);
            if (effect.piece_count == 1) {
                assert_int_equal(effect.pieces[0].at, rows[i].at);
                assert_int_equal(effect.pieces[0].length, IN_BYTES);
                assert_int_equal(effect.pieces[0].sm, 3);
                assert_ptr_equal(effect.pieces[0].from, ect_esc_newest_image(&c->esc, 3));
            }
            expect_as_computed(c, rows[i].what, rows[i].command, logical, rows[i].length, &effect);
        }
        free(c);
    }
}

/* Each change makes the effect of a LRW of all uncertain. */
static void uncertain(void **state)
{
    static const struct {
        const char *what;
        uint16_t in_start, out_start;
        uint8_t in_control, out_control;
        uint16_t reg; /* written afterwards, 0: none */
        uint8_t value;
        bool by_pdi, certain;
    } rows[] = {
        {"nothing", INPUTS, OUTPUTS, 0x20, 0x24, 0, 0, false, true},
        {"AL events and a watchdog", INPUTS, OUTPUTS, 0x20, 0x64, 0, 0, false, true},
        {"an ECAT event of the inputs", INPUTS, OUTPUTS, 0x30, 0x24, 0, 0, false, false},
        {"an ECAT event of the outputs", INPUTS, OUTPUTS, 0x20, 0x34, 0, 0, false, false},
        {"sequential mode", INPUTS, OUTPUTS, 0x20, 0xA4, 0, 0, false, false},
        {"outputs as a mailbox", INPUTS, OUTPUTS, 0x20, 0x26, 0, 0, false, false},
        {"inputs that the master writes", INPUTS, OUTPUTS, 0x24, 0x24, 0, 0, false, false},
        {"outputs that the master reads", INPUTS, OUTPUTS, 0x20, 0x20, 0, 0, false, false},
        {"three buffers up to the next", 0x1100 + 3 * OUT_BYTES, OUTPUTS, 0x20, 0x24, 0, 0, false, true},
        {"three buffers into the next", 0x1100 + 3 * OUT_BYTES - 1, OUTPUTS, 0x20, 0x24, 0, 0, false, false},
        {"overlapping ones", OUTPUTS + 2, OUTPUTS, 0x20, 0x24, 0, 0, false, false},
        {"three buffers up to the end", 0x3000 - 3 * IN_BYTES, OUTPUTS, 0x20, 0x24, 0, 0, false, true},
        {"three buffers beyond the end", 0x3000 - 3 * IN_BYTES + 1, OUTPUTS, 0x20, 0x24, 0, 0, false, false},
        {"write protection of registers", INPUTS, OUTPUTS, 0x20, 0x24, 0x0021, 1, false, false},
        {"write protection of all", INPUTS, OUTPUTS, 0x20, 0x24, 0x0031, 1, false, false},
        {"inputs that the PDI has disabled", INPUTS, OUTPUTS, 0x20, 0x24, 0x081F, 1, true, false},
        {"outputs that the PDI has disabled", INPUTS, OUTPUTS, 0x20, 0x24, 0x0817, 1, true, false},
        {"a start bit", INPUTS, OUTPUTS, 0x20, 0x24, 0x0606, 1, false, false},
        {"a stop bit", INPUTS, OUTPUTS, 0x20, 0x24, 0x0617, 6, false, false},
        {"both directions in one FMMU", INPUTS, OUTPUTS, 0x20, 0x24, 0x060B, 3, false, false},
        {"no FMMU of the inputs", INPUTS, OUTPUTS, 0x20, 0x24, 0x060C, 0, false, true},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        chip_t *c = mapped("et1100");
        ect_esc_cyclic_t effect;
        chip_set_sm(c, 2, rows[i].out_start, OUT_BYTES, rows[i].out_control, 1);
        chip_set_sm(c, 3, rows[i].in_start, IN_BYTES, rows[i].in_control, 1);
        set_fmmu(c, 0, LOGICAL, IN_BYTES, rows[i].in_start, 1);
        set_fmmu(c, 1, LOGICAL + 10, OUT_BYTES, rows[i].out_start, 2);
        chip_pdi_write(c, rows[i].in_start, 0x060504030201, IN_BYTES);
        if (rows[i].by_pdi)
            chip_pdi_write(c, rows[i].reg, rows[i].value, 1);
        else if (rows[i].reg != 0)
            assert_int_equal(chip_write(c, rows[i].reg, rows[i].value, 1), 1);
        if (ect_esc_cyclic(&c->esc, LRW, LOGICAL, 14, &effect) != rows[i].certain)
            fail_msg("%s: expected %s", rows[i].what, rows[i].certain ? "a certain effect" : "none that is certain");
        if (rows[i].certain)
            expect_as_computed(c, rows[i].what, LRW, LOGICAL, 14, &effect);
        free(c);
    }
}

static void before_the_first_image(void **state)
{
    ect_esc_cyclic_t effect;
    (void)state;
    chip_t *c = mapped("et1100");
    chip_set_sm(c, 3, INPUTS, IN_BYTES, 0x20, 1);
    assert_null(ect_esc_newest_image(&c->esc, 3));
    assert_false(ect_esc_cyclic(&c->esc, LRD, LOGICAL, IN_BYTES, &effect));
    for (unsigned int n = 0; n < 6; n++) {
        chip_pdi_write(c, INPUTS, 0x010101010101 * (n + 1), IN_BYTES);
        assert_true(ect_esc_cyclic(&c->esc, LRD, LOGICAL, IN_BYTES, &effect));
        assert_int_equal(effect.pieces[0].from[5], n + 1);
    }
    free(c);
}

int main(int argc, char **argv)
{
    static const struct CMUnitTest tests[] = {
        {"CF-028: the effect of LRD, LWR and LRW on whole, partial and missing images", windows, NULL, NULL, NULL},
        {"CF-028: settings that make the effect uncertain", uncertain, NULL, NULL, NULL},
        {"CF-028: the newest image, and none before the first", before_the_first_image, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("ESC effects computed in advance", tests, NULL, NULL);
}
