/* SPDX-License-Identifier: MIT */
/* Information on a bus for other programs: ready line, control socket, command line. */
#define _GNU_SOURCE
#include <cjson/cJSON.h>
#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "commands.h"

void twin_args_describe(twin_args_t *args)
{
    char folder[PATH_MAX];
    size_t size = 0;
    FILE *stream = getcwd(folder, sizeof folder) ? open_memstream(&args->joined, &size) : NULL;
    if (!stream)
        return;
    (void)fwrite(folder, 1, strlen(folder) + 1, stream);
    for (int i = 0; i < args->word_count; i++)
        (void)fwrite(args->words[i], 1, strlen(args->words[i]) + 1, stream);
    if (fclose(stream) != 0)
        return;
    args->about.words = args->joined;
    args->about.words_length = size;
}

bool print_ready(FILE *stream, char *const ifaces[ECT_ENDS], size_t slaves, const char *modbus, const char *udp)
{
    cJSON *line = cJSON_CreateObject();
    cJSON_AddStringToObject(line, "event", "ready");
    if (ifaces[ECT_END_IN])
        cJSON_AddStringToObject(line, "iface", ifaces[ECT_END_IN]);
    if (ifaces[ECT_END_OUT])
        cJSON_AddStringToObject(line, "iface2", ifaces[ECT_END_OUT]);
    if (modbus)
        cJSON_AddStringToObject(line, "modbus", modbus);
    if (udp)
        cJSON_AddStringToObject(line, "udp", udp);
    cJSON_AddNumberToObject(line, "slaves", (double)slaves);
    char *text = cJSON_PrintUnformatted(line);
    bool written = fprintf(stream, "%s\n", text ? text : "") > 0 && fflush(stream) == 0;
    cJSON_free(text);
    cJSON_Delete(line);
    if (written || errno == EPIPE) /* EPIPE: the reader has ended */
        return true;
    fprintf(stderr, "ectwin: the ready line cannot be written: %s\n", strerror(errno));
    clearerr(stream); /* already reported */
    return false;
}

int open_control(const char *who, const ect_about_t *about, ect_control_t **control)
{
    char message[ECT_ENDPOINT_MESSAGE];
    *control = ect_control_open(about->name, message);
    if (*control) {
        ect_control_describe(*control, about);
        return EXIT_CLEAN;
    }
    bool taken = about->name && errno == EADDRINUSE;
    fprintf(stderr, "%s: %s%s\n", who, message, taken ? "" : "; 'ectwin get' and 'ectwin set' cannot reach this twin");
    return taken ? EXIT_OPEN : EXIT_CLEAN;
}
