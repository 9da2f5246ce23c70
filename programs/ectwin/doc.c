/* SPDX-License-Identifier: MIT */
/* The dictionary for people: the same tables as Markdown or as one page of HTML that needs nothing beside it. */
#define _GNU_SOURCE
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "esi/values.h"
#include "output.h"

static const char who[] = "ectwin doc";

enum { KEY_HTML = 0x202 };

static const struct argp_option options[] = {
    {"html", KEY_HTML, NULL, 0, "One page of HTML (default: Markdown)", 0},
    {"output", 'o', "FILE", 0, "Write to FILE (default: standard output)", 0},
    {0},
};

/* A document while it is written. */
typedef struct page {
    FILE *file;
    bool html;
    ect_arena_t arena;
    const ect_device_t *device;
    const ect_identity_t *identity;
    ect_od_t od;
} page_t;

/* --- what a page is made of --------------------------------------------------------------------------------------- */

static void put_text(page_t *p, const char *text)
{
    for (; *text; text++) {
        const char *html = *text == '<' ? "&lt;" : *text == '>' ? "&gt;" : *text == '&' ? "&amp;" : NULL;
        bool escaped = !p->html && strchr("|<>*_`\\", *text);
        if (p->html && html)
            fputs(html, p->file);
        else
            fprintf(p->file, "%s%c", escaped ? "\\" : "", *text);
    }
}

static void heading(page_t *p, int level, const char *text)
{
    if (p->html)
        fprintf(p->file, "<h%d>", level);
    else
        fprintf(p->file, "\n%.*s ", level, "####");
    put_text(p, text);
    fprintf(p->file, p->html ? "</h%d>\n" : "\n\n", level);
}

/* A row of texts, NULL at the end; the first one of a table is its head. */
static void row(page_t *p, bool head, const char *const *cells)
{
    const char *tag = head ? "th" : "td";
    fputs(p->html ? "<tr>" : "|", p->file);
    for (size_t i = 0; cells[i]; i++) {
        if (p->html)
            fprintf(p->file, "<%s>", tag);
        else
            fputc(' ', p->file);
        put_text(p, cells[i]);
        if (p->html)
            fprintf(p->file, "</%s>", tag);
        else
            fputs(" |", p->file);
    }
    fputs(p->html ? "</tr>\n" : "\n", p->file);
    if (!head || p->html)
        return;
    for (size_t i = 0; cells[i]; i++)
        fputs("|---", p->file);
    fputs("|\n", p->file);
}

static void table(page_t *p, bool begin)
{
    if (p->html)
        fputs(begin ? "<table>\n" : "</table>\n", p->file);
}

#define ROW(p, head, ...) row(p, head, (const char *const[]){__VA_ARGS__, NULL})

/* --- what stands on it -------------------------------------------------------------------------------------------- */

static const char *hex(page_t *p, uint32_t value, int digits)
{
    return ect_arena_print(&p->arena, "0x%0*" PRIX32, digits, value);
}

static const char *plain(page_t *p, unsigned int value)
{
    return ect_arena_print(&p->arena, "%u", value);
}

static const char *value_text(page_t *p, const ect_entry_t *entry)
{
    size_t size;
    const uint8_t *value = ect_esi_entry_value(&p->arena, &p->od, entry, &size);
    if (ect_od_is_string(entry))
        return (const char *)value;
    if (!ect_esi_has_default(entry, value, size))
        return "";
    char *text = ect_arena_alloc(&p->arena, 2 * size + 3);
    memcpy(text, "0x", 2);
    for (size_t i = 0; i < size && size <= 8; i++)
        snprintf(text + 2 + 2 * i, 3, "%02X", value[size - 1 - i]);
    return size <= 8 ? text : "";
}

static const char *range_text(page_t *p, const ect_object_t *object, const ect_entry_t *entry)
{
    const ect_detail_t *detail = ect_od_detail(&p->od, object->index, (uint8_t)entry->subindex);
    if (!detail || detail->minimum == detail->maximum)
        return "";
    return ect_arena_print(&p->arena, "%" PRId64 " to %" PRId64, detail->minimum, detail->maximum);
}

static const char *access_text(page_t *p, uint16_t bits)
{
    const char *states = ect_esi_states((bits & ECT_ACCESS_W_PREOP) != 0, (bits & ECT_ACCESS_W_SAFEOP) != 0,
                                        (bits & ECT_ACCESS_W_OP) != 0);
    return ect_arena_print(&p->arena, "%s%s%s%s%s", ect_esi_access(bits), *states ? " written in " : "", states,
                           (bits & ECT_ACCESS_RXPDO) != 0 ? ", RxPDO" : "",
                           (bits & ECT_ACCESS_TXPDO) != 0 ? ", TxPDO" : "");
}

static const char *type_text(page_t *p, const ect_entry_t *entry)
{
    const char *name = ect_esi_type_of(&p->arena, entry->data_type, ect_od_bits(&p->od, entry));
    return name ? name : plain(p, ect_od_bits(&p->od, entry));
}

