/* SPDX-License-Identifier: MIT */
/* All objects of a slave, in ascending order. */
#include <string.h>

#include "reader/internal.h"
#include "wire/bytes.h"

enum { COE = 0x04, READ_PREOP = 0x01, DEVICE_TYPE = 0x1000, DEVICE_NAME = 0x1008, IDENTITY = 0x1018 };
enum {
    MAPPINGS = 0x1600,
    MAPPINGS_END = 0x1C00,
    ASSIGNMENTS = 0x1C10, /* of SyncManager 0 */
    ASSIGNMENTS_END = 0x1C30,
    OUTPUTS = 0x1C12,
    INPUTS = 0x1C13
};

typedef struct walk {
    ect_reader_t *r;
    ect_reader_values_t values;
    const ect_reader_sink_t *sink;
    ect_reader_result_t first; /* the first failure */
    uint32_t code;
    char text[ECT_READER_TEXT];
    unsigned int unanswered; /* successive uploads */
    unsigned int done, all;
} walk_t;

static bool is_of_identity_or_pdos(unsigned int index)
{
    return index == DEVICE_TYPE || index == DEVICE_NAME || index == IDENTITY ||
           (index >= MAPPINGS && index < MAPPINGS_END) || (index >= ASSIGNMENTS && index < ASSIGNMENTS_END);
}

/* Keeps the first failure, because later ones are its consequences. @return whether the walk continues */
static bool goes_on(walk_t *w, ect_reader_result_t result)
{
    if (result == ECT_READER_OK || result == ECT_READER_ABORTED || result == ECT_READER_REFUSED)
        return true;
    if (w->first == ECT_READER_OK) {
        w->first = result;
        w->code = w->r->code;
        memcpy(w->text, w->r->text, sizeof w->text);
    }
    return result != ECT_READER_LOST && result != ECT_READER_STOPPED && w->r->failures < FAILURES;
}

static void report_gap(const walk_t *w, ect_reader_gap_t gap)
{
    if (w->sink->gap != NULL)
        w->sink->gap(w->sink->ctx, &gap);
}

/* Continues without values after several successive uploads without a reply, because each costs seconds. */
static bool upload(walk_t *w, unsigned int index, unsigned int subindex, ect_reader_bytes_t *value)
{
    ect_reader_t *r = w->r;
    size_t size = sizeof r->value;
    ect_reader_gap_t gap = {
        .index = (uint16_t)index, .subindex = (uint8_t)subindex, .value = true, .result = ECT_READER_SILENT};
    *value = (ect_reader_bytes_t){0};
    if (w->unanswered >= FAILURES) {
        report_gap(w, gap);
        return true;
    }
    const ect_reader_result_t result = ect_reader_upload(r, (uint16_t)index, (uint8_t)subindex, false, r->value, &size);
    const bool failed = result == ECT_READER_SILENT || result == ECT_READER_WRONG;
    w->unanswered = failed ? w->unanswered + 1 : 0;
    if (result == ECT_READER_OK)
        *value = (ect_reader_bytes_t){.data = r->value, .length = size};
    gap.result = result;
    gap.code = r->code;
    if (result != ECT_READER_OK)
        report_gap(w, gap);
    return goes_on(w, result) || failed;
}

/* --- with SDO information ----------------------------------------------------------------------------------------- */

static bool walk_entry(walk_t *w, const ect_reader_object_t *object, unsigned int subindex)
{
    ect_reader_entry_t entry;
    const ect_reader_result_t result = ect_reader_entry(w->r, object->index, (uint8_t)subindex, &entry);
    if (result != ECT_READER_OK) {
        report_gap(w, (ect_reader_gap_t){
                          .index = object->index, .subindex = (uint8_t)subindex, .result = result, .code = w->r->code});
        return goes_on(w, result);
    }
    if (entry.type == 0 && entry.bits == 0)
        return true; /* a gap */
    const bool wanted =
        w->values == ECT_READER_ALL_VALUES ? (entry.access & READ_PREOP) != 0 : is_of_identity_or_pdos(object->index);
    const bool more = !wanted || upload(w, object->index, subindex, &entry.value);
    w->sink->entry(w->sink->ctx, object, &entry);
    return more;
}

static bool walk_object(walk_t *w, unsigned int index)
{
    uint8_t name[256];
    ect_reader_object_t object;
    const ect_reader_result_t result = ect_reader_object(w->r, (uint16_t)index, &object);
    if (result != ECT_READER_OK) {
        report_gap(w,
                   (ect_reader_gap_t){.index = (uint16_t)index, .whole = true, .result = result, .code = w->r->code});
        return goes_on(w, result);
    }
    object.name.length = object.name.length < sizeof name ? object.name.length : sizeof name;
    if (object.name.data != NULL) {
        memcpy(name, object.name.data, object.name.length); /* the entries overwrite it in the reader */
        object.name.data = name;
    }
    w->sink->object(w->sink->ctx, &object);
    for (unsigned int subindex = 0; subindex <= object.most; subindex++) {
        if (!walk_entry(w, &object, subindex))
            return false;
    }
    return true;
}

