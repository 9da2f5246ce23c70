/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Ends of a twin's network on the host: a TAP interface or a socket.
 */
#ifndef ECT_BUS_EOE_PLACE_H
#define ECT_BUS_EOE_PLACE_H

#include <stdbool.h>

#include "wire/linkage.h"

ECT_C_BEGIN

enum { ECT_PLACE_MESSAGE = 512, ECT_PLACE_NAME = 16 };

/** @return whether a text names a TAP: "tap" (the first free name) or "tapNAME" */
bool ect_place_is_tap(const char *text);

/** @return the path of "unix:PATH"; NULL: the text names no socket */
const char *ect_place_path(const char *text);

/**
 * Opens a TAP interface in the network of the calling process, creates it if it does not exist, and brings it up if the
 * capabilities permit. An interface that this function has created ends with its descriptor.
 * @param text          a name of ::ect_place_is_tap
 * @param[out] name     of the interface, ECT_PLACE_NAME bytes
 * @param[out] message  on failure one line for the user, ECT_PLACE_MESSAGE bytes
 * @return a descriptor that does not block: each read and each write is one frame; -1: see message
 */
int ect_place_tap(const char *text, char *name, char *message);

/**
 * Binds a SOCK_SEQPACKET socket to a path and listens: each message is one frame. The socket of a dead process is
 * replaced.
 * @param[out] message  on failure one line for the user, ECT_PLACE_MESSAGE bytes
 * @return a descriptor that does not block; -1: see message
 */
int ect_place_listen(const char *path, char *message);

ECT_C_END

#endif
