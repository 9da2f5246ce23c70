/* SPDX-License-Identifier: MIT */
/* Types come first: basic types in use, then one for each record (DT1018) and two for each array (DT2003ARR, DT2003).
 */
#include <stdio.h>
#include <string.h>

#include "esi/internal.h"

/* The dictionary, and the written types. */
typedef struct list {
    ect_xml_writer_t *xml;
    const ect_device_t *device;
    ect_od_t od;
    const char **names; /* written basic types */
    size_t count;
} list_t;

/* Room for "DT2003ARR". */
typedef struct type_name {
    char text[12];
} type_name_t;

static type_name_t record_type(const ect_object_t *object, const char *suffix)
{
    type_name_t name;
    (void)snprintf(name.text, sizeof name.text, "DT%04X%s", (unsigned int)object->index, suffix);
    return name;
}

static bool is_var(const ect_object_t *object)
{
    return object->object_code == ECT_OBJECT_VAR || object->object_code == ECT_OBJECT_DOMAIN;
}

/* @return the name of an entry's type */
static const char *type_of(const list_t *list, const ect_entry_t *entry)
{
    uint16_t bits = ect_od_bits(&list->od, entry);
    const char *name = ect_esi_type_of(list->xml->arena, entry->data_type, bits);
    return name != NULL ? name : ect_esi_type_of(list->xml->arena, ECT_TYPE_OCTET_STRING, (bits + 7u) / 8u * 8u);
}

static const char *type_of_item(const list_t *list, const ect_object_t *object, const ect_entry_t *entry)
{
    const char *named = ect_xml_enum_type(list->xml, &list->od, object->index, (uint8_t)entry->subindex);
    return named != NULL ? named : type_of(list, entry);
}

/* --- types ------------------------------------------------------------------------------------------------------- */

static bool is_new(list_t *list, const char *name)
{
    for (size_t i = 0; i < list->count; i++) {
        if (strcmp(list->names[i], name) == 0)
            return false;
    }
    list->names = ect_arena_grow(list->xml->arena, list->names, list->count, sizeof *list->names);
    list->names[list->count++] = name;
    return true;
}

static void write_array_info(ect_xml_writer_t *xml, unsigned int first, unsigned int elements)
{
    ect_xml_open(xml, "ArrayInfo");
    ect_xml_number(xml, "LBound", first);
    ect_xml_number(xml, "Elements", elements);
    ect_xml_close(xml);
}

static void write_basic_type(list_t *list, const char *name, unsigned int bits)
{
    ect_xml_writer_t *xml = list->xml;
    bool bytes = strncmp(name, "ARRAY ", 6) == 0;
    if (!is_new(list, name))
        return;
    if (bytes && is_new(list, "BYTE")) {
        ect_xml_open(xml, "DataType");
        ect_xml_text(xml, "Name", "BYTE");
        ect_xml_number(xml, "BitSize", 8);
        ect_xml_close(xml);
    }
    ect_xml_open(xml, "DataType");
    ect_xml_text(xml, "Name", name);
    if (bytes)
        ect_xml_text(xml, "BaseType", "BYTE");
    ect_xml_number(xml, "BitSize", bits);
    if (bytes)
        write_array_info(xml, 0, bits / 8);
    ect_xml_close(xml);
}

static void write_access(ect_xml_writer_t *xml, uint16_t bits, bool restricted)
{
    const char *access = ect_esi_access(bits);
    const char *read_in = ect_esi_states((bits & ECT_ACCESS_R_PREOP) != 0, (bits & ECT_ACCESS_R_SAFEOP) != 0,
                                         (bits & ECT_ACCESS_R_OP) != 0);
    const char *write_in = ect_esi_states((bits & ECT_ACCESS_W_PREOP) != 0, (bits & ECT_ACCESS_W_SAFEOP) != 0,
                                          (bits & ECT_ACCESS_W_OP) != 0);
    if (*access == '\0')
        return;
    ect_xml_open(xml, "Access");
    if (restricted && *read_in != '\0')
        ect_xml_attribute(xml, "ReadRestrictions", "%s", read_in);
    if (restricted && *write_in != '\0')
        ect_xml_attribute(xml, "WriteRestrictions", "%s", write_in);
    ect_xml_content(xml, access);
    ect_xml_close(xml);
}

