/* SPDX-License-Identifier: MIT */
#include "defects.h"

#include <string.h>

#include "defects_internal.h"
#include "sii/sii.h"

enum { ETHERNET = 14, MAIL_HEADER = 6, UNKNOWN_COMMAND = 99, ANY_MAIL = 0xFFFF };

static uint8_t al_status(const datagram_t *g)
{
    return g->chip[ECT_REG_AL_STATUS] & 0x1F;
}

static bool covers(const datagram_t *g, uint16_t address, uint16_t width)
{
    return address >= g->ado && (uint32_t)address + width <= (uint32_t)g->ado + g->length;
}

static void set_counter(const datagram_t *g, uint16_t value)
{
    ect_store_le16(g->now + ECT_DATAGRAM_DATA + g->length, value);
}

static uint16_t out_size(const datagram_t *g)
{
    return ect_load_le16(g->chip + SM_0 + ECT_SM_LENGTH);
}

static uint16_t in_size(const datagram_t *g)
{
    return ect_load_le16(g->chip + SM_1 + ECT_SM_LENGTH);
}

static void apply(const change_t *c, uint8_t *at)
{
    uint32_t value = 0;
    for (unsigned int i = 0; i < c->width; i++)
        value |= (uint32_t)at[i] << 8 * i;
    if (c->how == IF_EXPECTED && (value & c->mask) != c->was)
        return;
    value = c->how == INVERTED ? value ^ c->mask : (value & ~c->mask) | c->becomes;
    for (unsigned int i = 0; i < c->width; i++)
        at[i] = (uint8_t)(value >> 8 * i);
}

/* --- single defects ----------------------------------------------------------------------------------------------- */

/* Hides a datagram from the chip; defect_after restores it. */
static void hide(const datagram_t *g)
{
    g->now[ECT_DATAGRAM_COMMAND] = ECT_NOP;
}

static void bring_back(const datagram_t *g, uint16_t count)
{
    memcpy(g->now, g->sent, ECT_DATAGRAM_DATA);
    set_counter(g, count);
}

static void position_stays(defect_t *d, datagram_t *g)
{
    (void)d;
    if (g->command == ECT_APRD)
        ect_store_le16(g->now + ECT_DATAGRAM_ADP, g->adp);
}

static void position_twice(defect_t *d, datagram_t *g)
{
    (void)d;
    if (g->command == ECT_BRD && g->length > 2)
        ect_store_le16(g->now + ECT_DATAGRAM_ADP, (uint16_t)(ect_load_le16(g->now + ECT_DATAGRAM_ADP) + 1));
}

static void any_station(defect_t *d, datagram_t *g)
{
    (void)d;
    if (g->command == ECT_FPRD)
        memcpy(g->now + ECT_DATAGRAM_ADP, g->chip + ECT_REG_STATION_ADDRESS, 2);
}

static void own_station(defect_t *d, datagram_t *g)
{
    (void)d;
    if (g->command == ECT_FPRD)
        ect_store_le16(g->now + ECT_DATAGRAM_ADP, g->adp);
}

static void one_fmmu_more(defect_t *d, datagram_t *g)
{
    (void)d;
    if (g->command == ECT_FPWR && g->ado == ECT_REG_FMMU + ECT_FMMU_SIZE * g->chip[ECT_REG_FMMU_COUNT] &&
        g->length == ECT_FMMU_SIZE)
        set_counter(g, 1);
}

static void behind_the_ram(defect_t *d, datagram_t *g)
{
    (void)d;
    if (g->command == ECT_FPRD && g->ado == ECT_RAM + 1024 * g->chip[ECT_REG_RAM_SIZE])
        set_counter(g, 1);
}

/* A read-only register returns the written value until the original value is written. */
static void keep_written(defect_t *d, datagram_t *g)
{
    uint16_t address = d->row->address;
    if (g->command == ECT_FPWR && covers(g, address, 1)) {
        d->memory[1] = g->sent[ECT_DATAGRAM_DATA + address - g->ado];
        d->memory[0] = d->memory[1] != g->chip[address];
        set_counter(g, 1);
    } else if (g->command == ECT_FPRD && covers(g, address, 1) && d->memory[0] != 0) {
        data(g)[address - g->ado] = (uint8_t)d->memory[1];
        set_counter(g, 1);
    }
}

static void no_circulating(defect_t *d, datagram_t *g)
{
    (void)d;
    g->now[ECT_DATAGRAM_LENGTH + 1] &= 0xBF;
}

static void tenth_is_lost(defect_t *d, datagram_t *g)
{
    if (++d->memory[0] == 10)
        set_counter(g, 0);
    if ((g->sent[ECT_DATAGRAM_LENGTH + 1] & 0x80) == 0)
        d->memory[0] = 0;
}

static void full_too_early(defect_t *d, datagram_t *g)
{
    if (g->command == ECT_FPWR && g->ado == out_start(g) && g->ado >= ECT_RAM)
        d->memory[0] = g->length < out_size(g);
    else if (g->command == ECT_FPWR && g->ado > out_start(g))
        d->memory[0] = 0;
    else if (g->command == ECT_FPRD && g->ado == SM_0 + ECT_SM_STATUS && d->memory[0] != 0)
        data(g)[0] |= ECT_SM_STATUS_FULL;
}

static void empty_too_early(defect_t *d, datagram_t *g)
{
    if (g->command == ECT_FPRD && g->ado == in_start(g) && g->ado >= ECT_RAM)
        d->memory[0] = g->length > 2 && g->length < in_size(g);
    else if (g->command == ECT_FPRD && g->ado == SM_1 + ECT_SM_STATUS && d->memory[0] != 0)
        data(g)[0] &= (uint8_t)~ECT_SM_STATUS_FULL;
    else if (g->command == ECT_FPWR && g->ado == ECT_REG_AL_CONTROL)
        d->memory[0] = 0;
}

static void last_byte_alone(defect_t *d, datagram_t *g)
{
    (void)d;
    if (g->command == ECT_FPRD && g->length == 1 && g->ado == in_start(g) + in_size(g) - 1)
        set_counter(g, 0);
}

