/* SPDX-License-Identifier: MIT */
/* A sensor of an ESI file of tests/esi on a wire: its inputs by offset, its objects, its signals. Cycles of 1 ms. */
#ifndef TESTS_UNIT_ESI_SENSOR_OF_FILE_H
#define TESTS_UNIT_ESI_SENSOR_OF_FILE_H

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bus/chain/signals.h"
#include "esi/twin.h"
#include "support/wire.h"

#define COUNT(array) (sizeof(array) / sizeof((array)[0]))

static wire_t wire;
static ect_esi_twin_t *twin;

static inline ect_esi_twin_t *make(const char *file, const char *type, ect_behaviour_t behaviour)
{
    char path[300];
    char text[300] = "";
    (void)snprintf(path, sizeof path, "%s/%s", ESI_FILES, file);
    ect_esi_twin_t *made = ect_esi_twin_make(path, type, NULL, 0, text, sizeof text);
    if (made == NULL || !ect_esi_twin_behave(made, behaviour, text, sizeof text))
        fail_msg("%s: expected a twin, got: %s", type, text);
    return made;
}

static inline void open_behaviour(const char *file, const char *type, ect_behaviour_t behaviour)
{
    twin = make(file, type, behaviour);
    const ect_product_t *product = ect_esi_twin_product(twin);
    ect_twin_config_t config = ect_twin_default(product->device, product->plant);
    memset(&wire, 0, sizeof wire);
    wire_open_twins(&wire, &config, 1);
    wire_go(&wire, 0, ECT_STATE_PREOP);
}

/* In PREOP. */
static inline void open_sensor(const char *file, const char *type)
{
    open_behaviour(file, type, ECT_BEHAVIOUR_BY_FILE);
}

/* In PREOP, without behaviour. */
static inline void open_shell(const char *file, const char *type)
{
    open_behaviour(file, type, ECT_BEHAVIOUR_NONE);
}

static inline int close_sensor(void **state)
{
    (void)state;
    if (twin != NULL && wire.chain != NULL)
        wire_close(&wire);
    ect_esi_twin_free(twin);
    twin = NULL;
    memset(&wire, 0, sizeof wire);
    return 0;
}

/* The note that begins with a text. */
static inline const char *note(const char *begin)
{
    size_t count;
    const char *const *notes = ect_esi_twin_notes(twin, &count);
    for (size_t i = 0; i < count; i++) {
        if (strncmp(notes[i], begin, strlen(begin)) == 0)
            return notes[i];
    }
    return "";
}

static inline uint32_t write_sdo(uint16_t index, uint8_t subindex, int64_t value, size_t size)
{
    uint8_t bytes[8];
    ect_store_le64(bytes, (uint64_t)value);
    return wire_sdo_download(&wire, 0, index, subindex, false, bytes, size);
}

static inline int64_t read_sdo(uint16_t index, uint8_t subindex)
{
    uint8_t bytes[8] = {0};
    size_t size = sizeof bytes;
    uint32_t abort = wire_sdo_upload(&wire, 0, index, subindex, false, bytes, &size);
    if (abort != 0)
        fail_msg("%04X:%u: abort %08X", (unsigned int)index, (unsigned int)subindex, (unsigned int)abort);
    return size == 4 ? (int32_t)ect_load_le32(bytes) : (int64_t)ect_load_le64(bytes);
}

/* @return whether the signal exists and accepts the value */
static inline bool try_set(const char *name, const char *value)
{
    ect_signal_ref_t ref;
    char message[ECT_SIGNAL_MESSAGE];
    if (!ect_chain_signal(wire.chain, 0, name, &ref))
        fail_msg("there is no signal %s", name);
    bool done = ect_signal_write(&ref, value, wire.now_ns, message);
    ect_chain_wake(wire.chain, 0);
    return done;
}

static inline void set(const char *name, const char *value)
{
    if (!try_set(name, value))
        fail_msg("%s does not accept %s", name, value);
}

static inline double signal_of(const char *name)
{
    ect_signal_ref_t ref;
    char text[ECT_SIGNAL_TEXT_ROOM];
    if (!ect_chain_signal(wire.chain, 0, name, &ref))
        fail_msg("there is no signal %s", name);
    ect_signal_read(&ref, text);
    return strtod(text, NULL);
}

/* The inputs after a number of milliseconds. */
static inline void inputs_after(unsigned int ms, uint8_t *in, uint16_t size)
{
    wire_advance(&wire, ms * MS);
    assert_int_equal(wire_read(&wire, 0, ect_esi_twin_product(twin)->device->sm[3].start, in, size), 1);
}

#endif
