/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "connection.h"

#include <errno.h>
#include <glob.h>
#include <poll.h>
#include <pwd.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

#include "bus/chain/names.h"
#include "bus/control/endpoint.h"
#include "commands.h"
#include "text/number.h"
#include "text/utf8.h"

enum { LINE_ROOM = 2048 };

/* The patience is a number of short waits: while the machine stands still, the twin cannot reply, and no more than one
 * of them passes. */
enum { WAIT_MS = 100, WAITS = ECT_ENDPOINT_PATIENCE_S * 1000 / WAIT_MS };

struct connection {
    int fd;
    char path[ECT_ENDPOINT_PATH];
    size_t used;
    char received[LINE_ROOM]; /* `used` bytes, beginning with the next line */
};

/* @return bytes of the printable character at the start of a text; 0: none */
static size_t visible(const char *text)
{
    if (*text >= ' ' && *text <= '~')
        return 1;
    return ect_utf8_controls(text) ? 0 : ect_utf8_begins(text);
}

/* Writes the printable beginning of a text. @return the rest, which begins with another character or is empty */
static const char *write_visible(FILE *stream, const char *text)
{
    for (size_t length; (length = visible(text)) > 0; text += length)
        (void)fwrite(text, length, 1, stream);
    return text;
}

void print_text(FILE *stream, const char *text)
{
    while (*(text = write_visible(stream, text)) != 0)
        fprintf(stream, "\\x%02x", (unsigned char)*text++);
}

void print_json(const char *text)
{
    for (; *(text = write_visible(stdout, text)) != 0; text++)
        putchar('?');
    putchar('\n');
    fflush(stdout);
}

void print_line(const cJSON *line)
{
    char *text = cJSON_PrintUnformatted(line);
    print_json(text ? text : "");
    cJSON_free(text);
}

/* --- search ------------------------------------------------------------------------------------------------------- */

static const char *name_of(uid_t user, char room[32])
{
    const struct passwd *entry = getpwuid(user);
    if (entry)
        return entry->pw_name;
    snprintf(room, 32, "user %u", user);
    return room;
}

static connection_t *make_connection(int fd, const char *path, const char *who)
{
    const struct timeval wait = {.tv_usec = WAIT_MS * 1000};
    connection_t *connection = calloc(1, sizeof *connection);
    (void)setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &wait, sizeof wait);
    if (connection) {
        connection->fd = fd;
        snprintf(connection->path, sizeof connection->path, "%s", path);
        return connection;
    }
    fprintf(stderr, "%s: not enough memory\n", who);
    close(fd);
    return NULL;
}

typedef struct visit {
    const char *who;
    bool (*found)(void *ctx, connection_t *connection, const char *path);
    void *ctx;
} visit_t;

static bool visit(void *ctx, const char *path)
{
    const visit_t *visit = ctx;
    uid_t owner;
    int fd = ect_endpoint_connect(path, &owner);
    if (fd < 0) {
        ect_endpoint_clear(path);
        return true;
    }
    if (owner != geteuid()) {
        close(fd);
        return true;
    }
    connection_t *connection = make_connection(fd, path, visit->who);
    return connection && visit->found(visit->ctx, connection, path);
}

bool connection_each(const char *who, bool (*found)(void *ctx, connection_t *connection, const char *path), void *ctx)
{
    char folder[ECT_ENDPOINT_PATH];
    visit_t all = {.who = who, .found = found, .ctx = ctx};
    signal(SIGPIPE, SIG_IGN); /* a twin that closes the connection may have sent the reason */
    if (ect_endpoint_folder(folder) < 0) {
        fprintf(stderr, "%s: XDG_RUNTIME_DIR is too long\n", who);
        return false;
    }
    if (ect_endpoint_trust(folder) == 0) {
        ect_endpoint_each(folder, visit, &all);
    } else if (errno == EPERM) {
        fprintf(stderr, "%s: '%s' belongs to another user, or others may write to it: no twin in it is trusted\n", who,
                folder);
        return false;
    }
    return true;
}

typedef struct search {
    const char *who, *iface;
    connection_t *connection;
    size_t alive;
} search_t;

static bool report_one(void *ctx, const char *path)
{
    bool *reported = ctx;
    uid_t owner;
    char room[32];
    int fd = ect_endpoint_connect(path, &owner);
    if (fd < 0)
        return true;
    close(fd);
    fprintf(stderr, "  one of %s runs: -s ", name_of(owner, room));
    print_text(stderr, path);
    fputc('\n', stderr);
    *reported = true;
    return true;
}

