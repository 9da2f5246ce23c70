/* SPDX-License-Identifier: MIT */
/* H. Mailbox protocols other than CoE: reads only, nothing is written. */
#include <string.h>

#include "case.h"

enum { FOE_READ = 1, FOE_ACK = 4, FOE_ERROR = 5, FOE_BUSY = 6, FOE_HEADER = 6 };
enum { EOE_GET_IP = 6, EOE_GOT_IP = 7, EOE_LAST = 0x01, ERROR_PROTOCOL = 2 };

/* A file of that name is read, until its answer is no longer BUSY. */
static void ask_file(cf_t *c, const char *name, cf_mail_t *mail)
{
    uint8_t request[64] = {FOE_READ};
    size_t length = strlen(name);
    memcpy(request + FOE_HEADER, name, length);
    do {
        cf_send_mail(c, CF_MBX_FOE, request, (uint16_t)(FOE_HEADER + length));
        cf_receive(c, CF_MBX_FOE, mail);
        cf_expect_that(c, mail->length >= FOE_HEADER, "a FoE answer: expected at least 6 bytes, got %u", mail->length);
    } while (mail->data[0] == FOE_BUSY);
}

static void files(cf_t *c)
{
    uint8_t ack[FOE_HEADER] = {FOE_ACK};
    cf_mail_t mail;
    if ((c->facts.has & CF_BOOTSTRAP) != 0)
        cf_go(c, CF_BOOT);
    else
        cf_go(c, CF_PREOP);
    ask_file(c, "no such file", &mail);
    cf_expect(c, "FoE operation for a file that does not exist", FOE_ERROR, mail.data[0]);
    cf_expect_bits(c, "error code: one of FoE", 0xFFFFFFF0u, 0x8000, ect_load_le32(mail.data + 2));
    cf_step(c, "an acknowledge of nothing");
    ect_store_le32(ack + 2, 77);
    cf_send_mail(c, CF_MBX_FOE, ack, sizeof ack);
    cf_receive(c, CF_MBX_FOE, &mail);
    cf_expect(c, "FoE operation for an acknowledge of nothing", FOE_ERROR, mail.data[0]);
    cf_note(c, "refusals; files are neither read nor written, for none is known");
}

static void ethernet(cf_t *c)
{
    const uint8_t request[4] = {EOE_GET_IP, EOE_LAST, 0, 0};
    cf_mail_t mail;
    cf_go(c, CF_PREOP);
    cf_send_mail(c, CF_MBX_EOE, request, sizeof request);
    cf_receive(c, CF_MBX_EOE, &mail);
    cf_expect_that(c, mail.length >= 4, "an EoE answer: expected at least 4 bytes, got %u", mail.length);
    cf_expect_bits(c, "EoE type of the answer to 'get IP'", 0x0F, EOE_GOT_IP, mail.data[0]);
}

/* What is not offered is refused, and the mailbox goes on. */
static void not_offered(cf_t *c)
{
    static const struct {
        uint8_t type, bit;
    } others[] = {{CF_MBX_AOE, CF_PROTO_AOE}, {CF_MBX_SOE, CF_PROTO_SOE}, {CF_MBX_VOE, CF_PROTO_VOE}};
    const uint8_t nothing[8] = {0};
    unsigned int tried = 0;
    cf_go(c, CF_PREOP);
    for (size_t i = 0; i < sizeof others / sizeof others[0]; i++) {
        if ((c->facts.protocols & others[i].bit) != 0)
            continue;
        cf_step(c, "mailbox type %u", others[i].type);
        cf_send_mail(c, others[i].type, nothing, sizeof nothing);
        cf_expect_mail_error(c, ERROR_PROTOCOL);
        tried++;
    }
    if (tried == 0)
        cf_skip(c, "the slave offers them all");
}

static const cf_case_t cases[] = {
    {"CF-084", "FoE refuses files that do not exist with its error", 'F', CF_MAILBOX | CF_FOE, 0, files},
    {"CF-085", "EoE answers 'get IP'", 'F', CF_MAILBOX | CF_EOE, 0, ethernet},
    {"CF-086", "AoE, SoE and VoE get a mailbox error where they are not offered", 'R', CF_MAILBOX, 0, not_offered},
};

CF_SECTION(cf_mailbox, 'H', "Other mailbox protocols", cases);
