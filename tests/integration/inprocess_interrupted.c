/* SPDX-License-Identifier: MIT */
/*
 * Calls that a signal handler, a cancellation, another thread or a child of the program interrupts.
 * usage: ectwin with --in-process [--virtual-time] fzm1,fzm1 -- inprocess_interrupted {} real|virtual [CASE]
 */
#define _GNU_SOURCE
#include "inprocess.h"

#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <sched.h>
#include <semaphore.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

enum { LONGEST_S = 60 };

/* --- handlers ------------------------------------------------------------------------------------------------------
 */

static volatile sig_atomic_t handled;
static int fd_of_handler;

static void count(int number)
{
    (void)number;
    handled++;
}

static void exchange(int number)
{
    const int error = errno;
    uint8_t frame[FRAME];
    (void)number;
    frame_of(frame, 0x80);
    if (send(fd_of_handler, frame, sizeof frame, 0) == FRAME &&
        recv(fd_of_handler, frame, sizeof frame, MSG_DONTWAIT) == FRAME)
        handled++;
    errno = error;
}

static void handle(int number, void (*handler)(int number), int flags)
{
    const struct sigaction action = {.sa_handler = handler, .sa_flags = flags};
    handled = 0;
    assert_int_equal(sigaction(number, &action, NULL), 0);
}

/* @return a child that sends a signal to this process again and again, until it is killed */
static pid_t make_signaller(int number)
{
    const pid_t parent = getpid();
    pid_t child = fork();
    if (child == 0) {
        (void)alarm(LONGEST_S);
        while (kill(parent, number) == 0)
            usleep(20);
        _exit(1);
    }
    assert_true(child > 0);
    return child;
}

static void end_child(pid_t child)
{
    int status;
    assert_int_equal(kill(child, SIGKILL), 0);
    while (waitpid(child, &status, 0) != child)
        assert_int_equal(errno, EINTR);
}

static void a_handler_exchanges_frames_within_calls(void **state)
{
    enum { ENOUGH = 500 };
    uint8_t frame[FRAME];
    unsigned int exchanged = 0;
    (void)state;
    int fd = open_socket(0);
    fd_of_handler = open_socket(0);
    handle(SIGUSR1, exchange, SA_RESTART);
    pid_t child = make_signaller(SIGUSR1);
    for (uint8_t n = 0; handled < ENOUGH || exchanged < ENOUGH; n = (n + 1) & 0x7F) {
        send_one(fd, n);
        /* Both sockets receive each reply: many of the handler's may leave no room for this one. */
        while (recv(fd, frame, sizeof frame, MSG_DONTWAIT) == FRAME)
            exchanged += frame[17] == n;
        while (recv(fd_of_handler, frame, sizeof frame, MSG_DONTWAIT) > 0)
            ;
    }
    end_child(child);
    handle(SIGUSR1, SIG_IGN, 0);
    close(fd_of_handler);
    close(fd);
}

static void an_action_is_returned_as_it_was_set(void **state)
{
    static void (*const handlers[])(int number) = {SIG_DFL, count, exchange, SIG_IGN, count};
    static const int flags[] = {0, SA_RESTART, (int)SA_RESETHAND | SA_NODEFER, 0, SA_SIGINFO | SA_ONSTACK};
    struct sigaction action, before;
    (void)state;
    for (size_t i = 0; i < sizeof flags / sizeof *flags; i++) {
        action = (struct sigaction){.sa_handler = handlers[i], .sa_flags = flags[i]};
        sigemptyset(&action.sa_mask);
        sigaddset(&action.sa_mask, SIGUSR2);
        assert_int_equal(sigaction(SIGUSR1, &action, NULL), 0);
        assert_int_equal(sigaction(SIGUSR1, NULL, &before), 0);
        assert_ptr_equal(before.sa_handler, handlers[i]);
        assert_int_equal(before.sa_flags & ~0x04000000, flags[i]); /* the kernel's SA_RESTORER */
        assert_int_equal(sigismember(&before.sa_mask, SIGUSR2), 1);
        assert_int_equal(sigaction(SIGUSR1, &before, &action), 0);
        assert_ptr_equal(action.sa_handler, handlers[i]);
    }
    assert_ptr_equal(signal(SIGUSR1, exchange), count);
    assert_ptr_equal(signal(SIGUSR1, SIG_IGN), exchange);
    assert_ptr_equal(signal(SIGUSR1, SIG_DFL), SIG_IGN);
    errno = 0;
    assert_ptr_equal(signal(SIGUSR1, SIG_ERR), SIG_ERR);
    assert_int_equal(errno, EINVAL);
    assert_int_equal(sigaction(SIGKILL, &action, NULL), -1);
    assert_int_equal(errno, EINVAL);
}

