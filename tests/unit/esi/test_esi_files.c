/* SPDX-License-Identifier: MIT */
/* Files and memory: selectors, files that cannot be read, arenas, modules in slots, several devices in a written file.
 */
#define _POSIX_C_SOURCE 200809L
#include <sys/stat.h>
#include <unistd.h>

#include "esi/arena.h"
#include "esi/write.h"
#include "from_text.h"
#include "od/pdo.h"

/* --- arenas ------------------------------------------------------------------------------------------------------- */

static void memory(void **state)
{
    static const size_t sizes[] = {0, 1, 7, 16, 100, 4096, 65536, 65537, 200000, 3};
    ect_arena_t arena = {0};
    (void)state;
    for (unsigned int round = 0; round < 20; round++) {
        for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
            unsigned char *bytes = ect_arena_alloc(&arena, sizes[i]);
            assert_int_equal((uintptr_t)bytes % _Alignof(max_align_t), 0);
            for (size_t k = 0; k < sizes[i]; k++) {
                if (bytes[k] != 0)
                    fail_msg("byte %zu of %zu: expected 0, got %02X", k, sizes[i], bytes[k]);
            }
            memset(bytes, 0xAA, sizes[i]);
        }
    }
    ect_arena_free(&arena);
    ect_arena_free(&arena); /* an empty one, too */
}

/* An array keeps its elements while it grows. */
static void growth(void **state)
{
    ect_arena_t arena = {0};
    uint32_t *numbers = NULL;
    (void)state;
    for (size_t count = 0; count < 1000; count++) {
        numbers = ect_arena_grow(&arena, numbers, count, sizeof *numbers);
        assert_int_equal(numbers[count], 0);
        numbers[count] = (uint32_t)(count * 7);
    }
    for (size_t i = 0; i < 1000; i++)
        assert_int_equal(numbers[i], i * 7);
    ect_arena_free(&arena);
}

static void texts(void **state)
{
    ect_arena_t arena = {0};
    (void)state;
    assert_string_equal(ect_arena_copy(&arena, "abcdef", 3), "abc");
    assert_string_equal(ect_arena_copy(&arena, "", 0), "");
    assert_string_equal(ect_arena_print(&arena, "%s %04X", "index", 0x1A00u), "index 1A00");
    assert_int_equal(strlen(ect_arena_print(&arena, "%*s", 70000, "x")), 70000);
    ect_arena_free(&arena);
}

/* --- files -------------------------------------------------------------------------------------------------------- */

static const char *folder(void)
{
    static char path[] = "/tmp/ectwin-files-XXXXXX";
    (void)strcpy(path, "/tmp/ectwin-files-XXXXXX");
    assert_non_null(mkdtemp(path));
    return path;
}

static void write_text(const char *path, const char *text)
{
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    (void)fputs(text, file);
    (void)fclose(file);
}

/* The selector begins at the first '#' behind a file that exists; a file with '#' in its name is a file. */
static void selectors(void **state)
{
    static const struct {
        const char *operand;
        int at; /* -1: none */
    } table[] = {
        {"a.xml", -1},    {"a.xml#T", 5},   {"a.xml#", 5},     {"a.xml#@#x1234", 5}, {"b#c.xml", -1},
        {"b#c.xml#T", 7}, {"none.xml", -1}, {"none.xml#T", 8}, {"none#c.xml#T", 4},  {"b#c.xml#@1/#x2", 7},
        {"a.xml#b#c", 5}, {"d#", -1},       {"d##T", 2},       {"d##", 2},           {"d###", 2},
    };
    char old[1000];
    const char *path = folder();
    (void)state;
    assert_non_null(getcwd(old, sizeof old));
    assert_int_equal(chdir(path), 0);
    write_text("a.xml", "");
    write_text("b#c.xml", "");
    write_text("d#", "");
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        const char *hash = ect_esi_selector(table[i].operand);
        int at = hash != NULL ? (int)(hash - table[i].operand) : -1;
        if (at != table[i].at)
            fail_msg("%s: expected %d, got %d", table[i].operand, table[i].at, at);
    }
    (void)unlink("a.xml");
    (void)unlink("b#c.xml");
    (void)unlink("d#");
    assert_int_equal(chdir(old), 0);
    (void)rmdir(path);
}

