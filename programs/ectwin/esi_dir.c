/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "esi_dir.h"

#include <dirent.h>
#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "esi/read.h"
#include "products.h"

static int is_xml(const struct dirent *entry)
{
    size_t length = strlen(entry->d_name);
    return length > 4 && strcasecmp(entry->d_name + length - 4, ".xml") == 0;
}

/* @return whether exactly one device of the file has the identity. Only devices with its product and revision are read.
 */
static bool has_device(ect_esi_t *esi, const ect_identity_t *identity)
{
    char selector[32], why[PRODUCT_MESSAGE];
    size_t count;
    const ect_esi_head_t *heads = ect_esi_heads(esi, &count);
    bool there = false;
    for (size_t i = 0; i < count && !there; i++)
        there = heads[i].product_code == identity->product_code && heads[i].revision == identity->revision;
    if (!there)
        return false;
    snprintf(selector, sizeof selector, "@%" PRIu32 "/%" PRIu32, identity->product_code, identity->revision);
    const ect_esi_device_t *model = ect_esi_select(esi, selector, why, sizeof why);
    return model && model->vendor_id == identity->vendor_id;
}

bool esi_dir_search_file(const char *path, const ect_identity_t *identities, char **names, size_t count, char *message)
{
    ect_esi_t *esi = ect_esi_open(path, message, PRODUCT_MESSAGE);
    bool fine = esi != NULL;
    for (size_t i = 0; esi && fine && i < count; i++) {
        const ect_identity_t *one = &identities[i];
        if (!names[i] && has_device(esi, one))
            fine = asprintf(&names[i], "esi:%s#@0x%08" PRIX32 "/0x%08" PRIX32, path, one->product_code,
                            one->revision) >= 0;
    }
    ect_esi_close(esi);
    return fine;
}

bool esi_dir_search(const char *folder, const ect_identity_t *identities, char **names, size_t count, char *message)
{
    struct dirent **entries = NULL;
    int files = scandir(folder, &entries, is_xml, alphasort);
    char why[PRODUCT_MESSAGE];
    if (files < 0)
        snprintf(message, PRODUCT_MESSAGE, "--esi-dir %.300s: %s", folder, strerror(errno));
    for (int i = 0; i < files; i++) {
        char *path = NULL;
        if (asprintf(&path, "%s/%s", folder, entries[i]->d_name) >= 0)
            (void)esi_dir_search_file(path, identities, names, count, why); /* other files are ignored */
        free(path);
        free(entries[i]);
    }
    free(entries);
    return files >= 0;
}
