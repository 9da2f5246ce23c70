/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A drive over a dictionary: an axis of CiA 402-2 for a description that is not made for it, such as an ESI file.
 *
 * Control word, set values and settings come from the entries of the dictionary that the links name, actual values go
 * there; an object without an entry has the default of values.h, and is nowhere visible. Positions of the axis are the
 * user units of the master: 608Fh, 6091h and 6092h give the way of a turn.
 *
 *   drive_run.c      the functions of a description: time, process data, AL states, SDO
 *   drive_values.c   settings into the axis, actual values out of it
 *   drive_probe.c    touch probes
 *   drive_faults.c   faults, their reactions and emergencies
 *   drive_signals.c  the surroundings, as signals
 *   values.c         objects and links
 *
 * No function allocates, blocks or reads a clock. The caller owns drive, surroundings, links and instance; they stay
 * where they are. Context: mainline and exchange, one at a time.
 */
#ifndef ECT_PROFILES_CIA402_DRIVE_H
#define ECT_PROFILES_CIA402_DRIVE_H

#include "profiles/cia402/axis.h"
#include "profiles/cia402/values.h"
#include "seams/device.h"
#include "seams/signals.h"

ECT_C_BEGIN

/** Units of speeds and accelerations on the bus, DRV-519. */
enum { ECT_402_UNIT_POSITION, ECT_402_UNIT_RPM, ECT_402_UNIT_TENTH_RPM };

/** Bits 10 and 12 of the status word in mode 8. */
enum { ECT_402_BIT10_ZERO, ECT_402_BIT10_WINDOW, ECT_402_BIT10_TOGGLES };
enum { ECT_402_BIT12_FOLLOWS, ECT_402_BIT12_ONE, ECT_402_BIT12_ZERO };

/** Choices that the profile leaves to vendors, DRV-501 to DRV-530. 0 is the twin's own. */
typedef struct ect_402_choices {
    uint8_t home_offset_added; /**< 607Ch: home has the position 607Ch instead of -607Ch */
    uint8_t following_zero;    /**< 6065h of 0 is a window instead of none */
    uint8_t following_warns;   /**< bit 13 without fault 8611h */
    uint8_t switched_on_holds; /**< Switched on has torque */
    uint8_t csp_bit10;         /**< ECT_402_BIT10_... */
    uint8_t csp_bit12;         /**< ECT_402_BIT12_... */
    uint8_t homing_by_level;   /**< bit 4 that is 1 at the entry of homing mode starts a run */
    uint8_t home_stays;        /**< the shaft stays where it stops behind home */
    uint8_t limits_absolute;   /**< 607Dh without 607Ch */
    uint8_t switch_faults;     /**< a limit switch on the way is fault 8612h */
    uint8_t no_buffer;         /**< each set-point of mode 1 counts at once */
    uint8_t mode_zero;         /**< 6060h of 0 is no mode instead of the last one */
    uint8_t mode_change;       /**< ECT_402_CHANGE_... */
    uint8_t reset_needs_zero;  /**< bits 0 to 3 of the word that resets a fault are 0 */
    uint8_t sync_check;        /**< 60C2h beside another cycle is fault 8700h, and the end of OP */
} ect_402_choices_t;

/** Mode changes in Operation enabled: at any time, at a standstill, none. */
enum { ECT_402_CHANGE_ANY, ECT_402_CHANGE_STANDING, ECT_402_CHANGE_NONE };

/** The surroundings of a drive. They outlast a power cycle of it. */
typedef struct ect_402_surroundings {
    bool known;
    double turn; /**< position units, in which the machine is described */
    ect_402_plant_t machine;
    uint8_t power, enable, sto, warning;
    uint8_t velocity_unit; /**< ECT_402_UNIT_... */
    uint32_t resolution;   /**< increments a turn, when there is no 608Fh */
    ect_402_choices_t choices;
} ect_402_surroundings_t;

/** Touch probes, 60B8h. */
enum { ECT_402_PROBES = 2 };
typedef struct ect_402_probe {
    uint16_t function;        /**< 60B8h as taken last, shifted to bit 0 */
    bool armed[2], stored[2]; /**< positive, negative edge */
    bool toggle[2];           /**< changes with each edge in continuous mode */
    int32_t value[2];
    uint16_t edges[2];
} ect_402_probe_t;

/** One axis. Zeroed before ::ect_402_drive_init. */
typedef struct ect_402_drive {
    ect_402_axis_t axis;
    ect_402_config_t config;
    ect_402_surroundings_t *around;
    const ect_402_link_t *links; /**< ECT_402_VALUE_COUNT */
    void *instance;
    const ect_host_t *host;
    int64_t value[ECT_402_VALUE_COUNT]; /**< as read last */
    uint32_t modes;                     /**< supported, as in 6502h */
    double increments;                  /**< of a turn */
    double speed_unit;                  /**< position units a second */
    ect_402_probe_t probe[ECT_402_PROBES];
    uint16_t error_code;
    uint8_t al;
    bool control_known;            /**< a control word was received in this OP: edges count from it */
    bool fresh;                    /**< outputs wait for SYNC0 */
    bool cycle_written;            /**< 60C2h is the master's */
    uint8_t wrong_cycles;          /**< in succession, against 60C2h */
    uint32_t max_slippage;         /**< 60F8h, counts/s; mode 3; 0: none */
    uint64_t methods;              /**< 60E3h: bit n for method n of 6098h; 0: all that are known */
    uint64_t sync0_ns, outputs_ns; /**< the last of each; 0: none */

    /* as signals */
    uint16_t state_shown;
    uint16_t fault; /**< write: raises a fault */
    int8_t mode_shown;
    uint8_t powered, homed, braked;
    int32_t position, demand, following_error;
    double position_turns, speed_rpm, torque_nm;
} ect_402_drive_t;

