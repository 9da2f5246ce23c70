/* SPDX-License-Identifier: MIT */
/* Limits and conditions of a twin: the last value on one side, the first on the other, and what each leads to. */
#include "from_text.h"
#include "od/pdo.h"
#include "seams/standard.h"

#define COE           "<Mailbox><CoE/></Mailbox>"
#define DICT(objects) "<Profile><Dictionary><Objects>" objects "</Objects></Dictionary></Profile>"
#define OBJECT(index, type, bits, rest)                                                                                \
    "<Object><Index>" index "</Index><Name>V</Name><Type>" type "</Type><BitSize>" bits "</BitSize>" rest "</Object>"
#define ENTRY(index, sub, bits, name, type)                                                                            \
    "<Entry><Index>" index "</Index><SubIndex>" sub "</SubIndex><BitLen>" bits "</BitLen><Name>" name                  \
    "</Name><DataType>" type "</DataType></Entry>"
#define TX(attributes, index, rest) "<TxPdo " attributes "><Index>" index "</Index><Name>P</Name>" rest "</TxPdo>"
#define RX(attributes, index, rest) "<RxPdo " attributes "><Index>" index "</Index><Name>P</Name>" rest "</RxPdo>"
#define A8                          ENTRY("#x6000", "1", "8", "A", "USINT")
#define B8                          ENTRY("#x6000", "2", "8", "B", "USINT")
#define O8                          ENTRY("#x7000", "1", "8", "O", "USINT")
#define WITH(body)                  ESI_DEVICE(body ESI_MAILBOX_SMS ESI_PROCESS_SMS COE ESI_EEPROM)

/* A file that grows: a part before, numbered parts, a part behind. */
typedef struct grown {
    char *text;
    size_t length;
} grown_t;

enum { ROOM = 400000 };

static grown_t grow(void)
{
    grown_t g = {.text = malloc(ROOM)};
    assert_non_null(g.text);
    return g;
}

static void put(grown_t *g, const char *part)
{
    g->length += (size_t)snprintf(g->text + g->length, ROOM - g->length, "%s", part);
    assert_true(g->length < ROOM);
}

static void put_number(grown_t *g, const char *before, size_t number, const char *behind)
{
    char digits[30];
    (void)snprintf(digits, sizeof digits, "%zu", number);
    put(g, before);
    put(g, digits);
    put(g, behind);
}

#define OPEN "<Device Physics='YY'><Type ProductCode='#x1' RevisionNo='#x2'>DEV</Type><Name>A device</Name>"

/* --- counts of a description ------------------------------------------------------------------------------------- */

static size_t pdo_count(const ect_device_t *d)
{
    return d->pdo_count;
}

static size_t mode_count(const ect_device_t *d)
{
    return d->dc_mode_count;
}

static size_t command_count(const ect_device_t *d)
{
    return d->init_command_count;
}

static size_t mail_count(const ect_device_t *d)
{
    return d->init_mail_count;
}

static size_t category_count(const ect_device_t *d)
{
    return d->category_count;
}

static size_t fmmu_count(const ect_device_t *d)
{
    return d->fmmu_count;
}

static size_t sm_count(const ect_device_t *d)
{
    return d->sm_count;
}

static void counts(void **state)
{
    static const struct {
        const char *what, *before, *open, *close, *behind;
        size_t first, count, expected;
        size_t (*get)(const ect_device_t *d);
        const char *note;
    } table[] = {
        {"255 PDOs", ESI_MAILBOX_SMS ESI_PROCESS_SMS, "<TxPdo><Index>", "</Index></TxPdo>", COE, 0x1A00, 255, 255,
         pdo_count, NULL},
        {"256 PDOs", ESI_MAILBOX_SMS ESI_PROCESS_SMS, "<TxPdo><Index>", "</Index></TxPdo>", COE, 0x1A00, 256, 255,
         pdo_count, "it has 256 PDOs; fixed, mandatory and excluded PDOs are recorded for the first 255"},
        {"255 modes of the clocks", "<Dc>", "<OpMode><Name>M</Name><AssignActivate>", "</AssignActivate></OpMode>",
         "</Dc>", 1, 255, 255, mode_count, NULL},
        {"256 modes of the clocks", "<Dc>", "<OpMode><Name>M</Name><AssignActivate>", "</AssignActivate></OpMode>",
         "</Dc>", 1, 256, 255, mode_count, NULL},
        {"255 start-up commands", ESI_MAILBOX_SMS "<Mailbox><CoE>", "<InitCmd><Transition>PS</Transition><Index>",
         "</Index><SubIndex>0</SubIndex><Data>00</Data></InitCmd>", "</CoE></Mailbox>", 0x2000, 255, 255, command_count,
         NULL},
        {"256 start-up commands", ESI_MAILBOX_SMS "<Mailbox><CoE>", "<InitCmd><Transition>PS</Transition><Index>",
         "</Index><SubIndex>0</SubIndex><Data>00</Data></InitCmd>", "</CoE></Mailbox>", 0x2000, 256, 255, command_count,
         NULL},
        {"255 start-up mails", ESI_MAILBOX_SMS "<Mailbox><EoE>",
         "<InitCmd><Transition>PS</Transition><Type>2</Type><Data>", "</Data></InitCmd>", "</EoE></Mailbox>", 1000, 255,
         255, mail_count, NULL},
        {"256 start-up mails", ESI_MAILBOX_SMS "<Mailbox><EoE>",
         "<InitCmd><Transition>PS</Transition><Type>2</Type><Data>", "</Data></InitCmd>", "</EoE></Mailbox>", 1000, 256,
         255, mail_count, NULL},
        {"255 categories", "<Eeprom>", "<Category><CatNo>", "</CatNo><Data>0102</Data></Category>", "</Eeprom>", 2048,
         255, 255, category_count, NULL},
        {"256 categories", "<Eeprom>", "<Category><CatNo>", "</CatNo><Data>0102</Data></Category>", "</Eeprom>", 2048,
         256, 255, category_count, NULL},
        {"8 FMMUs", "", "<Fmmu No='", "'>Outputs</Fmmu>", "", 0, 8, 8, fmmu_count, NULL},
        {"9 FMMUs", "", "<Fmmu No='", "'>Outputs</Fmmu>", "", 0, 9, 8, fmmu_count, "it has 9 FMMUs; the twin has 8"},
        {"8 SyncManagers", "", "<Sm StartAddress='", "'/>", "", 0x1000, 8, 8, sm_count, NULL},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        grown_t g = grow();
        put(&g, ESI_HEAD OPEN);
        put(&g, table[i].before);
        for (size_t k = 0; k < table[i].count; k++)
            put_number(&g, table[i].open, table[i].first + k, table[i].close);
        put(&g, table[i].behind);
        put(&g, "</Device>" ESI_TAIL);
        made_t m = make_text(table[i].what, g.text);
        if (table[i].get(device_of(&m)) != table[i].expected)
            fail_msg("%s: expected %zu, got %zu", table[i].what, table[i].expected, table[i].get(device_of(&m)));
        if ((note_of(&m, "it has ") != NULL) != (table[i].note != NULL) ||
            (table[i].note != NULL && note_of(&m, table[i].note) == NULL))
            fail_msg("%s: expected the note \"%s\", got \"%s\"", table[i].what, table[i].note ? table[i].note : "none",
                     note_of(&m, "it has ") ? note_of(&m, "it has ") : "none");
        free_made(&m);
        free(g.text);
    }
}

