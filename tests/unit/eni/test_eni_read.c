/* SPDX-License-Identifier: MIT */
/* Network files in all found forms are read, or refused with one line. */
#define _POSIX_C_SOURCE 200809L
#include "from_text.h"

#include <inttypes.h>
#include <stdlib.h>

#define CASE(test) cmocka_unit_test(test)

static void free_eni(ect_eni_t *eni)
{
    ect_eni_close(eni);
}

/* --- refusals ----------------------------------------------------------------------------------------------------- */

static const struct {
    const char *title, *text, *why;
} refused[] = {
    {"ENI-001 another root", "<A/>", "t.xml:1: no ENI file: there is no EtherCATConfig with Config"},
    {"ENI-001 no Config", "<EtherCATConfig/>", "t.xml:1: no ENI file: there is no EtherCATConfig with Config"},
    {"ENI-001 no Master", "<EtherCATConfig>\n<Config/></EtherCATConfig>",
     "t.xml:2: EtherCATConfig/Config has no Master"},
    {"no slave", ENI_HEAD ENI_TAIL, "t.xml:1: there is no slave in it"},
    {"a slave without Info", ENI_HEAD "\n\n<Slave/>" ENI_TAIL, "t.xml:3: Config/Slave has no Info"},
    {"ENI-001 no VendorId", ENI_HEAD "<Slave>\n<Info/></Slave>" ENI_TAIL, "t.xml:2: Config/Slave/Info has no VendorId"},
    {"ENI-001 no ProductCode", ENI_HEAD "<Slave><Info><VendorId>1</VendorId></Info></Slave>" ENI_TAIL,
     "t.xml:1: Config/Slave/Info has no ProductCode"},
    {"ENI-001 no RevisionNo",
     ENI_HEAD "<Slave><Info><VendorId>1</VendorId><ProductCode>1</ProductCode></Info></Slave>" ENI_TAIL,
     "t.xml:1: Config/Slave/Info has no RevisionNo"},
    {"ENI-002 not a number", ENI_ONE("<PhysAddr>1o</PhysAddr>", ""), "t.xml:2: PhysAddr is \"1o\", not a number"},
    {"ENI-002 beyond its field", ENI_ONE("<PhysAddr>65536</PhysAddr>", ""),
     "t.xml:2: PhysAddr is 65536, not 0 to 65535"},
    {"ENI-022 a line break in a text that is cited", ENI_ONE("<PhysAddr>#\nx\t1</PhysAddr>", ""),
     "t.xml:2: PhysAddr is \"# x 1\", not a number"},
    {"ENI-003 odd digits", ENI_COMMAND("<Cmd>2</Cmd><Adp>0</Adp><Ado>16</Ado><Data>123</Data>"),
     "t.xml:2: Data has an odd number of hexadecimal digits (3)"},
    {"ENI-003 no digit", ENI_COMMAND("<Cmd>2</Cmd><Ado>16</Ado><Data>1g</Data>"),
     "t.xml:2: Data has the character 'g', which is no hexadecimal digit"},
    {"ENI-004 logical with Ado", ENI_COMMAND("<Cmd>12</Cmd><Addr>0</Addr><Ado>0</Ado><DataLength>1</DataLength>"),
     "t.xml:2: Cmd 12 has a logical address: Addr, without Adp and Ado"},
    {"ENI-004 logical without Addr", ENI_COMMAND("<Cmd>10</Cmd><DataLength>1</DataLength>"),
     "t.xml:2: Cmd 10 has a logical address: Addr, without Adp and Ado"},
    {"ENI-004 physical with Addr", ENI_COMMAND("<Cmd>4</Cmd><Adp>1</Adp><Ado>0</Ado><Addr>0</Addr>"),
     "t.xml:2: Cmd 4 has no logical address: Adp and Ado, without Addr"},
    {"ENI-004 physical without Ado", ENI_COMMAND("<Cmd>4</Cmd><Adp>1</Adp>"),
     "t.xml:2: Cmd 4 has no logical address: Adp and Ado, without Addr"},
    {"ENI-004 Data and DataLength", ENI_COMMAND("<Cmd>7</Cmd><Ado>0</Ado><Data>00</Data><DataLength>1</DataLength>"),
     "t.xml:2: Data and DataLength exclude each other"},
    {"ENI-004 more than a frame", ENI_COMMAND("<Cmd>7</Cmd><Ado>0</Ado><DataLength>1487</DataLength>"),
     "t.xml:2: DataLength is 1487, not 0 to 1486"},
    {"no Cmd", ENI_COMMAND("<Ado>0</Ado>"), "t.xml:2: InitCmd has no Cmd"},
    {"an unknown Cmd", ENI_COMMAND("<Cmd>15</Cmd><Ado>0</Ado>"), "t.xml:2: Cmd is 15, not 0 to 14"},
    {"an unknown Transition", ENI_COMMAND("<Transition>PX</Transition><Cmd>7</Cmd><Ado>0</Ado>"),
     "t.xml:2: Transition has the invalid value \"PX\""},
    {"ENI-005 a mask of another length",
     ENI_COMMAND("<Cmd>7</Cmd><Ado>0</Ado><DataLength>2</DataLength><Validate><Data>0000</Data>"
                 "<DataMask>00</DataMask></Validate>"),
     "t.xml:2: DataMask has 1 bytes, Data of Validate 2"},
    {"ENI-005 longer than the command",
     ENI_COMMAND("<Cmd>7</Cmd><Ado>0</Ado><DataLength>1</DataLength><Validate><Data>0000</Data></Validate>"),
     "t.xml:2: Validate has 2 bytes, more than the command, which has 1"},
    {"an unknown comparison",
     ENI_COMMAND("<Cmd>7</Cmd><Ado>0</Ado><DataLength>1</DataLength><Validate Type='LT'><Data>00</Data></Validate>"),
     "t.xml:2: Validate has the invalid Type \"LT\""},
    {"a CoE command without Index", ENI_COE("<Ccs>1</Ccs>"), "t.xml:2: InitCmd has no Index"},
    {"ENI-010 a Port beyond D", ENI_ONE("", "<PreviousPort><Port>E</Port></PreviousPort>"),
     "t.xml:2: PreviousPort has the Port \"E\", not A to D"},
    {"a frame that is too long",
     ENI_HEAD "<Slave>" ENI_INFO(
         "") "</Slave><Cyclic>\n<Frame>"
             "<Cmd><Cmd>10</Cmd><Addr>0</Addr><DataLength>1000</DataLength></Cmd>"
             "<Cmd><Cmd>10</Cmd><Addr>0</Addr><DataLength>475</DataLength></Cmd></Frame></Cyclic>" ENI_TAIL,
     "t.xml:2: Frame has 1499 bytes with the headers of its commands; a frame takes 1498"},
    {"ENI-022 an entity", "<!DOCTYPE a [<!ENTITY b 'c'>]><EtherCATConfig>&b;</EtherCATConfig>",
     "t.xml: has a document type definition, which no ENI file has: refused"},
    {"ENI-022 an outside file", "<!DOCTYPE a SYSTEM '/etc/passwd'><EtherCATConfig/>",
     "t.xml: has a document type definition, which no ENI file has: refused"},
};

