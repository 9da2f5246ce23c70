/* SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 200809L
#include "products.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "bus/chain/catalogue.h"
#include "devfile/devfile.h"
#include "eni/bus.h"
#include "esi/image.h"
#include "esi/number.h"
#include "sii_file.h"
#include "text/number.h"

/* Twins are freed at the end of the program: chains, signals and messages point into them. */
typedef struct made {
    struct made *next;
    ect_esi_twin_t *twin;
} made_t;

/* Each ESI file is opened once for all its twins: file and bus may be large. */
typedef struct opened {
    struct opened *next;
    ect_esi_t *esi;
} opened_t;

static made_t *all;
static opened_t *files;
static ect_eni_t *network;
static bool quiet;

void product_quiet(void)
{
    quiet = true;
}

/* Not by atexit(): a bus in a master's process is closed by a destructor, and uses its twins until then. */
__attribute__((destructor)) static void free_all(void)
{
    while (all) {
        made_t *next = all->next;
        ect_esi_twin_free(all->twin);
        free(all);
        all = next;
    }
    while (files) {
        opened_t *next = files->next;
        ect_esi_close(files->esi);
        free(files);
        files = next;
    }
    ect_eni_close(network);
    network = NULL;
}

static bool keep(ect_esi_twin_t *twin)
{
    made_t *made = malloc(sizeof *made);
    if (!made)
        return false;
    *made = (made_t){.next = all, .twin = twin};
    all = made;
    return true;
}

static const char *image_of(const char *name)
{
    return strncmp(name, "sii:", 4) == 0 ? name + 4 : NULL;
}

static const char *network_of(const char *name)
{
    return strncmp(name, "eni:", 4) == 0 ? name + 4 : NULL;
}

static const char *text_of(const char *name)
{
    return strncmp(name, "yaml:", 5) == 0 ? name + 5 : NULL;
}

const char *product_file(const char *name)
{
    if (network_of(name) || text_of(name))
        return network_of(name) ? network_of(name) : text_of(name);
    return strncmp(name, "esi:", 4) == 0 ? name + 4 : image_of(name);
}

static ect_esi_t *open_image(const char *path, char *message)
{
    uint8_t *image = malloc(SII_FILE_MOST);
    long size = -1;
    if (image)
        size = sii_file_read(path, image, message, PRODUCT_MESSAGE);
    else
        (void)snprintf(message, PRODUCT_MESSAGE, "%s: no memory left", path);
    ect_esi_t *esi = size >= 0 ? ect_esi_of_image(path, image, (size_t)size, message, PRODUCT_MESSAGE) : NULL;
    free(image);
    return esi;
}

const ect_eni_t *product_network(const char *path, char *message)
{
    if (network && strcmp(ect_eni_file(network), path) == 0)
        return network;
    ect_eni_close(network);
    network = ect_eni_open(path, message, PRODUCT_MESSAGE);
    return network;
}

/* Opens a slave of an ENI, FILE#N. */
static ect_esi_t *open_slave(const char *path, const char *number, char *message)
{
    uint64_t n;
    const ect_eni_t *eni = product_network(path, message);
    size_t count = eni ? ect_eni_network(eni)->slave_count : 0;
    if (!eni)
        return NULL;
    if (ect_number(number, 1, count, &n))
        return ect_eni_device(eni, (size_t)n - 1, message, PRODUCT_MESSAGE);
    (void)snprintf(message, PRODUCT_MESSAGE,
                   "eni:%.300s#N is one slave, N 1 to %zu; 'run' and 'with' take the bus, eni:%s", path, count, path);
    return NULL;
}

/* Opens an ESI file, owned by `files`. */
static ect_esi_t *open_once(const char *path, char *message)
{
    for (const opened_t *file = files; file; file = file->next) {
        if (strcmp(ect_esi_file(file->esi), path) == 0)
            return file->esi;
    }
    ect_esi_t *esi = ect_esi_open(path, message, PRODUCT_MESSAGE);
    opened_t *file = esi ? malloc(sizeof *file) : NULL;
    if (!file) {
        ect_esi_close(esi);
        return NULL;
    }
    *file = (opened_t){.next = files, .esi = esi};
    files = file;
    return esi;
}

static bool is_esi(const char *name)
{
    return !image_of(name) && !network_of(name) && !text_of(name);
}

/* Opens the file of a name as for product_file. @param[out] selector  the part that selects a device */
static ect_esi_t *open_file(const char *name, const char **selector, char *message)
{
    *selector = "";
    if (image_of(name))
        return open_image(image_of(name), message);
    if (text_of(name))
        return ect_devfile_open(text_of(name), message, PRODUCT_MESSAGE);
    const char *file = product_file(name);
    const char *hash = ect_esi_selector(file);
    char *path = strndup(file, hash ? (size_t)(hash - file) : strlen(file));
    ect_esi_t *esi = NULL;
    if (path && network_of(name))
        esi = open_slave(path, hash ? hash + 1 : "", message);
    else if (path)
        esi = open_once(path, message);
    free(path);
    *selector = hash && !network_of(name) ? hash + 1 : "";
    return esi;
}

