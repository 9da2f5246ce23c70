/* SPDX-License-Identifier: MIT */
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "check/internal.h"
#include "wire/assert.h"

bool wrong(const report_t *r, const char *format, ...)
{
    va_list arguments;
    ECT_ASSERT(r->text != NULL || r->room == 0);
    va_start(arguments, format);
    (void)vsnprintf(r->text, r->room, format, arguments);
    va_end(arguments);
    return false;
}

bool text_good(const report_t *r, const char *what, const char *text, size_t most)
{
    ECT_ASSERT(what != NULL && most > 0);
    if (!text || *text == 0)
        return wrong(r, "%s is missing", what);
    if (strlen(text) > most)
        return wrong(r, "%s is longer than %zu characters: '%.60s'", what, most, text);
    for (const char *c = text; *c != 0; c++) {
        if (*c < ' ' || *c > '~')
            return wrong(r, "%s has the character %02Xh, which is not a visible one", what, (unsigned char)*c);
    }
    return true;
}
