/* SPDX-License-Identifier: MIT */
/** @file Memories, EEPROMs and folders of twins: --store and --files. */
#ifndef ECTWIN_TWIN_STORAGE_H
#define ECTWIN_TWIN_STORAGE_H

#include "commands.h"

/**
 * Opens what the twins of a command line keep, before their power-on. ::twin_args_free closes it.
 * @return false: failure, with the reason reported by ::twin_args_report_option
 */
bool twin_storage_open(twin_args_t *args, const char *who);

/** Lets each save of the twins wait for the disk, see ::ect_memory_wait. After their power-on. */
void twin_storage_wait(twin_args_t *args);

#endif
