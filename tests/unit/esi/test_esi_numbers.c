/* SPDX-License-Identifier: MIT */
/* Numbers of ESI files: the range of each, the value of an absent one; lines of elements. */
#include "from_text.h"

#include <inttypes.h>

/* --- ranges ------------------------------------------------------------------------------------------------------- */

#define INFO(body)       ESI_DEVICE("<Info>" body "</Info>")
#define PDO(body)        ESI_DEVICE("<RxPdo><Index>1</Index>" body "</RxPdo>")
#define BOX(body)        ESI_DEVICE("<Mailbox>" body "</Mailbox>")
#define MODE(body)       ESI_DEVICE("<Dc><OpMode><Name>DC</Name>" body "</OpMode></Dc>")
#define EEPROM(body)     ESI_DEVICE("<Eeprom>" body "</Eeprom>")
#define DICTIONARY(body) ESI_DEVICE("<Profile><Dictionary>" body "</Dictionary></Profile>")
#define TYPE(body)       DICTIONARY("<DataTypes><DataType><Name>DT</Name>" body "</DataType></DataTypes>")
#define OBJECT(body)     DICTIONARY("<Objects><Object>" body "</Object></Objects>")
#define MAPPING(body)                                                                                                  \
    INFO("<VendorSpecific><TwinCAT><AlternativeSmMapping>" body "</AlternativeSmMapping></TwinCAT></VendorSpecific>")
#define MODULE(type, body)                                                                                             \
    "<EtherCATInfo><Vendor><Id>1</Id></Vendor><Descriptions><Devices><Device><Type>DEV</Type><Slots><Slot/></Slots>"   \
    "</Device></Devices><Modules><Module><Type" type ">M</Type>" body "</Module></Modules></Descriptions>"             \
    "</EtherCATInfo>"

