/* SPDX-License-Identifier: MIT */
/* Network files played on twins: every command gets the reply that the file expects; a line names the one that does
 * not. */
#include "bus_of_twins.h"

#include <stdlib.h>

enum { TEXT = 1 << 16 };

static const char *const machine_words[] = {"--quiet", "eni:" ENI_FILES "/machine.xml"};

/* A file, with one text replaced. NULL: unchanged */
static ect_eni_t *file_with(const char *path, const char *from, const char *to)
{
    static char file[TEXT], changed[3 * TEXT];
    char why[400] = "";
    FILE *in = fopen(path, "re");
    assert_non_null(in);
    file[fread(file, 1, sizeof file - 1, in)] = '\0';
    (void)fclose(in);
    char *at = from != NULL ? strstr(file, from) : file;
    if (at == NULL)
        fail_msg("the file has no \"%s\"", from);
    (void)snprintf(changed, sizeof changed, "%.*s%s%s", (int)(at - file), file, from != NULL ? to : "",
                   at + (from != NULL ? strlen(from) : 0));
    ect_eni_t *eni = ect_eni_parse("m.xml", changed, strlen(changed), why, sizeof why);
    if (eni == NULL)
        fail_msg("%s", why);
    return eni;
}

static ect_eni_t *machine_with(const char *from, const char *to)
{
    return file_with(ENI_FILES "/machine.xml", from, to);
}

static void CF_N02_the_commands_of_a_file_bring_its_bus_to_OP_with_every_counter_as_expected(void **state)
{
    enum { CYCLES = 100 };
    bus_of_twins_t b;
    (void)state;
    bus_open(&b, 2, machine_words);
    ect_eni_player_t player = {.eni = machine_with(NULL, NULL), .wire = &b.wire};
    if (!ect_eni_play(&player, ECT_ENI_OPERATIONAL))
        fail_msg("%s", b.lines);
    assert_int_equal(player.state, ECT_ENI_OPERATIONAL);
    for (unsigned int i = 0; i < CYCLES; i++)
        assert_true(ect_eni_play_cycle(&player));
    assert_string_equal(b.lines, "");
    ect_eni_close((ect_eni_t *)(uintptr_t)player.eni);
    ectwin_bus_close(b.bus);
}

static void a_state_is_reached_step_by_step(void **state)
{
    static const unsigned int steps[] = {ECT_ENI_PREOP, ECT_ENI_PREOP, ECT_ENI_SAFEOP, ECT_ENI_OPERATIONAL};
    bus_of_twins_t b;
    (void)state;
    bus_open(&b, 2, machine_words);
    ect_eni_t *eni = machine_with(NULL, NULL);
    ect_eni_player_t player = {.eni = eni, .wire = &b.wire};
    for (size_t i = 0; i < sizeof steps / sizeof steps[0]; i++) {
        assert_true(ect_eni_play(&player, steps[i]));
        assert_int_equal(player.state, steps[i]);
        assert_true(ect_eni_play_cycle(&player));
    }
    ect_eni_close(eni);
    ectwin_bus_close(b.bus);
}

#define VENDOR                "<Data>570e0000</Data>"
#define COE(index, sub, data) "<Index>" index "</Index><SubIndex>" sub "</SubIndex><Data>" data "</Data>"

/* The bus is that of the unchanged file; the file that is played has one text changed. */
static const struct {
    const char *title, *from, *to;
    unsigned int reached;
    const char *line; /* without file and line number */
} changes[] = {
    {"ENI-018 another identity than expected", VENDOR, "<Data>580e0000</Data>", 0,
     "EEPROM: check vendor id: the reply is 0xE57, which Validate refuses\n"},
    {"ENI-018 another number of slaves", "<DataLength>2</DataLength><Cnt>3</Cnt>",
     "<DataLength>2</DataLength><Cnt>4</Cnt>", 0, "count slaves: the working counter is 3, not 4\n"},
    {"ENI-018 no slave at all", "<DataLength>2</DataLength><Cnt>3</Cnt>", "<DataLength>2</DataLength><Cnt>0</Cnt>", 0,
     "count slaves: the working counter is 3, not 0\n"},
    {"an absent slave", "<Adp>65535</Adp>", "<Adp>65530</Adp>", 0,
     "station address: the working counter is 0, not 1\n"},
    {"ENI-013 a mailbox with another length", "00108000260001008010800022000100", "00108100260001008010800022000100", 0,
     "check PREOP: the reply is 0x11, which Validate refuses\n"},
    {"ENI-013 a SyncManager with another length", "0011060064000100", "0011050064000100", ECT_ENI_PREOP,
     "check SAFEOP: the reply is 0x12, which Validate refuses\n"},
    {"ENI-015 an object that does not exist", COE("32768", "1", "f401"), COE("32769", "1", "f401"), ECT_ENI_PREOP,
     "slave 2, 8001:1: abort code 0x06020000\n"},
    {"ENI-015 a value of another size", COE("32768", "1", "f401"), COE("32768", "1", "f4010000"), ECT_ENI_PREOP,
     "slave 2, 8000:1: abort code 0x06070012\n"},
    {"ENI-015 an object that is read-only", COE("32768", "1", "f401"), COE("4120", "1", "f4010000"), ECT_ENI_PREOP,
     "slave 2, 1018:1: abort code 0x06010002\n"},
    {"ENI-015 a PDO that does not exist", COE("7186", "1", "0016"), COE("7186", "1", "0116"), ECT_ENI_PREOP,
     "slave 2, 1C12:1: abort code 0x"},
    {"ENI-015 an object that cannot be read", "<Index>4096</Index><SubIndex>0</SubIndex>",
     "<Index>4096</Index><SubIndex>1</SubIndex>", ECT_ENI_SAFEOP, "slave 2, 1000:1: abort code 0x06090011\n"},
};

static void a_command_with_another_reply_is_named_and_the_next_state_is_not_entered(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof changes / sizeof changes[0]; i++) {
        bus_of_twins_t b;
        bus_open(&b, 2, machine_words);
        ect_eni_t *eni = machine_with(changes[i].from, changes[i].to);
        ect_eni_player_t player = {.eni = eni, .wire = &b.wire};
        const bool fine = ect_eni_play(&player, ECT_ENI_OPERATIONAL);
        if (fine || player.state != changes[i].reached || strncmp(b.lines, "m.xml:", 6) != 0 ||
            strstr(b.lines, changes[i].line) == NULL)
            fail_msg("%s: expected \"%s\" behind state %u, got state %u and \"%s\"", changes[i].title, changes[i].line,
                     changes[i].reached, player.state, b.lines);
        ect_eni_close(eni);
        ectwin_bus_close(b.bus);
    }
}

