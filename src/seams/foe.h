/* SPDX-License-Identifier: MIT */
/**
 * @file
 * FoE, File access over EtherCAT: a master reads and writes files of a device by name. A firmware update is one of
 * them.
 *
 * A device that offers files has an ::ect_foe_t, constant, and names its `protocol` member among its protocols
 * (::ect_device_t::protocols); nothing of FoE is linked otherwise. What a file is, the device alone knows: five
 * functions of it open, read, write and close one, piece by piece, so files may be of any size up to 4 GiB and no
 * buffer of a file's size exists. One file is open at a time.
 *
 *     typedef struct board { ect_standard_t standard; ect_foe_transfer_t transfer; ... } board_t;
 *     static const ect_foe_t files = {ECT_FOE_PROTOCOL, offsetof(board_t, transfer), .write_states = ECT_IN(3),
 *                                     .open = open_slot, .write = program, .ready = is_programmed, .close = swap};
 *     static const ect_protocol_t *const protocols[] = {&ect_protocol_sdo, &files.protocol, NULL};
 *
 * and in its description `mailbox_protocols` has ECT_MAILBOX_FOE; with BOOT also `boot_out` and `boot_in`.
 *
 * Time: a function must not block the slave. What takes long (erasing, programming, checking) is begun, and
 * ECT_FOE_LATER is returned: the master's answer waits until `ready` says that it is done. Masters wait for it as long
 * as for any answer (SOEM's caller chooses, usually 0.7 s); one who understands BUSY is told so after `busy_ms`. Not
 * all do: SOEM 1.4 takes a BUSY for the end of the file.
 *
 * What the protocol does by itself: packet numbers, the end of a file (a packet shorter than the mailbox), packets and
 * acknowledges that come a second time, errors with their code, time-outs, BUSY.
 *
 * A file that was written must not count before `close` says so: a transfer may end after any packet.
 *
 * Context: all functions run in mainline, as those of ::ect_protocol_t.
 *
 * Clauses: ETG.1000.6 §5.8.
 */
#ifndef ECT_SEAMS_FOE_H
#define ECT_SEAMS_FOE_H

#include <stddef.h>

#include "seams/mailbox.h"

/** Error codes that a master is told (ETG.1000.6 §5.8.5, and those that came later). */
enum {
    ECT_FOE_UNDEFINED = 0x8000,
    ECT_FOE_NOT_FOUND = 0x8001,
    ECT_FOE_ACCESS = 0x8002, /**< wrong name or password */
    ECT_FOE_DISK_FULL = 0x8003,
    ECT_FOE_ILLEGAL = 0x8004,
    ECT_FOE_PACKET_NUMBER = 0x8005,
    ECT_FOE_EXISTS = 0x8006,
    ECT_FOE_NO_USER = 0x8007,
    ECT_FOE_BOOT_ONLY = 0x8008,
    ECT_FOE_NOT_IN_BOOT = 0x8009,
    ECT_FOE_NO_RIGHTS = 0x800A,
    ECT_FOE_PROGRAM_ERROR = 0x800B,
    ECT_FOE_CHECKSUM = 0x800C,
};

/** What a function of the device returns beside an error code. */
enum { ECT_FOE_OK = 0, ECT_FOE_LATER = 1 };

/** A file that a master wants. */
typedef struct ect_foe_wish {
    const char *name; /**< `length` bytes, 1 or more, anything in them, no zero behind; valid during the call */
    uint16_t length;
    uint32_t password; /**< 0: none was given */
    bool write;
    uint8_t state; /**< AL state */
} ect_foe_wish_t;

/** A transfer under way, in the device's instance, zero at power-on. Private. */
typedef struct ect_foe_transfer {
    uint64_t heard_ns;   /* when the master was heard last, or when a reply that had to wait was given */
    uint64_t pending_ns; /* since when the device keeps the master waiting */
    uint32_t offset;     /* of what comes next (writing), of the packet that is out (reading) */
    uint32_t packet;     /* taken last (writing), out (reading) */
    uint16_t length;     /* of the packet that is out */
    uint8_t doing;       /* nothing, reading, writing */
    bool pending;        /* an answer waits for the device */
    bool told_busy;
    bool finished; /* the last packet of a file that is written was taken */
} ect_foe_transfer_t;

