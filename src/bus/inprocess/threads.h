/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The threads of the master on the virtual clock. One thread runs at a time; when it waits, the turn goes to the thread
 * that has been ready for the longest time. When all threads wait, time advances to the first deadline, of a thread or
 * of the bus. So a run depends only on the program and its inputs.
 *
 * A thread in a blocking system call that the library does not replace (for a terminal, for example) keeps the turn,
 * and time is stopped; clients of the control socket are served meanwhile. After a second of real time the thread loses
 * the turn, and a line on standard error names the call: the run is then not reproducible.
 *
 * Context: any thread of the master. The functions lock the state themselves.
 */
#ifndef ECT_BUS_INPROCESS_THREADS_H
#define ECT_BUS_INPROCESS_THREADS_H

#include <signal.h>
#include <stdbool.h>
#include <stdint.h>
#include <sys/types.h>

/** Monotonic time and time of day (2026-01-01 00:00 UTC) at the start of the bus, nanoseconds. */
#define ECT_VIRTUAL_START_NS 1000000000000ull
#define ECT_VIRTUAL_DAY_NS   1767225600000000000ull

/** @return the present virtual time, monotonic */
uint64_t ect_virtual_now(void);

/** Advances the time by the cost of a call; threads that become ready meanwhile run first. */
void ect_virtual_charge(uint64_t cost_ns);

/** Advances the time by the cost of a call if the calling thread has the turn, and keeps the turn. @return the time */
uint64_t ect_virtual_pass(uint64_t cost_ns);

/** Lets all other ready threads run first. */
void ect_virtual_yield(void);

/** The end of a wait. */
typedef enum ect_wait {
    ECT_WAIT_WOKEN,
    ECT_WAIT_TIMED_OUT,
    ECT_WAIT_INTERRUPTED, /**< a signal handler has run, or pthread_cancel() has been called for the thread */
} ect_wait_t;

/**
 * Waits for ::ect_virtual_wake with the same key, a signal, or a time.
 * @param key       address of the object; NULL: only a signal or the time ends the wait
 * @param until_ns  UINT64_MAX: no limit
 */
ect_wait_t ect_virtual_wait(const void *key, uint64_t until_ns);

/**
 * Waits until a condition on descriptors or on the bus is true. A cancellation point.
 * @param ready    evaluated while no thread of the master runs; must not block
 * @param outside  name of the master's call, if another process may make the condition true: clients of the control
 * socket are served at once; NULL: only the bus or another thread makes it true
 */
ect_wait_t ect_virtual_wait_until(bool (*ready)(void *arg), void *arg, const char *outside, uint64_t until_ns);

/**
 * As ::ect_virtual_wait_until, for a condition that another process makes true. With a bus, time is stopped meanwhile
 * for all threads, but at most for a second of real time since the last successful wait of this kind; a line reports
 * the end of this limit.
 */
ect_wait_t ect_virtual_wait_for_process(bool (*ready)(void *arg), void *arg, const char *call, uint64_t until_ns);

/** @return whether the master has a running child process */
bool ect_virtual_has_child(void);

/** @return whether all handlers that interrupted the thread's last wait have SA_RESTART; false, too, without one */
bool ect_virtual_restarts(void);

/** Makes the first `most` threads ready that wait for a key, in the order of their waits. @return their number */
unsigned int ect_virtual_wake(const void *key, unsigned int most);

/** A timer of the program: `expired` is called at a time, while no thread of the master runs. */
typedef struct ect_timer {
    struct ect_timer *next;
    uint64_t next_ns;     /**< UINT64_MAX: stopped */
    uint64_t interval_ns; /**< 0: once */
    void (*expired)(struct ect_timer *timer);
    bool inherited; /**< runs in a child of fork(), too */
} ect_timer_t;
void ect_virtual_add_timer(ect_timer_t *timer);
void ect_virtual_remove_timer(ect_timer_t *timer);

/** Makes the first thread ready that waits for a key. Only from `expired`. */
void ect_virtual_expired(const void *key);

/** A signal of a timer. Set `info` and zero the other members, which are private. */
typedef struct ect_signal {
    struct ect_signal *next;
    siginfo_t info;
    bool waits; /* pending until the receiving thread gets the turn */
} ect_signal_t;

/**
 * Sends a signal. Only from `expired`. A thread that does not block the signal runs the handler at its turn, and a wait
 * of the thread ends. If every thread blocks the signal, it is pending as usual.
 * @param to  the thread; 0: the process
 * @return false: the signal is already pending, which is an overrun
 */
bool ect_virtual_send(ect_signal_t *signal, pid_t to);
/** Cancels a signal whose handler has not yet run. */
void ect_virtual_recall(const ect_signal_t *signal);

/**
 * Called before the creation of a thread of the master.
 * @param ended  set to 1 at the end of the thread; its address is the key of threads that wait for this; must outlive
 * the thread
 * @return the record of the thread, for the next functions; NULL: there are 1024 threads
 */
void *ect_virtual_thread_new(int *ended);
/**
 * Called first by a new thread.
 * @param waits  true: the thread waits here for its turn; false: at its first call of the library, because the creating
 *               thread holds a lock until the new thread has begun, or a lock that the new thread needs
 */
void ect_virtual_thread_begin(void *record, bool waits);
/** Called after pthread_cancel(): ends the thread's wait, which becomes a cancellation point where POSIX has one. */
void ect_virtual_cancel(void *record);
/** Called last by a thread. */
void ect_virtual_thread_end(void);
/** Called if the creation of the thread has failed. */
void ect_virtual_thread_cancel(void *record);

#endif
