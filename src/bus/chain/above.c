/* SPDX-License-Identifier: MIT */
#include "bus/chain/above.h"

#include <stdlib.h>
#include <string.h>

#include "seams/mailbox.h"
#include "wire/assert.h"
#include "wire/bytes.h"
#include "wire/registers.h"

/* Offsets in a mail, and the length of the shortest mail with an SDO. */
enum { COUNTER = 5, COE = 6, SDO = 8, SDO_INDEX = 9, SDO_SUB = 11, SDO_CODE = 12, SDO_MAIL = 16 };
enum { REQUEST = 2, RESPONSE = 3 };                             /* services of CoE */
enum { SEGMENT_DOWN, START_DOWN, START_UP, SEGMENT_UP, ABORT }; /* SDO requests */
enum { COMMAND_ABORT = 0x80, COMMAND_UPLOAD = 0x40, COMMAND_TOGGLE = 0x10 };
enum { MAIL_ROOM = 2048, SOON_NS = 100000, NO_STATE = 7 };

typedef struct rule {
    ect_fault_t fault;
    uint64_t seen;
} rule_t;

/* The last requested SDO transfer. */
typedef struct transfer {
    uint16_t index;
    uint8_t sub;
    uint8_t direction; /* ect_fault_transfer_t; ECT_FAULT_ANY_TRANSFER: none */
    int32_t step;      /* number of its last request, from 1 */
} transfer_t;

struct ect_above {
    ect_esc_t *esc;
    ect_pdi_t plain; /* the PDI without faults; it has al_event */
    uint64_t now_ns;
    rule_t rules[ECT_ABOVE_FAULTS];
    size_t count;
    transfer_t transfer;
    uint8_t request[MAIL_ROOM]; /* as read by the stack */
    uint8_t request_counter;
    uint32_t abort_code;     /* of the request; 0: the request is not aborted, and is read unchanged */
    uint16_t refused_code;   /* of the last AL control read by the stack */
    bool refused;            /* ... and not yet set in the slave */
    uint8_t mail[MAIL_ROOM]; /* the last mail on its way into SM1 */
    uint16_t start, last, length;
    bool kept;    /* `mail` is sent at due_ns */
    bool again;   /* `mail` is sent again after the master has fetched it */
    bool fetched; /* SM1 is reported to the stack as empty */
    uint64_t due_ns;
};

/* --- faults ------------------------------------------------------------------------------------------------------- */

ect_above_t *ect_above_new(ect_esc_t *esc)
{
    ect_above_t *a = calloc(1, sizeof *a);
    if (a)
        a->esc = esc;
    return a;
}

void ect_above_end(ect_above_t *a, uint32_t tag)
{
    size_t kept = 0;
    for (size_t i = 0; i < a->count; i++) {
        if (tag != 0 ? a->rules[i].fault.tag != tag : a->rules[i].fault.kind == ECT_FAULT_COUNT)
            a->rules[kept++] = a->rules[i];
    }
    a->count = kept;
}

const ect_fault_t *ect_above_at(const ect_above_t *a, size_t i)
{
    for (size_t k = 0; k < a->count; k++) {
        if (a->rules[k].fault.kind != ECT_FAULT_COUNT && i-- == 0)
            return &a->rules[k].fault;
    }
    return NULL;
}

uint64_t ect_above_seen(const ect_above_t *a, uint32_t tag)
{
    uint64_t seen = 0;
    for (size_t i = 0; i < a->count; i++)
        seen += a->rules[i].fault.tag == tag ? a->rules[i].seen : 0;
    return seen;
}

/* @return whether a fault applies to the present event among those that it counts */
static bool applies(rule_t *rule)
{
    return ect_fault_applies(&rule->fault, ++rule->seen, &rule->fault.seed);
}

static void end_those_over(ect_above_t *a)
{
    size_t kept = 0;
    for (size_t i = 0; i < a->count; i++) {
        const rule_t *rule = &a->rules[i];
        if (!(rule->fault.when == ECT_FAULT_ONCE && rule->seen >= rule->fault.number))
            a->rules[kept++] = *rule;
    }
    a->count = kept;
}

/* @return whether a fault names the transfer */
static bool is_of(const transfer_t *t, const ect_fault_object_t *object)
{
    return t->direction != ECT_FAULT_ANY_TRANSFER && object->index == t->index &&
           (!object->has_sub || object->sub == t->sub) &&
           (object->transfer == ECT_FAULT_ANY_TRANSFER || object->transfer == t->direction);
}

