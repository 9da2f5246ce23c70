/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A command in a PID namespace: the processes of the command end with the command, and with the program that started
 * the command, even if the program is killed.
 */
#ifndef ECTWIN_CONTAIN_H
#define ECTWIN_CONTAIN_H

#include <sys/types.h>

/** Status of an ended process as in a shell: the exit status, or 128 + the number of the signal. */
int contain_status(int wait_status);

/**
 * Starts `run` as process 2 of a new PID namespace, with a private /proc if the system permits. Process 1 of the
 * namespace forwards the signals that it receives, except those from the terminal, which `run` receives itself. When
 * `run` ends, process 1 terminates the remaining processes, kills them after a second, and exits with ::contain_status
 * of `run`. When the calling process ends in any way, the kernel kills process 1 and the namespace.
 *
 * Needs CAP_SYS_ADMIN in the user namespace, as after ::ect_netns_enter.
 * @param run  must not return; signals are blocked in it
 * @return the process id of process 1, a child of the calling process; -1 (errno)
 */
pid_t contain_start(void (*run)(const void *ctx), const void *ctx);

#endif
