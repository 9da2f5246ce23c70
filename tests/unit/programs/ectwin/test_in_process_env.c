/* SPDX-License-Identifier: MIT */
/* The environment of a CMD with twins in its process (programs/ectwin/inprocess.c, net_folder.c): programs that the
 * library fits, variables, the folder of interfaces, and the marks of the buses. */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <elf.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <link.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "inprocess.h"
#include "net_folder.h"

enum { PARTS_AT = sizeof(ElfW(Ehdr)), PATH_AT = 2048, FILE_SIZE = 4096 };

/* --- ectwin, installed in a folder of the test ----------------------------------------------------------------------
 */

static char here[PATH_MAX];                  /* the folder of the test */
static const char *installed = "bin/ectwin"; /* path of the program in that folder */
static const char *const variables[] = {"ECTWIN_INPROCESS",     "ECTWIN_INPROCESS_MARK",
                                        "ECTWIN_INPROCESS_NET", "ECTWIN_INPROCESS_CWD",
                                        "LD_PRELOAD",           "TMPDIR"};

ssize_t __wrap_readlink(const char *path, char *text, size_t room);
ssize_t __real_readlink(const char *path, char *text, size_t room);

ssize_t __wrap_readlink(const char *path, char *text, size_t room)
{
    if (strcmp(path, "/proc/self/exe") != 0)
        return __real_readlink(path, text, room);
    char self[2 * PATH_MAX];
    const int length = snprintf(self, sizeof self, "%s/%s", here, installed);
    assert_true(length > 0 && (size_t)length < room);
    memcpy(text, self, (size_t)length);
    return length;
}

static void write_file(const char *path, const void *content, size_t size, mode_t mode)
{
    const int fd = open(path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, mode);
    assert_true(fd >= 0);
    assert_int_equal(write(fd, content, size), (ssize_t)size);
    close(fd);
}

static void read_file(const char *path, char *content, size_t room)
{
    FILE *file = fopen(path, "rb");
    if (!file)
        fail_msg("%s: %s", path, strerror(errno));
    content[fread(content, 1, room - 1, file)] = '\0';
    fclose(file);
}

/* @return whether the environment was made; see `message` else */
static bool prepare(in_process_t *p, char *message)
{
    static const char *const one[] = {"ecat0"};
    p->interfaces = p->interfaces ? p->interfaces : one;
    p->interface_count = p->interface_count > 0 ? p->interface_count : 1;
    p->command = p->command ? p->command : "/nosuch";
    message[0] = '\0';
    return in_process_prepare(p, message);
}

static bool finish(in_process_t *p)
{
    bool met = false;
    (void)in_process_finish(p, &met);
    return met;
}

static int open_folder(void **state)
{
    static char folder[] = "/tmp/ectwin-env-XXXXXX";
    (void)state;
    if (!mkdtemp(folder) || chdir(folder) != 0 || !getcwd(here, sizeof here))
        return -1;
    for (size_t i = 0; i < sizeof variables / sizeof variables[0]; i++)
        unsetenv(variables[i]);
    mkdir("bin", 0755);
    write_file("bin/libectwin-real.so", "", 0, 0644);
    return 0;
}

static int close_folder(void **state)
{
    (void)state;
    net_folder_remove(here);
    return access(here, F_OK) == 0 ? -1 : 0;
}

/* --- programs that the library fits ----------------------------------------------------------------------------------
 */

typedef struct program {
    unsigned char word_size; /* 0: that of the test */
    ElfW(Half) processor, part_size, part_count;
    unsigned int interpreter; /* number of the part with the linker */
    const char *linker;
    size_t length;   /* of its path, with the end; 0: as it is */
    size_t at;       /* of its path; 0: PATH_AT */
    const char *why; /* NULL: fits */
} program_t;

