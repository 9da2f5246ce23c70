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
#ifndef ECT_FACTS_FACTS_H
#define ECT_FACTS_FACTS_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "esi/arena.h"
#include "esi/model.h"
#include "seams/device.h"
#include "wire/linkage.h"

/** What a fact is about; facts.c has a row for each. */
typedef enum ect_fact_kind {
    ECT_FACT_VENDOR,
    ECT_FACT_PRODUCT,
    ECT_FACT_REVISION,
    ECT_FACT_TYPE,
    ECT_FACT_NAME,
    ECT_FACT_VENDOR_NAME,
    ECT_FACT_GROUP,
    ECT_FACT_GROUP_NAME,
    ECT_FACT_PORTS,
    ECT_FACT_EBUS,
    ECT_FACT_TIMEOUT, /**< by number, as in ::ect_timeouts_t */
    ECT_FACT_EEPROM_SIZE,
    ECT_FACT_CONFIG, /**< a word of the EEPROM's first seven */
    ECT_FACT_CHECKSUM,
    ECT_FACT_PROTOCOLS,
    ECT_FACT_COE,
    ECT_FACT_MAILBOX_OUT,
    ECT_FACT_MAILBOX_IN,
    ECT_FACT_BOOT_OUT,
    ECT_FACT_BOOT_IN,
    ECT_FACT_SM, /**< a SyncManager is there: its role */
    ECT_FACT_SM_START,
    ECT_FACT_SM_LENGTH,
    ECT_FACT_SM_CONTROL,
    ECT_FACT_SM_ENABLED,
    ECT_FACT_SM_DEFAULT, /**< what an ESI file says in DefaultSize */
    ECT_FACT_SM_MINIMUM,
    ECT_FACT_SM_MAXIMUM,
    ECT_FACT_FMMU, /**< an FMMU is there: its role */
    ECT_FACT_PDO,  /**< a PDO is there: its direction */
    ECT_FACT_PDO_SM,
    ECT_FACT_PDO_NAME,
    ECT_FACT_PDO_FIXED,
    ECT_FACT_PDO_MANDATORY,
    ECT_FACT_PDO_EXCLUDES,
    ECT_FACT_PDO_ENTRY, /**< an entry is there: what it maps, and its length; elements count from 1 */
    ECT_FACT_PDO_ENTRY_NAME,
    ECT_FACT_PDO_ENTRY_TYPE,
    ECT_FACT_OBJECT, /**< an object is there: its code */
    ECT_FACT_OBJECT_NAME,
    ECT_FACT_ENTRY, /**< an entry is there: its length */
    ECT_FACT_ENTRY_TYPE,
    ECT_FACT_ENTRY_ACCESS,
    ECT_FACT_ENTRY_NAME,
    ECT_FACT_ENTRY_DEFAULT,
    ECT_FACT_ENTRY_LIMITS,
    ECT_FACT_ENTRY_UNIT,
    ECT_FACT_DC, /**< a mode of the clocks is there: its name */
    ECT_FACT_DC_ACTIVATE,
    ECT_FACT_DC_SYNC0,
    ECT_FACT_DC_SYNC1,
    ECT_FACT_FILE,           /**< an element or attribute of an ESI file that no other kind has */
    ECT_FACT_FILE_TEXT,      /**< one that others have: a difference only when there is no other */
    ECT_FACT_WORDS,          /**< reserved words of the header of an EEPROM */
    ECT_FACT_CATEGORY,       /**< a category is in an EEPROM, by type; the content of those that no other kind has */
    ECT_FACT_GENERAL,        /**< a byte of the category General that no other kind has */
    ECT_FACT_SM_BITS,        /**< status and flags of a SyncManager in an EEPROM */
    ECT_FACT_PDO_BITS,       /**< synchronization and flags of a PDO in an EEPROM */
    ECT_FACT_PDO_ENTRY_BITS, /**< flags of an entry of a PDO in an EEPROM */
    ECT_FACT_DC_TEXT,        /**< description of a mode of the clocks in an EEPROM, and its reserved bytes */
    ECT_FACT_KINDS
} ect_fact_kind_t;

typedef struct ect_fact {
    ect_fact_kind_t kind;
    uint16_t index;
    uint16_t element;
    bool made;          /**< it follows from others: a source without it has it none the less */
    const char *path;   /**< of ECT_FACT_FILE and ECT_FACT_FILE_TEXT; else NULL */
    const char *text;   /**< NULL: it is there, and what it is is not known */
    const char *source; /**< who says so */
} ect_fact_t;

/** What a source says. All zero but for `source`: nothing. Freed with ::ect_facts_free. */
typedef struct ect_facts {
    const char *source; /**< as the user named it; outlives the facts */
    ect_arena_t arena;
    ect_fact_t *list;
    size_t count;
    bool complete[ECT_FACT_KINDS]; /**< of kinds that tell that something is there: all of them are told */
} ect_facts_t;

