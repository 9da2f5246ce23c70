/* SPDX-License-Identifier: MIT */
/**
 * @file
 * /sys/class/net as a master in process finds it: the machine's interfaces, and those of the bus. The folder has two
 * trees, `up` and `down`, for the states of the latter (bus/inprocess/paths.c).
 */
#ifndef ECTWIN_NET_FOLDER_H
#define ECTWIN_NET_FOLDER_H

#include <stdbool.h>
#include <stddef.h>

/** Makes the two trees. @param names  of the interfaces of the bus @return false (errno) */
bool net_folder_make(const char *folder, const char *const *names, size_t count);

/** Removes a folder with everything in it. */
void net_folder_remove(const char *folder);

#endif
