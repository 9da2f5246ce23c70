/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bus/storage/eeprom.h"

#include <errno.h>
#include <fcntl.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "wire/assert.h"
#include "wire/bytes.h"
#include "wire/crc.h"

enum { HEADER = 16, SIZE_AT = 8, CHECKSUM = ECT_SII_CHECKED_BYTES };

static const uint8_t magic[SIZE_AT] = {'E', 'C', 'T', 'W', 'S', 'I', 'I', '1'};

/* The file consists of a header, the factory image, and the present image. */
struct ect_eeprom {
    int fd;
    uint32_t size;
    uint8_t image[];
};

static bool write_all(int fd, const ect_eeprom_t *e, const uint8_t *factory)
{
    uint8_t header[HEADER] = {0};
    memcpy(header, magic, sizeof magic);
    ect_store_le32(header + SIZE_AT, e->size);
    return pwrite(fd, header, HEADER, 0) == HEADER && pwrite(fd, factory, e->size, HEADER) == (ssize_t)e->size &&
           pwrite(fd, e->image, e->size, HEADER + e->size) == (ssize_t)e->size && fsync(fd) == 0;
}

/* Writes a temporary file and renames it, so the named file is always complete. */
static bool replace_file(ect_eeprom_t *e, const char *path, const uint8_t *factory)
{
    char other[ECT_EEPROM_PATH + sizeof ".new"];
    snprintf(other, sizeof other, "%s.new", path);
    int fd = open(other, O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0600);
    if (fd < 0)
        return false;
    if (flock(fd, LOCK_EX | LOCK_NB) == 0 && write_all(fd, e, factory) && rename(other, path) == 0) {
        close(e->fd);
        e->fd = fd;
        return true;
    }
    int error = errno;
    (void)unlink(other);
    close(fd);
    errno = error;
    return false;
}

/* Locks the file, and checks that no other twin has replaced it since open(). */
static bool take_lock(int fd, const char *path)
{
    struct stat ours, named;
    if (flock(fd, LOCK_EX | LOCK_NB) < 0 || fstat(fd, &ours) < 0 || lstat(path, &named) < 0)
        return false;
    errno = EWOULDBLOCK;
    return ours.st_ino == named.st_ino && ours.st_dev == named.st_dev;
}

static bool checksum_good(const uint8_t *image)
{
    return image[CHECKSUM] == ect_crc_sii(image);
}

/* Applies the master's changes, `image` against the old factory image `before`, to the new factory image `now`. */
static void merge(uint8_t *image, const uint8_t *before, const uint8_t *now, uint32_t size)
{
    bool good = checksum_good(image);
    for (uint32_t at = 0; at < size; at += 2) {
        if (memcmp(before + at, now + at, 2) != 0)
            memcpy(image + at, now + at, 2);
    }
    if (good)
        image[CHECKSUM] = ect_crc_sii(image);
}

/* @return 1: read; 0: the file is new; -1 (errno; EINVAL: another kind of file) */
static int read_all(ect_eeprom_t *e, uint8_t *before)
{
    uint8_t header[HEADER];
    struct stat info;
    if (fstat(e->fd, &info) < 0)
        return -1;
    if (S_ISREG(info.st_mode) && info.st_size == 0)
        return 0;
    errno = EINVAL;
    if (!S_ISREG(info.st_mode) || info.st_size != (off_t)HEADER + 2 * (off_t)e->size ||
        pread(e->fd, header, HEADER, 0) != HEADER || memcmp(header, magic, sizeof magic) != 0 ||
        ect_load_le32(header + SIZE_AT) != e->size)
        return -1;
    bool whole = pread(e->fd, before, e->size, HEADER) == (ssize_t)e->size &&
                 pread(e->fd, e->image, e->size, HEADER + e->size) == (ssize_t)e->size;
    return whole ? 1 : -1;
}

static bool load(ect_eeprom_t *e, const char *path, const uint8_t *factory)
{
    uint8_t *before = malloc(e->size);
    e->fd = open(path, O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0600);
    int found = before && e->fd >= 0 && take_lock(e->fd, path) ? read_all(e, before) : -1;
    if (found > 0)
        merge(e->image, before, factory, e->size);
    else if (found == 0)
        memcpy(e->image, factory, e->size);
    bool same = found > 0 && memcmp(before, factory, e->size) == 0;
    bool done = found >= 0 && (same || replace_file(e, path, factory));
    int error = errno;
    free(before);
    errno = error;
    return done;
}

ect_eeprom_t *ect_eeprom_open(const char *path, const uint8_t *factory, uint32_t size, char *message)
{
    ect_eeprom_t *e = calloc(1, sizeof *e + size);
    if (e) {
        e->fd = -1;
        e->size = size;
    }
    if (e && load(e, path, factory))
        return e;
    const char *why =
        errno == EWOULDBLOCK ? "another twin uses it"
        : errno == EINVAL
            ? "it is no EEPROM content of a twin of this size; move it away to start from the factory's content"
        : errno == ELOOP ? "it is a symbolic link"
                         : strerror(errno);
    snprintf(message, ECT_EEPROM_MESSAGE, "cannot keep the EEPROM in '%s': %s", path, why);
    ect_eeprom_close(e);
    return NULL;
}

void ect_eeprom_close(ect_eeprom_t *eeprom)
{
    if (!eeprom)
        return;
    if (eeprom->fd >= 0) {
        (void)fdatasync(eeprom->fd);
        close(eeprom->fd);
    }
    free(eeprom);
}

const uint8_t *ect_eeprom_image(const ect_eeprom_t *eeprom)
{
    return eeprom->image;
}

void ect_eeprom_write(void *eeprom, const uint8_t *image, uint32_t size)
{
    ect_eeprom_t *e = eeprom;
    ECT_ASSERT(size == e->size);
    uint32_t from = 0;
    uint32_t to = size;
    while (from < to && image[from] == e->image[from])
        from++;
    while (to > from && image[to - 1] == e->image[to - 1])
        to--;
    memcpy(e->image + from, image + from, to - from);
    /* The file has its final size, so a full disk is impossible. After a failed write the change is lost with the
     * process. */
    if (to > from && pwrite(e->fd, image + from, to - from, (off_t)(HEADER + e->size + from)) < 0)
        return;
}
