/* SPDX-License-Identifier: MIT */
/**
 * @file
 * An axis of CiA 402-2: modes of operation, set-points, stops, limits, reference runs, controllers, and the plant: a
 * motor with load, friction, brake, switches and index pulse.
 *
 * A product embeds an ::ect_402_axis_t in its instance; its dictionary entries lie in the parameters of the axis.
 *
 *   step.c       execution of the state machine, a control step
 *   modes.c      set values, by mode of operation          task.c     set-points of mode 1
 *   status.c     bits 10, 12, 13 of the status word        stop.c     option codes 605Ah to 605Eh
 *   homing.c     reference runs                            limits.c   speed limit, software limit switches
 *   control.c    position and speed controller             ramp.c     ramps
 *   motor.c      the plant                                 state.c    the state machine, a pure function
 *
 * A step of a product:
 *
 *     axis.time_ns += ECT_402_STEP_NS;
 *     axis.mode, axis.cycle_steps, axis.conditions = ...
 *     ect_402_settle(&axis, 0);       then, with axis.was_reset, its own reset of the fault
 *     ect_402_step(&axis);            then axis.troubles become faults, axis.edge[] latches
 *
 * New outputs: axis.set = ..., ect_402_settle with the rising bits of the control word, ect_402_set_values.
 *
 * Each file includes only those below it. Positions are in counts, speeds in counts per second, torques in Nm. Internal
 * positions are machine coordinates without a bound; the positions of the master count from `zero`, modulo 2^32: its
 * set values are differences of 32 bits. Time advances in steps of ::ECT_402_STEP_NS; the result of a step does not
 * depend on the time of the call.
 *
 * No function allocates, blocks or reads a clock. The caller owns the axis, its plant and its configuration, which must
 * not move while the axis is in use. Context: mainline and exchange, one at a time.
 */
#ifndef ECT_PROFILES_CIA402_AXIS_H
#define ECT_PROFILES_CIA402_AXIS_H

#include "profiles/cia402/state.h"

ECT_C_BEGIN

enum { ECT_402_STEP_NS = 250000 };
#define ECT_402_STEPS_PER_S 4000 /* not an enumeration constant, because it is multiplied by doubles */
#define ECT_402_STEP_S      (1.0 / ECT_402_STEPS_PER_S)

/** Modes of operation, 6060h. */
enum {
    ECT_402_NO_MODE = 0,
    ECT_402_PP = 1,
    ECT_402_PV = 3,
    ECT_402_TQ = 4,
    ECT_402_HM = 6,
    ECT_402_IP = 7,
    ECT_402_CSP = 8,
    ECT_402_CSV = 9,
    ECT_402_CST = 10,
};

/** Lines with edges: the inputs, then the index pulse. A limit switch reads 0 when hit. */
enum { ECT_402_PROBE, ECT_402_HOME, ECT_402_POSITIVE, ECT_402_NEGATIVE, ECT_402_INDEX };
enum { ECT_402_INPUTS = ECT_402_INDEX };
enum { ECT_402_EDGES = 10 /* limit in a step: two for each mark, one for each limit switch, one of the index */ };

typedef struct ect_402_edge {
    uint8_t line;
    bool rising;
    double position; /**< machine */
} ect_402_edge_t;

/** A mark on the machine that turns a switch on, from `at` on for `width` counts; 0: no mark. */
typedef struct ect_402_mark {
    int32_t at, width;
} ect_402_mark_t;

/** A limit switch, machine coordinates. Without a switch the axis is endless in its direction. */
typedef struct ect_402_switch {
    uint8_t fitted;
    int32_t at;
} ect_402_switch_t;

/** The machine. It may outlast a power cycle of the axis. */
typedef struct ect_402_plant {
    double position; /**< of the shaft, machine coordinates */
    double speed;
    double load;         /**< Nm, against the positive direction */
    double load_inertia; /**< kg cm2, in addition to the motor's */
    double friction;     /**< Nm */
    double brake;        /**< holding torque, Nm; 0: no brake */
    uint8_t jam;         /**< the shaft is stuck */
    uint32_t brake_delay_ms;
    uint8_t input[ECT_402_INPUTS]; /**< switched manually */
    ect_402_mark_t mark[2];        /**< at ECT_402_PROBE and ECT_402_HOME */
    ect_402_switch_t stop_negative, stop_positive;
    int32_t index_at; /**< an index pulse, and one in each further turn */
} ect_402_plant_t;

