/* SPDX-License-Identifier: MIT */
/* Lists of module idents (src/esi/idents.c): F030h that a master configures, F050h that the twin detects. */
#include "rack.h"

/* F050h of 16 bits with two elements, and F030h likewise, as a file may have them itself. */
#define LIST(index, access)                                                                                            \
    "<Object><Index>" index "</Index><Name>Idents</Name><Type>DTI</Type><BitSize>48</BitSize><Info><SubItem>"          \
    "<Name>SubIndex 000</Name><Info><DefaultData>02</DefaultData></Info></SubItem></Info><Flags><Access>" access       \
    "</Access></Flags></Object>"
#define OWN_LISTS                                                                                                      \
    "<Dictionary><DataTypes><DataType><Name>USINT</Name><BitSize>8</BitSize></DataType><DataType><Name>UINT</Name>"    \
    "<BitSize>16</BitSize></DataType><DataType><Name>DTI</Name><BitSize>48</BitSize>"                                  \
    "<SubItem><SubIdx>0</SubIdx><Name>SubIndex 000</Name><Type>USINT</Type><BitSize>8</BitSize><BitOffs>0</BitOffs>"   \
    "<Flags><Access>rw</Access></Flags></SubItem>"                                                                     \
    "<SubItem><SubIdx>1</SubIdx><Name>One</Name><Type>UINT</Type><BitSize>16</BitSize><BitOffs>16</BitOffs>"           \
    "<Flags><Access>rw</Access></Flags></SubItem>"                                                                     \
    "<SubItem><SubIdx>2</SubIdx><Name>Two</Name><Type>UINT</Type><BitSize>16</BitSize><BitOffs>32</BitOffs>"           \
    "<Flags><Access>rw</Access></Flags></SubItem></DataType></DataTypes><Objects>" LIST("#xF030", "rw")                \
        LIST("#xF050", "ro") "</Objects></Dictionary>"

static void lists(void **state)
{
    static const struct {
        uint16_t index;
        uint8_t subindex;
        uint32_t value;
    } rows[] = {{0xF000, 0, 2}, {0xF000, 1, 0x10}, {0xF000, 2, 3},  {0xF030, 0, 3}, {0xF030, 1, 0},
                {0xF030, 3, 0}, {0xF050, 0, 3},    {0xF050, 1, IN}, {0xF050, 2, 0}, {0xF050, 3, 0}};
    rig_t r;
    (void)state;
    open_rig(&r, RACK(DOWNLOAD, ""), PREOP);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint32_t got = read_number(&r, rows[i].index, rows[i].subindex);
        if (got != rows[i].value)
            fail_msg("%04X:%u: expected %X, got %X", rows[i].index, rows[i].subindex, rows[i].value, (unsigned int)got);
    }
    assert_int_equal(read_number(&r, 0x1000, 0) & 0xFFFF, 5001);
    close_rig(&r);
}

static void no_lists(void **state)
{
    static const uint16_t indices[] = {0xF000, 0xF030, 0xF050};
    rig_t r;
    (void)state;
    open_rig(&r, RACK("", ""), PREOP);
    const ect_od_t od = ect_device_od(ect_esi_twin_product(r.made.twin)->device, NULL);
    for (size_t i = 0; i < sizeof indices / sizeof indices[0]; i++)
        assert_null(ect_od_find(&od, indices[i]));
    wire_go(&r.wire, 0, SAFEOP);
    close_rig(&r);
}

/* A master's way of writing the list. */
typedef enum way { ARRAY, SINGLE, COMPLETE } way_t;

static void write_list(rig_t *r, way_t way, const uint32_t idents[3], uint8_t count)
{
    uint8_t whole[2 + 12] = {count};
    if (way == COMPLETE) {
        for (unsigned int i = 0; i < 3; i++)
            ect_store_le32(whole + 2 + 4 * (size_t)i, idents[i]);
        assert_int_equal(wire_sdo_download(&r->wire, 0, 0xF030, 0, true, whole, 2 + 4 * (uint32_t)count), 0);
        return;
    }
    if (way == ARRAY)
        assert_int_equal(write_number(r, 0, 0, 1), 0);
    for (uint8_t i = 0; i < count; i++)
        assert_int_equal(write_number(r, (uint8_t)(i + 1), idents[i], 4), 0);
    if (way == ARRAY)
        assert_int_equal(write_number(r, 0, count, 1), 0);
}

