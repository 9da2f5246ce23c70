/* SPDX-License-Identifier: MIT */
/**
 * @file
 * ARM's MPS2 with the image AN385 (a Cortex-M3 at 25 MHz), or QEMU in its place: clock, sleep, a line of text.
 */
#ifndef FIRMWARE_MPS2_H
#define FIRMWARE_MPS2_H

#include <stdbool.h>
#include <stdint.h>

/** The used interrupts of the chip. */
enum { MPS2_INTERRUPT_ETHERNET = 13 };

/** Address of the window of the Ethernet controller. */
#define MPS2_ETHERNET 0x40200000u

/** Sets up clock and serial line. Called first. */
void mps2_init(void);

/**
 * @return nanoseconds since ::mps2_init, in steps of 40; never decreases. Must be called at least once in 171 s.
 * Context: any.
 */
uint64_t mps2_now_ns(void);

/**
 * Raises ::cpu_systick at a time, or after about 600 ms, whichever is earlier; the last call applies. UINT64_MAX: after
 * 600 ms. Context: any.
 */
void mps2_alarm(uint64_t at_ns);

/** The lamps of the FPGA, 0 and 1. Mainline. */
void mps2_led(unsigned int number, bool lit);

/** Writes text to the first serial line, and waits until it is sent (a character takes 87 us at 115200 baud). Mainline.
 */
void mps2_print(const char *text);

#endif
