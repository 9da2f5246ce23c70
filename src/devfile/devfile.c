/* SPDX-License-Identifier: MIT */
#include "devfile/devfile.h"

#include <stdlib.h>
#include <string.h>

#include "devfile/internal.h"
#include "esi/single.h"

enum { VERSION = 1 };

/* The keys of a device. */
typedef struct keys {
    ect_draft_t *d;
    const yaml_node_t *version, *vendor, *product, *revision, *type, *name, *group, *profile, *physics;
    const yaml_node_t *objects, *inputs, *outputs, *mailbox, *syncmanagers, *dc, *eeprom;
    ect_draft_rack_t rack;
} keys_t;

static void take_key(void *ctx, const char *key, const yaml_node_t *name, const yaml_node_t *value)
{
    keys_t *k = ctx;
    const struct {
        const char *name;
        const yaml_node_t **node;
    } nodes[] = {
        {"ectwin-device", &k->version},
        {"vendor", &k->vendor},
        {"product", &k->product},
        {"revision", &k->revision},
        {"type", &k->type},
        {"name", &k->name},
        {"group", &k->group},
        {"profile", &k->profile},
        {"physics", &k->physics},
        {"objects", &k->objects},
        {"inputs", &k->inputs},
        {"outputs", &k->outputs},
        {"mailbox", &k->mailbox},
        {"syncmanagers", &k->syncmanagers},
        {"dc", &k->dc},
        {"eeprom", &k->eeprom},
        {"slots", &k->rack.slots},
        {"modules", &k->rack.modules},
        {"slot-increments", &k->rack.increments},
        {"download-idents", &k->rack.download},
    };
    for (size_t i = 0; i < sizeof nodes / sizeof nodes[0]; i++) {
        if (strcmp(nodes[i].name, key) == 0) {
            *nodes[i].node = value;
            return;
        }
    }
    ect_yaml_fail(
        &k->d->yaml, name,
        "'%.60s' is no key of a device: ectwin-device, vendor, product, revision, type, name, group, profile, "
        "physics, objects, inputs, outputs, mailbox, syncmanagers, dc, eeprom, slots, modules, slot-increments, "
        "download-idents",
        key);
}

/* --- identity ----------------------------------------------------------------------------------------------------- */

static const char *text_of(ect_draft_t *d, const char *key, const yaml_node_t *node, const char *otherwise)
{
    const char *text = node != NULL ? ect_yaml_scalar(&d->yaml, node, key) : otherwise;
    if (node != NULL && *text == '\0')
        ect_yaml_fail(&d->yaml, node, "'%s' is empty", key);
    return ect_arena_copy(d->arena, text, strlen(text));
}

static uint32_t number_of(ect_draft_t *d, const char *key, const yaml_node_t *node, uint32_t otherwise)
{
    if (node == NULL || d->mistake.failed)
        return otherwise;
    ect_word_t word = ect_draft_word(d, node, key);
    return d->mistake.failed ? otherwise : (uint32_t)ect_draft_number(d, key, word, 0, UINT32_MAX);
}

static void take_vendor(void *ctx, const char *key, const yaml_node_t *name, const yaml_node_t *value)
{
    ect_draft_t *d = ctx;
    if (strcmp(key, "id") == 0)
        d->device->vendor_id = number_of(d, "id", value, 0);
    else if (strcmp(key, "name") == 0)
        d->device->vendor_name = text_of(d, "name", value, "");
    else
        ect_yaml_fail(&d->yaml, name, "'%.60s' is no key of 'vendor': id, name", key);
}

static void require(const keys_t *k, const yaml_node_t *root)
{
    const struct {
        const char *name;
        const yaml_node_t *node;
        const char *cure;
    } needed[] = {
        {"vendor", k->vendor, "{id: 0x00000E57, name: Example Works}"},
        {"product", k->product, "0x00000101"},
        {"type", k->type, "GAUGE-1"},
    };
    for (size_t i = 0; i < sizeof needed / sizeof needed[0]; i++) {
        if (needed[i].node == NULL)
            ect_yaml_fail(&k->d->yaml, root, "'%s' is missing, as in '%s: %s'", needed[i].name, needed[i].name,
                          needed[i].cure);
    }
}

static void take_physics(ect_draft_t *d, const yaml_node_t *node)
{
    d->device->physics = text_of(d, "physics", node, "YY");
    size_t length = strlen(d->device->physics);
    if (length > 4 || strspn(d->device->physics, "YKH ") != length)
        ect_yaml_fail(&d->yaml, node,
                      "'physics' takes one letter for each port, up to 4: Y for MII, K for LVDS, H for fast MII");
}

