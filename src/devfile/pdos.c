/* SPDX-License-Identifier: MIT */
/* `inputs` and `outputs`: one PDO as a list of entries, or a list of PDOs. */
#include "devfile/internal.h"

#include <string.h>

#include "od/pdo.h"

enum { FIRST_RXPDO = 0x1600, FIRST_TXPDO = 0x1A00, PDOS = 0x200, EXCLUDED_MOST = 64 };

/* A PDO whose keys are being read. */
typedef struct keys {
    ect_draft_t *d;
    const yaml_node_t *pdo, *name, *entries, *exclude, *mandatory, *assigned;
} keys_t;

static void take_key(void *ctx, const char *key, const yaml_node_t *name, const yaml_node_t *value)
{
    keys_t *k = ctx;
    const struct {
        const char *name;
        const yaml_node_t **node;
    } nodes[] = {{"pdo", &k->pdo},         {"name", &k->name},           {"entries", &k->entries},
                 {"exclude", &k->exclude}, {"mandatory", &k->mandatory}, {"assigned", &k->assigned}};
    for (size_t i = 0; i < sizeof nodes / sizeof nodes[0]; i++) {
        if (strcmp(nodes[i].name, key) == 0) {
            *nodes[i].node = value;
            return;
        }
    }
    ect_yaml_fail(&k->d->yaml, name, "'%.60s' is no key of a PDO: pdo, name, entries, exclude, mandatory, assigned",
                  key);
}

static const yaml_node_t *item(ect_draft_t *d, const yaml_node_t *list, size_t n)
{
    return ect_yaml_node(&d->yaml, list->data.sequence.items.start[n]);
}

static size_t length_of(const yaml_node_t *list)
{
    return (size_t)(list->data.sequence.items.top - list->data.sequence.items.start);
}

static void map_all(ect_draft_t *d, ect_esi_pdo_t *pdo, const yaml_node_t *list)
{
    if (list->type != YAML_SEQUENCE_NODE || length_of(list) == 0) {
        ect_yaml_fail(&d->yaml, list, "a PDO takes a list of entries, as [0x6000, '0x6001:1', gap 4]");
        return;
    }
    for (size_t i = 0; i < length_of(list) && !d->mistake.failed; i++) {
        ect_word_t word = ect_draft_word(d, item(d, list, i), "entries");
        if (!d->mistake.failed)
            ect_draft_map(d, pdo, word);
    }
}

static uint16_t number_of(ect_draft_t *d, const char *key, const yaml_node_t *node, bool tx)
{
    int64_t first = tx ? FIRST_TXPDO : FIRST_RXPDO;
    ect_word_t word = ect_draft_word(d, node, key);
    return d->mistake.failed ? 0 : (uint16_t)ect_draft_number(d, key, word, first, first + PDOS - 1);
}

static void take_excluded(ect_draft_t *d, ect_esi_pdo_t *pdo, const yaml_node_t *list)
{
    if (list->type != YAML_SEQUENCE_NODE || length_of(list) > EXCLUDED_MOST) {
        ect_yaml_fail(&d->yaml, list, "'exclude' takes a list of at most %d PDOs, as [0x1A01]", (int)EXCLUDED_MOST);
        return;
    }
    ect_esi_exclude_t *exclude = ect_arena_alloc(d->arena, (length_of(list) + 1) * sizeof *exclude);
    for (size_t i = 0; i < length_of(list); i++)
        exclude[pdo->exclude_count++] =
            (ect_esi_exclude_t){.index = number_of(d, "exclude", item(d, list, i), pdo->tx), .moves = d->moves};
    pdo->exclude = exclude;
}

static void take_pdo(ect_draft_t *d, const yaml_node_t *node, uint16_t next, bool tx)
{
    keys_t k = {.d = d};
    ect_yaml_each(&d->yaml, node, "a PDO", true, take_key, &k);
    if (!d->mistake.failed && k.entries == NULL)
        ect_yaml_fail(&d->yaml, node, "a PDO without 'entries: [0x6000]'");
    if (d->mistake.failed)
        return;
    uint16_t index = k.pdo != NULL ? number_of(d, "pdo", k.pdo, tx) : next;
    ect_esi_pdo_t *pdo = ect_draft_add_pdo(d, index, tx, ect_yaml_line(node));
    if (pdo == NULL)
        return;
    ect_word_t name = k.name != NULL ? ect_draft_word(d, k.name, "name")
                                     : (ect_word_t){.text = ect_arena_print(d->arena, "%s %04X", pdo->name, index)};
    pdo->name = ect_arena_copy(d->arena, name.text, strlen(name.text));
    if (k.mandatory != NULL)
        pdo->mandatory = ect_draft_flag(d, "mandatory", ect_draft_word(d, k.mandatory, "mandatory"));
    if (k.assigned != NULL && !ect_draft_flag(d, "assigned", ect_draft_word(d, k.assigned, "assigned")))
        pdo->sm = -1;
    if (pdo->sm < 0)
        d->device->mailbox.pdo_assign = true;
    if (k.exclude != NULL)
        take_excluded(d, pdo, k.exclude);
    map_all(d, pdo, k.entries);
}

void ect_draft_pdos(ect_draft_t *d, const yaml_node_t *list, bool tx)
{
    uint16_t first = tx ? FIRST_TXPDO : FIRST_RXPDO;
    if (list->type != YAML_SEQUENCE_NODE || length_of(list) == 0) {
        ect_yaml_fail(&d->yaml, list, "'%s' takes a list: entries, as [0x6000], or PDOs, '- {pdo: 0x%04X, entries: …}'",
                      tx ? "inputs" : "outputs", (unsigned int)first);
        return;
    }
    if (item(d, list, 0)->type == YAML_SCALAR_NODE) {
        ect_esi_pdo_t *pdo = ect_draft_add_pdo(d, first, tx, ect_yaml_line(list));
        if (pdo != NULL)
            map_all(d, pdo, list);
        return;
    }
    if (length_of(list) > PDOS)
        ect_yaml_fail(&d->yaml, list, "more than %d PDOs", (int)PDOS);
    for (size_t i = 0; i < length_of(list) && !d->mistake.failed; i++)
        take_pdo(d, item(d, list, i), (uint16_t)(first + i), tx);
}
