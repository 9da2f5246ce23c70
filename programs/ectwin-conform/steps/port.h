/* SPDX-License-Identifier: MIT */
/**
 * @file
 * SOEM's port: its socket, buffers and index carry datagrams of any kind. The only file beside it that knows SOEM is
 * port.c: SOEM and wire/registers.h use the same names for registers.
 */
#ifndef ECTWIN_CONFORM_PORT_H
#define ECTWIN_CONFORM_PORT_H

#include <signal.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

/** One datagram. Nothing interprets it on the way: any command, any address. */
typedef struct cf_datagram {
    uint8_t command;
    uint32_t address; /**< ADP in the low, ADO in the high 16 bits; or the logical address; as it came back */
    uint16_t length;  /**< 0..CF_MAX_DATA */
    void *data;       /**< `length` bytes: sent as they are, then what came back; NULL: zeros, and nothing kept */
    uint16_t wkc;     /**< sent with this value (0 as a rule), then what came back */
    uint16_t irq;     /**< what came back */
} cf_datagram_t;

typedef struct cf_port cf_port_t;

/** Counts SIGINT and SIGTERM: the case that runs is left, no other begins. The second one does not even wait for an
 * answer. */
extern volatile sig_atomic_t cf_interrupted;

/** Monotonic, nanoseconds. */
uint64_t cf_now_ns(void);

/** Opens an interface. @return NULL, or why it cannot be opened (constant text, or errno's) */
const char *cf_port_open(cf_port_t **port, const char *iface);
/** @param port  may be NULL */
void cf_port_close(cf_port_t *port);
/**
 * Takes the interface down, as if its cable were pulled, or up again.
 * @return NULL, or why that is not possible (constant text, or errno's)
 */
const char *cf_port_link(cf_port_t *port, bool up);
/** One frame there and back; sent once. @return false: it did not come back in time */
bool cf_port_exchange(cf_port_t *port, cf_datagram_t *d, size_t count, uint32_t timeout_ms);
/**
 * Any frame, with a NOP of its own behind it. A wire keeps the order: what has not come back before the NOP does not
 * come.
 * @return bytes of the answer, 0 none, -1: the NOP did not come back in time
 */
ssize_t cf_port_raw(cf_port_t *port, const void *frame, size_t length, uint8_t *reply, size_t room,
                    uint32_t timeout_ms);
/**
 * SOEM's own way over this port: all slaves configured and mapped, process data, one of them to OP.
 * @param slave     its number, from 1
 * @param[out] what  on failure: how far it came
 */
bool cf_port_soem_to_op(cf_port_t *port, uint16_t slave, char *what, size_t room);

#endif
