/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The hosts of networks (bus/eoe/network.h): the kernel's end of each TAP and socket.
 *
 * The loop of the twins waits for ::ect_hosts_fd and ::ect_hosts_due and calls ::ect_hosts_serve when no frame of a
 * master waits, so that no Ethernet frame delays process data. A host whose queue is full is not read: its own queue,
 * or its sender, waits. After a second in which the master has fetched no frame, further ones are read, dropped and
 * counted. Context: the thread of the chain; no call blocks.
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

/** @return no hosts yet; to be closed with ::ect_hosts_close. NULL: errno */
ect_hosts_t *ect_hosts_new(void);

/**
 * Opens the host of a network.
 * @param place         "tap", "tapNAME" or "unix:PATH"; outlives the hosts
 * @param network       ECT_NETWORK_HOST; outlives the hosts
 * @param position      of its twin in the chain
 * @param[out] message  on failure one line for the user, ECT_PLACE_MESSAGE bytes
 * @return the name of the interface or the path, valid until the hosts are closed; NULL: see message
 */
const char *ect_hosts_open(ect_hosts_t *hosts, const char *place, ect_network_t *network, size_t position,
                           char *message);

/** A descriptor that is readable when a host has a frame. */
int ect_hosts_fd(const ect_hosts_t *hosts);

/** When to call ::ect_hosts_serve without a readable descriptor, in the time of its argument: 0 now, ECT_NEVER. */
uint64_t ect_hosts_due(const ect_hosts_t *hosts);

/** Moves frames of one host: at most four to it and four from it, and wakes its twin. Cost: at most ten system calls,
 * and one for each host without a frame.
 * @param now_ns  never decreases */
void ect_hosts_serve(ect_hosts_t *hosts, ect_chain_t *chain, uint64_t now_ns);

/** Closes all; sockets of ours are removed. NULL: no effect */
void ect_hosts_close(ect_hosts_t *hosts);

ECT_C_END

#endif
