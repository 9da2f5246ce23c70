/* SPDX-License-Identifier: MIT */
/* Servo drive profile over EtherCAT (mailbox type 5): the IDNs of drives, procedure commands, lists of process data. */
#include "seams/soe.h"

#include <string.h>

#include "seams/standard.h"
#include "slave/internal.h"

enum { READ = 1, READ_DONE = 2, WRITE = 3, WRITE_DONE = 4, NOTIFICATION = 5, EMERGENCY = 6 };
enum { OPERATION = 0x07, INCOMPLETE = 0x08, FAILED = 0x10, DRIVE = 5 /* its first bit */, HEADER = 4, LENGTHS = 4 };
enum { IDLE, REPLYING, COLLECTING };
enum { ELEMENTS = 8, VALUE = 6 /* number of the value among them */, MISSING = 1, LOCKED = 4 };
enum { TELEGRAM_TYPE = 15, APPLICATION_TELEGRAM = 7, AT_LIST = 16, ALL_IDNS = 17, MDT_LIST = 24, MDT_CHOICE = 188 };
enum { NOT_FOR_SAFEOP = 21, NOT_FOR_OP = 22, CHECK_FOR_SAFEOP = 127, CHECK_FOR_OP = 128 };
enum { CONTROL_WORD = 134, STATUS_WORD = 135, COMMAND_CHANGE = 0x20, WRITE_SET = 1, WRITE_START = 3 };

/* An IDN of a drive. */
typedef struct place {
    const ect_soe_t *soe;
    const ect_soe_drive_t *drive;
    const ect_soe_idn_t *idn;
    uint8_t *instance;
    uint8_t number; /* of the drive */
} place_t;

/* Elements of a reply, in the buffer. */
typedef struct output {
    uint8_t *to;
    uint32_t length, room;
} output_t;

static ect_soe_state_t *state_of(const ect_soe_t *soe, void *instance)
{
    return (ect_soe_state_t *)(void *)((uint8_t *)instance + soe->offset);
}

static const ect_soe_t *entry_of(const ect_protocol_t *self)
{
    return (const ect_soe_t *)(const void *)self;
}

const ect_soe_idn_t *ect_soe_find(const ect_soe_drive_t *drive, uint16_t idn)
{
    unsigned int low = 0;
    unsigned int high = drive->count;
    while (low < high) {
        unsigned int middle = (low + high) / 2;
        if (drive->idns[middle].idn < idn)
            low = middle + 1;
        else
            high = middle;
    }
    return low < drive->count && drive->idns[low].idn == idn ? &drive->idns[low] : NULL;
}

/* --- values ------------------------------------------------------------------------------------------------------- */

static bool is_list(const ect_soe_idn_t *idn)
{
    return (idn->attribute & ECT_SOE_LIST) != 0;
}

static bool is_command(const ect_soe_idn_t *idn)
{
    return (idn->attribute & ECT_SOE_COMMAND) != 0;
}

/* Memory of a list. */
typedef ECT_SOE_LIST_MEMORY(1) list_t;
enum { LIST_DATA = offsetof(list_t, data) };

static void *memory(const place_t *p)
{
    ECT_ASSERT(p->idn->offset != 0);
    return p->instance + p->idn->offset;
}

static ect_soe_command_t *command_of(const place_t *p)
{
    return (ect_soe_command_t *)memory(p);
}

static uint16_t *used_of(const place_t *p)
{
    return (uint16_t *)memory(p);
}

static uint8_t *data_of(const place_t *p)
{
    return (uint8_t *)memory(p) + LIST_DATA;
}

static uint16_t capacity(const ect_soe_idn_t *idn)
{
    return idn->size != 0 ? idn->size : idn->used;
}

/* A number between the wire and the memory, either way. */
static void copy_number(uint8_t *to, const uint8_t *from, uint16_t width)
{
    for (uint16_t i = 0; i < width; i++)
        to[i] = from[ect_host_is_little_endian() ? i : width - 1 - i];
}

static uint64_t number_of(const place_t *p)
{
    uint8_t wire[8] = {0};
    if (p->idn->offset == 0)
        return p->idn->initial;
    copy_number(wire, memory(p), ect_soe_width(p->idn->attribute));
    return ect_load_le64(wire);
}

static void set_number(const place_t *p, uint64_t number)
{
    uint8_t wire[8];
    ect_store_le64(wire, number);
    copy_number(memory(p), wire, ect_soe_width(p->idn->attribute));
}

