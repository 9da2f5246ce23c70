/* SPDX-License-Identifier: MIT */
/* EC-Link periodic output data: blocks of 200 bytes become whole sets, and only whole ones are shown (TS-0007 §10.4).
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "devices/eclink/eclink.h"
#include "support/signals.h"
#include "support/wire.h"

#define COUNT(table) (sizeof(table) / sizeof((table)[0]))

enum { OUTPUTS_AT = 0x1000, INPUTS_AT = 0x2800, MOST_INPUTS = 142, OUTPUT_BYTES = 228, UPDATE_MS = 125 };
enum { PCO = 0, PAO = 2, SIZE = 24, BLOCK = 26, SPARE = 27, DATA = 28, PAI = 2, BLOCK_BYTES = 200, LARGEST = 51200 };

static const ect_device_t *const nodes[] = {&ect_eclink_map7, &ect_eclink_multiarm};

typedef struct rig {
    wire_t w;
    const ect_device_t *device;
    uint8_t out[OUTPUT_BYTES];
    uint8_t in[MOST_INPUTS];
    unsigned long sets; /* as they should be */
    unsigned long errors;
} rig_t;

static void cycle(rig_t *r)
{
    assert_int_equal(wire_write(&r->w, 0, OUTPUTS_AT, r->out, OUTPUT_BYTES), 1);
    assert_int_equal(wire_read(&r->w, 0, INPUTS_AT, r->in, ect_device_sm_bytes(r->device, 3)), 1);
}

static void to_op(rig_t *r)
{
    wire_go(&r->w, 0, ECT_STATE_SAFEOP);
    cycle(r);
    assert_int_equal(wire_al(&r->w, 0, ECT_STATE_OP, NULL), ECT_STATE_OP);
}

/* Time passes without new periodic data. */
static void pause_ms(rig_t *r, unsigned int ms)
{
    for (; ms > 0; ms--) {
        wire_advance(&r->w, 1 * MS);
        cycle(r);
    }
}

static unsigned long number(rig_t *r, const char *name)
{
    return (unsigned long)signal_number(&r->w, name);
}

static void set(rig_t *r, const char *name, const char *value)
{
    signal_set(&r->w, name, value);
}

static void start(rig_t *r, const ect_device_t *device)
{
    memset(r, 0, sizeof *r);
    r->device = device;
    wire_open_one(&r->w, device);
    to_op(r);
}

/* --- an oracle: zlib's CRC-32, by table; sets whose every byte depends on which set it is ------------------------- */

static uint32_t crc32_of(const uint8_t *data, size_t length)
{
    uint32_t table[256];
    for (uint32_t n = 0; n < 256; n++) {
        table[n] = n;
        for (int k = 0; k < 8; k++)
            table[n] = table[n] % 2 != 0 ? 0xEDB88320u ^ (table[n] >> 1) : table[n] >> 1;
    }
    uint32_t crc = 0xFFFFFFFFu;
    for (size_t i = 0; i < length; i++)
        crc = table[(crc ^ data[i]) & 0xFF] ^ (crc >> 8);
    return crc ^ 0xFFFFFFFFu;
}

static void fill(uint8_t *set_bytes, unsigned int number_of_set)
{
    uint32_t x = 2654435761u * (number_of_set + 1);
    for (size_t i = 0; i < LARGEST + BLOCK_BYTES; i++) {
        x = x * 1664525u + 1013904223u;
        set_bytes[i] = (uint8_t)(x >> 24);
    }
}

static unsigned int blocks_of(unsigned int size)
{
    return size / BLOCK_BYTES + (size % BLOCK_BYTES != 0 ? 1 : 0);
}

