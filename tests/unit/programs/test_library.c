/* SPDX-License-Identifier: MIT */
/* The bus as a library (src/bus/library.h): words, frames at both ends, late replies, signals, the control socket. */
#define _GNU_SOURCE
#include "bus/library.h"

#include <aio.h>
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include "bus/capture/logged.h"
#include "support/wire.h"

#define START_NS (1000 * MS)

enum { INPUT_END = 0, OUTPUT_END = 1, WORDS = 6, INDEX_AT = 17, TEXT = 512 };

/* A disk that completes only what is waited for. */
static const struct aiocb *waited_for;
int __wrap_aio_fsync(int operation, struct aiocb *block);
int __wrap_aio_error(const struct aiocb *block);
int __wrap_aio_suspend(const struct aiocb *const list[], int count, const struct timespec *timeout);
ssize_t __wrap_aio_return(struct aiocb *block);

int __wrap_aio_fsync(int operation, struct aiocb *block)
{
    (void)operation;
    (void)block;
    waited_for = NULL;
    return 0;
}

int __wrap_aio_error(const struct aiocb *block)
{
    return block == waited_for ? 0 : EINPROGRESS;
}

int __wrap_aio_suspend(const struct aiocb *const list[], int count, const struct timespec *timeout)
{
    (void)timeout;
    assert_int_equal(count, 1);
    waited_for = list[0];
    return 0;
}

ssize_t __wrap_aio_return(struct aiocb *block)
{
    (void)block;
    return 0;
}

static int count_of(const char *const words[WORDS])
{
    int count = 0;
    while (count < WORDS && words[count])
        count++;
    return count;
}

static ectwin_bus_t *must_open(const char *const words[WORDS])
{
    ectwin_bus_t *bus = ectwin_bus_open(count_of(words), words, START_NS, NULL);
    assert_non_null(bus);
    return bus;
}

static ectwin_bus_t *open_one(void)
{
    static const char *const words[WORDS] = {"fzm1"};
    return must_open(words);
}

/* @return the time of the next call without a frame */
static uint64_t pass(ectwin_bus_t *bus, unsigned int end, uint8_t index, uint64_t now_ns)
{
    wire_t w = {0};
    wire_build(&w, BRD, 0, 0x0130, "\0", 1);
    w.frame[INDEX_AT] = index;
    return ectwin_bus_frame(bus, end, w.frame, w.frame_length, now_ns);
}

/* @return the index of the next reply, at this end; -1: none waits */
static int reply_at(ectwin_bus_t *bus, unsigned int want_end)
{
    uint8_t frame[ECTWIN_FRAME_MAX];
    unsigned int end = 9;
    size_t length = ectwin_bus_reply(bus, &end, frame, sizeof frame);
    if (length == 0)
        return -1;
    assert_int_equal(end, want_end);
    assert_int_equal(length, 29);
    return frame[INDEX_AT];
}

/* --- opening ------------------------------------------------------------------------------------------------------ */

static void words_of_a_bus(void **state)
{
    static const struct {
        const char *words[WORDS];
        size_t slaves;
    } rows[] = {
        {{"fzm1"}, 1},
        {{"fzm1,vr-bu-ect-map7"}, 2},
        {{"--set", "data1=1.5", "fzm1,fzm1,fzm1"}, 3},
        {{"--iface", "eth7", "--in-process", "fzm1"}, 1}, /* options of `ectwin with` have no effect */
        {{"--virtual-time", "--leave-children", "fzm1"}, 1},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ectwin_bus_t *bus = must_open(rows[i].words);
        assert_int_equal(ectwin_bus_slaves(bus), rows[i].slaves);
        ectwin_bus_close(bus);
    }
    ectwin_bus_close(NULL);
    assert_int_equal(strspn(ectwin_version(), "0123456789."), strlen(ectwin_version()));
}

/* In a process of its own: a refused call may keep memory. Gets standard error, then '=' and the message.
 * @return whether the call returned, without a bus */
