/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A private network for twins and a master: new user, network and mount namespaces with one or two veth pairs.
 */
#ifndef ECT_BUS_NET_NETNS_H
#define ECT_BUS_NET_NETNS_H

#include "wire/linkage.h"

ECT_C_BEGIN

/** Limit of wires in a private network: one for each end of the chain. */
enum { ECT_NETNS_WIRES = 2 };

/** Names of the interfaces at the twins' ends of the wires. */
extern const char *const ect_netns_twin[ECT_NETNS_WIRES];

/** Room for a message of ::ect_netns_enter. */
enum { ECT_NETNS_MESSAGE = 768 };

/** Checks a name for the master's end of a wire. @return NULL: permitted; else the reason, a line for the user */
const char *ect_netns_unfit(const char *name);

/** Deficiencies of a usable private network. */
typedef enum ect_netns_lack {
    ECT_NETNS_OWN_SYSFS = 1,      /**< /sys/class/net still contains the interfaces outside */
    ECT_NETNS_USER_NAMESPACE = 2, /**< the process is root on the whole machine, not only in the namespace */
} ect_netns_lack_t;

/**
 * Moves the calling process into a new network namespace with veth pairs, all ends up, and the loopback interface; /sys
 * becomes that of the new network. Needs no rights where unprivileged user namespaces are allowed. Inside, the process
 * is root, with the right to open raw sockets on this network only. A process that was root before keeps root's access
 * to files and loses its rights on the machine, if a user namespace can be made.
 *
 * Context: before any thread is started.
 * @param masters       names of the master's ends; [1] NULL: one wire
 * @param[out] lacks    ORed ect_netns_lack_t
 * @param[out] message  on failure one line for the user, cause and cure; ECT_NETNS_MESSAGE bytes
 * @return 0; -1: the process may be in a half-made namespace and should end
 */
int ect_netns_enter(const char *const masters[ECT_NETNS_WIRES], unsigned int *lacks, char *message);

ECT_C_END

#endif
