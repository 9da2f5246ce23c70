/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Declarations that the files of esi/ share. No other room includes this header.
 *
 * From the lowest to the highest; each knows only those above it in this list (tests/check/order.py):
 *
 *   arena.c            memory that is freed together
 *   number.c, units.c, types.c  numbers, units and data types
 *   xml.c              a document, an element's parts, the first mistake kept
 *   read_dictionary.c  types and objects of a file
 *   read_device.c      the model of a device
 *   read.c             files, and which device of them
 *   single.c           a model without a file, as a file with one device
 *   image.c            EEPROM images, as files with one device
 *   found.c            the dictionary of a slave, added to its image
 *   lint.c             what of a file is not as files should be
 *   modules.c          slots, and the modules that they accept
 *   build.c            the list of objects while it grows; notes
 *   build_objects.c    objects of the dictionary
 *   build_modules.c    modules in their slots
 *   idents.c           lists of the idents of modules
 *   build_pdos.c       PDOs, what they map, which are assigned
 *   build_signals.c    signals from PDO entries and objects
 *   twin.c             the description and its behaviour
 *   behaviour.c        a drive by its objects of CiA 402
 *   network.c          EoE: an address that answers
 *   values.c           the values of a dictionary before the first write
 *   write_xml.c        elements and attributes, the first failure kept
 *   write_dictionary.c  data types and objects
 *   write_device.c     a device
 *   write.c            a file
 *
 * Reading goes on after a mistake with zeros and empty texts, so that no reader needs an error path of its own; whoever
 * began asks ::ect_esi_xml_t::failed at the end. Building goes on after a failure likewise (::ect_build_t::failure).
 */
#ifndef ECT_ESI_INTERNAL_H
#define ECT_ESI_INTERNAL_H

#include <libxml/tree.h>
#include <libxml/xmlwriter.h>

#include "esi/arena.h"
#include "esi/modules.h"
#include "esi/number.h"
#include "esi/pen.h"
#include "esi/single.h"
#include "esi/twin.h"
#include "esi/types.h"
#include "esi/values.h"
#include "esi/write.h"
#include "esi/xml.h"
#include "seams/eoe.h"
#include "seams/standard.h"
#include "wire/assert.h"

/* --- reading ----------------------------------------------------------------------------------------------------- */

/** An object of a slave's dictionary, in the order of ect_esi_dictionary_t::objects. */
typedef struct ect_esi_found {
    bool described;
    uint8_t code;
} ect_esi_found_t;

/** An open file. */
struct ect_esi {
    ect_arena_t arena;
    xmlDocPtr document;
    const char *file;
    const xmlNode *root;
    ect_esi_head_t *heads;
    const xmlNode **nodes; /**< of the heads */
    size_t count;
    ect_esi_found_t *found;   /**< by ::ect_esi_found_object; NULL: no dictionary was read */
    ect_esi_device_t *device; /**< of an EEPROM image; NULL: of a document, read by each ::ect_esi_select */
};

/** @param root  the file's EtherCATInfo; @param node  the `<Device>` */
ect_esi_device_t *ect_esi_read_device(ect_esi_xml_t *xml, const xmlNode *root, const xmlNode *node);

/** @param profile  `<Profile>` or NULL: then the dictionary is empty; @param[out] dictionary appended to */
void ect_esi_read_dictionary(ect_esi_xml_t *xml, const xmlNode *profile, ect_esi_dictionary_t *dictionary);

/* --- building ---------------------------------------------------------------------------------------------------- */

/** An entry while it is built. */
typedef struct ect_build_entry {
    uint8_t subindex;
    uint16_t data_type;
    uint16_t bits;
    uint16_t access;
    const char *name;
    ect_esi_bytes_t initial; /**< as on the wire; shorter than the entry: the rest is zero */
    ect_esi_number_t minimum, maximum;
    uint16_t unit; /* as in ect_detail_t */
    uint8_t per;
    size_t offset; /**< in the instance, once it is laid out */
    bool identity; /**< its data is a member of ect_standard_t at `offset`: 1018h, 1001h */
} ect_build_entry_t;

/** An object while it is built; its entries in any order. */
typedef struct ect_build_object {
    uint16_t index;
    uint16_t code;
    const char *name;
    ect_build_entry_t *entries;
    size_t count;
    bool complete; /**< from the dictionary: sub-index 0 is among the entries */
    size_t first;  /**< entries of the objects before it, once they are sorted */
} ect_build_object_t;

