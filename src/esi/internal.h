/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Declarations that the files of esi/ share. No other room includes this header.
 *
 * From the lowest to the highest; each file uses only files above it in this list (tests/check/order.py):
 *
 *   arena.c            memory freed together
 *   number.c, units.c, types.c  numbers, units and data types
 *   xml.c              documents and elements; the first mistake
 *   leaves.c           elements and attributes, as texts
 *   read_dictionary.c  types and objects of a file
 *   dictionary_file.c  a dictionary in a file of its own
 *   read_device.c      the model of a device
 *   read.c             files, and the selection of a device
 *   single.c           a model without a file, as a file with one device
 *   image.c            EEPROM images, as files with one device
 *   found.c            the dictionary of a slave, added to its image
 *   lint.c             violations of rules for files
 *   modules.c          slots, and the modules that they accept
 *   build.c            the growing list of objects; notes
 *   build_objects.c    objects of the dictionary
 *   pdo_groups.c       order and padding of the PDOs of modules
 *   build_idns.c       parameters of SoE drives
 *   build_modules.c    modules in their slots
 *   idents.c           lists of the idents of modules
 *   build_pdos.c       PDOs, mappings and assignments
 *   pdo_states.c       parameters of PDOs: exclusions, toggles
 *   profile.c          parts that every profile needs
 *   servo.c            SoE drives: the tables of the protocol
 *   build_signals.c    signals from PDO entries and objects
 *   inits.c            start-up commands of the description
 *   change.c           modules that change while the twin runs
 *   network.c          EoE: an IP host; AoE
 *   reported.c             SDO information that differs from the dictionary
 *   twin.c             the description and its behaviour
 *   rack.c             twins, with a description for each set of modules
 *   dialect.c          the words of SoE drives over axes of CiA 402
 *   encoders.c         encoders with objects of CiA 406
 *   measuring.c        measuring devices with objects of CiA 404
 *   homing.c           the homing procedure of SoE drives
 *   reports.c          notifications and emergencies of SoE drives
 *   behaviour.c        drives with objects of CiA 402, or IDNs
 *   values.c           the values of a dictionary before the first write
 *   write_xml.c        elements and attributes; the first failure
 *   write_fields.c     names of values and bits
 *   write_dictionary.c  data types and objects
 *   write_slots.c      slots
 *   write_device.c     a device
 *   write_modules.c    modules
 *   write.c            a file
 *
 * After a mistake, reading continues with zeros and empty texts, so that readers need no error paths; the caller of the
 * first reader checks ::ect_esi_xml_t::failed at the end. Building continues likewise (::ect_build_t::failure).
 */
#ifndef ECT_ESI_INTERNAL_H
#define ECT_ESI_INTERNAL_H

#include <libxml/tree.h>
#include <libxml/xmlwriter.h>

#include "esi/arena.h"
#include "esi/modules.h"
#include "esi/number.h"
#include "esi/single.h"
#include "esi/twin.h"
#include "esi/types.h"
#include "esi/values.h"
#include "esi/write.h"
#include "esi/xml.h"
#include "esi/xml_writer.h"
#include "profiles/cia402/drive.h"
#include "seams/aoe.h"
#include "seams/eoe.h"
#include "seams/soe.h"
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
    const char *folder; /**< of the file, "" or with '/' at its end; NULL: from memory */
    const xmlNode *root;
    ect_esi_head_t *heads;
    const xmlNode **nodes; /**< of the heads */
    size_t count;
    ect_esi_found_t *found;   /**< from ::ect_esi_found_object; NULL: no dictionary read */
    ect_esi_device_t *device; /**< of an EEPROM image; NULL: a document, read by each ::ect_esi_select */
};

/** @param root  the file's EtherCATInfo; @param node  the `<Device>` */
ect_esi_device_t *ect_esi_read_device(ect_esi_xml_t *xml, const xmlNode *root, const xmlNode *node);

/** @param profile  `<Profile>`; NULL: an empty dictionary; @param[out] dictionary  gets types and objects appended */
void ect_esi_read_dictionary(ect_esi_xml_t *xml, const xmlNode *profile, ect_esi_dictionary_t *dictionary);

/** Reads the dictionary of a profile, its own or that of its `<DictionaryFile>`, into that of CoE or of SoE. */
void ect_esi_read_profile(ect_esi_xml_t *xml, const xmlNode *profile, ect_esi_device_t *device);

