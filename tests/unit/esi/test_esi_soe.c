/* SPDX-License-Identifier: MIT */
/* SoE in ESI files: the element, its start-up commands, the dictionary of IDNs, and a dictionary in its own file. */
#define _POSIX_C_SOURCE 200809L
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include "from_text.h"

#define INIT(body)  "<InitCmd><Transition>PS</Transition><IDN>32</IDN><Data>0200</Data>" body "</InitCmd>"
#define SOE(body)   ESI_DEVICE(ESI_MAILBOX_SMS "<Mailbox><SoE>" body "</SoE></Mailbox>" ESI_EEPROM)
#define UINT16_TYPE "<DataTypes><DataType><Name>UINT</Name><BitSize>16</BitSize></DataType></DataTypes>"
#define IDN_32                                                                                                         \
    "<Object><Index>#x0020</Index><Name>Primary mode</Name><Type>UINT</Type><BitSize>16</BitSize>"                     \
    "<Flags><Attribute>#x60010001</Attribute></Flags></Object>"
#define OBJECT_2000         "<Object><Index>#x2000</Index><Name>Filter</Name><Type>UINT</Type><BitSize>16</BitSize></Object>"
#define DICTIONARY(objects) "<Dictionary>" UINT16_TYPE "<Objects>" objects "</Objects></Dictionary>"
#define DICT_FILE(objects)  "<EtherCATDict>" DICTIONARY(objects) "</EtherCATDict>"
#define PROFILE(objects)    "<Profile>" DICTIONARY(objects) "</Profile>"
#define WITH_PROFILE(protocols, profile)                                                                               \
    ESI_DEVICE(profile ESI_MAILBOX_SMS "<Mailbox>" protocols "</Mailbox>" ESI_EEPROM)
#define IN_FILE(protocols, name) WITH_PROFILE(protocols, "<Profile><DictionaryFile>" name "</DictionaryFile></Profile>")

static made_t select_text(const char *text)
{
    made_t m = {.why = ""};
    m.esi = ect_esi_parse("t.xml", text, strlen(text), m.why, sizeof m.why);
    m.model = m.esi != NULL ? ect_esi_select(m.esi, "", m.why, sizeof m.why) : NULL;
    return m;
}

/* --- the element -------------------------------------------------------------------------------------------------- */

static void element(void **state)
{
    static const struct {
        const char *text;
        unsigned int channels;
        bool follows;
    } cases[] = {
        {ESI_DEVICE(ESI_MAILBOX_SMS "<Mailbox><SoE/></Mailbox>"), 0, false},
        {ESI_DEVICE(ESI_MAILBOX_SMS "<Mailbox><SoE ChannelCount='2'/></Mailbox>"), 2, false},
        {ESI_DEVICE(ESI_MAILBOX_SMS "<Mailbox><SoE DriveFollowsBit3Support='1'/></Mailbox>"), 0, true},
        {ESI_DEVICE(ESI_MAILBOX_SMS "<Mailbox><SoE DriveFollowsBit3Support='true'/></Mailbox>"), 0, true},
        {ESI_DEVICE(ESI_MAILBOX_SMS "<Mailbox><SoE DriveFollowsBit3Support='false'/></Mailbox>"), 0, false},
    };
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        made_t m = select_text(cases[i].text);
        assert_non_null(m.model);
        assert_true(m.model->mailbox.soe);
        assert_int_equal(m.model->mailbox.soe_channels, cases[i].channels);
        assert_int_equal(m.model->mailbox.soe_follows, cases[i].follows);
        assert_int_equal(m.model->mailbox.mail_count, 0);
        free_made(&m);
    }
}

