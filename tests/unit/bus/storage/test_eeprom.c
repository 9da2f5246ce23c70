/* SPDX-License-Identifier: MIT */
/* The EEPROM of a twin in a file, which keeps the writes of a master (bus/storage/eeprom.h). */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "bus/storage/eeprom.h"
#include "support/testdev.h"
#include "support/wire.h"
#include "wire/crc.h"

enum { SIZE = 64 };

static char folder[] = "/tmp/ectwin-eeprom-XXXXXX";
static char path[64];
static char message[ECT_EEPROM_MESSAGE];

/* A step of another process between the open and the lock of the file; NULL: none. */
static void (*meanwhile)(void);

int __real_flock(int fd, int operation);
int __wrap_flock(int fd, int operation);

int __wrap_flock(int fd, int operation)
{
    void (*step)(void) = meanwhile;
    meanwhile = NULL;
    if (step)
        step();
    errno = 0;
    return __real_flock(fd, operation);
}

static int make_folder(void **state)
{
    (void)state;
    if (!mkdtemp(folder))
        return -1;
    snprintf(path, sizeof path, "%s/eeprom", folder);
    return 0;
}

static int remove_folder(void **state)
{
    (void)state;
    return rmdir(folder);
}

static int remove_file(void **state)
{
    (void)state;
    (void)unlink(path);
    return 0;
}

/* Makes factory content, with a correct check value. */
static void factory(uint8_t image[SIZE], uint8_t seed)
{
    for (unsigned int i = 0; i < SIZE; i++)
        image[i] = (uint8_t)(i * seed);
    image[15] = 0;
    image[ECT_SII_CHECKED_BYTES] = ect_crc_sii(image);
}

static ect_eeprom_t *must_open(const uint8_t image[SIZE])
{
    ect_eeprom_t *eeprom = ect_eeprom_open(path, image, SIZE, message);
    if (!eeprom)
        fail_msg("%s", message);
    return eeprom;
}

static void survives(void **state)
{
    uint8_t made[SIZE], image[SIZE];
    (void)state;
    factory(made, 3);
    ect_eeprom_t *eeprom = must_open(made);
    assert_memory_equal(ect_eeprom_image(eeprom), made, SIZE);
    memcpy(image, made, SIZE);
    ect_eeprom_write(eeprom, image, SIZE); /* no change */
    image[8] = 0x34;
    image[SIZE - 1] = 0x77;
    ect_eeprom_write(eeprom, image, SIZE);
    assert_memory_equal(ect_eeprom_image(eeprom), image, SIZE);
    image[40] = 0x55;
    ect_eeprom_write(eeprom, image, SIZE);
    ect_eeprom_close(eeprom);
    eeprom = must_open(made);
    assert_memory_equal(ect_eeprom_image(eeprom), image, SIZE);
    ect_eeprom_close(eeprom);
}

/* Marks in the file show the range that a write changes. */
static void only_the_changed_range_is_written(void **state)
{
    enum { HEADER = 16 };
    static const struct {
        const char *title;
        int first, last; /* changed bytes; -1: none */
    } cases[] = {{"nothing", -1, -1},
                 {"the first byte", 0, 0},
                 {"the last byte", SIZE - 1, SIZE - 1},
                 {"one byte", 40, 40},
                 {"two bytes and those between", 16, 20},
                 {"both ends", 0, SIZE - 1}};
    uint8_t made[SIZE], image[SIZE], marks[SIZE], got[SIZE];
    (void)state;
    factory(made, 3);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        ect_eeprom_t *eeprom = must_open(made);
        int fd = open(path, O_RDWR);
        memset(marks, 0xA5, sizeof marks);
        memcpy(image, made, SIZE);
        assert_int_equal(pwrite(fd, marks, SIZE, HEADER + SIZE), SIZE);
        if (cases[i].first >= 0) {
            image[cases[i].first] ^= 0xFF;
            image[cases[i].last] = (uint8_t)~made[cases[i].last];
        }
        ect_eeprom_write(eeprom, image, SIZE);
        assert_int_equal(pread(fd, got, SIZE, HEADER + SIZE), SIZE);
        for (int at = 0; at < SIZE; at++) {
            const bool written = cases[i].first >= 0 && at >= cases[i].first && at <= cases[i].last;
            if (got[at] != (written ? image[at] : 0xA5))
                fail_msg("%s: byte %d of the file is 0x%02X", cases[i].title, at, got[at]);
        }
        assert_memory_equal(ect_eeprom_image(eeprom), image, SIZE);
        close(fd);
        ect_eeprom_close(eeprom);
        assert_int_equal(unlink(path), 0);
    }
}

