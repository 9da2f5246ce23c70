/* SPDX-License-Identifier: MIT */
#include "esi/internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "check/check.h"
#include "sii/sii.h"
#include "wire/bytes.h"
#include "wire/sii.h"

/* Limits of the ESC: the registers of digital outputs, and 8 KB or 60 KB of RAM. */
enum {
    OUTPUT_REGISTERS = 0x0F00,
    RAM_START = 0x1000,
    RAM_END_SMALL = 0x3000,
    USUAL_EEPROM = 1024, /* default size, enlarged if the image needs more */
    LARGEST_EEPROM = 0xFF80
};

/* Limit of process data in one datagram of an Ethernet frame, bytes. */
enum { LONGEST_IMAGE = 1486 };

/* --- controller and layout --------------------------------------------------------------------------------------- */

static uint8_t role_of(const ect_esi_sm_t *sm)
{
    if (strcmp(sm->type, "MBoxOut") == 0)
        return ECT_SM_MAILBOX_OUT;
    if (strcmp(sm->type, "MBoxIn") == 0)
        return ECT_SM_MAILBOX_IN;
    if (strstr(sm->type, "Outputs") != NULL)
        return ECT_SM_OUTPUTS;
    return strstr(sm->type, "Inputs") != NULL ? ECT_SM_INPUTS : ECT_SM_UNUSED;
}

static bool has_protocols(const ect_esi_device_t *model)
{
    const ect_esi_mailbox_t *m = &model->mailbox;
    return m->aoe || m->eoe || m->coe || m->foe || m->soe || m->voe;
}

/* @return the largest size of a SyncManager's data, or each of its three buffers, before the next area */
static uint32_t gap_behind(const ect_build_t *build, size_t n)
{
    const ect_esi_sm_t *sms = build->model->sms;
    uint32_t next = 0x10000;
    for (size_t i = 0; i < build->model->sm_count; i++) {
        if (!sms[i].virtual_sm && sms[i].start > sms[n].start && sms[i].start < next)
            next = sms[i].start;
    }
    bool one_buffer = (sms[n].control & 3u) == 2;
    return (next - sms[n].start) / (one_buffer ? 1 : 3);
}

static uint32_t larger(uint32_t a, uint32_t b)
{
    return a > b ? a : b;
}

static uint32_t smaller(uint32_t a, uint32_t b)
{
    return a < b ? a : b;
}

/* @return the bytes of all telegrams of a direction with all values that they may contain; 0: no drives */
static uint32_t telegram_bytes(const ect_build_t *build, const ect_esi_sm_t *model)
{
    const bool tx = role_of(model) == ECT_SM_INPUTS;
    uint32_t bytes = 0;
    for (size_t i = 0; build->soe != NULL && i < build->soe->count; i++) {
        const ect_build_idn_t *idn = &build->soe->idns[i];
        if ((idn->row.flags & (tx ? ECT_SOE_IN_AT : ECT_SOE_IN_MDT)) != 0)
            bytes += ect_soe_width(idn->row.attribute);
    }
    return bytes > 0 ? bytes + 2u * build->soe->drives : 0;
}

/* @return the bytes of three buffers in a chip with 8 KB of memory */
static uint32_t in_ram(const ect_esi_sm_t *model)
{
    return model->start < RAM_END_SMALL ? (uint32_t)(RAM_END_SMALL - model->start) / 3 : 0;
}

/* @return whether a master may write any mapping or assignment, whatever the file's PdoAssign and PdoConfig announce */
static bool can_be_configured(const ect_build_t *build)
{
    for (size_t i = 0; i < build->object_count; i++) {
        const ect_build_object_t *object = &build->objects[i];
        bool assignment = object->index >= ECT_OD_ASSIGNMENT && object->index < ECT_OD_ASSIGNMENT + ECT_SMS;
        const ect_build_entry_t *count = ect_build_entry(object, 0);
        if ((assignment || ect_od_is_rxpdo(object->index) || ect_od_is_txpdo(object->index)) && count != NULL &&
            (count->access & ECT_ACCESS_WO) != 0)
            return true;
    }
    return false;
}

static void set_process_sm(ect_build_t *build, size_t n, ect_sm_t *sm)
{
    uint32_t now = (ect_build_assigned_bits(build, (int)n) + 7) / 8;
    uint32_t most = (ect_build_largest_bits(build, (int)n) + 7) / 8;
    const ect_esi_sm_t *model = &build->model->sms[n];
    if (build->model->mailbox.pdo_config || build->model->mailbox.pdo_assign || can_be_configured(build)) {
        /* MaxSize is optional; without a PDO there is nothing to map. */
        const uint32_t given = model->maximum != 0 || most == 0 ? model->maximum : in_ram(model);
        most = larger(most, larger(given, (uint32_t)model->size.value));
    }
    most = larger(most, smaller(telegram_bytes(build, model), in_ram(model)));
    most = larger(smaller(most, gap_behind(build, n)), now);
    if (now > LONGEST_IMAGE)
        ect_build_fail(build, "SyncManager %zu has %u bytes by default; a frame takes %u", n, (unsigned int)now,
                       (unsigned int)LONGEST_IMAGE);
    sm->maximum = (uint16_t)smaller(most, LONGEST_IMAGE);
}

static const uint16_t *virtual_pdos(const ect_build_t *build, int sm)
{
    uint16_t *indices = ect_arena_alloc(build->arena, (build->pdo_count + 1) * sizeof *indices);
    size_t count = 0;
    for (size_t i = 0; i < build->pdo_count; i++) {
        if (build->pdos[i].on_virtual && build->pdos[i].model->sm == sm)
            indices[count++] = build->pdos[i].index;
    }
    return indices;
}