/** @param node  an index, may be NULL. @return ECT_ESI_BY_SLOT, ECT_ESI_BY_GROUP, from its attributes */
uint8_t ect_esi_moves(ect_esi_xml_t *xml, const xmlNode *node);

/* --- building ---------------------------------------------------------------------------------------------------- */

/** An entry under construction. */
typedef struct ect_build_entry {
    uint8_t subindex;
    uint16_t data_type;
    uint16_t bits;
    uint16_t access;
    const char *name;
    ect_esi_bytes_t initial; /**< little-endian; zeros follow up to the length of the entry */
    ect_esi_number_t minimum, maximum;
    uint16_t unit; /* as in ect_detail_t */
    uint8_t per;
    size_t offset; /**< in the instance, after lay_out() */
    bool identity; /**< the data are a member of ect_standard_t, at `offset`: 1018h, 1001h */
    bool constant; /**< no data: an element of a mapping that never changes */
    ect_esi_number_t reported_access, reported_bits; /**< as in ect_esi_flags_t */
} ect_build_entry_t;

/** An object under construction; entries in any order. */
typedef struct ect_build_object {
    uint16_t index;
    uint16_t code;
    const char *name;
    ect_build_entry_t *entries;
    size_t count;
    bool complete;   /**< from the dictionary: sub-index 0 is among the entries */
    uint32_t module; /**< ident of the module that contains the object; 0: the device */
    size_t first;    /**< number of entries of the preceding objects, after sorting */
} ect_build_object_t;

/** Increments of the indices of a module at its slot; all 0 for the device itself. */
typedef struct ect_build_steps {
    uint32_t slot_index, slot_pdo;   /**< with ECT_ESI_BY_SLOT: objects and entries; PDOs */
    uint32_t group_index, group_pdo; /**< with ECT_ESI_BY_GROUP, likewise */
} ect_build_steps_t;

/** Steps of the device itself. */
extern const ect_build_steps_t ect_build_device;

/** A PDO of the device, or of a module in a slot. */
typedef struct ect_build_pdo {
    const ect_esi_pdo_t *model;
    uint16_t index;                 /**< shifted by the slot */
    const ect_build_steps_t *steps; /**< of the place */
    uint32_t module;                /**< ident of the module that brings it, 0: the device */
    uint32_t group;                 /**< of PDOs, from 1; 0: none */
    bool assigned;                  /**< to a SyncManager with process data, by default */
    bool usable;
    bool on_virtual;  /**< of a virtual SyncManager: the master accesses registers instead */
    bool is_telegram; /**< of a SoE drive: its entries are IDNs, its number is that of the model */
    uint8_t drive;    /**< with is_telegram */
    size_t place; /**< place in the assignment; PDOs that exclude each other have the same place, that of the first */
} ect_build_pdo_t;

/** A parameter of a SoE drive under construction. */
typedef struct ect_build_idn {
    uint8_t drive;
    bool cyclic;       /**< in a telegram by default */
    uint16_t entry;    /**< index of the entry in the dictionary with the same memory; 0: none */
    ect_soe_idn_t row; /**< its offset after ::ect_esi_servo_place */
} ect_build_idn_t;

/** Limit of values in a telegram after control or status word. */
enum { ECT_ESI_VALUES = 64 };

/** The SoE drives of a device. */
typedef struct ect_build_soe {
    uint8_t drives;
    ect_build_idn_t *idns; /**< sorted by drive and IDN after ::ect_build_idns */
    size_t count;
    uint32_t *positions[ECT_SOE_DRIVES];               /**< by IDN: position in `idns` + 1; 0: none */
    const ect_esi_pdo_t *telegrams[ECT_SOE_DRIVES][2]; /**< MDT, AT, that S-0-0024, S-0-0016 change; NULL: none */
    ect_soe_t servo;
    bool served; /**< the mailboxes have room for SoE */
} ect_build_soe_t;

/** Notes with the same format. */
typedef struct ect_build_note_kind {
    const char *format;
    size_t repeated; /**< number of further notes of this kind */
} ect_build_note_kind_t;

/** The first bytes of an instance. */
typedef struct ect_esi_instance {
    ect_standard_t standard;
    uint8_t hold; /**< toggles keep their value */
    uint8_t read; /**< the master has read the inputs since the last change of the toggles */
} ect_esi_instance_t;

