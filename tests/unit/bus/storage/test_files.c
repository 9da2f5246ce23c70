/* SPDX-License-Identifier: MIT */
/* The files of a twin: names that a master can and cannot open (files.h). */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "bus/storage/files.h"
#include "support/testdev.h"
#include "support/wire.h"

static char folder[64], outside[64];
static ect_files_t *files;
static const ect_foe_t *foe;

/* The error of the next call of each kind; 0: none. */
static struct {
    int openat_error, pread_error, pwrite_error, renameat_error;
} disk;

int __real_openat(int folder_fd, const char *path, int flags, ...);
int __wrap_openat(int folder_fd, const char *path, int flags, ...);
ssize_t __real_pread(int fd, void *bytes, size_t length, off_t at);
ssize_t __wrap_pread(int fd, void *bytes, size_t length, off_t at);
ssize_t __real_pwrite(int fd, const void *bytes, size_t length, off_t at);
ssize_t __wrap_pwrite(int fd, const void *bytes, size_t length, off_t at);
int __real_renameat(int from_fd, const char *from, int to_fd, const char *to);
int __wrap_renameat(int from_fd, const char *from, int to_fd, const char *to);

/* @return whether the call fails */
static bool fails(int *error)
{
    if (*error == 0)
        return false;
    errno = *error;
    *error = 0;
    return true;
}

int __wrap_openat(int folder_fd, const char *path, int flags, ...)
{
    va_list arguments;
    va_start(arguments, flags);
    const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(arguments, mode_t) : 0;
    va_end(arguments);
    return fails(&disk.openat_error) ? -1 : __real_openat(folder_fd, path, flags, mode);
}

ssize_t __wrap_pread(int fd, void *bytes, size_t length, off_t at)
{
    return fails(&disk.pread_error) ? -1
                                    : __real_pread(fd, bytes, length > 2 ? 2 : length, at); /* in pieces of 2 bytes */
}

ssize_t __wrap_pwrite(int fd, const void *bytes, size_t length, off_t at)
{
    return fails(&disk.pwrite_error) ? -1 : __real_pwrite(fd, bytes, length, at);
}

int __wrap_renameat(int from_fd, const char *from, int to_fd, const char *to)
{
    return fails(&disk.renameat_error) ? -1 : __real_renameat(from_fd, from, to_fd, to);
}

static const char *in(const char *name)
{
    static char path[400];
    (void)snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

static void put(const char *path, const char *content)
{
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    assert_true(fputs(content, file) >= 0);
    assert_int_equal(fclose(file), 0);
}

static void expect_content(const char *path, const char *content)
{
    char got[64] = "nothing";
    FILE *file = fopen(path, "r");
    if (file) {
        size_t length = fread(got, 1, sizeof got - 1, file);
        got[length] = '\0';
        (void)fclose(file);
    }
    if (strcmp(got, content) != 0)
        fail_msg("%s: expected \"%s\", got \"%s\"", path, content, got);
}

static const ect_foe_t *entry_of(const ect_device_t *device)
{
    const ect_protocol_t *const *p = device->protocols;
    while ((*p)->type != ECT_MAILBOX_TYPE_FOE)
        p++;
    return (const ect_foe_t *)(const void *)*p;
}

static int set_up(void **state)
{
    char message[ECT_FILES_MESSAGE];
    (void)state;
    (void)strcpy(folder, "/tmp/ectwin-files-XXXXXX");
    (void)strcpy(outside, "/tmp/ectwin-outside-XXXXXX");
    assert_non_null(mkdtemp(folder));
    int fd = mkstemp(outside);
    assert_true(fd >= 0);
    (void)close(fd);
    put(outside, "not yours");
    put(in("data"), "hello");
    put(in(".hidden"), "not yours either");
    assert_int_equal(mkdir(in("sub"), 0700), 0);
    put(in("sub/inner"), "nor this");
    assert_int_equal(symlink(outside, in("link")), 0);
    assert_int_equal(mkfifo(in("pipe"), 0600), 0);
    files = ect_files_open(folder, &testdev, 0, message);
    assert_non_null(files);
    foe = entry_of(ect_files_device(files));
    return 0;
}

static int tear_down(void **state)
{
    static const char *const names[] = {"data", ".hidden", "sub/inner", "link", "pipe", "new", "other"};
    (void)state;
    ect_files_close(files);
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++)
        (void)unlink(in(names[i]));
    (void)rmdir(in("sub"));
    (void)unlink(outside);
    return rmdir(folder); /* fails if a file remains */
}

