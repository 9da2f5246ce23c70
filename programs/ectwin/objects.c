/* SPDX-License-Identifier: MIT */
/*
 * `ectwin objects`: the dictionary as C source for SOES, in three files, and the EEPROM image. Types and macros are
 * those of SOES's public headers (esc_coe.h, options.h).
 */
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "esi/values.h"
#include "output.h"
#include "wire/bytes.h"

enum { KEY_SOES = 0x201 };

static const struct argp_option options[] = {
    {"soes", KEY_SOES, NULL, 0, "As C source for SOES: slave_objectlist.c, utypes.h, ecat_options.h, and eeprom.bin",
     0},
    {"output", 'o', "FOLDER", 0, "Write the files to FOLDER (default: here)", 0},
    {0},
};

/* The device, and the file in progress. */
typedef struct source {
    FILE *file;
    ect_arena_t arena;
    const ect_device_t *device;
    ect_od_t od;
} source_t;

/* @return whether the value may change while the slave runs, and so needs a variable */
static bool is_variable(const ect_object_t *object, const ect_entry_t *entry)
{
    return entry->data && !(entry->access & (ECT_ACCESS_DESCRIPTION | ECT_ACCESS_SHARED)) && object->index != 0x1018;
}

static void print_literal(FILE *file, const char *text, size_t length)
{
    fputc('"', file);
    for (size_t i = 0; i < length; i++) {
        unsigned char c = (unsigned char)text[i];
        if (c == '"' || c == '\\' || c < ' ' || c > '~' || c == '?')
            fprintf(file, "\\%03o", (unsigned int)c);
        else
            fputc(c, file);
    }
    fputc('"', file);
}

static bool is_bytes(const ect_entry_t *entry)
{
    return entry->data_type == ECT_TYPE_VISIBLE_STRING || entry->data_type == ECT_TYPE_OCTET_STRING;
}

static bool is_zero(const uint8_t *bytes, size_t size)
{
    for (size_t i = 0; i < size; i++) {
        if (bytes[i] != 0)
            return false;
    }
    return true;
}

/*
 * SOES copies process data of up to 64 bits as integers, and asserts an integer type: a mapped byte array of 8, 16, 32
 * or 64 bits becomes an integer.
 */
static ect_entry_t as_soes(const ect_entry_t *entry)
{
    static const struct {
        uint16_t bits, type;
    } types[] = {
        {8, ECT_TYPE_UNSIGNED8}, {16, ECT_TYPE_UNSIGNED16}, {32, ECT_TYPE_UNSIGNED32}, {64, ECT_TYPE_UNSIGNED64}};
    ect_entry_t soes = *entry;
    bool mapped = (entry->access & (ECT_ACCESS_RXPDO | ECT_ACCESS_TXPDO)) != 0;
    for (size_t i = 0; i < sizeof types / sizeof types[0] && mapped && is_bytes(entry); i++) {
        if (types[i].bits == entry->bit_length)
            soes.data_type = types[i].type;
    }
    return soes;
}

/* --- utypes.h ----------------------------------------------------------------------------------------------------- */

static const char *c_type(const ect_entry_t *entry)
{
    static const struct {
        uint16_t code;
        const char *name;
    } types[] = {
        {ECT_TYPE_INTEGER8, "int8_t"},     {ECT_TYPE_INTEGER16, "int16_t"},   {ECT_TYPE_INTEGER32, "int32_t"},
        {ECT_TYPE_INTEGER64, "int64_t"},   {ECT_TYPE_UNSIGNED16, "uint16_t"}, {ECT_TYPE_UNSIGNED32, "uint32_t"},
        {ECT_TYPE_UNSIGNED64, "uint64_t"}, {ECT_TYPE_REAL32, "float"},        {ECT_TYPE_REAL64, "double"},
        {ECT_TYPE_BITARR16, "uint16_t"},   {ECT_TYPE_BITARR32, "uint32_t"},
    };
    for (size_t i = 0; i < sizeof types / sizeof types[0]; i++) {
        if (types[i].code == entry->data_type)
            return types[i].name;
    }
    return "uint8_t";
}

