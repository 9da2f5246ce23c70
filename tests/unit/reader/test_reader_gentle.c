/* SPDX-License-Identifier: MIT */
/* The reader does not change a bus: its writes, the states it keeps, the detection of a master, and missing data.
 */
#define _GNU_SOURCE
#include "reader/reader.h"

#include <string.h>

#include "support/liar.h"
#include "support/testdev.h"

enum { INIT = 1, PREOP = 2, BOOT = 3, SAFEOP = 4, OP = 8, APWR_COMMAND = 2, IN_USE = 1 };
enum { MILLISECOND = 1000000, LISTEN_MS = 500, ETHERCAT = 0x88A4 };

static ect_reader_t reader;
static uint8_t image[ECT_READER_SII];

static void see_object(void *ctx, const ect_reader_object_t *object)
{
    (void)ctx;
    (void)object;
}

static void see_entry(void *ctx, const ect_reader_object_t *object, const ect_reader_entry_t *entry)
{
    (void)ctx;
    (void)object;
    (void)entry;
}

static const ect_reader_sink_t nothing = {.object = see_object, .entry = see_entry};

/* --- writes ------------------------------------------------------------------------------------------------------- */

/* One bit for each kind of register; the number of the liar collects them. */
enum { OWNER = 1, EEPROM = 2, STATE = 4, SMS = 8, MAIL = 16, OTHER = 32 };

static unsigned int kind_of(const liar_t *l, uint16_t ado, uint16_t length)
{
    if (ado == ECT_REG_SII_CONFIG && length == 1)
        return OWNER;
    if (ado >= ECT_REG_SII_CONTROL && ado + length <= ECT_REG_SII_DATA)
        return EEPROM;
    if (ado == ECT_REG_AL_CONTROL && length == 2)
        return STATE;
    if (ado >= ECT_REG_SM && ado + length <= ECT_REG_SM + 2 * ECT_SM_SIZE)
        return SMS;
    return ado == l->out_start ? MAIL : OTHER;
}

static bool collect_writes(liar_t *l, uint8_t *d, uint16_t ado, uint8_t *data, uint16_t length, uint8_t *wkc)
{
    (void)data;
    (void)wkc;
    if (d[0] == APWR_COMMAND)
        l->number |= kind_of(l, ado, length);
    return true;
}

static liar_mail_t refuse_downloads(liar_t *l, const uint8_t *r)
{
    (void)l;
    assert_int_equal(r[5] & 0x0F, 3); /* CoE */
    if (r[7] >> 4 == 2)               /* an SDO request: upload, its segments, abort */
        assert_true(r[8] >> 5 == 2 || r[8] >> 5 == 3 || r[8] >> 5 == 4);
    return LIAR_PASSES;
}

static void the_reader_writes_eeprom_state_mailbox_and_no_object(void **state)
{
    static const liar_kind_t kind = {.request = refuse_downloads, .datagram = collect_writes};
    static const struct {
        const char *title;
        ect_reader_changes_t changes;
        uint8_t state;
        unsigned int writes;
        ect_reader_result_t result;
    } cases[] = {
        {"CLN-004: in INIT, with consent", ECT_READER_CHANGES_INIT, INIT, EEPROM | STATE | SMS | MAIL, ECT_READER_OK},
        {"CLN-004: in INIT, without consent", ECT_READER_CHANGES_NONE, INIT, EEPROM, ECT_READER_DECLINED},
        {"CLN-004: in PREOP", ECT_READER_CHANGES_NONE, PREOP, EEPROM | MAIL, ECT_READER_OK},
        {"CLN-004: in OP", ECT_READER_CHANGES_INIT, OP, EEPROM | MAIL, ECT_READER_OK},
    };
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const ect_reader_config_t config = {.changes = cases[i].changes};
        liar_t l;
        size_t size;
        liar_open(&l, &testdev, &kind);
        if (cases[i].state != INIT)
            wire_go(&l.w, 0, cases[i].state);
        assert_int_equal(ect_reader_open(&reader, &l.link, &config), ECT_READER_OK);
        assert_int_equal(ect_reader_sii(&reader, image, 0, &size), ECT_READER_OK);
        const ect_reader_result_t result = ect_reader_dictionary(&reader, ECT_READER_ALL_VALUES, &nothing);
        ect_reader_close(&reader);
        if (l.number != cases[i].writes || result != cases[i].result)
            fail_msg("%s: wrote 0x%02X, result %d", cases[i].title, (unsigned int)l.number, (int)result);
        assert_int_equal(wire_read8(&l.w, 0, ECT_REG_AL_STATUS), cases[i].state);
        liar_close(&l);
    }
}

