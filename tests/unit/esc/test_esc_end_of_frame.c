/* SPDX-License-Identifier: MIT */
/* Effects of a frame that wait for its end (data sheet I §3, §14.1): registers, SyncManagers, clocks; RAM does not. */
#include <stdlib.h>
#include <string.h>

#include "esc/route.h"
#include "support/chip.h"

enum { DATA = 10, MAILBOX_OUT = 0x1000, BUFFERED = 0x1400, SIZE = 16 };

/* One mailbox and one of three buffers, both written by the master. */
static void configure(chip_t *c)
{
    chip_power_on(c);
    chip_set_sm(c, 0, MAILBOX_OUT, SIZE, 0x26, 1);
    chip_set_sm(c, 1, BUFFERED, SIZE, 0x24, 1);
    (void)chip_pdi_read(c, 0x0806, 1);
    (void)chip_pdi_read(c, 0x080E, 1);
}

/* A write, then a read in the same frame, then a read in the next one. */
static void takes_effect_later(void **state)
{
    static const struct {
        const char *what;
        uint16_t written;
        const char *value;
        uint16_t length, read, mask;
        uint16_t in_frame, after;
    } rows[] = {
        {"station address", 0x0010, "\x34\x12", 2, 0x0010, 0xFFFF, 0, 0x1234},
        {"protection", 0x0021, "\1", 1, 0x0021, 0x00FF, 0, 1},
        {"reset sequence", 0x0040, "R", 1, 0x0040, 0x00FF, 0, 1},
        {"DL control", 0x0101, "\x0C", 1, 0x0101, 0x00FF, 0, 0x0C},
        {"DL control: its loop in DL status", 0x0101, "\x0C", 1, 0x0110, 0x0C00, 0x0800, 0x0C00},
        {"offset of writes", 0x0108, "\2", 1, 0x0108, 0xFFFF, 0, 2},
        {"AL control", 0x0120, "\2", 1, 0x0120, 0xFFFF, 1, 2},
        {"AL control: its event", 0x0120, "\2", 1, 0x0220, 0x0001, 0, 1},
        {"ECAT event mask", 0x0200, "\4", 1, 0x0200, 0xFFFF, 0, 4},
        {"watchdog time", 0x0420, "\7", 1, 0x0420, 0x00FF, 0xE8, 7},
        {"EEPROM: owner", 0x0500, "\1", 1, 0x0500, 0x00FF, 0, 1},
        {"EEPROM: address", 0x0504, "\x22", 1, 0x0504, 0x00FF, 0, 0x22},
        {"EEPROM: a command that is invalid", 0x0502, "\0\3", 2, 0x0502, 0x2000, 0, 0x2000},
        {"FMMU", 0x0600, "\x55", 1, 0x0600, 0x00FF, 0, 0x55},
        {"SyncManager: start", 0x0810, "\x00\x18", 2, 0x0810, 0xFFFF, 0, 0x1800},
        {"SyncManager: activation", 0x0806, "\0", 1, 0x0806, 0x0001, 1, 0},
        {"SyncManager: event of its change", 0x0806, "\0", 1, 0x0220, 0x0010, 0, 0x10},
        {"a mail: its SyncManager is full", MAILBOX_OUT, "0123456789abcdef", SIZE, 0x0805, 0x0008, 0, 8},
        {"a mail: its event", MAILBOX_OUT, "0123456789abcdef", SIZE, 0x0220, 0x0100, 0, 0x100},
        {"outputs: last written buffer", BUFFERED, "0123456789abcdef", SIZE, 0x080D, 0x0030, 0x30, 0},
        {"outputs: watchdog", BUFFERED, "0123456789abcdef", SIZE, 0x0440, 0x0001, 0, 0},
        {"DC: speed counter start", 0x0930, "\0\x20", 2, 0x0930, 0xFFFF, 0x1000, 0x2000},
        {"DC: activation", 0x0981, "\1", 1, 0x0981, 0x00FF, 0, 1},
        {"DC: SYNC0 cycle", 0x09A0, "\x11\x22", 2, 0x09A0, 0xFFFF, 0, 0x2211},
        {"latch control", 0x09A8, "\1", 1, 0x09A8, 0x00FF, 0, 1},
        {"digital outputs", 0x0F00, "\x77", 1, 0x0F00, 0x00FF, 0, 0x77},
        {"user RAM, at once", 0x0F80, "\x77", 1, 0x0F80, 0x00FF, 0x77, 0x77},
        {"process RAM, at once", 0x1800, "\x77", 1, 0x1800, 0x00FF, 0x77, 0x77},
    };
    chip_t *c = *state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        configure(c);
        memset(c->memory + 0x0F80, 0, 4);
        memset(c->memory + 0x1800, 0, 4);
        wire_build(&c->w, APWR, 0, rows[i].written, rows[i].value, rows[i].length);
        wire_append(&c->w, APRD, 0, rows[i].read, "\0\0", 2);
        chip_transmit(c);
        unsigned int in_frame = ect_load_le16(wire_datagram(&c->w, 1) + DATA) & rows[i].mask;
        unsigned int after = (unsigned int)chip_read(c, rows[i].read, 2) & rows[i].mask;
        if (wire_wkc(&c->w, 0) != 1 || in_frame != rows[i].in_frame || after != rows[i].after)
            fail_msg("%s: expected 0x%X in the frame, 0x%X after it, got 0x%X, 0x%X", rows[i].what, rows[i].in_frame,
                     rows[i].after, in_frame, after);
    }
}

