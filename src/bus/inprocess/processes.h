/* SPDX-License-Identifier: MIT */
/** @file
 * Child processes of the master. */
#ifndef ECT_BUS_INPROCESS_PROCESSES_H
#define ECT_BUS_INPROCESS_PROCESSES_H

#include <stdbool.h>

/** Whether the master has a child process that runs. */
bool ect_processes_run(void);

#endif
