/* SPDX-License-Identifier: MIT */
/* The systematic part of CF-094: every command, header field and length once. No request has a lasting effect. */
#include <string.h>

#include "cases/beyond.h"

enum { MAIL_HEADER = 6, TYPE = 5, COE = 6, SDO = 8, UPLOAD = 0x40, UPLOAD_BYTES = 10, NOT_AN_OBJECT = 0x0001 };
enum { DRAIN_MS = 100, UNMAPPED = 0x70000000, INFO_HEADER = 4, FOE_WRITE = 2 };
enum { ETHERNET = 14, FRAME = 60, FRAME_LENGTHS = 0x800, LENGTH_STEP = 37 };

/* --- datagrams ---------------------------------------------------------------------------------------------------- */

static bool is_logical(unsigned int command)
{
    return command >= CF_LRD && command <= CF_LRW;
}

static bool is_positional(unsigned int command)
{
    return command <= CF_APRW || command == CF_ARMW;
}

/* Writes go to the last bytes of the RAM, which the process data of a start-up do not use. */
static unsigned long commands(cf_t *c)
{
    const uint16_t place = (uint16_t)(ECT_RAM + c->facts.ram_kb * 1024u - 4);
    cf_step(c, "every command of a datagram");
    for (unsigned int command = 0; command <= UINT8_MAX; command++) {
        uint8_t data[4] = {0};
        uint16_t adp = is_positional(command) ? c->facts.ring : c->facts.station;
        (void)cf_logical(c, (uint8_t)command, is_logical(command) ? UNMAPPED : CF_AT(adp, place), data, sizeof data);
    }
    return UINT8_MAX + 1;
}

/* @param type    type field of the EtherCAT header
 * @param claims  length field of the EtherCAT header
 * @param length  length field of the datagram, with its flags */
static void raw_frame(cf_t *c, unsigned int type, unsigned int claims, unsigned int length)
{
    uint8_t frame[FRAME] = {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 1, 1, 1, 1, 1, 1, 0x88, 0xA4};
    ect_store_le16(frame + ETHERNET, (uint16_t)(type << 12 | (claims & 0x7FF)));
    frame[ETHERNET + 2] = CF_BRD;
    frame[ETHERNET + 3] = 0xEE; /* an index unused by exchanges */
    ect_store_le16(frame + ETHERNET + 8, (uint16_t)length);
    (void)cf_raw_frame(c, frame, sizeof frame, NULL);
}

static unsigned long frames(cf_t *c)
{
    unsigned long sent = 0;
    cf_step(c, "every type and length of an EtherCAT header, lengths and flags of a datagram");
    for (unsigned int type = 0; type < 16; type++, sent++)
        raw_frame(c, type, 16, 4);
    for (unsigned int length = 0; length < FRAME_LENGTHS; length += LENGTH_STEP, sent += 2) {
        raw_frame(c, 1, length, 4);
        raw_frame(c, 1, length + 12, length);
    }
    for (unsigned int flags = 0; flags < 32; flags++, sent++)
        raw_frame(c, 1, 16, flags << 11 | 4);
    return sent;
}

/* --- mails -------------------------------------------------------------------------------------------------------- */

/* Reads replies until SM0 is free: a full SM0 refuses the next mail. */
static void drain(cf_t *c)
{
    uint8_t reply[CF_MAX_MAIL];
    uint64_t until = cf_now_ns() + DRAIN_MS * UINT64_C(1000000);
    bool full = true;
    while (full && cf_now_ns() < until) {
        if (cf_mail_waits(c))
            (void)cf_read(c, c->mailbox.in_start, reply, c->mailbox.in_size);
        full = (cf_get8(c, (uint16_t)(CF_SM(0) + ECT_SM_STATUS)) & ECT_SM_STATUS_FULL) != 0;
        if (full)
            cf_poll_pause(c);
    }
}

static void post(cf_t *c, const uint8_t *mail)
{
    drain(c);
    (void)cf_write(c, c->mailbox.out_start, mail, c->mailbox.out_size);
}

/* Builds an upload of 1018h:01 for CoE, a mail of zeros for any other type. */
static void upload(cf_t *c, uint8_t *mail, uint8_t type)
{
    memset(mail, 0, CF_MAX_MAIL);
    ect_store_le16(mail, UPLOAD_BYTES);
    c->mail_counter = (uint8_t)(c->mail_counter % 7 + 1);
    mail[TYPE] = (uint8_t)(type | c->mail_counter << 4);
    if (type != CF_MBX_COE)
        return;
    ect_store_le16(mail + COE, CF_COE_REQUEST << 12);
    mail[SDO] = UPLOAD;
    ect_store_le16(mail + SDO + 1, 0x1018);
    mail[SDO + 3] = 1;
}

