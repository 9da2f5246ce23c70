/* SPDX-License-Identifier: MIT */
/* The elements of a device, in the order of the schema. */
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "esi/internal.h"
#include "sii/sii.h"
#include "wire/bytes.h"
#include "wire/sii.h"

/* --- identity ----------------------------------------------------------------------------------------------------- */

static void write_type(ect_pen_t *pen, const ect_device_t *device, const ect_identity_t *identity)
{
    ect_pen_open(pen, "Type");
    ect_pen_attribute(pen, "ProductCode", "#x%08" PRIX32, identity->product_code);
    ect_pen_attribute(pen, "RevisionNo", "#x%08" PRIX32, identity->revision);
    if (identity->serial != 0)
        ect_pen_attribute(pen, "SerialNo", "#x%08" PRIX32, identity->serial);
    ect_pen_flag(pen, "UseLrdLwr", (ect_device_general_flags(device) & ECT_GENERAL_NO_LRW) != 0);
    ect_pen_content(pen, device->type_name);
    ect_pen_close(pen);
}

/* Writes a timeout, or else the standard's default, because the schema requires all timeouts or none. */
static void write_timeout(ect_pen_t *pen, const char *element, uint16_t said_ms, uint16_t default_ms)
{
    ect_pen_number(pen, element, said_ms != 0 ? said_ms : default_ms);
}

static void write_info(ect_pen_t *pen, const ect_device_t *device, const xmlNode *source)
{
    const ect_timeouts_t *t = &device->timeouts;
    uint8_t flags = ect_device_general_flags(device);
    ect_pen_open(pen, "Info");
    if (device->ebus_ma != 0) {
        ect_pen_open(pen, "Electrical");
        ect_pen_number(pen, "EBusCurrent", device->ebus_ma);
        ect_pen_close(pen);
    }
    ect_pen_open(pen, "StateMachine");
    ect_pen_open(pen, "Timeout");
    write_timeout(pen, "PreopTimeout", t->preop_ms, 3000);
    write_timeout(pen, "SafeopOpTimeout", t->safeop_op_ms, 10000);
    write_timeout(pen, "BackToInitTimeout", t->back_to_init_ms, 5000);
    write_timeout(pen, "BackToSafeopTimeout", t->back_to_safeop_ms, 200);
    ect_pen_close(pen);
    ect_pen_close(pen);
    if (t->mailbox_request_ms != 0 || t->mailbox_response_ms != 0) {
        ect_pen_open(pen, "Mailbox");
        ect_pen_open(pen, "Timeout");
        write_timeout(pen, "RequestTimeout", t->mailbox_request_ms, 100);
        write_timeout(pen, "ResponseTimeout", t->mailbox_response_ms, 2000);
        ect_pen_close(pen);
        ect_pen_close(pen);
    }
    ect_pen_copy_children(pen, ect_esi_child(source, "Info"), "VendorSpecific");
    if ((flags & ECT_GENERAL_ID_MEMORY) != 0)
        ect_pen_hex(pen, "IdentificationAdo", device->id_address, 4);
    if ((flags & ECT_GENERAL_ID_AL_STATUS) != 0)
        ect_pen_text(pen, "IdentificationReg134", "true");
    ect_pen_close(pen);
}

/* Omits a dictionary that no master can read: the PDOs contain its useful part. */
static void write_profile(ect_pen_t *pen, const ect_device_t *device, const ect_identity_t *identity)
{
    if ((device->mailbox_protocols & ECT_MAILBOX_COE) == 0)
        return;
    ect_pen_open(pen, "Profile");
    if (device->device_type != 0) {
        ect_pen_number(pen, "ProfileNo", device->device_type & 0xFFFF);
        ect_pen_number(pen, "AddInfo", device->device_type >> 16);
    }
    ect_pen_dictionary(pen, device, identity);
    ect_pen_close(pen);
}

/* --- the controller ---------------------------------------------------------------------------------------------- */