/* One block of a set, announced by PCO. Bytes behind the set's last byte are not part of it. */
static void give_block(rig_t *r, const uint8_t *bytes, unsigned int size, unsigned int block)
{
    ect_store_be16(r->out + SIZE, (uint16_t)size);
    r->out[BLOCK] = (uint8_t)block;
    memcpy(r->out + DATA, bytes + (size_t)block * BLOCK_BYTES, BLOCK_BYTES);
    r->out[PCO]++;
    wire_advance(&r->w, 1 * MS);
    cycle(r);
}

static void expect_set(rig_t *r, const char *when, const uint8_t *bytes, unsigned int size)
{
    uint32_t crc = size > 0 ? crc32_of(bytes, size) : 0;
    if (number(r, "bu.periodic_sets") != r->sets || number(r, "bu.periodic_size") != size ||
        number(r, "bu.periodic_check") != crc || number(r, "bu.periodic_errors") != r->errors)
        fail_msg("%s: expected %lu sets, the last of %u bytes with CRC %08X, and %lu errors; got %lu, %lu, %08lX, %lu",
                 when, r->sets, size, crc, r->errors, number(r, "bu.periodic_sets"), number(r, "bu.periodic_size"),
                 number(r, "bu.periodic_check"), number(r, "bu.periodic_errors"));
    ect_bulk_t shown = ect_chain_bulk(r->w.chain, 0);
    if (size > 0 && (shown.size != size || !shown.data || memcmp(shown.data, bytes, size) != 0))
        fail_msg("%s: the set that can be read is not that of %u bytes that is counted", when, size);
}

static uint8_t *new_set(unsigned int number_of_set)
{
    uint8_t *bytes = malloc(LARGEST + BLOCK_BYTES);
    fill(bytes, number_of_set);
    return bytes;
}

/* --- sets --------------------------------------------------------------------------------------------------------- */

static void oracle(void **state)
{
    (void)state;
    assert_int_equal(crc32_of((const uint8_t *)"123456789", 9), 0xCBF43926);
}

static void sizes(void **state)
{
    static const unsigned int rows[] = {1, 2, 199, 200, 201, 399, 400, 401, 5000, 51000, 51001, 51199, 51200};
    (void)state;
    for (size_t n = 0; n < COUNT(nodes); n++) {
        rig_t r;
        uint8_t *old = NULL;
        unsigned int old_size = 0;
        start(&r, nodes[n]);
        expect_set(&r, "nothing has come", NULL, 0);
        for (unsigned int i = 0; i < COUNT(rows); i++) {
            uint8_t *bytes = new_set(i);
            unsigned int blocks = blocks_of(rows[i]);
            for (unsigned int b = 0; b < blocks; b++) {
                expect_set(&r, "not complete yet", old, old_size);
                give_block(&r, bytes, rows[i], b);
            }
            r.sets++;
            expect_set(&r, "complete", bytes, rows[i]);
            free(old);
            old = bytes;
            old_size = rows[i];
        }
        free(old);
        wire_close(&r.w);
    }
}

static void size_zero(void **state)
{
    (void)state;
    rig_t r;
    uint8_t *bytes = new_set(0);
    start(&r, nodes[0]);
    for (unsigned int b = 0; b < 256; b++)
        give_block(&r, bytes, 0, b % 2 == 0 ? 0 : b);
    expect_set(&r, "size 0: no set, no error", NULL, 0);
    give_block(&r, bytes, 7, 0);
    r.sets++;
    expect_set(&r, "7 bytes", bytes, 7);
    give_block(&r, bytes, 0, 0);
    expect_set(&r, "size 0 after 7 bytes", bytes, 7);
    assert_int_equal(number(&r, "bu.ec_link"), 1);
    free(bytes);
    wire_close(&r.w);
}

