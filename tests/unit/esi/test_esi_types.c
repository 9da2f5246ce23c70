/* SPDX-License-Identifier: MIT */
/* Names of data types: conversion to types of entries, and back. */
#include "esi/types.h"
#include "esi/values.h"
#include "from_text.h"
#include "od/od.h"

#define TYPE(name, rest) "<DataType><Name>" name "</Name>" rest "</DataType>"

/* Types of a dictionary, each of another shape. */
static const char dictionary[] = ESI_DEVICE(
    "<Profile><Dictionary><DataTypes>" TYPE("USINT", "<BitSize>8</BitSize>") TYPE("INT", "<BitSize>16</BitSize>") TYPE(
        "WORDS", "<BaseType>UINT</BaseType><BitSize>48</BitSize><ArrayInfo><LBound>0</LBound><Elements>3</Elements>"
                 "</ArrayInfo>") TYPE("ALIAS", "<BaseType>DINT</BaseType><BitSize>32</BitSize>")
        TYPE("ALIAS2", "<BaseType>ALIAS</BaseType><BitSize>32</BitSize>")
            TYPE("STATE", "<BaseType>USINT</BaseType><BitSize>8</BitSize><EnumInfo><Text>A</Text><Enum>3</Enum>"
                          "</EnumInfo><EnumInfo><Text>B</Text><Enum>-1</Enum></EnumInfo><EnumInfo><Text>C</Text><Enum>7"
                          "</Enum></EnumInfo>") TYPE("LOOP", "<BaseType>LOOP</BaseType><BitSize>16</BitSize>")
                TYPE("RING1", "<BaseType>RING2</BaseType><BitSize>32</BitSize>") TYPE(
                    "RING2", "<BaseType>RING1</BaseType><BitSize>32</BitSize>") TYPE("OWN24", "<BitSize>24</BitSize>")
                    TYPE("OWN5", "<BitSize>5</BitSize>") TYPE("OWN64", "<BitSize>64</BitSize>")
                        TYPE("OWN32", "<BitSize>32</BitSize>") TYPE("NOTHING", "")
                            TYPE("RECORD", "<BitSize>24</BitSize><SubItem><SubIdx>0</SubIdx><Name>N</Name><Type>"
                                           "USINT</Type><BitSize>8</BitSize><BitOffs>0</BitOffs></SubItem>")
                                TYPE("TWICE", "<BitSize>8</BitSize>") TYPE("TWICE", "<BitSize>16</BitSize>")
                                    TYPE("UINT", "<BitSize>16</BitSize>") "</DataTypes></Dictionary></Profile>");

