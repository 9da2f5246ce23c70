/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "buses/bus_file.h"

#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "text/number.h"
#include "wire/assert.h"
#include "yaml/document.h"

enum { VERSION = 1 };

/* A twin of the file, or several by `count`. */
typedef struct entry {
    const yaml_node_t *node; /* its mapping */
    const char *name;        /* NULL: none */
    size_t first, count;     /* numbers, from 1 */
} entry_t;

typedef struct reader {
    ect_bus_file_t *file;
    const ect_bus_options_t *options;
    ect_mistake_t mistake;
    ect_yaml_t yaml;
    const entry_t *entry; /* of the twin whose keys are read; NULL: the bus */
    entry_t *entries;
    size_t entry_count;
    bool whole; /* the last twin is the bus of a network file */
} reader_t;

/* --- mistakes ----------------------------------------------------------------------------------------------------- */

static void fail_memory(reader_t *r)
{
    ect_yaml_fail(&r->yaml, NULL, "no memory left");
}

/* --- words -------------------------------------------------------------------------------------------------------- */

__attribute__((format(printf, 2, 3))) static char *print(reader_t *r, const char *format, ...)
{
    va_list values;
    char *text = NULL;
    va_start(values, format);
    if (vasprintf(&text, format, values) < 0) {
        text = NULL;
        fail_memory(r);
    }
    va_end(values);
    return text;
}

/* @return the array with room for one more element, reallocated at powers of two; NULL: no memory, the array is
 * unchanged */
static void *grow(reader_t *r, void *array, size_t count, size_t size)
{
    if ((count & (count - 1)) != 0)
        return array;
    void *grown = realloc(array, (count > 0 ? 2 * count : 1) * size);
    if (!grown)
        fail_memory(r);
    return grown;
}

/* Appends `word`, of `node`, whose ownership it takes. */
static void add_word(reader_t *r, const yaml_node_t *node, char *word)
{
    ect_bus_file_t *file = r->file;
    if (file->count == ECT_BUS_FILE_WORDS) {
        ect_yaml_fail(&r->yaml, NULL, "more than %d options of all twins together", (int)ECT_BUS_FILE_WORDS);
        free(word);
        return;
    }
    char **words = word ? grow(r, file->words, file->count, sizeof *words) : NULL;
    file->words = words ? words : file->words;
    size_t *lines = words ? grow(r, file->lines, file->count, sizeof *lines) : NULL;
    file->lines = lines ? lines : file->lines;
    if (!lines) {
        free(word);
        return;
    }
    lines[file->count] = ect_yaml_line(node);
    words[file->count++] = word;
}

static void add_device(reader_t *r, const char *name, const char *device, size_t count)
{
    ect_bus_file_t *file = r->file;
    char *before = file->devices;
    char number[24] = "";
    if (count > 1)
        (void)snprintf(number, sizeof number, "*%zu", count);
    file->devices = print(r, "%s%s%s%s%s%s", before ? before : "", before ? "," : "", name ? name : "", name ? "=" : "",
                          device, number);
    free(before);
}

/* --- nodes -------------------------------------------------------------------------------------------------------- */

static const yaml_node_t *node_of(reader_t *r, int number)
{
    return ect_yaml_node(&r->yaml, number);
}

static const char *scalar(reader_t *r, const yaml_node_t *node, const char *key)
{
    return ect_yaml_scalar(&r->yaml, node, key);
}

static const yaml_node_t *find(reader_t *r, const yaml_node_t *map, const char *key)
{
    return ect_yaml_find(&r->yaml, map, key);
}

static void each_pair(reader_t *r, const yaml_node_t *map, const char *what, ect_yaml_take_t take)
{
    ect_yaml_each(&r->yaml, map, what, true, take, r);
}

/* --- names of twins ----------------------------------------------------------------------------------------------- */

static bool is_name(const char *text)
{
    size_t length = strspn(text, "abcdefghijklmnopqrstuvwxyz0123456789_-");
    return *text >= 'a' && *text <= 'z' && text[length] == '\0' && length <= ECT_BUS_FILE_NAME;
}

