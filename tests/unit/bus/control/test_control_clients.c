/* SPDX-License-Identifier: MIT */
/* The control socket: connections, and the bounded work between two checks of the wire (control.h). */
#define _GNU_SOURCE
#include "support/control_bench.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include "bus/control/client.h"

/* --- bounded work ------------------------------------------------------------------------------------------------- */

/* Each of sixteen clients requests all signals several times in one write. serve_once() checks the bounds. */
static void pipelined_requests_are_served_in_pieces(void **state)
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
        set_nonblocking(fds[i]);
        for (size_t n = 0; n < REQUESTS; n++)
            send_text(fds[i], "{\"op\":\"list\",\"slave\":0}\n");
    }
    for (bool more = true; more;) {
        more = serve(&b) > 0;
        for (size_t i = 0; i < ECT_CONTROL_CLIENTS; i++)
            used[i] += receive_text(fds[i], got[i] + used[i], ANSWER_ROOM - used[i]);
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

/* One client repeats requests for all signals, one client does not read: another client is served in the next
 * round. */
static void clients_are_served_in_turn(void **state)
{
    char got[1024];
    int fds[3];
    bench_t b;
    (void)state;
    open_bench(&b, "vr-bu-ect-map7", 12);
    for (size_t i = 0; i < 3; i++) {
        fds[i] = connect_client(&b);
        set_nonblocking(fds[i]);
        serve(&b);
    }
    for (size_t n = 0; n < 40; n++) {
        send_text(fds[0], "{\"op\":\"list\",\"slave\":0}\n");
        send_text(fds[1], "{\"op\":\"get\",\"slave\":0}\n");
    }
    for (unsigned int i = 0; i < 1000; i++)
        serve_once(&b);
    for (unsigned int i = 0; i < 100; i++) {
        send_text(fds[2], "{\"op\":\"get\",\"pattern\":\"bu.state\"}\n");
        for (unsigned int k = 0; k < 3 * 3; k++) /* one turn for the reception, one for the reply */
            serve_once(&b);
        receive_text(fds[2], got, sizeof got);
        assert_non_null(strstr(got, "\"bu.state\""));
        assert_non_null(strstr(got, OK));
    }
    for (size_t i = 0; i < 3; i++)
        close(fds[i]);
    serve(&b);
    close_bench(&b);
}

/* The reply stops while the client does not read, without work for the twin, and is complete in the end. */
static void unread_replies_cost_nothing(void **state)
{
    static char got[ANSWER_ROOM];
    bench_t b;
    (void)state;
    open_bench(&b, "vr-bu-ect-map7", 12);
    int fd = connect_client(&b);
    int small = 4096;
    assert_int_equal(setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &small, sizeof small), 0);
    set_nonblocking(fd);
    for (size_t n = 0; n < 3; n++)
        send_text(fd, "{\"op\":\"get\",\"slave\":0}\n");
    serve(&b);
    assert_false(wants_to_be_served(&b)); /* waiting for the client, with an incomplete reply */
    size_t used = receive_text(fd, got, 1000);
    while (!wants_to_be_served(&b))
        used += receive_text(fd, got + used, 1000);
    serve_once(&b);
    assert_int_equal(work.receives, 0); /* nothing is pending for reception */
    assert_int_equal(work.sends, 1);
    for (size_t before = 1; used != before;) {
        before = used;
        used += receive_text(fd, got + used, 1000);
        serve(&b);
    }
    assert_int_equal(count_of(got, OK), 3);
    assert_int_equal(count_of(got, "\"slave\":12,"), count_of(got, "\"slave\":1,"));
    close(fd);
    serve(&b);
    close_bench(&b);
}

/* A step without a socket. */
static void a_step_is_bounded(void **state)
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
            assert_true(count_of(answer, "\n") - count_of(answer, OK) <= ECT_CLIENT_LINES);
            assert_true(work.matches <= ECT_CLIENT_MATCHES);
            assert_true(steps < 1000);
        }
        assert_non_null(strstr(answer, OK));
    }
    ect_watch_free(client.watch);
    close_bench(&b);
}

