/* SPDX-License-Identifier: MIT */
/* Mailbox protocols of a product: two (support/voe.h) and CoE, each served in the states of its entry. */
#include <stddef.h>
#include <string.h>

#include "support/testdev.h"
#include "support/voe.h"
#include "support/wire.h"

enum { SM0 = 0x1000, SM1 = 0x1080, SIZE = 128, HEADER = 6, VOE = ECT_MAILBOX_TYPE_VOE, FOE = ECT_MAILBOX_TYPE_FOE };

typedef struct product {
    testdev_t base;
    voe_t voe;
} product_t;

static const voe_protocol_t voe = {.protocol = {.type = ECT_MAILBOX_TYPE_VOE,
                                                .states = ECT_IN_PREOP_AND_ABOVE,
                                                .request = voe_request,
                                                .next = voe_next,
                                                .reset = voe_reset},
                                   .offset = offsetof(product_t, voe)};
static const voe_protocol_t boot = {
    .protocol = {.type = ECT_MAILBOX_TYPE_FOE, .states = ECT_IN(ECT_STATE_BOOT), .request = voe_boot_request},
    .offset = offsetof(product_t, voe)};
static const ect_protocol_t *const protocols[] = {&ect_protocol_emergency, &ect_protocol_sdo, &voe.protocol,
                                                  &boot.protocol, NULL};

static void open_product(wire_t *w)
{
    static ect_device_t device;
    device = testdev;
    device.protocols = protocols;
    device.mailbox_protocols = ECT_MAILBOX_COE | ECT_MAILBOX_FOE | ECT_MAILBOX_VOE;
    device.instance_size = sizeof(product_t);
    device.boot_out = (ect_boot_mailbox_t){SM0, SIZE};
    device.boot_in = (ect_boot_mailbox_t){SM1, SIZE};
    wire_open_one(w, &device);
}

static voe_t *voe_of(wire_t *w)
{
    return &((product_t *)(void *)testdev_of(w, 0))->voe;
}

static int send(wire_t *w, uint8_t type, const void *data, uint16_t length)
{
    uint8_t mail[SIZE] = {0};
    w->mail_counter = (uint8_t)(w->mail_counter % 7 + 1);
    ect_store_le16(mail, length);
    mail[5] = (uint8_t)(type | (w->mail_counter << 4));
    memcpy(mail + HEADER, data, length);
    return wire_write(w, 0, SM0, mail, SIZE);
}

/* @return type of the mail fetched, or -1 */
static int fetch(wire_t *w, uint8_t mail[SIZE])
{
    memset(mail, 0, SIZE);
    return wire_read(w, 0, SM1, mail, SIZE) == 1 ? mail[5] & 0x0F : -1;
}

static void expect_error(wire_t *w, uint16_t detail)
{
    uint8_t mail[SIZE];
    assert_int_equal(fetch(w, mail), ECT_MAILBOX_TYPE_ERROR);
    assert_int_equal(ect_load_le16(mail + HEADER + 2), detail);
}

static void expect_sdo(wire_t *w)
{
    uint32_t value = 0;
    size_t size = sizeof value;
    assert_int_equal(wire_sdo_upload(w, 0, 0x2000, 0, false, &value, &size), 0);
}

static void served(void **state)
{
    (void)state;
    static const uint8_t states[] = {ECT_STATE_PREOP, ECT_STATE_SAFEOP, ECT_STATE_OP};
    for (size_t i = 0; i < sizeof states; i++) {
        wire_t w;
        uint8_t mail[SIZE];
        open_product(&w);
        wire_go(&w, 0, states[i]);
        assert_int_equal(send(&w, VOE, "abcd", 4), 1);
        assert_int_equal(fetch(&w, mail), VOE);
        assert_int_equal(ect_load_le16(mail), 4);
        assert_memory_equal(mail + HEADER, "dcba", 4);
        expect_sdo(&w); /* beside it */
        assert_int_equal(send(&w, FOE, "x", 1), 1);
        expect_error(&w, ECT_MAILBOX_ERROR_PROTOCOL); /* served in BOOT only */
        wire_close(&w);
    }
}

static void own_states(void **state)
{
    (void)state;
    wire_t w;
    uint8_t mail[SIZE];
    open_product(&w);
    wire_configure_mailbox(&w, 0);
    assert_int_equal(wire_al(&w, 0, ECT_STATE_BOOT, NULL), ECT_STATE_BOOT);
    for (uint32_t n = 1; n <= 3; n++) {
        assert_int_equal(send(&w, FOE, "0123456789", 10), 1);
        assert_int_equal(fetch(&w, mail), FOE);
        assert_int_equal(ect_load_le32(mail + HEADER), 10 * n);
    }
    assert_int_equal(send(&w, VOE, "abcd", 4), 1);
    expect_error(&w, ECT_MAILBOX_ERROR_PROTOCOL);
    assert_int_equal(send(&w, ECT_MAILBOX_TYPE_COE, "\0\x20\x40\0\x20\0\0\0\0\0", 10), 1);
    expect_error(&w, ECT_MAILBOX_ERROR_PROTOCOL);
    /* A mail of the device waits until its protocol is permitted. */
    const uint8_t data[5] = {0};
    testdev_of(&w, 0)->host->emergency(testdev_of(&w, 0)->host->ctx, 0x8110, 0, data);
    voe_of(&w)->again = 1;
    wire_advance(&w, 10 * MS);
    assert_int_equal(fetch(&w, mail), -1);
    wire_close(&w);
}

