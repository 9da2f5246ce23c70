/* SPDX-License-Identifier: MIT */
/* The common part of `run` and `with`: twins on one or two interfaces until a signal. */
#define _GNU_SOURCE
#include <errno.h>
#include <sched.h>
#include <signal.h>
#include <string.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include "bus/chain/catalogue.h"
#include "bus/net/rights.h"
#include "bus/pages.h"
#include "commands.h"

/* nohup's SIG_IGN for SIGHUP is kept. A shell's SIG_IGN for SIGINT of background jobs is not: SIGINT ends the run. */
int open_signals(void)
{
    sigset_t set;
    sigemptyset(&set);
    sigaddset(&set, SIGINT);
    sigaddset(&set, SIGTERM);
    if (signal(SIGHUP, SIG_DFL) == SIG_IGN) /* a blocked signal is queued even if ignored */
        signal(SIGHUP, SIG_IGN);
    else
        sigaddset(&set, SIGHUP);
    sigaddset(&set, SIGCHLD);
    signal(SIGINT, SIG_DFL);
    signal(SIGTERM, SIG_DFL);
    signal(SIGCHLD, SIG_DFL); /* with an inherited SIG_IGN, the end of a command would not be reported */
    signal(SIGPIPE, SIG_IGN); /* the end of a reader must not end the twins */
    if (sigprocmask(SIG_BLOCK, &set, NULL) < 0)
        return -1;
    return signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK);
}

static void on_circulating(void *ctx, const char *iface)
{
    const session_t *s = ctx;
    fprintf(stderr,
            "%s: a program at the other end of '%s' replies to EtherCAT frames too, so frames circulated: end one of "
            "the two; "
            "until then such frames are destroyed\n",
            s->who, iface);
}

static void on_refused(void *ctx, const char *step, const char *why)
{
    const session_t *s = ctx;
    fprintf(stderr, "%s: '%s' is refused at its time: %s\n", s->who, step, why);
}

static void on_report(void *ctx, const char *text)
{
    const session_t *s = ctx;
    fprintf(stderr, "%s: %s\n", s->who, text);
}

static void on_judged(void *ctx, const ect_scenario_step_t *step)
{
    const session_t *s = ctx;
    char text[ECT_STEP_LINE + ECT_STEP_MESSAGE + 64];
    (void)ect_scenario_print(step, text, sizeof text);
    fprintf(stderr, "%s: %s\n", s->who, text);
}

static bool on_signal(void *ctx, int signal_number, bool from_terminal)
{
    const session_t *s = ctx;
    return s->on_signal(s->ctx, signal_number, from_terminal);
}

void session_init(session_t *s, const char *who, twin_args_t *twins)
{
    *s = (session_t){.who = who, .twins = twins};
    twins->eoe.has_hosts = true;
    twins->scenario.refused = on_refused;
    twins->scenario.judged = on_judged;
    twins->scenario.ctx = s;
    s->runner =
        (ect_runner_t){.exchange = {.scenario = &twins->scenario, .filter = twins->filter.ctx ? &twins->filter : NULL},
                       .signal_fd = -1,
                       .busy_poll = twins->busy_poll,
                       .link_fd = -1,
                       .on_signal = on_signal,
                       .on_circulating = on_circulating,
                       .ctx = s};
}

int session_open(session_t *s, const char *const ifaces[ECT_ENDS])
{
    char message[ECT_PACKET_MESSAGE];
    for (unsigned int end = 0; end < ECT_ENDS; end++) {
        if (!ifaces[end])
            continue;
        if (ect_packet_open(&s->ports[end], ifaces[end], message) < 0) {
            fprintf(stderr, "%s: %s\n", s->who, message);
            return EXIT_OPEN;
        }
        if (s->runner.busy_poll)
            (void)ect_packet_share(&s->ports[end]); /* on failure each poll is a system call */
        s->runner.ports[end] = &s->ports[end];
    }
    if (!ifaces[ECT_END_OUT])
        return EXIT_CLEAN;
    s->runner.link_fd = ect_packet_watch_links();
    if (s->runner.link_fd >= 0)
        return EXIT_CLEAN;
    fprintf(stderr, "%s: watching the cables of two interfaces failed: %s\n", s->who, strerror(errno));
    return EXIT_OPEN;
}

int session_open_udp(session_t *s)
{
    char message[ECT_PACKET_MESSAGE];
    if (!s->twins->udp)
        return EXIT_CLEAN;
    if (ect_udp_open(&s->udp, s->twins->udp, message) == 0) {
        s->runner.udp = &s->udp;
        return EXIT_CLEAN;
    }
    int status = errno == EINVAL ? EXIT_USAGE : EXIT_OPEN;
    fprintf(stderr, "%s: --udp: %s\n", s->who, message);
    return status;
}

