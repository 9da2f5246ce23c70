/* SPDX-License-Identifier: MIT */
/* The saved records of a twin on a PC, also after changes of the files by other programs (memory.h). */
#define _GNU_SOURCE
#include "bus/storage/memory.h"

#include <aio.h>
#include <errno.h>
#include <fcntl.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#include "seams/record.h"

#define MAGIC 0x54534554u

static char work[64];

/* A disk that reads in pieces, and ends a synchronisation at the time set by the test. */
static struct {
    size_t piece;   /* most bytes of a read; 0: no limit */
    off_t bad_from; /* reads from this offset on fail; 0: none fails */
    bool slow;      /* the functions of aio are replaced */
    int state;      /* of the synchronisation: EINPROGRESS; 0 or an error when it has ended */
    int end;        /* state after the first wait */
    unsigned int begun, waits, ended;
} disk;

ssize_t __real_pread(int fd, void *bytes, size_t length, off_t at);
ssize_t __wrap_pread(int fd, void *bytes, size_t length, off_t at);
int __real_aio_fsync(int operation, struct aiocb *block);
int __wrap_aio_fsync(int operation, struct aiocb *block);
int __real_aio_error(const struct aiocb *block);
int __wrap_aio_error(const struct aiocb *block);
int __real_aio_suspend(const struct aiocb *const list[], int count, const struct timespec *timeout);
int __wrap_aio_suspend(const struct aiocb *const list[], int count, const struct timespec *timeout);
ssize_t __real_aio_return(struct aiocb *block);
ssize_t __wrap_aio_return(struct aiocb *block);

ssize_t __wrap_pread(int fd, void *bytes, size_t length, off_t at)
{
    if (disk.bad_from > 0 && at >= disk.bad_from) {
        errno = EIO;
        return -1;
    }
    return __real_pread(fd, bytes, disk.piece > 0 && disk.piece < length ? disk.piece : length, at);
}

int __wrap_aio_fsync(int operation, struct aiocb *block)
{
    disk.begun++;
    return disk.slow ? 0 : __real_aio_fsync(operation, block);
}

int __wrap_aio_error(const struct aiocb *block)
{
    return disk.slow ? disk.state : __real_aio_error(block);
}

int __wrap_aio_suspend(const struct aiocb *const list[], int count, const struct timespec *timeout)
{
    if (!disk.slow)
        return __real_aio_suspend(list, count, timeout);
    assert_null(timeout);
    disk.waits++;
    disk.state = disk.end;
    return 0;
}

ssize_t __wrap_aio_return(struct aiocb *block)
{
    if (!disk.slow)
        return __real_aio_return(block);
    disk.ended++;
    errno = disk.state;
    return disk.state == 0 ? 0 : -1;
}

static int make_work(void **state)
{
    (void)state;
    strcpy(work, "/tmp/test-ectwin-XXXXXX");
    return mkdtemp(work) && chdir(work) == 0 ? 0 : -1;
}

static int remove_work(void **state)
{
    char command[96];
    (void)state;
    snprintf(command, sizeof command, "rm -rf '%s'", work);
    return system(command) == 0 ? 0 : -1;
}

static ect_memory_t *must_open(const char *path)
{
    char message[ECT_MEMORY_MESSAGE];
    ect_memory_t *memory = ect_memory_open(path, message);
    if (!memory || *message)
        fail_msg("%s", message);
    return memory;
}

static void expect_refused(const char *path, const char *why)
{
    char message[ECT_MEMORY_MESSAGE];
    ect_memory_t *memory = ect_memory_open(path, message);
    if (memory || !strstr(message, why))
        fail_msg("%s: expected a refusal with '%s', got '%s'", path, why, memory ? "none" : message);
}

/* @return whether the record was saved */
static bool save(const ect_memory_t *memory, const void *data, uint32_t size)
{
    ect_record_t newest, record;
    if (ect_record_find(ect_memory_storage(memory), MAGIC, &newest) < 0)
        return false;
    return ect_record_begin(&record, &newest) && ect_record_put(&record, data, size) &&
           ect_record_commit(&record, MAGIC);
}

