/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Interfaces between the files of check/. From the lowest to the highest; each file uses only files above it in this
 * list (tests/check/order.py):
 *
 *   report.c   the line
 *   chip.c     ESC, SyncManagers, FMMUs, mailboxes
 *   objects.c  objects and entries
 *   details.c  units, limits, defaults
 *   pdos.c     assignments and mappings
 *   drives.c   SoE
 *   offers.c   names, protocols, object services, clocks, SII
 *   plant.c    signals
 *   check.c    all checks, in an order in which each relies on the previous ones
 *
 * Each function returns true if there is no mistake; the report has the first mistake.
 */
#ifndef ECT_CHECK_INTERNAL_H
#define ECT_CHECK_INTERNAL_H

#include "check/check.h"

typedef struct report {
    const ect_device_t *device;
    ect_od_t od; /* the device's dictionary, without an instance */
    char *text;
    size_t room;
} report_t;

/* Writes the line. Returns false, for the return statement of a check. */
bool wrong(const report_t *r, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* Checks that a text exists, is printable (ISO 646), and has 1 to `most` characters. `what`: its name. */
bool text_good(const report_t *r, const char *what, const char *text, size_t most);

/* Checks that the ESC exists, and has enough SyncManagers and FMMUs. */
bool check_esc(const report_t *r);
bool check_layout(const report_t *r);
bool check_objects(const report_t *r);
/* @return bytes of an entry's value in the instance */
size_t storage_of(const ect_entry_t *entry);
bool is_integer_type(uint16_t type);
bool is_signed_type(uint16_t type);
bool check_details(const report_t *r);
bool check_pdos(const report_t *r);
bool check_names(const report_t *r);
/* Checks the stack's SoE, where the device has it: its tables of IDNs. */
bool check_soe(const report_t *r);
bool check_offers(const report_t *r);
bool check_sii(const report_t *r);

#endif
