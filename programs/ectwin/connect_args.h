/* SPDX-License-Identifier: MIT */
/** @file The option --connect: signals of one twin that set signals of another. */
#ifndef ECTWIN_CONNECT_ARGS_H
#define ECTWIN_CONNECT_ARGS_H

#include "bus/chain/chain.h"

/** Room for the reason of a failure. */
enum { CONNECT_MESSAGE = 640 };

/**
 * Connects the signals of a chain.
 * @param texts         `count` of N.NAME=M.NAME[,factor=F][,offset=O][,delay=T][,invert]
 * @param[out] wrong    on failure the index of the text
 * @param[out] message  of CONNECT_MESSAGE bytes: on failure one line for the user, which names the text
 * @return false: a text is wrong, or there is no memory
 */
bool connect_args_apply(ect_chain_t *chain, const char *const *texts, size_t count, size_t *wrong, char *message);

#endif
