/* SPDX-License-Identifier: MIT */
/* One file for a browser or paper: nothing in it refers to anything outside. Failures are unfolded, the rest folds. */
#include "report/report.h"

enum { LINE = 4096 };

static const char head[] =
    "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
    "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>EtherCAT "
    "conformance</title>\n<style>\n"
    "body{font:15px/1.45 system-ui,sans-serif;max-width:62rem;margin:2rem auto;padding:0 "
    "1rem;color:#1c1c1c;background:#fff}\n"
    "h1{font-size:1.5rem;margin:0 0 .2rem}h2{font-size:1.1rem;margin:2rem 0 .4rem;border-bottom:1px solid #bbb}\n"
    "table{border-collapse:collapse;width:100%}th,td{text-align:left;padding:.2rem .6rem .2rem 0;vertical-align:top}\n"
    "th{font-weight:600;border-bottom:1px solid #bbb}td.n,th.n{text-align:right}\n"
    ".v{font-weight:700;white-space:nowrap}.pass{color:#19692c}.fail{color:#b00020}.warn{color:#8a5a00}\n"
    ".skip,.interrupted{color:#666}\n.case{margin:.35rem 0;break-inside:avoid}\n.case .t{display:flex;gap:.7rem}\n"
    ".case .t .v{width:3.4rem}.case .id{white-space:nowrap;font-variant-numeric:tabular-nums}\n"
    ".why,.frames{margin-left:9.1rem;color:#444}.frames{font-size:.85rem;color:#666}\n"
    ".failed{border-left:4px solid #b00020;padding-left:.7rem;margin-left:-.95rem;break-inside:auto}.failed "
    ".why{color:#b00020;font-weight:600}\n"
    "pre{font:12px/1.4 ui-monospace,monospace;background:#f5f5f3;padding:.6rem;overflow-x:auto;white-space:pre-wrap;"
    "overflow-wrap:anywhere;margin:.4rem 0}\n"
    "pre .s{color:#333;font-weight:600}pre .o{color:#00458b}pre .i{color:#5b2a86}\n"
    "summary{cursor:pointer;color:#666;font-size:.85rem;margin-left:9.1rem}\n"
    "@media print{body{margin:0;max-width:none;font-size:10pt}details{display:none}pre{background:none;border:1px "
    "solid #ccc}}\n"
    "</style></head><body>\n";

static void about(FILE *to, const cf_run_t *run)
{
    const cf_facts_t *f = &run->c.facts;
    fputs("<h1>", to);
    cf_put_escaped(to, f->name[0] != 0 ? f->name : "EtherCAT slave");
    fprintf(to, "</h1>\n<p>Slave %u of %u on ", f->position + 1u, f->slaves);
    cf_put_escaped(to, run->iface);
    fprintf(to,
            ", %s, %.1f s. Vendor 0x%08X, product 0x%08X, revision 0x%08X, serial %u; ESC type 0x%02X, %u FMMUs, %u "
            "SyncManagers, %u KB; %u bytes in, %u out.</p>\n",
            run->started, (double)run->duration_ns / 1e9, f->vendor, f->product, f->revision_no, f->serial, f->type,
            f->fmmus, f->sms, f->ram_kb, f->input_bytes, f->output_bytes);
    fputs("<p>ESI file: ", to);
    cf_put_escaped(to, run->esi ? run->esi : "none given");
    fputs(".</p>\n", to);
    fputs(
        "<p>Written by ectwin-conform. Its numbers and words are its own: this is not the ETG's conformance test, and "
        "passing it gives no certificate.</p>\n",
        to);
}

static void count_cells(FILE *to, const cf_counts_t *n)
{
    static const cf_verdict_t order[] = {CF_PASS, CF_WARN, CF_FAIL, CF_SKIPPED};
    for (size_t i = 0; i < sizeof order / sizeof order[0]; i++) {
        if (n->of[order[i]] == 0)
            fputs("<td class=\"n\">&middot;</td>", to);
        else
            fprintf(to, "<td class=\"n %s\">%zu</td>", cf_verdict_name(order[i]), n->of[order[i]]);
    }
    fputs("</tr>\n", to);
}

