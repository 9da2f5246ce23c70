/* SPDX-License-Identifier: MIT */
/*
 * ectwin-probe: what a slave on the wire says of itself. Its EEPROM over the bus, its dictionary by SDO information,
 * its PDOs and identity by SDO. Any vendor's slave; nothing is written to it but AL control and mailbox requests.
 *
 * This file is MIT; the program is linked with SOEM and as a binary covered by SOEM's licence, GPL-2.0 with an
 * exception.
 */
#define _GNU_SOURCE
#include <argp.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "number.h"
#include "open_bus.h"
#include "probe.h"

enum { EXIT_CLEAN = 0, EXIT_USAGE = 1, EXIT_OPEN = 2, EXIT_RUN = 3 };

typedef struct args {
    const char *iface, *sii, *od;
    unsigned long slave;
} args_t;

static const struct argp_option options[] = {
    {"interface", 'i', "IFACE", 0, "The network interface that the slaves are on", 0},
    {"slave", 'n', "N", 0, "Which of them, from 1 (default 1)", 0},
    {"sii", 's', "FILE", 0, "Write its SII (EEPROM) to FILE", 0},
    {"od", 'd', "FILE.json", 0, "Write its dictionary to FILE.json", 0},
    {0},
};

static error_t parse(int key, char *text, struct argp_state *state)
{
    args_t *args = state->input;
    switch (key) {
    case 'i':
        args->iface = text;
        return 0;
    case 'n':
        args->slave = number_of(state, "-n", text, EC_MAXSLAVE - 1);
        if (args->slave == 0)
            argp_error(state, "-n takes the number of a slave, 1 to %d, not '%s'", EC_MAXSLAVE - 1, text);
        return 0;
    case 's':
        args->sii = text;
        return 0;
    case 'd':
        args->od = text;
        return 0;
    case ARGP_KEY_END:
        if (args->iface == NULL)
            argp_error(state, "name the interface: -i IFACE");
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static int save(const char *path, bool (*write)(uint16_t slave, FILE *file), uint16_t slave)
{
    FILE *file = fopen(path, "wb");
    if (file == NULL) {
        fprintf(stderr, "ectwin-probe: cannot write '%s': %s\n", path, strerror(errno));
        return EXIT_OPEN;
    }
    bool read = write(slave, file);
    bool written = fflush(file) == 0 && ferror(file) == 0;
    int error = errno;
    if (fclose(file) != 0 && written) {
        written = false;
        error = errno;
    }
    if (!read)
        fprintf(stderr, "ectwin-probe: slave %u stopped answering while its %s was read\n", (unsigned int)slave,
                write == probe_sii ? "EEPROM" : "dictionary");
    else if (!written)
        fprintf(stderr, "ectwin-probe: cannot write '%s': %s\n", path, strerror(error));
    return read && written ? EXIT_CLEAN : EXIT_RUN;
}

static int run(const args_t *args)
{
    int count = ec_config_init(FALSE);
    if (count <= 0 || (unsigned long)count < args->slave) {
        fprintf(stderr, "ectwin-probe: there are %d slaves on '%s', none with number %lu\n", count > 0 ? count : 0,
                args->iface, args->slave);
        return EXIT_RUN;
    }
    uint16_t slave = (uint16_t)args->slave;
    (void)ec_statecheck(slave, EC_STATE_PRE_OP, EC_TIMEOUTSTATE);
    const ec_slavet *s = &ec_slave[slave];
    if (args->sii == NULL && args->od == NULL)
        printf("slave %u: %s, vendor 0x%08X, product 0x%08X, revision 0x%08X, mailbox %u bytes%s\n",
               (unsigned int)slave, s->name, s->eep_man, s->eep_id, s->eep_rev, (unsigned int)s->mbx_l,
               (s->mbx_proto & ECT_PROBE_COE) != 0 ? ", CoE" : "");
    int status = args->sii != NULL ? save(args->sii, probe_sii, slave) : EXIT_CLEAN;
    if (status == EXIT_CLEAN && args->od != NULL)
        status = save(args->od, probe_dictionary, slave);
    ec_slave[0].state = EC_STATE_INIT;
    (void)ec_writestate(0);
    return status;
}

int main(int argc, char **argv)
{
    static const struct argp argp = {
        .options = options,
        .parser = parse,
        .doc =
            "Reads what a slave says of itself: its EEPROM over the bus, its dictionary by SDO information, its PDOs "
            "by SDO. Without files to write it prints one line. All slaves of the segment go to INIT and PREOP, and "
            "to INIT at the end: not for a machine at work.",
    };
    args_t args = {.slave = 1};
    argp_err_exit_status = EXIT_USAGE;
    argp_parse(&argp, argc, argv, 0, NULL, &args);
    if (!open_bus("ectwin-probe", args.iface))
        return EXIT_OPEN;
    int status = run(&args);
    ec_close();
    return status;
}
