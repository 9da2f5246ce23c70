/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Mailbox protocols: CoE, FoE, EoE, VoE … as entries that a device names.
 *
 * A description lists the protocols that it offers (::ect_device_t::protocols); what nobody lists is not linked. The
 * mailbox itself knows none of them: it takes care of buffers, counters and repetitions, hands a request to the entry
 * of its type, and answers everything that no entry wants with a mailbox error. A new protocol is one file with one
 * entry; one that only a product speaks (VoE) stands in that product's folder and needs nothing but this header.
 *
 * A protocol keeps what it must remember in the device's instance (::ect_mailbox_instance), or where its own entry
 * says: an entry may be the first member of a larger constant structure, and each function is given the entry that was
 * named.
 *
 * Several entries may share a type: CoE is made of three (SDO, SDO information, emergencies). They are asked in the
 * order in which the device lists them.
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

/** PREOP, SAFEOP and OP: where every protocol but a firmware update is at home. */
#define ECT_IN_PREOP_AND_ABOVE (ECT_IN(2) | ECT_IN(4) | ECT_IN(8))

/** One protocol. Constant; any function may be NULL: there is nothing to do then. */
typedef struct ect_protocol ect_protocol_t;
struct ect_protocol {
    uint8_t type;    /**< ECT_MAILBOX_TYPE_... */
    uint16_t states; /**< ECT_IN(...): in other AL states it is answered as unsupported, and sends nothing */

    /**
     * A mail of this type has come. The answer, if there is one, is built and sent in here, with at most one mail; more
     * mails follow through `next`. A repeated request (same counter) does not come here: the mailbox repeats the
     * answer.
     * @param data    `length` (1 or more) bytes behind the mailbox header; valid only during the call
     * @return ECT_MAILBOX_OK · the detail of the error reply that the mailbox sends. ECT_MAILBOX_ERROR_SERVICE: not
     *         mine, the next entry of the same type is asked. With an error nothing may have been built.
     */
    uint16_t (*request)(const ect_protocol_t *self, ect_slave_t *slave, const uint8_t *data, uint16_t length);

    /**
     * A mail of its own: the rest of a list, an incoming frame, an emergency. From a call of
     * ::ect_mailbox_wake on it is asked whenever the mailbox is free, until no entry has a mail any more; and so when
     * the mailbox starts. An entry without `request` speaks before a waiting request is answered, others after: a
     * request may end what it was about to say.
     * @param send  true: build and send it now, if there is one · false: only tell
     * @return whether there is, or was, one
     */
    bool (*next)(const ect_protocol_t *self, ect_slave_t *slave, bool send);

    /** The mailbox starts, from INIT to PREOP or BOOT: forget what was under way. */
    void (*reset)(const ect_protocol_t *self, ect_slave_t *slave);
};

/* --- what the stack has ------------------------------------------------------------------------------------------- */

/** SDO server (ETG.1000.6 §5.6.2): expedited, normal, segmented, Complete Access. The least that CoE is. */
extern const ect_protocol_t ect_protocol_sdo;

/** SDO information (ETG.1000.6 §5.6.3). With ECT_COE_SDO_INFO in the CoE details. */
extern const ect_protocol_t ect_protocol_sdo_info;

/** CoE emergencies (ETG.1000.6 §5.6.4): sends what ::ect_host_t::emergency queues. */
extern const ect_protocol_t ect_protocol_emergency;

/* File access: seams/foe.h. */

/**
 * A protocol has, or is about to have, mails of its own: `next` will be asked. Once for any number of mails. From the
 * protocol's own functions, and from those of the device; costs a byte.
 */
void ect_mailbox_wake(ect_slave_t *slave);

/* --- what a protocol may call, from its own functions only -------------------------------------------------------- */

/** The instance of the slave's device. */
void *ect_mailbox_instance(const ect_slave_t *slave);

/** Bytes that a mail may carry behind its header, in the layout that the master chose: 10 to 1480. */
uint16_t ect_mailbox_room(const ect_slave_t *slave);

/**
 * Begins a mail; an older one of the slave is given up for it. Only while the mailbox is free: in `request`, and in
 * `next` with `send`; at most once in a call.
 * @return where its data begin: ect_mailbox_room() bytes, all 0
 */
uint8_t *ect_mailbox_build(ect_slave_t *slave);

/**
 * Sends what was built: counter and header are the mailbox's work. When the PDI fails, the mailbox tries again by
 * itself.
 * @param type    ECT_MAILBOX_TYPE_...
 * @param length  data bytes, 1..ect_mailbox_room()
 * Cost: two PDI accesses: of what is used of this mail, or was of the one before, and of a byte.
 */
void ect_mailbox_send(ect_slave_t *slave, uint8_t type, uint16_t length);

ECT_C_END

#endif