static void set_mailbox_sm(ect_build_t *build, size_t n, ect_sm_t *sm)
{
    const ect_esi_sm_t *model = &build->model->sms[n];
    if (!has_protocols(build->model)) {
        ect_build_note(build, "line %d: SyncManager %zu is for a mailbox, and the device has none: it is unused",
                       model->line, n);
        sm->type = ECT_SM_UNUSED;
        return;
    }
    sm->length = (uint16_t)model->size.value;
    sm->minimum = model->minimum;
    uint32_t most = smaller(model->maximum, gap_behind(build, n));
    if (most > LONGEST_IMAGE) {
        ect_build_note(build, "line %d: a mailbox of %u bytes does not fit a frame; the twin's has at most %u",
                       model->line, (unsigned int)most, (unsigned int)LONGEST_IMAGE);
        most = LONGEST_IMAGE;
    }
    sm->maximum = (uint16_t)larger(most, sm->length);
}

static void set_sm(ect_build_t *build, size_t n, ect_sm_t *sm)
{
    ECT_ASSERT(n < ECT_SMS && n < build->model->sm_count);
    const ect_esi_sm_t *model = &build->model->sms[n];
    *sm = (ect_sm_t){.start = model->start, .control = model->control, .type = role_of(model), .flags = model->flags};
    if (model->virtual_sm) {
        sm->role = sm->type;
        sm->type = ECT_SM_UNUSED;
        sm->length = (uint16_t)((ect_build_assigned_bits(build, (int)n) + 7) / 8);
        sm->pdos = virtual_pdos(build, (int)n);
        return;
    }
    if (sm->type == ECT_SM_OUTPUTS || sm->type == ECT_SM_INPUTS) {
        set_process_sm(build, n, sm);
    } else if (sm->type != ECT_SM_UNUSED) {
        set_mailbox_sm(build, n, sm);
    }
    bool in_registers = sm->start >= OUTPUT_REGISTERS && sm->start < RAM_START;
    if (sm->start < RAM_START && !in_registers && sm->maximum > 0)
        ect_build_fail(build, "line %d: SyncManager %zu begins at 0x%04X, where there are registers", model->line, n,
                       (unsigned int)sm->start);
}

static void set_sms(ect_build_t *build, ect_device_t *device)
{
    size_t count = build->model->sm_count;
    if (count > ECT_SMS) {
        ect_build_fail(build, "it has %zu SyncManagers; the chips here have at most %u", count, (unsigned int)ECT_SMS);
        return;
    }
    device->sm_count = (uint8_t)count;
    for (size_t i = 0; i < count; i++)
        set_sm(build, i, &device->sm[i]);
}

static void set_fmmus(ect_build_t *build, ect_device_t *device)
{
    for (size_t i = 0; i < build->model->fmmu_count; i++) {
        const char *role = build->model->fmmus[i];
        uint8_t code = strcmp(role, "Outputs") == 0     ? ECT_FMMU_OUTPUTS
                       : strcmp(role, "Inputs") == 0    ? ECT_FMMU_INPUTS
                       : strcmp(role, "MBoxState") == 0 ? ECT_FMMU_MAILBOX_STATE
                                                        : ECT_FMMU_UNUSED;
        if (i < ECT_FMMUS)
            device->fmmu[device->fmmu_count++] = code;
        else
            ect_build_note(build, "it has %zu FMMUs; the twin has %u", build->model->fmmu_count,
                           (unsigned int)ECT_FMMUS);
    }
}

/* @return the smallest chip with enough memory */
static const char *esc_of(const ect_device_t *device)
{
    for (unsigned int i = 0; i < device->sm_count; i++) {
        const ect_sm_t *sm = &device->sm[i];
        uint32_t buffers = sm->type == ECT_SM_OUTPUTS || sm->type == ECT_SM_INPUTS ? 3 : 1;
        if (sm->type != ECT_SM_UNUSED && sm->start + buffers * sm->maximum > RAM_END_SMALL)
            return "ipcore";
    }
    return "et1100";
}

/* Replaces a missing text that a description requires. */
static const char *or_unnamed(const char *text)
{
    return *text != '\0' ? text : "unnamed";
}

/* --- mailbox, clocks, EEPROM ------------------------------------------------------------------------------------- */

/* Notes protocols of the file that the twin does not support: requests get the error "unsupported protocol". */
#define UNSERVED(name) {.type = ECT_MAILBOX_TYPE_##name, .states = ECT_IN_PREOP_AND_ABOVE}
static const ect_protocol_t aoe = UNSERVED(AOE), eoe = UNSERVED(EOE), foe = UNSERVED(FOE), soe = UNSERVED(SOE),
                            voe = UNSERVED(VOE);

static void add_protocol(ect_device_t *device, const ect_protocol_t **list, bool named, const ect_protocol_t *protocol)
{
    size_t count = 0;
    while (list[count] != NULL)
        count++;
    if (named)
        list[count] = protocol;
    device->protocols = list;
}

static void set_protocols(ect_build_t *build, ect_device_t *device)
{
    enum { MOST = 10 }; /* with room for one more by ect_esi_reported_set, and for the end */
    const ect_esi_mailbox_t *m = &build->model->mailbox;
    const ect_protocol_t **list = ect_arena_alloc(build->arena, MOST * sizeof *list);
    add_protocol(device, list, m->coe, &ect_protocol_emergency);
    add_protocol(device, list, m->coe, &ect_protocol_sdo);
    add_protocol(device, list, m->coe && m->sdo_info, &ect_protocol_sdo_info);
    const ect_protocol_t *ads = m->aoe ? ect_esi_ads(build, device) : NULL;
    add_protocol(device, list, m->aoe, ads ? ads : &aoe);
    add_protocol(device, list, m->foe, &foe);
    const ect_protocol_t *servo = m->soe ? ect_esi_servo(build, device) : NULL;
    add_protocol(device, list, m->soe, servo ? servo : &soe);
    add_protocol(device, list, m->voe, &voe);
    const ect_protocol_t *network = m->eoe ? ect_esi_network(build, device) : NULL;
    add_protocol(device, list, m->eoe, network ? network : &eoe);
}

