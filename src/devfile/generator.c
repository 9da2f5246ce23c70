/* SPDX-License-Identifier: MIT */
/* Projects of the public "EEPROM generator" for SOES, `esi.json`: a form with texts, objects in three sections, clock
 * modes. Each object of the sections txpdo and rxpdo is a PDO of its own. Keys without a meaning for a device (names of
 * variables in C), and objects whose key is no index, are ignored, as by the generator. */
#include <stdlib.h>
#include <string.h>

#include "devfile/internal.h"
#include "esi/number.h"

enum { INDEX_LEAST = 0x1000, FIRST_RXPDO = 0x1600, FIRST_TXPDO = 0x1A00, MAILBOX_MOST = 1486 };

/* An object of a section. */
typedef struct listed {
    uint16_t index;
    size_t line;
    const yaml_node_t *node;
} listed_t;

typedef struct section {
    ect_draft_t *d;
    listed_t *objects;
    size_t count;
} section_t;

/* --- texts of a mapping ------------------------------------------------------------------------------------------- */

/* @return the text of a key; NULL: absent, null, or empty */
static ect_word_t word_of(ect_draft_t *d, const yaml_node_t *map, const char *key)
{
    const yaml_node_t *node = map->type == YAML_MAPPING_NODE ? ect_yaml_find(&d->yaml, map, key) : NULL;
    ect_word_t word = {.text = NULL, .line = ect_yaml_line(map)};
    if (node == NULL)
        return word;
    word = ect_draft_word(d, node, key);
    if (*word.text == '\0' || strcmp(word.text, "null") == 0)
        word.text = NULL;
    return word;
}

static int64_t number_of(ect_draft_t *d, const yaml_node_t *map, const char *key, int64_t otherwise, int64_t maximum)
{
    const ect_word_t word = word_of(d, map, key);
    return word.text != NULL && !d->mistake.failed ? ect_draft_number(d, key, word, 0, maximum) : otherwise;
}

static const char *text_of(ect_draft_t *d, const yaml_node_t *map, const char *key)
{
    const ect_word_t word = word_of(d, map, key);
    return word.text != NULL ? ect_arena_copy(d->arena, word.text, strlen(word.text)) : "";
}

/* @return whether a box of the form is checked */
static bool is_checked(ect_draft_t *d, const yaml_node_t *form, const char *key)
{
    const ect_word_t word = word_of(d, form, key);
    return word.text != NULL && (strcmp(word.text, "true") == 0 || strcmp(word.text, "on") == 0);
}

/* --- the form ----------------------------------------------------------------------------------------------------- */

static void take_identity(ect_draft_t *d, const yaml_node_t *form)
{
    static const char *const ports[] = {"Port0Physical", "Port1Physical", "Port2Physical", "Port3Physical"};
    ect_esi_device_t *device = d->device;
    device->vendor_id = (uint32_t)number_of(d, form, "VendorID", 0, UINT32_MAX);
    device->vendor_name = text_of(d, form, "VendorName");
    device->product_code = (uint32_t)number_of(d, form, "ProductCode", 0, UINT32_MAX);
    device->revision = (uint32_t)number_of(d, form, "RevisionNumber", 0, UINT32_MAX);
    device->profile = (uint32_t)number_of(d, form, "ProfileNo", 0, UINT16_MAX);
    device->type = text_of(d, form, "TextDeviceType");
    device->name = text_of(d, form, "TextDeviceName");
    device->group_type = text_of(d, form, "TextGroupType");
    device->group_name = text_of(d, form, "TextGroupName5");
    device->line = (int)ect_yaml_line(form);
    char *physics = ect_arena_alloc(d->arena, sizeof ports / sizeof ports[0] + 1);
    for (size_t i = 0; i < sizeof ports / sizeof ports[0]; i++) {
        const char port = *text_of(d, form, ports[i]);
        if (port == 'Y' || port == 'K' || port == 'H')
            physics[strlen(physics)] = port;
    }
    device->physics = physics;
    if (*device->type == '\0')
        ect_yaml_fail(&d->yaml, form, "the form has no 'TextDeviceType': save the project again");
}

static void take_mailbox(ect_draft_t *d, const yaml_node_t *form)
{
    ect_esi_mailbox_t *m = &d->device->mailbox;
    m->given = m->coe = m->data_link_layer = true;
    m->foe = is_checked(d, form, "DetailsEnableUseFoE");
    m->sdo_info = is_checked(d, form, "CoeDetailsEnableSDOInfo");
    m->pdo_assign = is_checked(d, form, "CoeDetailsEnablePDOAssign");
    m->pdo_config = is_checked(d, form, "CoeDetailsEnablePDOConfiguration");
    m->pdo_upload = is_checked(d, form, "CoeDetailsEnableUploadAtStartup");
    m->complete_access = is_checked(d, form, "CoeDetailsEnableSDOCompleteAccess");
}

