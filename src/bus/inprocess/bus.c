/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bus/inprocess/bus.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <limits.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "bus/inprocess/real.h"
#include "bus/library.h"

enum { WORDS_MOST = 4096, SEPARATOR = 0x1F };

/* Functions of libectwin.so. */
typedef struct library {
    __typeof__(&ectwin_bus_open) open;
    __typeof__(&ectwin_bus_close) close;
    __typeof__(&ectwin_bus_link) link;
    __typeof__(&ectwin_bus_frame) frame;
    __typeof__(&ectwin_bus_reply) reply;
    __typeof__(&ectwin_bus_run) run;
    __typeof__(&ectwin_bus_control) control;
    __typeof__(&ectwin_bus_control_path) control_path;
    __typeof__(&ectwin_bus_serve) serve;
    __typeof__(&ectwin_bus_verdict) verdict;
} library_t;

static struct {
    library_t library;
    ectwin_bus_t *bus;
    int control_fd;
    bool failed;
    bool down[ECT_BUS_ENDS];
    ect_bus_deliver_t *deliver;
} state = {.control_fd = -1};

__thread int ect_inside __attribute__((tls_model("initial-exec")));
__thread bool ect_in_dlsym __attribute__((tls_model("initial-exec")));

static void *find(const char *name)
{
    bool nested = ect_in_dlsym; /* called by a resolver function (ifunc) within dlsym() */
    ect_inside++;
    ect_in_dlsym = true;
    void *found = dlsym(RTLD_NEXT, name);
    ect_in_dlsym = nested;
    ect_inside--;
    return found;
}

static __typeof__(&pthread_sigmask) set_mask;

/* Does not block signals, and therefore runs before the program can install a handler. */
static void find_mask(void)
{
    if (!set_mask)
        set_mask = (__typeof__(&pthread_sigmask))find("pthread_sigmask");
}

void *ect_real(const char *name)
{
    sigset_t others, before;
    find_mask();
    sigfillset(&others);
    sigdelset(&others, SIGSYS);
    set_mask(SIG_BLOCK, &others, &before);
    void *found = find(name);
    set_mask(SIG_SETMASK, &before, NULL);
    return found;
}

const char *ect_bus_name(unsigned int end)
{
    return getenv(end == 0 ? "ECTWIN_IFACE" : "ECTWIN_IFACE2");
}

int ect_bus_end_of_name(const char *name)
{
    for (unsigned int end = 0; end < ECT_BUS_ENDS; end++) {
        const char *its = ect_bus_name(end);
        if (its && strcmp(its, name) == 0)
            return (int)end;
    }
    return -1;
}

int ect_bus_end_of_index(int index)
{
    int end = index - ECT_BUS_INDEX;
    return end >= 0 && end < ECT_BUS_ENDS && ect_bus_name((unsigned int)end) ? end : -1;
}

static void *symbol(void *handle, const char *name, bool *whole)
{
    void *found = dlsym(handle, name);
    *whole &= found != NULL;
    return found;
}

/* The library of the bus is in this library's folder, as in a build, or in the parent folder, as installed. */
static void *open_library(char path[PATH_MAX])
{
    static const char *const places[] = {"", "../"};
    Dl_info self;
    void *handle = NULL;
    if (dladdr((void *)&state, &self) == 0 || !self.dli_fname)
        return NULL;
    const char *slash = strrchr(self.dli_fname, '/');
    int folder = slash ? (int)(slash - self.dli_fname + 1) : 0;
    for (size_t i = 0; !handle && i < sizeof places / sizeof *places; i++) {
        snprintf(path, PATH_MAX, "%.*s%s" ECTWIN_LIBRARY, folder, self.dli_fname, places[i]);
        handle = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    }
    return handle;
}

static bool load(library_t *library)
{
    char path[PATH_MAX] = "";
    void *handle = open_library(path);
    if (!handle) {
        fprintf(stderr, "ectwin: %s; install ectwin again\n", dlerror());
        return false;
    }
    bool whole = true;
    *library = (library_t){.open = symbol(handle, "ectwin_bus_open", &whole),
                           .close = symbol(handle, "ectwin_bus_close", &whole),
                           .link = symbol(handle, "ectwin_bus_link", &whole),
                           .frame = symbol(handle, "ectwin_bus_frame", &whole),
                           .reply = symbol(handle, "ectwin_bus_reply", &whole),
                           .run = symbol(handle, "ectwin_bus_run", &whole),
                           .control = symbol(handle, "ectwin_bus_control", &whole),
                           .control_path = symbol(handle, "ectwin_bus_control_path", &whole),
                           .serve = symbol(handle, "ectwin_bus_serve", &whole),
                           .verdict = symbol(handle, "ectwin_bus_verdict", &whole)};
    if (!whole)
        fprintf(stderr, "ectwin: %s is of another version; install ectwin again\n", path);
    return whole;
}