static bool is_refused(const char *const words[WORDS], char *text)
{
    int ends[2], status;
    size_t used = 0;
    ssize_t got;
    assert_int_equal(pipe(ends), 0);
    pid_t child = fork();
    if (child == 0) {
        char message[ECTWIN_MESSAGE];
        (void)dup2(ends[1], STDERR_FILENO);
        ectwin_bus_t *bus = ectwin_bus_open(count_of(words), words, START_NS, message);
        (void)dprintf(ends[1], "=%s", message);
        _exit(!bus && !ectwin_bus_open(count_of(words), words, START_NS, NULL) ? 99 : 0);
    }
    close(ends[1]);
    while (used + 1 < TEXT && (got = read(ends[0], text + used, TEXT - 1 - used)) > 0)
        used += (size_t)got;
    text[used] = 0;
    close(ends[0]);
    assert_int_equal(waitpid(child, &status, 0), child);
    return WIFEXITED(status) && WEXITSTATUS(status) == 99;
}

static void wrong_words(void **state)
{
    static const struct {
        const char *words[WORDS], *part;
    } rows[] = {
        {{NULL}, "name a device"},
        {{"--set", "data1=1"}, "name a device"},
        {{"fzm1", "fzm1"}, "one list of devices is enough"},
        {{"nosuch"}, "nosuch"},
        {{"--nosuch", "fzm1"}, "'--nosuch' is no option"},
        {{"fzm1", "--drop"}, "'--drop' is no option of a bus, or lacks its value"},
        {{"--help", "fzm1"}, "'--help' is no option"},
        {{"--external", "fzm1"}, "'--external' is no option of a bus, or lacks its value"},
        {{"--set", "data1", "fzm1"}, "--set takes NAME=VALUE"},
        {{"--set", "data1=1", "--set", "data1"}, "--set takes NAME=VALUE"},
        {{"--module", "1=0x120", "--module", "x", "fzm1"}, "--module takes SLOT=IDENT"},
        {{"--behaviour", "none", "--behaviour", "x", "fzm1"}, "--behaviour takes cia402, cia404, cia406 or none"},
        {{"--faults", "/nonexistent", "fzm1"}, "/nonexistent: No such file"},
        {{"--esc", "help", "fzm1"}, "a list of names is no bus"},
        {{"--set", "nosuch=1", "fzm1"}, "nosuch"},
        {{"--drop", "101", "fzm1"}, "drop"},
        {{"--fault", "explode", "fzm1"}, "explode"},
        {{"--fault", "hang slave 2", "fzm1"}, "slave 2"},
        {{"--files", "/nonexistent/folder", "fzm1"}, "/nonexistent/folder"},
        {{"--connect", "1.nosuch=1.data1", "fzm1"}, "twin 1 has no signal 'nosuch'"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char text[TEXT];
        bool refused = is_refused(rows[i].words, text);
        if (!refused || text[0] != '=' || !strstr(text, rows[i].part))
            fail_msg("row %zu: refused: %d, expected '=' and '%s' in '%s'", i, refused, rows[i].part, text);
    }
}

/* --- frames ------------------------------------------------------------------------------------------------------- */

static void lengths(void **state)
{
    static const struct {
        size_t length;
        bool taken;
    } rows[] = {{0, false},
                {1, true},
                {2, true},
                {1514, true},
                {2047, true},
                {ECTWIN_FRAME_MAX, true},
                {ECTWIN_FRAME_MAX + 1, false}};
    static const char *const words[WORDS] = {"--fault", "delay 2000us", "fzm1"};
    static uint8_t frame[ECTWIN_FRAME_MAX + 1];
    (void)state;
    memset(frame, 0xFF, sizeof frame);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ectwin_bus_t *bus = must_open(words);
        (void)ectwin_bus_run(bus, START_NS);
        uint64_t next_ns = ectwin_bus_frame(bus, INPUT_END, frame, rows[i].length, START_NS + 1 * MS);
        assert_true(next_ns == ectwin_bus_run(bus, START_NS));
        assert_int_equal(reply_at(bus, INPUT_END), -1);
        /* The time of a frame that is taken has come for all later calls. */
        (void)pass(bus, INPUT_END, 1, START_NS);
        assert_true(ectwin_bus_run(bus, START_NS) == START_NS + (rows[i].taken ? 3 * MS : 2 * MS));
        ectwin_bus_close(bus);
    }
}

