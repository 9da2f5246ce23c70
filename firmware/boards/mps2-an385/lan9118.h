/* SPDX-License-Identifier: MIT */
/**
 * @file
 * LAN9118 and LAN9220: an Ethernet controller, MAC and PHY, behind a window of the processor's bus.
 *
 * Configured for EtherCAT: 100 Mbit/s full duplex, frames with any destination address, no flow control. The only
 * interrupt is that of a received frame.
 *
 * One controller, one context at a time. Every wait is bounded. Figures are from the data sheet of the LAN9118
 * (revision 1.5).
 */
#ifndef FIRMWARE_LAN9118_H
#define FIRMWARE_LAN9118_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/** Longest frame, without check sum. */
enum { LAN9118_MAX_FRAME = 1518 };

/** Bytes to receive a frame: with the check sum, in complete words. */
enum { LAN9118_BUFFER = 1524 };

/** The controller. The members are private, except the counters. */
typedef struct lan9118 {
    uintptr_t base;
    uint32_t lost;   /**< frames not sent for lack of room */
    uint32_t broken; /**< frames received with an error, or longer than LAN9118_MAX_FRAME or the buffer */
} lan9118_t;

/**
 * Resets and configures the controller.
 * @param base  address of its window
 * @return false: no such controller at the address, or it is not ready in time (at most about 10 ms)
 */
bool lan9118_init(lan9118_t *mac, uintptr_t base);

/**
 * Clears the interrupt. Due before ::lan9118_receive is called until it returns 0: a frame that arrives meanwhile
 * raises the interrupt again.
 */
void lan9118_acknowledge(const lan9118_t *mac);

/**
 * Takes the oldest received frame.
 * @param[out] frame  `size` bytes, a multiple of 4; LAN9118_BUFFER are enough for any
 * @return length without check sum · 0: none. Frames with errors, and longer frames, are skipped.
 */
size_t lan9118_receive(lan9118_t *mac, uint32_t *frame, size_t size);

/**
 * Sends a frame; the controller pads frames shorter than 60 bytes.
 * @param frame  `length` bytes; the check sum is added
 * @return whether the controller had room for the frame
 */
bool lan9118_send(lan9118_t *mac, const uint32_t *frame, size_t length);

#endif
