/* SPDX-License-Identifier: MIT */
/* Mailbox, SyncManagers, clocks and EEPROM. */
#include "devfile/internal.h"

#include <string.h>

#include "esi/modules.h"

enum {
    MAILBOX = 128,      /* bytes, the standard */
    MAILBOX_LEAST = 34, /* with SDO information */
    MAILBOX_MOST = 1486,
    RAM = 0x1000,
    RAM_END = 0x10000,
    GRID = 0x80, /* default areas start at multiples of this */
    SMS = 16,
    MODES = 16,
    CONFIG = 14, /* bytes */
    EEPROM_LEAST = 128,
    EEPROM_MOST = 0x8000,
};

/* --- mailbox ------------------------------------------------------------------------------------------------------ */

static void take_protocol(ect_draft_t *d, const yaml_node_t *node)
{
    ect_esi_mailbox_t *m = &d->device->mailbox;
    const struct {
        const char *name;
        bool *flag;
    } protocols[] = {{"coe", &m->coe}, {"foe", &m->foe}, {"eoe", &m->eoe},
                     {"aoe", &m->aoe}, {"soe", &m->soe}, {"voe", &m->voe}};
    const char *name = ect_yaml_scalar(&d->yaml, node, "protocols");
    for (size_t i = 0; i < sizeof protocols / sizeof protocols[0]; i++) {
        if (strcmp(protocols[i].name, name) == 0) {
            *protocols[i].flag = true;
            return;
        }
    }
    ect_yaml_fail(&d->yaml, node, "'protocols' takes coe, eoe, foe, aoe, soe, voe, not '%.60s'", name);
}

static void take_protocols(ect_draft_t *d, const yaml_node_t *list)
{
    d->device->mailbox.coe = false;
    if (list->type != YAML_SEQUENCE_NODE)
        ect_yaml_fail(&d->yaml, list, "'protocols' takes a list, as [coe, foe]");
    for (const yaml_node_item_t *i = list->data.sequence.items.start;
         !d->mistake.failed && i < list->data.sequence.items.top; i++)
        take_protocol(d, ect_yaml_node(&d->yaml, *i));
}

static void take_mailbox(void *ctx, const char *key, const yaml_node_t *name, const yaml_node_t *value)
{
    ect_draft_t *d = ctx;
    ect_esi_mailbox_t *m = &d->device->mailbox;
    const struct {
        const char *name;
        bool *flag;
    } flags[] = {{"sdo-info", &m->sdo_info},
                 {"complete-access", &m->complete_access},
                 {"pdo-assign", &m->pdo_assign},
                 {"repeat", &m->data_link_layer}};
    if (strcmp(key, "protocols") == 0) {
        take_protocols(d, value);
        return;
    }
    ect_word_t word = ect_draft_word(d, value, key);
    if (d->mistake.failed)
        return;
    if (strcmp(key, "size") == 0) {
        d->mailbox_bytes = (uint16_t)ect_draft_number(d, "size", word, MAILBOX_LEAST, MAILBOX_MOST);
        return;
    }
    for (size_t i = 0; i < sizeof flags / sizeof flags[0]; i++) {
        if (strcmp(flags[i].name, key) == 0) {
            *flags[i].flag = ect_draft_flag(d, key, word);
            return;
        }
    }
    ect_yaml_fail(&d->yaml, name,
                  "'%.60s' is no key of 'mailbox': size, protocols, sdo-info, complete-access, pdo-assign, repeat",
                  key);
}

void ect_draft_mailbox(ect_draft_t *d, const yaml_node_t *mailbox)
{
    bool none = mailbox != NULL && mailbox->type == YAML_SCALAR_NODE &&
                strcmp((const char *)mailbox->data.scalar.value, "none") == 0;
    if (none)
        return;
    d->mailbox_bytes = MAILBOX;
    d->device->mailbox.given = d->device->mailbox.coe = d->device->mailbox.sdo_info = true;
    d->device->mailbox.complete_access = d->device->mailbox.data_link_layer = true;
    if (mailbox != NULL)
        ect_yaml_each(&d->yaml, mailbox, "'mailbox' other than 'none'", true, take_mailbox, d);
}

