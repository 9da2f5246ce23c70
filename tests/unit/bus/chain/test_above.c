/* SPDX-License-Identifier: MIT */
/* Faults above the wire: aborted transfers, mails, AL status, sizes, emergencies (bus/chain/above.h). */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bus/chain/chain.h"
#include "support/testdev.h"
#include "support/wire.h"

enum { TWINS = 2, ECT_ABOVE = 8, ROOM = 256 };

static int setup(void **state)
{
    wire_t *w = calloc(1, sizeof *w);
    const ect_device_t *devices[TWINS] = {&testdev, &testdev};
    wire_open(w, devices, TWINS);
    wire_configure_mailbox(w, 1);
    wire_go(w, 1, 2);
    *state = w;
    return 0;
}

static int teardown(void **state)
{
    wire_close(*state);
    free(*state);
    return 0;
}

static const char *try_fault(wire_t *w, const char *text)
{
    char message[ECT_FAULT_MESSAGE];
    ect_fault_t fault;
    if (!ect_fault_parse(text, &fault, message))
        fail_msg("'%s': %s", text, message);
    const char *why = ect_chain_fault(w->chain, &fault, w->now_ns);
    wire_poll(w);
    return why;
}

static void set(wire_t *w, const char *text)
{
    const char *why = try_fault(w, text);
    if (why)
        fail_msg("'%s': %s", text, why);
}

static void keep_still(wire_t *w)
{
    (void)w;
}

static uint32_t write_u32(wire_t *w, uint32_t value)
{
    uint8_t data[4];
    ect_store_le32(data, value);
    return wire_sdo_download(w, 1, 0x2000, 0, false, data, 4);
}

static uint32_t read_octets(wire_t *w)
{
    uint8_t data[1100];
    size_t size = sizeof data;
    return wire_sdo_upload(w, 1, 0x2002, 0, false, data, &size);
}

/* --- aborts ------------------------------------------------------------------------------------------------------- */

static void aborts(void **state)
{
    static const struct {
        const char *fault;
        uint32_t code[4]; /* of four successive downloads of 2000h */
    } rows[] = {
        {"abort 0x2000 0x06040043 slave 2", {0x06040043, 0x06040043, 0x06040043, 0x06040043}},
        {"abort 0x2000:0 0x08000020 2nd slave 2", {0, 0x08000020, 0, 0}},
        {"abort 0x2000 0x08000020 every 3 slave 2", {0, 0, 0x08000020, 0}},
        {"abort 0x2000 0x08000020 download 1st slave 2", {0x08000020, 0, 0, 0}},
        {"abort 0x2000 0x08000020 upload slave 2", {0, 0, 0, 0}},
        {"abort 0x2000:1 0x08000020 slave 2", {0, 0, 0, 0}},
        {"abort 0x2001 0x08000020 slave 2", {0, 0, 0, 0}},
        {"abort 0x2000 0x08000020 step 2 slave 2", {0, 0, 0, 0}},
        {"abort 0x2000 0x08000020 slave 1", {0, 0, 0, 0}},
    };
    wire_t *w = *state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        set(w, rows[i].fault);
        for (uint32_t n = 0; n < 4; n++) {
            uint32_t before = testdev_of(w, 1)->u32, value = 100 * (uint32_t)i + n + 1;
            uint32_t code = write_u32(w, value);
            if (code != rows[i].code[n])
                fail_msg("%s: download %u: expected 0x%08X, got 0x%08X", rows[i].fault, n + 1, rows[i].code[n], code);
            assert_int_equal(testdev_of(w, 1)->u32, code != 0 ? before : value); /* the device never gets it */
        }
        ect_chain_fault_end(w->chain, 0);
    }
}

/* Each fault has its own object; the first fault that matches a transfer applies. */
static void aborts_of_several(void **state)
{
    wire_t *w = *state;
    set(w, "abort 0x2002 0x08000022 slave 2");
    set(w, "abort 0x2000 0x08000020 slave 2");
    set(w, "abort 0x2000 0x08000021 slave 2");
    assert_int_equal(write_u32(w, 1), 0x08000020);
    assert_int_equal(read_octets(w), 0x08000022);
}

/* The stack reads a request of a fault in one piece or in several: each is a piece of the same request. */
static void aborts_in_pieces(void **state)
{
    static const uint8_t upload[] = {0x00, 0x20, 0x40, 0x00, 0x20, 0, 0, 0, 0, 0};
    enum { START = 0x1000, HALF = 64 };
    wire_t *w = *state;
    const ect_pdi_t *pdi = ect_chain_slave(w->chain, 1)->config.pdi;
    uint8_t whole[2 * HALF], pieces[2 * HALF];
    set(w, "abort 0x2000 0x08000020 slave 2");
    w->poll = keep_still;
    assert_int_equal(wire_mail_request(w, 1, 3, upload, sizeof upload), 1);
    assert_int_equal(pdi->read(pdi->ctx, START, whole, sizeof whole - 1), 0); /* the last byte would empty the buffer */
    assert_int_equal(ect_load_le16(whole + 9), 0);                            /* a missing object, in place of 2000h */
    for (uint16_t size = 1; size < HALF; size++) {
        for (uint16_t at = 0; at + size < 2 * HALF; at = (uint16_t)(at + size))
            assert_int_equal(pdi->read(pdi->ctx, (uint16_t)(START + at), pieces + at, size), 0);
        assert_memory_equal(pieces, whole, (2u * HALF - 1) / size * size);
    }
    w->poll = NULL;
}

/* 1000 bytes take a start and some segments; the second request of the transfer is the first segment. */
static void aborts_in_the_middle(void **state)
{
    wire_t *w = *state;
    for (unsigned int step = 1; step <= 4; step++) {
        char text[ECT_FAULT_TEXT];
        uint8_t data[1000] = {0};
        snprintf(text, sizeof text, "abort 0x2002:0 0x08000021 step %u slave 2", step);
        set(w, text);
        assert_int_equal(read_octets(w), 0x08000021);
        assert_int_equal(wire_sdo_download(w, 1, 0x2002, 0, false, data, sizeof data), 0x08000021);
        ect_chain_fault_end(w->chain, 0);
        assert_int_equal(read_octets(w), 0);
    }
}

/* The master that gets no reply in time sends the same request again, with the same counter. */
static void repeated_request(void **state)
{
    static const uint8_t mail[16] = {10, 0, 0, 0, 0, 0x33, 0, 0x20, 0x40, 0x00, 0x20, 0};
    wire_t *w = *state;
    set(w, "abort 0x2000 0x08000020 1st slave 2");
    for (unsigned int i = 0; i < 2; i++) {
        uint8_t reply[ROOM];
        assert_int_equal(wire_mail_send(w, 1, mail, sizeof mail), 1);
        assert_int_equal(wire_mail_receive(w, 1, reply, sizeof reply), 10);
        assert_int_equal(reply[8], 0x80);
        assert_int_equal(ect_load_le16(reply + 9), 0x2000);
        assert_int_equal(ect_load_le32(reply + 12), 0x08000020);
    }
}

