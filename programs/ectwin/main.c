/* SPDX-License-Identifier: MIT */
#include <argp.h>
#include <errno.h>
#include <fcntl.h>
#include <malloc.h>
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
    {"esi", command_esi},           {"eni", command_eni},
    {"doc", command_doc},           {"objects", command_objects},
    {"unplug", command_unplug},     {"plug", command_plug},
    {"cut", command_cut},           {"mend", command_mend},
    {"fault", command_fault},       {"lint", command_lint},
    {"check", command_check},       {"save-bus", command_save_bus},
    {"clone", command_clone},       {"ps", command_ps},
    {"enter", command_enter},       {"wait", command_wait},
    {"veth", command_veth},         {"replay", command_replay},
    {"new", command_new},           {"panel", command_panel},
    {"complete", command_complete},
};

/* Prints the commands that begin with `word`, except the last one, `complete`, which is for shells. */
static int complete_command(const char *word)
{
    for (size_t i = 0; i + 1 < sizeof commands / sizeof commands[0]; i++) {
        if (strncmp(commands[i].name, word, strlen(word)) == 0)
            puts(commands[i].name);
    }
    return EXIT_CLEAN;
}

static int usage(FILE *stream, int status)
{
    fputs(
        "usage: ectwin list                                   list the devices\n"
        "       ectwin run  -i IFACE DEVICE[,DEVICE...]       run this chain of devices on IFACE\n"
        "       ectwin run  -i IFACE BUS.yaml                 run the bus of a file; also with 'with'\n"
        "       ectwin run  -i IFACE eni:FILE.xml             run the bus of a network file (ENI); also with 'with'\n"
        "       ectwin check BUS.yaml                         check a bus file without running it\n"
        "       ectwin run  --modbus [ADDR:]PORT DEVICE       run a base unit over Modbus TCP alone\n"
        "       ectwin run  --udp [ADDR:]PORT DEVICE[,...]    reply to EtherCAT in UDP, without privileges\n"
        "       ectwin with DEVICE[,DEVICE...] -- CMD ARG...  run CMD with these devices on a private network\n"
        "       ectwin with --external PROGRAM -- CMD ARG...  run CMD with a slave of your own, a program with -i "
        "IFACE\n"
        "       ectwin sii  DEVICE [-o FILE]                  write the SII (EEPROM) image\n"
        "       ectwin verify A B...                          compare ESI files, EEPROM images, devices, "
        "slaves\n"
        "       ectwin save-bus [-o FILE]                     write the running bus as a bus file\n"
        "       ectwin clone -i IFACE -o DIR                  write every slave of a live bus as a twin, and a bus "
        "file\n"
        "       ectwin lint FILE.xml[#TYPE]                   list mistakes of an ESI file\n"
        "       ectwin new  DEVICE.yaml [-o DIR]              write ESI, EEPROM, manual and C source of a device of "
        "your "
        "own\n"
        "       ectwin esi  DEVICE[,DEVICE...] [-o FILE]      write the ESI file that engineering tools import\n"
        "       ectwin eni  DEVICE[,DEVICE...] [-o FILE]      write the network file (ENI) of a bus, for masters that "
        "need one\n"
        "       ectwin doc  DEVICE [--html] [-o FILE]         write a manual of dictionary and process data\n"
        "       ectwin objects DEVICE --soes [-o FOLDER]      write the dictionary as C source for SOES\n"
        "       ectwin veth [NAME]                            make a pair of interfaces for a master in the kernel\n"
        "       ectwin ps [--json]                            list your running twins\n"
        "       ectwin enter [-s NAME] -- CMD ARG...          run CMD in the network of a running twin\n"
        "       ectwin list-signals [DEVICE] [PATTERN...]     list the signals of a running twin, or of a device\n"
        "       ectwin get   [PATTERN...]                     print the values of signals\n"
        "       ectwin set   NAME=VALUE... [--csv FILE]       set signals, all of them or none; now, or --at TIME\n"
        "       ectwin watch [PATTERN...] [--every]           print each change as a line of JSON\n"
        "       ectwin wait CONDITION [--timeout SECONDS]     wait until a signal is NAME=VALUE, NAME<VALUE, ...\n"
        "       ectwin command ruN HEX16                      send an operator's command from remote unit N\n"
        "       ectwin periodic [-o FILE]                     print the last set of periodic data\n"
        "       ectwin unplug N          ectwin plug N        pull all plugs of slave N, insert them again\n"
        "       ectwin cut N.PORT        ectwin mend N.PORT   cut the wire at a port of slave N, mend it\n"
        "       ectwin fault [FAULT]                          inject a fault, or list the active faults\n"
        "       ectwin replay FILE [DEVICE[,DEVICE...]]       replay a record; compare a capture with devices\n"
        "       ectwin panel [--port PORT] [--open]           watch and control your running twins in a browser\n"
        "       ectwin stats [--json]                         print the counters of a running twin\n"
        "       ectwin --version\n"
        "'ectwin COMMAND --help' describes each command.\n",
        stream);
    return status;
}

/* Otherwise the next file or socket would get the number of a closed standard descriptor, and then its output. */
static void fill_standard_streams(void)
{
    int fd = open("/dev/null", O_RDWR);
    while (fd >= 0 && fd <= STDERR_FILENO)
        fd = open("/dev/null", O_RDWR);
    if (fd > STDERR_FILENO)
        close(fd);
}

/* Buffers short output, as help, until the end, where a failure is reported. */
static void keep_output_together(void)
{
    static char room[16384];
    if (!isatty(STDOUT_FILENO))
        (void)setvbuf(stdout, room, _IOFBF, sizeof room);
}

/* A fixed limit: large blocks always come from the system, which provides their pages when they are written to. With
 * the limit that the C library raises by itself, the blocks of a thousand twins would be filled with zeros. */
static void keep_large_blocks_apart(void)
{
#ifdef M_MMAP_THRESHOLD
    (void)mallopt(M_MMAP_THRESHOLD, 128 * 1024);
#endif
}

/* Reports lost output (a full disk) as a failure. EPIPE is none: the reader needs no more. */
static void check_output(void)
{
    errno = 0;
    if ((ferror(stdout) == 0 && fflush(stdout) == 0) || errno == EPIPE)
        return;
    fprintf(stderr, "ectwin: cannot write to standard output: %s\n", errno != 0 ? strerror(errno) : "it failed before");
    fflush(stderr);
    _exit(EXIT_OPEN);
}

/* Adds the program's own devices, which need valid descriptions and unique names. */
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
    keep_large_blocks_apart();
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
    if (strcmp(argv[1], "complete") == 0 && argc == 3)
        return complete_command(argv[2]);
    for (size_t i = 0; i < sizeof commands / sizeof commands[0]; i++) {
        if (strcmp(argv[1], commands[i].name) == 0) {
            char name[32];
            snprintf(name, sizeof name, "ectwin %s", commands[i].name);
            argv[1] = name;
            return commands[i].run(argc - 1, argv + 1);
        }
    }
    fprintf(stderr, "ectwin: no command '%s'\n", argv[1]);
    return usage(stderr, EXIT_USAGE);
}
