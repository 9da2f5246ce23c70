/* SPDX-License-Identifier: MIT */
#include "page.h"

#include <string.h>

/* Wide tables scroll separately on a screen and are not clipped on paper. Charts have a white background. */
static const char style[] =
    ":root{color-scheme:light "
    "dark;--line:#c8ccd2;--head:#eef1f5;--ink:#1b1f24;--dim:#5a6472;--page:#fff;--link:#0b5cad}\n"
    "@media(prefers-color-scheme:dark){:root{--line:#3d444d;--head:#232930;--ink:#e3e7ec;--dim:#9aa5b1;--page:#15191e;"
    "--link:#7ab7ff}figure svg{filter:invert(.9) hue-rotate(180deg)}}\n"
    "body{font:15px/1.5 system-ui,sans-serif;margin:2em auto;max-width:72em;padding:0 1.2em;color:var(--ink);"
    "background:var(--page)}\n"
    "h1{margin-bottom:0}h1+p{margin-top:.2em;color:var(--dim)}h2{border-bottom:1px solid var(--line);margin-top:2em}"
    "h3{margin:1.6em 0 .4em}\n"
    "a{color:var(--link);text-decoration:none}a:hover{text-decoration:underline}\n"
    "nav{background:var(--head);border-radius:6px;padding:.6em 1em;line-height:1.8}nav b{margin-right:.6em}"
    "nav a{margin-right:.9em;white-space:nowrap}\n"
    ".table{overflow-x:auto}table{border-collapse:collapse;margin:.4em 0}"
    "th,td{border:1px solid var(--line);padding:3px 9px;text-align:left;vertical-align:top}"
    "th{background:var(--head)}:target{background:var(--head)}td{font-variant-numeric:tabular-nums}\n"
    "figure{margin:1em 0;overflow-x:auto}figure svg{max-width:100%;height:auto}figcaption{color:var(--dim)}\n"
    "@media print{body{margin:0;max-width:none;font-size:10pt}nav{border:1px solid var(--line)}"
    "a{color:inherit}.table,figure{overflow:visible}tr,figure{break-inside:avoid}h2,h3{break-after:avoid}"
    "thead{display:table-header-group}}\n";

static void put_text(page_t *p, const char *text)
{
    for (; *text; text++) {
        const char *html = *text == '<'   ? "&lt;"
                           : *text == '>' ? "&gt;"
                           : *text == '&' ? "&amp;"
                           : *text == '"' ? "&quot;"
                                          : NULL;
        bool escaped = !p->html && strchr("|<>*_`\\", *text);
        if (p->html && html)
            fputs(html, p->file);
        else
            fprintf(p->file, "%s%c", escaped ? "\\" : "", *text);
    }
}

/* Writes an opening tag. @param id  NULL: none */
static void put_tag(page_t *p, const char *tag, const char *id)
{
    fprintf(p->file, "<%s", tag);
    if (id)
        fprintf(p->file, " id=\"%s\"", id);
    fputc('>', p->file);
}

static void put_cell(page_t *p, const cell_t *cell)
{
    bool linked = p->html && cell->link;
    if (linked)
        fprintf(p->file, "<a href=\"#%s\">", cell->link);
    put_text(p, cell->text);
    if (linked)
        fputs("</a>", p->file);
}

void page_begin(page_t *p, const char *title, const char *subtitle)
{
    if (p->html) {
        fputs("<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
              "<meta name=\"viewport\" content=\"width=device-width\"><title>",
              p->file);
        put_text(p, title);
        fprintf(p->file, "</title>\n<style>\n%s</style></head><body>\n<h1>", style);
        put_text(p, title);
        fputs("</h1>\n", p->file);
    } else {
        fputs("# ", p->file);
        put_text(p, title);
        fputs("\n\n", p->file);
    }
    page_paragraph(p, subtitle);
}

void page_end(page_t *p)
{
    if (p->html)
        fputs("</body></html>\n", p->file);
}

void page_heading(page_t *p, int level, const char *id, const char *text)
{
    char tag[] = {'h', (char)('0' + level), 0};
    if (p->html)
        put_tag(p, tag, id);
    else
        fprintf(p->file, "%.*s ", level, "####");
    put_text(p, text);
    if (p->html)
        fprintf(p->file, "</%s>\n", tag);
    else
        fputs("\n\n", p->file);
}

void page_paragraph(page_t *p, const char *text)
{
    fputs(p->html ? "<p>" : "", p->file);
    put_text(p, text);
    fputs(p->html ? "</p>\n" : "\n\n", p->file);
}

void page_links(page_t *p, const char *label, const cell_t *links)
{
    if (!p->html)
        return;
    fputs("<div><b>", p->file);
    put_text(p, label);
    fputs("</b>", p->file);
    for (; links->text; links++) {
        fputc('\n', p->file);
        put_cell(p, links);
    }
    fputs("</div>\n", p->file);
}

void page_figure(page_t *p, const char *html, size_t length, const char *caption)
{
    if (!p->html)
        return;
    fputs("<figure role=\"img\" aria-label=\"", p->file);
    put_text(p, caption);
    fprintf(p->file, "\">%.*s<figcaption>", (int)length, html);
    put_text(p, caption);
    fputs("</figcaption></figure>\n", p->file);
}

void page_table(page_t *p, bool begin)
{
    if (p->html)
        fputs(begin ? "<div class=\"table\"><table>\n" : "</tbody></table></div>\n", p->file);
    else
        fputs(begin ? "" : "\n", p->file);
}

static void put_rule(page_t *p, const cell_t *cells)
{
    for (; cells->text; cells++)
        fputs("|---", p->file);
    fputs("|\n", p->file);
}

static void put_row(page_t *p, bool head, const char *id, const cell_t *cells)
{
    fputs(head ? "<thead>" : "", p->file);
    put_tag(p, "tr", id);
    for (; cells->text; cells++) {
        fputs(head ? "<th>" : "<td>", p->file);
        put_cell(p, cells);
        fputs(head ? "</th>" : "</td>", p->file);
    }
    fputs(head ? "</tr></thead><tbody>\n" : "</tr>\n", p->file);
}

void page_row(page_t *p, bool head, const char *id, const cell_t *cells)
{
    if (p->html) {
        put_row(p, head, id, cells);
        return;
    }
    fputc('|', p->file);
    for (const cell_t *cell = cells; cell->text; cell++) {
        fputc(' ', p->file);
        put_cell(p, cell);
        fputs(" |", p->file);
    }
    fputc('\n', p->file);
    if (head)
        put_rule(p, cells);
}
