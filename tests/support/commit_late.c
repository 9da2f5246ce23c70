/* SPDX-License-Identifier: MIT */
/*
 * The chip with another time of commit, for tests: a frame takes effect COMMIT_LATE_NS after its end, also if further
 * frames pass before. Linked with --wrap for the functions named __wrap_...; it does not belong to the core.
 */
#include "bus/chain/fast.h"
#include "esc/internal.h"
#include "esc/route.h"

void __real_ect_esc_end_of_frame(ect_esc_t *esc);
void __wrap_ect_esc_end_of_frame(ect_esc_t *esc);
void __real_ect_esc_sii_tick(ect_esc_t *esc);
void __wrap_ect_esc_sii_tick(ect_esc_t *esc);
ect_fast_result_t __wrap_ect_fast_pass(ect_fast_t *fast, uint8_t *frame, size_t length, uint64_t now_ns);

enum { MOST_CHIPS = 64 };

/* The oldest frame that has not taken effect in each chip; 0: there is none. */
static struct {
    const ect_esc_t *esc;
    uint64_t due_ns;
} chips[MOST_CHIPS];

static uint64_t *due_of(const ect_esc_t *esc)
{
    size_t i = 0;
    while (chips[i].esc && chips[i].esc != esc) {
        i++;
        ECT_ASSERT(i < MOST_CHIPS);
    }
    chips[i].esc = esc;
    return &chips[i].due_ns;
}

void __wrap_ect_esc_end_of_frame(ect_esc_t *esc)
{
    uint64_t *due_ns = due_of(esc);
    if (esc->per_frame == 0)
        return;
    if (*due_ns == 0)
        *due_ns = esc->now_ns + COMMIT_LATE_NS;
    ect_esc_expect(esc, *due_ns);
}

/* The first part of a tick, called again at its end. */
void __wrap_ect_esc_sii_tick(ect_esc_t *esc)
{
    uint64_t *due_ns = due_of(esc);
    if (*due_ns != 0 && esc->now_ns >= *due_ns) {
        *due_ns = 0;
        __real_ect_esc_end_of_frame(esc);
    } else if (*due_ns != 0) {
        ect_esc_expect(esc, *due_ns);
    }
    __real_ect_esc_sii_tick(esc);
}

/* The fast path assumes that no register changes between frames but by them. */
ect_fast_result_t __wrap_ect_fast_pass(ect_fast_t *fast, uint8_t *frame, size_t length, uint64_t now_ns)
{
    (void)fast;
    (void)frame;
    (void)length;
    (void)now_ns;
    return ECT_FAST_NOT_TAKEN;
}