static void write_program(const char *path, const program_t *p)
{
    static uint8_t content[FILE_SIZE];
    ElfW(Ehdr) header, own;
    const int fd = open("/proc/self/exe", O_RDONLY | O_CLOEXEC);
    assert_int_equal(read(fd, &own, sizeof own), sizeof own);
    close(fd);
    header = own;
    header.e_ident[EI_CLASS] = p->word_size != 0 ? p->word_size : own.e_ident[EI_CLASS];
    header.e_machine = p->processor != 0 ? p->processor : own.e_machine;
    header.e_phentsize = p->part_size != 0 ? p->part_size : sizeof(ElfW(Phdr));
    header.e_phnum = p->part_count;
    header.e_phoff = PARTS_AT;
    memset(content, 0, sizeof content);
    memcpy(content, &header, sizeof header);
    if (p->linker) {
        const size_t at = p->at > 0 ? p->at : PATH_AT;
        const ElfW(Phdr)
            part = {.p_type = PT_INTERP, .p_offset = at, .p_filesz = p->length > 0 ? p->length : strlen(p->linker) + 1};
        memcpy(content + PARTS_AT + p->interpreter * sizeof part, &part, sizeof part);
        memcpy(content + at, p->linker, strlen(p->linker));
    }
    write_file(path, content, sizeof content, 0755);
}

static void programs(void **state)
{
    static const char other[] = "'./program' uses another C library (ld-other.so.1) than ectwin (";
    static const char processor[] = "'./program' is a program of another processor or word size than ectwin";
    static const program_t rows[] = {
        {.part_count = 1, .linker = "/lib/ld-other.so.1", .why = other},
        {.part_count = 3, .interpreter = 2, .linker = "/lib/a/ld-other.so.1", .why = other},
        {.part_count = 1, .linker = "ld-other.so.1", .why = other},
        /* a static program: it may start dynamic ones */
        {.part_count = 0},
        {.part_count = 3},
        /* a part behind the last one */
        {.part_count = 1, .interpreter = 1, .linker = "/lib/ld-other.so.1"},
        {.part_count = 0, .linker = "/lib/ld-other.so.1"},
        /* a path that is cut: by its length, by the end of the file */
        {.part_count = 1, .linker = "/lib/ld-other.so.1xx", .length = 18, .why = other},
        {.part_count = 1, .linker = "/lib/ld-other.so.1", .length = 255, .why = other},
        {.part_count = 1, .linker = "/lib/ld-other.so.1", .length = FILE_SIZE, .why = other},
        {.part_count = 1, .linker = "/lib", .length = 20, .at = FILE_SIZE - 4}, /* no path at all */
        {.part_count = 1, .part_size = 8, .linker = "/lib/ld-other.so.1"},
        {.processor = 0x1234, .why = processor},
        {.word_size = ELFCLASSNONE + 7, .why = processor},
    };
    char message[INPROCESS_MESSAGE];
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        in_process_t p = {.command = "./program"};
        write_program("program", &rows[i]);
        const bool fits = prepare(&p, message);
        if (fits != !rows[i].why ||
            strncmp(message, rows[i].why ? rows[i].why : "", rows[i].why ? strlen(rows[i].why) : 1) != 0)
            fail_msg("row %zu: expected '%s', got %d, '%s'", i, rows[i].why ? rows[i].why : "a program that fits", fits,
                     message);
        if (fits)
            (void)finish(&p);
    }
}

/* A file that is no ELF program, or none at all, is for the kernel to judge. */
static void other_files(void **state)
{
    static const struct {
        const char *command, *content;
        size_t size;
    } rows[] = {{"./script", "#!/bin/sh\n", 10},
                {"./script", "\177ELF\177\177\177\177", 8},
                {"./script", "", 0},
                {"./nosuch", NULL, 0},
                {"nosuch", NULL, 0},
                {"", NULL, 0},
                {".", NULL, 0}};
    char message[INPROCESS_MESSAGE];
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        in_process_t p = {.command = rows[i].command};
        if (rows[i].content)
            write_file("script", rows[i].content, rows[i].size, 0755);
        if (!prepare(&p, message))
            fail_msg("row %zu: expected no message, got '%s'", i, message);
        (void)finish(&p);
    }
}

/* CMD without a slash is the first program of this name in PATH that can be started; an empty element of PATH is the
 * working directory (POSIX.1-2017, XBD 8.3). */