static uint8_t protocols_of(const ect_esi_mailbox_t *m)
{
    return (uint8_t)((m->aoe ? ECT_MAILBOX_AOE : 0) | (m->eoe ? ECT_MAILBOX_EOE : 0) | (m->coe ? ECT_MAILBOX_COE : 0) |
                     (m->foe ? ECT_MAILBOX_FOE : 0) | (m->soe ? ECT_MAILBOX_SOE : 0) | (m->voe ? ECT_MAILBOX_VOE : 0));
}

static uint8_t coe_details_of(const ect_esi_mailbox_t *m)
{
    if (!m->coe)
        return 0;
    return (uint8_t)(ECT_COE_SDO | (m->sdo_info ? ECT_COE_SDO_INFO : 0) | (m->pdo_assign ? ECT_COE_PDO_ASSIGN : 0) |
                     (m->pdo_config ? ECT_COE_PDO_CONFIG : 0) | (m->pdo_upload ? ECT_COE_PDO_UPLOAD : 0) |
                     (m->complete_access ? ECT_COE_COMPLETE_ACCESS : 0));
}

static void note_unserved(ect_build_t *build, const ect_device_t *device)
{
    const ect_esi_mailbox_t *m = &build->model->mailbox;
    const bool servo = build->soe != NULL && build->soe->served;
    const uint8_t served = (uint8_t)(ECT_MAILBOX_COE | (build->network ? ECT_MAILBOX_EOE : 0) |
                                     (build->ads ? ECT_MAILBOX_AOE : 0) | (servo ? ECT_MAILBOX_SOE : 0));
    if ((device->mailbox_protocols & ~served) != 0)
        ect_build_note(build, "%s%s%s%s%sanswered with \"unsupported protocol\"", m->aoe && !build->ads ? "AoE " : "",
                       m->eoe && !build->network ? "EoE " : "", m->foe ? "FoE " : "", m->soe && !servo ? "SoE " : "",
                       m->voe ? "VoE " : "");
}

static void set_mailbox(ect_build_t *build, ect_device_t *device)
{
    const ect_esi_mailbox_t *m = &build->model->mailbox;
    device->mailbox_protocols = protocols_of(m);
    device->coe_details = coe_details_of(m);
    bool has_sms = device->sm[0].type == ECT_SM_MAILBOX_OUT && device->sm[1].type == ECT_SM_MAILBOX_IN;
    if (device->mailbox_protocols != 0 && !has_sms) {
        ect_build_note(build,
                       "it has mailbox protocols and no mailbox SyncManagers 0 and 1: the device has no mailbox");
        device->mailbox_protocols = 0;
        device->coe_details = 0;
    }
    if (device->mailbox_protocols != 0)
        set_protocols(build, device);
    note_unserved(build, device);
    if (build->model->dictionary_unread != NULL)
        ect_build_note(build, "the dictionary in the file %s is not read%s%s", build->model->dictionary_file,
                       *build->model->dictionary_unread != '\0' ? ": " : "", build->model->dictionary_unread);
}

static void set_general(const ect_esi_device_t *model, ect_device_t *device)
{
    device->general_flags = (uint8_t)(ECT_GENERAL_GIVEN | (model->lrd_lwr ? ECT_GENERAL_NO_LRW : 0) |
                                      (model->mailbox.data_link_layer ? ECT_GENERAL_MAIL_REPEAT : 0) |
                                      (model->identification_134 ? ECT_GENERAL_ID_AL_STATUS : 0) |
                                      (model->identification_ado.given ? ECT_GENERAL_ID_MEMORY : 0));
    device->id_address = (uint16_t)model->identification_ado.value;
    const uint8_t channels = model->mailbox.soe_channels;
    device->soe_channels = channels < ECT_SOE_DRIVES ? channels : (uint8_t)ECT_SOE_DRIVES;
}

static void set_boot(const ect_esi_device_t *model, ect_device_t *device)
{
    enum { BYTES = 8 };
    const bool in_image = model->bootstrap.bytes == NULL && model->eeprom.length >= ECT_SII_CATEGORIES;
    const uint8_t *b = in_image ? model->eeprom.bytes + ECT_SII_AT_BOOT_OUT : model->bootstrap.bytes;
    if ((!in_image && model->bootstrap.length != BYTES) || (b[2] | b[3]) == 0)
        return;
    device->boot_out = (ect_boot_mailbox_t){(uint16_t)(b[0] | b[1] << 8), (uint16_t)(b[2] | b[3] << 8)};
    device->boot_in = (ect_boot_mailbox_t){(uint16_t)(b[4] | b[5] << 8), (uint16_t)(b[6] | b[7] << 8)};
}

static void set_dc(ect_build_t *build, ect_device_t *device)
{
    const ect_esi_device_t *model = build->model;
    size_t count = model->dc_count < UINT8_MAX ? model->dc_count : UINT8_MAX;
    ect_dc_mode_t *modes = ect_arena_alloc(build->arena, (count + 1) * sizeof *modes);
    for (size_t i = 0; i < count; i++) {
        const ect_esi_dc_t *dc = &model->dcs[i];
        modes[i] = (ect_dc_mode_t){
            .name = ect_build_text(build, or_unnamed(dc->name), ECT_BUILD_TEXT),
            .description = ect_build_text(build, dc->description, ECT_BUILD_TEXT),
            .assign_activate = dc->assign_activate,
            .cycle_sync0_ns = (uint32_t)dc->cycle_sync0_ns,
            .factor_sync0 = (int16_t)dc->sync0_factor,
            .factor_sync1 = (int16_t)dc->sync1_factor,
            .shift_sync0_ns = (int32_t)dc->shift_sync0_ns,
            .shift_sync1_ns = (int32_t)dc->shift_sync1_ns,
        };
    }
    device->dc_modes = modes;
    device->dc_mode_count = (uint8_t)count;
}