enum { TAG = 9 };

/* Counts the transfers of 2000h. */
static void begin_count(wire_t *w)
{
    const ect_fault_t count = {
        .kind = ECT_FAULT_COUNT, .slave = 2, .tag = TAG, .object = {.named = true, .index = 0x2000}};
    assert_null(ect_chain_fault(w->chain, &count, w->now_ns));
}

/* A mail counts as a request of an SDO by its type, its service and its length. */
static void requests_of_an_SDO(void **state)
{
    static const struct {
        const char *title;
        uint8_t mail[16];
        bool counts;
    } rows[] = {
        {"an upload", {10, 0, 0, 0, 0, 0x03, 0, 0x20, 0x40, 0x00, 0x20}, true},
        {"a download", {10, 0, 0, 0, 0, 0x03, 0, 0x20, 0x23, 0x00, 0x20, 0, 1}, true},
        {"too short by a byte", {9, 0, 0, 0, 0, 0x03, 0, 0x20, 0x40, 0x00, 0x20}, false},
        {"an SDO response", {10, 0, 0, 0, 0, 0x03, 0, 0x30, 0x40, 0x00, 0x20}, false},
        {"an emergency", {10, 0, 0, 0, 0, 0x03, 0, 0x10, 0x40, 0x00, 0x20}, false},
        {"an SDO information", {10, 0, 0, 0, 0, 0x03, 0, 0x80, 0x40, 0x00, 0x20}, false},
        {"FoE", {10, 0, 0, 0, 0, 0x04, 0, 0x20, 0x40, 0x00, 0x20}, false},
        {"an abort", {10, 0, 0, 0, 0, 0x03, 0, 0x20, 0x80, 0x00, 0x20}, false},
        {"another object", {10, 0, 0, 0, 0, 0x03, 0, 0x20, 0x40, 0x01, 0x20}, false},
    };
    wire_t *w = *state;
    begin_count(w);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const uint64_t before = ect_chain_fault_seen(w->chain, TAG);
        uint8_t reply[ROOM];
        assert_int_equal(wire_mail_send(w, 1, rows[i].mail, sizeof rows[i].mail), 1);
        (void)wire_mail_receive(w, 1, reply, sizeof reply);
        const uint64_t counted = ect_chain_fault_seen(w->chain, TAG) - before;
        if (counted != rows[i].counts)
            fail_msg("%s: counted %u times", rows[i].title, (unsigned int)counted);
    }
}

/* A fault of one request is over when the stack has read the request, before any reply. */
static void over_with_its_request(void **state)
{
    wire_t *w = *state;
    uint8_t bytes[16];
    set(w, "abort 0x2000 0x08000020 1st slave 2");
    const ect_pdi_t *pdi = ect_chain_slave(w->chain, 1)->config.pdi;
    w->poll = keep_still;
    assert_int_equal(wire_mail_request(w, 1, 3, (uint8_t[]){0x00, 0x20, 0x40, 0x00, 0x20, 0, 0, 0, 0, 0}, 10), 1);
    assert_non_null(ect_chain_fault_at(w->chain, 0));
    assert_int_equal(pdi->read(pdi->ctx, 0x1000, bytes, sizeof bytes), 0);
    assert_null(ect_chain_fault_at(w->chain, 0));
    w->poll = NULL;
}

/* A mail without a counter is never a repeated one. A restart forgets the counter. */
static void repeated_counters(void **state)
{
    static const struct {
        uint8_t counter;
        bool restarts;
        bool counts;
    } rows[] = {{0, false, true}, {0, false, true},  {1, false, true}, {1, false, false}, {2, false, true},
                {1, false, true}, {7, false, true},  {7, true, true},  {7, false, false}, {0, false, true},
                {7, false, true}, {7, false, false}, {1, true, true},  {1, true, true}};
    wire_t *w = *state;
    begin_count(w);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const uint8_t counter = (uint8_t)(rows[i].counter << 4 | 3);
        const uint8_t mail[16] = {10, 0, 0, 0, 0, counter, 0, 0x20, 0x40, 0x00, 0x20};
        const uint64_t before = ect_chain_fault_seen(w->chain, TAG);
        uint8_t reply[ROOM];
        if (rows[i].restarts) {
            set(w, "reset slave 2");
            wire_assign_stations(w);
            wire_configure_mailbox(w, 1);
            wire_go(w, 1, ECT_STATE_PREOP);
        }
        assert_int_equal(wire_mail_send(w, 1, mail, sizeof mail), 1);
        (void)wire_mail_receive(w, 1, reply, sizeof reply);
        if (ect_chain_fault_seen(w->chain, TAG) - before != rows[i].counts)
            fail_msg("row %zu: counter %u: expected it counted: %d", i, rows[i].counter, rows[i].counts);
    }
}

/* A segment after an abort of the master, or after a restart, belongs to no transfer. */
static void aborted_by_the_master(void **state)
{
    static const uint8_t start[] = {0x00, 0x20, 0x40, 0x02, 0x20, 0, 0, 0, 0, 0};
    static const uint8_t abort[] = {0x00, 0x20, 0x80, 0x02, 0x20, 0, 0, 0, 0, 0x08};
    static const uint8_t segment[] = {0x00, 0x20, 0x60, 0, 0, 0, 0, 0, 0, 0};
    wire_t *w = *state;
    set(w, "abort 0x2002 0x08000021 step 2 slave 2");
    for (unsigned int aborted = 0; aborted < 3; aborted++) {
        uint8_t mail[ROOM];
        assert_int_equal(wire_mail_request(w, 1, 3, start, sizeof start), 1);
        assert_true(wire_mail_receive(w, 1, mail, ROOM) > 0);
        if (aborted == 1)
            assert_int_equal(wire_mail_request(w, 1, 3, abort, sizeof abort), 1);
        if (aborted == 2) {
            set(w, "reset slave 2");
            wire_assign_stations(w);
            wire_configure_mailbox(w, 1);
            wire_go(w, 1, ECT_STATE_PREOP);
        }
        assert_int_equal(wire_mail_request(w, 1, 3, segment, sizeof segment), 1);
        assert_true(wire_mail_receive(w, 1, mail, ROOM) > 0);
        assert_int_equal(mail[8], 0x80);
        if ((ect_load_le32(mail + 12) == 0x08000021) != (aborted == 0))
            fail_msg("aborted by the master %u: got 0x%08X", aborted, ect_load_le32(mail + 12));
    }
}

