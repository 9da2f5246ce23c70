/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bus/inprocess/threads.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <linux/futex.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include "bus/inprocess/bus.h"
#include "bus/inprocess/real.h"
#include "bus/inprocess/time.h"
#include "wire/assert.h"

#define NEVER UINT64_MAX

enum { THREADS_MOST = 1024 };
enum { SERVE_EVERY = 64, LOOK_EVERY = 16, IDLE_MS = 10, PATIENCE_MS = 1000, PAUSE_NS = 1000 };

typedef enum state { READY, RUNNING, WAITING, OUTSIDE } state_t;

typedef struct thread {
    struct thread *next;
    bool used;
    state_t state;
    uint64_t order; /* of becoming ready, or of beginning to wait */
    uint64_t until_ns;
    const void *key;
    bool (*condition)(void *arg);
    void *arg;
    bool outside; /* another process may make the condition true */
    bool woken;
    int *ended; /* set when the thread ends */
    bool reported;
    pid_t id;
    int turn; /* a futex: 1 when the thread may go on */
} thread_t;

const bool ect_time_is_virtual = true;

/* Guarded by `mutex`, which is held for moments only; the bus is touched with it held. */
static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
static uint64_t now_ns = ECT_VIRTUAL_START_NS;
static uint64_t bus_next_ns = NEVER;
static uint64_t orders;
static unsigned int calls; /* since a client was served */
static thread_t *threads;
static thread_t *running;
static ect_timer_t *timers;
static __thread thread_t *self __attribute__((tls_model("initial-exec")));
static pthread_key_t at_end;
static pthread_once_t once = PTHREAD_ONCE_INIT;

static void lock(void)
{
    REAL(pthread_mutex_lock)(&mutex);
    ect_inside++; /* an allocator that is called with the lock may read the clock */
}

static void unlock(void)
{
    ect_inside--;
    REAL(pthread_mutex_unlock)(&mutex);
}

void ect_time_lock(void)
{
    (void)ect_virtual_now(); /* a thread that is new here gets its turn first */
    lock();
}

void ect_time_unlock(void)
{
    unlock();
}

/* --- the turn ------------------------------------------------------------------------------------------------------
 */

static void wake_up(thread_t *thread)
{
    __atomic_store_n(&thread->turn, 1, __ATOMIC_RELEASE);
    REAL(syscall)(SYS_futex, &thread->turn, FUTEX_WAKE_PRIVATE, 1, NULL, NULL, 0);
}

static void run_timers(void)
{
    for (ect_timer_t *timer = timers; timer; timer = timer->next) {
        if (timer->next_ns > now_ns)
            continue;
        timer->next_ns = timer->interval_ns > 0 ? timer->next_ns + timer->interval_ns : NEVER;
        timer->expired(timer);
    }
}

/* Lets time pass up to `to_ns` in the steps that bus and timers ask for. */
static void advance(uint64_t to_ns)
{
    while (now_ns < to_ns || bus_next_ns <= now_ns) {
        uint64_t step_ns = bus_next_ns < to_ns ? bus_next_ns : to_ns;
        for (const ect_timer_t *timer = timers; timer; timer = timer->next)
            step_ns = timer->next_ns < step_ns ? timer->next_ns : step_ns;
        bool again = step_ns <= now_ns; /* a bus that is due again at once gets a pause, so that time goes on */
        now_ns = step_ns > now_ns ? step_ns : now_ns;
        if (bus_next_ns <= now_ns && ect_bus_running())
            bus_next_ns = ect_bus_run(now_ns);
        run_timers();
        if (again && bus_next_ns <= now_ns)
            bus_next_ns = now_ns + PAUSE_NS;
    }
}

static void make_ready(thread_t *thread, bool woken)
{
    thread->state = READY;
    thread->woken = woken;
    thread->order = ++orders;
    thread->key = NULL;
    thread->condition = NULL;
    thread->outside = false;
}

/* The waiting thread that has waited longest among those for which `due` holds. */
static thread_t *first_waiting(bool (*due)(const thread_t *thread))
{
    thread_t *first = NULL;
    for (thread_t *one = threads; one; one = one->next) {
        if (one->state == WAITING && due(one) && (!first || one->order < first->order))
            first = one;
    }
    return first;
}

