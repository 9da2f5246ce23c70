/* SPDX-License-Identifier: MIT */
/* A drive of tests/esi/drives.xml on a wire: its process data by object, its state machine. Cycles of 1 ms. */
#ifndef TESTS_UNIT_ESI_DRIVE_OF_FILE_H
#define TESTS_UNIT_ESI_DRIVE_OF_FILE_H

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bus/chain/signals.h"
#include "esi/twin.h"
#include "support/wire.h"

#define TWO_PI       6.283185307179586
#define COUNT(array) (sizeof(array) / sizeof((array)[0]))
enum { PREOP = ECT_STATE_PREOP, SAFEOP = ECT_STATE_SAFEOP, OP = ECT_STATE_OP };
enum { CONTROL = 0x6040, STATUS = 0x6041, MODE = 0x6060, SHOWN = 0x6061, ACTUAL = 0x6064, TARGET = 0x607A };
enum { SHUTDOWN = 0x06, SWITCH_ON = 0x07, ENABLE = 0x0F, RESET = 0x80, START = 0x1F };
enum { SOD = 0x40, READY = 0x21, SWITCHED_ON = 0x23, ENABLED = 0x27, STOPPING = 0x07, REACTING = 0x0F, FAULT = 0x08 };
enum { PP = 1, PV = 3, TQ = 4, HM = 6, IP = 7, CSP = 8, CSV = 9, CST = 10 };
enum { SEARCH = 20000, ZERO = 5000 }; /* speeds of 6099h */

static wire_t wire;
static ect_esi_twin_t *twin;
static uint8_t out[64], in[64];
static const uint32_t
    *remapped[2]; /* entries of 1600h and 1A00h, up to a 0, that a test has written; NULL: the file's */

/* --- the twin, its process data ----------------------------------------------------------------------------------- */

static inline ect_esi_twin_t *make(const char *type, ect_behaviour_t behaviour)
{
    char path[300];
    char text[300] = "";
    (void)snprintf(path, sizeof path, "%s/drives.xml", ESI_FILES);
    ect_esi_twin_t *made = ect_esi_twin_make(path, type, NULL, 0, text, sizeof text);
    if (made == NULL || !ect_esi_twin_behave(made, behaviour, text, sizeof text))
        fail_msg("%s: expected a twin, got: %s", type, text);
    return made;
}

static inline const ect_device_t *device(void)
{
    return ect_esi_twin_product(twin)->device;
}

/* In PREOP. */
static inline void open_twin(void)
{
    ect_twin_config_t config = ect_twin_default(device(), ect_esi_twin_product(twin)->plant);
    memset(&wire, 0, sizeof wire);
    memset(out, 0, sizeof out);
    wire_open_twins(&wire, &config, 1);
    wire_go(&wire, 0, PREOP);
}

static inline void open_drive(const char *type)
{
    twin = make(type, ECT_BEHAVIOUR_BY_FILE);
    open_twin();
}

static inline int close_drive(void **state)
{
    (void)state;
    if (twin != NULL)
        wire_close(&wire);
    ect_esi_twin_free(twin);
    twin = NULL;
    remapped[0] = remapped[1] = NULL;
    return 0;
}

static inline uint32_t value_of(uint16_t index, uint8_t subindex)
{
    const uint32_t *entries = index == 0x1600 ? remapped[0] : index == 0x1A00 ? remapped[1] : NULL;
    uint32_t count = 0;
    if (entries != NULL) {
        while (entries[count] != 0)
            count++;
        return subindex == 0 ? count : entries[subindex - 1];
    }
    ect_od_t od = ect_device_od(device(), NULL);
    const ect_object_t *object;
    const ect_entry_t *entry = NULL;
    (void)ect_od_lookup(&od, index, subindex, &object, &entry);
    return entry != NULL ? entry->value : 0;
}

