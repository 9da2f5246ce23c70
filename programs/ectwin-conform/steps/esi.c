/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "steps/esi.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "steps/reader.h"

enum { LINES_MOST = 20 };

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

/* In a file of many devices: the device with the slave's product code and revision, or with its product code. */
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
    esi->documented.source = esi->path;
    if (esi->twin)
        ect_facts_of_esi(&esi->documented, ect_esi_twin_product(esi->twin)->device, ect_esi_twin_model(esi->twin));
    return true;
}

static void forget(ect_facts_t *facts, const char *source)
{
    ect_facts_free(facts);
    *facts = (ect_facts_t){.source = source};
}

void cf_esi_close(cf_esi_t *esi)
{
    ect_facts_free(&esi->documented);
    ect_facts_free(&esi->known);
    ect_facts_free(&esi->found);
    free(esi->json);
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

/* --- comparison --------------------------------------------------------------------------------------------------- */

/* Content and size of PDOs of a slot depend on the module in the slot. */
static bool is_of_modules(const ect_fact_t *fact)
{
    return (fact->kind >= ECT_FACT_PDO && fact->kind <= ECT_FACT_PDO_ENTRY_TYPE) || fact->kind == ECT_FACT_SM_LENGTH ||
           fact->kind == ECT_FACT_SM_ENABLED || (fact->kind >= ECT_FACT_OBJECT && fact->index >= 0x1600);
}

static void expect_kinds(cf_esi_t *esi, ect_fact_kind_t first, ect_fact_kind_t last)
{
    ect_facts_take(&esi->known, &esi->documented, first, last);
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

/* Adds every difference to the evidence; the first one is the reason of the failure. */
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

/* --- the slave's dictionary --------------------------------------------------------------------------------------- */

/* Reads objects into esi->json. @param sms  bit n: the PDOs of SyncManager n; 0: all objects */
static void read_objects(cf_t *c, uint32_t sms)
{
    cf_esi_t *esi = c->esi;
    size_t size;
    free(esi->json);
    esi->json = NULL;
    ect_reader_t *reader = cf_reader_open(c);
    FILE *out = open_memstream(&esi->json, &size);
    if (!out)
        cf_fail(c, "out of memory");
    const ect_reader_result_t result = sms != 0 ? ect_reader_json_assigned(reader, sms, out)
                                                : ect_reader_json(reader, ECT_READER_IDENTITY_AND_PDOS, out);
    const bool written = fclose(out) == 0;
    cf_reader_close(c, result);
    forget(&esi->known, esi->path);
    forget(&esi->found, "the dictionary");
    if (!written || !ect_facts_of_dictionary(&esi->found, esi->json))
        cf_fail(c, "out of memory");
}

void cf_esi_expect_assigned(cf_t *c)
{
    uint32_t sms = 0;
    if (!cf_esi_model(c))
        return;
    for (unsigned int sm = 0; sm < c->facts.sm_count; sm++) {
        if (c->facts.sm[sm].type >= ECT_SM_OUTPUTS)
            sms |= UINT32_C(1) << sm;
    }
    if (sms == 0)
        return;
    read_objects(c, sms);
    expect_kinds(c->esi, ECT_FACT_PDO, ECT_FACT_PDO_ENTRY);
    expect_same(c);
}

void cf_esi_expect_objects(cf_t *c)
{
    if (!cf_esi_model(c))
        return;
    read_objects(c, 0);
    expect_kinds(c->esi, ECT_FACT_PDO_NAME, ECT_FACT_PDO_NAME);
    expect_kinds(c->esi, ECT_FACT_OBJECT, ECT_FACT_ENTRY_UNIT);
    expect_same(c);
}
