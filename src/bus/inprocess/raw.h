/* SPDX-License-Identifier: MIT */
/**
 * @file
 * System calls that the master makes itself, without the C library, as Rust's rustix does.
 *
 * The kernel (Linux 5.11, x86-64: Syscall User Dispatch) sends SIGSYS for each system call from outside the text of the
 * C library; the handler passes the call to the function that this library replaces, or on to the kernel. This slows
 * every system call of a thread down, so that it is on only in a process in which an object other than the C library
 * contains such an instruction. Elsewhere, and where the kernel has no dispatch, such calls are not seen.
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

/** Makes a call of the program. @return the kernel's result: negative error numbers */
typedef long ect_raw_route_t(const ect_raw_call_t *call);

/** Once a process, before its main function. @param argv  of the constructor: the auxiliary vector is behind it */
void ect_raw_begin(ect_raw_route_t *route, int argc, char **argv);

/** Searches objects that have been loaded since the last time, and turns the dispatch on if one makes calls itself: in
 * this thread, and in those created from now on. Context: any thread, without the lock. */
void ect_raw_look(void);

/** First call of a thread, or of the child of a fork. */
void ect_raw_thread(void);

/** Makes a call by the C library's text. @return the kernel's result: negative error numbers */
long ect_raw_pass(const ect_raw_call_t *call);

/** Whether the dispatch is on in this process. */
bool ect_raw_is_on(void);

/** Removes the vDSO from an auxiliary vector, on the virtual clock: programs that find none read the clock by a call.
 * @param vector  ends with AT_NULL; NULL: none */
void ect_raw_hide_vdso(ElfW(auxv_t) * vector);

/** A table of the functions of the C library that calls are passed to. @return whether it has the call */
typedef struct ect_raw_entry {
    long number;
    long (*make)(const long *a);
} ect_raw_entry_t;
bool ect_raw_find(const ect_raw_entry_t *table, size_t count, const ect_raw_call_t *call, long *result);

/** Makes calls about time, if the clock is virtual. @return false: it is none */
bool ect_raw_on_clock(const ect_raw_call_t *call, long *result);

/** The kernel's result of a function that returns -1 and errno. */
static inline long ect_raw_result(long returned)
{
    return returned == -1 ? -errno : returned;
}

#endif
