/* SPDX-License-Identifier: MIT */
#include "esi/read.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "esi/internal.h"

static ect_esi_xml_t context(ect_esi_t *esi, char *text, size_t room)
{
    return (ect_esi_xml_t){.arena = &esi->arena, .file = esi->file, .text = text, .room = room, .folder = esi->folder};
}

static size_t count_of(const xmlNode *parent, const char *name)
{
    size_t count = 0;
    ECT_ESI_EACH(node, parent, name)
    count++;
    return count;
}

static const char *add_extra(ect_esi_xml_t *xml, const char *text, size_t count, const char *what)
{
    if (count == 0)
        return text;
    return ect_arena_print(xml->arena, "%s%s%s: %zu", text, *text != '\0' ? ", " : "", what, count);
}

static const char *extras_of(ect_esi_xml_t *xml, const xmlNode *device)
{
    const xmlNode *vendor = ect_esi_child(ect_esi_child(device, "Info"), "VendorSpecific");
    const char *text = add_extra(xml, "", count_of(ect_esi_child(device, "Slots"), "Slot"), "slots");
    text = add_extra(xml, text, count_of(ect_esi_child(ect_esi_child(device, "Mailbox"), "CoE"), "InitCmd"),
                     "start-up commands");
    text = add_extra(xml, text, count_of(ect_esi_child(vendor, "TwinCAT"), "AlternativeSmMapping"),
                     "alternative assignments");
    return add_extra(xml, text, count_of(ect_esi_child(device, "Eeprom"), "Category"), "EEPROM categories");
}

static void read_heads(ect_esi_t *esi, ect_esi_xml_t *xml, const xmlNode *devices)
{
    ECT_ESI_EACH(node, devices, "Device")
    {
        const xmlNode *type = ect_esi_child(node, "Type");
        if (type == NULL) {
            ect_esi_fail(xml, node, "Device has no Type");
            return;
        }
        esi->heads = ect_arena_grow(&esi->arena, esi->heads, esi->count, sizeof *esi->heads);
        esi->nodes = ect_arena_grow(&esi->arena, esi->nodes, esi->count, sizeof *esi->nodes);
        esi->nodes[esi->count] = node;
        ect_esi_head_t *head = &esi->heads[esi->count++];
        head->type = ect_esi_text(xml, type);
        head->name = ect_esi_name(xml, node, "Name");
        head->product_code = (uint32_t)ect_esi_attribute_number(xml, type, "ProductCode", 0, UINT32_MAX, 0);
        head->revision = (uint32_t)ect_esi_attribute_number(xml, type, "RevisionNo", 0, UINT32_MAX, 0);
        head->extras = extras_of(xml, node);
        head->line = ect_esi_line(node);
    }
}

ect_esi_t *ect_esi_parse(const char *name, const void *data, size_t length, char *text, size_t room)
{
    xmlDocPtr document = ect_esi_document("ESI", name, data, length, text, room);
    if (document == NULL)
        return NULL;
    ect_esi_t *esi = calloc(1, sizeof *esi);
    if (esi == NULL) {
        (void)snprintf(text, room, "%s: no memory left", name);
        xmlFreeDoc(document);
        return NULL;
    }
    esi->document = document;
    esi->file = ect_arena_copy(&esi->arena, name, strlen(name));
    esi->root = xmlDocGetRootElement(document);

    ect_esi_xml_t xml = context(esi, text, room);
    const xmlNode *descriptions = ect_esi_child(esi->root, "Descriptions");
    if (!ect_esi_is(esi->root, "EtherCATInfo") || descriptions == NULL)
        ect_esi_fail(&xml, esi->root, "no ESI file: the root is %s, not EtherCATInfo with Descriptions",
                     (const char *)esi->root->name);
    read_heads(esi, &xml, ect_esi_child(descriptions, "Devices"));
    if (esi->count == 0)
        ect_esi_fail(&xml, esi->root, "there is no device in it");
    if (xml.failed) {
        ect_esi_close(esi);
        return NULL;
    }
    return esi;
}

