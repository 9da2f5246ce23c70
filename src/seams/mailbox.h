/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Mailbox protocols: CoE, FoE, EoE, VoE … as entries that a device names.
 *
 * A description lists the protocols that it offers (::ect_device_t::protocols); a protocol that no description lists is
 * not linked. The mailbox does not depend on any protocol: it manages buffers, counters and repetitions, passes a
 * request to the entry of its type, and replies with a mailbox error if no entry accepts the request. A new protocol is
 * one file with one entry; a protocol of a single product (VoE) belongs in the folder of that product and includes only
 * this header.
 *
 * A protocol keeps its state in the device's instance (::ect_mailbox_instance), or where its own entry points: an entry
 * may be the first member of a larger constant structure, and each function gets the entry that the description names.
 *
 * Several entries may share a type: CoE consists of three (SDO, SDO information, emergencies). The mailbox tries them
 * in the order in which the device lists them.
 *
 * Context: all functions of an entry run in mainline, one at a time for a slave, and must not block. The cyclic
 * exchange may interrupt them (docs/CONCURRENCY.md).
 *
 * Clauses: ETG.1000.4 §5.6, §6.7 (mailbox), ETG.1000.6 §5 (protocols).
 */
#ifndef ECT_SEAMS_MAILBOX_H
#define ECT_SEAMS_MAILBOX_H

#include <stdbool.h>
#include <stdint.h>

#include "wire/linkage.h"

ECT_C_BEGIN

/** A slave (slave/slave.h); opaque to protocols of a device. */
typedef struct ect_slave ect_slave_t;

/** Types of mail: bits 0..3 of a mail's byte 5 (ETG.1000.4 Table 29). */
enum {
    ECT_MAILBOX_TYPE_ERROR = 0,
    ECT_MAILBOX_TYPE_AOE = 1,
    ECT_MAILBOX_TYPE_EOE = 2,
    ECT_MAILBOX_TYPE_COE = 3,
    ECT_MAILBOX_TYPE_FOE = 4,
    ECT_MAILBOX_TYPE_SOE = 5,
    ECT_MAILBOX_TYPE_VOE = 15,
};

/** Details of a mailbox error reply (ETG.1000.4 Table 30). */
enum {
    ECT_MAILBOX_OK = 0,
    ECT_MAILBOX_ERROR_SYNTAX = 1,
    ECT_MAILBOX_ERROR_PROTOCOL = 2,
    ECT_MAILBOX_ERROR_CHANNEL = 3,
    ECT_MAILBOX_ERROR_SERVICE = 4,
    ECT_MAILBOX_ERROR_HEADER = 5,
    ECT_MAILBOX_ERROR_TOO_SHORT = 6,
    ECT_MAILBOX_ERROR_NO_MEMORY = 7,
    ECT_MAILBOX_ERROR_SIZE = 8,
};

/** A set of AL states: ECT_IN(ECT_STATE_BOOT) | … (seams/device.h). */
#define ECT_IN(state) (1u << (state))

/** PREOP, SAFEOP and OP: the states of every protocol except a firmware update. */
#define ECT_IN_PREOP_AND_ABOVE (ECT_IN(2) | ECT_IN(4) | ECT_IN(8))

/** One protocol. Constant. Any function may be NULL: the protocol then has nothing to do there. */
typedef struct ect_protocol ect_protocol_t;
struct ect_protocol {
    uint8_t type;    /**< ECT_MAILBOX_TYPE_... */
    uint16_t states; /**< ECT_IN(...); in other AL states its mails are refused as unsupported, and it sends none */

    /**
     * Handles a request of this type. The function builds and sends the reply, if there is one, in at most one mail;
     * further mails follow through `next`. A repeated request (same counter) is not passed: the mailbox repeats the
     * reply.
     * @param data    `length` (1 or more) bytes after the mailbox header; valid only during the call
     * @return ECT_MAILBOX_OK · the detail of the error reply that the mailbox sends, in which case the function must
     * not have built a mail. ECT_MAILBOX_ERROR_SERVICE passes the request on to the next entry of the same type.
     */
    uint16_t (*request)(const ect_protocol_t *self, ect_slave_t *slave, const uint8_t *data, uint16_t length);

    /**
     * Sends a mail that is no direct reply: the rest of a list, an incoming frame, an emergency. After
     * ::ect_mailbox_wake, and after the start of the mailbox, the mailbox calls this whenever it is free, until no
     * entry has a mail left. An entry without `request` is called before a waiting request is handled, any other entry
     * after it, because the request may cancel the mail.
     * @param send  true: build and send the mail now, if there is one · false: only report whether there is one
     * @return whether there is, or was, a mail to send
     */
    bool (*next)(const ect_protocol_t *self, ect_slave_t *slave, bool send);

    /** Cancels all transfers: the mailbox starts, from INIT to PREOP or BOOT. */
    void (*reset)(const ect_protocol_t *self, ect_slave_t *slave);
};

/* --- protocols of the stack --------------------------------------------------------------------------------------- */

/** SDO server (ETG.1000.6 §5.6.2): expedited, normal, segmented, Complete Access. The minimum of CoE. */
extern const ect_protocol_t ect_protocol_sdo;

/** SDO information (ETG.1000.6 §5.6.3). The CoE details of the description then include ECT_COE_SDO_INFO. */
extern const ect_protocol_t ect_protocol_sdo_info;

/** CoE emergencies (ETG.1000.6 §5.6.4): sends the emergencies that ::ect_host_t::emergency has queued. */
extern const ect_protocol_t ect_protocol_emergency;

/* File access: seams/foe.h. */

/**
 * Announces mails of a protocol's own: the mailbox will call `next`. One call is enough for any number of mails. May be
 * called from the functions of the protocol and of the device. Cost: one byte is set.
 */
void ect_mailbox_wake(ect_slave_t *slave);

/* --- functions that a protocol may call, from its own functions only ---------------------------------------------- */

/** The instance of the slave's device. */
void *ect_mailbox_instance(const ect_slave_t *slave);

/** Room for data in a mail, behind its header, in the layout that the master chose: 10 to 1480 bytes. */
uint16_t ect_mailbox_room(const ect_slave_t *slave);

/**
 * Starts a mail; an older mail that the slave kept for repetition is discarded. Only while the mailbox is free: in
 * `request`, and in `next` with `send`; at most once in a call.
 * @return the data of the mail: ect_mailbox_room() bytes, all 0
 */
uint8_t *ect_mailbox_build(ect_slave_t *slave);

/**
 * Sends the mail that was built; the mailbox fills in counter and header. After a failed PDI access the mailbox repeats
 * the attempt by itself. Cost: two PDI accesses, one of the bytes that this mail or the one before it uses, and one of
 * a single byte.
 * @param slave   the slave of the function's argument
 * @param type    ECT_MAILBOX_TYPE_...
 * @param length  data bytes, 1..ect_mailbox_room()
 */
void ect_mailbox_send(ect_slave_t *slave, uint8_t type, uint16_t length);

ECT_C_END

#endif
