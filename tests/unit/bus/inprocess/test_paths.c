/* SPDX-License-Identifier: MIT */
/* Paths below /sys/class/net, mapped to the folder of `ectwin with`. */
#define _GNU_SOURCE
#include <dirent.h>
#include <fcntl.h>
#include <limits.h>
#include <sys/stat.h>
#include <unistd.h>

#include "bus/inprocess/bus.h"
#include "bus/inprocess/ports.h"
#include "fakes.h"

OURS(open);
OURS(open64);
OURS(openat);
OURS(openat64);
OURS(fopen);
OURS(fopen64);
OURS(opendir);
OURS(scandir);
OURS(scandir64);
OURS(stat);
OURS(stat64);
OURS(lstat);
OURS(lstat64);
OURS(fstatat);
OURS(fstatat64);
OURS(statx);
OURS(access);
OURS(faccessat);
OURS(readlink);
OURS(readlinkat);
OURS(realpath);
int ours___open_2(const char *path, int flags);
int ours___open64_2(const char *path, int flags);
int ours___openat_2(int folder, const char *path, int flags);
int ours___openat64_2(int folder, const char *path, int flags);
ssize_t ours___readlink_chk(const char *path, char *target, size_t size, size_t room);
ssize_t ours___readlinkat_chk(int folder, const char *path, char *target, size_t size, size_t room);
char *ours___realpath_chk(const char *path, char *resolved, size_t room);

static char path_given[PATH_MAX + 1]; /* to the C library; "": NULL */
static const char *folder;            /* $ECTWIN_INPROCESS_NET */

/* --- fakes: the first path is kept, all other arguments are words
 * ------------------------------------------------------- */

static void keep(const char *path)
{
    snprintf(path_given, sizeof path_given, "%s", path ? path : "");
}

#define OF_PATH_0(name)                                                                                                \
    static long fake_##name(const char *path)                                                                          \
    {                                                                                                                  \
        keep(path);                                                                                                    \
        return CALLED(name);                                                                                           \
    }
#define OF_PATH_1(name)                                                                                                \
    static long fake_##name(const char *path, long b)                                                                  \
    {                                                                                                                  \
        keep(path);                                                                                                    \
        return CALLED(name, b);                                                                                        \
    }
#define OF_PATH_2(name)                                                                                                \
    static long fake_##name(const char *path, long b, long c)                                                          \
    {                                                                                                                  \
        keep(path);                                                                                                    \
        return CALLED(name, b, c);                                                                                     \
    }
#define OF_PATH_3(name)                                                                                                \
    static long fake_##name(const char *path, long b, long c, long d)                                                  \
    {                                                                                                                  \
        keep(path);                                                                                                    \
        return CALLED(name, b, c, d);                                                                                  \
    }
#define AT_PATH_1(name)                                                                                                \
    static long fake_##name(long a, const char *path, long c)                                                          \
    {                                                                                                                  \
        keep(path);                                                                                                    \
        return CALLED(name, a, c);                                                                                     \
    }
#define AT_PATH_2(name)                                                                                                \
    static long fake_##name(long a, const char *path, long c, long d)                                                  \
    {                                                                                                                  \
        keep(path);                                                                                                    \
        return CALLED(name, a, c, d);                                                                                  \
    }
#define AT_PATH_3(name)                                                                                                \
    static long fake_##name(long a, const char *path, long c, long d, long e)                                          \
    {                                                                                                                  \
        keep(path);                                                                                                    \
        return CALLED(name, a, c, d, e);                                                                               \
    }

OF_PATH_0(opendir)
OF_PATH_1(fopen)
OF_PATH_1(fopen64)
OF_PATH_1(stat)
OF_PATH_1(stat64)
OF_PATH_1(lstat)
OF_PATH_1(lstat64)
OF_PATH_1(access)
OF_PATH_1(realpath)
OF_PATH_1(__open_2)
OF_PATH_1(__open64_2)
OF_PATH_2(open)
OF_PATH_2(open64)
OF_PATH_2(readlink)
OF_PATH_2(__realpath_chk)
OF_PATH_3(scandir)
OF_PATH_3(scandir64)
OF_PATH_3(__readlink_chk)
AT_PATH_1(__openat_2)
AT_PATH_1(__openat64_2)
AT_PATH_2(openat)
AT_PATH_2(openat64)
AT_PATH_2(fstatat)
AT_PATH_2(fstatat64)
AT_PATH_2(faccessat)
AT_PATH_2(readlinkat)
AT_PATH_3(statx)
AT_PATH_3(__readlinkat_chk)

