/* SPDX-License-Identifier: MIT */
/*
 * A description that passes is safe to run (check/check.h): each number of a description is replaced by the bounds of
 * its type, one at a time. A refusal is one line; an accepted description has an SII, reaches SAFEOP or has an AL
 * status code, gives the changed object by SDO, and accepts outputs.
 */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "check/check.h"
#include "sii/sii.h"
#include "support/confdev.h"
#include "support/copy.h"
#include "support/gauge.h"
#include "support/terminal.h"
#include "support/testdev.h"
#include "support/wire.h"

static const ect_device_t *const devices[] = {&testdev, &confdev, &gauge, &terminal};
enum { DEVICES = sizeof devices / sizeof devices[0] };

typedef struct tally {
    unsigned int refused, accepted;
} tally_t;

/* A number of a table, by its place there. */
typedef struct member {
    const char *name;
    size_t offset, size;
} member_t;

#define MEMBER(type, m) {#m, offsetof(type, m), sizeof(((type *)0)->m)}

/* The functions of a device rely on an instance of its own type. */
static void without_behaviour(ect_device_t *d)
{
    memset((uint8_t *)d + offsetof(ect_device_t, init), 0, sizeof *d - offsetof(ect_device_t, init));
}

/* --- what is accepted --------------------------------------------------------------------------------------------- */

static void expect_sii(const char *what, const ect_device_t *d)
{
    uint8_t *image = malloc(d->sii_size);
    assert_non_null(image);
    if (ect_sii_write(d, NULL, 0, image, d->sii_size) != d->sii_size)
        fail_msg("%s: expected an SII of %u bytes", what, d->sii_size);
    free(image);
}

/* Each entry of an object is read, or refused with an abort code of the dictionary. */
static void expect_replies(const char *what, wire_t *w, const ect_object_t *object)
{
    static uint8_t value[70000];
    for (const ect_entry_t *e = object->entries; e != NULL; e = ect_od_next(object, e)) {
        size_t size = sizeof value;
        uint32_t code = wire_sdo_upload(w, 0, object->index, (uint8_t)e->subindex, false, value, &size);
        if (code != 0 && code >> 24 != 0x06 && code >> 24 != 0x08)
            fail_msg("%s: %04X:%u: expected data or an abort code, got %08X", what, object->index, e->subindex,
                     (unsigned int)code);
        if (code == 0 && size > 0xFFFF)
            fail_msg("%s: %04X:%u: expected at most 65535 bytes, got %zu", what, object->index, e->subindex, size);
    }
}

/* An AL status code stands for a state that is not reached. */
static void expect_state(const char *what, wire_t *w, uint8_t state)
{
    uint16_t code = 0;
    uint8_t status = wire_al(w, 0, state, &code);
    if (status != state && ((status & 0x10) == 0 || code == 0))
        fail_msg("%s: expected state %u or a code, got %02X with code %04X", what, state, status, code);
}

static void expect_sound(const char *what, const ect_device_t *d, const ect_object_t *object)
{
    wire_t w = {0};
    expect_sii(what, d);
    wire_open_one(&w, d);
    wire_configure_mailbox(&w, 0);
    expect_state(what, &w, ECT_STATE_PREOP);
    if (object != NULL && (d->mailbox_protocols & ECT_MAILBOX_COE) != 0)
        expect_replies(what, &w, object);
    wire_configure_process_data(&w, 0);
    expect_state(what, &w, ECT_STATE_SAFEOP);
    (void)wire_al(&w, 0, ECT_STATE_OP, NULL); /* delayed until there are outputs */
    (void)wire_outputs(&w, 0, 0x55);
    wire_advance(&w, 500 * MS);
    wire_close(&w);
}

static void judge(const char *what, copy_t *c, const ect_object_t *object, tally_t *tally)
{
    char text[ECT_CHECK_TEXT];
    memset(text, '#', sizeof text);
    without_behaviour(&c->device);
    bool good = ect_device_check(&c->device, text, sizeof text);
    if (memchr(text, '\0', sizeof text) == NULL || (*text == '\0') != good || strpbrk(text, "\r\n") != NULL)
        fail_msg("%s: expected %s, got \"%.200s\"", what, good ? "nothing" : "a line", text);
    tally->accepted += good;
    tally->refused += !good;
    if (good)
        expect_sound(what, &c->device, object);
}

/* --- what is changed ---------------------------------------------------------------------------------------------- */

static const uint64_t values[] = {0,       1,          2,          7,          8,       16,     32,
                                  0x7F,    0x80,       0xFF,       0x100,      0x1600,  0x7FFF, 0xFFFF,
                                  0x10000, 0x7FFFFFFF, 0x80000000, UINT32_MAX, SIZE_MAX};
