/* SPDX-License-Identifier: MIT */
/* Selection of a running twin, and the connection to it: the test has the folders, the users and the sockets. */
#define _GNU_SOURCE
#include "command_lines.h"

#include <errno.h>
#include <fcntl.h>
#include <glob.h>
#include <pwd.h>
#include <sys/stat.h>
#include <time.h>

#include "bus/control/endpoint.h"

enum { SELF = 1000, ANN = 1001, STRANGER = 1003, TWINS = 3, OTHERS = 3, ROOT = 0, WAITS = 50, LINE = 2048 };

#define OK    "{\"ok\":true}\n"
#define A     "{\"name\":\"a\",\"value\":1}\n"
#define ABOUT "{\"iface\":\"eth0\",\"iface2\":\"eth1\"}\n"

/* A socket. */
typedef struct twin {
    const char *path;
    uid_t owner;
    int error;         /* of the connection; 0: it succeeds */
    const char *reply; /* all that it sends; NULL: OK */
} twin_t;

/* Another user's folder, as glob() finds it. */
typedef struct other {
    const char *folder;
    uid_t owner;
    bool vanishes, is_file, is_hidden;
} other_t;

/* The machine of a run. */
typedef struct machine {
    twin_t twins[TWINS];
    other_t others[OTHERS];
    bool too_long;                     /* the folder of this user */
    int trust;                         /* errno of the check of this folder; 0: trusted */
    bool is_root;                      /* the user is 0 */
    unsigned int waits, interruptions; /* of recv() */
    size_t piece;                      /* most bytes that send() takes; 0: all */
    int send_error, interrupted_sends;
    int polls[4]; /* results of poll(): 0 timeout, 1 data, -1 EINTR, 2 the reader of the output has ended */
    long step_ms; /* clock, for each reading */
} machine_t;

static machine_t machine;
static pid_t parent;
static int ends[8];
static size_t end_count, poll_count;

/* --- functions of other rooms and of the C library ---------------------------------------------------------------- */

uid_t __wrap_geteuid(void);
struct passwd *__wrap_getpwuid(uid_t user);
int __wrap_glob(const char *pattern, int flags, int (*failed)(const char *, int), glob_t *found);
void __wrap_globfree(glob_t *found);
int __wrap_lstat(const char *path, struct stat *info);
int __wrap_access(const char *path, int mode);
ssize_t __real_recv(int fd, void *data, size_t size, int flags);
ssize_t __wrap_recv(int fd, void *data, size_t size, int flags);
ssize_t __real_send(int fd, const void *data, size_t size, int flags);
ssize_t __wrap_send(int fd, const void *data, size_t size, int flags);
int __real_poll(struct pollfd *fds, nfds_t count, int timeout_ms);
int __wrap_poll(struct pollfd *fds, nfds_t count, int timeout_ms);
int __real_clock_gettime(clockid_t clock, struct timespec *now);
int __wrap_clock_gettime(clockid_t clock, struct timespec *now);
int __wrap_ect_endpoint_folder(char *path);
int __wrap_ect_endpoint_trust(const char *folder);
void __wrap_ect_endpoint_each(const char *folder, bool (*found)(void *ctx, const char *path), void *ctx);
int __wrap_ect_endpoint_find(const char *name, char *path);
int __wrap_ect_endpoint_connect(const char *path, uid_t *owner);
void __wrap_ect_endpoint_clear(const char *path);

uid_t __wrap_geteuid(void)
{
    return machine.is_root ? ROOT : SELF;
}

struct passwd *__wrap_getpwuid(uid_t user)
{
    static struct passwd ann = {.pw_name = "ann"};
    return user == ANN ? &ann : NULL;
}

int __wrap_glob(const char *pattern, int flags, int (*failed)(const char *, int), glob_t *found)
{
    static char *paths[OTHERS];
    const size_t before = strcspn(pattern, "*");
    (void)failed;
    if (flags != 0)
        fputs("flags\n", stderr);
    *found = (glob_t){.gl_pathv = paths};
    for (size_t i = 0; i < OTHERS && machine.others[i].folder; i++) {
        if (strncmp(machine.others[i].folder, pattern, before) == 0)
            paths[found->gl_pathc++] = (char *)(uintptr_t)machine.others[i].folder;
    }
    return 0;
}

