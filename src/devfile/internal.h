/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Declarations that the files of devfile/ share. No other room includes this header.
 *
 * A draft contains the objects of a file until their PDOs are known: the mapping determines the access rights of an
 * entry. From the lowest to the highest: value.c (types and values of an entry), draft.c (objects, and the model),
 * fields.c (names of bits and values), table.c, objects.c, pdos.c, modules.c, layout.c (parts of a file),
 * generator.c (another format), devfile.c (the file).
 */
#ifndef ECT_DEVFILE_INTERNAL_H
#define ECT_DEVFILE_INTERNAL_H

#include "devfile/devfile.h"
#include "esi/arena.h"
#include "esi/model.h"
#include "od/od.h"
#include "text/mistake.h"
#include "wire/assert.h"
#include "yaml/document.h"

/** A text of the file and its line; NULL: absent. */
typedef struct ect_word {
    const char *text;
    size_t line;
} ect_word_t;

/** Keys of an entry. */
typedef enum ect_word_key {
    ECT_WORD_NAME,
    ECT_WORD_TYPE,
    ECT_WORD_ACCESS,
    ECT_WORD_DEFAULT,
    ECT_WORD_MIN,
    ECT_WORD_MAX,
    ECT_WORD_UNIT,
    ECT_WORD_WRITE_IN,
    ECT_WORD_BACKUP,
    ECT_WORD_SETTING,
    ECT_WORDS,
} ect_word_key_t;

/** An entry of a draft. */
typedef struct ect_draft_entry {
    uint8_t subindex;
    uint16_t type, bits;
    uint16_t access; /**< without the rights of PDO mapping; 0: not given */
    bool rx, tx;     /**< mapped by an RxPDO, by a TxPDO */
    bool limited;
    int64_t minimum, maximum; /**< with `limited` */
    ect_esi_bytes_t initial;
    uint32_t unit;
    const char *name;
    size_t line;
} ect_draft_entry_t;

/** An object of a draft; sub-index 0 of a record or an array is not among its entries. */
typedef struct ect_draft_object {
    uint16_t index;
    uint8_t code; /**< ECT_OBJECT_... */
    const char *name;
    ect_draft_entry_t *entries;
    size_t count;
    size_t line;
} ect_draft_object_t;

/** A device under construction. */
typedef struct ect_draft {
    ect_mistake_t mistake;
    ect_yaml_t yaml;
    ect_arena_t *arena; /**< of the model */
    ect_esi_device_t *device;
    ect_draft_object_t *objects;
    size_t object_count, entry_count;
    uint32_t *positions; /**< by index: position + 1; 0: none */
    ect_field_t *fields; /**< of the model; grows */
    size_t field_count;
    uint16_t mailbox_bytes;     /**< size of each mailbox in the standard layout; 0: no mailbox */
    uint8_t moves;              /**< of each index: ECT_ESI_BY_SLOT while a module is read */
    uint32_t *module_positions; /**< `positions` of a module, all 0 between two modules; NULL: before the first */
} ect_draft_t;

/* --- value.c ------------------------------------------------------------------------------------------------------ */

/** The key of a word: "min". */
extern const char *const ect_word_names[ECT_WORDS];

/** Makes an entry from its words, without the sub-index; reports mistakes. @param line  of the entry */
void ect_draft_words(ect_draft_t *d, ect_draft_entry_t *entry, const ect_word_t *words, size_t line);

/** Replaces the default of an entry. */
void ect_draft_default(ect_draft_t *d, ect_draft_entry_t *entry, ect_word_t word);

/** @return true: an integer, a bit or bits */
bool ect_draft_is_integer(const ect_draft_entry_t *entry);

/** Computes the range of an integer; of an unsigned integer of 64 bits only the lower half. */
void ect_draft_range(const ect_draft_entry_t *entry, int64_t *minimum, int64_t *maximum);

/** @return the default of an integer */
int64_t ect_draft_initial(const ect_draft_entry_t *entry);

/** @return the number of a word, minimum..maximum; any other text is a mistake and returns `minimum` */
int64_t ect_draft_number(ect_draft_t *d, const char *key, ect_word_t word, int64_t minimum, int64_t maximum);

/** @return true for "true", false for "false"; any other text is a mistake */
bool ect_draft_flag(ect_draft_t *d, const char *key, ect_word_t word);