static void a_file_that_cannot_be_read_is_refused_with_its_line(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof refused / sizeof refused[0]; i++) {
        char why[400] = "";
        ect_eni_t *eni = ect_eni_parse("t.xml", refused[i].text, strlen(refused[i].text), why, sizeof why);
        if (eni != NULL || strcmp(why, refused[i].why) != 0)
            fail_msg("%s: expected \"%s\", got \"%s\"", refused[i].title, refused[i].why, why);
    }
}

static void ENI_004_a_command_has_at_most_the_data_of_a_datagram(void **state)
{
    enum { MOST = 1486 };
    (void)state;
    for (size_t bytes = MOST; bytes <= MOST + 1; bytes++) {
        static char text[3 * MOST];
        char why[400] = "", data[2 * MOST + 3];
        memset(data, '0', 2 * bytes);
        data[2 * bytes] = '\0';
        (void)snprintf(text, sizeof text, ENI_COMMAND("<Cmd>7</Cmd><Ado>0</Ado><Data>%s</Data>"), data);
        ect_eni_t *eni = ect_eni_parse("t.xml", text, strlen(text), why, sizeof why);
        assert_int_equal(eni != NULL, bytes == MOST);
        assert_string_equal(why, bytes == MOST ? "" : "t.xml:2: Data has 1487 bytes; a frame takes 1486");
        if (eni != NULL)
            assert_int_equal(slave_of(eni, 0)->commands[0].data.length, MOST);
        ect_eni_close(eni);
    }
}

static void a_network_has_at_most_65535_slaves(void **state)
{
    enum { MOST = 65535 };
    static const char slave[] = ENI_SLAVE("", "");
    const size_t room = (size_t)(MOST + 1) * sizeof slave + sizeof ENI_HEAD ENI_TAIL;
    char *text = malloc(room);
    (void)state;
    assert_non_null(text);
    for (size_t count = MOST; count <= MOST + 1; count++) {
        char why[400] = "";
        char *end = stpcpy(text, ENI_HEAD);
        for (size_t i = 0; i < count; i++)
            end = stpcpy(end, slave);
        (void)strcpy(end, ENI_TAIL);
        ect_eni_t *eni = ect_eni_parse("t.xml", text, strlen(text), why, sizeof why);
        assert_int_equal(eni != NULL, count == MOST);
        assert_string_equal(why, count == MOST ? "" : "t.xml:1: more than 65535 slaves");
        if (eni != NULL)
            assert_int_equal(ect_eni_network(eni)->slave_count, MOST);
        ect_eni_close(eni);
    }
    free(text);
}

static void ENI_022_deep_nesting_and_no_xml_are_refused(void **state)
{
    enum { DEPTH = 300 };
    char why[400] = "", text[DEPTH * 3 + 1];
    (void)state;
    for (size_t i = 0; i < DEPTH; i++)
        memcpy(text + 3 * i, "<a>", 3);
    text[DEPTH * 3] = '\0';
    assert_null(ect_eni_parse("t.xml", text, strlen(text), why, sizeof why));
    assert_non_null(strstr(why, "t.xml:1: no well-formed XML: "));
    assert_null(ect_eni_parse("t.xml", "\0\1", 2, why, sizeof why));
    assert_non_null(strstr(why, "t.xml:1: no well-formed XML: "));
    assert_null(ect_eni_open("/nowhere/t.xml", why, sizeof why));
    assert_string_equal(why, "/nowhere/t.xml: No such file or directory");
}

static bool calloc_fails;

void *__real_calloc(size_t count, size_t size);
void *__wrap_calloc(size_t count, size_t size);

