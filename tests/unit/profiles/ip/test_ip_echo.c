/* SPDX-License-Identifier: MIT */
/* A device without a network stack that replies: one reply at a time. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "profiles/ip/echo.h"

enum { ARP_LENGTH = 42, ARP_REPLY = 2 };

typedef struct device {
    uint32_t other; /* so that the network is not at the beginning of the instance */
    ect_ip_echo_t network;
} device_t;

static const ect_eoe_t entry = ECT_IP_ECHO(offsetof(device_t, network));

/* ARP request of 192.168.10.1 for 192.168.10.20 */
static const uint8_t request[ARP_LENGTH] = {
    0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0,    0x11, 0x22, 0x33, 0x44, 0x55, 8, 6, 0, 1, 8, 0,   6,   4,  0,
    1,    0,    0x11, 0x22, 0x33, 0x44, 0x55, 192,  168,  10,   1,    0,    0, 0, 0, 0, 0, 192, 168, 10, 20};

static device_t *with_address(void)
{
    static device_t d;
    memset(&d, 0, sizeof d);
    d.network.eoe.address = (ect_eoe_address_t){.known = ECT_EOE_HAS_IP, .ip = {192, 168, 10, 20}};
    return &d;
}

static uint16_t fetched(device_t *d, uint8_t *frame)
{
    uint8_t port = 0;
    return entry.fetch(&entry, d, frame, &port);
}

static void the_reply_is_fetched_once(void **state)
{
    uint8_t frame[ECT_EOE_FRAME];
    device_t *d = with_address();
    (void)state;
    assert_int_equal(fetched(d, frame), 0);
    assert_true(entry.received(&entry, d, 0, request, sizeof request));
    assert_true(fetched(d, frame) >= ARP_LENGTH);
    assert_memory_equal(frame, request + 6, 6);
    assert_int_equal(frame[21], ARP_REPLY);
    assert_memory_equal(frame + 28, request + 38, 4);
    assert_int_equal(fetched(d, frame), 0);
}

static void a_frame_before_the_reply_is_fetched_is_dropped(void **state)
{
    uint8_t frame[ECT_EOE_FRAME];
    device_t *d = with_address();
    (void)state;
    assert_true(entry.received(&entry, d, 0, request, sizeof request));
    assert_false(entry.received(&entry, d, 0, request, sizeof request));
    assert_true(fetched(d, frame) > 0);
    assert_int_equal(fetched(d, frame), 0);
    assert_true(entry.received(&entry, d, 0, request, sizeof request));
}

static void a_start_of_the_mailbox_discards_the_reply(void **state)
{
    uint8_t frame[ECT_EOE_FRAME];
    device_t *d = with_address();
    (void)state;
    assert_true(entry.received(&entry, d, 0, request, sizeof request));
    entry.reset(&entry, d);
    assert_int_equal(fetched(d, frame), 0);
    assert_true(entry.received(&entry, d, 0, request, sizeof request));
}

static void a_frame_without_a_reply_leaves_room_for_the_next(void **state)
{
    uint8_t frame[ECT_EOE_FRAME];
    device_t *d = with_address();
    (void)state;
    d->network.eoe.address.known = 0; /* no address, no reply */
    assert_true(entry.received(&entry, d, 0, request, sizeof request));
    assert_int_equal(fetched(d, frame), 0);
    assert_true(entry.received(&entry, d, 0, request, sizeof request));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"The reply to a frame is fetched once", the_reply_is_fetched_once, NULL, NULL, NULL},
        {"EOE-016 A frame that comes before the reply is fetched is dropped, and the next one after it is taken",
         a_frame_before_the_reply_is_fetched_is_dropped, NULL, NULL, NULL},
        {"EOE-051 A start of the mailbox discards the reply that waits", a_start_of_the_mailbox_discards_the_reply,
         NULL, NULL, NULL},
        {"A frame without a reply leaves room for the next", a_frame_without_a_reply_leaves_room_for_the_next, NULL,
         NULL, NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
