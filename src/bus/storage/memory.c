/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bus/storage/memory.h"

#include <aio.h>
#include <errno.h>
#include <fcntl.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "seams/record.h"
#include "wire/assert.h"

/* A file consists of a header and a bank. Reads use a copy of the bank in memory, so changes of the file by other
 * programs have no effect on the twin. Without a path the bank is only in memory. The C library's aio thread waits for
 * the disk. */
enum { HEAD = 32, FILE_SIZE = HEAD + ECT_MEMORY_BANK, NAME = ECT_MEMORY_PATH + 16, MOST_KEPT = 9 };

static const uint8_t head[HEAD] = "ectwin store 1\n";

typedef struct bank {
    int fd; /* -1: none */
    uint8_t *image;
    bool written; /* whether bytes were written since the start of the last synchronisation */
    bool syncing;
    struct aiocb sync;
} bank_t;

struct ect_memory {
    ect_storage_t storage;
    bank_t banks[2];
    void (*saved)(void *ctx, size_t number); /* NULL: none */
    void *saved_ctx;
    size_t number;
    bool waits;                            /* for the end of each synchronisation */
    int (*flushed)(void *ctx, int result); /* NULL: none */
    void *flushed_ctx;
};

static int bank_read(void *ctx, unsigned int bank, uint32_t offset, void *buffer, uint32_t length)
{
    const ect_memory_t *m = ctx;
    ECT_ASSERT(bank < 2 && offset <= ECT_MEMORY_BANK && length <= ECT_MEMORY_BANK - offset);
    memcpy(buffer, m->banks[bank].image + offset, length);
    return 0;
}

/* A save ends with the header of its record. */
static void note_save(const ect_memory_t *m, uint32_t offset, const void *data, uint32_t length)
{
    static const uint8_t nothing[ECT_RECORD_HEADER];
    if (m->saved && offset == 0 && length == ECT_RECORD_HEADER && memcmp(data, nothing, length) != 0)
        m->saved(m->saved_ctx, m->number);
}

static int bank_write(void *ctx, unsigned int bank, uint32_t offset, const void *data, uint32_t length)
{
    ect_memory_t *m = ctx;
    bank_t *b = &m->banks[bank];
    ECT_ASSERT(bank < 2 && offset <= ECT_MEMORY_BANK && length <= ECT_MEMORY_BANK - offset);
    memcpy(b->image + offset, data, length);
    note_save(m, offset, data, length);
    if (b->fd < 0)
        return 0;
    b->written = true;
    return pwrite(b->fd, data, length, (off_t)HEAD + (off_t)offset) == (ssize_t)length ? 0 : -1;
}

/* Erases only the header, because files can be overwritten; an interrupted save then leaves a bank without a record. */
static int bank_erase(void *ctx, unsigned int bank)
{
    static const uint8_t nothing[ECT_RECORD_HEADER];
    return bank_write(ctx, bank, 0, nothing, sizeof nothing);
}

/* A deleted, truncated or renamed file would not be read at the next start. */
static bool still_there(const bank_t *b)
{
    struct stat info;
    return fstat(b->fd, &info) == 0 && info.st_nlink > 0 && info.st_size == FILE_SIZE;
}

static bool begin_sync(bank_t *b)
{
    b->sync = (struct aiocb){.aio_fildes = b->fd, .aio_sigevent = {.sigev_notify = SIGEV_NONE}};
    if (!still_there(b) || aio_fsync(O_DSYNC, &b->sync) < 0)
        return false;
    b->written = false;
    b->syncing = true;
    return true;
}

/* Ends the synchronisation in progress. @return as ect_storage_t::flush */
static int end_sync(bank_t *b, bool wait)
{
    const struct aiocb *const all[] = {&b->sync};
    int error = aio_error(&b->sync);
    while (wait && error == EINPROGRESS) {
        (void)aio_suspend(all, 1, NULL);
        error = aio_error(&b->sync);
    }
    if (error == EINPROGRESS)
        return ECT_STORAGE_BUSY;
    b->syncing = false;
    return aio_return(&b->sync) < 0 ? -1 : 0;
}

static int flush(bank_t *b, bool wait)
{
    int result = 0;
    while (result == 0 && (b->syncing || b->written)) {
        if (!b->syncing && !begin_sync(b))
            return -1;
        result = end_sync(b, wait);
    }
    return result;
}

