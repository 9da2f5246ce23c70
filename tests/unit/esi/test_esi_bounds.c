/* SPDX-License-Identifier: MIT */
/* Each number of a file at both of its bounds and one beyond, and the default of each number that is absent. */
#include <inttypes.h>

#include "from_text.h"

typedef int64_t (*get_t)(const ect_esi_device_t *d);

#define GET(name, member)                                                                                              \
    static int64_t name(const ect_esi_device_t *d)                                                                     \
    {                                                                                                                  \
        return (int64_t)(d->member);                                                                                   \
    }

GET(vendor, vendor_id)
GET(product, product_code)
GET(revision, revision)
GET(profile, profile)
GET(upper_profile, profile >> 16)
GET(preop, preop_ms)
GET(safeop_op, safeop_op_ms)
GET(to_init, back_to_init_ms)
GET(to_safeop, back_to_safeop_ms)
GET(request, request_ms)
GET(response, response_ms)
GET(ebus, ebus_current_ma)
GET(eeprom_size, eeprom_size)
GET(ado_given, identification_ado.given)
GET(ado, identification_ado.value)
GET(by_status, identification_134)
GET(lrd_lwr, lrd_lwr)
GET(pdo_index, pdos[0].index)
GET(pdo_sm, pdos[0].sm)
GET(pdo_samples, pdos[0].samples)
GET(pdo_excluded, pdos[0].exclude[0].index)
GET(entry_index, pdos[0].entries[0].index)
GET(entry_subindex, pdos[0].entries[0].subindex)
GET(entry_bits, pdos[0].entries[0].bits)
GET(sm_start, sms[0].start)
GET(sm_control, sms[0].control)
GET(sm_size, sms[0].size.value)
GET(sm_size_given, sms[0].size.given)
GET(sm_minimum, sms[0].minimum)
GET(sm_maximum, sms[0].maximum)
GET(sm_flags, sms[0].flags)
GET(sm_bits, sms[0].flags * 256 + d->sms[0].virtual_sm)
GET(init_index, mailbox.inits[0].index)
GET(init_subindex, mailbox.inits[0].subindex)
GET(init_adapts, mailbox.inits[0].adapts)
GET(channels, mailbox.soe_channels)
GET(coe_flags, mailbox.sdo_info * 10000 + d->mailbox.pdo_assign * 1000 + d->mailbox.pdo_config * 100 +
                   d->mailbox.pdo_upload * 10 + d->mailbox.complete_access)
GET(protocols, mailbox.given * 1000000 + d->mailbox.aoe * 100000 + d->mailbox.eoe * 10000 + d->mailbox.coe * 1000 +
                   d->mailbox.foe * 100 + d->mailbox.soe * 10 + d->mailbox.voe)
GET(link_layer, mailbox.data_link_layer)
GET(alternative_sm, alternatives[0].sm)
GET(alternative_pdo, alternatives[0].pdos[0])
GET(alternative_preset, alternatives[0].preset)
GET(activate, dcs[0].assign_activate)
GET(cycle0, dcs[0].cycle_sync0_ns)
GET(shift0, dcs[0].shift_sync0_ns)
GET(cycle1, dcs[0].cycle_sync1_ns)
GET(shift1, dcs[0].shift_sync1_ns)
GET(factor0, dcs[0].sync0_factor)
GET(factor1, dcs[0].sync1_factor)
GET(category, categories[0].number)
GET(category_length, categories[0].data.length)
GET(slots_max, slots_max)
GET(slots_pdo, slot_pdo_increment)
GET(slots_index, slot_index_increment)
GET(slot_pdo, slots[0].pdo_increment)
GET(slot_index, slots[0].index_increment)
GET(slot_own, slots[0].own_increments)
GET(slot_min, slots[0].instances_min)
GET(slot_max, slots[0].instances_max)
GET(slot_ident, slots[0].idents[0])
GET(slot_preset, slots[0].preset)
GET(modules_read, module_count)
GET(module_ident, modules[0].ident)
GET(object_index, dictionary.objects[0].index)
GET(object_bits, dictionary.objects[0].bits)
GET(type_bits, dictionary.types[0].bits)
GET(type_first, dictionary.types[0].first.value)
GET(type_elements, dictionary.types[0].elements.value)
GET(item_subindex, dictionary.types[0].items[0].subindex)
GET(item_bits, dictionary.types[0].items[0].bits)
GET(item_offset, dictionary.types[0].items[0].offset)
GET(lowest, dictionary.types[0].lowest)
GET(highest, dictionary.types[0].highest)

