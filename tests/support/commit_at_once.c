/* SPDX-License-Identifier: MIT */
/*
 * The chip with another time of commit, for tests: everything takes effect while its datagram passes. Linked with
 * --wrap for the functions named __wrap_...; it does not belong to the core.
 */
#include "bus/chain/fast.h"
#include "esc/internal.h"

bool __real_ect_esc_postpone_write(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);
bool __wrap_ect_esc_postpone_write(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length);
bool __real_ect_esc_sm_access(ect_esc_t *esc, unsigned int n, const ect_access_t *access, uint16_t offset,
                              uint16_t length);
bool __wrap_ect_esc_sm_access(ect_esc_t *esc, unsigned int n, const ect_access_t *access, uint16_t offset,
                              uint16_t length);
ect_fast_result_t __wrap_ect_fast_pass(ect_fast_t *fast, uint8_t *frame, size_t length, uint64_t now_ns);

bool __wrap_ect_esc_postpone_write(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    if (!__real_ect_esc_postpone_write(esc, access, address, length))
        return false;
    ect_esc_commit(esc);
    return true;
}

bool __wrap_ect_esc_sm_access(ect_esc_t *esc, unsigned int n, const ect_access_t *access, uint16_t offset,
                              uint16_t length)
{
    bool done = __real_ect_esc_sm_access(esc, n, access, offset, length);
    if (esc->closing != 0)
        ect_esc_commit(esc);
    return done;
}

/* The fast path assumes that no register changes within a frame. */
ect_fast_result_t __wrap_ect_fast_pass(ect_fast_t *fast, uint8_t *frame, size_t length, uint64_t now_ns)
{
    (void)fast;
    (void)frame;
    (void)length;
    (void)now_ns;
    return ECT_FAST_NOT_TAKEN;
}