/* Reports the folders of other users, readable only for these users and root. The star in the pattern is a user id. */
static void report_others(const char *pattern)
{
    glob_t found = {0};
    (void)glob(pattern, 0, NULL, &found);
    for (size_t i = 0; i < found.gl_pathc; i++) {
        struct stat info;
        char room[32], theirs[64];
        bool reported = false;
        if (lstat(found.gl_pathv[i], &info) < 0 || !S_ISDIR(info.st_mode) || info.st_uid == geteuid())
            continue;
        snprintf(theirs, sizeof theirs, "%.*s%u%s", (int)strcspn(pattern, "*"), pattern, info.st_uid,
                 strchr(pattern, '*') + 1);
        if (strcmp(theirs, found.gl_pathv[i]) != 0)
            continue;
        ect_endpoint_each(found.gl_pathv[i], report_one, &reported);
        if (!reported && access(found.gl_pathv[i], R_OK) < 0)
            fprintf(stderr, "  %s may have some, in %s: run the command as that user, or with sudo\n",
                    name_of(info.st_uid, room), found.gl_pathv[i]);
    }
    globfree(&found);
}

/* Connects to a socket that the user has named. */
static int connect_to(const char *path, const char *who)
{
    uid_t owner;
    char room[32];
    int fd = ect_endpoint_connect(path, &owner);
    if (fd < 0) {
        fprintf(stderr, "%s: no twin answers at '%s': %s\n", who, path, strerror(errno));
        return -1;
    }
    if (owner == geteuid() || owner == 0 || geteuid() == 0)
        return fd;
    fprintf(stderr, "%s: '%s' is served by %s, not by you: not trusted\n", who, path, name_of(owner, room));
    close(fd);
    return -1;
}

void connection_close(connection_t *connection)
{
    close(connection->fd);
    free(connection);
}

/* Removes the first line from `received` and copies it without its line feed. @return false: no complete line */
static bool take_line(connection_t *c, char line[LINE_ROOM])
{
    const char *end = memchr(c->received, '\n', c->used);
    if (!end && c->used < sizeof c->received)
        return false;
    size_t length = end ? (size_t)(end - c->received) : c->used - 1; /* a longer line is truncated */
    memcpy(line, c->received, length);
    line[length] = 0;
    c->used -= length + 1;
    memmove(c->received, c->received + length + 1, c->used);
    return true;
}

/* Waits for more bytes. @return false: connection closed or failed (errno; EAGAIN: timeout) */
static bool receive(connection_t *c)
{
    unsigned int waits = 0;
    ssize_t got;
    do
        got = recv(c->fd, c->received + c->used, sizeof c->received - c->used, 0);
    while (got < 0 && (errno == EINTR || (errno == EAGAIN && ++waits < WAITS)));
    errno = got == 0 ? 0 : errno;
    c->used += got > 0 ? (size_t)got : 0;
    return got > 0;
}

/* --- requests ----------------------------------------------------------------------------------------------------- */

const char *connection_text(const cJSON *line, const char *member, char room[32])
{
    const cJSON *value = cJSON_GetObjectItemCaseSensitive(line, member);
    if (cJSON_IsString(value) || (cJSON_IsNumber(value) && value->valuestring))
        return value->valuestring;
    room[0] = 0;
    if (cJSON_IsNumber(value))
        snprintf(room, 32, "%.15g", value->valuedouble);
    return room;
}

/* After a failed receive(). */
static int no_reply(const char *who)
{
    if (!who)
        return EXIT_RUN;
    if (errno == EAGAIN || errno == EWOULDBLOCK)
        fprintf(stderr, "%s: the twin does not answer: it is stopped, or very busy\n", who);
    else
        fprintf(stderr, "%s: the twin has ended, or has closed this connection\n", who);
    return EXIT_RUN;
}

/* EPIPE is no error: the reader of standard output needs no more. Other failures are reported by atexit(). */
static int output_failed(void)
{
    if (errno != EPIPE)
        return EXIT_RUN;
    clearerr(stdout);
    return EXIT_CLEAN;
}

/* Parses a line. An integer beyond the precision of cJSON becomes a string, as the "value". */
static cJSON *parse_line(const char *raw)
{
    enum { EXACT = 15 };
    static const char member[] = "\"value\":";
    cJSON *line = cJSON_Parse(raw);
    cJSON *value = cJSON_GetObjectItemCaseSensitive(line, "value");
    const char *digits = strstr(raw, member);
    digits = digits ? digits + strlen(member) : "";
    size_t length = strspn(digits, "-0123456789");
    if (length <= EXACT || !cJSON_IsNumber(value) || !strchr(",}", digits[length]))
        return line;
    value->valuestring = cJSON_malloc(length + 1); /* cJSON_Delete frees it */
    if (value->valuestring)
        snprintf(value->valuestring, length + 1, "%s", digits);
    return line;
}

