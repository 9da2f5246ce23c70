/* SPDX-License-Identifier: MIT */
/* Named bits and values (seams/fields.h) of every product: they fit their entries, and signals show them. */
#include <string.h>

#include "bus/chain/fields.h"
#include "devices/eclink/eclink.h"
#include "devices/fzm1/fzm1.h"
#include "support/every.h"
#include "support/signals.h"

static const ect_entry_t *entry_of(const ect_device_t *device, const ect_field_t *field)
{
    const ect_od_t od = ect_device_od(device, NULL);
    const ect_object_t *object = ect_od_find(&od, field->index);
    return object ? ect_od_entry(object, field->subindex) : NULL;
}

static void check_values(const char *name, const ect_field_t *field, unsigned int bits)
{
    int64_t most = bits < 64 ? (INT64_C(1) << bits) - 1 : INT64_MAX;
    assert_true(field->width != 1 || field->values == NULL);
    for (const ect_value_name_t *v = field->values; v && v->name; v++) {
        if (v->value > most || v->value < 0 || *v->name == 0)
            fail_msg("%s %04Xh:%u: value %lld '%s' in %u bits", name, field->index, field->subindex,
                     (long long)v->value, v->name, bits);
        for (const ect_value_name_t *other = field->values; other < v; other++) {
            assert_true(other->value != v->value);
            assert_string_not_equal(other->name, v->name);
        }
    }
}

static void check_field(const ect_device_t *device, const ect_field_t *first, const ect_field_t *field)
{
    const ect_entry_t *entry = entry_of(device, field);
    unsigned int bits = field->width > 0 ? field->width : entry->bit_length;
    if ((field->width == 0 && field->bit != 0) || field->bit + bits > entry->bit_length || bits > 64)
        fail_msg("%s %04Xh:%u: bits %u to %u of %u", device->name, field->index, field->subindex, field->bit,
                 field->bit + bits - 1, entry->bit_length);
    if (field->width > 0 ? field->name == NULL : field->values == NULL)
        fail_msg("%s %04Xh:%u bit %u has no name", device->name, field->index, field->subindex, field->bit);
    for (const ect_field_t *other = first; other < field; other++) {
        bool same = other->index == field->index && other->subindex == field->subindex;
        bool apart = other->width > 0 && field->width > 0 &&
                     (other->bit + other->width <= field->bit || field->bit + field->width <= other->bit);
        if (same && !apart)
            fail_msg("%s %04Xh:%u bit %u is named twice", device->name, field->index, field->subindex, field->bit);
    }
    check_values(device->name, field, bits);
}

static void fields_fit_their_entries(void **state)
{
    const ect_device_t *device;
    unsigned int checked = 0;
    (void)state;
    for (size_t i = 0; (device = every_product(i)) != NULL; i++) {
        const ect_field_t *first = plant_of(device)->fields;
        for (const ect_field_t *field = first; field && field->index != 0; field++) {
            if (entry_of(device, field)) {
                check_field(device, first, field);
                checked++;
            }
        }
    }
    assert_true(checked > 60);
}

/* A table is shared by products: one of them at least has the entry. */
static bool a_product_has(const ect_field_t *table, const ect_field_t *field)
{
    const ect_device_t *device;
    for (size_t i = 0; (device = every_product(i)) != NULL; i++) {
        if (plant_of(device)->fields == table && entry_of(device, field))
            return true;
    }
    return false;
}

static void every_field_has_its_entry(void **state)
{
    const ect_device_t *device;
    (void)state;
    for (size_t i = 0; (device = every_product(i)) != NULL; i++) {
        const ect_field_t *table = plant_of(device)->fields;
        for (const ect_field_t *field = table; field && field->index != 0; field++) {
            if (!a_product_has(table, field))
                fail_msg("%s: %04Xh:%u is in the dictionary of no product", device->name, field->index,
                         field->subindex);
        }
    }
}

/* `shown` of the fields that name a signal are found from it. */
static void fields_of_signals(wire_t *w, const ect_plant_t *plant, bool shown[64])
{
    ect_signal_cursor_t cursor = {0};
    ect_signal_ref_t ref;
    while (ect_signals_next(plant, ect_chain_slave(w->chain, 0)->config.instance, &cursor, &ref)) {
        const ect_field_t *field = ect_signal_field(&ref);
        if (!field)
            continue;
        for (const ect_field_t *f = plant->fields; f->index != 0; f++)
            shown[f - plant->fields] |= f->signal && strcmp(f->signal, field->signal) == 0;
    }
}

static void signals_show_them(void **state)
{
    const ect_device_t *device;
    (void)state;
    for (size_t i = 0; (device = every_product(i)) != NULL; i++) {
        const ect_plant_t *plant = plant_of(device);
        bool shown[64] = {false};
        wire_t w;
        wire_open_one(&w, device);
        fields_of_signals(&w, plant, shown);
        for (const ect_field_t *f = plant->fields; f && f->index != 0; f++) {
            if (f->signal && !shown[f - plant->fields])
                fail_msg("%s: there is no signal '%s'", device->name, f->signal);
        }
        wire_close(&w);
    }
}

static void as_text(void **state)
{
    static const struct {
        const ect_device_t *device;
        const char *signal, *text;
    } rows[] = {
        {&ect_fzm1, "ready", "2200h:1 bit 2"},
        {&ect_fzm1, "output_control", "2400h:1: 0 None, 1 Handshaking"},
        {&ect_fzm1, "lost", NULL},
        {&ect_eclink_map1, "bu.state",
         "2001h:8: 0 Initial, 1 Stopped, 2 External link error, 3 Blocked, 4 Failed, 16 Disarmed, 17 Armed"},
        {&ect_eclink_map1, "ru8.disabled",
         "2001h:20: 0 Enabled, 1 Tilting, 2 Inactivity, 3 Warning popup not acknowledged"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char text[ECT_FIELD_TEXT] = "";
        ect_signal_ref_t ref;
        wire_t w;
        wire_open_one(&w, rows[i].device);
        signal_find(&w, rows[i].signal, &ref);
        const ect_field_t *field = ect_signal_field(&ref);
        assert_int_equal(field != NULL, rows[i].text != NULL);
        if (field) {
            ect_field_text(field, text);
            assert_string_equal(text, rows[i].text);
        }
        wire_close(&w);
    }
}

static void text_is_cut(void **state)
{
    static const char name[] = "a name of forty characters, no more than";
    static const ect_value_name_t values[] = {{1, name},  {2, name},       {3, name}, {4, name}, {5, name},
                                              {6, name},  {7, name},       {8, name}, {9, name}, {10, name},
                                              {11, name}, {0x12345, name}, {0, NULL}};
    const ect_field_t field = {.index = 0x7000, .subindex = 3, .bit = 4, .width = 12, .values = values};
    char text[ECT_FIELD_TEXT];
    (void)state;
    ect_field_text(&field, text);
    assert_int_equal(strlen(text), ECT_FIELD_TEXT - 1);
    assert_memory_equal(text, "7000h:3 bits 4 to 15: 1 a name of", 33);
}

#define TEST(title, function) {title, function, NULL, NULL, NULL}

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST("named bits and values fit their entries, and none overlap", fields_fit_their_entries),
        TEST("each named entry is in the dictionary of a product", every_field_has_its_entry),
        TEST("each signal that a field names exists", signals_show_them),
        TEST("ECL-028 ECL-033: a field as text: its place, its values", as_text),
        TEST("a text that is too long is cut", text_is_cut),
    };
    return cmocka_run_group_tests_name("fields", tests, NULL, NULL);
}