static void any_order(void **state)
{
    static const struct {
        unsigned int size, step; /* block (step * n) mod blocks; step and blocks have no common divisor */
    } rows[] = {{401, 2}, {600, 1}, {1000, 3}, {51200, 255}, {51200, 77}, {50999, 101}};
    (void)state;
    rig_t r;
    start(&r, nodes[0]);
    for (unsigned int i = 0; i < COUNT(rows); i++) {
        uint8_t *bytes = new_set(i);
        unsigned int blocks = blocks_of(rows[i].size);
        for (unsigned int n = 0; n < blocks; n++) {
            assert_int_equal(number(&r, "bu.periodic_sets"), r.sets);
            give_block(&r, bytes, rows[i].size, rows[i].step * n % blocks);
        }
        r.sets++;
        expect_set(&r, "any order", bytes, rows[i].size);
        free(bytes);
    }
    wire_close(&r.w);
}

static void without_pco_nothing(void **state)
{
    (void)state;
    rig_t r;
    uint8_t *a = new_set(1), *b = new_set(2);
    start(&r, nodes[1]);
    give_block(&r, a, 400, 0);
    memcpy(r.out + DATA, b, BLOCK_BYTES);
    r.out[BLOCK] = 1;
    cycle(&r);
    cycle(&r);
    expect_set(&r, "block 1 without PCO", NULL, 0);
    give_block(&r, a, 400, 1);
    r.sets++;
    expect_set(&r, "block 1 with PCO", a, 400);
    for (unsigned int n = 0; n < 5; n++)
        cycle(&r);
    expect_set(&r, "the same cycle again and again", a, 400);
    free(a);
    free(b);
    wire_close(&r.w);
}

static void repeated_blocks(void **state)
{
    (void)state;
    rig_t r;
    uint8_t *a = new_set(1), *b = new_set(2);
    start(&r, nodes[0]);
    for (unsigned int n = 0; n < 5; n++)
        give_block(&r, a, 600, 0);
    give_block(&r, a, 600, 2);
    give_block(&r, a, 600, 2);
    expect_set(&r, "two of three blocks, each repeated", NULL, 0);
    assert_int_equal(number(&r, "bu.periodic_unfinished"), 4); /* block 0 begins a set, always */
    give_block(&r, a, 600, 1);
    r.sets++;
    expect_set(&r, "all three", a, 600);
    give_block(&r, a, 600, 1);
    expect_set(&r, "the last block repeated belongs to no set", a, 600);
    assert_int_equal(number(&r, "bu.periodic_skipped"), 1);
    give_block(&r, b, 600, 0);
    give_block(&r, b, 600, 1); /* newer bytes replace the older ones */
    give_block(&r, b, 600, 2);
    r.sets++;
    expect_set(&r, "the next set", b, 600);
    free(a);
    free(b);
    wire_close(&r.w);
}

static void size_changes_in_the_middle(void **state)
{
    static const struct {
        unsigned int first, then;
    } rows[] = {{600, 601}, {600, 599}, {600, 400}, {400, 51200}, {51200, 400}, {600, 1}, {401, 402}};
    (void)state;
    rig_t r;
    start(&r, nodes[0]);
    for (unsigned int i = 0; i < COUNT(rows); i++) {
        uint8_t *a = new_set(2 * i), *b = new_set(2 * i + 1);
        give_block(&r, a, rows[i].first, 0);
        give_block(&r, a, rows[i].first, 1 % blocks_of(rows[i].first));
        unsigned long sets = number(&r, "bu.periodic_sets");
        r.sets += rows[i].first <= 400 ? 1 : 0;
        assert_int_equal(sets, r.sets);
        for (unsigned int n = 0; n < blocks_of(rows[i].then); n++) {
            assert_int_equal(number(&r, "bu.periodic_sets"), r.sets);
            give_block(&r, b, rows[i].then, n);
        }
        r.sets++;
        expect_set(&r, "the set of the new size", b, rows[i].then);
        free(a);
        free(b);
    }
    wire_close(&r.w);
}