/* The element, or the attribute, replaces %s. */
static const struct {
    const char *name, *text;
    bool attribute;
    int64_t low, high;
} ranges[] = {
    {"Id",
     "<EtherCATInfo><Vendor>%s</Vendor><Descriptions><Devices><Device><Type>A</Type></Device></Devices>"
     "</Descriptions></EtherCATInfo>",
     false, INT32_MIN, UINT32_MAX},
    {"ProductCode", ESI_HEAD "<Device><Type %s>A</Type></Device>" ESI_TAIL, true, 0, UINT32_MAX},
    {"RevisionNo", ESI_HEAD "<Device><Type %s>A</Type></Device>" ESI_TAIL, true, 0, UINT32_MAX},
    {"ModulePdoGroup", ESI_HEAD "<Device><Type %s>A</Type></Device>" ESI_TAIL, true, -1, INT32_MAX},
    {"PreopTimeout", INFO("<StateMachine><Timeout>%s</Timeout></StateMachine>"), false, 0, UINT32_MAX},
    {"SafeopOpTimeout", INFO("<StateMachine><Timeout>%s</Timeout></StateMachine>"), false, 0, UINT32_MAX},
    {"BackToInitTimeout", INFO("<StateMachine><Timeout>%s</Timeout></StateMachine>"), false, 0, UINT32_MAX},
    {"BackToSafeopTimeout", INFO("<StateMachine><Timeout>%s</Timeout></StateMachine>"), false, 0, UINT32_MAX},
    {"RequestTimeout", INFO("<Mailbox><Timeout>%s</Timeout></Mailbox>"), false, 0, UINT32_MAX},
    {"ResponseTimeout", INFO("<Mailbox><Timeout>%s</Timeout></Mailbox>"), false, 0, UINT32_MAX},
    {"EBusCurrent", INFO("<Electrical>%s</Electrical>"), false, INT16_MIN, INT16_MAX},
    {"No", MAPPING("<Sm %s/>"), true, 0, UINT8_MAX},
    {"Pdo", MAPPING("<Sm>%s</Sm>"), false, 0, UINT16_MAX},
    {"StartAddress", ESI_DEVICE("<Sm %s/>"), true, 0, UINT16_MAX},
    {"ControlByte", ESI_DEVICE("<Sm %s/>"), true, 0, UINT8_MAX},
    {"DefaultSize", ESI_DEVICE("<Sm %s/>"), true, 0, UINT16_MAX},
    {"MinSize", ESI_DEVICE("<Sm %s/>"), true, 0, UINT16_MAX},
    {"MaxSize", ESI_DEVICE("<Sm %s/>"), true, 0, UINT16_MAX},
    {"Enable", ESI_DEVICE("<Sm %s/>"), true, 0, UINT8_MAX},
    {"Index", ESI_DEVICE("<TxPdo>%s</TxPdo>"), false, 0, UINT16_MAX},
    {"Sm", ESI_DEVICE("<TxPdo %s><Index>1</Index></TxPdo>"), true, 0, UINT8_MAX},
    {"OSFac", ESI_DEVICE("<TxPdo %s><Index>1</Index></TxPdo>"), true, 1, UINT16_MAX},
    {"Exclude", PDO("%s"), false, 0, UINT16_MAX},
    {"Index", PDO("<Entry>%s<BitLen>1</BitLen></Entry>"), false, 0, UINT16_MAX},
    {"SubIndex", PDO("<Entry><Index>1</Index>%s<BitLen>1</BitLen></Entry>"), false, 0, UINT8_MAX},
    {"BitLen", PDO("<Entry><Index>1</Index>%s</Entry>"), false, 0, UINT16_MAX},
    {"Index", BOX("<CoE><InitCmd>%s</InitCmd></CoE>"), false, 0, UINT16_MAX},
    {"SubIndex", BOX("<CoE><InitCmd><Index>1</Index>%s</InitCmd></CoE>"), false, 0, UINT8_MAX},
    {"Type", BOX("<EoE><InitCmd>%s</InitCmd></EoE>"), false, 0, 15},
    {"ChannelCount", BOX("<SoE %s/>"), true, 0, UINT8_MAX},
    {"IDN", BOX("<SoE><InitCmd>%s</InitCmd></SoE>"), false, 0, UINT16_MAX},
    {"Chn", BOX("<SoE><InitCmd %s><IDN>1</IDN></InitCmd></SoE>"), true, 0, 7},
    {"AssignActivate", MODE("%s"), false, 0, UINT16_MAX},
    {"CycleTimeSync0", MODE("%s"), false, INT32_MIN, UINT32_MAX},
    {"ShiftTimeSync0", MODE("%s"), false, INT32_MIN, UINT32_MAX},
    {"CycleTimeSync1", MODE("%s"), false, INT32_MIN, UINT32_MAX},
    {"ShiftTimeSync1", MODE("%s"), false, INT32_MIN, UINT32_MAX},
    {"Factor", MODE("<CycleTimeSync0 %s>0</CycleTimeSync0>"), true, INT16_MIN, INT16_MAX},
    {"Factor", MODE("<CycleTimeSync1 %s>0</CycleTimeSync1>"), true, INT16_MIN, INT16_MAX},
    {"No", MODE("<Sm %s/>"), true, 0, UINT8_MAX},
    {"ByteSize", EEPROM("%s"), false, 0, 4 * 1024 * 1024},
    {"CatNo", EEPROM("<Category>%s</Category>"), false, 0, UINT16_MAX},
    {"DataUINT", EEPROM("<Category><CatNo>1</CatNo>%s</Category>"), false, INT32_MIN, UINT32_MAX},
    {"DataUDINT", EEPROM("<Category><CatNo>1</CatNo>%s</Category>"), false, INT32_MIN, UINT32_MAX},
    {"ProfileNo", ESI_DEVICE("<Profile>%s</Profile>"), false, 0, UINT16_MAX},
    {"AddInfo", ESI_DEVICE("<Profile><ProfileNo>1</ProfileNo>%s</Profile>"), false, 0, UINT16_MAX},
    {"BitSize", TYPE("%s"), false, 0, UINT32_MAX},
    {"LBound", TYPE("<ArrayInfo>%s</ArrayInfo>"), false, 0, UINT16_MAX},
    {"Elements", TYPE("<ArrayInfo>%s</ArrayInfo>"), false, 0, UINT16_MAX},
    {"SubIdx", TYPE("<SubItem>%s</SubItem>"), false, 0, UINT8_MAX},
    {"BitSize", TYPE("<SubItem>%s</SubItem>"), false, 0, UINT32_MAX},
    {"BitOffs", TYPE("<SubItem>%s</SubItem>"), false, 0, UINT32_MAX},
    {"Value", TYPE("<SubItem><Properties><Property><Name>SdoInfoBits</Name>%s</Property></Properties></SubItem>"),
     false, 0, UINT16_MAX},
    {"Index", OBJECT("%s"), false, 0, UINT16_MAX},
    {"BitSize", OBJECT("<Index>1</Index>%s"), false, 0, UINT32_MAX},
    {"MaxSlotCount", ESI_DEVICE("<Slots %s/>"), true, 0, UINT16_MAX},
    {"SlotPdoIncrement", ESI_DEVICE("<Slots %s/>"), true, 0, UINT16_MAX},
    {"SlotIndexIncrement", ESI_DEVICE("<Slots %s/>"), true, 0, UINT16_MAX},
    {"SlotGroupPdoIncrement", ESI_DEVICE("<Slots %s/>"), true, 0, UINT16_MAX},
    {"SlotGroupIndexIncrement", ESI_DEVICE("<Slots %s/>"), true, 0, UINT16_MAX},
    {"MinInstances", ESI_DEVICE("<Slots><Slot %s/></Slots>"), true, 0, UINT16_MAX},
    {"MaxInstances", ESI_DEVICE("<Slots><Slot %s/></Slots>"), true, 0, UINT16_MAX},
    {"SlotPdoIncrement", ESI_DEVICE("<Slots><Slot %s/></Slots>"), true, 0, UINT16_MAX},
    {"SlotIndexIncrement", ESI_DEVICE("<Slots><Slot %s/></Slots>"), true, 0, UINT16_MAX},
    {"SlotGroup", ESI_DEVICE("<Slots><Slot %s/></Slots>"), true, 0, UINT16_MAX},
    {"SlotGroupPdoIncrement", ESI_DEVICE("<Slots><Slot %s/></Slots>"), true, 0, UINT16_MAX},
    {"SlotGroupIndexIncrement", ESI_DEVICE("<Slots><Slot %s/></Slots>"), true, 0, UINT16_MAX},
    {"ModuleIdent", ESI_DEVICE("<Slots><Slot>%s</Slot></Slots>"), false, 0, UINT32_MAX},
    {"Alignment", ESI_DEVICE("<Slots><ModulePdoGroup %s/></Slots>"), true, INT32_MIN, INT32_MAX},
    {"RxPdo", ESI_DEVICE("<Slots><ModulePdoGroup %s/></Slots>"), true, 0, UINT16_MAX},
    {"TxPdo", ESI_DEVICE("<Slots><ModulePdoGroup %s/></Slots>"), true, 0, UINT16_MAX},
    {"ModuleIdent", MODULE(" %s", ""), true, 0, UINT32_MAX},
    {"ModulePdoGroup", MODULE(" %s", ""), true, -1, INT32_MAX},
    {"ProfileNo", MODULE("", "<Profile>%s</Profile>"), false, 0, UINT16_MAX},
};

