/* SPDX-License-Identifier: MIT */
/* Indices of a module in its place: they move with the slot, with the slot group, or with both. */
#include "rack.h"

/* Two groups of slots; each index of the module has its own flags. */
#define GROUPS(on_slots, on_second)                                                                                    \
    ESI_HEAD "\n<Device Physics='YY'><Type ProductCode='#x1' RevisionNo='#x2'>RACK</Type><Name>A rack</Name>"          \
             "<Profile><ProfileNo>5001</ProfileNo></Profile><Fmmu>Outputs</Fmmu><Fmmu>Inputs</"                        \
             "Fmmu>" ESI_MAILBOX_SMS ESI_PROCESS_SMS                                                                   \
             "<Mailbox><CoE SdoInfo='1' PdoAssign='1'/></Mailbox><Slots MaxSlotCount='3' "                             \
             "SlotPdoIncrement='1' SlotIndexIncrement='#x10' " on_slots ">"                                            \
             "<Slot MinInstances='2' MaxInstances='2'><Name>A</Name><ModuleIdent Default='1'>1</ModuleIdent></Slot>"   \
             "<Slot SlotGroup='1' MinInstances='1' MaxInstances='1' " on_second                                        \
             "><Name>B</Name><ModuleIdent Default='1'>1</ModuleIdent></Slot></Slots>" ESI_EEPROM                       \
             "</Device></Devices><Modules><Module><Type ModuleIdent='1'>M</Type><Name>M</Name>"                        \
             "<TxPdo Sm='3'><Index DependOnSlot='1' DependOnSlotGroup='1'>#x1A00</Index><Name>P</Name>"                \
             "<Exclude>#x1B00</Exclude><Exclude DependOnSlot='1'>#x1B00</Exclude>"                                     \
             "<Entry><Index DependOnSlot='1' DependOnSlotGroup='1'>#x6000</Index><SubIndex>1</SubIndex>"               \
             "<BitLen>16</BitLen><DataType>UINT</DataType></Entry></TxPdo>"                                            \
             "<TxPdo><Index DependOnSlot='1'>#x1B00</Index><Name>Q</Name>"                                             \
             "<Entry><Index DependOnSlot='1'>#x6800</Index><SubIndex>1</SubIndex><BitLen>16</BitLen>"                  \
             "<DataType>UINT</DataType></Entry></TxPdo>"                                                               \
             "<Mailbox><CoE><InitCmd><Transition>PS</Transition><Index DependOnSlotGroup='1'>#x9000</Index>"           \
             "<SubIndex>0</SubIndex><Data>0100</Data></InitCmd></CoE></Mailbox>"                                       \
             "<Profile><Dictionary><DataTypes><DataType><Name>UINT</Name><BitSize>16</BitSize></DataType></DataTypes>" \
             "<Objects><Object><Index DependOnSlot='1' DependOnSlotGroup='1'>#x8000</Index><Name>F</Name>"             \
             "<Type>UINT</Type><BitSize>16</BitSize></Object></Objects></Dictionary></Profile></Module></Modules>"     \
             "</Descriptions></EtherCATInfo>"

static const ect_pdo_t *pdo_of(const ect_device_t *device, uint16_t index)
{
    for (unsigned int i = 0; i < device->pdo_count; i++) {
        if (device->pdos[i].index == index)
            return &device->pdos[i];
    }
    return NULL;
}

static void with_groups(void **state)
{
    static const struct {
        const char *what, *text;
        uint16_t pdo, mapped, object, command; /* of the slot in group 1, the third one of the device */
    } rows[] = {
        {"increments of all slots", GROUPS("SlotGroupPdoIncrement='#x40' SlotGroupIndexIncrement='#x100'", ""), 0x1A42,
         0x6120, 0x8120, 0x9100},
        {"increments of the slot",
         GROUPS("SlotGroupPdoIncrement='#x40' SlotGroupIndexIncrement='#x100'",
                "SlotGroupPdoIncrement='#x80' SlotGroupIndexIncrement='#x200'"),
         0x1A82, 0x6220, 0x8220, 0x9200},
        {"no increments of groups", GROUPS("", ""), 0x1A02, 0x6020, 0x8020, 0x9000},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        made_t m = make_text(rows[i].what, rows[i].text);
        const ect_od_t od = od_of(&m);
        const ect_object_t *pdo = ect_od_find(&od, rows[i].pdo);
        if (pdo == NULL || ect_od_element(pdo, 1) >> 16 != rows[i].mapped || !ect_od_find(&od, rows[i].object) ||
            !ect_od_find(&od, rows[i].command))
            fail_msg("%s: expected PDO %04Xh of %04Xh, objects %04Xh and %04Xh", rows[i].what, rows[i].pdo,
                     rows[i].mapped, rows[i].object, rows[i].command);
        free_made(&m);
    }
}

static void each_flag(void **state)
{
    made_t m = make_text("flags", GROUPS("SlotGroupPdoIncrement='#x40' SlotGroupIndexIncrement='#x100'", ""));
    const ect_pdo_t *second = pdo_of(device_of(&m), 0x1A01);
    const ect_pdo_t *third = pdo_of(device_of(&m), 0x1A42);
    (void)state;
    assert_non_null(second);
    assert_int_equal(second->excludes[0], 0x1B00); /* without a flag */
    assert_int_equal(second->excludes[1], 0x1B01);
    assert_non_null(third);
    assert_int_equal(third->excludes[1], 0x1B02); /* with the slot alone */
    const ect_od_t od = od_of(&m);
    assert_non_null(ect_od_find(&od, 0x6820));
    free_made(&m);
}