/* With 16 pending changes the first step writes eight, the second the others, the third none. */
static void a_step_is_used(void **state)
{
    static const char request[] = "{\"op\":\"watch\",\"slave\":0,\"pattern\":\"ru*.encoder\"}\n";
    static const size_t want[] = {8, 8, 0};
    static char answer[ECT_CLIENT_ANSWER];
    static ect_client_t client;
    bench_t b;
    (void)state;
    open_bench(&b, "vr-bu-ect-map7", 2);
    client = (ect_client_t){.fd = -1, .received = sizeof request - 1, .answer = answer};
    strcpy(client.request, request);
    ect_client_received(&client);
    while (ect_client_busy(&client)) {
        client.unsent = 0;
        ect_client_step(&client, b.wire.chain, 0, b.wire.now_ns);
    }
    assert_int_equal(ect_watch_count(client.watch), 16);
    for (size_t slave = 0; slave < 2; slave++) {
        for (unsigned int ru = 1; ru <= 8; ru++) {
            char name[ECT_SIGNAL_NAME];
            ect_signal_ref_t ref;
            (void)snprintf(name, sizeof name, "ru%u.encoder", ru);
            assert_true(ect_chain_signal(b.wire.chain, slave, name, &ref));
            *ref.value = 1;
        }
    }
    ect_watch_round(client.watch);
    for (size_t step = 0; step < sizeof want / sizeof want[0]; step++) {
        client.unsent = 0;
        ect_client_step(&client, b.wire.chain, 0, b.wire.now_ns);
        answer[client.unsent] = 0;
        assert_int_equal(count_of(answer, "\n"), want[step]);
    }
    ect_watch_free(client.watch);
    close_bench(&b);
}

/* --- connections -------------------------------------------------------------------------------------------------- */

static void a_half_closed_client_gets_its_reply(void **state)
{
    static const char *const requests[] = {"{\"op\":\"get\",\"pattern\":\"bu.state\"}\n",
                                           "{\"op\":\"get\",\"pattern\":\"bu.state\"}"};
    char got[1024];
    bench_t b;
    (void)state;
    open_bench(&b, "vr-bu-ect-map7", 1);
    for (size_t i = 0; i < 2; i++) {
        int fd = connect_client(&b);
        send_text(fd, requests[i]);
        assert_int_equal(shutdown(fd, SHUT_WR), 0);
        serve(&b);
        receive_text(fd, got, sizeof got); /* returns because the connection is closed after the reply */
        assert_non_null(strstr(got, OK));
        close(fd);
    }
    close_bench(&b);
}

/* A reply of many steps. */
static void a_half_closed_client_gets_a_long_reply(void **state)
{
    static char got[ANSWER_ROOM];
    bench_t b;
    (void)state;
    open_bench(&b, "vr-bu-ect-map7", 2);
    int fd = connect_client(&b);
    size_t used = 0;
    ssize_t part = 0;
    send_text(fd, "{\"op\":\"list\",\"slave\":0}\n");
    assert_int_equal(shutdown(fd, SHUT_WR), 0);
    set_nonblocking(fd);
    for (unsigned int i = 0; i < 1000 && (part > 0 || i < 900); i++) {
        serve(&b);
        part = read(fd, got + used, sizeof got - 1 - used);
        used += part > 0 ? (size_t)part : 0;
    }
    got[used] = 0;
    assert_int_equal(count_of(got, OK), 1);
    assert_int_equal(count_of(got, "\"slave\":2,"), count_of(got, "\"slave\":1,"));
    assert_int_equal(part, 0); /* end of the connection */
    close(fd);
    close_bench(&b);
}

/* epoll_ctl() may fail for a further descriptor. */
static void a_client_that_cannot_be_waited_for(void **state)
{
    char got[256];
    bench_t b;
    (void)state;
    open_bench(&b, "fzm1", 1);
    int fd = connect_client(&b);
    refuses_events = true;
    serve(&b);
    refuses_events = false;
    receive_text(fd, got, sizeof got); /* returns because the connection is closed */
    assert_non_null(strstr(got, "{\"ok\":false,"));
    close(fd);
    expect_part(&b, "{\"op\":\"get\"}\n", OK);
    close_bench(&b);
}