/** A description under construction. */
typedef struct ect_build {
    ect_arena_t *arena;
    const ect_esi_device_t *model;
    ect_build_object_t *objects; /**< sorted by ::ect_build_sort */
    size_t object_count;
    ect_build_pdo_t *pdos;
    size_t pdo_count;
    uint32_t *idents; /**< of the modules in the slots, 0: an empty slot */
    size_t ident_count;
    uint32_t module;           /**< whose objects are being added, 0: the device's */
    uint32_t pdo_group;        /**< of the PDOs that are being added */
    struct ect_esi_rack *rack; /**< the modules can change; NULL: they cannot */
    const char **notes;        /**< features of the file that are not represented, one line each */
    ect_build_note_kind_t *note_kinds;
    size_t note_count;
    size_t entry_count;  /**< entries added to all objects */
    uint32_t *positions; /**< by index: position in `objects` + 1; 0: none; NULL before the first object */
    const char *failure; /**< reason of the first failure; NULL: none */
    ect_eoe_t *network;  /**< the twin's EoE, NULL: none */
    size_t *toggles;     /**< TxPDO toggles: offsets in the instance */
    size_t toggle_count;
    ect_aoe_t *ads;       /**< the twin's AoE, NULL: none */
    ect_build_soe_t *soe; /**< the twin's SoE drives, NULL: none */
    size_t start;         /**< of the data of protocols and entries in the instance */
} ect_build_t;

/**
 * Adds a note for the user on a feature of the file that is not represented. Further notes with the same format are
 * only counted: ::ect_build_count_notes.
 */
__attribute__((format(printf, 2, 3))) void ect_build_note(ect_build_t *build, const char *format, ...);

/** Adds the number of further notes to the first note of each kind. Call it once, after the last note. */
void ect_build_count_notes(ect_build_t *build);

/** Room for a type's name, and for other texts, in a description. */
enum { ECT_BUILD_NAME = 40, ECT_BUILD_TEXT = 255 };

/**
 * @return the text in the form of a description: visible characters of ISO 646, at most `longest`; umlauts are spelt
 * out
 */
const char *ect_build_text(ect_build_t *build, const char *text, size_t longest);

/** @return a letter in lower case, or a digit, in any locale; 0: another character than a letter or digit of ISO 646 */
char ect_build_plain(char c);

/** Sets the reason of failure, unless one is already set. */
__attribute__((format(printf, 2, 3))) void ect_build_fail(ect_build_t *build, const char *format, ...);

/** @return the object of that index, or NULL */
ect_build_object_t *ect_build_find(const ect_build_t *build, uint16_t index);

/** @return a new object without entries; there must be none with this index */
ect_build_object_t *ect_build_object(ect_build_t *build, uint16_t index, uint16_t code, const char *name);

/** @return the entry with a sub-index; NULL: none */
ect_build_entry_t *ect_build_entry(const ect_build_object_t *object, uint8_t subindex);

/** @return a new entry; there must be none with this sub-index */
ect_build_entry_t *ect_build_add(ect_build_t *build, ect_build_object_t *object, uint8_t subindex, uint16_t data_type,
                                 uint32_t bits, uint16_t access, const char *name);

/** Removes the last object, to which no other object must refer. */
void ect_build_drop_last(ect_build_t *build);

/** Sets the default of an entry of 1 to 8 bytes. */
void ect_build_initial(ect_build_t *build, ect_build_entry_t *entry, uint64_t value);

/** @param[out] minimum, maximum  the range of an integer entry. @return false: not an integer, range unchanged */
bool ect_build_range(const ect_build_entry_t *entry, int64_t *minimum, int64_t *maximum);

/** @return true for a data type of signed integers */
bool ect_build_is_signed(uint16_t data_type);

/** @return the first 8 bytes of an entry's default as a number */
uint64_t ect_build_number(const ect_build_entry_t *entry);

/**
 * Makes a record of numbers: sub-index 0 with their count, and `capacity` elements of which `count` have values.
 * Replaces an existing object with this index, but keeps its name if `name` is empty.
 */
ect_build_object_t *ect_build_numbers(ect_build_t *build, uint16_t index, const char *name, const char *element,
                                      uint16_t data_type, uint16_t access, const uint32_t *values, size_t count,
                                      size_t capacity);

/** Sorts objects and entries, and sets sub-index 0 of records. */
void ect_build_sort(ect_build_t *build);

