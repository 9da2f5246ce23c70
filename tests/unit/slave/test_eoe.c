/* SPDX-License-Identifier: MIT */
/* Ethernet over EtherCAT: fragments of both directions, IP parameters, and their order with other mail. */
#include <string.h>

#include "seams/eoe.h"
#include "support/testdev.h"
#include "support/wire.h"

enum { SM0 = 0x1800, SM1 = 0x2000, MAIL_HEADER = 6, HEADER = 4, LAST = 1, STAMPED = 2, STAMP_WANTED = 4, UNIT = 32 };
enum { FRAGMENT, STAMP, SET_IP, SET_IP_DONE, SET_FILTER, SET_FILTER_DONE, GET_IP, GET_IP_DONE, GET_FILTER };
enum { NOTHING = -1, MAILBOX_ERROR = -2, QUEUE = 8, ROOM = 1600 };

/* A device whose host keeps the frames that it accepts, and has a queue of frames to send. */
typedef struct netdev {
    testdev_t base;
    ect_eoe_state_t eoe;
    uint8_t taken[ROOM];
    uint16_t taken_length;
    uint8_t taken_port;
    unsigned int taken_count, resets;
    bool full;
    uint16_t set_result;
    unsigned int sets, loads;
    uint8_t set_port, load_port;
    uint16_t queue[QUEUE]; /* lengths; a frame is filled by pattern() */
    unsigned int queued, given;
    uint8_t port;
} netdev_t;

static wire_t w;
static uint16_t size = 128;

static uint8_t pattern(unsigned int n)
{
    return (uint8_t)(n == 12 ? 0x81 : n == 13 ? 0 : n * 7 + n / 256); /* the type is that of a VLAN tag */
}

static void fill(uint8_t *frame, unsigned int length)
{
    for (unsigned int i = 0; i < length; i++)
        frame[i] = pattern(i);
}

static bool received(const ect_eoe_t *eoe, void *instance, uint8_t port, const uint8_t *frame, uint16_t length)
{
    netdev_t *d = instance;
    (void)eoe;
    if (d->full)
        return false;
    memcpy(d->taken, frame, length);
    d->taken_length = length;
    d->taken_port = port;
    d->taken_count++;
    return true;
}

static uint16_t fetch(const ect_eoe_t *eoe, void *instance, uint8_t *frame, uint8_t *port)
{
    netdev_t *d = instance;
    (void)eoe;
    if (d->given == d->queued)
        return 0;
    uint16_t length = d->queue[d->given++];
    fill(frame, length <= ECT_EOE_FRAME ? length : ECT_EOE_FRAME);
    *port = d->port;
    return length;
}

static uint16_t set(const ect_eoe_t *eoe, void *instance, uint8_t port, const ect_eoe_address_t *address)
{
    netdev_t *d = instance;
    (void)eoe;
    (void)address;
    d->sets++;
    d->set_port = port;
    return d->set_result;
}

/* The address of a port ends with its number. */
static void load(const ect_eoe_t *eoe, void *instance, uint8_t port)
{
    netdev_t *d = instance;
    (void)eoe;
    d->loads++;
    d->load_port = port;
    d->eoe.address = (ect_eoe_address_t){.known = ECT_EOE_HAS_IP, .ip = {192, 168, 10, port}};
}

static void reset(const ect_eoe_t *eoe, void *instance)
{
    netdev_t *d = instance;
    (void)eoe;
    d->resets++;
    d->given = d->queued = 0;
}

static ect_eoe_t entry = {ECT_EOE_PROTOCOL, offsetof(netdev_t, eoe), .received = received, .fetch = fetch,
                          .set = set,       .reset = reset};

static netdev_t *net(void)
{
    return (netdev_t *)(void *)testdev_of(&w, 0);
}

/* As a device announces a frame, at a time of its own. */
static void wake(void)
{
    ect_mailbox_wake(net()->base.host->ctx);
    ect_chain_wake(w.chain, 0);
}

/* The test device with EoE, mailboxes of `size` bytes, in PREOP. */
static void open_net(void)
{
    static const ect_protocol_t *protocols[TESTDEV_PROTOCOLS];
    static ect_device_t device;
    device = testdev_with(&entry.protocol, protocols, ECT_MAILBOX_EOE, sizeof(netdev_t));
    device.sm[0].start = SM0;
    device.sm[1].start = SM1;
    for (unsigned int n = 0; n < 2; n++)
        device.sm[n].length = device.sm[n].minimum = device.sm[n].maximum = size;
    device.boot_out = device.boot_in = (ect_boot_mailbox_t){0};
    wire_open_one(&w, &device);
    wire_go(&w, 0, ECT_STATE_PREOP);
}

static int setup(void **state)
{
    (void)state;
    size = 128;
    entry.dhcp = false;
    entry.ports = 0;
    entry.load = NULL;
    open_net();
    return 0;
}

