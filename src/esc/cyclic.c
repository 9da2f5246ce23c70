/* SPDX-License-Identifier: MIT */
/* The effect of a controller on frames of process data, computed in advance. */
#include "esc/cyclic.h"

#include "esc/internal.h"
#include "esc/route.h"

enum { BUFFERS = 3 };

/* The overlap of an FMMU with a datagram. */
typedef struct overlap {
    uint16_t at, length;
    uint32_t physical;
} overlap_t;

bool ect_esc_steady(const ect_esc_t *esc)
{
    /* With nothing due, the other two times are none; they are apart in memory. */
    return esc->per_frame == 0 && esc->sii_command == 0 &&
           (esc->next_ns == UINT64_MAX || (esc->loops_revert_ns == UINT64_MAX && esc->pdi_ns == UINT64_MAX));
}

static bool is_buffered(const ect_esc_t *esc, unsigned int n)
{
    unsigned int mode = ect_esc_sm_registers(esc, n)[ECT_SM_CONTROL] & ECT_SM_CONTROL_MODE;
    return mode != ECT_SM_CONTROL_MAILBOX && esc->sm[n].length > 1 && esc->sm[n].start >= ECT_RAM;
}

/* @return the first address after all buffers of a SyncManager */
static uint32_t end_of(const ect_esc_t *esc, unsigned int n)
{
    return esc->sm[n].start + (uint32_t)esc->sm[n].length * (is_buffered(esc, n) ? (uint32_t)BUFFERS : 1u);
}

/* @return whether all buffers of an image are apart from those of the other SyncManagers */
static bool is_alone(const ect_esc_t *esc, unsigned int n)
{
    for (unsigned int m = 0; m < ECT_ESC_MAX_SM; m++) {
        if (m != n && esc->sm[m].length > 0 && esc->sm[m].start < end_of(esc, n) && esc->sm[n].start < end_of(esc, m))
            return false;
    }
    return end_of(esc, n) <= esc->memory_size;
}

/* @return whether no access to this SyncManager changes the content of a later frame */
static bool is_quiet(const ect_esc_t *esc, unsigned int n)
{
    const uint8_t *sm = ect_esc_sm_registers(esc, n);
    uint16_t events = ect_load_le16(esc->memory + ECT_REG_ECAT_EVENT);
    return (sm[ECT_SM_CONTROL] & (ECT_SM_CONTROL_ECAT_EVENT | ECT_SM_CONTROL_SEQUENTIAL)) == 0 &&
           (events & (uint32_t)ECT_ECAT_EVENT_SM0 << n) == 0 && (sm[ECT_SM_PDI_CONTROL] & ECT_SM_PDI_DISABLE) == 0;
}

/* @return the SyncManager whose image is exactly this range, accessed in its direction; ECT_ESC_MAX_SM: none */
static unsigned int find_image(const ect_esc_t *esc, const overlap_t *o, bool write)
{
    for (unsigned int n = 0; n < ECT_ESC_MAX_SM; n++) {
        if (esc->sm[n].length == 0 || o->physical != esc->sm[n].start || o->length != esc->sm[n].length)
            continue;
        unsigned int direction = ect_esc_sm_registers(esc, n)[ECT_SM_CONTROL] & ECT_SM_CONTROL_DIRECTION;
        bool fits = (direction == ECT_SM_CONTROL_ECAT_WRITES) == write;
        return fits && is_buffered(esc, n) && is_alone(esc, n) && is_quiet(esc, n) ? n : ECT_ESC_MAX_SM;
    }
    return ECT_ESC_MAX_SM;
}

const uint8_t *ect_esc_newest_image(const ect_esc_t *esc, unsigned int sm)
{
    unsigned int latest = (ect_esc_sm_registers(esc, sm)[ECT_SM_STATUS] & (unsigned int)ECT_SM_STATUS_BUFFER) >> 4;
    ECT_ASSERT(sm < ECT_ESC_MAX_SM);
    return latest < BUFFERS ? esc->memory + esc->sm[sm].start + (size_t)latest * esc->sm[sm].length : NULL;
}