/** @return the index of an object or of a PDO's entry at the slot. @param moves  ECT_ESI_BY_... */
uint16_t ect_build_index(uint16_t index, uint8_t moves, const ect_build_steps_t *steps);

/** @return the index of a PDO at the slot */
uint16_t ect_build_pdo_index(uint16_t index, uint8_t moves, const ect_build_steps_t *steps);

/** build_objects.c: adds the objects of a dictionary with their indices at the slot. */
void ect_build_objects(ect_build_t *build, const ect_esi_dictionary_t *dictionary, const ect_build_steps_t *steps);

/** build_objects.c. @return ECT_ACCESS_... of an entry with flags of its own and of its object */
uint16_t ect_build_access(const ect_esi_flags_t *own, const ect_esi_flags_t *object);

/** build_objects.c: adds missing entries that start-up commands write, and makes them writable. */
void ect_build_inits(ect_build_t *build, const ect_esi_init_t *inits, size_t count, const ect_build_steps_t *steps);

/**
 * build_idns.c: adds the parameters of SoE drives, and entries of the dictionary for parameters that telegrams may
 * contain. Call it after ect_build_objects() of the device, before its PDOs. No effect without SoE.
 */
void ect_build_idns(ect_build_t *build);

/** build_idns.c. @return the parameter of a drive; NULL: none */
ect_build_idn_t *ect_build_idn(const ect_build_t *build, uint8_t drive, uint16_t idn);

/** build_idns.c. @return "S-0-0134" */
const char *ect_build_idn_text(ect_build_t *build, uint16_t idn);

/** build_idns.c. @return whether a PDO of the device is a telegram of a SoE drive, and the number of that drive */
bool ect_build_is_telegram(const ect_build_t *build, const ect_esi_pdo_t *pdo);
uint8_t ect_build_drive_of(const ect_build_t *build, const ect_esi_pdo_t *pdo);

/**
 * build_idns.c. @return the index, at the slot, of the entry in the dictionary that an entry of a PDO maps; 0: a gap
 */
uint16_t ect_build_mapped(const ect_build_t *build, const ect_build_pdo_t *pdo, const ect_esi_entry_t *entry);

/**
 * servo.c: SoE of a twin, if the file has SoE.
 * @param device  with its SyncManagers
 * @return the protocol; NULL: the mailboxes of the file are too short for SoE
 */
const ect_protocol_t *ect_esi_servo(ect_build_t *build, const ect_device_t *device);

/** servo.c: places the parameters of the drives in the instance, from `at` on, and makes their tables. @return the end
 */
size_t ect_esi_servo_place(ect_build_t *build, size_t at);

/** servo.c: as ect_device_t::init: the defaults of all parameters. */
void ect_esi_servo_init(void *instance, const ect_host_t *host, uint64_t now_ns);

/** build_modules.c. Adds the PDOs of the device and of the modules in its slots, and the modules' objects. */
void ect_build_modules(ect_build_t *build, const ect_module_choice_t *choices, size_t count);

/** pdo_groups.c: makes the PDOs of each group adjacent, followed by a padding PDO. Call it after the last PDO. */
void ect_build_pdo_groups(ect_build_t *build);

/** idents.c: adds F030h and F050h, after all other objects; F000h too if the file requires the download of idents. */
void ect_build_idents(ect_build_t *build);

/** pdo_states.c: sets the lists of excluded PDOs, 14xxh:06 and 18xxh:06, that have no values in the file. */
void ect_build_pdo_states(ect_build_t *build);

/** pdo_states.c. @return the existing PDOs that a PDO excludes, ended by 0; NULL: none */
const uint16_t *ect_build_excludes(const ect_build_t *build, const ect_build_pdo_t *pdo);

/** pdo_states.c: makes the mapped TxPDO toggles 18xxh:09 change with the inputs. Offsets must be set. */
void ect_build_toggles(ect_build_t *build, ect_device_t *device);

/** pdo_states.c. @return whether an entry is a toggle, after ::ect_build_toggles */
bool ect_build_is_toggle(const ect_build_t *build, const ect_build_entry_t *entry);

/** pdo_states.c: the signal of a device with toggles. */
extern const ect_signal_t ect_build_toggle_signals[1];

/** idents.c: the download revision F081h:1 is the revision number, unless the file has another default. */
void ect_build_revision(ect_build_t *build);