/** The motor, and the choices of a product. Constant. */
typedef struct ect_402_config {
    double turn;            /**< counts */
    double rated_torque;    /**< Nm: 1000 per mille */
    double peak_torque;     /**< Nm */
    double inertia;         /**< kg m2 */
    uint16_t reference_bit; /**< bit of the control word that starts a reference run in modes 7 and 8; 0: none */
    bool coasts;            /**< Switched On has no torque, regardless of 605Ch */
    bool cyclic_is_free;    /**< 607Fh limits profiled motion only, not modes 8 to 10 */
    bool ip_waits;          /**< mode 7 follows while bit 4 of the control word is 1 */
    bool overspeed_at_once; /**< 1.2 times the speed limit of the mode is a fault; else 1.2 times 6080h for 10 ms */
    bool cyclic_halts;      /**< bit 8 of the control word acts in modes 8 to 10 too */
    bool torque_releases;   /**< halt and disable operation reduce the torque of mode 4 on 6087h; else they brake */
    bool zero_window;       /**< 6065h of 0 is a window; else none */
    bool homing_by_level;   /**< bit 4 that is 1 at the entry of mode 6 starts a run */
    bool home_stays;        /**< the shaft remains at its stop behind home; else it returns */
    bool no_buffer;         /**< each set-point of mode 1 applies at once */
} ect_402_config_t;

/** The set value of the controllers. */
typedef enum ect_402_loop { ECT_402_LOOP_POSITION, ECT_402_LOOP_SPEED, ECT_402_LOOP_TORQUE } ect_402_loop_t;
typedef struct ect_402_reference {
    ect_402_loop_t loop;
    double position, speed, torque;
} ect_402_reference_t;

/** Control word and set values in force. */
typedef struct ect_402_set {
    uint16_t control;
    int32_t position, speed;
    int16_t torque, ahead; /**< per mille; feed-forward */
} ect_402_set_t;

/** Target and rates of mode 1 at their edge of bit 4. */
typedef struct ect_402_set_point {
    bool valid, at_once, relative, through;
    int32_t target;
    double speed, end_speed, acceleration, deceleration;
} ect_402_set_point_t;

/** A reference run under way. */
typedef struct ect_402_homing {
    int8_t method; /**< method at the start: 6098h may have changed since */
    uint8_t leg;   /**< of the method */
    bool active, error, done;
    bool interrupted; /**< by the master; with `error` */
    bool returning;   /**< motion to the point found */
    bool searching;   /**< search for the switch, in the direction of the second leg, before the first one */
    bool slow;        /**< the switch is found: no leg is a search */
    bool turned;      /**< reversed by a limit switch, on the first leg */
    uint32_t steps;   /**< since the start */
    double found;     /**< machine */
} ect_402_homing_t;

/** Supply and faults, set by the product. */
typedef struct ect_402_conditions {
    bool supplied;     /**< DC link, enable input, no STO: may be switched on */
    bool fault;        /**< present, and not reset */
    bool resettable;   /**< by bit 7 */
    bool fault_brakes; /**< brakes by 605Eh; else the power stage is switched off */
    bool by_level;     /**< 0Fh enables by its level */
} ect_402_conditions_t;

/** Reasons for a fault, set by the axis and cleared by the product. */
enum { ECT_402_LATE = 0x01 /**< following error, 6065h, 6066h */, ECT_402_OVERSPEED = 0x02 };