static void a_handler_with_sa_resethand_runs_once(void **state)
{
    struct sigaction action;
    (void)state;
    handle(SIGCHLD, count, (int)SA_RESETHAND); /* its default action is to ignore */
    raise(SIGCHLD);
    raise(SIGCHLD);
    assert_int_equal(handled, 1);
    assert_int_equal(sigaction(SIGCHLD, NULL, &action), 0);
    assert_ptr_equal(action.sa_handler, SIG_DFL);
}

static volatile sig_atomic_t mask_was_right;

static void look_at_mask(int number, siginfo_t *info, void *context)
{
    sigset_t mask;
    (void)context;
    pthread_sigmask(SIG_BLOCK, NULL, &mask);
    mask_was_right = info->si_signo == number && info->si_value.sival_int == 4711 && sigismember(&mask, number) == 1 &&
                     sigismember(&mask, SIGUSR2) == 1 && sigismember(&mask, SIGTERM) == 0;
}

static void a_handler_gets_information_and_mask(void **state)
{
    sigset_t before, after;
    struct sigaction action = {.sa_sigaction = look_at_mask, .sa_flags = SA_SIGINFO};
    (void)state;
    sigemptyset(&action.sa_mask);
    sigaddset(&action.sa_mask, SIGUSR2);
    assert_int_equal(sigaction(SIGUSR1, &action, NULL), 0);
    pthread_sigmask(SIG_BLOCK, NULL, &before);
    assert_int_equal(sigqueue(getpid(), SIGUSR1, (union sigval){.sival_int = 4711}), 0);
    assert_true(mask_was_right);
    pthread_sigmask(SIG_BLOCK, NULL, &after);
    for (int number = 1; number < SIGRTMIN; number++)
        assert_int_equal(sigismember(&after, number), sigismember(&before, number));
}

/* Sends SIGALRM in this period; 0: no more. */
static void alarm_every(suseconds_t period_us)
{
    const struct itimerval period = {.it_value.tv_usec = period_us, .it_interval.tv_usec = period_us};
    assert_int_equal(setitimer(ITIMER_REAL, &period, NULL), 0);
}

/* recv(2): SO_RCVTIMEO makes a receive end with EINTR after a handler with SA_RESTART, too. */
static void a_receive_ends_as_the_handler_asks(void **state)
{
    static const struct {
        int flags;
        time_t timeout_s;
    } cases[] = {{0, 0}, {0, 100}, {SA_RESTART, 100}};
    uint8_t frame[FRAME];
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const struct timeval timeout = {.tv_sec = cases[i].timeout_s};
        int fd = open_socket(0);
        setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &timeout, sizeof timeout);
        handle(SIGALRM, count, cases[i].flags);
        alarm_every(2000);
        const ssize_t length = recv(fd, frame, sizeof frame, 0);
        const int error = errno;
        alarm_every(0);
        if (length != -1 || error != EINTR)
            fail_msg("case %zu: %zd, errno %d; expected -1, EINTR", i, length, error);
        assert_true(handled > 0);
        close(fd);
    }
}

static void *send_after_a_signal(void *arg)
{
    const struct timespec pause = {.tv_nsec = MS};
    while (handled == 0)
        nanosleep(&pause, NULL);
    send_one(*(int *)arg, 5);
    return NULL;
}

static void a_restarted_receive_gets_the_reply(void **state)
{
    uint8_t frame[FRAME];
    pthread_t thread;
    sigset_t set;
    (void)state;
    int fd = open_socket(0);
    sigemptyset(&set);
    sigaddset(&set, SIGALRM);
    handle(SIGALRM, count, SA_RESTART);
    pthread_sigmask(SIG_BLOCK, &set, NULL); /* in the thread */
    assert_int_equal(pthread_create(&thread, NULL, send_after_a_signal, &fd), 0);
    pthread_sigmask(SIG_UNBLOCK, &set, NULL);
    alarm_every(2000);
    errno = EDOM;
    assert_reply(frame, recv(fd, frame, sizeof frame, 0), 5);
    assert_int_not_equal(errno, 0); /* errno(3): no function sets it to 0 */
    alarm_every(0);
    assert_true(handled > 0);
    pthread_join(thread, NULL);
    close(fd);
}

/* --- cancellation --------------------------------------------------------------------------------------------------
 */

static sem_t never;
static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
static pthread_cond_t condition = PTHREAD_COND_INITIALIZER;

