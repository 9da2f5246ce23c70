/* SPDX-License-Identifier: MIT */
/* The registers of FMMUs, and the summary derived from them: active FMMUs, and whether a transfer byte by byte is
 * possible. */
#include "esc/internal.h"

static bool is_active(const uint8_t *fmmu, unsigned int directions)
{
    return (fmmu[ECT_FMMU_ACTIVATE] & 1u) != 0 && (fmmu[ECT_FMMU_TYPE] & directions) != 0;
}

/* Whole bytes inside the address space, in one direction. */
static bool is_plain(const uint8_t *fmmu)
{
    return fmmu[ECT_FMMU_START_BIT] == 0 && fmmu[ECT_FMMU_STOP_BIT] == 7 && fmmu[ECT_FMMU_PHYSICAL_BIT] == 0 &&
           (fmmu[ECT_FMMU_TYPE] & (ECT_FMMU_TYPE_READ | ECT_FMMU_TYPE_WRITE)) !=
               (ECT_FMMU_TYPE_READ | ECT_FMMU_TYPE_WRITE) &&
           (uint32_t)ect_load_le16(fmmu + ECT_FMMU_PHYSICAL) + ect_load_le16(fmmu + ECT_FMMU_LENGTH) <=
               ECT_ESC_ADDRESS_SPACE;
}

static bool share_a_byte(const uint8_t *fmmu, const uint8_t *other)
{
    uint64_t first = ect_load_le32(fmmu + ECT_FMMU_LOGICAL);
    uint64_t others_first = ect_load_le32(other + ECT_FMMU_LOGICAL);
    return first < others_first + ect_load_le16(other + ECT_FMMU_LENGTH) &&
           others_first < first + ect_load_le16(fmmu + ECT_FMMU_LENGTH);
}

/* A read and a write may share bytes: reads replace data of the frame, and writes take the data that came. */
static void find_overlaps(ect_esc_t *esc)
{
    unsigned int active = (unsigned int)esc->fmmu_reads | esc->fmmu_writes;
    bool whole = true, apart = true, sorted = true;
    for (unsigned int n = 0; active >> n != 0; n++) {
        const uint8_t *fmmu = ect_esc_fmmu_registers(esc, n);
        whole &= (active >> n & 1u) == 0 || is_plain(fmmu);
        for (unsigned int m = n + 1; (active >> n & 1u) != 0 && active >> m != 0; m++) {
            const uint8_t *other = ect_esc_fmmu_registers(esc, m);
            bool shares = (active >> m & 1u) != 0 && share_a_byte(fmmu, other);
            apart &= !shares;
            sorted &= !shares || fmmu[ECT_FMMU_TYPE] != other[ECT_FMMU_TYPE];
        }
    }
    esc->fmmus_plain = whole && apart;
    esc->fmmus_whole = whole && sorted;
}

/* Determines which FMMUs a datagram must be compared with, and how. */
static void sort(ect_esc_t *esc)
{
    esc->fmmu_reads = esc->fmmu_writes = 0;
    for (unsigned int n = 0; n < esc->config.personality->fmmu_count; n++) {
        const uint8_t *fmmu = ect_esc_fmmu_registers(esc, n);
        esc->fmmu_reads |= (uint8_t)(is_active(fmmu, ECT_FMMU_TYPE_READ) ? 1u << n : 0u);
        esc->fmmu_writes |= (uint8_t)(is_active(fmmu, ECT_FMMU_TYPE_WRITE) ? 1u << n : 0u);
    }
    find_overlaps(esc);
}

static const uint8_t writable[ECT_FMMU_SIZE] = {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0x07, 0x07,
                                                0xFF, 0xFF, 0x07, 0x03, 0x01, 0x00, 0x00, 0x00};

static unsigned int end_of_registers(const ect_esc_t *esc)
{
    return ECT_REG_FMMU + ECT_FMMU_SIZE * (unsigned int)esc->config.personality->fmmu_count;
}

bool ect_esc_fmmu_accepts(const ect_esc_t *esc, uint16_t address, uint16_t length)
{
    unsigned int end = end_of_registers(esc);
    bool any = false;
    for (uint16_t i = 0; i < length && (unsigned int)address + i < end; i++)
        any |= writable[(unsigned int)(address + i) % ECT_FMMU_SIZE] != 0;
    return any;
}

bool ect_esc_fmmu_write_register(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    unsigned int end = end_of_registers(esc);
    bool any = false;
    esc->routing++;
    for (uint16_t i = 0; i < length && (unsigned int)address + i < end; i++) {
        uint8_t mask = writable[(unsigned int)(address + i) % ECT_FMMU_SIZE];
        esc->memory[address + i] = access->data[i] & mask;
        any |= mask != 0;
    }
    sort(esc);
    return any;
}