static void take_syncmanagers(ect_draft_t *d, const yaml_node_t *form)
{
    const struct {
        const char *type, *start;
        uint8_t control;
    } sms[] = {{"MBoxOut", "RxMailboxOffset", 0x26},
               {"MBoxIn", "TxMailboxOffset", 0x22},
               {"Outputs", "SM2Offset", 0x24},
               {"Inputs", "SM3Offset", 0x20}};
    const uint16_t bytes = (uint16_t)number_of(d, form, "MailboxSize", 128, MAILBOX_MOST);
    for (unsigned int n = 0; n < sizeof sms / sizeof sms[0]; n++) {
        ect_esi_sm_t *sm = ect_draft_sm(d, sms[n].type, sms[n].control, n < 2 ? bytes : 0);
        sm->start = (uint16_t)number_of(d, form, sms[n].start, 0, UINT16_MAX);
        sm->line = (int)ect_yaml_line(form);
    }
    if (!d->mistake.failed)
        ect_draft_assign(d);
}

/* Sets the first words of the EEPROM for the chip of the form, with a processor at its SPI. */
static void take_eeprom(ect_draft_t *d, const yaml_node_t *form)
{
    static const struct {
        const char *chip;
        uint8_t interface, low, high; /* byte 0, and word 5 */
    } chips[] = {{"ET1100", 0x05, 0, 0},
                 {"AX58100", 0x05, 0x1A, 0},
                 {"LAN9252", 0x80, 0, 0},
                 {"LAN9253 Beckhoff", 0x05, 0x40, 0xC0},
                 {"LAN9253 Direct", 0x82, 0x40, 0xC0},
                 {"LAN9253 Indirect", 0x80, 0x40, 0xC0}};
    const char *chip = text_of(d, form, "ESC");
    size_t n = 0;
    for (size_t i = 0; i < sizeof chips / sizeof chips[0]; i++)
        n = strcmp(chips[i].chip, chip) == 0 ? i : n;
    uint8_t *config = ect_arena_alloc(d->arena, 14);
    config[0] = chips[n].interface;
    config[1] = 0x06; /* SYNC and LATCH units */
    config[2] = (uint8_t)number_of(d, form, "SPImode", 0, 3);
    config[3] = 0x44; /* both SYNC signals are outputs */
    config[4] = 0x64; /* pulses of 1 us */
    config[10] = chips[n].low;
    config[11] = chips[n].high;
    d->device->config = (ect_esi_bytes_t){.bytes = config, .length = 14};
    d->device->eeprom_size = (uint32_t)number_of(d, form, "EEPROMsize", 0, 0x8000);
}

/* --- objects ------------------------------------------------------------------------------------------------------ */

/* Sets the words of an object or of one of its items. `dtype` is the type of the array that has the item. */
static void take_words(ect_draft_t *d, const yaml_node_t *node, ect_word_t dtype, const ect_word_t *access,
                       ect_word_t words[ECT_WORDS])
{
    const ect_word_t size = word_of(d, node, "size"), value = word_of(d, node, "value");
    memset(words, 0, ECT_WORDS * sizeof *words);
    words[ECT_WORD_NAME] = word_of(d, node, "name");
    words[ECT_WORD_TYPE] = dtype.text != NULL ? dtype : word_of(d, node, "dtype");
    words[ECT_WORD_DEFAULT] = value;
    if (words[ECT_WORD_TYPE].text != NULL && strcmp(words[ECT_WORD_TYPE].text, "VISIBLE_STRING") == 0) {
        const size_t length = value.text != NULL && *value.text != '\0' ? strlen(value.text) : 1;
        words[ECT_WORD_TYPE].text = size.text != NULL && strcmp(size.text, "0") != 0
                                        ? ect_arena_print(d->arena, "STRING(%.8s)", size.text)
                                        : ect_arena_print(d->arena, "STRING(%zu)", length);
    }
    const bool writable = access->text != NULL && strncmp(access->text, "RW", 2) == 0;
    const bool before = access->text != NULL && strcmp(access->text, "RWpre") == 0;
    const bool hidden = access->text != NULL && strncmp(access->text, "WO", 2) == 0;
    words[ECT_WORD_ACCESS] = (ect_word_t){.text = writable ? "rw" : hidden ? "wo" : "ro", .line = access->line};
    if (before)
        words[ECT_WORD_WRITE_IN] = (ect_word_t){.text = "preop", .line = access->line};
}