/* A changed word of the factory content is newer than the master's; the master's other words are kept. */
static void newer_factory(void **state)
{
    uint8_t made[SIZE], image[SIZE];
    (void)state;
    factory(made, 3);
    ect_eeprom_t *eeprom = must_open(made);
    memcpy(image, made, SIZE);
    image[8] = 0x01;  /* written by the master: alias */
    image[20] = 0x02; /* written by the master; changed in the next factory content */
    image[ECT_SII_CHECKED_BYTES] = ect_crc_sii(image);
    ect_eeprom_write(eeprom, image, SIZE);
    ect_eeprom_close(eeprom);
    made[2] = 0xA0;
    made[20] = 0xA1;
    made[30] = 0xA2;
    made[33] = 0xA3; /* one changed byte makes the word new */
    made[SIZE - 1] = 0xA4;
    made[ECT_SII_CHECKED_BYTES] = ect_crc_sii(made);
    for (unsigned int time = 0; time < 2; time++) {
        eeprom = must_open(made);
        const uint8_t *now = ect_eeprom_image(eeprom);
        assert_int_equal(now[8], 0x01);
        assert_int_equal(now[2], 0xA0);
        assert_int_equal(now[20], 0xA1);
        assert_int_equal(now[30], 0xA2);
        assert_int_equal(now[33], 0xA3);
        assert_int_equal(now[SIZE - 1], 0xA4);
        assert_int_equal(now[ECT_SII_CHECKED_BYTES], ect_crc_sii(now));
        ect_eeprom_close(eeprom);
    }
}

static void bad_checksum_stays_bad(void **state)
{
    uint8_t made[SIZE], image[SIZE];
    (void)state;
    factory(made, 3);
    ect_eeprom_t *eeprom = must_open(made);
    memcpy(image, made, SIZE);
    image[ECT_SII_CHECKED_BYTES] ^= 0xFF;
    ect_eeprom_write(eeprom, image, SIZE);
    ect_eeprom_close(eeprom);
    eeprom = must_open(made);
    assert_memory_equal(ect_eeprom_image(eeprom), image, SIZE);
    ect_eeprom_close(eeprom);
}

/* A full disk, or a kill, during the creation or the replacement of the file. */
static void cut_off_first_start(void **state)
{
    uint8_t made[SIZE], image[SIZE];
    char other[80];
    struct rlimit before, small;
    (void)state;
    factory(made, 3);
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    small = (struct rlimit){.rlim_cur = 30, .rlim_max = before.rlim_max};
    signal(SIGXFSZ, SIG_IGN);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
    ect_eeprom_t *eeprom = ect_eeprom_open(path, made, SIZE, message);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
    assert_null(eeprom);
    eeprom = must_open(made);
    memcpy(image, made, SIZE);
    image[8] = 1;
    ect_eeprom_write(eeprom, image, SIZE);
    ect_eeprom_close(eeprom);
    made[2] = 0xA0; /* changed factory content, and a full disk */
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
    eeprom = ect_eeprom_open(path, made, SIZE, message);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
    assert_null(eeprom);
    snprintf(other, sizeof other, "%s.new", path);
    int fd = open(other, O_WRONLY | O_CREAT, 0600); /* as by a kill */
    assert_int_equal(write(fd, "half", 4), 4);
    close(fd);
    eeprom = must_open(made);
    assert_int_equal(ect_eeprom_image(eeprom)[8], 1);
    assert_int_equal(ect_eeprom_image(eeprom)[2], 0xA0);
    ect_eeprom_close(eeprom);
    assert_int_equal(access(other, F_OK), -1);
}

static void assert_refused(const char *what, const uint8_t made[SIZE], const char *why)
{
    ect_eeprom_t *eeprom = ect_eeprom_open(path, made, SIZE, message);
    if (eeprom || !strstr(message, why))
        fail_msg("%s: expected a refusal with '%s', got '%s'", what, why, eeprom ? "success" : message);
}

