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
    (void)length;
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
    player.state = ECT_ENI_PREOP;
    assert_false(ect_eni_play_cycle(&player));
    assert_int_equal(player.reported, 2);
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

/* --- mails -------------------------------------------------------------------------------------------------------- */

/* Slaves that reply to every upload, and detect a mail with the counter of the previous mail. */
typedef struct postbox {
    uint8_t last[2];
    unsigned int mails, repeated;
    unsigned int emergencies; /* before each reply */
    unsigned int left;        /* of them */
    size_t longest;           /* of the mails, with their headers */
} postbox_t;

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
    } rows[] = {
        {5, 1, 21},    {FIRST, 1, BOX}, {FIRST + 1, 2, BOX}, {FIRST + SEGMENT, 2, BOX}, {FIRST + SEGMENT + 1, 3, BOX},
        {500, 10, BOX}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char data[2 * 500 + 1] = "", text[3000];
        memset(data, '7', 2 * rows[i].bytes);
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
        cmocka_unit_test(ENI_022_a_command_is_repeated_until_its_Timeout_and_a_minute_at_most),
        cmocka_unit_test(ENI_024_a_slave_with_CoE_commands_alone_is_brought_to_PREOP_by_the_player),
        cmocka_unit_test(ENI_024_a_slave_that_is_not_there_is_named),
        cmocka_unit_test(ENI_025_mails_of_AoE_and_EoE_get_the_reply_of_the_twin),
        cmocka_unit_test(ENI_025_commands_of_SoE_get_the_reply_of_the_twin),
        cmocka_unit_test(ENI_025_a_reply_of_SoE_is_bounded_whatever_the_slave_sends),
        cmocka_unit_test(each_slave_gets_mails_with_counters_of_its_own),
        cmocka_unit_test(emergencies_before_a_reply_are_skipped),
        cmocka_unit_test(ENI_015_a_long_value_is_sent_in_mails_that_fit_the_mailbox),
        cmocka_unit_test(a_wire_without_replies_is_named),
        cmocka_unit_test(a_mailbox_that_is_too_short_for_a_command_is_named),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
