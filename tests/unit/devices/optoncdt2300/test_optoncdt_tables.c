/* SPDX-License-Identifier: MIT */
/*
 * An optoNCDT 2300 before it measures: states (A 7.2.5), CoE (A 7.2.6), and, from pages of the
 * manual that are public, object directory, mapping and user level.
 */
#include <string.h>

#include "devices/optoncdt2300/optoncdt2300.h"
#include "support/ranger.h"

enum { INIT = ECT_STATE_INIT, PREOP = ECT_STATE_PREOP, SAFEOP = ECT_STATE_SAFEOP, OP = ECT_STATE_OP, ERR = 0x10 };
enum { ALL = (1 << OPTO_VALUES) - 1, DISTANCES = 1 << 5 | 1 << 7 };
#define COUNT(array) (sizeof(array) / sizeof((array)[0]))

static ranger_t r;

static int setup(void **state)
{
    (void)state;
    ranger_open(&r);
    return 0;
}

static int teardown(void **state)
{
    (void)state;
    ranger_close(&r);
    return 0;
}

static int setup_expert(void **state)
{
    setup(state);
    ranger_expert(&r);
    return 0;
}

/* --- states ------------------------------------------------------------------------------------------------------- */

static void states(void **state)
{
    static const struct {
        uint8_t al;
        bool sdo, inputs;
    } rows[] = {{PREOP, true, false}, {SAFEOP, true, true}, {OP, true, true}};
    uint8_t type = 0;
    (void)state;
    wire_advance(&r.w, 10000 * MS);
    assert_int_equal(wire_read8(&r.w, 0, ECT_REG_AL_STATUS), INIT); /* no request to leave INIT */
    assert_int_equal(wire_read(&r.w, 0, 0x0000, &type, 1), 1);      /* its registers can be read ... */
    assert_int_equal(type, 0x11);
    for (size_t i = 0; i < COUNT(rows); i++) {
        uint32_t value = 0;
        uint8_t data[8] = {0};
        wire_go(&r.w, 0, rows[i].al);
        assert_int_equal(wire_read8(&r.w, 0, ECT_REG_AL_STATUS), rows[i].al);
        assert_int_equal(ranger_upload(&r, 0x1018, 1, &value) == 0, rows[i].sdo);
        wire_advance(&r.w, 1 * MS);
        bool inputs = wire_read(&r.w, 0, RANGER_INPUTS, data, sizeof data) == 1 && ect_load_le32(data) == 10000000;
        assert_int_equal(inputs, rows[i].inputs);
    }
}

/* Mailbox SyncManagers other than described are refused, and without them no mail gets a reply. */
static void mailbox_in_init(void **state)
{
    uint8_t mail[256] = {10, 0, 0, 0, 0, 0x13, 0, 0x20, 0x40, 0x18, 0x10, 1};
    uint16_t code = 0;
    (void)state;
    assert_int_equal(wire_write(&r.w, 0, 0x1000, mail, sizeof mail), 1); /* plain memory */
    wire_advance(&r.w, 100 * MS);
    assert_int_equal(wire_al(&r.w, 0, PREOP, &code), INIT | ERR);
    assert_int_equal(code, ECT_AL_MAILBOX);
    (void)wire_al(&r.w, 0, INIT | ERR, NULL);
    wire_set_sm(&r.w, 0, 0, 0x1000, 128, 0x26);
    wire_set_sm(&r.w, 0, 1, 0x1100, 256, 0x22);
    assert_int_equal(wire_al(&r.w, 0, PREOP, &code), INIT | ERR);
    (void)wire_al(&r.w, 0, INIT | ERR, NULL);
    wire_configure_mailbox(&r.w, 0);
    assert_int_equal(wire_al(&r.w, 0, PREOP, &code), PREOP);
}

/* The configuration that SAFEOP needs: SM3, as long as the mapping; SM2 must stay off. */
static void process_sm(void **state)
{
    static const struct {
        uint16_t start, length;
        uint16_t code;
    } rows[] = {{RANGER_INPUTS, 4, ECT_AL_INPUT_SM},
                {RANGER_INPUTS, 12, ECT_AL_INPUT_SM},
                {0x1800, 8, ECT_AL_INPUT_SM},
                {RANGER_INPUTS, 8, 0}};
    (void)state;
    wire_go(&r.w, 0, PREOP);
    for (size_t i = 0; i < COUNT(rows); i++) {
        uint16_t code;
        wire_set_sm(&r.w, 0, 3, rows[i].start, rows[i].length, 0x20);
        uint8_t status = wire_al(&r.w, 0, SAFEOP, &code);
        if (status != (rows[i].code ? PREOP | ERR : SAFEOP) || code != rows[i].code)
            fail_msg("SM3 %04X, %u bytes: expected code %04X, got AL status %02X, code %04X", rows[i].start,
                     rows[i].length, rows[i].code, status, code);
        (void)wire_al(&r.w, 0, PREOP | ERR, NULL);
    }
}