/* Handles a line of a reply. @return the status of the request; -1: more lines follow */
static int take_reply(const char *raw, const char *who, void (*print)(const cJSON *line))
{
    char room[32];
    cJSON *line = parse_line(raw);
    const cJSON *ok = cJSON_GetObjectItemCaseSensitive(line, "ok");
    int status = -1;
    if (cJSON_IsBool(ok)) {
        status = cJSON_IsTrue(ok) ? EXIT_CLEAN : EXIT_USAGE;
        if (status != EXIT_CLEAN && who) {
            fprintf(stderr, "%s: ", who);
            print_text(stderr, connection_text(line, "message", room));
            fputc('\n', stderr);
        }
    } else if (print) {
        print(line);
    }
    cJSON_Delete(line);
    return status;
}

static int take_replies(connection_t *connection, const char *who, void (*print)(const cJSON *line))
{
    char line[LINE_ROOM];
    for (;;) {
        while (take_line(connection, line)) {
            int status = take_reply(line, who, print);
            if (status >= 0)
                return status;
            if (ferror(stdout))
                return output_failed();
        }
        if (!receive(connection))
            return no_reply(who);
    }
}

static bool send_text(const connection_t *connection, const char *text, size_t length)
{
    while (length > 0) {
        ssize_t sent = send(connection->fd, text, length, MSG_NOSIGNAL);
        if (sent < 0 && errno != EINTR)
            return false;
        text += sent > 0 ? sent : 0;
        length -= sent > 0 ? (size_t)sent : 0;
    }
    return true;
}

int connection_request(connection_t *connection, cJSON *request, const char *who, void (*print)(const cJSON *line))
{
    char *text = cJSON_PrintUnformatted(request);
    bool fits = text && strlen(text) < ECT_ENDPOINT_REQUEST;
    if (!fits && who)
        fprintf(stderr, "%s: too much for one request (%d characters): set fewer signals at once\n", who,
                ECT_ENDPOINT_REQUEST - 1);
    if (fits &&
        send_text(connection, text, strlen(text))) /* after a failure, the reason may already have been received */
        (void)send_text(connection, "\n", 1);
    cJSON_free(text);
    cJSON_Delete(request);
    return fits ? take_replies(connection, who, print) : EXIT_USAGE;
}

static int64_t clock_ms(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (int64_t)now.tv_sec * 1000 + now.tv_nsec / 1000000;
}

/* Waits for the twin, or for the end of standard output's reader. @return FOLLOW_MET: data can be received */
static int wait_for_more(const connection_t *connection, const follow_t *follow, int64_t end_ms)
{
    struct pollfd fds[] = {{.fd = connection->fd, .events = POLLIN}, {.fd = follow->quiet ? -1 : STDOUT_FILENO}};
    int count;
    do {
        int64_t left_ms = end_ms - clock_ms();
        left_ms = left_ms < 0 ? 0 : left_ms > INT32_MAX ? INT32_MAX : left_ms;
        count = poll(fds, 2, follow->timeout_ms < 0 ? -1 : (int)left_ms);
    } while (count < 0 && errno == EINTR);
    if (count == 0)
        return FOLLOW_TIMEOUT;
    return (fds[1].revents & (POLLERR | POLLHUP)) == 0 ? FOLLOW_MET : FOLLOW_UNREAD;
}

static bool is_met(const follow_t *follow, const char *line)
{
    cJSON *parsed = follow->met ? parse_line(line) : NULL;
    bool met = parsed && follow->met(follow->ctx, parsed);
    cJSON_Delete(parsed);
    return met;
}

int connection_follow(connection_t *connection, const char *who, const follow_t *follow)
{
    char line[LINE_ROOM];
    int64_t end_ms = clock_ms() + follow->timeout_ms;
    for (;;) {
        while (take_line(connection, line)) {
            if (!follow->quiet)
                print_json(line);
            if (ferror(stdout))
                return output_failed() == EXIT_CLEAN ? FOLLOW_UNREAD : EXIT_RUN;
            if (is_met(follow, line))
                return FOLLOW_MET;
        }
        int status = wait_for_more(connection, follow, end_ms);
        if (status != FOLLOW_MET)
            return status;
        if (!receive(connection))
            return no_reply(who);
    }
}

/* --- selection ---------------------------------------------------------------------------------------------------- */

static cJSON *about;

static void keep_about(const cJSON *line)
{
    cJSON_Delete(about);
    about = cJSON_Duplicate(line, true);
}

cJSON *connection_about(connection_t *connection)
{
    cJSON *request = cJSON_CreateObject();
    cJSON_AddStringToObject(request, "op", "about");
    about = NULL;
    (void)connection_request(connection, request, NULL, keep_about);
    return about;
}

static bool answers_on(connection_t *connection, const char *iface)
{
    char room[32];
    cJSON *line = connection_about(connection);
    bool found = strcmp(connection_text(line, "iface", room), iface) == 0 ||
                 strcmp(connection_text(line, "iface2", room), iface) == 0;
    cJSON_Delete(line);
    return found;
}