/* --- limits of a PDO --------------------------------------------------------------------------------------------- */

#define E16(n)  n n n n n n n n n n n n n n n n
#define BIT     "<Entry><Index>0</Index><BitLen>1</BitLen></Entry>"
#define E14(n)  n n n n n n n n n n n n n n
#define BITS254 E14(E16(BIT) BIT) E16(BIT)

static void refusals(void **state)
{
    static const struct {
        const char *what, *text, *expected; /* NULL: a twin */
    } table[] = {
        {"1600h", WITH(RX("Sm='2'", "#x1600", O8)), NULL},
        {"17FFh", WITH(RX("Sm='2'", "#x17FF", O8)), NULL},
        {"15FFh", WITH(RX("Sm='2'", "#x15FF", O8)), "its index is not that of a PDO of outputs"},
        {"1800h", WITH(RX("Sm='2'", "#x1800", O8)), "its index is not that of a PDO of outputs"},
        {"1A00h", WITH(TX("Sm='3'", "#x1A00", A8)), NULL},
        {"1BFFh", WITH(TX("Sm='3'", "#x1BFF", A8)), NULL},
        {"19FFh", WITH(TX("Sm='3'", "#x19FF", A8)), "its index is not that of a PDO of inputs"},
        {"1C00h", WITH(TX("Sm='3'", "#x1C00", A8)), "its index is not that of a PDO of inputs"},
        {"an entry of 248 bits", WITH(TX("Sm='3'", "#x1A00", ENTRY("#x6000", "1", "248", "A", "STRING(31)"))), NULL},
        {"255 bits of an entry",
         WITH(TX("Sm='3'", "#x1A00", ENTRY("#x6000", "1", "255", "A", "ARRAY [0..31] OF BYTE"))), NULL},
        {"an entry of 256 bits", WITH(TX("Sm='3'", "#x1A00", ENTRY("#x6000", "1", "256", "A", "STRING(32)"))),
         "an entry can map at most 255 bits"},
        {"a gap of 256 bits", WITH(TX("Sm='3'", "#x1A00", "<Entry><Index>0</Index><BitLen>256</BitLen></Entry>")),
         NULL},
        {"254 entries", WITH(TX("Sm='3'", "#x1A00", BITS254)), NULL},
        {"255 entries", WITH(TX("Sm='3'", "#x1A00", BITS254 BIT)), "a mapping object has at most 254 entries"},
        {"registers", ESI_DEVICE("<Sm StartAddress='#x0EFF' ControlByte='#x20'>Inputs</Sm>" TX("Sm='0'", "#x1A00", A8)),
         "SyncManager 0 begins at 0x0EFF, where there are registers"},
        {"the first output register",
         ESI_DEVICE("<Sm StartAddress='#x0F00' ControlByte='#x20'>Inputs</Sm>" TX("Sm='0'", "#x1A00", A8)), NULL},
        {"registers without data", ESI_DEVICE("<Sm StartAddress='#x0EFF' ControlByte='#x20'>Inputs</Sm>"), NULL},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = try_text(table[i].text);
        if ((m.twin == NULL) != (table[i].expected != NULL) ||
            (m.twin == NULL && strstr(m.why, table[i].expected) == NULL))
            fail_msg("%s: expected %s, got %s", table[i].what, table[i].expected ? table[i].expected : "a twin",
                     m.twin != NULL ? "a twin" : m.why);
        free_made(&m);
    }
}

/* @return a text with PDO 1A00h of `bytes` bytes of gaps and one entry of `bits` more */
static char *long_pdo(size_t bytes, size_t bits)
{
    grown_t g = grow();
    put(&g, ESI_HEAD OPEN ESI_PROCESS_SMS "<TxPdo Sm='1'><Index>#x1A00</Index>");
    put_number(&g, "<Entry><Index>0</Index><BitLen>", 8 * bytes, "</BitLen></Entry>");
    put_number(&g, "<Entry><Index>0</Index><BitLen>", bits, "</BitLen></Entry>");
    put(&g, "</TxPdo></Device>" ESI_TAIL);
    return g.text;
}

static void longest_image(void **state)
{
    static const struct {
        size_t bytes, bits;
        unsigned int maximum; /* 0: no twin */
    } table[] = {{1, 8, 2}, {1, 9, 3}, {1485, 8, 1486}, {1485, 9, 0}, {1486, 1, 0}};
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        char *text = long_pdo(table[i].bytes, table[i].bits);
        made_t m = try_text(text);
        unsigned int maximum = m.twin != NULL ? device_of(&m)->sm[1].maximum : 0;
        if (maximum != table[i].maximum)
            fail_msg("%zu bytes and %zu bits: expected %u bytes, got %u (%s)", table[i].bytes, table[i].bits,
                     table[i].maximum, maximum, m.why);
        if (m.twin == NULL)
            assert_non_null(strstr(m.why, "SyncManager 1 has 1487 bytes by default; a frame takes 1486"));
        free_made(&m);
        free(text);
    }
}

/* A gap takes an element for each 255 bits; an entry behind the 254th element is omitted. */
static void long_gaps(void **state)
{
#define GAP_OF(bits) "<Entry><Index>0</Index><BitLen>" bits "</BitLen></Entry>"
    static const struct {
        const char *what, *text;
        uint32_t last;
    } table[] = {
        {"253 elements and an entry", WITH(TX("", "#x1A05", GAP_OF("64515") A8)), 0x60000108},
        {"253 elements, one of a bit, and an entry", WITH(TX("", "#x1A05", GAP_OF("64516") A8)), 1},
        {"254 elements and an entry", WITH(TX("", "#x1A05", GAP_OF("64770") A8)), 255},
        {"255 elements", WITH(TX("", "#x1A05", GAP_OF("64771"))), 255},
        {"253 elements and a gap of two elements", WITH(TX("", "#x1A05", GAP_OF("64515") GAP_OF("256"))), 255},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = make_text(table[i].what, table[i].text);
        const ect_od_t od = od_of(&m);
        const ect_object_t *pdo = ect_od_find(&od, 0x1A05);
        assert_non_null(pdo);
        if (ect_od_element(pdo, 0) != 254 || pdo->max_subindex != 254 || ect_od_element(pdo, 254) != table[i].last)
            fail_msg("%s: expected 254 elements, the last %08X, got %u, %08X", table[i].what,
                     (unsigned int)table[i].last, (unsigned int)ect_od_element(pdo, 0),
                     (unsigned int)ect_od_element(pdo, 254));
        free_made(&m);
    }
}

