/* SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 200809L
#include "facts.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

/* How a place is written. */
typedef enum area { WHOLE, BY_NUMBER, BY_INDEX, BY_ENTRY, BY_SUBINDEX } area_t;

static const struct row {
    const char *place; /* before the numbers */
    const char *what;
    area_t area;
    fact_kind_t parent; /* without it, it is not missed; itself: none */
} rows[FACT_KINDS] = {
    [FACT_VENDOR] = {"identity", "vendor id", WHOLE, FACT_VENDOR},
    [FACT_PRODUCT] = {"identity", "product code", WHOLE, FACT_PRODUCT},
    [FACT_REVISION] = {"identity", "revision", WHOLE, FACT_REVISION},
    [FACT_TYPE] = {"device", "type", WHOLE, FACT_TYPE},
    [FACT_NAME] = {"device", "name", WHOLE, FACT_NAME},
    [FACT_VENDOR_NAME] = {"device", "vendor's name", WHOLE, FACT_VENDOR_NAME},
    [FACT_GROUP] = {"device", "group", WHOLE, FACT_GROUP},
    [FACT_GROUP_NAME] = {"device", "group's name", WHOLE, FACT_GROUP_NAME},
    [FACT_PORTS] = {"device", "ports", WHOLE, FACT_PORTS},
    [FACT_EBUS] = {"device", "E-bus current", WHOLE, FACT_EBUS},
    [FACT_TIMEOUT] = {"time-out ", "", BY_NUMBER, FACT_TIMEOUT},
    [FACT_EEPROM_SIZE] = {"EEPROM", "size", WHOLE, FACT_EEPROM_SIZE},
    [FACT_CONFIG] = {"EEPROM word ", "", BY_NUMBER, FACT_CONFIG},
    [FACT_CHECKSUM] = {"EEPROM", "checksum", WHOLE, FACT_CHECKSUM},
    [FACT_PROTOCOLS] = {"mailbox", "protocols", WHOLE, FACT_PROTOCOLS},
    [FACT_COE] = {"mailbox", "CoE abilities", WHOLE, FACT_COE},
    [FACT_MAILBOX_OUT] = {"mailbox", "to the slave", WHOLE, FACT_MAILBOX_OUT},
    [FACT_MAILBOX_IN] = {"mailbox", "from the slave", WHOLE, FACT_MAILBOX_IN},
    [FACT_BOOT_OUT] = {"mailbox", "to the slave in BOOT", WHOLE, FACT_BOOT_OUT},
    [FACT_BOOT_IN] = {"mailbox", "from the slave in BOOT", WHOLE, FACT_BOOT_IN},
    [FACT_SM] = {"SM", "", BY_NUMBER, FACT_SM},
    [FACT_SM_START] = {"SM", "start", BY_NUMBER, FACT_SM},
    [FACT_SM_LENGTH] = {"SM", "length", BY_NUMBER, FACT_SM},
    [FACT_SM_CONTROL] = {"SM", "control byte", BY_NUMBER, FACT_SM},
    [FACT_SM_ENABLED] = {"SM", "enabled", BY_NUMBER, FACT_SM},
    [FACT_SM_DEFAULT] = {"SM", "DefaultSize", BY_NUMBER, FACT_SM},
    [FACT_SM_MINIMUM] = {"SM", "smallest length", BY_NUMBER, FACT_SM},
    [FACT_SM_MAXIMUM] = {"SM", "largest length", BY_NUMBER, FACT_SM},
    [FACT_FMMU] = {"FMMU", "", BY_NUMBER, FACT_FMMU},
    [FACT_PDO] = {"PDO ", "", BY_INDEX, FACT_PDO},
    [FACT_PDO_SM] = {"PDO ", "SyncManager", BY_INDEX, FACT_PDO},
    [FACT_PDO_NAME] = {"PDO ", "name", BY_INDEX, FACT_PDO},
    [FACT_PDO_FIXED] = {"PDO ", "fixed", BY_INDEX, FACT_PDO},
    [FACT_PDO_MANDATORY] = {"PDO ", "mandatory", BY_INDEX, FACT_PDO},
    [FACT_PDO_EXCLUDES] = {"PDO ", "excludes", BY_INDEX, FACT_PDO},
    [FACT_PDO_ENTRY] = {"PDO ", "", BY_ENTRY, FACT_PDO},
    [FACT_PDO_ENTRY_NAME] = {"PDO ", "name", BY_ENTRY, FACT_PDO_ENTRY},
    [FACT_PDO_ENTRY_TYPE] = {"PDO ", "data type", BY_ENTRY, FACT_PDO_ENTRY},
    [FACT_OBJECT] = {"object ", "", BY_INDEX, FACT_OBJECT},
    [FACT_OBJECT_NAME] = {"object ", "name", BY_INDEX, FACT_OBJECT},
    [FACT_ENTRY] = {"object ", "length", BY_SUBINDEX, FACT_OBJECT},
    [FACT_ENTRY_TYPE] = {"object ", "data type", BY_SUBINDEX, FACT_ENTRY},
    [FACT_ENTRY_ACCESS] = {"object ", "access", BY_SUBINDEX, FACT_ENTRY},
    [FACT_ENTRY_NAME] = {"object ", "name", BY_SUBINDEX, FACT_ENTRY},
    [FACT_ENTRY_DEFAULT] = {"object ", "default", BY_SUBINDEX, FACT_ENTRY},
    [FACT_ENTRY_LIMITS] = {"object ", "limits", BY_SUBINDEX, FACT_ENTRY},
    [FACT_ENTRY_UNIT] = {"object ", "unit", BY_SUBINDEX, FACT_ENTRY},
    [FACT_DC] = {"DC mode ", "name", BY_NUMBER, FACT_DC},
    [FACT_DC_ACTIVATE] = {"DC mode ", "AssignActivate", BY_NUMBER, FACT_DC},
    [FACT_DC_SYNC0] = {"DC mode ", "SYNC0", BY_NUMBER, FACT_DC},
    [FACT_DC_SYNC1] = {"DC mode ", "SYNC1", BY_NUMBER, FACT_DC},
};

