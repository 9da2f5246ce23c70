/* SPDX-License-Identifier: MIT */
/* ectwin-probe: reads the EEPROM and the dictionary of a slave of any vendor over the bus. */
#define _GNU_SOURCE
#include <argp.h>
#include <errno.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "reader/packet.h"
#include "sii/sii.h"
#include "text/argument.h"

enum { EXIT_CLEAN = 0, EXIT_USAGE = 1, EXIT_OPEN = 2, EXIT_RUN = 3 };
enum { SLAVES_MOST = 65535, SECONDS_MOST = 86400, KEY_LIMIT = 256, KEY_VALUES = 257 };
enum { NAME_AT = 3, COE = 0x04 };

typedef struct args {
    const char *iface, *sii, *od;
    unsigned long slave, limit_s;
    ect_reader_values_t values;
} args_t;

static const struct argp_option options[] = {
    {"interface", 'i', "IFACE", 0, "Network interface with the slaves (required)", 0},
    {"slave", 'n', "N", 0, "Number of the slave in the segment, from 1 (default 1)", 0},
    {"sii", 's', "FILE", 0, "Write the EEPROM to FILE (binary)", 0},
    {"od", 'd', "FILE.json", 0, "Write the dictionary to FILE.json", 0},
    {"values", KEY_VALUES, NULL, 0,
     "With --od: upload the value of each readable entry, and not only those of identity and PDOs", 0},
    {"limit", KEY_LIMIT, "SECONDS", 0, "Stop after SECONDS, 1 to 86400 (default 600)", 0},
    {0},
};

static volatile sig_atomic_t interrupted;

static void on_signal(int number)
{
    (void)number;
    interrupted = 1;
}

