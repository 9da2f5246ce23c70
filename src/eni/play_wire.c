/* SPDX-License-Identifier: MIT */
/* Datagrams of a player: frames sent and replies received. */
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "eni/player.h"
#include "esc/route.h"
#include "wire/bytes.h"

enum { ETHERNET = 14, AT_TYPE = 12, AT_DATAGRAM = 16, SHORTEST = 60, ETHERTYPE = 0x88A4, COMMANDS = 0x1000 };
enum { MORE = 0x8000, LINE = 400, NS_PER_MS = 1000000 };

void eni_report(ect_eni_player_t *p, int line, const char *format, ...)
{
    char text[LINE];
    va_list values;
    int length = snprintf(text, sizeof text, "%.200s:%d: ", ect_eni_file(p->eni), line);
    va_start(values, format);
    (void)vsnprintf(text + length, sizeof text - (size_t)length, format, values);
    va_end(values);
    p->reported++;
    p->wire->report(p->wire->ctx, text);
}

void eni_frame_begin(eni_frame_t *f)
{
    static const uint8_t addresses[AT_TYPE] = {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0x02, 0, 0, 0, 0, 0x01};
    memcpy(f->bytes, addresses, sizeof addresses);
    ect_store_be16(f->bytes + AT_TYPE, ETHERTYPE);
    f->length = AT_DATAGRAM;
    f->last = 0;
}

size_t eni_frame_add(eni_frame_t *f, uint8_t index, const eni_datagram_t *datagram)
{
    uint8_t *at = f->bytes + f->length;
    ECT_ASSERT(f->length + ECT_DATAGRAM_DATA + datagram->length + ECT_DATAGRAM_COUNTER <= ECT_ENI_FRAME);
    if (f->last != 0)
        ect_store_le16(f->bytes + f->last + ECT_DATAGRAM_LENGTH,
                       (uint16_t)(ect_load_le16(f->bytes + f->last + ECT_DATAGRAM_LENGTH) | MORE));
    at[ECT_DATAGRAM_COMMAND] = datagram->command;
    at[1] = index;
    ect_store_le32(at + ECT_DATAGRAM_ADP, datagram->address);
    ect_store_le16(at + ECT_DATAGRAM_LENGTH, datagram->length);
    ect_store_le16(at + ECT_DATAGRAM_IRQ, 0);
    if (datagram->length > 0)
        memcpy(at + ECT_DATAGRAM_DATA, datagram->data, datagram->length);
    ect_store_le16(at + ECT_DATAGRAM_DATA + datagram->length, 0);
    f->last = f->length;
    f->length += ECT_DATAGRAM_DATA + (size_t)datagram->length + ECT_DATAGRAM_COUNTER;
    return f->last + ECT_DATAGRAM_DATA;
}

bool eni_frame_exchange(ect_eni_player_t *p, eni_frame_t *f)
{
    ect_store_le16(f->bytes + ETHERNET, (uint16_t)(COMMANDS | (f->length - AT_DATAGRAM)));
    if (f->length < SHORTEST) {
        memset(f->bytes + f->length, 0, SHORTEST - f->length);
        f->length = SHORTEST;
    }
    return p->wire->exchange(p->wire->ctx, f->bytes, f->length);
}

int eni_exchange(ect_eni_player_t *p, const eni_datagram_t *datagram, const uint8_t **reply)
{
    eni_frame_t f = {.bytes = p->frame};
    eni_frame_begin(&f);
    const size_t data = eni_frame_add(&f, ++p->index, datagram);
    *reply = p->frame + data;
    return eni_frame_exchange(p, &f) ? ect_load_le16(p->frame + data + datagram->length) : -1;
}

/* --- cyclic frames ------------------------------------------------------------------------------------------------ */

static void compare_cyclic(ect_eni_player_t *p, const ect_eni_command_t *command, int counter, bool came)
{
    if (!came)
        eni_report(p, command->line, "cyclic command: its frame does not come back");
    else if (command->counter >= 0 && counter != command->counter)
        eni_report(p, command->line, "cyclic command: the working counter is %d, not %d", counter, command->counter);
}

/* Sends the commands of one frame that apply in the present state, then checks all replies. */
static void send_frame(ect_eni_player_t *p, const ect_eni_frame_t *frame, bool compare)
{
    eni_frame_t f = {.bytes = p->frame};
    size_t at = AT_DATAGRAM, sent = 0;
    eni_frame_begin(&f);
    for (size_t i = 0; i < frame->command_count; i++) {
        const ect_eni_command_t *command = &frame->commands[i];
        const eni_datagram_t datagram = eni_datagram_of(command);
        if ((command->states & p->state) == 0)
            continue;
        (void)eni_frame_add(&f, ++p->index, &datagram);
        sent++;
    }
    const bool came = sent > 0 && eni_frame_exchange(p, &f);
    for (size_t i = 0; sent > 0 && compare && i < frame->command_count; i++) {
        const ect_eni_command_t *command = &frame->commands[i];
        if ((command->states & p->state) == 0)
            continue;
        at += ECT_DATAGRAM_DATA + command->data.length;
        compare_cyclic(p, command, ect_load_le16(p->frame + at), came);
        at += ECT_DATAGRAM_COUNTER;
    }
}

static uint64_t send_cyclic(ect_eni_player_t *p, bool compare)
{
    const ect_eni_network_t *network = ect_eni_network(p->eni);
    uint64_t cycle_ns = 0;
    for (size_t i = 0; i < network->cyclic_count; i++) {
        const ect_eni_cyclic_t *cyclic = &network->cyclics[i];
        const uint64_t ns = (uint64_t)cyclic->cycle_us * 1000;
        cycle_ns = cycle_ns == 0 || (ns != 0 && ns < cycle_ns) ? ns : cycle_ns;
        for (size_t k = 0; k < cyclic->frame_count; k++)
            send_frame(p, &cyclic->frames[k], compare);
    }
    p->idle_ns = 0;
    return cycle_ns != 0 ? cycle_ns : NS_PER_MS;
}

bool ect_eni_play_cycle(ect_eni_player_t *p)
{
    const size_t before = p->reported;
    p->wire->wait(p->wire->ctx, send_cyclic(p, true));
    return p->reported == before;
}

void eni_wait(ect_eni_player_t *p)
{
    enum { CYCLE_NS = NS_PER_MS };
    p->wire->wait(p->wire->ctx, CYCLE_NS);
    p->idle_ns += CYCLE_NS;
    if (p->state != 0)
        (void)send_cyclic(p, false);
}
