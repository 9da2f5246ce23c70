/* SPDX-License-Identifier: MIT */
/* Each element and attribute of a file in the model of its device; each member of a description in a file. */
#define _POSIX_C_SOURCE 200809L
#include "esi/values.h"
#include "esi/write.h"
#include "from_text.h"
#include "od/pdo.h"
#include "seams/standard.h"

/* A number of the model, by the function that finds it. */
typedef int64_t (*number_of_t)(const ect_esi_device_t *m);
typedef const char *(*text_of_t)(const ect_esi_device_t *m);

#define NUMBER(name, expression)                                                                                       \
    static int64_t name(const ect_esi_device_t *m)                                                                     \
    {                                                                                                                  \
        return (int64_t)(expression);                                                                                  \
    }
#define TEXT(name, expression)                                                                                         \
    static const char *name(const ect_esi_device_t *m)                                                                 \
    {                                                                                                                  \
        return expression;                                                                                             \
    }
NUMBER(product, m->product_code)
NUMBER(revision, m->revision)
NUMBER(vendor, m->vendor_id)
NUMBER(preop, m->preop_ms)
NUMBER(safeop_op, m->safeop_op_ms)
NUMBER(to_init, m->back_to_init_ms)
NUMBER(to_safeop, m->back_to_safeop_ms)
NUMBER(request, m->request_ms)
NUMBER(response, m->response_ms)
NUMBER(ebus, m->ebus_current_ma)
NUMBER(reg134, m->identification_134)
NUMBER(ado_given, m->identification_ado.given)
NUMBER(ado, m->identification_ado.value)
NUMBER(profile, m->profile)
NUMBER(lrd_lwr, m->lrd_lwr)
NUMBER(fmmus, m->fmmu_count)
NUMBER(sms, m->sm_count)
NUMBER(sm_start, m->sms[0].start)
NUMBER(sm_control, m->sms[0].control)
NUMBER(sm_size_given, m->sms[0].size.given)
NUMBER(sm_size, m->sms[0].size.value)
NUMBER(sm_minimum, m->sms[0].minimum)
NUMBER(sm_maximum, m->sms[0].maximum)
NUMBER(sm_flags, m->sms[0].flags)
NUMBER(sm_virtual, m->sms[0].virtual_sm)
NUMBER(pdos, m->pdo_count)
NUMBER(pdo_index, m->pdos[0].index)
NUMBER(pdo_tx, m->pdos[0].tx)
NUMBER(pdo_fixed, m->pdos[0].fixed)
NUMBER(pdo_mandatory, m->pdos[0].mandatory)
NUMBER(pdo_virtual, m->pdos[0].virtual_pdo)
NUMBER(pdo_sm, m->pdos[0].sm)
NUMBER(pdo_samples, m->pdos[0].samples)
NUMBER(pdo_excludes, m->pdos[0].exclude_count)
NUMBER(pdo_exclude, m->pdos[0].exclude[1].index)
NUMBER(pdo_slot, m->pdos[0].moves)
NUMBER(entries, m->pdos[0].entry_count)
NUMBER(entry_index, m->pdos[0].entries[0].index)
NUMBER(entry_subindex, m->pdos[0].entries[0].subindex)
NUMBER(entry_bits, m->pdos[0].entries[0].bits)
NUMBER(entry_slot, m->pdos[0].entries[0].moves)
NUMBER(coe, m->mailbox.coe)
NUMBER(info, m->mailbox.sdo_info)
NUMBER(assign, m->mailbox.pdo_assign)
NUMBER(config, m->mailbox.pdo_config)
NUMBER(upload, m->mailbox.pdo_upload)
NUMBER(complete, m->mailbox.complete_access)
NUMBER(link_layer, m->mailbox.data_link_layer)
NUMBER(channels, m->mailbox.soe_channels)
NUMBER(given, m->mailbox.given)
NUMBER(inits, m->mailbox.init_count)
NUMBER(init_index, m->mailbox.inits[0].index)
NUMBER(init_subindex, m->mailbox.inits[0].subindex)
NUMBER(init_complete, m->mailbox.inits[0].complete)
NUMBER(init_length, m->mailbox.inits[0].data.length)
NUMBER(init_slot, m->mailbox.inits[0].moves)
NUMBER(modes, m->dc_count)
NUMBER(activate, m->dcs[0].assign_activate)
NUMBER(cycle0, m->dcs[0].cycle_sync0_ns)
NUMBER(shift0, m->dcs[0].shift_sync0_ns)
NUMBER(cycle1, m->dcs[0].cycle_sync1_ns)
NUMBER(shift1, m->dcs[0].shift_sync1_ns)
NUMBER(factor0, m->dcs[0].sync0_factor)
NUMBER(factor1, m->dcs[0].sync1_factor)
NUMBER(eeprom_size, m->eeprom_size)
NUMBER(eeprom_length, m->eeprom.length)
NUMBER(config_length, m->config.length)
NUMBER(boot_length, m->bootstrap.length)
NUMBER(category_number, m->categories[0].number)
NUMBER(category_length, m->categories[0].data.length)
NUMBER(category_byte, m->categories[0].data.bytes[1])
NUMBER(slots, m->slot_count)
NUMBER(slots_max, m->slots_max)
NUMBER(slot_min, m->slots[0].instances_min)
NUMBER(slot_max, m->slots[0].instances_max)
NUMBER(slot_pdo, m->slots[0].pdo_increment)
NUMBER(slot_index, m->slots[0].index_increment)
NUMBER(slot_own, m->slots[0].own_increments)
NUMBER(slot_idents, m->slots[0].ident_count)
NUMBER(slot_preset, m->slots[0].preset)
NUMBER(slot_classes, m->slots[0].class_count)
TEXT(type, m->type)
TEXT(name, m->name)
TEXT(vendor_name, m->vendor_name)
TEXT(group, m->group_type)
TEXT(group_name, m->group_name)
TEXT(physics, m->physics)
TEXT(fmmu, m->fmmus[0])
TEXT(sm_type, m->sms[0].type)
TEXT(pdo_name, m->pdos[0].name)
TEXT(entry_name, m->pdos[0].entries[0].name)
TEXT(entry_type, m->pdos[0].entries[0].type)
TEXT(transitions, m->mailbox.inits[0].transitions)
TEXT(comment, m->mailbox.inits[0].comment)
TEXT(mode, m->dcs[0].name)
TEXT(mode_text, m->dcs[0].description)
TEXT(dictionary_file, m->dictionary_file)
TEXT(slot_name, m->slots[0].name)
TEXT(slot_class, m->slots[0].classes[0])

