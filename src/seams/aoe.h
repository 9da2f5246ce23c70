/* SPDX-License-Identifier: MIT */
/**
 * @file
 * AoE, ADS over EtherCAT: a master reads and writes by index group and index offset.
 *
 * A device that offers AoE has a constant `ect_aoe_t` and lists its `protocol` member among its protocols
 * (::ect_device_t::protocols); otherwise nothing of AoE is linked. A mail contains one AMS header and one ADS command;
 * each request gets one reply in one mail.
 *
 *     typedef struct gateway { ect_standard_t standard; ect_aoe_state_t aoe; ... } gateway_t;
 *     static const ect_aoe_t ads = {.protocol = ECT_AOE_PROTOCOL, .offset = offsetof(gateway_t, aoe)};
 *     static const ect_protocol_t *const protocols[] = {&ect_protocol_sdo, &ads.protocol, NULL};
 *
 * In the description, `mailbox_protocols` contains ECT_MAILBOX_AOE, and both mailboxes have at least
 * ::ECT_AOE_MAILBOX_LEAST bytes.
 *
 * | command | reply |
 * |---|---|
 * | ReadDeviceInfo | version of the entry, name: the first 16 bytes of ::ect_device_t::type_name |
 * | Read, Write, ReadWrite | by index group, see below; ReadWrite writes first, and reads if that succeeded |
 * | ReadState | ADS state 5 (run) in OP, else 6 (stop); device state: the AL state |
 * | WriteControl, AddDeviceNotification, DelDeviceNotification | result 0701h |
 * | others | error 0008h in the AMS header |
 *
 * | index group | index offset | access |
 * |---|---|---|
 * | F302h | index << 16, bit 8 Complete Access, bits 0..7 sub-index | dictionary of a device with CoE |
 * | 0001h | 0003h | write: 6 bytes, the NetId of the device |
 * | others | any | `read` and `write` of the entry, else result 0702h |
 *
 * The dictionary is accessed with the rules of the SDO server. A reply that is longer than the mailbox, or than the
 * length in the request, is refused with 0705h, because this AoE has no fragments. A CoE transfer in segments is not
 * affected by AoE. While a download in segments is under way, a write to the dictionary gets 0708h, as does a read
 * while an upload in segments sends bytes of the device (::ect_device_t::sdo_read).
 *
 * After the NetId has been set, a request for another NetId, except 0.0.0.0.0.0, gets error 0007h in the AMS header; a
 * request that sets the NetId is executed. Every port is accepted.
 *
 * Mailbox errors: 6 without a complete AMS header, 8 when the AMS length exceeds the mail. Responses and notifications
 * of a master are ignored.
 *
 * Context: all functions run in mainline, as those of `ect_protocol_t`, and must not block.
 *
 * Clauses: ETG.1000.6 (mailbox type 1), ETG.1020 (AoE). The codes are those of ADS.
 */
#ifndef ECT_SEAMS_AOE_H
#define ECT_SEAMS_AOE_H

#include <stddef.h>

#include "seams/device.h"
#include "seams/mailbox.h"

enum {
    ECT_AOE_MAILBOX_LEAST = 62, /**< headers and the reply to ReadDeviceInfo */
    ECT_AOE_NET_ID = 6,
};

/** Index groups and offsets of the stack. */
enum {
    ECT_AOE_GROUP_SETUP = 0x0001,
    ECT_AOE_OFFSET_NET_ID = 0x0003,
    ECT_AOE_GROUP_COE = 0xF302,
    ECT_AOE_COMPLETE_ACCESS = 0x0100, /**< bit of the index offset */
};

/** Error codes of the AMS header. */
enum {
    ECT_AMS_NO_TARGET = 0x0007, /**< another NetId */
    ECT_AMS_UNKNOWN_COMMAND = 0x0008,
    ECT_AMS_LENGTH = 0x000E, /**< shorter than the parameters of the command */
};

/** Results of ADS commands. */
enum {
    ECT_ADS_OK = 0x0000,
    ECT_ADS_GENERAL = 0x0700,
    ECT_ADS_NO_SERVICE = 0x0701,
    ECT_ADS_NO_GROUP = 0x0702,
    ECT_ADS_NO_OFFSET = 0x0703, /**< neither object nor sub-index */
    ECT_ADS_ACCESS = 0x0704,    /**< cannot be read, or written */
    ECT_ADS_SIZE = 0x0705,
    ECT_ADS_VALUE = 0x0706,
    ECT_ADS_BUSY = 0x0708,
    ECT_ADS_MEMORY = 0x070A,
    ECT_ADS_STATE = 0x0712, /**< not in this AL state */
};

/** State of AoE, in the device's instance, zero at power-on. */
typedef struct ect_aoe_state {
    uint8_t net_id[ECT_AOE_NET_ID]; /**< as set by a master; outlasts the mailbox; 0: none yet */
} ect_aoe_state_t;

/** AoE of a device. Each function gets the entry, which may be the first member of a larger constant structure, and the
 * device's instance. */
typedef struct ect_aoe ect_aoe_t;
struct ect_aoe {
    ect_protocol_t protocol;   /**< ECT_AOE_PROTOCOL; the first member */
    size_t offset;             /**< of an ::ect_aoe_state_t in the instance */
    uint8_t version, revision; /**< for ReadDeviceInfo */
    uint16_t build;

    /**
     * Reads from an index group of the device. NULL: there is none.
     * @param[out] data       room for `*length` bytes, all 0; unchanged unless ECT_ADS_OK
     * @param[in,out] length  bytes that the master and the mailbox can take, then bytes of the value
     * @return ECT_ADS_OK, or the result for the master
     */
    uint32_t (*read)(const ect_aoe_t *aoe, void *instance, uint32_t group, uint32_t offset, uint8_t *data,
                     uint32_t *length);

    /**
     * Writes to an index group of the device. NULL: there is none.
     * @param data  `length` bytes, valid during the call
     * @return ECT_ADS_OK, or the result for the master, in which case nothing has changed
     */
    uint32_t (*write)(const ect_aoe_t *aoe, void *instance, uint32_t group, uint32_t offset, const uint8_t *data,
                      uint32_t length);
};

ECT_C_BEGIN

/** Whether both mailboxes of a description have room for each reply of fixed length, whatever length a master chooses.
 */
static inline bool ect_aoe_fits(const ect_device_t *device)
{
    return ect_sm_shortest_mailbox(&device->sm[0]) >= ECT_AOE_MAILBOX_LEAST &&
           ect_sm_shortest_mailbox(&device->sm[1]) >= ECT_AOE_MAILBOX_LEAST;
}

/** Handles a request, for ECT_AOE_PROTOCOL only. */
uint16_t ect_aoe_request(const ect_protocol_t *self, ect_slave_t *slave, const uint8_t *data, uint16_t length);

ECT_C_END

/** Served in PREOP, SAFEOP and OP; in BOOT its mails are refused as unsupported. */
#define ECT_AOE_PROTOCOL {.type = ECT_MAILBOX_TYPE_AOE, .states = ECT_IN_PREOP_AND_ABOVE, .request = ect_aoe_request}

#endif
