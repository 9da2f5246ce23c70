/* SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 200809L
#include "facts/facts.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "wire/assert.h"

/* Formats of a place in a line. */
typedef enum area { WHOLE, BY_NUMBER, BY_INDEX, BY_ENTRY, BY_SUBINDEX, BY_PATH } area_t;

static const struct row {
    const char *place; /* before the numbers */
    const char *what;
    area_t area;
    ect_fact_kind_t parent; /* without a fact of this kind its absence is not reported; the kind itself: none */
} rows[ECT_FACT_KINDS] = {
    [ECT_FACT_VENDOR] = {"identity", "vendor id", WHOLE, ECT_FACT_VENDOR},
    [ECT_FACT_PRODUCT] = {"identity", "product code", WHOLE, ECT_FACT_PRODUCT},
    [ECT_FACT_REVISION] = {"identity", "revision", WHOLE, ECT_FACT_REVISION},
    [ECT_FACT_TYPE] = {"device", "type", WHOLE, ECT_FACT_TYPE},
    [ECT_FACT_NAME] = {"device", "name", WHOLE, ECT_FACT_NAME},
    [ECT_FACT_VENDOR_NAME] = {"device", "vendor's name", WHOLE, ECT_FACT_VENDOR_NAME},
    [ECT_FACT_GROUP] = {"device", "group", WHOLE, ECT_FACT_GROUP},
    [ECT_FACT_GROUP_NAME] = {"device", "group's name", WHOLE, ECT_FACT_GROUP_NAME},
    [ECT_FACT_PORTS] = {"device", "ports", WHOLE, ECT_FACT_PORTS},
    [ECT_FACT_EBUS] = {"device", "E-bus current", WHOLE, ECT_FACT_EBUS},
    [ECT_FACT_TIMEOUT] = {"timeout ", "", BY_NUMBER, ECT_FACT_TIMEOUT},
    [ECT_FACT_EEPROM_SIZE] = {"EEPROM", "size", WHOLE, ECT_FACT_EEPROM_SIZE},
    [ECT_FACT_CONFIG] = {"EEPROM word ", "", BY_NUMBER, ECT_FACT_CONFIG},
    [ECT_FACT_CHECKSUM] = {"EEPROM", "checksum", WHOLE, ECT_FACT_CHECKSUM},
    [ECT_FACT_PROTOCOLS] = {"mailbox", "protocols", WHOLE, ECT_FACT_PROTOCOLS},
    [ECT_FACT_COE] = {"mailbox", "CoE abilities", WHOLE, ECT_FACT_COE},
    [ECT_FACT_MAILBOX_OUT] = {"mailbox", "to the slave", WHOLE, ECT_FACT_MAILBOX_OUT},
    [ECT_FACT_MAILBOX_IN] = {"mailbox", "from the slave", WHOLE, ECT_FACT_MAILBOX_IN},
    [ECT_FACT_BOOT_OUT] = {"mailbox", "to the slave in BOOT", WHOLE, ECT_FACT_BOOT_OUT},
    [ECT_FACT_BOOT_IN] = {"mailbox", "from the slave in BOOT", WHOLE, ECT_FACT_BOOT_IN},
    [ECT_FACT_SM] = {"SM", "", BY_NUMBER, ECT_FACT_SM},
    [ECT_FACT_SM_START] = {"SM", "start", BY_NUMBER, ECT_FACT_SM},
    [ECT_FACT_SM_LENGTH] = {"SM", "length", BY_NUMBER, ECT_FACT_SM},
    [ECT_FACT_SM_CONTROL] = {"SM", "control byte", BY_NUMBER, ECT_FACT_SM},
    [ECT_FACT_SM_ENABLED] = {"SM", "enabled", BY_NUMBER, ECT_FACT_SM},
    [ECT_FACT_SM_DEFAULT] = {"SM", "DefaultSize", BY_NUMBER, ECT_FACT_SM},
    [ECT_FACT_SM_MINIMUM] = {"SM", "smallest length", BY_NUMBER, ECT_FACT_SM},
    [ECT_FACT_SM_MAXIMUM] = {"SM", "largest length", BY_NUMBER, ECT_FACT_SM},
    [ECT_FACT_FMMU] = {"FMMU", "", BY_NUMBER, ECT_FACT_FMMU},
    [ECT_FACT_PDO] = {"PDO ", "", BY_INDEX, ECT_FACT_PDO},
    [ECT_FACT_PDO_SM] = {"PDO ", "SyncManager", BY_INDEX, ECT_FACT_PDO},
    [ECT_FACT_PDO_NAME] = {"PDO ", "name", BY_INDEX, ECT_FACT_PDO},
    [ECT_FACT_PDO_FIXED] = {"PDO ", "fixed", BY_INDEX, ECT_FACT_PDO},
    [ECT_FACT_PDO_MANDATORY] = {"PDO ", "mandatory", BY_INDEX, ECT_FACT_PDO},
    [ECT_FACT_PDO_EXCLUDES] = {"PDO ", "excludes", BY_INDEX, ECT_FACT_PDO},
    [ECT_FACT_PDO_ENTRY] = {"PDO ", "", BY_ENTRY, ECT_FACT_PDO},
    [ECT_FACT_PDO_ENTRY_NAME] = {"PDO ", "name", BY_ENTRY, ECT_FACT_PDO_ENTRY},
    [ECT_FACT_PDO_ENTRY_TYPE] = {"PDO ", "data type", BY_ENTRY, ECT_FACT_PDO_ENTRY},
    [ECT_FACT_OBJECT] = {"object ", "", BY_INDEX, ECT_FACT_OBJECT},
    [ECT_FACT_OBJECT_NAME] = {"object ", "name", BY_INDEX, ECT_FACT_OBJECT},
    [ECT_FACT_ENTRY] = {"object ", "length", BY_SUBINDEX, ECT_FACT_OBJECT},
    [ECT_FACT_ENTRY_TYPE] = {"object ", "data type", BY_SUBINDEX, ECT_FACT_ENTRY},
    [ECT_FACT_ENTRY_ACCESS] = {"object ", "access", BY_SUBINDEX, ECT_FACT_ENTRY},
    [ECT_FACT_ENTRY_NAME] = {"object ", "name", BY_SUBINDEX, ECT_FACT_ENTRY},
    [ECT_FACT_ENTRY_DEFAULT] = {"object ", "default", BY_SUBINDEX, ECT_FACT_ENTRY},
    [ECT_FACT_ENTRY_LIMITS] = {"object ", "limits", BY_SUBINDEX, ECT_FACT_ENTRY},
    [ECT_FACT_ENTRY_UNIT] = {"object ", "unit", BY_SUBINDEX, ECT_FACT_ENTRY},
    [ECT_FACT_DC] = {"DC mode ", "name", BY_NUMBER, ECT_FACT_DC},
    [ECT_FACT_DC_ACTIVATE] = {"DC mode ", "AssignActivate", BY_NUMBER, ECT_FACT_DC},
    [ECT_FACT_DC_SYNC0] = {"DC mode ", "SYNC0", BY_NUMBER, ECT_FACT_DC},
    [ECT_FACT_DC_SYNC1] = {"DC mode ", "SYNC1", BY_NUMBER, ECT_FACT_DC},
    [ECT_FACT_FILE] = {"", "", BY_PATH, ECT_FACT_FILE},
    [ECT_FACT_FILE_TEXT] = {"", "", BY_PATH, ECT_FACT_FILE_TEXT},
    [ECT_FACT_WORDS] = {"EEPROM", "reserved words", WHOLE, ECT_FACT_WORDS},
    [ECT_FACT_CATEGORY] = {"EEPROM category ", "", BY_NUMBER, ECT_FACT_CATEGORY},
    [ECT_FACT_GENERAL] = {"EEPROM General byte ", "", BY_NUMBER, ECT_FACT_GENERAL},
    [ECT_FACT_SM_BITS] = {"SM", "in the EEPROM", BY_NUMBER, ECT_FACT_SM},
    [ECT_FACT_PDO_BITS] = {"PDO ", "in the EEPROM", BY_INDEX, ECT_FACT_PDO},
    [ECT_FACT_PDO_ENTRY_BITS] = {"PDO ", "in the EEPROM", BY_ENTRY, ECT_FACT_PDO_ENTRY},
    [ECT_FACT_DC_TEXT] = {"DC mode ", "in the EEPROM", BY_NUMBER, ECT_FACT_DC},
};

