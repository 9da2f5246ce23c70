/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Facts: the content of a source (a description, an EEPROM image, an ESI file, a slave's dictionary) in a common form,
 * so that any two sources can be compared.
 *
 * A fact has a kind, a place (index and element) and a text. Only kinds of facts that both sources have are compared. A
 * source may be complete in a kind (all entries of its PDOs): a fact of this kind that only the other source has is
 * then a difference, too.
 *
 * Host only, mainline. Out of memory, the program ends (esi/arena.h).
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

/** Kinds of facts; facts.c has a row for each. */
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
    ECT_FACT_SM, /**< existence of a SyncManager, with its role */
    ECT_FACT_SM_START,
    ECT_FACT_SM_LENGTH,
    ECT_FACT_SM_CONTROL,
    ECT_FACT_SM_ENABLED,
    ECT_FACT_SM_DEFAULT, /**< DefaultSize of an ESI file */
    ECT_FACT_SM_MINIMUM,
    ECT_FACT_SM_MAXIMUM,
    ECT_FACT_FMMU, /**< existence of an FMMU, with its role */
    ECT_FACT_PDO,  /**< existence of a PDO, with its direction */
    ECT_FACT_PDO_SM,
    ECT_FACT_PDO_NAME,
    ECT_FACT_PDO_FIXED,
    ECT_FACT_PDO_MANDATORY,
    ECT_FACT_PDO_EXCLUDES,
    ECT_FACT_PDO_ENTRY, /**< existence of a mapping entry, with mapped object and length; elements count from 1 */
    ECT_FACT_PDO_ENTRY_NAME,
    ECT_FACT_PDO_ENTRY_TYPE,
    ECT_FACT_OBJECT, /**< existence of an object, with its object code */
    ECT_FACT_OBJECT_NAME,
    ECT_FACT_ENTRY, /**< existence of an entry, with its length */
    ECT_FACT_ENTRY_TYPE,
    ECT_FACT_ENTRY_ACCESS,
    ECT_FACT_ENTRY_NAME,
    ECT_FACT_ENTRY_DEFAULT,
    ECT_FACT_ENTRY_LIMITS,
    ECT_FACT_ENTRY_UNIT,
    ECT_FACT_DC, /**< existence of a DC mode, with its name */
    ECT_FACT_DC_ACTIVATE,
    ECT_FACT_DC_SYNC0,
    ECT_FACT_DC_SYNC1,
    ECT_FACT_FILE,           /**< an element or attribute of an ESI file not covered by other kinds */
    ECT_FACT_FILE_TEXT,      /**< one covered by other kinds: reported only if there is no other difference */
    ECT_FACT_WORDS,          /**< reserved words of the header of an EEPROM */
    ECT_FACT_CATEGORY,       /**< a category of an EEPROM, by type; with its content if not covered by other kinds */
    ECT_FACT_GENERAL,        /**< a byte of category General not covered by other kinds */
    ECT_FACT_SM_BITS,        /**< status and flags of a SyncManager in an EEPROM */
    ECT_FACT_PDO_BITS,       /**< synchronization and flags of a PDO in an EEPROM */
    ECT_FACT_PDO_ENTRY_BITS, /**< flags of an entry of a PDO in an EEPROM */
    ECT_FACT_DC_TEXT,        /**< description of a DC mode in an EEPROM, and its reserved bytes */
    ECT_FACT_KINDS
} ect_fact_kind_t;

typedef struct ect_fact {
    ect_fact_kind_t kind;
    uint16_t index;
    uint16_t element;
    bool made;          /**< derived from other facts: its absence in a source is no difference */
    const char *path;   /**< of ECT_FACT_FILE and ECT_FACT_FILE_TEXT; else NULL */
    const char *text;   /**< NULL: existence only, content unknown */
    const char *source; /**< source of the fact; outlives it */
} ect_fact_t;

/** The facts of a source. Set `source` and zero the other members; free with ::ect_facts_free. */
typedef struct ect_facts {
    const char *source; /**< as named by the user; must outlive the facts */
    ect_arena_t arena;
    ect_fact_t *list;
    size_t count;
    bool complete[ECT_FACT_KINDS]; /**< by kind: the source has all facts of the kind */
} ect_facts_t;

struct cJSON;

ECT_C_BEGIN

/**
 * Adds a fact.
 * @param index, element  up to 0xFFFF each
 * @param format  NULL: existence only, content unknown; the text is truncated to 599 characters
 * @return the fact, valid until the next one is added
 */
__attribute__((format(printf, 5, 6))) ect_fact_t *ect_facts_add(ect_facts_t *facts, ect_fact_kind_t kind,
                                                                unsigned int index, unsigned int element,
                                                                const char *format, ...);

