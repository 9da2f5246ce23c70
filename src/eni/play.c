/* SPDX-License-Identifier: MIT */
/* Transitions of a player: the commands, their order, and the check of their replies. */
#include "eni/play.h"

#include <string.h>

#include "eni/player.h"
#include "esc/route.h"
#include "wire/bytes.h"
#include "wire/registers.h"

enum { NUMBER_BYTES = 8, REPEATS = 4, WAIT_MS = 1, TIME_BYTES = 8, START_NS = 1000000 };

static uint64_t number_of(const uint8_t *bytes, const uint8_t *mask, size_t length)
{
    uint64_t number = 0;
    for (size_t i = 0; i < length && i < NUMBER_BYTES; i++)
        number |= (uint64_t)(bytes[i] & (mask != NULL ? mask[i] : 0xFF)) << 8 * i;
    return number;
}

static bool equal(const uint8_t *reply, const ect_eni_validate_t *v)
{
    for (size_t i = 0; i < v->data.length; i++) {
        if (((reply[i] ^ v->data.bytes[i]) & (v->mask.bytes != NULL ? v->mask.bytes[i] : 0xFF)) != 0)
            return false;
    }
    return true;
}

/* Compares, as the file requires, with or without a sign, which is the highest bit of the last byte. */
static bool greater(const uint8_t *reply, const ect_eni_validate_t *v)
{
    const size_t length = v->data.length < NUMBER_BYTES ? v->data.length : NUMBER_BYTES;
    const uint64_t sign = v->is_signed && length > 0 ? UINT64_C(1) << (8 * length - 1) : 0;
    return (number_of(reply, v->mask.bytes, length) ^ sign) > (number_of(v->data.bytes, v->mask.bytes, length) ^ sign);
}

static bool fits(const uint8_t *reply, const ect_eni_validate_t *v)
{
    if (!v->given || v->compare == ECT_ENI_NONE)
        return true;
    const bool same = equal(reply, v);
    switch (v->compare) {
    case ECT_ENI_NOT_EQ:
        return !same;
    case ECT_ENI_G:
        return greater(reply, v);
    case ECT_ENI_L:
        return !same && !greater(reply, v);
    case ECT_ENI_EQ_OR_G:
        return same || greater(reply, v);
    case ECT_ENI_EQ_OR_L:
        return same || !greater(reply, v);
    default:
        return same;
    }
}

static bool is_start_time(const ect_eni_command_t *command)
{
    return (command->command == ECT_FPWR || command->command == ECT_APWR) && command->ado == ECT_REG_DC_START_TIME &&
           command->data.length == TIME_BYTES;
}

/* A file has only the shift of the first SYNC signal. The master adds the system time, because no signal starts in the
 * past. */
static void add_time(ect_eni_player_t *p, eni_datagram_t *datagram, uint8_t start[TIME_BYTES])
{
    static const uint8_t zeros[TIME_BYTES];
    const eni_datagram_t read = {.command = datagram->command == ECT_FPWR ? ECT_FPRD : ECT_APRD,
                                 .length = TIME_BYTES,
                                 .address = (datagram->address & UINT16_MAX) | (uint32_t)ECT_REG_DC_SYSTEM_TIME << 16,
                                 .data = zeros};
    const uint8_t *time = NULL;
    if (eni_exchange(p, &read, &time) != 1)
        return;
    ect_store_le64(start, ect_load_le64(datagram->data) + ect_load_le64(time) + START_NS);
    datagram->data = start;
}