/** A PDO that takes part: the device's, or a module's in its slot. */
typedef struct ect_build_pdo {
    const ect_esi_pdo_t *model;
    uint16_t index; /**< moved with the slot */
    uint32_t pdo_shift;
    uint32_t index_shift;
    bool assigned; /**< to a SyncManager with process data, by default */
    bool usable;
    bool on_virtual; /**< of a virtual SyncManager: a master reaches registers in its place */
    size_t place; /**< in its assignment: those that exclude each other share one, the position of the first of them */
} ect_build_pdo_t;

/** Notes with one format. */
typedef struct ect_build_note_kind {
    const char *format;
    size_t repeated; /**< notes of that kind after the first */
} ect_build_note_kind_t;

/** The whole thing. */
typedef struct ect_build {
    ect_arena_t *arena;
    const ect_esi_device_t *model;
    ect_build_object_t *objects; /**< ascending once ::ect_build_sort was called */
    size_t object_count;
    ect_build_pdo_t *pdos;
    size_t pdo_count;
    uint32_t *idents; /**< of the modules in the slots, 0: an empty slot */
    size_t ident_count;
    const char **notes; /**< what is not represented, a line each */
    ect_build_note_kind_t *note_kinds;
    size_t note_count;
    size_t entry_count;  /**< entries added to all objects */
    uint32_t *positions; /**< of each index: its position in `objects` plus 1, 0 none; NULL before the first object */
    const char *failure; /**< why it cannot be built, NULL while it can */
    ect_eoe_t *network;  /**< the twin's EoE, NULL: none */
} ect_build_t;

/**
 * Reports to the user that something of the file is not represented. A second note of the same kind, which is one with
 * the same format, is counted: ::ect_build_count_notes.
 */
__attribute__((format(printf, 2, 3))) void ect_build_note(ect_build_t *build, const char *format, ...);

/** Adds to the first note of each kind how many followed it. Once, after the last note. */
void ect_build_count_notes(ect_build_t *build);

/** Room for a type's name, and for other texts, in a description. */
enum { ECT_BUILD_NAME = 40, ECT_BUILD_TEXT = 255 };

/** @return the text as a description has texts: visible characters of ISO 646, at most `longest`; umlauts are spelt out
 */
const char *ect_build_text(ect_build_t *build, const char *text, size_t longest);

/** @return a letter in lower case, or a digit, in any locale; 0: it is neither of ISO 646 */
char ect_build_plain(char c);

/** Gives up, for a reason that is kept unless there was one before. */
__attribute__((format(printf, 2, 3))) void ect_build_fail(ect_build_t *build, const char *format, ...);

/** @return the object of that index, or NULL */
ect_build_object_t *ect_build_find(const ect_build_t *build, uint16_t index);

/** @return a new object without entries; the caller has made sure that there is none of that index */
ect_build_object_t *ect_build_object(ect_build_t *build, uint16_t index, uint16_t code, const char *name);

/** @return the entry of that sub-index, or NULL */
ect_build_entry_t *ect_build_entry(const ect_build_object_t *object, uint8_t subindex);

/** @return a new entry; the caller has made sure that there is none of that sub-index */
ect_build_entry_t *ect_build_add(ect_build_t *build, ect_build_object_t *object, uint8_t subindex, uint16_t data_type,
                                 uint32_t bits, uint16_t access, const char *name);

/** Removes the last object, which no other object refers to yet. */
void ect_build_drop_last(ect_build_t *build);

/** Gives an entry a number of 1 to 8 bytes as its default. */
void ect_build_initial(ect_build_t *build, ect_build_entry_t *entry, uint64_t value);

/** @param[out] minimum, maximum  the range of an integer entry. @return false: it is none, the range is unchanged */
bool ect_build_range(const ect_build_entry_t *entry, int64_t *minimum, int64_t *maximum);

/** @return true for a data type of signed integers */
bool ect_build_is_signed(uint16_t data_type);

/** @return an entry's default as a number, its first 8 bytes */
uint64_t ect_build_number(const ect_build_entry_t *entry);

/**
 * Makes a record of numbers: sub-index 0 with their count, and `capacity` elements of which `count` have values.
 * An object of that index that was there is replaced, but for its name if `name` is empty.
 */
ect_build_object_t *ect_build_numbers(ect_build_t *build, uint16_t index, const char *name, const char *element,
                                      uint16_t data_type, uint16_t access, const uint32_t *values, size_t count,
                                      size_t capacity);