/* @return the number of the entry's twin whose name is the first `length` characters; 0: none */
static size_t number_in(const entry_t *entry, const char *text, size_t length)
{
    size_t own = entry->name ? strlen(entry->name) : 0;
    char digits[8] = "";
    uint64_t number = 1;
    if (own == 0 || own > length || strncmp(text, entry->name, own) != 0 || length - own >= sizeof digits)
        return 0;
    memcpy(digits, text + own, length - own);
    bool found = entry->count == 1 ? length == own : *digits != '0' && ect_number(digits, 1, entry->count, &number);
    return found ? entry->first + (size_t)number - 1 : 0;
}

static size_t number_of(const reader_t *r, const char *text, size_t length)
{
    size_t number = 0;
    for (size_t i = 0; i < r->entry_count && number == 0; i++)
        number = number_in(&r->entries[i], text, length);
    return number;
}

/* Checks that `text` begins with the name or the number of a twin. @param[out] rest  the text after it */
static void check_twin(reader_t *r, const yaml_node_t *node, const char *text, const char *end, const char **rest)
{
    size_t length = strcspn(text, end);
    *rest = text + length;
    if (number_of(r, text, length) == 0 && (*text < '0' || *text > '9'))
        ect_yaml_fail(&r->yaml, node, "there is no twin with the name '%.*s'", (int)(length < 60 ? length : 60), text);
}

/* Replaces the names in "axis.home=distance.data1,factor=2"; a missing '=' is reported by the option. */
static void check_connection(reader_t *r, const yaml_node_t *node, const char *text)
{
    const char *rest;
    check_twin(r, node, text, ".=", &rest);
    const char *equals = strchr(rest, '=');
    if (equals)
        check_twin(r, node, equals + 1, ".,", &rest);
}

/* Replaces the names in "at 2.5s hang slave gripper". */
static void check_fault(reader_t *r, const yaml_node_t *node, const char *text)
{
    static const char place[] = "slave ";
    for (const char *word = strstr(text, place); word && !r->mistake.failed; word = strstr(word, place)) {
        bool begins = word == text || word[-1] == ' ';
        word += strlen(place);
        word += strspn(word, " ");
        if (begins)
            check_twin(r, node, word, " ", &word);
    }
}

/* --- paths -------------------------------------------------------------------------------------------------------- */

bool ect_bus_file_below(const char *path)
{
    bool below = *path != '/';
    for (const char *part = path; below && part; part = strchr(part, '/') ? strchr(part, '/') + 1 : NULL)
        below = strncmp(part, "..", 2) != 0 || (part[2] != '/' && part[2] != '\0');
    return below;
}

static char *path_of(reader_t *r, const char *prefix, const char *path)
{
    const char *slash = strrchr(r->mistake.path, '/');
    if (*path == '/' || !slash)
        return print(r, "%s%s", prefix, path);
    return print(r, "%s%.*s/%s", prefix, (int)(slash - r->mistake.path), r->mistake.path, path);
}

static char *device_of(reader_t *r, const yaml_node_t *node, const char *device)
{
    static const char *const prefixes[] = {"esi:", "sii:", "eni:", "yaml:"};
    if (ect_bus_file_is(device) && !strchr(device, ':'))
        ect_yaml_fail(&r->yaml, node,
                      "'device: %.60s' is a file: write 'device: yaml:%.60s' for a device file; a bus file contains no "
                      "other bus files: copy their twins",
                      device, device);
    if (*device == '\0' || strchr(device, ',') || (strchr(device, '*') && !strchr(device, ':')))
        ect_yaml_fail(&r->yaml, node,
                      "'device: %.60s' names one device: write a further one as a separate '- device:', several equal "
                      "ones as 'count'",
                      device);
    for (size_t i = 0; i < sizeof prefixes / sizeof prefixes[0]; i++) {
        if (strncmp(device, prefixes[i], strlen(prefixes[i])) == 0)
            return path_of(r, prefixes[i], device + strlen(prefixes[i]));
    }
    return print(r, "%s", device);
}