/* --- another master's mailbox ------------------------------------------------------------------------------------- */

static liar_mail_t record_counters(liar_t *l, const uint8_t *r)
{
    l->number = l->number << 4 | (r[5] >> 4 & 7u);
    return LIAR_PASSES;
}

static void the_first_mail_has_no_counter_and_the_mail_of_the_master_before_is_kept(void **state)
{
    static const liar_kind_t kind = {.request = record_counters};
    static const uint8_t upload[] = {0x00, 0x20, 0x40, 0x18, 0x10, 0x01, 0, 0, 0, 0};
    static const struct {
        const char *title;
        uint8_t state;
        bool mail;
        unsigned int counters; /* of three requests, a digit each */
    } cases[] = {
        {"CLN-008: PREOP, the mailbox is empty", PREOP, false, 0x012},
        {"CLN-008: OP, with the reply to another master", OP, true, 0x012},
        {"a mailbox that the reader has started", INIT, false, 0x123},
    };
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const ect_reader_config_t config = {.changes = ECT_READER_CHANGES_INIT};
        uint8_t value[4];
        liar_t l;
        liar_open(&l, &testdev, &kind);
        if (cases[i].state != INIT)
            wire_go(&l.w, 0, cases[i].state);
        if (cases[i].mail)
            assert_int_equal(wire_mail_request(&l.w, 0, 3, upload, sizeof upload), 1);
        assert_int_equal(ect_reader_open(&reader, &l.link, &config), ECT_READER_OK);
        l.number = 0;
        for (unsigned int n = 0; n < 3; n++) {
            size_t size = sizeof value;
            assert_int_equal(ect_reader_upload(&reader, 0x1018, 1, false, value, &size), ECT_READER_OK);
        }
        if (l.number != cases[i].counters)
            fail_msg("%s: counters %03X", cases[i].title, (unsigned int)l.number);
        assert_int_equal(reader.found_size, cases[i].mail ? 16 : 0);
        assert_true(!cases[i].mail || memcmp(reader.found_mail + 9, upload + 3, 3) == 0);
        ect_reader_close(&reader);
        liar_close(&l);
    }
}

/* 0501h as the PDI has it while it reads or writes. */
static bool keep_the_eeprom_in_use(liar_t *l, uint8_t *d, uint16_t ado, uint8_t *data, uint16_t length, uint8_t *wkc)
{
    if (ado == ECT_REG_SII_CONFIG && length == 2)
        data[1] |= IN_USE;
    return collect_writes(l, d, ado, data, length, wkc);
}

