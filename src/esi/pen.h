/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Writes XML files of the field, ESI and ENI: elements and attributes, the first failure kept.
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

/** libxml2's xmlTextWriter, so that users of this header need not include libxml2. */
struct _xmlTextWriter;

/** Destination of XML; a failure is kept until the end. */
typedef struct ect_pen {
    struct _xmlTextWriter *writer;
    ect_arena_t *arena;
    const ect_plant_t *plant; /* of the device that is being written; NULL: none */
    bool failed;
} ect_pen_t;

ECT_C_BEGIN

/**
 * Writes a document.
 * @param write  writes the root element
 * @param[out] length  bytes of the file, without the zero behind them
 * @param[out] text, room  the reason of the failure, one line
 * @return the file (UTF-8), as long as the arena; NULL: no memory left
 */
const char *ect_pen_file(ect_arena_t *arena, void (*write)(ect_pen_t *pen, const void *what), const void *what,
                         size_t *length, char *text, size_t room);

void ect_pen_open(ect_pen_t *pen, const char *element);
void ect_pen_close(ect_pen_t *pen);

/** An attribute of the element that was opened last, as long as it has no content. */
__attribute__((format(printf, 3, 4))) void ect_pen_attribute(ect_pen_t *pen, const char *name, const char *format, ...);

/** The same with "true"; one that is false is left out. */
void ect_pen_flag(ect_pen_t *pen, const char *name, bool value);

/** The text of the open element, as CDATA when it has characters that mean something in XML. */
void ect_pen_content(ect_pen_t *pen, const char *text);

/** A whole element with a text, a decimal number, `#x` and digits, or bytes in hexadecimal. */
void ect_pen_text(ect_pen_t *pen, const char *element, const char *text);
void ect_pen_number(ect_pen_t *pen, const char *element, int64_t value);
void ect_pen_hex(ect_pen_t *pen, const char *element, uint32_t value, int digits);
void ect_pen_bytes(ect_pen_t *pen, const char *element, const uint8_t *bytes, size_t length);

/** `<RxPdo>` (outputs) or `<TxPdo>` of a device: those assigned first, in the order of the assignment. */
void ect_pen_pdos(ect_pen_t *pen, const ect_device_t *device, bool outputs);

ECT_C_END

#endif
