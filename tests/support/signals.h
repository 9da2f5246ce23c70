/* SPDX-License-Identifier: MIT */
/** @file The operator's access to the twin at position 0 of a ::wire_t, by the names of its signals. */
#ifndef TESTS_SUPPORT_SIGNALS_H
#define TESTS_SUPPORT_SIGNALS_H

#include "bus/chain/signals.h"
#include "support/wire.h"

/* Asserts that the signal exists. */
void signal_find(wire_t *w, const char *name, ect_signal_ref_t *ref);
/* Writes it and polls. @return whether it was accepted; otherwise `message` has the reason */
bool signal_try_set(wire_t *w, const char *name, const char *value, char message[ECT_SIGNAL_MESSAGE]);
/* Asserts that it is accepted. */
void signal_set(wire_t *w, const char *name, const char *value);
void signal_get(wire_t *w, const char *name, char text[ECT_SIGNAL_TEXT_ROOM]);
long long signal_number(wire_t *w, const char *name);
/* "ru1.armed" and the like; valid until the fourth call after this one. */
const char *signal_of_ru(unsigned int ru, const char *signal);

#endif
