/* SPDX-License-Identifier: MIT */
/* The path and the owner of control sockets, and files that are left unchanged (endpoint.h). */
#define _GNU_SOURCE
#include "bus/control/endpoint.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cmocka.h>

/* A folder of the test, and its working directory. */
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

/* Creates a folder in `work`, and sets XDG_RUNTIME_DIR to it. @param[out] folder  of the sockets */
static void runtime_folder(const char *name, char folder[ECT_ENDPOINT_PATH])
{
    char path[ECT_ENDPOINT_PATH];
    snprintf(path, sizeof path, "%s/%s", work, name);
    for (char *at = path + strlen(work) + 1; at; at = strchr(at + 1, '/')) {
        char *end = strchr(at + 1, '/');
        if (end)
            *end = 0;
        assert_true(mkdir(path, 0700) == 0 || errno == EEXIST);
        if (!end)
            break;
        *end = '/';
        at = end - 1;
    }
    assert_int_equal(setenv("XDG_RUNTIME_DIR", path, 1), 0);
    assert_int_equal(ect_endpoint_folder(folder), 0);
}

static int must_listen(char path[ECT_ENDPOINT_PATH])
{
    char message[ECT_ENDPOINT_MESSAGE];
    int fd = ect_endpoint_listen(NULL, path, message);
    if (fd < 0)
        fail_msg("%s", message);
    assert_int_equal(fcntl(fd, F_GETFD) & FD_CLOEXEC, FD_CLOEXEC);
    assert_int_equal(fcntl(fd, F_GETFL) & O_NONBLOCK, O_NONBLOCK);
    return fd;
}

static void expect_reachable(int fd, const char *path)
{
    uid_t owner = 12345;
    int client = ect_endpoint_connect(path, &owner);
    if (client < 0)
        fail_msg("no process listens at %s: %s", path, strerror(errno));
    assert_int_equal(owner, geteuid());
    int served = accept(fd, NULL, NULL);
    assert_true(served >= 0);
    close(served);
    close(client);
}

/* Counts the files of a folder, hidden ones included. */
static int count_names(const char *folder)
{
    DIR *directory = opendir(folder);
    int count = 0;
    assert_non_null(directory);
    const struct dirent *entry;
    while ((entry = readdir(directory)) != NULL)
        count += strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0;
    closedir(directory);
    return count;
}

/* The mode of the last mkdir(), before any chmod(). */
static mode_t made_with;
int __real_mkdir(const char *path, mode_t mode);
int __wrap_mkdir(const char *path, mode_t mode);

int __wrap_mkdir(const char *path, mode_t mode)
{
    made_with = mode;
    return __real_mkdir(path, mode);
}

static void never_open_to_others(void **state)
{
    char folder[ECT_ENDPOINT_PATH], path[ECT_ENDPOINT_PATH];
    (void)state;
    runtime_folder("first start", folder);
    made_with = 0;
    int fd = must_listen(path);
    assert_int_equal(made_with, 0700);
    ect_endpoint_close(fd, path, ect_endpoint_identity(path));
}

static void rights(void **state)
{
    char folder[ECT_ENDPOINT_PATH], path[ECT_ENDPOINT_PATH];
    struct stat info;
    (void)state;
    runtime_folder("rights", folder);
    assert_int_equal(mkdir(folder, 0777), 0);
    assert_int_equal(chmod(folder, 0777), 0);
    const mode_t mask = umask(0027);
    int fd = must_listen(path);
    assert_int_equal(umask(mask), 0027); /* unchanged */
    assert_int_equal(stat(folder, &info), 0);
    assert_int_equal(info.st_mode & 07777, 0700);
    assert_int_equal(stat(path, &info), 0);
    assert_int_equal(info.st_mode & 07777, 0600);
    ect_endpoint_close(fd, path, ect_endpoint_identity(path));
    assert_int_equal(access(path, F_OK), -1);
}

