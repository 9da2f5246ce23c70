/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A document of headings and tables, written as Markdown or as a self-contained HTML page.
 *
 * Texts are escaped for the format. Links and their targets exist only in HTML.
 */
#ifndef ECTWIN_PAGE_H
#define ECTWIN_PAGE_H

#include <stdbool.h>
#include <stdio.h>

/** A page that is being written. */
typedef struct page {
    FILE *file; /**< the caller's */
    bool html;
} page_t;

/** A cell of a table. */
typedef struct cell {
    const char *text; /**< NULL ends a row */
    const char *link; /**< id of a heading or row of the page; NULL: no link */
} cell_t;

void page_begin(page_t *p, const char *title, const char *subtitle);
void page_end(page_t *p);

/** @param level  2 to 4; @param id  target of links; NULL: none */
void page_heading(page_t *p, int level, const char *id, const char *text);
void page_paragraph(page_t *p, const char *text);

/** Writes a line of links, one for each cell, as a table of contents. In Markdown: no effect. */
void page_links(page_t *p, const char *label, const cell_t *links);

/** @param html  shown as it is, without escapes, in HTML only; @param caption  text below it */
void page_figure(page_t *p, const char *html, size_t length, const char *caption);

/** Begins or ends a table. The rows, the head first, are written between the two calls. */
void page_table(page_t *p, bool begin);
void page_row(page_t *p, bool head, const char *id, const cell_t *cells);

/** Writes the head of a table, and a row; the arguments are cells. */
#define PAGE_HEAD(p, ...) page_row(p, true, NULL, (const cell_t[]){__VA_ARGS__, {NULL, NULL}})
#define PAGE_ROW(p, ...)  page_row(p, false, NULL, (const cell_t[]){__VA_ARGS__, {NULL, NULL}})
/** A cell without a link. */
#define CELL(words) {.text = (words)}

#endif