void __wrap_globfree(glob_t *found)
{
    found->gl_pathc = 0;
}

static const other_t *other_of(const char *folder)
{
    static const other_t none = {.vanishes = true};
    for (size_t i = 0; i < OTHERS && machine.others[i].folder; i++) {
        if (strcmp(machine.others[i].folder, folder) == 0)
            return &machine.others[i];
    }
    return &none;
}

int __wrap_lstat(const char *path, struct stat *info)
{
    const other_t *other = other_of(path);
    memset(info, 0, sizeof *info);
    info->st_mode = other->is_file ? S_IFREG : S_IFDIR;
    info->st_uid = other->owner;
    return other->vanishes ? -1 : 0;
}

int __wrap_access(const char *path, int mode)
{
    return mode == R_OK && !other_of(path)->is_hidden ? 0 : -1;
}

ssize_t __wrap_recv(int fd, void *data, size_t size, int flags)
{
    if (machine.interruptions > 0) {
        machine.interruptions--;
        errno = EINTR;
        return -1;
    }
    if (machine.waits > 0) {
        machine.waits--;
        errno = EAGAIN;
        return -1;
    }
    return __real_recv(fd, data, size, flags);
}

ssize_t __wrap_send(int fd, const void *data, size_t size, int flags)
{
    if (getpid() == parent)
        return __real_send(fd, data, size, flags);
    if (machine.interrupted_sends > 0) {
        machine.interrupted_sends--;
        errno = EINTR;
        return -1;
    }
    if (machine.send_error != 0) {
        errno = machine.send_error;
        return -1;
    }
    return __real_send(fd, data, machine.piece > 0 && machine.piece < size ? machine.piece : size, flags);
}

int __wrap_poll(struct pollfd *fds, nfds_t count, int timeout_ms)
{
    if (getpid() == parent)
        return __real_poll(fds, count, timeout_ms);
    const int result = machine.polls[poll_count++];
    fprintf(stderr, "poll %d ms%s\n", timeout_ms, fds[1].fd < 0 ? "" : ", and the output");
    fds[0].revents = fds[1].revents = 0;
    errno = EINTR;
    if (result == 1)
        fds[0].revents = POLLIN;
    if (result == 2)
        fds[1].revents = POLLERR;
    if (result == 3)
        fds[1].revents = POLLHUP;
    return result > 1 ? 1 : result;
}

int __wrap_clock_gettime(clockid_t clock, struct timespec *now)
{
    static long at_ms = 1500;
    if (getpid() == parent)
        return __real_clock_gettime(clock, now);
    *now = (struct timespec){.tv_sec = at_ms / 1000, .tv_nsec = at_ms % 1000 * 1000000 + 999999};
    at_ms += machine.step_ms;
    return 0;
}

int __wrap_ect_endpoint_folder(char *path)
{
    strcpy(path, "mine");
    return machine.too_long ? -1 : 0;
}

int __wrap_ect_endpoint_trust(const char *folder)
{
    if (strcmp(folder, "mine") != 0)
        fprintf(stderr, "trust %s\n", folder);
    errno = machine.trust;
    return machine.trust != 0 ? -1 : 0;
}

void __wrap_ect_endpoint_each(const char *folder, bool (*found)(void *ctx, const char *path), void *ctx)
{
    const size_t length = strlen(folder);
    for (size_t i = 0; i < TWINS && machine.twins[i].path; i++) {
        const char *path = machine.twins[i].path;
        if (strncmp(path, folder, length) == 0 && path[length] == '/' && !found(ctx, path))
            return;
    }
}

int __wrap_ect_endpoint_find(const char *name, char *path)
{
    sprintf(path, "mine/%s", name);
    return machine.too_long ? -1 : 0;
}

/* A connection that is still open at the end of the program. */
static void report_open(void)
{
    for (size_t i = 0; i < end_count; i++) {
        char text[4096];
        ssize_t got;
        while ((got = __real_recv(ends[i], text, sizeof text, MSG_DONTWAIT)) > 0)
            ;
        if (got < 0 && errno != ECONNRESET)
            fputs("left open\n", stderr);
    }
}

