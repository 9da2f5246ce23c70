/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "steps/esi.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "steps/coe_walk.h"

enum { VALUE = 256, ASSIGNMENT = 0x1C10, LINES_MOST = 20 };

/* --- the file ----------------------------------------------------------------------------------------------------- */

bool cf_esi_open(cf_esi_t *esi, const char *operand, const char *schema, char *text)
{
    const char *hash = ect_esi_selector(operand);
    esi->operand = operand;
    esi->path = strndup(operand, hash ? (size_t)(hash - operand) : strlen(operand));
    esi->file = esi->path ? ect_esi_open(esi->path, text, CF_ESI_TEXT) : NULL;
    esi->schema = esi->file && schema ? ect_esi_schema_open(schema, text, CF_ESI_TEXT) : NULL;
    return esi->file && (!schema || esi->schema);
}

/* A file of many devices has one with the slave's numbers, or at least its product code. */
static void selector_of_slave(const cf_esi_t *esi, const cf_facts_t *facts, char *selector, size_t room)
{
    size_t count;
    const ect_esi_head_t *heads = ect_esi_heads(esi->file, &count);
    bool product = false, revision = false;
    for (size_t i = 0; i < count; i++) {
        product = product || heads[i].product_code == facts->product;
        revision = revision || (heads[i].product_code == facts->product && heads[i].revision == facts->revision_no);
    }
    selector[0] = 0;
    if (revision)
        snprintf(selector, room, "@%" PRIu32 "/%" PRIu32, facts->product, facts->revision_no);
    else if (product)
        snprintf(selector, room, "@%" PRIu32, facts->product);
}

bool cf_esi_choose(cf_esi_t *esi, const cf_facts_t *facts, char *text)
{
    char selector[200];
    const char *hash = ect_esi_selector(esi->operand);
    if (hash)
        snprintf(selector, sizeof selector, "%s", hash + 1);
    else
        selector_of_slave(esi, facts, selector, sizeof selector);
    esi->device = ect_esi_select(esi->file, selector, text, CF_ESI_TEXT);
    if (!esi->device)
        return false;
    snprintf(esi->title, sizeof esi->title, "%s, %s revision 0x%08" PRIX32, esi->path, esi->device->type,
             esi->device->revision);
    esi->twin = ect_esi_twin_of(esi->file, esi->device, NULL, 0, esi->why, sizeof esi->why);
    esi->said.source = esi->path;
    if (esi->twin)
        ect_facts_of_esi(&esi->said, ect_esi_twin_product(esi->twin)->device, ect_esi_twin_model(esi->twin));
    return true;
}

static void forget(ect_facts_t *facts, const char *source)
{
    ect_facts_free(facts);
    *facts = (ect_facts_t){.source = source};
}

void cf_esi_close(cf_esi_t *esi)
{
    ect_facts_free(&esi->said);
    ect_facts_free(&esi->known);
    ect_facts_free(&esi->found);
    cJSON_Delete(esi->dictionary);
    ect_esi_twin_free(esi->twin);
    ect_esi_schema_close(esi->schema);
    ect_esi_close(esi->file);
    free(esi->path);
    *esi = (cf_esi_t){0};
}

const ect_esi_device_t *cf_esi_model(const cf_t *c)
{
    return c->esi && c->esi->twin ? c->esi->device : NULL;
}

/* --- comparing ---------------------------------------------------------------------------------------------------- */

/* Content and number of bytes of a module depend on the module that is plugged in. */
static bool is_of_modules(const ect_fact_t *fact)
{
    return (fact->kind >= ECT_FACT_PDO && fact->kind <= ECT_FACT_PDO_ENTRY_TYPE) || fact->kind == ECT_FACT_SM_LENGTH ||
           fact->kind == ECT_FACT_SM_ENABLED || (fact->kind >= ECT_FACT_OBJECT && fact->index >= 0x1600);
}

static void expect_kinds(cf_esi_t *esi, ect_fact_kind_t first, ect_fact_kind_t last)
{
    ect_facts_take(&esi->known, &esi->said, first, last);
    if (esi->device->slot_count == 0)
        return;
    size_t kept = 0;
    for (size_t i = 0; i < esi->known.count; i++) {
        if (!is_of_modules(&esi->known.list[i]))
            esi->known.list[kept++] = esi->known.list[i];
    }
    esi->known.count = kept;
    for (ect_fact_kind_t kind = first; kind <= last; kind++)
        esi->known.complete[kind] = false;
}

