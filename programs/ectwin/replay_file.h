/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Replay of files on the virtual clock: of records, in which every reply must be equal (replay_record.c), and of
 * captures of a bus, which are compared with twins (replay_bus.c).
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
    ect_item_t ahead; /**< the next item of the file; its bytes belong to the reader */
    ect_item_t item;  /**< the present item; its bytes are a copy in `bytes` */
    uint8_t *bytes;   /**< ECT_READER_BLOCK bytes */
    int status;       /**< exit status for the items replayed so far */
    bool data;        /**< --data */
    uint64_t requests, replies;
    bool begun;                 /**< the section has had a request */
    uint64_t first_ns, last_ns; /**< times of the first and the last request of the section */
    uint64_t bus_ns;            /**< sum of the times from first to last request of all sections */
} replay_t;

/** Advances: copies `ahead`, with the bytes of a frame, to `item`, and reads the next item. */
void replay_next(replay_t *r);

/** Counts the present item as a request. The time of the bus never goes back, whatever the times in the file. */
void replay_count_request(replay_t *r);

/** Prints one line about an invalid file and sets `status` to EXIT_OPEN. */
void replay_wrong(replay_t *r, const char *format, ...) __attribute__((format(printf, 2, 3)));

/**
 * Parses the command line of a recorded run as `run` and `with` do. Wrong words end the program with EXIT_OPEN.
 * @param words  `count` words after a program name; they outlive the twins
 */
void replay_words(twin_args_t *twins, int count, char **words);

/** Replays the section of a record that starts with the present item. */
void replay_record(replay_t *r);

/** Compares all remaining packets with twins, and prints the differences (docs/REPLAY.md). */
void replay_bus(replay_t *r, twin_args_t *twins);

/** Offset of the first datagram in a frame. */
enum { REPLAY_HEADS = 16 };

/** @return bytes of the datagram at an offset, with its header and counter; 0: the frame does not hold all of it */
size_t replay_datagram(const uint8_t *frame, size_t length, size_t at);

/** Whether a datagram has a logical address. */
bool replay_is_logical(const uint8_t *datagram);

/** The first difference between two frames: a datagram. The frames have the same layout up to this datagram. */
typedef struct replay_difference {
    size_t number, count; /**< number of the datagram, from 1, and number of datagrams in the expected frame */
    size_t at, length;    /**< offset in the frame, bytes of data; `at` 0: outside of datagrams */
} replay_difference_t;

/** Finds the first difference between two different frames. */
replay_difference_t replay_compare(const uint8_t *expected, size_t expected_length, const uint8_t *got,
                                   size_t got_length);

/**
 * Names the slaves that a request addresses: "slave 2", "slaves 1 and 3, FMMUs".
 * @param datagram    as sent by the master
 * @param[out] text   `room` bytes
 */
void replay_slaves(ect_chain_t *chain, const uint8_t *datagram, char *text, size_t room);

/**
 * Finds the first slave that a datagram with a position or station address reaches.
 * @return position of the slave; the number of twins: none, or another kind of address
 */
size_t replay_slave(ect_chain_t *chain, const uint8_t *datagram);

#endif
