/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "contain.h"

#include <errno.h>
#include <fcntl.h>
#include <sched.h>
#include <signal.h>
#include <stdbool.h>
#include <stddef.h>
#include <sys/mount.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

enum { SIGNALLED = 128, FAILED = 3 };

int contain_status(int wait_status)
{
    return WIFEXITED(wait_status) ? WEXITSTATUS(wait_status) : SIGNALLED + WTERMSIG(wait_status);
}

/* A container that masks parts of /proc forbids a second mount: the existing /proc remains. */
static void mount_proc(void)
{
    if (unshare(CLONE_NEWNS) == 0)
        (void)mount("proc", "/proc", "proc", MS_NOSUID | MS_NODEV | MS_NOEXEC, NULL);
}

/* Reaps all ended processes. @param[out] status  wait status of `main` @return whether `main` has ended */
static bool reap(pid_t main, int *status)
{
    int one;
    pid_t pid;
    bool found = false;
    while ((pid = waitpid(-1, &one, WNOHANG)) > 0) {
        if (pid != main)
            continue;
        *status = one;
        found = true;
    }
    return found;
}

/* Waits for the end of `main`, and forwards signals to `main`. @return the wait status */
static int wait_for(pid_t main, const sigset_t *all)
{
    int status = 0;
    siginfo_t info;
    for (;;) {
        int number = sigwaitinfo(all, &info);
        if (number == SIGCHLD && reap(main, &status))
            return status;
        if (number > 0 && number != SIGCHLD && info.si_code != SI_KERNEL)
            (void)kill(main, number);
    }
}

/* The kernel kills the other processes when process 1 ends; SIGTERM and a second allow an orderly end. */
static void end_others(void)
{
    enum { ROUNDS = 20 };
    const struct timespec pause = {.tv_nsec = 50000000};
    for (unsigned int round = 0; round < ROUNDS && kill(-1, SIGTERM) == 0; round++) {
        while (waitpid(-1, NULL, WNOHANG) > 0)
            ;
        if (errno == ECHILD)
            return;
        (void)nanosleep(&pause, NULL);
    }
}

static _Noreturn void be_process_1(void (*run)(const void *ctx), const void *ctx, const int ready[2])
{
    sigset_t all;
    sigfillset(&all);
    (void)sigprocmask(SIG_SETMASK, &all, NULL);
    (void)close(ready[0]);
    (void)prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (write(ready[1], "", 1) != 1) /* the calling process ended before PR_SET_PDEATHSIG took effect */
        _exit(FAILED);
    (void)close(ready[1]);
    mount_proc();
    pid_t main = fork();
    if (main == 0) {
        run(ctx);
        _exit(FAILED);
    }
    if (main < 0)
        _exit(FAILED);
    (void)close_range(STDERR_FILENO + 1, ~0u, 0); /* descriptors of the calling process */
    int status = wait_for(main, &all);
    end_others();
    _exit(contain_status(status));
}

/* clone() and not unshare(), after which the calling process could no longer start threads. */
static pid_t fork_into_namespace(void)
{
    return (pid_t)syscall(SYS_clone, CLONE_NEWPID | SIGCHLD, 0, 0, 0, 0);
}

pid_t contain_start(void (*run)(const void *ctx), const void *ctx)
{
    int ready[2];
    char byte;
    if (pipe2(ready, O_CLOEXEC) < 0)
        return -1;
    pid_t pid = fork_into_namespace();
    if (pid == 0)
        be_process_1(run, ctx, ready);
    int error = errno;
    (void)close(ready[1]);
    (void)!read(ready[0], &byte, 1);
    (void)close(ready[0]);
    errno = error;
    return pid;
}