static void set_eeprom(ect_build_t *build, ect_device_t *device)
{
    const ect_esi_device_t *model = build->model;
    size_t length = model->config.length < sizeof device->esc_config ? model->config.length : sizeof device->esc_config;
    if (length > 0)
        memcpy(device->esc_config, model->config.bytes, length);
    uint32_t size = larger(model->eeprom_size, (uint32_t)model->eeprom.length);
    size = size > 0 ? (size + 127) / 128 * 128 : USUAL_EEPROM;
    if (size > LARGEST_EEPROM) {
        ect_build_note(build, "its EEPROM has %u bytes; the twin's has %u", (unsigned int)size,
                       (unsigned int)LARGEST_EEPROM);
        size = LARGEST_EEPROM;
    }
    device->sii_size = (uint16_t)size;
    if (model->eeprom.bytes == NULL)
        return;
    uint8_t *image = ect_arena_alloc(build->arena, size);
    memset(image, 0xFF, size);
    memcpy(image, model->eeprom.bytes, model->eeprom.length < size ? model->eeprom.length : size);
    device->sii = image;
}

/* Adds categories of the file, except those written from the description. */
static void set_categories(ect_build_t *build, ect_device_t *device)
{
    static const uint16_t own[] = {ECT_SII_STRINGS, ECT_SII_GENERAL, ECT_SII_FMMU, ECT_SII_SYNCM,
                                   ECT_SII_TXPDO,   ECT_SII_RXPDO,   ECT_SII_DC,   ECT_SII_END};
    const ect_esi_device_t *model = build->model;
    ect_category_t *categories = ect_arena_alloc(build->arena, (model->category_count + 1) * sizeof *categories);
    size_t count = 0;
    for (size_t i = 0; i < model->category_count && count < UINT8_MAX; i++) {
        const ect_esi_category_t *category = &model->categories[i];
        bool taken = category->data.length > LARGEST_EEPROM;
        for (size_t k = 0; k < sizeof own / sizeof own[0]; k++)
            taken = taken || own[k] == category->number;
        if (taken)
            ect_build_note(build, "line %d: category %u of the EEPROM is left out: its number or length is taken",
                           category->line, (unsigned int)category->number);
        else
            categories[count++] = (ect_category_t){
                .number = category->number, .length = (uint16_t)category->data.length, .data = category->data.bytes};
    }
    device->categories = categories;
    device->category_count = (uint8_t)count;
}

/* Omits parts without room in the EEPROM, with a note. Without a size in the file the EEPROM is enlarged. */
static bool fit_image(ect_build_t *build, ect_device_t *device, bool size_given)
{
    static const char *const parts[] = {
        [ECT_OMIT_ENTRY_NAMES] = "the names of PDO entries",
        [ECT_OMIT_PDO_NAMES] = "the names of PDOs and their entries",
        [ECT_OMIT_MODE_TEXTS] = "the names of PDOs, their entries and the modes of the clocks",
        [ECT_OMIT_FREE_PDOS] = "the unassigned PDOs, and all names of PDOs, entries and clock modes",
        [ECT_OMIT_PDOS] = "all PDOs, which the dictionary has, and the names of the clock modes",
    };
    uint8_t *image = malloc(device->sii_size);
    device->sii_omit = size_given ? ECT_OMIT_PDOS : ECT_OMIT_ENTRY_NAMES;
    ECT_ASSERT(device->sii_size >= ECT_SII_CATEGORIES); /* set_eeprom */
    int omitted = image != NULL ? ect_sii_omission(device, image) : -1;
    free(image);
    ECT_ASSERT(omitted < (int)(sizeof parts / sizeof parts[0]));
    if (omitted > 0)
        ect_build_note(build, "an EEPROM of %u bytes has no room for %s: left out", (unsigned int)device->sii_size,
                       parts[omitted]);
    return omitted >= 0;
}

/* Enlarges the EEPROM if omitting parts is not enough. */
static void fit_eeprom(ect_build_t *build, ect_device_t *device)
{
    uint16_t given = device->sii_size;
    bool size_given = build->model->eeprom_size > 0;
    while (!fit_image(build, device, size_given)) {
        if (device->sii_size > LARGEST_EEPROM / 2) {
            ect_build_fail(
                build, "its SII does not fit an EEPROM of %u bytes, or needs more than the 255 texts that it can have",
                (unsigned int)device->sii_size);
            return;
        }
        device->sii_size = (uint16_t)(2 * device->sii_size);
    }
    if (size_given && device->sii_size != given)
        ect_build_note(build, "its SII does not fit %u bytes; the twin's EEPROM has %u", (unsigned int)given,
                       (unsigned int)device->sii_size);
}

/* --- identity ---------------------------------------------------------------------------------------------------- */

/* @return a timeout of the file, or else the default of ETG.2000 */
static uint16_t timeout(uint32_t said_ms, uint16_t default_ms)
{
    return said_ms == 0 ? default_ms : (uint16_t)(said_ms < UINT16_MAX ? said_ms : UINT16_MAX);
}

/* One letter for each port; other characters are omitted. */
static const char *physics_of(ect_build_t *build)
{
    char ports[5] = "";
    size_t count = 0;
    for (const char *letter = build->model->physics; *letter != '\0'; letter++) {
        if (strchr("YKH ", *letter) != NULL && count < 4)
            ports[count++] = *letter;
        else
            ect_build_note(build, "its Physics \"%s\" is not Y, K and H for at most 4 ports", build->model->physics);
    }
    return count > 0 ? ect_arena_copy(build->arena, ports, count) : "YY";
}

