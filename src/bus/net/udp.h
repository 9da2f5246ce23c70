/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A port for EtherCAT in UDP (ETG.1000.4 §5.3): unicast datagrams of IPv4, whose payload begins with the EtherCAT
 * header. Each datagram enters the chain as the Ethernet frame that would carry it, with IPv4 and UDP headers and
 * without a UDP check sum, so a reply contains the address of its sender even after a delay. No rights are necessary.
 * Every sender that reaches the port is a master (docs/SECURITY.md).
 */
#ifndef ECT_BUS_NET_UDP_H
#define ECT_BUS_NET_UDP_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

#include "bus/net/address.h"
#include "bus/net/packet.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** An open port. Members are read-only for callers. */
typedef struct ect_udp {
    int fd;                         /**< readable when a datagram is available */
    char address[ECT_ADDRESS_TEXT]; /**< of the port, "127.0.0.1:34980" */
    uint64_t came_ns;               /**< arrival of the last datagram whose age the kernel has reported */
} ect_udp_t;

/** Shortest and longest payload, bytes; the longest one fits into an Ethernet frame. */
enum { ECT_UDP_LEAST = 14, ECT_UDP_MOST = 1472 };

/** Bytes of the headers before a payload: Ethernet, IPv4, UDP. */
enum { ECT_UDP_HEADERS = 42 };

/**
 * A result of ::ect_udp_receive in addition to those of ::ect_packet_receive: a datagram of bad length was discarded.
 */
enum { ECT_UDP_REFUSED = -3 };

/**
 * Opens a port. Ports other than 88A4h (34980) are for tests and for several buses on one machine.
 * @param where  "[ADDRESS:]PORT" (::ect_address_parse), IPv4 only
 * @param[out] message  on failure one line for the user, cause and cure; ECT_PACKET_MESSAGE bytes
 * @return 0, or -1 with nothing open (errno; EINVAL: `where` is invalid)
 */
int ect_udp_open(ect_udp_t *port, const char *where, char *message);

/** Closes the port. */
void ect_udp_close(ect_udp_t *port);

/**
 * Receives a datagram as an Ethernet frame; does not wait. Discarded are payloads shorter than ECT_UDP_LEAST, longer
 * than ECT_UDP_MOST or shorter than their EtherCAT headers define, and datagrams whose age exceeds the limit of
 * ::ect_packet_receive.
 * @param[out] frame  at least ECT_UDP_HEADERS + ECT_UDP_MOST bytes
 * @param[out] time  unchanged without a frame
 * @return length of the frame · ECT_PACKET_NONE · ECT_PACKET_STALE · ECT_UDP_REFUSED · ECT_PACKET_GONE (errno)
 */
ssize_t ect_udp_receive(ect_udp_t *port, uint8_t *frame, ect_packet_time_t *time);

/** @return whether a frame came from a UDP port: its reply goes to ::ect_udp_send. */
bool ect_udp_carries(const uint8_t *frame, size_t length);

/**
 * Sends a frame of ::ect_udp_receive, processed by the chain, to the sender of its datagram. A frame with a damaged
 * IPv4 header is lost, as a damaged datagram would be. A frame is also lost if the socket's buffer is full.
 */
void ect_udp_send(const ect_udp_t *port, const uint8_t *frame, size_t length);

ECT_C_END

#endif