/* --- SyncManagers ------------------------------------------------------------------------------------------------- */

ect_esi_sm_t *ect_draft_sm(ect_draft_t *d, const char *type, uint8_t control, uint16_t bytes)
{
    ect_esi_sm_t *sms = (ect_esi_sm_t *)(uintptr_t)d->device->sms; /* not constant yet */
    sms = ect_arena_grow(d->arena, sms, d->device->sm_count, sizeof *sms);
    d->device->sms = sms;
    ect_esi_sm_t *sm = &sms[d->device->sm_count++];
    *sm = (ect_esi_sm_t){.type = type,
                         .control = control,
                         .size = {.given = bytes > 0, .value = bytes},
                         .minimum = bytes,
                         .maximum = bytes};
    return sm;
}

static uint32_t bits_of(const ect_esi_pdo_t *pdos, size_t count, bool tx)
{
    uint32_t bits = 0;
    for (size_t i = 0; i < count; i++) {
        for (size_t k = 0; k < pdos[i].entry_count; k++)
            bits += pdos[i].tx == tx ? pdos[i].entries[k].bits : 0u;
    }
    return bits;
}

/* @return the bits of the longest module of a slot */
static uint32_t longest_of(const ect_draft_t *d, const ect_esi_slot_t *slot, bool tx)
{
    uint32_t longest = 0;
    for (size_t i = 0; i < d->device->module_count; i++) {
        const ect_esi_module_t *module = &d->device->modules[i];
        const uint32_t bits = bits_of(module->pdos, module->pdo_count, tx);
        longest = ect_esi_slot_takes(slot, module) && bits > longest ? bits : longest;
    }
    return longest;
}

/* @return the bytes of all PDOs of a direction, with the longest modules in all places */
static uint32_t bytes_of(const ect_draft_t *d, bool tx)
{
    uint32_t bits = bits_of(d->device->pdos, d->device->pdo_count, tx);
    for (size_t i = 0; i < d->device->slot_count; i++)
        bits += d->device->slots[i].instances_max * longest_of(d, &d->device->slots[i], tx);
    return (bits + 7) / 8;
}

static uint32_t place(ect_draft_t *d, ect_esi_sm_t *sm, uint32_t at, uint32_t bytes)
{
    uint32_t end = at + (bytes + GRID - 1) / GRID * GRID;
    if (end > RAM_END)
        ect_mistake(&d->mistake, 1, "mailboxes and process data need more than the 60 KB of a controller: use fewer");
    sm->start = (uint16_t)at;
    return end;
}

/* Places two mailboxes, outputs and inputs in succession; without a mailbox, the process data only. */
static void make_standard(ect_draft_t *d)
{
    uint32_t at = RAM;
    const uint16_t bytes = d->mailbox_bytes;
    const bool mailbox = bytes > 0;
    for (unsigned int n = 0; n < 2 && mailbox; n++) {
        ect_esi_sm_t *sm = ect_draft_sm(d, n == 0 ? "MBoxOut" : "MBoxIn", n == 0 ? 0x26 : 0x22, bytes);
        at = place(d, sm, at, bytes);
    }
    for (unsigned int n = 0; n < 2; n++) {
        uint32_t length = bytes_of(d, n == 1);
        if (mailbox || length > 0)
            at = place(d, ect_draft_sm(d, n == 0 ? "Outputs" : "Inputs", n == 0 ? 0x64 : 0x20, 0), at, 3 * length);
    }
}

/* A SyncManager whose keys are being read. */
typedef struct sm_keys {
    ect_draft_t *d;
    const yaml_node_t *type, *start, *size, *control;
} sm_keys_t;