static char said[100]; /* text of the reply to the last open */

static uint32_t open_name(const char *name, size_t length, bool write)
{
    const char *text = "";
    const ect_foe_file_t wish = {.name = name, .length = (uint16_t)length, .write = write, .state = ECT_STATE_PREOP};
    const uint32_t code = foe->open(foe, NULL, &wish, &text);
    (void)snprintf(said, sizeof said, "%s", text);
    return code;
}

static uint32_t write_piece(uint32_t offset, const char *text, bool last)
{
    const char *why = NULL;
    return foe->write(foe, NULL, offset, text, (uint16_t)strlen(text), last, &why);
}

static void names(void **state)
{
    static char longest[200];
    static const struct {
        const char *what, *name;
        size_t length;
        uint32_t read, write;
    } table[] = {
        {"a folder above", "../data", 7, ECT_FOE_NOT_FOUND, ECT_FOE_NOT_FOUND},
        {"the folder above", "..", 2, ECT_FOE_NOT_FOUND, ECT_FOE_NOT_FOUND},
        {"the folder itself", ".", 1, ECT_FOE_NOT_FOUND, ECT_FOE_NOT_FOUND},
        {"from the root", "/etc/passwd", 11, ECT_FOE_NOT_FOUND, ECT_FOE_NOT_FOUND},
        {"a folder in it", "sub/inner", 9, ECT_FOE_NOT_FOUND, ECT_FOE_NOT_FOUND},
        {"backslashes", "..\\data", 7, ECT_FOE_NOT_FOUND, ECT_FOE_NOT_FOUND},
        {"a hidden file", ".hidden", 7, ECT_FOE_NOT_FOUND, ECT_FOE_NOT_FOUND},
        {"a blank at its beginning", " data", 5, ECT_FOE_NOT_FOUND, ECT_FOE_NOT_FOUND},
        {"a blank alone", " ", 1, ECT_FOE_NOT_FOUND, ECT_FOE_NOT_FOUND},
        {"a zero in it", "data\0../x", 9, ECT_FOE_NOT_FOUND, ECT_FOE_NOT_FOUND},
        {"a zero at its end", "data\0", 5, ECT_FOE_NOT_FOUND, ECT_FOE_NOT_FOUND},
        {"no character", "", 0, ECT_FOE_NOT_FOUND, ECT_FOE_NOT_FOUND},
        {"a line's end", "data\n", 5, ECT_FOE_NOT_FOUND, ECT_FOE_NOT_FOUND},
        {"a blank", "my data", 7, ECT_FOE_NOT_FOUND, ECT_FOE_NOT_FOUND},
        {"beyond ASCII", "d\xC3\xA4ta", 5, ECT_FOE_NOT_FOUND, ECT_FOE_NOT_FOUND},
        {"too long", longest, 129, ECT_FOE_NOT_FOUND, ECT_FOE_NOT_FOUND},
        {"a folder", "sub", 3, ECT_FOE_ACCESS, ECT_FOE_ACCESS},
        {"a link that leads out", "link", 4, ECT_FOE_ACCESS, ECT_FOE_ACCESS},
        {"a pipe", "pipe", 4, ECT_FOE_ACCESS, ECT_FOE_ACCESS},
        {"no file of that name", "new", 3, ECT_FOE_NOT_FOUND, ECT_FOE_OK},
        {"the longest name", longest, 128, ECT_FOE_NOT_FOUND, ECT_FOE_OK},
        {"one character", "n", 1, ECT_FOE_NOT_FOUND, ECT_FOE_OK},
        {"a file", "data", 4, ECT_FOE_OK, ECT_FOE_OK},
    };
    (void)state;
    memset(longest, 'n', sizeof longest);
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        uint32_t read = open_name(table[i].name, table[i].length, false);
        foe->close(foe, NULL, false);
        uint32_t write = open_name(table[i].name, table[i].length, true);
        foe->close(foe, NULL, false);
        if (read != table[i].read || write != table[i].write)
            fail_msg("%s: expected 0x%X to read and 0x%X to write, got 0x%X and 0x%X", table[i].what, table[i].read,
                     table[i].write, read, write);
    }
    (void)open_name("../data", 7, false);
    assert_string_equal(said, "not a name of a file here");
    expect_content(outside, "not yours");
    expect_content(in("data"), "hello");
    expect_content(in("new"), "nothing");
}

