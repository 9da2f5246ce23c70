/* SPDX-License-Identifier: MIT */
/* The parameters of a SoE drive, as its dictionary, telegrams and start-up commands in an ESI file make them. */
#include "from_text.h"
#include "seams/soe.h"
#include "wire/bytes.h"

#define TYPE(name, bits) "<DataType><Name>" name "</Name><BitSize>" bits "</BitSize></DataType>"
#define BITS(name, bits)                                                                                               \
    "<DataType><Name>" name "</Name><BitSize>" bits "</BitSize>"                                                       \
    "<SubItem><Name>Bit0</Name><Type>BIT</Type><BitSize>1</BitSize><BitOffs>0</BitOffs></SubItem></DataType>"
#define LIST_OF(name, bits, array)                                                                                     \
    "<DataType><Name>" name "</Name><BitSize>" bits "</BitSize>"                                                       \
    "<SubItem><Name>Act</Name><Type>UINT</Type><BitSize>16</BitSize><BitOffs>0</BitOffs></SubItem>"                    \
    "<SubItem><Name>Max</Name><Type>UINT</Type><BitSize>16</BitSize><BitOffs>16</BitOffs></SubItem>"                   \
    "<SubItem><Name>Values</Name><Type>" array                                                                         \
    "</Type><BitSize>32</BitSize><BitOffs>32</BitOffs></SubItem></DataType>"
#define ARRAY_OF(name, elements)                                                                                       \
    "<DataType><Name>" name "</Name><BaseType>UDINT</BaseType><BitSize>32</BitSize>"                                   \
    "<ArrayInfo><LBound>0</LBound><Elements>" elements "</Elements></ArrayInfo></DataType>"
#define MORE_TYPES                                                                                                     \
    BITS("BITS8", "8")                                                                                                 \
    BITS("BITS9", "9")                                                                                                 \
    BITS("BITS17", "17")                                                                                               \
    BITS("BITS33", "33")                                                                                               \
    BITS("BITS65", "65")                                                                                               \
    "<DataType><Name>FIRST15</Name><BitSize>16</BitSize><SubItem><Name>Low</Name><Type>BIT15</Type>"                   \
    "<BitSize>15</BitSize><BitOffs>0</BitOffs></SubItem></DataType>" ARRAY_OF("ARRAY1", "1") ARRAY_OF("ARRAY0", "0")   \
        LIST_OF("LIST1", "64", "ARRAY1") LIST_OF("LIST0", "96", "ARRAY0")
#define TYPES                                                                                                          \
    "<DataTypes>" TYPE("USINT", "8") TYPE("UINT", "16") TYPE("DINT", "32") TYPE("LINT", "64") TYPE("REAL", "32")       \
        TYPE("LREAL", "64") TYPE(                                                                                      \
            "STRING(4)",                                                                                               \
            "32") "<DataType><Name>ARRAY2</Name><BaseType>UDINT</BaseType><BitSize>64</BitSize><ArrayInfo><LBound>0</" \
                  "LBound>"                                                                                            \
                  "<Elements>2</Elements></ArrayInfo></DataType>"                                                      \
                  "<DataType><Name>LIST2</Name><BitSize>96</BitSize>"                                                  \
                  "<SubItem><Name>Act</Name><Type>UINT</Type><BitSize>16</BitSize><BitOffs>0</BitOffs></SubItem>"      \
                  "<SubItem><Name>Max</Name><Type>UINT</Type><BitSize>16</BitSize><BitOffs>16</BitOffs></SubItem>"     \
                  "<SubItem><Name>Values</Name><Type>ARRAY2</Type><BitSize>64</BitSize><BitOffs>32</BitOffs></"        \
                  "SubItem>"                                                                                           \
                  "</DataType>" BITS("BITS16", "16")                                                                   \
                      BITS("BITS64", "64") "<DataType><Name>SHORT</Name>"                                              \
                                           "<BitSize>64</BitSize>"                                                     \
                                           "<SubItem><Name>Act</Name><Type>UINT</Type><BitSize>16</"                   \
                                           "BitSize><BitOffs>0</BitOffs></SubItem>"                                    \
                                           "<SubItem><Name>Max</Name><Type>UINT</Type><BitSize>16</"                   \
                                           "BitSize><BitOffs>16</BitOffs></SubItem>"                                   \
                                           "<SubItem><Name>Value</Name><Type>UDINT</Type><BitSize>32</"                \
                                           "BitSize><BitOffs>32</BitOffs></SubItem>"                                   \
                                           "</DataType>" MORE_TYPES "</DataTypes>"
#define OBJECT(type, bits, rest)                                                                                       \
    "<Object><Index>#x8001</Index><Name>N</Name><Type>" type "</Type><BitSize>" bits "</BitSize>" rest "</Object>"
#define OBJECT_AT(index, type, bits, rest)                                                                             \
    "<Object><Index>#x" index "</Index><Name>N</Name><Type>" type "</Type><BitSize>" bits "</BitSize>" rest "</"       \
    "Object>"
#define INFO(body)       "<Info>" body "</Info>"
#define ATTRIBUTE(value) "<Flags><Attribute>#x" value "</Attribute></Flags>"
#define DRIVE_BESIDE(profile, objects, pdos, soe)                                                                      \
    ESI_DEVICE(profile "<Profile><Dictionary>" TYPES "<Objects>" objects                                               \
                       "</Objects></Dictionary></Profile>" ESI_MAILBOX_SMS ESI_PROCESS_SMS pdos "<Mailbox>" soe        \
                       "</Mailbox>" ESI_EEPROM)
#define DRIVE(objects, pdos, soe) DRIVE_BESIDE("", objects, pdos, soe)
#define ENTRY(index, bits, type)                                                                                       \
    "<Entry><Index>#x" index "</Index><BitLen>" bits "</BitLen><Name>V</Name><DataType>" type "</DataType></Entry>"
#define MDT(entries) "<RxPdo Sm='2'><Index>#x0018</Index><Name>MDT</Name>" ENTRY("86", "16", "UINT") entries "</RxPdo>"
#define AT(entries)  "<TxPdo Sm='3'><Index>#x0010</Index><Name>AT</Name>" ENTRY("87", "16", "UINT") entries "</TxPdo>"
#define INIT(idn, data)                                                                                                \
    "<SoE><InitCmd><Transition>PS</Transition><IDN>" idn "</IDN><Data>" data "</Data></InitCmd></SoE>"

static const ect_soe_t *soe_of(const made_t *m)
{
    for (const ect_protocol_t *const *p = device_of(m)->protocols; p != NULL && *p != NULL; p++) {
        if ((*p)->request == ect_soe_request)
            return (const ect_soe_t *)(const void *)*p;
    }
    fail_msg("expected a device with SoE");
    return NULL;
}

static const ect_soe_idn_t *find(const made_t *m, uint16_t idn)
{
    const ect_soe_idn_t *found = ect_soe_find(&soe_of(m)->drives[0], idn);
    if (found == NULL)
        fail_msg("expected IDN %u", idn);
    return found;
}

/* --- the dictionary ----------------------------------------------------------------------------------------------- */

