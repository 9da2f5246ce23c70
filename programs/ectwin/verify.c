/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include <dirent.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

#include "bus/chain/catalogue.h"
#include "buses/bus_file.h"
#include "commands.h"
#include "facts/facts.h"
#include "network.h"
#include "products.h"
#include "reader/packet.h"
#include "sii_file.h"
#include "text/number.h"
#include "verify_network.h"

/* Exit statuses as of cmp. */
enum { SAME = 0, DIFFERENT = 1, TROUBLE = 2 };
enum { SETS_MOST = 64, SLAVES_MOST = 65535 };

typedef struct verify {
    ect_arena_t arena; /* names of sources */
    ect_facts_t sets[SETS_MOST];
    size_t count;
    char message[PRODUCT_MESSAGE];
} verify_t;

static ect_facts_t *new_set(verify_t *v, const char *operand, const char *part)
{
    ect_facts_t *set = &v->sets[v->count++];
    *set = (ect_facts_t){.source = ect_arena_print(&v->arena, "%s%s", operand, part)};
    return set;
}

/* --- sources ----------------------------------------------------------------------------------------------------- */

static bool add_image(verify_t *v, const char *operand, const char *part, const char *path)
{
    uint8_t *image = malloc(SII_FILE_MOST);
    long size = image != NULL ? sii_file_read(path, image, v->message, sizeof v->message) : -1;
    if (size >= 0)
        ect_facts_of_sii(new_set(v, operand, part), image, (size_t)size);
    free(image);
    return size >= 0;
}

static bool add_written_image(verify_t *v, const char *operand, const ect_device_t *device)
{
    uint8_t *image = sii_file_make(device, NULL, 0, v->message, sizeof v->message);
    if (image == NULL)
        return false;
    ect_facts_of_sii(new_set(v, operand, " EEPROM"), image, device->sii_size);
    free(image);
    return true;
}

/* Adds a description and its EEPROM. @param only_contained  no EEPROM unless the file contains one */
static bool add_device(verify_t *v, const char *operand, const char *name, bool only_contained)
{
    const ect_product_t *product = product_find(name, NULL, 0, ECT_BEHAVIOUR_BY_FILE, v->message);
    if (product == NULL)
        return false;
    /* The facts of a device file are those of its description. */
    const ect_esi_twin_t *twin = strncmp(name, "yaml:", 5) != 0 ? product_twin(product) : NULL;
    ect_facts_t *set = new_set(v, operand, "");
    if (twin != NULL)
        ect_facts_of_esi(set, product->device, ect_esi_twin_model(twin));
    else
        ect_facts_of_device(set, product->device);
    return (only_contained && product->device->sii == NULL) || add_written_image(v, operand, product->device);
}

/* --- a slave on the wire ----------------------------------------------------------------------------------------- */

/* A slave, its connection, and its EEPROM. */
typedef struct slave {
    ect_packet_t port;
    char why[ECT_PACKET_MESSAGE];
    ect_reader_link_t link;
    ect_reader_t reader;
    uint8_t image[ECT_READER_SII];
} slave_t;

static bool fail(verify_t *v, const char *operand, const char *why)
{
    (void)snprintf(v->message, sizeof v->message, "%s: %s", operand, why);
    return false;
}

static bool add_dictionary(verify_t *v, const char *operand, ect_reader_t *reader)
{
    char *json = NULL;
    size_t length = 0;
    FILE *file = open_memstream(&json, &length);
    if (file == NULL)
        return fail(v, operand, "no memory for the dictionary");
    const ect_reader_result_t result = ect_reader_json(reader, ECT_READER_IDENTITY_AND_PDOS, file);
    const bool written = fclose(file) == 0 && ect_facts_of_dictionary(new_set(v, operand, " dictionary"), json);
    free(json);
    if (result != ECT_READER_OK)
        return fail(v, operand, reader->text);
    return written || fail(v, operand, "no memory for the dictionary");
}

static bool read_slave(verify_t *v, const char *operand, slave_t *slave, uint16_t position)
{
    const ect_reader_config_t config = {.position = position};
    size_t size = 0;
    slave->link = ect_reader_packet_link(&slave->port);
    bool fine = ect_reader_open(&slave->reader, &slave->link, &config) == ECT_READER_OK &&
                ect_reader_sii(&slave->reader, slave->image, 0, &size) == ECT_READER_OK;
    if (fine) {
        ect_facts_of_sii(new_set(v, operand, " EEPROM"), slave->image, size);
        fine = add_dictionary(v, operand, &slave->reader);
    } else {
        (void)fail(v, operand, slave->reader.text);
    }
    ect_reader_close(&slave->reader);
    return fine;
}

