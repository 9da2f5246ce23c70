/* SPDX-License-Identifier: MIT */
/*
 * Measurements of twins, one for each call, for tools/dev/bench/run.py, which defines their meaning. Each prints one
 * line of JSON.
 *
 *   ectwin-bench frames DEVICE PRESENT TOUCHED COMMAND FRAMES
 *       in this process, without a wire: for an instruction counter
 *   ectwin-bench axes AXES MS
 *       CiA 402 drives with their plants in this process, for MS milliseconds of their time
 *   ectwin-bench echo IFACE
 *       returns each frame, in blocking calls; runs until killed
 *   ectwin-bench spin IFACE
 *       returns each frame, without waiting
 *   ectwin-bench port IFACE
 *       returns each frame, with the sockets and the filter of system calls of a twin
 *   ectwin-bench round IFACE ECHO DEVICE PRESENT TOUCHED N
 *       N round trips in turns with N of an echo
 *   ectwin-bench echoes IFACE ECHO BYTES N
 *       the same for two echoes, with an LRW of BYTES bytes
 *   ectwin-bench first IFACE
 *       one BRD of AL status: the start of twins in this process
 *   ectwin-bench sdo IFACE DEVICE N
 *       N uploads of 1018h:1
 *   ectwin-bench cycle IFACE DEVICE PRESENT TOUCHED CYCLES [PERIOD_US]
 *       all process data of TOUCHED twins in each of CYCLES, a millisecond or PERIOD_US long
 */
#define _GNU_SOURCE
#include <arpa/inet.h>
#include <errno.h>
#include <linux/if_ether.h>
#include <linux/if_packet.h>
#include <net/if.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

#include "axes.h"
#include "bus/chain/catalogue.h"
#include "bus/chain/chain.h"
#include "bus/net/packet.h"
#include "bus/net/sandbox.h"
#include "esc/route.h"
#include "master.h"
#include "wire/bytes.h"
#include "wire/registers.h"

enum { LARGEST = 1486, BATCH = 100, SOURCE = 6, LOCAL = 0x02 };

static _Noreturn void end(const char *what)
{
    fprintf(stderr, "ectwin-bench: %s%s%s\n", what, errno != 0 ? ": " : "", errno != 0 ? strerror(errno) : "");
    exit(1);
}

static uint64_t now_ns(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
}

/* --- transports of a frame ---------------------------------------------------------------------------------------- */

static int set_up(int fd, const char *iface)
{
    const struct timeval patience = {.tv_usec = 200000};
    const int on = 1;
    struct sockaddr_ll address = {.sll_family = AF_PACKET, .sll_protocol = htons(0x88A4)};
    address.sll_ifindex = (int)if_nametoindex(iface);
    if (fd < 0 || address.sll_ifindex == 0 || setsockopt(fd, SOL_PACKET, PACKET_IGNORE_OUTGOING, &on, sizeof on) < 0 ||
        setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience) < 0 ||
        bind(fd, (const struct sockaddr *)&address, sizeof address) < 0)
        end(iface);
    return fd;
}

static int open_port(const char *iface)
{
    return set_up(socket(AF_PACKET, SOCK_RAW, 0), iface);
}

/* Opens a socket of the kernel, even if `ectwin with --in-process` replaces those of the C library. */
static int open_wire(const char *iface)
{
    return set_up((int)syscall(SYS_socket, AF_PACKET, SOCK_RAW, 0), iface);
}

static bool over_wire(master_t *m)
{
    int fd = *(const int *)m->ctx;
    if (send(fd, m->frame, m->length, 0) < 0)
        return false;
    return recv(fd, m->frame, sizeof m->frame, 0) == (ssize_t)m->length;
}

typedef struct virtual
{
    ect_chain_t *chain;
    uint64_t now_ns;
}
virtual_t;

static bool in_process(master_t *m)
{
    virtual_t *v = m->ctx;
    bool back = ect_chain_process(v->chain, m->frame, m->length, v->now_ns);
    (void)ect_chain_poll(v->chain, v->now_ns);
    return back;
}

static const ect_product_t *product_of(const char *name)
{
    const ect_product_t *product = ect_catalogue_find(name);
    if (!product)
        end("no such device");
    return product;
}

/* @return bytes of process data. @param[out] expected  working counter of an LRW over all of them */
static uint32_t prepare(master_t *m, const ect_device_t *device, size_t present, size_t touched, unsigned int *expected)
{
    uint32_t logical = 0;
    if (!master_address(m, present))
        end("the twins do not answer");
    for (size_t i = 0; i < touched; i++) {
        if (!master_operate(m, device, i, &logical, expected))
            end("a twin does not get into OP");
    }
    return logical;
}