/* There are no outputs, and OP does not wait for any; no watchdog ends it. */
static void no_outputs(void **state)
{
    uint16_t code = 0;
    (void)state;
    wire_go(&r.w, 0, SAFEOP);
    assert_int_equal(ranger_number(&r, 0x1C00, 3), ECT_SM_UNUSED);
    assert_int_equal(ect_device_bytes(&ect_optoncdt2300, ECT_SM_OUTPUTS), 0);
    assert_int_equal(wire_read8(&r.w, 0, ECT_REG_SM + 2 * ECT_SM_SIZE + ECT_SM_ACTIVATE), 0);
    assert_int_equal(wire_write16(&r.w, 0, ECT_REG_WD_TIME_PD, 10), 1);
    assert_int_equal(wire_al(&r.w, 0, OP, &code), OP);
    wire_advance(&r.w, 60000 * MS);
    assert_int_equal(wire_read8(&r.w, 0, ECT_REG_AL_STATUS), OP);
}

/* --- object directory --------------------------------------------------------------------------------------------- */

static void directory(void **state)
{
    static const struct {
        uint16_t index;
        uint8_t subindex;
        uint32_t value;
    } numbers[] = {{0x1000, 0, 0}, {0x1C12, 0, 0}, {0x1018, 0, 4},    {0x1018, 1, ECTWIN_VENDOR_ID},
                   {0x1A00, 0, 2}, {0x1C00, 0, 4}, {0x1C00, 1, 1},    {0x1C00, 2, 2},
                   {0x1C00, 3, 0}, {0x1C00, 4, 4}, {0x1C13, 0, 1},    {0x1C13, 1, 0x1A00},
                   {0x1C33, 1, 0}, {0x1C33, 4, 5}, {0x2001, 0, 7},    {0x2001, 1, 0},
                   {0x2005, 0, 9}, {0x21B0, 9, 1}, {0x21B0, 11, 1},   {0x2005, 2, 0x41A00000 /* 20.0 */},
                   {0x603F, 0, 2}, {0x603F, 1, 0}, {0x6065, 0, 0x11}, {0x2250, 1, 20000}};
    static const struct {
        uint16_t index;
        uint8_t subindex;
        const char *text;
    } texts[] = {{0x1008, 0, "ILD2300"}, {0x100A, 0, "V 0.100"}, {0x2005, 9, "DIFFUSE"}, {0x2005, 6, "000"}};
    (void)state;
    wire_go(&r.w, 0, PREOP);
    for (size_t i = 0; i < COUNT(numbers); i++) {
        uint32_t got = ranger_number(&r, numbers[i].index, numbers[i].subindex);
        if (got != numbers[i].value)
            fail_msg("%04Xh:%u: expected %08X, got %08X", numbers[i].index, numbers[i].subindex, numbers[i].value, got);
    }
    for (size_t i = 0; i < COUNT(texts); i++) {
        char text[64] = "";
        size_t size = sizeof text;
        assert_int_equal(wire_sdo_upload(&r.w, 0, texts[i].index, texts[i].subindex, false, (uint8_t *)text, &size), 0);
        assert_string_equal(text, texts[i].text);
    }
}

