/* SPDX-License-Identifier: MIT */
/** @file The option --panel: twins whose fronts `ectwin panel` shows. */
#ifndef ECTWIN_PANEL_ARGS_H
#define ECTWIN_PANEL_ARGS_H

#include "bus/chain/chain.h"
#include "connect_args.h"

/**
 * Checks that all parts of a list, separated by commas, are numbers or names of twins.
 * @param list          NULL: none
 * @param[out] message  of CONNECT_MESSAGE bytes: on failure one line for the user, which names the part
 * @return false: a part is wrong
 */
bool panel_args_check(const ect_chain_t *chain, const char *list, char *message);

#endif
