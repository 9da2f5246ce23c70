/* SPDX-License-Identifier: MIT */
/*
 * SyncManagers: mailbox mode (one buffer, producer and consumer in turn) and buffered mode (three buffers, both sides
 * at any time). One rule applies to both: an access to the first byte opens the buffer for a side, an access to the
 * last byte closes it, with any accesses in between (data sheet I §8).
 */
#include "esc/internal.h"

enum { NO_BUFFER = 3 };

/* One SyncManager, looked up once for an access. Its control register cannot change while it is enabled. */
typedef struct area {
    ect_esc_t *esc;
    unsigned int n;
    ect_esc_sm_t *own;
    uint8_t *registers;
    uint8_t control;
} area_t;

static bool is_mailbox(uint8_t control)
{
    return (control & ECT_SM_CONTROL_MODE) == ECT_SM_CONTROL_MAILBOX;
}

static bool ecat_writes(uint8_t control)
{
    return (control & ECT_SM_CONTROL_DIRECTION) == ECT_SM_CONTROL_ECAT_WRITES;
}

static void find_overlaps(ect_esc_t *esc)
{
    esc->sms_overlap = false;
    for (unsigned int n = 0; n < ECT_ESC_MAX_SM; n++) {
        for (unsigned int m = n + 1; m < ECT_ESC_MAX_SM && esc->sm[n].length > 0; m++) {
            const ect_esc_sm_t *a = &esc->sm[n];
            const ect_esc_sm_t *b = &esc->sm[m];
            esc->sms_overlap |= b->length > 0 && (uint32_t)a->start < (uint32_t)b->start + b->length &&
                                (uint32_t)b->start < (uint32_t)a->start + a->length;
        }
    }
}

/* Its position is decoded once, because its registers cannot be written while it is enabled. */
static void decode(ect_esc_t *esc, unsigned int n)
{
    const uint8_t *sm = ect_esc_sm_registers(esc, n);
    uint16_t length = ect_load_le16(sm + ECT_SM_LENGTH);
    bool enabled = (sm[ECT_SM_ACTIVATE] & ECT_SM_ACTIVATE_ENABLE) != 0 && length > 0;
    esc->sm[n].start = enabled ? ect_load_le16(sm + ECT_SM_START) : 0;
    esc->sm[n].length = enabled ? length : 0;
    find_overlaps(esc);
}

static void forget_close(ect_esc_t *esc, unsigned int n)
{
    esc->closing = (uint8_t)(esc->closing & ~(1u << n));
}

void ect_esc_sm_reset(ect_esc_t *esc, unsigned int n)
{
    ECT_ASSERT(n < esc->config.personality->sm_count);
    uint8_t *sm = ect_esc_sm_registers(esc, n);
    esc->sm[n] = (ect_esc_sm_t){.write_buffer = 0, .read_buffer = NO_BUFFER};
    forget_close(esc, n);
    decode(esc, n);
    esc->routing++;
    sm[ECT_SM_STATUS] = ect_esc_sm_enabled(esc, n) && is_mailbox(sm[ECT_SM_CONTROL]) ? 0 : ECT_SM_STATUS_BUFFER;
    ect_esc_clear(esc, (uint32_t)ECT_EVENT_SM0 << n);
    ect_esc_clear_ecat(esc, (uint16_t)(ECT_ECAT_EVENT_SM0 << n));
}

/* Stores the local time of an event, so that a master can measure the reaction time of the other side. */
static inline void latch(const area_t *sm, uint8_t wanted, uint16_t time_register)
{
    if ((sm->registers[ECT_SM_ACTIVATE] & wanted) != 0 && ect_esc_has(sm->esc, ECT_UNIT_SM_TIMES))
        ect_store_le32(sm->esc->memory + time_register, (uint32_t)ect_esc_frame_time(sm->esc));
}

/* Signals the other side that `side` has closed the buffer. */
static inline void notify(const area_t *sm, ect_side_t side)
{
    if (side == ECT_SIDE_ECAT) {
        sm->esc->activity++;
        latch(sm, ECT_SM_ACTIVATE_LATCH_ECAT, ECT_REG_DC_SM_TIME_ECAT);
        if ((sm->control & ECT_SM_CONTROL_AL_EVENT) != 0)
            ect_esc_raise(sm->esc, (uint32_t)ECT_EVENT_SM0 << sm->n);
    } else {
        latch(sm, ECT_SM_ACTIVATE_LATCH_PDI, ECT_REG_DC_SM_TIME_PDI_CHANGE);
        if ((sm->control & ECT_SM_CONTROL_ECAT_EVENT) != 0)
            ect_esc_raise_ecat(sm->esc, (uint16_t)(ECT_ECAT_EVENT_SM0 << sm->n));
    }
}

