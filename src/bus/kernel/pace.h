/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The pace: a bound on how far the replies in the kernel get ahead of devices that are reacting.
 *
 * A device reacts to outputs when its process runs. A master that sends its next frame immediately after the reply
 * leaves no time for this reaction, and hundreds of frames would read the same inputs. Therefore, while outputs change,
 * a frame whose distance from the previous one of its plan is shorter than any cycle time is left to the process, and
 * the master waits for the process.
 *
 * Freestanding, for user space and BPF.
 */
#ifndef ECT_BUS_KERNEL_PACE_H
#define ECT_BUS_KERNEL_PACE_H

#include <stdbool.h>
#include <stdint.h>

/**
 * Frames are close below ECT_PACE_CLOSE_NS, the shortest cycle time of masters; outputs count as changing for
 * ECT_PACE_REACTING_NS.
 */
enum { ECT_PACE_CLOSE_NS = 31250, ECT_PACE_REACTING_NS = 1000000000 };

/**
 * Decides about a frame with a plan.
 * @param[in,out] last_ns  arrival of the plan's last frame, and then of this one; owned by the side that has the turn
 * @param reacting         outputs have changed in the last ECT_PACE_REACTING_NS
 * @return true: leave the frame to the process, because the devices must run first
 */
static inline bool ect_pace_is_close(uint64_t *last_ns, uint64_t now_ns, bool reacting)
{
    const uint64_t distance_ns = now_ns - *last_ns;
    *last_ns = now_ns;
    return reacting && distance_ns < ECT_PACE_CLOSE_NS;
}

#endif