static void resolves(void **state)
{
    static const struct {
        const char *name;
        uint32_t bits;
        uint16_t code; /* ECT_TYPE_NONE: it does not resolve */
        uint32_t expected;
    } table[] = {
        /* names of IEC 61131 */
        {"BOOL", 0, ECT_TYPE_BOOLEAN, 1},
        {"BIT", 0, ECT_TYPE_BIT1, 1},
        {"SINT", 0, ECT_TYPE_INTEGER8, 8},
        {"INT", 0, ECT_TYPE_INTEGER16, 16},
        {"DINT", 0, ECT_TYPE_INTEGER32, 32},
        {"LINT", 0, ECT_TYPE_INTEGER64, 64},
        {"USINT", 0, ECT_TYPE_UNSIGNED8, 8},
        {"UINT", 0, ECT_TYPE_UNSIGNED16, 16},
        {"UDINT", 0, ECT_TYPE_UNSIGNED32, 32},
        {"ULINT", 0, ECT_TYPE_UNSIGNED64, 64},
        {"BYTE", 0, ECT_TYPE_UNSIGNED8, 8},
        {"WORD", 0, ECT_TYPE_UNSIGNED16, 16},
        {"DWORD", 0, ECT_TYPE_UNSIGNED32, 32},
        {"LWORD", 0, ECT_TYPE_UNSIGNED64, 64},
        {"REAL", 0, ECT_TYPE_REAL32, 32},
        {"LREAL", 0, ECT_TYPE_REAL64, 64},
        {"TIME", 0, ECT_TYPE_UNSIGNED32, 32},
        {"BITARR8", 0, ECT_TYPE_BITARR8, 8},
        {"BITARR16", 0, ECT_TYPE_BITARR16, 16},
        {"BITARR32", 0, ECT_TYPE_BITARR32, 32},
        {"UINT8", 0, ECT_TYPE_UNSIGNED8, 8},
        {"UINT16", 0, ECT_TYPE_UNSIGNED16, 16},
        {"UINT32", 0, ECT_TYPE_UNSIGNED32, 32},
        {"UINT64", 0, ECT_TYPE_UNSIGNED64, 64},
        {"INT8", 0, ECT_TYPE_INTEGER8, 8},
        {"INT16", 0, ECT_TYPE_INTEGER16, 16},
        {"INT32", 0, ECT_TYPE_INTEGER32, 32},
        {"INT64", 0, ECT_TYPE_INTEGER64, 64},
        /* names with a length in them */
        {"BIT1", 0, ECT_TYPE_BIT1, 1},
        {"BIT2", 0, ECT_TYPE_BIT1 + 1, 2},
        {"BIT8", 0, ECT_TYPE_BIT8, 8},
        {"BIT0", 0, ECT_TYPE_NONE, 0},
        {"BIT9", 0, ECT_TYPE_NONE, 0},
        {"STRING(1)", 0, ECT_TYPE_VISIBLE_STRING, 8},
        {"STRING(80)", 0, ECT_TYPE_VISIBLE_STRING, 640},
        {"STRING(65535)", 0, ECT_TYPE_VISIBLE_STRING, 524280},
        {"STRING(65536)", 0, ECT_TYPE_NONE, 0},
        {"STRING(0)", 0, ECT_TYPE_NONE, 0},
        {"STRING", 0, ECT_TYPE_NONE, 0},
        {"ARRAY [0..7] OF BYTE", 0, ECT_TYPE_OCTET_STRING, 64},
        {"ARRAY [1..4] OF BYTE", 0, ECT_TYPE_OCTET_STRING, 32},
        {"ARRAY [0..0] OF BYTE", 0, ECT_TYPE_OCTET_STRING, 8},
        {"ARRAY [0..1] OF UDINT", 0, ECT_TYPE_OCTET_STRING, 64},
        {"ARRAY [0..9] OF BIT", 0, ECT_TYPE_OCTET_STRING, 16},
        {"ARRAY [3..2] OF BYTE", 0, ECT_TYPE_NONE, 0},
        {"ARRAY [0..65535] OF BYTE", 0, ECT_TYPE_NONE, 0},
        {"ARRAY [0..65534] OF BYTE", 0, ECT_TYPE_OCTET_STRING, 524280},
        {"ARRAY [0..3] OF NONE", 0, ECT_TYPE_NONE, 0},
        {"ARRAY [0..3] OF RECORD", 0, ECT_TYPE_NONE, 0},
        /* the place has another length than the name */
        {"UINT", 16, ECT_TYPE_UNSIGNED16, 16},
        {"UINT", 8, ECT_TYPE_UNSIGNED8, 8},
        {"USINT", 3, ECT_TYPE_BIT1 + 2, 3},
        {"BOOL", 8, ECT_TYPE_UNSIGNED8, 8},
        {"DINT", 24, ECT_TYPE_OCTET_STRING, 24},
        {"UDINT", 64, ECT_TYPE_UNSIGNED64, 64},
        {"REAL", 16, ECT_TYPE_UNSIGNED16, 16},
        {"BIT2", 4, ECT_TYPE_BIT1 + 3, 4},
        {"STRING(4)", 64, ECT_TYPE_VISIBLE_STRING, 64},
        {"ARRAY [0..3] OF BYTE", 16, ECT_TYPE_OCTET_STRING, 16},
        {"ARRAY [0..3] OF BYTE", 12, ECT_TYPE_OCTET_STRING, 16},
        {"", 1, ECT_TYPE_BIT1, 1},
        {"", 7, ECT_TYPE_BIT1 + 6, 7},
        {"", 8, ECT_TYPE_UNSIGNED8, 8},
        {"", 9, ECT_TYPE_OCTET_STRING, 16},
        {"", 16, ECT_TYPE_UNSIGNED16, 16},
        {"", 32, ECT_TYPE_UNSIGNED32, 32},
        {"", 40, ECT_TYPE_OCTET_STRING, 40},
        {"", 64, ECT_TYPE_UNSIGNED64, 64},
        {"", 65, ECT_TYPE_OCTET_STRING, 72},
        {"", 0, ECT_TYPE_NONE, 0},
        {"WHATEVER", 32, ECT_TYPE_UNSIGNED32, 32},
        /* types of the dictionary */
        {"WORDS", 0, ECT_TYPE_OCTET_STRING, 48},
        {"ALIAS", 0, ECT_TYPE_INTEGER32, 32},
        {"ALIAS2", 0, ECT_TYPE_INTEGER32, 32},
        {"STATE", 0, ECT_TYPE_UNSIGNED8, 8},
        {"LOOP", 0, ECT_TYPE_UNSIGNED16, 16},
        {"RING1", 0, ECT_TYPE_UNSIGNED32, 32},
        {"OWN5", 0, ECT_TYPE_BIT1 + 4, 5},
        {"OWN24", 0, ECT_TYPE_OCTET_STRING, 24},
        {"OWN32", 0, ECT_TYPE_UNSIGNED32, 32},
        {"OWN64", 0, ECT_TYPE_UNSIGNED64, 64},
        {"NOTHING", 0, ECT_TYPE_NONE, 0},
        {"NOTHING", 16, ECT_TYPE_UNSIGNED16, 16},
        {"RECORD", 0, ECT_TYPE_NONE, 0},
        {"RECORD", 24, ECT_TYPE_NONE, 0},
        {"TWICE", 0, ECT_TYPE_UNSIGNED8, 8},
    };
    (void)state;
    made_t m = make_text("types", dictionary);
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        ect_esi_basic_t basic;
        bool good = ect_esi_resolve(&m.model->dictionary, table[i].name, table[i].bits, &basic);
        if (good != (table[i].code != ECT_TYPE_NONE) ||
            (good && (basic.code != table[i].code || basic.bits != table[i].expected)))
            fail_msg("%s with %u bits: expected type %02X, %u bits, got %s %02X, %u", table[i].name,
                     (unsigned int)table[i].bits, table[i].code, (unsigned int)table[i].expected,
                     good ? "type" : "none,", basic.code, (unsigned int)basic.bits);
    }
    free_made(&m);
}

