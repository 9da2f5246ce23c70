/* SPDX-License-Identifier: MIT */
/* Facts of ESI files: the facts of a file, without those that its twin adds, each with its opposite case. */
#include "facts/facts.h"

#include "../esi/from_text.h"

/* The text of a fact, "none" without it, "?" when its content is not known. */
static const char *text_of(const ect_facts_t *facts, ect_fact_kind_t kind, unsigned int index, unsigned int element)
{
    for (size_t i = 0; i < facts->count; i++) {
        const ect_fact_t *f = &facts->list[i];
        if (f->kind == kind && f->index == index && f->element == element)
            return f->text != NULL ? f->text : "?";
    }
    return "none";
}

#define DEV(body) ESI_DEVICE(body ESI_MAILBOX_SMS ESI_PROCESS_SMS "<Mailbox><CoE/></Mailbox>" ESI_EEPROM)
#define BARE      ESI_HEAD "<Device><Type ProductCode='1' RevisionNo='1'>D</Type></Device>" ESI_TAIL
#define OBJECT(index, rest)                                                                                            \
    "<Profile><Dictionary><Objects><Object><Index>" index "</Index><Name>A name</Name><Type>UINT</Type>"               \
    "<BitSize>16</BitSize>" rest "</Object></Objects></Dictionary></Profile>"
#define PDO(attributes, rest)                                                                                          \
    "<TxPdo " attributes "><Index>#x1A00</Index><Name>P</Name>" rest                                                   \
    "<Entry><Index>#x6000</Index><SubIndex>1</SubIndex><BitLen>16</BitLen><Name>E</Name><DataType>INT</DataType>"      \
    "</Entry></TxPdo>"
#define TIMEOUT(which, ms) "<Info><StateMachine><Timeout><" which ">" ms "</" which "></Timeout></StateMachine></Info>"
#define NINE(n)            n n n n n n n n n
#define EIGHTY_ONE         NINE(NINE("<Exclude>#x1A01</Exclude>"))

