/* SPDX-License-Identifier: MIT */
/** @file The files of the page, which content.cmake writes into the program at the build. */
#ifndef ECTWIN_PANEL_CONTENT_H
#define ECTWIN_PANEL_CONTENT_H

#include <stddef.h>

typedef struct content {
    const char *path; /**< "/" is the path of index.html; NULL: behind the last one */
    const char *type; /**< of the media */
    const unsigned char *bytes;
    size_t length;
} content_t;

extern const content_t contents[];

/** @return the file at a path, NULL: there is none */
const content_t *content_find(const char *path);

#endif