static void refusals(void **state)
{
    static const struct {
        uint16_t index;
        uint8_t subindex, size; /* 0: it is read */
        uint32_t value, code;
    } rows[] = {{0x2005, 1, 0, 0, 0x06090011},    {0x2005, 3, 0, 0, 0x06090011},     {0x2005, 8, 0, 0, 0x06090011},
                {0x2005, 10, 0, 0, 0x06090011},   {0x6040, 0, 0, 0, 0x06020000},     {0x1C12, 1, 0, 0, 0x06090011},
                {0x2001, 2, 0, 0, 0x06010001},    {0x2001, 7, 0, 0, 0x06010001},     {0x6065, 8, 0, 0, 0x06090011},
                {0x1A00, 0, 1, 1, 0x06010002},    {0x1A00, 1, 4, 0, 0x06010002},     {0x1A63, 1, 4, 0, 0x06010002},
                {0x1A64, 0, 0, 0, 0x06020000},    {0x2005, 2, 4, 0, 0x06010002},     {0x6065, 5, 4, 0, 0x06010002},
                {0x2001, 1, 1, 1, 0x06010002},    {0x2001, 4, 1, 2, 0x06090031},     {0x2131, 1, 1, 3, 0x06090031},
                {0x2250, 1, 4, 1000, 0x06090030}, {0x2250, 1, 4, 49020, 0x06090030}, {0x2250, 1, 2, 1500, 0x06070013},
                {0x21B0, 3, 1, 1, 0x06090011},    {0x21B0, 17, 1, 1, 0x06090011}};
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        uint32_t value;
        uint32_t code = rows[i].size == 0
                            ? ranger_upload(&r, rows[i].index, rows[i].subindex, &value)
                            : ranger_download(&r, rows[i].index, rows[i].subindex, rows[i].value, rows[i].size);
        if (code != rows[i].code)
            fail_msg("%04Xh:%u %s: expected %08X, got %08X", rows[i].index, rows[i].subindex,
                     rows[i].size == 0 ? "read" : "written", rows[i].code, code);
    }
}

static void identity(void **state)
{
    ect_twin_config_t twin = ect_twin_default(&ect_optoncdt2300, &ect_optoncdt2300_plant);
    const uint32_t want[] = {0x00000607, 0x003EDE73, 0x00010000, 0x009A4435};
    (void)state;
    assert_int_not_equal(ect_optoncdt2300.identity.vendor_id, want[0]); /* we are not they */
    twin.identity = (ect_identity_t){want[0], want[1], want[2], want[3]};
    wire_close(&r.w);
    wire_open_twins(&r.w, &twin, 1);
    wire_go(&r.w, 0, PREOP);
    for (uint8_t n = 0; n < COUNT(want); n++)
        assert_int_equal(ranger_number(&r, 0x1018, (uint8_t)(n + 1)), want[n]);
}

/* --- mapping ------------------------------------------------------------------------------------------------------ */

static void default_mapping(void **state)
{
    (void)state;
    wire_go(&r.w, 0, PREOP);
    assert_int_equal(ranger_number(&r, 0x1A00, 0), 2);
    assert_int_equal(ranger_number(&r, 0x1A00, 1), 0x60650520);
    assert_int_equal(ranger_number(&r, 0x1A00, 2), 0x60650720);
    assert_int_equal(ect_device_bytes(&ect_optoncdt2300, ECT_SM_INPUTS), 8);
}

static void full_mapping(void **state)
{
    static const uint32_t printed[OPTO_VALUES] = {0x60650120, 0x60650220, 0x60650320, 0x60651120, 0x60650420,
                                                  0x60650520, 0x60650620, 0x60650720, 0x60650C20, 0x60650D20,
                                                  0x60650E20, 0x60650F20, 0x60651020};
    (void)state;
    ranger_select(&r, ALL, 1);
    assert_int_equal(ranger_number(&r, 0x1A00, 0), OPTO_VALUES);
    for (uint8_t n = 0; n < OPTO_VALUES; n++)
        assert_int_equal(ranger_number(&r, 0x1A00, (uint8_t)(n + 1)), printed[n]);
    ranger_go(&r, SAFEOP);
    assert_int_equal(r.bytes, 52);
    ranger_wait(&r, 1 * MS);
    assert_int_equal(ranger_value(&r, 5), 10000000);
}

/* A selection in any order: 1A00h has it in its own order, at once; SM3 has it from the next SAFEOP on.
 */
static void selection(void **state)
{
    static const uint32_t choices[] = {DISTANCES, 0x0001, 0x1FFF, 0x1000, 0x0555, 0x0AAA, 0x0020, 0x1800, DISTANCES};
    static const uint8_t subs[OPTO_VALUES] = {1, 2, 3, 0x11, 4, 5, 6, 7, 0xC, 0xD, 0xE, 0xF, 0x10};
    (void)state;
    for (size_t i = 0; i < COUNT(choices); i++) {
        uint8_t n = 0;
        ranger_select(&r, choices[i], 1);
        for (unsigned int m = 0; m < OPTO_VALUES; m++) {
            if ((choices[i] >> m & 1) == 0)
                continue;
            uint32_t got = ranger_number(&r, 0x1A00, ++n);
            if (got != ECT_MAP(0x6065, subs[m], 32))
                fail_msg("choice %04X: 1A00h:%u is %08X", choices[i], n, got);
        }
        assert_int_equal(ranger_number(&r, 0x1A00, 0), n);
        for (uint8_t rest = (uint8_t)(n + 1); rest <= OPTO_VALUES; rest++)
            assert_int_equal(ranger_number(&r, 0x1A00, rest), 0);
        ranger_go(&r, SAFEOP);
        assert_int_equal(r.bytes, 4 * n);
        ranger_wait(&r, 1 * MS);
        assert_int_equal(wire_al(&r.w, 0, PREOP, NULL), PREOP);
    }
}

