/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The LAN9252 on SPI (Microchip, DS00001909): an ESC with three FMMUs, four SyncManagers and 4 KB of process RAM.
 *
 * The chip has two address spaces. Its own registers and its FIFOs are reached by SPI directly, 32 bits at a time. The
 * ESC stands behind them: a register of the ESC (below 0x1000) by a command that is written, waited for and read out;
 * process RAM by a pair of FIFOs of 64 bytes, which the chip fills and empties itself. This port is the way from the
 * PDI seam to these, and knows nothing of what the bytes mean.
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
 * At 20 MHz a byte takes 0.4 us; what a transfer costs besides is the board's. docs/LAN9252.md says what cycle time
 * follows for a device.
 *
 * **Bounds.** Every wait counts: an access of the ESC gives up after ect_lan9252_t::patience looks at the chip's status
 * (7 bytes each), the start after ect_lan9252_t::ready_ms. An access that was given up, or of which the SPI said that
 * it failed, is abandoned in the chip too before the next one begins.
 *
 * **What SPI hides.** There is no check value on this bus. The port sees a command of a register access that arrived
 * damaged (the chip shows it again), a status that cannot be, a FIFO that never fills; a bit that flips in data, or in
 * an address of process RAM, it cannot see. A board on which bits flip has to be mended.
 *
 * **Context**: as seams/pdi.h says. One ::ect_lan9252_t for a chip, owned by the caller.
 */
#ifndef ECT_PORTS_LAN9252_H
#define ECT_PORTS_LAN9252_H

#include "seams/pdi.h"
#include "seams/spi.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** One chip: fill in `spi`; 0 is good for all others. */
typedef struct ect_lan9252 {
    const ect_spi_t *spi;  /**< required; must outlive the chip's use */
    uint16_t patience;     /**< looks at the status of an access until it is given up; 0: 100 (280 us at 20 MHz) */
    uint16_t ready_ms;     /**< how long a start may take; 0: 1000. The chip needs some 10 ms, and its EEPROM as much */
    bool interrupt_high;   /**< polarity of the interrupt pin: true active high, false active low */
    bool interrupt_driven; /**< the pin is driven to both levels; false: open drain, the board pulls it up */
    bool abandoned;        /* private: the last access failed, the chip may still be about it */
} ect_lan9252_t;

/** Results of ::ect_lan9252_start. */
enum {
    ECT_LAN9252_READY = 0,
    ECT_LAN9252_SPI = -1,       /**< the SPI said that a transfer failed, or no access was ever done */
    ECT_LAN9252_SILENT = -2,    /**< nothing answers as it should: not powered, in reset, or not wired so */
    ECT_LAN9252_STRANGER = -3,  /**< a chip answers, and it is no LAN9252 */
    ECT_LAN9252_NOT_READY = -4, /**< it did not get ready in time */
    ECT_LAN9252_NO_EEPROM =
        -5, /**< the ESC has not loaded its EEPROM: empty, damaged, or not for a PDI on SPI (0x80) */
};

/**
 * Resets the chip, ESC and PHYs included, as a power cycle does: by its pin, where that is wired, else by its reset
 * register, for which it must be able to listen. All masters lose the link for some seconds.
 * @return whether it could be told; ::ect_lan9252_start comes next
 * Context: mainline. Cost: 1 ms with the pin, else a transfer.
 */
bool ect_lan9252_reset(const ect_lan9252_t *chip);

/**
 * Waits until the chip is ready and its ESC has loaded the EEPROM, ends what an earlier program may have left under
 * way, and sets the interrupt pin up. Once before ::ect_slave_init, and after each reset. Nothing of the ESC is
 * changed.
 * @return ECT_LAN9252_READY, or what is wrong; then call it again, or tell somebody
 * Context: mainline. Cost: ect_lan9252_t::ready_ms at most for each of its two waits, looking once a millisecond.
 */
int ect_lan9252_start(ect_lan9252_t *chip);

/**
 * The PDI of the chip, which must outlive its use. With ect_spi_t::line the AL event word costs nothing while there is
 * none.
 */
ect_pdi_t ect_lan9252_pdi(ect_lan9252_t *chip);

ECT_C_END

#endif
