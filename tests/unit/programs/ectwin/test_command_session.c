/* SPDX-License-Identifier: MIT */
/* `ectwin run` and `ectwin with` on a machine of the test: the order of the steps, the end after each failure, and the
 * hints about interfaces. */
#define _GNU_SOURCE
#include "command_lines.h"

#include <arpa/inet.h>
#include <errno.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <sched.h>
#include <signal.h>

#include "bus/control/control.h"
#include "bus/kernel/kernel.h"
#include "bus/modbus/modbus.h"
#include "bus/net/netns.h"
#include "bus/net/packet.h"
#include "bus/net/rights.h"
#include "bus/net/udp.h"
#include "bus/runner.h"
#include "bus/trace.h"

enum { ADDRESSES = 2, LINK_FD = 1000, INDEX = 7 };

/* An address of an interface. */
typedef struct address {
    const char *iface;
    const char *text; /* NULL: an interface without an address */
} address_t;

/* The machine of a run; zeros: everything succeeds. */
typedef struct machine {
    const char *no_interface; /* cannot be opened */
    bool was_down, no_link, no_watch, no_realtime, no_kernel, no_hook, no_drop, no_control, no_observer;
    int udp_error, modbus_error;
    address_t addresses[ADDRESSES];
    bool no_addresses;
    bool fails, circulates, refuses; /* the loop */
    bool signals;                    /* the loop gets SIGINT of the terminal and SIGTERM of a process */
    unsigned int lacks;
    bool no_network, no_process;
} machine_t;

static machine_t machine;
static int program;
static size_t huge;      /* blocks of memory */
static bool huge_heap;   /* the growth of the heap is one of them */
static char heap[2][40]; /* before and after the twins */

/* --- functions of other rooms ------------------------------------------------------------------------------------- */

int __wrap_ect_packet_open(ect_packet_t *port, const char *iface, char *message);
void __wrap_ect_packet_close(ect_packet_t *port);
bool __wrap_ect_packet_share(ect_packet_t *port);
bool __wrap_ect_packet_has_link(const ect_packet_t *port);
int __wrap_ect_packet_watch_links(void);
int __wrap_ect_udp_open(ect_udp_t *port, const char *where, char *message);
void __wrap_ect_udp_close(ect_udp_t *port);
ect_modbus_server_t *__wrap_ect_modbus_server_open(const char *where, char *message);
bool __wrap_ect_modbus_server_observe(ect_modbus_server_t *server, ect_modbus_observer_t *observer, void *ctx);
void __real_ect_trace_log(ect_trace_t *trace, ect_logged_kind_t kind, uint32_t value, uint64_t time_ns,
                          const char *text, size_t length);
void __wrap_ect_trace_log(ect_trace_t *trace, ect_logged_kind_t kind, uint32_t value, uint64_t time_ns,
                          const char *text, size_t length);
void __wrap_ect_modbus_server_close(ect_modbus_server_t *server);
const char *__wrap_ect_modbus_server_address(const ect_modbus_server_t *server);
int __wrap_ect_rights_drop(unsigned int keep, char *message);
int __wrap_ect_rights_realtime(int priority, char *message);
ect_kernel_t *__wrap_ect_kernel_load(char *message);
int __wrap_ect_kernel_attach(ect_kernel_t *kernel, unsigned int index, char *message);
const char *__wrap_ect_kernel_hook(const ect_kernel_t *kernel);
void __wrap_ect_kernel_close(ect_kernel_t *kernel);
ect_control_t *__wrap_ect_control_open(const char *name, char *message);
void __wrap_ect_control_describe(ect_control_t *control, const ect_about_t *about);
void __wrap_ect_control_report(ect_control_t *control, void (*report)(void *ctx, const char *text), void *ctx);
const char *__wrap_ect_control_path(const ect_control_t *control);
void __wrap_ect_control_close(ect_control_t *control);
int __wrap_ect_runner_run(ect_runner_t *runner);
void __wrap_ect_pages_make_huge(void *block, size_t size);
void *__wrap_sbrk(intptr_t increment);
int __wrap_getifaddrs(struct ifaddrs **all);
void __wrap_freeifaddrs(struct ifaddrs *all);
int __wrap_sched_setscheduler(pid_t process, int policy, const struct sched_param *parameters);
int __wrap_ect_netns_enter(const char *const masters[ECT_NETNS_WIRES], unsigned int *lacks, char *message);
pid_t __wrap_contain_start(void (*run)(const void *ctx), const void *ctx);

