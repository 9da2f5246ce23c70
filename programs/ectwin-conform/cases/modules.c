/* SPDX-License-Identifier: MIT */
/* G. CoE: modular devices (ETG.5001): the lists of module idents, parameters of PDOs. */
#include <string.h>

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

/* A way in which a master writes the list. Each starts with the modules in the slots, and ends in SAFEOP. */
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

/* @return the bytes of a SyncManager with the present assignment */
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

/* Configures the SyncManagers of process data from the dictionary, because idents may have changed the PDOs. */
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

/* Writes an ident other than that of the slot. @return whether the slave accepts it; if not, the old ident must stay */
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

/* --- parameters of PDOs ------------------------------------------------------------------------------------------- */

enum { TX_PARAMETERS = 0x1800, BELOW_MAPPING = 0x200, TX_PDO = 0x1A00, STATE = 7, TOGGLE = 9, EXCLUDED = 6 };
enum { CHANGES = 4, CYCLES = 2000, MOST_EXCLUDED = 64 };

/* Bits in the inputs of TxPDO toggles and states. */
typedef struct marks {
    uint16_t toggles[MOST], states[MOST];
    unsigned int toggle_count, state_count;
} marks_t;

static void find_mark(marks_t *marks, uint32_t entry, unsigned int bit)
{
    const uint32_t index = entry >> 16, sub = entry >> 8 & 0xFF;
    if (index < TX_PARAMETERS || index >= TX_PDO || (entry & 0xFF) != 1)
        return;
    if (sub == TOGGLE && marks->toggle_count < MOST)
        marks->toggles[marks->toggle_count++] = (uint16_t)bit;
    else if (sub == STATE && marks->state_count < MOST)
        marks->states[marks->state_count++] = (uint16_t)bit;
}

/* Adds those of a SyncManager, whose inputs begin at a bit. @return the bit behind its inputs */
static unsigned int find_marks(cf_t *c, marks_t *marks, uint16_t assignment, unsigned int bit)
{
    const unsigned int count = (unsigned int)cf_upload_number(c, assignment, 0);
    for (unsigned int i = 1; i <= count; i++) {
        const uint16_t pdo = (uint16_t)cf_upload_number(c, assignment, (uint8_t)i);
        const unsigned int entries = (unsigned int)cf_upload_number(c, pdo, 0);
        for (unsigned int k = 1; k <= entries; k++) {
            const uint32_t entry = (uint32_t)cf_upload_number(c, pdo, (uint8_t)k);
            find_mark(marks, entry, bit);
            bit += entry & 0xFF;
        }
    }
    return (bit + 7) / 8 * 8;
}

static bool bit_of(const uint8_t *inputs, unsigned int bit)
{
    return (inputs[bit / 8] >> bit % 8 & 1) != 0;
}

/* Cycles until a bit has changed several times: a device may renew its inputs less often than a master reads them. */
static void expect_toggle(cf_t *c, unsigned int bit)
{
    uint8_t before[CF_MAX_DATA] = {0}, now[CF_MAX_DATA] = {0};
    unsigned int changes = 0;
    cf_expect_wkc(c, "process data in OP", cf_cycle_wkc(c), cf_cycle(c, NULL, before));
    for (unsigned int i = 0; i < CYCLES && changes < CHANGES; i++) {
        cf_poll_pause(c);
        (void)cf_cycle(c, NULL, now);
        changes += bit_of(now, bit) != bit_of(before, bit);
        memcpy(before, now, sizeof before);
    }
    cf_expect_that(c, changes == CHANGES,
                   "TxPDO toggle, bit %u of the inputs: expected a change with new inputs, got "
                   "%u in %u cycles",
                   bit, changes, (unsigned int)CYCLES);
}