/* Every difference is a step of the evidence; the first one is the reason. */
static void expect_same(cf_t *c)
{
    char *lines = NULL, first[CF_ESI_TEXT] = "";
    size_t size = 0, count = 0;
    FILE *out = open_memstream(&lines, &size);
    if (!out)
        cf_fail(c, "out of memory");
    size_t all = ect_facts_compare(&c->esi->known, &c->esi->found, out);
    (void)fclose(out);
    for (const char *line = lines; *line != 0 && count < LINES_MOST; count++) {
        int length = (int)strcspn(line, "\n");
        if (count == 0)
            snprintf(first, sizeof first, "%.*s", length, line);
        cf_remark(c, "%.*s", length, line);
        line += length + (line[length] == '\n');
    }
    free(lines);
    if (all == 1)
        cf_fail(c, "%.350s", first);
    if (all > 1)
        cf_fail(c, "%.300s, and %zu more differences", first, all - 1);
}

void cf_esi_expect_sii(cf_t *c, ect_fact_kind_t first, ect_fact_kind_t last)
{
    if (!cf_esi_model(c))
        return;
    forget(&c->esi->known, c->esi->path);
    forget(&c->esi->found, "the EEPROM");
    expect_kinds(c->esi, first, last);
    ect_facts_of_sii(&c->esi->found, c->facts.sii, c->facts.sii_size);
    expect_same(c);
}

/* --- the slave's dictionary, in the form of ectwin-probe ---------------------------------------------------------- */

static cJSON *begin(cf_t *c, bool described)
{
    cJSON_Delete(c->esi->dictionary);
    c->esi->dictionary = cJSON_CreateObject();
    cJSON_AddBoolToObject(c->esi->dictionary, "described", described);
    return cJSON_AddArrayToObject(c->esi->dictionary, "objects");
}

static cJSON *add_object(cJSON *objects, uint16_t index)
{
    cJSON *object = cJSON_CreateObject();
    cJSON_AddItemToArray(objects, object);
    cJSON_AddNumberToObject(object, "index", index);
    return object;
}

static cJSON *add_entry(cJSON *entries, unsigned int sub)
{
    cJSON *entry = cJSON_CreateObject();
    cJSON_AddItemToArray(entries, entry);
    cJSON_AddNumberToObject(entry, "subindex", sub);
    return entry;
}

static void add_bytes(cJSON *entry, const char *name, const uint8_t *bytes, size_t length)
{
    char text[2 * VALUE + 1] = "";
    for (size_t i = 0; i < length && i < VALUE; i++)
        snprintf(text + 2 * i, 3, "%02x", bytes[i]);
    cJSON_AddStringToObject(entry, name, text);
}

/* The values of objects that identify the slave. @return whether the upload succeeded */
static bool add_value(cf_t *c, cJSON *entry, uint16_t index, uint8_t sub)
{
    uint8_t value[VALUE] = {0};
    size_t size = sizeof value;
    if (cf_upload(c, index, sub, false, value, &size) != 0)
        return false;
    add_bytes(entry, "value", value, size);
    return true;
}

static bool is_identity(uint16_t index)
{
    return index == 0x1000 || index == 0x1008 || index == 0x1018 || ect_facts_are_of_pdos(index);
}

/* The optional fields have the order of their bits, those with the entry's length among them; then the name. */
static void add_details(cf_t *c, cJSON *entry, const uint8_t *answer, int bytes)
{
    static const struct {
        uint8_t bit;
        const char *name;
    } fields[] = {{COE_INFO_UNIT, "unit"},
                  {COE_INFO_DEFAULT, "default"},
                  {COE_INFO_MINIMUM, "minimum"},
                  {COE_INFO_MAXIMUM, "maximum"}};
    const int length = (ect_load_le16(answer + 6) + 7) / 8;
    int at = COE_ENTRY_BYTES;
    for (size_t i = 0; i < sizeof fields / sizeof fields[0]; i++) {
        int size = fields[i].bit == COE_INFO_UNIT ? 2 : length;
        if ((answer[3] & fields[i].bit) == 0 || at + size > bytes)
            continue;
        add_bytes(entry, fields[i].name, answer + at, (size_t)size);
        at += size;
    }
    char name[COE_NAME] = "";
    if (!coe_is_full(c, bytes))
        snprintf(name, sizeof name, "%.*s", bytes - at, (const char *)answer + at);
    cJSON_AddStringToObject(entry, "name", name);
}

