/* SPDX-License-Identifier: MIT */
/* A slave of an ENI as the model of a device. */
#include <stdio.h>
#include <string.h>

#include "eni/bus.h"
#include "eni/internal.h"
#include "esc/route.h"
#include "esi/single.h"
#include "od/pdo.h"
#include "wire/bytes.h"
#include "wire/registers.h"

enum {
    SMS = 16,
    SM_BYTES = 8,
    FMMU_BYTES = 16,
    CONTROL_DIRECTION = 0x0C, /* bits of a SyncManager's control byte */
    CONTROL_WRITES = 0x04,    /* the master writes */
    SDO_INFO_MAILBOX = 34,    /* the shortest mailbox of a twin with SDO information */
    MAILBOX_OUT = 0x26,       /* control bytes if the file has none */
    MAILBOX_IN = 0x22,

    PDO_ASSIGNMENT = 0x1C10,
    PDO_ASSIGNMENT_END = 0x1C30,
    RXPDO = 0x1600,
    TXPDO = 0x1A00,
    TXPDO_END = 0x1C00,
};

typedef struct maker {
    ect_arena_t *arena;
    const ect_eni_slave_t *slave;
    ect_esi_device_t *device;
} maker_t;

/* --- SyncManagers ------------------------------------------------------------------------------------------------- */

/* @return the bytes that an InitCmd writes to the registers from `at` on, at least `length` bytes */
static const ect_eni_command_t *write_to(const ect_eni_slave_t *slave, unsigned int at, size_t length)
{
    for (size_t i = 0; i < slave->command_count; i++) {
        const ect_eni_command_t *command = &slave->commands[i];
        bool writes = (command->command == ECT_APWR || command->command == ECT_FPWR) && !ect_eni_is_of_boot(command);
        if (writes && command->ado <= at && at + length <= command->ado + command->data.length &&
            command->data.bytes[at - command->ado + length - 1] != 0)
            return command;
    }
    return NULL;
}

static const char *role_of(const maker_t *m, unsigned int n, uint8_t control)
{
    bool writes = (control & CONTROL_DIRECTION) == CONTROL_WRITES;
    if (n < 2 && m->slave->mailbox.given)
        return writes ? "MBoxOut" : "MBoxIn";
    return writes ? "Outputs" : "Inputs";
}

static void sm_of_file(const maker_t *m, unsigned int n, ect_esi_sm_t *sm)
{
    const ect_eni_sm_t *from = &m->slave->sms[n];
    sm->type =
        *from->type != '\0' ? ect_arena_copy(m->arena, from->type, strlen(from->type)) : role_of(m, n, from->control);
    sm->start = from->start;
    sm->control = from->control;
    sm->size = from->size;
    sm->minimum = from->minimum;
    sm->maximum = from->maximum;
    sm->line = from->line;
}

/* Derives a SyncManager that the file does not list from the registers that the master writes. @return false: none */
static bool sm_of_command(const maker_t *m, unsigned int n, ect_esi_sm_t *sm)
{
    const unsigned int at = ECT_REG_SM + SM_BYTES * n;
    const ect_eni_command_t *command = write_to(m->slave, at, SM_BYTES - 1); /* byte 6: enabled */
    if (command == NULL)
        return false;
    const uint8_t *bytes = command->data.bytes + (at - command->ado);
    sm->start = ect_load_le16(bytes);
    sm->size = (ect_esi_number_t){.given = true, .value = ect_load_le16(bytes + 2)};
    sm->control = bytes[4];
    sm->type = role_of(m, n, sm->control);
    sm->line = command->line;
    return true;
}

/* Completes a mailbox for which the file has only start and length. @return false: none */
static bool sm_of_mailbox(const maker_t *m, unsigned int n, ect_esi_sm_t *sm)
{
    const ect_eni_box_t *box = n == 0 ? &m->slave->mailbox.send : &m->slave->mailbox.receive;
    if (n > 1 || box->length == 0)
        return false;
    sm->type = n == 0 ? "MBoxOut" : "MBoxIn";
    sm->start = box->start;
    sm->size = (ect_esi_number_t){.given = true, .value = box->length};
    sm->control = n == 0 ? MAILBOX_OUT : MAILBOX_IN;
    sm->line = m->slave->line;
    return true;
}

/* @return PDO `n`, from 0, that a start-up command assigns; 0: none */
static uint16_t assigned(const ect_eni_coe_t *command, size_t n)
{
    const bool to_assignment =
        command->download && command->index >= PDO_ASSIGNMENT && command->index < PDO_ASSIGNMENT_END;
    const size_t at = command->complete ? (command->subindex == 0 ? 2u : 0u) + 2 * n : 2 * n;
    if (!to_assignment || (!command->complete && (command->subindex == 0 || n > 0)) || at + 2 > command->data.length)
        return 0;
    return ect_load_le16(command->data.bytes + at);
}