static void identity(page_t *p)
{
    const ect_device_t *d = p->device;
    table(p, true);
    ROW(p, true, "Property", "Value");
    ROW(p, false, "Name", d->full_name ? d->full_name : d->type_name);
    ROW(p, false, "Vendor", ect_arena_print(&p->arena, "%s, 0x%08" PRIX32, d->vendor_name, p->identity->vendor_id));
    ROW(p, false, "Product code", hex(p, p->identity->product_code, 8));
    ROW(p, false, "Revision", hex(p, p->identity->revision, 8));
    ROW(p, false, "Controller", d->esc);
    ROW(p, false, "EEPROM", ect_arena_print(&p->arena, "%u bytes", d->sii_size));
    table(p, false);
}

static void layout(page_t *p)
{
    static const char *const roles[] = {"unused", "mailbox to the slave", "mailbox from the slave", "outputs",
                                        "inputs"};
    heading(p, 2, "SyncManagers");
    table(p, true);
    ROW(p, true, "Number", "Role", "Start", "Bytes", "Control");
    for (unsigned int i = 0; i < p->device->sm_count; i++) {
        const ect_sm_t *sm = &p->device->sm[i];
        ROW(p, false, plain(p, i), roles[sm->type < 5 ? sm->type : 0], hex(p, sm->start, 4),
            plain(p, ect_device_sm_bytes(p->device, i)), hex(p, sm->control, 2));
    }
    table(p, false);
}

static void pdo(page_t *p, const ect_object_t *object)
{
    uint32_t bit = 0;
    heading(p, 3, ect_arena_print(&p->arena, "%04Xh %s", object->index, object->name));
    table(p, true);
    ROW(p, true, "Byte", "Bit", "Bits", "Object", "Name", "Type");
    for (uint32_t n = 1; n <= ect_od_element(object, 0); n++) {
        uint32_t mapping = ect_od_element(object, n);
        const ect_entry_t *entry = ect_od_mapped(&p->od, mapping);
        const char *type = entry ? ect_esi_type_of(&p->arena, entry->data_type, mapping & 0xFF) : NULL;
        ROW(p, false, plain(p, bit / 8), plain(p, bit % 8), plain(p, mapping & 0xFF),
            entry ? ect_arena_print(&p->arena, "%04Xh:%u", mapping >> 16, mapping >> 8 & 0xFF) : "gap",
            entry && entry->name ? entry->name : "", type ? type : "");
        bit += mapping & 0xFF;
    }
    table(p, false);
}

static void pdos(page_t *p)
{
    heading(p, 2, "Process data");
    for (uint16_t i = 0; i < p->od.count; i++) {
        const ect_object_t *object = &p->od.objects[i];
        if (ect_od_is_rxpdo(object->index) || ect_od_is_txpdo(object->index))
            pdo(p, object);
    }
}

static void dictionary(page_t *p)
{
    heading(p, 2, "Objects");
    for (uint16_t i = 0; i < p->od.count; i++) {
        const ect_object_t *object = &p->od.objects[i];
        heading(p, 3, ect_arena_print(&p->arena, "%04Xh %s", object->index, object->name));
        table(p, true);
        ROW(p, true, "Sub-index", "Name", "Type", "Access", "Default", "Range");
        for (const ect_entry_t *e = object->entries; e; e = ect_od_next(object, e))
            ROW(p, false, plain(p, e->subindex), e->name ? e->name : "", type_text(p, e), access_text(p, e->access),
                value_text(p, e), range_text(p, object, e));
        table(p, false);
    }
}

static void write_page(page_t *p)
{
    if (p->html) {
        fputs("<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>", p->file);
        put_text(p, p->device->type_name);
        fputs("</title>\n<style>body{font:15px/1.4 sans-serif;margin:2em;max-width:70em}"
              "table{border-collapse:collapse}th,td{border:1px solid #aaa;padding:2px 8px;text-align:left}"
              "th{background:#eee}</style></head><body>\n",
              p->file);
        heading(p, 1, p->device->type_name);
    } else {
        fputs("# ", p->file);
        put_text(p, p->device->type_name);
        fputs("\n\n", p->file);
    }
    identity(p);
    layout(p);
    pdos(p);
    dictionary(p);
    if (p->html)
        fputs("</body></html>\n", p->file);
}

int command_doc(int argc, char **argv)
{
    static const struct argp argp = {
        .options = options,
        .parser = output_parse,
        .args_doc = "DEVICE",
        .doc = "Writes the dictionary and the process data of a device for people, as Markdown or HTML.",
        .children = output_children,
    };
    output_args_t args = {.key = KEY_HTML};
    argp_parse(&argp, argc, argv, 0, NULL, &args);
    const ect_twin_config_t *twin = &args.twins.twins[0];
    output_text_t out;
    int status = EXIT_RUN;
    page_t page = {.html = args.given, .device = twin->device, .identity = &twin->identity};
    page.od = ect_esi_values(&page.arena, twin->device, &twin->identity);
    page.file = output_open(who, &out);
    if (page.file) {
        write_page(&page);
        status = output_close(who, &out, args.output);
    }
    ect_arena_free(&page.arena);
    twin_args_free(&args.twins);
    return status;
}