static void write_fmmus(ect_pen_t *pen, const ect_device_t *device)
{
    static const char *const roles[] = {"", "Outputs", "Inputs", "MBoxState"};
    for (unsigned int i = 0; i < device->fmmu_count; i++)
        ect_pen_text(pen, "Fmmu", device->fmmu[i] < 4 ? roles[device->fmmu[i]] : "");
}

/* Writes both limits of a mailbox of fixed size; for process data, whose length is that of the PDOs, only a varying
 * maximum. */
static void write_limits(ect_pen_t *pen, const ect_sm_t *sm, unsigned int bytes)
{
    bool mailbox = sm->type == ECT_SM_MAILBOX_OUT || sm->type == ECT_SM_MAILBOX_IN;
    if (mailbox)
        ect_pen_attribute(pen, "MinSize", "%u", sm->minimum != 0 ? (unsigned int)sm->minimum : bytes);
    if (sm->maximum > bytes || mailbox)
        ect_pen_attribute(pen, "MaxSize", "%u", sm->maximum > bytes ? (unsigned int)sm->maximum : bytes);
}

static void write_sms(ect_pen_t *pen, const ect_device_t *device)
{
    static const char *const roles[] = {"", "MBoxOut", "MBoxIn", "Outputs", "Inputs"};
    for (unsigned int i = 0; i < device->sm_count; i++) {
        const ect_sm_t *sm = &device->sm[i];
        uint16_t bytes = ect_device_sm_bytes(device, i);
        ect_pen_open(pen, "Sm");
        write_limits(pen, sm, bytes);
        ect_pen_attribute(pen, "DefaultSize", "%u", (unsigned int)bytes);
        ect_pen_attribute(pen, "StartAddress", "#x%04X", (unsigned int)sm->start);
        ect_pen_attribute(pen, "ControlByte", "#x%02X", (unsigned int)sm->control);
        ect_pen_attribute(pen, "Enable", "%u", (bytes > 0 ? 1u : 0u) | (sm->flags & ECT_SM_FLAG_FIXED));
        ect_pen_flag(pen, "Virtual", (sm->flags & ECT_SM_FLAG_VIRTUAL) != 0);
        ect_pen_flag(pen, "OpOnly", (sm->flags & ECT_SM_FLAG_OP_ONLY) != 0);
        ect_pen_content(pen, ect_sm_role(sm) < 5 ? roles[ect_sm_role(sm)] : "");
        ect_pen_close(pen);
    }
}

/* --- PDOs -------------------------------------------------------------------------------------------------------- */

static void write_entry(ect_pen_t *pen, const ect_od_t *od, uint32_t mapping)
{
    const ect_entry_t *entry = ect_od_mapped(od, mapping);
    uint32_t bits = mapping & 0xFF;
    ect_pen_open(pen, "Entry");
    ect_pen_hex(pen, "Index", entry != NULL ? mapping >> 16 : 0, entry != NULL ? 4 : 1);
    if (entry != NULL)
        ect_pen_number(pen, "SubIndex", mapping >> 8 & 0xFF);
    ect_pen_number(pen, "BitLen", bits);
    if (entry != NULL) {
        const char *type = ect_esi_type_of(pen->arena, entry->data_type, bits);
        ect_pen_text(pen, "Name", entry->name != NULL ? entry->name : "");
        ect_pen_bits(pen, (uint16_t)(mapping >> 16), (uint8_t)(mapping >> 8));
        if (type != NULL)
            ect_pen_text(pen, "DataType", type);
    }
    ect_pen_close(pen);
}

static const uint16_t *excludes_of(const ect_device_t *device, uint16_t index)
{
    static const uint16_t none[] = {0};
    for (unsigned int i = 0; i < device->pdo_count; i++) {
        if (device->pdos[i].index == index && device->pdos[i].excludes != NULL)
            return device->pdos[i].excludes;
    }
    return none;
}

