/* SPDX-License-Identifier: MIT */
/* The report for a terminal. */
#include <string.h>

#include "report/report.h"

enum { LINE = 4096, SHOWN_ITEMS = 24 };

static void evidence(FILE *to, const cf_run_t *run, const cf_result_t *r)
{
    const cf_evidence_t *e = &r->evidence;
    size_t start = cf_evidence_start(e);
    if (e->count - start > SHOWN_ITEMS)
        start = e->count - SHOWN_ITEMS;
    for (size_t i = start; i < e->count; i++) {
        static const char *const arrows[] = {"--", "->", "<-"};
        const cf_item_t *item = &e->items[i];
        char text[LINE];
        cf_decode(&run->c, item, text, sizeof text);
        if (item->kind == CF_ITEM_STEP)
            fprintf(to, "               %s %s\n", arrows[item->kind], text);
        else
            fprintf(to, "        %6u %s ", item->frame, arrows[item->kind]);
        for (const char *at = text; item->kind != CF_ITEM_STEP && *at != 0;) {
            int length = (int)strcspn(at, "\n");
            fprintf(to, "%s%.*s\n", at == text ? "" : "                  ", length, at);
            at += length + (at[length] == '\n');
        }
    }
}

static void one(FILE *to, const cf_run_t *run, const cf_result_t *r)
{
    char frames[80];
    cf_frames_text(r, frames, sizeof frames);
    fprintf(to, "  %-4s %s  %s%s%s%s\n", r->verdict == CF_FAIL ? "FAIL" : cf_verdict_name(r->verdict), r->entry->id,
            r->entry->title, frames[0] != 0 ? "  (" : "", frames, frames[0] != 0 ? ")" : "");
    if (r->reason[0] != 0)
        fprintf(to, "               %s\n", r->reason);
    if (r->verdict == CF_FAIL && r->step[0] != 0)
        fprintf(to, "               at: %s\n", r->step);
    if (r->verdict == CF_FAIL)
        evidence(to, run, r);
}

void cf_report_text(FILE *to, const cf_run_t *run)
{
    const cf_facts_t *f = &run->c.facts;
    const cf_section_t *section = NULL;
    cf_counts_t n = cf_count(run, NULL);
    fprintf(to, "slave %u of %u on %s: %s, vendor 0x%08X product 0x%08X revision 0x%08X, ESC type 0x%02X\n",
            f->position + 1u, f->slaves, run->iface, f->name[0] != 0 ? f->name : "without a name", f->vendor,
            f->product, f->revision_no, f->type);
    fprintf(to, "ESI file: %s\n", run->esi ? run->esi : "none given (--esi)");
    if (run->esi_hash[0] != 0)
        fprintf(to, "SHA-256: %s\n", run->esi_hash);
    for (size_t i = 0; i < run->count; i++) {
        const cf_result_t *r = &run->results[i];
        if (r->section != section)
            fprintf(to, "\n%c. %s\n", r->section->letter, r->section->title);
        section = r->section;
        one(to, run, r);
    }
    cf_timing_text(to, run);
    fprintf(to, "\n%zu of %zu cases in %.1f s: %zu pass, %zu warn, %zu fail, %zu skip", run->count, run->planned,
            (double)run->duration_ns / 1e9, n.of[CF_PASS], n.of[CF_WARN], n.of[CF_FAIL], n.of[CF_SKIPPED]);
    if (n.of[CF_UNJUDGED] > 0)
        fprintf(to, ", %zu not judged", n.of[CF_UNJUDGED]);
    fprintf(to, "%s\n", n.of[CF_INTERRUPTED] > 0 ? ", interrupted" : "");
}
