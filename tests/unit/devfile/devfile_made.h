/* SPDX-License-Identifier: MIT */
/* The twin of a device file, or the line that refuses the file. */
#ifndef ECT_TEST_DEVFILE_MADE_H
#define ECT_TEST_DEVFILE_MADE_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "devfile/devfile.h"
#include "esi/twin.h"

typedef struct made {
    ect_esi_t *esi;
    const ect_esi_device_t *model;
    ect_esi_twin_t *twin; /* NULL: refused, `why` has the line */
    char why[500];
} made_t;

/* Makes the twin of a file's first device. */
static inline made_t made_of(const char *path, const char *text)
{
    made_t m = {.why = ""};
    m.esi = ect_devfile_parse(path, text, strlen(text), m.why, sizeof m.why);
    m.model = m.esi != NULL ? ect_esi_select(m.esi, "", m.why, sizeof m.why) : NULL;
    m.twin = m.model != NULL ? ect_esi_twin_of(m.esi, m.model, NULL, 0, m.why, sizeof m.why) : NULL;
    return m;
}

/* Expects a twin without a note. @return m */
static inline made_t whole(const char *what, made_t m)
{
    size_t count = 0;
    if (m.twin == NULL)
        fail_msg("%s: %s", what, m.why);
    const char *const *notes = ect_esi_twin_notes(m.twin, &count);
    if (count > 0)
        fail_msg("%s: %s", what, notes[0]);
    return m;
}

static inline void drop(made_t *m)
{
    ect_esi_twin_free(m->twin);
    ect_esi_close(m->esi);
}

static inline const ect_device_t *device_of(const made_t *m)
{
    return ect_esi_twin_product(m->twin)->device;
}

static inline const ect_object_t *object_of(const made_t *m, uint16_t index)
{
    ect_od_t od = ect_device_od(device_of(m), NULL);
    const ect_object_t *object = ect_od_find(&od, index);
    if (object == NULL)
        fail_msg("no object %04X", (unsigned int)index);
    return object;
}

/* @return NULL: the device has no such entry, or no such object */
static inline const ect_entry_t *entry_of(const made_t *m, uint16_t index, uint8_t subindex)
{
    ect_od_t od = ect_device_od(device_of(m), NULL);
    const ect_object_t *object = ect_od_find(&od, index);
    return object != NULL ? ect_od_entry(object, subindex) : NULL;
}

#endif
