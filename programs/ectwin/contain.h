/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A command in a PID namespace of its own: no process that it leaves behind outlives it, or the program that started
 * it, however that ends.
 */
#ifndef ECTWIN_CONTAIN_H
#define ECTWIN_CONTAIN_H

#include <sys/types.h>

/** Status of a process that has ended, as a shell reports it: its exit status, or 128 and the number of a signal. */
int contain_status(int wait_status);

/**
 * Starts `run` as process 2 of a new PID namespace with a /proc of its own where the system allows that. Process 1 of
 * the namespace passes on signals that it receives, but those from the terminal, which `run` has received itself. When
 * `run` ends, process 1 ends the processes that are left, by force after a second, and exits with ::contain_status of
 * `run`. It is killed, and the namespace with it, when the calling process ends in any way.
 *
 * Needs CAP_SYS_ADMIN in the user namespace, as after ::ect_netns_enter.
 * @param run  must not return; signals are blocked in it
 * @return the process id of process 1, a child of the calling process; -1 (errno)
 */
pid_t contain_start(void (*run)(const void *ctx), const void *ctx);

#endif
