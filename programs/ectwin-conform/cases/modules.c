/* SPDX-License-Identifier: MIT */
/* G. CoE: modular devices (ETG.5001), the lists of module idents. */
#include "steps/case.h"

enum { CONFIGURED = 0xF030, DETECTED = 0xF050, MOST = 254, IDENT_BYTES = 4, COUNT_BYTES = 2 };
enum { ACK = 0x10, UNLIKE = 0x0070, WRONG_STATE = 0x08000022, READ_ONLY = 0x06010002, ASSIGNMENTS = 0x1C10 };

/* The modules in the slots. */
typedef struct slots {
    uint8_t count;
    uint32_t idents[MOST + 1];
} slots_t;

/* The slave in PREOP, and its modules. */
static void begin(cf_t *c, slots_t *slots)
{
    uint32_t code;
    cf_go(c, CF_PREOP);
    if (!cf_object_exists(c, CONFIGURED, 0, &code) || !cf_object_exists(c, DETECTED, 0, &code))
        cf_skip(c, "the slave has no lists of module idents (F030h, F050h)");
    slots->count = (uint8_t)cf_upload_number(c, DETECTED, 0);
    if (slots->count == 0 || slots->count > MOST)
        cf_skip(c, "no slot of the slave has a module");
    for (unsigned int i = 1; i <= slots->count; i++)
        slots->idents[i] = (uint32_t)cf_upload_number(c, DETECTED, (uint8_t)i);
}

static uint32_t write_ident(cf_t *c, uint8_t slot, uint32_t ident)
{
    uint8_t data[IDENT_BYTES];
    ect_store_le32(data, ident);
    return cf_change(c, CONFIGURED, slot, data, sizeof data);
}

static uint32_t write_count(cf_t *c, uint8_t count)
{
    return cf_change(c, CONFIGURED, 0, &count, 1);
}

static void write_elements(cf_t *c, const slots_t *slots)
{
    for (unsigned int i = 1; i <= slots->count; i++)
        cf_expect(c, "abort of an ident of F030h", 0, write_ident(c, (uint8_t)i, slots->idents[i]));
}

/* Idents of F030h, read back. */
static void expect_list(cf_t *c, const slots_t *slots)
{
    for (unsigned int i = 1; i <= slots->count; i++)
        cf_expect(c, "an ident of F030h", slots->idents[i], cf_upload_number(c, CONFIGURED, (uint8_t)i));
}

static bool has_twice(cf_t *c, uint16_t assignment)
{
    uint16_t pdos[MOST];
    const unsigned int count = (unsigned int)cf_upload_number(c, assignment, 0);
    for (unsigned int i = 0; i < count && i < MOST; i++) {
        pdos[i] = (uint16_t)cf_upload_number(c, assignment, (uint8_t)(i + 1));
        for (unsigned int k = 0; k < i; k++) {
            if (pdos[k] == pdos[i])
                return true;
        }
    }
    return false;
}

/* A list in a way of the master's: each starts with the modules in the slots, and ends in SAFEOP. */
static void expect_accepted(cf_t *c, const slots_t *slots)
{
    uint32_t code;
    expect_list(c, slots);
    for (unsigned int n = 0; n < c->facts.sm_count; n++) {
        const uint16_t assignment = (uint16_t)(ASSIGNMENTS + n);
        if (c->facts.sm[n].type >= ECT_SM_OUTPUTS && cf_object_exists(c, assignment, 0, &code))
            cf_expect_that(c, !has_twice(c, assignment), "%04Xh: expected each PDO once, got one twice", assignment);
    }
    cf_go(c, CF_SAFEOP);
    cf_go(c, CF_PREOP);
}

static void complete(cf_t *c, const slots_t *slots)
{
    uint8_t data[COUNT_BYTES + IDENT_BYTES * MOST] = {slots->count};
    if ((c->facts.has & CF_COMPLETE) == 0)
        return;
    for (unsigned int i = 1; i <= slots->count; i++)
        ect_store_le32(data + COUNT_BYTES + (size_t)IDENT_BYTES * (i - 1), slots->idents[i]);
    cf_step(c, "F030h by Complete Access");
    cf_expect(c, "abort of F030h", 0,
              cf_download(c, CONFIGURED, 0, true, data, COUNT_BYTES + (size_t)IDENT_BYTES * slots->count));
    expect_accepted(c, slots);
}

