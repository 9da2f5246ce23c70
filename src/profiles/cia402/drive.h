/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A drive over a dictionary: an axis of CiA 402-2 for a foreign description, such as an ESI file.
 *
 * Control word, set values and settings are read from the linked entries of the dictionary, actual values are written
 * to them; an object without an entry has the default of values.h. Positions of the axis are in the user units of the
 * master: 608Fh, 6091h and 6092h determine the distance of a turn.
 *
 *   drive_run.c      the functions of a description: time, process data, AL states, SDO
 *   drive_values.c   settings into the axis, actual values out of it
 *   drive_probe.c    touch probes
 *   drive_faults.c   faults, their reactions and emergencies
 *   drive_signals.c  the surroundings, as signals
 *   values.c         objects and links
 *
 * No function allocates, blocks or reads a clock. The caller owns drive, surroundings, links and instance, which must
 * not move. Context: mainline and exchange, one at a time.
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

/** Choices that the profile leaves to vendors, DRV-501 to DRV-530. 0 is the twin's default. */
typedef struct ect_402_choices {
    uint8_t home_offset_added; /**< 607Ch: home has the position 607Ch instead of -607Ch */
    uint8_t following_zero;    /**< 6065h of 0 is a window instead of none */
    uint8_t following_warns;   /**< bit 13 without fault 8611h */
    uint8_t switched_on_holds; /**< Switched on has torque */
    uint8_t csp_bit10;         /**< ECT_402_BIT10_... */
    uint8_t csp_bit12;         /**< ECT_402_BIT12_... */
    uint8_t homing_by_level;   /**< bit 4 that is 1 at the entry of homing mode starts a run */
    uint8_t home_stays;        /**< the shaft remains at its stop behind home */
    uint8_t limits_absolute;   /**< 607Dh without 607Ch */
    uint8_t switch_faults;     /**< a limit switch on the way is fault 8612h */
    uint8_t no_buffer;         /**< each set-point of mode 1 applies at once */
    uint8_t mode_zero;         /**< 6060h of 0 is no mode instead of the last one */
    uint8_t mode_change;       /**< ECT_402_CHANGE_... */
    uint8_t reset_needs_zero;  /**< bits 0 to 3 of the word that resets a fault are 0 */
    uint8_t sync_check;        /**< 60C2h different from the cycle is fault 8700h, and the end of OP */
} ect_402_choices_t;

/** Mode changes in Operation enabled: at any time, at a standstill, none. */
enum { ECT_402_CHANGE_ANY, ECT_402_CHANGE_STANDING, ECT_402_CHANGE_NONE };

/** The surroundings of a drive, which outlast a power cycle of the drive. */
typedef struct ect_402_surroundings {
    bool known;
    double turn; /**< position units of the description of the machine */
    ect_402_plant_t machine;
    uint8_t power, enable, sto, warning;
    uint8_t velocity_unit; /**< ECT_402_UNIT_... */
    uint32_t resolution;   /**< increments per turn, without 608Fh */
    ect_402_choices_t choices;
} ect_402_surroundings_t;