static void commands(void **state)
{
    made_t m =
        select_text(SOE("<InitCmd><Transition>IP</Transition><Transition>PS</Transition><IDN>32778</IDN>"
                        "<Data>0A00 0B</Data><Comment>Motor</Comment></InitCmd>"
                        "<InitCmd Chn='7'><Transition>SO</Transition><IDN>#x0001</IDN><Data>D007</Data></InitCmd>"));
    (void)state;
    assert_non_null(m.model);
    const ect_esi_mail_t *inits = m.model->mailbox.mails;
    assert_int_equal(m.model->mailbox.mail_count, 2);
    assert_string_equal(inits[0].transitions, "IP PS");
    assert_int_equal(inits[0].idn, 0x800A);
    assert_int_equal(inits[0].drive, 0);
    assert_int_equal(inits[0].data.length, 3);
    assert_memory_equal(inits[0].data.bytes, "\x0A\x00\x0B", 3);
    assert_string_equal(inits[0].comment, "Motor");
    assert_int_equal(inits[0].line, 2);
    assert_string_equal(inits[1].transitions, "SO");
    assert_int_equal(inits[1].idn, 1);
    assert_int_equal(inits[1].drive, 7);
    assert_string_equal(inits[1].comment, "");
    free_made(&m);
}

/* A command without a mail of its protocol is omitted; all are commands of the twin. */
static void mails(void **state)
{
#define AMS_31 "00112233445566778899AABBCCDDEEFF00112233445566778899AABBCCDDEE"
#define AMS    AMS_31 "FF"
    static const char text[] = ESI_DEVICE(
        ESI_MAILBOX_SMS
        "<Mailbox><AoE><InitCmd><Transition>IP</Transition><Data>" AMS "</Data><Comment>NetId</Comment></InitCmd>"
        "<InitCmd><Transition>IP</Transition><Data>00</Data></InitCmd>"
        "<InitCmd><Transition>IP</Transition><Data>" AMS_31 "</Data></InitCmd>"
        "<InitCmd><Transition>OP</Transition><Data>" AMS "00</Data></InitCmd></AoE><EoE>"
        "<InitCmd><Transition>PS</Transition><Transition>XX</Transition><Type>2</Type><Data>0102</Data></InitCmd>"
        "<InitCmd><Transition>PS</Transition><Data>0102</Data></InitCmd>"
        "<InitCmd><Transition>OP</Transition><Type>15</Type><Data>01</Data></InitCmd></EoE>"
        "<SoE><InitCmd><Transition>SO</Transition><IDN>32</IDN><Data>0B00</Data></InitCmd></SoE></Mailbox>" ESI_EEPROM);
    static const ect_init_mail_t expected[] = {
        {"IP", "NetId", ECT_MAILBOX_TYPE_AOE, 0, 0, 0, 0, false, 32, NULL},
        {"OP", NULL, ECT_MAILBOX_TYPE_AOE, 0, 0, 0, 0, false, 33, NULL},
        {"PS", NULL, ECT_MAILBOX_TYPE_EOE, 2, 0, 0, 0, false, 2, NULL},
        {"OP", NULL, ECT_MAILBOX_TYPE_EOE, 15, 0, 0, 0, false, 1, NULL},
        {"SO", NULL, ECT_MAILBOX_TYPE_SOE, ECT_INIT_WRITES, 0, 0x40, 32, false, 2, NULL},
    };
    (void)state;
    made_t m = make_text("mails", text);
    const ect_device_t *device = device_of(&m);
    assert_int_equal(device->init_mail_count, sizeof expected / sizeof expected[0]);
    for (size_t i = 0; i < sizeof expected / sizeof expected[0]; i++) {
        const ect_init_mail_t *mail = &device->init_mails[i];
        assert_string_equal(mail->transitions, expected[i].transitions);
        assert_int_equal(mail->comment != NULL, expected[i].comment != NULL);
        assert_int_equal(mail->protocol, expected[i].protocol);
        assert_int_equal(mail->type, expected[i].type);
        assert_int_equal(mail->elements, expected[i].elements);
        assert_int_equal(mail->idn, expected[i].idn);
        assert_int_equal(mail->size, expected[i].size);
        assert_non_null(mail->data);
    }
    assert_non_null(note_of(&m, "line 2: a start-up command has the transitions \"PS XX\""));
    free_made(&m);
}

