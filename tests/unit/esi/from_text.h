/* SPDX-License-Identifier: MIT */
/* ESI files as tests write them: a device between the lines that every file has, and the resulting twin. */
#ifndef TESTS_UNIT_ESI_FROM_TEXT_H
#define TESTS_UNIT_ESI_FROM_TEXT_H

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "esi/twin.h"

#define ESI_HEAD                                                                                                       \
    "<EtherCATInfo><Vendor><Id>#xE57</Id><Name>Works</Name></Vendor><Descriptions><Groups><Group><Type>G</Type>"       \
    "<Name>Group</Name></Group></Groups><Devices>"
#define ESI_TAIL "</Devices></Descriptions></EtherCATInfo>"
/* `body` goes behind the name; the device is on line 2. */
#define ESI_DEVICE(body)                                                                                               \
    ESI_HEAD "\n<Device Physics='YY'><Type ProductCode='#x1' RevisionNo='#x2'>DEV</Type><Name>A device</Name>" body    \
             "</Device>" ESI_TAIL
#define ESI_MAILBOX_SMS                                                                                                \
    "<Sm DefaultSize='128' StartAddress='#x1000' ControlByte='#x26' Enable='1'>MBoxOut</Sm>"                           \
    "<Sm DefaultSize='128' StartAddress='#x1080' ControlByte='#x22' Enable='1'>MBoxIn</Sm>"
#define ESI_PROCESS_SMS                                                                                                \
    "<Sm StartAddress='#x1100' ControlByte='#x24' Enable='1'>Outputs</Sm>"                                             \
    "<Sm StartAddress='#x1400' ControlByte='#x20' Enable='1'>Inputs</Sm>"
#define ESI_EEPROM "<Eeprom><ByteSize>2048</ByteSize><ConfigData>0504</ConfigData></Eeprom>"

/* A file that was opened, the device that was selected, its twin. */
typedef struct made {
    ect_esi_t *esi;
    const ect_esi_device_t *model;
    ect_esi_twin_t *twin;
    char why[400];
} made_t;

static inline made_t try_text(const char *text)
{
    made_t m = {.why = ""};
    m.esi = ect_esi_parse("t.xml", text, strlen(text), m.why, sizeof m.why);
    m.model = m.esi != NULL ? ect_esi_select(m.esi, "", m.why, sizeof m.why) : NULL;
    m.twin = m.model != NULL ? ect_esi_twin_of(m.esi, m.model, NULL, 0, m.why, sizeof m.why) : NULL;
    return m;
}

static inline made_t make_text(const char *what, const char *text)
{
    made_t m = try_text(text);
    if (m.twin == NULL)
        fail_msg("%s: expected a twin, got: %s", what, m.why);
    return m;
}

static inline void free_made(made_t *m)
{
    ect_esi_twin_free(m->twin);
    ect_esi_close(m->esi);
}

static inline const ect_device_t *device_of(const made_t *m)
{
    return ect_esi_twin_product(m->twin)->device;
}

static inline ect_od_t od_of(const made_t *m)
{
    return ect_device_od(device_of(m), NULL);
}

/* The first note that begins with `begin`, NULL: there is none. */
static inline const char *note_of(const made_t *m, const char *begin)
{
    size_t count;
    const char *const *lines = ect_esi_twin_notes(m->twin, &count);
    for (size_t i = 0; i < count; i++) {
        if (strncmp(lines[i], begin, strlen(begin)) == 0)
            return lines[i];
    }
    return NULL;
}

/* `expected` NULL: no note at all; else the only one. */
static inline void expect_note(const char *what, const made_t *m, const char *expected)
{
    size_t count;
    const char *const *lines = ect_esi_twin_notes(m->twin, &count);
    const char *first = count > 0 ? lines[0] : "none";
    if (count != (expected != NULL) || (expected != NULL && strcmp(first, expected) != 0))
        fail_msg("%s: expected the note \"%s\", got %zu, the first \"%s\"", what,
                 expected != NULL ? expected : "(none)", count, first);
}

#endif
