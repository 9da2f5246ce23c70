/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "content.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "bus/storage/files.h"
#include "bus/storage/memory.h"

/* BLOCK: bytes of data in a block. PIECE_MOST: limit for a piece of a manipulated record. */
enum { BLOCK = 32 * 1024, PIECE_MOST = ECT_MEMORY_BANK };

static const char of_file[] = "file ";

void content_name_memory(char *name, size_t slave, unsigned int bank)
{
    snprintf(name, CONTENT_NAME, "memory %zu.%u", slave, bank);
}

void content_name_eeprom(char *name, size_t slave)
{
    snprintf(name, CONTENT_NAME, "eeprom %zu", slave);
}

/* --- pieces ------------------------------------------------------------------------------------------------------- */

static content_piece_t *find(const content_t *content, const char *name)
{
    content_piece_t *piece = content->pieces;
    while (piece && strcmp(piece->name, name) != 0)
        piece = piece->next;
    return piece;
}

const content_piece_t *content_find(const content_t *content, const char *name)
{
    return find(content, name);
}

static content_piece_t *add_piece(content_t *content, const char *name)
{
    content_piece_t *piece = calloc(1, sizeof *piece);
    if (!piece)
        return NULL;
    snprintf(piece->name, sizeof piece->name, "%s", name);
    piece->next = content->pieces;
    content->pieces = piece;
    return piece;
}

static bool append(content_piece_t *piece, const uint8_t *data, size_t size)
{
    uint8_t *grown = realloc(piece->data, piece->size + size + 1);
    if (!grown)
        return false;
    if (size > 0)
        memcpy(grown + piece->size, data, size);
    piece->data = grown;
    piece->size += size;
    return true;
}

bool content_keep(content_t *content, const char *name, const uint8_t *data, size_t size)
{
    content_piece_t *piece = add_piece(content, name);
    while (size > 0 && data[size - 1] == 0)
        size--;
    return piece && append(piece, data, size);
}

/* --- writing to a record ------------------------------------------------------------------------------------------ */

static void log_block(ect_trace_t *trace, const char *name, uint64_t offset, const uint8_t *data, size_t size)
{
    char text[CONTENT_NAME + BLOCK];
    int head = snprintf(text, sizeof text, "%s\n", name);
    if (data)
        memcpy(text + head, data, size);
    ect_trace_log(trace, ECT_LOGGED_CONTENT, (uint32_t)size, offset, text, (size_t)head + size);
    ect_trace_flush(trace);
}

static void log_piece(ect_trace_t *trace, const content_piece_t *piece)
{
    size_t offset = 0, size;
    do {
        size = piece->size - offset < BLOCK ? piece->size - offset : BLOCK;
        log_block(trace, piece->name, offset, piece->data + offset, size);
        offset += size;
    } while (offset < piece->size);
}

/* Copies at most the initial size: the record itself may be a growing file in the folder. */
static const char *log_data(ect_trace_t *trace, int fd, const char *name, off_t size)
{
    uint8_t data[BLOCK];
    off_t offset = 0;
    ssize_t got;
    do {
        size_t want = size - offset < BLOCK ? (size_t)(size - offset) : BLOCK;
        got = pread(fd, data, want, offset);
        if (got < 0)
            return strerror(errno);
        log_block(trace, name, (uint64_t)offset, data, (size_t)got);
        offset += got;
    } while (got > 0 && offset < size);
    return NULL;
}

static const char *log_file(ect_trace_t *trace, int folder, const char *name)
{
    char full[CONTENT_NAME];
    struct stat info;
    if (!ect_files_fits(name, strlen(name)) || fstatat(folder, name, &info, AT_SYMLINK_NOFOLLOW) < 0 ||
        !S_ISREG(info.st_mode))
        return NULL; /* not accessible to a master */
    if (info.st_size > ECT_FILES_MOST)
        return "it is longer than 64 MiB";
    int fd = openat(folder, name, O_RDONLY | O_NOFOLLOW | O_CLOEXEC | O_NONBLOCK);
    if (fd < 0)
        return strerror(errno);
    snprintf(full, sizeof full, "%s%s", of_file, name);
    const char *why = log_data(trace, fd, full, info.st_size);
    close(fd);
    return why;
}