void *__wrap_calloc(size_t count, size_t size)
{
    return calloc_fails ? NULL : __real_calloc(count, size);
}

static void a_file_is_refused_without_memory(void **state)
{
    static const char text[] = ENI_ONE("", "");
    char why[400] = "";
    (void)state;
    calloc_fails = true;
    ect_eni_t *eni = ect_eni_parse("t.xml", text, strlen(text), why, sizeof why);
    calloc_fails = false;
    assert_null(eni);
    assert_string_equal(why, "t.xml: no memory left");
}

static void every_prefix_of_a_file_is_refused_with_one_line(void **state)
{
    static const char text[] =
        ENI_ONE("", "<InitCmds><InitCmd><Cmd>1</Cmd><Ado>0</Ado><Data>00</Data></InitCmd></InitCmds>");
    (void)state;
    for (size_t length = 0; length + 1 < sizeof text; length++) {
        char why[400] = "";
        assert_null(ect_eni_parse("t.xml", text, length, why, sizeof why));
        assert_true(why[0] != '\0' && strchr(why, '\n') == NULL);
    }
}

/* --- values ------------------------------------------------------------------------------------------------------- */

static void ENI_001_the_root_may_hold_the_configuration_and_unknown_elements_are_skipped(void **state)
{
    (void)state;
    ect_eni_t *eni = eni_of("root", "<Tool><EtherCATConfig><Config><New/><Master/><Slave><New/>" ENI_INFO(
                                        "<New/>") "</Slave></Config></EtherCATConfig></Tool>");
    assert_int_equal(ect_eni_network(eni)->slave_count, 1);
    assert_string_equal(ect_eni_file(eni), "t.xml");
    free_eni(eni);
}

static void ENI_002_numbers_have_every_notation_and_negative_identities_are_large_ones(void **state)
{
    static const struct {
        const char *text;
        uint32_t value;
    } numbers[] = {{"10", 10}, {" #x1A ", 26}, {"0x1a", 26}, {"-1", UINT32_MAX}, {"#xFFFFFFFF", UINT32_MAX}};
    (void)state;
    for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; i++) {
        char text[400];
        (void)snprintf(text, sizeof text, ENI_HEAD "<Slave>" ENI_INFO("<SerialNo>%s</SerialNo>") "</Slave>" ENI_TAIL,
                       numbers[i].text);
        ect_eni_t *eni = eni_of(numbers[i].text, text);
        assert_int_equal(slave_of(eni, 0)->serial, numbers[i].value);
        free_eni(eni);
    }
}

/* A number element in its place, and the values that it may have. */
#define OF_INFO(element)    ENI_ONE(element, "")
#define OF_COMMAND(element) ENI_COMMAND("<Cmd>5</Cmd>" element)
#define OF_LOGICAL(element) ENI_COMMAND("<Cmd>10</Cmd>" element)
#define OF_SLAVE(element)   ENI_ONE("", element)
#define OF_CONFIG(element)  ENI_HEAD "\n" ENI_SLAVE("", "") element ENI_TAIL
#define OF_MAIL(protocol, element)                                                                                     \
    ENI_ONE("", "<Mailbox><" protocol "><InitCmd>" element "</InitCmd></" protocol "></Mailbox>")