/* Sends a command until its reply is as expected, at most for the time in the file. */
static void play_command(ect_eni_player_t *p, const ect_eni_command_t *command)
{
    eni_datagram_t datagram = eni_datagram_of(command);
    uint8_t start[TIME_BYTES];
    const ect_eni_validate_t *v = &command->validate;
    const uint32_t most = v->given && v->timeout_ms > 0 ? eni_bounded_timeout(v->timeout_ms) / WAIT_MS + 1 : REPEATS;
    const uint8_t *reply = NULL;
    int counter = -1;
    if (is_start_time(command))
        add_time(p, &datagram, start);
    for (uint32_t i = 0; i < most; i++) {
        if (i > 0)
            eni_wait(p);
        counter = eni_exchange(p, &datagram, &reply);
        const bool counted = counter >= 0 && (command->counter < 0 || counter == command->counter);
        if (counted && fits(reply, v))
            return;
    }
    if (counter < 0)
        eni_report(p, command->line, "%s: no frame returns", command->comment);
    else if (command->counter >= 0 && counter != command->counter)
        eni_report(p, command->line, "%s: the working counter is %d, not %d", command->comment, counter,
                   command->counter);
    else
        eni_report(p, command->line, "%s: the reply is 0x%llX, which Validate refuses", command->comment,
                   (unsigned long long)number_of(reply, v->mask.bytes, v->data.length));
}

static void play_commands(ect_eni_player_t *p, const ect_eni_command_t *commands, size_t count, unsigned int transition)
{
    for (size_t i = 0; i < count; i++) {
        if ((commands[i].transitions & transition) != 0)
            play_command(p, &commands[i]);
    }
}

static void play_master(ect_eni_player_t *p, unsigned int transition, bool before)
{
    const ect_eni_network_t *network = ect_eni_network(p->eni);
    for (size_t i = 0; i < network->command_count; i++) {
        if (network->commands[i].before_slave == before)
            play_commands(p, &network->commands[i], 1, transition);
    }
}

static void play_mails(ect_eni_player_t *p, size_t slave, unsigned int transition)
{
    const ect_eni_mailbox_t *mailbox = &ect_eni_network(p->eni)->slaves[slave].mailbox;
    for (size_t i = 0; i < mailbox->command_count; i++) {
        if ((mailbox->commands[i].transitions & transition) != 0 && !mailbox->commands[i].disabled)
            eni_play_coe(p, slave, &mailbox->commands[i]);
    }
    for (size_t i = 0; i < mailbox->mail_count; i++) {
        const ect_eni_mail_t *mail = &mailbox->mails[i];
        const bool sent = (mail->transitions & transition) != 0 && mail->protocol != ECT_MAILBOX_TYPE_FOE;
        if (!sent || mail->disabled)
            continue;
        if (mail->protocol == ECT_MAILBOX_TYPE_SOE)
            eni_play_soe(p, slave, mail);
        else
            eni_play_mail(p, slave, mail);
    }
}

/* --- slaves without register commands ------------------------------------------------------------------------------
 */

static bool write_registers(ect_eni_player_t *p, uint8_t command, uint16_t address, uint16_t at, const uint8_t *bytes,
                            uint16_t length)
{
    const uint8_t *reply;
    const eni_datagram_t write = {
        .command = command, .address = address | (uint32_t)at << 16, .length = length, .data = bytes};
    return eni_exchange(p, &write, &reply) == 1;
}

/* @return AL status, and its code in the upper half; 0: no reply */
static uint32_t al_status(ect_eni_player_t *p, uint16_t address)
{
    enum { STATUS_AND_CODE = 6 };
    static const uint8_t zeros[STATUS_AND_CODE];
    const eni_datagram_t read = {.command = ECT_FPRD,
                                 .address = address | (uint32_t)ECT_REG_AL_STATUS << 16,
                                 .length = STATUS_AND_CODE,
                                 .data = zeros};
    const uint8_t *reply;
    return eni_exchange(p, &read, &reply) == 1 ? ect_load_le16(reply) | (uint32_t)ect_load_le16(reply + 4) << 16 : 0;
}

static void put_mailbox(uint8_t sm[8], const ect_eni_box_t *box, uint8_t control)
{
    enum { ENABLE = 1 << 16 };
    ect_store_le16(sm, box->start);
    ect_store_le16(sm + 2, box->length);
    ect_store_le32(sm + 4, control | ENABLE);
}