/** build.c: adds a service to those that a device names. */
void ect_build_service(ect_build_t *build, ect_device_t *device, const ect_service_t *service);

/** build_modules.c: adds the PDOs, objects and start-up commands of one module; `steps` outlive the build. */
void ect_build_module(ect_build_t *build, const ect_esi_module_t *module, const ect_build_steps_t *steps);

/** inits.c: sets the start-up commands: SDOs of CoE, mails of AoE, EoE and SoE. A note for each unknown transition. */
void ect_esi_inits_set(ect_build_t *build, ect_device_t *device);

/** idents.c: makes a device with F030h check the list. Call it before a behaviour with its own functions. */
void ect_esi_idents_set(const ect_build_t *build, ect_device_t *device);

/** idents.c. @return whether the lists configured by a master are empty, or equal to the detected ones. */
bool ect_esi_idents_fit(const ect_od_t *od);

/** Lists of a modular device, one element for each slot. */
enum {
    ECT_ESI_PROFILES = 0xF010,
    ECT_ESI_ADDRESSES = 0xF020,
    ECT_ESI_IDENTS = 0xF030,
    ECT_ESI_ADDRESSES_DETECTED = 0xF040,
    ECT_ESI_IDENTS_DETECTED = 0xF050
};

/** idents.c. @return element `subindex` of a list; 0: none. */
uint32_t ect_esi_list_at(const ect_od_t *od, uint16_t index, uint8_t subindex);

/** idents.c: as ect_device_t::state_change. @return ECT_AL_MODULE_IDENTS: the idents of F030h are not those of F050h */
uint16_t ect_esi_idents_state(void *instance, uint8_t from, uint8_t to);

/** idents.c: as ect_device_t::sdo_write. @return ECT_REASON_RANGE: the slot does not accept this module */
ect_reason_t ect_esi_idents_write(void *instance, uint16_t index, uint8_t subindex, const void *data, uint16_t size);

/** build_pdos.c: adds mapping objects, mapped objects and assignments. */
void ect_build_pdos(ect_build_t *build);

/** @return number of bits assigned to a SyncManager */
uint32_t ect_build_assigned_bits(const ect_build_t *build, int sm);

/** @return largest number of bits that can be assigned to a SyncManager */
uint32_t ect_build_largest_bits(const ect_build_t *build, int sm);

/** build_signals.c: sets the plant's signals. Entries must have their offsets. */
void ect_build_signals(ect_build_t *build, ect_plant_t *plant);

/** build_signals.c. @return the default of an entry; 0: none, or no such entry. */
uint32_t ect_build_default(const ect_build_t *build, uint16_t index, uint8_t subindex);

/** build_signals.c. @return the name of a unit of ETG.1004; NULL: none. */
const char *ect_build_unit_name(ect_build_t *build, uint32_t unit);

/**
 * network.c: EoE of a twin, if the file has EoE.
 * @param device  with its SyncManagers
 * @return the protocol; NULL: the mailboxes of the file are too short for EoE
 */
const ect_protocol_t *ect_esi_network(ect_build_t *build, const ect_device_t *device);

/** network.c: places the state of EoE in the instance, from `at` on. @return the end */
size_t ect_esi_network_place(const ect_build_t *build, size_t at);

/**
 * network.c: AoE of a twin, if the file has AoE. Its NetId is at ect_build_t::start, in each set of modules.
 * @param device  with its SyncManagers
 * @return the protocol; NULL: the mailboxes of the file are too short for AoE
 */
const ect_protocol_t *ect_esi_ads(ect_build_t *build, const ect_device_t *device);

/** network.c: bytes of the NetId in the instance; 0: the file has no AoE. */
size_t ect_esi_ads_size(const ect_esi_device_t *model);

/* --- modules that change ----------------------------------------------------------------------------------------- */

/** Place of an entry in the instance, the same in each description that has it. */
typedef struct ect_esi_place {
    struct ect_esi_place *next; /**< of the same index */
    uint32_t module;            /**< that brings the entry */
    uint16_t data_type, bits;
    uint8_t subindex;
    size_t offset;
} ect_esi_place_t;

/** Limit of sets of modules of a device during a run of the program. */
enum { ECT_ESI_SETS = 64 };

/**
 * A device whose modules change: a twin for each set of modules, all over the same instance. An entry of the same
 * module has the same place in all of them, so that a reference to a signal never reaches the data of another.
 */
