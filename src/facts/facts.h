/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Facts: the content of a source (a description, an EEPROM image, an ESI file, a slave's dictionary) in a form that all
 * sources have in common, so that any two can be compared.
 *
 * A fact is a kind, a place (index and element) and a text. A source has facts of what it knows and is silent of the
 * rest: only kinds that two sources know are compared. A source that knows all of a kind (all entries of its PDOs) is
 * complete in it: a fact of the other source that it lacks is a difference, too.
 *
 * Host only, mainline. The program ends when memory is exhausted (esi/arena.h).
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

/** Subjects of facts; facts.c has a row for each. */
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
    ECT_FACT_SM_DEFAULT, /**< DefaultSize of an ESI file */
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
    bool made;          /**< derived from others: a source without it is not different */
    const char *path;   /**< of ECT_FACT_FILE and ECT_FACT_FILE_TEXT; else NULL */
    const char *text;   /**< NULL: the thing exists, its content is not known */
    const char *source; /**< source of the fact; outlives it */
} ect_fact_t;

/** The facts of a source. All zero but for `source`: none. Freed with ::ect_facts_free. */
typedef struct ect_facts {
    const char *source; /**< as the user named it; outlives the facts */
    ect_arena_t arena;
    ect_fact_t *list;
    size_t count;
    bool complete[ECT_FACT_KINDS]; /**< of kinds that list things: the list is whole */
} ect_facts_t;

struct cJSON;

ECT_C_BEGIN

/**
 * Adds a fact.
 * @param index, element  up to 0xFFFF each
 * @param format  NULL: the thing exists, its content is not known; the text is cut at 599 characters
 * @return the fact, valid until the next one is added
 */
__attribute__((format(printf, 5, 6))) ect_fact_t *ect_facts_add(ect_facts_t *facts, ect_fact_kind_t kind,
                                                                unsigned int index, unsigned int element,
                                                                const char *format, ...);

/**
 * Adds a text of `length` bytes, without trailing blanks and zeros. A text that is empty, a placeholder ("SubIndex
 * 001"), or with letters beyond ISO 646, which each source spells its own way, is no fact.
 */
void ect_facts_add_text(ect_facts_t *facts, ect_fact_kind_t kind, unsigned int index, unsigned int element,
                        const char *text, size_t length);

/** Adds an entry of a PDO; `index` 0 is padding. @param element  from 1 */
void ect_facts_add_mapping(ect_facts_t *facts, unsigned int pdo, unsigned int element, unsigned int index,
                           unsigned int subindex, unsigned int bits);

/** Adds the rights of an entry. @param access  ECT_ACCESS_... */
void ect_facts_add_access(ect_facts_t *facts, unsigned int index, unsigned int subindex, unsigned int access);

/** Adds a default in the byte order of the wire, without trailing zeros, up to 64 bytes. */
void ect_facts_add_default(ect_facts_t *facts, unsigned int index, unsigned int subindex, const uint8_t *bytes,
                           size_t length);

/** @return true for mapping and assignment objects: their content is facts of PDOs, and differences belong there */
bool ect_facts_are_of_pdos(unsigned int index);

/** @return true for identity and roles of SyncManagers (1018h, 1C00h): other facts have their content */
bool ect_facts_are_known_elsewhere(unsigned int index);

/** FNV-1a of bytes: for contents that are compared and not printed. */
uint32_t ect_facts_sum(const void *bytes, size_t length);

/**
 * Adds an element or attribute of an ESI file. Its place in the order of facts is a check sum of the path: two paths
 * with the same one, a case in four thousand million, are one fact.
 * @param kind  ECT_FACT_FILE or ECT_FACT_FILE_TEXT
 * @param value  up to 60 characters are kept, of a longer one its length and check sum
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
 * Compares and learns: prints a line for each fact of `found` that differs in `known`, then adds the facts that `known`
 * lacks. Facts of the kind ECT_FACT_FILE_TEXT follow when there are no other differences: so two files that
 * differ in any value are never the same, and no value has two lines.
 * @param[in,out] known  the expectation; keeps pointers into `found`, which must outlive it
 * @return number of lines
 */
size_t ect_facts_compare(ect_facts_t *known, const ect_facts_t *found, FILE *out);

/**
 * Copies the facts of the kinds `first` to `last`, both inclusive, and whether their lists are whole: for comparing a
 * part.
 * @param[in,out] to  keeps pointers into `from`, which must outlive it
 */
void ect_facts_take(ect_facts_t *to, const ect_facts_t *from, ect_fact_kind_t first, ect_fact_kind_t last);

void ect_facts_free(ect_facts_t *facts);

/* --- sources ------------------------------------------------------------------------------------------------------ */

/** Facts of a description: the dictionary with CoE only. */
void ect_facts_of_device(ect_facts_t *facts, const ect_device_t *device);

/**
 * Facts of an ESI file: those of the twin that is made of it, less what the twin adds, and those that only a file has.
 * Objects of the twin that the file lacks are marked as made.
 */
void ect_facts_of_esi(ect_facts_t *facts, const ect_device_t *device, const ect_esi_device_t *model);

/** Facts of an EEPROM image; any bytes, any size. */
void ect_facts_of_sii(ect_facts_t *facts, const uint8_t *bytes, size_t size);

/** Facts of a dictionary as ectwin-probe writes it (reader/reader.h). @return false: `json` is no such text */
bool ect_facts_of_dictionary(ect_facts_t *facts, const char *json);

/** The same, parsed. */
bool ect_facts_of_objects(ect_facts_t *facts, const struct cJSON *dictionary);

ECT_C_END

#endif
