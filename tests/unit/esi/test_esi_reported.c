/* SPDX-License-Identifier: MIT */
/* SDO information of a clone: rights and lengths as reported by its slave, while the dictionary keeps its own. */
#include "rack.h"

#define PROPERTY(name, value) "<Property><Name>" name "</Name><Value>" value "</Value></Property>"
#define OBJECT(index, properties)                                                                                      \
    "<Object><Index>#x" index "</Index><Name>V</Name><Type>UDINT</Type><BitSize>32</BitSize><Info>"                    \
    "<DefaultData>78563412</DefaultData></Info><Flags><Access>rw</Access></Flags>" properties "</Object>"
#define CLONE(coe, properties)                                                                                         \
    ESI_DEVICE("<Profile><Dictionary><Objects>" OBJECT("2000", properties)                                             \
                   OBJECT("2001", "") "</Objects></Dictionary></Profile>" ESI_MAILBOX_SMS "<Mailbox><CoE " coe         \
                                      "/></Mailbox>" ESI_EEPROM)
#define INFO "SdoInfo='1'"

enum { RW = 0x003F, COE_INFO = 0x80, GET_ENTRY = 5, ENTRY = 6, GET_OBJECT = 3, OBJECT_DESCRIPTION = 4, GET_LIST = 1 };

/* Asks for the description of an object or an entry. @return length of the reply */
static int ask(rig_t *r, uint8_t what, uint16_t index, uint8_t *reply, uint16_t room)
{
    const uint8_t request[] = {0, COE_INFO, what, 0, 0, 0, (uint8_t)index, (uint8_t)(index >> 8), 0, 0};
    const uint16_t length = what == GET_ENTRY ? 10 : 8;
    return wire_coe(&r->wire, 0, request, length, reply, room);
}

static void entries(void **state)
{
    static const struct {
        const char *what, *text;
        uint16_t access, bits;
    } rows[] = {
        {"no property", CLONE(INFO, ""), RW, 32},
        {"its own rights", CLONE(INFO, "<Properties>" PROPERTY("SdoInfoAccess", "#x3F") "</Properties>"), RW, 32},
        {"other rights", CLONE(INFO, "<Properties>" PROPERTY("SdoInfoAccess", "#x47") "</Properties>"), 0x47, 32},
        {"another length", CLONE(INFO, "<Properties>" PROPERTY("SdoInfoBits", "0") "</Properties>"), RW, 0},
        {"another property", CLONE(INFO, "<Properties>" PROPERTY("Else", "7") "</Properties>"), RW, 32},
        {"rights and length",
         CLONE(INFO, "<Properties>" PROPERTY("SdoInfoAccess", "#x07") PROPERTY("SdoInfoBits", "16") "</Properties>"),
         0x07, 16},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        rig_t r;
        uint8_t reply[128];
        open_rig(&r, rows[i].text, PREOP);
        for (uint16_t index = 0x2000; index <= 0x2001; index++) {
            const bool own = index == 0x2001;
            assert_true(ask(&r, GET_ENTRY, index, reply, sizeof reply) >= 16);
            assert_int_equal(reply[2], ENTRY);
            const uint16_t bits = ect_load_le16(reply + 12), access = ect_load_le16(reply + 14);
            if (bits != (own ? 32 : rows[i].bits) || access != (own ? RW : rows[i].access))
                fail_msg("%s: %04X: %u bits, access %04X", rows[i].what, (unsigned int)index, (unsigned int)bits,
                         (unsigned int)access);
        }
        assert_true(ask(&r, GET_OBJECT, 0x2000, reply, sizeof reply) > 0);
        assert_int_equal(reply[2], OBJECT_DESCRIPTION);
        assert_int_equal(read_number(&r, 0x2000, 0), 0x12345678); /* the dictionary keeps its own */
        close_rig(&r);
    }
}

