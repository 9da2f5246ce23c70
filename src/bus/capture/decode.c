/* SPDX-License-Identifier: MIT */
#include "bus/capture/decode.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "text/state.h"
#include "wire/bytes.h"
#include "wire/registers.h"

enum { NOP, APRD, APWR, APRW, FPRD, FPWR, FPRW, BRD, BWR, BRW, LRD, LWR, LRW, ARMW, FRMW };
enum { MAIL_ERROR = 0, MAIL_COE = 3 };
enum { COE_EMERGENCY = 1, COE_REQUEST = 2, COE_RESPONSE = 3, COE_INFO = 8 };
enum { ETHERNET = 14, HEADER = 10, TRAILER = 2, SHOWN_BYTES = 48, MAIL_HEADER = 6 };

typedef struct out {
    char *text;
    size_t room, used;
} out_t;

static void print(out_t *o, const char *format, ...) __attribute__((format(printf, 2, 3)));
static void print(out_t *o, const char *format, ...)
{
    va_list arguments;
    if (o->used + 1 >= o->room)
        return;
    va_start(arguments, format);
    int length = vsnprintf(o->text + o->used, o->room - o->used, format, arguments);
    va_end(arguments);
    o->used += length > 0 ? (size_t)length : 0;
}

static void print_bytes(out_t *o, const uint8_t *bytes, size_t length)
{
    for (size_t i = 0; i < length && i < SHOWN_BYTES; i++)
        print(o, " %02X", bytes[i]);
    if (length > SHOWN_BYTES)
        print(o, " ... (%zu bytes)", length);
}

static const char *const commands[] = {"NOP", "APRD", "APWR", "APRW", "FPRD", "FPWR", "FPRW", "BRD",
                                       "BWR", "BRW",  "LRD",  "LWR",  "LRW",  "ARMW", "FRMW"};

static const struct {
    uint16_t first, last;
    const char *name;
} registers[] = {
    {0x0000, 0x0009, "chip information"},   {0x0010, 0x0011, "station address"}, {0x0012, 0x0013, "station alias"},
    {0x0020, 0x0031, "write protection"},   {0x0040, 0x0041, "ESC reset"},       {0x0100, 0x0103, "DL control"},
    {0x0108, 0x0109, "read/write offset"},  {0x0110, 0x0111, "DL status"},       {0x0120, 0x0121, "AL control"},
    {0x0130, 0x0135, "AL status"},          {0x0138, 0x0139, "indicators"},      {0x0140, 0x0153, "PDI configuration"},
    {0x0200, 0x0207, "event masks"},        {0x0210, 0x0211, "ECAT event"},      {0x0220, 0x0223, "AL event"},
    {0x0300, 0x0313, "error counters"},     {0x0400, 0x0448, "watchdogs"},       {0x0500, 0x050F, "SII"},
    {0x0900, 0x09FF, "distributed clocks"}, {0x0F80, 0x0FFF, "user RAM"},
};

static void print_place(const ect_mailboxes_t *m, out_t *o, uint16_t address)
{
    if (address >= ECT_REG_FMMU && address < ECT_REG_FMMU + 0x100)
        print(o, " FMMU%u", (address - ECT_REG_FMMU) / ECT_FMMU_SIZE);
    else if (address >= ECT_REG_SM && address < ECT_REG_SM + 0x80)
        print(o, " SM%u", (address - ECT_REG_SM) / ECT_SM_SIZE);
    else if (address >= ECT_RAM && address == m->out_start)
        print(o, " mailbox out");
    else if (address >= ECT_RAM && address == m->in_start)
        print(o, " mailbox in");
    for (size_t i = 0; i < sizeof registers / sizeof registers[0]; i++) {
        if (address >= registers[i].first && address <= registers[i].last)
            print(o, " %s", registers[i].name);
    }
}

/* --- mails -------------------------------------------------------------------------------------------------------- */

static void print_sdo(out_t *o, const uint8_t *sdo, bool reply)
{
    const uint16_t index = ect_load_le16(sdo + 1);
    switch (sdo[0] >> 5) {
    case 4:
        print(o, "abort %04Xh:%02X code 0x%08X", index, sdo[3], ect_load_le32(sdo + 4));
        break;
    case 2:
        print(o, "upload %04Xh:%02X%s", index, sdo[3], (sdo[0] & 0x10) != 0 ? " complete" : "");
        break;
    case 1:
        print(o, reply ? "segment taken" : "download %04Xh:%02X%s", index, sdo[3],
              (sdo[0] & 0x10) != 0 ? " complete" : "");
        break;
    case 3:
        print(o, reply ? "downloaded %04Xh:%02X" : "next segment", index, sdo[3]);
        break;
    default:
        print(o, "segment, toggle %d%s", sdo[0] >> 4 & 1, (sdo[0] & 1) != 0 ? ", last" : "");
        break;
    }
}

static void print_coe(out_t *o, const uint8_t *coe, size_t length)
{
    static const char *const services[16] = {"service 0", "emergency",     "SDO request",   "SDO response", "TxPDO",
                                             "RxPDO",     "TxPDO request", "RxPDO request", "information"};
    unsigned int service = ect_load_le16(coe) >> 12;
    print(o, "CoE %s ", services[service] ? services[service] : "of an unknown service");
    if ((service == COE_REQUEST || service == COE_RESPONSE) && length >= 10)
        print_sdo(o, coe + 2, service == COE_RESPONSE);
    else if (service == COE_EMERGENCY && length >= 4)
        print(o, "code 0x%04X", ect_load_le16(coe + 2));
    else if (service == COE_INFO && length >= 6)
        print(o, "opcode %u, %u fragments left", coe[2] & 0x7Fu, ect_load_le16(coe + 4));
}

