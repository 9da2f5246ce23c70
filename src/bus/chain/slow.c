/* SPDX-License-Identifier: MIT */
#include "bus/chain/slow.h"

#include <string.h>

#include "seams/random.h"
#include "slave/slave.h"
#include "wire/assert.h"

/* A write in the queue: time, address, length, data. */
enum { DUE = 0, ADDRESS = 8, LENGTH = 10, DATA = 12 };

static uint64_t draw(ect_slow_t *slow, const ect_slow_range_t *span)
{
    uint64_t range = span->max_ns - span->min_ns + 1;
    uint64_t high = ect_random_next(&slow->random);
    ECT_ASSERT(span->max_ns >= span->min_ns);
    return span->min_ns + (high << 32 | ect_random_next(&slow->random)) % range;
}

void ect_slow_init(ect_slow_t *slow, const ect_slow_config_t *config, ect_esc_t *esc, uint64_t now_ns)
{
    const ect_slow_config_t own = *config; /* `config` may point into this instance */
    const ect_esc_arrival_t arrival = slow->arrival;
    const uint32_t random = slow->esc ? slow->random : own.seed;
    memset(slow, 0, offsetof(ect_slow_t, queue));
    slow->config = own;
    slow->esc = esc;
    slow->arrival = arrival;
    slow->random = random;
    slow->now_ns = slow->busy_ns = now_ns;
}

/* --- writes on their way ------------------------------------------------------------------------------------------ */

static uint64_t next_due(const ect_slow_t *slow)
{
    return slow->first < slow->used ? ect_load_le64(slow->queue + slow->first + DUE) : ECT_NEVER;
}

static uint8_t *next_write(ect_slow_t *slow)
{
    uint8_t *entry = slow->queue + slow->first;
    slow->first = (uint16_t)(slow->first + DATA + ect_load_le16(entry + LENGTH));
    ECT_ASSERT(slow->first <= slow->used);
    return entry;
}

static void apply(ect_slow_t *slow, uint64_t until_ns)
{
    while (slow->first < slow->used && next_due(slow) <= until_ns) {
        const uint8_t *entry = next_write(slow);
        (void)ect_esc_pdi_write(slow->esc, ect_load_le16(entry + ADDRESS), entry + DATA, ect_load_le16(entry + LENGTH));
    }
    if (slow->first == slow->used)
        slow->first = slow->used = 0;
}

/* @return whether a buffer of process data begins at this address */
static bool is_process_data(const ect_esc_t *esc, uint16_t address)
{
    for (const uint8_t *sm = esc->memory + ECT_REG_SM; sm < esc->memory + ECT_REG_SM + ECT_SM_SIZE * ECT_ESC_MAX_SM;
         sm += ECT_SM_SIZE) {
        if ((sm[ECT_SM_ACTIVATE] & ECT_SM_ACTIVATE_ENABLE) != 0 && ect_load_le16(sm + ECT_SM_START) == address)
            return (sm[ECT_SM_CONTROL] & ECT_SM_CONTROL_MODE) != ECT_SM_CONTROL_MAILBOX;
    }
    return false;
}

/* Adds the time of the device's own code, once in each poll with process data. */
static void spend(ect_slow_t *slow, uint16_t address, uint16_t length, bool write)
{
    slow->now_ns += ect_board_access_ns(slow->config.board, address, length, write);
    if (slow->cycled || !is_process_data(slow->esc, address))
        return;
    slow->cycled = true;
    slow->now_ns += slow->config.cycle_ns;
}

static int queue_write(ect_slow_t *slow, uint16_t address, const void *buffer, uint16_t length)
{
    spend(slow, address, length, true);
    if ((size_t)slow->used + DATA + length > sizeof slow->queue) {
        apply(slow, ECT_NEVER - 1);
        return ect_esc_pdi_write(slow->esc, address, buffer, length);
    }
    uint8_t *entry = slow->queue + slow->used;
    ect_store_le64(entry + DUE, slow->now_ns);
    ect_store_le16(entry + ADDRESS, address);
    ect_store_le16(entry + LENGTH, length);
    memcpy(entry + DATA, buffer, length);
    slow->used = (uint16_t)(slow->used + DATA + length);
    return 0;
}

/* --- the PDI ------------------------------------------------------------------------------------------------------ */

static int write(void *ctx, uint16_t address, const void *buffer, uint16_t length)
{
    ect_slow_t *slow = ctx;
    if (slow->config.board && slow->polling)
        return queue_write(slow, address, buffer, length);
    return ect_esc_pdi_write(slow->esc, address, buffer, length);
}

/* Executes pending writes before a read, because the stack must read its own earlier writes. */
static int read(void *ctx, uint16_t address, void *buffer, uint16_t length)
{
    ect_slow_t *slow = ctx;
    if (slow->config.board && slow->polling) {
        spend(slow, address, length, false);
        apply(slow, ECT_NEVER - 1);
    }
    if (!slow->al.waits || address != ECT_REG_AL_CONTROL || length != sizeof slow->al_control)
        return ect_esc_pdi_read(slow->esc, address, buffer, length);
    memcpy(buffer, slow->al_control, length);
    slow->al.waits = false;
    return 0;
}