const char *session_udp(const session_t *s)
{
    return s->runner.udp ? s->udp.address : NULL;
}

static void list_modbus_devices(const char *who)
{
    const char *before = "; devices with one: ";
    fprintf(stderr, "%s: --modbus: this device has no Modbus interface", who);
    const ect_product_t *product;
    for (size_t i = 0; (product = ect_catalogue_at(i)) != NULL; i++) {
        if (!product->plant || !product->plant->modbus)
            continue;
        fprintf(stderr, "%s%s", before, product->device->name);
        before = ", ";
    }
    fprintf(stderr, "\n");
}

static char *write_hexadecimal(char *to, const uint8_t *bytes, size_t length)
{
    static const char digits[] = "0123456789ABCDEF";
    for (size_t i = 0; i < length; i++) {
        *to++ = digits[bytes[i] >> 4];
        *to++ = digits[bytes[i] & 15];
    }
    return to;
}

static void log_modbus(void *ctx, const uint8_t *request, size_t length, const uint8_t *reply, size_t reply_length)
{
    const session_t *s = ctx;
    char text[4 * ECT_MODBUS_ADU + 1];
    char *end = write_hexadecimal(text, request, length);
    *end++ = ' ';
    end = write_hexadecimal(end, reply, reply_length);
    ect_trace_log(s->runner.exchange.trace, ECT_LOGGED_MODBUS, 0, 0, text, (size_t)(end - text));
}

int session_open_modbus(session_t *s)
{
    char message[ECT_MODBUS_MESSAGE];
    const twin_args_t *twins = s->twins;
    if (!twins->modbus)
        return EXIT_CLEAN;
    if (twins->count != 1) {
        fprintf(stderr, "%s: --modbus: one address serves one device; start another 'ectwin run' for the next one\n",
                s->who);
        return EXIT_USAGE;
    }
    if (!twins->twins[0].plant || !twins->twins[0].plant->modbus) {
        list_modbus_devices(s->who);
        return EXIT_USAGE;
    }
    s->runner.modbus = ect_modbus_server_open(twins->modbus, message);
    if (s->runner.modbus && (!twins->record || ect_modbus_server_observe(s->runner.modbus, log_modbus, s)))
        return EXIT_CLEAN;
    if (s->runner.modbus)
        snprintf(message, sizeof message, "requests cannot be recorded: %s", strerror(errno));
    int status = errno == EINVAL ? EXIT_USAGE : EXIT_OPEN;
    fprintf(stderr, "%s: --modbus: %s\n", s->who, message);
    return status;
}

int session_open_hosts(session_t *s)
{
    char message[EOE_MESSAGE];
    if (eoe_args_open(&s->twins->eoe, s->who, s->twins->quiet, &s->runner.hosts, message))
        return EXIT_CLEAN;
    fprintf(stderr, "%s: %s\n", s->who, message);
    return EXIT_OPEN;
}

int session_open_control(session_t *s, char *const ifaces[ECT_ENDS])
{
    for (unsigned int end = 0; end < ECT_ENDS; end++)
        s->twins->about.ifaces[end] = ifaces[end];
    if (!ifaces[ECT_END_IN])
        s->twins->about.ifaces[ECT_END_IN] = session_udp(s);
    s->runner.client_pause_ns = ECT_RUNNER_REST_NS;
    twin_args_describe(s->twins);
    const int status = open_control(s->who, &s->twins->about, &s->runner.exchange.control);
    if (s->runner.exchange.control)
        ect_control_report(s->runner.exchange.control, on_report, s);
    return status;
}

const char *session_modbus(const session_t *s)
{
    return s->runner.modbus ? ect_modbus_server_address(s->runner.modbus) : NULL;
}

/* A process of the ordinary class that a frame wakes would preempt the master that has sent the frame. */
static void let_the_master_run(void)
{
    const struct sched_param parameters = {0};
    (void)sched_setscheduler(0, SCHED_BATCH | SCHED_RESET_ON_FORK, &parameters);
}

static int run_before_others(const session_t *s)
{
    char message[ECT_RIGHTS_MESSAGE];
    if (s->twins->realtime == 0 && s->twins->in_kernel)
        let_the_master_run();
    if (s->twins->realtime == 0 || ect_rights_realtime(s->twins->realtime, message) == 0)
        return EXIT_CLEAN;
    fprintf(stderr, "%s: %s\n", s->who, message);
    return EXIT_OPEN;
}

static int load_into_kernel(session_t *s)
{
    char message[ECT_KERNEL_MESSAGE];
    if (!s->twins->in_kernel)
        return EXIT_CLEAN;
    if (s->twins->udp || s->twins->busy_poll) {
        fprintf(stderr, "%s: --in-kernel excludes --udp and --busy-poll: leave one of them out\n", s->who);
        return EXIT_USAGE;
    }
    s->runner.kernel = ect_kernel_load(message);
    if (s->runner.kernel)
        return EXIT_CLEAN;
    fprintf(stderr, "%s: %s\n", s->who, message);
    return EXIT_OPEN;
}

