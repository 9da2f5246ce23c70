/* SPDX-License-Identifier: MIT */
/* The bus of bus/library.h, placed here because the command parses the words that describe twins. */
#define _GNU_SOURCE
#include "bus/library.h"

#include <cjson/cJSON.h>
#include <errno.h>
#include <poll.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "bus/chain/settings.h"
#include "bus/exchange.h"
#include "commands.h"
#include "products.h"
#include "run_options.h"
#include "twin_storage.h"

_Static_assert((int)ECTWIN_FRAME_MAX <= (int)ECT_EXCHANGE_FRAME, "the exchange takes every frame");
_Static_assert((int)TWIN_MESSAGE == (int)ECTWIN_MESSAGE, "a reason fits");

typedef struct reply {
    struct reply *next;
    ect_end_t end;
    size_t length;
    uint8_t frame[];
} reply_t;

struct ectwin_bus {
    twin_args_t twins;
    char message[TWIN_MESSAGE];
    char **words;     /* options point into them */
    with_words_t run; /* the parsed words */
    ect_exchange_t exchange;
    uint64_t now_ns;
    reply_t *first, **last;
};

const char *ectwin_version(void)
{
    return ECTWIN_VERSION;
}

/* Time never goes back. */
static void advance(ectwin_bus_t *bus, uint64_t now_ns)
{
    bus->now_ns = now_ns > bus->now_ns ? now_ns : bus->now_ns;
}

static uint64_t present(void *ctx)
{
    const ectwin_bus_t *bus = ctx;
    return bus->now_ns;
}

/* A reply without memory is a lost frame. */
static void queue(void *ctx, ect_end_t end, const uint8_t *frame, size_t length)
{
    ectwin_bus_t *bus = ctx;
    reply_t *reply = malloc(sizeof *reply + length);
    if (!reply)
        return;
    reply->next = NULL;
    reply->end = end;
    reply->length = length;
    memcpy(reply->frame, frame, length);
    *bus->last = reply;
    bus->last = &reply->next;
}

/* The parsers of options end the program by argp_error(), argp_failure() or exit(). In the library the linker replaces
 * these functions by the following ones, which return to ectwin_bus_open. */
static _Thread_local struct {
    jmp_buf back;
    char *message; /* TWIN_MESSAGE bytes; NULL: no parser is running */
} parsing;

