/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "network.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bus/chain/catalogue.h"
#include "eni/bus.h"
#include "esi/read.h"
#include "esi_dir.h"
#include "products.h"

const char *network_path(const char *name)
{
    if (strncmp(name, "eni:", 4) != 0 || ect_esi_selector(name + 4))
        return NULL;
    return name + 4;
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
        fprintf(stderr, "; its AutoIncAddr is %" PRId64 "; its place in the file requires %zu", slave->place.value,
                i + 1);
    if (slave->mailbox.others > 0)
        fprintf(stderr, "; its %zu start-up commands of FoE, or without a mail, have no effect on the twin",
                slave->mailbox.others);
    fprintf(stderr, "\n");
}

/* Reads the network and allocates the names. @return NULL: see message */
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

static ect_identity_t *identities_of(const ect_eni_network_t *network, char *message)
{
    ect_identity_t *identities = calloc(network->slave_count, sizeof *identities);
    for (size_t i = 0; identities && i < network->slave_count; i++) {
        const ect_eni_slave_t *slave = &network->slaves[i];
        identities[i] = (ect_identity_t){
            .vendor_id = slave->vendor_id, .product_code = slave->product_code, .revision = slave->revision};
    }
    if (!identities)
        snprintf(message, PRODUCT_MESSAGE, "no memory left");
    return identities;
}

/* Names the slaves without an ESI file. */
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
    ect_identity_t *identities = network ? identities_of(network, message) : NULL;
    const bool fine = identities &&
                      (!esi_dir || esi_dir_search(esi_dir, identities, names->names, names->count, message)) &&
                      end_names(names, path);
    free(identities);
    for (size_t i = 0; fine && i < names->count && !quiet; i++)
        print_slave(&network->slaves[i], i, names->names[i]);
    return fine;
}

static bool is_same(const ect_identity_t *a, const ect_identity_t *b)
{
    return a->vendor_id == b->vendor_id && a->product_code == b->product_code && a->revision == b->revision;
}

/* A device of `ectwin list`, or of a file with its prefix, as esi:FILE#TYPE. @return false: see message */
static bool take_device(network_names_t *names, const char *device, const ect_identity_t *identities, char *message)
{
    const ect_product_t *product = product_find(device, NULL, 0, ECT_BEHAVIOUR_BY_FILE, message);
    for (size_t i = 0; product && i < names->count; i++) {
        if (names->names[i] || !is_same(&identities[i], &product->device->identity))
            continue;
        names->names[i] = strdup(device);
        if (!names->names[i]) {
            snprintf(message, PRODUCT_MESSAGE, "no memory left");
            return false;
        }
    }
    return product != NULL;
}

static bool is_device(const char *name)
{
    return product_file(name) || ect_catalogue_find(name);
}

bool network_names_of_files(network_names_t *names, const char *path, const char *const files[], size_t count,
                            char *message)
{
    const ect_eni_network_t *network = begin_names(names, path, message);
    ect_identity_t *identities = network ? identities_of(network, message) : NULL;
    bool fine = identities != NULL;
    for (size_t i = 0; fine && i < count; i++)
        fine = is_device(files[i]) ? take_device(names, files[i], identities, message)
                                   : esi_dir_search_file(files[i], identities, names->names, names->count, message);
    free(identities);
    return fine && end_names(names, path);
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
