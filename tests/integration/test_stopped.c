/* SPDX-License-Identifier: MIT */
/*
 * Process data during a program that stops the twins' process at random (SIGSTOP) and lets it continue: no image is
 * torn, no image and no reply is lost, and the watchdog of outputs expires only if no frame arrived.
 *
 * usage: test_stopped IFACE PID CYCLES [SEED]     the slave is a tally (tests/support/tally.h), PID its process
 */
#define _GNU_SOURCE
#include <arpa/inet.h>
#include <errno.h>
#include <linux/if_packet.h>
#include <net/if.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

#include <setjmp.h>
#include <stdarg.h>

#include <cmocka.h>

#include "esc/route.h"
#include "master.h"
#include "seams/random.h"
#include "support/tally.h"
#include "wire/bytes.h"
#include "wire/registers.h"

enum {
    NS_PER_US = 1000,
    NS_PER_MS = 1000000,
    PATIENCE_S = 200, /* for a reply: a machine may stand still */
    WATCHDOG_MS = 100,
    LONGEST_PAUSE_US = 2000,
    LONGEST_RUN_US = 20000,
    SHORT_STOP_US = 5000,
    LONG_STOP_US = 180000,
    STATUS_EACH = 16,   /* cycles between reads of AL status by BRD, which the kernel replies to, */
    STATUS_OF_ONE = 25, /* of which so many are one by FPRD, which the twin replies to */
    WHILE_STOPPED = 100,
    CATCH_UP = 10000,
    INDEX = 17,
    LOGICAL = 0x100,
    IMAGE = 4 * TALLY_WORDS
};

static const char *iface;
static unsigned int least_cycles;
static uint32_t seed = 1;

static uint64_t now_ns(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
}

/* Between 0 and `most_us`, uniform. */
static void rest(uint32_t *random, uint32_t most_us)
{
    uint32_t us = (uint32_t)((uint64_t)ect_random_next(random) * most_us >> 32);
    const struct timespec pause = {.tv_nsec = (long)us * NS_PER_US};
    (void)nanosleep(&pause, NULL);
}

/* --- the program that stops the twins ----------------------------------------------------------------------------- */

typedef struct stopper {
    pthread_t thread;
    pid_t pid;
    uint32_t random;
    atomic_bool ends;
    atomic_uint changes; /* an odd number: the process stands still */
} stopper_t;

static stopper_t stopper;

/* Its state as the kernel shows it: T, stopped. */
static bool is_stopped(pid_t pid)
{
    char path[40], text[400];
    snprintf(path, sizeof path, "/proc/%d/stat", (int)pid);
    FILE *file = fopen(path, "re");
    size_t length = file ? fread(text, 1, sizeof text - 1, file) : 0;
    if (file)
        fclose(file);
    text[length] = '\0';
    const char *behind_name = strrchr(text, ')');
    return behind_name && strncmp(behind_name, ") T", 3) == 0;
}

static void *stop_at_random(void *ctx)
{
    stopper_t *s = ctx;
    while (!s->ends) {
        rest(&s->random, LONGEST_RUN_US);
        (void)kill(s->pid, SIGSTOP);
        while (!is_stopped(s->pid) && !s->ends)
            rest(&s->random, 100);
        s->changes++;
        rest(&s->random, ect_random_next(&s->random) % 2 == 0 ? SHORT_STOP_US : LONG_STOP_US);
        s->changes++;
        (void)kill(s->pid, SIGCONT);
    }
    return NULL;
}

static int start_stopper(void **state)
{
    (void)state;
    stopper.random = seed + 1;
    return pthread_create(&stopper.thread, NULL, stop_at_random, &stopper);
}

static int end_stopper(void **state)
{
    (void)state;
    if (!stopper.ends) {
        stopper.ends = true;
        pthread_join(stopper.thread, NULL);
    }
    return 0;
}

/* --- the master --------------------------------------------------------------------------------------------------- */

typedef struct run {
    master_t m;
    int fd;
    uint32_t random;
    uint8_t index;
    uint16_t bytes;        /* of all process data */
    unsigned int expected; /* working counter */
    uint32_t sent;         /* the newest outputs */
    uint32_t seen;         /* the newest inputs */
    uint64_t outputs_ns;   /* sending of the newest outputs; 0: none since OP */
    unsigned int cycles, while_stopped, starts;
} run_t;

static int open_wire(void)
{
    const struct timeval patience = {.tv_sec = PATIENCE_S};
    const int on = 1;
    struct sockaddr_ll address = {.sll_family = AF_PACKET, .sll_protocol = htons(0x88A4)};
    address.sll_ifindex = (int)if_nametoindex(iface);
    int fd = socket(AF_PACKET, SOCK_RAW | SOCK_CLOEXEC, 0);
    assert_true(fd >= 0 && address.sll_ifindex != 0);
    assert_int_equal(setsockopt(fd, SOL_PACKET, PACKET_IGNORE_OUTGOING, &on, sizeof on), 0);
    assert_int_equal(setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience), 0);
    assert_int_equal(bind(fd, (const struct sockaddr *)&address, sizeof address), 0);
    return fd;
}

/* One frame is on its way at a time, so a reply with another index is one too many. */
static bool exchange(master_t *m)
{
    run_t *r = m->ctx;
    m->frame[INDEX] = ++r->index;
    assert_int_equal(send(r->fd, m->frame, m->length, 0), (ssize_t)m->length);
    ssize_t length = recv(r->fd, m->frame, sizeof m->frame, 0);
    if (length < 0)
        fail_msg("cycle %u: no reply (%s)", r->cycles, strerror(errno));
    assert_int_equal(length, m->length);
    assert_int_equal(m->frame[INDEX], r->index);
    return true;
}