static void disabled_replies(defect_t *d, datagram_t *g)
{
    (void)d;
    if (al_status(g) == 1 && is_mail(g, true))
        set_counter(g, 1);
}

static void off_is_not_seen(defect_t *d, datagram_t *g)
{
    (void)d;
    if (g->command == ECT_FPWR && g->ado == SM_1 + ECT_SM_ACTIVATE && g->length == 1 && data(g)[0] == 0 &&
        al_status(g) == 2)
        hide(g);
}

static void return_hidden(defect_t *d, datagram_t *g)
{
    (void)d;
    if (g->now[ECT_DATAGRAM_COMMAND] == ECT_NOP && g->command != ECT_NOP)
        bring_back(g, 1);
}

/* The toggle does not reach the slave, but the acknowledge is returned. */
static void repeat_is_not_seen(defect_t *d, datagram_t *g)
{
    if (g->command == ECT_FPWR && g->ado == SM_1 + ECT_SM_ACTIVATE && g->length == 1 && (data(g)[0] & 1) != 0 &&
        al_status(g) >= 2) {
        d->memory[0] = (uint32_t)(data(g)[0] & ECT_SM_ACTIVATE_REPEAT);
        hide(g);
    }
}

static void repeat_is_acknowledged(defect_t *d, datagram_t *g)
{
    return_hidden(d, g);
    if (g->command != ECT_FPRD || g->ado != SM_1 + ECT_SM_STATUS || g->length != 3)
        return;
    for (int i = 1; i <= 2; i++)
        data(g)[i] = (uint8_t)((data(g)[i] & 0xFDu) | d->memory[0]);
}

static void second_is_lost(defect_t *d, datagram_t *g)
{
    (void)d;
    if (is_mail(g, true) && (g->chip[SM_1 + ECT_SM_STATUS] & ECT_SM_STATUS_FULL) != 0)
        hide(g);
}

static void length_is_trusted(defect_t *d, datagram_t *g)
{
    (void)d;
    if (is_mail(g, true) && ect_load_le16(data(g)) > out_size(g) - MAIL_HEADER)
        ect_store_le16(data(g), 10);
}

static void logical(defect_t *d, datagram_t *g)
{
    const change_t *c = &d->row->change;
    if (g->command == d->row->command && g->length == d->row->length && counter(g) == c->was)
        set_counter(g, (uint16_t)c->becomes);
}

static void logical_bit(defect_t *d, datagram_t *g)
{
    if (g->command == (d->row->command != 0 ? d->row->command : ECT_LRD) && g->length == d->row->length)
        apply(&d->row->change, data(g) + d->row->at);
}

static void acknowledges_itself(defect_t *d, datagram_t *g)
{
    (void)d;
    if (g->command == ECT_FPWR && g->ado == ECT_REG_AL_CONTROL && (al_status(g) & ECT_AL_ERROR) != 0)
        data(g)[0] |= ECT_AL_ACKNOWLEDGE;
}

static void code_is_late(defect_t *d, datagram_t *g)
{
    if (g->command == ECT_FPRD && g->ado == ECT_REG_AL_STATUS && g->length == 6 && d->memory[0] != 0)
        ect_store_le16(data(g) + 4, 0);
    d->memory[0] = g->command == ECT_FPWR && g->ado == ECT_REG_AL_CONTROL;
}

/* The next object read contains outputs received in SAFEOP. */
static void outputs_move(defect_t *d, datagram_t *g)
{
    if (g->command == ECT_LRW && al_status(g) == 4)
        d->memory[0] = g->sent[ECT_DATAGRAM_DATA];
    else if (is_mail(g, false) && counter(g) == 1 && d->memory[0] != 0 && al_status(g) == 4)
        data(g)[12] = (uint8_t)d->memory[0];
}

static void part_feeds(defect_t *d, datagram_t *g)
{
    uint16_t start = ect_load_le16(g->chip + SM_2);
    if (g->command == ECT_FPWR && g->ado == start)
        d->memory[0] = g->length < ect_load_le16(g->chip + SM_2 + ECT_SM_LENGTH);
    else if (g->command == ECT_FPRD && g->ado == ECT_REG_WD_STATUS_PD && d->memory[0] != 0)
        data(g)[0] |= 1;
    else if (g->command == ECT_LRW)
        d->memory[0] = 0;
}

static void off_expires(defect_t *d, datagram_t *g)
{
    (void)d;
    if (g->command == ECT_FPRD && g->ado == ECT_REG_WD_STATUS_PD && ect_load_le16(g->chip + ECT_REG_WD_TIME_PD) == 0)
        data(g)[0] &= 0xFE;
}

static void sii_changes(defect_t *d, datagram_t *g)
{
    uint16_t first = ect_load_le16(g->chip + ECT_REG_SII_ADDRESS);
    if (g->command == ECT_FPRD && g->ado == ECT_REG_SII_DATA && first <= d->row->address &&
        d->row->address < first + g->length / 2 && d->memory[0]++ > 0)
        data(g)[2 * (d->row->address - first)] ^= 1;
}

static void soe_is_known(defect_t *d, datagram_t *g)
{
    if (is_mail(g, true))
        d->memory[0] = g->sent[ECT_DATAGRAM_DATA + 5] & 0x0F;
    else if (is_mail(g, false) && counter(g) == 1 && (data(g)[5] & 0x0F) == 0 && d->memory[0] == 5)
        data(g)[8] = 4;
}

/* Get Object Description response: the name follows index, data type, max. sub-index and object code. */
static void name_differs(defect_t *d, datagram_t *g)
{
    const uint8_t *mail = data(g);
    if (is_mail(g, false) && counter(g) == 1 && (mail[5] & 0x0F) == 3 && mail[7] >> 4 == 8 && mail[8] == 4 &&
        ect_load_le16(mail + 12) == d->row->address)
        data(g)[18] = 'X';
}