/* Converts a number so that its order is that of unsigned numbers. */
static uint64_t order(uint32_t attribute, uint64_t number)
{
    const unsigned int unused = 64u - 8u * ect_soe_width(attribute);
    const uint64_t sign = 1ull << 63;
    const uint32_t kind = attribute & ECT_SOE_KIND;
    number <<= unused;
    if (kind == ECT_SOE_FLOAT && (number & sign) != 0)
        return ~number;
    return kind == ECT_SOE_FLOAT || kind == ECT_SOE_SIGNED ? number ^ sign : number;
}

static uint16_t check_limits(const ect_soe_idn_t *idn, uint64_t number)
{
    const uint64_t place = order(idn->attribute, number);
    if ((idn->flags & ECT_SOE_MINIMUM) != 0 && place < order(idn->attribute, (uint64_t)idn->minimum))
        return ECT_SOE_TOO_LOW;
    if ((idn->flags & ECT_SOE_MAXIMUM) != 0 && place > order(idn->attribute, (uint64_t)idn->maximum))
        return ECT_SOE_TOO_HIGH;
    return ECT_SOE_OK;
}

/* @return an IDN of the drive of `p` that has memory */
static bool find_memory(const place_t *p, uint16_t idn, place_t *found)
{
    *found = *p;
    found->idn = ect_soe_find(p->drive, idn);
    return found->idn && found->idn->offset != 0;
}

/* --- elements of a reply ------------------------------------------------------------------------------------------ */

/* Whether a list that the stack makes contains an IDN of the table. */
static bool is_in_made(uint16_t list, const ect_soe_idn_t *idn)
{
    if (list == ALL_IDNS)
        return true;
    return (idn->flags & (list == MDT_CHOICE ? ECT_SOE_IN_MDT : ECT_SOE_IN_AT)) != 0;
}

static uint16_t made_length(const ect_soe_drive_t *drive, uint16_t list)
{
    unsigned int bytes = 0;
    for (unsigned int i = 0; i < drive->count; i++)
        bytes += is_in_made(list, &drive->idns[i]) ? 2u : 0u;
    return (uint16_t)bytes;
}

static uint8_t *take(output_t *o, uint32_t bytes)
{
    ECT_ASSERT(bytes <= o->room - o->length);
    o->length += bytes;
    return o->to + o->length - bytes;
}

static void put_number(output_t *o, uint64_t number, uint16_t width)
{
    uint8_t wire[8];
    ect_store_le64(wire, number);
    memcpy(take(o, width), wire, width);
}

/* A list, or with `data` NULL only its two length words. */
static void put_list(output_t *o, const void *data, uint16_t used, uint16_t most)
{
    put_number(o, used | (uint32_t)most << 16, LENGTHS);
    if (data && used > 0)
        memcpy(take(o, used), data, used);
}

static void put_text(output_t *o, const char *text)
{
    const uint16_t length = (uint16_t)strlen(text);
    put_list(o, text, length, length);
}

static void put_made(output_t *o, const place_t *p)
{
    const uint16_t length = made_length(p->drive, p->idn->idn);
    put_list(o, NULL, length, length);
    for (unsigned int i = 0; i < p->drive->count; i++) {
        if (is_in_made(p->idn->idn, &p->drive->idns[i]))
            put_number(o, p->drive->idns[i].idn, 2);
    }
}

static void put_value(output_t *o, const place_t *p)
{
    const ect_soe_idn_t *idn = p->idn;
    if (ect_soe_is_made(idn)) {
        put_made(o, p);
    } else if (!is_list(idn)) {
        put_number(o, number_of(p), ect_soe_width(idn->attribute));
    } else if (idn->offset != 0) {
        ECT_ASSERT(*used_of(p) <= capacity(idn));
        put_list(o, data_of(p), *used_of(p), capacity(idn));
    } else {
        put_list(o, idn->content, idn->used, capacity(idn));
    }
}

static void put_element(output_t *o, const place_t *p, unsigned int element)
{
    const ect_soe_idn_t *idn = p->idn;
    const uint16_t width = ect_soe_width(idn->attribute);
    switch (1u << element) {
    case ECT_SOE_ELEMENT_STATE:
        put_number(o, command_of(p)->state, 2);
        break;
    case ECT_SOE_ELEMENT_NAME:
        put_text(o, idn->name);
        break;
    case ECT_SOE_ELEMENT_ATTRIBUTE:
        put_number(o, idn->attribute, 4);
        break;
    case ECT_SOE_ELEMENT_UNIT:
        put_text(o, idn->unit);
        break;
    case ECT_SOE_ELEMENT_MINIMUM:
        put_number(o, (uint64_t)idn->minimum, width);
        break;
    case ECT_SOE_ELEMENT_MAXIMUM:
        put_number(o, (uint64_t)idn->maximum, width);
        break;
    case ECT_SOE_ELEMENT_VALUE:
        put_value(o, p);
        break;
    default:
        put_number(o, idn->initial, width);
        break;
    }
}