static void start(run_t *r)
{
    uint32_t logical = LOGICAL;
    uint8_t time[2];
    r->expected = 0;
    r->sent = r->seen = 0;
    r->outputs_ns = 0;
    r->starts++;
    assert_true(master_address(&r->m, 1));
    assert_true(master_operate(&r->m, &tally, 0, &logical, &r->expected));
    r->bytes = (uint16_t)(logical - LOGICAL);
    assert_int_equal(r->bytes, 2 * IMAGE);
    ect_store_le16(time, WATCHDOG_MS * 10);
    assert_int_equal(master_send(&r->m, ECT_FPWR, MASTER_STATION, ECT_REG_WD_TIME_PD, time, sizeof time), 1);
}

/* Whether outputs came so late that the watchdog may have expired: the machine or the stopper kept the reply back. */
static bool may_have_expired(const run_t *r)
{
    return r->outputs_ns != 0 && now_ns() - r->outputs_ns >= (uint64_t)WATCHDOG_MS * NS_PER_MS;
}

static void fill(uint8_t *image, uint32_t value)
{
    for (unsigned int i = 0; i < TALLY_WORDS; i++)
        ect_store_le32(image + (size_t)4 * i, value);
}

/* All words of both images, and the order of the inputs. */
static void check_images(run_t *r)
{
    const uint8_t *data = master_data(&r->m);
    uint8_t same[2 * IMAGE];
    uint32_t inputs = ect_load_le32(data + IMAGE);
    fill(same, r->sent);
    fill(same + IMAGE, inputs);
    if (memcmp(data, same, sizeof same) != 0)
        fail_msg("cycle %u: outputs %u, inputs %u: the reply has other words too", r->cycles, r->sent, inputs);
    if (inputs == TALLY_BROKEN)
        fail_msg("cycle %u: the device has got torn outputs, or has missed some", r->cycles);
    if (inputs < r->seen || inputs >= r->sent)
        fail_msg("cycle %u: inputs %u after %u, before outputs %u", r->cycles, inputs, r->seen, r->sent);
    r->seen = inputs;
}

/* @return false: the watchdog may have expired */
static bool cycle(run_t *r)
{
    unsigned int before = stopper.changes;
    master_build(&r->m, ECT_LRW, LOGICAL, 0, r->bytes);
    fill(master_data(&r->m), ++r->sent);
    uint64_t sent_ns = now_ns();
    (void)exchange(&r->m);
    r->while_stopped += before % 2 == 1 && before == stopper.changes;
    if (may_have_expired(r))
        return false;
    r->outputs_ns = sent_ns;
    r->cycles++;
    assert_int_equal(master_counter(&r->m), r->expected);
    check_images(r);
    return true;
}

/* @return false: the watchdog may have expired */
static bool is_in_op(run_t *r)
{
    uint8_t status[2] = {0};
    bool all = r->cycles / STATUS_EACH % STATUS_OF_ONE != 0;
    int counter = master_send(&r->m, all ? ECT_BRD : ECT_FPRD, all ? 0 : MASTER_STATION, ECT_REG_AL_STATUS, status,
                              sizeof status);
    if (may_have_expired(r))
        return false;
    assert_int_equal(counter, 1);
    assert_int_equal(status[0], ECT_STATE_OP);
    return true;
}

/* After the last stop the twin shows the newest outputs. */
static void catch_up(run_t *r)
{
    for (unsigned int i = 0; i < CATCH_UP && r->seen + 1 != r->sent; i++) {
        if (!cycle(r))
            start(r);
        rest(&r->random, LONGEST_PAUSE_US);
    }
    assert_int_equal(r->seen + 1, r->sent);
}

static void stopped_at_random(void **state)
{
    static run_t r;
    (void)state;
    r = (run_t){.random = seed, .fd = open_wire()};
    r.m = (master_t){.exchange = exchange, .ctx = &r};
    start(&r);
    while (r.cycles < least_cycles || r.while_stopped < WHILE_STOPPED) {
        bool in_time = cycle(&r) && (r.cycles % STATUS_EACH != 0 || is_in_op(&r));
        if (!in_time)
            start(&r);
        if (ect_random_next(&r.random) % 8 != 0)
            rest(&r.random, LONGEST_PAUSE_US);
    }
    (void)end_stopper(NULL);
    catch_up(&r);
    print_message("%u cycles, %u of them while the process stood still in %u stops; %u starts\n", r.cycles,
                  r.while_stopped, stopper.changes / 2, r.starts);
    close(r.fd);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"CF-010 CF-028: a twin that is stopped at random loses no image, and tears none", stopped_at_random,
         start_stopper, end_stopper, NULL},
    };
    if (argc < 4) {
        fprintf(stderr, "usage: test_stopped IFACE PID CYCLES [SEED]\n");
        return 2;
    }
    iface = argv[1];
    stopper.pid = (pid_t)strtol(argv[2], NULL, 10);
    least_cycles = (unsigned int)strtoul(argv[3], NULL, 10);
    if (argc > 4)
        seed = (uint32_t)strtoul(argv[4], NULL, 10);
    return cmocka_run_group_tests_name("stopped at random", tests, NULL, NULL);
}