static void without_a_dictionary(void **state)
{
    static const struct {
        const char *name;
        bool good;
    } table[] = {{"UINT", true}, {"STRING(3)", true}, {"BIT3", true}, {"WORDS", false}, {"", false}};
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        ect_esi_basic_t basic;
        if (ect_esi_resolve(NULL, table[i].name, 0, &basic) != table[i].good)
            fail_msg("\"%s\": expected %d", table[i].name, table[i].good);
    }
    assert_null(ect_esi_find_type(NULL, "UINT"));
}

static void enumerations(void **state)
{
    (void)state;
    made_t m = make_text("types", dictionary);
    ect_esi_basic_t basic;
    assert_true(ect_esi_resolve(&m.model->dictionary, "STATE", 0, &basic));
    assert_true(basic.minimum.given && basic.maximum.given);
    assert_int_equal(basic.minimum.value, -1);
    assert_int_equal(basic.maximum.value, 7);
    assert_true(ect_esi_resolve(&m.model->dictionary, "ALIAS", 0, &basic));
    assert_false(basic.minimum.given || basic.maximum.given);
    free_made(&m);
}

/* Looked up by halves: each of them, the neighbours of each, and those before the first and behind the last. */
static void lookup(void **state)
{
    static const char *const names[] = {"ALIAS", "ALIAS2", "INT",   "LOOP",   "NOTHING", "OWN24",
                                        "OWN32", "OWN5",   "OWN64", "RECORD", "RING1",   "RING2",
                                        "STATE", "TWICE",  "UINT",  "USINT",  "WORDS"};
    (void)state;
    made_t m = make_text("types", dictionary);
    const ect_esi_dictionary_t *d = &m.model->dictionary;
    assert_int_equal(d->type_count, sizeof names / sizeof names[0] + 1);
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        char other[16];
        const ect_esi_type_t *type = ect_esi_find_type(d, names[i]);
        if (type == NULL || strcmp(type->name, names[i]) != 0)
            fail_msg("%s: expected to find it, got %s", names[i], type != NULL ? type->name : "nothing");
        (void)snprintf(other, sizeof other, "%s_", names[i]);
        if (ect_esi_find_type(d, other) != NULL)
            fail_msg("%s: expected nothing", other);
    }
    assert_null(ect_esi_find_type(d, ""));
    assert_null(ect_esi_find_type(d, "A"));
    assert_null(ect_esi_find_type(d, "ZZZ"));
    assert_int_equal(ect_esi_find_type(d, "TWICE")->bits, 8);
    free_made(&m);
}