/* An assignment has at most 254 elements, those of the first PDOs. */
static void longest_assignment(void **state)
{
    static const struct {
        size_t pdos;
        uint8_t elements;
    } table[] = {{253, 253}, {254, 254}, {255, 254}};
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        for (unsigned int assigned = 0; assigned < 2; assigned++) {
            grown_t g = grow();
            put(&g, ESI_HEAD OPEN ESI_MAILBOX_SMS ESI_PROCESS_SMS);
            for (size_t k = 0; k < table[i].pdos; k++)
                put_number(&g, assigned != 0 ? "<TxPdo Sm='3'><Index>" : "<TxPdo><Index>", 0x1A00 + k,
                           "</Index>" BIT "</TxPdo>");
            put(&g, "<Mailbox><CoE PdoAssign='1'/></Mailbox></Device>" ESI_TAIL);
            made_t m = try_text(g.text);
            if (m.twin == NULL)
                fail_msg("%zu PDOs: %s", table[i].pdos, m.why);
            const ect_od_t od = od_of(&m);
            const ect_object_t *list = ect_od_find(&od, 0x1C13);
            const uint32_t count = assigned != 0 ? table[i].elements : 0;
            if (list->max_subindex != table[i].elements || ect_od_element(list, 0) != count)
                fail_msg("%zu PDOs: expected %u of %u elements, got %u of %u", table[i].pdos, (unsigned int)count,
                         table[i].elements, (unsigned int)ect_od_element(list, 0), list->max_subindex);
            free_made(&m);
            free(g.text);
        }
    }
}

/* --- a device without CoE ---------------------------------------------------------------------------------------- */