#define ENTRY(rest)     "<TxPdo><Index>#x1A00</Index><Entry>" rest "</Entry></TxPdo>"
#define INIT(rest)      "<Mailbox><CoE><InitCmd>" rest "</InitCmd></CoE></Mailbox>"
#define STATES(rest)    "<Info><StateMachine><Timeout>" rest "</Timeout></StateMachine></Info>"
#define MAIL(rest)      "<Info><Mailbox><Timeout>" rest "</Timeout></Mailbox></Info>"
#define MAPPING(rest)   "<Info><VendorSpecific><TwinCAT>" rest "</TwinCAT></VendorSpecific></Info>"
#define MODE(rest)      "<Dc><OpMode>" rest "</OpMode></Dc>"
#define SLOT(attribute) "<Slots><Slot " attribute "/></Slots>"
#define TYPE(rest)      "<Profile><Dictionary><DataTypes><DataType>" rest "</DataType></DataTypes></Dictionary></Profile>"
#define OBJECT(rest)    "<Profile><Dictionary><Objects><Object>" rest "</Object></Objects></Dictionary></Profile>"
#define TYPED(code, revision)                                                                                          \
    ESI_HEAD "<Device><Type ProductCode='" code "' RevisionNo='" revision "'>D</Type></Device>" ESI_TAIL

/* One number of a file; `@` is its place in the text. */
typedef struct bound {
    const char *name, *text;
    int64_t lowest, highest;
    get_t get;
} bound_t;

