/* SPDX-License-Identifier: MIT */
/* The slaves of a live bus as files: an ESI file a slave, and a bus file. */
#define _GNU_SOURCE
#include <errno.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "clone_blank.h"
#include "clone_note.h"
#include "commands.h"
#include "esc/personality.h"
#include "esi/image.h"
#include "esi/write.h"
#include "esi_dir.h"
#include "output.h"
#include "products.h"
#include "reader/packet.h"
#include "text/argument.h"
#include "text/state.h"
#include "wire/bytes.h"
#include "wire/registers.h"

static const char who[] = "ectwin clone";

enum { KEY_LIMIT = 0x200, KEY_PREOP, KEY_BESIDE, KEY_BLANK, KEY_ESI_DIR };
enum { FAILURES = 3, SECONDS_MOST = 86400, NAME = 24, MESSAGE = 600, PORTS = 4, LISTEN_MS = 500, INIT = 1 };

typedef struct args {
    const char *iface, *folder, *esi_dir;
    uint32_t limit_ms;
    bool preop, beside;
    unsigned int blank; /* CLONE_BLANK_... */
} args_t;

static const struct argp_option options[] = {
    {"interface", 'i', "IFACE", 0, "Network interface with the slaves (required)", 0},
    {"output", 'o', "DIR", 0, "Folder to create (required)", 0},
    {"preop", KEY_PREOP, NULL, 0,
     "Take slaves in INIT to PREOP for their dictionaries, and back to INIT (default: read their EEPROMs only)", 0},
    {"beside-master", KEY_BESIDE, NULL, 0,
     "Read even while another master uses the bus: each may receive replies of the other (default: refuse)", 0},
    {"blank", KEY_BLANK, "LIST", 0,
     "Leave out of the files: serial, alias, names (of the products), texts (that a master can write), separated by "
     "commas, or none (default serial)",
     0},
    {"esi-dir", KEY_ESI_DIR, "DIR", 0,
     "Take names and objects of a slave without SDO information from the ESI file in DIR that has its vendor, product "
     "and revision",
     0},
    {"limit", KEY_LIMIT, "SECONDS", 0, "Stop reading a slave after SECONDS, 1 to 86400 (default 600)", 0},
    {0},
};

/* The position of a slave in the tree. */
typedef struct place {
    uint8_t open; /* bit n: port n has a link and no child yet; port 0 excluded */
    uint16_t parent;
    unsigned int port; /* port of the parent; 0: the first slave */
} place_t;

/* The slave in progress, and the positions of the previous slaves. */
typedef struct clone {
    const args_t *args;
    ect_reader_link_t link;
    ect_reader_t reader;
    uint8_t image[ECT_READER_SII];
    ect_esi_t *esi;
    unsigned int objects, unread; /* `unread`: readable entries without a value */
    const ect_device_t *file;     /* from an ESI file, for a slave without SDO information; NULL: none */
    bool ignores;                 /* ignores the objects of the reader: `file` has more details */
    clone_note_t note;
    char time[32];     /* time of reading the slave */
    output_text_t bus; /* the bus file */
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
    case KEY_PREOP:
        args->preop = true;
        return 0;
    case KEY_BESIDE:
        args->beside = true;
        return 0;
    case KEY_BLANK:
        if (!clone_blank_parse(text, &args->blank))
            argp_error(state, "--blank takes serial, alias, names, texts, separated by commas, or none, not '%s'",
                       text);
        return 0;
    case KEY_ESI_DIR:
        args->esi_dir = text;
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

/* Copies bytes as a terminated string; a long name is truncated. */
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
    if (c->ignores)
        return;
    const ect_esi_found_object_t found = {.index = object->index,
                                          .described = object->described,
                                          .code = object->code,
                                          .name = text_of(object->name, name)};
    c->objects++;
    clone_note_object(&c->note, object);
    ect_esi_found_object(c->esi, &found);
}

/* The value of an entry after blanking, in `blanked`. */
static ect_reader_bytes_t value_of(const clone_t *c, const ect_reader_object_t *object, const ect_reader_entry_t *entry,
                                   uint8_t blanked[ECT_READER_VALUE])
{
    ect_reader_bytes_t value = entry->value.data ? entry->value : entry->preset;
    if (!value.data || value.length > ECT_READER_VALUE)
        return value;
    memcpy(blanked, value.data, value.length);
    clone_blank_value(c->args->blank, object->index, entry->subindex, entry->type, entry->access, blanked,
                      value.length);
    value.data = blanked;
    return value;
}

