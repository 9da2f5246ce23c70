/* SPDX-License-Identifier: MIT */
/* A slave of an ENI. */
#include "eni/internal.h"

#include <stdio.h>
#include <string.h>

#include "esc/route.h"
#include "wire/registers.h"

enum { PORT_A = 'A', PORT_D = 'D' };

/* An identity: xs:int in the schema, so a large one may be negative. */
static uint32_t identity(ect_esi_xml_t *xml, const xmlNode *info, const char *name, bool required)
{
    if (required && ect_esi_child(info, name) == NULL)
        ect_esi_fail(xml, info, "Config/Slave/Info has no %s", name);
    return (uint32_t)ect_esi_number(xml, info, name, INT32_MIN, UINT32_MAX, 0);
}

static void read_info(ect_esi_xml_t *xml, const xmlNode *info, ect_eni_slave_t *slave)
{
    const xmlNode *identification = ect_esi_child(info, "Identification");
    slave->name = ect_esi_name(xml, info, "Name");
    slave->address = (uint16_t)ect_esi_number(xml, info, "PhysAddr", 0, UINT16_MAX, 0);
    slave->place = ect_esi_optional(xml, info, "AutoIncAddr");
    slave->physics = ect_esi_text(xml, ect_esi_child(info, "Physics"));
    slave->vendor_id = identity(xml, info, "VendorId", true);
    slave->product_code = identity(xml, info, "ProductCode", true);
    slave->revision = identity(xml, info, "RevisionNo", true);
    slave->serial = identity(xml, info, "SerialNo", false);
    if (identification == NULL)
        return;
    slave->identification.given = *ect_esi_attribute(xml, identification, "Value") != '\0';
    slave->identification.value = ect_esi_attribute_number(xml, identification, "Value", 0, UINT16_MAX, 0);
    slave->identification_ado = (uint16_t)ect_esi_number(xml, identification, "Ado", 0, UINT16_MAX, 0);
}

/* --- process data ------------------------------------------------------------------------------------------------- */

static const ect_eni_bits_t *read_bits(ect_esi_xml_t *xml, const xmlNode *parent, const char *name, size_t *count)
{
    ect_eni_bits_t *list = NULL;
    ect_eni_bits_t *bits;
    ECT_ESI_EACH(node, parent, name)
    {
        ECT_APPEND(xml, list, *count, bits);
        bits->start = (uint32_t)ect_esi_number(xml, node, "BitStart", 0, UINT32_MAX, 0);
        bits->length = (uint32_t)ect_esi_number(xml, node, "BitLength", 0, UINT32_MAX, 0);
    }
    return list;
}

static void read_sm(ect_esi_xml_t *xml, const xmlNode *node, ect_eni_sm_t *sm)
{
    uint16_t *pdos = NULL;
    uint16_t *pdo;
    sm->given = true;
    sm->type = ect_esi_text(xml, ect_esi_child(node, "Type"));
    sm->minimum = (uint16_t)ect_esi_number(xml, node, "MinSize", 0, UINT16_MAX, 0);
    sm->maximum = (uint16_t)ect_esi_number(xml, node, "MaxSize", 0, UINT16_MAX, 0);
    sm->size.given = ect_esi_child(node, "DefaultSize") != NULL;
    sm->size.value = ect_esi_number(xml, node, "DefaultSize", 0, UINT16_MAX, 0);
    sm->start = (uint16_t)ect_esi_number(xml, node, "StartAddress", 0, UINT16_MAX, 0);
    sm->control = (uint8_t)ect_esi_number(xml, node, "ControlByte", 0, UINT8_MAX, 0);
    sm->line = ect_esi_line(node);
    ECT_ESI_EACH(child, node, "Pdo")
    {
        ECT_APPEND(xml, pdos, sm->pdo_count, pdo);
        *pdo = (uint16_t)ect_esi_value(xml, child, 0, UINT16_MAX);
    }
    sm->pdos = pdos;
}

