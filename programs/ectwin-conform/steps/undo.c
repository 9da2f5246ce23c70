/* SPDX-License-Identifier: MIT */
/* Undoes the lasting changes of a case. */
#include "steps/engine.h"

static void undo_one(cf_t *c, const cf_undo_t *u)
{
    if (u->what == CF_UNDO_SII) {
        cf_sii_write_word(c, u->index, ect_load_le16(u->data));
    } else if (u->what == CF_UNDO_FILE) {
        cf_go(c, u->state);
        uint32_t code = cf_write_file(c, c->password, u->file, u->size);
        if (code != 0)
            cf_fail(c, "restoring the file: error 0x%08X", code);
    } else if (u->what == CF_UNDO_CALL) {
        cf_go(c, CF_PREOP);
        u->put_back(c, u->data, u->size);
    } else {
        cf_go(c, CF_PREOP);
        uint32_t code = cf_download(c, u->index, u->sub, false, u->data, u->size);
        if (code != 0)
            cf_fail(c, "restoring %04Xh:%02X: abort 0x%08X", u->index, u->sub, code);
    }
}

void cf_put_back(cf_t *c)
{
    cf_engine_t *e = c->engine;
    cf_put_plug_back(c);
    cf_known_state(c);
    while (e->undo_count > 0)
        undo_one(c, &e->undo[--e->undo_count]);
    cf_known_state(c);
}