/* The SyncManager of the requests has room for an SDO, and no more than the stack reads at once. */
static void mailboxes_of_any_length(void **state)
{
    enum { START = 0x1000 };
    static const struct {
        uint16_t length;
        bool counts;
    } rows[] = {{15, false}, {16, true}, {17, true}, {2047, true}, {2048, true}, {2049, false}};
    wire_t *w = *state;
    begin_count(w);
    const ect_pdi_t *pdi = ect_chain_slave(w->chain, 1)->config.pdi;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t *memory = ect_chain_esc(w->chain, 1)->memory;
        uint8_t bytes[8];
        memset(memory + START, 0, 16);
        memcpy(memory + START, ((uint8_t[]){10, 0, 0, 0, 0, 0x03, 0, 0x20, 0x40, 0x00, 0x20}), 11);
        ect_store_le16(memory + ECT_REG_SM + ECT_SM_LENGTH, rows[i].length);
        memory[ECT_REG_SM + ECT_SM_STATUS] |= ECT_SM_STATUS_FULL;
        const uint64_t before = ect_chain_fault_seen(w->chain, TAG);
        (void)pdi->read(pdi->ctx, START, bytes, sizeof bytes);
        if (ect_chain_fault_seen(w->chain, TAG) - before != rows[i].counts)
            fail_msg("%u bytes: expected a request counted: %d", rows[i].length, rows[i].counts);
    }
}

/* A request is read from its first byte on, in a full buffer in the RAM, within its length. */
static void reads_of_a_request(void **state)
{
    enum { START = 0x1000, LENGTH = 128 };
    static const struct {
        const char *title;
        uint16_t start, address, length;
        bool full, counts;
    } rows[] = {
        {"all", START, START, LENGTH, true, true},
        {"the first byte", START, START, 1, true, true},
        {"not from the first byte on", START, START + 1, 8, true, false},
        {"beyond the end", START, START, LENGTH + 1, true, false},
        {"no mail", START, START, 8, false, false},
        {"before the RAM", ECT_RAM - 1, ECT_RAM - 1, 8, true, false},
    };
    wire_t *w = *state;
    begin_count(w);
    const ect_pdi_t *pdi = ect_chain_slave(w->chain, 1)->config.pdi;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t *memory = ect_chain_esc(w->chain, 1)->memory;
        uint8_t bytes[LENGTH + 1];
        memcpy(memory + rows[i].start, ((uint8_t[]){10, 0, 0, 0, 0, 0x03, 0, 0x20, 0x40, 0x00, 0x20, 0}), 12);
        ect_store_le16(memory + ECT_REG_SM + ECT_SM_START, rows[i].start);
        memory[ECT_REG_SM + ECT_SM_STATUS] = rows[i].full ? ECT_SM_STATUS_FULL : 0;
        const uint64_t before = ect_chain_fault_seen(w->chain, TAG);
        (void)pdi->read(pdi->ctx, rows[i].address, bytes, rows[i].length);
        if (ect_chain_fault_seen(w->chain, TAG) - before != rows[i].counts)
            fail_msg("%s: expected a request counted: %d", rows[i].title, rows[i].counts);
    }
}

/* --- mails -------------------------------------------------------------------------------------------------------- */

static const uint8_t upload[] = {0x00, 0x20, 0x40, 0x00, 0x20, 0, 0, 0, 0, 0};

/* Requests 2000h:0. @return service data length of the mail, -1: no mail */
static int request(wire_t *w, uint8_t *mail)
{
    assert_int_equal(wire_mail_request(w, 1, 3, upload, sizeof upload), 1);
    return wire_mail_receive(w, 1, mail, ROOM);
}

static void changed_headers(void **state)
{
    static const struct {
        const char *fault;
        unsigned int offset;
        uint8_t mask, value; /* 0xFF: that of the mail before */
    } rows[] = {
        {"mail type slave 2", 5, 0x0F, 0x0F},
        {"mail length slave 2", 0, 0xFF, 128},
        {"mail counter slave 2", 5, 0x70, 0xFF},
    };
    wire_t *w = *state;
    uint8_t before[ROOM], mail[ROOM];
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        assert_int_equal(request(w, before), 10);
        set(w, rows[i].fault);
        (void)request(w, mail);
        uint8_t want = rows[i].value == 0xFF ? before[rows[i].offset] & rows[i].mask : rows[i].value;
        if ((mail[rows[i].offset] & rows[i].mask) != want)
            fail_msg("%s: expected 0x%02X, got 0x%02X", rows[i].fault, want, mail[rows[i].offset] & rows[i].mask);
        unsigned int counter = (before[5] >> 4 & 7u) % 7 + 1; /* nothing else is changed */
        if (i < 2)
            assert_int_equal(mail[5] >> 4, counter);
        ect_chain_fault_end(w->chain, 0);
        assert_int_equal(request(w, mail), 10);
        assert_int_equal(mail[5] & 0x0F, 3);
        assert_int_not_equal(mail[5] & 0x70, want & 0x70);
    }
}

static void toggles(void **state)
{
    static const uint8_t start[] = {0x00, 0x20, 0x40, 0x02, 0x20, 0, 0, 0, 0, 0};
    static const uint8_t segment[] = {0x00, 0x20, 0x60, 0, 0, 0, 0, 0, 0, 0};
    wire_t *w = *state;
    uint8_t mail[ROOM];
    set(w, "mail toggle slave 2");
    assert_int_equal(wire_mail_request(w, 1, 3, start, sizeof start), 1);
    assert_true(wire_mail_receive(w, 1, mail, ROOM) > 0);
    assert_int_equal(mail[8] & 0xF0, 0x40); /* not a segment: as it is */
    assert_int_equal(wire_mail_request(w, 1, 3, segment, sizeof segment), 1);
    assert_true(wire_mail_receive(w, 1, mail, ROOM) > 0);
    assert_int_equal(mail[8] & 0x10, 0x10);
}

/* The response to each segment of a download, and none other, has its toggle bit inverted. */
static void toggles_of_a_download(void **state)
{
    static const uint8_t start[] = {0x00, 0x20, 0x21, 0x02, 0x20, 0, 0xE8, 0x03, 0, 0};
    static const struct {
        uint8_t command, want;
    } rows[] = {{0x00, 0x30}, {0x10, 0x20}, {0x00, 0x30}};
    wire_t *w = *state;
    uint8_t mail[ROOM];
    set(w, "mail toggle slave 2");
    assert_int_equal(wire_mail_request(w, 1, 3, start, sizeof start), 1);
    assert_true(wire_mail_receive(w, 1, mail, ROOM) > 0);
    assert_int_equal(mail[8], 0x60);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const uint8_t segment[] = {0x00, 0x20, rows[i].command, 1, 2, 3, 4, 5, 6, 7};
        assert_int_equal(wire_mail_request(w, 1, 3, segment, sizeof segment), 1);
        assert_true(wire_mail_receive(w, 1, mail, ROOM) > 0);
        assert_int_equal(mail[8], rows[i].want);
    }
}

