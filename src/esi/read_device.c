/* SPDX-License-Identifier: MIT */
#include "esi/internal.h"

#include <string.h>

enum { MOST_DRIVES = 8, SOE_VALUE = 0x40 }; /* of SoE: a mail has three bits for the drive */

static uint16_t index_of(ect_esi_xml_t *xml, const xmlNode *parent, uint8_t *moves)
{
    const xmlNode *node = ect_esi_child(parent, "Index");
    *moves = ect_esi_moves(xml, node);
    if (node == NULL) {
        ect_esi_fail(xml, parent, "%s has no Index", (const char *)parent->name);
        return 0;
    }
    return (uint16_t)ect_esi_value(xml, node, 0, UINT16_MAX);
}

static void read_entry(ect_esi_xml_t *xml, const xmlNode *node, ect_esi_entry_t *entry)
{
    entry->index = index_of(xml, node, &entry->moves);
    entry->subindex = (uint8_t)ect_esi_number(xml, node, "SubIndex", 0, UINT8_MAX, 0);
    entry->bits = (uint16_t)ect_esi_number(xml, node, "BitLen", 0, UINT16_MAX, 0);
    entry->name = ect_esi_name(xml, node, "Name");
    entry->type = ect_esi_text(xml, ect_esi_child(node, "DataType"));
    entry->line = ect_esi_line(node);
    if (ect_esi_child(node, "BitLen") == NULL)
        ect_esi_fail(xml, node, "Entry has no BitLen");
}

static void read_pdo(ect_esi_xml_t *xml, const xmlNode *node, ect_esi_pdo_t *pdo)
{
    ect_esi_entry_t *entries = NULL;
    ect_esi_entry_t *entry;
    ect_esi_exclude_t *exclude = NULL;
    ect_esi_exclude_t *excluded;
    pdo->tx = ect_esi_is(node, "TxPdo");
    pdo->index = index_of(xml, node, &pdo->moves);
    pdo->name = ect_esi_name(xml, node, "Name");
    pdo->fixed = ect_esi_flag(xml, node, "Fixed");
    pdo->mandatory = ect_esi_flag(xml, node, "Mandatory");
    pdo->virtual_pdo = ect_esi_flag(xml, node, "Virtual");
    pdo->sm = (int)ect_esi_attribute_number(xml, node, "Sm", 0, UINT8_MAX, -1);
    pdo->samples = (uint16_t)ect_esi_attribute_number(xml, node, "OSFac", 1, UINT16_MAX, 1);
    pdo->line = ect_esi_line(node);
    ECT_ESI_EACH(child, node, "Exclude")
    {
        ECT_APPEND(xml, exclude, pdo->exclude_count, excluded);
        excluded->index = (uint16_t)ect_esi_value(xml, child, 0, UINT16_MAX);
        excluded->moves = ect_esi_moves(xml, child);
    }
    ECT_ESI_EACH(child, node, "Entry")
    {
        ECT_APPEND(xml, entries, pdo->entry_count, entry);
        read_entry(xml, child, entry);
    }
    pdo->exclude = exclude;
    pdo->entries = entries;
}

const ect_esi_pdo_t *ect_esi_read_pdos(ect_esi_xml_t *xml, const xmlNode *parent, size_t *count)
{
    ect_esi_pdo_t *pdos = NULL;
    ect_esi_pdo_t *pdo;
    ECT_ESI_EACH(node, parent, "RxPdo")
    {
        ECT_APPEND(xml, pdos, *count, pdo);
        read_pdo(xml, node, pdo);
    }
    ECT_ESI_EACH(node, parent, "TxPdo")
    {
        ECT_APPEND(xml, pdos, *count, pdo);
        read_pdo(xml, node, pdo);
    }
    return pdos;
}

