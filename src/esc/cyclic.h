/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The effect of a controller on frames of process data, computed in advance: for code that replies to a recurring frame
 * first, and passes the frame through the controller later (bus/kernel).
 *
 * The reference is ::ect_esc_datagram. A function returns false, or NULL, if the effect is not certain. No function
 * changes the controller. Context: as for every other call of the instance.
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
 * @return whether only frames and accesses change the effect of later frames, not time: no EEPROM command, no temporary
 * loop setting and no PDI watchdog is running whose end would change the content of a frame.
 */
bool ect_esc_steady(const ect_esc_t *esc);

/**
 * Finds the effect of LRD, LWR or LRW. If ::ect_esc_steady, the effect is valid for any number of such datagrams, until
 * any other access of either side. Until ::ect_esc_routing changes, such an access can replace only the images
 * (::ect_esc_newest_image).
 * @return false: not certain. The effect is certain for whole images of SyncManagers with three buffers in RAM, each
 * entirely in one FMMU and in the datagram, without ECAT events, sequential mode or write protection, if neither
 * SyncManagers nor FMMUs of one direction overlap
 */
bool ect_esc_cyclic(const ect_esc_t *esc, uint8_t command, uint32_t logical, uint16_t length, ect_esc_cyclic_t *effect);

/**
 * The newest image of a SyncManager with three buffers that ::ect_esc_cyclic has named.
 * @return NULL: none yet; else valid until the next call of the instance
 */
const uint8_t *ect_esc_newest_image(const ect_esc_t *esc, unsigned int sm);

/**
 * Finds the system time that a frame reads at 0x0910, while the clock has the rate of `now_ns`.
 * @param[out] offset_ns  system time minus the frame's time of arrival at the chain, modulo 2^64
 * @return false: no clock, or a rate of its own
 */
bool ect_esc_even_clock(const ect_esc_t *esc, uint64_t *offset_ns);

ECT_C_END

#endif