/* The working counter follows the state when the datagram passes, the effect the order of the datagrams. */
static void order(void **state)
{
    static const struct {
        const char *what;
        uint16_t address;
        const char *first, *second;
        uint16_t length, want, mask;
    } rows[] = {
        {"two station addresses", 0x0010, "\1\0", "\2\0", 2, 2, 0xFFFF},
        {"two states", 0x0120, "\4", "\2", 1, 2, 0x00FF},
        {"EEPROM to the PDI and back", 0x0500, "\1", "\0", 1, 0, 0x0001},
        {"EEPROM: an invalid command, then none", 0x0502, "\0\3", "\0\0", 2, 0, 0x2000},
        {"a SyncManager off and on", 0x0806, "\0", "\1", 1, 1, 0x0001},
        {"a mail and a SyncManager off", 0x0806, "\1", "\0", 1, 0, 0x0001},
    };
    chip_t *c = *state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        configure(c);
        wire_build(&c->w, APWR, 0, rows[i].address, rows[i].first, rows[i].length);
        wire_append(&c->w, APWR, 0, rows[i].address, rows[i].second, rows[i].length);
        chip_transmit(c);
        unsigned int got = (unsigned int)chip_read(c, rows[i].address, 2) & rows[i].mask;
        if (wire_wkc(&c->w, 0) != 1 || wire_wkc(&c->w, 1) != 1 || got != rows[i].want)
            fail_msg("%s: expected 0x%X, got 0x%X", rows[i].what, rows[i].want, got);
    }
}

/* The mail was accepted by the state of the SyncManager when the datagram passed. Another write may follow: the buffers
 * that the frame has left so far change hands before it. */
static void mail_and_restart(void **state)
{
    chip_t *c = *state;
    for (unsigned int row = 0; row < 4; row++) {
        const bool mail_first = row % 2 != 0, write_last = row / 2 != 0;
        configure(c);
        if (mail_first)
            wire_build(&c->w, APWR, 0, MAILBOX_OUT, "0123456789abcdef", SIZE);
        else
            wire_build(&c->w, NOP, 0, 0, "", 1);
        wire_append(&c->w, APWR, 0, 0x0806, "\0", 1);
        wire_append(&c->w, APWR, 0, 0x0806, "\1", 1);
        if (!mail_first)
            wire_append(&c->w, APWR, 0, MAILBOX_OUT, "0123456789abcdef", SIZE);
        if (write_last)
            wire_append(&c->w, APWR, 0, 0x0010, "\1\0", 2);
        chip_transmit(c);
        assert_int_equal(wire_wkc(&c->w, mail_first ? 0 : 3), 1);
        if ((chip_read(c, 0x0805, 1) & 0x08) != 0)
            fail_msg("mail first %d, a write last %d: expected an empty mailbox", mail_first, write_last);
    }
}

