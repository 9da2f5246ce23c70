/* SPDX-License-Identifier: MIT */
#include "sha256.h"

#include <stdint.h>
#include <string.h>

#include "wire/bytes.h"

enum { BLOCK = 64, LENGTH_AT = 56, ROUNDS = 64 };

/* FIPS 180-4, 4.2.2: first 32 bits of the fractional parts of the cube roots of the first 64 primes. */
static const uint32_t constants[ROUNDS] = {
    0x428A2F98, 0x71374491, 0xB5C0FBCF, 0xE9B5DBA5, 0x3956C25B, 0x59F111F1, 0x923F82A4, 0xAB1C5ED5,
    0xD807AA98, 0x12835B01, 0x243185BE, 0x550C7DC3, 0x72BE5D74, 0x80DEB1FE, 0x9BDC06A7, 0xC19BF174,
    0xE49B69C1, 0xEFBE4786, 0x0FC19DC6, 0x240CA1CC, 0x2DE92C6F, 0x4A7484AA, 0x5CB0A9DC, 0x76F988DA,
    0x983E5152, 0xA831C66D, 0xB00327C8, 0xBF597FC7, 0xC6E00BF3, 0xD5A79147, 0x06CA6351, 0x14292967,
    0x27B70A85, 0x2E1B2138, 0x4D2C6DFC, 0x53380D13, 0x650A7354, 0x766A0ABB, 0x81C2C92E, 0x92722C85,
    0xA2BFE8A1, 0xA81A664B, 0xC24B8B70, 0xC76C51A3, 0xD192E819, 0xD6990624, 0xF40E3585, 0x106AA070,
    0x19A4C116, 0x1E376C08, 0x2748774C, 0x34B0BCB5, 0x391C0CB3, 0x4ED8AA4A, 0x5B9CCA4F, 0x682E6FF3,
    0x748F82EE, 0x78A5636F, 0x84C87814, 0x8CC70208, 0x90BEFFFA, 0xA4506CEB, 0xBEF9A3F7, 0xC67178F2};

static uint32_t rotate(uint32_t value, unsigned int bits)
{
    return value >> bits | value << (32 - bits);
}

static uint32_t load_be32(const uint8_t *at)
{
    return (uint32_t)ect_load_be16(at) << 16 | ect_load_be16(at + 2);
}

static void schedule(uint32_t w[ROUNDS], const uint8_t block[BLOCK])
{
    for (unsigned int i = 0; i < 16; i++)
        w[i] = load_be32(block + 4 * (size_t)i);
    for (unsigned int i = 16; i < ROUNDS; i++) {
        uint32_t s0 = rotate(w[i - 15], 7) ^ rotate(w[i - 15], 18) ^ w[i - 15] >> 3;
        uint32_t s1 = rotate(w[i - 2], 17) ^ rotate(w[i - 2], 19) ^ w[i - 2] >> 10;
        w[i] = w[i - 16] + s0 + w[i - 7] + s1;
    }
}

static void compress(uint32_t hash[8], const uint8_t block[BLOCK])
{
    uint32_t w[ROUNDS], v[8];
    schedule(w, block);
    memcpy(v, hash, sizeof v);
    for (unsigned int i = 0; i < ROUNDS; i++) {
        uint32_t s1 = rotate(v[4], 6) ^ rotate(v[4], 11) ^ rotate(v[4], 25);
        uint32_t t1 = v[7] + s1 + ((v[4] & v[5]) ^ (~v[4] & v[6])) + constants[i] + w[i];
        uint32_t s0 = rotate(v[0], 2) ^ rotate(v[0], 13) ^ rotate(v[0], 22);
        uint32_t t2 = s0 + ((v[0] & v[1]) ^ (v[0] & v[2]) ^ (v[1] & v[2]));
        memmove(v + 1, v, 7 * sizeof v[0]);
        v[4] += t1;
        v[0] = t1 + t2;
    }
    for (unsigned int i = 0; i < 8; i++)
        hash[i] += v[i];
}

static void finish(uint32_t hash[8], uint8_t block[BLOCK], size_t used, uint64_t total)
{
    block[used++] = 0x80;
    memset(block + used, 0, BLOCK - used);
    if (used > LENGTH_AT) {
        compress(hash, block);
        memset(block, 0, BLOCK);
    }
    for (unsigned int i = 0; i < 8; i++)
        block[LENGTH_AT + i] = (uint8_t)(8 * total >> (56 - 8 * i));
    compress(hash, block);
}

void cf_sha256(FILE *file, char hex[65])
{
    uint32_t hash[8] = {0x6A09E667, 0xBB67AE85, 0x3C6EF372, 0xA54FF53A, 0x510E527F, 0x9B05688C, 0x1F83D9AB, 0x5BE0CD19};
    uint8_t block[BLOCK];
    uint64_t total = 0;
    size_t used;
    hex[0] = 0;
    while ((used = fread(block, 1, sizeof block, file)) == BLOCK) {
        compress(hash, block);
        total += BLOCK;
    }
    if (ferror(file) != 0)
        return;
    finish(hash, block, used, total + used);
    for (unsigned int i = 0; i < 8; i++)
        snprintf(hex + 8 * (size_t)i, 9, "%08x", (unsigned int)hash[i]);
}
