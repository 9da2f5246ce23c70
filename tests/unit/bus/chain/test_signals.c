/* SPDX-License-Identifier: MIT */
/* A user sets a signal (bus/chain/signals.h, seams/plant.h): the plant checks the value, the value is stored, the
 * plant is notified. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "bus/chain/fields.h"
#include "bus/chain/signals.h"

typedef struct unit {
    uint16_t number;
    char text[9];
    const char *answer; /* of signal_write */
    struct {
        const ect_signal_t *signal;
        uint16_t group_number, number; /* the value as the instance held it */
        uint64_t now_ns;
    } checked, notified;
} unit_t;

static const ect_signal_t signals[] = {
    {"number", "a number", NULL, ECT_SIGNAL_U16, ECT_SIGNAL_WRITE, offsetof(unit_t, number), 0, 40000, 0},
    {"text", "a text", NULL, ECT_SIGNAL_TEXT, ECT_SIGNAL_WRITE, offsetof(unit_t, text), 0, 8, 0},
};
static const ect_signal_group_t groups[] = {
    {.signal_count = 2, .signals = signals},
    {.prefix = "part", .count = 2, .signal_count = 1, .signals = signals},
};

static const char *signal_write(void *instance, const ect_signal_t *signal, uint16_t number, const void *value,
                                uint64_t now_ns)
{
    unit_t *u = instance;
    (void)value;
    u->checked.signal = signal;
    u->checked.group_number = number;
    u->checked.number = u->number;
    u->checked.now_ns = now_ns;
    return u->answer;
}

static void signal_written(void *instance, const ect_signal_t *signal, uint16_t number, uint64_t now_ns)
{
    unit_t *u = instance;
    u->notified.signal = signal;
    u->notified.group_number = number;
    u->notified.number = u->number;
    u->notified.now_ns = now_ns;
}

static bool set(unit_t *u, const ect_plant_t *plant, const char *name, const char *value, char *message)
{
    ect_signal_ref_t ref;
    assert_true(ect_signal_find(plant, u, name, &ref));
    return ect_signal_write(&ref, value, 12345, message);
}

static const ect_plant_t plant = {
    .signal_groups = groups, .signal_group_count = 2, .signal_write = signal_write, .signal_written = signal_written};

static void checked_stored_notified(void **state)
{
    char message[ECT_SIGNAL_MESSAGE];
    unit_t u = {.number = 1};
    (void)state;
    assert_true(set(&u, &plant, "part2.number", "40000", message));
    assert_ptr_equal(u.checked.signal, &signals[0]);
    assert_int_equal(u.checked.group_number, 2);
    assert_int_equal(u.checked.number, 1);
    assert_int_equal(u.checked.now_ns, 12345);
    assert_ptr_equal(u.notified.signal, &signals[0]);
    assert_int_equal(u.notified.group_number, 2);
    assert_int_equal(u.notified.number, 40000);
    assert_int_equal(u.notified.now_ns, 12345);
    assert_true(set(&u, &plant, "text", "12345678", message));
    assert_string_equal(u.text, "12345678");
    assert_ptr_equal(u.notified.signal, &signals[1]);
}

static void done_or_refused(void **state)
{
    static const char *const answers[] = {"", "not now"};
    (void)state;
    for (size_t i = 0; i < 2; i++) {
        char message[ECT_SIGNAL_MESSAGE] = "";
        unit_t u = {.number = 1, .answer = answers[i]};
        assert_int_equal(set(&u, &plant, "number", "2", message), i == 0);
        assert_string_equal(message, i == 0 ? "" : "number: not now");
        assert_ptr_equal(u.checked.signal, &signals[0]);
        assert_int_equal(u.number, 1);
        assert_null(u.notified.signal);
    }
}

static void out_of_range(void **state)
{
    char message[ECT_SIGNAL_MESSAGE];
    unit_t u = {.number = 1};
    (void)state;
    assert_false(set(&u, &plant, "number", "40001", message));
    assert_non_null(strstr(message, "0..40000"));
    assert_null(u.checked.signal);
    assert_null(u.notified.signal);
    assert_int_equal(u.number, 1);
}

static void without_functions(void **state)
{
    static const ect_plant_t silent = {.signal_groups = groups, .signal_group_count = 2};
    char message[ECT_SIGNAL_MESSAGE];
    unit_t u = {.number = 1};
    (void)state;
    assert_true(set(&u, &silent, "number", "2", message));
    assert_int_equal(u.number, 2);
}