static void odd_and_long_paths(void **state)
{
    char folder[ECT_ENDPOINT_PATH], path[ECT_ENDPOINT_PATH], name[500];
    static const char *const odd[] = {"with [brackets]*?", "with 'quotes\" and $", "with\nlines"};
    (void)state;
    for (size_t i = 0; i < sizeof odd / sizeof odd[0]; i++) {
        runtime_folder(odd[i], folder);
        int fd = must_listen(path);
        expect_reachable(fd, path);
        ect_endpoint_close(fd, path, ect_endpoint_identity(path));
        assert_int_equal(access(path, F_OK), -1);
    }
    /* Around and far above the length of a socket's address, 108 bytes. */
    for (size_t length = 90; length <= 400; length += 31) {
        memset(name, 'x', length);
        for (size_t i = 50; i < length; i += 50)
            name[i] = '/';
        name[length] = 0;
        runtime_folder(name, folder);
        int fd = must_listen(path);
        expect_reachable(fd, path);
        ect_endpoint_close(fd, path, ect_endpoint_identity(path));
        assert_int_equal(access(path, F_OK), -1);
    }
}

static void too_long_a_path(void **state)
{
    char name[ECT_ENDPOINT_PATH + 10], path[ECT_ENDPOINT_PATH], message[ECT_ENDPOINT_MESSAGE];
    uid_t owner;
    (void)state;
    memset(name, 'x', sizeof name - 1);
    name[sizeof name - 1] = 0;
    setenv("XDG_RUNTIME_DIR", name, 1);
    assert_int_equal(ect_endpoint_folder(path), -1);
    assert_int_equal(ect_endpoint_listen(NULL, path, message), -1);
    assert_non_null(strstr(message, "too long"));
    assert_int_equal(ect_endpoint_connect(name, &owner), -1);
    assert_int_equal(errno, ENAMETOOLONG);
}

/* A folder leaves 32 bytes of a path for a name; a path longer than a socket's address is reached through its folder.
 */
static void paths_at_their_limits(void **state)
{
    enum { FOLDER_MOST = ECT_ENDPOINT_PATH - 32 - 1 - (int)sizeof "/ectwin" + 1, ADDRESS = 108 };
    char name[ECT_ENDPOINT_PATH + 10], path[ECT_ENDPOINT_PATH], message[ECT_ENDPOINT_MESSAGE];
    uid_t owner;
    (void)state;
    for (size_t length = FOLDER_MOST - 1; length <= FOLDER_MOST + 1; length++) {
        memset(name, 'x', length);
        name[length] = 0;
        setenv("XDG_RUNTIME_DIR", name, 1);
        errno = 0;
        int result = ect_endpoint_folder(path);
        assert_int_equal(result, length <= FOLDER_MOST ? 0 : -1);
        assert_int_equal(errno, ENAMETOOLONG);
        if (result == 0)
            assert_int_equal(strlen(path), length + strlen("/ectwin"));
    }
    assert_int_equal(ect_endpoint_listen(NULL, path, message), -1);
    assert_non_null(strstr(message, "XDG_RUNTIME_DIR can name another place"));
    for (size_t length = ADDRESS - 1; length <= ADDRESS + 1;
         length++) { /* a path without a folder must fit the address */
        memset(name, 'y', length);
        name[length] = 0;
        assert_int_equal(ect_endpoint_connect(name, &owner), -1);
        assert_int_equal(errno, length < ADDRESS ? ENOENT : ENAMETOOLONG);
    }
    /* A name of 108 bytes fits no address, in any folder. */
    char longest[ECT_ENDPOINT_PATH + sizeof work + 16];
    snprintf(longest, sizeof longest, "%s/%s", work, name);
    assert_int_equal(ect_endpoint_connect(longest, &owner), -1);
    assert_int_equal(errno, ENAMETOOLONG);
    assert_int_equal(ect_endpoint_identity(longest), 0);
}

/* Names of which the path has 1023 bytes, in short and long folders. */
static void the_longest_name_that_is_found(void **state)
{
    enum { ROOM = 1023 - (int)sizeof "/.sock" + 1 };
    char runtime[ECT_ENDPOINT_PATH], name[ECT_ENDPOINT_PATH], path[ECT_ENDPOINT_PATH];
    (void)state;
    for (size_t length = 100; length <= 900; length += 400) {
        memset(runtime, 'x', length);
        runtime[length] = 0;
        setenv("XDG_RUNTIME_DIR", runtime, 1);
        assert_int_equal(ect_endpoint_folder(path), 0);
        const size_t most = ROOM - strlen(path);
        memset(name, 'n', most + 1);
        name[most + 1] = 0;
        assert_int_equal(ect_endpoint_find(name, path), -1);
        name[most] = 0;
        assert_int_equal(ect_endpoint_find(name, path), 0);
        assert_int_equal(strlen(path), 1023);
        assert_string_equal(path + 1023 - sizeof "n.sock" + 1, "n.sock");
    }
}

