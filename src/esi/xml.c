/* SPDX-License-Identifier: MIT */
#include "esi/internal.h"

#include <errno.h>
#include <fcntl.h>
#include <libxml/parser.h>
#include <libxml/parserInternals.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { FILE_MEBIBYTES = 64, FILE_MAXIMUM = FILE_MEBIBYTES * 1024 * 1024 };

/* --- documents ---------------------------------------------------------------------------------------------------- */

/* Stops the parser before a document type definition, the source of entities. */
static void refuse_dtd(void *parser, const xmlChar *name, const xmlChar *external, const xmlChar *system)
{
    (void)name;
    (void)external;
    (void)system;
    xmlParserCtxtPtr ctxt = parser;
    ctxt->_private = ctxt;
    xmlStopParser(ctxt);
}

static void report_parse_error(xmlParserCtxtPtr parser, const char *kind, const char *name, char *text, size_t room)
{
    if (parser->_private != NULL) {
        (void)snprintf(text, room, "%s: has a document type definition, which no %s file has: refused", name, kind);
        return;
    }
    const xmlError *error = xmlCtxtGetLastError(parser);
    const char *message = error != NULL && error->message != NULL ? error->message : "not XML";
    (void)snprintf(text, room, "%s:%d: no well-formed XML: %.*s", name, error != NULL ? error->line : 1,
                   (int)strcspn(message, "\n"), message);
}

xmlDocPtr ect_esi_document(const char *kind, const char *name, const void *data, size_t length, char *text, size_t room)
{
    if (length > FILE_MAXIMUM) {
        (void)snprintf(text, room, "%s: larger than %d MiB", name, FILE_MEBIBYTES);
        return NULL;
    }
    xmlParserCtxtPtr parser = xmlNewParserCtxt();
    if (parser == NULL) {
        (void)snprintf(text, room, "%s: no memory left", name);
        return NULL;
    }
    parser->sax->internalSubset = refuse_dtd;
    xmlDocPtr document = xmlCtxtReadMemory(parser, data, (int)length, name, NULL,
                                           XML_PARSE_NONET | XML_PARSE_NOERROR | XML_PARSE_NOWARNING |
                                               XML_PARSE_NOBLANKS | XML_PARSE_BIG_LINES | XML_PARSE_COMPACT);
    if (document == NULL || parser->_private != NULL) {
        report_parse_error(parser, kind, name, text, room);
        xmlFreeDoc(document);
        document = NULL;
    }
    xmlFreeParserCtxt(parser);
    return document;
}

/* Reads a whole file. @return to be freed with free(); NULL (errno) */
static char *read_all(int file, size_t size, size_t *length)
{
    char *data = malloc(size + 1);
    ssize_t got = data ? 1 : -1;
    while (got > 0) {
        got = read(file, data + *length, size - *length);
        *length += got > 0 ? (size_t)got : 0;
    }
    if (got >= 0)
        return data;
    int error = errno;
    free(data);
    errno = error;
    return NULL;
}

/* As read_all(), with an error message. */
ect_esi_file_t ect_esi_load(const char *path, char *text, size_t room)
{
    int file = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK); // O_NONBLOCK: a pipe must not block the command
    struct stat status;
    ect_esi_file_t loaded = {.data = NULL};
    if (file < 0 || fstat(file, &status) != 0) {
        (void)snprintf(text, room, "%s: %s", path, strerror(errno));
    } else if (!S_ISREG(status.st_mode) || status.st_size > FILE_MAXIMUM) {
        (void)snprintf(text, room, "%s: not a file of at most %d MiB", path, FILE_MEBIBYTES);
    } else {
        loaded.data = read_all(file, (size_t)status.st_size, &loaded.length);
        if (!loaded.data)
            (void)snprintf(text, room, "%s: %s", path, strerror(errno));
    }
    if (file >= 0)
        (void)close(file);
    return loaded;
}

/* --- elements ----------------------------------------------------------------------------------------------------- */

void ect_esi_fail(ect_esi_xml_t *xml, const xmlNode *node, const char *format, ...)
{
    ECT_ASSERT(node != NULL && format != NULL);
    if (xml->failed)
        return;
    xml->failed = true;
    int length = snprintf(xml->text, xml->room, "%s:%d: ", xml->file, ect_esi_line(node));
    if (length < 0 || (size_t)length >= xml->room)
        return;
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(xml->text + length, xml->room - (size_t)length, format, arguments);
    va_end(arguments);
}

int ect_esi_line(const xmlNode *node)
{
    return (int)xmlGetLineNo((xmlNodePtr)(uintptr_t)node); // libxml2's signature lacks a const before 2.9.14
}

bool ect_esi_is(const xmlNode *node, const char *name)
{
    return node->type == XML_ELEMENT_NODE && strcmp((const char *)node->name, name) == 0;
}

static const xmlNode *first_of(const xmlNode *node, const char *name)
{
    while (node != NULL && !ect_esi_is(node, name))
        node = node->next;
    return node;
}

const xmlNode *ect_esi_child(const xmlNode *parent, const char *name)
{
    return parent != NULL ? first_of(parent->children, name) : NULL;
}

const xmlNode *ect_esi_next(const xmlNode *node, const char *name)
{
    ECT_ASSERT(node != NULL && ect_esi_is(node, name));
    return first_of(node->next, name);
}

static bool is_blank(char c)
{
    return c == ' ' || c == '\t' || c == '\n' || c == '\r';
}