static void folders_of_programs(void **state)
{
    static const program_t own = {.part_count = 0}, foreign = {.processor = 0x1234};
    static const struct {
        const char *path; /* NULL: not set */
        bool fits;
        bool here; /* there is a program in the working directory, which does not fit */
    } rows[] = {
        {"a", true, false},         {"b", false, false},       {"a:b", true, false},        {"b:a", false, false},
        {"nosuch:b", false, false}, {"c:b", false, false},     {"nosuch:a:b", true, false}, {"nosuch", true, false},
        {NULL, true, false},        {"nosuch:c", true, false}, {NULL, true, true},          {"a", true, true},
        {"b:", false, false},       {"::b", false, false},     {"nosuch::b", false, false}, {":a", true, false},
        {"a:", true, true},         {":a", false, true},       {"nosuch:", false, true},    {"nosuch::a", false, true},
        {"", false, true},          {"", true, false}};
    char message[INPROCESS_MESSAGE], *before = strdup(getenv("PATH"));
    (void)state;
    mkdir("a", 0755);
    mkdir("b", 0755);
    mkdir("c", 0755);
    write_program("a/program", &own);
    write_program("b/program", &foreign);
    write_program("c/program", &foreign);
    assert_int_equal(chmod("c/program", 0644), 0); /* cannot be started */
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        in_process_t p = {.command = "program"};
        if (rows[i].here)
            write_program("program", &foreign);
        else
            (void)unlink("program");
        if (rows[i].path)
            setenv("PATH", rows[i].path, 1);
        else
            unsetenv("PATH");
        if (prepare(&p, message) != rows[i].fits)
            fail_msg("row %zu, PATH=%s: expected %d, got '%s'", i, rows[i].path, rows[i].fits, message);
        if (rows[i].fits)
            (void)finish(&p);
    }
    setenv("PATH", before, 1);
    free(before);
}

/* --- the library, and its variables ----------------------------------------------------------------------------------
 */

/* The library is beside the program, or in lib/ectwin beside the program's folder. */
static void places_of_the_library(void **state)
{
    static const struct {
        const char *self, *library;
        bool virtual_time, found;
    } rows[] = {{"p/ectwin", "p/libectwin-real.so", false, true},
                {"p/ectwin", "p/libectwin-virtual.so", true, true},
                {"p/ectwin", "p/libectwin-virtual.so", false, false},
                {"p/ectwin", "p/libectwin-real.so", true, false},
                {"p/ectwin", "lib/ectwin/libectwin-real.so", false, true},
                {"p/ectwin", "p/lib/ectwin/libectwin-real.so", false, false}};
    char message[INPROCESS_MESSAGE], want[2 * PATH_MAX];
    (void)state;
    mkdir("p", 0755);
    mkdir("p/lib", 0755);
    mkdir("p/lib/ectwin", 0755);
    mkdir("lib", 0755);
    mkdir("lib/ectwin", 0755);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        in_process_t p = {.virtual_time = rows[i].virtual_time};
        installed = rows[i].self;
        write_file(rows[i].library, "", 0, 0644);
        unsetenv("LD_PRELOAD");
        if (prepare(&p, message) != rows[i].found)
            fail_msg("row %zu: expected %d, got '%s'", i, rows[i].found, message);
        snprintf(want, sizeof want, "%s/%s", here, rows[i].library);
        const char *preload = getenv("LD_PRELOAD");
        if (rows[i].found &&
            (!preload || strlen(preload) < strlen(want) || strcmp(preload + strlen(preload) - strlen(want), want) != 0))
            fail_msg("row %zu: expected LD_PRELOAD %s, got %s", i, want, preload);
        snprintf(want, sizeof want, "libectwin-%s.so is not where ectwin is installed: install ectwin again",
                 rows[i].virtual_time ? "virtual" : "real");
        assert_string_equal(message, rows[i].found ? "" : want);
        if (rows[i].found)
            (void)finish(&p);
        unlink(rows[i].library);
    }
    installed = "bin/ectwin";
}

static void preloaded_libraries(void **state)
{
    static const struct {
        const char *before, *end;
    } rows[] = {{NULL, "/bin/libectwin-real.so"},
                {"", "/bin/libectwin-real.so"},
                {"x.so:y.so", "/bin/libectwin-real.so:x.so:y.so"}};
    char message[INPROCESS_MESSAGE], want[2 * PATH_MAX];
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        in_process_t p = {0};
        if (rows[i].before)
            setenv("LD_PRELOAD", rows[i].before, 1);
        else
            unsetenv("LD_PRELOAD");
        assert_true(prepare(&p, message));
        snprintf(want, sizeof want, "%s%s", here, rows[i].end);
        const char *got = getenv("LD_PRELOAD");
        if (strlen(got) < strlen(want) || strcmp(got + strlen(got) - strlen(want), want) != 0)
            fail_msg("row %zu: expected '%s', got '%s'", i, want, got);
        (void)finish(&p);
    }
    unsetenv("LD_PRELOAD");
}