/* Adds slave:IFACE[:N]. */
static bool add_slave(verify_t *v, const char *operand)
{
    const char *rest = strchr(operand, ':') + 1;
    const char *colon = strchr(rest, ':');
    const char *iface = colon != NULL ? ect_arena_copy(&v->arena, rest, (size_t)(colon - rest)) : rest;
    const char *number = colon != NULL ? colon + 1 : "1";
    uint64_t n = 0;
    if (!ect_number(number, 1, SLAVES_MOST, &n))
        return fail(v, operand, "the number of a slave is 1 to 65535: slave:IFACE[:N]");
    slave_t *slave = calloc(1, sizeof *slave);
    if (slave == NULL)
        return fail(v, operand, "no memory");
    bool fine = ect_packet_open(&slave->port, iface, slave->why) == 0;
    if (fine) {
        fine = read_slave(v, operand, slave, (uint16_t)(n - 1));
        ect_packet_close(&slave->port);
    } else {
        (void)fail(v, operand, slave->why);
    }
    free(slave);
    return fine;
}

/* --- the command ------------------------------------------------------------------------------------------------- */

static bool ends_with(const char *text, const char *end)
{
    size_t length = strlen(text);
    return length >= strlen(end) && strcasecmp(text + length - strlen(end), end) == 0;
}

static bool is_esi(const char *operand)
{
    const char *hash = strrchr(operand, '#'), *suffix = strcasestr(operand, ".xml");
    return ends_with(operand, ".xml") || (hash != NULL && suffix != NULL && suffix < hash);
}

static bool add(verify_t *v, const char *operand)
{
    if (v->count + 2 > SETS_MOST) {
        (void)snprintf(v->message, sizeof v->message, "more than %d sources at once", SETS_MOST / 2);
        return false;
    }
    if (strncmp(operand, "slave:", 6) == 0)
        return add_slave(v, operand);
    if (product_file(operand) != NULL)
        return add_device(v, operand, operand, false);
    if (is_esi(operand))
        return add_device(v, operand, ect_arena_print(&v->arena, "esi:%s", operand), true);
    if (ends_with(operand, ".bin") || ends_with(operand, ".hex") ||
        (ect_catalogue_find(operand) == NULL && !ect_bus_file_is(operand) && access(operand, F_OK) == 0))
        return add_image(v, operand, "", operand);
    return add_device(v, operand, operand, false);
}

typedef struct operands {
    const char **names;
    size_t count;
} operands_t;

static error_t parse(int key, char *text, struct argp_state *state)
{
    operands_t *operands = state->input;
    if (key == ARGP_KEY_ARG) {
        operands->names[operands->count++] = text;
        return 0;
    }
    if (key == ARGP_KEY_NO_ARGS)
        argp_error(state, "name what to compare: FILE.xml[#TYPE], FILE.bin, FILE.hex, DEVICE, slave:IFACE[:N]");
    return ARGP_ERR_UNKNOWN;
}

static int compare(verify_t *v)
{
    ect_facts_t known = {.source = v->sets[0].source};
    size_t lines = 0;
    for (size_t i = 0; i < v->count; i++)
        lines += ect_facts_compare(&known, &v->sets[i], stdout);
    ect_facts_free(&known);
    return lines > 0 ? DIFFERENT : SAME;
}

/* --- a clone ------------------------------------------------------------------------------------------------------ */

static void release(verify_t *v)
{
    for (size_t i = 0; i < v->count; i++)
        ect_facts_free(&v->sets[i]);
    ect_arena_free(&v->arena);
    v->count = 0;
}

/* Removes default values: those of a clone are the slave's values at the time of cloning. */
static void without_defaults(verify_t *v)
{
    for (size_t i = 0; i < v->count; i++) {
        for (size_t k = 0; k < v->sets[i].count; k++) {
            ect_fact_t *fact = &v->sets[i].list[k];
            fact->text = fact->kind == ECT_FACT_ENTRY_DEFAULT ? NULL : fact->text;
        }
    }
}

static size_t compare_two(const verify_t *v, size_t expected, size_t found)
{
    ect_facts_t known = {.source = v->sets[expected].source};
    const size_t lines = ect_facts_compare(&known, &v->sets[expected], stdout);
    const size_t more = ect_facts_compare(&known, &v->sets[found], stdout);
    ect_facts_free(&known);
    return lines + more;
}