/* Get OD List response, first fragment, list type 0: the number of objects in each list. */
static void list_is_longer(defect_t *d, datagram_t *g)
{
    (void)d;
    uint8_t *mail = data(g);
    if (is_mail(g, false) && counter(g) == 1 && (mail[5] & 0x0F) == 3 && mail[7] >> 4 == 8 && (mail[8] & 0x7F) == 2 &&
        ect_load_le16(mail + 12) == 0)
        mail[14]++;
}

static void foe_error_differs(defect_t *d, datagram_t *g)
{
    (void)d;
    uint8_t *mail = data(g);
    if (is_mail(g, false) && counter(g) == 1 && (mail[5] & 0x0F) == 4 && mail[6] == 5 && mail[8] == 5)
        mail[8] = 4;
}

static void reads_latch(defect_t *d, datagram_t *g)
{
    if (g->command == ECT_FPRD && g->ado == ECT_REG_DC_RECEIVE_TIME)
        data(g)[0] = (uint8_t)(data(g)[0] + ++d->memory[0]);
}

/* After an invalid SDO command, SM0 accepts no further mail until the twin restarts. */
static void mailbox_stops(defect_t *d, datagram_t *g)
{
    if (is_mail(g, true) && d->memory[0] == 0)
        d->memory[0] = (data(g)[5] & 0x0F) == 3 && data(g)[7] >> 4 == 2 && data(g)[8] >> 5 == 7;
    else if (is_mail(g, true))
        hide(g);
}

/* Not a defect: hardware changes the status of a SyncManager at the end of the frame, the twin with the datagram. */
static void record_status(defect_t *d, datagram_t *g)
{
    uint8_t *status = (uint8_t *)d->memory;
    for (unsigned int n = 0; g->sent == d->sent + ETHERNET + 2 && n < SMS; n++)
        status[n] = g->chip[SM_0 + n * ECT_SM_SIZE + ECT_SM_STATUS];
}

static void status_of_the_start(defect_t *d, datagram_t *g)
{
    const uint8_t *status = (const uint8_t *)d->memory;
    for (unsigned int n = 0; g->command == ECT_FPRD && n < SMS; n++) {
        uint16_t address = (uint16_t)(SM_0 + n * ECT_SM_SIZE + ECT_SM_STATUS);
        if (covers(g, address, 1))
            data(g)[address - g->ado] = status[n];
    }
}

/* Each read of the inner bytes of an input buffer returns other bytes. */
static void buffer_is_taken(defect_t *d, datagram_t *g)
{
    const uint8_t *sm = g->chip + SM_3;
    uint16_t start = ect_load_le16(sm), length = ect_load_le16(sm + ECT_SM_LENGTH);
    if (g->command == ECT_FPRD && g->ado == start + 1 && g->length + 2 == length && counter(g) == 1)
        data(g)[0] = (uint8_t)(data(g)[0] + ++d->memory[0]);
}

static void broadcast_does_not_latch(defect_t *d, datagram_t *g)
{
    (void)d;
    if (g->command == ECT_BWR && g->ado == ECT_REG_DC_RECEIVE_TIME)
        hide(g);
}

static void second_pulse_is_first(defect_t *d, datagram_t *g)
{
    (void)d;
    if (g->command == ECT_FPRD && g->ado == ECT_REG_DC_NEXT_SYNC1 && g->length == 8)
        ect_store_le64(data(g), ect_load_le64(data(g)) - ect_load_le32(g->chip + ECT_REG_DC_SYNC1_CYCLE));
}

static void mask_is_ignored(defect_t *d, datagram_t *g)
{
    (void)d;
    ect_store_le16(g->now + ECT_DATAGRAM_IRQ, ect_load_le16(g->chip + ECT_REG_ECAT_EVENT));
}

static void no_interrupt(defect_t *d, datagram_t *g)
{
    (void)d;
    ect_store_le16(g->now + ECT_DATAGRAM_IRQ, 0);
}

static void abort_is_not_seen(defect_t *d, datagram_t *g)
{
    (void)d;
    if (is_mail(g, true) && (data(g)[5] & 0x0F) == 3 && data(g)[8] == 0x80)
        hide(g);
}

/* After a mail of an unknown type, the slave ignores two requests. */
static void type_hangs(defect_t *d, datagram_t *g)
{
    if (is_mail(g, true) && (data(g)[5] & 0x0F) == 13 && d->memory[0] == 0)
        d->memory[0] = 3;
    if (g->command == ECT_FPWR && g->ado == ECT_REG_AL_CONTROL && d->memory[0] > 1) {
        d->memory[0]--;
        hide(g);
    }
}

/* After an unknown command, the slave ignores two requests. */
static void hangs(defect_t *d, datagram_t *g)
{
    if (g->command == UNKNOWN_COMMAND && d->memory[0] == 0)
        d->memory[0] = 3;
    if (g->command == ECT_FPWR && g->ado == ECT_REG_AL_CONTROL && d->memory[0] > 1) {
        d->memory[0]--;
        hide(g);
    }
}

static void address_stays_lost(defect_t *d, datagram_t *g)
{
    bool lost = ect_load_le16(g->chip + ECT_REG_STATION_ADDRESS) == 0;
    if (g->command == ECT_APWR && g->ado == ECT_REG_STATION_ADDRESS && lost && al_status(g) == 4 && d->memory[0]++ == 0)
        hide(g);
}

static void uncounted_hidden(defect_t *d, datagram_t *g)
{
    (void)d;
    if (g->now[ECT_DATAGRAM_COMMAND] == ECT_NOP && g->command != ECT_NOP)
        bring_back(g, 0);
}

/* @return whether the datagram is a mail of EoE; the frame type follows the mailbox header */
static bool is_ethernet(const datagram_t *g, bool to_slave)
{
    return is_mail(g, to_slave) && (to_slave || counter(g) == 1) && (data(g)[5] & 0x0F) == 2;
}

static void gateway_is_not_known(defect_t *d, datagram_t *g)
{
    (void)d;
    if (is_ethernet(g, false) && (data(g)[6] & 0x0F) == 7 && ect_load_le16(data(g)) > 8)
        data(g)[10] &= 0xF7;
}