/* --- options ------------------------------------------------------------------------------------------------------ */

/* @return the length of "N:" or "NAME:" before a value of the bus */
static size_t twin_before(const reader_t *r, const char *text)
{
    size_t length = strcspn(text, ":");
    bool number = length > 0 && strspn(text, "0123456789") == length;
    return text[length] == ':' && (number || number_of(r, text, length) > 0) ? length + 1 : 0;
}

/* @param n  number of the twin of the option; 0: an option of the bus */
static char *path_value(reader_t *r, const yaml_node_t *node, const char *key, unsigned int option, size_t n)
{
    const char *text = scalar(r, node, key);
    static const char socket[] = "unix:";
    size_t before = n == 0 && (option & ECT_BUS_OPTION_OF_TWIN) != 0 ? twin_before(r, text) : 0;
    if ((option & ECT_BUS_OPTION_SOCKET) != 0) {
        if (strncmp(text + before, socket, strlen(socket)) != 0)
            return print(r, "%s", text);
        before += strlen(socket);
    }
    if ((option & ECT_BUS_OPTION_OUTPUT) != 0 && !ect_bus_file_below(text + before))
        ect_yaml_fail(
            &r->yaml, node,
            "'%.60s: %.120s' is written outside the folder of the bus file: take a path below that folder, or "
            "give --%.60s on the command line",
            key, text, key);
    char *prefix = print(r, "%.*s", (int)before, text);
    char *path = prefix ? path_of(r, prefix, text + before) : NULL;
    free(prefix);
    return path;
}

static char *value_of(reader_t *r, const yaml_node_t *node, const char *key, unsigned int option, size_t n)
{
    const char *text = scalar(r, node, key);
    if (r->mistake.failed)
        return NULL;
    if (strcmp(key, "connect") == 0)
        check_connection(r, node, text);
    if (strcmp(key, "fault") == 0)
        check_fault(r, node, text);
    return (option & (ECT_BUS_OPTION_PATH | ECT_BUS_OPTION_SOCKET)) != 0 ? path_value(r, node, key, option, n)
                                                                         : print(r, "%s", text);
}

/* @param n  number of the twin of the option; 0: an option of the bus */
static void add_option(reader_t *r, const yaml_node_t *node, const char *key, unsigned int option, size_t n)
{
    char *value = value_of(r, node, key, option, n);
    if (value)
        add_word(r, node, n > 0 ? print(r, "--%s=%zu:%s", key, n, value) : print(r, "--%s=%s", key, value));
    free(value);
}

static void add_flag(reader_t *r, const yaml_node_t *node, const char *key)
{
    const char *value = scalar(r, node, key);
    if (strcmp(value, "true") != 0 && strcmp(value, "false") != 0)
        ect_yaml_fail(&r->yaml, node, "'%.60s' takes true or false", key);
    else if (*value == 't')
        add_word(r, node, print(r, "--%s", key));
}

/* Reads a value, or a list of values. */
static void add_options(reader_t *r, const yaml_node_t *node, const char *key, unsigned int option, size_t n)
{
    if (node->type != YAML_SEQUENCE_NODE) {
        add_option(r, node, key, option, n);
        return;
    }
    for (const yaml_node_item_t *i = node->data.sequence.items.start; i < node->data.sequence.items.top; i++)
        add_option(r, node_of(r, *i), key, option, n);
}

/* Appends twins, separated by commas, to a word, whose ownership it takes. */
static char *append_twins(reader_t *r, char *word, const yaml_node_t *node, const char *key, const char *between)
{
    const char *text = scalar(r, node, key);
    const char *rest = text;
    check_twin(r, node, rest, ",", &rest);
    while (*rest == ',')
        check_twin(r, node, rest + 1, ",", &rest);
    char *longer = print(r, "%s%s%s", word ? word : "", between, text);
    free(word);
    return longer;
}