/* Adds the newest image. @return false: none yet */
static bool add_piece(const ect_esc_t *esc, unsigned int n, const overlap_t *o, ect_esc_cyclic_t *effect)
{
    const uint8_t *from = ect_esc_newest_image(esc, n);
    if (!from)
        return false;
    ECT_ASSERT(effect->piece_count < ECT_ESC_MAX_FMMU);
    effect->pieces[effect->piece_count++] =
        (ect_esc_piece_t){.at = o->at, .length = o->length, .from = from, .sm = (uint8_t)n};
    return true;
}

static bool find_overlap(const uint8_t *fmmu, uint32_t logical, uint16_t length, overlap_t *o)
{
    uint64_t start = ect_load_le32(fmmu + ECT_FMMU_LOGICAL);
    uint64_t end = start + ect_load_le16(fmmu + ECT_FMMU_LENGTH);
    uint64_t frame_end = (uint64_t)logical + length;
    uint64_t first = start > logical ? start : logical;
    end = end < frame_end ? end : frame_end;
    if (first >= end)
        return false;
    *o = (overlap_t){.at = (uint16_t)(first - logical),
                     .length = (uint16_t)(end - first),
                     .physical = ect_load_le16(fmmu + ECT_FMMU_PHYSICAL) + (uint32_t)(first - start)};
    return true;
}

/* Maps one direction through all FMMUs. @param[in,out] any  set if an FMMU maps a part of the datagram */
static bool find_pieces(const ect_esc_t *esc, uint32_t logical, uint16_t length, bool write, ect_esc_cyclic_t *effect,
                        bool *any)
{
    unsigned int set = write ? esc->fmmu_writes : esc->fmmu_reads;
    overlap_t o;
    while (set != 0) {
        if (!find_overlap(ect_esc_fmmu_registers(esc, ect_esc_take(&set)), logical, length, &o))
            continue;
        unsigned int n = find_image(esc, &o, write);
        if (n == ECT_ESC_MAX_SM || (!write && !add_piece(esc, n, &o, effect)))
            return false;
        *any = true;
    }
    return true;
}

bool ect_esc_cyclic(const ect_esc_t *esc, uint8_t command, uint32_t logical, uint16_t length, ect_esc_cyclic_t *effect)
{
    const uint8_t *m = esc->memory;
    bool read = false, written = false;
    *effect = (ect_esc_cyclic_t){0};
    if (!esc->fmmus_whole || esc->sms_overlap || !esc->sii_valid || command < ECT_LRD || command > ECT_LRW ||
        (m[ECT_REG_WRITE_PROTECTION] | m[ECT_REG_ESC_WRITE_PROTECTION]) != 0 ||
        (esc->config.personality->features & ECT_FEATURE_NO_LRW) != 0)
        return false;
    if ((command != ECT_LWR && !find_pieces(esc, logical, length, false, effect, &read)) ||
        (command != ECT_LRD && !find_pieces(esc, logical, length, true, effect, &written)))
        return false;
    effect->gain = (read ? 1u : 0u) + (written ? command == ECT_LRW ? 2u : 1u : 0u);
    return true;
}

bool ect_esc_even_clock(const ect_esc_t *esc, uint64_t *offset_ns)
{
    const ect_esc_clock_t *c = &esc->clock;
    *offset_ns = c->local_ns - c->real_ns + esc->arrival.unit_ns + ect_load_le64(esc->memory + ECT_REG_DC_OFFSET) -
                 ect_load_le32(esc->memory + ECT_REG_DC_DELAY);
    return ect_esc_dc_present(esc) && c->drift_ppb == 0 && c->trim_ppb == 0 && c->slew_ppb == 0;
}