static void end_is_not_marked(defect_t *d, datagram_t *g)
{
    (void)d;
    if (is_ethernet(g, false) && (data(g)[6] & 0x0F) == 0 && (ect_load_le16(data(g)) - 4) % 32 == 0)
        data(g)[7] &= 0xFE;
}

static void frame_number_is_ignored(defect_t *d, datagram_t *g)
{
    (void)d;
    if (is_ethernet(g, true) && (data(g)[6] & 0x0F) == 0)
        data(g)[9] = (uint8_t)((data(g)[9] & 0x0F) | 0x10);
}

static void cut_address_is_taken(defect_t *d, datagram_t *g)
{
    (void)d;
    if (is_ethernet(g, false) && (data(g)[6] & 0x0F) == 3)
        ect_store_le16(data(g) + 8, 0);
}

/* A fragment that follows an SDO request is lost. */
static void sdo_ends_frame(defect_t *d, datagram_t *g)
{
    if (!is_mail(g, true))
        return;
    if (d->memory[0] == 3 && is_ethernet(g, true) && (data(g)[6] & 0x0F) == 0 && (data(g)[8] & 0x3F) != 0)
        hide(g);
    d->memory[0] = g->sent[ECT_DATAGRAM_DATA + 5] & 0x0F;
}

/* A repeated mail is processed again: its counter becomes 0, which is never compared. */
static void repeat_is_new(defect_t *d, datagram_t *g)
{
    if (!is_ethernet(g, true))
        return;
    const uint8_t number = data(g)[5] >> 4;
    if (number == d->memory[0])
        data(g)[5] &= 0x0F;
    d->memory[0] = number;
}

/* The slave joins the second fragment after a restart with the old first one, still in the RAM of SM0. */
static void half_frame_stays(defect_t *d, datagram_t *g)
{
    enum { FIRST = 32, AT = 10, UNITS = 2 };
    if (g->command == ECT_FPWR && g->ado == ECT_REG_AL_CONTROL && (data(g)[0] & 0x0F) == 1)
        d->memory[0] = 1;
    if (!is_ethernet(g, true) || (data(g)[6] & 0x0F) != 0)
        return;
    uint8_t *mail = data(g);
    const uint16_t size = (uint16_t)(ect_load_le16(mail) - 4);
    if (d->memory[0] != 0 && (mail[8] & 0x3F) == 1 && AT + FIRST + size <= g->length) {
        memmove(mail + AT + FIRST, mail + AT, size);
        memcpy(mail + AT, g->chip + g->ado + AT, FIRST);
        ect_store_le16(mail, (uint16_t)(4 + FIRST + size));
        ect_store_le16(mail + 8, (uint16_t)((ect_load_le16(mail + 8) & 0xF000) | UNITS << 6));
    }
    d->memory[0] = 0;
}

/* Set IP takes the octets in the printed order, and get IP reports them so. */
static void address_is_reversed(const datagram_t *g, uint8_t type)
{
    enum { FLAGS_AT = 10, FIELDS_AT = 14, MAC = 6, HAS_MAC = 1, HAS_IP = 2, FULL = 62 };
    uint8_t *mail = data(g);
    const uint16_t length = ect_load_le16(mail);
    if ((mail[6] & 0x0F) != type || length > g->length - MAIL_HEADER || (mail[FLAGS_AT] & HAS_IP) == 0)
        return;
    const unsigned int at = FIELDS_AT + (length >= FULL || (mail[FLAGS_AT] & HAS_MAC) != 0 ? MAC : 0u);
    if (at + 4u > (unsigned int)length + MAIL_HEADER)
        return;
    const uint8_t octets[] = {mail[at + 3], mail[at + 2], mail[at + 1], mail[at]};
    memcpy(mail + at, octets, sizeof octets);
}

static void set_address_reversed(defect_t *d, datagram_t *g)
{
    (void)d;
    if (is_ethernet(g, true))
        address_is_reversed(g, 2);
}

static void get_address_reversed(defect_t *d, datagram_t *g)
{
    (void)d;
    if (is_ethernet(g, false))
        address_is_reversed(g, 7);
}

/* The last byte of a frame's first fragment changes when AL status was read 50 times since the last mail was. */
static void frame_decays(defect_t *d, datagram_t *g)
{
    enum { READS = 50 };
    if (g->command == ECT_FPRD && covers(g, ECT_REG_AL_STATUS, 1))
        d->memory[0]++;
    if (!is_mail(g, false) || counter(g) != 1)
        return;
    const uint16_t length = ect_load_le16(data(g));
    if (d->memory[0] >= READS && is_ethernet(g, false) && (data(g)[6] & 0x0F) == 0 && length > 4)
        data(g)[MAIL_HEADER + length - 1] ^= 0xFF;
    d->memory[0] = 0;
}

/* After a fragment of the highest number none is taken until INIT. */
static void last_number_ends_frames(defect_t *d, datagram_t *g)
{
    if (g->command == ECT_FPWR && g->ado == ECT_REG_AL_CONTROL && (data(g)[0] & 0x0F) == 1)
        d->memory[0] = 0;
    if (!is_ethernet(g, true) || (data(g)[6] & 0x0F) != 0)
        return;
    if ((data(g)[8] & 0x3F) == 0x3F)
        d->memory[0] = 1;
    if (d->memory[0] != 0)
        hide(g);
}

static void reserved_type_is_done(defect_t *d, datagram_t *g)
{
    (void)d;
    if (is_ethernet(g, false) && (data(g)[6] & 0x0F) >= 0x0A)
        ect_store_le16(data(g) + 8, 0);
}

/* --- the table ---------------------------------------------------------------------------------------------------- */

