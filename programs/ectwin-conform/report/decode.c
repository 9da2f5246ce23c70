/* SPDX-License-Identifier: MIT */
/* Evidence as text. */
#include <stdio.h>
#include <string.h>

#include "bus/capture/decode.h"
#include "report/report.h"

void cf_decode(const cf_t *c, const cf_item_t *item, char *text, size_t room)
{
    const ect_mailboxes_t mailboxes = {.out_start = c->mailbox.out_start, .in_start = c->mailbox.in_start};
    if (item->kind == CF_ITEM_STEP)
        snprintf(text, room, "%s", (const char *)item->bytes);
    else
        ect_decode_frame(&mailboxes, item->bytes, item->length, item->kind == CF_ITEM_SENT, text, room);
    size_t used = strlen(text);
    if (item->folded == 1)
        snprintf(text + used, room - used, " (and once before)");
    else if (item->folded > 1)
        snprintf(text + used, room - used, " (and %u times before)", item->folded);
}

size_t cf_evidence_start(const cf_evidence_t *evidence)
{
    for (size_t i = 0; i < evidence->count; i++) {
        if (evidence->items[i].kind == CF_ITEM_STEP &&
            strcmp((const char *)evidence->items[i].bytes, CF_CASE_BEGINS) == 0)
            return i + 1;
    }
    return 0;
}
