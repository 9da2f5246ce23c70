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

static void write_type(ect_xml_writer_t *xml, const ect_device_t *device, const ect_identity_t *identity)
{
    ect_xml_open(xml, "Type");
    ect_xml_attribute(xml, "ProductCode", "#x%08" PRIX32, identity->product_code);
    ect_xml_attribute(xml, "RevisionNo", "#x%08" PRIX32, identity->revision);
    if (identity->serial != 0)
        ect_xml_attribute(xml, "SerialNo", "#x%08" PRIX32, identity->serial);
    ect_xml_flag(xml, "UseLrdLwr", (ect_device_general_flags(device) & ECT_GENERAL_NO_LRW) != 0);
    ect_xml_content(xml, device->type_name);
    ect_xml_close(xml);
}

/* Writes a timeout, or else the standard's default, because the schema requires all timeouts or none. */
static void write_timeout(ect_xml_writer_t *xml, const char *element, uint16_t said_ms, uint16_t default_ms)
{
    ect_xml_number(xml, element, said_ms != 0 ? said_ms : default_ms);
}

static void write_info(ect_xml_writer_t *xml, const ect_device_t *device, const xmlNode *source)
{
    const ect_timeouts_t *t = &device->timeouts;
    uint8_t flags = ect_device_general_flags(device);
    ect_xml_open(xml, "Info");
    if (device->ebus_ma != 0) {
        ect_xml_open(xml, "Electrical");
        ect_xml_number(xml, "EBusCurrent", device->ebus_ma);
        ect_xml_close(xml);
    }
    ect_xml_open(xml, "StateMachine");
    ect_xml_open(xml, "Timeout");
    write_timeout(xml, "PreopTimeout", t->preop_ms, 3000);
    write_timeout(xml, "SafeopOpTimeout", t->safeop_op_ms, 10000);
    write_timeout(xml, "BackToInitTimeout", t->back_to_init_ms, 5000);
    write_timeout(xml, "BackToSafeopTimeout", t->back_to_safeop_ms, 200);
    ect_xml_close(xml);
    ect_xml_close(xml);
    if (t->mailbox_request_ms != 0 || t->mailbox_response_ms != 0) {
        ect_xml_open(xml, "Mailbox");
        ect_xml_open(xml, "Timeout");
        write_timeout(xml, "RequestTimeout", t->mailbox_request_ms, 100);
        write_timeout(xml, "ResponseTimeout", t->mailbox_response_ms, 2000);
        ect_xml_close(xml);
        ect_xml_close(xml);
    }
    ect_xml_copy_children(xml, ect_esi_child(source, "Info"), "VendorSpecific");
    if ((flags & ECT_GENERAL_ID_MEMORY) != 0)
        ect_xml_hex(xml, "IdentificationAdo", device->id_address, 4);
    if ((flags & ECT_GENERAL_ID_AL_STATUS) != 0)
        ect_xml_text(xml, "IdentificationReg134", "true");
    ect_xml_close(xml);
}

/* Omits a dictionary that no master can read, because the PDOs contain its useful part. The IDNs of SoE are those of
 * the file. */
static void write_profile(ect_xml_writer_t *xml, const ect_device_t *device, const ect_identity_t *identity,
                          const xmlNode *source)
{
    if ((device->mailbox_protocols & ECT_MAILBOX_COE) == 0) {
        if ((device->mailbox_protocols & ECT_MAILBOX_SOE) != 0)
            ect_xml_copy_children(xml, source, "Profile");
        return;
    }
    ect_xml_open(xml, "Profile");
    if (device->device_type != 0) {
        ect_xml_number(xml, "ProfileNo", device->device_type & 0xFFFF);
        ect_xml_number(xml, "AddInfo", device->device_type >> 16);
    }
    ect_xml_dictionary(xml, device, identity);
    ect_xml_close(xml);
}

/* --- the controller ---------------------------------------------------------------------------------------------- */

static void write_fmmus(ect_xml_writer_t *xml, const ect_device_t *device)
{
    static const char *const roles[] = {"", "Outputs", "Inputs", "MBoxState"};
    for (unsigned int i = 0; i < device->fmmu_count; i++)
        ect_xml_text(xml, "Fmmu", device->fmmu[i] < 4 ? roles[device->fmmu[i]] : "");
}

/* Writes both limits of a mailbox of fixed size; for process data, whose length is that of the PDOs, only a varying
 * maximum. */