static void whole_files_only(void **state)
{
    (void)state;
    assert_int_equal(open_name("data", 4, true), ECT_FOE_OK);
    assert_int_equal(write_piece(0, "good", false), ECT_FOE_OK);
    expect_content(in("data"), "hello");
    foe->close(foe, NULL, false);
    expect_content(in("data"), "hello");
    assert_int_equal(open_name("data", 4, true), ECT_FOE_OK);
    assert_int_equal(write_piece(0, "good", false), ECT_FOE_OK);
    assert_int_equal(write_piece(4, "bye", true), ECT_FOE_OK);
    foe->close(foe, NULL, true);
    expect_content(in("data"), "goodbye");
    assert_int_equal(open_name("new", 3, true), ECT_FOE_OK);
    assert_int_equal(write_piece(0, "", true), ECT_FOE_OK);
    foe->close(foe, NULL, true);
    expect_content(in("new"), "");
}

static void read_pieces(void **state)
{
    char data[8] = "";
    uint16_t length = 3;
    const char *text = NULL;
    (void)state;
    assert_int_equal(open_name("data", 4, false), ECT_FOE_OK);
    assert_int_equal(foe->read(foe, NULL, 0, data, &length, &text), ECT_FOE_OK);
    assert_int_equal(length, 3);
    assert_memory_equal(data, "hel", 3);
    assert_int_equal(foe->read(foe, NULL, 3, data, &length, &text), ECT_FOE_OK);
    assert_int_equal(length, 2);
    assert_memory_equal(data, "lo", 2);
    foe->close(foe, NULL, true);
}

static void too_large(void **state)
{
    (void)state;
    assert_int_equal(open_name("new", 3, true), ECT_FOE_OK);
    assert_int_equal(write_piece(ECT_FILES_MOST - 4, "1234", false),
                     ECT_FOE_OK); /* a hole, which needs no space on the disk */
    assert_int_equal(write_piece(ECT_FILES_MOST - 3, "1234", false), ECT_FOE_DISK_FULL);
    expect_content(in("new"), "nothing");
}

/* During a transfer, a user replaces the incomplete file by a link. */
static void meanwhile(void **state)
{
    (void)state;
    assert_int_equal(open_name("new", 3, true), ECT_FOE_OK);
    assert_int_equal(write_piece(0, "good", false), ECT_FOE_OK);
    assert_int_equal(unlink(in(".new.part")), 0);
    assert_int_equal(symlink(outside, in(".new.part")), 0);
    assert_int_equal(write_piece(4, "bye", true), ECT_FOE_OK); /* renames the link; its target is unchanged */
    foe->close(foe, NULL, true);
    expect_content(outside, "not yours");
    assert_int_equal(open_name("new", 3, false), ECT_FOE_ACCESS);
    assert_int_equal(symlink(outside, in(".other.part")), 0);
    assert_int_equal(open_name("other", 5, true), ECT_FOE_OK);
    assert_int_equal(write_piece(0, "mine", true), ECT_FOE_OK);
    foe->close(foe, NULL, true);
    expect_content(in("other"), "mine");
    expect_content(outside, "not yours");
}