int __wrap_ect_endpoint_connect(const char *path, uid_t *owner)
{
    const twin_t *twin = NULL;
    int pair[2];
    for (size_t i = 0; i < TWINS && machine.twins[i].path; i++)
        twin = strcmp(machine.twins[i].path, path) == 0 ? &machine.twins[i] : twin;
    errno = twin ? twin->error : ENOENT;
    if (!twin || twin->error != 0 || socketpair(AF_UNIX, SOCK_STREAM, 0, pair) < 0)
        return -1;
    const char *reply = twin->reply ? twin->reply : OK;
    if (__real_send(pair[1], reply, strlen(reply), 0) < 0)
        return -1;
    (void)shutdown(pair[1], SHUT_WR);
    if (end_count == 0)
        (void)atexit(report_open);
    ends[end_count++] = pair[1];
    *owner = twin->owner;
    return pair[0];
}

void __wrap_ect_endpoint_clear(const char *path)
{
    fprintf(stderr, "clear %s\n", path);
}

/* --- runs --------------------------------------------------------------------------------------------------------- */

typedef struct row {
    const char *line;
    machine_t machine;
    int status;
    const char *text;
} row_t;

static void expect(const row_t *rows, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        machine = rows[i].machine;
        command_expect(&(command_line_t){.line = rows[i].line, .status = rows[i].status, .text = rows[i].text}, NULL,
                       0);
    }
}

#define EXPECT(rows)    expect(rows, sizeof(rows) / sizeof(rows)[0])
#define GET             "ectwin get: "
#define NONE            GET "no twin of yours is running: start one with 'ectwin run' or 'ectwin with'\n"
#define SEVERAL         GET "several twins are running: 'ectwin ps' lists them; choose one with -s, e.g. -s "
#define MINE(name, ...) {.path = "mine/" name, .owner = SELF, __VA_ARGS__}

static void own_twins(void **state)
{
    static const row_t rows[] = {
        {"get", {.twins = {MINE("a", .reply = A OK)}}, 0, "a=1\n"},
        {"get", {.twins = {MINE("a", .error = ECONNREFUSED), MINE("b", .reply = A OK)}}, 0, "clear mine/a\na=1\n"},
        {"get", {.twins = {MINE("a", .reply = A OK), MINE("b", .error = EAGAIN)}}, 0, "clear mine/b\na=1\n"},
        {"get", {.twins = {{.path = "mine/a", .owner = ANN}, MINE("b", .reply = A OK)}}, 0, "a=1\n"},
        {"get", {.twins = {{.path = "mine/a", .owner = ROOT}, MINE("b", .reply = A OK)}}, 0, "a=1\n"},
        {"get", {.twins = {{.path = "mine/a", .owner = ANN}}}, 2, NONE},
        {"get", {.twins = {MINE("a"), MINE("b")}}, 2, SEVERAL "mine/b\n"},
        {"get", {.twins = {MINE("a"), MINE("b\x1b"), MINE("c")}}, 2, SEVERAL "mine/b\\x1b\n"},
        {"get", {.too_long = true}, 2, GET "XDG_RUNTIME_DIR is too long\n"},
        {"get", {.trust = ENOENT}, 2, NONE},
        {"get", {.trust = ENOENT, .twins = {MINE("a")}}, 2, NONE},
        {"get",
         {.trust = EPERM, .twins = {MINE("a")}},
         2,
         GET "'mine' belongs to another user, or others may write to it: no twin in it is trusted\n"},
        {"ps",
         {.trust = EPERM},
         2,
         "ectwin ps: 'mine' belongs to another user, or others may write to it: no twin in it is trusted\n"},
        {"ps", {.trust = ENOENT}, 0, ""},
        {"ps", {.trust = 0}, 0, ""},
        {"get -i eth1", {.twins = {MINE("a", .reply = OK), MINE("b", .reply = ABOUT OK A OK)}}, 0, "a=1\n"},
        {"get -i eth0",
         {.twins = {MINE("a", .reply = ABOUT OK A OK), MINE("b", .reply = "{\"iface\":\"eth2\"}\n" OK)}},
         0,
         "a=1\n"},
        {"get -i eth0",
         {.twins = {MINE("a", .reply = ABOUT OK), MINE("b", .reply = "{\"iface\":\"eth0\"}\n" OK)}},
         2,
         SEVERAL "mine/b\n"},
        {"get -i eth2",
         {.twins = {MINE("a", .reply = ABOUT OK)}},
         2,
         GET "no twin of yours answers on 'eth2': 'ectwin ps' lists them\n"},
        {"get -i eth2",
         {.twins = {MINE("a", .reply = "")}},
         2,
         GET "no twin of yours answers on 'eth2': 'ectwin ps' lists them\n"},
    };
    (void)state;
    EXPECT(rows);
}

