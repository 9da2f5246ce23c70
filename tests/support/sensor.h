/* SPDX-License-Identifier: MIT */
/** @file A PLC in front of an FZM1 at position 0 of a ::wire_t, in virtual time. */
#ifndef TESTS_SUPPORT_SENSOR_H
#define TESTS_SUPPORT_SENSOR_H

#include "devices/fzm1/instance.h"
#include "support/signals.h"
#include "support/wire.h"

typedef struct sensor {
    wire_t w;
    uint8_t out[20];
    uint8_t in[48];
} sensor_t;

/* Into OP, all signals off, the bus watchdog switched off; image input 5 ms, processing 20 ms, commands 1 ms. */
void sensor_open(sensor_t *s);
void sensor_open_with(sensor_t *s, const ect_storage_t *storage);
/* From INIT (again) to OP. */
void sensor_operational(sensor_t *s);
void sensor_close(sensor_t *s);
fzm1_t *sensor_instance(sensor_t *s);

/* Sends the command area, then reads the inputs. Takes no time. */
void sensor_exchange(sensor_t *s);
/* Control signals on or off, and exchanges. */
void sensor_set(sensor_t *s, uint32_t signals, bool on);
/* Reads the inputs; @return the control signals */
uint32_t sensor_read(sensor_t *s);
/* Lets time pass, then looks. */
uint32_t sensor_wait(sensor_t *s, uint64_t ns);
/* Asserts which of `mask` are on, now. */
void sensor_expect(sensor_t *s, const char *when, uint32_t mask, uint32_t want);
/* Nanoseconds until the signals of `mask` become `want`; fails after a minute. */
uint64_t sensor_until(sensor_t *s, uint32_t mask, uint32_t want);
int32_t sensor_data(sensor_t *s, unsigned int n); /* 1..8 */

/* Writes a command's code and parameters, not EXE. */
void sensor_prepare(sensor_t *s, uint32_t code, int32_t p1, int32_t p2, int32_t p3);
/* The whole handshake. @return response code; *data, unless NULL, is the response data */
uint32_t sensor_command(sensor_t *s, uint32_t code, int32_t p1, int32_t p2, int32_t p3, int32_t *data);
/* STEP's rising edge and, when READY has gone, its fall. */
void sensor_step(sensor_t *s);

/* Non-volatile memory in RAM: two banks; writing stops for good after `budget` bytes, reading after `reads` reads
 * (UINT32_MAX: never). */
enum { SENSOR_BANK = 600000, SENSOR_UNSAFE = 64 };
typedef struct sensor_memory {
    ect_storage_t storage;
    uint8_t *bank[2];
    uint32_t budget;
    uint32_t reads;
    uint32_t written; /* bytes */
    /* A cache: a write is safe after `lazy` calls of flush; 0: at once. */
    unsigned int lazy, flushes;
    bool unsafe; /* flush fails */
    struct {
        unsigned int bank;
        uint32_t offset, length;
        uint8_t before[1024];
    } cache[SENSOR_UNSAFE]; /* data that are written and not yet safe */
    unsigned int cached;
} sensor_memory_t;
/* The power goes: each write that was not safe is on the medium, or is not. */
void sensor_memory_cut(sensor_memory_t *m, uint32_t written_mask);
bool sensor_memory_dirty(const sensor_memory_t *m);
void sensor_memory_open(sensor_memory_t *m);
void sensor_memory_close(sensor_memory_t *m);

#endif
