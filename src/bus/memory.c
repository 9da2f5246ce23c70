/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bus/memory.h"

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
 * which say so when the disk is full. */
struct ect_memory {
    ect_storage_t storage;
    int fd[2];
    const uint8_t *image[2]; /* MAP_FAILED: none */
    uint32_t end[2];         /* of the last write */
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
    ect_memory_t *m = ctx;
    m->end[bank] = 0;
    return 0;
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
    }
    if (!m || !open_bank(m, path, 0) || !open_bank(m, path, 1)) {
        const char *why = errno == EWOULDBLOCK ? "another twin uses it" : strerror(errno);
        snprintf(message, ECT_MEMORY_MESSAGE, "cannot keep what is saved in '%s.0' and '.1': %s", path ? path : "",
                 why);
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