static void named_twins(void **state)
{
#define NOT_NAMED GET "no twin of yours has the name or the process id 'a': 'ectwin ps' lists them\n"
    static const row_t rows[] = {
        {"get -s a", {.twins = {MINE("a", .reply = A OK), MINE("b")}}, 0, "a=1\n"},
        {"get -s a", {.twins = {MINE("b")}}, 2, NOT_NAMED},
        {"get -s a", {.twins = {MINE("a", .error = EAGAIN)}}, 2, NOT_NAMED},
        {"get -s a", {.twins = {{.path = "mine/a", .owner = ANN}}}, 2, NOT_NAMED},
        {"get -s a", {.is_root = true, .twins = {{.path = "mine/a", .owner = ANN}}}, 2, NOT_NAMED},
        {"get -s a", {.too_long = true, .twins = {MINE("a")}}, 2, NOT_NAMED},
        {"get -s /a", {.twins = {{.path = "/a", .owner = SELF, .reply = A OK}}}, 0, "a=1\n"},
        {"get -s /a", {.twins = {{.path = "/a", .owner = ROOT, .reply = A OK}}}, 0, "a=1\n"},
        {"get -s /a", {.is_root = true, .twins = {{.path = "/a", .owner = ANN, .reply = A OK}}}, 0, "a=1\n"},
        {"get -s /a",
         {.twins = {{.path = "/a", .owner = ANN}}},
         2,
         GET "'/a' is served by ann, not by you: not trusted\n"},
        {"get -s /a",
         {.twins = {{.path = "/a", .owner = STRANGER}}},
         2,
         GET "'/a' is served by user 1003, not by you: not trusted\n"},
        {"get -s /a",
         {.twins = {{.path = "/a", .error = ECONNREFUSED}}},
         2,
         GET "no twin answers at '/a': Connection refused\n"},
        {"get -s /b", {.twins = {{.path = "/a"}}}, 2, GET "no twin answers at '/b': No such file or directory\n"},
    };
    (void)state;
    EXPECT(rows);
}

