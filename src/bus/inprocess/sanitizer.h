/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A sanitizer between the master's program and this library. Functions of the sanitizer hold locks while they call this
 * library, so no other thread may get the turn there.
 */
#ifndef ECT_BUS_INPROCESS_SANITIZER_H
#define ECT_BUS_INPROCESS_SANITIZER_H

#include <stdbool.h>

/** @return whether AddressSanitizer, LeakSanitizer or ThreadSanitizer is loaded as a shared library */
bool ect_sanitizer_is_loaded(void);

/** @return whether an address is in the code of the sanitizer */
bool ect_sanitizer_has(const void *address);

#endif