static void take_entry(void *ctx, const ect_reader_object_t *object, const ect_reader_entry_t *entry)
{
    char name[256];
    uint8_t blanked[ECT_READER_VALUE];
    clone_t *c = ctx;
    if (c->ignores)
        return;
    const ect_esi_found_entry_t found = {.subindex = entry->subindex,
                                         .type = entry->type,
                                         .bits = entry->bits,
                                         .access = entry->access,
                                         .name = text_of(entry->name, name),
                                         .unit = bytes_of(entry->unit),
                                         .minimum = bytes_of(entry->minimum),
                                         .maximum = bytes_of(entry->maximum),
                                         .value = bytes_of(value_of(c, object, entry, blanked))};
    c->unread += object->described && (entry->access & ECT_ACCESS_R_PREOP) != 0 && !entry->value.data;
    clone_note_entry(&c->note, object, entry);
    ect_esi_found_entry(c->esi, &found);
}

static void take_gap(void *ctx, const ect_reader_gap_t *gap)
{
    clone_t *c = ctx;
    if (!c->ignores)
        clone_note_gap(&c->note, gap);
}

/* --- the dictionary of an ESI file, for a slave without SDO information ------------------------------------------- */

/* A number of the dictionary in little-endian bytes. */
static ect_reader_bytes_t wire_of(int64_t number, uint16_t bits, uint8_t wire[8])
{
    ect_store_le64(wire, (uint64_t)number);
    return (ect_reader_bytes_t){.data = wire, .length = bits > 64 ? 8 : (bits + 7u) / 8};
}

static ect_reader_bytes_t name_of(const char *name)
{
    return (ect_reader_bytes_t){.data = (const uint8_t *)name, .length = name ? strlen(name) : 0};
}

/* Uploads an entry. @return false: the slave no longer replies */
static bool upload_value(clone_t *c, uint16_t index, uint8_t subindex, uint8_t *value, ect_reader_bytes_t *bytes)
{
    size_t size = ECT_READER_VALUE;
    const ect_reader_result_t result = ect_reader_upload(&c->reader, index, subindex, false, value, &size);
    const ect_reader_gap_t gap = {
        .index = index, .subindex = subindex, .value = true, .result = result, .code = c->reader.code};
    if (result == ECT_READER_OK)
        *bytes = (ect_reader_bytes_t){.data = value, .length = size};
    else
        take_gap(c, &gap);
    return result != ECT_READER_LOST && result != ECT_READER_STOPPED && c->reader.failures < FAILURES;
}

static bool take_file_entry(clone_t *c, const ect_od_t *od, const ect_reader_object_t *object, const ect_entry_t *from)
{
    uint8_t value[ECT_READER_VALUE], unit[8], minimum[8], maximum[8];
    const ect_detail_t *detail = ect_od_detail(od, object->index, (uint8_t)from->subindex);
    ect_reader_entry_t entry = {.subindex = (uint8_t)from->subindex,
                                .type = from->data_type,
                                .bits = ect_od_bits(od, from),
                                .access = from->access,
                                .name = name_of(from->name)};
    if (detail && (detail->unit != 0 || detail->per != 0))
        entry.unit = wire_of((int64_t)detail->unit << 16 | (int64_t)detail->per << 8, 32, unit);
    if (detail && detail->minimum != detail->maximum) {
        entry.minimum = wire_of(detail->minimum, entry.bits, minimum);
        entry.maximum = wire_of(detail->maximum, entry.bits, maximum);
    }
    const bool readable = (entry.access & ECT_ACCESS_R_PREOP) != 0;
    const bool more = !readable || upload_value(c, object->index, entry.subindex, value, &entry.value);
    take_entry(c, object, &entry);
    return more;
}

/* @return EXIT_CLEAN · EXIT_RUN: the slave no longer replies */
static int take_file(clone_t *c, const ect_device_t *device)
{
    const ect_od_t od = ect_device_od(device, NULL);
    c->ignores = false;
    for (uint16_t i = 0; i < device->object_count; i++) {
        const ect_object_t *from = &od.objects[i];
        const ect_reader_object_t object = {
            .index = from->index, .described = true, .code = (uint8_t)from->object_code, .name = name_of(from->name)};
        take_object(c, &object);
        for (const ect_entry_t *entry = from->entries; entry; entry = ect_od_next(from, entry)) {
            if (!take_file_entry(c, &od, &object, entry))
                return EXIT_RUN;
        }
    }
    return EXIT_CLEAN;
}

