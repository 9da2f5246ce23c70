/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The threads of the master on the virtual clock. One runs at a time; another gets its turn when the running one waits,
 * in the order in which they became ready. When all of them wait, time goes on to the first deadline, of a thread or of
 * the bus. So a run depends on nothing but the program and its inputs.
 *
 * A thread that waits for something unknown (a descriptor of another process, a system call that the library does not
 * see) keeps its turn; after a second of real time without a call, asleep in the kernel, it loses the turn and a line
 * on standard error reports that. Its run is not reproducible then.
 *
 * Context: any thread of the master, without holding the turn of another. Functions below take and release the state's
 * lock themselves.
 */
#ifndef ECT_BUS_INPROCESS_THREADS_H
#define ECT_BUS_INPROCESS_THREADS_H

#include <stdbool.h>
#include <stdint.h>

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

/**
 * Waits for ::ect_virtual_wake with the same key, or a time.
 * @param key       address of the object that is waited for; NULL: nothing wakes it but the time
 * @param until_ns  UINT64_MAX: no limit
 * @return true: woken; false: the time has come
 */
bool ect_virtual_wait(const void *key, uint64_t until_ns);

/**
 * Waits until a condition holds that descriptors or the bus make true.
 * @param ready    evaluated while no thread of the master runs; must not block
 * @param outside  another process may make it true: clients of the control socket are served at once
 * @return whether it holds
 */
bool ect_virtual_wait_until(bool (*ready)(void *arg), void *arg, bool outside, uint64_t until_ns);

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