static int teardown(void **state)
{
    (void)state;
    wire_close(&w);
    return 0;
}

/* --- mails -------------------------------------------------------------------------------------------------------- */

static void send_data(const uint8_t *data, unsigned int length)
{
    assert_int_equal(wire_mail_request(&w, 0, ECT_MAILBOX_TYPE_EOE, data, (uint16_t)length), 1);
}

/* @return bytes of the EoE data, NOTHING, or MAILBOX_ERROR with its detail in data[0] */
static int receive(uint8_t data[ROOM])
{
    uint8_t mail[ROOM];
    int length = wire_mail_receive(&w, 0, mail, sizeof mail);
    if (length < 0)
        return NOTHING;
    if ((mail[5] & 0x0F) == ECT_MAILBOX_TYPE_ERROR) {
        data[0] = mail[8];
        return MAILBOX_ERROR;
    }
    if ((mail[5] & 0x0F) != ECT_MAILBOX_TYPE_EOE)
        fail_msg("expected a mail of EoE, got type %u", mail[5] & 0x0Fu);
    memcpy(data, mail + MAIL_HEADER, (size_t)length);
    return length;
}

static void expect_mail(const char *what, const uint8_t *want, int want_length)
{
    uint8_t got[ROOM];
    int length = receive(got);
    if (length != want_length)
        fail_msg("%s: expected %d bytes, got %d", what, want_length, length);
    for (int i = 0; i < length; i++) {
        if (got[i] != want[i])
            fail_msg("%s: byte %d: expected %02X, got %02X", what, i, want[i], got[i]);
    }
}

static void expect_nothing(const char *what)
{
    uint8_t got[ROOM];
    int length = receive(got);
    if (length != NOTHING)
        fail_msg("%s: expected no mail, got %d bytes of type %X", what, length, got[0]);
}

static void expect_error(const char *what, uint8_t detail)
{
    uint8_t got[ROOM];
    int length = receive(got);
    if (length != MAILBOX_ERROR || got[0] != detail)
        fail_msg("%s: expected mailbox error %u, got %d with %u", what, detail, length, got[0]);
}

/* --- the master sends ----------------------------------------------------------------------------------------------
 */

typedef struct piece {
    unsigned int fragment, units, number, at, bytes, flags;
} piece_t;

static void send_piece(const piece_t *p)
{
    uint8_t data[ROOM] = {0x10, (uint8_t)p->flags}; /* port 1 */
    ect_store_le16(data + 2, (uint16_t)(p->fragment | p->units << 6 | p->number << 12));
    for (unsigned int i = 0; i < p->bytes; i++)
        data[HEADER + i] = pattern(p->at + i);
    send_data(data, HEADER + p->bytes);
    expect_nothing("EOE-014: after a fragment");
}

/* As SOEM and IgH send a frame, in pieces of at most `most` bytes. */
static void send_frame(unsigned int length, unsigned int most, unsigned int number)
{
    unsigned int fragment = 0;
    for (unsigned int at = 0; at < length; fragment++) {
        unsigned int bytes = length - at <= most ? length - at : most / UNIT * UNIT;
        unsigned int units = at == 0 ? (length + UNIT - 1) / UNIT : at / UNIT;
        send_piece(&(piece_t){fragment, units, number, at, bytes, at + bytes == length ? LAST : 0});
        at += bytes;
    }
}

static void expect_taken(const char *what, unsigned int count, unsigned int dropped, unsigned int length)
{
    const netdev_t *d = net();
    if (d->taken_count != count || d->eoe.dropped != dropped || d->eoe.received != count ||
        (count > 0 && d->taken_length != length))
        fail_msg("%s: expected %u frames, the last of %u bytes, %u dropped; got %u of %u, %u dropped", what, count,
                 length, dropped, d->taken_count, d->taken_length, d->eoe.dropped);
    for (unsigned int i = 0; count > 0 && i < length; i++) {
        if (d->taken[i] != pattern(i))
            fail_msg("%s: byte %u: expected %02X, got %02X", what, i, pattern(i), d->taken[i]);
    }
}

static void frames_of_each_length(void **state)
{
    static const struct {
        const char *what;
        unsigned int length;
        bool good;
    } rows[] = {{"EOE-012: one byte too short", 13, false},
                {"EOE-012: a header alone", 14, true},
                {"a whole unit", 32, true},
                {"one byte more than a unit", 33, true},
                {"all that fits into a mail", 118, true},
                {"one byte more", 119, true},
                {"twice 96", 192, true},
                {"EOE-013: without a tag", 1514, true},
                {"EOE-013: with a tag", 1518, true},
                {"EOE-013: too long", 1519, false}};
    unsigned int count = 0, dropped = 0, length = 0;
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        send_frame(rows[i].length, size - (unsigned int)(MAIL_HEADER + HEADER), (unsigned int)i & 15u);
        count += rows[i].good;
        dropped += !rows[i].good;
        length = rows[i].good ? rows[i].length : length;
        expect_taken(rows[i].what, count, dropped, length);
    }
    assert_int_equal(net()->taken_port, 1);
}

