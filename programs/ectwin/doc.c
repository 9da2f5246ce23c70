/* SPDX-License-Identifier: MIT */
/* The document of a device, from its description: identity, layout, process data, named bits, charts, dictionary. */
#define _GNU_SOURCE
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "bus/chain/fields.h"
#include "charts.h"
#include "esi/units.h"
#include "esi/values.h"
#include "output.h"
#include "page.h"
#include "products.h"

enum { KEY_HTML = 0x202 };

static const struct argp_option options[] = {
    {"html", KEY_HTML, NULL, 0, "One page of HTML with links and charts (default: Markdown)", 0},
    {"output", 'o', "FILE", 0, "Write to FILE (default: standard output)", 0},
    {0},
};

/* A document in progress. */
typedef struct doc {
    page_t page;
    ect_arena_t arena;
    const ect_device_t *device;
    const ect_plant_t *plant;
    const ect_identity_t *identity;
    ect_od_t od;
} doc_t;

/* --- texts -------------------------------------------------------------------------------------------------------- */

static const char *hex(doc_t *d, uint32_t value, int digits)
{
    return ect_arena_print(&d->arena, "0x%0*" PRIX32, digits, value);
}

static const char *plain(doc_t *d, unsigned int value)
{
    return ect_arena_print(&d->arena, "%u", value);
}

static const char *or_empty(const char *text)
{
    return text ? text : "";
}

static const char *value_text(doc_t *d, const ect_entry_t *entry)
{
    size_t size;
    const uint8_t *value = ect_esi_entry_value(&d->arena, &d->od, entry, &size);
    if (ect_od_is_string(entry))
        return (const char *)value;
    if (!ect_esi_has_default(entry, value, size))
        return "";
    char *text = ect_arena_alloc(&d->arena, 2 * size + 3);
    memcpy(text, "0x", 2);
    for (size_t i = 0; i < size && size <= 8; i++)
        snprintf(text + 2 + 2 * i, 3, "%02X", value[size - 1 - i]);
    return size <= 8 ? text : "";
}

static const char *unit_text(doc_t *d, const ect_detail_t *detail)
{
    char text[40];
    const char *name = ect_esi_unit_text((uint32_t)detail->unit << 16 | (uint32_t)detail->per << 8, text, sizeof text);
    return name ? ect_arena_copy(&d->arena, name, strlen(name)) : hex(d, detail->unit, 4);
}

static const char *range_text(doc_t *d, const ect_object_t *object, const ect_entry_t *entry)
{
    const ect_detail_t *detail = ect_od_detail(&d->od, object->index, (uint8_t)entry->subindex);
    bool limits = detail && detail->minimum != detail->maximum;
    const char *unit = detail && detail->unit != 0 ? unit_text(d, detail) : "";
    if (!limits)
        return unit;
    return ect_arena_print(&d->arena, "%" PRId64 " to %" PRId64 "%s%s", detail->minimum, detail->maximum,
                           *unit ? " " : "", unit);
}

static const char *access_text(doc_t *d, uint16_t bits)
{
    const char *states = ect_esi_states((bits & ECT_ACCESS_W_PREOP) != 0, (bits & ECT_ACCESS_W_SAFEOP) != 0,
                                        (bits & ECT_ACCESS_W_OP) != 0);
    return ect_arena_print(&d->arena, "%s%s%s%s%s", ect_esi_access(bits), *states ? " written in " : "", states,
                           (bits & ECT_ACCESS_RXPDO) != 0 ? ", RxPDO" : "",
                           (bits & ECT_ACCESS_TXPDO) != 0 ? ", TxPDO" : "");
}

static const char *type_text(doc_t *d, const ect_entry_t *entry)
{
    const char *name = ect_esi_type_of(&d->arena, entry->data_type, ect_od_bits(&d->od, entry));
    return name ? name : plain(d, ect_od_bits(&d->od, entry));
}

/* --- targets of links --------------------------------------------------------------------------------------------- */

static const char *object_id(doc_t *d, uint16_t index)
{
    return ect_arena_print(&d->arena, "o%04X", index);
}

static const char *entry_id(doc_t *d, uint16_t index, unsigned int subindex)
{
    return ect_arena_print(&d->arena, "o%04X-%u", index, subindex);
}

