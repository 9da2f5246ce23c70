/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The SII: the image of a slave's EEPROM, written from a device description and read back.
 *
 * All functions are pure and may run in any context; buffers are the caller's.
 * Clauses: ETG.1000.6 §5.4 and Table 16 ff., ETG.2010.
 */
#ifndef ECT_SII_SII_H
#define ECT_SII_SII_H

#include <stddef.h>
#include <stdint.h>

#include "seams/device.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** The ESI letter of a port type of category General: MII Y, EBUS K, fast hot connect H; a blank for any other. */
static inline char ect_sii_port_letter(unsigned int type)
{
    return " Y KH           "[type & 0xFu];
}

/** Categories of the SII (ETG.2010). */
enum {
    ECT_SII_STRINGS = 10,
    ECT_SII_GENERAL = 30,
    ECT_SII_FMMU = 40,
    ECT_SII_SYNCM = 41,
    ECT_SII_TXPDO = 50,
    ECT_SII_RXPDO = 51,
    ECT_SII_DC = 60,
    ECT_SII_END = 0xFFFF,
};

/** Byte offset of the first category. */
enum { ECT_SII_CATEGORIES = 0x80 };

/**
 * Writes the image of a device: identity, mailboxes, strings, general, FMMUs, SyncManagers, PDOs with all entries,
 * distributed clocks, and 0xFF up to the end of the EEPROM. In an image that the description contains
 * (::ect_device_t::sii) only identity and alias are replaced. When the EEPROM is too small, the image omits the least
 * that ::ect_device_t::sii_omit allows. Names of PDO entries beyond the 255 strings of a table are always omitted.
 * @param device      one that `ect_device_check` (check/check.h) accepts
 * @param identity    NULL: the description's
 * @param alias       configured station alias, word 4; not 0: it is the explicit device id too, and the image declares
 * so
 * @param[out] image  `size` bytes; undefined on failure
 * @param size        at least device->sii_size
 * @return bytes of the image (device->sii_size) · -1 `size` is too small · -2 the content does not fit the EEPROM of
 * the description, or needs more than 255 strings
 */
int32_t ect_sii_write(const ect_device_t *device, const ect_identity_t *identity, uint16_t alias, uint8_t *image,
                      size_t size);

/**
 * Determines which parts an image omits for lack of room.
 * @param device        the description
 * @param[out] scratch  device->sii_size bytes, overwritten
 * @return 0: none · ECT_OMIT_... · -1: the image does not fit, even without all that ::ect_device_t::sii_omit allows
 */
int ect_sii_omission(const ect_device_t *device, uint8_t *scratch);

/**
 * Flags of a PDO in SII and ESI: those of the description (::ect_pdo_t), else by the default rule.
 * @param device  the description
 * @param pdo     a mapping object of the device
 * @return ECT_PDO_...
 */
uint16_t ect_sii_pdo_flags(const ect_device_t *device, const ect_object_t *pdo);

/** @return the number of a PDO in SII and ESI. @param pdo  index of a mapping object of the device */
uint16_t ect_sii_pdo_number(const ect_device_t *device, uint16_t pdo);

/** @return element n (from 1) of a PDO as SII and ESI have it: for a telegram of SoE, with its IDN as the index */
uint32_t ect_sii_pdo_element(const ect_device_t *device, const ect_object_t *pdo, uint32_t n);

/** @return the SyncManager that a PDO is assigned to by default; 0xFF: none */
uint8_t ect_sii_pdo_sm(const ect_device_t *device, uint16_t pdo);

/** The check value of words 0..6: CRC-8, polynomial 0x07, start value 0xFF. `image`: at least 14 bytes. */
uint8_t ect_sii_checksum(const uint8_t *image);

/**
 * Finds a category of an image of any origin; never reads beyond `size`.
 * @param image, size  the image, and its bytes
 * @param category     ECT_SII_...
 * @param[out] length  bytes of the category's data
 * @return the data inside `image`, or NULL when the category is missing or truncated by the end of the image
 */
const uint8_t *ect_sii_category(const uint8_t *image, size_t size, uint16_t category, size_t *length);

/**
 * Reads a string of the image's string table.
 * @param image, size  the image, and its bytes
 * @param index        1..255
 * @param[out] length  number of characters; they are not terminated
 * @return the characters inside `image`, or NULL when there is no such string or the table is damaged
 */
const char *ect_sii_string(const uint8_t *image, size_t size, uint8_t index, uint8_t *length);

ECT_C_END

#endif