#define D(body) ESI_DEVICE(body)
#define PDO(at)                                                                                                        \
    D("<TxPdo " at "><Index>#x1A00</Index><Name>P</Name><Exclude>1</Exclude><Exclude>#x1A02</Exclude></TxPdo>")
#define ENT(in)  D("<RxPdo><Index>#x1600</Index><Entry>" in "</Entry></RxPdo>")
#define SM(at)   D("<Sm " at ">Inputs</Sm>")
#define INIT(in) D("<Mailbox><CoE><InitCmd " in "</InitCmd></CoE></Mailbox>")
#define MODE(in) D("<Dc><OpMode>" in "</OpMode></Dc>")
#define CAT(in)  D("<Eeprom><Category><CatNo>2048</CatNo>" in "</Category></Eeprom>")
#define SLOT(at, in)                                                                                                   \
    D("<Slots MaxSlotCount='9' SlotPdoIncrement='2' SlotIndexIncrement='16'><Slot " at "><Name>S</Name>" in            \
      "</Slot></Slots>")

static void numbers(void **state)
{
    static const struct {
        const char *what, *text;
        number_of_t of;
        int64_t expected;
    } table[] = {
        {"ProductCode", D(""), product, 1},
        {"RevisionNo", D(""), revision, 2},
        {"Vendor/Id", D(""), vendor, 0xE57},
        {"UseLrdLwr", D(""), lrd_lwr, 0},
        {"PreopTimeout",
         D("<Info><StateMachine><Timeout><PreopTimeout>11</PreopTimeout></Timeout></StateMachine></Info>"), preop, 11},
        {"SafeopOpTimeout",
         D("<Info><StateMachine><Timeout><SafeopOpTimeout>12</SafeopOpTimeout></Timeout></StateMachine></Info>"),
         safeop_op, 12},
        {"BackToInitTimeout",
         D("<Info><StateMachine><Timeout><BackToInitTimeout>13</BackToInitTimeout></Timeout></StateMachine></Info>"),
         to_init, 13},
        {"BackToSafeopTimeout",
         D("<Info><StateMachine><Timeout><BackToSafeopTimeout>14</BackToSafeopTimeout></Timeout></StateMachine></"
           "Info>"),
         to_safeop, 14},
        {"RequestTimeout", D("<Info><Mailbox><Timeout><RequestTimeout>15</RequestTimeout></Timeout></Mailbox></Info>"),
         request, 15},
        {"ResponseTimeout",
         D("<Info><Mailbox><Timeout><ResponseTimeout>16</ResponseTimeout></Timeout></Mailbox></Info>"), response, 16},
        {"EBusCurrent", D("<Info><Electrical><EBusCurrent>-2000</EBusCurrent></Electrical></Info>"), ebus, -2000},
        {"IdentificationReg134 true", D("<Info><IdentificationReg134>true</IdentificationReg134></Info>"), reg134, 1},
        {"IdentificationReg134 1", D("<Info><IdentificationReg134> 1 </IdentificationReg134></Info>"), reg134, 1},
        {"IdentificationReg134 false", D("<Info><IdentificationReg134>false</IdentificationReg134></Info>"), reg134, 0},
        {"IdentificationAdo", D("<Info><IdentificationAdo>#x12</IdentificationAdo></Info>"), ado, 0x12},
        {"IdentificationAdo exists", D("<Info><IdentificationAdo>0</IdentificationAdo></Info>"), ado_given, 1},
        {"IdentificationAdo is not", D("<Info/>"), ado_given, 0},
        {"ProfileNo", D("<Profile><ProfileNo>5001</ProfileNo></Profile>"), profile, 5001},
        {"AddInfo", D("<Profile><ProfileNo>402</ProfileNo><AddInfo>2</AddInfo></Profile>"), profile, 0x20192},
        {"the first profile",
         D("<Profile><ProfileNo>1</ProfileNo></Profile><Profile><ProfileNo>2</ProfileNo></Profile>"), profile, 1},
        {"a profile without number first", D("<Profile/><Profile><ProfileNo>2</ProfileNo></Profile>"), profile, 2},
        {"Fmmu", D("<Fmmu>Inputs</Fmmu><Fmmu/>"), fmmus, 2},
        {"Sm", D("<Sm/><Sm/><Sm/><Sm/><Sm/>"), sms, 5},
        {"StartAddress", SM("StartAddress='#x1800'"), sm_start, 0x1800},
        {"ControlByte", SM("ControlByte='#x64'"), sm_control, 0x64},
        {"DefaultSize", SM("DefaultSize='12'"), sm_size, 12},
        {"DefaultSize exists", SM("DefaultSize='0'"), sm_size_given, 1},
        {"DefaultSize is not", SM(""), sm_size_given, 0},
        {"MinSize", SM("MinSize='3'"), sm_minimum, 3},
        {"MaxSize", SM("MaxSize='4'"), sm_maximum, 4},
        {"OpOnly in Enable", SM("Enable='9'"), sm_flags, 8},
        {"OpOnly", SM("OpOnly='1'"), sm_flags, 8},
        {"OpOnly 0", SM("OpOnly='0'"), sm_flags, 0},
        {"Virtual", SM("Virtual='true'"), sm_virtual, 1},
        {"Virtual in Enable", SM("Enable='5'"), sm_virtual, 1},
        {"flags", SM("Enable='#xFF'"), sm_flags, 0x0E},
        {"PDOs", D("<RxPdo><Index>1</Index></RxPdo><TxPdo><Index>2</Index></TxPdo>"), pdos, 2},
        {"outputs come first", D("<TxPdo><Index>2</Index></TxPdo><RxPdo><Index>1</Index></RxPdo>"), pdo_index, 1},
        {"TxPdo", PDO(""), pdo_tx, 1},
        {"RxPdo", D("<RxPdo><Index>1</Index></RxPdo>"), pdo_tx, 0},
        {"Fixed", PDO("Fixed='1'"), pdo_fixed, 1},
        {"Fixed 0", PDO("Fixed='0'"), pdo_fixed, 0},
        {"Mandatory", PDO("Mandatory='true'"), pdo_mandatory, 1},
        {"Virtual of a PDO", PDO("Virtual='1'"), pdo_virtual, 1},
        {"Sm of a PDO", PDO("Sm='3'"), pdo_sm, 3},
        {"Sm of none", PDO(""), pdo_sm, -1},
        {"OSFac", PDO("OSFac='10'"), pdo_samples, 10},
        {"OSFac of none", PDO(""), pdo_samples, 1},
        {"Exclude", PDO(""), pdo_excludes, 2},
        {"the second Exclude", PDO(""), pdo_exclude, 0x1A02},
        {"DependOnSlot", D("<TxPdo><Index DependOnSlot='1'>#x1A00</Index></TxPdo>"), pdo_slot, 1},
        {"Entries", ENT("<Index>#x7000</Index><BitLen>8</BitLen>"), entries, 1},
        {"Entry/Index", ENT("<Index>#x7000</Index><BitLen>8</BitLen>"), entry_index, 0x7000},
        {"Entry/SubIndex", ENT("<Index>1</Index><SubIndex>#x11</SubIndex><BitLen>8</BitLen>"), entry_subindex, 0x11},
        {"Entry/SubIndex of none", ENT("<Index>1</Index><BitLen>8</BitLen>"), entry_subindex, 0},
        {"BitLen", ENT("<Index>1</Index><BitLen>1000</BitLen>"), entry_bits, 1000},
        {"DependOnSlotGroup", D("<TxPdo><Index DependOnSlotGroup='1'>#x1A00</Index></TxPdo>"), pdo_slot, 2},
        {"Entry/DependOnSlot", ENT("<Index DependOnSlot='1'>1</Index><BitLen>8</BitLen>"), entry_slot, 1},
        {"Mailbox", D("<Mailbox/>"), given, 1},
        {"no Mailbox", D(""), given, 0},
        {"CoE", D("<Mailbox><CoE/></Mailbox>"), coe, 1},
        {"SdoInfo", D("<Mailbox><CoE SdoInfo='1'/></Mailbox>"), info, 1},
        {"PdoAssign", D("<Mailbox><CoE PdoAssign='1'/></Mailbox>"), assign, 1},
        {"PdoConfig", D("<Mailbox><CoE PdoConfig='1'/></Mailbox>"), config, 1},
        {"PdoUpload", D("<Mailbox><CoE PdoUpload='1'/></Mailbox>"), upload, 1},
        {"CompleteAccess", D("<Mailbox><CoE CompleteAccess='1'/></Mailbox>"), complete, 1},
        {"DataLinkLayer", D("<Mailbox DataLinkLayer='1'/>"), link_layer, 1},
        {"ChannelCount", D("<Mailbox><SoE ChannelCount='255'/></Mailbox>"), channels, 255},
        {"InitCmd", INIT("><Index>1</Index>"), inits, 1},
        {"InitCmd/Index", INIT("><Index>#x8000</Index>"), init_index, 0x8000},
        {"InitCmd/SubIndex", INIT("><SubIndex>9</SubIndex>"), init_subindex, 9},
        {"InitCmd/CompleteAccess", INIT("CompleteAccess='1'>"), init_complete, 1},
        {"InitCmd/Data", INIT("><Data>010203</Data>"), init_length, 3},
        {"InitCmd/DependOnSlot", INIT("><Index DependOnSlot='true'>1</Index>"), init_slot, 1},
        {"OpMode", D("<Dc><OpMode/><OpMode/></Dc>"), modes, 2},
        {"AssignActivate", MODE("<AssignActivate>#x730</AssignActivate>"), activate, 0x730},
        {"CycleTimeSync0", MODE("<CycleTimeSync0>100</CycleTimeSync0>"), cycle0, 100},
        {"ShiftTimeSync0", MODE("<ShiftTimeSync0>-9</ShiftTimeSync0>"), shift0, -9},
        {"CycleTimeSync1", MODE("<CycleTimeSync1>7</CycleTimeSync1>"), cycle1, 7},
        {"ShiftTimeSync1", MODE("<ShiftTimeSync1>8</ShiftTimeSync1>"), shift1, 8},
        {"Factor of SYNC0", MODE("<CycleTimeSync0 Factor='-10'>0</CycleTimeSync0>"), factor0, -10},
        {"Factor of SYNC1", MODE("<CycleTimeSync1 Factor='2'>0</CycleTimeSync1>"), factor1, 2},
        {"Factor of none", MODE("<CycleTimeSync1>0</CycleTimeSync1>"), factor1, 0},
        {"ByteSize", D("<Eeprom><ByteSize>4194304</ByteSize></Eeprom>"), eeprom_size, 4194304},
        {"Data", D("<Eeprom><Data>00 11\n22</Data></Eeprom>"), eeprom_length, 3},
        {"ConfigData", D("<Eeprom><ConfigData>0102</ConfigData></Eeprom>"), config_length, 2},
        {"BootStrap", D("<Eeprom><BootStrap>0010800080108000</BootStrap></Eeprom>"), boot_length, 8},
        {"CatNo", CAT("<Data>01</Data>"), category_number, 2048},
        {"Category/Data", CAT("<Data>010203</Data>"), category_length, 3},
        {"DataString", CAT("<DataString>ab</DataString>"), category_byte, 'b'},
        {"DataUINT", CAT("<DataUINT>513</DataUINT>"), category_byte, 2},
        {"DataUINT's length", CAT("<DataUINT>513</DataUINT>"), category_length, 2},
        {"DataUDINT's length", CAT("<DataUDINT>1</DataUDINT>"), category_length, 4},
        {"Slots", SLOT("", ""), slots, 1},
        {"MaxSlotCount", SLOT("", ""), slots_max, 9},
        {"MinInstances", SLOT("MinInstances='2'", ""), slot_min, 2},
        {"MaxInstances", SLOT("MaxInstances='5'", ""), slot_max, 5},
        {"MaxInstances of none", SLOT("", ""), slot_max, 1},
        {"SlotPdoIncrement of all", SLOT("", ""), slot_pdo, 2},
        {"SlotPdoIncrement of its own", SLOT("SlotPdoIncrement='3'", ""), slot_pdo, 3},
        {"SlotIndexIncrement of all", SLOT("", ""), slot_index, 16},
        {"SlotIndexIncrement of its own", SLOT("SlotIndexIncrement='32'", ""), slot_index, 32},
        {"no increment of its own", SLOT("", ""), slot_own, 0},
        {"an increment of its own", SLOT("SlotIndexIncrement='32'", ""), slot_own, 1},
        {"ModuleIdent", SLOT("", "<ModuleIdent>1</ModuleIdent><ModuleIdent>2</ModuleIdent>"), slot_idents, 2},
        {"Default", SLOT("", "<ModuleIdent>1</ModuleIdent><ModuleIdent Default='1'>2</ModuleIdent>"), slot_preset, 2},
        {"Default of none", SLOT("", "<ModuleIdent>1</ModuleIdent>"), slot_preset, 0},
        {"ModuleClass", SLOT("", "<ModuleClass><Class>A</Class></ModuleClass>"), slot_classes, 1},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = try_text(table[i].text);
        if (m.model == NULL)
            fail_msg("%s: expected a device, got: %s", table[i].what, m.why);
        int64_t got = table[i].of(m.model);
        if (got != table[i].expected)
            fail_msg("%s: expected %lld, got %lld", table[i].what, (long long)table[i].expected, (long long)got);
        free_made(&m);
    }
}