static void expect_saved(const ect_memory_t *memory, const char *want)
{
    char got[64] = "";
    ect_record_t record;
    int found = ect_record_find(ect_memory_storage(memory), MAGIC, &record);
    if (found > 0)
        assert_true(ect_record_get(&record, 0, got, record.length < sizeof got ? record.length : sizeof got));
    assert_string_equal(found > 0 ? got : "none", want);
}

static void overwrite(const char *name, off_t offset, const char *text)
{
    int fd = open(name, O_WRONLY);
    assert_true(fd >= 0);
    assert_int_equal(pwrite(fd, text, strlen(text), offset), (ssize_t)strlen(text));
    close(fd);
}

static void keeps(void **state)
{
    (void)state;
    ect_memory_t *memory = must_open("keeps");
    expect_saved(memory, "none");
    assert_true(save(memory, "one", 4));
    assert_true(save(memory, "two", 4));
    expect_saved(memory, "two");
    ect_memory_close(memory);
    memory = must_open("keeps");
    expect_saved(memory, "two");
    ect_memory_close(memory);
}

static void without_files(void **state)
{
    (void)state;
    ect_memory_t *memory = must_open(NULL);
    assert_true(save(memory, "one", 4));
    expect_saved(memory, "one");
    ect_memory_close(memory);
    ect_memory_close(NULL);
}

static void write_file(const char *name, const void *data, size_t size, size_t length)
{
    int fd = open(name, O_CREAT | O_TRUNC | O_WRONLY, 0600);
    assert_true(fd >= 0);
    assert_int_equal(write(fd, data, size), (ssize_t)size);
    assert_int_equal(ftruncate(fd, (off_t)length), 0);
    close(fd);
}

static off_t size_of(const char *name)
{
    struct stat info;
    return lstat(name, &info) == 0 ? info.st_size : -1;
}

static void longest_path(void **state)
{
    char path[ECT_MEMORY_PATH + 1] = "";
    (void)state;
    for (size_t length = ECT_MEMORY_PATH - 1; length <= ECT_MEMORY_PATH; length++) {
        memset(path, '/', length);
        path[0] = '.';
        memcpy(path + length - 4, "long", 5);
        if (length < ECT_MEMORY_PATH)
            ect_memory_close(must_open(path));
        else
            expect_refused(path, ".0': File name too long");
    }
    assert_int_equal(size_of("long.0"), ECT_MEMORY_BANK + 32);
    assert_int_equal(size_of("long.1"), ECT_MEMORY_BANK + 32);
}

/* Both ends of a bank, in memory and in the file. */
static void ends_of_a_bank(void **state)
{
    static const struct {
        const char *name;
        unsigned int bank;
        uint32_t offset;
    } cases[] = {
        {"ends.0", 0, 0}, {"ends.0", 0, ECT_MEMORY_BANK - 4}, {"ends.1", 1, 0}, {"ends.1", 1, ECT_MEMORY_BANK - 4}};
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char got[4];
        ect_memory_t *memory = must_open("ends");
        const ect_storage_t *s = ect_memory_storage(memory);
        assert_int_equal(s->bank_size, ECT_MEMORY_BANK);
        assert_int_equal(s->write(s->ctx, cases[i].bank, cases[i].offset, "abcd", 4), 0);
        assert_int_equal(s->read(s->ctx, cases[i].bank, cases[i].offset, got, 4), 0);
        assert_memory_equal(got, "abcd", 4);
        int fd = open(cases[i].name, O_RDONLY);
        assert_int_equal(pread(fd, got, 4, 32 + (off_t)cases[i].offset), 4);
        assert_memory_equal(got, "abcd", 4);
        assert_int_equal(pread(fd, got, 4, 32 + (off_t)ECT_MEMORY_BANK), 0);
        close(fd);
        ect_memory_close(memory);
        assert_int_equal(unlink("ends.0"), 0);
        assert_int_equal(unlink("ends.1"), 0);
    }
}