struct cJSON;

ECT_C_BEGIN

/** Adds a fact and returns it. `format` NULL: there, and not known. */
__attribute__((format(printf, 5, 6))) ect_fact_t *ect_facts_add(ect_facts_t *facts, ect_fact_kind_t kind,
                                                                unsigned int index, unsigned int element,
                                                                const char *format, ...);

/** Adds a text: what is none (NULL, empty) or has letters beyond ISO 646, which each source spells its own way, is not.
 */
void ect_facts_add_text(ect_facts_t *facts, ect_fact_kind_t kind, unsigned int index, unsigned int element,
                        const char *text, size_t length);

/** Adds what is mapped by the three numbers of a PDO's entry. */
void ect_facts_add_mapping(ect_facts_t *facts, unsigned int pdo, unsigned int element, unsigned int index,
                           unsigned int subindex, unsigned int bits);

/** Adds the rights of an entry: ECT_ACCESS_... */
void ect_facts_add_access(ect_facts_t *facts, unsigned int index, unsigned int subindex, unsigned int access);

/** Adds bytes as a default, without the zeros at the end. */
void ect_facts_add_default(ect_facts_t *facts, unsigned int index, unsigned int subindex, const uint8_t *bytes,
                           size_t length);

/** True for mapping and assignment objects: what they hold are facts of PDOs, and a difference in it is told there. */
bool ect_facts_are_of_pdos(unsigned int index);

/** True for identity and roles of SyncManagers: what they hold is told by other facts. */
bool ect_facts_are_told_elsewhere(unsigned int index);

/** FNV-1a of bytes: for contents that are compared and not printed. */
uint32_t ect_facts_sum(const void *bytes, size_t length);

/**
 * Adds an element or attribute of an ESI file. Its place in the order of facts is a check sum of the path: two paths
 * with the same one, a case in four thousand million, are one fact.
 * @param kind  ECT_FACT_FILE or ECT_FACT_FILE_TEXT
 * @param value  up to 60 characters are kept, of a longer one its length and check sum
 */
void ect_facts_add_leaf(ect_facts_t *facts, ect_fact_kind_t kind, const char *path, const char *value);

/** Adds the role of a SyncManager or FMMU: ECT_SM_..., ECT_FMMU_... */
void ect_facts_add_sm(ect_facts_t *facts, unsigned int sm, unsigned int type);
void ect_facts_add_fmmus(ect_facts_t *facts, const uint8_t *roles, size_t count);

/** Adds mailbox protocols and CoE details, ECT_MAILBOX_..., ECT_COE_.... */
void ect_facts_add_protocols(ect_facts_t *facts, unsigned int protocols, unsigned int coe_details);

/** Adds a mailbox of the EEPROM's header. */
void ect_facts_add_mailbox(ect_facts_t *facts, ect_fact_kind_t kind, unsigned int start, unsigned int length);

/**
 * Compares and learns: prints a line for each fact of `found` that is another in `known`, then adds to `known` what it
 * did not know. Facts of the kind ECT_FACT_FILE_TEXT follow when there are no other differences: so two files that
 * differ in any value are never the same, and no value has two lines.
 * @param[in,out] known  the expectation; keeps pointers into `found`, which must outlive it
 * @return how many lines
 */
size_t ect_facts_compare(ect_facts_t *known, const ect_facts_t *found, FILE *out);

/**
 * Takes over the facts of the kinds `first` to `last`, both inclusive, and whether all of them are told: for comparing
 * a part.
 * @param[in,out] to  keeps pointers into `from`, which must outlive it
 */
void ect_facts_take(ect_facts_t *to, const ect_facts_t *from, ect_fact_kind_t first, ect_fact_kind_t last);

void ect_facts_free(ect_facts_t *facts);

/* --- sources ------------------------------------------------------------------------------------------------------ */

/** What a description says. */
void ect_facts_of_device(ect_facts_t *facts, const ect_device_t *device);

/**
 * What an ESI file says: what the twin that is made of it says, and what only a file does. Objects that the twin has
 * and the file has not are made up.
 */
void ect_facts_of_esi(ect_facts_t *facts, const ect_device_t *device, const ect_esi_device_t *model);

/** What an EEPROM's image says; any bytes. */
void ect_facts_of_sii(ect_facts_t *facts, const uint8_t *bytes, size_t size);

/** What a slave's dictionary says, as ectwin-probe writes it. @return false: `json` is not that */
bool ect_facts_of_dictionary(ect_facts_t *facts, const char *json);

/** The same, parsed (a cJSON). */
bool ect_facts_of_objects(ect_facts_t *facts, const struct cJSON *dictionary);

ECT_C_END

#endif