static const ect_product_t *from_file(const char *name, const ect_module_choice_t *modules, size_t module_count,
                                      ect_behaviour_t behaviour, char *message)
{
    const char *selector;
    ect_esi_t *esi = open_file(name, &selector, message);
    ect_esi_twin_t *twin = NULL;
    if (!is_esi(name))
        twin = ect_esi_twin_take(esi, selector, modules, module_count, message, PRODUCT_MESSAGE);
    const ect_esi_device_t *model =
        esi && is_esi(name) ? ect_esi_select(esi, selector, message, PRODUCT_MESSAGE) : NULL;
    if (model)
        twin = ect_esi_twin_of(esi, model, modules, module_count, message, PRODUCT_MESSAGE);
    if (!twin || !keep(twin) || !ect_esi_twin_behave(twin, behaviour, message, PRODUCT_MESSAGE))
        return NULL;
    size_t count;
    const char *const *notes = ect_esi_twin_notes(twin, &count);
    count = quiet ? 0 : count;
    for (size_t i = 0; i < count; i++)
        (void)fprintf(stderr, "ectwin: %s: %s\n", ect_esi_twin_product(twin)->device->type_name, notes[i]);
    return ect_esi_twin_product(twin);
}

/* @return the prefix that is missing from a file's name, by its extension; NULL: not a file */
static const char *prefix_for(const char *name)
{
    static const struct {
        const char *ending, *prefix;
    } known[] = {{".xml", "esi"}, {".yaml", "yaml"}, {".yml", "yaml"}, {".json", "yaml"}};
    size_t length = strcspn(name, "#");
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++) {
        size_t ending = strlen(known[i].ending);
        if (length > ending && strncasecmp(name + length - ending, known[i].ending, ending) == 0)
            return known[i].prefix;
    }
    return NULL;
}

const ect_product_t *product_find(const char *name, const ect_module_choice_t *modules, size_t module_count,
                                  ect_behaviour_t behaviour, char *message)
{
    if (product_file(name))
        return from_file(name, modules, module_count, behaviour, message);
    const ect_product_t *product = ect_catalogue_find(name);
    if (product && behaviour == ECT_BEHAVIOUR_BY_FILE)
        return product;
    if (product) {
        (void)snprintf(message, PRODUCT_MESSAGE,
                       "'%.60s' has its own behaviour: --behaviour is for twins of files, esi:FILE.xml#TYPE, sii:FILE "
                       "and yaml:FILE",
                       name);
        return NULL;
    }
    const char *prefix = prefix_for(name);
    if (prefix) {
        (void)snprintf(message, PRODUCT_MESSAGE, "'%.200s' is the name of a file: write %s:%.200s for a device of it%s",
                       name, prefix, name,
                       strcmp(prefix, "yaml") == 0 ? "; a bus file is the only operand of run, with or check" : "");
        return NULL;
    }
    int used = snprintf(message, PRODUCT_MESSAGE, "there is no device '%.60s'; there are: ", name);
    for (size_t i = 0; (product = ect_catalogue_at(i)) != NULL && used < PRODUCT_MESSAGE; i++)
        used += snprintf(message + used, (size_t)(PRODUCT_MESSAGE - used), "%s, ", product->device->name);
    if (used < PRODUCT_MESSAGE)
        (void)snprintf(message + used, (size_t)(PRODUCT_MESSAGE - used), "esi:FILE.xml#TYPE, sii:FILE and yaml:FILE");
    return NULL;
}

const ect_esi_twin_t *product_twin(const ect_product_t *product)
{
    for (const made_t *made = all; made; made = made->next) {
        if (ect_esi_twin_product(made->twin) == product)
            return made->twin;
    }
    return NULL;
}

const ect_esi_twin_t *product_twin_of_device(const ect_device_t *device)
{
    for (const made_t *made = all; made; made = made->next) {
        if (ect_esi_twin_product(made->twin)->device == device)
            return made->twin;
    }
    return NULL;
}

bool product_list_file(const char *name, char *message)
{
    const char *selector;
    ect_esi_t *esi = open_file(name, &selector, message);
    if (!esi)
        return false;
    size_t count;
    const ect_esi_head_t *heads = ect_esi_heads(esi, &count);
    for (size_t i = 0; i < count; i++)
        printf("%-24s @0x%08" PRIX32 "/0x%08" PRIX32 "  %s%s%s%s\n", heads[i].type, heads[i].product_code,
               heads[i].revision, heads[i].name, *heads[i].extras != '\0' ? " (" : "", heads[i].extras,
               *heads[i].extras != '\0' ? ")" : "");
    if (!is_esi(name))
        ect_esi_close(esi);
    return true;
}

bool product_parse_module(const char *text, ect_module_choice_t *choice)
{
    char slot[8];
    int64_t number;
    int64_t ident;
    const char *equals = strchr(text, '=');
    if (!equals || equals == text || (size_t)(equals - text) >= sizeof slot)
        return false;
    (void)snprintf(slot, sizeof slot, "%.*s", (int)(equals - text), text);
    if (!ect_esi_parse_number(slot, &number) || number < 1 || number > UINT16_MAX ||
        !ect_esi_parse_number(equals + 1, &ident) || ident < 1 || ident > UINT32_MAX)
        return false;
    *choice = (ect_module_choice_t){.slot = (unsigned int)number - 1, .ident = (uint32_t)ident};
    return true;
}
