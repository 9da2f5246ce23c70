/* SPDX-License-Identifier: MIT */
/* G. CoE, part two: mapping, the information service, rights by state, emergencies, diagnosis, store, synchronisation.
 */
#include <string.h>

#include "steps/coe_walk.h"
#include "steps/esi.h"

enum {
    NO_SUBINDEX_WRITE = 0x06010003,
    READ_ONLY = 0x06010002,
    NO_OBJECT = 0x06020000,
    NO_SUBINDEX = 0x06090011,
    WRONG_STATE = 0x08000022,
};
enum { MISSING_PDO = 0x17F3, EMERGENCY_BYTES = 10, EMERGENCY_MS = 500, PARALLEL = 500 };
enum { DIAGNOSIS = 0x10F3, STORE = 0x1010, RESTORE = 0x1011, SYNC_OUT = 0x1C32, SYNC_IN = 0x1C33, TICKS_10MS = 100 };

/* Buffer of the last upload, too large for the stack. */
static uint8_t value[65536];

static uint16_t missing_index(cf_t *c)
{
    static const uint16_t candidates[] = {0x0FFF, 0x6FFF, 0x5FFE, 0x3ABC};
    uint32_t code;
    for (size_t i = 0; i < sizeof candidates / sizeof candidates[0]; i++) {
        if (!cf_object_exists(c, candidates[i], 0, &code))
            return candidates[i];
    }
    cf_skip(c, "all tested indices exist");
}

/* --- mapping ------------------------------------------------------------------------------------------------------ */

/* @return the PDO assignment object of the first process data SyncManager */
static uint16_t assignment(cf_t *c)
{
    uint32_t code;
    for (unsigned int n = 0; n < c->facts.sm_count; n++) {
        uint16_t index = (uint16_t)(0x1C10 + n);
        if (c->facts.sm[n].type >= ECT_SM_OUTPUTS && c->facts.sm[n].length > 0 && cf_object_exists(c, index, 1, &code))
            return index;
    }
    cf_skip(c, "the slave has no process data assigned by CoE");
}

static uint32_t write8(cf_t *c, uint16_t index, uint8_t sub, uint8_t byte)
{
    return cf_change(c, index, sub, &byte, 1);
}

static uint32_t write16(cf_t *c, uint16_t index, uint8_t sub, uint16_t word)
{
    uint8_t data[2];
    ect_store_le16(data, word);
    return cf_change(c, index, sub, data, sizeof data);
}

static uint32_t write32(cf_t *c, uint16_t index, uint8_t sub, uint32_t number)
{
    uint8_t data[4];
    ect_store_le32(data, number);
    return cf_change(c, index, sub, data, sizeof data);
}

static void expect_abort(cf_t *c, const char *what, uint32_t code)
{
    cf_expect_that(c, code != 0, "%s: expected an abort, got a response", what);
}

/* A fixed assignment or mapping must refuse every write. @return whether the object is fixed */
static bool fixed(cf_t *c, uint16_t index, uint8_t count)
{
    uint32_t code = write8(c, index, 0, 0);
    if (code == 0)
        return false;
    cf_expect_that(c, code == READ_ONLY || code == NO_SUBINDEX_WRITE || code == WRONG_STATE,
                   "count of %04Xh, which is fixed: expected abort 0x06010002, 3 or 0x08000022, got 0x%08X", index,
                   code);
    expect_abort(c, "an entry of a fixed assignment", write16(c, index, 1, MISSING_PDO));
    cf_expect_range(c, "entries afterwards", count, count, cf_upload_number(c, index, 0));
    return true;
}

