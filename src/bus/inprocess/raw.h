/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Direct system calls of the master, made without the C library, as by Rust's rustix.
 *
 * The kernel (Linux 5.11, x86-64: Syscall User Dispatch) sends SIGSYS for each system call from outside the text of the
 * C library; the handler passes the call to the replaced function, or to the kernel. The dispatch slows down every
 * system call of a thread. Therefore the dispatch is on only if an object other than the C library contains a system
 * call instruction. Without dispatch, direct system calls are not intercepted.
 */
#ifndef ECT_BUS_INPROCESS_RAW_H
#define ECT_BUS_INPROCESS_RAW_H

#include <errno.h>
#include <link.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/** A system call: its number and arguments. */
typedef struct ect_raw_call {
    long number;
    long a[6];
} ect_raw_call_t;

/** Executes a call of the program. @return the kernel's result: negative error numbers */
typedef long ect_raw_route_t(const ect_raw_call_t *call);

/**
 * Prepares the dispatch. Called once in each process, before its main function.
 * @param argv  of the constructor, which precedes the auxiliary vector in memory
 */
void ect_raw_begin(ect_raw_route_t *route, int argc, char **argv);

/**
 * Searches the objects loaded since the previous call. If one of them contains a system call, turns the dispatch on in
 * this thread and in threads created later. Context: any thread, without the lock.
 */
void ect_raw_scan(void);

/** Turns the dispatch on in a new thread, or in the child of a fork, if it is on in the process. */
void ect_raw_thread(void);

/** Executes a call from the text of the C library. @return the kernel's result: negative error numbers */
long ect_raw_pass(const ect_raw_call_t *call);

/** @return whether the dispatch is on in this process */
bool ect_raw_is_on(void);

/**
 * Removes the vDSO from an auxiliary vector on the virtual clock, so that programs read the clock by a system call.
 * @param vector  ends with AT_NULL; NULL: none
 */
void ect_raw_hide_vdso(ElfW(auxv_t) * vector);

/** A row of a table of functions of the C library, and the search in it. @return whether the table has the call */
typedef struct ect_raw_entry {
    long number;
    long (*make)(const long *a);
} ect_raw_entry_t;
bool ect_raw_find(const ect_raw_entry_t *table, size_t count, const ect_raw_call_t *call, long *result);

/** Executes a call that concerns time on the virtual clock. @return false: another call, or the real clock */
bool ect_raw_on_clock(const ect_raw_call_t *call, long *result);

/** @return the kernel's result for a function that returns -1 and sets errno */
static inline long ect_raw_result(long returned)
{
    return returned == -1 ? -errno : returned;
}

#endif
