/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Byte offsets of fields in the header of an SII, little-endian words (ETG.1000.6 §5.4, Table 16; ETG.2010).
 */
#ifndef ECT_WIRE_SII_H
#define ECT_WIRE_SII_H

/** A mailbox is described by its start address and, two bytes later, its length. */
enum {
    ECT_SII_AT_ALIAS = 0x08,
    ECT_SII_AT_CHECKSUM = 0x0E, /**< of the preceding bytes: wire/crc.h */
    ECT_SII_AT_VENDOR = 0x10,
    ECT_SII_AT_PRODUCT = 0x14,
    ECT_SII_AT_REVISION = 0x18,
    ECT_SII_AT_SERIAL = 0x1C,
    ECT_SII_AT_BOOT_OUT = 0x28,
    ECT_SII_AT_BOOT_IN = 0x2C,
    ECT_SII_AT_MAILBOX_OUT = 0x30,
    ECT_SII_AT_MAILBOX_IN = 0x34,
    ECT_SII_AT_PROTOCOLS = 0x38,
    ECT_SII_AT_SIZE = 0x7C, /**< in Kbit, minus one */
    ECT_SII_AT_VERSION = 0x7E,
};

#endif