/* Containers with a common folder may have equal process ids: the second twin takes another name. */
static void names_that_collide(void **state)
{
    char folder[ECT_ENDPOINT_PATH], path[3][ECT_ENDPOINT_PATH];
    int fds[3];
    (void)state;
    runtime_folder("collide", folder);
    for (size_t i = 0; i < 3; i++)
        fds[i] = must_listen(path[i]);
    for (size_t i = 0; i < 3; i++) {
        assert_string_not_equal(path[i], path[(i + 1) % 3]);
        expect_reachable(fds[i], path[i]);
    }
    ect_endpoint_close(fds[1], path[1], ect_endpoint_identity(path[1]));
    expect_reachable(fds[0], path[0]);
    fds[1] = must_listen(path[1]);
    expect_reachable(fds[1], path[1]);
    for (size_t i = 0; i < 3; i++)
        ect_endpoint_close(fds[i], path[i], ect_endpoint_identity(path[i]));
    assert_int_equal(rmdir(folder), 0);
}

/* A hundred names for the socket, and for the hidden file that becomes the socket. */
static void most_names(void **state)
{
    enum { MOST = 100 };
    static const struct {
        const char *before, *after;
        int taken;
        bool finds;
    } rows[] = {
        {"", ".sock", MOST - 1, true}, {"", ".sock", MOST, false}, {".", "", MOST - 1, true}, {".", "", MOST, false}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char folder[ECT_ENDPOINT_PATH], path[ECT_ENDPOINT_PATH], message[ECT_ENDPOINT_MESSAGE], name[16];
        snprintf(name, sizeof name, "most%zu", i);
        runtime_folder(name, folder);
        assert_int_equal(mkdir(folder, 0700), 0);
        for (int n = 1; n <= rows[i].taken; n++) {
            char file[ECT_ENDPOINT_PATH + 64], number[16] = "";
            if (n > 1)
                snprintf(number, sizeof number, "-%d", n);
            snprintf(file, sizeof file, "%s/%s%d%s%s", folder, rows[i].before, (int)getpid(), number, rows[i].after);
            close(open(file, O_CREAT | O_WRONLY, 0600));
        }
        const int free_before = open("/dev/null", O_RDONLY);
        close(free_before);
        int fd = ect_endpoint_listen(NULL, path, message);
        const int free_after = open("/dev/null", O_RDONLY);
        close(free_after);
        assert_int_equal(free_after - free_before, rows[i].finds);
        if ((fd >= 0) != rows[i].finds || (fd < 0 && errno != EADDRINUSE))
            fail_msg("%d names of the kind '%sPID%s': got %d, %s", rows[i].taken, rows[i].before, rows[i].after, fd,
                     strerror(errno));
        assert_int_equal(count_names(folder), rows[i].taken + rows[i].finds);
        if (fd >= 0)
            ect_endpoint_close(fd, path, ect_endpoint_identity(path));
    }
}

static void dead_socket(void **state)
{
    char folder[ECT_ENDPOINT_PATH], path[2][ECT_ENDPOINT_PATH];
    (void)state;
    runtime_folder("dead", folder);
    close(must_listen(path[0])); /* as by a kill: the file remains */
    int fd = must_listen(path[1]);
    assert_string_equal(path[0], path[1]);
    expect_reachable(fd, path[1]);
    ect_endpoint_close(fd, path[1], ect_endpoint_identity(path[1]));
}

