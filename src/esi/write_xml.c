/* SPDX-License-Identifier: MIT */
#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "esi/internal.h"

static void note(ect_xml_writer_t *xml, int result)
{
    xml->failed |= result < 0;
}

static bool write_document(ect_xml_writer_t *xml, void (*write)(ect_xml_writer_t *xml, const void *what),
                           const void *what)
{
    note(xml, xmlTextWriterSetIndent(xml->writer, 1));
    note(xml, xmlTextWriterSetIndentString(xml->writer, BAD_CAST "  "));
    note(xml, xmlTextWriterStartDocument(xml->writer, "1.0", "UTF-8", NULL));
    write(xml, what);
    note(xml, xmlTextWriterEndDocument(xml->writer));
    return !xml->failed;
}

const char *ect_xml_file(ect_arena_t *arena, void (*write)(ect_xml_writer_t *xml, const void *what), const void *what,
                         size_t *length, char *text, size_t room)
{
    const char *file = NULL;
    xmlBufferPtr buffer = xmlBufferCreate();
    ect_xml_writer_t xml = {.writer = buffer != NULL ? xmlNewTextWriterMemory(buffer, 0) : NULL, .arena = arena};
    bool fine = xml.writer != NULL && write_document(&xml, write, what);
    xmlFreeTextWriter(xml.writer);
    if (fine) {
        *length = (size_t)xmlBufferLength(buffer);
        file = ect_arena_copy(arena, (const char *)xmlBufferContent(buffer), *length);
    } else {
        (void)snprintf(text, room, "the file could not be written: no memory left");
    }
    if (buffer != NULL)
        xmlBufferFree(buffer);
    return file;
}

void ect_xml_open(ect_xml_writer_t *xml, const char *element)
{
    note(xml, xmlTextWriterStartElement(xml->writer, BAD_CAST element));
}

void ect_xml_close(ect_xml_writer_t *xml)
{
    note(xml, xmlTextWriterEndElement(xml->writer));
}

void ect_xml_attribute(ect_xml_writer_t *xml, const char *name, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    note(xml, xmlTextWriterWriteVFormatAttribute(xml->writer, BAD_CAST name, format, arguments));
    va_end(arguments);
}

void ect_xml_flag(ect_xml_writer_t *xml, const char *name, bool value)
{
    if (value)
        ect_xml_attribute(xml, name, "true");
}

void ect_xml_content(ect_xml_writer_t *xml, const char *text)
{
    bool special = strpbrk(text, "<>&") != NULL && strstr(text, "]]>") == NULL;
    note(xml, special ? xmlTextWriterWriteCDATA(xml->writer, BAD_CAST text)
                      : xmlTextWriterWriteString(xml->writer, BAD_CAST text));
}

void ect_xml_text(ect_xml_writer_t *xml, const char *element, const char *text)
{
    ect_xml_open(xml, element);
    ect_xml_content(xml, text);
    ect_xml_close(xml);
}

void ect_xml_number(ect_xml_writer_t *xml, const char *element, int64_t value)
{
    char text[24];
    (void)snprintf(text, sizeof text, "%" PRId64, value);
    ect_xml_text(xml, element, text);
}

void ect_xml_hex(ect_xml_writer_t *xml, const char *element, uint32_t value, int digits)
{
    char text[16];
    ECT_ASSERT(digits > 0 && digits <= 8);
    (void)snprintf(text, sizeof text, "#x%0*" PRIX32, digits, value);
    ect_xml_text(xml, element, text);
}

void ect_xml_index(ect_xml_writer_t *xml, const char *element, uint16_t index)
{
    char text[16];
    (void)snprintf(text, sizeof text, "#x%04X", (unsigned int)index);
    ect_xml_open(xml, element);
    ect_xml_flag(xml, "DependOnSlot", xml->by_slot);
    ect_xml_content(xml, text);
    ect_xml_close(xml);
}

void ect_xml_bytes(ect_xml_writer_t *xml, const char *element, const uint8_t *bytes, size_t length)
{
    ect_xml_open(xml, element);
    if (length > 0)
        note(xml, xmlTextWriterWriteBinHex(xml->writer, (const char *)bytes, 0, (int)length));
    ect_xml_close(xml);
}

static void copy_attributes(ect_xml_writer_t *xml, const xmlNode *node)
{
    for (const xmlAttr *a = node->properties; a != NULL; a = a->next) {
        const char *prefix = a->ns != NULL && a->ns->prefix != NULL ? (const char *)a->ns->prefix : "";
        const char *value = a->children != NULL ? (const char *)a->children->content : "";
        const char *name =
            ect_arena_print(xml->arena, "%s%s%s", prefix, *prefix != '\0' ? ":" : "", (const char *)a->name);
        ect_xml_attribute(xml, name, "%s", value != NULL ? value : "");
    }
}

static void copy_node(ect_xml_writer_t *xml, const xmlNode *node)
{
    if (node->type == XML_ELEMENT_NODE) {
        ect_xml_open(xml, (const char *)node->name);
        copy_attributes(xml, node);
    } else if ((node->type == XML_TEXT_NODE || node->type == XML_CDATA_SECTION_NODE) && node->content != NULL) {
        ect_xml_content(xml, (const char *)node->content);
    }
}

void ect_xml_copy(ect_xml_writer_t *xml, const xmlNode *top)
{
    const xmlNode *node = top;
    ECT_ASSERT(top != NULL && top->type == XML_ELEMENT_NODE);
    while (node != NULL) {
        copy_node(xml, node);
        if (node->type == XML_ELEMENT_NODE && node->children != NULL) {
            node = node->children;
            continue;
        }
        if (node->type == XML_ELEMENT_NODE)
            ect_xml_close(xml);
        while (node != top && node->next == NULL) {
            node = node->parent;
            ect_xml_close(xml);
        }
        node = node != top ? node->next : NULL;
    }
}

void ect_xml_copy_children(ect_xml_writer_t *xml, const xmlNode *parent, const char *name)
{
    for (const xmlNode *node = parent != NULL ? parent->children : NULL; node != NULL; node = node->next) {
        if (node->type == XML_ELEMENT_NODE && (name == NULL || ect_esi_is(node, name)))
            ect_xml_copy(xml, node);
    }
}

const xmlNode *ect_xml_source(const ect_esi_part_t *part)
{
    return part->twin != NULL ? ect_esi_twin_file(part->twin)->nodes[ect_esi_twin_model(part->twin)->place] : NULL;
}