static void add_entry(ect_draft_t *d, const yaml_node_t *node, ect_word_t dtype, ect_word_t access, uint8_t subindex)
{
    ect_word_t words[ECT_WORDS];
    ect_draft_entry_t entry;
    take_words(d, node, dtype, &access, words);
    if (d->mistake.failed)
        return;
    ect_draft_words(d, &entry, words, ect_yaml_line(node));
    if (!d->mistake.failed)
        (void)ect_draft_entry(d, subindex, &entry);
}

/* Reads the items; item 0 has the number of the others. */
static void add_items(ect_draft_t *d, const yaml_node_t *node, bool array)
{
    const yaml_node_t *items = ect_yaml_find(&d->yaml, node, "items");
    const ect_word_t none = {.text = NULL}, object = word_of(d, node, "access");
    const ect_word_t dtype = array ? word_of(d, node, "dtype") : none;
    const size_t count = items != NULL && items->type == YAML_SEQUENCE_NODE
                             ? (size_t)(items->data.sequence.items.top - items->data.sequence.items.start)
                             : 0;
    if (count < 2 || count > UINT8_MAX) {
        ect_yaml_fail(&d->yaml, node, "'items' takes 2 to 255 of them, the first one for sub-index 0");
        return;
    }
    for (size_t i = 1; i < count && !d->mistake.failed; i++) {
        const yaml_node_t *item = ect_yaml_node(&d->yaml, items->data.sequence.items.start[i]);
        const ect_word_t access = word_of(d, item, "access");
        add_entry(d, item, dtype, access.text != NULL ? access : object, (uint8_t)i);
    }
}

static bool add_object(ect_draft_t *d, const listed_t *one)
{
    const ect_word_t otype = word_of(d, one->node, "otype"), name = word_of(d, one->node, "name");
    const ect_word_t none = {.text = NULL};
    const bool record = otype.text != NULL && strcmp(otype.text, "RECORD") == 0;
    const bool array = otype.text != NULL && strcmp(otype.text, "ARRAY") == 0;
    const uint8_t code = record ? ECT_OBJECT_RECORD : array ? ECT_OBJECT_ARRAY : ECT_OBJECT_VAR;
    const ect_word_t index = {.text = ect_arena_print(d->arena, "0x%04X", (unsigned int)one->index), .line = one->line};
    if (!d->mistake.failed && !record && !array && (otype.text == NULL || strcmp(otype.text, "VAR") != 0))
        ect_mistake(&d->mistake, one->line, "object %04X: 'otype' takes VAR, ARRAY or RECORD",
                    (unsigned int)one->index);
    if (!d->mistake.failed && name.text == NULL)
        ect_mistake(&d->mistake, one->line, "object %04X has no 'name'", (unsigned int)one->index);
    if (d->mistake.failed || ect_draft_add(d, index, code, name.text) == NULL)
        return false;
    if (code == ECT_OBJECT_VAR)
        add_entry(d, one->node, none, word_of(d, one->node, "access"), 0);
    else
        add_items(d, one->node, array);
    return !d->mistake.failed;
}

/* Adds a PDO with all entries of the last object. A BOOLEAN fills a byte, except in an array. */
static void map_object(ect_draft_t *d, uint16_t index, bool tx, size_t line)
{
    const ect_draft_object_t *object = &d->objects[d->object_count - 1];
    ect_esi_pdo_t *pdo = ect_draft_add_pdo(d, index, tx, line);
    if (pdo == NULL)
        return;
    pdo->name = object->name;
    pdo->mandatory = true;
    for (size_t i = 0; i < object->count && !d->mistake.failed; i++) {
        const ect_draft_entry_t *entry = &object->entries[i];
        const char *text =
            ect_arena_print(d->arena, "0x%04X:%u", (unsigned int)object->index, (unsigned int)entry->subindex);
        ect_draft_map(d, pdo, (ect_word_t){.text = text, .line = line});
        if (entry->type == ECT_TYPE_BOOLEAN && object->code != ECT_OBJECT_ARRAY)
            ect_draft_map(d, pdo, (ect_word_t){.text = "gap 7", .line = line});
    }
}

static void list_object(void *ctx, const char *key, const yaml_node_t *name, const yaml_node_t *value)
{
    section_t *s = ctx;
    char text[8];
    int64_t index;
    if (strlen(key) != 4)
        return;
    (void)snprintf(text, sizeof text, "0x%s", key);
    if (!ect_esi_parse_number(text, &index) || index < INDEX_LEAST)
        return;
    s->objects = ect_arena_grow(s->d->arena, s->objects, s->count, sizeof *s->objects);
    s->objects[s->count++] = (listed_t){.index = (uint16_t)index, .line = ect_yaml_line(name), .node = value};
}

static int compare(const void *a, const void *b)
{
    return (int)((const listed_t *)a)->index - (int)((const listed_t *)b)->index;
}

