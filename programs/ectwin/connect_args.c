/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "connect_args.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "text/number.h"

enum { TEXT = 300, MESSAGE = 500 };

/* Parses "2.name" or "gripper.name": the number, from 1, or the name of a twin, and a signal of this twin. */
static bool read_end(const ect_chain_t *chain, const char *text, size_t *position, ect_signal_ref_t *ref, char *message)
{
    uint64_t number = 0;
    const char *dot = text + strcspn(text, ".");
    number = ect_names_find(ect_chain_names(chain), text, (size_t)(dot - text));
    if (number == 0)
        dot = ect_number_begins(text, 1, UINT16_MAX, &number);
    if (!dot || *dot != '.') {
        (void)snprintf(message, MESSAGE,
                       "'%.80s' is no signal of a twin: write its number or name first, as in 2.position", text);
        return false;
    }
    const size_t count = ect_chain_count(chain);
    if (number > count) {
        (void)snprintf(message, MESSAGE, "'%.80s': the chain has %zu twin%s", text, count, count == 1 ? "" : "s");
        return false;
    }
    *position = (size_t)number - 1;
    if (ect_chain_signal(chain, *position, dot + 1, ref))
        return true;
    (void)snprintf(message, MESSAGE, "twin %zu has no signal '%.80s': 'ectwin list-signals DEVICE' lists them",
                   *position + 1, dot + 1);
    return false;
}

static bool read_real(const char *text, double *value)
{
    char *end;
    *value = strtod(text, &end);
    return end != text && *end == 0 && isfinite(*value);
}

static bool read_property(ect_connection_t *c, const char *text, char *message)
{
    bool good = false;
    if (strcmp(text, "invert") == 0)
        good = c->invert = true;
    else if (strncmp(text, "factor=", 7) == 0)
        good = read_real(text + 7, &c->factor);
    else if (strncmp(text, "offset=", 7) == 0)
        good = read_real(text + 7, &c->offset);
    else if (strncmp(text, "delay=", 6) == 0)
        good = ect_number_time(text + 6, &c->delay_ns);
    if (!good)
        (void)snprintf(message, MESSAGE,
                       "'%.80s' is none of factor=NUMBER, offset=NUMBER, delay=TIME (as 10ms), invert", text);
    return good;
}

static bool check(const ect_connection_t *c, char *message)
{
    if (ect_connection_fits(c))
        return true;
    if (c->target.signal->access != ECT_SIGNAL_WRITE)
        (void)snprintf(message, MESSAGE, "%zu.%s cannot be set: write TARGET=SOURCE, as in --set", c->to + 1,
                       c->target.name);
    else
        (void)snprintf(message, MESSAGE, "%zu.%s and %zu.%s must both be numbers", c->to + 1, c->target.name,
                       c->from + 1, c->source.name);
    return false;
}

static bool read_connection(const ect_chain_t *chain, const char *text, ect_connection_t *c, char *message)
{
    char copy[TEXT];
    *c = (ect_connection_t){.factor = 1};
    (void)snprintf(copy, sizeof copy, "%s", text);
    char *rest = strchr(copy, '=');
    if (!rest || strlen(text) >= sizeof copy) {
        (void)snprintf(message, MESSAGE, "it takes TARGET=SOURCE, as in 1.channel_1=2.channel_1");
        return false;
    }
    *rest++ = 0;
    char *source = strsep(&rest, ",");
    if (!read_end(chain, copy, &c->to, &c->target, message) || !read_end(chain, source, &c->from, &c->source, message))
        return false;
    for (char *property = strsep(&rest, ","); property; property = strsep(&rest, ",")) {
        if (!read_property(c, property, message))
            return false;
    }
    return check(c, message);
}

bool connect_args_apply(ect_chain_t *chain, const char *const *texts, size_t count, size_t *wrong, char *message)
{
    char why[MESSAGE] = "out of memory";
    ect_connection_t *list = calloc(count + 1, sizeof *list);
    size_t done = 0;
    while (list && done < count && read_connection(chain, texts[done], &list[done], why))
        done++;
    bool good = list && done == count;
    size_t loop = good ? ect_connections_loop(list, count) : count;
    if (loop < count) {
        good = false;
        done = loop;
        (void)snprintf(why, sizeof why, "closes a loop of connections without a delay: add ,delay=1ms");
    }
    if (good && count > 0)
        good = ect_chain_connect(chain, list, count);
    *wrong = done < count ? done : 0;
    if (!good)
        (void)snprintf(message, CONNECT_MESSAGE, "--connect %.120s: %s", done < count ? texts[done] : "", why);
    free(list);
    return good;
}