static int bank_flush(void *ctx, unsigned int bank, bool wait)
{
    ect_memory_t *m = ctx;
    int result = flush(&m->banks[bank], wait || m->waits);
    return m->flushed ? m->flushed(m->flushed_ctx, result) : result;
}

/* --- opening ------------------------------------------------------------------------------------------------------ */

/* Synchronises the folder, which contains the name of a new file. */
static int sync_folder(const char *name)
{
    char folder[NAME];
    const char *end = strrchr(name, '/');
    snprintf(folder, sizeof folder, "%.*s", end ? (int)(end - name) : 1, end ? name : ".");
    int fd = open(*folder ? folder : "/", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    int result = fd < 0 ? -1 : fsync(fd);
    if (fd >= 0)
        close(fd);
    return result;
}

/* Skips holes: the banks of a thousand twins are nearly empty. */
static bool read_image(const bank_t *b)
{
    for (off_t at = lseek(b->fd, HEAD, SEEK_DATA); at >= 0 && at < FILE_SIZE;) {
        ssize_t got = pread(b->fd, b->image + (at - HEAD), (size_t)(FILE_SIZE - at), at);
        if (got <= 0)
            return false;
        at = lseek(b->fd, at + got, SEEK_DATA);
    }
    return true;
}

static const char *make_empty(const bank_t *b, const char *name)
{
    bool done = ftruncate(b->fd, FILE_SIZE) == 0 && pwrite(b->fd, head, HEAD, 0) == HEAD && fsync(b->fd) == 0 &&
                sync_folder(name) == 0;
    return done ? NULL : strerror(errno);
}

/* @return whether make_empty() was interrupted, or failed on a full disk */
static bool is_unmade(const bank_t *b, const uint8_t found[HEAD])
{
    static const uint8_t nothing[HEAD];
    if (memcmp(found, nothing, HEAD) != 0 || !read_image(b))
        return false;
    return b->image[0] == 0 && memcmp(b->image, b->image + 1, ECT_MEMORY_BANK - 1) == 0;
}

/* Accepts only files of this module; other files are unchanged. @return the reason of a refusal; NULL: accepted */
static const char *take_file(const bank_t *b, const char *name)
{
    static const char foreign[] = "it is not a twin's record; the file is left unchanged";
    struct stat info;
    uint8_t found[HEAD];
    if (fstat(b->fd, &info) < 0 || !S_ISREG(info.st_mode))
        return "it is not a regular file";
    if (flock(b->fd, LOCK_EX | LOCK_NB) < 0) /* two twins would overwrite each other's records */
        return errno == EWOULDBLOCK ? "another twin uses it" : strerror(errno);
    if (info.st_size == 0)
        return make_empty(b, name);
    if (info.st_size != FILE_SIZE || pread(b->fd, found, HEAD, 0) != HEAD)
        return foreign;
    if (memcmp(found, head, HEAD) != 0)
        return is_unmade(b, found) ? make_empty(b, name) : foreign;
    return read_image(b) ? NULL : strerror(errno);
}

static const char *open_file(bank_t *b, const char *name)
{
    b->fd = open(name, O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0600);
    if (b->fd < 0)
        return errno == ELOOP ? "it is a link" : strerror(errno);
    return take_file(b, name);
}

static bool has_record(const ect_storage_t *storage, unsigned int bank, uint32_t magic, ect_record_t *record)
{
    return ect_record_header(storage, bank, magic, record) > 0 && ect_record_data_good(record) > 0;
}

/* A bank without a header was never written, or its last save was interrupted. After a power failure it may still have
 * the header of the previous record, which is older than the record in the other bank. */
static bool is_ordinary(const ect_storage_t *storage, unsigned int bank)
{
    static const uint8_t empty[ECT_RECORD_HEADER];
    uint8_t header[ECT_RECORD_HEADER];
    ect_record_t record, other;
    (void)storage->read(storage->ctx, bank, 0, header, sizeof header);
    uint32_t magic = ect_load_le32(header);
    if (memcmp(header, empty, sizeof header) == 0 || has_record(storage, bank, magic, &record))
        return true;
    return has_record(storage, bank ^ 1u, magic, &other) && (int32_t)(record.sequence - other.sequence) < 0;
}

/* Renames a file to the first free name, or the last name. */
static bool rename_damaged(const char *name, char *other, size_t room)
{
    for (int n = 1; n < MOST_KEPT; n++) {
        snprintf(other, room, "%s.damaged%d", name, n);
        if (link(name, other) == 0)
            return unlink(name) == 0;
        if (errno != EEXIST)
            return false;
    }
    snprintf(other, room, "%s.damaged%d", name, MOST_KEPT);
    return rename(name, other) == 0;
}

/* Keeps a damaged file under another name, for repair by the user, and creates an empty one. @return the reason of a
 * failure; NULL: done */
static const char *keep_aside(ect_memory_t *m, unsigned int bank, const char *name, char *message)
{
    bank_t *b = &m->banks[bank];
    char other[NAME + 32];
    if (!rename_damaged(name, other, sizeof other))
        return strerror(errno);
    size_t used = strlen(message);
    const char *end = strrchr(other, '/');
    snprintf(message + used, ECT_MEMORY_MESSAGE - used, "%s'%.200s' has no complete record and is kept as '%.30s'",
             used > 0 ? "; " : "", name, end ? end + 1 : other);
    close(b->fd);
    memset(b->image, 0, ECT_MEMORY_BANK);
    return open_file(b, name);
}

static void name_bank(char name[NAME], const char *path, unsigned int bank)
{
    snprintf(name, NAME, "%s.%u", path, bank);
}

static const char *open_bank(ect_memory_t *m, unsigned int bank, const char *path)
{
    char name[NAME];
    m->banks[bank].image = calloc(1, ECT_MEMORY_BANK);
    if (!m->banks[bank].image)
        return "not enough memory";
    if (!path)
        return NULL;
    name_bank(name, path, bank);
    return open_file(&m->banks[bank], name);
}

static const char *check_bank(ect_memory_t *m, unsigned int bank, const char *path, char *message)
{
    char name[NAME];
    if (!path || is_ordinary(&m->storage, bank))
        return NULL;
    name_bank(name, path, bank);
    return keep_aside(m, bank, name, message);
}

static ect_memory_t *make_memory(void)
{
    ect_memory_t *m = calloc(1, sizeof *m);
    if (!m)
        return NULL;
    m->banks[0].fd = m->banks[1].fd = -1;
    m->storage = (ect_storage_t){.ctx = m,
                                 .bank_size = ECT_MEMORY_BANK,
                                 .read = bank_read,
                                 .erase = bank_erase,
                                 .write = bank_write,
                                 .flush = bank_flush};
    return m;
}

ect_memory_t *ect_memory_open(const char *path, char *message)
{
    ect_memory_t *m = make_memory();
    const char *why = !m                                        ? "not enough memory"
                      : path && strlen(path) >= ECT_MEMORY_PATH ? strerror(ENAMETOOLONG)
                                                                : NULL;
    unsigned int step = 0;
    *message = 0;
    for (; step < 4 && !why; step++)
        why = step < 2 ? open_bank(m, step, path) : check_bank(m, step - 2, path, message);
    if (!why)
        return m;
    if (path)
        snprintf(message, ECT_MEMORY_MESSAGE, "cannot keep what is saved in '%.400s.%u': %s", path,
                 step > 0 ? (step - 1) % 2 : 0, why);
    else
        snprintf(message, ECT_MEMORY_MESSAGE, "cannot keep what is saved: %s", why);
    ect_memory_close(m);
    return NULL;
}

void ect_memory_close(ect_memory_t *memory)
{
    if (!memory)
        return;
    for (unsigned int bank = 0; bank < 2; bank++) {
        bank_t *b = &memory->banks[bank];
        if (b->syncing)
            (void)end_sync(b, true);
        if (b->fd >= 0)
            close(b->fd);
        free(b->image);
    }
    free(memory);
}

const ect_storage_t *ect_memory_storage(const ect_memory_t *memory)
{
    return &memory->storage;
}

void ect_memory_observe(ect_memory_t *memory, void (*saved)(void *ctx, size_t number), void *ctx, size_t number)
{
    memory->saved = saved;
    memory->saved_ctx = ctx;
    memory->number = number;
}

void ect_memory_wait(ect_memory_t *memory)
{
    memory->waits = true;
}

void ect_memory_replace_flush(ect_memory_t *memory, int (*flushed)(void *ctx, int result), void *ctx)
{
    memory->flushed = flushed;
    memory->flushed_ctx = ctx;
}