static const char *field_id(doc_t *d, uint16_t index, unsigned int subindex)
{
    return ect_arena_print(&d->arena, "f%04X-%u", index, subindex);
}

static const char *pdo_id(doc_t *d, uint16_t index)
{
    return ect_arena_print(&d->arena, "p%04X", index);
}

static const ect_entry_t *entry_of(const doc_t *d, uint16_t index, uint8_t subindex)
{
    const ect_object_t *object = ect_od_find(&d->od, index);
    return object ? ect_od_entry(object, subindex) : NULL;
}

/* @return the first field, from `field` on, of an existing entry; NULL: none */
static const ect_field_t *next_field(const doc_t *d, const ect_field_t *field)
{
    while (field && field->index != 0 && !entry_of(d, field->index, field->subindex))
        field++;
    return field && field->index != 0 ? field : NULL;
}

static const ect_field_t *first_field(const doc_t *d)
{
    return d->plant ? next_field(d, d->plant->fields) : NULL;
}

/* @return the first field of the same table: bits of the same entry, or the same list of values */
static const ect_field_t *shown_with(const doc_t *d, const ect_field_t *field)
{
    const ect_field_t *f = first_field(d);
    for (; f != field; f = next_field(d, f + 1)) {
        bool same_entry = f->index == field->index && f->subindex == field->subindex;
        if (field->width > 0 ? same_entry : f->width == 0 && f->values == field->values)
            break;
    }
    return f;
}

/* @return the id of the section with an entry's names of bits and values; NULL: none */
static const char *names_of(doc_t *d, uint16_t index, uint8_t subindex)
{
    for (const ect_field_t *f = first_field(d); f; f = next_field(d, f + 1)) {
        const ect_field_t *shown = shown_with(d, f);
        if (f->index == index && f->subindex == subindex)
            return field_id(d, shown->index, shown->subindex);
    }
    return NULL;
}

/* Successive objects with the same entries, as samples of a sensor, are shown once. @return index after the last */
static uint16_t end_of_alike(const doc_t *d, uint16_t i)
{
    const ect_object_t *first = &d->od.objects[i];
    for (i++; i < d->od.count; i++) {
        const ect_object_t *object = &d->od.objects[i];
        if (object->entries != first->entries || strcmp(or_empty(object->name), or_empty(first->name)) != 0)
            break;
    }
    return i;
}

static const char *title_of(doc_t *d, uint16_t first, uint16_t end)
{
    const ect_object_t *objects = d->od.objects;
    if (end - first == 1)
        return ect_arena_print(&d->arena, "%04Xh %s", objects[first].index, or_empty(objects[first].name));
    return ect_arena_print(&d->arena, "%04Xh to %04Xh %s", objects[first].index, objects[end - 1].index,
                           or_empty(objects[first].name));
}

static bool is_pdo(uint16_t index)
{
    return ect_od_is_rxpdo(index) || ect_od_is_txpdo(index);
}

/* --- sections ----------------------------------------------------------------------------------------------------- */

static const char *protocols_text(doc_t *d)
{
    static const struct {
        uint8_t bit;
        const char *name;
    } names[] = {{ECT_MAILBOX_AOE, "AoE"}, {ECT_MAILBOX_EOE, "EoE"}, {ECT_MAILBOX_COE, "CoE"},
                 {ECT_MAILBOX_FOE, "FoE"}, {ECT_MAILBOX_SOE, "SoE"}, {ECT_MAILBOX_VOE, "VoE"}};
    const char *text = "";
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        if ((d->device->mailbox_protocols & names[i].bit) != 0)
            text = ect_arena_print(&d->arena, "%s%s%s", text, *text ? ", " : "", names[i].name);
    }
    return *text ? text : "none";
}