static void names(void **state)
{
    static const struct {
        uint16_t code;
        uint32_t bits;
        const char *name;
    } table[] = {
        {ECT_TYPE_BOOLEAN, 1, "BOOL"},
        {ECT_TYPE_INTEGER8, 8, "SINT"},
        {ECT_TYPE_INTEGER16, 16, "INT"},
        {ECT_TYPE_INTEGER32, 32, "DINT"},
        {ECT_TYPE_INTEGER64, 64, "LINT"},
        {ECT_TYPE_UNSIGNED8, 8, "USINT"},
        {ECT_TYPE_UNSIGNED16, 16, "UINT"},
        {ECT_TYPE_UNSIGNED32, 32, "UDINT"},
        {ECT_TYPE_UNSIGNED64, 64, "ULINT"},
        {ECT_TYPE_REAL32, 32, "REAL"},
        {ECT_TYPE_REAL64, 64, "LREAL"},
        {ECT_TYPE_BITARR8, 8, "BITARR8"},
        {ECT_TYPE_BITARR16, 16, "BITARR16"},
        {ECT_TYPE_BITARR32, 32, "BITARR32"},
        {ECT_TYPE_BIT1, 1, "BIT"},
        {ECT_TYPE_BIT1 + 1, 2, "BIT2"},
        {ECT_TYPE_BIT8, 8, "BIT8"},
        {ECT_TYPE_UNSIGNED8, 5, "BIT5"},
        {ECT_TYPE_VISIBLE_STRING, 8, "STRING(1)"},
        {ECT_TYPE_VISIBLE_STRING, 320, "STRING(40)"},
        {ECT_TYPE_OCTET_STRING, 7, "BIT7"},
        {ECT_TYPE_OCTET_STRING, 8, "ARRAY [0..0] OF BYTE"},
        {ECT_TYPE_OCTET_STRING, 16, "ARRAY [0..1] OF BYTE"},
        {ECT_TYPE_OCTET_STRING, UINT32_MAX - 7, "ARRAY [0..536870910] OF BYTE"},
        {ECT_TYPE_OCTET_STRING, 2040, "ARRAY [0..254] OF BYTE"},
        {ECT_TYPE_UNSIGNED16, 24, "ARRAY [0..2] OF BYTE"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        char text[40];
        const char *name = ect_esi_type_name(table[i].code, table[i].bits, text, sizeof text);
        if (strcmp(name, table[i].name) != 0)
            fail_msg("type %02X of %u bits: expected %s, got %s", table[i].code, (unsigned int)table[i].bits,
                     table[i].name, name);
    }
}

/* A name that is written is read as the same type. */
static void there_and_back(void **state)
{
    static const struct {
        uint16_t code;
        uint32_t bits;
    } table[] = {{ECT_TYPE_BOOLEAN, 1},      {ECT_TYPE_INTEGER8, 8},      {ECT_TYPE_INTEGER16, 16},
                 {ECT_TYPE_INTEGER32, 32},   {ECT_TYPE_INTEGER64, 64},    {ECT_TYPE_UNSIGNED8, 8},
                 {ECT_TYPE_UNSIGNED16, 16},  {ECT_TYPE_UNSIGNED32, 32},   {ECT_TYPE_UNSIGNED64, 64},
                 {ECT_TYPE_REAL32, 32},      {ECT_TYPE_REAL64, 64},       {ECT_TYPE_BITARR8, 8},
                 {ECT_TYPE_BITARR16, 16},    {ECT_TYPE_BITARR32, 32},     {ECT_TYPE_BIT1, 1},
                 {ECT_TYPE_BIT1 + 2, 3},     {ECT_TYPE_BIT8, 8},          {ECT_TYPE_VISIBLE_STRING, 72},
                 {ECT_TYPE_OCTET_STRING, 8}, {ECT_TYPE_OCTET_STRING, 56}, {ECT_TYPE_OCTET_STRING, 8 * 255}};
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        char text[40];
        ect_esi_basic_t basic = {0};
        const char *name = ect_esi_type_name(table[i].code, table[i].bits, text, sizeof text);
        if (!ect_esi_resolve(NULL, name, 0, &basic) || basic.code != table[i].code || basic.bits != table[i].bits)
            fail_msg("%s: expected type %02X of %u bits, got %02X of %u", name, table[i].code,
                     (unsigned int)table[i].bits, basic.code, (unsigned int)basic.bits);
    }
}

