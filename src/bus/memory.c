/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bus/memory.h"

#include <aio.h>
#include <errno.h>
#include <fcntl.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <unistd.h>

/* Without a path the files have no name, and go with the process. They are read through a mapping and written by calls,
 * which say so when the disk is full. A thread of the C library waits for the disk. */
struct ect_memory {
    ect_storage_t storage;
    bool on_disk;
    int fd[2];
    const uint8_t *image[2]; /* MAP_FAILED: none */
    bool written[2];         /* since the last synchronisation began */
    bool syncing[2];
    struct aiocb sync[2];
};

static int bank_read(void *ctx, unsigned int bank, uint32_t offset, void *buffer, uint32_t length)
{
    const ect_memory_t *m = ctx;
    memcpy(buffer, m->image[bank] + offset, length);
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
    m->written[bank] = m->on_disk;
    return pwrite(m->fd[bank], data, length, offset) == (ssize_t)length ? 0 : -1;
}

static int begin_sync(ect_memory_t *m, unsigned int bank)
{
    m->sync[bank] = (struct aiocb){.aio_fildes = m->fd[bank], .aio_sigevent = {.sigev_notify = SIGEV_NONE}};
    if (aio_fsync(O_DSYNC, &m->sync[bank]) < 0)
        return -1;
    m->written[bank] = false;
    m->syncing[bank] = true;
    return 0;
}

/* @return as ect_storage_t::flush, of the synchronisation that was begun */
static int end_sync(ect_memory_t *m, unsigned int bank, bool wait)
{
    const struct aiocb *const all[] = {&m->sync[bank]};
    int error = aio_error(&m->sync[bank]);
    while (wait && error == EINPROGRESS) {
        (void)aio_suspend(all, 1, NULL);
        error = aio_error(&m->sync[bank]);
    }
    if (error == EINPROGRESS)
        return ECT_STORAGE_BUSY;
    m->syncing[bank] = false;
    return aio_return(&m->sync[bank]) < 0 ? -1 : 0;
}

static int bank_flush(void *ctx, unsigned int bank, bool wait)
{
    ect_memory_t *m = ctx;
    int result = 0;
    while (result == 0 && (m->syncing[bank] || m->written[bank])) {
        if (!m->syncing[bank] && begin_sync(m, bank) < 0)
            return -1;
        result = end_sync(m, bank, wait);
    }
    return result;
}

static int open_file(const char *path, int bank)
{
    char name[ECT_MEMORY_PATH + 4];
    if (!path)
        return memfd_create("ectwin", MFD_CLOEXEC);
    if (snprintf(name, sizeof name, "%s.%d", path, bank) >= (int)sizeof name) {
        errno = ENAMETOOLONG;
        return -1;
    }
    return open(name, O_RDWR | O_CREAT | O_CLOEXEC, 0600);
}

/* Two twins on one file would undo each other's records. */
static bool open_bank(ect_memory_t *m, const char *path, int bank)
{
    m->fd[bank] = open_file(path, bank);
    if (m->fd[bank] < 0 || flock(m->fd[bank], LOCK_EX | LOCK_NB) < 0 || ftruncate(m->fd[bank], ECT_MEMORY_BANK) < 0)
        return false;
    m->image[bank] = mmap(NULL, ECT_MEMORY_BANK, PROT_READ, MAP_SHARED, m->fd[bank], 0);
    return m->image[bank] != MAP_FAILED;
}

ect_memory_t *ect_memory_open(const char *path, char *message)
{
    ect_memory_t *m = calloc(1, sizeof *m);
    if (m) {
        m->fd[0] = m->fd[1] = -1;
        m->image[0] = m->image[1] = MAP_FAILED;
        m->on_disk = path != NULL;
    }
    if (!m || !open_bank(m, path, 0) || !open_bank(m, path, 1)) {
        const char *why = errno == EWOULDBLOCK ? "another twin uses it" : strerror(errno);
        snprintf(message, ECT_MEMORY_MESSAGE, "cannot keep what is saved in '%s.0' and '.1': %s", path ? path : "",
                 why);
        ect_memory_close(m);
        return NULL;
    }
    m->storage = (ect_storage_t){.ctx = m,
                                 .bank_size = ECT_MEMORY_BANK,
                                 .read = bank_read,
                                 .erase = bank_erase,
                                 .write = bank_write,
                                 .flush = bank_flush};
    return m;
}

void ect_memory_close(ect_memory_t *memory)
{
    if (!memory)
        return;
    for (unsigned int bank = 0; bank < 2; bank++) {
        if (memory->syncing[bank])
            (void)end_sync(memory, bank, true);
        if (memory->image[bank] != MAP_FAILED)
            munmap((void *)(uintptr_t)memory->image[bank], ECT_MEMORY_BANK);
        if (memory->fd[bank] >= 0)
            close(memory->fd[bank]);
    }
    free(memory);
}

const ect_storage_t *ect_memory_storage(const ect_memory_t *memory)
{
    return &memory->storage;
}
