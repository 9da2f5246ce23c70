/* SPDX-License-Identifier: MIT */
/* The search for control sockets (finder.h), in a folder of the test. */
#define _GNU_SOURCE
#include "finder.h"

#include <fcntl.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cmocka.h>

enum { MOST = BUS_MOST + 8 };

static char runtime[] = "/tmp/ectwin-finder-XXXXXX", folder[64];
static buses_t buses;
static int listeners[MOST];
static size_t listening;
static unsigned int taken;
static int strangers; /* connections whose other end has another owner */
static int last_fd;

int __real_ect_endpoint_connect_now(const char *path, uid_t *owner);
int __wrap_ect_endpoint_connect_now(const char *path, uid_t *owner);

int __wrap_ect_endpoint_connect_now(const char *path, uid_t *owner)
{
    const int fd = __real_ect_endpoint_connect_now(path, owner);
    if (strangers > 0 && fd >= 0) {
        strangers--;
        *owner += 1;
    }
    last_fd = fd;
    return fd;
}

static void take(void *ctx, bus_t *bus, int fd, long process)
{
    assert_ptr_equal(ctx, &taken);
    assert_int_equal(process, getpid());
    assert_int_equal(fcntl(fd, F_GETFL) & O_NONBLOCK, O_NONBLOCK);
    close(fd);
    bus->socket = bus;
    taken++;
}

static const char *path_of(const char *name)
{
    static char path[128];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

static int begin(void **state)
{
    (void)state;
    memset(&buses, 0, sizeof buses);
    listening = 0;
    taken = 0;
    strangers = 0;
    strcpy(runtime + strlen(runtime) - 6, "XXXXXX");
    if (!mkdtemp(runtime) || setenv("XDG_RUNTIME_DIR", runtime, 1) != 0)
        return -1;
    snprintf(folder, sizeof folder, "%s/ectwin", runtime);
    return mkdir(folder, 0700);
}

static void stop_listening(void)
{
    while (listening > 0)
        close(listeners[--listening]);
}

static int finish(void **state)
{
    char line[128];
    (void)state;
    stop_listening();
    for (size_t i = 0; i < buses.count; i++) {
        table_clear(&buses.all[i]->table);
        free(buses.all[i]);
    }
    snprintf(line, sizeof line, "rm -r %s", runtime);
    return system(line);
}

static void listen_at(const char *name)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    const int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    strcpy(address.sun_path, path_of(name));
    assert_true(listening < MOST);
    assert_int_equal(bind(fd, (const struct sockaddr *)&address, sizeof address), 0);
    assert_int_equal(listen(fd, 4), 0);
    listeners[listening++] = fd;
}

static void search(void)
{
    finder_search(&buses, take, &taken);
}

static bool has(const char *name)
{
    size_t found = 0;
    for (size_t i = 0; i < buses.count; i++)
        found += strcmp(buses.all[i]->path, path_of(name)) == 0;
    assert_in_range(found, 0, 1);
    return found == 1;
}

static void each_once(void **state)
{
    (void)state;
    search();
    assert_int_equal(buses.count, 0);
    listen_at("a.sock");
    listen_at("b.sock");
    listen_at("c.txt");
    for (int times = 0; times < 3; times++) {
        search();
        assert_int_equal(buses.count, 2);
        assert_true(has("a.sock") && has("b.sock"));
        assert_int_equal(buses.all[0]->number + buses.all[1]->number, 1 + 2);
        assert_int_equal(taken, 2); /* connected once */
    }
    listen_at("d.sock");
    buses.all[0]->socket = NULL;
    search();
    assert_int_equal(buses.count, 3);
    assert_int_equal(buses.all[2]->number, 3);
    assert_int_equal(taken, 4);
    assert_int_equal(buses.changes, 0); /* a bus is new when it has described itself */
}