static const struct {
    const char *name, *text; /* %s: the element */
    int64_t low, high;
} ranges[] = {
    {"PhysAddr", OF_INFO("%s"), 0, UINT16_MAX},
    {"SerialNo", OF_INFO("%s"), INT32_MIN, UINT32_MAX},
    {"Ado", OF_INFO("<Identification Value='1'>%s</Identification>"), 0, UINT16_MAX},
    {"BitStart", OF_SLAVE("<ProcessData><Send>%s</Send></ProcessData>"), 0, UINT32_MAX},
    {"BitLength", OF_SLAVE("<ProcessData><Recv>%s</Recv></ProcessData>"), 0, UINT32_MAX},
    {"MinSize", OF_SLAVE("<ProcessData><Sm0>%s</Sm0></ProcessData>"), 0, UINT16_MAX},
    {"MaxSize", OF_SLAVE("<ProcessData><Sm0>%s</Sm0></ProcessData>"), 0, UINT16_MAX},
    {"DefaultSize", OF_SLAVE("<ProcessData><Sm0>%s</Sm0></ProcessData>"), 0, UINT16_MAX},
    {"StartAddress", OF_SLAVE("<ProcessData><Sm15>%s</Sm15></ProcessData>"), 0, UINT16_MAX},
    {"ControlByte", OF_SLAVE("<ProcessData><Sm0>%s</Sm0></ProcessData>"), 0, UINT8_MAX},
    {"Pdo", OF_SLAVE("<ProcessData><Sm0>%s</Sm0></ProcessData>"), 0, UINT16_MAX},
    {"Start", OF_SLAVE("<Mailbox><Send>%s</Send></Mailbox>"), 0, UINT16_MAX},
    {"Length", OF_SLAVE("<Mailbox><Recv>%s</Recv></Mailbox>"), 0, UINT16_MAX},
    {"PhysAddr", OF_SLAVE("<PreviousPort><Port>B</Port>%s</PreviousPort>"), 0, UINT16_MAX},
    {"GroupMemberCnt", OF_SLAVE("<HotConnect>%s</HotConnect>"), 1, ECT_ENI_SLAVES},
    {"CycleTime0", OF_SLAVE("<DC>%s</DC>"), INT32_MIN, UINT32_MAX},
    {"CycleTime1", OF_SLAVE("<DC>%s</DC>"), INT32_MIN, UINT32_MAX},
    {"ShiftTime", OF_SLAVE("<DC>%s</DC>"), INT32_MIN, UINT32_MAX},
    {"Cmd", ENI_COMMAND("%s<Ado>0</Ado>"), 0, 14},
    {"Adp", OF_COMMAND("%s<Ado>0</Ado>"), INT16_MIN, UINT16_MAX},
    {"Ado", OF_COMMAND("%s"), 0, UINT16_MAX},
    {"Addr", OF_LOGICAL("%s"), INT32_MIN, UINT32_MAX},
    {"DataLength", OF_COMMAND("%s<Ado>0</Ado>"), 0, 1486},
    {"Cnt", OF_COMMAND("%s<Ado>0</Ado>"), 0, UINT16_MAX},
    {"Retries", OF_COMMAND("%s<Ado>0</Ado>"), 0, UINT32_MAX},
    {"InputOffs", OF_COMMAND("%s<Ado>0</Ado>"), 0, UINT32_MAX},
    {"OutputOffs", OF_COMMAND("%s<Ado>0</Ado>"), 0, UINT32_MAX},
    {"Timeout", OF_COMMAND("<Ado>0</Ado><Validate>%s</Validate>"), 0, UINT32_MAX},
    {"SrcBitOffs", OF_COMMAND("<Ado>0</Ado><CopyInfos><CopyInfo>%s</CopyInfo></CopyInfos>"), 0, UINT32_MAX},
    {"DstBitOffs", OF_COMMAND("<Ado>0</Ado><CopyInfos><CopyInfo>%s</CopyInfo></CopyInfos>"), 0, UINT32_MAX},
    {"BitSize", OF_COMMAND("<Ado>0</Ado><CopyInfos><CopyInfo>%s</CopyInfo></CopyInfos>"), 0, UINT32_MAX},
    {"Index", OF_MAIL("CoE", "%s"), 0, UINT16_MAX},
    {"SubIndex", OF_MAIL("CoE", "<Index>0</Index>%s"), 0, UINT8_MAX},
    {"Timeout", OF_MAIL("CoE", "<Index>0</Index>%s"), 0, UINT32_MAX},
    {"Timeout", OF_MAIL("EoE", "%s"), 0, UINT32_MAX},
    {"Type", OF_MAIL("EoE", "%s"), 0, 15},
    {"OpCode", OF_MAIL("SoE", "%s"), 0, UINT8_MAX},
    {"DriveNo", OF_MAIL("SoE", "%s"), 0, 7},
    {"Elements", OF_MAIL("SoE", "%s"), 0, UINT8_MAX},
    {"IDN", OF_MAIL("SoE", "%s"), 0, UINT16_MAX},
    {"OpCode", OF_MAIL("FoE", "%s"), 0, UINT8_MAX},
    {"Password", OF_MAIL("FoE", "%s"), 0, UINT32_MAX},
    {"CycleTime", OF_CONFIG("<Cyclic>%s</Cyclic>"), 0, UINT32_MAX},
    {"ByteSize", OF_CONFIG("<ProcessImage><Inputs>%s</Inputs></ProcessImage>"), 0, UINT32_MAX},
    {"BitSize", OF_CONFIG("<ProcessImage><Inputs><Variable>%s</Variable></Inputs></ProcessImage>"), 0, UINT32_MAX},
    {"BitOffs", OF_CONFIG("<ProcessImage><Outputs><Variable>%s</Variable></Outputs></ProcessImage>"), 0, UINT32_MAX},
    {"Count", "<EtherCATConfig><Config><Master><MailboxStates>\n%s</MailboxStates></Master>" ENI_SLAVE("", "") ENI_TAIL,
     0, UINT32_MAX},
};

static void ENI_002_each_number_has_a_range(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof ranges / sizeof ranges[0]; i++) {
        const int64_t values[] = {ranges[i].low, ranges[i].high, ranges[i].low - 1, ranges[i].high + 1};
        for (size_t k = 0; k < 4; k++) {
            char element[100], text[900], why[400] = "", expected[400] = "";
            (void)snprintf(element, sizeof element, "<%s>%" PRId64 "</%s>", ranges[i].name, values[k], ranges[i].name);
            const char *at = strstr(ranges[i].text, "%s");
            (void)snprintf(text, sizeof text, "%.*s%s%s", (int)(at - ranges[i].text), ranges[i].text, element, at + 2);
            if (k >= 2)
                (void)snprintf(expected, sizeof expected, "t.xml:2: %s is %" PRId64 ", not %" PRId64 " to %" PRId64,
                               ranges[i].name, values[k], ranges[i].low, ranges[i].high);
            ect_eni_t *eni = ect_eni_parse("t.xml", text, strlen(text), why, sizeof why);
            if ((eni != NULL) != (k < 2) || strcmp(why, expected) != 0)
                fail_msg("row %zu, %s: expected \"%s\", got \"%s\"", i, element, expected, why);
            ect_eni_close(eni);
        }
    }
}