static const defect_row_t rows[] = {
    {"CF-001", "the chip has an FMMU more than it reports", CUSTOM, .after = one_fmmu_more},
    {"CF-002", "BRD increments ADP twice", CUSTOM, .after = position_twice},
    {"CF-003", "APRD leaves ADP as it is", CUSTOM, .after = position_stays},
    {"CF-004", "every station address is its own for FPRD", CUSTOM, .before = any_station, .after = own_station},
    {"CF-005", "a write to a read-only register counts", COUNT, ECT_FPWR, 0x0000, 4, .change = ANY(2, 1)},
    {"CF-006", "ARMW does not count", COUNT, ECT_ARMW, 0x0600, 4, .change = ANY(2, 0)},
    {"CF-007", "NOP counts", COUNT, ECT_NOP, 0x0600, 4, .change = ANY(2, 8)},
    {"CF-008", "a read behind the end of the RAM counts", CUSTOM, .after = behind_the_ram},
    {"CF-009", "the AL status code can be written", CUSTOM, .address = ECT_REG_AL_STATUS_CODE, .after = keep_written},
    {"CF-010", "DL status does not report that the SII is loaded", ANSWER, ECT_FPRD, ECT_REG_DL_STATUS, 2,
     .change = CLEARED(1)},
    {"CF-011", "an error counter stops at 127", ANSWER, ECT_FPRD, ECT_REG_PROCESSING_ERROR, 1,
     .change = FROM(1, 255, 127)},
    {"CF-012", "a reset sequence does not get beyond its first letter", ANSWER, ECT_FPRD, ECT_REG_RESET_ECAT, 1,
     .change = FROM(1, 2, 1)},
    {"CF-013", "a datagram without data counts", COUNT, ECT_FPRD, 0x0000, 0, .change = ANY(2, 1)},
    {"CF-014", "the circulating flag is taken away", CUSTOM, .after = no_circulating},
    {"CF-015", "the tenth datagram of a frame does not count", CUSTOM, .after = tenth_is_lost},
    {"CF-016", "the mailbox is full before its last byte", CUSTOM, .after = full_too_early},
    {"CF-017", "the mailbox is empty before its last byte", CUSTOM, .after = empty_too_early},
    {"CF-018", "the last byte of a mail cannot be read alone (needs a reply shorter than the mailbox)", CUSTOM,
     .after = last_byte_alone},
    {"CF-019", "the number of the output buffer never changes (needs outputs)", ANSWER, ECT_FPRD, SM_2 + ECT_SM_STATUS,
     1, .change = CLEARED(0x30)},
    {"CF-019b", "the slave writes the input buffer that the master reads", CUSTOM, .after = buffer_is_taken},
    {"CF-020", "a SyncManager does not show that it was written", ANSWER, ECT_FPRD, SM_1 + ECT_SM_STATUS, 1,
     .change = CLEARED(1)},
    {"CF-021", "a SyncManager that the slave disabled answers", CUSTOM, .after = disabled_replies},
    {"CF-022", "SM1 switched off is not noticed", CUSTOM, .before = off_is_not_seen, .after = return_hidden},
    {"CF-023", "a repeat is acknowledged and not done", CUSTOM, .before = repeat_is_not_seen,
     .after = repeat_is_acknowledged},
    {"CF-024", "the counter of mails comes by 0", MAIL, .length = ANY_MAIL, .at = 5, .change = BITS(0x70, 0x70, 0)},
    {"CF-025", "a request while a reply waits is lost", CUSTOM, .before = second_is_lost, .after = return_hidden},
    {"CF-026", "a length beyond the mailbox is accepted", CUSTOM, .before = length_is_trusted},
    {"CF-027", "SM0 has no length in the SyncManager category", CATEGORY, .address = ECT_SII_SYNCM, .length = 2,
     .change = ANY(2, 0)},
    {"CF-028", "LRD changes a byte that is not mapped", CUSTOM, .length = 16, .at = 0, .change = FLIPPED(1),
     .after = logical_bit},
    {"CF-029", "LRD of bits changes another one", CUSTOM, .length = 4, .at = 3, .change = FLIPPED(1),
     .after = logical_bit},
    {"CF-030", "the mailbox state takes a second bit", CUSTOM, .length = 1, .at = 0, .change = FLIPPED(0x80),
     .after = logical_bit},
    {"CF-031", "LRD counts without an FMMU", CUSTOM, .command = ECT_LRD, .length = 4, .change = FROM(2, 0, 1),
     .after = logical},
    {"CF-032", "LRW over two slaves counts one too few (needs two slaves)", CUSTOM, .command = ECT_LRW, .length = 16,
     .change = FROM(2, 6, 5), .after = logical},
    {"CF-033", "INIT is reached with a code", ANSWER, ECT_FPRD, ECT_REG_AL_STATUS_CODE, 2, 1, .change = ANY(2, 0x11)},
    {"CF-034", "SAFEOP refuses with another code", .state = 0x14, AL_CODE(0x11, 0x12)},
    {"CF-035", "an unknown state is refused as an invalid change", AL_CODE(0x12, 0x11)},
    {"CF-036", "a wrong mailbox is refused with 0x0017", .state = 0x11, AL_CODE(0x16, 0x17)},
    {"CF-037", "wrong inputs are refused as wrong outputs", .state = 0x12, AL_CODE(0x1E, 0x1D)},
    {"CF-038", "a request acknowledges by itself", CUSTOM, .before = acknowledges_itself},
    {"CF-039", "an acknowledge takes no other state", REQUEST, ECT_FPWR, ECT_REG_AL_CONTROL, 2, 0x12,
     .change = FROM(1, 0x14, 0x12)},
    {"CF-040", "the code comes after the error flag", CUSTOM, .after = code_is_late},
    {"CF-041", "INIT in INIT is an unknown state", REQUEST, ECT_FPWR, ECT_REG_AL_CONTROL, 2, 1,
     .change = FROM(1, 0x01, 0x05)},
    {"CF-042", "a watchdog has the code of synchronisation (needs outputs)", AL_CODE(0x1B, 0x1A)},
    {"CF-046", "the identification value is 0 (needs --alias)", ANSWER, ECT_FPRD, ECT_REG_AL_STATUS_CODE, 2, 2,
     .change = ANY(2, 0)},
    {"CF-048", "outputs move in SAFEOP (needs outputs)", CUSTOM, .after = outputs_move},
    {"CF-049", "the watchdog counter wraps (needs outputs)", ANSWER, ECT_FPRD, ECT_REG_WD_COUNTER_PD, 1,
     .change = FROM(1, 255, 14)},
    {"CF-050", "a watchdog that is off expires (needs outputs)", CUSTOM, .after = off_expires},
    {"CF-051", "the second expiry counts twice (needs outputs)", ANSWER, ECT_FPRD, ECT_REG_WD_COUNTER_PD, 1,
     .change = FROM(1, 2, 3)},
    {"CF-052", "a part of the outputs feeds the watchdog (needs outputs)", CUSTOM, .after = part_feeds},
    {"CF-053", "the PDI watchdog shows expired", ANSWER, ECT_FPRD, ECT_REG_DL_STATUS, 2, .change = CLEARED(2)},
    {"CF-054", "the check value of the SII is wrong", SII_WORD, .address = 7, .change = ANY(1, 0x5A)},
    {"CF-055", "a bad EEPROM command makes no error", ANSWER, ECT_FPRD, ECT_REG_SII_CONTROL + 1, 2,
     .change = CLEARED(0x20)},
    {"CF-056", "a write without enable makes no error", ANSWER, ECT_FPRD, ECT_REG_SII_CONTROL + 1, 2,
     .change = CLEARED(0x40)},
    {"CF-057", "the serial number of the SII is another", SII_WORD, .address = 14, .change = ANY(2, 0x4711)},
    {"CF-058", "a protocol that is not there gets error 0x0004", MAIL, .length = ANY_MAIL, .at = 6,
     .change = FROM(4, 0x00020001, 0x00040001)},
    {"CF-059", "the SII has version 9", SII_WORD, .address = 0x3F, .change = ANY(2, 9)},
    {"CF-060", "SM0 reaches into SM1 in the SyncManager category", CATEGORY, .address = ECT_SII_SYNCM, .length = 3,
     .change = ANY(1, 2)},
    {"CF-061", "an entry of the SII has another sub-index", CATEGORY, .address = ECT_SII_RXPDO, .length = 10,
     .change = ANY(1, 0x77)},
    {"CF-062", "a clock mode has a name that does not exist (needs clock modes)", CATEGORY, .address = ECT_SII_DC,
     .length = 18, .change = ANY(1, 0xF0)},
    {"CF-064", "a string of the General category does not exist", CATEGORY, .address = ECT_SII_GENERAL, .length = 2,
     .change = ANY(1, 0xF0)},
    {"CF-065", "the alias register shows another alias", ANSWER, ECT_FPRD, ECT_REG_STATION_ALIAS, 2,
     .change = ANY(2, 0x4711)},
    {"CF-066", "a word of the SII changes", CUSTOM, .address = 0x10, .after = sii_changes},
    {"CF-067", "1C00h:01 is a mailbox to the master", SDO(0x1C00, 1, 12), .command = 0x4F, .change = ANY(1, 2)},
    {"CF-068", "behind the last of 1C00h there is no object (needs SDO information)", SDO(0x1C00, 5, 12),
     .command = 0x80, .change = ANY(4, 0x06020000)},
    {"CF-069", "1000h has three bytes (needs SDO information)", SDO(0x1000, 0, 8), .command = 0x43,
     .change = ANY(1, 0x47)},
    {"CF-070", "a write to 1018h:01 is refused as unsupported", SDO(0x1018, 1, 12),
     .change = FROM(4, 0x06010002, 0x06010000)},
    {"CF-071", "an abort has another command", SDO(0x1018, 0x55, 8), .command = 0x80, .change = ANY(1, 0x8F)},
    {"CF-072", "an unknown command is refused as a timeout", SDO(0x1018, 1, 12),
     .change = FROM(4, 0x05040001, 0x05040000)},
    {"CF-072b", "a transfer goes on after the master aborted it (needs an object longer than the mailbox)", CUSTOM,
     .before = abort_is_not_seen, .after = return_hidden},
    {"CF-073", "a complete upload of 1018h has a wrong count (needs Complete Access)", SDO(0x1018, 0, 16),
     .command = 0x51, .change = ANY(1, 3)},
    {"CF-074", "a fixed assignment is refused for no reason (needs 1C12h)", SDO(0x1C12, 0, 12), .command = 0x80,
     .change = ANY(4, 0x08000000)},
    {"CF-076", "list 0 reports one object too many (needs SDO information)", CUSTOM, .after = list_is_longer},
    {"CF-077", "1018h has another name than in the ESI (needs SDO information)", CUSTOM, .address = 0x1018,
     .after = name_differs},
    {"CF-078", "a write in the wrong state is a general error (needs 1C32h)", SDO(0x1C32, 1, 12), .state = 4,
     .command = 0x80, .change = ANY(4, 0x08000000)},
    {"CF-082", "no synchronisation type is supported (needs 1C32h)", SDO(0x1C32, 4, 12), .command = 0x4B,
     .change = ANY(2, 0)},
    {"CF-083", "1018h:03 is another in OP", SDO(0x1018, 3, 12), .state = 8, .command = 0x43, .change = ANY(1, 0x99)},
    {"CF-084", "a FoE packet out of order is refused as an illegal operation (needs --files)", CUSTOM,
     .after = foe_error_differs},
    {"CF-086", "SoE gets error 0x0004", CUSTOM, .after = soe_is_known},
    {"CF-087", "a read latches the receive time", CUSTOM, .after = reads_latch},
    {"CF-087b", "BWR does not latch the receive times", CUSTOM, .before = broadcast_does_not_latch,
     .after = return_hidden},
    {"CF-087c", "the receive time of the processing unit has no upper half", ANSWER, ECT_FPRD,
     ECT_REG_DC_RECEIVE_TIME_UNIT + 4, 8, .change = ANY(4, 0)},
    {"CF-088", "the difference of the clocks has the other sign", ANSWER, ECT_FPRD, ECT_REG_DC_DIFFERENCE + 3, 4,
     .change = FLIPPED(0x80)},
    {"CF-088b", "the propagation delay has no effect", SWALLOW, ECT_FPWR, ECT_REG_DC_DELAY, 4, .change = ANY(2, 1)},
    {"CF-089", "SYNC0 is a nanosecond beside its grid", ANSWER, ECT_FPRD, ECT_REG_DC_START_TIME, 8,
     .change = FLIPPED(1)},
    {"CF-089b", "SYNC1 comes with SYNC0, without its shift", CUSTOM, .after = second_pulse_is_first},
    {"CF-089c", "0x098E shows a pulse with SYNC0 off", ANSWER, ECT_FPRD, ECT_REG_DC_SYNC0_STATUS, 1,
     .change = ANY(1, 1)},
    {"CF-092", "a cycle is refused as a wrong mailbox (needs clock modes)", AL_CODE(0x36, 0x16)},
    {"CF-094", "an unknown command stops the slave", CUSTOM, .before = hangs, .after = return_hidden},
    {"CF-094b", "a mail of type 13 stops the slave", CUSTOM, .before = type_hangs, .after = return_hidden},
    {"CF-095", "two SyncManagers in one write are not taken", SWALLOW, ECT_FPWR, ECT_REG_SM, 16, .change = ANY(2, 1)},
    {"CF-096", "in SAFEOP a lost address is not given again at once", CUSTOM, .before = address_stays_lost,
     .after = uncounted_hidden},
    {"CF-096b", "a lost link is not counted (needs --plug of ectwin-conform)", ANSWER, ECT_APRD, ECT_REG_LOST_LINK, 4,
     .change = ANY(4, 0)},
    {"CF-097", "the event of AL status stays when AL status is read", ANSWER, ECT_FPRD, ECT_REG_ECAT_EVENT, 2,
     .change = {.how = ALWAYS, .width = 1, .mask = 8, .becomes = 8}},
    {"CF-097b", "events are in the IRQ field whatever their mask", CUSTOM, .after = mask_is_ignored},
    {"CF-097c", "the IRQ field is always 0", CUSTOM, .after = no_interrupt},
    {"CF-098", "mails have a foreign address", MAIL, .length = ANY_MAIL, .at = 2, .change = ANY(2, 0x7777)},
    {"CF-098b", "mails have channel 1", MAIL, .length = ANY_MAIL, .at = 4, .change = ANY(1, 1)},
    {"CF-A01", "AoE reads another value than CoE (needs AoE)", CUSTOM, .after = defect_ads_value_is_wrong},
    {"CF-A02", "each result of AoE is 0 (needs AoE)", CUSTOM, .after = defect_ads_refuses_nothing},
    {"CF-S01", "an unknown IDN gets a general error (needs SoE)", CUSTOM, .after = defect_idn_is_known},
    {"CF-S02", "an attribute has another width (needs SoE)", CUSTOM, .after = defect_width_is_wrong},
    {"CF-S03", "a write of too many bytes is confirmed (needs SoE)", CUSTOM, .after = defect_long_value_is_taken},
    {"CF-S04", "an unknown drive is an unknown IDN (needs SoE)", CUSTOM, .after = defect_drive_is_known},
    {"CF-S05", "mails behind the present one are always 1 (needs SoE)", CUSTOM, .after = defect_pieces_are_not_counted},
    {"CF-S06", "an attribute that is read alone has another width (needs SoE)", CUSTOM,
     .after = defect_width_alone_is_wrong},
    {"CF-E01", "the gateway is not reported (needs EoE)", CUSTOM, .after = gateway_is_not_known},
    {"CF-E02", "a last fragment of whole units is not marked as the last (needs EoE)", CUSTOM,
     .after = end_is_not_marked},
    {"CF-E03", "frame numbers of fragments are ignored (needs EoE)", CUSTOM, .before = frame_number_is_ignored},
    {"CF-E04", "a repeated mail is taken as a new one (needs EoE)", CUSTOM, .before = repeat_is_new},
    {"CF-E05", "a cut set IP is answered as done (needs EoE)", CUSTOM, .after = cut_address_is_taken},
    {"CF-E06", "set IP and get IP have the octets in the printed order (needs EoE)", CUSTOM,
     .before = set_address_reversed, .after = get_address_reversed},
    {"CF-E07", "an SDO between two fragments ends the frame (needs EoE)", CUSTOM, .before = sdo_ends_frame,
     .after = return_hidden},
    {"CF-E08", "the first fragment outlasts INIT (needs EoE)", CUSTOM, .before = half_frame_stays},
    {"CF-E09", "a frame is damaged that the master fetches late (needs EoE)", CUSTOM, .after = frame_decays},
    {"CF-E10", "a fragment of number 63 ends the frames until INIT (needs EoE)", CUSTOM,
     .before = last_number_ends_frames, .after = return_hidden},
    {"CF-E11", "the General category has EoE inverted", CATEGORY, .address = ECT_SII_GENERAL, .length = 7,
     .change = FLIPPED(1)},
    {"CF-E12", "a reserved type is answered as done (needs EoE)", CUSTOM, .after = reserved_type_is_done},
    {"CF-M01", "F030h:01 reads as empty (needs module idents)", SDO(0xF030, 1, 12), .command = 0x43,
     .change = ANY(4, 0)},
    {"CF-M02", "unlike modules are refused with the code of a missing one (needs module idents)", AL_CODE(0x70, 0x71)},
    {"CF-M02b", "F030h in SAFEOP is a general error (needs module idents)", SDO(0xF030, 1, 12), .state = 4,
     .command = 0x80, .change = ANY(4, 0x08000000)},
    {"CF-M03", "the TxPDO toggle stands still (needs one in the first bit of 3 bytes of inputs)", CUSTOM,
     .command = ECT_LRW, .length = 3, .change = CLEARED(1), .after = logical_bit},
};