static void write_types(source_t *s)
{
    fprintf(s->file,
            "#ifndef UTYPES_H\n#define UTYPES_H\n\n#include \"cc.h\"\n\n"
            "/* The values of the dictionary of %s. */\ntypedef struct\n{\n",
            s->device->type_name);
    for (uint16_t i = 0; i < s->od.count; i++) {
        const ect_object_t *object = &s->od.objects[i];
        for (const ect_entry_t *e = object->entries; e; e = ect_od_next(object, e)) {
            if (!is_variable(object, e))
                continue;
            const ect_entry_t soes = as_soes(e);
            fprintf(s->file, "  %s v%04X_%02X", c_type(&soes), object->index, e->subindex);
            if (is_bytes(&soes))
                fprintf(s->file, "[%u]", ect_od_bytes(e));
            fprintf(s->file, ";\n");
        }
    }
    fprintf(s->file,
            "  uint8_t unused; /* a structure has a member */\n} _Objects;\n\nextern _Objects Obj;\n\n#endif\n");
}

/* --- slave_objectlist.c ------------------------------------------------------------------------------------------- */

static uint32_t number_of(const uint8_t *bytes, size_t size)
{
    uint32_t value = 0;
    for (size_t i = size < 4 ? size : 4; i-- > 0;)
        value = value << 8 | bytes[i];
    return value;
}

static void write_entry(source_t *s, const ect_object_t *object, const ect_entry_t *from)
{
    size_t size;
    const uint8_t *value = ect_esi_entry_value(&s->arena, &s->od, from, &size);
    const ect_entry_t soes = as_soes(from);
    const ect_entry_t *entry = &soes;
    bool variable = is_variable(object, entry);
    bool bytes = ect_od_is_string(entry) || size > 4;
    fprintf(s->file, "  {0x%02X, 0x%04X, %u, 0x%03X, ", entry->subindex, entry->data_type, ect_od_bits(&s->od, entry),
            entry->access & ECT_ACCESS_WIRE);
    print_literal(s->file, entry->name ? entry->name : "", entry->name ? strlen(entry->name) : 0);
    fprintf(s->file, ", 0x%08X, ", bytes ? 0u : number_of(value, size));
    if (variable)
        fprintf(s->file, "%sObj.v%04X_%02X", is_bytes(entry) ? "" : "&", object->index, entry->subindex);
    else if (bytes)
        print_literal(s->file, (const char *)value, size);
    else
        fprintf(s->file, "NULL");
    fprintf(s->file, "},\n");
}

static void write_long(FILE *file, const ect_entry_t *entry, const uint8_t *value, size_t size)
{
    if (is_bytes(entry)) {
        for (size_t k = 0; k < size; k++)
            fprintf(file, "%s0x%02X", k > 0 ? ", " : "{", value[k]);
        fprintf(file, "},\n");
    } else if (entry->data_type == ECT_TYPE_REAL64) {
        uint64_t bits = ect_load_le64(value);
        double number;
        memcpy(&number, &bits, sizeof number);
        fprintf(file, "%.17g,\n", number);
    } else {
        fprintf(file, "0x%016llX,\n", (unsigned long long)ect_load_le64(value));
    }
}

/* SOES initialises integers of up to 32 bits from the list; longer values need an initialiser. */
static void write_initial(source_t *s)
{
    fprintf(s->file, "_Objects Obj =\n{\n");
    for (uint16_t i = 0; i < s->od.count; i++) {
        const ect_object_t *object = &s->od.objects[i];
        for (const ect_entry_t *e = object->entries; e; e = ect_od_next(object, e)) {
            size_t size;
            const uint8_t *value = ect_esi_entry_value(&s->arena, &s->od, e, &size);
            const ect_entry_t soes = as_soes(e);
            if (!is_variable(object, e) || is_zero(value, size) || (size <= 4 && !is_bytes(&soes)))
                continue;
            fprintf(s->file, "  .v%04X_%02X = ", object->index, e->subindex);
            write_long(s->file, &soes, value, size);
        }
    }
    fprintf(s->file, "  .unused = 0\n};\n\n");
}