/**
 * Adds a text of `length` bytes, without trailing blanks and zeros. No fact is added for an empty text, a placeholder
 * ("SubIndex 001"), or a text with letters beyond ISO 646, whose encoding depends on the source.
 */
void ect_facts_add_text(ect_facts_t *facts, ect_fact_kind_t kind, unsigned int index, unsigned int element,
                        const char *text, size_t length);

/** Adds an entry of a PDO; `index` 0 is padding. @param element  from 1 */
void ect_facts_add_mapping(ect_facts_t *facts, unsigned int pdo, unsigned int element, unsigned int index,
                           unsigned int subindex, unsigned int bits);

/** Adds the rights of an entry. @param access  ECT_ACCESS_... */
void ect_facts_add_access(ect_facts_t *facts, unsigned int index, unsigned int subindex, unsigned int access);

/** Adds a default of up to 64 bytes, little-endian, without trailing zeros. */
void ect_facts_add_default(ect_facts_t *facts, unsigned int index, unsigned int subindex, const uint8_t *bytes,
                           size_t length);

/** @return true: a mapping or assignment object, whose content is compared by the kinds of PDOs */
bool ect_facts_are_of_pdos(unsigned int index);

/** @return true: 1018h or 1C00h, whose content is compared by other kinds */
bool ect_facts_are_known_elsewhere(unsigned int index);

/** @return FNV-1a of bytes, for contents that are compared but not printed */
uint32_t ect_facts_sum(const void *bytes, size_t length);

/**
 * Adds an element or attribute of an ESI file. Its place is a 32-bit hash of the path; two paths with the same hash
 * would be one fact.
 * @param kind  ECT_FACT_FILE or ECT_FACT_FILE_TEXT
 * @param value  up to 60 characters are stored; a longer value is stored as its length and hash
 */
void ect_facts_add_leaf(ect_facts_t *facts, ect_fact_kind_t kind, const char *path, const char *value);

/** Adds the role of a SyncManager (ECT_SM_...), or those of all FMMUs (ECT_FMMU_..., 0xFF: unused). */
void ect_facts_add_sm(ect_facts_t *facts, unsigned int sm, unsigned int type);
void ect_facts_add_fmmus(ect_facts_t *facts, const uint8_t *roles, size_t count);

/** Adds mailbox protocols and CoE details, ECT_MAILBOX_..., ECT_COE_.... */
void ect_facts_add_protocols(ect_facts_t *facts, unsigned int protocols, unsigned int coe_details);

/** Adds a mailbox of the EEPROM's header. */
void ect_facts_add_mailbox(ect_facts_t *facts, ect_fact_kind_t kind, unsigned int start, unsigned int length);

/**
 * Prints a line for each fact of `found` that differs in `known`, then adds the facts missing from `known`. Differences
 * of the kind ECT_FACT_FILE_TEXT are printed only if there are no others, so any difference of two files is reported,
 * and no value has two lines.
 * @param[in,out] known  the expectation; refers to `found` afterwards, which must outlive `known`
 * @return number of lines
 */
size_t ect_facts_compare(ect_facts_t *known, const ect_facts_t *found, FILE *out);

/**
 * Copies the facts of the kinds `first` to `last` inclusive, and their completeness, for a partial comparison.
 * @param[in,out] to  refers to `from` afterwards, which must outlive `to`
 */
void ect_facts_take(ect_facts_t *to, const ect_facts_t *from, ect_fact_kind_t first, ect_fact_kind_t last);

void ect_facts_free(ect_facts_t *facts);

/* --- sources ------------------------------------------------------------------------------------------------------ */

/** Adds the facts of a description; of the dictionary only with CoE. */
void ect_facts_of_device(ect_facts_t *facts, const ect_device_t *device);

/**
 * Adds the facts of an ESI file: those of its twin, except those added by the twin, and those that only a file has.
 * Objects of the twin that are not in the file are marked as made.
 */
void ect_facts_of_esi(ect_facts_t *facts, const ect_device_t *device, const ect_esi_device_t *model);

/** Adds the facts of an EEPROM image of any content and size. */
void ect_facts_of_sii(ect_facts_t *facts, const uint8_t *bytes, size_t size);

/** Adds the facts of a dictionary written by ectwin-probe (reader/reader.h). @return false: `json` is another text */
bool ect_facts_of_dictionary(ect_facts_t *facts, const char *json);

/** Adds the facts of a parsed dictionary. */
bool ect_facts_of_objects(ect_facts_t *facts, const struct cJSON *dictionary);

ECT_C_END

#endif
