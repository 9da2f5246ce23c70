/* SPDX-License-Identifier: MIT */
/** @file Parts of a cloned slave that are blanked in its file: `ectwin clone --blank`. */
#ifndef ECTWIN_CLONE_BLANK_H
#define ECTWIN_CLONE_BLANK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/** Parts, one bit each. */
enum {
    CLONE_BLANK_SERIAL = 1, /**< serial number: EEPROM, 1018:04 */
    CLONE_BLANK_ALIAS = 2,  /**< station alias: EEPROM */
    CLONE_BLANK_NAMES = 4,  /**< name, order number, group, picture of the EEPROM; 1008h to 100Ah */
    CLONE_BLANK_TEXTS = 8,  /**< texts that a master can write */
};

/** Reads "serial,alias", or "none". @param[out] parts  CLONE_BLANK_... @return false: another text */
bool clone_blank_parse(const char *text, unsigned int *parts);

/** @return the parts as a text, "serial, alias"; "nothing" for none; constant or in `text` */
const char *clone_blank_text(unsigned int parts, char text[40]);

/** Blanks an EEPROM image: numbers become 0, letters x. The check value is unchanged, and may then be wrong. */
void clone_blank_image(unsigned int parts, uint8_t *image, size_t size);

/**
 * Blanks the value of an entry: numbers become 0, letters of names x, texts that a master can write empty.
 * @param type, access  the values of SDO information
 */
void clone_blank_value(unsigned int parts, uint16_t index, uint8_t subindex, uint16_t type, uint16_t access,
                       uint8_t *value, size_t size);

#endif
