/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "support/control_bench.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "bus/chain/catalogue.h"
#include "bus/control/client.h"

bench_work_t work;
bool refuses_events;
bool refuses_memory;
int receive_error;

ssize_t __real_recv(int fd, void *buffer, size_t size, int flags);
ssize_t __wrap_recv(int fd, void *buffer, size_t size, int flags);
void *__real_calloc(size_t count, size_t size);
void *__wrap_calloc(size_t count, size_t size);
ssize_t __real_send(int fd, const void *data, size_t size, int flags);
ssize_t __wrap_send(int fd, const void *data, size_t size, int flags);
int __real_accept4(int fd, struct sockaddr *address, socklen_t *size, int flags);
int __wrap_accept4(int fd, struct sockaddr *address, socklen_t *size, int flags);
int __real_epoll_wait(int fd, struct epoll_event *events, int room, int timeout);
int __wrap_epoll_wait(int fd, struct epoll_event *events, int room, int timeout);
int __real_epoll_ctl(int fd, int operation, int of, struct epoll_event *event);
int __wrap_epoll_ctl(int fd, int operation, int of, struct epoll_event *event);
int __real_fnmatch(const char *pattern, const char *text, int flags);
int __wrap_fnmatch(const char *pattern, const char *text, int flags);
void __real_ect_lamps_update(ect_lamps_t *lamps, const ect_slave_t *slave, bool in_link, bool out_link,
                             uint64_t last_frame_ns, uint64_t now_ns);
void __wrap_ect_lamps_update(ect_lamps_t *lamps, const ect_slave_t *slave, bool in_link, bool out_link,
                             uint64_t last_frame_ns, uint64_t now_ns);

ssize_t __wrap_recv(int fd, void *buffer, size_t size, int flags)
{
    work.receives++;
    if (receive_error != 0) {
        errno = receive_error;
        receive_error = 0;
        return -1;
    }
    return __real_recv(fd, buffer, size, flags);
}

void *__wrap_calloc(size_t count, size_t size)
{
    return refuses_memory ? NULL : __real_calloc(count, size);
}

ssize_t __wrap_send(int fd, const void *data, size_t size, int flags)
{
    ssize_t sent = __real_send(fd, data, size, flags);
    work.sends++;
    work.sent += sent > 0 ? (size_t)sent : 0;
    return sent;
}

int __wrap_accept4(int fd, struct sockaddr *address, socklen_t *size, int flags)
{
    work.accepts++;
    return __real_accept4(fd, address, size, flags);
}

int __wrap_epoll_wait(int fd, struct epoll_event *events, int room, int timeout)
{
    work.waits++;
    return __real_epoll_wait(fd, events, room, timeout);
}

int __wrap_epoll_ctl(int fd, int operation, int of, struct epoll_event *event)
{
    errno = ENOSPC;
    return refuses_events && operation == EPOLL_CTL_ADD ? -1 : __real_epoll_ctl(fd, operation, of, event);
}

int __wrap_fnmatch(const char *pattern, const char *text, int flags)
{
    work.matches++;
    return __real_fnmatch(pattern, text, flags);
}

void __wrap_ect_lamps_update(ect_lamps_t *lamps, const ect_slave_t *slave, bool in_link, bool out_link,
                             uint64_t last_frame_ns, uint64_t now_ns)
{
    work.lamps++;
    __real_ect_lamps_update(lamps, slave, in_link, out_link, last_frame_ns, now_ns);
}
/* --- a chain and its socket --------------------------------------------------------------------------------------- */

enum { MOST_CALLS = 200000 };

static unsigned int open_descriptors(void)
{
    unsigned int count = 0;
    for (int fd = 0; fd < 256; fd++)
        count += fcntl(fd, F_GETFD) >= 0;
    return count;
}