static void identity(doc_t *d)
{
    page_t *p = &d->page;
    const ect_device_t *v = d->device;
    page_table(p, true);
    PAGE_HEAD(p, CELL("Property"), CELL("Value"));
    PAGE_ROW(p, CELL("Name"), CELL(v->full_name ? v->full_name : v->type_name));
    PAGE_ROW(p, CELL("Vendor"),
             CELL(ect_arena_print(&d->arena, "%s, 0x%08" PRIX32, v->vendor_name, d->identity->vendor_id)));
    PAGE_ROW(p, CELL("Product code"), CELL(hex(d, d->identity->product_code, 8)));
    PAGE_ROW(p, CELL("Revision"), CELL(hex(d, d->identity->revision, 8)));
    PAGE_ROW(p, CELL("Hardware, software version"),
             CELL(ect_arena_print(&d->arena, "%s, %s", or_empty(v->hardware_version), or_empty(v->software_version))));
    PAGE_ROW(p, CELL("Device type (1000h)"), CELL(hex(d, v->device_type, 8)));
    PAGE_ROW(p, CELL("Controller"), CELL(v->esc));
    PAGE_ROW(p, CELL("Ports"), CELL(or_empty(v->physics)));
    PAGE_ROW(p, CELL("EEPROM"), CELL(ect_arena_print(&d->arena, "%u bytes", v->sii_size)));
    PAGE_ROW(p, CELL("Mailbox protocols"), CELL(protocols_text(d)));
    page_table(p, false);
}

/* --- totals --- */

static unsigned int count_entries(const doc_t *d)
{
    unsigned int count = 0;
    for (uint16_t i = 0; i < d->od.count; i++) {
        for (const ect_entry_t *e = d->od.objects[i].entries; e; e = ect_od_next(&d->od.objects[i], e))
            count++;
    }
    return count;
}

static unsigned int count_pdos(const doc_t *d, bool outputs)
{
    unsigned int count = 0;
    for (uint16_t i = 0; i < d->od.count; i++) {
        uint16_t index = d->od.objects[i].index;
        count += outputs ? ect_od_is_rxpdo(index) : ect_od_is_txpdo(index);
    }
    return count;
}

static unsigned int count_signals(const ect_plant_t *plant)
{
    unsigned int count = 0;
    for (uint16_t i = 0; plant && i < plant->signal_group_count; i++) {
        const ect_signal_group_t *group = &plant->signal_groups[i];
        count += group->signal_count * (group->count > 0 ? group->count : 1u);
    }
    return count;
}

static void totals(doc_t *d)
{
    page_t *p = &d->page;
    page_table(p, true);
    PAGE_HEAD(p, CELL("Total"), CELL("Outputs (to the device)"), CELL("Inputs (from the device)"));
    PAGE_ROW(p, CELL("Bytes by default"), CELL(plain(d, ect_device_bytes(d->device, ECT_SM_OUTPUTS))),
             CELL(plain(d, ect_device_bytes(d->device, ECT_SM_INPUTS))));
    PAGE_ROW(p, CELL("PDOs"), CELL(plain(d, count_pdos(d, true))), CELL(plain(d, count_pdos(d, false))));
    page_table(p, false);
    page_paragraph(p, ect_arena_print(&d->arena, "%u objects with %u entries; %u signals of the twin.", d->od.count,
                                      count_entries(d), count_signals(d->plant)));
}

static void layout(doc_t *d)
{
    static const char *const roles[] = {"unused", "mailbox to the slave", "mailbox from the slave", "outputs",
                                        "inputs"};
    page_t *p = &d->page;
    page_table(p, true);
    PAGE_HEAD(p, CELL("Number"), CELL("Role"), CELL("Start"), CELL("Bytes"), CELL("Control"));
    for (unsigned int i = 0; i < d->device->sm_count; i++) {
        const ect_sm_t *sm = &d->device->sm[i];
        PAGE_ROW(p, CELL(plain(d, i)), CELL(roles[ect_sm_role(sm) < 5 ? ect_sm_role(sm) : 0]),
                 CELL(hex(d, sm->start, 4)), CELL(plain(d, ect_device_sm_bytes(d->device, i))),
                 CELL(hex(d, sm->control, 2)));
    }
    page_table(p, false);
}

static const char *cycle_text(doc_t *d, const ect_dc_mode_t *mode)
{
    if (mode->assign_activate == 0)
        return "";
    if (mode->cycle_sync0_ns != 0)
        return ect_arena_print(&d->arena, "%" PRIu32 " ns", mode->cycle_sync0_ns);
    if (mode->factor_sync0 < 0)
        return ect_arena_print(&d->arena, "bus cycle / %d", -mode->factor_sync0);
    return mode->factor_sync0 <= 1 ? "bus cycle" : ect_arena_print(&d->arena, "%d bus cycles", mode->factor_sync0);
}

