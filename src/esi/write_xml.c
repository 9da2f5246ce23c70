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
