/* SPDX-License-Identifier: MIT */
#include "bus/eoe/network.h"

#include <stdlib.h>
#include <string.h>

#include "profiles/ip/responder.h"
#include "slave/slave.h"
#include "wire/assert.h"

typedef struct ring {
    size_t first, count;
    uint16_t lengths[ECT_NETWORK_QUEUE];
    uint8_t frames[ECT_NETWORK_QUEUE][ECT_EOE_FRAME];
} ring_t;

typedef struct values {
    uint8_t link;
    uint32_t received, sent, dropped;
} values_t;

_Static_assert(sizeof(values_t) == ECT_NETWORK_SIGNALS, "the size of an instance");

struct ect_network {
    ect_eoe_t eoe; /* the first member: functions get its address */
    const ect_eoe_t *own;
    ect_network_kind_t kind;
    values_t values;
    uint32_t lost;      /* frames dropped in this file, not by the stack */
    ect_slave_t *slave; /* of the started mailbox; NULL: none yet */
    ring_t out, in;     /* to the host, from the host or the responder */
    ect_device_t device;
    const ect_protocol_t *protocols[];
};

/* --- signals ------------------------------------------------------------------------------------------------------ */

static const ect_signal_t signals[] = {
    ECT_SIGNAL(values_t, link, "link", BOOL, WRITE, 0, 1, NULL,
               "cable to the network behind the EoE port: 1 plugged in, 0 pulled, all frames are lost"),
    ECT_SIGNAL(values_t, received, "received", U32, READ, 0, UINT32_MAX, NULL,
               "Ethernet frames of the master that the network has taken, since power-on"),
    ECT_SIGNAL(values_t, sent, "sent", U32, READ, 0, UINT32_MAX, NULL,
               "Ethernet frames sent to the master, since power-on"),
    ECT_SIGNAL(values_t, dropped, "dropped", U32, READ, 0, UINT32_MAX, NULL,
               "Ethernet frames of either direction that were broken, too long, or had no room or no link"),
};

static const ect_signal_group_t groups[] = {
    {.prefix = "eoe", .signal_count = sizeof signals / sizeof signals[0], .signals = signals}};

const ect_plant_t ect_network_plant = {
    .signal_groups = groups, .signal_group_count = 1, .outside_size = sizeof(values_t)};

/* --- queues ------------------------------------------------------------------------------------------------------- */

static bool put(ring_t *ring, const uint8_t *frame, uint16_t length)
{
    ECT_ASSERT(length <= ECT_EOE_FRAME);
    if (ring->count == ECT_NETWORK_QUEUE)
        return false;
    size_t place = (ring->first + ring->count++) % ECT_NETWORK_QUEUE;
    ring->lengths[place] = length;
    memcpy(ring->frames[place], frame, length);
    return true;
}

static void remove_first(ring_t *ring)
{
    ECT_ASSERT(ring->count > 0);
    ring->first = (ring->first + 1) % ECT_NETWORK_QUEUE;
    ring->count--;
}

/* --- the entry of the device -------------------------------------------------------------------------------------- */

static ect_network_t *network_of(const ect_eoe_t *eoe)
{
    return (ect_network_t *)(uintptr_t)eoe; /* the entry is constant for the stack only */
}

static const ect_eoe_state_t *state_of(const ect_network_t *n, const void *instance)
{
    return (const ect_eoe_state_t *)(const void *)((const uint8_t *)instance + n->eoe.offset);
}

static bool reply(ect_network_t *n, const void *instance, const uint8_t *frame, uint16_t length)
{
    uint8_t answer[ECT_EOE_FRAME];
    uint16_t size = ect_ip_reply(&state_of(n, instance)->address, frame, length, answer);
    return size == 0 || put(&n->in, answer, size);
}

static bool received(const ect_eoe_t *eoe, void *instance, uint8_t port, const uint8_t *frame, uint16_t length)
{
    ect_network_t *n = network_of(eoe);
    if (n->values.link == 0)
        return false;
    if (n->kind == ECT_NETWORK_OWN)
        return n->own->received(n->own, instance, port, frame, length);
    return n->kind == ECT_NETWORK_ECHO ? reply(n, instance, frame, length) : put(&n->out, frame, length);
}

/* Returns the device's own frame, or the oldest frame of the queue. */
static uint16_t next_frame(ect_network_t *n, void *instance, uint8_t *frame, uint8_t *port)
{
    if (n->kind == ECT_NETWORK_OWN)
        return n->own->fetch(n->own, instance, frame, port);
    if (n->in.count == 0)
        return 0;
    uint16_t length = n->in.lengths[n->in.first];
    memcpy(frame, n->in.frames[n->in.first], length);
    remove_first(&n->in);
    return length;
}

/* With the cable pulled, one call discards at most as many frames as the queue holds. */
static uint16_t fetch(const ect_eoe_t *eoe, void *instance, uint8_t *frame, uint8_t *port)
{
    ect_network_t *n = network_of(eoe);
    uint16_t length = next_frame(n, instance, frame, port);
    for (unsigned int i = 0; n->values.link == 0 && length != 0; i++) {
        n->lost++;
        length = i < ECT_NETWORK_QUEUE ? next_frame(n, instance, frame, port) : 0;
    }
    return length;
}