static void clocks(doc_t *d)
{
    page_t *p = &d->page;
    page_table(p, true);
    PAGE_HEAD(p, CELL("Mode"), CELL("Description"), CELL("AssignActivate"), CELL("SYNC0 cycle"), CELL("SYNC0 shift"));
    for (unsigned int i = 0; i < d->device->dc_mode_count; i++) {
        const ect_dc_mode_t *mode = &d->device->dc_modes[i];
        PAGE_ROW(
            p, CELL(mode->name), CELL(or_empty(mode->description)), CELL(hex(d, mode->assign_activate, 4)),
            CELL(cycle_text(d, mode)),
            CELL(mode->shift_sync0_ns != 0 ? ect_arena_print(&d->arena, "%" PRId32 " ns", mode->shift_sync0_ns) : ""));
    }
    page_table(p, false);
}

static void pdo_entry(doc_t *d, uint32_t mapping, uint32_t bit)
{
    uint16_t index = (uint16_t)(mapping >> 16);
    uint8_t subindex = (uint8_t)(mapping >> 8);
    const ect_entry_t *entry = ect_od_mapped(&d->od, mapping);
    const char *type = entry ? ect_esi_type_of(&d->arena, entry->data_type, mapping & 0xFF) : NULL;
    const cell_t object = {.text = entry ? ect_arena_print(&d->arena, "%04Xh:%u", index, subindex) : "gap",
                           .link = entry ? entry_id(d, index, subindex) : NULL};
    const cell_t name = {.text = entry ? or_empty(entry->name) : "", .link = names_of(d, index, subindex)};
    PAGE_ROW(&d->page, CELL(plain(d, bit / 8)), CELL(plain(d, bit % 8)), CELL(plain(d, mapping & 0xFF)), object, name,
             CELL(or_empty(type)));
}

static void pdo(doc_t *d, uint16_t first, uint16_t end)
{
    const ect_object_t *object = &d->od.objects[first];
    uint32_t bit = 0;
    page_heading(&d->page, 3, pdo_id(d, object->index), title_of(d, first, end));
    page_table(&d->page, true);
    PAGE_HEAD(&d->page, CELL("Byte"), CELL("Bit"), CELL("Bits"), CELL("Object"), CELL("Name"), CELL("Type"));
    for (uint32_t n = 1; n <= ect_od_element(object, 0); n++) {
        uint32_t mapping = ect_od_element(object, n);
        pdo_entry(d, mapping, bit);
        bit += mapping & 0xFF;
    }
    page_table(&d->page, false);
}

static void pdos(doc_t *d)
{
    for (uint16_t i = 0; i < d->od.count; i = end_of_alike(d, i)) {
        if (is_pdo(d->od.objects[i].index))
            pdo(d, i, end_of_alike(d, i));
    }
}

static const char *bits_text(doc_t *d, const ect_field_t *f)
{
    return f->width == 1 ? plain(d, f->bit) : ect_arena_print(&d->arena, "%u to %u", f->bit, f->bit + f->width - 1u);
}

static const char *entry_text(doc_t *d, const ect_field_t *f)
{
    const char *name = or_empty(entry_of(d, f->index, f->subindex)->name);
    return ect_arena_print(&d->arena, "%04Xh:%u %s", f->index, f->subindex, name);
}

static bool has_values(const doc_t *d, const ect_field_t *first)
{
    bool found = false;
    for (const ect_field_t *f = first; f; f = next_field(d, f + 1))
        found |= f->index == first->index && f->subindex == first->subindex && f->values;
    return found;
}

/* One row for each named bit of an entry. */
static void bits(doc_t *d, const ect_field_t *first)
{
    bool values = has_values(d, first);
    page_heading(&d->page, 3, field_id(d, first->index, first->subindex), entry_text(d, first));
    page_table(&d->page, true);
    PAGE_HEAD(&d->page, CELL("Bit"), CELL("Name"), CELL("Meaning"), CELL("Signal"), CELL(values ? "Values" : NULL));
    for (const ect_field_t *f = first; f; f = next_field(d, f + 1)) {
        char text[ECT_FIELD_TEXT];
        if (f->index != first->index || f->subindex != first->subindex)
            continue;
        ect_field_values(f, text);
        PAGE_ROW(&d->page, CELL(bits_text(d, f)), CELL(f->name), CELL(or_empty(f->meaning)), CELL(or_empty(f->signal)),
                 CELL(values ? ect_arena_print(&d->arena, "%s", text) : NULL));
    }
    page_table(&d->page, false);
}

