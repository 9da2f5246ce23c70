/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A processor from power-on to main(), without a vendor's kit, and the few things that C has no words for: cortex_m.c
 * for the Cortex-M, riscv32.c for a RISC-V with 32 bits, memory.c and flash.ld for any.
 */
#ifndef FIRMWARE_CPU_H
#define FIRMWARE_CPU_H

#include <stddef.h>
#include <stdint.h>

/** A register of the processor or of the chip. */
#define REGISTER(address) (*(volatile uint32_t *)(uintptr_t)(address))

/** An entry of a vector table. */
typedef void (*cpu_handler_t)(void);

/**
 * Cortex-M: interrupts of the chip, which the board knows. The table follows the processor's own vectors, from
 * interrupt 0 on; one without a handler must not be enabled.
 */
#define CPU_VECTORS __attribute__((section(".vectors.board"), used))

/** A variable that a reset leaves as it is; after power-on it holds anything. */
#define CPU_KEPT __attribute__((section(".kept")))

/** Cortex-M: SysTick's registers, for who has it to himself: ::cpu_cycles, or a board. It counts down, 24 bits. */
#define CPU_SYSTICK_CONTROL REGISTER(0xE000E010)
#define CPU_SYSTICK_RELOAD  REGISTER(0xE000E014)
#define CPU_SYSTICK_VALUE   REGISTER(0xE000E018)
#define CPU_SYSTICK_COUNTS  5u /**< by the processor's clock, without interrupts */
#define CPU_SYSTICK_ALARMS  7u /**< ... with them */
#define CPU_SYSTICK_LONGEST 0x00FFFFFFu

/** Cortex-M: SysTick. Defined by a board that starts it. */
void cpu_systick(void);

/** A fault, or an interrupt without a handler. Weak: an endless loop; the firmware's own calls board_fault (board.h).
 */
void cpu_fault(void);

/** Begins a piece that no interrupt comes into. @return what ::cpu_interrupts_restore takes to end it; they may be
 * nested. */
uint32_t cpu_interrupts_off(void);
void cpu_interrupts_restore(uint32_t before);

/**
 * Sleeps until an interrupt is due. Call it with interrupts off, after a check whether there is work:
 * one that comes between the check and this ends the sleep all the same, and is taken when interrupts are on again.
 */
void cpu_sleep(void);

/**
 * Cycles of the processor's clock since the first call. Mainline.
 *
 * Cortex-M: takes SysTick for itself, which counts 24 bits. From a Cortex-M3 on it also takes the cycle counter of the
 * DWT, so that 2^32 cycles may pass between two calls while the processor is awake, e.g. in an erase of flash; asleep,
 * or on a Cortex-M0+, 2^24: a driver of flash that takes longer there calls this while it waits, from RAM. RISC-V:
 * mcycle, without a limit.
 */
uint64_t cpu_cycles(void);

/**
 * Makes addresses device memory: accesses are not cached, reordered, merged or speculated. For an ESC at an address
 * that the processor takes for normal memory, as a Cortex-M7 does below 0x80000000 outside its peripherals. Takes the
 * last region of the MPU, which beats the others; a processor without an MPU (ARMv6-M, ARMv7-M) has no cache either,
 * and stays as it is. RISC-V: the chip's own attributes decide, nothing is done.
 * @param base  a multiple of the size
 * @param bits  the size is 2^bits bytes, 5..31
 */
void cpu_device_memory(uint32_t base, unsigned int bits);

/** Cortex-M: lets interrupt `number` of the chip through. */
void cpu_interrupt_enable(unsigned int number);

/** Begins the image whose vectors are at that address, as after a reset. Cortex-M3 and above. */
_Noreturn void cpu_run(uint32_t vectors);

/** Resets the chip; a processor that cannot restarts the image. */
_Noreturn void cpu_reset(void);

/** Variables, then main(): from the processor's first instructions, on the stack. */
_Noreturn void cpu_start(void);

#endif
