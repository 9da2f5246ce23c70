/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The paths of the control sockets of running twins, for the twins and their clients.
 *
 * Each user has a folder, mode 0700: $XDG_RUNTIME_DIR/ectwin, or /tmp/ectwin-UID. The folder contains a socket of each
 * process, mode 0600: PID.sock, or PID-2.sock and so on if a live socket has this name (containers with a common folder
 * may have equal process ids); NAME.sock for a process with a name. Any user may create a folder in /tmp, so neither
 * side trusts a folder of another user.
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
    ECT_ENDPOINT_MESSAGE = ECT_ENDPOINT_PATH + 160, /**< room for a message of one line */
    ECT_ENDPOINT_PATIENCE_S = 5,                    /**< timeout of a client, seconds */
    ECT_ENDPOINT_REQUEST = 4096,                    /**< most bytes of a request, line feed included */
    ECT_ENDPOINT_VALUES = 128,                      /**< most signals that a request sets */
    ECT_ENDPOINT_NAME = 32,                         /**< room for a name, terminator included */
};

/** Writes the folder of this user's sockets. @param[out] path  ECT_ENDPOINT_PATH bytes @return 0, -1 (ENAMETOOLONG) */
int ect_endpoint_folder(char *path);

/**
 * Checks that a folder belongs to this user and that no other user may write to it.
 * @return 0 · -1 (errno; EPERM: the folder of another user, or open to others)
 */
int ect_endpoint_trust(const char *folder);

/**
 * Calls `found` with the path of each socket in a folder, dead ones included, until `found` returns false. Names that
 * begin with a dot are skipped. A missing folder counts as empty.
 */
void ect_endpoint_each(const char *folder, bool (*found)(void *ctx, const char *path), void *ctx);

/** Writes the path of the socket with a name, which need not exist. @return as ::ect_endpoint_folder */
int ect_endpoint_find(const char *name, char *path);

/** Checks a name. @return NULL: valid; else the reason, a line for the user */
const char *ect_endpoint_unfit(const char *name);

/**
 * Opens a listening socket in the folder, which is created if necessary. Dead sockets of this user in the folder are
 * removed. The socket already listens when its file appears.
 * @param name          ::ect_endpoint_unfit accepts it; NULL: the process id
 * @param[out] path     of the socket; ECT_ENDPOINT_PATH bytes
 * @param[out] message  on failure one line for the user; ECT_ENDPOINT_MESSAGE bytes
 * @return the descriptor, non-blocking; -1 (errno; EADDRINUSE: a live process of this user has that name)
 */
int ect_endpoint_listen(const char *name, char *path, char *message);

/** @return the inode of a socket's file, for ::ect_endpoint_close; 0: no such socket */
ino_t ect_endpoint_identity(const char *path);
/**
 * Closes a listening socket, and removes its file if the file still has this inode. (A process that has dropped its
 * rights cannot connect for a check.)
 * @param identity  ::ect_endpoint_identity after ::ect_endpoint_listen
 */
void ect_endpoint_close(int fd, const char *path, ino_t identity);

/**
 * Connects to a socket; the path may be longer than the address of a socket.
 * @param[out] owner  the user of the listening process
 * @return the descriptor, blocking, with a timeout of ECT_ENDPOINT_PATIENCE_S for writes; -1 (errno): ECONNREFUSED no
 *         process listens · EAGAIN no process has accepted in time
 */
int ect_endpoint_connect(const char *path, uid_t *owner);

/** As ::ect_endpoint_connect, without waiting: the descriptor is non-blocking, and EAGAIN is returned at once. */
int ect_endpoint_connect_now(const char *path, uid_t *owner);

/** Removes a socket of this user if no process listens. Other files are kept. */
void ect_endpoint_clear(const char *path);

ECT_C_END

#endif