static void read_sms(ect_esi_xml_t *xml, const xmlNode *node, ect_esi_device_t *device)
{
    ect_esi_sm_t *sms = NULL;
    ect_esi_sm_t *sm;
    ECT_ESI_EACH(child, node, "Sm")
    {
        ECT_APPEND(xml, sms, device->sm_count, sm);
        sm->type = ect_esi_text(xml, child);
        sm->start = (uint16_t)ect_esi_attribute_number(xml, child, "StartAddress", 0, UINT16_MAX, 0);
        sm->control = (uint8_t)ect_esi_attribute_number(xml, child, "ControlByte", 0, UINT8_MAX, 0);
        sm->size.given = *ect_esi_attribute(xml, child, "DefaultSize") != '\0';
        sm->size.value = ect_esi_attribute_number(xml, child, "DefaultSize", 0, UINT16_MAX, 0);
        sm->minimum = (uint16_t)ect_esi_attribute_number(xml, child, "MinSize", 0, UINT16_MAX, 0);
        sm->maximum = (uint16_t)ect_esi_attribute_number(xml, child, "MaxSize", 0, UINT16_MAX, 0);
        // Enable is a bit mask; absent means enabled, as in masters.
        unsigned int bits = (unsigned int)ect_esi_attribute_number(xml, child, "Enable", 0, UINT8_MAX, 1);
        bits |= ect_esi_flag(xml, child, "OpOnly") ? ECT_SM_FLAG_OP_ONLY : 0u;
        bits |= ect_esi_flag(xml, child, "Virtual") ? ECT_SM_FLAG_VIRTUAL : 0u;
        sm->flags = bits & (ECT_SM_FLAG_FIXED | ECT_SM_FLAG_VIRTUAL | ECT_SM_FLAG_OP_ONLY);
        sm->virtual_sm = (bits & ECT_SM_FLAG_VIRTUAL) != 0;
        sm->line = ect_esi_line(child);
    }
    device->sms = sms;
}

static void read_fmmus(ect_esi_xml_t *xml, const xmlNode *node, ect_esi_device_t *device)
{
    const char **fmmus = NULL;
    const char **fmmu;
    ECT_ESI_EACH(child, node, "Fmmu")
    {
        ECT_APPEND(xml, fmmus, device->fmmu_count, fmmu);
        *fmmu = ect_esi_text(xml, child);
    }
    device->fmmus = fmmus;
}

static const char *read_transitions(ect_esi_xml_t *xml, const xmlNode *init)
{
    const char *transitions = "";
    ECT_ESI_EACH(node, init, "Transition")
    transitions =
        ect_arena_print(xml->arena, "%s%s%s", transitions, *transitions != '\0' ? " " : "", ect_esi_text(xml, node));
    return transitions;
}

static const ect_esi_init_t *read_inits(ect_esi_xml_t *xml, const xmlNode *coe, size_t *count)
{
    ect_esi_init_t *inits = NULL;
    ect_esi_init_t *init;
    ECT_ESI_EACH(node, coe, "InitCmd")
    {
        ECT_APPEND(xml, inits, *count, init);
        init->transitions = read_transitions(xml, node);
        init->index = (uint16_t)ect_esi_number(xml, node, "Index", 0, UINT16_MAX, 0);
        init->subindex = (uint8_t)ect_esi_number(xml, node, "SubIndex", 0, UINT8_MAX, 0);
        init->complete = ect_esi_flag(xml, node, "CompleteAccess");
        init->data = ect_esi_hex(xml, node, "Data");
        const xmlNode *data = ect_esi_child(node, "Data");
        init->adapts = data != NULL && ect_esi_flag(xml, data, "AdaptAutomatically");
        init->comment = ect_esi_name(xml, node, "Comment");
        init->moves = ect_esi_moves(xml, ect_esi_child(node, "Index"));
        init->line = ect_esi_line(node);
    }
    return inits;
}

static void read_mail(ect_esi_xml_t *xml, const xmlNode *node, uint8_t protocol, ect_esi_mail_t *mail)
{
    mail->protocol = protocol;
    mail->transitions = read_transitions(xml, node);
    mail->data = ect_esi_hex(xml, node, "Data");
    mail->comment = ect_esi_name(xml, node, "Comment");
    mail->line = ect_esi_line(node);
}