/* --- values.h: entries in files ----------------------------------------------------------------------------------- */

static void type_of(void **state)
{
    static const struct {
        uint16_t code;
        uint32_t bits;
        const char *name; /* NULL: there is none */
    } table[] = {
        {ECT_TYPE_UNSIGNED16, 16, "UINT"},
        {ECT_TYPE_BIT1 + 4, 5, "BIT5"},
        {ECT_TYPE_UNSIGNED16, 12, NULL},
        {ECT_TYPE_UNSIGNED16, 9, NULL},
        {ECT_TYPE_UNSIGNED32, 24, "ARRAY [0..2] OF BYTE"},
        {ECT_TYPE_OCTET_STRING, 0, "OCTET_STRING(0)"},
        {ECT_TYPE_VISIBLE_STRING, 80, "STRING(10)"},
        {ECT_TYPE_UNSIGNED8, 8, "USINT"},
        {ECT_TYPE_BOOLEAN, 1, "BOOL"},
        {ECT_TYPE_OCTET_STRING, 8, "ARRAY [0..0] OF BYTE"},
        {ECT_TYPE_OCTET_STRING, UINT32_MAX - 7, "ARRAY [0..536870910] OF BYTE"},
    };
    ect_arena_t arena = {0};
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        const char *name = ect_esi_type_of(&arena, table[i].code, table[i].bits);
        if ((name == NULL) != (table[i].name == NULL) || (name != NULL && strcmp(name, table[i].name) != 0))
            fail_msg("type %02X of %u bits: expected %s, got %s", table[i].code, (unsigned int)table[i].bits,
                     table[i].name ? table[i].name : "none", name ? name : "none");
    }
    ect_arena_free(&arena);
}

