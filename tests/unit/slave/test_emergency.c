/* SPDX-License-Identifier: MIT */
/* Emergencies of a device: bytes, order, queue, error register, states (spec E.7). */
#include <string.h>

#include "support/testdev.h"
#include "support/wire.h"

enum { HEADER = 6, ROOM = 300, NO_MAIL = -1, QUEUE = 8 };

/* A device that requests a poll every millisecond. */
static uint64_t every_millisecond(void *instance, uint64_t now_ns)
{
    (void)instance;
    return now_ns + MS;
}

static testdev_t *open_in(wire_t *w, ect_device_t *device, uint8_t state)
{
    *device = testdev;
    device->tick = every_millisecond;
    wire_open_one(w, device);
    wire_go(w, 0, state);
    return testdev_of(w, 0);
}

/* Emergency n: every byte of it differs from those of the others. */
static void raise_emergency(testdev_t *t, unsigned int n)
{
    const uint8_t data[5] = {(uint8_t)n, (uint8_t)(n + 1), (uint8_t)(n + 2), (uint8_t)(n + 3), (uint8_t)(n + 4)};
    t->host->emergency(t->host->ctx, (uint16_t)(0x8100 + n), (uint8_t)(0x80 | n), data);
}

static void expect_emergency(wire_t *w, unsigned int n)
{
    uint8_t mail[ROOM] = {0};
    const uint8_t want[10] = {0x00,
                              0x10,
                              (uint8_t)n,
                              0x81,
                              (uint8_t)(0x80 | n),
                              (uint8_t)n,
                              (uint8_t)(n + 1),
                              (uint8_t)(n + 2),
                              (uint8_t)(n + 3),
                              (uint8_t)(n + 4)};
    int length = wire_mail_receive(w, 0, mail, sizeof mail);
    if (length != 10 || (mail[5] & 0x8F) != 3 || mail[4] != 0 || memcmp(mail + HEADER, want, 10) != 0)
        fail_msg("expected emergency %u of 10 bytes, got length %d, type %u, service %X, code %04X", n, length,
                 mail[5] & 0x0F, mail[7] >> 4, ect_load_le16(mail + 8));
}

static void expect_nothing(wire_t *w)
{
    uint8_t mail[ROOM];
    wire_advance(w, 2 * MS);
    assert_int_equal(wire_mail_receive(w, 0, mail, sizeof mail), NO_MAIL);
}

static void put_upload(wire_t *w, uint8_t command, uint16_t index)
{
    w->mail_counter = (uint8_t)(w->mail_counter % 7 + 1);
    const uint8_t mail[16] = {
        10, 0, 0, 0, 0, (uint8_t)(3 | w->mail_counter << 4), 0, 0x20, command, (uint8_t)index, (uint8_t)(index >> 8)};
    assert_int_equal(wire_mail_send(w, 0, mail, sizeof mail), 1);
}

static int fetch_reply(wire_t *w, uint8_t *mail)
{
    int length = wire_mail_receive(w, 0, mail, ROOM);
    if (length < 10 || mail[7] != 0x30)
        fail_msg("expected an SDO response, got length %d, service byte %02X", length, mail[7]);
    return length;
}

static void bytes_in_every_state(void **state)
{
    static const uint8_t states[] = {ECT_STATE_PREOP, ECT_STATE_SAFEOP, ECT_STATE_OP};
    (void)state;
    for (size_t i = 0; i < sizeof states; i++) {
        wire_t w;
        ect_device_t device;
        testdev_t *t = open_in(&w, &device, states[i]);
        raise_emergency(t, 0x21);
        wire_advance(&w, MS);
        expect_emergency(&w, 0x21);
        expect_nothing(&w);
        wire_close(&w);
    }
}

static void error_and_no_error(void **state)
{
    static const uint8_t none[5] = {0}, want[10] = {0x00, 0x10};
    wire_t w;
    ect_device_t device;
    uint8_t mail[ROOM];
    (void)state;
    testdev_t *t = open_in(&w, &device, ECT_STATE_PREOP);
    raise_emergency(t, 5);
    t->host->emergency(t->host->ctx, 0x0000, 0x00, none);
    wire_advance(&w, MS);
    expect_emergency(&w, 5);
    assert_int_equal(wire_mail_receive(&w, 0, mail, sizeof mail), 10);
    assert_memory_equal(mail + HEADER, want, 10);
    expect_nothing(&w);
    wire_close(&w);
}

static void in_order_and_before_replies(void **state)
{
    wire_t w;
    ect_device_t device;
    uint8_t mail[ROOM];
    (void)state;
    testdev_t *t = open_in(&w, &device, ECT_STATE_PREOP);
    for (unsigned int n = 1; n <= 3; n++)
        raise_emergency(t, n);
    put_upload(&w, 0x40, 0x2000);
    for (unsigned int n = 1; n <= 3; n++)
        expect_emergency(&w, n);
    assert_int_equal(fetch_reply(&w, mail), 10);
    assert_int_equal(mail[8], 0x43);
    expect_nothing(&w);
    wire_close(&w);
}

