/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Threads of this process as the kernel describes them in /proc/self/task.
 */
#ifndef ECT_BUS_INPROCESS_TASKS_H
#define ECT_BUS_INPROCESS_TASKS_H

#include <stdbool.h>
#include <sys/types.h>

/** Room for a name of ::ect_task_call. */
enum { ECT_TASK_CALL = 32 };

/** @return whether a thread sleeps in the kernel; false, too, if the thread has ended */
bool ect_task_sleeps(pid_t id);

/**
 * The system call in which a thread sleeps.
 * @param[out] name  ECT_TASK_CALL bytes, for a call without a name here
 * @return its name; "a system call": the thread is in none, or may not be read
 */
const char *ect_task_call(pid_t id, char *name);

/** @return whether a thread blocks a signal; true, too, if the thread has ended */
bool ect_task_blocks(pid_t id, int number);

#endif
