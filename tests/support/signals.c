/* SPDX-License-Identifier: MIT */
#include "support/signals.h"

#include <stdio.h>
#include <stdlib.h>

void signal_find(wire_t *w, const char *name, ect_signal_ref_t *ref)
{
    if (!ect_chain_signal(w->chain, 0, name, ref))
        fail_msg("no signal %s", name);
}

bool signal_try_set(wire_t *w, const char *name, const char *value, char message[ECT_SIGNAL_MESSAGE])
{
    ect_signal_ref_t ref;
    signal_find(w, name, &ref);
    bool done = ect_signal_write(&ref, value, w->now_ns, message);
    ect_chain_wake(w->chain, 0);
    wire_poll(w);
    return done;
}

void signal_set(wire_t *w, const char *name, const char *value)
{
    char message[ECT_SIGNAL_MESSAGE] = "";
    if (!signal_try_set(w, name, value, message))
        fail_msg("%s := %s: %s", name, value, message);
}

void signal_get(wire_t *w, const char *name, char text[ECT_SIGNAL_TEXT_ROOM])
{
    ect_signal_ref_t ref;
    signal_find(w, name, &ref);
    ect_signal_read(&ref, text);
}

long long signal_number(wire_t *w, const char *name)
{
    char text[ECT_SIGNAL_TEXT_ROOM];
    signal_get(w, name, text);
    return strtoll(text, NULL, 10);
}

const char *signal_of_ru(unsigned int ru, const char *signal)
{
    static char names[4][ECT_SIGNAL_NAME];
    static unsigned int next;
    next = (next + 1) % 4;
    snprintf(names[next], sizeof names[next], "ru%u.%s", ru, signal);
    return names[next];
}
