/* SPDX-License-Identifier: MIT */
/* The control socket: its replies, and the bounded work between two checks of the wire (control.h). */
#define _GNU_SOURCE
#include "bus/control/control.h"

#include <cjson/cJSON.h>
#include <fcntl.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include "bus/chain/catalogue.h"
#include "bus/chain/lamps.h"
#include "bus/control/client.h"
#include "support/wire.h"

/* The system calls of one ect_control_serve: the linker leads them through here (tests/CMakeLists.txt). */
static struct {
    unsigned int receives, sends, accepts, waits, matches, lamps;
    size_t sent;
} work;

ssize_t __real_recv(int fd, void *buffer, size_t size, int flags);
ssize_t __wrap_recv(int fd, void *buffer, size_t size, int flags);
ssize_t __real_send(int fd, const void *data, size_t size, int flags);
ssize_t __wrap_send(int fd, const void *data, size_t size, int flags);
int __real_accept4(int fd, struct sockaddr *address, socklen_t *size, int flags);
int __wrap_accept4(int fd, struct sockaddr *address, socklen_t *size, int flags);
int __real_epoll_wait(int fd, struct epoll_event *events, int room, int timeout);
int __wrap_epoll_wait(int fd, struct epoll_event *events, int room, int timeout);
int __real_fnmatch(const char *pattern, const char *text, int flags);
int __wrap_fnmatch(const char *pattern, const char *text, int flags);
void __real_ect_lamps_update(ect_lamps_t *lamps, const ect_slave_t *slave, bool in_link, bool out_link,
                             uint64_t last_frame_ns, uint64_t now_ns);
void __wrap_ect_lamps_update(ect_lamps_t *lamps, const ect_slave_t *slave, bool in_link, bool out_link,
                             uint64_t last_frame_ns, uint64_t now_ns);