/* --- adding ------------------------------------------------------------------------------------------------------ */

ect_fact_t *ect_facts_add(ect_facts_t *facts, ect_fact_kind_t kind, unsigned int index, unsigned int element,
                          const char *format, ...)
{
    char text[600];
    ECT_ASSERT(facts->source != NULL);
    ECT_ASSERT((unsigned int)kind < ECT_FACT_KINDS);
    ECT_ASSERT(index <= UINT16_MAX && element <= UINT16_MAX);
    facts->list = ect_arena_grow(&facts->arena, facts->list, facts->count, sizeof *facts->list);
    ect_fact_t *fact = &facts->list[facts->count++];
    *fact = (ect_fact_t){.kind = kind, .index = (uint16_t)index, .element = (uint16_t)element, .source = facts->source};
    if (format) {
        va_list arguments;
        va_start(arguments, format);
        (void)vsnprintf(text, sizeof text, format, arguments);
        va_end(arguments);
        fact->text = ect_arena_copy(&facts->arena, text, strlen(text));
    }
    return fact;
}

/* @return whether a text is a placeholder that tools write for entries without a name, as for elements of arrays */
static bool is_placeholder(const char *text, size_t length)
{
    static const char word[] = "SubIndex ";
    size_t at = sizeof word - 1;
    if (length < at || memcmp(text, word, at) != 0)
        return false;
    while (at < length && text[at] >= '0' && text[at] <= '9')
        at++;
    return at == length;
}

