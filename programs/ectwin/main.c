/* SPDX-License-Identifier: MIT */
#include <argp.h>
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "bus/chain/catalogue.h"
#include "check/check.h"
#include "commands.h"
#include "ectwin.h"

static const struct command {
    const char *name;
    int (*run)(int argc, char **argv);
} commands[] = {
    {"list", command_list},         {"run", command_run},
    {"with", command_with},         {"sii", command_sii},
    {"get", command_get},           {"set", command_set},
    {"watch", command_watch},       {"list-signals", command_list_signals},
    {"command", command_command},   {"stats", command_stats},
    {"periodic", command_periodic}, {"verify", command_verify},
    {"esi", command_esi},           {"doc", command_doc},
    {"objects", command_objects},   {"unplug", command_unplug},
    {"plug", command_plug},         {"cut", command_cut},
    {"mend", command_mend},         {"fault", command_fault},
    {"lint", command_lint},
};

static int usage(FILE *stream, int status)
{
    fputs("usage: ectwin list                                   the devices there are\n"
          "       ectwin run  -i IFACE DEVICE[,DEVICE...]       answer on IFACE as this chain of devices\n"
          "       ectwin run  --modbus [ADDR:]PORT DEVICE       answer as a base unit over Modbus TCP\n"
          "       ectwin with DEVICE[,DEVICE...] -- CMD ARG...  run CMD with these devices on a private network\n"
          "       ectwin with --external PROGRAM -- CMD ARG...  ... with a slave of your own, which takes -i IFACE\n"
          "       ectwin sii  DEVICE [-o FILE]                  write the SII (EEPROM) image\n"
          "       ectwin verify A B...                          in what ESI files, EEPROM images, devices, slaves "
          "differ\n"
          "       ectwin lint FILE.xml[#TYPE]                   mistakes of an ESI file\n"
          "       ectwin esi  DEVICE[,DEVICE...] [-o FILE]      write the ESI file that engineering tools import\n"
          "       ectwin doc  DEVICE [--html] [-o FILE]         write its dictionary and process data for people\n"
          "       ectwin objects DEVICE --soes [-o FOLDER]      write its dictionary as C source for SOES\n"
          "       ectwin list-signals [DEVICE] [PATTERN]        the signals of a running twin, or of a device\n"
          "       ectwin get   [PATTERN]                        their values\n"
          "       ectwin set   NAME=VALUE... [--csv FILE]       set some, all of them or none\n"
          "       ectwin watch [PATTERN] [--every]              one line of JSON for what has changed, until Ctrl-C\n"
          "       ectwin command ruN HEX16                      an operator's command from remote unit N\n"
          "       ectwin periodic [-o FILE]                     the last set of periodic data that remotes were shown\n"
          "       ectwin unplug N          ectwin plug N        pull all plugs of slave N, put them back\n"
          "       ectwin cut N.PORT        ectwin mend N.PORT   cut the wire at a port of slave N, mend it\n"
          "       ectwin fault [FAULT]                          let something go wrong, or list what does\n"
          "       ectwin stats [--json]                         frames, answer times and what came late, since the "
          "start\n"
          "       ectwin --version\n"
          "'ectwin COMMAND --help' tells more of each.\n",
          stream);
    return status;
}

/* A descriptor that is closed at the start would be given to the next file or socket, which then gets what we print. */
static void fill_standard_streams(void)
{
    int fd = open("/dev/null", O_RDWR);
    while (fd >= 0 && fd <= STDERR_FILENO)
        fd = open("/dev/null", O_RDWR);
    if (fd > STDERR_FILENO)
        close(fd);
}

/* Short output, as help, is written at its end: there it is known why it cannot be. */
static void keep_output_together(void)
{
    static char room[16384];
    if (!isatty(STDOUT_FILENO))
        (void)setvbuf(stdout, room, _IOFBF, sizeof room);
}

/* Output that is not written is no success: a full disk. One who has stopped to read has got what he wanted. */
static void check_output(void)
{
    errno = 0;
    if ((ferror(stdout) == 0 && fflush(stdout) == 0) || errno == EPIPE)
        return;
    fprintf(stderr, "ectwin: cannot write to standard output: %s\n", errno != 0 ? strerror(errno) : "it failed before");
    fflush(stderr);
    _exit(EXIT_OPEN);
}

/* The program's own devices: described well, and found by their names. */
static bool take_products(const ect_product_t *products, size_t count)
{
    ect_catalogue_add(products, count);
    for (size_t i = 0; i < count; i++) {
        char text[ECT_CHECK_TEXT];
        const char *name = products[i].device->name;
        if (!ect_device_check(products[i].device, text, sizeof text) ||
            !ect_plant_check(products[i].plant, products[i].device, text, sizeof text)) {
            fprintf(stderr, "ectwin: the description of '%s' is wrong: %s\n", name ? name : "a device", text);
            return false;
        }
        if (ect_catalogue_find(name) != &products[i]) {
            fprintf(stderr, "ectwin: two devices have the name '%s'; give this program's another one\n", name);
            return false;
        }
    }
    return true;
}

int ectwin_main(int argc, char **argv, const ect_product_t *products, size_t count)
{
    argp_err_exit_status = EXIT_USAGE;
    fill_standard_streams();
    keep_output_together();
    if (atexit(check_output) != 0)
        return EXIT_RUN;
    if (!take_products(products, count))
        return EXIT_RUN;
    if (argc < 2)
        return usage(stderr, EXIT_USAGE);
    if (strcmp(argv[1], "--version") == 0) {
        puts("ectwin " ECTWIN_VERSION);
        return EXIT_CLEAN;
    }
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