/* The counters are 1 to 7, then 1 again. */
static void each_counter(void **state)
{
    wire_t *w = *state;
    uint8_t mail[ROOM];
    assert_int_equal(request(w, mail), 10);
    unsigned int right = mail[5] >> 4;
    set(w, "mail counter slave 2");
    for (unsigned int n = 0; n < 9; n++) {
        assert_int_equal(request(w, mail), 10);
        assert_int_equal(mail[5] >> 4, right);
        right = right % 7 + 1;
    }
}

/* A mail of several faults has the effects of each; a lost one is neither late nor there twice. */
static void mails_of_several(void **state)
{
    static const struct {
        const char *faults[2];
        int first, later; /* service data length at once and after 60 ms; -1: no mail */
        uint8_t type;
    } rows[] = {
        {{"mail late 50ms slave 2", "mail type slave 2"}, -1, 10, 15},
        {{"mail type slave 2", "mail late 50ms slave 2"}, -1, 10, 15},
        {{"mail late 50ms slave 2", "mail lost slave 2"}, -1, -1, 0},
        {{"mail lost slave 2", "mail late 50ms slave 2"}, -1, -1, 0},
        {{"mail late 50ms slave 2", "mail late 40ms slave 2"}, -1, 10, 3},
        {{"mail twice slave 2", "mail type slave 2"}, 10, 10, 15},
    };
    wire_t *w = *state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t mail[ROOM] = {0};
        set(w, rows[i].faults[0]);
        set(w, rows[i].faults[1]);
        const int first = request(w, mail);
        wire_advance(w, 60 * MS);
        const int later = wire_mail_receive(w, 1, mail, ROOM);
        if (first != rows[i].first || later != rows[i].later)
            fail_msg("%s, %s: got %d, then %d", rows[i].faults[0], rows[i].faults[1], first, later);
        if (later > 0)
            assert_int_equal(mail[5] & 0x0F, rows[i].type);
        ect_chain_fault_end(w->chain, 0);
        wire_poll(w);
        assert_int_equal(request(w, mail), 10);
    }
}

/* An abort by the stack is a mail of the transfer too. */
static void mail_of_an_abort(void **state)
{
    static const uint8_t download[] = {0x00, 0x20, 0x23, 0x00, 0x10, 0, 1, 0, 0, 0};
    wire_t *w = *state;
    uint8_t mail[ROOM];
    set(w, "mail lost of 0x1000 slave 2");
    assert_int_equal(wire_mail_request(w, 1, 3, download, sizeof download), 1);
    assert_int_equal(wire_mail_receive(w, 1, mail, ROOM), -1);
    wire_advance(w, MS);
    ect_chain_fault_end(w->chain, 0);
    assert_int_equal(wire_mail_request(w, 1, 3, download, sizeof download), 1);
    assert_int_equal(wire_mail_receive(w, 1, mail, ROOM), 10);
    assert_int_equal(mail[8], 0x80);
}

/* The poll returns the time at which the mail leaves. */
static void late_to_the_nanosecond(void **state)
{
    wire_t *w = *state;
    uint8_t mail[ROOM];
    set(w, "mail late 50ms 1st slave 2");
    w->now_ns += 1000 * MS;
    wire_poll(w);
    const uint64_t due_ns = w->now_ns + 50 * MS;
    assert_int_equal(wire_mail_request(w, 1, 3, upload, sizeof upload), 1);
    w->manual_poll = true;
    w->now_ns += 20 * MS; /* link lamps */
    while (w->now_ns < due_ns) {
        const uint64_t next_ns = ect_chain_poll(w->chain, w->now_ns);
        assert_int_equal(wire_mail_receive(w, 1, mail, ROOM), -1);
        assert_true(next_ns > w->now_ns && next_ns <= due_ns);
        w->now_ns = next_ns;
    }
    assert_int_equal(wire_mail_receive(w, 1, mail, ROOM), -1);
    (void)ect_chain_poll(w->chain, due_ns);
    assert_int_equal(wire_mail_receive(w, 1, mail, ROOM), 10);
}

/* Without a fault, and without a mail that is kept or comes again, the stack accesses the ESC directly. */
static void direct_accesses(void **state)
{
    static const struct {
        const char *fault;
        bool requests;
        uint64_t ns; /* after which the accesses are direct */
    } rows[] = {{"mail type slave 2", false, 0},
                {"mail late 50ms 1st slave 2", true, 50 * MS},
                {"mail late 50ms slave 2", true, 50 * MS},
                {"al never slave 2", false, 0}};
    wire_t *w = *state;
    const ect_pdi_t direct = *ect_chain_slave(w->chain, 1)->config.pdi;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t mail[ROOM];
        const ect_pdi_t *pdi = ect_chain_slave(w->chain, 1)->config.pdi;
        set(w, rows[i].fault);
        assert_ptr_not_equal(pdi->ctx, direct.ctx);
        if (rows[i].requests)
            assert_int_equal(request(w, mail), -1);
        ect_chain_fault_end(w->chain, 0);
        ect_chain_wake(w->chain, 1);
        wire_poll(w);
        if ((pdi->ctx == direct.ctx) != (rows[i].ns == 0))
            fail_msg("%s: direct at once: %d", rows[i].fault, pdi->ctx == direct.ctx);
        wire_advance(w, rows[i].ns);
        assert_memory_equal(pdi, &direct, sizeof direct);
        if (rows[i].requests)
            assert_int_equal(wire_mail_receive(w, 1, mail, ROOM), 10);
    }
}

static void late(void **state)
{
    wire_t *w = *state;
    uint8_t mail[ROOM];
    set(w, "mail late 50ms 1st slave 2");
    assert_int_equal(request(w, mail), -1);
    wire_advance(w, 49 * MS);
    assert_int_equal(wire_mail_receive(w, 1, mail, ROOM), -1);
    wire_advance(w, 2 * MS);
    assert_int_equal(wire_mail_receive(w, 1, mail, ROOM), 10);
    assert_int_equal(request(w, mail), 10); /* the fault was that of the first one */
    set(w, "mail late 50ms slave 2");
    assert_int_equal(request(w, mail), -1);
    assert_int_equal(wire_al(w, 1, 1, NULL), 1); /* INIT forgets it */
    wire_go(w, 1, 2);
    wire_advance(w, 100 * MS);
    assert_int_equal(wire_mail_receive(w, 1, mail, ROOM), -1);
}