static const char *value_number(doc_t *d, int64_t value)
{
    return value > 9 ? ect_arena_print(&d->arena, "0x%02" PRIX64, (uint64_t)value) : plain(d, (unsigned int)value);
}

/* Entries with the same list of values share a table. */
static void values(doc_t *d, const ect_field_t *first)
{
    const char *entries = "";
    page_heading(&d->page, 3, field_id(d, first->index, first->subindex), entry_text(d, first));
    for (const ect_field_t *f = first; f; f = next_field(d, f + 1)) {
        if (f->width > 0 || f->values != first->values)
            continue;
        entries = ect_arena_print(&d->arena, "%s%s%s%s%s%s", entries, *entries ? ", " : "", entry_text(d, f),
                                  f->signal ? " (signal " : "", or_empty(f->signal), f->signal ? ")" : "");
    }
    page_paragraph(&d->page, entries);
    page_table(&d->page, true);
    PAGE_HEAD(&d->page, CELL("Value"), CELL("Name"));
    for (const ect_value_name_t *v = first->values; v->name; v++)
        PAGE_ROW(&d->page, CELL(value_number(d, v->value)), CELL(v->name));
    if (first->open)
        PAGE_ROW(&d->page, CELL("others"), CELL("a number"));
    page_table(&d->page, false);
}

static void fields(doc_t *d)
{
    for (const ect_field_t *f = first_field(d); f; f = next_field(d, f + 1)) {
        if (shown_with(d, f) != f)
            continue;
        if (f->width > 0)
            bits(d, f);
        else
            values(d, f);
    }
}

/* A family of devices has one folder of charts: eclink for all base units. */
static bool is_of(const chart_t *chart, const ect_device_t *device)
{
    bool family = strcmp(chart->folder, "eclink") == 0 && strncmp(device->name, "vr-bu-", 6) == 0;
    return family || strcmp(chart->folder, device->name) == 0;
}

static void timing(doc_t *d)
{
    for (const chart_t *chart = charts; chart->folder; chart++) {
        if (is_of(chart, d->device))
            page_figure(&d->page, chart->svg, chart->length, chart->caption);
    }
}

static void dictionary(doc_t *d)
{
    page_t *p = &d->page;
    for (uint16_t i = 0; i < d->od.count; i = end_of_alike(d, i)) {
        const ect_object_t *object = &d->od.objects[i];
        page_heading(p, 3, object_id(d, object->index), title_of(d, i, end_of_alike(d, i)));
        page_table(p, true);
        PAGE_HEAD(p, CELL("Sub-index"), CELL("Name"), CELL("Type"), CELL("Access"), CELL("Default"),
                  CELL("Range, unit"));
        for (const ect_entry_t *e = object->entries; e; e = ect_od_next(object, e)) {
            const cell_t name = {or_empty(e->name), names_of(d, object->index, (uint8_t)e->subindex)};
            const cell_t cells[] = {CELL(plain(d, e->subindex)),
                                    name,
                                    CELL(type_text(d, e)),
                                    CELL(access_text(d, e->access)),
                                    CELL(value_text(d, e)),
                                    CELL(range_text(d, object, e)),
                                    {NULL, NULL}};
            page_row(p, false, entry_id(d, object->index, e->subindex), cells);
        }
        page_table(p, false);
    }
}

/* --- elements of an ESI file beyond the description --------------------------------------------------------------- */

static const ect_esi_device_t *model_of(const doc_t *d)
{
    const ect_esi_twin_t *twin = product_twin_of_device(d->device);
    return twin ? ect_esi_twin_model(twin) : NULL;
}

static const char *bytes_text(doc_t *d, const uint8_t *bytes, size_t length)
{
    char *text = ect_arena_alloc(&d->arena, 2 * length + 1);
    for (size_t i = 0; i < length; i++)
        snprintf(text + 2 * i, 3, "%02X", bytes[i]);
    return text;
}