static bool condition_holds(const thread_t *thread)
{
    return thread->condition && thread->condition(thread->arg);
}

static bool deadline_has_passed(const thread_t *thread)
{
    return thread->until_ns <= now_ns;
}

static void make_timely_ready(void)
{
    thread_t *thread;
    while ((thread = first_waiting(deadline_has_passed)))
        make_ready(thread, false);
}

static void make_due_ready(void)
{
    thread_t *thread;
    while ((thread = first_waiting(condition_holds)))
        make_ready(thread, true);
    make_timely_ready();
}

static thread_t *first_ready(void)
{
    thread_t *first = NULL;
    for (thread_t *one = threads; one; one = one->next) {
        if (one->state == READY && (!first || one->order < first->order))
            first = one;
    }
    return first;
}

/* The time at which something happens although every thread waits. */
static uint64_t next_event(void)
{
    uint64_t next_ns = bus_next_ns;
    for (const thread_t *one = threads; one; one = one->next) {
        if (one->state == WAITING && one->until_ns < next_ns)
            next_ns = one->until_ns;
    }
    for (const ect_timer_t *timer = timers; timer; timer = timer->next)
        next_ns = timer->next_ns < next_ns ? timer->next_ns : next_ns;
    return next_ns;
}

static bool any_timed_wait(void)
{
    for (const thread_t *one = threads; one; one = one->next) {
        if (one->state == WAITING && one->until_ns != NEVER)
            return true;
    }
    for (const ect_timer_t *timer = timers; timer; timer = timer->next) {
        if (timer->next_ns != NEVER)
            return true;
    }
    return false;
}

/* Every thread waits without a limit: only the world outside can make one ready. Time passes as it does there. */
static void wait_for_the_world(void)
{
    const struct timespec pause = {.tv_nsec = IDLE_MS * 1000000};
    unlock();
    (void)REAL(nanosleep)(&pause, NULL);
    lock();
    advance(now_ns + IDLE_MS * 1000000ull);
}

/* @return whether a client was served */
static bool serve_client(void)
{
    calls = 0;
    if (!ect_bus_running() || !ect_bus_serve(now_ns))
        return false;
    bus_next_ns = ect_bus_run(now_ns);
    return true;
}

/* A thread that waits for a descriptor may be a client of the control socket, or wait for one. */
static bool any_external_wait(void)
{
    for (const thread_t *one = threads; one; one = one->next) {
        if (one->state == WAITING && one->outside)
            return true;
    }
    return false;
}

/* Chooses who runs next; with the lock. NULL: no thread is left that could. */
static thread_t *choose(void)
{
    for (;;) {
        thread_t *thread;
        make_due_ready();
        thread = first_ready();
        if (thread || !threads)
            return thread;
        bool waits = false;
        for (const thread_t *one = threads; one; one = one->next)
            waits |= one->state == WAITING;
        if (!waits)
            return NULL;
        if (any_external_wait() && serve_client())
            continue;
        if (any_timed_wait())
            advance(next_event());
        else
            wait_for_the_world();
        if (++calls >= SERVE_EVERY)
            (void)serve_client();
    }
}

static bool sleeps_in_kernel(pid_t id)
{
    char path[64];
    char text[256];
    snprintf(path, sizeof path, "/proc/self/task/%d/stat", (int)id);
    int fd = open(path, O_RDONLY | O_CLOEXEC);
    ssize_t length = fd >= 0 ? REAL(read)(fd, text, sizeof text - 1) : -1;
    if (fd >= 0)
        REAL(close)(fd);
    if (length <= 0)
        return false;
    text[length] = 0;
    const char *name_end = strrchr(text, ')');
    return name_end && name_end[1] == ' ' && name_end[2] == 'S';
}

static void pass_turn(thread_t *thread)
{
    running = thread;
    if (thread)
        thread->state = RUNNING;
    if (thread && thread != self)
        wake_up(thread);
}

/* The running thread has made no call for a second. If it sleeps in the kernel, the turn goes to another one. */
static void take_turn_away(void)
{
    thread_t *stuck = running;
    if (!stuck || stuck->state != RUNNING || !sleeps_in_kernel(stuck->id))
        return;
    if (!stuck->reported)
        (void)!dprintf(STDERR_FILENO,
                       "ectwin: --virtual-time: a thread waits for something that the virtual clock does not know; "
                       "from here on the run is not reproducible\n");
    stuck->reported = true;
    stuck->state = OUTSIDE;
    pass_turn(choose());
}