/* Writes an assignment in the order count 0, entries, count, with writes in between that must be refused. */
static void remap(cf_t *c)
{
    cf_go(c, CF_PREOP);
    const uint16_t index = assignment(c);
    const uint8_t count = (uint8_t)cf_upload_number(c, index, 0);
    const uint16_t first = (uint16_t)cf_upload_number(c, index, 1);
    if (fixed(c, index, count)) {
        cf_note(c, "the assignment is fixed and refuses writes");
    } else {
        cf_step(c, "a non-existent PDO: refused at once or with the count");
        uint32_t code = write16(c, index, 1, MISSING_PDO);
        code = code == 0 ? write8(c, index, 0, 1) : code;
        expect_abort(c, "assigning a non-existent PDO", code);
        cf_expect(c, "abort of the right PDO again", 0, write16(c, index, 1, first));
        cf_expect(c, "abort of the count", 0, write8(c, index, 0, count));
        expect_abort(c, "an entry while the count is not 0", write16(c, index, 1, first));
    }
    cf_step(c, "SAFEOP with the previous mapping, which cannot be changed there");
    cf_go(c, CF_SAFEOP);
    expect_abort(c, "the count of an assignment in SAFEOP", write8(c, index, 0, 0));
    cf_expect_range(c, "entries afterwards", count, count, cf_upload_number(c, index, 0));
}

static void too_large(cf_t *c)
{
    cf_go(c, CF_PREOP);
    const uint16_t pdo = (uint16_t)cf_upload_number(c, assignment(c), 1);
    const uint8_t count = (uint8_t)cf_upload_number(c, pdo, 0);
    const uint32_t first = (uint32_t)cf_upload_number(c, pdo, 1);
    if (write8(c, pdo, 0, 0) != 0)
        cf_skip(c, "the mapping is fixed");
    cf_step(c, "an entry of 255 bits of a shorter object: refused at once or with the count");
    uint32_t code = write32(c, pdo, 1, (first & 0xFFFFFF00u) | 0xFF);
    code = code == 0 ? write8(c, pdo, 0, 1) : code;
    expect_abort(c, "an entry longer than its object", code);
    cf_step(c, "the previous mapping, and SAFEOP");
    cf_expect(c, "abort of the previous entry", 0, write32(c, pdo, 1, first));
    cf_expect(c, "abort of the previous count", 0, write8(c, pdo, 0, count));
    cf_go(c, CF_SAFEOP);
}

/* --- information -------------------------------------------------------------------------------------------------- */

static bool holds(const uint16_t *list, size_t count, uint16_t index)
{
    for (size_t i = 0; i < count; i++) {
        if (list[i] == index)
            return true;
    }
    return false;
}

static void lists(cf_t *c)
{
    static uint16_t all[COE_OBJECTS_MOST], some[COE_OBJECTS_MOST];
    uint16_t lengths[COE_OBJECTS_MOST];
    size_t types = cf_object_list(c, 0, lengths, COE_OBJECTS_MOST);
    cf_expect_range(c, "lengths in list 0", 5, 5, types);
    size_t count = cf_object_list(c, 1, all, COE_OBJECTS_MOST);
    cf_expect_range(c, "indices in list 1", lengths[0], lengths[0], count);
    for (size_t i = 1; i < count; i++) { /* no clause requires ascending order, but a binary search does */
        if (all[i] < all[i - 1])
            cf_warn(c, "list 1: rising as a rule, got %04Xh behind %04Xh", all[i], all[i - 1]);
        cf_expect_that(c, all[i] != all[i - 1], "list 1: expected each index once, got %04Xh twice", all[i]);
    }
    for (uint16_t type = 2; type <= 5; type++) {
        size_t n = cf_object_list(c, type, some, COE_OBJECTS_MOST);
        cf_expect_that(c, n == lengths[type - 1], "list %u: expected %u indices as in list 0, got %zu", type,
                       lengths[type - 1], n);
        for (size_t i = 0; i < n; i++)
            cf_expect_that(c, holds(all, count, some[i]), "list %u: expected indices of list 1, got %04Xh", type,
                           some[i]);
    }
}

static void check_description(cf_t *c, const coe_object_t *o)
{
    cf_expect_that(c, o->code == COE_VAR || o->code == COE_ARRAY || o->code == COE_RECORD,
                   "%04Xh: expected object code 7, 8 or 9, got %u", o->index, o->code);
    cf_expect_that(c, o->code != COE_VAR || o->most == 0, "%04Xh, a variable: expected maximum sub-index 0, got %u",
                   o->index, o->most);
    coe_entry_t e;
    if (o->code != COE_VAR && coe_entry(c, o, 0, &e))
        cf_expect_that(c, e.bits == 8, "%04Xh:00: expected 8 bits, got %u", o->index, e.bits);
    if (o->code == COE_VAR)
        cf_expect_that(c, coe_entry(c, o, 0, &e), "%04Xh:00: expected an entry description, got an info error",
                       o->index);
}