static error_t parse(int key, char *text, struct argp_state *state)
{
    args_t *args = state->input;
    switch (key) {
    case 'i':
        args->iface = text;
        return 0;
    case 'n':
        args->slave = (unsigned int)ect_argument_number(state, "-n", text, 1, SLAVES_MOST);
        return 0;
    case 's':
        args->sii = text;
        return 0;
    case 'd':
        args->od = text;
        return 0;
    case KEY_VALUES:
        args->values = ECT_READER_ALL_VALUES;
        return 0;
    case KEY_LIMIT:
        args->limit_s = (unsigned int)ect_argument_number(state, "--limit", text, 1, SECONDS_MOST);
        return 0;
    case ARGP_KEY_END:
        if (args->iface == NULL)
            argp_error(state, "name the interface: -i IFACE");
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

/* On a terminal one line that overwrites itself. */
static bool show_progress(void *ctx, const char *what, unsigned int done, unsigned int all)
{
    (void)ctx;
    if (isatty(STDERR_FILENO))
        fprintf(stderr, "\rectwin-probe: %s %u of %u \r", what, done, all);
    return true;
}

static bool is_interrupted(void *ctx)
{
    (void)ctx;
    return interrupted != 0;
}

static int fail(const ect_reader_t *r, const args_t *args)
{
    fprintf(stderr, "ectwin-probe: slave %lu on '%s': %s\n", args->slave, args->iface, r->text);
    return EXIT_RUN;
}

static int cannot_write(const char *path, int error, int status)
{
    fprintf(stderr, "ectwin-probe: cannot write '%s': %s\n", path, strerror(error));
    return status;
}

/* An incomplete file stays: the exit code marks it. */
static int save(ect_reader_t *r, const args_t *args, const char *path,
                ect_reader_result_t (*write)(ect_reader_t *r, const args_t *args, FILE *file))
{
    FILE *file = fopen(path, "wb");
    if (file == NULL)
        return cannot_write(path, errno, EXIT_OPEN);
    const ect_reader_result_t result = write(r, args, file);
    (void)fflush(file); /* a failure is one of the file, too */
    bool written = ferror(file) == 0;
    int error = errno;
    if (fclose(file) != 0 && written) {
        written = false;
        error = errno;
    }
    if (result != ECT_READER_OK)
        return fail(r, args);
    return written ? EXIT_CLEAN : cannot_write(path, error, EXIT_RUN);
}

static uint8_t image[ECT_READER_SII];

static ect_reader_result_t write_sii(ect_reader_t *r, const args_t *args, FILE *file)
{
    size_t size;
    (void)args;
    const ect_reader_result_t result = ect_reader_sii(r, image, 0, &size);
    (void)fwrite(image, 1, size, file);
    return result;
}

static ect_reader_result_t write_dictionary(ect_reader_t *r, const args_t *args, FILE *file)
{
    return ect_reader_json(r, args->values, file);
}

static int print_line(ect_reader_t *r, const args_t *args)
{
    size_t size, bytes = 0;
    uint8_t length = 0;
    if (ect_reader_sii(r, image, 0, &size) != ECT_READER_OK)
        return fail(r, args);
    const uint8_t *general = ect_sii_category(image, size, ECT_SII_GENERAL, &bytes);
    const char *name =
        general != NULL && bytes > NAME_AT ? ect_sii_string(image, size, general[NAME_AT], &length) : NULL;
    printf("slave %lu: ", args->slave);
    for (uint8_t i = 0; name != NULL && i < length; i++)
        putchar(name[i] >= ' ' && name[i] <= '~' ? name[i] : '?');
    printf("%svendor 0x%08X, product 0x%08X, revision 0x%08X, mailbox %u bytes%s\n", length > 0 ? ", " : "", r->vendor,
           r->product, r->revision, (unsigned int)r->out_size, (r->protocols & COE) != 0 ? ", CoE" : "");
    return EXIT_CLEAN;
}

static int run(ect_packet_t *port, const args_t *args)
{
    static ect_reader_t reader;
    const ect_reader_link_t link = ect_reader_packet_link(port);
    const ect_reader_config_t config = {.position = (uint16_t)(args->slave - 1),
                                        .limit_ms = (uint32_t)(args->limit_s * 1000),
                                        .progress = show_progress,
                                        .stopped = is_interrupted};
    int status = EXIT_CLEAN;
    if (ect_reader_open(&reader, &link, &config) != ECT_READER_OK)
        status = fail(&reader, args);
    else if (args->sii == NULL && args->od == NULL)
        status = print_line(&reader, args);
    if (status == EXIT_CLEAN && args->sii != NULL)
        status = save(&reader, args, args->sii, write_sii);
    if (status == EXIT_CLEAN && args->od != NULL)
        status = save(&reader, args, args->od, write_dictionary);
    ect_reader_close(&reader);
    return status;
}

int main(int argc, char **argv)
{
    static const struct argp argp = {
        .options = options,
        .parser = parse,
        .doc = "Reads the EEPROM and the dictionary of a slave: the EEPROM over the bus, objects by SDO information, "
               "values, PDO mappings and assignments by SDO upload. Without --sii and --od it prints one line.\v"
               "A slave in INIT goes to PREOP, and back to INIT at the end; any other state is kept. The only writes "
               "are mailbox requests and the registers of the EEPROM interface. Stop a master that uses the same "
               "mailbox first: probe and master would receive each other's replies.\n"
               "\n"
               "Exit codes: 0 the slave was read, 1 wrong usage, 2 the interface or a file cannot be opened, 3 the "
               "slave was not read completely; the file then contains the part that was read.",
    };
    args_t args = {.slave = 1, .limit_s = 600};
    char message[ECT_PACKET_MESSAGE];
    ect_packet_t port;
    argp_err_exit_status = EXIT_USAGE;
    argp_parse(&argp, argc, argv, 0, NULL, &args);
    if (ect_packet_open(&port, args.iface, message) < 0) {
        fprintf(stderr, "ectwin-probe: %s\n", message);
        return EXIT_OPEN;
    }
    (void)signal(SIGINT, on_signal);
    (void)signal(SIGTERM, on_signal);
    const int status = run(&port, &args);
    ect_packet_close(&port);
    return status;
}