/* @return false: the slave supports the protocol, in which a mail of zeros may have an effect (CoE excepted) */
static bool is_harmless(const cf_t *c, unsigned int type)
{
    static const uint8_t bits[16] = {[CF_MBX_AOE] = CF_PROTO_AOE,
                                     [CF_MBX_EOE] = CF_PROTO_EOE,
                                     [CF_MBX_SOE] = CF_PROTO_SOE,
                                     [CF_MBX_VOE] = CF_PROTO_VOE};
    return (c->facts.protocols & bits[type]) == 0;
}

static unsigned long mail_headers(cf_t *c)
{
    uint8_t mail[CF_MAX_MAIL];
    unsigned long sent = 0;
    cf_step(c, "every type, counter, channel and length of a mail");
    for (unsigned int type = 0; type < 16; type++) {
        if (!is_harmless(c, type))
            continue;
        upload(c, mail, (uint8_t)type);
        post(c, mail);
        sent++;
    }
    for (unsigned int bits = 0; bits <= UINT8_MAX; bits++, sent++) {
        upload(c, mail, CF_MBX_COE);
        if (bits < 16)
            mail[TYPE] = (uint8_t)(bits << 4 | CF_MBX_COE);
        else
            mail[4] = (uint8_t)bits;
        post(c, mail);
    }
    for (unsigned int length = 0; length <= c->mailbox.out_size + 2u; length++, sent++) {
        upload(c, mail, CF_MBX_COE);
        ect_store_le16(mail, (uint16_t)(length > c->mailbox.out_size ? UINT16_MAX - length : length));
        post(c, mail);
    }
    return sent;
}

/* Downloads are to a non-existent object; segments belong to no transfer. */
static unsigned long coe(cf_t *c)
{
    uint8_t mail[CF_MAX_MAIL];
    cf_step(c, "every service of CoE, command of an SDO, opcode of the information service");
    for (unsigned int service = 0; service < 16; service++) {
        upload(c, mail, CF_MBX_COE);
        ect_store_le16(mail + COE, (uint16_t)(service << 12));
        post(c, mail);
    }
    for (unsigned int command = 0; command <= UINT8_MAX; command++) {
        upload(c, mail, CF_MBX_COE);
        mail[SDO] = (uint8_t)command;
        ect_store_le16(mail + SDO + 1, NOT_AN_OBJECT);
        post(c, mail);
    }
    for (unsigned int opcode = 0; opcode <= UINT8_MAX; opcode++) {
        upload(c, mail, CF_MBX_COE);
        ect_store_le16(mail + COE, (uint16_t)(CF_COE_INFO << 12));
        memset(mail + SDO, 0, INFO_HEADER);
        mail[SDO] = (uint8_t)opcode;
        post(c, mail);
    }
    return 16 + 2 * (UINT8_MAX + 1);
}

static unsigned long foe(cf_t *c)
{
    uint8_t mail[CF_MAX_MAIL];
    cf_step(c, "every operation of FoE but write");
    for (unsigned int operation = 0; operation <= UINT8_MAX; operation++) {
        upload(c, mail, CF_MBX_FOE);
        mail[MAIL_HEADER] = (uint8_t)(operation == FOE_WRITE ? 0 : operation);
        post(c, mail);
    }
    return UINT8_MAX + 1;
}

/* --- AL control --------------------------------------------------------------------------------------------------- */

static unsigned long requests(cf_t *c)
{
    cf_step(c, "every value of AL control's low byte");
    for (unsigned int value = 0; value <= UINT8_MAX; value++) {
        const uint8_t request[2] = {(uint8_t)value, 0};
        (void)cf_write(c, ECT_REG_AL_CONTROL, request, sizeof request);
    }
    return UINT8_MAX + 1;
}

unsigned long cf_sweep(cf_t *c)
{
    static const struct {
        unsigned long (*send)(cf_t *c);
        uint32_t needs;
    } kinds[] = {{commands, 0}, {frames, 0}, {mail_headers, CF_MAILBOX}, {coe, CF_COE}, {foe, CF_FOE}, {requests, 0}};
    const uint64_t vendor = cf_start_up(c);
    unsigned long sent = 0;
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; i++) {
        if ((kinds[i].needs & ~c->facts.has) != 0)
            continue;
        sent += kinds[i].send(c);
        cf_expect(c, "vendor id, 1018h:01", vendor, cf_start_up(c));
    }
    cf_put8(c, ECT_REG_SII_CONFIG, 0);
    return sent;
}