/* A file may have CoE commands only. Its master then brings the slave to PREOP without commands, with the mailbox of
 * the file. */
static void start_slave(ect_eni_player_t *p, size_t i)
{
    enum { MAILBOX_OUT = 0x26, MAILBOX_IN = 0x22, PREOP = 2, STATE = 0x1F, WAITS = 1000 };
    const ect_eni_slave_t *slave = &ect_eni_network(p->eni)->slaves[i];
    const uint16_t station = eni_station(slave, i);
    uint8_t address[2], sms[16], request[2] = {PREOP, 0};
    uint32_t status = 0;
    ect_store_le16(address, station);
    put_mailbox(sms, &slave->mailbox.send, MAILBOX_OUT);
    put_mailbox(sms + 8, &slave->mailbox.receive, MAILBOX_IN);
    if (!write_registers(p, ECT_APWR, (uint16_t)(0u - i), ECT_REG_STATION_ADDRESS, address, sizeof address) ||
        !write_registers(p, ECT_FPWR, station, ECT_REG_SM, sms, sizeof sms) ||
        !write_registers(p, ECT_FPWR, station, ECT_REG_AL_CONTROL, request, sizeof request)) {
        eni_report(p, slave->line, "slave %zu does not reply", i + 1);
        return;
    }
    for (unsigned int n = 0; n < WAITS && (status & STATE) != PREOP; n++) {
        eni_wait(p);
        status = al_status(p, station);
        if ((status & STATE) > PREOP)
            break;
    }
    if ((status & STATE) != PREOP)
        eni_report(p, slave->line,
                   "slave %zu does not enter PREOP with the mailbox of the file: AL status 0x%04X, code "
                   "0x%04X",
                   i + 1, (unsigned int)(status & UINT16_MAX), (unsigned int)(status >> 16));
}

static void start_slaves(ect_eni_player_t *p)
{
    const ect_eni_network_t *network = ect_eni_network(p->eni);
    for (size_t i = 0; i < network->slave_count; i++) {
        const ect_eni_slave_t *slave = &network->slaves[i];
        if (slave->command_count == 0 && slave->mailbox.command_count + slave->mailbox.mail_count > 0 &&
            slave->mailbox.send.length > 0 && slave->mailbox.receive.length > 0)
            start_slave(p, i);
    }
}

static void play_transition(ect_eni_player_t *p, unsigned int transition)
{
    const ect_eni_network_t *network = ect_eni_network(p->eni);
    play_master(p, transition, true);
    for (size_t i = 0; i < network->slave_count; i++) {
        if (transition != ECT_ENI_IP)
            play_mails(p, i, transition);
        play_commands(p, network->slaves[i].commands, network->slaves[i].command_count, transition);
    }
    play_master(p, transition, false);
    if (transition == ECT_ENI_IP)
        start_slaves(p);
    for (size_t i = 0; transition == ECT_ENI_IP && i < network->slave_count; i++)
        play_mails(p, i, transition);
}

bool ect_eni_play(ect_eni_player_t *p, unsigned int state)
{
    static const struct {
        unsigned int transition, state;
    } steps[] = {{ECT_ENI_IP, ECT_ENI_PREOP}, {ECT_ENI_PS, ECT_ENI_SAFEOP}, {ECT_ENI_SO, ECT_ENI_OPERATIONAL}};
    ECT_ASSERT(state >= p->state && state <= ECT_ENI_OPERATIONAL);
    for (size_t i = 0; i < sizeof steps / sizeof steps[0]; i++) {
        const size_t before = p->reported;
        if (steps[i].state <= p->state || steps[i].state > state)
            continue;
        play_transition(p, steps[i].transition);
        if (p->reported != before)
            return false;
        p->state = steps[i].state;
    }
    return true;
}
