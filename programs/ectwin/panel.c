/* SPDX-License-Identifier: MIT */
/* Starts ectwin-panel, a program of its own: only the panel needs libwebsockets. */
#define _GNU_SOURCE
#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "commands.h"

/* --help works without the panel too: the manual page contains the help of each command. */
static int report_missing(int argc, char **argv, const char *name)
{
    static const char cause[] = "ectwin was built without libwebsockets; install libwebsockets-dev and build again";
    if (argc == 2 && strcmp(argv[1], "--help") == 0) {
        printf("Usage: %s [OPTION...]\nShows all running twins of this user in a browser, by the program %s, which is "
               "missing: %s.\n",
               argv[0], name, cause);
        return EXIT_CLEAN;
    }
    fprintf(stderr, "%s: the program '%s' is missing: %s\n", argv[0], name, cause);
    return EXIT_OPEN;
}

int command_panel(int argc, char **argv)
{
    static const char name[] = "ectwin-panel";
    char path[PATH_MAX + sizeof name];
    ssize_t length = readlink("/proc/self/exe", path, PATH_MAX);
    path[length > 0 ? length : 0] = 0;
    char *slash = strrchr(path, '/'); /* beside this program, in a build as well as installed */
    strcpy(slash ? slash + 1 : path, name);
    execv(path, argv);
    if (errno == ENOENT)
        execvp(name, argv);
    if (errno == ENOENT)
        return report_missing(argc, argv, name);
    fprintf(stderr, "%s: cannot run '%s': %s\n", argv[0], name, strerror(errno));
    return EXIT_OPEN;
}