static void both_ends(void **state)
{
    ectwin_bus_t *bus = open_one();
    (void)state;
    (void)pass(bus, INPUT_END, 1, START_NS);
    (void)pass(bus, OUTPUT_END, 2, START_NS); /* no cable is in there */
    assert_int_equal(reply_at(bus, INPUT_END), 1);
    assert_int_equal(reply_at(bus, INPUT_END), -1);
    ectwin_bus_link(bus, OUTPUT_END, 1, START_NS);
    (void)pass(bus, INPUT_END, 3, START_NS);
    (void)pass(bus, OUTPUT_END, 4, START_NS);
    assert_int_equal(reply_at(bus, OUTPUT_END), 3);
    assert_int_equal(reply_at(bus, INPUT_END), 4);
    ectwin_bus_link(bus, INPUT_END, 0, START_NS);
    (void)pass(bus, INPUT_END, 5, START_NS);
    assert_int_equal(reply_at(bus, INPUT_END), -1);
    ectwin_bus_link(bus, OUTPUT_END, 0, START_NS);
    ectwin_bus_link(bus, INPUT_END, 7, START_NS); /* any value but 0 */
    ectwin_bus_link(bus, 2, 1, START_NS);         /* there is no such end */
    (void)pass(bus, 2, 6, START_NS);
    (void)pass(bus, INPUT_END, 7, START_NS);
    assert_int_equal(reply_at(bus, INPUT_END), 7);
    assert_int_equal(reply_at(bus, INPUT_END), -1);
    ectwin_bus_close(bus);
}

/* A reply is cut to the room; the returned length is that of the frame. The bus frees the replies that wait. */
static void rooms(void **state)
{
    static const size_t rows[] = {0, 1, 28, 29, 30};
    ectwin_bus_t *bus = open_one();
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t frame[64];
        unsigned int end;
        memset(frame, 0xAA, sizeof frame);
        (void)pass(bus, INPUT_END, 1, START_NS);
        assert_int_equal(ectwin_bus_reply(bus, &end, frame, rows[i]), 29);
        for (size_t n = rows[i]; n < sizeof frame; n++)
            assert_int_equal(frame[n], 0xAA);
        assert_int_equal(frame[0], rows[i] > 0 ? 0xFF : 0xAA);
    }
    for (uint8_t n = 0; n < 5; n++)
        (void)pass(bus, INPUT_END, n, START_NS);
    for (uint8_t n = 0; n < 3; n++)
        assert_int_equal(reply_at(bus, INPUT_END), n);
    ectwin_bus_close(bus);
}

static void late_replies(void **state)
{
    static const char *const words[WORDS] = {"--fault", "delay 2000us every 2", "fzm1"};
    ectwin_bus_t *bus = must_open(words);
    (void)state;
    (void)ectwin_bus_run(bus, START_NS); /* takes the fault */
    (void)pass(bus, INPUT_END, 1, START_NS);
    assert_true(pass(bus, INPUT_END, 2, START_NS) == START_NS + 2 * MS); /* the time of its reply */
    (void)pass(bus, INPUT_END, 3, START_NS + 1 * MS);
    assert_int_equal(reply_at(bus, INPUT_END), 1);
    assert_int_equal(reply_at(bus, INPUT_END), -1);
    assert_true(ectwin_bus_run(bus, START_NS + 2 * MS - 1) == START_NS + 2 * MS);
    assert_int_equal(reply_at(bus, INPUT_END), -1);
    assert_true(ectwin_bus_run(bus, START_NS + 2 * MS) > START_NS + 2 * MS);
    assert_int_equal(reply_at(bus, INPUT_END), 2);
    assert_int_equal(reply_at(bus, INPUT_END), 3);
    assert_int_equal(reply_at(bus, INPUT_END), -1);
    ectwin_bus_close(bus);
}

/* A call with an earlier time than the last one uses the last one. */
static void time_that_goes_back(void **state)
{
    static const char *const words[WORDS] = {"--fault", "delay 2000us", "fzm1"};
    ectwin_bus_t *bus = must_open(words);
    (void)state;
    (void)ectwin_bus_run(bus, START_NS + 10 * MS);
    (void)pass(bus, INPUT_END, 1, START_NS); /* at 10 ms */
    (void)ectwin_bus_run(bus, START_NS + 2 * MS);
    assert_int_equal(reply_at(bus, INPUT_END), -1);
    assert_true(ectwin_bus_run(bus, 0) == START_NS + 12 * MS);
    (void)ectwin_bus_run(bus, START_NS + 12 * MS);
    assert_int_equal(reply_at(bus, INPUT_END), 1);
    ectwin_bus_close(bus);
}