static void an_eeprom_that_the_pdi_is_using_stays_with_it(void **state)
{
    static const liar_kind_t kind = {.datagram = keep_the_eeprom_in_use};
    static const struct {
        const char *title;
        ect_reader_changes_t changes;
        unsigned int writes;
        ect_reader_result_t result;
    } cases[] = {
        {"CLN-005: by force", ECT_READER_CHANGES_ALL, OWNER | EEPROM, ECT_READER_OK},
        {"CLN-005: left alone", ECT_READER_CHANGES_INIT, 0, ECT_READER_DECLINED},
        {"CLN-005: left alone in any state", ECT_READER_CHANGES_NONE, 0, ECT_READER_DECLINED},
    };
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const ect_reader_config_t config = {.changes = cases[i].changes};
        liar_t l;
        liar_open(&l, &testdev, &kind);
        const ect_reader_result_t result = ect_reader_open(&reader, &l.link, &config);
        if (l.number != cases[i].writes || result != cases[i].result)
            fail_msg("%s: wrote 0x%02X, result %d", cases[i].title, (unsigned int)l.number, (int)result);
        if (result != ECT_READER_OK)
            assert_string_equal(reader.text, "the PDI is using the EEPROM: try again later");
        ect_reader_close(&reader);
        liar_close(&l);
    }
}

/* --- states ------------------------------------------------------------------------------------------------------- */

static uint8_t put_in(liar_t *l, uint8_t state, bool error)
{
    uint16_t code;
    if (state != INIT)
        wire_go(&l->w, 0, state);
    if (error) /* a state that no slave has */
        (void)wire_al(&l->w, 0, state | 0x05, &code);
    return wire_read8(&l->w, 0, ECT_REG_AL_STATUS);
}

static void a_state_changes_only_from_init_and_with_consent(void **state)
{
    static const struct {
        const char *title;
        uint8_t state;
        bool error;
        ect_reader_changes_t changes;
        ect_reader_result_t result;
        uint8_t after;
    } cases[] = {
        {"CLN-007: INIT, consent", INIT, false, ECT_READER_CHANGES_INIT, ECT_READER_OK, INIT},
        {"CLN-007: INIT, no consent", INIT, false, ECT_READER_CHANGES_NONE, ECT_READER_DECLINED, INIT},
        {"CLN-007: INIT with error, consent", INIT, true, ECT_READER_CHANGES_INIT, ECT_READER_OK, INIT},
        {"CLN-007: INIT with error", INIT, true, ECT_READER_CHANGES_NONE, ECT_READER_DECLINED, INIT | ECT_AL_ERROR},
        {"CLN-007: PREOP", PREOP, false, ECT_READER_CHANGES_NONE, ECT_READER_OK, PREOP},
        {"CLN-007: SAFEOP", SAFEOP, false, ECT_READER_CHANGES_INIT, ECT_READER_OK, SAFEOP},
        {"CLN-007: OP", OP, false, ECT_READER_CHANGES_INIT, ECT_READER_OK, OP},
        {"CLN-007: PREOP with error", PREOP, true, ECT_READER_CHANGES_INIT, ECT_READER_OK, PREOP | ECT_AL_ERROR},
        {"CLN-007: SAFEOP with error", SAFEOP, true, ECT_READER_CHANGES_INIT, ECT_READER_OK, SAFEOP | ECT_AL_ERROR},
    };
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const ect_reader_config_t config = {.changes = cases[i].changes};
        uint8_t value[4], before[16], after[16];
        size_t size = sizeof value;
        liar_t l;
        liar_open(&l, &testdev, NULL);
        const uint8_t was = put_in(&l, cases[i].state, cases[i].error);
        assert_int_equal(was, cases[i].state | (cases[i].error ? ECT_AL_ERROR : 0));
        assert_int_equal(wire_read(&l.w, 0, ECT_REG_SM, before, sizeof before), 1);
        assert_int_equal(ect_reader_open(&reader, &l.link, &config), ECT_READER_OK);
        const ect_reader_result_t result = ect_reader_upload(&reader, 0x1018, 1, false, value, &size);
        ect_reader_close(&reader);
        const uint8_t is = wire_read8(&l.w, 0, ECT_REG_AL_STATUS);
        if (result != cases[i].result || is != cases[i].after)
            fail_msg("%s: result %d, state 0x%02X", cases[i].title, (int)result, is);
        assert_int_equal(wire_read(&l.w, 0, ECT_REG_SM, after, sizeof after), 1);
        before[ECT_SM_STATUS] = after[ECT_SM_STATUS];
        before[ECT_SM_SIZE + ECT_SM_STATUS] = after[ECT_SM_SIZE + ECT_SM_STATUS];
        assert_memory_equal(before, after, sizeof before);
        liar_close(&l);
    }
}

