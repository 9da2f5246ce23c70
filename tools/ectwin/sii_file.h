/* SPDX-License-Identifier: MIT */
/** @file EEPROM images in files: bytes as they are, or Intel HEX. */
#ifndef ECTWIN_SII_FILE_H
#define ECTWIN_SII_FILE_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

/** The largest EEPROM. */
enum { SII_FILE_MOST = 0x20000 };

/**
 * Reads an image; a file whose first character is ':' is Intel HEX, what it leaves out is 0xFF.
 * @param[out] image  SII_FILE_MOST bytes
 * @param[out] message, room  the line that says why not
 * @return bytes, or -1
 */
long sii_file_read(const char *path, uint8_t *image, char *message, size_t room);

#endif
