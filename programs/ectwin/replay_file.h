/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Replay of captures on the virtual clock: of our own records, in which every reply must be equal (replay_record.c),
 * and of captures of a bus, which are compared with twins (replay_bus.c).
 */
#ifndef ECTWIN_REPLAY_FILE_H
#define ECTWIN_REPLAY_FILE_H

#include <stdbool.h>
#include <stdint.h>

#include "bus/capture/logged.h"
#include "bus/capture/reader.h"
#include "commands.h"

/** Exit status of a replay that found a difference. */
enum { EXIT_DIFFERS = 1 };

typedef struct replay {
    const char *path;
    ect_reader_t reader;
    ect_item_t ahead; /**< the next item of the file; its bytes are the reader's */
    ect_item_t item;  /**< the present item; its bytes are a copy */
    uint8_t *bytes;   /**< ECT_READER_BLOCK bytes for that copy */
    int status;       /**< so far */
    bool data;        /**< --data */
    uint64_t requests, replies;
    bool begun;                 /**< the section has had a request */
    uint64_t first_ns, last_ns; /**< of its requests */
    uint64_t bus_ns;            /**< time of the bus from first to last request, of all sections */
} replay_t;

/** Moves on: `ahead` becomes `item`, with the bytes of a frame, and the next item is read. */
void replay_next(replay_t *r);

/** Counts the present item as a request. A file may hold any times; that of the bus never goes back. */
void replay_count_request(replay_t *r);

/** Ends with one line about the file; `status` becomes EXIT_OPEN. */
void replay_wrong(replay_t *r, const char *format, ...) __attribute__((format(printf, 2, 3)));

/** Reads the words of a run as `run` and `with` do, at the power-on of a record. Wrong words end the program with
 * EXIT_OPEN. @param words  `count` of them, behind a name; they outlive the twins */
void replay_words(twin_args_t *twins, int count, char **words);

/** Replays a section of our own whose start is the present item, up to the next section. */
void replay_record(replay_t *r);

/** Compares all packets that are left with twins, and prints where these differ (docs/REPLAY.md). */
void replay_bus(replay_t *r, twin_args_t *twins);

/** Offset of the first datagram in a frame. */
enum { REPLAY_HEADS = 16 };

/** @return bytes of the datagram at an offset, with its header and counter; 0: the frame does not hold all of it */
size_t replay_datagram(const uint8_t *frame, size_t length, size_t at);

/** Whether a datagram has a logical address. */
bool replay_is_logical(const uint8_t *datagram);

/** A datagram of two frames, of equal layout up to it, that differs. */
typedef struct replay_difference {
    size_t number, count; /**< from 1; of the datagrams in the expected frame */
    size_t at, length;    /**< offset in the frame, bytes of data; at 0: outside of datagrams */
} replay_difference_t;

/** Finds the first datagram that differs; only for frames that differ. */
replay_difference_t replay_compare(const uint8_t *expected, size_t expected_length, const uint8_t *got,
                                   size_t got_length);

/** Names the slaves that a request addresses: "slave 2", "slaves 1 and 3, FMMUs". @param datagram  as the master has
 * sent it. @param[out] text  room bytes */
void replay_slaves(ect_chain_t *chain, const uint8_t *datagram, char *text, size_t room);

/** Position of the slave that a datagram with a position or a station address reaches first. @return the number of
 * twins: none, or no such command */
size_t replay_slave(ect_chain_t *chain, const uint8_t *datagram);

#endif