static bool take_only_one(void *ctx, connection_t *connection, const char *path)
{
    search_t *search = ctx;
    if (search->iface && !answers_on(connection, search->iface)) {
        connection_close(connection);
        return true;
    }
    search->alive++;
    if (search->alive == 1) {
        search->connection = connection;
        return true;
    }
    fprintf(stderr, "%s: several twins are running: 'ectwin ps' lists them; choose one with -s, e.g. -s ", search->who);
    print_text(stderr, path);
    fputc('\n', stderr);
    connection_close(connection);
    connection_close(search->connection);
    search->connection = NULL;
    return false;
}

static connection_t *find(const connection_choice_t *choice, const char *who)
{
    search_t search = {.who = who, .iface = choice->iface};
    if (!connection_each(who, take_only_one, &search))
        return NULL;
    if (search.alive == 0 && choice->iface) {
        fprintf(stderr, "%s: no twin of yours answers on '%s': 'ectwin ps' lists them\n", who, choice->iface);
    } else if (search.alive == 0) {
        fprintf(stderr, "%s: no twin of yours is running: start one with 'ectwin run' or 'ectwin with'\n", who);
        report_others("/tmp/ectwin-*");
        report_others("/run/user/*/ectwin");
    }
    return search.connection;
}

/* A name or a process id selects a socket in this user's folder. */
static connection_t *connect_to_named(const char *name, const char *who)
{
    char path[ECT_ENDPOINT_PATH];
    uid_t owner;
    int fd = ect_endpoint_find(name, path) == 0 ? ect_endpoint_connect(path, &owner) : -1;
    if (fd >= 0 && owner == geteuid())
        return make_connection(fd, path, who);
    if (fd >= 0)
        close(fd);
    fprintf(stderr, "%s: no twin of yours has the name or the process id '%s': 'ectwin ps' lists them\n", who, name);
    return NULL;
}

connection_t *connection_open(const connection_choice_t *choice, const char *who)
{
    const char *path = choice->twin || choice->iface ? choice->twin : getenv("ECTWIN_SOCKET");
    signal(SIGPIPE, SIG_IGN); /* a twin that closes the connection may have sent the reason */
    if (!path)
        return find(choice, who);
    if (choice->twin && !strchr(path, '/'))
        return connect_to_named(path, who);
    int fd = connect_to(path, who);
    return fd < 0 ? NULL : make_connection(fd, path, who);
}

void connection_path(const connection_t *connection, char *path, size_t room)
{
    *path = 0;
    if (strlen(connection->path) < room)
        strcpy(path, connection->path);
}

pid_t connection_process(const connection_t *connection)
{
    struct ucred peer = {0};
    socklen_t size = sizeof peer;
    (void)getsockopt(connection->fd, SOL_SOCKET, SO_PEERCRED, &peer, &size);
    return peer.pid;
}

const char *connection_slave(const struct argp_state *state, const char *text, unsigned int minimum)
{
    uint64_t number = 0;
    size_t length = ect_name_begins(text);
    if (!ect_number(text, minimum, UINT16_MAX, &number) && (length == 0 || text[length] != 0))
        argp_error(state, "--slave takes a number from %u to %d or the name of a twin, not '%s'", minimum, UINT16_MAX,
                   text);
    return text;
}

void connection_add_slave(cJSON *request, const char *slave)
{
    uint64_t number = 0;
    if (ect_number(slave, 0, UINT16_MAX, &number))
        cJSON_AddNumberToObject(request, "slave", (double)number);
    else
        cJSON_AddStringToObject(request, "slave", slave);
}

void connection_full_name(const cJSON *line, char name[CONNECTION_NAME])
{
    char room[32];
    const char *twin = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(line, "twin"));
    snprintf(name, CONNECTION_NAME, "%s%s%s", twin ? twin : "", twin ? "." : "", connection_text(line, "name", room));
}

static error_t parse(int key, char *text, struct argp_state *state)
{
    connection_choice_t *choice = state->input;
    switch (key) {
    case 's':
        choice->twin = text;
        return 0;
    case 'i':
        choice->iface = text;
        return 0;
    case ARGP_KEY_END:
        if (choice->twin && choice->iface)
            argp_error(state, "-s and -i both choose the twin: leave one of them out");
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static const struct argp_option options[] = {
    {"socket", 's', "NAME", 0,
     "Name or process id of the twin, as 'ectwin ps' lists them, or the path of its socket (default: $ECTWIN_SOCKET, "
     "or "
     "the only running twin)",
     0},
    {"interface", 'i', "IFACE", 0, "The twin that answers on this interface, in place of -s", 0},
    {0}};

const struct argp connection_argp = {.options = options, .parser = parse};

const struct argp_child connection_children[] = {{&connection_argp, 0, "The twin:", 1}, {0}};
