/* SPDX-License-Identifier: MIT */
/* CF-A01, CF-A02: ADS over EtherCAT, as far as it does not depend on the slave's application. */
#include <string.h>

#include "cases/beyond.h"

enum { HEADER = 32, ADDRESS = 8, COMMAND = 16, FLAGS = 18, LENGTH = 20, ERROR = 24, INVOKE = 28, IS_ADS = 4 };
enum { REQUEST = 0x0004, RESPONSE = 0x0005 };
enum { DEVICE_INFO = 1, READ = 2, WRITE = 3, STATE = 4, PARAMETERS = 12, VALUE = 8 };
enum { COE_GROUP = 0xF302, NO_GROUP = 0x00BAD000, UNKNOWN_COMMAND = 8, NO_COMMAND = 0x0077 };
enum { IDENTITY = 0x1018, NO_OBJECT = 0x0BAD, ERROR_TOO_SHORT = 6 };

typedef struct ads {
    uint16_t command;
    const uint8_t *data;
    uint16_t length;
    uint32_t invoke;
} ads_t;

static void need(cf_t *c)
{
    if ((c->facts.protocols & CF_PROTO_AOE) == 0)
        cf_skip(c, "the slave has no AoE");
    cf_go(c, CF_PREOP);
}

static void send(cf_t *c, const ads_t *request)
{
    static const uint8_t addresses[2 * ADDRESS] = {0, 0, 0, 0, 0, 0, 1, 0x10, 192, 0, 2, 1, 1, 1, 0, 0x80};
    uint8_t mail[HEADER + PARAMETERS + VALUE] = {0};
    memcpy(mail, addresses, sizeof addresses);
    ect_store_le16(mail + COMMAND, request->command);
    ect_store_le16(mail + FLAGS, REQUEST);
    ect_store_le32(mail + LENGTH, request->length);
    ect_store_le32(mail + INVOKE, request->invoke);
    if (request->length > 0)
        memcpy(mail + HEADER, request->data, request->length);
    cf_send_mail(c, CF_MBX_AOE, mail, (uint16_t)(HEADER + request->length));
}

/* Receives the reply to `request`. @return error code of the AMS header */
static uint32_t receive(cf_t *c, const ads_t *request, cf_mail_t *mail)
{
    cf_receive(c, CF_MBX_AOE, mail);
    cf_expect_range(c, "bytes of the reply", HEADER, CF_MAX_MAIL, mail->length);
    cf_expect(c, "command of the reply", request->command, ect_load_le16(mail->data + COMMAND));
    cf_expect_bits(c, "state flags of the reply", RESPONSE, RESPONSE, ect_load_le16(mail->data + FLAGS));
    cf_expect(c, "invoke id of the reply", request->invoke, ect_load_le32(mail->data + INVOKE));
    cf_expect(c, "length in the AMS header", (uint64_t)mail->length - HEADER, ect_load_le32(mail->data + LENGTH));
    return ect_load_le32(mail->data + ERROR);
}

/* Sends a command. @return its result, or the error code of the AMS header */
static uint32_t ask(cf_t *c, const ads_t *request, cf_mail_t *mail)
{
    send(c, request);
    const uint32_t error = receive(c, request, mail);
    if (error != 0)
        return error;
    cf_expect_range(c, "bytes behind the AMS header", 4, CF_MAX_MAIL, (uint64_t)mail->length - HEADER);
    return ect_load_le32(mail->data + HEADER);
}

static uint32_t ask_read(cf_t *c, uint32_t group, uint32_t offset, uint32_t invoke, cf_mail_t *mail)
{
    uint8_t parameters[PARAMETERS];
    ect_store_le32(parameters, group);
    ect_store_le32(parameters + 4, offset);
    ect_store_le32(parameters + 8, 4);
    return ask(c, &(ads_t){READ, parameters, sizeof parameters, invoke}, mail);
}

static void expect_identity(cf_t *c, uint8_t sub, uint64_t want)
{
    cf_mail_t mail;
    cf_step(c, "Read of 1018h:%u by index group F302h", sub);
    cf_expect(c, "result of Read", 0, ask_read(c, COE_GROUP, (uint32_t)IDENTITY << 16 | sub, 2u + sub, &mail));
    cf_expect_range(c, "bytes of the reply", HEADER + VALUE + 4, HEADER + VALUE + 4, mail.length);
    cf_expect(c, "length of the value", 4, ect_load_le32(mail.data + HEADER + 4));
    cf_expect(c, "value", want, ect_load_le32(mail.data + HEADER + VALUE));
}

static void expect_state(cf_t *c, uint32_t invoke)
{
    cf_mail_t mail;
    cf_step(c, "ReadState");
    cf_expect(c, "result of ReadState", 0, ask(c, &(ads_t){STATE, NULL, 0, invoke}, &mail));
    cf_expect_range(c, "bytes of the reply", HEADER + VALUE, HEADER + VALUE, mail.length);
}

void cf_ads_reads(cf_t *c)
{
    cf_mail_t mail;
    need(c);
    expect_state(c, 1);
    cf_step(c, "ReadDeviceInfo");
    cf_expect(c, "result of ReadDeviceInfo", 0, ask(c, &(ads_t){DEVICE_INFO, NULL, 0, 2}, &mail));
    cf_expect_range(c, "bytes of the reply", HEADER + 24, HEADER + 24, mail.length);
    if ((c->facts.has & CF_COE) == 0)
        return;
    for (uint8_t sub = 1; sub <= 2; sub++)
        expect_identity(c, sub, cf_upload_number(c, IDENTITY, sub));
}

void cf_ads_refusals(cf_t *c)
{
    static const struct {
        const char *what;
        uint32_t group, offset;
    } rows[] = {{"an index group that no slave has", NO_GROUP, 0},
                {"an object that no slave has", COE_GROUP, (uint32_t)NO_OBJECT << 16},
                {"sub-index 255 of 1018h", COE_GROUP, (uint32_t)IDENTITY << 16 | 0xFF}};
    const uint8_t nothing[PARAMETERS] = {0};
    cf_mail_t mail;
    need(c);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        cf_step(c, "Read of %s", rows[i].what);
        const uint32_t result = ask_read(c, rows[i].group, rows[i].offset, (uint32_t)(30 + i), &mail);
        cf_expect_that(c, result != 0, "result of a Read of %s: expected an error, got 0x0000", rows[i].what);
        expect_state(c, (uint32_t)(10 + i));
    }
    cf_step(c, "a command that ADS does not have");
    cf_expect(c, "error code in the AMS header", UNKNOWN_COMMAND, ask(c, &(ads_t){NO_COMMAND, NULL, 0, 20}, &mail));
    for (uint32_t length = 0; length < PARAMETERS; length += PARAMETERS - 1) {
        cf_step(c, "Write with %u bytes of parameters", length);
        const uint32_t error = ask(c, &(ads_t){WRITE, nothing, (uint16_t)length, 21 + length}, &mail);
        cf_expect_that(c, error != 0, "Write with %u bytes of parameters: expected an error, got 0x0000", length);
    }
    cf_step(c, "a mail of 31 bytes, shorter than an AMS header");
    cf_send_mail(c, CF_MBX_AOE, (const uint8_t[HEADER]){0}, HEADER - 1);
    cf_expect_mail_error(c, ERROR_TOO_SHORT);
    expect_state(c, 50);
}