typedef struct ect_foe ect_foe_t;

/**
 * The files of a device. Each function is given the entry, which may be the first member of a larger constant
 * structure, and the device's instance; `*text` may be set to a constant text of ISO 646 that goes with an error.
 * After an error the file is closed, without `close`.
 */
struct ect_foe {
    ect_protocol_t protocol; /**< ECT_FOE_PROTOCOL; the first member */
    size_t offset;           /**< of an ::ect_foe_transfer_t in the instance, aligned */
    uint16_t read_states;    /**< ECT_IN(...): where files can be read; elsewhere the answer is 8008h or 8009h */
    uint16_t write_states;   /**< where they can be written */
    uint32_t timeout_ms;     /**< without a word from the master, or from the device, the transfer ends; 0: 10000 */
    uint32_t busy_ms;        /**< after which a master who writes is told BUSY; 0: never */

    /**
     * Opens a file.
     * @return ECT_FOE_OK · ECT_FOE_LATER it is being opened: `ready` · an error code: there is none
     */
    uint32_t (*open)(const ect_foe_t *foe, void *instance, const ect_foe_wish_t *wish, const char **text);
    /**
     * Reads the open file. The same piece may be asked for again, that before the last is not. NULL: none can be read.
     * @param offset  bytes from its start, rising without gaps
     * @param[in,out] length  room, at least 1; bytes that were read: fewer than room is the end of the file
     * @return ECT_FOE_OK · ECT_FOE_LATER: `ready`, then it is asked again · an error code
     */
    uint32_t (*read)(const ect_foe_t *foe, void *instance, uint32_t offset, void *data, uint16_t *length,
                     const char **text);
    /**
     * Takes a piece of the open file. NULL: none can be written.
     * @param data  `length` bytes (0 or more), valid during the call
     * @param last  the file ends here: it can be checked
     * @return ECT_FOE_OK · ECT_FOE_LATER: taken, and `ready` tells when the next may come, or what is wrong · an error
     *         code
     */
    uint32_t (*write)(const ect_foe_t *foe, void *instance, uint32_t offset, const void *data, uint16_t length,
                      bool last, const char **text);
    /**
     * What was begun with ECT_FOE_LATER: asked at each poll of the slave, and at least every millisecond. NULL: nothing
     * ever takes long.
     * @return ECT_FOE_LATER · ECT_FOE_OK it is done · an error code
     */
    uint32_t (*ready)(const ect_foe_t *foe, void *instance, const char **text);
    /**
     * The transfer is over. May be NULL.
     * @param whole  the master has all of a file that was read; or, of one that was written, the acknowledge of the
     * last packet is on its way: now it counts. false: the master gave up, was not heard any more, or sent nonsense:
     * forget it
     */
    void (*close)(const ect_foe_t *foe, void *instance, bool whole);
};

ECT_C_BEGIN

/** The functions behind ECT_FOE_PROTOCOL. For the mailbox only. */
uint16_t ect_foe_request(const ect_protocol_t *self, ect_slave_t *slave, const uint8_t *data, uint16_t length);
bool ect_foe_next(const ect_protocol_t *self, ect_slave_t *slave, bool send);
void ect_foe_reset(const ect_protocol_t *self, ect_slave_t *slave);

ECT_C_END

/** In every state with a mailbox: where files are not at home the master is told so. */
#define ECT_FOE_PROTOCOL                                                                                               \
    {.type = ECT_MAILBOX_TYPE_FOE,                                                                                     \
     .states = ECT_IN_PREOP_AND_ABOVE | ECT_IN(3),                                                                     \
     .request = ect_foe_request,                                                                                       \
     .next = ect_foe_next,                                                                                             \
     .reset = ect_foe_reset}

#endif