/* --- every type ------------------------------------------------------------------------------------------------- */

typedef struct kinds {
    uint8_t yes, u8;
    int8_t i8;
    int16_t i16;
    uint16_t u16;
    int32_t i32;
    uint32_t u32;
    int64_t i64;
    uint64_t u64;
    float real32;
    double real;
    char text[5];
    uint8_t bytes[3];
    uint16_t described;
    char longest[ECT_SIGNAL_LONGEST_TEXT + 1];
    uint8_t most[ECT_SIGNAL_LONGEST_BYTES];
    uint8_t behind; /* of no signal */
} kinds_t;

#define KIND(member, kind, rights, minimum, maximum, unit)                                                             \
    ECT_SIGNAL(kinds_t, member, #member, kind, rights, minimum, maximum, unit, "")

static const ect_signal_t kinds[] = {
    KIND(yes, BOOL, WRITE, 0, 1, NULL),
    KIND(u8, U8, WRITE, 1, 200, NULL),
    KIND(i8, I8, WRITE, -100, 100, "%"),
    KIND(i16, I16, WRITE, -1000, 32767, NULL),
    KIND(u16, U16, WRITE, 0, 65535, NULL),
    KIND(i32, I32, WRITE, INT32_MIN, INT32_MAX, NULL),
    KIND(u32, U32, WRITE, 0, UINT32_MAX, "mm"),
    KIND(i64, I64, WRITE, INT64_MIN, INT64_MAX, "nm"),
    KIND(u64, U64, WRITE, 0, INT64_MAX, NULL),
    KIND(real32, REAL32, WRITE, -2, 3, NULL),
    KIND(real, REAL, WRITE, -2, 3, NULL),
    KIND(text, TEXT, WRITE, 0, 4, NULL),
    KIND(bytes, BYTES, WRITE, 0, 3, NULL),
    KIND(described, DESCRIBED, READ, 0, 20, NULL),
    KIND(longest, TEXT, WRITE, 0, ECT_SIGNAL_LONGEST_TEXT, NULL),
    KIND(most, BYTES, WRITE, 0, ECT_SIGNAL_LONGEST_BYTES, NULL),
};

static void describe(const ect_signal_t *signal, uint16_t value, char *text)
{
    (void)snprintf(text, (size_t)signal->maximum + 1, "number %u", value);
}

static const ect_signal_group_t kinds_group = {.signal_count = sizeof kinds / sizeof kinds[0], .signals = kinds};
static const ect_plant_t kinds_plant = {
    .signal_groups = &kinds_group, .signal_group_count = 1, .signal_describe = describe};

static ect_signal_ref_t kind(kinds_t *k, const char *name)
{
    ect_signal_ref_t ref = {0};
    if (!ect_signal_find(&kinds_plant, k, name, &ref))
        fail_msg("no signal %s", name);
    return ref;
}

static void types(void **state)
{
    static const struct {
        const char *name;
        size_t size;
        bool number;
        const char *range;
    } rows[] = {
        {"yes", 1, true, "0..1"},
        {"u8", 1, true, "1..200"},
        {"i8", 1, true, "-100..100 %"},
        {"i16", 2, true, "-1000..32767"},
        {"u16", 2, true, "0..65535"},
        {"i32", 4, true, "-2147483648..2147483647"},
        {"u32", 4, true, "0..4294967295 mm"},
        {"i64", 8, true, "any number nm"},
        {"u64", 8, true, "0..9223372036854775807"},
        {"real32", 4, true, "-2..3"},
        {"real", 8, true, "-2..3"},
        {"text", 5, false, "up to 4 characters from space to ~"},
        {"bytes", 3, false, "3 bytes, 6 hexadecimal digits"},
        {"described", 2, false, "up to 20 characters from space to ~"},
        {"longest", 128, false, "up to 127 characters from space to ~"},
        {"most", 64, false, "64 bytes, 128 hexadecimal digits"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char range[ECT_SIGNAL_TEXT_ROOM];
        kinds_t k = {0};
        ect_signal_ref_t ref = kind(&k, rows[i].name);
        assert_int_equal(ect_signal_size(ref.signal), rows[i].size);
        assert_int_equal(ect_signal_is_number(ref.signal), rows[i].number);
        ect_signal_range(ref.signal, range);
        assert_string_equal(range, rows[i].range);
    }
}

/* `set` is refused if `read` is NULL. */
static void written_and_read(void **state)
{
    static const struct {
        const char *name, *set, *read;
    } rows[] = {
        {"yes", "1", "1"},
        {"yes", "2", NULL},
        {"yes", "true", NULL},
        {"yes", "", NULL},
        {"yes", "1 ", NULL},
        {"u8", "200", "200"},
        {"u8", "201", NULL},
        {"u8", "1", "1"},
        {"u8", "0", NULL},
        {"u8", "0x1F", "31"},
        {"u8", "0X1f", "31"},
        {"u8", "010", "10"},
        {"i8", "-100", "-100"},
        {"i8", "-101", NULL},
        {"i8", "-0x10", "-16"},
        {"i16", "-1000", "-1000"},
        {"i16", "32767", "32767"},
        {"u16", "65535", "65535"},
        {"u16", "65536", NULL},
        {"i32", "-2147483648", "-2147483648"},
        {"i32", "2147483648", NULL},
        {"u32", "4294967295", "4294967295"},
        {"i64", "-9223372036854775808", "-9223372036854775808"},
        {"i64", "9223372036854775807", "9223372036854775807"},
        {"i64", "9223372036854775808", NULL},
        {"i64", "-9223372036854775809", NULL},
        {"u64", "9223372036854775807", "9223372036854775807"},
        {"u64", "-1", NULL},
        {"real32", "-2", "-2"},
        {"real32", "3", "3"},
        {"real32", "3.0001", NULL},
        {"real32", "1.25", "1.25"},
        {"real32", "nan", NULL},
        {"real32", "", NULL},
        {"real32", "1x", NULL},
        {"real", "2.5e-3", "0.0025"},
        {"real", "-2.0001", NULL},
        {"real", "-2", "-2"},
        {"real", "3", "3"},
        {"real", "inf", NULL},
        {"real", "", NULL},
        {"real", "1,5", NULL},
        {"text", "", ""},
        {"text", " ~", " ~"},
        {"text", "1234", "1234"},
        {"text", "12345", NULL},
        {"text", "a\tb", NULL},
        {"text", "\x7F", NULL},
        {"bytes", "00aBfF", "00abff"},
        {"bytes", "00abf", NULL},
        {"bytes", "00abff0", NULL},
        {"bytes", "00abfg", NULL},
        {"described", "1", NULL},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char message[ECT_SIGNAL_MESSAGE] = "", text[ECT_SIGNAL_TEXT_ROOM] = "";
        kinds_t k = {0}, before = {0};
        ect_signal_ref_t ref = kind(&k, rows[i].name);
        assert_int_equal(ect_signal_check(&ref, rows[i].set, message), rows[i].read != NULL);
        assert_memory_equal(&k, &before, sizeof k);
        assert_int_equal(ect_signal_write(&ref, rows[i].set, 0, message), rows[i].read != NULL);
        if (!rows[i].read) {
            assert_memory_equal(&k, &before, sizeof k);
            assert_memory_equal(message, rows[i].name, strlen(rows[i].name));
            continue;
        }
        ect_signal_read(&ref, text);
        if (strcmp(text, rows[i].read) != 0)
            fail_msg("%s set to '%s': expected '%s', got '%s'", rows[i].name, rows[i].set, rows[i].read, text);
        memset(ref.value, 0, ect_signal_size(ref.signal));
        assert_memory_equal(&k, &before, sizeof k); /* no byte outside the value has changed */
    }
}

/* Values that only the twin or a master can give. */
static void read_alone(void **state)
{
    char text[ECT_SIGNAL_TEXT_ROOM];
    kinds_t k = {.u64 = UINT64_MAX, .described = 65535, .text = "\x1F \x7F~", .i32 = -1};
    (void)state;
    ect_signal_ref_t ref = kind(&k, "u64");
    ect_signal_read(&ref, text);
    assert_string_equal(text, "18446744073709551615");
    ref = kind(&k, "described");
    ect_signal_read(&ref, text);
    assert_string_equal(text, "number 65535");
    ref = kind(&k, "text");
    ect_signal_read(&ref, text);
    assert_string_equal(text, "? ?~");
    ref = kind(&k, "i32");
    ect_signal_text(&ref, &(int32_t){7}, text); /* another value of the same signal */
    assert_string_equal(text, "7");
}

static void longest_values(void **state)
{
    char message[ECT_SIGNAL_MESSAGE], text[ECT_SIGNAL_TEXT_ROOM], set_to[ECT_SIGNAL_TEXT_ROOM + 2] = "";
    kinds_t k = {0};
    (void)state;
    memset(set_to, 'z', ECT_SIGNAL_LONGEST_TEXT);
    ect_signal_ref_t ref = kind(&k, "longest");
    assert_true(ect_signal_write(&ref, set_to, 0, message));
    ect_signal_read(&ref, text);
    assert_string_equal(text, set_to);
    set_to[ECT_SIGNAL_LONGEST_TEXT] = 'z';
    assert_false(ect_signal_write(&ref, set_to, 0, message));
    memset(set_to, 0, sizeof set_to);
    memset(set_to, 'e', (size_t)2 * ECT_SIGNAL_LONGEST_BYTES);
    ref = kind(&k, "most");
    assert_true(ect_signal_write(&ref, set_to, 0, message));
    ect_signal_read(&ref, text);
    assert_string_equal(text, set_to);
    assert_int_equal(k.most[ECT_SIGNAL_LONGEST_BYTES - 1], 0xEE);
    assert_int_equal(k.behind, 0);
}

/* --- names ------------------------------------------------------------------------------------------------------ */

typedef struct tree {
    uint8_t top;
    struct {
        uint8_t pad, a, b;
    } bu;
    struct {
        uint8_t a, b, pad[2];
    } ru[12];
} tree_t;

static const ect_signal_t top_signals[] = {ECT_SIGNAL(tree_t, top, "top", U8, WRITE, 0, 255, NULL, "")};
static const ect_signal_t part_signals[] = {{"a", "", NULL, ECT_SIGNAL_U8, ECT_SIGNAL_WRITE, 0, 0, 255, 0},
                                            {"b", "", NULL, ECT_SIGNAL_U8, ECT_SIGNAL_WRITE, 1, 0, 255, 0}};
static const ect_signal_group_t tree_groups[] = {
    {.signal_count = 1, .signals = top_signals},
    {.prefix = "bu", .offset = offsetof(tree_t, bu.a), .signal_count = 2, .signals = part_signals},
    {.prefix = "none", .count = 3, .signal_count = 0},
    {.prefix = "ru",
     .count = 12,
     .offset = offsetof(tree_t, ru),
     .stride = 4,
     .signal_count = 2,
     .signals = part_signals},
};
static const ect_plant_t tree_plant = {.signal_groups = tree_groups, .signal_group_count = 4};

/* In the order of the tables, each found by its name, and each at its own byte. */
static void listed_as_found(void **state)
{
    static const char *const first[] = {"top", "bu.a", "bu.b", "ru1.a", "ru1.b", "ru2.a"};
    ect_signal_cursor_t cursor = {0};
    ect_signal_ref_t ref, found;
    tree_t t = {0};
    size_t count = 0;
    (void)state;
    while (ect_signals_next(&tree_plant, &t, &cursor, &ref)) {
        if (count < sizeof first / sizeof first[0])
            assert_string_equal(ref.name, first[count]);
        assert_true(ect_signal_find(&tree_plant, &t, ref.name, &found));
        assert_ptr_equal(found.value, ref.value);
        assert_int_equal(found.number, ref.number);
        assert_int_equal((*ref.value)++, 0);
        count++;
    }
    assert_int_equal(count, 1 + 2 + 12 * 2);
    assert_int_equal(t.bu.pad + t.ru[0].pad[0] + t.ru[11].pad[1], 0);
    assert_int_equal(t.ru[11].b, 1);
    assert_false(ect_signals_next(&tree_plant, &t, &cursor, &ref));
    assert_false(ect_signals_next(NULL, &t, &(ect_signal_cursor_t){0}, &ref));
    assert_false(ect_signal_find(NULL, &t, "top", &ref));
}

static void names_not_found(void **state)
{
    static const char *const names[] = {
        "",       "to",   "top.",   "bu",     "bu.",    "bu1.a", "bu.c", "bux.a", "ru.a",   "ru0.a",
        "ru13.a", "ru1a", "ru01.a", "ru+1.a", "ru-1.a", "ru1.c", "ru1.", "RU1.a", "ru 1.a", "ru99999999999999999999.a",
        "none1.a"};
    ect_signal_ref_t ref;
    tree_t t = {0};
    (void)state;
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        if (ect_signal_find(&tree_plant, &t, names[i], &ref))
            fail_msg("'%s' was found", names[i]);
    }
}

/* --- fields ----------------------------------------------------------------------------------------------------- */

static const ect_value_name_t named[] = {{0, "Off"}, {999, "Many"}, {1000, "More"}, {0x12345678, "Most"}, {0, NULL}};
static const ect_field_t tree_fields[] = {
    {.index = 0x2000, .subindex = 1, .signal = "top"},
    {.index = 0x2001, .subindex = 2, .bit = 3, .width = 1, .signal = "bu.b"},
    {.index = 0x2002, .subindex = 3, .bit = 4, .width = 2, .signal = "ru.a", .values = named},
    {.index = 0x2003, .subindex = 4, .values = named},
    {.index = 0},
};

/* Structures of an array share a field; equal parts of a name alone are not enough. */
static void fields_of_signals(void **state)
{
    static const struct {
        const char *signal;
        uint16_t index; /* 0: none */
    } rows[] = {{"top", 0x2000},   {"bu.a", 0},        {"bu.b", 0x2001}, {"ru1.a", 0x2002},
                {"ru9.a", 0x2002}, {"ru12.a", 0x2002}, {"ru1.b", 0},     {"ru12.b", 0}};
    ect_plant_t with_fields = tree_plant;
    tree_t t = {0};
    (void)state;
    with_fields.fields = tree_fields;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_signal_ref_t ref;
        assert_true(ect_signal_find(&with_fields, &t, rows[i].signal, &ref));
        const ect_field_t *field = ect_signal_field(&ref);
        if ((field ? field->index : 0) != rows[i].index)
            fail_msg("%s: expected field %04Xh, got %04Xh", rows[i].signal, rows[i].index, field ? field->index : 0);
        assert_true(ect_signal_find(&tree_plant, &t, rows[i].signal, &ref));
        assert_null(ect_signal_field(&ref));
    }
}