static void texts(void **state)
{
    static const struct {
        const char *what, *text;
        text_of_t of;
        const char *expected;
    } table[] = {
        {"Type", D(""), type, "DEV"},
        {"Name", D(""), name, "A device"},
        {"Vendor/Name", D(""), vendor_name, "Works"},
        {"Physics", D(""), physics, "YY"},
        {"GroupType", D("<GroupType>G</GroupType>"), group, "G"},
        {"the group's name", D("<GroupType>G</GroupType>"), group_name, "Group"},
        {"a group of another file", D("<GroupType>H</GroupType>"), group_name, ""},
        {"Fmmu", D("<Fmmu>MBoxState</Fmmu>"), fmmu, "MBoxState"},
        {"Sm", SM(""), sm_type, "Inputs"},
        {"PDO's Name", PDO(""), pdo_name, "P"},
        {"Entry's Name", ENT("<Index>1</Index><BitLen>8</BitLen><Name>E</Name>"), entry_name, "E"},
        {"blanks around a text", ENT("<Index>1</Index><BitLen>8</BitLen><Name>\n  E 1\t</Name>"), entry_name, "E 1"},
        {"an empty text", ENT("<Index>1</Index><BitLen>8</BitLen><Name/>"), entry_name, ""},
        {"CDATA", ENT("<Index>1</Index><BitLen>8</BitLen><Name><![CDATA[ a & b ]]></Name>"), entry_name, "a & b"},
        {"text and CDATA", ENT("<Index>1</Index><BitLen>8</BitLen><Name>a <![CDATA[& b]]></Name>"), entry_name,
         "a & b"},
        {"a comment in a text", ENT("<Index>1</Index><BitLen>8</BitLen><Name>a<!-- no -->b</Name>"), entry_name, "ab"},
        {"the English of two",
         ENT("<Index>1</Index><BitLen>8</BitLen><Name LcId='1031'>Wert</Name><Name LcId='1033'>Value</Name>"),
         entry_name, "Value"},
        {"the first without English",
         ENT("<Index>1</Index><BitLen>8</BitLen><Name LcId='1031'>Wert</Name><Name LcId='1036'>Valeur</Name>"),
         entry_name, "Wert"},
        {"the first English",
         ENT("<Index>1</Index><BitLen>8</BitLen><Name LcId='1033'>One</Name><Name LcId='1033'>Two</Name>"), entry_name,
         "One"},
        {"DataType", ENT("<Index>1</Index><BitLen>8</BitLen><DataType>USINT</DataType>"), entry_type, "USINT"},
        {"DataType of none", ENT("<Index>1</Index><BitLen>8</BitLen>"), entry_type, ""},
        {"Transition", INIT("><Transition>PS</Transition>"), transitions, "PS"},
        {"Transitions", INIT("><Transition>PS</Transition><Transition>SO</Transition>"), transitions, "PS SO"},
        {"Transition of none", INIT(">"), transitions, ""},
        {"Comment", INIT("><Comment>C</Comment>"), comment, "C"},
        {"OpMode/Name", MODE("<Name>DC</Name>"), mode, "DC"},
        {"OpMode/Desc", MODE("<Desc>Text</Desc>"), mode_text, "Text"},
        {"DictionaryFile", D("<Profile><DictionaryFile>d.xml</DictionaryFile></Profile>"), dictionary_file, "d.xml"},
        {"DictionaryFile of none", D(""), dictionary_file, ""},
        {"Slot/Name", SLOT("", ""), slot_name, "S"},
        {"ModuleClass/Class", SLOT("", "<ModuleClass><Class>A</Class><Name>N</Name></ModuleClass>"), slot_class, "A"},
        {"ModuleClass as a text", SLOT("", "<ModuleClass>B</ModuleClass>"), slot_class, "B"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = try_text(table[i].text);
        if (m.model == NULL)
            fail_msg("%s: expected a device, got: %s", table[i].what, m.why);
        if (strcmp(table[i].of(m.model), table[i].expected) != 0)
            fail_msg("%s: expected \"%s\", got \"%s\"", table[i].what, table[i].expected, table[i].of(m.model));
        free_made(&m);
    }
}

/* Numbers at their bounds, and one beyond. */
static void bounds(void **state)
{
    static const struct {
        const char *text, *why; /* NULL: it is read */
    } table[] = {
        {SM("StartAddress='65535'"), NULL},
        {SM("StartAddress='65536'"), "StartAddress is 65536, not 0 to 65535"},
        {SM("StartAddress='-1'"), "StartAddress is -1, not 0 to 65535"},
        {SM("ControlByte='255'"), NULL},
        {SM("ControlByte='256'"), "ControlByte is 256, not 0 to 255"},
        {SM("Enable='256'"), "Enable is 256, not 0 to 255"},
        {SM("DefaultSize='big'"), "DefaultSize is \"big\", not a number"},
        {PDO("OSFac='0'"), "OSFac is 0, not 1 to 65535"},
        {PDO("Sm='256'"), "Sm is 256, not 0 to 255"},
        {ENT("<Index>1</Index><BitLen>65535</BitLen>"), NULL},
        {ENT("<Index>1</Index><BitLen>65536</BitLen>"), "BitLen is 65536, not 0 to 65535"},
        {ENT("<Index>1</Index><SubIndex>255</SubIndex><BitLen>1</BitLen>"), NULL},
        {MODE("<AssignActivate>65536</AssignActivate>"), "AssignActivate is 65536"},
        {MODE("<CycleTimeSync0>4294967295</CycleTimeSync0>"), NULL},
        {MODE("<CycleTimeSync0>4294967296</CycleTimeSync0>"), "CycleTimeSync0 is 4294967296"},
        {MODE("<ShiftTimeSync0>-2147483648</ShiftTimeSync0>"), NULL},
        {MODE("<ShiftTimeSync0>-2147483649</ShiftTimeSync0>"), "ShiftTimeSync0 is -2147483649"},
        {MODE("<CycleTimeSync0 Factor='32768'>0</CycleTimeSync0>"), "Factor is 32768"},
        {D("<Eeprom><ByteSize>4194305</ByteSize></Eeprom>"), "ByteSize is 4194305, not 0 to 4194304"},
        {CAT("<DataUINT>many</DataUINT>"), "DataUINT is \"many\", not a number"},
        {D("<Info><Electrical><EBusCurrent>32768</EBusCurrent></Electrical></Info>"), "EBusCurrent is 32768"},
        {D("<Profile><ProfileNo>65536</ProfileNo></Profile>"), "ProfileNo is 65536"},
        {D("<Mailbox><SoE ChannelCount='256'/></Mailbox>"), "ChannelCount is 256"},
        {SLOT("MaxInstances='65536'", ""), "MaxInstances is 65536"},
        {SLOT("", "<ModuleIdent>4294967296</ModuleIdent>"), "ModuleIdent is 4294967296"},
        {D("<Profile><Dictionary><Objects><Object><Name>N</Name></Object></Objects></Dictionary></Profile>"),
         "Object has no Index"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        made_t m = try_text(table[i].text);
        bool as_expected =
            table[i].why == NULL ? m.model != NULL : m.model == NULL && strstr(m.why, table[i].why) != NULL;
        if (!as_expected)
            fail_msg("%zu: expected %s, got \"%s\"", i, table[i].why ? table[i].why : "a device", m.why);
        free_made(&m);
    }
}

/* --- writing ------------------------------------------------------------------------------------------------------ */

/* The line of a written file for a line of the file that the twin was made from. */
static void written(void **state)
{
#define MAIL    ESI_MAILBOX_SMS
#define COE(at) MAIL "<Mailbox><CoE " at "/></Mailbox>"
    static const struct {
        const char *what, *text, *expected;
    } table[] = {
        {"the product code", D(""), "ProductCode=\"#x00000001\" RevisionNo=\"#x00000002\">DEV</Type>"},
        {"LRW",
         ESI_HEAD "<Device Physics='Y'><Type ProductCode='1' RevisionNo='1' UseLrdLwr='1'>D</Type></Device>" ESI_TAIL,
         "UseLrdLwr=\"true\""},
        {"ports", D(""), "<Device Physics=\"YY\">"},
        {"the name", D(""), "<Name>A device</Name>"},
        {"a name with signs of XML",
         ESI_HEAD "<Device><Type ProductCode='1'>D</Type><Name>a &lt; b</Name></Device>" ESI_TAIL, "<![CDATA[a < b]]>"},
        {"the current", D("<Info><Electrical><EBusCurrent>90</EBusCurrent></Electrical></Info>"),
         "<EBusCurrent>90</EBusCurrent>"},
        {"a timeout", D("<Info><StateMachine><Timeout><PreopTimeout>11</PreopTimeout></Timeout></StateMachine></Info>"),
         "<PreopTimeout>11</PreopTimeout>"},
        {"the standard's timeout", D(""), "<BackToSafeopTimeout>200</BackToSafeopTimeout>"},
        {"one mailbox timeout",
         D("<Info><Mailbox><Timeout><RequestTimeout>5</RequestTimeout></Timeout></Mailbox></Info>"),
         "<ResponseTimeout>2000</ResponseTimeout>"},
        {"the other mailbox timeout",
         D("<Info><Mailbox><Timeout><ResponseTimeout>5</ResponseTimeout></Timeout></Mailbox></Info>"),
         "<RequestTimeout>100</RequestTimeout>"},
        {"identification", D("<Info><IdentificationReg134>1</IdentificationReg134></Info>"),
         "<IdentificationReg134>true</IdentificationReg134>"},
        {"identification in memory", D("<Info><IdentificationAdo>#x1000</IdentificationAdo></Info>"),
         "<IdentificationAdo>#x1000</IdentificationAdo>"},
        {"an FMMU", D("<Fmmu>MBoxState</Fmmu>"), "<Fmmu>MBoxState</Fmmu>"},
        {"an FMMU of no role", D("<Fmmu>Other</Fmmu>"), "<Fmmu></Fmmu>"},
        {"a mailbox SyncManager", D(COE("")),
         "<Sm MinSize=\"128\" MaxSize=\"128\" DefaultSize=\"128\" StartAddress=\"#x1000\" ControlByte=\"#x26\" "
         "Enable=\"1\">MBoxOut</Sm>"},
        {"OpOnly", D("<Sm StartAddress='#x1000' ControlByte='#x20' Enable='9'>Inputs</Sm>"),
         "Enable=\"0\" OpOnly=\"true\">Inputs</Sm>"},
        {"a fixed SyncManager", D("<Sm StartAddress='#x1000' ControlByte='#x20' Enable='3'>Inputs</Sm>"),
         "Enable=\"2\">Inputs</Sm>"},
        {"a fixed PDO",
         D("<Sm StartAddress='#x1000' ControlByte='#x20'>Inputs</Sm><TxPdo Fixed='1' "
           "Sm='0'><Index>#x1A00</Index><Name>P</Name></TxPdo>"),
         "<TxPdo Fixed=\"true\" Sm=\"0\">"},
        {"a mandatory PDO",
         D("<Sm StartAddress='#x1000' ControlByte='#x20'>Inputs</Sm><TxPdo Mandatory='1' "
           "Sm='0'><Index>#x1A00</Index><Name>P</Name></TxPdo>"),
         "<TxPdo Mandatory=\"true\" Sm=\"0\">"},
        {"a PDO that is not assigned", D("<TxPdo><Index>#x1A00</Index><Name>P</Name></TxPdo>"), "<TxPdo>"},
        {"exclusion",
         D("<TxPdo><Index>#x1A00</Index><Name>P</Name><Exclude>#x1A01</Exclude></TxPdo><TxPdo><Index>#x1A01</"
           "Index><Name>Q</Name></TxPdo>"),
         "<Exclude>#x1A01</Exclude>"},
        {"a gap",
         D("<TxPdo><Index>#x1A00</Index><Name>P</Name><Entry><Index>0</Index><BitLen>3</BitLen></Entry></TxPdo>"),
         "<Index>#x0</Index>\n            <BitLen>3</BitLen>"},
        {"the data link layer", D(MAIL "<Mailbox DataLinkLayer='1'><CoE/></Mailbox>"),
         "<Mailbox DataLinkLayer=\"true\">"},
        {"no data link layer", D(COE("")), "<Mailbox>"},
        {"abilities of CoE", D(COE("SdoInfo='1' CompleteAccess='1' PdoUpload='1'")),
         "<CoE SdoInfo=\"true\" PdoUpload=\"true\" CompleteAccess=\"true\" SegmentedSdo=\"true\"/>"},
        {"another protocol", D(MAIL "<Mailbox><VoE/></Mailbox>"), "<VoE/>"},
        {"a mode of the clocks",
         MODE("<Name>DC</Name><AssignActivate>#x300</AssignActivate><CycleTimeSync0 Factor='1'>0</CycleTimeSync0>"),
         "<CycleTimeSync0 Factor=\"1\">0</CycleTimeSync0>"},
        {"a shift", MODE("<Name>DC</Name><AssignActivate>#x300</AssignActivate><ShiftTimeSync0>-7</ShiftTimeSync0>"),
         "<ShiftTimeSync0>-7</ShiftTimeSync0>"},
        {"the size of the EEPROM", D("<Eeprom><ByteSize>512</ByteSize></Eeprom>"), "<ByteSize>512</ByteSize>"},
        {"its first words", D("<Eeprom><ByteSize>512</ByteSize><ConfigData>0102</ConfigData></Eeprom>"),
         "<ConfigData>0102000000000000000000000000</ConfigData>"},
        {"BOOT mailboxes",
         D(COE("") "<Eeprom><ByteSize>512</ByteSize><BootStrap>0010800080108000</BootStrap></Eeprom>"),
         "<BootStrap>0010800080108000</BootStrap>"},
        {"the profile", D("<Profile><ProfileNo>402</ProfileNo><AddInfo>2</AddInfo></Profile>" COE("")),
         "<ProfileNo>402</ProfileNo>\n          <AddInfo>2</AddInfo>"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        ect_arena_t arena = {0};
        char why[300];
        size_t length;
        made_t m = make_text(table[i].what, table[i].text);
        const ect_esi_part_t part = {.device = device_of(&m), .twin = m.twin};
        const char *text = ect_esi_write(&arena, &part, 1, &length, why, sizeof why);
        if (text == NULL || strstr(text, table[i].expected) == NULL)
            fail_msg("%s: expected %s, got %s", table[i].what, table[i].expected, text ? text : why);
        free_made(&m);
        ect_arena_free(&arena);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"each number of a file is in the model", numbers, NULL, NULL, NULL},
        {"each text of a file is in the model, in English, without blanks around", texts, NULL, NULL, NULL},
        {"numbers beyond their bounds are refused", bounds, NULL, NULL, NULL},
        {"each member of a description is in the file", written, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
