/* SPDX-License-Identifier: MIT */
/* Checks of names, protocols, object services, clocks and the size of the SII. */
#include <stdlib.h>
#include <string.h>

#include "check/internal.h"
#include "esc/personality.h"
#include "seams/aoe.h"
#include "seams/eoe.h"
#include "seams/services.h"
#include "seams/standard.h"
#include "sii/sii.h"

enum { LONGEST_NAME = 40, LONGEST_TEXT = 255 };

bool check_names(const report_t *r)
{
    const ect_device_t *d = r->device;
    const struct {
        const char *what, *text;
        size_t most;
        bool needed;
    } texts[] = {{"name", d->name, LONGEST_NAME, true},
                 {"summary", d->summary, LONGEST_TEXT, true},
                 {"vendor_name", d->vendor_name, LONGEST_TEXT, true},
                 {"type_name", d->type_name, LONGEST_NAME, true},
                 {"full_name", d->full_name, LONGEST_TEXT, false},
                 {"group_type", d->group_type, LONGEST_TEXT, true},
                 {"group_name", d->group_name, LONGEST_TEXT, true},
                 {"hardware_version", d->hardware_version, LONGEST_NAME, false},
                 {"software_version", d->software_version, LONGEST_NAME, false}};
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++) {
        if ((texts[i].needed || texts[i].text) && !text_good(r, texts[i].what, texts[i].text, texts[i].most))
            return false;
    }
    if (strspn(d->name, "abcdefghijklmnopqrstuvwxyz0123456789-") != strlen(d->name))
        return wrong(r, "name: '%.40s' contains a character other than lower case, digits and hyphens", d->name);
    return true;
}

/* --- protocols ---------------------------------------------------------------------------------------------------- */

static const struct {
    uint8_t bit, type;
    const char *name;
} kinds[] = {{ECT_MAILBOX_AOE, ECT_MAILBOX_TYPE_AOE, "AoE"}, {ECT_MAILBOX_EOE, ECT_MAILBOX_TYPE_EOE, "EoE"},
             {ECT_MAILBOX_COE, ECT_MAILBOX_TYPE_COE, "CoE"}, {ECT_MAILBOX_FOE, ECT_MAILBOX_TYPE_FOE, "FoE"},
             {ECT_MAILBOX_SOE, ECT_MAILBOX_TYPE_SOE, "SoE"}, {ECT_MAILBOX_VOE, ECT_MAILBOX_TYPE_VOE, "VoE"}};

static bool serves(const report_t *r, uint8_t type)
{
    for (const ect_protocol_t *const *p = r->device->protocols; p && *p; p++) {
        if ((*p)->type == type)
            return true;
    }
    return false;
}

static bool names_protocol(const report_t *r, const ect_protocol_t *which)
{
    for (const ect_protocol_t *const *p = r->device->protocols; p && *p; p++) {
        if (*p == which)
            return true;
    }
    return false;
}

static bool coe_good(const report_t *r)
{
    const ect_device_t *d = r->device;
    bool coe = (d->mailbox_protocols & ECT_MAILBOX_COE) != 0;
    if (!coe)
        return d->coe_details == 0 ? true : wrong(r, "coe_details: without CoE there are none");
    if (((d->coe_details & ECT_COE_SDO_INFO) != 0) != names_protocol(r, &ect_protocol_sdo_info))
        return wrong(r, "protocols: ect_protocol_sdo_info and ECT_COE_SDO_INFO go together");
    if (!ect_od_find(&r->od, 0x1000) || !ect_od_find(&r->od, 0x1018))
        return wrong(r, "objects: a device with CoE has 1000h and 1018h");
    return true;
}

/* Checks the requirements of the stack's EoE; a device may have its own EoE. */
static bool eoe_good(const report_t *r)
{
    const ect_device_t *d = r->device;
    for (const ect_protocol_t *const *p = d->protocols; p && *p; p++) {
        if ((*p)->request != ect_eoe_request)
            continue;
        if (!ect_eoe_fits(d))
            return wrong(r, "sm: with EoE both mailboxes have at least %d bytes", ECT_EOE_MAILBOX_LEAST);
        if (p[1])
            return wrong(r, "protocols: EoE is not the last; its frames would delay the mails of those after it");
    }
    return true;
}

/* Checks the requirements of the stack's AoE; a device may have its own AoE. */
static bool aoe_good(const report_t *r)
{
    const ect_device_t *d = r->device;
    for (const ect_protocol_t *const *p = d->protocols; p && *p; p++) {
        if ((*p)->request != ect_aoe_request)
            continue;
        const ect_aoe_t *aoe = (const ect_aoe_t *)(const void *)*p;
        if (!ect_aoe_fits(d))
            return wrong(r, "sm: with AoE both mailboxes have at least %d bytes", ECT_AOE_MAILBOX_LEAST);
        if (aoe->offset < sizeof(ect_standard_t) || aoe->offset > d->instance_size ||
            sizeof(ect_aoe_state_t) > d->instance_size - aoe->offset)
            return wrong(r, "protocols: the state of AoE is not inside the instance");
    }
    return true;
}