static void ENI_016_a_cyclic_command_with_another_counter_is_named(void **state)
{
    static const struct {
        const char *from, *to, *line;
    } rows[] = {
        {"<Cnt>9</Cnt>", "<Cnt>8</Cnt>", "cyclic command: the working counter is 9, not 8\n"},
        {"<Addr>65536</Addr>", "<Addr>65544</Addr>", "cyclic command: the working counter is 0, not 9\n"},
        {"<DataLength>8</DataLength><Cnt>9", "<DataLength>7</DataLength><Cnt>9",
         "cyclic command: the working counter is 6, not 9\n"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        bus_of_twins_t b;
        bus_open(&b, 2, machine_words);
        ect_eni_t *eni = machine_with(rows[i].from, rows[i].to);
        ect_eni_player_t player = {.eni = eni, .wire = &b.wire};
        assert_true(ect_eni_play(&player, ECT_ENI_SAFEOP));
        assert_false(ect_eni_play_cycle(&player));
        if (strstr(b.lines, rows[i].line) == NULL)
            fail_msg("expected \"%s\", got \"%s\"", rows[i].line, b.lines);
        ect_eni_close(eni);
        ectwin_bus_close(b.bus);
    }
}

/* --- comparisons -------------------------------------------------------------------------------------------------- */

/* A wire on which every slave is the same memory: each read gives `value` and a counter of 1. */
typedef struct fake {
    uint8_t value[2];
    unsigned int frames, lines;
    bool silent;
} fake_t;

static bool fake_exchange(void *ctx, uint8_t *frame, size_t length)
{
    fake_t *fake = ctx;
    expect_frame(frame, length);
    fake->frames++;
    memcpy(frame + 26, fake->value, sizeof fake->value);
    frame[26 + frame[22]] = 1; /* behind the data */
    return !fake->silent;
}

static void fake_wait(void *ctx, uint64_t ns)
{
    (void)ctx;
    (void)ns;
}

static void fake_report(void *ctx, const char *line)
{
    fake_t *fake = ctx;
    assert_non_null(strstr(line, "t.xml:"));
    fake->lines++;
}

static void ENI_005_every_comparison_of_Validate_decides_with_mask_and_sign(void **state)
{
    static const struct {
        const char *validate;
        uint8_t value[2];
        bool fits;
    } rows[] = {
        {"<Validate><Data>0102</Data>", {1, 2}, true},
        {"<Validate><Data>0102</Data>", {1, 3}, false},
        {"<Validate><Data>0102</Data><DataMask>FF00</DataMask>", {1, 3}, true},
        {"<Validate Type='NOT_EQ'><Data>0102</Data>", {1, 3}, true},
        {"<Validate Type='NOT_EQ'><Data>0102</Data>", {1, 2}, false},
        {"<Validate Type='G'><Data>0102</Data>", {2, 2}, true},
        {"<Validate Type='G'><Data>0102</Data>", {1, 2}, false},
        {"<Validate Type='G'><Data>0100</Data>", {0, 0x80}, true},
        {"<Validate Type='G' Signed='1'><Data>0100</Data>", {0, 0x80}, false},
        {"<Validate Type='G'><Data>0102</Data><DataMask>00FF</DataMask>", {2, 2}, false},
        {"<Validate Type='L'><Data>0102</Data>", {0, 2}, true},
        {"<Validate Type='L'><Data>0102</Data>", {1, 2}, false},
        {"<Validate Type='EQ_OR_G'><Data>0102</Data>", {1, 2}, true},
        {"<Validate Type='EQ_OR_G'><Data>0102</Data>", {0, 2}, false},
        {"<Validate Type='EQ_OR_L'><Data>0102</Data>", {1, 2}, true},
        {"<Validate Type='EQ_OR_L'><Data>0102</Data>", {2, 2}, false},
        {"<Validate Type='NONE'><Data>0102</Data>", {9, 9}, true},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char text[700];
        (void)snprintf(text, sizeof text,
                       ENI_HEAD "<Slave>" ENI_INFO(
                           "") "<InitCmds><InitCmd><Transition>IP</Transition><Cmd>4</Cmd>"
                               "<Ado>0</Ado><DataLength>2</DataLength>%s<Timeout>5</Timeout></Validate></InitCmd>"
                               "</InitCmds></Slave>" ENI_TAIL,
                       rows[i].validate);
        fake_t fake = {.value = {rows[i].value[0], rows[i].value[1]}};
        const ect_eni_wire_t wire = {.ctx = &fake, .exchange = fake_exchange, .wait = fake_wait, .report = fake_report};
        ect_eni_t *eni = eni_of(rows[i].validate, text);
        ect_eni_player_t player = {.eni = eni, .wire = &wire};
        if (ect_eni_play(&player, ECT_ENI_PREOP) != rows[i].fits || fake.lines != !rows[i].fits)
            fail_msg("%s with %02X%02X", rows[i].validate, rows[i].value[0], rows[i].value[1]);
        assert_int_equal(fake.frames, rows[i].fits ? 1 : 6); /* once a millisecond until the end */
        ect_eni_close(eni);
    }
}

/* The end of a Validate that never fits. */
static void ENI_022_a_command_is_repeated_until_its_Timeout_and_a_minute_at_most(void **state)
{
    static const struct {
        const char *timeout;
        unsigned int frames;
    } rows[] = {{"59999", 60000}, {"60001", 60001}, {"4294967295", 60001}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char text[700];
        (void)snprintf(text, sizeof text,
                       ENI_COMMAND("<Transition>IP</Transition><Cmd>4</Cmd><Ado>0</Ado><DataLength>2</DataLength>"
                                   "<Validate><Data>0102</Data><Timeout>%s</Timeout></Validate>"),
                       rows[i].timeout);
        fake_t fake = {.value = {9, 9}};
        const ect_eni_wire_t wire = {.ctx = &fake, .exchange = fake_exchange, .wait = fake_wait, .report = fake_report};
        ect_eni_t *eni = eni_of(rows[i].timeout, text);
        ect_eni_player_t player = {.eni = eni, .wire = &wire};
        assert_false(ect_eni_play(&player, ECT_ENI_PREOP));
        assert_int_equal(fake.frames, rows[i].frames);
        ect_eni_close(eni);
    }
}

static void a_wire_without_replies_is_named(void **state)
{
    static const char text[] = ENI_HEAD "<Slave>" ENI_INFO(
        "") "<InitCmds><InitCmd><Transition>IP</Transition><Cmd>4</Cmd><Ado>0</Ado><DataLength>2</DataLength></InitCmd>"
            "</InitCmds></Slave><Cyclic><Frame><Cmd><State>PREOP</State><Cmd>7</Cmd><Ado>0</Ado><DataLength>1</"
            "DataLength>"
            "</Cmd></Frame></Cyclic>" ENI_TAIL;
    fake_t fake = {.silent = true};
    const ect_eni_wire_t wire = {.ctx = &fake, .exchange = fake_exchange, .wait = fake_wait, .report = fake_report};
    (void)state;
    ect_eni_t *eni = eni_of("silent", text);
    ect_eni_player_t player = {.eni = eni, .wire = &wire};
    assert_false(ect_eni_play(&player, ECT_ENI_PREOP));
    assert_int_equal(player.reported, 1);
    assert_int_equal(fake.frames, 4); /* three repeats */
    player.state = ECT_ENI_PREOP;
    assert_false(ect_eni_play_cycle(&player));
    assert_int_equal(player.reported, 2);
    assert_int_equal(fake.frames, 5);
    ect_eni_close(eni);
}

static void a_mailbox_that_is_too_short_for_a_command_is_named(void **state)
{
#define EOE_OF(length)                                                                                                 \
    ENI_ONE("", "<Mailbox><Send><Start>4096</Start><Length>" length "</Length></Send><Recv><Start>4160</Start>"        \
                "<Length>64</Length></Recv><EoE><InitCmd><Transition>PS</Transition><Type>0</Type>"                    \
                "<Data>0000000000000000</Data></InitCmd></EoE></Mailbox>")
    static const struct {
        const char *text;
        unsigned int lines;
    } rows[] = {
        {ENI_COE("<Transition>PS</Transition><Index>4096</Index><SubIndex>0</SubIndex><Data>00</Data>"), 1},
        {EOE_OF("17"), 1},
        {EOE_OF("18"), 0},
        {EOE_OF("1487"), 1},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        fake_t fake = {.silent = false};
        const ect_eni_wire_t wire = {.ctx = &fake, .exchange = fake_exchange, .wait = fake_wait, .report = fake_report};
        ect_eni_t *eni = eni_of("short", rows[i].text);
        ect_eni_player_t player = {.eni = eni, .wire = &wire, .state = ECT_ENI_PREOP};
        assert_int_equal(ect_eni_play(&player, ECT_ENI_SAFEOP), rows[i].lines == 0);
        assert_int_equal(fake.lines, rows[i].lines);
        assert_int_equal(fake.frames > 0, rows[i].lines == 0);
        ect_eni_close(eni);
    }
}

/* --- slaves and mailboxes that are waited for --------------------------------------------------------------------- */

/* A wire on which time is counted: two slaves with an AL status each, and mailboxes that take and give mails or do not.
 */
typedef struct waiting {
    uint16_t statuses[2]; /* the first and the second read; then the second; 0: no reply */
    uint16_t code;
    bool takes;
    unsigned int status_reads, writes, reads, cycles;
    uint64_t ns;
    char line[300];
} waiting_t;

enum { CMD_FPRD = 4, CMD_FPWR = 5, CMD_BRD = 7, BOX_OUT = 0x1000, BOX_IN = 0x1040 };

static bool waiting_exchange(void *ctx, uint8_t *frame, size_t length)
{
    static const uint8_t sms[16] = {0, 0x10, 64, 0, 0x26, 0, 1, 0, 0x40, 0x10, 64, 0, 0x22, 0, 1, 0};
    static const uint8_t preop[2] = {2, 0};
    waiting_t *w = ctx;
    uint8_t *data = frame + 26;
    const uint8_t command = frame[16];
    const uint16_t adp = ect_load_le16(frame + 18), ado = ect_load_le16(frame + 20), bytes = ect_load_le16(frame + 22);
    bool processed = true;
    expect_frame(frame, length);
    if (command == CMD_FPWR && ado == 0x0800) {
        assert_int_equal(bytes, sizeof sms);
        assert_memory_equal(data, sms, sizeof sms);
    } else if (command == CMD_FPWR && ado == 0x0120) {
        assert_int_equal(bytes, sizeof preop);
        assert_memory_equal(data, preop, sizeof preop);
    } else if (command == CMD_FPRD && ado == 0x0130) {
        assert_int_equal(bytes, 6);
        ect_store_le16(data, w->statuses[w->status_reads++ > 0]);
        ect_store_le16(data + 4, w->code);
        processed = w->statuses[0] != 0;
    } else if (command == CMD_FPWR && ado == BOX_OUT) {
        w->writes++;
        processed = w->takes;
    } else if (command == CMD_FPRD && ado == BOX_IN) {
        w->reads++;
        processed = false;
    } else if (command == CMD_BRD) {
        w->cycles++;
    } else {
        assert_int_equal(ado, 0x0010); /* of the station address, by position */
        assert_int_equal(ect_load_le16(data), 0x1001 + (uint16_t)(0 - adp));
    }
    ect_store_le16(data + bytes, processed);
    return true;
}

static void waiting_wait(void *ctx, uint64_t ns)
{
    ((waiting_t *)ctx)->ns += ns;
}

static void waiting_report(void *ctx, const char *line)
{
    waiting_t *w = ctx;
    (void)snprintf(w->line, sizeof w->line, "%s", line);
}

#define WAITING_SLAVE(disabled, timeout)                                                                               \
    "<Slave>" ENI_INFO("") "<Mailbox><Send><Start>4096</Start><Length>64</Length></Send><Recv><Start>4160</Start>"     \
                           "<Length>64</Length></Recv><CoE><InitCmd><Transition>PS</Transition><Index>4096</Index>"    \
                           "<Timeout>" timeout "</Timeout><Disabled>" disabled "</Disabled></InitCmd></CoE></Mailbox>" \
                           "</Slave>"
#define WAITING_CYCLE "<Cyclic><Frame><Cmd><State>PREOP</State><Cmd>7</Cmd><Ado>0</Ado></Cmd></Frame></Cyclic>"

static void ENI_024_PREOP_is_waited_for_a_second_or_until_an_error(void **state)
{
    static const char text[] = ENI_HEAD WAITING_SLAVE("1", "0") WAITING_SLAVE("1", "0") ENI_TAIL;
    static const struct {
        const char *title;
        uint16_t statuses[2], code;
        unsigned int reads; /* of AL status of both slaves, each a millisecond after the one before */
        const char *line;
    } rows[] = {
        {"at once", {2, 2}, 0, 2, ""},
        {"at the second read", {1, 2}, 0, 3, ""},
        {"never",
         {1, 1},
         0,
         2000,
         "t.xml:1: slave 2 does not enter PREOP with the mailbox of the file: AL status 0x0001, "
         "code 0x0000"},
        {"an error",
         {0x11, 0x12},
         0x0016,
         2,
         "t.xml:1: slave 2 does not enter PREOP with the mailbox of the file: "
         "AL status 0x0012, code 0x0016"},
        {"another state",
         {3, 4},
         0,
         2,
         "t.xml:1: slave 2 does not enter PREOP with the mailbox of the file: "
         "AL status 0x0004, code 0x0000"},
        {"no reply",
         {0, 0},
         0x0016,
         2000,
         "t.xml:1: slave 2 does not enter PREOP with the mailbox of the file: "
         "AL status 0x0000, code 0x0000"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        waiting_t w = {.statuses = {rows[i].statuses[0], rows[i].statuses[1]}, .code = rows[i].code};
        const ect_eni_wire_t wire = {
            .ctx = &w, .exchange = waiting_exchange, .wait = waiting_wait, .report = waiting_report};
        ect_eni_t *eni = eni_of(rows[i].title, text);
        ect_eni_player_t player = {.eni = eni, .wire = &wire};
        const bool fine = ect_eni_play(&player, ECT_ENI_PREOP);
        if (fine != (rows[i].line[0] == '\0') || w.status_reads != rows[i].reads ||
            w.ns != rows[i].reads * 1000000ull || strcmp(w.line, rows[i].line) != 0)
            fail_msg("%s: expected %u reads and \"%s\", got %u in %llu ns and \"%s\"", rows[i].title, rows[i].reads,
                     rows[i].line, w.status_reads, (unsigned long long)w.ns, w.line);
        ect_eni_close(eni);
    }
}

/* While the player waits, it sends the cyclic frames every millisecond. */
static void ENI_015_a_mailbox_is_tried_for_a_second_or_the_Timeout_of_the_command(void **state)
{
    static const struct {
        const char *title, *timeout;
        bool takes;
        unsigned int writes, reads;
        const char *line;
    } rows[] = {
        {"a mailbox that stays full", "0", false, 1000, 0, "t.xml:1: slave 1, 1000:0: its mailbox accepts no mail"},
        {"no reply", "0", true, 1, 1001, "t.xml:1: slave 1, 1000:0: no reply"},
        {"no reply within the Timeout", "5", true, 1, 6, "t.xml:1: slave 1, 1000:0: no reply"},
        {"a Timeout beyond a minute", "60001", true, 1, 60001, "t.xml:1: slave 1, 1000:0: no reply"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        waiting_t w = {.takes = rows[i].takes};
        const ect_eni_wire_t wire = {
            .ctx = &w, .exchange = waiting_exchange, .wait = waiting_wait, .report = waiting_report};
        char text[1200];
        (void)snprintf(text, sizeof text, ENI_HEAD WAITING_SLAVE("0", "%s") WAITING_CYCLE ENI_TAIL, rows[i].timeout);
        ect_eni_t *eni = eni_of(rows[i].title, text);
        ect_eni_player_t player = {.eni = eni, .wire = &wire, .state = ECT_ENI_PREOP};
        const unsigned int waits = (rows[i].takes ? 0 : rows[i].writes) + rows[i].reads;
        assert_false(ect_eni_play(&player, ECT_ENI_SAFEOP));
        if (w.writes != rows[i].writes || w.reads != rows[i].reads || w.cycles != waits || w.ns != waits * 1000000ull ||
            strcmp(w.line, rows[i].line) != 0)
            fail_msg("%s: expected %u writes, %u reads, \"%s\", got %u, %u, %u cycles, %llu ns and \"%s\"",
                     rows[i].title, rows[i].writes, rows[i].reads, rows[i].line, w.writes, w.reads, w.cycles,
                     (unsigned long long)w.ns, w.line);
        ect_eni_close(eni);
    }
}

static void ENI_016_a_cycle_takes_the_shortest_CycleTime_or_a_millisecond(void **state)
{
#define CYCLE_OF(us) "<Cyclic><CycleTime>" us "</CycleTime></Cyclic>"
    static const struct {
        const char *text;
        uint64_t ns;
    } rows[] = {
        {ENI_HEAD ENI_SLAVE("", "") ENI_TAIL, 1000000},
        {ENI_HEAD ENI_SLAVE("", "") "<Cyclic/>" ENI_TAIL, 1000000},
        {ENI_HEAD ENI_SLAVE("", "") CYCLE_OF("2000") ENI_TAIL, 2000000},
        {ENI_HEAD ENI_SLAVE("", "") CYCLE_OF("2000") CYCLE_OF("500") ENI_TAIL, 500000},
        {ENI_HEAD ENI_SLAVE("", "") CYCLE_OF("500") CYCLE_OF("2000") ENI_TAIL, 500000},
        {ENI_HEAD ENI_SLAVE("", "") CYCLE_OF("0") CYCLE_OF("700") "<Cyclic/>" ENI_TAIL, 700000},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        waiting_t w = {.ns = 0};
        const ect_eni_wire_t wire = {
            .ctx = &w, .exchange = waiting_exchange, .wait = waiting_wait, .report = waiting_report};
        ect_eni_t *eni = eni_of("cycle", rows[i].text);
        ect_eni_player_t player = {.eni = eni, .wire = &wire, .state = ECT_ENI_OPERATIONAL};
        assert_true(ect_eni_play_cycle(&player));
        assert_int_equal(w.ns, rows[i].ns);
        ect_eni_close(eni);
    }
}

/* The offsets of registers, in the order of the commands. */
typedef struct order {
    char offsets[32];
    size_t count;
} order_t;

static bool order_exchange(void *ctx, uint8_t *frame, size_t length)
{
    order_t *order = ctx;
    (void)length;
    assert_true(order->count + 1 < sizeof order->offsets);
    order->offsets[order->count++] = (char)('0' + ect_load_le16(frame + 20));
    frame[26 + frame[22]] = 1;
    return true;
}

static void ENI_005_commands_of_the_master_are_played_before_or_after_those_of_the_slaves(void **state)
{
#define ORDERED(before, ado)                                                                                           \
    "<InitCmd><Transition>IP</Transition><Transition>PS</Transition>" before "<Cmd>7</Cmd><Ado>" ado                   \
    "</Ado><DataLength>1</DataLength></InitCmd>"
    static const char text[] =
        "<EtherCATConfig><Config><Master><InitCmds>" ORDERED("", "4") ORDERED("<BeforeSlave>1</BeforeSlave>", "1")
            ORDERED("<BeforeSlave>0</BeforeSlave>",
                    "5") "</InitCmds></Master>" ENI_SLAVE("", "<InitCmds>" ORDERED("", "2") "</InitCmds>")
                ENI_SLAVE("", "<InitCmds>" ORDERED("", "3") "</InitCmds>") ENI_TAIL;
    order_t order = {.count = 0};
    const ect_eni_wire_t wire = {.ctx = &order, .exchange = order_exchange, .wait = fake_wait, .report = fake_report};
    (void)state;
    ect_eni_t *eni = eni_of("order", text);
    ect_eni_player_t player = {.eni = eni, .wire = &wire};
    assert_true(ect_eni_play(&player, ECT_ENI_SAFEOP));
    assert_string_equal(order.offsets, "1234512345");
    ect_eni_close(eni);
}

/* --- mails -------------------------------------------------------------------------------------------------------- */

/* Slaves that reply to every upload, and detect a mail with the counter of the previous mail. */
typedef struct postbox {
    uint8_t last[2];
    unsigned int mails, repeated;
    unsigned int emergencies; /* before each reply */
    unsigned int left;        /* of them */
    size_t longest;           /* of the mails, with their headers */
    size_t bytes, announced;  /* of a download */
    uint8_t value[600];
    uint8_t toggle;
} postbox_t;

/* Takes the data of a download, expedited, normal or in segments (ETG.1000.6 clause 5.6.2). */
static void take_download(postbox_t *p, const uint8_t *mail, size_t size)
{
    const uint8_t command = mail[8];
    size_t at = 16, count = size - at;
    if ((command & 0xE2) == 0x22) {
        assert_int_equal(size, 16);
        at = 12;
        count = 4u - (command >> 2 & 3);
        p->announced = count;
    } else if ((command & 0xE0) == 0x20) {
        assert_int_equal(command, 0x21);
        p->announced = ect_load_le32(mail + 12);
        p->bytes = 0;
        p->toggle = 0;
    } else if ((command & 0xE0) == 0x00) {
        at = 9;
        count = size - at - (size == 16 ? command >> 1 & 7 : 0);
        assert_int_equal(command & 0x10, p->toggle);
        assert_int_equal(command & 1, p->bytes + count == p->announced);
        p->toggle ^= 0x10;
    } else {
        return;
    }
    assert_true(p->bytes + count <= sizeof p->value);
    memcpy(p->value + p->bytes, mail + at, count);
    p->bytes += count;
}

static bool postbox_exchange(void *ctx, uint8_t *frame, size_t length)
{
    enum {
        COMMAND = 16,
        ADP = 18,
        LENGTH = 22,
        DATA = 26,
        FPWR = 5,
        STATION = 1001,
        COE = 3,
        RESPONSE = 0x30,
        EMERGENCY = 0x10
    };
    postbox_t *p = ctx;
    uint8_t *mail = frame + DATA, *last = &p->last[frame[ADP] - (STATION & 0xFF)];
    (void)length;
    if (frame[COMMAND] == FPWR) {
        const uint8_t counter = mail[5] >> 4;
        const size_t size = 6u + mail[0] + 256u * mail[1];
        p->repeated += *last == counter;
        p->longest = size > p->longest ? size : p->longest;
        p->mails++;
        p->left = p->emergencies;
        assert_int_equal(ect_load_le16(mail + 2) | mail[4], 0); /* address, channel and priority */
        assert_int_equal(mail[5] & 0x8F, COE);
        assert_int_equal(ect_load_le16(mail + 6), 0x2000); /* an SDO request */
        for (size_t i = size; i < frame[LENGTH]; i++)
            assert_int_equal(mail[i], 0);
        take_download(p, mail, size);
        *last = counter;
    } else {
        mail[5] = COE;
        mail[7] = p->left > 0 ? EMERGENCY : RESPONSE;
        p->left -= p->left > 0;
    }
    mail[frame[LENGTH]] = 1;
    return true;
}

static void each_slave_gets_mails_with_counters_of_its_own(void **state)
{
#define UPLOAD(transition) "<InitCmd><Transition>" transition "</Transition><Index>4096</Index></InitCmd>"
#define BOXES(commands)                                                                                                \
    "<Mailbox><Send><Start>4096</Start><Length>64</Length></Send><Recv><Start>4160</Start><Length>64</Length></Recv>"  \
    "<CoE>" commands "</CoE></Mailbox>" NOTHING
/* A register command: the file starts the slave. */
#define NOTHING                                                                                                        \
    "<InitCmds><InitCmd><Transition>IP</Transition><Cmd>4</Cmd><Adp>1001</Adp><Ado>0</Ado><DataLength>8</"             \
    "DataLength></InitCmd></InitCmds>"
    static const char text[] = ENI_HEAD ENI_SLAVE("<PhysAddr>1001</PhysAddr>", BOXES(UPLOAD("IP") UPLOAD("PS")))
        ENI_SLAVE("<PhysAddr>1002</PhysAddr>",
                  BOXES(UPLOAD("IP") UPLOAD("IP") UPLOAD("IP") UPLOAD("IP") UPLOAD("IP") UPLOAD("IP"))) ENI_TAIL;
    postbox_t postbox = {.mails = 0};
    const ect_eni_wire_t wire = {
        .ctx = &postbox, .exchange = postbox_exchange, .wait = fake_wait, .report = fake_report};
    (void)state;
    ect_eni_t *eni = eni_of("mails", text);
    ect_eni_player_t player = {.eni = eni, .wire = &wire};
    assert_true(ect_eni_play(&player, ECT_ENI_SAFEOP));
    assert_int_equal(postbox.mails, 8);
    assert_int_equal(postbox.repeated, 0);
    ect_eni_close(eni);
}

/* 64 are skipped. */
static void emergencies_before_a_reply_are_skipped(void **state)
{
    static const char text[] =
        ENI_HEAD ENI_SLAVE("<PhysAddr>1001</PhysAddr>", BOXES(UPLOAD("IP") UPLOAD("IP"))) ENI_TAIL;
    static const unsigned int rows[][3] = {{0, 2, 0}, {1, 2, 0}, {64, 2, 0}, {65, 2, 2}}; /* mails, reports */
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        postbox_t postbox = {.emergencies = rows[i][0]};
        const ect_eni_wire_t wire = {
            .ctx = &postbox, .exchange = postbox_exchange, .wait = fake_wait, .report = fake_report};
        ect_eni_t *eni = eni_of("emergencies", text);
        ect_eni_player_t player = {.eni = eni, .wire = &wire};
        assert_int_equal(ect_eni_play(&player, ECT_ENI_PREOP), rows[i][2] == 0);
        assert_int_equal(postbox.mails, rows[i][1]);
        assert_int_equal(player.reported, rows[i][2]);
        ect_eni_close(eni);
    }
}

/* Bytes in the first mail, and in each segment: 64 minus the headers. */
static void ENI_015_a_long_value_is_sent_in_mails_that_fit_the_mailbox(void **state)
{
    enum { BOX = 64, FIRST = BOX - 16, SEGMENT = BOX - 9 };
    static const struct {
        size_t bytes;
        unsigned int mails;
        size_t longest;
    } rows[] = {{1, 1, 16},
                {3, 1, 16},
                {4, 1, 16},
                {5, 1, 21},
                {FIRST, 1, BOX},
                {FIRST + 7, 2, BOX},
                {FIRST + 6, 2, BOX},
                {FIRST + 1, 2, BOX},
                {FIRST + SEGMENT, 2, BOX},
                {FIRST + SEGMENT + 1, 3, BOX},
                {500, 10, BOX}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char data[2 * 500 + 1] = "", text[3000];
        for (size_t k = 0; k < rows[i].bytes; k++)
            (void)snprintf(data + 2 * k, 3, "%02x", (unsigned int)(k * 7 + k / 256) & 0xFF);
        (void)snprintf(text, sizeof text,
                       ENI_HEAD ENI_SLAVE("<PhysAddr>1001</PhysAddr>",
                                          BOXES("<InitCmd><Transition>PS</Transition><Index>8192</Index>"
                                                "<SubIndex>0</SubIndex><Data>%s</Data></InitCmd>")) ENI_TAIL,
                       data);
        postbox_t postbox = {.mails = 0};
        const ect_eni_wire_t wire = {
            .ctx = &postbox, .exchange = postbox_exchange, .wait = fake_wait, .report = fake_report};
        ect_eni_t *eni = eni_of("long", text);
        ect_eni_player_t player = {.eni = eni, .wire = &wire};
        assert_true(ect_eni_play(&player, ECT_ENI_SAFEOP));
        if (postbox.mails != rows[i].mails || postbox.longest != rows[i].longest)
            fail_msg("%zu bytes: expected %u mails up to %zu bytes, got %u up to %zu", rows[i].bytes, rows[i].mails,
                     rows[i].longest, postbox.mails, postbox.longest);
        assert_int_equal(postbox.announced, rows[i].bytes);
        assert_int_equal(postbox.bytes, rows[i].bytes);
        for (size_t k = 0; k < rows[i].bytes; k++)
            assert_int_equal(postbox.value[k], (k * 7 + k / 256) & 0xFF);
        ect_eni_close(eni);
    }
}

static const struct {
    const char *title, *from, *to;
    const char *line; /* NULL: OP is reached without a line */
} starts[] = {
    {"as it is", NULL, NULL, NULL},
    {"another mailbox than that of the slave", "<Start>0x1000</Start><Length>64<", "<Start>0x1000</Start><Length>62<",
     "slave 1 does not enter PREOP with the mailbox of the file: AL status 0x0011, code 0x0016\n"},
    {"a PDO that does not exist", "<Data>041a</Data>", "<Data>051a</Data>", "slave 1, 1C13:2: abort code 0x06020000\n"},
    {"an upload of an object that does not exist", "<Index>0x1018</Index>", "<Index>0x1017</Index>",
     "slave 2, 1017:1: abort code 0x06020000\n"},
};

static void ENI_024_a_slave_with_CoE_commands_alone_is_brought_to_PREOP_by_the_player(void **state)
{
    static const char *const words[] = {"--quiet", "eni:" ENI_FILES "/coe.xml"};
    (void)state;
    for (size_t i = 0; i < sizeof starts / sizeof starts[0]; i++) {
        bus_of_twins_t b;
        bus_open(&b, 2, words);
        ect_eni_t *eni = file_with(ENI_FILES "/coe.xml", starts[i].from, starts[i].to);
        ect_eni_player_t player = {.eni = eni, .wire = &b.wire};
        const bool fine = ect_eni_play(&player, ECT_ENI_OPERATIONAL);
        if (fine != (starts[i].line == NULL) || (starts[i].line != NULL && strstr(b.lines, starts[i].line) == NULL))
            fail_msg("%s: expected \"%s\", got state %u and \"%s\"", starts[i].title,
                     starts[i].line != NULL ? starts[i].line : "", player.state, b.lines);
        ect_eni_close(eni);
        ectwin_bus_close(b.bus);
    }
}

/* The first AoE command sets the NetId to which the others are addressed. */
typedef struct talk {
    const char *title, *from, *to;
    unsigned int reached;
    const char *line; /* NULL: OP is reached without a line */
} talk_t;

static const talk_t talks[] = {
    {"as it is", NULL, NULL, ECT_ENI_OPERATIONAL, NULL},
    {"AoE: another NetId",
     "<Transition>PS</Transition><Comment>read 1000h</Comment><Timeout>0</Timeout><Data>0a00000502",
     "<Transition>PS</Transition><Comment>read 1000h</Comment><Timeout>0</Timeout><Data>0a00000503", ECT_ENI_PREOP,
     "slave 1, AoE: ADS error 0x0007\n"},
    {"AoE: another index group", "02f30000 00000010", "03f30000 00000010", ECT_ENI_PREOP,
     "slave 1, AoE: ADS error 0x0702\n"},
    {"AoE: an object that does not exist", "02f30000 00000010", "02f30000 00000020", ECT_ENI_PREOP,
     "slave 1, AoE: ADS error 0x0703\n"},
    {"AoE: no ADS command", "0200 0400 0c000000 00000000 02", "0b00 0400 0c000000 00000000 02", ECT_ENI_PREOP,
     "slave 1, AoE: ADS error 0x0008\n"},
    {"AoE: a length beyond the mail", "0c000000 00000000 02", "ff000000 00000000 02", ECT_ENI_PREOP,
     "slave 1, AoE: mailbox error\n"},
    {"AoE: a command that is no longer disabled", "<Disabled>1</Disabled>", "<Disabled>0</Disabled>", ECT_ENI_SAFEOP,
     "slave 1, AoE: ADS error 0x0703\n"},
    {"EoE: an address that is cut", "00ffffff010aa8c0<", "00ffffff<", 0, "slave 1, EoE type 2: EoE result 0x0001\n"},
    {"EoE: a filter", "<Type>6</Type>", "<Type>4</Type>", ECT_ENI_PREOP, "slave 1, EoE type 4: EoE result 0x0401\n"},
    {"EoE: a response in place of a request", "<Type>6</Type>", "<Type>7</Type><Timeout>5</Timeout>", ECT_ENI_PREOP,
     "slave 1, EoE type 7: no reply\n"},
};

static void play_talk(const char *path, const talk_t *talk)
{
    char device[300];
    const char *const words[] = {"--quiet", device};
    bus_of_twins_t b;
    (void)snprintf(device, sizeof device, "eni:%s", path);
    bus_open(&b, 2, words);
    ect_eni_t *eni = file_with(path, talk->from, talk->to);
    ect_eni_player_t player = {.eni = eni, .wire = &b.wire};
    const bool fine = ect_eni_play(&player, ECT_ENI_OPERATIONAL);
    if (fine != (talk->line == NULL) || player.state != talk->reached ||
        (talk->line != NULL && strstr(b.lines, talk->line) == NULL))
        fail_msg("%s: expected \"%s\" behind state %u, got state %u and \"%s\"", talk->title,
                 talk->line != NULL ? talk->line : "", talk->reached, player.state, b.lines);
    ect_eni_close(eni);
    ectwin_bus_close(b.bus);
}

static void ENI_025_mails_of_AoE_and_EoE_get_the_reply_of_the_twin(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof talks / sizeof talks[0]; i++)
        play_talk(ENI_FILES "/mails.xml", &talks[i]);
}

#define SOE_OF(code, drive, idn, elements)                                                                             \
    "<OpCode>" code "</OpCode><DriveNo>" drive "</DriveNo><IDN>" idn "</IDN><Elements>" elements "</Elements>"

static const talk_t drives[] = {
    {"as it is", NULL, NULL, ECT_ENI_OPERATIONAL, NULL},
    {"an IDN that does not exist", SOE_OF("1", "0", "33026", "200"), SOE_OF("1", "0", "999", "200"), ECT_ENI_SAFEOP,
     "slave 1, SoE drive 0, S-0-0999: SoE error 0x1001\n"},
    {"an IDN of the last parameter set", SOE_OF("1", "0", "33026", "200"), SOE_OF("1", "0", "32767", "200"),
     ECT_ENI_SAFEOP, "slave 1, SoE drive 0, S-7-4095: SoE error 0x1001\n"},
    {"a product's IDN of the second parameter set", SOE_OF("1", "0", "33026", "200"), SOE_OF("1", "0", "36865", "200"),
     ECT_ENI_SAFEOP, "slave 1, SoE drive 0, P-1-0001: SoE error 0x1001\n"},
    {"no elements", SOE_OF("1", "0", "33026", "200"), SOE_OF("1", "0", "33026", "0"), ECT_ENI_SAFEOP,
     "slave 1, SoE drive 0, P-0-0258: SoE error 0x800C\n"},
    {"a drive that does not exist", SOE_OF("3", "1", "32", "64"), SOE_OF("3", "2", "32", "64"), ECT_ENI_PREOP,
     "slave 1, SoE drive 2, S-0-0032: SoE error 0x800A\n"},
    {"an element that is read-only", SOE_OF("3", "1", "32", "64"), SOE_OF("3", "1", "32", "4"), ECT_ENI_PREOP,
     "slave 1, SoE drive 1, S-0-0032: SoE error 0x3004\n"},
    {"a value that is too long", "<Data>d007<", "<Data>d00700<", ECT_ENI_PREOP,
     "slave 1, SoE drive 0, S-0-0001: SoE error 0x7003\n"},
    {"a write without data", "<Data>d007</Data>", "", ECT_ENI_PREOP,
     "slave 1, SoE drive 0, S-0-0001: SoE error 0x7002\n"},
    {"a list that is longer than its room", "2c012c01", "2d012c01", ECT_ENI_PREOP,
     "slave 1, SoE drive 0, P-0-0258: SoE error 0x7003\n"},
    {"a command that is no longer disabled", "<Disabled>1</Disabled>", "<Disabled>0</Disabled>", ECT_ENI_SAFEOP,
     "slave 1, SoE drive 1, S-0-0999: SoE error 0x1001\n"},
};

static void ENI_025_commands_of_SoE_get_the_reply_of_the_twin(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof drives / sizeof drives[0]; i++)
        play_talk(ENI_FILES "/soe.xml", &drives[i]);
}