typedef struct ect_esi_rack {
    const ect_esi_t *esi;
    const ect_esi_device_t *model;
    ect_arena_t *arena;
    ect_esi_place_t **places; /**< by index */
    size_t used;              /**< bytes of the instance */
    size_t size;              /**< of the instance; 0 while the first set is built */
    size_t room;              /**< for the entries of sets after the first */
    ect_growth_t growth;
    unsigned int slots;
    struct {
        uint32_t *idents;
        struct ect_esi_twin *twin; /**< NULL: this set cannot be built */
    } sets[ECT_ESI_SETS];
    size_t set_count;
    struct ect_esi_twin *(*find)(struct ect_esi_rack *rack, const uint32_t *idents); /**< rack.c */
} ect_esi_rack_t;

/** change.c: bytes at the beginning of the instance of a device whose modules change. */
size_t ect_esi_change_size(const ect_esi_rack_t *rack);

/** change.c: signals for the modules, before those of process data. */
void ect_esi_change_signals(ect_build_t *build, ect_plant_t *plant);

/**
 * reported.c. Sets what SDO information reports: rights and lengths of the file where they differ from those of the
 * twin. Call it after the objects and protocols of the device are set.
 */
void ect_esi_reported_set(const ect_build_t *build, ect_device_t *device);

/** change.c: the functions of device and plant. */
void ect_esi_change_set(const ect_build_t *build, ect_device_t *device, ect_plant_t *plant);

/** twin.c: a twin with one set of modules. @param rack  NULL: its modules do not change; else as ::ect_esi_twin_of */
struct ect_esi_twin *ect_esi_twin_assemble(const ect_esi_t *esi, const ect_esi_device_t *model,
                                           const ect_module_choice_t *modules, size_t module_count,
                                           ect_esi_rack_t *rack, char *text, size_t room);

/** twin.c: frees one set. NULL is allowed. */
void ect_esi_twin_drop(struct ect_esi_twin *twin);

/** The axes of a twin that is a drive: behaviour.c. */
typedef struct ect_esi_drives ect_esi_drives_t;

/** The encoders of a twin: encoders.c. */
typedef struct ect_esi_encoders ect_esi_encoders_t;

/** The measuring inputs of a twin: measuring.c. */
typedef struct ect_esi_measuring ect_esi_measuring_t;

struct ect_esi_twin {
    ect_arena_t arena;
    ect_arena_t racks; /* of the first set of modules: the rack */
    ect_esi_t *own;    /* the file, when it is the twin's */
    const ect_esi_t *esi;
    bool chosen; /* the user has selected modules */
    ect_build_t build;
    ect_device_t device;
    ect_plant_t plant;
    ect_product_t product;
    ect_esi_drives_t *drives;       /* NULL: no drive */
    ect_esi_encoders_t *encoders;   /* NULL: no encoder */
    ect_esi_measuring_t *measuring; /* NULL: no measuring device */
};

/** profile.c. @return a number in the wire form of an entry */
int64_t ect_esi_wire_number(const ect_link_t *link, const uint8_t *data, uint16_t size);
/** profile.c. @return false: an infinity or a NaN, in the wire form of an entry */
bool ect_esi_wire_finite(const ect_link_t *link, const uint8_t *data, uint16_t size);
/** profile.c. @return the next offset in an instance at which a structure may begin */
size_t ect_esi_aligned(size_t at);
/**
 * profile.c: the objects of a profile without behaviour, as " 6040 6200".
 * @param first      object of the profile
 * @param count      of its objects
 * @param simulated  @return whether the profile whose first object is 6000h has a behaviour for an object
 */
const char *ect_esi_objects_without(struct ect_esi_twin *twin, unsigned int first, unsigned int count,
                                    bool (*simulated)(uint16_t index));
/** profile.c: the note of a behaviour. @param rest  of ::ect_esi_objects_without */
void ect_esi_profile_note(struct ect_esi_twin *twin, const char *text, const char *rest);
/**
 * profile.c: adds the memory of a behaviour to the instance.
 * @param size          bytes that a power cycle clears, at `offset`
 * @param outside_size  bytes that outlast it, at `outside`
 */
void ect_esi_profile_place(struct ect_esi_twin *twin, size_t size, size_t outside_size, size_t *offset,
                           size_t *outside);