static void write_list(source_t *s)
{
    fprintf(s->file,
            "/* The dictionary of %s, written by ectwin from its description. */\n"
            "#include \"esc_coe.h\"\n#include \"utypes.h\"\n#include <stddef.h>\n\n",
            s->device->type_name);
    write_initial(s);
    for (uint16_t i = 0; i < s->od.count; i++) {
        const ect_object_t *object = &s->od.objects[i];
        fprintf(s->file, "const _objd SDO%04X[] =\n{\n", object->index);
        for (const ect_entry_t *e = object->entries; e; e = ect_od_next(object, e))
            write_entry(s, object, e);
        fprintf(s->file, "};\n");
    }
    fprintf(s->file, "\nconst _objectlist SDOobjects[] =\n{\n");
    for (uint16_t i = 0; i < s->od.count; i++) {
        const ect_object_t *object = &s->od.objects[i];
        fprintf(s->file, "  {0x%04X, 0x%04X, %td, 0, ", object->index, object->object_code,
                ect_od_last(object) - object->entries);
        print_literal(s->file, object->name, strlen(object->name));
        fprintf(s->file, ", SDO%04X},\n", object->index);
    }
    fprintf(s->file, "  {0xFFFF, 0xFF, 0xFF, 0xFF, NULL, NULL}\n};\n");
}

/* --- ecat_options.h ----------------------------------------------------------------------------------------------- */

/* Never 0: SOES would then expect process data without entries. */
static unsigned int most_mappings(const source_t *s, bool outputs)
{
    unsigned int count = 0;
    for (uint16_t i = 0; i < s->od.count; i++) {
        const ect_object_t *object = &s->od.objects[i];
        if (outputs ? ect_od_is_rxpdo(object->index) : ect_od_is_txpdo(object->index))
            count += (unsigned int)(ect_od_last(object) - object->entries);
    }
    return count > 0 ? count : 1;
}

static void write_mailboxes(FILE *file, const char *suffix, const uint16_t layout[4], const uint8_t controls[2])
{
    for (unsigned int n = 0; n < 2; n++) {
        fprintf(file, "#define MBX%u_sma%s 0x%04X\n#define MBX%u_sml%s %u\n", n, suffix, layout[2 * n], n, suffix,
                layout[2 * n + 1]);
        fprintf(file, "#define MBX%u_sme%s (MBX%u_sma%s + MBX%u_sml%s - 1)\n#define MBX%u_smc%s 0x%02X\n", n, suffix, n,
                suffix, n, suffix, n, suffix, controls[n]);
    }
}

/* SOES accesses process data in words of 64 bits, up to the end of the last word. */
static unsigned int room_for(const ect_device_t *device, unsigned int sm)
{
    unsigned int bytes = ect_device_sm_bytes(device, sm);
    bytes = device->sm[sm].maximum > bytes ? device->sm[sm].maximum : bytes;
    return bytes > 0 ? (bytes + 7) / 8 * 8 : 8;
}

static void write_options(source_t *s)
{
    const ect_device_t *d = s->device;
    const uint8_t controls[2] = {d->sm[0].control, d->sm[1].control};
    const uint16_t mailboxes[4] = {d->sm[0].start, d->sm[0].length, d->sm[1].start, d->sm[1].length};
    const uint16_t boot[4] = {d->boot_out.start, d->boot_out.length, d->boot_in.start, d->boot_in.length};
    fprintf(s->file, "#ifndef ECAT_OPTIONS_H\n#define ECAT_OPTIONS_H\n\n#include \"cc.h\"\n\n");
    fprintf(s->file, "#define USE_FOE %d\n#define USE_EOE %d\n\n", (d->mailbox_protocols & ECT_MAILBOX_FOE) != 0,
            (d->mailbox_protocols & ECT_MAILBOX_EOE) != 0);
    fprintf(s->file, "#define MBXSIZE %u\n#define MBXSIZEBOOT %u\n#define MBXBUFFERS 3\n\n", d->sm[0].length,
            d->boot_out.length != 0 ? d->boot_out.length : d->sm[0].length);
    write_mailboxes(s->file, "", mailboxes, controls);
    write_mailboxes(s->file, "_b", d->boot_out.length != 0 ? boot : mailboxes, controls);
    for (unsigned int n = 2; n < 4; n++)
        fprintf(s->file, "#define SM%u_sma 0x%04X\n#define SM%u_smc 0x%02X\n#define SM%u_act %d\n", n, d->sm[n].start,
                n, d->sm[n].control, n, ect_device_sm_bytes(d, n) > 0);
    fprintf(s->file, "\n#define MAX_MAPPINGS_SM2 %u\n#define MAX_MAPPINGS_SM3 %u\n", most_mappings(s, true),
            most_mappings(s, false));
    fprintf(s->file, "#define MAX_RXPDO_SIZE %u\n#define MAX_TXPDO_SIZE %u\n\n#endif\n", room_for(d, 2),
            room_for(d, 3));
}

