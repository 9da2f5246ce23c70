/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bus/inprocess/threads.h"

#include <errno.h>
#include <limits.h>
#include <linux/futex.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "bus/inprocess/actions.h"
#include "bus/inprocess/bus.h"
#include "bus/inprocess/real.h"
#include "bus/inprocess/tasks.h"
#include "bus/inprocess/time.h"
#include "wire/assert.h"

#define NEVER UINT64_MAX

enum { THREADS_MOST = 1024 };
#define PATIENCE_NS 1000000000ull

enum { SERVE_EVERY = 64, LOOK_EVERY = 16, NAP_MS = 1, IDLE_MS = 10, PAUSE_NS = 1000 };
enum { SERVED_MOST = 64 };

typedef enum state { READY, RUNNING, WAITING, OUTSIDE } state_t;

typedef struct wait {
    uint64_t until_ns;
    const void *key;
    bool (*condition)(void *arg);
    void *arg;
    const char *outside; /* call whose condition another process may make true; NULL: none */
    bool stops_time;     /* time is stopped while the thread waits for a process */
} wait_t;

typedef struct thread {
    struct thread *next;
    bool used;
    state_t state;
    uint64_t order; /* in which threads became ready, or started to wait */
    wait_t wait;
    bool woken;
    bool interrupted;      /* the wait has ended by a signal or by pthread_cancel() */
    bool cancelled;        /* by pthread_cancel() since the begin of the wait */
    bool idle;             /* sleeps in wait_for_the_world() */
    ect_signal_t *signals; /* delivered when the thread has its turn */
    int *ended;            /* set when the thread ends */
    pid_t id;
    int turn; /* a futex: 1 when the thread may go on */
} thread_t;

const bool ect_time_is_virtual = true;

/* Guarded by `mutex`, which is held briefly; the bus is used only with it held. */
static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
static uint64_t now_ns = ECT_VIRTUAL_START_NS;
static uint64_t bus_next_ns = NEVER;
static uint64_t orders;
static unsigned int calls; /* since the last client served by serve_in_turn() */
static uint64_t turns;     /* counts calls and turns, to detect a thread that makes none */
static bool reported;      /* whether the line about a run that is not reproducible has been printed */
static bool watched;       /* watch_turn() runs in this process */
static bool watch_begins;  /* LeakSanitizer waits, with the lock, until the thread of watch_turn() has read the clock */
static uint64_t stopped_ns; /* of real time, since the last successful wait for a process */
static thread_t *threads;
static thread_t *running;
static ect_timer_t *timers;
static __thread thread_t *self __attribute__((tls_model("initial-exec")));
static pthread_key_t at_end;
static pthread_once_t once = PTHREAD_ONCE_INIT;

static void lock(void)
{
    ect_action_hold();
    REAL(pthread_mutex_lock)(&mutex);
    ect_inside++; /* an allocator that is called with the lock may read the clock */
}

static void unlock(void)
{
    ect_inside--;
    REAL(pthread_mutex_unlock)(&mutex);
    ect_action_release();
}

void ect_time_lock(void)
{
    (void)ect_virtual_now(); /* a new thread gets its turn first */
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
        const uint64_t span_ns = timer->interval_ns, most_ns = NEVER - 1 - timer->next_ns;
        timer->next_ns = span_ns > 0 ? timer->next_ns + (span_ns < most_ns ? span_ns : most_ns) : NEVER;
        timer->expired(timer);
    }
}