static void tag_makes_room(void **state)
{
    uint8_t data[ROOM] = {0};
    (void)state;
    wire_close(&w);
    size = 1024;
    open_net();
    ect_store_le16(data + 2, 48 << 6);
    send_data(data, HEADER + 992);
    data[1] = LAST;
    ect_store_le16(data + 2, 1 | 31 << 6);
    send_data(data, HEADER + 523);
    assert_int_equal(net()->eoe.received, 0); /* 1515 bytes, whose type is not that of a tag */
    assert_int_equal(net()->eoe.dropped, 1);
}

/* Each row: pieces of a frame of 200 bytes in 96, 96, 8; one of them changed. Then a good frame. */
static void broken_frames(void **state)
{
    static const piece_t good[3] = {{0, 7, 5, 0, 96, 0}, {1, 3, 5, 96, 96, 0}, {2, 6, 5, 192, 8, LAST}};
    static const struct {
        const char *what;
        unsigned int which;
        piece_t piece;
        unsigned int count, dropped;
    } rows[] = {
        {"EOE-003: another start", 1, {0, 7, 6, 0, 96, 0}, 0, 2},
        {"EOE-004: wrong fragment number", 1, {2, 3, 5, 96, 96, 0}, 0, 1},
        {"EOE-004: wrong frame number", 1, {1, 3, 6, 96, 96, 0}, 0, 1},
        {"EOE-004: wrong offset", 1, {1, 4, 5, 96, 96, 0}, 0, 1},
        {"EOE-015: a repeated fragment", 2, {1, 3, 5, 96, 96, 0}, 0, 1},
        {"EOE-007: more than announced", 0, {0, 5, 5, 0, 96, 0}, 0, 1},
        {"EOE-007: nothing announced", 0, {0, 0, 5, 0, 96, 0}, 0, 1},
        {"EOE-006: a unit too many announced", 0, {0, 8, 5, 0, 96, 0}, 1, 0},
        {"EOE-007: 63 units announced", 0, {0, 63, 5, 0, 96, 0}, 1, 0},
        {"EOE-008: a middle piece of 95", 1, {1, 3, 5, 96, 95, 0}, 0, 1},
        {"EOE-008: a middle piece of 64", 1, {1, 3, 5, 96, 64, 0}, 0, 1},
        {"EOE-008: an empty middle piece", 1, {1, 3, 5, 96, 0, 0}, 0, 1},
        {"EOE-010: 8 bytes of which 4 are a stamp", 2, {2, 6, 5, 192, 8, LAST | STAMPED}, 1, 0},
        {"EOE-010: 3 bytes with a stamp of 4", 2, {2, 6, 5, 192, 3, LAST | STAMPED}, 0, 1},
        {"EOE-010: a stamp before the last piece has no meaning", 1, {1, 3, 5, 96, 96, STAMPED}, 1, 0},
        {"EOE-011: a stamp is requested", 2, {2, 6, 5, 192, 8, LAST | STAMP_WANTED}, 1, 0},
        {"EOE-002: reserved bits", 2, {2, 6, 5, 192, 8, LAST | 0xF8}, 1, 0},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const bool stamped = (rows[i].piece.flags & (LAST | STAMPED)) == (LAST | STAMPED);
        wire_close(&w);
        open_net();
        for (unsigned int k = 0; k < 3; k++)
            send_piece(k == rows[i].which ? &rows[i].piece : &good[k]);
        expect_taken(rows[i].what, rows[i].count, rows[i].dropped, stamped ? 196 : 200);
        send_frame(200, 118, 9);
        expect_taken(rows[i].what, rows[i].count + 1, rows[i].dropped, 200);
    }
}

/* Every later fragment of the dropped frame, right or wrong, is part of it: none is counted, and none opens a frame. */
static void rest_is_swallowed(void **state)
{
    static const piece_t rest[] = {{2, 6, 5, 192, 96, 0}, {1, 3, 5, 96, 96, 0},     {3, 9, 6, 288, 95, 0},
                                   {63, 63, 5, 0, 0, 0},  {4, 12, 5, 384, 8, LAST}, {1, 3, 5, 96, 104, LAST}};
    (void)state;
    send_piece(&(piece_t){0, 13, 5, 0, 96, 0});
    send_piece(&(piece_t){2, 3, 5, 96, 96, 0}); /* a wrong number */
    for (size_t i = 0; i < sizeof rest / sizeof rest[0]; i++) {
        send_piece(&rest[i]);
        expect_taken("EOE-005: the rest of the frame", 0, 1, 0);
    }
    send_frame(60, 118, 6);
    expect_taken("EOE-005: the next frame", 1, 1, 60);
}