/* A daemon's standard input may be closed: a socket or a connection then gets descriptor 0. */
static void descriptor_0(void **state)
{
    char folder[ECT_ENDPOINT_PATH], path[2][ECT_ENDPOINT_PATH];
    uid_t owner = 0;
    (void)state;
    runtime_folder("zero", folder);
    int fd = must_listen(path[0]);
    const int input = dup(STDIN_FILENO);
    (void)close(STDIN_FILENO);
    const int connected = ect_endpoint_connect(path[0], &owner);
    (void)close(STDIN_FILENO);
    const int listening = must_listen(path[1]);
    ect_endpoint_close(listening, path[1], ect_endpoint_identity(path[1]));
    if (input >= 0) {
        (void)dup2(input, STDIN_FILENO);
        close(input);
    }
    assert_int_equal(connected, STDIN_FILENO);
    assert_int_equal(listening, STDIN_FILENO);
    assert_int_equal(owner, geteuid());
    ect_endpoint_close(fd, path[0], ect_endpoint_identity(path[0]));
}

/* Dead sockets are removed; live sockets and other files remain. */
static void dead_sockets_of_others(void **state)
{
    char folder[ECT_ENDPOINT_PATH], path[ECT_ENDPOINT_PATH], left[ECT_ENDPOINT_PATH], live[ECT_ENDPOINT_PATH];
    char file[ECT_ENDPOINT_PATH + 16], hidden[ECT_ENDPOINT_PATH + 16];
    (void)state;
    runtime_folder("left", folder);
    close(must_listen(path));
    snprintf(hidden, sizeof hidden, "%s/.sock", folder);
    assert_int_equal(rename(path, hidden), 0);
    close(must_listen(path));
    snprintf(left, sizeof left, "%.900s/1.sock", folder);
    snprintf(live, sizeof live, "%.900s/2.sock", folder);
    snprintf(file, sizeof file, "%s/3.sock", folder);
    assert_int_equal(rename(path, left), 0);
    int second = must_listen(path);
    assert_int_equal(rename(path, live), 0);
    close(open(file, O_CREAT | O_WRONLY, 0600));
    int fd = must_listen(path);
    assert_int_equal(access(left, F_OK), -1);
    assert_int_equal(access(live, F_OK), 0);
    assert_int_equal(access(file, F_OK), 0);
    assert_int_equal(access(hidden, F_OK), 0); /* a name of no twin */
    ect_endpoint_close(fd, path, ect_endpoint_identity(path));
    ect_endpoint_close(second, live, ect_endpoint_identity(live));
}

/* The file has been removed, and another process has a socket with its name. */
static void name_of_another(void **state)
{
    char folder[ECT_ENDPOINT_PATH], path[ECT_ENDPOINT_PATH], other[ECT_ENDPOINT_PATH];
    (void)state;
    runtime_folder("another", folder);
    int fd = must_listen(path);
    ino_t identity = ect_endpoint_identity(path);
    assert_true(identity != 0);
    assert_int_equal(unlink(path), 0);
    int second = must_listen(other);
    assert_string_equal(path, other);
    ect_endpoint_close(fd, path, identity);
    expect_reachable(second, other);
    ect_endpoint_close(second, other, ect_endpoint_identity(other));
}

static void other_files_than_sockets(void **state)
{
    char folder[ECT_ENDPOINT_PATH], path[ECT_ENDPOINT_PATH + 32], taken[ECT_ENDPOINT_PATH];
    struct stat info;
    (void)state;
    runtime_folder("no socket", folder);
    assert_int_equal(mkdir(folder, 0700), 0);
    snprintf(path, sizeof path, "%s/%d.sock", folder, (int)getpid());
    int file = open(path, O_CREAT | O_WRONLY, 0600);
    assert_true(file >= 0);
    assert_int_equal(write(file, "mine", 4), 4);
    close(file);
    int fd = must_listen(taken);
    assert_string_not_equal(path, taken);
    ect_endpoint_close(fd, taken, ect_endpoint_identity(taken));
    ect_endpoint_clear(path);
    assert_int_equal(stat(path, &info), 0);
    assert_int_equal(info.st_size, 4);
    /* A link to a dead socket and its target also remain. */
    char link[ECT_ENDPOINT_PATH + 32];
    snprintf(link, sizeof link, "%s/link.sock", folder);
    close(must_listen(taken));
    assert_int_equal(symlink(taken, link), 0);
    ect_endpoint_clear(link);
    assert_int_equal(lstat(link, &info), 0);
    assert_int_equal(lstat(taken, &info), 0);
    ect_endpoint_clear(taken);
    assert_int_equal(lstat(taken, &info), -1);
}