/* The elements that an IDN has. */
static unsigned int elements_of(const ect_soe_idn_t *idn)
{
    return ECT_SOE_ELEMENT_ATTRIBUTE | ECT_SOE_ELEMENT_VALUE | (is_command(idn) ? ECT_SOE_ELEMENT_STATE : 0u) |
           (idn->name ? ECT_SOE_ELEMENT_NAME : 0u) | (idn->unit ? ECT_SOE_ELEMENT_UNIT : 0u) |
           ((idn->flags & ECT_SOE_MINIMUM) != 0 ? ECT_SOE_ELEMENT_MINIMUM : 0u) |
           ((idn->flags & ECT_SOE_MAXIMUM) != 0 ? ECT_SOE_ELEMENT_MAXIMUM : 0u) |
           ((idn->flags & ECT_SOE_DEFAULT) != 0 ? ECT_SOE_ELEMENT_DEFAULT : 0u);
}

static uint32_t text_length(const char *text)
{
    return text ? LENGTHS + (uint32_t)strlen(text) : 0;
}

static uint32_t longest_of(const ect_soe_drive_t *drive, const ect_soe_idn_t *idn)
{
    enum { NUMBERS = 2 + 4 + 4 * 8 }; /* data state, attribute, limits, default, and a value that is no list */
    uint32_t list = is_list(idn) ? (uint32_t)LENGTHS + capacity(idn) : 0;
    if (ect_soe_is_made(idn))
        list = (uint32_t)LENGTHS + made_length(drive, idn->idn);
    return NUMBERS + text_length(idn->name) + text_length(idn->unit) + list;
}

uint32_t ect_soe_longest(const ect_soe_t *soe)
{
    uint32_t longest = 0;
    for (unsigned int n = 0; n < soe->drive_count; n++) {
        for (unsigned int i = 0; i < soe->drives[n].count; i++) {
            uint32_t length = longest_of(&soe->drives[n], &soe->drives[n].idns[i]);
            longest = length > longest ? length : longest;
        }
    }
    return longest;
}

/* --- process data ------------------------------------------------------------------------------------------------- */

static void set_element(const ect_od_t *od, uint16_t index, unsigned int subindex, uint32_t value)
{
    const ect_object_t *object = NULL;
    const ect_entry_t *entry = NULL;
    uint8_t wire[4];
    ect_store_le32(wire, value);
    (void)ect_od_lookup(od, index, (uint8_t)subindex, &object, &entry);
    ECT_ASSERT(entry);
    (void)ect_od_write(od, entry, 0, wire, ect_od_bytes(entry));
}

/* Maps the content of a list of process data, after the control word or status word. */
static void map(const place_t *p)
{
    const ect_standard_t *standard = (const ect_standard_t *)(const void *)p->instance;
    const ect_od_t od = ect_device_od(standard->device, p->instance);
    const uint16_t object = p->idn->idn == AT_LIST ? p->drive->at : p->drive->mdt;
    const unsigned int count = *used_of(p) / 2u;
    if (object == 0)
        return;
    for (unsigned int i = 0; i < count; i++) {
        const ect_soe_idn_t *mapped = ect_soe_find(p->drive, ect_load_le16(data_of(p) + 2u * (size_t)i));
        ECT_ASSERT(mapped);
        set_element(&od, object, i + 2, mapped->mapping);
    }
    set_element(&od, object, 0, count + 1);
}

static bool is_process_list(const ect_soe_idn_t *idn)
{
    return idn->idn == AT_LIST || idn->idn == MDT_LIST;
}

static bool can_be_mapped(const place_t *p, const uint8_t *data, uint16_t size)
{
    const unsigned int flag = p->idn->idn == AT_LIST ? ECT_SOE_IN_AT : ECT_SOE_IN_MDT;
    for (unsigned int at = 0; at < size; at += 2) {
        const ect_soe_idn_t *mapped = ect_soe_find(p->drive, ect_load_le16(data + at));
        if (!mapped || (mapped->flags & flag) == 0)
            return false;
    }
    return true;
}

/* Whether the process data of a drive write an IDN. */
static bool is_in_mdt(const place_t *p)
{
    place_t list;
    if (p->drive->mdt == 0)
        return false;
    if (p->idn->idn == CONTROL_WORD)
        return true;
    if (!find_memory(p, MDT_LIST, &list))
        return false;
    for (unsigned int at = 0; at < *used_of(&list); at += 2) {
        if (ect_load_le16(data_of(&list) + at) == p->idn->idn)
            return true;
    }
    return false;
}

