/* SPDX-License-Identifier: MIT */
/* Commands of an ENI: datagrams, and mails at the start. */
#include "eni/internal.h"

#include <string.h>

#include "esc/route.h"

/* Reads the bits of the words in all children with a name. */
static unsigned int bits_of(ect_esi_xml_t *xml, const xmlNode *parent, const char *name, const char *const *words,
                            size_t count)
{
    unsigned int bits = 0;
    ECT_ESI_EACH(node, parent, name)
    {
        const char *text = ect_esi_text(xml, node);
        size_t i = 0;
        while (i < count && strcmp(text, words[i]) != 0)
            i++;
        if (i == count)
            ect_esi_fail(xml, node, "%s has the invalid value \"%.20s\"", name, text);
        else
            bits |= 1u << i;
    }
    return bits;
}

unsigned int ect_eni_transitions(ect_esi_xml_t *xml, const xmlNode *node)
{
    static const char *const words[] = {"II", "IP", "PP", "PO", "PS", "PI", "SS", "SP",
                                        "SO", "SI", "OS", "OP", "OI", "IB", "BI"};
    return bits_of(xml, node, "Transition", words, sizeof words / sizeof words[0]);
}

static unsigned int states_of(ect_esi_xml_t *xml, const xmlNode *node)
{
    static const char *const words[] = {"INIT", "PREOP", "SAFEOP", "OP"};
    return bits_of(xml, node, "State", words, sizeof words / sizeof words[0]);
}

/* Reads a flag given as an element. */
static bool says_true(ect_esi_xml_t *xml, const xmlNode *parent, const char *name)
{
    const char *text = ect_esi_text(xml, ect_esi_child(parent, name));
    return strcmp(text, "1") == 0 || strcmp(text, "true") == 0;
}

static ect_eni_compare_t compare_of(ect_esi_xml_t *xml, const xmlNode *node)
{
    static const char *const words[] = {"EQ", "NOT_EQ", "G", "L", "EQ_OR_G", "EQ_OR_L", "NONE"};
    const char *text = ect_esi_attribute(xml, node, "Type");
    for (size_t i = 0; i < sizeof words / sizeof words[0]; i++) {
        if (strcmp(text, words[i]) == 0)
            return (ect_eni_compare_t)i;
    }
    if (*text != '\0')
        ect_esi_fail(xml, node, "Validate has the invalid Type \"%.20s\"", text);
    return ECT_ENI_EQ;
}

static void read_validate(ect_esi_xml_t *xml, const xmlNode *node, size_t most, ect_eni_validate_t *validate)
{
    validate->given = true;
    validate->compare = compare_of(xml, node);
    validate->is_signed = ect_esi_flag(xml, node, "Signed");
    validate->data = ect_esi_hex(xml, node, "Data");
    validate->mask = ect_esi_hex(xml, node, "DataMask");
    validate->timeout_ms = (uint32_t)ect_esi_number(xml, node, "Timeout", 0, UINT32_MAX, 0);
    if (validate->data.length > most)
        ect_esi_fail(xml, node, "Validate has %zu bytes, more than the command, which has %zu", validate->data.length,
                     most);
    else if (validate->mask.bytes != NULL && validate->mask.length != validate->data.length)
        ect_esi_fail(xml, node, "DataMask has %zu bytes, Data of Validate %zu", validate->mask.length,
                     validate->data.length);
}

static void read_address(ect_esi_xml_t *xml, const xmlNode *node, ect_eni_command_t *command)
{
    bool logical = command->command >= ECT_LRD && command->command <= ECT_LRW;
    bool has_logical = ect_esi_child(node, "Addr") != NULL;
    bool has_physical = ect_esi_child(node, "Ado") != NULL || ect_esi_child(node, "Adp") != NULL;
    command->adp = (uint16_t)ect_esi_number(xml, node, "Adp", INT16_MIN, UINT16_MAX, 0);
    command->ado = (uint16_t)ect_esi_number(xml, node, "Ado", 0, UINT16_MAX, 0);
    command->address = (uint32_t)ect_esi_number(xml, node, "Addr", INT32_MIN, UINT32_MAX, 0);
    if (logical && (has_physical || !has_logical))
        ect_esi_fail(xml, node, "Cmd %u has a logical address: Addr, without Adp and Ado", command->command);
    else if (!logical && command->command != 0 && (has_logical || ect_esi_child(node, "Ado") == NULL))
        ect_esi_fail(xml, node, "Cmd %u has no logical address: Adp and Ado, without Addr", command->command);
}

