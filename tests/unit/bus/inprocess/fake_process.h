/* SPDX-License-Identifier: MIT */
/* The process of a test that is linked with eventfds.c. */
#ifndef TESTS_BUS_INPROCESS_FAKE_PROCESS_H
#define TESTS_BUS_INPROCESS_FAKE_PROCESS_H

#include <stddef.h>
#include <sys/types.h>

static pid_t process = 50;     /* that the program is */
static void (*in_child)(void); /* called in a child of fork() */

pid_t fake_getpid(void);
pid_t fake_getpid(void)
{
    return process;
}

int fake_pthread_atfork(void (*prepare)(void), void (*parent)(void), void (*child)(void));
int fake_pthread_atfork(void (*prepare)(void), void (*parent)(void), void (*child)(void))
{
    in_child = !prepare && !parent ? child : NULL;
    return 0;
}

#endif