static void stamp_counts_in_the_size(void **state)
{
    (void)state;
    send_piece(&(piece_t){0, 3, 1, 0, 96, LAST | STAMPED}); /* 92 bytes and the stamp are three units */
    expect_taken("EOE-023: the announced size has room for the stamp", 1, 0, 92);
    send_piece(&(piece_t){0, 3, 2, 0, 98, LAST | STAMPED}); /* 94 bytes are three units, but not with the stamp */
    expect_taken("EOE-023: the announced size has none", 1, 1, 92);
}

/* The master is the switch: a device judges no destination, and returns no frame. */
static void any_destination(void **state)
{
    static const struct {
        const char *what;
        uint8_t to[6];
    } rows[] = {{"EOE-055: to all", {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF}},
                {"EOE-055: to a group", {1, 0, 0x5E, 0, 0, 0xFB}},
                {"EOE-055: to another station", {2, 9, 9, 9, 9, 9}}};
    (void)state;
    for (unsigned int i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t data[HEADER + 60] = {0, LAST};
        ect_store_le16(data + 2, (uint16_t)(2 << 6 | i << 12));
        memcpy(data + HEADER, rows[i].to, sizeof rows[i].to);
        send_data(data, sizeof data);
        expect_nothing(rows[i].what);
        if (net()->taken_count != i + 1 || memcmp(net()->taken, rows[i].to, sizeof rows[i].to) != 0)
            fail_msg("%s: expected a frame, got %u in all", rows[i].what, net()->taken_count);
    }
}

static void frame_without_an_end(void **state)
{
    (void)state;
    send_piece(&(piece_t){0, 3, 1, 0, 96, 0}); /* a frame of 96 bytes, all there */
    expect_taken("EOE-017: no last flag", 0, 0, 0);
    send_frame(60, 118, 2);
    expect_taken("EOE-017: the next frame", 1, 1, 60);
}

static void host_without_room(void **state)
{
    (void)state;
    net()->full = true;
    send_frame(60, 118, 1);
    expect_taken("EOE-016: no room", 0, 1, 0);
    net()->full = false;
    send_frame(60, 118, 2);
    expect_taken("EOE-016: room again", 1, 1, 60);
}

static void restart_forgets_pieces(void **state)
{
    (void)state;
    send_piece(&(piece_t){0, 7, 5, 0, 96, 0});
    net()->queue[net()->queued++] = 60;
    unsigned int resets = net()->resets;
    assert_int_equal(wire_al(&w, 0, ECT_STATE_INIT, NULL), ECT_STATE_INIT);
    wire_go(&w, 0, ECT_STATE_PREOP);
    assert_int_equal(net()->resets, resets + 1);
    expect_nothing("EOE-051: a frame not yet begun");
    send_piece(&(piece_t){1, 3, 5, 96, 96, 0});
    send_piece(&(piece_t){2, 6, 5, 192, 8, LAST});
    expect_taken("EOE-051: the rest of an earlier frame", 0, 0, 0);
}

/* --- the device sends ----------------------------------------------------------------------------------------------
 */

/* EOE-V6 to V12: the words of the headers, byte 0 first, and the data bytes. */
static void frames_of_the_device(void **state)
{
    static const struct {
        const char *what;
        uint16_t length, mailbox, number;
        unsigned int pieces;
        struct {
            uint8_t header[HEADER];
            uint16_t bytes;
        } first, second, last;
    } rows[] = {
        {"EOE-V6", 42, 128, 1, 1, {{0, 1, 0x80, 0x10}, 42}, {{0}, 0}, {{0}, 0}},
        {"EOE-V7", 118, 128, 1, 1, {{0, 1, 0x00, 0x11}, 118}, {{0}, 0}, {{0}, 0}},
        {"EOE-V8", 119, 128, 1, 2, {{0, 0, 0x00, 0x11}, 96}, {{0}, 0}, {{0, 1, 0xC1, 0x10}, 23}},
        {"EOE-V9", 192, 128, 2, 2, {{0, 0, 0x80, 0x21}, 96}, {{0}, 0}, {{0, 1, 0xC1, 0x20}, 96}},
        {"EOE-V10", 1514, 128, 3, 16, {{0, 0, 0x00, 0x3C}, 96}, {{0, 0, 0xC1, 0x30}, 96}, {{0, 1, 0x4F, 0x3B}, 74}},
        {"EOE-V11", 1518, 1024, 4, 2, {{0, 0, 0x00, 0x4C}, 992}, {{0}, 0}, {{0, 1, 0xC1, 0x47}, 526}},
        {"EOE-V12", 1514, 42, 5, 48, {{0, 0, 0x00, 0x5C}, 32}, {{0, 0, 0x41, 0x50}, 32}, {{0, 1, 0xEF, 0x5B}, 10}},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        unsigned int at = 0;
        wire_close(&w);
        size = rows[i].mailbox;
        open_net();
        net()->eoe.out_number = (uint8_t)(rows[i].number - 1);
        net()->queue[net()->queued++] = rows[i].length;
        wake();
        wire_poll(&w);
        for (unsigned int k = 0; k < rows[i].pieces; k++) {
            uint8_t data[ROOM];
            int length = receive(data) - HEADER;
            if (length <= 0)
                fail_msg("%s: expected %u mails, got %u", rows[i].what, rows[i].pieces, k);
            const bool last = k + 1 == rows[i].pieces && k > 0;
            const uint8_t *want = last ? rows[i].last.header : k == 0 ? rows[i].first.header : rows[i].second.header;
            const int bytes = last ? rows[i].last.bytes : k == 0 ? rows[i].first.bytes : rows[i].second.bytes;
            if (((k < 2 || last) && memcmp(data, want, HEADER) != 0) || length != bytes)
                fail_msg("%s, mail %u: expected %02X %02X %02X %02X with %d bytes, got %02X %02X %02X %02X with %d",
                         rows[i].what, k, want[0], want[1], want[2], want[3], bytes, data[0], data[1], data[2], data[3],
                         length);
            for (int n = 0; n < length; n++, at++)
                assert_int_equal(data[HEADER + n], pattern(at));
        }
        expect_nothing(rows[i].what);
        assert_int_equal(at, rows[i].length);
        assert_int_equal(net()->eoe.sent, 1);
    }
}