/* @return a name in the style of built-in devices, for names of files */
static const char *command_name(ect_build_t *build, const char *type)
{
    char *name = ect_arena_alloc(build->arena, ECT_BUILD_NAME + 1);
    size_t length = 0;
    for (; *type != '\0' && length < ECT_BUILD_NAME; type++) {
        char plain = ect_build_plain(*type);
        if (plain != '\0')
            name[length++] = plain;
        else if (length > 0 && name[length - 1] != '-')
            name[length++] = '-';
    }
    while (length > 0 && name[length - 1] == '-')
        name[--length] = '\0';
    return length > 0 ? name : "esi";
}

/* @return the serial number of an EEPROM image; 0: none */
static uint32_t serial_of(const ect_esi_device_t *model)
{
    const bool has_header = model->eeprom.length >= ECT_SII_CATEGORIES;
    return has_header ? ect_load_le32(model->eeprom.bytes + ECT_SII_AT_SERIAL) : 0;
}

static void set_identity(ect_build_t *build, ect_device_t *device)
{
    const ect_esi_device_t *model = build->model;
    device->identity = (ect_identity_t){.vendor_id = model->vendor_id,
                                        .product_code = model->product_code,
                                        .revision = model->revision,
                                        .serial = serial_of(model)};
    device->type_name = ect_build_text(build, model->type, ECT_BUILD_NAME);
    device->full_name = *model->name != '\0' ? ect_build_text(build, model->name, ECT_BUILD_TEXT) : NULL;
    device->vendor_name = ect_build_text(build, or_unnamed(model->vendor_name), ECT_BUILD_TEXT);
    device->group_type = ect_build_text(build, or_unnamed(model->group_type), ECT_BUILD_TEXT);
    device->group_name = ect_build_text(build, or_unnamed(model->group_name), ECT_BUILD_TEXT);
    device->physics = physics_of(build);
    device->ebus_ma = (int16_t)model->ebus_current_ma;
    device->device_type = model->profile;
    device->name = command_name(build, model->type);
    device->summary = ect_build_text(build, *model->name != '\0' ? model->name : model->type, ECT_BUILD_TEXT);
    device->timeouts = (ect_timeouts_t){
        .preop_ms = timeout(model->preop_ms, 3000),
        .safeop_op_ms = timeout(model->safeop_op_ms, 10000),
        .back_to_init_ms = timeout(model->back_to_init_ms, 5000),
        .back_to_safeop_ms = timeout(model->back_to_safeop_ms, 200),
        .mailbox_request_ms = timeout(model->request_ms, 0),
        .mailbox_response_ms = timeout(model->response_ms, 0),
    };
}

static void add_text(ect_build_t *build, uint16_t index, const char *name, const char *text)
{
    if (ect_build_find(build, index) != NULL || *text == '\0')
        return;
    ect_build_object_t *object = ect_build_object(build, index, ECT_OBJECT_VAR, name);
    ect_build_entry_t *entry =
        ect_build_add(build, object, 0, ECT_TYPE_VISIBLE_STRING, (uint32_t)(8 * strlen(text)), ECT_ACCESS_RO, name);
    entry->initial = (ect_esi_bytes_t){.bytes = (const uint8_t *)text, .length = strlen(text)};
}

/* Adds missing mandatory objects of CoE. */
static void add_mandatory(ect_build_t *build)
{
    const ect_esi_device_t *model = build->model;
    uint32_t types[ECT_SMS];
    if (ect_build_find(build, 0x1000) == NULL) {
        ect_build_object_t *object = ect_build_object(build, 0x1000, ECT_OBJECT_VAR, "Device type");
        ect_build_entry_t *entry =
            ect_build_add(build, object, 0, ECT_TYPE_UNSIGNED32, 32, ECT_ACCESS_RO, "Device type");
        ect_build_initial(build, entry, model->profile);
    }
    add_text(build, 0x1008, "Device name", model->type);
    for (size_t i = 0; i < model->sm_count && i < ECT_SMS; i++)
        types[i] = model->sms[i].virtual_sm ? (uint32_t)ECT_SM_UNUSED : role_of(&model->sms[i]);
    size_t count = model->sm_count < ECT_SMS ? model->sm_count : ECT_SMS;
    ect_build_object_t *object =
        ect_build_numbers(build, 0x1C00, "", "Type", ECT_TYPE_UNSIGNED8, ECT_ACCESS_RO, types, count, count);
    if (*object->name == '\0')
        object->name = "SyncManager type";
}

/* Adds 1018h, with values in the instance, because options may change the identity. */
static void add_identity(ect_build_t *build)
{
    static const struct {
        const char *name;
        size_t offset;
    } members[] = {
        {"Vendor ID", offsetof(ect_standard_t, identity.vendor_id)},
        {"Product code", offsetof(ect_standard_t, identity.product_code)},
        {"Revision number", offsetof(ect_standard_t, identity.revision)},
        {"Serial number", offsetof(ect_standard_t, identity.serial)},
    };
    ect_build_object_t *object =
        ect_build_numbers(build, 0x1018, "", "", ECT_TYPE_UNSIGNED32, ECT_ACCESS_RO, NULL, 0, 4);
    if (*object->name == '\0')
        object->name = "Identity";
    ect_build_initial(build, &object->entries[0], 4);
    for (size_t i = 0; i < 4; i++) {
        object->entries[i + 1].name = members[i].name;
        object->entries[i + 1].offset = members[i].offset;
        object->entries[i + 1].identity = true;
    }
}

