/* SPDX-License-Identifier: MIT */
/* The vendor's protocol of examples/device, with CoE in one mailbox. */
#include <string.h>

#include "heater.h"
#include "support/testdev.h"
#include "support/wire.h"

enum { MAIL_HEADER = 6, ROOM = 128, VOE = ECT_MAILBOX_TYPE_VOE, ERROR_AT = MAIL_HEADER + 2 };
#define VENDOR 0x57, 0x0E, 0, 0

static wire_t w;

static heater_t *device(void)
{
    return (heater_t *)(void *)testdev_of(&w, 0);
}

static int setup(void **state)
{
    (void)state;
    wire_open_one(&w, &heater);
    wire_go(&w, 0, ECT_STATE_PREOP);
    device()->sensed = 215;
    device()->peak = 770;
    return 0;
}

static int teardown(void **state)
{
    (void)state;
    wire_close(&w);
    return 0;
}

static void each_request_has_its_reply(void **state)
{
    static const struct {
        const char *what;
        uint8_t request[8], length;
        uint8_t type, reply[8], reply_length; /* of an error: its detail */
        int16_t peak;                         /* afterwards */
    } rows[] = {
        {"read", {VENDOR, 1, 0}, 6, VOE, {VENDOR, 1, 0, 0x02, 0x03}, 8, 770},
        {"clear", {VENDOR, 2, 0}, 6, VOE, {VENDOR, 2, 0}, 6, 215},
        {"read again", {VENDOR, 1, 0}, 6, VOE, {VENDOR, 1, 0, 0xD7, 0}, 8, 215},
        {"an unknown service", {VENDOR, 3, 0}, 6, 0, {ECT_MAILBOX_ERROR_SERVICE}, 0, 215},
        {"another vendor", {0x58, 0x0E, 0, 0, 2, 0}, 6, 0, {ECT_MAILBOX_ERROR_SERVICE}, 0, 215},
        {"no whole header", {VENDOR, 1}, 5, 0, {ECT_MAILBOX_ERROR_TOO_SHORT}, 0, 215},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t mail[ROOM] = {0};
        assert_int_equal(wire_mail_request(&w, 0, VOE, rows[i].request, rows[i].length), 1);
        const int length = wire_mail_receive(&w, 0, mail, sizeof mail);
        if (length < 0 || (mail[5] & 0x0F) != rows[i].type)
            fail_msg("%s: expected a mail of type %u, got %d bytes of type %u", rows[i].what, rows[i].type, length,
                     mail[5] & 0x0Fu);
        const bool good = rows[i].type == VOE ? length == rows[i].reply_length &&
                                                    memcmp(mail + MAIL_HEADER, rows[i].reply, rows[i].reply_length) == 0
                                              : mail[ERROR_AT] == rows[i].reply[0];
        if (!good || device()->peak != rows[i].peak)
            fail_msg("%s: another reply than expected, of %d bytes, or a peak of %d", rows[i].what, length,
                     device()->peak);
    }
}

static void coe_is_served_beside(void **state)
{
    static const uint8_t upload[10] = {0, 0x20, 0x40, 0x18, 0x10, 1}, read_peak[] = {VENDOR, 1, 0};
    uint8_t mail[ROOM];
    (void)state;
    assert_int_equal(wire_mail_request(&w, 0, VOE, read_peak, sizeof read_peak), 1);
    assert_int_equal(wire_mail_receive(&w, 0, mail, sizeof mail), 8);
    assert_int_equal(wire_mail_request(&w, 0, ECT_MAILBOX_TYPE_COE, upload, sizeof upload), 1);
    assert_int_equal(wire_mail_receive(&w, 0, mail, sizeof mail), 10);
    assert_int_equal(mail[5] & 0x0F, ECT_MAILBOX_TYPE_COE);
    assert_int_equal(ect_load_le16(mail + MAIL_HEADER + 6), 0x0E57);
}

int main(void)
{
    static const struct CMUnitTest tests[] = {
        {"VoE: each service has its reply; an unknown one, another vendor and a cut header get a mailbox error",
         each_request_has_its_reply, setup, teardown, NULL},
        {"VoE: a CoE request after a VoE request gets its reply", coe_is_served_beside, setup, teardown, NULL},
    };
    return cmocka_run_group_tests_name("The example's own mailbox protocol", tests, NULL, NULL);
}