/* Elements without content, each on a line of its own. */
static const char bare[] =
    "<EtherCATConfig><Config><Master><InitCmds>\n<InitCmd><Cmd>0</Cmd></InitCmd></InitCmds></Master>"
    "\n<Slave>" ENI_INFO("<Identification/>") "<ProcessData><Send/><Recv/>\n<Sm0/></ProcessData><Mailbox><Send/><Recv/>"
                                              "<BootStrap/><CoE>\n<InitCmd><Index>0</Index></InitCmd></"
                                              "CoE><EoE>\n<InitCmd><Type>0</Type></InitCmd></EoE>"
                                              "<SoE>\n<InitCmd><IDN>0</IDN></InitCmd></"
                                              "SoE><FoE>\n<InitCmd><FileName>a</FileName></InitCmd></FoE></Mailbox>"
                                              "<InitCmds>\n<InitCmd><Cmd>0</Cmd><CopyInfos>\n<CopyInfo/></"
                                              "CopyInfos><Validate/></InitCmd></InitCmds>"
                                              "\n<PreviousPort><Port>B</Port></PreviousPort><HotConnect/><DC/></"
                                              "Slave><Cyclic>\n<Frame>\n<Cmd><Cmd>0</Cmd></Cmd>"
                                              "</Frame></Cyclic><ProcessImage><Inputs>\n<Variable/></Inputs><Outputs/"
                                              "></ProcessImage>" ENI_TAIL;

static void ENI_002_a_number_that_is_absent_is_0_but_for_counters_groups_and_elements(void **state)
{
    (void)state;
    ect_eni_t *eni = eni_of("bare", bare);
    const ect_eni_network_t *network = ect_eni_network(eni);
    const ect_eni_slave_t *s = slave_of(eni, 0);
    const ect_eni_command_t *c = s->commands;
    const ect_eni_mailbox_t *m = &s->mailbox;
    const ect_eni_mail_t *eoe = &m->mails[0], *soe = &m->mails[1], *foe = &m->mails[2];
    const struct {
        const char *what;
        int64_t value, expected;
    } numbers[] = {
        {"members of a group", s->members, 1},
        {"Cnt", c->counter, -1},
        {"Elements", soe->elements, 0x40},
        {"OpCode of SoE", soe->type, 1},
        {"OpCode of FoE", foe->type, 1},
        {"port", s->previous.port, 1},
        {"PhysAddr", s->address, 0},
        {"AutoIncAddr", s->place.given, 0},
        {"SerialNo", s->serial, 0},
        {"Identification", s->identification.given, 0},
        {"value of Identification", s->identification.value, 0},
        {"Ado of Identification", s->identification_ado, 0},
        {"BitStart", s->sends[0].start | s->receives[0].start, 0},
        {"BitLength", s->sends[0].length | s->receives[0].length, 0},
        {"MinSize", s->sms[0].minimum, 0},
        {"MaxSize", s->sms[0].maximum, 0},
        {"DefaultSize", s->sms[0].size.given, 0},
        {"value of DefaultSize", s->sms[0].size.value, 0},
        {"StartAddress", s->sms[0].start, 0},
        {"ControlByte", s->sms[0].control, 0},
        {"start of a mailbox", m->send.start | m->receive.start | m->boot_send.start | m->boot_receive.start, 0},
        {"length of a mailbox", m->send.length | m->receive.length | m->boot_send.length | m->boot_receive.length, 0},
        {"StatusBitAddr", m->status_bit.given, 0},
        {"sub-index", m->commands[0].subindex, 0},
        {"timeout of CoE", m->commands[0].timeout_ms, 0},
        {"timeout of a mail", eoe->timeout_ms | soe->timeout_ms | foe->timeout_ms, 0},
        {"type of EoE", eoe->type, 0},
        {"DriveNo", soe->drive, 0},
        {"Password", foe->password, 0},
        {"address of the neighbour", s->previous.address, 0},
        {"CycleTime0", s->cycle0_ns, 0},
        {"CycleTime1", s->cycle1_ns, 0},
        {"ShiftTime", s->shift_ns, 0},
        {"Adp", c->adp, 0},
        {"Ado", c->ado, 0},
        {"Addr", c->address, 0},
        {"DataLength", (int64_t)c->data.length, 0},
        {"Retries", c->retries, 0},
        {"InputOffs", c->input_offset, 0},
        {"OutputOffs", c->output_offset, 0},
        {"Timeout of Validate", c->validate.timeout_ms, 0},
        {"comparison", c->validate.compare, ECT_ENI_EQ},
        {"SrcBitOffs", c->copies[0].source, 0},
        {"DstBitOffs", c->copies[0].target, 0},
        {"BitSize of a copy", c->copies[0].bits, 0},
        {"CycleTime", network->cyclics[0].cycle_us, 0},
        {"ByteSize", network->inputs.bytes | network->outputs.bytes, 0},
        {"BitSize", network->inputs.variables[0].bits, 0},
        {"BitOffs", network->inputs.variables[0].offset, 0},
        {"StartAddr", network->status_start.given, 0},
        {"Count", network->status_count, 0},
    };
    for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; i++) {
        if (numbers[i].value != numbers[i].expected)
            fail_msg("%s: expected %" PRId64 ", got %" PRId64, numbers[i].what, numbers[i].expected, numbers[i].value);
    }
    free_eni(eni);
}