static void configured(void **state)
{
    static const struct {
        const char *what;
        uint32_t idents[3];
        uint8_t count;
        bool refused;
    } rows[] = {
        {"the modules in the slots", {IN, 0, 0}, 3, false},
        {"the first slot alone", {IN, 0, 0}, 1, false},
        {"nothing", {0, 0, 0}, 3, false},
        {"another module in the first slot", {OUT, 0, 0}, 3, true},
        {"a module in an empty slot", {IN, 0, OUT}, 3, true},
        {"an empty slot for a module", {0, OUT, 0}, 3, true},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        for (way_t way = ARRAY; way <= COMPLETE; way++) {
            rig_t r;
            uint16_t code = 0xFFFF;
            open_rig(&r, RACK(DOWNLOAD, ""), PREOP);
            write_list(&r, way, rows[i].idents, rows[i].count);
            configure(&r);
            uint8_t al = wire_al(&r.wire, 0, SAFEOP, &code);
            uint8_t want = rows[i].refused ? PREOP | 0x10 : SAFEOP;
            if (al != want || code != (rows[i].refused ? 0x0070 : 0))
                fail_msg("%s, way %u: AL status %02X, code %04X", rows[i].what, (unsigned int)way, al, code);
            close_rig(&r);
        }
    }
}

static void corrected(void **state)
{
    rig_t r;
    uint16_t code;
    (void)state;
    open_rig(&r, RACK(DOWNLOAD, ""), PREOP);
    assert_int_equal(write_number(&r, 1, OUT, 4), 0);
    configure(&r);
    assert_int_equal(wire_al(&r.wire, 0, SAFEOP, &code), PREOP | 0x10);
    assert_int_equal(wire_al(&r.wire, 0, PREOP | 0x10, &code), PREOP);
    assert_int_equal(write_number(&r, 1, IN, 4), 0);
    configure(&r);
    assert_int_equal(wire_al(&r.wire, 0, SAFEOP, &code), SAFEOP);
    assert_int_equal(write_number(&r, 1, OUT, 4), 0x08000022);
    assert_int_equal(read_number(&r, 0xF030, 1), IN);
    close_rig(&r);
}

static void unfit(void **state)
{
    static const struct {
        uint8_t subindex;
        uint32_t ident, abort;
    } rows[] = {{1, OUT, 0}, {1, OTHER, 0x06090030}, {1, 0x999, 0x06090030}, {2, OTHER, 0x06090030}, {3, IN, 0},
                {3, 0, 0}};
    rig_t r;
    (void)state;
    open_rig(&r, RACK(DOWNLOAD, ""), PREOP);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint32_t before = read_number(&r, 0xF030, rows[i].subindex);
        uint32_t code = write_number(&r, rows[i].subindex, rows[i].ident, 4);
        uint32_t after = read_number(&r, 0xF030, rows[i].subindex);
        if (code != rows[i].abort || after != (code == 0 ? rows[i].ident : before))
            fail_msg("slot %u, ident %X: abort code %08X, then %X", rows[i].subindex, rows[i].ident, (unsigned int)code,
                     (unsigned int)after);
    }
    close_rig(&r);
}

static void of_the_file(void **state)
{
    rig_t r;
    uint16_t code;
    (void)state;
    open_rig(&r, RACK("", OWN_LISTS), PREOP);
    assert_int_equal(read_number(&r, 0xF050, 0), 2);
    assert_int_equal(read_number(&r, 0xF050, 1), IN);
    assert_int_equal(read_number(&r, 0xF030, 1), 0);
    assert_int_equal(write_number(&r, 2, OUT, 2), 0);
    configure(&r);
    assert_int_equal(wire_al(&r.wire, 0, SAFEOP, &code), PREOP | 0x10);
    assert_int_equal(code, 0x0070);
    close_rig(&r);
}

enum { PROFILE = 5u << 16 | 401 };

/* A list of elements with the default 7, their number with the default 0; without elements a value with the default 9.
 */