static void walk_described(walk_t *w)
{
    for (unsigned int index = 0; index < 0x10000; index++) {
        if (!reader_is_listed(w->r, index))
            continue;
        if (!reader_progress(w->r, "objects", w->done++, w->all)) {
            (void)goes_on(w, w->r->result);
            return;
        }
        if (!walk_object(w, index))
            return;
    }
}

/* --- without ------------------------------------------------------------------------------------------------------ */

static unsigned int number_of(ect_reader_bytes_t value)
{
    uint8_t bytes[4] = {0};
    memcpy(bytes, value.data, value.length < sizeof bytes ? value.length : sizeof bytes);
    return ect_load_le32(bytes);
}

/* Reports each object once, because several assignments may name the same mapping. */
static bool walk_values(walk_t *w, unsigned int index)
{
    ect_reader_object_t object = {.index = (uint16_t)index};
    ect_reader_entry_t entry = {0};
    if (reader_is_listed(w->r, index))
        return true;
    w->r->objects[index / 8] |= (uint8_t)(1u << index % 8);
    if (!reader_progress(w->r, "objects", w->done++, w->all))
        return goes_on(w, w->r->result);
    if (!upload(w, index, 0, &entry.value))
        return false;
    if (entry.value.data == NULL)
        return true;
    const unsigned int most = index == DEVICE_TYPE || index == DEVICE_NAME ? 0 : number_of(entry.value) & 0xFF;
    w->sink->object(w->sink->ctx, &object);
    w->sink->entry(w->sink->ctx, &object, &entry);
    for (unsigned int subindex = 1; subindex <= most; subindex++) {
        entry = (ect_reader_entry_t){.subindex = (uint8_t)subindex};
        if (!upload(w, index, subindex, &entry.value))
            return false;
        w->sink->entry(w->sink->ctx, &object, &entry);
    }
    return true;
}

/* Reports an assignment, then the mappings that it names. */
static bool walk_assignment(walk_t *w, unsigned int assignment)
{
    ect_reader_bytes_t value;
    if (!upload(w, assignment, 0, &value))
        return false;
    if (value.data == NULL)
        return true;
    const unsigned int count = number_of(value) & 0xFF;
    if (!walk_values(w, assignment))
        return false;
    for (unsigned int n = 1; n <= count; n++) {
        if (!upload(w, assignment, n, &value))
            return false;
        if (value.data != NULL && value.length >= 2 && !walk_values(w, number_of(value) & 0xFFFF))
            return false;
    }
    return true;
}

static void walk_undescribed(walk_t *w)
{
    memset(w->r->objects, 0, sizeof w->r->objects);
    if (walk_values(w, DEVICE_TYPE) && walk_values(w, DEVICE_NAME) && walk_values(w, IDENTITY) &&
        walk_assignment(w, OUTPUTS))
        (void)walk_assignment(w, INPUTS);
}

/* ------------------------------------------------------------------------------------------------------------------ */

static void walk(walk_t *w)
{
    size_t count = 0;
    const bool coe = (w->r->protocols & COE) != 0;
    const ect_reader_result_t result = coe ? ect_reader_list(w->r, &count) : ECT_READER_OK;
    const bool good = result == ECT_READER_OK || ((result == ECT_READER_ABORTED || result == ECT_READER_REFUSED) &&
                                                  ect_reader_preop(w->r) == ECT_READER_OK);
    w->all = (unsigned int)count;
    if (w->sink->begin != NULL)
        w->sink->begin(w->sink->ctx, count > 0);
    if (!good) {
        w->first = result;
        w->code = w->r->code;
        memcpy(w->text, w->r->text, sizeof w->text);
    } else if (count > 0) {
        walk_described(w);
    } else if (coe) {
        walk_undescribed(w);
    }
}

static ect_reader_result_t result_of(walk_t *w)
{
    if (w->first == ECT_READER_OK)
        return reader_good(w->r);
    w->r->code = w->code;
    return reader_report(w->r, w->first, "%s", w->text);
}

ect_reader_result_t ect_reader_dictionary(ect_reader_t *r, ect_reader_values_t values, const ect_reader_sink_t *sink)
{
    walk_t w = {.r = r, .values = values, .sink = sink};
    r->failures = 0;
    walk(&w);
    return result_of(&w);
}

ect_reader_result_t ect_reader_assigned(ect_reader_t *r, uint32_t sms, const ect_reader_sink_t *sink)
{
    walk_t w = {.r = r, .sink = sink};
    bool more = true;
    r->failures = 0;
    memset(r->objects, 0, sizeof r->objects);
    if (sink->begin != NULL)
        sink->begin(sink->ctx, false);
    for (unsigned int sm = 0; more && sm < ASSIGNMENTS_END - ASSIGNMENTS; sm++)
        more = (sms >> sm & 1) == 0 || walk_assignment(&w, ASSIGNMENTS + sm);
    return result_of(&w);
}
