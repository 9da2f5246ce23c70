/* SPDX-License-Identifier: MIT */
/* EoE of a twin of an ESI file: a master sets the address and pings it, through the mailbox. AoE of such a twin. */
#include "rack.h"

enum { SIZE = 128, MAIL_HEADER = 6, HEADER = 4, FRAME = 14 + 20 + 8 + 1400, LAST = 1 };

static const uint8_t ip[4] = {192, 168, 10, 20}, asking[4] = {192, 168, 10, 1}, made_mac[6] = {2, 0, 192, 168, 10, 20};

static void power_on(wire_t *w, const made_t *m)
{
    const ect_product_t *product = ect_esi_twin_product(m->twin);
    ect_twin_config_t config = ect_twin_default(product->device, product->plant);
    memset(w, 0, sizeof *w);
    wire_open_twins(w, &config, 1);
    wire_go(w, 0, ECT_STATE_PREOP);
}

static int exchange(wire_t *w, const uint8_t *data, unsigned int length, uint8_t reply[SIZE])
{
    assert_int_equal(wire_mail_request(w, 0, ECT_MAILBOX_TYPE_EOE, data, (uint16_t)length), 1);
    return wire_mail_receive(w, 0, reply, SIZE);
}

static void set_ip(wire_t *w)
{
    static const uint8_t set[] = {2, 1, 0, 0, 2, 0, 0, 0, 20, 10, 168, 192}, done[] = {3, 1, 0, 0};
    uint8_t reply[SIZE];
    assert_int_equal(exchange(w, set, sizeof set, reply), (int)sizeof done);
    assert_memory_equal(reply + MAIL_HEADER, done, sizeof done);
}

static void make_ping(uint8_t *frame)
{
    uint32_t sum = 0;
    memset(frame, 0x55, FRAME);
    memcpy(frame, made_mac, 6);
    frame[6] = 0;
    ect_store_be16(frame + 12, 0x0800);
    memset(frame + 14, 0, 28);
    frame[14] = 0x45;
    ect_store_be16(frame + 16, FRAME - 14);
    frame[22] = 64;
    frame[23] = 1;
    memcpy(frame + 26, asking, 4);
    memcpy(frame + 30, ip, 4);
    for (int i = 14; i < 34; i += 2)
        sum += ect_load_be16(frame + i);
    ect_store_be16(frame + 24, (uint16_t)~(sum + (sum >> 16)));
    frame[34] = 8; /* the checksum of the echo is wrong, and so is that of the reply */
}

static void ping_is_answered(void **state)
{
    made_t m = make_text("EoE", ESI_DEVICE(ESI_MAILBOX_SMS "<Mailbox><CoE/><EoE/></Mailbox>" ESI_EEPROM));
    uint8_t frame[FRAME];
    uint8_t back[FRAME + 32];
    uint8_t reply[SIZE];
    unsigned int got = 0;
    wire_t w;
    (void)state;
    power_on(&w, &m);
    set_ip(&w);
    make_ping(frame);
    for (unsigned int at = 0, fragment = 0; at < FRAME; fragment++) {
        const unsigned int bytes = FRAME - at <= 118 ? FRAME - at : 96;
        uint8_t data[SIZE] = {0, at + bytes == FRAME ? LAST : 0};
        const unsigned int units = at == 0 ? (FRAME + 31) / 32 : at / 32;
        ect_store_le16(data + 2, (uint16_t)(fragment | units << 6 | 1u << 12));
        memcpy(data + HEADER, frame + at, bytes);
        at += bytes;
        int length = exchange(&w, data, HEADER + bytes, reply);
        if (at < FRAME)
            assert_int_equal(length, -1);
        for (; at == FRAME && length > 0; length = wire_mail_receive(&w, 0, reply, SIZE)) {
            memcpy(back + got, reply + MAIL_HEADER + HEADER, (size_t)length - HEADER);
            got += (unsigned int)length - HEADER;
        }
    }
    assert_int_equal(got, FRAME);
    assert_memory_equal(back, frame + 6, 6);
    assert_memory_equal(back + 6, made_mac, 6);
    assert_memory_equal(back + 26, ip, 4);
    assert_int_equal(back[34], 0);
    assert_memory_equal(back + 38, frame + 38, FRAME - 38);
    wire_close(&w);
    free_made(&m);
}

#define OBJECT_HEAD                                                                                                    \
    ESI_HEAD "<Device Physics='YY'><Type ProductCode='#x1' RevisionNo='#x2'>DEV</Type><Name>A device</Name><Profile>"  \
             "<Dictionary><Objects><Object><Index>#x2000</Index><Name>V</Name><Type>STRING("