static void write_entry_flags(ect_xml_writer_t *xml, uint16_t bits)
{
    static const char *const directions[] = {"", "R", "T", "TR"};
    unsigned int mapping = ((bits & ECT_ACCESS_RXPDO) != 0 ? 1u : 0u) | ((bits & ECT_ACCESS_TXPDO) != 0 ? 2u : 0u);
    if (mapping != 0)
        ect_xml_text(xml, "PdoMapping", directions[mapping]);
    if ((bits & ECT_ACCESS_BACKUP) != 0)
        ect_xml_number(xml, "Backup", 1);
    if ((bits & ECT_ACCESS_SETTING) != 0)
        ect_xml_number(xml, "Setting", 1);
}

/* For a whole record only the access is written: sub-items would inherit the other flags. */
static void write_flags(ect_xml_writer_t *xml, uint16_t index, uint16_t bits, bool whole_record)
{
    bool mandatory = index == 0x1000 || index == 0x1018 || index == 0x1C00; /* ETG.1000.6 §5.6.7 */
    ect_xml_open(xml, "Flags");
    write_access(xml, bits, !whole_record);
    ect_xml_text(xml, "Category", mandatory ? "m" : "o");
    if (!whole_record)
        write_entry_flags(xml, bits);
    ect_xml_close(xml);
}

static void write_property(ect_xml_writer_t *xml, const char *name, uint32_t value)
{
    ect_xml_open(xml, "Property");
    ect_xml_text(xml, "Name", name);
    ect_xml_hex(xml, "Value", value, 4);
    ect_xml_close(xml);
}

/* Writes the properties that SDO information reports in a form different from the entry. */
static void write_properties(list_t *list, const ect_object_t *object, const ect_entry_t *entry)
{
    ect_xml_writer_t *xml = list->xml;
    const ect_od_t reported = {.objects = ect_esi_reported(list->device), .count = list->device->object_count};
    const ect_object_t *described = ect_od_find(&reported, object->index);
    const ect_entry_t *other = described != NULL ? ect_od_entry(described, (uint8_t)entry->subindex) : NULL;
    const bool access = other != NULL && ((other->access ^ entry->access) & ECT_ACCESS_WIRE) != 0;
    const bool bits = other != NULL && other->bit_length != entry->bit_length;
    if (!access && !bits)
        return;
    ect_xml_open(xml, "Properties");
    if (access)
        write_property(xml, "SdoInfoAccess", other->access & ECT_ACCESS_WIRE);
    if (bits)
        write_property(xml, "SdoInfoBits", other->bit_length);
    ect_xml_close(xml);
}

static void write_item(list_t *list, const ect_object_t *object, const ect_entry_t *entry)
{
    ect_xml_writer_t *xml = list->xml;
    ect_item_name_t name = ect_esi_item_name(object, entry);
    ect_xml_open(xml, "SubItem");
    ect_xml_number(xml, "SubIdx", entry->subindex);
    ect_xml_text(xml, "Name", *name.unique != '\0' ? name.unique : name.name);
    if (*name.unique != '\0' && *name.name != '\0')
        ect_xml_text(xml, "DisplayName", name.name);
    ect_xml_text(xml, "Type", type_of_item(list, object, entry));
    ect_xml_bits(xml, object->index, (uint8_t)entry->subindex);
    ect_xml_number(xml, "BitSize", ect_od_bits(&list->od, entry));
    ect_xml_number(xml, "BitOffs", ect_esi_item_offset(object, entry));
    write_flags(xml, object->index, entry->access, false);
    write_properties(list, object, entry);
    ect_xml_close(xml);
}