/* The time of a call, as that of a frame in `lengths`: a frame with an earlier time enters at the time of the call. */
static void times_of_calls(void **state)
{
    static const char *const words[WORDS] = {"--fault", "delay 2000us", "fzm1"};
    const uint64_t call_ns = START_NS + 1 * MS;
    char why[ECTWIN_MESSAGE];
    (void)state;
    for (unsigned int call = 0; call < 5; call++) {
        ectwin_bus_t *bus = must_open(words);
        (void)ectwin_bus_run(bus, START_NS);
        if (call == 0)
            (void)ectwin_bus_run(bus, call_ns);
        else if (call == 1)
            ectwin_bus_link(bus, OUTPUT_END, 0, call_ns);
        else if (call == 2)
            ectwin_bus_power_cycle(bus, call_ns);
        else if (call == 3)
            assert_int_equal(ectwin_bus_set(bus, 1, "data1", "1", call_ns, why, sizeof why), 0);
        else
            assert_int_equal(ectwin_bus_fault(bus, "drop 0%", call_ns, why, sizeof why), 0);
        const uint64_t reply_ns = pass(bus, INPUT_END, 1, START_NS);
        if (reply_ns != call_ns + 2 * MS)
            fail_msg("call %u: expected a reply at %" PRIu64 " ns, got %" PRIu64, call, (uint64_t)(call_ns + 2 * MS),
                     reply_ns);
        ectwin_bus_close(bus);
    }
}

/* The same: a reply that is due at the time of a call waits when the call returns. */
static void work_of_calls(void **state)
{
    static const char *const words[WORDS] = {"--fault", "delay 2000us", "fzm1"};
    const uint64_t due_ns = START_NS + 2 * MS;
    char why[ECTWIN_MESSAGE];
    (void)state;
    for (unsigned int call = 0; call < 5; call++) {
        ectwin_bus_t *bus = must_open(words);
        (void)ectwin_bus_run(bus, START_NS);
        (void)pass(bus, INPUT_END, 1, START_NS);
        if (call == 0)
            (void)ectwin_bus_run(bus, due_ns);
        else if (call == 1)
            ectwin_bus_link(bus, OUTPUT_END, 0, due_ns);
        else if (call == 2)
            assert_int_equal(ectwin_bus_set(bus, 1, "data1", "1", due_ns, why, sizeof why), 0);
        else if (call == 3)
            assert_int_equal(ectwin_bus_fault(bus, "drop 0%", due_ns, why, sizeof why), 0);
        else
            (void)pass(bus, INPUT_END, 2, due_ns);
        if (reply_at(bus, INPUT_END) != 1)
            fail_msg("call %u: expected the reply that is due", call);
        assert_int_equal(reply_at(bus, INPUT_END), -1);
        ectwin_bus_close(bus);
    }
}

/* A late reply and the registers go; faults and cables stay. */
static void power_cycle(void **state)
{
    static const char *const words[WORDS] = {"--fault", "delay 2000us", "fzm1"};
    ectwin_bus_t *bus = must_open(words);
    (void)state;
    (void)ectwin_bus_run(bus, START_NS);
    ectwin_bus_link(bus, OUTPUT_END, 1, START_NS);
    pass(bus, INPUT_END, 1, START_NS);
    ectwin_bus_power_cycle(bus, START_NS + 1 * MS);
    (void)ectwin_bus_run(bus, START_NS + 9 * MS);
    assert_int_equal(reply_at(bus, OUTPUT_END), -1);
    pass(bus, INPUT_END, 2, START_NS + 10 * MS);
    assert_int_equal(reply_at(bus, OUTPUT_END), -1);
    (void)ectwin_bus_run(bus, START_NS + 12 * MS);
    assert_int_equal(reply_at(bus, OUTPUT_END), 2);
    ectwin_bus_close(bus);
}