static void *exchange_for_ever(void *arg)
{
    uint8_t frame[FRAME];
    for (uint8_t n = 0;; n++) {
        frame_of(frame, n);
        (void)!send(*(int *)arg, frame, sizeof frame, 0);
        (void)!recv(*(int *)arg, frame, sizeof frame, MSG_DONTWAIT);
    }
    return NULL;
}

static void *receive_for_ever(void *arg)
{
    uint8_t frame[FRAME];
    for (;;)
        (void)!recv(*(int *)arg, frame, sizeof frame, 0);
    return NULL;
}

static void *poll_for_ever(void *unused)
{
    (void)unused;
    for (;;)
        (void)poll(NULL, 0, -1);
    return NULL;
}

static void *sleep_for_ever(void *unused)
{
    (void)unused;
    for (;;)
        (void)usleep(500000);
    return NULL;
}

static void *wait_for_a_semaphore(void *unused)
{
    (void)unused;
    for (;;)
        (void)sem_wait(&never);
    return NULL;
}

static void unlock(void *its)
{
    pthread_mutex_unlock(its);
}

static void *wait_for_a_condition(void *unused)
{
    (void)unused;
    pthread_mutex_lock(&mutex);
    pthread_cleanup_push(unlock, &mutex);
    for (;;)
        (void)pthread_cond_wait(&condition, &mutex);
    pthread_cleanup_pop(1);
    return NULL;
}

static void a_thread_is_cancelled_in_every_kind_of_call(void **state)
{
    static void *(*const kinds[])(void *arg) = {exchange_for_ever, receive_for_ever,     poll_for_ever,
                                                sleep_for_ever,    wait_for_a_semaphore, wait_for_a_condition,
                                                receive_for_ever};
    enum { KINDS = sizeof kinds / sizeof *kinds, TIMES = 40 };
    uint8_t frame[FRAME];
    (void)state;
    sem_init(&never, 0, 0);
    for (unsigned int n = 0; n < KINDS * TIMES; n++) {
        pthread_t thread;
        void *result = NULL;
        int fd = open_socket(0);
        int own = open_socket(0);
        assert_int_equal(pthread_create(&thread, NULL, kinds[n % KINDS], &fd), 0);
        usleep(n % KINDS == KINDS - 1 ? 0 : 300);
        assert_int_equal(pthread_cancel(thread), 0);
        assert_int_equal(pthread_join(thread, &result), 0);
        assert_ptr_equal(result, PTHREAD_CANCELED);
        assert_int_equal(pthread_mutex_trylock(&mutex), 0);
        pthread_mutex_unlock(&mutex);
        send_one(own, 200);
        do
            assert_int_equal(recv(own, frame, sizeof frame, 0), FRAME);
        while (frame[17] != 200); /* before it those of the other thread, which both sockets receive */
        close(own);
        close(fd);
    }
}

static atomic_bool may_end;

static void *disable_cancellation(void *unused)
{
    int before;
    (void)unused;
    pthread_setcancelstate(PTHREAD_CANCEL_DISABLE, &before);
    uint64_t since_ns = now_ns();
    int slept = usleep(20000);
    assert_int_equal(slept, 0);
    assert_took(since_ns, 20 * MS);
    may_end = true;
    pthread_setcancelstate(PTHREAD_CANCEL_ENABLE, NULL);
    for (;;)
        (void)usleep(1000);
    return NULL;
}

static void a_thread_with_disabled_cancellation_completes_its_call(void **state)
{
    pthread_t thread;
    void *result = NULL;
    (void)state;
    assert_int_equal(pthread_create(&thread, NULL, disable_cancellation, NULL), 0);
    usleep(5000);
    assert_int_equal(pthread_cancel(thread), 0);
    assert_int_equal(pthread_join(thread, &result), 0);
    assert_ptr_equal(result, PTHREAD_CANCELED);
}

/* --- descriptors of others -----------------------------------------------------------------------------------------
 */

static atomic_int receiver;

/* @return whether the receiving thread is in the kernel's ppoll(), where it waits on the real clock */
static bool receiver_waits(void)
{
    char path[64], call[16] = "";
    snprintf(path, sizeof path, "/proc/self/task/%d/syscall", receiver);
    FILE *file = fopen(path, "re");
    assert_non_null(file);
    assert_non_null(fgets(call, sizeof call, file));
    fclose(file);
    return atoi(call) == SYS_ppoll;
}

static void *receive_once(void *arg)
{
    uint8_t frame[FRAME];
    receiver = gettid();
    ssize_t length = recv(*(int *)arg, frame, sizeof frame, 0);
    return length == FRAME && frame[17] == 7 ? arg : NULL;
}

