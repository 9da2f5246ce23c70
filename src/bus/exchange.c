/* SPDX-License-Identifier: MIT */
#include "bus/exchange.h"

#include <stdlib.h>
#include <string.h>

#include "wire/assert.h"

/* Limits: runs of the devices to catch up in one call, and steps of the scenario at one time. */
enum { CATCH_UP = 64, STEPS_IN_A_ROW = 8 };

static uint64_t now(const ect_exchange_t *x)
{
    return x->clock(x->ctx);
}

/* The devices run at this time before any later one. */
static void touch(ect_exchange_t *x, uint64_t now_ns)
{
    x->polled_ns = x->touched_ns = now_ns;
}

static void count_captured(ect_exchange_t *x, bool captured)
{
    x->stats.captured += captured;
    x->stats.uncaptured += !captured;
}

static void log_time(const ect_exchange_t *x, ect_logged_kind_t kind, uint64_t time_ns)
{
    if (x->trace)
        ect_trace_log(x->trace, kind, 0, time_ns, NULL, 0);
}

/* Reads the clock and logs the time, because a replay needs the same reading for its decisions. */
static uint64_t logged_now(const ect_exchange_t *x)
{
    uint64_t now_ns = now(x);
    log_time(x, ECT_LOGGED_CLOCK, now_ns);
    return now_ns;
}

uint64_t ect_exchange_touch(ect_exchange_t *x)
{
    touch(x, now(x));
    log_time(x, ECT_LOGGED_TOUCH, x->touched_ns);
    return x->touched_ns;
}

/* NULL: no client captures. */
static ect_recent_t *recent_of(const ect_exchange_t *x)
{
    ect_recent_t *recent = x->control ? ect_control_recent(x->control) : NULL;
    return recent && recent->on ? recent : NULL;
}

/* A frame enters the chain. */
static void note_request(ect_exchange_t *x, ect_end_t in, uint64_t now_ns, const uint8_t *frame, size_t length)
{
    if (recent_of(x))
        ect_recent_add(recent_of(x), (uint32_t)in, ECT_PCAPNG_INBOUND, now_ns, frame, length);
    if (x->trace)
        count_captured(x, ect_trace_request(x->trace, in, now_ns, frame, length));
}

/* Every frame that leaves does so here. @return the time; 0: not read */
static uint64_t emit(ect_exchange_t *x, ect_end_t end, const uint8_t *frame, size_t length)
{
    x->send(x->ctx, end, frame, length);
    if (x->datagrams.until_ns != 0)
        ect_datagrams_count(&x->datagrams, frame, length, x->polled_ns);
    if (!x->trace && !recent_of(x))
        return 0;
    uint64_t now_ns = now(x);
    if (recent_of(x))
        ect_recent_add(recent_of(x), (uint32_t)end, ECT_PCAPNG_OUTBOUND, now_ns, frame, length);
    if (x->trace)
        count_captured(x, ect_trace_reply(x->trace, end, now_ns, frame, length));
    return now_ns;
}

/* Queues a delayed reply, or a reply that must not overtake one. */
static void keep(ect_exchange_t *x, ect_end_t end, const uint8_t *frame, size_t length, uint64_t due_ns)
{
    if (ect_late_add(&x->late[end], frame, length, due_ns))
        x->stats.delayed++;
    else
        x->stats.dropped++;
}

/* Sends queued replies that are due. @return the time of the last one; 0: none, or not read */
static uint64_t send_kept(ect_exchange_t *x, ect_end_t end, ect_late_t *kept, uint64_t now_ns)
{
    uint64_t sent_ns = 0;
    ect_late_frame_t *late;
    while ((late = ect_late_take(kept, now_ns))) {
        sent_ns = emit(x, end, late->frame, late->length);
        x->stats.answered++;
        free(late);
    }
    return sent_ns;
}

static void send_late(ect_exchange_t *x, uint64_t now_ns)
{
    for (unsigned int end = 0; end < ECT_ENDS; end++) {
        (void)send_kept(x, end, &x->late[end], now_ns);
        (void)send_kept(x, end, &x->behind[end], now_ns);
    }
}

/* @return the time at which the next queued reply is due */
static uint64_t late_due(const ect_exchange_t *x)
{
    uint64_t due_ns = ECT_NEVER;
    for (unsigned int end = 0; end < ECT_ENDS; end++)
        due_ns = ect_earlier(due_ns, ect_earlier(ect_late_due(&x->late[end]), ect_late_due(&x->behind[end])));
    return due_ns;
}

