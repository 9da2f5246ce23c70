/* SPDX-License-Identifier: MIT */
/* One access to the address space, split into registers, SyncManagers and plain RAM. */
#include "esc/internal.h"

/* The enabled SyncManager that contains `address`, or the start of the next one above it; -1: none contains it. */
static int find_sm(const ect_esc_t *esc, uint32_t address, uint32_t *limit)
{
    for (unsigned int n = 0; n < esc->config.personality->sm_count; n++) {
        const ect_esc_sm_t *sm = &esc->sm[n];
        if (address - sm->start < sm->length) {
            uint32_t sm_end = (uint32_t)sm->start + sm->length;
            *limit = sm_end < *limit ? sm_end : *limit; /* one with a lower number may begin inside */
            return (int)n;
        }
        if (sm->start > address && sm->start < *limit)
            *limit = sm->start;
    }
    return -1;
}

/* First address that may belong to a SyncManager: the RAM, or the registers of the digital outputs if one covers them.
 */
static uint16_t first_managed(const ect_esc_t *esc)
{
    for (unsigned int n = 0; n < esc->config.personality->sm_count; n++) {
        uint16_t start = esc->sm[n].start;
        if (start >= ECT_REG_DIGITAL_OUTPUT && start < ECT_RAM)
            return ECT_REG_DIGITAL_OUTPUT;
    }
    return ECT_RAM;
}

/* Splits an access: SyncManagers handle their parts, the rest is plain memory or registers. */
static bool managed_access(ect_esc_t *esc, const ect_access_t *access, uint32_t address, uint16_t length)
{
    if (!esc->sii_valid)
        return false;
    bool any = false;
    uint32_t end = address + length;
    ECT_ASSERT(address >= ECT_REG_DIGITAL_OUTPUT);
    if (end > esc->memory_size)
        end = esc->memory_size;
    uint32_t at = address;
    while (at < end) {
        uint32_t limit = end;
        if (at < ECT_RAM && limit > ECT_RAM)
            limit = ECT_RAM;
        int n = find_sm(esc, at, &limit);
        uint16_t part = (uint16_t)(limit - at);
        ect_access_t piece = ect_esc_slice(access, (uint16_t)(at - address));
        if (n < 0 && at < ECT_RAM) {
            any |= ect_esc_register_access(esc, &piece, (uint16_t)at, part);
        } else if (n < 0) {
            ect_esc_copy(&piece, esc->memory + at, 0, part);
            any = true;
        } else {
            any |= ect_esc_sm_access(esc, (unsigned int)n, &piece, (uint16_t)(at - esc->sm[n].start), part);
        }
        at = limit;
    }
    return any;
}

static bool open_access(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    bool any = false;
    uint16_t in_registers = 0;
    uint32_t end = (uint32_t)address + length;
    uint16_t first = address < ECT_RAM && end > ECT_REG_DIGITAL_OUTPUT ? first_managed(esc) : ECT_RAM;
    if (address < first) {
        in_registers = (uint16_t)(first - address);
        if (in_registers > length)
            in_registers = length;
        any = ect_esc_register_access(esc, access, address, in_registers);
    }
    if (length > in_registers) {
        ect_access_t rest = ect_esc_slice(access, in_registers);
        any |= managed_access(esc, &rest, (uint32_t)address + in_registers, (uint16_t)(length - in_registers));
    }
    return any;
}

static bool asks_registers(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    ect_access_t question = *access;
    question.stage = ECT_STAGE_ASKS;
    return open_access(esc, &question, address, length);
}

/* Registers change at the end of the frame, if they accept the write when the datagram passes; RAM changes at once. If
 * more is written than a frame of physical addresses can contain, the first part takes effect earlier. */
static bool passing_write(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    uint16_t in_registers = 0;
    bool any = false;
    if (address < ECT_REG_USER_RAM) {
        in_registers = (uint16_t)(ECT_REG_USER_RAM - address);
        in_registers = in_registers < length ? in_registers : length;
        any = asks_registers(esc, access, address, in_registers);
    }
    if (any && !ect_esc_postpone_write(esc, access, address, in_registers)) {
        ect_esc_commit(esc);
        any = ect_esc_postpone_write(esc, access, address, in_registers);
        ECT_ASSERT(any);
    }
    if (length > in_registers) {
        ect_access_t rest = ect_esc_slice(access, in_registers);
        any |= open_access(esc, &rest, (uint16_t)(address + in_registers), (uint16_t)(length - in_registers));
    }
    return any;
}

/* Applies write protection: takes write enables, then passes the part from the first unprotected address on. */
static bool protected_write(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    bool any = ect_esc_unlock(esc, address, length);
    uint32_t first = ect_esc_first_writable(esc);
    if (first >= (uint32_t)address + length)
        return any;
    uint16_t skipped = (uint16_t)(first > address ? first - address : 0);
    ect_access_t rest = ect_esc_slice(access, skipped);
    return passing_write(esc, &rest, (uint16_t)(address + skipped), (uint16_t)(length - skipped)) || any;
}

bool ect_esc_any_access(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    if (ect_esc_guards(esc, access))
        return protected_write(esc, access, address, length);
    if (access->write && access->side == ECT_SIDE_ECAT)
        return passing_write(esc, access, address, length);
    return open_access(esc, access, address, length);
}

void ect_esc_commit_writes(ect_esc_t *esc)
{
    ect_postponed_t next;
    uint16_t at = 0;
    while (ect_esc_next_postponed(esc, &at, &next)) {
        if (next.length == 0)
            ect_esc_sm_close(esc, next.address);
        else
            (void)open_access(esc, &next.access, next.address, next.length);
    }
    ect_esc_lock_al_control(esc);
    esc->postponed_length = 0;
    esc->listed = 0;
}