int __wrap_ect_packet_open(ect_packet_t *port, const char *iface, char *message)
{
    fprintf(stderr, "open %s\n", iface);
    memset(port, 0, sizeof *port);
    snprintf(port->iface, sizeof port->iface, "%s", iface);
    port->was_down = machine.was_down;
    port->index = INDEX;
    strcpy(message, "no interface");
    return machine.no_interface && strcmp(machine.no_interface, iface) == 0 ? -1 : 0;
}

void __wrap_ect_packet_close(ect_packet_t *port)
{
    fprintf(stderr, "close %s\n", port->iface);
}

bool __wrap_ect_packet_share(ect_packet_t *port)
{
    fprintf(stderr, "share %s\n", port->iface);
    return false;
}

bool __wrap_ect_packet_has_link(const ect_packet_t *port)
{
    (void)port;
    return !machine.no_link;
}

int __wrap_ect_packet_watch_links(void)
{
    errno = EMFILE;
    return machine.no_watch ? -1 : LINK_FD;
}

int __wrap_ect_udp_open(ect_udp_t *port, const char *where, char *message)
{
    fprintf(stderr, "UDP %s\n", where);
    strcpy(port->address, "address:1");
    strcpy(message, "no port");
    errno = machine.udp_error;
    return machine.udp_error != 0 ? -1 : 0;
}

void __wrap_ect_udp_close(ect_udp_t *port)
{
    fprintf(stderr, "close %s\n", port->address);
}

static ect_modbus_server_t *const server = (ect_modbus_server_t *)(void *)&machine;

ect_modbus_server_t *__wrap_ect_modbus_server_open(const char *where, char *message)
{
    fprintf(stderr, "Modbus %s\n", where);
    strcpy(message, "no port");
    errno = machine.modbus_error;
    return machine.modbus_error != 0 ? NULL : server;
}

bool __wrap_ect_modbus_server_observe(ect_modbus_server_t *one, ect_modbus_observer_t *observer, void *ctx)
{
    static const uint8_t request[] = {0x00, 0x1F, 0xA0}, reply[] = {0x9B, 0xFF};
    (void)one;
    observer(ctx, request, sizeof request, reply, sizeof reply);
    errno = EMFILE;
    return !machine.no_observer;
}

/* Without a trace: an item that the test's server has sent before the trace exists. */
void __wrap_ect_trace_log(ect_trace_t *trace, ect_logged_kind_t kind, uint32_t value, uint64_t time_ns,
                          const char *text, size_t length)
{
    if (trace)
        __real_ect_trace_log(trace, kind, value, time_ns, text, length);
    else
        fprintf(stderr, "log%s: %.*s\n", kind == ECT_LOGGED_MODBUS ? " Modbus" : "", (int)length, text);
}

void __wrap_ect_modbus_server_close(ect_modbus_server_t *one)
{
    if (one)
        fputs("close Modbus\n", stderr);
}

const char *__wrap_ect_modbus_server_address(const ect_modbus_server_t *one)
{
    (void)one;
    return "address:2";
}

int __wrap_ect_rights_drop(unsigned int keep, char *message)
{
    fprintf(stderr, "keep rights %u\n", keep);
    strcpy(message, "rights remain");
    return machine.no_drop ? -1 : 0;
}

int __wrap_ect_rights_realtime(int priority, char *message)
{
    fprintf(stderr, "priority %d\n", priority);
    strcpy(message, "no priority");
    return machine.no_realtime ? -1 : 0;
}

static ect_kernel_t *const kernel = (ect_kernel_t *)(void *)&program;

ect_kernel_t *__wrap_ect_kernel_load(char *message)
{
    fputs("load\n", stderr);
    strcpy(message, "no BPF");
    return machine.no_kernel ? NULL : kernel;
}

