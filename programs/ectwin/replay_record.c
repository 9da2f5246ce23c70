/* SPDX-License-Identifier: MIT */
/* Replays a record: the same frames at the same times must give the same replies. Each reading of the clock returns the
 * recorded value. */
#define _GNU_SOURCE
#include <cjson/cJSON.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "bus/capture/decode.h"
#include "bus/capture/pcapng.h"
#include "bus/control/change.h"
#include "esc/route.h"
#include "replay_file.h"
#include "wire/bytes.h"

enum { WORDS_MOST = 4096, LINE = 600 };

typedef struct section {
    replay_t *replay;
    twin_args_t twins;
    ect_exchange_t exchange;
    uint64_t offset_ns; /* added to the clock: times in the file */
    uint64_t clock_ns;
    bool sent;   /* the next reading of the clock returns the time of the last reply */
    bool frozen; /* a difference was found: the comparison has ended */
    char **words;
    int word_count;
    ect_modbus_server_t *modbus;            /* NULL: none in the run */
    uint8_t request[ECT_PCAPNG_FRAME_MOST]; /* the frame before the reply, as received */
    size_t request_length;
} section_t;

/* --- differences -------------------------------------------------------------------------------------------------- */

static void begin_report(section_t *s, uint64_t frame, uint64_t time_ns, const char *what)
{
    const replay_t *r = s->replay;
    s->frozen = true;
    s->replay->status = EXIT_DIFFERS;
    printf("%s: frame %" PRIu64 ", %.9f s after the first: %s\n", r->path, frame, (double)(time_ns - r->first_ns) / 1e9,
           what);
}

static ect_mailboxes_t mailboxes_of(section_t *s, const uint8_t *datagram)
{
    size_t position = replay_slave(s->exchange.chain, datagram);
    if (position == ect_chain_count(s->exchange.chain))
        return (ect_mailboxes_t){0};
    const ect_slave_t *slave = ect_chain_slave(s->exchange.chain, position);
    return (ect_mailboxes_t){.out_start = slave->mailbox.out_start, .in_start = slave->mailbox.in_start};
}

static void print_frame(const char *name, const uint8_t *frame, size_t length)
{
    char text[4 * LINE];
    const ect_mailboxes_t none = {0};
    ect_decode_frame(&none, frame, length, false, text, sizeof text);
    printf("  %s %zu bytes: %s\n", name, length, text);
}

static void report_reply(section_t *s, const uint8_t *got, size_t length)
{
    const ect_item_t *expected = &s->replay->ahead;
    char text[LINE];
    begin_report(s, expected->number, expected->time_ns, "the reply differs");
    replay_difference_t d = replay_compare(expected->bytes, expected->captured, got, length);
    if (d.at == 0 || d.at + ECT_DATAGRAM_DATA + d.length + ECT_DATAGRAM_COUNTER > s->request_length) {
        print_frame("expected", expected->bytes, expected->captured);
        print_frame("got", got, length);
        return;
    }
    const ect_mailboxes_t m = mailboxes_of(s, s->request + d.at);
    replay_slaves(s->exchange.chain, s->request + d.at, text, sizeof text);
    printf("  datagram %zu of %zu, %s\n", d.number, d.count, text);
    ect_decode_datagram(&m, s->request + d.at, d.length, true, text, sizeof text);
    printf("  request  %s\n", text);
    ect_decode_datagram(&m, expected->bytes + d.at, d.length, false, text, sizeof text);
    printf("  expected %s\n", text);
    ect_decode_datagram(&m, got + d.at, d.length, false, text, sizeof text);
    printf("  got      %s\n", text);
}

/* --- functions called by the exchange ----------------------------------------------------------------------------- */

static bool is_reply(const ect_item_t *item)
{
    return item->kind == ECT_ITEM_PACKET && item->direction == ECT_PCAPNG_OUTBOUND;
}

