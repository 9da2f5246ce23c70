/* SPDX-License-Identifier: MIT */
/* ectwin: EtherCAT device twins on a network interface. */
#include <argp.h>
#include <string.h>

#include "commands.h"

static const struct command {
    const char *name;
    int (*run)(int argc, char **argv);
} commands[] = {
    {"list", command_list},       {"run", command_run},
    {"with", command_with},       {"sii", command_sii},
    {"get", command_get},         {"set", command_set},
    {"watch", command_watch},     {"list-signals", command_list_signals},
    {"command", command_command},
};

static int usage(FILE *stream, int status)
{
    fputs("usage: ectwin list                                   the devices there are\n"
          "       ectwin run  -i IFACE DEVICE[,DEVICE...]       answer on IFACE as this chain of devices\n"
          "       ectwin with DEVICE[,DEVICE...] -- CMD ARG...  run CMD with these devices on a private network\n"
          "       ectwin sii  DEVICE [-o FILE]                  write the SII (EEPROM) image\n"
          "       ectwin list-signals [PATTERN]                 the signals of a running twin: range and meaning\n"
          "       ectwin get   [PATTERN]                        their values\n"
          "       ectwin set   NAME=VALUE... [--csv FILE]       set some\n"
          "       ectwin watch [PATTERN] [--every]              one line of JSON for what has changed, until Ctrl-C\n"
          "       ectwin command ruN HEX16                      an operator's command from remote unit N\n"
          "'ectwin COMMAND --help' tells more of each.\n",
          stream);
    return status;
}

int main(int argc, char **argv)
{
    argp_err_exit_status = EXIT_USAGE;
    if (argc < 2)
        return usage(stderr, EXIT_USAGE);
    if (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "help") == 0)
        return usage(stdout, EXIT_CLEAN);
    for (size_t i = 0; i < sizeof commands / sizeof commands[0]; i++) {
        if (strcmp(argv[1], commands[i].name) == 0) {
            char name[32];
            snprintf(name, sizeof name, "ectwin %s", commands[i].name);
            argv[1] = name;
            return commands[i].run(argc - 1, argv + 1);
        }
    }
    fprintf(stderr, "ectwin: there is no command '%s'\n", argv[1]);
    return usage(stderr, EXIT_USAGE);
}
