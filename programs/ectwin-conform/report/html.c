/* SPDX-License-Identifier: MIT */
/* A self-contained HTML page, for a browser or for printing. The evidence of failures is unfolded, other evidence is
 * folded. */
#include "report/report.h"

enum { LINE = 4096 };

static const char style[] =
    ":root{color-scheme:light dark;--text:#1c1c1c;--page:#fff;--faint:#666;--line:#bbb;--code:#f5f5f3;--pass:#19692c;"
    "--fail:#b00020;--warn:#8a5a00;--sent:#00458b;--received:#5b2a86}\n"
    "@media(prefers-color-scheme:dark){:root{--text:#e4e4e4;--page:#161616;--faint:#a0a0a0;--line:#4a4a4a;--code:#222;"
    "--pass:#7ecb8f;--fail:#ff8a95;--warn:#e2b25a;--sent:#8fc1ff;--received:#d0a8ff}}\n"
    "body{font:15px/1.45 system-ui,sans-serif;max-width:62rem;margin:2rem auto;padding:0 1rem;color:var(--text);"
    "background:var(--page)}\n"
    "a{color:inherit}h1{font-size:1.5rem;margin:0 0 .6rem}h2{font-size:1.1rem;margin:2rem 0 .4rem;border-bottom:1px "
    "solid "
    "var(--line)}\n"
    ".verdict{border:2px solid;border-radius:.4rem;padding:.6rem 1rem;margin:0 0 1.2rem}.verdict b{font-size:1.25rem}\n"
    ".verdict ul{margin:.4rem 0 0;padding-left:1.2rem;color:var(--text)}.verdict li{margin:.1rem 0}\n"
    "table{border-collapse:collapse;width:100%}th,td{text-align:left;padding:.2rem .6rem .2rem 0;vertical-align:top}\n"
    "th{font-weight:600}.sums tr:first-child th,.sums tr:last-child th,.sums tr:last-child td{border-bottom:1px solid "
    "var(--line)}td.n,th.n{text-align:right}\n"
    ".about th{white-space:nowrap;width:9rem;font-weight:400;color:var(--faint)}.about td{overflow-wrap:anywhere}\n"
    ".blank{display:inline-block;min-width:16rem;border-bottom:1px solid var(--faint)}code{font:13px "
    "ui-monospace,monospace}\n"
    ".v{font-weight:700;white-space:nowrap}.pass{color:var(--pass)}.fail{color:var(--fail)}.warn,.unjudged{color:"
    "var(--warn)}\n"
    ".skip,.interrupted,.frames,summary{color:var(--faint)}.case{margin:.35rem 0;break-inside:avoid}\n"
    ".case .t{display:flex;gap:.7rem}.case .t .v{width:4.6rem}.case .id{white-space:nowrap;font-variant-numeric:"
    "tabular-nums}\n"
    ".why,.frames,summary{margin-left:9.3rem}.frames,summary{font-size:.85rem}summary{cursor:pointer}\n"
    ".failed{border-left:4px solid var(--fail);padding-left:.7rem;margin-left:-.95rem;break-inside:auto}.failed "
    ".why{color:var(--fail);font-weight:600}\n"
    "pre{font:12px/1.4 "
    "ui-monospace,monospace;background:var(--code);padding:.6rem;overflow-x:auto;white-space:pre-wrap;"
    "overflow-wrap:anywhere;margin:.4rem 0}\n"
    "pre .s{font-weight:600}pre .o{color:var(--sent)}pre .i{color:var(--received)}\n"
    "svg text{fill:var(--text)}svg rect{fill:var(--sent)}\n"
    "@media print{:root{color-scheme:light;--text:#000;--page:#fff;--faint:#444;--line:#888;--code:#fff;--pass:#19692c;"
    "--fail:#b00020;--warn:#8a5a00;--sent:#00458b;--received:#5b2a86}body{margin:0;max-width:none;font-size:10pt}"
    "details{display:none}pre{border:1px solid #ccc}h2{break-after:avoid}@page{margin:15mm}}\n";

static const char *device(const cf_run_t *run)
{
    return run->c.facts.name[0] != 0 ? run->c.facts.name : "EtherCAT slave";
}

