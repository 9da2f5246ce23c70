/* SPDX-License-Identifier: MIT */
/* Groups of the PDOs of modules (src/esi/pdo_groups.c). */
#include "rack.h"

#define TX(index, bits)                                                                                                \
    "<TxPdo Fixed='1' Sm='3'><Index DependOnSlot='1'>" index "</Index><Name>P</Name><Entry><Index DependOnSlot='1'>"   \
    "#x6000</Index><SubIndex>1</SubIndex><BitLen>" bits "</BitLen><Name>A</Name><DataType>BIT" bits                    \
    "</DataType></Entry></TxPdo>"
#define OF_GROUP(ident, group, pdo)                                                                                    \
    "<Module><Type ModuleIdent='" ident "' " group ">M</Type><Name>M</Name>" pdo "</Module>"

/* Three slots with module 1 (3 bits, group 1), module 2 (5 bits, group 0) and module 3 (2 bits, no group). */
#define GROUPED(type, pdos, groups)                                                                                    \
    ESI_HEAD "\n<Device Physics='YY'><Type ProductCode='#x1' RevisionNo='#x2' " type ">RACK</Type><Name>A rack</Name>" \
             "<Fmmu>Outputs</Fmmu><Fmmu>Inputs</Fmmu>" ESI_MAILBOX_SMS ESI_PROCESS_SMS pdos                            \
             "<Mailbox><CoE SdoInfo='1' CompleteAccess='1'/></Mailbox>"                                                \
             "<Slots DownloadModuleIdentList='1' SlotPdoIncrement='1' SlotIndexIncrement='#x10'>"                      \
             "<Slot MinInstances='1' MaxInstances='1'><Name>A</Name><ModuleIdent Default='1'>1</ModuleIdent></Slot>"   \
             "<Slot MinInstances='1' MaxInstances='1'><Name>B</Name><ModuleIdent Default='1'>2</ModuleIdent></Slot>"   \
             "<Slot MinInstances='1' MaxInstances='1'><Name>C</Name><ModuleIdent Default='1'>3</ModuleIdent>"          \
             "<ModuleIdent>1</ModuleIdent></Slot>" groups "</Slots>" ESI_EEPROM                                        \
             "</Device></Devices><Modules>" OF_GROUP("1", "ModulePdoGroup='1'", TX("#x1a00", "3"))                     \
                 OF_GROUP("2", "ModulePdoGroup='0'", TX("#x1a00", "5"))                                                \
                     OF_GROUP("3", "", TX("#x1a00", "2")) "</Modules></Descriptions></EtherCATInfo>"
#define GROUP(attributes) "<ModulePdoGroup " attributes "/>"
#define PADDING(entry)                                                                                                 \
    "<TxPdo Fixed='1' Sm='3'><Index>#x1bff</Index><Name>Fill</Name><Entry>" entry "<BitLen>7</BitLen></Entry></TxPdo>"

static uint32_t element(const made_t *m, uint16_t index, unsigned int n)
{
    const ect_od_t od = ect_device_od(ect_esi_twin_product(m->twin)->device, NULL);
    const ect_object_t *object = ect_od_find(&od, index);
    return object != NULL ? ect_od_element(object, n) : 0;
}

/* Compares the PDOs of an assignment, 1C12h or 1C13h. */
static void expect_pdos(const made_t *m, const char *what, uint16_t assignment, const uint16_t *pdos,
                        unsigned int count)
{
    for (unsigned int n = 0; n < count; n++) {
        const uint32_t pdo = element(m, assignment, n + 1);
        if (pdo != pdos[n])
            fail_msg("%s: PDO %u is %04X, expected %04X", what, n + 1, (unsigned int)pdo, pdos[n]);
    }
}

static void order(void **state)
{
    static const struct {
        const char *what, *text;
        uint16_t pdos[5];
        uint16_t padding; /* a padding PDO; 0: none */
        uint32_t entry;   /* of it */
    } rows[] = {
        {"no groups", GROUPED("", "", ""), {0x1A00, 0x1A01, 0x1A02}, 0x1BFF, 0},
        {"two groups", GROUPED("", "", GROUP("") GROUP("")), {0x1A02, 0x1A01, 0x1A00}, 0x1BFF, 0},
        {"padded by a byte",
         GROUPED("", "", GROUP("Alignment='1' TxPdo='#x1bff'") GROUP("")),
         {0x1A02, 0x1A01, 0x1BFF, 0x1A00},
         0x1BFF,
         0x00000001},
        {"both padded by two bytes",
         GROUPED("", "", GROUP("Alignment='2' TxPdo='#x1bfe'") GROUP("Alignment='2' TxPdo='#x1bff' RxPdo='#x17ff'")),
         {0x1A02, 0x1A01, 0x1BFE, 0x1A00, 0x1BFF},
         0x1BFF,
         0x0000000D},
        {"aligned as it is",
         GROUPED("", PADDING("<Index>0</Index>"), GROUP("Alignment='1' RxPdo='#x17ff'") GROUP("")),
         {0x1BFF, 0x1A02, 0x1A01, 0x1A00},
         0x1BFF,
         0x00000007},
        {"a padding PDO of the file",
         GROUPED("", PADDING("<Index>0</Index>"), GROUP("Alignment='1' TxPdo='#x1bff'") GROUP("")),
         {0x1A02, 0x1A01, 0x1BFF, 0x1A00},
         0x1BFF,
         0x00000001},
        {"the device in the last group",
         GROUPED("ModulePdoGroup='1'", PADDING("<Index>#x6100</Index><SubIndex>1</SubIndex>"), GROUP("") GROUP("")),
         {0x1A02, 0x1A01, 0x1BFF, 0x1A00},
         0x1BFF,
         0x61000107},
        {"an alignment that no module has",
         GROUPED("", "", GROUP("Alignment='17' TxPdo='#x1bff'") GROUP("Alignment='-1' TxPdo='#x1bff'")),
         {0x1A02, 0x1A01, 0x1A00},
         0x1BFF,
         0},
        {"a group without modules",
         GROUPED("", "", GROUP("") GROUP("") GROUP("Alignment='4' TxPdo='#x1bff'")),
         {0x1A02, 0x1A01, 0x1A00},
         0x1BFF,
         0},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        made_t m = make_text(rows[i].what, rows[i].text);
        expect_pdos(&m, rows[i].what, 0x1C13, rows[i].pdos, 5);
        if (element(&m, rows[i].padding, 1) != rows[i].entry)
            fail_msg("%s: the padding is %08X", rows[i].what, (unsigned int)element(&m, rows[i].padding, 1));
        free_made(&m);
    }
}