static unsigned int element_bits(const ect_object_t *object)
{
    return ect_od_last(object)->subindex * (unsigned int)ect_od_entry(object, 1)->bit_length;
}

static void write_elements(list_t *list, const ect_object_t *object)
{
    ect_xml_writer_t *xml = list->xml;
    const ect_entry_t *first = ect_od_entry(object, 1);
    ect_xml_open(xml, "SubItem");
    ect_xml_text(xml, "Name", "Elements");
    ect_xml_text(xml, "Type", record_type(object, "ARR").text);
    ect_xml_number(xml, "BitSize", element_bits(object));
    ect_xml_number(xml, "BitOffs", ect_esi_item_offset(object, first));
    write_flags(xml, object->index, first->access, false);
    write_properties(list, object, first);
    ect_xml_close(xml);
}

static void write_array_type(list_t *list, const ect_object_t *object)
{
    ect_xml_writer_t *xml = list->xml;
    ect_xml_open(xml, "DataType");
    ect_xml_text(xml, "Name", record_type(object, "ARR").text);
    ect_xml_text(xml, "BaseType", type_of(list, ect_od_entry(object, 1)));
    ect_xml_number(xml, "BitSize", element_bits(object));
    write_array_info(xml, 1, ect_od_last(object)->subindex);
    ect_xml_close(xml);
}

static void write_record_type(list_t *list, const ect_object_t *object)
{
    ect_xml_writer_t *xml = list->xml;
    bool array = ect_esi_is_array(object);
    if (array)
        write_array_type(list, object);
    ect_xml_open(xml, "DataType");
    ect_xml_text(xml, "Name", record_type(object, "").text);
    ect_xml_number(xml, "BitSize", ect_esi_object_bits(&list->od, object));
    for (const ect_entry_t *e = object->entries; e != NULL; e = ect_od_next(object, e)) {
        if (array && e->subindex == 1) {
            write_elements(list, object);
            break;
        }
        write_item(list, object, e);
    }
    ect_xml_close(xml);
}

static void write_types(list_t *list)
{
    for (uint16_t i = 0; i < list->od.count; i++) {
        const ect_object_t *object = &list->od.objects[i];
        for (const ect_entry_t *e = object->entries; e != NULL; e = ect_od_next(object, e))
            write_basic_type(list, type_of(list, e), ect_od_bits(&list->od, e));
    }
    ect_xml_enum_types(list->xml, &list->od);
    for (uint16_t i = 0; i < list->od.count; i++) {
        if (!is_var(&list->od.objects[i]))
            write_record_type(list, &list->od.objects[i]);
    }
}

/* --- objects ----------------------------------------------------------------------------------------------------- */

/* @return whether a text can be read back: without leading and trailing blanks */
static bool is_plain(const uint8_t *text, size_t size)
{
    return size > 0 && text[0] != ' ' && text[size - 1] != ' ' && strlen((const char *)text) == size;
}

static int64_t number_of(const ect_entry_t *entry, const uint8_t *value, size_t size)
{
    ECT_ASSERT(size > 0 && size <= sizeof(int64_t));
    bool negative = ect_build_is_signed(entry->data_type) && (value[size - 1] & 0x80) != 0;
    uint64_t number = negative ? UINT64_MAX : 0;
    for (size_t i = size; i-- > 0;)
        number = number << 8 | value[i];
    return (int64_t)number;
}

static void write_default(list_t *list, const ect_entry_t *entry, const ect_detail_t *detail)
{
    ect_xml_writer_t *xml = list->xml;
    size_t size;
    const uint8_t *value = ect_esi_entry_value(xml->arena, &list->od, entry, &size);
    if (detail != NULL && detail->minimum != detail->maximum) {
        ect_xml_number(xml, "MinValue", detail->minimum);
        ect_xml_number(xml, "MaxValue", detail->maximum);
        ect_xml_number(xml, "DefaultValue", number_of(entry, value, size));
    } else if (!ect_esi_has_default(entry, value, size)) {
        return;
    } else if (ect_od_is_string(entry) && is_plain(value, size)) {
        ect_xml_text(xml, "DefaultString", (const char *)value);
    } else {
        ect_xml_bytes(xml, "DefaultData", value, size);
    }
}