/** Touch probes, 60B8h. */
enum { ECT_402_PROBES = 2 };
typedef struct ect_402_probe {
    uint16_t function;        /**< last evaluated 60B8h, shifted to bit 0 */
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
    int64_t value[ECT_402_VALUE_COUNT]; /**< last value read */
    uint32_t modes;                     /**< supported, as in 6502h */
    double increments;                  /**< of a turn */
    double speed_unit;                  /**< position units per second */
    ect_402_probe_t probe[ECT_402_PROBES];
    uint16_t error_code;
    uint8_t al;
    bool control_known;            /**< a control word was received in this OP: edges count from it */
    bool fresh;                    /**< outputs wait for SYNC0 */
    bool cycle_written;            /**< 60C2h was set by the master */
    uint8_t wrong_cycles;          /**< in succession, against 60C2h */
    uint32_t max_slippage;         /**< 60F8h, counts/s; mode 3; 0: none */
    uint64_t methods;              /**< 60E3h: bit n for method n of 6098h; 0: all methods of the axis */
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
 * @param instance  the linked entries, with the defaults of the file
 * @param host      valid as long as the drive
 */
void ect_402_drive_init(ect_402_drive_t *d, const ect_402_link_t *links, ect_402_surroundings_t *around, void *instance,
                        const ect_host_t *host, uint64_t now_ns);
/** Time passes. */
void ect_402_drive_advance(ect_402_drive_t *d, uint64_t now_ns);
/** Writes actual values to the dictionary. */
void ect_402_drive_publish(ect_402_drive_t *d);
/** Handles outputs written by the master. With SYNC0 they take effect at the next SYNC0. */
void ect_402_drive_outputs(ect_402_drive_t *d, uint64_t now_ns);
void ect_402_drive_sync0(ect_402_drive_t *d, uint64_t now_ns);
/** Handles the begin of OP. */
void ect_402_drive_enter_op(ect_402_drive_t *d, uint64_t now_ns);
/**
 * Handles the end of OP, of any cause: 6007h. The outputs in the dictionary have their defaults; settings among them
 * get their values of OP again.
 */
void ect_402_drive_leave_op(ect_402_drive_t *d, uint64_t now_ns);
/**
 * Handles the begin of an AL state below OP, after ::ect_402_drive_leave_op if OP has ended. @param al ECT_STATE_...
 */
void ect_402_drive_below_op(ect_402_drive_t *d, uint8_t al);
/** @return the time of the next call of ::ect_402_drive_advance, or ECT_NEVER */
uint64_t ect_402_drive_next(const ect_402_drive_t *d);
/** Handles a write of an entry of the axis by SDO or by a user. @param value  of the axis */
void ect_402_drive_written(ect_402_drive_t *d, ect_402_value_t value, uint64_t now_ns);
/** Handles a change of the surroundings by a user: edges occur at the present position. */
void ect_402_drive_touched(ect_402_drive_t *d);

/* --- drive_values.c ----------------------------------------------------------------------------------------------- */

/** @return ECT_OK, or the reason to refuse `number` for `value` */
ect_reason_t ect_402_drive_check(const ect_402_drive_t *d, ect_402_value_t value, int64_t number);
/** @return 60C2h, `units` times ten to the power of `power`, in ns; 0: a power above 0, or below -9. */
uint64_t ect_402_drive_cycle_ns(int64_t units, int64_t power);
/** Sets settings and commands without a default in the file to that of values.h. */
void ect_402_drive_defaults(ect_402_drive_t *d);
/** Reads the entries. @param all  false: only those accessible to process data */
void ect_402_drive_read(ect_402_drive_t *d, bool all);
/** Reads the set values of the master, except the control word. */
void ect_402_drive_set_values(ect_402_drive_t *d);
void ect_402_drive_actual(ect_402_drive_t *d);

/* --- drive_probe.c ------------------------------------------------------------------------------------------------ */

/** Evaluates 60B8h. */
void ect_402_drive_probe_control(ect_402_drive_t *d);
/** Evaluates the edges of the last step. */
void ect_402_drive_probe_edges(ect_402_drive_t *d);
/** Writes 60B9h to 60BDh and 60D5h to 60D8h to the dictionary. */
void ect_402_drive_probe_publish(const ect_402_drive_t *d);
/** @return the master's position at a machine position, with polarity and 607Bh. */
int32_t ect_402_drive_position(const ect_402_drive_t *d, double machine);

/* --- drive_faults.c ----------------------------------------------------------------------------------------------- */

/** Raises a fault: 603Fh, an emergency, the reaction of 605Eh or none. */
void ect_402_drive_fault(ect_402_drive_t *d, uint16_t code);
void ect_402_drive_fault_reset(ect_402_drive_t *d);
/** @return whether the power stage can brake with a fault. */
bool ect_402_fault_brakes(uint16_t code);
/** @return whether only a restart ends a fault. */
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
