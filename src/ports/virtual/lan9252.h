/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A virtual LAN9252: the SPI side of the chip, register by register and word by word, in front of a software ESC. A
 * driver for the chip (ports/lan9252, or another) runs against the model as on the board, under a real master.
 *
 * The model follows the chip's data sheet, not a driver. It has the instructions READ (0x03), FAST READ (0x0B) and
 * WRITE (0x02) with constant, ascending and descending addresses; the two FIFOs of 16 words with their windows; ID_REV,
 * IRQ_CFG, INT_STS, INT_EN, BYTE_TEST, HW_CFG, RESET_CTL, and the six registers for access to the ESC; SQI mode, which
 * RSTQIO ends. It lacks the timers, GPIO, PHYs, and the chip's other bus interfaces.
 *
 * Time is counted in bytes on the SPI, 0.4 us each at 20 MHz: an access of the ESC lasts a number of bytes, in which
 * the registers read as busy. A test therefore needs no clock, and a FIFO fills during the transfer of its reader.
 *
 * **Faults** are members that may be set at any time, 0 for none: flipped bits on the wire, a chip that is late, never
 * ready, or busy without end.
 *
 * **Mistakes** of a driver, which the real chip would execute differently or ignore, are counted, and otherwise treated
 * as by the chip: the count must stay 0.
 *
 * Context: one thread at a time, that of the software ESC too.
 */
#ifndef ECT_PORTS_VIRTUAL_LAN9252_H
#define ECT_PORTS_VIRTUAL_LAN9252_H

#include "esc/esc.h"
#include "wire/linkage.h"

ECT_C_BEGIN

enum { ECT_VIRTUAL_LAN9252_FIFO = 16 /* words */ };

/** One direction of process RAM. Private. */
typedef struct ect_virtual_fifo {
    uint32_t word[ECT_VIRTUAL_LAN9252_FIFO];
    unsigned int first, count;
    uint16_t address, left; /* next address in the ESC's memory, and remaining bytes */
    bool busy;
} ect_virtual_fifo_t;

/**
 * One chip. Zeroed, with `esc` set, the chip is ready and idle; members that are not private may be set or read at any
 * time.
 */
typedef struct ect_virtual_lan9252 {
    ect_esc_t *esc; /**< initialised; required. Its configuration has the ports with a link after a reset */

    uint32_t ready_after; /**< bytes on the SPI from a reset until READY */
    uint32_t csr_lasts;   /**< ... of an access to a register of the ESC */
    uint32_t word_lasts;  /**< ... of the ESC for each word of process RAM */
    bool never_ready;     /**< from now on */
    bool sqi;             /**< in SQI mode, possibly set by an earlier program: SPI is not accepted */
    bool active_high;     /**< the interrupt pin is active high on the board; false: active low */
    bool csr_stuck;       /**< further accesses of registers do not end */
    bool ram_stuck;       /**< the ESC moves no further word of process RAM */
    uint64_t flip_at;     /**< number of the bit to flip, counted by `bits`, 16 for each byte: 8 out, 8 in; 0: none */
    uint32_t flip_one_in; /**< probability of a flip of each bit; 0: none */
    uint32_t flip_seed;   /**< of the random flips; changes with each */

    uint64_t bits;       /**< transferred over the SPI, both ways */
    uint32_t transfers;  /**< since the caller set it to 0 */
    uint32_t bytes;      /**< ... on the SPI */
    uint32_t mistakes;   /**< of the driver */
    const char *mistake; /**< the last one, in words */

    uint32_t irq_cfg, int_en, csr_data, csr_command; /* private, and all below */
    ect_virtual_fifo_t reading, writing;
    uint32_t starting; /* bytes until READY */
    uint32_t csr_left; /* ... until a register access is done */
    uint32_t ram_time; /* ... that the ESC has not used */
    uint32_t resets;   /* resets of the ESC that the chip's registers have followed */
    bool held;         /* by the reset pin */
} ect_virtual_lan9252_t;

/**
 * Executes one SPI transfer (ect_spi_t::transfer): each byte is replaced by the byte that the chip sends.
 * @param chip  an ::ect_virtual_lan9252_t
 * @return 0
 */
int ect_virtual_lan9252_transfer(void *chip, uint8_t *bytes, uint16_t length);

/**
 * Sets the reset pin (ect_spi_t::reset): its release resets the chip and its ESC. A reset sequence of the master in
 * 0x0040, or of the PDI in 0x0041, has the same effect, as on the real chip.
 */
void ect_virtual_lan9252_reset(void *chip, bool active);

/**
 * Returns whether the interrupt pin is at the board's active level (ect_spi_t::line). The chip drives the pin, or only
 * pulls it low, according to bits 0 and 4 of IRQ_CFG.
 */
bool ect_virtual_lan9252_line(void *chip);

/** Advances the time (ect_spi_t::pause). */
void ect_virtual_lan9252_pause(void *chip, uint32_t us);

ECT_C_END

#endif
