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
 *   stop.c       option codes
 *   modes.c      set values, by mode of operation
 *   task.c       motion tasks: set-points, one under way and one waiting
 *   homing.c     reference runs, as legs in a table
 *   latch.c      latch control and status word
 *   control.c    position and speed controller
 *   limits.c     speed limit, software limit switches
 *   profile.c    ramps
 *   motor.c      motor, load, switches, index pulse
 *   fault.c      faults F01 … F32 and warnings
 *   quirks.c     replies and AL status codes as the manual prints them
 *
 * The state machine is that of the profile, profiles/cia402/state.h.
 *
 * Positions are counts, 2^20 a turn; speeds counts a second; torques Nm. Inside they are machine coordinates without a
 * bound: where the shaft is, whatever the reference. The master's positions count from `zero`, modulo 2^32: its set
 * values are differences of 32 bits. Time goes in steps of 250 us, the cycle of the position controller; each step is
 * the same whenever it is taken, so a session has the same numbers every time.
 */
#ifndef ECT_DEVICES_PMCTENDO_INSTANCE_H
#define ECT_DEVICES_PMCTENDO_INSTANCE_H

#include <stdbool.h>

#include "profiles/cia402/state.h"
#include "seams/standard.h"
#include "wire/bytes.h"

enum { PMC_STEP_NS = 250000, PMC_DISPLAYS_FAULT = 0x100, PMC_STATUS_402 = 402 };

/* In expressions with doubles. */
#define PMC_TURN        1048576 /* counts */
#define PMC_STEPS_PER_S 4000
#define PMC_STEP_S      (1.0 / PMC_STEPS_PER_S)

/** Bits of the control word and of the status word that the manual has beside those of CiA 402. */
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
    PMC_MODE_TASK = 1,
    PMC_MODE_SPEED_RAMP = 3,
    PMC_MODE_HOMING = 6,
    PMC_MODE_INTERPOLATED = 7,
    PMC_MODE_POSITION = 8,
    PMC_MODE_SPEED = 9,
    PMC_MODE_TORQUE = 10,
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

/** Lines with edges: the four inputs, then the index pulse of the feedback. */
enum { PMC_DI1, PMC_DI2, PMC_DI3, PMC_DI4, PMC_INDEX };
enum { PMC_INPUTS = PMC_INDEX };

/** Functions of the inputs (our assumption). */
enum { PMC_LATCH1 = PMC_DI1, PMC_LATCH2 = PMC_DI2, PMC_HOME = PMC_DI2, PMC_PSTOP = PMC_DI3, PMC_NSTOP = PMC_DI4 };

enum { PMC_EDGES = 10 /* the most in a step: two a mark, one a limit switch, the index */ };

typedef struct pmc_edge {
    uint8_t line;
    bool rising;
    double position; /* machine */
} pmc_edge_t;

/** A strip on the machine that turns a switch on, from `at` on for `width` counts; 0: no strip. */
typedef struct pmc_mark {
    int32_t at, width;
} pmc_mark_t;

/** A limit switch, machine coordinates. Without one the axis is endless that way. */
typedef struct pmc_stop {
    uint8_t fitted;
    int32_t at;
} pmc_stop_t;

/** The surroundings of the amplifier. They outlast a power cycle. */
typedef struct pmc_plant {
    bool known;
    double position; /* of the shaft, machine coordinates */
    double speed;
    double load;         /* Nm, against the positive direction */
    double load_inertia; /* kg cm2, beside the motor's own */
    double friction;     /* Nm */
    double brake;        /* Nm that it holds, 0: there is none */
    uint32_t brake_delay_ms;
    uint8_t input[PMC_INPUTS];
    pmc_mark_t mark[2]; /* in front of DI1 and DI2 */
    pmc_stop_t stop_negative, stop_positive;
    int32_t index_at;
    uint8_t power, enable, sto;
    int16_t analog;
    int32_t feedback2;
    uint16_t status_bits; /* 0: the manual's, PMC_STATUS_402 */
    uint32_t sync_patience_ms, sync_tolerance_ppm, sync_timeout_ms;
    uint8_t quirk_reply, quirk_al_codes;
} pmc_plant_t;

/** The set value of the controllers. */
typedef enum pmc_loop { PMC_LOOP_POSITION, PMC_LOOP_SPEED, PMC_LOOP_TORQUE } pmc_loop_t;
typedef struct pmc_reference {
    pmc_loop_t loop;
    double position, speed, torque;
} pmc_reference_t;

/** Control word and set values in force: those of the last SYNC0, or of the last outputs. */
typedef struct pmc_set {
    uint16_t control;
    int32_t position, speed;
    int16_t torque, ahead;
} pmc_set_t;

/** Target and rates of a motion task, as they were at its edge of bit 4. */
typedef struct pmc_set_point {
    bool valid, at_once, relative, through;
    int32_t target;
    double speed, acceleration, deceleration;
} pmc_set_point_t;