int __wrap_ect_kernel_attach(ect_kernel_t *one, unsigned int index, char *message)
{
    fprintf(stderr, "attach %d to %u\n", one == kernel, index);
    strcpy(message, "no hook");
    return machine.no_hook ? -1 : 0;
}

const char *__wrap_ect_kernel_hook(const ect_kernel_t *one)
{
    (void)one;
    return "native";
}

void __wrap_ect_kernel_close(ect_kernel_t *one)
{
    if (one)
        fputs("unload\n", stderr);
}

static ect_control_t *const control = (ect_control_t *)(void *)&machine.lacks;

ect_control_t *__wrap_ect_control_open(const char *name, char *message)
{
    strcpy(message, "no socket");
    errno = name ? EADDRINUSE : EACCES;
    return machine.no_control ? NULL : control;
}

void __wrap_ect_control_describe(ect_control_t *one, const ect_about_t *about)
{
    const char *out = about->ifaces[ECT_END_OUT];
    (void)one;
    fprintf(stderr, "control: %s on %s%s%s\n", about->devices,
            about->ifaces[ECT_END_IN] ? about->ifaces[ECT_END_IN] : "nothing", out ? " and " : "", out ? out : "");
}

void __wrap_ect_control_report(ect_control_t *one, void (*report)(void *ctx, const char *text), void *ctx)
{
    if (one == control)
        report(ctx, "reports");
}

const char *__wrap_ect_control_path(const ect_control_t *one)
{
    (void)one;
    return "path";
}

void __wrap_ect_control_close(ect_control_t *one)
{
    if (one)
        fputs("close control\n", stderr);
}

static const char *port_of(const ect_runner_t *runner, ect_end_t end)
{
    return runner->ports[end] ? runner->ports[end]->iface : "-";
}

void __wrap_ect_pages_make_huge(void *block, size_t size)
{
    huge += block && size > 0;
    huge_heap |= block == heap[0] && size == sizeof heap[0];
}

void *__wrap_sbrk(intptr_t increment)
{
    static unsigned int calls;
    return increment == 0 ? heap[calls++ % 2] : (void *)-1;
}

int __wrap_ect_runner_run(ect_runner_t *runner)
{
    fprintf(stderr, "loop: %s %s%s%s%s%s, pause %u, links %d, hook %s\n", port_of(runner, ECT_END_IN),
            port_of(runner, ECT_END_OUT), runner->udp ? ", UDP" : "", runner->modbus == server ? ", Modbus" : "",
            runner->kernel == kernel ? ", kernel" : "", runner->busy_poll ? ", polls" : "", runner->client_pause_ns,
            runner->link_fd, runner->exchange.stats.hook ? runner->exchange.stats.hook : "-");
    if (huge == 0 || !huge_heap || !runner->exchange.chain || runner->signal_fd < 0 ||
        runner->exchange.control != (machine.no_control ? NULL : control))
        fputs("incomplete\n", stderr);
    if (machine.circulates)
        runner->on_circulating(runner->ctx, "tw0");
    if (machine.refuses)
        runner->exchange.scenario->refused(runner->exchange.scenario->ctx, "a step", "a reason");
    if (machine.signals) {
        (void)runner->on_signal(runner->ctx, SIGINT, true);
        (void)runner->on_signal(runner->ctx, SIGTERM, false);
    }
    errno = EIO;
    if (machine.fails)
        return -1;
    for (unsigned int i = 0; i < 20000 && runner->on_signal(runner->ctx, SIGCHLD, false); i++) {
        if (!runner->on_signal(runner->ctx, SIGHUP, true)) /* the end of `run` */
            return 0;
        usleep(1000);
    }
    return 0;
}

int __wrap_getifaddrs(struct ifaddrs **all)
{
    static struct ifaddrs list[ADDRESSES];
    static struct sockaddr_in6 numbers[ADDRESSES];
    *all = NULL;
    if (machine.no_addresses)
        return -1;
    for (size_t i = ADDRESSES; i-- > 0;) {
        const address_t *one = &machine.addresses[i];
        struct sockaddr_in *in = (struct sockaddr_in *)(void *)&numbers[i];
        if (!one->iface)
            continue;
        list[i] = (struct ifaddrs){.ifa_next = *all, .ifa_name = (char *)(uintptr_t)one->iface};
        *all = &list[i];
        if (!one->text)
            continue;
        list[i].ifa_addr = (struct sockaddr *)in;
        if (inet_pton(AF_INET, one->text, &in->sin_addr) == 1)
            in->sin_family = AF_INET;
        else if (inet_pton(AF_INET6, one->text, &numbers[i].sin6_addr) == 1)
            in->sin_family = AF_INET6;
        else
            in->sin_family = AF_PACKET;
    }
    return 0;
}

