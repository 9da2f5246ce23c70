/* SPDX-License-Identifier: MIT */
/* Compares a capture of a bus with twins. The frames of the capture do not depend on the replies of the twins, and
 * twins are faster than hardware; so AL states and mails are compared by their order, not frame by frame. */
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "bus/capture/decode.h"
#include "bus/capture/pcapng.h"
#include "esc/route.h"
#include "replay_file.h"
#include "text/state.h"
#include "wire/bytes.h"
#include "wire/registers.h"

enum { SOURCE = 6, MARKED = 2, MAIL = 12, STEPS = 64, TEXT = 300, MAIL_HEAD = 6, SHOWN = 20 };

/* AL states, or mails, in the order of the master's reads. Mails are compared by header and service. */
typedef struct steps {
    size_t count;
    uint64_t frames[STEPS];
    uint8_t steps[STEPS][MAIL];
} steps_t;

enum { BUS, TWIN, SIDES };

typedef struct slave {
    steps_t states[SIDES], mails[SIDES];
} slave_t;

typedef struct comparison {
    replay_t *replay;
    ect_exchange_t exchange;
    uint64_t clock_ns, base_ns, next_ns;
    uint8_t request[ECT_ESC_MAX_FRAME], reply[ECT_ESC_MAX_FRAME];
    size_t request_length, reply_length; /* 0: none */
    slave_t *slaves;
    uint64_t differences;
} comparison_t;

static uint64_t read_clock(void *ctx)
{
    const comparison_t *c = ctx;
    return c->clock_ns;
}

static void take_reply(void *ctx, ect_end_t end, const uint8_t *frame, size_t length)
{
    comparison_t *c = ctx;
    (void)end;
    c->reply_length = length < sizeof c->reply ? length : sizeof c->reply;
    memcpy(c->reply, frame, c->reply_length);
}

/* --- one datagram ------------------------------------------------------------------------------------------------- */

static void differ(comparison_t *c, const uint8_t *d, const char *what, unsigned int bus, unsigned int twin)
{
    char slaves[TEXT], text[TEXT];
    const ect_mailboxes_t none = {0};
    if (c->differences++ >= SHOWN)
        return;
    replay_slaves(c->exchange.chain, d, slaves, sizeof slaves);
    ect_decode_datagram(&none, d, 0, true, text, sizeof text);
    text[strcspn(text, ",")] = 0;
    printf("  frame %" PRIu64 ", %s, %s: %s: bus %u, twin %u\n", c->replay->item.number, text, slaves, what, bus, twin);
}

static void add_step(steps_t *s, uint64_t frame, const uint8_t *step, size_t length, bool repeats)
{
    uint8_t one[MAIL] = {0};
    memcpy(one, step, length < MAIL ? length : MAIL);
    if (s->count == STEPS || (!repeats && s->count > 0 && memcmp(s->steps[s->count - 1], one, MAIL) == 0))
        return;
    s->frames[s->count] = frame;
    memcpy(s->steps[s->count++], one, MAIL);
}

/* Adds type and protocol of a mail, without counter and values. */
static void add_mail(steps_t *s, uint64_t frame, const uint8_t *data, size_t length)
{
    uint8_t mail[MAIL] = {0};
    memcpy(mail, data, length < MAIL ? length : MAIL);
    mail[0] = mail[1] = 0; /* the length depends on values */
    mail[5] &= 0x0F;
    add_step(s, frame, mail, MAIL, true);
}

static unsigned int counter_of(const uint8_t *d, size_t length)
{
    return ect_load_le16(d + ECT_DATAGRAM_DATA + length);
}

static bool reads_one(const uint8_t *d)
{
    return d[0] == ECT_APRD || d[0] == ECT_FPRD;
}

/* Adds AL status and mails of a reply on one side. @return whether the data are a mail or a mailbox status, which may
 *come later */
static bool take_steps(comparison_t *c, size_t position, unsigned int side, const uint8_t *d)
{
    const ect_slave_t *slave = ect_chain_slave(c->exchange.chain, position);
    const uint16_t address = ect_load_le16(d + ECT_DATAGRAM_ADO);
    const size_t length = ect_datagram_length(d);
    const bool mailbox = address >= ECT_RAM && address == slave->mailbox.in_start && length > MAIL_HEAD;
    const bool read = counter_of(d, length) > 0;
    slave_t *s = &c->slaves[position];
    if (read && address == ECT_REG_AL_STATUS && length > 0)
        add_step(&s->states[side], c->replay->item.number, d + ECT_DATAGRAM_DATA, 1, false);
    if (read && mailbox)
        add_mail(&s->mails[side], c->replay->item.number, d + ECT_DATAGRAM_DATA, length);
    return mailbox || address == ECT_REG_SM + ECT_SM_SIZE + ECT_SM_STATUS;
}