static void write_pdo(ect_pen_t *pen, const ect_device_t *device, const ect_object_t *pdo)
{
    ect_od_t od = ect_device_od(device, NULL);
    uint16_t flags = ect_sii_pdo_flags(device, pdo);
    uint8_t sm = ect_sii_pdo_sm(device, pdo->index);
    ect_pen_open(pen, ect_od_is_rxpdo(pdo->index) ? "RxPdo" : "TxPdo");
    ect_pen_flag(pen, "Fixed", (flags & ECT_PDO_FIXED) != 0);
    ect_pen_flag(pen, "Mandatory", (flags & ECT_PDO_MANDATORY) != 0);
    ect_pen_flag(pen, "Virtual", (flags & ECT_PDO_VIRTUAL) != 0);
    if (sm < ECT_SMS)
        ect_pen_attribute(pen, "Sm", "%u", (unsigned int)sm);
    ect_pen_hex(pen, "Index", pdo->index, 4);
    ect_pen_text(pen, "Name", pdo->name != NULL ? pdo->name : "");
    for (const uint16_t *other = excludes_of(device, pdo->index); *other != 0; other++)
        ect_pen_hex(pen, "Exclude", *other, 4);
    for (uint32_t n = 1; n <= ect_od_element(pdo, 0); n++)
        write_entry(pen, &od, ect_od_element(pdo, n));
    ect_pen_close(pen);
}

/* Writes assigned PDOs first, in the order of the assignment and the data, then the others. */
static void write_assigned(ect_pen_t *pen, const ect_device_t *device, uint8_t role)
{
    ect_od_t od = ect_device_od(device, NULL);
    for (unsigned int sm = 0; sm < device->sm_count; sm++) {
        const ect_object_t *assignment = ect_od_find(&od, (uint16_t)(ECT_OD_ASSIGNMENT + sm));
        for (uint32_t n = 1; device->sm[sm].type == role && n <= ect_od_element(assignment, 0); n++) {
            const ect_object_t *pdo = ect_od_find(&od, (uint16_t)ect_od_element(assignment, n));
            if (pdo != NULL)
                write_pdo(pen, device, pdo);
        }
    }
}

void ect_pen_pdos(ect_pen_t *pen, const ect_device_t *device, bool outputs)
{
    write_assigned(pen, device, outputs ? ECT_SM_OUTPUTS : ECT_SM_INPUTS);
    for (uint16_t i = 0; i < device->object_count; i++) {
        const ect_object_t *object = &device->objects[i];
        bool wanted = outputs ? ect_od_is_rxpdo(object->index) : ect_od_is_txpdo(object->index);
        bool is_virtual = (ect_sii_pdo_flags(device, object) & ECT_PDO_VIRTUAL) != 0;
        if (wanted && (is_virtual || ect_sii_pdo_sm(device, object->index) >= ECT_SMS))
            write_pdo(pen, device, object);
    }
}

/* --- mailbox, clocks, EEPROM ------------------------------------------------------------------------------------- */

static void write_init_command(ect_pen_t *pen, const ect_init_command_t *command)
{
    ect_pen_open(pen, "InitCmd");
    ect_pen_flag(pen, "CompleteAccess", command->complete);
    for (const char *from = command->transitions; *from != '\0'; from += strspn(from, " ")) {
        size_t length = strcspn(from, " ");
        ect_pen_text(pen, "Transition", ect_arena_print(pen->arena, "%.*s", (int)length, from));
        from += length;
    }
    ect_pen_hex(pen, "Index", command->index, 4);
    ect_pen_number(pen, "SubIndex", command->subindex);
    ect_pen_open(pen, "Data");
    ect_pen_flag(pen, "AdaptAutomatically", command->adapts);
    for (uint16_t i = 0; i < command->size; i++)
        ect_pen_content(pen, ect_arena_print(pen->arena, "%02X", command->data[i]));
    ect_pen_close(pen);
    if (command->comment != NULL)
        ect_pen_text(pen, "Comment", command->comment);
    ect_pen_close(pen);
}

