/* SPDX-License-Identifier: MIT */
#include "bus/chain/fields.h"

#include <ctype.h>
#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

__attribute__((format(printf, 2, 3))) static void append(char *text, const char *format, ...)
{
    size_t length = strlen(text);
    va_list values;
    va_start(values, format);
    (void)vsnprintf(text + length, ECT_FIELD_TEXT - length, format, values);
    va_end(values);
}

/* Compares without the number of the structure: the field "ru.state" describes the signal "ru1.state". */
static bool is_signal(const ect_signal_ref_t *ref, const char *wanted)
{
    const char *dot = strchr(ref->name, '.');
    size_t prefix = dot ? (size_t)(dot - ref->name) : 0;
    while (ref->number > 0 && prefix > 0 && isdigit((unsigned char)ref->name[prefix - 1]))
        prefix--;
    return strncmp(ref->name, wanted, prefix) == 0 && strcmp(dot ? dot : ref->name, wanted + prefix) == 0;
}

const ect_field_t *ect_signal_field(const ect_signal_ref_t *ref)
{
    for (const ect_field_t *field = ref->plant->fields; field && field->index != 0; field++) {
        if (field->signal && is_signal(ref, field->signal))
            return field;
    }
    return NULL;
}

void ect_field_values(const ect_field_t *field, char *text)
{
    enum { LARGEST_DECIMAL = 999 };
    *text = 0;
    for (const ect_value_name_t *v = field->values; v && v->name; v++)
        append(text, v->value > LARGEST_DECIMAL ? "%s0x%08" PRIX64 " %s" : "%s%" PRId64 " %s",
               v == field->values ? "" : ", ", v->value, v->name);
}

void ect_field_text(const ect_field_t *field, char *text)
{
    char values[ECT_FIELD_TEXT];
    *text = 0;
    append(text, "%04Xh:%u", field->index, field->subindex);
    if (field->width == 1)
        append(text, " bit %u", field->bit);
    else if (field->width > 1)
        append(text, " bits %u to %u", field->bit, field->bit + field->width - 1u);
    ect_field_values(field, values);
    if (*values)
        append(text, ": %s", values);
}