/* Clears the event of `side`, which has started to use the buffer. */
static inline void quiet(const area_t *sm, ect_side_t side)
{
    if (side == ECT_SIDE_PDI) {
        latch(sm, ECT_SM_ACTIVATE_LATCH_PDI, ECT_REG_DC_SM_TIME_PDI_START);
        ect_esc_clear(sm->esc, (uint32_t)ECT_EVENT_SM0 << sm->n);
    } else {
        ect_esc_clear_ecat(sm->esc, (uint16_t)(ECT_ECAT_EVENT_SM0 << sm->n));
    }
}

static bool open_write(const area_t *sm, ect_side_t side)
{
    ECT_ASSERT(sm->own->write_buffer < NO_BUFFER);
    uint8_t status = sm->registers[ECT_SM_STATUS];
    if (is_mailbox(sm->control) && (status & ECT_SM_STATUS_FULL) != 0)
        return false;
    sm->registers[ECT_SM_STATUS] = (uint8_t)((status | ECT_SM_STATUS_WRITE_OPEN) & ~ECT_SM_STATUS_READ);
    quiet(sm, side);
    return true;
}

static bool open_read(const area_t *sm, ect_side_t side)
{
    uint8_t status = sm->registers[ECT_SM_STATUS];
    uint8_t latest = (uint8_t)((status & ECT_SM_STATUS_BUFFER) >> 4);
    if (is_mailbox(sm->control) ? (status & ECT_SM_STATUS_FULL) == 0 : latest == NO_BUFFER)
        return false;
    sm->own->read_buffer = latest;
    sm->registers[ECT_SM_STATUS] = (uint8_t)((status | ECT_SM_STATUS_READ_OPEN) & ~ECT_SM_STATUS_WRITTEN);
    quiet(sm, side);
    return true;
}

static uint8_t free_buffer(uint8_t latest, uint8_t reading)
{
    ECT_ASSERT(latest < NO_BUFFER && reading <= NO_BUFFER);
    uint8_t candidate = 0;
    while (candidate == latest || candidate == reading)
        candidate++;
    return candidate;
}

static void close_write(const area_t *sm, ect_side_t side)
{
    ECT_ASSERT(sm->own->write_buffer < NO_BUFFER);
    uint8_t status = (uint8_t)(sm->registers[ECT_SM_STATUS] & ~(ECT_SM_STATUS_WRITE_OPEN | ECT_SM_STATUS_VIOLATED));
    if (sm->own->violated) { /* the other side keeps the previous buffer */
        sm->registers[ECT_SM_STATUS] = status | ECT_SM_STATUS_VIOLATED;
        return;
    }
    if (is_mailbox(sm->control)) {
        status |= ECT_SM_STATUS_FULL;
    } else {
        uint8_t written = sm->own->write_buffer;
        status = (uint8_t)((status & ~ECT_SM_STATUS_BUFFER) | (written << 4));
        sm->own->write_buffer = free_buffer(written, sm->own->read_buffer);
    }
    sm->registers[ECT_SM_STATUS] = status | ECT_SM_STATUS_WRITTEN;
    if (side == ECT_SIDE_ECAT && (sm->control & ECT_SM_CONTROL_WATCHDOG) != 0)
        ect_esc_watchdog_trigger(sm->esc);
    notify(sm, side);
}

static void close_read(const area_t *sm, ect_side_t side)
{
    uint8_t status = (uint8_t)(sm->registers[ECT_SM_STATUS] & ~ECT_SM_STATUS_READ_OPEN);
    if (is_mailbox(sm->control))
        status = (uint8_t)(status & ~ECT_SM_STATUS_FULL);
    sm->registers[ECT_SM_STATUS] = status | ECT_SM_STATUS_READ;
    notify(sm, side);
}

/* A SyncManager of one byte has no buffers, nor has one over the registers of the digital outputs: they are plain
 * memory with events (data sheet I §8.5). */
static bool is_transparent(const ect_esc_sm_t *sm)
{
    return sm->length == 1 || sm->start < ECT_RAM;
}

static void close_transparent(const area_t *sm, ect_side_t side, bool write)
{
    unsigned int done = write ? ECT_SM_STATUS_WRITTEN : ECT_SM_STATUS_READ;
    sm->registers[ECT_SM_STATUS] &= (uint8_t)~(ECT_SM_STATUS_WRITTEN | ECT_SM_STATUS_READ);
    sm->registers[ECT_SM_STATUS] |= (uint8_t)done;
    if (write && side == ECT_SIDE_ECAT && (sm->control & ECT_SM_CONTROL_WATCHDOG) != 0)
        ect_esc_watchdog_trigger(sm->esc);
    quiet(sm, side);
    notify(sm, side);
}

/* The buffer changes hands when the frame has ended. */
static inline void postpone_close(const area_t *sm)
{
    sm->esc->closing = (uint8_t)(sm->esc->closing | 1u << sm->n);
    sm->esc->per_frame |= ECT_FRAME_COMMITS;
}