static void frame_numbers(void **state)
{
    (void)state;
    net()->port = 1;
    for (unsigned int i = 1; i <= 20; i++) {
        uint8_t data[ROOM];
        net()->queue[0] = 60;
        net()->given = 0;
        net()->queued = 1;
        wake();
        wire_poll(&w);
        assert_int_equal(receive(data), HEADER + 60);
        assert_int_equal(data[0], 0x10); /* EOE-026: the port */
        assert_int_equal(data[3] >> 4, i % 16);
    }
}

/* All of the first frame, then all of the second one, despite a frame of the master in between. */
static void one_frame_at_a_time(void **state)
{
    uint8_t data[ROOM];
    (void)state;
    net()->queue[0] = net()->queue[1] = 200;
    net()->queued = 2;
    wake();
    wire_poll(&w);
    for (unsigned int mail = 0; mail < 4; mail++) {
        if (mail == 1) { /* its own mail is fetched first, so the next one waits already */
            uint8_t frame[HEADER + 60] = {0, LAST, 2 << 6 & 0xFF};
            assert_int_equal(wire_mail_request(&w, 0, ECT_MAILBOX_TYPE_EOE, frame, sizeof frame), 1);
        }
        assert_true(receive(data) > HEADER);
        assert_int_equal(data[2] & 0x3F, mail % 2);
        assert_int_equal(data[3] >> 4, 1 + mail / 2);
        assert_int_equal(data[1] & LAST, mail % 2 == 1);
    }
    expect_nothing("EOE-025: after both");
    assert_int_equal(net()->taken_count, 1);
}

static void frames_that_cannot_be_sent(void **state)
{
    static const uint16_t lengths[] = {13, 1519, 2016, 2017, UINT16_MAX, 60};
    uint8_t data[ROOM];
    (void)state;
    memcpy(net()->queue, lengths, sizeof lengths);
    net()->queued = sizeof lengths / sizeof lengths[0];
    wake();
    wire_poll(&w);
    assert_int_equal(receive(data), HEADER + 60);
    expect_nothing("after the only good frame");
    assert_int_equal(net()->eoe.dropped, net()->queued - 1);
}

/* EOE-052, EOE-053: with a queue of frames that never ends, each request is answered by the next mail. */
static void other_mail_comes_between(void **state)
{
    static const uint8_t get_ip[HEADER] = {GET_IP};
    uint8_t data[ROOM];
    (void)state;
    for (unsigned int i = 0; i < 20; i++) {
        netdev_t *d = net();
        d->queue[0] = 1514;
        d->given = 0;
        d->queued = 1;
        wake();
        wire_poll(&w);
        const uint8_t upload[10] = {0, 0x20, 0x40, 0x18, 0x10, 1};
        uint8_t mail[MAIL_HEADER + sizeof upload];
        assert_int_equal(wire_mail_request(&w, 0, ECT_MAILBOX_TYPE_COE, upload, sizeof upload), 1);
        assert_true(receive(data) > HEADER); /* the fragment from before */
        assert_int_equal(wire_mail_receive(&w, 0, mail, sizeof mail), 10);
        assert_int_equal(mail[5] & 0x0F, ECT_MAILBOX_TYPE_COE);
        assert_true(receive(data) > HEADER); /* the frame goes on */
    }
    send_data(get_ip, sizeof get_ip);
    assert_true(receive(data) > HEADER);
    assert_int_equal(receive(data), 8);
    assert_int_equal(data[0], GET_IP_DONE);
}