static void twins_of_others(void **state)
{
#define TMP      "/tmp/ectwin-1001"
#define RUN      "/run/user/1001/ectwin"
#define MAY_HAVE " may have some, in "
#define AS_THAT  ": run the command as that user, or with sudo\n"
    static const row_t rows[] = {
        {"get",
         {.others = {{.folder = TMP, .owner = ANN}}, .twins = {{.path = TMP "/a", .owner = ANN}}},
         2,
         NONE "  one of ann runs: -s " TMP "/a\n"},
        {"get",
         {.others = {{.folder = TMP, .owner = ANN}}, .twins = {{.path = TMP "/\x1b", .owner = STRANGER}}},
         2,
         NONE "  one of user 1003 runs: -s " TMP "/\\x1b\n"},
        {"get",
         {.others = {{.folder = RUN, .owner = ANN}},
          .twins = {{.path = RUN "/a", .owner = ANN}, {.path = RUN "/b", .owner = ANN}}},
         2,
         NONE "  one of ann runs: -s " RUN "/a\n  one of ann runs: -s " RUN "/b\n"},
        {"get",
         {.others = {{.folder = TMP, .owner = ANN, .is_hidden = true}}, .twins = {{.path = TMP "/a", .owner = ANN}}},
         2,
         NONE "  one of ann runs: -s " TMP "/a\n"},
        {"get",
         {.others = {{.folder = TMP, .owner = ANN}}, .twins = {{.path = TMP "/a", .error = ECONNREFUSED}}},
         2,
         NONE},
        {"get",
         {.others = {{.folder = TMP, .owner = ANN, .is_hidden = true}},
          .twins = {{.path = TMP "/a", .error = EACCES}, {.path = TMP "/b", .error = EACCES}}},
         2,
         NONE "  ann" MAY_HAVE TMP AS_THAT},
        {"get", {.others = {{.folder = RUN, .owner = ANN, .is_hidden = true}}}, 2, NONE "  ann" MAY_HAVE RUN AS_THAT},
        {"get",
         {.others = {{.folder = "/run/user/1003/ectwin", .owner = STRANGER, .is_hidden = true},
                     {.folder = TMP, .owner = ANN, .is_hidden = true}}},
         2,
         NONE "  ann" MAY_HAVE TMP AS_THAT "  user 1003" MAY_HAVE "/run/user/1003/ectwin" AS_THAT},
        {"get", {.others = {{.folder = TMP, .owner = ANN}}}, 2, NONE},
        /* folders that no twin of their owner has made */
        {"get", {.others = {{.folder = "/tmp/ectwin-1000", .owner = SELF, .is_hidden = true}}}, 2, NONE},
        {"get", {.others = {{.folder = TMP, .owner = ANN, .is_hidden = true, .is_file = true}}}, 2, NONE},
        {"get", {.others = {{.folder = TMP, .owner = ANN, .is_hidden = true, .vanishes = true}}}, 2, NONE},
        {"get", {.others = {{.folder = TMP, .owner = STRANGER, .is_hidden = true}}}, 2, NONE},
        {"get", {.others = {{.folder = "/tmp/ectwin-1001x", .owner = ANN, .is_hidden = true}}}, 2, NONE},
        {"get", {.others = {{.folder = "/run/user/1003/ectwin", .owner = ANN, .is_hidden = true}}}, 2, NONE},
        /* and only if nothing else selects the twin */
        {"get -i eth0",
         {.others = {{.folder = TMP, .owner = ANN, .is_hidden = true}}},
         2,
         GET "no twin of yours answers on 'eth0': 'ectwin ps' lists them\n"},
    };
    (void)state;
    EXPECT(rows);
}

static void late_and_broken(void **state)
{
#define TWIN(text) .twins = {MINE("a", .reply = text)}
#define ENDED      GET "the twin has ended, or has closed this connection\n"
    static const row_t rows[] = {
        {"get", {TWIN(A OK), .waits = WAITS - 1}, 0, "a=1\n"},
        {"get", {TWIN(A OK), .waits = WAITS}, 3, GET "the twin does not answer: it is stopped, or very busy\n"},
        {"get", {TWIN(A OK), .interruptions = 200, .waits = WAITS - 1}, 0, "a=1\n"},
        {"get", {TWIN(A OK), .interrupted_sends = 3}, 0, "a=1\n"},
        {"get", {TWIN(A OK), .piece = 1}, 0, "a=1\n"},
        {"get", {TWIN("{\"ok\":false,\"message\":\"full\"}\n"), .send_error = EPIPE}, 1, GET "full\n"},
        {"get", {TWIN(A)}, 3, ENDED "a=1\n"},
        {"get", {TWIN("{\"ok\":true}")}, 3, ENDED},
        {"get -i eth0",
         {TWIN(ABOUT OK A OK), .waits = WAITS},
         2,
         GET "no twin of yours answers on 'eth0': 'ectwin ps' lists them\n"},
    };
    (void)state;
    EXPECT(rows);
}