static void take_identity(const keys_t *k)
{
    ect_draft_t *d = k->d;
    ect_esi_device_t *device = d->device;
    ect_yaml_each(&d->yaml, k->vendor, "vendor", true, take_vendor, d);
    if (!d->mistake.failed && (device->vendor_id == 0 || *device->vendor_name == '\0'))
        ect_yaml_fail(&d->yaml, k->vendor, "'vendor' takes both: {id: 0x00000E57, name: Example Works}");
    device->product_code = number_of(d, "product", k->product, 0);
    device->revision = number_of(d, "revision", k->revision, 1);
    device->profile = number_of(d, "profile", k->profile, 0);
    device->type = text_of(d, "type", k->type, "");
    device->name = text_of(d, "name", k->name, device->type);
    device->group_type = device->group_name = text_of(d, "group", k->group, "Devices");
    take_physics(d, k->physics);
    device->line = (int)ect_yaml_line(k->type);
}

/* --- the whole ---------------------------------------------------------------------------------------------------- */

static void take_parts(const keys_t *k)
{
    ect_draft_t *d = k->d;
    take_identity(k);
    if (!d->mistake.failed)
        ect_draft_mailbox(d, k->mailbox);
    if (!d->mistake.failed && k->objects != NULL)
        ect_draft_objects(d, k->objects);
    if (!d->mistake.failed && k->outputs != NULL)
        ect_draft_pdos(d, k->outputs, false);
    if (!d->mistake.failed && k->inputs != NULL)
        ect_draft_pdos(d, k->inputs, true);
    if (!d->mistake.failed && k->dc != NULL)
        ect_draft_clocks(d, k->dc);
    if (!d->mistake.failed && k->eeprom != NULL)
        ect_draft_eeprom(d, k->eeprom);
    if (!d->mistake.failed)
        ect_draft_rack(d, &k->rack);
    if (!d->mistake.failed)
        ect_draft_syncmanagers(d, k->syncmanagers);
    if (!d->mistake.failed)
        ect_draft_end(d);
}

/* Reports a document that is no device file of this version. @param version  its version; NULL: none */
static void refuse_other(ect_draft_t *d, const yaml_node_t *root, const yaml_node_t *version)
{
    const bool is_bus = version == NULL && root != NULL && root->type == YAML_MAPPING_NODE &&
                        ect_yaml_find(&d->yaml, root, "twins") != NULL;
    if (is_bus)
        ect_yaml_fail(&d->yaml, root, "a bus file, not a device: run it alone, as in 'ectwin run -i IFACE %s'",
                      d->mistake.path);
    else
        ect_yaml_fail(
            &d->yaml, version != NULL ? version : root,
            "'ectwin-device: %d' is missing: the version of the format of device files that this ectwin reads",
            (int)VERSION);
}

static void take_document(ect_draft_t *d)
{
    keys_t k = {.d = d};
    int64_t version = 0;
    const yaml_node_t *root = ect_yaml_root(&d->yaml);
    const yaml_node_t *first =
        root != NULL && root->type == YAML_MAPPING_NODE ? ect_yaml_find(&d->yaml, root, "ectwin-device") : NULL;
    if (first == NULL && root != NULL && root->type == YAML_MAPPING_NODE && ect_draft_is_project(d, root)) {
        ect_draft_project(d, root);
        return;
    }
    if (first != NULL)
        version = ect_draft_number(d, "ectwin-device", ect_draft_word(d, first, "ectwin-device"), 0, UINT32_MAX);
    if (version != VERSION) {
        refuse_other(d, root, first);
        return;
    }
    ect_yaml_each(&d->yaml, root, "the device", true, take_key, &k);
    if (!d->mistake.failed)
        require(&k, root);
    if (!d->mistake.failed)
        take_parts(&k);
}

ect_esi_t *ect_devfile_parse(const char *path, const void *data, size_t length, char *text, size_t room)
{
    ect_draft_t d = {.mistake = {.path = path, .text = text, .room = room}};
    ect_esi_t *esi = ect_esi_single_begin(path, text, room);
    if (esi == NULL)
        return NULL;
    d.device = ect_esi_single_device(esi, &d.arena);
    if (ect_yaml_open(&d.yaml, "device file", &d.mistake, data, length)) {
        take_document(&d);
        ect_yaml_close(&d.yaml);
    }
    if (d.mistake.failed) {
        ect_esi_close(esi);
        return NULL;
    }
    ect_esi_single_end(esi, "device file");
    return esi;
}

ect_esi_t *ect_devfile_open(const char *path, char *text, size_t room)
{
    size_t length = 0;
    char *data = ect_yaml_load(path, ECT_DEVFILE_BYTES, &length, text, room);
    ect_esi_t *esi = data != NULL ? ect_devfile_parse(path, data, length, text, room) : NULL;
    free(data);
    return esi;
}