/* A sub-index of no type and no length is a gap. */
static void add_described_entry(cf_t *c, cJSON *entries, uint16_t index, uint8_t sub)
{
    uint8_t answer[COE_ANSWER];
    int bytes = coe_describe_entry(c, index, sub, COE_INFO_ALL, answer);
    if (bytes < 0 || (ect_load_le16(answer + 4) == 0 && ect_load_le16(answer + 6) == 0))
        return;
    cJSON *entry = add_entry(entries, sub);
    cJSON_AddNumberToObject(entry, "type", ect_load_le16(answer + 4));
    cJSON_AddNumberToObject(entry, "bits", ect_load_le16(answer + 6));
    cJSON_AddNumberToObject(entry, "access", ect_load_le16(answer + 8));
    add_details(c, entry, answer, bytes);
    if (is_identity(index))
        (void)add_value(c, entry, index, sub);
}

static void add_described(cf_t *c, const coe_object_t *o)
{
    cJSON *object = add_object(cJSON_GetObjectItemCaseSensitive(c->esi->dictionary, "objects"), o->index);
    cJSON_AddNumberToObject(object, "code", o->code);
    cJSON_AddStringToObject(object, "name", o->name);
    cJSON *entries = cJSON_AddArrayToObject(object, "entries");
    for (unsigned int sub = 0; sub <= o->most; sub++)
        add_described_entry(c, entries, o->index, (uint8_t)sub);
}

/* An object of numbers, as many as sub-index 0 counts. @return false: there is none */
static bool add_numbers(cf_t *c, cJSON *objects, uint16_t index)
{
    uint32_t code;
    if (!cf_object_exists(c, index, 0, &code))
        return false;
    unsigned int count = (uint8_t)cf_upload_number(c, index, 0);
    cJSON *entries = cJSON_AddArrayToObject(add_object(objects, index), "entries");
    for (unsigned int sub = 0; sub <= count; sub++)
        (void)add_value(c, add_entry(entries, sub), index, (uint8_t)sub);
    return true;
}

static void add_assigned(cf_t *c, cJSON *objects, uint16_t assignment)
{
    if (!add_numbers(c, objects, assignment))
        return;
    unsigned int count = (uint8_t)cf_upload_number(c, assignment, 0);
    for (unsigned int n = 1; n <= count; n++)
        (void)add_numbers(c, objects, (uint16_t)cf_upload_number(c, assignment, (uint8_t)n));
}

/* --- comparisons -------------------------------------------------------------------------------------------------- */

static void take_dictionary(cf_t *c)
{
    forget(&c->esi->known, c->esi->path);
    forget(&c->esi->found, "the dictionary");
    if (!ect_facts_of_objects(&c->esi->found, c->esi->dictionary))
        cf_fail(c, "out of memory");
}

void cf_esi_expect_assigned(cf_t *c)
{
    if (!cf_esi_model(c))
        return;
    cJSON *objects = begin(c, false);
    for (unsigned int sm = 0; sm < c->facts.sm_count; sm++) {
        if (c->facts.sm[sm].type >= ECT_SM_OUTPUTS)
            add_assigned(c, objects, (uint16_t)(ASSIGNMENT + sm));
    }
    take_dictionary(c);
    expect_kinds(c->esi, ECT_FACT_PDO, ECT_FACT_PDO_ENTRY);
    expect_same(c);
}

void cf_esi_expect_objects(cf_t *c)
{
    if (!cf_esi_model(c))
        return;
    (void)begin(c, true);
    (void)coe_walk(c, add_described);
    take_dictionary(c);
    expect_kinds(c->esi, ECT_FACT_PDO_NAME, ECT_FACT_PDO_NAME);
    expect_kinds(c->esi, ECT_FACT_OBJECT, ECT_FACT_ENTRY_UNIT);
    expect_same(c);
}
