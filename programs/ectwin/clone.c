/* SPDX-License-Identifier: MIT */
/* The slaves of a live bus as files: an ESI file a slave, and a bus file. */
#define _GNU_SOURCE
#include <errno.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "commands.h"
#include "esc/personality.h"
#include "esi/image.h"
#include "esi/write.h"
#include "output.h"
#include "reader/packet.h"
#include "text/argument.h"
#include "wire/registers.h"

static const char who[] = "ectwin clone";

enum { KEY_LIMIT = 0x200, SECONDS_MOST = 86400, NAME = 24, MESSAGE = 600, PORTS = 4 };

typedef struct args {
    const char *iface, *folder;
    uint32_t limit_ms;
} args_t;

static const struct argp_option options[] = {
    {"interface", 'i', "IFACE", 0, "Network interface with the slaves (required)", 0},
    {"output", 'o', "DIR", 0, "Folder to make (required)", 0},
    {"limit", KEY_LIMIT, "SECONDS", 0, "Stop reading a slave after SECONDS, 1 to 86400 (default 600)", 0},
    {0},
};

/* The place of a slave on the bus. */
typedef struct place {
    uint8_t open; /* ports behind port 0 with a link that no slave hangs at yet, a bit each */
    uint16_t parent;
    unsigned int port; /* of the parent; 0: the first slave */
} place_t;

/* The slave that is being read, and what is known of those before it. */
typedef struct clone {
    const args_t *args;
    ect_reader_link_t link;
    ect_reader_t reader;
    uint8_t image[ECT_READER_SII];
    ect_esi_t *esi;
    unsigned int objects, unread; /* entries that are readable and gave no value */
    output_text_t bus;            /* the bus file */
    place_t *places;
    uint16_t count, written;
} clone_t;

