/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Reader of ESI files of any vendor, including files that violate the schema.
 *
 * libxml2 parses a file once, which gives the list of devices; a device is read in full when selected. Only the file
 * itself and the `<DictionaryFile>` of a selected device are opened, the latter only in the folder of the file or below
 * it: no network, no external entity. A file with a document type definition is refused as an attack,
 * because an ESI has none. Nesting and the length of a text are bounded by libxml2's limits (256 levels, 10 MB).
 *
 * An error is one line `FILE:LINE: ERROR`. Context: mainline, host only. Cost: about 20 ms for each megabyte.
 */
#ifndef ECT_ESI_READ_H
#define ECT_ESI_READ_H

#include "esi/model.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** An open file, the owner of all results. */
typedef struct ect_esi ect_esi_t;

/** A device in the list of a file. */
typedef struct ect_esi_head {
    const char *type;
    const char *name;
    uint32_t product_code;
    uint32_t revision;
    const char *extras; /**< "slots: 2, start-up commands: 1", "": none of the parts that ::ect_esi_part_t copies */
    int line;
} ect_esi_head_t;

/**
 * Splits an operand, `FILE` or `FILE#SELECTOR`. Names of files and numbers (\#x1234) may contain '#' too: if the whole
 * operand is an existing file, there is no selector; else the selector begins at the first '#' after an existing file.
 * @return the '#' in `operand`; NULL: no selector
 */
const char *ect_esi_selector(const char *operand);

/**
 * Opens a file.
 * @param path  a regular file of at most 64 MiB
 * @param[out] text, room  the error, one line
 * @return the file; NULL: missing, too large, not XML, a document type definition, not an ESI, or without devices
 */
ect_esi_t *ect_esi_open(const char *path, char *text, size_t room);

/**
 * Opens a file in memory, as ::ect_esi_open.
 * @param name  prefix of messages
 * @param data, length  need not outlive the call
 */
ect_esi_t *ect_esi_parse(const char *name, const void *data, size_t length, char *text, size_t room);

/** @return the prefix of messages: the path, or `name` */
const char *ect_esi_file(const ect_esi_t *esi);

/** The devices in the order of the file. @param[out] count at least 1 */
const ect_esi_head_t *ect_esi_heads(const ect_esi_t *esi, size_t *count);

/**
 * Reads one device in full. Several calls are possible; each costs a walk over that device.
 * @param selector  a type (`EL1008`), `@product`, `@product/revision` (decimal or 0x…, \#x…), or "" if the file
 *                  has only one type of device. The highest of several revisions is selected.
 * @return the device; NULL: none or several match (the line lists the devices), or an invalid number, text or length
 * (the line gives its position)
 */
const ect_esi_device_t *ect_esi_select(ect_esi_t *esi, const char *selector, char *text, size_t room);

/** Frees the file and all results. NULL: no effect */
void ect_esi_close(ect_esi_t *esi);

ECT_C_END

#endif
