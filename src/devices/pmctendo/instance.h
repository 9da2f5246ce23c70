/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A PMCtendo DD5 in memory.
 *
 * Each file includes only those below it; `pmctendo.c`, the description, reaches them through its tables:
 *
 *   signals.c    the plant: signals of the user
 *   drive.c      the functions that the stack calls: time, process data, AL states
 *   sync.c       the cyclic rhythm: warning n17, fault F28
 *   status.c     status word
 *   latch.c      latch control and status word
 *   fault.c      faults F01 … F32 and warnings
 *   quirks.c     replies and AL status codes as printed in the manual
 *
 * The axis of profiles/cia402 has all standard functions of CiA 402, with a control step of 250 us. The following
 * members are the additions and differences of the manual.
 */
#ifndef ECT_DEVICES_PMCTENDO_INSTANCE_H
#define ECT_DEVICES_PMCTENDO_INSTANCE_H

#include <stdbool.h>

#include "profiles/cia402/axis.h"
#include "seams/standard.h"
#include "wire/bytes.h"

enum { PMC_STEP_NS = ECT_402_STEP_NS, PMC_DISPLAYS_FAULT = 0x100, PMC_STATUS_402 = 402 };

#define PMC_TURN 1048576 /* counts; for expressions with doubles */

/** Bits of the control word and of the status word in addition to those of CiA 402. */
enum {
    PMC_REFERENCE = 0x0800, /**< control: reference run, mode 8 */
    PMC_SAVE = 0x1000,      /**< control: its rising edge stores the parameters */
    PMC_STATUS_REFERENCING = 0x1000,
    PMC_STATUS_REFERENCE_ERROR = 0x2000,
    PMC_STATUS_TASK = 0x8000,
};

/** Modes of operation 6060h; 0: by the assigned PDO. */
enum {
    PMC_MODE_BY_PDO = 0,
    PMC_MODE_TASK = ECT_402_PP,
    PMC_MODE_SPEED_RAMP = ECT_402_PV,
    PMC_MODE_HOMING = ECT_402_HM,
    PMC_MODE_INTERPOLATED = ECT_402_IP,
    PMC_MODE_POSITION = ECT_402_CSP,
    PMC_MODE_SPEED = ECT_402_CSV,
    PMC_MODE_TORQUE = ECT_402_CST,
};

/** The fixed PDOs; their mappings are in pmctendo.c. */
enum {
    PMC_PDO_POSITION = 0x1701,
    PMC_PDO_SPEED = 0x1702,
    PMC_PDO_TORQUE = 0x1704,
    PMC_PDO_POSITION_FULL = 0x1720,
    PMC_PDO_POSITION_TORQUE = 0x1721,
    PMC_PDO_POSITION_LIMIT = 0x1722,
    PMC_PDO_ACTUAL = 0x1B01,
    PMC_PDO_ACTUAL_FULL = 0x1B25,
    PMC_PDO_ACTUAL_STATUS = 0x1B26,
};

/** The wiring of the inputs (an assumption of the twin). */
enum { PMC_DI1 = ECT_402_PROBE, PMC_DI2 = ECT_402_HOME, PMC_DI3 = ECT_402_POSITIVE, PMC_DI4 = ECT_402_NEGATIVE };
enum { PMC_LATCH1 = PMC_DI1, PMC_LATCH2 = PMC_DI2, PMC_HOME = PMC_DI2, PMC_PSTOP = PMC_DI3, PMC_NSTOP = PMC_DI4 };

/** The surroundings of the amplifier, which outlast a power cycle. */
typedef struct pmc_plant {
    bool known;
    ect_402_plant_t machine;
    uint8_t power, enable, sto;
    int16_t analog;
    int32_t feedback2;
    uint16_t status_bits; /* 0: the manual's, PMC_STATUS_402 */
    uint32_t sync_patience_ms, sync_tolerance_ppm, sync_timeout_ms;
    uint8_t quirk_reply, quirk_al_codes;
} pmc_plant_t;

enum { PMC_LATCHES = 5 };
typedef struct pmc_latch {
    uint8_t armed, valid; /* one bit each */
    int32_t value[PMC_LATCHES];
} pmc_latch_t;

typedef struct pmc_sync {
    bool synchronised, warned;  /* n17 */
    unsigned int good;          /* consecutive events in time */
    unsigned int measured;      /* events in the present mean */
    uint64_t last_ns, first_ns; /* the last event; the start of the mean; 0: none */
    uint64_t op_until_ns;       /* deadline of SAFEOP to OP; ECT_NEVER: the transition does not wait */
} pmc_sync_t;