/* EEPROM with EEPROM, dictionary with dictionary: where a slave's own differ, its file has both. */
static int compare_halves(verify_t *v)
{
    enum { FILE_DICTIONARY, FILE_EEPROM, SLAVE_EEPROM, SLAVE_DICTIONARY, HALVES };
    if (v->count != HALVES)
        return compare(v);
    const size_t lines = compare_two(v, FILE_DICTIONARY, SLAVE_DICTIONARY) + compare_two(v, FILE_EEPROM, SLAVE_EEPROM);
    return lines > 0 ? DIFFERENT : SAME;
}

/* Compares a file of the folder with its slave, whose number is the beginning of the file's name. */
static int compare_slave(verify_t *v, const char *folder, const char *name, const char *bus)
{
    char *file = NULL, *slave = NULL;
    int status = TROUBLE;
    if (asprintf(&file, "%s/%s", folder, name) < 0 || asprintf(&slave, "%s:%lu", bus, strtoul(name, NULL, 10)) < 0)
        (void)snprintf(v->message, sizeof v->message, "no memory left");
    else if (add(v, file) && add_slave(v, slave)) {
        without_defaults(v);
        status = compare_halves(v);
    }
    free(file);
    free(slave);
    if (status == TROUBLE)
        fprintf(stderr, "ectwin verify: %s\n", v->message);
    release(v);
    return status;
}

static int is_of_slave(const struct dirent *entry)
{
    return entry->d_name[0] >= '0' && entry->d_name[0] <= '9' && ends_with(entry->d_name, ".xml");
}

/* Compares a folder of `ectwin clone` with the bus slave:IFACE. */
static int compare_clone(verify_t *v, const char *folder, const char *bus)
{
    struct dirent **entries = NULL;
    int count = scandir(folder, &entries, is_of_slave, alphasort);
    int status = count > 0 ? SAME : TROUBLE;
    if (count <= 0)
        fprintf(stderr, "ectwin verify: '%s' has no files of 'ectwin clone'\n", folder);
    for (int i = 0; i < count; i++) {
        int one = compare_slave(v, folder, entries[i]->d_name, bus);
        status = one > status ? one : status;
        free(entries[i]);
    }
    free(entries);
    return status;
}

static bool is_folder(const char *path)
{
    struct stat status;
    return stat(path, &status) == 0 && S_ISDIR(status.st_mode);
}

static int compare_operands(verify_t *v, const operands_t *operands)
{
    if (network_path(operands->names[0]))
        return verify_network(network_path(operands->names[0]), operands->names + 1, operands->count - 1);
    if (operands->count == 2 && is_folder(operands->names[0]) && strncmp(operands->names[1], "slave:", 6) == 0)
        return compare_clone(v, operands->names[0], operands->names[1]);
    bool fine = true;
    for (size_t i = 0; i < operands->count && fine; i++)
        fine = add(v, operands->names[i]);
    if (fine && v->count < 2) {
        (void)snprintf(v->message, sizeof v->message, "'%s' is one source alone: name another one to compare it with",
                       operands->names[0]);
        fine = false;
    }
    if (!fine)
        fprintf(stderr, "ectwin verify: %s\n", v->message);
    return fine ? compare(v) : TROUBLE;
}

int command_verify(int argc, char **argv)
{
    static const struct argp argp = {
        .parser = parse,
        .args_doc = "A [B...]\nDIR slave:IFACE\neni:FILE.xml [FILE.xml...|DEVICE...|slave:IFACE]",
        .doc = "Compares the sources of a device: an ESI file (FILE.xml[#TYPE]), an EEPROM image (FILE.bin, "
               "FILE.hex), a DEVICE ('ectwin list' or esi:FILE.xml#TYPE) with its EEPROM, a slave on the wire "
               "(slave:IFACE[:N]) with its EEPROM and dictionary. The first source is the expectation; each further "
               "source adds the facts that the previous ones lack. Prints one line for each difference.\n"
               "With a folder of 'ectwin clone' and slave:IFACE: compares each slave of the bus with its file, "
               "except values.\n"
               "With a network file: compares its parts with each other, and plays its commands on twins of the ESI "
               "files, on a virtual clock, up to OP: states, SDO transfers, working counters. With slave:IFACE: "
               "compares number and identities of the slaves; the only writes are requests for the EEPROM.\v"
               "Exit codes: 0 no difference, 1 differences, 2 wrong usage, or a source cannot be read. Serial number "
               "and alias are not compared, because each slave has its own.",
    };
    operands_t operands = {.names = calloc((size_t)argc + 1, sizeof *operands.names)};
    verify_t *v = calloc(1, sizeof *v);
    if (operands.names == NULL || v == NULL)
        return TROUBLE;
    argp_err_exit_status = TROUBLE;
    argp_parse(&argp, argc, argv, 0, NULL, &operands);
    int status = compare_operands(v, &operands);
    release(v);
    free(operands.names);
    free(v);
    return status;
}