static void ends(void **state)
{
    static const char text[] = "{\"slave\":1,\"name\":\"a\",\"value\":1}";
    (void)state;
    listen_at("a.sock");
    search();
    listen_at("b.sock");
    search();
    listen_at("c.sock");
    search();
    cJSON *line = cJSON_Parse(text);
    assert_true(table_add(&buses.all[0]->table, text, line)); /* which is given back */
    cJSON_Delete(line);
    unlink(path_of("a.sock"));
    unlink(path_of("b.sock"));
    search();
    assert_int_equal(buses.count, 3); /* their connections exist */
    buses.all[0]->socket = NULL;
    buses.all[1]->socket = NULL;
    buses.all[1]->trace.socket = &buses;
    search();
    assert_int_equal(buses.count, 2);
    assert_int_equal(buses.changes, 1);
    assert_true(has("b.sock") && has("c.sock") && !has("a.sock"));
    buses.all[0]->trace.socket = NULL;
    search();
    assert_int_equal(buses.count, 1);
    assert_int_equal(buses.changes, 2);
    listen_at("a.sock"); /* one of the same name is another bus */
    search();
    assert_int_equal(buses.count, 2);
    assert_int_equal(buses.all[1]->number, 4);
}

static void bounded(void **state)
{
    char name[32];
    (void)state;
    for (int i = 0; i < MOST; i++) {
        snprintf(name, sizeof name, "t%d.sock", i);
        listen_at(name);
    }
    search();
    assert_int_equal(buses.count, BUS_MOST);
    assert_int_equal(taken, BUS_MOST);
    bus_t *first = buses.all[0];
    unlink(first->path);
    first->socket = NULL;
    search();
    assert_int_equal(buses.count, BUS_MOST); /* one has ended, another one has its place */
    assert_int_equal(buses.all[BUS_MOST - 1]->number, BUS_MOST + 1);
    assert_int_equal(taken, BUS_MOST + 1);
}

/* A twin that was killed leaves its socket. */
static void left_behind(void **state)
{
    (void)state;
    listen_at("a.sock");
    stop_listening();
    search();
    assert_int_equal(taken, 0);
    assert_int_equal(access(path_of("a.sock"), F_OK), -1);
    search();
    assert_int_equal(buses.count, 0);
}

static void strangers_sockets(void **state)
{
    (void)state;
    listen_at("a.sock");
    strangers = 2;
    for (int times = 0; times < 2; times++) {
        search();
        assert_int_equal(taken, 0);
        assert_true(last_fd >= 0);
        assert_int_equal(fcntl(last_fd, F_GETFD), -1); /* closed */
    }
    finder_connect(buses.all[0], take, &taken);
    assert_int_equal(taken, 1);
}

/* A program without standard input gets descriptor 0 for a connection. */
static void descriptor_0(void **state)
{
    const int before = dup(STDIN_FILENO);
    (void)state;
    listen_at("a.sock");
    close(STDIN_FILENO);
    search();
    assert_int_equal(last_fd, STDIN_FILENO);
    assert_int_equal(taken, 1);
    (void)dup2(before, STDIN_FILENO);
    close(before);
}

/* A folder that others can write, and one whose name is too long. */
static void folders(void **state)
{
    char name[ECT_ENDPOINT_PATH + 16];
    (void)state;
    listen_at("a.sock");
    chmod(folder, 0770);
    search();
    assert_int_equal(buses.count, 0);
    chmod(folder, 0700);
    memset(name, 'x', sizeof name);
    name[0] = '/';
    name[sizeof name - 1] = 0;
    setenv("XDG_RUNTIME_DIR", name, 1);
    search();
    assert_int_equal(buses.count, 0);
    setenv("XDG_RUNTIME_DIR", runtime, 1);
    search();
    assert_int_equal(buses.count, 1);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"Each control socket is one bus, which is connected once", each_once, begin, finish, NULL},
        {"A bus is removed when its socket is gone and its connections have ended", ends, begin, finish, NULL},
        {"SEC: buses are bounded", bounded, begin, finish, NULL},
        {"A socket without a process is removed", left_behind, begin, finish, NULL},
        {"A connection may have descriptor 0", descriptor_0, begin, finish, NULL},
        {"SEC: sockets of other users are not used", strangers_sockets, begin, finish, NULL},
        {"SEC: a folder that others can write is not searched", folders, begin, finish, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Panel: finder", tests, NULL, NULL);
}
