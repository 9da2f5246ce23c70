/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A chain of twins with its control socket, and clients of it. Each call of ect_control_serve is checked to be a
 * bounded piece of work: the linker leads its system calls through control_bench.c (tests/CMakeLists.txt).
 */
#ifndef TESTS_SUPPORT_CONTROL_BENCH_H
#define TESTS_SUPPORT_CONTROL_BENCH_H

#include "bus/chain/lamps.h"
#include "bus/control/control.h"
#include "support/wire.h"

#define OK "{\"ok\":true}\n"

enum { ANSWER_ROOM = 4 * 1024 * 1024 };

typedef struct bench {
    wire_t wire;
    ect_control_t *control;
    char folder[64];
    unsigned int descriptors; /* that were open before */
} bench_t;

/* The calls of one ect_control_serve. */
typedef struct bench_work {
    unsigned int receives, sends, accepts, waits, matches, lamps;
    size_t sent;
} bench_work_t;
extern bench_work_t work;

/* Whether epoll_ctl() refuses to add a descriptor. */
extern bool refuses_events;
extern bool refuses_memory; /* calloc() fails */
extern int receive_error;   /* of the next recv(); 0: none */

/* `count` (1..16) twins of a device of the catalogue, and the socket in a folder of its own. */
void open_bench(bench_t *b, const char *device, size_t count);
void close_bench(bench_t *b);

int connect_client(const bench_t *b);
void set_nonblocking(int fd);
void send_text(int fd, const char *text);
/* The bytes received so far, at most `room` - 1, and a zero. @return bytes */
size_t receive_text(int fd, char *text, size_t room);
size_t count_of(const char *text, const char *part);

/* @return whether the socket has something to do */
bool wants_to_be_served(const bench_t *b);
/* One call, checked for its bounds. */
void serve_once(bench_t *b);
/* Calls until nothing is left to do. @return calls */
unsigned int serve(bench_t *b);

/* One request on a connection of its own: the whole reply, or a part of it. */
void expect_answer(bench_t *b, const char *request, const char *want);
void expect_part(bench_t *b, const char *request, const char *part);

#endif