static void lost(void **state)
{
    wire_t *w = *state;
    uint8_t mail[ROOM];
    set(w, "mail lost of 0x2000 2nd slave 2");
    assert_int_equal(request(w, mail), 10);
    assert_int_equal(request(w, mail), -1);
    wire_advance(w, MS);
    assert_int_equal(wire_mail_receive(w, 1, mail, ROOM), -1);
    assert_int_equal(request(w, mail), 10);
    set(w, "mail lost of 0x2001 slave 2");
    assert_int_equal(request(w, mail), 10);
}

static void twice(void **state)
{
    wire_t *w = *state;
    uint8_t first[ROOM] = {0}, again[ROOM] = {0};
    set(w, "mail twice 1st slave 2");
    assert_int_equal(request(w, first), 10);
    wire_poll(w);
    assert_int_equal(wire_mail_receive(w, 1, again, ROOM), 10);
    assert_memory_equal(first, again, 16);
    wire_poll(w);
    assert_int_equal(wire_mail_receive(w, 1, again, ROOM), -1);
    assert_int_equal(request(w, again), 10);
    assert_int_not_equal(again[5], first[5]);
}

/* The second one leaves when the master has fetched the first one, however often the stack runs before. */
static void twice_after_a_while(void **state)
{
    wire_t *w = *state;
    uint8_t mail[ROOM];
    set(w, "mail twice 1st slave 2");
    assert_int_equal(wire_mail_request(w, 1, 3, upload, sizeof upload), 1);
    for (unsigned int n = 0; n < 5; n++) {
        w->now_ns += MS;
        ect_chain_wake(w->chain, 1);
        wire_poll(w);
    }
    assert_int_equal(wire_mail_receive(w, 1, mail, ROOM), 10);
    wire_poll(w);
    assert_int_equal(wire_mail_receive(w, 1, mail, ROOM), 10);
    wire_poll(w);
    assert_int_equal(wire_mail_receive(w, 1, mail, ROOM), -1);
}

/* The SyncManager of the mails has more room than an SDO, and no more than 2048 bytes, behind the registers. */
static void mails_of_any_length(void **state)
{
    static const struct {
        uint16_t start, size;
        bool changed;
    } rows[] = {{0x1080, 16, false},  {0x1080, 17, true},    {0x1080, 128, true},
                {0x1080, 2048, true}, {0x1080, 2049, false}, {ECT_RAM, 128, true}};
    wire_t *w = *state;
    set(w, "mail type slave 2");
    w->poll = keep_still;
    const ect_pdi_t *pdi = ect_chain_slave(w->chain, 1)->config.pdi;
    wire_set_sm(w, 1, 0, ECT_RAM, 0, 0x26); /* the RAM is free */
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        static const uint8_t mail[16] = {10, 0, 0, 0, 0, 0x13, 0, 0x30, 0x4F, 0x00, 0x20};
        const uint8_t *memory = ect_chain_esc(w->chain, 1)->memory;
        wire_set_sm(w, 1, 1, rows[i].start, 0, 0x22);
        wire_set_sm(w, 1, 1, rows[i].start, rows[i].size, 0x22);
        assert_int_equal(pdi->write(pdi->ctx, rows[i].start, mail, rows[i].size > 16 ? 16 : 15), 0);
        assert_int_equal(pdi->write(pdi->ctx, (uint16_t)(rows[i].start + rows[i].size - 1), "", 1), 0);
        if (memory[rows[i].start + 5] != (rows[i].changed ? 0x1F : 0x13))
            fail_msg("%u bytes at 0x%04X: got type and counter 0x%02X", rows[i].size, rows[i].start,
                     memory[rows[i].start + 5]);
    }
    w->poll = NULL;
}

static void emergencies(void **state)
{
    wire_t *w = *state;
    uint8_t mail[ROOM] = {0};
    set(w, "emergency 0x5530 register 32 data 0102030405 slave 2");
    assert_int_equal(wire_mail_receive(w, 1, mail, ROOM), 10);
    assert_memory_equal(mail + 6, ((uint8_t[]){0x00, 0x10, 0x30, 0x55, 32, 1, 2, 3, 4, 5}), 10);
    assert_int_equal(testdev_of(w, 1)->standard.error_register, 32);
}

/* A fault of an object's mails applies to responses of SDO transfers of the object, and to no emergency between them.
 */
static void emergency_beside_a_transfer(void **state)
{
    wire_t *w = *state;
    uint8_t mail[ROOM] = {0};
    set(w, "mail type of 0x2000 slave 2");
    assert_int_equal(request(w, mail), 10);
    assert_int_equal(mail[5] & 0x0F, 0x0F);
    set(w, "emergency 0x5530 register 32 data 0102030405 slave 2");
    assert_int_equal(wire_mail_receive(w, 1, mail, ROOM), 10);
    assert_int_equal(mail[5] & 0x0F, ECT_MAILBOX_TYPE_COE);
    assert_int_equal(mail[7] >> 4, 1);
    assert_int_equal(request(w, mail), 10);
    assert_int_equal(mail[5] & 0x0F, 0x0F);
}

/* A device that serves no emergencies: with other protocols, or without any. */
static void no_emergencies(void **state)
{
    static const ect_protocol_t *const sdo_alone[] = {&ect_protocol_sdo, NULL};
    const ect_protocol_t *const *const lists[] = {sdo_alone, NULL};
    (void)state;
    for (unsigned int i = 0; i < 2; i++) {
        ect_device_t device = testdev;
        wire_t w;
        device.protocols = lists[i];
        wire_open_one(&w, &device);
        assert_string_equal(try_fault(&w, "emergency 0x5530 slave 1"), "its device has no emergencies");
        wire_close(&w);
    }
}

/* Mails of other protocols pass, and count as no request of an SDO. */
static void aborts_of_SDO_alone(void **state)
{
    static const uint8_t data[] = {0x00, 0x20, 0x40, 0x00, 0x20, 0, 0, 0, 0, 0};
    wire_t *w = *state;
    uint8_t mail[ROOM];
    set(w, "abort 0x2000 0x08000020 2nd slave 2");
    assert_int_equal(request(w, mail), 10);
    for (uint8_t type = 1; type < 16; type++) {
        if (type == 3)
            continue;
        assert_int_equal(wire_mail_request(w, 1, type, data, sizeof data), 1);
        assert_true(wire_mail_receive(w, 1, mail, ROOM) > 0);
        assert_int_equal(mail[5] & 0x0F, 0); /* an error of the mailbox */
    }
    assert_int_equal(request(w, mail), 10);
    assert_int_equal(mail[8], 0x80);
    assert_int_equal(ect_load_le32(mail + 12), 0x08000020);
}

