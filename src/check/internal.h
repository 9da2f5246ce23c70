/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Interfaces between the files of check/.
 *
 *   report.c   the line
 *   chip.c     ESC, SyncManagers, FMMUs, mailboxes
 *   objects.c  objects and entries
 *   details.c  units, limits, defaults
 *   pdos.c     assignments and mappings
 *   offers.c   names, protocols, object services, clocks, SII
 *   plant.c    signals
 *   check.c    all of it, in an order in which each may rely on the ones before
 *
 * Each function returns whether there was no mistake; the first one is in the report.
 */
#ifndef ECT_CHECK_INTERNAL_H
#define ECT_CHECK_INTERNAL_H

#include "check/check.h"

typedef struct report {
    const ect_device_t *device;
    ect_od_t od; /* its list, without an instance */
    char *text;
    size_t room;
} report_t;

/* Writes the line. Always false, so that a check ends with it. */
bool wrong(const report_t *r, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* Whether a text is there, visible (ISO 646), and 1 to `most` characters long; `what` names it. */
bool text_good(const report_t *r, const char *what, const char *text, size_t most);

/* Its ESC, and no more SyncManagers and FMMUs than that has. */
bool check_esc(const report_t *r);
bool check_layout(const report_t *r);
bool check_objects(const report_t *r);
/* Room in the instance that an entry's value takes. */
size_t storage_of(const ect_entry_t *entry);
bool is_integer_type(uint16_t type);
bool is_signed_type(uint16_t type);
bool check_details(const report_t *r);
bool check_pdos(const report_t *r);
bool check_names(const report_t *r);
bool check_offers(const report_t *r);
bool check_sii(const report_t *r);

#endif