static void information(cf_t *c)
{
    uint8_t request[4] = {0}, reply[64];
    uint32_t code = 0;
    cf_go(c, CF_PREOP);
    lists(c);
    unsigned int objects = coe_walk(c, check_description);
    cf_step(c, "non-existent objects and entries");
    ect_store_le16(request, missing_index(c));
    cf_expect_that(c, cf_info(c, 3, request, 2, reply, sizeof reply, &code) < 0 && code == NO_OBJECT,
                   "description of a non-existent index: expected info error 0x06020000, got 0x%08X", code);
    ect_store_le16(request, 0x1018);
    request[2] = 0x77;
    cf_expect_that(c, cf_info(c, 5, request, 4, reply, sizeof reply, &code) < 0 && code == NO_SUBINDEX,
                   "description of 1018h:77: expected info error 0x06090011, got 0x%08X", code);
    cf_note(c, "%u objects", objects);
}

static void as_in_file(cf_t *c)
{
    const ect_esi_device_t *model = cf_esi_model(c);
    if (!model)
        cf_skip(c, "the ESI file describes an impossible device: see CF-063");
    if (model->dictionary.object_count == 0)
        cf_skip(c, "the ESI file has no dictionary%s%s", *model->dictionary_file ? ": it is in " : "",
                model->dictionary_file);
    cf_go(c, CF_PREOP);
    cf_esi_expect_objects(c);
    cf_note(c, "%zu objects of the file%s", model->dictionary.object_count,
            model->slot_count > 0 ? "; those of modules are not compared" : "");
}

/* --- rights ------------------------------------------------------------------------------------------------------- */

typedef struct limited {
    uint16_t index;
    uint8_t sub;
} limited_t;
static limited_t in_preop_only;

static void find_limited(cf_t *c, const coe_object_t *o)
{
    for (unsigned int sub = 0; sub <= o->most && in_preop_only.index == 0; sub++) {
        coe_entry_t e;
        if (coe_entry(c, o, (uint8_t)sub, &e) && (e.access & COE_WRITE_PREOP) != 0 &&
            (e.access & COE_WRITE_SAFEOP) == 0 && (e.access & COE_READ_SAFEOP) != 0 && e.bits <= 64)
            in_preop_only = (limited_t){o->index, (uint8_t)sub};
    }
}

static void by_state(cf_t *c)
{
    in_preop_only = (limited_t){0};
    cf_go(c, CF_PREOP);
    (void)coe_walk(c, find_limited);
    if (in_preop_only.index == 0)
        cf_skip(c, "no entry is writable in PREOP only");
    cf_go(c, CF_SAFEOP);
    size_t size = 8;
    uint32_t code = cf_upload(c, in_preop_only.index, in_preop_only.sub, false, value, &size);
    cf_expect_that(c, code == 0, "upload of %04Xh:%02X in SAFEOP: expected data, got abort 0x%08X", in_preop_only.index,
                   in_preop_only.sub, code);
    code = cf_change(c, in_preop_only.index, in_preop_only.sub, value, size);
    cf_expect_that(c, code == WRONG_STATE || code == NO_SUBINDEX_WRITE || code == READ_ONLY,
                   "download to %04Xh:%02X in SAFEOP, writable in PREOP only: expected abort 0x08000022, got 0x%08X",
                   in_preop_only.index, in_preop_only.sub, code);
    cf_note(c, "tried with %04Xh:%02X", in_preop_only.index, in_preop_only.sub);
}

/* --- events ------------------------------------------------------------------------------------------------------- */

static bool is_emergency(const cf_mail_t *mail)
{
    return mail->type == CF_MBX_COE && mail->length >= 2 && ect_load_le16(mail->data) >> 12 == CF_COE_EMERGENCY;
}

