/* SPDX-License-Identifier: MIT */
/**
 * @file
 * EoE, Ethernet over EtherCAT: a device has a network address, and its Ethernet frames travel in mails.
 *
 * A device that offers EoE has a constant `ect_eoe_t` and lists its `protocol` member as the last of its protocols
 * (::ect_device_t::protocols), because its frames may occupy the mailbox whenever no preceding protocol has a mail;
 * otherwise nothing of EoE is linked. Two functions transfer complete frames; the protocol itself handles fragments,
 * frame numbers, the IP parameters and their results. One frame is under way in each direction.
 *
 *     typedef struct drive { ect_standard_t standard; ect_eoe_state_t eoe; ... } drive_t;
 *     static const ect_eoe_t network = {ECT_EOE_PROTOCOL, offsetof(drive_t, eoe),
 *                                       .received = to_stack, .fetch = from_stack};
 *     static const ect_protocol_t *const protocols[] = {&ect_protocol_sdo, &network.protocol, NULL};
 *
 * In the description, `mailbox_protocols` contains ECT_MAILBOX_EOE, and both mailboxes have at least
 * ::ECT_EOE_MAILBOX_LEAST bytes.
 *
 * A master sets the address in PREOP. The address is kept until power-off; a restart of the mailbox only drops frames
 * that are not complete.
 *
 * Not offered: address filters (the reply is 0401h), DHCP in a device without it (0202h), time stamps (a request for a
 * stamp is ignored, an appended stamp is removed).
 *
 * Context: all functions run in mainline, as those of `ect_protocol_t`, and must not block.
 *
 * Clauses: ETG.1000.6 §5.7.
 */
#ifndef ECT_SEAMS_EOE_H
#define ECT_SEAMS_EOE_H

#include <stddef.h>

#include "seams/device.h"
#include "seams/mailbox.h"

enum {
    ECT_EOE_FRAME = 1518,       /**< longest frame without FCS, with one VLAN tag; without a tag 1514 */
    ECT_EOE_FRAME_LEAST = 14,   /**< an Ethernet header */
    ECT_EOE_MAILBOX_LEAST = 42, /**< headers and one unit of 32 bytes */
    ECT_EOE_NAME = 32,
    ECT_EOE_STAMP = 4,
};

/** Results of set IP (ETG.1000.6 §5.7.4). */
enum {
    ECT_EOE_OK = 0x0000,
    ECT_EOE_UNSPECIFIED = 0x0001,
    ECT_EOE_UNSUPPORTED_TYPE = 0x0002,
    ECT_EOE_NO_IP = 0x0201,
    ECT_EOE_NO_DHCP = 0x0202,
    ECT_EOE_NO_FILTER = 0x0401,
};

/** Parameters that are known: flags of ::ect_eoe_address_t, as on the wire. */
enum {
    ECT_EOE_HAS_MAC = 0x01,
    ECT_EOE_HAS_IP = 0x02,
    ECT_EOE_HAS_SUBNET = 0x04,
    ECT_EOE_HAS_GATEWAY = 0x08,
    ECT_EOE_HAS_DNS = 0x10,
    ECT_EOE_HAS_NAME = 0x20,
};

/** The address of a device. Octets in the order in which they are printed: 192.168.0.1 is {192, 168, 0, 1}. */
typedef struct ect_eoe_address {
    uint8_t known; /**< ECT_EOE_HAS_...; the others are 0 */
    uint8_t mac[6];
    uint8_t ip[4], subnet[4], gateway[4], dns[4];
    char name[ECT_EOE_NAME]; /**< DNS name, padded with zeros; zero-terminated only if it is shorter */
} ect_eoe_address_t;

/** State of EoE, in the device's instance, zero at power-on; the device may fill in `address` in its `init`. */
typedef struct ect_eoe_state {
    ect_eoe_address_t address;
    uint32_t received; /**< frames taken by the device; wraps */
    uint32_t sent;     /**< frames whose last fragment was sent; wraps */
    uint32_t dropped;  /**< frames of either direction that were broken, too long, or not taken by the device; wraps */

    /* Private from here. */
    uint16_t in_length, in_limit; /* bytes so far; bytes announced */
    uint16_t out_length, out_sent;
    uint8_t in_fragment, in_number; /* expected next */
    uint8_t out_fragment, out_number, out_port;
    bool in_open;
    uint8_t in[ECT_EOE_FRAME + ECT_EOE_STAMP];
    uint8_t out[ECT_EOE_FRAME];
} ect_eoe_state_t;