/* To another size and back: blocks before the change do not belong to the set after it. */
static void size_changes_and_returns(void **state)
{
    static const unsigned int between[] = {600, 399, 1, 0};
    (void)state;
    for (size_t i = 0; i < COUNT(between); i++) {
        rig_t r;
        char when[40];
        uint8_t *a = new_set(1), *b = new_set(2), *c = new_set(3);
        start(&r, nodes[0]);
        give_block(&r, a, 400, 0);
        give_block(&r, b, between[i], 0);
        r.sets += between[i] == 1 ? 1 : 0;
        give_block(&r, c, 400, 1);
        snprintf(when, sizeof when, "block 1 after size %u", between[i]);
        expect_set(&r, when, b, between[i] == 1 ? 1 : 0);
        give_block(&r, c, 400, 0);
        give_block(&r, c, 400, 1);
        r.sets++;
        expect_set(&r, "from block 0 on", c, 400);
        free(a);
        free(b);
        free(c);
        wire_close(&r.w);
    }
}

static void impossible_blocks(void **state)
{
    static const struct {
        unsigned int size, block;
    } rows[] = {{51201, 0}, {51201, 255}, {51400, 0},   {65535, 0},  {65535, 255}, {1, 1},
                {1, 255},   {199, 1},     {200, 1},     {201, 2},    {400, 2},     {400, 255},
                {401, 3},   {51000, 255}, {50800, 254}, {32768, 164}};
    (void)state;
    rig_t r;
    uint8_t *a = new_set(1), *wrong = new_set(2);
    start(&r, nodes[1]);
    for (size_t i = 0; i < COUNT(rows); i++) {
        give_block(&r, a, 600, 0);
        memcpy(r.out + DATA, wrong, BLOCK_BYTES);
        ect_store_be16(r.out + SIZE, (uint16_t)rows[i].size);
        r.out[BLOCK] = (uint8_t)rows[i].block;
        r.out[PCO]++;
        cycle(&r);
        cycle(&r);
        r.errors++;
        if (number(&r, "bu.periodic_errors") != r.errors)
            fail_msg("size %u, block %u: expected %lu errors, got %lu", rows[i].size, rows[i].block, r.errors,
                     number(&r, "bu.periodic_errors"));
        give_block(&r, a, 600, 1);
        give_block(&r, a, 600, 2);
        r.sets++;
        expect_set(&r, "the impossible block was ignored", a, 600);
        assert_int_equal(number(&r, "bu.ec_link"), 1);
    }
    free(a);
    free(wrong);
    wire_close(&r.w);
}

/* --- never a mixture ---------------------------------------------------------------------------------------------- */

static void hand_over_is_atomic(void **state)
{
    enum { SETS = 12, BYTES = 1999 };
    (void)state;
    rig_t r;
    uint8_t *old = new_set(0);
    unsigned int old_size = 0;
    start(&r, nodes[0]);
    for (unsigned int n = 1; n <= SETS; n++) {
        uint8_t *bytes = new_set(n);
        for (unsigned int b = 0; b < blocks_of(BYTES); b++) {
            expect_set(&r, "the old set until the new one is complete", old, old_size);
            give_block(&r, bytes, BYTES, b * (n % 2 == 0 ? 7 : 3) % blocks_of(BYTES));
            if (b == 4)
                pause_ms(&r, 300);
        }
        r.sets++;
        expect_set(&r, "the new set", bytes, BYTES);
        free(old);
        old = bytes;
        old_size = BYTES;
    }
    free(old);
    wire_close(&r.w);
}

