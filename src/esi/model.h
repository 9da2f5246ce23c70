/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Model: one device of an ESI file, as plain structures.
 *
 * esi/read.h makes a model from a file; esi/twin.h builds a running device from it, and `ectwin verify` compares it.
 * The model is not interpreted: defaults are those of the file, not derived ones. All memory belongs to the
 * ::ect_esi_t. Texts are UTF-8 and never NULL unless stated otherwise; of names in several languages, the model has the
 * English one (LcId 1033), or else the first.
 *
 * Clauses: ETG.2000 and its schema 1.17.
 */
#ifndef ECT_ESI_MODEL_H
#define ECT_ESI_MODEL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "seams/fields.h"

/** A value that may be absent. */
typedef struct ect_esi_number {
    bool given;
    uint8_t bytes; /**< 1 to 8: given as this number of unsigned bytes (`<MinData>`); 0: given as a number */
    int64_t value;
} ect_esi_number_t;

/** Little-endian bytes (`<Data>`, `<DefaultData>`, `<ConfigData>`). */
typedef struct ect_esi_bytes {
    const uint8_t *bytes; /**< NULL when absent */
    size_t length;
} ect_esi_bytes_t;

/** Flags of an index in a module: it moves with the module's place. */
enum {
    ECT_ESI_BY_SLOT = 1,  /**< `DependOnSlot`: with the slot */
    ECT_ESI_BY_GROUP = 2, /**< `DependOnSlotGroup`: with the group of the slot */
};

/** `<Entry>` of a PDO; index 0 is a gap. */
typedef struct ect_esi_entry {
    uint16_t index;
    uint8_t subindex;
    uint16_t bits;
    const char *name;
    const char *type; /**< `<DataType>`, "" when absent */
    uint8_t moves;    /**< ECT_ESI_BY_SLOT, ECT_ESI_BY_GROUP */
    int line;
} ect_esi_entry_t;

/** `<Exclude>` of a PDO: a PDO that cannot be assigned together with it. */
typedef struct ect_esi_exclude {
    uint16_t index;
    uint8_t moves; /**< ECT_ESI_BY_SLOT, ECT_ESI_BY_GROUP */
} ect_esi_exclude_t;

/** `<RxPdo>` or `<TxPdo>`. */
typedef struct ect_esi_pdo {
    uint16_t index;
    const char *name;
    bool tx;          /**< inputs: from the slave to the master */
    bool fixed;       /**< content cannot be changed */
    bool mandatory;   /**< always assigned */
    bool virtual_pdo; /**< maps registers, not a SyncManager */
    int sm;           /**< assigned by default to this SyncManager, -1 to none */
    uint16_t samples; /**< `OSFac`, 1 when absent */
    const ect_esi_exclude_t *exclude;
    size_t exclude_count;
    const ect_esi_entry_t *entries;
    size_t entry_count;
    uint8_t moves; /**< ECT_ESI_BY_SLOT, ECT_ESI_BY_GROUP */
    int line;
} ect_esi_pdo_t;

/** `<Sm>`; the array index is the number. */
typedef struct ect_esi_sm {
    const char *type; /**< "MBoxOut", "MBoxIn", "Outputs", "Inputs", "" … */
    uint16_t start;
    uint8_t control;
    ect_esi_number_t size;     /**< `DefaultSize` */
    uint16_t minimum, maximum; /**< 0 when absent */
    uint8_t flags; /**< bits 1 to 3 of `Enable`, with `OpOnly` (8) and `Virtual` (4): byte 6 of the SII's SyncM */
    bool virtual_sm;
    int line;
} ect_esi_sm_t;

/** `<InitCmd>` of CoE: a value that a master writes at a transition. */
typedef struct ect_esi_init {
    const char *transitions; /**< "PS", several separated by a blank */
    uint16_t index;
    uint8_t subindex;
    bool complete;
    bool adapts; /**< `AdaptAutomatically`: tools replace the data */
    ect_esi_bytes_t data;
    const char *comment; /**< "" when absent */
    uint8_t moves;       /**< ECT_ESI_BY_SLOT, ECT_ESI_BY_GROUP */
    bool disabled;       /**< `Disabled` of a network file */
    bool upload;         /**< a network file's command without `Data`: the master reads */
    int line;
} ect_esi_init_t;

/** `<InitCmd>` of AoE, EoE or SoE: a mail that a master sends at a transition. */
typedef struct ect_esi_mail {
    const char *transitions; /**< as ect_esi_init_t::transitions */
    const char *comment;     /**< "" when absent */
    uint8_t protocol;        /**< ECT_MAILBOX_TYPE_AOE, _EOE or _SOE */
    uint8_t type;            /**< of EoE: that of the mail; of SoE: ECT_INIT_READS, ECT_INIT_WRITES */
    uint8_t drive;           /**< of SoE: `Chn` */
    uint8_t elements;        /**< of SoE: bit 6 is the value */
    uint16_t idn;            /**< of SoE */
    bool disabled;           /**< `Disabled` of a network file */
    ect_esi_bytes_t data;
    int line;
} ect_esi_mail_t;

