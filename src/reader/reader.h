/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Reader of a slave: its EEPROM, its object dictionary, values, PDO mappings and assignments, over any wire.
 *
 * The reader trusts no reply. Every length, toggle, index and count that a slave sends is checked, every wait has a
 * timeout, every list an end, and the whole run a limit: against any slave a call returns, and uses no memory beyond
 * ::ect_reader_t and the buffers of the caller.
 *
 * The reader addresses the slave by its position, or by an existing station address. It writes mailbox
 * requests and the registers of the EEPROM interface. A slave in INIT or BOOT, or with the error flag set, goes to
 * PREOP, with SyncManagers 0 and 1 set from its EEPROM, and back to INIT in ::ect_reader_close; a slave in PREOP,
 * SAFEOP or OP keeps state and mailbox. ::ect_reader_config_t::changes forbids some or all of these changes. A master
 * that uses the same mailbox at the same time receives replies to the reader, and vice versa: ::ect_reader_hears_master
 * detects a master.
 *
 * Host only. One thread for a reader; calls block until the reply, the timeout or the limit.
 *
 * Clauses: ETG.1000.4 (datagrams, SyncManager mailbox, slave information interface), ETG.1000.6 clause 5.6 (CoE).
 */
#ifndef ECT_READER_READER_H
#define ECT_READER_READER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "wire/linkage.h"

/** A frame of maximum length, Ethernet header included, check sequence excluded. */
enum { ECT_READER_FRAME = 1514 };
/** Largest mailbox, in bytes: one datagram of one frame. A slave with a larger mailbox is refused. */
enum { ECT_READER_MAIL = 1486 };
/** Room for the line of ::ect_reader_t::text, terminator included. */
enum { ECT_READER_TEXT = 160 };
/** Limit of an EEPROM, bytes. A header that announces more is regarded as invalid: only the header is read. */
enum { ECT_READER_SII = 128 * 1024 };
/** Bytes of the header of an EEPROM. */
enum { ECT_READER_HEADER = 128 };
/** Limit of a value uploaded by ::ect_reader_dictionary, bytes; a longer value is reported as ECT_READER_TOO_LONG. */
enum { ECT_READER_VALUE = 4096 };

/** A connection: frames out, frames in, time. All functions are called with `ctx`, from the thread of the reader. */
typedef struct ect_reader_link {
    void *ctx;
    /** Sends a frame of `length` bytes, up to ::ECT_READER_FRAME. A frame that cannot be sent counts as lost. */
    void (*send)(void *ctx, const uint8_t *frame, size_t length);
    /**
     * Waits for the next frame, until `until_ns` at most.
     * @return length on the wire, above `room` if truncated; 0: no frame
     */
    size_t (*receive)(void *ctx, uint8_t *frame, size_t room, uint64_t until_ns);
    /** Monotonic time, nanoseconds. */
    uint64_t (*now)(void *ctx);
    /** Returns at `until_ns` or later. */
    void (*wait)(void *ctx, uint64_t until_ns);
} ect_reader_link_t;

/** Results of all calls. ::ect_reader_t::text describes each one but ECT_READER_OK. */
typedef enum ect_reader_result {
    ECT_READER_OK,
    ECT_READER_ABORTED,  /**< SDO abort or SDO information error: ::ect_reader_t::code */
    ECT_READER_REFUSED,  /**< mailbox error: ::ect_reader_t::code; AL status code: the state was refused */
    ECT_READER_SILENT,   /**< no reply within the timeout, after all tries */
    ECT_READER_WRONG,    /**< a reply that violates the standard */
    ECT_READER_TOO_LONG, /**< more bytes than the caller has room for; the transfer was aborted */
    ECT_READER_LOST,     /**< no frame returned, or no slave processed it */
    ECT_READER_STOPPED,  /**< ::ect_reader_config_t::progress returned false, `stopped` true, or the limit has passed */
    ECT_READER_DECLINED, /**< ::ect_reader_config_t::changes forbids a necessary change */
} ect_reader_result_t;

/** Changes of a slave that a reader may make. */
typedef enum ect_reader_changes {
    /** The state of a slave in INIT or BOOT, or with the error flag; the EEPROM is taken from the PDI. */
    ECT_READER_CHANGES_ALL,
    /** The state of a slave in INIT. A slave in PREOP, SAFEOP or OP keeps its state, even with the error flag. */
    ECT_READER_CHANGES_INIT,
    /** No state: a slave in INIT has no dictionary. */
    ECT_READER_CHANGES_NONE,
} ect_reader_changes_t;

