/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bus/net/sandbox.h"

#include <errno.h>
#include <fcntl.h>
#include <linux/sockios.h>
#include <sched.h>
#include <seccomp.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/socket.h>

#define COUNT(list) (sizeof(list) / sizeof(list)[0])

/* Frames, clients, time, memory, saved data, and the end. */
static const int running[] = {
    SCMP_SYS(accept),
    SCMP_SYS(accept4),
    SCMP_SYS(bind), /* of existing sockets: socket() is limited */
    SCMP_SYS(brk),
    SCMP_SYS(clock_gettime),
    SCMP_SYS(clock_gettime64),
    SCMP_SYS(clock_nanosleep),
    SCMP_SYS(clock_nanosleep_time64),
    SCMP_SYS(close),
    SCMP_SYS(epoll_ctl),
    SCMP_SYS(epoll_pwait),
    SCMP_SYS(epoll_wait),
    SCMP_SYS(exit),
    SCMP_SYS(exit_group),
    SCMP_SYS(fallocate),
    SCMP_SYS(fcntl),
    SCMP_SYS(fcntl64),
    SCMP_SYS(fdatasync),
    SCMP_SYS(flock),
    SCMP_SYS(fstat),
    SCMP_SYS(fstat64),
    SCMP_SYS(fsync),
    SCMP_SYS(ftruncate),
    SCMP_SYS(ftruncate64),
    SCMP_SYS(futex),
    SCMP_SYS(futex_time64),
    SCMP_SYS(getegid),
    SCMP_SYS(geteuid),
    SCMP_SYS(getgid),
    SCMP_SYS(getpid),
    SCMP_SYS(getrandom),
    SCMP_SYS(getsockname),
    SCMP_SYS(getsockopt),
    SCMP_SYS(gettid),
    SCMP_SYS(gettimeofday),
    SCMP_SYS(getuid),
    SCMP_SYS(lseek),
    SCMP_SYS(_llseek),
    SCMP_SYS(lstat),
    SCMP_SYS(madvise),
    SCMP_SYS(mremap),
    SCMP_SYS(munmap),
    SCMP_SYS(nanosleep),
    SCMP_SYS(newfstatat),
    SCMP_SYS(poll),
    SCMP_SYS(ppoll),
    SCMP_SYS(ppoll_time64),
    SCMP_SYS(pread64),
    SCMP_SYS(pwrite64),
    SCMP_SYS(read),
    SCMP_SYS(recv),
    SCMP_SYS(recvfrom),
    SCMP_SYS(recvmsg),
    SCMP_SYS(restart_syscall),
    SCMP_SYS(rseq),
    SCMP_SYS(rt_sigaction),
    SCMP_SYS(rt_sigprocmask),
    SCMP_SYS(rt_sigreturn),
    SCMP_SYS(sched_getparam), /* by the C library, before it starts the thread that waits for the disk */
    SCMP_SYS(sched_getscheduler),
    SCMP_SYS(sched_yield),
    SCMP_SYS(send),
    SCMP_SYS(sendmsg),
    SCMP_SYS(sendto),
    SCMP_SYS(set_robust_list),
    SCMP_SYS(setsockopt),
    SCMP_SYS(shutdown),
    SCMP_SYS(sigaltstack),
    SCMP_SYS(stat),
    SCMP_SYS(statx),
    SCMP_SYS(sysinfo),
    SCMP_SYS(tgkill), /* abort() */
    SCMP_SYS(unlink), /* of the control socket */
    SCMP_SYS(unlinkat),
    SCMP_SYS(write),
    SCMP_SYS(writev),
};

static const int with_children[] = {
    SCMP_SYS(kill),
    SCMP_SYS(wait4),
    SCMP_SYS(waitid),
    SCMP_SYS(waitpid),
};

/* Files that a master writes are opened and renamed. */
static const int with_files[] = {SCMP_SYS(openat), SCMP_SYS(rename), SCMP_SYS(renameat), SCMP_SYS(renameat2)};

/* Connections to local sockets, which are found by reading a folder. */
static const int with_client[] = {SCMP_SYS(connect), SCMP_SYS(getdents), SCMP_SYS(getdents64), SCMP_SYS(getpeername)};

/* Calls with which the sanitizers report leaks at the end. */
#ifdef __SANITIZE_ADDRESS__
static const int sanitizers[] = {
    SCMP_SYS(open),   SCMP_SYS(getdents), SCMP_SYS(getppid),    SCMP_SYS(arch_prctl),
    SCMP_SYS(clone),  SCMP_SYS(getdents), SCMP_SYS(getdents64), SCMP_SYS(kill),
    SCMP_SYS(openat), SCMP_SYS(prctl),    SCMP_SYS(prlimit64),  SCMP_SYS(process_vm_readv),
    SCMP_SYS(ptrace), SCMP_SYS(readlink), SCMP_SYS(readlinkat), SCMP_SYS(sched_getaffinity),
    SCMP_SYS(wait4),
};
#else
static const int sanitizers[] = {SCMP_SYS(exit)};
#endif