/* Connects 1001h of the file to the error register of the stack. */
static void link_error_register(const ect_build_t *build)
{
    const ect_build_object_t *object = ect_build_find(build, 0x1001);
    ect_build_entry_t *entry = object != NULL ? ect_build_entry(object, 0) : NULL;
    if (entry == NULL || entry->bits != 8)
        return;
    entry->initial = (ect_esi_bytes_t){0};
    entry->offset = offsetof(ect_standard_t, error_register);
    entry->identity = true;
}

/* --- the object list --------------------------------------------------------------------------------------------- */

static size_t align_to(size_t at, size_t bytes)
{
    size_t alignment = bytes >= 8 ? 8 : bytes >= 4 ? 4 : bytes >= 2 ? 2 : 1;
    return (at + alignment - 1) / alignment * alignment;
}

/* @return the place of an entry: the same as in another set of modules, else the next one */
static size_t place_of(ect_esi_rack_t *rack, const ect_build_object_t *object, const ect_build_entry_t *entry,
                       size_t room)
{
    ect_esi_place_t **first = &rack->places[object->index];
    for (ect_esi_place_t *place = *first; place != NULL; place = place->next) {
        if (place->subindex == entry->subindex && place->module == object->module &&
            place->data_type == entry->data_type && place->bits == entry->bits)
            return place->offset;
    }
    ect_esi_place_t *place = ect_arena_alloc(rack->arena, sizeof *place);
    *place = (ect_esi_place_t){.next = *first,
                               .module = object->module,
                               .data_type = entry->data_type,
                               .bits = entry->bits,
                               .subindex = entry->subindex,
                               .offset = align_to(rack->used, room)};
    *first = place;
    rack->used = place->offset + room;
    return place->offset;
}

/* Allocates room in the instance for each entry, aligned to its size, with a terminator after texts. */
static size_t lay_out(ect_build_t *build)
{
    size_t at = build->start + ect_esi_ads_size(build->model);
    for (size_t i = 0; i < build->object_count; i++) {
        for (size_t k = 0; k < build->objects[i].count; k++) {
            ect_build_entry_t *entry = &build->objects[i].entries[k];
            size_t bytes = (entry->bits + 7u) / 8u + (entry->data_type == ECT_TYPE_VISIBLE_STRING ? 1 : 0);
            if (entry->identity || entry->constant)
                continue;
            entry->offset =
                build->rack != NULL ? place_of(build->rack, &build->objects[i], entry, bytes) : align_to(at, bytes);
            at = entry->offset + bytes;
        }
    }
    return at;
}

/* All sets of modules have an instance of the same size, which the first one determines. */
static size_t rack_size(ect_build_t *build)
{
    ect_esi_rack_t *rack = build->rack;
    if (rack->size == 0)
        rack->size = align_to(rack->used + rack->room, sizeof(uint64_t));
    if (rack->used > rack->size)
        ect_build_fail(build, "there is no room for one more set of modules");
    return rack->size;
}

static int64_t default_of(const ect_build_entry_t *entry, bool is_signed)
{
    uint64_t value = ect_build_number(entry);
    ECT_ASSERT(entry->bits > 0 && entry->bits <= 64); /* ect_build_range: an integer */
    uint64_t sign = is_signed ? UINT64_C(1) << (entry->bits - 1) : 0;
    return (value & sign) != 0 ? (int64_t)(value | ~(sign - 1)) : (int64_t)value;
}

/* Sets limits of the file that are within the range of the type. */
static bool limits_of(ect_build_t *build, const ect_build_object_t *object, const ect_build_entry_t *entry,
                      int64_t *minimum, int64_t *maximum)
{
    if ((!entry->minimum.given && !entry->maximum.given) || !ect_build_range(entry, minimum, maximum))
        return false;
    int64_t lowest = *minimum;
    int64_t highest = *maximum;
    if (entry->minimum.given)
        *minimum = entry->minimum.value;
    if (entry->maximum.given)
        *maximum = entry->maximum.value;
    int64_t initial = default_of(entry, lowest < 0);
    bool in_range = initial >= *minimum && initial <= *maximum;
    if (*minimum >= lowest && *maximum <= highest && *minimum < *maximum && in_range)
        return true;
    if (!in_range) {
        ect_build_note(build, "object %04X:%u: its default %lld is not within its limits %lld to %lld: no limits",
                       (unsigned int)object->index, (unsigned int)entry->subindex, (long long)initial,
                       (long long)*minimum, (long long)*maximum);
        return false;
    }
    ect_build_note(build, "object %04X:%u: its limits %lld to %lld do not fit its type: left out",
                   (unsigned int)object->index, (unsigned int)entry->subindex, (long long)*minimum,
                   (long long)*maximum);
    return false;
}

/* Adds limits, units and long defaults, which are not members of an entry. */
static void add_detail(ect_build_t *build, ect_device_t *device, const ect_build_object_t *object,
                       const ect_build_entry_t *entry)
{
    bool long_default = entry->initial.length > 4;
    int64_t minimum;
    int64_t maximum;
    bool limited = limits_of(build, object, entry, &minimum, &maximum);
    if (!long_default && !limited && entry->unit == 0)
        return;
    ect_detail_t *details = (ect_detail_t *)(uintptr_t)device->details; // ours, growing
    details = ect_arena_grow(build->arena, details, device->detail_count, sizeof *details);
    ect_detail_t *detail = &details[device->detail_count++];
    detail->index = object->index;
    detail->subindex = entry->subindex;
    detail->unit = entry->unit;
    detail->per = entry->per;
    if (limited) {
        detail->minimum = minimum;
        detail->maximum = maximum;
    }
    if (long_default) {
        uint8_t *bytes = ect_arena_alloc(build->arena, (entry->bits + 7u) / 8u);
        ECT_ASSERT(entry->initial.length <= (entry->bits + 7u) / 8u);
        memcpy(bytes, entry->initial.bytes, entry->initial.length);
        detail->initial = bytes;
    }
    device->details = details;
}