/* Without the lock; returns when this thread has the turn. */
static void await_turn(void)
{
    const struct timespec patience = {.tv_sec = PATIENCE_MS / 1000};
    const thread_t *before = NULL;
    uint64_t before_ns = 0;
    while (__atomic_exchange_n(&self->turn, 0, __ATOMIC_ACQUIRE) == 0) {
        long result = REAL(syscall)(SYS_futex, &self->turn, FUTEX_WAIT_PRIVATE, 0, &patience, NULL, 0);
        if (result == 0 || errno != ETIMEDOUT)
            continue;
        lock();
        if (running == before && now_ns == before_ns)
            take_turn_away();
        before = running;
        before_ns = now_ns;
        unlock();
    }
}

/* Gives the turn away and waits for it. With the lock; returns without. */
static void release_turn(void)
{
    thread_t *chosen = choose();
    bool mine = chosen == self;
    pass_turn(chosen);
    unlock();
    if (!mine)
        await_turn();
}

/* --- threads -------------------------------------------------------------------------------------------------------
 */

/* No heap: an allocator may read the clock, and be the first of a thread to call this library. */
static thread_t *free_record(void)
{
    static thread_t records[THREADS_MOST];
    for (size_t i = 0; i < THREADS_MOST; i++) {
        if (!records[i].used)
            return &records[i];
    }
    return NULL;
}

static thread_t *add_thread(int *ended)
{
    lock();
    thread_t *thread = free_record();
    if (!thread) {
        unlock();
        return NULL;
    }
    *thread = (thread_t){.used = true};
    thread->ended = ended;
    thread->next = threads;
    threads = thread;
    make_ready(thread, false);
    unlock();
    return thread;
}

static void remove_thread(thread_t *thread)
{
    for (thread_t **at = &threads; *at; at = &(*at)->next) {
        if (*at == thread) {
            *at = thread->next;
            break;
        }
    }
    thread->used = false;
}

static void on_thread_end(void *unused)
{
    (void)unused;
    ect_virtual_thread_end();
}

/* The child of fork has one thread, the one that called it, and no bus. */
static void in_child(void)
{
    thread_t *mine = self;
    mutex = (pthread_mutex_t)PTHREAD_MUTEX_INITIALIZER;
    threads = mine;
    running = mine;
    timers = NULL;
    bus_next_ns = NEVER;
    if (mine) {
        mine->next = NULL;
        mine->state = RUNNING;
        mine->id = gettid();
    }
}

static void prepare(void)
{
    (void)pthread_key_create(&at_end, on_thread_end);
    (void)pthread_atfork(NULL, NULL, in_child);
}

/* A thread that the library has not seen before: the main one, or one of a library's own making. */
static void enter(void)
{
    if (self)
        return;
    (void)REAL(pthread_once)(&once, prepare);
    thread_t *thread = add_thread(NULL);
    if (!thread)
        abort();
    ect_virtual_thread_begin(thread, true);
}

/* Takes the turn up again if it was taken away. With the lock. */
static void resume_turn(void)
{
    while (self->state != RUNNING) {
        if (self->state == OUTSIDE)
            make_ready(self, false);
        if (!running) {
            pass_turn(choose());
            if (running == self)
                return;
        }
        unlock();
        await_turn();
        lock();
    }
}

static void begin_call(void)
{
    enter();
    lock();
    resume_turn();
    self->turn = 0; /* given before the thread's first call, if that is where the thread waits for it */
}

void *ect_virtual_thread_new(int *ended)
{
    enter();
    return add_thread(ended);
}

void ect_virtual_thread_begin(void *record, bool waits)
{
    self = record;
    self->id = gettid();
    (void)pthread_setspecific(at_end, record);
    if (!waits)
        return;
    lock();
    if (!running) {
        pass_turn(choose());
        if (running == self) {
            unlock();
            return;
        }
    }
    unlock();
    await_turn();
}