/* A slave that replies to each read of its mailbox with the same mail. */
typedef struct drive {
    uint8_t mail[16];
    unsigned int reads;
} drive_t;

static bool drive_exchange(void *ctx, uint8_t *frame, size_t length)
{
    enum { COMMAND = 16, LENGTH = 22, DATA = 26, FPRD = 4 };
    drive_t *drive = ctx;
    (void)length;
    frame[DATA + frame[LENGTH]] = 1;
    if (frame[COMMAND] == FPRD) {
        drive->reads++;
        memcpy(frame + DATA, drive->mail, sizeof drive->mail);
    }
    return true;
}

static bool has_end(const char *line, const char *end)
{
    const size_t length = strlen(line), wanted = strlen(end);
    return length >= wanted && strcmp(line + length - wanted, end) == 0;
}

static void drive_report(void *ctx, const char *line)
{
    drive_t *drive = ctx;
    drive->mail[15] = has_end(line, "S-0-0017: the reply does not end") ? 'e'
                      : has_end(line, "S-0-0017: no reply")             ? 'n'
                      : has_end(line, "S-0-0017: SoE error 0x0000")     ? '0'
                      : has_end(line, "S-0-0017: SoE error 0x7009")     ? '9'
                      : has_end(line, "for this start-up command")      ? 'm'
                                                                        : '?';
}

