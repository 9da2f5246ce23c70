/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Non-volatile memory of a twin on a PC, in two files or only in the process.
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
 * Opens the memory. A file that this function has not created, or that another twin uses, is refused and unchanged. A
 * file whose creation was interrupted is completed. After an interrupted save the previous record is valid
 * (seams/record.h). A file with a damaged record is renamed (PATH.0.damaged1 to 9, then the last one is replaced), and
 * replaced by an empty file.
 * @param path          the files are PATH.0 and PATH.1, created if missing, with mode 0600; NULL: no files
 * @param[out] message  ECT_MEMORY_MESSAGE bytes. On failure one line for the user; else "", or a line on a renamed file
 * @return the memory, to be closed with ::ect_memory_close, or NULL
 */
ect_memory_t *ect_memory_open(const char *path, char *message);
void ect_memory_close(ect_memory_t *memory);

/** The storage for ect_twin_config_t; valid until the memory is closed. */
const ect_storage_t *ect_memory_storage(const ect_memory_t *memory);

/** Sets a function that is called with `number` at the end of each save, before the disk has the data. NULL: none */
void ect_memory_observe(ect_memory_t *memory, void (*saved)(void *ctx, size_t number), void *ctx, size_t number);

/**
 * Lets each ect_storage_t::flush wait until the disk has the data, also one that need not: a save then ends at a time
 * of the bus that does not depend on the disk's speed. Effective until the memory is closed.
 */
void ect_memory_wait(ect_memory_t *memory);

/**
 * Sets a function that gets each result of ect_storage_t::flush and returns the result for the caller, because the time
 * of a disk's completion is not reproducible. NULL: none
 */
void ect_memory_replace_flush(ect_memory_t *memory, int (*flushed)(void *ctx, int result), void *ctx);

ECT_C_END

#endif