static const bound_t bounds[] = {
    {"Id",
     "<EtherCATInfo><Vendor><Id>@</Id></Vendor><Descriptions><Devices><Device><Type>D</Type></Device></Devices>"
     "</Descriptions></EtherCATInfo>",
     INT32_MIN, UINT32_MAX, NULL},
    {"ProductCode", TYPED("@", "1"), 0, UINT32_MAX, product},
    {"RevisionNo", TYPED("1", "@"), 0, UINT32_MAX, revision},
    {"ProfileNo", ESI_DEVICE("<Profile><ProfileNo>@</ProfileNo></Profile>"), 0, UINT16_MAX, profile},
    {"AddInfo", ESI_DEVICE("<Profile><AddInfo>@</AddInfo></Profile>"), 0, UINT16_MAX, upper_profile},
    {"PreopTimeout", ESI_DEVICE(STATES("<PreopTimeout>@</PreopTimeout>")), 0, UINT32_MAX, preop},
    {"SafeopOpTimeout", ESI_DEVICE(STATES("<SafeopOpTimeout>@</SafeopOpTimeout>")), 0, UINT32_MAX, safeop_op},
    {"BackToInitTimeout", ESI_DEVICE(STATES("<BackToInitTimeout>@</BackToInitTimeout>")), 0, UINT32_MAX, to_init},
    {"BackToSafeopTimeout", ESI_DEVICE(STATES("<BackToSafeopTimeout>@</BackToSafeopTimeout>")), 0, UINT32_MAX,
     to_safeop},
    {"RequestTimeout", ESI_DEVICE(MAIL("<RequestTimeout>@</RequestTimeout>")), 0, UINT32_MAX, request},
    {"ResponseTimeout", ESI_DEVICE(MAIL("<ResponseTimeout>@</ResponseTimeout>")), 0, UINT32_MAX, response},
    {"EBusCurrent", ESI_DEVICE("<Info><Electrical><EBusCurrent>@</EBusCurrent></Electrical></Info>"), INT16_MIN,
     INT16_MAX, ebus},
    {"ByteSize", ESI_DEVICE("<Eeprom><ByteSize>@</ByteSize></Eeprom>"), 0, 4194304, eeprom_size},
    {"CatNo", ESI_DEVICE("<Eeprom><Category><CatNo>@</CatNo></Category></Eeprom>"), 0, UINT16_MAX, category},
    {"DataUINT", ESI_DEVICE("<Eeprom><Category><DataUINT>@</DataUINT></Category></Eeprom>"), INT32_MIN, UINT32_MAX,
     NULL},
    {"Index", ESI_DEVICE("<RxPdo><Index>@</Index></RxPdo>"), 0, UINT16_MAX, pdo_index},
    {"Sm", ESI_DEVICE("<RxPdo Sm='@'><Index>1</Index></RxPdo>"), 0, UINT8_MAX, pdo_sm},
    {"OSFac", ESI_DEVICE("<RxPdo OSFac='@'><Index>1</Index></RxPdo>"), 1, UINT16_MAX, pdo_samples},
    {"Exclude", ESI_DEVICE("<RxPdo><Index>1</Index><Exclude>@</Exclude></RxPdo>"), 0, UINT16_MAX, pdo_excluded},
    {"Index", ESI_DEVICE(ENTRY("<Index>@</Index><BitLen>1</BitLen>")), 0, UINT16_MAX, entry_index},
    {"SubIndex", ESI_DEVICE(ENTRY("<Index>1</Index><SubIndex>@</SubIndex><BitLen>1</BitLen>")), 0, UINT8_MAX,
     entry_subindex},
    {"BitLen", ESI_DEVICE(ENTRY("<Index>1</Index><BitLen>@</BitLen>")), 0, UINT16_MAX, entry_bits},
    {"StartAddress", ESI_DEVICE("<Sm StartAddress='@'/>"), 0, UINT16_MAX, sm_start},
    {"ControlByte", ESI_DEVICE("<Sm ControlByte='@'/>"), 0, UINT8_MAX, sm_control},
    {"DefaultSize", ESI_DEVICE("<Sm DefaultSize='@'/>"), 0, UINT16_MAX, sm_size},
    {"MinSize", ESI_DEVICE("<Sm MinSize='@'/>"), 0, UINT16_MAX, sm_minimum},
    {"MaxSize", ESI_DEVICE("<Sm MaxSize='@'/>"), 0, UINT16_MAX, sm_maximum},
    {"Enable", ESI_DEVICE("<Sm Enable='@'/>"), 0, UINT8_MAX, NULL},
    {"Index", ESI_DEVICE(INIT("<Index>@</Index>")), 0, UINT16_MAX, init_index},
    {"SubIndex", ESI_DEVICE(INIT("<SubIndex>@</SubIndex>")), 0, UINT8_MAX, init_subindex},
    {"ChannelCount", ESI_DEVICE("<Mailbox><SoE ChannelCount='@'/></Mailbox>"), 0, UINT8_MAX, channels},
    {"No", ESI_DEVICE(MAPPING("<AlternativeSmMapping><Sm No='@'/></AlternativeSmMapping>")), 0, UINT8_MAX,
     alternative_sm},
    {"Pdo", ESI_DEVICE(MAPPING("<AlternativeSmMapping><Sm No='2'><Pdo>@</Pdo></Sm></AlternativeSmMapping>")), 0,
     UINT16_MAX, alternative_pdo},
    {"AssignActivate", ESI_DEVICE(MODE("<AssignActivate>@</AssignActivate>")), 0, UINT16_MAX, activate},
    {"CycleTimeSync0", ESI_DEVICE(MODE("<CycleTimeSync0>@</CycleTimeSync0>")), INT32_MIN, UINT32_MAX, cycle0},
    {"ShiftTimeSync0", ESI_DEVICE(MODE("<ShiftTimeSync0>@</ShiftTimeSync0>")), INT32_MIN, UINT32_MAX, shift0},
    {"CycleTimeSync1", ESI_DEVICE(MODE("<CycleTimeSync1>@</CycleTimeSync1>")), INT32_MIN, UINT32_MAX, cycle1},
    {"ShiftTimeSync1", ESI_DEVICE(MODE("<ShiftTimeSync1>@</ShiftTimeSync1>")), INT32_MIN, UINT32_MAX, shift1},
    {"Factor", ESI_DEVICE(MODE("<CycleTimeSync0 Factor='@'>1</CycleTimeSync0>")), INT16_MIN, INT16_MAX, factor0},
    {"Factor", ESI_DEVICE(MODE("<CycleTimeSync1 Factor='@'>1</CycleTimeSync1>")), INT16_MIN, INT16_MAX, factor1},
    {"MaxSlotCount", ESI_DEVICE("<Slots MaxSlotCount='@'/>"), 0, UINT16_MAX, slots_max},
    {"SlotPdoIncrement", ESI_DEVICE("<Slots SlotPdoIncrement='@'/>"), 0, UINT16_MAX, slots_pdo},
    {"SlotIndexIncrement", ESI_DEVICE("<Slots SlotIndexIncrement='@'/>"), 0, UINT16_MAX, slots_index},
    {"SlotPdoIncrement", ESI_DEVICE(SLOT("SlotPdoIncrement='@'")), 0, UINT16_MAX, slot_pdo},
    {"SlotIndexIncrement", ESI_DEVICE(SLOT("SlotIndexIncrement='@'")), 0, UINT16_MAX, slot_index},
    {"MinInstances", ESI_DEVICE(SLOT("MinInstances='@'")), 0, UINT16_MAX, slot_min},
    {"MaxInstances", ESI_DEVICE(SLOT("MaxInstances='@'")), 0, UINT16_MAX, slot_max},
    {"ModuleIdent", ESI_DEVICE("<Slots><Slot><ModuleIdent>@</ModuleIdent></Slot></Slots>"), 0, UINT32_MAX, slot_ident},
    {"Index", ESI_DEVICE(OBJECT("<Index>@</Index>")), 0, UINT16_MAX, object_index},
    {"BitSize", ESI_DEVICE(OBJECT("<Index>1</Index><BitSize>@</BitSize>")), 0, UINT32_MAX, object_bits},
    {"BitSize", ESI_DEVICE(TYPE("<BitSize>@</BitSize>")), 0, UINT32_MAX, type_bits},
    {"LBound", ESI_DEVICE(TYPE("<ArrayInfo><LBound>@</LBound></ArrayInfo>")), 0, UINT16_MAX, type_first},
    {"Elements", ESI_DEVICE(TYPE("<ArrayInfo><Elements>@</Elements></ArrayInfo>")), 0, UINT16_MAX, type_elements},
    {"SubIdx", ESI_DEVICE(TYPE("<SubItem><SubIdx>@</SubIdx></SubItem>")), 0, UINT8_MAX, item_subindex},
    {"BitSize", ESI_DEVICE(TYPE("<SubItem><BitSize>@</BitSize></SubItem>")), 0, UINT32_MAX, item_bits},
    {"BitOffs", ESI_DEVICE(TYPE("<SubItem><BitOffs>@</BitOffs></SubItem>")), 0, UINT32_MAX, item_offset},
};

