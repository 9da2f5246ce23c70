/* SPDX-License-Identifier: MIT */
/* `ectwin clone` without a wire: the test has the functions of the reader, with the replies of any slave. */
#define _GNU_SOURCE
#include "command_lines.h"

#include <dirent.h>
#include <sys/stat.h>

#include "bus/net/packet.h"
#include "devices/fzm1/fzm1.h"
#include "esc/personality.h"
#include "esi_dir.h"
#include "products.h"
#include "reader/packet.h"
#include "reader/reader.h"
#include "sii/sii.h"
#include "support/gauge.h"
#include "wire/bytes.h"
#include "wire/registers.h"

enum { SLAVES_MOST = 6, OBJECTS_MOST = 6, UPLOADS_MOST = 4, LEAVES = 99, FILE_ROOM = 1 << 17 };
enum { INIT = 1, PREOP = 2, SAFEOP = 4, LISTEN_MS = 500, DEFAULT_LIMIT_MS = 600000 };

#define COMMAND "clone -i w -o out "

/* Object or entry that the dictionary of a slave has. */
typedef struct found {
    uint16_t index;
    bool undescribed;
    const char *name;
    size_t name_length; /* 0: as `name` has it */
    uint8_t subindex;
    uint16_t type, bits, access;
    const char *value, *preset;
    size_t value_length; /* 0: as `value` has it */
} found_t;

/* The slaves of a run. */
typedef struct bus {
    const ect_device_t *device;     /* NULL: gauge */
    const char *type;               /* NULL: that of the device */
    uint16_t count;                 /* 0: one */
    uint16_t leave;                 /* the command ends before slave n, from 0; 0: it does not */
    uint8_t status[SLAVES_MOST][2]; /* DL status */
    uint8_t info[8];                /* first registers */
    bool no_info, no_status;
    ect_reader_result_t open, sii, dictionary;
    uint16_t found_status; /* AL status */
    bool brought_up, undescribed, no_coe, declined, empty_image, hears, no_link, terminal;
    found_t found[OBJECTS_MOST];
    const char *esi_dir; /* result of the search: a name; NULL: none */
    bool esi_dir_fails;
    ect_reader_result_t uploads[UPLOADS_MOST]; /* of the first ones; then ECT_READER_OK */
    unsigned int failures;                     /* after an upload that fails */
    uint32_t limit_ms;                         /* expected */
    ect_reader_changes_t changes;              /* expected */
} bus_t;

static bus_t bus;
static unsigned int uploads;

/* --- functions of other rooms ------------------------------------------------------------------------------------- */

int __wrap_ect_packet_open(ect_packet_t *port, const char *iface, char *message);
void __wrap_ect_packet_close(ect_packet_t *port);
ect_reader_link_t __wrap_ect_reader_packet_link(ect_packet_t *port);
bool __wrap_ect_reader_hears_master(const ect_reader_link_t *link, uint32_t ms);
ect_reader_result_t __wrap_ect_reader_open(ect_reader_t *r, const ect_reader_link_t *link,
                                           const ect_reader_config_t *config);
void __wrap_ect_reader_close(ect_reader_t *r);
ect_reader_result_t __wrap_ect_reader_sii(ect_reader_t *r, uint8_t *image, size_t size, size_t *read);
ect_reader_result_t __wrap_ect_reader_registers(ect_reader_t *r, uint16_t address, void *data, uint16_t length);
ect_reader_result_t __wrap_ect_reader_upload(ect_reader_t *r, uint16_t index, uint8_t subindex, bool complete,
                                             void *data, size_t *size);
ect_reader_result_t __wrap_ect_reader_dictionary(ect_reader_t *r, ect_reader_values_t values,
                                                 const ect_reader_sink_t *sink);
int __wrap_isatty(int fd);
bool __wrap_esi_dir_search(const char *folder, const ect_identity_t *identities, char **names, size_t count,
                           char *message);

int __wrap_ect_packet_open(ect_packet_t *port, const char *iface, char *message)
{
    memset(port, 0, sizeof *port);
    if (!bus.no_link && strcmp(iface, "w") == 0)
        return 0;
    strcpy(message, "no link");
    return -1;
}

void __wrap_ect_packet_close(ect_packet_t *port)
{
    (void)port;
    fputs("closed\n", stderr);
}

ect_reader_link_t __wrap_ect_reader_packet_link(ect_packet_t *port)
{
    return (ect_reader_link_t){.ctx = port};
}

bool __wrap_ect_reader_hears_master(const ect_reader_link_t *link, uint32_t ms)
{
    (void)link;
    fprintf(stderr, "listens for %u ms\n", (unsigned int)ms);
    return bus.hears;
}

