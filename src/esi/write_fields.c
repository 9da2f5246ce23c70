/* SPDX-License-Identifier: MIT */
/*
 * Names of values and bits (seams/fields.h). An entry whose values all have names gets a type with EnumInfo; named bits
 * become a comment, because the schema has bits of an entry only in PDO structures.
 */
#include <stdio.h>
#include <string.h>

#include "esi/internal.h"

/* No named bits and values. */
static const ect_field_t none[] = {{0}};

static const ect_field_t *fields_of(const ect_xml_writer_t *xml)
{
    return xml->plant != NULL && xml->plant->fields != NULL ? xml->plant->fields : none;
}

static const ect_entry_t *entry_of(const ect_od_t *od, const ect_field_t *field)
{
    const ect_object_t *object = ect_od_find(od, field->index);
    return object != NULL ? ect_od_entry(object, field->subindex) : NULL;
}

static bool is_enumeration(const ect_field_t *field)
{
    return field->width == 0 && field->values != NULL && !field->open;
}

/* @return the first field with the same values and entry length, whose number names the type */
static const ect_field_t *first_alike(const ect_xml_writer_t *xml, const ect_od_t *od, const ect_field_t *field)
{
    uint16_t bits = ect_od_bits(od, entry_of(od, field));
    const ect_field_t *first = fields_of(xml);
    while (!is_enumeration(first) || first->values != field->values || entry_of(od, first) == NULL ||
           ect_od_bits(od, entry_of(od, first)) != bits)
        first++;
    return first;
}

static const char *enum_name(ect_xml_writer_t *xml, const ect_field_t *field)
{
    return ect_arena_print(xml->arena, "DT%04XEN%02X", field->index, field->subindex);
}

const char *ect_xml_enum_type(ect_xml_writer_t *xml, const ect_od_t *od, uint16_t index, uint8_t subindex)
{
    for (const ect_field_t *f = fields_of(xml); f->index != 0; f++) {
        if (f->index == index && f->subindex == subindex && is_enumeration(f))
            return enum_name(xml, first_alike(xml, od, f));
    }
    return NULL;
}

static void write_enum_type(ect_xml_writer_t *xml, const ect_od_t *od, const ect_field_t *field)
{
    const ect_entry_t *entry = entry_of(od, field);
    uint16_t bits = ect_od_bits(od, entry);
    ect_xml_open(xml, "DataType");
    ect_xml_text(xml, "Name", enum_name(xml, field));
    ect_xml_text(xml, "BaseType", ect_esi_type_of(xml->arena, entry->data_type, bits));
    ect_xml_number(xml, "BitSize", bits);
    for (const ect_value_name_t *v = field->values; v->name != NULL; v++) {
        ect_xml_open(xml, "EnumInfo");
        ect_xml_text(xml, "Text", v->name);
        ect_xml_number(xml, "Enum", v->value);
        ect_xml_close(xml);
    }
    ect_xml_close(xml);
}

void ect_xml_enum_types(ect_xml_writer_t *xml, const ect_od_t *od)
{
    for (const ect_field_t *f = fields_of(xml); f->index != 0; f++) {
        if (is_enumeration(f) && entry_of(od, f) != NULL && first_alike(xml, od, f) == f)
            write_enum_type(xml, od, f);
    }
}

/* "bit 2 READY: STEP can be accepted", "bits 0 to 3 Distance 1" */
static const char *bits_text(ect_xml_writer_t *xml, const ect_field_t *f)
{
    const char *place = f->width == 1 ? ect_arena_print(xml->arena, "bit %u", f->bit)
                                      : ect_arena_print(xml->arena, "bits %u to %u", f->bit, f->bit + f->width - 1u);
    return ect_arena_print(xml->arena, "%s %s%s%s", place, f->name, f->meaning != NULL ? ": " : "",
                           f->meaning != NULL ? f->meaning : "");
}

void ect_xml_bits(ect_xml_writer_t *xml, uint16_t index, uint8_t subindex)
{
    const char *text = NULL;
    for (const ect_field_t *f = fields_of(xml); f->index != 0; f++) {
        if (f->index != index || f->subindex != subindex || f->width == 0)
            continue;
        text = text == NULL ? bits_text(xml, f) : ect_arena_print(xml->arena, "%s; %s", text, bits_text(xml, f));
    }
    if (text != NULL)
        ect_xml_text(xml, "Comment", text);
}