/* Reads the commands of AoE or EoE; one without a mail of its protocol is left out. */
static void read_mails(ect_esi_xml_t *xml, const xmlNode *parent, uint8_t protocol, ect_esi_mailbox_t *mailbox)
{
    enum { AMS_HEADER = 32, EOE_TYPES = 15 };
    ect_esi_mail_t *mails = (ect_esi_mail_t *)(uintptr_t)mailbox->mails; // ours, growing
    ect_esi_mail_t *mail;
    ECT_ESI_EACH(node, parent, "InitCmd")
    {
        ECT_APPEND(xml, mails, mailbox->mail_count, mail);
        read_mail(xml, node, protocol, mail);
        mail->type = (uint8_t)ect_esi_number(xml, node, "Type", 0, EOE_TYPES, 0);
        const bool ads = protocol == ECT_MAILBOX_TYPE_AOE;
        if (ads ? mail->data.length < AMS_HEADER : ect_esi_child(node, "Type") == NULL)
            mailbox->mail_count--;
    }
    mailbox->mails = mails;
}

static void read_soe(ect_esi_xml_t *xml, const xmlNode *soe, ect_esi_mailbox_t *mailbox)
{
    ect_esi_mail_t *mails = (ect_esi_mail_t *)(uintptr_t)mailbox->mails; // ours, growing
    ect_esi_mail_t *mail;
    if (soe == NULL)
        return;
    mailbox->soe = true;
    mailbox->soe_channels = (uint8_t)ect_esi_attribute_number(xml, soe, "ChannelCount", 0, UINT8_MAX, 0);
    mailbox->soe_follows = ect_esi_flag(xml, soe, "DriveFollowsBit3Support");
    ECT_ESI_EACH(node, soe, "InitCmd")
    {
        ECT_APPEND(xml, mails, mailbox->mail_count, mail);
        read_mail(xml, node, ECT_MAILBOX_TYPE_SOE, mail);
        mail->type = ECT_INIT_WRITES;
        mail->idn = (uint16_t)ect_esi_number(xml, node, "IDN", 0, UINT16_MAX, 0);
        mail->drive = (uint8_t)ect_esi_attribute_number(xml, node, "Chn", 0, MOST_DRIVES - 1, 0);
        mail->elements = SOE_VALUE;
        if (ect_esi_child(node, "IDN") == NULL)
            ect_esi_fail(xml, node, "InitCmd of SoE has no IDN");
    }
    mailbox->mails = mails;
}

static void read_mailbox(ect_esi_xml_t *xml, const xmlNode *node, ect_esi_mailbox_t *mailbox)
{
    const xmlNode *coe = ect_esi_child(node, "CoE");
    mailbox->given = node != NULL;
    mailbox->aoe = ect_esi_child(node, "AoE") != NULL;
    mailbox->eoe = ect_esi_child(node, "EoE") != NULL;
    mailbox->coe = coe != NULL;
    mailbox->foe = ect_esi_child(node, "FoE") != NULL;
    mailbox->voe = ect_esi_child(node, "VoE") != NULL;
    mailbox->data_link_layer = node != NULL && ect_esi_flag(xml, node, "DataLinkLayer");
    read_mails(xml, ect_esi_child(node, "AoE"), ECT_MAILBOX_TYPE_AOE, mailbox);
    read_mails(xml, ect_esi_child(node, "EoE"), ECT_MAILBOX_TYPE_EOE, mailbox);
    read_soe(xml, ect_esi_child(node, "SoE"), mailbox);
    if (coe == NULL)
        return;
    mailbox->sdo_info = ect_esi_flag(xml, coe, "SdoInfo");
    mailbox->pdo_assign = ect_esi_flag(xml, coe, "PdoAssign");
    mailbox->pdo_config = ect_esi_flag(xml, coe, "PdoConfig");
    mailbox->pdo_upload = ect_esi_flag(xml, coe, "PdoUpload");
    mailbox->complete_access = ect_esi_flag(xml, coe, "CompleteAccess");
    mailbox->inits = read_inits(xml, coe, &mailbox->init_count);
}

/* Appends the SyncManagers with PDOs below an element. */
static const ect_esi_assignment_t *read_assignments(ect_esi_xml_t *xml, const xmlNode *parent, const char *name,
                                                    const ect_esi_assignment_t *list, size_t *count)
{
    ect_esi_assignment_t *assignments = (ect_esi_assignment_t *)(uintptr_t)list; // ours, growing
    ect_esi_assignment_t *assignment;
    ECT_ESI_EACH(node, parent, "Sm")
    {
        uint16_t *pdos = NULL;
        uint16_t *pdo;
        ECT_APPEND(xml, assignments, *count, assignment);
        assignment->name = name;
        assignment->preset = ect_esi_flag(xml, parent, "Default");
        assignment->sm = (unsigned int)ect_esi_attribute_number(xml, node, "No", 0, UINT8_MAX, 0);
        ECT_ESI_EACH(child, node, "Pdo")
        {
            ECT_APPEND(xml, pdos, assignment->pdo_count, pdo);
            *pdo = (uint16_t)ect_esi_value(xml, child, 0, UINT16_MAX);
        }
        assignment->pdos = pdos;
    }
    return assignments;
}

