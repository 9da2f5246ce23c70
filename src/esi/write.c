/* SPDX-License-Identifier: MIT */
#include "esi/write.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "esi/internal.h"

static const ect_identity_t *identity_of(const ect_esi_part_t *part)
{
    return part->identity != NULL ? part->identity : &part->device->identity;
}

static bool agree(const ect_esi_part_t *parts, size_t count, char *text, size_t room)
{
    for (size_t i = 1; i < count; i++) {
        const ect_identity_t *own = identity_of(&parts[i]);
        if (own->vendor_id != identity_of(&parts[0])->vendor_id) {
            (void)snprintf(text, room, "%s and %s have different vendors: a file has one", parts[0].device->type_name,
                           parts[i].device->type_name);
            return false;
        }
        for (size_t k = 0; k < i; k++) {
            const ect_identity_t *other = identity_of(&parts[k]);
            if (other->product_code != own->product_code || other->revision != own->revision)
                continue;
            (void)snprintf(text, room,
                           "%s and %s both have product code 0x%08" PRIX32 " and revision 0x%08" PRIX32
                           ": no tool can distinguish them",
                           parts[k].device->type_name, parts[i].device->type_name, own->product_code, own->revision);
            return false;
        }
    }
    return true;
}

static bool group_is_new(const ect_esi_part_t *parts, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        if (strcmp(parts[i].device->group_type, parts[n].device->group_type) == 0)
            return false;
    }
    return true;
}

static void write_head(ect_xml_writer_t *xml, const ect_esi_part_t *part)
{
    ect_xml_attribute(xml, "xmlns:xsi", "http://www.w3.org/2001/XMLSchema-instance");
    ect_xml_attribute(xml, "xsi:noNamespaceSchemaLocation", "EtherCATInfo.xsd");
    ect_xml_attribute(xml, "Version", "1.14");
    ect_xml_open(xml, "Vendor");
    ect_xml_hex(xml, "Id", identity_of(part)->vendor_id, 8);
    ect_xml_text(xml, "Name", part->device->vendor_name);
    ect_xml_close(xml);
}

/* Writes a modular device without modules: slots and modules of its file are copied. */
static void write_device(ect_xml_writer_t *xml, const ect_esi_part_t *part)
{
    ect_esi_twin_t *bare = part->twin != NULL ? ect_esi_twin_without_modules(part->twin) : NULL;
    ect_esi_part_t written = *part;
    if (bare != NULL)
        written.device = ect_esi_twin_product(bare)->device;
    ect_xml_device(xml, &written, bare != NULL);
    ect_esi_twin_free(bare);
}

/* Writes the modules of each file of a device with slots, once for each file. */
static void write_modules(ect_xml_writer_t *xml, const ect_esi_part_t *parts, size_t count)
{
    const xmlNode *written = NULL;
    bool open = false;
    for (size_t i = 0; i < count; i++) {
        const xmlNode *device = ect_xml_source(&parts[i]);
        const xmlNode *descriptions = device != NULL ? device->parent->parent : NULL;
        const ect_esi_device_t *model =
            parts[i].twin != NULL && device == NULL ? ect_esi_twin_model(parts[i].twin) : NULL;
        const bool own = model != NULL && model->slot_count > 0;
        if (!own && (ect_esi_child(device, "Slots") == NULL || descriptions == written))
            continue;
        if (!open)
            ect_xml_open(xml, "Modules");
        open = true;
        written = descriptions;
        if (own)
            xml->failed |= !ect_xml_modules(xml, model);
        else
            ect_xml_copy_children(xml, ect_esi_child(descriptions, "Modules"), "Module");
    }
    if (open)
        ect_xml_close(xml);
}

static void write_descriptions(ect_xml_writer_t *xml, const ect_esi_part_t *parts, size_t count)
{
    ect_xml_open(xml, "Descriptions");
    ect_xml_open(xml, "Groups");
    for (size_t i = 0; i < count; i++) {
        if (!group_is_new(parts, i))
            continue;
        ect_xml_open(xml, "Group");
        ect_xml_text(xml, "Type", parts[i].device->group_type);
        ect_xml_text(xml, "Name", parts[i].device->group_name);
        ect_xml_close(xml);
    }
    ect_xml_close(xml);
    ect_xml_open(xml, "Devices");
    for (size_t i = 0; i < count; i++)
        write_device(xml, &parts[i]);
    ect_xml_close(xml);
    write_modules(xml, parts, count);
    ect_xml_close(xml);
}

typedef struct content {
    const ect_esi_part_t *parts;
    size_t count;
} content_t;

static void write_file(ect_xml_writer_t *xml, const void *what)
{
    const content_t *content = what;
    ect_xml_open(xml, "EtherCATInfo");
    write_head(xml, &content->parts[0]);
    write_descriptions(xml, content->parts, content->count);
    ect_xml_close(xml);
}

const char *ect_esi_write(ect_arena_t *arena, const ect_esi_part_t *parts, size_t count, size_t *length, char *text,
                          size_t room)
{
    ECT_ASSERT(parts != NULL && count > 0);
    const content_t content = {parts, count};
    return agree(parts, count, text, room) ? ect_xml_file(arena, write_file, &content, length, text, room) : NULL;
}
