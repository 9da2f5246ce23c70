/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Check values of the SII (ETG.1000.6 §5.4) and of stored or transferred data. Computed bit by bit, without a table:
 * no caller is time-critical.
 */
#ifndef ECT_WIRE_CRC_H
#define ECT_WIRE_CRC_H

#include <stdint.h>

/** Length of the part of an SII that the check value in the low byte of word 7 covers, bytes. */
enum { ECT_SII_CHECKED_BYTES = 14 };

/** Check value of an SII: x^8 + x^2 + x + 1, initial value 0xFF. @param sii  at least ECT_SII_CHECKED_BYTES */
static inline uint8_t ect_crc_sii(const uint8_t *sii)
{
    unsigned int crc = 0xFF;
    for (int i = 0; i < ECT_SII_CHECKED_BYTES; i++) {
        crc ^= sii[i];
        for (int bit = 0; bit < 8; bit++)
            crc = (crc & 0x80) != 0 ? ((crc << 1) ^ 0x07) & 0xFF : crc << 1;
    }
    return (uint8_t)crc;
}

/**
 * CRC-32 (IEEE 802.3) of data in successive pieces: the first call takes 0xFFFFFFFF, each other call takes the previous
 * result; the published value is the complement of the last result.
 */
static inline uint32_t ect_crc32(uint32_t crc, const uint8_t *data, uint32_t length)
{
    for (uint32_t i = 0; i < length; i++) {
        crc ^= data[i];
        for (int bit = 0; bit < 8; bit++)
            crc = (crc >> 1) ^ ((crc & 1u) != 0 ? 0xEDB88320u : 0u);
    }
    return crc;
}

#endif
