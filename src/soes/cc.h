/* SPDX-License-Identifier: MIT */
/**
 * @file
 * SOES's API for the compiler: byte order, packing, atomic access, assertions, debug output.
 *
 * `htoes` and `htoel` convert a 16- or 32-bit number from the processor's byte order to the ESC's, `etohs` and `etohl`
 * back. Exactly one of EC_LITTLE_ENDIAN and EC_BIG_ENDIAN is defined.
 */
#ifndef ECT_SOES_CC_H
#define ECT_SOES_CC_H

#include <assert.h>
#include <inttypes.h>
#include <stddef.h>
#include <stdint.h>

#ifndef MIN
#define MIN(a, b) ((a) < (b) ? (a) : (b))
#endif
#ifndef MAX
#define MAX(a, b) ((a) > (b) ? (a) : (b))
#endif

#define CC_PACKED_BEGIN
#define CC_PACKED_END
#define CC_PACKED     __attribute__((packed))
#define CC_ALIGNED(n) __attribute__((aligned(n)))
#define CC_DEPRECATED __attribute__((deprecated))

#define CC_ASSERT(exp) assert(exp)
#ifdef __cplusplus
#define CC_STATIC_ASSERT(exp, msg) static_assert(exp, msg)
#else
#define CC_STATIC_ASSERT(exp, msg) _Static_assert(exp, msg)
#endif

#define CC_SWAP16(x) __builtin_bswap16(x)
#define CC_SWAP32(x) __builtin_bswap32(x)

/** Access to variables that an interrupt accesses too; AND, OR, ADD and SUB return the new value. */
#define CC_ATOMIC_SET(var, val) __atomic_store_n(&(var), (val), __ATOMIC_SEQ_CST)
#define CC_ATOMIC_GET(var)      __atomic_load_n(&(var), __ATOMIC_SEQ_CST)
#define CC_ATOMIC_ADD(var, val) __atomic_add_fetch(&(var), (val), __ATOMIC_SEQ_CST)
#define CC_ATOMIC_SUB(var, val) __atomic_sub_fetch(&(var), (val), __ATOMIC_SEQ_CST)
#define CC_ATOMIC_AND(var, val) __atomic_and_fetch(&(var), (val), __ATOMIC_SEQ_CST)
#define CC_ATOMIC_OR(var, val)  __atomic_or_fetch(&(var), (val), __ATOMIC_SEQ_CST)

#if __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
#define EC_BIG_ENDIAN
#define htoes(x) CC_SWAP16((uint16_t)(x))
#define htoel(x) CC_SWAP32((uint32_t)(x))
#else
#define EC_LITTLE_ENDIAN
#define htoes(x) ((uint16_t)(x))
#define htoel(x) ((uint32_t)(x))
#endif
#define etohs(x) htoes(x)
#define etohl(x) htoel(x)

/** With ESC_DEBUG defined, an application prints lines to standard output. */
#ifdef ESC_DEBUG
#include <stdio.h>
#define DPRINT(...) printf("soes: " __VA_ARGS__)
#else
#define DPRINT(...)
#endif

#endif