static void an_error_is_answered(void **state)
{
    (void)state;
    wire_t w;
    open_product(&w);
    wire_go(&w, 0, ECT_STATE_PREOP);
    assert_int_equal(send(&w, VOE, "a", 1), 1);
    expect_error(&w, ECT_MAILBOX_ERROR_TOO_SHORT);
    /* SDO information is not listed, and the listed CoE entry does not accept it. */
    assert_int_equal(send(&w, ECT_MAILBOX_TYPE_COE, "\0\x80\1\0\0\0\1\0", 8), 1);
    expect_error(&w, ECT_MAILBOX_ERROR_SERVICE);
    assert_int_equal(send(&w, ECT_MAILBOX_TYPE_EOE, "abcd", 4), 1);
    expect_error(&w, ECT_MAILBOX_ERROR_PROTOCOL);
    wire_close(&w);
}

/* A mail of its own each time that the mailbox is free; emergencies precede it, replies precede it, and repeats work
 * as usual. */
static void mails_of_its_own(void **state)
{
    (void)state;
    wire_t w;
    uint8_t mail[SIZE], again[SIZE];
    const uint8_t data[5] = {0};
    open_product(&w);
    wire_go(&w, 0, ECT_STATE_PREOP);
    assert_int_equal(send(&w, VOE, "again \3", 7), 1);
    assert_int_equal(fetch(&w, mail), VOE);
    assert_int_equal(ect_load_le16(mail), 7);
    testdev_of(&w, 0)->host->emergency(testdev_of(&w, 0)->host->ctx, 0x8110, 0, data);
    assert_int_equal(send(&w, VOE, "ab", 2), 1);
    assert_int_equal(fetch(&w, mail), VOE); /* it was there already */
    assert_int_equal(mail[HEADER], 3);
    assert_int_equal(fetch(&w, mail), ECT_MAILBOX_TYPE_COE);
    assert_int_equal(fetch(&w, mail), VOE);
    assert_memory_equal(mail + HEADER, "ba", 2);
    assert_int_equal(fetch(&w, mail), VOE);
    assert_int_equal(mail[HEADER], 2);
    /* The master lost it: the toggle of SM1 requests it again. */
    wire_write8(&w, 0, ECT_REG_SM + ECT_SM_SIZE + ECT_SM_ACTIVATE, ECT_SM_ACTIVATE_ENABLE | ECT_SM_ACTIVATE_REPEAT);
    assert_int_equal(fetch(&w, again), VOE);
    assert_memory_equal(again, mail, SIZE);
    assert_int_equal(fetch(&w, mail), VOE);
    assert_int_equal(mail[HEADER], 1);
    assert_int_equal(fetch(&w, mail), -1);
    wire_close(&w);
}

static void forgets_on_restart(void **state)
{
    (void)state;
    wire_t w;
    uint8_t mail[SIZE];
    open_product(&w);
    wire_go(&w, 0, ECT_STATE_PREOP);
    assert_int_equal(voe_of(&w)->resets, 1);
    assert_int_equal(send(&w, VOE, "again \5", 7), 1);
    assert_int_equal(wire_al(&w, 0, ECT_STATE_INIT, NULL), ECT_STATE_INIT);
    assert_int_equal(voe_of(&w)->again, 5);
    wire_configure_mailbox(&w, 0);
    assert_int_equal(wire_al(&w, 0, ECT_STATE_PREOP, NULL), ECT_STATE_PREOP);
    assert_int_equal(voe_of(&w)->resets, 2);
    wire_advance(&w, MS);
    assert_int_equal(fetch(&w, mail), -1);
    expect_sdo(&w);
    wire_close(&w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"Protocols: one of a product is served with CoE, in the states of its entry", served, NULL, NULL, NULL},
        {"Protocols: one for BOOT alone; the others neither reply nor send mails in them", own_states, NULL, NULL,
         NULL},
        {"Protocols: the error that an entry returns is sent; a mail without an entry gets detail 2 or 4 (CF-086)",
         an_error_is_answered, NULL, NULL, NULL},
        {"Protocols: a protocol's own mails follow when the mailbox is free, after emergencies and replies, and are "
         "repeated",
         mails_of_its_own, NULL, NULL, NULL},
        {"Protocols: active transfers are dropped when the mailbox restarts", forgets_on_restart, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests_name("protocols", tests, NULL, NULL);
}
