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

/** An open port. Members are read only for others. */
typedef struct ect_packet {
    int fd;             /**< readable when a frame without a VLAN tag has come */
    int tagged_fd;      /**< when one with a tag has; -1: `fd` stands for both */
    int claim_fd;       /**< shows others that the interface is ours */
    unsigned int index; /**< of the interface */
    char iface[16];
    bool was_down;        /**< we brought the interface up and take it down again */
    uint64_t patience_ns; /**< how long ::ect_packet_receive waits at most, if it is to; 0: it cannot */
    uint8_t *shared;      /**< of ::ect_packet_share; NULL: not called */
    unsigned int slot;    /**< where the next frame will be in it */
    unsigned int looks;   /**< that found none */
    uint64_t came_ns;     /**< when a frame had come; those that are yet to be received from `fd` came later */
} ect_packet_t;

/** Monotonic time, nanoseconds: that of ::ect_packet_time, of the loop and of all that it drives. */
uint64_t ect_packet_now(void);

/** When a frame was received, and how long before that it had arrived. */
typedef struct ect_packet_time {
    uint64_t now_ns;    /**< as ::ect_packet_now, after it was received */
    uint64_t waited_ns; /**< since its arrival at the interface; 0 may also stand for less than ECT_PACKET_ASK_NS */
} ect_packet_time_t;

/** Room for a message of ::ect_packet_open. */
enum { ECT_PACKET_MESSAGE = 512 };

/** What ::ect_packet_receive says besides a length. */
enum { ECT_PACKET_NONE = 0, ECT_PACKET_GONE = -1, ECT_PACKET_STALE = -2 };

/**
 * Opens `iface` for EtherCAT frames: bound to it, promiscuous while open, own frames not received. An interface that
 * is down is brought up. An interface on which
 * somebody else has opened a socket for them is refused.
 * @param[out] message  on failure one line for the user: what is missing and how to get it; ECT_PACKET_MESSAGE bytes
 * @return 0, or -1 with nothing changed
 */
int ect_packet_open(ect_packet_t *port, const char *iface, char *message);

/** Closes the port and leaves the interface as it was found. */
void ect_packet_close(ect_packet_t *port);

/**
 * For those who look for frames and never wait: from now on the kernel puts them into memory that it shares, half a
 * megabyte, and ::ect_packet_receive costs no system call. What has arrived until now is lost.
 * @return false: this kernel cannot; nothing has changed
 */
bool ect_packet_share(ect_packet_t *port);

/** The kernel is asked when a frame arrived, unless it cannot have been longer ago than this: frames come in order. */
#define ECT_PACKET_ASK_NS 200000ull

/**
 * Takes a frame that has arrived. A VLAN tag stands in it as it was on the wire. Frames that have waited
 * for more than 5 ms while newer ones came are dropped. One system call, a second one every ECT_PACKET_ASK_NS, and a
 * look at the clock.
 * @param wait  for a frame without a tag, never longer than ect_packet_t::patience_ns, some milliseconds; false, and
 * always after ::ect_packet_share: takes what is there
 * @param[out] time  unchanged without a frame
 * @return its length on the wire, which may exceed `room` (the frame is then cut) · ECT_PACKET_NONE · ECT_PACKET_STALE
 * one was dropped · ECT_PACKET_GONE the interface is gone (errno)
 */
ssize_t ect_packet_receive(ect_packet_t *port, bool wait, uint8_t *frame, size_t room, ect_packet_time_t *time);

/** Whether a cable is in: the interface is up and has a carrier. One system call. */
bool ect_packet_has_link(const ect_packet_t *port);

/**
 * Opens a descriptor that becomes readable when any interface of this network changes, for those who then ask
 * ::ect_packet_has_link. @return the descriptor, to be closed with close(), or -1 (errno)
 */
int ect_packet_watch_links(void);
/** Forgets the changes that made it readable. */
void ect_packet_links_seen(int fd);

/** Sends a frame at its own length. One system call. A full queue or a link that is down loses it, as a wire would. */
void ect_packet_send(const ect_packet_t *port, const uint8_t *frame, size_t length);

ECT_C_END

#endif
