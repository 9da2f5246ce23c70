/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "network.h"

#include <dirent.h>
#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "eni/bus.h"
#include "esi/read.h"
#include "products.h"

const char *network_path(const char *name)
{
    if (strncmp(name, "eni:", 4) != 0 || ect_esi_selector(name + 4))
        return NULL;
    return name + 4;
}

/* --- a folder of ESI files ---------------------------------------------------------------------------------------- */

static int is_xml(const struct dirent *entry)
{
    size_t length = strlen(entry->d_name);
    return length > 4 && strcasecmp(entry->d_name + length - 4, ".xml") == 0;
}

/* Whether an ESI file has the device of a slave, alone. A model is read in full only where product and revision fit. */
static bool has_device(ect_esi_t *esi, const ect_eni_slave_t *slave)
{
    char selector[32], why[PRODUCT_MESSAGE];
    size_t count;
    const ect_esi_head_t *heads = ect_esi_heads(esi, &count);
    bool there = false;
    for (size_t i = 0; i < count && !there; i++)
        there = heads[i].product_code == slave->product_code && heads[i].revision == slave->revision;
    if (!there)
        return false;
    snprintf(selector, sizeof selector, "@%" PRIu32 "/%" PRIu32, slave->product_code, slave->revision);
    const ect_esi_device_t *model = ect_esi_select(esi, selector, why, sizeof why);
    return model && model->vendor_id == slave->vendor_id;
}

/* Names the device of each slave that has none yet and is in this file. @return false: the file cannot be read */
static bool search_file(network_names_t *names, const ect_eni_network_t *network, const char *path, char *message)
{
    ect_esi_t *esi = ect_esi_open(path, message, PRODUCT_MESSAGE);
    bool fine = esi != NULL;
    for (size_t i = 0; esi && fine && i < names->count; i++) {
        const ect_eni_slave_t *slave = &network->slaves[i];
        if (!names->names[i] && has_device(esi, slave))
            fine = asprintf(&names->names[i], "esi:%s#@0x%08" PRIX32 "/0x%08" PRIX32, path, slave->product_code,
                            slave->revision) >= 0;
    }
    ect_esi_close(esi);
    return fine;
}

static bool search_folder(network_names_t *names, const ect_eni_network_t *network, const char *folder, char *message)
{
    struct dirent **entries = NULL;
    int count = scandir(folder, &entries, is_xml, alphasort);
    char why[PRODUCT_MESSAGE];
    if (count < 0)
        snprintf(message, PRODUCT_MESSAGE, "--esi-dir %.300s: %s", folder, strerror(errno));
    for (int i = 0; i < count; i++) {
        char *path = NULL;
        if (asprintf(&path, "%s/%s", folder, entries[i]->d_name) >= 0)
            (void)search_file(names, network, path, why); /* other files may lie there */
        free(path);
        free(entries[i]);
    }
    free(entries);
    return count >= 0;
}

/* ------------------------------------------------------------------------------------------------------------------ */

static void print_slave(const ect_eni_slave_t *slave, size_t i, const char *name)
{
    const bool from_esi = strncmp(name, "esi:", 4) == 0;
    fprintf(stderr, "ectwin: slave %zu, %s: %s", i + 1, *slave->name != '\0' ? slave->name : "without a name",
            from_esi ? name + 4 : "from the ENI alone, without a dictionary of its own");
    if (slave->group)
        fprintf(stderr, "; hot-connect group%s%s, plugged in", *slave->group != '\0' ? " " : "", slave->group);
    if (slave->place.given && (uint16_t)slave->place.value != (uint16_t)(0 - i))
        fprintf(stderr, "; its AutoIncAddr is %" PRId64 ", its place in the file %zu", slave->place.value, i + 1);
    fprintf(stderr, "\n");
}

/* Room for the names. @return the network, NULL: it cannot be read */
static const ect_eni_network_t *begin_names(network_names_t *names, const char *path, char *message)
{
    *names = (network_names_t){0};
    const ect_eni_t *eni = product_network(path, message);
    if (!eni)
        return NULL;
    const ect_eni_network_t *network = ect_eni_network(eni);
    names->names = calloc(network->slave_count, sizeof *names->names);
    names->count = names->names ? network->slave_count : 0;
    snprintf(message, PRODUCT_MESSAGE, "no memory left");
    return names->names ? network : NULL;
}

/* The slaves that no ESI file has. */
static bool end_names(network_names_t *names, const char *path)
{
    for (size_t i = 0; i < names->count; i++) {
        if (!names->names[i] && asprintf(&names->names[i], "eni:%s#%zu", path, i + 1) < 0)
            return false;
    }
    return true;
}

bool network_names(network_names_t *names, const char *path, const char *esi_dir, bool quiet, char *message)
{
    const ect_eni_network_t *network = begin_names(names, path, message);
    if (!network || (esi_dir && !search_folder(names, network, esi_dir, message)) || !end_names(names, path))
        return false;
    for (size_t i = 0; i < names->count && !quiet; i++)
        print_slave(&network->slaves[i], i, names->names[i]);
    return true;
}

bool network_names_of_files(network_names_t *names, const char *path, const char *const files[], size_t count,
                            char *message)
{
    const ect_eni_network_t *network = begin_names(names, path, message);
    for (size_t i = 0; network && i < count; i++) {
        if (!search_file(names, network, files[i], message))
            return false;
    }
    return network && end_names(names, path);
}

void network_names_free(network_names_t *names)
{
    for (size_t i = 0; i < names->count; i++)
        free(names->names[i]);
    free(names->names);
    *names = (network_names_t){0};
}

bool network_apply(const char *path, ect_twin_config_t *twins, size_t first, char *message)
{
    const ect_eni_t *eni = product_network(path, message);
    const ect_eni_network_t *network = eni ? ect_eni_network(eni) : NULL;
    ect_eni_place_t place = {.port = 0};
    for (size_t i = 0; network && i < network->slave_count; i++) {
        ect_twin_config_t *twin = &twins[first + i];
        if (!ect_eni_place(eni, i, &place, message, PRODUCT_MESSAGE))
            return false;
        twin->up = place.port != 0 ? first + place.up : 0;
        twin->up_port = place.port;
        twin->alias = ect_eni_alias(&network->slaves[i]);
        if (network->slaves[i].serial != 0)
            twin->identity.serial = network->slaves[i].serial;
    }
    return network != NULL;
}