static void read_data(ect_esi_xml_t *xml, const xmlNode *node, ect_esi_bytes_t *data)
{
    static const uint8_t zeros[ECT_ENI_DATA]; /* shared: a small file may have a million of these commands */
    *data = ect_esi_hex(xml, node, "Data");
    const xmlNode *length = ect_esi_child(node, "DataLength");
    if (length == NULL) {
        if (data->length > ECT_ENI_DATA)
            ect_esi_fail(xml, node, "Data has %zu bytes; a frame takes %d", data->length, (int)ECT_ENI_DATA);
        return;
    }
    if (data->bytes != NULL)
        ect_esi_fail(xml, length, "Data and DataLength exclude each other");
    data->length = (size_t)ect_esi_value(xml, length, 0, ECT_ENI_DATA);
    data->bytes = zeros;
}

static void read_copies(ect_esi_xml_t *xml, const xmlNode *node, ect_eni_command_t *command)
{
    ect_eni_copy_t *copies = NULL;
    ect_eni_copy_t *copy;
    ECT_ESI_EACH(child, node, "CopyInfo")
    {
        ECT_APPEND(xml, copies, command->copy_count, copy);
        copy->source = (uint32_t)ect_esi_number(xml, child, "SrcBitOffs", 0, UINT32_MAX, 0);
        copy->target = (uint32_t)ect_esi_number(xml, child, "DstBitOffs", 0, UINT32_MAX, 0);
        copy->bits = (uint32_t)ect_esi_number(xml, child, "BitSize", 0, UINT32_MAX, 0);
        copy->line = ect_esi_line(child);
    }
    command->copies = copies;
}

void ect_eni_read_command(ect_esi_xml_t *xml, const xmlNode *node, ect_eni_command_t *command)
{
    command->transitions = ect_eni_transitions(xml, node);
    command->states = states_of(xml, node);
    command->before_slave = says_true(xml, node, "BeforeSlave");
    command->comment = ect_esi_name(xml, node, "Comment");
    command->command = (uint8_t)ect_esi_number(xml, node, "Cmd", 0, ECT_FRMW, 0);
    command->counter = (int)ect_esi_number(xml, node, "Cnt", 0, UINT16_MAX, -1);
    command->retries = (uint32_t)ect_esi_number(xml, node, "Retries", 0, UINT32_MAX, 0);
    command->input_offset = (uint32_t)ect_esi_number(xml, node, "InputOffs", 0, UINT32_MAX, 0);
    command->output_offset = (uint32_t)ect_esi_number(xml, node, "OutputOffs", 0, UINT32_MAX, 0);
    command->line = ect_esi_line(node);
    read_copies(xml, ect_esi_child(node, "CopyInfos"), command);
    if (ect_esi_child(node, "Cmd") == NULL)
        ect_esi_fail(xml, node, "%s has no Cmd", (const char *)node->name);
    read_address(xml, node, command);
    read_data(xml, node, &command->data);
    const xmlNode *validate = ect_esi_child(node, "Validate");
    if (validate != NULL)
        read_validate(xml, validate, command->data.length, &command->validate);
}

const ect_eni_command_t *ect_eni_read_inits(ect_esi_xml_t *xml, const xmlNode *parent, size_t *count)
{
    ect_eni_command_t *commands = NULL;
    ect_eni_command_t *command;
    ECT_ESI_EACH(node, ect_esi_child(parent, "InitCmds"), "InitCmd")
    {
        ECT_APPEND(xml, commands, *count, command);
        ect_eni_read_command(xml, node, command);
    }
    return commands;
}

