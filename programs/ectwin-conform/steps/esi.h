/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The slave's ESI file (--esi), for the cases that compare with it. What file and slave say is brought into the same
 * form, facts (facts/facts.h), and compared as `ectwin verify` does.
 *
 * A file is compared as the twin that it describes. Of a modular device only what does not depend on the modules is.
 */
#ifndef ECTWIN_CONFORM_ESI_H
#define ECTWIN_CONFORM_ESI_H

#include <cjson/cJSON.h>

#include "esi/lint.h"
#include "esi/twin.h"
#include "facts/facts.h"
#include "steps/case.h"

enum { CF_ESI_TEXT = 600 };

typedef struct cf_esi {
    const char *operand; /**< as the user wrote it: FILE, FILE#TYPE */
    char *path;          /**< the file alone */
    ect_esi_t *file;
    ect_esi_schema_t *schema;       /**< NULL: the user named none */
    const ect_esi_device_t *device; /**< of `file` */
    ect_esi_twin_t *twin;           /**< NULL: the file describes what no slave can be, `why` */
    char why[CF_ESI_TEXT];
    char title[CF_ESI_TEXT]; /**< for reports: file and device */

    /* What a case compares; kept here, for a case may be left at any step. */
    ect_facts_t said, known, found;
    cJSON *dictionary;
} cf_esi_t;

/**
 * Opens the file, before anything is asked of a slave.
 * @param operand  FILE or FILE#SELECTOR (esi/read.h); must outlive `esi`
 * @param schema   path of EtherCATInfo.xsd, NULL: none
 * @param[out] text  CF_ESI_TEXT bytes: the line that says why not
 */
bool cf_esi_open(cf_esi_t *esi, const char *operand, const char *schema, char *text);
/** Chooses the device: the user's, else the slave's by its product code and revision. @return false: `text` says why */
bool cf_esi_choose(cf_esi_t *esi, const cf_facts_t *facts, char *text);
/** Frees all. Closed already, or never opened (zeros), is allowed. */
void cf_esi_close(cf_esi_t *esi);

/* --- for cases: nothing happens when there is no file, or when its device cannot be (CF-063 tells that) ----------- */

/** What the EEPROM's image says must be as in the file: facts of these kinds, both inclusive. Else the case ends. */
void cf_esi_expect_sii(cf_t *c, ect_fact_kind_t first, ect_fact_kind_t last);
/** The PDOs that the slave's objects assign must be those of the file, entry by entry. In PREOP, with CoE. */
void cf_esi_expect_assigned(cf_t *c);
/** All objects of the slave must be those of the file. In PREOP, with CoE and its information service. */
void cf_esi_expect_objects(cf_t *c);
/** The model to compare with; NULL: no file, or no device that can be. */
const ect_esi_device_t *cf_esi_model(const cf_t *c);

#endif