static bool toggles_move(cf_t *c)
{
    static marks_t marks;
    uint8_t inputs[CF_MAX_DATA] = {0};
    unsigned int bit = 0;
    uint32_t code;
    marks = (marks_t){0};
    for (unsigned int n = 0; n < c->facts.sm_count; n++) {
        const uint16_t assignment = (uint16_t)(ASSIGNMENTS + n);
        if (c->facts.sm[n].type == ECT_SM_INPUTS && cf_object_exists(c, assignment, 0, &code))
            bit = find_marks(c, &marks, assignment, bit);
    }
    if (marks.toggle_count + marks.state_count == 0 || bit > 8u * c->facts.input_bytes)
        return false;
    cf_go(c, CF_OP);
    for (unsigned int i = 0; i < marks.toggle_count; i++)
        expect_toggle(c, marks.toggles[i]);
    (void)cf_cycle(c, NULL, inputs);
    for (unsigned int i = 0; i < marks.state_count; i++) {
        if (bit_of(inputs, marks.states[i]))
            cf_warn(c, "TxPDO state, bit %u of the inputs: the inputs are not valid", marks.states[i]);
    }
    cf_go(c, CF_PREOP);
    return true;
}

/* Adds a second PDO to the first one of an assignment; the runner restores elements that the assignment had. */
static uint32_t write_second(cf_t *c, uint16_t assignment, uint16_t other)
{
    const uint8_t none = 0, two = 2, sub = 2;
    const bool had = cf_upload_number(c, assignment, 0) >= two;
    uint8_t data[2];
    uint32_t code = cf_change(c, assignment, 0, &none, 1);
    ect_store_le16(data, other);
    if (code == 0)
        code = had ? cf_change(c, assignment, sub, data, sizeof data)
                   : cf_download(c, assignment, sub, false, data, sizeof data);
    return code == 0 ? cf_change(c, assignment, 0, &two, 1) : code;
}

/* @return the first existing PDO that a PDO excludes, 0: none */
static uint16_t excluded_by(cf_t *c, uint16_t pdo)
{
    uint8_t list[MOST_EXCLUDED];
    size_t size = sizeof list;
    uint32_t code;
    const uint16_t parameters = (uint16_t)(pdo - BELOW_MAPPING);
    if (!cf_object_exists(c, parameters, 0, &code) || !cf_object_exists(c, parameters, EXCLUDED, &code) ||
        cf_upload(c, parameters, EXCLUDED, false, list, &size) != 0)
        return 0;
    for (size_t i = 0; i + 1 < size; i += 2) {
        const uint16_t other = ect_load_le16(list + i);
        if (other >= TX_PDO && other != pdo && cf_object_exists(c, other, 0, &code))
            return other;
    }
    return 0;
}

static bool exclusions_hold(cf_t *c)
{
    uint32_t code;
    for (unsigned int n = 0; n < c->facts.sm_count; n++) {
        const uint16_t assignment = (uint16_t)(ASSIGNMENTS + n);
        if (c->facts.sm[n].type != ECT_SM_INPUTS || !cf_object_exists(c, assignment, 1, &code))
            continue;
        const uint16_t pdo = (uint16_t)cf_upload_number(c, assignment, 1);
        const uint16_t other = pdo >= TX_PDO ? excluded_by(c, pdo) : 0;
        if (other == 0)
            continue;
        cf_step(c, "%04Xh beside %04Xh, which it excludes", other, pdo);
        cf_expect_that(c, write_second(c, assignment, other) != 0,
                       "assigning %04Xh and %04Xh: expected an abort, got a response", pdo, other);
        return true;
    }
    return false;
}

static void inputs_have_states(cf_t *c)
{
    cf_go(c, CF_PREOP);
    const bool toggles = toggles_move(c);
    if (!exclusions_hold(c) && !toggles)
        cf_skip(c, "the slave maps no TxPDO toggle or state, and lists no excluded PDOs (18xxh:06, 07, 09)");
}

static const cf_case_t cases[] = {
    {"CF-M01", "The detected modules are taken as configured, by elements, with the count, and by Complete Access", 'F',
     CF_COE, 60000, detected_are_accepted},
    {"CF-M02", "Modules unlike the detected ones are refused at SAFEOP or at once; F030h is refused in SAFEOP", 'R',
     CF_COE, 60000, unlike_are_refused},
    {"CF-M03", "A mapped TxPDO toggle changes with the inputs; PDOs that exclude each other are refused", 'F',
     CF_COE | CF_INPUTS, 60000, inputs_have_states},
};

CF_SECTION(cf_modules, 'G', "CoE: modular devices", cases);