/* --- requests ----------------------------------------------------------------------------------------------------- */

static const uint8_t *sm_registers(const ect_above_t *a, unsigned int n)
{
    return a->esc->config.memory + ECT_REG_SM + n * ECT_SM_SIZE;
}

static bool is_sdo(const uint8_t *mail, unsigned int service)
{
    return (mail[COUNTER] & 0x0F) == ECT_MAILBOX_TYPE_COE && ect_load_le16(mail) >= SDO_MAIL - COE &&
           mail[COE + 1] >> 4 == service;
}

/* Follows the transfer: the present one continues, or another one begins. */
static void follow_transfer(ect_above_t *a, const uint8_t *mail)
{
    transfer_t *t = &a->transfer;
    unsigned int command = mail[SDO] >> 5;
    if (command == SEGMENT_DOWN || command == SEGMENT_UP) {
        t->step++;
        return;
    }
    *t = (transfer_t){.index = ect_load_le16(mail + SDO_INDEX), .sub = mail[SDO_SUB], .step = 1};
    if (command == START_DOWN || command == START_UP)
        t->direction = command == START_UP ? ECT_FAULT_UPLOAD : ECT_FAULT_DOWNLOAD;
}

/* Aborts a request before the device gets it: the stack reads an upload of object 0000h instead, and aborts that. */
static void replace_request(ect_above_t *a, uint32_t code)
{
    uint8_t *mail = a->request;
    a->abort_code = code;
    ect_store_le16(mail, SDO_MAIL - COE);
    memset(mail + SDO, 0, SDO_MAIL - SDO);
    mail[SDO] = COMMAND_UPLOAD;
}

static void check_sdo(ect_above_t *a)
{
    for (size_t i = 0; i < a->count; i++) {
        rule_t *rule = &a->rules[i];
        const ect_fault_t *fault = &rule->fault;
        bool sees = fault->kind == ECT_FAULT_ABORT || fault->kind == ECT_FAULT_COUNT;
        int32_t step = fault->amount > 0 ? fault->amount : 1;
        if (!sees || step != a->transfer.step || !is_of(&a->transfer, &fault->object) || !applies(rule))
            continue;
        if (fault->kind == ECT_FAULT_ABORT && a->abort_code == 0)
            replace_request(a, fault->code);
    }
    end_those_over(a);
}

/* @return whether the request is new: a request repeated by the master counts once */
static void take_request(ect_above_t *a, uint16_t start)
{
    const uint8_t *mail = a->esc->config.memory + start;
    uint16_t length = ect_load_le16(sm_registers(a, 0) + ECT_SM_LENGTH);
    uint8_t counter = (mail[COUNTER] >> 4) & 7;
    if (counter != 0 && counter == a->request_counter)
        return;
    a->request_counter = counter;
    a->abort_code = 0;
    if (length < SDO_MAIL || length > sizeof a->request)
        return;
    memcpy(a->request, mail, length);
    if (!is_sdo(a->request, REQUEST))
        return;
    follow_transfer(a, a->request);
    check_sdo(a);
}

/* --- AL control and SyncManagers ---------------------------------------------------------------------------------- */

/* Changes a request in AL control into one for the present state, or for a state that does not exist. */
static void change_al_control(ect_above_t *a, uint8_t *control)
{
    uint8_t state = a->esc->config.memory[ECT_REG_AL_STATUS] & 0x0F;
    uint8_t target = control[0] & 0x0F;
    a->refused_code = 0;
    for (size_t i = 0; i < a->count && target > state; i++) {
        const ect_fault_t *fault = &a->rules[i].fault;
        if (fault->kind < ECT_FAULT_AL_REFUSE || fault->kind > ECT_FAULT_AL_NEVER ||
            (fault->state != 0 && fault->state != target))
            continue;
        bool refuses = fault->kind == ECT_FAULT_AL_REFUSE;
        control[0] = (uint8_t)((control[0] & 0xF0) | (refuses ? NO_STATE : state));
        a->refused_code = refuses ? (uint16_t)fault->code : 0;
        return;
    }
}