/* Reads one or several twins as one value. */
static void add_twins(reader_t *r, const yaml_node_t *node, const char *key)
{
    char *word = print(r, "--%s=", key);
    if (node->type != YAML_SEQUENCE_NODE) {
        add_word(r, node, append_twins(r, word, node, key, ""));
        return;
    }
    const yaml_node_item_t *first = node->data.sequence.items.start;
    for (const yaml_node_item_t *i = first; i < node->data.sequence.items.top && !r->mistake.failed; i++)
        word = append_twins(r, word, node_of(r, *i), key, i == first ? "" : ",");
    add_word(r, node, word);
}

/* Increments alias and serial number from one twin to the next, as on the command line. */
static void add_counted(reader_t *r, const yaml_node_t *node, const char *key, const entry_t *entry)
{
    uint64_t first = 0;
    const char *text = scalar(r, node, key);
    if (!r->mistake.failed && !ect_number(text, 0, UINT32_MAX, &first))
        ect_yaml_fail(&r->yaml, node, "'%.60s' takes a number, not '%.60s'", key, text);
    for (size_t i = 0; i < entry->count && !r->mistake.failed; i++)
        add_word(r, node, print(r, "--%s=%zu:%zu", key, entry->first + i, (size_t)first + i));
}

/* --- a twin ------------------------------------------------------------------------------------------------------- */

static void take_setting(void *ctx, const char *key, const yaml_node_t *name, const yaml_node_t *value)
{
    reader_t *r = ctx;
    const entry_t *entry = r->entry;
    (void)name;
    const char *text = scalar(r, value, key);
    for (size_t i = 0; i < entry->count && !r->mistake.failed; i++)
        add_word(r, value, print(r, "--set=%zu:%s=%s", entry->first + i, key, text));
}

static void take_module(void *ctx, const char *key, const yaml_node_t *name, const yaml_node_t *value)
{
    reader_t *r = ctx;
    const entry_t *entry = r->entry;
    (void)name;
    const char *text = scalar(r, value, key);
    for (size_t i = 0; i < entry->count && !r->mistake.failed; i++)
        add_word(r, value, print(r, "--module=%zu:%s=%s", entry->first + i, key, text));
}

static void take_connection(void *ctx, const char *key, const yaml_node_t *name, const yaml_node_t *value)
{
    reader_t *r = ctx;
    const entry_t *entry = r->entry;
    (void)name;
    const char *rest;
    const char *text = scalar(r, value, key);
    check_twin(r, value, text, ".,", &rest);
    for (size_t i = 0; i < entry->count && !r->mistake.failed; i++)
        add_word(r, value, print(r, "--connect=%zu.%s=%s", entry->first + i, key, text));
}

static void take_twin_key(void *ctx, const char *key, const yaml_node_t *name, const yaml_node_t *value)
{
    reader_t *r = ctx;
    const entry_t *entry = r->entry;
    (void)name;
    if (strcmp(key, "device") == 0 || strcmp(key, "name") == 0 || strcmp(key, "count") == 0)
        return;
    unsigned int option = r->options->find(r->options->ctx, key);
    if (strcmp(key, "set") == 0)
        each_pair(r, value, "set", take_setting);
    else if (strcmp(key, "module") == 0)
        each_pair(r, value, "module", take_module);
    else if (strcmp(key, "connect") == 0)
        each_pair(r, value, "connect", take_connection);
    else if ((option & ECT_BUS_OPTION_OF_TWIN) == 0)
        ect_yaml_fail(
            &r->yaml, value,
            "'%.60s' is no key of a twin: device, name, count, set, module, connect, or an option of 'ectwin run' "
            "that takes N: for twin N",
            key);
    else if (strcmp(key, "alias") == 0 || strcmp(key, "serial") == 0)
        add_counted(r, value, key, entry);
    else
        for (size_t i = 0; i < entry->count && !r->mistake.failed; i++)
            add_options(r, value, key, option, entry->first + i);
}

