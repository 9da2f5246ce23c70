/* SPDX-License-Identifier: MIT */
/* Common parts of all reports: counts, names of verdicts, escaped text. */
#include "report/report.h"

#include "text/utf8.h"

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

void cf_clean(char *text)
{
    while (*text != 0) {
        const unsigned char byte = (unsigned char)*text;
        size_t length = byte >= 0x80 ? ect_utf8_begins(text) : 1;
        if (length == 0 || byte == 0x7F || (byte < 0x20 && byte != '\n'))
            *text = '?';
        text += length > 0 ? length : 1;
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
    while (*text != 0) {
        const unsigned char byte = (unsigned char)*text;
        const char *escaped = entity(byte);
        size_t length = ect_utf8_begins(text);
        if (length > 0)
            (void)fwrite(text, length, 1, to);
        else if (escaped)
            fputs(escaped, to);
        else
            fputc((byte < 0x20 && byte != '\n') || byte >= 0x7F ? '?' : byte, to);
        text += length > 0 ? length : 1;
    }
}