static void access_words(void **state)
{
    static const struct {
        uint16_t bits;
        const char *word;
    } table[] = {
        {0, ""},
        {ECT_ACCESS_R_PREOP, "ro"},
        {ECT_ACCESS_R_OP, "ro"},
        {ECT_ACCESS_RO, "ro"},
        {ECT_ACCESS_W_OP, "wo"},
        {ECT_ACCESS_WO, "wo"},
        {ECT_ACCESS_RW, "rw"},
        {ECT_ACCESS_RW_PREOP, "rw"},
        {ECT_ACCESS_R_PREOP | ECT_ACCESS_W_SAFEOP, "rw"},
        {ECT_ACCESS_TXPDO, ""},
        {ECT_ACCESS_RO | ECT_ACCESS_TXPDO | ECT_ACCESS_BACKUP, "ro"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        if (strcmp(ect_esi_access(table[i].bits), table[i].word) != 0)
            fail_msg("%03X: expected \"%s\", got \"%s\"", table[i].bits, table[i].word, ect_esi_access(table[i].bits));
    }
}

static void states_of_restrictions(void **state)
{
    static const struct {
        bool preop, safeop, op;
        const char *word;
    } table[] = {
        {false, false, false, ""},           {true, false, false, "PreOP"}, {false, true, false, "SafeOP"},
        {true, true, false, "PreOP_SafeOP"}, {false, false, true, "OP"},    {true, false, true, "PreOP_OP"},
        {false, true, true, "SafeOP_OP"},    {true, true, true, ""},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++)
        assert_string_equal(ect_esi_states(table[i].preop, table[i].safeop, table[i].op), table[i].word);
}

static void defaults_worth_a_word(void **state)
{
    static const uint8_t zero[4] = {0}, last[4] = {0, 0, 0, 1}, first[4] = {1};
    static const struct {
        const char *what;
        uint16_t access;
        const uint8_t *value;
        size_t size;
        bool expected;
    } table[] = {
        {"a parameter of zero", ECT_ACCESS_RW, zero, 4, true},
        {"a parameter without bytes", ECT_ACCESS_RW, zero, 0, false},
        {"inputs of zero", ECT_ACCESS_RO | ECT_ACCESS_TXPDO, zero, 4, false},
        {"outputs of zero", ECT_ACCESS_RW | ECT_ACCESS_RXPDO, zero, 4, false},
        {"inputs, the last byte set", ECT_ACCESS_RO | ECT_ACCESS_TXPDO, last, 4, true},
        {"inputs, the first byte set", ECT_ACCESS_RO | ECT_ACCESS_TXPDO, first, 4, true},
        {"inputs, without the last byte", ECT_ACCESS_RO | ECT_ACCESS_TXPDO, last, 3, false},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        const ect_entry_t entry = {.access = table[i].access};
        if (ect_esi_has_default(&entry, table[i].value, table[i].size) != table[i].expected)
            fail_msg("%s: expected %d", table[i].what, table[i].expected);
    }
}

/* Objects of a description: whether one line describes all elements, where an entry begins, how long the whole is. */
static void layout_of_objects(void **state)
{
#define E(n, type, bits, rights, text)                                                                                 \
    {.subindex = n, .data_type = type, .bit_length = bits, .access = rights, .name = text}
    static const ect_entry_t var[] = {E(0, ECT_TYPE_UNSIGNED32, 32, ECT_ACCESS_RO, "V")};
    static const ect_entry_t empty[] = {E(0, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, "N")};
    static const ect_entry_t array[] = {
        E(0, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, "N"), E(1, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RW, "A"),
        E(2, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RW, "B"), E(3, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RW, "B")};
    static const ect_entry_t gap[] = {E(0, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, "N"),
                                      E(1, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RW, "A"),
                                      E(3, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RW, "B")};
    static const ect_entry_t types[] = {E(0, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, "N"),
                                        E(1, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RW, "A"),
                                        E(2, ECT_TYPE_INTEGER16, 16, ECT_ACCESS_RW, "B")};
    static const ect_entry_t lengths[] = {E(0, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, "N"),
                                          E(1, ECT_TYPE_VISIBLE_STRING, 16, ECT_ACCESS_RW, "A"),
                                          E(2, ECT_TYPE_VISIBLE_STRING, 24, ECT_ACCESS_RW, "B")};
    static const ect_entry_t rights[] = {E(0, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, "N"),
                                         E(1, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RW, "A"),
                                         E(2, ECT_TYPE_UNSIGNED16, 16, ECT_ACCESS_RO, "B")};
    static const ect_entry_t bits[] = {
        E(0, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, "N"), E(1, ECT_TYPE_BOOLEAN, 1, ECT_ACCESS_RW, "A"),
        E(2, ECT_TYPE_BIT1 + 2, 3, ECT_ACCESS_RW, "B"), E(3, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RW, "C"),
        E(4, ECT_TYPE_UNSIGNED32, 32, ECT_ACCESS_RW, "SubIndex 004")};
    static const ect_entry_t alike[] = {E(0, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, "N"),
                                        E(1, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RW, "SubIndexes")};
    static const struct {
        const char *what;
        uint16_t code;
        const ect_entry_t *entries;
        uint8_t last, max_subindex;
        bool array;
        uint32_t object_bits, last_offset;
        const char *unique; /* of the last entry */
    } table[] = {
        {"a value", ECT_OBJECT_VAR, var, 0, 0, false, 32, 0, "SubIndex 000"},
        {"an empty record", ECT_OBJECT_RECORD, empty, 0, 0, false, 16, 0, "SubIndex 000"},
        {"an array", ECT_OBJECT_ARRAY, array, 3, 3, true, 64, 48, "SubIndex 003"},
        {"a record of alike entries", ECT_OBJECT_RECORD, array, 3, 3, false, 64, 48, "SubIndex 003"},
        {"a gap in it", ECT_OBJECT_ARRAY, gap, 2, 3, false, 48, 32, ""},
        {"two types in it", ECT_OBJECT_ARRAY, types, 2, 2, false, 48, 32, ""},
        {"two lengths in it", ECT_OBJECT_ARRAY, lengths, 2, 2, false, 56, 32, ""},
        {"two rights in it", ECT_OBJECT_ARRAY, rights, 2, 2, false, 48, 32, ""},
        {"an array without elements", ECT_OBJECT_ARRAY, empty, 0, 0, false, 16, 0, "SubIndex 000"},
        {"a name that begins like those of numbers", ECT_OBJECT_RECORD, alike, 1, 1, false, 24, 16, ""},
        {"bits side by side", ECT_OBJECT_RECORD, bits, 4, 4, false, 64, 32, "SubIndex 004"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        const ect_object_t object = {.index = 0x2000,
                                     .object_code = table[i].code,
                                     .max_subindex = table[i].max_subindex,
                                     .last = table[i].last,
                                     .name = "O",
                                     .entries = table[i].entries};
        const ect_od_t od = {.objects = &object, .count = 1};
        const ect_entry_t *last = &table[i].entries[table[i].last];
        ect_item_name_t name = ect_esi_item_name(&object, last);
        if (ect_esi_is_array(&object) != table[i].array)
            fail_msg("%s: expected array %d", table[i].what, table[i].array);
        if (ect_esi_object_bits(&od, &object) != table[i].object_bits)
            fail_msg("%s: expected %u bits, got %u", table[i].what, (unsigned int)table[i].object_bits,
                     (unsigned int)ect_esi_object_bits(&od, &object));
        if (ect_esi_item_offset(&object, last) != table[i].last_offset)
            fail_msg("%s: expected the last at bit %u, got %u", table[i].what, (unsigned int)table[i].last_offset,
                     (unsigned int)ect_esi_item_offset(&object, last));
        if (strcmp(name.unique, table[i].unique) != 0)
            fail_msg("%s: expected \"%s\", got \"%s\"", table[i].what, table[i].unique, name.unique);
    }
#undef E
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"names of IEC 61131, with lengths, of the dictionary, in places of another length", resolves, NULL, NULL,
         NULL},
        {"without a dictionary the basic names resolve", without_a_dictionary, NULL, NULL, NULL},
        {"an enumeration limits its values", enumerations, NULL, NULL, NULL},
        {"a type is found by its name; of two with one name the first", lookup, NULL, NULL, NULL},
        {"each code and length has a name", names, NULL, NULL, NULL},
        {"a name that is written is read as the same type", there_and_back, NULL, NULL, NULL},
        {"numbers without a name of their length have none", type_of, NULL, NULL, NULL},
        {"rights in a word", access_words, NULL, NULL, NULL},
        {"restrictions to AL states in a word", states_of_restrictions, NULL, NULL, NULL},
        {"process data of zero have no default in a file", defaults_worth_a_word, NULL, NULL, NULL},
        {"arrays, offsets, lengths and names of sub-items", layout_of_objects, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