/* The kernel keeps the socket until the receive returns. */
static void a_socket_is_closed_while_a_thread_receives(void **state)
{
    enum { TIMES = 20, SOCKETS = 4 };
    const struct timeval timeout = {.tv_sec = LONGEST_S};
    uint8_t frame[FRAME];
    (void)state;
    for (int n = 0; n < TIMES; n++) {
        pthread_t thread;
        void *result = NULL;
        int others[SOCKETS];
        int fd = open_socket(0);
        setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &timeout, sizeof timeout);
        receiver = 0;
        assert_int_equal(pthread_create(&thread, NULL, receive_once, &fd), 0);
        usleep(1000);
        while (receiver == 0 || (!is_virtual && !receiver_waits()))
            usleep(100);
        assert_int_equal(close(fd), 0);
        for (int i = 0; i < SOCKETS; i++) /* may get the memory of the closed one */
            others[i] = open_socket(0);
        send_one(others[0], 7);
        for (int i = 0; i < SOCKETS; i++)
            assert_reply(frame, recv(others[i], frame, sizeof frame, 0), 7);
        assert_int_equal(pthread_join(thread, &result), 0);
        assert_ptr_equal(result, &fd);
        for (int i = 0; i < SOCKETS; i++)
            assert_int_equal(close(others[i]), 0);
    }
}

static atomic_int fd_of_sender;
static atomic_uint rounds_of_sender;
static atomic_bool sender_ends;

/* A refusal is because of a closed socket, the other file with its number, a new socket without an interface, or no
 * frame. */
static bool is_frame_or_refusal(ssize_t result)
{
    return result == FRAME ||
           (result < 0 && (errno == EBADF || errno == ENOTSOCK || errno == ENXIO || errno == EAGAIN));
}

static void *send_and_receive(void *arg)
{
    uint8_t frame[FRAME];
    bool good = true;
    while (!atomic_load(&sender_ends)) {
        const int fd = atomic_load(&fd_of_sender);
        frame_of(frame, 1);
        good &= is_frame_or_refusal(send(fd, frame, sizeof frame, 0));
        good &= is_frame_or_refusal(recv(fd, frame, sizeof frame, MSG_DONTWAIT));
        atomic_fetch_add(&rounds_of_sender, 1);
    }
    return good ? arg : NULL;
}

/* Closes the socket of the sender, whose number remains taken until the sender has another one: a file that is opened
 * meanwhile, such as a connection of the library, would get its frames. */
static void change_socket(int other_file)
{
    const int fd = atomic_load(&fd_of_sender);
    assert_int_equal(dup2(other_file, fd), fd);
    atomic_store(&fd_of_sender, open_socket(0));
    const unsigned int round = atomic_load(&rounds_of_sender);
    while (atomic_load(&rounds_of_sender) - round < 2)
        (void)sched_yield();
    assert_int_equal(close(fd), 0);
}

static void a_socket_is_closed_while_a_thread_sends(void **state)
{
    enum { ROUNDS = 3000 };
    pthread_t thread;
    void *result = NULL;
    int other_file = open("/dev/null", O_RDWR);
    (void)state;
    atomic_store(&fd_of_sender, open_socket(0));
    atomic_store(&sender_ends, false);
    assert_int_equal(pthread_create(&thread, NULL, send_and_receive, &result), 0);
    for (unsigned int i = 0; i < ROUNDS; i++) {
        send_one(atomic_load(&fd_of_sender), 2);
        change_socket(other_file);
    }
    atomic_store(&sender_ends, true);
    assert_int_equal(pthread_join(thread, &result), 0);
    assert_ptr_equal(result, &result);
    close(atomic_load(&fd_of_sender));
    close(other_file);
}

static void a_child_of_vfork_closes_its_descriptors_alone(void **state)
{
    uint8_t frame[FRAME];
    int status = -1;
    (void)state;
    int fd = open_socket(0);
    int other = open("/dev/null", O_RDWR);
    pid_t child = vfork();
    if (child == 0) {
        close(fd);
        dup2(other, fd);
        _exit(0);
    }
    assert_int_equal(waitpid(child, &status, 0), child);
    child = vfork();
    if (child == 0) {
        dup2(fd, other);
        closefrom(3);
        _exit(0);
    }
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_int_equal(write(other, "", 1), 1);
    send_one(fd, 9);
    assert_reply(frame, recv(fd, frame, sizeof frame, 0), 9);
    close(other);
    close(fd);
}