static void read_alternatives(ect_esi_xml_t *xml, const xmlNode *info, ect_esi_device_t *device)
{
    const xmlNode *vendor = ect_esi_child(ect_esi_child(info, "VendorSpecific"), "TwinCAT");
    ECT_ESI_EACH(node, vendor, "AlternativeSmMapping")
    device->alternatives =
        read_assignments(xml, node, ect_esi_name(xml, node, "Name"), device->alternatives, &device->alternative_count);
}

static int factor_of(ect_esi_xml_t *xml, const xmlNode *mode, const char *name)
{
    const xmlNode *node = ect_esi_child(mode, name);
    return node != NULL ? (int)ect_esi_attribute_number(xml, node, "Factor", INT16_MIN, INT16_MAX, 0) : 0;
}

static void read_dcs(ect_esi_xml_t *xml, const xmlNode *node, ect_esi_device_t *device)
{
    ect_esi_dc_t *dcs = NULL;
    ect_esi_dc_t *dc;
    ECT_ESI_EACH(mode, node, "OpMode")
    {
        ECT_APPEND(xml, dcs, device->dc_count, dc);
        dc->name = ect_esi_name(xml, mode, "Name");
        dc->description = ect_esi_name(xml, mode, "Desc");
        dc->assign_activate = (uint16_t)ect_esi_number(xml, mode, "AssignActivate", 0, UINT16_MAX, 0);
        dc->cycle_sync0_ns = ect_esi_number(xml, mode, "CycleTimeSync0", INT32_MIN, UINT32_MAX, 0);
        dc->shift_sync0_ns = ect_esi_number(xml, mode, "ShiftTimeSync0", INT32_MIN, UINT32_MAX, 0);
        dc->cycle_sync1_ns = ect_esi_number(xml, mode, "CycleTimeSync1", INT32_MIN, UINT32_MAX, 0);
        dc->shift_sync1_ns = ect_esi_number(xml, mode, "ShiftTimeSync1", INT32_MIN, UINT32_MAX, 0);
        dc->sync0_factor = factor_of(xml, mode, "CycleTimeSync0");
        dc->sync1_factor = factor_of(xml, mode, "CycleTimeSync1");
        device->mode_assignments =
            read_assignments(xml, mode, dc->name, device->mode_assignments, &device->mode_assignment_count);
    }
    device->dcs = dcs;
}

static void read_info(ect_esi_xml_t *xml, const xmlNode *info, ect_esi_device_t *device)
{
    const xmlNode *timeout = ect_esi_child(ect_esi_child(info, "StateMachine"), "Timeout");
    device->preop_ms = (uint32_t)ect_esi_number(xml, timeout, "PreopTimeout", 0, UINT32_MAX, 0);
    device->safeop_op_ms = (uint32_t)ect_esi_number(xml, timeout, "SafeopOpTimeout", 0, UINT32_MAX, 0);
    device->back_to_init_ms = (uint32_t)ect_esi_number(xml, timeout, "BackToInitTimeout", 0, UINT32_MAX, 0);
    device->back_to_safeop_ms = (uint32_t)ect_esi_number(xml, timeout, "BackToSafeopTimeout", 0, UINT32_MAX, 0);
    timeout = ect_esi_child(ect_esi_child(info, "Mailbox"), "Timeout");
    device->request_ms = (uint32_t)ect_esi_number(xml, timeout, "RequestTimeout", 0, UINT32_MAX, 0);
    device->response_ms = (uint32_t)ect_esi_number(xml, timeout, "ResponseTimeout", 0, UINT32_MAX, 0);
    device->ebus_current_ma =
        (int)ect_esi_number(xml, ect_esi_child(info, "Electrical"), "EBusCurrent", INT16_MIN, INT16_MAX, 0);
    const char *identification = ect_esi_text(xml, ect_esi_child(info, "IdentificationReg134"));
    device->identification_134 = strcmp(identification, "1") == 0 || strcmp(identification, "true") == 0;
    device->identification_ado = ect_esi_optional(xml, info, "IdentificationAdo");
}

