/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The EEPROM of a twin on a PC: what a master writes to it outlasts the process.
 *
 * The file holds two images, the one that the twin's description made (its factory's) and the one that the master has
 * made of it. When the description makes another one the next time (a newer ectwin, other options), each word that the
 * master had written stays, unless the factory's has changed as well: then the factory's is the newer wish.
 */
#ifndef ECT_BUS_STORAGE_EEPROM_H
#define ECT_BUS_STORAGE_EEPROM_H

#include <stdint.h>

#include "wire/linkage.h"

ECT_C_BEGIN

enum { ECT_EEPROM_PATH = 1024, ECT_EEPROM_MESSAGE = ECT_EEPROM_PATH + 160 };

typedef struct ect_eeprom ect_eeprom_t;

/**
 * Opens it, or makes it with the factory's content. A file that is none of this kind, or in use by another twin, is
 * refused and left as it is.
 * @param factory       `size` bytes, even, at least 16
 * @param[out] message  on failure one line for the user; ECT_EEPROM_MESSAGE bytes
 * @return the memory, to be closed with ::ect_eeprom_close, or NULL
 */
ect_eeprom_t *ect_eeprom_open(const char *path, const uint8_t *factory, uint32_t size, char *message);

/** Closes it; what was written is on the disk when this returns. NULL: nothing happens. */
void ect_eeprom_close(ect_eeprom_t *eeprom);

/** Its content, of the factory's size; valid until it is closed, follows ::ect_eeprom_write. */
const uint8_t *ect_eeprom_image(const ect_eeprom_t *eeprom);

/**
 * Takes over what has changed in `image`. It survives the end of the process at once, a power failure a little later.
 * @param eeprom  an ::ect_eeprom_t: the shape of ect_twin_config_t::sii_written
 * Cost: a comparison, and one system call if something has changed. Nothing is waited for.
 */
void ect_eeprom_write(void *eeprom, const uint8_t *image, uint32_t size);

ECT_C_END

#endif
