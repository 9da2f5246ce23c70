/* SPDX-License-Identifier: MIT */
#include <stdlib.h>
#include <string.h>

#include "esi/internal.h"

uint8_t ect_esi_moves(ect_esi_xml_t *xml, const xmlNode *node)
{
    if (node == NULL)
        return 0;
    return (uint8_t)((ect_esi_flag(xml, node, "DependOnSlot") ? ECT_ESI_BY_SLOT : 0) |
                     (ect_esi_flag(xml, node, "DependOnSlotGroup") ? ECT_ESI_BY_GROUP : 0));
}

/* Backup and Setting are numbers; any number except 0 means true. */
static bool is_set(ect_esi_xml_t *xml, const xmlNode *parent, const char *name)
{
    const char *text = ect_esi_text(xml, ect_esi_child(parent, name));
    return *text != '\0' && strcmp(text, "0") != 0 && strcmp(text, "false") != 0;
}

static void read_flags(ect_esi_xml_t *xml, const xmlNode *node, ect_esi_flags_t *flags)
{
    const xmlNode *access = ect_esi_child(node, "Access");
    flags->access = ect_esi_text(xml, access);
    flags->read_in = access != NULL ? ect_esi_attribute(xml, access, "ReadRestrictions") : "";
    flags->write_in = access != NULL ? ect_esi_attribute(xml, access, "WriteRestrictions") : "";
    flags->mapping = ect_esi_text(xml, ect_esi_child(node, "PdoMapping"));
    flags->category = ect_esi_text(xml, ect_esi_child(node, "Category"));
    const xmlNode *attribute = ect_esi_child(node, "Attribute");
    flags->attribute.given =
        attribute != NULL && ect_esi_parse_number(ect_esi_text(xml, attribute), &flags->attribute.value);
    flags->backup = is_set(xml, node, "Backup");
    flags->setting = is_set(xml, node, "Setting");
}

/* Properties of `ectwin clone`: an entry that SDO information describes in another way than its use requires. */
static void read_properties(ect_esi_xml_t *xml, const xmlNode *node, ect_esi_flags_t *flags)
{
    ECT_ESI_EACH(property, ect_esi_child(node, "Properties"), "Property")
    {
        const char *name = ect_esi_text(xml, ect_esi_child(property, "Name"));
        ect_esi_number_t *reported = strcmp(name, "SdoInfoAccess") == 0 ? &flags->reported_access
                                     : strcmp(name, "SdoInfoBits") == 0 ? &flags->reported_bits
                                                                        : NULL;
        if (reported == NULL)
            continue;
        reported->value = ect_esi_number(xml, property, "Value", 0, UINT16_MAX, 0);
        reported->given = true;
    }
}

static ect_esi_bytes_t from_number(ect_esi_xml_t *xml, int64_t value)
{
    uint8_t *bytes = ect_arena_alloc(xml->arena, 8);
    for (unsigned int i = 0; i < 8; i++)
        bytes[i] = (uint8_t)((uint64_t)value >> 8 * i);
    return (ect_esi_bytes_t){.bytes = bytes, .length = 8};
}

/* Reads a limit, a number or bytes (MinData); anything else (a REAL as text) gives no limit. */
static ect_esi_number_t limit_of(ect_esi_xml_t *xml, const xmlNode *info, const char *value, const char *data)
{
    ect_esi_number_t limit = {.given = false};
    const xmlNode *node = ect_esi_child(info, value);
    if (node != NULL) {
        limit.given = ect_esi_parse_number(ect_esi_text(xml, node), &limit.value);
        return limit;
    }
    ect_esi_bytes_t bytes = ect_esi_hex(xml, info, data);
    if (bytes.bytes == NULL || bytes.length == 0 || bytes.length > 8)
        return limit;
    uint64_t number = 0;
    for (size_t i = bytes.length; i-- > 0;)
        number = number << 8 | bytes.bytes[i];
    limit.given = true;
    limit.bytes = (uint8_t)bytes.length;
    limit.value = (int64_t)number;
    return limit;
}

static void read_info(ect_esi_xml_t *xml, const xmlNode *info, ect_esi_info_t *result)
{
    const xmlNode *text = ect_esi_child(info, "DefaultString");
    const xmlNode *value = ect_esi_child(info, "DefaultValue");
    int64_t number;
    if (ect_esi_child(info, "DefaultData") != NULL) {
        result->initial = ect_esi_hex(xml, info, "DefaultData");
    } else if (text != NULL) {
        const char *string = ect_esi_text(xml, text);
        result->initial = (ect_esi_bytes_t){.bytes = (const uint8_t *)string, .length = strlen(string)};
    } else if (value != NULL && ect_esi_parse_number(ect_esi_text(xml, value), &number)) {
        result->initial = from_number(xml, number);
        result->initial_is_number = true;
    }
    result->minimum = limit_of(xml, info, "MinValue", "MinData");
    result->maximum = limit_of(xml, info, "MaxValue", "MaxData");
    if (ect_esi_parse_number(ect_esi_text(xml, ect_esi_child(info, "Unit")), &number))
        result->unit = (uint32_t)number;
    result->name = "";
    result->display = ect_esi_name(xml, info, "DisplayName");
}

