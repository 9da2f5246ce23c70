/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The folder that replaces /sys/class/net for a master with twins in its process: the interfaces of the machine and
 * those of the bus. Its two trees, `up` and `down`, are for the two states of the bus (bus/inprocess/paths.c).
 */
#ifndef ECTWIN_NET_FOLDER_H
#define ECTWIN_NET_FOLDER_H

#include <stdbool.h>
#include <stddef.h>

/** Creates the two trees. @param names  of the interfaces of the bus @return false (errno) */
bool net_folder_make(const char *folder, const char *const *names, size_t count);

/** Removes a folder with everything in it. */
void net_folder_remove(const char *folder);

#endif
