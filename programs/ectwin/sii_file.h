/* SPDX-License-Identifier: MIT */
/**
 * @file
 * EEPROM images, made from a description or read from a file, binary or Intel HEX.
 */
#ifndef ECTWIN_SII_FILE_H
#define ECTWIN_SII_FILE_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "sii/sii.h"

/** The largest EEPROM. */
enum { SII_FILE_MOST = 0x20000 };

/**
 * Reads an image. A file that begins with ':' is Intel HEX; bytes without a record are 0xFF.
 * @param[out] image  SII_FILE_MOST bytes
 * @param[out] message, room  one line with the cause of a failure
 * @return size of the image in bytes; -1: failure
 */
long sii_file_read(const char *path, uint8_t *image, char *message, size_t room);

/**
 * Makes the image of a device.
 * @param identity, alias  as for ::ect_sii_write
 * @param[out] message, room  one line with the cause of a failure
 * @return device->sii_size bytes for free(), or NULL
 */
uint8_t *sii_file_make(const ect_device_t *device, const ect_identity_t *identity, uint16_t alias, char *message,
                       size_t room);

#endif
