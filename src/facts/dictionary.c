/* SPDX-License-Identifier: MIT */
/* Facts of a slave's dictionary, as ectwin-probe reads it over the bus. */
#include <cjson/cJSON.h>
#include <inttypes.h>
#include <string.h>

#include "facts/facts.h"
#include "od/pdo.h"
#include "wire/bytes.h"

enum { VALUE_MOST = 64 };

typedef struct value {
    uint8_t bytes[VALUE_MOST];
    size_t length;
} value_t;

static unsigned int number_of(const cJSON *parent, const char *name)
{
    const cJSON *number = cJSON_GetObjectItemCaseSensitive(parent, name);
    return cJSON_IsNumber(number) && number->valuedouble >= 0 && number->valuedouble <= UINT32_MAX
               ? (unsigned int)number->valuedouble
               : 0;
}

/* @return an index or a sub-index; the JSON number may have any value */
static unsigned int place_of(const cJSON *parent, const char *name)
{
    return number_of(parent, name) & UINT16_MAX;
}

static const char *text_of(const cJSON *parent, const char *name)
{
    const char *text = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(parent, name));
    return text != NULL ? text : "";
}

/* @return false: no such member */
static bool bytes_of(const cJSON *parent, const char *name, value_t *value)
{
    const char *text = text_of(parent, name);
    *value = (value_t){.length = 0};
    unsigned int byte;
    for (; value->length < VALUE_MOST && sscanf(text, "%2x", &byte) == 1 && text[1] != '\0'; text += 2)
        value->bytes[value->length++] = (uint8_t)byte;
    return value->length > 0;
}

static bool is_signed(unsigned int type)
{
    return (type >= ECT_TYPE_INTEGER8 && type <= ECT_TYPE_INTEGER32) || type == ECT_TYPE_INTEGER64;
}

static int64_t integer_of(const value_t *value, unsigned int type)
{
    uint8_t wire[8];
    size_t length = value->length < sizeof wire ? value->length : sizeof wire;
    bool negative = is_signed(type) && (value->bytes[length - 1] & 0x80) != 0;
    memset(wire, negative ? 0xFF : 0, sizeof wire);
    memcpy(wire, value->bytes, length);
    return (int64_t)ect_load_le64(wire);
}

static const cJSON *entry_of(const cJSON *object, unsigned int subindex)
{
    const cJSON *entry;
    cJSON_ArrayForEach(entry, cJSON_GetObjectItemCaseSensitive(object, "entries"))
    {
        if (place_of(entry, "subindex") == subindex)
            return entry;
    }
    return NULL;
}

/* @return false: the slave has not returned the value */
static bool element(const cJSON *object, unsigned int subindex, uint32_t *number)
{
    value_t value;
    if (!bytes_of(entry_of(object, subindex), "value", &value))
        return false;
    *number = (uint32_t)integer_of(&value, ECT_TYPE_UNSIGNED32);
    return true;
}

static void add_entry(ect_facts_t *facts, unsigned int index, const cJSON *entry)
{
    unsigned int subindex = place_of(entry, "subindex");
    unsigned int type = number_of(entry, "type");
    value_t value;
    value_t maximum;
    if (!ect_facts_are_of_pdos(index))
        (void)ect_facts_add(facts, ECT_FACT_ENTRY, index, subindex, "%u bits", number_of(entry, "bits"));
    (void)ect_facts_add(facts, ECT_FACT_ENTRY_TYPE, index, subindex, "0x%04X", type);
    ect_facts_add_access(facts, index, subindex, number_of(entry, "access"));
    ect_facts_add_text(facts, ECT_FACT_ENTRY_NAME, index, subindex, text_of(entry, "name"),
                       strlen(text_of(entry, "name")));
    bool has_default = index == 0x1000 || index == 0x1008
                           ? bytes_of(entry, "value", &value)
                           : !ect_facts_are_known_elsewhere(index) && bytes_of(entry, "default", &value);
    if (has_default && !ect_facts_are_of_pdos(index))
        ect_facts_add_default(facts, index, subindex, value.bytes, value.length);
    if (bytes_of(entry, "minimum", &value) && bytes_of(entry, "maximum", &maximum))
        (void)ect_facts_add(facts, ECT_FACT_ENTRY_LIMITS, index, subindex, "%" PRId64 " to %" PRId64,
                            integer_of(&value, type), integer_of(&maximum, type));
    if (bytes_of(entry, "unit", &value))
        (void)ect_facts_add(facts, ECT_FACT_ENTRY_UNIT, index, subindex, "0x%04X",
                            (unsigned int)integer_of(&value, ECT_TYPE_UNSIGNED16));
}