static void ENI_025_a_reply_of_SoE_is_bounded_whatever_the_slave_sends(void **state)
{
    enum { SKIPPED = 65 };
#define READS_17(length)                                                                                               \
    ENI_ONE("", "<Mailbox><Send><Start>4096</Start><Length>" length "</Length></Send><Recv><Start>4160</Start>"        \
                "<Length>16</Length></Recv><SoE><InitCmd><Transition>PS</Transition><DriveNo>1</DriveNo><IDN>17</IDN>" \
                "</InitCmd></SoE></Mailbox>")
    static const struct {
        const char *title, *text;
        uint8_t mail[16];
        unsigned int reads;
        char line; /* 0: none */
    } rows[] = {
        {"the value", READS_17("16"), {6, 0, 0, 0, 0, 5, 0x22, 0x40, 17, 0, 1, 2}, 1, 0},
        {"a piece, for ever", READS_17("16"), {6, 0, 0, 0, 0, 5, 0x2A, 0x40, 1, 0, 1, 2}, 1 << 14, 'e'},
        {"another drive", READS_17("16"), {6, 0, 0, 0, 0, 5, 0x42, 0x40, 17, 0, 1, 2}, SKIPPED, 'n'},
        {"the reply to a write", READS_17("16"), {6, 0, 0, 0, 0, 5, 0x24, 0x40, 17, 0, 1, 2}, SKIPPED, 'n'},
        {"longer than the mailbox", READS_17("16"), {11, 0, 0, 0, 0, 5, 0x22, 0x40, 17, 0, 1, 2}, SKIPPED, 'n'},
        {"shorter than its header", READS_17("16"), {3, 0, 0, 0, 0, 5, 0x22, 0x40, 17, 0, 1, 2}, SKIPPED, 'n'},
        {"an error without code", READS_17("16"), {4, 0, 0, 0, 0, 5, 0x32, 0x40, 17, 0, 1, 2}, 1, '0'},
        {"an error", READS_17("16"), {6, 0, 0, 0, 0, 5, 0x32, 0x40, 17, 0, 9, 0x70}, 1, '9'},
        {"a mailbox for an error", READS_17("12"), {6, 0, 0, 0, 0, 5, 0x22, 0x40, 17, 0, 1, 2}, 1, 0},
        {"a mailbox without room for an error", READS_17("11"), {0}, 0, 'm'},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        drive_t drive = {.reads = 0};
        memcpy(drive.mail, rows[i].mail, sizeof drive.mail);
        const ect_eni_wire_t wire = {
            .ctx = &drive, .exchange = drive_exchange, .wait = fake_wait, .report = drive_report};
        ect_eni_t *eni = eni_of(rows[i].title, rows[i].text);
        ect_eni_player_t player = {.eni = eni, .wire = &wire, .state = ECT_ENI_PREOP};
        const bool fine = ect_eni_play(&player, ECT_ENI_SAFEOP);
        if (fine != (rows[i].line == 0) || drive.mail[15] != (uint8_t)rows[i].line || drive.reads != rows[i].reads)
            fail_msg("%s: expected %u reads and '%c', got %u and '%c'", rows[i].title, rows[i].reads, rows[i].line,
                     drive.reads, drive.mail[15]);
        ect_eni_close(eni);
    }
}

