/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Contents of the reply to the request `about` of the control socket: information on the process and its twins.
 */
#ifndef ECT_BUS_CONTROL_ABOUT_H
#define ECT_BUS_CONTROL_ABOUT_H

#include <stddef.h>

#include "bus/chain/crossing.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** Texts of the caller; NULL: the reply has no such member. */
typedef struct ect_about {
    const char *name;    /**< given by the user */
    const char *devices; /**< as named at the start */
    const char *panel;   /**< twins whose fronts the panel shows: names or numbers, separated by commas */
    const char *words;   /**< working directory at the start, then the command line: texts, each with its terminator */
    size_t words_length; /**< bytes of `words` */
    const char *ifaces[ECT_ENDS]; /**< by end: the master's interface, or the twins' own */
} ect_about_t;

ECT_C_END

#endif