static void compare(void *ctx, ect_end_t end, const uint8_t *frame, size_t length)
{
    section_t *s = ctx;
    const ect_item_t *ahead = &s->replay->ahead;
    if (s->frozen || ahead->kind == ECT_ITEM_END || ahead->kind == ECT_ITEM_WRONG)
        return; /* the record ends within its last step */
    if (!is_reply(ahead)) {
        begin_report(s, s->replay->item.number, s->clock_ns + s->offset_ns,
                     "a reply of the twins is not in the record");
        print_frame("got", frame, length);
    } else if (ahead->interface != end || ahead->captured != length || memcmp(ahead->bytes, frame, length) != 0) {
        report_reply(s, frame, length);
    } else {
        s->clock_ns = ahead->time_ns - s->offset_ns;
        s->sent = s->replay->item.kind == ECT_ITEM_PACKET; /* a run reads the time of replies to frames only */
        s->replay->replies++;
        replay_next(s->replay);
    }
}

static bool take_logged(const ect_item_t *item, ect_logged_t *logged)
{
    return item->kind == ECT_ITEM_LOCAL && ect_logged_read(item->bytes, item->captured, logged);
}

static uint64_t read_clock(void *ctx)
{
    section_t *s = ctx;
    ect_logged_t logged;
    if (s->sent)
        s->sent = false;
    else if (take_logged(&s->replay->ahead, &logged) && logged.kind == ECT_LOGGED_CLOCK) {
        s->clock_ns = ect_later(s->clock_ns, logged.time_ns);
        replay_next(s->replay);
    }
    return s->clock_ns;
}

/* --- steps of the record ------------------------------------------------------------------------------------------ */

/* Time never goes back, even in an invalid file. */
static void advance(section_t *s, uint64_t time_ns)
{
    s->clock_ns = ect_later(s->clock_ns, time_ns);
}

static void pass_request(section_t *s)
{
    replay_t *r = s->replay;
    const ect_item_t *item = &r->item;
    if (item->interface >= ECT_ENDS || item->captured > sizeof s->request || item->captured == 0) {
        replay_wrong(r, "frame %" PRIu64 " is not a frame of a record", item->number);
        return;
    }
    advance(s, item->time_ns - s->offset_ns);
    memcpy(s->request, item->bytes, item->captured);
    s->request_length = item->captured;
    replay_count_request(r);
    const ect_packet_time_t time = {.now_ns = s->clock_ns};
    const ect_end_t in = (ect_end_t)item->interface;
    if (item->length > ECT_EXCHANGE_FRAME)
        ect_exchange_long_frame(&s->exchange, in, r->bytes, item->length, s->clock_ns);
    else if (item->length == item->captured)
        ect_exchange_frame(&s->exchange, in, r->bytes, item->captured, &time);
    else
        replay_wrong(r, "frame %" PRIu64 " is cut", item->number);
}

static void pass_packet(section_t *s)
{
    if (!is_reply(&s->replay->item)) {
        pass_request(s);
        return;
    }
    begin_report(s, s->replay->item.number, s->replay->item.time_ns, "the twins do not reply");
    print_frame("expected", s->replay->item.bytes, s->replay->item.captured);
}

static void carry_out(section_t *s, const ect_logged_t *logged)
{
    char message[ECT_SIGNAL_MESSAGE];
    cJSON *request = cJSON_ParseWithLength(logged->text, logged->length);
    if (ect_change_is(ect_change_op(request)))
        (void)ect_change_apply(s->exchange.chain, s->exchange.scenario, request, s->exchange.touched_ns, message);
    else
        replay_wrong(s->replay, "an invalid request: %.*s", (int)(logged->length < 60 ? logged->length : 60),
                     logged->text);
    cJSON_Delete(request);
}

/* Reads hexadecimal digits up to another character. @return number of bytes; `most` + 1: too many */
static size_t read_hexadecimal(const char **text, const char *end, uint8_t *bytes, size_t most)
{
    static const char digits[] = "0123456789ABCDEF";
    size_t count = 0;
    for (; end - *text >= 2 && count <= most; *text += 2) {
        const char *high = memchr(digits, (*text)[0], 16);
        const char *low = memchr(digits, (*text)[1], 16);
        if (!high || !low)
            break;
        if (count < most)
            bytes[count] = (uint8_t)((high - digits) << 4 | (low - digits));
        count++;
    }
    return count;
}

