/* SPDX-License-Identifier: MIT */
/* What all reports share: counts, names of verdicts, escaped text. */
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
    static const char *const names[] = {"pass", "warn", "fail", "skip", "interrupted"};
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

void cf_put_escaped(FILE *to, const char *text)
{
    for (; *text != 0; text++) {
        unsigned char byte = (unsigned char)*text;
        if (byte == '&')
            fputs("&amp;", to);
        else if (byte == '<')
            fputs("&lt;", to);
        else if (byte == '>')
            fputs("&gt;", to);
        else if (byte == '"')
            fputs("&quot;", to);
        else
            fputc((byte < 0x20 && byte != '\n') || byte >= 0x7F ? '?' : byte, to);
    }
}