static void selection_is_refused(void **state)
{
    (void)state;
    ranger_go(&r, SAFEOP);
    assert_int_equal(ranger_download(&r, 0x21B0, 4, 1, 1), 0x08000022);
    assert_int_equal(ranger_download(&r, 0x1C13, 0, 0, 1), 0x08000022);
    assert_int_equal(wire_al(&r.w, 0, OP, NULL), OP);
    assert_int_equal(ranger_download(&r, 0x21B0, 4, 1, 1), 0x08000022);
    assert_int_equal(ranger_number(&r, 0x1A00, 0), 2);
}

static void nothing_selected(void **state)
{
    uint16_t code;
    (void)state;
    ranger_select(&r, 0, 1);
    assert_int_equal(ranger_number(&r, 0x1A00, 0), 0);
    wire_set_sm(&r.w, 0, 3, RANGER_INPUTS, 0, 0x20);
    assert_int_equal(wire_al(&r.w, 0, SAFEOP, &code), SAFEOP);
}

/* SM3 has space for 22 complete records: neither more records nor more values are possible. */
static void room(void **state)
{
    (void)state;
    ranger_select(&r, ALL, 22);
    ranger_go(&r, SAFEOP);
    assert_int_equal(r.bytes, 1144);
    ranger_wait(&r, 10 * MS);
    assert_int_equal(wire_al(&r.w, 0, PREOP, NULL), PREOP);
    ranger_write(&r, 0x1C13, 0, 0, 1);
    ranger_write(&r, 0x1C13, 23, 0x1A16, 2);
    assert_int_equal(ranger_download(&r, 0x1C13, 0, 23, 1), 0x06040042);
    ranger_select(&r, DISTANCES, 100);
    ranger_go(&r, SAFEOP);
    assert_int_equal(r.bytes, 800);
    assert_int_equal(wire_al(&r.w, 0, PREOP, NULL), PREOP);
    assert_int_equal(ranger_download(&r, 0x21B0, 4, 1, 1), 0x06040042); /* 1200 bytes */
    assert_int_equal(ranger_number(&r, 0x1A00, 0), 2);
    ranger_write(&r, 0x21B0, 9, 1, 1); /* selected values need no more space */
    ranger_select(&r, DISTANCES, 95);
    ranger_write(&r, 0x21B0, 4, 1, 1); /* 1140 bytes */
}

static void assignment(void **state)
{
    (void)state;
    ranger_write(&r, 0x1C13, 0, 0, 1);
    assert_int_equal(ranger_download(&r, 0x1C13, 1, 0x1A64, 2), 0x06020000);
    assert_int_equal(ranger_download(&r, 0x1C13, 1, 0x1600, 2), 0x06040041);
    ranger_write(&r, 0x1C13, 1, 0x1A05, 2);
    ranger_write(&r, 0x1C13, 2, 0x1A05, 2);
    assert_int_equal(ranger_download(&r, 0x1C13, 0, 2, 1), 0x06040043); /* one PDO twice */
    ranger_write(&r, 0x1C13, 0, 1, 1);                                  /* any one alone: the last record */
    ranger_go(&r, OP);
    ranger_wait(&r, 1 * MS);
    assert_int_equal(ranger_value(&r, 0), 10000000);
}

/* --- user level --------------------------------------------------------------------------------------------------- */

