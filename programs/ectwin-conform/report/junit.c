/* SPDX-License-Identifier: MIT */
/* The report for CI servers: one test suite for each section, one test case for each case. */
#include "report/report.h"

enum { LINE = 4096 };

static void text_of(FILE *to, const cf_run_t *run, const cf_result_t *r)
{
    for (size_t i = cf_evidence_start(&r->evidence); i < r->evidence.count; i++) {
        static const char *const kinds[] = {"step", "sent", "received"};
        const cf_item_t *item = &r->evidence.items[i];
        char text[LINE];
        cf_decode(&run->c, item, text, sizeof text);
        fprintf(to, "%u %s: ", item->frame, kinds[item->kind]);
        cf_put_escaped(to, text);
        fputc('\n', to);
    }
}

static void tagged(FILE *to, const cf_run_t *run, const cf_result_t *r, const char *tag)
{
    char frames[80];
    cf_frames_text(r, frames, sizeof frames);
    fprintf(to, "<%s message=\"", tag);
    cf_put_escaped(to, r->reason);
    fprintf(to, "\">%s\n", frames);
    text_of(to, run, r);
    fprintf(to, "</%s>", tag);
}

static void one(FILE *to, const cf_run_t *run, const cf_result_t *r)
{
    fprintf(to, "    <testcase classname=\"%c. ", r->section->letter);
    cf_put_escaped(to, r->section->title);
    fprintf(to, "\" name=\"%s ", r->entry->id);
    cf_put_escaped(to, r->entry->title);
    fprintf(to, "\" time=\"%.3f\">", (double)r->duration_ns / 1e9);
    if (r->verdict == CF_FAIL) {
        tagged(to, run, r, "failure");
    } else if (r->verdict == CF_UNJUDGED) {
        tagged(to, run, r, "error");
    } else if (r->verdict == CF_SKIPPED || r->verdict == CF_INTERRUPTED) {
        fprintf(to, "<skipped message=\"");
        cf_put_escaped(to, r->reason);
        fprintf(to, "\"/>");
    } else if (r->reason[0] != 0) {
        fprintf(to, "<system-out>%s: ", cf_verdict_name(r->verdict));
        cf_put_escaped(to, r->reason);
        fprintf(to, "</system-out>");
    }
    fprintf(to, "</testcase>\n");
}

void cf_report_junit(FILE *to, const cf_run_t *run)
{
    fprintf(to, "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites time=\"%.3f\">\n",
            (double)run->duration_ns / 1e9);
    for (size_t i = 0; i < run->count;) {
        const cf_section_t *section = run->results[i].section;
        cf_counts_t n = cf_count(run, section);
        size_t total =
            n.of[CF_PASS] + n.of[CF_WARN] + n.of[CF_FAIL] + n.of[CF_SKIPPED] + n.of[CF_UNJUDGED] + n.of[CF_INTERRUPTED];
        fprintf(to, "  <testsuite name=\"%c. ", section->letter);
        cf_put_escaped(to, section->title);
        fprintf(to, "\" tests=\"%zu\" failures=\"%zu\" errors=\"%zu\" skipped=\"%zu\" timestamp=\"%s\">\n", total,
                n.of[CF_FAIL], n.of[CF_UNJUDGED], n.of[CF_SKIPPED] + n.of[CF_INTERRUPTED], run->started);
        for (; i < run->count && run->results[i].section == section; i++)
            one(to, run, &run->results[i]);
        fprintf(to, "  </testsuite>\n");
    }
    fprintf(to, "</testsuites>\n");
}
