/* SPDX-License-Identifier: MIT */
/** @file The command line of ectwin-conform. */
#ifndef ECTWIN_CONFORM_OPTIONS_H
#define ECTWIN_CONFORM_OPTIONS_H

#include "report/report.h"

enum { EXIT_CLEAN = 0, EXIT_FAILED = 1, EXIT_NOTHING = 2, EXIT_USAGE = 64, EXIT_INTERRUPTED = 130 };

/** All options. Texts point into argv. NULL: not given. */
typedef struct cf_options {
    const char *iface, *in_process, *only, *skip, *output, *pcap, *esi, *schema, *power, *plug, *file, *operator_,
        *firmware;
    unsigned long slave, seconds, seed, password;
    uint32_t requested; /**< cases on request, bits of CF_ON_REQUEST */
    cf_move_t move;     /**< distance 0: not given */
    cf_report_t report;
    bool list, destructive, whole, emulated;
} cf_options_t;

/** Reads the command line. Prints a message and exits with EXIT_USAGE on an error, with 0 after --help or --version. */
void cf_options_parse(cf_options_t *options, int argc, char **argv);
/** @return whether the options select a case */
bool cf_options_select(const cf_options_t *options, const cf_case_t *entry);
/** @return number of cases that the options select */
size_t cf_options_count(const cf_options_t *options);

#endif