/* A slot for one module, then one for two of another kind. */
#define OWN(on_slots, on_second)                                                                                       \
    ESI_HEAD                                                                                                           \
    "\n<Device Physics='YY'><Type ProductCode='#x1' RevisionNo='#x2'>RACK</Type><Name>A rack</Name>"                   \
    "<Profile><ProfileNo>5001</ProfileNo></Profile><Fmmu>Outputs</Fmmu><Fmmu>Inputs</"                                 \
    "Fmmu>" ESI_MAILBOX_SMS ESI_PROCESS_SMS "<Mailbox><CoE SdoInfo='1'/></Mailbox><Slots MaxSlotCount='3' " on_slots   \
    ">"                                                                                                                \
    "<Slot MinInstances='1' MaxInstances='1'><Name>A</Name><ModuleIdent Default='1'>#x110</ModuleIdent></Slot>"        \
    "<Slot MinInstances='2' MaxInstances='2' " on_second                                                               \
    "><Name>B</Name><ModuleIdent Default='1'>#x120</ModuleIdent></Slot></Slots>" ESI_EEPROM                            \
    "</Device></Devices><Modules>" MODULE("#x110", "IO", TX_PDO)                                                       \
        MODULE("#x120", "IO", RX_PDO) "</Modules></Descriptions></EtherCATInfo>"

static void own_increments(void **state)
{
    static const struct {
        const char *what, *text;
        uint16_t first, second, mapped; /* PDOs of slot B's instances; the object that the second one maps */
    } rows[] = {
        {"of all slots", OWN("SlotPdoIncrement='1' SlotIndexIncrement='#x10'", ""), 0x1601, 0x1602, 0x7020},
        {"of the slot",
         OWN("SlotPdoIncrement='1' SlotIndexIncrement='#x10'", "SlotPdoIncrement='8' SlotIndexIncrement='#x20'"),
         0x1600, 0x1608, 0x7020},
        {"of the slot for PDOs alone", OWN("SlotPdoIncrement='1' SlotIndexIncrement='#x10'", "SlotPdoIncrement='#x10'"),
         0x1600, 0x1610, 0x7010},
        {"PDOs 8 a slot", OWN("SlotPdoIncrement='8' SlotIndexIncrement='#x10'", ""), 0x1608, 0x1610, 0x7020},
        {"PDOs 16 a slot", OWN("SlotPdoIncrement='#x10' SlotIndexIncrement='#x10'", ""), 0x1610, 0x1620, 0x7020},
        {"0", OWN("SlotPdoIncrement='0' SlotIndexIncrement='0'", ""), 0x1600, 0x1600, 0x7000},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        made_t m = make_text(rows[i].what, rows[i].text);
        const ect_od_t od = od_of(&m);
        const ect_object_t *second = ect_od_find(&od, rows[i].second);
        if (!ect_od_find(&od, rows[i].first) || second == NULL || ect_od_element(second, 1) >> 16 != rows[i].mapped)
            fail_msg("increments %s: expected PDOs %04Xh and %04Xh, the second one with %04Xh", rows[i].what,
                     rows[i].first, rows[i].second, rows[i].mapped);
        free_made(&m);
    }
}

/* A gap is one in each slot, also where its index depends on the slot. */
static void gaps(void **state)
{
#define WITH_A_GAP                                                                                                     \
    "<TxPdo Fixed='1' Sm='3'><Index DependOnSlot='1'>#x1a00</Index><Name>P</Name><Entry><Index DependOnSlot='1'>"      \
    "#x6000</Index><SubIndex>1</SubIndex><BitLen>8</BitLen><Name>A</Name><DataType>USINT</DataType></Entry><Entry>"    \
    "<Index DependOnSlot='1'>0</Index><BitLen>8</BitLen></Entry></TxPdo>"
    static const char text[] = ESI_HEAD
        "\n<Device Physics='YY'><Type ProductCode='#x1' RevisionNo='#x2'>RACK</Type><Name>A rack</Name>"
        "<Fmmu>Outputs</Fmmu><Fmmu>Inputs</Fmmu>" ESI_MAILBOX_SMS ESI_PROCESS_SMS
        "<Mailbox><CoE/></Mailbox><Slots MaxSlotCount='2' SlotPdoIncrement='1' SlotIndexIncrement='#x10'>"
        "<Slot MinInstances='2' MaxInstances='2'><Name>A</Name><ModuleIdent Default='1'>#x110</ModuleIdent>"
        "</Slot></Slots>" ESI_EEPROM
        "</Device></Devices><Modules>" MODULE("#x110", "IO", WITH_A_GAP) "</Modules></Descriptions></EtherCATInfo>";
    (void)state;
    made_t m = make_text("gaps", text);
    const ect_od_t od = od_of(&m);
    for (uint16_t slot = 0; slot < 2; slot++) {
        const ect_object_t *pdo = ect_od_find(&od, 0x1A00 + slot);
        assert_non_null(pdo);
        assert_int_equal(ect_od_element(pdo, 1), (0x6000u + 0x10u * slot) << 16 | 0x0108);
        assert_int_equal(ect_od_element(pdo, 2), 8);
    }
    assert_null(ect_od_find(&od, 0x0010));
    free_made(&m);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"MDP-014: indices move by the slot's group times the increment of the slot, or else of all slots", with_groups,
         NULL, NULL, NULL},
        {"MDP-012 MDP-013: increments of a slot replace those of all slots and count its own instances", own_increments,
         NULL, NULL, NULL},
        {"MDP-011: gaps of modules have no index", gaps, NULL, NULL, NULL},
        {"MDP-011 MDP-014: each index, also of an Exclude, has its own flags", each_flag, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("ESI: places of modules", tests, NULL, NULL);
}