/**
 * profile.c: inserts the signals of a behaviour before those of the file, which may have the same name, and makes the
 * signals of entries written by the behaviour read-only.
 * @param writes  @return whether the behaviour writes the value at an offset of the instance
 */
void ect_esi_profile_signals(struct ect_esi_twin *twin, const ect_signal_group_t *groups, uint16_t count,
                             bool (*writes)(const struct ect_esi_twin *twin, uint32_t offset));

/** encoders.c. @return whether a twin is an encoder: by request, by its ProfileNo, or by its objects */
bool ect_esi_encoders_wanted(const struct ect_esi_twin *twin, ect_behaviour_t behaviour);
/** encoders.c: as ::ect_esi_twin_behave. */
bool ect_esi_encoders_set(struct ect_esi_twin *twin, ect_behaviour_t behaviour, char *text, size_t room);

/** measuring.c. @return whether a twin is a measuring device: by request, or by its ProfileNo */
bool ect_esi_measuring_wanted(const struct ect_esi_twin *twin, ect_behaviour_t behaviour);
/** measuring.c: as ::ect_esi_twin_behave. */
bool ect_esi_measuring_set(struct ect_esi_twin *twin, ect_behaviour_t behaviour, char *text, size_t room);

/** The words of a SoE drive in the form of an axis of CiA 402; in the instance. */
typedef struct ect_esi_words {
    uint16_t control, status;
    int8_t mode, shown;
    uint8_t reset;  /**< phase of a reset by S-0-0099 */
    uint8_t homing; /**< phase of a run by S-0-0148 */
    int8_t method;
    int32_t home;
} ect_esi_words_t;

enum { ECT_ESI_HOMING = 148 /**< S-0-0148 */ };

/** The connection of a SoE drive to its axis. */
typedef struct ect_esi_dialect {
    uint8_t drive;
    bool follows;                                           /**< bit 3 of S-0-0135 */
    size_t control, status;                                 /**< of S-0-0134, S-0-0135 in the instance */
    size_t words;                                           /**< of an ::ect_esi_words_t */
    ect_402_link_t modes[4];                                /**< S-0-0032 to S-0-0035 */
    ect_402_link_t class_1;                                 /**< S-0-0011 */
    bool homes;                                             /**< has S-0-0148, and the following members: */
    size_t homing;                                          /**< of the command S-0-0148 */
    ect_402_link_t parameter, distance, home_switch, homed; /**< S-0-0147, S-0-0052, S-0-0400, S-0-0403 */
} ect_esi_dialect_t;

/** dialect.c. @return whether a drive has S-0-0134 and S-0-0135 */
bool ect_esi_dialect_find(const ect_build_t *build, uint8_t drive, ect_esi_dialect_t *dialect);
/** dialect.c. @return the link to a number of a drive; 0 bytes: none. */
ect_402_link_t ect_esi_dialect_link(const ect_build_t *build, uint8_t drive, uint16_t idn);
/** dialect.c: sets the links of the axis, ECT_402_VALUE_COUNT. @param words  offset of the words in the instance */
void ect_esi_dialect_links(const ect_build_t *build, ect_esi_dialect_t *dialect, size_t words, ect_402_link_t *links);
/**
 * dialect.c. @return whether the drive writes the value at an offset of the instance, in addition to those of the links
 */
bool ect_esi_dialect_writes(const ect_esi_dialect_t *dialect, size_t offset);
/** dialect.c: converts S-0-0134 to the control word of the axis; due before ::ect_402_drive_outputs. */
void ect_esi_dialect_in(const ect_esi_dialect_t *dialect, void *instance, const ect_402_drive_t *d);
/** dialect.c: converts the state of the axis to S-0-0135; due after ::ect_402_drive_publish. */
void ect_esi_dialect_out(const ect_esi_dialect_t *dialect, void *instance, const ect_402_drive_t *d);
/** dialect.c: makes the next control word reset a fault. @param start  false: cancels the reset */
void ect_esi_dialect_reset(const ect_esi_dialect_t *dialect, void *instance, bool start);
/** dialect.c: follows a reset; due after a control word. @return whether the reset has ended */
bool ect_esi_dialect_ends(const ect_esi_dialect_t *dialect, void *instance);

