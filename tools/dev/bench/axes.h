/* SPDX-License-Identifier: MIT */
/** @file Time of CiA 402 drives with their plants, in this process. */
#ifndef TOOLS_BENCH_AXES_H
#define TOOLS_BENCH_AXES_H

/**
 * Runs drives in csp, each with new outputs every millisecond, and prints a line of JSON: processor time for an axis
 * and millisecond, number of axes of a core at 1 kHz.
 * @param argument  AXES, MS: 1 and more each
 * @return exit status
 */
int axes(char **argument);

#endif
