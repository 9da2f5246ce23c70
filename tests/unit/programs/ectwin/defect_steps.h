/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Datagrams on their way through a twin with a defect, as text. A line is a frame of one datagram, in words:
 *
 *     50* FPRD 0130 0200 >0300 a1002 :1400#1 =1500#2 ^1003 i0004    the same frame 50 times: command, address, data
 *     & FPWR 1000 0A00~16                                           one more datagram in the frame of the line before
 *     @0130 02                                                      the twin's memory from 0x0130 on
 *
 *     >DATA   expected in the chip; >- : the chip does not get the datagram     (as sent)
 *     aADP    expected in the chip                                              (as sent)
 *     :DATA#N the chip's reply and working counter                              (the data that it got, and 1)
 *     =DATA#N expected by the master                                            (the chip's; 0 without the datagram)
 *     ^ADP    expected by the master                                            (the chip's)
 *     iIRQ    expected by the master                                            (the chip's)
 *
 * DATA are hexadecimal digits, with points to read them by; ~N adds bytes of 0 up to N. The chip increments ADP where
 * the command asks for it. The twin has its mailbox at 0x1000 and 0x1100 (128 bytes), outputs at 0x1180 (6), inputs
 * at 0x1400 (4), and is in PREOP.
 */
#ifndef TESTS_DEFECT_STEPS_H
#define TESTS_DEFECT_STEPS_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "defects.h"
#include "esc/route.h"
#include "support/hex.h"
#include "support/wire.h"

enum { STEP_STATION = 0x1001, STEP_IRQ = 0x0804, STEP_DATA = 256, STEP_MOST = 16, STEP_LINE = 1024 };

typedef struct step {
    uint8_t command;
    uint16_t ado, length, irq;
    uint16_t adp, chip_adp, reply_adp, got_adp;
    uint8_t sent[STEP_DATA], chip[STEP_DATA], reply[STEP_DATA], got[STEP_DATA];
    uint16_t counter, got_counter;
    bool hidden;
} step_t;

typedef struct step_frame {
    const char *row; /* for messages */
    char line[STEP_LINE];
    step_t steps[STEP_MOST];
    size_t count;
} step_frame_t;

static inline uint8_t step_command(const char *word)
{
    static const char *const names[] = {"NOP", "APRD", "APWR", "APRW", "FPRD", "FPWR", "FPRW", "BRD",
                                        "BWR", "BRW",  "LRD",  "LWR",  "LRW",  "ARMW", "FRMW"};
    for (uint8_t n = 0; n < sizeof names / sizeof names[0]; n++) {
        if (strcmp(word, names[n]) == 0)
            return n;
    }
    return (uint8_t)strtoul(word, NULL, 16);
}

/* @return bytes of DATA, at most STEP_DATA; *counter changes only if the word has one */
static inline uint16_t step_bytes(const char *word, uint8_t *bytes, uint16_t *counter)
{
    char digits[STEP_LINE];
    size_t count = 0;
    const char *end = word + strcspn(word, "~#"), *number = strchr(word, '#');
    for (const char *c = word; c < end; c++) {
        if (*c != '.')
            digits[count++] = *c;
    }
    digits[count] = '\0';
    memset(bytes, 0, STEP_DATA);
    uint16_t length = from_hex(digits, bytes);
    if (*end == '~')
        length = (uint16_t)strtoul(end + 1, NULL, 10);
    if (number && counter)
        *counter = (uint16_t)strtoul(number + 1, NULL, 10);
    assert_true(length <= STEP_DATA);
    return length;
}

static inline uint16_t step_number(const char *word)
{
    return (uint16_t)strtoul(word, NULL, 16);
}

/* One mark of a line, after the data of the request. */
static inline void step_mark(step_t *s, const char *word)
{
    const bool bytes = word[1] != '\0' && word[1] != '#';
    if (strcmp(word, ">-") == 0) {
        s->hidden = true;
        s->counter = s->got_counter = 0;
        s->reply_adp = s->got_adp = s->adp;
    } else if (*word == '>') {
        (void)step_bytes(word + 1, s->chip, NULL);
        memcpy(s->reply, s->chip, STEP_DATA);
        memcpy(s->got, s->chip, STEP_DATA);
    } else if (*word == ':') {
        uint8_t *data = bytes ? s->reply : (uint8_t[STEP_DATA]){0};
        (void)step_bytes(word + 1, data, &s->counter);
        memcpy(s->got, s->reply, STEP_DATA);
        s->got_counter = s->counter;
    } else if (*word == '=') {
        uint8_t *data = bytes ? s->got : (uint8_t[STEP_DATA]){0};
        (void)step_bytes(word + 1, data, &s->got_counter);
    } else if (*word == 'a') {
        s->chip_adp = s->reply_adp = s->got_adp = step_number(word + 1);
    } else if (*word == '^') {
        s->got_adp = step_number(word + 1);
    } else if (*word == 'i') {
        s->irq = step_number(word + 1);
    } else {
        fail_msg("'%s' is no mark", word);
    }
}

/* @return how often the frame is sent */
static inline unsigned long step_parse(step_t *s, char *line)
{
    unsigned long times = 1;
    char *rest = NULL, *word = strtok_r(line, " ", &rest);
    if (strchr(word, '*')) {
        times = strtoul(word, NULL, 10);
        word = strtok_r(NULL, " ", &rest);
    }
    *s = (step_t){.command = step_command(word), .adp = STEP_STATION, .counter = 1, .got_counter = 1, .irq = STEP_IRQ};
    s->ado = step_number(strtok_r(NULL, " ", &rest));
    word = strtok_r(NULL, " ", &rest);
    if (word && strchr("0123456789ABCDEF", *word)) {
        s->length = step_bytes(word, s->sent, NULL);
        word = strtok_r(NULL, " ", &rest);
    }
    const bool counts = s->command == APRD || s->command == APWR || s->command == APRW || s->command == ARMW ||
                        s->command == BRD || s->command == BWR || s->command == BRW;
    s->chip_adp = s->adp;
    s->reply_adp = s->got_adp = (uint16_t)(s->adp + (counts ? 1 : 0));
    memcpy(s->chip, s->sent, STEP_DATA);
    memcpy(s->reply, s->sent, STEP_DATA);
    memcpy(s->got, s->sent, STEP_DATA);
    for (; word; word = strtok_r(NULL, " ", &rest))
        step_mark(s, word);
    return times;
}

static inline void step_expect(const step_frame_t *f, const char *what, unsigned int want, unsigned int got)
{
    if (want != got)
        fail_msg("%s: %s: %s: expected 0x%X, got 0x%X", f->row, f->line, what, want, got);
}

static inline void step_expect_data(const step_frame_t *f, const char *what, const step_t *s, const uint8_t *want,
                                    const uint8_t *got)
{
    for (uint16_t i = 0; i < s->length; i++) {
        if (want[i] != got[i])
            fail_msg("%s: %s: %s, byte %u: expected 0x%02X, got 0x%02X", f->row, f->line, what, i, want[i], got[i]);
    }
}

/* The way of a frame: through the defect, the chip, and the defect again. */
static inline void step_send(const step_frame_t *f, defect_t *d, wire_t *w)
{
    for (size_t n = 0; n < f->count; n++) {
        const step_t *s = &f->steps[n];
        (n == 0 ? wire_build : wire_append)(w, s->command, s->adp, s->ado, s->sent, s->length);
    }
    defect_before(d, w->chain, w->frame, w->frame_length);
    for (unsigned int n = 0; n < f->count; n++) {
        const step_t *s = &f->steps[n];
        uint8_t *datagram = wire_datagram(w, n), *data = datagram + ECT_DATAGRAM_DATA;
        step_expect(f, "command in the chip", s->hidden ? NOP : s->command, datagram[ECT_DATAGRAM_COMMAND]);
        step_expect(f, "ADP in the chip", s->chip_adp, ect_load_le16(datagram + ECT_DATAGRAM_ADP));
        step_expect_data(f, "data in the chip", s, s->chip, data);
        ect_store_le16(datagram + ECT_DATAGRAM_ADP, s->reply_adp);
        ect_store_le16(datagram + ECT_DATAGRAM_IRQ, STEP_IRQ);
        memcpy(data, s->reply, s->length);
        ect_store_le16(data + s->length, s->counter);
    }
    defect_after(d, w->chain, w->frame, w->frame_length);
    for (unsigned int n = 0; n < f->count; n++) {
        const step_t *s = &f->steps[n];
        const uint8_t *datagram = wire_datagram(w, n), *data = datagram + ECT_DATAGRAM_DATA;
        step_expect(f, "command of the reply", s->command, datagram[ECT_DATAGRAM_COMMAND]);
        step_expect(f, "ADP of the reply", s->got_adp, ect_load_le16(datagram + ECT_DATAGRAM_ADP));
        step_expect(f, "ADO of the reply", s->ado, ect_load_le16(datagram + ECT_DATAGRAM_ADO));
        if (!s->hidden)
            step_expect(f, "IRQ", s->irq, ect_load_le16(datagram + ECT_DATAGRAM_IRQ));
        step_expect_data(f, "data of the reply", s, s->got, data);
        step_expect(f, "working counter", s->got_counter, ect_load_le16(data + s->length));
    }
}

/* A twin to which no device is connected, as the head of this file describes it. */
static inline ect_esc_t *step_open(wire_t *w, const ect_device_t *device)
{
    static const uint8_t sms[] = {0x00, 0x10, 0x80, 0, 0x26, 0, 1, 0, 0x00, 0x11, 0x80, 0, 0x22, 0, 1, 0,
                                  0x80, 0x11, 6,    0, 0x24, 0, 1, 0, 0x00, 0x14, 4,    0, 0x20, 0, 1, 0};
    wire_open_one(w, device);
    ect_esc_t *esc = ect_chain_esc(w->chain, 0);
    memcpy(esc->memory + ECT_REG_SM, sms, sizeof sms);
    esc->memory[ECT_REG_AL_STATUS] = 2;
    return esc;
}

/* Runs lines, separated by '\n', against a defect. @param sii  NULL: that of the device */
static inline void step_run(const ect_device_t *device, const char *id, const char *lines, uint8_t *sii, size_t size)
{
    defect_t defect = {0};
    wire_t w = {0};
    char line[STEP_LINE];
    ect_esc_t *esc = step_open(&w, device);
    const ect_esc_config_t config = esc->config;
    if (sii) {
        esc->config.sii = sii;
        esc->config.sii_size = (uint32_t)size;
    }
    assert_true(defect_choose(&defect, id));
    step_frame_t f = {.row = id};
    unsigned long times = 0;
    for (const char *at = lines; at; at = strchr(at, '\n') ? strchr(at, '\n') + 1 : NULL) {
        const size_t length = strcspn(at, "\n");
        assert_in_range(length, 1, sizeof line - 1);
        memcpy(line, at, length);
        line[length] = '\0';
        if (*line == '@') {
            uint8_t bytes[STEP_DATA];
            const uint16_t count = step_bytes(strchr(line, ' ') + 1, bytes, NULL);
            memcpy(esc->memory + step_number(line + 1), bytes, count);
            continue;
        }
        const bool more = *line == '&';
        snprintf(f.line, sizeof f.line, "%s", line);
        f.count = more ? f.count : 0;
        assert_true(f.count < STEP_MOST);
        const unsigned long one = step_parse(&f.steps[f.count++], more ? line + 2 : line);
        times = more ? times : one;
        if (at[length] == '\n' && at[length + 1] == '&')
            continue;
        for (unsigned long i = 0; i < times; i++)
            step_send(&f, &defect, &w);
    }
    esc->config = config;
    wire_close(&w);
}

#endif