#define OBJECT_MIDDLE  ")</Type><BitSize>"
#define OBJECT_MAILBOX "</BitSize></Object></Objects></Dictionary></Profile>" ESI_MAILBOX_SMS "<Mailbox>"
#define OBJECT_TAIL    "</Mailbox>" ESI_EEPROM "</Device>" ESI_TAIL

/* A mailbox of less than 42 bytes cannot carry a unit: the file is wrong, and a note reports it. */
static void short_mailbox(void **state)
{
    static const char text[] =
        ESI_DEVICE("<Sm DefaultSize='41' StartAddress='#x1000' ControlByte='#x26' Enable='1'>MBoxOut</Sm>"
                   "<Sm DefaultSize='128' StartAddress='#x1080' ControlByte='#x22' Enable='1'>MBoxIn</Sm>"
                   "<Mailbox><EoE/></Mailbox>" ESI_EEPROM);
    made_t m = make_text("EoE", text);
    uint8_t reply[SIZE];
    static const uint8_t get[] = {6, 1, 0, 0};
    wire_t w;
    (void)state;
    assert_non_null(note_of(&m, "EoE answered with \"unsupported protocol\""));
    power_on(&w, &m);
    assert_int_equal(exchange(&w, get, sizeof get, reply), 4);
    assert_int_equal(reply[5] & 0x0F, ECT_MAILBOX_TYPE_ERROR);
    assert_int_equal(reply[8], ECT_MAILBOX_ERROR_PROTOCOL);
    wire_close(&w);
    free_made(&m);
}

static size_t instance_with(const char *protocols, unsigned int length)
{
    char text[2000];
    (void)snprintf(text, sizeof text, "%s%u%s%u%s%s%s", OBJECT_HEAD, length, OBJECT_MIDDLE, 8 * length, OBJECT_MAILBOX,
                   protocols, OBJECT_TAIL);
    made_t m = make_text("EoE", text);
    const size_t size = device_of(&m)->instance_size;
    free_made(&m);
    return size;
}

/* The address lies behind the objects, whose bytes may be of any number, and is aligned. */
static void place_behind_any_objects(void **state)
{
    const size_t own = instance_with("<EoE/><CoE/>", 3) - instance_with("<CoE/>", 3);
    (void)state;
    for (unsigned int length = 4; length <= 20; length++) {
        const size_t objects = instance_with("<CoE/>", length);
        const size_t place = instance_with("<EoE/><CoE/>", length) - own;
        assert_true(place >= objects && place < objects + sizeof(uint32_t) && place % sizeof(uint32_t) == 0);
    }
}

/* --- AoE ---------------------------------------------------------------------------------------------------------- */

enum { AMS = 32, TARGET_LAST = 5, COMMAND = 16, READ = 2, WRITE = 3, COE_GROUP = 0xF302, SETUP_GROUP = 1, NET_ID = 3 };

/* Sends an ADS command to the NetId 1.2.3.4.5.`id`. @return its result, or the error code of the AMS header */
static uint32_t ads(wire_t *w, uint8_t id, uint16_t command, uint32_t group, uint32_t offset, const void *data,
                    uint32_t length, uint8_t reply[SIZE])
{
    uint8_t mail[SIZE] = {1, 2, 3, 4, 5, id};
    const uint32_t sent = command == WRITE ? length : 0;
    ect_store_le16(mail + COMMAND, command);
    mail[COMMAND + 2] = 4;
    ect_store_le32(mail + COMMAND + 4, 12 + sent);
    ect_store_le32(mail + AMS, group);
    ect_store_le32(mail + AMS + 4, offset);
    ect_store_le32(mail + AMS + 8, length);
    if (sent > 0)
        memcpy(mail + AMS + 12, data, sent);
    assert_int_equal(wire_mail_request(w, 0, ECT_MAILBOX_TYPE_AOE, mail, (uint16_t)(AMS + 12 + sent)), 1);
    const int got = wire_mail_receive(w, 0, reply, SIZE);
    assert_true(got >= AMS);
    const uint32_t error = ect_load_le32(reply + MAIL_HEADER + 24);
    return error != 0 ? error : ect_load_le32(reply + MAIL_HEADER + AMS);
}

static uint32_t set_net_id(wire_t *w, uint8_t id)
{
    const uint8_t own[] = {1, 2, 3, 4, 5, id};
    uint8_t reply[SIZE];
    return ads(w, id, WRITE, SETUP_GROUP, NET_ID, own, sizeof own, reply);
}

