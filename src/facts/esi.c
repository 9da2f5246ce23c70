/* SPDX-License-Identifier: MIT */
/* Facts of an ESI file beyond those of its twin. */
#include <inttypes.h>
#include <string.h>

#include "esi/leaves.h"
#include "facts/facts.h"
#include "wire/assert.h"

static bool has_object(const ect_esi_dictionary_t *dictionary, uint16_t index)
{
    for (size_t i = 0; i < dictionary->object_count; i++) {
        if (dictionary->objects[i].index == index)
            return true;
    }
    return false;
}

/* @return whether an object is missing from the file: mapped by a PDO, or mandatory */
static bool is_made(const ect_fact_t *fact, const ect_esi_device_t *model)
{
    return fact->kind >= ECT_FACT_OBJECT && fact->kind <= ECT_FACT_ENTRY_UNIT &&
           !has_object(&model->dictionary, fact->index);
}

/* Marks objects made by the twin. The list of objects of a modular device is never complete. */
static void mark_made(ect_facts_t *facts, const ect_esi_device_t *model)
{
    for (size_t i = 0; i < facts->count; i++) {
        ect_fact_t *fact = &facts->list[i];
        if (is_made(fact, model)) {
            fact->made = true;
            fact->text = NULL;
        }
    }
    bool whole = model->dictionary.object_count > 0 && model->dictionary_unread == NULL && model->slot_count == 0;
    facts->complete[ECT_FACT_OBJECT] = whole;
    facts->complete[ECT_FACT_ENTRY] = whole;
}

static bool is_default_timeout(const ect_fact_t *fact, const ect_esi_device_t *m)
{
    const uint32_t said[] = {m->preop_ms,          m->safeop_op_ms, m->back_to_init_ms,
                             m->back_to_safeop_ms, m->request_ms,   m->response_ms};
    return fact->kind == ECT_FACT_TIMEOUT && said[fact->index % 6] == 0;
}

/* @return whether a name was chosen by the twin */
static bool is_own_name(const ect_fact_t *fact)
{
    bool standard = fact->index == 0x1018 || fact->index == 0x1C00;
    return (fact->kind == ECT_FACT_OBJECT_NAME && standard) ||
           (fact->kind == ECT_FACT_ENTRY_NAME && (standard || ect_facts_are_of_pdos(fact->index)));
}

/* @return whether a length is the sum of the twin's PDOs, missing from the file */
static bool is_own_length(const ect_fact_t *fact, const ect_esi_device_t *model)
{
    return fact->kind == ECT_FACT_SM_LENGTH && fact->index < model->sm_count && !model->sms[fact->index].size.given;
}

/* @return whether a text is missing from the file */
static bool is_missing_text(const ect_fact_t *fact, const ect_esi_device_t *model)
{
    const struct {
        ect_fact_kind_t kind;
        const char *text;
    } texts[] = {{ECT_FACT_GROUP, model->group_type},
                 {ECT_FACT_GROUP_NAME, model->group_name},
                 {ECT_FACT_VENDOR_NAME, model->vendor_name},
                 {ECT_FACT_PORTS, model->physics}};
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++) {
        if (fact->kind == texts[i].kind)
            return *texts[i].text == '\0';
    }
    return false;
}

static bool is_of_twin(const ect_fact_t *fact, const ect_esi_device_t *model)
{
    const bool eeprom = fact->kind == ECT_FACT_EEPROM_SIZE ||
                        (fact->kind == ECT_FACT_CONFIG && fact->index * 2u + 2u > model->config.length);
    return eeprom || is_missing_text(fact, model) || is_default_timeout(fact, model) || is_own_name(fact) ||
           is_own_length(fact, model);
}

/* Removes defaults chosen by the twin, which are no facts of the file. */
static void forget_defaults(ect_facts_t *facts, const ect_esi_device_t *model)
{
    size_t kept = 0;
    for (size_t i = 0; i < facts->count; i++) {
        if (!is_of_twin(&facts->list[i], model))
            facts->list[kept++] = facts->list[i];
    }
    facts->count = kept;
}

static void add_sm(ect_facts_t *facts, unsigned int number, const ect_esi_sm_t *sm)
{
    if (sm->size.given)
        (void)ect_facts_add(facts, ECT_FACT_SM_DEFAULT, number, 0, "%" PRId64, sm->size.value);
    (void)ect_facts_add(facts, ECT_FACT_SM_MINIMUM, number, 0, "%u", sm->minimum);
    (void)ect_facts_add(facts, ECT_FACT_SM_MAXIMUM, number, 0, "%u", sm->maximum);
}

/* Adds values of the file that the twin changes: the size of the EEPROM, and names of standard objects. */
static void add_own_words(ect_facts_t *facts, const ect_esi_device_t *model)
{
    if (model->eeprom_size != 0)
        (void)ect_facts_add(facts, ECT_FACT_EEPROM_SIZE, 0, 0, "%" PRIu32 " bytes", model->eeprom_size);
    for (size_t i = 0; i < model->dictionary.object_count; i++) {
        const ect_esi_object_t *object = &model->dictionary.objects[i];
        if (object->index == 0x1018 || object->index == 0x1C00)
            ect_facts_add_text(facts, ECT_FACT_OBJECT_NAME, object->index, 0, object->name, strlen(object->name));
    }
}

static void add_pdo(ect_facts_t *facts, const ect_esi_pdo_t *pdo)
{
    char excludes[300] = "none";
    size_t used = 0;
    for (size_t i = 0; i < pdo->exclude_count && used < sizeof excludes - 8; i++)
        used += (size_t)snprintf(excludes + used, sizeof excludes - used, "%s%04X", i > 0 ? " " : "",
                                 pdo->exclude[i].index);
    (void)ect_facts_add(facts, ECT_FACT_PDO_FIXED, pdo->index, 0, "%s", pdo->fixed ? "yes" : "no");
    (void)ect_facts_add(facts, ECT_FACT_PDO_MANDATORY, pdo->index, 0, "%s", pdo->mandatory ? "yes" : "no");
    (void)ect_facts_add(facts, ECT_FACT_PDO_EXCLUDES, pdo->index, 0, "%s", excludes);
}

static void add_leaf(void *facts, bool modelled, const char *path, const char *value)
{
    ect_facts_add_leaf(facts, modelled ? ECT_FACT_FILE_TEXT : ECT_FACT_FILE, path, value);
}

void ect_facts_of_esi(ect_facts_t *facts, const ect_device_t *device, const ect_esi_device_t *model)
{
    ECT_ASSERT(model->esi != NULL);
    ECT_ASSERT(facts->count == 0);
    ect_facts_of_device(facts, device);
    forget_defaults(facts, model);
    mark_made(facts, model);
    add_own_words(facts, model);
    for (size_t i = 0; i < model->sm_count; i++)
        add_sm(facts, (unsigned int)i, &model->sms[i]);
    for (size_t i = 0; i < model->pdo_count; i++) {
        if (!model->pdos[i].virtual_pdo)
            add_pdo(facts, &model->pdos[i]);
    }
    ect_esi_leaves(model, add_leaf, facts);
    facts->complete[ECT_FACT_FILE] = facts->complete[ECT_FACT_FILE_TEXT] = true;
}