static void a_child_of_fork_receives_beside_its_parent(void **state)
{
    uint8_t frame[FRAME];
    int status = -1;
    (void)state;
    int fd = open_socket(0);
    int copy = fcntl(fd, F_DUPFD_CLOEXEC, 0);
    struct pollfd one = {.fd = copy, .events = POLLIN};
    send_one(fd, 1);
    pid_t child = fork();
    if (child == 0) {
        (void)alarm(LONGEST_S);
        bool done = poll(&one, 1, 0) == 1 && recv(fd, frame, sizeof frame, 0) == FRAME && poll(&one, 1, 0) == 0 &&
                    fcntl(copy, F_GETFD) == FD_CLOEXEC && fcntl(fd, F_GETFD) == 0 &&
                    (fcntl(fd, F_GETFL) & O_NONBLOCK) == 0;
        frame_of(frame, 2);
        done = done && send(copy, frame, sizeof frame, 0) == FRAME && poll(&one, 1, 1000) == 1 &&
               recv(copy, frame, sizeof frame, 0) == FRAME && frame[17] == 2;
        _exit(done ? 0 : 1);
    }
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_int_equal(status, 0);
    assert_int_equal(poll(&one, 1, 0), 1);
    assert_reply(frame, recv(fd, frame, sizeof frame, 0), 1);
    assert_int_equal(poll(&one, 1, 0), 0);
    close(copy);
    close(fd);
}

static void a_range_of_descriptors_is_closed(void **state)
{
    (void)state;
    int fd = open_socket(0);
    int copy = fcntl(fd, F_DUPFD, 200);
    assert_int_equal(copy, 200);
    assert_int_equal(close_range(150, 210, CLOSE_RANGE_CLOEXEC), 0);
    uint8_t frame[FRAME];
    send_one(copy, 3);
    assert_reply(frame, recv(copy, frame, sizeof frame, 0), 3);
    assert_int_equal(close_range(150, 210, 0), 0);
    assert_int_equal(fcntl(STDOUT_FILENO, F_DUPFD, copy), copy); /* a file, not the socket */
    assert_int_equal(write(copy, "", 0), 0);
    assert_int_equal(close(copy), 0);
    send_one(fd, 4);
    assert_reply(frame, recv(fd, frame, sizeof frame, 0), 4);
    copy = fcntl(fd, F_DUPFD, 200);
    closefrom(200);
    assert_int_equal(fcntl(STDOUT_FILENO, F_DUPFD, copy), copy);
    assert_int_equal(write(copy, "", 0), 0);
    close(copy);
    close(fd);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"signal(7): sigaction and signal return the action that was set", an_action_is_returned_as_it_was_set, NULL,
         NULL, NULL},
        {"sigaction(2): a handler with SA_RESETHAND runs once", a_handler_with_sa_resethand_runs_once, NULL, NULL,
         NULL},
        {"sigaction(2): a handler gets its signal's information and mask", a_handler_gets_information_and_mask, NULL,
         NULL, NULL},
        {"signal-safety(7): a handler sends and receives, wherever it interrupts its thread",
         a_handler_exchanges_frames_within_calls, NULL, NULL, NULL},
        {"signal(7): a receive ends with EINTR after a handler without SA_RESTART, or with a timeout",
         a_receive_ends_as_the_handler_asks, NULL, NULL, NULL},
        {"signal(7): a receive without timeout continues after a handler with SA_RESTART",
         a_restarted_receive_gets_the_reply, NULL, NULL, NULL},
        {"pthreads(7): a thread is cancelled in every kind of call, and the others go on",
         a_thread_is_cancelled_in_every_kind_of_call, NULL, NULL, NULL},
        {"pthread_setcancelstate(3): without cancellation a call is completed",
         a_thread_with_disabled_cancellation_completes_its_call, NULL, NULL, NULL},
        {"close(2): a thread that receives still gets a frame after another thread has closed the socket",
         a_socket_is_closed_while_a_thread_receives, NULL, NULL, NULL},
        {"close(2): a thread that sends and receives gets EBADF after another thread has closed the socket",
         a_socket_is_closed_while_a_thread_sends, NULL, NULL, NULL},
        {"vfork(2): a child closes its own descriptors, not those of the program",
         a_child_of_vfork_closes_its_descriptors_alone, NULL, NULL, NULL},
        {"fork(2): a child and its parent have the waiting frames, each its own",
         a_child_of_fork_receives_beside_its_parent, NULL, NULL, NULL},
        {"close_range(2), closefrom(3): sockets in the range are closed", a_range_of_descriptors_is_closed, NULL, NULL,
         NULL},
    };
    if (!is_started(argc, argv))
        return 1;
    return cmocka_run_group_tests(tests, NULL, NULL);
}
