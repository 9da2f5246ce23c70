/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Replies in the kernel: a program at the XDP hook of an interface that carries out plans (bus/kernel/plan.h).
 *
 * The process owns the chain while its loop runs, and gives the turn to the kernel before it sleeps
 * (bus/kernel/turn.h). While the process sleeps, the kernel replies to a frame with a plan and holds the frame for the
 * process. The process wakes up, takes the turn, and first passes the held frames through the chain, with their times
 * of arrival. A frame without a plan, a frame that arrives while the process has the turn, and every frame after such a
 * frame go to the process's socket, in their order. The process counts these frames (::ect_kernel_got).
 *
 * Context: the thread of the loop. No call blocks, except ::ect_kernel_take for a frame in the kernel, about 1 µs.
 */
#ifndef ECT_BUS_KERNEL_KERNEL_H
#define ECT_BUS_KERNEL_KERNEL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus/kernel/plan.h"
#include "bus/kernel/shared.h"
#include "wire/linkage.h"

ECT_C_BEGIN

typedef struct ect_kernel ect_kernel_t;

/** Room for a message of this header. */
enum { ECT_KERNEL_MESSAGE = 320 };

/**
 * Loads the program, which replies to no frame until it is attached. Needs CAP_BPF and CAP_NET_ADMIN, or root.
 * @param[out] message  on failure one line, cause and cure; ECT_KERNEL_MESSAGE bytes
 * @return NULL: a right, a feature of the kernel or a part of this build is missing
 */
ect_kernel_t *ect_kernel_load(char *message);

/**
 * Attaches the program to an interface, until ::ect_kernel_close or the end of the process. Needs CAP_NET_ADMIN in the
 * interface's network namespace. The hook is the driver's, if the driver has one and leaves VLAN tags in frames; else
 * the generic hook.
 * @param index  of the interface
 * @return 0; -1: `message` has the reason
 */
int ect_kernel_attach(ect_kernel_t *kernel, unsigned int index, char *message);

/** @return the hook that the program is attached to: "native", in the driver, or "generic"; NULL: not attached. */
const char *ect_kernel_hook(const ect_kernel_t *kernel);

/** Detaches and unloads the program. Due before the chain is freed. NULL: no effect */
void ect_kernel_close(ect_kernel_t *kernel);

/** @return a descriptor, readable when the kernel has replied to a frame; valid until ::ect_kernel_close. */
int ect_kernel_fd(const ect_kernel_t *kernel);

/** Passes a frame of the socket to the planner, before the frame passes the chain (::ect_planner_see). */
void ect_kernel_see(ect_kernel_t *kernel, const uint8_t *frame, size_t length);

/** Counts a frame that the socket has returned, even if the chain does not get it. */
void ect_kernel_got(ect_kernel_t *kernel);

/**
 * Makes plans for the chain, the same in each call, and gives the turn to the kernel. Due before the process sleeps,
 * after ::ect_chain_poll; the chain must not be called until ::ect_kernel_take. From the first call on, the kernel is
 * an observer of the chain (ECT_CHAIN_PLANS). The process keeps the turn if no plan exists, or while frames are on
 * their way to the socket; a frame that has not arrived after 20 ms counts as lost.
 * @return the number of plans
 */
unsigned int ect_kernel_give(ect_kernel_t *kernel, ect_chain_t *chain, uint64_t now_ns);

/** Takes the turn and makes plans void. Due before the chain is called. No effect with the turn. */
void ect_kernel_take(ect_kernel_t *kernel);

/**
 * Called with the turn.
 * @return the next frame that the kernel holds, in the order of arrival, which the caller may change until the next
 * call; NULL: none
 */
ect_held_t *ect_kernel_next(ect_kernel_t *kernel);

/**
 * Runs the program for a frame without an interface (BPF_PROG_TEST_RUN): for tests.
 * @param[in,out] frame  at most ECT_PLAN_FRAME bytes; changed as on the wire
 * @return true: `frame` is the reply; false: the frame is left to the process
 */
bool ect_kernel_try(ect_kernel_t *kernel, uint8_t *frame, size_t length);

ECT_C_END

#endif