static void read_process_data(ect_esi_xml_t *xml, const xmlNode *data, ect_eni_slave_t *slave)
{
    slave->sends = read_bits(xml, data, "Send", &slave->send_count);
    slave->receives = read_bits(xml, data, "Recv", &slave->receive_count);
    for (unsigned int n = 0; n < sizeof slave->sms / sizeof slave->sms[0]; n++) {
        char name[8];
        (void)snprintf(name, sizeof name, "Sm%u", n);
        slave->sms[n].type = "";
        if (ect_esi_child(data, name) != NULL)
            read_sm(xml, ect_esi_child(data, name), &slave->sms[n]);
    }
    slave->pdos = ect_esi_read_pdos(xml, data, &slave->pdo_count);
}

/* --- mailbox ------------------------------------------------------------------------------------------------------ */

static ect_eni_box_t read_box(ect_esi_xml_t *xml, const xmlNode *node)
{
    return (ect_eni_box_t){.start = (uint16_t)ect_esi_number(xml, node, "Start", 0, UINT16_MAX, 0),
                           .length = (uint16_t)ect_esi_number(xml, node, "Length", 0, UINT16_MAX, 0)};
}

/* The sample of SOEM has `<Receive>`. */
static const xmlNode *receive_of(const xmlNode *mailbox)
{
    const xmlNode *node = ect_esi_child(mailbox, "Recv");
    return node != NULL ? node : ect_esi_child(mailbox, "Receive");
}

/* @return whether the file names the protocol, or has an element for it */
static bool speaks(ect_esi_xml_t *xml, const xmlNode *mailbox, const char *protocol)
{
    ECT_ESI_EACH(node, mailbox, "Protocol")
    {
        if (strcmp(ect_esi_text(xml, node), protocol) == 0)
            return true;
    }
    return ect_esi_child(mailbox, protocol) != NULL;
}

/* The commands are in `<InitCmds>`, in some files in the protocol's element itself. */
static const xmlNode *commands_of(const xmlNode *mailbox, const char *protocol)
{
    const xmlNode *node = ect_esi_child(mailbox, protocol);
    return ect_esi_child(node, "InitCmds") != NULL ? ect_esi_child(node, "InitCmds") : node;
}

/* A command without a mail of its protocol is only counted, one of FoE too. */
static void read_mails(ect_esi_xml_t *xml, const xmlNode *node, ect_eni_mailbox_t *mailbox)
{
    static const struct {
        const char *name;
        uint8_t protocol;
    } protocols[] = {{"AoE", ECT_MAILBOX_TYPE_AOE},
                     {"EoE", ECT_MAILBOX_TYPE_EOE},
                     {"SoE", ECT_MAILBOX_TYPE_SOE},
                     {"FoE", ECT_MAILBOX_TYPE_FOE}};
    ect_eni_mail_t *mails = NULL;
    ect_eni_mail_t *mail;
    for (size_t i = 0; i < sizeof protocols / sizeof protocols[0]; i++) {
        ECT_ESI_EACH(init, commands_of(node, protocols[i].name), "InitCmd")
        {
            ECT_APPEND(xml, mails, mailbox->mail_count, mail);
            mail->protocol = protocols[i].protocol;
            const bool complete = ect_eni_read_mail(xml, init, mail);
            mailbox->mail_count -= complete ? 0 : 1;
            mailbox->others += complete && mail->protocol != ECT_MAILBOX_TYPE_FOE ? 0 : 1;
        }
    }
    mailbox->mails = mails;
}

static void read_mailbox(ect_esi_xml_t *xml, const xmlNode *node, ect_eni_mailbox_t *mailbox)
{
    ect_eni_coe_t *commands = NULL;
    ect_eni_coe_t *command;
    const xmlNode *receive = receive_of(node), *boot = ect_esi_child(node, "BootStrap");
    mailbox->given = true;
    mailbox->data_link_layer = ect_esi_flag(xml, node, "DataLinkLayer");
    mailbox->send = read_box(xml, ect_esi_child(node, "Send"));
    mailbox->receive = read_box(xml, receive);
    mailbox->boot_send = read_box(xml, ect_esi_child(boot, "Send"));
    mailbox->boot_receive = read_box(xml, receive_of(boot));
    mailbox->status_bit = ect_esi_optional(xml, receive, "StatusBitAddr");
    mailbox->aoe = speaks(xml, node, "AoE");
    mailbox->eoe = speaks(xml, node, "EoE");
    mailbox->coe = speaks(xml, node, "CoE");
    mailbox->foe = speaks(xml, node, "FoE");
    mailbox->soe = speaks(xml, node, "SoE");
    mailbox->voe = speaks(xml, node, "VoE");
    ECT_ESI_EACH(init, commands_of(node, "CoE"), "InitCmd")
    {
        ECT_APPEND(xml, commands, mailbox->command_count, command);
        ect_eni_read_coe(xml, init, command);
    }
    mailbox->commands = commands;
    read_mails(xml, node, mailbox);
}