static void elements_have_their_lines(void **state)
{
    (void)state;
    ect_eni_t *eni = eni_of("bare", bare);
    const ect_eni_network_t *network = ect_eni_network(eni);
    const ect_eni_slave_t *s = slave_of(eni, 0);
    const int lines[] = {network->commands[0].line,
                         s->line,
                         s->sms[0].line,
                         s->mailbox.commands[0].line,
                         s->mailbox.mails[0].line,
                         s->mailbox.mails[1].line,
                         s->mailbox.mails[2].line,
                         s->commands[0].line,
                         s->commands[0].copies[0].line,
                         s->previous.line,
                         network->cyclics[0].frames[0].line,
                         network->cyclics[0].frames[0].commands[0].line,
                         network->inputs.variables[0].line};
    for (size_t i = 0; i < sizeof lines / sizeof lines[0]; i++)
        assert_int_equal(lines[i], i + 2);
    free_eni(eni);
}

static void ENI_003_bytes_are_read_across_blanks_and_comments_in_either_case(void **state)
{
    (void)state;
    ect_eni_t *eni =
        eni_of("hex", ENI_COMMAND("<Cmd>5</Cmd><Adp>-1</Adp><Ado>#x120</Ado><Data>0a <!-- x --> B1</Data>"));
    const ect_eni_command_t *command = slave_of(eni, 0)->commands;
    assert_int_equal(command->data.length, 2);
    assert_memory_equal(command->data.bytes, "\x0A\xB1", 2);
    assert_int_equal(command->adp, 0xFFFF);
    assert_int_equal(command->ado, 0x120);
    assert_int_equal(command->counter, -1);
    free_eni(eni);
}

static void ENI_005_a_validate_has_data_mask_and_comparison(void **state)
{
    static const char text[] = ENI_COMMAND(
        "<Transition>IP</Transition><Transition>PS</Transition><BeforeSlave>true</BeforeSlave><Cmd>4</Cmd><Ado>0</Ado>"
        "<DataLength>4</DataLength><Cnt>1</Cnt><Retries>3</Retries><Validate Type='EQ_OR_G' "
        "Signed='1'><Data>0102</Data>"
        "<DataMask>FF00</DataMask><Timeout>20</Timeout></Validate>");
    (void)state;
    ect_eni_t *eni = eni_of("validate", text);
    const ect_eni_command_t *command = slave_of(eni, 0)->commands;
    const ect_eni_validate_t *validate = &command->validate;
    assert_int_equal(command->transitions, ECT_ENI_IP | ECT_ENI_PS);
    assert_true(command->before_slave);
    assert_int_equal(command->data.length, 4);
    assert_int_equal(command->counter, 1);
    assert_int_equal(command->retries, 3);
    assert_true(validate->given && validate->is_signed);
    assert_int_equal(validate->compare, ECT_ENI_EQ_OR_G);
    assert_memory_equal(validate->data.bytes, "\x01\x02", 2);
    assert_memory_equal(validate->mask.bytes, "\xFF\x00", 2);
    assert_int_equal(validate->timeout_ms, 20);
    free_eni(eni);
}

static void ENI_006_007_data_makes_a_download_whatever_Ccs_and_a_disabled_command_is_kept(void **state)
{
    static const struct {
        const char *body;
        bool download, disabled, complete;
    } commands[] = {
        {"<Ccs>1</Ccs><Index>#x1C12</Index><Data>00</Data>", true, false, false},
        {"<Ccs>2</Ccs><Index>#x1C12</Index><Data>00</Data>", true, false, false},
        {"<Ccs>2</Ccs><Index>#x1C12</Index>", false, false, false},
        {"<Ccs>2</Ccs><Index>#x1C12</Index><Data>00</Data><Disabled>1</Disabled>", true, true, false},
    };
    (void)state;
    for (size_t i = 0; i < sizeof commands / sizeof commands[0]; i++) {
        char text[600];
        (void)snprintf(text, sizeof text,
                       ENI_HEAD
                       "<Slave>" ENI_INFO("") "<Mailbox><CoE><InitCmd>%s</InitCmd></CoE></Mailbox></Slave>" ENI_TAIL,
                       commands[i].body);
        ect_eni_t *eni = eni_of(commands[i].body, text);
        const ect_eni_mailbox_t *mailbox = &slave_of(eni, 0)->mailbox;
        assert_int_equal(mailbox->command_count, 1);
        assert_int_equal(mailbox->commands[0].index, 0x1C12);
        assert_int_equal(mailbox->commands[0].download, commands[i].download);
        assert_int_equal(mailbox->commands[0].disabled, commands[i].disabled);
        free_eni(eni);
    }
}

static void ENI_025_mails_of_AoE_and_EoE_have_their_data(void **state)
{
#define AMS "00112233445566778899aabbccddeeff00112233445566778899aabbccddeeff"
    (void)state;
    ect_eni_t *eni =
        eni_of("mails", ENI_ONE("", "<Mailbox><EoE><InitCmd><Transition>IP</Transition><Type>2</Type><Data>01</Data>"
                                    "<Timeout>7</Timeout></InitCmd></EoE><AoE><InitCmds><InitCmd><Data>" AMS "</Data>"
                                    "<Comment>C</Comment><Disabled>1</Disabled></InitCmd><InitCmd><Data>" AMS
                                    "</Data></InitCmd></InitCmds></AoE></Mailbox>"));
    const ect_eni_mailbox_t *mailbox = &slave_of(eni, 0)->mailbox;
    const ect_eni_mail_t *ads = &mailbox->mails[0], *address = &mailbox->mails[2];
    assert_int_equal(mailbox->mail_count, 3);
    assert_int_equal(mailbox->others, 0);
    assert_true(ads->protocol == ECT_MAILBOX_TYPE_AOE && ads->disabled && ads->data.length == 32);
    assert_string_equal(ads->comment, "C");
    assert_true(address->protocol == ECT_MAILBOX_TYPE_EOE && address->type == 2 && !address->disabled);
    assert_true(address->transitions == ECT_ENI_IP && address->timeout_ms == 7 && address->data.length == 1);
    free_eni(eni);
}

