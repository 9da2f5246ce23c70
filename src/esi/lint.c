/* SPDX-License-Identifier: MIT */
#include "esi/lint.h"

#include <libxml/xmlschemas.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "esi/internal.h"
#include "wire/bytes.h"

enum { LINE = 400, WORDS = 40 };
enum { BMP_WIDTH = 18, BMP_HEIGHT = 22, BMP_HEADER = 26, PICTURE_WIDTH = 16, PICTURE_HEIGHT = 14, CONFIG_BYTES = 14 };

typedef struct lint {
    ect_esi_xml_t xml;
    ect_esi_report_t report;
    void *ctx;
} lint_t;

__attribute__((format(printf, 4, 5))) static void finding(const lint_t *l, bool wrong, const xmlNode *node,
                                                          const char *format, ...)
{
    char line[LINE];
    int used = snprintf(line, sizeof line, "%s:%d: ", l->xml.file, ect_esi_line(node));
    va_list arguments;
    va_start(arguments, format);
    if (used > 0 && (size_t)used < sizeof line)
        (void)vsnprintf(line + used, sizeof line - (size_t)used, format, arguments);
    va_end(arguments);
    l->report(l->ctx, wrong, line);
}

static const char *tag(const xmlNode *node)
{
    return (const char *)node->name;
}

/* @return position of a word in a list separated by blanks; -1: none */
static int place_of(const char *words, const char *word)
{
    size_t length = strlen(word);
    for (int place = 0; *words != '\0'; place++) {
        size_t next = strcspn(words, " ");
        if (next == length && strncmp(words, word, length) == 0)
            return place;
        words += next + (words[next] == ' ');
    }
    return -1;
}

/* --- order ------------------------------------------------------------------------------------------------------- */

static const struct order {
    const char *parent, *children;
} orders[] = {
    {"EtherCATInfo", "InfoReference Vendor Descriptions"},
    {"Vendor", "Id Name Comment URL DescriptionURL Image16x14 ImageFile16x14 ImageData16x14 VendorSpecific"},
    {"Descriptions", "Groups Devices Modules"},
    {"Group", "Type Name Comment Image16x14 ImageFile16x14 ImageData16x14 VendorSpecific"},
    {"Device",
     "Sci Type HideType AlternativeType SubDevice Name Comment URL Info GroupType Profile Fmmu Sm Su RxPdo TxPdo "
     "Mailbox Dc Slots ESC Eeprom Image16x14 ImageFile16x14 ImageData16x14 VendorSpecific"},
    {"Mailbox", "AoE EoE CoE FoE SoE VoE VendorSpecific"},
    {"Eeprom", "Data ByteSize ConfigData BootStrap Category VendorSpecific"},
};

/* @return the rank of an element; equal for the kinds of pictures and for PDOs, whose order is free */
static int rank(const struct order *order, const char *name)
{
    int place = place_of(order->children, name);
    if (strcmp(name, "TxPdo") == 0)
        place = place_of(order->children, "RxPdo");
    return place;
}

static void check_order(const lint_t *l, const xmlNode *parent, const struct order *order)
{
    const xmlNode *before = NULL;
    for (const xmlNode *node = parent->children; node != NULL; node = node->next) {
        if (node->type != XML_ELEMENT_NODE)
            continue;
        if (rank(order, tag(node)) < 0)
            finding(l, true, node, "%s in %s, where there is no such element", tag(node), order->parent);
        else if (before != NULL && rank(order, tag(node)) < rank(order, tag(before)))
            finding(l, true, node, "%s behind %s in %s: tools that require the order of the schema skip the file",
                    tag(node), tag(before), order->parent);
        before = rank(order, tag(node)) < 0 ? before : node;
    }
}

/* --- obsolete ---------------------------------------------------------------------------------------------------- */

/* Elements with attributes that are obsolete by the schema; "*": any element. */
static const struct obsolete {
    const char *element, *attributes;
} obsolete_attributes[] = {
    {"Type", "TcSmClass TcCfgModeSafeOp DownloadModuleList"},
    {"HideType", "ProductRevision"},
    {"Profile", "Channel"},
    {"Fmmu", "OpOnly"},
    {"Sm", "OneByteMode Watchdog FixedAssignment"},
    {"RxPdo", "PdoOrder"},
    {"TxPdo", "PdoOrder"},
    {"CoE", "DS402Channels"},
    {"InitCmd", "Fixed"},
    {"Slots", "IdentifyModuleBy"},
    {"Vendor", "UniqueName"},
};
static const char obsolete_elements[] = "Image16x14 StationAliasSupported";

/* Adds a remark, because few masters enable a SyncManager in OP only. */
static const char op_only[] = "OpOnly";

static void check_attribute(const lint_t *l, const xmlNode *node, const char *name)
{
    for (size_t i = 0; i < sizeof obsolete_attributes / sizeof obsolete_attributes[0]; i++) {
        if (strcmp(tag(node), obsolete_attributes[i].element) == 0 &&
            place_of(obsolete_attributes[i].attributes, name) >= 0)
            finding(l, true, node, "%s of %s is obsolete", name, tag(node));
    }
    if (strcmp(tag(node), "Sm") == 0 && strcmp(name, op_only) == 0)
        finding(l, false, node, "OpOnly of Sm: many masters do not support it");
}