void __wrap_freeifaddrs(struct ifaddrs *all)
{
    (void)all;
}

int __wrap_sched_setscheduler(pid_t process, int policy, const struct sched_param *parameters)
{
    fprintf(stderr, "scheduler %d, %d, %d\n", (int)process, policy == (SCHED_BATCH | SCHED_RESET_ON_FORK),
            parameters->sched_priority);
    return 0;
}

int __wrap_ect_netns_enter(const char *const masters[ECT_NETNS_WIRES], unsigned int *lacks, char *message)
{
    fprintf(stderr, "network: %s %s\n", masters[0], masters[1] ? masters[1] : "-");
    *lacks = machine.lacks;
    strcpy(message, "no network");
    return machine.no_network ? -1 : 0;
}

pid_t __wrap_contain_start(void (*run)(const void *ctx), const void *ctx)
{
    errno = EAGAIN;
    const pid_t pid = machine.no_process ? -1 : fork();
    if (pid == 0) {
        run(ctx);
        _exit(99);
    }
    return pid;
}

/* --- runs --------------------------------------------------------------------------------------------------------- */

typedef struct row {
    const char *line;
    machine_t machine;
    int status;
    const char *text;
} row_t;

static void expect(const row_t *rows, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        machine = rows[i].machine;
        command_expect(&(command_line_t){.line = rows[i].line, .status = rows[i].status, .text = rows[i].text}, NULL,
                       0);
    }
}

#define EXPECT(rows) expect(rows, sizeof(rows) / sizeof(rows)[0])
#define RUN          "ectwin run: "
#define CONTROL      "control: fzm1 on tw0\n" RUN "reports\n"
#define LOOP         "loop: tw0 -, pause 50000, links -1, hook -\n"
#define CLOSE        "close control\nclose tw0\n"
#define READY        "{\"event\":\"ready\",\"iface\":\"tw0\",\"slaves\":1}\n"