/* A user's new file with the name of the incomplete file is not removed by the close of the complete file. */
static void complete_before_its_close(void **state)
{
    (void)state;
    assert_int_equal(open_name("new", 3, true), ECT_FOE_OK);
    assert_int_equal(write_piece(0, "all", true), ECT_FOE_OK);
    put(in(".new.part"), "of a user");
    foe->close(foe, NULL, true);
    expect_content(in("new"), "all");
    expect_content(in(".new.part"), "of a user");
    assert_int_equal(unlink(in(".new.part")), 0);
}

/* @return the next free descriptor */
static int next_descriptor(void)
{
    const int fd = open("/dev/null", O_RDONLY);
    (void)close(fd);
    return fd;
}

/* After each error no descriptor is open, and no incomplete file exists. */
static void errors_of_the_disk(void **state)
{
    static const struct {
        int error;
        uint32_t code;
    } rows[] = {{ENOENT, ECT_FOE_NOT_FOUND}, {ENOSPC, ECT_FOE_DISK_FULL},  {EDQUOT, ECT_FOE_DISK_FULL},
                {EFBIG, ECT_FOE_DISK_FULL},  {EIO, ECT_FOE_PROGRAM_ERROR}, {EACCES, ECT_FOE_ACCESS},
                {EROFS, ECT_FOE_ACCESS},     {ELOOP, ECT_FOE_ACCESS}};
    const int before = next_descriptor();
    char data[8];
    const char *text = NULL;
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        for (unsigned int write = 0; write < 2; write++) {
            disk.openat_error = rows[i].error;
            assert_int_equal(open_name("data", 4, write != 0), rows[i].code);
            assert_int_equal(next_descriptor(), before);
        }
        uint16_t length = sizeof data;
        assert_int_equal(open_name("data", 4, false), ECT_FOE_OK);
        disk.pread_error = rows[i].error;
        assert_int_equal(foe->read(foe, NULL, 0, data, &length, &text), ECT_FOE_PROGRAM_ERROR);
        assert_int_equal(next_descriptor(), before);
        foe->close(foe, NULL, false);
        for (unsigned int rename = 0; rename < 2; rename++) {
            assert_int_equal(open_name("data", 4, true), ECT_FOE_OK);
            *(rename != 0 ? &disk.renameat_error : &disk.pwrite_error) = rows[i].error;
            assert_int_equal(write_piece(0, "bad", true), rows[i].code);
            assert_int_equal(next_descriptor(), before);
            assert_int_equal(access(in(".data.part"), F_OK), -1);
            foe->close(foe, NULL, false);
        }
        expect_content(in("data"), "hello");
    }
}

/* No child process inherits the descriptor, and opening a pipe would not block. */
static void descriptors_of_open_files(void **state)
{
    char message[ECT_FILES_MESSAGE];
    (void)state;
    const int folder_fd = next_descriptor();
    ect_files_t *opened = ect_files_open(folder, &testdev, 0, message);
    assert_non_null(opened);
    assert_int_equal(fcntl(folder_fd, F_GETFD), FD_CLOEXEC);
    ect_files_close(opened);
    for (unsigned int write = 0; write < 2; write++) {
        const int fd = next_descriptor();
        assert_int_equal(open_name("data", 4, write != 0), ECT_FOE_OK);
        assert_int_equal(fcntl(fd, F_GETFD), FD_CLOEXEC);
        assert_int_equal(fcntl(fd, F_GETFL) & (O_ACCMODE | O_NONBLOCK), (write ? O_WRONLY : O_RDONLY) | O_NONBLOCK);
        foe->close(foe, NULL, false);
        assert_int_equal(next_descriptor(), fd);
    }
}