/* A number of `size` bytes, little-endian. */
static ect_esi_bytes_t bytes_of(ect_esi_xml_t *xml, const xmlNode *node, size_t size)
{
    int64_t value = ect_esi_value(xml, node, INT32_MIN, UINT32_MAX);
    uint8_t *bytes = ect_arena_alloc(xml->arena, size);
    for (size_t i = 0; i < size; i++)
        bytes[i] = (uint8_t)((uint64_t)value >> 8 * i);
    return (ect_esi_bytes_t){.bytes = bytes, .length = size};
}

static ect_esi_bytes_t category_data(ect_esi_xml_t *xml, const xmlNode *node)
{
    const xmlNode *text = ect_esi_child(node, "DataString");
    const xmlNode *word = ect_esi_child(node, "DataUINT");
    const xmlNode *words = ect_esi_child(node, "DataUDINT");
    if (text != NULL) {
        const char *string = ect_esi_text(xml, text);
        return (ect_esi_bytes_t){.bytes = (const uint8_t *)string, .length = strlen(string)};
    }
    if (word != NULL || words != NULL)
        return bytes_of(xml, word != NULL ? word : words, word != NULL ? 2 : 4);
    return ect_esi_hex(xml, node, "Data");
}

static void read_categories(ect_esi_xml_t *xml, const xmlNode *eeprom, ect_esi_device_t *device)
{
    ect_esi_category_t *categories = NULL;
    ect_esi_category_t *category;
    ECT_ESI_EACH(node, eeprom, "Category")
    {
        ECT_APPEND(xml, categories, device->category_count, category);
        category->number = (uint16_t)ect_esi_number(xml, node, "CatNo", 0, UINT16_MAX, 0);
        category->data = category_data(xml, node);
        category->line = ect_esi_line(node);
    }
    device->categories = categories;
}

static void read_eeprom(ect_esi_xml_t *xml, const xmlNode *eeprom, ect_esi_device_t *device)
{
    device->eeprom = ect_esi_hex(xml, eeprom, "Data");
    device->eeprom_size = (uint32_t)ect_esi_number(xml, eeprom, "ByteSize", 0, 4 * 1024 * 1024, 0);
    device->config = ect_esi_hex(xml, eeprom, "ConfigData");
    device->bootstrap = ect_esi_hex(xml, eeprom, "BootStrap");
    read_categories(xml, eeprom, device);
}

static void read_slot(ect_esi_xml_t *xml, const xmlNode *node, ect_esi_device_t *device, ect_esi_slot_t *slot)
{
    uint32_t *idents = NULL;
    uint32_t *ident;
    const char **classes = NULL;
    const char **module_class;
    slot->name = ect_esi_name(xml, node, "Name");
    slot->instances_min = (unsigned int)ect_esi_attribute_number(xml, node, "MinInstances", 0, UINT16_MAX, 0);
    slot->instances_max = (unsigned int)ect_esi_attribute_number(xml, node, "MaxInstances", 0, UINT16_MAX, 1);
    slot->pdo_increment =
        (uint32_t)ect_esi_attribute_number(xml, node, "SlotPdoIncrement", 0, UINT16_MAX, device->slot_pdo_increment);
    slot->index_increment = (uint32_t)ect_esi_attribute_number(xml, node, "SlotIndexIncrement", 0, UINT16_MAX,
                                                               device->slot_index_increment);
    slot->group = (uint32_t)ect_esi_attribute_number(xml, node, "SlotGroup", 0, UINT16_MAX, 0);
    slot->group_pdo_increment = (uint32_t)ect_esi_attribute_number(xml, node, "SlotGroupPdoIncrement", 0, UINT16_MAX,
                                                                   device->group_pdo_increment);
    slot->group_index_increment = (uint32_t)ect_esi_attribute_number(xml, node, "SlotGroupIndexIncrement", 0,
                                                                     UINT16_MAX, device->group_index_increment);
    slot->own_increments = *ect_esi_attribute(xml, node, "SlotPdoIncrement") != '\0' ||
                           *ect_esi_attribute(xml, node, "SlotIndexIncrement") != '\0';
    ECT_ESI_EACH(child, node, "ModuleIdent")
    {
        ECT_APPEND(xml, idents, slot->ident_count, ident);
        *ident = (uint32_t)ect_esi_value(xml, child, 0, UINT32_MAX);
        if (ect_esi_flag(xml, child, "Default"))
            slot->preset = *ident;
    }
    ECT_ESI_EACH(child, node, "ModuleClass")
    {
        const xmlNode *name = ect_esi_child(child, "Class");
        ECT_APPEND(xml, classes, slot->class_count, module_class);
        *module_class = ect_esi_text(xml, name != NULL ? name : child);
    }
    slot->idents = idents;
    slot->classes = classes;
}