static bool has_start_up(const doc_t *d)
{
    const ect_esi_device_t *model = model_of(d);
    return model && model->mailbox.init_count > 0;
}

static void start_up(doc_t *d)
{
    const ect_esi_mailbox_t *mailbox = &model_of(d)->mailbox;
    page_table(&d->page, true);
    PAGE_HEAD(&d->page, CELL("Transitions"), CELL("Object"), CELL("Data"), CELL("Comment"));
    for (size_t i = 0; i < mailbox->init_count; i++) {
        const ect_esi_init_t *init = &mailbox->inits[i];
        PAGE_ROW(&d->page, CELL(init->transitions),
                 CELL(ect_arena_print(&d->arena, "%04Xh:%u%s", init->index, init->subindex,
                                      init->complete ? " complete" : "")),
                 CELL(bytes_text(d, init->data.bytes, init->data.length)), CELL(init->comment));
    }
    page_table(&d->page, false);
}

static bool has_slots(const doc_t *d)
{
    const ect_esi_device_t *model = model_of(d);
    return model && model->slot_count > 0;
}

static const char *accepts(doc_t *d, const ect_esi_slot_t *slot)
{
    const char *text = "";
    for (size_t k = 0; k < slot->ident_count; k++)
        text = ect_arena_print(&d->arena, "%s%s0x%08" PRIX32 "%s", text, *text ? ", " : "", slot->idents[k],
                               slot->idents[k] == slot->preset ? " (preset)" : "");
    for (size_t k = 0; k < slot->class_count; k++)
        text = ect_arena_print(&d->arena, "%s%sclass %s", text, *text ? ", " : "", slot->classes[k]);
    return text;
}

static void slots(doc_t *d)
{
    const ect_esi_device_t *model = model_of(d);
    page_table(&d->page, true);
    PAGE_HEAD(&d->page, CELL("Slot"), CELL("Modules"), CELL("Accepts"));
    for (size_t i = 0; i < model->slot_count; i++) {
        const ect_esi_slot_t *slot = &model->slots[i];
        PAGE_ROW(&d->page, CELL(slot->name),
                 CELL(ect_arena_print(&d->arena, "%u to %u", slot->instances_min, slot->instances_max)),
                 CELL(accepts(d, slot)));
    }
    page_table(&d->page, false);
}

static bool has_assignments(const doc_t *d)
{
    const ect_esi_device_t *model = model_of(d);
    return model && model->alternative_count + model->mode_assignment_count > 0;
}

static void assignment_rows(doc_t *d, const char *kind, const ect_esi_assignment_t *list, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        const char *pdos_text = "";
        for (size_t k = 0; k < list[i].pdo_count; k++)
            pdos_text = ect_arena_print(&d->arena, "%s%s%04Xh", pdos_text, k > 0 ? " " : "", list[i].pdos[k]);
        PAGE_ROW(&d->page, CELL(kind),
                 CELL(ect_arena_print(&d->arena, "%s%s", list[i].name, list[i].preset ? " (preset)" : "")),
                 CELL(plain(d, list[i].sm)), CELL(pdos_text));
    }
}

static void alternatives(doc_t *d)
{
    const ect_esi_device_t *model = model_of(d);
    page_table(&d->page, true);
    PAGE_HEAD(&d->page, CELL("Kind"), CELL("Name"), CELL("SyncManager"), CELL("PDOs"));
    assignment_rows(d, "assignment", model->alternatives, model->alternative_count);
    assignment_rows(d, "clock mode", model->mode_assignments, model->mode_assignment_count);
    page_table(&d->page, false);
}

static bool has_categories(const doc_t *d)
{
    return d->device->category_count > 0;
}

static void categories(doc_t *d)
{
    page_table(&d->page, true);
    PAGE_HEAD(&d->page, CELL("Number"), CELL("Data"));
    for (unsigned int i = 0; i < d->device->category_count; i++) {
        const ect_category_t *category = &d->device->categories[i];
        PAGE_ROW(&d->page, CELL(plain(d, category->number)), CELL(bytes_text(d, category->data, category->length)));
    }
    page_table(&d->page, false);
}

/* --- the document ------------------------------------------------------------------------------------------------- */

static bool has_clocks(const doc_t *d)
{
    return d->device->dc_mode_count > 0;
}

static bool has_fields(const doc_t *d)
{
    return first_field(d) != NULL;
}

