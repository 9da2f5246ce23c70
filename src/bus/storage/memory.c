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

/* A file is a head and a bank. The bank is kept in memory too and read from there: whatever others do to the file
 * meanwhile, the twin knows what it has written. Without a path there is no file. A thread of the C library waits for
 * the disk. */
enum { HEAD = 32, FILE_SIZE = HEAD + ECT_MEMORY_BANK, NAME = ECT_MEMORY_PATH + 16, MOST_KEPT = 9 };

static const uint8_t head[HEAD] = "ectwin store 1\n";

typedef struct bank {
    int fd; /* -1: none */
    uint8_t *image;
    bool written; /* since the last synchronisation began */
    bool syncing;
    struct aiocb sync;
} bank_t;

struct ect_memory {
    ect_storage_t storage;
    bank_t banks[2];
};

static int bank_read(void *ctx, unsigned int bank, uint32_t offset, void *buffer, uint32_t length)
{
    const ect_memory_t *m = ctx;
    memcpy(buffer, m->banks[bank].image + offset, length);
    return 0;
}

/* A file can be written over. */
static int bank_erase(void *ctx, unsigned int bank)
{
    (void)ctx;
    (void)bank;
    return 0;
}

static int bank_write(void *ctx, unsigned int bank, uint32_t offset, const void *data, uint32_t length)
{
    ect_memory_t *m = ctx;
    bank_t *b = &m->banks[bank];
    memcpy(b->image + offset, data, length);
    if (b->fd < 0)
        return 0;
    b->written = true;
    return pwrite(b->fd, data, length, (off_t)HEAD + (off_t)offset) == (ssize_t)length ? 0 : -1;
}

/* A file that was deleted, cut or put aside under our hands keeps nothing for the next time. */
static bool still_there(const bank_t *b)
{
    struct stat info;
    return fstat(b->fd, &info) == 0 && info.st_nlink > 0 && info.st_size == FILE_SIZE;
}

static int begin_sync(bank_t *b)
{
    b->sync = (struct aiocb){.aio_fildes = b->fd, .aio_sigevent = {.sigev_notify = SIGEV_NONE}};
    if (!still_there(b) || aio_fsync(O_DSYNC, &b->sync) < 0)
        return -1;
    b->written = false;
    b->syncing = true;
    return 0;
}

/* @return as ect_storage_t::flush, of the synchronisation that was begun */
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

static int bank_flush(void *ctx, unsigned int bank, bool wait)
{
    ect_memory_t *m = ctx;
    bank_t *b = &m->banks[bank];
    int result = 0;
    while (result == 0 && (b->syncing || b->written)) {
        if (!b->syncing && begin_sync(b) < 0)
            return -1;
        result = end_sync(b, wait);
    }
    return result;
}

/* --- opening ------------------------------------------------------------------------------------------------------ */

/* The name of a new file is on the disk when its folder is. */
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

static const char *make_empty(const bank_t *b, const char *name)
{
    bool done = ftruncate(b->fd, FILE_SIZE) == 0 && pwrite(b->fd, head, HEAD, 0) == HEAD && fsync(b->fd) == 0 &&
                sync_folder(name) == 0;
    return done ? NULL : strerror(errno);
}

/* What was never written to is not read: the banks of a thousand twins are nearly empty. */
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

/* Nothing but a file of our own is taken, and nothing else is changed. @return why not, NULL */
static const char *take_file(const bank_t *b, const char *name)
{
    struct stat info;
    uint8_t found[HEAD];
    if (fstat(b->fd, &info) < 0 || !S_ISREG(info.st_mode))
        return "it is not a regular file";
    if (flock(b->fd, LOCK_EX | LOCK_NB) < 0) /* two twins on one file would undo each other's records */
        return errno == EWOULDBLOCK ? "another twin uses it" : strerror(errno);
    if (info.st_size == 0)
        return make_empty(b, name);
    if (info.st_size != FILE_SIZE || pread(b->fd, found, HEAD, 0) != HEAD || memcmp(found, head, HEAD) != 0)
        return "it is not what a twin has saved; it stays as it is";
    return read_image(b) ? NULL : strerror(errno);
}

static const char *open_file(bank_t *b, const char *name)
{
    b->fd = open(name, O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0600);
    if (b->fd < 0)
        return errno == ELOOP ? "it is a link" : strerror(errno);
    return take_file(b, name);
}

/* What was never written is empty; what was is whole, or the last save was cut off, or it is damaged. */
static bool is_whole(const ect_storage_t *storage, unsigned int bank)
{
    static const uint8_t empty[ECT_RECORD_HEADER];
    uint8_t header[ECT_RECORD_HEADER];
    ect_record_t record;
    (void)storage->read(storage->ctx, bank, 0, header, sizeof header);
    if (memcmp(header, empty, sizeof header) == 0)
        return true;
    return ect_record_header(storage, bank, ect_load_le32(header), &record) > 0 && ect_record_data_good(&record) > 0;
}

/* Under another name, for those who may mend it; an empty file takes its place. @return why not, NULL */
static const char *keep_aside(ect_memory_t *m, unsigned int bank, const char *name, char *message)
{
    bank_t *b = &m->banks[bank];
    char other[NAME + 32];
    for (int n = 1; n <= MOST_KEPT; n++) {
        snprintf(other, sizeof other, "%s.damaged%d", name, n);
        if (link(name, other) == 0) {
            size_t used = strlen(message);
            snprintf(message + used, ECT_MEMORY_MESSAGE - used,
                     "%s'%.200s' holds no whole record, it is kept as '%.30s'", used > 0 ? "; " : "", name,
                     strrchr(other, '/') ? strrchr(other, '/') + 1 : other);
            (void)unlink(name);
            close(b->fd);
            memset(b->image, 0, ECT_MEMORY_BANK);
            return open_file(b, name);
        }
        if (errno != EEXIST)
            return strerror(errno);
    }
    return "it is damaged, and so are nine others: look at them, and remove some";
}

static const char *open_bank(ect_memory_t *m, unsigned int bank, const char *path, char *message)
{
    char name[NAME];
    m->banks[bank].image = calloc(1, ECT_MEMORY_BANK);
    if (!m->banks[bank].image)
        return "not enough memory";
    if (!path)
        return NULL;
    snprintf(name, sizeof name, "%s.%u", path, bank);
    const char *why = open_file(&m->banks[bank], name);
    return why || is_whole(&m->storage, bank) ? why : keep_aside(m, bank, name, message);
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
    unsigned int bank = 0;
    *message = 0;
    for (; bank < 2 && !why; bank++)
        why = open_bank(m, bank, path, message);
    if (!why)
        return m;
    snprintf(message, ECT_MEMORY_MESSAGE, "cannot keep what is saved in '%.400s.%u': %s", path ? path : "",
             bank > 0 ? bank - 1 : 0, why);
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