/* --- AL status ---------------------------------------------------------------------------------------------------- */

static uint8_t enter_op(wire_t *w)
{
    wire_configure_process_data(w, 1);
    wire_go(w, 1, 8);
    return wire_read8(w, 1, 0x0130);
}

static void drops(void **state)
{
    static const struct {
        const char *fault;
        uint8_t status;
        uint16_t code;
    } rows[] = {
        {"al 0x001B slave 2", 0x14, 0x001B},
        {"to SAFEOP 0x001B slave 2", 0x14, 0x001B},
        {"al 0x002D to PREOP slave 2", 0x12, 0x002D},
        {"to SAFEOP slave 2", 0x14, 0x0001},
        {"init slave 2", 0x11, 0x0001},
        {"init 0x0050 slave 2", 0x11, 0x0050},
    };
    wire_t *w = *state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        assert_int_equal(enter_op(w), 8);
        set(w, rows[i].fault);
        uint8_t status = wire_read8(w, 1, 0x0130);
        uint16_t code = wire_read16(w, 1, 0x0134);
        if (status != rows[i].status || code != rows[i].code)
            fail_msg("%s: got 0x%02X 0x%04X", rows[i].fault, status, code);
        assert_int_equal(wire_al(w, 1, 0x11, NULL), 1);
        wire_configure_mailbox(w, 1);
        wire_go(w, 1, 2);
    }
}

static void drops_downwards_only(void **state)
{
    static const struct {
        uint8_t state;
        const char *fault;
        bool refused;
    } rows[] = {
        {ECT_STATE_INIT, "al 0x001B slave 2", true},   {ECT_STATE_INIT, "init slave 2", true},
        {ECT_STATE_INIT, "to PREOP slave 2", true},    {ECT_STATE_PREOP, "to SAFEOP slave 2", true},
        {ECT_STATE_PREOP, "to PREOP slave 2", true},   {ECT_STATE_PREOP, "init slave 2", false},
        {ECT_STATE_SAFEOP, "to SAFEOP slave 2", true}, {ECT_STATE_SAFEOP, "al 0x001B slave 2", false},
        {ECT_STATE_SAFEOP, "to PREOP slave 2", false}, {ECT_STATE_OP, "to SAFEOP slave 2", false},
    };
    wire_t *w = *state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        wire_go(w, 1, rows[i].state);
        const char *why = try_fault(w, rows[i].fault);
        bool left = wire_read8(w, 1, 0x0130) != rows[i].state;
        if ((why != NULL) != rows[i].refused || left == rows[i].refused)
            fail_msg("'%s' in state %u: expected refused %d, got %s", rows[i].fault, rows[i].state, rows[i].refused,
                     why ? why : "no reason");
        assert_true(!why || strstr(why, "in that state already, or below"));
        assert_int_equal(wire_al(w, 1, 0x11, NULL), 1);
    }
}

static void refuses(void **state)
{
    wire_t *w = *state;
    uint16_t code;
    wire_configure_process_data(w, 1);
    set(w, "al refuse 0x0030 to SAFEOP slave 2");
    assert_int_equal(wire_al(w, 1, 4, &code), 0x12);
    assert_int_equal(code, 0x0030);
    assert_int_equal(ect_chain_slave(w->chain, 1)->code, 0x0030);
    assert_int_equal(wire_al(w, 1, 0x12, &code), 2); /* the master acknowledges it */
    assert_int_equal(code, 0);
    assert_int_equal(wire_al(w, 1, 1, NULL), 1); /* other states: as ever */
    wire_configure_mailbox(w, 1);
    wire_go(w, 1, 2);
    assert_int_equal(wire_al(w, 1, 5, &code), 0x12); /* the slave's own refusal has its own code */
    assert_int_equal(code, ECT_AL_UNKNOWN_STATE);
    assert_int_equal(ect_chain_slave(w->chain, 1)->code, ECT_AL_UNKNOWN_STATE);
    assert_int_equal(wire_al(w, 1, 0x12, &code), 2);
    ect_chain_fault_end(w->chain, 0);
    assert_int_equal(enter_op(w), 8);
}

/* Faults of mails do not change requests for a state; the first fault of the state applies. */
static void refuses_beside_others(void **state)
{
    wire_t *w = *state;
    uint16_t code;
    set(w, "mail type 0% slave 2");
    set(w, "pdo-size 0 slave 2");
    set(w, "al never to OP slave 2");
    set(w, "al refuse 0x0030 to SAFEOP slave 2");
    set(w, "al never to SAFEOP slave 2");
    wire_configure_process_data(w, 1);
    assert_int_equal(wire_al(w, 1, ECT_STATE_PREOP, &code), ECT_STATE_PREOP); /* the present state */
    assert_int_equal(code, 0);
    assert_int_equal(wire_al(w, 1, ECT_STATE_SAFEOP, &code), 0x12);
    assert_int_equal(code, 0x0030);
    assert_int_equal(wire_al(w, 1, 0x10 | ECT_STATE_INIT, &code), ECT_STATE_INIT);
    assert_int_equal(code, 0);
}

static void never_comes(void **state)
{
    wire_t *w = *state;
    uint16_t code;
    set(w, "al never to OP slave 2");
    wire_configure_process_data(w, 1);
    wire_go(w, 1, 4);
    (void)wire_outputs(w, 1, 0);
    assert_int_equal(wire_al(w, 1, 8, &code), 4);
    wire_advance(w, 20000 * MS);
    assert_int_equal(wire_read8(w, 1, 0x0130), 4);
    assert_int_equal(code, 0);
    ect_chain_fault_end(w->chain, 0);
    assert_int_equal(enter_op(w), 8);
}

/* The request becomes one for INIT: the slave reports no error. */
static void never_leaves_INIT(void **state)
{
    wire_t *w = *state;
    uint16_t code = 0;
    wire_go(w, 1, ECT_STATE_INIT);
    wire_configure_mailbox(w, 1);
    set(w, "al never slave 2");
    assert_int_equal(wire_al(w, 1, ECT_STATE_PREOP, &code), ECT_STATE_INIT);
    assert_int_equal(code, 0);
    ect_chain_fault_end(w->chain, 0);
    assert_int_equal(wire_al(w, 1, ECT_STATE_PREOP, NULL), ECT_STATE_PREOP);
}