static void user_level(void **state)
{
    static const struct {
        uint16_t index;
        uint8_t subindex, size;
        uint32_t value;
    } settings[] = {{0x2001, 4, 1, 0}, {0x2131, 1, 1, 0}, {0x2181, 1, 1, 1}, {0x21B0, 9, 1, 1}, {0x2250, 1, 4, 20000}};
    (void)state;
    wire_go(&r.w, 0, PREOP);
    for (unsigned int round = 0; round < 3; round++) {
        bool expert = round == 1;
        assert_int_equal(ranger_number(&r, 0x2001, 1), expert);
        for (size_t i = 0; i < COUNT(settings); i++) {
            uint32_t code =
                ranger_download(&r, settings[i].index, settings[i].subindex, settings[i].value, settings[i].size);
            if (code != (expert ? 0 : 0x08000021))
                fail_msg("round %u, %04Xh:%u: got %08X", round, settings[i].index, settings[i].subindex, code);
        }
        (void)ranger_number(&r, 0x2250, 1); /* every user level may read */
        assert_int_equal(ranger_text(&r, 0x2001, 5, "000"), expert ? 0 : 0x08000021);
        if (round == 0) {
            assert_int_equal(ranger_text(&r, 0x2001, 2, "001"), 0x08000020);
            assert_int_equal(ranger_text(&r, 0x2001, 2, "0000"), 0x08000020);
            assert_int_equal(ranger_number(&r, 0x2001, 1), 0);
            assert_int_equal(ranger_text(&r, 0x2001, 2, "000"), 0);
        } else {
            ranger_write(&r, 0x2001, 3, 0, 1); /* FALSE is no logout */
            assert_int_equal(ranger_number(&r, 0x2001, 1), expert);
            ranger_write(&r, 0x2001, 3, 1, 1);
            assert_int_equal(ranger_number(&r, 0x2001, 3), 0);
        }
    }
}

static uint32_t change_password(const char *old, const char *new, const char *repeat)
{
    assert_int_equal(ranger_text(&r, 0x2001, 5, old), 0);
    assert_int_equal(ranger_text(&r, 0x2001, 6, new), 0);
    return ranger_text(&r, 0x2001, 7, repeat);
}

static void passwords(void **state)
{
    static const struct {
        const char *old, *new, *repeat;
        uint32_t code;
    } rows[] = {{"111", "abc", "abc", 0x08000020},
                {"000", "abc", "abd", 0x08000020},
                {"000", "ab1", "ab1", 0x08000020},
                {"000", "1ab", "1ab", 0x08000020},
                {"000", "@ab", "@ab", 0x08000020},
                {"000", "a[b", "a[b", 0x08000020},
                {"000", "`", "`", 0x08000020},
                {"000", "ab{", "ab{", 0x08000020},
                {"000", "abc", "ab", 0x08000020},
                {"000", "abc", "abcd", 0x08000020},
                {"000", "Geheim", "Geheim", 0},
                {"000", "abc", "abc", 0x08000020},
                {"Geheim", "abcdefghijklmnopqrstuvwxyzABCDE", "abcdefghijklmnopqrstuvwxyzABCDE", 0},
                {"abcdefghijklmnopqrstuvwxyzABCDE", "Z", "Z", 0}};
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        uint32_t code = change_password(rows[i].old, rows[i].new, rows[i].repeat);
        if (code != rows[i].code)
            fail_msg("'%s' to '%s', '%s': expected %08X, got %08X", rows[i].old, rows[i].new, rows[i].repeat,
                     rows[i].code, code);
    }
    assert_int_equal(ranger_text(&r, 0x2001, 7, "Z"), 0x08000020); /* each change needs old and new */
    ranger_write(&r, 0x2001, 3, 1, 1);
    assert_int_equal(ranger_text(&r, 0x2001, 2, "000"), 0x08000020);
    assert_int_equal(ranger_text(&r, 0x2001, 2, "Z"), 0);
}

/* Password and default user are kept without power, all other settings return to the factory settings. */
static void power_cycle(void **state)
{
    (void)state;
    assert_int_equal(change_password("000", "Z", "Z"), 0);
    ranger_select(&r, ALL, 3);
    ranger_write(&r, 0x2250, 1, 5000, 4);
    for (uint32_t user = 0; user < 2; user++) {
        ranger_write(&r, 0x2001, 4, user, 1);
        signal_set(&r.w, "restart", "1");
        wire_advance(&r.w, 1 * MS);
        wire_assign_stations(&r.w);
        assert_int_equal(wire_read8(&r.w, 0, ECT_REG_AL_STATUS), INIT);
        wire_go(&r.w, 0, PREOP);
        assert_int_equal(ranger_number(&r, 0x2001, 1), user);
        assert_int_equal(ranger_number(&r, 0x2001, 4), user);
        assert_int_equal(ranger_number(&r, 0x1A00, 0), 2);
        assert_int_equal(ranger_number(&r, 0x1C13, 0), 1);
        assert_int_equal(ranger_number(&r, 0x2250, 1), 20000);
        assert_int_equal(ranger_text(&r, 0x2001, 2, "Z"), 0);
    }
}