void open_bench(bench_t *b, const char *device, size_t count)
{
    ect_twin_config_t twins[16];
    char message[ECT_ENDPOINT_MESSAGE];
    const ect_product_t *product = ect_catalogue_find(device);
    memset(b, 0, sizeof *b);
    b->descriptors = open_descriptors();
    for (size_t i = 0; i < count; i++)
        twins[i] = ect_twin_default(product->device, product->plant);
    wire_open_twins(&b->wire, twins, count);
    strcpy(b->folder, "/tmp/test-ectwin-XXXXXX");
    assert_non_null(mkdtemp(b->folder));
    setenv("XDG_RUNTIME_DIR", b->folder, 1);
    b->control = ect_control_open(NULL, message);
    if (!b->control)
        fail_msg("%s", message);
}

void close_bench(bench_t *b)
{
    char path[128];
    ect_control_close(b->control);
    wire_close(&b->wire);
    assert_int_equal(open_descriptors(), b->descriptors);
    snprintf(path, sizeof path, "%s/ectwin", b->folder);
    assert_int_equal(rmdir(path), 0); /* the socket is gone, and nothing else was left there */
    assert_int_equal(rmdir(b->folder), 0);
}

int connect_client(const bench_t *b)
{
    uid_t owner;
    int fd = ect_endpoint_connect(ect_control_path(b->control), &owner);
    assert_true(fd >= 0);
    assert_int_equal(owner, geteuid());
    return fd;
}

bool wants_to_be_served(const bench_t *b)
{
    struct pollfd fd = {.fd = ect_control_fd(b->control), .events = POLLIN};
    return ect_control_due(b->control) <= b->wire.now_ns || poll(&fd, 1, 0) > 0;
}

void serve_once(bench_t *b)
{
    memset(&work, 0, sizeof work);
    ect_control_serve(b->control, b->wire.chain, b->wire.now_ns);
    assert_true(work.receives <= 1);
    assert_true(work.sends <= 1);
    assert_true(work.accepts <= 2); /* the second one refuses a client for lack of descriptors */
    assert_int_equal(work.waits, 1);
    assert_true(work.matches <= ECT_CLIENT_MATCHES);
    assert_true(work.sent <= ECT_CLIENT_ANSWER);
}

unsigned int serve(bench_t *b)
{
    unsigned int calls = 0;
    while (wants_to_be_served(b)) {
        serve_once(b);
        if (++calls == MOST_CALLS)
            fail_msg("the socket never becomes idle");
    }
    return calls;
}

void send_text(int fd, const char *text)
{
    assert_int_equal(write(fd, text, strlen(text)), (ssize_t)strlen(text));
}

size_t receive_text(int fd, char *text, size_t room)
{
    size_t used = 0;
    ssize_t got;
    while (used + 1 < room && (got = read(fd, text + used, room - 1 - used)) > 0)
        used += (size_t)got;
    text[used] = 0;
    return used;
}

void set_nonblocking(int fd)
{
    assert_int_equal(fcntl(fd, F_SETFL, O_NONBLOCK), 0);
}

size_t count_of(const char *text, const char *part)
{
    size_t count = 0;
    for (const char *at = strstr(text, part); at; at = strstr(at + 1, part))
        count++;
    return count;
}

void expect_answer(bench_t *b, const char *request, const char *want)
{
    static char got[ANSWER_ROOM];
    int fd = connect_client(b);
    set_nonblocking(fd);
    send_text(fd, request);
    serve(b);
    receive_text(fd, got, sizeof got);
    if (strcmp(got, want) != 0)
        fail_msg("%s\nexpected %s\ngot      %s", request, want, got);
    close(fd);
    serve(b);
}

void expect_part(bench_t *b, const char *request, const char *part)
{
    static char got[ANSWER_ROOM];
    int fd = connect_client(b);
    set_nonblocking(fd);
    send_text(fd, request);
    serve(b);
    receive_text(fd, got, sizeof got);
    if (!strstr(got, part))
        fail_msg("%s\nexpected a part %s\ngot             %s", request, part, got);
    close(fd);
    serve(b);
}
