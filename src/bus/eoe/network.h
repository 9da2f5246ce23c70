/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The network behind a twin with EoE: the link of its cable, its counters, and the queues of frames to and from a host.
 *
 * A network replaces the EoE entry of a device (seams/eoe.h) in a copy of the description. Frames of the master go to
 * the device itself, to a small responder, or to a host: a TAP or a socket (bus/eoe/hosts.h). The device keeps the
 * address and handles the fragments.
 *
 * This file uses no operating system. The queues of a host are bounded; a frame that finds a full queue is dropped and
 * counted. Context: the thread of the chain; no call blocks.
 */
#ifndef ECT_BUS_EOE_NETWORK_H
#define ECT_BUS_EOE_NETWORK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus/chain/twin_config.h"
#include "seams/eoe.h"
#include "wire/linkage.h"

ECT_C_BEGIN

typedef enum ect_network_kind {
    ECT_NETWORK_OWN,  /**< the device itself processes frames */
    ECT_NETWORK_ECHO, /**< profiles/ip replies to ARP, ping and UDP echo, at the address that the master sets */
    ECT_NETWORK_HOST, /**< two queues: frames to the host (::ect_network_peek) and from the host (::ect_network_push) */
} ect_network_kind_t;

/** Frames of a queue: enough for the frames between two turns of a host. The rest of a TCP window waits in the host. */
enum { ECT_NETWORK_QUEUE = 64 };

typedef struct ect_network ect_network_t;

/** @return the EoE entry of a device; NULL: the device has no EoE, or announces EoE without supporting it */
const ect_eoe_t *ect_network_entry(const ect_device_t *device);

/**
 * Makes a network for one twin, with the cable plugged in.
 * @param device  with EoE (::ect_network_entry); outlives the network
 * @return to be freed with ::ect_network_free after the chain; NULL: no memory
 */
ect_network_t *ect_network_new(const ect_device_t *device, ect_network_kind_t kind);

/** Frees a network. NULL: no effect */
void ect_network_free(ect_network_t *network);

/** Adds the network to the configuration of its twin: the device, and the signals eoe.NAME in addition to the device's.
 */
void ect_network_join(ect_network_t *network, ect_twin_config_t *twin);

/** The signals of every network, eoe.NAME; an instance has ECT_NETWORK_SIGNALS bytes, aligned as uint32_t. */
extern const ect_plant_t ect_network_plant;
enum { ECT_NETWORK_SIGNALS = 16 };

/* --- the host's side, ECT_NETWORK_HOST only ------------------------------------------------------------------------
 */

/** @return whether the cable is plugged in and the AL state is PREOP or above; if not, frames of the host are lost */
bool ect_network_has_link(const ect_network_t *network);

/** @return number of frames for which ::ect_network_push has room, 0 to ECT_NETWORK_QUEUE */
size_t ect_network_room(const ect_network_t *network);

/**
 * Appends a frame of the host to the queue towards the master; the caller then wakes the twin (::ect_chain_wake).
 * Without room or link, and with more than ECT_EOE_FRAME bytes, the frame is dropped and counted.
 * @param frame  from the destination address on, without FCS; copied
 */
void ect_network_push(ect_network_t *network, const uint8_t *frame, size_t length);

/** @return the oldest frame for the host, valid until ::ect_network_next or the next call of the chain; NULL: none */
const uint8_t *ect_network_peek(const ect_network_t *network, uint16_t *length);

/** Removes the frame of ::ect_network_peek. @param taken  false: the host has refused the frame, which is counted */
void ect_network_next(ect_network_t *network, bool taken);

ECT_C_END

#endif