/* Stops the outputs, or sends an invalid request to a slave without outputs: most slaves then send an emergency. */
static void provoke(cf_t *c)
{
    if (c->facts.output_bytes > 0) {
        cf_go(c, CF_OP);
        cf_put16(c, ECT_REG_WD_TIME_PD, TICKS_10MS);
        (void)cf_cycle(c, NULL, NULL);
        (void)cf_wait_status(c, CF_SAFEOP | ECT_AL_ERROR, EMERGENCY_MS, false, NULL, NULL);
    } else {
        cf_go(c, CF_PREOP);
        (void)cf_request(c, CF_OP, NULL);
    }
}

static void emergencies(cf_t *c)
{
    cf_mail_t mail;
    unsigned int seen = 0;
    provoke(c);
    while (cf_receive_mail(c, &mail, EMERGENCY_MS)) {
        if (!is_emergency(&mail))
            continue;
        cf_expect_range(c, "length of an emergency", EMERGENCY_BYTES, EMERGENCY_BYTES, mail.length);
        uint16_t code = ect_load_le16(mail.data + 2);
        if (seen == 0)
            cf_expect_that(c, code != 0, "the first emergency: expected an error code, got 0x0000");
        seen++;
    }
    if (seen == 0)
        cf_skip(c, "the slave sent no emergency for errors that a master can cause");
    cf_step(c, "none below PREOP");
    cf_go(c, CF_INIT);
    cf_set_mailbox(c, CF_PREOP);
    cf_expect(c, "mailbox full flag of SM1 in INIT", 0, cf_mail_waits(c));
    cf_note(c, "%u emergencies", seen);
}

static void diagnosis(cf_t *c)
{
    uint32_t code;
    cf_go(c, CF_PREOP);
    if (!cf_object_exists(c, DIAGNOSIS, 1, &code))
        cf_skip(c, "the slave has no diagnosis history (10F3h)");
    uint8_t most = (uint8_t)cf_upload_number(c, DIAGNOSIS, 1), newest = (uint8_t)cf_upload_number(c, DIAGNOSIS, 2);
    (void)cf_upload_number(c, DIAGNOSIS, 5);
    cf_expect_that(c, newest == 0 || (newest >= 6 && newest <= 5 + most), "newest message: expected 0 or 6..%u, got %u",
                   5u + most, newest);
    if (newest == 0) {
        cf_note(c, "no message yet");
        return;
    }
    size_t size = sizeof value;
    code = cf_upload(c, DIAGNOSIS, newest, false, value, &size);
    cf_expect_that(c, code == 0 && size >= 16, "the newest message: expected at least 16 bytes, got %zu, abort 0x%08X",
                   size, code);
    cf_expect(c, "abort of its acknowledge", 0, cf_download(c, DIAGNOSIS, 3, false, &newest, 1));
    cf_expect(c, "new messages available, all acknowledged", 0, cf_upload_number(c, DIAGNOSIS, 4));
}

static void store(cf_t *c)
{
    const uint8_t wrong[4] = {'n', 'o', 'p', 'e'}, save[4] = {'s', 'a', 'v', 'e'};
    uint32_t code;
    cf_go(c, CF_PREOP);
    if (!cf_object_exists(c, STORE, 1, &code) && !cf_object_exists(c, RESTORE, 1, &code))
        cf_skip(c, "the slave has neither 1010h nor 1011h");
    for (unsigned int n = 0; n < 2; n++) {
        uint16_t index = (uint16_t)(n == 0 ? STORE : RESTORE);
        if (!cf_object_exists(c, index, 1, &code))
            continue;
        cf_expect_bits(c, "abilities of 1010h or 1011h", 1, 1, cf_upload_number(c, index, 1));
        expect_abort(c, "a wrong signature", cf_download(c, index, 1, false, wrong, sizeof wrong));
    }
    if (!c->destructive || !cf_object_exists(c, STORE, 1, &code)) {
        cf_note(c, "without storing: %s", c->destructive ? "there is no 1010h" : "only with --destructive");
        return;
    }
    cf_step(c, "storing the present values");
    cf_expect(c, "abort of a wrong signature", 0, cf_download(c, STORE, 1, false, save, sizeof save));
}