static bool is_output(uint16_t pdo)
{
    return pdo < TXPDO;
}

/* Places a SyncManager for which the file has only assigned PDOs after the mailboxes. @return false: none */
static bool sm_of_assignment(const maker_t *m, unsigned int n, ect_esi_sm_t *sm)
{
    enum { ALIGNMENT = 0x100, ROOM = 0x400, OUTPUTS = 0x64, INPUTS = 0x20 };
    const ect_eni_mailbox_t *mailbox = &m->slave->mailbox;
    const unsigned int send_end = (unsigned int)mailbox->send.start + mailbox->send.length;
    const unsigned int receive_end = (unsigned int)mailbox->receive.start + mailbox->receive.length;
    const unsigned int end = send_end > receive_end ? send_end : receive_end;
    for (size_t i = 0; n >= 2 && i < mailbox->command_count; i++) {
        const ect_eni_coe_t *command = &mailbox->commands[i];
        const uint16_t pdo = assigned(command, 0);
        if (pdo == 0 || command->index != PDO_ASSIGNMENT + n)
            continue;
        sm->start = (uint16_t)((end + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT + (n - 2) * ROOM);
        sm->size = (ect_esi_number_t){.given = true};
        sm->type = is_output(pdo) ? "Outputs" : "Inputs";
        sm->control = is_output(pdo) ? OUTPUTS : INPUTS;
        sm->line = command->line;
        return true;
    }
    return false;
}

static void make_sms(const maker_t *m)
{
    ect_esi_sm_t *sms = ect_arena_alloc(m->arena, SMS * sizeof *sms);
    for (unsigned int n = 0; n < SMS; n++) {
        bool known = m->slave->sms[n].given;
        sms[n].type = "";
        if (known)
            sm_of_file(m, n, &sms[n]);
        else
            known = sm_of_command(m, n, &sms[n]) || sm_of_mailbox(m, n, &sms[n]) || sm_of_assignment(m, n, &sms[n]);
        m->device->sm_count = known ? n + 1 : m->device->sm_count;
    }
    m->device->sms = sms;
}

/* --- process data ------------------------------------------------------------------------------------------------- */

/* @return the SyncManager that lists a PDO; -1: none */
static int lister_of(const ect_eni_slave_t *slave, uint16_t index)
{
    for (int n = 0; n < SMS; n++) {
        for (size_t i = 0; i < slave->sms[n].pdo_count; i++) {
            if (slave->sms[n].pdos[i] == index)
                return n;
        }
    }
    return -1;
}

static void copy_text(const maker_t *m, const char **text)
{
    *text = ect_arena_copy(m->arena, *text, strlen(*text));
}

/* Copies a text, because the model outlives the file. */
static void copy_pdo(const maker_t *m, const ect_esi_pdo_t *from)
{
    ect_esi_pdo_t *pdo = ect_esi_append_pdo(m->arena, m->device);
    ect_esi_entry_t *entries = ect_arena_alloc(m->arena, (from->entry_count + 1) * sizeof *entries);
    *pdo = *from;
    copy_text(m, &pdo->name);
    pdo->exclude = NULL;
    pdo->exclude_count = 0;
    pdo->entries = entries;
    for (size_t i = 0; i < from->entry_count; i++) {
        entries[i] = from->entries[i];
        copy_text(m, &entries[i].name);
        copy_text(m, &entries[i].type);
    }
    if (pdo->sm < 0)
        pdo->sm = lister_of(m->slave, pdo->index);
    if (pdo->sm >= (int)m->device->sm_count)
        pdo->sm = -1;
}

static bool has_pdo(const maker_t *m, uint16_t index)
{
    for (size_t i = 0; i < m->device->pdo_count; i++) {
        if (m->device->pdos[i].index == index)
            return true;
    }
    return false;
}

/* Adds the PDOs that start-up commands assign and the file does not describe, without entries. */
static void add_assigned(const maker_t *m)
{
    for (size_t i = 0; i < m->slave->mailbox.command_count; i++) {
        const ect_eni_coe_t *command = &m->slave->mailbox.commands[i];
        uint16_t index;
        for (size_t n = 0; (index = assigned(command, n)) != 0; n++) {
            if ((!ect_od_is_rxpdo(index) && !ect_od_is_txpdo(index)) || has_pdo(m, index))
                continue;
            *ect_esi_append_pdo(m->arena, m->device) =
                (ect_esi_pdo_t){.index = index,
                                .name = ect_arena_print(m->arena, "PDO %04X", (unsigned int)index),
                                .tx = !is_output(index),
                                .sm = -1,
                                .samples = 1,
                                .line = command->line};
        }
    }
}

static void make_fmmus(const maker_t *m)
{
    const char **fmmus = ect_arena_alloc(m->arena, 3 * sizeof *fmmus);
    if (m->slave->send_count > 0)
        fmmus[m->device->fmmu_count++] = "Outputs";
    if (m->slave->receive_count > 0)
        fmmus[m->device->fmmu_count++] = "Inputs";
    if (m->slave->mailbox.status_bit.given)
        fmmus[m->device->fmmu_count++] = "MBoxState";
    m->device->fmmus = fmmus;
}

/* --- mailbox ------------------------------------------------------------------------------------------------------ */

/* ESI files have no PP and SS. */
static const char *transitions_of(const maker_t *m, unsigned int bits)
{
    static const struct {
        unsigned int bit;
        const char *name;
    } known[] = {{ECT_ENI_IP, "IP"}, {ECT_ENI_PS, "PS"}, {ECT_ENI_SO, "SO"},
                 {ECT_ENI_SP, "SP"}, {ECT_ENI_OP, "OP"}, {ECT_ENI_OS, "OS"}};
    const char *text = "";
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++) {
        if ((bits & known[i].bit) != 0)
            text = ect_arena_print(m->arena, "%s%s%s", text, *text != '\0' ? " " : "", known[i].name);
    }
    return text;
}