static void build_lrw(master_t *m, uint32_t address, uint32_t bytes)
{
    uint32_t length = bytes < LARGEST ? bytes : LARGEST;
    master_build(m, ECT_LRW, (uint16_t)address, (uint16_t)(address >> 16), (uint16_t)length);
}

/* --- frames ------------------------------------------------------------------------------------------------------- */

static void build_command(master_t *m, const char *command, uint32_t bytes)
{
    if (strcmp(command, "LRW") == 0)
        build_lrw(m, 0, bytes);
    else if (strcmp(command, "BRD") == 0)
        master_build(m, ECT_BRD, 0, ECT_REG_AL_STATUS, 2);
    else if (strcmp(command, "FPRD") == 0)
        master_build(m, ECT_FPRD, MASTER_STATION, ECT_REG_AL_STATUS, 2);
    else if (strcmp(command, "FRMW") == 0)
        master_build(m, ECT_FRMW, MASTER_STATION, ECT_REG_DC_SYSTEM_TIME, 8);
    else
        end("COMMAND is LRW, BRD, FPRD or FRMW");
}

/* The counter covers ect_chain_pass and ect_chain_poll; one call before excludes their preparation. */
static int frames(char **argument)
{
    const ect_product_t *product = product_of(argument[0]);
    size_t present = strtoul(argument[1], NULL, 10);
    unsigned int expected = 0;
    unsigned long count = strtoul(argument[4], NULL, 10);
    ect_twin_config_t *twins = calloc(present, sizeof *twins);
    for (size_t i = 0; twins && i < present; i++)
        twins[i] = ect_twin_default(product->device, product->plant);
    virtual_t v = {.now_ns = 1000000000u};
    v.chain = twins ? ect_chain_new(twins, present, v.now_ns) : NULL;
    if (!v.chain)
        end("not enough memory");
    master_t m = {.exchange = in_process, .ctx = &v};
    uint32_t bytes = prepare(&m, product->device, present, strtoul(argument[2], NULL, 10), &expected);
    unsigned int counter = 0;
    for (unsigned long i = 0; i < count; i++) {
        v.now_ns += 1000;
        build_command(&m, argument[3], bytes);
        if (!in_process(&m))
            end("no answer");
        counter = master_counter(&m);
    }
    printf("{\"device\":\"%s\",\"present\":%zu,\"command\":\"%s\",\"frames\":%lu,\"working_counter\":%u}\n",
           argument[0], present, argument[3], count, counter);
    ect_chain_free(v.chain);
    free(twins);
    return 0;
}

/* --- echo --------------------------------------------------------------------------------------------------------- */

static _Noreturn void echo(char **argument, int flags)
{
    uint8_t frame[MASTER_FRAME];
    int fd = open_port(argument[0]);
    for (;;) {
        ssize_t length = recv(fd, frame, sizeof frame, flags);
        if (length <= 0)
            continue;
        frame[SOURCE] |= LOCAL;
        (void)send(fd, frame, (size_t)length, 0);
    }
}

static int echo_waiting(char **argument)
{
    echo(argument, 0);
}

static int echo_spinning(char **argument)
{
    echo(argument, MSG_DONTWAIT);
}

static int echo_by_port(char **argument)
{
    char message[ECT_PACKET_MESSAGE];
    uint8_t frame[MASTER_FRAME];
    ect_packet_t port;
    ect_packet_time_t time;
    if (ect_packet_open(&port, argument[0], message) < 0)
        end(message);
    if (ect_sandbox_enter(false, false, false) < 0)
        end("the filter of system calls");
    for (;;) {
        ssize_t length = ect_packet_receive(&port, true, frame, sizeof frame, &time);
        if (length <= 0)
            continue;
        frame[SOURCE] |= LOCAL;
        ect_packet_send(&port, frame, (size_t)length);
    }
}

/* --- round trips -------------------------------------------------------------------------------------------------- */

static int by_size(const void *a, const void *b)
{
    uint32_t x = *(const uint32_t *)a;
    uint32_t y = *(const uint32_t *)b;
    return (x > y) - (x < y);
}

static uint32_t one_round(master_t *m, uint32_t bytes)
{
    build_lrw(m, 0, bytes);
    uint64_t start = now_ns();
    if (!m->exchange(m))
        end("an answer is missing");
    return (uint32_t)(now_ns() - start);
}

/* @param times_ns in ascending order */
static double median(const uint32_t *times_ns, size_t count)
{
    size_t middle = count / 2;
    return (double)times_ns[middle];
}

