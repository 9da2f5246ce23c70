/* SPDX-License-Identifier: MIT */
/* Captures and records of a run. */
#define _GNU_SOURCE
#include <cjson/cJSON.h>
#include <errno.h>
#include <inttypes.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "bus/capture/capture.h"
#include "commands.h"

/* Holds a tenth of a second of the fastest masters while the disk is busy. */
enum { CAPTURE_BUFFER = 4 * 1024 * 1024, RECORD_BUFFER = 16 * 1024 * 1024, NS_PER_S = 1000000000 };

static void note_save(void *ctx, size_t number)
{
    ect_trace_note(ctx, "slave %zu: parameters are saved", number);
}

static int log_flush(void *ctx, int result)
{
    ect_trace_log(ctx, ECT_LOGGED_FLUSH, (uint32_t)result, 0, NULL, 0);
    return result;
}

static uint64_t offset_of_wall_clock(void)
{
    struct timespec wall, clock;
    (void)clock_gettime(CLOCK_REALTIME, &wall);
    (void)clock_gettime(CLOCK_MONOTONIC, &clock);
    return (uint64_t)(wall.tv_sec - clock.tv_sec) * NS_PER_S + (uint64_t)wall.tv_nsec - (uint64_t)clock.tv_nsec;
}

/* Two processes of CMD may have a bus at the same time: the second file's name contains the process id. */
static ect_capture_t *open_capture(const twin_args_t *args, const char *path, bool record, uint64_t offset_ns,
                                   char *message)
{
    char other[PATH_MAX];
    ect_capture_config_t config = {.path = path,
                                   .most = record ? 0 : args->pcap_size,
                                   .buffer = record ? RECORD_BUFFER : CAPTURE_BUFFER,
                                   .append = args->in_process,
                                   .offset_ns = offset_ns,
                                   .application = "ectwin " ECTWIN_VERSION,
                                   .names = {args->about.ifaces[ECT_END_IN], args->about.ifaces[ECT_END_OUT]}};
    ect_capture_t *capture = ect_capture_open(&config, message);
    if (capture || !args->in_process || errno != EWOULDBLOCK)
        return capture;
    snprintf(other, sizeof other, "%s.%d", path, (int)getpid());
    config.path = other;
    return ect_capture_open(&config, message);
}

/* Writes the start of a record: all data for the power-on of the same twins in a replay. */
static void log_start(const twin_args_t *args, ect_trace_t *trace, uint64_t offset_ns)
{
    cJSON *start = cJSON_CreateObject();
    cJSON *words = cJSON_AddArrayToObject(start, "words");
    char number[24];
    for (int i = 0; i < args->word_count; i++)
        cJSON_AddItemToArray(words, cJSON_CreateString(args->words[i]));
    cJSON_AddStringToObject(start, "version", ECTWIN_VERSION);
    cJSON_AddNumberToObject(start, "seed", args->scenario.seed);
    snprintf(number, sizeof number, "%" PRIu64, offset_ns);
    cJSON_AddStringToObject(start, "offset", number);
    char *text = cJSON_PrintUnformatted(start);
    if (text)
        ect_trace_log(trace, ECT_LOGGED_START, 0, args->power_on_ns, text, strlen(text));
    cJSON_free(text);
    cJSON_Delete(start);
}

/* A record orders Modbus requests by its frames, and so needs frames; frames of a host behind EoE are not recorded. */
static bool can_record(const twin_args_t *args, const char *who)
{
    const bool framed = !args->modbus || args->about.ifaces[ECT_END_IN] || args->udp;
    const char *host = eoe_args_host(&args->eoe);
    if (args->record && !framed)
        twin_args_report(args, who, "--record needs frames, and there is no interface for them: add -i IFACE");
    else if (args->record && host)
        twin_args_report(args, who, "--record does not hold the frames of --eoe %s: leave one of the two out", host);
    return !args->record || (framed && !host);
}

/* Logs the content of the folders and, from now on, the completion of each save. */
static bool log_content(const twin_args_t *args, ect_trace_t *trace, char *message)
{
    char text[ECT_CAPTURE_MESSAGE];
    const char *why = content_log(&args->content, args->files, trace, text, sizeof text);
    for (size_t i = 0; args->store && i < args->count; i++)
        ect_memory_replace_flush(args->memories[i], log_flush, trace);
    if (why)
        snprintf(message, ECT_CAPTURE_MESSAGE, "%s", why);
    return !why;
}

static bool open_files_of_trace(const twin_args_t *args, ect_trace_t **trace, char *message)
{
    uint64_t offset_ns = args->own_clock ? 0 : offset_of_wall_clock();
    ect_capture_t *capture = args->pcap ? open_capture(args, args->pcap, false, offset_ns, message) : NULL;
    bool done = !args->pcap || capture;
    ect_capture_t *record = done && args->record ? open_capture(args, args->record, true, offset_ns, message) : NULL;
    done = done && (!args->record || record);
    *trace = done ? ect_trace_new(capture, record, args->count) : NULL;
    if (*trace) {
        log_start(args, *trace, offset_ns);
        if (!record || log_content(args, *trace, message))
            return true;
        (void)ect_trace_close(*trace, args->power_on_ns);
        *trace = NULL;
        return false;
    }
    (void)ect_capture_close(capture, NULL, 0, 0);
    (void)ect_capture_close(record, NULL, 0, 0);
    return false;
}

int twin_args_trace(twin_args_t *args, const char *who, ect_trace_t **trace)
{
    char message[ECT_CAPTURE_MESSAGE] = "not enough memory for a capture";
    *trace = NULL;
    if (!args->pcap && !args->record)
        return EXIT_CLEAN;
    if (!can_record(args, who))
        return EXIT_USAGE;
    if (!open_files_of_trace(args, trace, message)) {
        twin_args_report(args, who, "%s: %s", args->pcap && strstr(message, args->pcap) ? "--pcap" : "--record",
                         message);
        return EXIT_OPEN;
    }
    for (size_t i = 0; i < args->count; i++)
        ect_memory_observe(args->memories[i], note_save, *trace, i + 1);
    return EXIT_CLEAN;
}

bool twin_args_end_trace(const twin_args_t *args, const char *who, ect_trace_t *trace, uint64_t now_ns)
{
    for (size_t i = 0; trace && i < args->count; i++) {
        ect_memory_observe(args->memories[i], NULL, NULL, 0);
        ect_memory_replace_flush(args->memories[i], NULL, NULL);
    }
    ect_trace_lacks_t lacks = ect_trace_close(trace, now_ns);
    if (lacks.capture != 0)
        fprintf(stderr, "%s: --pcap: '%s' lacks the end of the run: %s\n", who, args->pcap, strerror(lacks.capture));
    if (lacks.record != 0 || lacks.record_is_slow)
        fprintf(stderr, "%s: --record: '%s' lacks the end of the run: %s\n", who, args->record,
                lacks.record != 0 ? strerror(lacks.record) : "the disk is too slow; write to a faster one");
    return lacks.capture == 0 && lacks.record == 0 && !lacks.record_is_slow;
}
