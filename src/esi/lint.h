/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Lint: mistakes in a readable ESI file (esi/read.h).
 *
 * Engineering tools ignore a file with such a mistake silently, or misread it. The checks cover the vendor, the groups
 * and one device: order of elements, names, the group, numbers written 0x…, which only some tools read, pictures,
 * ConfigData, and elements that are obsolete by the schema. The schema of the ETG, which is not part of this project,
 * defines the validity of the whole file: ::ect_esi_validate uses the user's copy.
 *
 * Each finding is one line `FILE:LINE: FINDING`, valid during the call only. Context: mainline, host
 * only.
 *
 * Clauses: ETG.2000 and its schema 1.17.
 */
#ifndef ECT_ESI_LINT_H
#define ECT_ESI_LINT_H

#include "esi/read.h"
#include "wire/linkage.h"

/** Called for a finding. @param wrong  true: a mistake; false: a remark on something allowed */
typedef void (*ect_esi_report_t)(void *ctx, bool wrong, const char *line);

ECT_C_BEGIN

/**
 * Checks the vendor and the groups of a file, and one device.
 * @param device  from ::ect_esi_select of this file
 */
void ect_esi_lint(ect_esi_t *esi, const ect_esi_device_t *device, ect_esi_report_t report, void *ctx);

/** A schema. */
typedef struct ect_esi_schema ect_esi_schema_t;

/**
 * Reads a schema.
 * @param path  of EtherCATInfo.xsd; its includes must be in the same folder
 * @param[out] text, room  the reason of the failure, one line
 * @return to be closed with ::ect_esi_schema_close; NULL: unreadable, or not a schema
 */
ect_esi_schema_t *ect_esi_schema_open(const char *path, char *text, size_t room);

/** Validates the whole file; each mistake is reported as wrong. */
void ect_esi_validate(const ect_esi_t *esi, ect_esi_schema_t *schema, ect_esi_report_t report, void *ctx);

/** Frees a schema. NULL: no effect */
void ect_esi_schema_close(ect_esi_schema_t *schema);

ECT_C_END

#endif
