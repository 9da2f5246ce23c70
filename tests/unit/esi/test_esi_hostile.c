/* SPDX-License-Identifier: MIT */
/*
 * Damaged files, systematically: each file of this tree with each element removed and doubled, each number at
 * the bounds of the types that it may have, and the text cut off at any byte. A file is refused with one line, or its
 * twin keeps what esi/twin.h promises.
 */
#include <inttypes.h>

#include "check/check.h"
#include "esi/lint.h"
#include "esi/write.h"
#include "from_text.h"
#include "sii/sii.h"

static const char *const files[] = {"analog.xml", "digital.xml", "extras.xml", "modular.xml",
                                    "soe.xml",    "state.xml",   "virtual.xml"};
enum { FILES = sizeof files / sizeof files[0], TEXT = 100000 };

static char *load(const char *file)
{
    char path[300];
    (void)snprintf(path, sizeof path, "%s/%s", ESI_FILES, file);
    FILE *stream = fopen(path, "rb");
    char *text = calloc(1, TEXT);
    assert_true(stream != NULL && text != NULL);
    assert_true(fread(text, 1, TEXT - 1, stream) > 0);
    (void)fclose(stream);
    return text;
}

/* The text with `length` bytes at `at` replaced; to be freed. */
static char *with(const char *text, size_t at, size_t length, const char *part, size_t part_length)
{
    char *result = calloc(1, strlen(text) - length + part_length + 1);
    assert_non_null(result);
    memcpy(result, text, at);
    memcpy(result + at, part, part_length);
    (void)strcpy(result + at + part_length, text + at + length);
    return result;
}

/* --- what holds for every file ------------------------------------------------------------------------------------ */

typedef struct tally {
    unsigned int refused, made;
} tally_t;

static void expect_line(const char *what, const char *line)
{
    if (strncmp(line, "t.xml:", 6) != 0 || strlen(line) <= 7 || strpbrk(line, "\r\n") != NULL)
        fail_msg("%s: expected one line that begins with t.xml:, got \"%s\"", what, line);
}

static void ignore(void *ctx, bool wrong, const char *line)
{
    (void)wrong;
    expect_line(ctx, line);
}

/* Process data have the same places and lengths; of a modular device only without modules, as a file describes it. */
static void expect_same_data(const char *what, const ect_device_t *device, const ect_device_t *again)
{
    assert_int_equal(again->sm_count, device->sm_count);
    for (unsigned int i = 0; i < device->sm_count; i++) {
        unsigned int bytes = ect_device_sm_bytes(device, i), other = ect_device_sm_bytes(again, i);
        if (again->sm[i].start != device->sm[i].start || other != bytes)
            fail_msg("%s: SM%u: expected %u bytes at %04X in the written file, got %u at %04X", what, i, bytes,
                     device->sm[i].start, other, again->sm[i].start);
    }
}

/* A twin's notes are lines, its description is right, its SII fits, and its file describes the same twin. */
static void expect_promises(const char *what, const ect_esi_twin_t *twin)
{
    char why[300] = "";
    size_t count, length;
    const ect_product_t *product = ect_esi_twin_product(twin);
    const char *const *notes = ect_esi_twin_notes(twin, &count);
    for (size_t i = 0; i < count; i++) {
        if (*notes[i] == '\0' || strchr(notes[i], '\n') != NULL)
            fail_msg("%s: expected a line, got the note \"%s\"", what, notes[i]);
    }
    if (!ect_device_check(product->device, why, sizeof why) ||
        !ect_plant_check(product->plant, product->device, why, sizeof why))
        fail_msg("%s: expected a description without a mistake, got: %s", what, why);
    ect_arena_t arena = {0};
    const ect_esi_part_t part = {.device = product->device, .twin = twin};
    const char *text = ect_esi_write(&arena, &part, 1, &length, why, sizeof why);
    if (text == NULL)
        fail_msg("%s: expected a file, got: %s", what, why);
    made_t again = try_text(text);
    if (again.twin == NULL)
        fail_msg("%s: expected a twin of the written file, got: %s", what, again.why);
    expect_same_data(what, product->device, device_of(&again));
    free_made(&again);
    ect_arena_free(&arena);
}

static void judge_device(const char *what, ect_esi_t *esi, const ect_esi_head_t *head, tally_t *tally)
{
    char selector[60], why[400] = "";
    (void)snprintf(selector, sizeof selector, "@%" PRIu32 "/%" PRIu32, head->product_code, head->revision);
    const ect_esi_device_t *model = ect_esi_select(esi, selector, why, sizeof why);
    ect_esi_twin_t *twin = NULL;
    if (model != NULL) {
        ect_esi_lint(esi, model, ignore, (void *)(uintptr_t)what);
        twin = ect_esi_twin_of(esi, model, NULL, 0, why, sizeof why);
    }
    if (twin == NULL)
        expect_line(what, why);
    else
        expect_promises(what, twin);
    tally->refused += twin == NULL;
    tally->made += twin != NULL;
    ect_esi_twin_free(twin);
}

