/* SPDX-License-Identifier: MIT */
/*
 * SyncManagers under every interleaving of their two sides: no torn or outdated image, no mail lost or read twice.
 *
 * Each side goes through its buffer in pieces, in order, again and again. A step is one access of one side; the tests
 * execute all orders of a number of steps, and long random ones, in which a side may also restart half way. For a
 * replay, the order is printed as w and r (W and R: restart).
 */
#include <stdlib.h>
#include <string.h>

#include "support/chip.h"

enum { LENGTH = 12, START = 0x1000, ORDER = 64 };

typedef struct sides {
    chip_t *c;
    bool mailbox;
    bool master_writes;
    unsigned int pieces[2]; /* of the writer, of the reader: 1, 2, 3, 4 */
    unsigned int at[2];     /* index of the next piece */
    bool accepted[2];       /* no access of this pass was refused */
    uint8_t writing;        /* the number that fills this image */
    uint8_t written;        /* number of the last complete image; 0: none */
    uint8_t wanted;         /* number of the last image when the reader started */
    uint8_t last_read;
    uint8_t image[LENGTH];
    char order[ORDER];
    size_t steps;
} sides_t;

static void fail_at(const sides_t *s, const char *what, unsigned int want, unsigned int got)
{
    fail_msg("%s, the master %s, %u and %u pieces, order %.*s%s: %s: expected %u, got %u",
             s->mailbox ? "mailbox" : "3 buffers", s->master_writes ? "writes" : "reads", s->pieces[0], s->pieces[1],
             (int)(s->steps < ORDER ? s->steps : ORDER), s->order, s->steps < ORDER ? "" : "…", what, want, got);
}

/* One access, by the side of its direction. @return whether it was accepted */
static bool access_one(sides_t *s, bool write, uint16_t offset, uint8_t *data, uint16_t length)
{
    ect_esc_t *esc = &s->c->esc;
    bool master = write == s->master_writes;
    if (master)
        return chip_send(s->c, write ? APWR : APRD, (uint16_t)(START + offset), data, length) == 1;
    uint8_t status = s->c->memory[0x0815];
    bool opened = esc->sm[2].open[1];
    if (write)
        (void)ect_esc_pdi_write(esc, (uint16_t)(START + offset), data, length);
    else
        (void)ect_esc_pdi_read(esc, (uint16_t)(START + offset), data, length);
    if (offset != 0) /* the PDI gets no result: the test reads the status and its start */
        return opened;
    if (s->mailbox)
        return write == ((status & 0x08) == 0);
    return write || (status & 0x30) != 0x30;
}

static void complete_write(sides_t *s)
{
    if (s->accepted[0])
        s->written = s->writing;
    s->writing = (uint8_t)(s->writing % 250 + 1);
}

static void complete_read(sides_t *s)
{
    if (!s->accepted[1])
        return;
    for (unsigned int i = 0; i < LENGTH; i++) {
        if (s->image[i] != s->image[0])
            fail_at(s, "a torn image: its bytes are of", s->image[0], s->image[i]);
    }
    if (s->image[0] != s->wanted)
        fail_at(s, "a stale image, or one that is not complete", s->wanted, s->image[0]);
    if (s->mailbox && s->image[0] == s->last_read)
        fail_at(s, "a mail is read twice", s->last_read + 1u, s->image[0]);
    s->last_read = s->image[0];
}