FAKES(FAKE(opendir), FAKE(fopen), FAKE(fopen64), FAKE(stat), FAKE(stat64), FAKE(lstat), FAKE(lstat64), FAKE(access),
      FAKE(realpath), FAKE(__open_2), FAKE(__open64_2), FAKE(open), FAKE(open64), FAKE(readlink), FAKE(__realpath_chk),
      FAKE(scandir), FAKE(scandir64), FAKE(__readlink_chk), FAKE(__openat_2), FAKE(__openat64_2), FAKE(openat),
      FAKE(openat64), FAKE(fstatat), FAKE(fstatat64), FAKE(faccessat), FAKE(readlinkat), FAKE(statx),
      FAKE(__readlinkat_chk))

char *fake_getenv(const char *name)
{
    assert_string_equal(name, "ECTWIN_INPROCESS_NET");
    return (char *)(uintptr_t)folder;
}

/* Two interfaces: end 0 is up, end 1 is down. The longest name has 15 letters. */
int ect_bus_end_of_name(const char *name)
{
    return strcmp(name, "ect0") == 0 ? 0 : strcmp(name, "abcdefghijklmno") == 0 ? 1 : -1;
}

bool ect_port_is_up(unsigned int end)
{
    return end == 0;
}

static int begin(void **state)
{
    folder = "/f";
    path_given[0] = 0;
    return begin_fakes(state);
}

/* --- tests
 * -------------------------------------------------------------------------------------------------------------- */

static void maps_paths(void **state)
{
    static const struct {
        const char *path, *given;
    } rows[] = {
        {"/sys/class/net", "/f/up/"},
        {"/sys/class/net/", "/f/up/"},
        {"/sys/class/net///", "/f/up/"},
        {"/sys/class/net/ect0", "/f/up/ect0"},
        {"/sys/class/net//ect0/flags", "/f/up/ect0/flags"},
        {"/sys/class/net/abcdefghijklmno/carrier", "/f/down/abcdefghijklmno/carrier"},
        {"/sys/class/net/abcdefghijklmnop/carrier", "/sys/class/net/abcdefghijklmnop/carrier"},
        {"/sys/class/net/lo/flags", "/sys/class/net/lo/flags"},
        {"/sys/class/network/ect0", "/sys/class/network/ect0"},
        {"/sys/class/ne", "/sys/class/ne"},
        {"xsys/class/net/ect0", "xsys/class/net/ect0"},
        {"/tmp/ect0", "/tmp/ect0"},
        {"", ""},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        plan("access", -1, EPERM);
        assert_int_equal(ours_access(rows[i].path, 8), -1);
        assert_string_equal(path_given, rows[i].given);
        EXPECT_CALLS("access", "access(8) ");
    }
}

static void leaves_other_paths(void **state)
{
    (void)state;
    (void)ours___open_2(NULL, 4);
    assert_string_equal(path_given, "");
    ect_inside = 1;
    (void)ours_access("/sys/class/net/ect0", 8);
    assert_string_equal(path_given, "/sys/class/net/ect0");
    ect_inside = 0;
    folder = NULL;
    (void)ours_access("/sys/class/net/ect0", 8);
    assert_string_equal(path_given, "/sys/class/net/ect0");
    forget_calls();
}

static void leaves_bad_paths(void **state)
{
    static const char path[] = "/sys/class/net/ect0";
    static char too_long[PATH_MAX + 100] = "/sys/class/net/ect0/";
    (void)state;
    for (size_t i = 0; i < sizeof path; i++) { /* the path ends with the memory */
        bad_memory.unreadable = &path[i];
        (void)ours_access(path, 8);
        assert_string_equal(path_given, path);
    }
    memset(too_long + strlen(too_long), 'x', sizeof too_long - 1 - strlen(too_long));
    (void)ours_access(too_long, 8);
    assert_memory_equal(path_given, "/sys/class/net/ect0/xxx", 23);
    forget_calls();
}

static void cuts_a_path_that_is_too_long(void **state)
{
    static char path[PATH_MAX];
    static const char begin_of[] = "/sys/class/net/ect0/";
    (void)state;
    folder = "/a/longer/name/than/that/of/the/system";
    memset(path, 'x', sizeof path - 1);
    memcpy(path, begin_of, sizeof begin_of - 1);
    (void)ours_access(path, 8);
    assert_int_equal(strlen(path_given), PATH_MAX - 1);
    assert_memory_equal(path_given, "/a/longer/name/than/that/of/the/system/up/ect0/xxx", 50);
    forget_calls();
}

#define PATH "/sys/class/net/ect0"