static void read_item(ect_esi_xml_t *xml, const xmlNode *node, ect_esi_item_t *item)
{
    item->subindex = (int)ect_esi_number(xml, node, "SubIdx", 0, UINT8_MAX, -1);
    item->name = ect_esi_name(xml, node, "Name");
    item->display = ect_esi_name(xml, node, "DisplayName");
    item->type = ect_esi_text(xml, ect_esi_child(node, "Type"));
    item->bits = (uint32_t)ect_esi_number(xml, node, "BitSize", 0, UINT32_MAX, 0);
    item->offset = (uint32_t)ect_esi_number(xml, node, "BitOffs", 0, UINT32_MAX, 0);
    item->line = ect_esi_line(node);
    read_flags(xml, ect_esi_child(node, "Flags"), &item->flags);
    read_properties(xml, node, &item->flags);
    read_info(xml, node, &item->info);
}

static void read_enum(ect_esi_xml_t *xml, const xmlNode *node, ect_esi_type_t *type)
{
    ECT_ESI_EACH(child, node, "EnumInfo")
    {
        int64_t value = ect_esi_number(xml, child, "Enum", INT64_MIN, INT64_MAX, 0);
        if (!type->is_enum || value < type->lowest)
            type->lowest = value;
        if (!type->is_enum || value > type->highest)
            type->highest = value;
        type->is_enum = true;
    }
}

static void read_type(ect_esi_xml_t *xml, const xmlNode *node, ect_esi_type_t *type)
{
    ect_esi_item_t *items = NULL;
    ect_esi_item_t *item;
    const xmlNode *array = ect_esi_child(node, "ArrayInfo");
    type->name = ect_esi_text(xml, ect_esi_child(node, "Name"));
    type->base = ect_esi_text(xml, ect_esi_child(node, "BaseType"));
    type->bits = (uint32_t)ect_esi_number(xml, node, "BitSize", 0, UINT32_MAX, 0);
    if (array != NULL) {
        type->first =
            (ect_esi_number_t){.given = true, .value = ect_esi_number(xml, array, "LBound", 0, UINT16_MAX, 0)};
        type->elements =
            (ect_esi_number_t){.given = true, .value = ect_esi_number(xml, array, "Elements", 0, UINT16_MAX, 0)};
    }
    read_enum(xml, node, type);
    ECT_ESI_EACH(child, node, "SubItem")
    {
        ECT_APPEND(xml, items, type->item_count, item);
        read_item(xml, child, item);
    }
    type->items = items;
}

static void read_object(ect_esi_xml_t *xml, const xmlNode *node, ect_esi_object_t *object)
{
    ect_esi_info_t *items = NULL;
    ect_esi_info_t *item;
    const xmlNode *index = ect_esi_child(node, "Index");
    const xmlNode *info = ect_esi_child(node, "Info");
    object->index = (uint16_t)ect_esi_number(xml, node, "Index", 0, UINT16_MAX, 0);
    object->moves = ect_esi_moves(xml, index);
    object->name = ect_esi_name(xml, node, "Name");
    object->type = ect_esi_text(xml, ect_esi_child(node, "Type"));
    object->bits = (uint32_t)ect_esi_number(xml, node, "BitSize", 0, UINT32_MAX, 0);
    object->line = ect_esi_line(node);
    read_flags(xml, ect_esi_child(node, "Flags"), &object->flags);
    read_properties(xml, node, &object->flags);
    read_info(xml, info, &object->info);
    ECT_ESI_EACH(child, info, "SubItem")
    {
        ECT_APPEND(xml, items, object->item_count, item);
        read_info(xml, ect_esi_child(child, "Info"), item);
        item->name = ect_esi_name(xml, child, "Name");
    }
    object->items = items;
    if (index == NULL)
        ect_esi_fail(xml, node, "Object has no Index");
}

static int by_name(const void *a, const void *b)
{
    const ect_esi_type_t *left = *(const ect_esi_type_t *const *)a;
    const ect_esi_type_t *right = *(const ect_esi_type_t *const *)b;
    int order = strcmp(left->name, right->name);
    return order != 0 ? order : (left > right) - (left < right);
}

/* Sorts the types, which are searched for each entry. */
static const ect_esi_type_t *const *sorted(ect_esi_xml_t *xml, const ect_esi_type_t *types, size_t count)
{
    const ect_esi_type_t **list = ect_arena_alloc(xml->arena, (count + 1) * sizeof *list);
    for (size_t i = 0; i < count; i++)
        list[i] = &types[i];
    if (count > 0)
        qsort(list, count, sizeof *list, by_name);
    return list;
}

void ect_esi_read_dictionary(ect_esi_xml_t *xml, const xmlNode *profile, ect_esi_dictionary_t *dictionary)
{
    const xmlNode *node = ect_esi_child(profile, "Dictionary");
    ect_esi_type_t *types = (ect_esi_type_t *)(uintptr_t)dictionary->types; // made by the last call
    ect_esi_type_t *type;
    ect_esi_object_t *objects = (ect_esi_object_t *)(uintptr_t)dictionary->objects;
    ect_esi_object_t *object;
    ECT_ESI_EACH(child, ect_esi_child(node, "DataTypes"), "DataType")
    {
        ECT_APPEND(xml, types, dictionary->type_count, type);
        read_type(xml, child, type);
    }
    ECT_ESI_EACH(child, ect_esi_child(node, "Objects"), "Object")
    {
        ECT_APPEND(xml, objects, dictionary->object_count, object);
        read_object(xml, child, object);
    }
    dictionary->types = types;
    dictionary->types_by_name = sorted(xml, types, dictionary->type_count);
    dictionary->objects = objects;
}