static size_t count_of(reader_t *r, const yaml_node_t *twin)
{
    uint64_t count = 1;
    const yaml_node_t *node = find(r, twin, "count");
    if (node && !ect_number(scalar(r, node, "count"), 1, ECT_BUS_FILE_TWINS, &count))
        ect_yaml_fail(&r->yaml, node, "'count' takes a number from 1 to %d", (int)ECT_BUS_FILE_TWINS);
    return (size_t)count;
}

/* Checks that a name is unique, and differs from the numbered names of other entries. */
static void take_name(reader_t *r, const yaml_node_t *name, entry_t *entry)
{
    entry->name = scalar(r, name, "name");
    if (!is_name(entry->name))
        ect_yaml_fail(&r->yaml, name, "'name: %.60s': a letter a to z first, then letters, digits, _ and -, at most %d",
                      entry->name, (int)ECT_BUS_FILE_NAME);
    for (size_t i = 0; i < r->entry_count; i++) {
        const char *other = r->entries[i].name;
        if (other && (strcmp(other, entry->name) == 0 || number_in(entry, other, strlen(other)) > 0 ||
                      number_in(&r->entries[i], entry->name, strlen(entry->name)) > 0))
            ect_yaml_fail(&r->yaml, name, "two twins have the name '%.60s'", entry->name);
    }
}

/* Checks that the bus of a network file is the last entry, and the only one, because it may have any length. */
static void check_whole(reader_t *r, const yaml_node_t *twin, const char *word, size_t count)
{
    if (r->whole)
        ect_yaml_fail(&r->yaml, twin, "'device: eni:FILE' must be the last entry: its bus has any length");
    r->whole = word && strncmp(word, "eni:", 4) == 0 && !strchr(word, '#');
    if (r->whole && count > 1)
        ect_yaml_fail(&r->yaml, twin, "'count' is for one device; 'device: eni:FILE' is a bus");
}

static void add_twin_line(reader_t *r, size_t line)
{
    size_t *lines = grow(r, r->file->twin_lines, r->file->twins, sizeof *lines);
    if (!lines)
        return;
    r->file->twin_lines = lines;
    lines[r->file->twins++] = line;
}

static void add_entry(reader_t *r, const yaml_node_t *twin)
{
    if (twin->type != YAML_MAPPING_NODE) {
        ect_yaml_fail(&r->yaml, twin, "a twin is '- device: DEVICE', followed by its other keys");
        return;
    }
    const yaml_node_t *name = find(r, twin, "name");
    const yaml_node_t *device = find(r, twin, "device");
    entry_t entry = {.node = twin, .first = r->file->twins + 1, .count = count_of(r, twin)};
    if (!device) {
        ect_yaml_fail(&r->yaml, twin, "a twin without 'device'; 'ectwin list' lists the devices");
        return;
    }
    if (name)
        take_name(r, name, &entry);
    char *word = device_of(r, device, scalar(r, device, "device"));
    check_whole(r, twin, word, entry.count);
    if (r->file->twins + entry.count > ECT_BUS_FILE_TWINS)
        ect_yaml_fail(&r->yaml, twin, "more than %d twins", (int)ECT_BUS_FILE_TWINS);
    for (size_t i = 0; i < entry.count && !r->mistake.failed; i++)
        add_twin_line(r, ect_yaml_line(device));
    if (word && !r->mistake.failed)
        add_device(r, entry.name, word, entry.count);
    free(word);
    r->entries[r->entry_count++] = entry;
}

/* --- the whole ---------------------------------------------------------------------------------------------------- */

static void take_twins(reader_t *r, const yaml_node_t *twins)
{
    if (!twins || twins->type != YAML_SEQUENCE_NODE ||
        twins->data.sequence.items.start == twins->data.sequence.items.top) {
        ect_yaml_fail(&r->yaml, twins, "'twins:' with a list of '- device: DEVICE' is missing");
        return;
    }
    const yaml_node_item_t *top = twins->data.sequence.items.top;
    r->entries = calloc((size_t)(top - twins->data.sequence.items.start), sizeof *r->entries);
    if (!r->entries)
        fail_memory(r);
    for (const yaml_node_item_t *i = twins->data.sequence.items.start; i < top && !r->mistake.failed; i++)
        add_entry(r, node_of(r, *i));
}