/* For tests of the runner. */
static const defect_row_t runner_rows[] = {
    {"DEAD-MAILBOX", "an unknown SDO command ends the mailbox until the twin restarts", CUSTOM, .before = mailbox_stops,
     .after = uncounted_hidden},
    {"END-OF-FRAME", "no defect: SyncManagers change their status at the end of the frame, as chips do", CUSTOM,
     .before = record_status, .after = status_of_the_start},
};

/* --- the filter --------------------------------------------------------------------------------------------------- */

static const defect_row_t *row_at(size_t n)
{
    const size_t count = sizeof rows / sizeof rows[0];
    const size_t runner = count + defect_drive_count;
    if (n < count)
        return &rows[n];
    if (n < runner)
        return &defect_drive_rows[n - count];
    return n - runner < sizeof runner_rows / sizeof runner_rows[0] ? &runner_rows[n - runner] : NULL;
}

bool defect_choose(defect_t *defect, const char *id)
{
    for (size_t n = 0; row_at(n); n++) {
        if (strcmp(row_at(n)->id, id) == 0) {
            defect->row = row_at(n);
            return true;
        }
    }
    return false;
}

void defect_list(void (*visit)(void *ctx, const char *id, const char *what), void *ctx)
{
    for (size_t n = 0; row_at(n); n++)
        visit(ctx, row_at(n)->id, row_at(n)->what);
}