static void set_default(const place_t *p)
{
    const ect_soe_idn_t *idn = p->idn;
    if (!is_list(idn)) {
        set_number(p, idn->initial);
        return;
    }
    ECT_ASSERT(idn->used <= capacity(idn));
    *used_of(p) = idn->content ? idn->used : 0;
    if (idn->content)
        memcpy(data_of(p), idn->content, idn->used);
    if (is_process_list(idn))
        map(p);
}

void ect_soe_set_defaults(const ect_soe_t *soe, void *instance)
{
    for (uint8_t n = 0; n < soe->drive_count; n++) {
        place_t p = {.soe = soe, .drive = &soe->drives[n], .instance = instance, .number = n};
        for (p.idn = p.drive->idns; p.idn < p.drive->idns + p.drive->count; p.idn++) {
            if (p.idn->offset != 0 && !is_command(p.idn))
                set_default(&p);
        }
    }
}

/* --- transitions -------------------------------------------------------------------------------------------------- */

static bool is_valid(const place_t *p, uint8_t target)
{
    if (!is_list(p->idn) && check_limits(p->idn, number_of(p)) != ECT_SOE_OK)
        return false;
    return !p->soe->valid || p->soe->valid(p->soe, p->instance, p->number, p->idn, target);
}

static void note_invalid(const place_t *list, uint16_t idn)
{
    uint16_t *used = used_of(list);
    if (*used + 2u > capacity(list->idn))
        return;
    ect_store_le16(data_of(list) + *used, idn);
    *used = (uint16_t)(*used + 2);
}

/* Checks a drive for a state, and lists the IDNs that prevent the state. @return whether the list is empty */
static bool check_drive(const place_t *drive, uint8_t target)
{
    const unsigned int flag = target == ECT_STATE_SAFEOP ? ECT_SOE_CHECK_SAFEOP : ECT_SOE_CHECK_OP;
    place_t p = *drive;
    place_t list;
    bool good = true;
    const bool noted = find_memory(drive, target == ECT_STATE_SAFEOP ? NOT_FOR_SAFEOP : NOT_FOR_OP, &list);
    if (noted)
        *used_of(&list) = 0;
    for (p.idn = p.drive->idns; p.idn < p.drive->idns + p.drive->count; p.idn++) {
        if ((p.idn->flags & flag) == 0 || is_valid(&p, target))
            continue;
        good = false;
        if (noted)
            note_invalid(&list, p.idn->idn);
    }
    return good;
}

static uint16_t check_up(ect_slave_t *s, uint8_t target)
{
    bool good = true;
    if (target != ECT_STATE_SAFEOP && target != ECT_STATE_OP)
        return ECT_AL_NO_ERROR;
    for (const ect_protocol_t *const *protocol = s->config.device->protocols; protocol && *protocol; protocol++) {
        if ((*protocol)->request != ect_soe_request)
            continue;
        place_t p = {.soe = entry_of(*protocol), .instance = (uint8_t *)s->config.instance};
        for (p.number = 0; p.number < p.soe->drive_count; p.number++) {
            p.drive = &p.soe->drives[p.number];
            good &= check_drive(&p, target);
        }
    }
    return good ? ECT_AL_NO_ERROR : ECT_AL_SETTINGS;
}

const ect_service_t ect_service_soe = {.check_up = check_up};

/* --- procedure commands ------------------------------------------------------------------------------------------- */

static bool has_ended(const place_t *p)
{
    const uint16_t state = command_of(p)->state;
    return state == ECT_SOE_COMMAND_DONE || state == ECT_SOE_COMMAND_ERROR;
}

/* Bit 5 of the status word. */
static void report_change(const place_t *command)
{
    place_t status;
    bool change = false;
    if (!command->drive->command_change || !find_memory(command, STATUS_WORD, &status))
        return;
    place_t p = *command;
    for (p.idn = p.drive->idns; p.idn < p.drive->idns + p.drive->count; p.idn++)
        change |= is_command(p.idn) && has_ended(&p);
    const uint64_t word = number_of(&status);
    set_number(&status, change ? word | COMMAND_CHANGE : word & ~(uint64_t)COMMAND_CHANGE);
}

static void finish(const place_t *p, bool success)
{
    ect_soe_state_t *st = state_of(p->soe, p->instance);
    ect_soe_command_t *command = command_of(p);
    if (command->state != ECT_SOE_COMMAND_RUNS)
        return;
    command->state = success ? ECT_SOE_COMMAND_DONE : ECT_SOE_COMMAND_ERROR;
    report_change(p);
    if (!p->soe->notifies && !st->notifies)
        return;
    st->notices |= (uint8_t)(1u << p->number);
    st->notice[p->number] = p->idn->idn;
    if (st->slave)
        ect_mailbox_wake(st->slave);
}

