/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Local blocks of a capture: the data of a record other than frames (docs/REPLAY.md). The body of a block is a kind and
 * a value of 32 bits, a time of 64 bits, little-endian, and a text.
 */
#ifndef ECT_BUS_CAPTURE_LOGGED_H
#define ECT_BUS_CAPTURE_LOGGED_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "wire/bytes.h"
#include "wire/linkage.h"

ECT_C_BEGIN

typedef enum ect_logged_kind {
    ECT_LOGGED_START = 1, /**< the chain is powered on at `time_ns`; `text`: a JSON object */
    ECT_LOGGED_RUN,     /**< late replies, devices and steps of the script; `time_ns` 0: see the next ECT_LOGGED_CLOCK.
                             `value` 1: at the time of the reply before it */
    ECT_LOGGED_CLOCK,   /**< the clock was read while the previous item was processed */
    ECT_LOGGED_TOUCH,   /**< the chain is changed at `time_ns` by something other than a frame */
    ECT_LOGGED_REQUEST, /**< `text`: a request of the control socket, executed at the time of the last touch */
    ECT_LOGGED_LINK,    /**< a cable is pulled or plugged in; `value`: end, + ECT_LOGGED_PLUGGED when plugged in */
    ECT_LOGGED_POWER,   /**< all twins are switched off and on at the time of the last touch */
    ECT_LOGGED_LOST,    /**< the record ends here: the disk was too slow */
    ECT_LOGGED_CONTENT, /**< part of a memory or a file at the start; `value`: bytes of it, `time_ns`: offset of them,
                             `text`: a name, a line feed, the bytes */
    ECT_LOGGED_FLUSH,   /**< a memory has replied to a flush; `value`: ect_storage_t::flush */
    ECT_LOGGED_MODBUS,  /**< a Modbus request at the time of the last touch; `text`: request and reply, hexadecimal,
                             a space between them */
} ect_logged_kind_t;

enum { ECT_LOGGED_HEAD = 16, ECT_LOGGED_PLUGGED = 256 };

typedef struct ect_logged {
    uint32_t kind; /**< ::ect_logged_kind_t, or another one from a file */
    uint32_t value;
    uint64_t time_ns;
    const char *text; /**< `length` bytes without a terminator */
    size_t length;
} ect_logged_t;

/** Writes the part before the text. @param[out] head  ECT_LOGGED_HEAD bytes */
static inline void ect_logged_head(uint8_t *head, ect_logged_kind_t kind, uint32_t value, uint64_t time_ns)
{
    ect_store_le32(head, kind);
    ect_store_le32(head + 4, value);
    ect_store_le64(head + 8, time_ns);
}

/** Reads a body. Zeros at the end are padding, not text. @return false: too short */
static inline bool ect_logged_read(const uint8_t *body, size_t length, ect_logged_t *logged)
{
    if (length < ECT_LOGGED_HEAD)
        return false;
    while (length > ECT_LOGGED_HEAD && body[length - 1] == 0)
        length--;
    *logged = (ect_logged_t){.kind = ect_load_le32(body),
                             .value = ect_load_le32(body + 4),
                             .time_ns = ect_load_le64(body + 8),
                             .text = (const char *)body + ECT_LOGGED_HEAD,
                             .length = length - ECT_LOGGED_HEAD};
    return true;
}

ECT_C_END

#endif
