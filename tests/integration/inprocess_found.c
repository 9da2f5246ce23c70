/* SPDX-License-Identifier: MIT */
/*
 * A signal comes while ectwin's library lets the dynamic linker search for a function that it replaces.
 * usage: ectwin with --in-process --virtual-time fzm1 -- inprocess_found
 */
#define _GNU_SOURCE
#include <errno.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/wait.h>

/* CMocka needs the headers above. */
#include <cmocka.h>

#include "inprocess_next.h"

static volatile sig_atomic_t handled, handled_in_search;

/* As a shell's handler. */
static void on_child(int number)
{
    int error = errno;
    (void)number;
    handled++;
    handled_in_search += next_is_searched;
    while (waitpid(-1, NULL, WNOHANG) > 0)
        ;
    errno = error;
}

static void a_handler_runs_after_the_search(void **state)
{
    const struct sigaction action = {.sa_handler = on_child};
    (void)state;
    assert_int_equal(next_searches, 0);
    assert_int_equal(sigaction(SIGCHLD, &action, NULL), 0);
    errno = 0;
    assert_int_equal(waitpid(-1, NULL, WNOHANG), -1);
    assert_int_equal(errno, ECHILD);
    assert_true(next_searches > 0);
    assert_true(handled > 0);
    assert_int_equal(handled_in_search, 0);
}

static void a_search_within_ends_no_other(void **state)
{
    (void)state;
    assert_true(next_searches > 0); /* of the first test */
    assert_int_equal(next_clocks, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"A handler that calls waitpid() runs after the search for it, and a call of the program's own works within",
         a_handler_runs_after_the_search, NULL, NULL, NULL},
        {"A search inside another search does not affect the outer one", a_search_within_ends_no_other, NULL, NULL,
         NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