static void print_bytes(const char *name, const uint8_t *bytes, size_t length)
{
    printf("  %s", name);
    for (size_t i = 0; i < length; i++)
        printf(" %02X", bytes[i]);
    printf(length > 0 ? "\n" : " none\n");
}

/* Repeats a Modbus request at its position between the frames, and compares the reply with the recorded one. */
static void pass_modbus(section_t *s, const ect_logged_t *logged)
{
    uint8_t request[ECT_MODBUS_ADU], expected[ECT_MODBUS_ADU], got[ECT_MODBUS_ADU];
    const char *text = logged->text;
    const char *end = text + logged->length;
    size_t length = read_hexadecimal(&text, end, request, sizeof request);
    bool separated = text < end && *text == ' ';
    text += separated;
    size_t want = read_hexadecimal(&text, end, expected, sizeof expected);
    if (!s->modbus || !separated || text != end || length > sizeof request || want > sizeof expected) {
        replay_wrong(s->replay, "an invalid Modbus request");
        return;
    }
    size_t replied =
        ect_modbus_server_request(s->modbus, s->exchange.chain, s->exchange.touched_ns, request, length, got);
    if (replied == want && memcmp(got, expected, want) == 0)
        return;
    begin_report(s, s->replay->requests, s->clock_ns + s->offset_ns, "the reply to a Modbus request behind it differs");
    print_bytes("request ", request, length);
    print_bytes("expected", expected, want);
    print_bytes("got     ", got, replied);
}

static void pass_logged(section_t *s, const ect_logged_t *logged)
{
    const unsigned int end = logged->value & 0xFF;
    switch (logged->kind) {
    case ECT_LOGGED_MODBUS:
        pass_modbus(s, logged);
        return;
    case ECT_LOGGED_FLUSH:
        return; /* after the last frame: a run finishes its saves */
    case ECT_LOGGED_RUN:
        advance(s, logged->time_ns);
        if (logged->value == 0)
            s->exchange.answered_ns = 0;
        (void)ect_exchange_run(&s->exchange);
        return;
    case ECT_LOGGED_TOUCH:
        advance(s, logged->time_ns);
        (void)ect_exchange_touch(&s->exchange);
        return;
    case ECT_LOGGED_REQUEST:
        carry_out(s, logged);
        return;
    case ECT_LOGGED_LINK:
        if (end < ECT_ENDS)
            ect_exchange_link(&s->exchange, (ect_end_t)end, (logged->value & ECT_LOGGED_PLUGGED) != 0);
        return;
    case ECT_LOGGED_POWER:
        ect_exchange_end(&s->exchange);
        ect_chain_power_cycle(s->exchange.chain, s->exchange.touched_ns);
        return;
    case ECT_LOGGED_LOST:
        fprintf(stderr, "%s: the record ends early: its disk was too slow\n", s->replay->path);
        return;
    default:
        replay_wrong(s->replay, "a clock reading or a start in the wrong place");
    }
}

static void pass_item(section_t *s)
{
    ect_logged_t logged;
    s->sent = false;
    if (s->replay->item.kind == ECT_ITEM_PACKET)
        pass_packet(s);
    else if (take_logged(&s->replay->item, &logged))
        pass_logged(s, &logged);
    else
        replay_wrong(s->replay, "a local block of %zu bytes", s->replay->item.captured);
}

/* --- the start ---------------------------------------------------------------------------------------------------- */

static bool take_words(section_t *s, const cJSON *words)
{
    static char name[] = "ectwin replay";
    int count = cJSON_IsArray(words) ? cJSON_GetArraySize(words) : 0;
    s->words = count > 0 && count < WORDS_MOST ? calloc((size_t)count + 2, sizeof *s->words) : NULL;
    if (!s->words)
        return false;
    s->words[0] = name;
    const cJSON *word;
    cJSON_ArrayForEach(word, words)
    {
        const char *text = cJSON_GetStringValue(word);
        s->words[++s->word_count] = text ? strdup(text) : NULL;
        if (!s->words[s->word_count])
            return false;
    }
    return true;
}

