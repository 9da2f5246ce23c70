/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The threads of the master on the virtual clock. One runs at a time; another gets its turn when the running one waits,
 * in the order in which they became ready. When all of them wait, time goes on to the first deadline, of a thread or of
 * the bus. So a run depends on nothing but the program and its inputs.
 *
 * A thread that waits in a system call that the library does not replace (for a child process, a terminal) keeps its
 * turn, and time is stopped; clients of the control socket are served meanwhile. After a second of real time the thread
 * loses the turn, and a line on standard error names the call: the run is not reproducible then.
 *
 * Context: any thread of the master, without holding the turn of another. Functions below take and release the state's
 * lock themselves.
 */
#ifndef ECT_BUS_INPROCESS_THREADS_H
#define ECT_BUS_INPROCESS_THREADS_H

#include <signal.h>
#include <stdbool.h>
#include <stdint.h>
#include <sys/types.h>

/** Monotonic time of the bus at the start, and the time of day then (2026-01-01 00:00 UTC), nanoseconds. */
#define ECT_VIRTUAL_START_NS 1000000000000ull
#define ECT_VIRTUAL_DAY_NS   1767225600000000000ull

/** Present virtual time, monotonic. */
uint64_t ect_virtual_now(void);

/** Lets a stated cost pass; threads that become ready by it run first. */
void ect_virtual_charge(uint64_t cost_ns);

/** Lets a stated cost pass, if the calling thread has the turn, and keeps the turn. @return the time then */
uint64_t ect_virtual_pass(uint64_t cost_ns);

/** Lets every other thread that is ready run first. */
void ect_virtual_yield(void);

/** The end of a wait. */
typedef enum ect_wait {
    ECT_WAIT_WOKEN,
    ECT_WAIT_TIMED_OUT,
    ECT_WAIT_INTERRUPTED, /**< a handler of a signal has run */
} ect_wait_t;

/**
 * Waits for ::ect_virtual_wake with the same key, a signal, or a time.
 * @param key       address of the object that is waited for; NULL: nothing wakes it but the time
 * @param until_ns  UINT64_MAX: no limit
 */
ect_wait_t ect_virtual_wait(const void *key, uint64_t until_ns);

/**
 * Waits until a condition holds that descriptors or the bus make true.
 * @param ready    evaluated while no thread of the master runs; must not block
 * @param outside  name of the master's call, if another process may make it true: clients of the control socket are
 *                 served at once; NULL: the bus or another thread makes it true
 */
ect_wait_t ect_virtual_wait_until(bool (*ready)(void *arg), void *arg, const char *outside, uint64_t until_ns);

/**
 * The same for a condition that another process makes true. With a bus, time is stopped until then, for all threads,
 * but for no more than a second of real time since such a wait last ended well; a line reports that.
 */
ect_wait_t ect_virtual_wait_for_process(bool (*ready)(void *arg), void *arg, const char *call, uint64_t until_ns);

/** Whether the master has a child process that runs. */
bool ect_virtual_has_child(void);

/** Whether each handler that ended the thread's last wait has SA_RESTART; false for a signal from outside. */
bool ect_virtual_restarts(void);

/** Makes the first `most` threads ready that wait for a key, in the order in which they began to wait. @return how many
 */
unsigned int ect_virtual_wake(const void *key, unsigned int most);

/** Registers a timer of the program: `expired` runs at a time, while no thread of the master runs. */
typedef struct ect_timer {
    struct ect_timer *next;
    uint64_t next_ns;     /**< UINT64_MAX: stopped */
    uint64_t interval_ns; /**< 0: once */
    void (*expired)(struct ect_timer *timer);
} ect_timer_t;
void ect_virtual_add_timer(ect_timer_t *timer);
void ect_virtual_remove_timer(ect_timer_t *timer);

/** From `expired`: makes the first thread ready that waits for a key. */
void ect_virtual_expired(const void *key);

/** A signal of a timer. Zero but `info` at the start; the other members are private. */
typedef struct ect_signal {
    struct ect_signal *next;
    siginfo_t info;
    bool waits; /* for the turn of the thread that takes it */
} ect_signal_t;

/**
 * From `expired`: sends a signal. A thread that does not block it runs the handler when it has its turn, and a wait of
 * that thread ends; a signal that every thread blocks is pending as any other.
 * @param to  the thread; 0: the process
 * @return false: the signal is pending already, which makes this an overrun
 */
bool ect_virtual_send(ect_signal_t *signal, pid_t to);
/** Takes back a signal whose handler has not run. */
void ect_virtual_recall(const ect_signal_t *signal);

/**
 * A thread of the master is about to be created.
 * @param ended  becomes 1 when the thread ends, and wakes who waits with it as the key; outlives the thread
 * @return its record, for the next functions; NULL: there are 1024 threads
 */
void *ect_virtual_thread_new(int *ended);
/**
 * First call of a new thread.
 * @param waits  the thread waits for its turn here; false: at its first call of the library, for the creating thread
 *               holds a lock until the new one has begun, or the new one needs a lock that the creating thread holds
 */
void ect_virtual_thread_begin(void *record, bool waits);
/** Last call of a thread. */
void ect_virtual_thread_end(void);
/** The thread was not created after all. */
void ect_virtual_thread_cancel(void *record);

#endif