static void step(sides_t *s, bool write, bool restart)
{
    unsigned int side = write ? 0 : 1;
    if (s->steps < ORDER)
        s->order[s->steps] = write ? (restart ? 'W' : 'w') : (restart ? 'R' : 'r');
    s->steps++;
    if (restart)
        s->at[side] = 0;
    if (s->at[side] == 0) {
        s->accepted[side] = true;
        if (!write)
            s->wanted = s->written;
    }
    uint16_t size = (uint16_t)(LENGTH / s->pieces[side]);
    uint16_t offset = (uint16_t)(size * s->at[side]);
    uint8_t bytes[LENGTH];
    memset(bytes, write ? s->writing : 0xEE, sizeof bytes);
    bool was_full = s->mailbox && s->last_read != s->written;
    bool taken = access_one(s, write, offset, bytes, size);
    bool must = s->mailbox ? was_full != write : write || s->written != 0;
    if (offset == 0 && taken != must)
        fail_at(s, write ? "a write is taken" : "a read is taken", must, taken);
    s->accepted[side] &= taken;
    if (!write)
        memcpy(s->image + offset, bytes, size);
    s->at[side] = (s->at[side] + 1) % s->pieces[side];
    if (s->at[side] != 0)
        return;
    if (write)
        complete_write(s);
    else
        complete_read(s);
}

static void begin(sides_t *s, chip_t *c, bool mailbox, bool master_writes, unsigned int writer, unsigned int reader)
{
    *s =
        (sides_t){.c = c, .mailbox = mailbox, .master_writes = master_writes, .pieces = {writer, reader}, .writing = 1};
    uint8_t control = (uint8_t)((mailbox ? 0x02 : 0x00) | (master_writes ? 0x04 : 0x00) | 0x30);
    chip_set_sm(c, 2, START, LENGTH, control, 1);
}

/* Every order of so many steps: depth first, with chip and both sides restored on the way up. */
static void every_order(sides_t *s, unsigned int writes, unsigned int reads)
{
    enum { USED = 0x1000 + 3 * LENGTH };
    for (unsigned int write = 0; write < 2; write++) {
        if ((write == 1 ? writes : reads) == 0)
            continue;
        sides_t sides = *s;
        ect_esc_t esc = s->c->esc;
        uint8_t memory[USED];
        memcpy(memory, s->c->memory, USED);
        step(s, write == 1, false);
        every_order(s, writes - write, reads - (1 - write));
        memcpy(s->c->memory, memory, USED);
        s->c->esc = esc;
        *s = sides;
    }
}

static void exhaustive(void **state)
{
    /* Pieces, and steps of either side. */
    static const unsigned int rows[][4] = {{1, 1, 6, 6}, {2, 2, 6, 6}, {1, 2, 4, 6}, {2, 1, 6, 4},
                                           {3, 2, 6, 6}, {2, 3, 6, 6}, {4, 1, 8, 3}, {1, 4, 3, 8}};
    chip_t *c = *state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        for (unsigned int mode = 0; mode < 4; mode++) {
            sides_t s;
            begin(&s, c, mode % 2 == 1, mode / 2 == 1, rows[i][0], rows[i][1]);
            every_order(&s, rows[i][2], rows[i][3]);
        }
    }
}

static uint32_t next_random(uint32_t *seed)
{
    *seed = *seed * 1664525u + 1013904223u;
    return *seed >> 8;
}

/* In a mailbox, a side that restarts half way starts the same mail again. */
static void random_orders(void **state)
{
    static const unsigned int pieces[] = {1, 2, 3, 4, 6, 12};
    chip_t *c = *state;
    uint32_t seed = 20;
    for (unsigned int run = 0; run < 400; run++) {
        sides_t s;
        begin(&s, c, run % 2 == 1, run % 4 >= 2, pieces[next_random(&seed) % 6], pieces[next_random(&seed) % 6]);
        unsigned int bias = 1 + next_random(&seed) % 15;
        for (unsigned int i = 0; i < 300; i++)
            step(&s, next_random(&seed) % 16 < bias, next_random(&seed) % 16 == 0);
    }
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"CF-016 CF-017 CF-019: no torn, stale or lost image in any order of the accesses of both sides", exhaustive,
         chip_setup, chip_teardown, NULL},
        {"CF-018 CF-019: nor in long random orders, in which sides restart half way", random_orders, chip_setup,
         chip_teardown, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("SyncManagers, both sides", tests, NULL, NULL);
}