ect_reader_result_t __wrap_ect_reader_open(ect_reader_t *r, const ect_reader_link_t *link,
                                           const ect_reader_config_t *config)
{
    const ect_device_t *device = bus.device ? bus.device : &gauge;
    memset(r, 0, sizeof *r);
    if (bus.leave > 0 && config->position >= bus.leave)
        _exit(LEAVES);
    if (config->limit_ms != (bus.limit_ms > 0 ? bus.limit_ms : DEFAULT_LIMIT_MS) || config->changes != bus.changes)
        fprintf(stderr, "limit %u, changes %d\n", (unsigned int)config->limit_ms, config->changes);
    r->link = link;
    r->config = *config;
    r->count = bus.count > 0 ? bus.count : 1;
    r->vendor = device->identity.vendor_id;
    r->product = device->identity.product_code;
    r->revision = device->identity.revision;
    r->protocols = bus.no_coe ? ECT_MAILBOX_EOE : ECT_MAILBOX_COE | ECT_MAILBOX_FOE;
    r->found_status = bus.found_status > 0 ? bus.found_status : PREOP;
    r->brought_up = bus.brought_up;
    strcpy(r->text, "the reason");
    if (!config->progress(config->progress_ctx, "things", 3, 7))
        fputs("stopped\n", stderr);
    return bus.open;
}

void __wrap_ect_reader_close(ect_reader_t *r)
{
    (void)r;
}

ect_reader_result_t __wrap_ect_reader_sii(ect_reader_t *r, uint8_t *image, size_t size, size_t *read)
{
    ect_device_t device = *(bus.device ? bus.device : &gauge);
    (void)r;
    (void)size;
    if (bus.type)
        device.type_name = bus.type;
    *read = device.sii_size;
    memset(image, 0xFF, *read);
    if (bus.empty_image)
        memset(image, 0, *read);
    else if (ect_sii_write(&device, &device.identity, 7, image, *read) < 0)
        fputs("no image\n", stderr);
    return bus.sii;
}

ect_reader_result_t __wrap_ect_reader_registers(ect_reader_t *r, uint16_t address, void *data, uint16_t length)
{
    if (address == ECT_REG_TYPE && length == sizeof bus.info)
        memcpy(data, bus.info, length);
    else if (address == ECT_REG_DL_STATUS && length == 2)
        memcpy(data, bus.status[r->config.position], length);
    else
        fprintf(stderr, "registers at %04X, %u bytes\n", address, length);
    return (address == ECT_REG_TYPE ? bus.no_info : bus.no_status) ? ECT_READER_LOST : ECT_READER_OK;
}

ect_reader_result_t __wrap_ect_reader_upload(ect_reader_t *r, uint16_t index, uint8_t subindex, bool complete,
                                             void *data, size_t *size)
{
    const ect_reader_result_t result = uploads < UPLOADS_MOST ? bus.uploads[uploads] : ECT_READER_OK;
    if (complete || *size != ECT_READER_VALUE)
        fprintf(stderr, "upload of %04X:%02X, %zu bytes, complete: %d\n", index, subindex, *size, complete);
    const uint32_t identity[] = {4, r->vendor, r->product, r->revision, 1};
    *size = 4;
    if (index < 0x2000) {
        ect_store_le32(data, index == 0x1018 ? identity[subindex] : 0);
        return ECT_READER_OK;
    }
    uploads++;
    r->failures = result == ECT_READER_OK ? 0 : bus.failures;
    r->code = 0x0601;
    ect_store_le32(data, 1);
    return result;
}

static ect_reader_bytes_t bytes_of(const char *text, size_t length)
{
    return (ect_reader_bytes_t){.data = (const uint8_t *)text, .length = length > 0 || !text ? length : strlen(text)};
}

ect_reader_result_t __wrap_ect_reader_dictionary(ect_reader_t *r, ect_reader_values_t values,
                                                 const ect_reader_sink_t *sink)
{
    if (values != ECT_READER_ALL_VALUES)
        fputs("not all values\n", stderr);
    r->result = bus.declined ? ECT_READER_DECLINED : ECT_READER_OK;
    sink->begin(sink->ctx, !bus.undescribed);
    for (size_t i = 0; i < OBJECTS_MOST && bus.found[i].index != 0; i++) {
        const found_t *f = &bus.found[i];
        const ect_reader_object_t object = {.index = f->index,
                                            .described = !f->undescribed,
                                            .most = f->subindex,
                                            .code = f->subindex > 0 ? 9 : 7,
                                            .name = bytes_of(f->name, f->name_length)};
        const ect_reader_entry_t entry = {.subindex = f->subindex,
                                          .type = f->type,
                                          .bits = f->bits,
                                          .access = f->access,
                                          .name = bytes_of(f->name, f->name_length),
                                          .preset = bytes_of(f->preset, 0),
                                          .value = bytes_of(f->value, f->value_length)};
        sink->object(sink->ctx, &object);
        sink->entry(sink->ctx, &object, &entry);
    }
    return bus.dictionary;
}