static ect_esi_bytes_t copy_bytes(const maker_t *m, const ect_esi_bytes_t *from)
{
    uint8_t *bytes = ect_arena_alloc(m->arena, from->length);
    if (from->length > 0)
        memcpy(bytes, from->bytes, from->length);
    return (ect_esi_bytes_t){.bytes = bytes, .length = from->length};
}

static void copy_inits(const maker_t *m)
{
    const ect_eni_mailbox_t *from = &m->slave->mailbox;
    ect_esi_mailbox_t *mailbox = &m->device->mailbox;
    ect_esi_init_t *inits = ect_arena_alloc(m->arena, (from->command_count + 1) * sizeof *inits);
    for (size_t i = 0; i < from->command_count; i++) {
        const ect_eni_coe_t *command = &from->commands[i];
        uint16_t index = command->index;
        mailbox->pdo_assign |= command->download && index >= PDO_ASSIGNMENT && index < PDO_ASSIGNMENT_END;
        mailbox->pdo_config |= command->download && index >= RXPDO && index < TXPDO_END;
        mailbox->complete_access |= command->complete;
        inits[mailbox->init_count] = (ect_esi_init_t){.transitions = transitions_of(m, command->transitions),
                                                      .index = index,
                                                      .subindex = command->subindex,
                                                      .complete = command->complete,
                                                      .comment = command->comment,
                                                      .disabled = command->disabled,
                                                      .upload = !command->download,
                                                      .data = copy_bytes(m, &command->data),
                                                      .line = command->line};
        copy_text(m, &inits[mailbox->init_count++].comment);
    }
    mailbox->inits = inits;
}

/* Makes the bytes of a mail after its header from a request of FoE: the name ends with a zero, the file follows. */
static ect_esi_bytes_t foe_request(const maker_t *m, const ect_eni_mail_t *mail)
{
    const size_t name = strlen(mail->file) + 1, length = ECT_ENI_FOE_HEADER + name + mail->data.length;
    uint8_t *bytes = ect_arena_alloc(m->arena, length);
    bytes[0] = mail->type;
    ect_store_le32(bytes + 2, mail->password);
    memcpy(bytes + ECT_ENI_FOE_HEADER, mail->file, name);
    if (mail->data.length > 0)
        memcpy(bytes + ECT_ENI_FOE_HEADER + name, mail->data.bytes, mail->data.length);
    return (ect_esi_bytes_t){.bytes = bytes, .length = length};
}