/* --- adding ------------------------------------------------------------------------------------------------------ */

fact_t *facts_add(facts_t *facts, fact_kind_t kind, unsigned int index, unsigned int element, const char *format, ...)
{
    char text[600];
    facts->list = ect_arena_grow(&facts->arena, facts->list, facts->count, sizeof *facts->list);
    fact_t *fact = &facts->list[facts->count++];
    *fact = (fact_t){.kind = kind, .index = (uint16_t)index, .element = (uint16_t)element, .source = facts->source};
    if (format) {
        va_list arguments;
        va_start(arguments, format);
        (void)vsnprintf(text, sizeof text, format, arguments);
        va_end(arguments);
        fact->text = ect_arena_copy(&facts->arena, text, strlen(text));
    }
    return fact;
}

/* What tools write where they have no name, or no room for it: an array in an ESI file has none for its elements. */
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

void facts_add_text(facts_t *facts, fact_kind_t kind, unsigned int index, unsigned int element, const char *text,
                    size_t length)
{
    while (length > 0 && (text[length - 1] == '\0' || text[length - 1] == ' '))
        length--;
    for (size_t i = 0; i < length; i++) {
        if (text[i] < ' ' || text[i] > '~')
            return;
    }
    if (length > 0 && !is_placeholder(text, length))
        (void)facts_add(facts, kind, index, element, "\"%.*s\"", (int)length, text);
}

void facts_add_mapping(facts_t *facts, unsigned int pdo, unsigned int element, unsigned int index,
                       unsigned int subindex, unsigned int bits)
{
    if (index == 0)
        (void)facts_add(facts, FACT_PDO_ENTRY, pdo, element, "%u bits of padding", bits);
    else
        (void)facts_add(facts, FACT_PDO_ENTRY, pdo, element, "%04X:%02X, %u bits", index, subindex, bits);
}

/* The names of the bits that are set, in a row. */
static const char *names_of_bits(char *text, size_t room, const char *const *names, size_t count, unsigned int bits)
{
    size_t used = 0;
    text[0] = '\0';
    for (size_t i = 0; i < count && used < room; i++) {
        if ((bits >> i & 1u) != 0 && names[i] != NULL)
            used += (size_t)snprintf(text + used, room - used, "%s%s", used > 0 ? " " : "", names[i]);
    }
    return used > 0 ? text : "none";
}