/* The device of the ESI file with the identity of the slave. */
static const ect_device_t *find_file(const clone_t *c)
{
    char message[PRODUCT_MESSAGE] = "no file has its vendor, product and revision";
    char *name = NULL;
    const ect_identity_t identity = {
        .vendor_id = c->reader.vendor, .product_code = c->reader.product, .revision = c->reader.revision};
    const unsigned int number = c->reader.config.position + 1u;
    const ect_product_t *product = NULL;
    if (esi_dir_search(c->args->esi_dir, &identity, &name, 1, message) && name)
        product = product_find(name, NULL, 0, ECT_BEHAVIOUR_BY_FILE, message);
    if (product) {
        fprintf(stderr, "%s: slave %u: no SDO information: names and objects from %s\n", who, number, name + 4);
        fprintf(c->note.lines.file, "No SDO information: names and objects are those of an ESI file.\n");
    } else {
        fprintf(stderr, "%s: slave %u: no SDO information: %s\n", who, number, message);
    }
    free(name);
    return product ? product->device : NULL;
}

/* Called before the first object. */
static void take_begin(void *ctx, bool described)
{
    clone_t *c = ctx;
    const bool searches = !described && c->args->esi_dir && (c->reader.protocols & ECT_MAILBOX_COE) != 0 &&
                          c->reader.result != ECT_READER_DECLINED;
    c->file = searches ? find_file(c) : NULL;
    c->ignores = c->file != NULL;
}

/* --- chip and position -------------------------------------------------------------------------------------------- */

/* The known chip with the same type, FMMUs, SyncManagers and RAM; NULL: none. */
static const char *chip_of(const uint8_t *info)
{
    const ect_esc_personality_t *p;
    for (size_t i = 0; (p = ect_esc_personality_at(i)) != NULL; i++) {
        if (info[0] == p->type && info[4] == p->fmmu_count && info[5] == p->sm_count && info[6] == p->ram_kb)
            return p->name;
    }
    return NULL;
}

/* A frame leaves a slave by ports 3, 1, 2 in this order (ETG.1000.4); the parent is the last slave with a free port. */
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
    for (unsigned int i = 1; i < PORTS; i++) /* communication established: bit 9 + 2 * port */
        c->places[n].open |= (uint8_t)(((unsigned int)status[1] >> (2 * i + 1) & 1u) << i);
}

/* Only for a slave that is not connected to port 1 of the previous slave. */
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

/* Inserts the comment into the file. */
static char *join_note(clone_t *c, const char *file, size_t size, size_t *length)
{
    char *head = NULL, blanks[40];
    const ect_reader_t *r = &c->reader;
    if (asprintf(&head,
                 "Slave %u on %s, cloned by ectwin " ECTWIN_VERSION ", read in %s at %s.\n"
                 "Defaults are the values of that time, not those of the vendor.\n"
                 "The application of the slave is not cloned.\nBlanked: %s.\n",
                 r->config.position + 1u, c->args->iface, r->brought_up ? "PREOP" : ect_state_text(r->found_status),
                 c->time, clone_blank_text(c->args->blank, blanks)) < 0)
        return NULL;
    char *noted = clone_note_join(who, &c->note, head, file, size, length);
    free(head);
    return noted;
}

static int write_esi(clone_t *c, const ect_esi_twin_t *twin, const char *name)
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
    char *noted = file ? join_note(c, file, length, &length) : NULL;
    if (noted && output_path(who, path, c->args->folder, name))
        status = output_save(who, path, noted, length);
    free(noted);
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
    c->esi = NULL; /* owned by the twin, or closed */
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
        printf(", %u %s without a value", c->unread, c->unread == 1 ? "entry" : "entries");
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

/* @return EXIT_CLEAN · EXIT_RUN: incomplete, which is printed */
static int read_dictionary(clone_t *c, uint16_t n)
{
    const ect_reader_sink_t sink = {
        .ctx = c, .begin = take_begin, .object = take_object, .entry = take_entry, .gap = take_gap};
    c->objects = c->unread = 0;
    const ect_reader_result_t result = ect_reader_dictionary(&c->reader, ECT_READER_ALL_VALUES, &sink);
    if (result == ECT_READER_OK && (!c->file || take_file(c, c->file) == EXIT_CLEAN))
        return EXIT_CLEAN;
    if (result != ECT_READER_DECLINED)
        return fail(c, n, "dictionary, read in part");
    fprintf(stderr, "%s: slave %u: without its dictionary: %s%s\n", who, n + 1u, c->reader.text,
            (c->reader.found_status & ECT_AL_STATE_MASK) == INIT ? ": --preop takes it to PREOP and back" : "");
    return EXIT_RUN;
}