/* The memory of a transfer follows the instance. */
static void instance_with_a_transfer(void **state)
{
    enum { ALIGNED = sizeof(max_align_t) };
    (void)state;
    for (size_t size = 1; size <= 2 * ALIGNED + 1; size++) {
        char message[ECT_FILES_MESSAGE];
        ect_device_t device = testdev;
        device.instance_size = size;
        device.mailbox_protocols = ECT_MAILBOX_COE;
        ect_files_t *opened = ect_files_open(folder, &device, 0, message);
        assert_non_null(opened);
        const ect_device_t *made = ect_files_device(opened);
        const size_t offset = entry_of(made)->offset;
        assert_in_range(offset, size, size + ALIGNED - 1);
        assert_int_equal(offset % ALIGNED, 0);
        assert_int_equal(made->instance_size, offset + sizeof(ect_foe_transfer_t));
        assert_int_equal(made->mailbox_protocols, ECT_MAILBOX_COE | ECT_MAILBOX_FOE);
        ect_files_close(opened);
    }
}

static void most_protocols_of_a_device(void **state)
{
    enum { MOST = 16 };
    static const ect_protocol_t protocol = {.type = ECT_MAILBOX_TYPE_COE};
    const ect_protocol_t *protocols[MOST + 2] = {NULL};
    char message[ECT_FILES_MESSAGE];
    ect_device_t device = testdev;
    (void)state;
    device.protocols = protocols;
    for (size_t count = 0; count <= MOST + 1; count++) {
        if (count > 0)
            protocols[count - 1] = &protocol;
        ect_files_t *opened = ect_files_open(folder, &device, 0, message);
        assert_true((opened != NULL) == (count <= MOST));
        if (opened == NULL) {
            assert_non_null(strstr(message, "the device has too many protocols"));
            continue;
        }
        const ect_protocol_t *const *all = ect_files_device(opened)->protocols;
        assert_int_equal(all[0]->type, ECT_MAILBOX_TYPE_FOE);
        for (size_t i = 1; i <= count; i++)
            assert_ptr_equal(all[i], &protocol);
        assert_null(all[count + 1]);
        ect_files_close(opened);
    }
}

static void refused_devices(void **state)
{
    char message[ECT_FILES_MESSAGE];
    ect_device_t none = testdev;
    (void)state;
    none.mailbox_protocols = 0;
    assert_null(ect_files_open(folder, &none, 0, message));
    assert_non_null(strstr(message, "the device has no mailbox"));
    assert_null(ect_files_open(folder, ect_files_device(files), 0, message));
    assert_non_null(strstr(message, "the device has files of its own"));
    assert_null(ect_files_open("/no/such/folder", &testdev, 0, message));
    assert_string_equal(message, "cannot open the folder '/no/such/folder' for files: No such file or directory");
    assert_null(ect_files_open(outside, &testdev, 0, message));
    assert_non_null(strstr(message, "' for files: Not a directory"));
}

/* The folder is closed while a file is open. */
static void closes_its_descriptors(void **state)
{
    char message[ECT_FILES_MESSAGE];
    (void)state;
    const int before = open("/dev/null", O_RDONLY);
    (void)close(before);
    ect_files_t *more = ect_files_open(folder, &testdev, 0, message);
    assert_non_null(more);
    const ect_foe_t *its = entry_of(ect_files_device(more));
    const ect_foe_file_t wish = {.name = "data", .length = 4, .state = ECT_STATE_PREOP};
    const char *text = NULL;
    const int file_fd = next_descriptor();
    assert_int_equal(its->open(its, NULL, &wish, &text), ECT_FOE_OK);
    ect_files_close(more);
    assert_int_equal(fcntl(file_fd, F_GETFD), -1);
    const int after = open("/dev/null", O_RDONLY);
    (void)close(after);
    assert_int_equal(after, before);
}

