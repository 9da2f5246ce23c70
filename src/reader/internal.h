/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Interfaces between the files of reader/, from the lowest to the highest (tests/check/order.py):
 *
 *   packet.c      frames of a packet socket
 *   report.c      result, text and limit
 *   datagram.c    one datagram, there and back
 *   mailbox.c     mails through SyncManagers 0 and 1
 *   eeprom.c      EEPROM
 *   slave.c       states
 *   coe.c         CoE requests and their replies
 *   upload.c      SDO upload
 *   info.c        SDO information
 *   dictionary.c  all objects
 *   json.c        all objects as JSON
 */
#ifndef ECT_READER_INTERNAL_H
#define ECT_READER_INTERNAL_H

#include "reader/reader.h"

#define NS_PER_MS UINT64_C(1000000)

enum { MAILBOX_ERROR = 0, MAILBOX_COE = 3, MAIL_HEADER = 6, COE_HEADER = 2 };
enum { COE_EMERGENCY = 1, COE_REQUEST = 2, COE_RESPONSE = 3, COE_INFO = 8 };
/* Replies to nothing that one request skips, and requests in a row that may fail. */
enum { SKIPS = 64, FAILURES = 3 };

/* Records a result and its text. @return the result */
ect_reader_result_t reader_report(ect_reader_t *r, ect_reader_result_t result, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
ect_reader_result_t reader_good(ect_reader_t *r);
/* @return whether the limit has passed, with the result recorded */
bool reader_is_over(ect_reader_t *r);
/* @return whether the caller wants to go on */
bool reader_progress(ect_reader_t *r, const char *what, unsigned int done, unsigned int all);
uint64_t reader_now(const ect_reader_t *r);
/* A pause between two polls: short at first, then up to 1 ms. */
void reader_pause(const ect_reader_t *r, unsigned int polls);

/* `command`: APRD, APWR or BRD. @return false: no frame came back. *wkc: slaves that processed the datagram */
bool reader_try(ect_reader_t *r, uint8_t command, uint16_t address, uint8_t *data, uint16_t length, uint16_t *wkc);
/* To the slave, repeated when a frame is lost: never for data that a read or write consumes. */
ect_reader_result_t reader_get(ect_reader_t *r, uint16_t address, uint8_t *data, uint16_t length);
ect_reader_result_t reader_put(ect_reader_t *r, uint16_t address, const uint8_t *data, uint16_t length);
uint16_t reader_load16(const uint8_t *bytes);

enum { APRD = 1, APWR = 2, FPRD = 4, FPWR = 5, BRD = 7 };

/* Sends a mail of a type; empties the mailbox from the slave before. */
ect_reader_result_t reader_send_mail(ect_reader_t *r, uint8_t type, const uint8_t *data, uint16_t length);
/* The next mail into r->mail, its length checked. */
ect_reader_result_t reader_receive_mail(ect_reader_t *r, uint64_t until_ns);

/* A CoE message: service, and `length` bytes behind the CoE header. */
ect_reader_result_t reader_send_coe(ect_reader_t *r, uint8_t service, const uint8_t *data, uint16_t length);
/* Whether a CoE message is the reply to a request; `data` behind the CoE header. */
typedef bool (*reader_match_t)(uint8_t service, const uint8_t *data, size_t length, const void *wanted);
/* The next CoE message that matches, others skipped. */
ect_reader_result_t reader_receive_coe(ect_reader_t *r, reader_match_t match, const void *wanted, const uint8_t **data,
                                       size_t *length);
/* Repeats a request while it stays without a usable reply. */
typedef ect_reader_result_t (*reader_request_t)(ect_reader_t *r, void *what);
ect_reader_result_t reader_repeat(ect_reader_t *r, reader_request_t request, void *what);

/* Whether an index is in r->objects. */
bool reader_is_listed(const ect_reader_t *r, unsigned int index);

#endif