static uint16_t set(const ect_eoe_t *eoe, void *instance, uint8_t port, const ect_eoe_address_t *address)
{
    const ect_eoe_t *own = network_of(eoe)->own;
    return own->set ? own->set(own, instance, port, address) : ECT_EOE_OK;
}

static void load(const ect_eoe_t *eoe, void *instance, uint8_t port)
{
    const ect_eoe_t *own = network_of(eoe)->own;
    if (own->load)
        own->load(own, instance, port);
}

/* Discards frames that the master has not fetched before the restart of the mailbox. */
static void reset(const ect_eoe_t *eoe, void *instance)
{
    ect_network_t *n = network_of(eoe);
    n->in.count = n->out.count = 0;
    if (n->own->reset)
        n->own->reset(n->own, instance);
}

/* --- the protocol, and the counters of each step ------------------------------------------------------------------ */

static void count(ect_network_t *n, const ect_slave_t *slave)
{
    const ect_eoe_state_t *state = state_of(n, ect_mailbox_instance(slave));
    n->values.received = state->received;
    n->values.sent = state->sent;
    n->values.dropped = state->dropped + n->lost;
}

static ect_network_t *network_behind(const ect_protocol_t *self)
{
    return (ect_network_t *)(uintptr_t)self;
}

static uint16_t request(const ect_protocol_t *self, ect_slave_t *slave, const uint8_t *data, uint16_t length)
{
    uint16_t result = ect_eoe_request(self, slave, data, length);
    count(network_behind(self), slave);
    return result;
}

static bool next(const ect_protocol_t *self, ect_slave_t *slave, bool send)
{
    bool any = ect_eoe_next(self, slave, send);
    count(network_behind(self), slave);
    return any;
}

static void start(const ect_protocol_t *self, ect_slave_t *slave)
{
    network_behind(self)->slave = slave;
    ect_eoe_reset(self, slave);
    count(network_behind(self), slave);
}

/* --- making one --------------------------------------------------------------------------------------------------- */

const ect_eoe_t *ect_network_entry(const ect_device_t *device)
{
    const ect_protocol_t *const *p = device->protocols;
    while (p && *p && (*p)->request != ect_eoe_request)
        p++;
    return p && *p ? (const ect_eoe_t *)(const void *)*p : NULL;
}

static void make_device(ect_network_t *n, const ect_device_t *device)
{
    n->device = *device;
    for (size_t i = 0; device->protocols[i]; i++)
        n->protocols[i] = device->protocols[i] == &n->own->protocol ? &n->eoe.protocol : device->protocols[i];
    n->device.protocols = n->protocols;
}

ect_network_t *ect_network_new(const ect_device_t *device, ect_network_kind_t kind)
{
    size_t protocols = 0;
    while (device->protocols[protocols])
        protocols++;
    ect_network_t *n = calloc(1, sizeof *n + (protocols + 1) * sizeof n->protocols[0]);
    if (!n)
        return NULL;
    n->own = ect_network_entry(device);
    n->kind = kind;
    n->values.link = 1;
    ECT_ASSERT(n->own);
    n->eoe = (ect_eoe_t){ECT_EOE_PROTOCOL,
                         .offset = n->own->offset,
                         .ports = n->own->ports,
                         .dhcp = n->own->dhcp,
                         .received = received,
                         .fetch = fetch,
                         .set = set,
                         .load = load,
                         .reset = reset};
    n->eoe.protocol.states = n->own->protocol.states;
    n->eoe.protocol.request = request;
    n->eoe.protocol.next = next;
    n->eoe.protocol.reset = start;
    make_device(n, device);
    return n;
}

void ect_network_free(ect_network_t *n)
{
    free(n);
}

void ect_network_join(ect_network_t *n, ect_twin_config_t *twin)
{
    twin->device = &n->device;
    twin->beside = (ect_beside_t){&ect_network_plant, &n->values, sizeof n->values};
}

/* --- the host's side ---------------------------------------------------------------------------------------------- */

bool ect_network_has_link(const ect_network_t *n)
{
    return n->values.link != 0 && n->slave && !n->slave->off_bus &&
           (n->eoe.protocol.states & ECT_IN(n->slave->state)) != 0;
}

size_t ect_network_room(const ect_network_t *n)
{
    return ECT_NETWORK_QUEUE - n->in.count;
}

static void lose(ect_network_t *n)
{
    n->lost++;
    n->values.dropped++;
}

void ect_network_push(ect_network_t *n, const uint8_t *frame, size_t length)
{
    ECT_ASSERT(n->kind == ECT_NETWORK_HOST);
    if (length > ECT_EOE_FRAME || !ect_network_has_link(n) || !put(&n->in, frame, (uint16_t)length))
        lose(n);
    else
        ect_mailbox_wake(n->slave);
}

const uint8_t *ect_network_peek(const ect_network_t *n, uint16_t *length)
{
    if (n->out.count == 0)
        return NULL;
    *length = n->out.lengths[n->out.first];
    return n->out.frames[n->out.first];
}

void ect_network_next(ect_network_t *n, bool taken)
{
    remove_first(&n->out);
    if (!taken)
        lose(n);
}
