/* SPDX-License-Identifier: MIT */
/**
 * @file
 * LAN9118 and LAN9220: an Ethernet controller, MAC and PHY, behind a window of the processor's bus.
 *
 * Set up for EtherCAT: 100 Mbit/s full duplex, all frames whoever they are addressed to, no flow control. The only
 * interrupt is that of a received frame.
 *
 * One controller, one context at a time. Every wait is bounded. Figures are of the data sheet of the
 * LAN9118 (revision 1.5).
 */
#ifndef FIRMWARE_LAN9118_H
#define FIRMWARE_LAN9118_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/** Longest frame that goes through it, without check sum. */
enum { LAN9118_MAX_FRAME = 1518 };

/** Bytes to receive one: with the check sum, in whole words. */
enum { LAN9118_BUFFER = 1524 };

/** The controller. The members are private but for the counters. */
typedef struct lan9118 {
    uintptr_t base;
    uint32_t lost;   /**< frames to be sent that found no room */
    uint32_t broken; /**< frames received with an error, or longer than LAN9118_MAX_FRAME or the buffer */
} lan9118_t;

/**
 * Resets the controller and sets it up.
 * @param base  address of its window
 * @return false: nothing that looks like it is there, or it does not get ready (at most some 10 ms)
 */
bool lan9118_init(lan9118_t *mac, uintptr_t base);

/**
 * Takes the interrupt back. To be called before ::lan9118_receive until that has nothing: a frame that comes meanwhile
 * raises it again.
 */
void lan9118_acknowledge(const lan9118_t *mac);

/**
 * Takes the oldest frame that was received.
 * @param[out] frame  `size` bytes, a multiple of 4; LAN9118_BUFFER are enough for any
 * @return its length without check sum · 0: there is none. Frames with errors, and those that are longer, are passed
 * over.
 */
size_t lan9118_receive(lan9118_t *mac, uint32_t *frame, size_t size);

/**
 * Sends a frame; the controller fills up what is shorter than 60 bytes.
 * @param frame  `length` bytes; the check sum is added
 * @return whether the controller had room for it
 */
bool lan9118_send(lan9118_t *mac, const uint32_t *frame, size_t length);

#endif