/** @return bytes of pairs of hexadecimal digits; blanks between them are allowed; any other text is a mistake */
ect_esi_bytes_t ect_draft_hex(ect_draft_t *d, const char *key, ect_word_t word, size_t most);

/* --- draft.c ------------------------------------------------------------------------------------------------------ */

/** Adds an object. @param word  its index @return NULL: the index is in use or reserved, a mistake */
ect_draft_object_t *ect_draft_add(ect_draft_t *d, ect_word_t word, uint8_t code, const char *name);

/** Adds an entry to the last added object. @return NULL: too many, or the sub-index is in use, a mistake */
ect_draft_entry_t *ect_draft_entry(ect_draft_t *d, uint8_t subindex, const ect_draft_entry_t *entry);

/** @return the object of an index; NULL: none */
ect_draft_object_t *ect_draft_find(const ect_draft_t *d, uint16_t index);

/** Adds the entries named by a word of a PDO list: "0x6000", "0x6000:1", "gap 4". */
void ect_draft_map(ect_draft_t *d, ect_esi_pdo_t *pdo, ect_word_t word);

/** @return the word of a scalar; any other node is a mistake */
ect_word_t ect_draft_word(ect_draft_t *d, const yaml_node_t *node, const char *key);

/** Transfers the objects to the model. */
void ect_draft_end(ect_draft_t *d);

/* --- the parts of a YAML file ------------------------------------------------------------------------------------- */

/** fields.c: reads `bits` and `values` of an entry whose type is set. */
void ect_draft_bits(ect_draft_t *d, const yaml_node_t *bits, const ect_draft_entry_t *entry);
void ect_draft_values(ect_draft_t *d, const yaml_node_t *values, ect_draft_entry_t *entry);

/** fields.c: reads bits and values from cells of a table; "": none. */
void ect_draft_cells(ect_draft_t *d, ect_word_t bits, ect_word_t values, ect_draft_entry_t *entry);

/** table.c: reads the objects of a table, FILE.csv, relative to the folder of the device file. */
void ect_draft_table(ect_draft_t *d, ect_word_t word);

/** objects.c: reads `objects`, a mapping or the name of a table. */
void ect_draft_objects(ect_draft_t *d, const yaml_node_t *objects);

/** draft.c: @return the reason why no object of a file may have an index; NULL: it may */
const char *ect_draft_reserved(uint16_t index);

/** draft.c: adds a PDO. @return NULL: the index is in use, a mistake */
ect_esi_pdo_t *ect_draft_add_pdo(ect_draft_t *d, uint16_t index, bool tx, size_t line);

/** pdos.c: reads `inputs` or `outputs`. */
void ect_draft_pdos(ect_draft_t *d, const yaml_node_t *list, bool tx);

/** Keys of a device with slots; NULL: not given. */
typedef struct ect_draft_rack {
    const yaml_node_t *slots, *modules, *increments, *download;
} ect_draft_rack_t;

/** modules.c: reads `slots`, `modules`, `slot-increments` and `download-idents`, after the objects and PDOs. */
void ect_draft_rack(ect_draft_t *d, const ect_draft_rack_t *rack);

/** layout.c: adds a SyncManager. @param bytes  size of a mailbox */
ect_esi_sm_t *ect_draft_sm(ect_draft_t *d, const char *type, uint8_t control, uint16_t bytes);

/** layout.c: adds a clock mode. */
ect_esi_dc_t *ect_draft_mode(ect_draft_t *d);

/** layout.c: adds the FMMUs, and assigns the PDOs to the SyncManagers. */
void ect_draft_assign(ect_draft_t *d);

/** generator.c: @return true: a project of the EEPROM generator */
bool ect_draft_is_project(ect_draft_t *d, const yaml_node_t *root);

/** generator.c: reads a project of the EEPROM generator. */
void ect_draft_project(ect_draft_t *d, const yaml_node_t *root);

/** layout.c: read `mailbox`, `syncmanagers`, `dc`, `eeprom`; NULL: the standard. Read SyncManagers last, after PDOs. */
void ect_draft_mailbox(ect_draft_t *d, const yaml_node_t *mailbox);
void ect_draft_clocks(ect_draft_t *d, const yaml_node_t *list);
void ect_draft_eeprom(ect_draft_t *d, const yaml_node_t *eeprom);
void ect_draft_syncmanagers(ect_draft_t *d, const yaml_node_t *list);

#endif