enum { VALUES = sizeof values / sizeof values[0] };

/* @return false: the member has that value already, or cannot have it */
static bool put(void *table, const member_t *m, uint64_t value)
{
    uint64_t before = 0;
    memcpy(&before, (uint8_t *)table + m->offset, m->size);
    if (before == value || (m->size < sizeof value && value >> 8 * m->size != 0))
        return false;
    memcpy((uint8_t *)table + m->offset, &value, m->size);
    return true;
}

static void numbers_of_entries(void **state)
{
    static const member_t members[] = {MEMBER(ect_entry_t, subindex), MEMBER(ect_entry_t, data_type),
                                       MEMBER(ect_entry_t, bit_length), MEMBER(ect_entry_t, access),
                                       MEMBER(ect_entry_t, value)};
    tally_t tally = {0};
    (void)state;
    for (size_t i = 0; i < DEVICES; i++) {
        for (uint16_t o = 0; o < devices[i]->object_count; o++) {
            const size_t at = devices[i]->objects[o].last; /* the last entry of each object */
            for (size_t k = 0; k < VALUES * sizeof members / sizeof members[0]; k++) {
                const member_t *m = &members[k / VALUES];
                char what[100];
                copy_t *c = copy_device(devices[i]);
                ect_entry_t *e = &c->entries[o][at];
                (void)snprintf(what, sizeof what, "%s %04X:%u.%s=%" PRIX64, devices[i]->name, c->objects[o].index,
                               e->subindex, m->name, values[k % VALUES]);
                bool shared = (e->access & ECT_ACCESS_SHARED) != 0; /* its data are a pointer */
                if (put(e, m, values[k % VALUES]) &&
                    (e->access & ECT_ACCESS_SHARED) == (shared ? ECT_ACCESS_SHARED : 0))
                    judge(what, c, &c->objects[o], &tally);
                copy_free(c);
            }
        }
    }
    assert_true(tally.refused > 1000);
    assert_true(tally.accepted > 300);
}

/* A shared entry has a pointer, all others an offset. */
static void places_of_entries(void **state)
{
    static const member_t data = MEMBER(ect_entry_t, data);
    tally_t tally = {0};
    (void)state;
    for (size_t i = 0; i < DEVICES; i++) {
        for (uint16_t o = 0; o < devices[i]->object_count; o++) {
            const size_t at = devices[i]->objects[o].last;
            const uint64_t whole = devices[i]->instance_size;
            const uint64_t places[] = {0,
                                       1,
                                       sizeof(ect_standard_t) - 1,
                                       sizeof(ect_standard_t),
                                       whole - 8,
                                       whole - 4,
                                       whole - 1,
                                       whole,
                                       whole + 1,
                                       SIZE_MAX};
            for (size_t k = 0; k < sizeof places / sizeof places[0]; k++) {
                char what[100];
                copy_t *c = copy_device(devices[i]);
                ect_entry_t *e = &c->entries[o][at];
                (void)snprintf(what, sizeof what, "%s %04X:%u at %" PRIX64, devices[i]->name, c->objects[o].index,
                               e->subindex, places[k]);
                if ((e->access & ECT_ACCESS_SHARED) == 0 && put(e, &data, places[k]))
                    judge(what, c, &c->objects[o], &tally);
                copy_free(c);
            }
        }
    }
    assert_true(tally.refused > 300);
    assert_true(tally.accepted > 50);
}

static void numbers_of_objects(void **state)
{
    static const member_t members[] = {MEMBER(ect_object_t, index), MEMBER(ect_object_t, object_code),
                                       MEMBER(ect_object_t, max_subindex)};
    tally_t tally = {0};
    (void)state;
    for (size_t i = 0; i < DEVICES; i++) {
        for (uint16_t o = 0; o < devices[i]->object_count; o++) {
            for (size_t k = 0; k < VALUES * sizeof members / sizeof members[0]; k++) {
                const member_t *m = &members[k / VALUES];
                char what[100];
                copy_t *c = copy_device(devices[i]);
                (void)snprintf(what, sizeof what, "%s %04X.%s=%" PRIX64, devices[i]->name, c->objects[o].index, m->name,
                               values[k % VALUES]);
                if (put(&c->objects[o], m, values[k % VALUES]))
                    judge(what, c, &c->objects[o], &tally);
                copy_free(c);
            }
        }
    }
    assert_true(tally.refused > 1000);
    assert_true(tally.accepted > 10);
}