/* A twin with password 0 accepts each password. */
static void passwords(void **state)
{
    static const struct {
        uint32_t twin, master, want;
    } rows[] = {
        {0, 0, ECT_FOE_OK},
        {0, 7, ECT_FOE_OK},
        {1, 1, ECT_FOE_OK},
        {1, 0, ECT_FOE_ACCESS},
        {1, 2, ECT_FOE_ACCESS},
        {UINT32_MAX, UINT32_MAX, ECT_FOE_OK},
        {UINT32_MAX, 0, ECT_FOE_ACCESS},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char message[ECT_FILES_MESSAGE];
        const char *text = "";
        const ect_foe_file_t wish = {.name = "data", .length = 4, .password = rows[i].master, .state = ECT_STATE_PREOP};
        ect_files_t *locked = ect_files_open(folder, &testdev, rows[i].twin, message);
        assert_non_null(locked);
        const ect_foe_t *entry = entry_of(ect_files_device(locked));
        const uint32_t code = entry->open(entry, NULL, &wish, &text);
        entry->close(entry, NULL, false);
        ect_files_close(locked);
        if (code != rows[i].want)
            fail_msg("password %u for %u: expected 0x%X, got 0x%X", rows[i].master, rows[i].twin, rows[i].want, code);
    }
}

/* A master opens a file in BOOT, with a correct and a wrong password. */
static void over_the_wire(void **state)
{
    char message[ECT_FILES_MESSAGE];
    uint8_t mail[128] = {10, 0, 0, 0, 0, 0x14, 1, 0, 5, 0, 0, 0, 'd', 'a', 't', 'a'};
    wire_t w;
    (void)state;
    ect_files_t *locked = ect_files_open(folder, &testdev, 5, message);
    assert_non_null(locked);
    wire_open_one(&w, ect_files_device(locked));
    wire_configure_mailbox(&w, 0);
    assert_int_equal(wire_al(&w, 0, ECT_STATE_BOOT, NULL), ECT_STATE_BOOT);
    assert_int_equal(wire_write(&w, 0, 0x1000, mail, sizeof mail), 1);
    uint8_t answer[128];
    assert_int_equal(wire_read(&w, 0, 0x1080, answer, sizeof answer), 1);
    assert_memory_equal(answer + 6, "\3\0\1\0\0\0hello", 11);
    mail[5] = 0x24;
    mail[8] = 6;
    assert_int_equal(wire_write(&w, 0, 0x1000, mail, sizeof mail), 1);
    assert_int_equal(wire_read(&w, 0, 0x1080, answer, sizeof answer), 1);
    assert_memory_equal(answer + 6, "\5\0\2\x80\0\0", 6);
    wire_close(&w);
    ect_files_close(locked);
}

int main(void)
{
#define TEST(title, function) {title, function, set_up, tear_down, NULL}
    const struct CMUnitTest tests[] = {
        TEST("Attack: names that lead out of the folder or name no regular file are refused", names),
        TEST("Files: a written file replaces the previous file when it is complete", whole_files_only),
        TEST("Attack: a wrong password opens no file; a twin without a password accepts each", passwords),
        TEST("Files: a file is read in pieces", read_pieces),
        TEST("Attack: a file of more than 64 MiB is refused", too_large),
        TEST("Attack: links that are created during a transfer are not followed", meanwhile),
        TEST("Files: a complete file has its name before it is closed", complete_before_its_close),
        TEST("Files: each error of the disk has an error code of FoE", errors_of_the_disk),
        TEST("Files: no child process inherits a descriptor of the folder or of a file", descriptors_of_open_files),
        TEST("Files: the memory of a transfer follows the instance, aligned for any type", instance_with_a_transfer),
        TEST("Files: a device has at most 16 protocols besides FoE", most_protocols_of_a_device),
        TEST("Files: a device without a mailbox, or with files of its own, is refused with a line", refused_devices),
        TEST("Files: with a folder, its descriptors and those of its open files are closed", closes_its_descriptors),
        TEST("Files: a file is read in BOOT, with the correct password", over_the_wire),
    };
    return cmocka_run_group_tests_name("files", tests, NULL, NULL);
}