static void refused(void **state)
{
    enum { ROOM = 16 + 2 * SIZE };
    uint8_t made[SIZE], content[ROOM + 1] = "ECTWSII1";
    char aim[80];
    struct stat info;
    (void)state;
    factory(made, 3);
    content[8] = SIZE;
    static const struct {
        const char *what;
        size_t length, change; /* changed byte; SIZE_MAX: none */
    } files[] = {
        {"too short", ROOM - 1, SIZE_MAX}, {"too long", ROOM + 1, SIZE_MAX}, {"another kind", ROOM, 3},
        {"another size", ROOM, 8},         {"a byte", 1, SIZE_MAX},
    };
    for (size_t i = 0; i < sizeof files / sizeof files[0]; i++) {
        uint8_t written[ROOM + 1];
        memcpy(written, content, sizeof written);
        if (files[i].change != SIZE_MAX)
            written[files[i].change] ^= 1;
        int fd = open(path, O_CREAT | O_TRUNC | O_WRONLY, 0600);
        assert_int_equal(write(fd, written, files[i].length), files[i].length);
        close(fd);
        assert_refused(files[i].what, made, "no EEPROM content");
        assert_int_equal(stat(path, &info), 0);
        assert_int_equal(info.st_size, files[i].length);
        assert_int_equal(unlink(path), 0);
    }
    snprintf(aim, sizeof aim, "%s/aim", folder);
    assert_int_equal(symlink(aim, path), 0);
    assert_refused("a symbolic link", made, "symbolic link");
    assert_int_equal(access(aim, F_OK), -1);
    assert_int_equal(unlink(path), 0);
    assert_int_equal(mkfifo(path, 0600), 0);
    assert_refused("a pipe", made, "no EEPROM content");
    assert_int_equal(unlink(path), 0);
    ect_eeprom_t *eeprom = must_open(made);
    assert_refused("in use", made, "another twin");
    ect_eeprom_close(eeprom);
}

/* Another user of a shared folder may create a link with the name of the temporary file. */
static void link_as_temporary_file(void **state)
{
    uint8_t made[SIZE];
    char aim[80], other[90], content[8] = "";
    (void)state;
    factory(made, 3);
    snprintf(aim, sizeof aim, "%s/aim", folder);
    snprintf(other, sizeof other, "%s.new", path);
    FILE *file = fopen(aim, "w");
    assert_non_null(file);
    assert_true(fputs("theirs", file) >= 0);
    assert_int_equal(fclose(file), 0);
    assert_int_equal(symlink(aim, other), 0);
    assert_refused("a link as temporary file", made, "symbolic link");
    file = fopen(aim, "r");
    assert_non_null(file);
    assert_non_null(fgets(content, sizeof content, file));
    assert_int_equal(fclose(file), 0);
    assert_string_equal(content, "theirs");
    assert_int_equal(unlink(other), 0);
    assert_int_equal(unlink(aim), 0);
}

static void replace(void)
{
    char other[80];
    snprintf(other, sizeof other, "%s.other", path);
    int fd = open(other, O_CREAT | O_WRONLY, 0600);
    close(fd);
    assert_int_equal(rename(other, path), 0);
}

static void hide(void)
{
    assert_int_equal(unlink(path), 0);
}

/* A file that another twin replaces before the lock belongs to that twin. */
static void replaced_before_the_lock(void **state)
{
    static const struct {
        const char *title, *message;
        void (*step)(void);
    } cases[] = {{"replaced", "another twin uses it", replace}, {"removed", "No such file or directory", hide}};
    uint8_t made[SIZE];
    struct stat info;
    (void)state;
    factory(made, 3);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        ect_eeprom_close(must_open(made));
        meanwhile = cases[i].step;
        assert_refused(cases[i].title, made, cases[i].message);
        if (stat(path, &info) == 0)
            assert_int_equal(info.st_size, 0); /* the other twin's file is unchanged */
        (void)unlink(path);
    }
}

