/* SPDX-License-Identifier: MIT */
/*
 * The reader of a slave against a slave of any bytes: registers that lead to PREOP, and then EEPROM and mails from the
 * input. The first two bytes select the function of the reader. Each mail of the input: its length in a byte, then its
 * bytes, behind a header that fits; a length of 255 is a mail with a header of its own.
 */
#define _GNU_SOURCE
#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "reader/reader.h"
#include "wire/bytes.h"
#include "wire/registers.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { DATAGRAM = 16, AT_DATA = 26, PREOP = 2, OUT = 0x1000, IN = 0x1080, MAILBOX = 128, MAIL_HEADER = 6, COE = 3 };
enum { SM1_STATUS = ECT_REG_SM + ECT_SM_SIZE + ECT_SM_STATUS };

typedef struct slave {
    const uint8_t *data;
    size_t size;
    uint64_t now_ns;
    uint8_t frame[ECT_READER_FRAME];
    size_t length; /* 0: no frame is on its way */
    uint8_t counter;
    unsigned int mails, due; /* for each request, and left of them */
} slave_t;

static void take(slave_t *s, uint8_t *to, size_t length)
{
    const size_t some = length < s->size ? length : s->size;
    memset(to, 0, length);
    if (some > 0)
        memcpy(to, s->data, some);
    s->data += some;
    s->size -= some;
}

static void take_mail(slave_t *s, uint8_t *mail)
{
    uint8_t length = 0;
    take(s, &length, 1);
    s->counter = (uint8_t)(s->counter % 7 + 1);
    s->due -= s->due > 0;
    if (length == 255) {
        take(s, mail, MAILBOX);
        return;
    }
    length = length <= MAILBOX - MAIL_HEADER ? length : MAILBOX - MAIL_HEADER;
    mail[0] = length;
    mail[5] = (uint8_t)(COE | s->counter << 4);
    take(s, mail + MAIL_HEADER, length);
}

static void send_frame(void *ctx, const uint8_t *frame, size_t length)
{
    static const uint8_t sms[16] = {OUT & 0xFF, OUT >> 8, MAILBOX, 0, 0x26, 0, 1, 0,
                                    IN & 0xFF,  IN >> 8,  MAILBOX, 0, 0x22, 0, 1, 0};
    slave_t *s = ctx;
    const uint16_t address = ect_load_le16(frame + DATAGRAM + 4);
    const uint16_t bytes = ect_load_le16(frame + DATAGRAM + 6);
    uint8_t *to = s->frame + AT_DATA;
    memcpy(s->frame, frame, length);
    s->length = s->size > 0 ? length : 0; /* the input ends: so does the wire */
    ect_store_le16(to + bytes, 1);
    if (address == ECT_REG_AL_STATUS)
        ect_store_le16(to, PREOP);
    else if (address == SM1_STATUS)
        to[0] = s->due > 0 ? ECT_SM_STATUS_FULL : 0;
    else if (address == OUT)
        s->due = s->mails;
    else if (address == ECT_REG_SM)
        memcpy(to, sms, sizeof sms);
    else if (address == ECT_REG_SII_DATA)
        take(s, to, bytes);
    else if (address == IN)
        take_mail(s, to);
}

static size_t receive(void *ctx, uint8_t *frame, size_t room, uint64_t until_ns)
{
    slave_t *s = ctx;
    const size_t length = s->length;
    if (length == 0)
        s->now_ns = until_ns;
    memcpy(frame, s->frame, length < room ? length : room);
    s->length = 0;
    return length;
}

static uint64_t now(void *ctx)
{
    slave_t *s = ctx;
    return s->now_ns += 1000;
}

static void wait_until(void *ctx, uint64_t until_ns)
{
    slave_t *s = ctx;
    s->now_ns = until_ns > s->now_ns ? until_ns : s->now_ns;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static ect_reader_t reader;
    static uint8_t value[1000];
    if (size < 2)
        return 0;
    slave_t s = {.data = data + 2, .size = size - 2, .mails = 1u + (data[0] >> 2 & 3u)};
    const ect_reader_link_t link = {.ctx = &s, .send = send_frame, .receive = receive, .now = now, .wait = wait_until};
    const ect_reader_config_t config = {.frame_ms = 1, .reply_ms = 2, .state_ms = 2, .limit_ms = 1000, .tries = 2};
    size_t length = data[1] * (size_t)4 % sizeof value;
    char *json = NULL;
    size_t json_length = 0;
    if (ect_reader_open(&reader, &link, &config) == ECT_READER_OK) {
        reader.protocols = 0x04;
        const size_t room = length;
        const ect_reader_result_t result = ect_reader_upload(&reader, 0x1018, 1, (data[0] & 2) != 0, value, &length);
        assert(result != ECT_READER_OK || length <= room);
        FILE *file = open_memstream(&json, &json_length);
        assert(file != NULL);
        (void)ect_reader_json(&reader, (data[0] & 1) != 0 ? ECT_READER_ALL_VALUES : ECT_READER_IDENTITY_AND_PDOS, file);
        (void)fclose(file);
        assert(json_length > 2 && json[json_length - 2] == '}');
        free(json);
    }
    ect_reader_close(&reader);
    assert(s.now_ns < UINT64_C(3000000000));
    return 0;
}