static void mistakes(void **state)
{
    static const struct {
        const char *text, *why;
    } cases[] = {
        {SOE("<InitCmd><Transition>PS</Transition><Data>00</Data></InitCmd>"), "t.xml:2: InitCmd of SoE has no IDN"},
        {SOE("<InitCmd><IDN>65536</IDN></InitCmd>"), "t.xml:2: IDN is 65536, not 0 to 65535"},
        {SOE("<InitCmd><IDN>-1</IDN></InitCmd>"), "t.xml:2: IDN is -1, not 0 to 65535"},
        {SOE("<InitCmd><IDN>S-0-0032</IDN></InitCmd>"), "t.xml:2: IDN is \"S-0-0032\", not a number"},
        {SOE("<InitCmd Chn='8'><IDN>1</IDN></InitCmd>"), "t.xml:2: Chn is 8, not 0 to 7"},
        {SOE("<InitCmd><IDN>1</IDN><Data>0</Data></InitCmd>"),
         "t.xml:2: Data has an odd number of hexadecimal digits (1)"},
        {ESI_DEVICE(ESI_MAILBOX_SMS "<Mailbox><EoE><InitCmd><Type>16</Type></InitCmd></EoE></Mailbox>"),
         "t.xml:2: Type is 16, not 0 to 15"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        made_t m = select_text(cases[i].text);
        assert_null(m.model);
        assert_string_equal(m.why, cases[i].why);
        free_made(&m);
    }
}

/* --- the dictionary ----------------------------------------------------------------------------------------------- */

static void dictionaries(void **state)
{
    static const struct {
        const char *what, *text;
        size_t idns, objects;
    } cases[] = {
        {"SoE alone", WITH_PROFILE("<SoE/>", PROFILE(IDN_32)), 1, 0},
        {"SoE alone, without attributes", WITH_PROFILE("<SoE/>", PROFILE(OBJECT_2000)), 1, 0},
        {"CoE alone", WITH_PROFILE("<CoE/>", PROFILE(IDN_32)), 0, 1},
        {"both, with attributes", WITH_PROFILE("<CoE/><SoE/>", PROFILE(IDN_32)), 1, 0},
        {"both, without attributes", WITH_PROFILE("<CoE/><SoE/>", PROFILE(OBJECT_2000)), 0, 1},
        {"both, a profile each", WITH_PROFILE("<CoE/><SoE/>", PROFILE(OBJECT_2000) PROFILE(IDN_32)), 1, 1},
    };
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        made_t m = select_text(cases[i].text);
        if (m.model == NULL || m.model->idns.object_count != cases[i].idns ||
            m.model->dictionary.object_count != cases[i].objects)
            fail_msg("%s: expected %zu IDNs and %zu objects", cases[i].what, cases[i].idns, cases[i].objects);
        free_made(&m);
    }
}

static void attribute(void **state)
{
    made_t m = select_text(WITH_PROFILE("<SoE/>", PROFILE(IDN_32 OBJECT_2000)));
    (void)state;
    assert_non_null(m.model);
    assert_int_equal(m.model->idns.object_count, 2);
    assert_int_equal(m.model->idns.objects[0].index, 32);
    assert_true(m.model->idns.objects[0].flags.attribute.given);
    assert_int_equal(m.model->idns.objects[0].flags.attribute.value, 0x60010001);
    assert_false(m.model->idns.objects[1].flags.attribute.given);
    assert_int_equal(m.model->idns.type_count, 1);
    free_made(&m);
}

/* --- a dictionary in its own file --------------------------------------------------------------------------------- */

static char folder[64];

static void path_in(char path[200], const char *name)
{
    (void)snprintf(path, 200, "%s/%s", folder, name);
}

static void write_bytes(const char *name, const char *text, size_t length)
{
    char path[200];
    path_in(path, name);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(text, 1, length, file), length);
    assert_int_equal(fclose(file), 0);
}

static void write_text(const char *name, const char *text)
{
    write_bytes(name, text, strlen(text));
}