static bool access_transparent(const area_t *sm, const ect_access_t *access, uint16_t offset, uint16_t length)
{
    ect_esc_t *esc = sm->esc;
    uint32_t at = (uint32_t)sm->own->start + offset;
    ECT_ASSERT(at + length <= esc->memory_size);
    if (access->stage == ECT_STAGE_ASKS)
        return true;
    ect_esc_copy(access, esc->memory + at, 0, length);
    if (offset + length < sm->own->length)
        return true; /* an access to the last byte signals the other side */
    bool producer = (access->side == ECT_SIDE_ECAT) == ecat_writes(sm->control);
    if (producer != access->write)
        return true; /* a read against the direction has no effect */
    if (access->side == ECT_SIDE_ECAT && access->stage == ECT_STAGE_PASSING)
        postpone_close(sm);
    else
        close_transparent(sm, access->side, access->write);
    return true;
}

/* Address of a byte of the buffer: in the single buffer, or in the side's own one of three. */
static uint32_t buffer_address(const area_t *sm, bool write, uint16_t offset)
{
    uint32_t buffer = write ? sm->own->write_buffer : sm->own->read_buffer;
    ECT_ASSERT(is_mailbox(sm->control) || buffer < NO_BUFFER);
    uint32_t first = is_mailbox(sm->control) ? 0 : buffer * sm->own->length;
    return sm->own->start + first + offset;
}

/* A frame that accesses a buffer again after its last byte: a mailbox refuses, since it has changed hands. One of
 * three buffers is opened again, and changes hands when its last byte has been accessed again. */
static bool open_buffer(const area_t *sm, const ect_access_t *access)
{
    bool closing = access->side == ECT_SIDE_ECAT && (sm->esc->closing & 1u << sm->n) != 0;
    if (closing && is_mailbox(sm->control))
        return false;
    if (closing) {
        forget_close(sm->esc, sm->n);
        ect_esc_unlist(sm->esc, sm->n);
    }
    return access->write ? open_write(sm, access->side) : open_read(sm, access->side);
}

static void leave_buffer(const area_t *sm, const ect_access_t *access)
{
    sm->own->open[access->side] = false;
    if (access->side == ECT_SIDE_ECAT)
        postpone_close(sm);
    else if (access->write)
        close_write(sm, access->side);
    else
        close_read(sm, access->side);
}

/* Sequential mode: a buffer must be written from start to end; a byte out of order invalidates it until it is opened
 * again. */
static void follow_sequence(ect_esc_sm_t *own, uint16_t offset, uint16_t length)
{
    if (offset == 0)
        own->violated = false;
    else if (offset != own->next)
        own->violated = true;
    own->next = (uint16_t)(offset + length);
}

static bool is_sequential(const area_t *sm, const ect_access_t *access)
{
    return (sm->control & ECT_SM_CONTROL_SEQUENTIAL) != 0 && access->write && access->side == ECT_SIDE_ECAT &&
           (sm->esc->config.personality->features & ECT_FEATURE_SEQUENTIAL) != 0;
}

static void close_buffer(ect_esc_t *esc, unsigned int n)
{
    uint8_t *registers = ect_esc_sm_registers(esc, n);
    const area_t sm = {
        .esc = esc, .n = n, .own = &esc->sm[n], .registers = registers, .control = registers[ECT_SM_CONTROL]};
    ECT_ASSERT(ect_esc_sm_enabled(esc, n));
    bool writes = ecat_writes(sm.control);
    if (is_transparent(sm.own))
        close_transparent(&sm, ECT_SIDE_ECAT, writes);
    else if (writes)
        close_write(&sm, ECT_SIDE_ECAT);
    else
        close_read(&sm, ECT_SIDE_ECAT);
}

void ect_esc_sm_close(ect_esc_t *esc, unsigned int set)
{
    set &= esc->closing;
    esc->closing = (uint8_t)(esc->closing & ~set);
    while (set != 0)
        close_buffer(esc, ect_esc_take(&set));
}

