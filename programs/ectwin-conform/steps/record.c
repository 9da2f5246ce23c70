/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "steps/record.h"

#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>

#include "bus/capture/pcapng.h"
#include "steps/case.h"

enum { COMMENT = 600, SOURCE = 6, MAC = 6, MULTICAST = 1, DATAGRAM_INDEX = 17, FRAME_MOST = ECT_PCAPNG_FRAME_MOST };
enum { ROOM_LEAST = 64 }; /* bytes of an item: most frames are as short as Ethernet allows */

/* One record for the process: the wrapped send and recv have no parameter for it. */
static struct {
    FILE *capture;
    uint64_t start_ns;
    uint64_t epoch_ns; /* wall clock at the start */
    uint32_t frame;
    char comment[COMMENT]; /* of the next frame */
    cf_item_t *items;      /* a ring buffer */
    size_t next, count;
    uint32_t first_frame;
    bool has_source;
    uint8_t source[MAC];
} record;

uint64_t cf_now_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (uint64_t)t.tv_sec * 1000000000u + (uint64_t)t.tv_nsec;
}

/* --- the file ----------------------------------------------------------------------------------------------------- */

static void write_heads(void)
{
    uint8_t block[ECT_PCAPNG_ROOM];
    (void)fwrite(block, ect_pcapng_section(block, NULL), 1, record.capture);
    (void)fwrite(block, ect_pcapng_interface(block, NULL), 1, record.capture);
}

static void write_packet(const cf_item_t *item)
{
    uint8_t block[ECT_PCAPNG_ROOM];
    const ect_pcapng_packet_t packet = {.direction =
                                            item->kind == CF_ITEM_SENT ? ECT_PCAPNG_OUTBOUND : ECT_PCAPNG_INBOUND,
                                        .time_ns = record.epoch_ns + item->time_ns,
                                        .frame = item->bytes,
                                        .captured = item->length,
                                        .length = item->length,
                                        .comment = record.comment};
    (void)fwrite(block, ect_pcapng_packet(block, &packet), 1, record.capture);
}

/* --- the ring buffer ---------------------------------------------------------------------------------------------- */

static void make_room(cf_item_t *item, size_t length)
{
    if (item->bytes && item->room >= length)
        return;
    item->room = (uint32_t)(length < ROOM_LEAST ? (size_t)ROOM_LEAST : length);
    free(item->bytes);
    item->bytes = malloc(item->room);
    if (!item->bytes)
        abort(); /* a run without evidence is worthless */
}

/* The memory of a displaced item serves the new one: a run records a hundred thousand frames and more. */
static cf_item_t *new_item(cf_item_kind_t kind, const void *bytes, size_t length)
{
    cf_item_t *item = &record.items[record.next];
    record.next = (record.next + 1) % CF_EVIDENCE_MAX;
    record.count += record.count < CF_EVIDENCE_MAX;
    make_room(item, length);
    *item = (cf_item_t){.kind = kind,
                        .time_ns = cf_now_ns() - record.start_ns,
                        .length = (uint32_t)length,
                        .room = item->room,
                        .bytes = item->bytes};
    memcpy(item->bytes, bytes, length);
    return item;
}

static size_t at(size_t nth)
{
    return (record.next + CF_EVIDENCE_MAX - record.count + nth) % CF_EVIDENCE_MAX;
}

/* @return whether two frames are equal except for the index of the first datagram */
static bool same_frame(const cf_item_t *a, const cf_item_t *b)
{
    return a->kind == b->kind && a->kind != CF_ITEM_STEP && a->length == b->length && a->length > DATAGRAM_INDEX &&
           memcmp(a->bytes, b->bytes, DATAGRAM_INDEX) == 0 &&
           memcmp(a->bytes + DATAGRAM_INDEX + 1, b->bytes + DATAGRAM_INDEX + 1, a->length - DATAGRAM_INDEX - 1) == 0;
}

static void swap(cf_item_t *a, cf_item_t *b)
{
    const cf_item_t before = *a;
    *a = *b;
    *b = before;
}

/* Polling for seconds must not displace the request from the evidence. */
static void fold_poll(void)
{
    if (record.count < 4)
        return;
    cf_item_t *sent = &record.items[at(record.count - 4)], *received = &record.items[at(record.count - 3)];
    cf_item_t *sent_again = &record.items[at(record.count - 2)], *received_again = &record.items[at(record.count - 1)];
    if (sent->kind != CF_ITEM_SENT || received->kind != CF_ITEM_RECEIVED || !same_frame(sent, sent_again) ||
        !same_frame(received, received_again))
        return;
    sent_again->folded = received_again->folded = received->folded + 1;
    swap(sent, sent_again);
    swap(received, received_again);
    record.count -= 2;
    record.next = (record.next + CF_EVIDENCE_MAX - 2) % CF_EVIDENCE_MAX;
}