/* A client that watches and has ended sending gets changes; after its end another client is accepted. */
static void a_half_closed_watcher_gets_changes(void **state)
{
    char got[1024];
    bench_t b;
    (void)state;
    open_bench(&b, "vr-bu-ect-map7", 1);
    for (unsigned int i = 0; i < 2 * ECT_CONTROL_CLIENTS; i++) {
        int fd = connect_client(&b);
        set_nonblocking(fd);
        send_text(fd, "{\"op\":\"watch\",\"pattern\":\"ru1.encoder\"}\n");
        assert_int_equal(shutdown(fd, SHUT_WR), 0);
        serve(&b);
        receive_text(fd, got, sizeof got);
        char request[96];
        snprintf(request, sizeof request, "{\"op\":\"set\",\"name\":\"ru1.encoder\",\"value\":%u}\n", i + 100);
        expect_answer(&b, request, OK);
        b.wire.now_ns += 10 * MS;
        serve(&b);
        receive_text(fd, got, sizeof got);
        snprintf(request, sizeof request, "\"value\":%u,", i + 100);
        assert_non_null(strstr(got, request));
        close(fd);
        serve(&b);
    }
    close_bench(&b);
}

static void requests_before_the_end_of_a_connection(void **state)
{
    bench_t b;
    (void)state;
    open_bench(&b, "fzm1", 1);
    int fd = connect_client(&b);
    send_text(fd, "{\"op\":\"get\"}\n{\"op\":\"set\",\"name\":\"data1\",\"value\":1}\n"
                  "{\"op\":\"set\",\"name\":\"data2\",\"value\":2}\n");
    close(fd);
    serve(&b);
    expect_answer(&b, "{\"op\":\"get\",\"pattern\":\"data[12]\"}\n",
                  "{\"slave\":1,\"name\":\"data1\",\"value\":1}\n{\"slave\":1,\"name\":\"data2\",\"value\":2}\n" OK);
    close_bench(&b);
}

/* Writes `last`, then requests until the buffer of the socket is full. */
static void fill_with_requests(int fd, const char *request, const char *last)
{
    static char block[4096];
    size_t used = 0;
    while (used + strlen(request) < sizeof block) {
        strcpy(block + used, request);
        used += strlen(request);
    }
    set_nonblocking(fd);
    send_text(fd, last);
    while (write(fd, block, used) == (ssize_t)used)
        ;
}

/* Sixteen clients request all signals thousands of times and close their connections. */
static void requests_of_closed_connections_are_skipped(void **state)
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
                fail_msg("closed clients are still served after %u calls", calls);
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

static void a_request_in_pieces(void **state)
{
    const char *request = "{\"op\":\"get\",\"pattern\":\"bu.state\"}\n";
    char got[1024];
    bench_t b;
    (void)state;
    open_bench(&b, "vr-bu-ect-map7", 1);
    int fd = connect_client(&b);
    set_nonblocking(fd);
    for (const char *c = request; *c != 0; c++) {
        const char piece[] = {*c, 0};
        send_text(fd, piece);
        serve(&b);
    }
    receive_text(fd, got, sizeof got);
    assert_non_null(strstr(got, OK));
    close(fd);
    serve(&b);
    close_bench(&b);
}

/* A request of 4095 bytes waits for its line feed; another byte in place of the line feed ends the connection. */
static void the_line_feed_of_the_longest_request(void **state)
{
    static const struct {
        size_t length;
        const char *last, *part;
        bool closed;
    } cases[] = {{ECT_ENDPOINT_REQUEST - 1, "\n", OK, false},
                 {ECT_ENDPOINT_REQUEST - 2, "\n", OK, false},
                 {ECT_ENDPOINT_REQUEST - 1, "x", "at most 4095 characters", true}};
    bench_t b;
    (void)state;
    open_bench(&b, "vr-bu-ect-map7", 1);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const char *request = "{\"op\":\"get\",\"pattern\":\"bu.state\"}";
        char text[ECT_ENDPOINT_REQUEST + 1] = "", got[1024];
        int fd = connect_client(&b);
        set_nonblocking(fd);
        memset(text, ' ', cases[i].length);
        memcpy(text, request, strlen(request));
        send_text(fd, text);
        serve(&b);
        assert_int_equal(receive_text(fd, got, sizeof got), 0);
        assert_int_equal(read(fd, got, 1), -1); /* open */
        send_text(fd, cases[i].last);
        serve(&b);
        receive_text(fd, got, sizeof got);
        assert_non_null(strstr(got, cases[i].part));
        assert_int_equal(read(fd, got, 1), cases[i].closed ? 0 : -1);
        close(fd);
        serve(&b);
    }
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
    set_nonblocking(fd);
    assert_int_equal(write(fd, zero, sizeof zero - 1), sizeof zero - 1);
    serve(&b);
    receive_text(fd, got, sizeof got);
    assert_non_null(strstr(got, "no zero byte"));
    const char *request = "{\"op\":\"get\",\"pattern\":\"bu.state\"}";
    memset(text, ' ', ECT_ENDPOINT_REQUEST - 1);
    memcpy(text, request, strlen(request));
    strcpy(text + ECT_ENDPOINT_REQUEST - 1, "\n");
    send_text(fd, text); /* the longest request */
    serve(&b);
    receive_text(fd, got, sizeof got);
    assert_non_null(strstr(got, OK));
    memset(text, 'x', sizeof text - 1);
    send_text(fd, text);
    serve(&b);
    receive_text(fd, got, sizeof got);
    assert_non_null(strstr(got, "at most 4095 characters"));
    assert_int_equal(read(fd, got, 1), 0); /* closed */
    close(fd);
    close_bench(&b);
}