bool ect_esc_sm_access(ect_esc_t *esc, unsigned int n, const ect_access_t *access, uint16_t offset, uint16_t length)
{
    uint8_t *registers = ect_esc_sm_registers(esc, n);
    const area_t sm = {
        .esc = esc, .n = n, .own = &esc->sm[n], .registers = registers, .control = registers[ECT_SM_CONTROL]};
    uint16_t size = sm.own->length;
    ECT_ASSERT(ect_esc_sm_enabled(esc, n) && length > 0 && offset + length <= size);
    if ((registers[ECT_SM_PDI_CONTROL] & ECT_SM_PDI_DISABLE) != 0)
        return false;
    if (is_transparent(sm.own))
        return access_transparent(&sm, access, offset, length);
    bool producer = (access->side == ECT_SIDE_ECAT) == ecat_writes(sm.control);
    if (producer != access->write)
        return false;
    if (offset == 0)
        sm.own->open[access->side] = open_buffer(&sm, access);
    if (!sm.own->open[access->side])
        return false;
    uint32_t at = buffer_address(&sm, access->write, offset);
    if (at + length > esc->memory_size)
        return false; /* one of the three buffers is beyond the RAM */
    if (is_sequential(&sm, access))
        follow_sequence(sm.own, offset, length);
    if (!access->unread || access->write)
        ect_esc_copy(access, esc->memory + at, 0, length);
    if (offset + length == size)
        leave_buffer(&sm, access);
    return true;
}

static bool ecat_may_write(unsigned int reg, bool enabled)
{
    return reg <= ECT_SM_ACTIVATE && reg != ECT_SM_STATUS && (reg == ECT_SM_ACTIVATE || !enabled);
}

bool ect_esc_sm_accepts(const ect_esc_t *esc, uint16_t address, uint16_t length)
{
    unsigned int first = (unsigned int)address - ECT_REG_SM;
    unsigned int end = ECT_SM_SIZE * (unsigned int)esc->config.personality->sm_count;
    for (unsigned int at = first; at < first + length && at < end; at++) {
        const uint8_t *sm = ect_esc_sm_registers(esc, at / ECT_SM_SIZE);
        if (ecat_may_write(at % ECT_SM_SIZE, (sm[ECT_SM_ACTIVATE] & ECT_SM_ACTIVATE_ENABLE) != 0))
            return true;
    }
    return false;
}

/* Writes one register byte of a SyncManager. @return whether it was accepted */
static bool write_byte(ect_esc_t *esc, unsigned int n, unsigned int reg, uint8_t value, ect_side_t side,
                       bool was_enabled)
{
    uint8_t *sm = ect_esc_sm_registers(esc, n);
    if (side == ECT_SIDE_PDI) {
        if (reg != ECT_SM_PDI_CONTROL)
            return false;
        sm[reg] = value & (ECT_SM_PDI_DISABLE | ECT_SM_PDI_REPEAT_ACK);
        if ((value & ECT_SM_PDI_DISABLE) != 0)
            ect_esc_sm_reset(esc, n);
        return true;
    }
    if (!ecat_may_write(reg, was_enabled))
        return false;
    sm[reg] = reg == ECT_SM_ACTIVATE ? value & 0xC3 : value;
    return true;
}

/* After a write to the activate register: restarts the SyncManager on a change of the enable bit, and always notifies
 * the PDI. */
static void activate_written(ect_esc_t *esc, unsigned int n, bool was_enabled)
{
    bool enabled = (ect_esc_sm_registers(esc, n)[ECT_SM_ACTIVATE] & ECT_SM_ACTIVATE_ENABLE) != 0;
    if (enabled != was_enabled)
        ect_esc_sm_reset(esc, n);
}

bool ect_esc_sm_write_register(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    bool any = false;
    uint16_t end = (uint16_t)(address + length);
    for (unsigned int n = 0; n < esc->config.personality->sm_count; n++) {
        uint8_t *sm = ect_esc_sm_registers(esc, n);
        uint16_t first = (uint16_t)(ECT_REG_SM + ECT_SM_SIZE * n);
        uint8_t activate = sm[ECT_SM_ACTIVATE];
        bool was_enabled = (activate & ECT_SM_ACTIVATE_ENABLE) != 0;
        for (unsigned int reg = 0; reg < ECT_SM_SIZE; reg++) {
            unsigned int at = first + reg;
            if (at >= address && at < end)
                any |= write_byte(esc, n, reg, access->data[at - address], access->side, was_enabled);
        }
        if (sm[ECT_SM_ACTIVATE] != activate) {
            activate_written(esc, n, was_enabled);
            esc->sm_changed = (uint8_t)(esc->sm_changed | (1u << n));
            ect_esc_raise(esc, ECT_EVENT_SM_CHANGED);
        }
    }
    return any;
}

/* The event is cleared when the PDI has read the activate register of every SyncManager that changed. */
void ect_esc_sm_read_register(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    if (access->side != ECT_SIDE_PDI || esc->sm_changed == 0)
        return;
    for (unsigned int n = 0; n < ECT_ESC_MAX_SM; n++) {
        unsigned int activate = ECT_REG_SM + ECT_SM_SIZE * n + ECT_SM_ACTIVATE;
        if (activate >= address && activate < (unsigned int)address + length)
            esc->sm_changed = (uint8_t)(esc->sm_changed & ~(1u << n));
    }
    if (esc->sm_changed == 0)
        ect_esc_clear(esc, ECT_EVENT_SM_CHANGED);
}