/* Blocks of two sets, sent by a controller that is interrupted in the middle of the first. */
static void interrupted_exchange(void **state)
{
    static const uint8_t down[] = {ECT_STATE_INIT, ECT_STATE_PREOP, ECT_STATE_SAFEOP, 0 /* watchdog */};
    (void)state;
    for (size_t i = 0; i < COUNT(down); i++) {
        rig_t r;
        uint8_t *a = new_set(1), *b = new_set(2);
        start(&r, nodes[0]);
        give_block(&r, a, 400, 0);
        if (down[i] != 0)
            assert_int_equal(wire_al(&r.w, 0, down[i], NULL), down[i]);
        wire_advance(&r.w, 1000 * MS);
        memset(r.out + SIZE, 0, 4);
        to_op(&r);
        give_block(&r, b, 400, 1);
        expect_set(&r, "half of a set from before the interruption is not completed by half of another", NULL, 0);
        give_block(&r, b, 400, 0);
        give_block(&r, b, 400, 1);
        r.sets++;
        expect_set(&r, "the set from after the interruption", b, 400);
        assert_int_equal(number(&r, "bu.periodic_unfinished"), 1);
        assert_int_equal(number(&r, "bu.periodic_lost"), 1);
        free(a);
        free(b);
        wire_close(&r.w);
    }
}

/* The last block of a set is lost and the controller continues with the next set, in order. */
static void lost_last_block(void **state)
{
    (void)state;
    rig_t r;
    uint8_t *a = new_set(1), *b = new_set(2);
    start(&r, nodes[0]);
    give_block(&r, a, 600, 0);
    give_block(&r, a, 600, 1);
    r.out[PCO]++; /* that cycle never arrived */
    for (unsigned int n = 0; n < 3; n++) {
        expect_set(&r, "the first set never became whole", NULL, 0);
        give_block(&r, b, 600, n);
    }
    r.sets++;
    expect_set(&r, "the next set", b, 600);
    free(a);
    free(b);
    wire_close(&r.w);
}

/* The outputs are ready when OP is entered: the first block of the first set, or one from the middle. */
static void first_outputs(void **state)
{
    (void)state;
    for (unsigned int block = 0; block <= 1; block++) {
        rig_t r = {.device = nodes[0]};
        uint8_t *a = new_set(1), *b = new_set(2);
        wire_open_one(&r.w, r.device);
        ect_store_be16(r.out + SIZE, 600);
        r.out[BLOCK] = (uint8_t)block;
        memcpy(r.out + DATA, a + (size_t)block * BLOCK_BYTES, BLOCK_BYTES);
        r.out[PCO] = 77;
        to_op(&r);
        cycle(&r);
        cycle(&r);
        assert_int_equal(number(&r, "bu.pai"), 77);
        for (unsigned int n = block + 1; n <= 2; n++)
            give_block(&r, a, 600, n);
        r.sets += block == 0 ? 1 : 0;
        expect_set(&r, "the set with which OP began", a, block == 0 ? 600 : 0);
        assert_int_equal(number(&r, "bu.periodic_skipped"), block == 0 ? 0 : 2);
        for (unsigned int n = 0; n <= 2; n++)
            give_block(&r, b, 600, n);
        r.sets++;
        expect_set(&r, "the next set", b, 600);
        free(a);
        free(b);
        wire_close(&r.w);
    }
}

/* Blocks of sets a, b, c of 600 bytes, as "a0 b1 ..."; the results. */
static const struct sequence {
    const char *blocks;
    char last; /* the complete set at the end, 0 none */
    unsigned int sets, unfinished, lost, skipped;
} sequences[] = {
    {"a0 a1 a2", 'a', 1, 0, 0, 0},        {"a0 a2 a1", 'a', 1, 0, 0, 0},
    {"a1 a2 b0 b1 b2", 'b', 1, 0, 0, 2},  {"a0 b0 b1 b2", 'b', 1, 1, 2, 0},
    {"a0 a1 b0 b1 b2", 'b', 1, 1, 1, 0},  {"a0 a2 b0 b1 b2 c0 c1 c2", 'c', 2, 1, 1, 0},
    {"a0 a1 b0 b2 c0 c1", 0, 0, 2, 2, 0}, {"a0 a1 a2 b1 b2 c0 c1 c2", 'c', 2, 0, 0, 2},
    {"a0 a0 a1 a2", 'a', 1, 1, 2, 0},     {"a0 a1 a1 a2", 'a', 1, 0, 0, 0},
};