int session_attach(session_t *s)
{
    char message[ECT_KERNEL_MESSAGE];
    if (!s->runner.kernel)
        return EXIT_CLEAN;
    if (!s->runner.ports[ECT_END_IN] || s->runner.ports[ECT_END_OUT]) {
        snprintf(message, sizeof message, "--in-kernel needs one interface, at the input: leave the option out");
    } else if (ect_kernel_attach(s->runner.kernel, s->ports[ECT_END_IN].index, message) == 0) {
        s->runner.exchange.stats.hook = ect_kernel_hook(s->runner.kernel);
        return EXIT_CLEAN;
    }
    fprintf(stderr, "%s: %s\n", s->who, message);
    return EXIT_OPEN;
}

void session_drop_rights(session_t *s, bool children)
{
    char message[ECT_RIGHTS_MESSAGE];
    unsigned int keep = (children ? ECT_RIGHTS_CHILDREN : 0u) | (s->twins->files ? ECT_RIGHTS_FILES : 0u);
    for (unsigned int end = 0; end < ECT_ENDS; end++)
        keep |= s->ports[end].was_down ? ECT_RIGHTS_LINK : 0;
    if (ect_rights_drop(keep, message) < 0)
        fprintf(stderr, "%s: %s\n", s->who, message);
}

static void make_huge(void *ctx, void *at, size_t size)
{
    (void)ctx;
    ect_pages_make_huge(at, size);
}

/* @param heap  end of the heap before the twins: malloc() has taken their smaller blocks behind it */
static void make_twins_huge(const ect_chain_t *chain, const uint8_t *heap)
{
    const uint8_t *end = sbrk(0);
    ect_chain_memory(chain, make_huge, NULL);
    if (end > heap)
        ect_pages_make_huge((void *)(uintptr_t)heap, (size_t)(end - heap));
}

int session_power_on(session_t *s)
{
    const uint8_t *heap = sbrk(0);
    int status = twin_args_power_on(s->twins, s->who, ect_packet_now(), &s->runner.exchange.chain);
    if (status != EXIT_CLEAN)
        return status;
    make_twins_huge(s->runner.exchange.chain, heap);
    status = twin_args_trace(s->twins, s->who, &s->runner.exchange.trace);
    if (status == EXIT_CLEAN)
        status = load_into_kernel(s);
    return status == EXIT_CLEAN ? run_before_others(s) : status;
}

int session_run(session_t *s, bool (*on_end)(void *ctx, int signal_number, bool from_terminal), void *ctx)
{
    s->on_signal = on_end;
    s->ctx = ctx;
    if (s->runner.exchange.trace)
        ect_trace_start(s->runner.exchange.trace);
    if (s->runner.signal_fd >= 0 && ect_runner_run(&s->runner) == 0)
        return EXIT_CLEAN;
    const int error = errno;
    const char *at = s->runner.ports[ECT_END_IN] ? s->ports[ECT_END_IN].iface : session_udp(s);
    fprintf(stderr, "%s: stopped on '%s': %s\n", s->who, at ? at : session_modbus(s), strerror(error));
    return EXIT_RUN;
}

int session_verdict(session_t *s, int status)
{
    char text[ECT_SCENARIO_NAME + 64];
    if (s->twins->scenario.verdict.all == 0)
        return status;
    ect_verdict_t verdict = ect_scenario_end(&s->twins->scenario);
    (void)ect_scenario_print_verdict(&s->twins->scenario, text, sizeof text);
    fprintf(stderr, "%s: %s\n", s->who, text);
    return status == EXIT_CLEAN && verdict.met != verdict.all ? EXIT_RUN : status;
}

void session_close(session_t *s)
{
    ect_control_close(s->runner.exchange.control);
    (void)twin_args_end_trace(s->twins, s->who, s->runner.exchange.trace, ect_packet_now());
    ect_modbus_server_close(s->runner.modbus);
    ect_hosts_close(s->runner.hosts);
    ect_kernel_close(s->runner.kernel);
    ect_chain_free(s->runner.exchange.chain);
    for (unsigned int end = 0; end < ECT_ENDS; end++) {
        if (s->runner.ports[end])
            ect_packet_close(s->runner.ports[end]);
    }
    if (s->runner.udp)
        ect_udp_close(s->runner.udp);
    if (s->runner.link_fd >= 0)
        close(s->runner.link_fd);
    if (s->runner.signal_fd >= 0)
        close(s->runner.signal_fd);
    twin_args_free(s->twins);
}