static void print_mail(out_t *o, const uint8_t *mail, size_t room)
{
    static const char *const types[16] = {"error", "AoE", "EoE", "", "FoE", "SoE"};
    size_t length = ect_load_le16(mail);
    unsigned int type = mail[5] & 0x0F;
    print(o, " | mail of %zu bytes, counter %u: ", length, mail[5] >> 4 & 7u);
    if (length > room - MAIL_HEADER)
        length = room - MAIL_HEADER;
    if (type == MAIL_COE && length >= 2)
        print_coe(o, mail + MAIL_HEADER, length);
    else if (type == MAIL_ERROR && length >= 4)
        print(o, "error, detail 0x%04X", ect_load_le16(mail + MAIL_HEADER + 2));
    else
        print(o, "%s type %u", types[type] ? types[type] : "", type);
    print(o, " |");
    print_bytes(o, mail, length + MAIL_HEADER);
}

/* --- datagrams ---------------------------------------------------------------------------------------------------- */

static bool reads(uint8_t command)
{
    return command != APWR && command != FPWR && command != BWR && command != LWR;
}

static bool writes(uint8_t command)
{
    return command != APRD && command != FPRD && command != BRD && command != LRD;
}

static void print_head(const ect_mailboxes_t *m, out_t *o, const uint8_t *d, size_t length)
{
    uint8_t command = d[0];
    if (command < sizeof commands / sizeof commands[0])
        print(o, "%s", commands[command]);
    else
        print(o, "command %u", command);
    if (command >= LRD && command <= LRW)
        print(o, " logical 0x%08X", ect_load_le32(d + 2));
    else
        print(o, " %04X:%04X", ect_load_le16(d + 2), ect_load_le16(d + 4));
    if (command < LRD || command > LRW)
        print_place(m, o, ect_load_le16(d + 4));
    print(o, ", %zu byte%s", length, length == 1 ? "" : "s");
}

/* Prints AL control or AL status as text. */
static void print_state(out_t *o, uint16_t address, const uint8_t *data, size_t length)
{
    if (address == ECT_REG_AL_CONTROL && length > 0)
        print(o, " | %s%s", ect_state_text(data[0] & ECT_AL_STATE_MASK),
              (data[0] & ECT_AL_ACKNOWLEDGE) != 0 ? ", acknowledge" : "");
    else if (address == ECT_REG_AL_STATUS && length > 0)
        print(o, " | %s", ect_state_text(data[0]));
    if (address == ECT_REG_AL_STATUS && length >= 6)
        print(o, ", code 0x%04X", ect_load_le16(data + 4));
}

static void print_datagram(const ect_mailboxes_t *m, out_t *o, const uint8_t *d, size_t length, bool sent)
{
    uint16_t address = ect_load_le16(d + 4);
    bool logical = d[0] >= LRD && d[0] <= LRW;
    bool data = sent ? writes(d[0]) : reads(d[0]);
    print_head(m, o, d, length);
    if (!sent)
        print(o, ", WKC %u", ect_load_le16(d + HEADER + length));
    if (!data || (!sent && ect_load_le16(d + HEADER + length) == 0))
        return;
    if (!logical && length >= MAIL_HEADER && address >= ECT_RAM &&
        (address == m->out_start || address == m->in_start)) {
        print_mail(o, d + HEADER, length);
        return;
    }
    print(o, ":");
    print_bytes(o, d + HEADER, length);
    if (!logical)
        print_state(o, address, d + HEADER, length);
}

static void print_frame(const ect_mailboxes_t *m, out_t *o, const uint8_t *frame, size_t size, bool sent)
{
    bool more = true;
    size_t at = ETHERNET + 2;
    if (size < at || ect_load_be16(frame + 12) != 0x88A4 || ect_load_le16(frame + ETHERNET) >> 12 != 1) {
        print(o, "frame of %zu bytes:", size);
        print_bytes(o, frame, size);
        return;
    }
    while (more) {
        if (size < at + HEADER + TRAILER ||
            size - at < HEADER + TRAILER + (size_t)(ect_load_le16(frame + at + 6) & 0x07FF)) {
            print(o, "%scut off:", at > ETHERNET + 2 ? "\n" : "");
            print_bytes(o, frame + at, size - at);
            return;
        }
        size_t length = ect_load_le16(frame + at + 6) & 0x07FF;
        print(o, "%s", at > ETHERNET + 2 ? "\n" : "");
        print_datagram(m, o, frame + at, length, sent);
        more = (frame[at + 7] & 0x80) != 0;
        at += HEADER + length + TRAILER;
    }
}

void ect_decode_frame(const ect_mailboxes_t *m, const uint8_t *frame, size_t length, bool sent, char *text, size_t room)
{
    out_t o = {.text = text, .room = room};
    text[0] = 0;
    print_frame(m, &o, frame, length, sent);
}

void ect_decode_datagram(const ect_mailboxes_t *m, const uint8_t *datagram, size_t length, bool sent, char *text,
                         size_t room)
{
    out_t o = {.text = text, .room = room};
    text[0] = 0;
    print_datagram(m, &o, datagram, length, sent);
}