/* Simulates process data longer than described: the length set by the master is read as shorter. */
static void change_sizes(const ect_above_t *a, uint8_t *registers, uint16_t length)
{
    for (size_t i = 0; i < a->count; i++) {
        for (unsigned int at = 2 * ECT_SM_SIZE; a->rules[i].fault.kind == ECT_FAULT_PDO_SIZE && at < length;
             at += ECT_SM_SIZE) {
            uint8_t *size = registers + at + ECT_SM_LENGTH;
            if (ect_load_le16(size) != 0)
                ect_store_le16(size, (uint16_t)(ect_load_le16(size) - a->rules[i].fault.amount));
        }
    }
}

static int read_changed(void *ctx, uint16_t address, void *buffer, uint16_t length)
{
    ect_above_t *a = ctx;
    const uint8_t *sm = sm_registers(a, 0);
    uint16_t start = ect_load_le16(sm + ECT_SM_START);
    bool inside = address >= start && address + length <= start + ect_load_le16(sm + ECT_SM_LENGTH) && start >= ECT_RAM;
    if (inside && address == start && (sm[ECT_SM_STATUS] & ECT_SM_STATUS_FULL) != 0)
        take_request(a, start);
    int result = a->plain.read(a->plain.ctx, address, buffer, length);
    if (inside && a->abort_code != 0)
        memcpy(buffer, a->request + (address - start), length);
    else if (address == ECT_REG_AL_CONTROL)
        change_al_control(a, buffer);
    else if (address == ECT_REG_SM)
        change_sizes(a, buffer, length);
    return result;
}

/* --- mails -------------------------------------------------------------------------------------------------------- */

static void emit(const ect_above_t *a)
{
    (void)a->plain.write(a->plain.ctx, a->start, a->mail, a->length);
    (void)a->plain.write(a->plain.ctx, (uint16_t)(a->start + a->last), a->mail + a->last, 1);
}

static bool is_segment(const uint8_t *mail)
{
    return is_sdo(mail, RESPONSE) && mail[SDO] >> 5 <= START_DOWN;
}

/* @return whether any fault applies to the mail */
static bool sees_mail(const ect_above_t *a, const ect_fault_t *fault)
{
    bool sdo = is_sdo(a->mail, RESPONSE) || is_sdo(a->mail, REQUEST);
    return fault->kind >= ECT_FAULT_MAIL_TOGGLE && fault->kind <= ECT_FAULT_MAIL_LOST &&
           (fault->kind != ECT_FAULT_MAIL_TOGGLE || is_segment(a->mail)) &&
           (!fault->object.named || (sdo && is_of(&a->transfer, &fault->object)));
}

/* @return the counter of the previous mail; the values are 1 to 7, then 1 */
static unsigned int counter_before(const uint8_t *mail)
{
    unsigned int counter = (mail[COUNTER] >> 4) & 7u;
    return counter > 1 ? counter - 1 : 7;
}

static void change_mail(ect_above_t *a, const ect_fault_t *fault)
{
    uint8_t *mail = a->mail;
    switch (fault->kind) {
    case ECT_FAULT_MAIL_TOGGLE:
        mail[SDO] ^= COMMAND_TOGGLE;
        return;
    case ECT_FAULT_MAIL_COUNTER:
        mail[COUNTER] = (uint8_t)((mail[COUNTER] & 0x8F) | counter_before(mail) << 4);
        return;
    case ECT_FAULT_MAIL_TYPE:
        mail[COUNTER] = (uint8_t)((mail[COUNTER] & 0xF0) | ECT_MAILBOX_TYPE_VOE);
        return;
    case ECT_FAULT_MAIL_LENGTH:
        ect_store_le16(mail, (uint16_t)(a->last + 1u));
        return;
    case ECT_FAULT_MAIL_LATE:
        a->kept = true;
        a->due_ns = a->now_ns + 1000000ull * (uint32_t)fault->amount;
        return;
    case ECT_FAULT_MAIL_TWICE:
        a->again = true;
        return;
    default:
        a->fetched = true;
        return;
    }
}

static void answer_abort(ect_above_t *a)
{
    uint8_t *mail = a->mail;
    if (a->abort_code == 0 || !is_sdo(mail, REQUEST) || mail[SDO] != COMMAND_ABORT ||
        ect_load_le16(mail + SDO_INDEX) != 0)
        return;
    ect_store_le16(mail + SDO_INDEX, a->transfer.index);
    mail[SDO_SUB] = a->transfer.sub;
    ect_store_le32(mail + SDO_CODE, a->abort_code);
}