/* --- numbers ----------------------------------------------------------------------------------------------------- */

static const char number_attributes[] =
    "ProductCode RevisionNo StartAddress ControlByte DefaultSize MinSize MaxSize Enable Sm";
static const char number_elements[] = "Id Index SubIndex SubIdx AssignActivate ByteSize ExcludedSm Exclude";

static void check_number(const lint_t *l, const xmlNode *node, const char *what, const char *text)
{
    if (text[0] == '0' && (text[1] == 'x' || text[1] == 'X'))
        finding(l, true, node, "%s %s: a hexadecimal number is written #x%s", what, text, text + 2);
}

static void check_element(lint_t *l, const xmlNode *node)
{
    for (const xmlAttr *a = node->properties; a != NULL; a = a->next) {
        const char *name = (const char *)a->name;
        check_attribute(l, node, name);
        if (place_of(number_attributes, name) >= 0)
            check_number(l, node, name, ect_esi_attribute(&l->xml, node, name));
    }
    if (place_of(obsolete_elements, tag(node)) >= 0)
        finding(l, true, node, "%s is obsolete", tag(node));
    if (place_of(number_elements, tag(node)) >= 0)
        check_number(l, node, tag(node), ect_esi_text(&l->xml, node));
}

/* Checks an element and all elements below. */
static void walk(lint_t *l, const xmlNode *top)
{
    for (const xmlNode *node = top; node != NULL;) {
        if (node->type == XML_ELEMENT_NODE)
            check_element(l, node);
        if (node->children != NULL && node->type == XML_ELEMENT_NODE) {
            node = node->children;
            continue;
        }
        while (node != top && node->next == NULL)
            node = node->parent;
        node = node != top ? node->next : NULL;
    }
}

/* --- content of single elements ----------------------------------------------------------------------------------- */

static void require_text(lint_t *l, const xmlNode *parent, const char *child)
{
    if (*ect_esi_name(&l->xml, parent, child) == '\0')
        finding(l, true, parent, "%s has no %s", tag(parent), child);
}

/* Absolute value, also of INT32_MIN: the height of a top-down picture is negative. */
static uint32_t magnitude(uint32_t number)
{
    return number > INT32_MAX ? 0u - number : number;
}

/* Checks a bitmap file. */
static void check_picture(lint_t *l, const xmlNode *parent)
{
    const xmlNode *node = ect_esi_child(parent, "ImageData16x14");
    if (node == NULL)
        return;
    ect_esi_bytes_t data = ect_esi_hex(&l->xml, parent, "ImageData16x14");
    if (data.length == 0)
        finding(l, true, node, "ImageData16x14 of %s is empty or not hexadecimal", tag(parent));
    else if (data.length < BMP_HEADER || data.bytes[0] != 'B' || data.bytes[1] != 'M')
        finding(l, true, node, "ImageData16x14 of %s is not a bitmap: it does not begin with 424D", tag(parent));
    else if (ect_load_le32(data.bytes + BMP_WIDTH) != PICTURE_WIDTH ||
             magnitude(ect_load_le32(data.bytes + BMP_HEIGHT)) != PICTURE_HEIGHT)
        finding(l, true, node, "ImageData16x14 of %s is a bitmap of %u x %u", tag(parent),
                (unsigned int)ect_load_le32(data.bytes + BMP_WIDTH),
                (unsigned int)magnitude(ect_load_le32(data.bytes + BMP_HEIGHT)));
}

static void check_group(lint_t *l, const xmlNode *node, const ect_esi_device_t *device)
{
    const xmlNode *type = ect_esi_child(node, "GroupType");
    if (*device->group_type == '\0')
        finding(l, true, type != NULL ? type : node, "Device has no GroupType");
    else if (*device->group_name == '\0')
        finding(l, false, type, "GroupType %s is no group with a name in this file", device->group_type);
}

static void check_eeprom(lint_t *l, const xmlNode *node, const ect_esi_device_t *device)
{
    const xmlNode *eeprom = ect_esi_child(node, "Eeprom");
    if (eeprom == NULL)
        finding(l, false, node, "Device has no Eeprom: no tool can write one");
    else if (device->eeprom.length == 0 && device->eeprom_size == 0)
        finding(l, true, eeprom, "Eeprom has neither Data nor ByteSize");
    else if (device->config.length > CONFIG_BYTES)
        finding(l, true, eeprom, "ConfigData has %zu bytes, more than the %d of an EEPROM's first words",
                device->config.length, (int)CONFIG_BYTES);
}

static void check_device(lint_t *l, const xmlNode *node, const ect_esi_device_t *device)
{
    if (*device->physics == '\0')
        finding(l, true, node, "Device has no Physics");
    require_text(l, node, "Type");
    require_text(l, node, "Name");
    check_group(l, node, device);
    check_eeprom(l, node, device);
    check_picture(l, node);
    walk(l, node);
}