/** homing.c. @return whether a drive has S-0-0148; on true the links of the dialect are set */
bool ect_esi_homing_find(const ect_build_t *build, ect_esi_dialect_t *dialect);
/** homing.c: sets the links of the axis to speed, acceleration, method and reference point. */
void ect_esi_homing_links(const ect_build_t *build, const ect_esi_dialect_t *dialect, ect_402_link_t *links);
/**
 * homing.c: starts S-0-0148. @param[out] runs false: the settings permit no run. @return ECT_SOE_OK, or the error code
 */
uint16_t ect_esi_homing_start(const ect_esi_dialect_t *dialect, void *instance, ect_402_drive_t *d, bool *runs);
/** homing.c: cancels a running S-0-0148. */
void ect_esi_homing_cancel(const ect_esi_dialect_t *dialect, void *instance);
/** homing.c: sets mode and control word of a run; due after ::ect_esi_dialect_in. */
void ect_esi_homing_in(const ect_esi_dialect_t *dialect, void *instance);
/**
 * homing.c: follows a run after a change of the axis by time or outputs. @return whether the run has ended, and its
 * success
 */
bool ect_esi_homing_ends(const ect_esi_dialect_t *dialect, void *instance, const ect_402_drive_t *d, bool *success);
/** homing.c: sets S-0-0400 and S-0-0403. */
void ect_esi_homing_out(const ect_esi_dialect_t *dialect, void *instance, const ect_402_drive_t *d);

/** The settings for unrequested mails of SoE drives, in the surroundings of the twin. */
typedef struct ect_esi_reports {
    uint8_t on;
} ect_esi_reports_t;

/** The host of a SoE drive, whose emergencies are those of SoE; in the instance. */
typedef struct ect_esi_reporter {
    ect_host_t host; /**< `emergency` alone */
    const ect_host_t *twin;
    const ect_soe_t *servo;
    void *instance;
    uint8_t drive;
} ect_esi_reporter_t;

/** reports.c: signals over ::ect_esi_reports_t. */
extern const ect_signal_t ect_esi_report_signals[];
extern const uint16_t ect_esi_report_signal_count;
/** reports.c: power-on of a drive. `reporter` must stay valid. @return the host of the drive */
const ect_host_t *ect_esi_reporter(ect_esi_reporter_t *reporter, const ect_soe_t *servo, void *instance, uint8_t drive,
                                   const ect_host_t *twin);
/** reports.c: applies the settings at power-on, or after a change by a user. */
void ect_esi_report(const ect_soe_t *servo, void *instance, const ect_esi_reports_t *reports);

/* --- writing ----------------------------------------------------------------------------------------------------- */

/** Copies an element of a file with its content. */
void ect_xml_copy(ect_xml_writer_t *xml, const xmlNode *top);

/** Copies the children with a name of an element of a file. @param name  NULL: all children */
void ect_xml_copy_children(ect_xml_writer_t *xml, const xmlNode *parent, const char *name);

/** @return the `<Device>` in the file of a part; NULL: the part is not from a file */
const xmlNode *ect_xml_source(const ect_esi_part_t *part);

/** Writes `<Dictionary>`. */
void ect_xml_dictionary(ect_xml_writer_t *xml, const ect_device_t *device, const ect_identity_t *identity);

/** write_fields.c: name of the type with EnumInfo for an entry; NULL: its values have no names. */
const char *ect_xml_enum_type(ect_xml_writer_t *xml, const ect_od_t *od, uint16_t index, uint8_t subindex);
/** Writes `<DataType>` for all types with EnumInfo of the device. */
void ect_xml_enum_types(ect_xml_writer_t *xml, const ect_od_t *od);
/** Writes `<Comment>` with the named bits of an entry, if there are any. */
void ect_xml_bits(ect_xml_writer_t *xml, uint16_t index, uint8_t subindex);

/** write_slots.c: writes `<Slots>` of a device whose file is not an ESI. */
void ect_xml_slots(ect_xml_writer_t *xml, const ect_esi_device_t *model);

/**
 * write_modules.c: writes a `<Module>` for each module of such a device. All its indices move with the slot.
 * @return false: a module cannot be built
 */
bool ect_xml_modules(ect_xml_writer_t *xml, const ect_esi_device_t *model);

/** Writes `<Device>`. @param slots  true: writes its slots, those of an ESI file as a copy */
void ect_xml_device(ect_xml_writer_t *xml, const ect_esi_part_t *part, bool slots);

#endif
