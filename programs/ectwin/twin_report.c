/* SPDX-License-Identifier: MIT */
/* Reasons of a failed power-on: to standard error, or to the caller of a library. */
#include <stdarg.h>
#include <stdio.h>

#include "bus_place.h"
#include "commands.h"

static void report_at(const twin_args_t *args, const char *who, const char *place, const char *format, va_list values)
{
    char text[TWIN_MESSAGE];
    (void)vsnprintf(text, sizeof text, format, values);
    if (args->message)
        snprintf(args->message, TWIN_MESSAGE, "%s%s", place, text);
    else
        fprintf(stderr, "%s: %s%s\n", who, place, text);
}

void twin_args_report(const twin_args_t *args, const char *who, const char *format, ...)
{
    va_list values;
    va_start(values, format);
    report_at(args, who, "", format, values);
    va_end(values);
}

void twin_args_report_option(const twin_args_t *args, const char *who, const char *option, const char *format, ...)
{
    char place[BUS_PLACE];
    va_list values;
    va_start(values, format);
    report_at(args, who, bus_place_of(place, option), format, values);
    va_end(values);
}