typedef struct ect_402_axis {
    const ect_402_config_t *config;
    ect_402_plant_t *plant;

    /* parameters: entries of the dictionary */
    int32_t target;
    uint32_t task_speed, end_speed, acceleration, deceleration, quick_deceleration, speed_limit;
    uint32_t error_window, position_window;
    int16_t quick_option, shutdown_option, disable_option, halt_option, fault_option;
    uint16_t error_time, position_time, speed_time, zero_time; /**< ms */
    uint16_t speed_window, zero_window;                        /**< counts/s */
    uint16_t max_torque, max_current, torque_limit[2];         /**< per mille; positive, negative */
    uint32_t motor_speed;                                      /**< turns a minute */
    uint32_t torque_slope;                                     /**< per mille per second; mode 4 */
    uint32_t most_acceleration, most_deceleration;
    uint32_t physical[2]; /**< 60FEh: outputs, mask */
    int8_t home_method;
    int32_t home_offset;
    uint32_t home_speed[2];
    uint32_t home_acceleration;
    int32_t limit[2]; /**< software limit switches, lower and upper; equal: none */
    int32_t range[2]; /**< 607Bh, lowest and highest position of a rotary axis; equal: none */
    uint16_t options; /**< 60F2h */

    /* inputs: updated by the product */
    int8_t mode;          /**< in force */
    bool live;            /**< control word and set values apply */
    uint32_t cycle_steps; /**< of set positions, in steps; 0: as 1 */
    ect_402_conditions_t conditions;
    ect_402_set_t set;

    /* state */
    uint64_t time_ns; /**< end of the last step, a multiple of the step */
    ect_402_state_t state;
    ect_402_inputs_t inputs; /**< of the last decision, in state `decided` */
    ect_402_state_t decided;
    ect_402_action_t action;
    uint8_t troubles;       /**< ECT_402_LATE, ...; the product clears them */
    bool was_reset;         /**< bit 7 has reset the fault; cleared by the product */
    uint64_t brake_ns;      /**< the brake is closed from this time on, while the torque is off */
    uint64_t stop_until_ns; /**< the deadline of a quick stop */

    ect_402_reference_t reference;
    int8_t mode_running;
    uint32_t segment_steps; /**< remaining steps to the newest set position */
    double segment_target;
    bool set_new;
    bool toggle;     /**< changes with each set position */
    bool task;       /**< under way */
    bool task_known; /**< task_target is the target of the last task */
    bool task_reached;
    bool task_taken; /**< bit 12 of mode 1 */
    double task_target;
    ect_402_set_point_t running, next;
    int8_t guarded;                      /**< stopped by the software limit switch in this direction; 0: by none */
    bool limit_negative, limit_positive; /**< a software limit switch changes the set value */
    double guard_target;
    ect_402_homing_t homing;
    bool homed;
    double zero; /**< machine coordinate of position 0 */
    double sum;  /**< integral part of the speed controller, Nm */
    double torque_now;
    bool at_switch; /**< a limit switch stops the shaft; present set position */
    double switch_speed;
    bool held;              /**< the torque or speed limit changes the set value */
    uint32_t error_steps;   /**< with the following error beyond its window */
    uint32_t over_steps;    /**< above 6080h */
    uint32_t reached_steps; /**< with the target reached */
    uint32_t slow_steps, fast_steps;
    bool speed_is_zero;

    uint8_t level[ECT_402_INPUTS];
    ect_402_edge_t edge[ECT_402_EDGES]; /**< of the last step */
    unsigned int edges;
} ect_402_axis_t;

/* --- step.c ------------------------------------------------------------------------------------------------------- */

/** @return whether the motor has torque. */
bool ect_402_powered(const ect_402_axis_t *a);
/** @return whether the axis has no torque and the shaft is at rest, so that time may advance without steps. */
bool ect_402_rests(const ect_402_axis_t *a);
/** Executes all transitions; `rising`: bits of a new control word that were 0 before, else 0. */
void ect_402_settle(ect_402_axis_t *a, uint16_t rising);
/** Executes one step of set values, controllers and plant, up to `time_ns`. */
void ect_402_step(ect_402_axis_t *a);
/** Reads the levels after a manual change of a switch; edges occur at the present position. */
void ect_402_read_levels(ect_402_axis_t *a);

/* --- modes.c ------------------------------------------------------------------------------------------------------ */

/** Applies new set values; `rising`: bits of the control word that were 0 before. */
void ect_402_set_values(ect_402_axis_t *a, uint16_t rising);
void ect_402_follow_begin(ect_402_axis_t *a);
/** Applies a mode, also one by mailbox, before its set values. @return whether the mode has changed */
bool ect_402_take_mode(ect_402_axis_t *a);
/** Executes one step of set values. */
void ect_402_follow(ect_402_axis_t *a);
void ect_402_hold_begin(ect_402_axis_t *a);
void ect_402_brake_begin(ect_402_axis_t *a);
/** Executes one step of 6087h towards no torque. */
void ect_402_release(ect_402_axis_t *a);
/** @return whether halt and disable operation reduce the torque in place of braking. */
bool ect_402_releases(const ect_402_axis_t *a);
/** Executes one step of a ramp to a standstill. */
void ect_402_brake(ect_402_axis_t *a, double deceleration);
/** @return bit 10 without the times of its windows, while set values are followed. */
bool ect_402_target_reached(const ect_402_axis_t *a);
/** @return whether mode 7 follows its set positions: bit 4, if the product requires this bit. */
bool ect_402_ip_active(const ect_402_axis_t *a);
/** @return whether Operation Enabled has a halt, bit 8: set-points and reference runs are kept. */
bool ect_402_halted(const ect_402_axis_t *a);

/* --- status.c ----------------------------------------------------------------------------------------------------- */

/** @return bits 10, 12 and 13 of the status word, by mode. */
uint16_t ect_402_mode_bits(const ect_402_axis_t *a);
/** @return bit 10 with the times of its windows, in any state. */
bool ect_402_reached(const ect_402_axis_t *a);
/** Advances the times of windows; called once in each step. */
void ect_402_status_step(ect_402_axis_t *a);

/* --- stop.c ------------------------------------------------------------------------------------------------------- */