ssize_t __wrap_recv(int fd, void *buffer, size_t size, int flags)
{
    work.receives++;
    return __real_recv(fd, buffer, size, flags);
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

enum { ANSWER_ROOM = 4 * 1024 * 1024, MOST_CALLS = 200000 };

typedef struct bench {
    wire_t wire;
    ect_control_t *control;
    char folder[64];
} bench_t;

static void open_bench(bench_t *b, const char *device, size_t count)
{
    ect_twin_config_t twins[16];
    char message[ECT_ENDPOINT_MESSAGE];
    const ect_product_t *product = ect_catalogue_find(device);
    memset(b, 0, sizeof *b);
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

static void close_bench(bench_t *b)
{
    char path[128];
    ect_control_close(b->control);
    wire_close(&b->wire);
    snprintf(path, sizeof path, "%s/ectwin", b->folder);
    assert_int_equal(rmdir(path), 0); /* the socket is gone, and nothing else was left there */
    assert_int_equal(rmdir(b->folder), 0);
}

static int connect_client(const bench_t *b)
{
    uid_t owner;
    int fd = ect_endpoint_connect(ect_control_path(b->control), &owner);
    assert_true(fd >= 0);
    assert_int_equal(owner, geteuid());
    return fd;
}

static bool wants_to_be_served(const bench_t *b)
{
    struct pollfd fd = {.fd = ect_control_fd(b->control), .events = POLLIN};
    return ect_control_due(b->control) <= b->wire.now_ns || poll(&fd, 1, 0) > 0;
}

/* One call, and that it was a bounded piece of work. */
static void serve_once(bench_t *b)
{
    memset(&work, 0, sizeof work);
    ect_control_serve(b->control, b->wire.chain, b->wire.now_ns);
    assert_true(work.receives <= 1);
    assert_true(work.sends <= 1);
    assert_true(work.accepts <= 2); /* the second one refuses a client for lack of descriptors */
    assert_int_equal(work.waits, 1);
    assert_true(work.matches <= ECT_CLIENT_LOOKS);
    assert_true(work.sent <= ECT_CLIENT_ANSWER);
}

/* Until nothing is left to do. @return how many calls it took */
static unsigned int serve(bench_t *b)
{
    unsigned int calls = 0;
    while (wants_to_be_served(b)) {
        serve_once(b);
        if (++calls == MOST_CALLS)
            fail_msg("the socket never comes to rest");
    }
    return calls;
}

static void say(int fd, const char *text)
{
    assert_int_equal(write(fd, text, strlen(text)), (ssize_t)strlen(text));
}

/* The bytes received so far, at most `room` - 1. */
static size_t hear(int fd, char *text, size_t room)
{
    size_t used = 0;
    ssize_t got;
    while (used + 1 < room && (got = read(fd, text + used, room - 1 - used)) > 0)
        used += (size_t)got;
    text[used] = 0;
    return used;
}

static void no_waiting(int fd)
{
    assert_int_equal(fcntl(fd, F_SETFL, O_NONBLOCK), 0);
}

static size_t count_of(const char *text, const char *part)
{
    size_t count = 0;
    for (const char *at = strstr(text, part); at; at = strstr(at + 1, part))
        count++;
    return count;
}

/* Asks on a connection of its own. */
static void expect_answer(bench_t *b, const char *request, const char *want)
{
    static char got[ANSWER_ROOM];
    int fd = connect_client(b);
    no_waiting(fd);
    say(fd, request);
    serve(b);
    hear(fd, got, sizeof got);
    if (strcmp(got, want) != 0)
        fail_msg("%s\nexpected %s\ngot      %s", request, want, got);
    close(fd);
    serve(b);
}

static void expect_part(bench_t *b, const char *request, const char *part)
{
    static char got[ANSWER_ROOM];
    int fd = connect_client(b);
    no_waiting(fd);
    say(fd, request);
    serve(b);
    hear(fd, got, sizeof got);
    if (!strstr(got, part))
        fail_msg("%s\nexpected a part %s\ngot             %s", request, part, got);
    close(fd);
    serve(b);
}

/* --- answers ------------------------------------------------------------------------------------------------------ */

#define OK "{\"ok\":true}\n"

static void answers(void **state)
{
    static const struct {
        const char *request, *want;
    } exact[] = {
        {"{\"op\":\"get\",\"pattern\":\"data1\"}\n", "{\"slave\":1,\"name\":\"data1\",\"value\":0}\n" OK},
        {"{\"op\":\"set\",\"name\":\"data1\",\"value\":\"-1.5\"}\n", OK},
        {"{\"op\":\"set\",\"name\":\"data1\",\"value\":-2.25}\n", OK},
        {"{\"op\":\"get\",\"pattern\":\"data[1]\"}\n", "{\"slave\":1,\"name\":\"data1\",\"value\":-2.25}\n" OK},
        {"{\"op\":\"set\",\"name\":\"run\",\"value\":true}\n", OK},
        {"{\"op\":\"set\",\"name\":\"comment1\",\"value\":\"a \\\"b\\\\ c\"}\n", OK},
        {"{\"op\":\"get\",\"pattern\":\"comment1\"}\n",
         "{\"slave\":1,\"name\":\"comment1\",\"value\":\"a \\\"b\\\\ c\"}\n" OK},
        {"{\"op\":\"set\",\"name\":\"scene\",\"value\":\"010\"}\n", OK},
        {"{\"op\":\"get\",\"pattern\":\"scene\"}\n", "{\"slave\":1,\"name\":\"scene\",\"value\":10}\n" OK},
        {"{\"op\":\"set\",\"name\":\"scene\",\"value\":\"0x0b\"}\n", OK},
        {"{\"op\":\"get\",\"pattern\":\"scene\",\"slave\":0}\n",
         "{\"slave\":1,\"name\":\"scene\",\"value\":11}\n{\"slave\":2,\"name\":\"scene\",\"value\":0}\n" OK},
        {"{\"op\":\"get\",\"pattern\":\"scene\",\"slave\":2}\n", "{\"slave\":2,\"name\":\"scene\",\"value\":0}\n" OK},
        {"{\"op\":\"get\",\"pattern\":\"ecat.state\"}\n", "{\"slave\":1,\"name\":\"ecat.state\",\"value\":1}\n" OK},
        {"{\"op\":\"watch\",\"pattern\":\"gate\"}\n",
         "{\"slave\":1,\"name\":\"gate\",\"value\":0,\"time\":1.000000}\n" OK},
    };
    static const struct {
        const char *request, *part;
    } refused[] = {
        {"\n", "{\"ok\":false,\"message\":\"a request is"},
        {"nonsense\n", "a request is"},
        {"[1,2]\n", "a request is"},
        {"{\"op\":\"format\"}\n", "a request is"},
        {"{\"op\":7}\n", "a request is"},
        {"{\"op\":\"get\",\"slave\":3}\n", "no such slave"},
        {"{\"op\":\"get\",\"slave\":1.5}\n", "no such slave"},
        {"{\"op\":\"get\",\"slave\":\"1\"}\n", "no such slave"},
        {"{\"op\":\"get\",\"slave\":-1}\n", "no such slave"},
        {"{\"op\":\"set\",\"slave\":0,\"name\":\"scene\",\"value\":1}\n", "no such slave"},
        {"{\"op\":\"get\",\"pattern\":\"nosuch*\"}\n",
         "no signal of slave 1 matches 'nosuch*': 'ectwin list-signals -n 1' lists them; -n chooses one of 2 slaves"},
        {"{\"op\":\"get\",\"slave\":0,\"pattern\":\"nosuch*\"}\n", "no signal matches 'nosuch*': "},
        {"{\"op\":\"get\",\"pattern\":5}\n", "a text of at most 127"},
        {"{\"op\":\"set\",\"name\":\"nosuch\",\"value\":1}\n",
         "slave 1 has no signal 'nosuch': 'ectwin list-signals DEVICE' lists those of a device; -n chooses the slave"},
        {"{\"op\":\"set\",\"name\":\"datta1\",\"value\":1}\n", "no signal 'datta1'; did you mean 'data1'?"},
        {"{\"op\":\"set\",\"name\":\"ecat.plug_ni\",\"value\":1}\n", "did you mean 'ecat.plug_in'?"},
        {"{\"op\":\"set\",\"name\":\"x\",\"value\":1}\n", "lists those of a device"},
        {"{\"op\":\"set\",\"name\":\"scene\"}\n", "a value is"},
        {"{\"op\":\"set\",\"name\":\"scene\",\"value\":[1]}\n", "a value is"},
        {"{\"op\":\"set\"}\n", "takes"},
        {"{\"op\":\"set\",\"values\":{}}\n", "takes"},
        {"{\"op\":\"set\",\"name\":\"busy\",\"value\":1}\n", "the twin's own"},
        {"{\"op\":\"set\",\"name\":\"scene\",\"value\":1e300}\n", "takes 0.."},
        {"{\"op\":\"set\",\"name\":\"scene\",\"value\":\"\\u001b[31m\"}\n", "\\u001b"},
        {"{\"op\":\"list\",\"pattern\":\"data1\"}\n", "\"access\":\"rw\",\"range\":\"-999999999..999999999\""},
    };
    bench_t b;
    (void)state;
    open_bench(&b, "fzm1", 2);
    for (size_t i = 0; i < sizeof exact / sizeof exact[0]; i++)
        expect_answer(&b, exact[i].request, exact[i].want);
    for (size_t i = 0; i < sizeof refused / sizeof refused[0]; i++)
        expect_part(&b, refused[i].request, refused[i].part);
    close_bench(&b);
}

/* Every line of every answer is JSON by itself, whatever the signal. */
/* Each counter with a value of its own. */
static void counted(void **state)
{
    static const ect_stats_t stats = {.start_ns = 400 * MS,
                                      .frames = 11,
                                      .answered = 12,
                                      .unanswered = 13,
                                      .stale = 14,
                                      .circling = 15,
                                      .dropped = 16,
                                      .delayed = 17,
                                      .answers = {[2] = 985, [6] = 10, [9] = 5},
                                      .longest_answer_ns = 18999,
                                      .polls = 19,
                                      .late_polls = 20,
                                      .latest_poll_ns = 21999};
    static ect_scenario_t scenario;
    bench_t b;
    (void)state;
    open_bench(&b, "fzm1", 1);
    expect_part(&b, "{\"op\":\"stats\"}\n", "{\"ok\":false,\"message\":\"nothing is counted here\"}");
    expect_part(&b, "{\"op\":\"fault\"}\n", "{\"ok\":false,\"message\":\"no faults can be set here\"}");
    ect_control_show(b.control, &stats, &scenario);
    b.wire.now_ns = 2150 * MS;
    expect_answer(&b, "{\"op\":\"stats\"}\n",
                  "{\"frames\":11,\"answered\":12,\"unanswered\":13,\"stale\":14,\"circling\":15,\"dropped\":16,"
                  "\"delayed\":17,\"p50_us\":5,\"p99_us\":100,\"longest_us\":18,\"polls\":19,\"late_polls\":20,"
                  "\"latest_poll_us\":21,\"time\":1.750000}\n"
                  "{\"answers\":[0,0,985,0,0,0,10,0,0,5,0,0,0,0,0,0,0,0,0,0],\"edges_us\":[1,2,5,10,20,50,100,200,500,"
                  "1000,2000,5000,10000,20000,50000,100000,200000,500000,1000000]}\n" OK);
    close_bench(&b);
}

static void about_the_twins(void **state)
{
    static const ect_about_t named = {
        .name = "bench", .devices = "fzm1,fzm1", .ifaces = {[ECT_END_IN] = "ecat0", [ECT_END_OUT] = "ecat1"}};
    static const ect_about_t plain = {.devices = "fzm1"};
    bench_t b;
    (void)state;
    open_bench(&b, "fzm1", 2);
    expect_part(&b, "{\"op\":\"about\"}\n", "{\"ok\":false,\"message\":\"this chain has no description\"}");
    ect_control_describe(b.control, &named);
    expect_answer(&b, "{\"op\":\"about\"}\n",
                  "{\"name\":\"bench\",\"devices\":\"fzm1,fzm1\",\"iface\":\"ecat0\",\"iface2\":\"ecat1\",\"slaves\":2,"
                  "\"lowest\":1,\"highest\":1,\"errors\":0}\n" OK);
    ect_control_describe(b.control, &plain);
    expect_answer(&b, "{\"op\":\"set\",\"slave\":2,\"name\":\"ecat.plug_in\",\"value\":0}\n", OK);
    expect_answer(&b, "{\"op\":\"about\"}\n",
                  "{\"devices\":\"fzm1\",\"slaves\":2,\"lowest\":1,\"highest\":1,\"errors\":0}\n" OK);
    close_bench(&b);
}

static void faults_by_request(void **state)
{
    static const struct {
        const char *request, *want;
    } rows[] = {
        {"{\"op\":\"fault\"}\n", OK},
        {"{\"op\":\"fault\",\"fault\":5}\n", "{\"ok\":false,\"message\":\"\\\"fault\\\" is a text, as in "
                                             "{\\\"op\\\":\\\"fault\\\",\\\"fault\\\":\\\"drop 5%\\\"}\"}\n"},
        {"{\"op\":\"fault\",\"fault\":\"drop 5%\"}\n", OK},
        {"{\"op\":\"fault\",\"fault\":\"delay 7us every 2\"}\n", OK},
        {"{\"op\":\"fault\",\"fault\":\"hang slave 1\"}\n", OK},
        {"{\"op\":\"fault\"}\n", "{\"fault\":\"drop 5%\"}\n{\"fault\":\"delay 7us every 2\"}\n" OK},
        {"{\"op\":\"fault\",\"fault\":\"hang slave 2\"}\n",
         "{\"ok\":false,\"message\":\"there is no slave 2: the chain has 1\"}\n"},
        {"{\"op\":\"fault\",\"fault\":\"off\"}\n", OK},
        {"{\"op\":\"fault\"}\n", OK},
    };
    static ect_stats_t stats;
    static ect_scenario_t scenario;
    bench_t b;
    (void)state;
    open_bench(&b, "fzm1", 1);
    ect_control_show(b.control, &stats, &scenario);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
        expect_answer(&b, rows[i].request, rows[i].want);
    close_bench(&b);
}

static void lines_are_json(void **state)
{
    static char got[ANSWER_ROOM];
    bench_t b;
    (void)state;
    open_bench(&b, "vr-bu-ect-map7", 1);
    int fd = connect_client(&b);
    no_waiting(fd);
    say(fd, "{\"op\":\"list\"}\n{\"op\":\"get\"}\n{\"op\":\"watch\"}\n");
    unsigned int lines = 0;
    for (unsigned int i = 0; i < 100; i++) {
        serve(&b);
        hear(fd, got, sizeof got);
        for (char *line = strtok(got, "\n"); line; line = strtok(NULL, "\n"), lines++) {
            cJSON *json = cJSON_Parse(line);
            if (!cJSON_IsObject(json))
                fail_msg("no JSON: %s", line);
            cJSON_Delete(json);
        }
    }
    assert_true(lines > 3 * 200);
    close(fd);
    serve(&b);
    close_bench(&b);
}

/* The controller sends a set of periodic data whose bytes count up. */
static void send_periodic(bench_t *b, uint16_t size)
{
    uint8_t out[228] = {0};
    wire_go(&b->wire, 0, ECT_STATE_OP);
    for (unsigned int at = 0; at < size; at += 200) {
        out[0]++;
        ect_store_be16(out + 24, size);
        out[26] = (uint8_t)(at / 200);
        for (unsigned int i = 0; i < 200; i++)
            out[28 + i] = (uint8_t)(at + i);
        assert_int_equal(wire_write(&b->wire, 0, 0x1000, out, sizeof out), 1);
    }
}

/* Too large for a signal, and for a line: it is given in pieces. */
static void data_in_pieces(void **state)
{
    static const struct {
        const char *request, *want;
    } exact[] = {
        {"{\"op\":\"data\",\"offset\":447}\n",
         "{\"slave\":1,\"serial\":1,\"size\":450,\"offset\":447,\"data\":\"bfc0c1\"}\n" OK},
        {"{\"op\":\"data\",\"offset\":450,\"slave\":1}\n",
         "{\"slave\":1,\"serial\":1,\"size\":450,\"offset\":450,\"data\":\"\"}\n" OK},
    };
    static const struct {
        const char *request, *part;
    } parts[] = {
        {"{\"op\":\"data\"}\n", "\"offset\":0,\"data\":\"00010203"},
        {"{\"op\":\"data\"}\n", "8c8d8e8f\"}\n" OK}, /* byte 399 */
        {"{\"op\":\"data\",\"offset\":451}\n", "a number from 0 to the size"},
        {"{\"op\":\"data\",\"offset\":-1}\n", "a number from 0 to the size"},
        {"{\"op\":\"data\",\"offset\":1e300}\n", "a number from 0 to the size"},
        {"{\"op\":\"data\",\"offset\":\"0\"}\n", "a number from 0 to the size"},
        {"{\"op\":\"data\",\"slave\":0}\n", "no such slave"},
        {"{\"op\":\"data\",\"slave\":2}\n", "no such slave"},
    };
    bench_t b;
    (void)state;
    open_bench(&b, "vr-bu-ect-map7", 1);
    expect_part(&b, "{\"op\":\"data\"}\n", "{\"slave\":1,\"serial\":0,\"size\":0,\"offset\":0,\"data\":\"\"}\n" OK);
    send_periodic(&b, 450);
    for (size_t i = 0; i < sizeof exact / sizeof exact[0]; i++)
        expect_answer(&b, exact[i].request, exact[i].want);
    for (size_t i = 0; i < sizeof parts / sizeof parts[0]; i++)
        expect_part(&b, parts[i].request, parts[i].part);
    close_bench(&b);
    open_bench(&b, "vr-bu-ect-map3", 1);
    expect_part(&b, "{\"op\":\"data\"}\n", "has no data for this request");
    close_bench(&b);
    open_bench(&b, "fzm1", 1);
    expect_part(&b, "{\"op\":\"data\"}\n", "has no data for this request");
    close_bench(&b);
}

/* --- bounded work ------------------------------------------------------------------------------------------------- */

/* Several requests for everything in one write, from each of sixteen clients. serve_once() holds the bounds.
 */
static void pipelined_lists(void **state)
{
    static char got[ECT_CONTROL_CLIENTS][ANSWER_ROOM];
    enum { REQUESTS = 4, TWINS = 2 };
    size_t used[ECT_CONTROL_CLIENTS] = {0};
    int fds[ECT_CONTROL_CLIENTS];
    bench_t b;
    (void)state;
    open_bench(&b, "vr-bu-ect-map7", TWINS);
    for (size_t i = 0; i < ECT_CONTROL_CLIENTS; i++) {
        fds[i] = connect_client(&b);
        no_waiting(fds[i]);
        for (size_t n = 0; n < REQUESTS; n++)
            say(fds[i], "{\"op\":\"list\",\"slave\":0}\n");
    }
    for (bool more = true; more;) {
        more = serve(&b) > 0;
        for (size_t i = 0; i < ECT_CONTROL_CLIENTS; i++)
            used[i] += hear(fds[i], got[i] + used[i], ANSWER_ROOM - used[i]);
    }
    size_t signals = count_of(got[0], "\"meaning\"") / REQUESTS;
    assert_true(signals > TWINS * 200);
    for (size_t i = 0; i < ECT_CONTROL_CLIENTS; i++) {
        assert_int_equal(count_of(got[i], "\"meaning\""), signals * REQUESTS);
        assert_int_equal(count_of(got[i], OK), REQUESTS);
        close(fds[i]);
    }
    serve(&b);
    close_bench(&b);
}

/* One who asks for everything again and again, one who does not read: the others' turn comes in the next round. */
static void everybody_in_turn(void **state)
{
    char got[1024];
    int fds[3];
    bench_t b;
    (void)state;
    open_bench(&b, "vr-bu-ect-map7", 12);
    for (size_t i = 0; i < 3; i++) {
        fds[i] = connect_client(&b);
        no_waiting(fds[i]);
        serve(&b);
    }
    for (size_t n = 0; n < 40; n++) {
        say(fds[0], "{\"op\":\"list\",\"slave\":0}\n");
        say(fds[1], "{\"op\":\"get\",\"slave\":0}\n");
    }
    for (unsigned int i = 0; i < 1000; i++)
        serve_once(&b);
    for (unsigned int i = 0; i < 100; i++) {
        say(fds[2], "{\"op\":\"get\",\"pattern\":\"bu.state\"}\n");
        for (unsigned int k = 0; k < 3 * 3; k++) /* it is received, then answered, in its turns */
            serve_once(&b);
        hear(fds[2], got, sizeof got);
        assert_non_null(strstr(got, "\"bu.state\""));
        assert_non_null(strstr(got, OK));
    }
    for (size_t i = 0; i < 3; i++)
        close(fds[i]);
    serve(&b);
    close_bench(&b);
}

/* An unread reply stops, costs nothing meanwhile, and is complete in the end. */
static void slow_reader(void **state)
{
    static char got[ANSWER_ROOM];
    bench_t b;
    (void)state;
    open_bench(&b, "vr-bu-ect-map7", 12);
    int fd = connect_client(&b);
    int small = 4096;
    assert_int_equal(setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &small, sizeof small), 0);
    no_waiting(fd);
    for (size_t n = 0; n < 3; n++)
        say(fd, "{\"op\":\"get\",\"slave\":0}\n");
    serve(&b);
    assert_false(wants_to_be_served(&b)); /* at rest, though the answer is not over */
    size_t used = 0;
    for (size_t before = 1; used != before;) {
        before = used;
        used += hear(fd, got + used, 1000);
        serve(&b);
    }
    assert_int_equal(count_of(got, OK), 3);
    assert_int_equal(count_of(got, "\"slave\":12,"), count_of(got, "\"slave\":1,"));
    close(fd);
    serve(&b);
    close_bench(&b);
}

/* A step by itself, without a socket. */
static void one_step(void **state)
{
    static const char *const requests[] = {"{\"op\":\"list\"}\n", "{\"op\":\"get\",\"pattern\":\"*\",\"slave\":0}\n",
                                           "{\"op\":\"watch\",\"every\":true}\n"};
    static char answer[ECT_CLIENT_ANSWER];
    static ect_client_t client;
    bench_t b;
    (void)state;
    open_bench(&b, "vr-bu-ect-map7", 2);
    for (size_t i = 0; i < sizeof requests / sizeof requests[0]; i++) {
        client = (ect_client_t){.fd = -1, .received = strlen(requests[i]), .answer = answer};
        strcpy(client.request, requests[i]);
        ect_client_received(&client);
        for (unsigned int steps = 0; ect_client_busy(&client); steps++) {
            work.matches = 0;
            client.unsent = 0;
            assert_true(ect_client_room(&client));
            ect_client_step(&client, b.wire.chain, ECT_CONTROL_EVERY, b.wire.now_ns);
            answer[client.unsent] = 0;
            assert_true(count_of(answer, "\n") <= ECT_CLIENT_LINES + 1);
            assert_true(work.matches <= ECT_CLIENT_LOOKS);
            assert_true(steps < 1000);
        }
        assert_non_null(strstr(answer, OK));
    }
    ect_watch_free(client.watch);
    close_bench(&b);
}

/* --- connections -------------------------------------------------------------------------------------------------- */

static void half_closed(void **state)
{
    static const char *const requests[] = {"{\"op\":\"get\",\"pattern\":\"bu.state\"}\n",
                                           "{\"op\":\"get\",\"pattern\":\"bu.state\"}"};
    char got[1024];
    bench_t b;
    (void)state;
    open_bench(&b, "vr-bu-ect-map7", 1);
    for (size_t i = 0; i < 2; i++) {
        int fd = connect_client(&b);
        say(fd, requests[i]);
        assert_int_equal(shutdown(fd, SHUT_WR), 0);
        serve(&b);
        hear(fd, got, sizeof got); /* returns: the connection was closed after the answer */
        assert_non_null(strstr(got, OK));
        close(fd);
    }
    close_bench(&b);
}

/* A watcher that has ended sending still gets changes; when it is gone, its place is free. */
static void half_closed_watcher(void **state)
{
    char got[1024];
    bench_t b;
    (void)state;
    open_bench(&b, "vr-bu-ect-map7", 1);
    for (unsigned int i = 0; i < 2 * ECT_CONTROL_CLIENTS; i++) {
        int fd = connect_client(&b);
        no_waiting(fd);
        say(fd, "{\"op\":\"watch\",\"pattern\":\"ru1.encoder\"}\n");
        assert_int_equal(shutdown(fd, SHUT_WR), 0);
        serve(&b);
        hear(fd, got, sizeof got);
        char request[96];
        snprintf(request, sizeof request, "{\"op\":\"set\",\"name\":\"ru1.encoder\",\"value\":%u}\n", i + 100);
        expect_answer(&b, request, OK);
        b.wire.now_ns += 10 * MS;
        serve(&b);
        hear(fd, got, sizeof got);
        snprintf(request, sizeof request, "\"value\":%u,", i + 100);
        assert_non_null(strstr(got, request));
        close(fd);
        serve(&b);
    }
    close_bench(&b);
}

static void gone_after_asking(void **state)
{
    bench_t b;
    (void)state;
    open_bench(&b, "fzm1", 1);
    int fd = connect_client(&b);
    say(fd, "{\"op\":\"get\"}\n{\"op\":\"set\",\"name\":\"data1\",\"value\":1}\n"
            "{\"op\":\"set\",\"name\":\"data2\",\"value\":2}\n");
    close(fd);
    serve(&b);
    expect_answer(&b, "{\"op\":\"get\",\"pattern\":\"data[12]\"}\n",
                  "{\"slave\":1,\"name\":\"data1\",\"value\":1}\n{\"slave\":1,\"name\":\"data2\",\"value\":2}\n" OK);
    close_bench(&b);
}

/* Writes as many requests as the socket takes, the last one sets a signal. */
static void fill_with_requests(int fd, const char *request, const char *last)
{
    static char block[4096];
    size_t used = 0;
    while (used + strlen(request) < sizeof block) {
        strcpy(block + used, request);
        used += strlen(request);
    }
    no_waiting(fd);
    say(fd, last);
    while (write(fd, block, used) == (ssize_t)used)
        ;
}

/* Sixteen clients that asked for everything, thousands of times, and closed their connections. */
static void dead_clients_give_way(void **state)
{
    static const char *const requests[] = {"{\"op\":\"list\",\"slave\":0}\n", "{\"op\":\"watch\",\"slave\":0}\n", "\n"};
    bench_t b;
    (void)state;
    open_bench(&b, "vr-bu-ect-map7", 16);
    for (size_t r = 0; r < sizeof requests / sizeof requests[0]; r++) {
        unsigned int matches = 0, calls = 0;
        int fds[ECT_CONTROL_CLIENTS];
        char last[96];
        for (size_t i = 0; i < ECT_CONTROL_CLIENTS; i++) {
            fds[i] = connect_client(&b);
            serve(&b);
        }
        for (size_t i = 0; i < ECT_CONTROL_CLIENTS; i++) {
            snprintf(last, sizeof last, "{\"op\":\"set\",\"slave\":%zu,\"name\":\"ru1.encoder\",\"value\":%zu}\n",
                     i + 1, r + 7);
            fill_with_requests(fds[i], requests[r], last);
            close(fds[i]);
        }
        for (; wants_to_be_served(&b); calls++) {
            serve_once(&b);
            matches += work.matches;
            if (calls > ECT_CONTROL_CLIENTS * 4000)
                fail_msg("dead clients are still served after %u calls", calls);
        }
        assert_int_equal(matches, 0);
        for (size_t i = 1; i <= ECT_CONTROL_CLIENTS; i++) {
            char want[96];
            snprintf(last, sizeof last, "{\"op\":\"get\",\"slave\":%zu,\"pattern\":\"ru1.encoder\"}\n", i);
            snprintf(want, sizeof want, "{\"slave\":%zu,\"name\":\"ru1.encoder\",\"value\":%zu}\n" OK, i, r + 7);
            expect_answer(&b, last, want);
        }
    }
    close_bench(&b);
}

static void in_pieces(void **state)
{
    const char *request = "{\"op\":\"get\",\"pattern\":\"bu.state\"}\n";
    char got[1024];
    bench_t b;
    (void)state;
    open_bench(&b, "vr-bu-ect-map7", 1);
    int fd = connect_client(&b);
    no_waiting(fd);
    for (const char *c = request; *c != 0; c++) {
        const char piece[] = {*c, 0};
        say(fd, piece);
        serve(&b);
    }
    hear(fd, got, sizeof got);
    assert_non_null(strstr(got, OK));
    close(fd);
    serve(&b);
    close_bench(&b);
}

static void zero_bytes_and_long_requests(void **state)
{
    static const char zero[] = "{\"op\":\"get\",\0\"pattern\":\"bu.state\"}\n";
    static char text[2 * ECT_ENDPOINT_REQUEST];
    char got[1024];
    bench_t b;
    (void)state;
    open_bench(&b, "vr-bu-ect-map7", 1);
    int fd = connect_client(&b);
    no_waiting(fd);
    assert_int_equal(write(fd, zero, sizeof zero - 1), sizeof zero - 1);
    serve(&b);
    hear(fd, got, sizeof got);
    assert_non_null(strstr(got, "no zero byte"));
    const char *request = "{\"op\":\"get\",\"pattern\":\"bu.state\"}";
    memset(text, ' ', ECT_ENDPOINT_REQUEST - 1);
    memcpy(text, request, strlen(request));
    strcpy(text + ECT_ENDPOINT_REQUEST - 1, "\n");
    say(fd, text); /* as long as may be */
    serve(&b);
    hear(fd, got, sizeof got);
    assert_non_null(strstr(got, OK));
    memset(text, 'x', sizeof text - 1);
    say(fd, text);
    serve(&b);
    hear(fd, got, sizeof got);
    assert_non_null(strstr(got, "at most 4095 characters"));
    assert_int_equal(read(fd, got, 1), 0); /* and it was closed */
    close(fd);
    close_bench(&b);
}

static void seventeenth_client(void **state)
{
    char got[256];
    int fds[ECT_CONTROL_CLIENTS];
    bench_t b;
    (void)state;
    open_bench(&b, "vr-bu-ect-map7", 1);
    for (size_t i = 0; i < ECT_CONTROL_CLIENTS; i++) {
        fds[i] = connect_client(&b);
        serve(&b);
    }
    int more = connect_client(&b);
    serve(&b);
    hear(more, got, sizeof got);
    assert_non_null(strstr(got, "serves 16 connections"));
    close(more);
    close(fds[5]);
    serve(&b);
    expect_part(&b, "{\"op\":\"get\"}\n", OK);
    for (size_t i = 0; i < ECT_CONTROL_CLIENTS; i++) {
        if (i != 5)
            close(fds[i]);
    }
    serve(&b);
    close_bench(&b);
}

/* Without a descriptor no client is accepted, and a waiting one keeps the socket readable: the loop must not spin. */
static void no_descriptors(void **state)
{
    struct rlimit before, none;
    char got[256];
    bench_t b;
    (void)state;
    open_bench(&b, "vr-bu-ect-map7", 1);
    int fd = connect_client(&b);
    assert_int_equal(getrlimit(RLIMIT_NOFILE, &before), 0);
    none = before;
    none.rlim_cur = (rlim_t)fd + 1;
    assert_int_equal(setrlimit(RLIMIT_NOFILE, &none), 0);
    serve(&b);
    assert_int_equal(setrlimit(RLIMIT_NOFILE, &before), 0);
    no_waiting(fd);
    hear(fd, got, sizeof got);
    assert_non_null(strstr(got, "no descriptor left"));
    close(fd);
    serve(&b);
    expect_part(&b, "{\"op\":\"get\"}\n", OK);
    close_bench(&b);
}

/* No descriptor for the refusal either: the next attempt follows after a second. */
static void no_descriptors_at_all(void **state)
{
    struct rlimit before, none;
    char got[1024];
    bench_t b;
    (void)state;
    assert_int_equal(getrlimit(RLIMIT_NOFILE, &before), 0);
    open_bench(&b, "vr-bu-ect-map7", 1);
    int fd = connect_client(&b);
    no_waiting(fd);
    none = before;
    none.rlim_cur = 3;
    assert_int_equal(setrlimit(RLIMIT_NOFILE, &none), 0);
    unsigned int calls = 0;
    while (wants_to_be_served(&b) && ++calls < 10)
        ect_control_serve(b.control, b.wire.chain, b.wire.now_ns);
    assert_true(calls < 10);
    assert_true(ect_control_due(b.control) == b.wire.now_ns + 1000 * MS);
    assert_int_equal(setrlimit(RLIMIT_NOFILE, &before), 0);
    b.wire.now_ns += 1000 * MS;
    serve(&b);
    say(fd, "{\"op\":\"get\",\"pattern\":\"bu.state\"}\n");
    serve(&b);
    hear(fd, got, sizeof got);
    assert_non_null(strstr(got, OK));
    close(fd);
    serve(&b);
    close_bench(&b);
}

/* --- watching ----------------------------------------------------------------------------------------------------- */

static void set_encoder(bench_t *b, unsigned int value)
{
    ect_signal_ref_t ref;
    char text[16], message[ECT_SIGNAL_MESSAGE];
    snprintf(text, sizeof text, "%u", value);
    assert_true(ect_chain_signal(b->wire.chain, 0, "ru1.encoder", &ref));
    assert_true(ect_signal_write(&ref, text, b->wire.now_ns, message));
}

static void by_rounds(void **state)
{
    char got[1024];
    bench_t b;
    (void)state;
    open_bench(&b, "vr-bu-ect-map7", 1);
    int fd = connect_client(&b);
    no_waiting(fd);
    say(fd, "{\"op\":\"watch\",\"pattern\":\"ru1.encoder\"}\n");
    serve(&b);
    hear(fd, got, sizeof got);
    uint64_t round = ect_control_due(b.control);
    assert_true(round > b.wire.now_ns && round <= b.wire.now_ns + 10 * MS);
    set_encoder(&b, 5);
    set_encoder(&b, 6);
    b.wire.now_ns = round - 1;
    assert_int_equal(serve(&b), 0);
    b.wire.now_ns = round;
    serve(&b);
    hear(fd, got, sizeof got);
    assert_string_equal(got, "{\"slave\":1,\"name\":\"ru1.encoder\",\"value\":6,\"time\":1.010000}\n");
    set_encoder(&b, 7);
    set_encoder(&b, 6); /* back before the next round: no change */
    b.wire.now_ns += 10 * MS;
    serve(&b);
    assert_int_equal(hear(fd, got, sizeof got), 0);
    close(fd);
    serve(&b);
    assert_true(ect_control_due(b.control) == ECT_NEVER); /* no client watches: no rounds */
    close_bench(&b);
}

static void every_change(void **state)
{
    char got[1024];
    bench_t b;
    (void)state;
    open_bench(&b, "vr-bu-ect-map7", 1);
    int fd = connect_client(&b);
    no_waiting(fd);
    say(fd, "{\"op\":\"watch\",\"pattern\":\"ru1.encoder\",\"every\":true}\n");
    serve(&b);
    hear(fd, got, sizeof got);
    for (unsigned int i = 1; i <= 3; i++) {
        b.wire.now_ns += 7000;
        set_encoder(&b, i % 2);
        ect_control_note(b.control, b.wire.chain, b.wire.now_ns);
    }
    serve(&b);
    hear(fd, got, sizeof got);
    assert_string_equal(got, "{\"slave\":1,\"name\":\"ru1.encoder\",\"value\":1,\"time\":1.000007}\n"
                             "{\"slave\":1,\"name\":\"ru1.encoder\",\"value\":0,\"time\":1.000014}\n"
                             "{\"slave\":1,\"name\":\"ru1.encoder\",\"value\":1,\"time\":1.000021}\n");
    close(fd);
    serve(&b);
    close_bench(&b);
}

/* Lamps are made when they are looked for: those of the twins of which one is watched, and of no others. */
static void watched_lamps(void **state)
{
    static const struct {
        const char *watch;
        unsigned int looks; /* at the lamps of a twin, for each comparison */
        const char *told;
    } rows[] = {
        {"{\"op\":\"watch\",\"slave\":2,\"pattern\":\"ecat.state\",\"every\":true}\n", 1,
         "{\"slave\":2,\"name\":\"ecat.state\",\"value\":2,"},
        {"{\"op\":\"watch\",\"slave\":2,\"pattern\":\"ecat.state\"}\n", 1,
         "{\"slave\":2,\"name\":\"ecat.state\",\"value\":2,"},
        {"{\"op\":\"watch\",\"slave\":0,\"pattern\":\"ru1.encoder\",\"every\":true}\n", 0, ""},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char got[1024];
        bench_t b;
        open_bench(&b, "vr-bu-ect-map7", 3);
        int fd = connect_client(&b);
        no_waiting(fd);
        say(fd, rows[i].watch);
        serve(&b);
        hear(fd, got, sizeof got);
        wire_go(&b.wire, 1, 2);
        work.lamps = 0;
        ect_control_note(b.control, b.wire.chain, b.wire.now_ns);
        b.wire.now_ns += 10 * MS;
        unsigned int looks = work.lamps;
        while (wants_to_be_served(&b)) {
            serve_once(&b);
            looks += work.lamps;
        }
        hear(fd, got, sizeof got);
        if (strncmp(got, rows[i].told, strlen(rows[i].told)) != 0 || looks != rows[i].looks)
            fail_msg("%s: expected %s and %u updates of lamps, got %s and %u", rows[i].watch, rows[i].told,
                     rows[i].looks, got, looks);
        close(fd);
        serve(&b);
        close_bench(&b);
    }
}

/* A thousand equal requests: each gets a reply, and a change is reported once. */
static void watched_once(void **state)
{
    static char got[ANSWER_ROOM];
    bench_t b;
    (void)state;
    open_bench(&b, "vr-bu-ect-map7", 1);
    int fd = connect_client(&b);
    no_waiting(fd);
    for (unsigned int i = 0; i < 1000; i++) {
        say(fd, "{\"op\":\"watch\",\"pattern\":\"ru1.*\"}\n");
        serve(&b);
        hear(fd, got, sizeof got);
        assert_int_equal(count_of(got, OK), 1);
    }
    set_encoder(&b, 9);
    b.wire.now_ns += 10 * MS;
    serve(&b);
    hear(fd, got, sizeof got);
    assert_int_equal(count_of(got, "\n"), 1);
    close(fd);
    serve(&b);
    close_bench(&b);
}

static void too_much_watched(void **state)
{
    static char got[ANSWER_ROOM];
    enum { TWINS = 16 };
    bench_t b;
    (void)state;
    open_bench(&b, "vr-bu-ect-map7", TWINS);
    int fds[2];
    for (size_t i = 0; i < 2; i++) {
        fds[i] = connect_client(&b);
        no_waiting(fds[i]);
        say(fds[i], i == 0 ? "{\"op\":\"watch\",\"slave\":0}\n" : "{\"op\":\"watch\",\"slave\":0,\"every\":true}\n");
        size_t used = 0;
        for (unsigned int n = 0; n < 1000; n++) {
            serve(&b);
            used += hear(fds[i], got + used, sizeof got - used);
        }
        assert_int_equal(count_of(got, "\n"), ECT_WATCH_MOST + 1);
        assert_non_null(strstr(got, i == 0 ? "a connection watches at most 4096 signals" : "4096"));
    }
    expect_part(&b, "{\"op\":\"watch\",\"every\":true}\n", "too many signals are watched at every change");
    /* Nor by asking for every change of what is watched already. */
    say(fds[0], "{\"op\":\"watch\",\"pattern\":\"bu.state\",\"every\":true}\n");
    serve(&b);
    hear(fds[0], got, sizeof got);
    assert_non_null(strstr(got, "too many signals are watched at every change"));
    for (size_t i = 0; i < 2; i++)
        close(fds[i]);
    serve(&b);
    close_bench(&b);
}

/* A client that watches every change and reads none gets a line about the loss, and the connection ends. */
static void changes_lost(void **state)
{
    static char got[ANSWER_ROOM];
    bench_t b;
    (void)state;
    open_bench(&b, "vr-bu-ect-map7", 1);
    int fd = connect_client(&b);
    no_waiting(fd);
    say(fd, "{\"op\":\"watch\",\"pattern\":\"ru1.encoder\",\"every\":true}\n");
    serve(&b);
    for (unsigned int i = 1; i < 100000; i++) {
        set_encoder(&b, i % 256);
        ect_control_note(b.control, b.wire.chain, b.wire.now_ns + i);
        if (i % 100 == 0)
            serve(&b);
    }
    size_t used = 0;
    for (unsigned int n = 0; n < 1000; n++) {
        serve(&b);
        used += hear(fd, got + used, sizeof got - used);
    }
    assert_non_null(strstr(got, "changes were lost"));
    assert_int_equal(read(fd, got, 1), 0);
    close(fd);
    close_bench(&b);
}

/* --- all or nothing ----------------------------------------------------------------------------------------------- */

static void all_or_nothing(void **state)
{
    static const struct {
        const char *request, *part;
    } cases[] = {
        /* Each of the two limits the other: 5 ms and 10 ms at first. */
        {"{\"op\":\"set\",\"values\":{\"output_period\":40,\"output_time\":30}}\n", OK},
        {"{\"op\":\"set\",\"values\":{\"output_time\":300,\"output_period\":400}}\n", OK},
        {"{\"op\":\"set\",\"values\":{\"output_period\":30,\"output_time\":20}}\n", OK},
        {"{\"op\":\"get\",\"pattern\":\"output_[pt]*\"}\n",
         "\"value\":30}\n{\"slave\":1,\"name\":\"output_time\",\"value\":20}"},
        {"{\"op\":\"set\",\"values\":{\"data1\":7,\"output_time\":30}}\n",
         "output_time: the output time must be shorter"},
        {"{\"op\":\"set\",\"values\":{\"data1\":7,\"nosuch\":30}}\n", "no signal 'nosuch'"},
        {"{\"op\":\"set\",\"values\":{\"data1\":7,\"output_time\":\"x\"}}\n", "takes 10..10000"},
        {"{\"op\":\"set\",\"values\":{\"row_add\":1,\"busy\":1}}\n", "the twin's own"},
        {"{\"op\":\"set\",\"values\":{\"row_add\":1,\"restart\":1,\"output_time\":31}}\n", "must be shorter"},
        {"{\"op\":\"get\",\"pattern\":\"data1\"}\n", "\"value\":0}"},
        {"{\"op\":\"get\",\"pattern\":\"rows\"}\n", "\"value\":0}"},
        {"{\"op\":\"set\",\"values\":{\"row1\":5,\"row_add\":1,\"units\":4,\"output_unit\":3}}\n", OK},
        {"{\"op\":\"get\",\"pattern\":\"rows\"}\n", "\"value\":1}"},
        {"{\"op\":\"set\",\"values\":{\"output_unit\":6,\"units\":7}}\n", OK},
        {"{\"op\":\"set\",\"values\":{\"units\":2,\"data1\":1,\"output_unit\":1}}\n", OK},
    };
    bench_t b;
    (void)state;
    open_bench(&b, "fzm1", 1);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++)
        expect_part(&b, cases[i].request, cases[i].part);
    assert_false(ect_chain_slave(b.wire.chain, 0)->off_bus); /* the restart was taken back */
    close_bench(&b);
}