static void write_coe(ect_pen_t *pen, const ect_device_t *device, const xmlNode *source)
{
    ect_od_t od = ect_device_od(device, NULL);
    uint8_t details = device->coe_details;
    ect_pen_open(pen, "CoE");
    ect_pen_flag(pen, "SdoInfo", (details & ECT_COE_SDO_INFO) != 0);
    ect_pen_flag(pen, "PdoAssign", (details & ECT_COE_PDO_ASSIGN) != 0);
    ect_pen_flag(pen, "PdoConfig", (details & ECT_COE_PDO_CONFIG) != 0);
    ect_pen_flag(pen, "PdoUpload", (details & ECT_COE_PDO_UPLOAD) != 0);
    ect_pen_flag(pen, "CompleteAccess", (details & ECT_COE_COMPLETE_ACCESS) != 0);
    ect_pen_flag(pen, "SegmentedSdo", true);
    ect_pen_flag(pen, "DiagHistory", ect_od_find(&od, 0x10F3) != NULL);
    for (unsigned int i = 0; source == NULL && i < device->init_command_count; i++) {
        if (!device->init_commands[i].disabled) /* an ESI file has no such commands */
            write_init_command(pen, &device->init_commands[i]);
    }
    ect_pen_copy_children(pen, source, NULL);
    ect_pen_close(pen);
}

static void write_mailbox(ect_pen_t *pen, const ect_device_t *device, const xmlNode *source)
{
    static const struct {
        const char *element;
        uint8_t bit;
    } protocols[] = {
        {"AoE", ECT_MAILBOX_AOE}, {"EoE", ECT_MAILBOX_EOE}, {"CoE", ECT_MAILBOX_COE},
        {"FoE", ECT_MAILBOX_FOE}, {"SoE", ECT_MAILBOX_SOE}, {"VoE", ECT_MAILBOX_VOE},
    };
    if (device->mailbox_protocols == 0)
        return;
    ect_pen_open(pen, "Mailbox");
    ect_pen_flag(pen, "DataLinkLayer", (ect_device_general_flags(device) & ECT_GENERAL_MAIL_REPEAT) != 0);
    for (size_t i = 0; i < sizeof protocols / sizeof protocols[0]; i++) {
        if ((device->mailbox_protocols & protocols[i].bit) == 0)
            continue;
        if (protocols[i].bit == ECT_MAILBOX_COE) {
            write_coe(pen, device, ect_esi_child(source, "CoE"));
        } else {
            ect_pen_open(pen, protocols[i].element);
            if (protocols[i].bit == ECT_MAILBOX_SOE && device->soe_channels != 0)
                ect_pen_attribute(pen, "ChannelCount", "%u", (unsigned int)device->soe_channels);
            ect_pen_copy_children(pen, ect_esi_child(source, protocols[i].element), NULL);
            ect_pen_close(pen);
        }
    }
    ect_pen_close(pen);
}

static void write_time(ect_pen_t *pen, const char *element, int64_t time_ns, int factor)
{
    if (time_ns == 0 && factor == 0)
        return;
    ect_pen_open(pen, element);
    if (factor != 0)
        ect_pen_attribute(pen, "Factor", "%d", factor);
    char text[24];
    (void)snprintf(text, sizeof text, "%" PRId64, time_ns);
    ect_pen_content(pen, text);
    ect_pen_close(pen);
}