static void each_number_has_a_range(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof ranges / sizeof ranges[0]; i++) {
        const int64_t values[] = {ranges[i].low, ranges[i].high, ranges[i].low - 1, ranges[i].high + 1};
        for (size_t k = 0; k < 4; k++) {
            char number[100], text[900], why[400] = "", expected[200] = "";
            const char *at = strstr(ranges[i].text, "%s");
            if (ranges[i].attribute)
                (void)snprintf(number, sizeof number, "%s='%" PRId64 "'", ranges[i].name, values[k]);
            else
                (void)snprintf(number, sizeof number, "<%s>%" PRId64 "</%s>", ranges[i].name, values[k],
                               ranges[i].name);
            (void)snprintf(text, sizeof text, "%.*s%s%s", (int)(at - ranges[i].text), ranges[i].text, number, at + 2);
            if (k >= 2)
                (void)snprintf(expected, sizeof expected, ": %s is %" PRId64 ", not %" PRId64 " to %" PRId64,
                               ranges[i].name, values[k], ranges[i].low, ranges[i].high);
            ect_esi_t *esi = ect_esi_parse("t.xml", text, strlen(text), why, sizeof why);
            const bool read = esi != NULL && ect_esi_select(esi, "", why, sizeof why) != NULL;
            if (read != (k < 2) || (k < 2 ? why[0] != '\0' : strstr(why, expected) == NULL))
                fail_msg("row %zu, %s: expected \"%s\", got \"%s\"", i, number, expected, why);
            ect_esi_close(esi);
        }
    }
}

