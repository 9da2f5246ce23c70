/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The PLC's side of an FZM1: the handshakes of its signals (Q179 §4-2, §4-4).
 *
 * A template to copy, without bus and clock: call ::fzm1_plc_cycle once in each cycle, between reading the inputs and
 * sending the outputs, with the present time. Three independent handshakes:
 *
 *   STEP  on while READY is on; off when READY is off, or after `step_hold_ns` in a cycle too slow to read that
 *   EXE   on a cycle after code and parameters; the response is read when FLG is on; EXE off; done when FLG is off
 *   DSA   on to fetch the next data, which are read when GATE is on; DSA off; on again when GATE is off
 *
 * Each wait is bounded: after an ignored EXE (BUSY rose at the same time, by another trigger), EXE falls and rises
 * again; so does DSA after a timeout of the sensor (ERR).
 *
 * The sensor ignores EXE that rises while it is BUSY (except for Clear, End continuous and Restart), and STEP while it
 * switches scenes: no command begins while STEP is on, and no STEP during a command.
 *
 * Without handshaking of the data output DSA stays off, and data are read at the rising edge of GATE.
 */
#ifndef ECTWIN_FZM1_PLC_H
#define ECTWIN_FZM1_PLC_H

#include <stdbool.h>
#include <stdint.h>

enum { FZM1_PLC_OUT = 20, FZM1_PLC_IN = 48, FZM1_PLC_DATA = 8 };

/** Control signals. */
enum { PLC_EXE = 1u << 0, PLC_STEP = 1u << 1, PLC_DSA = 1u << 16 };
enum {
    PLC_FLG = 1u << 0,
    PLC_BUSY = 1u << 1,
    PLC_READY = 1u << 2,
    PLC_OR = 1u << 3,
    PLC_RUN = 1u << 4,
    PLC_ERR = 1u << 15,
    PLC_GATE = 1u << 16,
};

/** Command codes. */
enum {
    PLC_START_CONTINUOUS = 0x00101020,
    PLC_END_CONTINUOUS = 0x00101030,
    PLC_CLEAR = 0x00102010,
    PLC_SAVE = 0x00103010,
    PLC_RESTART = 0x0010F010,
    PLC_GET_SCENE = 0x00201000,
    PLC_GET_GROUP = 0x00202000,
    PLC_SWITCH_SCENE = 0x00301000,
    PLC_SWITCH_GROUP = 0x00302000,
    PLC_GET_UNIT_DATA = 0x00401000,
    PLC_SET_UNIT_DATA = 0x00501000,
};

typedef enum fzm1_plc_exe { PLC_EXE_IDLE, PLC_EXE_WANTED, PLC_EXE_PREPARED, PLC_EXE_ON, PLC_EXE_OFF } fzm1_plc_exe_t;

typedef struct fzm1_plc {
    /* set before the first cycle */
    bool handshaking;      /**< output control of the sensor, 2400h:1 */
    uint64_t step_hold_ns; /**< longer than the image input and two cycles */
    uint64_t exe_retry_ns; /**< longer than any command without BUSY; then an ignored EXE is repeated */
    void (*on_data)(void *ctx, const int32_t data[FZM1_PLC_DATA]);
    void *ctx;

    /* read only */
    uint32_t signals; /**< control signals of the sensor */
    bool done;        /**< the response of the command is available: */
    uint32_t result;  /**< 0 OK, 0xFFFFFFFF refused */
    int32_t data;

    /* private */
    bool step, dsa;
    uint64_t step_until_ns, exe_until_ns;
    bool step_wanted;
    fzm1_plc_exe_t exe;
    uint32_t code;
    int32_t parameter[3];
    uint32_t before;
} fzm1_plc_t;

/** Call it when the bus has reached OP (again): restarts all handshakes. */
void fzm1_plc_start(fzm1_plc_t *p);

/** Executes one cycle: reads `in`, writes `out`. */
void fzm1_plc_cycle(fzm1_plc_t *p, const uint8_t in[FZM1_PLC_IN], uint8_t out[FZM1_PLC_OUT], uint64_t now_ns);

/** Measures once. @return false: READY is off, the last STEP is still on, or a command is under way */
bool fzm1_plc_measure(fzm1_plc_t *p);

/** Executes a command; `done` is set at its end. @return false: one is under way, STEP is on, or the sensor is busy */
bool fzm1_plc_command(fzm1_plc_t *p, uint32_t code, int32_t p1, int32_t p2, int32_t p3);

#endif