void ect_soe_finish(const ect_soe_t *soe, void *instance, uint8_t drive, uint16_t idn, bool success)
{
    ECT_ASSERT(drive < soe->drive_count);
    const place_t p = {.soe = soe,
                       .drive = &soe->drives[drive],
                       .idn = ect_soe_find(&soe->drives[drive], idn),
                       .instance = (uint8_t *)instance,
                       .number = drive};
    ECT_ASSERT(p.idn && is_command(p.idn));
    finish(&p, success);
}

/* A command that the stack executes: the check of a transition, in the state before it. */
static uint16_t check_by_command(const ect_slave_t *s, const place_t *p)
{
    const bool first = p->idn->idn == CHECK_FOR_SAFEOP;
    if (s->state != (first ? ECT_STATE_PREOP : ECT_STATE_SAFEOP))
        return ECT_SOE_COMMAND_NOT_NOW;
    finish(p, check_drive(p, first ? ECT_STATE_SAFEOP : ECT_STATE_OP));
    return ECT_SOE_OK;
}

static uint16_t start_command(const ect_slave_t *s, const place_t *p)
{
    ect_soe_command_t *command = command_of(p);
    const uint16_t before = command->state;
    uint16_t code = ECT_SOE_OK;
    command->state = ECT_SOE_COMMAND_RUNS;
    if (p->idn->idn == CHECK_FOR_SAFEOP || p->idn->idn == CHECK_FOR_OP)
        code = check_by_command(s, p);
    else if (p->soe->command)
        code = p->soe->command(p->soe, p->instance, p->number, p->idn, true, s->now_ns);
    else
        finish(p, true);
    if (code != ECT_SOE_OK)
        command->state = before;
    return code;
}

static uint16_t clear_command(const ect_slave_t *s, const place_t *p)
{
    ect_soe_command_t *command = command_of(p);
    if (command->state == ECT_SOE_COMMAND_RUNS) {
        const uint16_t code =
            p->soe->command ? p->soe->command(p->soe, p->instance, p->number, p->idn, false, s->now_ns) : ECT_SOE_OK;
        if (code != ECT_SOE_OK)
            return code;
    }
    command->state = ECT_SOE_COMMAND_CLEARED;
    return ECT_SOE_OK;
}

static uint16_t write_command(ect_slave_t *s, const place_t *p, uint16_t value)
{
    ect_soe_command_t *command = command_of(p);
    uint16_t code = ECT_SOE_OK;
    if (value != 0 && value != WRITE_SET && value != WRITE_START)
        return ECT_SOE_INVALID;
    if (value != 0 && command->state == ECT_SOE_COMMAND_RUNS)
        return ECT_SOE_COMMAND_ACTIVE;
    if (value == WRITE_START)
        code = start_command(s, p);
    else if (value == 0)
        code = clear_command(s, p);
    else
        command->state = ECT_SOE_COMMAND_SET;
    if (code != ECT_SOE_OK)
        return code;
    command->value = value;
    report_change(p);
    ect_slave_wake(s);
    return ECT_SOE_OK;
}

/* --- writes ------------------------------------------------------------------------------------------------------- */

static uint16_t element_code(unsigned int element, unsigned int cause)
{
    if (element == 0) /* the data state has codes of its own */
        return cause == LOCKED ? ECT_SOE_NO_STATE_WRITE : ECT_SOE_NO_STATE;
    return (uint16_t)((element + 1) << 12 | cause);
}

static unsigned int first_of(unsigned int elements)
{
    unsigned int element = 0;
    ECT_ASSERT(elements != 0);
    while ((elements >> element & 1u) == 0)
        element++;
    return element;
}

/* Whether a value may be written at all, and now. */
static uint16_t check_rights(const ect_slave_t *s, const place_t *p, unsigned int elements)
{
    if (elements == 0)
        return ECT_SOE_NO_ELEMENT;
    if ((elements & (elements - 1)) != 0)
        return ECT_SOE_GENERAL;
    if (elements != ECT_SOE_ELEMENT_VALUE)
        return element_code(first_of(elements), LOCKED);
    const uint32_t locks = p->idn->attribute & ECT_SOE_READ_ONLY;
    if (locks == ECT_SOE_READ_ONLY || p->idn->offset == 0 || ect_soe_is_made(p->idn))
        return ECT_SOE_VALUE_READ_ONLY;
    const uint32_t now = s->state == ECT_STATE_PREOP    ? ECT_SOE_LOCK_PREOP
                         : s->state == ECT_STATE_SAFEOP ? ECT_SOE_LOCK_SAFEOP
                                                        : ECT_SOE_LOCK_OP;
    if ((locks & now) != 0)
        return ECT_SOE_LOCKED_BY_STATE;
    return s->state >= ECT_STATE_SAFEOP && is_in_mdt(p) ? ECT_SOE_CYCLIC : ECT_SOE_OK;
}