/* Advances the time to `to_ns`, in steps that end at the deadlines of bus and timers. */
static void advance(uint64_t to_ns)
{
    while (now_ns < to_ns || bus_next_ns <= now_ns) {
        uint64_t step_ns = bus_next_ns < to_ns ? bus_next_ns : to_ns;
        for (const ect_timer_t *timer = timers; timer; timer = timer->next)
            step_ns = timer->next_ns < step_ns ? timer->next_ns : step_ns;
        bool again = step_ns <= now_ns; /* a bus that is due again at once gets a pause, so that time advances */
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
    thread->wait = (wait_t){0};
}

static void interrupt(thread_t *thread)
{
    make_ready(thread, false);
    thread->interrupted = true;
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
    return thread->wait.condition && thread->wait.condition(thread->wait.arg);
}

static bool deadline_has_passed(const thread_t *thread)
{
    return thread->wait.until_ns <= now_ns;
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

/* The first time limit of a wait or a timer; NEVER: none. */
static uint64_t next_deadline(void)
{
    uint64_t next_ns = NEVER;
    for (const thread_t *one = threads; one; one = one->next) {
        if (one->state == WAITING && one->wait.until_ns < next_ns)
            next_ns = one->wait.until_ns;
    }
    for (const ect_timer_t *timer = timers; timer; timer = timer->next)
        next_ns = timer->next_ns < next_ns ? timer->next_ns : next_ns;
    return next_ns;
}

static void report(const char *call)
{
    if (!reported)
        (void)!dprintf(STDERR_FILENO,
                       "ectwin: --virtual-time: %s has waited for a second of real time for an event outside the "
                       "virtual clock, such as another process or a network; from here on the run is not "
                       "reproducible: give the wait a timeout, or leave out --virtual-time\n",
                       call);
    reported = true;
}

/* The call for which time is stopped; NULL: none, or the longest stop is over. */
static const char *stopped_for(void)
{
    const char *call = NULL;
    for (const thread_t *one = threads; one && stopped_ns < PATIENCE_NS; one = one->next)
        call = one->state == WAITING && one->wait.stops_time ? one->wait.outside : call;
    return ect_bus_running() ? call : NULL;
}

static uint64_t real_now(void)
{
    struct timespec time;
    REAL(clock_gettime)(CLOCK_MONOTONIC, &time);
    return (uint64_t)time.tv_sec * 1000000000u + (uint64_t)time.tv_nsec;
}

/* The length of a pause, without the time in which the process or the machine was suspended and nothing else ran. */
static uint64_t length_since(uint64_t since_ns)
{
    enum { MOST_NS = 20000000 };
    uint64_t length_ns = real_now() - since_ns;
    return length_ns < MOST_NS ? length_ns : MOST_NS;
}

/* Sleeps for a moment of real time, without the lock. @return its length, nanoseconds */
static uint64_t nap(unsigned int nap_ms)
{
    uint64_t since_ns = real_now();
    const struct timespec pause = {.tv_nsec = (long)nap_ms * 1000000};
    if (self)
        self->idle = true;
    unlock();
    bool handled = ect_action_handled().count > 0; /* by the end of the lock */
    int result = handled ? -1 : REAL(nanosleep)(&pause, NULL);
    lock();
    if (self)
        self->idle = false;
    if (result != 0 && self && self->state == WAITING)
        interrupt(self);
    return length_since(since_ns);
}

static void stop_time(const char *call)
{
    stopped_ns += nap(NAP_MS);
    if (stopped_ns >= PATIENCE_NS)
        report(call);
}

/* Waits for another process: only it can make a thread ready, or a thread waits for a child. Time passes as in the real
 * world. */
static void wait_for_the_world(uint64_t *waited_ns)
{
    const char *call = NULL;
    for (const thread_t *one = threads; one; one = one->next)
        call = one->wait.outside ? one->wait.outside : call;
    *waited_ns += nap(IDLE_MS);
    if (call && ect_bus_running() && *waited_ns >= PATIENCE_NS)
        report(call);
    advance(now_ns + IDLE_MS * 1000000ull);
}

bool ect_virtual_has_child(void)
{
    siginfo_t info = {0};
    return REAL(waitid)(P_ALL, 0, &info, WEXITED | WNOHANG | WNOWAIT) == 0 && info.si_pid == 0;
}

/* A process without a bus that has children, such as timeout(1) or a test runner, waits for these: its timers must not
 * expire before the children have had as much time. */
static bool waits_for_children(void)
{
    return !ect_bus_running() && ect_virtual_has_child();
}

/* @return whether a client was served */
static bool serve_client(void)
{
    if (!ect_bus_running() || !ect_bus_serve(now_ns))
        return false;
    bus_next_ns = ect_bus_run(now_ns);
    return true;
}

static void serve_in_turn(void)
{
    if (++calls < SERVE_EVERY)
        return;
    calls = 0;
    (void)serve_client();
}

/* A thread that waits for a descriptor may be a client of the control socket, or wait for one. */
static bool any_external_wait(void)
{
    for (const thread_t *one = threads; one; one = one->next) {
        if (one->state == WAITING && one->wait.outside)
            return true;
    }
    return false;
}

/* Chooses the thread that runs next; with the lock. NULL: no thread can run. */
static thread_t *choose(void)
{
    uint64_t waited_ns = 0;
    for (;;) {
        thread_t *thread;
        bool children = waits_for_children(); /* first, because a child that ends later belongs to the next round */
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
        const char *call = stopped_for();
        uint64_t next_ns = next_deadline();
        if (call)
            stop_time(call);
        else if (next_ns != NEVER && !children)
            advance(next_ns < bus_next_ns ? next_ns : bus_next_ns);
        else
            wait_for_the_world(&waited_ns);
        if (self && self->state == RUNNING) /* a handler of a signal has taken the turn */
            return self;
        serve_in_turn();
    }
}

static void pass_turn(thread_t *thread)
{
    running = thread;
    turns++;
    if (thread)
        thread->state = RUNNING;
    if (thread && thread != self)
        wake_up(thread);
}

/* @return whether this thread has the turn, perhaps by a call of the handler */
static bool interrupt_wait(void)
{
    lock();
    bool mine = self->state == RUNNING;
    if (self->state == WAITING)
        interrupt(self);
    unlock();
    return mine;
}

/* Without the lock; returns when this thread has the turn. A futex with a timeout ends with EINTR after every handler
 * of a signal, one without a timeout only after some. */
static void await_turn(void)
{
    const struct timespec hour = {.tv_sec = 3600};
    while (__atomic_exchange_n(&self->turn, 0, __ATOMIC_ACQUIRE) == 0) {
        long result = REAL(syscall)(SYS_futex, &self->turn, FUTEX_WAIT_PRIVATE, 0, &hour, NULL, 0);
        if (result == 0 || errno != EINTR)
            continue;
        if (interrupt_wait())
            return;
    }
}

/* Passes the turn on and waits for the next one. With the lock; returns without. */
static void release_turn(void)
{
    thread_t *chosen = choose();
    bool mine = chosen == self;
    pass_turn(chosen);
    unlock();
    bool handled = ect_action_handled().count > 0; /* by the end of the lock */
    if (mine || (handled && interrupt_wait()))
        return;
    await_turn();
}

/* --- calls that the library does not replace -----------------------------------------------------------------------
 */

/* The running thread has made no call for a second and sleeps in the kernel: the turn goes to another one. */
static void take_turn_away(void)
{
    char name[ECT_TASK_CALL];
    report(ect_task_call(running->id, name));
    running->state = OUTSIDE;
    pass_turn(choose());
}

static bool running_is_stuck(void)
{
    return running && running->state == RUNNING && ect_task_sleeps(running->id);
}

/* Time is stopped while the thread with the turn waits in the kernel, for a child process for example. The child may be
 * a client of the control socket, so clients are served meanwhile. */
static void *watch_turn(void *unused)
{
    const struct timespec pause = {.tv_nsec = IDLE_MS * 1000000};
    uint64_t turns_before = 0;
    uint64_t stuck_ns = 0;
    (void)unused;
    ect_inside++;
    for (;;) {
        uint64_t since_ns = real_now();
        (void)REAL(nanosleep)(&pause, NULL);
        lock();
        bool stuck = turns == turns_before && running_is_stuck();
        turns_before = turns;
        stuck_ns = stuck ? stuck_ns + length_since(since_ns) : 0;
        for (unsigned int i = 0; stuck && i < SERVED_MOST && serve_client(); i++)
            ;
        if (stuck_ns >= PATIENCE_NS)
            take_turn_away();
        if (!running && threads) { /* all threads are outside */
            advance(now_ns + IDLE_MS * 1000000ull);
            pass_turn(choose());
            (void)serve_client();
        }
        unlock();
    }
    return NULL;
}

/* Called with the lock. The thread is created detached, because it is missing from the list of threads that a preloaded
 * library may keep. */
static void watch(void)
{
    pthread_t thread;
    pthread_attr_t detached;
    sigset_t all, before;
    if (watched)
        return;
    watched = true;
    sigfillset(&all);
    pthread_sigmask(SIG_BLOCK, &all, &before);
    pthread_attr_init(&detached);
    pthread_attr_setdetachstate(&detached, PTHREAD_CREATE_DETACHED);
    watch_begins = true;
    (void)REAL(pthread_create)(&thread, &detached, watch_turn, NULL);
    watch_begins = false;
    pthread_attr_destroy(&detached);
    pthread_sigmask(SIG_SETMASK, &before, NULL);
}

/* --- threads -------------------------------------------------------------------------------------------------------
 */

/* No heap: an allocator may read the clock, as the first call of a thread into this library. */
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
    for (ect_timer_t **at = &timers; *at;) {
        if ((*at)->inherited)
            at = &(*at)->next;
        else
            *at = (*at)->next;
    }
    bus_next_ns = NEVER;
    watched = false;
    if (mine) {
        mine->next = NULL;
        mine->signals = NULL;
        mine->state = RUNNING;
        mine->id = gettid();
    }
}

static void prepare(void)
{
    (void)pthread_key_create(&at_end, on_thread_end);
    (void)pthread_atfork(NULL, NULL, in_child);
}

/* Adds a thread without a record: the main thread, or a thread that another library has created. */
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

/* Takes the turn back if another thread has got it. With the lock. */
static void resume_turn(void)
{
    if (self->state == WAITING) /* in the handler of a signal that has ended the wait */
        interrupt(self);
    if (self->idle)
        self->state = RUNNING;
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
    turns++;
    self->turn = 0; /* the turn may have been passed to this thread before its first call */
}

void *ect_virtual_thread_new(int *ended)
{
    enter();
    lock();
    watch();
    unlock();
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

/* A thread that did not wait for its turn at its start may end before its first call. Such a thread ends in its turn
 * too, so that pthread_join() finds `ended` set or is woken. */
void ect_virtual_thread_end(void)
{
    thread_t *mine = self;
    if (!mine)
        return;
    lock();
    resume_turn();
    self = NULL;
    ect_inside++; /* the rest of the thread's end is the C library's own */
    if (mine->ended)
        *mine->ended = 1;
    for (thread_t *one = threads; one; one = one->next) {
        if (one->state == WAITING && mine->ended && one->wait.key == mine->ended)
            make_ready(one, true);
    }
    mine->state = WAITING; /* the nap of choose() is not a call that keeps the turn */
    remove_thread(mine);
    pass_turn(choose());
    unlock();
}

void ect_virtual_thread_cancel(void *record)
{
    lock();
    remove_thread(record);
    unlock();
}

/* --- signals of timers ---------------------------------------------------------------------------------------------
 */

static bool blocks(const thread_t *thread, int number)
{
    sigset_t mask;
    if (thread == self) {
        pthread_sigmask(SIG_BLOCK, NULL, &mask);
        return sigismember(&mask, number) == 1;
    }
    return ect_task_blocks(thread->id, number);
}

static thread_t *thread_of(pid_t id)
{
    thread_t *thread = threads;
    while (thread && thread->id != id)
        thread = thread->next;
    return thread;
}

/* @return the main thread, or else the first of the others, that does not block the signal; NULL: every thread blocks
 * it. The mask of another thread is read from a file, so the most likely thread is first. */
static thread_t *taker_of(int number, pid_t to)
{
    thread_t *first = thread_of(to != 0 ? to : getpid());
    if (first && !blocks(first, number))
        return first;
    thread_t *taker = NULL;
    for (thread_t *one = to == 0 ? threads : NULL; one; one = one->next) {
        if (one != first && one->id != 0 && !blocks(one, number))
            taker = one;
    }
    return taker;
}

static bool is_pending(int number)
{
    sigset_t pending;
    return sigpending(&pending) == 0 && sigismember(&pending, number) == 1;
}

static bool is_ignored(int number)
{
    struct sigaction action;
    return sigaction(number, NULL, &action) == 0 && action.sa_handler == SIG_IGN;
}

static void send_to(pid_t thread, const siginfo_t *info)
{
    (void)REAL(syscall)(SYS_rt_tgsigqueueinfo, getpid(), thread, info->si_signo, info, 0, 0);
}

static void add_signal(thread_t *taker, ect_signal_t *signal)
{
    ect_signal_t **at = &taker->signals;
    while (*at)
        at = &(*at)->next;
    signal->next = NULL;
    signal->waits = true;
    *at = signal;
    if (taker->state == WAITING)
        interrupt(taker);
}

bool ect_virtual_send(ect_signal_t *signal, pid_t to)
{
    int number = signal->info.si_signo;
    if (signal->waits || is_pending(number))
        return false;
    thread_t *taker = taker_of(number, to);
    if (taker && taker->state == OUTSIDE)
        send_to(taker->id, &signal->info);
    else if (taker && !is_ignored(number))
        add_signal(taker, signal);
    else if (!taker && to != 0)
        send_to(to, &signal->info);
    else if (!taker)
        (void)REAL(syscall)(SYS_rt_sigqueueinfo, getpid(), number, &signal->info, 0, 0, 0);
    return true;
}

void ect_virtual_recall(const ect_signal_t *signal)
{
    begin_call();
    for (thread_t *one = threads; one; one = one->next) {
        ect_signal_t **at = &one->signals;
        while (*at && *at != signal)
            at = &(*at)->next;
        if (*at)
            *at = signal->next;
    }
    unlock();
}

/* Runs the handlers of this thread's signals, without the lock: they may call the library. */
static void take_signals(void)
{
    if (!self->signals)
        return;
    int error = errno;
    lock();
    while (self->signals) {
        ect_signal_t *signal = self->signals;
        const siginfo_t info = signal->info;
        self->signals = signal->next;
        signal->waits = false;
        unlock();
        send_to(self->id, &info);
        lock();
    }
    unlock();
    errno = error;
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
    serve_in_turn();
    if (calls % LOOK_EVERY == 0)
        make_due_ready();
    else
        make_timely_ready();
    if (first_ready()) {
        make_ready(self, true);
        release_turn();
    } else {
        unlock();
    }
    take_signals();
}

uint64_t ect_virtual_pass(uint64_t cost_ns)
{
    if (!self && watch_begins)
        return now_ns;
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

static bool can_be_cancelled(void)
{
    int state;
    (void)pthread_setcancelstate(PTHREAD_CANCEL_DISABLE, &state);
    (void)pthread_setcancelstate(state, NULL);
    return state == PTHREAD_CANCEL_ENABLE;
}

static ect_wait_t wait_once(const wait_t *wait)
{
    self->state = WAITING;
    self->wait = *wait;
    self->order = ++orders;
    self->interrupted = false;
    self->cancelled = false;
    ect_action_watch();
    release_turn();
    ect_wait_t result = self->woken ? ECT_WAIT_WOKEN : self->interrupted ? ECT_WAIT_INTERRUPTED : ECT_WAIT_TIMED_OUT;
    take_signals();
    return result;
}

/* Waits as the record states. With the lock; returns without. A cancellation for which the thread is not ready does not
 * end the wait. */
static ect_wait_t wait_as(const wait_t *wait)
{
    ect_wait_t result = wait_once(wait);
    while (result == ECT_WAIT_INTERRUPTED && self->cancelled && !can_be_cancelled()) {
        begin_call();
        result = wait_once(wait);
    }
    return result;
}

ect_wait_t ect_virtual_wait_for_process(bool (*ready)(void *arg), void *arg, const char *call, uint64_t until_ns)
{
    pthread_testcancel();
    begin_call();
    ect_wait_t result =
        wait_as(&(wait_t){.condition = ready, .arg = arg, .outside = call, .stops_time = true, .until_ns = until_ns});
    if (result == ECT_WAIT_WOKEN)
        stopped_ns = 0;
    pthread_testcancel();
    return result;
}

ect_wait_t ect_virtual_wait(const void *key, uint64_t until_ns)
{
    begin_call();
    return wait_as(&(wait_t){.key = key, .until_ns = until_ns});
}

ect_wait_t ect_virtual_wait_until(bool (*ready)(void *arg), void *arg, const char *outside, uint64_t until_ns)
{
    pthread_testcancel();
    begin_call();
    ect_wait_t result = wait_as(&(wait_t){.condition = ready, .arg = arg, .outside = outside, .until_ns = until_ns});
    pthread_testcancel();
    return result;
}

void ect_virtual_cancel(void *record)
{
    thread_t *thread = record;
    begin_call();
    thread->cancelled = true;
    if (thread->state == WAITING)
        interrupt(thread);
    unlock();
}

bool ect_virtual_restarts(void)
{
    const ect_handled_t handlers = ect_action_handled();
    return handlers.count > 0 && handlers.restarts;
}

static unsigned int wake(const void *key, unsigned int most)
{
    unsigned int count = 0;
    while (count < most) {
        thread_t *first = NULL;
        for (thread_t *one = threads; one; one = one->next) {
            if (one->state == WAITING && one->wait.key == key && (!first || one->order < first->order))
                first = one;
        }
        if (!first)
            break;
        make_ready(first, true);
        count++;
    }
    return count;
}

unsigned int ect_virtual_wake(const void *key, unsigned int most)
{
    begin_call();
    unsigned int count = wake(key, most);
    unlock();
    return count;
}

void ect_virtual_expired(const void *key)
{
    (void)wake(key, 1);
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
    watch();
}

void ect_time_bus_next(uint64_t next_ns)
{
    bus_next_ns = next_ns;
}

typedef struct question {
    bool (*ready)(const void *arg);
    const void *arg;
} question_t;

static bool is_ready(void *arg)
{
    const question_t *its = arg;
    return its->ready(its->arg);
}

/* recv(2): a timeout ends a receive after each handler. */
bool ect_time_wait(int fd, bool (*ready)(const void *arg), const void *arg, uint64_t until_ns)
{
    question_t its = {.ready = ready, .arg = arg};
    (void)fd;
    ect_wait_t result;
    for (;;) {
        result = wait_as(&(wait_t){.condition = is_ready, .arg = &its, .until_ns = until_ns});
        lock();
        if (result != ECT_WAIT_INTERRUPTED || !ect_virtual_restarts() || until_ns != NEVER)
            break;
    }
    errno = result == ECT_WAIT_INTERRUPTED ? EINTR : EAGAIN;
    return result == ECT_WAIT_WOKEN;
}

__attribute__((destructor)) static void end(void)
{
    lock();
    ect_bus_end();
    unlock();
}