static void head(FILE *to, const cf_run_t *run)
{
    fputs("<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
          "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>",
          to);
    cf_put_escaped(to, device(run));
    fprintf(to, ": EtherCAT conformance, %s</title>\n<style>\n%s</style></head><body>\n<h1>", run->started, style);
    cf_put_escaped(to, device(run));
    fputs(": EtherCAT conformance</h1>\n", to);
}

/* --- verdict ------------------------------------------------------------------------------------------------------ */

static void links(FILE *to, const cf_run_t *run, cf_verdict_t verdict)
{
    for (size_t i = 0; i < run->count; i++) {
        const cf_result_t *r = &run->results[i];
        if (r->verdict != verdict)
            continue;
        fprintf(to, "<li><a href=\"#%s\">%s</a> <span class=\"%s\">%s</span> ", r->entry->id, r->entry->id,
                cf_verdict_name(verdict), cf_verdict_name(verdict));
        cf_put_escaped(to, r->entry->title);
        fputs("<br>", to);
        cf_put_escaped(to, r->reason);
        fputs("</li>\n", to);
    }
}

/* The verdict of the run, then a link to each case that needs attention. */
static void verdict(FILE *to, const cf_run_t *run)
{
    const cf_counts_t n = cf_count(run, NULL);
    const size_t bad = n.of[CF_FAIL] + n.of[CF_UNJUDGED];
    const char *class = bad > 0 ? "fail" : run->count < run->planned ? "interrupted" : "pass";
    const char *word = bad > 0 ? "FAIL" : run->count < run->planned ? "INTERRUPTED" : "PASS";
    fprintf(to,
            "<div class=\"verdict %s\"><b>%s</b> &mdash; %zu of %zu cases ran: %zu pass, %zu warn, %zu fail, %zu skip",
            class, word, run->count, run->planned, n.of[CF_PASS], n.of[CF_WARN], n.of[CF_FAIL], n.of[CF_SKIPPED]);
    if (n.of[CF_UNJUDGED] > 0)
        fprintf(to, ", %zu not judged", n.of[CF_UNJUDGED]);
    fputs(".\n", to);
    if (bad + n.of[CF_WARN] > 0) {
        fputs("<ul>\n", to);
        links(to, run, CF_FAIL);
        links(to, run, CF_UNJUDGED);
        links(to, run, CF_WARN);
        fputs("</ul>\n", to);
    }
    fputs("</div>\n", to);
}

/* --- the run ------------------------------------------------------------------------------------------------------ */

/* @param text  NULL: a blank line for handwriting */
static void field(FILE *to, const char *name, const char *text, const char *tag)
{
    fprintf(to, "<tr><th>%s</th><td>", name);
    if (text) {
        fprintf(to, "<%s>", tag);
        cf_put_escaped(to, text);
        fprintf(to, "</%s>", tag);
    } else {
        fputs("<span class=\"blank\">&nbsp;</span>", to);
    }
    fputs("</td></tr>\n", to);
}

static void about(FILE *to, const cf_run_t *run)
{
    const cf_facts_t *f = &run->c.facts;
    char text[200];
    fputs("<table class=\"about\">\n", to);
    field(to, "Device", device(run), "b");
    snprintf(text, sizeof text, "vendor 0x%08X, product 0x%08X, revision 0x%08X, serial number %u", f->vendor,
             f->product, f->revision_no, f->serial);
    field(to, "Identity", text, "span");
    field(to, "Firmware", run->firmware, "span");
    snprintf(text, sizeof text, "type 0x%02X revision %u build %u, %u FMMUs, %u SyncManagers, %u KB", f->type,
             f->revision, f->build, f->fmmus, f->sms, f->ram_kb);
    field(to, "ESC", text, "span");
    snprintf(text, sizeof text, "%u bytes of inputs, %u bytes of outputs", f->input_bytes, f->output_bytes);
    field(to, "Process data", text, "span");
    field(to, "ESI file", run->esi ? run->esi : "none given (--esi)", "span");
    if (run->esi_hash[0] != 0)
        field(to, "ESI SHA-256", run->esi_hash, "code");
    snprintf(text, sizeof text, "slave %u of %u on %s", f->position + 1u, f->slaves, run->iface);
    field(to, "Connection", text, "span");
    snprintf(text, sizeof text, "%s, %.1f s", run->started, (double)run->duration_ns / 1e9);
    field(to, "Date", text, "span");
    field(to, "Operator", run->operator_, "span");
    snprintf(text, sizeof text, "ectwin-conform %s", run->version);
    field(to, "Tool", text, "span");
    field(to, "Command", run->command, "code");
    fputs("</table>\n<p class=\"skip\">Numbers and texts of the cases are those of ectwin-conform: this is not the "
          "ETG's conformance test, and a pass gives no certificate.</p>\n",
          to);
}