/* The place of an object in the process data, as the file maps it. @return its bytes, 0: it is not mapped */
static inline unsigned int place(uint16_t assignment, uint16_t index, unsigned int *at)
{
    unsigned int bits = 0;
    for (uint8_t p = 1; p <= value_of(assignment, 0); p++) {
        uint16_t pdo = (uint16_t)value_of(assignment, p);
        for (uint8_t e = 1; e <= value_of(pdo, 0); e++) {
            uint32_t map = value_of(pdo, e);
            *at = bits / 8;
            if (map >> 16 == index)
                return (map & 0xFF) / 8;
            bits += map & 0xFF;
        }
    }
    return 0;
}

static inline void put(uint16_t index, int64_t value)
{
    unsigned int at;
    unsigned int bytes = place(0x1C12, index, &at);
    assert_true(bytes > 0);
    for (unsigned int i = 0; i < bytes; i++)
        out[at + i] = (uint8_t)((uint64_t)value >> 8 * i);
}

static inline int64_t get(uint16_t index)
{
    unsigned int at;
    unsigned int bytes = place(0x1C13, index, &at);
    uint64_t value = 0;
    assert_true(bytes > 0);
    for (unsigned int i = bytes; i-- > 0;)
        value = value << 8 | in[at + i];
    return bytes == 4 ? (int32_t)(uint32_t)value : (int64_t)value;
}

static inline uint16_t size_of(unsigned int sm)
{
    const uint32_t *entries = remapped[sm - 2];
    unsigned int bits = 0;
    if (entries == NULL)
        return ect_device_sm_bytes(device(), sm);
    for (; *entries != 0; entries++)
        bits += *entries & 0xFF;
    return (uint16_t)(bits / 8);
}

static inline void cycles(unsigned int count)
{
    while (count-- > 0) {
        (void)wire_write(&wire, 0, device()->sm[2].start, out, size_of(2));
        wire_advance(&wire, MS);
        assert_int_equal(wire_read(&wire, 0, device()->sm[3].start, in, size_of(3)), 1);
    }
}