static void take_key(void *ctx, const char *key, const yaml_node_t *name, const yaml_node_t *value)
{
    reader_t *r = ctx;
    (void)name;
    if (strcmp(key, "ectwin") == 0 || strcmp(key, "twins") == 0)
        return;
    unsigned int option = r->options->find(r->options->ctx, key);
    if (option == ECT_BUS_OPTION_NONE)
        ect_yaml_fail(&r->yaml, value,
                      "'%.60s' is no key of a bus: ectwin, twins, or a long option of 'ectwin run' without its --",
                      key);
    else if (strcmp(key, "panel") == 0)
        add_twins(r, value, key);
    else if ((option & ECT_BUS_OPTION_VALUE) != 0)
        add_options(r, value, key, option, 0);
    else
        add_flag(r, value, key);
}

static void take_document(reader_t *r)
{
    const yaml_node_t *root = ect_yaml_root(&r->yaml);
    if (!root || root->type != YAML_MAPPING_NODE) {
        ect_yaml_fail(&r->yaml, root, "not a bus file: it begins with 'ectwin: %d' and has 'twins:'", VERSION);
        return;
    }
    const yaml_node_t *version = find(r, root, "ectwin");
    uint64_t number = 0;
    if (!version && find(r, root, "ectwin-device")) {
        ect_yaml_fail(&r->yaml, root, "a device, not a bus: write yaml:%s", r->mistake.path);
        return;
    }
    if (!version || !ect_number(scalar(r, version, "ectwin"), 0, UINT32_MAX, &number) || number != VERSION) {
        ect_yaml_fail(&r->yaml, version ? version : root,
                      "'ectwin: %d' is missing: the version of the format that this ectwin reads", VERSION);
        return;
    }
    take_twins(r, find(r, root, "twins"));
    if (!r->mistake.failed)
        each_pair(r, root, "the bus", take_key);
    for (size_t i = 0; i < r->entry_count && !r->mistake.failed; i++) {
        r->entry = &r->entries[i];
        each_pair(r, r->entries[i].node, "a twin", take_twin_key);
    }
}

bool ect_bus_file_is(const char *name)
{
    const char *dot = strncmp(name, "yaml:", 5) != 0 ? strrchr(name, '.') : NULL;
    return dot && !strchr(name, ',') && (strcasecmp(dot, ".yaml") == 0 || strcasecmp(dot, ".yml") == 0);
}

bool ect_bus_file_parse(ect_bus_file_t *file, const char *path, const void *data, size_t length,
                        const ect_bus_options_t *options, char *text, size_t room)
{
    reader_t r = {.file = file, .options = options, .mistake = {.path = path, .text = text, .room = room}};
    *file = (ect_bus_file_t){0};
    ECT_ASSERT(options->find != NULL && room > 0);
    if (ect_yaml_open(&r.yaml, "bus file", &r.mistake, data, length)) {
        take_document(&r);
        ect_yaml_close(&r.yaml);
    }
    free(r.entries);
    return !r.mistake.failed;
}

bool ect_bus_file_read(ect_bus_file_t *file, const char *path, const ect_bus_options_t *options, char *text,
                       size_t room)
{
    size_t length = 0;
    char *data = ect_yaml_load(path, ECT_BUS_FILE_BYTES, &length, text, room);
    *file = (ect_bus_file_t){0};
    bool fine = data && ect_bus_file_parse(file, path, data, length, options, text, room);
    free(data);
    return fine;
}

void ect_bus_file_free(ect_bus_file_t *file)
{
    for (size_t i = 0; i < file->count; i++)
        free(file->words[i]);
    free(file->words);
    free(file->lines);
    free(file->twin_lines);
    free(file->devices);
    *file = (ect_bus_file_t){0};
}
