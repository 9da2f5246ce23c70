/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The part of a controller in the exchange of process data, known in advance: for code that replies to a recurring
 * frame without passing it through the controller, and passes it later (bus/kernel).
 *
 * The reference is ::ect_esc_datagram. Both functions return false, or -1, for all that they are not certain of.
 * Nothing here changes the controller. Context: as for every other call of the instance.
 */
#ifndef ECT_ESC_CYCLIC_H
#define ECT_ESC_CYCLIC_H

#include "esc/esc.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** Bytes of a datagram that a controller replaces by an input image. */
typedef struct ect_esc_piece {
    uint16_t at;         /**< from the first byte of data on */
    uint16_t length;     /**< bytes */
    const uint8_t *from; /**< the newest image; valid until the next call of the instance */
    uint8_t sm;          /**< its SyncManager */
} ect_esc_piece_t;

/** Effect of a datagram with a logical address. */
typedef struct ect_esc_cyclic {
    unsigned int gain; /**< increment of the working counter */
    unsigned int piece_count;
    ect_esc_piece_t pieces[ECT_ESC_MAX_FMMU]; /**< in the order in which they are copied */
} ect_esc_cyclic_t;

/**
 * Whether frames alone change the effect of later frames: no command to the EEPROM, no temporary setting of a loop and
 * no watchdog of the PDI is running whose end a passing frame would show.
 */
bool ect_esc_steady(const ect_esc_t *esc);

/**
 * Finds the effect of LRD, LWR or LRW. It lasts, however often such datagrams pass, until any other access of either
 * side, if ::ect_esc_steady. Until ::ect_esc_routing changes, such an access replaces the images at most
 * (::ect_esc_newest_image).
 * @return false: not certain. Certain are whole images of SyncManagers with three buffers in RAM, each whole in one
 *         FMMU and in the datagram, without ECAT events, sequential mode or write protection, where neither
 *         SyncManagers nor FMMUs of one direction overlap
 */
bool ect_esc_cyclic(const ect_esc_t *esc, uint8_t command, uint32_t logical, uint16_t length, ect_esc_cyclic_t *effect);

/**
 * The newest image of a SyncManager with three buffers that ::ect_esc_cyclic has named.
 * @return NULL: there is none yet; else it is valid until the next call of the instance
 */
const uint8_t *ect_esc_newest_image(const ect_esc_t *esc, unsigned int sm);

/**
 * The system time that a frame reads at 0x0910, while the clock has the rate of `now_ns`.
 * @param[out] offset_ns  system time minus the frame's time of arrival at the chain, modulo 2^64
 * @return false: no clock, or a rate of its own
 */
bool ect_esc_even_clock(const ect_esc_t *esc, uint64_t *offset_ns);

ECT_C_END

#endif
