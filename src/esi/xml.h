/* SPDX-License-Identifier: MIT */
/**
 * @file
 * XML files of the field, ESI and ENI: a document in memory, and the parts of its elements.
 *
 * Nothing but the file itself is opened: no network, no external entity, and a file with a document type definition is
 * refused (neither an ESI nor an ENI has one; what has one is an attack). Nesting and the length of a text are bounded
 * by libxml2's limits (256 levels, 10 MB).
 *
 * Reading goes on after a mistake with zeros and empty texts, so that no reader needs an error path of its own; whoever
 * began asks ::ect_esi_xml_t::failed at the end. Host only. Context: mainline.
 */
#ifndef ECT_ESI_XML_H
#define ECT_ESI_XML_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "esi/arena.h"
#include "esi/model.h"
#include "wire/linkage.h"

/** libxml2's node and document (xmlNode, xmlDoc), so that users of this header need not include libxml2. */
struct _xmlNode;
struct _xmlDoc;

ECT_C_BEGIN

/** Source of memory, and destination of the first mistake. */
typedef struct ect_esi_xml {
    ect_arena_t *arena;
    const char *file;
    char *text;
    size_t room;
    bool failed;
} ect_esi_xml_t;

/** A file in memory. */
typedef struct ect_esi_file {
    char *data; /**< for free() */
    size_t length;
} ect_esi_file_t;

/**
 * Reads a file.
 * @param path  a regular file of at most 64 MiB
 * @param[out] text, room  the error, one line
 * @return its bytes; `data` NULL: not there, too large, no file
 */
ect_esi_file_t ect_esi_load(const char *path, char *text, size_t room);

/**
 * Parses a document.
 * @param kind  "ESI" or "ENI", for messages; @param name  prefix of messages
 * @param data, length  need not outlive the call
 * @param[out] text, room  the error, one line
 * @return to be freed by xmlFreeDoc; NULL: larger than 64 MiB, no XML, a document type definition
 */
struct _xmlDoc *ect_esi_document(const char *kind, const char *name, const void *data, size_t length, char *text,
                                 size_t room);

/** Appends a zeroed element to an array of an arena's owner (`->arena`) and names it. */
#define ECT_APPEND(owner, array, count, element)                                                                       \
    (array) = ect_arena_grow((owner)->arena, (array), (count), sizeof *(array));                                       \
    (element) = &(array)[(count)++]

/** Takes note of a mistake at an element's line, unless there was one before. */
__attribute__((format(printf, 3, 4))) void ect_esi_fail(ect_esi_xml_t *xml, const struct _xmlNode *node,
                                                        const char *format, ...);

/** @return the element's line in the file */
int ect_esi_line(const struct _xmlNode *node);

/** @return true for an element of this name, in any namespace */
bool ect_esi_is(const struct _xmlNode *node, const char *name);

/** @return the first child of this name, or NULL; a NULL parent has none */
const struct _xmlNode *ect_esi_child(const struct _xmlNode *parent, const char *name);

/** @return the next sibling of this name, or NULL */
const struct _xmlNode *ect_esi_next(const struct _xmlNode *node, const char *name);

/** Runs over the children of a name. */
#define ECT_ESI_EACH(node, parent, name)                                                                               \
    for (const struct _xmlNode *node = ect_esi_child(parent, name); node != NULL; node = ect_esi_next(node, name))

/** @return the text of an element, one line without blanks around it; "" for NULL or an empty one */
const char *ect_esi_text(ect_esi_xml_t *xml, const struct _xmlNode *node);

/** @return the text of a child in English when there are several languages, "" when there is none */
const char *ect_esi_name(ect_esi_xml_t *xml, const struct _xmlNode *parent, const char *name);

/** @return an attribute's text, one line without blanks around it, "" when it is absent */
const char *ect_esi_attribute(ect_esi_xml_t *xml, const struct _xmlNode *node, const char *name);

/** @return true when the attribute is 1 or true */
bool ect_esi_flag(ect_esi_xml_t *xml, const struct _xmlNode *node, const char *name);

/** A child's number between two limits, both inclusive; 0 and a mistake noted when it is another; `none` if absent. */
int64_t ect_esi_number(ect_esi_xml_t *xml, const struct _xmlNode *parent, const char *name, int64_t minimum,
                       int64_t maximum, int64_t none);

/** The element's own number. */
int64_t ect_esi_value(ect_esi_xml_t *xml, const struct _xmlNode *node, int64_t minimum, int64_t maximum);

/** An attribute's number. */
int64_t ect_esi_attribute_number(ect_esi_xml_t *xml, const struct _xmlNode *node, const char *name, int64_t minimum,
                                 int64_t maximum, int64_t none);

/** A child's number, or that there is none. */
ect_esi_number_t ect_esi_optional(ect_esi_xml_t *xml, const struct _xmlNode *parent, const char *name);

/** A child's hexadecimal bytes; blanks between them are allowed. */
ect_esi_bytes_t ect_esi_hex(ect_esi_xml_t *xml, const struct _xmlNode *parent, const char *name);

/** Reads the `<RxPdo>` and `<TxPdo>` below an element, outputs first. @param[out] count  of them */
const ect_esi_pdo_t *ect_esi_read_pdos(ect_esi_xml_t *xml, const struct _xmlNode *parent, size_t *count);

ECT_C_END

#endif
