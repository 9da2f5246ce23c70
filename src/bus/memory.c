/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bus/memory.h"

#include <errno.h>
#include <fcntl.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

enum { ERASED = 0xFF };

/* Without a path the files have no name, and go with the process. */
struct ect_memory {
    ect_storage_t storage;
    int fd[2];
    uint32_t end[2]; /* of the last write */
};

static int bank_read(void *ctx, unsigned int bank, uint32_t offset, void *buffer, uint32_t length)
{
    const ect_memory_t *m = ctx;
    ssize_t got = pread(m->fd[bank], buffer, length, offset);
    if (got < 0)
        return -1;
    memset((char *)buffer + got, ERASED, length - (size_t)got);
    return 0;
}

static int bank_erase(void *ctx, unsigned int bank)
{
    ect_memory_t *m = ctx;
    m->end[bank] = 0;
    return ftruncate(m->fd[bank], 0);
}

/* A write in front of the last one (a header, after its data) must not reach the disk before that. */
static int bank_write(void *ctx, unsigned int bank, uint32_t offset, const void *data, uint32_t length)
{
    ect_memory_t *m = ctx;
    bool seals = offset < m->end[bank];
    m->end[bank] = offset + length;
    if (seals && fdatasync(m->fd[bank]) < 0)
        return -1;
    if (pwrite(m->fd[bank], data, length, offset) != (ssize_t)length)
        return -1;
    return seals ? fdatasync(m->fd[bank]) : 0;
}

static int open_bank(const char *path, int bank)
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

ect_memory_t *ect_memory_open(const char *path, char *message)
{
    ect_memory_t *m = calloc(1, sizeof *m);
    if (m) {
        m->fd[0] = open_bank(path, 0);
        m->fd[1] = open_bank(path, 1);
    }
    if (!m || m->fd[0] < 0 || m->fd[1] < 0) {
        snprintf(message, ECT_MEMORY_MESSAGE, "no memory in '%s.0' and '.1': %s", path ? path : "", strerror(errno));
        ect_memory_close(m);
        return NULL;
    }
    m->storage = (ect_storage_t){
        .ctx = m, .bank_size = ECT_MEMORY_BANK, .read = bank_read, .erase = bank_erase, .write = bank_write};
    return m;
}

void ect_memory_close(ect_memory_t *memory)
{
    if (!memory)
        return;
    for (unsigned int bank = 0; bank < 2; bank++) {
        if (memory->fd[bank] >= 0)
            close(memory->fd[bank]);
    }
    free(memory);
}

const ect_storage_t *ect_memory_storage(const ect_memory_t *memory)
{
    return &memory->storage;
}