static void foreign_files(void **state)
{
    enum { FAR = 2 * ECT_MEMORY_BANK };
    (void)state;
    static const struct {
        off_t first, step; /* of the bytes other than 0 */
    } patterns[] = {{0, FAR}, {31, FAR}, {32, FAR}, {33, FAR}, {33, 2}, {ECT_MEMORY_BANK + 31, FAR}};
    static const size_t sizes[] = {1, 100, ECT_MEMORY_BANK, ECT_MEMORY_BANK + 32, ECT_MEMORY_BANK + 33};
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        write_file("foreign.0", "M", 1, sizes[i]);
        expect_refused("foreign", "it is not a twin's record");
        assert_int_equal(size_of("foreign.0"), sizes[i]);
        assert_int_equal(size_of("foreign.1"), -1);
    }
    for (size_t i = 0; i < sizeof patterns / sizeof patterns[0]; i++) { /* unlike the file of an interrupted start */
        write_file("foreign.0", "", 0, ECT_MEMORY_BANK + 32);
        for (off_t at = patterns[i].first; at < ECT_MEMORY_BANK + 32; at += patterns[i].step)
            overwrite("foreign.0", at, "x");
        expect_refused("foreign", "it is not a twin's record");
        assert_int_equal(size_of("foreign.0"), ECT_MEMORY_BANK + 32);
    }
    assert_int_equal(unlink("foreign.0"), 0);
    ect_memory_close(must_open("second"));
    write_file("second.1", "M", 1, 100);
    expect_refused("second", "'second.1'");
    assert_int_equal(size_of("second.1"), 100);
}

static void links_and_devices(void **state)
{
    (void)state;
    write_file("precious", "x", 1, 1);
    assert_int_equal(symlink("precious", "link.0"), 0);
    expect_refused("link", "it is a link");
    assert_int_equal(size_of("precious"), 1);
    assert_int_equal(symlink("nowhere", "dangling.0"), 0);
    expect_refused("dangling", "it is a link");
    assert_int_equal(size_of("nowhere"), -1);
    assert_int_equal(mkfifo("fifo.0", 0600), 0);
    expect_refused("fifo", "not a regular file");
    assert_int_equal(mkdir("folder.0", 0700), 0);
    expect_refused("folder", "directory");
    expect_refused("no/such/folder/x", "No such file");
    char name[ECT_MEMORY_PATH + 1];
    memset(name, 'x', sizeof name - 1);
    name[sizeof name - 1] = 0;
    expect_refused(name, "too long");
}

static void one_twin_each(void **state)
{
    (void)state;
    ect_memory_t *memory = must_open("locked");
    expect_refused("locked", "another twin uses it");
    assert_true(save(memory, "one", 4));
    ect_memory_close(memory);
    memory = must_open("locked");
    expect_saved(memory, "one");
    ect_memory_close(memory);
}

/* An access to the mapping of a truncated file would end the process (SIGBUS). */
static void cut_while_it_runs(void **state)
{
    (void)state;
    ect_memory_t *memory = must_open("cut");
    assert_true(save(memory, "one", 4));
    for (int bank = 0; bank < 2; bank++)
        assert_int_equal(truncate(bank == 0 ? "cut.0" : "cut.1", 0), 0);
    expect_saved(memory, "one");
    assert_false(save(memory, "two", 4));
    ect_memory_close(memory);
}

static void deleted_while_it_runs(void **state)
{
    (void)state;
    ect_memory_t *memory = must_open("deleted");
    assert_true(save(memory, "one", 4));
    assert_int_equal(unlink("deleted.0"), 0);
    assert_int_equal(unlink("deleted.1"), 0);
    expect_saved(memory, "one");
    assert_false(save(memory, "two", 4));
    ect_memory_close(memory);
}