/* A drive with a mailbox of 16 bytes that stores each mail, and confirms the last one. */
typedef struct written_mails {
    uint8_t mails[4][16];
    unsigned int count;
} written_mails_t;

static bool written_exchange(void *ctx, uint8_t *frame, size_t length)
{
    enum { COMMAND = 16, LENGTH = 22, DATA = 26, FPWR = 5 };
    static const uint8_t reply[] = {4, 0, 0, 0, 0, 5, 0x24, 0x40, 17, 0};
    written_mails_t *w = ctx;
    (void)length;
    assert_int_equal(frame[LENGTH], 16);
    if (frame[COMMAND] == FPWR) {
        assert_true(w->count < 4);
        memcpy(w->mails[w->count++], frame + DATA, 16);
    } else {
        memcpy(frame + DATA, reply, sizeof reply);
    }
    frame[DATA + 16] = 1;
    return true;
}

static void written_report(void *ctx, const char *line)
{
    (void)ctx;
    fail_msg("%s", line);
}

/* Each mail has the number of further mails in place of the IDN, and the last one has the IDN. */
static void ENI_025_a_long_value_of_SoE_is_sent_in_mails_that_fit_the_mailbox(void **state)
{
    enum { ROOM = 6, VALUE = 0x80 };
    static const struct {
        size_t bytes;
        unsigned int mails;
    } rows[] = {{0, 1}, {1, 1}, {ROOM, 1}, {ROOM + 1, 2}, {2 * ROOM, 2}, {2 * ROOM + 1, 3}, {3 * ROOM + 2, 4}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char data[2 * 4 * ROOM + 1] = "", text[1500];
        for (size_t k = 0; k < rows[i].bytes; k++)
            (void)snprintf(data + 2 * k, 3, "%02x", (unsigned int)(VALUE + k));
        (void)snprintf(text, sizeof text,
                       ENI_ONE("", "<Mailbox><Send><Start>4096</Start><Length>16</Length></Send><Recv><Start>4160"
                                   "</Start><Length>16</Length></Recv><SoE><InitCmd><Transition>PS</Transition>"
                                   "<OpCode>3</OpCode><DriveNo>1</DriveNo><IDN>17</IDN><Elements>64</Elements>"
                                   "<Data>%s</Data></InitCmd></SoE></Mailbox>"),
                       data);
        written_mails_t w = {.count = 0};
        const ect_eni_wire_t wire = {
            .ctx = &w, .exchange = written_exchange, .wait = fake_wait, .report = written_report};
        ect_eni_t *eni = eni_of("writes", text);
        ect_eni_player_t player = {.eni = eni, .wire = &wire, .state = ECT_ENI_PREOP};
        assert_true(ect_eni_play(&player, ECT_ENI_SAFEOP));
        assert_int_equal(w.count, rows[i].mails);
        for (unsigned int n = 0; n < w.count; n++) {
            const unsigned int left = w.count - 1 - n;
            const size_t at = (size_t)n * ROOM, count = left > 0 ? ROOM : rows[i].bytes - at;
            uint8_t expected[16] = {
                (uint8_t)(4 + count),         0, 0, 0, 0, (uint8_t)((n + 1) << 4 | 5), left > 0 ? 0x2B : 0x23, 0x40,
                left > 0 ? (uint8_t)left : 17};
            for (size_t k = 0; k < count; k++)
                expected[10 + k] = (uint8_t)(VALUE + at + k);
            assert_memory_equal(w.mails[n], expected, sizeof expected);
        }
        ect_eni_close(eni);
    }
}

