/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Decisions on what a browser sends: Host, Origin, token, paths, requests. Pure functions.
 *
 * A page of another site can send requests to this server, and by DNS rebinding under a name of its own that leads to
 * this machine. Its Host then is that name, so only numeric addresses and "localhost" are taken; a numeric address
 * needs no DNS.
 */
#ifndef ECTWIN_PANEL_REQUEST_H
#define ECTWIN_PANEL_REQUEST_H

#include <cjson/cJSON.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    REQUEST_TOKEN = 33,  /**< room for a token, terminator included */
    REQUEST_HOST = 64,   /**< room for a Host that is taken */
    REQUEST_ORIGIN = 80, /**< room for an Origin that is taken */
    REQUEST_TEXT = 4096, /**< most bytes of a message of a page */
    REQUEST_LINE = 3072, /**< most bytes of a request that is passed on; the control protocol takes 4095 */
};

/** @return whether a Host header is a numeric address or "localhost", with this port (80 may be left out) */
bool request_host_is_ours(const char *host, unsigned int port);

/** @return whether an Origin header is that of the pages at this Host */
bool request_origin_is_ours(const char *origin, const char *host);

/** @return whether the token is right; the time does not depend on the place of the first difference */
bool request_token_is_right(const char *given, const char *token);

/** Writes 128 bits as a token. */
void request_write_token(const uint8_t bits[16], char token[REQUEST_TOKEN]);

/** @return whether an address is one of this machine alone (127.0.0.0/8 or ::1) */
bool request_is_loopback(const char *address);

/** @return whether an address is numeric, of IPv4 or IPv6 */
bool request_is_numeric(const char *address);

/**
 * Checks a request of a page that is to be passed on to a bus.
 * @param view  nothing may be changed
 * @return NULL: it is passed on; else the reason of the refusal, one line for the user
 */
const char *request_refused(const cJSON *request, bool view);

#endif
