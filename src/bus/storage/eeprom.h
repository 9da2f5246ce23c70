/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The EEPROM of a twin on a PC in a file, which keeps what a master writes.
 *
 * The file holds two images: that of the twin's description (the factory's) and the present one. When the description
 * makes a different image at the next start (a newer ectwin, other options), each word that the master has written
 * stays, unless the factory's word has changed as well: the factory's word is newer then.
 */
#ifndef ECT_BUS_STORAGE_EEPROM_H
#define ECT_BUS_STORAGE_EEPROM_H

#include <stdint.h>

#include "wire/linkage.h"

ECT_C_BEGIN

enum { ECT_EEPROM_PATH = 1024, ECT_EEPROM_MESSAGE = ECT_EEPROM_PATH + 160 };

typedef struct ect_eeprom ect_eeprom_t;

/**
 * Opens the file, or makes it with the factory's content, for its user alone: complete, or not at all. Another kind of
 * file, or one that another twin uses, is refused and left as it is.
 * @param factory       `size` bytes, even, at least 16
 * @param[out] message  on failure one line for the user; ECT_EEPROM_MESSAGE bytes
 * @return the memory, to be closed with ::ect_eeprom_close, or NULL
 */
ect_eeprom_t *ect_eeprom_open(const char *path, const uint8_t *factory, uint32_t size, char *message);

/** Closes the file; its content is on the disk on return. NULL: no effect */
void ect_eeprom_close(ect_eeprom_t *eeprom);

/** The present content, of the factory's size; valid until the file is closed, follows ::ect_eeprom_write. */
const uint8_t *ect_eeprom_image(const ect_eeprom_t *eeprom);

/**
 * Writes the bytes that differ in `image`. They survive the end of the process at once, a power failure some seconds
 * later.
 * @param eeprom  an ::ect_eeprom_t: the shape of ect_twin_config_t::sii_written
 * Cost: a comparison, and one system call if bytes differ. The call does not wait for the disk.
 */
void ect_eeprom_write(void *eeprom, const uint8_t *image, uint32_t size);

ECT_C_END

#endif