static void ENI_025_commands_of_SoE_have_operation_drive_elements_and_IDN(void **state)
{
#define SOE(body) ENI_ONE("", "<Mailbox><SoE><InitCmds><InitCmd>" body "</InitCmd></InitCmds></SoE></Mailbox>")
    static const struct {
        const char *text;
        uint8_t type, drive, elements; /* type 0: counted only */
        uint16_t idn;
        size_t bytes;
    } rows[] = {
        {SOE("<OpCode>3</OpCode><DriveNo>7</DriveNo><IDN>33026</IDN><Elements>64</Elements><Data>0102</Data>"), 3, 7,
         64, 0x8102, 2},
        {SOE("<OpCode>1</OpCode><IDN>17</IDN><Elements>255</Elements>"), 1, 0, 255, 17, 0},
        {SOE("<IDN>17</IDN>"), 1, 0, 0x40, 17, 0},
        {SOE("<IDN>17</IDN><Data>01</Data>"), 3, 0, 0x40, 17, 1},
        {SOE("<OpCode>3</OpCode><IDN>0</IDN>"), 3, 0, 0x40, 0, 0},
        {SOE("<OpCode>3</OpCode><Data>01</Data>"), 0, 0, 0, 0, 0},
        {SOE("<OpCode>2</OpCode><IDN>17</IDN>"), 0, 0, 0, 0, 0},
        {SOE("<OpCode>4</OpCode><IDN>17</IDN>"), 0, 0, 0, 0, 0},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_eni_t *eni = eni_of(rows[i].text, rows[i].text);
        const ect_eni_mailbox_t *mailbox = &slave_of(eni, 0)->mailbox;
        assert_int_equal(mailbox->mail_count, rows[i].type != 0);
        assert_int_equal(mailbox->others, rows[i].type == 0);
        const ect_eni_mail_t *mail = mailbox->mails;
        if (rows[i].type != 0 &&
            (mail->protocol != ECT_MAILBOX_TYPE_SOE || mail->type != rows[i].type || mail->drive != rows[i].drive ||
             mail->elements != rows[i].elements || mail->idn != rows[i].idn || mail->data.length != rows[i].bytes))
            fail_msg("%s: operation %u, drive %u, elements 0x%02X, IDN 0x%04X, %zu bytes", rows[i].text, mail->type,
                     mail->drive, mail->elements, mail->idn, mail->data.length);
        free_eni(eni);
    }
}

static void ENI_025_commands_of_FoE_have_operation_file_and_password(void **state)
{
#define FOE(body) ENI_ONE("", "<Mailbox><FoE><InitCmds><InitCmd>" body "</InitCmd></InitCmds></FoE></Mailbox>")
    static const struct {
        const char *text;
        uint8_t type; /* 0: counted only */
        const char *file;
        uint32_t password;
        size_t bytes;
    } rows[] = {
        {FOE("<OpCode>2</OpCode><Password>4294967295</Password><FileName>a.bin</FileName><Data>0102</Data>"), 2,
         "a.bin", UINT32_MAX, 2},
        {FOE("<OpCode>1</OpCode><FileName>a.bin</FileName>"), 1, "a.bin", 0, 0},
        {FOE("<FileName>b</FileName>"), 1, "b", 0, 0},
        {FOE("<FileName>b</FileName><Data>01</Data>"), 2, "b", 0, 1},
        {FOE("<OpCode>3</OpCode><FileName>b</FileName>"), 0, "", 0, 0},
        {FOE("<OpCode>2</OpCode><Data>01</Data>"), 0, "", 0, 0},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_eni_t *eni = eni_of(rows[i].text, rows[i].text);
        const ect_eni_mailbox_t *mailbox = &slave_of(eni, 0)->mailbox;
        const ect_eni_mail_t *mail = mailbox->mails;
        assert_int_equal(mailbox->mail_count, rows[i].type != 0);
        assert_int_equal(mailbox->others, 1); /* not sent */
        if (rows[i].type != 0 && (mail->protocol != ECT_MAILBOX_TYPE_FOE || mail->type != rows[i].type ||
                                  mail->password != rows[i].password || strcmp(mail->file, rows[i].file) != 0 ||
                                  mail->data.length != rows[i].bytes))
            fail_msg("%s: operation %u, file %s, password %u, %zu bytes", rows[i].text, mail->type, mail->file,
                     (unsigned int)mail->password, mail->data.length);
        free_eni(eni);
    }
}

static void ENI_025_commands_of_other_protocols_are_counted(void **state)
{
    (void)state;
    ect_eni_t *eni = eni_of(
        "others", ENI_ONE("", "<Mailbox><Protocol>AoE</Protocol><SoE><InitCmds><InitCmd/><InitCmd/></InitCmds></SoE>"
                              "<FoE><InitCmds><InitCmd/></InitCmds></FoE></Mailbox>"));
    const ect_eni_mailbox_t *mailbox = &slave_of(eni, 0)->mailbox;
    assert_int_equal(mailbox->others, 3);
    assert_true(mailbox->soe && mailbox->foe && mailbox->aoe && !mailbox->coe && !mailbox->eoe && !mailbox->voe);
    free_eni(eni);
}

