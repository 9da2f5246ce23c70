/* SPDX-License-Identifier: MIT */
/** @file A network file (ENI) compared with itself, with ESI files, or with the slaves of a bus. */
#ifndef ECTWIN_VERIFY_NETWORK_H
#define ECTWIN_VERIFY_NETWORK_H

#include <stddef.h>

/**
 * Prints a line for each difference.
 * @param operands, count  paths of ESI files, or slave:IFACE alone
 * @return exit status: 0 no difference · 1 differences · 2 a source cannot be read, which is printed
 */
int verify_network(const char *path, const char *const operands[], size_t count);

#endif