static void unreadable(void **state)
{
    char fifo[100], empty[100], why[300] = "";
    const char *path = folder();
    (void)state;
    (void)snprintf(fifo, sizeof fifo, "%s/fifo", path);
    (void)snprintf(empty, sizeof empty, "%s/empty", path);
    assert_int_equal(mkfifo(fifo, 0600), 0);
    write_text(empty, "");
    assert_null(ect_esi_open(fifo, why, sizeof why)); /* and does not wait for a writer */
    assert_non_null(strstr(why, "not a file of at most 64 MiB"));
    assert_null(ect_esi_open(empty, why, sizeof why));
    assert_non_null(strstr(why, "no well-formed XML"));
    assert_null(ect_esi_twin_make(empty, "", NULL, 0, why, sizeof why));
    (void)unlink(fifo);
    (void)unlink(empty);
    (void)rmdir(path);
    ect_esi_close(NULL);
    ect_esi_twin_free(NULL);
}

/* A line that does not fit its room is cut, never written beyond. */
static void short_rooms(void **state)
{
    static const size_t rooms[] = {1, 2, 5, 9, 20};
    (void)state;
    for (size_t i = 0; i < sizeof rooms / sizeof rooms[0]; i++) {
        char why[32];
        memset(why, '#', sizeof why);
        assert_null(ect_esi_parse("file.xml", "<Other/>", 8, why, rooms[i]));
        assert_true(strlen(why) < rooms[i]);
        for (size_t k = rooms[i]; k < sizeof why; k++)
            assert_int_equal(why[k], '#');
    }
}

static void heads(void **state)
{
    static const char text[] = ESI_HEAD
        "<Device><Type ProductCode='1' RevisionNo='1'>A</Type><Name LcId='1031'>Eins</Name><Name LcId='1033'>One"
        "</Name></Device>\n<Device><Type ProductCode='1' RevisionNo='3'>A</Type></Device>\n<Device><Type "
        "ProductCode='#x2' RevisionNo='2'>B</Type><Slots><Slot/><Slot/></Slots></Device>" ESI_TAIL;
    static const struct {
        const char *selector, *type;
        uint32_t revision;
    } table[] = {{"A", "A", 3}, {"B", "B", 2}, {"@1", "A", 3}, {"@1/1", "A", 1}, {"@2", "B", 2}, {"@#x2/#x2", "B", 2}};
    char why[300] = "";
    size_t count;
    (void)state;
    ect_esi_t *esi = ect_esi_parse("h.xml", text, strlen(text), why, sizeof why);
    assert_non_null(esi);
    assert_string_equal(ect_esi_file(esi), "h.xml");
    const ect_esi_head_t *list = ect_esi_heads(esi, &count);
    assert_int_equal(count, 3);
    assert_string_equal(list[0].name, "One");
    assert_string_equal(list[1].name, "");
    assert_string_equal(list[1].extras, "");
    assert_string_equal(list[2].extras, "slots: 2");
    assert_int_equal(list[2].line, 3);
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        const ect_esi_device_t *m = ect_esi_select(esi, table[i].selector, why, sizeof why);
        if (m == NULL || strcmp(m->type, table[i].type) != 0 || m->revision != table[i].revision)
            fail_msg("%s: expected %s %u, got %s", table[i].selector, table[i].type, (unsigned int)table[i].revision,
                     m != NULL ? m->type : why);
    }
    char longest[80] = "@";
    memset(longest + 1, '1', 70);
    assert_null(ect_esi_select(esi, longest, why, sizeof why));
    assert_non_null(strstr(why, "is not TYPE, @PRODUCT or @PRODUCT/REVISION"));
    for (size_t digits = 63; digits <= 64; digits++) { /* leading zeros */
        memset(longest + 1, '0', digits);
        longest[digits] = '1';
        longest[digits + 1] = '\0';
        assert_int_equal(ect_esi_select(esi, longest, why, sizeof why) != NULL, digits == 63);
    }
    ect_esi_close(esi);
}

/* --- slots -------------------------------------------------------------------------------------------------------- */