/* Announcements while a protocol always has a mail, of any number. */
static void announcements_are_not_forgotten(void **state)
{
    uint8_t data[ROOM];
    (void)state;
    for (unsigned int more = 0; more < 600; more++) {
        netdev_t *d = net();
        d->queue[0] = 150; /* two mails */
        d->given = 0;
        d->queued = 1;
        wake();
        wire_poll(&w);
        for (unsigned int i = 0; i < more; i++)
            ect_mailbox_wake(d->base.host->ctx);
        for (unsigned int mail = 0; mail < 2; mail++) {
            if (receive(data) <= HEADER)
                fail_msg("with %u announcements more mail %u does not come", more, mail);
        }
        assert_int_equal(receive(data), NOTHING);
    }
}

static unsigned int later_calls;

static uint16_t later_request(const ect_protocol_t *self, ect_slave_t *s, const uint8_t *data, uint16_t length)
{
    (void)self;
    (void)s;
    (void)data;
    (void)length;
    return ECT_MAILBOX_OK;
}

static bool later_next(const ect_protocol_t *self, ect_slave_t *s, bool send)
{
    (void)self;
    (void)s;
    (void)send;
    later_calls++;
    return false;
}

/* The mailbox calls the protocols in their order, until one of them has a mail. */
static void without_a_frame_others_send(void **state)
{
    static const ect_protocol_t later = {
        .type = ECT_MAILBOX_TYPE_VOE, .states = ECT_IN_PREOP_AND_ABOVE, .request = later_request, .next = later_next};
    static const ect_protocol_t *list[TESTDEV_PROTOCOLS + 1];
    const ect_protocol_t *known[TESTDEV_PROTOCOLS];
    uint8_t data[ROOM];
    size_t count = 0;
    (void)state;
    wire_close(&w);
    ect_device_t device = testdev_with(&entry.protocol, known, ECT_MAILBOX_EOE | ECT_MAILBOX_VOE, sizeof(netdev_t));
    for (; known[count] != NULL; count++)
        list[count] = known[count];
    list[count] = &later;
    device.protocols = list;
    wire_open_one(&w, &device);
    wire_go(&w, 0, ECT_STATE_PREOP);
    later_calls = 0;
    wake();
    wire_poll(&w);
    assert_true(later_calls > 0);
    later_calls = 0;
    net()->queue[0] = 150; /* two mails */
    net()->queued = 1;
    wake();
    wire_poll(&w);
    assert_int_equal(later_calls, 0);
    assert_true(receive(data) > HEADER);
    assert_true(receive(data) > HEADER);
    wire_poll(&w);
    assert_true(later_calls > 0);
}

/* --- the address -------------------------------------------------------------------------------------------------- */

#define V1 2, 1, 0, 0, 0x0E, 0, 0, 0, 0x14, 0x0A, 0xA8, 0xC0, 0, 0xFF, 0xFF, 0xFF, 1, 0x0A, 0xA8, 0xC0

static void settings(void **state)
{
    static const uint8_t set_packed[] = {V1};
    static const uint8_t set_full[62] = {2, 0,    0,    0,    0x0E, 0, 0,    0,    0,    0, 0,    0,    0,
                                         0, 0x14, 0x0A, 0xA8, 0xC0, 0, 0xFF, 0xFF, 0xFF, 1, 0x0A, 0xA8, 0xC0};
    static const uint8_t set_done[] = {3, 1, 0, 0}, get[] = {6, 1, 0, 0};
    static const uint8_t nothing[] = {7, 1, 0, 0, 0, 0, 0, 0};
    static const uint8_t got[] = {7,    1,    0,    0,    0x0F, 0, 0,    0,    2,    0, 0x5E, 0x10, 0x20,
                                  0x30, 0x14, 0x0A, 0xA8, 0xC0, 0, 0xFF, 0xFF, 0xFF, 1, 0x0A, 0xA8, 0xC0};
    static const struct {
        const char *what;
        const uint8_t *mail;
        unsigned int length;
    } rows[] = {{"EOE-V1: packed", set_packed, sizeof set_packed}, {"EOE-V3: full layout", set_full, sizeof set_full}};
    static const uint8_t mac[6] = {2, 0, 0x5E, 0x10, 0x20, 0x30}, ip[4] = {192, 168, 10, 20};
    (void)state;
    for (size_t i = 0; i < 2; i++) {
        wire_close(&w);
        open_net();
        send_data(get, sizeof get);
        expect_mail("EOE-036: nothing known", nothing, sizeof nothing);
        send_data(rows[i].mail, rows[i].length);
        expect_mail(rows[i].what, set_done, sizeof set_done);
        assert_memory_equal(net()->eoe.address.ip, ip, 4);
        memcpy(net()->eoe.address.mac, mac, 6);
        net()->eoe.address.known |= ECT_EOE_HAS_MAC;
        assert_int_equal(wire_al(&w, 0, ECT_STATE_INIT, NULL), ECT_STATE_INIT);
        wire_go(&w, 0, ECT_STATE_PREOP);
        send_data(get, sizeof get);
        expect_mail("EOE-V4, EOE-040: after a restart of the mailbox", got, sizeof got);
    }
}