static void interrupted_reads_are_repeated(void **state)
{
    static const struct {
        int error;
        bool served;
    } rows[] = {{EAGAIN, true}, {EINTR, true}, {ECONNRESET, false}, {ENOMEM, false}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char got[256];
        bench_t b;
        open_bench(&b, "fzm1", 1);
        int fd = connect_client(&b);
        serve(&b);
        set_nonblocking(fd);
        receive_error = rows[i].error;
        send_text(fd, "{\"op\":\"get\",\"pattern\":\"data1\"}\n");
        serve(&b);
        assert_int_equal(receive_error, 0);
        receive_text(fd, got, sizeof got);
        if ((strstr(got, OK) != NULL) != rows[i].served)
            fail_msg("after %s: got '%s'", strerror(rows[i].error), got);
        close(fd);
        serve(&b);
        close_bench(&b);
    }
}

static void a_client_that_is_gone_before_its_refusal(void **state)
{
    int fds[ECT_CONTROL_CLIENTS];
    bench_t b;
    (void)state;
    open_bench(&b, "fzm1", 1);
    for (size_t i = 0; i < ECT_CONTROL_CLIENTS; i++) {
        fds[i] = connect_client(&b);
        serve(&b);
    }
    close(connect_client(&b));
    serve(&b);
    close(fds[0]);
    serve(&b);
    expect_part(&b, "{\"op\":\"get\"}\n", OK);
    for (size_t i = 1; i < ECT_CONTROL_CLIENTS; i++)
        close(fds[i]);
    serve(&b);
    close_bench(&b);
}

static void the_17th_client_gets_the_reason(void **state)
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
    receive_text(more, got, sizeof got);
    assert_non_null(strstr(got, "serves 16 connections, and all are taken: end one of them\"}\n"));
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

/* Without a free descriptor a pending client keeps the socket readable, but the loop must not spin. */
static void expect_refusal(void)
{
    struct rlimit before, none;
    char got[256];
    bench_t b;
    open_bench(&b, "vr-bu-ect-map7", 1);
    int fd = connect_client(&b);
    assert_int_equal(getrlimit(RLIMIT_NOFILE, &before), 0);
    none = before;
    none.rlim_cur = (rlim_t)fd + 1;
    assert_int_equal(setrlimit(RLIMIT_NOFILE, &none), 0);
    serve(&b);
    assert_int_equal(setrlimit(RLIMIT_NOFILE, &before), 0);
    set_nonblocking(fd);
    receive_text(fd, got, sizeof got);
    assert_non_null(strstr(got, "no descriptor left"));
    close(fd);
    serve(&b);
    expect_part(&b, "{\"op\":\"get\"}\n", OK);
    close_bench(&b);
}

static void no_descriptors(void **state)
{
    (void)state;
    expect_refusal();
}