static void sizes(void **state)
{
    wire_t *w = *state;
    uint16_t code;
    wire_configure_process_data(w, 1);
    set(w, "pdo-size 1 slave 2");
    assert_int_equal(wire_al(w, 1, 4, &code), 0x12);
    assert_int_equal(code, 0x001D);
    set(w, "reset slave 2"); /* it lasts */
    wire_assign_stations(w);
    wire_configure_mailbox(w, 1);
    wire_go(w, 1, 2);
    wire_configure_process_data(w, 1);
    assert_int_equal(wire_al(w, 1, 4, &code), 0x12);
    ect_chain_fault_end(w->chain, 0);
    assert_int_equal(wire_al(w, 1, 0x12, NULL), 2);
    assert_int_equal(enter_op(w), 8);
}

/* The SyncManagers of the process data, and no byte behind the registers that are read. */
static void sizes_of_process_data_alone(void **state)
{
    enum { REGISTERS = 4 * 8, BEHIND = 8 };
    wire_t *w = *state;
    const ect_pdi_t *pdi = ect_chain_slave(w->chain, 1)->config.pdi;
    uint8_t before[REGISTERS], changed[REGISTERS + BEHIND], none[BEHIND];
    wire_configure_process_data(w, 1);
    assert_int_equal(pdi->read(pdi->ctx, ECT_REG_SM, before, REGISTERS), 0);
    set(w, "pdo-size 1 slave 2");
    pdi = ect_chain_slave(w->chain, 1)->config.pdi;
    memset(changed, 0x5A, sizeof changed);
    memset(none, 0x5A, sizeof none);
    for (uint16_t length = 16; length <= REGISTERS; length = (uint16_t)(length + 8)) {
        memset(changed, 0x5A, sizeof changed);
        assert_int_equal(pdi->read(pdi->ctx, ECT_REG_SM, changed, length), 0);
        for (uint16_t at = 0; at < length; at = (uint16_t)(at + 8))
            assert_int_equal(ect_load_le16(changed + at + 2), ect_load_le16(before + at + 2) - (at >= 16));
        assert_memory_equal(changed + length, none, BEHIND);
    }
}

/* The length of SM2 as the stack reads it; one without data stays without. */
static void sizes_of_any_length(void **state)
{
    static const struct {
        const char *fault;
        uint16_t length, read;
    } rows[] = {
        {"pdo-size 1 slave 2", 0, 0},
        {"pdo-size 1 slave 2", 1, 0},
        {"pdo-size 1 slave 2", 2, 1},
        {"pdo-size 2 slave 2", 0x0102, 0x0100},
        {"pdo-size -1 slave 2", 0, 0},
        {"pdo-size -1 slave 2", 1, 2},
        {"pdo-size -1 slave 2", 0x00FF, 0x0100},
    };
    wire_t *w = *state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t registers[3 * ECT_SM_SIZE], length[2];
        ect_store_le16(length, rows[i].length);
        assert_int_equal(wire_write(w, 1, ECT_REG_SM + 2 * ECT_SM_SIZE + ECT_SM_LENGTH, length, 2), 1);
        set(w, rows[i].fault);
        const ect_pdi_t *pdi = ect_chain_slave(w->chain, 1)->config.pdi;
        assert_int_equal(pdi->read(pdi->ctx, ECT_REG_SM, registers, sizeof registers), 0);
        const uint16_t read = ect_load_le16(registers + 2 * ECT_SM_SIZE + ECT_SM_LENGTH);
        if (read != rows[i].read)
            fail_msg("%s, %u bytes: expected %u, got %u", rows[i].fault, rows[i].length, rows[i].read, read);
        ect_chain_fault_end(w->chain, 0);
    }
}

/* A twin with a fault sleeps until an event, unless a mail of it is lost: the stack has to detect the empty buffer. */
static void sleeps(void **state)
{
    wire_t *w = *state;
    uint8_t mail[ROOM];
    set(w, "mail lost 1st slave 2");
    assert_true(ect_chain_poll(w->chain, w->now_ns) > w->now_ns + MS);
    assert_int_equal(request(w, mail), -1);
    wire_advance(w, MS);
    assert_true(ect_chain_poll(w->chain, w->now_ns) > w->now_ns + MS);
    set(w, "mail type 0% slave 2");
    assert_true(ect_chain_poll(w->chain, w->now_ns) > w->now_ns + MS);
}

/* --- several ------------------------------------------------------------------------------------------------------ */

static void listed(void **state)
{
    wire_t *w = *state;
    char text[ECT_FAULT_TEXT];
    set(w, "mail lost 0% slave 2");
    set(w, "al never to BOOT slave 1");
    ect_fault_print(ect_chain_fault_at(w->chain, 0), text);
    assert_string_equal(text, "al never to BOOT slave 1");
    ect_fault_print(ect_chain_fault_at(w->chain, 1), text);
    assert_string_equal(text, "mail lost 0% slave 2");
    assert_null(ect_chain_fault_at(w->chain, 2));
    for (unsigned int i = 1; i < ECT_ABOVE; i++)
        set(w, "mail type 0% slave 2");
    assert_non_null(strstr(try_fault(w, "mail type slave 2"), "'off' ends them"));
    ect_chain_fault_end(w->chain, 0);
    assert_null(ect_chain_fault_at(w->chain, 0));
}

static void ended_by_tag(void **state)
{
    static const struct {
        uint32_t tag;
        const char *left;
    } rows[] = {{9, "1213"}, {1, "23"}, {2, "113"}, {3, "121"}};
    wire_t *w = *state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char left[ECT_ABOVE + 1] = "";
        for (const char *tag = "1213"; *tag != 0; tag++) {
            const ect_fault_t fault = {.kind = ECT_FAULT_MAIL_LOST, .slave = 2, .tag = (uint32_t)(*tag - '0')};
            assert_null(ect_chain_fault(w->chain, &fault, w->now_ns));
        }
        ect_chain_fault_end(w->chain, rows[i].tag);
        for (size_t k = 0; ect_chain_fault_at(w->chain, k); k++)
            left[k] = (char)('0' + ect_chain_fault_at(w->chain, k)->tag);
        if (strcmp(left, rows[i].left) != 0)
            fail_msg("end of tag %u: expected the tags %s, got %s", rows[i].tag, rows[i].left, left);
        ect_chain_fault_end(w->chain, 0);
    }
}