static void block_0_begins_a_set(void **state)
{
    (void)state;
    for (size_t i = 0; i < COUNT(sequences); i++) {
        const struct sequence *c = &sequences[i];
        uint8_t *sets[] = {new_set(1), new_set(2), new_set(3)};
        rig_t r;
        start(&r, nodes[i % 2]);
        for (const char *block = c->blocks; *block; block += block[2] ? 3 : 2)
            give_block(&r, sets[block[0] - 'a'], 600, (unsigned int)(block[1] - '0'));
        r.sets = c->sets;
        expect_set(&r, c->blocks, c->last ? sets[c->last - 'a'] : NULL, c->last ? 600 : 0);
        if (number(&r, "bu.periodic_unfinished") != c->unfinished || number(&r, "bu.periodic_lost") != c->lost ||
            number(&r, "bu.periodic_skipped") != c->skipped)
            fail_msg("%s: expected %u sets unfinished, %u blocks lost, %u skipped; got %lu, %lu, %lu", c->blocks,
                     c->unfinished, c->lost, c->skipped, number(&r, "bu.periodic_unfinished"),
                     number(&r, "bu.periodic_lost"), number(&r, "bu.periodic_skipped"));
        for (size_t n = 0; n < COUNT(sets); n++)
            free(sets[n]);
        wire_close(&r.w);
    }
}

/* A block of a set of another size: the set in transfer is abandoned, even if its size is sent again. */
static void block_of_another_size(void **state)
{
    (void)state;
    rig_t r;
    uint8_t *a = new_set(1), *b = new_set(2);
    start(&r, nodes[0]);
    give_block(&r, a, 600, 0);
    give_block(&r, b, 400, 1);
    give_block(&r, b, 600, 1);
    give_block(&r, b, 600, 2);
    expect_set(&r, "a0, then blocks of others", NULL, 0);
    assert_int_equal(number(&r, "bu.periodic_skipped"), 3);
    assert_int_equal(number(&r, "bu.periodic_unfinished"), 1);
    assert_int_equal(number(&r, "bu.periodic_lost"), 2);
    free(a);
    free(b);
    wire_close(&r.w);
}

static void expect_pending(rig_t *r, const char *when, unsigned int size, unsigned int missing)
{
    if (number(r, "bu.periodic_pending") != size || number(r, "bu.periodic_missing") != missing)
        fail_msg("%s: expected %u bytes coming in, %u blocks missing; got %lu, %lu", when, size, missing,
                 number(r, "bu.periodic_pending"), number(r, "bu.periodic_missing"));
}

static void missing_blocks(void **state)
{
    (void)state;
    rig_t r;
    uint8_t *a = new_set(1);
    start(&r, nodes[0]);
    expect_pending(&r, "nothing has come", 0, 0);
    for (unsigned int n = 0; n < 5; n++) {
        give_block(&r, a, 1100, n);
        expect_pending(&r, "one block more", 1100, 5 - n);
    }
    give_block(&r, a, 1100, 5);
    expect_pending(&r, "complete", 0, 0);
    give_block(&r, a, 0xC201, 0); /* 450, its bytes in the wrong order */
    expect_pending(&r, "a size with swapped bytes", 0xC201, 248);
    assert_int_equal(wire_al(&r.w, 0, ECT_STATE_SAFEOP, NULL), ECT_STATE_SAFEOP);
    expect_pending(&r, "interrupted", 0, 0);
    assert_int_equal(number(&r, "bu.periodic_lost"), 248);
    free(a);
    wire_close(&r.w);
}