void facts_add_access(facts_t *facts, unsigned int index, unsigned int subindex, unsigned int access)
{
    static const char *const names[] = {"R.PREOP", "R.SAFEOP", "R.OP",  "W.PREOP", "W.SAFEOP",
                                        "W.OP",    "RxPDO",    "TxPDO", "backup",  "setting"};
    char text[120];
    (void)facts_add(facts, FACT_ENTRY_ACCESS, index, subindex, "%s",
                    names_of_bits(text, sizeof text, names, sizeof names / sizeof names[0], access));
}

void facts_add_default(facts_t *facts, unsigned int index, unsigned int subindex, const uint8_t *bytes, size_t length)
{
    char text[3 * 64 + 4] = "";
    size_t used = 0;
    while (length > 1 && bytes[length - 1] == 0)
        length--;
    for (size_t i = 0; i < length && i < 64; i++)
        used += (size_t)snprintf(text + used, sizeof text - used, "%02X ", bytes[i]);
    if (used > 0)
        (void)facts_add(facts, FACT_ENTRY_DEFAULT, index, subindex, "%.*s", (int)used - 1, text);
}

bool facts_are_of_pdos(unsigned int index)
{
    return (index >= 0x1600 && index < 0x1C00) || (index >= 0x1C10 && index < 0x1C30);
}

bool facts_are_told_elsewhere(unsigned int index)
{
    return index == 0x1018 || index == 0x1C00;
}

void facts_add_sm(facts_t *facts, unsigned int sm, unsigned int type)
{
    static const char *const names[] = {"unused", "mailbox to the slave", "mailbox from the slave", "outputs",
                                        "inputs"};
    if (type < sizeof names / sizeof names[0])
        (void)facts_add(facts, FACT_SM, sm, 0, "%s", names[type]);
    else
        (void)facts_add(facts, FACT_SM, sm, 0, "role %u", type);
}

void facts_add_fmmus(facts_t *facts, const uint8_t *roles, size_t count)
{
    static const char *const names[] = {"unused", "outputs", "inputs", "mailbox state"};
    while (count > 0 && (roles[count - 1] == ECT_FMMU_UNUSED || roles[count - 1] == 0xFF))
        count--;
    for (size_t i = 0; i < count; i++) {
        uint8_t role = roles[i] == 0xFF ? ECT_FMMU_UNUSED : roles[i];
        if (role < sizeof names / sizeof names[0])
            (void)facts_add(facts, FACT_FMMU, (unsigned int)i, 0, "%s", names[role]);
        else
            (void)facts_add(facts, FACT_FMMU, (unsigned int)i, 0, "role %u", role);
    }
    facts->complete[FACT_FMMU] = true;
}

void facts_add_protocols(facts_t *facts, unsigned int protocols, unsigned int coe_details)
{
    static const char *const boxes[] = {"AoE", "EoE", "CoE", "FoE", "SoE", "VoE"};
    static const char *const details[] = {"SDO",        "SDO-information", "PDO-assign", "PDO-configuration",
                                          "PDO-upload", "Complete-Access"};
    char text[120];
    (void)facts_add(facts, FACT_PROTOCOLS, 0, 0, "%s", names_of_bits(text, sizeof text, boxes, 6, protocols));
    (void)facts_add(facts, FACT_COE, 0, 0, "%s", names_of_bits(text, sizeof text, details, 6, coe_details));
}

void facts_add_mailbox(facts_t *facts, fact_kind_t kind, unsigned int start, unsigned int length)
{
    if (length == 0)
        (void)facts_add(facts, kind, 0, 0, "none");
    else
        (void)facts_add(facts, kind, 0, 0, "%u bytes at 0x%04X", length, start);
}

/* --- comparing --------------------------------------------------------------------------------------------------- */

static uint64_t key(const fact_t *fact)
{
    return (uint64_t)fact->kind << 32 | (uint32_t)fact->index << 16 | fact->element;
}

static int by_key(const void *a, const void *b)
{
    uint64_t left = key(*(const fact_t *const *)a);
    uint64_t right = key(*(const fact_t *const *)b);
    return left < right ? -1 : left > right;
}

/* Facts by key, so that they are found in a dictionary of thousands. */
typedef struct order {
    const fact_t **facts;
    size_t count;
} order_t;

static order_t order_of(ect_arena_t *arena, const facts_t *facts)
{
    order_t order = {.facts = ect_arena_alloc(arena, (facts->count + 1) * sizeof *order.facts), .count = facts->count};
    for (size_t i = 0; i < facts->count; i++)
        order.facts[i] = &facts->list[i];
    qsort(order.facts, order.count, sizeof *order.facts, by_key);
    return order;
}

