/* SPDX-License-Identifier: MIT */
/*
 * `ectwin verify` is complete: each element and attribute of an ESI file is changed and removed, and each bit of an
 * EEPROM image flipped, one at a time. Each change is a difference, or has its place in a list below, with a reason.
 */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "bus/chain/catalogue.h"
#include "esi/twin.h"
#include "facts/facts.h"
#include "sii/sii.h"
#include "wire/bytes.h"

/* --- ESI ---------------------------------------------------------------------------------------------------------- */

/* Changes that are no difference. */
static const struct silent {
    const char *path, *reason;
} silent_in_files[] = {
    {"EtherCATInfo@xmlns:xsi", "of the file, not of the device"},
    {"EtherCATInfo@xsi:noNamespaceSchemaLocation", "of the file, not of the device"},
    {"EtherCATInfo@Version", "of the schema, not of the device"},
};

enum { PATH = 300, DEPTH = 20, SPANS = 1000 };

/* A value in the text of a file, and the part of the text to remove with it. */
typedef struct span {
    char path[PATH];
    size_t value, value_length;
    size_t whole, whole_length;
} span_t;

typedef struct scan {
    const char *text;
    span_t *spans;
    size_t count;
    const char *names[DEPTH];
    size_t lengths[DEPTH], starts[DEPTH], contents[DEPTH];
    size_t depth;
    bool has_elements[DEPTH];
} scan_t;

static void path_of(const scan_t *s, char path[PATH], const char *attribute, size_t length)
{
    size_t used = 0;
    for (size_t i = 0; i < s->depth; i++)
        used += (size_t)snprintf(path + used, PATH - used, "%s%.*s", i > 0 ? "/" : "", (int)s->lengths[i], s->names[i]);
    if (length > 0)
        (void)snprintf(path + used, PATH - used, "@%.*s", (int)length, attribute);
}

static span_t *new_span(scan_t *s, const char *attribute, size_t length)
{
    assert_true(s->count < SPANS);
    span_t *span = &s->spans[s->count++];
    path_of(s, span->path, attribute, length);
    return span;
}

/* Attributes of the tag whose name ends at `at`. @return where the tag ends, at its '>' or '/' */
static const char *scan_attributes(scan_t *s, const char *at)
{
    while (*at != '>' && *at != '/') {
        const char *name = at + strspn(at, " \n");
        if (*name == '>' || *name == '/')
            return name;
        const size_t length = strcspn(name, "=");
        const char *value = name + length + 2;
        const size_t value_length = strcspn(value, "\"");
        span_t *span = new_span(s, name, length);
        span->value = (size_t)(value - s->text);
        span->value_length = value_length;
        span->whole = (size_t)(at - s->text);
        span->whole_length = (size_t)(value + value_length + 1 - at);
        at = value + value_length + 1;
    }
    return at;
}

static void close_element(scan_t *s, const char *content_end, const char *end)
{
    const size_t i = s->depth - 1;
    if (!s->has_elements[i]) {
        span_t *span = new_span(s, NULL, 0);
        span->value = s->contents[i];
        span->value_length = (size_t)(content_end - s->text) - s->contents[i];
        span->whole = s->starts[i];
        span->whole_length = (size_t)(end - s->text) - s->starts[i];
    }
    s->depth--;
    if (s->depth > 0)
        s->has_elements[s->depth - 1] = true;
}

/* All values of a well-formed text without CDATA. */
static void scan(scan_t *s)
{
    const char *at = s->text;
    while ((at = strchr(at, '<')) != NULL) {
        if (at[1] == '?' || at[1] == '!') {
            at = strchr(at, '>') + 1;
        } else if (at[1] == '/') {
            const char *end = strchr(at, '>') + 1;
            close_element(s, at, end);
            at = end;
        } else {
            assert_true(s->depth < DEPTH);
            s->names[s->depth] = at + 1;
            s->lengths[s->depth] = strcspn(at + 1, " />\n");
            s->starts[s->depth] = (size_t)(at - s->text);
            s->has_elements[s->depth++] = false;
            const char *end = scan_attributes(s, at + 1 + s->lengths[s->depth - 1]);
            s->contents[s->depth - 1] = (size_t)(end + 1 - s->text);
            at = end + 1;
            if (*end == '/')
                close_element(s, end + 1, ++at);
        }
    }
    assert_int_equal(s->depth, 0);
}

