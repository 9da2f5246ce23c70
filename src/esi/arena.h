/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Arena: memory for things that are made together and freed together, such as the model of an ESI file.
 *
 * Host only. A program that has no memory left ends with one line on standard error: a twin that is half built is of
 * no use to anybody, and no caller could do better.
 */
#ifndef ECT_ESI_ARENA_H
#define ECT_ESI_ARENA_H

#include <stddef.h>

#include "wire/linkage.h"

/** All zero: empty and ready. */
typedef struct ect_arena {
    struct ect_arena_block *blocks;
    size_t room; /**< bytes free in the newest block */
} ect_arena_t;

ECT_C_BEGIN

/** @return `size` zeroed bytes, aligned as by malloc, until ::ect_arena_free; never NULL */
void *ect_arena_alloc(ect_arena_t *arena, size_t size);

/** @return a zero-terminated copy of the first `length` bytes of `text` */
char *ect_arena_copy(ect_arena_t *arena, const char *text, size_t length);

/** @return a text made as by printf */
__attribute__((format(printf, 2, 3))) char *ect_arena_print(ect_arena_t *arena, const char *format, ...);

/**
 * Makes room for one more element in an array that grows: reallocates at the sizes 4, 8, 16 …
 * @param array  NULL for a new one; @param count  elements that it holds
 * @return the array, perhaps moved; element `count` is zeroed
 */
void *ect_arena_grow(ect_arena_t *arena, void *array, size_t count, size_t element_size);

/** Frees everything; the arena is empty and ready again. */
void ect_arena_free(ect_arena_t *arena);

ECT_C_END

#endif