/* A daemon's standard input may be closed: the spare descriptor, or the descriptor of a client, then is 0. */
static void descriptor_0(void **state)
{
    char got[256];
    bench_t b;
    (void)state;
    int null = open("/dev/null", O_RDONLY), input = fcntl(null, F_DUPFD_CLOEXEC, STDIN_FILENO + 1);
    assert_true(null >= 0 && input >= 0);
    if (null != STDIN_FILENO)
        close(null);
    close(STDIN_FILENO);
    expect_refusal();
    assert_int_equal(dup2(input, STDIN_FILENO), STDIN_FILENO);
    open_bench(&b, "fzm1", 1);
    int fd = connect_client(&b);
    close(STDIN_FILENO);
    send_text(fd, "{\"op\":\"get\",\"pattern\":\"data1\"}\n");
    serve(&b);
    set_nonblocking(fd);
    receive_text(fd, got, sizeof got);
    assert_non_null(strstr(got, OK));
    close(fd);
    fd = dup(input); /* replaces descriptor 0, which close_bench() closes */
    close_bench(&b);
    close(fd);
    assert_int_equal(dup2(input, STDIN_FILENO), STDIN_FILENO);
    close(input);
}

/* Without the spare descriptor, too, the next attempt follows after a second. */
static void no_descriptors_at_all(void **state)
{
    struct rlimit before, none;
    char got[1024];
    bench_t b;
    (void)state;
    assert_int_equal(getrlimit(RLIMIT_NOFILE, &before), 0);
    open_bench(&b, "vr-bu-ect-map7", 1);
    int fd = connect_client(&b);
    set_nonblocking(fd);
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
    send_text(fd, "{\"op\":\"get\",\"pattern\":\"bu.state\"}\n");
    serve(&b);
    receive_text(fd, got, sizeof got);
    assert_non_null(strstr(got, OK));
    close(fd);
    serve(&b);
    close_bench(&b);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"Attack: 4 requests for all signals from each of 16 clients are served completely, in bounded pieces",
         pipelined_requests_are_served_in_pieces, NULL, NULL, NULL},
        {"A step writes at most eight lines and the result, and compares at most 32 names", a_step_is_bounded, NULL,
         NULL, NULL},
        {"A step writes eight of the pending changes, the next step the others", a_step_is_used, NULL, NULL, NULL},
        {"Each client is served in turn, regardless of the requests of the others", clients_are_served_in_turn, NULL,
         NULL, NULL},
        {"Attack: a client that does not read causes no work, and gets the complete reply later",
         unread_replies_cost_nothing, NULL, NULL, NULL},
        {"A half-closed client gets a reply of many steps completely", a_half_closed_client_gets_a_long_reply, NULL,
         NULL, NULL},
        {"A client that epoll refuses is closed with a reason", a_client_that_cannot_be_waited_for, NULL, NULL, NULL},
        {"A half-closed client gets its reply", a_half_closed_client_gets_its_reply, NULL, NULL, NULL},
        {"A half-closed client that watches gets changes; after its end another client is accepted",
         a_half_closed_watcher_gets_changes, NULL, NULL, NULL},
        {"Requests before the end of a connection are executed", requests_before_the_end_of_a_connection, NULL, NULL,
         NULL},
        {"Attack: only changes are executed of the requests of sixteen closed connections",
         requests_of_closed_connections_are_skipped, NULL, NULL, NULL},
        {"A request is received byte by byte", a_request_in_pieces, NULL, NULL, NULL},
        {"A request of 4095 bytes waits for its line feed", the_line_feed_of_the_longest_request, NULL, NULL, NULL},
        {"Attack: zero bytes and too long requests are refused", zero_bytes_and_long_requests, NULL, NULL, NULL},
        {"Attack: the 17th client gets the reason and is closed", the_17th_client_gets_the_reason, NULL, NULL, NULL},
        {"An interrupted read is repeated, a failed one ends the connection", interrupted_reads_are_repeated, NULL,
         NULL, NULL},
        {"Attack: a client that ends before its refusal has no effect on others",
         a_client_that_is_gone_before_its_refusal, NULL, NULL, NULL},
        {"Attack: without a free descriptor a client gets the reason", no_descriptors, NULL, NULL, NULL},
        {"With the standard input closed, descriptor 0 is the spare one or that of a client", descriptor_0, NULL, NULL,
         NULL},
        {"Attack: without the spare descriptor the loop does not spin", no_descriptors_at_all, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Control socket: clients", tests, NULL, NULL);
}