/* Another value of the same kind. */
static void change_value(char *value, size_t room, const char *from, size_t length)
{
    static const char *const types[][2] = {{"INT", "UINT"},
                                           {"UINT", "INT"},
                                           {"BOOL", "BIT1"},
                                           {"USINT", "SINT"},
                                           {"UDINT", "DINT"},
                                           {"ro", "rw"},
                                           {"rw", "ro"},
                                           {"T", "R"},
                                           {"R", "T"},
                                           {"PreOP", "SafeOP"},
                                           {"PreOP_SafeOP", "PreOP"},
                                           {"Outputs", "Inputs"},
                                           {"Inputs", "Outputs"},
                                           {"PS", "SO"}};
    (void)snprintf(value, room, "%.*s", (int)length, from);
    for (size_t i = 0; i < sizeof types / sizeof types[0]; i++) {
        if (strcmp(value, types[i][0]) == 0) {
            (void)snprintf(value, room, "%s", types[i][1]);
            return;
        }
    }
    char *last = &value[length > 0 ? length - 1 : 0];
    if (length == 0)
        (void)snprintf(value, room, "x");
    else if (strcmp(value, "1") == 0)
        *last = '0';
    else if (*last >= '0' && *last <= '8')
        (*last)++;
    else
        *last = *last == '9'                                         ? '8'
                : *last == 'x'                                       ? 'y'
                : strspn(value, "0123456789abcdefABCDEF#") == length ? '1'
                                                                     : 'x';
}

static char *with(const char *text, size_t at, size_t length, const char *value)
{
    char *result = calloc(1, strlen(text) + strlen(value) + 1);
    assert_non_null(result);
    (void)sprintf(result, "%.*s%s%s", (int)at, text, value, text + at + length);
    return result;
}

/* @return false: the file is refused, which a user notices */
static bool facts_of_text(ect_facts_t *facts, const char *text)
{
    char message[600] = "";
    ect_esi_t *esi = ect_esi_parse("every.xml", text, strlen(text), message, sizeof message);
    const ect_esi_device_t *model = esi != NULL ? ect_esi_select(esi, "", message, sizeof message) : NULL;
    ect_esi_twin_t *twin = model != NULL ? ect_esi_twin_of(esi, model, NULL, 0, message, sizeof message) : NULL;
    if (twin != NULL)
        ect_facts_of_esi(facts, ect_esi_twin_product(twin)->device, model);
    ect_esi_twin_free(twin);
    ect_esi_close(esi);
    return twin != NULL;
}

static size_t differences(const ect_facts_t *expected, const ect_facts_t *found)
{
    FILE *nowhere = fopen("/dev/null", "w");
    ect_facts_t known = {.source = expected->source};
    assert_non_null(nowhere);
    assert_int_equal(ect_facts_compare(&known, expected, nowhere), 0);
    const size_t lines = ect_facts_compare(&known, found, nowhere);
    (void)fclose(nowhere);
    ect_facts_free(&known);
    return lines;
}

static bool is_noticed(const ect_facts_t *expected, const char *text)
{
    ect_facts_t found = {.source = "changed"};
    const bool noticed = !facts_of_text(&found, text) || differences(expected, &found) > 0;
    ect_facts_free(&found);
    return noticed;
}

static bool is_allowed(const char *path, bool *used)
{
    for (size_t i = 0; i < sizeof silent_in_files / sizeof silent_in_files[0]; i++) {
        if (strcmp(path, silent_in_files[i].path) == 0) {
            used[i] = true;
            return true;
        }
    }
    return false;
}

static char *load(const char *file)
{
    char path[300];
    (void)snprintf(path, sizeof path, "%s/%s", ESI_FILES, file);
    FILE *stream = fopen(path, "rb");
    char *text = calloc(1, 100000);
    assert_true(stream != NULL && text != NULL);
    assert_true(fread(text, 1, 99999, stream) > 0);
    (void)fclose(stream);
    return text;
}

