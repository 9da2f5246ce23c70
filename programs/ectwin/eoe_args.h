/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The command-line option for the networks behind twins with EoE.
 */
#ifndef ECTWIN_EOE_ARGS_H
#define ECTWIN_EOE_ARGS_H

#include <argp.h>
#include <stdbool.h>
#include <stddef.h>

#include "bus/chain/names.h"
#include "bus/chain/twin_config.h"
#include "bus/eoe/hosts.h"
#include "bus/eoe/network.h"

/** An option --eoe=[N:]PLACE; N is the number or the name of a twin. */
typedef struct eoe_setting {
    size_t twin;      /**< from 1, set by ::eoe_args_join */
    const char *text; /**< the option, as given */
    const char *place;
} eoe_setting_t;

typedef struct eoe_args {
    eoe_setting_t *settings;
    size_t count;
    const char *wrong;        /**< the option for which ::eoe_args_join has failed; NULL: none */
    bool has_hosts;           /**< whether the command supports TAPs and sockets */
    ect_network_t **networks; /**< one for each twin, NULL without EoE */
    size_t network_count;
} eoe_args_t;

/** Argp parser for the option; its input is an eoe_args_t. */
extern const struct argp eoe_argp;

enum { EOE_MESSAGE = ECT_PLACE_MESSAGE + 128 };

/** Finds an option with a TAP or a socket. @return the first one; NULL: none */
const char *eoe_args_host(const eoe_args_t *args);

/**
 * Adds a network to each twin with EoE, before the chain is made.
 * @param names         of the twins; NULL: none
 * @param[out] message  on failure one line, EOE_MESSAGE bytes
 * @return false: failure
 */
bool eoe_args_join(eoe_args_t *args, const ect_names_t *names, ect_twin_config_t *twins, size_t count, char *message);

/**
 * Opens the TAPs and sockets of the options, in the present network namespace.
 * @param[out] hosts    NULL: the options name none, or failure
 * @param quiet         suppresses the note that names each host
 * @param[out] message  on failure one line, EOE_MESSAGE bytes
 * @return false: failure
 */
bool eoe_args_open(const eoe_args_t *args, const char *who, bool quiet, ect_hosts_t **hosts, char *message);

void eoe_args_free(eoe_args_t *args);

#endif
