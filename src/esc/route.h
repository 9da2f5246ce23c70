/* SPDX-License-Identifier: MIT */
/**
 * @file
 * What a passing frame needs to know of a controller, for those who lead frames through many of them: they parse a
 * frame once, know beforehand which controllers it concerns, and ask only those.
 *
 * The reference is ::ect_esc_process for one controller after the other. As long as each controller that takes part in
 * a datagram is given that datagram by ::ect_esc_datagram, in the order of the wire, the result is the same.
 */
#ifndef ECT_ESC_ROUTE_H
#define ECT_ESC_ROUTE_H

#include "esc/esc.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** Commands of datagrams. */
typedef enum ect_command {
    ECT_NOP,
    ECT_APRD,
    ECT_APWR,
    ECT_APRW,
    ECT_FPRD,
    ECT_FPWR,
    ECT_FPRW,
    ECT_BRD,
    ECT_BWR,
    ECT_BRW,
    ECT_LRD,
    ECT_LWR,
    ECT_LRW,
    ECT_ARMW,
    ECT_FRMW,
} ect_command_t;

/** Offsets inside a datagram, and the sizes of what stands around its data. */
enum {
    ECT_DATAGRAM_COMMAND = 0,
    ECT_DATAGRAM_ADP = 2,
    ECT_DATAGRAM_ADO = 4,
    ECT_DATAGRAM_LENGTH = 6,
    ECT_DATAGRAM_IRQ = 8,
    ECT_DATAGRAM_DATA = 10,
    ECT_DATAGRAM_COUNTER = 2, /**< bytes of the working counter behind the data */
};

/** Parts that a controller takes in a datagram with a physical address. */
enum {
    ECT_PART_READ = 1,
    ECT_PART_WRITE = 2,
    ECT_PART_OR = 4, /**< what is read is OR'ed into the frame: broadcast */
};

/** Bytes of logical addresses that an active FMMU covers, at least in part. */
typedef struct ect_esc_window {
    uint32_t first;
    uint16_t length;    /**< not 0; may reach beyond the last address */
    uint16_t direction; /**< ECT_PART_READ, ECT_PART_WRITE or both */
} ect_esc_window_t;

/** All of a controller that decides what a frame does there, and what a frame takes with it from those it passes by. */
typedef struct ect_esc_route {
    uint16_t station;      /**< configured station address */
    uint16_t alias;        /**< the other one; as `station` where none is enabled */
    uint16_t events;       /**< ECAT events behind their mask: OR'ed into each datagram */
    uint16_t al_status;    /**< 0x0130 */
    bool al_status_new;    /**< it was written since it was read: reading it takes an event away */
    bool open;             /**< frames leave by port 1 */
    bool goes_astray;      /**< frames do not simply go to port 1 and come back: ::ect_esc_circulates, a junction */
    bool marks_source;     /**< frames get the "locally administered" bit here */
    bool awaits_frame;     /**< the next frame ends something here, to whomever its datagrams go */
    bool takes_time;       /**< a system time that is written is compared with its own (::ect_esc_take_time) */
    bool guards_writes;    /**< protection has a say in what is written */
    bool writes_registers; /**< an FMMU that is written through reaches below the RAM */
    uint8_t window_count;
    ect_esc_window_t windows[ECT_ESC_MAX_FMMU]; /**< in the order of the FMMUs */
} ect_esc_route_t;

/** Reads it. Valid until ::ect_esc_routing moves. */
void ect_esc_route(const ect_esc_t *esc, ect_esc_route_t *route);

/** A counter that moves whenever an ::ect_esc_route_t would be another, or might. */
static inline uint32_t ect_esc_routing(const ect_esc_t *esc)
{
    return esc->routing;
}

/**
 * Where the datagrams of a frame begin.
 * @return offset of the first one; 0: the frame is malformed, too long, no EtherCAT, or EtherCAT in UDP
 */
size_t ect_frame_datagrams(const uint8_t *frame, size_t length);

/** Bytes of data in a datagram. */
static inline uint16_t ect_datagram_length(const uint8_t *datagram)
{
    return (uint16_t)((datagram[ECT_DATAGRAM_LENGTH] | datagram[ECT_DATAGRAM_LENGTH + 1] << 8) & 0x07FF);
}

/** Bytes of a datagram, from its header to its working counter. */
static inline size_t ect_datagram_size(const uint8_t *datagram)
{
    return (size_t)ECT_DATAGRAM_DATA + ect_datagram_length(datagram) + ECT_DATAGRAM_COUNTER;
}

/** Whether another one stands behind it. */
static inline bool ect_datagram_follows(const uint8_t *datagram)
{
    return (datagram[ECT_DATAGRAM_LENGTH + 1] & 0x80) != 0;
}

/** The one behind it; NULL: it is the last. */
static inline uint8_t *ect_datagram_next(uint8_t *datagram)
{
    return ect_datagram_follows(datagram) ? datagram + ect_datagram_size(datagram) : NULL;
}

/** Whether each controller that a datagram passes adds one to its address: commands by position, and broadcasts. */
static inline bool ect_command_counts(uint8_t command)
{
    return (command >= ECT_APRD && command <= ECT_APRW) || (command >= ECT_BRD && command <= ECT_BRW) ||
           command == ECT_ARMW;
}

/** A frame begins at `now_ns`; once for each controller that takes part in it, before its first datagram. */
void ect_esc_begin_of_frame(ect_esc_t *esc, uint64_t now_ns);

/**
 * Lets a controller take part in one datagram: its data change, header and working counter do not.
 * @param part  ECT_PART_...; commands with a logical address: of no meaning
 * @return what the working counter gains
 */
unsigned int ect_esc_datagram(ect_esc_t *esc, uint8_t *datagram, unsigned int part);

/**
 * As a datagram that writes the four bytes of the system time (0x0910), in a frame that begins at `now_ns`, to a
 * controller that takes it. Nothing comes of it that a passing frame shows, so it may be late, as long as nobody has
 * looked at the controller since.
 */
void ect_esc_take_time(ect_esc_t *esc, uint32_t time, uint64_t now_ns);

/** The frame is over; due for each controller that took part in it. */
void ect_esc_end_of_frame(ect_esc_t *esc);

ECT_C_END

#endif