static bool concerns(const defect_row_t *row, const datagram_t *g)
{
    if (row->state != 0 && row->state != al_status(g))
        return false;
    return g->command == row->command && g->length == row->length && (g->length == 0 || covers(g, row->address, 1));
}

/* @return whether a mail has the index, sub-index and command of a row */
static bool about(const defect_row_t *row, const uint8_t *mail)
{
    unsigned int service = mail[7] >> 4;
    return (mail[5] & 0x0F) == 3 && (service == 2 || service == 3) && ect_load_le16(mail + 9) == row->address &&
           mail[11] == row->length && (row->command == 0 || mail[8] == row->command);
}

static void change_mail(const defect_row_t *row, const datagram_t *g)
{
    uint8_t *mail = data(g);
    if (!is_mail(g, false) || counter(g) == 0 || (row->state != 0 && row->state != al_status(g)))
        return;
    if (row->length == ANY_MAIL || about(row, mail))
        apply(&row->change, mail + row->at);
}

static void change_sii(const defect_row_t *row, const datagram_t *g, uint32_t byte)
{
    uint32_t first = 2u * ect_load_le16(g->chip + ECT_REG_SII_ADDRESS);
    if (g->command == ECT_FPRD && g->ado == ECT_REG_SII_DATA && byte >= first &&
        byte + row->change.width <= first + g->length)
        apply(&row->change, data(g) + (byte - first));
}

