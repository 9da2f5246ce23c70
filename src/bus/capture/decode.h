/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Frames as text: command, address, register, mail. Invalid data are written as bytes: a defective slave may send
 * anything.
 *
 * Context: any. Texts are truncated to `room`, and always terminated.
 */
#ifndef ECT_BUS_CAPTURE_DECODE_H
#define ECT_BUS_CAPTURE_DECODE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "wire/linkage.h"

ECT_C_BEGIN

/** Addresses at which mails are decoded; 0: none. */
typedef struct ect_mailboxes {
    uint16_t out_start, in_start;
} ect_mailboxes_t;

/**
 * Writes a frame, one line for each datagram.
 * @param frame      from the destination address on, `length` bytes of any content
 * @param sent       true: a request of the master; false: the returned frame
 * @param[out] text  `room` bytes, 1 or more
 */
void ect_decode_frame(const ect_mailboxes_t *m, const uint8_t *frame, size_t length, bool sent, char *text,
                      size_t room);

/** Writes one datagram. @param datagram  header, `length` bytes of data, working counter. Others as ::ect_decode_frame
 */
void ect_decode_datagram(const ect_mailboxes_t *m, const uint8_t *datagram, size_t length, bool sent, char *text,
                         size_t room);

ECT_C_END

#endif