/* The text with `value` in place of the number. */
static void fill(char *filled, size_t room, const char *text, int64_t value)
{
    const char *place = strchr(text, '@');
    assert_non_null(place);
    (void)snprintf(filled, room, "%.*s%" PRId64 "%s", (int)(place - text), text, value, place + 1);
}

static void try_number(const bound_t *b, int64_t value, bool good)
{
    char filled[1000], expected[200], why[300] = "";
    fill(filled, sizeof filled, b->text, value);
    (void)snprintf(expected, sizeof expected, "%s is %" PRId64 ", not %" PRId64 " to %" PRId64, b->name, value,
                   b->lowest, b->highest);
    ect_esi_t *esi = ect_esi_parse("t.xml", filled, strlen(filled), why, sizeof why);
    const ect_esi_device_t *d = esi != NULL ? ect_esi_select(esi, "", why, sizeof why) : NULL;
    if (good && d == NULL)
        fail_msg("%s: %s: expected %" PRId64 ", got \"%s\"", b->name, b->text, value, why);
    if (good && b->get != NULL && b->get(d) != value)
        fail_msg("%s: %s: expected %" PRId64 ", got %" PRId64, b->name, b->text, value, b->get(d));
    if (!good && strstr(why, expected) == NULL)
        fail_msg("%s: expected \"%s\", got \"%s\"", b->text, expected, why);
    ect_esi_close(esi);
}