static void change_category(const defect_row_t *row, const datagram_t *g)
{
    size_t length;
    const uint8_t *category = ect_sii_category(g->config->sii, g->config->sii_size, row->address, &length);
    if (!category && row->address == ECT_SII_RXPDO) /* a device without outputs */
        category = ect_sii_category(g->config->sii, g->config->sii_size, ECT_SII_TXPDO, &length);
    if (category && row->length < length)
        change_sii(row, g, (uint32_t)(category - g->config->sii) + row->length);
}

static void before_one(defect_t *d, datagram_t *g)
{
    const defect_row_t *row = d->row;
    if (row->before)
        row->before(d, g);
    else if (row->kind == REQUEST && concerns(row, g))
        apply(&row->change, data(g) + (row->address - g->ado));
    else if (row->kind == SWALLOW && concerns(row, g))
        hide(g);
}

static void after_one(defect_t *d, datagram_t *g)
{
    const defect_row_t *row = d->row;
    if (row->after)
        row->after(d, g);
    else if (row->kind == SWALLOW)
        return_hidden(d, g);
    else if (row->kind == MAIL)
        change_mail(row, g);
    else if (row->kind == SII_WORD)
        change_sii(row, g, 2u * row->address);
    else if (row->kind == CATEGORY)
        change_category(row, g);
    else if (row->kind == COUNT && concerns(row, g))
        set_counter(g, (uint16_t)row->change.becomes);
    else if (row->kind == ANSWER && concerns(row, g) && counter(g) != 0)
        apply(&row->change, data(g) + (row->address - g->ado));
}

static void walk(defect_t *d, ect_chain_t *chain, uint8_t *frame, void (*one)(defect_t *d, datagram_t *g))
{
    const ect_esc_t *esc = ect_chain_esc(chain, 0);
    size_t at = ETHERNET + 2;
    bool more = true;
    while (more && at + ECT_DATAGRAM_DATA + ECT_DATAGRAM_COUNTER <= d->length) {
        const uint8_t *sent = d->sent + at;
        uint16_t length = ect_datagram_length(sent);
        if (at + ECT_DATAGRAM_DATA + length + ECT_DATAGRAM_COUNTER > d->length)
            return;
        datagram_t g = {.sent = sent,
                        .now = frame + at,
                        .command = sent[ECT_DATAGRAM_COMMAND],
                        .adp = ect_load_le16(sent + ECT_DATAGRAM_ADP),
                        .ado = ect_load_le16(sent + ECT_DATAGRAM_ADO),
                        .length = length,
                        .chip = esc->memory,
                        .config = &esc->config};
        one(d, &g);
        more = (sent[ECT_DATAGRAM_LENGTH + 1] & 0x80) != 0;
        at += (size_t)ECT_DATAGRAM_DATA + length + ECT_DATAGRAM_COUNTER;
    }
}

void defect_before(void *ctx, ect_chain_t *chain, uint8_t *frame, size_t length)
{
    defect_t *defect = ctx;
    bool ethercat = length >= ETHERNET + 2 && length <= DEFECT_FRAME && ect_load_be16(frame + 12) == 0x88A4 &&
                    frame[ETHERNET + 1] >> 4 == 1;
    defect->length = defect->row && ethercat ? length : 0;
    memcpy(defect->sent, frame, defect->length);
    if (defect->length > 0)
        walk(defect, chain, frame, before_one);
}

void defect_after(void *ctx, ect_chain_t *chain, uint8_t *frame, size_t length)
{
    defect_t *defect = ctx;
    if (defect->length == length && length > 0)
        walk(defect, chain, frame, after_one);
}
