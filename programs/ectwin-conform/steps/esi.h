/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The slave's ESI file (--esi), for the cases that compare with it. File and slave are converted to facts
 * (facts/facts.h), the dictionary by the reader of slaves (steps/reader.h), and compared as `ectwin verify` does.
 *
 * The slave is compared with the twin of the file; with a modular device only in the facts that no module changes.
 */
#ifndef ECTWIN_CONFORM_ESI_H
#define ECTWIN_CONFORM_ESI_H

#include "esi/lint.h"
#include "esi/twin.h"
#include "facts/facts.h"
#include "steps/case.h"

enum { CF_ESI_TEXT = 600 };

typedef struct cf_esi {
    const char *operand; /**< FILE or FILE#TYPE, as given */
    char *path;          /**< the file alone */
    ect_esi_t *file;
    ect_esi_schema_t *schema;       /**< NULL: none given */
    const ect_esi_device_t *device; /**< of `file` */
    ect_esi_twin_t *twin;           /**< NULL: the file describes no possible slave; reason in `why` */
    char why[CF_ESI_TEXT];
    char title[CF_ESI_TEXT]; /**< for reports: file and device */

    /* Input of a comparison; kept here because a case may be left at any step. */
    ect_facts_t documented, known, found;
    char *json; /**< objects of the slave */
} cf_esi_t;

/**
 * Opens the file, before any request to a slave.
 * @param operand  FILE or FILE#SELECTOR (esi/read.h); must outlive `esi`
 * @param schema   path of EtherCATInfo.xsd, NULL: none
 * @param[out] text  CF_ESI_TEXT bytes: on false: the reason, one line
 */
bool cf_esi_open(cf_esi_t *esi, const char *operand, const char *schema, char *text);
/** Selects the device: #TYPE of the operand, else by product code and revision. @return false: the reason is in `text`
 */
bool cf_esi_choose(cf_esi_t *esi, const cf_facts_t *facts, char *text);
/** Frees everything. A closed or zero-initialised object is allowed. */
void cf_esi_close(cf_esi_t *esi);

/* --- for cases: no effect without a file, or when its device cannot exist (CF-063 reports that) ------------------- */

/** Compares the facts first..last (inclusive) of the EEPROM's image with those of the file; a difference ends the case.
 */
void cf_esi_expect_sii(cf_t *c, ect_fact_kind_t first, ect_fact_kind_t last);
/** Compares the assigned PDOs of the slave with those of the file, entry by entry. In PREOP, with CoE. */
void cf_esi_expect_assigned(cf_t *c);
/** Compares all objects of the slave with those of the file. In PREOP, with CoE and its information service. */
void cf_esi_expect_objects(cf_t *c);
/** @return the device of the file; NULL: no file, or no possible device */
const ect_esi_device_t *cf_esi_model(const cf_t *c);

#endif