/**
 * EoE of a device. Each function gets the entry, which may be the first member of a larger constant structure, and the
 * device's instance.
 */
typedef struct ect_eoe ect_eoe_t;
struct ect_eoe {
    ect_protocol_t protocol; /**< ECT_EOE_PROTOCOL; the first member */
    size_t offset;           /**< of an ::ect_eoe_state_t in the instance, aligned */
    uint8_t ports;           /**< 0 and 1: one port, which mails name 0 or 1; else ports 0 to this number */
    bool dhcp;               /**< set IP with only a MAC is passed to `set`; false: its result is 0202h */

    /**
     * Gets a frame sent by a master.
     * @param port    of the last fragment
     * @param frame   from the destination address on, without FCS; valid during the call
     * @param length  ECT_EOE_FRAME_LEAST..ECT_EOE_FRAME; short frames are not padded
     * @return false: no room; the frame is counted as dropped
     */
    bool (*received)(const ect_eoe_t *eoe, void *instance, uint8_t port, const uint8_t *frame, uint16_t length);

    /**
     * Returns the next frame for the master. Called when no frame is under way: after a received frame and after
     * ::ect_mailbox_wake, until it returns 0.
     * @param frame  room for ECT_EOE_FRAME bytes
     * @param port   0 when called
     * @return length, 0: none. A frame shorter than ECT_EOE_FRAME_LEAST or longer than the standard permits is counted
     * as dropped
     */
    uint16_t (*fetch)(const ect_eoe_t *eoe, void *instance, uint8_t *frame, uint8_t *port);

    /**
     * Called when a master sets the address; ::ect_eoe_state_t::address has the previous one until the return. NULL:
     * any address is accepted.
     * @param address  the new address: parameters omitted by the master have their previous values
     * @return the result for the master; the new address is stored only with ECT_EOE_OK
     */
    uint16_t (*set)(const ect_eoe_t *eoe, void *instance, uint8_t port, const ect_eoe_address_t *address);

    /** Called when a master reads the address: the device may update ::ect_eoe_state_t::address. May be NULL. */
    void (*load)(const ect_eoe_t *eoe, void *instance, uint8_t port);

    /** Called when the mailbox starts: discards frames that wait for `fetch`. May be NULL. */
    void (*reset)(const ect_eoe_t *eoe, void *instance);
};

ECT_C_BEGIN

/** @return whether both mailboxes of a description have room for a fragment, for any length that a master may choose */
static inline bool ect_eoe_fits(const ect_device_t *device)
{
    return ect_sm_shortest_mailbox(&device->sm[0]) >= ECT_EOE_MAILBOX_LEAST &&
           ect_sm_shortest_mailbox(&device->sm[1]) >= ECT_EOE_MAILBOX_LEAST;
}

/** Handles a request, for ECT_EOE_PROTOCOL only. */
uint16_t ect_eoe_request(const ect_protocol_t *self, ect_slave_t *slave, const uint8_t *data, uint16_t length);
/** Sends a fragment, for ECT_EOE_PROTOCOL only. */
bool ect_eoe_next(const ect_protocol_t *self, ect_slave_t *slave, bool send);
/** Drops frames that are not complete, for ECT_EOE_PROTOCOL only. */
void ect_eoe_reset(const ect_protocol_t *self, ect_slave_t *slave);

ECT_C_END

/** Served in PREOP, SAFEOP and OP; in BOOT its mails are refused as unsupported. */
#define ECT_EOE_PROTOCOL                                                                                               \
    {.type = ECT_MAILBOX_TYPE_EOE,                                                                                     \
     .states = ECT_IN_PREOP_AND_ABOVE,                                                                                 \
     .request = ect_eoe_request,                                                                                       \
     .next = ect_eoe_next,                                                                                             \
     .reset = ect_eoe_reset}

#endif