void ect_facts_add_text(ect_facts_t *facts, ect_fact_kind_t kind, unsigned int index, unsigned int element,
                        const char *text, size_t length)
{
    ECT_ASSERT(text != NULL || length == 0);
    while (length > 0 && (text[length - 1] == '\0' || text[length - 1] == ' '))
        length--;
    for (size_t i = 0; i < length; i++) {
        if (text[i] < ' ' || text[i] > '~')
            return;
    }
    if (length > 0 && !is_placeholder(text, length))
        (void)ect_facts_add(facts, kind, index, element, "\"%.*s\"", (int)length, text);
}

uint32_t ect_facts_sum(const void *bytes, size_t length)
{
    const uint8_t *byte = bytes;
    uint32_t sum = 2166136261u;
    for (size_t i = 0; i < length; i++)
        sum = (sum ^ byte[i]) * 16777619u;
    return sum;
}

void ect_facts_add_leaf(ect_facts_t *facts, ect_fact_kind_t kind, const char *path, const char *value)
{
    enum { SHORT = 60 };
    ECT_ASSERT(kind == ECT_FACT_FILE || kind == ECT_FACT_FILE_TEXT);
    const size_t length = strlen(value);
    const uint32_t key = ect_facts_sum(path, strlen(path));
    const char *copy = ect_arena_copy(&facts->arena, path, strlen(path));
    ect_fact_t *fact;
    if (length <= SHORT)
        fact = ect_facts_add(facts, kind, key >> 16, key & 0xFFFF, "\"%s\"", value);
    else
        fact = ect_facts_add(facts, kind, key >> 16, key & 0xFFFF, "%zu characters, sum %08" PRIX32, length,
                             ect_facts_sum(value, length));
    fact->path = copy;
}

void ect_facts_add_mapping(ect_facts_t *facts, unsigned int pdo, unsigned int element, unsigned int index,
                           unsigned int subindex, unsigned int bits)
{
    if (index == 0)
        (void)ect_facts_add(facts, ECT_FACT_PDO_ENTRY, pdo, element, "%u bits of padding", bits);
    else
        (void)ect_facts_add(facts, ECT_FACT_PDO_ENTRY, pdo, element, "%04X:%02X, %u bits", index, subindex, bits);
}