/* A slave that replies to each read of its mailbox with the same mail of AoE or EoE. */
typedef struct server {
    uint8_t mail[64];
    unsigned int reads;
    char line[200];
} server_t;

/* A mail of AoE, or one of EoE with a single fragment: address, channel, priority and the rest of the mailbox are zero.
 */
static void expect_mail(const uint8_t *mail, size_t length)
{
    const size_t size = 6u + ect_load_le16(mail);
    assert_int_equal(ect_load_le16(mail + 2) | mail[4], 0);
    if ((mail[5] & 0x0F) == 2) {
        assert_int_equal(mail[7], 1);
        assert_int_equal(ect_load_le16(mail + 8), 0); /* number and offset of the fragment */
    }
    for (size_t i = size; i < length; i++)
        assert_int_equal(mail[i], 0);
}

static bool server_exchange(void *ctx, uint8_t *frame, size_t length)
{
    server_t *server = ctx;
    expect_frame(frame, length);
    if (frame[16] == CMD_FPWR)
        expect_mail(frame + 26, frame[22]);
    frame[26 + frame[22]] = 1;
    if (frame[16] == CMD_FPRD) {
        server->reads++;
        memcpy(frame + 26, server->mail, sizeof server->mail);
    }
    return true;
}

static void server_report(void *ctx, const char *line)
{
    server_t *server = ctx;
    (void)snprintf(server->line, sizeof server->line, "%s", line);
}

