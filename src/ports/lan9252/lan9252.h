/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The LAN9252 on SPI (Microchip, DS00001909): an ESC with three FMMUs, four SyncManagers and 4 KB of process RAM.
 *
 * The chip has two address spaces. SPI reaches its own registers and FIFOs directly, 32 bits at a time. The ESC is
 * behind them: a register of the ESC (below 0x1000) takes a command, a wait and a read; process RAM goes through a pair
 * of FIFOs of 64 bytes, which the chip fills and empties itself. This port maps the PDI seam to these, and knows no
 * meaning of the bytes.
 *
 * | access of the stack | transfers | bytes on the SPI, when the chip is never waited for |
 * |---|--:|--:|
 * | register, read of 1, 2 or 4 aligned bytes | 3 | 21 |
 * | register, write of 1, 2 or 4 aligned bytes | 2 | 18 |
 * | process RAM, read of n bytes, up to 64 | 3 | 21 + 4 for each word that they touch |
 * | process RAM, write of n bytes, up to 64 | 4 | 28 + 4 for each word that they touch |
 * | ... for each further 64 bytes | 2 | 10 more |
 * | AL event word, with the interrupt pin wired and inactive | 0 | 0 |
 *
 * At 20 MHz a byte takes 0.4 us; chip select and driver calls of a transfer come on top. docs/LAN9252.md has the cycle
 * times that follow for a device.
 *
 * **Bounds.** Every wait counts: an access of the ESC gives up after ect_lan9252_t::patience reads of the chip's status
 * (7 bytes each), the start after ect_lan9252_t::ready_ms. An access that gave up, or failed on the SPI, is abandoned
 * in the chip too before the next one begins.
 *
 * **What SPI hides.** This bus has no check value. The port detects a damaged command of a register access (the chip
 * reads it back), an impossible status, a FIFO that never fills; it cannot detect a flipped bit in data or in an
 * address of process RAM. A board on which bits flip has to be repaired.
 *
 * **A reset of the chip** leaves no trace on the bus. ::ect_lan9252_check in the main loop detects it.
 *
 * **Context**: as in seams/pdi.h. One ::ect_lan9252_t for a chip, owned by the caller.
 */
#ifndef ECT_PORTS_LAN9252_H
#define ECT_PORTS_LAN9252_H

#include "seams/pdi.h"
#include "seams/spi.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** One chip: set `spi`; 0 is valid for all others. */
typedef struct ect_lan9252 {
    const ect_spi_t *spi; /**< required; must outlive the chip's use */
    uint16_t patience;    /**< reads of the status of an access until it gives up; 0: 100 (280 us at 20 MHz) */
    uint16_t ready_ms;    /**< longest wait of a start in milliseconds; 0: 1000. Chip and EEPROM need some 10 ms each */
    uint16_t check_ms;    /**< interval of ::ect_lan9252_check in milliseconds; 0: 50 */
    bool interrupt_high;  /**< the interrupt pin is active high, and driven to both levels; false: active low */
    bool interrupt_driven; /**< an active-low pin is driven to both levels; false: open drain, the board pulls it up */
    uint64_t check_ns;     /**< when ::ect_lan9252_check reads the chip next; written by it */
    bool abandoned;        /* private: the last access failed, the chip may still be busy with it */
} ect_lan9252_t;

/** Results of ::ect_lan9252_start. */
enum {
    ECT_LAN9252_READY = 0,
    ECT_LAN9252_SPI = -1,       /**< the SPI reported a failed transfer, or no access ended in time */
    ECT_LAN9252_SILENT = -2,    /**< no valid reply: the chip has no power, is held in reset, or is wired otherwise */
    ECT_LAN9252_STRANGER = -3,  /**< another chip replies */
    ECT_LAN9252_NOT_READY = -4, /**< the chip did not get ready in time */
    ECT_LAN9252_NO_EEPROM =
        -5, /**< the ESC has not loaded its EEPROM: empty, damaged, or not for a PDI on SPI (0x80) */
};

/**
 * Resets the chip, ESC and PHYs included, as a power cycle does: by its pin, where that is wired, else by its reset
 * register, which takes a chip that is ready. The link is down for some seconds. ::ect_lan9252_start comes next.
 * @return false: the SPI reported a failed transfer, the chip may not be reset
 * Context: mainline. Cost: 1 ms with the pin, else a transfer.
 */
bool ect_lan9252_reset(const ect_lan9252_t *chip);

/**
 * Waits until the chip is ready and its ESC has loaded the EEPROM, ends SQI mode and accesses that an earlier program
 * has left, and sets the interrupt pin up. Once before ::ect_slave_init, and after each reset. The ESC is unchanged.
 * @return ECT_LAN9252_READY, or the cause; it may be called again
 * Context: mainline. Cost: at most ect_lan9252_t::ready_ms for each of its two waits, with an access each millisecond.
 */
int ect_lan9252_start(ect_lan9252_t *chip);

/**
 * Checks whether the chip still has the settings of ::ect_lan9252_start. A reset by the master (0x0040), by the pin, or
 * by a supply that was too low for a moment clears them: the interrupt pin stays inactive from then on, AL control is
 * never read, and a poll notices nothing. On false call ::ect_lan9252_start, then ::ect_slave_init, as after power-on.
 *
 *     while (true) {
 *         if (!ect_lan9252_check(&chip, now_ns()))
 *             start_again();
 *         (void)ect_slave_poll(&slave, now_ns());
 *         ... sleep until the pin is active, or until the earlier of slave's time and chip.check_ns
 *     }
 *
 * @param now_ns  nanoseconds of the clock that ::ect_slave_poll gets; never goes back
 * @return false: the chip has lost its settings · true: it has them, or they need not be read before
 * ect_lan9252_t::check_ns, or the SPI reports a failed transfer
 * Context: mainline. Cost: nothing before ect_lan9252_t::check_ns, else one transfer of 15 bytes, two on the way to
 * false.
 */
bool ect_lan9252_check(ect_lan9252_t *chip, uint64_t now_ns);

/**
 * The PDI of the chip, which must outlive its use. With ect_spi_t::line the AL event word costs nothing while there is
 * none.
 */
ect_pdi_t ect_lan9252_pdi(ect_lan9252_t *chip);

ECT_C_END

#endif
