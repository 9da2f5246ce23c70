/* SPDX-License-Identifier: MIT */
/* Diagnosis history, 10F3h (ETG.1020 §16): a ring of messages with acknowledgement. */
#include <string.h>

#include "seams/standard.h"
#include "slave/internal.h"

enum {
    INDEX = 0x10F3,
    FIRST = 6, /* sub-index of the first message */
    LAST = FIRST + ECT_DIAGNOSIS_MESSAGES - 1,
    TIME_IS_LOCAL = 0x0010,
    TWO_PARAMETERS = 0x0200,
    PARAMETER_UNSIGNED16 = 0x0006,
    EMERGENCY_IN_CODE = 0xE800, /* low word of a diagnosis code whose high word is an emergency error code */
    DEVICE_SPECIFIC = 0xFF00,
};

static uint8_t after(uint8_t subindex)
{
    return subindex < FIRST || subindex >= LAST ? FIRST : (uint8_t)(subindex + 1);
}

static bool empty(const ect_diagnosis_t *d, uint8_t subindex)
{
    static const uint8_t nothing[ECT_DIAGNOSIS_BYTES];
    return memcmp(d->messages[subindex - FIRST], nothing, sizeof nothing) == 0;
}

static bool is_recorded(const ect_diagnosis_t *d, uint8_t type)
{
    static const uint16_t off[] = {ECT_DIAGNOSIS_NO_INFO, ECT_DIAGNOSIS_NO_WARNING, ECT_DIAGNOSIS_NO_ERROR};
    return type < 3 && (d->flags & off[type]) == 0;
}

static void emergency(ect_slave_t *s, uint32_t code, uint16_t text_id, uint8_t subindex)
{
    uint16_t error = (code & 0xFFFF) == EMERGENCY_IN_CODE ? (uint16_t)(code >> 16) : (uint16_t)DEVICE_SPECIFIC;
    uint8_t data[5] = {0};
    ect_store_le16(data, text_id);
    data[2] = subindex;
    ect_host_emergency(s, error, ((const ect_standard_t *)s->config.instance)->error_register, data);
}

/* Whether the slot that is used next holds a message that the master has not acknowledged. */
static bool full(const ect_diagnosis_t *d, uint8_t slot)
{
    return d->acknowledged != d->newest && !empty(d, slot) && (d->acknowledged == 0 || slot == after(d->acknowledged));
}

static void diagnose(void *slave, uint8_t type, uint32_t code, uint16_t text_id, const uint16_t parameters[2])
{
    ect_slave_t *s = slave;
    ect_diagnosis_t *d = ect_services_data(s, INDEX);
    if (!d || !is_recorded(d, type))
        return;
    uint8_t slot = after(d->newest);
    ECT_ASSERT(slot >= FIRST && slot <= LAST);
    if (full(d, slot)) {
        d->flags |= ECT_DIAGNOSIS_LOST;
        if ((d->flags & ECT_DIAGNOSIS_ACKNOWLEDGE) != 0)
            return;
    }
    if (slot == d->acknowledged) /* the acknowledged message is overwritten: the ones after it are unacknowledged */
        d->acknowledged = 0;
    uint8_t *m = d->messages[slot - FIRST];
    ect_store_le32(m, code);
    ect_store_le16(m + 4, (uint16_t)(type | TIME_IS_LOCAL | TWO_PARAMETERS));
    ect_store_le16(m + 6, text_id);
    ect_store_le64(m + 8, s->now_ns);
    ect_store_le16(m + 16, PARAMETER_UNSIGNED16);
    ect_store_le16(m + 18, parameters[0]);
    ect_store_le16(m + 20, PARAMETER_UNSIGNED16);
    ect_store_le16(m + 22, parameters[1]);
    d->newest = slot;
    d->available = 1;
    if ((d->flags & ECT_DIAGNOSIS_EMERGENCY) != 0)
        emergency(s, code, text_id, slot);
}

static void start(ect_slave_t *s)
{
    s->host.diagnose = diagnose;
}

/* 0, or the sub-index of an existing message. */
static bool may_acknowledge(const ect_diagnosis_t *d, uint8_t subindex)
{
    return subindex == 0 || (subindex >= FIRST && subindex <= LAST && !empty(d, subindex));
}

static ect_reason_t write_history(ect_slave_t *s, const ect_download_t *w)
{
    const ect_diagnosis_t *d = w->index == INDEX ? ect_services_data(s, INDEX) : NULL;
    if (!d)
        return ECT_OK;
    if (w->subindex == 5 && (ect_load_le16(w->data) & ~0x1Fu) != 0)
        return ECT_REASON_RANGE;
    return w->subindex != 3 || may_acknowledge(d, w->data[0]) ? ECT_OK : ECT_REASON_RANGE;
}

static ect_reason_t written_history(ect_slave_t *s, uint16_t index, uint8_t subindex, bool complete)
{
    ect_diagnosis_t *d = index == INDEX ? ect_services_data(s, INDEX) : NULL;
    if (!d || (subindex != 3 && !complete))
        return ECT_OK;
    if (d->acknowledged == 0) { /* 0 clears the history */
        memset(d->messages, 0, sizeof d->messages);
        d->newest = 0;
    }
    d->available = d->newest != d->acknowledged;
    d->flags &= (uint16_t)~ECT_DIAGNOSIS_LOST;
    return ECT_OK;
}

const ect_service_t ect_service_diagnosis = {.start = start, .write = write_history, .written = written_history};