static void interfaces(void **state)
{
    static const row_t rows[] = {
        {"run -i tw0 fzm1", {0}, 0, "open tw0\n" CONTROL "keep rights 0\n" LOOP CLOSE READY},
        {"run -i tw0 fzm1", {.no_interface = "tw0"}, 2, "open tw0\n" RUN "no interface\n"},
        {"run -i tw0 -o tw1 fzm1",
         {0},
         0,
         "open tw0\nopen tw1\ncontrol: fzm1 on tw0 and tw1\n" RUN
         "reports\nkeep rights 0\nloop: tw0 tw1, pause 50000, links 1000, hook -\nclose control\nclose tw0\nclose "
         "tw1\n{\"event\":\"ready\",\"iface\":\"tw0\",\"iface2\":\"tw1\",\"slaves\":1}\n"},
        {"run -i tw0 -o tw1 fzm1", {.no_interface = "tw1"}, 2, "open tw0\nopen tw1\n" RUN "no interface\nclose tw0\n"},
        {"run -i tw0 -o tw1 fzm1",
         {.no_watch = true},
         2,
         "open tw0\nopen tw1\n" RUN
         "watching the cables of two interfaces failed: Too many open files\nclose tw0\nclose tw1\n"},
        {"run -i tw0 --busy-poll fzm1",
         {0},
         0,
         "open tw0\nshare tw0\n" CONTROL
         "keep rights 0\nloop: tw0 -, polls, pause 50000, links -1, hook -\n" CLOSE READY},
        {"run -i tw0 fzm1", {.was_down = true}, 0, "open tw0\n" CONTROL "keep rights 1\n" LOOP CLOSE READY},
        {"run -i tw0 fzm1",
         {.no_drop = true},
         0,
         "open tw0\n" CONTROL "keep rights 0\n" RUN "rights remain\n" LOOP CLOSE READY},
        {"run -i tw0 --files . fzm1", {0}, 0, "open tw0\n" CONTROL "keep rights 4\n" LOOP CLOSE READY},
        {"run -i tw0 fzm1",
         {.no_control = true},
         0,
         "open tw0\n" RUN "no socket; 'ectwin get' and 'ectwin set' cannot reach this twin\nkeep rights 0\n" LOOP
         "close tw0\n" READY},
        {"run -i tw0 --name a fzm1", {.no_control = true}, 2, "open tw0\n" RUN "no socket\nclose tw0\n"},
        {"run -i tw0 --set data1=x fzm1",
         {0},
         1,
         "open tw0\n" CONTROL RUN "--set: data1 takes -999999999..999999999, not 'x'\n" CLOSE},
        {"run -i tw0 fzm1",
         {.fails = true},
         3,
         "open tw0\n" CONTROL "keep rights 0\n" LOOP RUN "stopped on 'tw0': Input/output error\n" CLOSE READY},
        {"run -i tw0 fzm1",
         {.circulates = true, .refuses = true},
         0,
         "open tw0\n" CONTROL "keep rights 0\n" LOOP RUN
         "a program at the other end of 'tw0' replies to EtherCAT frames too, so frames circulated: end one of the "
         "two; until then such frames are destroyed\n" RUN "'a step' is refused at its time: a reason\n" CLOSE READY},
        {"run -i tw0 --scenario t.csv fzm1",
         {0},
         3,
         "open tw0\n" CONTROL "keep rights 0\n" LOOP RUN
         "line 1: 'at 1s expect data1=0' has failed: the run ended before its milestone\n" RUN
         "0 of 1 expectations are met\n" CLOSE READY},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        command_write_table("at 1s expect data1=0\n");
        expect(&rows[i], 1);
    }
    (void)unlink("t.csv");
}

static void rights(void **state)
{
#define BATCH "scheduler 0, 1, 0\n"
    static const row_t rows[] = {
        {"run -i tw0 --realtime fzm1", {0}, 0, "open tw0\n" CONTROL "priority 50\nkeep rights 0\n" LOOP CLOSE READY},
        {"run -i tw0 --realtime 1 fzm1", {0}, 0, "open tw0\n" CONTROL "priority 1\nkeep rights 0\n" LOOP CLOSE READY},
        {"run -i tw0 --realtime=99 fzm1",
         {.no_realtime = true},
         2,
         "open tw0\n" CONTROL "priority 99\n" RUN "no priority\n" CLOSE},
        {"run -i tw0 --in-kernel fzm1",
         {0},
         0,
         "open tw0\n" CONTROL "load\n" BATCH "attach 1 to 7\nkeep rights 0\nloop: tw0 -, kernel, pause 50000, links "
         "-1, hook native\nclose control\nunload\nclose tw0\n" READY},
        {"run -i tw0 --in-kernel --realtime fzm1",
         {0},
         0,
         "open tw0\n" CONTROL "load\npriority 50\nattach 1 to 7\nkeep rights 0\nloop: tw0 -, kernel, pause 50000, "
         "links -1, hook native\nclose control\nunload\nclose tw0\n" READY},
        {"run -i tw0 --in-kernel fzm1", {.no_kernel = true}, 2, "open tw0\n" CONTROL "load\n" RUN "no BPF\n" CLOSE},
        {"run -i tw0 --in-kernel fzm1",
         {.no_hook = true},
         2,
         "open tw0\n" CONTROL "load\n" BATCH "attach 1 to 7\n" RUN "no hook\nclose control\nunload\nclose tw0\n"},
        {"run -i tw0 -o tw1 --in-kernel fzm1",
         {0},
         2,
         "open tw0\nopen tw1\ncontrol: fzm1 on tw0 and tw1\n" RUN "reports\nload\n" BATCH RUN
         "--in-kernel needs one interface, at the input: leave the option out\nclose control\nunload\nclose tw0\nclose "
         "tw1\n"},
        {"run --modbus 5 --in-kernel vr-bu-ect-map7",
         {0},
         2,
         "Modbus 5\ncontrol: vr-bu-ect-map7 on nothing\n" RUN "reports\nload\n" BATCH RUN
         "--in-kernel needs one interface, at the input: leave the option out\nclose control\nclose Modbus\nunload\n"},
        {"run -i tw0 --in-kernel --busy-poll fzm1",
         {0},
         1,
         "open tw0\nshare tw0\n" CONTROL RUN
         "--in-kernel excludes --udp and --busy-poll: leave one of them out\n" CLOSE},
        {"run -i tw0 --in-kernel --udp 5 fzm1",
         {0},
         1,
         "open tw0\nUDP 5\n" CONTROL RUN "--in-kernel excludes --udp and --busy-poll: leave one of them out\nclose "
         "control\nclose tw0\nclose address:1\n"},
    };
    (void)state;
    EXPECT(rows);
}

