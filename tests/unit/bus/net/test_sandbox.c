/* SPDX-License-Identifier: MIT */
/* Each system call that docs/SECURITY.md denies to a running twin (bus/net/sandbox.h), tried in a process of its own.
 */
#define _GNU_SOURCE
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <linux/seccomp.h>
#include <linux/sockios.h>
#include <net/if.h>
#include <pthread.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/ptrace.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

#include "bus/net/sandbox.h"

static char folder[] = "/tmp/ectwin-sandbox-XXXXXX";

static int make_folder(void **state)
{
    (void)state;
    if (!mkdtemp(folder) || chdir(folder) < 0)
        return -1;
    int fd = open("file", O_WRONLY | O_CREAT, 0600);
    ssize_t written = write(fd, "content", 7);
    close(fd);
    return written == 7 ? 0 : -1;
}

static int remove_folder(void **state)
{
    (void)state;
    return unlink("file") == 0 ? rmdir(folder) : -1;
}

/* --- calls: each returns as the system call, -1 and errno on failure ---------------------------------------------- */

static long close_if_open(int fd)
{
    return fd < 0 ? -1 : close(fd);
}

static long open_writing(void)
{
    return close_if_open(openat(AT_FDCWD, "file", O_WRONLY));
}

static long open_both(void)
{
    return close_if_open(openat(AT_FDCWD, "file", O_RDWR));
}

static long open_new(void)
{
    return close_if_open(openat(AT_FDCWD, "new", O_RDONLY | O_CREAT, 0600));
}

static long open_truncating(void)
{
    return close_if_open(openat(AT_FDCWD, "file", O_RDONLY | O_TRUNC));
}

static long open_unnamed(void)
{
    return close_if_open(openat(AT_FDCWD, ".", O_RDWR | O_TMPFILE, 0600));
}

static long open_2(void)
{
    return close_if_open((int)syscall(SYS_openat2, AT_FDCWD, "file", NULL, 0));
}

static long rename_file(void)
{
    return rename("file", "other");
}

static long rename_and_back(void)
{
    return rename("file", "other") == 0 ? rename("other", "file") : -1;
}

static long make_directory(void)
{
    return mkdirat(AT_FDCWD, "folder", 0700);
}

static long change_mode(void)
{
    return fchmodat(AT_FDCWD, "file", 0777, 0);
}

static long link_file(void)
{
    return linkat(AT_FDCWD, "file", AT_FDCWD, "second", 0);
}

static long truncate_file(void)
{
    return truncate("file", 0);
}

static long internet_socket(void)
{
    return close_if_open(socket(AF_INET, SOCK_STREAM, 0));
}

static long packet_socket(void)
{
    return close_if_open(socket(AF_PACKET, SOCK_RAW, 0));
}

static long netlink_socket(void)
{
    return close_if_open(socket(AF_NETLINK, SOCK_RAW, 0));
}