static void assert_signal(ectwin_bus_t *bus, const char *name, const char *want)
{
    char got[TEXT];
    assert_int_equal(ectwin_bus_get(bus, 1, name, got, sizeof got), 0);
    assert_string_equal(got, want);
}

static void set_signal(ectwin_bus_t *bus, const char *name, const char *value, uint64_t now_ns)
{
    char why[ECTWIN_MESSAGE];
    if (ectwin_bus_set(bus, 1, name, value, now_ns, why, sizeof why) != 0)
        fail_msg("%s=%s: %s", name, value, why);
}

static void remove_folder(const char *folder)
{
    DIR *files = opendir(folder);
    assert_non_null(files);
    for (const struct dirent *file = readdir(files); file; file = readdir(files))
        (void)unlinkat(dirfd(files), file->d_name, 0);
    closedir(files);
    assert_int_equal(rmdir(folder), 0);
}

/* A bus whose time is an argument would have another run with another disk; one on the real clock must not stop. */
static void saves_and_the_disk(void **state)
{
    static const struct {
        const char *title, *clock[2];
        const char *saves; /* after a second */
    } rows[] = {{"a bus with its own clock", {NULL}, "1"},
                {"in the process of a master, virtual clock", {"--in-process", "--virtual-time"}, "1"},
                {"in the process of a master, real clock", {"--in-process"}, "0"}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char folder[] = "/tmp/test-ectwin-XXXXXX";
        assert_non_null(mkdtemp(folder));
        const char *const words[WORDS] = {"--store", folder, "fzm1", rows[i].clock[0], rows[i].clock[1]};
        print_message("%s\n", rows[i].title);
        ectwin_bus_t *bus = must_open(words);
        set_signal(bus, "data1", "7", START_NS);
        set_signal(bus, "save", "1", START_NS);
        for (unsigned int ms = 1; ms <= 1000; ms++)
            (void)ectwin_bus_run(bus, START_NS + ms * MS);
        assert_signal(bus, "saves", rows[i].saves);
        ectwin_bus_close(bus);
        bus = must_open(words);
        assert_signal(bus, "data1", "7");
        set_signal(bus, "data1", "8", START_NS);
        set_signal(bus, "save", "1", START_NS);
        ectwin_bus_close(bus);
        bus = must_open(words);
        assert_signal(bus, "data1", "8");
        ectwin_bus_close(bus);
        remove_folder(folder);
    }
}

/* --- signals ------------------------------------------------------------------------------------------------------ */

static void get_signals(void **state)
{
    static const struct {
        size_t slave;
        const char *name;
        size_t room;
        const char *want; /* NULL: refused */
    } rows[] = {
        {1, "data1", TEXT, "1.5"}, {2, "data1", TEXT, "0"},      {1, "data1", 4, "1.5"},   {1, "data1", 3, NULL},
        {1, "data1", 0, NULL},     {0, "data1", TEXT, NULL},     {3, "data1", TEXT, NULL}, {1, "nosuch", TEXT, NULL},
        {1, "", TEXT, NULL},       {2, "ecat.state", TEXT, "1"},
    };
    static const char *const words[WORDS] = {"--set", "data1=1.5", "fzm1,fzm1"};
    ectwin_bus_t *bus = must_open(words);
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char text[TEXT] = "before";
        int result = ectwin_bus_get(bus, rows[i].slave, rows[i].name, text, rows[i].room);
        assert_int_equal(result, rows[i].want ? 0 : -1);
        assert_string_equal(text, rows[i].want ? rows[i].want : "before");
    }
    ectwin_bus_close(bus);
}

