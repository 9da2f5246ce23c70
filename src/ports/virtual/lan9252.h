/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A virtual LAN9252: the SPI side of the chip, register by register and word by word, in front of a software ESC. A
 * driver for the chip, ours (ports/lan9252) or another, runs against it as on the board, under a real master.
 *
 * It was written from the chip's data sheet, not from a driver. It has: the instructions READ (0x03), FAST
 * READ (0x0B) and WRITE (0x02) with addresses that stay, go up or go down; the two FIFOs of 16 words with their
 * windows; ID_REV, IRQ_CFG, INT_STS, INT_EN, BYTE_TEST, HW_CFG, RESET_CTL, and the six registers that lead to the ESC.
 * It knows SQI mode, and that RSTQIO ends it. It has not: the timers, GPIO, PHYs, and the chip's other bus
 * interfaces.
 *
 * Time is counted in bytes on the SPI, at 20 MHz 0.4 us each: an access of the ESC lasts so many of them, and while it
 * lasts the registers read as busy. So a test needs no clock, and a FIFO fills while its reader is on the way.
 *
 * **Faults** are members that may be set at any time, 0 for none: bits that flip on the wire, a chip that is late or
 * never ready, one that stays busy.
 *
 * **Mistakes** of a driver that the real chip would answer by doing something else, or nothing, are counted and
 * otherwise treated as by the chip: they must stay 0.
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
    uint16_t address, left; /* where the ESC's memory is read or written next, and how many bytes */
    bool busy;
} ect_virtual_fifo_t;

/** One chip. Zeroed, with `esc` set, it is ready and has nothing under way; what is not marked as private may be set or
 * read at any time. */
typedef struct ect_virtual_lan9252 {
    ect_esc_t *esc; /**< initialised; required. Its config names the ports with a link, which a reset begins with */

    uint32_t ready_after; /**< bytes on the SPI from a reset until READY */
    uint32_t csr_lasts;   /**< ... that an access of a register of the ESC lasts */
    uint32_t word_lasts;  /**< ... that the ESC takes for each word of process RAM */
    bool never_ready;     /**< from now on */
    bool sqi;             /**< in SQI mode, as an earlier program may have left it: SPI is not understood */
    bool active_high;     /**< the board takes a high level of the interrupt pin as active; false: a low one */
    bool csr_stuck;       /**< an access of a register that begins from now on does not end */
    bool ram_stuck;       /**< the ESC moves no word of process RAM from now on */
    uint64_t flip_at;     /**< the bit that flips, counted from `bits`; 0 none: 16 a byte, 8 of them out, 8 in */
    uint32_t flip_one_in; /**< each bit flips with this probability; 0 none */
    uint32_t flip_seed;   /**< of those; moves on with each */

    uint64_t bits;       /**< that went over the SPI, both ways */
    uint32_t transfers;  /**< since the caller set it to 0 */
    uint32_t bytes;      /**< ... on the SPI */
    uint32_t mistakes;   /**< of the driver */
    const char *mistake; /**< the last one, in words */

    uint32_t irq_cfg, int_en, csr_data, csr_command; /* private, and all below */
    ect_virtual_fifo_t reading, writing;
    uint32_t starting; /* bytes until READY */
    uint32_t csr_left; /* ... until a register access is done */
    uint32_t ram_time; /* ... that the ESC has not used */
    uint32_t resets;   /* of the ESC that the chip's registers have followed */
    bool held;         /* by the reset pin */
} ect_virtual_lan9252_t;

/**
 * One SPI transfer, in the shape of ect_spi_t::transfer: each byte is replaced by what the chip sends meanwhile.
 * @param chip  an ::ect_virtual_lan9252_t
 * @return 0
 */
int ect_virtual_lan9252_transfer(void *chip, uint8_t *bytes, uint16_t length);

/**
 * The reset pin, in the shape of ect_spi_t::reset: released, it resets the chip and its ESC. A reset sequence of the
 * master in 0x0040, or of the PDI in 0x0041, does the same, as on the real chip.
 */
void ect_virtual_lan9252_reset(void *chip, bool active);

/**
 * Whether the interrupt pin is at the level that the board takes as active, in the shape of ect_spi_t::line. The chip
 * drives the pin, or pulls it low only, as bits 0 and 4 of IRQ_CFG ask for.
 */
bool ect_virtual_lan9252_line(void *chip);

/** Lets time pass, in the shape of ect_spi_t::pause. */
void ect_virtual_lan9252_pause(void *chip, uint32_t us);

ECT_C_END

#endif