static void own_list(char *text, size_t room, uint16_t index, unsigned int first, unsigned int last, unsigned int bits)
{
    size_t used = (size_t)snprintf(text, room,
                                   "<Dictionary><DataTypes><DataType><Name>USINT</Name><BitSize>8</BitSize></DataType>"
                                   "<DataType><Name>E</Name><BaseType>%s</BaseType><BitSize>%u</BitSize></DataType>"
                                   "<DataType><Name>L</Name><BitSize>%u</BitSize>",
                                   bits == 8    ? "USINT"
                                   : bits == 16 ? "UINT"
                                   : bits == 32 ? "UDINT"
                                                : "ULINT",
                                   bits, 16 + last * bits);
    for (unsigned int i = first; i <= last; i++)
        used += (size_t)snprintf(text + used, room - used,
                                 "<SubItem><SubIdx>%u</SubIdx><Name>N%u</Name><Type>%s</Type><BitSize>%u</BitSize>"
                                 "<BitOffs>%u</BitOffs></SubItem>",
                                 i, i, i == 0 ? "USINT" : "E", i == 0 ? 8 : bits, i == 0 ? 0 : 16 + (i - 1) * bits);
    used +=
        (size_t)snprintf(text + used, room - used,
                         "</DataType></DataTypes><Objects><Object><Index>#x%04X</Index><Name>L</Name><Type>%s</Type>"
                         "<BitSize>%u</BitSize><Info>",
                         index, last == 0 ? "E" : "L", last == 0 ? bits : 16 + last * bits);
    for (unsigned int i = first; i <= last && last > 0; i++)
        used += (size_t)snprintf(text + used, room - used,
                                 "<SubItem><Name>N%u</Name><Info><DefaultValue>%u</DefaultValue></Info></SubItem>", i,
                                 i == 0 ? 0u : 7u);
    (void)snprintf(text + used, room - used,
                   "%s</Info><Flags><Access>rw</Access></Flags></Object></Objects></Dictionary>",
                   last == 0 ? "<DefaultValue>9</DefaultValue>" : "");
}

/* A list of the file, as long as it may be; four slots have a module each. */
static void lengths(void **state)
{
    static const struct {
        const char *what;
        uint16_t index;
        unsigned int first, last, bits; /* sub-indices of the file, and their width */
        uint32_t values[6];
    } rows[] = {
        {"F050h, shorter than the slots", 0xF050, 0, 3, 32, {3, IN, IN, IN}},
        {"F050h, one element for each slot", 0xF050, 0, 4, 32, {4, IN, IN, IN, IN}},
        {"F050h, longer than the slots", 0xF050, 0, 5, 32, {4, IN, IN, IN, IN, 7}},
        {"F050h of 16 bits", 0xF050, 0, 2, 16, {2, IN, IN}},
        {"F050h of 8 bits", 0xF050, 0, 2, 8, {0, 7, 7}},
        {"F050h of 64 bits", 0xF050, 0, 2, 64, {0, 7, 7}},
        {"F050h, a single element", 0xF050, 0, 1, 32, {1, IN}},
        {"F050h without the number of elements", 0xF050, 1, 2, 32, {2, IN, IN}},
        {"F050h, a value without elements", 0xF050, 0, 0, 32, {9}},
        {"F030h, shorter than the slots", 0xF030, 0, 3, 32, {3, 0, 0, 0}},
        {"F030h, longer than the slots", 0xF030, 0, 5, 32, {4, 0, 0, 0, 0, 7}},
        {"F040h, shorter than the slots", 0xF040, 0, 3, 16, {3, 1, 2, 3}},
        {"F040h, longer than the slots", 0xF040, 0, 5, 16, {4, 1, 2, 3, 4, 7}},
        {"F020h, longer than the slots", 0xF020, 0, 5, 16, {4, 0, 0, 0, 0, 7}},
        {"F010h, longer than the slots", 0xF010, 0, 5, 32, {4, PROFILE, PROFILE, PROFILE, PROFILE, 7}},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char list[6000], text[12000];
        const char *at = strstr(MANY_SLOTS, "</ProfileNo></Profile>");
        own_list(list, sizeof list, rows[i].index, rows[i].first, rows[i].last, rows[i].bits);
        const int head = (int)(at - MANY_SLOTS);
        (void)snprintf(text, sizeof text, "%.*s</ProfileNo>%s%s", head, MANY_SLOTS, list, at + strlen("</ProfileNo>"));
        made_t m = make_text(rows[i].what, text);
        static uint64_t memory[16384];
        assert_true(device_of(&m)->instance_size <= sizeof memory);
        memset(memory, 0, sizeof memory);
        const ect_od_t od = ect_device_od(device_of(&m), memory);
        ect_od_set_defaults(&od);
        for (uint8_t k = 0; k <= rows[i].last; k++) {
            uint64_t got = 0;
            const ect_entry_t *entry = ect_od_entry(ect_od_find(&od, rows[i].index), k);
            assert_non_null(entry);
            ect_od_read(&od, entry, 0, (uint8_t *)&got, ect_od_bytes(entry));
            if (ect_load_le32((const uint8_t *)&got) != rows[i].values[k])
                fail_msg("%s: %04X:%u: expected %X, got %X", rows[i].what, rows[i].index, k,
                         (unsigned int)rows[i].values[k], (unsigned int)got);
        }
        free_made(&m);
    }
}