static void follows(void **state)
{
#define B     "{\"name\":\"a\",\"slave\":1,\"value\":2}\n"
#define FIRST "{\"name\":\"a\",\"slave\":1,\"value\":1}\n"
    static const row_t rows[] = {
        {"wait -t 2.5 a=2",
         {TWIN(FIRST OK), .polls = {0}},
         3,
         "poll 2500 ms\nectwin wait: a is still 1 after 2.5 s, not a=2\n"},
        {"wait -t 2.5 a=2",
         {TWIN(FIRST OK), .polls = {-1, 0}, .step_ms = 600},
         3,
         "poll 1900 ms\npoll 1300 ms\nectwin wait: a is still 1 after 2.5 s, not a=2\n"},
        {"wait -t 1 a=2",
         {TWIN(FIRST OK), .polls = {-1, 0}, .step_ms = 600},
         3,
         "poll 400 ms\npoll 0 ms\nectwin wait: a is still 1 after 1 s, not a=2\n"},
        {"wait -t 3000000 a=2",
         {TWIN(FIRST OK), .polls = {0}},
         3,
         "poll 2147483647 ms\nectwin wait: a is still 1 after 3e+06 s, not a=2\n"},
        {"wait a=2",
         {TWIN(FIRST OK), .polls = {0}},
         3,
         "poll 10000 ms\nectwin wait: a is still 1 after 10 s, not a=2\n"},
        {"wait a=2", {TWIN(FIRST OK B), .polls = {1}}, 0, ""},
        {"wait a=2",
         {TWIN(FIRST OK), .polls = {1}},
         3,
         "poll 10000 ms\nectwin wait: the twin has ended, or has closed this connection\n"},
        {"watch a",
         {TWIN(FIRST OK B), .polls = {1}},
         3,
         "poll -1 ms, and the output\nectwin watch: the twin has ended, or has closed this connection\n" FIRST B},
        {"watch a",
         {TWIN(FIRST OK B), .polls = {-1, 2}},
         0,
         "poll -1 ms, and the output\npoll -1 ms, and the output\n" FIRST B},
        {"watch a", {TWIN(FIRST OK B), .polls = {3}}, 0, "poll -1 ms, and the output\n" FIRST B},
        {"watch --csv - a",
         {TWIN(FIRST OK B), .polls = {1}},
         3,
         "poll -1 ms\nectwin watch: the twin has ended, or has closed this "
         "connection\ntime,a\n0.000000,1\n0.000000,2\n"},
    };
    (void)state;
    EXPECT(rows);
}

/* A line of a reply has room for 2047 characters; the next one is lost, and the rest becomes another line. */
static void long_lines(void **state)
{
    (void)state;
    for (size_t length = LINE - 2; length <= LINE + 1; length++) {
        static char reply[LINE + 100], text[LINE + 300];
        static const char poll[] = "poll -1 ms, and the output\n",
                          begin[] = "ectwin watch: the twin has ended, or has closed this "
                                    "connection\n" FIRST;
        const size_t after = sizeof FIRST OK - 1;
        memset(reply, 'x', sizeof reply);
        memcpy(reply, FIRST OK, after);
        strcpy(reply + after + length, "\n");
        const size_t first = length < LINE ? length : LINE - 1;
        snprintf(text, sizeof text, "%s%s%s%s%.*s\n%.*s%s", poll, poll, length > first ? poll : "", begin, (int)first,
                 reply + after, (int)(length > first ? length - LINE : 0), reply + after, length > first ? "\n" : "");
        machine = (machine_t){.twins = {{.path = "mine/a", .owner = SELF, .reply = reply}}, .polls = {1, 1, 1, 1}};
        command_expect(&(command_line_t){.line = "watch a", .status = 3, .text = text}, NULL, 0);
    }
}

#define TEST(title, function) {title, function, NULL, NULL, NULL}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        TEST("without a name, the only twin of this user is selected", own_twins),
        TEST("a name selects a twin of this user, a path also one of root", named_twins),
        TEST("without a twin of this user, those of others are listed", twins_of_others),
        TEST("a request survives interruptions and pieces, a reply is waited for 5 s", late_and_broken),
        TEST("changes are waited for until the timeout, or until the output has no reader", follows),
        TEST("a long line is cut", long_lines),
    };
    parent = getpid();
    unsetenv("ECTWIN_SOCKET");
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("The connection to a twin", tests, commands_begin, commands_end);
}
