/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The pace: a bound on how far the replies in the kernel get ahead of devices that are reacting.
 *
 * A device reacts to outputs when its process runs, and a master that sends its next frame as soon as it has the reply
 * leaves no pause for that: hundreds of frames would show the same inputs. So while outputs change, a frame that
 * follows the previous one of its plan more closely than in any cycle is left to the process, for which the master then
 * waits.
 *
 * Freestanding, for user space and BPF.
 */
#ifndef ECT_BUS_KERNEL_PACE_H
#define ECT_BUS_KERNEL_PACE_H

#include <stdbool.h>
#include <stdint.h>

/** Frames are close below this distance, the shortest cycle time of masters; outputs count as changing this long. */
enum { ECT_PACE_CLOSE_NS = 31250, ECT_PACE_REACTING_NS = 1000000000 };

/**
 * Decides about a frame with a plan.
 * @param[in,out] last_ns  arrival of the plan's last frame, and then of this one; owned by the side that has the turn
 * @param reacting         outputs have changed in the last ECT_PACE_REACTING_NS
 * @return whether the devices have to run first: leave the frame to the process
 */
static inline bool ect_pace_is_close(uint64_t *last_ns, uint64_t now_ns, bool reacting)
{
    const uint64_t distance_ns = now_ns - *last_ns;
    *last_ns = now_ns;
    return reacting && distance_ns < ECT_PACE_CLOSE_NS;
}

#endif