/** Configuration of a reader. Zeroed: the first slave, with the defaults. */
typedef struct ect_reader_config {
    uint16_t position;  /**< in the segment, from 0 */
    uint16_t station;   /**< configured station address, for addressing; 0: addressing by position */
    uint32_t frame_ms;  /**< time after which a frame without a reply is sent again; 0: 500 */
    uint32_t reply_ms;  /**< longest wait for a reply by mail; 0: 2000 (ETG.2000 ResponseTimeout) */
    uint32_t state_ms;  /**< time after which a state change counts as refused; 0: 5000 */
    uint32_t limit_ms;  /**< of all calls of a reader together; 0: 600 000 */
    unsigned int tries; /**< for each request; 0: 3 */
    uint8_t counter;    /**< of the last mail that the slave has received, 1 to 7; 0: unknown */
    ect_reader_changes_t changes;
    void *progress_ctx; /**< first argument of `progress` */
    /** Called before each object (`done` of `all`) and each block of the EEPROM (bytes); false stops. NULL: none. */
    bool (*progress)(void *progress_ctx, const char *what, unsigned int done, unsigned int all);
    /** Called before each frame, also while the reader waits for a state or a mail, with the argument of `progress`;
     * true stops. ::ect_reader_close does not call it. NULL: none. */
    bool (*stopped)(void *progress_ctx);
} ect_reader_config_t;

/** Limit of the kept bytes of another master's mail. */
enum { ECT_READER_FOUND = 64 };

/** A reader. Set up by ::ect_reader_open; members are read only for others. */
typedef struct ect_reader {
    const ect_reader_link_t *link;
    ect_reader_config_t config;         /**< with defaults instead of zeros */
    uint64_t limit_ns;                  /**< time at which every call stops */
    uint16_t count;                     /**< slaves of the segment */
    uint8_t header[ECT_READER_HEADER];  /**< of the EEPROM, when the reader was opened */
    uint32_t vendor, product, revision; /**< of the header */
    uint16_t protocols;                 /**< of the EEPROM's header: ECT_MAILBOX_... */
    uint16_t out_start, out_size;       /**< mailbox to the slave; size 0: none in use */
    uint16_t in_start, in_size;         /**< mailbox from the slave */
    uint16_t found_status;              /**< AL status when the reader was opened */
    bool brought_up;                    /**< ::ect_reader_close returns the slave to INIT */
    bool sii_of_pdi;                    /**< ::ect_reader_close returns the EEPROM to the PDI */
    uint8_t found_sms[16];              /**< registers of SyncManagers 0 and 1 before ::ect_reader_preop */
    uint8_t index;                      /**< of the last datagram */
    uint8_t counter;                    /**< of the last mail sent, 1 to 7 */
    bool sent;                          /**< a mail was sent */
    bool plain; /**< the next mail has counter 0: the counter of another master's last mail is unknown (CLN-008) */
    uint16_t found_size;                  /**< bytes of `found_mail`; 0: none */
    uint8_t found_mail[ECT_READER_FOUND]; /**< the beginning of a mail that another master has left in SyncManager 1 */
    uint32_t last_sum;                    /**< check sum of the last mail received, counter included */
    unsigned int failures;                /**< successive requests without a usable reply */
    unsigned int skipped;            /**< mails that belonged to no request: emergencies, late and repeated replies */
    ect_reader_result_t result;      /**< of the last call */
    uint32_t code;                   /**< of ECT_READER_ABORTED and ECT_READER_REFUSED */
    char text[ECT_READER_TEXT];      /**< one line without a line end */
    uint8_t objects[0x10000 / 8];    /**< a bit for each index: each walk ends in 65 536 steps */
    uint8_t frame[ECT_READER_FRAME]; /**< being sent */
    uint8_t reply[ECT_READER_FRAME]; /**< being received */
    uint8_t mail[ECT_READER_MAIL];   /**< last one received */
    uint8_t data[ECT_READER_VALUE];  /**< of the dictionary's descriptions and values */
    uint8_t value[ECT_READER_VALUE];
} ect_reader_t;

/** Bytes within a reply, valid during the callback. */
typedef struct ect_reader_bytes {
    const uint8_t *data; /**< NULL: none */
    size_t length;
} ect_reader_bytes_t;