static void read_pdo_groups(ect_esi_xml_t *xml, const xmlNode *slots, ect_esi_device_t *device)
{
    enum { ALIGNMENT_MOST = 16 /* bytes; more than any alignment of modules */ };
    ect_esi_pdo_group_t *groups = NULL;
    ect_esi_pdo_group_t *group;
    ECT_ESI_EACH(node, slots, "ModulePdoGroup")
    {
        ECT_APPEND(xml, groups, device->pdo_group_count, group);
        const int64_t bytes = ect_esi_attribute_number(xml, node, "Alignment", INT32_MIN, INT32_MAX, 0);
        group->alignment = (uint8_t)(bytes > 0 && bytes <= ALIGNMENT_MOST ? bytes : 0);
        group->rx = (uint16_t)ect_esi_attribute_number(xml, node, "RxPdo", 0, UINT16_MAX, 0);
        group->tx = (uint16_t)ect_esi_attribute_number(xml, node, "TxPdo", 0, UINT16_MAX, 0);
    }
    device->pdo_groups = groups;
}

/* @return `ModulePdoGroup` of a `<Type>`, from 1; 0: none */
static uint32_t pdo_group_of(ect_esi_xml_t *xml, const xmlNode *type)
{
    return (uint32_t)(ect_esi_attribute_number(xml, type, "ModulePdoGroup", -1, INT32_MAX, -1) + 1);
}

static void read_slots(ect_esi_xml_t *xml, const xmlNode *node, ect_esi_device_t *device)
{
    if (node == NULL)
        return;
    ect_esi_slot_t *slots = NULL;
    ect_esi_slot_t *slot;
    device->slots_max = (uint32_t)ect_esi_attribute_number(xml, node, "MaxSlotCount", 0, UINT16_MAX, 0);
    device->slot_pdo_increment = (uint32_t)ect_esi_attribute_number(xml, node, "SlotPdoIncrement", 0, UINT16_MAX, 0);
    device->slot_index_increment =
        (uint32_t)ect_esi_attribute_number(xml, node, "SlotIndexIncrement", 0, UINT16_MAX, 0);
    device->group_pdo_increment =
        (uint32_t)ect_esi_attribute_number(xml, node, "SlotGroupPdoIncrement", 0, UINT16_MAX, 0);
    device->group_index_increment =
        (uint32_t)ect_esi_attribute_number(xml, node, "SlotGroupIndexIncrement", 0, UINT16_MAX, 0);
    device->download_idents = ect_esi_flag(xml, node, "DownloadModuleIdentList");
    device->download_addresses = ect_esi_flag(xml, node, "DownloadModuleAddressList");
    read_pdo_groups(xml, node, device);
    ECT_ESI_EACH(child, node, "Slot")
    {
        ECT_APPEND(xml, slots, device->slot_count, slot);
        read_slot(xml, child, device, slot);
    }
    device->slots = slots;
}

static uint32_t read_profile(ect_esi_xml_t *xml, const xmlNode *profile)
{
    uint32_t number = (uint32_t)ect_esi_number(xml, profile, "ProfileNo", 0, UINT16_MAX, 0);
    return number | (uint32_t)ect_esi_number(xml, profile, "AddInfo", 0, UINT16_MAX, 0) << 16;
}

