/* SPDX-License-Identifier: MIT */
#include "twin_storage.h"

#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>

#include "sii_file.h"

/* Copies the content of the banks for a record, or sets it from a record. */
static bool exchange_memory(twin_args_t *args, size_t i)
{
    const ect_storage_t *storage = ect_memory_storage(args->memories[i]);
    if (!args->store || !(args->record || args->replayed))
        return true;
    uint8_t *data = malloc(storage->bank_size);
    bool done = data != NULL;
    for (unsigned int bank = 0; done && bank < 2; bank++) {
        char name[CONTENT_NAME];
        content_name_memory(name, i + 1, bank);
        const content_piece_t *piece = content_find(&args->content, name);
        if (args->replayed && piece && piece->size <= storage->bank_size)
            done = storage->write(storage->ctx, bank, 0, piece->data, (uint32_t)piece->size) == 0;
        else if (!args->replayed)
            done = storage->read(storage->ctx, bank, 0, data, storage->bank_size) == 0 &&
                   content_keep(&args->content, name, data, storage->bank_size);
    }
    free(data);
    return done;
}

static bool open_memories(twin_args_t *args, const char *who)
{
    char message[ECT_MEMORY_MESSAGE] = "out of memory";
    const char *store = args->replayed ? NULL : args->store;
    args->memories = calloc(args->count, sizeof(ect_memory_t *));
    if (store)
        (void)mkdir(store, 0700); /* may exist; a failure is reported when a file is opened */
    for (size_t i = 0; args->memories && i < args->count; i++) {
        char path[ECT_MEMORY_PATH];
        int length = snprintf(path, sizeof path, "%s/%s-%zu", store ? store : "", args->twins[i].device->name, i + 1);
        if (length < (int)sizeof path)
            args->memories[i] = ect_memory_open(store ? path : NULL, message);
        else
            snprintf(message, sizeof message, "the folder's name is too long");
        const char *why = !args->memories[i] ? message : exchange_memory(args, i) ? NULL : "out of memory";
        if (why) {
            twin_args_report_option(args, who, args->store, "%s", why);
            return false;
        }
        if (*message)
            fprintf(stderr, "%s: %s\n", who, message);
        args->twins[i].storage = ect_memory_storage(args->memories[i]);
    }
    return args->memories != NULL;
}

/* Replaces the device of each twin by one with files. */
static bool open_files(twin_args_t *args, const char *who)
{
    char message[ECT_FILES_MESSAGE] = "out of memory";
    args->opened = calloc(args->count, sizeof(ect_files_t *));
    bool done = args->opened != NULL;
    for (size_t i = 0; done && args->files && i < args->count; i++) {
        args->opened[i] = ect_files_open(args->files, args->twins[i].device, args->files_password, message);
        done = args->opened[i] != NULL;
        if (done)
            args->twins[i].device = ect_files_device(args->opened[i]);
    }
    if (!done)
        twin_args_report_option(args, who, args->files, "--files: %s", message);
    return done;
}

static bool open_eeprom(twin_args_t *args, size_t i, char *message)
{
    ect_twin_config_t *twin = &args->twins[i];
    char path[ECT_EEPROM_PATH], name[CONTENT_NAME];
    uint8_t *factory = sii_file_make(twin->device, &twin->identity, twin->alias, message, ECT_EEPROM_MESSAGE);
    int length = snprintf(path, sizeof path, "%s/%s-%zu.sii", args->store, twin->device->name, i + 1);
    if (length >= (int)sizeof path)
        snprintf(message, ECT_EEPROM_MESSAGE, "the folder's name is too long");
    else if (factory)
        args->eeproms[i] = ect_eeprom_open(path, factory, twin->device->sii_size, message);
    free(factory);
    if (!args->eeproms[i])
        return false;
    twin->sii = ect_eeprom_image(args->eeproms[i]);
    twin->sii_written = ect_eeprom_write;
    twin->sii_ctx = args->eeproms[i];
    content_name_eeprom(name, i + 1);
    snprintf(message, ECT_EEPROM_MESSAGE, "out of memory");
    return !args->record || content_keep(&args->content, name, twin->sii, twin->device->sii_size);
}

/* Sets the EEPROM from a record, padded with zeros to its full size: a record has no zeros at the end. */
static bool take_eeprom(twin_args_t *args, size_t i)
{
    ect_twin_config_t *twin = &args->twins[i];
    char name[CONTENT_NAME];
    content_name_eeprom(name, i + 1);
    return content_pad(&args->content, name, twin->device->sii_size, &twin->sii);
}

static bool open_eeproms(twin_args_t *args, const char *who)
{
    char message[ECT_EEPROM_MESSAGE] = "out of memory";
    args->eeproms = calloc(args->count, sizeof(ect_eeprom_t *));
    bool done = args->eeproms != NULL;
    for (size_t i = 0; done && args->store && i < args->count; i++)
        done = args->replayed ? take_eeprom(args, i) : open_eeprom(args, i, message);
    if (!done)
        twin_args_report_option(args, who, args->store, "%s", message);
    return done;
}

bool twin_storage_open(twin_args_t *args, const char *who)
{
    return open_files(args, who) && open_memories(args, who) && open_eeproms(args, who);
}

void twin_storage_wait(twin_args_t *args)
{
    for (size_t i = 0; i < args->count; i++)
        ect_memory_wait(args->memories[i]);
}