/* The second of two saves is damaged, so the record of the first save is used. */
static void damaged(void **state)
{
    char message[ECT_MEMORY_MESSAGE], other[64];
    (void)state;
    const int before = open("/dev/null", O_RDONLY);
    (void)close(before);
    for (unsigned int n = 1; n <= 20; n++) {
        ect_memory_t *memory = n == 1 ? must_open("damaged") : ect_memory_open("damaged", message);
        if (!memory)
            fail_msg("%s", message);
        assert_true(save(memory, "one", 4));
        assert_true(save(memory, "two", 4));
        ect_record_t newest;
        assert_int_equal(ect_record_find(ect_memory_storage(memory), MAGIC, &newest), 1);
        unsigned int bank = newest.bank;
        ect_memory_close(memory);
        overwrite(bank == 0 ? "damaged.0" : "damaged.1", 32 + ECT_RECORD_HEADER, "XXX");
        memory = ect_memory_open("damaged", message);
        assert_non_null(memory);
        snprintf(other, sizeof other, "kept as 'damaged.%u.damaged", bank);
        assert_non_null(strstr(message, "has no complete record"));
        assert_non_null(strstr(message, other));
        expect_saved(memory, "one"); /* the previous record */
        ect_memory_close(memory);
        snprintf(other, sizeof other, "damaged.%u.damaged1", bank);
        assert_int_equal(size_of(other), ECT_MEMORY_BANK + 32);
        memory = must_open("damaged"); /* reported once */
        ect_memory_close(memory);
    }
    assert_true(size_of("damaged.0.damaged9") > 0 && size_of("damaged.1.damaged9") > 0);
    assert_true(size_of("damaged.0.damaged10") < 0 && size_of("damaged.1.damaged10") < 0);
    const int after = open("/dev/null", O_RDONLY);
    (void)close(after);
    assert_int_equal(after, before); /* all descriptors are closed */
}

/* @return the next free descriptor */
static int next_descriptor(void)
{
    const int fd = open("/dev/null", O_RDONLY);
    (void)close(fd);
    return fd;
}

static void save_twice_and_damage(const char *path)
{
    char name[ECT_MEMORY_PATH + 4];
    ect_record_t newest;
    ect_memory_t *memory = must_open(path);
    assert_true(save(memory, "one", 4));
    assert_true(save(memory, "two", 4));
    assert_int_equal(ect_record_find(ect_memory_storage(memory), MAGIC, &newest), 1);
    ect_memory_close(memory);
    (void)snprintf(name, sizeof name, "%s.%u", path, newest.bank);
    overwrite(name, 32 + ECT_RECORD_HEADER, "XXX");
}

/* The report names each file with its folder, and the new name without the folder. */
static void reports_of_damage(void **state)
{
    static const struct {
        bool damaged[2];
        const char *message;
    } rows[] = {
        {{true, false}, "'aside/x.0' has no complete record and is kept as 'x.0.damaged1'"},
        {{false, true}, "'aside/x.1' has no complete record and is kept as 'x.1.damaged1'"},
        {{true, true},
         "'aside/x.0' has no complete record and is kept as 'x.0.damaged2'; "
         "'aside/x.1' has no complete record and is kept as 'x.1.damaged2'"},
    };
    (void)state;
    assert_int_equal(mkdir("aside", 0700), 0);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char message[ECT_MEMORY_MESSAGE];
        ect_memory_close(must_open("aside/x"));
        if (rows[i].damaged[0])
            overwrite("aside/x.0", 32, "a header?");
        if (rows[i].damaged[1])
            overwrite("aside/x.1", 32, "a header?");
        ect_memory_t *memory = ect_memory_open("aside/x", message);
        assert_non_null(memory);
        assert_string_equal(message, rows[i].message);
        ect_memory_close(memory);
    }
}

/* The longest file name leaves no room for the suffix .damaged1. */
static void damage_that_stays(void **state)
{
    enum { LONGEST = 255 - 2 }; /* of a file's name, without ".0" */
    char path[LONGEST + 1], wanted[ECT_MEMORY_MESSAGE], name[LONGEST + 3];
    (void)state;
    memset(path, 'd', LONGEST);
    path[LONGEST] = '\0';
    for (unsigned int bank = 0; bank < 2; bank++) {
        char message[ECT_MEMORY_MESSAGE];
        ect_memory_close(must_open(path));
        (void)snprintf(name, sizeof name, "%s.%u", path, bank);
        overwrite(name, 32, "a header?");
        (void)snprintf(wanted, sizeof wanted, "cannot keep what is saved in '%s': File name too long", name);
        for (unsigned int time = 0; time < 2; time++) {
            assert_null(ect_memory_open(path, message));
            assert_string_equal(message, wanted);
        }
        assert_int_equal(unlink(name), 0);
    }
}

