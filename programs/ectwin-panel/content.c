/* SPDX-License-Identifier: MIT */
#include "content.h"

#include <string.h>

const content_t *content_find(const char *path)
{
    for (const content_t *content = contents; content->path; content++) {
        if (strcmp(content->path, path) == 0)
            return content;
    }
    return NULL;
}