static const fact_t *find(const order_t *order, fact_kind_t kind, uint16_t index, uint16_t element)
{
    const fact_t wanted = {.kind = kind, .index = index, .element = element};
    const fact_t *pointer = &wanted;
    const fact_t **at = bsearch(&pointer, order->facts, order->count, sizeof *order->facts, by_key);
    return at ? *at : NULL;
}

/* That something is not there is said once, not for each of its parts. */
static bool is_missed(const facts_t *facts, const order_t *order, const fact_t *fact)
{
    fact_kind_t parent = rows[fact->kind].parent;
    if (!facts->complete[fact->kind] || fact->made)
        return false;
    uint16_t element = rows[parent].area == BY_ENTRY || rows[parent].area == BY_SUBINDEX ? fact->element : 0;
    return parent == fact->kind || find(order, parent, fact->index, element) != NULL;
}

static void print_place(const fact_t *fact, FILE *out)
{
    static const char *const timeouts[] = {"to PREOP",       "to SAFEOP or OP", "back to INIT",
                                           "back to SAFEOP", "mailbox request", "mailbox response"};
    const struct row *row = &rows[fact->kind];
    fputs(row->place, out);
    if (fact->kind == FACT_TIMEOUT)
        fputs(timeouts[fact->index % 6], out);
    else if (row->area == BY_NUMBER)
        fprintf(out, "%u", fact->index);
    else if (row->area == BY_INDEX)
        fprintf(out, "%04X", fact->index);
    else if (row->area == BY_ENTRY)
        fprintf(out, "%04X entry %u", fact->index, fact->element);
    else if (row->area == BY_SUBINDEX)
        fprintf(out, "%04X:%02X", fact->index, fact->element);
    if (*row->what != '\0')
        fprintf(out, " %s", row->what);
}

static void print_text(const fact_t *fact, FILE *out)
{
    fputs(fact == NULL ? "nothing" : fact->text == NULL ? "something" : fact->text, out);
}

static void print(const facts_t *found, const char *expecting, const fact_t *expected, const fact_t *actual, FILE *out)
{
    fprintf(out, "%s: ", found->source);
    print_place(expected ? expected : actual, out);
    fputs(": expected ", out);
    print_text(expected, out);
    fprintf(out, " (%s), found ", expecting);
    print_text(actual, out);
    fputc('\n', out);
}

static bool same(const fact_t *a, const fact_t *b)
{
    return a->text == NULL || b->text == NULL || strcmp(a->text, b->text) == 0;
}

static size_t compare_known(const facts_t *known, const facts_t *found, const order_t *order, FILE *out)
{
    size_t lines = 0;
    for (size_t i = 0; i < known->count; i++) {
        const fact_t *expected = &known->list[i];
        const fact_t *actual = find(order, expected->kind, expected->index, expected->element);
        if (actual ? same(expected, actual) : !is_missed(found, order, expected))
            continue;
        print(found, expected->source, expected, actual, out);
        lines++;
    }
    return lines;
}

size_t facts_compare(facts_t *known, const facts_t *found, FILE *out)
{
    order_t of_known = order_of(&known->arena, known);
    order_t of_found = order_of(&known->arena, found);
    size_t lines = compare_known(known, found, &of_found, out);
    fact_t *list = NULL;
    size_t count = 0;
    for (size_t i = 0; i < found->count; i++) {
        const fact_t *fact = &found->list[i];
        if (find(&of_known, fact->kind, fact->index, fact->element))
            continue;
        if (is_missed(known, &of_known, fact)) {
            print(found, known->source, NULL, fact, out);
            lines++;
        }
        list = ect_arena_grow(&known->arena, list, count, sizeof *list);
        list[count++] = *fact;
    }
    for (size_t i = 0; i < count; i++) {
        known->list = ect_arena_grow(&known->arena, known->list, known->count, sizeof *known->list);
        known->list[known->count++] = list[i];
    }
    for (size_t i = 0; i < FACT_KINDS; i++)
        known->complete[i] = known->complete[i] || found->complete[i];
    return lines;
}

void facts_free(facts_t *facts)
{
    ect_arena_free(&facts->arena);
}