void ect_virtual_thread_end(void)
{
    thread_t *mine = self;
    if (!mine)
        return;
    self = NULL;
    ect_inside++; /* the rest of the thread's end is the C library's own */
    lock();
    bool had_turn = running == mine;
    if (mine->ended)
        *mine->ended = 1;
    for (thread_t *one = threads; one; one = one->next) {
        if (one->state == WAITING && mine->ended && one->key == mine->ended)
            make_ready(one, true);
    }
    remove_thread(mine);
    if (had_turn)
        pass_turn(choose());
    unlock();
}

void ect_virtual_thread_cancel(void *record)
{
    lock();
    remove_thread(record);
    unlock();
}

/* --- waiting -------------------------------------------------------------------------------------------------------
 */

uint64_t ect_virtual_now(void)
{
    begin_call();
    uint64_t time_ns = now_ns;
    unlock();
    return time_ns;
}

void ect_virtual_charge(uint64_t cost_ns)
{
    begin_call();
    advance(now_ns + cost_ns);
    if (++calls >= SERVE_EVERY)
        (void)serve_client();
    if (calls % LOOK_EVERY == 0)
        make_due_ready();
    else
        make_timely_ready();
    if (!first_ready()) {
        unlock();
        return;
    }
    make_ready(self, true);
    release_turn();
}

uint64_t ect_virtual_pass(uint64_t cost_ns)
{
    enter();
    lock();
    if (self->state == RUNNING)
        advance(now_ns + cost_ns);
    uint64_t time_ns = now_ns;
    unlock();
    return time_ns;
}

void ect_virtual_yield(void)
{
    ect_virtual_charge(ECT_COST_CLOCK_NS);
}

static bool wait_here(const void *key, bool (*condition)(void *arg), void *arg, uint64_t until_ns)
{
    self->state = WAITING;
    self->key = key;
    self->condition = condition;
    self->arg = arg;
    self->until_ns = until_ns;
    self->order = ++orders;
    release_turn();
    return self->woken;
}

bool ect_virtual_wait(const void *key, uint64_t until_ns)
{
    begin_call();
    return wait_here(key, NULL, NULL, until_ns);
}

bool ect_virtual_wait_until(bool (*ready)(void *arg), void *arg, bool outside, uint64_t until_ns)
{
    begin_call();
    self->outside = outside;
    return wait_here(NULL, ready, arg, until_ns);
}

unsigned int ect_virtual_wake(const void *key, unsigned int most)
{
    unsigned int count = 0;
    begin_call();
    while (count < most) {
        thread_t *first = NULL;
        for (thread_t *one = threads; one; one = one->next) {
            if (one->state == WAITING && one->key == key && (!first || one->order < first->order))
                first = one;
        }
        if (!first)
            break;
        make_ready(first, true);
        count++;
    }
    unlock();
    return count;
}

/* --- timers and the bus --------------------------------------------------------------------------------------------
 */

void ect_virtual_add_timer(ect_timer_t *timer)
{
    begin_call();
    timer->next = timers;
    timers = timer;
    unlock();
}

void ect_virtual_remove_timer(ect_timer_t *timer)
{
    begin_call();
    for (ect_timer_t **at = &timers; *at; at = &(*at)->next) {
        if (*at == timer) {
            *at = timer->next;
            break;
        }
    }
    unlock();
}

uint64_t ect_time_now(void)
{
    return now_ns;
}

void ect_time_charge(uint64_t cost_ns)
{
    ect_virtual_charge(cost_ns);
}

void ect_time_bus_started(void)
{
    bus_next_ns = now_ns;
}

void ect_time_bus_next(uint64_t next_ns)
{
    bus_next_ns = next_ns;
}

typedef struct wait {
    bool (*ready)(const void *arg);
    const void *arg;
} wait_t;

static bool is_ready(void *arg)
{
    const wait_t *wait = arg;
    return wait->ready(wait->arg);
}

bool ect_time_wait(int fd, bool (*ready)(const void *arg), const void *arg, uint64_t until_ns)
{
    wait_t wait = {.ready = ready, .arg = arg};
    (void)fd;
    bool result = wait_here(NULL, is_ready, &wait, until_ns);
    lock();
    return result;
}

__attribute__((destructor)) static void end(void)
{
    lock();
    ect_bus_end();
    unlock();
}