/* Without an OpCode, a command with data writes. @return false: it neither reads nor writes an IDN */
static bool read_soe(ect_esi_xml_t *xml, const xmlNode *node, ect_eni_mail_t *mail)
{
    enum { LAST_DRIVE = 7, VALUE = 0x40 };
    const int usual = mail->data.length > 0 ? ECT_INIT_WRITES : ECT_INIT_READS;
    mail->type = (uint8_t)ect_esi_number(xml, node, "OpCode", 0, UINT8_MAX, usual);
    mail->drive = (uint8_t)ect_esi_number(xml, node, "DriveNo", 0, LAST_DRIVE, 0);
    mail->elements = (uint8_t)ect_esi_number(xml, node, "Elements", 0, UINT8_MAX, VALUE);
    mail->idn = (uint16_t)ect_esi_number(xml, node, "IDN", 0, UINT16_MAX, 0);
    return ect_esi_child(node, "IDN") != NULL && (mail->type == ECT_INIT_READS || mail->type == ECT_INIT_WRITES);
}

/* Without an OpCode, a command with data writes. @return false: it has no name of a file, or another operation */
static bool read_foe(ect_esi_xml_t *xml, const xmlNode *node, ect_eni_mail_t *mail)
{
    const int usual = mail->data.length > 0 ? ECT_ENI_FOE_WRITES : ECT_ENI_FOE_READS;
    mail->type = (uint8_t)ect_esi_number(xml, node, "OpCode", 0, UINT8_MAX, usual);
    mail->password = (uint32_t)ect_esi_number(xml, node, "Password", 0, UINT32_MAX, 0);
    mail->file = ect_esi_text(xml, ect_esi_child(node, "FileName"));
    return *mail->file != '\0' && (mail->type == ECT_ENI_FOE_READS || mail->type == ECT_ENI_FOE_WRITES);
}

bool ect_eni_read_mail(ect_esi_xml_t *xml, const xmlNode *node, ect_eni_mail_t *mail)
{
    enum { AMS_HEADER = 32, EOE_TYPES = 15 };
    mail->transitions = ect_eni_transitions(xml, node);
    mail->comment = ect_esi_name(xml, node, "Comment");
    mail->timeout_ms = (uint32_t)ect_esi_number(xml, node, "Timeout", 0, UINT32_MAX, 0);
    mail->data = ect_esi_hex(xml, node, "Data");
    mail->disabled = says_true(xml, node, "Disabled");
    mail->line = ect_esi_line(node);
    mail->file = "";
    if (mail->protocol == ECT_MAILBOX_TYPE_SOE)
        return read_soe(xml, node, mail);
    if (mail->protocol == ECT_MAILBOX_TYPE_FOE)
        return read_foe(xml, node, mail);
    mail->type = (uint8_t)ect_esi_number(xml, node, "Type", 0, EOE_TYPES, 0);
    return mail->protocol == ECT_MAILBOX_TYPE_AOE ? mail->data.length >= AMS_HEADER
                                                  : ect_esi_child(node, "Type") != NULL;
}

void ect_eni_read_coe(ect_esi_xml_t *xml, const xmlNode *node, ect_eni_coe_t *command)
{
    command->transitions = ect_eni_transitions(xml, node);
    command->comment = ect_esi_name(xml, node, "Comment");
    command->timeout_ms = (uint32_t)ect_esi_number(xml, node, "Timeout", 0, UINT32_MAX, 0);
    command->index = (uint16_t)ect_esi_number(xml, node, "Index", 0, UINT16_MAX, 0);
    command->subindex = (uint8_t)ect_esi_number(xml, node, "SubIndex", 0, UINT8_MAX, 0);
    command->complete = ect_esi_flag(xml, node, "CompleteAccess");
    command->data = ect_esi_hex(xml, node, "Data");
    command->download = command->data.length > 0;
    command->disabled = says_true(xml, node, "Disabled");
    command->line = ect_esi_line(node);
    if (ect_esi_child(node, "Index") == NULL)
        ect_esi_fail(xml, node, "InitCmd has no Index");
}