static bool protocols_good(const report_t *r)
{
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; i++) {
        bool said = (r->device->mailbox_protocols & kinds[i].bit) != 0;
        if (said != serves(r, kinds[i].type))
            return wrong(r, "mailbox_protocols: it %s %s, the list 'protocols' %s", said ? "has" : "has not",
                         kinds[i].name, said ? "does not serve it" : "serves it");
    }
    if ((r->device->mailbox_protocols & ~0x3Fu) != 0)
        return wrong(r, "mailbox_protocols: there is no protocol %02Xh", r->device->mailbox_protocols & ~0x3Fu);
    return eoe_good(r) && aoe_good(r) && check_soe(r) && coe_good(r);
}

/* --- 1018h, 1C00h: consistent with the description ------------------------------------------------------------------
 */

static bool constant_good(const report_t *r, uint16_t index, uint8_t subindex, uint32_t want)
{
    const ect_object_t *object = NULL;
    const ect_entry_t *e = NULL;
    if (ect_od_lookup(&r->od, index, subindex, &object, &e) != ECT_OK || e->data || e->value == want)
        return true;
    return wrong(r, "%04Xh:%u: it has %Xh, the description %Xh", index, subindex, e->value, want);
}

static bool constants_good(const report_t *r)
{
    const ect_device_t *d = r->device;
    const ect_object_t *types = ect_od_find(&r->od, 0x1C00);
    if (types && types->max_subindex != d->sm_count)
        return wrong(r, "1C00h: it has %u SyncManagers, the description %u", types->max_subindex, d->sm_count);
    for (unsigned int n = 0; n < d->sm_count; n++) {
        if (!constant_good(r, 0x1C00, (uint8_t)(n + 1), d->sm[n].type))
            return false;
    }
    return constant_good(r, 0x1018, 1, d->identity.vendor_id) &&
           constant_good(r, 0x1018, 2, d->identity.product_code) && constant_good(r, 0x1018, 3, d->identity.revision) &&
           constant_good(r, 0x1018, 4, d->identity.serial);
}

/* --- object services ---------------------------------------------------------------------------------------------- */

static bool names_service(const report_t *r, const ect_service_t *which)
{
    for (const ect_service_t *const *s = r->device->services; s && *s; s++) {
        if (*s == which)
            return true;
    }
    return false;
}

/* Checks that the structure of a service, which begins at the value of `index`:1, is inside the instance. */
static bool data_good(const report_t *r, const char *service, uint16_t index, size_t size)
{
    const ect_object_t *object = NULL;
    const ect_entry_t *e = NULL;
    if (ect_od_lookup(&r->od, index, 1, &object, &e) != ECT_OK || !e->data)
        return wrong(r, "services: %s needs %04Xh:1 in memory", service, index);
    size_t offset = (uintptr_t)e->data;
    size_t whole = r->device->instance_size;
    if (!r->device->addresses && (offset < sizeof(ect_standard_t) || offset > whole || size > whole - offset))
        return wrong(r, "services: the data of %s, from %04Xh:1 on, are not inside the instance", service, index);
    return r->device->addresses || offset % _Alignof(uint32_t) == 0
               ? true
               : wrong(r, "services: the data of %s, from %04Xh:1 on, are not aligned", service, index);
}

static bool can_be_written(const report_t *r, uint16_t index, const char *service)
{
    const ect_object_t *object = NULL;
    const ect_entry_t *e = NULL;
    if (ect_od_lookup(&r->od, index, 1, &object, &e) == ECT_OK && (e->access & ECT_ACCESS_WO) != 0)
        return true;
    return wrong(r, "services: %s needs %04Xh:1 that can be written", service, index);
}

/* @return whether a master may change an assignment or mapping */
static bool can_be_configured(const report_t *r)
{
    for (unsigned int i = 0; i < r->device->object_count; i++) {
        const ect_object_t *o = &r->device->objects[i];
        bool config = o->index >= 0x1600 && o->index < 0x1C30 && o->index != 0x1C00;
        for (const ect_entry_t *e = config ? o->entries : NULL; e; e = ect_od_next(o, e)) {
            if ((e->access & ECT_ACCESS_WO) != 0)
                return true;
        }
    }
    return wrong(r, "services: ect_service_pdo_config has no assignment or mapping that can be written");
}

static bool has_outputs(const report_t *r)
{
    for (unsigned int n = 0; n < r->device->sm_count; n++) {
        if (r->device->sm[n].type == ECT_SM_OUTPUTS)
            return true;
    }
    return false;
}