static void most_values(void **state)
{
    char request[ECT_ENDPOINT_REQUEST];
    bench_t b;
    (void)state;
    open_bench(&b, "vr-bu-ect-map7", 1);
    for (unsigned int count = ECT_ENDPOINT_VALUES; count <= ECT_ENDPOINT_VALUES + 1; count++) {
        size_t used = (size_t)snprintf(request, sizeof request, "{\"op\":\"set\",\"values\":{");
        for (unsigned int i = 0; i < count; i++)
            used +=
                (size_t)snprintf(request + used, sizeof request - used, "%s\"ru1.encoder\":%u", i > 0 ? "," : "", i);
        snprintf(request + used, sizeof request - used, "}}\n");
        expect_part(&b, request, count == ECT_ENDPOINT_VALUES ? OK : "at most 128 signals");
    }
    expect_part(&b, "{\"op\":\"get\",\"pattern\":\"ru1.encoder\"}\n", "\"value\":127}");
    close_bench(&b);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"Requests get replies, refusals with the reason", answers, NULL, NULL, NULL},
        {"Each counter and step of the histogram is in the reply to stats", counted, NULL, NULL, NULL},
        {"The twins are described: name, devices, interfaces, AL states", about_the_twins, NULL, NULL, NULL},
        {"Faults are set, listed and ended by requests", faults_by_request, NULL, NULL, NULL},
        {"Every line is JSON", lines_are_json, NULL, NULL, NULL},
        {"Data too large for a signal come in pieces", data_in_pieces, NULL, NULL, NULL},
        {"Attack: 4 x everything from 16 clients is served in bounded pieces, and whole", pipelined_lists, NULL, NULL,
         NULL},
        {"A step writes at most eight lines and its result, and compares at most 32 names", one_step, NULL, NULL, NULL},
        {"Everybody's turn comes, whatever the others ask", everybody_in_turn, NULL, NULL, NULL},
        {"Attack: a client that does not read costs nothing, and gets everything later", slow_reader, NULL, NULL, NULL},
        {"A client that has ended sending gets its answer", half_closed, NULL, NULL, NULL},
        {"A watcher that has ended sending still gets changes, and its place is free when it is gone",
         half_closed_watcher, NULL, NULL, NULL},
        {"Requests before the end of a connection are carried out", gone_after_asking, NULL, NULL, NULL},
        {"Attack: sixteen clients that are gone: only set and fault are carried out", dead_clients_give_way, NULL, NULL,
         NULL},
        {"A request may come byte by byte", in_pieces, NULL, NULL, NULL},
        {"Attack: zero bytes and endless requests are refused", zero_bytes_and_long_requests, NULL, NULL, NULL},
        {"Attack: the 17th client gets the reason, and is closed", seventeenth_client, NULL, NULL, NULL},
        {"Attack: without descriptors a client gets the reason", no_descriptors, NULL, NULL, NULL},
        {"Attack: without any descriptor nothing spins", no_descriptors_at_all, NULL, NULL, NULL},
        {"Watch: one line for what differs after 10 ms", by_rounds, NULL, NULL, NULL},
        {"Watch: every change, with its time", every_change, NULL, NULL, NULL},
        {"Watch: lamps are brought up to date where one is watched", watched_lamps, NULL, NULL, NULL},
        {"Attack: 1000 x the same watch is watched once", watched_once, NULL, NULL, NULL},
        {"Attack: at most 4096 signals are watched", too_much_watched, NULL, NULL, NULL},
        {"Attack: who wants every change and reads none is let go", changes_lost, NULL, NULL, NULL},
        {"Several signals are set all or none, in any order", all_or_nothing, NULL, NULL, NULL},
        {"A request sets at most 128 signals", most_values, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Control socket", tests, NULL, NULL);
}