static void pco_steps(void **state)
{
    static const struct {
        uint8_t from, to;
        unsigned long jumps;
    } rows[] = {{0, 1, 0}, {255, 0, 0}, {7, 7, 0}, {7, 9, 1}, {7, 6, 1}, {0, 255, 1}, {1, 0, 1}, {0, 128, 1}};
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        rig_t r = {.device = nodes[i % 2]};
        wire_open_one(&r.w, r.device);
        r.out[PCO] = rows[i].from; /* the start value of the controller is no step */
        to_op(&r);
        cycle(&r);
        r.out[PCO] = rows[i].to;
        cycle(&r);
        cycle(&r);
        if (number(&r, "bu.pco_jumps") != rows[i].jumps)
            fail_msg("PCO from %u to %u: expected %lu in bu.pco_jumps, got %lu", rows[i].from, rows[i].to,
                     rows[i].jumps, number(&r, "bu.pco_jumps"));
        wire_close(&r.w);
    }
}

/* --- PAI and the rest --------------------------------------------------------------------------------------------- */

static void expect_pai(rig_t *r, uint8_t want)
{
    pause_ms(r, UPDATE_MS);
    if (r->in[PAI] != want || number(r, "bu.pai") != want)
        fail_msg("expected PAI %u, got %u, bu.pai %lu", want, r->in[PAI], number(r, "bu.pai"));
}

static void pai_follows_pco(void **state)
{
    (void)state;
    for (size_t n = 0; n < COUNT(nodes); n++) {
        rig_t r;
        uint8_t *a = new_set(1);
        start(&r, nodes[n]);
        expect_pai(&r, 0);
        for (unsigned int i = 1; i <= 260; i++) {
            give_block(&r, a, i % 3 == 0 ? 0 : 600, i % 3);
            assert_int_equal(number(&r, "bu.pai"), (uint8_t)i);
            expect_pai(&r, (uint8_t)i);
        }
        give_block(&r, a, 51201, 0); /* processed: refused */
        expect_pai(&r, (uint8_t)261);
        give_block(&r, a, 400, 1); /* processed: of a set without its block 0 */
        expect_pai(&r, (uint8_t)262);
        free(a);
        wire_close(&r.w);
    }
}

static void pao_and_spares_do_not_matter(void **state)
{
    (void)state;
    rig_t r;
    uint8_t *a = new_set(1);
    start(&r, nodes[0]);
    r.out[PAO] = 0xFF;
    r.out[SPARE] = 0xFF;
    memset(r.out + 22, 0xFF, 2);
    give_block(&r, a, 300, 0);
    r.out[PAO] = 0x55;
    give_block(&r, a, 300, 1);
    r.sets++;
    expect_set(&r, "PAO and the spare bytes are not 0", a, 300);
    free(a);
    wire_close(&r.w);
}

/* A board without memory for sets counts them and keeps no content. */
static void without_a_buffer(void **state)
{
    (void)state;
    ect_device_t small = ect_eclink_map7;
    ect_twin_config_t twin = ect_twin_default(&small, &ect_eclink_plant);
    rig_t r = {.device = &small};
    uint8_t *a = new_set(1);
    small.buffer_size = 0;
    wire_open_twins(&r.w, &twin, 1);
    to_op(&r);
    for (unsigned int n = 0; n < 3; n++)
        give_block(&r, a, 600, n);
    assert_int_equal(number(&r, "bu.periodic_sets"), 1);
    assert_int_equal(number(&r, "bu.periodic_size"), 600);
    assert_int_equal(number(&r, "bu.periodic_check"), 0);
    assert_null(ect_chain_bulk(r.w.chain, 0).data);
    free(a);
    wire_close(&r.w);
}

static void mode_without_periodic_data(void **state)
{
    (void)state;
    rig_t r = {.device = &ect_eclink_map3};
    wire_open_one(&r.w, r.device);
    wire_go(&r.w, 0, ECT_STATE_OP);
    for (unsigned int n = 0; n < 50; n++) {
        memset(r.out, 0, 24);
        r.out[PCO] = (uint8_t)n;
        wire_advance(&r.w, 10 * MS);
        assert_int_equal(wire_write(&r.w, 0, OUTPUTS_AT, r.out, 24), 1);
    }
    expect_set(&r, "Input + Commands", NULL, 0);
    wire_close(&r.w);
}

