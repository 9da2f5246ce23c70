/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bus/capture/capture.h"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <semaphore.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "wire/assert.h"
#include "wire/bytes.h"

/* A batch ends at the end of a block; the thread collects blocks for GATHER_NS before writing. */
enum { BATCH = 65536, GATHER_NS = 5000000, HEADS = 3 };

struct ect_capture {
    int fd;
    uint64_t most;      /* limit of the section in bytes; 0: none */
    uint64_t section;   /* offset of the section in the file */
    uint64_t begin;     /* offset of the first removable block */
    uint64_t end;       /* end of the file */
    uint64_t middle;    /* end of the first batch in the newer half; 0: none yet */
    uint64_t offset_ns; /* added to each time */
    atomic_int failed;  /* errno */
    /* Owned by the adding thread. */
    uint8_t *buffer;
    size_t size;
    uint64_t dropped; /* frames dropped since the last added packet */
    bool removed;     /* older frames were removed; owned by the writer */
    char comment[ECT_PCAPNG_COMMENT_MOST + 1];
    size_t comment_length;
    /* Positions in the stream of blocks: `head` is set by the adding thread, `tail` by the writer. */
    atomic_size_t head, tail;
    /* The writing thread. */
    bool threaded;
    pthread_t thread;
    sem_t wake;
    atomic_bool waits, ends;
};

/* --- the buffer --------------------------------------------------------------------------------------------------- */

static void copy_in(ect_capture_t *c, size_t position, const uint8_t *bytes, size_t length)
{
    size_t at = position & (c->size - 1);
    size_t first = length < c->size - at ? length : c->size - at;
    memcpy(c->buffer + at, bytes, first);
    memcpy(c->buffer, bytes + first, length - first);
}

/* @return the length of the block at a position: blocks have lengths of whole words, so the buffer's end is not within
 * the word */
static size_t block_length(const ect_capture_t *c, size_t position)
{
    enum { LENGTH = 4 };
    return ect_load_le32(c->buffer + ((position + LENGTH) & (c->size - 1)));
}

static bool has_room(const ect_capture_t *c, size_t length)
{
    size_t head = atomic_load_explicit(&c->head, memory_order_relaxed);
    return atomic_load_explicit(&c->failed, memory_order_relaxed) == 0 &&
           length <= c->size - (head - atomic_load_explicit(&c->tail, memory_order_acquire));
}

static bool add(ect_capture_t *c, const uint8_t *block, size_t length)
{
    size_t head = atomic_load_explicit(&c->head, memory_order_relaxed);
    if (!has_room(c, length))
        return false;
    copy_in(c, head, block, length);
    atomic_store_explicit(&c->head, head + length, memory_order_release);
    return true;
}

/* --- the file ----------------------------------------------------------------------------------------------------- */

static bool write_at(const ect_capture_t *c, const uint8_t *bytes, size_t length, uint64_t at)
{
    while (length > 0) {
        ssize_t done = pwrite(c->fd, bytes, length, (off_t)at);
        if (done < 0 && errno == EINTR)
            continue;
        if (done <= 0)
            return false;
        bytes += done;
        at += (uint64_t)done;
        length -= (size_t)done;
    }
    return true;
}

/* Moves the newer half of the file over the older one. */
static bool remove_older(ect_capture_t *c)
{
    uint8_t piece[16384];
    uint64_t from = c->middle != 0 ? c->middle : c->end;
    uint64_t to = c->begin;
    while (from < c->end) {
        size_t length = c->end - from < sizeof piece ? (size_t)(c->end - from) : sizeof piece;
        if (pread(c->fd, piece, length, (off_t)from) != (ssize_t)length || !write_at(c, piece, length, to))
            return false;
        from += length;
        to += length;
    }
    c->end = to;
    c->middle = 0;
    c->removed = true;
    return ftruncate(c->fd, (off_t)to) == 0;
}

/* @return bytes of the next batch, whole blocks only */
static size_t next_batch(const ect_capture_t *c, size_t tail, size_t available)
{
    size_t most = c->most != 0 && c->most / 8 < BATCH ? (size_t)(c->most / 8) : BATCH;
    size_t taken = 0;
    if (available <= most)
        return available;
    for (;;) {
        size_t block = block_length(c, tail + taken);
        if (taken > 0 && taken + block > most)
            return taken;
        taken += block;
    }
}