static ect_end_t through(ect_exchange_t *x, ect_end_t in, uint8_t *frame, size_t length, uint64_t now_ns)
{
    const ect_filter_t *filter = x->filter;
    if (filter)
        filter->before(filter->ctx, x->chain, frame, length);
    ect_end_t out = ect_chain_pass(x->chain, in, frame, length, now_ns);
    if (filter && out != ECT_END_NONE)
        filter->after(filter->ctx, x->chain, frame, length);
    return out;
}

/* Sends a reply, and then the replies that waited for it. @return the time; 0: not read */
static uint64_t send_with_others(ect_exchange_t *x, ect_end_t end, const uint8_t *frame, size_t length, bool twice)
{
    uint64_t sent_ns = emit(x, end, frame, length);
    if (twice)
        sent_ns = emit(x, end, frame, length);
    return ect_later(sent_ns, send_kept(x, end, &x->behind[end], UINT64_MAX));
}

/* Sends a reply at once, with a delay, or after the next one. */
static void reply_with(ect_exchange_t *x, ect_end_t out, const uint8_t *frame, size_t length,
                       const ect_frame_effects_t *effects, const ect_packet_time_t *time)
{
    const unsigned int copies = effects->twice ? 2 : 1;
    if (effects->after_next) {
        for (unsigned int n = 0; n < copies; n++)
            x->stats.dropped += !ect_late_add(&x->behind[out], frame, length, time->now_ns + ECT_WIRES_BEHIND_NS);
    } else if (effects->delay_us > 0 || x->late[out].first) {
        for (unsigned int n = 0; n < copies; n++)
            keep(x, out, frame, length, time->now_ns + 1000ull * effects->delay_us);
    } else {
        uint64_t sent_ns = send_with_others(x, out, frame, length, effects->twice);
        x->answered_ns = sent_ns != 0 ? sent_ns : now(x);
        ect_stats_answer(&x->stats, time->waited_ns + (x->answered_ns - time->now_ns));
    }
}

/* @return NULL: no fault is set or planned, and no frame is kept on a wire */
static ect_scenario_t *faults_of(const ect_exchange_t *x)
{
    return x->scenario && !ect_scenario_rests(x->scenario) ? x->scenario : NULL;
}

/* Continues with frames that were kept on a wire and are due. */
static void release_kept(ect_exchange_t *x)
{
    ect_kept_t *kept;
    ect_scenario_t *faults = faults_of(x);
    uint64_t due_ns = faults ? ect_wires_due(&faults->wires) : ECT_NEVER;
    if (due_ns == ECT_NEVER)
        return;
    const uint64_t now_ns = logged_now(x);
    if (due_ns > now_ns)
        return;
    touch(x, now_ns);
    while ((kept = ect_wires_release(&faults->wires, x->chain, now_ns))) {
        if (kept->end != ECT_END_NONE && x->late[kept->end].first) {
            keep(x, kept->end, kept->frame, kept->at.length, now_ns);
        } else if (kept->end != ECT_END_NONE) {
            (void)send_with_others(x, kept->end, kept->frame, kept->at.length, false);
            x->stats.answered++;
        }
        free(kept);
    }
}

/* Records a request as received, and the effects of faults on it. */
static ect_frame_effects_t traced_effects(ect_exchange_t *x, ect_scenario_t *faults, ect_end_t in, uint8_t *frame,
                                          size_t *length, uint64_t now_ns)
{
    uint8_t request[ECT_EXCHANGE_FRAME];
    const size_t came = *length;
    ECT_ASSERT(came <= sizeof request);
    memcpy(request, frame, came);
    ect_frame_effects_t effects = ect_scenario_frame(faults, x->chain, frame, length, now_ns);
    if (x->trace)
        ect_trace_effects(x->trace, &effects, *length != came || memcmp(request, frame, came) != 0);
    note_request(x, in, now_ns, request, came);
    return effects;
}

void ect_exchange_frame(ect_exchange_t *x, ect_end_t in, uint8_t *frame, size_t length, const ect_packet_time_t *time)
{
    touch(x, time->now_ns);
    ect_scenario_t *faults = faults_of(x);
    ect_frame_effects_t effects = {0};
    if (faults && (x->trace || recent_of(x)))
        effects = traced_effects(x, faults, in, frame, &length, time->now_ns);
    else if (faults)
        effects = ect_scenario_frame(faults, x->chain, frame, &length, time->now_ns);
    else
        note_request(x, in, time->now_ns, frame, length);
    ect_end_t out = effects.lose_request ? ECT_END_NONE : through(x, in, frame, length, time->now_ns);
    ect_wires_result_t on_wires = faults ? ect_scenario_reply(faults, &effects, frame, &length) : ECT_WIRES_PASSED;
    if (x->trace && on_wires == ECT_WIRES_LOST)
        ect_trace_note(x->trace, "fault: the frame is lost on a wire");
    if (effects.lose_request || (effects.lose_reply && out != ECT_END_NONE) || on_wires == ECT_WIRES_LOST)
        x->stats.dropped++;
    else if (out != ECT_END_NONE)
        reply_with(x, out, frame, length, &effects, time);
    else if (on_wires == ECT_WIRES_KEEP)
        x->stats.delayed++;
    else
        x->stats.unanswered++;
    release_kept(x);
}