/* Copies the mails. A device has at least the drives of its SoE commands. */
static void copy_mails(const maker_t *m)
{
    const ect_eni_mailbox_t *from = &m->slave->mailbox;
    ect_esi_mailbox_t *mailbox = &m->device->mailbox;
    ect_esi_mail_t *mails = ect_arena_alloc(m->arena, (from->mail_count + 1) * sizeof *mails);
    for (size_t i = 0; i < from->mail_count; i++) {
        const ect_eni_mail_t *mail = &from->mails[i];
        mails[i] = (ect_esi_mail_t){.transitions = transitions_of(m, mail->transitions),
                                    .comment = mail->comment,
                                    .protocol = mail->protocol,
                                    .type = mail->type,
                                    .drive = mail->drive,
                                    .elements = mail->elements,
                                    .idn = mail->idn,
                                    .disabled = mail->disabled,
                                    .data = mail->protocol == ECT_MAILBOX_TYPE_FOE ? foe_request(m, mail)
                                                                                   : copy_bytes(m, &mail->data),
                                    .line = mail->line};
        copy_text(m, &mails[i].comment);
        if (mail->protocol == ECT_MAILBOX_TYPE_SOE && mail->drive >= mailbox->soe_channels)
            mailbox->soe_channels = (uint8_t)(mail->drive + 1);
    }
    mailbox->mails = mails;
    mailbox->mail_count = from->mail_count;
}

static void make_mailbox(const maker_t *m)
{
    const ect_eni_mailbox_t *from = &m->slave->mailbox;
    if (!from->given)
        return;
    m->device->mailbox = (ect_esi_mailbox_t){.given = true,
                                             .data_link_layer = from->data_link_layer,
                                             .aoe = from->aoe,
                                             .eoe = from->eoe,
                                             .coe = from->coe || from->command_count > 0,
                                             .foe = from->foe,
                                             .soe = from->soe,
                                             .voe = from->voe,
                                             .sdo_info = from->send.length >= SDO_INFO_MAILBOX};
    copy_inits(m);
    copy_mails(m);
    if (from->boot_send.length == 0 || from->boot_receive.length == 0)
        return;
    uint8_t *boot = ect_arena_alloc(m->arena, 8);
    ect_store_le16(boot, from->boot_send.start);
    ect_store_le16(boot + 2, from->boot_send.length);
    ect_store_le16(boot + 4, from->boot_receive.start);
    ect_store_le16(boot + 6, from->boot_receive.length);
    m->device->bootstrap = (ect_esi_bytes_t){.bytes = boot, .length = 8};
}

/* ------------------------------------------------------------------------------------------------------------------ */

static void make_clock(const maker_t *m)
{
    const ect_eni_command_t *command = write_to(m->slave, ECT_REG_DC_CYCLIC_CONTROL, 2);
    if (!m->slave->clocked && command == NULL)
        return;
    ect_esi_dc_t *mode = ect_arena_alloc(m->arena, sizeof *mode);
    *mode = (ect_esi_dc_t){.name = "DC", .description = "DC"};
    if (command != NULL)
        mode->assign_activate =
            ect_load_le16(command->data.bytes + (ECT_REG_DC_CYCLIC_CONTROL - (unsigned int)command->ado));
    m->device->dcs = mode;
    m->device->dc_count = 1;
}

/* B and H are both ports of fast hot-connect; ESI files have H. */
static const char *physics_of(const maker_t *m)
{
    char *physics = ect_arena_copy(m->arena, m->slave->physics, strlen(m->slave->physics));
    for (char *port = strchr(physics, 'B'); port != NULL; port = strchr(port, 'B'))
        *port = 'H';
    return physics;
}

static void make_identity(const maker_t *m)
{
    const ect_eni_slave_t *slave = m->slave;
    ect_esi_device_t *device = m->device;
    device->vendor_id = slave->vendor_id;
    device->product_code = slave->product_code;
    device->revision = slave->revision;
    device->type = device->name = ect_arena_copy(m->arena, slave->name, strlen(slave->name));
    device->physics = physics_of(m);
    device->line = slave->line;
    device->identification_134 = slave->identification_ado == ECT_REG_AL_STATUS_CODE;
    device->identification_ado.given = slave->identification.given &&
                                       slave->identification_ado != ECT_REG_STATION_ALIAS &&
                                       !device->identification_134;
    device->identification_ado.value = slave->identification_ado;
}

ect_esi_t *ect_eni_device(const ect_eni_t *eni, size_t i, char *text, size_t room)
{
    ECT_ASSERT(i < ect_eni_network(eni)->slave_count);
    ect_esi_t *esi = ect_esi_single_begin(ect_eni_file(eni), text, room);
    if (esi == NULL)
        return NULL;
    maker_t m = {.slave = &ect_eni_network(eni)->slaves[i]};
    m.device = ect_esi_single_device(esi, &m.arena);
    make_identity(&m);
    make_sms(&m);
    for (size_t k = 0; k < m.slave->pdo_count; k++)
        copy_pdo(&m, &m.slave->pdos[k]);
    add_assigned(&m);
    make_fmmus(&m);
    make_mailbox(&m);
    make_clock(&m);
    ect_esi_single_end(esi, "ENI");
    return esi;
}