static void behind_an_unread_reply(void **state)
{
    wire_t w;
    ect_device_t device;
    uint8_t mail[ROOM];
    (void)state;
    testdev_t *t = open_in(&w, &device, ECT_STATE_PREOP);
    put_upload(&w, 0x40, 0x2000);
    raise_emergency(t, 9);
    wire_advance(&w, 3 * MS);
    put_upload(&w, 0x40, 0x2004);
    assert_int_equal(fetch_reply(&w, mail), 10);
    assert_int_equal(mail[8], 0x43);
    expect_emergency(&w, 9);
    assert_int_equal(fetch_reply(&w, mail), 10);
    assert_int_equal(mail[8], 0x4B);
    expect_nothing(&w);
    wire_close(&w);
}

/* Transfers in several mails continue unaffected. */
static void between_segments(void **state)
{
    wire_t w;
    ect_device_t device;
    uint8_t mail[ROOM], got[1000];
    (void)state;
    testdev_t *t = open_in(&w, &device, ECT_STATE_PREOP);
    for (unsigned int i = 0; i < 1000; i++)
        t->octets[i] = (uint8_t)(i * 11);
    put_upload(&w, 0x40, 0x2002);
    unsigned int done = (unsigned int)fetch_reply(&w, mail) - 10;
    memcpy(got, mail + 16, done);
    for (unsigned int n = 0; done < 1000; n++) {
        raise_emergency(t, n);
        wire_advance(&w, MS);
        expect_emergency(&w, n);
        put_upload(&w, (uint8_t)(0x60 | (n % 2) << 4), 0);
        unsigned int piece = (unsigned int)fetch_reply(&w, mail) - 3;
        assert_true(done + piece <= 1000);
        memcpy(got + done, mail + 9, piece);
        done += piece;
    }
    assert_memory_equal(got, t->octets, 1000);
    wire_close(&w);
}

static void between_fragments_of_a_list(void **state)
{
    static const uint8_t list[14] = {8, 0, 0, 0, 0, 0x13, 0x00, 0x80, 0x01, 0, 0, 0, 0x01, 0x00};
    static ect_object_t objects[100];
    static const ect_entry_t entry[] = {{0, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, "E", 0, NULL}};
    ect_device_t device = testdev;
    wire_t w;
    uint8_t mail[ROOM];
    (void)state;
    for (uint16_t i = 0; i < 100; i++)
        objects[i] = (ect_object_t){(uint16_t)(0x2000 + i), ECT_OBJECT_VAR, 0, 0, "O", entry};
    device.objects = objects;
    device.object_count = 100;
    wire_open_one(&w, &device);
    wire_go(&w, 0, ECT_STATE_PREOP);
    testdev_t *t = testdev_of(&w, 0);
    assert_int_equal(wire_mail_send(&w, 0, list, sizeof list), 1);
    raise_emergency(t, 3);
    assert_int_equal(wire_mail_receive(&w, 0, mail, sizeof mail), 122);
    assert_int_equal(mail[8], 0x82);
    expect_emergency(&w, 3);
    assert_int_equal(wire_mail_receive(&w, 0, mail, sizeof mail), 6 + 2 * (101 - 58));
    assert_int_equal(mail[8], 0x02);
    assert_int_equal(ect_load_le16(mail + 12), 0x2000 + 57);
    wire_close(&w);
}

static void full_queue(void **state)
{
    wire_t w;
    ect_device_t device;
    (void)state;
    testdev_t *t = open_in(&w, &device, ECT_STATE_PREOP);
    const ect_slave_t *slave = ect_chain_slave(w.chain, 0);
    assert_int_equal(ECT_EMERGENCY_QUEUE, QUEUE);
    for (unsigned int round = 0; round < 3; round++) {
        for (unsigned int n = 0; n < QUEUE + 3; n++)
            raise_emergency(t, 10 * round + n);
        assert_int_equal(slave->emergencies_lost, 3 * (round + 1));
        wire_advance(&w, MS);
        for (unsigned int n = 0; n < QUEUE - 1; n++)
            expect_emergency(&w, 10 * round + n);
        raise_emergency(t, 0x70); /* a place is free again */
        assert_int_equal(slave->emergencies_lost, 3 * (round + 1));
        expect_emergency(&w, 10 * round + QUEUE - 1);
        expect_emergency(&w, 0x70);
        expect_nothing(&w);
    }
    wire_close(&w);
}

static uint8_t error_register(wire_t *w)
{
    uint8_t value = 0xEE;
    size_t size = 1;
    assert_int_equal(wire_sdo_upload(w, 0, 0x1001, 0, false, &value, &size), 0);
    assert_int_equal(size, 1);
    return value;
}