static void addresses_of_ports(void **state)
{
    (void)state;
    entry.ports = 2;
    for (uint8_t port = 0; port <= 2; port++) {
        const uint8_t set_ip[] = {(uint8_t)(port << 4 | 2), 1, 0, 0, 2, 0, 0, 0, 4, 3, 2, 1};
        const uint8_t set_done[] = {(uint8_t)(port << 4 | 3), 1, 0, 0}, get[] = {(uint8_t)(port << 4 | 6), 1, 0, 0};
        const uint8_t known[] = {(uint8_t)(port << 4 | 7), 1, 0, 0, 2, 0, 0, 0, 4, 3, 2, 1};
        const uint8_t loaded[] = {(uint8_t)(port << 4 | 7), 1, 0, 0, 2, 0, 0, 0, port, 10, 168, 192};
        entry.load = NULL;
        send_data(set_ip, sizeof set_ip);
        expect_mail("EOE-039: set IP of a port", set_done, sizeof set_done);
        assert_int_equal(net()->sets, port + 1);
        assert_int_equal(net()->set_port, port);
        send_data(get, sizeof get);
        expect_mail("EOE-040: the address as it was set", known, sizeof known);
        entry.load = load;
        send_data(get, sizeof get);
        expect_mail("EOE-040: the address that the device has loaded", loaded, sizeof loaded);
        assert_int_equal(net()->loads, port + 1);
        assert_int_equal(net()->load_port, port);
    }
}

static void names(void **state)
{
    static const uint8_t cut[] = {2, 1, 0, 0, 0x20, 0, 0, 0, 'd', 'r', 'i', 'v', 'e'};
    static const uint8_t done[] = {3, 1, 0, 0}, get[] = {6, 1, 0, 0};
    uint8_t want[8 + ECT_EOE_NAME] = {7, 1, 0, 0, 0x20, 0, 0, 0, 'd', 'r', 'i', 'v', 'e'};
    uint8_t data[ROOM];
    (void)state;
    send_data(cut, sizeof cut);
    expect_mail("EOE-034: a name that is cut short", done, sizeof done);
    send_data(get, sizeof get);
    expect_mail("EOE-034: it returns with 32 bytes", want, sizeof want);
    wire_close(&w);
    size = ECT_EOE_MAILBOX_LEAST;
    open_net();
    send_data(cut, sizeof cut);
    expect_mail("in the smallest mailbox", done, sizeof done);
    send_data(get, sizeof get);
    assert_int_equal(receive(data), 8);
    assert_int_equal(data[4], 0); /* no room for 32 bytes */
}

static void refusals(void **state)
{
    static const struct {
        const char *what;
        uint8_t mail[24];
        uint8_t length, ports;
        uint16_t host; /* result of the device */
        bool dhcp;
        uint8_t reply[4];
        unsigned int sets;
    } rows[] = {
        {"EOE-032: without flags", {2, 1}, 4, 0, 0, false, {3, 1, 1, 0}, 0},
        {"EOE-032: a field beyond the mail", {2, 1, 0, 0, 2, 0, 0, 0, 1, 2, 3}, 11, 0, 0, false, {3, 1, 1, 0}, 0},
        {"EOE-034: a name of no byte", {2, 1, 0, 0, 0x20, 0, 0, 0}, 8, 0, 0, false, {3, 1, 1, 0}, 0},
        {"EOE-033: a MAC alone", {2, 1, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 0, 1}, 14, 0, 0, false, {3, 1, 2, 2}, 0},
        {"EOE-033: with DHCP", {2, 1, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 0, 1}, 14, 0, 0, true, {3, 1, 0, 0}, 1},
        {"EOE-035: the host's result", {V1}, 20, 0, ECT_EOE_NO_IP, false, {3, 1, 1, 2}, 1},
        {"EOE-V5: get filter", {8, 1}, 4, 0, 0, false, {9, 1, 1, 4}, 0},
        {"EOE-037: set filter", {4, 1, 0, 0, 0, 0}, 6, 0, 0, false, {5, 1, 1, 4}, 0},
        {"EOE-038: type A", {0x0A, 1}, 4, 0, 0, false, {0x0A, 1, 2, 0}, 0},
        {"EOE-038: type F", {0x0F, 1}, 4, 0, 0, false, {0x0F, 1, 2, 0}, 0},
        {"EOE-039: set IP of port 2 of one", {0x22, 1}, 4, 0, 0, false, {0x23, 1, 1, 0}, 0},
        {"EOE-039: get IP of port 2 of one", {0x26, 1}, 4, 1, 0, false, {0x27, 1, 1, 0}, 0},
        {"EOE-039: get filter of port 3 of two", {0x38, 1}, 4, 2, 0, false, {0x39, 1, 1, 0}, 0},
        {"EOE-039: get filter of port 2 of two", {0x28, 1}, 4, 2, 0, false, {0x29, 1, 1, 4}, 0},
    };
    static const ect_eoe_address_t none;
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        entry.dhcp = rows[i].dhcp;
        entry.ports = rows[i].ports;
        net()->set_result = rows[i].host;
        net()->sets = 0;
        net()->eoe.address = none;
        send_data(rows[i].mail, rows[i].length);
        expect_mail(rows[i].what, rows[i].reply, 4);
        if (net()->sets != rows[i].sets)
            fail_msg("%s: expected %u calls of the device, got %u", rows[i].what, rows[i].sets, net()->sets);
        if (rows[i].reply[2] != 0 && memcmp(&net()->eoe.address, &none, sizeof none) != 0)
            fail_msg("%s: the address has changed", rows[i].what);
    }
}