static void detected_are_accepted(cf_t *c)
{
    static slots_t slots; /* too large for a stack */
    begin(c, &slots);
    cf_step(c, "F030h ident by ident");
    write_elements(c, &slots);
    expect_accepted(c, &slots);
    cf_step(c, "F030h with count 0, idents, count");
    const uint32_t code = write_count(c, 0);
    cf_expect_that(c, code == 0 || code == READ_ONLY, "count of F030h: expected 0 or abort 0x06010002, got 0x%08X",
                   code);
    if (code == 0) {
        write_elements(c, &slots);
        cf_expect(c, "abort of the count of F030h", 0, write_count(c, slots.count));
        expect_accepted(c, &slots);
    }
    complete(c, &slots);
}

/* Bytes that a SyncManager has with the present assignment. */
static uint16_t mapped_bytes(cf_t *c, uint16_t assignment)
{
    uint32_t bits = 0;
    const unsigned int count = (unsigned int)cf_upload_number(c, assignment, 0);
    for (unsigned int i = 1; i <= count; i++) {
        const uint16_t pdo = (uint16_t)cf_upload_number(c, assignment, (uint8_t)i);
        const unsigned int entries = (unsigned int)cf_upload_number(c, pdo, 0);
        for (unsigned int k = 1; k <= entries; k++)
            bits += (uint32_t)cf_upload_number(c, pdo, (uint8_t)k) & 0xFF;
    }
    return (uint16_t)((bits + 7) / 8);
}

/* The SyncManagers of process data as the dictionary is now: idents may have changed the PDOs. */
static void set_process_data(cf_t *c)
{
    uint32_t code;
    cf_set_process_data(c);
    for (unsigned int n = 0; n < c->facts.sm_count; n++) {
        const cf_sm_t *sm = &c->facts.sm[n];
        const uint16_t assignment = (uint16_t)(ASSIGNMENTS + n);
        if (sm->type >= ECT_SM_OUTPUTS && cf_object_exists(c, assignment, 0, &code))
            cf_set_sm(c, n, sm->start, mapped_bytes(c, assignment), sm->control);
    }
}

/* Writes an ident unlike that in its slot. @return whether the slave takes it; if not, the old one must stay */
static bool takes(cf_t *c, uint8_t slot, uint32_t ident)
{
    const uint64_t before = cf_upload_number(c, CONFIGURED, slot);
    if (write_ident(c, slot, ident) == 0)
        return true;
    cf_expect(c, "the ident of F030h after a refusal", before, cf_upload_number(c, CONFIGURED, slot));
    return false;
}

/* Makes F030h unlike F050h. @return false: the slave refuses each way at once */
static bool make_unlike(cf_t *c, const slots_t *slots)
{
    unsigned int filled = 0;
    uint8_t first = 0;
    for (unsigned int i = slots->count; i >= 1; i--) {
        first = slots->idents[i] != 0 ? (uint8_t)i : first;
        filled += slots->idents[i] != 0;
    }
    if (first == 0)
        cf_skip(c, "no slot of the slave has a module");
    for (unsigned int i = 1; i <= slots->count; i++) {
        if (slots->idents[i] == 0 && takes(c, (uint8_t)i, slots->idents[first]))
            return true;
    }
    return takes(c, first, slots->idents[first] ^ 0x00A5A5A5u) || (filled > 1 && takes(c, first, 0));
}

static void unlike_are_refused(cf_t *c)
{
    static slots_t slots;
    begin(c, &slots);
    write_elements(c, &slots);
    cf_step(c, "a module that is not there");
    if (make_unlike(c, &slots)) {
        set_process_data(c);
        cf_expect_refused(c, CF_SAFEOP, CF_PREOP, UNLIKE);
        cf_expect_state(c, CF_PREOP | ACK, CF_PREOP);
        write_elements(c, &slots);
    } else {
        cf_note(c, "idents unlike those of F050h are refused at once");
    }
    cf_step(c, "F030h in SAFEOP");
    set_process_data(c);
    cf_expect_state(c, CF_SAFEOP, CF_SAFEOP);
    cf_expect(c, "abort of an ident in SAFEOP", WRONG_STATE, write_ident(c, 1, slots.idents[1]));
}

static const cf_case_t cases[] = {
    {"CF-M01", "The detected modules are taken as configured, by elements, with the count, and by Complete Access", 'F',
     CF_COE, 60000, detected_are_accepted},
    {"CF-M02", "Modules unlike the detected ones are refused at SAFEOP or at once; F030h is refused in SAFEOP", 'R',
     CF_COE, 60000, unlike_are_refused},
};

CF_SECTION(cf_modules, 'G', "CoE: modular devices", cases);
