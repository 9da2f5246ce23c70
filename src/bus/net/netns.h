/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A private network for twins and a master: user, network and mount namespaces of this process's own, with one veth
 * pair or two.
 */
#ifndef ECT_BUS_NET_NETNS_H
#define ECT_BUS_NET_NETNS_H

#include "wire/linkage.h"

ECT_C_BEGIN

/** Wires that a private network may have: the chain's two ends. */
enum { ECT_NETNS_WIRES = 2 };

/** What the twins' end of each wire is called. */
extern const char *const ect_netns_twin[ECT_NETNS_WIRES];

/** Room for a message of ::ect_netns_enter. */
enum { ECT_NETNS_MESSAGE = 768 };

/** @return why this cannot be the name of a master's end, a line for the user; NULL: it can */
const char *ect_netns_unfit(const char *name);

/** What the private network lacks, though it can be used. */
typedef enum ect_netns_lack {
    ECT_NETNS_OWN_SYSFS = 1,      /**< /sys/class/net still shows the interfaces outside */
    ECT_NETNS_USER_NAMESPACE = 2, /**< the process is root on the whole machine, not only in here */
} ect_netns_lack_t;

/**
 * Moves the calling process into a new network namespace with veth pairs, all ends up, and the loopback interface; /sys
 * becomes that of the new network. Needs no rights where unprivileged user namespaces are allowed. Inside, the process
 * sees itself as root, with the rights to open raw sockets on this network only. A process that is root already keeps
 * root's way with files but loses its rights over the machine, if a user namespace can be made. Call it before any
 * thread is started.
 * @param masters       names of the master's ends; [1] NULL: one wire
 * @param[out] lacks    ORed ect_netns_lack_t
 * @param[out] message  on failure one line for the user: what forbids it and what to do; ECT_NETNS_MESSAGE bytes
 * @return 0, or -1; the process may then be in a half-made namespace and should end.
 */
int ect_netns_enter(const char *const masters[ECT_NETNS_WIRES], unsigned int *lacks, char *message);

ECT_C_END

#endif
