/* SPDX-License-Identifier: MIT */
/**
 * @file
 * ARM's MPS2 with the image AN385 (a Cortex-M3 at 25 MHz), or QEMU in its place: clock, sleep, a line of text.
 */
#ifndef FIRMWARE_MPS2_BOARD_H
#define FIRMWARE_MPS2_BOARD_H

#include <stdint.h>

/** Interrupts of the chip that are used. */
enum { BOARD_INTERRUPT_ETHERNET = 13 };

/** Where the window of the Ethernet controller is. */
#define BOARD_ETHERNET 0x40200000u

/** Clock and serial line. To be called first. */
void board_init(void);

/** Nanoseconds since ::board_init, in steps of 40. Never goes back; has to be called once in 171 s or more often. Any
 * context. */
uint64_t board_now_ns(void);

/**
 * Raises ::cpu_systick at that time, or after some 600 ms, whatever comes first; the last call counts. UINT64_MAX:
 * after 600 ms. Any context.
 */
void board_alarm(uint64_t at_ns);

/** Writes text to the first serial line, and waits until it is out (a character takes 87 us at 115200 baud). Mainline.
 */
void board_print(const char *text);

#endif