static made_t open_device(void)
{
    made_t m = {.why = ""};
    char path[200];
    path_in(path, "device.xml");
    m.esi = ect_esi_open(path, m.why, sizeof m.why);
    m.model = m.esi != NULL ? ect_esi_select(m.esi, "", m.why, sizeof m.why) : NULL;
    m.twin = m.model != NULL ? ect_esi_twin_of(m.esi, m.model, NULL, 0, m.why, sizeof m.why) : NULL;
    if (m.twin == NULL)
        fail_msg("expected a twin, got: %s", m.why);
    return m;
}

static int make_folder(void **state)
{
    char path[200];
    (void)state;
    (void)strcpy(folder, "/tmp/ectwin-soe-XXXXXX");
    assert_non_null(mkdtemp(folder));
    path_in(path, "below");
    return mkdir(path, 0700);
}

static int remove_folder(void **state)
{
    static const char *const names[] = {"device.xml", "d.xml", "below/d.xml", "below", ""};
    char path[200];
    (void)state;
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        path_in(path, names[i]);
        (void)remove(path);
    }
    return 0;
}

static void own_file(void **state)
{
    static const struct {
        const char *what, *device, *file;
        size_t idns, objects;
    } cases[] = {
        {"SoE", IN_FILE("<SoE/>", "d.xml"), "d.xml", 1, 0},
        {"CoE", IN_FILE("<CoE/>", "d.xml"), "d.xml", 0, 1},
        {"both", IN_FILE("<CoE/><SoE/>", "d.xml"), "d.xml", 1, 0},
        {"a folder below", IN_FILE("<SoE/>", "below/d.xml"), "below/d.xml", 1, 0},
        {"a folder below, '\\'", IN_FILE("<SoE/>", ".\\below\\d.xml"), "below/d.xml", 1, 0},
    };
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        write_text("device.xml", cases[i].device);
        write_text(cases[i].file, DICT_FILE(IDN_32));
        made_t m = open_device();
        if (m.model->idns.object_count != cases[i].idns || m.model->dictionary.object_count != cases[i].objects ||
            m.model->dictionary_unread != NULL)
            fail_msg("%s: expected %zu IDNs and %zu objects", cases[i].what, cases[i].idns, cases[i].objects);
        assert_null(note_of(&m, "the dictionary in"));
        free_made(&m);
    }
}

/* The note of a device without its dictionary ends with the reason; the folder differs in each run. */
static void expect_unread(const char *what, const char *reason)
{
    made_t m = open_device();
    const char *note = note_of(&m, "the dictionary in the file ");
    if (note == NULL || strlen(note) < strlen(reason) || strcmp(note + strlen(note) - strlen(reason), reason) != 0)
        fail_msg("%s: expected a note that ends with \"%s\", got \"%s\"", what, reason, note != NULL ? note : "none");
    assert_int_equal(m.model->idns.object_count, 0);
    free_made(&m);
}

static void unread_file(void **state)
{
    static const struct {
        const char *what, *text, *reason;
    } cases[] = {
        {"a definition", "<!DOCTYPE EtherCATDict><EtherCATDict/>",
         "/d.xml: has a document type definition, which no dictionary file has: refused"},
        {"another root", "<Parameters/>",
         "/d.xml:1: no dictionary: the root is Parameters, not EtherCATDict with Dictionary"},
        {"an object without index", DICT_FILE(IDN_32 "<Object><Name>N</Name></Object>"),
         "/d.xml:1: Object has no Index"},
        {"an index beyond 16 bits", DICT_FILE("<Object><Index>65536</Index></Object>"),
         "/d.xml:1: Index is 65536, not 0 to 65535"},
    };
    (void)state;
    write_text("device.xml", IN_FILE("<SoE/>", "d.xml"));
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        write_text("d.xml", cases[i].text);
        expect_unread(cases[i].what, cases[i].reason);
    }
    char path[200];
    path_in(path, "d.xml");
    assert_int_equal(remove(path), 0);
    expect_unread("no file", "/d.xml: No such file or directory");
    write_text("device.xml", IN_FILE("<SoE/>", "below"));
    expect_unread("a folder", "/below: not a file of at most 64 MiB");
    write_text("d.xml", DICT_FILE(IDN_32));
    write_text(
        "device.xml",
        WITH_PROFILE("<CoE/>", "<Profile>" DICTIONARY(OBJECT_2000) "<DictionaryFile>d.xml</DictionaryFile></Profile>"));
    expect_unread("a second dictionary", "/d.xml:1: the device has another dictionary already");
}