/* A file without slots, as of a clone. */
#define SLOTLESS(detected)                                                                                             \
    ESI_HEAD "\n<Device Physics='YY'><Type ProductCode='#x1' RevisionNo='#x2'>D</Type><Name>A clone</Name><Profile>"   \
             "<Dictionary><DataTypes><DataType><Name>UDINT</Name><BitSize>32</BitSize></DataType>"                     \
             "<DataType><Name>USINT</Name><BitSize>8</BitSize></DataType>"                                             \
             "<DataType><Name>L</Name><BitSize>48</BitSize><SubItem><SubIdx>0</SubIdx><Name>N</Name>"                  \
             "<Type>USINT</Type><BitSize>8</BitSize><BitOffs>0</BitOffs></SubItem><SubItem><SubIdx>1</SubIdx>"         \
             "<Name>M</Name><Type>UDINT</Type><BitSize>32</BitSize><BitOffs>16</BitOffs><Flags>"                       \
             "<Access WriteRestrictions='PreOP'>rw</Access></Flags></SubItem></DataType></DataTypes><Objects>"         \
             "<Object><Index>#xF030</Index><Name>C</Name><Type>L</Type><BitSize>48</BitSize></Object>"                 \
             "<Object><Index>#xF050</Index><Name>D</Name><Type>L</Type><BitSize>48</BitSize><Info><SubItem>"           \
             "<Name>N</Name><Info><DefaultData>01</DefaultData></Info></SubItem><SubItem><Name>M</Name><Info>"         \
             "<DefaultData>" detected "</DefaultData></Info></SubItem></Info></Object></Objects></Dictionary>"         \
             "</Profile><Fmmu>Outputs</Fmmu><Fmmu>Inputs</Fmmu>" ESI_MAILBOX_SMS ESI_PROCESS_SMS                       \
             "<Mailbox><CoE SdoInfo='1' CompleteAccess='1'/></Mailbox>" ESI_EEPROM "</Device>" ESI_TAIL

static void without_slots(void **state)
{
    static const struct {
        const char *what, *text;
        uint32_t ident;
        bool refused;
    } rows[] = {
        {"the module of F050h", SLOTLESS("10010000"), IN, false},
        {"another module", SLOTLESS("10010000"), OUT, true},
        {"no module in F050h", SLOTLESS("00000000"), OUT, false},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        rig_t r;
        uint16_t code = 0xFFFF;
        open_rig(&r, rows[i].text, PREOP);
        assert_int_equal(write_number(&r, 1, rows[i].ident, 4), 0);
        configure(&r);
        const uint8_t al = wire_al(&r.wire, 0, SAFEOP, &code);
        if (al != (rows[i].refused ? PREOP | 0x10 : SAFEOP) || code != (rows[i].refused ? 0x0070 : 0))
            fail_msg("%s: AL status %02X, code %04X", rows[i].what, al, code);
        close_rig(&r);
    }
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"MDP-001 MDP-002 MDP-003 MDP-017: F000h, F030h and F050h of a file whose idents are downloaded", lists, NULL,
         NULL, NULL},
        {"MDP-017: without DownloadModuleIdentList a twin has the lists of its file only", no_lists, NULL, NULL, NULL},
        {"MDP-004 MDP-006 MDP-007 MDP-008: F030h, in each way of writing it, is compared with F050h at SAFEOP",
         configured, NULL, NULL, NULL},
        {"MDP-003 MDP-007: after 0x0070 another list is accepted, in PREOP only", corrected, NULL, NULL, NULL},
        {"MDP-005: an ident that the slot does not take is refused, and the old one stays", unfit, NULL, NULL, NULL},
        {"CLN-015 MDP-007: a file without slots compares F030h with a F050h that has modules", without_slots, NULL,
         NULL, NULL},
        {"MDP-002: the lists of the file have the idents, in its types", of_the_file, NULL, NULL, NULL},
        {"MDP-002: the lists of the file have their own length; an element without a slot keeps its default", lengths,
         NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("ESI: lists of module idents", tests, NULL, NULL);
}