static void shown_by_the_remotes_that_are_on(void **state)
{
    (void)state;
    rig_t r;
    uint8_t *a = new_set(1);
    start(&r, nodes[1]);
    set(&r, "ru1.on", "1");
    set(&r, "ru2.on", "1");
    give_block(&r, a, 0, 0);
    set(&r, "ru2.armed", "1");
    for (unsigned int n = 0; n < 5; n++) {
        give_block(&r, a, 400, 0);
        pause_ms(&r, 2 * UPDATE_MS);
        assert_int_equal(number(&r, "ru1.periodic_count"), n);
        give_block(&r, a, 400, 1);
        pause_ms(&r, 2 * UPDATE_MS);
        assert_int_equal(number(&r, "ru1.periodic_count"), n + 1);
        assert_int_equal(number(&r, "ru2.periodic_count"), n + 1);
        assert_int_equal(number(&r, "ru3.periodic_count"), 0);
    }
    set(&r, "ru3.on", "1");
    pause_ms(&r, 2 * UPDATE_MS);
    assert_int_equal(number(&r, "ru3.periodic_count"), 0);
    free(a);
    wire_close(&r.w);
}

#define TEST(title, function) {title, function, NULL, NULL, NULL}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        TEST("the CRC-32 of these tests has its published check value", oracle),
        TEST("ECL-054 ECL-059: sets of 1 to 51200 bytes are shown after their last block", sizes),
        TEST("ECL-054: size 0 is neither a set nor an error", size_zero),
        TEST("ECL-059: after block 0 the others may be sent in any order", any_order),
        TEST("ECL-054 ECL-059: block 0 always begins a set; no block counts before it; incomplete sets are counted "
             "with their missing blocks",
             block_0_begins_a_set),
        TEST("ECL-049 ECL-059: only PCO makes a block count", without_pco_nothing),
        TEST("ECL-059: a repeated block counts once, and its newer bytes apply", repeated_blocks),
        TEST("ECL-054 ECL-059: another size in the middle begins another set", size_changes_in_the_middle),
        TEST("ECL-054 ECL-059: after another size in between the first set starts again", size_changes_and_returns),
        TEST("ECL-054 ECL-059: sizes above 51200 and blocks beyond the size are counted as errors and ignored",
             impossible_blocks),
        TEST("ECL-054 ECL-059: a block of another size ends the set in transfer", block_of_another_size),
        TEST("ECL-054 ECL-059: signals show the size of the set that is being assembled and its missing blocks",
             missing_blocks),
        TEST("ECL-059: the old set is kept until the new one is complete", hand_over_is_atomic),
        TEST("ECL-059: an interrupted exchange never completes a set with blocks from before it", interrupted_exchange),
        TEST("ECL-059: when the last block of a set is lost, the next set is shown whole", lost_last_block),
        TEST("ECL-024 ECL-059: the first outputs are used if they contain block 0, else the next set is the first",
             first_outputs),
        TEST("ECL-049: steps of PCO other than +1 are counted", pco_steps),
        TEST("ECL-024: PAI follows PCO with the next update, also from 255 to 0", pai_follows_pco),
        TEST("ECL-052 ECL-053: PAO and the spare bytes have no effect", pao_and_spares_do_not_matter),
        TEST("ECL-059: without memory for sets they are still counted", without_a_buffer),
        TEST("ECL-055: Input + Commands has no periodic data", mode_without_periodic_data),
        TEST("ECL-062: a complete set is shown once by each remote that is on, armed or not",
             shown_by_the_remotes_that_are_on),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("EC-Link periodic data", tests, NULL, NULL);
}