static void take_sm_key(void *ctx, const char *key, const yaml_node_t *name, const yaml_node_t *value)
{
    sm_keys_t *k = ctx;
    const struct {
        const char *name;
        const yaml_node_t **node;
    } nodes[] = {{"type", &k->type}, {"start", &k->start}, {"size", &k->size}, {"control", &k->control}};
    for (size_t i = 0; i < sizeof nodes / sizeof nodes[0]; i++) {
        if (strcmp(nodes[i].name, key) == 0) {
            *nodes[i].node = value;
            return;
        }
    }
    ect_yaml_fail(&k->d->yaml, name, "'%.60s' is no key of a SyncManager: type, start, size, control", key);
}

static int64_t number_or(ect_draft_t *d, const char *key, const yaml_node_t *node, int64_t otherwise, int64_t maximum)
{
    if (node == NULL || d->mistake.failed)
        return otherwise;
    ect_word_t word = ect_draft_word(d, node, key);
    return d->mistake.failed ? otherwise : ect_draft_number(d, key, word, 0, maximum);
}

static void take_sm(ect_draft_t *d, const yaml_node_t *node)
{
    static const struct {
        const char *name, *type;
        uint8_t control;
    } kinds[] = {{"mailbox-out", "MBoxOut", 0x26},
                 {"mailbox-in", "MBoxIn", 0x22},
                 {"outputs", "Outputs", 0x64},
                 {"inputs", "Inputs", 0x20},
                 {"unused", "", 0x00}};
    sm_keys_t k = {.d = d};
    size_t kind = 0;
    ect_yaml_each(&d->yaml, node, "a SyncManager", true, take_sm_key, &k);
    if (!d->mistake.failed && (k.type == NULL || k.start == NULL))
        ect_yaml_fail(&d->yaml, node, "a SyncManager takes 'type' and 'start': {type: inputs, start: 0x1400}");
    const char *type = d->mistake.failed ? "" : ect_yaml_scalar(&d->yaml, k.type, "type");
    while (kind < sizeof kinds / sizeof kinds[0] && strcmp(kinds[kind].name, type) != 0)
        kind++;
    if (!d->mistake.failed && kind == sizeof kinds / sizeof kinds[0])
        ect_yaml_fail(&d->yaml, k.type, "'type' takes mailbox-out, mailbox-in, outputs, inputs, unused, not '%.60s'",
                      type);
    if (!d->mistake.failed && (k.size != NULL) != (kind < 2))
        ect_yaml_fail(&d->yaml, node,
                      kind < 2 ? "a mailbox takes its 'size': 128"
                               : "'size' is for mailboxes; process data have that of their PDOs");
    if (d->mistake.failed)
        return;
    const uint8_t control = (uint8_t)number_or(d, "control", k.control, kinds[kind].control, 255);
    ect_esi_sm_t *sm =
        ect_draft_sm(d, kinds[kind].type, control, (uint16_t)number_or(d, "size", k.size, 0, MAILBOX_MOST));
    sm->start = (uint16_t)number_or(d, "start", k.start, 0, RAM_END - 1);
    sm->line = (int)ect_yaml_line(node);
}

static void add_fmmus(ect_draft_t *d)
{
    const char **fmmus = ect_arena_alloc(d->arena, 3 * sizeof *fmmus);
    const bool all = d->device->mailbox.given;
    if (all || bytes_of(d, false) > 0)
        fmmus[d->device->fmmu_count++] = "Outputs";
    if (all || bytes_of(d, true) > 0)
        fmmus[d->device->fmmu_count++] = "Inputs";
    if (all)
        fmmus[d->device->fmmu_count++] = "MBoxState";
    d->device->fmmus = fmmus;
}

/* The first SyncManager for a direction; -1: none. */
static int sm_for(const ect_draft_t *d, bool tx)
{
    for (size_t i = 0; i < d->device->sm_count; i++) {
        if (strcmp(d->device->sms[i].type, tx ? "Inputs" : "Outputs") == 0)
            return (int)i;
    }
    return -1;
}