static int read_noted(clone_t *c, uint16_t n, size_t size)
{
    char prefix[64];
    const int status = read_dictionary(c, n);
    (void)snprintf(prefix, sizeof prefix, "%s: slave %u: EEPROM and ", who, n + 1u);
    clone_note_compare(&c->note, c->image, size, &c->reader, prefix);
    ect_esi_found_end(c->esi);
    const int written = write_slave(c, n, size);
    if (written == EXIT_CLEAN)
        find_place(c, n);
    return written != EXIT_CLEAN ? written : status;
}

static int read_slave(clone_t *c, uint16_t n)
{
    char why[MESSAGE];
    size_t size = 0;
    clone_note_time(c->time);
    if (ect_reader_sii(&c->reader, c->image, 0, &size) != ECT_READER_OK)
        return fail(c, n, "EEPROM");
    clone_blank_image(c->args->blank, c->image, size);
    c->esi = ect_esi_of_image("EEPROM", c->image, size, why, sizeof why);
    if (!c->esi) {
        fprintf(stderr, "%s: slave %u: %s\n", who, n + 1u, why);
        return EXIT_RUN;
    }
    const int status = clone_note_begin(who, &c->note) ? read_noted(c, n, size) : EXIT_RUN;
    ect_esi_close(c->esi); /* left open if the note could not be begun */
    c->esi = NULL;
    clone_note_free(&c->note);
    return status;
}

static int clone_slave(clone_t *c, uint16_t n)
{
    const ect_reader_config_t config = {.position = n,
                                        .limit_ms = c->args->limit_ms,
                                        .changes = c->args->preop ? ECT_READER_CHANGES_INIT : ECT_READER_CHANGES_NONE,
                                        .progress = show_progress,
                                        .progress_ctx = c};
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
    clone_note_time(c->time);
    fprintf(c->bus.file,
            "# The bus on %s, cloned by ectwin " ECTWIN_VERSION " at %s: values are those of that time,\n"
            "# and the applications of the slaves are not cloned.\nectwin: 1\ntwins:\n",
            c->args->iface, c->time);
    uint32_t n = 0;
    do { /* opening the first slave sets the count */
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

static bool is_free(ect_packet_t *port, const args_t *args)
{
    const ect_reader_link_t link = ect_reader_packet_link(port);
    if (args->beside || !ect_reader_hears_master(&link, LISTEN_MS))
        return true;
    fprintf(stderr,
            "%s: a master is active on '%s', and each would fetch replies of the other: stop it first, or read with "
            "--beside-master\n",
            who, args->iface);
    return false;
}

static int clone_bus(ect_packet_t *port, const args_t *args)
{
    clone_t *c = calloc(1, sizeof *c);
    int status = c ? EXIT_OPEN : EXIT_RUN;
    if (c && make_folder(args->folder)) {
        c->args = args;
        c->link = ect_reader_packet_link(port);
        status = clone_all(c);
        free(c->places);
    }
    free(c);
    return status;
}

int command_clone(int argc, char **argv)
{
    static const struct argp argp = {
        .options = options,
        .parser = parse,
        .doc = "Reads every slave of a live bus and writes a folder: an ESI file for each slave, with its EEPROM, its "
               "dictionary and its present values, and bus.yaml, which 'ectwin run' and 'ectwin with' start.\v"
               "With --preop a slave in INIT goes to PREOP, and back to INIT at the end; any other state is kept. The "
               "only writes are mailbox requests, the registers of the EEPROM interface, and with --preop AL control "
               "and SyncManagers 0 and 1. Error counters are kept; reading clears events (0210h bit 2). Another master "
               "on the interface is an error; the command listens for half a second to detect one.\n"
               "\n"
               "The file of a slave begins with a comment: the state and time of reading, the items that the slave did "
               "not supply, and the differences between its EEPROM and its dictionary. SOURCE_DATE_EPOCH of the "
               "environment replaces the time.\n"
               "\n"
               "Exit codes: 0 all slaves were read, 1 wrong usage, 2 the interface or the folder cannot be opened, or "
               "another master is active, 3 a slave was not read, or not completely.",
    };
    args_t args = {.limit_ms = 600000, .blank = CLONE_BLANK_SERIAL};
    char message[ECT_PACKET_MESSAGE];
    ect_packet_t port;
    argp_parse(&argp, argc, argv, 0, NULL, &args);
    if (ect_packet_open(&port, args.iface, message) < 0) {
        fprintf(stderr, "%s: %s\n", who, message);
        return EXIT_OPEN;
    }
    const int status = is_free(&port, &args) ? clone_bus(&port, &args) : EXIT_OPEN;
    ect_packet_close(&port);
    return status;
}
