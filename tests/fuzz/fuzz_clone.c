/* SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 200809L
/*
 * Folders of `ectwin clone` with anything in them: the input is the bus file, then each other file behind a line "===
 * NAME". A device of an accepted bus file is read from its part. It is refused with one line, or it becomes a twin: the
 * file of this twin is read as the same description, and the file of that description is equal byte by byte, like the
 * clone of a clone. At last all twins are powered on as one bus.
 */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bus/chain/chain.h"
#include "buses/bus_file.h"
#include "esi/write.h"
#include "facts/facts.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { TWINS_MOST = 4, MESSAGE = 400, NAME_MOST = 60 };

static const char mark[] = "\n=== ";

/* A file of the folder. */
typedef struct part {
    const char *data;
    size_t length;
} part_t;

/* A twin, and the file that it is from. */
typedef struct made {
    ect_esi_t *esi;
    ect_esi_twin_t *twin;
} made_t;

/* The options that a clone writes. */
static unsigned int find_option(void *ctx, const char *name)
{
    (void)ctx;
    if (strcmp(name, "esc") == 0)
        return ECT_BUS_OPTION_VALUE | ECT_BUS_OPTION_OF_TWIN;
    return strcmp(name, "wire") == 0 ? ECT_BUS_OPTION_VALUE : ECT_BUS_OPTION_NONE;
}

static const char *next_mark(const char *from, const char *end)
{
    for (const char *at = from; at + sizeof mark - 1 <= end; at++) {
        if (memcmp(at, mark, sizeof mark - 1) == 0)
            return at;
    }
    return end;
}

/* @return the file with a name; its data are NULL: the folder has none */
static part_t part_of(const char *text, size_t size, const char *name, size_t length)
{
    const char *end = text + size;
    for (const char *at = next_mark(text, end); at < end; at = next_mark(at + 1, end)) {
        const char *first = at + sizeof mark - 1;
        const char *line = memchr(first, '\n', (size_t)(end - first));
        if (line != NULL && (size_t)(line - first) == length && memcmp(first, name, length) == 0)
            return (part_t){.data = line + 1, .length = (size_t)(next_mark(line, end) - line - 1)};
    }
    return (part_t){0};
}

static void expect_line(const char *why)
{
    if (why[0] == '\0' || strchr(why, '\n') != NULL)
        abort();
}

static made_t make(const char *name, const void *data, size_t length)
{
    char why[MESSAGE] = "";
    made_t made = {.esi = ect_esi_parse(name, data, length, why, sizeof why)};
    const ect_esi_device_t *model = made.esi != NULL ? ect_esi_select(made.esi, "", why, sizeof why) : NULL;
    if (model != NULL)
        made.twin = ect_esi_twin_of(made.esi, model, NULL, 0, why, sizeof why);
    if (made.twin == NULL)
        expect_line(why);
    return made;
}

static void drop(made_t *made)
{
    ect_esi_twin_free(made->twin);
    ect_esi_close(made->esi);
}

/* The descriptions of a twin and of the twin of its written file must be equal. A file that
 * contradicts itself may have differences to itself. */
static void compare(const ect_esi_twin_t *twin, const ect_esi_twin_t *again)
{
    char lines[MESSAGE] = "";
    FILE *out = fmemopen(lines, sizeof lines, "w");
    ect_facts_t one = {.source = "one"}, two = {.source = "two"}, known = {.source = "known"};
    ect_facts_t file = {.source = "file"}, copy = {.source = "copy"};
    ect_facts_of_device(&one, ect_esi_twin_product(twin)->device);
    ect_facts_of_device(&two, ect_esi_twin_product(again)->device);
    ect_facts_of_esi(&file, ect_esi_twin_product(twin)->device, ect_esi_twin_model(twin));
    if (out == NULL || ect_facts_compare(&known, &one, out) + ect_facts_compare(&known, &two, out) > 0)
        abort();
    (void)ect_facts_compare(&copy, &file, out);
    (void)fclose(out);
    ect_facts_free(&copy);
    ect_facts_free(&file);
    ect_facts_free(&known);
    ect_facts_free(&one);
    ect_facts_free(&two);
}

static const char *write_file(ect_arena_t *arena, const ect_esi_twin_t *twin, size_t *length)
{
    char why[MESSAGE] = "";
    const ect_product_t *product = ect_esi_twin_product(twin);
    const ect_esi_part_t part = {.device = product->device, .plant = product->plant, .twin = twin};
    return ect_esi_write(arena, &part, 1, length, why, sizeof why);
}

/* A text of a file may have characters that no XML has: such a file is not written. */
static void expect_the_same_again(const ect_esi_twin_t *twin)
{
    ect_arena_t arena = {0};
    size_t first = 0, second = 0;
    const char *one = write_file(&arena, twin, &first);
    made_t again = one != NULL ? make("again.xml", one, first) : (made_t){0};
    const char *two = again.twin != NULL ? write_file(&arena, again.twin, &second) : NULL;
    if (two != NULL && (first != second || memcmp(one, two, first) != 0))
        abort();
    if (two != NULL)
        compare(twin, again.twin);
    drop(&again);
    ect_arena_free(&arena);
}

static void run(const made_t *made, size_t count)
{
    ect_twin_config_t twins[TWINS_MOST];
    for (size_t i = 0; i < count; i++) {
        const ect_product_t *product = ect_esi_twin_product(made[i].twin);
        twins[i] = ect_twin_default(product->device, product->plant);
    }
    ect_chain_t *chain = count > 0 ? ect_chain_new(twins, count, 1) : NULL;
    if (chain == NULL)
        return;
    (void)ect_chain_poll(chain, 2);
    ect_chain_free(chain);
}

/* Makes the twin of an element of the list, "slave1=esi:folder/01-a.xml". @return false: none */
static bool make_one(const char *device, size_t length, const char *text, size_t size, made_t *made)
{
    static const char head[] = "esi:folder/";
    char name[NAME_MOST];
    const char *equals = memchr(device, '=', length);
    const char *file = equals != NULL ? equals + 1 : device;
    const size_t rest = length - (size_t)(file - device);
    if (rest < sizeof head || strncmp(file, head, sizeof head - 1) != 0 || rest - sizeof head + 1 >= sizeof name)
        return false;
    (void)snprintf(name, sizeof name, "%.*s", (int)(rest - sizeof head + 1), file + sizeof head - 1);
    const part_t part = part_of(text, size, name, strlen(name));
    if (part.data == NULL)
        return false;
    *made = make(name, part.data, part.length);
    if (made->twin == NULL) {
        drop(made);
        return false;
    }
    expect_the_same_again(made->twin);
    return true;
}

/* Makes the twins of a list. */
static void try_devices(const char *devices, const char *text, size_t size)
{
    made_t made[TWINS_MOST] = {{0}};
    size_t count = 0;
    for (const char *at = devices; at != NULL && count < TWINS_MOST; at = strchr(at, ',')) {
        at += *at == ',';
        if (make_one(at, strcspn(at, ","), text, size, &made[count]))
            count++;
    }
    run(made, count);
    for (size_t i = 0; i < count; i++)
        drop(&made[i]);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char why[MESSAGE] = "";
    ect_bus_file_t file;
    const char *text = (const char *)data;
    const ect_bus_options_t options = {.find = find_option};
    const size_t length = (size_t)(next_mark(text, text + size) - text);
    if (ect_bus_file_parse(&file, "folder/bus.yaml", text, length, &options, why, sizeof why))
        try_devices(file.devices, text, size);
    else
        expect_line(why);
    ect_bus_file_free(&file);
    return 0;
}
