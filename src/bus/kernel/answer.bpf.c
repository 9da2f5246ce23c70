/* SPDX-License-Identifier: MIT */
/*
 * The program at the XDP hook of an interface: replies to frames by plans (plan.h), and holds each of these frames for
 * the twins' process. All other frames go on to that process, in their order (turn.h).
 *
 * Each access to a frame or a map has a bound that the verifier checks. The maps belong to one process and its chain.
 */
#include <linux/bpf.h>

#include <bpf/bpf_helpers.h>

#define ECT_STEPS_FRAME                          struct xdp_md *
#define ECT_STEPS_LOAD                           bpf_xdp_load_bytes
#define ECT_STEPS_STORE(frame, at, from, length) bpf_xdp_store_bytes(frame, at, (void *)(uintptr_t)(from), length)

#include "bus/kernel/shared.h"

enum { ETHERTYPE_ECAT = 0xA488, ETHERTYPE_VLAN = 0x0081, SHORTEST = 28, BELL = 4096 };

struct {
    __uint(type, BPF_MAP_TYPE_ARRAY);
    __uint(map_flags, BPF_F_MMAPABLE);
    __uint(max_entries, 1);
    __type(key, uint32_t);
    __type(value, ect_shared_t);
} shared SEC(".maps");

struct {
    __uint(type, BPF_MAP_TYPE_ARRAY);
    __uint(map_flags, BPF_F_MMAPABLE);
    __uint(max_entries, ECT_PLANS);
    __type(key, uint32_t);
    __type(value, ect_plan_t);
} plans SEC(".maps");

struct {
    __uint(type, BPF_MAP_TYPE_ARRAY);
    __uint(map_flags, BPF_F_MMAPABLE);
    __uint(max_entries, ECT_HELD_FRAMES);
    __type(key, uint32_t);
    __type(value, ect_held_t);
} held SEC(".maps");

/* Wakes the process; the content of the event is unused. */
struct {
    __uint(type, BPF_MAP_TYPE_RINGBUF);
    __uint(max_entries, BELL);
} bell SEC(".maps");

static __always_inline bool is_ethercat(struct xdp_md *ctx, const uint8_t *head)
{
    uint8_t inner[2];
    uint16_t type = ect_load_le16(head + ECT_PLAN_TYPE);
    if (type != ETHERTYPE_VLAN)
        return type == ETHERTYPE_ECAT;
    return bpf_xdp_load_bytes(ctx, ECT_PLAN_TYPE + 4, inner, 2) == 0 && ect_load_le16(inner) == ETHERTYPE_ECAT;
}

static __always_inline void ring(void)
{
    uint64_t *one = bpf_ringbuf_reserve(&bell, sizeof *one, 0);
    if (!one)
        return;
    *one = 0;
    bpf_ringbuf_submit(one, BPF_RB_FORCE_WAKEUP);
}

/* @return NULL: none */
static __always_inline const ect_plan_t *find_plan(const uint8_t *head, uint32_t *place)
{
    const uint64_t key = ect_plan_key(head);
    const uint32_t first = ect_plan_place(key);
    for (uint32_t i = 0; i < ECT_PLAN_PROBES; i++) {
        *place = (first + i) % ECT_PLANS;
        const ect_plan_t *plan = bpf_map_lookup_elem(&plans, place);
        if (!plan || plan->key == 0)
            return 0;
        if (plan->key == key)
            return plan;
    }
    return 0;
}

/* Replies to a frame; called with the turn. @return XDP_TX: replied; XDP_PASS: no plan, no room to hold the frame, or
 * the devices must react first; XDP_DROP: the plan is out of bounds */
static __always_inline int reply(struct xdp_md *ctx, ect_shared_t *s, const uint8_t *head)
{
    uint32_t place;
    uint32_t at = (uint32_t)s->held;
    uint64_t length = bpf_xdp_get_buff_len(ctx);
    uint64_t now_ns = bpf_ktime_get_ns();
    const ect_plan_t *plan = find_plan(head, &place);
    ect_held_t *h = bpf_map_lookup_elem(&held, &at);
    if (!plan || !h || length > ECT_PLAN_FRAME || length < SHORTEST ||
        !ect_steps_match(plan, ctx, (uint32_t)length, head))
        return XDP_PASS;
    if (bpf_xdp_load_bytes(ctx, 0, h->frame, (uint32_t)length) != 0 ||
        ect_pace_is_close(&s->last_ns[place % ECT_PLANS], now_ns, s->reacting != 0))
        return XDP_PASS;
    h->time_ns = now_ns;
    h->length = (uint32_t)length;
    if (!ect_steps_run(plan, ctx, head, now_ns))
        return XDP_DROP;
    h->took_ns = (uint32_t)(bpf_ktime_get_ns() - now_ns);
    s->held = at + 1;
    if (at == 0)
        ring();
    return XDP_TX;
}

SEC("xdp") int answer(struct xdp_md *ctx)
{
    uint8_t head[ECT_PLAN_HEAD];
    uint32_t zero = 0;
    ect_shared_t *s = bpf_map_lookup_elem(&shared, &zero);
    if (!s || bpf_xdp_load_bytes(ctx, 0, head, sizeof head) != 0 || !is_ethercat(ctx, head))
        return XDP_PASS;
    if (!ect_turn_begin(&s->turn))
        return XDP_PASS;
    int verdict = reply(ctx, s, head);
    ect_turn_end(&s->turn, verdict == XDP_PASS);
    return verdict;
}

char answer_license[] SEC("license") = "MIT";