static void add_object(ect_facts_t *facts, const cJSON *object)
{
    unsigned int index = place_of(object, "index");
    const cJSON *entry;
    (void)ect_facts_add(facts, ECT_FACT_OBJECT, index, 0, "code %u", number_of(object, "code"));
    if (!ect_facts_are_of_pdos(index))
        ect_facts_add_text(facts, ECT_FACT_OBJECT_NAME, index, 0, text_of(object, "name"),
                           strlen(text_of(object, "name")));
    cJSON_ArrayForEach(entry, cJSON_GetObjectItemCaseSensitive(object, "entries")) add_entry(facts, index, entry);
}

static void add_pdo(ect_facts_t *facts, const cJSON *object)
{
    unsigned int index = place_of(object, "index");
    uint32_t count;
    uint32_t mapping;
    if (!element(object, 0, &count))
        return;
    (void)ect_facts_add(facts, ECT_FACT_PDO, index, 0, "%s", ect_od_is_rxpdo((uint16_t)index) ? "outputs" : "inputs");
    ect_facts_add_text(facts, ECT_FACT_PDO_NAME, index, 0, text_of(object, "name"), strlen(text_of(object, "name")));
    for (unsigned int n = 1; n <= count && n <= 255 && element(object, n, &mapping); n++)
        ect_facts_add_mapping(facts, index, n, mapping >> 16, mapping >> 8 & 0xFF, mapping & 0xFF);
    facts->complete[ECT_FACT_PDO_ENTRY] = true;
}

static void add_assignment(ect_facts_t *facts, const cJSON *object)
{
    uint32_t count;
    uint32_t pdo;
    if (!element(object, 0, &count))
        return;
    for (unsigned int n = 1; n <= count && n <= 255 && element(object, n, &pdo); n++)
        (void)ect_facts_add(facts, ECT_FACT_PDO_SM, pdo & 0xFFFF, 0, "%u",
                            place_of(object, "index") - ECT_OD_ASSIGNMENT);
}

static void add_identity(ect_facts_t *facts, const cJSON *object)
{
    static const ect_fact_kind_t kinds[] = {ECT_FACT_VENDOR, ECT_FACT_PRODUCT, ECT_FACT_REVISION};
    uint32_t number;
    for (unsigned int i = 0; i < 3; i++) {
        if (element(object, i + 1, &number))
            (void)ect_facts_add(facts, kinds[i], 0, 0, "0x%08" PRIX32, number);
    }
}

static void add_values(ect_facts_t *facts, const cJSON *object)
{
    unsigned int index = place_of(object, "index");
    if (index == 0x1018)
        add_identity(facts, object);
    else if (ect_od_is_rxpdo((uint16_t)index) || ect_od_is_txpdo((uint16_t)index))
        add_pdo(facts, object);
    else if (index >= ECT_OD_ASSIGNMENT && index < ECT_OD_ASSIGNMENT + 32)
        add_assignment(facts, object);
}

static bool has(const ect_facts_t *facts, ect_fact_kind_t kind, uint16_t index)
{
    for (size_t i = 0; i < facts->count; i++) {
        if (facts->list[i].kind == kind && facts->list[i].index == index)
            return true;
    }
    return false;
}

/* Adds "no SyncManager" for unassigned PDOs, if the slave has assignments. */
static void add_unassigned(ect_facts_t *facts, const cJSON *objects)
{
    const cJSON *object;
    bool assigns = false;
    cJSON_ArrayForEach(object, objects)
    {
        uint32_t count;
        unsigned int index = place_of(object, "index");
        assigns = assigns || ((index == 0x1C12 || index == 0x1C13) && element(object, 0, &count));
    }
    for (size_t i = 0, count = facts->count; assigns && i < count; i++) {
        uint16_t index = facts->list[i].index;
        if (facts->list[i].kind == ECT_FACT_PDO && !has(facts, ECT_FACT_PDO_SM, index))
            (void)ect_facts_add(facts, ECT_FACT_PDO_SM, index, 0, "none");
    }
}

bool ect_facts_of_objects(ect_facts_t *facts, const cJSON *dictionary)
{
    const cJSON *objects = cJSON_GetObjectItemCaseSensitive(dictionary, "objects");
    const cJSON *object;
    bool described = cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(dictionary, "described"));
    cJSON_ArrayForEach(object, objects)
    {
        if (described)
            add_object(facts, object);
        add_values(facts, object);
    }
    add_unassigned(facts, objects);
    facts->complete[ECT_FACT_OBJECT] = described;
    facts->complete[ECT_FACT_ENTRY] = described;
    return cJSON_IsArray(objects);
}

bool ect_facts_of_dictionary(ect_facts_t *facts, const char *json)
{
    cJSON *root = cJSON_Parse(json);
    bool fine = ect_facts_of_objects(facts, root);
    cJSON_Delete(root);
    return fine;
}