#define TALK(protocol, body)                                                                                           \
    ENI_ONE("", "<Mailbox><Send><Start>4096</Start><Length>64</Length></Send><Recv><Start>4160</Start>"                \
                "<Length>64</Length></Recv><" protocol "><InitCmd><Transition>PS</Transition>" body                    \
                "</InitCmd></" protocol "></Mailbox>")
/* A request of command 2 with the number 01020304h. */
#define ADS_REQUEST TALK("AoE", "<Data>0000000000000000 0000000000000000 0200 0400 00000000 00000000 04030201</Data>")
/* A reply: length, flags, error, invoke id, result. */
#define ADS(bytes, command, flags, error, invoke, result)                                                              \
    {bytes,                                                                                                            \
     0,                                                                                                                \
     0,                                                                                                                \
     0,                                                                                                                \
     0,                                                                                                                \
     1,                                                                                                                \
     0,                                                                                                                \
     0,                                                                                                                \
     0,                                                                                                                \
     0,                                                                                                                \
     0,                                                                                                                \
     0,                                                                                                                \
     0,                                                                                                                \
     0,                                                                                                                \
     0,                                                                                                                \
     0,                                                                                                                \
     0,                                                                                                                \
     0,                                                                                                                \
     0,                                                                                                                \
     0,                                                                                                                \
     0,                                                                                                                \
     0,                                                                                                                \
     command,                                                                                                          \
     0,                                                                                                                \
     flags,                                                                                                            \
     0,                                                                                                                \
     0,                                                                                                                \
     0,                                                                                                                \
     0,                                                                                                                \
     0,                                                                                                                \
     (error) & 0xFF,                                                                                                   \
     (error) >> 8,                                                                                                     \
     0,                                                                                                                \
     0,                                                                                                                \
     invoke,                                                                                                           \
     3,                                                                                                                \
     2,                                                                                                                \
     1,                                                                                                                \
     (result) & 0xFF,                                                                                                  \
     (result) >> 8}
#define EOE_REQUEST                 TALK("EoE", "<Type>2</Type><Data>0102</Data>")
#define EOE(type, protocol, result) {4, 0, 0, 0, 0, protocol, type, 1, (result) & 0xFF, (result) >> 8}