static error_t parse(int key, char *text, struct argp_state *state)
{
    args_t *args = state->input;
    switch (key) {
    case 'i':
        args->iface = text;
        return 0;
    case 'o':
        args->folder = text;
        return 0;
    case KEY_LIMIT:
        args->limit_ms = 1000 * (uint32_t)ect_argument_number(state, "--limit", text, 1, SECONDS_MOST);
        return 0;
    case ARGP_KEY_END:
        if (!args->iface || !args->folder)
            argp_error(state, "name the interface and the folder: -i IFACE -o DIR");
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static bool show_progress(void *ctx, const char *what, unsigned int done, unsigned int all)
{
    const clone_t *c = ctx;
    if (isatty(STDERR_FILENO))
        fprintf(stderr, "\rslave %u: %s %u of %u \r", c->reader.config.position + 1u, what, done, all);
    return true;
}

/* --- the dictionary ----------------------------------------------------------------------------------------------- */

/* A copy with a zero behind it; longer names are cut. */
static const char *text_of(ect_reader_bytes_t bytes, char text[256])
{
    size_t length = bytes.data && bytes.length < 255 ? bytes.length : bytes.data ? 255 : 0;
    memcpy(text, bytes.data ? (const char *)bytes.data : "", length);
    text[length] = '\0';
    return text;
}

static ect_esi_bytes_t bytes_of(ect_reader_bytes_t bytes)
{
    return (ect_esi_bytes_t){.bytes = bytes.data, .length = bytes.length};
}

static void take_object(void *ctx, const ect_reader_object_t *object)
{
    char name[256];
    clone_t *c = ctx;
    const ect_esi_found_object_t found = {.index = object->index,
                                          .described = object->described,
                                          .code = object->code,
                                          .name = text_of(object->name, name)};
    c->objects++;
    ect_esi_found_object(c->esi, &found);
}

static void take_entry(void *ctx, const ect_reader_object_t *object, const ect_reader_entry_t *entry)
{
    char name[256];
    clone_t *c = ctx;
    const ect_esi_found_entry_t found = {.subindex = entry->subindex,
                                         .type = entry->type,
                                         .bits = entry->bits,
                                         .access = entry->access,
                                         .name = text_of(entry->name, name),
                                         .unit = bytes_of(entry->unit),
                                         .minimum = bytes_of(entry->minimum),
                                         .maximum = bytes_of(entry->maximum),
                                         .value = bytes_of(entry->value.data ? entry->value : entry->preset)};
    c->unread += object->described && (entry->access & ECT_ACCESS_R_PREOP) != 0 && !entry->value.data;
    ect_esi_found_entry(c->esi, &found);
}

/* --- chip and place ----------------------------------------------------------------------------------------------- */

/* The chip of ours with the same type and units; NULL: none. */
static const char *chip_of(const uint8_t *info)
{
    const ect_esc_personality_t *p;
    for (size_t i = 0; (p = ect_esc_personality_at(i)) != NULL; i++) {
        if (info[0] == p->type && info[4] == p->fmmu_count && info[5] == p->sm_count && info[6] == p->ram_kb)
            return p->name;
    }
    return NULL;
}

/* Frames leave a slave by port 3, then 1, then 2 (ETG.1000.4); the slave hangs at the first such port that is free. */
static void find_parent(clone_t *c, uint16_t n)
{
    static const unsigned int order[] = {3, 1, 2};
    for (uint16_t m = n; m-- > 0;) {
        for (unsigned int i = 0; i < 3; i++) {
            if ((c->places[m].open & 1u << order[i]) == 0)
                continue;
            c->places[m].open &= (uint8_t)~(1u << order[i]);
            c->places[n].parent = m;
            c->places[n].port = order[i];
            return;
        }
    }
}

static void find_place(clone_t *c, uint16_t n)
{
    uint8_t info[8], status[2];
    find_parent(c, n);
    if (ect_reader_registers(&c->reader, ECT_REG_TYPE, info, sizeof info) == ECT_READER_OK && chip_of(info))
        fprintf(c->bus.file, "    esc: %s\n", chip_of(info));
    if (ect_reader_registers(&c->reader, ECT_REG_DL_STATUS, status, sizeof status) != ECT_READER_OK)
        return;
    for (unsigned int i = 1; i < PORTS; i++) /* communication established, a bit a port from bit 9 on */
        c->places[n].open |= (uint8_t)(((unsigned int)status[1] >> (2 * i + 1) & 1u) << i);
}

/* Only where a slave does not hang at port 1 of the one before. */
static void write_wires(const clone_t *c)
{
    const char *before = "wire: [";
    for (uint32_t n = 1; n < c->count; n++) {
        const place_t *place = &c->places[n];
        if (place->port == 0 || (place->parent == n - 1 && place->port == 1))
            continue;
        fprintf(c->bus.file, "%s'%u:%u.%u'", before, n + 1, place->parent + 1u, place->port);
        before = ", ";
    }
    fputs(*before == ',' ? "]\n" : "", c->bus.file);
}

/* --- files -------------------------------------------------------------------------------------------------------- */

/* "01-el1008.xml" */
static void file_name(const clone_t *c, uint16_t n, const char *type, char name[NAME + 16])
{
    int width = c->count >= 1000 ? 5 : c->count >= 100 ? 3 : 2;
    int used = snprintf(name, NAME, "%0*u-", width, n + 1u);
    for (; *type && used < NAME - 1; type++) {
        char letter = (char)(*type >= 'A' && *type <= 'Z' ? *type - 'A' + 'a' : *type);
        bool plain = (letter >= 'a' && letter <= 'z') || (letter >= '0' && letter <= '9');
        if (plain || name[used - 1] != '-')
            name[used++] = plain ? letter : '-';
    }
    used -= name[used - 1] == '-';
    strcpy(name + used, ".xml");
}

static int write_esi(const clone_t *c, const ect_esi_twin_t *twin, const char *name)
{
    char path[OUTPUT_PATH], why[200];
    ect_arena_t arena = {0};
    size_t length;
    const ect_product_t *product = ect_esi_twin_product(twin);
    const ect_esi_part_t part = {.device = product->device, .plant = product->plant, .twin = twin};
    const char *file = ect_esi_write(&arena, &part, 1, &length, why, sizeof why);
    int status = EXIT_RUN;
    if (!file)
        fprintf(stderr, "%s: %s: %s\n", who, name, why);
    else if (output_path(who, path, c->args->folder, name))
        status = output_save(who, path, file, length);
    ect_arena_free(&arena);
    return status;
}

static void print_notes(const ect_esi_twin_t *twin, uint16_t n)
{
    size_t count;
    const char *const *notes = ect_esi_twin_notes(twin, &count);
    for (size_t i = 0; i < count; i++)
        fprintf(stderr, "%s: slave %u: %s\n", who, n + 1u, notes[i]);
}

static int write_slave(clone_t *c, uint16_t n, size_t image_size)
{
    char why[MESSAGE], name[NAME + 16];
    ect_esi_twin_t *twin = ect_esi_twin_take(c->esi, "", NULL, 0, why, sizeof why);
    c->esi = NULL; /* the twin's, or closed */
    if (!twin) {
        fprintf(stderr, "%s: slave %u: no twin can be made of it: %s\n", who, n + 1u, why);
        return EXIT_RUN;
    }
    const ect_esi_device_t *model = ect_esi_twin_model(twin);
    file_name(c, n, model->type, name);
    print_notes(twin, n);
    int status = write_esi(c, twin, name);
    printf("%u %s @0x%08" PRIX32 "/0x%08" PRIX32 ": EEPROM %zu bytes, %u objects, %zu PDOs", n + 1u, model->type,
           model->product_code, model->revision, image_size, c->objects, model->pdo_count);
    if (c->unread > 0)
        printf(", %u entries without a value", c->unread);
    printf("\n");
    fprintf(c->bus.file, "  - device: 'esi:%s'\n    name: slave%u\n", name, n + 1u);
    if (status == EXIT_CLEAN)
        c->written++;
    ect_esi_twin_free(twin);
    return status;
}

/* --- slaves ------------------------------------------------------------------------------------------------------- */

static int fail(const clone_t *c, uint16_t n, const char *part)
{
    fprintf(stderr, "%s: slave %u: %s: %s\n", who, n + 1u, part, c->reader.text);
    return EXIT_RUN;
}

static int read_slave(clone_t *c, uint16_t n)
{
    char why[MESSAGE];
    size_t size = 0;
    int status = EXIT_CLEAN;
    const ect_reader_sink_t sink = {.ctx = c, .object = take_object, .entry = take_entry};
    if (ect_reader_sii(&c->reader, c->image, 0, &size) != ECT_READER_OK)
        return fail(c, n, "EEPROM");
    c->esi = ect_esi_of_image("EEPROM", c->image, size, why, sizeof why);
    if (!c->esi) {
        fprintf(stderr, "%s: slave %u: %s\n", who, n + 1u, why);
        return EXIT_RUN;
    }
    c->objects = c->unread = 0;
    if (ect_reader_dictionary(&c->reader, ECT_READER_ALL_VALUES, &sink) != ECT_READER_OK)
        status = fail(c, n, "dictionary, read in part");
    ect_esi_found_end(c->esi);
    int written = write_slave(c, n, size);
    if (written == EXIT_CLEAN)
        find_place(c, n);
    return written != EXIT_CLEAN ? written : status;
}

static int clone_slave(clone_t *c, uint16_t n)
{
    const ect_reader_config_t config = {
        .position = n, .limit_ms = c->args->limit_ms, .progress = show_progress, .progress_ctx = c};
    int status = ect_reader_open(&c->reader, &c->link, &config) == ECT_READER_OK ? EXIT_CLEAN : fail(c, n, "EEPROM");
    c->count = n == 0 ? c->reader.count : c->count;
    if (n == 0)
        c->places = calloc((size_t)c->count + 1, sizeof *c->places);
    if (status == EXIT_CLEAN)
        status = c->places ? read_slave(c, n) : EXIT_RUN;
    ect_reader_close(&c->reader);
    return status;
}

static int clone_all(clone_t *c)
{
    char path[OUTPUT_PATH];
    int status = EXIT_CLEAN;
    if (!output_open(who, &c->bus))
        return EXIT_RUN;
    fprintf(c->bus.file, "# The bus on %s, cloned by ectwin " ECTWIN_VERSION ".\nectwin: 1\ntwins:\n", c->args->iface);
    uint32_t n = 0;
    do { /* the first slave that is opened counts them */
        int one = clone_slave(c, (uint16_t)n);
        status = one != EXIT_CLEAN ? one : status;
    } while (++n < c->count);
    if (c->written == c->count)
        write_wires(c);
    else
        fprintf(c->bus.file, "# Without %u of the %u slaves of the bus, and without its wires.\n",
                c->count - c->written, c->count);
    if (!output_path(who, path, c->args->folder, "bus.yaml"))
        return EXIT_OPEN;
    int written = output_close(who, &c->bus, path);
    return written != EXIT_CLEAN ? written : status;
}

static bool make_folder(const char *folder)
{
    if (mkdir(folder, 0777) == 0)
        return true;
    fprintf(stderr, "%s: '%s': %s%s\n", who, folder, strerror(errno),
            errno == EEXIST ? ": name a folder that is not there yet" : "");
    return false;
}

int command_clone(int argc, char **argv)
{
    static const struct argp argp = {
        .options = options,
        .parser = parse,
        .doc =
            "Reads every slave of a live bus and writes a folder: an ESI file a slave, with its EEPROM, its dictionary "
            "and "
            "the values that it has now, and bus.yaml, which 'ectwin run' and 'ectwin with' start.\v"
            "A slave in INIT goes to PREOP, and back to INIT at the end; a slave in another state stays there. Nothing "
            "is written but mailbox requests and the EEPROM interface. End the master first: both would take replies "
            "of the other.\n\n"
            "Exit codes: 0 all was read, 1 wrong usage, 2 the interface or the folder cannot be opened, 3 a slave "
            "could "
            "not be read, or not completely.",
    };
    args_t args = {.limit_ms = 600000};
    char message[ECT_PACKET_MESSAGE];
    ect_packet_t port;
    argp_parse(&argp, argc, argv, 0, NULL, &args);
    if (ect_packet_open(&port, args.iface, message) < 0) {
        fprintf(stderr, "%s: %s\n", who, message);
        return EXIT_OPEN;
    }
    clone_t *c = calloc(1, sizeof *c);
    int status = c ? EXIT_OPEN : EXIT_RUN;
    if (c && make_folder(args.folder)) {
        c->args = &args;
        c->link = ect_reader_packet_link(&port);
        status = clone_all(c);
        free(c->places);
    }
    free(c);
    ect_packet_close(&port);
    return status;
}