static void signals(void **state)
{
    static const struct {
        const char *name, *value, *why;
    } refused[] = {{"surface1.fault", "5", "0, 6, 7 or 8"},
                   {"surface1.fault", "9", "0..8"},
                   {"surface1.distance", "2148", "-2147"},
                   {"surface3.present", "1", ""},
                   {"surface1.noise", "-1", "0..100"},
                   {"surface2.source", "4", "0..3"},
                   {"rate", "20001", "49140"},
                   {"rate", "1000", "1500"},
                   {"range", "0", "1..500"},
                   {"distance1", "5", "twin's own"},
                   {"user", "2", "0..1"},
                   {"exposure", "1311", "0..1310"}};
    static const char *const buttons[] = {"restart", "row_add", "row_clear", "statistic_reset"};
    (void)state;
    for (size_t i = 0; i < COUNT(refused); i++) {
        char message[ECT_SIGNAL_MESSAGE] = "";
        ect_signal_ref_t ref;
        if (!ect_chain_signal(r.w.chain, 0, refused[i].name, &ref)) {
            assert_string_equal(refused[i].why, "");
            continue;
        }
        if (signal_try_set(&r.w, refused[i].name, refused[i].value, message) || !strstr(message, refused[i].why))
            fail_msg("%s=%s: expected a refusal with '%s', got '%s'", refused[i].name, refused[i].value, refused[i].why,
                     message);
    }
    uint8_t before = wire_read8(&r.w, 0, ECT_REG_AL_STATUS);
    for (size_t i = 0; i < COUNT(buttons); i++)
        signal_set(&r.w, buttons[i], "0");
    assert_int_equal(wire_read8(&r.w, 0, ECT_REG_AL_STATUS), before);
    assert_int_equal(signal_number(&r.w, "rows"), 0);
    signal_set(&r.w, "error_number", "32");
    signal_set(&r.w, "error_text", "E32 Timeout");
    wire_go(&r.w, 0, PREOP);
    assert_int_equal(ranger_number(&r, 0x603F, 1), 32);
    signal_set(&r.w, "range", "50");
    assert_int_equal(ranger_number(&r, 0x2005, 2), 0x42480000); /* 50.0 */
}

int main(void)
{
#define T(title, function) {title, function, setup, teardown, NULL}
#define E(title, function) {title, function, setup_expert, teardown, NULL}
    const struct CMUnitTest tests[] = {
        T("OPT-001 OPT-003 OPT-005 OPT-006: INIT, PREOP, SAFEOP and OP permit their services", states),
        T("OPT-001 OPT-002: no mailbox before its SyncManagers are configured as described", mailbox_in_init),
        T("OPT-004: SAFEOP needs SM3 as long as the mapping", process_sm),
        T("OPT-005 OPT-006 OPT-009: no outputs to wait for, SM2 unused (public manual, p. 151)", no_outputs),
        T("OPT-007 OPT-008: the object directory reads as printed (public manual, pp. 157, 161, 172)", directory),
        E("OPT-007 OPT-008: missing and read-only entries are refused", refusals),
        T("OPT-012: identity can be that of the manual (public, p. 157), the default is a placeholder", identity),
        T("OPT-011: distance 1 and distance 2 by default (public manual, p. 153)", default_mapping),
        E("OPT-010: all thirteen measurements in the printed order (public manual, p. 157)", full_mapping),
        E("OPT-010: 1A00h follows the selection in 21B0h (public manual, p. 153)", selection),
        E("OPT-010: it can be changed in PREOP only (public manual, p. 153)", selection_is_refused),
        E("OPT-010: no selection, no process data", nothing_selected),
        E("OPT-010: no selection and no assignment beyond the capacity of SM3", room),
        E("1C13h (public manual, p. 174): each PDO once, and only existing ones", assignment),
        T("OPT-014: settings require the user level expert (public manual, pp. 131, 161)", user_level),
        E("OPT-014: a password is changed with the old one, and consists of letters (public manual, p. 131)",
          passwords),
        E("OPT-014: the default user is logged in after power-on (public manual, p. 131)", power_cycle),
        T("signals are refused with a reason, and buttons do nothing at 0", signals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