/* Checks the length of a list: a multiple of the element's length, equal to that of the data, and within the capacity.
 */
static uint16_t check_list_length(const ect_soe_idn_t *idn, const uint8_t *data, uint16_t size)
{
    if (size < LENGTHS)
        return ECT_SOE_TOO_SHORT;
    const uint16_t used = ect_load_le16(data);
    const unsigned int behind = size - (unsigned int)LENGTHS;
    if (used > capacity(idn) || used < behind)
        return ECT_SOE_TOO_LONG;
    return used > behind || used % ect_soe_width(idn->attribute) != 0 ? ECT_SOE_TOO_SHORT : ECT_SOE_OK;
}

static uint16_t check_number(const ect_soe_idn_t *idn, const uint8_t *data, uint16_t size)
{
    uint8_t wire[8] = {0};
    const uint16_t width = ect_soe_width(idn->attribute);
    if (size != width)
        return size < width ? ECT_SOE_TOO_SHORT : ECT_SOE_TOO_LONG;
    memcpy(wire, data, width);
    return check_limits(idn, ect_load_le64(wire));
}

/* Applies the rules of the standard IDNs, then those of the device; `data` is a number, or a list without its lengths.
 */
static uint16_t check_content(const place_t *p, const uint8_t *data, uint16_t size)
{
    if (is_process_list(p->idn) && !can_be_mapped(p, data, size))
        return ECT_SOE_INVALID;
    if (p->idn->idn == TELEGRAM_TYPE && (size != 2 || ect_load_le16(data) != APPLICATION_TELEGRAM))
        return ECT_SOE_INVALID;
    return p->soe->write ? p->soe->write(p->soe, p->instance, p->number, p->idn, data, size) : ECT_SOE_OK;
}

static void store(ect_slave_t *s, const place_t *p, const uint8_t *data, uint16_t size)
{
    if (is_list(p->idn)) {
        *used_of(p) = size;
        memcpy(data_of(p), data, size);
        if (is_process_list(p->idn))
            map(p);
    } else {
        copy_number(memory(p), data, size);
    }
    if (p->soe->written)
        p->soe->written(p->soe, p->instance, p->number, p->idn, s->now_ns);
    ect_slave_wake(s);
}

static uint16_t write_value(ect_slave_t *s, const place_t *p, const uint8_t *data, uint16_t size)
{
    const bool list = is_list(p->idn);
    uint16_t code = list ? check_list_length(p->idn, data, size) : check_number(p->idn, data, size);
    if (code != ECT_SOE_OK)
        return code;
    if (is_command(p->idn))
        return write_command(s, p, ect_load_le16(data));
    if (list) {
        data += LENGTHS;
        size = (uint16_t)(size - LENGTHS);
    }
    code = check_content(p, data, size);
    if (code == ECT_SOE_OK)
        store(s, p, data, size);
    return code;
}

/* --- requests ----------------------------------------------------------------------------------------------------- */

static uint16_t locate(const ect_soe_t *soe, const ect_slave_t *s, const uint8_t *data, place_t *p)
{
    const uint8_t drive = data[0] >> DRIVE;
    if (drive >= soe->drive_count)
        return ECT_SOE_NO_DRIVE;
    *p = (place_t){.soe = soe,
                   .drive = &soe->drives[drive],
                   .idn = ect_soe_find(&soe->drives[drive], ect_load_le16(data + 2)),
                   .instance = (uint8_t *)s->config.instance,
                   .number = drive};
    return p->idn ? ECT_SOE_OK : ECT_SOE_NO_IDN;
}

/* Replies without data; a code makes it an error. */
static void reply(ect_slave_t *s, const uint8_t *request, uint16_t code)
{
    uint8_t *mail = ect_mailbox_build(s);
    memcpy(mail, request, HEADER);
    mail[0] = (uint8_t)((request[0] & ~(INCOMPLETE | FAILED)) + 1);
    if (code != ECT_SOE_OK)
        mail[0] |= FAILED;
    ect_store_le16(mail + HEADER, code);
    ect_mailbox_send(s, ECT_MAILBOX_TYPE_SOE, code != ECT_SOE_OK ? HEADER + 2 : HEADER);
}

