/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include <argp.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>
#include <unistd.h>

#include "bus/control/endpoint.h"
#include "bus/net/rights.h"
#include "server.h"
#include "text/argument.h"

enum { EXIT_USAGE = 1, EXIT_OPEN = 2 };
enum { KEY_BIND = 256, KEY_VIEW };

typedef struct arguments {
    server_options_t server;
    bool open;
    char file[ECT_ENDPOINT_PATH + 32]; /* the file that the browser opens; "": none */
} arguments_t;

static const struct argp_option options[] = {
    {"port", 'p', "PORT", 0, "TCP port of the panel; 0 (default): any that is free", 0},
    {"open", 'o', NULL, 0, "Open the panel in the browser of this desktop (xdg-open)", 0},
    {"view", KEY_VIEW, NULL, 0, "Refuse all changes: the page is read-only", 0},
    {"bind", KEY_BIND, "ADDRESS", 0,
     "Listen at this numeric address in place of 127.0.0.1. There is no encryption: everybody on the network path can "
     "read the "
     "token, and change the twins",
     0},
    {0}};

static error_t parse(int key, char *text, struct argp_state *state)
{
    arguments_t *args = state->input;
    switch (key) {
    case 'p':
        args->server.port = (unsigned int)ect_argument_number(state, "--port", text, 0, UINT16_MAX);
        break;
    case 'o':
        args->open = true;
        break;
    case KEY_VIEW:
        args->server.view = true;
        break;
    case KEY_BIND:
        if (!request_is_numeric(text))
            argp_error(state, "--bind takes a numeric address, as 192.168.1.5, not '%s'", text);
        args->server.address = text;
        break;
    case ARGP_KEY_ARG:
        argp_error(state, "it takes no argument");
        break;
    default:
        return ARGP_ERR_UNKNOWN;
    }
    return 0;
}

static void print_version(FILE *stream, struct argp_state *state)
{
    (void)state;
    fputs("ectwin-panel " ECTWIN_VERSION "\n", stream);
}

/* The URL with the token would be in the browser's arguments, which other users can read; a file of mode 0600 is not.
 */
static bool write_file(arguments_t *args, const char *url)
{
    char folder[ECT_ENDPOINT_PATH];
    if (ect_endpoint_folder(folder) < 0 || ect_endpoint_trust(folder) < 0)
        return false;
    snprintf(args->file, sizeof args->file, "%s/panel-%d.html", folder, (int)getpid());
    int fd = open(args->file, O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW | O_CLOEXEC, 0600);
    FILE *file = fd >= 0 ? fdopen(fd, "w") : NULL;
    if (!file)
        return false;
    fprintf(file, "<!doctype html><meta http-equiv=\"refresh\" content=\"0;url=%s\"><title>ectwin</title>\n", url);
    return fclose(file) == 0;
}

static void open_browser(arguments_t *args, const char *url)
{
    if (!write_file(args, url)) {
        fputs("ectwin panel: --open needs the folder of a running twin: start one, or open the URL yourself\n", stderr);
        return;
    }
    (void)signal(SIGCHLD, SIG_IGN); /* the kernel collects it */
    if (fork() == 0) {
        execlp("xdg-open", "xdg-open", args->file, (char *)NULL);
        fprintf(stderr, "ectwin panel: cannot run xdg-open (%s): open the URL yourself\n", strerror(errno));
        _exit(127);
    }
}

/* From here on the panel serves clients that it does not trust: it opens no file for writing, starts no program, and
 * creates local sockets only. */
static void drop_rights(void)
{
    char message[ECT_RIGHTS_MESSAGE];
    if (ect_rights_drop(ECT_RIGHTS_CLIENT, message) < 0)
        fprintf(stderr, "ectwin panel: %s\n", message);
}

static void ready(void *ctx, unsigned int port)
{
    arguments_t *args = ctx;
    bool six = strchr(args->server.address, ':') != NULL;
    char url[160];
    snprintf(url, sizeof url, "http://%s%s%s:%u/#%s", six ? "[" : "", args->server.address, six ? "]" : "", port,
             args->server.token);
    if (args->open)
        open_browser(args, url);
    drop_rights();
    printf("{\"event\":\"ready\",\"url\":\"%s\"}\n", url);
    fflush(stdout);
}

int main(int argc, char **argv)
{
    static const struct argp argp = {
        .options = options,
        .parser = parse,
        .doc =
            "Serves all running twins of this user to a browser: lamps, plugs, signals, faults, plots. Prints a line "
            "with the URL, which contains the token that a page needs; ends with Ctrl-C."
            "\vExit codes: 0 ended by a signal, 1 wrong usage, 2 the port cannot be opened."};
    arguments_t args = {.server = {.address = "127.0.0.1"}};
    uint8_t bits[16];
    argp_err_exit_status = EXIT_USAGE;
    argp_program_version_hook = print_version;
    argp_parse(&argp, argc, argv, 0, NULL, &args);
    if (getrandom(bits, sizeof bits, 0) != (ssize_t)sizeof bits) {
        fprintf(stderr, "%s: no random numbers: %s\n", argv[0], strerror(errno));
        return EXIT_OPEN;
    }
    request_write_token(bits, args.server.token);
    if (!request_is_loopback(args.server.address))
        fprintf(stderr,
                "%s: listens at %s: everybody on the network path can read the token and change the twins; with --view "
                "only "
                "read them\n",
                argv[0], args.server.address);
    bool served = server_run(&args.server, argv[0], ready, &args);
    if (args.file[0])
        (void)unlink(args.file);
    return served ? EXIT_SUCCESS : EXIT_OPEN;
}