static void fields_as_text(void **state)
{
    static const char *const want[] = {"2000h:1", "2001h:2 bit 3",
                                       "2002h:3 bits 4 to 5: 0 Off, 999 Many, 0x000003E8 More, 0x12345678 Most",
                                       "2003h:4: 0 Off, 999 Many, 0x000003E8 More, 0x12345678 Most"};
    char text[ECT_FIELD_TEXT];
    (void)state;
    for (size_t i = 0; i < sizeof want / sizeof want[0]; i++) {
        ect_field_text(&tree_fields[i], text);
        assert_string_equal(text, want[i]);
        ect_field_values(&tree_fields[i], text);
        assert_string_equal(text, i < 2 ? "" : strchr(want[i] + 6, ':') + 2);
    }
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"a value that a user sets: the plant checks it, then it is stored, then the plant is notified",
         checked_stored_notified, NULL, NULL, NULL},
        {"the plant has stored the value itself, or refuses it: nothing is stored, no notification follows",
         done_or_refused, NULL, NULL, NULL},
        {"a value out of range does not reach the plant", out_of_range, NULL, NULL, NULL},
        {"a plant without functions: the value is stored", without_functions, NULL, NULL, NULL},
        {"each type has its size, its form in JSON and its range as text", types, NULL, NULL, NULL},
        {"each type accepts only texts of its range, and returns them", written_and_read, NULL, NULL, NULL},
        {"values that no user can set are read: the largest number, a described one, invisible characters", read_alone,
         NULL, NULL, NULL},
        {"the longest text and the longest bytes fit", longest_values, NULL, NULL, NULL},
        {"signals are listed in the order of the tables, and each is found by its name", listed_as_found, NULL, NULL,
         NULL},
        {"an inexact name is not found", names_not_found, NULL, NULL, NULL},
        {"a signal has the field that names it, a signal of an array the field of its structure", fields_of_signals,
         NULL, NULL, NULL},
        {"a field as text: its position, its bits, its values, in four hexadecimal digits", fields_as_text, NULL, NULL,
         NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("signals", tests, NULL, NULL);
}
