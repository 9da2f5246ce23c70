/* SPDX-License-Identifier: MIT */
#include "support/liar.h"

#include <string.h>

#include "seams/device.h"

enum { ETHERNET = 14, HEADER = 2, DATAGRAM = 10, AT_DATA = ETHERNET + HEADER + DATAGRAM, COE = 3 };
enum { SM1_STATUS = ECT_REG_SM + ECT_SM_SIZE + ECT_SM_STATUS };

static uint64_t now(void *ctx)
{
    const liar_t *l = ctx;
    return l->w.now_ns;
}

static void wait_until(void *ctx, uint64_t until_ns)
{
    liar_t *l = ctx;
    if (until_ns > l->w.now_ns)
        wire_advance(&l->w, until_ns - l->w.now_ns);
}

static bool is_mail_to_slave(const liar_t *l, const uint8_t *frame, uint16_t ado)
{
    return frame[ETHERNET + HEADER] == APWR && ado == l->out_start;
}

/* @return whether the frame goes to the slave */
static bool take_request(liar_t *l, const uint8_t *data)
{
    l->mails++;
    l->has_mail = false;
    if (l->kind == NULL || l->kind->request == NULL)
        return true;
    const liar_mail_t what = l->kind->request(l, data);
    l->has_mail = what == LIAR_REPLIES;
    return what == LIAR_PASSES;
}

/* Registers and mailbox as the liar has them. */
static void put_mail(liar_t *l, uint16_t ado, uint8_t *data, uint16_t length, uint8_t *wkc)
{
    if (!l->has_mail)
        return;
    if (ado == SM1_STATUS)
        data[0] |= ECT_SM_STATUS_FULL;
    if (ado != l->in_start)
        return;
    memset(data, 0, length);
    memcpy(data, l->mail, l->mail_length < length ? l->mail_length : length);
    ect_store_le16(wkc, 1);
    l->fetched++;
    l->has_mail = l->kind->next != NULL && l->kind->next(l);
}

static void send_frame(void *ctx, const uint8_t *frame, size_t length)
{
    liar_t *l = ctx;
    const uint16_t ado = ect_load_le16(frame + ETHERNET + HEADER + 4);
    const uint16_t bytes = ect_load_le16(frame + ETHERNET + HEADER + 6) & 0x7FF;
    assert_true(length <= sizeof l->w.frame && AT_DATA + bytes + 2u <= length);
    l->frames++;
    l->w.now_ns += FRAME_NS;
    memcpy(l->w.frame, frame, length);
    l->w.frame_length = length;
    bool comes = true;
    if (is_mail_to_slave(l, frame, ado) && !take_request(l, frame + AT_DATA))
        ect_store_le16(l->w.frame + AT_DATA + bytes, 1);
    else
        comes = wire_transmit(&l->w);
    uint8_t *data = l->w.frame + AT_DATA;
    uint8_t *wkc = data + bytes;
    put_mail(l, ado, data, bytes, wkc);
    if (l->kind != NULL && l->kind->reply != NULL && ado == l->in_start && frame[ETHERNET + HEADER] == APRD &&
        ect_load_le16(wkc) == 1)
        l->kind->reply(l, data);
    if (comes && l->kind != NULL && l->kind->datagram != NULL)
        comes = l->kind->datagram(l, l->w.frame + ETHERNET + HEADER, ado, data, bytes, wkc);
    l->reply_length = comes ? l->w.frame_length : 0;
    memcpy(l->reply, l->w.frame, l->reply_length);
}

static size_t receive(void *ctx, uint8_t *frame, size_t room, uint64_t until_ns)
{
    liar_t *l = ctx;
    const size_t length = l->reply_length;
    l->reply_length = 0;
    if (length == 0)
        wait_until(l, until_ns);
    memcpy(frame, l->reply, length < room ? length : room);
    return length;
}

void liar_attach(liar_t *l, const liar_kind_t *kind)
{
    const ect_device_t *device = wire_device(&l->w, 0);
    l->kind = kind;
    l->link = (ect_reader_link_t){.ctx = l, .send = send_frame, .receive = receive, .now = now, .wait = wait_until};
    for (unsigned int i = 0; i < device->sm_count; i++) {
        if (device->sm[i].type == ECT_SM_MAILBOX_OUT)
            l->out_start = device->sm[i].start;
        if (device->sm[i].type == ECT_SM_MAILBOX_IN) {
            l->in_start = device->sm[i].start;
            l->in_size = device->sm[i].length;
        }
    }
}

void liar_open(liar_t *l, const ect_device_t *device, const liar_kind_t *kind)
{
    memset(l, 0, sizeof *l);
    wire_open_one(&l->w, device);
    liar_attach(l, kind);
}

void liar_close(liar_t *l)
{
    wire_close(&l->w);
}

void liar_set_mail(liar_t *l, uint8_t type, const void *data, size_t length)
{
    assert_true(length + 6 <= sizeof l->mail);
    l->counter = (uint8_t)(l->counter % 7 + 1);
    memset(l->mail, 0, sizeof l->mail);
    ect_store_le16(l->mail, (uint16_t)length);
    l->mail[5] = (uint8_t)(type | l->counter << 4);
    memcpy(l->mail + 6, data, length);
    l->mail_length = (uint16_t)(length + 6);
}

void liar_set_coe_mail(liar_t *l, uint8_t service, const void *data, size_t length)
{
    uint8_t message[1500] = {0, (uint8_t)(service << 4)};
    assert_true(length + 2 <= sizeof message);
    memcpy(message + 2, data, length);
    liar_set_mail(l, COE, message, length + 2);
}