/* Sends the next mail of a reply: each mail except the last contains the number of further mails. */
static void send_piece(const ect_soe_t *soe, ect_slave_t *s)
{
    ect_soe_state_t *st = state_of(soe, s->config.instance);
    const uint16_t room = (uint16_t)(ect_mailbox_room(s) - HEADER);
    const uint16_t rest = (uint16_t)(st->length - st->sent);
    const uint16_t bytes = rest < room ? rest : room;
    const unsigned int behind = (rest - (unsigned int)bytes + room - 1u) / room;
    uint8_t *mail = ect_mailbox_build(s);
    ECT_ASSERT(st->phase == REPLYING && bytes > 0);
    mail[0] = (uint8_t)(st->head | (behind > 0 ? INCOMPLETE : 0));
    mail[1] = st->elements;
    ect_store_le16(mail + 2, behind > 0 ? (uint16_t)behind : st->idn);
    memcpy(mail + HEADER, (uint8_t *)s->config.instance + soe->buffer + st->sent, bytes);
    st->sent = (uint16_t)(st->sent + bytes);
    st->phase = behind > 0 ? REPLYING : IDLE;
    if (behind > 0)
        ect_mailbox_wake(s);
    ect_mailbox_send(s, ECT_MAILBOX_TYPE_SOE, (uint16_t)(HEADER + bytes));
}

/* Copies the requested elements to the buffer; missing elements are omitted, unless all are missing. */
static uint16_t gather(const place_t *p, ect_soe_state_t *st, unsigned int elements)
{
    const unsigned int present = elements & elements_of(p->idn);
    if (elements == 0)
        return ECT_SOE_NO_ELEMENT;
    if (present == 0)
        return element_code(first_of(elements), MISSING);
    if ((present & ECT_SOE_ELEMENT_VALUE) != 0 && p->soe->read && !ect_soe_is_made(p->idn)) {
        const uint16_t code = p->soe->read(p->soe, p->instance, p->number, p->idn);
        if (code != ECT_SOE_OK)
            return code;
    }
    output_t o = {.to = p->instance + p->soe->buffer, .room = p->soe->buffer_size};
    for (unsigned int element = 0; element < ELEMENTS; element++) {
        if ((present >> element & 1u) != 0)
            put_element(&o, p, element);
    }
    st->elements = (uint8_t)present;
    st->length = (uint16_t)o.length;
    return ECT_SOE_OK;
}

static void read_request(const ect_soe_t *soe, ect_slave_t *s, const uint8_t *data)
{
    ect_soe_state_t *st = state_of(soe, s->config.instance);
    place_t p;
    st->phase = IDLE;
    uint16_t code = (data[0] & INCOMPLETE) != 0 ? ECT_SOE_GENERAL : locate(soe, s, data, &p);
    if (code == ECT_SOE_OK)
        code = gather(&p, st, data[1]);
    if (code != ECT_SOE_OK) {
        reply(s, data, code);
        return;
    }
    st->phase = REPLYING;
    st->head = (uint8_t)((data[0] & ~(OPERATION | FAILED)) | READ_DONE);
    st->idn = p.idn->idn;
    st->sent = 0;
    send_piece(soe, s);
}

/* A piece of a value; another drive or other elements start another value. */
static void collect(const ect_soe_t *soe, ect_slave_t *s, const uint8_t *data, uint16_t length)
{
    ect_soe_state_t *st = state_of(soe, s->config.instance);
    const uint8_t head = (uint8_t)(data[0] & ~(INCOMPLETE | FAILED));
    const unsigned int bytes = length - (unsigned int)HEADER;
    if (st->phase != COLLECTING || st->head != head || st->elements != data[1]) {
        st->phase = COLLECTING;
        st->head = head;
        st->elements = data[1];
        st->length = 0;
        st->too_long = false;
    }
    st->too_long |= bytes > (unsigned int)soe->buffer_size - st->length;
    if (st->too_long)
        return;
    memcpy((uint8_t *)s->config.instance + soe->buffer + st->length, data + HEADER, bytes);
    st->length = (uint16_t)(st->length + bytes);
}

static uint16_t write_all(const ect_soe_t *soe, ect_slave_t *s, const uint8_t *data)
{
    const ect_soe_state_t *st = state_of(soe, s->config.instance);
    place_t p;
    uint16_t code = locate(soe, s, data, &p);
    if (code == ECT_SOE_OK)
        code = check_rights(s, &p, data[1]);
    if (code == ECT_SOE_OK && st->too_long)
        code = ECT_SOE_TOO_LONG;
    if (code != ECT_SOE_OK)
        return code;
    return write_value(s, &p, p.instance + soe->buffer, st->length);
}