static void compare_data(comparison_t *c, const uint8_t *request, const uint8_t *bus, const uint8_t *twin,
                         const char *name)
{
    char what[TEXT];
    const size_t length = ect_datagram_length(request);
    size_t i = 0;
    while (i < length && bus[ECT_DATAGRAM_DATA + i] == twin[ECT_DATAGRAM_DATA + i])
        i++;
    snprintf(what, sizeof what, "byte %zu of the %s", i, name);
    if (i < length)
        differ(c, request, what, bus[ECT_DATAGRAM_DATA + i], twin[ECT_DATAGRAM_DATA + i]);
}

static void compare_datagram(comparison_t *c, const uint8_t *request, const uint8_t *bus, const uint8_t *twin)
{
    const size_t length = ect_datagram_length(request);
    const size_t position = reads_one(request) ? replay_slave(c->exchange.chain, request) : SIZE_MAX;
    bool later = false;
    if (position < ect_chain_count(c->exchange.chain)) {
        later = take_steps(c, position, BUS, bus);
        (void)take_steps(c, position, TWIN, twin);
    }
    const unsigned int of_bus = counter_of(bus, length), of_twin = counter_of(twin, length);
    if (of_bus != of_twin && !later)
        differ(c, request, "working counter", of_bus, of_twin);
    if (of_bus == of_twin && of_bus > 0 && position < ect_chain_count(c->exchange.chain) &&
        ect_load_le16(request + ECT_DATAGRAM_ADO) == ECT_REG_SII_DATA)
        compare_data(c, request, bus, twin, "EEPROM data");
    if (of_bus == of_twin && c->replay->data && replay_is_logical(request))
        compare_data(c, request, bus, twin, "process data");
}

/* --- frames ------------------------------------------------------------------------------------------------------- */

static void compare_frames(comparison_t *c, const uint8_t *bus, size_t length)
{
    const size_t replied = length < c->reply_length ? length : c->reply_length;
    const size_t least = replied < c->request_length ? replied : c->request_length;
    size_t size;
    if (c->reply_length == 0) {
        differ(c, c->request + REPLAY_HEADS, "replies", 1, 0);
        return;
    }
    for (size_t at = REPLAY_HEADS; (size = replay_datagram(c->request, least, at)) > 0; at += size) {
        compare_datagram(c, c->request + at, bus + at, c->reply + at);
        if (!ect_datagram_follows(c->request + at))
            return;
    }
}

static bool is_ethercat(const ect_item_t *item)
{
    enum { TYPE = 12, LEAST = 28 };
    return item->captured >= LEAST && item->captured == item->length && item->captured <= ECT_ESC_MAX_FRAME &&
           ect_load_be16(item->bytes + TYPE) == 0x88A4;
}

/* The first slave sets a bit in the source address of a frame. The master's address may have the same bit, so a reply
 * must also follow a request with the same first command and index. */
static bool is_reply(const comparison_t *c, const ect_item_t *item)
{
    enum { COMMAND = 16 };
    return (item->bytes[SOURCE] & MARKED) != 0 && c->request_length == item->captured &&
           memcmp(c->request + COMMAND, item->bytes + COMMAND, 2) == 0;
}

/* Polls the devices at each of their deadlines. */
static void pass_time(comparison_t *c, uint64_t now_ns)
{
    while (c->next_ns <= now_ns) {
        c->clock_ns = ect_later(c->clock_ns, c->next_ns);
        c->next_ns = ect_exchange_run(&c->exchange);
        if (c->next_ns <= c->clock_ns)
            c->next_ns = c->clock_ns + 1;
    }
    c->clock_ns = ect_later(c->clock_ns, now_ns);
}