/** A reference run under way. */
typedef struct pmc_homing {
    int8_t method; /* at its start: 6098h may have changed since */
    uint8_t leg;   /* of the method's */
    bool active, error, done;
    bool interrupted; /* the error is that the master ended it */
    bool returning;   /* to the point that was found */
    bool searching;   /* for the switch, in the direction of the second leg, before the first one */
    bool slow;        /* the switch has been found: no leg is a search */
    uint32_t steps;   /* taken so far */
    double found;     /* machine */
} pmc_homing_t;

enum { PMC_LATCHES = 5 };
typedef struct pmc_latch {
    uint8_t armed, valid; /* a bit each */
    int32_t value[PMC_LATCHES];
} pmc_latch_t;

typedef struct pmc_sync {
    bool synchronised, warned;  /* n17 */
    unsigned int good;          /* consecutive events in order */
    unsigned int measured;      /* events in the present mean */
    uint64_t last_ns, first_ns; /* the last event, 0: none; the start of the mean */
    uint64_t op_until_ns;       /* deadline of SAFEOP to OP; ECT_NEVER: the transition is not waiting */
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
    uint16_t max_torque;
    uint16_t outputs; /* digital ones */
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
    int32_t target;
    uint32_t task_speed, acceleration, deceleration, quick_deceleration, speed_limit;
    uint32_t error_window, position_window;
    int16_t quick_option, shutdown_option, disable_option, halt_option, fault_option;
    uint16_t error_time, position_time, speed_time, zero_time; /* ms */
    uint16_t speed_window, zero_window;                        /* counts/s */
    uint16_t max_current, torque_limit[2];                     /* per mille; positive, negative */
    uint32_t motor_speed;                                      /* turns a minute */
    uint32_t most_acceleration, most_deceleration;
    uint32_t physical[2]; /* 60FEh: outputs, mask */
    uint8_t polarity;
    int16_t ramp_type;
    int8_t home_method;
    int32_t home_offset;
    uint32_t home_speed[2];
    uint32_t home_acceleration;
    int32_t limit[2]; /* software limit switches, lower and upper; equal: none */
    uint8_t cycle_units;
    int8_t cycle_power;

    const ect_host_t *host;
    uint64_t time_ns; /* the end of the last step, on the grid of steps */
    uint8_t al;
    bool live; /* OP, and outputs have come */

    ect_402_state_t state;
    ect_402_inputs_t ds;
    ect_402_action_t action;
    pmc_set_t set;
    bool control_known;     /* set.control was received in this OP: edges count from it */
    bool fresh;             /* outputs wait for SYNC0 */
    uint64_t brake_ns;      /* the brake is closed from then on, while there is no torque */
    uint64_t stop_until_ns; /* the deadline of a quick stop (F30) */

    /* set values */
    pmc_reference_t reference;
    int8_t mode_running;
    uint32_t segment_steps; /* remaining steps to the newest position set value */
    double segment_target;
    bool set_new;
    bool task;       /* under way */
    bool task_known; /* task_target is the target of the last one */
    bool task_reached;
    bool task_taken; /* as bit 12 of CiA 402 shows it */
    double task_target;
    pmc_set_point_t running, next;
    int8_t guarded; /* by the software limit switch in this direction, 0: by none */
    double guard_target;
    pmc_homing_t homing;
    bool homed;
    double zero; /* machine coordinate of the reference's 0 */
    double sum;  /* integral part of the speed controller, Nm */
    double torque_now;
    uint32_t error_steps;   /* that the following error has been beyond its window */
    uint32_t reached_steps; /* that the target has been reached */
    uint32_t slow_steps, fast_steps;
    bool speed_is_zero;

    uint8_t level[PMC_INPUTS];
    pmc_edge_t edge[PMC_EDGES];
    unsigned int edges;
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

/* drive.c: called by the stack */
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
/* ... and by the plant: runs the steps that are due; reads the levels of the inputs again. */
void pmc_advance(pmctendo_t *u, uint64_t now_ns);
void pmc_read_levels(pmctendo_t *u);
void pmc_publish(pmctendo_t *u); /* to the master, and as signals */

/* sync.c */
bool pmc_sync_is_clocked(const pmctendo_t *u); /* the rate of the rhythm matters */
void pmc_sync_lose(pmctendo_t *u);
void pmc_sync_event(pmctendo_t *u, uint8_t events, uint64_t now_ns);
void pmc_sync_wait(pmctendo_t *u, uint64_t now_ns); /* SAFEOP to OP */
void pmc_sync_due(pmctendo_t *u, uint64_t now_ns);
uint64_t pmc_sync_next(const pmctendo_t *u);
/* The cycle of the set values, 60C2h, in steps; 0: no multiple of a step. */
uint32_t pmc_cycle_steps(const pmctendo_t *u);

/* modes.c */
int8_t pmc_mode(const pmctendo_t *u);                /* the one in force */
void pmc_set_values(pmctendo_t *u, uint16_t rising); /* new set values are in force */
void pmc_follow_begin(pmctendo_t *u);
void pmc_follow(pmctendo_t *u); /* one step */
void pmc_hold_begin(pmctendo_t *u);
void pmc_brake_begin(pmctendo_t *u);
void pmc_brake(pmctendo_t *u, double deceleration); /* one step of a ramp to a standstill */
bool pmc_target_reached(const pmctendo_t *u);
bool pmc_halted(const pmctendo_t *u);

/* status.c */
uint16_t pmc_status(const pmctendo_t *u);
void pmc_status_step(pmctendo_t *u); /* windows and their times */

/* stop.c */
double pmc_stop_deceleration(const pmctendo_t *u);
void pmc_stop_begin(pmctendo_t *u); /* its deadline: 1.5 times the ramp, and 200 ms */
bool pmc_stop_in_time(const pmctendo_t *u);
bool pmc_stop_waits(const pmctendo_t *u); /* for a standstill; else the torque goes at once */
bool pmc_stop_stays(const pmctendo_t *u); /* in Quick Stop Active */
bool pmc_stop_known(uint16_t index, int option);

/* task.c */
void pmc_task_take(pmctendo_t *u); /* an edge of bit 4 */
void pmc_task_room(pmctendo_t *u); /* bit 4 or the queue has changed */
void pmc_task_drop(pmctendo_t *u);
void pmc_task_follow(pmctendo_t *u); /* one step */
bool pmc_task_active(const pmctendo_t *u);

/* limits.c */
double pmc_speed_limit(const pmctendo_t *u);
double pmc_acceleration(const pmctendo_t *u);
double pmc_deceleration(const pmctendo_t *u);
bool pmc_limit_acts(const pmctendo_t *u); /* a software limit switch changes the set value */
/* The machine position of a set value, absolute or relative, seen from machine position `from`. */
double pmc_absolute(pmctendo_t *u, double from, int32_t position);
double pmc_relative(pmctendo_t *u, double from, int32_t way);
void pmc_limits_begin(pmctendo_t *u);
/* One step: whether a software limit switch has the shaft, and the reference with it. */
bool pmc_limit_holds_speed(pmctendo_t *u, double speed);
bool pmc_limit_holds_torque(pmctendo_t *u, double torque);

/* homing.c */
void pmc_homing_start(pmctendo_t *u);
void pmc_homing_abort(pmctendo_t *u);
void pmc_homing_step(pmctendo_t *u);
void pmc_homing_edge(pmctendo_t *u, const pmc_edge_t *edge);
bool pmc_homing_known(int8_t method);

/* latch.c */
void pmc_latch_control(pmctendo_t *u);
void pmc_latch_edge(pmctendo_t *u, const pmc_edge_t *edge);

static inline double pmc_size(double x)
{
    return x < 0 ? -x : x;
}

/* control.c */
bool pmc_following_late(const pmctendo_t *u);
void pmc_control(pmctendo_t *u); /* torque_now from the reference */
void pmc_control_off(pmctendo_t *u);
bool pmc_standing(const pmctendo_t *u);

/* profile.c */
double pmc_within(double x, double limit);
/* From one value towards another, by at most `most`. */
double pmc_towards(double from, double to, double most);
/* One step to a standstill at `target`; @return whether the reference has arrived. */
bool pmc_profile(pmc_reference_t *r, double target, double speed, double acceleration, double deceleration);

/* motor.c */
#define PMC_RATED_TORQUE  3.0 /* Nm */
#define PMC_PEAK_TORQUE   9.0
#define PMC_MOTOR_INERTIA 3e-4 /* kg m2 */
/* Counts/s2 of one Nm on so much inertia. */
#define PMC_PER_NM(inertia) (PMC_TURN / 6.283185307179586 / (inertia))
void pmc_motor_step(pmctendo_t *u, bool powered); /* with torque_now; fills in u->edge */
bool pmc_motor_rests(const pmctendo_t *u);        /* without motor torque the shaft stays at its standstill */
void pmc_motor_levels(pmctendo_t *u);             /* the present levels of the inputs; a change is an edge */
int32_t pmc_counts(double counts);                /* a position: the nearest count, modulo 2^32 */
int32_t pmc_saturated(double counts);             /* no position: the nearest count, within 32 bits */
static inline double pmc_user(const pmctendo_t *u, double machine)
{
    return machine - u->zero;
}
/* The user's position `way` from that at `from`, in whole counts. */
double pmc_beyond(const pmctendo_t *u, double from, double way);
/* The machine position nearest to `from` that the master counts as `position`, modulo 2^32. */
double pmc_nearest(const pmctendo_t *u, double from, int32_t position);

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
bool pmc_fault_brakes(uint16_t number); /* the drive brakes; else the power stage goes off */
void pmc_warn(pmctendo_t *u, unsigned int number, bool on);

/* quirks.c */
void pmc_mail(void *instance, uint8_t *mail, uint16_t size);
uint16_t pmc_al_code(const pmctendo_t *u, uint16_t code); /* as the master reads it */

#endif
