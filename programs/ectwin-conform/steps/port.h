/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Datagrams of any kind through the port of SOEM: its socket, buffers and index. Only port.c includes SOEM, because
 * SOEM and wire/registers.h use the same names for registers.
 */
#ifndef ECTWIN_CONFORM_PORT_H
#define ECTWIN_CONFORM_PORT_H

#include <signal.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

/** One datagram of any command and address, sent unchanged. */
typedef struct cf_datagram {
    uint8_t command;
    uint32_t
        address; /**< ADP in the low, ADO in the high 16 bits, or the logical address; after the reply: its address */
    uint16_t length; /**< 0..CF_MAX_DATA */
    void *data;      /**< `length` bytes to send, replaced by those of the reply; NULL: sends zeros, drops the reply */
    uint16_t wkc;    /**< value to send (usually 0), replaced by that of the reply */
    uint16_t irq;    /**< of the reply */
} cf_datagram_t;

typedef struct cf_port cf_port_t;

/** Number of SIGINT and SIGTERM: the first ends the running case and the run, the second also ends the wait for a
 * reply. */
extern volatile sig_atomic_t cf_interrupted;

/** @return the monotonic clock in nanoseconds */
uint64_t cf_now_ns(void);

/** Opens an interface. @return NULL, or the reason (constant text, or errno's) */
const char *cf_port_open(cf_port_t **port, const char *iface);
/** @param port  may be NULL */
void cf_port_close(cf_port_t *port);
/**
 * Takes the interface down, which disconnects all slaves, or up.
 * @return NULL, or the reason why that is not possible (constant text, or errno's)
 */
const char *cf_port_link(cf_port_t *port, bool up);
/** Sends one frame, once, and waits for its return. @return false: not within the timeout */
bool cf_port_exchange(cf_port_t *port, cf_datagram_t *d, size_t count, uint32_t timeout_ms);
/**
 * Sends any frame, then a NOP. A wire keeps the order of frames: a frame that has not returned before the NOP is lost.
 * @return bytes of the reply, 0 none, -1: the NOP did not return within the timeout
 */
ssize_t cf_port_raw(cf_port_t *port, const void *frame, size_t length, uint8_t *reply, size_t room,
                    uint32_t timeout_ms);
/**
 * SOEM's own start-up over this port: configures and maps all slaves, takes one of them to OP with process data.
 * @param slave     its number, from 1
 * @param[out] what  on failure: the state that was reached
 */
bool cf_port_soem_to_op(cf_port_t *port, uint16_t slave, char *what, size_t room);
/**
 * SOEM's own start-up to PREOP, then its set IP and its get IP.
 * @param set       octets in the order in which they are printed
 * @param[out] got  octets that get IP returned, in the same order; 0 when the slave reports no address
 * @param[out] what  on failure: the function and its result
 */
bool cf_port_soem_address(cf_port_t *port, uint16_t slave, const uint8_t set[4], uint8_t got[4], char *what,
                          size_t room);

#endif