static void longest_path_of_a_damaged_file(void **state)
{
    char path[ECT_MEMORY_PATH], message[ECT_MEMORY_MESSAGE];
    (void)state;
    memset(path, '/', sizeof path - 1);
    path[0] = '.';
    memcpy(path + sizeof path - 9, "far-away", 9);
    save_twice_and_damage(path);
    ect_memory_t *memory = ect_memory_open(path, message);
    assert_non_null(memory);
    assert_non_null(strstr(message, "is kept as 'far-away."));
    expect_saved(memory, "one");
    ect_memory_close(memory);
    assert_true(size_of("far-away.0.damaged1") > 0 || size_of("far-away.1.damaged1") > 0);
}

/* A power failure can leave wrong data only in the older record. */
static void age_of_a_record_without_data(void **state)
{
    static const struct {
        uint32_t newer; /* sequence number, relative to the record in the other bank */
        bool damaged;
    } rows[] = {{UINT32_MAX, false}, {0, true}, {1, true}, {INT32_MAX, true}, {0x80000000u, false}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char message[ECT_MEMORY_MESSAGE];
        uint8_t header[ECT_RECORD_HEADER];
        ect_record_t newest;
        ect_memory_t *memory = must_open("age");
        assert_true(save(memory, "one", 4));
        assert_int_equal(ect_record_find(ect_memory_storage(memory), MAGIC, &newest), 1);
        const ect_storage_t *s = ect_memory_storage(memory);
        assert_int_equal(s->read(s->ctx, newest.bank, 0, header, sizeof header), 0);
        ect_store_le32(header + 4, newest.sequence + rows[i].newer);
        ect_store_le32(header + 12, ~newest.check);
        assert_int_equal(s->write(s->ctx, newest.bank ^ 1u, 0, header, sizeof header), 0);
        ect_memory_close(memory);
        memory = ect_memory_open("age", message);
        assert_non_null(memory);
        assert_int_equal(*message != '\0', rows[i].damaged);
        expect_saved(memory, "one");
        ect_memory_close(memory);
        assert_int_equal(unlink("age.0"), 0);
        assert_int_equal(unlink("age.1"), 0);
    }
}

/* Each read returns at most a piece of the file. */
static void read_in_pieces(void **state)
{
    static const size_t pieces[] = {4096, ECT_MEMORY_BANK - 1};
    static uint8_t data[ECT_MEMORY_BANK - ECT_RECORD_HEADER];
    (void)state;
    for (size_t i = 0; i < sizeof pieces / sizeof pieces[0]; i++) {
        const uint32_t size = sizeof data;
        uint8_t last;
        for (uint32_t at = 0; at < size; at++)
            data[at] = (uint8_t)(at * 7 + 1);
        ect_memory_t *memory = must_open("pieces");
        assert_true(save(memory, data, size));
        ect_memory_close(memory);
        disk.piece = pieces[i];
        memory = must_open("pieces");
        disk.piece = 0;
        ect_record_t record;
        assert_int_equal(ect_record_find(ect_memory_storage(memory), MAGIC, &record), 1);
        assert_int_equal(record.length, size);
        assert_true(ect_record_get(&record, size - 1, &last, 1));
        assert_int_equal(last, data[size - 1]);
        ect_memory_close(memory);
    }
}

/* The unreadable part may contain a record. */
static void unreadable(void **state)
{
    (void)state;
    ect_memory_t *memory = must_open("bad");
    assert_true(save(memory, "data", 5));
    ect_memory_close(memory);
    disk.bad_from = 32;
    expect_refused("bad", strerror(EIO));
    disk.bad_from = 0;
    memory = must_open("bad");
    expect_saved(memory, "data");
    ect_memory_close(memory);
    assert_int_equal(unlink("bad.0"), 0);
    assert_int_equal(unlink("bad.1"), 0);
}