/* A link to another folder, a file, a folder writable by others. (A folder of another user requires a second user:
 * tests/integration/control.sh.) */
static void folders_not_to_trust(void **state)
{
    char folder[ECT_ENDPOINT_PATH], path[ECT_ENDPOINT_PATH], message[ECT_ENDPOINT_MESSAGE];
    (void)state;
    runtime_folder("link", folder);
    assert_int_equal(mkdir("elsewhere", 0700), 0);
    assert_int_equal(symlink("../elsewhere", folder), 0);
    assert_int_equal(ect_endpoint_trust(folder), -1);
    assert_int_equal(errno, EPERM);
    assert_int_equal(ect_endpoint_listen(NULL, path, message), -1);
    assert_non_null(strstr(message, "not a folder of your own"));
    runtime_folder("file", folder);
    close(open(folder, O_CREAT | O_WRONLY, 0600));
    assert_int_equal(ect_endpoint_listen(NULL, path, message), -1);
    assert_non_null(strstr(message, "not a folder of your own"));
    runtime_folder("open", folder);
    assert_int_equal(mkdir(folder, 0700), 0);
    assert_int_equal(ect_endpoint_trust(folder), 0);
    assert_int_equal(chmod(folder, 0720), 0);
    assert_int_equal(ect_endpoint_trust(folder), -1);
    assert_int_equal(errno, EPERM);
    assert_int_equal(ect_endpoint_trust("nowhere"), -1);
    assert_int_equal(errno, ENOENT);
    assert_int_equal(setenv("XDG_RUNTIME_DIR", "/nowhere/at/all", 1), 0);
    assert_int_equal(ect_endpoint_listen(NULL, path, message), -1);
    assert_non_null(strstr(message, "XDG_RUNTIME_DIR can name another place"));
}

/* A named twin has one socket, with its name, and the folder contains no other file. */
static void names(void **state)
{
    static const char longest[] = "abcdefghijklmnopqrstuvwxyz12345";
    static const struct {
        const char *name;
        bool fit;
    } rows[] = {{"a", true},
                {"Bench-2_x.y", true},
                {longest, true},
                {"", false},
                {"2nd", false},
                {".hidden", false},
                {"a/b", false},
                {"a b", false},
                {"caf\xc3\xa9", false},
                {"abcdefghijklmnopqrstuvwxyz123456", false}};
    char folder[ECT_ENDPOINT_PATH], path[ECT_ENDPOINT_PATH], other[ECT_ENDPOINT_PATH], message[ECT_ENDPOINT_MESSAGE];
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
        assert_int_equal(ect_endpoint_unfit(rows[i].name) == NULL, rows[i].fit);
    runtime_folder("names", folder);
    int fd = ect_endpoint_listen(longest, path, message);
    assert_true(fd >= 0);
    assert_int_equal(ect_endpoint_find(longest, other), 0);
    assert_string_equal(path, other);
    expect_reachable(fd, path);
    assert_int_equal(count_names(folder), 1);
    assert_int_equal(ect_endpoint_listen(longest, other, message), -1);
    assert_int_equal(errno, EADDRINUSE);
    assert_non_null(strstr(message, "is running"));
    assert_int_equal(count_names(folder), 1);
    close(fd); /* as by a kill */
    fd = ect_endpoint_listen(longest, path, message);
    assert_true(fd >= 0);
    ect_endpoint_close(fd, path, ect_endpoint_identity(path));
    assert_int_equal(count_names(folder), 0);
}

static void without_a_runtime_folder(void **state)
{
    char folder[ECT_ENDPOINT_PATH], want[64];
    (void)state;
    snprintf(want, sizeof want, "/tmp/ectwin-%u", geteuid());
    unsetenv("XDG_RUNTIME_DIR");
    assert_int_equal(ect_endpoint_folder(folder), 0);
    assert_string_equal(folder, want);
    setenv("XDG_RUNTIME_DIR", "", 1);
    assert_int_equal(ect_endpoint_folder(folder), 0);
    assert_string_equal(folder, want);
}

typedef struct seen {
    size_t count, most;
    char path[ECT_ENDPOINT_PATH];
} seen_t;

static bool count_one(void *ctx, const char *path)
{
    seen_t *seen = ctx;
    strcpy(seen->path, path);
    return ++seen->count < seen->most;
}

