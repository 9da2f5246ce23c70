/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A processor from power-on to main(), without a vendor's kit, and functions that C cannot express: cortex_m.c for the
 * Cortex-M, riscv32.c for a RISC-V with 32 bits, memory.c and flash.ld for both.
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
 * Cortex-M: interrupts of the chip, defined by the board. The table follows the processor's own vectors, from interrupt
 * 0 on; an interrupt without a handler must not be enabled.
 */
#define CPU_VECTORS __attribute__((section(".vectors.board"), used))

/** A variable that outlasts a reset; undefined after power-on. */
#define CPU_KEPT __attribute__((section(".kept")))

/** Cortex-M: SysTick's registers, for one exclusive user: ::cpu_cycles, or a board. SysTick counts down, 24 bits. */
#define CPU_SYSTICK_CONTROL REGISTER(0xE000E010)
#define CPU_SYSTICK_RELOAD  REGISTER(0xE000E014)
#define CPU_SYSTICK_VALUE   REGISTER(0xE000E018)
#define CPU_SYSTICK_COUNTS  5u /**< at the processor's clock, without interrupts */
#define CPU_SYSTICK_ALARMS  7u /**< ... with interrupts */
#define CPU_SYSTICK_LONGEST 0x00FFFFFFu

/** Cortex-M: SysTick. Defined by a board that starts it. */
void cpu_systick(void);

/**
 * Called at a fault, or an interrupt without a handler. Weak: an endless loop; the firmware's version calls board_fault
 * (board.h).
 */
void cpu_fault(void);

/**
 * Disables interrupts; calls may be nested. @return the argument of ::cpu_interrupts_restore, which restores the
 * previous state.
 */
uint32_t cpu_interrupts_off(void);
void cpu_interrupts_restore(uint32_t before);

/**
 * Sleeps until an interrupt is pending. Call it with interrupts disabled, after a check for work: an interrupt between
 * the check and this call also ends the sleep, and is taken when interrupts are enabled again.
 */
void cpu_sleep(void);

/**
 * @return the cycles of the processor's clock since the first call. Mainline.
 *
 * Cortex-M: uses SysTick exclusively, which counts 24 bits. A Cortex-M3 and larger also uses the cycle counter of the
 * DWT, so that up to 2^32 cycles may pass between two calls while the processor is awake, e.g. in an erase of flash;
 * asleep, or on a Cortex-M0+, up to 2^24: a slower driver of flash calls this function while it waits, from RAM.
 * RISC-V: mcycle, without a limit.
 */
uint64_t cpu_cycles(void);

/**
 * Makes an address range device memory: accesses are not cached, reordered, merged or speculated. For an ESC at an
 * address of normal memory, on a Cortex-M7 below 0x80000000 outside its peripherals. Uses the last region of the MPU,
 * which has the highest priority; no effect on a processor without an MPU (ARMv6-M, ARMv7-M), which has no cache
 * either. RISC-V: no effect, because the chip defines the attributes.
 * @param base  a multiple of the size
 * @param bits  the size is 2^bits bytes, 5..31
 */
void cpu_device_memory(uint32_t base, unsigned int bits);

/** Cortex-M: enables interrupt `number` of the chip. */
void cpu_interrupt_enable(unsigned int number);

/** Starts the image whose vectors are at an address, as after a reset. Cortex-M3 and above. */
_Noreturn void cpu_run(uint32_t vectors);

/** Resets the chip; a processor without a reset function restarts the image. */
_Noreturn void cpu_reset(void);

/** Initialises variables, then calls main(); called by the first instructions, with a valid stack. */
_Noreturn void cpu_start(void);

#endif