double ect_402_stop_deceleration(const ect_402_axis_t *a);
/** Sets the deadline of a quick stop: 1.5 times its ramp, and 200 ms; 10 s at the current or voltage limit. */
void ect_402_stop_begin(ect_402_axis_t *a);
bool ect_402_stop_in_time(const ect_402_axis_t *a);
/** @return whether a transition from Operation Enabled or Quick Stop Active waits for a standstill. */
bool ect_402_stop_waits(const ect_402_axis_t *a);
/** @return whether the drive stays in Quick Stop Active (605Ah). */
bool ect_402_stop_stays(const ect_402_axis_t *a);
/** @return whether 605Ah to 605Eh has an option. */
bool ect_402_stop_known(uint16_t index, int option);

/* --- task.c ------------------------------------------------------------------------------------------------------- */

/** Handles an edge of bit 4. */
void ect_402_task_take(ect_402_axis_t *a);
/** Handles a change of bit 4 or of the queue. */
void ect_402_task_room(ect_402_axis_t *a);
void ect_402_task_drop(ect_402_axis_t *a);
/** One step. */
void ect_402_task_follow(ect_402_axis_t *a);
bool ect_402_task_active(const ect_402_axis_t *a);

/* --- homing.c ----------------------------------------------------------------------------------------------------- */

void ect_402_homing_start(ect_402_axis_t *a);
void ect_402_homing_abort(ect_402_axis_t *a);
/** One step. */
void ect_402_homing_step(ect_402_axis_t *a);
void ect_402_homing_edge(ect_402_axis_t *a, const ect_402_edge_t *edge);
bool ect_402_homing_known(int8_t method);

/* --- control.c ---------------------------------------------------------------------------------------------------- */

/** @return whether the following error has been beyond 6065h for longer than 6066h. */
bool ect_402_following_late(const ect_402_axis_t *a);
/** Executes one step: sets `torque_now` from the reference, and `troubles`. */
void ect_402_control(ect_402_axis_t *a);
void ect_402_control_off(ect_402_axis_t *a);
/** @return whether the reference is 0 and the shaft below 3 turns per minute. */
bool ect_402_standing(const ect_402_axis_t *a);

/* --- limits.c ----------------------------------------------------------------------------------------------------- */

double ect_402_speed_limit(const ect_402_axis_t *a);
double ect_402_acceleration(const ect_402_axis_t *a);
double ect_402_deceleration(const ect_402_axis_t *a);
bool ect_402_limit_acts(const ect_402_axis_t *a);
/** @return the machine position of a set value, absolute or relative, nearest to machine position `from`. */
double ect_402_absolute(ect_402_axis_t *a, double from, int32_t position);
/** @return a position in the master's count, within 607Bh. */
double ect_402_folded(const ect_402_axis_t *a, double user);
double ect_402_relative(ect_402_axis_t *a, double from, int32_t way);
void ect_402_limits_begin(ect_402_axis_t *a);
/** Execute one step. @return whether a software limit switch determines the reference, and stops the shaft. */
bool ect_402_limit_holds_speed(ect_402_axis_t *a, double speed);
bool ect_402_limit_holds_torque(ect_402_axis_t *a, double torque);

/* --- ramp.c ------------------------------------------------------------------------------------------------------- */

double ect_402_within(double x, double limit);
/** @return a value moved towards another by at most `most`. */
double ect_402_towards(double from, double to, double most);
/** Executes one step to a standstill at `target`. @return whether the reference has arrived */
bool ect_402_ramp(ect_402_reference_t *r, double target, double speed, double acceleration, double deceleration);

static inline double ect_402_size(double x)
{
    return x < 0 ? -x : x;
}

/* --- motor.c ------------------------------------------------------------------------------------------------------ */

/** @return the acceleration by 1 Nm on an inertia in kg m2, counts/s2. */
static inline double ect_402_per_nm(const ect_402_axis_t *a, double inertia)
{
    return a->config->turn / 6.283185307179586 / inertia;
}

/** Executes one step of the shaft with `torque_now`; sets `edge` and `level`. */
void ect_402_motor_step(ect_402_axis_t *a, bool powered);
/** @return whether the shaft stays at a standstill without motor torque. */
bool ect_402_motor_rests(const ect_402_axis_t *a);
/** Reads the present levels of the inputs; a change is an edge. */
void ect_402_motor_levels(ect_402_axis_t *a);
/** @return a position: the nearest count, modulo 2^32. */
int32_t ect_402_counts(double counts);
/** @return another value: the nearest count, within 32 bits. */
int32_t ect_402_saturated(double counts);
static inline double ect_402_user(const ect_402_axis_t *a, double machine)
{
    return machine - a->zero;
}
/** @return the machine position at a distance `way` from `from`, in integer counts of the master. */
double ect_402_beyond(const ect_402_axis_t *a, double from, double way);
/** @return the machine position nearest to `from` whose count for the master is `position`. */
double ect_402_nearest(const ect_402_axis_t *a, double from, int32_t position);

ECT_C_END

#endif