static void servers(void **state)
{
#define MAP7 "vr-bu-ect-map7"
    static const row_t rows[] = {
        {"run --udp 5 fzm1",
         {0},
         0,
         "UDP 5\ncontrol: fzm1 on address:1\n" RUN
         "reports\nkeep rights 0\nloop: - -, UDP, pause 50000, links -1, hook -\nclose control\nclose "
         "address:1\n{\"event\":\"ready\",\"udp\":\"address:1\",\"slaves\":1}\n"},
        {"run --udp 5 fzm1",
         {.fails = true},
         3,
         "UDP 5\ncontrol: fzm1 on address:1\n" RUN
         "reports\nkeep rights 0\nloop: - -, UDP, pause 50000, links -1, hook -\n" RUN
         "stopped on 'address:1': Input/output error\nclose control\nclose "
         "address:1\n{\"event\":\"ready\",\"udp\":\"address:1\",\"slaves\":1}\n"},
        {"run --udp 5 fzm1", {.udp_error = EINVAL}, 1, "UDP 5\n" RUN "--udp: no port\n"},
        {"run --udp 5 fzm1", {.udp_error = EADDRINUSE}, 2, "UDP 5\n" RUN "--udp: no port\n"},
        {"run --modbus 5 " MAP7,
         {0},
         0,
         "Modbus 5\ncontrol: " MAP7 " on nothing\n" RUN
         "reports\nkeep rights 0\nloop: - -, Modbus, pause 50000, links -1, hook -\nclose control\nclose "
         "Modbus\n{\"event\":\"ready\",\"modbus\":\"address:2\",\"slaves\":1}\n"},
        {"run --modbus 5 " MAP7,
         {.fails = true},
         3,
         "Modbus 5\ncontrol: " MAP7 " on nothing\n" RUN
         "reports\nkeep rights 0\nloop: - -, Modbus, pause 50000, links -1, hook -\n" RUN
         "stopped on 'address:2': Input/output error\nclose control\nclose "
         "Modbus\n{\"event\":\"ready\",\"modbus\":\"address:2\",\"slaves\":1}\n"},
        {"run --modbus 5 " MAP7, {.modbus_error = EINVAL}, 1, "Modbus 5\n" RUN "--modbus: no port\n"},
        {"run --modbus 5 " MAP7, {.modbus_error = EADDRINUSE}, 2, "Modbus 5\n" RUN "--modbus: no port\n"},
        {"run --modbus 5 --record /dev/null " MAP7,
         {.no_observer = true},
         2,
         "Modbus 5\nlog Modbus: 001FA0 9BFF\n" RUN
         "--modbus: requests cannot be recorded: Too many open files\nclose Modbus\n"},
        {"run --modbus 5 " MAP7 "," MAP7,
         {0},
         1,
         RUN "--modbus: one address serves one device; start another 'ectwin run' for the next one\n"},
        {"run --modbus 5 fzm1",
         {0},
         1,
         RUN "--modbus: this device has no Modbus interface; devices with one: vr-bu-ect-map1, vr-bu-ect-map3, "
             "vr-bu-ect-map7, vr-bu-ect-multiarm\n"},
    };
    (void)state;
    EXPECT(rows);
}