/* A mailbox that the frame has filled accepts no second mail; outputs are overwritten. */
static void twice_in_a_frame(void **state)
{
    static const struct {
        uint16_t address, wkc;
        const char *want;
    } rows[] = {{MAILBOX_OUT, 0, "0123456789abcdef"}, {BUFFERED, 1, "ABCDEFGHIJKLMNOP"}};
    chip_t *c = *state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t got[SIZE];
        configure(c);
        wire_build(&c->w, APWR, 0, rows[i].address, "0123456789abcdef", SIZE);
        wire_append(&c->w, APWR, 0, rows[i].address, "ABCDEFGHIJKLMNOP", SIZE);
        chip_transmit(c);
        assert_int_equal(wire_wkc(&c->w, 0), 1);
        assert_int_equal(wire_wkc(&c->w, 1), rows[i].wkc);
        ect_esc_pdi_read(&c->esc, rows[i].address, got, SIZE);
        assert_memory_equal(got, rows[i].want, SIZE);
    }
}

/* The start of a second write revokes the first one: the slave never reads a part of each. */
static void begun_again(void **state)
{
    chip_t *c = *state;
    uint8_t got[SIZE];
    configure(c);
    wire_build(&c->w, APWR, 0, BUFFERED, "0123456789abcdef", SIZE);
    wire_append(&c->w, APWR, 0, BUFFERED, "ABCD", 4);
    chip_transmit(c);
    assert_int_equal(chip_read(c, 0x080D, 1) & 0x30, 0x30);
    assert_int_equal(chip_send(c, APWR, BUFFERED + 4, memcpy(got, "EFGHIJKLMNOP", 12), 12), 1);
    ect_esc_pdi_read(&c->esc, BUFFERED, got, SIZE);
    assert_memory_equal(got, "ABCDEFGHIJKLMNOP", SIZE);
}

/* Outputs are written in three datagrams at most, with register writes that latch the time at which the buffer changes:
 * a datagram of 0 bytes is omitted. They are released at their last completion. */
static void completed_among_writes(void **state)
{
    static const struct {
        const char *what;
        uint16_t before;           /* bytes of the outputs that are written before everything else */
        bool writes_first;         /* then a register write without an effect on them */
        uint16_t begun, completed; /* bytes before and after the write that lets the time be latched */
        bool latched;
    } rows[] = {
        {"complete before the write", SIZE, false, 0, 0, false},
        {"complete after the write", 0, false, 0, SIZE, true},
        {"begun before the write, completed after it", 0, false, 4, SIZE - 4, true},
        {"complete, begun again, the write, completed", SIZE, false, 4, SIZE - 4, true},
        {"complete, another write, begun again, the write, completed", SIZE, true, 4, SIZE - 4, true},
        {"complete, another write, complete again, the write", SIZE, true, SIZE, 0, false},
    };
    static const uint8_t outputs[SIZE] = "ABCDEFGHIJKLMNO";
    static const uint8_t latches = ECT_SM_ACTIVATE_ENABLE | ECT_SM_ACTIVATE_LATCH_ECAT;
    chip_t *c = *state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t got[SIZE];
        configure(c);
        c->w.now_ns += 1 * MS;
        wire_build(&c->w, NOP, 0, 0, "", 1);
        if (rows[i].before > 0)
            wire_append(&c->w, APWR, 0, BUFFERED, "0123456789abcdef", rows[i].before);
        if (rows[i].writes_first)
            wire_append(&c->w, APWR, 0, 0x0010, "\1\0", 2);
        if (rows[i].begun > 0)
            wire_append(&c->w, APWR, 0, BUFFERED, outputs, rows[i].begun);
        wire_append(&c->w, APWR, 0, 0x0808 + ECT_SM_ACTIVATE, &latches, 1);
        if (rows[i].completed > 0)
            wire_append(&c->w, APWR, 0, (uint16_t)(BUFFERED + rows[i].begun), outputs + rows[i].begun,
                        rows[i].completed);
        chip_transmit(c);
        bool latched = ect_load_le32(c->memory + ECT_REG_DC_SM_TIME_ECAT) != 0;
        if (latched != rows[i].latched)
            fail_msg("%s: expected %d, got %d", rows[i].what, rows[i].latched, latched);
        assert_int_equal(ect_esc_pdi_read(&c->esc, BUFFERED, got, SIZE), 0);
        assert_memory_equal(got, rows[i].begun + rows[i].completed > 0 ? outputs : (const uint8_t *)"0123456789abcdef",
                            SIZE);
    }
}