/** An object. */
typedef struct ect_reader_object {
    uint16_t index;
    bool described; /**< the next four members are known; else only values are */
    uint16_t type;
    uint8_t most;            /**< largest sub-index */
    uint8_t code;            /**< 7 VAR, 8 ARRAY, 9 RECORD */
    ect_reader_bytes_t name; /**< none if possibly truncated by the mailbox */
} ect_reader_object_t;

/** An entry of an object. */
typedef struct ect_reader_entry {
    uint8_t subindex;
    uint16_t type, bits, access;                       /**< as in SDO information */
    ect_reader_bytes_t name;                           /**< as of the object */
    ect_reader_bytes_t unit, preset, minimum, maximum; /**< in the byte order of the wire */
    ect_reader_bytes_t value;                          /**< uploaded; none: not requested, or unreadable */
} ect_reader_entry_t;

/** A missing part of the dictionary: the description of an object or entry, or a value. */
typedef struct ect_reader_gap {
    uint16_t index;
    uint8_t subindex;
    bool whole; /**< the description of the object; `subindex` is 0 */
    bool value; /**< the value of a described entry; false: a description */
    ect_reader_result_t result;
    uint32_t code; /**< of ECT_READER_ABORTED and ECT_READER_REFUSED */
} ect_reader_gap_t;

/** Values that ::ect_reader_dictionary uploads. */
typedef enum ect_reader_values {
    ECT_READER_IDENTITY_AND_PDOS, /**< 1000h, 1008h, 1018h, mappings 1600h–1BFFh, assignments 1C10h–1C2Fh */
    ECT_READER_ALL_VALUES,        /**< of all entries that are readable in PREOP */
} ect_reader_values_t;

/** Receives a dictionary: one call of `begin`, then each object, followed by its entries. */
typedef struct ect_reader_sink {
    void *ctx;
    void (*begin)(void *ctx, bool described); /**< NULL: not called */
    void (*object)(void *ctx, const ect_reader_object_t *object);
    void (*entry)(void *ctx, const ect_reader_object_t *object, const ect_reader_entry_t *entry);
    /** A request without a result, before the entry of the request; NULL: not called */
    void (*gap)(void *ctx, const ect_reader_gap_t *gap);
} ect_reader_sink_t;

ECT_C_BEGIN

/**
 * Listens for frames of a master. Call it before the reader sends a frame, because later frames may be the reader's
 * own.
 * @param ms  at most
 * @return true, at once: an EtherCAT frame was received
 */
bool ect_reader_hears_master(const ect_reader_link_t *link, uint32_t ms);

/**
 * Finds the slave and reads the header of its EEPROM. The AL state is unchanged.
 * @param link  must outlive the reader
 * @param config  copied; NULL: all defaults
 * @return ECT_READER_OK · ECT_READER_LOST no slave at that position · any result of ::ect_reader_sii. Call
 * ::ect_reader_close in each case.
 */
ect_reader_result_t ect_reader_open(ect_reader_t *r, const ect_reader_link_t *link, const ect_reader_config_t *config);

/** Restores the AL state, SyncManagers 0 and 1 and the owner of the EEPROM as found by ::ect_reader_open. */
void ect_reader_close(ect_reader_t *r);

/**
 * Takes the slave to a state with a mailbox. The functions below call it if necessary.
 * @return ECT_READER_OK · ECT_READER_REFUSED with the AL status code in `code` · ECT_READER_WRONG the EEPROM
 * describes no usable mailbox · ECT_READER_SILENT the state was not reached within the timeout · ECT_READER_LOST ·
 * ECT_READER_DECLINED the slave must keep a state without a mailbox
 */
ect_reader_result_t ect_reader_preop(ect_reader_t *r);

/**
 * Reads the EEPROM from its start.
 * @param size  bytes, a multiple of 4, up to ::ECT_READER_SII; 0: the size in the header
 * @param[out] image  room for `size` bytes, or for ::ECT_READER_SII
 * @param[out] read  bytes read, also on failure
 * Cost: four frames for each 4 or 8 bytes, as the ESC reads them, and polls while the interface is busy.
 * @return ECT_READER_OK · ECT_READER_SILENT the interface stays busy · ECT_READER_WRONG the EEPROM does not acknowledge
 * · ECT_READER_LOST · ECT_READER_STOPPED · ECT_READER_DECLINED the PDI is using it
 */
ect_reader_result_t ect_reader_sii(ect_reader_t *r, uint8_t *image, size_t size, size_t *read);