/* The device that byte `place` is in, -1: all devices of the file have it. */
static int device_at(const char *text, size_t place)
{
    int device = -1;
    const char *end = strstr(text, "</Devices>");
    for (const char *at = strstr(text, "<Device "); at != NULL && at <= text + place; at = strstr(at + 1, "<Device "))
        device++;
    return end != NULL && text + place < end ? device : -1;
}

/* `device` as of device_at. */
static void judge(const char *what, const char *text, int device, tally_t *tally)
{
    char why[400] = "";
    size_t count = 0;
    ect_esi_t *esi = ect_esi_parse("t.xml", text, strlen(text), why, sizeof why);
    if (esi == NULL) {
        expect_line(what, why);
        tally->refused++;
        return;
    }
    const ect_esi_head_t *heads = ect_esi_heads(esi, &count);
    assert_true(count > 0);
    for (size_t i = 0; i < count; i++) {
        if (device < 0 || (size_t)device >= count || (size_t)device == i)
            judge_device(what, esi, &heads[i], tally);
    }
    ect_esi_close(esi);
}

/* --- elements ----------------------------------------------------------------------------------------------------- */

/* @return behind the element that begins at `at` */
static const char *behind(const char *at)
{
    int depth = 0;
    for (;; at = strchr(at, '<')) {
        const char *end = strchr(at, '>');
        assert_non_null(end);
        if (at[1] == '/')
            depth--;
        else if (end[-1] != '/' && at[1] != '!')
            depth++;
        at = end + 1;
        if (depth == 0)
            return at;
    }
}

static const char *next_element(const char *at)
{
    while ((at = strchr(at, '<')) != NULL && (at[1] == '/' || at[1] == '?' || at[1] == '!'))
        at++;
    return at;
}

static void elements_removed_and_doubled(void **state)
{
    tally_t tally = {0};
    (void)state;
    for (size_t i = 0; i < FILES; i++) {
        char *text = load(files[i]);
        const char *root = next_element(text);
        for (const char *at = next_element(root + 1); at != NULL; at = next_element(at + 1)) {
            const size_t place = (size_t)(at - text), length = (size_t)(behind(at) - at);
            char what[100];
            (void)snprintf(what, sizeof what, "%s: %.*s", files[i], (int)strcspn(at, "\n"), at);
            char *removed = with(text, place, length, "", 0);
            char *doubled = with(text, place, 0, at, length);
            judge(what, removed, device_at(text, place), &tally);
            judge(what, doubled, device_at(text, place), &tally);
            free(removed);
            free(doubled);
        }
        free(text);
    }
    assert_true(tally.refused > 100);
    assert_true(tally.made > 1000);
}

/* --- numbers ------------------------------------------------------------------------------------------------------ */

/* A number is what stands alone in an element or in an attribute. */
static const char *next_number(const char *at, size_t *length)
{
    for (; *at != '\0'; at++) {
        if ((*at != '>' && *at != '"' && *at != '\'') || strchr("#-0123456789", at[1]) == NULL)
            continue;
        *length = strspn(at + 1, "#x-0123456789abcdefABCDEF");
        if (at[1] != '\0' && strchr("<\"'", at[1 + *length]) != NULL)
            return at + 1;
    }
    return NULL;
}

static void numbers_at_their_bounds(void **state)
{
    static const char *const values[] = {"", "-1", "0", "255", "65536", "#xFFFFFFFF"};
    tally_t tally = {0};
    (void)state;
    for (size_t i = 0; i < FILES; i++) {
        char *text = load(files[i]);
        size_t length;
        for (const char *at = next_number(text, &length); at != NULL; at = next_number(at, &length)) {
            for (size_t k = 0; k < sizeof values / sizeof values[0]; k++) {
                char what[100];
                char *changed = with(text, (size_t)(at - text), length, values[k], strlen(values[k]));
                (void)snprintf(what, sizeof what, "%s, byte %zu: %s", files[i], (size_t)(at - text), values[k]);
                judge(what, changed, device_at(text, (size_t)(at - text)), &tally);
                free(changed);
            }
        }
        free(text);
    }
    assert_true(tally.refused > 1000);
    assert_true(tally.made > 1000);
}

/* --- bytes -------------------------------------------------------------------------------------------------------- */

static void cut_off_at_any_byte(void **state)
{
    (void)state;
    for (size_t i = 0; i < FILES; i++) {
        char *text = load(files[i]);
        const size_t end = (size_t)(behind(next_element(text)) - text);
        for (size_t length = 0; length < end; length += 7) {
            char why[400] = "";
            if (ect_esi_parse("t.xml", text, length, why, sizeof why) != NULL)
                fail_msg("%s: expected a refusal of %zu bytes of %zu", files[i], length, end);
            expect_line(files[i], why);
        }
        free(text);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"CF-063 a file without any one of its elements, or with it twice, is refused or makes a sound twin",
         elements_removed_and_doubled, NULL, NULL, NULL},
        {"CF-063 a file with any one of its numbers at a bound is refused or makes a sound twin",
         numbers_at_their_bounds, NULL, NULL, NULL},
        {"a file that is cut off at any byte is refused with its line", cut_off_at_any_byte, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