/* @return the names of the set bits */
static const char *names_of_bits(char *text, size_t room, const char *const *names, size_t count, unsigned int bits)
{
    size_t used = 0;
    ECT_ASSERT(count < 32);
    for (size_t i = 0; i < count; i++) {
        if ((bits >> i & 1u) != 0)
            used += (size_t)snprintf(text + used, room - used, "%s%s", used > 0 ? " " : "", names[i]);
        ECT_ASSERT(used < room);
    }
    if (bits >> count != 0)
        (void)snprintf(text + used, room - used, "%sbits 0x%X", used > 0 ? " " : "", bits >> count << count);
    return bits != 0 ? text : "none";
}

void ect_facts_add_access(ect_facts_t *facts, unsigned int index, unsigned int subindex, unsigned int access)
{
    static const char *const names[] = {"R.PREOP", "R.SAFEOP", "R.OP",  "W.PREOP", "W.SAFEOP",
                                        "W.OP",    "RxPDO",    "TxPDO", "backup",  "setting"};
    char text[120];
    (void)ect_facts_add(facts, ECT_FACT_ENTRY_ACCESS, index, subindex, "%s",
                        names_of_bits(text, sizeof text, names, sizeof names / sizeof names[0], access));
}

void ect_facts_add_default(ect_facts_t *facts, unsigned int index, unsigned int subindex, const uint8_t *bytes,
                           size_t length)
{
    char text[3 * 64 + 4] = "";
    size_t used = 0;
    ECT_ASSERT(bytes != NULL || length == 0);
    while (length > 1 && bytes[length - 1] == 0)
        length--;
    for (size_t i = 0; i < length && i < 64; i++)
        used += (size_t)snprintf(text + used, sizeof text - used, "%02X ", bytes[i]);
    if (used > 0)
        (void)ect_facts_add(facts, ECT_FACT_ENTRY_DEFAULT, index, subindex, "%.*s", (int)used - 1, text);
}

bool ect_facts_are_of_pdos(unsigned int index)
{
    return (index >= 0x1600 && index < 0x1C00) || (index >= 0x1C10 && index < 0x1C30);
}

bool ect_facts_are_known_elsewhere(unsigned int index)
{
    return index == 0x1018 || index == 0x1C00;
}

void ect_facts_add_sm(ect_facts_t *facts, unsigned int sm, unsigned int type)
{
    static const char *const names[] = {"unused", "mailbox to the slave", "mailbox from the slave", "outputs",
                                        "inputs"};
    if (type < sizeof names / sizeof names[0])
        (void)ect_facts_add(facts, ECT_FACT_SM, sm, 0, "%s", names[type]);
    else
        (void)ect_facts_add(facts, ECT_FACT_SM, sm, 0, "role %u", type);
}

void ect_facts_add_fmmus(ect_facts_t *facts, const uint8_t *roles, size_t count)
{
    static const char *const names[] = {"unused", "outputs", "inputs", "mailbox state"};
    while (count > 0 && (roles[count - 1] == ECT_FMMU_UNUSED || roles[count - 1] == 0xFF))
        count--;
    for (size_t i = 0; i < count; i++) {
        uint8_t role = roles[i] == 0xFF ? ECT_FMMU_UNUSED : roles[i];
        if (role < sizeof names / sizeof names[0])
            (void)ect_facts_add(facts, ECT_FACT_FMMU, (unsigned int)i, 0, "%s", names[role]);
        else
            (void)ect_facts_add(facts, ECT_FACT_FMMU, (unsigned int)i, 0, "role %u", role);
    }
    facts->complete[ECT_FACT_FMMU] = true;
}

void ect_facts_add_protocols(ect_facts_t *facts, unsigned int protocols, unsigned int coe_details)
{
    static const char *const boxes[] = {"AoE", "EoE", "CoE", "FoE", "SoE", "VoE"};
    static const char *const details[] = {"SDO",        "SDO-information", "PDO-assign", "PDO-configuration",
                                          "PDO-upload", "Complete-Access"};
    char text[120];
    (void)ect_facts_add(facts, ECT_FACT_PROTOCOLS, 0, 0, "%s", names_of_bits(text, sizeof text, boxes, 6, protocols));
    (void)ect_facts_add(facts, ECT_FACT_COE, 0, 0, "%s", names_of_bits(text, sizeof text, details, 6, coe_details));
}