static void error_register_follows(void **state)
{
    static const uint8_t none[5] = {0};
    wire_t w;
    ect_device_t device;
    (void)state;
    testdev_t *t = open_in(&w, &device, ECT_STATE_PREOP);
    assert_int_equal(error_register(&w), 0);
    raise_emergency(t, 1);
    wire_advance(&w, MS);
    expect_emergency(&w, 1);
    assert_int_equal(error_register(&w), 0x81);
    for (unsigned int n = 0; n <= QUEUE; n++)
        raise_emergency(t, n); /* the last one is lost, the state of the device is not */
    wire_advance(&w, MS);
    for (unsigned int n = 0; n < QUEUE; n++)
        expect_emergency(&w, n);
    assert_int_equal(error_register(&w), 0x80 | QUEUE);
    t->host->emergency(t->host->ctx, 0, 0, none);
    wire_advance(&w, MS);
    assert_int_equal(wire_mail_receive(&w, 0, (uint8_t[ROOM]){0}, ROOM), 10);
    assert_int_equal(error_register(&w), 0);
    wire_close(&w);
}

static void not_below_preop(void **state)
{
    wire_t w;
    ect_device_t device;
    (void)state;
    testdev_t *t = open_in(&w, &device, ECT_STATE_INIT);
    wire_configure_mailbox(&w, 0);
    raise_emergency(t, 1);
    wire_advance(&w, 5 * MS);
    assert_int_equal(wire_read8(&w, 0, ECT_REG_SM + ECT_SM_SIZE + ECT_SM_STATUS) & ECT_SM_STATUS_FULL, 0);
    wire_close(&w);
    t = open_in(&w, &device, ECT_STATE_OP);
    wire_go(&w, 0, ECT_STATE_INIT);
    wire_configure_mailbox(&w, 0);
    raise_emergency(t, 2);
    wire_advance(&w, 5 * MS);
    assert_int_equal(wire_read8(&w, 0, ECT_REG_SM + ECT_SM_SIZE + ECT_SM_STATUS) & ECT_SM_STATUS_FULL, 0);
    wire_close(&w);
}

static void restart_forgets(void **state)
{
    wire_t w;
    ect_device_t device;
    (void)state;
    testdev_t *t = open_in(&w, &device, ECT_STATE_PREOP);
    for (unsigned int n = 0; n < 4; n++)
        raise_emergency(t, n);
    t->host->restart(t->host->ctx);
    wire_advance(&w, 2 * MS);
    wire_assign_stations(&w);
    wire_go(&w, 0, ECT_STATE_PREOP);
    expect_nothing(&w);
    assert_int_equal(error_register(&w), 0);
    wire_close(&w);
}

static void counters_run_on(void **state)
{
    wire_t w;
    ect_device_t device;
    uint8_t mail[ROOM];
    (void)state;
    testdev_t *t = open_in(&w, &device, ECT_STATE_PREOP);
    for (unsigned int n = 0; n < 20; n++) {
        if (n % 3 == 0)
            put_upload(&w, 0x40, 0x2000);
        else
            raise_emergency(t, n);
        wire_advance(&w, MS);
        assert_int_equal(wire_mail_receive(&w, 0, mail, sizeof mail), 10);
        assert_int_equal((mail[5] >> 4) & 7, n % 7 + 1);
    }
    wire_close(&w);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"CF-079: an emergency is a CoE mail of service 1 with code, register and 5 bytes, in PREOP, SAFEOP and OP",
         bytes_in_every_state, NULL, NULL, NULL},
        {"CF-079: an error and its end are two emergencies, the second with code 0000", error_and_no_error, NULL, NULL,
         NULL},
        {"CF-079: emergencies are sent in order, and before the reply to a request", in_order_and_before_replies, NULL,
         NULL, NULL},
        {"CF-079 CF-025: an emergency does not overwrite a reply in SM1", behind_an_unread_reply, NULL, NULL, NULL},
        {"CF-079: an upload in segments continues between emergencies", between_segments, NULL, NULL, NULL},
        {"CF-079 CF-076: an object list continues after an emergency", between_fragments_of_a_list, NULL, NULL, NULL},
        {"CF-079: eight emergencies wait, further ones are lost and counted", full_queue, NULL, NULL, NULL},
        {"CF-079: 1001h holds the error register of the last emergency, a lost one included", error_register_follows,
         NULL, NULL, NULL},
        {"CF-079: nothing is sent below PREOP", not_below_preop, NULL, NULL, NULL},
        {"CF-079: a restart discards waiting emergencies", restart_forgets, NULL, NULL, NULL},
        {"CF-024 CF-079: emergencies and replies share the mail counter 1 to 7", counters_run_on, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Emergency", tests, NULL, NULL);
}
