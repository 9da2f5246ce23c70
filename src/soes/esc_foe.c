/* SPDX-License-Identifier: MIT */
/* Files of SOES's API, which a master may write and not read, over this stack's FoE (seams/foe.h). */
#include "soes/esc_foe.h"

#include "soes/internal.h"

ect_soes_instance_t ect_soes_instance;

static foe_cfg_t *files;
static foe_file_cfg_t *file; /* file under way */
static uint32_t collected;   /* bytes of the file in the buffer */

void FOE_config(foe_cfg_t *cfg)
{
    files = cfg;
}

void FOE_init(void)
{
    ect_soes_instance.transfer = (ect_foe_transfer_t){0};
}

/* A loop in place of memcmp and strlen, which need more flash in a C library than the rest of this file. */
static bool is_name(const char *name, const ect_foe_file_t *request)
{
    uint16_t n = 0;
    while (n < request->length && name[n] != 0 && name[n] == request->name[n])
        n++;
    return n == request->length && name[n] == 0;
}

static foe_file_cfg_t *find(const ect_foe_file_t *request)
{
    for (uint32_t n = 0; files && n < files->n_files; n++) {
        if (is_name(files->files[n].name, request))
            return &files->files[n];
    }
    return NULL;
}

static uint32_t open_file(const ect_foe_t *foe, void *instance, const ect_foe_file_t *request, const char **text)
{
    foe_file_cfg_t *found = find(request);
    (void)foe;
    (void)instance;
    (void)text;
    if (!found)
        return FOE_ERR_NOTFOUND;
    if (request->password != found->filepass)
        return FOE_ERR_NORIGHTS;
    if (!request->write)
        return FOE_ERR_ACCESS;
    if (found->write_only_in_boot != 0 && request->state != ESCboot)
        return FOE_ERR_NOTINBOOTSTRAP;
    file = found;
    file->address_offset = 0;
    file->total_size = 0;
    collected = 0;
    return ECT_FOE_OK;
}

/* A result that is no error code of FoE is reported as one. */
static uint32_t hand_over(void)
{
    uint32_t error = file->write_function(file, files->fbuffer, collected);
    file->address_offset += collected;
    collected = 0;
    return error == 0 || error >= FOE_ERR_NOTDEFINED ? error : FOE_ERR_PROGERROR;
}

static uint32_t write_file(const ect_foe_t *foe, void *instance, uint32_t offset, const void *data, uint16_t length,
                           bool last, const char **text)
{
    const uint8_t *from = data;
    uint32_t error = ECT_FOE_OK;
    (void)foe;
    (void)instance;
    (void)text;
    if (length > file->max_data - offset)
        return FOE_ERR_DISKFULL;
    for (uint16_t n = 0; n < length && error == ECT_FOE_OK; n++) {
        files->fbuffer[collected++] = from[n];
        if (collected == files->buffer_size)
            error = hand_over();
    }
    file->total_size += length;
    return error == ECT_FOE_OK && last ? hand_over() : error;
}

const ect_foe_t ect_soes_files = {
    ECT_FOE_PROTOCOL,
    .offset = offsetof(ect_soes_instance_t, transfer),
    .read_states = ECT_IN_PREOP_AND_ABOVE | ECT_IN(ESCboot),
    .write_states = ECT_IN_PREOP_AND_ABOVE | ECT_IN(ESCboot),
    .open = open_file,
    .write = write_file,
};