static void add_frame(cf_item_kind_t kind, const void *bytes, size_t length)
{
    if (!record.items || length > FRAME_MOST)
        return;
    cf_item_t *item = new_item(kind, bytes, length);
    item->frame = ++record.frame;
    if (record.first_frame == 0)
        record.first_frame = record.frame;
    if (record.capture)
        write_packet(item);
    record.comment[0] = 0;
    if (kind == CF_ITEM_RECEIVED)
        fold_poll();
}

static void add_comment(const char *text)
{
    size_t used = strlen(record.comment);
    snprintf(record.comment + used, sizeof record.comment - used, "%s%.280s", used > 0 ? "\n" : "", text);
}

void cf_record_open(FILE *capture)
{
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    record.capture = capture;
    record.start_ns = cf_now_ns();
    record.epoch_ns = (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
    record.items = calloc(CF_EVIDENCE_MAX, sizeof record.items[0]);
    if (!record.items)
        abort();
    if (capture)
        write_heads();
}

void cf_record_begin(const char *id, const char *title)
{
    char text[300];
    snprintf(text, sizeof text, "%s %s", id, title);
    record.comment[0] = 0;
    add_comment(text);
    record.first_frame = 0;
}

void cf_record_step(const char *text)
{
    add_comment(text);
    new_item(CF_ITEM_STEP, text, strlen(text) + 1)->frame = record.frame + 1;
}

cf_evidence_t cf_record_end(size_t most)
{
    cf_evidence_t e = {.first_frame = record.first_frame, .last_frame = record.first_frame ? record.frame : 0};
    e.count = record.count < most ? record.count : most;
    e.items = calloc(e.count + 1, sizeof e.items[0]);
    if (!e.items)
        abort();
    for (size_t i = 0; i < record.count; i++) {
        cf_item_t *item = &record.items[at(i)];
        if (i < record.count - e.count)
            continue;
        e.items[i - (record.count - e.count)] = *item;
        item->bytes = NULL;
    }
    record.count = 0;
    record.next = 0;
    if (record.capture)
        (void)fflush(record.capture); /* the growing file always contains whole cases */
    return e;
}

void cf_evidence_free(cf_evidence_t *evidence)
{
    for (size_t i = 0; i < evidence->count; i++)
        free(evidence->items[i].bytes);
    free(evidence->items);
    *evidence = (cf_evidence_t){0};
}

uint32_t cf_record_frame(void)
{
    return record.frame;
}

void cf_record_source(const uint8_t *mac)
{
    record.has_source = mac != NULL;
    if (mac)
        memcpy(record.source, mac, MAC);
}

void cf_record_close(void)
{
    for (size_t i = 0; record.items && i < CF_EVIDENCE_MAX; i++)
        free(record.items[i].bytes);
    free(record.items);
    memset(&record, 0, sizeof record);
}

/* --- send and recv of SOEM and cases ------------------------------------------------------------------------------ */

ssize_t __real_send(int fd, const void *bytes, size_t length, int flags);
ssize_t __real_recv(int fd, void *bytes, size_t room, int flags);
ssize_t __wrap_send(int fd, const void *bytes, size_t length, int flags);
ssize_t __wrap_recv(int fd, void *bytes, size_t room, int flags);

ssize_t __wrap_send(int fd, const void *bytes, size_t length, int flags)
{
    uint8_t copy[FRAME_MOST];
    if (record.has_source && length <= sizeof copy && length >= SOURCE + MAC &&
        (((const uint8_t *)bytes)[SOURCE] & MULTICAST) != 0) {
        memcpy(copy, bytes, length);
        memcpy(copy + SOURCE, record.source, MAC);
        bytes = copy;
    }
    add_frame(CF_ITEM_SENT, bytes, length);
    return __real_send(fd, bytes, length, flags);
}

ssize_t __wrap_recv(int fd, void *bytes, size_t room, int flags)
{
    ssize_t got = __real_recv(fd, bytes, room, flags);
    if (got > 0)
        add_frame(CF_ITEM_RECEIVED, bytes, (size_t)got);
    return got;
}
