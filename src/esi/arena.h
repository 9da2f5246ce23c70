/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Arena: memory for objects that are freed together, such as the model of an ESI file.
 *
 * Host only. Out of memory, the program ends with one line on standard error, because no caller could continue with an
 * incomplete twin.
 */
#ifndef ECT_ESI_ARENA_H
#define ECT_ESI_ARENA_H

#include <stddef.h>

#include "wire/linkage.h"

/** An arena. Zeroed: empty. */
typedef struct ect_arena {
    struct ect_arena_block *blocks;
    size_t room; /**< free bytes in the newest block */
} ect_arena_t;

ECT_C_BEGIN

/** @return `size` zeroed bytes, aligned as by malloc(), valid until ::ect_arena_free; never NULL */
void *ect_arena_alloc(ect_arena_t *arena, size_t size);

/** @return a zero-terminated copy of the first `length` bytes of `text` */
char *ect_arena_copy(ect_arena_t *arena, const char *text, size_t length);

/** @return a text formatted as by printf() */
__attribute__((format(printf, 2, 3))) char *ect_arena_print(ect_arena_t *arena, const char *format, ...);

/**
 * Makes room for one more element in a growing array; reallocates at 4, 8, 16 … elements.
 * @param array  NULL: a new array; @param count  number of its elements
 * @return the array, which may have moved; element `count` is zeroed
 */
void *ect_arena_grow(ect_arena_t *arena, void *array, size_t count, size_t element_size);

/** Frees all memory. The arena is then empty, and can be used again. */
void ect_arena_free(ect_arena_t *arena);

ECT_C_END

#endif