/* Each call maps its path and returns the result of the C library. */
#define EXPECT_MAPPED(name, want, call)                                                                                \
    do {                                                                                                               \
        path_given[0] = 0;                                                                                             \
        plan(#name, 42, 0);                                                                                            \
        assert_int_equal((long)(call), 42);                                                                            \
        assert_string_equal(path_given, "/f/up/ect0");                                                                 \
        EXPECT_CALLS(#name, #name want " ");                                                                           \
    } while (0)

static void maps_the_paths_of_files(void **state)
{
    (void)state;
    EXPECT_MAPPED(open, "(2,0)", ours_open(PATH, O_RDWR));
    EXPECT_MAPPED(open64, "(2,0)", ours_open64(PATH, O_RDWR));
    EXPECT_MAPPED(openat, "(3,2,0)", ours_openat(3, PATH, O_RDWR));
    EXPECT_MAPPED(openat64, "(3,2,0)", ours_openat64(3, PATH, O_RDWR));
    EXPECT_MAPPED(open, "(66,7)", ours_open(PATH, O_RDWR | O_CREAT, 7));
    EXPECT_MAPPED(open64, "(66,7)", ours_open64(PATH, O_RDWR | O_CREAT, 7));
    EXPECT_MAPPED(openat, "(3,66,7)", ours_openat(3, PATH, O_RDWR | O_CREAT, 7));
    EXPECT_MAPPED(openat64, "(3,66,7)", ours_openat64(3, PATH, O_RDWR | O_CREAT, 7));
    EXPECT_MAPPED(__open_2, "(4)", ours___open_2(PATH, 4));
    EXPECT_MAPPED(__open64_2, "(4)", ours___open64_2(PATH, 4));
    EXPECT_MAPPED(__openat_2, "(3,4)", ours___openat_2(3, PATH, 4));
    EXPECT_MAPPED(__openat64_2, "(3,4)", ours___openat64_2(3, PATH, 4));
    EXPECT_MAPPED(fopen, "(9)", ours_fopen(PATH, AT(9)));
    EXPECT_MAPPED(fopen64, "(9)", ours_fopen64(PATH, AT(9)));
    EXPECT_MAPPED(opendir, "()", ours_opendir(PATH));
    EXPECT_MAPPED(scandir, "(9,0,0)", ours_scandir(PATH, AT(9), NULL, NULL));
    EXPECT_MAPPED(scandir64, "(9,0,0)", ours_scandir64(PATH, AT(9), NULL, NULL));
}

static void maps_the_paths_of_attributes(void **state)
{
    (void)state;
    EXPECT_MAPPED(stat, "(9)", ours_stat(PATH, AT(9)));
    EXPECT_MAPPED(stat64, "(9)", ours_stat64(PATH, AT(9)));
    EXPECT_MAPPED(lstat, "(9)", ours_lstat(PATH, AT(9)));
    EXPECT_MAPPED(lstat64, "(9)", ours_lstat64(PATH, AT(9)));
    EXPECT_MAPPED(fstatat, "(3,9,5)", ours_fstatat(3, PATH, AT(9), 5));
    EXPECT_MAPPED(fstatat64, "(3,9,5)", ours_fstatat64(3, PATH, AT(9), 5));
    EXPECT_MAPPED(statx, "(3,4,5,9)", ours_statx(3, PATH, 4, 5, AT(9)));
    EXPECT_MAPPED(access, "(4)", ours_access(PATH, 4));
    EXPECT_MAPPED(faccessat, "(3,4,5)", ours_faccessat(3, PATH, 4, 5));
    EXPECT_MAPPED(readlink, "(9,5)", ours_readlink(PATH, AT(9), 5));
    EXPECT_MAPPED(readlinkat, "(3,9,5)", ours_readlinkat(3, PATH, AT(9), 5));
    EXPECT_MAPPED(realpath, "(9)", ours_realpath(PATH, AT(9)));
    EXPECT_MAPPED(__readlink_chk, "(9,5,6)", ours___readlink_chk(PATH, AT(9), 5, 6));
    EXPECT_MAPPED(__readlinkat_chk, "(3,9,5,6)", ours___readlinkat_chk(3, PATH, AT(9), 5, 6));
    EXPECT_MAPPED(__realpath_chk, "(9,6)", ours___realpath_chk(PATH, AT(9), 6));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"A path of an interface of the bus is one of its folder, up or down", maps_paths, begin, NULL, NULL},
        {"Other paths, and those of the library, are unchanged", leaves_other_paths, begin, NULL, NULL},
        {"A path at a bad address, or longer than any path, is the C library's", leaves_bad_paths, begin, NULL, NULL},
        {"A path that is too long is cut", cuts_a_path_that_is_too_long, begin, NULL, NULL},
        {"Files and folders are opened in that folder", maps_the_paths_of_files, begin, NULL, NULL},
        {"Attributes are read in that folder", maps_the_paths_of_attributes, begin, NULL, NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
