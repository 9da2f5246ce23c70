/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The control socket of a running chain: signals are read, set and watched from outside.
 *
 * A Unix stream socket, one a process, mode 0600, in $XDG_RUNTIME_DIR/ectwin or /tmp/ectwin-UID (mode 0700), named
 * after the process. A request is a line of JSON, an answer one or more:
 *
 *   {"op":"get","pattern":"ru1.*"}          {"slave":1,"name":"ru1.on","value":"1"} ... {"ok":true}
 *   {"op":"list","pattern":"*"}             the same with "range", "access" and "meaning"
 *   {"op":"set","name":"ru1.on","value":"1"}    {"ok":true} or {"ok":false,"message":"..."}
 *   {"op":"watch","pattern":"bu.*"}         each value once, then one line a change, until the client closes; with
 * "time", seconds of the twin's clock. At most one a signal in 10 ms, with "every":true after each poll of the devices
 *
 * "slave" chooses one of the chain, from 1 (default 1; 0 in get, list and watch: all). Values are text.
 * Context: the thread of the runner. What a client does not read yet waits, up to 2 MB; then it is dropped. The bus
 * never waits for one.
 */
#ifndef ECT_BUS_CONTROL_H
#define ECT_BUS_CONTROL_H

#include <poll.h>
#include <stddef.h>
#include <stdint.h>

#include "bus/chain.h"

/** Descriptors that a control socket may have open: itself and its clients. */
enum {
    ECT_CONTROL_CLIENTS = 16,
    ECT_CONTROL_FDS = ECT_CONTROL_CLIENTS + 1,
    ECT_CONTROL_PATH = 108,
    ECT_CONTROL_MESSAGE = 256
};

typedef struct ect_control ect_control_t;

/** Writes the directory of the sockets for this user. @param[out] path  ECT_CONTROL_PATH bytes @return 0, -1 too long
 */
int ect_control_directory(char *path);

/**
 * Opens the socket. @param[out] message  on failure one line for the user; ECT_CONTROL_MESSAGE bytes
 * @return the socket, to be closed with ::ect_control_close, or NULL
 */
ect_control_t *ect_control_open(char *message);
void ect_control_close(ect_control_t *control);
const char *ect_control_path(const ect_control_t *control);

/** What to wait for. @param[out] fds  room for ECT_CONTROL_FDS @return how many were filled */
size_t ect_control_fds(const ect_control_t *control, struct pollfd *fds);
/** Serves what `fds` (as filled above, waited for) report. */
void ect_control_serve(ect_control_t *control, ect_chain_t *chain, const struct pollfd *fds, size_t count,
                       uint64_t now_ns);
/** Tells the watchers what has changed. @return when to call it again, ECT_NEVER without watchers */
uint64_t ect_control_report(ect_control_t *control, uint64_t now_ns);

#endif
