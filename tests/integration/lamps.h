/* SPDX-License-Identifier: MIT */
/** @file The lamps of a slave that is alone on the wire, over states, errors and traffic (ETG.1300). */
#ifndef TESTS_INTEGRATION_LAMPS_H
#define TESTS_INTEGRATION_LAMPS_H

#include "soem.h"

/* From any state without process data; ends with the watchdog expired. Asserts what `ecat.*` shows on the way. */
void lamps_follow(soem_t *m);

#endif
