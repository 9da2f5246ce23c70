/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Where the control sockets of running twins are, for those who open them and those who look for them.
 *
 * A folder for each user, mode 0700: $XDG_RUNTIME_DIR/ectwin, or /tmp/ectwin-UID. In it a socket a process, mode 0600,
 * PID.sock; where that is taken by a live one (containers that share the folder have equal process ids) PID-2.sock and
 * so on. Anybody may make a folder in /tmp: neither side trusts one that is not its user's own.
 */
#ifndef ECT_BUS_CONTROL_ENDPOINT_H
#define ECT_BUS_CONTROL_ENDPOINT_H

#include <stdbool.h>
#include <stddef.h>
#include <sys/types.h>

#include "wire/linkage.h"

ECT_C_BEGIN

enum {
    ECT_ENDPOINT_PATH = 1024,                       /**< room for a path, terminator included */
    ECT_ENDPOINT_MESSAGE = ECT_ENDPOINT_PATH + 160, /**< for a message of one line */
    ECT_ENDPOINT_PATIENCE_S = 5,                    /**< how long to wait for a twin that does not act */
    ECT_ENDPOINT_REQUEST = 4096,                    /**< bytes of a request, its line feed included */
    ECT_ENDPOINT_VALUES = 128,                      /**< signals that one request may set */
};

/** Writes the folder of this user's sockets. @param[out] path  ECT_ENDPOINT_PATH bytes @return 0, -1 (ENAMETOOLONG) */
int ect_endpoint_folder(char *path);

/**
 * Whether a folder is one to look for sockets in: it belongs to this user and nobody else may write to it.
 * @return 0 · -1: EPERM it is somebody else's or open to others; another errno: it cannot be looked at
 */
int ect_endpoint_trust(const char *folder);

/**
 * Makes the folder if need be, and a socket in it that listens. Dead sockets of this user in the folder are removed.
 * @param[out] path     of the socket; ECT_ENDPOINT_PATH bytes
 * @param[out] message  on failure one line for the user; ECT_ENDPOINT_MESSAGE bytes
 * @return the descriptor, non-blocking; -1
 */
int ect_endpoint_listen(char *path, char *message);

/** What the file of a socket is on its disk, for ::ect_endpoint_close. @return 0: there is none */
ino_t ect_endpoint_identity(const char *path);
/**
 * Closes a socket that listens, and removes its name if that is still its own: a process that has given up its rights
 * may not connect to see who listens there.
 * @param identity  of its file, when it was new
 */
void ect_endpoint_close(int fd, const char *path, ino_t identity);

/**
 * Connects to a socket; paths longer than an address of a socket are fine.
 * @param[out] owner  the user who listens there
 * @return the descriptor, blocking, writes to it give up after ECT_ENDPOINT_PATIENCE_S; -1 (errno): ECONNREFUSED nobody
 *         listens there any more · EAGAIN nobody has accepted for that long
 */
int ect_endpoint_connect(const char *path, uid_t *owner);

/** Removes a socket of this user at which nobody listens any more. Anything else stays. */
void ect_endpoint_clear(const char *path);

ECT_C_END

#endif
