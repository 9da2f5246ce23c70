/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Bytes on the wire: the only way in which multi-byte values enter and leave a buffer.
 *
 * EtherCAT is little-endian (ETG.1000.4 §5), a few device payloads are big-endian; the host may be either. Every
 * function here is pure, works at any alignment and accesses exactly the bytes that it names. No pointer is kept.
 */
#ifndef ECT_WIRE_BYTES_H
#define ECT_WIRE_BYTES_H

#include <stdbool.h>
#include <stdint.h>

/** Whether the host stores numbers in the byte order of the wire. A constant to any optimising compiler. */
static inline bool ect_host_is_little_endian(void)
{
    const union {
        uint16_t number;
        uint8_t bytes[2];
    } one = {.number = 1};
    return one.bytes[0] == 1;
}

/** Reads 2 bytes, least significant first. */
static inline uint16_t ect_load_le16(const void *bytes)
{
    const uint8_t *b = (const uint8_t *)bytes;
    return (uint16_t)(b[0] | (uint16_t)(b[1] << 8));
}

/** Reads 4 bytes, least significant first. */
static inline uint32_t ect_load_le32(const void *bytes)
{
    const uint8_t *b = (const uint8_t *)bytes;
    return (uint32_t)b[0] | ((uint32_t)b[1] << 8) | ((uint32_t)b[2] << 16) | ((uint32_t)b[3] << 24);
}

/** Reads 8 bytes, least significant first. */
static inline uint64_t ect_load_le64(const void *bytes)
{
    const uint8_t *b = (const uint8_t *)bytes;
    return (uint64_t)ect_load_le32(b) | ((uint64_t)ect_load_le32(b + 4) << 32);
}

/** Writes 2 bytes, least significant first. */
static inline void ect_store_le16(void *bytes, uint16_t value)
{
    uint8_t *b = (uint8_t *)bytes;
    b[0] = (uint8_t)value;
    b[1] = (uint8_t)(value >> 8);
}

/** Writes 4 bytes, least significant first. */
static inline void ect_store_le32(void *bytes, uint32_t value)
{
    uint8_t *b = (uint8_t *)bytes;
    b[0] = (uint8_t)value;
    b[1] = (uint8_t)(value >> 8);
    b[2] = (uint8_t)(value >> 16);
    b[3] = (uint8_t)(value >> 24);
}

/** Writes 8 bytes, least significant first. */
static inline void ect_store_le64(void *bytes, uint64_t value)
{
    uint8_t *b = (uint8_t *)bytes;
    ect_store_le32(b, (uint32_t)value);
    ect_store_le32(b + 4, (uint32_t)(value >> 32));
}

/** Reads 2 bytes, most significant first. */
static inline uint16_t ect_load_be16(const void *bytes)
{
    const uint8_t *b = (const uint8_t *)bytes;
    return (uint16_t)((uint16_t)(b[0] << 8) | b[1]);
}

/** Writes 2 bytes, most significant first. */
static inline void ect_store_be16(void *bytes, uint16_t value)
{
    uint8_t *b = (uint8_t *)bytes;
    b[0] = (uint8_t)(value >> 8);
    b[1] = (uint8_t)value;
}

/**
 * Copies `count` bits, least significant first (ETG.1000.4 §5), from bit `from_bit` of `from` to bit `to_bit` of `to`.
 * The bits around them are unchanged. The two areas must not overlap.
 */
static inline void ect_copy_bits(uint8_t *to, unsigned int to_bit, const uint8_t *from, unsigned int from_bit,
                                 unsigned int count)
{
    for (unsigned int i = 0; i < count; i++) {
        unsigned int from_mask = 1u << ((from_bit + i) % 8);
        unsigned int to_mask = 1u << ((to_bit + i) % 8);
        uint8_t *byte = &to[(to_bit + i) / 8];
        bool set = ((unsigned int)from[(from_bit + i) / 8] & from_mask) != 0;
        *byte = (uint8_t)(set ? *byte | to_mask : *byte & ~to_mask);
    }
}

#endif