static void hints(void **state)
{
#define NO_LINK RUN "'tw0' has no link: plug the cable in, or bring the other end up\n"
#define ADDRESS(text)                                                                                                  \
    RUN "'tw0' has the address " text                                                                                  \
        ": other traffic shares this wire and delays frames; 'ip addr flush dev tw0' removes it\n"
#define RUNS(hint) 0, "open tw0\n" hint CONTROL "keep rights 0\n" LOOP CLOSE READY
    static const row_t rows[] = {
        {"run -i tw0 fzm1", {.no_link = true}, RUNS(NO_LINK)},
        {"run -i tw0 --quiet fzm1", {.no_link = true, .addresses = {{"tw0", "192.0.2.1"}}}, RUNS("")},
        {"run -i tw0 fzm1", {.addresses = {{"tw0", "192.0.2.1"}}}, RUNS(ADDRESS("192.0.2.1"))},
        {"run -i tw0 fzm1", {.addresses = {{"tw0", "192.0.2.1"}, {"tw0", "192.0.2.2"}}}, RUNS(ADDRESS("192.0.2.1"))},
        {"run -i tw0 fzm1", {.addresses = {{"lo", "192.0.2.1"}, {"tw0", "192.0.2.2"}}}, RUNS(ADDRESS("192.0.2.2"))},
        {"run -i tw0 fzm1", {.addresses = {{"tw0", NULL}, {"tw0", "2001:db8::1"}}}, RUNS(ADDRESS("2001:db8::1"))},
        {"run -i tw0 fzm1", {.addresses = {{"tw0", "fe80::1"}, {"tw0", "packet"}}}, RUNS("")},
        {"run -i tw0 fzm1", {.addresses = {{"tw0", "fe80::1"}, {"tw1", "192.0.2.1"}}}, RUNS("")},
        {"run -i tw0 fzm1", {.no_addresses = true, .addresses = {{"tw0", "192.0.2.1"}}}, RUNS("")},
        {"run -i tw0 fzm1", {.no_link = true, .addresses = {{"tw0", "192.0.2.1"}}}, RUNS(NO_LINK ADDRESS("192.0.2.1"))},
        {"run -i tw0 fzm1",
         {.no_link = true, .was_down = true},
         0,
         "open tw0\n" CONTROL "keep rights 1\n" LOOP CLOSE READY},
    };
    (void)state;
    EXPECT(rows);
}