/* @return whether the event is still hidden */
static bool hides(ect_slow_t *slow, ect_hidden_t *hidden, const ect_slow_range_t *span, uint64_t now_ns)
{
    if (!hidden->waits)
        hidden->due_ns = now_ns + draw(slow, span);
    hidden->waits = true;
    hidden->shown = now_ns >= hidden->due_ns;
    return !hidden->shown;
}

/* AL control is read at once and processed later, so that the master may replace the request. */
static uint32_t hide_al(ect_slow_t *slow, uint32_t event, uint64_t now_ns)
{
    if ((event & ECT_EVENT_AL_CONTROL) != 0) {
        (void)ect_esc_pdi_read(slow->esc, ECT_REG_AL_CONTROL, slow->al_control, sizeof slow->al_control);
        slow->al.waits = false;
        (void)hides(slow, &slow->al, &slow->config.al, now_ns);
    }
    slow->al.shown = slow->al.waits && now_ns >= slow->al.due_ns;
    return (event & ~(uint32_t)ECT_EVENT_AL_CONTROL) | (slow->al.shown ? (uint32_t)ECT_EVENT_AL_CONTROL : 0u);
}

static uint32_t hide_mail(ect_slow_t *slow, uint32_t event, uint64_t now_ns)
{
    if ((event & ECT_EVENT_SM0) == 0)
        slow->mailbox.waits = false;
    else if (hides(slow, &slow->mailbox, &slow->config.mailbox, now_ns))
        event &= ~(uint32_t)ECT_EVENT_SM0;
    return event;
}

static int al_event(void *ctx, uint32_t *event)
{
    ect_slow_t *slow = ctx;
    uint64_t now_ns = slow->now_ns;
    *event = ect_esc_al_event(slow->esc);
    if (slow->config.al.max_ns != 0)
        *event = hide_al(slow, *event, now_ns);
    if (slow->config.mailbox.max_ns != 0)
        *event = hide_mail(slow, *event, now_ns);
    if (slow->config.board && slow->polling)
        spend(slow, ECT_REG_AL_EVENT, 4, false);
    return 0;
}

ect_pdi_t ect_slow_pdi(ect_slow_t *slow)
{
    return (ect_pdi_t){.ctx = slow, .read = read, .write = write, .al_event = al_event};
}

/* --- time --------------------------------------------------------------------------------------------------------- */

static void draw_arrival(ect_slow_t *slow)
{
    const ect_slow_range_t span = {0, slow->config.receive_ns};
    ect_esc_arrival_t arrival = slow->arrival;
    for (size_t port = 0; port < sizeof arrival.port_ns / sizeof arrival.port_ns[0]; port++)
        arrival.port_ns[port] += (uint32_t)draw(slow, &span);
    arrival.unit_ns += (uint32_t)draw(slow, &span);
    ect_esc_set_arrival(slow->esc, &arrival);
}

void ect_slow_run(ect_slow_t *slow, uint64_t now_ns)
{
    apply(slow, now_ns);
    if (slow->config.receive_ns != 0)
        draw_arrival(slow);
}

void ect_slow_delays(ect_slow_t *slow, bool before)
{
    if (slow->config.receive_ns == 0)
        return;
    if (before)
        ect_esc_set_arrival(slow->esc, &slow->arrival);
    else
        slow->arrival = slow->esc->arrival;
}

/* Without an interrupt pin the main loop reads the event word repeatedly: the next read begins a poll. */
static uint64_t begin_of_poll(ect_slow_t *slow, uint64_t now_ns)
{
    uint64_t start_ns = now_ns;
    if (slow->config.board) {
        uint64_t idle_ns = ect_board_access_ns(slow->config.board, ECT_REG_AL_EVENT, 4, false);
        uint64_t since_ns = now_ns > slow->busy_ns ? now_ns - slow->busy_ns : 0;
        start_ns = slow->busy_ns + (since_ns + idle_ns - 1) / idle_ns * idle_ns;
    }
    return slow->config.jitter.max_ns != 0 ? start_ns + draw(slow, &slow->config.jitter) : start_ns;
}

bool ect_slow_begins(ect_slow_t *slow, uint64_t now_ns)
{
    if (slow->start_ns == 0)
        slow->start_ns = begin_of_poll(slow, now_ns);
    if (now_ns < slow->start_ns)
        return false;
    slow->start_ns = 0;
    slow->now_ns = now_ns;
    slow->polling = true;
    slow->cycled = false;
    return true;
}

uint64_t ect_slow_end(ect_slow_t *slow, uint64_t slave_ns)
{
    slow->polling = false;
    slow->busy_ns = slow->now_ns;
    if (slow->al.waits && !slow->al.shown)
        slave_ns = ect_earlier(slave_ns, slow->al.due_ns);
    return slow->mailbox.waits && !slow->mailbox.shown ? ect_earlier(slave_ns, slow->mailbox.due_ns) : slave_ns;
}

uint64_t ect_slow_next(const ect_slow_t *slow, uint64_t slave_ns)
{
    uint64_t poll_ns = slow->start_ns != 0 ? slow->start_ns : ect_later(slave_ns, slow->busy_ns);
    return ect_earlier(poll_ns, next_due(slow));
}