static void assign(ect_draft_t *d, const ect_esi_pdo_t *constant, size_t count)
{
    ect_esi_pdo_t *pdos = (ect_esi_pdo_t *)(uintptr_t)constant; /* ours */
    for (size_t i = 0; i < count; i++) {
        int sm = sm_for(d, pdos[i].tx);
        if (sm < 0)
            ect_mistake(&d->mistake, (size_t)pdos[i].line, "no SyncManager has the %s: add one to 'syncmanagers'",
                        pdos[i].tx ? "inputs" : "outputs");
        pdos[i].sm = pdos[i].sm < 0 ? -1 : sm;
    }
}

void ect_draft_assign(ect_draft_t *d)
{
    add_fmmus(d);
    assign(d, d->device->pdos, d->device->pdo_count);
    for (size_t i = 0; i < d->device->module_count; i++)
        assign(d, d->device->modules[i].pdos, d->device->modules[i].pdo_count);
}

void ect_draft_syncmanagers(ect_draft_t *d, const yaml_node_t *list)
{
    bool standard = list == NULL ||
                    (list->type == YAML_SCALAR_NODE && strcmp((const char *)list->data.scalar.value, "standard") == 0);
    if (!standard && list->type != YAML_SEQUENCE_NODE)
        ect_yaml_fail(&d->yaml, list,
                      "'syncmanagers' takes standard, or a list, '- {type: inputs, start: 0x1400}' each");
    if (d->mistake.failed)
        return;
    if (standard)
        make_standard(d);
    else if (list->data.sequence.items.top - list->data.sequence.items.start > SMS)
        ect_yaml_fail(&d->yaml, list, "more than %d SyncManagers", (int)SMS);
    for (const yaml_node_item_t *i = standard ? NULL : list->data.sequence.items.start;
         !standard && !d->mistake.failed && i < list->data.sequence.items.top; i++)
        take_sm(d, ect_yaml_node(&d->yaml, *i));
    if (!d->mistake.failed)
        ect_draft_assign(d);
}

/* --- clocks ------------------------------------------------------------------------------------------------------- */

ect_esi_dc_t *ect_draft_mode(ect_draft_t *d)
{
    ect_esi_dc_t *modes = (ect_esi_dc_t *)(uintptr_t)d->device->dcs; /* not constant yet */
    modes = ect_arena_grow(d->arena, modes, d->device->dc_count, sizeof *modes);
    d->device->dcs = modes;
    ect_esi_dc_t *mode = &modes[d->device->dc_count++];
    *mode = (ect_esi_dc_t){.name = "", .description = ""};
    return mode;
}

static ect_esi_dc_t *last_mode(const ect_draft_t *d)
{
    return &((ect_esi_dc_t *)(uintptr_t)d->device->dcs)[d->device->dc_count - 1];
}

static bool take_time(ect_draft_t *d, const char *key, ect_word_t word)
{
    ect_esi_dc_t *mode = last_mode(d);
    const struct {
        const char *name;
        int64_t *ns;
        int *factor;
        int64_t least, most;
    } times[] = {
        {"cycle0", &mode->cycle_sync0_ns, NULL, 0, INT32_MAX},
        {"cycle1", &mode->cycle_sync1_ns, NULL, 0, INT32_MAX},
        {"shift0", &mode->shift_sync0_ns, NULL, INT32_MIN, INT32_MAX},
        {"shift1", &mode->shift_sync1_ns, NULL, INT32_MIN, INT32_MAX},
        {"factor0", NULL, &mode->sync0_factor, INT16_MIN, INT16_MAX},
        {"factor1", NULL, &mode->sync1_factor, INT16_MIN, INT16_MAX},
    };
    for (size_t i = 0; i < sizeof times / sizeof times[0]; i++) {
        if (strcmp(times[i].name, key) != 0)
            continue;
        int64_t value = ect_draft_number(d, key, word, times[i].least, times[i].most);
        if (times[i].ns != NULL)
            *times[i].ns = value;
        else
            *times[i].factor = (int)value;
        return true;
    }
    return false;
}