/* --- drive_run.c -------------------------------------------------------------------------------------------------- */

/**
 * Power-on.
 * @param instance  the entries that the links name; they have the defaults of the file
 * @param host      valid as long as the drive
 */
void ect_402_drive_init(ect_402_drive_t *d, const ect_402_link_t *links, ect_402_surroundings_t *around, void *instance,
                        const ect_host_t *host, uint64_t now_ns);
/** Time passes. */
void ect_402_drive_advance(ect_402_drive_t *d, uint64_t now_ns);
/** Actual values into the dictionary. */
void ect_402_drive_publish(ect_402_drive_t *d);
/** The master has written outputs. With SYNC0 they come into force at the next one. */
void ect_402_drive_outputs(ect_402_drive_t *d, uint64_t now_ns);
void ect_402_drive_sync0(ect_402_drive_t *d, uint64_t now_ns);
/** OP has begun. */
void ect_402_drive_enter_op(ect_402_drive_t *d, uint64_t now_ns);
/**
 * OP has ended, whatever the cause: 6007h. The outputs in the dictionary are at their defaults; settings among them
 * get the values that they had in OP.
 */
void ect_402_drive_leave_op(ect_402_drive_t *d, uint64_t now_ns);
/** An AL state below OP has begun, after ::ect_402_drive_leave_op when OP has ended. @param al  ECT_STATE_... */
void ect_402_drive_below_op(ect_402_drive_t *d, uint8_t al);
/** @return the time of the next call of ::ect_402_drive_advance, or ECT_NEVER */
uint64_t ect_402_drive_next(const ect_402_drive_t *d);
/** An entry of the axis was written by SDO or by a user. @param value  which */
void ect_402_drive_written(ect_402_drive_t *d, ect_402_value_t value, uint64_t now_ns);
/** The surroundings were changed by a user: edges lie at the present position. */
void ect_402_drive_touched(ect_402_drive_t *d);

/* --- drive_values.c ----------------------------------------------------------------------------------------------- */

/** @return ECT_OK, or the reason to refuse `number` for `value` */
ect_reason_t ect_402_drive_check(const ect_402_drive_t *d, ect_402_value_t value, int64_t number);
/** 60C2h: `units` times ten to the power of `power`, in ns; 0: a power above 0, or below -9. */
uint64_t ect_402_drive_cycle_ns(int64_t units, int64_t power);
/** Settings and commands without a default of the file get that of values.h. */
void ect_402_drive_defaults(ect_402_drive_t *d);
/** Reads the entries. @param all  false: only those that process data reach */
void ect_402_drive_read(ect_402_drive_t *d, bool all);
/** Control word excepted: the set values of the master. */
void ect_402_drive_set_values(ect_402_drive_t *d);
void ect_402_drive_actual(ect_402_drive_t *d);

/* --- drive_probe.c ------------------------------------------------------------------------------------------------ */

/** 60B8h was read again. */
void ect_402_drive_probe_control(ect_402_drive_t *d);
/** The edges of the last step. */
void ect_402_drive_probe_edges(ect_402_drive_t *d);
/** 60B9h to 60BDh and 60D5h to 60D8h into the dictionary. */
void ect_402_drive_probe_publish(const ect_402_drive_t *d);
/** The position of the master at a machine position: polarity, 607Bh. */
int32_t ect_402_drive_position(const ect_402_drive_t *d, double machine);

/* --- drive_faults.c ----------------------------------------------------------------------------------------------- */

/** Raises a fault: 603Fh, an emergency, the reaction of 605Eh or none. */
void ect_402_drive_fault(ect_402_drive_t *d, uint16_t code);
void ect_402_drive_fault_reset(ect_402_drive_t *d);
/** Whether the power stage can brake with such a fault. */
bool ect_402_fault_brakes(uint16_t code);
/** Whether only a restart ends such a fault. */
bool ect_402_fault_restarts(uint16_t code);

/* --- drive_signals.c ---------------------------------------------------------------------------------------------- */

/** Signals over ::ect_402_drive_t. */
extern const ect_signal_t ect_402_drive_signals[];
extern const uint16_t ect_402_drive_signal_count;
/** Signals over ::ect_402_surroundings_t. */
extern const ect_signal_t ect_402_around_signals[];
extern const uint16_t ect_402_around_signal_count;
/** @return as ect_plant_t::signal_write; for a signal over the drive */
const char *ect_402_drive_signal_write(ect_402_drive_t *d, const ect_signal_t *signal, const void *value);
/** ect_plant_t::signal_describe for a signal over the drive. */
void ect_402_drive_signal_describe(const ect_signal_t *signal, uint16_t value, char *text);

ECT_C_END

#endif