/* Writes the DC modes; those of a twin are in the order of its file. */
static void write_dc(ect_pen_t *pen, const ect_device_t *device, const xmlNode *source)
{
    const xmlNode *mode_of_file = ect_esi_child(source, "OpMode");
    if (device->dc_mode_count == 0)
        return;
    ect_pen_open(pen, "Dc");
    for (unsigned int i = 0; i < device->dc_mode_count; i++) {
        const ect_dc_mode_t *mode = &device->dc_modes[i];
        ect_pen_open(pen, "OpMode");
        ect_pen_text(pen, "Name", mode->name);
        if (mode->description != NULL && *mode->description != '\0')
            ect_pen_text(pen, "Desc", mode->description);
        ect_pen_hex(pen, "AssignActivate", mode->assign_activate, 4);
        write_time(pen, "CycleTimeSync0", mode->cycle_sync0_ns, mode->factor_sync0);
        write_time(pen, "ShiftTimeSync0", mode->shift_sync0_ns, 0);
        write_time(pen, "CycleTimeSync1", 0, mode->factor_sync1);
        write_time(pen, "ShiftTimeSync1", mode->shift_sync1_ns, 0);
        ect_pen_copy_children(pen, mode_of_file, "Sm");
        mode_of_file = mode_of_file != NULL ? ect_esi_next(mode_of_file, "OpMode") : NULL;
        ect_pen_close(pen);
    }
    ect_pen_close(pen);
}

static void write_boot(ect_pen_t *pen, const ect_device_t *device)
{
    uint8_t words[8];
    if (device->boot_out.length == 0)
        return;
    ect_store_le16(words, device->boot_out.start);
    ect_store_le16(words + 2, device->boot_out.length);
    ect_store_le16(words + 4, device->boot_in.start);
    ect_store_le16(words + 6, device->boot_in.length);
    ect_pen_bytes(pen, "BootStrap", words, sizeof words);
}

static void write_categories(ect_pen_t *pen, const ect_device_t *device)
{
    for (unsigned int i = 0; i < device->category_count; i++) {
        const ect_category_t *category = &device->categories[i];
        ect_pen_open(pen, "Category");
        ect_pen_number(pen, "CatNo", category->number);
        ect_pen_bytes(pen, "Data", category->data, category->length);
        ect_pen_close(pen);
    }
}

/* Writes the elements from which a tool makes the image, or the image of the description. */
static void write_eeprom(ect_pen_t *pen, const ect_device_t *device, const ect_identity_t *identity)
{
    ect_pen_open(pen, "Eeprom");
    if (device->sii != NULL) {
        uint8_t *image = ect_arena_alloc(pen->arena, device->sii_size);
        pen->failed |=
            ect_sii_write(device, identity, ect_load_le16(device->sii + ECT_SII_AT_ALIAS), image, device->sii_size) < 0;
        ect_pen_bytes(pen, "Data", image, device->sii_size);
    } else {
        ect_pen_number(pen, "ByteSize", device->sii_size);
        ect_pen_bytes(pen, "ConfigData", device->esc_config, sizeof device->esc_config);
        write_boot(pen, device);
        write_categories(pen, device);
    }
    ect_pen_close(pen);
}

void ect_pen_device(ect_pen_t *pen, const ect_esi_part_t *part, bool slots)
{
    const ect_device_t *device = part->device;
    const ect_identity_t *identity = part->identity != NULL ? part->identity : &device->identity;
    pen->plant = part->plant;
    const xmlNode *source = ect_pen_source(part);
    ect_pen_open(pen, "Device");
    ect_pen_attribute(pen, "Physics", "%s", device->physics != NULL ? device->physics : "");
    write_type(pen, device, identity);
    ect_pen_text(pen, "Name", device->full_name != NULL ? device->full_name : device->type_name);
    write_info(pen, device, source);
    ect_pen_text(pen, "GroupType", device->group_type);
    write_profile(pen, device, identity);
    write_fmmus(pen, device);
    write_sms(pen, device);
    ect_pen_pdos(pen, device, true);
    ect_pen_pdos(pen, device, false);
    write_mailbox(pen, device, ect_esi_child(source, "Mailbox"));
    write_dc(pen, device, ect_esi_child(source, "Dc"));
    if (slots)
        ect_pen_copy_children(pen, source, "Slots");
    write_eeprom(pen, device, identity);
    ect_pen_close(pen);
}
