/* SPDX-License-Identifier: MIT */
/* Candidates for the last word of a command line, for shell completion: `ectwin complete WORD... LAST`. */
#define _GNU_SOURCE
#include <argp.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "bus/chain/catalogue.h"
#include "bus/chain/fault.h"
#include "commands.h"
#include "connection.h"

static const char *last;

static void offer(const char *before, const char *word, const char *after)
{
    size_t length = strlen(before);
    if (strncmp(last, before, length) == 0 && strncmp(word, last + length, strlen(last + length)) == 0)
        printf("%s%s%s\n", before, word, after);
}

/* Runs this program and passes each line of its output to `take`: candidates come from help texts and lists. */
static void each_line(char *const words[], void (*take)(char *line))
{
    int ends[2];
    char *line = NULL;
    size_t room = 0;
    if (pipe2(ends, O_CLOEXEC) < 0)
        return;
    fflush(stdout);
    pid_t pid = fork();
    if (pid == 0) {
        int nothing = open("/dev/null", O_WRONLY | O_CLOEXEC);
        (void)dup2(ends[1], STDOUT_FILENO);
        (void)dup2(nothing, STDERR_FILENO);
        execv("/proc/self/exe", words);
        _exit(EXIT_RUN);
    }
    close(ends[1]);
    FILE *output = fdopen(ends[0], "r");
    while (pid > 0 && output && getline(&line, &room, output) >= 0)
        take(line);
    free(line);
    if (output)
        fclose(output);
    if (pid > 0)
        (void)waitpid(pid, NULL, 0);
}

/* Prints the options in a line of a command's help. */
static void take_options(char *line)
{
    char *option = strstr(line, "--");
    if (line[0] != ' ' || !option || strspn(line, " ") > 8)
        return;
    size_t length = strcspn(option, " =[,\n");
    bool value = option[length] == '=';
    option[length] = 0;
    offer("", option, value ? "=" : "");
}

/* Prints the name of a line "NAME r ..." of list-signals. */
static void take_signal(char *line)
{
    line[strcspn(line, " \n")] = 0;
    offer("", line, "");
}

static void take_writable_signal(char *line)
{
    char *access = line + strcspn(line, " ");
    if (strncmp(access + strspn(access, " "), "rw", 2) != 0)
        return;
    *access = 0;
    offer("", line, "=");
}

static void offer_devices(void)
{
    char before[256];
    const char *comma = strrchr(last, ',');
    const ect_product_t *product;
    snprintf(before, sizeof before, "%.*s", comma ? (int)(comma - last + 1) : 0, last);
    for (size_t i = 0; (product = ect_catalogue_at(i)) != NULL; i++)
        offer(before, product->device->name, "");
}

static void take_twin(char *line)
{
    char room[32];
    char word[ECT_ENDPOINT_PATH];
    cJSON *twin = cJSON_Parse(line);
    const char *name = strrchr(connection_text(twin, "socket", room), '/');
    if (name) {
        snprintf(word, sizeof word, "%.*s", (int)(strlen(name + 1) - strlen(".sock")), name + 1);
        offer("", word, "");
    }
    cJSON_Delete(twin);
}

static bool is_one_of(const char *word, const char *const *list)
{
    while (*list && strcmp(*list, word) != 0)
        list++;
    return *list != NULL;
}

static void offer_signals(const char *program, void (*take)(char *line))
{
    char *words[] = {(char *)program, "list-signals", NULL};
    each_line(words, take);
}

/* Prints the candidates for an operand of a command. */
static void offer_argument(const char *program, const char *command, int place)
{
    static const char *const of_devices[] = {"run", "with", "sii", "esi", "doc", "objects", "list-signals", NULL};
    static const char *const of_signals[] = {"get", "watch", "wait", NULL};
    if (is_one_of(command, of_devices) && place == 1)
        offer_devices();
    if (is_one_of(command, of_signals))
        offer_signals(program, take_signal);
    if (strcmp(command, "set") == 0)
        offer_signals(program, take_writable_signal);
    for (size_t i = 0; strcmp(command, "fault") == 0 && place == 1 && ect_fault_word(i); i++) {
        if (i == 0 || strcmp(ect_fault_word(i), ect_fault_word(i - 1)) != 0)
            offer("", ect_fault_word(i), "");
    }
}

int command_complete(int argc, char **argv)
{
    static char program[] = "ectwin";
    static char help[] = "--help";
    static char ps[] = "ps";
    static char json[] = "--json";
    if (argc < 3) /* main.c completes the name of the command */
        return EXIT_USAGE;
    last = argv[argc - 1];
    const char *previous = argv[argc - 2];
    int place = 0; /* number of operands */
    for (int i = 1; i < argc; i++)
        place += argv[i][0] != '-';
    if (*last == '-') {
        char *const words[] = {program, argv[1], help, NULL};
        each_line(words, take_options);
    } else if (strcmp(previous, "-s") == 0) {
        char *const words[] = {program, ps, json, NULL};
        each_line(words, take_twin);
    } else if (previous[0] != '-') {
        offer_argument(program, argv[1], place - 1 > 0 ? place - 1 : 1);
    }
    return EXIT_CLEAN;
}