/** `<Sm>` with its PDOs, of an `<AlternativeSmMapping>` or an `<OpMode>`. */
typedef struct ect_esi_assignment {
    const char *name; /**< of the alternative or the mode */
    bool preset;      /**< `Default` of the alternative */
    unsigned int sm;
    const uint16_t *pdos;
    size_t pdo_count;
} ect_esi_assignment_t;

/** `<Category>` of the EEPROM. */
typedef struct ect_esi_category {
    uint16_t number;
    ect_esi_bytes_t data; /**< of `<Data>`, `<DataString>`, `<DataUINT>` (2 bytes) or `<DataUDINT>` (4 bytes) */
    int line;
} ect_esi_category_t;

/** `<OpMode>`. */
typedef struct ect_esi_dc {
    const char *name;
    const char *description;
    uint16_t assign_activate;
    int64_t cycle_sync0_ns, shift_sync0_ns, cycle_sync1_ns, shift_sync1_ns;
    int sync0_factor, sync1_factor;
} ect_esi_dc_t;

/** Rights and abilities of an entry of the dictionary, `<Flags>`. */
typedef struct ect_esi_flags {
    const char *access;   /**< "ro", "rw", "wo"; "" when absent */
    const char *read_in;  /**< `ReadRestrictions`, "" for none */
    const char *write_in; /**< `WriteRestrictions`: "PreOP", "PreOP_SafeOP", …, "" for none */
    const char *mapping;  /**< `<PdoMapping>`: "", "T", "R", "TR" … */
    const char *category;
    ect_esi_number_t attribute; /**< of an IDN, `<Attribute>` */
    bool backup;
    bool setting;
    ect_esi_number_t reported_access; /**< access rights of SDO information, `<Property>` SdoInfoAccess of a clone */
    ect_esi_number_t reported_bits;   /**< length of SDO information, `<Property>` SdoInfoBits of a clone */
} ect_esi_flags_t;

/** A type's or an object's default and limits. */
typedef struct ect_esi_info {
    ect_esi_bytes_t initial; /**< `DefaultData`, or `DefaultString`, or `DefaultValue` as 8 bytes little endian */
    bool initial_is_number;  /**< from `DefaultValue`: only as many bytes as the type has are valid */
    ect_esi_number_t minimum, maximum;
    uint32_t unit;       /**< ETG.1004, 0 when absent */
    const char *name;    /**< the sub-item's; "" for the object itself */
    const char *display; /**< `DisplayName`, "" when absent */
} ect_esi_info_t;

/** `<SubItem>` of a data type. */
typedef struct ect_esi_item {
    int subindex; /**< -1: absent, the item stands for the elements of an array */
    const char *name;
    const char *display; /**< `DisplayName`, "" when absent */
    const char *type;
    uint32_t bits;
    uint32_t offset;
    ect_esi_flags_t flags;
    ect_esi_info_t info;
    int line;
} ect_esi_item_t;

/** `<DataType>`. */
typedef struct ect_esi_type {
    const char *name;
    const char *base; /**< "" when absent */
    uint32_t bits;
    ect_esi_number_t first, elements; /**< of `<ArrayInfo>` */
    const ect_esi_item_t *items;
    size_t item_count;
    bool is_enum;
    int64_t lowest, highest; /**< of the enumeration */
} ect_esi_type_t;

/** `<Object>`. */
typedef struct ect_esi_object {
    uint16_t index;
    const char *name;
    const char *type;
    uint32_t bits;
    ect_esi_flags_t flags;
    ect_esi_info_t info;
    const ect_esi_info_t *items; /**< `<Info><SubItem>`: by name, or in order */
    size_t item_count;
    uint8_t moves; /**< ECT_ESI_BY_SLOT, ECT_ESI_BY_GROUP */
    int line;
} ect_esi_object_t;

/** `<Dictionary>`; empty when there is none. */
typedef struct ect_esi_dictionary {
    const ect_esi_type_t *types;
    const ect_esi_type_t *const *types_by_name; /**< ascending; equal names in the order of the file */
    size_t type_count;
    const ect_esi_object_t *objects;
    size_t object_count;
} ect_esi_dictionary_t;

/** `<Slot>` and the modules that it accepts. */
typedef struct ect_esi_slot {
    const char *name;
    unsigned int instances_min, instances_max;
    uint32_t pdo_increment, index_increment; /**< for each slot between the module and the first slot */
    bool own_increments; /**< counted from this slot's first instance; false: from the device's first slot */
    uint32_t group;      /**< `SlotGroup`, 0 when absent */
    uint32_t group_pdo_increment, group_index_increment; /**< times `group` */
    const uint32_t *idents;                              /**< `<ModuleIdent>` */
    size_t ident_count;
    uint32_t preset;            /**< the ident with `Default`, 0 none */
    const char *const *classes; /**< `<ModuleClass>` */
    size_t class_count;
} ect_esi_slot_t;