/* @return a short default, truncated to the bits of the entry */
static uint32_t short_default(ect_build_t *build, const ect_build_object_t *object, const ect_build_entry_t *entry)
{
    uint32_t value = entry->initial.length <= 4 ? (uint32_t)ect_build_number(entry) : 0;
    if (entry->bits == 0 || entry->bits >= 8 || value >> entry->bits == 0)
        return value;
    ect_build_note(build, "object %04X:%u: its default 0x%X is truncated to %u bits", (unsigned int)object->index,
                   (unsigned int)entry->subindex, (unsigned int)value, (unsigned int)entry->bits);
    return value & ((1u << entry->bits) - 1);
}

static void set_objects(ect_build_t *build, ect_device_t *device)
{
    ect_object_t *objects = ect_arena_alloc(build->arena, (build->object_count + 1) * sizeof *objects);
    for (size_t i = 0; i < build->object_count; i++) {
        const ect_build_object_t *from = &build->objects[i];
        ECT_ASSERT(from->count > 0 && from->count <= UINT8_MAX + 1u);
        ect_entry_t *entries = ect_arena_alloc(build->arena, from->count * sizeof *entries);
        for (size_t k = 0; k < from->count; k++) {
            const ect_build_entry_t *entry = &from->entries[k];
            entries[k] = (ect_entry_t){
                .subindex = entry->subindex,
                .data_type = entry->data_type,
                .bit_length = entry->bits,
                .access = entry->access,
                .name = entry->name,
                .value = short_default(build, from, entry),
                .data = (void *)entry->offset,
            };
            add_detail(build, device, from, entry);
        }
        objects[i] = (ect_object_t){.index = from->index,
                                    .object_code = from->code,
                                    .max_subindex = from->count > 1 ? from->entries[from->count - 1].subindex : 0,
                                    .last = (uint8_t)(from->count - 1),
                                    .name = from->name,
                                    .entries = entries};
    }
    device->objects = objects;
    device->object_count = (uint16_t)build->object_count;
}

/* --- PDOs: properties beyond their objects ----------------------------------------------------------------------- */

/* IDNs for the elements that mapping_values() has made: none for an entry without bits, several for a long gap. */
static const uint16_t *idns_of(const ect_build_t *build, const ect_build_pdo_t *pdo)
{
    enum { LONGEST_MAPPING = 254, LONGEST_GAP = 255 };
    uint16_t *idns = ect_arena_alloc(build->arena, (LONGEST_MAPPING + 1) * sizeof *idns);
    size_t count = 0;
    for (size_t i = 0; i < pdo->model->entry_count; i++) {
        const ect_esi_entry_t *entry = &pdo->model->entries[i];
        if (ect_build_mapped(build, pdo, entry) != 0 && count < LONGEST_MAPPING)
            idns[count++] = entry->index;
        else
            count += (entry->bits + LONGEST_GAP - 1u) / LONGEST_GAP;
    }
    return idns;
}

static void set_telegrams(ect_build_t *build, ect_device_t *device)
{
    ect_telegram_t *telegrams = ect_arena_alloc(build->arena, (build->pdo_count + 1) * sizeof *telegrams);
    for (size_t i = 0; i < build->pdo_count && device->telegram_count < UINT8_MAX; i++) {
        const ect_build_pdo_t *pdo = &build->pdos[i];
        if (pdo->is_telegram && pdo->usable)
            telegrams[device->telegram_count++] =
                (ect_telegram_t){.index = pdo->index, .number = pdo->model->index, .idns = idns_of(build, pdo)};
    }
    device->telegrams = telegrams;
}

static void set_pdos(ect_build_t *build, ect_device_t *device)
{
    ect_pdo_t *pdos = ect_arena_alloc(build->arena, (build->pdo_count + 1) * sizeof *pdos);
    size_t count = 0;
    for (size_t i = 0; i < build->pdo_count && count < UINT8_MAX; i++) {
        const ect_build_pdo_t *pdo = &build->pdos[i];
        const ect_esi_pdo_t *model = pdo->model;
        if (pdo->usable)
            pdos[count++] = (ect_pdo_t){
                .index = pdo->index,
                .flags = (uint16_t)((model->mandatory ? ECT_PDO_MANDATORY : 0) | (model->fixed ? ECT_PDO_FIXED : 0) |
                                    (pdo->on_virtual ? ECT_PDO_VIRTUAL : 0)),
                .excludes = ect_build_excludes(build, pdo),
            };
    }
    if (build->pdo_count > UINT8_MAX)
        ect_build_note(build, "it has %zu PDOs; fixed, mandatory and excluded PDOs are recorded for the first %u",
                       build->pdo_count, (unsigned int)UINT8_MAX);
    device->pdos = pdos;
    device->pdo_count = (uint8_t)count;
}

/* --- behaviour --------------------------------------------------------------------------------------------------- */

/* Sets outputs to their initial values when the master stops. A mappable entry has at most 255 bits. */
static void safe_outputs(void *instance, uint64_t now_ns)
{
    const ect_standard_t *standard = instance;
    const ect_device_t *device = standard->device;
    const ect_build_t *build = &((const ect_esi_twin_t *)device->context)->build;
    ect_od_t od = ect_device_od(device, instance);
    ECT_ASSERT(build->object_count == device->object_count);
    (void)now_ns;
    for (size_t i = 0; i < build->object_count; i++) {
        const ect_build_object_t *from = &build->objects[i];
        for (size_t k = 0; k < from->count; k++) {
            uint8_t wire[32] = {0};
            const ect_build_entry_t *entry = &from->entries[k];
            if ((entry->access & ECT_ACCESS_RXPDO) == 0 || entry->bits > 8 * sizeof wire)
                continue;
            if (entry->initial.length > 0)
                memcpy(wire, entry->initial.bytes, entry->initial.length);
            (void)ect_od_write(&od, &device->objects[i].entries[k], 0, wire, (uint16_t)((entry->bits + 7u) / 8u));
        }
    }
}