static void take_mode_key(void *ctx, const char *key, const yaml_node_t *name, const yaml_node_t *value)
{
    ect_draft_t *d = ctx;
    ect_word_t word = ect_draft_word(d, value, key);
    if (d->mistake.failed)
        return;
    if (strcmp(key, "name") == 0)
        last_mode(d)->name = ect_arena_copy(d->arena, word.text, strlen(word.text));
    else if (strcmp(key, "description") == 0)
        last_mode(d)->description = ect_arena_copy(d->arena, word.text, strlen(word.text));
    else if (strcmp(key, "activate") == 0)
        last_mode(d)->assign_activate = (uint16_t)ect_draft_number(d, key, word, 0, UINT16_MAX);
    else if (!take_time(d, key, word))
        ect_yaml_fail(
            &d->yaml, name,
            "'%.60s' is no key of a clock mode: name, description, activate, cycle0, shift0, factor0, cycle1, "
            "shift1, factor1",
            key);
}

/* A mode by its usual name. */
static void take_usual(ect_draft_t *d, const yaml_node_t *node)
{
    static const struct {
        const char *word, *name, *description;
        uint16_t activate;
    } usual[] = {
        {"free-run", "FreeRun", "FreeRun or SM synchron", 0},
        {"sync0", "DC", "DC, SYNC0", 0x0300},
        {"sync01", "DC01", "DC, SYNC0 and SYNC1", 0x0700},
    };
    const char *word = ect_yaml_scalar(&d->yaml, node, "dc");
    for (size_t i = 0; i < sizeof usual / sizeof usual[0]; i++) {
        if (strcmp(usual[i].word, word) != 0)
            continue;
        *ect_draft_mode(d) = (ect_esi_dc_t){
            .name = usual[i].name, .description = usual[i].description, .assign_activate = usual[i].activate};
        return;
    }
    ect_yaml_fail(&d->yaml, node, "'dc' takes free-run, sync0, sync01, or {name: DC, activate: 0x0300}, not '%.60s'",
                  word);
}

static void take_mode(ect_draft_t *d, const yaml_node_t *node)
{
    if (node->type == YAML_SCALAR_NODE) {
        take_usual(d, node);
        return;
    }
    ect_draft_mode(d);
    ect_yaml_each(&d->yaml, node, "a clock mode", true, take_mode_key, d);
    if (*last_mode(d)->name == '\0')
        ect_yaml_fail(&d->yaml, node, "a clock mode without 'name'");
}

void ect_draft_clocks(ect_draft_t *d, const yaml_node_t *list)
{
    if (list->type != YAML_SEQUENCE_NODE || list->data.sequence.items.top - list->data.sequence.items.start > MODES) {
        ect_yaml_fail(&d->yaml, list, "'dc' takes a list of at most %d clock modes, as [free-run, sync0]", (int)MODES);
        return;
    }
    for (const yaml_node_item_t *i = list->data.sequence.items.start;
         !d->mistake.failed && i < list->data.sequence.items.top; i++)
        take_mode(d, ect_yaml_node(&d->yaml, *i));
}

/* --- EEPROM ------------------------------------------------------------------------------------------------------- */

static void take_eeprom(void *ctx, const char *key, const yaml_node_t *name, const yaml_node_t *value)
{
    ect_draft_t *d = ctx;
    ect_word_t word = ect_draft_word(d, value, key);
    if (d->mistake.failed)
        return;
    if (strcmp(key, "size") == 0)
        d->device->eeprom_size = (uint32_t)ect_draft_number(d, "size", word, EEPROM_LEAST, EEPROM_MOST);
    else if (strcmp(key, "config") == 0)
        d->device->config = ect_draft_hex(d, "config", word, CONFIG);
    else
        ect_yaml_fail(&d->yaml, name, "'%.60s' is no key of 'eeprom': size, config", key);
}

void ect_draft_eeprom(ect_draft_t *d, const yaml_node_t *eeprom)
{
    ect_yaml_each(&d->yaml, eeprom, "eeprom", true, take_eeprom, d);
}
