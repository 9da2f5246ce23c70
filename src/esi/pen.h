/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Writes XML files of the fieldbus (ESI, ENI): elements and attributes.
 *
 * Host only. Context: mainline.
 */
#ifndef ECT_ESI_PEN_H
#define ECT_ESI_PEN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "esi/arena.h"
#include "seams/device.h"
#include "seams/plant.h"
#include "wire/linkage.h"

/** libxml2's xmlTextWriter, declared here so that this header does not include libxml2. */
struct _xmlTextWriter;

/** Destination of XML; ::ect_pen_file reports a failure at the end. */
typedef struct ect_pen {
    struct _xmlTextWriter *writer;
    ect_arena_t *arena;
    const ect_plant_t *plant; /* of the present device; NULL: none */
    bool failed;
} ect_pen_t;

ECT_C_BEGIN

/**
 * Writes a document.
 * @param write  writes the root element
 * @param[out] length  bytes of the file, without the terminator
 * @param[out] text, room  the reason of the failure, one line
 * @return the file (UTF-8), valid as long as the arena; NULL: out of memory
 */
const char *ect_pen_file(ect_arena_t *arena, void (*write)(ect_pen_t *pen, const void *what), const void *what,
                         size_t *length, char *text, size_t room);

void ect_pen_open(ect_pen_t *pen, const char *element);
void ect_pen_close(ect_pen_t *pen);

/** Writes an attribute of the element that was opened last, before any content of the element. */
__attribute__((format(printf, 3, 4))) void ect_pen_attribute(ect_pen_t *pen, const char *name, const char *format, ...);

/** Writes the attribute "true", or no attribute for false. */
void ect_pen_flag(ect_pen_t *pen, const char *name, bool value);

/** Writes the text of the open element, as CDATA if it contains characters with a meaning in XML. */
void ect_pen_content(ect_pen_t *pen, const char *text);

/** Writes a whole element with a text, a decimal number, `#x` and hexadecimal digits, or hexadecimal bytes. */
void ect_pen_text(ect_pen_t *pen, const char *element, const char *text);
void ect_pen_number(ect_pen_t *pen, const char *element, int64_t value);
void ect_pen_hex(ect_pen_t *pen, const char *element, uint32_t value, int digits);
void ect_pen_bytes(ect_pen_t *pen, const char *element, const uint8_t *bytes, size_t length);

/** Writes the `<RxPdo>` (outputs) or `<TxPdo>` of a device, assigned PDOs first, in the order of the assignment. */
void ect_pen_pdos(ect_pen_t *pen, const ect_device_t *device, bool outputs);

ECT_C_END

#endif
