/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A sanitizer between the master's program and this library. Its functions hold locks of its own while they call this
 * library, so that no other thread may get the turn there.
 */
#ifndef ECT_BUS_INPROCESS_SANITIZER_H
#define ECT_BUS_INPROCESS_SANITIZER_H

#include <stdbool.h>

/** Whether the process has AddressSanitizer, LeakSanitizer or ThreadSanitizer as a shared library. */
bool ect_sanitizer_is_loaded(void);

/** Whether an address is in the code of that library. */
bool ect_sanitizer_has(const void *address);

#endif