/* The state as the slave reports it. */
static bool report_boot(liar_t *l, uint8_t *d, uint16_t ado, uint8_t *data, uint16_t length, uint8_t *wkc)
{
    if (ado == ECT_REG_AL_STATUS && d[0] != APWR_COMMAND)
        data[0] = BOOT;
    return collect_writes(l, d, ado, data, length, wkc);
}

static void a_slave_in_boot_stays_there(void **state)
{
    static const liar_kind_t kind = {.datagram = report_boot};
    const ect_reader_config_t config = {.changes = ECT_READER_CHANGES_INIT};
    uint8_t value[4];
    size_t size = sizeof value;
    liar_t l;
    (void)state;
    liar_open(&l, &testdev, &kind);
    assert_int_equal(ect_reader_open(&reader, &l.link, &config), ECT_READER_OK);
    assert_int_equal(ect_reader_upload(&reader, 0x1018, 1, false, value, &size), ECT_READER_DECLINED);
    assert_string_equal(reader.text, "the slave is in BOOT, without a mailbox");
    ect_reader_close(&reader);
    assert_int_equal(l.number, EEPROM); /* CLN-007: no state was requested */
    liar_close(&l);
}

/* --- another master ----------------------------------------------------------------------------------------------- */

/* A wire on which frames come without a request, one each 10 ms. */
typedef struct traffic {
    uint64_t now_ns;
    const uint8_t *frame;
    size_t length;
    unsigned int count, received;
} traffic_t;

static uint64_t traffic_now(void *ctx)
{
    return ((traffic_t *)ctx)->now_ns;
}

static size_t traffic_receive(void *ctx, uint8_t *frame, size_t room, uint64_t until_ns)
{
    traffic_t *t = ctx;
    const bool comes = t->received < t->count;
    t->now_ns = comes ? t->now_ns + (uint64_t)10 * MILLISECOND : until_ns;
    t->received += comes;
    memcpy(frame, t->frame, comes && t->length < room ? t->length : 0);
    return comes ? t->length : 0;
}

static void a_master_is_heard_by_its_frames(void **state)
{
    static const struct {
        const char *title;
        unsigned int count; /* frames on the wire */
        uint16_t ethertype, header;
        size_t length;
        bool heard;
    } cases[] = {
        {"CLN-003: silence", 0, ETHERCAT, 0x100E, 60, false},
        {"CLN-003: one frame", 1, ETHERCAT, 0x100E, 60, true},
        {"CLN-003: frames of another protocol", 5, 0x0800, 0x100E, 60, false},
        {"CLN-003: network variables, which are no datagrams", 5, ETHERCAT, 0x400E, 60, false},
        {"CLN-003: a frame without a datagram", 5, ETHERCAT, 0x100E, 27, false},
        {"CLN-003: the shortest frame with a datagram", 1, ETHERCAT, 0x100E, 28, true},
        {"CLN-003: frames of another protocol without an end", UINT32_MAX, 0x0800, 0x100E, 60, false},
    };
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        uint8_t frame[60] = {0};
        traffic_t t = {.frame = frame, .length = cases[i].length, .count = cases[i].count};
        const ect_reader_link_t link = {.ctx = &t, .receive = traffic_receive, .now = traffic_now};
        ect_store_be16(frame + 12, cases[i].ethertype);
        ect_store_le16(frame + 14, cases[i].header);
        if (ect_reader_hears_master(&link, LISTEN_MS) != cases[i].heard)
            fail_msg("%s: expected %d", cases[i].title, cases[i].heard);
        const uint64_t expected_ms = cases[i].heard ? 10 : LISTEN_MS;
        assert_int_equal(t.now_ns / MILLISECOND, expected_ms);
    }
}