static void each_socket(void **state)
{
    static const char *const others[] = {".1.sock", "1.socket", ".sock", "1.sock.html"};
    char folder[ECT_ENDPOINT_PATH], path[ECT_ENDPOINT_PATH], other[ECT_ENDPOINT_PATH + 16];
    char message[ECT_ENDPOINT_MESSAGE];
    seen_t seen = {.most = 10};
    (void)state;
    runtime_folder("each", folder);
    ect_endpoint_each(folder, count_one, &seen);
    assert_int_equal(seen.count, 0);
    int fd = ect_endpoint_listen("one", path, message);
    assert_true(fd >= 0);
    for (size_t i = 0; i < sizeof others / sizeof *others; i++) {
        snprintf(other, sizeof other, "%s/%s", folder, others[i]);
        close(open(other, O_CREAT | O_WRONLY, 0600));
    }
    ect_endpoint_each(folder, count_one, &seen);
    assert_int_equal(seen.count, 1);
    assert_string_equal(seen.path, path);
    int second = ect_endpoint_listen("two", path, message);
    assert_true(second >= 0);
    seen = (seen_t){.most = 1};
    ect_endpoint_each(folder, count_one, &seen);
    assert_int_equal(seen.count, 1);
    close(fd);
    close(second);
}

static void full_backlog(void **state)
{
    char folder[ECT_ENDPOINT_PATH], path[ECT_ENDPOINT_PATH], message[ECT_ENDPOINT_MESSAGE];
    int fds[64];
    size_t count = 0;
    uid_t owner = 0;
    (void)state;
    runtime_folder("full", folder);
    int fd = ect_endpoint_listen("full", path, message);
    assert_true(fd >= 0);
    while (count < 64 && (fds[count] = ect_endpoint_connect_now(path, &owner)) >= 0) {
        assert_true((fcntl(fds[count], F_GETFL) & O_NONBLOCK) != 0);
        assert_int_equal(owner, geteuid());
        count++;
    }
    assert_true(count > 0 && count < 64);
    assert_int_equal(errno, EAGAIN);
    while (count > 0)
        close(fds[--count]);
    close(fd);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"The folder has mode 0700 and the socket 0600, regardless of the previous mode and of umask", rights, NULL,
         NULL, NULL},
        {"Attack: the folder is created with mode 0700", never_open_to_others, NULL, NULL, NULL},
        {"Paths with brackets and blanks, and paths longer than a socket's address, are reached", odd_and_long_paths,
         NULL, NULL, NULL},
        {"A path that is too long is refused, not truncated", too_long_a_path, NULL, NULL, NULL},
        {"A name is found if its path has at most 1023 bytes", the_longest_name_that_is_found, NULL, NULL, NULL},
        {"Paths at their limits: the longest folder, the longest address of a socket", paths_at_their_limits, NULL,
         NULL, NULL},
        {"Attack: the name of a live twin is not taken by another", names_that_collide, NULL, NULL, NULL},
        {"A process without a name tries a hundred names", most_names, NULL, NULL, NULL},
        {"With the standard input closed, a socket or a connection has descriptor 0", descriptor_0, NULL, NULL, NULL},
        {"The name of a killed twin is free", dead_socket, NULL, NULL, NULL},
        {"The sockets of killed processes are removed at the next start", dead_sockets_of_others, NULL, NULL, NULL},
        {"A socket of another twin with the same name is not removed", name_of_another, NULL, NULL, NULL},
        {"Attack: a file that is no socket is never removed", other_files_than_sockets, NULL, NULL, NULL},
        {"Attack: a link, a file, and a folder that others may write to are not trusted", folders_not_to_trust, NULL,
         NULL, NULL},
        {"A name belongs to one live twin, and is free after the end of the twin", names, NULL, NULL, NULL},
        {"The sockets of a folder are listed without other files and hidden names", each_socket, NULL, NULL, NULL},
        {"Connecting without waiting returns EAGAIN with a full backlog", full_backlog, NULL, NULL, NULL},
        {"Without XDG_RUNTIME_DIR the folder is /tmp/ectwin-UID", without_a_runtime_folder, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Control endpoint", tests, make_work, remove_work);
}