static void names_of_other_folders(void **state)
{
    static const char *const devices[] = {
        IN_FILE("<SoE/>", "../d.xml"),
        IN_FILE("<SoE/>", "below/../../d.xml"),
        IN_FILE("<SoE/>", "..\\d.xml"),
        IN_FILE("<SoE/>", "/etc/passwd"),
        IN_FILE("<SoE/>", "\\d.xml"),
        IN_FILE("<SoE/>", "C:\\d.xml"),
        IN_FILE("<SoE/>", "http://a.b/d.xml"),
        IN_FILE("<SoE/>", "below/"),
        IN_FILE("<SoE/>", ""),
        IN_FILE("<SoE/>", ".."),
    };
    (void)state;
    for (size_t i = 0; i < sizeof devices / sizeof devices[0]; i++) {
        write_text("device.xml", devices[i]);
        expect_unread(devices[i], "its name is not that of a file in the folder of the ESI file, or below it");
    }
}

/* A file in memory has no folder. */
static void no_folder(void **state)
{
    made_t m = make_text("memory", IN_FILE("<SoE/>", "d.xml"));
    (void)state;
    assert_string_equal(note_of(&m, "the dictionary in"), "the dictionary in the file d.xml is not read");
    free_made(&m);
}

static void cut_file(void **state)
{
    static const char whole[] = DICT_FILE(IDN_32 OBJECT_2000);
    (void)state;
    write_text("device.xml", IN_FILE("<SoE/>", "d.xml"));
    for (size_t length = 0; length < sizeof whole - 1; length++) {
        write_bytes("d.xml", whole, length);
        made_t m = open_device();
        const char *note = note_of(&m, "the dictionary in the file d.xml is not read: ");
        if (note == NULL || strchr(note, '\n') != NULL || m.model->idns.object_count != 0)
            fail_msg("cut at %zu: expected a note of one line and no IDNs", length);
        free_made(&m);
    }
}

int main(void)
{
    static const struct CMUnitTest tests[] = {
        {"the number of drives and bit 3 of S-0-0135", element, NULL, NULL, NULL},
        {"SOE-046: start-up commands with transitions, IDN, drive and data", commands, NULL, NULL, NULL},
        {"ENI-025: start-up commands of AoE, EoE and SoE are those of the twin", mails, NULL, NULL, NULL},
        {"SOE-046: a mistake in a start-up command is one line", mistakes, NULL, NULL, NULL},
        {"SOE-045: a dictionary is that of SoE without CoE, or with attributes", dictionaries, NULL, NULL, NULL},
        {"SOE-045: the attribute of an IDN", attribute, NULL, NULL, NULL},
        {"SOE-045: a DictionaryFile in the folder of the file, or below", own_file, make_folder, remove_folder, NULL},
        {"SOE-045: a DictionaryFile that cannot be read is a note with the reason", unread_file, make_folder,
         remove_folder, NULL},
        {"SOE-045: a DictionaryFile outside the folder is not opened", names_of_other_folders, make_folder,
         remove_folder, NULL},
        {"SOE-045: the DictionaryFile of a file in memory is not opened", no_folder, NULL, NULL, NULL},
        {"SOE-045: a DictionaryFile cut at any byte gives no IDNs", cut_file, make_folder, remove_folder, NULL},
    };
    return cmocka_run_group_tests_name("SoE in ESI files", tests, NULL, NULL);
}
