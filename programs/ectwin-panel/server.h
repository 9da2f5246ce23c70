/* SPDX-License-Identifier: MIT */
/** @file The server: pages over HTTP and WebSocket on one side, control sockets on the other, in one event loop. */
#ifndef ECTWIN_PANEL_SERVER_H
#define ECTWIN_PANEL_SERVER_H

#include <stdbool.h>

#include "request.h"

typedef struct server_options {
    const char *address; /**< numeric */
    unsigned int port;   /**< 0: any */
    bool view;           /**< pages may change nothing */
    char token[REQUEST_TOKEN];
} server_options_t;

/**
 * Serves until SIGINT or SIGTERM.
 * @param who    first words of messages
 * @param ready  called once with the port
 * @return whether it could listen; if not, the reason is printed
 */
bool server_run(const server_options_t *options, const char *who, void (*ready)(void *ctx, unsigned int port),
                void *ctx);

#endif
