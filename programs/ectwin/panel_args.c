/* SPDX-License-Identifier: MIT */
#include "panel_args.h"

#include <stdio.h>
#include <string.h>

#include "text/number.h"

bool panel_args_check(const ect_chain_t *chain, const char *list, char *message)
{
    size_t length;
    for (const char *part = list; part; part = part[length] ? part + length + 1 : NULL) {
        length = strcspn(part, ",");
        uint64_t number = ect_names_find(ect_chain_names(chain), part, length);
        const char *end = number > 0 ? part + length : ect_number_begins(part, 1, UINT16_MAX, &number);
        if (end == part + length && number <= ect_chain_count(chain))
            continue;
        (void)snprintf(message, CONNECT_MESSAGE,
                       "--panel: '%.*s' is no twin: write names or numbers from 1 to %zu, as in camera,axis",
                       (int)(length < 80 ? length : 80), part, ect_chain_count(chain));
        return false;
    }
    return true;
}