static void set_signals(void **state)
{
    static const struct {
        size_t slave;
        const char *name, *value;
        const char *part; /* of the message; NULL: it is set */
    } rows[] = {
        {1, "data1", "-2.25", NULL},        {2, "data1", "3", NULL},
        {0, "data1", "4", "no such slave"}, {3, "data1", "4", "no such slave"},
        {1, "nosuch", "4", "no signal"},    {1, "data1", "x", "takes"},
        {1, "data1", "1e10", "takes"},      {1, "busy", "1", "the twin's own"},
    };
    static const char *const words[WORDS] = {"fzm1,fzm1"};
    ectwin_bus_t *bus = must_open(words);
    char text[TEXT];
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char message[TEXT] = "before";
        int result = ectwin_bus_set(bus, rows[i].slave, rows[i].name, rows[i].value, START_NS, message, sizeof message);
        if (result != (rows[i].part ? -1 : 0) || !strstr(message, rows[i].part ? rows[i].part : "before"))
            fail_msg("row %zu: %d, '%s'", i, result, message);
    }
    char message[TEXT] = "before";
    assert_int_equal(ectwin_bus_set(bus, 0, "data1", "4", START_NS, message, 0), -1);
    assert_string_equal(message, "before");
    assert_int_equal(ectwin_bus_set(bus, 0, "data1", "4", START_NS, message, 6), -1);
    assert_string_equal(message, "there");
    assert_int_equal(ectwin_bus_get(bus, 1, "data1", text, sizeof text), 0);
    assert_string_equal(text, "-2.25");
    assert_int_equal(ectwin_bus_get(bus, 2, "data1", text, sizeof text), 0);
    assert_string_equal(text, "3");
    ectwin_bus_close(bus);
}

/* The twin of a set signal runs at the time of the call, though nothing was due then. */
static void a_signal_acts_at_its_time(void **state)
{
    static const uint64_t rows[] = {START_NS, START_NS + 1, START_NS + 3 * MS};
    enum { FIRST_PIECE_NS = 100000 };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ectwin_bus_t *bus = open_one();
        assert_true(ectwin_bus_run(bus, START_NS) == UINT64_MAX);
        set_signal(bus, "save", "1", rows[i]);
        assert_true(ectwin_bus_run(bus, rows[i]) == rows[i] + FIRST_PIECE_NS);
        ectwin_bus_close(bus);
    }
}

static void set_faults(void **state)
{
    static const struct {
        const char *fault, *part; /* of the message; NULL: it is set */
    } rows[] = {{"explode", "explode"}, {"hang slave 2", "slave 2"}, {"drop every 2", NULL}};
    ectwin_bus_t *bus = open_one();
    char message[TEXT];
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        snprintf(message, sizeof message, "before");
        int result = ectwin_bus_fault(bus, rows[i].fault, START_NS, message, sizeof message);
        if (result != (rows[i].part ? -1 : 0) || !strstr(message, rows[i].part ? rows[i].part : "before"))
            fail_msg("row %zu: %d, '%s'", i, result, message);
    }
    for (uint8_t n = 1; n <= 4; n++) {
        pass(bus, INPUT_END, n, START_NS);
        assert_int_equal(reply_at(bus, INPUT_END), n % 2 == 0 ? -1 : n);
    }
    assert_int_equal(ectwin_bus_fault(bus, "off", START_NS, message, 0), 0);
    assert_int_equal(ectwin_bus_fault(bus, "explode", START_NS, message, 0), -1);
    for (uint8_t n = 1; n <= 4; n++) {
        pass(bus, INPUT_END, n, START_NS);
        assert_int_equal(reply_at(bus, INPUT_END), n);
    }
    ectwin_bus_close(bus);
}

/* Replies to 64 frames, as bits. */
static uint64_t replies_of(const char *const words[WORDS])
{
    ectwin_bus_t *bus = must_open(words);
    uint64_t replies = 0;
    (void)ectwin_bus_run(bus, START_NS);
    for (uint8_t n = 0; n < 64; n++) {
        pass(bus, INPUT_END, n, START_NS);
        replies = replies << 1 | (reply_at(bus, INPUT_END) >= 0);
    }
    ectwin_bus_close(bus);
    return replies;
}

static void seeds(void **state)
{
    static const char *const none[WORDS] = {"--fault", "drop 50%", "fzm1"},
                             *const one[WORDS] = {"--fault", "drop 50%", "--seed", "1", "fzm1"},
                             *const two[WORDS] = {"--fault", "drop 50%", "--seed", "2", "fzm1"};
    (void)state;
    assert_true(replies_of(none) == replies_of(one));
    assert_true(replies_of(two) == replies_of(two));
    assert_true(replies_of(one) != replies_of(two));
}