static bool services_good(const report_t *r)
{
    uint16_t sync = has_outputs(r) ? 0x1C32 : 0x1C33;
    if (names_service(r, &ect_service_sync) && !data_good(r, "ect_service_sync", sync, sizeof(ect_sync_data_t)))
        return false;
    if (names_service(r, &ect_service_diagnosis)) {
        const ect_object_t *history = ect_od_find(&r->od, 0x10F3);
        if (!data_good(r, "ect_service_diagnosis", 0x10F3, sizeof(ect_diagnosis_t)))
            return false;
        if (history->max_subindex != 5 + ECT_DIAGNOSIS_MESSAGES)
            return wrong(r, "10F3h: it has %d messages", ECT_DIAGNOSIS_MESSAGES);
    }
    if (names_service(r, &ect_service_store) && !can_be_written(r, 0x1010, "ect_service_store"))
        return false;
    if (r->device->cyclic && !names_service(r, &ect_service_rhythm))
        return wrong(r, "cyclic: it needs ect_service_rhythm, which calls it");
    return !names_service(r, &ect_service_pdo_config) || can_be_configured(r);
}

/* --- clocks ------------------------------------------------------------------------------------------------------- */

static bool mode_good(const report_t *r, const ect_dc_mode_t *mode)
{
    const char *esc = r->device->esc;
    if (!text_good(r, "dc_modes: a name", mode->name, LONGEST_TEXT))
        return false;
    if (mode->assign_activate != 0 && (ect_esc_personality(esc)->features & ECT_FEATURE_DC) == 0)
        return wrong(r, "dc_modes: '%.40s' needs distributed clocks, which the ESC '%s' has not", mode->name, esc);
    return true;
}

static bool clocks_good(const report_t *r)
{
    const ect_device_t *d = r->device;
    if ((d->dc_mode_count > 0 && !d->dc_modes) || (d->sync.dc_cycle_count > 0 && !d->sync.dc_cycles_ns))
        return wrong(r, "dc_modes: they, or their cycles, are missing");
    for (unsigned int i = 0; i < d->dc_mode_count; i++) {
        if (!mode_good(r, &d->dc_modes[i]))
            return false;
    }
    if ((d->sync.supported & (1u << ECT_SYNC_DC_SYNC0)) != 0 && d->dc_mode_count == 0)
        return wrong(r, "sync: SYNC0 is supported, but no mode of dc_modes starts it");
    return true;
}

/* --- init commands ------------------------------------------------------------------------------------------------ */

static bool transitions_good(const char *transitions)
{
    static const char known[] = "IP PS SO SP OP OS";
    size_t length = transitions ? strlen(transitions) : 0;
    for (size_t at = 0; at < length; at += 3) {
        char name[3] = {transitions[at], transitions[at + 1], 0};
        if (strlen(name) != 2 || strchr(name, ' ') || !strstr(known, name) ||
            (at + 2 < length && (transitions[at + 2] != ' ' || at + 3 == length)))
            return false;
    }
    return length > 0;
}

static bool init_commands_good(const report_t *r)
{
    const ect_device_t *d = r->device;
    if (d->init_command_count > 0 && !d->init_commands)
        return wrong(r, "init_commands: they are missing");
    for (unsigned int i = 0; i < d->init_command_count; i++) {
        const ect_init_command_t *c = &d->init_commands[i];
        if (!transitions_good(c->transitions))
            return wrong(r, "init_commands: %04Xh:%u names transitions other than IP PS SO SP OP OS", c->index,
                         c->subindex);
        if (!c->upload && (!c->data || c->size == 0))
            return wrong(r, "init_commands: %04Xh:%u has no data", c->index, c->subindex);
    }
    return true;
}

static bool init_mails_good(const report_t *r)
{
    const ect_device_t *d = r->device;
    if (d->init_mail_count > 0 && !d->init_mails)
        return wrong(r, "init_mails: they are missing");
    for (unsigned int i = 0; i < d->init_mail_count; i++) {
        const ect_init_mail_t *m = &d->init_mails[i];
        if (!transitions_good(m->transitions))
            return wrong(r, "init_mails: number %u names transitions other than IP PS SO SP OP OS", i);
        if (m->size > 0 && !m->data)
            return wrong(r, "init_mails: number %u has no data", i);
    }
    return true;
}

static bool timeouts_good(const report_t *r)
{
    const ect_timeouts_t *t = &r->device->timeouts;
    if (t->preop_ms == 0 || t->safeop_op_ms == 0)
        return wrong(r, "timeouts: preop_ms and safeop_op_ms are needed: a delayed transition ends after them");
    return true;
}

bool check_offers(const report_t *r)
{
    return protocols_good(r) && constants_good(r) && services_good(r) && clocks_good(r) && init_commands_good(r) &&
           init_mails_good(r) && timeouts_good(r);
}

bool check_sii(const report_t *r)
{
    const ect_device_t *d = r->device;
    if (d->sii_size < ECT_SII_CATEGORIES || d->sii_size % 128 != 0)
        return wrong(r, "sii_size: %u is not a multiple of 128", d->sii_size);
    uint8_t *image = malloc(d->sii_size);
    if (!image)
        return wrong(r, "sii_size: no memory for an image of %u bytes", d->sii_size);
    bool fits = ect_sii_write(d, NULL, 0, image, d->sii_size) >= 0;
    free(image);
    return fits ? true
                : wrong(r, "sii_size: the SII does not fit into %u bytes, or has more than 255 texts", d->sii_size);
}
