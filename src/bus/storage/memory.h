/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Non-volatile memory of a twin on a PC: two files; or memory of the process alone.
 */
#ifndef ECT_BUS_STORAGE_MEMORY_H
#define ECT_BUS_STORAGE_MEMORY_H

#include <stddef.h>

#include "seams/storage.h"
#include "wire/linkage.h"

ECT_C_BEGIN

enum { ECT_MEMORY_BANK = 1024 * 1024, ECT_MEMORY_PATH = 512, ECT_MEMORY_MESSAGE = 640 };

typedef struct ect_memory ect_memory_t;

/**
 * Opens the memory. A file must be one that this function has made and that no other twin uses; any other file is
 * refused and left as it is. A file whose making was cut off is completed. A save that was cut off leaves the record
 * before (seams/record.h). A file with a damaged record is kept under another name (PATH.0.damaged1 to 9, then the last
 * of these is replaced), and an empty file takes its place.
 * @param path          the files are PATH.0 and PATH.1, made when they are missing, for their user alone; NULL: in
 *                      memory only
 * @param[out] message  ECT_MEMORY_MESSAGE bytes. On failure one line for the user; else "", or a line about a file that
 *                      was put aside
 * @return the memory, to be closed with ::ect_memory_close, or NULL
 */
ect_memory_t *ect_memory_open(const char *path, char *message);
void ect_memory_close(ect_memory_t *memory);

/** The storage for ect_twin_config_t; valid until the memory is closed. */
const ect_storage_t *ect_memory_storage(const ect_memory_t *memory);

/** Sets a function that gets `number` at the end of each save, before the data are safe on a disk. NULL: none */
void ect_memory_observe(ect_memory_t *memory, void (*saved)(void *ctx, size_t number), void *ctx, size_t number);

/**
 * Sets a function that gets each result of ect_storage_t::flush, and returns the result for the caller: the moment at
 * which a disk is done is not repeatable. NULL: none
 */
void ect_memory_replace_flush(ect_memory_t *memory, int (*flushed)(void *ctx, int result), void *ctx);

ECT_C_END

#endif
