/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A private network for a twin and a master: a user and network namespace of this process's own, with a veth pair.
 */
#ifndef ECT_BUS_NETNS_H
#define ECT_BUS_NETNS_H

/** The two ends, as they are called inside. */
#define ECT_NETNS_TWIN   "ectwin0"
#define ECT_NETNS_MASTER "ecat0"

/** Room for a message of ::ect_netns_enter. */
enum { ECT_NETNS_MESSAGE = 768 };

/**
 * Moves the calling process into a new network namespace with a veth pair, both ends up, and the loopback interface.
 * Needs no rights where unprivileged user namespaces are allowed; as root it needs none either, given CAP_SYS_ADMIN.
 * Inside a user namespace the process sees itself as root, and has the rights to open raw sockets, on this network
 * only. Call it before any thread is started.
 * @param[out] message  on failure one line for the user: what forbids it and what to do; ECT_NETNS_MESSAGE bytes
 * @return 0, or -1; the process may then be in a half-made namespace and should end.
 */
int ect_netns_enter(char *message);

#endif
