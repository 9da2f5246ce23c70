/* SPDX-License-Identifier: MIT */
#include "link.h"

#include <string.h>

#include "text/utf8.h"

bool link_ask(link_t *link, const char *text, const link_request_t *request)
{
    size_t length = strlen(text);
    if (link->count == LINK_WAITING || link->unsent + length + 1 > sizeof link->out)
        return false;
    memcpy(link->out + link->unsent, text, length);
    link->out[link->unsent + length] = '\n';
    link->unsent += length + 1;
    link->waiting[(link->first + link->count++) % LINK_WAITING] = *request;
    return true;
}

void link_sent(link_t *link, size_t length)
{
    link->unsent -= length;
    memmove(link->out, link->out + length, link->unsent);
}

/* A browser closes the connection at a message that is no UTF-8. */
static void make_text(char *line)
{
    for (size_t length; *line; line += length) {
        length = (unsigned char)*line < 0x80 ? 1 : ect_utf8_begins(line);
        if (length == 0)
            *line = '?'; /* and is passed in the next round */
    }
}

static bool is_change(const cJSON *line)
{
    return cJSON_HasObjectItem(line, "name") && cJSON_HasObjectItem(line, "value") && cJSON_HasObjectItem(line, "time");
}

static bool take_line(link_t *link, char *text, link_taker_t take, void *ctx)
{
    static const link_request_t change = {.kind = LINK_CHANGE};
    make_text(text);
    cJSON *line = cJSON_Parse(text);
    bool last = cJSON_IsBool(cJSON_GetObjectItemCaseSensitive(line, "ok"));
    bool known = line && (link->count > 0 || is_change(line));
    if (known && is_change(line)) {
        take(ctx, &change, text, line, false);
    } else if (known) {
        const link_request_t request = link->waiting[link->first];
        link->first = last ? (link->first + 1) % LINK_WAITING : link->first;
        link->count -= last;
        take(ctx, &request, text, line, last);
    }
    cJSON_Delete(line);
    return known;
}

bool link_take(link_t *link, const char *bytes, size_t length, link_taker_t take, void *ctx)
{
    for (size_t i = 0; i < length; i++) {
        if (link->received == sizeof link->line - 1 || bytes[i] == 0)
            return false;
        link->line[link->received++] = bytes[i];
        if (bytes[i] != '\n')
            continue;
        link->line[link->received - 1] = 0;
        link->received = 0;
        if (!take_line(link, link->line, take, ctx))
            return false;
    }
    return true;
}