static void forget_mails(ect_above_t *a)
{
    a->kept = a->again = a->fetched = false;
}

/* Handles a complete mail: changes it, and sends it unless it is late or lost. */
static void send_mail(ect_above_t *a)
{
    forget_mails(a);
    answer_abort(a);
    for (size_t i = 0; i < a->count; i++) {
        const ect_fault_t *fault = &a->rules[i].fault;
        if (sees_mail(a, fault) && applies(&a->rules[i]))
            change_mail(a, fault);
    }
    end_those_over(a);
    a->kept = a->kept && !a->fetched;
    if (!a->kept && !a->fetched)
        emit(a);
}

/* Keeps the bytes of a mail; its last byte completes the mail. @return whether the write belongs to a mail */
static bool take_mail(ect_above_t *a, uint16_t address, const uint8_t *bytes, uint16_t length)
{
    const uint8_t *sm = sm_registers(a, 1);
    const uint16_t start = ect_load_le16(sm + ECT_SM_START), size = ect_load_le16(sm + ECT_SM_LENGTH);
    if (start < ECT_RAM || size <= SDO_MAIL || size > sizeof a->mail)
        return false;
    if (address == start && length < size) {
        a->start = start;
        a->last = (uint16_t)(size - 1);
        a->length = length;
        memcpy(a->mail, bytes, length);
        return true;
    }
    if (address != start + a->last || length != 1 || start != a->start)
        return false;
    a->mail[a->last] = bytes[0];
    send_mail(a);
    return true;
}

static int write_changed(void *ctx, uint16_t address, const void *buffer, uint16_t length)
{
    ect_above_t *a = ctx;
    const uint8_t *bytes = buffer;
    uint8_t code[2];
    if (take_mail(a, address, bytes, length))
        return 0;
    if (address == ECT_REG_AL_STATUS && (bytes[0] & 0x0F) == ECT_STATE_INIT)
        forget_mails(a);
    a->refused |= address == ECT_REG_AL_STATUS_CODE && a->refused_code != 0 && ect_load_le16(bytes) != 0;
    if (address == ECT_REG_AL_STATUS_CODE && a->refused) {
        ect_store_le16(code, a->refused_code);
        bytes = code;
    }
    return a->plain.write(a->plain.ctx, address, bytes, length);
}

/* --- the poll ----------------------------------------------------------------------------------------------------- */

static int event_changed(void *ctx, uint32_t *event)
{
    ect_above_t *a = ctx;
    int result = a->plain.al_event(a->plain.ctx, event);
    if (a->again && (*event & ECT_EVENT_SM1) != 0) {
        a->again = false;
        emit(a);
        *event &= ~(uint32_t)ECT_EVENT_SM1;
    }
    if (a->fetched)
        *event |= ECT_EVENT_SM1;
    a->fetched = false;
    return result;
}

bool ect_above_add(ect_above_t *a, const ect_fault_t *fault, ect_pdi_t *pdi)
{
    ECT_ASSERT(ect_fault_is_above_wire(fault));
    if (a->count == ECT_ABOVE_FAULTS)
        return false;
    a->rules[a->count++] = (rule_t){.fault = *fault};
    if (pdi->ctx != a) {
        a->plain = *pdi;
        *pdi = (ect_pdi_t){.ctx = a, .read = read_changed, .write = write_changed, .al_event = event_changed};
    }
    return true;
}

void ect_above_restart(ect_above_t *a)
{
    forget_mails(a);
    a->transfer = (transfer_t){0};
    a->request_counter = 0;
    a->abort_code = 0;
    a->refused_code = 0;
    a->refused = false;
}

void ect_above_before(ect_above_t *a, uint64_t now_ns)
{
    a->now_ns = now_ns;
    if (!a->kept || now_ns < a->due_ns)
        return;
    a->kept = false;
    emit(a);
}

uint64_t ect_above_after(ect_above_t *a, ect_slave_t *slave, ect_pdi_t *pdi)
{
    if (a->refused)
        slave->code = a->refused_code;
    a->refused = false;
    if (a->fetched)
        return a->now_ns + SOON_NS;
    if (a->count == 0 && pdi->ctx == a && !a->kept && !a->again && a->abort_code == 0)
        *pdi = a->plain;
    return a->kept ? a->due_ns : ECT_NEVER;
}