static void facts_of_files(void **state)
{
    static const struct {
        const char *what, *text;
        ect_fact_kind_t kind;
        unsigned int index, element;
        const char *fact;
    } table[] = {
        {"the vendor", DEV(""), ECT_FACT_VENDOR, 0, 0, "0x00000E57"},
        {"the name", DEV(""), ECT_FACT_NAME, 0, 0, "\"A device\""},
        {"the vendor's name", DEV(""), ECT_FACT_VENDOR_NAME, 0, 0, "\"Works\""},
        {"no vendor's name",
         "<EtherCATInfo><Vendor><Id>1</Id></Vendor><Descriptions><Devices><Device><Type>D</Type></Device></Devices>"
         "</Descriptions></EtherCATInfo>",
         ECT_FACT_VENDOR_NAME, 0, 0, "none"},
        {"the ports", DEV(""), ECT_FACT_PORTS, 0, 0, "\"YY\""},
        {"no ports", BARE, ECT_FACT_PORTS, 0, 0, "none"},
        {"the group", DEV("<GroupType>G</GroupType>"), ECT_FACT_GROUP, 0, 0, "\"G\""},
        {"the group's name", DEV("<GroupType>G</GroupType>"), ECT_FACT_GROUP_NAME, 0, 0, "\"Group\""},
        {"a group of another file", DEV("<GroupType>H</GroupType>"), ECT_FACT_GROUP_NAME, 0, 0, "none"},
        {"no group", DEV(""), ECT_FACT_GROUP, 0, 0, "none"},
        {"a timeout to PREOP", DEV(TIMEOUT("PreopTimeout", "11")), ECT_FACT_TIMEOUT, 0, 0, "11 ms"},
        {"a timeout to OP", DEV(TIMEOUT("SafeopOpTimeout", "12")), ECT_FACT_TIMEOUT, 1, 0, "12 ms"},
        {"a timeout back to INIT", DEV(TIMEOUT("BackToInitTimeout", "13")), ECT_FACT_TIMEOUT, 2, 0, "13 ms"},
        {"a timeout back to SAFEOP", DEV(TIMEOUT("BackToSafeopTimeout", "14")), ECT_FACT_TIMEOUT, 3, 0, "14 ms"},
        {"a timeout of the standard", DEV(TIMEOUT("PreopTimeout", "11")), ECT_FACT_TIMEOUT, 1, 0, "none"},
        {"a timeout as in the standard", DEV(TIMEOUT("PreopTimeout", "3000")), ECT_FACT_TIMEOUT, 0, 0, "3000 ms"},
        {"the size of the EEPROM", DEV(""), ECT_FACT_EEPROM_SIZE, 0, 0, "2048 bytes"},
        {"a size that the twin changes", ESI_DEVICE("<Eeprom><ByteSize>1</ByteSize></Eeprom>"), ECT_FACT_EEPROM_SIZE, 0,
         0, "1 bytes"},
        {"no size", BARE, ECT_FACT_EEPROM_SIZE, 0, 0, "none"},
        {"the first word", DEV(""), ECT_FACT_CONFIG, 0, 0, "0x0405"},
        {"a word beyond ConfigData", DEV(""), ECT_FACT_CONFIG, 1, 0, "none"},
        {"the last word of ConfigData",
         ESI_DEVICE("<Eeprom><ConfigData>0102030405060708090A0B0C0D0E</ConfigData></Eeprom>"), ECT_FACT_CONFIG, 6, 0,
         "0x0E0D"},
        {"half a word of ConfigData", ESI_DEVICE("<Eeprom><ConfigData>010203</ConfigData></Eeprom>"), ECT_FACT_CONFIG,
         1, 0, "none"},
        {"DefaultSize", DEV(""), ECT_FACT_SM_DEFAULT, 0, 0, "128"},
        {"no DefaultSize", DEV(""), ECT_FACT_SM_DEFAULT, 3, 0, "none"},
        {"the length with DefaultSize", DEV(""), ECT_FACT_SM_LENGTH, 1, 0, "128 bytes"},
        {"the length without", DEV(PDO("Sm='3'", "")), ECT_FACT_SM_LENGTH, 3, 0, "none"},
        {"MinSize", ESI_DEVICE("<Sm StartAddress='#x1000' ControlByte='#x20' MinSize='3'>Inputs</Sm>"),
         ECT_FACT_SM_MINIMUM, 0, 0, "3"},
        {"MaxSize", ESI_DEVICE("<Sm StartAddress='#x1000' ControlByte='#x20' MaxSize='9'>Inputs</Sm>"),
         ECT_FACT_SM_MAXIMUM, 0, 0, "9"},
        {"neither", DEV(""), ECT_FACT_SM_MAXIMUM, 0, 0, "0"},
        {"a fixed PDO", DEV(PDO("Fixed='1'", "")), ECT_FACT_PDO_FIXED, 0x1A00, 0, "yes"},
        {"a PDO that is not fixed", DEV(PDO("", "")), ECT_FACT_PDO_FIXED, 0x1A00, 0, "no"},
        {"a mandatory PDO", DEV(PDO("Mandatory='1'", "")), ECT_FACT_PDO_MANDATORY, 0x1A00, 0, "yes"},
        {"a PDO that is not mandatory", DEV(PDO("", "")), ECT_FACT_PDO_MANDATORY, 0x1A00, 0, "no"},
        {"no exclusion", DEV(PDO("", "")), ECT_FACT_PDO_EXCLUDES, 0x1A00, 0, "none"},
        {"an exclusion", DEV(PDO("", "<Exclude>#x1A01</Exclude>")), ECT_FACT_PDO_EXCLUDES, 0x1A00, 0, "1A01"},
        {"two exclusions", DEV(PDO("", "<Exclude>#x1A02</Exclude><Exclude>#x1A01</Exclude>")), ECT_FACT_PDO_EXCLUDES,
         0x1A00, 0, "1A02 1A01"},
        {"a virtual PDO has no properties", DEV(PDO("Virtual='1'", "")), ECT_FACT_PDO_FIXED, 0x1A00, 0, "none"},
        {"an entry", DEV(PDO("", "")), ECT_FACT_PDO_ENTRY, 0x1A00, 1, "6000:01, 16 bits"},
        {"its name", DEV(PDO("", "")), ECT_FACT_PDO_ENTRY_NAME, 0x1A00, 1, "\"E\""},
        {"an object", DEV(OBJECT("#x2000", "")), ECT_FACT_OBJECT, 0x2000, 0, "code 7"},
        {"an object's name", DEV(OBJECT("#x2000", "")), ECT_FACT_OBJECT_NAME, 0x2000, 0, "\"A name\""},
        {"an object that a PDO made", DEV(PDO("", "")), ECT_FACT_OBJECT, 0x6000, 0, "?"},
        {"an object that every slave has", DEV(OBJECT("#x2000", "")), ECT_FACT_OBJECT, 0x1000, 0, "?"},
        {"its entry", DEV(OBJECT("#x2000", "")), ECT_FACT_ENTRY, 0x1000, 0, "?"},
        {"limits",
         DEV(OBJECT("#x2000",
                    "<Info><MinValue>1</MinValue><MaxValue>5</MaxValue><DefaultValue>2</DefaultValue></Info>")),
         ECT_FACT_ENTRY_LIMITS, 0x2000, 0, "1 to 5"},
        {"a unit", DEV(OBJECT("#x2000", "<Info><Unit>#xFD010000</Unit></Info>")), ECT_FACT_ENTRY_UNIT, 0x2000, 0,
         "0xFD01"},
        {"a default", DEV(OBJECT("#x2000", "<Info><DefaultData>0501</DefaultData></Info>")), ECT_FACT_ENTRY_DEFAULT,
         0x2000, 0, "05 01"},
        {"the file's name of 1C00h", DEV(OBJECT("#x1C00", "")), ECT_FACT_OBJECT_NAME, 0x1C00, 0, "\"A name\""},
        {"the twin's name of 1C00h", DEV(""), ECT_FACT_OBJECT_NAME, 0x1C00, 0, "none"},
        {"the twin's name of 1018h", DEV(OBJECT("#x2000", "")), ECT_FACT_OBJECT_NAME, 0x1018, 0, "none"},
        {"the twin's name of an element of 1018h", DEV(""), ECT_FACT_ENTRY_NAME, 0x1018, 1, "none"},
        {"the twin's name of an element of a mapping", DEV(PDO("", "")), ECT_FACT_ENTRY_NAME, 0x1A00, 1, "none"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        ect_facts_t facts = {.source = "file"};
        made_t m = make_text(table[i].what, table[i].text);
        ect_facts_of_esi(&facts, device_of(&m), m.model);
        const char *fact = text_of(&facts, table[i].kind, table[i].index, table[i].element);
        if (strcmp(fact, table[i].fact) != 0)
            fail_msg("%s: expected %s, got %s", table[i].what, table[i].fact, fact);
        ect_facts_free(&facts);
        free_made(&m);
    }
}

/* Complete lists: a further item of the other source is a difference. */
static void whole_lists(void **state)
{
    static const struct {
        const char *what, *text;
        bool objects;
    } table[] = {
        {"a dictionary", DEV(OBJECT("#x2000", "")), true},
        {"no dictionary", DEV(""), false},
        {"a dictionary in a file of its own",
         DEV("<Profile><DictionaryFile>d.xml</DictionaryFile></Profile>" OBJECT("#x2000", "")), false},
        {"a dictionary that modules add to", DEV(OBJECT("#x2000", "") "<Slots><Slot/></Slots>"), false},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        ect_facts_t facts = {.source = "file"};
        made_t m = make_text(table[i].what, table[i].text);
        ect_facts_of_esi(&facts, device_of(&m), m.model);
        if (facts.complete[ECT_FACT_OBJECT] != table[i].objects || facts.complete[ECT_FACT_ENTRY] != table[i].objects)
            fail_msg("%s: expected objects to be whole: %d", table[i].what, table[i].objects);
        assert_true(facts.complete[ECT_FACT_PDO] && facts.complete[ECT_FACT_SM] && facts.complete[ECT_FACT_DC]);
        assert_true(facts.complete[ECT_FACT_FILE] && facts.complete[ECT_FACT_FILE_TEXT]);
        ect_facts_free(&facts);
        free_made(&m);
    }
}

/* A list of exclusions ends with a whole index where the text has no more room. */
static void many_exclusions(void **state)
{
    ect_facts_t facts = {.source = "file"};
    (void)state;
    made_t m = make_text("81 exclusions", DEV(PDO("", EIGHTY_ONE)));
    assert_int_equal(m.model->pdos[0].exclude_count, 81);
    ect_facts_of_esi(&facts, device_of(&m), m.model);
    const char *fact = text_of(&facts, ECT_FACT_PDO_EXCLUDES, 0x1A00, 0);
    assert_int_equal(strlen(fact) % 5, 4);
    assert_true(strlen(fact) > 280);
    assert_string_equal(fact + strlen(fact) - 4, "1A01");
    ect_facts_free(&facts);
    free_made(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"CF-057 CF-060 CF-061 CF-077 a file has facts of its content, not of additions of its twin", facts_of_files,
         NULL, NULL, NULL},
        {"CF-077 the objects of a file are whole with a dictionary of its own and without modules", whole_lists, NULL,
         NULL, NULL},
        {"a list of exclusions is cut behind a whole index", many_exclusions, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
