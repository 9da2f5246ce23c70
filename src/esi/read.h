/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Reads ESI files: anybody's, as they are found, not only those that keep to the schema.
 *
 * A file is parsed once by libxml2; which devices are in it is known then, and one of them is read in full when it is
 * selected. Nothing but the file itself is opened: no network, no external entity, and a file with a document type
 * definition is refused (an ESI has none; what has one is an attack). Nesting and the length of a text are bounded by
 * libxml2's limits (256 levels, 10 MB).
 *
 * An error is one line `FILE:LINE: ERROR`. Context: mainline, host only. Cost: about 20 ms a megabyte.
 */
#ifndef ECT_ESI_READ_H
#define ECT_ESI_READ_H

#include "esi/model.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** An open file; owns all that it hands out. */
typedef struct ect_esi ect_esi_t;

/** A device in the list of a file. */
typedef struct ect_esi_head {
    const char *type;
    const char *name;
    uint32_t product_code;
    uint32_t revision;
    const char *extras; /**< "slots: 2, start-up commands: 1", "" when it has none of what ::ect_esi_part_t copies */
    int line;
} ect_esi_head_t;

/**
 * Splits what a user names, `FILE` or `FILE#SELECTOR`. Files and folders may have a '#' in their names too, and a
 * number is written \#x1234: a file that is there is one, else the selector begins at the first one behind a file that
 * is there.
 * @return the '#' in `operand`, or NULL: it names a file alone
 */
const char *ect_esi_selector(const char *operand);

/**
 * Opens a file.
 * @param path  a regular file of at most 64 MiB
 * @param[out] text, room  the error, one line
 * @return the file, or NULL: not there, too large, no XML, a document type definition, no ESI, or no device in it
 */
ect_esi_t *ect_esi_open(const char *path, char *text, size_t room);

/**
 * The same from memory.
 * @param name  prefix of messages
 * @param data, length  need not outlive the call
 */
ect_esi_t *ect_esi_parse(const char *name, const void *data, size_t length, char *text, size_t room);

/** The prefix of messages: the path, or the name that was given. */
const char *ect_esi_file(const ect_esi_t *esi);

/** The devices in the order of the file. @param[out] count at least 1 */
const ect_esi_head_t *ect_esi_heads(const ect_esi_t *esi, size_t *count);

/**
 * Reads one device in full. Several calls are possible; each costs a walk over that device.
 * @param selector  a type (`EL1008`), `@product`, `@product/revision` (decimal or 0x…, \#x…), or "" when the file has
 *                  one type of device only. The highest of several revisions is taken.
 * @return the device, or NULL: nothing or too much fits (the line names what there is), or a number, a text or a
 *         length in it cannot be read (the line has its place)
 */
const ect_esi_device_t *ect_esi_select(ect_esi_t *esi, const char *selector, char *text, size_t room);

/** Frees the file and all that came from it. NULL is allowed. */
void ect_esi_close(ect_esi_t *esi);

ECT_C_END

#endif
