/* SPDX-License-Identifier: MIT */
/* Capture files and records with any bytes: the reader, the items of a record, the content that a replay takes, and
 * frames in words and in comparison. */
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../../programs/ectwin/content.h"
#include "../../programs/ectwin/replay_file.h"
#include "bus/capture/decode.h"
#include "bus/capture/logged.h"
#include "bus/capture/reader.h"
#include "esc/route.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { TEXT = 600 };

/* The frame before, which a packet is compared with. */
typedef struct before {
    uint8_t *bytes;
    size_t length;
} before_t;

static void decode(const uint8_t *frame, size_t length)
{
    static const ect_mailboxes_t mailboxes[] = {{0, 0}, {0x1000, 0x1C00}};
    char text[TEXT];
    for (unsigned int i = 0; i < 4; i++)
        ect_decode_frame(&mailboxes[i % 2], frame, length, i < 2, text, i < 2 ? sizeof text : 1 + length % sizeof text);
    for (size_t at = REPLAY_HEADS, step; (step = replay_datagram(frame, length, at)) > 0; at += step) {
        (void)replay_is_logical(frame + at);
        ect_decode_datagram(&mailboxes[1], frame + at, step - ECT_DATAGRAM_DATA - ECT_DATAGRAM_COUNTER, true, text,
                            sizeof text);
    }
}

static void compare(before_t *before, const uint8_t *frame, size_t length)
{
    bool differs = length != before->length || (length > 0 && memcmp(frame, before->bytes, length) != 0);
    if (before->bytes && differs) {
        replay_difference_t d = replay_compare(before->bytes, before->length, frame, length);
        if (d.at + d.length > length && d.at + d.length > before->length)
            abort(); /* the report reads these bytes */
    }
    free(before->bytes);
    before->bytes = malloc(length + 1);
    before->length = before->bytes ? length : 0;
    if (before->bytes && length > 0)
        memcpy(before->bytes, frame, length);
}

static void take(content_t *content, const ect_item_t *item)
{
    ect_logged_t logged;
    if (!ect_logged_read(item->bytes, item->captured, &logged))
        return;
    if (ECT_LOGGED_HEAD + logged.length > item->captured)
        abort();
    if (logged.kind == ECT_LOGGED_CONTENT)
        (void)content_take(content, &logged, item->captured - ECT_LOGGED_HEAD);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    ect_reader_t reader = {.file = size > 0 ? fmemopen((void *)(uintptr_t)data, size, "rb") : NULL};
    ect_item_t item;
    before_t before = {0};
    content_t content = {0};
    const uint8_t *eeprom = NULL;
    if (!reader.file)
        return 0;
    while (ect_reader_next(&reader, &item) > ECT_ITEM_WRONG) {
        if (item.kind == ECT_ITEM_LOCAL)
            take(&content, &item);
        if (item.kind != ECT_ITEM_PACKET)
            continue;
        decode(item.bytes, item.captured);
        compare(&before, item.bytes, item.captured);
    }
    (void)content_pad(&content, "eeprom 1", 128, &eeprom);
    content_free(&content);
    free(before.bytes);
    ect_reader_free(&reader);
    (void)fclose(reader.file);
    return 0;
}