static bool write_batch(ect_capture_t *c, size_t tail, size_t length)
{
    size_t at = tail & (c->size - 1);
    size_t first = length < c->size - at ? length : c->size - at;
    if (c->most != 0 && c->end + length > c->section + c->most && !remove_older(c))
        return false;
    if (!write_at(c, c->buffer + at, first, c->end) || !write_at(c, c->buffer, length - first, c->end + first))
        return false;
    c->end += length;
    if (c->middle == 0 && c->end >= c->section + c->most / 2)
        c->middle = c->end;
    return true;
}

/* Writes the buffer. After a failed write all data are discarded. */
static void write_all(ect_capture_t *c)
{
    size_t tail = atomic_load_explicit(&c->tail, memory_order_relaxed);
    size_t head;
    while ((head = atomic_load_explicit(&c->head, memory_order_acquire)) != tail) {
        size_t length = next_batch(c, tail, head - tail);
        errno = 0; /* a short read or write sets none */
        if (atomic_load(&c->failed) == 0 && !write_batch(c, tail, length)) {
            atomic_store(&c->failed, errno != 0 ? errno : EIO);
            (void)!ftruncate(c->fd, (off_t)c->end); /* removes a partial block */
        }
        tail += length;
        atomic_store_explicit(&c->tail, tail, memory_order_release);
    }
}

/* --- the thread --------------------------------------------------------------------------------------------------- */

static void *write_on(void *ctx)
{
    const struct timespec gather = {.tv_nsec = GATHER_NS};
    ect_capture_t *c = ctx;
    while (!atomic_load(&c->ends)) {
        atomic_store(&c->waits, true);
        while (atomic_load(&c->head) == atomic_load(&c->tail) && !atomic_load(&c->ends) && sem_wait(&c->wake) != 0 &&
               errno == EINTR)
            ;
        if (!atomic_load(&c->ends))
            (void)nanosleep(&gather, NULL);
        write_all(c);
    }
    return NULL;
}

bool ect_capture_start(ect_capture_t *c)
{
    sigset_t all, before;
    if (sem_init(&c->wake, 0, 0) != 0)
        return false;
    sigfillset(&all); /* signals are for the event loop */
    (void)pthread_sigmask(SIG_SETMASK, &all, &before);
    c->threaded = pthread_create(&c->thread, NULL, write_on, c) == 0;
    (void)pthread_sigmask(SIG_SETMASK, &before, NULL);
    return c->threaded;
}

void ect_capture_flush(ect_capture_t *c)
{
    if (!c->threaded) {
        write_all(c);
        return;
    }
    if (atomic_load_explicit(&c->head, memory_order_relaxed) == atomic_load(&c->tail))
        return;
    atomic_thread_fence(memory_order_seq_cst); /* the thread sets `waits`, then reads `head`: so no wake-up is lost */
    if (atomic_load_explicit(&c->waits, memory_order_relaxed) && atomic_exchange(&c->waits, false))
        (void)sem_post(&c->wake);
}

/* --- open and close ----------------------------------------------------------------------------------------------- */

static bool write_heads(ect_capture_t *c, const ect_capture_config_t *config)
{
    uint8_t heads[HEADS * ECT_PCAPNG_ROOM];
    size_t length = ect_pcapng_section(heads, config->application);
    for (size_t end = 0; end < ECT_CAPTURE_ENDS; end++)
        length += ect_pcapng_interface(heads + length, config->names[end]);
    if (!write_at(c, heads, length, c->end))
        return false;
    c->end += length;
    c->begin = c->end;
    return true;
}

/* The lock keeps out other captures. Devices and pipes are refused, because they cannot be truncated. */
static const char *take_file(ect_capture_t *c, const ect_capture_config_t *config)
{
    struct stat info;
    c->fd = open(config->path, O_RDWR | O_CREAT | O_CLOEXEC | O_NONBLOCK, 0666);
    if (c->fd < 0)
        return strerror(errno);
    if (fstat(c->fd, &info) < 0 || !S_ISREG(info.st_mode)) {
        errno = EINVAL;
        return "it is not a regular file";
    }
    if (flock(c->fd, LOCK_EX | LOCK_NB) < 0)
        return errno == EWOULDBLOCK ? "another capture writes to it; give this one another name" : strerror(errno);
    c->end = c->section = config->append ? (uint64_t)info.st_size : 0;
    if (!config->append && ftruncate(c->fd, 0) < 0)
        return strerror(errno);
    return write_heads(c, config) ? NULL : strerror(errno);
}

