/* SPDX-License-Identifier: MIT */
/** @file
 * The signal mask of a wait, as in ppoll(2), pselect(2) and epoll_pwait(2). */
#ifndef ECT_BUS_INPROCESS_SIGNALS_H
#define ECT_BUS_INPROCESS_SIGNALS_H

#include <signal.h>

/**
 * Sets the mask of a wait.
 * @param mask         of the program (user.h); NULL: unchanged
 * @param[out] before  the present mask, for ::ect_signals_unmask
 * @return 0: wait; -1: the handler of a previously blocked signal has run (EINTR), a bad address (EFAULT)
 */
int ect_signals_mask(const sigset_t *mask, sigset_t *before);

/** Restores the mask, also after a failure; errno is unchanged. */
void ect_signals_unmask(const sigset_t *mask, const sigset_t *before);

#endif