static const char *log_folder(ect_trace_t *trace, const char *path, char *text, size_t room)
{
    DIR *folder = opendir(path);
    const char *why = folder ? NULL : strerror(errno);
    const struct dirent *entry;
    while (folder && !why && (entry = readdir(folder))) {
        why = log_file(trace, dirfd(folder), entry->d_name);
        if (why)
            snprintf(text, room, "'%.400s/%.200s' cannot be recorded: %s", path, entry->d_name, why);
    }
    if (!folder)
        snprintf(text, room, "'%.400s' cannot be recorded: %s", path, why);
    else
        closedir(folder);
    return why ? text : NULL;
}

const char *content_log(const content_t *content, const char *files, ect_trace_t *trace, char *text, size_t room)
{
    for (const content_piece_t *piece = content->pieces; piece; piece = piece->next)
        log_piece(trace, piece);
    return files ? log_folder(trace, files, text, room) : NULL;
}

/* --- reading from a record ---------------------------------------------------------------------------------------- */

const char *content_make_folder(content_t *content)
{
    const char *temporary = getenv("TMPDIR");
    int length = snprintf(content->folder, sizeof content->folder, "%s/ectwin-replay-XXXXXX",
                          temporary && *temporary ? temporary : "/tmp");
    bool done = length < (int)sizeof content->folder && mkdtemp(content->folder);
    if (!done)
        content->folder[0] = 0;
    return done ? NULL : "a folder for its files cannot be made: set TMPDIR to a folder that can be written";
}

static const char *take_file(const content_t *content, const char *name, uint64_t offset, const uint8_t *data,
                             size_t size)
{
    struct stat info;
    if (content->folder[0] == 0 || !ect_files_fits(name, strlen(name)))
        return "it contains a file that no twin has";
    int folder = open(content->folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    int fd = folder < 0 ? -1 : openat(folder, name, O_WRONLY | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0600);
    const char *why = NULL;
    if (fd < 0 || fstat(fd, &info) < 0)
        why = strerror(errno);
    else if ((uint64_t)info.st_size != offset || offset + size > ECT_FILES_MOST)
        why = "the parts of a file do not fit";
    else if (pwrite(fd, data, size, (off_t)offset) != (ssize_t)size)
        why = strerror(errno);
    if (fd >= 0)
        close(fd);
    if (folder >= 0)
        close(folder);
    return why;
}

static const char *take_piece(content_t *content, const char *name, uint64_t offset, const uint8_t *data, size_t size)
{
    content_piece_t *piece = find(content, name);
    if (!piece)
        piece = add_piece(content, name);
    if (!piece)
        return "not enough memory";
    if (offset != piece->size || offset + size > PIECE_MOST)
        return "the parts of a memory do not fit";
    return append(piece, data, size) ? NULL : "not enough memory";
}

const char *content_take(content_t *content, const ect_logged_t *logged, size_t room)
{
    char name[CONTENT_NAME];
    const char *end = memchr(logged->text, '\n', logged->length);
    size_t length = end ? (size_t)(end - logged->text) : 0;
    if (!end || length >= sizeof name || logged->value > BLOCK || logged->value > room - length - 1)
        return "an invalid part of a memory or a file";
    memcpy(name, logged->text, length);
    name[length] = 0;
    const uint8_t *data = (const uint8_t *)end + 1;
    if (strncmp(name, of_file, sizeof of_file - 1) == 0)
        return take_file(content, name + sizeof of_file - 1, logged->time_ns, data, logged->value);
    return take_piece(content, name, logged->time_ns, data, logged->value);
}

bool content_pad(content_t *content, const char *name, size_t size, const uint8_t **data)
{
    content_piece_t *piece = find(content, name);
    if (!piece || piece->size > size)
        return true;
    uint8_t *padded = realloc(piece->data, size);
    if (!padded)
        return false;
    memset(padded + piece->size, 0, size - piece->size);
    piece->data = padded;
    piece->size = size;
    *data = padded;
    return true;
}

static void remove_folder(const char *path)
{
    DIR *folder = opendir(path);
    const struct dirent *entry;
    while (folder && (entry = readdir(folder)))
        (void)unlinkat(dirfd(folder), entry->d_name, 0);
    if (folder)
        closedir(folder);
    (void)rmdir(path);
}

void content_free(content_t *content)
{
    while (content->pieces) {
        content_piece_t *next = content->pieces->next;
        free(content->pieces->data);
        free(content->pieces);
        content->pieces = next;
    }
    if (content->folder[0] != 0)
        remove_folder(content->folder);
    content->folder[0] = 0;
}