/* --- absent numbers and lines ------------------------------------------------------------------------------------- */

/* Elements without content, the most of them on a line of their own. */
static const char bare[] =
    "<EtherCATInfo><Vendor><Id>1</Id></Vendor><Descriptions><Devices>\n<Device><Type>DEV</Type><Info><VendorSpecific>"
    "<TwinCAT><AlternativeSmMapping><Sm/></AlternativeSmMapping></TwinCAT></VendorSpecific></Info>\n<Sm/>\n<RxPdo>"
    "<Index>1</Index>\n<Entry><Index>0</Index><BitLen>1</BitLen></Entry></RxPdo><Mailbox><EoE>\n<InitCmd><Type>0</Type>"
    "</InitCmd></EoE><CoE>\n<InitCmd/></CoE><SoE>\n<InitCmd><IDN>0</IDN></InitCmd></SoE></Mailbox><Dc><OpMode/>"
    "<OpMode><CycleTimeSync0>0</CycleTimeSync0><CycleTimeSync1>0</CycleTimeSync1></OpMode></Dc><Eeprom>\n<Category/></"
    "Eeprom><Profile><Dictionary>"
    "<DataTypes><DataType><ArrayInfo/>\n<SubItem/></DataType></DataTypes><Objects>\n<Object><Index>0</Index></Object>"
    "</Objects></Dictionary></Profile><Slots><ModulePdoGroup/><Slot/></Slots></Device></Devices><Modules>\n<Module>"
    "<Type/></Module></Modules></Descriptions></EtherCATInfo>";

static const ect_esi_device_t *bare_device(ect_esi_t **esi)
{
    char why[400] = "";
    *esi = ect_esi_parse("t.xml", bare, sizeof bare - 1, why, sizeof why);
    const ect_esi_device_t *device = *esi != NULL ? ect_esi_select(*esi, "", why, sizeof why) : NULL;
    if (device == NULL)
        fail_msg("%s", why);
    return device;
}