/* Allows calls with any arguments. A call missing on this machine needs no rule. */
static int allow(scmp_filter_ctx filter, const int *calls, size_t count)
{
    int error = 0;
    for (size_t i = 0; i < count && error == 0; i++) {
        error = seccomp_rule_add(filter, SCMP_ACT_ALLOW, calls[i], 0);
        error = error == -EDOM ? 0 : error;
    }
    return error;
}

/* Allows a call whose arguments satisfy all conditions. A call missing on this machine needs no rule. */
static int allow_if(scmp_filter_ctx filter, int call, const struct scmp_arg_cmp *conditions, unsigned int count)
{
    int error = seccomp_rule_add_array(filter, SCMP_ACT_ALLOW, call, count, conditions);
    return error == -EDOM ? 0 : error;
}

/* Allows threads, but no processes. */
static int allow_threads(scmp_filter_ctx filter)
{
    const struct scmp_arg_cmp thread = {
        .arg = 0, .op = SCMP_CMP_MASKED_EQ, .datum_a = CLONE_THREAD, .datum_b = CLONE_THREAD};
    return allow_if(filter, SCMP_SYS(clone), &thread, 1);
}

/* Allows local stream sockets, which cannot connect. */
static int allow_sockets(scmp_filter_ctx filter)
{
    const scmp_datum_t type = (uint32_t)~(SOCK_CLOEXEC | SOCK_NONBLOCK);
    const struct scmp_arg_cmp local[] = {
        {.arg = 0, .op = SCMP_CMP_EQ, .datum_a = AF_UNIX},
        {.arg = 1, .op = SCMP_CMP_MASKED_EQ, .datum_a = type, .datum_b = SOCK_STREAM},
    };
    return allow_if(filter, SCMP_SYS(socket), local, COUNT(local));
}

/* Allows existing files to be opened for reading. */
static int allow_reading(scmp_filter_ctx filter)
{
    const struct scmp_arg_cmp reading = {
        .arg = 2, .op = SCMP_CMP_MASKED_EQ, .datum_a = O_ACCMODE | O_CREAT | O_TRUNC, .datum_b = O_RDONLY};
    return allow_if(filter, SCMP_SYS(openat), &reading, 1);
}

/* Allows memory that is not executable. */
static int allow_memory(scmp_filter_ctx filter)
{
    static const int calls[] = {SCMP_SYS(mmap), SCMP_SYS(mmap2), SCMP_SYS(mprotect)};
    const struct scmp_arg_cmp data = {.arg = 2, .op = SCMP_CMP_MASKED_EQ, .datum_a = PROT_EXEC, .datum_b = 0};
    int error = 0;
    for (size_t i = 0; i < COUNT(calls) && error == 0; i++)
        error = allow_if(filter, calls[i], &data, 1);
    return error;
}

/* Allows requests for the interface's flags, address, number and link, for the age of a frame, and those of the C
 * library for a terminal. */
static int allow_ioctls(scmp_filter_ctx filter)
{
    static const unsigned long numbers[] = {SIOCGIFFLAGS, SIOCSIFFLAGS, SIOCGIFHWADDR, SIOCGIFINDEX, SIOCETHTOOL,
                                            SIOCGSTAMPNS, FIONREAD,     TCGETS,        TIOCGWINSZ};
    int error = 0;
    for (size_t i = 0; i < COUNT(numbers) && error == 0; i++) {
        const struct scmp_arg_cmp number = {
            .arg = 1, .op = SCMP_CMP_MASKED_EQ, .datum_a = UINT32_MAX, .datum_b = numbers[i]};
        error = allow_if(filter, SCMP_SYS(ioctl), &number, 1);
    }
    return error;
}

static int allow_in_part(scmp_filter_ctx filter)
{
    static int (*const parts[])(scmp_filter_ctx filter) = {allow_threads, allow_sockets, allow_reading, allow_memory,
                                                           allow_ioctls};
    int error = 0;
    for (size_t i = 0; i < COUNT(parts) && error == 0; i++)
        error = parts[i](filter);
    return error;
}

int ect_sandbox_enter(bool children, bool files, bool client)
{
    scmp_filter_ctx filter = seccomp_init(SCMP_ACT_ERRNO(ENOSYS));
    if (!filter) {
        errno = ENOMEM;
        return -1;
    }
    int error = seccomp_attr_set(filter, SCMP_FLTATR_CTL_TSYNC, 1);
    error = error != 0 ? error : seccomp_attr_set(filter, SCMP_FLTATR_CTL_OPTIMIZE, 2);
    error = error != 0 ? error : allow(filter, running, COUNT(running));
    error = error != 0 ? error : allow(filter, with_children, children ? COUNT(with_children) : 0);
    error = error != 0 ? error : allow(filter, with_files, files ? COUNT(with_files) : 0);
    error = error != 0 ? error : allow(filter, with_client, client ? COUNT(with_client) : 0);
    error = error != 0 ? error : allow(filter, sanitizers, COUNT(sanitizers));
    error = error != 0 ? error : allow_in_part(filter);
    error = error != 0 ? error : seccomp_load(filter);
    seccomp_release(filter);
    errno = -error;
    return error == 0 ? 0 : -1;
}
