/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Facts: what a source (a description, an EEPROM image, a slave on the wire) says of a device, in a form that all
 * sources have in common, so that any two can be compared.
 *
 * A fact is a kind, a place (index and element) and a text. A source says what it knows and is silent of the rest: only
 * what two of them know is compared. Where a source knows all of a kind (all entries of its PDOs), what it does not
 * have is a difference too.
 *
 * Host only, mainline. Memory that is short ends the program (esi/arena.h).
 */
#ifndef ECTWIN_FACTS_H
#define ECTWIN_FACTS_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "esi/arena.h"
#include "esi/model.h"
#include "seams/device.h"

/** What a fact is about; facts.c has a row for each. */
typedef enum fact_kind {
    FACT_VENDOR,
    FACT_PRODUCT,
    FACT_REVISION,
    FACT_TYPE,
    FACT_NAME,
    FACT_VENDOR_NAME,
    FACT_GROUP,
    FACT_GROUP_NAME,
    FACT_PORTS,
    FACT_EBUS,
    FACT_TIMEOUT, /**< by number, as in ::ect_timeouts_t */
    FACT_EEPROM_SIZE,
    FACT_CONFIG, /**< a word of the EEPROM's first seven */
    FACT_CHECKSUM,
    FACT_PROTOCOLS,
    FACT_COE,
    FACT_MAILBOX_OUT,
    FACT_MAILBOX_IN,
    FACT_BOOT_OUT,
    FACT_BOOT_IN,
    FACT_SM, /**< a SyncManager is there: its role */
    FACT_SM_START,
    FACT_SM_LENGTH,
    FACT_SM_CONTROL,
    FACT_SM_ENABLED,
    FACT_SM_DEFAULT, /**< what an ESI file says in DefaultSize */
    FACT_SM_MINIMUM,
    FACT_SM_MAXIMUM,
    FACT_FMMU, /**< an FMMU is there: its role */
    FACT_PDO,  /**< a PDO is there: its direction */
    FACT_PDO_SM,
    FACT_PDO_NAME,
    FACT_PDO_FIXED,
    FACT_PDO_MANDATORY,
    FACT_PDO_EXCLUDES,
    FACT_PDO_ENTRY, /**< an entry is there: what it maps, and its length; elements count from 1 */
    FACT_PDO_ENTRY_NAME,
    FACT_PDO_ENTRY_TYPE,
    FACT_OBJECT, /**< an object is there: its code */
    FACT_OBJECT_NAME,
    FACT_ENTRY, /**< an entry is there: its length */
    FACT_ENTRY_TYPE,
    FACT_ENTRY_ACCESS,
    FACT_ENTRY_NAME,
    FACT_ENTRY_DEFAULT,
    FACT_ENTRY_LIMITS,
    FACT_ENTRY_UNIT,
    FACT_DC, /**< a mode of the clocks is there: its name */
    FACT_DC_ACTIVATE,
    FACT_DC_SYNC0,
    FACT_DC_SYNC1,
    FACT_KINDS
} fact_kind_t;

typedef struct fact {
    fact_kind_t kind;
    uint16_t index;
    uint16_t element;
    bool made;          /**< it follows from others: a source without it has it none the less */
    const char *text;   /**< NULL: it is there, and what it is is not known */
    const char *source; /**< who says so */
} fact_t;

/** What a source says. All zero but for `source`: nothing. Freed with ::facts_free. */
typedef struct facts {
    const char *source; /**< as the user named it; outlives the facts */
    ect_arena_t arena;
    fact_t *list;
    size_t count;
    bool complete[FACT_KINDS]; /**< of kinds that tell that something is there: all of them are told */
} facts_t;

/** Adds a fact and returns it. `format` NULL: there, and not known. */
__attribute__((format(printf, 5, 6))) fact_t *facts_add(facts_t *facts, fact_kind_t kind, unsigned int index,
                                                        unsigned int element, const char *format, ...);

/** Adds a text: what is none (NULL, empty) or has letters beyond ISO 646, which each source spells its own way, is not.
 */
void facts_add_text(facts_t *facts, fact_kind_t kind, unsigned int index, unsigned int element, const char *text,
                    size_t length);

/** Adds what is mapped by the three numbers of a PDO's entry. */
void facts_add_mapping(facts_t *facts, unsigned int pdo, unsigned int element, unsigned int index,
                       unsigned int subindex, unsigned int bits);

/** Adds the rights of an entry: ECT_ACCESS_... */
void facts_add_access(facts_t *facts, unsigned int index, unsigned int subindex, unsigned int access);

/** Adds bytes as a default, without the zeros at the end. */
void facts_add_default(facts_t *facts, unsigned int index, unsigned int subindex, const uint8_t *bytes, size_t length);

/** True for mapping and assignment objects: what they hold are facts of PDOs, and a difference in it is told there. */
bool facts_are_of_pdos(unsigned int index);

/** True for identity and roles of SyncManagers: what they hold is told by other facts. */
bool facts_are_told_elsewhere(unsigned int index);

/** Adds the role of a SyncManager or FMMU: ECT_SM_..., ECT_FMMU_... */
void facts_add_sm(facts_t *facts, unsigned int sm, unsigned int type);
void facts_add_fmmus(facts_t *facts, const uint8_t *roles, size_t count);

/** Adds mailbox protocols and CoE details, ECT_MAILBOX_..., ECT_COE_.... */
void facts_add_protocols(facts_t *facts, unsigned int protocols, unsigned int coe_details);

/** Adds a mailbox of the EEPROM's header. */
void facts_add_mailbox(facts_t *facts, fact_kind_t kind, unsigned int start, unsigned int length);

/**
 * Compares and learns: prints a line for each fact of `found` that is another in `known`, then adds to `known` what it
 * did not know.
 * @param[in,out] known  the expectation; keeps pointers into `found`, which must outlive it
 * @return how many lines
 */
size_t facts_compare(facts_t *known, const facts_t *found, FILE *out);

void facts_free(facts_t *facts);

/* --- sources ------------------------------------------------------------------------------------------------------ */

/** What a description says. */
void facts_of_device(facts_t *facts, const ect_device_t *device);

/**
 * What an ESI file says: what the twin that is made of it says, and what only a file does. Objects that the twin has
 * and the file has not are made up.
 */
void facts_of_esi(facts_t *facts, const ect_device_t *device, const ect_esi_device_t *model);

/** What an EEPROM's image says; any bytes. */
void facts_of_sii(facts_t *facts, const uint8_t *image, size_t size);

/** What a slave's dictionary says, as ectwin-probe writes it. @return false: `json` is not that */
bool facts_of_dictionary(facts_t *facts, const char *json);

#endif