/** Brings objects and entries into ascending order and gives records a sub-index 0 that is right. */
void ect_build_sort(ect_build_t *build);

/** build_objects.c: adds the objects of a dictionary, moved by `shift` where they depend on a slot. */
void ect_build_objects(ect_build_t *build, const ect_esi_dictionary_t *dictionary, uint32_t shift);

/** build_objects.c: makes what start-up commands write exist and writable; `shift` as of ::ect_build_objects. */
void ect_build_inits(ect_build_t *build, const ect_esi_init_t *inits, size_t count, uint32_t shift);

/** build_modules.c. Adds the PDOs of the device and of the modules in its slots, and the modules' objects. */
void ect_build_modules(ect_build_t *build, const ect_module_choice_t *choices, size_t count);

/** idents.c: F030h and F050h, after all other objects; F000h too where the file wants idents downloaded. */
void ect_build_idents(ect_build_t *build);

/** idents.c: makes a device with F030h check it. Before a behaviour that has functions of its own. */
void ect_esi_idents_set(const ect_build_t *build, ect_device_t *device);

/** idents.c: as ect_device_t::state_change. @return ECT_AL_MODULE_IDENTS: the idents of F030h are not those of F050h */
uint16_t ect_esi_idents_state(void *instance, uint8_t from, uint8_t to);

/** idents.c: as ect_device_t::sdo_write. @return ECT_REASON_RANGE: the slot does not take that module */
ect_reason_t ect_esi_idents_write(void *instance, uint16_t index, uint8_t subindex, const void *data, uint16_t size);

/** build_pdos.c: the mapping objects, the objects that are mapped, the assignments. */
void ect_build_pdos(ect_build_t *build);

/** @return how many bits are assigned to a SyncManager */
uint32_t ect_build_assigned_bits(const ect_build_t *build, int sm);

/** @return the most that can be assigned to it: all PDOs that it may have */
uint32_t ect_build_largest_bits(const ect_build_t *build, int sm);

/** build_signals.c: fills the plant's signals; entries have their offsets. */
void ect_build_signals(ect_build_t *build, ect_plant_t *plant);

/**
 * network.c: EoE of a twin whose file has it.
 * @param device  with its SyncManagers
 * @return the protocol; NULL: the mailboxes of the file are too short for EoE
 */
const ect_protocol_t *ect_esi_network(ect_build_t *build, const ect_device_t *device);

/** network.c: places the state of EoE in the instance, from `at` on. @return the end */
size_t ect_esi_network_place(const ect_build_t *build, size_t at);

/** The axes of a twin that is a drive: behaviour.c. */
typedef struct ect_esi_drives ect_esi_drives_t;

struct ect_esi_twin {
    ect_arena_t arena;
    ect_esi_t *own; /* the file, when it is the twin's */
    const ect_esi_t *esi;
    bool chosen; /* the user named modules */
    ect_build_t build;
    ect_device_t device;
    ect_plant_t plant;
    ect_product_t product;
    ect_esi_drives_t *drives; /* NULL: a shell */
};

/* --- writing ----------------------------------------------------------------------------------------------------- */

/** Copies an element of a file with all that is in it. */
void ect_pen_copy(ect_pen_t *pen, const xmlNode *top);

/** Copies the children of an element of a file that have that name; NULL: all children. */
void ect_pen_copy_children(ect_pen_t *pen, const xmlNode *parent, const char *name);

/** @return the `<Device>` of the file that a part comes from; NULL: it comes from none */
const xmlNode *ect_pen_source(const ect_esi_part_t *part);

/** `<Dictionary>` */
void ect_pen_dictionary(ect_pen_t *pen, const ect_device_t *device, const ect_identity_t *identity);

/** write_fields.c: name of the type with EnumInfo for an entry; NULL: its values have no names. */
const char *ect_pen_enum_type(ect_pen_t *pen, const ect_od_t *od, uint16_t index, uint8_t subindex);
/** `<DataType>` of all such types of the device. */
void ect_pen_enum_types(ect_pen_t *pen, const ect_od_t *od);
/** `<Comment>` with the named bits of an entry, if there are any. */
void ect_pen_bits(ect_pen_t *pen, uint16_t index, uint8_t subindex);

/** `<Device>`. @param slots  whether the slots of its file are copied */
void ect_pen_device(ect_pen_t *pen, const ect_esi_part_t *part, bool slots);

#endif