static void judge_scenarios(void **state)
{
    static const struct {
        const char *step;
        int failed;
        const char *text;
    } rows[] = {
        {"drop 0%", 0, ""},
        {"expect ecat.state=1", 0, "'expect ecat.state=1' is met\n1 of 1 expectations are met\n"},
        {"expect ecat.state=2", 1, "'expect ecat.state=2' has failed: ecat.state is 1\n0 of 1 expectations are met\n"},
        {"at OP expect ecat.state=8", 1,
         "'at OP expect ecat.state=8' has failed: the run ended before its milestone\n0 of 1 expectations are met\n"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char text[512], why[ECTWIN_MESSAGE];
        const char *const words[] = {"--fault", rows[i].step, "fzm1"};
        ectwin_bus_t *bus = ectwin_bus_open(3, words, START_NS, why);
        assert_non_null(bus);
        (void)ectwin_bus_run(bus, START_NS + 1);
        assert_int_equal(ectwin_bus_verdict(bus, text, sizeof text), rows[i].failed);
        assert_string_equal(text, rows[i].text);
        assert_int_equal(ectwin_bus_verdict(bus, text, 0), rows[i].failed);
        assert_string_equal(text, rows[i].text);
        text[0] = 'x';
        assert_int_equal(ectwin_bus_verdict(bus, text, 1), rows[i].failed);
        assert_string_equal(text, "");
        assert_int_equal(ectwin_bus_verdict(bus, text, 4), rows[i].failed);
        assert_memory_equal(text, rows[i].text, strnlen(rows[i].text, 3));
        ectwin_bus_close(bus);
    }
}

/* --- control socket ----------------------------------------------------------------------------------------------- */

static int connect_to(const char *path)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    assert_true(strlen(path) < sizeof address.sun_path);
    strcpy(address.sun_path, path);
    assert_int_equal(connect(fd, (const struct sockaddr *)&address, sizeof address), 0);
    assert_int_equal(fcntl(fd, F_SETFL, O_NONBLOCK), 0);
    return fd;
}

static void control_socket(void **state)
{
    static const char request[] = "{\"op\":\"get\",\"pattern\":\"data1\"}\n{\"op\":\"stats\"}\n";
    char folder[] = "/tmp/test-ectwin-XXXXXX", inner[64], got[8192];
    ectwin_bus_t *bus = open_one();
    (void)state;
    assert_non_null(mkdtemp(folder));
    setenv("XDG_RUNTIME_DIR", folder, 1);
    assert_null(ectwin_bus_control_path(bus));
    assert_int_equal(ectwin_bus_serve(bus, START_NS), 0); /* nothing is open */
    (void)pass(bus, INPUT_END, 1, START_NS);
    int control = ectwin_bus_control(bus);
    assert_true(control >= 0);
    assert_int_equal(ectwin_bus_control(bus), control); /* once */
    assert_int_equal(ectwin_bus_serve(bus, START_NS), 0);
    const char *path = ectwin_bus_control_path(bus);
    assert_non_null(strstr(path, folder));
    int fd = connect_to(path);
    struct pollfd ready = {.fd = control, .events = POLLIN};
    assert_int_equal(poll(&ready, 1, 0), 1);
    assert_int_equal(write(fd, request, strlen(request)), (ssize_t)strlen(request));
    unsigned int calls = 0;
    while (ectwin_bus_serve(bus, START_NS + 5 * MS) && calls < 100)
        calls++;
    assert_in_range(calls, 2, 99);
    ssize_t size = read(fd, got, sizeof got - 1);
    assert_true(size > 0);
    got[size] = 0;
    assert_non_null(strstr(got, "{\"slave\":1,\"name\":\"data1\",\"value\":0}\n{\"ok\":true}\n"));
    assert_non_null(strstr(got, "\"frames\":1,\"answered\":1,\"in_kernel\":0,\"unanswered\":0"));
    ectwin_bus_close(bus);
    assert_int_equal(read(fd, got, sizeof got), 0); /* the end of the bus ends the connection */
    close(fd);
    snprintf(inner, sizeof inner, "%s/ectwin", folder);
    assert_int_equal(rmdir(inner), 0);
    assert_int_equal(rmdir(folder), 0);
}