static void write_request(const ect_soe_t *soe, ect_slave_t *s, const uint8_t *data, uint16_t length)
{
    collect(soe, s, data, length);
    if ((data[0] & INCOMPLETE) != 0)
        return;
    state_of(soe, s->config.instance)->phase = IDLE;
    reply(s, data, write_all(soe, s, data));
}

uint16_t ect_soe_request(const ect_protocol_t *self, ect_slave_t *s, const uint8_t *data, uint16_t length)
{
    if (length < HEADER)
        return ECT_MAILBOX_ERROR_TOO_SHORT;
    const unsigned int operation = data[0] & OPERATION;
    if (operation != READ && operation != WRITE)
        return ECT_MAILBOX_ERROR_SERVICE;
    if (operation == READ)
        read_request(entry_of(self), s, data);
    else
        write_request(entry_of(self), s, data, length);
    return ECT_MAILBOX_OK;
}

/* --- mails of the slave ------------------------------------------------------------------------------------------- */

void ect_soe_emergency(const ect_soe_t *soe, void *instance, uint8_t drive, uint16_t code, uint8_t error_register,
                       const uint8_t data[5])
{
    ect_soe_state_t *st = state_of(soe, instance);
    ECT_ASSERT(drive < soe->drive_count);
    if ((uint8_t)(st->emergency_put - st->emergency_got) == ECT_SOE_EMERGENCIES) {
        st->emergencies_lost++;
        return;
    }
    ect_soe_emergency_t *emergency = &st->emergency[st->emergency_put++ % ECT_SOE_EMERGENCIES];
    *emergency = (ect_soe_emergency_t){.code = code, .drive = drive, .error_register = error_register};
    memcpy(emergency->data, data, sizeof emergency->data);
    if (st->slave)
        ect_mailbox_wake(st->slave);
}

static void send_emergency(ect_soe_state_t *st, ect_slave_t *s)
{
    const ect_soe_emergency_t *emergency = &st->emergency[st->emergency_got++ % ECT_SOE_EMERGENCIES];
    uint8_t *mail = ect_mailbox_build(s);
    mail[0] = (uint8_t)(EMERGENCY | emergency->drive << DRIVE);
    ect_store_le16(mail + HEADER, emergency->code);
    mail[HEADER + 2] = emergency->error_register;
    memcpy(mail + HEADER + 3, emergency->data, sizeof emergency->data);
    ect_mailbox_send(s, ECT_MAILBOX_TYPE_SOE, HEADER + 3 + sizeof emergency->data);
}

static void send_notice(const ect_soe_t *soe, ect_slave_t *s)
{
    ect_soe_state_t *st = state_of(soe, s->config.instance);
    const uint8_t drive = (uint8_t)first_of(st->notices);
    const place_t p = {.soe = soe,
                       .drive = &soe->drives[drive],
                       .idn = ect_soe_find(&soe->drives[drive], st->notice[drive]),
                       .instance = (uint8_t *)s->config.instance,
                       .number = drive};
    ECT_ASSERT(p.idn);
    uint8_t *mail = ect_mailbox_build(s);
    st->notices &= (uint8_t)~(1u << drive);
    mail[0] = (uint8_t)(NOTIFICATION | drive << DRIVE);
    mail[1] = ECT_SOE_ELEMENT_STATE;
    ect_store_le16(mail + 2, st->notice[drive]);
    ect_store_le16(mail + HEADER, command_of(&p)->state);
    ect_mailbox_send(s, ECT_MAILBOX_TYPE_SOE, HEADER + 2);
}

/* A reply under way comes first: no other mail of SoE occurs between its pieces. */
bool ect_soe_next(const ect_protocol_t *self, ect_slave_t *s, bool send)
{
    const ect_soe_t *soe = entry_of(self);
    ect_soe_state_t *st = state_of(soe, s->config.instance);
    const bool emergency = st->emergency_put != st->emergency_got;
    if (st->phase != REPLYING && !emergency && st->notices == 0)
        return false;
    if (!send)
        return true;
    if (st->phase == REPLYING)
        send_piece(soe, s);
    else if (emergency)
        send_emergency(st, s);
    else
        send_notice(soe, s);
    return true;
}

void ect_soe_reset(const ect_protocol_t *self, ect_slave_t *s)
{
    ect_soe_state_t *st = state_of(entry_of(self), s->config.instance);
    st->phase = IDLE;
    st->slave = s;
}
