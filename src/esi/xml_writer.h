/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Writer of XML files of the fieldbus (ESI, ENI): elements and attributes.
 *
 * Host only. Context: mainline.
 */
#ifndef ECT_ESI_XML_WRITER_H
#define ECT_ESI_XML_WRITER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "esi/arena.h"
#include "seams/device.h"
#include "seams/plant.h"
#include "wire/linkage.h"

/** libxml2's xmlTextWriter, declared here so that this header does not include libxml2. */
struct _xmlTextWriter;

/** Destination of XML; ::ect_xml_file reports a failure at the end. */
typedef struct ect_xml_writer {
    struct _xmlTextWriter *writer;
    ect_arena_t *arena;
    const ect_plant_t *plant; /* of the present device; NULL: none */
    bool by_slot;             /* indices are those of a module in the first slot: `DependOnSlot` */
    bool failed;
} ect_xml_writer_t;

ECT_C_BEGIN

/**
 * Writes a document.
 * @param write  writes the root element
 * @param[out] length  bytes of the file, without the terminator
 * @param[out] text, room  the reason of the failure, one line
 * @return the file (UTF-8), valid as long as the arena; NULL: out of memory
 */
const char *ect_xml_file(ect_arena_t *arena, void (*write)(ect_xml_writer_t *xml, const void *what), const void *what,
                         size_t *length, char *text, size_t room);

void ect_xml_open(ect_xml_writer_t *xml, const char *element);
void ect_xml_close(ect_xml_writer_t *xml);

/** Writes an attribute of the last opened element, before any content of the element. */
__attribute__((format(printf, 3, 4))) void ect_xml_attribute(ect_xml_writer_t *xml, const char *name,
                                                             const char *format, ...);

/** Writes the attribute "true", or no attribute for false. */
void ect_xml_flag(ect_xml_writer_t *xml, const char *name, bool value);

/** Writes the text of the open element, as CDATA if it contains characters with a meaning in XML. */
void ect_xml_content(ect_xml_writer_t *xml, const char *text);

/** Writes a whole element with a text, a decimal number, `#x` and hexadecimal digits, or hexadecimal bytes. */
void ect_xml_text(ect_xml_writer_t *xml, const char *element, const char *text);
void ect_xml_number(ect_xml_writer_t *xml, const char *element, int64_t value);
void ect_xml_hex(ect_xml_writer_t *xml, const char *element, uint32_t value, int digits);
void ect_xml_bytes(ect_xml_writer_t *xml, const char *element, const uint8_t *bytes, size_t length);

/** Writes an index of an object or a PDO, which moves with the slot in a module. */
void ect_xml_index(ect_xml_writer_t *xml, const char *element, uint16_t index);

/** Writes the `<RxPdo>` (outputs) or `<TxPdo>` of a device, assigned PDOs first, in the order of the assignment. */
void ect_xml_pdos(ect_xml_writer_t *xml, const ect_device_t *device, bool outputs);

ECT_C_END

#endif