static void no_control_socket(void **state)
{
    ectwin_bus_t *bus = open_one();
    (void)state;
    setenv("XDG_RUNTIME_DIR", "/dev/null", 1);
    assert_int_equal(ectwin_bus_control(bus), -1);
    assert_null(ectwin_bus_control_path(bus));
    assert_int_equal(ectwin_bus_serve(bus, START_NS), 0);
    ectwin_bus_close(bus);
}

/* @return whether a file contains bytes */
static bool contains_bytes(const char *path, const void *bytes, size_t length)
{
    static char content[1 << 20];
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    const size_t size = fread(content, 1, sizeof content, file);
    fclose(file);
    return memmem(content, size, bytes, length) != NULL;
}

static bool contains(const char *path, const char *text)
{
    return contains_bytes(path, text, strlen(text));
}

/* @return whether a record has a change at this time */
static bool is_touched(const char *path, uint64_t time_ns)
{
    uint8_t head[ECT_LOGGED_HEAD];
    ect_logged_head(head, ECT_LOGGED_TOUCH, 0, time_ns);
    return contains_bytes(path, head, sizeof head);
}

static void changes_in_a_record(void **state)
{
    char path[] = "/tmp/ectwin-library-XXXXXX", why[ECTWIN_MESSAGE];
    const int fd = mkstemp(path);
    (void)state;
    assert_true(fd >= 0);
    close(fd);
    const char *const words[WORDS] = {"--record", path, "fzm1,fzm1"};
    ectwin_bus_t *bus = must_open(words);
    assert_int_equal(ectwin_bus_set(bus, 2, "data1", "1.5", START_NS + 1 * MS, why, sizeof why), 0);
    assert_int_equal(ectwin_bus_fault(bus, "drop 3%", START_NS + 2 * MS, why, sizeof why), 0);
    ectwin_bus_link(bus, OUTPUT_END, 1, START_NS + 3 * MS);
    (void)ectwin_bus_run(bus, START_NS + 4 * MS);
    ectwin_bus_close(bus);
    for (unsigned int ms = 0; ms <= 4; ms++) {
        if (is_touched(path, START_NS + ms * MS) != (ms >= 1 && ms <= 3))
            fail_msg("%u ms: expected a touch at each change, and no other", ms);
    }
    assert_true(contains(path, "\"seed\":1,"));
    assert_true(contains(path, "{\"op\":\"set\",\"slave\":2,\"name\":\"data1\",\"value\":\"1.5\"}"));
    assert_true(contains(path, "{\"op\":\"fault\",\"fault\":\"drop 3%\"}"));
    unlink(path);
}

#define TEST(title, function) {title, function, NULL, NULL, NULL}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        TEST("a bus has the twins that its words name; options of a command have no effect", words_of_a_bus),
        TEST("wrong words are refused with a line that names them, and print nothing", wrong_words),
        TEST("frames of 1..2048 bytes are taken, shorter and longer ones are lost", lengths),
        TEST("frames enter and leave at both ends, as long as a cable is in", both_ends),
        TEST("a reply is cut to the room, and the length of the frame is returned", rooms),
        TEST("a late reply leaves when it is due, before the later ones", late_replies),
        TEST("a call with an earlier time uses the last time", time_that_goes_back),
        TEST("the time of each call is that of the bus", times_of_calls),
        TEST("each call does the work that is due at its time", work_of_calls),
        TEST("a power cycle drops late replies and keeps faults and cables", power_cycle),
        TEST("a save waits for the disk, on the real clock only at the end of the bus", saves_and_the_disk),
        TEST("a signal is read as text, if it has room", get_signals),
        TEST("a signal is set from text, or the reason is returned and nothing changes", set_signals),
        TEST("a set signal acts at the time of the call", a_signal_acts_at_its_time),
        TEST("a fault is set from text, or the reason is returned", set_faults),
        TEST("the random seed is 1, or that of --seed", seeds),
        TEST("a record has the seed, and each set signal and fault as a request at its time", changes_in_a_record),
        TEST("the expectations of a bus are judged, a line each", judge_scenarios),
        TEST("the control socket of a bus opens once, serves its clients and ends with the bus", control_socket),
        TEST("without a folder for the control socket none is open", no_control_socket),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Library", tests, NULL, NULL);
}