static void ENI_025_a_reply_of_AoE_or_EoE_is_that_to_the_request(void **state)
{
    enum { SKIPPED = 65 };
    static const struct {
        const char *title, *text;
        uint8_t mail[64];
        unsigned int reads;
        const char *line; /* its end */
    } rows[] = {
        {"AoE: no error", ADS_REQUEST, ADS(36, 2, 5, 0, 4, 0), 1, ""},
        {"AoE: an error", ADS_REQUEST, ADS(36, 2, 5, 0x0706, 4, 0), 1, "AoE: ADS error 0x0706"},
        {"AoE: a result", ADS_REQUEST, ADS(36, 2, 5, 0, 4, 0x0705), 1, "AoE: ADS error 0x0705"},
        {"AoE: an error before a result", ADS_REQUEST, ADS(36, 2, 5, 0x0706, 4, 0x0705), 1, "AoE: ADS error 0x0706"},
        {"AoE: a part of a result is none", ADS_REQUEST, ADS(35, 2, 5, 0, 4, 0x0705), 1, ""},
        {"AoE: no result", ADS_REQUEST, ADS(32, 2, 5, 0, 4, 0x0705), 1, ""},
        {"AoE: shorter than its header", ADS_REQUEST, ADS(31, 2, 5, 0, 4, 0), SKIPPED, "AoE: no reply"},
        {"AoE: a request", ADS_REQUEST, ADS(36, 2, 4, 0, 4, 0), SKIPPED, "AoE: no reply"},
        {"AoE: another command", ADS_REQUEST, ADS(36, 3, 5, 0, 4, 0), SKIPPED, "AoE: no reply"},
        {"AoE: another number", ADS_REQUEST, ADS(36, 2, 5, 0, 5, 0), SKIPPED, "AoE: no reply"},
        {"EoE: no error", EOE_REQUEST, EOE(3, 2, 0), 1, ""},
        {"EoE: an error", EOE_REQUEST, EOE(3, 2, 0x0201), 1, "EoE type 2: EoE result 0x0201"},
        {"EoE: bits beside the type", EOE_REQUEST, EOE(0x13, 2, 0), 1, ""},
        {"EoE: the request itself", EOE_REQUEST, EOE(2, 2, 0), SKIPPED, "EoE type 2: no reply"},
        {"EoE: another type", EOE_REQUEST, EOE(4, 2, 0), SKIPPED, "EoE type 2: no reply"},
        {"EoE: another protocol", EOE_REQUEST, EOE(3, 1, 0), SKIPPED, "EoE type 2: no reply"},
        {"EoE: a mailbox error", EOE_REQUEST, EOE(3, 0, 0), 1, "EoE type 2: mailbox error"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        server_t server = {.reads = 0};
        memcpy(server.mail, rows[i].mail, sizeof server.mail);
        const ect_eni_wire_t wire = {
            .ctx = &server, .exchange = server_exchange, .wait = fake_wait, .report = server_report};
        ect_eni_t *eni = eni_of(rows[i].title, rows[i].text);
        ect_eni_player_t player = {.eni = eni, .wire = &wire, .state = ECT_ENI_PREOP};
        const bool fine = ect_eni_play(&player, ECT_ENI_SAFEOP);
        if (fine != (rows[i].line[0] == '\0') || !has_end(server.line, rows[i].line) || server.reads != rows[i].reads)
            fail_msg("%s: expected %u reads and \"%s\", got %u and \"%s\"", rows[i].title, rows[i].reads, rows[i].line,
                     server.reads, server.line);
        ect_eni_close(eni);
    }
}

static void ENI_025_a_mail_contains_nothing_of_the_previous_one(void **state)
{
    static const char text[] = ENI_ONE(
        "", "<Mailbox><Send><Start>4096</Start><Length>64</Length></Send><Recv><Start>4160</Start>"
            "<Length>64</Length></Recv><AoE><InitCmd><Transition>PS</Transition>"
            "<Data>FFFFFFFFFFFFFFFF FFFFFFFFFFFFFFFF 0200 0400 00000000 00000000 04030201</Data></InitCmd></AoE>"
            "<EoE><InitCmd><Transition>PS</Transition><Type>0</Type><Data>01</Data></InitCmd></EoE></Mailbox>");
    server_t server = {.mail = ADS(36, 2, 5, 0, 4, 0)};
    const ect_eni_wire_t wire = {
        .ctx = &server, .exchange = server_exchange, .wait = fake_wait, .report = server_report};
    (void)state;
    ect_eni_t *eni = eni_of("two mails", text);
    ect_eni_player_t player = {.eni = eni, .wire = &wire, .state = ECT_ENI_PREOP};
    const bool fine = ect_eni_play(&player, ECT_ENI_SAFEOP);
    if (!fine || server.reads != 1 || server.line[0] != '\0')
        fail_msg("expected 1 read and no line, got %u and \"%s\"", server.reads, server.line);
    ect_eni_close(eni);
}

static void ENI_024_a_slave_that_is_not_there_is_named(void **state)
{
    static const char *const words[] = {"--quiet", "fzm1"};
    bus_of_twins_t b;
    (void)state;
    bus_open(&b, 2, words);
    ect_eni_t *eni = file_with(ENI_FILES "/coe.xml", NULL, NULL);
    ect_eni_player_t player = {.eni = eni, .wire = &b.wire};
    assert_false(ect_eni_play(&player, ECT_ENI_PREOP));
    assert_non_null(strstr(b.lines, "slave 2 does not reply\n"));
    ect_eni_close(eni);
    ectwin_bus_close(b.bus);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(CF_N02_the_commands_of_a_file_bring_its_bus_to_OP_with_every_counter_as_expected),
        cmocka_unit_test(a_state_is_reached_step_by_step),
        cmocka_unit_test(a_command_with_another_reply_is_named_and_the_next_state_is_not_entered),
        cmocka_unit_test(ENI_016_a_cyclic_command_with_another_counter_is_named),
        cmocka_unit_test(ENI_005_every_comparison_of_Validate_decides_with_mask_and_sign),
        cmocka_unit_test(ENI_005_commands_of_the_master_are_played_before_or_after_those_of_the_slaves),
        cmocka_unit_test(ENI_022_a_command_is_repeated_until_its_Timeout_and_a_minute_at_most),
        cmocka_unit_test(ENI_024_a_slave_with_CoE_commands_alone_is_brought_to_PREOP_by_the_player),
        cmocka_unit_test(ENI_024_a_slave_that_is_not_there_is_named),
        cmocka_unit_test(ENI_025_mails_of_AoE_and_EoE_get_the_reply_of_the_twin),
        cmocka_unit_test(ENI_025_commands_of_SoE_get_the_reply_of_the_twin),
        cmocka_unit_test(ENI_025_a_reply_of_SoE_is_bounded_whatever_the_slave_sends),
        cmocka_unit_test(ENI_025_a_long_value_of_SoE_is_sent_in_mails_that_fit_the_mailbox),
        cmocka_unit_test(ENI_024_PREOP_is_waited_for_a_second_or_until_an_error),
        cmocka_unit_test(ENI_015_a_mailbox_is_tried_for_a_second_or_the_Timeout_of_the_command),
        cmocka_unit_test(ENI_016_a_cycle_takes_the_shortest_CycleTime_or_a_millisecond),
        cmocka_unit_test(ENI_025_a_reply_of_AoE_or_EoE_is_that_to_the_request),
        cmocka_unit_test(ENI_025_a_mail_contains_nothing_of_the_previous_one),
        cmocka_unit_test(each_slave_gets_mails_with_counters_of_its_own),
        cmocka_unit_test(emergencies_before_a_reply_are_skipped),
        cmocka_unit_test(ENI_015_a_long_value_is_sent_in_mails_that_fit_the_mailbox),
        cmocka_unit_test(a_wire_without_replies_is_named),
        cmocka_unit_test(a_mailbox_that_is_too_short_for_a_command_is_named),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