static void write_limits(ect_xml_writer_t *xml, const ect_sm_t *sm, unsigned int bytes)
{
    bool mailbox = sm->type == ECT_SM_MAILBOX_OUT || sm->type == ECT_SM_MAILBOX_IN;
    if (mailbox)
        ect_xml_attribute(xml, "MinSize", "%u", sm->minimum != 0 ? (unsigned int)sm->minimum : bytes);
    if (sm->maximum > bytes || mailbox)
        ect_xml_attribute(xml, "MaxSize", "%u", sm->maximum > bytes ? (unsigned int)sm->maximum : bytes);
}

static void write_sms(ect_xml_writer_t *xml, const ect_device_t *device)
{
    static const char *const roles[] = {"", "MBoxOut", "MBoxIn", "Outputs", "Inputs"};
    for (unsigned int i = 0; i < device->sm_count; i++) {
        const ect_sm_t *sm = &device->sm[i];
        uint16_t bytes = ect_device_sm_bytes(device, i);
        ect_xml_open(xml, "Sm");
        write_limits(xml, sm, bytes);
        ect_xml_attribute(xml, "DefaultSize", "%u", (unsigned int)bytes);
        ect_xml_attribute(xml, "StartAddress", "#x%04X", (unsigned int)sm->start);
        ect_xml_attribute(xml, "ControlByte", "#x%02X", (unsigned int)sm->control);
        ect_xml_attribute(xml, "Enable", "%u", (bytes > 0 ? 1u : 0u) | (sm->flags & ECT_SM_FLAG_FIXED));
        ect_xml_flag(xml, "Virtual", (sm->flags & ECT_SM_FLAG_VIRTUAL) != 0);
        ect_xml_flag(xml, "OpOnly", (sm->flags & ECT_SM_FLAG_OP_ONLY) != 0);
        ect_xml_content(xml, ect_sm_role(sm) < 5 ? roles[ect_sm_role(sm)] : "");
        ect_xml_close(xml);
    }
}

/* --- PDOs -------------------------------------------------------------------------------------------------------- */

