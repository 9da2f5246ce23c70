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
    const char *name;             /**< given by the user */
    const char *devices;          /**< as they were named at the start */
    const char *panel;            /**< twins whose fronts the panel shows: names or numbers, separated by commas */
    const char *words;            /**< folder of the start, then its command line: texts, each with its terminator */
    size_t words_length;          /**< bytes of `words` */
    const char *ifaces[ECT_ENDS]; /**< by end: the interface of the master, or the one on which the twins answer */
} ect_about_t;

ECT_C_END

#endif
