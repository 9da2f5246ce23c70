/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The EEPROM of a twin on a PC, in a file that keeps the words written by a master.
 *
 * The file contains two images: that of the twin's description (the factory image) and the present one. If the
 * description results in another image at the next start (a newer ectwin, other options), each word written by the
 * master is kept, unless the factory image has a new value for this word, which then prevails.
 */
#ifndef ECT_BUS_STORAGE_EEPROM_H
#define ECT_BUS_STORAGE_EEPROM_H

#include <stdint.h>

#include "wire/linkage.h"

ECT_C_BEGIN

enum { ECT_EEPROM_PATH = 1024, ECT_EEPROM_MESSAGE = ECT_EEPROM_PATH + 160 };

typedef struct ect_eeprom ect_eeprom_t;

/**
 * Opens the file, or creates it atomically with the factory image, mode 0600. Another kind of file, or a file in use by
 * another twin, is refused and unchanged.
 * @param factory       `size` bytes, even, at least 16
 * @param[out] message  on failure one line for the user; ECT_EEPROM_MESSAGE bytes
 * @return the memory, to be closed with ::ect_eeprom_close, or NULL
 */
ect_eeprom_t *ect_eeprom_open(const char *path, const uint8_t *factory, uint32_t size, char *message);

/** Closes the file; its content is on the disk on return. NULL: no effect */
void ect_eeprom_close(ect_eeprom_t *eeprom);

/** The present image, of the factory image's size; valid until the file is closed, updated by ::ect_eeprom_write. */
const uint8_t *ect_eeprom_image(const ect_eeprom_t *eeprom);

/**
 * Writes the bytes that differ in `image`. The change survives the end of the process at once, and a power failure
 * after some seconds.
 * @param eeprom  an ::ect_eeprom_t; void * as in ect_twin_config_t::sii_written
 * Cost: a comparison of the images, and one system call if bytes differ, which does not wait for the disk.
 */
void ect_eeprom_write(void *eeprom, const uint8_t *image, uint32_t size);

ECT_C_END

#endif
