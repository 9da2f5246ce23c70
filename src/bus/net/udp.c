/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bus/net/udp.h"

#include <errno.h>
#include <netinet/in.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "wire/bytes.h"

enum { SOURCE = 6, TYPE = 12, IP = 14, UDP = 34, ECAT_HEADER = 2 };
enum { ETHERTYPE_IPV4 = 0x0800, PORT_ECAT = 0x88A4, LENGTH_MASK = 0x07FF };

/* Offsets in the IPv4 and UDP headers. */
enum { IP_SIZE = 2, IP_ID = 4, IP_LIFE = 8, IP_CARRIES = 9, IP_SUM = 10, IP_FROM = 12 };
enum { UDP_FROM = 0, UDP_TO = 2, UDP_SIZE = 4, IP_BYTES = 20, UDP_BYTES = 8 };

static int refuse(char *message, const char *where, const char *why, int error)
{
    snprintf(message, ECT_PACKET_MESSAGE, "cannot receive at '%s': %s", where, why);
    errno = error;
    return -1;
}

int ect_udp_open(ect_udp_t *port, const char *where, char *message)
{
    ect_address_t address;
    ect_packet_time_t time;
    *port = (ect_udp_t){.fd = -1};
    if (!ect_address_parse(&address, where) || address.at.ss_family != AF_INET) {
        snprintf(message, ECT_PACKET_MESSAGE,
                 "'%s' is no [ADDRESS:]PORT: a numeric IPv4 address, the port from 0 to 65535, as in "
                 "127.0.0.1:34980",
                 where);
        errno = EINVAL;
        return -1;
    }
    port->fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (port->fd < 0)
        return refuse(message, where, strerror(errno), errno);
    if (bind(port->fd, (const struct sockaddr *)&address.at, address.size) < 0) {
        int error = errno;
        ect_udp_close(port);
        return refuse(message, where, ect_address_why(error), error);
    }
    ect_address_print(port->fd, port->address);
    (void)ect_packet_arrived(port->fd, NULL, &time); /* from this call on the kernel records times of arrival */
    return 0;
}

void ect_udp_close(ect_udp_t *port)
{
    if (port->fd >= 0)
        close(port->fd);
    port->fd = -1;
}

/* @return the sum of a header; 0xFFFF: its check sum is correct (RFC 1071) */
static uint16_t sum_of(const uint8_t *ip)
{
    uint32_t sum = 0;
    for (unsigned int i = 0; i < IP_BYTES; i += 2)
        sum += ect_load_be16(ip + i);
    sum = (sum & 0xFFFF) + (sum >> 16);
    return (uint16_t)((sum & 0xFFFF) + (sum >> 16));
}

/* Writes the headers of a frame. The identification repeats the sender's port, so that the check sum of IPv4 covers the
 * entire return address. The destination port is that of EtherCAT, as controllers require, whichever port received the
 * datagram. */
static void write_headers(uint8_t *frame, const struct sockaddr_in *from, size_t payload)
{
    uint8_t *ip = frame + IP, *udp = frame + UDP;
    uint16_t port = ntohs(from->sin_port);
    memset(frame, 0, ECT_UDP_HEADERS);
    memset(frame, 0xFF, SOURCE);
    frame[SOURCE] = 0x02; /* as set by a controller */
    ect_store_be16(frame + TYPE, ETHERTYPE_IPV4);
    ip[0] = 0x45;
    ect_store_be16(ip + IP_SIZE, (uint16_t)(IP_BYTES + UDP_BYTES + payload));
    ect_store_be16(ip + IP_ID, port);
    ip[IP_LIFE] = 64;
    ip[IP_CARRIES] = IPPROTO_UDP;
    memcpy(ip + IP_FROM, &from->sin_addr, sizeof from->sin_addr);
    ect_store_be16(ip + IP_SUM, (uint16_t)~sum_of(ip));
    ect_store_be16(udp + UDP_FROM, port);
    ect_store_be16(udp + UDP_TO, PORT_ECAT);
    ect_store_be16(udp + UDP_SIZE, (uint16_t)(UDP_BYTES + payload));
}

static bool has_fit_length(const uint8_t *payload, ssize_t length)
{
    return length >= ECT_UDP_LEAST && length <= ECT_UDP_MOST &&
           ECAT_HEADER + (ect_load_le16(payload) & LENGTH_MASK) <= length;
}

ssize_t ect_udp_receive(ect_udp_t *port, uint8_t *frame, ect_packet_time_t *time)
{
    struct sockaddr_in from;
    socklen_t size = sizeof from;
    uint8_t *payload = frame + ECT_UDP_HEADERS;
    ssize_t length =
        recvfrom(port->fd, payload, ECT_UDP_MOST, MSG_DONTWAIT | MSG_TRUNC, (struct sockaddr *)&from, &size);
    if (length < 0)
        return errno == EAGAIN || errno == EINTR ? ECT_PACKET_NONE : ECT_PACKET_GONE;
    if (!has_fit_length(payload, length))
        return ECT_UDP_REFUSED;
    write_headers(frame, &from, (size_t)length);
    return ect_packet_arrived(port->fd, &port->came_ns, time) ? ECT_PACKET_STALE : ECT_UDP_HEADERS + length;
}

bool ect_udp_carries(const uint8_t *frame, size_t length)
{
    return length > ECT_UDP_HEADERS && ect_load_be16(frame + TYPE) == ETHERTYPE_IPV4;
}

void ect_udp_send(const ect_udp_t *port, const uint8_t *frame, size_t length)
{
    const uint8_t *ip = frame + IP;
    struct sockaddr_in to = {.sin_family = AF_INET, .sin_port = htons(ect_load_be16(frame + UDP + UDP_FROM))};
    if (sum_of(ip) != 0xFFFF || ect_load_be16(ip + IP_ID) != ntohs(to.sin_port))
        return;
    memcpy(&to.sin_addr, ip + IP_FROM, sizeof to.sin_addr);
    (void)sendto(port->fd, frame + ECT_UDP_HEADERS, length - ECT_UDP_HEADERS, MSG_DONTWAIT,
                 (const struct sockaddr *)&to, sizeof to);
}