/* ------------------------------------------------------------------------------------------------------------------ */

static void read_previous(ect_esi_xml_t *xml, const xmlNode *parent, ect_eni_previous_t *previous)
{
    const xmlNode *chosen = ect_esi_child(parent, "PreviousPort");
    ECT_ESI_EACH(node, parent, "PreviousPort")
    {
        if (ect_esi_flag(xml, node, "Selected"))
            chosen = node;
    }
    if (chosen == NULL)
        return;
    const char *port = ect_esi_text(xml, ect_esi_child(chosen, "Port"));
    previous->given = true;
    previous->address = (uint16_t)ect_esi_number(xml, chosen, "PhysAddr", 0, UINT16_MAX, 0);
    previous->line = ect_esi_line(chosen);
    if (port[0] < PORT_A || port[0] > PORT_D || port[1] != '\0')
        ect_esi_fail(xml, chosen, "PreviousPort has the Port \"%.20s\", not A to D", port);
    else
        previous->port = (uint8_t)(port[0] - PORT_A);
}

/* Without Identification, a command may identify the slave: by the value that it expects in the alias (0012h) or in the
 * AL status code (0134h). */
static void read_identify(ect_esi_xml_t *xml, const xmlNode *hot, ect_eni_slave_t *slave)
{
    ECT_ESI_EACH(node, hot, "IdentifyCmd")
    {
        ect_eni_command_t command = {.counter = -1};
        ect_eni_read_command(xml, node, &command);
        const ect_esi_bytes_t *data = &command.validate.data;
        const bool reads = command.command == ECT_APRD || command.command == ECT_FPRD || command.command == ECT_BRD;
        const bool of_identity = command.ado == ECT_REG_STATION_ALIAS || command.ado == ECT_REG_AL_STATUS_CODE;
        if (!reads || !of_identity || data->length == 0 || slave->identification.given)
            continue;
        slave->identification.given = true;
        slave->identification.value = data->bytes[0] | (data->length > 1 ? data->bytes[1] << 8 : 0);
        slave->identification_ado = command.ado;
    }
}

void ect_eni_read_slave(ect_esi_xml_t *xml, const xmlNode *node, ect_eni_slave_t *slave)
{
    const xmlNode *info = ect_esi_child(node, "Info"), *clock = ect_esi_child(node, "DC");
    const xmlNode *mailbox = ect_esi_child(node, "Mailbox"), *hot = ect_esi_child(node, "HotConnect");
    slave->line = ect_esi_line(node);
    if (info == NULL) {
        ect_esi_fail(xml, node, "Config/Slave has no Info");
        return;
    }
    read_info(xml, info, slave);
    read_process_data(xml, ect_esi_child(node, "ProcessData"), slave);
    if (mailbox != NULL)
        read_mailbox(xml, mailbox, &slave->mailbox);
    slave->commands = ect_eni_read_inits(xml, node, &slave->command_count);
    read_previous(xml, node, &slave->previous);
    slave->group = hot != NULL ? ect_esi_name(xml, hot, "GroupName") : NULL;
    slave->members = (unsigned int)ect_esi_number(xml, hot, "GroupMemberCnt", 1, ECT_ENI_SLAVES, 1);
    if (hot != NULL)
        read_identify(xml, hot, slave);
    slave->clocked = clock != NULL;
    slave->cycle0_ns = ect_esi_number(xml, clock, "CycleTime0", INT32_MIN, UINT32_MAX, 0);
    slave->cycle1_ns = ect_esi_number(xml, clock, "CycleTime1", INT32_MIN, UINT32_MAX, 0);
    slave->shift_ns = ect_esi_number(xml, clock, "ShiftTime", INT32_MIN, UINT32_MAX, 0);
}
