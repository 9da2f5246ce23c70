/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A raw EtherCAT port on a Linux network interface (AF_PACKET, EtherType 0x88A4).
 */
#ifndef ECT_BUS_NET_PACKET_H
#define ECT_BUS_NET_PACKET_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

#include "wire/linkage.h"

ECT_C_BEGIN

/** An open port. Members are read-only for callers. */
typedef struct ect_packet {
    int fd;             /**< readable when a frame without a VLAN tag is available */
    int tagged_fd;      /**< readable when a frame with a tag is available; -1: `fd` is for both */
    int claim_fd;       /**< marks the interface as in use, for other programs */
    unsigned int index; /**< of the interface */
    char iface[16];
    bool was_down;     /**< this port brought the interface up, and takes it down when it closes */
    uint64_t wait_ns;  /**< longest wait of ::ect_packet_receive; 0: it does not wait */
    uint8_t *shared;   /**< frames in memory that the kernel shares (::ect_packet_share); NULL: not called */
    unsigned int slot; /**< of the next frame in `shared` */
    unsigned int idle; /**< reads that have found no frame */
    uint64_t came_ns;  /**< arrival of the last frame whose age the kernel has reported */
} ect_packet_t;

/** CLOCK_MONOTONIC, nanoseconds: the time of ::ect_packet_time_t, of the loop and of the chain. */
uint64_t ect_packet_now(void);

/** Time of a frame's reception, and its age then. */
typedef struct ect_packet_time {
    uint64_t now_ns;    /**< as ::ect_packet_now, after reception */
    uint64_t waited_ns; /**< from arrival at the interface to reception; 0 if less than ECT_PACKET_ASK_NS */
} ect_packet_time_t;

/** Room for a message of ::ect_packet_open. */
enum { ECT_PACKET_MESSAGE = 512 };

/** Results of ::ect_packet_receive other than a length. */
enum { ECT_PACKET_NONE = 0, ECT_PACKET_GONE = -1, ECT_PACKET_STALE = -2 };

/**
 * Opens an interface for EtherCAT frames: promiscuous while open; frames sent by this machine are not received. An
 * interface that is down is brought up. An interface on which another program has opened a socket for EtherCAT is
 * refused.
 * @param iface  name, at most 15 characters
 * @param[out] message  on failure one line for the user, cause and cure; ECT_PACKET_MESSAGE bytes
 * @return 0, or -1 with nothing changed
 */
int ect_packet_open(ect_packet_t *port, const char *iface, char *message);

/** Closes the port and restores the initial state of the interface. */
void ect_packet_close(ect_packet_t *port);

/**
 * Makes the kernel place frames into 512 KiB of shared memory, for a loop that polls continuously: ::ect_packet_receive
 * then makes no system call. Frames that have arrived before are lost.
 * @return false: not supported by this kernel; nothing has changed
 */
bool ect_packet_share(ect_packet_t *port);

/**
 * The age of a frame is read from the kernel only if it can exceed this limit: frames arrive in order, so the last age
 * read bounds the next one.
 */
#define ECT_PACKET_ASK_NS 200000ull

/**
 * Receives a frame, with its VLAN tag as on the wire. A frame that has waited for more than 5 ms while newer frames
 * arrived is discarded. Cost: one system call, a second one every ECT_PACKET_ASK_NS, and one read of the clock.
 * @param wait  true: waits for a frame without a tag, at most ect_packet_t::wait_ns, some milliseconds; false, and
 * after ::ect_packet_share: does not wait
 * @param[out] frame  `room` bytes
 * @param[out] time  unchanged without a frame
 * @return length on the wire, which may exceed `room` (the frame is then truncated) · ECT_PACKET_NONE no frame ·
 * ECT_PACKET_STALE a frame was discarded · ECT_PACKET_GONE the interface is gone (errno)
 */
ssize_t ect_packet_receive(ect_packet_t *port, bool wait, uint8_t *frame, size_t room, ect_packet_time_t *time);

/**
 * Reads the time at which the frame or datagram last read from a socket has arrived.
 * @param came_ns  arrival of the last frame whose age was read, updated; NULL: the age is read in any case
 * @param[out] time  set
 * @return true: the frame has waited for more than 5 ms while newer ones arrived. Cost: one read of the clock, and at
 * most two system calls
 */
bool ect_packet_arrived(int fd, uint64_t *came_ns, ect_packet_time_t *time);

/** @return frames lost since the previous call because the port's queue was full. Cost: one or two system calls */
uint64_t ect_packet_lost(const ect_packet_t *port);

/** @return whether the interface is up and has a carrier. Cost: one or two system calls. */
bool ect_packet_has_link(const ect_packet_t *port);

/**
 * Opens a descriptor that becomes readable when any interface of this network changes; ::ect_packet_has_link then reads
 * the link. @return the descriptor, to be closed with close(); -1 (errno)
 */
int ect_packet_watch_links(void);
/** Discards the changes that made the descriptor readable. */
void ect_packet_links_seen(int fd);

/** Sends a frame. Cost: one system call. A full queue or a link that is down loses the frame, as a wire would. */
void ect_packet_send(const ect_packet_t *port, const uint8_t *frame, size_t length);

ECT_C_END

#endif