static void print_times(const char *name, uint32_t *times, size_t count)
{
    qsort(times, count, sizeof *times, by_size);
    printf("\"%s\":{\"median_ns\":%u,\"p90_ns\":%u,\"p99_ns\":%u},", name, times[count / 2], times[count * 9 / 10],
           times[count * 99 / 100]);
}

/* Round trips on two wires. */
typedef struct pair {
    master_t twin, bare;
    int fds[2];
    uint32_t *twin_ns, *bare_ns;
    size_t count;          /* of each, a multiple of BATCH */
    uint32_t bytes;        /* of process data */
    unsigned int expected; /* working counter */
    unsigned int wrong;
} pair_t;

static void open_pair(pair_t *p, char **argument, const char *count)
{
    p->fds[0] = open_port(argument[0]);
    p->fds[1] = open_wire(argument[1]);
    p->twin = (master_t){.exchange = over_wire, .ctx = &p->fds[0]};
    p->bare = (master_t){.exchange = over_wire, .ctx = &p->fds[1]};
    p->count = strtoul(count, NULL, 10) / BATCH * BATCH;
    p->twin_ns = calloc(p->count + BATCH, sizeof *p->twin_ns);
    p->bare_ns = calloc(p->count + BATCH, sizeof *p->bare_ns);
    if (!p->twin_ns || !p->bare_ns || p->count == 0)
        end("not enough memory, or fewer than 100 rounds");
}

/* Measures in turns, so that other load of the machine affects both. The first round of each batch does not count,
 * because the other program has used the caches. */
static void exchange_in_turns(pair_t *p)
{
    for (size_t at = 0; at < p->count; at += BATCH) {
        (void)one_round(&p->bare, p->bytes);
        for (size_t i = 0; i < BATCH; i++)
            p->bare_ns[at + i] = one_round(&p->bare, p->bytes);
        (void)one_round(&p->twin, p->bytes);
        for (size_t i = 0; i < BATCH; i++) {
            p->twin_ns[at + i] = one_round(&p->twin, p->bytes);
            p->wrong += p->bytes <= LARGEST && master_counter(&p->twin) != p->expected;
        }
    }
}

static void print_pair(const pair_t *p)
{
    printf("\"bytes\":%u,\"rounds\":%zu,\"wrong\":%u,", p->bytes < LARGEST ? p->bytes : LARGEST, p->count, p->wrong);
    print_times("twin", p->twin_ns, p->count);
    print_times("echo", p->bare_ns, p->count);
    printf("\"ratio\":%.3f}\n", median(p->twin_ns, p->count) / median(p->bare_ns, p->count));
}

static int round_trips(char **argument)
{
    const ect_device_t *device = product_of(argument[2])->device;
    size_t present = strtoul(argument[3], NULL, 10);
    pair_t p = {0};
    open_pair(&p, argument, argument[5]);
    p.bytes = prepare(&p.twin, device, present, strtoul(argument[4], NULL, 10), &p.expected);
    exchange_in_turns(&p);
    printf("{\"device\":\"%s\",\"present\":%zu,\"touched\":%s,", argument[2], present, argument[4]);
    print_pair(&p);
    return 0;
}

static int echoes(char **argument)
{
    pair_t p = {0};
    open_pair(&p, argument, argument[3]);
    p.bytes = (uint32_t)strtoul(argument[2], NULL, 10);
    exchange_in_turns(&p);
    printf("{");
    print_pair(&p);
    return 0;
}

static int first(char **argument)
{
    int fd = open_port(argument[0]);
    uint8_t status[2] = {0};
    master_t m = {.exchange = over_wire, .ctx = &fd};
    int counter = master_send(&m, ECT_BRD, 0, ECT_REG_AL_STATUS, status, sizeof status);
    if (counter < 0)
        end("an answer is missing");
    printf("{\"working_counter\":%d}\n", counter);
    return 0;
}

/* --- SDOs --------------------------------------------------------------------------------------------------------- */

static int sdos(char **argument)
{
    const ect_device_t *device = product_of(argument[1])->device;
    unsigned long count = strtoul(argument[2], NULL, 10);
    int fd = open_port(argument[0]);
    master_t m = {.exchange = over_wire, .ctx = &fd};
    unsigned int expected = 0;
    (void)prepare(&m, device, 1, 1, &expected);
    uint64_t start = now_ns();
    for (unsigned long i = 0; i < count; i++) {
        if (!master_sdo(&m, device, 0))
            end("an SDO upload failed");
    }
    double seconds = (double)(now_ns() - start) / 1e9;
    printf("{\"device\":\"%s\",\"uploads\":%lu,\"per_second\":%.0f}\n", argument[1], count, (double)count / seconds);
    return 0;
}