static bool has_charts(const doc_t *d)
{
    bool found = false;
    for (const chart_t *chart = charts; chart->folder; chart++)
        found |= is_of(chart, d->device);
    return found && d->page.html;
}

static const struct section {
    const char *id, *title;
    void (*write)(doc_t *d);
    bool (*present)(const doc_t *d); /* condition; NULL: always */
} sections[] = {
    {"identity", "Identity", identity, NULL},
    {"totals", "Totals", totals, NULL},
    {"syncmanagers", "SyncManagers", layout, NULL},
    {"clocks", "Distributed clocks", clocks, has_clocks},
    {"pdos", "Process data", pdos, NULL},
    {"fields", "Bits and values", fields, has_fields},
    {"start-up", "Start-up commands", start_up, has_start_up},
    {"slots", "Slots", slots, has_slots},
    {"alternatives", "Alternative PDO assignments", alternatives, has_assignments},
    {"categories", "EEPROM categories", categories, has_categories},
    {"timing", "Behaviour over time", timing, has_charts},
    {"objects", "Objects", dictionary, NULL},
};
enum { SECTIONS = sizeof sections / sizeof sections[0] };

static bool is_present(const doc_t *d, const struct section *s)
{
    return !s->present || s->present(d);
}

/* Links to all objects, or to those of PDOs only. */
static void object_links(doc_t *d, const char *label, bool pdos_only)
{
    cell_t *links = ect_arena_alloc(&d->arena, (d->od.count + 1u) * sizeof *links);
    size_t count = 0;
    for (uint16_t i = 0; i < d->od.count; i = end_of_alike(d, i)) {
        uint16_t index = d->od.objects[i].index;
        if (!pdos_only)
            links[count++] = (cell_t){ect_arena_print(&d->arena, "%04Xh", index), object_id(d, index)};
        else if (is_pdo(index))
            links[count++] = (cell_t){title_of(d, i, end_of_alike(d, i)), pdo_id(d, index)};
    }
    page_links(&d->page, label, links);
}

static void contents(doc_t *d)
{
    cell_t links[SECTIONS + 1] = {{0}};
    size_t count = 0;
    for (size_t i = 0; i < SECTIONS; i++) {
        if (is_present(d, &sections[i]))
            links[count++] = (cell_t){sections[i].title, sections[i].id};
    }
    if (!d->page.html)
        return;
    fputs("<nav>\n", d->page.file);
    page_links(&d->page, "Contents", links);
    object_links(d, "Process data", true);
    object_links(d, "Objects", false);
    fputs("</nav>\n", d->page.file);
}

static void write_document(doc_t *d)
{
    page_begin(&d->page, d->device->type_name,
               ect_arena_print(&d->arena, "%s. Written by ectwin %s from the description of the twin.",
                               or_empty(d->device->summary), ECTWIN_VERSION));
    contents(d);
    for (size_t i = 0; i < SECTIONS; i++) {
        if (!is_present(d, &sections[i]))
            continue;
        page_heading(&d->page, 2, sections[i].id, sections[i].title);
        sections[i].write(d);
    }
    page_end(&d->page);
}

int output_document(const char *who, const ect_twin_config_t *twin, bool html, const char *path)
{
    output_text_t out;
    int status = EXIT_RUN;
    doc_t doc = {.page = {.html = html}, .device = twin->device, .plant = twin->plant, .identity = &twin->identity};
    doc.od = ect_esi_values(&doc.arena, twin->device, &twin->identity);
    doc.page.file = output_open(who, &out);
    if (doc.page.file) {
        write_document(&doc);
        status = output_close(who, &out, path);
    }
    ect_arena_free(&doc.arena);
    return status;
}

int command_doc(int argc, char **argv)
{
    static const struct argp argp = {
        .options = options,
        .parser = output_parse,
        .args_doc = "DEVICE",
        .doc =
            "Writes identity, process data, named bits and the dictionary of a device for people, as Markdown or HTML.",
        .children = output_children,
    };
    output_args_t args = {.key = KEY_HTML};
    argp_parse(&argp, argc, argv, 0, NULL, &args);
    int status = output_document("ectwin doc", &args.twins.twins[0], args.given, args.output);
    twin_args_free(&args.twins);
    return status;
}