static void shapes(void **state)
{
    static const struct {
        const char *what, *object;
        uint32_t attribute;
        uint16_t size, used;
        const char *content;
    } rows[] = {
        {"8 bits", OBJECT("USINT", "8", ""), ECT_SOE_8 | ECT_SOE_UNSIGNED | ECT_SOE_READ_ONLY | 1, 0, 0, NULL},
        {"signed, 32 bits", OBJECT("DINT", "32", ""), ECT_SOE_32 | ECT_SOE_SIGNED | ECT_SOE_READ_ONLY | 1, 0, 0, NULL},
        {"signed, 64 bits", OBJECT("LINT", "64", ""), ECT_SOE_64 | ECT_SOE_SIGNED | ECT_SOE_READ_ONLY | 1, 0, 0, NULL},
        {"floating", OBJECT("REAL", "32", ""), ECT_SOE_32 | ECT_SOE_FLOAT | ECT_SOE_READ_ONLY | 1, 0, 0, NULL},
        {"floating, 64 bits", OBJECT("LREAL", "64", ""), ECT_SOE_64 | ECT_SOE_FLOAT | ECT_SOE_READ_ONLY | 1, 0, 0,
         NULL},
        {"written in PREOP and OP",
         OBJECT("UINT", "16", "<Flags><Access WriteRestrictions='PreOP_OP'>rw</Access></Flags>"),
         ECT_SOE_16 | ECT_SOE_UNSIGNED | ECT_SOE_LOCK_SAFEOP | 1, 0, 0, NULL},
        {"its own attribute, but for the width", OBJECT("DINT", "32", ATTRIBUTE("20310002")), 0x20320002, 0, 0, NULL},
        {"bits with names", OBJECT("BITS16", "16", ""), ECT_SOE_16 | ECT_SOE_READ_ONLY | 1, 0, 0, NULL},
        {"64 bits with names", OBJECT("BITS64", "64", ATTRIBUTE("60030001")), 0x60030001, 0, 0, NULL},
        {"a short list", OBJECT("SHORT", "64", ""), ECT_SOE_16 | ECT_SOE_LIST | ECT_SOE_READ_ONLY | 1, 4, 0, NULL},
        {"a short list by its attribute", OBJECT("BITS64", "64", ATTRIBUTE("60050001")), 0x60050001, 4, 0, NULL},
        {"a command", OBJECT("DINT", "32", ATTRIBUTE("000A0001")), 0x00090001, 0, 0, NULL},
        {"a floating value of 16 bits", OBJECT("UINT", "16", ATTRIBUTE("60610001")),
         ECT_SOE_16 | ECT_SOE_FLOAT | 0x60000001, 0, 0, NULL},
        {"a text", OBJECT("STRING(4)", "32", INFO("<DefaultString>AB</DefaultString>")),
         ECT_SOE_8 | ECT_SOE_LIST | ECT_SOE_TEXT | ECT_SOE_READ_ONLY | 1, 4, 2, "AB"},
        {"a list", OBJECT("LIST2", "96", INFO("<DefaultData>0400080001020304</DefaultData>")),
         ECT_SOE_32 | ECT_SOE_LIST | ECT_SOE_READ_ONLY | 1, 8, 4, "\1\2\3\4"},
        {"a list without a default", OBJECT("LIST2", "96", ""), ECT_SOE_32 | ECT_SOE_LIST | ECT_SOE_READ_ONLY | 1, 8, 0,
         NULL},
        {"a list with a default that has no length", OBJECT("LIST2", "96", INFO("<DefaultData>0400</DefaultData>")),
         ECT_SOE_32 | ECT_SOE_LIST | ECT_SOE_READ_ONLY | 1, 8, 0, NULL},
        {"a list by its attribute", OBJECT("UINT", "16", ATTRIBUTE("00050001")), 0x00050001, 2, 0, NULL},
        {"8 bits with names", OBJECT("BITS8", "8", ""), ECT_SOE_8 | ECT_SOE_READ_ONLY | 1, 0, 0, NULL},
        {"9 bits with names", OBJECT("BITS9", "9", ""), ECT_SOE_16 | ECT_SOE_READ_ONLY | 1, 0, 0, NULL},
        {"17 bits with names", OBJECT("BITS17", "17", ""), ECT_SOE_32 | ECT_SOE_READ_ONLY | 1, 0, 0, NULL},
        {"33 bits with names", OBJECT("BITS33", "33", ""), ECT_SOE_64 | ECT_SOE_READ_ONLY | 1, 0, 0, NULL},
        {"65 bits with names", OBJECT("BITS65", "65", ""), ECT_SOE_16 | ECT_SOE_LIST | ECT_SOE_READ_ONLY | 1, 4, 0,
         NULL},
        {"a first part of 15 bits", OBJECT("FIRST15", "16", ""), ECT_SOE_16 | ECT_SOE_READ_ONLY | 1, 0, 0, NULL},
        {"an object longer than its type", OBJECT("BITS16", "32", ""), ECT_SOE_32 | ECT_SOE_READ_ONLY | 1, 0, 0, NULL},
        {"an object shorter than its type", OBJECT("BITS16", "8", ""), ECT_SOE_16 | ECT_SOE_READ_ONLY | 1, 0, 0, NULL},
        {"a list without room for its lengths", OBJECT("BITS16", "16", ATTRIBUTE("00050001")), 0x00050001, 0, 0, NULL},
        {"a list of one byte", OBJECT("BITS16", "40", ATTRIBUTE("00040001")), 0x00040001, 1, 0, NULL},
        {"a list of one number", OBJECT("LIST1", "64", ""), ECT_SOE_32 | ECT_SOE_LIST | ECT_SOE_READ_ONLY | 1, 4, 0,
         NULL},
        {"a list of an array without elements", OBJECT("LIST0", "96", ""),
         ECT_SOE_16 | ECT_SOE_LIST | ECT_SOE_READ_ONLY | 1, 8, 0, NULL},
        {"a list with room for a part of an element", OBJECT("LIST2", "112", ""),
         ECT_SOE_32 | ECT_SOE_LIST | ECT_SOE_READ_ONLY | 1, 8, 0, NULL},
        {"a bit that is a list by its attribute", OBJECT("BOOL", "1", ATTRIBUTE("00040001")), 0x00040001, 1, 0, NULL},
        {"a byte that is a list by its attribute", OBJECT("USINT", "8", ATTRIBUTE("00040001")), 0x00040001, 1, 0, NULL},
        {"bytes", OBJECT("ARRAY [0..7] OF BYTE", "64", ""),
         ECT_SOE_8 | ECT_SOE_LIST | ECT_SOE_UNSIGNED | ECT_SOE_READ_ONLY | 1, 8, 0, NULL},
        {"a text of 16384 bytes", OBJECT("STRING(16384)", "131072", ""),
         ECT_SOE_8 | ECT_SOE_LIST | ECT_SOE_TEXT | ECT_SOE_READ_ONLY | 1, 16384, 0, NULL},
        {"a text of 16385 bytes", OBJECT("STRING(16385)", "131080", ""),
         ECT_SOE_8 | ECT_SOE_LIST | ECT_SOE_TEXT | ECT_SOE_READ_ONLY | 1, 16384, 0, NULL},
        {"a full list", OBJECT("LIST2", "96", INFO("<DefaultData>080008000102030405060708</DefaultData>")),
         ECT_SOE_32 | ECT_SOE_LIST | ECT_SOE_READ_ONLY | 1, 8, 8, "\1\2\3\4\5\6\7\x08"},
        {"an empty list", OBJECT("LIST2", "96", INFO("<DefaultData>00000800</DefaultData>")),
         ECT_SOE_32 | ECT_SOE_LIST | ECT_SOE_READ_ONLY | 1, 8, 0, ""},
        {"a full text", OBJECT("STRING(4)", "32", INFO("<DefaultString>ABCD</DefaultString>")),
         ECT_SOE_8 | ECT_SOE_LIST | ECT_SOE_TEXT | ECT_SOE_READ_ONLY | 1, 4, 4, "ABCD"},
        {"a list by its attribute with a number as default",
         OBJECT("UINT", "16", INFO("<DefaultValue>5</DefaultValue>") ATTRIBUTE("00050001")), 0x00050001, 2, 0, NULL},
        {"a list by its attribute with bytes as default",
         OBJECT("UINT", "16", INFO("<DefaultData>0102</DefaultData>") ATTRIBUTE("00050001")), 0x00050001, 2, 2, "\1\2"},
        {"written in each state", OBJECT("UINT", "16", "<Flags><Access>rw</Access></Flags>"),
         ECT_SOE_16 | ECT_SOE_UNSIGNED | 1, 0, 0, NULL},
        {"written in SAFEOP", OBJECT("UINT", "16", "<Flags><Access WriteRestrictions='SafeOP'>rw</Access></Flags>"),
         ECT_SOE_16 | ECT_SOE_UNSIGNED | ECT_SOE_LOCK_PREOP | ECT_SOE_LOCK_OP | 1, 0, 0, NULL},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char text[8000];
        (void)snprintf(text, sizeof text, DRIVE("%s", "", "<SoE/>"), rows[i].object);
        made_t m = make_text(rows[i].what, text);
        const ect_soe_idn_t *idn = find(&m, 0x8001);
        if (idn->attribute != rows[i].attribute || idn->size != rows[i].size || idn->used != rows[i].used)
            fail_msg("%s: expected attribute 0x%08X, %u of %u bytes, got 0x%08X, %u of %u", rows[i].what,
                     (unsigned int)rows[i].attribute, rows[i].used, rows[i].size, (unsigned int)idn->attribute,
                     idn->used, idn->size);
        assert_int_not_equal(idn->offset, 0); /* each has memory */
        if ((idn->content != NULL) != (rows[i].content != NULL))
            fail_msg("%s: expected %s", rows[i].what, rows[i].content != NULL ? "a content" : "no content");
        if (rows[i].content != NULL)
            assert_memory_equal(idn->content, rows[i].content, rows[i].used);
        free_made(&m);
    }
}

static void limits(void **state)
{
    enum { MIN = ECT_SOE_MINIMUM, MAX = ECT_SOE_MAXIMUM, DEFAULT = ECT_SOE_DEFAULT };
#define OUTSIDE "line 2: the default of P-0-0001 is not within its limits: it has no limits"
    static const struct {
        const char *what, *object;
        uint8_t flags;
        int64_t minimum, maximum;
        const char *note;
    } rows[] = {
        {"none", OBJECT("DINT", "32", ""), 0, 0, 0, NULL},
        {"both",
         OBJECT("UINT", "16", INFO("<MinValue>2</MinValue><MaxValue>9</MaxValue><DefaultValue>9</DefaultValue>")),
         MIN | MAX | DEFAULT, 2, 9, NULL},
        {"signed",
         OBJECT("DINT", "32",
                INFO("<MinData>FEFFFFFF</MinData><MaxData>05000000</MaxData><DefaultData>FEFFFFFF</DefaultData>")),
         MIN | MAX | DEFAULT, -2, 5, NULL},
        {"a minimum alone", OBJECT("DINT", "32", INFO("<MinValue>-7</MinValue>")), MIN, -7, 0, NULL},
        {"a maximum alone", OBJECT("UINT", "16", INFO("<MaxValue>7</MaxValue>")), MAX, 0, 7, NULL},
        {"a minimum of 0 alone", OBJECT("UINT", "16", INFO("<MinValue>0</MinValue>")), MIN, 0, 0, NULL},
        {"signed, 8 bits",
         OBJECT("SINT", "8", INFO("<MinData>80</MinData><MaxData>7F</MaxData><DefaultData>80</DefaultData>")),
         MIN | MAX | DEFAULT, -128, 127, NULL},
        {"signed, 16 bits", OBJECT("INT", "16", INFO("<MinData>FEFF</MinData><MaxData>FF7F</MaxData>")), MIN | MAX, -2,
         32767, NULL},
        {"signed, 64 bits",
         OBJECT("LINT", "64", INFO("<MinData>FEFFFFFFFFFFFFFF</MinData><MaxData>0500000000000000</MaxData>")),
         MIN | MAX, -2, 5, NULL},
        {"unsigned, 16 bits",
         OBJECT("UINT", "16", INFO("<MinData>0100</MinData><MaxData>FFFF</MaxData><DefaultData>0080</DefaultData>")),
         MIN | MAX | DEFAULT, 1, 65535, NULL},
        {"equal ones are none", OBJECT("UINT", "16", INFO("<MinValue>3</MinValue><MaxValue>3</MaxValue>")), 0, 0, 0,
         NULL},
        {"of a floating value", OBJECT("REAL", "32", INFO("<MinValue>1</MinValue><MaxValue>2</MaxValue>")), 0, 0, 0,
         NULL},
        {"minimum above maximum", OBJECT("UINT", "16", INFO("<MinValue>9</MinValue><MaxValue>2</MaxValue>")), 0, 0, 0,
         OUTSIDE},
        {"default below", OBJECT("UINT", "16", INFO("<MinValue>2</MinValue><DefaultValue>1</DefaultValue>")), DEFAULT,
         0, 0, OUTSIDE},
        {"default above", OBJECT("UINT", "16", INFO("<MaxValue>2</MaxValue><DefaultValue>3</DefaultValue>")), DEFAULT,
         0, 0, OUTSIDE},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char text[8000];
        (void)snprintf(text, sizeof text, DRIVE("%s", "", "<SoE/>"), rows[i].object);
        made_t m = make_text(rows[i].what, text);
        const ect_soe_idn_t *idn = find(&m, 0x8001);
        const char *note = note_of(&m, "line 2: the default of");
        if (idn->flags != rows[i].flags || idn->minimum != rows[i].minimum || idn->maximum != rows[i].maximum)
            fail_msg("%s: expected flags 0x%02X, %lld to %lld, got 0x%02X, %lld to %lld", rows[i].what, rows[i].flags,
                     (long long)rows[i].minimum, (long long)rows[i].maximum, idn->flags, (long long)idn->minimum,
                     (long long)idn->maximum);
        if ((note == NULL) != (rows[i].note == NULL) || (note != NULL && strcmp(note, rows[i].note) != 0))
            fail_msg("%s: expected the note %s, got %s", rows[i].what, rows[i].note != NULL ? rows[i].note : "none",
                     note != NULL ? note : "none");
        free_made(&m);
    }
}