/* --- cycles ------------------------------------------------------------------------------------------------------- */

static void sleep_until(uint64_t at_ns)
{
    const struct timespec at = {.tv_sec = (time_t)(at_ns / 1000000000u), .tv_nsec = (long)(at_ns % 1000000000u)};
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, NULL) == EINTR)
        ;
}

/* @return the number of lost frames of a cycle, of `most` bytes each */
static unsigned int one_cycle(master_t *m, uint32_t bytes, uint32_t most, unsigned int *counter)
{
    int fd = *(const int *)m->ctx;
    unsigned int out = 0;
    unsigned int in = 0;
    for (uint32_t at = 0; at < bytes; at += most, out++) {
        build_lrw(m, at, bytes - at < most ? bytes - at : most);
        if (send(fd, m->frame, m->length, 0) < 0)
            end("send");
    }
    for (*counter = 0; in < out && recv(fd, m->frame, sizeof m->frame, 0) > 0; in++)
        *counter += master_counter(m);
    return out - in;
}

/* Counts of sorted times, 20 steps for a factor of 10: step n has those below 1 us * 10^(n / 20), the last one all
 * others.
 */
static void print_steps(const uint32_t *times, size_t count)
{
    enum { STEPS = 120 };
    double edge_ns = 1000;
    size_t at = 0;
    for (unsigned int step = 0; step < STEPS; step++) {
        size_t before = at;
        while (at < count && (step + 1 == STEPS || times[at] < edge_ns))
            at++;
        printf("%s%zu", step > 0 ? "," : "\"steps\":[", at - before);
        edge_ns *= 1.1220184543;
    }
    printf("],");
}

static int cycles(char **argument)
{
    const char *period_us = argument[5]; /* NULL: 1000 */
    const ect_device_t *device = product_of(argument[1])->device;
    size_t present = strtoul(argument[2], NULL, 10);
    unsigned long count = strtoul(argument[4], NULL, 10);
    int fd = open_port(argument[0]);
    master_t m = {.exchange = over_wire, .ctx = &fd};
    unsigned int expected = 0;
    uint32_t bytes = prepare(&m, device, present, strtoul(argument[3], NULL, 10), &expected);
    const uint32_t each = bytes / (uint32_t)strtoul(argument[3], NULL, 10); /* a frame has whole images */
    const uint64_t period_ns = (period_us ? strtoul(period_us, NULL, 10) : 1000) * 1000;
    uint32_t *times_ns = calloc(count + 1, sizeof *times_ns);
    unsigned long lost = 0, late = 0;
    if (!times_ns || count == 0)
        end("not enough memory, or no cycle");
    uint64_t next = now_ns() + period_ns;
    for (unsigned long i = 0; i < count; i++, next += period_ns) {
        unsigned int counter;
        sleep_until(next);
        uint64_t sent = now_ns();
        lost += one_cycle(&m, bytes, LARGEST / each * each, &counter);
        times_ns[i] = (uint32_t)(now_ns() - sent);
        late += now_ns() > next + period_ns;
    }
    printf("{");
    print_times("exchange", times_ns, count);
    print_steps(times_ns, count);
    printf("\"device\":\"%s\",\"present\":%zu,\"touched\":%s,\"bytes\":%u,\"cycles\":%lu,\"frames_lost\":%lu,"
           "\"longest_ns\":%u,\"cycles_too_long\":%lu}\n",
           argument[1], present, argument[3], bytes, count, lost, times_ns[count - 1], late);
    free(times_ns);
    return 0;
}

/* Each measurement: its name, the number of its arguments, its function. */
static const struct {
    const char *name;
    int least, most;
    int (*run)(char **argument);
} MEASUREMENTS[] = {
    {"frames", 5, 5, frames},      {"axes", 2, 2, axes},         {"echo", 1, 1, echo_waiting},
    {"spin", 1, 1, echo_spinning}, {"port", 1, 1, echo_by_port}, {"round", 6, 6, round_trips},
    {"echoes", 4, 4, echoes},      {"first", 1, 1, first},       {"sdo", 3, 3, sdos},
    {"cycle", 5, 6, cycles},
};

int main(int count, char **argument)
{
    errno = 0;
    for (size_t i = 0; count > 1 && i < sizeof MEASUREMENTS / sizeof *MEASUREMENTS; i++) {
        bool fits = count - 2 >= MEASUREMENTS[i].least && count - 2 <= MEASUREMENTS[i].most;
        if (fits && strcmp(argument[1], MEASUREMENTS[i].name) == 0)
            return MEASUREMENTS[i].run(argument + 2);
    }
    end("use tools/dev/bench/run.py");
}