static void accepted_bounds(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof bounds / sizeof bounds[0]; i++) {
        try_number(&bounds[i], bounds[i].lowest, true);
        try_number(&bounds[i], bounds[i].highest, true);
    }
}

static void refused_beyond(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof bounds / sizeof bounds[0]; i++) {
        try_number(&bounds[i], bounds[i].lowest - 1, false);
        try_number(&bounds[i], bounds[i].highest + 1, false);
    }
}

/* One value of the model of each text. */
typedef struct reading {
    const char *what, *text;
    int64_t expected;
    get_t get;
} reading_t;

static void expect_readings(const reading_t *table, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        char why[300] = "";
        ect_esi_t *esi = ect_esi_parse("t.xml", table[i].text, strlen(table[i].text), why, sizeof why);
        const ect_esi_device_t *d = esi != NULL ? ect_esi_select(esi, "", why, sizeof why) : NULL;
        if (d == NULL)
            fail_msg("%s: expected a device, got \"%s\"", table[i].what, why);
        if (table[i].get(d) != table[i].expected)
            fail_msg("%s: expected %" PRId64 ", got %" PRId64, table[i].what, table[i].expected, table[i].get(d));
        ect_esi_close(esi);
    }
}

static void absent(void **state)
{
#define ANY_PDO      ESI_DEVICE("<TxPdo><Index>1</Index><Entry><Index>2</Index><BitLen>1</BitLen></Entry></TxPdo>")
#define ANY_SM       ESI_DEVICE("<Sm/>")
#define ANY_MODE     ESI_DEVICE(MODE("<CycleTimeSync0>1</CycleTimeSync0><CycleTimeSync1>1</CycleTimeSync1>"))
#define ANY_SLOT     ESI_DEVICE(SLOT(""))
#define ANY_ITEM     ESI_DEVICE(TYPE("<SubItem/>"))
#define ANY_CATEGORY ESI_DEVICE("<Eeprom><Category/></Eeprom>")
    static const reading_t table[] = {
        {"ProductCode", ESI_HEAD "<Device><Type>D</Type></Device>" ESI_TAIL, 0, product},
        {"RevisionNo", ESI_HEAD "<Device><Type>D</Type></Device>" ESI_TAIL, 0, revision},
        {"UseLrdLwr", ESI_DEVICE(""), 0, lrd_lwr},
        {"ProfileNo", ESI_DEVICE("<Profile/>"), 0, profile},
        {"PreopTimeout", ESI_DEVICE(STATES("")), 0, preop},
        {"SafeopOpTimeout", ESI_DEVICE(STATES("")), 0, safeop_op},
        {"BackToInitTimeout", ESI_DEVICE(STATES("")), 0, to_init},
        {"BackToSafeopTimeout", ESI_DEVICE(STATES("")), 0, to_safeop},
        {"RequestTimeout", ESI_DEVICE(MAIL("")), 0, request},
        {"ResponseTimeout", ESI_DEVICE(MAIL("")), 0, response},
        {"EBusCurrent", ESI_DEVICE("<Info/>"), 0, ebus},
        {"IdentificationAdo", ESI_DEVICE("<Info/>"), 0, ado_given},
        {"IdentificationReg134", ESI_DEVICE("<Info/>"), 0, by_status},
        {"ByteSize", ESI_DEVICE("<Eeprom/>"), 0, eeprom_size},
        {"CatNo", ANY_CATEGORY, 0, category},
        {"data of a category", ANY_CATEGORY, 0, category_length},
        {"Sm of a PDO", ANY_PDO, -1, pdo_sm},
        {"OSFac", ANY_PDO, 1, pdo_samples},
        {"SubIndex of an entry", ANY_PDO, 0, entry_subindex},
        {"StartAddress", ANY_SM, 0, sm_start},
        {"ControlByte", ANY_SM, 0, sm_control},
        {"DefaultSize", ANY_SM, 0, sm_size_given},
        {"size by default", ANY_SM, 0, sm_size},
        {"MinSize", ANY_SM, 0, sm_minimum},
        {"MaxSize", ANY_SM, 0, sm_maximum},
        {"bits of Enable", ANY_SM, 0, sm_bits},
        {"Index of a start-up command", ESI_DEVICE(INIT("")), 0, init_index},
        {"SubIndex of a start-up command", ESI_DEVICE(INIT("")), 0, init_subindex},
        {"AdaptAutomatically", ESI_DEVICE(INIT("<Data>00</Data>")), 0, init_adapts},
        {"attributes of CoE", ESI_DEVICE("<Mailbox><CoE/></Mailbox>"), 0, coe_flags},
        {"ChannelCount", ESI_DEVICE("<Mailbox><SoE/></Mailbox>"), 0, channels},
        {"Mailbox", ESI_DEVICE(""), 0, protocols},
        {"DataLinkLayer", ESI_DEVICE("<Mailbox/>"), 0, link_layer},
        {"No of a SyncManager", ESI_DEVICE(MAPPING("<AlternativeSmMapping><Sm/></AlternativeSmMapping>")), 0,
         alternative_sm},
        {"Default of an alternative", ESI_DEVICE(MAPPING("<AlternativeSmMapping><Sm/></AlternativeSmMapping>")), 0,
         alternative_preset},
        {"AssignActivate", ANY_MODE, 0, activate},
        {"CycleTimeSync0", ESI_DEVICE(MODE("")), 0, cycle0},
        {"CycleTimeSync1", ESI_DEVICE(MODE("")), 0, cycle1},
        {"ShiftTimeSync0", ANY_MODE, 0, shift0},
        {"ShiftTimeSync1", ANY_MODE, 0, shift1},
        {"Factor of SYNC0", ANY_MODE, 0, factor0},
        {"Factor of SYNC1", ANY_MODE, 0, factor1},
        {"Factor of no SYNC0", ESI_DEVICE(MODE("")), 0, factor0},
        {"MaxSlotCount", ANY_SLOT, 0, slots_max},
        {"SlotPdoIncrement", ANY_SLOT, 0, slots_pdo},
        {"SlotIndexIncrement", ANY_SLOT, 0, slots_index},
        {"MinInstances", ANY_SLOT, 0, slot_min},
        {"MaxInstances", ANY_SLOT, 1, slot_max},
        {"increments of a slot", ANY_SLOT, 0, slot_own},
        {"ModuleIdent of a module",
         ESI_HEAD "<Device><Type>D</Type><Slots><Slot/></Slots></Device></Devices><Modules><Module><Type/></Module>"
                  "</Modules></Descriptions></EtherCATInfo>",
         0, module_ident},
        {"BitSize of an object", ESI_DEVICE(OBJECT("<Index>1</Index>")), 0, object_bits},
        {"BitSize of a type", ANY_ITEM, 0, type_bits},
        {"LBound", ESI_DEVICE(TYPE("<ArrayInfo/>")), 0, type_first},
        {"Elements", ESI_DEVICE(TYPE("<ArrayInfo/>")), 0, type_elements},
        {"SubIdx", ANY_ITEM, -1, item_subindex},
        {"BitSize of a sub-item", ANY_ITEM, 0, item_bits},
        {"BitOffs", ANY_ITEM, 0, item_offset},
        {"Enum", ESI_DEVICE(TYPE("<EnumInfo/>")), 0, lowest},
    };
    (void)state;
    expect_readings(table, sizeof table / sizeof table[0]);
}