/* Writes a unit of ETG.1004, 32 bits: prefix, numerator, denominator, a reserved byte. */
static void write_unit(ect_xml_writer_t *xml, const ect_detail_t *detail)
{
    if (detail != NULL && detail->unit != 0)
        ect_xml_hex(xml, "Unit", (uint32_t)detail->unit << 16 | (uint32_t)detail->per << 8, 8);
}

static void write_info(list_t *list, const ect_object_t *object, const ect_entry_t *entry, const char *display)
{
    const ect_detail_t *detail = ect_od_detail(&list->od, object->index, (uint8_t)entry->subindex);
    ect_xml_open(list->xml, "Info");
    write_default(list, entry, detail);
    if (display != NULL)
        ect_xml_text(list->xml, "DisplayName", display);
    write_unit(list->xml, detail);
    ect_xml_close(list->xml);
}

/* Writes the name of an element, because the type of an array has one name for all elements. */
static void write_item_info(list_t *list, const ect_object_t *object, const ect_entry_t *entry)
{
    ect_item_name_t name = ect_esi_item_name(object, entry);
    bool own_name = ect_esi_is_array(object) && entry->subindex != 0 && *name.name != '\0';
    ect_xml_open(list->xml, "SubItem");
    ect_xml_text(list->xml, "Name", *name.unique != '\0' ? name.unique : name.name);
    write_info(list, object, entry, own_name ? name.name : NULL);
    ect_xml_close(list->xml);
}

static uint16_t access_of_all(const ect_object_t *object)
{
    uint16_t bits = 0;
    for (const ect_entry_t *e = object->entries; e != NULL; e = ect_od_next(object, e))
        bits |= e->access;
    return bits;
}

/* @return the name of the entry of a single value; NULL: none other than that of the object */
static const char *name_of_value(const ect_object_t *object)
{
    const char *name = object->entries->name;
    return name != NULL && *name != '\0' && object->name != NULL && strcmp(name, object->name) != 0 ? name : NULL;
}

static void write_object(list_t *list, const ect_object_t *object)
{
    ect_xml_writer_t *xml = list->xml;
    bool record = !is_var(object);
    ect_xml_open(xml, "Object");
    ect_xml_index(xml, "Index", object->index);
    ect_xml_text(xml, "Name", object->name != NULL ? object->name : "");
    ect_xml_text(xml, "Type", record ? record_type(object, "").text : type_of_item(list, object, object->entries));
    ect_xml_number(xml, "BitSize", ect_esi_object_bits(&list->od, object));
    if (record) {
        ect_xml_open(xml, "Info");
        for (const ect_entry_t *e = object->entries; e != NULL; e = ect_od_next(object, e))
            write_item_info(list, object, e);
        ect_xml_close(xml);
    } else {
        write_info(list, object, object->entries, name_of_value(object));
    }
    write_flags(xml, object->index, access_of_all(object), record);
    if (!record)
        write_properties(list, object, object->entries);
    ect_xml_close(xml);
}

void ect_xml_dictionary(ect_xml_writer_t *xml, const ect_device_t *device, const ect_identity_t *identity)
{
    list_t list = {.xml = xml, .device = device, .od = ect_esi_values(xml->arena, device, identity)};
    ect_xml_open(xml, "Dictionary");
    ect_xml_open(xml, "DataTypes");
    write_types(&list);
    ect_xml_close(xml);
    ect_xml_open(xml, "Objects");
    for (uint16_t i = 0; i < list.od.count; i++)
        write_object(&list, &list.od.objects[i]);
    ect_xml_close(xml);
    ect_xml_close(xml);
}