/* --- gaps --------------------------------------------------------------------------------------------------------- */

enum { GAPS = 8 };

typedef struct gaps {
    ect_reader_gap_t list[GAPS];
    size_t count;
} gaps_t;

static void see_gap(void *ctx, const ect_reader_gap_t *gap)
{
    gaps_t *g = ctx;
    assert_true(g->count < GAPS);
    g->list[g->count++] = *gap;
}

static liar_mail_t abort_with(liar_t *l, uint8_t service, const uint8_t *place, uint32_t code)
{
    uint8_t reply[8] = {service == 8 ? 0x07 : 0x80};
    if (service != 8)
        memcpy(reply + 1, place, 3);
    ect_store_le32(reply + 4, code);
    liar_set_coe_mail(l, service, reply, sizeof reply);
    return LIAR_REPLIES;
}

/* Refuses the value of 2000h, the description of 2005:00 and that of the object 2007h. */
static liar_mail_t refuse_three(liar_t *l, const uint8_t *r)
{
    const uint8_t *m = r + 8; /* behind the CoE header */
    if (r[7] >> 4 == 2 && m[0] >> 5 == 2 && ect_load_le16(m + 1) == 0x2000)
        return abort_with(l, 2, m + 1, 0x08000021);
    if (r[7] >> 4 == 8 && m[0] == 5 && ect_load_le16(m + 4) == 0x2005)
        return abort_with(l, 8, NULL, 0x06090011);
    if (r[7] >> 4 == 8 && m[0] == 3 && ect_load_le16(m + 4) == 0x2007)
        return abort_with(l, 8, NULL, 0x06020000);
    return LIAR_PASSES;
}

static void a_refused_part_of_the_dictionary_is_reported_with_its_code(void **state)
{
    static const liar_kind_t kind = {.request = refuse_three};
    static const ect_reader_gap_t expected[] = {
        {.index = 0x2000, .value = true, .result = ECT_READER_ABORTED, .code = 0x08000021},
        {.index = 0x2005, .result = ECT_READER_ABORTED, .code = 0x06090011},
        {.index = 0x2007, .whole = true, .result = ECT_READER_ABORTED, .code = 0x06020000},
    };
    gaps_t g = {.count = 0};
    const ect_reader_sink_t sink = {.ctx = &g, .object = see_object, .entry = see_entry, .gap = see_gap};
    liar_t l;
    (void)state;
    liar_open(&l, &testdev, &kind);
    assert_int_equal(ect_reader_open(&reader, &l.link, NULL), ECT_READER_OK);
    assert_int_equal(ect_reader_dictionary(&reader, ECT_READER_ALL_VALUES, &sink), ECT_READER_OK);
    assert_int_equal(g.count, 3); /* CLN-009 */
    for (size_t i = 0; i < g.count; i++) {
        assert_int_equal(g.list[i].index, expected[i].index);
        assert_int_equal(g.list[i].subindex, expected[i].subindex);
        assert_int_equal(g.list[i].whole, expected[i].whole);
        assert_int_equal(g.list[i].value, expected[i].value);
        assert_int_equal(g.list[i].result, expected[i].result);
        assert_int_equal(g.list[i].code, expected[i].code);
    }
    ect_reader_close(&reader);
    liar_close(&l);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_first_mail_has_no_counter_and_the_mail_of_the_master_before_is_kept),
        cmocka_unit_test(the_reader_writes_eeprom_state_mailbox_and_no_object),
        cmocka_unit_test(an_eeprom_that_the_pdi_is_using_stays_with_it),
        cmocka_unit_test(a_state_changes_only_from_init_and_with_consent),
        cmocka_unit_test(a_slave_in_boot_stays_there),
        cmocka_unit_test(a_master_is_heard_by_its_frames),
        cmocka_unit_test(a_refused_part_of_the_dictionary_is_reported_with_its_code),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