static void ignored_types(void **state)
{
    (void)state;
    for (uint8_t type = 1; type <= 9; type = (uint8_t)(type + 2)) {
        const uint8_t mail[8] = {type, 1};
        send_data(mail, sizeof mail);
        expect_nothing("EOE-038: a reply in the place of a request");
    }
}

static void short_mail(void **state)
{
    static const uint8_t mail[3] = {0, 1, 0};
    (void)state;
    send_data(mail, sizeof mail);
    expect_error("EOE-001: three bytes", ECT_MAILBOX_ERROR_TOO_SHORT);
}

int main(void)
{
    static const struct CMUnitTest tests[] = {
        {"EOE-009 EOE-012 EOE-013: frames of each length arrive whole", frames_of_each_length, setup, teardown, NULL},
        {"EOE-013: 1515 bytes without a VLAN tag are dropped", tag_makes_room, setup, teardown, NULL},
        {"EOE-002..011 EOE-015: a wrong fragment affects only its own frame", broken_frames, setup, teardown, NULL},
        {"EOE-005: after a wrong fragment the rest of the frame is discarded", rest_is_swallowed, setup, teardown,
         NULL},
        {"EOE-023: the announced size includes the time stamp", stamp_counts_in_the_size, setup, teardown, NULL},
        {"EOE-055: frames to all, to groups and to other stations reach the device, none returns", any_destination,
         setup, teardown, NULL},
        {"EOE-017: a frame without an end does not disturb the next", frame_without_an_end, setup, teardown, NULL},
        {"EOE-016: a frame that does not fit into the device is dropped", host_without_room, setup, teardown, NULL},
        {"EOE-051: INIT to PREOP discards incomplete frames", restart_forgets_pieces, setup, teardown, NULL},
        {"EOE-020 EOE-022 EOE-V6..V12: fragments of the device", frames_of_the_device, setup, teardown, NULL},
        {"EOE-024 EOE-026: frame numbers count modulo 16, fragments name the port", frame_numbers, setup, teardown,
         NULL},
        {"EOE-025: fragments of two frames of the device are not mixed", one_frame_at_a_time, setup, teardown, NULL},
        {"EOE-013 EOE-027: frames that the device must not send are dropped", frames_that_cannot_be_sent, setup,
         teardown, NULL},
        {"EOE-052 EOE-053: an endless queue of frames delays no reply", other_mail_comes_between, setup, teardown,
         NULL},
        {"EOE-053: without a frame the protocols after EoE may send", without_a_frame_others_send, setup, teardown,
         NULL},
        {"EOE-053: 0 to 600 announcements while a frame is under way do not stop it", announcements_are_not_forgotten,
         setup, teardown, NULL},
        {"EOE-030 EOE-031 EOE-036 EOE-040 EOE-V1 EOE-V2 EOE-V3 EOE-V4: the address in both layouts", settings, setup,
         teardown, NULL},
        {"EOE-039 EOE-040: the device gets the port whose address is set or read", addresses_of_ports, setup, teardown,
         NULL},
        {"EOE-034: names of 1 to 32 bytes", names, setup, teardown, NULL},
        {"EOE-032..039 EOE-V5: refusals change nothing", refusals, setup, teardown, NULL},
        {"EOE-038: replies of a master are ignored", ignored_types, setup, teardown, NULL},
        {"EOE-001: a mail without a whole header", short_mail, setup, teardown, NULL},
    };
    return cmocka_run_group_tests_name("EoE", tests, NULL, NULL);
}