static void check_sync(cf_t *c, uint16_t index)
{
    uint32_t code;
    uint16_t supported = (uint16_t)cf_upload_number(c, index, 4), type = (uint16_t)cf_upload_number(c, index, 1);
    bool good = (type == 0 && (supported & 1) != 0) || (type != 0 && (supported & 0x1E) != 0);
    cf_expect_that(c, good, "%04Xh:01, the type: expected one of the bits 0x%04X in :04, got 0x%04X", index, supported,
                   type);
    (void)cf_upload_number(c, index, 5);
    expect_abort(c, "an unsupported synchronisation type", write16(c, index, 1, 0x0F));
    cf_expect(c, "the type after the refusal", type, cf_upload_number(c, index, 1));
    for (uint8_t sub = 0x0B; sub <= 0x0C; sub++) {
        if (!cf_object_exists(c, index, sub, &code))
            continue;
        cf_expect_range(c, "an error counter, which has 16 bits", 0, 0xFFFF, cf_upload_number(c, index, sub));
    }
}

static void synchronisation(cf_t *c)
{
    uint32_t code;
    bool any = false;
    cf_go(c, CF_PREOP);
    for (unsigned int n = 0; n < 2; n++) {
        uint16_t index = (uint16_t)(n == 0 ? SYNC_OUT : SYNC_IN);
        if (!cf_object_exists(c, index, 1, &code))
            continue;
        any = true;
        check_sync(c, index);
    }
    if (!any)
        cf_skip(c, "the slave has neither 1C32h nor 1C33h");
}

static void cycle(cf_t *c, void *ctx)
{
    unsigned long *cycles = ctx;
    cf_expect_wkc(c, "process data in OP", cf_cycle_wkc(c), cf_cycle(c, NULL, NULL));
    ++*cycles;
}

static void parallel(cf_t *c)
{
    unsigned long cycles = 0;
    uint64_t expected[5] = {0};
    cf_go(c, CF_PREOP);
    for (uint8_t sub = 1; sub <= 4; sub++)
        expected[sub] = cf_upload_number(c, 0x1018, sub);
    cf_go(c, CF_OP);
    cf_while_waiting(c, cycle, &cycles);
    for (unsigned int n = 0; n < PARALLEL; n++) {
        uint8_t sub = (uint8_t)(n % 4 + 1);
        cycle(c, &cycles);
        cf_expect(c, "an entry of 1018h during process data", expected[sub], cf_upload_number(c, 0x1018, sub));
    }
    cf_expect(c, "AL status afterwards", CF_OP, cf_get16(c, ECT_REG_AL_STATUS) & 0x1F);
}

static const cf_case_t cases[] = {
    {"CF-074", "PDOs are assigned by count 0, entries, count, in PREOP only; wrong assignments are refused", 'F',
     CF_COE, 0, remap},
    {"CF-075", "A PDO entry longer than its object is refused", 'F', CF_COE, 0, too_large},
    {"CF-076", "The information service lists and describes all objects", 'F', CF_COE | CF_SDO_INFO, 60000,
     information},
    {"CF-077", "The dictionary equals that of the ESI: objects, types, lengths, rights, names, defaults", 'S',
     CF_COE | CF_SDO_INFO | CF_ESI, 120000, as_in_file},
    {"CF-078", "A write to an entry that is writable in PREOP only is refused in SAFEOP", 'F', CF_COE | CF_SDO_INFO,
     60000, by_state},
    {"CF-079", "An emergency has a valid code and format; the slave sends none below PREOP", 'F',
     CF_COE | CF_APPLICATION, 0, emergencies},
    {"CF-080", "The diagnosis history reports the newest message and accepts the acknowledge", 'F', CF_COE, 0,
     diagnosis},
    {"CF-081", "Store and restore accept only their signature", 'F', CF_COE, 0, store},
    {"CF-082", "Supported synchronisation types are accepted, others refused", 'F', CF_COE, 0, synchronisation},
    {"CF-083", "In 500 SDO transfers during process data no reply is lost or confused", 'F', CF_COE | CF_APPLICATION,
     60000, parallel},
};

CF_SECTION(cf_coe_more, 'G', "CoE: mapping, information, events", cases);