/* A daemon's standard input may be closed: the first file then gets descriptor 0. */
static void descriptor_0(void **state)
{
    (void)state;
    const int input = dup(STDIN_FILENO);
    (void)close(STDIN_FILENO);
    ect_memory_t *memory = must_open("zero");
    const bool used = fcntl(STDIN_FILENO, F_GETFD) >= 0;
    const bool saved = save(memory, "one", 4) && save(memory, "two", 4) && save(memory, "three", 6);
    ect_memory_close(memory);
    const bool left = fcntl(STDIN_FILENO, F_GETFD) >= 0;
    memory = must_open("zero");
    expect_saved(memory, "three"); /* each file has one of the last two records */
    ect_memory_close(memory);
    if (input >= 0) {
        (void)dup2(input, STDIN_FILENO);
        close(input);
    }
    assert_true(used && saved);
    assert_false(left);
}

static void closes_its_descriptors(void **state)
{
    static const char *const paths[] = {"shut", "./shut", "/tmp/../dev/null/no"}; /* created, found, refused */
    (void)state;
    for (size_t i = 0; i < sizeof paths / sizeof paths[0]; i++) {
        char message[ECT_MEMORY_MESSAGE];
        const int before = next_descriptor();
        ect_memory_close(ect_memory_open(paths[i], message));
        assert_int_equal(next_descriptor(), before);
    }
}

/* A save need not wait for the synchronisation; the close of a memory waits. */
static void slow_disk(void **state)
{
    static const struct {
        const char *title;
        int end; /* 0, or the error of the disk */
        bool wait, always;
        int result;
    } rows[] = {{"ends while it is waited for", 0, true, false, 0},
                {"fails while it is waited for", EIO, true, false, -1},
                {"is not waited for", 0, false, false, ECT_STORAGE_BUSY},
                {"is not waited for and will fail", EIO, false, false, ECT_STORAGE_BUSY},
                {"ends, in a memory that waits", 0, false, true, 0},
                {"fails, in a memory that waits", EIO, false, true, -1}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_memory_t *memory = must_open("slow");
        const ect_storage_t *s = ect_memory_storage(memory);
        memset(&disk, 0, sizeof disk);
        disk.slow = true;
        disk.state = EINPROGRESS;
        disk.end = rows[i].end;
        assert_int_equal(s->write(s->ctx, 1, 100, "abcd", 4), 0);
        if (rows[i].always)
            ect_memory_wait(memory);
        const int result = s->flush(s->ctx, 1, rows[i].wait);
        if (rows[i].result < 0 ? result >= 0 : result != rows[i].result)
            fail_msg("%s: %d", rows[i].title, result);
        assert_int_equal(disk.begun, 1);
        assert_int_equal(disk.waits, rows[i].wait || rows[i].always ? 1 : 0);
        ect_memory_close(memory);
        assert_int_equal(disk.waits, 1);
        assert_int_equal(disk.ended, 1);
        memset(&disk, 0, sizeof disk);
    }
}

/* Leaves a record without a commit, as by a kill. */
static void leave_unfinished(const char *path, const char *text)
{
    ect_record_t newest, record;
    ect_memory_t *memory = must_open(path);
    assert_int_equal(ect_record_find(ect_memory_storage(memory), MAGIC, &newest), 1);
    assert_true(ect_record_begin(&record, &newest));
    assert_true(ect_record_put(&record, text, (uint32_t)strlen(text)));
    ect_memory_close(memory);
}

static void cut_off_saves(void **state)
{
    (void)state;
    ect_memory_t *memory = must_open("killed");
    assert_true(save(memory, "one", 4));
    assert_true(save(memory, "two", 4));
    ect_memory_close(memory);
    for (unsigned int n = 1; n <= 20; n++)
        leave_unfinished("killed", "a record that was never finished");
    memory = must_open("killed");
    expect_saved(memory, "two");
    assert_true(save(memory, "three", 6));
    expect_saved(memory, "three");
    ect_memory_close(memory);
    assert_true(size_of("killed.0.damaged1") < 0 && size_of("killed.1.damaged1") < 0);
}

/* After a power failure the older bank may have the previous header with data of the next record. */
static void cut_off_by_power(void **state)
{
    ect_record_t newest;
    (void)state;
    ect_memory_t *memory = must_open("power");
    assert_true(save(memory, "one", 4));
    assert_true(save(memory, "two", 4));
    assert_int_equal(ect_record_find(ect_memory_storage(memory), MAGIC, &newest), 1);
    ect_memory_close(memory);
    overwrite(newest.bank == 0 ? "power.1" : "power.0", 32 + ECT_RECORD_HEADER, "XXX");
    memory = must_open("power");
    expect_saved(memory, "two");
    ect_memory_close(memory);
}