static void commands(void **state)
{
#define WITH  "ectwin with: "
#define BEGIN "control: fzm1 on ecat0\n" WITH "reports\nnetwork: ecat0 -\n"
#define OPENED                                                                                                         \
    "open ectwin0\n{\"event\":\"ready\",\"iface\":\"ecat0\",\"slaves\":1}\nkeep rights 2\nloop: ectwin0 -, pause "     \
    "50000, links -1, hook -\n"
#define CLOSED  "close control\nclose ectwin0\n"
#define NO_USER WITH "no user namespace can be made on this system, so CMD is root on the whole machine\n"
#define NO_SYS  WITH "/sys cannot be mounted again on this system, so /sys/class/net shows CMD the interfaces outside\n"
#define NOT_PRIVATE                                                                                                    \
    WITH "CMD is not run, because of --require-private: allow user namespaces, or leave the option out\nclose "        \
         "control\n"
    static const row_t rows[] = {
        {"with fzm1 -- true", {0}, 0, BEGIN OPENED CLOSED},
        {"with fzm1 -- sh -c 'exit 9'", {0}, 9, BEGIN OPENED CLOSED},
        {"with fzm1 -- sh -c 'kill -KILL $$'", {0}, 137, BEGIN OPENED CLOSED},
        {"with fzm1 -- sh -c 'echo {} $ECTWIN_IFACE $ECTWIN_SOCKET'", {0}, 0, BEGIN OPENED CLOSED "ecat0 ecat0 path\n"},
        {"with --iface a,b fzm1 -- true",
         {0},
         0,
         "control: fzm1 on a and b\n" WITH "reports\nnetwork: a b\nopen ectwin0\nopen "
         "ectwin1\n{\"event\":\"ready\",\"iface\":\"a\",\"iface2\":\"b\",\"slaves\":1}\nkeep rights 2\nloop: ectwin0 "
         "ectwin1, pause 50000, links 1000, hook -\nclose control\nclose ectwin0\nclose ectwin1\n"},
        {"with fzm1 -- true", {.lacks = ECT_NETNS_USER_NAMESPACE}, 0, BEGIN NO_USER OPENED CLOSED},
        {"with fzm1 -- true", {.lacks = ECT_NETNS_OWN_SYSFS}, 0, BEGIN NO_SYS OPENED CLOSED},
        {"with --quiet fzm1 -- true",
         {.lacks = ECT_NETNS_USER_NAMESPACE | ECT_NETNS_OWN_SYSFS},
         0,
         BEGIN OPENED CLOSED},
        {"with --require-private fzm1 -- true", {0}, 0, BEGIN OPENED CLOSED},
        {"with --require-private fzm1 -- true",
         {.lacks = ECT_NETNS_USER_NAMESPACE | ECT_NETNS_OWN_SYSFS},
         2,
         BEGIN NO_USER NO_SYS NOT_PRIVATE},
        {"with --require-private --quiet fzm1 -- true", {.lacks = ECT_NETNS_OWN_SYSFS}, 2, BEGIN NOT_PRIVATE},
        {"with fzm1 -- true", {.no_network = true}, 2, BEGIN WITH "no network\nclose control\n"},
        {"with fzm1 -- true",
         {.no_interface = "ectwin0"},
         2,
         BEGIN "open ectwin0\n" WITH "no interface\nclose control\n"},
        {"with fzm1 -- true",
         {.no_process = true},
         3,
         BEGIN "open ectwin0\n{\"event\":\"ready\",\"iface\":\"ecat0\",\"slaves\":1}\n" WITH
               "cannot start another process: Resource temporarily unavailable\nkeep rights 2\n" CLOSED},
        {"with fzm1 -- sleep 30",
         {.fails = true},
         3,
         BEGIN OPENED WITH "stopped on 'ectwin0': Input/output error\n" CLOSED},
        {"with fzm1 -- sleep 30", {.signals = true}, 143, BEGIN OPENED CLOSED},
        {"with --leave-children fzm1 -- sh -c 'exit 8'", {.no_process = true}, 8, BEGIN OPENED CLOSED},
        {"with --udp 5 fzm1 -- sh -c 'echo $ECTWIN_UDP'",
         {0},
         0,
         BEGIN
         "open ectwin0\nUDP 5\n{\"event\":\"ready\",\"iface\":\"ecat0\",\"udp\":\"address:1\",\"slaves\":1}\nkeep "
         "rights 2\nloop: ectwin0 -, UDP, pause 50000, links -1, hook -\n" CLOSED "close address:1\naddress:1\n"},
        {"with --modbus 5 vr-bu-ect-map7 -- sh -c 'echo $ECTWIN_MODBUS'",
         {0},
         0,
         "control: vr-bu-ect-map7 on ecat0\n" WITH "reports\nnetwork: ecat0 -\nopen ectwin0\nModbus "
         "5\n{\"event\":\"ready\",\"iface\":\"ecat0\",\"modbus\":\"address:2\",\"slaves\":1}\nkeep rights 2\nloop: "
         "ectwin0 -, Modbus, pause 50000, links -1, hook -\nclose control\nclose Modbus\nclose ectwin0\naddress:2\n"},
        {"with --in-kernel fzm1 -- true",
         {.no_hook = true},
         2,
         "control: fzm1 on ecat0\n" WITH "reports\nload\n" BATCH "network: ecat0 -\nopen ectwin0\nattach 1 to 7\n" WITH
         "no hook\nclose control\nunload\nclose ectwin0\n"},
    };
    (void)state;
    EXPECT(rows);
}

#define TEST(title, function) {title, function, NULL, NULL, NULL}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        TEST("run: interfaces are opened and closed, and each failure ends the run", interfaces),
        TEST("run: real-time priority, and replies in the kernel", rights),
        TEST("run: servers of UDP and Modbus", servers),
        TEST("run: hints about cable and addresses", hints),
        TEST("with: the command runs in the network, and its status is that of ectwin", commands),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Sessions", tests, commands_begin, commands_end);
}