static void read_modules(ect_esi_xml_t *xml, const xmlNode *node, ect_esi_device_t *device)
{
    ect_esi_module_t *modules = NULL;
    ect_esi_module_t *module;
    ECT_ESI_EACH(child, node, "Module")
    {
        const xmlNode *type = ect_esi_child(child, "Type");
        if (type == NULL)
            continue; // without an ident no slot can refer to the module
        ECT_APPEND(xml, modules, device->module_count, module);
        module->ident = (uint32_t)ect_esi_attribute_number(xml, type, "ModuleIdent", 0, UINT32_MAX, 0);
        module->module_class = ect_esi_attribute(xml, type, "ModuleClass");
        module->type = ect_esi_text(xml, type);
        module->pdo_group = pdo_group_of(xml, type);
        const xmlNode *profile = ect_esi_child(child, "Profile");
        module->profile = profile != NULL ? read_profile(xml, profile) : 0;
        module->name = ect_esi_name(xml, child, "Name");
        module->line = ect_esi_line(child);
        module->pdos = ect_esi_read_pdos(xml, child, &module->pdo_count);
        module->inits = read_inits(xml, ect_esi_child(ect_esi_child(child, "Mailbox"), "CoE"), &module->init_count);
        ect_esi_read_dictionary(xml, profile, &module->dictionary);
    }
    device->modules = modules;
}

static const char *group_name(ect_esi_xml_t *xml, const xmlNode *descriptions, const char *type)
{
    ECT_ESI_EACH(group, ect_esi_child(descriptions, "Groups"), "Group")
    {
        if (strcmp(ect_esi_text(xml, ect_esi_child(group, "Type")), type) == 0)
            return ect_esi_name(xml, group, "Name");
    }
    return "";
}

static void read_identity(ect_esi_xml_t *xml, const xmlNode *root, const xmlNode *node, ect_esi_device_t *device)
{
    const xmlNode *vendor = ect_esi_child(root, "Vendor");
    const xmlNode *type = ect_esi_child(node, "Type"); // it exists: read_heads() checks this
    device->vendor_id = (uint32_t)ect_esi_number(xml, vendor, "Id", INT32_MIN, UINT32_MAX, 0);
    device->vendor_name = ect_esi_name(xml, vendor, "Name");
    device->type = ect_esi_text(xml, type);
    device->product_code = (uint32_t)ect_esi_attribute_number(xml, type, "ProductCode", 0, UINT32_MAX, 0);
    device->revision = (uint32_t)ect_esi_attribute_number(xml, type, "RevisionNo", 0, UINT32_MAX, 0);
    device->lrd_lwr = ect_esi_flag(xml, type, "UseLrdLwr");
    device->name = ect_esi_name(xml, node, "Name");
    device->group_type = ect_esi_text(xml, ect_esi_child(node, "GroupType"));
    device->group_name = group_name(xml, ect_esi_child(root, "Descriptions"), device->group_type);
    device->physics = ect_esi_attribute(xml, node, "Physics");
    device->line = ect_esi_line(node);
    if (ect_esi_child(vendor, "Id") == NULL)
        ect_esi_fail(xml, vendor != NULL ? vendor : root, "there is no Vendor with an Id");
}

ect_esi_device_t *ect_esi_read_device(ect_esi_xml_t *xml, const xmlNode *root, const xmlNode *node)
{
    ect_esi_device_t *device = ect_arena_alloc(xml->arena, sizeof *device);
    read_identity(xml, root, node, device);
    read_info(xml, ect_esi_child(node, "Info"), device);
    read_alternatives(xml, ect_esi_child(node, "Info"), device);
    read_fmmus(xml, node, device);
    read_sms(xml, node, device);
    device->pdos = ect_esi_read_pdos(xml, node, &device->pdo_count);
    read_mailbox(xml, ect_esi_child(node, "Mailbox"), &device->mailbox);
    read_dcs(xml, ect_esi_child(node, "Dc"), device);
    read_eeprom(xml, ect_esi_child(node, "Eeprom"), device);
    device->dictionary_file = "";
    ECT_ESI_EACH(profile, node, "Profile")
    {
        ect_esi_read_profile(xml, profile, device);
        if (device->profile == 0)
            device->profile = read_profile(xml, profile);
    }
    device->pdo_group = pdo_group_of(xml, ect_esi_child(node, "Type"));
    read_slots(xml, ect_esi_child(node, "Slots"), device);
    if (device->slot_count > 0)
        read_modules(xml, ect_esi_child(ect_esi_child(root, "Descriptions"), "Modules"), device);
    return device;
}
