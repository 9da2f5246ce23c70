/* SPDX-License-Identifier: MIT */
/* `ectwin stats`: counters of a running twin: frames, reply times, late replies. */
#include <argp.h>
#include <stdlib.h>
#include <string.h>

#include "commands.h"
#include "connection.h"

typedef struct stats_args {
    connection_choice_t twin;
    bool json;
} stats_args_t;

static error_t parse(int key, char *text, struct argp_state *state)
{
    stats_args_t *args = state->input;
    (void)text;
    switch (key) {
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &args->twin;
        return 0;
    case 'j':
        args->json = true;
        return 0;
    case ARGP_KEY_ARG:
        argp_error(state, "it takes no argument");
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static double number(const cJSON *line, const char *name)
{
    const cJSON *member = cJSON_GetObjectItemCaseSensitive(line, name);
    return cJSON_IsNumber(member) ? member->valuedouble : 0;
}

static void print_scenario(const cJSON *line)
{
    if (number(line, "steps") > 0)
        printf("scenario: %.0f of %.0f steps are over; of %.0f expectations %.0f are met, %.0f have failed\n",
               number(line, "steps_over"), number(line, "steps"), number(line, "expected"), number(line, "met"),
               number(line, "failed"));
}

static void print_kernel(const cJSON *line)
{
    const char *hook = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(line, "hook"));
    if (hook)
        printf(
            "in the kernel, %s XDP: plans for %.0f recurring frames; replies: half within %.0f us, 99 %% within %.0f "
            "us, the longest %.0f us\n",
            hook, number(line, "plans"), number(line, "kernel_p50_us"), number(line, "kernel_p99_us"),
            number(line, "kernel_longest_us"));
}

static void print_counters(const cJSON *line)
{
    static const struct {
        const char *name, *meaning;
    } counters[] = {
        {"frames", "received"},
        {"answered", "sent back, or out at the other end"},
        {"in_kernel", "of these in the kernel, by --in-kernel"},
        {"unanswered", "no EtherCAT, malformed, or without a way back"},
        {"queue_lost", "lost in the queue of the interface, which was full"},
        {"stale", "discarded, too old: this machine was busy"},
        {"circling", "replies that another program replied to"},
        {"dropped", "lost by a fault"},
        {"delayed", "delayed by a fault, not in the times below"},
        {"captured", "frames in the capture of --pcap"},
        {"uncaptured", "frames missing in the capture: the disk was too slow, or is full"},
    };
    printf("in %.1f s:\n", number(line, "time"));
    for (size_t i = 0; i < sizeof counters / sizeof counters[0]; i++)
        printf("%12.0f  %-10s  %s\n", number(line, counters[i].name), counters[i].name, counters[i].meaning);
    printf("%12.0f  %-10s  runs of the devices, %.0f of them more than 1 ms late, the latest by %.0f us\n",
           number(line, "polls"), "polls", number(line, "late_polls"), number(line, "latest_poll_us"));
    printf("answers, from the arrival of a frame: half below %.0f us, 99 %% below %.0f us, the longest %.0f us\n",
           number(line, "p50_us"), number(line, "p99_us"), number(line, "longest_us"));
    print_kernel(line);
    print_scenario(line);
}

/* One bar for each step, from the first to the last non-empty one. */
static void print_histogram(const cJSON *answers, const cJSON *edges)
{
    enum { WIDTH = 50 };
    int first = -1;
    int last = -1;
    double most = 1;
    for (int i = 0; i < cJSON_GetArraySize(answers); i++) {
        double count = cJSON_GetArrayItem(answers, i)->valuedouble;
        first = first < 0 && count > 0 ? i : first;
        last = count > 0 ? i : last;
        most = count > most ? count : most;
    }
    for (int i = first; i >= 0 && i <= last; i++) {
        double count = cJSON_GetArrayItem(answers, i)->valuedouble;
        const cJSON *edge = cJSON_GetArrayItem(edges, i);
        char bar[WIDTH + 1] = "";
        memset(bar, '#', (size_t)(count / most * (double)WIDTH));
        if (edge)
            printf("   < %7.0f us %12.0f  %s\n", edge->valuedouble, count, bar);
        else
            printf("       longer %13.0f  %s\n", count, bar);
    }
}

static void print_histograms(const cJSON *line, const cJSON *answers)
{
    const cJSON *edges = cJSON_GetObjectItemCaseSensitive(line, "edges_us");
    const cJSON *in_kernel = cJSON_GetObjectItemCaseSensitive(line, "kernel_answers");
    if (in_kernel)
        printf("answers by the twins' process:\n");
    print_histogram(answers, edges);
    if (in_kernel)
        printf("answers in the kernel:\n");
    print_histogram(in_kernel, edges);
}

static void print_plant(const cJSON *line, const char *name)
{
    printf(
        "plant '%s', every %.0f us%s: %.0f steps, %.0f periods late, %.0f replies refused; replies: half within %.0f "
        "us, 99 %% within %.0f us, the longest after %.0f us\n",
        name, number(line, "period_us"),
        cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(line, "connected")) ? "" : ", has ended", number(line, "steps"),
        number(line, "late"), number(line, "refused"), number(line, "p50_us"), number(line, "p99_us"),
        number(line, "longest_us"));
}

static void print_stats(const cJSON *line)
{
    const char *plant = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(line, "plant"));
    const cJSON *answers = cJSON_GetObjectItemCaseSensitive(line, "answers");
    if (plant)
        print_plant(line, plant);
    else if (cJSON_IsArray(answers))
        print_histograms(line, answers);
    else
        print_counters(line);
}

int command_stats(int argc, char **argv)
{
    static const struct argp_option options[] = {
        {"json", 'j', NULL, 0, "Print the twin's reply as JSON (docs/CONTROL.md)", 0}, {0}};
    static const struct argp argp = {
        .options = options,
        .parser = parse,
        .children = connection_children,
        .doc = "Prints the counters of a running twin since its start: frames, response times, late runs."};
    stats_args_t args = {0};
    argp_parse(&argp, argc, argv, 0, NULL, &args);
    connection_t *connection = connection_open(&args.twin, argv[0]);
    if (!connection)
        return EXIT_OPEN;
    cJSON *request = cJSON_CreateObject();
    cJSON_AddStringToObject(request, "op", "stats");
    int status = connection_request(connection, request, argv[0], args.json ? print_line : print_stats);
    connection_close(connection);
    return status;
}
