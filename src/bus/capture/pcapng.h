/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Blocks of a pcapng file (draft-ietf-opsawg-pcapng): section, interface, packet, statistics, and local data, which
 * other programs skip. Numbers are little-endian, times are nanoseconds.
 *
 * The functions write to memory. Context: any. Cost: a copy of the bytes.
 */
#ifndef ECT_BUS_CAPTURE_PCAPNG_H
#define ECT_BUS_CAPTURE_PCAPNG_H

#include <stddef.h>
#include <stdint.h>

#include "wire/linkage.h"

ECT_C_BEGIN

/** Types of blocks. ECT_PCAPNG_LOCAL is in the range reserved for local use. */
#define ECT_PCAPNG_SECTION    0x0A0D0D0Au
#define ECT_PCAPNG_INTERFACE  1u
#define ECT_PCAPNG_STATISTICS 5u
#define ECT_PCAPNG_PACKET     6u
#define ECT_PCAPNG_LOCAL      0x80E7C001u
/** Byte-order magic of a section. */
#define ECT_PCAPNG_MAGIC 0x1A2B3C4Du

/** Options of blocks. */
enum {
    ECT_PCAPNG_COMMENT = 1,
    ECT_PCAPNG_FLAGS = 2,      /**< of a packet */
    ECT_PCAPNG_DROPPED = 4,    /**< of a packet: frames lost before it */
    ECT_PCAPNG_NAME = 2,       /**< of an interface */
    ECT_PCAPNG_RESOLUTION = 9, /**< of an interface */
    ECT_PCAPNG_APPLICATION = 4 /**< of a section */
};

/** Longest comment, longest text of another option, and longest captured frame, bytes. */
enum { ECT_PCAPNG_COMMENT_MOST = 1000, ECT_PCAPNG_TEXT_MOST = 200, ECT_PCAPNG_FRAME_MOST = 2048 };

/** Room for any section, interface or packet. */
enum { ECT_PCAPNG_ROOM = 4096 };

/** Direction of a packet, as seen by the interface. */
typedef enum ect_pcapng_direction { ECT_PCAPNG_INBOUND = 1, ECT_PCAPNG_OUTBOUND = 2 } ect_pcapng_direction_t;

typedef struct ect_pcapng_packet {
    uint32_t interface; /**< index in the section, from 0 */
    ect_pcapng_direction_t direction;
    uint64_t time_ns;
    const uint8_t *frame;
    uint32_t captured;   /**< bytes of `frame`, at most ECT_PCAPNG_FRAME_MOST */
    uint32_t length;     /**< on the wire */
    uint64_t dropped;    /**< frames lost since the previous packet */
    const char *comment; /**< at most ECT_PCAPNG_COMMENT_MOST bytes are used; NULL or "": none */
} ect_pcapng_packet_t;

/** Writes a section header. @param application  program and version; NULL: none. @param[out] to  ECT_PCAPNG_ROOM bytes
 * @return length of the block */
size_t ect_pcapng_section(uint8_t *to, const char *application);

/** Writes an Ethernet interface with times in nanoseconds. @param name  NULL: none. @param[out] to  ECT_PCAPNG_ROOM
 * bytes
 * @return length of the block */
size_t ect_pcapng_interface(uint8_t *to, const char *name);

/** Writes a packet. @param[out] to  ECT_PCAPNG_ROOM bytes. @return length of the block */
size_t ect_pcapng_packet(uint8_t *to, const ect_pcapng_packet_t *packet);

/** Writes statistics of interface 0 with a comment, the end of a section. @param[out] to  ECT_PCAPNG_ROOM bytes
 * @return length of the block */
size_t ect_pcapng_statistics(uint8_t *to, uint64_t time_ns, const char *comment);

/** @return length of a block with `length` bytes of local data */
static inline size_t ect_pcapng_local_size(size_t length)
{
    return 12 + (length + 3) / 4 * 4;
}

/** Writes local data. @param[out] to  ::ect_pcapng_local_size bytes. @return length of the block */
size_t ect_pcapng_local(uint8_t *to, const void *data, size_t length);

ECT_C_END

#endif