static void ENI_025_a_command_without_a_mail_is_counted(void **state)
{
    (void)state;
    ect_eni_t *eni = eni_of(
        "short", ENI_ONE("", "<Mailbox><EoE><InitCmd><Data>00</Data></InitCmd></EoE><AoE><InitCmd><Data>00</Data>"
                             "</InitCmd><InitCmd/></AoE></Mailbox>"));
    assert_int_equal(slave_of(eni, 0)->mailbox.mail_count, 0);
    assert_int_equal(slave_of(eni, 0)->mailbox.others, 3);
    free_eni(eni);
}

/* --- a whole file ------------------------------------------------------------------------------------------------- */

static ect_eni_t *machine(void)
{
    char why[400] = "";
    ect_eni_t *eni = ect_eni_open(ENI_FILES "/machine.xml", why, sizeof why);
    if (eni == NULL)
        fail_msg("%s", why);
    return eni;
}

static void a_file_gives_its_slaves_in_order_with_process_data_and_mailbox(void **state)
{
    (void)state;
    ect_eni_t *eni = machine();
    const ect_eni_network_t *network = ect_eni_network(eni);
    const ect_eni_slave_t *drive = slave_of(eni, 1), *tool = slave_of(eni, 2);
    assert_string_equal(network->name, "Machine");
    assert_int_equal(network->command_count, 4);
    assert_int_equal(network->slave_count, 3);
    assert_string_equal(drive->name, "Drive 2 (AX1)");
    assert_int_equal(drive->address, 1002);
    assert_int_equal(drive->place.value, 65535);
    assert_int_equal(drive->serial, 7);
    assert_int_equal(drive->sends[0].start, 8);
    assert_int_equal(drive->receives[0].length, 48);
    assert_int_equal(drive->sms[3].start, 0x1200);
    assert_int_equal(drive->sms[3].pdos[0], 0x1A00);
    assert_int_equal(drive->pdo_count, 2);
    assert_int_equal(drive->pdos[1].entries[1].index, 0x6064);
    assert_int_equal(drive->mailbox.receive.start, 0x1080);
    assert_int_equal(drive->mailbox.command_count, 6);
    assert_true(drive->mailbox.commands[3].complete);
    assert_false(drive->mailbox.commands[5].download);
    assert_true(drive->clocked);
    assert_int_equal(drive->cycle0_ns, 2000000);
    assert_null(drive->group);
    assert_string_equal(tool->group, "Tool");
    assert_int_equal(tool->identification.value, 17);
    assert_int_equal(tool->identification_ado, 0x0012);
    assert_int_equal(tool->previous.port, 2);
    free_eni(eni);
}

static void a_file_gives_its_cyclic_frames_and_its_process_image(void **state)
{
    (void)state;
    ect_eni_t *eni = machine();
    const ect_eni_network_t *network = ect_eni_network(eni);
    const ect_eni_frame_t *frame = network->cyclics[0].frames;
    assert_int_equal(network->cyclic_count, 1);
    assert_int_equal(network->cyclics[0].cycle_us, 2000);
    assert_int_equal(frame->command_count, 2);
    assert_int_equal(frame->commands[0].states, ECT_ENI_SAFEOP | ECT_ENI_OPERATIONAL);
    assert_int_equal(frame->commands[0].address, 0x10000);
    assert_int_equal(frame->commands[0].counter, 9);
    assert_int_equal(frame->commands[1].input_offset, 8);
    assert_int_equal(network->inputs.bytes, 10);
    assert_int_equal(network->outputs.variable_count, 3);
    assert_int_equal(network->outputs.variables[2].offset, 56);
    free_eni(eni);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CASE(a_file_that_cannot_be_read_is_refused_with_its_line),
        CASE(ENI_004_a_command_has_at_most_the_data_of_a_datagram),
        CASE(a_network_has_at_most_65535_slaves),
        CASE(ENI_022_deep_nesting_and_no_xml_are_refused),
        CASE(a_file_is_refused_without_memory),
        CASE(every_prefix_of_a_file_is_refused_with_one_line),
        CASE(ENI_001_the_root_may_hold_the_configuration_and_unknown_elements_are_skipped),
        CASE(ENI_002_numbers_have_every_notation_and_negative_identities_are_large_ones),
        CASE(ENI_002_each_number_has_a_range),
        CASE(ENI_002_a_number_that_is_absent_is_0_but_for_counters_groups_and_elements),
        CASE(elements_have_their_lines),
        CASE(ENI_003_bytes_are_read_across_blanks_and_comments_in_either_case),
        CASE(ENI_005_a_validate_has_data_mask_and_comparison),
        CASE(ENI_006_007_data_makes_a_download_whatever_Ccs_and_a_disabled_command_is_kept),
        CASE(ENI_025_mails_of_AoE_and_EoE_have_their_data),
        CASE(ENI_025_commands_of_SoE_have_operation_drive_elements_and_IDN),
        CASE(ENI_025_commands_of_FoE_have_operation_file_and_password),
        CASE(ENI_025_commands_of_other_protocols_are_counted),
        CASE(ENI_025_a_command_without_a_mail_is_counted),
        CASE(a_file_gives_its_slaves_in_order_with_process_data_and_mailbox),
        CASE(a_file_gives_its_cyclic_frames_and_its_process_image),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