ect_capture_t *ect_capture_open(const ect_capture_config_t *config, char *message)
{
    ECT_ASSERT(config->buffer >= (size_t)4 * ECT_PCAPNG_ROOM && (config->buffer & (config->buffer - 1)) == 0);
    ECT_ASSERT(config->most == 0 || config->most >= ECT_CAPTURE_SMALLEST);
    ect_capture_t *c = calloc(1, sizeof *c);
    uint8_t *buffer = malloc(config->buffer);
    const char *why = "not enough memory";
    if (c && buffer) {
        c->most = config->most;
        c->size = config->buffer;
        c->buffer = buffer;
        c->offset_ns = config->offset_ns;
        why = take_file(c, config);
    }
    if (!why)
        return c;
    int error = errno;
    snprintf(message, ECT_CAPTURE_MESSAGE, "cannot write '%.300s': %s", config->path, why);
    if (c && buffer && c->fd >= 0)
        close(c->fd);
    free(buffer);
    free(c);
    errno = error;
    return NULL;
}

/* Adds the last block, after the last frame. */
static void add_end(ect_capture_t *c, uint64_t time_ns)
{
    uint8_t block[ECT_PCAPNG_ROOM];
    char dropped[64];
    if (c->removed)
        ect_capture_comment(c, "older frames were removed: --pcap-size");
    snprintf(dropped, sizeof dropped, "%llu frames were dropped", (unsigned long long)c->dropped);
    if (c->dropped > 0)
        ect_capture_comment(c, dropped);
    if (c->comment_length > 0)
        (void)add(c, block, ect_pcapng_statistics(block, time_ns + c->offset_ns, c->comment));
}

int ect_capture_close(ect_capture_t *c, const void *last, size_t length, uint64_t time_ns)
{
    if (!c)
        return 0;
    if (c->threaded) {
        atomic_store(&c->ends, true);
        (void)sem_post(&c->wake);
        (void)pthread_join(c->thread, NULL);
        (void)sem_destroy(&c->wake);
    }
    write_all(c);
    if (length > 0)
        (void)ect_capture_local(c, last, length);
    add_end(c, time_ns);
    write_all(c);
    int failed = atomic_load(&c->failed);
    close(c->fd);
    free(c->buffer);
    free(c);
    return failed;
}

/* --- frames ------------------------------------------------------------------------------------------------------- */

bool ect_capture_frame(ect_capture_t *c, uint32_t interface, ect_pcapng_direction_t direction, uint64_t time_ns,
                       const uint8_t *frame, size_t length)
{
    uint8_t block[ECT_PCAPNG_ROOM];
    const uint32_t captured = length < ECT_PCAPNG_FRAME_MOST ? (uint32_t)length : ECT_PCAPNG_FRAME_MOST;
    const ect_pcapng_packet_t packet = {.interface = interface,
                                        .direction = direction,
                                        .time_ns = time_ns + c->offset_ns,
                                        .frame = frame,
                                        .captured = captured,
                                        .length = (uint32_t)length,
                                        .dropped = c->dropped,
                                        .comment = c->comment_length > 0 ? c->comment : NULL};
    ECT_ASSERT(interface < ECT_CAPTURE_ENDS);
    if (!add(c, block, ect_pcapng_packet(block, &packet))) {
        c->dropped++;
        return false;
    }
    c->dropped = 0;
    c->comment_length = 0;
    return true;
}

void ect_capture_comment(ect_capture_t *c, const char *text)
{
    size_t room = sizeof c->comment - c->comment_length;
    int length = snprintf(c->comment + c->comment_length, room, "%s%s", c->comment_length > 0 ? "\n" : "", text);
    c->comment_length += (size_t)length < room ? (size_t)length : room - 1;
}

bool ect_capture_local(ect_capture_t *c, const void *data, size_t length)
{
    size_t size = ect_pcapng_local_size(length);
    uint8_t small[256];
    uint8_t *block = size <= sizeof small ? small : malloc(size);
    if (!block)
        return false;
    bool done = add(c, block, ect_pcapng_local(block, data, length));
    if (block != small)
        free(block);
    return done;
}
