/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The hosts of networks (bus/eoe/network.h): the host's end of each TAP and socket.
 *
 * The loop of the twins waits for ::ect_hosts_fd and ::ect_hosts_due and calls ::ect_hosts_serve when no frame of a
 * master waits, so that no Ethernet frame delays process data. While the queue of a network is full, its TAP or socket
 * is not read: frames wait in the kernel's queue, or the sender blocks. When the master has fetched no frame for a
 * second, further frames are read, dropped and counted. Context: the thread of the chain; no call blocks.
 */
#ifndef ECT_BUS_EOE_HOSTS_H
#define ECT_BUS_EOE_HOSTS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus/chain/chain.h"
#include "bus/eoe/network.h"
#include "bus/eoe/place.h"
#include "wire/linkage.h"

ECT_C_BEGIN

typedef struct ect_hosts ect_hosts_t;

/** Makes an empty set of hosts. @return to be closed with ::ect_hosts_close; NULL: errno */
ect_hosts_t *ect_hosts_new(void);

/**
 * Opens the host of a network.
 * @param place         "tap", "tapNAME" or "unix:PATH"; outlives the hosts
 * @param network       ECT_NETWORK_HOST; outlives the hosts
 * @param position      of the twin in the chain
 * @param[out] message  on failure one line for the user, ECT_PLACE_MESSAGE bytes
 * @return the name of the interface or the path, valid until the hosts are closed; NULL: see message
 */
const char *ect_hosts_open(ect_hosts_t *hosts, const char *place, ect_network_t *network, size_t position,
                           char *message);

/** @return a descriptor that is readable while a host has a frame */
int ect_hosts_fd(const ect_hosts_t *hosts);

/** @return the time at which to call ::ect_hosts_serve even if the descriptor is not readable, on the clock of its
 *          `now_ns`: 0: now; ECT_NEVER */
uint64_t ect_hosts_due(const ect_hosts_t *hosts);

/**
 * Moves frames of one host, at most four in each direction, and wakes its twin. Cost: at most ten system calls, and one
 * for each host without a frame.
 * @param now_ns  never decreases
 */
void ect_hosts_serve(ect_hosts_t *hosts, ect_chain_t *chain, uint64_t now_ns);

/** Closes all hosts and removes the sockets of ::ect_hosts_open. NULL: no effect */
void ect_hosts_close(ect_hosts_t *hosts);

ECT_C_END

#endif
