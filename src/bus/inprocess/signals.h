/* SPDX-License-Identifier: MIT */
/** @file
 * The signal mask of a wait, as ppoll(2) and its kin take it. */
#ifndef ECT_BUS_INPROCESS_SIGNALS_H
#define ECT_BUS_INPROCESS_SIGNALS_H

#include <signal.h>

/**
 * Sets the mask of a wait.
 * @param mask         NULL: the mask stays
 * @param[out] before  the present mask, for ::ect_signals_unmask
 * @return 0: wait; -1 (EINTR): the handler of a signal that was blocked before has run
 */
int ect_signals_mask(const sigset_t *mask, sigset_t *before);

/** Restores the mask; errno stays. */
void ect_signals_unmask(const sigset_t *mask, const sigset_t *before);

#endif