#define MODULE(ident, class, index)                                                                                    \
    "<Module><Type ModuleIdent='" ident                                                                                \
    "' ModuleClass='" class "'>M</Type><Name>M</Name><TxPdo Sm='3'><Index "                                            \
                            "DependOnSlot='1'>" index                                                                  \
                            "</Index><Name>M</Name><Entry><Index DependOnSlot='1'>#x6000</Index><SubIndex>1"           \
                            "</SubIndex><BitLen>8</BitLen><Name>V</Name></Entry></TxPdo></Module>"
#define RACK(slots)                                                                                                    \
    ESI_HEAD                                                                                                           \
    "<Device Physics='YY'><Type ProductCode='1' "                                                                      \
    "RevisionNo='2'>R</Type><Name>R</Name>" ESI_MAILBOX_SMS ESI_PROCESS_SMS                                            \
    "<Mailbox><CoE/></Mailbox><Slots SlotPdoIncrement='1' SlotIndexIncrement='16'>" slots                              \
    "</Slots></Device></Devices><Modules><Module><Name>without a type</Name></Module>" MODULE("1", "X", "#x1A00")      \
        MODULE("2", "Y", "#x1A80") "</Modules></Descriptions></EtherCATInfo>"

static void modules(void **state)
{
    static const struct {
        const char *what, *text;
        ect_module_choice_t choices[2];
        size_t count;
        uint16_t pdos[4]; /* of 1C13h, 0 at the end */
        const char *why;  /* NULL: it is made */
    } table[] = {
        {"no preset", RACK("<Slot><Name>S</Name><ModuleIdent>1</ModuleIdent></Slot>"), {{0}}, 0, {0}, NULL},
        {"a preset",
         RACK("<Slot><Name>S</Name><ModuleIdent Default='1'>1</ModuleIdent></Slot>"),
         {{0}},
         0,
         {0x1A00},
         NULL},
        {"a preset in two of three",
         RACK("<Slot MinInstances='2' MaxInstances='3'><Name>S</Name><ModuleIdent Default='1'>1</ModuleIdent></Slot>"),
         {{0}},
         0,
         {0x1A00, 0x1A01},
         NULL},
        {"a preset, and one chosen",
         RACK("<Slot MaxInstances='3'><Name>S</Name><ModuleIdent Default='1'>1</ModuleIdent></Slot>"),
         {{2, 1}},
         1,
         {0x1A00, 0x1A02},
         NULL},
        {"a preset taken out",
         RACK("<Slot><Name>S</Name><ModuleIdent Default='1'>1</ModuleIdent></Slot>"),
         {{0, 0}},
         1,
         {0},
         NULL},
        {"by class",
         RACK("<Slot><Name>S</Name><ModuleClass><Class>Y</Class></ModuleClass></Slot>"),
         {{0, 2}},
         1,
         {0x1A80},
         NULL},
        {"of another class",
         RACK("<Slot><Name>S</Name><ModuleClass><Class>Y</Class></ModuleClass></Slot>"),
         {{0, 1}},
         1,
         {0},
         "slot 1 (S) takes no module 0x00000001"},
        {"an unknown module",
         RACK("<Slot><Name>S</Name><ModuleIdent>1</ModuleIdent></Slot>"),
         {{0, 9}},
         1,
         {0},
         "slot 1 (S) takes no module 0x00000009"},
        {"a slot beyond the last",
         RACK("<Slot><Name>S</Name><ModuleIdent>1</ModuleIdent></Slot>"),
         {{1, 1}},
         1,
         {0},
         "there is no slot 2; the device has 1"},
        {"increments of its own, from its first instance",
         RACK("<Slot><Name>S</Name><ModuleIdent Default='1'>1</ModuleIdent></Slot><Slot MaxInstances='2' "
              "SlotPdoIncrement='4'><Name>T</Name><ModuleIdent>2</ModuleIdent></Slot>"),
         {{1, 2}, {2, 2}},
         2,
         {0x1A00, 0x1A80, 0x1A84},
         NULL},
        {"increments of the device, from its first slot",
         RACK("<Slot><Name>S</Name><ModuleIdent Default='1'>1</ModuleIdent></Slot><Slot MaxInstances='2'><Name>T</Name>"
              "<ModuleIdent>2</ModuleIdent></Slot>"),
         {{1, 2}, {2, 2}},
         2,
         {0x1A00, 0x1A81, 0x1A82},
         NULL},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = {.why = ""};
        m.esi = ect_esi_parse("t.xml", table[i].text, strlen(table[i].text), m.why, sizeof m.why);
        m.model = m.esi != NULL ? ect_esi_select(m.esi, "", m.why, sizeof m.why) : NULL;
        assert_non_null(m.model);
        assert_int_equal(m.model->module_count, 2);
        m.twin = ect_esi_twin_of(m.esi, m.model, table[i].choices, table[i].count, m.why, sizeof m.why);
        if ((m.twin == NULL) != (table[i].why != NULL) || (m.twin == NULL && strstr(m.why, table[i].why) == NULL))
            fail_msg("%s: expected %s, got %s", table[i].what, table[i].why ? table[i].why : "a twin", m.why);
        ect_od_t od = m.twin != NULL ? od_of(&m) : (ect_od_t){0};
        const ect_object_t *assigned = m.twin != NULL ? ect_od_find(&od, 0x1C13) : NULL;
        for (uint32_t n = 0; assigned != NULL && n < 4; n++) {
            if (ect_od_element(assigned, n + 1) != table[i].pdos[n])
                fail_msg("%s: PDO %u: expected %04X, got %04X", table[i].what, (unsigned int)n + 1, table[i].pdos[n],
                         (unsigned int)ect_od_element(assigned, n + 1));
        }
        free_made(&m);
    }
}