static void leave_mark(char mark)
{
    const char *path = getenv("ECTWIN_INPROCESS_MARK");
    int fd = path ? REAL(open)(path, O_WRONLY | O_APPEND | O_CLOEXEC) : -1;
    if (fd < 0)
        return;
    (void)!REAL(write)(fd, &mark, 1);
    REAL(close)(fd);
}

static ectwin_bus_t *open_bus(char *words, uint64_t now_ns)
{
    const char *list[WORDS_MOST];
    const char separators[] = {SEPARATOR, 0};
    int count = 0;
    for (char *word = strsep(&words, separators); word && count < WORDS_MOST; word = strsep(&words, separators))
        list[count++] = word;
    const char *folder = getenv("ECTWIN_INPROCESS_CWD");
    int here = REAL(open)(".", O_PATH | O_DIRECTORY | O_CLOEXEC);
    bool moved = folder && here >= 0 && chdir(folder) == 0;
    char why[ECTWIN_MESSAGE];
    ectwin_bus_t *bus = state.library.open(count, list, now_ns, why);
    if (!bus)
        fprintf(stderr, "ectwin: %s\n", why);
    if (moved)
        (void)!fchdir(here);
    if (here >= 0)
        REAL(close)(here);
    return bus;
}

static bool start(uint64_t now_ns)
{
    const char *words = getenv("ECTWIN_INPROCESS");
    char *copy = words ? strdup(words) : NULL;
    if (copy)
        leave_mark(ECT_BUS_MARK_OPENED); /* a failed start of the bus reports itself */
    if (copy && (state.library.open || load(&state.library)))
        state.bus = open_bus(copy, now_ns);
    free(copy);
    if (!state.bus)
        return false;
    state.control_fd = state.library.control(state.bus);
    if (state.control_fd >= 0)
        setenv("ECTWIN_SOCKET", state.library.control_path(state.bus), 1);
    return true;
}

bool ect_bus_running(void)
{
    return state.bus != NULL;
}

/* The bus remains with the parent. */
static void in_child(void)
{
    state.bus = NULL;
    state.failed = false;
    state.control_fd = -1;
}

__attribute__((constructor)) static void begin(void)
{
    find_mask();
    (void)pthread_atfork(NULL, NULL, in_child);
}

int ect_bus_start(uint64_t now_ns, ect_bus_deliver_t *deliver)
{
    if (ect_bus_running())
        return 0;
    if (state.failed)
        return -1;
    state.control_fd = -1;
    state.deliver = deliver;
    int before = ect_enter();
    state.failed = !start(now_ns);
    ect_leave(before);
    return state.failed ? -1 : 1;
}

static void deliver(void)
{
    uint8_t frame[ECTWIN_FRAME_MAX];
    unsigned int end;
    size_t length;
    while ((length = state.library.reply(state.bus, &end, frame, sizeof frame)) > 0)
        state.deliver(end, frame, length);
}

bool ect_bus_is_up(unsigned int end)
{
    return !state.down[end];
}

void ect_bus_plug(unsigned int end, bool in, uint64_t now_ns)
{
    state.down[end] = !in;
    if (!ect_bus_running())
        return;
    int before = ect_enter();
    state.library.link(state.bus, end, in, now_ns);
    ect_leave(before);
}

uint64_t ect_bus_run(uint64_t now_ns)
{
    int before = ect_enter();
    uint64_t next_ns = state.library.run(state.bus, now_ns);
    deliver();
    ect_leave(before);
    return next_ns;
}

uint64_t ect_bus_frame(unsigned int end, const void *frame, size_t length, uint64_t now_ns)
{
    int before = ect_enter();
    uint64_t next_ns = state.library.frame(state.bus, end, frame, length, now_ns);
    deliver();
    ect_leave(before);
    return next_ns;
}

bool ect_bus_serve(uint64_t now_ns)
{
    int before = ect_enter();
    bool more = state.library.serve(state.bus, now_ns) != 0;
    deliver();
    ect_leave(before);
    return more;
}

int ect_bus_control_fd(void)
{
    return state.control_fd;
}

/* Prints the expectations of the scenario, one line each. */
static void report_verdict(void)
{
    enum { ROOM = 65536 };
    char *text = calloc(1, ROOM);
    if (!text)
        return;
    if (state.library.verdict(state.bus, text, ROOM) == 0)
        leave_mark(ECT_BUS_MARK_MET);
    for (char *rest = text, *line = strsep(&rest, "\n"); line; line = strsep(&rest, "\n")) {
        if (*line != 0)
            fprintf(stderr, "ectwin: %s\n", line);
    }
    free(text);
}

void ect_bus_end(void)
{
    if (!ect_bus_running())
        return;
    int before = ect_enter();
    report_verdict();
    state.library.close(state.bus);
    state.bus = NULL;
    state.control_fd = -1;
    ect_leave(before);
}
