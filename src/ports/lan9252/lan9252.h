/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The LAN9252 on SPI (Microchip, DS00001909): an ESC with three FMMUs, four SyncManagers and 4 KB of process RAM.
 *
 * The chip has two address spaces. SPI accesses the chip's own registers and FIFOs directly, in words of 32 bits. The
 * ESC is behind these: a register of the ESC (below 0x1000) needs a command, a wait and a read; process RAM is accessed
 * through a pair of FIFOs of 64 bytes, which the chip fills and empties itself. This port maps the PDI seam to these
 * registers, regardless of the meaning of the bytes.
 *
 * | access of the stack | transfers | bytes on the SPI, without waits for the chip |
 * |---|--:|--:|
 * | register, read of 1, 2 or 4 aligned bytes | 3 | 21 |
 * | register, write of 1, 2 or 4 aligned bytes | 2 | 18 |
 * | process RAM, read of n bytes, up to 64 | 3 | 21 + 4 for each word touched |
 * | process RAM, write of n bytes, up to 64 | 4 | 28 + 4 for each word touched |
 * | ... for each further 64 bytes | 2 | 10 more |
 * | AL event word, with the interrupt pin wired and inactive | 0 | 0 |
 *
 * At 20 MHz a byte takes 0.4 us, plus chip select and driver calls for each transfer. docs/LAN9252.md has the resulting
 * cycle times of devices.
 *
 * **Bounds.** Every wait is bounded: an access of the ESC gives up after ect_lan9252_t::patience reads of the chip's
 * status (7 bytes each), the start after ect_lan9252_t::ready_ms. An access that gave up, or failed on the SPI, is also
 * ended in the chip before the next one begins.
 *
 * **Undetected errors.** SPI has no check value. The port detects a damaged command of a register access (the chip
 * returns the command), an impossible status, and a FIFO that never fills. A flipped bit in data, or in an address of
 * process RAM, is not detectable. A board with bit errors must be repaired.
 *
 * **A reset of the chip** is not visible on the bus. ::ect_lan9252_check in the main loop detects a reset.
 *
 * **Context**: as in seams/pdi.h. One ::ect_lan9252_t for each chip, owned by the caller.
 */
#ifndef ECT_PORTS_LAN9252_H
#define ECT_PORTS_LAN9252_H

#include "seams/pdi.h"
#include "seams/spi.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** One chip. Set `spi`; 0 is valid for all other members. */
typedef struct ect_lan9252 {
    const ect_spi_t *spi; /**< required; must outlive the chip's use */
    uint16_t patience;    /**< limit of status reads of an access; 0: 100 (280 us at 20 MHz) */
    uint16_t ready_ms;    /**< longest wait of a start in milliseconds; 0: 1000. Chip and EEPROM need some 10 ms each */
    uint16_t check_ms;    /**< interval of ::ect_lan9252_check in milliseconds; 0: 50 */
    bool interrupt_high;  /**< the interrupt pin is active high, and driven to both levels; false: active low */
    bool interrupt_driven; /**< an active-low pin is driven to both levels; false: open drain, pulled up by the board */
    uint64_t check_ns;     /**< time of the next read by ::ect_lan9252_check, which sets it */
    bool abandoned;        /* private: the last access has failed, and may still be under way in the chip */
} ect_lan9252_t;

/** Results of ::ect_lan9252_start. */
enum {
    ECT_LAN9252_READY = 0,
    ECT_LAN9252_SPI = -1,       /**< the SPI reported a failed transfer, or no access ended in time */
    ECT_LAN9252_SILENT = -2,    /**< no valid reply: the chip has no power, is held in reset, or is wired incorrectly */
    ECT_LAN9252_STRANGER = -3,  /**< another chip replies */
    ECT_LAN9252_NOT_READY = -4, /**< the chip was not ready in time */
    ECT_LAN9252_NO_EEPROM =
        -5, /**< the ESC has not loaded its EEPROM: empty, damaged, or not for a PDI on SPI (0x80) */
};

/**
 * Resets the chip, ESC and PHYs included, like a power cycle: by its reset pin, if wired, else by its reset register,
 * which requires a ready chip. The link is down for some seconds. ::ect_lan9252_start is due afterwards.
 * @return false: the SPI reported a failed transfer; the chip may not have been reset
 * Context: mainline. Cost: 1 ms with the pin, else one transfer.
 */
bool ect_lan9252_reset(const ect_lan9252_t *chip);

/**
 * Waits until the chip is ready and its ESC has loaded the EEPROM, ends SQI mode and accesses of an earlier program,
 * and configures the interrupt pin. Due before ::ect_slave_init, and after each reset. The ESC is unchanged.
 * @return ECT_LAN9252_READY, or the cause; the call may be repeated
 * Context: mainline. Cost: two waits of at most ect_lan9252_t::ready_ms each, with an access each millisecond.
 */
int ect_lan9252_start(ect_lan9252_t *chip);

/**
 * Checks whether the chip still has the settings of ::ect_lan9252_start. A reset by the master (0x0040), by the pin, or
 * by a short drop of the supply clears the settings: the interrupt pin then stays inactive, and polls no longer read AL
 * control. On false call ::ect_lan9252_start, then ::ect_slave_init, as after power-on.
 *
 *     while (true) {
 *         if (!ect_lan9252_check(&chip, now_ns()))
 *             start_again();
 *         (void)ect_slave_poll(&slave, now_ns());
 *         ... sleep until the pin is active, or until the earlier of slave's time and chip.check_ns
 *     }
 *
 * @param now_ns  nanoseconds of the clock of ::ect_slave_poll; never decreases
 * @return false: the chip has lost its settings · true: the chip has its settings, or ect_lan9252_t::check_ns is not
 * reached, or the SPI reports a failed transfer Context: mainline. Cost: none before ect_lan9252_t::check_ns, else one
 * transfer of 15 bytes, two for a result of false.
 */
bool ect_lan9252_check(ect_lan9252_t *chip, uint64_t now_ns);

/**
 * Returns the PDI of the chip, which must outlive its use. With ect_spi_t::line the AL event word costs no transfer
 * while no event is pending.
 */
ect_pdi_t ect_lan9252_pdi(ect_lan9252_t *chip);

ECT_C_END

#endif
