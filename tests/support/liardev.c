/* SPDX-License-Identifier: MIT */
#include "support/liardev.h"

#include <string.h>

#include "seams/mailbox.h"
#include "support/testdev.h"
#include "wire/bytes.h"

enum { EMERGENCY = 1, REQUEST = 2, RESPONSE = 3, INFO = 8, UPLOAD = 2, SEGMENT = 3, INCOMPLETE = 0x80 };

typedef struct lie {
    ect_protocol_t protocol;
    const char *name;
    uint32_t size;       /* that an upload announces; 0: the four bytes of an expedited one */
    uint8_t toggle;      /* of each segment */
    uint8_t index;       /* added to that of an upload */
    bool no_uploads;     /* without a reply */
    bool no_information; /* without a reply */
    bool endless_list;
    bool endless_mails;
} lie_t;

static void send(ect_slave_t *slave, uint8_t service, const void *data, size_t length)
{
    uint8_t *mail = ect_mailbox_build(slave);
    mail[1] = (uint8_t)(service << 4);
    memcpy(mail + 2, data, length);
    ect_mailbox_send(slave, ECT_MAILBOX_TYPE_COE, (uint16_t)(2 + length));
}

static void upload(const lie_t *lie, ect_slave_t *slave, const uint8_t *r)
{
    uint8_t reply[20] = {lie->size != 0 ? 0x41 : 0x43, (uint8_t)(r[3] + lie->index), r[4], r[5]};
    ect_store_le32(reply + 4, lie->size);
    if (!lie->no_uploads)
        send(slave, RESPONSE, reply, lie->size != 0 ? 18 : 8);
}

static void information(const lie_t *lie, ect_slave_t *slave, const uint8_t *r)
{
    static const uint8_t none[8] = {7, 0, 0, 0, 0x00, 0x00, 0x01, 0x06};
    static const uint8_t list[8] = {2 | INCOMPLETE, 0, 1, 0, 1, 0, 0x00, 0x10};
    if (lie->no_information)
        return;
    send(slave, INFO, lie->endless_list && r[2] == 1 ? list : none, sizeof none);
    ect_mailbox_wake(slave);
}

static uint16_t request(const ect_protocol_t *self, ect_slave_t *slave, const uint8_t *data, uint16_t length)
{
    const lie_t *lie = (const lie_t *)(const void *)self;
    const uint8_t segment[20] = {lie->toggle};
    if (length < 8)
        return ECT_MAILBOX_ERROR_SIZE;
    if (data[1] >> 4 == INFO)
        information(lie, slave, data);
    else if (data[2] >> 5 == UPLOAD)
        upload(lie, slave, data);
    else if (data[2] >> 5 == SEGMENT)
        send(slave, RESPONSE, segment, sizeof segment);
    return ECT_MAILBOX_OK;
}

static bool next(const ect_protocol_t *self, ect_slave_t *slave, bool is_sent)
{
    const lie_t *lie = (const lie_t *)(const void *)self;
    static const uint8_t fragment[4] = {2 | INCOMPLETE};
    static const uint8_t emergency[8] = {0, 0x10};
    if (is_sent && lie->endless_list)
        send(slave, INFO, fragment, sizeof fragment);
    else if (is_sent && lie->endless_mails)
        send(slave, EMERGENCY, emergency, sizeof emergency);
    return lie->endless_list || lie->endless_mails;
}

#define LIAR {.type = ECT_MAILBOX_TYPE_COE, .states = ECT_IN_PREOP_AND_ABOVE, .request = request, .next = next}

static const lie_t lies[] = {
    {LIAR, "liar-upload-4g", .size = UINT32_MAX},
    {LIAR, "liar-no-uploads", .no_uploads = true},
    {LIAR, "liar-no-replies", .no_uploads = true, .no_information = true},
    {LIAR, "liar-toggle", .size = 1000, .toggle = 0},
    {LIAR, "liar-other-index", .index = 1},
    {LIAR, "liar-endless-list", .endless_list = true},
    {LIAR, "liar-endless-mails", .endless_mails = true, .no_uploads = true},
};

const ect_device_t *liardev(size_t number)
{
    enum { COUNT = sizeof lies / sizeof lies[0] };
    static ect_device_t devices[COUNT];
    static const ect_protocol_t *protocols[COUNT][2];
    if (number >= COUNT)
        return NULL;
    protocols[number][0] = &lies[number].protocol;
    devices[number] = testdev;
    devices[number].name = lies[number].name;
    devices[number].protocols = protocols[number];
    devices[number].coe_details = 0;
    return &devices[number];
}