/* A full disk, or a kill during the creation of a file, leaves a file without content. */
static void cut_off_first_start(void **state)
{
    struct rlimit before, small;
    char message[ECT_MEMORY_MESSAGE];
    (void)state;
    write_file("first.0", "", 0, ECT_MEMORY_BANK + 32);
    ect_memory_t *memory = must_open("first");
    assert_true(save(memory, "one", 4));
    ect_memory_close(memory);
    memory = must_open("first");
    expect_saved(memory, "one");
    ect_memory_close(memory);
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    small = (struct rlimit){.rlim_cur = 16, .rlim_max = before.rlim_max};
    signal(SIGXFSZ, SIG_IGN);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
    memory = ect_memory_open("full", message);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
    assert_null(memory);
    ect_memory_close(must_open("full"));
}

/* All ones, a length beyond the bank, text. */
static void damaged_headers(void **state)
{
    static const char *const headers[] = {"\xff\xff\xff\xff\xff\xff\xff\xff\xff\xff\xff\xff\xff\xff\xff\xff",
                                          "TEST\x01\x01\x01\x01\xff\xff\xff\x7f", "hello, world!"};
    char message[ECT_MEMORY_MESSAGE];
    (void)state;
    for (size_t i = 0; i < sizeof headers / sizeof headers[0]; i++) {
        ect_memory_close(must_open("header"));
        overwrite("header.0", 32, headers[i]);
        ect_memory_t *memory = ect_memory_open("header", message);
        assert_non_null(memory);
        assert_non_null(strstr(message, "has no complete record"));
        expect_saved(memory, "none");
        assert_true(save(memory, "one", 4));
        ect_memory_close(memory);
        memory = must_open("header");
        expect_saved(memory, "one");
        ect_memory_close(memory);
        assert_int_equal(unlink("header.0"), 0);
        assert_int_equal(unlink("header.1"), 0);
    }
}

static void largest_record(void **state)
{
    static uint8_t data[ECT_MEMORY_BANK - ECT_RECORD_HEADER + 1];
    ect_record_t record;
    (void)state;
    memset(data, 0x5A, sizeof data);
    ect_memory_t *memory = must_open("largest");
    assert_false(save(memory, data, sizeof data));
    assert_true(save(memory, data, sizeof data - 1));
    ect_memory_close(memory);
    memory = must_open("largest");
    assert_int_equal(ect_record_find(ect_memory_storage(memory), MAGIC, &record), 1);
    assert_int_equal(record.length, sizeof data - 1);
    ect_memory_close(memory);
}

static void note_number(void *ctx, size_t number)
{
    size_t *last = ctx;
    *last += number;
}

static void observed(void **state)
{
    char message[ECT_MEMORY_MESSAGE];
    size_t sum = 0;
    (void)state;
    ect_memory_t *m = ect_memory_open(NULL, message);
    ect_memory_observe(m, note_number, &sum, 7);
    assert_true(save(m, "a", 1));
    assert_int_equal(sum, 7);
    ect_memory_observe(m, NULL, NULL, 0);
    assert_true(save(m, "b", 1));
    assert_int_equal(sum, 7);
    ect_memory_close(m);
}

/* The results of the flushes, and their replacement. */
typedef struct flushes {
    int results[8];
    unsigned int count;
    int replacement;
} flushes_t;

static int replace_result(void *ctx, int result)
{
    flushes_t *f = ctx;
    assert_true(f->count < sizeof f->results / sizeof f->results[0]);
    f->results[f->count++] = result;
    return f->replacement;
}