/** `<ModulePdoGroup>`: modules whose PDOs follow one another. */
typedef struct ect_esi_pdo_group {
    uint8_t alignment; /**< bytes, up to which the PDO of the direction fills the group; 0: not filled */
    uint16_t rx, tx;   /**< indices of these PDOs; 0: none */
} ect_esi_pdo_group_t;

/** `<Module>`. */
typedef struct ect_esi_module {
    uint32_t ident;
    const char *type;
    const char *module_class;
    uint32_t profile; /**< `<ProfileNo>`, the first, and in the upper half its `<AddInfo>`; 0 none */
    const char *name;
    const ect_esi_pdo_t *pdos;
    size_t pdo_count;
    ect_esi_dictionary_t dictionary;
    const ect_esi_init_t *inits;
    size_t init_count;
    uint32_t pdo_group; /**< `ModulePdoGroup` + 1: its number among those of the device, from 1; 0: none */
    int line;
} ect_esi_module_t;

/** Mailbox protocols and abilities, `<Mailbox>`. */
typedef struct ect_esi_mailbox {
    bool given;
    bool data_link_layer;
    bool aoe, eoe, coe, foe, soe, voe;
    uint8_t soe_channels; /**< `ChannelCount`, 0 when absent */
    bool soe_follows;     /**< `DriveFollowsBit3Support`: bit 3 of S-0-0135 */
    const ect_esi_mail_t *mails;
    size_t mail_count;
    bool sdo_info, pdo_assign, pdo_config, pdo_upload, complete_access;
    const ect_esi_init_t *inits;
    size_t init_count;
} ect_esi_mailbox_t;

/** A device of an ESI file. */
typedef struct ect_esi_device {
    uint32_t vendor_id;
    const char *vendor_name;
    const char *type;
    uint32_t product_code;
    uint32_t revision;
    const char *name;
    const char *group_type;
    const char *group_name; /**< "" when the group is not in the file */
    const char *physics;
    size_t place;              /**< among the devices of its file, from 0 */
    const struct ect_esi *esi; /**< the file, owner of the model */
    int line;

    uint32_t preop_ms, safeop_op_ms, back_to_init_ms, back_to_safeop_ms; /**< 0 when absent */
    uint32_t request_ms, response_ms;
    int ebus_current_ma;
    bool identification_134, alias_supported;
    bool lrd_lwr; /**< `UseLrdLwr`: LRW is not supported */
    ect_esi_number_t identification_ado;
    uint32_t profile; /**< value of 1000h: the first `<ProfileNo>`, and `<AddInfo>` in the upper half; 0: none */

    const char *const *fmmus; /**< "Outputs", "Inputs", "MBoxState", … */
    size_t fmmu_count;
    const ect_esi_sm_t *sms;
    size_t sm_count;
    const ect_esi_pdo_t *pdos; /**< in the order of the file, outputs first */
    size_t pdo_count;
    ect_esi_mailbox_t mailbox;
    const ect_esi_dc_t *dcs;
    size_t dc_count;
    ect_esi_dictionary_t dictionary;
    ect_esi_dictionary_t idns;     /**< parameters of SoE: the index of an object is the IDN */
    const char *dictionary_file;   /**< "" when the dictionary is not in a file of its own */
    const char *dictionary_unread; /**< the reason why that file was not read, "": none is known; NULL: it was read */

    uint32_t eeprom_size;                     /**< bytes, 0 when absent */
    ect_esi_bytes_t eeprom;                   /**< `<Data>`: the whole image */
    ect_esi_bytes_t config;                   /**< `<ConfigData>` */
    ect_esi_bytes_t bootstrap;                /**< `<BootStrap>` */
    const ect_esi_assignment_t *alternatives; /**< one for each SyncManager of each alternative */
    size_t alternative_count;
    const ect_esi_assignment_t *mode_assignments; /**< one for each SyncManager of each mode of the clocks */
    size_t mode_assignment_count;
    const ect_esi_category_t *categories;
    size_t category_count;

    const ect_esi_slot_t *slots;
    size_t slot_count;
    uint32_t slot_pdo_increment, slot_index_increment, slots_max;
    uint32_t group_pdo_increment, group_index_increment; /**< `SlotGroupPdoIncrement`, `SlotGroupIndexIncrement` */
    bool download_idents;                                /**< `DownloadModuleIdentList`: a master writes F030h */
    bool download_addresses;                             /**< `DownloadModuleAddressList`: a master writes F020h */
    const ect_esi_pdo_group_t *pdo_groups;
    size_t pdo_group_count;
    uint32_t pdo_group;              /**< `ModulePdoGroup` + 1 of the device itself; 0: none */
    const ect_esi_module_t *modules; /**< all of the file */
    size_t module_count;

    const ect_field_t *fields; /**< named bits and values, as ect_plant_t::fields; NULL: none; no ESI file has them */
} ect_esi_device_t;

#endif
