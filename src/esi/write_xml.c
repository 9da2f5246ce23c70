/* SPDX-License-Identifier: MIT */
#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "esi/internal.h"

static void note(ect_pen_t *pen, int result)
{
    pen->failed |= result < 0;
}

static bool write_document(ect_pen_t *pen, void (*write)(ect_pen_t *pen, const void *what), const void *what)
{
    note(pen, xmlTextWriterSetIndent(pen->writer, 1));
    note(pen, xmlTextWriterSetIndentString(pen->writer, BAD_CAST "  "));
    note(pen, xmlTextWriterStartDocument(pen->writer, "1.0", "UTF-8", NULL));
    write(pen, what);
    note(pen, xmlTextWriterEndDocument(pen->writer));
    return !pen->failed;
}

const char *ect_pen_file(ect_arena_t *arena, void (*write)(ect_pen_t *pen, const void *what), const void *what,
                         size_t *length, char *text, size_t room)
{
    const char *file = NULL;
    xmlBufferPtr buffer = xmlBufferCreate();
    ect_pen_t pen = {.writer = buffer != NULL ? xmlNewTextWriterMemory(buffer, 0) : NULL, .arena = arena};
    bool fine = pen.writer != NULL && write_document(&pen, write, what);
    xmlFreeTextWriter(pen.writer);
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

void ect_pen_open(ect_pen_t *pen, const char *element)
{
    note(pen, xmlTextWriterStartElement(pen->writer, BAD_CAST element));
}

void ect_pen_close(ect_pen_t *pen)
{
    note(pen, xmlTextWriterEndElement(pen->writer));
}

void ect_pen_attribute(ect_pen_t *pen, const char *name, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    note(pen, xmlTextWriterWriteVFormatAttribute(pen->writer, BAD_CAST name, format, arguments));
    va_end(arguments);
}

void ect_pen_flag(ect_pen_t *pen, const char *name, bool value)
{
    if (value)
        ect_pen_attribute(pen, name, "true");
}

void ect_pen_content(ect_pen_t *pen, const char *text)
{
    bool special = strpbrk(text, "<>&") != NULL && strstr(text, "]]>") == NULL;
    note(pen, special ? xmlTextWriterWriteCDATA(pen->writer, BAD_CAST text)
                      : xmlTextWriterWriteString(pen->writer, BAD_CAST text));
}

void ect_pen_text(ect_pen_t *pen, const char *element, const char *text)
{
    ect_pen_open(pen, element);
    ect_pen_content(pen, text);
    ect_pen_close(pen);
}

void ect_pen_number(ect_pen_t *pen, const char *element, int64_t value)
{
    char text[24];
    (void)snprintf(text, sizeof text, "%" PRId64, value);
    ect_pen_text(pen, element, text);
}

void ect_pen_hex(ect_pen_t *pen, const char *element, uint32_t value, int digits)
{
    char text[16];
    ECT_ASSERT(digits > 0 && digits <= 8);
    (void)snprintf(text, sizeof text, "#x%0*" PRIX32, digits, value);
    ect_pen_text(pen, element, text);
}

void ect_pen_bytes(ect_pen_t *pen, const char *element, const uint8_t *bytes, size_t length)
{
    ect_pen_open(pen, element);
    if (length > 0)
        note(pen, xmlTextWriterWriteBinHex(pen->writer, (const char *)bytes, 0, (int)length));
    ect_pen_close(pen);
}

static void copy_attributes(ect_pen_t *pen, const xmlNode *node)
{
    for (const xmlAttr *a = node->properties; a != NULL; a = a->next) {
        const char *prefix = a->ns != NULL && a->ns->prefix != NULL ? (const char *)a->ns->prefix : "";
        const char *value = a->children != NULL ? (const char *)a->children->content : "";
        const char *name =
            ect_arena_print(pen->arena, "%s%s%s", prefix, *prefix != '\0' ? ":" : "", (const char *)a->name);
        ect_pen_attribute(pen, name, "%s", value != NULL ? value : "");
    }
}

static void copy_node(ect_pen_t *pen, const xmlNode *node)
{
    if (node->type == XML_ELEMENT_NODE) {
        ect_pen_open(pen, (const char *)node->name);
        copy_attributes(pen, node);
    } else if ((node->type == XML_TEXT_NODE || node->type == XML_CDATA_SECTION_NODE) && node->content != NULL) {
        ect_pen_content(pen, (const char *)node->content);
    }
}

void ect_pen_copy(ect_pen_t *pen, const xmlNode *top)
{
    const xmlNode *node = top;
    ECT_ASSERT(top != NULL && top->type == XML_ELEMENT_NODE);
    while (node != NULL) {
        copy_node(pen, node);
        if (node->type == XML_ELEMENT_NODE && node->children != NULL) {
            node = node->children;
            continue;
        }
        if (node->type == XML_ELEMENT_NODE)
            ect_pen_close(pen);
        while (node != top && node->next == NULL) {
            node = node->parent;
            ect_pen_close(pen);
        }
        node = node != top ? node->next : NULL;
    }
}

void ect_pen_copy_children(ect_pen_t *pen, const xmlNode *parent, const char *name)
{
    for (const xmlNode *node = parent != NULL ? parent->children : NULL; node != NULL; node = node->next) {
        if (node->type == XML_ELEMENT_NODE && (name == NULL || ect_esi_is(node, name)))
            ect_pen_copy(pen, node);
    }
}

const xmlNode *ect_pen_source(const ect_esi_part_t *part)
{
    return part->twin != NULL ? ect_esi_twin_file(part->twin)->nodes[ect_esi_twin_model(part->twin)->place] : NULL;
}