static bool read_start(section_t *s, const ect_logged_t *logged)
{
    cJSON *start = cJSON_ParseWithLength(logged->text, logged->length);
    const char *offset = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(start, "offset"));
    const char *version = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(start, "version"));
    bool done = offset && version && take_words(s, cJSON_GetObjectItemCaseSensitive(start, "words"));
    if (done)
        s->offset_ns = strtoull(offset, NULL, 10);
    if (done && strcmp(version, ECTWIN_VERSION) != 0)
        fprintf(stderr, "%s: recorded by ectwin %.20s, replayed by ectwin %s\n", s->replay->path, version,
                ECTWIN_VERSION);
    cJSON_Delete(start);
    return done;
}

/* The result of a flush in the run. */
static int take_flush(void *ctx, int result)
{
    const section_t *s = ctx;
    ect_logged_t logged;
    if (!take_logged(&s->replay->ahead, &logged) || logged.kind != ECT_LOGGED_FLUSH)
        return result;
    replay_next(s->replay);
    return (int32_t)logged.value;
}

/* Reads the content of the run's folders, which replaces the folders. */
static bool take_content(section_t *s)
{
    ect_logged_t logged;
    const char *why = s->twins.files ? content_make_folder(&s->twins.content) : NULL;
    s->twins.replayed = true;
    if (s->twins.files)
        s->twins.files = s->twins.content.folder;
    while (!why && take_logged(&s->replay->ahead, &logged) && logged.kind == ECT_LOGGED_CONTENT) {
        replay_next(s->replay);
        (void)take_logged(&s->replay->item, &logged);
        why = content_take(&s->twins.content, &logged, s->replay->item.captured - ECT_LOGGED_HEAD);
    }
    if (why)
        replay_wrong(s->replay, "%s", why);
    return !why;
}

static bool open_modbus(section_t *s)
{
    char message[ECT_MODBUS_MESSAGE];
    s->modbus = s->twins.modbus ? ect_modbus_server_new(message) : NULL;
    if (s->twins.modbus && !s->modbus)
        replay_wrong(s->replay, "%s", message);
    return !s->twins.modbus || s->modbus;
}

static bool power_on(section_t *s, uint64_t now_ns)
{
    char message[TWIN_MESSAGE] = "";
    s->clock_ns = now_ns;
    replay_words(&s->twins, s->word_count, s->words);
    if (!take_content(s) || !open_modbus(s))
        return false;
    s->twins.message = message;
    if (twin_args_power_on(&s->twins, "ectwin replay", now_ns, &s->exchange.chain) != EXIT_CLEAN) {
        replay_wrong(s->replay, "its twins cannot be powered on: %s", message);
        return false;
    }
    for (size_t i = 0; s->twins.store && i < s->twins.count; i++)
        ect_memory_replace_flush(s->twins.memories[i], take_flush, s);
    s->exchange.scenario = &s->twins.scenario;
    s->exchange.filter = s->twins.filter.ctx ? &s->twins.filter : NULL;
    s->exchange.send = compare;
    s->exchange.clock = read_clock;
    s->exchange.ctx = s;
    ect_exchange_start(&s->exchange);
    return true;
}

static void free_section(section_t *s)
{
    if (s->exchange.chain) {
        ect_exchange_end(&s->exchange);
        ect_chain_free(s->exchange.chain);
    }
    ect_modbus_server_close(s->modbus);
    twin_args_free(&s->twins);
    for (int i = 1; i <= s->word_count; i++)
        free(s->words[i]);
    free(s->words);
    free(s);
}

void replay_record(replay_t *r)
{
    section_t *s = calloc(1, sizeof *s);
    ect_logged_t logged;
    if (!s) {
        replay_wrong(r, "not enough memory");
        return;
    }
    s->replay = r;
    r->begun = false;
    if (!take_logged(&r->item, &logged) || !read_start(s, &logged))
        replay_wrong(r, "an invalid start");
    else if (power_on(s, logged.time_ns)) {
        while (r->status == EXIT_CLEAN && (r->ahead.kind == ECT_ITEM_PACKET || r->ahead.kind == ECT_ITEM_LOCAL)) {
            replay_next(r);
            pass_item(s);
        }
    }
    free_section(s);
}