static void conditions(void **state)
{
#define SLOTS_OF(attributes)                                                                                           \
    ESI_DEVICE("<Slots SlotPdoIncrement='3' SlotIndexIncrement='5'><Slot " attributes "/></Slots>")
#define ENUM(a, b, c)                                                                                                  \
    ESI_DEVICE(TYPE("<EnumInfo><Enum>" a "</Enum></EnumInfo><EnumInfo><Enum>" b "</Enum></EnumInfo><EnumInfo><Enum>" c \
                    "</Enum></EnumInfo>"))
#define DATA(rest) ESI_DEVICE("<Eeprom><Category>" rest "</Category></Eeprom>")
    static const reading_t table[] = {
        {"Id of the head", ESI_DEVICE(""), 0xE57, vendor},
        {"UseLrdLwr", ESI_HEAD "<Device><Type UseLrdLwr='1'>D</Type></Device>" ESI_TAIL, 1, lrd_lwr},
        {"profile with AddInfo", ESI_DEVICE("<Profile><ProfileNo>5001</ProfileNo><AddInfo>3</AddInfo></Profile>"),
         0x31389, profile},
        {"the first profile of two",
         ESI_DEVICE("<Profile><ProfileNo>402</ProfileNo></Profile><Profile><ProfileNo>403</ProfileNo></Profile>"), 402,
         profile},
        {"the second profile where the first has no number",
         ESI_DEVICE("<Profile/><Profile><ProfileNo>403</ProfileNo></Profile>"), 403, profile},
        {"IdentificationReg134 1", ESI_DEVICE("<Info><IdentificationReg134>1</IdentificationReg134></Info>"), 1,
         by_status},
        {"IdentificationReg134 true", ESI_DEVICE("<Info><IdentificationReg134>true</IdentificationReg134></Info>"), 1,
         by_status},
        {"IdentificationReg134 0", ESI_DEVICE("<Info><IdentificationReg134>0</IdentificationReg134></Info>"), 0,
         by_status},
        {"IdentificationAdo 0 is given", ESI_DEVICE("<Info><IdentificationAdo>0</IdentificationAdo></Info>"), 1,
         ado_given},
        {"IdentificationAdo 18", ESI_DEVICE("<Info><IdentificationAdo>18</IdentificationAdo></Info>"), 18, ado},
        {"DefaultSize 0 is given", ESI_DEVICE("<Sm DefaultSize='0'/>"), 1, sm_size_given},
        {"Enable 255 has bits 1 to 3", ESI_DEVICE("<Sm Enable='255'/>"), 14, sm_flags},
        {"Enable 4 is virtual", ESI_DEVICE("<Sm Enable='4'/>"), 0x401, sm_bits},
        {"Enable 8 is for OP only", ESI_DEVICE("<Sm Enable='8'/>"), 0x800, sm_bits},
        {"OpOnly", ESI_DEVICE("<Sm OpOnly='1'/>"), 0x800, sm_bits},
        {"Virtual", ESI_DEVICE("<Sm Virtual='true'/>"), 0x401, sm_bits},
        {"SdoInfo", ESI_DEVICE("<Mailbox><CoE SdoInfo='1'/></Mailbox>"), 10000, coe_flags},
        {"PdoAssign", ESI_DEVICE("<Mailbox><CoE PdoAssign='1'/></Mailbox>"), 1000, coe_flags},
        {"PdoConfig", ESI_DEVICE("<Mailbox><CoE PdoConfig='1'/></Mailbox>"), 100, coe_flags},
        {"PdoUpload", ESI_DEVICE("<Mailbox><CoE PdoUpload='1'/></Mailbox>"), 10, coe_flags},
        {"CompleteAccess", ESI_DEVICE("<Mailbox><CoE CompleteAccess='1'/></Mailbox>"), 1, coe_flags},
        {"an empty Mailbox", ESI_DEVICE("<Mailbox/>"), 1000000, protocols},
        {"AoE", ESI_DEVICE("<Mailbox><AoE/></Mailbox>"), 1100000, protocols},
        {"EoE", ESI_DEVICE("<Mailbox><EoE/></Mailbox>"), 1010000, protocols},
        {"CoE", ESI_DEVICE("<Mailbox><CoE/></Mailbox>"), 1001000, protocols},
        {"FoE", ESI_DEVICE("<Mailbox><FoE/></Mailbox>"), 1000100, protocols},
        {"SoE", ESI_DEVICE("<Mailbox><SoE/></Mailbox>"), 1000010, protocols},
        {"VoE", ESI_DEVICE("<Mailbox><VoE/></Mailbox>"), 1000001, protocols},
        {"DataLinkLayer", ESI_DEVICE("<Mailbox DataLinkLayer='1'/>"), 1, link_layer},
        {"AdaptAutomatically", ESI_DEVICE(INIT("<Data AdaptAutomatically='1'>00</Data>")), 1, init_adapts},
        {"PDO increment of all slots", SLOTS_OF(""), 3, slot_pdo},
        {"index increment of all slots", SLOTS_OF(""), 5, slot_index},
        {"increments of all slots are not the slot's", SLOTS_OF(""), 0, slot_own},
        {"an own PDO increment", SLOTS_OF("SlotPdoIncrement='3'"), 1, slot_own},
        {"an own index increment", SLOTS_OF("SlotIndexIncrement='5'"), 1, slot_own},
        {"the preset among the modules of a slot",
         ESI_DEVICE("<Slots><Slot><ModuleIdent>7</ModuleIdent><ModuleIdent Default='1'>8</ModuleIdent>"
                    "<ModuleIdent>9</ModuleIdent></Slot></Slots>"),
         8, slot_preset},
        {"no preset", ESI_DEVICE("<Slots><Slot><ModuleIdent>7</ModuleIdent></Slot></Slots>"), 0, slot_preset},
        {"modules without slots",
         ESI_HEAD "<Device><Type>D</Type></Device></Devices><Modules><Module><Type/></Module>"
                  "</Modules></Descriptions></EtherCATInfo>",
         0, modules_read},
        {"modules with a type, and a slot",
         ESI_HEAD "<Device><Type>D</Type><Slots><Slot/></Slots></Device></Devices><Modules><Module><Type/></Module>"
                  "<Module/></Modules></Descriptions></EtherCATInfo>",
         1, modules_read},
        {"the lowest of an enumeration", ENUM("5", "-3", "7"), -3, lowest},
        {"the highest of an enumeration", ENUM("5", "-3", "7"), 7, highest},
        {"the lowest above 0", ENUM("5", "6", "7"), 5, lowest},
        {"the highest below 0", ENUM("-7", "-6", "-5"), -5, highest},
        {"DataUINT", DATA("<DataUINT>1</DataUINT>"), 2, category_length},
        {"DataUDINT", DATA("<DataUDINT>1</DataUDINT>"), 4, category_length},
        {"DataString", DATA("<DataString>five.</DataString>"), 5, category_length},
        {"Data", DATA("<Data>010203</Data>"), 3, category_length},
    };
    (void)state;
    expect_readings(table, sizeof table / sizeof table[0]);
}