static inline void operational(void)
{
    wire_go(&wire, 0, OP);
    cycles(1);
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

static inline void map(uint16_t pdo, uint8_t entry, uint32_t value, uint32_t abort)
{
    uint32_t got = write_sdo(pdo, entry, value, entry == 0 ? 1 : 4);
    if (got != abort)
        fail_msg("%04X:%u = %08X: expected %08X, got %08X", (unsigned int)pdo, entry, (unsigned int)value,
                 (unsigned int)abort, (unsigned int)got);
}

static inline void next_state(uint8_t al)
{
    uint16_t code = 0;
    if (al == SAFEOP) {
        wire_configure_process_data(&wire, 0);
        for (unsigned int sm = 2; sm <= 3; sm++)
            wire_set_sm(&wire, 0, sm, device()->sm[sm].start, size_of(sm), sm == 2 ? 0x64 : 0x20);
    } else {
        (void)wire_write(&wire, 0, device()->sm[2].start, out, size_of(2));
    }
    assert_int_equal(wire_al(&wire, 0, al, &code) & 0x0F, al);
    if (al == OP)
        cycles(1);
}

static inline void set(const char *name, const char *value)
{
    ect_signal_ref_t ref;
    char message[ECT_SIGNAL_MESSAGE];
    if (!ect_chain_signal(wire.chain, 0, name, &ref))
        fail_msg("there is no signal %s", name);
    if (!ect_signal_write(&ref, value, wire.now_ns, message))
        fail_msg("%s=%s: %s", name, value, message);
    ect_chain_wake(wire.chain, 0);
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

static inline void expect_emergency(uint16_t code, uint8_t error_register)
{
    uint8_t mail[256];
    assert_true(wire_mail_receive(&wire, 0, mail, sizeof mail) >= 10);
    assert_int_equal(ect_load_le16(mail + 8), code);
    assert_int_equal(mail[10], error_register);
}

/* --- the state machine -------------------------------------------------------------------------------------------- */

static inline unsigned int state_of(int64_t status)
{
    static const struct {
        unsigned int mask, value;
    } states[] = {{0x4F, SOD},      {0x6F, READY},    {0x6F, SWITCHED_ON}, {0x6F, ENABLED},
                  {0x6F, STOPPING}, {0x4F, REACTING}, {0x4F, FAULT}};
    for (size_t i = 0; i < COUNT(states); i++) {
        if ((status & states[i].mask) == states[i].value)
            return states[i].value;
    }
    return 0;
}

/* `axis` from 0. */
static inline void until(unsigned int axis, unsigned int state)
{
    uint16_t status = (uint16_t)(STATUS + 0x800 * axis);
    for (unsigned int n = 0; n < 1000 && state_of(get(status)) != state; n++)
        cycles(1);
    if (state_of(get(status)) != state)
        fail_msg("axis %u: expected state %02X, status word is %04X", axis + 1, state, (unsigned int)get(status));
}

static inline void command(unsigned int axis, uint16_t control, unsigned int state)
{
    put((uint16_t)(CONTROL + 0x800 * axis), control);
    cycles(1);
    until(axis, state);
}

static inline void enable(unsigned int axis)
{
    command(axis, SHUTDOWN, READY);
    command(axis, SWITCH_ON, SWITCHED_ON);
    command(axis, ENABLE, ENABLED);
}

/* A mode by PDO where the file maps 6060h, else by SDO where there is one. */
static inline void choose_mode(unsigned int axis, int8_t mode)
{
    unsigned int at;
    uint16_t index = (uint16_t)(MODE + 0x800 * axis);
    ect_od_t od = ect_device_od(device(), NULL);
    if (place(0x1C12, index, &at) > 0)
        put(index, mode);
    else if (ect_od_find(&od, index) != NULL)
        assert_int_equal(write_sdo(index, 0, mode, 1), 0);
}

static inline const char *note(void)
{
    size_t count;
    const char *const *notes = ect_esi_twin_notes(twin, &count);
    for (size_t i = 0; i < count; i++) {
        if (strncmp(notes[i], "CiA 402", 7) == 0)
            return notes[i];
    }
    return "";
}

/* A reference run. @return bits 13, 12, 10 at its end */
static inline unsigned int home(int8_t method, int32_t offset)
{
    assert_int_equal(write_sdo(0x6098, 0, method, 1), 0);
    assert_int_equal(write_sdo(0x607C, 0, offset, 4), 0);
    put(MODE, HM);
    put(CONTROL, ENABLE);
    cycles(1);
    put(CONTROL, START);
    unsigned int ms = 0;
    do {
        cycles(1);
    } while (++ms < 20000 && ((get(STATUS) & 0x3400) == 0 || (get(STATUS) & 0x3400) == 0x1000));
    return (unsigned int)(get(STATUS) >> 10 & 0xD); /* 13, 12, 10 */
}

/* --- SERVO with turns of its own ---------------------------------------------------------------------------------- */

static inline void signals(const char *name, int64_t value)
{
    char text[24];
    (void)snprintf(text, sizeof text, "%lld", (long long)value);
    set(name, text);
}

static inline void settings(uint32_t speed, uint32_t acceleration)
{
    assert_int_equal(write_sdo(0x6081, 0, speed, 4), 0);
    assert_int_equal(write_sdo(0x6083, 0, acceleration, 4), 0);
    assert_int_equal(write_sdo(0x6084, 0, acceleration, 4), 0);
    assert_int_equal(write_sdo(0x6085, 0, 500000, 4), 0);
    assert_int_equal(write_sdo(0x6065, 0, -1, 4), 0);
    assert_int_equal(write_sdo(0x6067, 0, 20, 4), 0);
    assert_int_equal(write_sdo(0x607F, 0, 1000000, 4), 0);
    assert_int_equal(write_sdo(0x6099, 1, SEARCH, 4), 0);
    assert_int_equal(write_sdo(0x6099, 2, ZERO, 4), 0);
    assert_int_equal(write_sdo(0x609A, 0, 500000, 4), 0);
}

static inline void servo(int8_t mode, uint32_t turn)
{
    open_drive("SERVO");
    signals("axis1.resolution", turn);
    settings(50000, 100000);
    put(MODE, mode);
    operational();
}

static inline void expect_near(const char *what, double want, double off, double got)
{
    if (!(fabs(got - want) <= off))
        fail_msg("%s: expected %.1f +- %.1f, got %.1f", what, want, off, got);
}

#endif