void ect_facts_add_mailbox(ect_facts_t *facts, ect_fact_kind_t kind, unsigned int start, unsigned int length)
{
    if (length == 0 && start == 0)
        (void)ect_facts_add(facts, kind, 0, 0, "none");
    else
        (void)ect_facts_add(facts, kind, 0, 0, "%u bytes at 0x%04X", length, start);
}

/* --- comparing --------------------------------------------------------------------------------------------------- */

static uint64_t key(const ect_fact_t *fact)
{
    return (uint64_t)fact->kind << 32 | (uint32_t)fact->index << 16 | fact->element;
}

static int by_key(const void *a, const void *b)
{
    uint64_t left = key(*(const ect_fact_t *const *)a);
    uint64_t right = key(*(const ect_fact_t *const *)b);
    return (left > right) - (left < right);
}

/* Facts sorted by key, for a binary search. */
typedef struct order {
    const ect_fact_t **facts;
    size_t count;
} order_t;

static order_t order_of(ect_arena_t *arena, const ect_facts_t *facts)
{
    order_t order = {.facts = ect_arena_alloc(arena, (facts->count + 1) * sizeof *order.facts), .count = facts->count};
    for (size_t i = 0; i < facts->count; i++)
        order.facts[i] = &facts->list[i];
    qsort(order.facts, order.count, sizeof *order.facts, by_key);
    return order;
}

static const ect_fact_t *find(const order_t *order, ect_fact_kind_t kind, uint16_t index, uint16_t element)
{
    const ect_fact_t wanted = {.kind = kind, .index = index, .element = element};
    const ect_fact_t *pointer = &wanted;
    const ect_fact_t **at = bsearch(&pointer, order->facts, order->count, sizeof *order->facts, by_key);
    return at ? *at : NULL;
}

/* @return whether the absence of a fact is reported; the parts of a missing object are not */
static bool is_missed(const ect_facts_t *facts, const order_t *order, const ect_fact_t *fact)
{
    ect_fact_kind_t parent = rows[fact->kind].parent;
    ECT_ASSERT(rows[parent].parent == parent || rows[rows[parent].parent].parent == rows[parent].parent);
    if (!facts->complete[fact->kind] || fact->made)
        return false;
    uint16_t element = rows[parent].area == BY_ENTRY || rows[parent].area == BY_SUBINDEX ? fact->element : 0;
    return parent == fact->kind || find(order, parent, fact->index, element) != NULL;
}

static void print_place(const ect_fact_t *fact, FILE *out)
{
    static const char *const timeouts[] = {"to PREOP",       "to SAFEOP or OP", "back to INIT",
                                           "back to SAFEOP", "mailbox request", "mailbox response"};
    const struct row *row = &rows[fact->kind];
    ECT_ASSERT(row->place != NULL);
    ECT_ASSERT(row->area != BY_PATH || fact->path != NULL);
    fputs(row->place, out);
    if (fact->kind == ECT_FACT_TIMEOUT)
        fputs(timeouts[fact->index % 6], out);
    else if (row->area == BY_NUMBER)
        fprintf(out, "%u", fact->index);
    else if (row->area == BY_INDEX)
        fprintf(out, "%04X", fact->index);
    else if (row->area == BY_ENTRY)
        fprintf(out, "%04X entry %u", fact->index, fact->element);
    else if (row->area == BY_SUBINDEX)
        fprintf(out, "%04X:%02X", fact->index, fact->element);
    else if (row->area == BY_PATH)
        fputs(fact->path, out);
    if (*row->what != '\0')
        fprintf(out, " %s", row->what);
}

static void print_text(const ect_fact_t *fact, FILE *out)
{
    fputs(fact == NULL ? "nothing" : fact->text == NULL ? "something" : fact->text, out);
}

static void print(const ect_facts_t *found, const char *expecting, const ect_fact_t *expected, const ect_fact_t *actual,
                  FILE *out)
{
    ECT_ASSERT(expected != NULL || actual != NULL);
    fprintf(out, "%s: ", found->source);
    print_place(expected ? expected : actual, out);
    fputs(": expected ", out);
    print_text(expected, out);
    fprintf(out, " (%s), found ", expecting);
    print_text(actual, out);
    fputc('\n', out);
}