void __real_exit(int status) __attribute__((noreturn));
void __wrap_exit(int status) __attribute__((noreturn));
void __wrap_argp_error(const struct argp_state *state, const char *format, ...) __attribute__((format(printf, 2, 3)));
void __wrap_argp_failure(const struct argp_state *state, int status, int number, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

void __wrap_exit(int status)
{
    if (!parsing.message)
        __real_exit(status);
    snprintf(parsing.message, TWIN_MESSAGE, "a list of names is no bus: the command prints it");
    longjmp(parsing.back, 1);
}

void __wrap_argp_error(const struct argp_state *state, const char *format, ...)
{
    va_list values;
    (void)state;
    va_start(values, format);
    vsnprintf(parsing.message, TWIN_MESSAGE, format, values);
    va_end(values);
    longjmp(parsing.back, 1);
}

void __wrap_argp_failure(const struct argp_state *state, int status, int number, const char *format, ...)
{
    va_list values;
    (void)state;
    (void)status;
    va_start(values, format);
    vsnprintf(parsing.message, TWIN_MESSAGE, format, values);
    va_end(values);
    size_t used = strlen(parsing.message);
    if (number != 0)
        snprintf(parsing.message + used, TWIN_MESSAGE - used, ": %s", strerror(number));
    longjmp(parsing.back, 1);
}

/* The words may be a whole command line of `ectwin with`. */
static error_t parse(int key, char *text, struct argp_state *state)
{
    ectwin_bus_t *bus = state->input;
    (void)text;
    switch (key) {
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &bus->run;
        return 0;
    case ARGP_KEY_ERROR:
        snprintf(bus->message, sizeof bus->message, "'%s' is no option of a bus, or lacks its value",
                 state->argv[state->next - 1]);
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static bool copy_words(ectwin_bus_t *bus, int count, const char *const words[])
{
    static char name[] = "ectwin";
    char **copy = calloc((size_t)count + 2, sizeof *copy);
    if (!copy)
        return false;
    bus->words = copy;
    copy[0] = name;
    for (int i = 0; i < count; i++) {
        copy[i + 1] = strdup(words[i]);
        if (!copy[i + 1])
            return false;
    }
    return true;
}

static bool read_words(ectwin_bus_t *bus, int count)
{
    static const struct argp_child children[] = {{&with_words_argp, 0, NULL, 0}, {0}};
    static const struct argp argp = {.parser = parse, .children = children};
    bus->run.twins = &bus->twins;
    parsing.message = bus->message;
    if (setjmp(parsing.back) == 0) {
        const unsigned int flags = ARGP_IN_ORDER | ARGP_NO_EXIT | ARGP_NO_ERRS | ARGP_NO_HELP;
        if (argp_parse(&argp, count + 1, bus->words, flags, NULL, bus) == 0)
            parsing.message = NULL;
    }
    bool done = parsing.message == NULL;
    parsing.message = NULL;
    return done;
}

static void free_bus(ectwin_bus_t *bus)
{
    twin_args_free(&bus->twins);
    for (char **word = bus->words ? bus->words + 1 : NULL; word && *word; word++)
        free(*word);
    free(bus->words);
    free(bus);
}

/* Only in a process of `ectwin with --in-process` do the interfaces have names. */
static int open_trace(ectwin_bus_t *bus)
{
    twin_args_t *twins = &bus->twins;
    twins->in_process = bus->run.in_process;
    twins->own_clock = bus->run.virtual_time || !twins->in_process;
    twins->about.ifaces[ECT_END_IN] = twins->in_process ? getenv("ECTWIN_IFACE") : NULL;
    twins->about.ifaces[ECT_END_OUT] = twins->in_process ? getenv("ECTWIN_IFACE2") : NULL;
    twins->words = bus->words + 1;
    while (twins->words[twins->word_count])
        twins->word_count++;
    if (twins->own_clock)
        twin_storage_wait(twins);
    int status = twin_args_trace(twins, "ectwin", &bus->exchange.trace);
    if (status != EXIT_CLEAN)
        ect_chain_free(bus->exchange.chain);
    return status;
}

static ectwin_bus_t *power_on(int count, const char *const words[], uint64_t now_ns, char *message)
{
    static const char no_memory[] = "not enough memory for a bus";
    ectwin_bus_t *bus = calloc(1, sizeof *bus);
    memcpy(message, no_memory, sizeof no_memory);
    if (!bus)
        return NULL;
    product_quiet();
    memcpy(bus->message, no_memory, sizeof no_memory);
    bus->twins.message = bus->message;
    if (copy_words(bus, count, words) && read_words(bus, count) &&
        twin_args_power_on(&bus->twins, "ectwin", now_ns, &bus->exchange.chain) == EXIT_CLEAN &&
        open_trace(bus) == EXIT_CLEAN)
        return bus;
    memcpy(message, bus->message, sizeof bus->message);
    free_bus(bus);
    return NULL;
}

static void on_refused(void *ctx, const char *step, const char *why)
{
    (void)ctx;
    fprintf(stderr, "ectwin: '%s' is refused at its time: %s\n", step, why);
}

ectwin_bus_t *ectwin_bus_open(int count, const char *const words[], uint64_t now_ns, char *message)
{
    char unwanted[ECTWIN_MESSAGE];
    ectwin_bus_t *bus = power_on(count, words, now_ns, message ? message : unwanted);
    if (!bus)
        return NULL;
    bus->now_ns = now_ns;
    bus->last = &bus->first;
    bus->exchange.scenario = &bus->twins.scenario;
    bus->twins.scenario.refused = on_refused;
    bus->exchange.filter = bus->twins.filter.ctx ? &bus->twins.filter : NULL;
    bus->exchange.send = queue;
    bus->exchange.clock = present;
    bus->exchange.ctx = bus;
    ect_exchange_start(&bus->exchange);
    ect_exchange_link(&bus->exchange, ECT_END_IN, true);
    return bus;
}

static void forget_replies(ectwin_bus_t *bus)
{
    while (bus->first) {
        reply_t *next = bus->first->next;
        free(bus->first);
        bus->first = next;
    }
    bus->last = &bus->first;
}

/* Finishes a save under way, within two seconds of bus time, which pass without the disk. */
static void finish(ectwin_bus_t *bus)
{
    enum { STEP_NS = 1000000, STEPS = 2000 };
    twin_storage_wait(&bus->twins);
    for (unsigned int i = 0; i < STEPS && ect_chain_unfinished(bus->exchange.chain); i++) {
        bus->now_ns += STEP_NS;
        (void)ect_exchange_run(&bus->exchange);
    }
}

void ectwin_bus_close(ectwin_bus_t *bus)
{
    if (!bus)
        return;
    finish(bus);
    ect_exchange_end(&bus->exchange);
    forget_replies(bus);
    if (bus->exchange.control)
        ect_control_close(bus->exchange.control);
    (void)twin_args_end_trace(&bus->twins, "ectwin", bus->exchange.trace, bus->now_ns);
    ect_chain_free(bus->exchange.chain);
    free_bus(bus);
}

void ectwin_bus_power_cycle(ectwin_bus_t *bus, uint64_t now_ns)
{
    advance(bus, now_ns);
    finish(bus);
    forget_replies(bus);
    ect_exchange_power_cycle(&bus->exchange);
    (void)ect_exchange_run(&bus->exchange);
}

size_t ectwin_bus_slaves(const ectwin_bus_t *bus)
{
    return ect_chain_count(bus->exchange.chain);
}

void ectwin_bus_link(ectwin_bus_t *bus, unsigned int end, int link, uint64_t now_ns)
{
    if (end >= ECT_ENDS)
        return;
    advance(bus, now_ns);
    (void)ect_exchange_touch(&bus->exchange);
    ect_exchange_link(&bus->exchange, (ect_end_t)end, link != 0);
    (void)ect_exchange_run(&bus->exchange);
}

uint64_t ectwin_bus_frame(ectwin_bus_t *bus, unsigned int end, const void *frame, size_t length, uint64_t now_ns)
{
    uint8_t copy[ECTWIN_FRAME_MAX];
    if (end >= ECT_ENDS || length == 0 || length > sizeof copy)
        return ect_exchange_run(&bus->exchange);
    advance(bus, now_ns);
    memcpy(copy, frame, length);
    const ect_packet_time_t time = {.now_ns = bus->now_ns};
    bus->exchange.stats.frames++;
    ect_exchange_frame(&bus->exchange, (ect_end_t)end, copy, length, &time);
    return ect_exchange_run(&bus->exchange);
}

size_t ectwin_bus_reply(ectwin_bus_t *bus, unsigned int *end, void *frame, size_t room)
{
    reply_t *reply = bus->first;
    if (!reply)
        return 0;
    size_t length = reply->length;
    *end = (unsigned int)reply->end;
    memcpy(frame, reply->frame, length < room ? length : room);
    bus->first = reply->next;
    if (!bus->first)
        bus->last = &bus->first;
    free(reply);
    return length;
}

uint64_t ectwin_bus_run(ectwin_bus_t *bus, uint64_t now_ns)
{
    advance(bus, now_ns);
    return ect_exchange_run(&bus->exchange);
}

int ectwin_bus_get(const ectwin_bus_t *bus, size_t slave, const char *name, char *text, size_t room)
{
    ect_signal_ref_t ref;
    char value[ECT_SIGNAL_TEXT_ROOM];
    if (slave < 1 || slave > ectwin_bus_slaves(bus) || !ect_chain_signal(bus->exchange.chain, slave - 1, name, &ref))
        return -1;
    ect_signal_read(&ref, value);
    size_t length = strlen(value);
    if (length >= room)
        return -1;
    memcpy(text, value, length + 1);
    return 0;
}

static void note_request(ectwin_bus_t *bus, cJSON *request)
{
    char *line = cJSON_PrintUnformatted(request);
    if (line)
        ect_exchange_request(&bus->exchange, line, strlen(line));
    cJSON_free(line);
    cJSON_Delete(request);
}

/* Logs a change as the equivalent request of the control protocol. */
static void note_set(ectwin_bus_t *bus, size_t slave, const char *name, const char *value)
{
    if (!bus->exchange.trace)
        return;
    cJSON *request = cJSON_CreateObject();
    cJSON_AddStringToObject(request, "op", "set");
    cJSON_AddNumberToObject(request, "slave", (double)slave);
    cJSON_AddStringToObject(request, "name", name);
    cJSON_AddStringToObject(request, "value", value);
    note_request(bus, request);
}

static void note_fault(ectwin_bus_t *bus, const char *fault)
{
    if (!bus->exchange.trace)
        return;
    cJSON *request = cJSON_CreateObject();
    cJSON_AddStringToObject(request, "op", "fault");
    cJSON_AddStringToObject(request, "fault", fault);
    note_request(bus, request);
}

int ectwin_bus_set(ectwin_bus_t *bus, size_t slave, const char *name, const char *value, uint64_t now_ns, char *message,
                   size_t room)
{
    char why[ECT_SIGNAL_MESSAGE] = "there is no such slave";
    const ect_setting_t setting = {.name = name, .value = value};
    advance(bus, now_ns);
    (void)ect_exchange_touch(&bus->exchange);
    note_set(bus, slave, name, value);
    bool done = slave >= 1 && slave <= ectwin_bus_slaves(bus) &&
                ect_settings_apply(bus->exchange.chain, slave - 1, &setting, 1, bus->now_ns, why);
    (void)ect_exchange_run(&bus->exchange);
    if (!done && room > 0)
        snprintf(message, room, "%s", why);
    return done ? 0 : -1;
}

int ectwin_bus_fault(ectwin_bus_t *bus, const char *fault, uint64_t now_ns, char *message, size_t room)
{
    char why[ECT_FAULT_MESSAGE] = "";
    ect_fault_t read;
    advance(bus, now_ns);
    (void)ect_exchange_touch(&bus->exchange);
    note_fault(bus, fault);
    bool done = ect_fault_parse_named(fault, ect_chain_names(bus->exchange.chain), &read, why) &&
                ect_scenario_set(bus->exchange.scenario, bus->exchange.chain, &read, bus->now_ns, why);
    (void)ect_exchange_run(&bus->exchange);
    if (!done && room > 0)
        snprintf(message, room, "%s", why);
    return done ? 0 : -1;
}

int ectwin_bus_verdict(ectwin_bus_t *bus, char *text, size_t room)
{
    const ect_scenario_t *s = bus->exchange.scenario;
    char line[ECT_STEP_LINE + ECT_STEP_MESSAGE + 64];
    size_t used = 0;
    ect_verdict_t verdict = ect_scenario_end(bus->exchange.scenario);
    if (room > 0)
        *text = 0;
    for (size_t i = 0; verdict.all > 0 && i <= s->step_count; i++) {
        if (i < s->step_count && s->steps[i].plan.action != ECT_ACTION_EXPECT)
            continue;
        if (i < s->step_count)
            (void)ect_scenario_print(&s->steps[i], line, sizeof line);
        else
            (void)ect_scenario_print_verdict(s, line, sizeof line);
        int length = used < room ? snprintf(text + used, room - used, "%s\n", line) : 0;
        used += (size_t)length;
    }
    return (int)(verdict.all - verdict.met);
}

/* Each process of CMD has a bus of its own; the name goes to the first bus. */
static bool name_is_free(const char *name)
{
    char path[ECT_ENDPOINT_PATH];
    uid_t owner;
    int fd = name && ect_endpoint_find(name, path) == 0 ? ect_endpoint_connect(path, &owner) : -1;
    if (fd >= 0)
        close(fd);
    return fd < 0;
}

static void on_report(void *ctx, const char *text)
{
    (void)ctx;
    fprintf(stderr, "ectwin: %s\n", text);
}

/* On a virtual clock, plants may stop the clock, and the bus begins with the plant of --plant. */
static void prepare_plants(ectwin_bus_t *bus)
{
    ect_control_t *control = bus->exchange.control;
    ect_control_report(control, on_report, NULL);
    if (!bus->twins.own_clock)
        return;
    ect_control_let_wait(control);
    if (bus->run.plant && !ect_control_await_plant(control, bus->exchange.chain, bus->run.plant, bus->now_ns))
        fprintf(stderr,
                "ectwin: no plant '%s' has come within 20 s: start it beside ectwin; the bus begins without it\n",
                bus->run.plant);
    (void)ect_exchange_run(&bus->exchange);
}

int ectwin_bus_control(ectwin_bus_t *bus)
{
    if (!bus->exchange.control) {
        ect_about_t *about = &bus->twins.about;
        about->ifaces[ECT_END_IN] = getenv("ECTWIN_IFACE");
        about->ifaces[ECT_END_OUT] = getenv("ECTWIN_IFACE2");
        about->name = name_is_free(about->name) ? about->name : NULL;
        if (!about->words)
            twin_args_describe(&bus->twins);
        (void)open_control("ectwin", about, &bus->exchange.control);
        if (bus->exchange.control) {
            ect_exchange_show(&bus->exchange);
            prepare_plants(bus);
        }
    }
    return bus->exchange.control ? ect_control_fd(bus->exchange.control) : -1;
}

const char *ectwin_bus_control_path(const ectwin_bus_t *bus)
{
    return bus->exchange.control ? ect_control_path(bus->exchange.control) : NULL;
}

int ectwin_bus_serve(ectwin_bus_t *bus, uint64_t now_ns)
{
    ect_control_t *control = bus->exchange.control;
    if (!control)
        return 0;
    struct pollfd fd = {.fd = ect_control_fd(control), .events = POLLIN};
    advance(bus, now_ns);
    if (ect_control_due(control) != 0 && poll(&fd, 1, 0) <= 0)
        return 0;
    ect_control_serve(control, bus->exchange.chain, ect_exchange_touch(&bus->exchange));
    (void)ect_exchange_run(&bus->exchange);
    return 1;
}
