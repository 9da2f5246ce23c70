/* SPDX-License-Identifier: MIT */
/* Saved records of a twin on a PC, and files that other programs change (memory.h). */
#define _GNU_SOURCE
#include "bus/storage/memory.h"

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

/* @return whether it was saved */
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
            expect_refused(path, "too long");
    }
    assert_int_equal(size_of("long.0"), ECT_MEMORY_BANK + 32);
    assert_int_equal(size_of("long.1"), ECT_MEMORY_BANK + 32);
}

/* Both ends of a bank, in memory and in the file behind its header. */
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
    (void)state;
    static const size_t sizes[] = {1, 100, ECT_MEMORY_BANK, ECT_MEMORY_BANK + 32, ECT_MEMORY_BANK + 33};
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        write_file("foreign.0", "M", 1, sizes[i]);
        expect_refused("foreign", "no record of a twin");
        assert_int_equal(size_of("foreign.0"), sizes[i]);
        assert_int_equal(size_of("foreign.1"), -1);
    }
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

/* A mapping of a file that is cut ends the process; what is kept of it does not change. */
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

static void overwrite(const char *name, off_t offset, const char *text)
{
    int fd = open(name, O_WRONLY);
    assert_true(fd >= 0);
    assert_int_equal(pwrite(fd, text, strlen(text), offset), (ssize_t)strlen(text));
    close(fd);
}

/* The newest record is in the bank that the second save went to. */
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
        assert_non_null(strstr(message, "holds no whole record"));
        assert_non_null(strstr(message, other));
        expect_saved(memory, "one"); /* the record before */
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
    assert_int_equal(after, before); /* no descriptor is left open */
}

/* A record that was begun and put, but not sealed: the process was killed. */
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

/* After a power failure the header before may still be there, with data that belong to the record after. */
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

/* A full disk, or a kill between the calls that make a file, leaves one without content. */
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

/* A length beyond the bank, all ones, text: no header that is read as one. */
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
        assert_non_null(strstr(message, "holds no whole record"));
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

/* The results that were, and those that are to be. */
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

/* Whatever the user's umask is: no other user reads or changes it. */
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
        {"A saved record is there at the next start", keeps, NULL, NULL, NULL},
        {"Without a path it lasts as long as the process", without_files, NULL, NULL, NULL},
        {"A path has at most 511 characters", longest_path, NULL, NULL, NULL},
        {"The first and the last byte of a bank are in the file behind its header", ends_of_a_bank, NULL, NULL, NULL},
        {"Attack: a file that no twin has made is refused, and stays as it is", foreign_files, NULL, NULL, NULL},
        {"Attack: links, pipes and folders are refused", links_and_devices, NULL, NULL, NULL},
        {"Only their user reads or writes the files", own_file, NULL, NULL, NULL},
        {"A second twin on the same files is refused", one_twin_each, NULL, NULL, NULL},
        {"Attack: a file that is cut while it runs: no crash, the next save fails", cut_while_it_runs, NULL, NULL,
         NULL},
        {"A file that is deleted while it runs: the next save fails", deleted_while_it_runs, NULL, NULL, NULL},
        {"A damaged record is reported and kept aside, nine times at most, the one before is used", damaged, NULL, NULL,
         NULL},
        {"A save that was cut off is ordinary: the record before is used, twenty times", cut_off_saves, NULL, NULL,
         NULL},
        {"A save that a power failure cut off is ordinary too", cut_off_by_power, NULL, NULL, NULL},
        {"A first start that was cut off, or met a full disk, is made good", cut_off_first_start, NULL, NULL, NULL},
        {"Attack: headers that make no sense", damaged_headers, NULL, NULL, NULL},
        {"An observer gets its number once a save", observed, NULL, NULL, NULL},
        {"A replay gives each flush the result that it had in the run, with files and without", replaced_flushes, NULL,
         NULL, NULL},
        {"A record fills the bank to its last byte, and no further", largest_record, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Memory", tests, make_work, remove_work);
}
