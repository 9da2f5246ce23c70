/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Properties of a controller that affect passing frames, for code that passes frames through many controllers. Such
 * code parses a frame once, and calls only the controllers that take part in the frame, determined in advance.
 *
 * The reference is ::ect_esc_pass for each controller in the order of the wire, then ::ect_esc_end_of_frame for each.
 * The result is the same if each controller that takes part in a datagram gets the datagram by ::ect_esc_datagram, in
 * the order of the wire.
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

/** Offsets inside a datagram, and sizes of the parts around its data. */
enum {
    ECT_DATAGRAM_COMMAND = 0,
    ECT_DATAGRAM_ADP = 2,
    ECT_DATAGRAM_ADO = 4,
    ECT_DATAGRAM_LENGTH = 6,
    ECT_DATAGRAM_IRQ = 8,
    ECT_DATAGRAM_DATA = 10,
    ECT_DATAGRAM_COUNTER = 2, /**< bytes of the working counter after the data */
};

/** Parts of a controller in a datagram, of which only ECT_PART_UNREAD applies to commands with a logical address. */
enum {
    ECT_PART_READ = 1,
    ECT_PART_WRITE = 2,
    ECT_PART_OR = 4,     /**< broadcast: the read data are OR'ed into the frame */
    ECT_PART_UNREAD = 8, /**< the datagram has no reader: with a logical address, images may be left out */
};

/** Range of logical addresses that an active FMMU maps, at least in part. */
typedef struct ect_esc_window {
    uint32_t first;
    uint16_t length;    /**< bytes, not 0; may reach beyond the last address */
    uint16_t direction; /**< ECT_PART_READ, ECT_PART_WRITE or both */
} ect_esc_window_t;

/** Properties that determine a controller's effect on a frame, and the data that every passing frame collects. */
typedef struct ect_esc_route {
    uint16_t station;   /**< configured station address */
    uint16_t alias;     /**< second address; equal to `station` if no alias is enabled */
    uint16_t events;    /**< ECAT events that the mask passes: OR'ed into each datagram */
    uint16_t al_status; /**< 0x0130 */
    bool al_status_new; /**< written and not read since: a read clears an event */
    bool open;          /**< frames leave by port 1 */
    bool leaves_line;   /**< frames do not only pass to port 1 and return: ::ect_esc_circulates, a junction */
    bool marks_source;  /**< frames get the "locally administered" bit here */
    bool awaits_frame;  /**< the next frame has an effect here, regardless of its datagrams */
    bool takes_time;    /**< a written system time is compared with the local one (::ect_esc_take_time) */
    bool guards_writes; /**< write protection may refuse a write */
    uint8_t window_count;
    ect_esc_window_t windows[ECT_ESC_MAX_FMMU]; /**< in the order of the FMMUs */
} ect_esc_route_t;

/** Reads these properties. They are valid until ::ect_esc_routing changes. */
void ect_esc_route(const ect_esc_t *esc, ect_esc_route_t *route);

/** A counter that changes whenever an ::ect_esc_route_t, or the layout of an ::ect_esc_cyclic_t, may have changed. */
static inline uint32_t ect_esc_routing(const ect_esc_t *esc)
{
    return esc->routing;
}

/**
 * Finds the first datagram of a frame.
 * @return its offset; 0: the frame is malformed, too long, not EtherCAT, or EtherCAT in UDP with a check sum, which
 * the controllers must clear
 */
size_t ect_frame_datagrams(const uint8_t *frame, size_t length);

/** Length of the data of a datagram, bytes. */
static inline uint16_t ect_datagram_length(const uint8_t *datagram)
{
    return (uint16_t)((datagram[ECT_DATAGRAM_LENGTH] | datagram[ECT_DATAGRAM_LENGTH + 1] << 8) & 0x07FF);
}

/** Length of a datagram from its header to its working counter, bytes. */
static inline size_t ect_datagram_size(const uint8_t *datagram)
{
    return (size_t)ECT_DATAGRAM_DATA + ect_datagram_length(datagram) + ECT_DATAGRAM_COUNTER;
}

/** Whether another datagram follows. */
static inline bool ect_datagram_follows(const uint8_t *datagram)
{
    return (datagram[ECT_DATAGRAM_LENGTH + 1] & 0x80) != 0;
}

/** The next datagram; NULL: this is the last one. */
static inline uint8_t *ect_datagram_next(uint8_t *datagram)
{
    return ect_datagram_follows(datagram) ? datagram + ect_datagram_size(datagram) : NULL;
}

/** ::ect_datagram_next for reading. */
static inline const uint8_t *ect_datagram_after(const uint8_t *datagram)
{
    return ect_datagram_follows(datagram) ? datagram + ect_datagram_size(datagram) : NULL;
}

/** Whether each controller that a datagram passes adds one to its address: auto increment and broadcast commands. */
static inline bool ect_command_counts(uint8_t command)
{
    return (command >= ECT_APRD && command <= ECT_APRW) || (command >= ECT_BRD && command <= ECT_BRW) ||
           command == ECT_ARMW;
}

/** Parts of a command with a logical address: ECT_PART_READ, ECT_PART_WRITE or both; 0: the command has none. */
static inline unsigned int ect_command_direction(uint8_t command)
{
    switch (command) {
    case ECT_LRD:
        return ECT_PART_READ;
    case ECT_LWR:
        return ECT_PART_WRITE;
    case ECT_LRW:
        return ECT_PART_READ | ECT_PART_WRITE;
    default:
        return 0;
    }
}

/** Starts a frame at `now_ns`: once for each controller that takes part, before its first datagram. */
void ect_esc_begin_of_frame(ect_esc_t *esc, uint64_t now_ns);

/**
 * Executes one datagram in a controller. The data of the datagram change; its header and working counter do not.
 * @param esc       the controller
 * @param datagram  from its header on
 * @param part      ECT_PART_...
 * @return increment of the working counter
 */
unsigned int ect_esc_datagram(ect_esc_t *esc, uint8_t *datagram, unsigned int part);

/**
 * Executes a datagram that writes the four bytes of the system time (0x0910), in a frame that begins at `now_ns`, in a
 * controller that uses the time (ect_esc_route_t::takes_time). The effect appears in no passing frame, so the call may
 * be late, but must precede every other use of the controller.
 */
void ect_esc_take_time(ect_esc_t *esc, uint32_t time, uint64_t now_ns);

/** As ::ect_esc_take_time, but in the order of the datagrams of a frame in which the controller takes part. */
void ect_esc_postpone_time(ect_esc_t *esc, uint32_t time);

/**
 * Passes a frame through the controller like ::ect_esc_process, but without its end: writes to registers and the change
 * of buffers wait for ::ect_esc_end_of_frame. Until then the frame leaves by the ports that were open at its arrival.
 */
ect_frame_result_t ect_esc_pass(ect_esc_t *esc, uint8_t *frame, size_t length, uint64_t now_ns);

/** Ends a frame: its writes take effect. Required for each controller that took part in the frame. */
void ect_esc_end_of_frame(ect_esc_t *esc);

ECT_C_END

#endif