static long local_datagrams(void)
{
    return close_if_open(socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
}

static long socket_pair(void)
{
    int fds[2];
    return socketpair(AF_UNIX, SOCK_STREAM, 0, fds);
}

static long connect_local(void)
{
    const struct sockaddr_un address = {.sun_family = AF_UNIX, .sun_path = "none"};
    int fd = socket(AF_UNIX, SOCK_STREAM, 0);
    return fd < 0 ? 0 : connect(fd, (const struct sockaddr *)&address, sizeof address);
}

static long list_folder(void)
{
    DIR *folder_of_test = opendir(".");
    long result = folder_of_test && readdir(folder_of_test) ? 0 : -1;
    if (folder_of_test)
        closedir(folder_of_test);
    return result;
}

static long start_program(void)
{
    char *const none[] = {NULL};
    return execve("/bin/true", none, none);
}

static long start_process(void)
{
    pid_t pid = (pid_t)syscall(SYS_clone, SIGCHLD, 0, 0, 0, 0);
    if (pid == 0)
        _exit(0);
    return pid;
}

static long start_process_3(void)
{
    return syscall(SYS_clone3, NULL, 0);
}

static long signal_another(void)
{
    return kill(getppid(), 0);
}

static long trace_another(void)
{
    return ptrace(PTRACE_SEIZE, 1, 0, 0);
}

static long write_to_another(void)
{
    return syscall(SYS_process_vm_writev, 1, NULL, 0, NULL, 0, 0);
}

static long map_code(void)
{
    void *at = mmap(NULL, 4096, PROT_READ | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    return at == MAP_FAILED ? -1 : 0;
}

static long make_code(void)
{
    static _Alignas(65536) char page[65536];
    return mprotect(page, sizeof page, PROT_READ | PROT_EXEC);
}

static long memory_file(void)
{
    return close_if_open(memfd_create("x", 0));
}

static long type_into_terminal(void)
{
    return ioctl(STDIN_FILENO, TIOCSTI, "x");
}

static long interface_name(void)
{
    struct ifreq request = {.ifr_ifindex = 1};
    return ioctl(STDIN_FILENO, SIOCGIFNAME, &request);
}

static long new_namespace(void)
{
    return syscall(SYS_unshare, 0x10000000 /* CLONE_NEWUSER */);
}

static long mount_something(void)
{
    return syscall(SYS_mount, "none", "/tmp", "tmpfs", 0, NULL);
}

static long another_filter(void)
{
    return syscall(SYS_seccomp, SECCOMP_SET_MODE_FILTER, 0, NULL);
}

static long executable_personality(void)
{
    return syscall(SYS_personality, 0x0400000);
}

static long kernel_ring(void)
{
    return syscall(SYS_io_uring_setup, 1, NULL);
}

static long trace_kernel(void)
{
    return syscall(SYS_bpf, 0, NULL, 0);
}

/* --- calls that a running twin needs ------------------------------------------------------------------------------ */

static long open_reading(void)
{
    return close_if_open(openat(AT_FDCWD, "file", O_RDONLY | O_CLOEXEC));
}

static long local_stream(void)
{
    return close_if_open(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
}

static long map_data(void)
{
    void *at = mmap(NULL, 4096, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    return at == MAP_FAILED ? -1 : mprotect(at, 4096, PROT_NONE);
}

static void *nothing(void *unused)
{
    return unused;
}

static long start_thread(void)
{
    pthread_t thread;
    errno = pthread_create(&thread, NULL, nothing, NULL);
    return errno != 0 ? -1 : pthread_join(thread, NULL);
}

/* The result is that of the kernel for a wrong descriptor. */
static unsigned long request;

static long ask(void)
{
    return ioctl(-1, request, NULL);
}

static long await_child(void)
{
    return waitpid(-1, NULL, WNOHANG);
}

/* --- tests -------------------------------------------------------------------------------------------------------- */

typedef struct call {
    const char *what;
    long (*call)(void);
    bool sanitizer; /* the address sanitizer needs the call too */
} call_t;

enum { ALLOWED = 0, DENIED = 1, NO_FILTER = 2, REFUSED = 3 };

/* The result of a call behind the filter, in a process of its own. */
static int try(long (*call)(void), bool children, bool files, bool client)
{
    int status = 0;
    fflush(NULL);
    pid_t pid = fork();
    assert_true(pid >= 0);
    if (pid == 0) {
        if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) < 0 || ect_sandbox_enter(children, files, client) != 0)
            _exit(REFUSED);
        if (prctl(PR_GET_SECCOMP, 0, 0, 0, 0) == 0)
            _exit(NO_FILTER);
        errno = 0;
        long result = call();
        _exit(result < 0 && errno == ENOSYS ? DENIED : ALLOWED);
    }
    assert_int_equal(waitpid(pid, &status, 0), pid);
    if (!WIFEXITED(status))
        fail_msg("killed by signal %d", WTERMSIG(status));
    return WEXITSTATUS(status);
}

static bool sanitized(void)
{
#ifdef __SANITIZE_ADDRESS__
    return true;
#else
    return false;
#endif
}

/* A kernel that can filter must take the filter. */
static void skip_without_filter(void)
{
    const uint32_t action = SECCOMP_RET_ERRNO;
    if (syscall(SYS_seccomp, SECCOMP_GET_ACTION_AVAIL, 0, &action) < 0)
        skip();
    if (try(open_reading, false, false, false) == NO_FILTER)
        skip(); /* built without libseccomp */
}

static void expect(const call_t *calls, size_t count, int want, bool children, bool files, bool client)
{
    for (size_t i = 0; i < count; i++) {
        if (sanitized() && calls[i].sanitizer)
            continue;
        int got = try(calls[i].call, children, files, client);
        if (got != want)
            fail_msg("%s: expected %s, got %d", calls[i].what, want == DENIED ? "ENOSYS" : "success", got);
    }
}

static const call_t writing_files[] = {
    {"open for writing", open_writing, true},
    {"open for reading and writing", open_both, true},
    {"open a new file", open_new, true},
    {"open and truncate, read-only", open_truncating, true},
    {"open a file without a name", open_unnamed, true},
    {"rename", rename_file, false},
};

static void denied(void **state)
{
    static const call_t calls[] = {
        {"openat2", open_2, false},
        {"mkdir", make_directory, false},
        {"chmod", change_mode, false},
        {"link", link_file, false},
        {"truncate", truncate_file, false},
        {"socket AF_INET", internet_socket, false},
        {"socket AF_PACKET", packet_socket, false},
        {"socket AF_NETLINK", netlink_socket, false},
        {"socket AF_UNIX datagrams", local_datagrams, false},
        {"socketpair", socket_pair, false},
        {"connect", connect_local, false},
        {"execve", start_program, false},
        {"clone a process", start_process, true},
        {"clone3", start_process_3, false},
        {"kill", signal_another, true},
        {"ptrace", trace_another, true},
        {"process_vm_writev", write_to_another, false},
        {"mmap executable", map_code, false},
        {"mprotect executable", make_code, false},
        {"memfd_create", memory_file, false},
        {"ioctl TIOCSTI", type_into_terminal, false},
        {"ioctl SIOCGIFNAME", interface_name, false},
        {"unshare", new_namespace, false},
        {"mount", mount_something, false},
        {"seccomp", another_filter, false},
        {"personality", executable_personality, false},
        {"io_uring_setup", kernel_ring, false},
        {"bpf", trace_kernel, false},
    };
    (void)state;
    skip_without_filter();
    expect(writing_files, sizeof writing_files / sizeof writing_files[0], DENIED, false, false, false);
    expect(calls, sizeof calls / sizeof calls[0], DENIED, false, false, false);
    expect(calls, 16, DENIED, false, true, false); /* --files opens and renames files, and nothing else */
    /* A client connects and lists folders, and nothing else. */
    expect(writing_files, sizeof writing_files / sizeof writing_files[0], DENIED, false, false, true);
    expect(calls, 10, DENIED, false, false, true);
    expect(calls + 11, sizeof calls / sizeof calls[0] - 11, DENIED, false, false, true);
    struct stat info;
    assert_int_equal(stat("file", &info), 0);
    assert_int_equal(info.st_size, 7);
}

static void allowed(void **state)
{
    static const call_t calls[] = {
        {"open for reading", open_reading, false},
        {"socket AF_UNIX stream", local_stream, false},
        {"mmap and mprotect data", map_data, false},
        {"a thread", start_thread, false},
    };
    static const call_t with_files[] = {{"open for writing", open_writing, false}, {"rename", rename_and_back, false}};
    static const call_t with_children[] = {{"kill", signal_another, false}, {"wait", await_child, false}};
    static const call_t with_client[] = {{"connect", connect_local, false}, {"list a folder", list_folder, false}};
    static const unsigned long requests[] = {SIOCGIFFLAGS, SIOCSIFFLAGS, SIOCGIFHWADDR, SIOCGIFINDEX, SIOCETHTOOL,
                                             SIOCGSTAMPNS, FIONREAD,     TCGETS,        TIOCGWINSZ};
    (void)state;
    skip_without_filter();
    expect(calls, sizeof calls / sizeof calls[0], ALLOWED, false, false, false);
    expect(with_files, 2, ALLOWED, false, true, false);
    expect(with_children, 2, ALLOWED, true, false, false);
    expect(with_client, 2, ALLOWED, false, false, true);
    for (size_t i = 0; i < sizeof requests / sizeof requests[0]; i++) {
        char title[32];
        const call_t one = {title, ask, false};
        snprintf(title, sizeof title, "ioctl %lx", requests[i]);
        request = requests[i];
        expect(&one, 1, ALLOWED, false, false, false);
    }
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"Each call that SECURITY.md denies is denied", denied, NULL, NULL, NULL},
        {"Each call that a running twin needs is allowed", allowed, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Sandbox", tests, make_folder, remove_folder);
}