bool ect_exchange_is_plain(const ect_exchange_t *x)
{
    return !x->trace && !recent_of(x) && !x->filter && !faults_of(x) && late_due(x) == ECT_NEVER;
}

/* A late call runs the devices at each of their deadlines, so that clients also receive values that lasted only until
 * the next deadline. */
static void poll_devices(ect_exchange_t *x, uint64_t now_ns, uint64_t (*poll)(ect_chain_t *chain, uint64_t now_ns))
{
    uint64_t next_ns = ect_earlier(x->deadline_ns, x->touched_ns);
    x->touched_ns = ECT_NEVER;
    for (unsigned int i = 1; i <= CATCH_UP; i++) {
        bool late = next_ns < now_ns && i < CATCH_UP;
        x->polled_ns = late ? ect_later(next_ns, x->polled_ns) : now_ns;
        next_ns = poll(x->chain, x->polled_ns);
        if (x->control)
            ect_control_record(x->control, x->chain, x->polled_ns);
        if (x->trace)
            ect_trace_states(x->trace, x->chain);
        if (next_ns > now_ns)
            break;
    }
    x->deadline_ns = next_ns;
}

void ect_exchange_replied(ect_exchange_t *x, uint8_t *frame, size_t length, uint64_t now_ns, uint32_t took_ns)
{
    const uint64_t came_ns = ect_later(now_ns, x->polled_ns);
    const bool touched = x->touched_ns < came_ns && ect_chain_awaits_poll(x->chain, frame, length);
    if (x->deadline_ns < came_ns || touched)
        poll_devices(x, came_ns, ect_chain_catch_up);
    touch(x, came_ns);
    ect_chain_pass_replied(x->chain, frame, length, came_ns);
    if (x->datagrams.until_ns != 0)
        ect_datagrams_count(&x->datagrams, frame, length, came_ns);
    x->stats.frames++;
    ect_stats_kernel_answer(&x->stats, took_ns);
}

void ect_exchange_long_frame(ect_exchange_t *x, ect_end_t in, uint8_t *frame, size_t length, uint64_t now_ns)
{
    touch(x, now_ns);
    note_request(x, in, now_ns, frame, length);
    (void)ect_chain_pass(x->chain, in, frame, length, now_ns);
    x->stats.unanswered++;
}

void ect_exchange_link(ect_exchange_t *x, ect_end_t end, bool link)
{
    static const char *const ends[ECT_ENDS] = {[ECT_END_IN] = "input", [ECT_END_OUT] = "output"};
    if (x->trace && link != x->linked[end]) {
        ect_trace_note(x->trace, "cable at the %s of the chain: %s", ends[end], link ? "plugged in" : "pulled");
        ect_trace_log(x->trace, ECT_LOGGED_LINK, (uint32_t)end | (link ? ECT_LOGGED_PLUGGED : 0u), 0, NULL, 0);
    }
    x->linked[end] = link;
    ect_chain_set_link(x->chain, end, link);
}

/* Executes due steps of the scenario; the devices run after each step that changes the chain. @return when the next is
 * due */
static uint64_t take_steps(ect_exchange_t *x)
{
    uint64_t next_ns = ECT_NEVER;
    ect_scenario_t *scenario = faults_of(x);
    for (unsigned int i = 0; scenario && i < STEPS_IN_A_ROW; i++) {
        scenario->acted = false;
        next_ns = ect_scenario_tick(scenario, x->chain, x->polled_ns);
        if (!scenario->acted)
            break;
        x->touched_ns = x->polled_ns;
        poll_devices(x, x->polled_ns, ect_chain_poll);
    }
    return next_ns;
}

/* Whether a run changes nothing, so that a record needs no trace of it. */
static bool is_idle(const ect_exchange_t *x, uint64_t now_ns)
{
    return x->run_ns != 0 && x->touched_ns == ECT_NEVER && now_ns < x->deadline_ns && late_due(x) == ECT_NEVER;
}

