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
/* Limits: mails skipped by a request because they are no replies, and successive failed requests. */
enum { SKIPS = 64, FAILURES = 3 };

/* Records a result and its text. @return the result */
ect_reader_result_t reader_report(ect_reader_t *r, ect_reader_result_t result, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
ect_reader_result_t reader_good(ect_reader_t *r);
/* @return whether the user has stopped the reader; on true the result is recorded */
bool reader_is_stopped(ect_reader_t *r);
/* The same, or the limit has passed. */
bool reader_is_over(ect_reader_t *r);
/* @return whether the run continues (ect_reader_config_t::progress) */
bool reader_progress(ect_reader_t *r, const char *what, unsigned int done, unsigned int all);
uint64_t reader_now(const ect_reader_t *r);
/* A pause between two polls: short at first, then up to 1 ms. */
void reader_pause(const ect_reader_t *r, unsigned int polls);

/* Sends a datagram until a reply arrives, at most ect_reader_config_t::tries times. `command`: APRD, APWR or BRD.
 * @return false: no frame came back, or the limit of all calls was reached. *wkc: slaves that processed the datagram */
bool reader_ask(ect_reader_t *r, uint8_t command, uint16_t address, uint8_t *data, uint16_t length, uint16_t *wkc);
/* Sends a datagram to the slave, and repeats it when a frame is lost or not processed: not for accesses with side
 * effects. */
ect_reader_result_t reader_get(ect_reader_t *r, uint16_t address, uint8_t *data, uint16_t length);
ect_reader_result_t reader_put(ect_reader_t *r, uint16_t address, const uint8_t *data, uint16_t length);
uint16_t reader_load16(const uint8_t *bytes);

enum { APRD = 1, APWR = 2, FPRD = 4, FPWR = 5, BRD = 7 };

/* Sends a mail of a type; empties the mailbox from the slave before. */
ect_reader_result_t reader_send_mail(ect_reader_t *r, uint8_t type, const uint8_t *data, uint16_t length);
/* Receives the next mail into r->mail, and checks its length. */
ect_reader_result_t reader_receive_mail(ect_reader_t *r, uint64_t until_ns);

/* Sends a CoE message: service, and `length` bytes after the CoE header. */
ect_reader_result_t reader_send_coe(ect_reader_t *r, uint8_t service, const uint8_t *data, uint16_t length);
/* Returns whether a CoE message is the reply to a request; `data` begins after the CoE header. */
typedef bool (*reader_match_t)(uint8_t service, const uint8_t *data, size_t length, const void *wanted);
/* Receives the next CoE message that matches; other messages are skipped. */
ect_reader_result_t reader_receive_coe(ect_reader_t *r, reader_match_t match, const void *wanted, const uint8_t **data,
                                       size_t *length);
/* Repeats a request until a usable reply arrives, at most ect_reader_config_t::tries times. */
typedef ect_reader_result_t (*reader_request_t)(ect_reader_t *r, void *what);
ect_reader_result_t reader_repeat(ect_reader_t *r, reader_request_t request, void *what);

/* @return whether an index is in r->objects. */
bool reader_is_listed(const ect_reader_t *r, unsigned int index);

#endif