static void lists(void **state)
{
    rig_t r;
    uint8_t reply[128];
    const uint8_t request[] = {0, COE_INFO, GET_LIST, 0, 0, 0, 1, 0};
    (void)state;
    open_rig(&r, CLONE(INFO, "<Properties>" PROPERTY("SdoInfoBits", "8") "</Properties>"), PREOP);
    int length = wire_coe(&r.wire, 0, request, sizeof request, reply, sizeof reply);
    assert_true(length >= 12);
    assert_int_equal(reply[2], 2);
    wire_go(&r.wire, 0, ECT_STATE_INIT); /* resets the protocol */
    wire_go(&r.wire, 0, PREOP);
    assert_true(ask(&r, GET_ENTRY, 0x2000, reply, sizeof reply) >= 16);
    assert_int_equal(ect_load_le16(reply + 12), 8);
    close_rig(&r);
}

/* A list of mappable objects is that of the reported rights, in each of its fragments. */
static void fragments(void **state)
{
    enum { OBJECTS = 150, TX_MAPPABLE = 3, CONTINUED = 0x80, MAIL_HEAD = 6, INFO_HEAD = 6 };
    static char text[OBJECTS * 400];
    size_t used = (size_t)snprintf(text, sizeof text, "%s",
                                   ESI_HEAD "\n<Device Physics='YY'><Type ProductCode='#x1' RevisionNo='#x2'>DEV</Type>"
                                            "<Name>A device</Name><Profile><Dictionary><Objects>");
    for (unsigned int i = 0; i < OBJECTS; i++)
        used += (size_t)snprintf(text + used, sizeof text - used,
                                 OBJECT("%04X", "<Properties>" PROPERTY("SdoInfoAccess", "%s") "</Properties>"),
                                 0x2000 + i, i % 3 == 0 ? "#x3F" : "#xBF");
    (void)snprintf(text + used, sizeof text - used, "%s",
                   "</Objects></Dictionary></Profile>" ESI_MAILBOX_SMS "<Mailbox><CoE " INFO "/></Mailbox>" ESI_EEPROM
                   "</Device>" ESI_TAIL);
    rig_t r;
    uint8_t mail[128 + MAIL_HEAD];
    uint8_t *reply = mail + MAIL_HEAD;
    const uint8_t request[] = {0, COE_INFO, GET_LIST, 0, 0, 0, TX_MAPPABLE, 0};
    unsigned int expected = 1, count = 1;
    (void)state;
    open_rig(&r, text, PREOP);
    int length = wire_coe(&r.wire, 0, request, sizeof request, reply, 128);
    int at = INFO_HEAD + 2;
    for (;; count++) {
        assert_true(length >= at);
        for (; at < length; at += 2) {
            assert_int_equal(ect_load_le16(reply + at), 0x2000 + expected);
            expected += expected % 3 == 1 ? 1 : 2;
        }
        if ((reply[2] & CONTINUED) == 0)
            break;
        length = wire_mail_receive(&r.wire, 0, mail, sizeof mail);
        at = INFO_HEAD;
    }
    assert_int_equal(count, 2);
    assert_int_equal(expected, OBJECTS + 1);
    close_rig(&r);
}

static void without_information(void **state)
{
    rig_t r;
    uint8_t reply[128];
    (void)state;
    open_rig(&r, CLONE("", "<Properties>" PROPERTY("SdoInfoBits", "8") "</Properties>"), PREOP);
    assert_ptr_equal(ect_esi_reported(wire_device(&r.wire, 0)), wire_device(&r.wire, 0)->objects);
    (void)ask(&r, GET_ENTRY, 0x2000, reply, sizeof reply);
    assert_int_not_equal(reply[2], ENTRY);
    assert_int_equal(read_number(&r, 0x2000, 0), 0x12345678);
    close_rig(&r);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"a property of an entry changes its rights and its length in SDO information alone", entries, NULL, NULL,
         NULL},
        {"a list, and an entry after a restart of the mailbox", lists, NULL, NULL, NULL},
        {"a list of mappable objects has those of the reported rights, also in its second fragment", fragments, NULL,
         NULL, NULL},
        {"a twin without SDO information has none by a property", without_information, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("ESI: SDO information as reported", tests, NULL, NULL);
}
