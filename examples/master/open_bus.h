/* SPDX-License-Identifier: MIT */
/** @file What masters have in common. */
#ifndef TOOLS_MASTER_OPEN_BUS_H
#define TOOLS_MASTER_OPEN_BUS_H

#include <stdbool.h>

/**
 * Opens an interface for SOEM, which says only that it did not work.
 * @param program  as the user has called it
 * @return whether it is open; else standard error says in a line what is missing, and how to get it
 */
bool open_bus(const char *program, const char *iface);

#endif