ect_esi_t *ect_esi_open(const char *path, char *text, size_t room)
{
    ect_esi_file_t file = ect_esi_load(path, text, room);
    ect_esi_t *esi = file.data != NULL ? ect_esi_parse(path, file.data, file.length, text, room) : NULL;
    free(file.data);
    if (esi != NULL) {
        const char *slash = strrchr(path, '/');
        esi->folder = slash != NULL ? ect_arena_copy(&esi->arena, path, (size_t)(slash - path) + 1) : "";
    }
    return esi;
}

const char *ect_esi_selector(const char *operand)
{
    const char *first = access(operand, F_OK) != 0 ? strchr(operand, '#') : NULL;
    for (const char *hash = first; hash != NULL; hash = strchr(hash + 1, '#')) {
        char *path = strndup(operand, (size_t)(hash - operand));
        bool there = path != NULL && access(path, F_OK) == 0;
        free(path);
        if (there)
            return hash;
    }
    return first;
}

const char *ect_esi_file(const ect_esi_t *esi)
{
    return esi->file;
}

const ect_esi_head_t *ect_esi_heads(const ect_esi_t *esi, size_t *count)
{
    *count = esi->count;
    return esi->heads;
}

/* A parsed selector: a type, or numbers. */
typedef struct selection {
    const char *type; // NULL: any
    bool product_given, revision_given;
    int64_t product, revision;
} selection_t;

static bool parse_selector(const char *selector, selection_t *selection)
{
    *selection = (selection_t){.type = NULL};
    if (*selector == '\0')
        return true;
    if (*selector != '@') {
        selection->type = selector;
        return true;
    }
    char number[64];
    const char *slash = strchr(selector, '/');
    size_t length = slash != NULL ? (size_t)(slash - selector) - 1 : strlen(selector) - 1;
    if (length >= sizeof number)
        return false;
    memcpy(number, selector + 1, length);
    number[length] = '\0';
    selection->product_given = true;
    selection->revision_given = slash != NULL;
    return ect_esi_parse_number(number, &selection->product) &&
           (slash == NULL || ect_esi_parse_number(slash + 1, &selection->revision));
}

static bool fits(const selection_t *selection, const ect_esi_head_t *head)
{
    return (selection->type == NULL || strcmp(selection->type, head->type) == 0) &&
           (!selection->product_given || selection->product == head->product_code) &&
           (!selection->revision_given || selection->revision == head->revision);
}

/* @param[out] other  a matching device of another type @return the matching device with the highest revision */
static size_t choose(const ect_esi_t *esi, const selection_t *selection, size_t *other)
{
    size_t best = esi->count;
    *other = esi->count;
    for (size_t i = 0; i < esi->count; i++) {
        if (!fits(selection, &esi->heads[i]))
            continue;
        if (best != esi->count && *other == esi->count && strcmp(esi->heads[best].type, esi->heads[i].type) != 0)
            *other = i;
        if (best == esi->count || esi->heads[i].revision > esi->heads[best].revision)
            best = i;
    }
    return best;
}

const ect_esi_device_t *ect_esi_select(ect_esi_t *esi, const char *selector, char *text, size_t room)
{
    selection_t selection;
    if (!parse_selector(selector, &selection)) {
        (void)snprintf(text, room, "%s: \"%s\" is not TYPE, @PRODUCT or @PRODUCT/REVISION", esi->file, selector);
        return NULL;
    }
    size_t other;
    size_t chosen = choose(esi, &selection, &other);
    if (chosen == esi->count) {
        (void)snprintf(text, room, "%s: no device \"%s\" in it; `ectwin list esi:%s` lists the devices", esi->file,
                       selector, esi->file);
        return NULL;
    }
    if (other != esi->count) {
        (void)snprintf(text, room, "%s: %s and %s both fit: name one, as in esi:%s#%s", esi->file,
                       esi->heads[chosen].type, esi->heads[other].type, esi->file, esi->heads[chosen].type);
        return NULL;
    }
    ECT_ASSERT(chosen < esi->count);
    if (esi->device != NULL)
        return esi->device;
    ect_esi_xml_t xml = context(esi, text, room);
    ect_esi_device_t *device = ect_esi_read_device(&xml, esi->root, esi->nodes[chosen]);
    device->place = chosen;
    device->esi = esi;
    return xml.failed ? NULL : device;
}

void ect_esi_close(ect_esi_t *esi)
{
    if (esi == NULL)
        return;
    xmlFreeDoc(esi->document);
    ect_arena_free(&esi->arena);
    free(esi);
}