/* Called after a signal is set: sends the inputs again. The twin has no timers. */
static uint64_t tick(void *instance, uint64_t now_ns)
{
    (void)instance;
    (void)now_ns;
    return ECT_NEVER;
}

/* --- the twin ----------------------------------------------------------------------------------------------------- */

static void build(ect_esi_twin_t *twin, const ect_module_choice_t *modules, size_t module_count)
{
    ect_build_t *b = &twin->build;
    ect_device_t *device = &twin->device;
    ect_build_objects(b, &b->model->dictionary, &ect_build_device);
    ect_build_idns(b);
    ect_build_modules(b, modules, module_count);
    ect_build_pdos(b);
    ect_build_inits(b, b->model->mailbox.inits, b->model->mailbox.init_count, &ect_build_device);
    ect_build_idents(b);
    ect_build_pdo_states(b);
    ect_build_revision(b);
    if (b->model->mailbox.coe)
        add_mandatory(b);
    add_identity(b);
    link_error_register(b);
    ect_build_sort(b);
    set_identity(b, device);
    set_sms(b, device);
    set_fmmus(b, device);
    set_mailbox(b, device);
    set_general(b->model, device);
    set_boot(b->model, device);
    set_dc(b, device);
    ect_esi_inits_set(b, device);
    set_eeprom(b, device);
    set_categories(b, device);
    device->esc = esc_of(device);
    device->instance_size = ect_esi_servo_place(b, ect_esi_network_place(b, lay_out(b)));
    if (b->rack != NULL)
        device->instance_size = rack_size(b);
    ect_build_toggles(b, device);
    set_objects(b, device);
    ect_esi_reported_set(b, device);
    set_pdos(b, device);
    set_telegrams(b, device);
    if (can_be_configured(b))
        ect_build_service(b, device, &ect_service_pdo_config);
    if (b->soe != NULL && b->soe->served) {
        ect_build_service(b, device, &ect_service_soe);
        device->init = ect_esi_servo_init;
    }
    device->safe_outputs = safe_outputs;
    device->tick = tick;
    device->context = twin;
    ect_esi_idents_set(b, device);
    if (device->sii == NULL && b->failure == NULL)
        fit_eeprom(b, device);
    if (b->rack != NULL) {
        ect_esi_change_set(b, device, &twin->plant);
        ect_esi_change_signals(b, &twin->plant);
    }
    if (b->failure == NULL)
        ect_build_signals(b, &twin->plant);
    ect_build_count_notes(b);
    twin->plant.fields = b->model->fields;
    twin->product = (ect_product_t){.device = device, .plant = &twin->plant};
}

ect_esi_twin_t *ect_esi_twin_assemble(const ect_esi_t *esi, const ect_esi_device_t *model,
                                      const ect_module_choice_t *modules, size_t module_count, ect_esi_rack_t *rack,
                                      char *text, size_t room)
{
    char why[200];
    ect_esi_twin_t *twin = calloc(1, sizeof *twin);
    if (twin == NULL) {
        (void)snprintf(text, room, "%s: no memory left", ect_esi_file(esi));
        return NULL;
    }
    twin->build = (ect_build_t){.arena = &twin->arena, .model = model, .rack = rack};
    twin->build.start = rack != NULL ? ect_esi_change_size(rack) : sizeof(ect_esi_instance_t);
    twin->esi = esi;
    twin->chosen = module_count > 0;
    build(twin, modules, module_count);
    if (twin->build.failure == NULL && (!ect_device_check(&twin->device, why, sizeof why) ||
                                        !ect_plant_check(&twin->plant, &twin->device, why, sizeof why)))
        ect_build_fail(&twin->build, "%s", why);
    if (twin->build.failure == NULL)
        return twin;
    (void)snprintf(text, room, "%s:%d: %s: %s", ect_esi_file(esi), model->line, model->type, twin->build.failure);
    ect_esi_twin_drop(twin);
    return NULL;
}

const ect_product_t *ect_esi_twin_product(const ect_esi_twin_t *twin)
{
    return &twin->product;
}

const char *const *ect_esi_twin_notes(const ect_esi_twin_t *twin, size_t *count)
{
    *count = twin->build.note_count;
    return twin->build.notes;
}

const ect_esi_device_t *ect_esi_twin_model(const ect_esi_twin_t *twin)
{
    return twin->build.model;
}

const ect_esi_t *ect_esi_twin_file(const ect_esi_twin_t *twin)
{
    return twin->esi;
}

ect_esi_twin_t *ect_esi_twin_without_modules(const ect_esi_twin_t *twin)
{
    char text[200];
    const ect_esi_device_t *model = twin->build.model;
    size_t count = 0;
    for (size_t i = 0; i < model->slot_count; i++)
        count += model->slots[i].instances_max;
    ect_module_choice_t *empty = count > 0 && !twin->chosen ? calloc(count, sizeof *empty) : NULL;
    if (empty == NULL)
        return NULL;
    for (size_t i = 0; i < count; i++)
        empty[i].slot = (unsigned int)i; /* ident 0: no module */
    ect_esi_twin_t *bare = ect_esi_twin_assemble(twin->esi, model, empty, count, NULL, text, sizeof text);
    free(empty);
    return bare;
}

void ect_esi_twin_drop(ect_esi_twin_t *twin)
{
    if (twin == NULL)
        return;
    ect_esi_close(twin->own);
    ect_arena_free(&twin->arena);
    free(twin);
}