/* --- the command -------------------------------------------------------------------------------------------------- */

/* SOES supports SyncManagers 0 and 1 as mailboxes, 2 for outputs and 3 for inputs; a SyncManager without process data
 * is not used. */
bool output_suits_soes(const ect_device_t *device)
{
    static const uint8_t roles[] = {ECT_SM_MAILBOX_OUT, ECT_SM_MAILBOX_IN, ECT_SM_OUTPUTS, ECT_SM_INPUTS};
    for (unsigned int n = 0; n < 4; n++) {
        bool unused = n >= 2 && device->sm[n].type == ECT_SM_UNUSED;
        if (device->sm[n].type != roles[n] && !unused)
            return false;
    }
    return device->sm_count == 4;
}

static int write_source(source_t *s, const char *who, const char *folder, const char *name, void (*write)(source_t *s))
{
    char path[OUTPUT_PATH];
    output_text_t out;
    if (!output_path(who, path, folder, name))
        return EXIT_OPEN;
    s->file = output_open(who, &out);
    if (!s->file)
        return EXIT_RUN;
    write(s);
    return output_close(who, &out, path);
}

static int write_image(const char *who, const ect_twin_config_t *twin, const char *folder)
{
    char path[OUTPUT_PATH];
    if (!output_path(who, path, folder, "eeprom.bin"))
        return EXIT_OPEN;
    uint8_t *image = output_image(who, twin);
    int status = image ? output_save(who, path, image, twin->device->sii_size) : EXIT_RUN;
    free(image);
    return status;
}

/* Creates the folder if necessary. */
static int write_all(source_t *s, const char *who, const char *folder)
{
    static const struct {
        const char *name;
        void (*write)(source_t *s);
    } files[] = {{"utypes.h", write_types}, {"slave_objectlist.c", write_list}, {"ecat_options.h", write_options}};
    int status = EXIT_CLEAN;
    (void)mkdir(folder, 0777); /* a failure is reported when a file is opened */
    for (size_t i = 0; i < sizeof files / sizeof files[0] && status == EXIT_CLEAN; i++)
        status = write_source(s, who, folder, files[i].name, files[i].write);
    return status;
}

int output_soes(const char *who, const ect_twin_config_t *twin, const char *folder)
{
    source_t source = {.device = twin->device};
    source.od = ect_esi_values(&source.arena, twin->device, &twin->identity);
    int status = write_all(&source, who, folder);
    if (status == EXIT_CLEAN)
        status = write_image(who, twin, folder);
    ect_arena_free(&source.arena);
    return status;
}

int command_objects(int argc, char **argv)
{
    static const char who[] = "ectwin objects";
    static const struct argp argp = {
        .options = options,
        .parser = output_parse,
        .args_doc = "DEVICE --soes",
        .doc = "Writes the dictionary of a device as source code.",
        .children = output_children,
    };
    output_args_t args = {.key = KEY_SOES};
    argp_parse(&argp, argc, argv, 0, NULL, &args);
    const ect_device_t *device = args.twins.twins[0].device;
    int status = EXIT_USAGE;
    if (!args.given) {
        fprintf(stderr, "%s: name the stack to write for: --soes\n", who);
    } else if (!output_suits_soes(device)) {
        fprintf(stderr, "%s: %s does not have the SyncManagers of a SOES slave: two mailboxes, outputs, inputs\n", who,
                device->name);
    } else {
        status = output_soes(who, &args.twins.twins[0], args.output ? args.output : ".");
    }
    twin_args_free(&args.twins);
    return status;
}
