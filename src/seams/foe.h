/* SPDX-License-Identifier: MIT */
/**
 * @file
 * FoE, File access over EtherCAT: a master reads and writes files of a device by name. A firmware update is such a
 * write.
 *
 * A device that offers files has a constant `ect_foe_t` and lists its `protocol` member among its protocols
 * (::ect_device_t::protocols); otherwise nothing of FoE is linked. The device defines the content of a file: five
 * functions open, read, write and close it, piece by piece. Files may therefore have any size up to 4 GiB, without a
 * buffer of the file's size. One file is open at a time.
 *
 *     typedef struct board { ect_standard_t standard; ect_foe_transfer_t transfer; ... } board_t;
 *     static const ect_foe_t files = {ECT_FOE_PROTOCOL, offsetof(board_t, transfer), .write_states = ECT_IN(3),
 *                                     .open = open_slot, .write = program, .ready = is_programmed, .close = swap};
 *     static const ect_protocol_t *const protocols[] = {&ect_protocol_sdo, &files.protocol, NULL};
 *
 * In the description, `mailbox_protocols` contains ECT_MAILBOX_FOE, and a device with BOOT has `boot_out` and
 * `boot_in`.
 *
 * Time: a function must not block the slave. It starts a long operation (erasing, programming, checking) and returns
 * ECT_FOE_LATER; the reply to the master then waits until `ready` reports the end of the operation. A master waits as
 * long as for any reply (the caller of SOEM chooses the timeout, usually 0.7 s). With `busy_ms`, the master gets a
 * BUSY. Not every master supports BUSY: SOEM 1.4 regards a BUSY as the end of the file.
 *
 * The protocol itself handles packet numbers, the end of a file (a packet shorter than the mailbox), repeated packets
 * and acknowledges, errors with their code, timeouts and BUSY.
 *
 * A written file must not take effect before `close` confirms it, because a transfer may end after any packet.
 *
 * Context: all functions run in mainline, as those of `ect_protocol_t`.
 *
 * Clauses: ETG.1000.6 §5.8.
 */
#ifndef ECT_SEAMS_FOE_H
#define ECT_SEAMS_FOE_H

#include <stddef.h>

#include "seams/mailbox.h"

/** Error codes (ETG.1000.6 §5.8.5, with later additions). */
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

/** Results of the device's functions other than an error code. */
enum { ECT_FOE_OK = 0, ECT_FOE_LATER = 1 };

/** A file that a master wants to open. */
typedef struct ect_foe_file {
    const char *name; /**< `length` bytes, 1 or more, of any value; not zero-terminated; valid during the call */
    uint16_t length;
    uint32_t password; /**< 0: none */
    bool write;
    uint8_t state; /**< AL state */
} ect_foe_file_t;

/** A transfer under way, in the device's instance, zero at power-on. Private. */
typedef struct ect_foe_transfer {
    uint64_t activity_ns; /* last request of the master, or last delayed reply */
    uint64_t pending_ns;  /* start of the wait for the device */
    uint32_t offset;      /* of the next piece (writing), of the packet in the mailbox (reading) */
    uint32_t packet;      /* number of the last packet taken (writing), of the packet in the mailbox (reading) */
    uint16_t length;      /* of the packet in the mailbox */
    uint8_t doing;        /* nothing, reading, writing */
    bool pending;         /* a reply waits for the device */
    bool busy_sent;
    bool finished; /* writing: the last packet was taken */
} ect_foe_transfer_t;

/** The files of a device: struct ect_foe. */
typedef struct ect_foe ect_foe_t;

/**
 * The files of a device. Each function gets the entry, which may be the first member of a larger constant structure,
 * and the device's instance. With an error it may set `*text` to a constant text (ISO 646) for the error reply. After
 * an error the file is closed, without a call of `close`.
 */
struct ect_foe {
    ect_protocol_t protocol; /**< ECT_FOE_PROTOCOL; the first member */
    size_t offset;           /**< of an ::ect_foe_transfer_t in the instance, aligned */
    uint16_t read_states;  /**< ECT_IN(...): states in which files can be read; in others the reply is 8008h or 8009h */
    uint16_t write_states; /**< states in which files can be written, likewise */
    uint32_t timeout_ms;   /**< a transfer ends after this time without a request or a delayed reply; 0: 10000 */
    uint32_t busy_ms;      /**< a master that writes gets BUSY after this time; 0: never */

    /**
     * Opens a file.
     * @return ECT_FOE_OK · ECT_FOE_LATER: the file is being opened, `ready` reports the end · an error code: it cannot
     * be opened
     */
    uint32_t (*open)(const ect_foe_t *foe, void *instance, const ect_foe_file_t *file, const char **text);
    /**
     * Reads the next piece of the open file. The last piece may be requested again, earlier ones are not. NULL: no file
     * can be read.
     * @param offset  bytes from the start of the file, ascending without gaps
     * @param[in,out] length  room, at least 1; then the bytes read: fewer than the room mark the end of the file
     * @return ECT_FOE_OK · ECT_FOE_LATER: the piece is requested again once `ready` reports ECT_FOE_OK · an error code
     */
    uint32_t (*read)(const ect_foe_t *foe, void *instance, uint32_t offset, void *data, uint16_t *length,
                     const char **text);
    /**
     * Writes the next piece of the open file. NULL: no file can be written.
     * @param data  `length` bytes (0 or more), valid during the call
     * @param last  this is the end of the file, which can be verified now
     * @return ECT_FOE_OK · ECT_FOE_LATER: the piece is taken, and `ready` reports when the next one may follow, or an
     *         error · an error code
     */
    uint32_t (*write)(const ect_foe_t *foe, void *instance, uint32_t offset, const void *data, uint16_t length,
                      bool last, const char **text);
    /**
     * Reports the state of an operation that returned ECT_FOE_LATER. Called at each poll of the slave, at least every
     * millisecond. NULL: no operation returns ECT_FOE_LATER.
     * @return ECT_FOE_LATER · ECT_FOE_OK: complete · an error code
     */
    uint32_t (*ready)(const ect_foe_t *foe, void *instance, const char **text);
    /**
     * Ends a transfer. May be NULL.
     * @param whole  true: the master has read the whole file; or it has written the whole file, whose last acknowledge
     * is about to be sent, and the file takes effect. false: the master gave up, stopped sending, or violated the
     * protocol; the device discards the written data
     */
    void (*close)(const ect_foe_t *foe, void *instance, bool whole);
};

ECT_C_BEGIN

/** Handles a request, for ECT_FOE_PROTOCOL only. */
uint16_t ect_foe_request(const ect_protocol_t *self, ect_slave_t *slave, const uint8_t *data, uint16_t length);
/** Sends a delayed reply, for ECT_FOE_PROTOCOL only. */
bool ect_foe_next(const ect_protocol_t *self, ect_slave_t *slave, bool send);
/** Ends the transfer under way, for ECT_FOE_PROTOCOL only. */
void ect_foe_reset(const ect_protocol_t *self, ect_slave_t *slave);

ECT_C_END

/** Served in every state with a mailbox; in a state without access to files the reply is an FoE error. */
#define ECT_FOE_PROTOCOL                                                                                               \
    {.type = ECT_MAILBOX_TYPE_FOE,                                                                                     \
     .states = ECT_IN_PREOP_AND_ABOVE | ECT_IN(3),                                                                     \
     .request = ect_foe_request,                                                                                       \
     .next = ect_foe_next,                                                                                             \
     .reset = ect_foe_reset}

#endif