static void words(void **state)
{
    static char one[] = "--set", two[] = "data1=1 2", empty[] = "", three[] = "fzm1";
    static const struct {
        char *words[3];
        int count;
        const char *text;
    } rows[] = {{{NULL}, 0, ""},
                {{three}, 1, "fzm1"},
                {{one, two, three},
                 3,
                 "--set\x1F"
                 "data1=1 2\x1F"
                 "fzm1"},
                {{empty, empty, three},
                 3,
                 "\x1F\x1F"
                 "fzm1"}};
    char message[INPROCESS_MESSAGE];
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        in_process_t p = {.words = rows[i].words, .word_count = rows[i].count};
        assert_true(prepare(&p, message));
        assert_string_equal(getenv("ECTWIN_INPROCESS"), rows[i].text);
        assert_string_equal(getenv("ECTWIN_INPROCESS_CWD"), here);
        (void)finish(&p);
    }
}

/* --- the folder of a run
 * ---------------------------------------------------------------------------------------------- */

/* In $TMPDIR, up to 32 characters of it; for each user to read. The mark is that of this user. */
static void folder_of_a_run(void **state)
{
    char message[INPROCESS_MESSAGE], parent[2 * PATH_MAX], path[3 * PATH_MAX];
    (void)state;
    for (size_t length = 31; length <= 34; length++) {
        in_process_t p = {0};
        struct stat its;
        snprintf(parent, sizeof parent, "%s/%0*d", here, (int)(length - strlen(here) - 1), 0);
        assert_int_equal(strlen(parent), length);
        assert_int_equal(mkdir(parent, 0755), 0);
        setenv("TMPDIR", parent, 1);
        assert_true(prepare(&p, message));
        const bool there = length <= sizeof p.folder / 2;
        snprintf(path, sizeof path, "%s/ectwin-", there ? parent : "/tmp");
        if (strncmp(p.folder, path, strlen(path)) != 0)
            fail_msg("%zu characters: expected a folder %s…, got %s", length, path, p.folder);
        assert_string_equal(getenv("ECTWIN_INPROCESS_NET"), p.folder);
        assert_int_equal(stat(p.folder, &its), 0);
        assert_int_equal(its.st_mode & 0777, 0755);
        snprintf(path, sizeof path, "%s/mark", p.folder);
        assert_string_equal(getenv("ECTWIN_INPROCESS_MARK"), path);
        assert_int_equal(stat(path, &its), 0);
        assert_int_equal(its.st_mode & 0777, 0600);
        assert_int_equal(its.st_size, 0);
        (void)finish(&p);
        assert_int_equal(access(p.folder, F_OK), -1);
        assert_int_equal(rmdir(parent), 0);
    }
    unsetenv("TMPDIR");
}

static void folder_that_cannot_be_made(void **state)
{
    char message[INPROCESS_MESSAGE];
    in_process_t p = {0};
    (void)state;
    setenv("TMPDIR", "/nosuch", 1);
    assert_false(prepare(&p, message));
    assert_string_equal(message, "the environment of CMD cannot be made: No such file or directory");
    unsetenv("TMPDIR");
}

/* The trees `up` and `down` have the files of each interface of the bus, and links to those of the machine. */
static void interfaces(void **state)
{
    static const char *const names[] = {"ecat0", "lo"};
    static const struct {
        const char *file, *up, *down;
    } rows[] = {
        {"ecat0/address", "02:00:00:00:00:01\n", NULL},
        {"ecat0/addr_len", "6\n", NULL},
        {"ecat0/broadcast", "ff:ff:ff:ff:ff:ff\n", NULL},
        {"ecat0/carrier", "1\n", "0\n"},
        {"ecat0/duplex", "full\n", NULL},
        {"ecat0/flags", "0x1103\n", "0x1102\n"},
        {"ecat0/ifindex", "1001\n", NULL},
        {"ecat0/iflink", "1001\n", NULL},
        {"ecat0/mtu", "1500\n", NULL},
        {"ecat0/operstate", "up\n", "down\n"},
        {"ecat0/speed", "100\n", NULL},
        {"ecat0/type", "1\n", NULL},
        {"ecat0/uevent", "INTERFACE=ecat0\nIFINDEX=1001\n", NULL},
        {"lo/ifindex", "1002\n", NULL}, /* in place of the machine's own */
        {"lo/uevent", "INTERFACE=lo\nIFINDEX=1002\n", NULL},
    };
    in_process_t p = {.interfaces = names, .interface_count = 2};
    char message[INPROCESS_MESSAGE], path[PATH_MAX], content[256];
    (void)state;
    assert_true(prepare(&p, message));
    for (size_t i = 0; i < 2 * sizeof rows / sizeof rows[0]; i++) {
        const bool up = i % 2 == 0;
        const char *want = up || !rows[i / 2].down ? rows[i / 2].up : rows[i / 2].down;
        snprintf(path, sizeof path, "%s/%s/%s", p.folder, up ? "up" : "down", rows[i / 2].file);
        read_file(path, content, sizeof content);
        if (strcmp(content, want) != 0)
            fail_msg("%s: expected %s, got %s", path, want, content);
    }
    (void)finish(&p);
}