static void expect_product(wire_t *w, uint8_t id, uint32_t result)
{
    uint8_t reply[SIZE];
    assert_int_equal(ads(w, id, READ, COE_GROUP, 0x10180002, NULL, 4, reply), result);
    if (result == 0)
        assert_int_equal(ect_load_le32(reply + MAIL_HEADER + AMS + 8), 1);
}

static void dictionary_by_ads(void **state)
{
    made_t m = make_text("AoE", ESI_DEVICE(ESI_MAILBOX_SMS "<Mailbox><AoE/><CoE/></Mailbox>" ESI_EEPROM));
    wire_t w;
    (void)state;
    power_on(&w, &m);
    expect_product(&w, 6, 0);
    assert_int_equal(set_net_id(&w, 7), 0);
    expect_product(&w, 7, 0);
    expect_product(&w, 6, 7);
    wire_close(&w);
    free_made(&m);
}

static void no_dictionary(void **state)
{
    made_t m = make_text("AoE", ESI_DEVICE(ESI_MAILBOX_SMS "<Mailbox><AoE/></Mailbox>" ESI_EEPROM));
    wire_t w;
    (void)state;
    power_on(&w, &m);
    expect_product(&w, 6, 0x702);
    assert_int_equal(set_net_id(&w, 7), 0);
    wire_close(&w);
    free_made(&m);
}

static void mailbox_of_61(void **state)
{
    static const char text[] =
        ESI_DEVICE("<Sm DefaultSize='128' StartAddress='#x1000' ControlByte='#x26' Enable='1'>MBoxOut</Sm>"
                   "<Sm DefaultSize='61' StartAddress='#x1080' ControlByte='#x22' Enable='1'>MBoxIn</Sm>"
                   "<Mailbox><AoE/></Mailbox>" ESI_EEPROM);
    made_t m = make_text("AoE", text);
    (void)state;
    assert_non_null(note_of(&m, "AoE answered with \"unsupported protocol\""));
    free_made(&m);
}

/* The NetId is neither among the objects nor among the modules that outlast a power cycle. */
static void net_id_of_a_rack(void **state)
{
    static char text[20000];
    static const char mailbox[] = "<Mailbox>", with_ads[] = "<Mailbox><AoE/>";
    const char *before = strstr(MANY_SLOTS, mailbox);
    rig_t r;
    (void)state;
    assert_in_range(snprintf(text, sizeof text, "%.*s%s%s", (int)(before - MANY_SLOTS), MANY_SLOTS, with_ads,
                             before + strlen(mailbox)),
                    1, sizeof text - 1);
    open_rig(&r, text, ECT_STATE_PREOP);
    assert_int_equal(set_net_id(&r.wire, 7), 0);
    expect_product(&r.wire, 7, 0);
    const uint32_t first = read_number(&r, 0xF030, 1);
    const uint8_t idents[] = {0x20, 1, 0, 0};
    uint8_t reply[SIZE];
    assert_int_equal(ads(&r.wire, 7, WRITE, COE_GROUP, 0xF0300001, idents, sizeof idents, reply), 0);
    assert_int_not_equal(first, OUT);
    assert_int_equal(read_number(&r, 0xF030, 1), OUT);
    expect_product(&r.wire, 7, 0);
    expect_product(&r.wire, 6, 7);
    close_rig(&r);
}

int main(void)
{
    static const struct CMUnitTest tests[] = {
        {"AoE: a master sets the NetId and reads the dictionary of the file", dictionary_by_ads, NULL, NULL, NULL},
        {"AoE: a file without CoE has no dictionary, and takes the NetId", no_dictionary, NULL, NULL, NULL},
        {"AoE: with a mailbox of 61 bytes it is refused, and a note reports it", mailbox_of_61, NULL, NULL, NULL},
        {"AoE: the NetId of a rack stays when AoE writes other modules", net_id_of_a_rack, NULL, NULL, NULL},
        {"EOE-035 EOE-041: a ping of 1400 bytes to the address that a master sets gets its reply", ping_is_answered,
         NULL, NULL, NULL},
        {"the place of the address is aligned, whatever the length of the objects", place_behind_any_objects, NULL,
         NULL, NULL},
        {"EOE-021: with a mailbox of 41 bytes EoE is refused, and a note reports it", short_mailbox, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests_name("EoE and AoE of ESI files", tests, NULL, NULL);
}