static void count_cells(FILE *to, const cf_counts_t *n)
{
    static const cf_verdict_t order[] = {CF_PASS, CF_WARN, CF_FAIL, CF_UNJUDGED, CF_SKIPPED};
    for (size_t i = 0; i < sizeof order / sizeof order[0]; i++) {
        if (n->of[order[i]] == 0)
            fputs("<td class=\"n skip\">&middot;</td>", to);
        else
            fprintf(to, "<td class=\"n %s\">%zu</td>", cf_verdict_name(order[i]), n->of[order[i]]);
    }
    fputs("</tr>\n", to);
}

static void summary(FILE *to, const cf_run_t *run)
{
    cf_counts_t all = cf_count(run, NULL);
    fputs("<table class=\"sums\"><tr><th>Section</th><th class=\"n\">pass</th><th class=\"n\">warn</th>"
          "<th class=\"n\">fail</th><th class=\"n\">not judged</th><th class=\"n\">skip</th></tr>\n",
          to);
    for (size_t i = 0; i < run->count; i++) {
        const cf_section_t *section = run->results[i].section;
        if (i > 0 && run->results[i - 1].section == section)
            continue;
        cf_counts_t n = cf_count(run, section);
        fprintf(to, "<tr><td><a href=\"#from-%s\">%c. ", section->cases[0].id, section->letter);
        cf_put_escaped(to, section->title);
        fputs("</a></td>", to);
        count_cells(to, &n);
    }
    fputs("<tr><th>All</th>", to);
    count_cells(to, &all);
    fputs("</table>\n", to);
}

/* --- cases -------------------------------------------------------------------------------------------------------- */

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

static void paragraph(FILE *to, const char *class, const char *before, const char *text)
{
    if (text[0] == 0)
        return;
    fprintf(to, "<div class=\"%s\">%s", class, before);
    cf_put_escaped(to, text);
    fputs("</div>\n", to);
}

static void one(FILE *to, const cf_run_t *run, const cf_result_t *r)
{
    const char *name = cf_verdict_name(r->verdict);
    char frames[80];
    const bool shown = r->verdict == CF_FAIL || r->verdict == CF_WARN;
    cf_frames_text(r, frames, sizeof frames);
    fprintf(to,
            "<div class=\"case%s\" id=\"%s\"><div class=\"t\"><span class=\"v %s\">%s</span><span "
            "class=\"id\">%s</span><span>",
            r->verdict == CF_FAIL ? " failed" : "", r->entry->id, name, name, r->entry->id);
    cf_put_escaped(to, r->entry->title);
    fputs("</span></div>\n", to);
    paragraph(to, "why", "", r->reason);
    if (r->verdict == CF_FAIL)
        paragraph(to, "frames", "at: ", r->step);
    if (shown)
        paragraph(to, "frames", "", frames);
    if (r->evidence.count > 0) {
        if (!shown)
            fprintf(to, "<details><summary>%s</summary>", frames[0] != 0 ? frames : "evidence");
        evidence(to, run, r);
        if (!shown)
            fputs("</details>\n", to);
    }
    fputs("</div>\n", to);
}

void cf_report_html(FILE *to, const cf_run_t *run)
{
    head(to, run);
    verdict(to, run);
    about(to, run);
    summary(to, run);
    for (size_t i = 0; i < run->count; i++) {
        const cf_section_t *section = run->results[i].section;
        if (i == 0 || run->results[i - 1].section != section) {
            fprintf(to, "<h2 id=\"from-%s\">%c. ", section->cases[0].id, section->letter);
            cf_put_escaped(to, section->title);
            fputs("</h2>\n", to);
        }
        one(to, run, &run->results[i]);
    }
    cf_timing_html(to, run);
    fputs("</body></html>\n", to);
}
