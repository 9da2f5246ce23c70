/* SPDX-License-Identifier: MIT */
/* Shared by all reports: counts, names of verdicts, escaped text. */
#include "report/report.h"

cf_counts_t cf_count(const cf_run_t *run, const cf_section_t *section)
{
    cf_counts_t counts = {{0}};
    for (size_t i = 0; i < run->count; i++) {
        if (!section || run->results[i].section == section)
            counts.of[run->results[i].verdict]++;
    }
    return counts;
}

const char *cf_verdict_name(cf_verdict_t verdict)
{
    static const char *const names[] = {"pass", "warn", "fail", "skip", "unjudged", "interrupted"};
    return names[verdict];
}

void cf_frames_text(const cf_result_t *result, char *text, size_t room)
{
    const cf_evidence_t *e = &result->evidence;
    text[0] = 0;
    if (e->first_frame == 0)
        return;
    int used = snprintf(text, room, "frames %u-%u", e->first_frame, e->last_frame);
    if ((result->verdict == CF_FAIL || result->verdict == CF_WARN) && result->frame != 0)
        snprintf(text + used, room - (size_t)used, ", seen in %u", result->frame);
}

/* Bytes of the well-formed UTF-8 sequence of two bytes or more (Unicode, table 3-7); 0: none, a slave may send
 * anything. */
static size_t utf8(const unsigned char *at)
{
    static const struct {
        unsigned char first, last, second_least, second_most, length;
    } forms[] = {{0xC2, 0xDF, 0x80, 0xBF, 2}, {0xE0, 0xE0, 0xA0, 0xBF, 3}, {0xE1, 0xEC, 0x80, 0xBF, 3},
                 {0xED, 0xED, 0x80, 0x9F, 3}, {0xEE, 0xEF, 0x80, 0xBF, 3}, {0xF0, 0xF0, 0x90, 0xBF, 4},
                 {0xF1, 0xF3, 0x80, 0xBF, 4}, {0xF4, 0xF4, 0x80, 0x8F, 4}};
    for (size_t i = 0; i < sizeof forms / sizeof forms[0]; i++) {
        if (at[0] < forms[i].first || at[0] > forms[i].last)
            continue;
        if (at[1] < forms[i].second_least || at[1] > forms[i].second_most)
            return 0;
        for (size_t n = 2; n < forms[i].length; n++) {
            if ((at[n] & 0xC0) != 0x80)
                return 0;
        }
        return forms[i].length;
    }
    return 0;
}

void cf_clean(char *text)
{
    unsigned char *at = (unsigned char *)text;
    while (*at != 0) {
        size_t length = *at >= 0x80 ? utf8(at) : 1;
        if (length == 0 || *at == 0x7F || (*at < 0x20 && *at != '\n'))
            *at = '?';
        at += length > 0 ? length : 1;
    }
}

static const char *entity(unsigned char byte)
{
    switch (byte) {
    case '&':
        return "&amp;";
    case '<':
        return "&lt;";
    case '>':
        return "&gt;";
    case '"':
        return "&quot;";
    default:
        return NULL;
    }
}

void cf_put_escaped(FILE *to, const char *text)
{
    const unsigned char *at = (const unsigned char *)text;
    while (*at != 0) {
        const char *escaped = entity(*at);
        size_t length = *at >= 0x80 ? utf8(at) : 0;
        if (length > 0)
            (void)fwrite(at, length, 1, to);
        else if (escaped)
            fputs(escaped, to);
        else
            fputc((*at < 0x20 && *at != '\n') || *at >= 0x7F ? '?' : *at, to);
        at += length > 0 ? length : 1;
    }
}