/* `first`: the index of the first PDO; 0: the direction has none. */
static void take_section(ect_draft_t *d, const yaml_node_t *od, const char *key, uint16_t first)
{
    section_t s = {.d = d};
    const yaml_node_t *node = ect_yaml_find(&d->yaml, od, key);
    if (node == NULL || d->mistake.failed)
        return;
    ect_yaml_each(&d->yaml, node, key, false, list_object, &s);
    if (s.count > 0)
        qsort(s.objects, s.count, sizeof *s.objects, compare);
    for (size_t i = 0; i < s.count && !d->mistake.failed; i++) {
        if (s.objects[i].node->type != YAML_MAPPING_NODE)
            ect_mistake(&d->mistake, s.objects[i].line, "object %04X is no object: save the project again",
                        (unsigned int)s.objects[i].index);
        else if (add_object(d, &s.objects[i]) && first != 0)
            map_object(d, (uint16_t)(first + i), first == FIRST_TXPDO, s.objects[i].line);
    }
}

static void add_text(ect_draft_t *d, const yaml_node_t *form, uint16_t index, const char *name, const char *key)
{
    const ect_word_t text = word_of(d, form, key);
    ect_word_t words[ECT_WORDS] = {{.text = NULL}};
    ect_draft_entry_t entry;
    if (text.text == NULL || d->mistake.failed || ect_draft_find(d, index) != NULL)
        return;
    words[ECT_WORD_TYPE] = (ect_word_t){.text = "STRING", .line = text.line};
    words[ECT_WORD_DEFAULT] = text;
    ect_draft_words(d, &entry, words, text.line);
    const ect_word_t number = {.text = ect_arena_print(d->arena, "0x%04X", (unsigned int)index), .line = text.line};
    if (!d->mistake.failed && ect_draft_add(d, number, ECT_OBJECT_VAR, name) != NULL)
        (void)ect_draft_entry(d, 0, &entry);
}

/* --- the whole ---------------------------------------------------------------------------------------------------- */

static void take_clocks(ect_draft_t *d, const yaml_node_t *list)
{
    const yaml_node_item_t *top =
        list != NULL && list->type == YAML_SEQUENCE_NODE ? list->data.sequence.items.top : NULL;
    for (const yaml_node_item_t *i = top != NULL ? list->data.sequence.items.start : NULL;
         i < top && !d->mistake.failed; i++) {
        const yaml_node_t *node = ect_yaml_node(&d->yaml, *i);
        ect_esi_dc_t *mode = ect_draft_mode(d);
        mode->name = text_of(d, node, "Name");
        mode->description = text_of(d, node, "Description");
        mode->assign_activate = (uint16_t)number_of(d, node, "AssignActivate", 0, UINT16_MAX);
        mode->cycle_sync0_ns = number_of(d, node, "Sync0cycleTime", 0, INT32_MAX);
        mode->shift_sync0_ns = number_of(d, node, "Sync0shiftTime", 0, INT32_MAX);
        mode->cycle_sync1_ns = number_of(d, node, "Sync1cycleTime", 0, INT32_MAX);
        mode->shift_sync1_ns = number_of(d, node, "Sync1shiftTime", 0, INT32_MAX);
    }
}

bool ect_draft_is_project(ect_draft_t *d, const yaml_node_t *root)
{
    return ect_yaml_find(&d->yaml, root, "form") != NULL && ect_yaml_find(&d->yaml, root, "od") != NULL;
}

void ect_draft_project(ect_draft_t *d, const yaml_node_t *root)
{
    const yaml_node_t *form = ect_yaml_find(&d->yaml, root, "form");
    const yaml_node_t *od = ect_yaml_find(&d->yaml, root, "od");
    if (form->type != YAML_MAPPING_NODE || od->type != YAML_MAPPING_NODE) {
        ect_yaml_fail(&d->yaml, root, "'form' and 'od' of a project are mappings: save the project again");
        return;
    }
    take_identity(d, form);
    take_mailbox(d, form);
    take_eeprom(d, form);
    take_section(d, od, "rxpdo", FIRST_RXPDO);
    take_section(d, od, "txpdo", FIRST_TXPDO);
    take_section(d, od, "sdo", 0);
    add_text(d, form, 0x1008, "Device Name", "TextDeviceName");
    add_text(d, form, 0x1009, "Hardware Version", "HWversion");
    add_text(d, form, 0x100A, "Software Version", "SWversion");
    take_clocks(d, ect_yaml_find(&d->yaml, root, "dc"));
    if (!d->mistake.failed)
        take_syncmanagers(d, form);
    if (!d->mistake.failed)
        ect_draft_end(d);
}