int __wrap_isatty(int fd)
{
    return bus.terminal && fd == STDERR_FILENO;
}

bool __wrap_esi_dir_search(const char *folder, const ect_identity_t *identities, char **names, size_t count,
                           char *message)
{
    if (strcmp(folder, "files") != 0 || count != 1 || *names || identities->vendor_id != ECTWIN_VENDOR_ID ||
        identities->product_code != gauge.identity.product_code || identities->revision != gauge.identity.revision)
        fprintf(stderr, "search in %s for %zu\n", folder, count);
    if (bus.esi_dir)
        *names = strdup(bus.esi_dir);
    if (bus.esi_dir_fails)
        strcpy(message, "no such folder");
    return !bus.esi_dir_fails;
}

/* --- runs --------------------------------------------------------------------------------------------------------- */

static char content[FILE_ROOM];

/* Reads a file below the folder of the clone; "": none. */
static const char *read_out(const char *name)
{
    char path[300];
    snprintf(path, sizeof path, "out/%s", name);
    FILE *file = fopen(path, "rb");
    content[file ? fread(content, 1, sizeof content - 1, file) : 0] = '\0';
    if (file)
        fclose(file);
    return content;
}

static int no_dot(const struct dirent *entry)
{
    return entry->d_name[0] != '.';
}

/* Removes the folder of the clone. @param[out] names  its files, each after a blank */
static void remove_out(char *names, size_t room)
{
    struct dirent **entries = NULL;
    const int count = scandir("out", &entries, no_dot, alphasort);
    names[0] = '\0';
    for (int i = 0; i < count; i++) {
        char path[300];
        const size_t used = strlen(names);
        snprintf(names + used, room - used, " %s", entries[i]->d_name);
        snprintf(path, sizeof path, "out/%s", entries[i]->d_name);
        unlink(path);
        free(entries[i]);
    }
    free(entries);
    (void)rmdir("out");
}

static ect_device_t detailed;
static const ect_product_t products[] = {{&detailed, NULL}};

static void run(const bus_t *slaves, const char *line, int status, const char *text)
{
    char names[300];
    remove_out(names, sizeof names);
    bus = *slaves;
    uploads = 0;
    command_expect(&(command_line_t){.line = line, .status = status, .text = text}, products, 1);
}

#define LISTENS "listens for 500 ms\n"
#define GAUGE   "1 GAUGE @0x00007E59/0x00000001: EEPROM 1024 bytes, "