static void a_number_that_is_absent_is_0_but_for_some(void **state)
{
    ect_esi_t *esi;
    (void)state;
    const ect_esi_device_t *d = bare_device(&esi);
    const ect_esi_mail_t *eoe = &d->mailbox.mails[0], *soe = &d->mailbox.mails[1];
    const ect_esi_slot_t *slot = &d->slots[0];
    const ect_esi_dc_t *dc = &d->dcs[1];
    const ect_esi_type_t *type = &d->dictionary.types[0];
    const struct {
        const char *what;
        int64_t value, expected;
    } numbers[] = {
        {"Enable", d->sms[0].flags, 0},
        {"Sm of a PDO", d->pdos[0].sm, -1},
        {"OSFac", d->pdos[0].samples, 1},
        {"MaxInstances", slot->instances_max, 1},
        {"SubIdx", type->items[0].subindex, -1},
        {"elements of a mail of SoE", soe->elements, 0x40},
        {"type of a mail of SoE", soe->type, ECT_INIT_WRITES},
        {"ProductCode", d->product_code, 0},
        {"RevisionNo", d->revision, 0},
        {"ModulePdoGroup", d->pdo_group | d->modules[0].pdo_group, 0},
        {"timeouts of states", d->preop_ms | d->safeop_op_ms | d->back_to_init_ms | d->back_to_safeop_ms, 0},
        {"timeouts of mails", d->request_ms | d->response_ms, 0},
        {"EBusCurrent", d->ebus_current_ma, 0},
        {"IdentificationAdo", d->identification_ado.given, 0},
        {"No of an alternative", d->alternatives[0].sm, 0},
        {"StartAddress", d->sms[0].start, 0},
        {"ControlByte", d->sms[0].control, 0},
        {"DefaultSize", d->sms[0].size.given, 0},
        {"value of DefaultSize", d->sms[0].size.value, 0},
        {"MinSize", d->sms[0].minimum, 0},
        {"MaxSize", d->sms[0].maximum, 0},
        {"sub-index of an entry", d->pdos[0].entries[0].subindex, 0},
        {"type of EoE", eoe->type, 0},
        {"elements of a mail of EoE", eoe->elements, 0},
        {"Chn", soe->drive, 0},
        {"ChannelCount", d->mailbox.soe_channels, 0},
        {"index of a command", d->mailbox.inits[0].index, 0},
        {"sub-index of a command", d->mailbox.inits[0].subindex, 0},
        {"AssignActivate", dc->assign_activate, 0},
        {"CycleTimeSync0", d->dcs[0].cycle_sync0_ns, 0},
        {"ShiftTimeSync0", dc->shift_sync0_ns, 0},
        {"CycleTimeSync1", d->dcs[0].cycle_sync1_ns, 0},
        {"ShiftTimeSync1", dc->shift_sync1_ns, 0},
        {"factor of SYNC0", d->dcs[0].sync0_factor, 0},
        {"factor of SYNC1", d->dcs[0].sync1_factor, 0},
        {"Factor of SYNC0", dc->sync0_factor, 0},
        {"Factor of SYNC1", dc->sync1_factor, 0},
        {"ByteSize", d->eeprom_size, 0},
        {"CatNo", d->categories[0].number, 0},
        {"ProfileNo", d->profile, 0},
        {"BitSize of a type", type->bits, 0},
        {"LBound", type->first.value, 0},
        {"Elements", type->elements.value, 0},
        {"BitSize of an item", type->items[0].bits, 0},
        {"BitOffs", type->items[0].offset, 0},
        {"BitSize of an object", d->dictionary.objects[0].bits, 0},
        {"MaxSlotCount", d->slots_max, 0},
        {"increments of slots", d->slot_pdo_increment | d->slot_index_increment, 0},
        {"increments of groups", d->group_pdo_increment | d->group_index_increment, 0},
        {"MinInstances", slot->instances_min, 0},
        {"increments of a slot", slot->pdo_increment | slot->index_increment, 0},
        {"increments of its group", slot->group_pdo_increment | slot->group_index_increment, 0},
        {"SlotGroup", slot->group, 0},
        {"Alignment", d->pdo_groups[0].alignment, 0},
        {"PDOs of a group", d->pdo_groups[0].rx | d->pdo_groups[0].tx, 0},
        {"ModuleIdent", d->modules[0].ident, 0},
        {"profile of a module", d->modules[0].profile, 0},
    };
    for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; i++) {
        if (numbers[i].value != numbers[i].expected)
            fail_msg("%s: expected %" PRId64 ", got %" PRId64, numbers[i].what, numbers[i].expected, numbers[i].value);
    }
    ect_esi_close(esi);
}

static void elements_have_their_lines(void **state)
{
    ect_esi_t *esi;
    (void)state;
    const ect_esi_device_t *d = bare_device(&esi);
    const int lines[] = {d->line,
                         d->sms[0].line,
                         d->pdos[0].line,
                         d->pdos[0].entries[0].line,
                         d->mailbox.mails[0].line,
                         d->mailbox.inits[0].line,
                         d->mailbox.mails[1].line,
                         d->categories[0].line,
                         d->dictionary.types[0].items[0].line,
                         d->dictionary.objects[0].line,
                         d->modules[0].line};
    for (size_t i = 0; i < sizeof lines / sizeof lines[0]; i++)
        assert_int_equal(lines[i], i + 2);
    ect_esi_close(esi);
}

