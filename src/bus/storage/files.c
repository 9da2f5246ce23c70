/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bus/storage/files.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { NAME = 128, PROTOCOLS = 16, NONE = -1 };
enum { EVERYWHERE = ECT_IN_PREOP_AND_ABOVE | ECT_IN(ECT_STATE_BOOT) };

struct ect_files {
    ect_foe_t foe; /* first member: functions get its address */
    ect_device_t device;
    const ect_protocol_t *protocols[PROTOCOLS + 2];
    uint32_t password;
    int folder;
    int file; /* the open file */
    bool writing;
    char name[NAME + 1];
    char draft[NAME + 8]; /* name of an incomplete file */
};

static ect_files_t *files_of(const ect_foe_t *foe)
{
    return (ect_files_t *)(uintptr_t)foe; /* only the stack regards the entry as constant */
}

/* --- one file ----------------------------------------------------------------------------------------------------- */

bool ect_files_fits(const char *name, size_t length)
{
    static const char good[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789._-+";
    size_t fit = 0;
    while (fit < length && name[fit] != 0 && strchr(good, name[fit]))
        fit++;
    return length >= 1 && length <= NAME && name[0] != '.' && fit == length;
}

static bool take_name(ect_files_t *f, const char *name, size_t length)
{
    if (!ect_files_fits(name, length))
        return false;
    memcpy(f->name, name, length);
    f->name[length] = '\0';
    (void)snprintf(f->draft, sizeof f->draft, ".%s.part", f->name);
    return true;
}

static uint32_t code_of(int error)
{
    switch (error) {
    case ENOENT:
        return ECT_FOE_NOT_FOUND;
    case ENOSPC:
    case EDQUOT:
    case EFBIG:
        return ECT_FOE_DISK_FULL;
    case EIO:
        return ECT_FOE_PROGRAM_ERROR;
    default:
        return ECT_FOE_ACCESS;
    }
}

static void close_file(ect_files_t *f)
{
    if (f->file == NONE)
        return;
    (void)close(f->file);
    f->file = NONE;
    if (f->writing)
        (void)unlinkat(f->folder, f->draft, 0);
}

/* Refuses links, folders and pipes. */
static uint32_t check_place(const ect_files_t *f, bool write)
{
    struct stat status;
    if (fstatat(f->folder, f->name, &status, AT_SYMLINK_NOFOLLOW) != 0)
        return errno == ENOENT && write ? ECT_FOE_OK : code_of(errno);
    return S_ISREG(status.st_mode) ? ECT_FOE_OK : ECT_FOE_ACCESS;
}

static uint32_t open_file(const ect_foe_t *foe, void *instance, const ect_foe_file_t *request, const char **text)
{
    enum { READ = O_RDONLY, WRITE = O_WRONLY | O_CREAT | O_EXCL, SAFELY = O_NOFOLLOW | O_CLOEXEC | O_NONBLOCK };
    ect_files_t *f = files_of(foe);
    (void)instance;
    close_file(f); /* left open by a power cycle of the twin */
    if (f->password != 0 && request->password != f->password)
        return ECT_FOE_ACCESS;
    if (!take_name(f, request->name, request->length)) {
        *text = "not a name of a file here";
        return ECT_FOE_NOT_FOUND;
    }
    uint32_t code = check_place(f, request->write);
    if (code != ECT_FOE_OK)
        return code;
    if (request->write)
        (void)unlinkat(f->folder, f->draft, 0);
    f->writing = request->write;
    f->file = openat(f->folder, request->write ? f->draft : f->name, (request->write ? WRITE : READ) | SAFELY, 0644);
    return f->file != NONE ? ECT_FOE_OK : code_of(errno);
}

static uint32_t read_file(const ect_foe_t *foe, void *instance, uint32_t offset, void *data, uint16_t *length,
                          const char **text)
{
    ect_files_t *f = files_of(foe);
    (void)instance;
    (void)text;
    uint16_t got = 0;
    while (got < *length) { /* only the last block is shorter */
        ssize_t more = pread(f->file, (uint8_t *)data + got, (size_t)*length - got, (off_t)offset + got);
        if (more < 0) {
            close_file(f);
            return ECT_FOE_PROGRAM_ERROR;
        }
        if (more == 0)
            break;
        got = (uint16_t)(got + more);
    }
    *length = got;
    return ECT_FOE_OK;
}

/* Renames the complete file. */
static bool finish(ect_files_t *f)
{
    if (renameat(f->folder, f->draft, f->folder, f->name) != 0)
        return false;
    f->writing = false;
    return true;
}

static uint32_t write_file(const ect_foe_t *foe, void *instance, uint32_t offset, const void *data, uint16_t length,
                           bool last, const char **text)
{
    ect_files_t *f = files_of(foe);
    (void)instance;
    (void)text;
    errno = EFBIG;
    bool fine = (uint64_t)offset + length <= ECT_FILES_MOST && pwrite(f->file, data, length, (off_t)offset) == length;
    if (fine && last)
        fine = finish(f);
    if (fine)
        return ECT_FOE_OK;
    uint32_t code = code_of(errno);
    close_file(f);
    return code;
}

static void closed(const ect_foe_t *foe, void *instance, bool whole)
{
    (void)instance;
    (void)whole;
    close_file(files_of(foe));
}

/* --- a device with files ------------------------------------------------------------------------------------------ */

static const char *why_not(const ect_device_t *device)
{
    size_t count = 0;
    if (device->mailbox_protocols == 0)
        return "the device has no mailbox";
    for (const ect_protocol_t *const *p = device->protocols; p && *p; p++, count++) {
        if ((*p)->type == ECT_MAILBOX_TYPE_FOE && (*p)->request)
            return "the device has files of its own";
    }
    return count <= PROTOCOLS ? NULL : "the device has too many protocols";
}

static void make_device(ect_files_t *f, const ect_device_t *device)
{
    enum { ALIGNED = sizeof(max_align_t) };
    size_t count = 1, offset = (device->instance_size + ALIGNED - 1) / ALIGNED * ALIGNED;
    f->device = *device;
    for (const ect_protocol_t *const *p = device->protocols; p && *p; p++)
        f->protocols[count++] = *p;
    f->protocols[0] = &f->foe.protocol; /* before an unsupported FoE; EoE remains the last one */
    f->device.protocols = f->protocols;
    f->device.mailbox_protocols |= ECT_MAILBOX_FOE;
    f->device.instance_size = offset + sizeof(ect_foe_transfer_t);
    if (device->boot_out.length == 0) {
        f->device.boot_out = (ect_boot_mailbox_t){device->sm[0].start, device->sm[0].length};
        f->device.boot_in = (ect_boot_mailbox_t){device->sm[1].start, device->sm[1].length};
    }
    f->foe = (ect_foe_t){.protocol = ECT_FOE_PROTOCOL,
                         .offset = offset,
                         .read_states = EVERYWHERE,
                         .write_states = EVERYWHERE,
                         .open = open_file,
                         .read = read_file,
                         .write = write_file,
                         .close = closed};
}

ect_files_t *ect_files_open(const char *folder, const ect_device_t *device, uint32_t password, char *message)
{
    const char *reason = why_not(device);
    ect_files_t *f = calloc(1, sizeof *f);
    int fd = reason ? NONE : open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (!f || fd == NONE) {
        if (reason)
            (void)snprintf(message, ECT_FILES_MESSAGE, "'%s' cannot offer files: %s", device->name, reason);
        else
            (void)snprintf(message, ECT_FILES_MESSAGE, "cannot open the folder '%.400s' for files: %s", folder,
                           strerror(f ? errno : ENOMEM));
        free(f);
        return NULL;
    }
    f->folder = fd;
    f->file = NONE;
    f->password = password;
    make_device(f, device);
    return f;
}

const ect_device_t *ect_files_device(const ect_files_t *files)
{
    return &files->device;
}

void ect_files_close(ect_files_t *files)
{
    if (!files)
        return;
    close_file(files);
    (void)close(files->folder);
    free(files);
}