static void files(void **state)
{
    static const struct {
        const char *type;
        uint16_t count, leave;
        const char *names;
    } rows[] = {
        {"GAUGE", 99, 1, " 01-gauge.xml"},
        {"GAUGE", 100, 1, " 001-gauge.xml"},
        {"GAUGE", 999, 1, " 001-gauge.xml"},
        {"GAUGE", 1000, 1, " 00001-gauge.xml"},
        {"GAUGE", 65535, 1, " 00001-gauge.xml"},
        {"AZaz09", 2, 1, " 01-azaz09.xml"},
        {"a@b[c`d{e/f:g", 2, 1, " 01-a-b-c-d-e-f-g.xml"},
        {"a..b--c", 2, 1, " 01-a-b-c.xml"},
        {"..a", 2, 1, " 01-a.xml"},
        {"a..", 2, 1, " 01-a.xml"},
        {"..", 2, 1, " 01.xml"},
        {"abcdefghijklmnopqrst", 2, 1, " 01-abcdefghijklmnopqrst.xml"},
        {"abcdefghijklmnopqrstu", 2, 1, " 01-abcdefghijklmnopqrst.xml"},
        {"abcdefghijklmnopqrs.u", 2, 1, " 01-abcdefghijklmnopqrs.xml"},
        {"abcdefghijklmnopqrstu", 1000, 1, " 00001-abcdefghijklmnopq.xml"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char names[300], text[COMMAND_TEXT], requests[COMMAND_TEXT];
        bus = (bus_t){.type = rows[i].type, .count = rows[i].count, .leave = rows[i].leave};
        const command_line_t row = {.line = COMMAND};
        assert_int_equal(command_line_run(&row, NULL, 0, text, requests), LEAVES);
        remove_out(names, sizeof names);
        if (strcmp(names, rows[i].names) != 0)
            fail_msg("%s, 1 of %u: expected%s, got%s", rows[i].type, rows[i].count, rows[i].names, names);
    }
}

/* Runs the command on `slaves`, and compares a file with texts that it has, and one that it has not. */
static void expect_file(const bus_t *slaves, const char *line, int status, const char *text, const char *file,
                        const char *has, const char *lacks)
{
    char names[300];
    run(slaves, line, status, text);
    read_out(file);
    remove_out(names, sizeof names);
    if ((has && !strstr(content, has)) || (lacks && strstr(content, lacks)))
        fail_msg("ectwin %s: expected '%s', not '%s' in %s, which is\n%s", line, has ? has : "", lacks ? lacks : "",
                 file, content);
}

#define HEAD                                                                                                           \
    "# The bus on w, cloned by ectwin " ECTWIN_VERSION " at 1970-01-01 00:00:00 UTC: values are those of that "        \
    "time,\n# and the applications of the slaves are not cloned.\nectwin: 1\ntwins:\n"
#define SLAVE(n) "  - device: 'esi:0" #n "-gauge.xml'\n    name: slave" #n "\n"

/* DL status: bit 9 + 2 * n for a communication at port n. */
static void wires(void **state)
{
    static const struct {
        uint16_t count;
        uint8_t status[SLAVES_MOST][2];
        bool no_status;
        const char *wire;
    } rows[] = {
        {1, {{0}}, false, ""},
        {2, {{0, 0x02 | 0x08}, {0, 0x02}}, false, ""},
        {3, {{0, 0x08}, {0, 0x08}, {0}}, false, ""},
        /* ports in the order 3, 1, 2 */
        {4, {{0, 0x80 | 0x08 | 0x20}, {0}, {0}, {0}}, false, "wire: ['2:1.3', '3:1.1', '4:1.2']\n"},
        {3, {{0, 0x80 | 0x08}, {0}, {0}}, false, "wire: ['2:1.3', '3:1.1']\n"},
        {3, {{0, 0x08 | 0x20}, {0}, {0}}, false, "wire: ['3:1.2']\n"},
        {2, {{0, 0x80}, {0}}, false, "wire: ['2:1.3']\n"},
        {2, {{0, 0x20}, {0}}, false, "wire: ['2:1.2']\n"},
        /* a slave is connected to the last one with a free port */
        {4, {{0, 0x08 | 0x20}, {0, 0x08}, {0}, {0}}, false, "wire: ['4:1.2']\n"},
        {5, {{0, 0x88}, {0, 0x28}, {0}, {0}, {0}}, false, "wire: ['2:1.3', '4:2.2', '5:1.1']\n"},
        /* port 0 leads to the parent; other bits have another meaning */
        {3, {{0xFF, 0x02}, {0xFF, 0x57}, {0xFF, 0x57}}, false, ""},
        {2, {{0xFF, 0x55}, {0}}, false, ""},
        {2, {{0, 0x80}, {0}}, true, ""},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        static const char *const slaves[] = {SLAVE(1), SLAVE(2), SLAVE(3), SLAVE(4), SLAVE(5)};
        char names[300], text[COMMAND_TEXT], requests[COMMAND_TEXT], expected[2000] = HEAD;
        bus = (bus_t){.count = rows[i].count, .no_status = rows[i].no_status};
        memcpy(bus.status, rows[i].status, sizeof bus.status);
        const command_line_t row = {.line = COMMAND};
        assert_int_equal(command_line_run(&row, NULL, 0, text, requests), 0);
        for (unsigned int n = 0; n < rows[i].count; n++)
            strcat(expected, slaves[n]);
        strcat(expected, rows[i].wire);
        read_out("bus.yaml");
        remove_out(names, sizeof names);
        if (strcmp(content, expected) != 0)
            fail_msg("row %zu: expected\n%s\ngot\n%s", i, expected, content);
    }
}

/* Type, FMMUs, SyncManagers and RAM are in registers 0, 4, 5 and 6. */
static void chips(void **state)
{
    (void)state;
    for (size_t i = 0; ect_esc_personality_at(i) != NULL; i++) {
        const ect_esc_personality_t *p = ect_esc_personality_at(i);
        const uint8_t info[8] = {p->type, 0x77, 0x77, 0x77, p->fmmu_count, p->sm_count, p->ram_kb, 0x77};
        for (unsigned int changed = i == 0 ? 0 : 8; changed < 9; changed++) {
            const bool counts = changed == 0 || (changed >= 4 && changed <= 6);
            bus_t one = {.no_info = changed == 7, .changes = ECT_READER_CHANGES_NONE};
            char chip[60];
            memcpy(one.info, info, sizeof info);
            if (changed < 7)
                one.info[changed] ^= 0x40;
            snprintf(chip, sizeof chip, "    esc: %s\n", p->name);
            const bool known = !counts && changed != 7;
            expect_file(&one, COMMAND, 0, "listens for 500 ms\nclosed\n" GAUGE "0 objects, 1 PDOs\n", "bus.yaml",
                        known ? chip : NULL, known ? NULL : "esc:");
        }
    }
}

static void options(void **state)
{
    static const struct {
        const char *line;
        bus_t bus;
        int status;
        const char *text;
    } rows[] = {
        {COMMAND "--preop", {.changes = ECT_READER_CHANGES_INIT}, 0, LISTENS "closed\n" GAUGE "0 objects, 1 PDOs\n"},
        {COMMAND, {.changes = ECT_READER_CHANGES_NONE}, 0, LISTENS "closed\n" GAUGE "0 objects, 1 PDOs\n"},
        {COMMAND "--limit 1",
         {.limit_ms = 1000, .changes = ECT_READER_CHANGES_NONE},
         0,
         LISTENS "closed\n" GAUGE "0 objects, 1 PDOs\n"},
        {COMMAND "--limit 86400",
         {.limit_ms = 86400000, .changes = ECT_READER_CHANGES_NONE},
         0,
         LISTENS "closed\n" GAUGE "0 objects, 1 PDOs\n"},
        {COMMAND "--limit 0", {0}, 1, "ectwin clone: --limit takes a number from 1 to 86400, not '0'\n"},
        {COMMAND "--limit 86401", {0}, 1, "ectwin clone: --limit takes a number from 1 to 86400, not '86401'\n"},
        {"clone -o out", {0}, 1, "ectwin clone: name the interface and the folder: -i IFACE -o DIR\n"},
        {"clone -i w", {0}, 1, "ectwin clone: name the interface and the folder: -i IFACE -o DIR\n"},
        {"clone -i x -o out", {0}, 2, "ectwin clone: no link\n"},
        {COMMAND,
         {.hears = true},
         2,
         LISTENS
         "ectwin clone: a master is active on 'w', and each would fetch replies of the other: stop it first, or "
         "read with --beside-master\nclosed\n"},
        {COMMAND "--beside-master",
         {.hears = true, .changes = ECT_READER_CHANGES_NONE},
         0,
         "closed\n" GAUGE "0 objects, 1 PDOs\n"},
        {"clone -i w -o nosuch/out", {0}, 2, LISTENS "ectwin clone: 'nosuch/out': No such file or directory\nclosed\n"},
        {"clone -i w -o .",
         {0},
         2,
         LISTENS "ectwin clone: '.': File exists: name a folder that is not there yet\nclosed\n"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char names[300];
        run(&rows[i].bus, rows[i].line, rows[i].status, rows[i].text);
        remove_out(names, sizeof names);
        if (strcmp(names, rows[i].status == 0 ? " 01-gauge.xml bus.yaml" : "") != 0)
            fail_msg("row %zu: got%s", i, names);
    }
}

static void incomplete(void **state)
{
#define FAILED "ectwin clone: slave 1: "
    static const struct {
        bus_t bus;
        const char *text, *bus_file;
    } rows[] = {
        {{.open = ECT_READER_LOST},
         FAILED "EEPROM: the reason\nclosed\n",
         "# Without 1 of the 1 slaves of the bus, and without its wires.\n"},
        {{.open = ECT_READER_LOST, .count = 3, .leave = 0},
         FAILED "EEPROM: the reason\nectwin clone: slave 2: EEPROM: the reason\nectwin clone: slave 3: EEPROM: the "
                "reason\nclosed\n",
         "# Without 3 of the 3 slaves of the bus, and without its wires.\n"},
        {{.sii = ECT_READER_SILENT},
         FAILED "EEPROM: the reason\nclosed\n",
         "# Without 1 of the 1 slaves of the bus, and without its wires.\n"},
        {{.empty_image = true},
         FAILED "EEPROM: an empty EEPROM image: it has neither vendor id nor product code\nclosed\n",
         "# Without 1 of the 1 slaves of the bus, and without its wires.\n"},
        {{.dictionary = ECT_READER_SILENT},
         FAILED "dictionary, read in part: the reason\nclosed\n" GAUGE "0 objects, 1 PDOs\n",
         SLAVE(1)},
        {{.dictionary = ECT_READER_DECLINED, .found_status = INIT},
         FAILED "without its dictionary: the reason: --preop takes it to PREOP and back\nclosed\n" GAUGE
                "0 objects, 1 PDOs\n",
         SLAVE(1)},
        {{.dictionary = ECT_READER_DECLINED, .found_status = 0x10 | INIT},
         FAILED "without its dictionary: the reason: --preop takes it to PREOP and back\nclosed\n" GAUGE
                "0 objects, 1 PDOs\n",
         SLAVE(1)},
        {{.dictionary = ECT_READER_DECLINED, .found_status = 3},
         FAILED "without its dictionary: the reason\nclosed\n" GAUGE "0 objects, 1 PDOs\n",
         SLAVE(1)},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char text[COMMAND_TEXT], names[300], expected[1000];
        bus_t one = rows[i].bus;
        one.changes = ECT_READER_CHANGES_NONE;
        snprintf(text, sizeof text, LISTENS "%s", rows[i].text);
        snprintf(expected, sizeof expected, HEAD "%s", rows[i].bus_file);
        run(&one, COMMAND, 3, text);
        read_out("bus.yaml");
        remove_out(names, sizeof names);
        if (strcmp(content, expected) != 0)
            fail_msg("row %zu: expected\n%s\ngot\n%s", i, expected, content);
    }
}

/* Access: 3Fh read and write in all states, 07h read, 38h write, 06h read in SAFEOP and OP. */
#define UNREAD(n, text) {.index = n, .name = "Object", .type = 7, .bits = 32, .access = text}
#define NAME_50         "a23456789.a23456789.a23456789.a23456789.a23456789."
#define NAME_255        NAME_50 NAME_50 NAME_50 NAME_50 NAME_50 "a2345"

static char long_value[ECT_READER_VALUE + 1];

static void dictionaries(void **state)
{
    static const struct {
        const char *line;
        bus_t bus;
        const char *said, *has, *lacks;
    } rows[] = {
        {COMMAND,
         {.found = {{0x2000, .name = "Speed", .type = 7, .bits = 32, .access = 7, .value = "\1\2\3\4",
                     .value_length = 4}}},
         "1 objects, 1 PDOs",
         "<DefaultData>01020304</DefaultData>",
         NULL},
        {COMMAND,
         {.found = {{0x2000, .name = "Speed", .type = 7, .bits = 32, .access = 7, .preset = "abcd"}}},
         "1 objects, 1 PDOs, 1 entry without a value",
         "<DefaultData>61626364</DefaultData>",
         NULL},
        {COMMAND,
         {.found = {{0x2000, .name = "Speed", .type = 7, .bits = 32, .access = 7, .preset = "abcd", .value = "efgh"}}},
         "1 objects, 1 PDOs",
         "<DefaultData>65666768</DefaultData>",
         "61626364"},
        {COMMAND,
         {.found = {UNREAD(0x2000, 0x07), UNREAD(0x2001, 0x3F), UNREAD(0x2002, 0x38), UNREAD(0x2003, 0x06)}},
         "4 objects, 1 PDOs, 2 entries without a value",
         "  2002:00: no value: access 0x0038, not readable\n  2003:00: no value: access 0x0006, not readable in "
         "PREOP\n",
         NULL},
        {COMMAND,
         {.undescribed = true, .found = {{0x2000, true, .name = "", .type = 7, .bits = 32, .access = 7}}},
         "1 objects, 1 PDOs",
         NULL,
         "no value"},
        {COMMAND,
         {.found = {{0x2000, .name = NAME_255, .name_length = 254, .type = 7, .bits = 32, .access = 7,
                     .value = "efgh"}}},
         "1 objects, 1 PDOs",
         "."
         "a234<",
         "a2345<"},
        {COMMAND,
         {.found = {{0x2000, .name = NAME_255, .name_length = 255, .type = 7, .bits = 32, .access = 7,
                     .value = "efgh"}}},
         "1 objects, 1 PDOs",
         "."
         "a2345<",
         NULL},
        {COMMAND,
         {.found = {{0x2000, .name = NAME_255 "x", .name_length = 256, .type = 7, .bits = 32, .access = 7,
                     .value = "efgh"}}},
         "1 objects, 1 PDOs",
         "."
         "a2345<",
         "a2345x"},
        {COMMAND,
         {.found = {{0x2000, .name = NAME_255 NAME_50, .type = 7, .bits = 32, .access = 7, .value = "efgh"}}},
         "1 objects, 1 PDOs",
         "."
         "a2345<",
         NULL},
        {COMMAND "--blank texts",
         {.found = {{0x2000, .name = "Text", .type = 9, .bits = 32, .access = 0x3F, .value = "efgh"}}},
         "1 objects, 1 PDOs",
         "<DefaultData>00000000</DefaultData>",
         "efgh"},
        {COMMAND "--blank serial",
         {.found = {{0x2000, .name = "Text", .type = 9, .bits = 32, .access = 0x3F, .value = "efgh"}}},
         "1 objects, 1 PDOs",
         "<DefaultString>efgh</DefaultString>",
         NULL},
        {COMMAND "--blank texts",
         {.found = {{0x2000, .name = "Text", .type = 9, .bits = 32, .access = 0x3F, .preset = "efgh"}}},
         "1 objects, 1 PDOs, 1 entry without a value",
         "<DefaultData>00000000</DefaultData>",
         "efgh"},
        {COMMAND "--blank texts",
         {.found = {{0x2000, .name = "Text", .type = 9, .bits = 32768, .access = 0x3F, .value = long_value,
                     .value_length = ECT_READER_VALUE}}},
         "1 objects, 1 PDOs",
         "<DefaultData>0000",
         "zzzz"},
        {COMMAND "--blank texts",
         {.found = {{0x2000, .name = "Text", .type = 9, .bits = 32776, .access = 0x3F, .value = long_value,
                     .value_length = ECT_READER_VALUE + 1}}},
         "1 objects, 1 PDOs",
         "<DefaultString>zzzz",
         NULL},
    };
    (void)state;
    memset(long_value, 'z', sizeof long_value);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char text[200];
        bus_t one = rows[i].bus;
        one.changes = ECT_READER_CHANGES_NONE;
        snprintf(text, sizeof text, LISTENS "closed\n" GAUGE "%s\n", rows[i].said);
        expect_file(&one, rows[i].line, 0, text, "01-gauge.xml", rows[i].has, rows[i].lacks);
    }
}

static void searches(void **state)
{
#define NO_INFO "ectwin clone: slave 1: no SDO information: "
#define FILES   "--esi-dir files"
    static const struct {
        const char *line;
        bus_t bus;
        const char *text, *has, *lacks;
    } rows[] = {
        {COMMAND, {.undescribed = true}, "closed\n" GAUGE "0 objects, 1 PDOs\n", NULL, "SDO information"},
        {COMMAND FILES, {.undescribed = false}, "closed\n" GAUGE "0 objects, 1 PDOs\n", NULL, "SDO information"},
        {COMMAND FILES,
         {.undescribed = true, .no_coe = true},
         "closed\n" GAUGE "0 objects, 1 PDOs\n",
         NULL,
         "SDO information"},
        {COMMAND FILES,
         {.undescribed = true, .declined = true},
         "closed\n" GAUGE "0 objects, 1 PDOs\n",
         NULL,
         "SDO information"},
        {COMMAND FILES,
         {.undescribed = true},
         NO_INFO "no file has its vendor, product and revision\nclosed\n" GAUGE "0 objects, 1 PDOs\n",
         NULL,
         "SDO information"},
        {COMMAND FILES,
         {.undescribed = true, .esi_dir_fails = true},
         NO_INFO "no such folder\nclosed\n" GAUGE "0 objects, 1 PDOs\n",
         NULL,
         "SDO information"},
        {COMMAND FILES,
         {.undescribed = true, .esi_dir_fails = true, .esi_dir = "fzm1"},
         NO_INFO "no such folder\nclosed\n" GAUGE "0 objects, 1 PDOs\n",
         NULL,
         "SDO information"},
        {COMMAND FILES,
         {.undescribed = true, .esi_dir = "esi:nosuch"},
         NO_INFO "nosuch: No such file or directory\nclosed\n" GAUGE "0 objects, 1 PDOs\n",
         NULL,
         "SDO information"},
        {COMMAND FILES,
         {.undescribed = true, .esi_dir = "detailed"},
         NO_INFO "names and objects from iled\nclosed\n" GAUGE "6 objects, 1 PDOs\n",
         "  No SDO information: names and objects are those of an ESI file.\n",
         NULL},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char text[500];
        bus_t one = rows[i].bus;
        one.changes = ECT_READER_CHANGES_NONE;
        snprintf(text, sizeof text, LISTENS "%s", rows[i].text);
        expect_file(&one, rows[i].line, 0, text, "01-gauge.xml", rows[i].has, rows[i].lacks);
    }
}

typedef struct detailed {
    ect_standard_t standard;
    int16_t speed;
    uint64_t count;
    uint8_t on, key;
} detailed_t;

static const ect_entry_t speed[] = {ECT_ENTRY(0, INTEGER16, 16, ECT_ACCESS_RO, "Speed", 0, detailed_t, speed)};
static const ect_entry_t count[] = {ECT_ENTRY(0, UNSIGNED64, 64, ECT_ACCESS_RO, "Count", 0, detailed_t, count)};
static const ect_entry_t on[] = {ECT_ENTRY(0, UNSIGNED8, 8, ECT_ACCESS_RO, "On", 1, detailed_t, on)};
static const ect_entry_t key[] = {ECT_ENTRY(0, UNSIGNED8, 8, ECT_ACCESS_WO, "Key", 0, detailed_t, key)};
static const ect_object_t detailed_objects[] = {
    ECT_OBJECT_DEVICE_TYPE,          ECT_OBJECT_IDENTITY,       ECT_VAR(0x2000, "Speed", speed),
    ECT_VAR(0x2001, "Count", count), ECT_VAR(0x2002, "On", on), ECT_VAR(0x2003, "Key", key),
};
static const ect_detail_t details[] = {
    ECT_LIMITS_PER(0x2000, 0, 0x000B, 0x20, -5, 7),
    ECT_LIMITS_PER(0x2001, 0, 0, 0x03, 0, INT64_MAX),
    ECT_LIMITS(0x2002, 0, 1, 1, 2),
};

/* Details of an entry in a file: unit and its divisor, minimum and maximum, each in the size of the entry. */
static void details_of_a_file(void **state)
{
    static const struct {
        ect_reader_result_t uploads[UPLOADS_MOST];
        unsigned int failures;
        int status;
        const char *said, *has, *lacks;
    } rows[] = {
        {{0}, 0, 0, "6 objects, 1 PDOs", "<Unit>#x000B2000</Unit>", NULL},
        {{0}, 0, 0, "6 objects, 1 PDOs", "<Unit>#x00010000</Unit>", NULL},
        {{0}, 0, 0, "6 objects, 1 PDOs", "<MinValue>-5</MinValue>", NULL},
        {{0}, 0, 0, "6 objects, 1 PDOs", "<MaxValue>7</MaxValue>", NULL},
        {{0}, 0, 0, "6 objects, 1 PDOs", "<MaxValue>9223372036854775807</MaxValue>", NULL},
        {{0}, 0, 0, "6 objects, 1 PDOs", "<MinValue>1</MinValue>", NULL},
        {{0}, 0, 0, "6 objects, 1 PDOs", "  2003:00: no value: access 0x0038, not readable\n", "2000:00"},
        {{ECT_READER_ABORTED},
         2,
         0,
         "6 objects, 1 PDOs, 1 entry without a value",
         "  2000:00: no value: abort code 0x00000601\n",
         "2001:00"},
        {{ECT_READER_OK, ECT_READER_SILENT},
         2,
         0,
         "6 objects, 1 PDOs, 1 entry without a value",
         "  2001:00: no value: no reply\n",
         "2000:00"},
        {{ECT_READER_OK, ECT_READER_SILENT},
         3,
         3,
         "4 objects, 1 PDOs, 1 entry without a value",
         "  2001:00: no value: no reply\n",
         "2002:00"},
        {{ECT_READER_LOST},
         0,
         3,
         "3 objects, 1 PDOs, 1 entry without a value",
         "  2000:00: no value: no frame came back\n",
         "2001:00"},
        {{ECT_READER_STOPPED},
         0,
         3,
         "3 objects, 1 PDOs, 1 entry without a value",
         "  2000:00: no value: not read any more\n",
         "2001:00"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char text[500];
        bus_t one = {.undescribed = true,
                     .esi_dir = "detailed",
                     .failures = rows[i].failures,
                     .changes = ECT_READER_CHANGES_NONE};
        memcpy(one.uploads, rows[i].uploads, sizeof one.uploads);
        snprintf(text, sizeof text, LISTENS NO_INFO "names and objects from iled\n%sclosed\n" GAUGE "%s\n",
                 rows[i].status != 0 ? "ectwin clone: slave 1: dictionary, read in part: the reason\n" : "",
                 rows[i].said);
        expect_file(&one, COMMAND FILES, rows[i].status, text, "01-gauge.xml", rows[i].has, rows[i].lacks);
    }
}

static void progress(void **state)
{
    const bus_t one = {.terminal = true, .changes = ECT_READER_CHANGES_NONE};
    (void)state;
    expect_file(&one, COMMAND, 0, LISTENS "\rslave 1: things 3 of 7 \rclosed\n" GAUGE "0 objects, 1 PDOs\n", "bus.yaml",
                SLAVE(1), NULL);
}

#define TEST(title, function) {title, function, NULL, NULL, NULL}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        TEST("the name of a file has the slave's number, and its type without other characters", files),
        TEST("the bus file has the wires that are not those of a line", wires),
        TEST("the bus file names a chip with the same type, FMMUs, SyncManagers and RAM", chips),
        TEST("options, a master on the wire, and folders that cannot be made", options),
        TEST("entries of the dictionary become entries of the file, with their values", dictionaries),
        TEST("--esi-dir is searched for a slave with CoE without SDO information", searches),
        TEST("units, minima and maxima of the file of --esi-dir are kept", details_of_a_file),
        TEST("progress is printed to a terminal", progress),
        TEST("a slave that is not read, or in part, is exit code 3", incomplete),
    };
    detailed = gauge;
    detailed.name = "detailed";
    detailed.objects = detailed_objects;
    detailed.object_count = sizeof detailed_objects / sizeof detailed_objects[0];
    detailed.instance_size = sizeof(detailed_t);
    detailed.sm_count = 2;
    detailed.inputs = NULL;
    detailed.sdo_written = NULL;
    detailed.details = details;
    detailed.detail_count = sizeof details / sizeof details[0];
    setenv("SOURCE_DATE_EPOCH", "0", 1);
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Clones of slaves", tests, commands_begin, commands_end);
}