/* --- attributes of slots ------------------------------------------------------------------------------------------ */

static void a_slot_has_the_increments_of_all_slots_or_its_own(void **state)
{
    static const struct {
        const char *slot;
        uint32_t pdo, index, group_pdo, group_index;
        bool own;
    } rows[] = {
        {"<Slot/>", 1, 2, 3, 4, false},
        {"<Slot SlotPdoIncrement='5'/>", 5, 2, 3, 4, true},
        {"<Slot SlotIndexIncrement='6'/>", 1, 6, 3, 4, true},
        {"<Slot SlotGroupPdoIncrement='7'/>", 1, 2, 7, 4, false},
        {"<Slot SlotGroupIndexIncrement='8'/>", 1, 2, 3, 8, false},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char text[900], why[400] = "";
        (void)snprintf(text, sizeof text,
                       ESI_DEVICE("<Slots SlotPdoIncrement='1' SlotIndexIncrement='2' SlotGroupPdoIncrement='3' "
                                  "SlotGroupIndexIncrement='4'>%s</Slots>"),
                       rows[i].slot);
        ect_esi_t *esi = ect_esi_parse("t.xml", text, strlen(text), why, sizeof why);
        const ect_esi_device_t *d = esi != NULL ? ect_esi_select(esi, "", why, sizeof why) : NULL;
        if (d == NULL)
            fail_msg("%s: %s", rows[i].slot, why);
        const ect_esi_slot_t *slot = &d->slots[0];
        if (slot->pdo_increment != rows[i].pdo || slot->index_increment != rows[i].index ||
            slot->group_pdo_increment != rows[i].group_pdo || slot->group_index_increment != rows[i].group_index ||
            slot->own_increments != rows[i].own)
            fail_msg("%s: got %u, %u, %u, %u, own: %d", rows[i].slot, (unsigned int)slot->pdo_increment,
                     (unsigned int)slot->index_increment, (unsigned int)slot->group_pdo_increment,
                     (unsigned int)slot->group_index_increment, slot->own_increments);
        ect_esi_close(esi);
    }
}

/* An alignment beyond 16 bytes is none that modules have. */
static void a_group_of_pdos_has_an_alignment_of_1_to_16_bytes_or_none(void **state)
{
    static const struct {
        const char *alignment;
        uint8_t bytes;
    } rows[] = {{"-1", 0}, {"0", 0}, {"1", 1}, {"2", 2}, {"16", 16}, {"17", 0}, {"256", 0}, {"257", 0}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char text[900], why[400] = "";
        (void)snprintf(text, sizeof text, ESI_DEVICE("<Slots><ModulePdoGroup Alignment='%s'/></Slots>"),
                       rows[i].alignment);
        ect_esi_t *esi = ect_esi_parse("t.xml", text, strlen(text), why, sizeof why);
        const ect_esi_device_t *d = esi != NULL ? ect_esi_select(esi, "", why, sizeof why) : NULL;
        if (d == NULL)
            fail_msg("%s: %s", rows[i].alignment, why);
        assert_int_equal(d->pdo_groups[0].alignment, rows[i].bytes);
        ect_esi_close(esi);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"each number has a range, both ends included; one beyond is refused", each_number_has_a_range, NULL, NULL,
         NULL},
        {"an absent number is 0, but for OSFac, MaxInstances, elements of SoE, SubIdx and Sm of a PDO",
         a_number_that_is_absent_is_0_but_for_some, NULL, NULL, NULL},
        {"elements have their lines", elements_have_their_lines, NULL, NULL, NULL},
        {"a slot has the increments of all slots, or its own", a_slot_has_the_increments_of_all_slots_or_its_own, NULL,
         NULL, NULL},
        {"a group of PDOs has an alignment of 1 to 16 bytes, or none",
         a_group_of_pdos_has_an_alignment_of_1_to_16_bytes_or_none, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