/* --- notes -------------------------------------------------------------------------------------------------------- */

static void mistakes(void **state)
{
    static const struct {
        const char *what, *text, *note;
    } rows[] = {
        {"an IDN twice", DRIVE(OBJECT("UINT", "16", "") OBJECT("UINT", "16", ""), "", "<SoE/>"),
         "line 2: P-0-0001 is left out: it exists already"},
        {"an unknown type", DRIVE(OBJECT("NONE", "0", ""), "", "<SoE/>"),
         "line 2: P-0-0001 is left out: the length of its type is not known"},
        {"a list longer than its type",
         DRIVE(OBJECT("LIST2", "96", INFO("<DefaultData>0C000C00010203040102030401020304</DefaultData>")), "",
               "<SoE/>"),
         "line 2: the default of P-0-0001 does not fit its type: it is empty"},
        {"a list with a length beyond its data",
         DRIVE(OBJECT("LIST2", "96", INFO("<DefaultData>0800080001020304</DefaultData>")), "", "<SoE/>"),
         "line 2: the default of P-0-0001 does not fit its type: it is empty"},
        {"a list with a part of an element",
         DRIVE(OBJECT("LIST2", "96", INFO("<DefaultData>030008000102030405060708</DefaultData>")), "", "<SoE/>"),
         "line 2: the default of P-0-0001 does not fit its type: it is empty"},
        {"a telegram with another width", DRIVE(OBJECT("UINT", "16", ""), MDT(ENTRY("8001", "32", "DINT")), "<SoE/>"),
         "line 2: PDO 0018 has 32 bits of P-0-0001, unlike the dictionary: the PDO counts"},
        {"a telegram with a list", DRIVE(OBJECT("LIST2", "96", ""), AT(ENTRY("8001", "32", "DINT")), "<SoE/>"),
         "line 2: PDO 0010 has 32 bits of P-0-0001, unlike the dictionary: the PDO counts"},
        {"a telegram with 24 bits", DRIVE("", MDT(ENTRY("8001", "24", "UINT24")), "<SoE/>"),
         "line 2: PDO 0018 has 24 bits of P-0-0001: they are a gap"},
        {"a text longer than its type",
         DRIVE(OBJECT("STRING(4)", "32", INFO("<DefaultString>ABCDE</DefaultString>")), "", "<SoE/>"),
         "line 2: the default of P-0-0001 does not fit its type: it is empty"},
        {"a telegram with a smaller width", DRIVE(OBJECT("DINT", "32", ""), MDT(ENTRY("8001", "16", "INT")), "<SoE/>"),
         "line 2: PDO 0018 has 16 bits of P-0-0001, unlike the dictionary: the PDO counts"},
        {"a telegram with a command",
         DRIVE(OBJECT("UINT", "16", ATTRIBUTE("00090001")), MDT(ENTRY("8001", "16", "UINT")), "<SoE/>"),
         "line 2: PDO 0018 has 16 bits of P-0-0001, unlike the dictionary: the PDO counts"},
        {"a telegram with a sub-index",
         DRIVE("",
               MDT("<Entry><Index>#x8001</Index><SubIndex>1</SubIndex><BitLen>16</BitLen><Name>V</Name>"
                   "<DataType>UINT</DataType></Entry>"),
               "<SoE/>"),
         "line 2: PDO 0018 has 16 bits of P-0-0001: they are a gap"},
        {"a command of three bytes for a missing IDN", DRIVE("", "", INIT("#x8001", "010203")),
         "line 2: a start-up command writes 3 bytes to P-0-0001, which does not take them"},
        {"a command of nine bytes for a missing IDN", DRIVE("", "", INIT("#x8001", "010203040506070809")),
         "line 2: a start-up command writes 9 bytes to P-0-0001, which does not take them"},
        {"a command for the third drive of two",
         DRIVE("", "",
               "<SoE ChannelCount='2'><InitCmd "
               "Chn='2'><Transition>PS</Transition><IDN>32</IDN><Data>0200</Data></InitCmd></SoE>"),
         "line 2: a start-up command is for drive 2; the device has 2"},
        {"a command for a missing drive",
         DRIVE("", "",
               "<SoE ChannelCount='1'><InitCmd "
               "Chn='1'><Transition>PS</Transition><IDN>32</IDN><Data>0200</Data></InitCmd></SoE>"),
         "line 2: a start-up command is for drive 1; the device has 1"},
        {"a command for a missing IDN", DRIVE("", "", INIT("#x8001", "0102")),
         "line 2: a start-up command writes P-0-0001, which the dictionary lacks: it is added"},
        {"a command of another length", DRIVE(OBJECT("UINT", "16", ""), "", INIT("#x8001", "01020304")),
         "line 2: a start-up command writes 4 bytes to P-0-0001, which does not take them"},
        {"a command without data", DRIVE("", "", INIT("#x8001", "")),
         "line 2: a start-up command writes 0 bytes to P-0-0001, which does not take them"},
        {"a list with another length in its data",
         DRIVE(OBJECT("LIST2", "96", ""), "", INIT("#x8001", "0500080001020304")),
         "line 2: a start-up command writes 8 bytes to P-0-0001, which does not take them"},
        {"a list longer than the IDN's",
         DRIVE(OBJECT("LIST2", "96", ""), "", INIT("#x8001", "0C000C00010203040102030401020304")),
         "line 2: a start-up command writes 16 bytes to P-0-0001, which does not take them"},
        {"a list shorter than its lengths", DRIVE(OBJECT("LIST2", "96", ""), "", INIT("#x8001", "0400")),
         "line 2: a start-up command writes 2 bytes to P-0-0001, which does not take them"},
        {"nine drives", DRIVE("", "", "<SoE ChannelCount='9'/>"), "it has 9 drives; SoE reaches 8"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        made_t m = make_text(rows[i].what, rows[i].text);
        if (note_of(&m, rows[i].note) == NULL)
            fail_msg("%s: expected the note \"%s\"", rows[i].what, rows[i].note);
        free_made(&m);
    }
}

/* --- start-up commands, telegrams --------------------------------------------------------------------------------- */

static void added_by_a_command(void **state)
{
#define COMMENTED(text)                                                                                                \
    "<SoE><InitCmd><Transition>PS</Transition><IDN>#x8001</IDN><Data>01</Data><Comment>" text                          \
    "</Comment></InitCmd></SoE>"
    static const struct {
        const char *what, *text;
        uint32_t attribute;
        uint16_t size;
        const char *name;
    } rows[] = {
        {"a number", DRIVE("", "", INIT("#x8001", "0102")), ECT_SOE_16 | ECT_SOE_UNSIGNED | 1, 0, "Start-up parameter"},
        {"a byte with a comment", DRIVE("", "", COMMENTED("Motor")), ECT_SOE_8 | ECT_SOE_UNSIGNED | 1, 0, "Motor"},
        {"a number that could be an empty list", DRIVE("", "", INIT("#x8001", "00000800")),
         ECT_SOE_8 | ECT_SOE_LIST | 1, 8, "Start-up parameter"},
        {"four bytes that are no list", DRIVE("", "", INIT("#x8001", "01000800")), ECT_SOE_32 | ECT_SOE_UNSIGNED | 1, 0,
         "Start-up parameter"},
        {"a list of one byte", DRIVE("", "", INIT("#x8001", "0100010005")), ECT_SOE_8 | ECT_SOE_LIST | 1, 1,
         "Start-up parameter"},
        {"five bytes that are no list", DRIVE("", "", INIT("#x8001", "0200010005")), ECT_SOE_64 | ECT_SOE_UNSIGNED | 1,
         0, "Start-up parameter"},
        {"a list with room for more", DRIVE("", "", INIT("#x8001", "020006000102")), ECT_SOE_8 | ECT_SOE_LIST | 1, 6,
         "Start-up parameter"},
        {"a list with less room than data", DRIVE("", "", INIT("#x8001", "020000000102")), ECT_SOE_8 | ECT_SOE_LIST | 1,
         2, "Start-up parameter"},
        {"eight bytes", DRIVE("", "", INIT("#x8001", "0400040001020304")), ECT_SOE_64 | ECT_SOE_UNSIGNED | 1, 0,
         "Start-up parameter"},
        {"a list of five bytes", DRIVE("", "", INIT("#x8001", "050005000102030405")), ECT_SOE_8 | ECT_SOE_LIST | 1, 5,
         "Start-up parameter"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        made_t m = make_text(rows[i].what, rows[i].text);
        const ect_soe_idn_t *idn = find(&m, 0x8001);
        if (idn->attribute != rows[i].attribute || idn->size != rows[i].size || strcmp(idn->name, rows[i].name) != 0)
            fail_msg("%s: expected \"%s\" with attribute 0x%08X and %u bytes, got \"%s\" with 0x%08X and %u",
                     rows[i].what, rows[i].name, (unsigned int)rows[i].attribute, rows[i].size, idn->name,
                     (unsigned int)idn->attribute, idn->size);
        free_made(&m);
    }
}

/* A list that a command adds has at most 16384 bytes with its two lengths. */
static void longest_command(void **state)
{
    static const size_t lengths[] = {16384, 16385};
    static char digits[2 * 16385 + 1], text[sizeof digits + 8000];
    (void)state;
    for (size_t i = 0; i < 2; i++) {
        const size_t bytes = lengths[i] - 4;
        (void)snprintf(digits, sizeof digits, "%02zX%02zX0000", bytes % 256, bytes / 256);
        memset(digits + 8, '0', 2 * bytes);
        digits[2 * lengths[i]] = '\0';
        (void)snprintf(text, sizeof text, DRIVE("", "", INIT("#x8001", "%s")), digits);
        made_t m = make_text("a long command", text);
        const ect_soe_idn_t *idn = ect_soe_find(&soe_of(&m)->drives[0], 0x8001);
        if (i == 0)
            assert_true(idn != NULL && idn->size == 16380);
        else
            assert_null(idn);
        assert_int_equal(note_of(&m, "line 2: a start-up command writes 16385 bytes to P-0-0001") != NULL, i == 1);
        free_made(&m);
    }
}

static void opened_by_a_command(void **state)
{
    static const struct {
        const char *transition;
        uint32_t locks;
    } rows[] = {
        {"IP", ECT_SOE_LOCK_SAFEOP | ECT_SOE_LOCK_OP},
        {"PS", ECT_SOE_LOCK_SAFEOP | ECT_SOE_LOCK_OP},
        {"SO", ECT_SOE_LOCK_PREOP | ECT_SOE_LOCK_OP},
        {"SP", ECT_SOE_LOCK_PREOP | ECT_SOE_LOCK_OP},
        {"OS", ECT_SOE_LOCK_PREOP | ECT_SOE_LOCK_SAFEOP},
        {"OP", ECT_SOE_LOCK_PREOP | ECT_SOE_LOCK_SAFEOP},
        {"SI", ECT_SOE_READ_ONLY},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char text[8000];
        (void)snprintf(
            text, sizeof text,
            DRIVE("%s", "",
                  "<SoE><InitCmd><Transition>%s</Transition><IDN>#x8001</IDN><Data>0A00</Data></InitCmd></SoE>"),
            OBJECT("UINT", "16", INFO("<MinValue>1</MinValue><MaxValue>9</MaxValue><DefaultValue>2</DefaultValue>")),
            rows[i].transition);
        made_t m = make_text(rows[i].transition, text);
        const ect_soe_idn_t *idn = find(&m, 0x8001);
        if ((idn->attribute & ECT_SOE_READ_ONLY) != rows[i].locks)
            fail_msg("%s: expected locks 0x%08X, got 0x%08X", rows[i].transition, (unsigned int)rows[i].locks,
                     (unsigned int)(idn->attribute & ECT_SOE_READ_ONLY));
        assert_int_equal(idn->attribute & ~ECT_SOE_READ_ONLY, ECT_SOE_16 | ECT_SOE_UNSIGNED | 1);
        assert_int_equal(idn->flags & (ECT_SOE_MINIMUM | ECT_SOE_MAXIMUM), 0); /* 10 is above the maximum */
        free_made(&m);
    }
}

static void modes(void **state)
{
    static const struct {
        const char *what, *text;
        uint64_t mode;
    } rows[] = {
        {"position", DRIVE("", MDT(ENTRY("2F", "32", "DINT")), "<SoE/>"), 11},
        {"speed", DRIVE("", MDT(ENTRY("24", "32", "DINT")), "<SoE/>"), 2},
        {"torque", DRIVE("", MDT(ENTRY("50", "16", "INT")), "<SoE/>"), 1},
        {"a position that no telegram has", DRIVE(OBJECT_AT("002F", "DINT", "32", ""), "", "<SoE/>"), 1},
        {"a speed that no telegram has", DRIVE(OBJECT_AT("0024", "DINT", "32", ""), "", "<SoE/>"), 1},
        {"a speed in the telegram, a position without one",
         DRIVE(OBJECT_AT("002F", "DINT", "32", ""), MDT(ENTRY("24", "32", "DINT")), "<SoE/>"), 2},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        made_t m = make_text(rows[i].what, rows[i].text);
        if (find(&m, 32)->initial != rows[i].mode)
            fail_msg("%s: expected mode %u, got %u", rows[i].what, (unsigned int)rows[i].mode,
                     (unsigned int)find(&m, 32)->initial);
        free_made(&m);
    }
}

/* A PDO that begins with another value, or has a second control word, is no list. */
static void unlisted(void **state)
{
    static const struct {
        const char *what, *pdo;
        uint16_t used;
    } rows[] = {
        {"a value", MDT(ENTRY("24", "32", "DINT")), 2},
        {"no word", "<RxPdo Sm='2'><Index>#x0018</Index><Name>MDT</Name>" ENTRY("24", "32", "DINT") "</RxPdo>", 0},
        {"a word of 32 bits",
         "<RxPdo Sm='2'><Index>#x0018</Index><Name>MDT</Name>" ENTRY("86", "32", "UDINT") "</RxPdo>", 0},
        {"a second word", MDT(ENTRY("86", "16", "UINT")), 0},
        {"the status word", MDT(ENTRY("87", "16", "UINT")), 0},
        {"no entries", "<RxPdo Sm='2'><Index>#x0018</Index><Name>MDT</Name></RxPdo>", 0},
        {"a gap", MDT("<Entry><Index>0</Index><BitLen>16</BitLen></Entry>"), 0},
        {"no SyncManager",
         "<RxPdo><Index>#x0018</Index><Name>MDT</Name>" ENTRY("86", "16", "UINT") ENTRY("24", "32", "DINT") "</RxPdo>",
         0},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char text[8000];
        (void)snprintf(text, sizeof text, DRIVE("", "%s", "<SoE/>"), rows[i].pdo);
        made_t m = make_text(rows[i].what, text);
        if (find(&m, 24)->used != rows[i].used)
            fail_msg("%s: expected %u bytes in S-0-0024, got %u", rows[i].what, rows[i].used, find(&m, 24)->used);
        free_made(&m);
    }
}

/* S-0-0187 of the dictionary names numbers; a word, a list and a missing IDN are no choice. */
static void choices(void **state)
{
    static const char objects[] =
        "<Object><Index>#x00BB</Index><Name>Choices</Name><Type>LIST2</Type><BitSize>96</BitSize>" INFO(
            "<DefaultData>0800080001808700BC000900</DefaultData>") "</Object>" OBJECT("UINT", "16", "");
    (void)state;
    made_t m = make_text("choices", DRIVE("", "", "<SoE/>"));
    assert_int_equal(ect_soe_find(&soe_of(&m)->drives[0], 0x8001) != NULL, false);
    free_made(&m);
    char text[8000];
    (void)snprintf(text, sizeof text, DRIVE("%s", "", "<SoE/>"), objects);
    m = make_text("choices", text);
    assert_int_equal(find(&m, 0x8001)->flags & (ECT_SOE_IN_AT | ECT_SOE_IN_MDT), ECT_SOE_IN_AT);
    assert_int_equal(find(&m, 188)->flags, 0);
    free_made(&m);
}

/* A number is no list, a list without a default is empty; words of telegrams and lists are in no list of choices. */
static void no_choices(void **state)
{
    static const struct {
        const char *what, *text;
        uint16_t idns[2];
    } rows[] = {
        {"a number", DRIVE(OBJECT_AT("00BB", "UINT", "16", "") OBJECT("UINT", "16", ""), "", "<SoE/>"), {0x8001}},
        {"an empty list", DRIVE(OBJECT_AT("00BB", "LIST2", "96", "") OBJECT("UINT", "16", ""), "", "<SoE/>"), {0x8001}},
        {"words, and the list itself",
         DRIVE(OBJECT_AT("0086", "UINT", "16", "<Flags><PdoMapping>R</PdoMapping></Flags>")
                   OBJECT_AT("0087", "UINT", "16", "<Flags><PdoMapping>T</PdoMapping></Flags>")
                       OBJECT_AT("00BB", "LIST2", "96", INFO("<DefaultData>0800080086008700BB000000</DefaultData>")),
               "", "<SoE/>"),
         {0x86, 0x87}},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        made_t m = make_text(rows[i].what, rows[i].text);
        for (size_t k = 0; k < 2 && rows[i].idns[k] != 0; k++) {
            if ((find(&m, rows[i].idns[k])->flags & (ECT_SOE_IN_AT | ECT_SOE_IN_MDT)) != 0)
                fail_msg("%s: expected IDN %u in no telegram", rows[i].what, rows[i].idns[k]);
        }
        assert_int_equal(find(&m, 187)->flags, 0);
        free_made(&m);
    }
}

/* A command whose value is beyond a limit of the dictionary takes both limits away. */
static void limits_and_commands(void **state)
{
    enum { MIN = ECT_SOE_MINIMUM, MAX = ECT_SOE_MAXIMUM };
#define BOTH    INFO("<MinValue>3</MinValue><MaxValue>9</MaxValue><DefaultValue>5</DefaultValue>")
#define MINIMUM INFO("<MinValue>3</MinValue><DefaultValue>5</DefaultValue>")
#define MAXIMUM INFO("<MaxValue>9</MaxValue><DefaultValue>5</DefaultValue>")
#define WIDE                                                                                                           \
    INFO("<MinData>0300000000000000</MinData><MaxData>0900000000000040</MaxData><DefaultValue>5</DefaultValue>")
    static const struct {
        const char *what, *text;
        uint8_t flags;
    } rows[] = {
        {"within", DRIVE(OBJECT("UINT", "16", BOTH), "", INIT("#x8001", "0400")), MIN | MAX},
        {"the minimum", DRIVE(OBJECT("UINT", "16", BOTH), "", INIT("#x8001", "0300")), MIN | MAX},
        {"the maximum", DRIVE(OBJECT("UINT", "16", BOTH), "", INIT("#x8001", "0900")), MIN | MAX},
        {"below", DRIVE(OBJECT("UINT", "16", BOTH), "", INIT("#x8001", "0200")), 0},
        {"above", DRIVE(OBJECT("UINT", "16", BOTH), "", INIT("#x8001", "0A00")), 0},
        {"above, with a minimum alone", DRIVE(OBJECT("UINT", "16", MINIMUM), "", INIT("#x8001", "0A00")), MIN},
        {"below, with a minimum alone", DRIVE(OBJECT("UINT", "16", MINIMUM), "", INIT("#x8001", "0200")), 0},
        {"0, with a maximum alone", DRIVE(OBJECT("UINT", "16", MAXIMUM), "", INIT("#x8001", "0000")), MAX},
        {"negative, with a maximum alone", DRIVE(OBJECT("DINT", "32", MAXIMUM), "", INIT("#x8001", "FEFFFFFF")), MAX},
        {"64 bits, within", DRIVE(OBJECT("LINT", "64", WIDE), "", INIT("#x8001", "0900000000000040")), MIN | MAX},
        {"64 bits, above in byte 0", DRIVE(OBJECT("LINT", "64", WIDE), "", INIT("#x8001", "0A00000000000040")), 0},
        {"64 bits, below in byte 7", DRIVE(OBJECT("LINT", "64", WIDE), "", INIT("#x8001", "0900000000000080")), 0},
        {"64 bits, above in byte 7", DRIVE(OBJECT("LINT", "64", WIDE), "", INIT("#x8001", "0900000000000041")), 0},
        {"a list of two elements", DRIVE(OBJECT("LIST2", "96", ""), "", INIT("#x8001", "080008000102030405060708")), 0},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        made_t m = make_text(rows[i].what, rows[i].text);
        if ((find(&m, 0x8001)->flags & (MIN | MAX)) != rows[i].flags)
            fail_msg("%s: expected flags 0x%02X, got 0x%02X", rows[i].what, rows[i].flags, find(&m, 0x8001)->flags);
        assert_null(note_of(&m, "line 2: a start-up command"));
        free_made(&m);
    }
}

/* PDOs of CoE and virtual ones bring no IDN. */
static void telegrams(void **state)
{
#define PDO_OF(index, attributes)                                                                                      \
    "<RxPdo Sm='2'" attributes "><Index>#x" index "</Index><Name>P</Name>" ENTRY("86", "16", "UINT")                   \
        ENTRY("8001", "16", "UINT") "</RxPdo>"
#define INPUTS_OF(index)                                                                                               \
    "<TxPdo Sm='3'><Index>#x" index "</Index><Name>P</Name>" ENTRY("87", "16", "UINT")                                 \
        ENTRY("8001", "16", "UINT") "</TxPdo>"
    static const struct {
        const char *what, *text;
        bool telegram;
    } rows[] = {
        {"SoE", DRIVE("", PDO_OF("0018", ""), "<SoE/>"), true},
        {"an index of CoE without CoE", DRIVE("", PDO_OF("1600", ""), "<SoE/>"), true},
        {"virtual", DRIVE("", PDO_OF("0018", " Virtual='1'"), "<SoE/>"), false},
        {"CoE", DRIVE("", PDO_OF("1600", ""), "<CoE/><SoE/>"), false},
        {"below CoE", DRIVE("", PDO_OF("0018", ""), "<CoE/><SoE/>"), true},
        {"above CoE", DRIVE("", PDO_OF("1800", ""), "<CoE/><SoE/>"), true},
        {"the last below CoE", DRIVE("", PDO_OF("15FF", ""), "<CoE/><SoE/>"), true},
        {"the last of CoE", DRIVE("", PDO_OF("17FF", ""), "<CoE/><SoE/>"), false},
        {"inputs below CoE", DRIVE("", INPUTS_OF("19FF"), "<CoE/><SoE/>"), true},
        {"the first inputs of CoE", DRIVE("", INPUTS_OF("1A00"), "<CoE/><SoE/>"), false},
        {"the last inputs of CoE", DRIVE("", INPUTS_OF("1BFF"), "<CoE/><SoE/>"), false},
        {"inputs above CoE", DRIVE("", INPUTS_OF("1C00"), "<CoE/><SoE/>"), true},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        made_t m = make_text(rows[i].what, rows[i].text);
        if ((ect_soe_find(&soe_of(&m)->drives[0], 0x8001) != NULL) != rows[i].telegram)
            fail_msg("%s: expected P-0-0001 %s", rows[i].what, rows[i].telegram ? "to be there" : "not to be there");
        free_made(&m);
    }
}

static void widths(void **state)
{
    static const struct {
        const char *bits, *type;
        uint32_t attribute;
    } rows[] = {
        {"8", "SINT", ECT_SOE_8 | ECT_SOE_SIGNED},     {"16", "UINT", ECT_SOE_16 | ECT_SOE_UNSIGNED},
        {"32", "REAL", ECT_SOE_32 | ECT_SOE_FLOAT},    {"64", "LINT", ECT_SOE_64 | ECT_SOE_SIGNED},
        {"64", "LREAL", ECT_SOE_64 | ECT_SOE_FLOAT},   {"32", "", ECT_SOE_32 | ECT_SOE_UNSIGNED},
        {"16", "BITS16", ECT_SOE_16 | ECT_SOE_BINARY},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        for (unsigned int tx = 0; tx < 2; tx++) {
            char text[8000];
            (void)snprintf(text, sizeof text,
                           tx != 0 ? DRIVE("", AT(ENTRY("8001", "%s", "%s")), "<SoE/>")
                                   : DRIVE("", MDT(ENTRY("8001", "%s", "%s")), "<SoE/>"),
                           rows[i].bits, rows[i].type);
            made_t m = make_text(rows[i].type, text);
            const ect_soe_idn_t *idn = find(&m, 0x8001);
            const uint32_t attribute = rows[i].attribute | (tx != 0 ? ECT_SOE_READ_ONLY : 0) | 1;
            if (idn->attribute != attribute || idn->flags != (tx != 0 ? ECT_SOE_IN_AT : ECT_SOE_IN_MDT))
                fail_msg("%s: expected attribute 0x%08X, got 0x%08X with flags 0x%02X", rows[i].type,
                         (unsigned int)attribute, (unsigned int)idn->attribute, idn->flags);
            assert_string_equal(idn->name, "V");
            free_made(&m);
        }
    }
}

/* The words are binary numbers, whatever the types of the file, and no choice of the lists. */
static void words_of_telegrams(void **state)
{
    (void)state;
    made_t m = make_text("words", DRIVE("", MDT("") AT(""), "<SoE/>"));
    assert_int_equal(find(&m, 134)->attribute, ECT_SOE_16 | ECT_SOE_BINARY | 1);
    assert_int_equal(find(&m, 135)->attribute, ECT_SOE_16 | ECT_SOE_BINARY | ECT_SOE_READ_ONLY | 1);
    for (uint16_t idn = 134; idn <= 135; idn++) {
        assert_int_equal(find(&m, idn)->flags, 0);
        assert_int_not_equal(find(&m, idn)->mapping, 0);
    }
    free_made(&m);
}

/* A PDO that contradicts the dictionary leaves name, kind, rights and display format of the IDN. */
static void contradictions(void **state)
{
#define MAPPED_AS(mapping, attribute)                                                                                  \
    "<Flags><PdoMapping>" mapping "</PdoMapping><Attribute>#x" attribute "</Attribute></Flags>"
#define LIMITED INFO("<MinValue>2</MinValue><MaxValue>9</MaxValue><DefaultValue>5</DefaultValue>")
    static const struct {
        const char *what, *text;
        uint32_t attribute;
        uint8_t flags;
    } rows[] = {
        {"a wider value",
         DRIVE(OBJECT("UINT", "16", LIMITED MAPPED_AS("T", "62110003")), MDT(ENTRY("8001", "32", "DINT")), "<SoE/>"),
         0x62120003, ECT_SOE_IN_AT | ECT_SOE_IN_MDT},
        {"a narrower value",
         DRIVE(OBJECT("DINT", "32", LIMITED MAPPED_AS("", "62220003")), AT(ENTRY("8001", "8", "USINT")), "<SoE/>"),
         0x62200003, ECT_SOE_IN_AT},
        {"a list",
         DRIVE(OBJECT("LIST2", "96", INFO("<DefaultData>0400080001020304</DefaultData>") MAPPED_AS("T", "00360002")),
               MDT(ENTRY("8001", "16", "UINT")), "<SoE/>"),
         0x00310002, ECT_SOE_IN_MDT},
        {"a command",
         DRIVE(OBJECT("UINT", "16", MAPPED_AS("T", "000A0001")), MDT(ENTRY("8001", "16", "UINT")), "<SoE/>"),
         0x00010001, ECT_SOE_IN_MDT},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        made_t m = make_text(rows[i].what, rows[i].text);
        const ect_soe_idn_t *idn = find(&m, 0x8001);
        if (idn->attribute != rows[i].attribute || idn->flags != rows[i].flags)
            fail_msg("%s: expected attribute 0x%08X and flags 0x%02X, got 0x%08X and 0x%02X", rows[i].what,
                     (unsigned int)rows[i].attribute, rows[i].flags, (unsigned int)idn->attribute, idn->flags);
        assert_string_equal(idn->name, "N");
        assert_true(idn->initial == 0 && idn->minimum == 0 && idn->maximum == 0 && idn->size == 0 && idn->used == 0);
        free_made(&m);
    }
}

/* The fourth hexadecimal digit of a telegram's number is its drive, if the device has it. */
static void drives_of_telegrams(void **state)
{
    static const struct {
        const char *index, *channels;
        uint8_t drive;
    } rows[] = {{"0010", "1", 0}, {"1010", "2", 1}, {"7010", "8", 7}, {"8010", "8", 0}, {"1010", "1", 0},
                {"15FF", "2", 1}, {"1600", "2", 0}, {"25FF", "3", 2}, {"2600", "3", 0}, {"2010", "2", 0}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char text[8000];
        (void)snprintf(text, sizeof text,
                       DRIVE("",
                             "<TxPdo Sm='3'><Index>#x%s</Index><Name>AT</Name>" ENTRY("87", "16", "UINT")
                                 ENTRY("8001", "16", "UINT") "</TxPdo>",
                             "<SoE ChannelCount='%s'/>"),
                       rows[i].index, rows[i].channels);
        made_t m = make_text(rows[i].index, text);
        const ect_soe_t *soe = soe_of(&m);
        for (uint8_t drive = 0; drive < soe->drive_count; drive++) {
            if ((ect_soe_find(&soe->drives[drive], 0x8001) != NULL) != (drive == rows[i].drive))
                fail_msg("PDO %s of %s drives: expected a telegram of drive %u", rows[i].index, rows[i].channels,
                         rows[i].drive);
        }
        free_made(&m);
    }
}

static void numbers_of_drives(void **state)
{
    static const struct {
        const char *channels;
        unsigned int drives;
        const char *note;
    } rows[] = {{"0", 1, NULL}, {"1", 1, NULL}, {"2", 2, NULL},
                {"7", 7, NULL}, {"8", 8, NULL}, {"9", 8, "it has 9 drives; SoE reaches 8"}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char text[8000];
        (void)snprintf(text, sizeof text, DRIVE(OBJECT("UINT", "16", ""), "", "<SoE ChannelCount='%s'/>"),
                       rows[i].channels);
        made_t m = make_text(rows[i].channels, text);
        const ect_soe_t *soe = soe_of(&m);
        assert_int_equal(soe->drive_count, rows[i].drives);
        for (unsigned int drive = 0; drive < rows[i].drives; drive++) {
            assert_int_equal(soe->drives[drive].count, 11); /* P-0-0001 and ten standard parameters */
            assert_non_null(ect_soe_find(&soe->drives[drive], 0x8001));
        }
        expect_note(rows[i].channels, &m, rows[i].note);
        free_made(&m);
    }
}

/* --- standard parameters ------------------------------------------------------------------------------------------ */

#define LIST_OF_IDNS (ECT_SOE_16 | ECT_SOE_LIST | ECT_SOE_IDNS | 1u)
#define IN_PREOP     (ECT_SOE_LOCK_SAFEOP | ECT_SOE_LOCK_OP)

static void expect_row(const char *what, const ect_soe_idn_t *idn, uint32_t attribute, uint16_t size, uint16_t used)
{
    if (idn->attribute != attribute || idn->size != size || idn->used != used)
        fail_msg("%s, IDN %u: expected attribute 0x%08X, %u of %u bytes, got 0x%08X, %u of %u", what, idn->idn,
                 (unsigned int)attribute, used, size, (unsigned int)idn->attribute, idn->used, idn->size);
}

static void standard_ones(void **state)
{
    static const struct {
        uint16_t idn;
        uint32_t attribute;
        uint16_t size;
        uint64_t initial;
        const char *name;
    } rows[] = {
        {15, ECT_SOE_16 | IN_PREOP | 1, 0, 7, "Telegram type"},
        {16, LIST_OF_IDNS | IN_PREOP, 0, 0, "Configuration list of the AT"},
        {17, LIST_OF_IDNS | ECT_SOE_READ_ONLY, 0, 0, "IDN list of all operation data"},
        {21, LIST_OF_IDNS | ECT_SOE_READ_ONLY, 64, 0, "IDN list of invalid operation data for SAFEOP"},
        {22, LIST_OF_IDNS | ECT_SOE_READ_ONLY, 64, 0, "IDN list of invalid operation data for OP"},
        {24, LIST_OF_IDNS | IN_PREOP, 0, 0, "Configuration list of the MDT"},
        {32, ECT_SOE_16 | IN_PREOP | 1, 0, 1, "Primary operation mode"},
        {99, ECT_SOE_16 | ECT_SOE_COMMAND | 1, 0, 0, "Reset class 1 diagnostic"},
        {187, LIST_OF_IDNS | ECT_SOE_READ_ONLY, 0, 0, "IDN list of configurable data in the AT"},
        {188, LIST_OF_IDNS | ECT_SOE_READ_ONLY, 0, 0, "IDN list of configurable data in the MDT"},
    };
    (void)state;
    made_t m = make_text("standard parameters", DRIVE("", "", "<SoE/>"));
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const ect_soe_idn_t *idn = find(&m, rows[i].idn);
        expect_row("standard parameters", idn, rows[i].attribute, rows[i].size, 0);
        assert_string_equal(idn->name, rows[i].name);
        assert_int_equal(idn->initial, rows[i].initial);
        assert_int_equal(idn->flags, 0);
    }
    free_made(&m);
}

/* The dictionary keeps its name, rights and display format; kind, width and content are those of the standard. */
static void forced(void **state)
{
    static const struct {
        const char *what, *text;
        uint16_t idn;
        uint32_t attribute;
        uint16_t size;
        uint64_t initial;
    } rows[] = {
#define OF(index, attribute, type, bits)                                                                               \
    DRIVE(OBJECT_AT(index, type, bits, INFO("<DefaultData>0400080001020304</DefaultData>") ATTRIBUTE(attribute)), "",  \
          "<SoE/>")
        {"a telegram type of 32 bits", OF("000F", "00120002", "DINT", "32"), 15, 0x00110002, 0, 7},
        {"a list of all IDNs with content", OF("0011", "00350002", "LIST2", "96"), 17, 0x00350002, 0, 0},
        {"a list of errors that is a number", OF("0015", "00320002", "DINT", "32"), 21, 0x00350002, 64, 0x00080004},
        {"a list of errors of the dictionary", OF("0016", "00350002", "LIST2", "96"), 22, 0x00350002, 64, 0},
        {"an operation mode of 32 bits", OF("0020", "00120002", "DINT", "32"), 32, 0x00120002, 0, 0x00080004},
        {"a reset that is no command", OF("0063", "00120002", "DINT", "32"), 99, 0x00190002, 0, 0x00080004},
        {"a list of the AT that is a number", OF("0010", "00320002", "DINT", "32"), 16, 0x00350002, 0, 0x00080004},
        {"a list of the MDT with content", OF("0018", "00360002", "LIST2", "96"), 24, 0x00350002, 0, 0},
        {"a list of choices of 32 bits", OF("00BB", "00360002", "LIST2", "96"), 187, 0x00350002, 0, 0},
#undef OF
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        made_t m = make_text(rows[i].what, rows[i].text);
        const ect_soe_idn_t *idn = find(&m, rows[i].idn);
        const bool mode = rows[i].idn == 32;
        expect_row(rows[i].what, idn, rows[i].attribute, rows[i].size, 0);
        assert_string_equal(idn->name, "N");
        assert_true(idn->content == NULL || rows[i].idn == 16 || rows[i].idn == 24); /* set with the telegrams */
        if (idn->initial != rows[i].initial || idn->flags != (mode ? ECT_SOE_DEFAULT : 0))
            fail_msg("%s: expected the value %u, got %u with flags 0x%02X", rows[i].what, (unsigned int)rows[i].initial,
                     (unsigned int)idn->initial, idn->flags);
        free_made(&m);
    }
}

/* The lists of telegrams have room for all numbers that may be in the telegram, of their own drive and direction. */
static void rooms(void **state)
{
#define MAPPED(index, mapping) OBJECT_AT(index, "UINT", "16", "<Flags><PdoMapping>" mapping "</PdoMapping></Flags>")
    static const struct {
        const char *what, *text;
        uint16_t at_size, at_used, mdt_size, mdt_used;
        const char *at, *mdt;
    } rows[] = {
        {"two of three",
         DRIVE(MAPPED("8002", "T") MAPPED("8003", "T") MAPPED("8004", "T") MAPPED("8005", "R"),
               AT(ENTRY("8003", "16", "UINT") ENTRY("8002", "16", "UINT")), "<SoE/>"),
         6, 4, 2, 0, "\x03\x80\x02\x80", ""},
        {"both directions",
         DRIVE(MAPPED("8002", "RT"), AT(ENTRY("8002", "16", "UINT")) MDT(ENTRY("8002", "16", "UINT")), "<SoE/>"), 2, 2,
         2, 2, "\x02\x80", "\x02\x80"},
        {"one value twice", DRIVE("", MDT(ENTRY("8002", "16", "UINT") ENTRY("8002", "16", "UINT")), "<SoE/>"), 0, 0, 4,
         4, "", "\x02\x80\x02\x80"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        made_t m = make_text(rows[i].what, rows[i].text);
        expect_row(rows[i].what, find(&m, 16), LIST_OF_IDNS | IN_PREOP, rows[i].at_size, rows[i].at_used);
        expect_row(rows[i].what, find(&m, 24), LIST_OF_IDNS | IN_PREOP, rows[i].mdt_size, rows[i].mdt_used);
        assert_memory_equal(find(&m, 16)->content, rows[i].at, rows[i].at_used);
        assert_memory_equal(find(&m, 24)->content, rows[i].mdt, rows[i].mdt_used);
        free_made(&m);
    }
}

/* The first PDO of a direction that begins with its word, and has at most 64 values, is the list. */
static void first_listed(void **state)
{
#define FOUR(text) text text text text
#define VALUE      ENTRY("8002", "16", "UINT")
    static const struct {
        const char *what, *text;
        uint16_t list, used;
    } rows[] = {
        {"64 values", DRIVE("", MDT(FOUR(FOUR(FOUR(VALUE)))), "<SoE/>"), 24, 128},
        {"65 values", DRIVE("", MDT(FOUR(FOUR(FOUR(VALUE))) VALUE), "<SoE/>"), 24, 0},
        {"two PDOs", DRIVE("", MDT(VALUE) PDO_OF("0019", ""), "<SoE/>"), 24, 2},
        {"a PDO without its word first",
         DRIVE("", "<RxPdo Sm='2'><Index>#x0017</Index><Name>P</Name>" VALUE "</RxPdo>" MDT(VALUE VALUE), "<SoE/>"), 24,
         4},
        {"inputs with the control word",
         DRIVE("", "<TxPdo Sm='3'><Index>#x0010</Index><Name>P</Name>" ENTRY("86", "16", "UINT") VALUE "</TxPdo>",
               "<SoE/>"),
         16, 0},
        {"outputs with the status word",
         DRIVE("", "<RxPdo Sm='2'><Index>#x0018</Index><Name>P</Name>" ENTRY("87", "16", "UINT") VALUE "</RxPdo>",
               "<SoE/>"),
         24, 0},
        {"inputs with both words", DRIVE("", AT(VALUE ENTRY("86", "16", "UINT")), "<SoE/>"), 16, 0},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        made_t m = make_text(rows[i].what, rows[i].text);
        if (find(&m, rows[i].list)->used != rows[i].used)
            fail_msg("%s: expected %u bytes in S-0-%04u, got %u", rows[i].what, rows[i].used, rows[i].list,
                     find(&m, rows[i].list)->used);
        free_made(&m);
    }
}

/* @return a file whose drive has `count` numbers for the AT, beside objects of CoE; to be freed */
static char *many_values(size_t count, const char *beside)
{
    const size_t room = 8000 + 250 * count;
    char *objects = malloc(room), *text = malloc(room);
    size_t length = 0;
    assert_true(objects != NULL && text != NULL);
    for (size_t i = 0; i < count; i++)
        length += (size_t)snprintf(objects + length, room - length,
                                   OBJECT_AT("%zX", "UINT", "16", MAPPED_AS("T", "00110001")), 0x8001 + i);
    (void)snprintf(text, room, DRIVE_BESIDE("%s", "%s", "", "<CoE/><SoE/>"), beside, objects);
    free(objects);
    return text;
}

/* The list of a telegram has room for 64 values at most. */
static void most_room(void **state)
{
    static const struct {
        size_t values;
        uint16_t size;
    } rows[] = {{63, 126}, {64, 128}, {65, 128}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char *text = many_values(rows[i].values, "");
        made_t m = make_text("many values", text);
        assert_int_equal(find(&m, 16)->size, rows[i].size);
        assert_int_equal(find(&m, 24)->size, 0);
        free_made(&m);
        free(text);
    }
}

/* A SyncManager has room for all values that its telegrams may have, with a word of each drive, within 8 KB. */
static void room_of_telegrams(void **state)
{
#define WIDE_ONE(index, mapping) OBJECT_AT(index, "DINT", "32", "<Flags><PdoMapping>" mapping "</PdoMapping></Flags>")
#define AT_THE_END                                                                                                     \
    ESI_DEVICE("<Profile><Dictionary>" TYPES "<Objects>" MAPPED("8002", "T") MAPPED("8003", "T")                       \
                   WIDE_ONE("8004", "T") "</Objects></Dictionary></Profile>" ESI_MAILBOX_SMS                           \
                                         "<Sm StartAddress='#x1100' ControlByte='#x24' Enable='1'>Outputs</Sm>"        \
                                         "<Sm StartAddress='#x2FEE' ControlByte='#x20' Enable='1'>Inputs</Sm>" AT(     \
                                             ENTRY("8002", "16", "UINT")) "<Mailbox><SoE/></Mailbox>" ESI_EEPROM)
    static const struct {
        const char *what, *text;
        unsigned int outputs, inputs;
    } rows[] = {
        {"words alone", DRIVE("", AT("") MDT(""), "<SoE/>"), 2, 2},
        {"values of the dictionary",
         DRIVE(MAPPED("8002", "T") MAPPED("8003", "T") WIDE_ONE("8004", "T") MAPPED("8005", "R"),
               AT(ENTRY("8002", "16", "UINT")) MDT(""), "<SoE/>"),
         4, 10},
        {"two drives", DRIVE(MAPPED("8002", "T") WIDE_ONE("8004", "RT"), AT("") MDT(""), "<SoE ChannelCount='2'/>"), 12,
         16},
        {"six bytes at the end of 8 KB", AT_THE_END, 0, 6},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        made_t m = make_text(rows[i].what, rows[i].text);
        const ect_sm_t *sm = device_of(&m)->sm;
        if (sm[2].maximum != rows[i].outputs || sm[3].maximum != rows[i].inputs)
            fail_msg("%s: expected at most %u and %u bytes, got %u and %u", rows[i].what, rows[i].outputs,
                     rows[i].inputs, sm[2].maximum, sm[3].maximum);
        free_made(&m);
    }
}

/* Entries of numbers have the free indices from 5000h to 5FFFh. */
static void indices_of_entries(void **state)
{
#define BESIDE(index)                                                                                                  \
    "<Profile><Dictionary>" TYPES "<Objects>" OBJECT_AT(index, "UINT", "16", "") "</Objects></Dictionary></Profile>"
    static const struct {
        size_t values;
        const char *beside;
        uint16_t first, last; /* 0: refused */
    } rows[] = {
        {2, "", 0x5000, 0x5001},
        {2, BESIDE("5000"), 0x5001, 0x5002},
        {3, BESIDE("5001"), 0x5000, 0x5003},
        {4096, "", 0x5000, 0x5FFF},
        {4097, "", 0, 0},
        {4095, BESIDE("5FFF"), 0x5000, 0x5FFE},
        {4096, BESIDE("5FFF"), 0, 0},
        {4096, BESIDE("6000"), 0x5000, 0x5FFF},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char *text = many_values(rows[i].values, rows[i].beside);
        made_t m = try_text(text);
        if ((m.twin != NULL) != (rows[i].first != 0))
            fail_msg("%zu values: expected %s", rows[i].values, rows[i].first != 0 ? m.why : "no twin");
        if (m.twin != NULL) {
            assert_int_equal(find(&m, 0x8001)->mapping, (uint32_t)rows[i].first << 16 | 16);
            assert_int_equal(find(&m, (uint16_t)(0x8000 + rows[i].values))->mapping, (uint32_t)rows[i].last << 16 | 16);
        } else {
            assert_string_equal(m.why, "t.xml:2: DEV: its drives have more than 4096 values for telegrams");
        }
        free_made(&m);
        free(text);
    }
}

/* A number that a telegram may have, in either direction, has an entry with that right; other values have none. */
static void rights_of_entries(void **state)
{
    static const struct {
        const char *type, *bits, *flags;
        uint8_t in;
        uint16_t access; /* 0: no entry */
    } rows[] = {
        {"UINT", "16", MAPPED_AS("T", "00110001"), ECT_SOE_IN_AT, ECT_ACCESS_RO | ECT_ACCESS_TXPDO},
        {"UINT", "16", MAPPED_AS("t", "00110001"), ECT_SOE_IN_AT, ECT_ACCESS_RO | ECT_ACCESS_TXPDO},
        {"UINT", "16", MAPPED_AS("R", "00110001"), ECT_SOE_IN_MDT, ECT_ACCESS_RO | ECT_ACCESS_RXPDO},
        {"UINT", "16", MAPPED_AS("r", "00110001"), ECT_SOE_IN_MDT, ECT_ACCESS_RO | ECT_ACCESS_RXPDO},
        {"UINT", "16", MAPPED_AS("RT", "00110001"), ECT_SOE_IN_AT | ECT_SOE_IN_MDT,
         ECT_ACCESS_RO | ECT_ACCESS_TXPDO | ECT_ACCESS_RXPDO},
        {"UINT", "16", MAPPED_AS("", "00110001"), 0, 0},
        {"LIST2", "96", MAPPED_AS("RT", "00160001"), 0, 0},
        {"UINT", "16", MAPPED_AS("RT", "00090001"), 0, 0},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char text[8000];
        (void)snprintf(text, sizeof text, DRIVE(OBJECT("%s", "%s", "%s"), "", "<SoE/>"), rows[i].type, rows[i].bits,
                       rows[i].flags);
        made_t m = make_text(rows[i].flags, text);
        const ect_od_t od = od_of(&m);
        const ect_soe_idn_t *idn = find(&m, 0x8001);
        const ect_object_t *object = ect_od_find(&od, (uint16_t)(idn->mapping >> 16));
        const ect_entry_t *entry = object != NULL ? ect_od_entry(object, 0) : NULL;
        if (idn->flags != rows[i].in || (entry != NULL ? entry->access : 0) != rows[i].access)
            fail_msg("%s %s: expected flags 0x%02X and rights 0x%03X, got 0x%02X and 0x%03X", rows[i].type,
                     rows[i].flags, rows[i].in, rows[i].access, idn->flags, entry != NULL ? entry->access : 0);
        if (entry != NULL) {
            assert_string_equal(object->name, "N");
            assert_string_equal(entry->name, "N");
        }
        free_made(&m);
    }
}

/* Each IDN that a list of choices names, the first and the last too. */
static void all_choices(void **state)
{
#define NUMBERS OBJECT("UINT", "16", "") OBJECT_AT("8002", "UINT", "16", "") OBJECT_AT("8003", "UINT", "16", "")
#define CHOICES(index, type, attribute, data)                                                                          \
    OBJECT_AT(index, type, "96", INFO("<DefaultData>" data "</DefaultData>") ATTRIBUTE(attribute))
    static const struct {
        const char *what, *text;
        uint8_t flags[3];
    } rows[] = {
        {"of the AT",
         DRIVE(NUMBERS CHOICES("00BB", "LIST2", "00360001", "080008000180090002800380"), "", "<SoE/>"),
         {ECT_SOE_IN_AT, ECT_SOE_IN_AT, ECT_SOE_IN_AT}},
        {"of the MDT",
         DRIVE(NUMBERS CHOICES("00BC", "LIST2", "00360001", "08000800018009000280FFFF"), "", "<SoE/>"),
         {ECT_SOE_IN_MDT, ECT_SOE_IN_MDT, 0}},
        {"an odd number of bytes",
         DRIVE(NUMBERS CHOICES("00BB", "LIST2", "00340001", "03000800028001"), "", "<SoE/>"),
         {0, ECT_SOE_IN_AT, 0}},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        made_t m = make_text(rows[i].what, rows[i].text);
        for (uint16_t k = 0; k < 3; k++) {
            if (find(&m, (uint16_t)(0x8001 + k))->flags != rows[i].flags[k])
                fail_msg("%s: expected flags 0x%02X of P-0-%04u, got 0x%02X", rows[i].what, rows[i].flags[k], k + 1u,
                         find(&m, (uint16_t)(0x8001 + k))->flags);
        }
        free_made(&m);
    }
}

/* A number of a telegram has an entry from 5000h on, which has its default. */
static void entries(void **state)
{
    static const struct {
        const char *bits, *type, *data;
        uint16_t code;
        uint64_t initial;
    } rows[] = {
        {"8", "USINT", "81", ECT_TYPE_UNSIGNED8, 0x81},
        {"16", "INT", "0180", ECT_TYPE_INTEGER16, 0x8001},
        {"16", "UINT", "FFFF", ECT_TYPE_UNSIGNED16, 0xFFFF},
        {"32", "DINT", "03000080", ECT_TYPE_INTEGER32, 0x80000003},
        {"32", "REAL", "0100803F", ECT_TYPE_REAL32, 0x3F800001},
        {"64", "LINT", "0102030405060788", ECT_TYPE_INTEGER64, 0x8807060504030201},
        {"64", "LREAL", "010000000000F03F", ECT_TYPE_REAL64, 0x3FF0000000000001},
        {"16", "UINT", "01020304", ECT_TYPE_UNSIGNED16, 0x0201},
        {"8", "SINT", "80", ECT_TYPE_INTEGER8, 0x80},
        {"64", "ULINT", "FFFFFFFFFFFFFFFF", ECT_TYPE_UNSIGNED64, UINT64_MAX},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char text[8000];
        (void)snprintf(
            text, sizeof text,
            DRIVE(OBJECT("%s", "%s", INFO("<DefaultData>%s</DefaultData>")), MDT(ENTRY("8001", "%s", "%s")), "<SoE/>"),
            rows[i].type, rows[i].bits, rows[i].data, rows[i].bits, rows[i].type);
        made_t m = make_text(rows[i].type, text);
        static uint64_t memory[16384];
        assert_true(device_of(&m)->instance_size <= sizeof memory);
        memset(memory, 0, sizeof memory);
        const ect_od_t od = ect_device_od(device_of(&m), memory);
        ect_od_set_defaults(&od);
        const ect_soe_idn_t *idn = find(&m, 0x8001);
        const ect_entry_t *entry = ect_od_entry(ect_od_find(&od, (uint16_t)(idn->mapping >> 16)), 0);
        uint8_t bytes[8] = {0};
        assert_non_null(entry);
        assert_in_range(idn->mapping >> 16, 0x5000, 0x5FFF);
        ect_od_read(&od, entry, 0, bytes, ect_od_bytes(entry));
        const uint64_t got = ect_load_le32(bytes) | (uint64_t)ect_load_le32(bytes + 4) << 32;
        if (entry->data_type != rows[i].code || got != rows[i].initial || idn->initial != rows[i].initial)
            fail_msg("%s: expected type %04X with the default %llX, got %04X with %llX", rows[i].type, rows[i].code,
                     (unsigned long long)rows[i].initial, entry->data_type, (unsigned long long)got);
        free_made(&m);
    }
}

/* @return a file of a drive with many long texts and a last one of some length; to be freed */
static char *long_texts(size_t last)
{
    enum { TEXTS = 1022, SIZE = 200 * TEXTS };
    char *objects = malloc(SIZE), *text = malloc(SIZE);
    size_t length = 0;
    assert_true(objects != NULL && text != NULL);
    for (unsigned int i = 0; i < TEXTS; i++)
        length += (size_t)snprintf(objects + length, SIZE - length, OBJECT_AT("%X", "STRING(16384)", "131072", ""),
                                   0x8002 + i);
    (void)snprintf(objects + length, SIZE - length, OBJECT_AT("8001", "STRING(%zu)", "%zu", ""), last, 8 * last);
    (void)snprintf(text, SIZE, DRIVE("%s", "", "<SoE/>"), objects);
    free(objects);
    return text;
}

/* The parameters end with 16 MiB of the instance at the latest. Each text has a place of whole 16 bytes, with its
 * length of two bytes. */
static void most_memory(void **state)
{
    enum { LIMIT = 16 << 20, SHORTEST = 14 };
    (void)state;
    char *text = long_texts(SHORTEST);
    made_t m = make_text("long texts", text);
    const size_t last = SHORTEST + LIMIT - soe_of(&m)->buffer;
    free_made(&m);
    free(text);
    text = long_texts(last);
    m = make_text("16 MiB", text);
    assert_int_equal(soe_of(&m)->buffer, LIMIT);
    free_made(&m);
    free(text);
    text = long_texts(last + 1);
    m = try_text(text);
    assert_null(m.twin);
    assert_string_equal(m.why, "t.xml:2: DEV: its parameters of SoE need more than 16 MiB");
    free_made(&m);
    free(text);
}

/* A drive moves only with a control word and a status word of 16 bits. */
static void words_of_a_drive(void **state)
{
#define PDO_WITH(element, sm, index, entry)                                                                            \
    "<" element " Sm='" sm "'><Index>#x" index "</Index><Name>P</Name>" entry "</" element ">"
#define CONTROL_OF(bits, type) PDO_WITH("RxPdo", "2", "0018", ENTRY("86", bits, type))
#define STATUS_OF(bits, type)  PDO_WITH("TxPdo", "3", "0010", ENTRY("87", bits, type))
    static const struct {
        const char *what, *text;
        bool moves;
    } rows[] = {
        {"both words", DRIVE("", CONTROL_OF("16", "UINT") STATUS_OF("16", "UINT"), "<SoE/>"), true},
        {"no control word", DRIVE("", STATUS_OF("16", "UINT"), "<SoE/>"), false},
        {"no status word", DRIVE("", CONTROL_OF("16", "UINT"), "<SoE/>"), false},
        {"a control word of 8 bits", DRIVE("", CONTROL_OF("8", "USINT") STATUS_OF("16", "UINT"), "<SoE/>"), false},
        {"a control word of 32 bits", DRIVE("", CONTROL_OF("32", "UDINT") STATUS_OF("16", "UINT"), "<SoE/>"), false},
        {"a status word of 8 bits", DRIVE("", CONTROL_OF("16", "UINT") STATUS_OF("8", "USINT"), "<SoE/>"), false},
        {"a status word of 32 bits", DRIVE("", CONTROL_OF("16", "UINT") STATUS_OF("32", "UDINT"), "<SoE/>"), false},
        {"words in the dictionary alone",
         DRIVE(OBJECT_AT("0086", "UINT", "16", "") OBJECT_AT("0087", "UINT", "16", ""), "", "<SoE/>"), true},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char why[200] = "";
        made_t m = make_text(rows[i].what, rows[i].text);
        assert_true(ect_esi_twin_behave(m.twin, ECT_BEHAVIOUR_BY_FILE, why, sizeof why));
        if ((note_of(&m, "S-0-0134, S-0-0135: axis 1") != NULL) != rows[i].moves)
            fail_msg("%s: expected %s", rows[i].what, rows[i].moves ? "an axis" : "no axis");
        free_made(&m);
    }
}

int main(void)
{
    static const struct CMUnitTest tests[] = {
        {"SOE-011 SOE-045: attribute and length of an IDN of the dictionary", shapes, NULL, NULL, NULL},
        {"SOE-045: limits of an IDN, where the default is within them", limits, NULL, NULL, NULL},
        {"SOE-045 SOE-046: a contradiction of the file is a note with its line", mistakes, NULL, NULL, NULL},
        {"SOE-046: an IDN that a start-up command adds", added_by_a_command, NULL, NULL, NULL},
        {"SOE-046: an IDN can be written in the states of its start-up command", opened_by_a_command, NULL, NULL, NULL},
        {"SOE-044: the operation mode is that of the set value in the telegram", modes, NULL, NULL, NULL},
        {"SOE-034: the IDNs that S-0-0187 of the dictionary names may be in the AT", choices, NULL, NULL, NULL},
        {"SOE-034: IDNs that may not be in the AT", no_choices, NULL, NULL, NULL},
        {"SOE-046: a start-up command removes the limits that its value exceeds", limits_and_commands, NULL, NULL,
         NULL},
        {"SOE-036: PDOs that are telegrams", telegrams, NULL, NULL, NULL},
        {"SOE-037: the width and kind of a value that a telegram alone has", widths, NULL, NULL, NULL},
        {"SOE-037: the words of telegrams without a dictionary are binary numbers", words_of_telegrams, NULL, NULL,
         NULL},
        {"SOE-045: a value whose length in a PDO is not that of the dictionary", contradictions, NULL, NULL, NULL},
        {"SOE-036: the drive of a telegram is a digit of its number", drives_of_telegrams, NULL, NULL, NULL},
        {"a device has one to eight drives, each with the parameters of the dictionary", numbers_of_drives, NULL, NULL,
         NULL},
        {"SOE-036: the first PDO with the word and at most 64 values is the list", first_listed, NULL, NULL, NULL},
        {"SOE-036: the lists of telegrams have room for at most 64 values", most_room, NULL, NULL, NULL},
        {"SOE-036: SyncManagers have room for all values of their telegrams", room_of_telegrams, NULL, NULL, NULL},
        {"SOE-037: up to 4096 values of telegrams have the free entries from 5000h on", indices_of_entries, NULL, NULL,
         NULL},
        {"SOE-037: entries have the directions that the dictionary gives a number", rights_of_entries, NULL, NULL,
         NULL},
        {"SOE-034: lists of choices name numbers from the first to the last", all_choices, NULL, NULL, NULL},
        {"SOE-046: a start-up command adds at most 16384 bytes", longest_command, NULL, NULL, NULL},
        {"SOE-036: the list of a telegram is that of a PDO of words and values", unlisted, NULL, NULL, NULL},
        {"the standard parameters of a drive that describes none", standard_ones, NULL, NULL, NULL},
        {"SOE-045: the shape of a standard parameter that the dictionary describes in another way", forced, NULL, NULL,
         NULL},
        {"SOE-036: content and room of the lists of telegrams", rooms, NULL, NULL, NULL},
        {"SOE-045: the entry of a number in a telegram has its type and default", entries, NULL, NULL, NULL},
        {"parameters of SoE that need 16 MiB, and more", most_memory, NULL, NULL, NULL},
        {"words that make a drive of SoE move", words_of_a_drive, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests_name("parameters of SoE drives in ESI files", tests, NULL, NULL);
}