static void pass_request(comparison_t *c, const ect_item_t *item)
{
    replay_t *r = c->replay;
    replay_count_request(r);
    pass_time(c, c->base_ns + r->bus_ns);
    memcpy(c->request, item->bytes, item->captured);
    c->request_length = item->captured;
    c->reply_length = 0;
    const ect_packet_time_t time = {.now_ns = c->clock_ns};
    ect_exchange_frame(&c->exchange, ECT_END_IN, r->bytes, item->captured, &time);
    c->next_ns = ect_exchange_run(&c->exchange);
}

static void pass_item(comparison_t *c)
{
    const ect_item_t *item = &c->replay->item;
    if (item->kind != ECT_ITEM_PACKET || !is_ethercat(item))
        return;
    if (!is_reply(c, item)) {
        pass_request(c, item);
        return;
    }
    c->replay->replies++;
    compare_frames(c, item->bytes, item->captured);
    c->request_length = 0;
}

/* --- the report --------------------------------------------------------------------------------------------------- */

static void print_step(bool mail, const steps_t *s, size_t i)
{
    static const char *const types[16] = {"error", "AoE", "EoE", "CoE", "FoE", "SoE"};
    const uint8_t *step = s->steps[i];
    if (i >= s->count)
        printf("nothing more");
    else if (!mail)
        printf("%s", ect_state_text(step[0]));
    else if (step[5] == 3)
        printf("CoE service %u, %04Xh:%02X, command 0x%02X", step[7] >> 4, ect_load_le16(step + 9), step[11], step[8]);
    else
        printf("%s mail", types[step[5]] ? types[step[5]] : "unknown");
}

static void compare_steps(comparison_t *c, size_t position, const char *name, const steps_t sides[SIDES], bool mail)
{
    size_t i = 0;
    while (i < sides[BUS].count && i < sides[TWIN].count &&
           memcmp(sides[BUS].steps[i], sides[TWIN].steps[i], MAIL) == 0)
        i++;
    if (i == sides[BUS].count && i == sides[TWIN].count)
        return;
    const unsigned int side = i < sides[BUS].count ? BUS : TWIN;
    c->differences++;
    printf("  frame %" PRIu64 ", slave %zu, %s %zu: bus ", sides[side].frames[i], position + 1, name, i + 1);
    print_step(mail, &sides[BUS], i);
    printf(", twin ");
    print_step(mail, &sides[TWIN], i);
    printf("\n");
}

static void report(comparison_t *c)
{
    replay_t *r = c->replay;
    for (size_t i = 0; i < ect_chain_count(c->exchange.chain); i++) {
        compare_steps(c, i, "AL state", c->slaves[i].states, false);
        compare_steps(c, i, "mail", c->slaves[i].mails, true);
    }
    printf("%s: %" PRIu64 " frames and %" PRIu64 " replies in %.3f s of the bus: %" PRIu64 " differences\n", r->path,
           r->requests, r->replies, (double)r->bus_ns / 1e9, c->differences);
    r->status = c->differences > 0 ? EXIT_DIFFERS : EXIT_CLEAN;
}

void replay_bus(replay_t *r, twin_args_t *twins)
{
    enum { POWER_ON_NS = 1000000000 };
    comparison_t *c = calloc(1, sizeof *c);
    if (!c) {
        replay_wrong(r, "not enough memory");
        return;
    }
    c->replay = r;
    c->clock_ns = c->base_ns = POWER_ON_NS;
    int status = twin_args_power_on(twins, "ectwin replay", POWER_ON_NS, &c->exchange.chain);
    c->slaves = status == EXIT_CLEAN ? calloc(twins->count, sizeof *c->slaves) : NULL;
    if (c->slaves) {
        c->exchange.scenario = &twins->scenario;
        c->exchange.filter = twins->filter.ctx ? &twins->filter : NULL;
        c->exchange.send = take_reply;
        c->exchange.clock = read_clock;
        c->exchange.ctx = c;
        ect_exchange_start(&c->exchange);
        c->next_ns = ect_exchange_run(&c->exchange);
        while (r->status == EXIT_CLEAN && r->ahead.kind != ECT_ITEM_END && r->ahead.kind != ECT_ITEM_WRONG) {
            replay_next(r);
            pass_item(c);
        }
        if (r->status == EXIT_CLEAN)
            report(c);
        ect_exchange_end(&c->exchange);
    } else {
        r->status = status == EXIT_CLEAN ? EXIT_RUN : status;
    }
    ect_chain_free(c->exchange.chain);
    free(c->slaves);
    free(c);
}
