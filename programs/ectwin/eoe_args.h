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

/** "[N:]PLACE" of --eoe, with the number or the name of a twin. */
typedef struct eoe_setting {
    size_t twin;      /**< from 1, set by ::eoe_args_join */
    const char *text; /**< the option, as given */
    const char *place;
} eoe_setting_t;

typedef struct eoe_args {
    eoe_setting_t *settings;
    size_t count;
    bool has_hosts;           /**< the command opens TAPs and sockets; false: it refuses them */
    ect_network_t **networks; /**< one a twin, NULL without EoE */
    size_t network_count;
} eoe_args_t;

/** Argp parser for the option; its input is an eoe_args_t. */
extern const struct argp eoe_argp;

enum { EOE_MESSAGE = ECT_PLACE_MESSAGE + 128 };

/** The first option that asks for a TAP or a socket; NULL: none. */
const char *eoe_args_host(const eoe_args_t *args);

/**
 * Puts a network behind each twin with EoE, before the chain is made.
 * @param names         of the twins; NULL: none
 * @param[out] message  on failure one line, EOE_MESSAGE bytes
 * @return whether it was done
 */
bool eoe_args_join(eoe_args_t *args, const ect_names_t *names, ect_twin_config_t *twins, size_t count, char *message);

/**
 * Opens the hosts that the options ask for, in the network of this moment.
 * @param[out] hosts    NULL: none is wanted, or failure
 * @param quiet         without the note that names each host
 * @param[out] message  on failure one line, EOE_MESSAGE bytes
 * @return whether it was done
 */
bool eoe_args_open(const eoe_args_t *args, const char *who, bool quiet, ect_hosts_t **hosts, char *message);

void eoe_args_free(eoe_args_t *args);

#endif
