/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Reads XML files of the fieldbus (ESI, ENI): a document in memory, and the parts of its elements.
 *
 * Only the file itself is opened, and the dictionary files of an ESI: no network, no external entity. A file with a
 * document type definition is refused as an attack, because neither an ESI nor an ENI has one. libxml2 limits nesting
 * (256 levels) and texts (10 MB).
 *
 * After a mistake reading continues with zeros and empty texts, so that the readers need no error path; the caller of
 * the first reader checks ::ect_esi_xml_t::failed at the end. Host only. Context: mainline.
 */
#ifndef ECT_ESI_XML_H
#define ECT_ESI_XML_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "esi/arena.h"
#include "esi/model.h"
#include "wire/linkage.h"

/** libxml2's node and document (xmlNode, xmlDoc), declared here so that this header does not include libxml2. */
struct _xmlNode;
struct _xmlDoc;

ECT_C_BEGIN

/** Memory for the model, and the message of the first mistake. */
typedef struct ect_esi_xml {
    ect_arena_t *arena;
    const char *file;
    char *text;
    size_t room;
    bool failed;
    const char *folder; /**< of the file, where its other files are; NULL: no other file is read */
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
 * @return the content; `data` NULL: missing, too large, no regular file
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

/** Stores the message of a mistake at an element's line, if it is the first mistake. */
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

/** Iterates over the children with a name. */
#define ECT_ESI_EACH(node, parent, name)                                                                               \
    for (const struct _xmlNode *node = ect_esi_child(parent, name); node != NULL; node = ect_esi_next(node, name))

/** @return the text of an element, one line without surrounding blanks; "" for NULL or an empty element */
const char *ect_esi_text(ect_esi_xml_t *xml, const struct _xmlNode *node);

/** @return the text of a child, in English if there are several languages; "" if there is no such child */
const char *ect_esi_name(ect_esi_xml_t *xml, const struct _xmlNode *parent, const char *name);

/** @return the text of an attribute, one line without surrounding blanks; "": absent */
const char *ect_esi_attribute(ect_esi_xml_t *xml, const struct _xmlNode *node, const char *name);

/** @return whether the attribute is 1 or true */
bool ect_esi_flag(ect_esi_xml_t *xml, const struct _xmlNode *node, const char *name);

/** @return the number of a child, minimum..maximum; `none`: absent; any other value is a mistake and returns 0 */
int64_t ect_esi_number(ect_esi_xml_t *xml, const struct _xmlNode *parent, const char *name, int64_t minimum,
                       int64_t maximum, int64_t none);

/** @return the number of the element itself, minimum..maximum; any other value is a mistake and returns 0 */
int64_t ect_esi_value(ect_esi_xml_t *xml, const struct _xmlNode *node, int64_t minimum, int64_t maximum);

/** @return the number of an attribute, minimum..maximum; `none`: absent; any other value is a mistake and returns 0 */
int64_t ect_esi_attribute_number(ect_esi_xml_t *xml, const struct _xmlNode *node, const char *name, int64_t minimum,
                                 int64_t maximum, int64_t none);

/** @return the number of a child, if there is one */
ect_esi_number_t ect_esi_optional(ect_esi_xml_t *xml, const struct _xmlNode *parent, const char *name);

/** @return the hexadecimal bytes of a child; blanks between them are allowed */
ect_esi_bytes_t ect_esi_hex(ect_esi_xml_t *xml, const struct _xmlNode *parent, const char *name);

/** Reads the `<RxPdo>` and `<TxPdo>` below an element, outputs first. @param[out] count  number of PDOs */
const ect_esi_pdo_t *ect_esi_read_pdos(ect_esi_xml_t *xml, const struct _xmlNode *parent, size_t *count);

ECT_C_END

#endif
