/* SPDX-License-Identifier: MIT */
/** @file The plant's side of the twin that $ECTWIN_SOCKET names: its signals, over the control socket. */
#ifndef TESTS_INTEGRATION_PLANT_H
#define TESTS_INTEGRATION_PLANT_H

/* Each asserts that the twin answers. */

/* Asserts that it is taken. */
void plant_set(const char *name, const char *value);
/* The same for another slave of the chain, from 1. */
void plant_set_of(unsigned int slave, const char *name, const char *value);
/* "a=1 b=2": one after the other. */
void plant_set_all(const char *settings);
/* Asserts that it is refused, with a message that contains `why`. */
void plant_refuses(const char *name, const char *value, const char *why);
/* The value as text; valid until the next call. */
const char *plant_get(const char *name);
long long plant_number(const char *name);

#endif