static void links_to_interfaces_of_the_machine(void **state)
{
    in_process_t p = {0};
    char message[INPROCESS_MESSAGE], path[PATH_MAX], target[PATH_MAX] = "";
    (void)state;
    assert_true(prepare(&p, message));
    snprintf(path, sizeof path, "%s/down/lo", p.folder);
    assert_int_equal(__real_readlink(path, target, sizeof target - 1), strlen("/sys/class/net/lo"));
    assert_string_equal(target, "/sys/class/net/lo");
    (void)finish(&p);
}

/* --- marks
 * ------------------------------------------------------------------------------------------------------------ */

/* Each bus adds '+' when an interface is opened, and '.' when it ends with its expectations met. */
static void marks(void **state)
{
    static const struct {
        const char *first; /* then `more`, repeated */
        const char *more;
        size_t times;
        bool used, met;
    } rows[] = {
        {"", "", 0, false, false},    {"+", "", 0, true, false},      {"+.", "", 0, true, true},
        {"++.", "", 0, true, false},  {"++..", "", 0, true, true},    {"+.+.", "", 0, true, true},
        {"x", "", 0, false, false},   {"+x.", "", 0, true, true},     {"", "+.", 2048, true, true},
        {"", "+.", 2049, true, true}, {"+", "+.", 3000, true, false}, {"+.+", "+.", 2047, true, false},
    };
    char message[INPROCESS_MESSAGE], path[PATH_MAX];
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        in_process_t p = {0};
        bool met = false;
        assert_true(prepare(&p, message));
        snprintf(path, sizeof path, "%s/mark", p.folder);
        FILE *file = fopen(path, "w");
        for (size_t n = 0; n < rows[i].times; n++)
            fputs(rows[i].more, file);
        fputs(rows[i].first, file);
        fclose(file);
        const bool used = in_process_finish(&p, &met);
        if (used != rows[i].used || met != rows[i].met)
            fail_msg("row %zu: expected used %d, met %d, got %d, %d", i, rows[i].used, rows[i].met, used, met);
    }
}

/* A run without expectations has met all of them. */
static void a_run_without_expectations(void **state)
{
    char message[INPROCESS_MESSAGE];
    in_process_t p = {0};
    bool met = true;
    (void)state;
    assert_true(prepare(&p, message));
    assert_false(in_process_finish(&p, &met));
    assert_true(met);
}

#define TEST(title, function) {title, function, NULL, NULL, NULL}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        TEST("a program of another processor, word size or C library does not fit; a static one does", programs),
        TEST("a file that is no program is left to the kernel", other_files),
        TEST("a name without a slash is searched in PATH", folders_of_programs),
        TEST("the library is beside the program or in lib/ectwin, by the clock", places_of_the_library),
        TEST("LD_PRELOAD has the library before others", preloaded_libraries),
        TEST("ECTWIN_INPROCESS has the words of the bus", words),
        TEST("the folder of a run is in TMPDIR, or in /tmp if that is long", folder_of_a_run),
        TEST("a folder that cannot be made is an error", folder_that_cannot_be_made),
        TEST("each interface of the bus has the files of /sys/class/net", interfaces),
        TEST("other interfaces are links to those of the machine", links_to_interfaces_of_the_machine),
        TEST("marks: buses that were opened, and that ended with their expectations met", marks),
        TEST("without expectations, all are met", a_run_without_expectations),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("The environment of --in-process", tests, open_folder, close_folder);
}