/* Outputs of the device, in its own group: those of a SyncManager count. */
static void outputs(void **state)
{
#define RX(attributes, index, bits)                                                                                    \
    "<RxPdo Fixed='1' " attributes "><Index>" index "</Index><Name>P</Name><Entry><Index>#x7000</Index><SubIndex>1"    \
    "</SubIndex><BitLen>" bits "</BitLen><Name>A</Name><DataType>BIT" bits "</DataType></Entry></RxPdo>"
#define OUTPUTS(alignment, pdos)                                                                                       \
    GROUPED("ModulePdoGroup='1'", pdos, GROUP("") GROUP("Alignment='" alignment "' RxPdo='#x17ff' TxPdo='#x1bff'"))
    static const struct {
        const char *what, *text;
        uint16_t pdos[4];
        uint32_t padding;
    } rows[] = {
        {"three bits", OUTPUTS("1", RX("Sm='2'", "#x1600", "3")), {0x1600, 0x17FF}, 5},
        {"three bits to four bytes", OUTPUTS("4", RX("Sm='2'", "#x1600", "3")), {0x1600, 0x17FF}, 29},
        {"a byte", OUTPUTS("1", RX("Sm='2'", "#x1600", "8")), {0x1600}, 0},
        {"two PDOs",
         OUTPUTS("1", RX("Sm='2'", "#x1600", "3") RX("Sm='2'", "#x1601", "2")),
         {0x1600, 0x1601, 0x17FF},
         3},
        {"a PDO of no SyncManager",
         OUTPUTS("1", RX("Sm='2'", "#x1600", "3") RX("", "#x1601", "2")),
         {0x1600, 0x17FF},
         5},
        {"a virtual PDO",
         OUTPUTS("1", RX("Sm='2'", "#x1600", "3") RX("Virtual='1' Sm='2'", "#x1601", "2")),
         {0x1600, 0x17FF},
         5},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        made_t m = make_text(rows[i].what, rows[i].text);
        expect_pdos(&m, rows[i].what, 0x1C12, rows[i].pdos, 4);
        if (element(&m, 0x17FF, 1) != rows[i].padding)
            fail_msg("%s: the padding is %08X", rows[i].what, (unsigned int)element(&m, 0x17FF, 1));
        free_made(&m);
    }
}

static void with_data(void **state)
{
    size_t count = 0;
    (void)state;
    made_t m = make_text("data", GROUPED("", PADDING("<Index>#x6100</Index><SubIndex>1</SubIndex>"),
                                         GROUP("Alignment='1' TxPdo='#x1bff'") GROUP("")));
    const char *const *notes = ect_esi_twin_notes(m.twin, &count);
    assert_int_equal(count, 1);
    assert_string_equal(notes[0], "PDO 1BFF has data: it does not fill the group of PDOs 0");
    assert_int_equal(element(&m, 0x1C13, 1), 0x1BFF);
    free_made(&m);
}

/* Slot 3 gets 3 bits of group 1 in place of 2 bits without a group. */
static void changed(void **state)
{
    rig_t r;
    (void)state;
    open_rig(&r, GROUPED("", "", GROUP("Alignment='1' TxPdo='#x1bfe'") GROUP("Alignment='1' TxPdo='#x1bff'")), PREOP);
    assert_int_equal(read_number(&r, 0x1BFE, 1), 0x00000001);
    assert_int_equal(write_number(&r, 1, 1, 4), 0);
    assert_int_equal(write_number(&r, 2, 2, 4), 0);
    assert_int_equal(write_number(&r, 3, 1, 4), 0);
    static const uint16_t pdos[] = {0x1A01, 0x1BFE, 0x1A00, 0x1A02, 0x1BFF};
    for (uint8_t n = 0; n < 5; n++)
        assert_int_equal(read_number(&r, 0x1C13, (uint8_t)(n + 1)) & 0xFFFF, pdos[n]);
    assert_int_equal(read_number(&r, 0x1BFE, 1), 0x00000003);
    assert_int_equal(read_number(&r, 0x1BFF, 1), 0x00000002);
    close_rig(&r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"MDP-019: the PDOs of a group follow one another, padded to its alignment", order, NULL, NULL, NULL},
        {"MDP-019: the outputs of a group are padded, too", outputs, NULL, NULL, NULL},
        {"MDP-019: a PDO with data is no padding", with_data, NULL, NULL, NULL},
        {"MDP-009 MDP-019: F030h changes order and padding", changed, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