/* --- several devices in a file ------------------------------------------------------------------------------------ */

static size_t occurrences(const char *text, const char *part)
{
    size_t count = 0;
    for (const char *at = strstr(text, part); at != NULL; at = strstr(at + 1, part))
        count++;
    return count;
}

static void several(void **state)
{
    ect_arena_t arena = {0};
    char why[300];
    size_t length;
    (void)state;
    made_t one = make_text("one", RACK("<Slot><Name>S</Name><ModuleIdent>1</ModuleIdent></Slot>"));
    made_t other =
        make_text("other", ESI_HEAD "<Device Physics='Y'><Type ProductCode='7' RevisionNo='2'>B</Type><Name>B"
                                    "</Name><GroupType>G</GroupType></Device>" ESI_TAIL);
    const ect_esi_part_t parts[] = {{.device = device_of(&one), .twin = one.twin},
                                    {.device = device_of(&other), .twin = other.twin},
                                    {.device = device_of(&other), .identity = &(ect_identity_t){.vendor_id = 0xE57}}};
    const char *text = ect_esi_write(&arena, parts, 3, &length, why, sizeof why);
    if (text == NULL)
        fail_msg("expected a file, got: %s", why);
    assert_int_equal(strlen(text), length);
    assert_int_equal(occurrences(text, "<Device "), 3);
    assert_int_equal(occurrences(text, "<Group>"), 2); /* "unnamed" and G */
    assert_int_equal(occurrences(text, "<Modules>"), 1);
    assert_int_equal(occurrences(text, "<Module>"), 3);
    assert_int_equal(occurrences(text, "<Slots "), 1);
    const ect_identity_t stranger = {.vendor_id = 1};
    const ect_esi_part_t strangers[] = {parts[0], {.device = device_of(&other), .identity = &stranger}};
    assert_null(ect_esi_write(&arena, strangers, 2, &length, why, sizeof why));
    assert_string_equal(why, "R and B have different vendors: a file has one");
    free_made(&one);
    free_made(&other);
    ect_arena_free(&arena);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"memory of an arena is aligned and zero, of any size", memory, NULL, NULL, NULL},
        {"an array in an arena keeps its elements while it grows", growth, NULL, NULL, NULL},
        {"texts in an arena: copied, printed, of any length", texts, NULL, NULL, NULL},
        {"a selector begins behind a file that exists", selectors, NULL, NULL, NULL},
        {"pipes and empty files are refused without delay", unreadable, NULL, NULL, NULL},
        {"an error is cut to the room of its text", short_rooms, NULL, NULL, NULL},
        {"devices of a file: names, lines, selection", heads, NULL, NULL, NULL},
        {"modules in slots: presets, choices, classes, increments", modules, NULL, NULL, NULL},
        {"several devices in a file: groups and modules once", several, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