static void replaced_flushes(void **state)
{
    (void)state;
    for (unsigned int i = 0; i < 2; i++) {
        flushes_t f = {.replacement = 0};
        ect_memory_t *m = must_open(i == 0 ? NULL : "flushed");
        const ect_storage_t *storage = ect_memory_storage(m);
        ect_memory_replace_flush(m, replace_result, &f);
        assert_true(save(m, "a", 1));
        assert_true(f.count >= 1);
        for (unsigned int n = 0; n < f.count; n++)
            assert_int_equal(f.results[n], 0);
        f.count = 0;
        f.replacement = ECT_STORAGE_BUSY;
        assert_int_equal(storage->flush(storage->ctx, 1, true), ECT_STORAGE_BUSY);
        f.replacement = -1;
        assert_int_equal(storage->flush(storage->ctx, 1, true), -1);
        assert_int_equal(f.count, 2);
        ect_memory_replace_flush(m, NULL, NULL);
        assert_int_equal(storage->flush(storage->ctx, 1, true), 0);
        assert_int_equal(f.count, 2);
        ect_memory_close(m);
    }
}

/* Even with umask 0 no other user can read or change the files. */
static void own_file(void **state)
{
    static const char *const files[] = {"own.0", "own.1"};
    struct stat its;
    (void)state;
    mode_t before = umask(0);
    ect_memory_close(must_open("own"));
    (void)umask(before);
    for (size_t i = 0; i < sizeof files / sizeof files[0]; i++) {
        assert_int_equal(stat(files[i], &its), 0);
        assert_int_equal(its.st_mode & 07777, 0600);
    }
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"A saved record is read back at the next start", keeps, NULL, NULL, NULL},
        {"Without a path a record lasts as long as the process", without_files, NULL, NULL, NULL},
        {"A path has at most 511 characters", longest_path, NULL, NULL, NULL},
        {"The bytes of a bank follow the header of its file, from the first to the last", ends_of_a_bank, NULL, NULL,
         NULL},
        {"Attack: a file that is not a twin's record is refused and not changed", foreign_files, NULL, NULL, NULL},
        {"Attack: links, pipes and folders are refused", links_and_devices, NULL, NULL, NULL},
        {"Only the user of the twin can read or write the files", own_file, NULL, NULL, NULL},
        {"A second twin with the same files is refused", one_twin_each, NULL, NULL, NULL},
        {"Attack: after a file of a running twin is truncated, the next save fails", cut_while_it_runs, NULL, NULL,
         NULL},
        {"After a file of a running twin is deleted, the next save fails", deleted_while_it_runs, NULL, NULL, NULL},
        {"A damaged record is reported and kept under another name, nine times at most; the previous record is used",
         damaged, NULL, NULL, NULL},
        {"After an interrupted save the previous record is used, without a report, twenty times", cut_off_saves, NULL,
         NULL, NULL},
        {"After a save that a power failure has interrupted, the newest complete record is used, without a report",
         cut_off_by_power, NULL, NULL, NULL},
        {"After an interrupted first start, and after one with a full disk, the next start succeeds",
         cut_off_first_start, NULL, NULL, NULL},
        {"Attack: a file with an impossible header is reported, and the twin can save again", damaged_headers, NULL,
         NULL, NULL},
        {"A report of damage names each file, and its new name", reports_of_damage, NULL, NULL, NULL},
        {"A damaged file that cannot be renamed is refused with its name, and not changed", damage_that_stays, NULL,
         NULL, NULL},
        {"A damaged file with the longest path is renamed", longest_path_of_a_damaged_file, NULL, NULL, NULL},
        {"A record with wrong data is reported only if it is newer than the other record", age_of_a_record_without_data,
         NULL, NULL, NULL},
        {"A file is read completely from a disk that reads in pieces", read_in_pieces, NULL, NULL, NULL},
        {"A file that the disk cannot read is refused and not changed", unreadable, NULL, NULL, NULL},
        {"With the standard input closed, a file has descriptor 0, which is closed with the memory", descriptor_0, NULL,
         NULL, NULL},
        {"All descriptors are closed with the memory", closes_its_descriptors, NULL, NULL, NULL},
        {"A flush waits for a slow disk on request or as set, the close of a memory always", slow_disk, NULL, NULL,
         NULL},
        {"An observer gets its number once for each save", observed, NULL, NULL, NULL},
        {"A function replaces the result of each flush, with files and without", replaced_flushes, NULL, NULL, NULL},
        {"The longest record fills the bank to its last byte; a longer one is refused", largest_record, NULL, NULL,
         NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Memory", tests, make_work, remove_work);
}