/* A chip may end a frame late. The PDI reads the previous outputs meanwhile; its access neither loses nor advances the
 * new ones. */
static void pdi_before_the_end(void **state)
{
    static const struct {
        const char *what;
        uint16_t read; /* bytes that the PDI reads between the pass and the end of the frame */
    } rows[] = {{"no access", 0}, {"a begun access", 4}, {"a complete access", SIZE}};
    chip_t *c = *state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t got[SIZE] = "0123456789abcde", data[SIZE] = "0123456789abcde";
        configure(c);
        assert_int_equal(chip_send(c, APWR, BUFFERED, data, SIZE), 1);
        wire_build(&c->w, APWR, 0, BUFFERED, "ABCDEFGHIJKLMNOP", SIZE);
        assert_int_equal(ect_esc_pass(&c->esc, c->w.frame, c->w.frame_length, c->w.now_ns), ECT_FRAME_FORWARD);
        if (rows[i].read > 0)
            assert_int_equal(ect_esc_pdi_read(&c->esc, BUFFERED, got, rows[i].read), 0);
        assert_memory_equal(got, data, SIZE);
        ect_esc_end_of_frame(&c->esc);
        if (rows[i].read > 0 && rows[i].read < SIZE) {
            assert_int_equal(ect_esc_pdi_read(&c->esc, (uint16_t)(BUFFERED + rows[i].read), got + rows[i].read,
                                              (uint16_t)(SIZE - rows[i].read)),
                             0);
            assert_memory_equal(got, data, SIZE);
        }
        if ((chip_pdi_read(c, 0x0220, 4) & 0x200) == 0)
            fail_msg("%s: there is no event", rows[i].what);
        assert_int_equal(ect_esc_pdi_read(&c->esc, BUFFERED, got, SIZE), 0);
        assert_memory_equal(got, "ABCDEFGHIJKLMNOP", SIZE);
    }
}

/* The new FMMU maps the next frame. */
static void fmmu_and_access(void **state)
{
    static const uint8_t fmmu[16] = {0, 1, 0, 0, 1, 0, 0, 7, 0x80, 0x0F, 0, 1, 1};
    chip_t *c = *state;
    uint8_t data = 0;
    configure(c);
    c->memory[0x0F80] = 0x5A;
    wire_build(&c->w, APWR, 0, 0x0600, fmmu, sizeof fmmu);
    wire_append(&c->w, LRD, 0x0100, 0, "\0", 1);
    chip_transmit(c);
    assert_int_equal(wire_wkc(&c->w, 1), 0);
    wire_build(&c->w, LRD, 0x0100, 0, &data, 1);
    chip_transmit(c);
    assert_int_equal(wire_wkc(&c->w, 0), 1);
    assert_int_equal(wire_datagram(&c->w, 0)[DATA], 0x5A);
}

/* An FMMU for bits may write registers: unmapped bits keep their value at the end, not at the datagram. */
static void bits_through_fmmus(void **state)
{
    static const uint8_t low[16] = {0, 1, 0, 0, 1, 0, 0, 3, 0x04, 0x09, 0, 2, 1};  /* bits 0..3 of 0x0904: read-only */
    static const uint8_t high[16] = {0, 1, 0, 0, 1, 0, 4, 7, 0x08, 0x01, 4, 2, 1}; /* bits 4..7 of 0x0108 */
    chip_t *c = *state;
    configure(c);
    assert_int_equal(chip_write(c, 0x0108, 0x11, 1), 1);
    wire_build(&c->w, APWR, 0, 0x0600, low, sizeof low);
    wire_append(&c->w, APWR, 0, 0x0610, high, sizeof high);
    chip_transmit(c);
    wire_build(&c->w, APWR, 0, 0x0108, "\x02", 1);
    wire_append(&c->w, LWR, 0x0100, 0, "\xAB", 1);
    chip_transmit(c);
    assert_int_equal(wire_wkc(&c->w, 1), 1);
    assert_int_equal(chip_read(c, 0x0108, 1), 0xA2);
}

/* More postponed writes than a frame of physical addresses can contain: each FMMU of eight writes a register with each
 * datagram. The first ones take effect earlier, and none is lost. */