static bool same(const ect_fact_t *a, const ect_fact_t *b)
{
    return a->text == NULL || b->text == NULL || strcmp(a->text, b->text) == 0;
}

typedef struct comparison {
    ect_facts_t *known;
    const ect_facts_t *found;
    order_t of_known, of_found;
    FILE *out;
} comparison_t;

/* Reports facts of `known` that differ in `found`, or are missing there. @param texts  true: only ECT_FACT_FILE_TEXT,
 * false: only the others */
static size_t compare_known(const comparison_t *c, bool texts)
{
    size_t lines = 0;
    for (size_t i = 0; i < c->known->count; i++) {
        const ect_fact_t *expected = &c->known->list[i];
        if ((expected->kind == ECT_FACT_FILE_TEXT) != texts)
            continue;
        const ect_fact_t *actual = find(&c->of_found, expected->kind, expected->index, expected->element);
        if (actual ? same(expected, actual) : !is_missed(c->found, &c->of_found, expected))
            continue;
        print(c->found, expected->source, expected, actual, c->out);
        lines++;
    }
    return lines;
}

/* Reports facts of `found` that are missing from `known`. */
static size_t compare_found(const comparison_t *c, bool texts)
{
    size_t lines = 0;
    for (size_t i = 0; i < c->found->count; i++) {
        const ect_fact_t *fact = &c->found->list[i];
        if ((fact->kind == ECT_FACT_FILE_TEXT) != texts ||
            find(&c->of_known, fact->kind, fact->index, fact->element) != NULL ||
            !is_missed(c->known, &c->of_known, fact))
            continue;
        print(c->found, c->known->source, NULL, fact, c->out);
        lines++;
    }
    return lines;
}

static void adopt_facts(const comparison_t *c)
{
    ect_facts_t *known = c->known;
    const size_t before = known->count;
    ect_fact_t *list = NULL;
    size_t count = 0;
    for (size_t i = 0; i < c->found->count; i++) {
        const ect_fact_t *fact = &c->found->list[i];
        if (find(&c->of_known, fact->kind, fact->index, fact->element) != NULL)
            continue;
        list = ect_arena_grow(&known->arena, list, count, sizeof *list);
        list[count++] = *fact;
    }
    /* Appended last, because the order refers to the list, which may move. */
    for (size_t i = 0; i < count; i++) {
        known->list = ect_arena_grow(&known->arena, known->list, known->count, sizeof *known->list);
        known->list[known->count++] = list[i];
    }
    ECT_ASSERT(known->count == before + count);
    for (size_t i = 0; i < ECT_FACT_KINDS; i++)
        known->complete[i] = known->complete[i] || c->found->complete[i];
}

size_t ect_facts_compare(ect_facts_t *known, const ect_facts_t *found, FILE *out)
{
    ect_arena_t arena = {0};
    const comparison_t c = {.known = known,
                            .found = found,
                            .of_known = order_of(&arena, known),
                            .of_found = order_of(&arena, found),
                            .out = out};
    ECT_ASSERT(known != found);
    size_t lines = compare_known(&c, false);
    lines += compare_found(&c, false);
    if (lines == 0)
        lines = compare_known(&c, true);
    if (lines == 0)
        lines = compare_found(&c, true);
    adopt_facts(&c);
    ect_arena_free(&arena);
    return lines;
}

void ect_facts_take(ect_facts_t *to, const ect_facts_t *from, ect_fact_kind_t first, ect_fact_kind_t last)
{
    ECT_ASSERT(to != from);
    ECT_ASSERT(first <= last && last < ECT_FACT_KINDS);
    for (size_t i = 0; i < from->count; i++) {
        if (from->list[i].kind < first || from->list[i].kind > last)
            continue;
        to->list = ect_arena_grow(&to->arena, to->list, to->count, sizeof *to->list);
        to->list[to->count++] = from->list[i];
    }
    for (ect_fact_kind_t kind = first; kind <= last; kind++)
        to->complete[kind] = from->complete[kind];
}

void ect_facts_free(ect_facts_t *facts)
{
    ect_arena_free(&facts->arena);
}