static void numbers_of_sync_managers(void **state)
{
    static const member_t members[] = {MEMBER(ect_sm_t, start),   MEMBER(ect_sm_t, length),  MEMBER(ect_sm_t, minimum),
                                       MEMBER(ect_sm_t, maximum), MEMBER(ect_sm_t, control), MEMBER(ect_sm_t, type)};
    static const uint64_t more[] = {33,     34,     64,     128,    1486, 1487, 0x1000,
                                    0x1100, 0x2F00, 0x2FFF, 0x3000, 0x20, 0x24, 0x26};
    enum { ALL = VALUES + sizeof more / sizeof more[0] };
    tally_t tally = {0};
    (void)state;
    for (size_t i = 0; i < DEVICES; i++) {
        for (unsigned int sm = 0; sm < devices[i]->sm_count; sm++) {
            for (size_t k = 0; k < ALL * sizeof members / sizeof members[0]; k++) {
                const member_t *m = &members[k / ALL];
                const uint64_t value = k % ALL < VALUES ? values[k % ALL] : more[k % ALL - VALUES];
                char what[100];
                copy_t *c = copy_device(devices[i]);
                (void)snprintf(what, sizeof what, "%s SM%u.%s=%" PRIX64, devices[i]->name, sm, m->name, value);
                if (put(&c->device.sm[sm], m, value))
                    judge(what, c, NULL, &tally);
                copy_free(c);
            }
        }
    }
    assert_true(tally.refused > 500);
    assert_true(tally.accepted > 100);
}

/* Counts only become smaller: the length of an array is not visible. */
static void numbers_of_devices(void **state)
{
    static const member_t members[] = {MEMBER(ect_device_t, sii_size),
                                       MEMBER(ect_device_t, boot_out.start),
                                       MEMBER(ect_device_t, boot_out.length),
                                       MEMBER(ect_device_t, boot_in.start),
                                       MEMBER(ect_device_t, boot_in.length),
                                       MEMBER(ect_device_t, mailbox_protocols),
                                       MEMBER(ect_device_t, coe_details),
                                       MEMBER(ect_device_t, general_flags),
                                       MEMBER(ect_device_t, id_address),
                                       MEMBER(ect_device_t, soe_channels),
                                       MEMBER(ect_device_t, ebus_ma),
                                       MEMBER(ect_device_t, sync.supported),
                                       MEMBER(ect_device_t, sync.minimum_cycle_ns),
                                       MEMBER(ect_device_t, timeouts.preop_ms),
                                       MEMBER(ect_device_t, timeouts.safeop_op_ms),
                                       MEMBER(ect_device_t, timeouts.back_to_init_ms),
                                       MEMBER(ect_device_t, identity.vendor_id),
                                       MEMBER(ect_device_t, identity.serial),
                                       MEMBER(ect_device_t, device_type),
                                       MEMBER(ect_device_t, instance_size)};
    tally_t tally = {0};
    (void)state;
    for (size_t i = 0; i < DEVICES; i++) {
        for (size_t k = 0; k < VALUES * sizeof members / sizeof members[0]; k++) {
            const member_t *m = &members[k / VALUES];
            const uint64_t value = values[k % VALUES];
            char what[100];
            copy_t *c = copy_device(devices[i]);
            (void)snprintf(what, sizeof what, "%s.%s=%" PRIX64, devices[i]->name, m->name, value);
            bool too_large = m->offset == offsetof(ect_device_t, instance_size) && value > 0x10000;
            if (put(&c->device, m, value) && !too_large)
                judge(what, c, NULL, &tally);
            copy_free(c);
        }
        for (uint16_t count = 0; count < devices[i]->object_count; count++) {
            char what[100];
            copy_t *c = copy_device(devices[i]);
            const uint16_t objects = c->device.object_count;
            (void)snprintf(what, sizeof what, "%s with %u objects", devices[i]->name, count);
            c->device.object_count = count;
            judge(what, c, NULL, &tally);
            c->device.object_count = objects;
            copy_free(c);
        }
    }
    assert_true(tally.refused > 100);
    assert_true(tally.accepted > 300);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"CF-068 CF-077 each number of an entry at its bounds: refused with a line, or safe to run", numbers_of_entries,
         NULL, NULL, NULL},
        {"each place of an entry's data: refused with a line, or safe to run", places_of_entries, NULL, NULL, NULL},
        {"CF-067 CF-077 each number of an object at its bounds: refused with a line, or safe to run",
         numbers_of_objects, NULL, NULL, NULL},
        {"CF-060 each number of a SyncManager at its bounds: refused with a line, or safe to run",
         numbers_of_sync_managers, NULL, NULL, NULL},
        {"CF-057 CF-058 each number of a device at its bounds: refused with a line, or safe to run", numbers_of_devices,
         NULL, NULL, NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