static void many_writes(void **state)
{
    chip_t *c = *state;
    configure(c);
    for (uint8_t n = 0; n < 8; n++) {
        uint8_t fmmu[16] = {n, 1, 0, 0, 1, 0, 0, 6, (uint8_t)(0x10 + n), 0x0F, 0, 2, 1}; /* general outputs */
        uint16_t at = (uint16_t)(0x0600 + 16 * n);
        assert_int_equal(chip_send(c, APWR, at, fmmu, sizeof fmmu), 1);
    }
    wire_build(&c->w, LWR, 0x0100, 0, "\0\0\0\0\0\0\0\0", 8);
    for (uint8_t k = 1; k < 60; k++) {
        uint8_t data[8] = {k, k, k, k, k, k, k, k};
        wire_append(&c->w, LWR, 0x0100, 0, data, sizeof data);
    }
    chip_transmit(c);
    for (unsigned int k = 0; k < 60; k++)
        assert_int_equal(wire_wkc(&c->w, k), 1);
    assert_int_equal(chip_read(c, 0x0F10, 8), 0x3B3B3B3B3B3B3B3B);
}

/* The frame that latches the receive times reads those of the previous frame. */
static void receive_times(void **state)
{
    chip_t *c = *state;
    configure(c);
    assert_int_equal(chip_send(c, BWR, 0x0900, memcpy((uint8_t[4]){0}, "\0", 1), 4), 1);
    uint64_t before = chip_read(c, 0x0900, 4);
    c->w.now_ns += 1 * MS;
    wire_build(&c->w, BWR, 0, 0x0900, "\0\0\0\0", 4);
    wire_append(&c->w, APRD, 0, 0x0900, "\0\0\0\0", 4);
    chip_transmit(c);
    assert_int_equal(ect_load_le32(wire_datagram(&c->w, 1) + DATA), before);
    assert_int_equal(chip_read(c, 0x0900, 4), (uint32_t)(before + 1 * MS));
}

/* Between ect_esc_pass and ect_esc_end_of_frame the frame leaves by the ports that were open at its arrival. */
static void ports_stay(void **state)
{
    chip_t *c = *state;
    configure(c);
    wire_build(&c->w, APWR, 0, 0x0101, "\x0C", 1);
    assert_int_equal(ect_esc_pass(&c->esc, c->w.frame, c->w.frame_length, c->w.now_ns), ECT_FRAME_FORWARD);
    assert_int_equal(ect_esc_next_port(&c->esc, 0), 1);
    ect_esc_end_of_frame(&c->esc);
    assert_int_equal(ect_esc_next_port(&c->esc, 0), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"CF-002: a register is written when the frame has ended; a later datagram reads the value before",
         takes_effect_later, chip_setup, chip_teardown, NULL},
        {"CF-002: the writes of a frame take effect in the order of its datagrams", order, chip_setup, chip_teardown,
         NULL},
        {"CF-016: a SyncManager that a frame restarts is empty, also if the frame has filled it", mail_and_restart,
         chip_setup, chip_teardown, NULL},
        {"CF-016 CF-019: a second mail in a frame is refused, second outputs replace the first", twice_in_a_frame,
         chip_setup, chip_teardown, NULL},
        {"CF-019: outputs that a frame begins again are released when they are complete", begun_again, chip_setup,
         chip_teardown, NULL},
        {"CF-002 CF-019: outputs are released between the register writes, at their last completion",
         completed_among_writes, chip_setup, chip_teardown, NULL},
        {"CF-019: an access of the PDI between a frame and its end reads the previous outputs, and the new ones follow",
         pdi_before_the_end, chip_setup, chip_teardown, NULL},
        {"CF-028: an FMMU maps the frames after the one that wrote it", fmmu_and_access, chip_setup, chip_teardown,
         NULL},
        {"CF-028: bits that an FMMU writes to a register do not change the others at the end of the frame",
         bits_through_fmmus, chip_setup, chip_teardown, NULL},
        {"CF-028: no write is lost if FMMUs multiply the writes", many_writes, chip_setup, chip_teardown, NULL},
        {"CF-083: receive times are read in the frame after the one that latched them", receive_times, chip_setup,
         chip_teardown, NULL},
        {"CF-010: a frame leaves by the ports that were open when it came", ports_stay, chip_setup, chip_teardown,
         NULL},
    };
    return cmocka_run_group_tests_name("end of a frame", tests, NULL, NULL);
}