static void log_run(const ect_exchange_t *x, bool answered, uint64_t now_ns)
{
    if (x->trace)
        ect_trace_log(x->trace, ECT_LOGGED_RUN, answered, now_ns, NULL, 0);
}

/* @return the time of a run. With faults the clock is read after the release of kept frames, which may read it too. */
static uint64_t begin_run(ect_exchange_t *x)
{
    const bool faults = faults_of(x) != NULL;
    const bool answered = x->answered_ns != 0;
    if (faults) {
        log_run(x, answered, 0);
        release_kept(x);
    }
    uint64_t now_ns = answered ? ect_later(x->answered_ns, x->polled_ns) : faults ? logged_now(x) : now(x);
    if (!faults && !is_idle(x, now_ns))
        log_run(x, answered, now_ns);
    return now_ns;
}

static uint64_t planned(const ect_exchange_t *x)
{
    return x->control ? ect_control_planned(x->control) : ECT_NEVER;
}

/* Executes due steps of plants. @return whether the devices must run again at this time */
static bool step_plants(ect_exchange_t *x)
{
    if (!x->control || !ect_control_wants_step(x->control, x->polled_ns))
        return false;
    return ect_control_step(x->control, x->chain, ect_exchange_touch(x));
}

static uint64_t run(ect_exchange_t *x)
{
    if (planned(x) != ECT_NEVER && planned(x) <= now(x))
        ect_control_act(x->control, x->chain, ect_exchange_touch(x));
    uint64_t now_ns = begin_run(x);
    x->answered_ns = 0;
    x->run_ns = now_ns;
    send_late(x, now_ns);
    ect_stats_poll(&x->stats, now_ns > x->deadline_ns ? now_ns - x->deadline_ns : 0);
    poll_devices(x, now_ns, ect_chain_poll);
    uint64_t step_ns = take_steps(x);
    if (x->trace)
        ect_trace_flush(x->trace);
    return ect_earlier(ect_earlier(x->deadline_ns, step_ns), ect_earlier(late_due(x), planned(x)));
}

uint64_t ect_exchange_run(ect_exchange_t *x)
{
    uint64_t next_ns = run(x);
    if (step_plants(x))
        next_ns = run(x);
    return x->control ? ect_earlier(next_ns, ect_control_step_due(x->control)) : next_ns;
}

static void note_fault(void *observer, const char *fault)
{
    const ect_exchange_t *x = observer;
    ect_trace_note(x->trace, "fault: %s", fault);
}

static void log_request(void *observer, const char *request, size_t length)
{
    enum { MOST = 300 };
    const ect_exchange_t *x = observer;
    ect_trace_note(x->trace, "request: %.*s", (int)(length < MOST ? length : MOST), request);
    ect_trace_log(x->trace, ECT_LOGGED_REQUEST, 0, x->touched_ns, request, length);
}

void ect_exchange_show(ect_exchange_t *x)
{
    ect_control_show(x->control, &x->stats, x->scenario);
    ect_control_follow(x->control, x->chain);
    ect_control_count(x->control, &x->datagrams);
    if (x->trace)
        ect_control_observe(x->control, log_request, x);
}

void ect_exchange_start(ect_exchange_t *x)
{
    x->deadline_ns = x->touched_ns = ECT_NEVER;
    x->linked[ECT_END_IN] = true; /* the links of a new chain (ect_chain_new) */
    x->stats.start_ns = now(x);
    if (x->scenario && x->scenario->step_count > 0)
        ect_chain_show(x->chain, &ect_progress_plant, &x->scenario->progress);
    if (x->control)
        ect_exchange_show(x);
    if (x->trace && x->scenario) {
        x->scenario->done = note_fault;
        x->scenario->observer = x;
    }
}

void ect_exchange_power_cycle(ect_exchange_t *x)
{
    ect_exchange_end(x);
    uint64_t now_ns = ect_exchange_touch(x);
    log_time(x, ECT_LOGGED_POWER, now_ns);
    ect_chain_power_cycle(x->chain, now_ns);
}

void ect_exchange_request(ect_exchange_t *x, const char *request, size_t length)
{
    if (x->trace)
        log_request(x, request, length);
}

void ect_exchange_end(ect_exchange_t *x)
{
    for (unsigned int end = 0; end < ECT_ENDS; end++) {
        ect_late_clear(&x->late[end]);
        ect_late_clear(&x->behind[end]);
    }
    if (x->scenario)
        ect_wires_clear(&x->scenario->wires);
}