/**
 * As ::ect_reader_sii, up to the end mark of the categories: an image without the unused rest of a large EEPROM. The
 * header is the one that ::ect_reader_open has read.
 * @param[out] image  room for ::ECT_READER_SII bytes
 * @param[out] read  bytes read, a multiple of 4 and the end mark included; without one the size in the header, or
 * ::ECT_READER_SII when the header announces more
 * @return as ::ect_reader_sii
 */
ect_reader_result_t ect_reader_sii_content(ect_reader_t *r, uint8_t *image, size_t *read);

/**
 * Reads registers, in any state of the slave. The address is not checked: some registers change when they are read.
 * @param[out] data  `length` bytes, at most ::ECT_READER_MAIL; 0 where the slave has no register
 * @return ECT_READER_OK · ECT_READER_LOST · ECT_READER_STOPPED
 */
ect_reader_result_t ect_reader_registers(ect_reader_t *r, uint16_t address, void *data, uint16_t length);

/**
 * Uploads an entry, or an object by Complete Access: expedited, normal or segmented, as the slave replies.
 * Cost: about six frames for each mail, and polls until the reply.
 * @param subindex  with `complete` 0 or 1
 * @param[in,out] size  room in `data`; bytes read; with ECT_READER_TOO_LONG the size that the slave announces, if any
 * @return ECT_READER_OK · ECT_READER_ABORTED · ECT_READER_REFUSED · ECT_READER_SILENT · ECT_READER_WRONG ·
 * ECT_READER_TOO_LONG · ECT_READER_LOST · ECT_READER_STOPPED, and the results of ::ect_reader_preop. The content of
 * `data` is valid only with ECT_READER_OK.
 */
ect_reader_result_t ect_reader_upload(ect_reader_t *r, uint16_t index, uint8_t subindex, bool complete, void *data,
                                      size_t *size);

/**
 * Reads the list of objects into ::ect_reader_t::objects.
 * @param[out] count  objects in the list
 * @return as ::ect_reader_upload; ECT_READER_ABORTED or ECT_READER_REFUSED: no SDO information
 */
ect_reader_result_t ect_reader_list(ect_reader_t *r, size_t *count);

/** Reads the description of an object. @param[out] object  its name lies in the reader @return as ::ect_reader_list */
ect_reader_result_t ect_reader_object(ect_reader_t *r, uint16_t index, ect_reader_object_t *object);

/** Reads the description of an entry, without its value. @return as ::ect_reader_object */
ect_reader_result_t ect_reader_entry(ect_reader_t *r, uint16_t index, uint8_t subindex, ect_reader_entry_t *entry);

/**
 * Reads the dictionary in ascending order of the indices: by SDO information, or without it the values of identity,
 * assignments and the mappings that they name. A slave without CoE has no objects.
 * @return ECT_READER_OK, or the first result that ended it: the sink has received all objects up to there. Three
 * successive tries without a usable reply end the call; an entry refused by the slave does not.
 */
ect_reader_result_t ect_reader_dictionary(ect_reader_t *r, ect_reader_values_t values, const ect_reader_sink_t *sink);

/**
 * Reads the PDO assignments (1C10h and following) of some SyncManagers and the assigned mappings: values only, each
 * object once. The slave needs CoE.
 * @param sms  bit n: SyncManager n, 0 to 31
 * @return as ::ect_reader_dictionary
 */
ect_reader_result_t ect_reader_assigned(ect_reader_t *r, uint32_t sms, const ect_reader_sink_t *sink);

/**
 * Writes the dictionary as one JSON object: `slave`, counted from 1; `described`; `objects`, each with `index`, and
 * where the slave describes them `type`, `code`, `name`; `entries`, each with `subindex`, `type`, `bits`, `access`,
 * `name`, and as hexadecimal bytes of the wire `unit`, `default`, `minimum`, `maximum`, `value`; and `complete`, false
 * when the result is not ECT_READER_OK. The object is well-formed in each case. Write errors are left to ferror().
 * @return as ::ect_reader_dictionary
 */
ect_reader_result_t ect_reader_json(ect_reader_t *r, ect_reader_values_t values, FILE *file);

/** Writes the objects of ::ect_reader_assigned, in the form of ::ect_reader_json. @return as ::ect_reader_assigned */
ect_reader_result_t ect_reader_json_assigned(ect_reader_t *r, uint32_t sms, FILE *file);

ECT_C_END

#endif