/* @return the text as one line, for messages and reports */
static const char *trimmed(ect_esi_xml_t *xml, const char *text)
{
    while (is_blank(*text))
        text++;
    size_t length = strlen(text);
    while (length > 0 && is_blank(text[length - 1]))
        length--;
    if (length == 0)
        return "";
    char *copy = ect_arena_copy(xml->arena, text, length);
    for (size_t i = 0; i < length; i++)
        copy[i] = (char)(is_blank(copy[i]) ? ' ' : copy[i]);
    return copy;
}

const char *ect_esi_text(ect_esi_xml_t *xml, const xmlNode *node)
{
    if (node == NULL || node->children == NULL)
        return "";
    const xmlNode *only = node->children;
    if (only->next == NULL && (only->type == XML_TEXT_NODE || only->type == XML_CDATA_SECTION_NODE))
        return only->content != NULL ? trimmed(xml, (const char *)only->content) : "";
    xmlChar *content = xmlNodeGetContent(node);
    const char *text = content != NULL ? trimmed(xml, (const char *)content) : "";
    xmlFree(content);
    return text;
}

const char *ect_esi_name(ect_esi_xml_t *xml, const xmlNode *parent, const char *name)
{
    const xmlNode *chosen = ect_esi_child(parent, name);
    ECT_ESI_EACH(node, parent, name)
    {
        if (strcmp(ect_esi_attribute(xml, node, "LcId"), "1033") == 0) {
            chosen = node;
            break;
        }
    }
    return ect_esi_text(xml, chosen);
}

const char *ect_esi_attribute(ect_esi_xml_t *xml, const xmlNode *node, const char *name)
{
    ECT_ASSERT(node != NULL && node->type == XML_ELEMENT_NODE);
    const xmlAttr *attribute = node->properties;
    while (attribute != NULL && strcmp((const char *)attribute->name, name) != 0)
        attribute = attribute->next;
    if (attribute == NULL || attribute->children == NULL || attribute->children->content == NULL)
        return "";
    return trimmed(xml, (const char *)attribute->children->content);
}

bool ect_esi_flag(ect_esi_xml_t *xml, const xmlNode *node, const char *name)
{
    const char *text = ect_esi_attribute(xml, node, name);
    return strcmp(text, "1") == 0 || strcmp(text, "true") == 0;
}

static int64_t within(ect_esi_xml_t *xml, const xmlNode *node, const char *what, const char *text, int64_t minimum,
                      int64_t maximum)
{
    int64_t value;
    ECT_ASSERT(minimum <= maximum);
    if (!ect_esi_parse_number(text, &value)) {
        ect_esi_fail(xml, node, "%s is \"%.40s\", not a number", what, text);
        return 0;
    }
    if (value < minimum || value > maximum) {
        ect_esi_fail(xml, node, "%s is %lld, not %lld to %lld", what, (long long)value, (long long)minimum,
                     (long long)maximum);
        return 0;
    }
    return value;
}

int64_t ect_esi_value(ect_esi_xml_t *xml, const xmlNode *node, int64_t minimum, int64_t maximum)
{
    return within(xml, node, (const char *)node->name, ect_esi_text(xml, node), minimum, maximum);
}

int64_t ect_esi_number(ect_esi_xml_t *xml, const xmlNode *parent, const char *name, int64_t minimum, int64_t maximum,
                       int64_t none)
{
    const xmlNode *node = ect_esi_child(parent, name);
    return node != NULL ? ect_esi_value(xml, node, minimum, maximum) : none;
}

int64_t ect_esi_attribute_number(ect_esi_xml_t *xml, const xmlNode *node, const char *name, int64_t minimum,
                                 int64_t maximum, int64_t none)
{
    const char *text = ect_esi_attribute(xml, node, name);
    return *text != '\0' ? within(xml, node, name, text, minimum, maximum) : none;
}

ect_esi_number_t ect_esi_optional(ect_esi_xml_t *xml, const xmlNode *parent, const char *name)
{
    const xmlNode *node = ect_esi_child(parent, name);
    ect_esi_number_t number = {.given = false};
    if (node != NULL) {
        number.given = true;
        number.value = ect_esi_value(xml, node, INT64_MIN, INT64_MAX);
    }
    return number;
}

static int digit(char c)
{
    if (c >= '0' && c <= '9')
        return c - '0';
    if (c >= 'a' && c <= 'f')
        return c - 'a' + 10;
    return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

ect_esi_bytes_t ect_esi_hex(ect_esi_xml_t *xml, const xmlNode *parent, const char *name)
{
    const xmlNode *node = ect_esi_child(parent, name);
    ect_esi_bytes_t none = {.bytes = NULL};
    if (node == NULL)
        return none;
    const char *text = ect_esi_text(xml, node);
    uint8_t *bytes = ect_arena_alloc(xml->arena, strlen(text) / 2 + 1);
    size_t digits = 0;
    for (; *text != '\0'; text++) {
        int value = digit(*text);
        if (value >= 0) {
            bytes[digits / 2] = (uint8_t)(bytes[digits / 2] << 4 | value);
            digits++;
        } else if (!is_blank(*text)) {
            ect_esi_fail(xml, node, "%s has the character '%c', which is no hexadecimal digit", name, *text);
            return none;
        }
    }
    if (digits % 2 != 0) {
        ect_esi_fail(xml, node, "%s has an odd number of hexadecimal digits (%zu)", name, digits);
        return none;
    }
    return (ect_esi_bytes_t){.bytes = bytes, .length = digits / 2};
}