/* The master writes by the registers of the chip; chain and process then have a power cycle. */
static void written_by_a_master(void **state)
{
    (void)state;
    uint8_t *made = calloc(1, testdev.sii_size);
    assert_non_null(made);
    for (unsigned int round = 0; round < 2; round++) {
        ect_twin_config_t twin = ect_twin_default(&testdev, NULL);
        wire_t w;
        ect_eeprom_t *eeprom = ect_eeprom_open(path, made, testdev.sii_size, message);
        assert_non_null(eeprom);
        if (round > 0)
            twin.sii = ect_eeprom_image(eeprom);
        twin.sii_written = ect_eeprom_write;
        twin.sii_ctx = eeprom;
        wire_open_twins(&w, &twin, 1);
        if (round == 0) {
            const uint8_t command[] = {0x01, 0x02, 0x20, 0x00, 0x00, 0x00, 0xCD, 0xAB}; /* write word 0x20 */
            assert_int_equal(wire_write(&w, 0, 0x0502, command, sizeof command), 1);
            wire_advance(&w, 20 * MS);
        }
        assert_int_equal(ect_load_le16(ect_eeprom_image(eeprom) + 0x40), 0xABCD);
        ect_chain_power_cycle(w.chain, w.now_ns);
        wire_assign_stations(&w);
        const uint8_t read[] = {0x00, 0x01, 0x20, 0x00, 0x00, 0x00};
        assert_int_equal(wire_write(&w, 0, 0x0502, read, sizeof read), 1);
        wire_advance(&w, 20 * MS);
        assert_int_equal(wire_read16(&w, 0, 0x0508), 0xABCD);
        wire_close(&w);
        ect_eeprom_close(eeprom);
    }
    free(made);
}

/* A daemon's standard input may be closed: the file then gets descriptor 0. */
static void descriptor_0(void **state)
{
    uint8_t made[SIZE];
    (void)state;
    factory(made, 3);
    const int input = dup(STDIN_FILENO);
    (void)close(STDIN_FILENO);
    ect_eeprom_close(must_open(made));
    ect_eeprom_t *first = must_open(made);
    const bool used = fcntl(STDIN_FILENO, F_GETFD) >= 0;
    ect_eeprom_close(first);
    const bool left = fcntl(STDIN_FILENO, F_GETFD) >= 0;
    if (input >= 0) {
        (void)dup2(input, STDIN_FILENO);
        close(input);
    }
    assert_true(used);
    assert_false(left);
}

/* Even with umask 0 no other user can read or change the file. */
static void own_file(void **state)
{
    uint8_t image[SIZE];
    struct stat its;
    (void)state;
    factory(image, 3);
    mode_t before = umask(0);
    ect_eeprom_close(must_open(image));
    (void)umask(before);
    assert_int_equal(stat(path, &its), 0);
    assert_int_equal(its.st_mode & 07777, 0600);
}

int main(int argc, char **argv)
{
#define EEPROM_TEST(title, function) {title, function, NULL, remove_file, NULL}
    const struct CMUnitTest tests[] = {
        EEPROM_TEST("EEPROM file: written words are kept", survives),
        EEPROM_TEST("EEPROM file: only the changed range is written", only_the_changed_range_is_written),
        EEPROM_TEST(
            "EEPROM file: changed words of the factory content replace the master's; the check value is correct",
            newer_factory),
        EEPROM_TEST("EEPROM file: a wrong check value of the master is kept", bad_checksum_stays_bad),
        EEPROM_TEST("EEPROM file: after an interrupted start, and after one with a full disk, the next start succeeds",
                    cut_off_first_start),
        EEPROM_TEST("EEPROM file: its descriptor is closed, also descriptor 0", descriptor_0),
        EEPROM_TEST("EEPROM file: a foreign file is refused and not changed", refused),
        EEPROM_TEST("EEPROM file: a link in place of the temporary file is refused, and its target not changed",
                    link_as_temporary_file),
        EEPROM_TEST("EEPROM file: a file that is replaced or removed before the lock is refused",
                    replaced_before_the_lock),
        EEPROM_TEST("EEPROM file: only the user of the twin can read or write the file", own_file),
        EEPROM_TEST("CF-065: words written by a master are kept over a power cycle and a restart of the process",
                    written_by_a_master),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("EEPROM", tests, make_folder, remove_folder);
}
