/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Reader of capture files: pcapng and pcap in either byte order, with times of any resolution. Any file is safe to
 * read: an invalid length is an error of one line, and at most ECT_READER_BLOCK bytes are in memory.
 *
 * Context: any; one thread for each file. Cost: a copy of the bytes.
 */
#ifndef ECT_BUS_CAPTURE_READER_H
#define ECT_BUS_CAPTURE_READER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "wire/linkage.h"

ECT_C_BEGIN

/** Longest block, most interfaces of a section, room for a message. */
enum { ECT_READER_BLOCK = 1024 * 1024, ECT_READER_INTERFACES = 64, ECT_READER_MESSAGE = 256 };

typedef enum ect_item_kind {
    ECT_ITEM_END,     /**< the file has no more items */
    ECT_ITEM_WRONG,   /**< the file is invalid from here on: reader->message is the reason */
    ECT_ITEM_SECTION, /**< a section begins; a pcap file is one section */
    ECT_ITEM_PACKET,
    ECT_ITEM_LOCAL, /**< a local block (::ect_pcapng_local) */
} ect_item_kind_t;

typedef struct ect_item {
    ect_item_kind_t kind;
    uint64_t number;  /**< of a packet, in the whole file, from 1 */
    uint64_t time_ns; /**< of a packet */
    uint32_t interface;
    unsigned int direction; /**< of a packet: ::ect_pcapng_direction_t; 0: not in the file */
    const uint8_t *bytes;   /**< of a packet or a local block; valid until the next call of ::ect_reader_next */
    size_t captured;        /**< bytes at `bytes` */
    size_t length;          /**< of a packet, on the wire */
} ect_item_t;

/** Resolution of the times of an interface: 10^-n s, or 2^-n s. */
typedef struct ect_reader_interface {
    bool ethernet, binary;
    uint8_t exponent;
} ect_reader_interface_t;

/** A reader. Set `file` and zero the other members, which are private except `message`. */
typedef struct ect_reader {
    FILE *file; /**< the caller's */
    char message[ECT_READER_MESSAGE];
    enum { ECT_READER_NEW, ECT_READER_PCAPNG, ECT_READER_PCAP, ECT_READER_OVER } state;
    bool swapped;     /* numbers are big-endian */
    bool nanoseconds; /* of a pcap file */
    uint64_t at;      /* offset of the present block */
    uint64_t packets;
    ect_reader_interface_t interfaces[ECT_READER_INTERFACES];
    uint32_t interface_count;
    uint8_t *block; /* ECT_READER_BLOCK bytes */
} ect_reader_t;

/** Reads the next item. After ECT_ITEM_END or ECT_ITEM_WRONG further calls return ECT_ITEM_END. */
ect_item_kind_t ect_reader_next(ect_reader_t *reader, ect_item_t *item);

/** Frees the reader's memory; the file stays open. */
void ect_reader_free(ect_reader_t *reader);

ECT_C_END

#endif