typedef struct pmctendo {
    ect_standard_t standard;
    ect_sync_data_t sync_data;

    /* process data, and set values by SDO */
    uint16_t control;
    uint16_t status;
    uint16_t assigned_out, assigned_in;
    uint8_t assigned_outs, assigned_ins; /* numbers of PDOs: 0 or 1 */
    int32_t set_position;
    int32_t set_speed;
    int16_t set_torque;   /* per mille of the rated torque */
    int16_t torque_ahead; /* feed-forward */
    uint16_t outputs;     /* digital ones */
    uint16_t latch_control, latch_status;
    int32_t latch_position[2];
    int32_t position, internal_position, speed, following_error, demand;
    int16_t torque, torque_demand, current, analog;
    uint32_t inputs; /* 60FDh */
    int32_t feedback2;
    int8_t mode, mode_display;
    uint16_t error_code;
    uint16_t fault;    /* 0, or n of Fn */
    uint32_t warnings; /* bit n-1: nn */

    /* parameters */
    uint8_t polarity;
    int16_t ramp_type;
    uint8_t cycle_units;
    int8_t cycle_power;

    ect_402_axis_t axis;
    const ect_host_t *host;
    uint8_t al;
    bool control_known; /* set.control was received in this OP: edges count from it */
    bool fresh;         /* outputs wait for SYNC0 */
    pmc_latch_t latch;
    pmc_sync_t sync;

    /* as signals */
    double position_turns, speed_rpm, torque_nm;
    uint16_t display;     /* number of a warning, or of a fault with PMC_DISPLAYS_FAULT; 0: empty */
    uint16_t state_shown; /* ect_402_state_t */
    uint8_t synchronised, homed_level, powered, do1, do2;
    uint8_t provoke, restart;
    uint32_t saves;

    pmc_plant_t plant; /* outlasts power: see ect_plant_t */
} pmctendo_t;

/* drive.c: functions called by the stack */
void pmc_init(void *instance, const ect_host_t *host, uint64_t now_ns);
uint16_t pmc_state_change(void *instance, uint8_t from, uint8_t to, uint64_t now_ns);
void pmc_cyclic(void *instance, uint8_t events, uint64_t now_ns);
void pmc_outputs(void *instance, uint64_t now_ns);
void pmc_safe_outputs(void *instance, uint64_t now_ns);
void pmc_inputs(void *instance, uint64_t now_ns);
uint64_t pmc_tick(void *instance, uint64_t now_ns);
ect_reason_t pmc_sdo_write(void *instance, uint16_t index, uint8_t subindex, const void *data, uint16_t size);
void pmc_sdo_written(void *instance, uint16_t index, uint8_t subindex, uint64_t now_ns);
uint16_t pmc_al_error(void *instance, uint8_t state, uint16_t code, uint64_t now_ns);
/* ... and by the plant: runs due steps; reads the levels of the inputs again. */
void pmc_advance(pmctendo_t *u, uint64_t now_ns);
void pmc_read_levels(pmctendo_t *u);
void pmc_publish(pmctendo_t *u); /* for the master, and as signals */

/* sync.c */
bool pmc_sync_is_clocked(const pmctendo_t *u); /* whether the rate of the rhythm is checked */
void pmc_sync_lose(pmctendo_t *u);
void pmc_sync_event(pmctendo_t *u, uint8_t events, uint64_t now_ns);
void pmc_sync_wait(pmctendo_t *u, uint64_t now_ns); /* SAFEOP to OP */
void pmc_sync_due(pmctendo_t *u, uint64_t now_ns);
uint64_t pmc_sync_next(const pmctendo_t *u);
/* @return the cycle of the set values, 60C2h, in steps; 0: not a multiple of a step. */
uint32_t pmc_cycle_steps(const pmctendo_t *u);

/* status.c */
uint16_t pmc_status(const pmctendo_t *u);

/* latch.c */
void pmc_latch_control(pmctendo_t *u);
void pmc_latch_edge(pmctendo_t *u, const ect_402_edge_t *edge);

/* fault.c */
enum {
    PMC_F_FOLLOWING = 3,
    PMC_F_UNDERVOLTAGE = 5,
    PMC_F_OVERSPEED = 8,
    PMC_F_STO = 27,
    PMC_F_SYNC = 28,
    PMC_F_STOP = 30,
    PMC_FAULTS = 32
};
enum { PMC_N_SOFT_NEGATIVE = 6, PMC_N_SOFT_POSITIVE = 7, PMC_N_PSTOP = 10, PMC_N_NSTOP = 11, PMC_N_SYNC = 17 };
void pmc_fault(pmctendo_t *u, uint16_t number); /* a second fault does not replace the first */
void pmc_fault_reset(pmctendo_t *u);
bool pmc_fault_known(uint16_t number);
bool pmc_fault_needs_restart(uint16_t number);
bool pmc_fault_brakes(uint16_t number); /* the drive brakes; else the power stage is switched off */
void pmc_warn(pmctendo_t *u, unsigned int number, bool on);

/* quirks.c */
void pmc_mail(void *instance, uint8_t *mail, uint16_t size);
uint16_t pmc_al_code(const pmctendo_t *u, uint16_t code); /* value read by the master */

#endif