/* A fault of one transfer or mail is over with it: it is listed no more, and leaves room for another. */
static void over_after_one(void **state)
{
    static const char *const faults[] = {"abort 0x2000 0x08000020 2nd slave 2", "mail type 2nd slave 2",
                                         "mail lost 2nd slave 2"};
    wire_t *w = *state;
    uint8_t mail[ROOM];
    for (size_t i = 0; i < sizeof faults / sizeof faults[0]; i++) {
        set(w, faults[i]);
        (void)request(w, mail);
        if (!ect_chain_fault_at(w->chain, 0))
            fail_msg("%s: over after the first", faults[i]);
        (void)request(w, mail);
        if (ect_chain_fault_at(w->chain, 0))
            fail_msg("%s: not over after the second", faults[i]);
        wire_advance(w, MS);
    }
}

/* The counts of a tag are added, in all twins and for all objects. */
static void counts_of_a_tag(void **state)
{
    wire_t *w = *state;
    uint8_t mail[ROOM];
    begin_count(w);
    begin_count(w);
    const ect_fault_t other = {
        .kind = ECT_FAULT_COUNT, .slave = 2, .tag = TAG + 1, .object = {.named = true, .index = 0x2000}};
    assert_null(ect_chain_fault(w->chain, &other, w->now_ns));
    assert_int_equal(request(w, mail), 10);
    assert_int_equal(ect_chain_fault_seen(w->chain, TAG), 2);
    assert_int_equal(ect_chain_fault_seen(w->chain, TAG + 1), 1);
    assert_int_equal(ect_chain_fault_seen(w->chain, TAG + 2), 0);
}

/* A count is no fault: it is not listed, lasts beyond 'off', and ends by its tag. */
static void counts(void **state)
{
    wire_t *w = *state;
    uint8_t mail[ROOM];
    const ect_fault_t count = {.kind = ECT_FAULT_COUNT,
                               .slave = 2,
                               .tag = 9,
                               .object = {.named = true, .index = 0x2000, .transfer = ECT_FAULT_UPLOAD}};
    assert_null(ect_chain_fault(w->chain, &count, w->now_ns));
    assert_null(ect_chain_fault_at(w->chain, 0));
    ect_chain_fault_end(w->chain, 0);
    assert_int_equal(request(w, mail), 10);
    assert_int_equal(write_u32(w, 1), 0);
    assert_int_equal(request(w, mail), 10);
    assert_int_equal(ect_chain_fault_seen(w->chain, 9), 2);
    ect_chain_fault_end(w->chain, 9);
    assert_int_equal(ect_chain_fault_seen(w->chain, 9), 0);
}

static void shares(void **state)
{
    enum { REQUESTS = 2000 };
    wire_t *w = *state;
    char first[REQUESTS] = {0}, second[REQUESTS] = {0};
    char *const runs[] = {first, second};
    unsigned int refused = 0;
    for (unsigned int run = 0; run < 2; run++) {
        ect_fault_t fault;
        char message[ECT_FAULT_MESSAGE];
        assert_true(ect_fault_parse("abort 0x2000 0x08000020 30% slave 2", &fault, message));
        fault.seed = 5;
        assert_null(ect_chain_fault(w->chain, &fault, w->now_ns));
        for (uint32_t i = 0; i < REQUESTS; i++)
            runs[run][i] = write_u32(w, i) != 0;
        ect_chain_fault_end(w->chain, 0);
    }
    for (unsigned int i = 0; i < REQUESTS; i++)
        refused += first[i] != 0;
    assert_memory_equal(first, second, REQUESTS);
    assert_in_range(refused, REQUESTS * 27 / 100, REQUESTS * 33 / 100);
}

#define TEST(title, function) {title, function, setup, teardown, NULL}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        TEST("CF-030: SDO transfers are aborted with any code, and the device never gets them", aborts),
        TEST("CF-030: transfers of several objects are aborted, each with its code", aborts_of_several),
        TEST("CF-030: a request that is aborted is read in pieces of any size", aborts_in_pieces),
        TEST("CF-033: a transfer is aborted at any of its requests", aborts_in_the_middle),
        TEST("CF-026: a repeated request gets the same abort", repeated_request),
        TEST("CF-030: a request of an SDO has its type, its service and its length", requests_of_an_SDO),
        TEST("CF-026: a request with the counter of the one before is counted once, unless the counter is 0",
             repeated_counters),
        TEST("CF-030: a fault of one request is over when the request has been read", over_with_its_request),
        TEST("CF-033: a segment after an abort of the master, or a restart, belongs to no transfer",
             aborted_by_the_master),
        TEST("requests in mailboxes of 16 to 2048 bytes are counted", mailboxes_of_any_length),
        TEST("a request is counted when its first byte is read from a full mailbox", reads_of_a_request),
        TEST("mails with a wrong type, length and counter", changed_headers),
        TEST("mails with the counter of the mail before, at each counter", each_counter),
        TEST("segments with a wrong toggle bit", toggles),
        TEST("responses to segments of a download with a wrong toggle bit", toggles_of_a_download),
        TEST("a mail is late, and INIT discards it", late),
        TEST("a late mail leaves at the time that the poll returns", late_to_the_nanosecond),
        TEST("a mail of several faults", mails_of_several),
        TEST("the mail of an abort belongs to the transfer", mail_of_an_abort),
        TEST("the stack accesses the ESC directly after the last fault", direct_accesses),
        TEST("a mail is lost, and the next request gets a reply", lost),
        TEST("a mail comes twice", twice),
        TEST("a mail comes again when the first one has been fetched", twice_after_a_while),
        TEST("mails in mailboxes of 17 to 2048 bytes are changed", mails_of_any_length),
        TEST("an emergency on demand", emergencies),
        TEST("a fault of an object's mails applies to no emergency", emergency_beside_a_transfer),
        TEST("an emergency on demand needs a device that has emergencies", no_emergencies),
        TEST("an abort concerns SDO alone", aborts_of_SDO_alone),
        TEST("a slave leaves its state with any AL status code", drops),
        TEST("a fault moves a slave to a lower state only", drops_downwards_only),
        TEST("a slave refuses a state with any AL status code", refuses),
        TEST("a slave refuses a state beside other faults", refuses_beside_others),
        TEST("a slave never reaches a state", never_comes),
        TEST("a slave never leaves INIT, without an error", never_leaves_INIT),
        TEST("process data of another size are refused, after a reset too", sizes),
        TEST("the sizes of process data change, and no other data", sizes_of_process_data_alone),
        TEST("a SyncManager without data has none with a fault of sizes either", sizes_of_any_length),
        TEST("a twin with a fault sleeps until there is work", sleeps),
        TEST("faults above the wire are listed, at most eight of a slave, and ended", listed),
        TEST("the faults with a tag are ended, and all others stay", ended_by_tag),
        TEST("a fault of one transfer or mail is over with it", over_after_one),
        TEST("SDO transfers are counted", counts),
        TEST("the counts of a tag are added", counts_of_a_tag),
        TEST("a share of the transfers, the same with the same seed", shares),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
