/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Lint: what of an ESI file is not as a file should be, beyond what keeps it from being read (esi/read.h).
 *
 * Engineering tools pass over a file with such a mistake without a word, or misread it. Looked at are the vendor, the
 * groups and one device: order of elements, names, the group, numbers written 0x…, which only some tools read,
 * pictures, ConfigData, and what the schema calls obsolete. Whether the whole file is valid only its schema says, which
 * is the ETG's and not here: ::ect_esi_validate takes the user's copy.
 *
 * Each finding is told in one line `FILE:LINE: what`, which is there during the call only. Context: mainline, host
 * only.
 *
 * Clauses: ETG.2000 and its schema 1.17.
 */
#ifndef ECT_ESI_LINT_H
#define ECT_ESI_LINT_H

#include "esi/read.h"
#include "wire/linkage.h"

/** Takes a finding. @param wrong  false: it is allowed, and yet worth a word */
typedef void (*ect_esi_tell_t)(void *ctx, bool wrong, const char *line);

ECT_C_BEGIN

/**
 * Looks at the file's vendor and groups, and at one device.
 * @param device  from ::ect_esi_select of this file
 */
void ect_esi_lint(ect_esi_t *esi, const ect_esi_device_t *device, ect_esi_tell_t told, void *ctx);

/** A schema that was read. */
typedef struct ect_esi_schema ect_esi_schema_t;

/**
 * Reads a schema.
 * @param path  of EtherCATInfo.xsd; what it includes must stand beside it
 * @param[out] text, room  the line that says why not
 * @return to be closed with ::ect_esi_schema_close; NULL: it cannot be read, or is none
 */
ect_esi_schema_t *ect_esi_schema_open(const char *path, char *text, size_t room);

/** Validates the whole file; each mistake is told, all as wrong. */
void ect_esi_validate(const ect_esi_t *esi, ect_esi_schema_t *schema, ect_esi_tell_t told, void *ctx);

/** NULL is allowed. */
void ect_esi_schema_close(ect_esi_schema_t *schema);

ECT_C_END

#endif