static void every_value_of_a_file_counts(void **state)
{
    char *text = load("every.xml");
    scan_t s = {.text = text, .spans = calloc(SPANS, sizeof *s.spans)};
    ect_facts_t expected = {.source = "file"};
    bool used[sizeof silent_in_files / sizeof silent_in_files[0]] = {false};
    unsigned int silent = 0;
    (void)state;
    assert_non_null(s.spans);
    scan(&s);
    assert_true(s.count > 300);
    assert_true(facts_of_text(&expected, text));
    for (size_t i = 0; i < s.count; i++) {
        const span_t *span = &s.spans[i];
        char value[200];
        change_value(value, sizeof value, text + span->value, span->value_length);
        char *changed = with(text, span->value, span->value_length, value);
        char *removed = with(text, span->whole, span->whole_length, "");
        const bool by_change = is_noticed(&expected, changed), by_removal = is_noticed(&expected, removed);
        if ((!by_change || !by_removal) && !is_allowed(span->path, used)) {
            print_error("%s = \"%.*s\": %s%s\n", span->path, (int)span->value_length, text + span->value,
                        by_change ? "" : "a change is silent ", by_removal ? "" : "removal is silent");
            silent++;
        }
        free(changed);
        free(removed);
    }
    for (size_t i = 0; i < sizeof used; i++) {
        if (!used[i])
            fail_msg("%s is a difference now: take it off the list", silent_in_files[i].path);
    }
    assert_int_equal(silent, 0);
    ect_facts_free(&expected);
    free(s.spans);
    free(text);
}

/* --- EEPROM ------------------------------------------------------------------------------------------------------- */

static const struct silent_bits {
    size_t first, last; /* bytes */
    const char *reason;
} silent_in_images[] = {
    {0x1C, 0x1F, "serial number: each slave has its own"},
};

/* A letter beyond ISO 646, which every tool spells its own way, a count of strings beyond the last one, or the
 * byte that fills the last word. */
static bool is_of_strings(const ect_device_t *device, const uint8_t *image, size_t byte)
{
    size_t length = 0;
    const uint8_t *strings = ect_sii_category(image, device->sii_size, ECT_SII_STRINGS, &length);
    const size_t at = ECT_SII_CATEGORIES + 4;
    return strings != NULL && byte >= at && byte < at + length &&
           (byte == at || byte == at + length - 1 || image[byte] < ' ' || image[byte] > '~');
}

static bool may_be_silent(size_t byte)
{
    for (size_t i = 0; i < sizeof silent_in_images / sizeof silent_in_images[0]; i++) {
        if (byte >= silent_in_images[i].first && byte <= silent_in_images[i].last)
            return true;
    }
    return false;
}

/* @return bytes up to and with the type of the last category: what follows is no content */
static size_t used_bytes(const uint8_t *image, size_t size)
{
    size_t at = ECT_SII_CATEGORIES;
    while (at + 4 <= size && ect_load_le16(image + at) != ECT_SII_END)
        at += 4 + 2 * (size_t)ect_load_le16(image + at + 2);
    return at + 2;
}

static void flip_all(const ect_device_t *device)
{
    const size_t size = device->sii_size;
    uint8_t *image = malloc(size);
    ect_facts_t expected = {.source = "image"};
    assert_non_null(image);
    assert_true(ect_sii_write(device, NULL, 0, image, size) > 0);
    ect_facts_of_sii(&expected, image, size);
    const size_t used = used_bytes(image, size);
    unsigned int silent = 0;
    assert_true(used < size);
    for (size_t bit = 0; bit < 8 * used; bit++) {
        ect_facts_t found = {.source = "flipped"};
        image[bit / 8] ^= (uint8_t)(1u << bit % 8);
        ect_facts_of_sii(&found, image, size);
        const bool noticed = differences(&expected, &found) > 0;
        if (noticed && may_be_silent(bit / 8))
            fail_msg("%s: byte 0x%zX is a difference now: take it off the list", device->name, bit / 8);
        if (!noticed && !may_be_silent(bit / 8) && !is_of_strings(device, image, bit / 8)) {
            print_error("%s: byte 0x%zX bit %zu: 0x%02X is silent\n", device->name, bit / 8, bit % 8, image[bit / 8]);
            silent++;
        }
        image[bit / 8] ^= (uint8_t)(1u << bit % 8);
        ect_facts_free(&found);
    }
    ect_facts_free(&expected);
    free(image);
    assert_int_equal(silent, 0);
}

static void every_bit_of_an_image_counts(void **state)
{
    static const char *const names[] = {"fzm1", "pmctendo-dd5"};
    (void)state;
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++)
        flip_all(ect_catalogue_find(names[i])->device);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"each value of an ESI file is compared, or listed with a reason (CF-066)", every_value_of_a_file_counts, NULL,
         NULL, NULL},
        {"each bit of an EEPROM image is compared, or listed with a reason (CF-054)", every_bit_of_an_image_counts,
         NULL, NULL, NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