static void category_bytes(void **state)
{
    static const struct {
        const char *what, *text;
        uint8_t bytes[4];
        size_t length;
    } table[] = {
        {"DataUINT is little-endian", DATA("<DataUINT>#x0102</DataUINT>"), {2, 1}, 2},
        {"DataUDINT is little-endian", DATA("<DataUDINT>#x01020304</DataUDINT>"), {4, 3, 2, 1}, 4},
        {"DataUDINT has a sign", DATA("<DataUDINT>-2</DataUDINT>"), {0xFE, 0xFF, 0xFF, 0xFF}, 4},
        {"DataString comes before DataUINT", DATA("<DataUINT>1</DataUINT><DataString>ab</DataString>"), {'a', 'b'}, 2},
        {"DataUINT comes before DataUDINT", DATA("<DataUDINT>1</DataUDINT><DataUINT>2</DataUINT>"), {2, 0}, 2},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        char why[300] = "";
        ect_esi_t *esi = ect_esi_parse("t.xml", table[i].text, strlen(table[i].text), why, sizeof why);
        const ect_esi_device_t *d = esi != NULL ? ect_esi_select(esi, "", why, sizeof why) : NULL;
        if (d == NULL)
            fail_msg("%s: expected a device, got \"%s\"", table[i].what, why);
        const ect_esi_bytes_t *data = &d->categories[0].data;
        if (data->length != table[i].length || memcmp(data->bytes, table[i].bytes, data->length) != 0)
            fail_msg("%s: expected %zu bytes from %02X, got %zu from %02X", table[i].what, table[i].length,
                     table[i].bytes[0], data->length, data->bytes[0]);
        ect_esi_close(esi);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"each number is read at its lowest and its highest value", accepted_bounds, NULL, NULL, NULL},
        {"each number below its lowest or above its highest value is refused", refused_beyond, NULL, NULL, NULL},
        {"each number that is absent has its default", absent, NULL, NULL, NULL},
        {"flags, presets and increments follow the element that has them", conditions, NULL, NULL, NULL},
        {"data of a category is text, 2 bytes, 4 bytes or hexadecimal", category_bytes, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