static void substitutes(void **state)
{
#define BARE(pdos) ESI_DEVICE(ESI_PROCESS_SMS pdos ESI_EEPROM)
    static const struct {
        const char *what, *text;
        uint16_t indices[3];
        size_t count;
        const char *note;
    } table[] = {
        {"1600h stays", BARE(RX("Sm='0'", "#x1600", O8)), {0x1600}, 1, NULL},
        {"17FFh stays", BARE(RX("Sm='0'", "#x17FF", O8)), {0x17FF}, 1, NULL},
        {"1A00h stays", BARE(TX("Sm='1'", "#x1A00", A8)), {0x1A00}, 1, NULL},
        {"1BFFh stays", BARE(TX("Sm='1'", "#x1BFF", A8)), {0x1BFF}, 1, NULL},
        {"15FFh", BARE(RX("Sm='0'", "#x15FF", O8)), {0x1600}, 1, "line 2: PDO 15FF is PDO 1600 in the SII of the twin"},
        {"1800h", BARE(RX("Sm='0'", "#x1800", O8)), {0x1600}, 1, "line 2: PDO 1800 is PDO 1600 in the SII of the twin"},
        {"19FFh", BARE(TX("Sm='1'", "#x19FF", A8)), {0x1A00}, 1, "line 2: PDO 19FF is PDO 1A00 in the SII of the twin"},
        {"1C00h", BARE(TX("Sm='1'", "#x1C00", A8)), {0x1A00}, 1, "line 2: PDO 1C00 is PDO 1A00 in the SII of the twin"},
        {"S-0-0016 and S-0-0024",
         BARE(RX("Sm='0'", "24", O8) TX("Sm='1'", "16", A8)),
         {0x1600, 0x1A00},
         2,
         "line 2: PDO 0018 is PDO 1600 in the SII of the twin (and 1 more like it)"},
        {"two of one direction",
         BARE(TX("Sm='1'", "16", A8) TX("Sm='1'", "17", B8)),
         {0x1A00, 0x1A01},
         2,
         "line 2: PDO 0010 is PDO 1A00 in the SII of the twin (and 1 more like it)"},
        {"beside 1A00h",
         BARE(TX("Sm='1'", "#x1A00", A8) TX("Sm='1'", "16", B8)),
         {0x1A00, 0x1A01},
         2,
         "line 2: PDO 0010 is PDO 1A01 in the SII of the twin"},
        {"before 1A00h",
         BARE(TX("Sm='1'", "16", A8) TX("Sm='1'", "#x1A00", B8)),
         {0x1A01, 0x1A00},
         2,
         "line 2: PDO 0010 is PDO 1A01 in the SII of the twin"},
        {"beside 1A01h and 1A00h",
         BARE(TX("Sm='1'", "#x1A01", A8) TX("Sm='1'", "#x1A00", B8) TX("", "16", A8)),
         {0x1A01, 0x1A00, 0x1A02},
         3,
         "line 2: PDO 0010 is PDO 1A02 in the SII of the twin"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = make_text(table[i].what, table[i].text);
        const ect_device_t *d = device_of(&m);
        if (d->pdo_count != table[i].count)
            fail_msg("%s: expected %zu PDOs, got %u", table[i].what, table[i].count, d->pdo_count);
        for (size_t k = 0; k < table[i].count; k++) {
            if (d->pdos[k].index != table[i].indices[k])
                fail_msg("%s: expected PDO %04X, got %04X", table[i].what, table[i].indices[k], d->pdos[k].index);
        }
        expect_note(table[i].what, &m, table[i].note);
        free_made(&m);
    }
}

/* --- assignments and timeouts ------------------------------------------------------------------------------------ */

static void without_pdo_assign(void **state)
{
#define SIZED(coe)                                                                                                     \
    ESI_DEVICE(ESI_MAILBOX_SMS                                                                                         \
               "<Sm StartAddress='#x1100' ControlByte='#x24'>Outputs</Sm>"                                             \
               "<Sm StartAddress='#x1400' ControlByte='#x20' MaxSize='9'>Inputs</Sm>" TX("Sm='3'", "#x1A00", A8)       \
                   TX("", "#x1A01", B8) "<Mailbox><CoE " coe "/></Mailbox>" ESI_EEPROM)
    static const struct {
        const char *what, *text;
        uint8_t elements, details;
        uint16_t assignment, mapping;
        unsigned int maximum;
    } table[] = {
        {"neither", SIZED(""), 1, ECT_COE_SDO, ECT_ACCESS_RO, ECT_ACCESS_RO, 2},
        {"PdoAssign 0", SIZED("PdoAssign='0'"), 1, ECT_COE_SDO, ECT_ACCESS_RO, ECT_ACCESS_RO, 2},
        {"PdoAssign", SIZED("PdoAssign='1'"), 2, ECT_COE_SDO | ECT_COE_PDO_ASSIGN, ECT_ACCESS_RW_PREOP, ECT_ACCESS_RO,
         9},
        {"PdoConfig", SIZED("PdoConfig='1'"), 1, ECT_COE_SDO | ECT_COE_PDO_CONFIG, ECT_ACCESS_RO, ECT_ACCESS_RW_PREOP,
         9},
        {"both", SIZED("PdoAssign='1' PdoConfig='1'"), 2, ECT_COE_SDO | ECT_COE_PDO_ASSIGN | ECT_COE_PDO_CONFIG,
         ECT_ACCESS_RW_PREOP, ECT_ACCESS_RW_PREOP, 9},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = make_text(table[i].what, table[i].text);
        ect_od_t od = od_of(&m);
        const ect_object_t *assignment = ect_od_find(&od, 0x1C13), *mapping = ect_od_find(&od, 0x1A00);
        const ect_device_t *d = device_of(&m);
        if (assignment->max_subindex != table[i].elements || assignment->entries[0].access != table[i].assignment ||
            mapping->entries[0].access != table[i].mapping || d->sm[3].maximum != table[i].maximum ||
            d->coe_details != table[i].details)
            fail_msg("%s: expected %u, %02X, %02X, %u, %02X, got %u, %02X, %02X, %u, %02X", table[i].what,
                     table[i].elements, table[i].assignment, table[i].mapping, table[i].maximum, table[i].details,
                     assignment->max_subindex, assignment->entries[0].access, mapping->entries[0].access,
                     d->sm[3].maximum, d->coe_details);
        free_made(&m);
    }
}

/* A mapping has as many elements as its object in the dictionary, and at least those of the PDO. */
static void elements_of_a_mapping(void **state)
{
#define NUMBER                                                                                                         \
    "<SubItem><SubIdx>0</SubIdx><Name>N</Name><Type>USINT</Type><BitSize>8</BitSize><BitOffs>0</BitOffs></SubItem>"
#define NUMBERED(n, name, offset)                                                                                      \
    "<SubItem><SubIdx>" n "</SubIdx><Name>" name "</Name><Type>UDINT</Type><BitSize>32</BitSize><BitOffs>" offset      \
    "</BitOffs></SubItem>"
#define ELEMENT(n, offset) NUMBERED(n, "M" n, offset)
#define DESCRIBED(elements)                                                                                            \
    ESI_DEVICE("<Profile><Dictionary><DataTypes><DataType><Name>M</Name><BitSize>112</BitSize>" NUMBER elements        \
               "</DataType></DataTypes><Objects>" OBJECT(                                                              \
                   "#x1A00", "M", "112", "") "</Objects></Dictionary></Profile>" ESI_MAILBOX_SMS ESI_PROCESS_SMS       \
                   TX("Sm='3'", "#x1A00", A8 B8) "<Mailbox><CoE PdoConfig='1'/></Mailbox>" ESI_EEPROM)
    static const struct {
        const char *what, *text, *names[3];
        uint8_t elements;
    } table[] = {
        {"none in the dictionary", DESCRIBED(""), {"Mapped object", "Mapped object"}, 2},
        {"one less than the PDO", DESCRIBED(ELEMENT("1", "16")), {"M1", "Mapped object"}, 2},
        {"those of the PDO", DESCRIBED(ELEMENT("1", "16") ELEMENT("2", "48")), {"M1", "M2"}, 2},
        {"names that are numbers, and one that begins like these",
         DESCRIBED(NUMBERED("1", "SubIndex 001", "16") NUMBERED("2", "SubIndexes", "48")),
         {"Mapped object", "SubIndexes"},
         2},
        {"one more than the PDO",
         DESCRIBED(ELEMENT("1", "16") ELEMENT("2", "48") ELEMENT("3", "80")),
         {"M1", "M2", "M3"},
         3},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = make_text(table[i].what, table[i].text);
        const ect_od_t od = od_of(&m);
        const ect_object_t *mapping = ect_od_find(&od, 0x1A00);
        if (mapping->max_subindex != table[i].elements || mapping->entries[0].value != 2)
            fail_msg("%s: expected %u elements, got %u", table[i].what, table[i].elements, mapping->max_subindex);
        for (uint8_t k = 0; k < table[i].elements; k++)
            assert_string_equal(ect_od_entry(mapping, (uint8_t)(k + 1))->name, table[i].names[k]);
        free_made(&m);
    }
}

static void mailbox_timeouts(void **state)
{
#define TIMES(request, response)                                                                                       \
    ESI_DEVICE("<Info><Mailbox><Timeout><RequestTimeout>" request "</RequestTimeout><ResponseTimeout>" response        \
               "</ResponseTimeout></Timeout></Mailbox></Info>" ESI_EEPROM)
    static const struct {
        const char *text;
        uint16_t request, response;
    } table[] = {
        {ESI_DEVICE(ESI_EEPROM), 0, 0},
        {TIMES("0", "0"), 0, 0},
        {TIMES("1", "0"), 1, 0},
        {TIMES("0", "1"), 0, 1},
        {TIMES("65534", "1"), 65534, 1},
        {TIMES("65535", "65536"), 65535, 65535},
        {TIMES("65536", "65535"), 65535, 65535},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = make_text("timeouts", table[i].text);
        const ect_timeouts_t *t = &device_of(&m)->timeouts;
        if (t->mailbox_request_ms != table[i].request || t->mailbox_response_ms != table[i].response)
            fail_msg("%zu: expected %u and %u ms, got %u and %u", i, table[i].request, table[i].response,
                     t->mailbox_request_ms, t->mailbox_response_ms);
        free_made(&m);
    }
}

/* --- controller and EEPROM --------------------------------------------------------------------------------------- */

static void chips_and_memory(void **state)
{
#define AT(start, size)                                                                                                \
    ESI_DEVICE("<Sm DefaultSize='128' StartAddress='#x1000' ControlByte='#x26'>MBoxOut</Sm>"                           \
               "<Sm DefaultSize='" size "' StartAddress='" start "' ControlByte='#x22'>MBoxIn</Sm>" COE ESI_EEPROM)
#define IN(start)  ESI_DEVICE("<Sm StartAddress='" start "' ControlByte='#x20'>Inputs</Sm>" TX("Sm='0'", "#x1A00", A8))
#define SIZE(size) ESI_DEVICE("<Eeprom><ByteSize>" size "</ByteSize></Eeprom>")
    static const struct {
        const char *what, *text, *esc;
        uint16_t eeprom;
    } table[] = {
        {"a mailbox that ends with 8 KB", AT("#x2F80", "128"), "et1100", 2048},
        {"a mailbox one byte beyond 8 KB", AT("#x2F80", "129"), "ipcore", 2048},
        {"three buffers that end with 8 KB", IN("#x2FFD"), "et1100", 1024},
        {"three buffers one byte beyond 8 KB", IN("#x2FFE"), "ipcore", 1024},
        {"no size", ESI_DEVICE(""), "et1100", 1024},
        {"a size of 0", SIZE("0"), "et1100", 1024},
        {"a size of 1024", SIZE("1024"), "et1100", 1024},
        {"a size of 1025", SIZE("1025"), "et1100", 1152},
        {"a size of 65408", SIZE("65408"), "et1100", 0xFF80},
        {"a size of 65409", SIZE("65409"), "et1100", 0xFF80},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = make_text(table[i].what, table[i].text);
        const ect_device_t *d = device_of(&m);
        if (strcmp(d->esc, table[i].esc) != 0 || d->sii_size != table[i].eeprom)
            fail_msg("%s: expected %s with %u bytes, got %s with %u", table[i].what, table[i].esc, table[i].eeprom,
                     d->esc, d->sii_size);
        free_made(&m);
    }
}

static void boot_mailboxes(void **state)
{
#define BOOT(bytes) ESI_DEVICE(ESI_MAILBOX_SMS COE "<Eeprom><BootStrap>" bytes "</BootStrap></Eeprom>")
    static const struct {
        const char *what, *text;
        uint16_t length;
    } table[] = {
        {"a length in the low byte", BOOT("0010800080108000"), 0x80},
        {"a length in the high byte", BOOT("0010000100120001"), 0x100},
        {"a length of 0", BOOT("0010000080100000"), 0},
        {"7 bytes", BOOT("00108000801080"), 0},
        {"9 bytes", BOOT("001080008010800000"), 0},
        {"none", ESI_DEVICE(ESI_MAILBOX_SMS COE), 0},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = make_text(table[i].what, table[i].text);
        if (device_of(&m)->boot_out.length != table[i].length || device_of(&m)->boot_in.length != table[i].length)
            fail_msg("%s: expected %u bytes, got %u and %u", table[i].what, table[i].length,
                     device_of(&m)->boot_out.length, device_of(&m)->boot_in.length);
        free_made(&m);
    }
}

/* --- outputs without a master ------------------------------------------------------------------------------------ */

static void outputs_return(void **state)
{
#define OUT(type, bits, info, mapping)                                                                                 \
    ESI_DEVICE(DICT(OBJECT("#x0900", type, bits,                                                                       \
                           "<Info>" info "</Info><Flags><Access>rw</Access><PdoMapping>" mapping                       \
                           "</PdoMapping></Flags>")) ESI_MAILBOX_SMS COE ESI_EEPROM)
    static const struct {
        const char *what, *text;
        uint8_t expected; /* of the first byte, which was 9 */
    } table[] = {
        {"the first entry of the list", OUT("USINT", "8", "<DefaultValue>5</DefaultValue>", "R"), 5},
        {"one byte of default", OUT("UINT", "16", "<DefaultData>07</DefaultData>", "R"), 7},
        {"no default", OUT("USINT", "8", "", "R"), 0},
        {"an input", OUT("USINT", "8", "<DefaultValue>5</DefaultValue>", "T"), 9},
        {"no process data", OUT("USINT", "8", "<DefaultValue>5</DefaultValue>", ""), 9},
        {"both directions", OUT("USINT", "8", "<DefaultValue>5</DefaultValue>", "RT"), 5},
        {"32 bytes", OUT("ARRAY [0..31] OF BYTE", "256", "", "R"), 0},
        {"33 bytes, which no PDO can map", OUT("ARRAY [0..32] OF BYTE", "264", "", "R"), 9},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = make_text(table[i].what, table[i].text);
        const ect_device_t *d = device_of(&m);
        ect_standard_t *instance = calloc(1, d->instance_size);
        assert_non_null(instance);
        instance->device = d;
        ect_od_t od = ect_device_od(d, instance);
        assert_int_equal(d->objects[0].index, 0x0900);
        const ect_entry_t *entry = &d->objects[0].entries[0];
        uint8_t bytes[40];
        memset(bytes, 9, sizeof bytes);
        assert_int_equal(ect_od_write(&od, entry, 0, bytes, (uint16_t)ect_od_bytes(entry)), ECT_OK);
        d->safe_outputs(instance, 0);
        ect_od_read(&od, entry, 0, bytes, (uint16_t)ect_od_bytes(entry));
        if (bytes[0] != table[i].expected)
            fail_msg("%s: expected %u, got %u", table[i].what, table[i].expected, bytes[0]);
        free(instance);
        free_made(&m);
    }
}

/* --- signals ----------------------------------------------------------------------------------------------------- */

static const ect_signal_t *find_signal(const made_t *m, const char *prefix, const char *name)
{
    const ect_plant_t *plant = ect_esi_twin_product(m->twin)->plant;
    for (unsigned int i = 0; i < plant->signal_group_count; i++) {
        for (unsigned int k = 0; k < plant->signal_groups[i].signal_count; k++) {
            const ect_signal_t *s = &plant->signal_groups[i].signals[k];
            if (strcmp(plant->signal_groups[i].prefix, prefix) == 0 && strcmp(s->name, name) == 0)
                return s;
        }
    }
    return NULL;
}

static void signal_ranges(void **state)
{
#define LIMITED(type, bits, low, high)                                                                                 \
    WITH(DICT(OBJECT("#x2000", type, bits, "<Info>" low high "</Info><Flags><Access>rw</Access></Flags>")))
#define MIN(n) "<MinValue>" n "</MinValue>"
#define MAX(n) "<MaxValue>" n "</MaxValue>"
    static const struct {
        const char *what, *text;
        int64_t minimum, maximum;
    } table[] = {
        {"no limits", LIMITED("USINT", "8", "", ""), 0, 255},
        {"a minimum of 0", LIMITED("USINT", "8", MIN("0"), ""), 0, 255},
        {"a minimum of 1", LIMITED("USINT", "8", MIN("1"), ""), 1, 255},
        {"a minimum of -1", LIMITED("USINT", "8", MIN("-1"), ""), 0, 255},
        {"a minimum at the highest value", LIMITED("USINT", "8", MIN("255"), ""), 255, 255},
        {"a minimum beyond the highest value", LIMITED("USINT", "8", MIN("256"), ""), 0, 255},
        {"a maximum of 255", LIMITED("USINT", "8", "", MAX("255")), 0, 255},
        {"a maximum of 254", LIMITED("USINT", "8", "", MAX("254")), 0, 254},
        {"a maximum of 256", LIMITED("USINT", "8", "", MAX("256")), 0, 255},
        {"a maximum of 0", LIMITED("USINT", "8", "", MAX("0")), 0, 0},
        {"a maximum of -1", LIMITED("USINT", "8", "", MAX("-1")), 0, 255},
        {"a maximum at the minimum", LIMITED("USINT", "8", MIN("10"), MAX("10")), 10, 10},
        {"a maximum below the minimum", LIMITED("USINT", "8", MIN("10"), MAX("9")), 10, 255},
        {"both", LIMITED("INT", "16", MIN("-5"), MAX("5")), -5, 5},
        {"the lowest INT", LIMITED("INT", "16", MIN("-32768"), ""), -32768, 32767},
        {"below the lowest INT", LIMITED("INT", "16", MIN("-32769"), ""), -32768, 32767},
        {"7 characters", LIMITED("STRING(7)", "56", "", ""), 0, 7},
        {"60 characters", LIMITED("STRING(60)", "480", "", ""), 0, 60},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = make_text(table[i].what, table[i].text);
        const ect_signal_t *s = find_signal(&m, "od", "2000_00");
        if (s == NULL || s->minimum != table[i].minimum || s->maximum != table[i].maximum)
            fail_msg("%s: expected %lld to %lld, got %lld to %lld", table[i].what, (long long)table[i].minimum,
                     (long long)table[i].maximum, s ? (long long)s->minimum : -1, s ? (long long)s->maximum : -1);
        free_made(&m);
    }
}

static void signal_places(void **state)
{
#define ON_REGISTERS(pdos)                                                                                             \
    ESI_DEVICE("<Sm DefaultSize='1' StartAddress='#x0910' ControlByte='#x00' Virtual='1'>Inputs</Sm>"                  \
               "<Sm StartAddress='#x1400' ControlByte='#x20' Enable='1'>Inputs</Sm>" pdos ESI_EEPROM)
    static const struct {
        const char *what, *text, *prefix, *name;
        bool there;
        ect_signal_access_t access;
    } table[] = {
        {"an assigned PDO", WITH(TX("Sm='3'", "#x1A00", A8)), "p", "a", true, ECT_SIGNAL_WRITE},
        {"outputs", WITH(RX("Sm='2'", "#x1600", O8)), "p", "o", true, ECT_SIGNAL_READ},
        {"a PDO that is not assigned", WITH(TX("", "#x1A00", A8)), "p", "a", true, ECT_SIGNAL_WRITE},
        {"the entry of one is not an object's", WITH(TX("", "#x1A00", A8)), "od", "6000_01", false, 0},
        {"an entry of two PDOs has one signal", WITH(TX("", "#x1A00", A8) TX("Sm='3'", "#x1A01", A8)), "p_2", "a",
         false, 0},
        {"another entry has one in the second group", WITH(TX("", "#x1A00", A8 B8) TX("Sm='3'", "#x1A01", A8)), "p_2",
         "b", true, ECT_SIGNAL_WRITE},
        {"an index outside those of PDOs", WITH(TX("", "#x19FF", A8)), "p", "a", false, 0},
        {"a virtual PDO of a virtual SyncManager", ON_REGISTERS(TX("Sm='0' Virtual='1'", "#x1A00", A8)), "p", "a",
         false, 0},
        {"the entry of one is not an object's", ON_REGISTERS(TX("Sm='0' Virtual='1'", "#x1A00", A8)), "od", "6000_01",
         false, 0},
        {"its second entry is not an object's", ON_REGISTERS(TX("Sm='0' Virtual='1'", "#x1A00", A8 B8)), "od",
         "6000_02", false, 0},
        {"the entry of one and of another PDO",
         ON_REGISTERS(TX("Sm='0' Virtual='1'", "#x1A00", A8) TX("Sm='1'", "#x1A01", A8)), "p", "a", true,
         ECT_SIGNAL_WRITE},
        {"0FFFh", WITH(DICT(OBJECT("#x0FFF", "USINT", "8", ""))), "od", "0fff_00", true, ECT_SIGNAL_WRITE},
        {"1000h", WITH(DICT(OBJECT("#x1000", "UDINT", "32", ""))), "od", "1000_00", false, 0},
        {"1FFFh", WITH(DICT(OBJECT("#x1FFF", "USINT", "8", ""))), "od", "1fff_00", false, 0},
        {"2000h", WITH(DICT(OBJECT("#x2000", "USINT", "8", ""))), "od", "2000_00", true, ECT_SIGNAL_WRITE},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = make_text(table[i].what, table[i].text);
        const ect_signal_t *s = find_signal(&m, table[i].prefix, table[i].name);
        if ((s != NULL) != table[i].there)
            fail_msg("%s: expected %s %s.%s", table[i].what, table[i].there ? "the signal" : "no signal",
                     table[i].prefix, table[i].name);
        if (s != NULL)
            assert_int_equal(s->access, table[i].access);
        free_made(&m);
    }
}

/* --- object codes ------------------------------------------------------------------------------------------------ */

static void codes_of_replaced_objects(void **state)
{
#define CODED(index, type, rest) DICT(OBJECT(index, type, "8", "")) rest
#define FULL(types, index, rest)                                                                                       \
    WITH("<Profile><Dictionary><DataTypes>" types                                                                      \
         "</DataTypes><Objects>" OBJECT(index, "T", "64", "") "</Objects></Dictionary></Profile>" rest)
#define RECORD_TYPE                                                                                                    \
    "<DataType><Name>T</Name><BitSize>64</BitSize><SubItem><SubIdx>0</SubIdx><Name>N</Name><Type>USINT</Type>"         \
    "<BitSize>8</BitSize></SubItem><SubItem><SubIdx>1</SubIdx><Name>First</Name><Type>UINT</Type>"                     \
    "<BitSize>16</BitSize></SubItem></DataType>"
    static const struct {
        const char *what, *text;
        uint16_t index, code;
        uint8_t elements;
        const char *name; /* of element 1, NULL: there is none */
    } table[] = {
        {"1C00h as a value", WITH(CODED("#x1C00", "USINT", "")), 0x1C00, ECT_OBJECT_ARRAY, 4, "Type"},
        {"1C00h as a record", FULL(RECORD_TYPE, "#x1C00", ""), 0x1C00, ECT_OBJECT_ARRAY, 4, "First"},
        {"1C13h as a value", WITH(CODED("#x1C13", "USINT", TX("Sm='3'", "#x1A00", A8))), 0x1C13, ECT_OBJECT_ARRAY, 1,
         "Assigned PDO"},
        {"1C13h as a record", FULL(RECORD_TYPE, "#x1C13", TX("Sm='3'", "#x1A00", A8)), 0x1C13, ECT_OBJECT_ARRAY, 1,
         "First"},
        {"1A00h as a value", WITH(CODED("#x1A00", "USINT", TX("Sm='3'", "#x1A00", A8))), 0x1A00, ECT_OBJECT_RECORD, 1,
         "Mapped object"},
        {"1018h as a value", WITH(CODED("#x1018", "USINT", "")), 0x1018, ECT_OBJECT_RECORD, 4, "Vendor ID"},
        {"a mapped value with a sub-index", WITH(CODED("#x6000", "USINT", TX("Sm='3'", "#x1A00", A8))), 0x6000,
         ECT_OBJECT_RECORD, 1, "A"},
        {"a mapped value",
         WITH(CODED("#x6000", "USINT", TX("Sm='3'", "#x1A00", ENTRY("#x6000", "0", "8", "A", "USINT")))), 0x6000,
         ECT_OBJECT_VAR, 0, NULL},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = make_text(table[i].what, table[i].text);
        ect_od_t od = od_of(&m);
        const ect_object_t *o = ect_od_find(&od, table[i].index);
        if (o == NULL || o->object_code != table[i].code || o->max_subindex != table[i].elements)
            fail_msg("%s: expected code %u with %u elements, got %u with %u", table[i].what, table[i].code,
                     table[i].elements, o ? o->object_code : 0, o ? o->max_subindex : 0);
        const ect_entry_t *first = ect_od_entry(o, 1);
        if ((first != NULL) != (table[i].name != NULL) || (first != NULL && strcmp(first->name, table[i].name) != 0))
            fail_msg("%s: expected the name %s, got %s", table[i].what, table[i].name ? table[i].name : "of none",
                     first ? first->name : "none");
        free_made(&m);
    }
}

/* --- start-up commands ------------------------------------------------------------------------------------------- */

static void transitions(void **state)
{
#define WRITES(transition, rest)                                                                                       \
    ESI_DEVICE(ESI_MAILBOX_SMS "<Mailbox><CoE><InitCmd><Transition>" transition                                        \
                               "</Transition><Index>#x2000</Index><SubIndex>0</SubIndex><Data>0001</Data>" rest        \
                               "</InitCmd></CoE></Mailbox>" ESI_EEPROM)
    static const struct {
        const char *transition, *text;
        uint16_t access;
    } table[] = {
        {"IP", WRITES("IP", ""), ECT_ACCESS_RO | ECT_ACCESS_W_PREOP},
        {"PS", WRITES("PS", ""), ECT_ACCESS_RO | ECT_ACCESS_W_PREOP},
        {"SO", WRITES("SO", ""), ECT_ACCESS_RO | ECT_ACCESS_W_SAFEOP},
        {"SP", WRITES("SP", ""), ECT_ACCESS_RO | ECT_ACCESS_W_SAFEOP},
        {"OS", WRITES("OS", ""), ECT_ACCESS_RO | ECT_ACCESS_W_OP},
        {"OP", WRITES("OP", ""), ECT_ACCESS_RO | ECT_ACCESS_W_OP},
        {"PS SO", WRITES("PS</Transition><Transition>SO", ""),
         ECT_ACCESS_RO | ECT_ACCESS_W_PREOP | ECT_ACCESS_W_SAFEOP},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = make_text(table[i].transition, table[i].text);
        ect_od_t od = od_of(&m);
        const ect_object_t *o = ect_od_find(&od, 0x2000);
        assert_non_null(o);
        if (o->entries[0].access != table[i].access || o->entries[0].bit_length != 16)
            fail_msg("%s: expected %04X of 16 bits, got %04X of %u", table[i].transition, table[i].access,
                     o->entries[0].access, o->entries[0].bit_length);
        free_made(&m);
    }
}

/* Rights of the dictionary are kept in addition to those that a command needs. */
static void rights_of_commands(void **state)
{
#define HAVING(flags, transition)                                                                                      \
    ESI_DEVICE(DICT(OBJECT("#x2000", "UINT", "16", "<Flags>" flags "</Flags>")) ESI_MAILBOX_SMS                        \
               "<Mailbox><CoE><InitCmd><Transition>" transition "</Transition><Index>#x2000</Index><Data>0001</Data>"  \
               "</InitCmd></CoE></Mailbox>" ESI_EEPROM)
    static const struct {
        const char *what, *text;
        uint16_t access;
        bool note;
    } table[] = {
        {"wo", HAVING("<Access>wo</Access>", "PS"), ECT_ACCESS_WO, false},
        {"wo in OP, at PS", HAVING("<Access WriteRestrictions='OP'>wo</Access>", "PS"),
         ECT_ACCESS_W_OP | ECT_ACCESS_W_PREOP, true},
        {"wo in OP, at SO", HAVING("<Access WriteRestrictions='OP'>wo</Access>", "SO"),
         ECT_ACCESS_W_OP | ECT_ACCESS_W_SAFEOP, true},
        {"wo in PREOP, at OS", HAVING("<Access WriteRestrictions='PreOP'>wo</Access>", "OS"),
         ECT_ACCESS_W_OP | ECT_ACCESS_W_PREOP, true},
        {"wo in PREOP, at IP", HAVING("<Access WriteRestrictions='PreOP'>wo</Access>", "IP"), ECT_ACCESS_W_PREOP,
         false},
        {"ro, at an unknown transition", HAVING("<Access>ro</Access>", "XX"), ECT_ACCESS_RW, true},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = make_text(table[i].what, table[i].text);
        ect_od_t od = od_of(&m);
        uint16_t access = ect_od_find(&od, 0x2000)->entries[0].access;
        bool note = note_of(&m, "line 2: a start-up command writes 2000:0, which is read-only") != NULL;
        if (access != table[i].access || note != table[i].note)
            fail_msg("%s: expected %03X, note %d, got %03X, %d", table[i].what, table[i].access, table[i].note, access,
                     note);
        free_made(&m);
    }
}

/* Files have other words, too: a command keeps the transitions that a CoE command can have, or is omitted. */
static void unknown_transitions(void **state)
{
    static const struct {
        const char *what, *text, *transitions, *note;
    } table[] = {
        {"PI", WRITES("PI", ""), NULL,
         "line 2: a start-up command has the transitions \"PI\", not all of them of IP PS SO SP OP OS"},
        {"small letters", WRITES("ps", ""), NULL,
         "line 2: a start-up command has the transitions \"ps\", not all of them of IP PS SO SP OP OS"},
        {"P", WRITES("P", ""), NULL,
         "line 2: a start-up command has the transitions \"P\", not all of them of IP PS SO SP OP OS"},
        {"IP PS in one", WRITES("IP PS", ""), "IP PS", NULL},
        {"two of three", WRITES("IB</Transition><Transition>PS</Transition><Transition>SO", ""), "PS SO",
         "line 2: a start-up command has the transitions \"IB PS SO\", not all of them of IP PS SO SP OP OS"},
        {"an empty one behind", WRITES("OS</Transition><Transition>", ""), "OS", NULL},
        {"two blanks between", WRITES("PS  SO", ""), "PS SO", NULL},
        {"none", WRITES("", ""), NULL, NULL},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = make_text(table[i].what, table[i].text);
        const ect_device_t *d = device_of(&m);
        const char *transitions = d->init_command_count > 0 ? d->init_commands[0].transitions : "no command";
        const char *note = note_of(&m, "line 2: a start-up command has");
        if (strcmp(transitions, table[i].transitions != NULL ? table[i].transitions : "no command") != 0)
            fail_msg("%s: expected %s, got %s", table[i].what,
                     table[i].transitions != NULL ? table[i].transitions : "no command", transitions);
        if ((note == NULL) != (table[i].note == NULL) || (note != NULL && strcmp(note, table[i].note) != 0))
            fail_msg("%s: expected the note \"%s\", got \"%s\"", table[i].what, table[i].note ? table[i].note : "none",
                     note ? note : "none");
        free_made(&m);
    }
}

/* A command cannot add elements to a value; the dictionary stays as the file has it. */
static void commands_against_the_dictionary(void **state)
{
#define COMMAND(index, subindex, data)                                                                                 \
    "<Mailbox><CoE><InitCmd><Transition>PS</Transition><Index>" index "</Index><SubIndex>" subindex                    \
    "</SubIndex><Data>" data "</Data></InitCmd></CoE></Mailbox>"
#define COMMANDED(dictionary, command) ESI_DEVICE(dictionary ESI_MAILBOX_SMS command ESI_EEPROM)
#define PAIR                                                                                                           \
    "<Profile><Dictionary><DataTypes><DataType><Name>T</Name><BitSize>24</BitSize><SubItem><SubIdx>2</SubIdx>"         \
    "<Name>Two</Name><Type>UINT</Type><BitSize>16</BitSize></SubItem></DataType></DataTypes><Objects>" OBJECT(         \
        "#x2000", "T", "24", "") "</Objects></Dictionary></Profile>"
    static const struct {
        const char *what, *text;
        uint8_t count;    /* default of sub-index 0; a value itself */
        uint16_t entries; /* of the object */
        const char *note;
    } table[] = {
        {"an element of a value", COMMANDED(DICT(OBJECT("#x2000", "USINT", "8", "")), COMMAND("#x2000", "1", "05")), 0,
         1, "line 2: a start-up command writes 2000:1, and 2000 is a single value: the entry is not added"},
        {"a value", COMMANDED("", COMMAND("#x2000", "0", "05")), 0, 1,
         "line 2: a start-up command writes 2000:0, which the dictionary lacks: it is added"},
        {"an element of nothing", COMMANDED("", COMMAND("#x2000", "3", "05")), 3, 2,
         "line 2: a start-up command writes 2000:3, which the dictionary lacks: it is added"},
        {"one element more", COMMANDED(PAIR, COMMAND("#x2000", "4", "05")), 4, 3,
         "line 2: a start-up command writes 2000:4, which the dictionary lacks: it is added"},
        {"the number of entries that the dictionary omits", COMMANDED(PAIR, COMMAND("#x2000", "0", "05")), 2, 2,
         "line 2: a start-up command writes 2000:0, which the dictionary lacks: it is added"},
        {"two bytes of it", COMMANDED(PAIR, COMMAND("#x2000", "0", "0500")), 2, 2,
         "line 2: a start-up command writes 2000:0, which the dictionary lacks: it is added"},
        {"no data", COMMANDED("", COMMAND("#x2000", "0", "")), 0, 0, NULL},
        {"the first assignment", COMMANDED("", COMMAND("#x1C10", "1", "0016")), 0, 0, NULL},
        {"the last assignment", COMMANDED("", COMMAND("#x1C2F", "1", "0016")), 0, 0, NULL},
        {"before the assignments", COMMANDED("", COMMAND("#x1C0F", "1", "0016")), 1, 2,
         "line 2: a start-up command writes 1C0F:1, which the dictionary lacks: it is added"},
        {"behind the assignments", COMMANDED("", COMMAND("#x1C30", "1", "0016")), 1, 2,
         "line 2: a start-up command writes 1C30:1, which the dictionary lacks: it is added"},
        {"the first mapping of outputs", COMMANDED("", COMMAND("#x1600", "1", "0016")), 0, 0, NULL},
        {"the last mapping of inputs", COMMANDED("", COMMAND("#x1BFF", "1", "0016")), 0, 0, NULL},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = make_text(table[i].what, table[i].text);
        ect_od_t od = od_of(&m);
        const ect_object_t *o = ect_od_find(&od, 0x2000);
        o = o != NULL ? o : ect_od_find(&od, 0x1C30);
        o = o != NULL ? o : ect_od_find(&od, 0x1C0F);
        unsigned int entries = o != NULL ? o->last + 1u : 0, count = o != NULL ? o->entries[0].value : 0;
        if (entries != table[i].entries || count != table[i].count || (o != NULL && o->entries[0].bit_length != 8))
            fail_msg("%s: expected %u entries, a count of %u, got %u, %u", table[i].what, table[i].entries,
                     table[i].count, entries, count);
        expect_note(table[i].what, &m, table[i].note);
        free_made(&m);
    }
}

/* --- texts, lengths and left-out objects ------------------------------------------------------------------------- */

static void texts_of_devices(void **state)
{
#define NAMED(name) ESI_HEAD "<Device Physics='YY'><Type>DEV</Type>" name ESI_MAILBOX_SMS COE "</Device>" ESI_TAIL
    static const struct {
        const char *what, *text, *full, *summary;
    } table[] = {
        {"a name", NAMED("<Name>Long name</Name>"), "Long name", "Long name"},
        {"an empty name", NAMED("<Name> </Name>"), NULL, "DEV"},
        {"no name", NAMED(""), NULL, "DEV"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = make_text(table[i].what, table[i].text);
        const ect_device_t *d = device_of(&m);
        const char *full = d->full_name != NULL ? d->full_name : "(none)";
        if (strcmp(full, table[i].full != NULL ? table[i].full : "(none)") != 0 ||
            strcmp(d->summary, table[i].summary) != 0)
            fail_msg("%s: expected %s and %s, got %s and %s", table[i].what, table[i].full ? table[i].full : "(none)",
                     table[i].summary, full, d->summary);
        ect_od_t od = od_of(&m);
        const ect_object_t *name = ect_od_find(&od, 0x1008);
        assert_int_equal(name->entries[0].bit_length, 24);
        assert_int_equal(name->entries[0].value, 'D' | 'E' << 8 | 'V' << 16);
        free_made(&m);
    }
}

static void lengths_and_omissions(void **state)
{
#define TEXT(bits) WITH(DICT(OBJECT("#x2000", "", bits, "")))
    static const struct {
        const char *what, *text;
        uint16_t index, bits; /* of its last entry, 0: there is no such object */
        const char *note;
    } table[] = {
        {"65528 bits", TEXT("65528"), 0x2000, 65528, NULL},
        {"65536 bits", TEXT("65536"), 0x2000, 65528, "object 2000:0 has 8192 bytes; the twin has its first 8191"},
        {"a mapping of no PDO", WITH(DICT(OBJECT("#x1A05", "USINT", "8", ""))), 0x1A05, 0,
         "line 2: object 1A05 is not one of the file's PDOs: it is left out"},
        {"a mapping of a PDO", WITH(DICT(OBJECT("#x1A05", "USINT", "8", "")) TX("", "#x1A05", A8)), 0x1A05, 32, NULL},
        {"a gap of 65535 bits", WITH(TX("", "#x1A05", "<Entry><Index>0</Index><BitLen>65535</BitLen></Entry>")), 0x1A05,
         32,
         "an EEPROM of 2048 bytes has no room for the unassigned PDOs, and all names of PDOs, entries and "
         "clock modes: left out"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = make_text(table[i].what, table[i].text);
        ect_od_t od = od_of(&m);
        const ect_object_t *o = ect_od_find(&od, table[i].index);
        unsigned int bits = o != NULL ? o->entries[o->last].bit_length : 0;
        if (bits != table[i].bits)
            fail_msg("%s: expected %u bits, got %u", table[i].what, table[i].bits, bits);
        expect_note(table[i].what, &m, table[i].note);
        free_made(&m);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"a description has at most 255 PDOs, modes, commands, categories, and 8 FMMUs", counts, NULL, NULL, NULL},
        {"a PDO beyond a limit of its index, its entries or its memory is refused", refusals, NULL, NULL, NULL},
        {"1486 bytes of process data fit a frame, 1487 are refused", longest_image, NULL, NULL, NULL},
        {"a mapping has 254 elements at most, with those of long gaps", long_gaps, NULL, NULL, NULL},
        {"an assignment has at most 254 elements", longest_assignment, NULL, NULL, NULL},
        {"without CoE a PDO has an index of a mapping that no other PDO has", substitutes, NULL, NULL, NULL},
        {"only with PdoAssign can 1C13h be written, and have more than the default", without_pdo_assign, NULL, NULL,
         NULL},
        {"a mapping has the elements of the dictionary, and at least those of the PDO", elements_of_a_mapping, NULL,
         NULL, NULL},
        {"timeouts of the mailbox are 0 when absent, and at most 65535 ms", mailbox_timeouts, NULL, NULL, NULL},
        {"the chip and the EEPROM are the smallest that have the memory", chips_and_memory, NULL, NULL, NULL},
        {"a bootstrap mailbox needs 8 bytes and a length", boot_mailboxes, NULL, NULL, NULL},
        {"outputs without a master return to their defaults", outputs_return, NULL, NULL, NULL},
        {"a signal has the limits of the file where its type can have them", signal_ranges, NULL, NULL, NULL},
        {"PDOs, assigned or not, have signals before objects have", signal_places, NULL, NULL, NULL},
        {"an object that a PDO or the stack replaces has its code", codes_of_replaced_objects, NULL, NULL, NULL},
        {"a start-up command makes its entry writable in the states of its transitions", transitions, NULL, NULL, NULL},
        {"a start-up command leaves the rights that there are", rights_of_commands, NULL, NULL, NULL},
        {"a start-up command keeps the transitions that CoE has", unknown_transitions, NULL, NULL, NULL},
        {"a start-up command adds objects within the limits of the dictionary", commands_against_the_dictionary, NULL,
         NULL, NULL},
        {"the name of a device is its summary, and its type where there is none", texts_of_devices, NULL, NULL, NULL},
        {"an entry has at most 65528 bits, a mapping 254 elements and a PDO", lengths_and_omissions, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
