/* SPDX-License-Identifier: MIT */
#include "esi/arena.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "wire/assert.h"

enum { BLOCK_SIZE = 64 * 1024, ALIGNMENT = _Alignof(max_align_t) };

typedef struct ect_arena_block {
    struct ect_arena_block *next;
    size_t used;
    _Alignas(max_align_t) unsigned char bytes[];
} ect_arena_block_t;

static void add_block(ect_arena_t *arena, size_t size)
{
    size_t room = size > BLOCK_SIZE ? size : BLOCK_SIZE;
    ect_arena_block_t *block = calloc(1, sizeof *block + room);
    if (block == NULL) {
        (void)fprintf(stderr, "ectwin: no memory left\n");
        abort();
    }
    block->next = arena->blocks;
    arena->blocks = block;
    arena->room = room;
}

void *ect_arena_alloc(ect_arena_t *arena, size_t size)
{
    size_t rounded = (size + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
    if (arena->blocks == NULL || arena->room < rounded)
        add_block(arena, rounded);
    ECT_ASSERT(rounded >= size && arena->room >= rounded);
    void *memory = arena->blocks->bytes + arena->blocks->used;
    arena->blocks->used += rounded;
    arena->room -= rounded;
    return memory;
}

char *ect_arena_copy(ect_arena_t *arena, const char *text, size_t length)
{
    ECT_ASSERT(text != NULL);
    char *copy = ect_arena_alloc(arena, length + 1);
    memcpy(copy, text, length);
    return copy;
}

char *ect_arena_print(ect_arena_t *arena, const char *format, ...)
{
    va_list arguments;
    va_list again;
    va_start(arguments, format);
    va_copy(again, arguments);
    int length = vsnprintf(NULL, 0, format, arguments);
    ECT_ASSERT(length >= 0); /* all formats are constants of this project */
    char *text = ect_arena_alloc(arena, (size_t)length + 1);
    (void)vsnprintf(text, (size_t)length + 1, format, again);
    va_end(again);
    va_end(arguments);
    return text;
}

void *ect_arena_grow(ect_arena_t *arena, void *array, size_t count, size_t element_size)
{
    ECT_ASSERT(element_size > 0 && (array != NULL || count == 0));
    if (count == 0)
        return ect_arena_alloc(arena, 4 * element_size);
    if (count < 4 || (count & (count - 1)) != 0)
        return array;
    void *larger = ect_arena_alloc(arena, 2 * count * element_size);
    memcpy(larger, array, count * element_size);
    return larger;
}

void ect_arena_free(ect_arena_t *arena)
{
    while (arena->blocks != NULL) {
        ect_arena_block_t *next = arena->blocks->next;
        free(arena->blocks);
        arena->blocks = next;
    }
    arena->room = 0;
}
