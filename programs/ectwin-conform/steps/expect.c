/* SPDX-License-Identifier: MIT */
/* Expectations: each compares one value with the expected one and ends the case when they differ. */
#include "steps/engine.h"

static int digits(uint64_t a, uint64_t b)
{
    uint64_t larger = a > b ? a : b;
    return larger > UINT32_MAX ? 16 : larger > UINT16_MAX ? 8 : larger > UINT8_MAX ? 4 : 2;
}

void cf_expect(cf_t *c, const char *what, uint64_t expected, uint64_t got)
{
    int width = digits(expected, got);
    if (expected != got)
        cf_fail(c, "%s: expected 0x%0*llX, got 0x%0*llX", what, width, (unsigned long long)expected, width,
                (unsigned long long)got);
}

void cf_expect_bits(cf_t *c, const char *what, uint64_t mask, uint64_t expected, uint64_t got)
{
    int width = digits(mask | expected, got);
    if (((expected ^ got) & mask) != 0)
        cf_fail(c, "%s: expected 0x%0*llX in the bits 0x%0*llX, got 0x%0*llX", what, width,
                (unsigned long long)(expected & mask), width, (unsigned long long)mask, width, (unsigned long long)got);
}

void cf_expect_range(cf_t *c, const char *what, uint64_t minimum, uint64_t maximum, uint64_t got)
{
    if (got >= minimum && got <= maximum)
        return;
    if (minimum == maximum)
        cf_fail(c, "%s: expected %llu, got %llu", what, (unsigned long long)minimum, (unsigned long long)got);
    cf_fail(c, "%s: expected %llu..%llu, got %llu", what, (unsigned long long)minimum, (unsigned long long)maximum,
            (unsigned long long)got);
}

void cf_expect_wkc(cf_t *c, const char *what, unsigned int expected, unsigned int got)
{
    if (expected != got)
        cf_fail(c, "WKC of %s: expected %u, got %u", what, expected, got);
}

void cf_expect_bytes(cf_t *c, const char *what, const void *expected, const void *got, size_t length)
{
    const uint8_t *e = expected, *g = got;
    for (size_t i = 0; i < length; i++) {
        if (e[i] != g[i])
            cf_fail(c, "%s: byte %zu of %zu: expected 0x%02X, got 0x%02X", what, i, length, e[i], g[i]);
    }
}