static void check_orders(const lint_t *l, const xmlNode *node)
{
    for (size_t i = 0; i < sizeof orders / sizeof orders[0]; i++) {
        if (ect_esi_is(node, orders[i].parent))
            check_order(l, node, &orders[i]);
    }
}

/* --- the file ----------------------------------------------------------------------------------------------------- */

static void check_head(lint_t *l, const xmlNode *root, const xmlNode *descriptions)
{
    check_orders(l, root);
    check_orders(l, descriptions);
    const xmlNode *vendor = ect_esi_child(root, "Vendor"); /* exists: ect_esi_select */
    check_orders(l, vendor);
    require_text(l, vendor, "Name");
    check_picture(l, vendor);
    walk(l, vendor);
}

static void check_groups(lint_t *l, const xmlNode *groups, const ect_esi_device_t *device)
{
    ECT_ESI_EACH(group, groups, "Group")
    {
        if (strcmp(ect_esi_text(&l->xml, ect_esi_child(group, "Type")), device->group_type) != 0)
            continue;
        check_orders(l, group);
        check_picture(l, group);
        walk(l, group);
    }
}

void ect_esi_lint(ect_esi_t *esi, const ect_esi_device_t *device, ect_esi_report_t report, void *ctx)
{
    char unread[LINE]; /* the reader reports mistakes that make a file unreadable */
    lint_t l = {.xml = {.arena = &esi->arena, .file = esi->file, .text = unread, .room = sizeof unread},
                .report = report,
                .ctx = ctx};
    const xmlNode *descriptions = ect_esi_child(esi->root, "Descriptions");
    check_head(&l, esi->root, descriptions);
    check_groups(&l, ect_esi_child(descriptions, "Groups"), device);
    const xmlNode *node = esi->nodes[device->place];
    check_orders(&l, node);
    for (const xmlNode *child = node->children; child != NULL; child = child->next) {
        if (child->type == XML_ELEMENT_NODE)
            check_orders(&l, child);
    }
    check_device(&l, node, device);
}

/* --- schema ------------------------------------------------------------------------------------------------------ */

struct ect_esi_schema {
    xmlSchemaPtr xml;
    xmlSchemaValidCtxtPtr valid;
};

typedef struct validation {
    const ect_esi_t *esi;
    ect_esi_report_t report;
    void *ctx;
    size_t count;
} validation_t;

/* Called by libxml2, which stores the mistake with its line. */
__attribute__((format(printf, 2, 3))) static void invalid(void *ctx, const char *format, ...)
{
    (void)format;
    char line[LINE];
    validation_t *v = ctx;
    const xmlError *error = xmlGetLastError();
    const char *message = error != NULL && error->message != NULL ? error->message : "not valid";
    (void)snprintf(line, sizeof line, "%s:%d: %.*s", v->esi->file, error != NULL ? error->line : 1,
                   (int)strcspn(message, "\n"), message);
    v->report(v->ctx, true, line);
    v->count++;
}

__attribute__((format(printf, 2, 3))) static void ignore(void *ctx, const char *format, ...)
{
    (void)ctx;
    (void)format;
}

ect_esi_schema_t *ect_esi_schema_open(const char *path, char *text, size_t room)
{
    ect_esi_schema_t *schema = calloc(1, sizeof *schema);
    xmlDocPtr document = xmlReadFile(path, NULL, XML_PARSE_NONET | XML_PARSE_NOERROR | XML_PARSE_NOWARNING);
    xmlSchemaParserCtxtPtr parser = document != NULL ? xmlSchemaNewDocParserCtxt(document) : NULL;
    if (schema != NULL && parser != NULL) {
        xmlSchemaSetParserErrors(parser, ignore, ignore, NULL);
        schema->xml = xmlSchemaParse(parser);
        schema->valid = schema->xml != NULL ? xmlSchemaNewValidCtxt(schema->xml) : NULL;
    }
    xmlSchemaFreeParserCtxt(parser);
    xmlFreeDoc(document); /* the schema has copies of all necessary data */
    if (schema != NULL && schema->valid != NULL)
        return schema;
    (void)snprintf(text, room, "%s: the schema, or a file that it includes, cannot be read", path);
    ect_esi_schema_close(schema);
    return NULL;
}

void ect_esi_validate(const ect_esi_t *esi, ect_esi_schema_t *schema, ect_esi_report_t report, void *ctx)
{
    validation_t v = {.esi = esi, .report = report, .ctx = ctx};
    xmlSchemaSetValidErrors(schema->valid, invalid, invalid, &v);
    if (xmlSchemaValidateDoc(schema->valid, esi->document) != 0 && v.count == 0)
        invalid(&v, "not valid");
}

void ect_esi_schema_close(ect_esi_schema_t *schema)
{
    if (schema == NULL)
        return;
    xmlSchemaFreeValidCtxt(schema->valid);
    xmlSchemaFree(schema->xml);
    free(schema);
}