/* @param written  the mapping as the file has it */
static void write_entry(ect_xml_writer_t *xml, const ect_od_t *od, uint32_t mapping, uint32_t written)
{
    const ect_entry_t *entry = ect_od_mapped(od, mapping);
    uint32_t bits = mapping & 0xFF;
    ect_xml_open(xml, "Entry");
    if (entry != NULL) {
        ect_xml_index(xml, "Index", (uint16_t)(written >> 16));
        ect_xml_number(xml, "SubIndex", written >> 8 & 0xFF);
    } else {
        ect_xml_hex(xml, "Index", 0, 1);
    }
    ect_xml_number(xml, "BitLen", bits);
    if (entry != NULL) {
        const char *type = ect_esi_type_of(xml->arena, entry->data_type, bits);
        ect_xml_text(xml, "Name", entry->name != NULL ? entry->name : "");
        ect_xml_bits(xml, (uint16_t)(mapping >> 16), (uint8_t)(mapping >> 8));
        if (type != NULL)
            ect_xml_text(xml, "DataType", type);
    }
    ect_xml_close(xml);
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

static void write_pdo(ect_xml_writer_t *xml, const ect_device_t *device, const ect_object_t *pdo)
{
    ect_od_t od = ect_device_od(device, NULL);
    uint16_t flags = ect_sii_pdo_flags(device, pdo);
    uint8_t sm = ect_sii_pdo_sm(device, pdo->index);
    ect_xml_open(xml, ect_od_is_rxpdo(pdo->index) ? "RxPdo" : "TxPdo");
    ect_xml_flag(xml, "Fixed", (flags & ECT_PDO_FIXED) != 0);
    ect_xml_flag(xml, "Mandatory", (flags & ECT_PDO_MANDATORY) != 0);
    ect_xml_flag(xml, "Virtual", (flags & ECT_PDO_VIRTUAL) != 0);
    if (sm < ECT_SMS)
        ect_xml_attribute(xml, "Sm", "%u", (unsigned int)sm);
    ect_xml_index(xml, "Index", ect_sii_pdo_number(device, pdo->index));
    ect_xml_text(xml, "Name", pdo->name != NULL ? pdo->name : "");
    for (const uint16_t *other = excludes_of(device, pdo->index); *other != 0; other++)
        ect_xml_index(xml, "Exclude", ect_sii_pdo_number(device, *other));
    for (uint32_t n = 1; n <= ect_od_element(pdo, 0); n++)
        write_entry(xml, &od, ect_od_element(pdo, n), ect_sii_pdo_element(device, pdo, n));
    ect_xml_close(xml);
}

/* Writes assigned PDOs first, in the order of the assignment and the data, then the others. */
static void write_assigned(ect_xml_writer_t *xml, const ect_device_t *device, uint8_t role)
{
    ect_od_t od = ect_device_od(device, NULL);
    for (unsigned int sm = 0; sm < device->sm_count; sm++) {
        const ect_object_t *assignment = ect_od_find(&od, (uint16_t)(ECT_OD_ASSIGNMENT + sm));
        for (uint32_t n = 1; device->sm[sm].type == role && n <= ect_od_element(assignment, 0); n++) {
            const ect_object_t *pdo = ect_od_find(&od, (uint16_t)ect_od_element(assignment, n));
            if (pdo != NULL)
                write_pdo(xml, device, pdo);
        }
    }
}

void ect_xml_pdos(ect_xml_writer_t *xml, const ect_device_t *device, bool outputs)
{
    write_assigned(xml, device, outputs ? ECT_SM_OUTPUTS : ECT_SM_INPUTS);
    for (uint16_t i = 0; i < device->object_count; i++) {
        const ect_object_t *object = &device->objects[i];
        bool wanted = outputs ? ect_od_is_rxpdo(object->index) : ect_od_is_txpdo(object->index);
        bool is_virtual = (ect_sii_pdo_flags(device, object) & ECT_PDO_VIRTUAL) != 0;
        if (wanted && (is_virtual || ect_sii_pdo_sm(device, object->index) >= ECT_SMS))
            write_pdo(xml, device, object);
    }
}

/* --- mailbox, clocks, EEPROM ------------------------------------------------------------------------------------- */

static void write_transitions(ect_xml_writer_t *xml, const char *transitions)
{
    for (const char *from = transitions; *from != '\0'; from += strspn(from, " ")) {
        size_t length = strcspn(from, " ");
        ect_xml_text(xml, "Transition", ect_arena_print(xml->arena, "%.*s", (int)length, from));
        from += length;
    }
}

static void write_init_command(ect_xml_writer_t *xml, const ect_init_command_t *command)
{
    ect_xml_open(xml, "InitCmd");
    ect_xml_flag(xml, "CompleteAccess", command->complete);
    write_transitions(xml, command->transitions);
    ect_xml_hex(xml, "Index", command->index, 4);
    ect_xml_number(xml, "SubIndex", command->subindex);
    ect_xml_open(xml, "Data");
    ect_xml_flag(xml, "AdaptAutomatically", command->adapts);
    for (uint16_t i = 0; i < command->size; i++)
        ect_xml_content(xml, ect_arena_print(xml->arena, "%02X", command->data[i]));
    ect_xml_close(xml);
    if (command->comment != NULL)
        ect_xml_text(xml, "Comment", command->comment);
    ect_xml_close(xml);
}

static void write_coe(ect_xml_writer_t *xml, const ect_device_t *device, const xmlNode *source)
{
    ect_od_t od = ect_device_od(device, NULL);
    uint8_t details = device->coe_details;
    ect_xml_open(xml, "CoE");
    ect_xml_flag(xml, "SdoInfo", (details & ECT_COE_SDO_INFO) != 0);
    ect_xml_flag(xml, "PdoAssign", (details & ECT_COE_PDO_ASSIGN) != 0);
    ect_xml_flag(xml, "PdoConfig", (details & ECT_COE_PDO_CONFIG) != 0);
    ect_xml_flag(xml, "PdoUpload", (details & ECT_COE_PDO_UPLOAD) != 0);
    ect_xml_flag(xml, "CompleteAccess", (details & ECT_COE_COMPLETE_ACCESS) != 0);
    ect_xml_flag(xml, "SegmentedSdo", true);
    ect_xml_flag(xml, "DiagHistory", ect_od_find(&od, 0x10F3) != NULL);
    for (unsigned int i = 0; source == NULL && i < device->init_command_count; i++) {
        if (!device->init_commands[i].disabled && !device->init_commands[i].upload) /* no commands of an ESI file */
            write_init_command(xml, &device->init_commands[i]);
    }
    ect_xml_copy_children(xml, source, NULL);
    ect_xml_close(xml);
}

/* Writes the commands of a protocol that an ESI file can have: SoE writes, and all are enabled. */
static void write_init_mails(ect_xml_writer_t *xml, const ect_device_t *device, uint8_t protocol)
{
    for (unsigned int i = 0; i < device->init_mail_count; i++) {
        const ect_init_mail_t *mail = &device->init_mails[i];
        const bool drives = mail->protocol == ECT_MAILBOX_TYPE_SOE;
        if (mail->protocol != protocol || mail->disabled || (drives && mail->type != ECT_INIT_WRITES))
            continue;
        ect_xml_open(xml, "InitCmd");
        if (drives && mail->drive != 0)
            ect_xml_attribute(xml, "Chn", "%u", (unsigned int)mail->drive);
        write_transitions(xml, mail->transitions);
        if (protocol == ECT_MAILBOX_TYPE_EOE)
            ect_xml_number(xml, "Type", mail->type);
        if (drives)
            ect_xml_number(xml, "IDN", mail->idn);
        if (mail->size > 0)
            ect_xml_bytes(xml, "Data", mail->data, mail->size);
        if (mail->comment != NULL)
            ect_xml_text(xml, "Comment", mail->comment);
        ect_xml_close(xml);
    }
}

static void write_soe_attributes(ect_xml_writer_t *xml, const ect_device_t *device, const xmlNode *source)
{
    if (device->soe_channels != 0)
        ect_xml_attribute(xml, "ChannelCount", "%u", (unsigned int)device->soe_channels);
    for (const xmlAttr *of = source != NULL ? source->properties : NULL; of != NULL; of = of->next) {
        if (strcmp((const char *)of->name, "DriveFollowsBit3Support") == 0 && of->children != NULL)
            ect_xml_attribute(xml, (const char *)of->name, "%s", (const char *)of->children->content);
    }
}

static void write_mailbox(ect_xml_writer_t *xml, const ect_device_t *device, const xmlNode *source)
{
    static const struct {
        const char *element;
        uint8_t bit, type;
    } protocols[] = {
        {"AoE", ECT_MAILBOX_AOE, ECT_MAILBOX_TYPE_AOE}, {"EoE", ECT_MAILBOX_EOE, ECT_MAILBOX_TYPE_EOE},
        {"CoE", ECT_MAILBOX_COE, ECT_MAILBOX_TYPE_COE}, {"FoE", ECT_MAILBOX_FOE, ECT_MAILBOX_TYPE_FOE},
        {"SoE", ECT_MAILBOX_SOE, ECT_MAILBOX_TYPE_SOE}, {"VoE", ECT_MAILBOX_VOE, ECT_MAILBOX_TYPE_VOE},
    };
    if (device->mailbox_protocols == 0)
        return;
    ect_xml_open(xml, "Mailbox");
    ect_xml_flag(xml, "DataLinkLayer", (ect_device_general_flags(device) & ECT_GENERAL_MAIL_REPEAT) != 0);
    for (size_t i = 0; i < sizeof protocols / sizeof protocols[0]; i++) {
        if ((device->mailbox_protocols & protocols[i].bit) == 0)
            continue;
        if (protocols[i].bit == ECT_MAILBOX_COE) {
            write_coe(xml, device, ect_esi_child(source, "CoE"));
        } else {
            ect_xml_open(xml, protocols[i].element);
            if (protocols[i].bit == ECT_MAILBOX_SOE)
                write_soe_attributes(xml, device, ect_esi_child(source, "SoE"));
            if (source == NULL && protocols[i].bit != ECT_MAILBOX_FOE) /* the schema has no start-up commands of FoE */
                write_init_mails(xml, device, protocols[i].type);
            ect_xml_copy_children(xml, ect_esi_child(source, protocols[i].element), NULL);
            ect_xml_close(xml);
        }
    }
    ect_xml_close(xml);
}

static void write_time(ect_xml_writer_t *xml, const char *element, int64_t time_ns, int factor)
{
    if (time_ns == 0 && factor == 0)
        return;
    ect_xml_open(xml, element);
    if (factor != 0)
        ect_xml_attribute(xml, "Factor", "%d", factor);
    char text[24];
    (void)snprintf(text, sizeof text, "%" PRId64, time_ns);
    ect_xml_content(xml, text);
    ect_xml_close(xml);
}

/* Writes the DC modes; those of a twin are in the order of its file. */
static void write_dc(ect_xml_writer_t *xml, const ect_device_t *device, const xmlNode *source)
{
    const xmlNode *mode_of_file = ect_esi_child(source, "OpMode");
    if (device->dc_mode_count == 0)
        return;
    ect_xml_open(xml, "Dc");
    for (unsigned int i = 0; i < device->dc_mode_count; i++) {
        const ect_dc_mode_t *mode = &device->dc_modes[i];
        ect_xml_open(xml, "OpMode");
        ect_xml_text(xml, "Name", mode->name);
        if (mode->description != NULL && *mode->description != '\0')
            ect_xml_text(xml, "Desc", mode->description);
        ect_xml_hex(xml, "AssignActivate", mode->assign_activate, 4);
        write_time(xml, "CycleTimeSync0", mode->cycle_sync0_ns, mode->factor_sync0);
        write_time(xml, "ShiftTimeSync0", mode->shift_sync0_ns, 0);
        write_time(xml, "CycleTimeSync1", 0, mode->factor_sync1);
        write_time(xml, "ShiftTimeSync1", mode->shift_sync1_ns, 0);
        ect_xml_copy_children(xml, mode_of_file, "Sm");
        mode_of_file = mode_of_file != NULL ? ect_esi_next(mode_of_file, "OpMode") : NULL;
        ect_xml_close(xml);
    }
    ect_xml_close(xml);
}

static void write_boot(ect_xml_writer_t *xml, const ect_device_t *device)
{
    uint8_t words[8];
    if (device->boot_out.length == 0)
        return;
    ect_store_le16(words, device->boot_out.start);
    ect_store_le16(words + 2, device->boot_out.length);
    ect_store_le16(words + 4, device->boot_in.start);
    ect_store_le16(words + 6, device->boot_in.length);
    ect_xml_bytes(xml, "BootStrap", words, sizeof words);
}

static void write_categories(ect_xml_writer_t *xml, const ect_device_t *device)
{
    for (unsigned int i = 0; i < device->category_count; i++) {
        const ect_category_t *category = &device->categories[i];
        ect_xml_open(xml, "Category");
        ect_xml_number(xml, "CatNo", category->number);
        ect_xml_bytes(xml, "Data", category->data, category->length);
        ect_xml_close(xml);
    }
}

/* Writes the elements from which a tool makes the image, or the image of the description. */
static void write_eeprom(ect_xml_writer_t *xml, const ect_device_t *device, const ect_identity_t *identity)
{
    ect_xml_open(xml, "Eeprom");
    if (device->sii != NULL) {
        uint8_t *image = ect_arena_alloc(xml->arena, device->sii_size);
        xml->failed |=
            ect_sii_write(device, identity, ect_load_le16(device->sii + ECT_SII_AT_ALIAS), image, device->sii_size) < 0;
        ect_xml_bytes(xml, "Data", image, device->sii_size);
    } else {
        ect_xml_number(xml, "ByteSize", device->sii_size);
        ect_xml_bytes(xml, "ConfigData", device->esc_config, sizeof device->esc_config);
        write_boot(xml, device);
        write_categories(xml, device);
    }
    ect_xml_close(xml);
}

void ect_xml_device(ect_xml_writer_t *xml, const ect_esi_part_t *part, bool slots)
{
    const ect_device_t *device = part->device;
    const ect_identity_t *identity = part->identity != NULL ? part->identity : &device->identity;
    xml->plant = part->plant;
    const xmlNode *source = ect_xml_source(part);
    ect_xml_open(xml, "Device");
    ect_xml_attribute(xml, "Physics", "%s", device->physics != NULL ? device->physics : "");
    write_type(xml, device, identity);
    ect_xml_text(xml, "Name", device->full_name != NULL ? device->full_name : device->type_name);
    write_info(xml, device, source);
    ect_xml_text(xml, "GroupType", device->group_type);
    write_profile(xml, device, identity, source);
    write_fmmus(xml, device);
    write_sms(xml, device);
    ect_xml_pdos(xml, device, true);
    ect_xml_pdos(xml, device, false);
    write_mailbox(xml, device, ect_esi_child(source, "Mailbox"));
    write_dc(xml, device, ect_esi_child(source, "Dc"));
    if (slots && source != NULL)
        ect_xml_copy_children(xml, source, "Slots");
    else if (slots)
        ect_xml_slots(xml, ect_esi_twin_model(part->twin));
    write_eeprom(xml, device, identity);
    ect_xml_close(xml);
}