static void summary(FILE *to, const cf_run_t *run)
{
    cf_counts_t all = cf_count(run, NULL);
    fputs("<table><tr><th>Section</th><th class=\"n\">pass</th><th class=\"n\">warn</th><th class=\"n\">fail</th>"
          "<th class=\"n\">skip</th></tr>\n",
          to);
    for (size_t i = 0; i < run->count; i++) {
        const cf_section_t *section = run->results[i].section;
        if (i > 0 && run->results[i - 1].section == section)
            continue;
        cf_counts_t n = cf_count(run, section);
        fprintf(to, "<tr><td>%c. ", section->letter);
        cf_put_escaped(to, section->title);
        fputs("</td>", to);
        count_cells(to, &n);
    }
    fputs("<tr><th>All</th>", to);
    count_cells(to, &all);
    fputs("</table>\n", to);
    if (run->count < run->planned)
        fprintf(to, "<p class=\"fail\">Interrupted: %zu of %zu cases ran.</p>\n", run->count, run->planned);
}

static void evidence(FILE *to, const cf_run_t *run, const cf_result_t *r)
{
    static const char *const classes[] = {"s", "o", "i"}, *const arrows[] = {"", "&rarr;", "&larr;"};
    fputs("<pre>", to);
    for (size_t i = cf_evidence_start(&r->evidence); i < r->evidence.count; i++) {
        const cf_item_t *item = &r->evidence.items[i];
        char text[LINE];
        cf_decode(&run->c, item, text, sizeof text);
        fprintf(to, "<span class=\"%s\">", classes[item->kind]);
        if (item->kind != CF_ITEM_STEP)
            fprintf(to, "%6u %s ", item->frame, arrows[item->kind]);
        cf_put_escaped(to, text);
        fputs("</span>\n", to);
    }
    fputs("</pre>\n", to);
}

static void one(FILE *to, const cf_run_t *run, const cf_result_t *r)
{
    const char *verdict = cf_verdict_name(r->verdict);
    char frames[80];
    bool failed = r->verdict == CF_FAIL || r->verdict == CF_WARN;
    cf_frames_text(r, frames, sizeof frames);
    fprintf(to,
            "<div class=\"case%s\" id=\"%s\"><div class=\"t\"><span class=\"v %s\">%s</span><span "
            "class=\"id\">%s</span><span>",
            r->verdict == CF_FAIL ? " failed" : "", r->entry->id, verdict, verdict, r->entry->id);
    cf_put_escaped(to, r->entry->title);
    fputs("</span></div>\n", to);
    if (r->reason[0] != 0) {
        fputs("<div class=\"why\">", to);
        cf_put_escaped(to, r->reason);
        fputs("</div>\n", to);
    }
    if (r->verdict == CF_FAIL && r->step[0] != 0) {
        fputs("<div class=\"frames\">at: ", to);
        cf_put_escaped(to, r->step);
        fputs("</div>\n", to);
    }
    if (failed && frames[0] != 0)
        fprintf(to, "<div class=\"frames\">%s of the capture</div>\n", frames);
    if (r->evidence.count > 0) {
        if (!failed)
            fprintf(to, "<details><summary>%s</summary>", frames);
        evidence(to, run, r);
        if (!failed)
            fputs("</details>\n", to);
    }
    fputs("</div>\n", to);
}

void cf_report_html(FILE *to, const cf_run_t *run)
{
    fputs(head, to);
    about(to, run);
    summary(to, run);
    for (size_t i = 0; i < run->count; i++) {
        const cf_section_t *section = run->results[i].section;
        if (i == 0 || run->results[i - 1].section != section) {
            fprintf(to, "<h2>%c. ", section->letter);
            cf_put_escaped(to, section->title);
            fputs("</h2>\n", to);
        }
        one(to, run, &run->results[i]);
    }
    cf_timing_html(to, run);
    fputs("</body></html>\n", to);
}
