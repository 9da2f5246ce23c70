/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The base unit's instance, and the offsets of the fields of TS-0007 chapters 8 and 9 in the process data.
 */
#ifndef ECT_DEVICES_ECLINK_INSTANCE_H
#define ECT_DEVICES_ECLINK_INSTANCE_H

#include <stdbool.h>

#include "seams/fields.h"
#include "seams/modbus.h"
#include "seams/standard.h"

enum { ECLINK_INPUT_BYTES = 142, ECLINK_OUTPUT_BYTES = 228, ECLINK_PERIODIC_BYTES = 200, ECLINK_COMMAND_BYTES = 16 };

/** Offsets in the input data (TS-0007 §8). */
enum {
    ECLINK_IN_PCI = 0,
    ECLINK_IN_CCI = 1,
    ECLINK_IN_PAI = 2,
    ECLINK_IN_CAI = 3,
    ECLINK_IN_COMMAND_RU = 4,
    ECLINK_IN_COMMAND = 6,
    ECLINK_IN_BU_STATE = 22,
    ECLINK_IN_VLAPS = 23,
    ECLINK_IN_UNARMED = 24,
    ECLINK_IN_EG_LINK = 25,
    ECLINK_IN_EC_LINK = 26,
    ECLINK_IN_SPARE = 27,
    ECLINK_IN_RU = 28, /* first remote; the second and third follow at this stride */
    ECLINK_IN_RU_STRIDE = 38,
};

/** Offsets in a remote unit's part of the input data. */
enum {
    ECLINK_RU_ID = 0,
    ECLINK_RU_STATE = 2,
    ECLINK_RU_BATTERY = 3,
    ECLINK_RU_RSSI = 4,
    ECLINK_RU_CABLE = 5,
    ECLINK_RU_DOCKED = 6,
    ECLINK_RU_DISABLED = 7,
    ECLINK_RU_C_LINK = 8,
    ECLINK_RU_G_LINK = 9,
    ECLINK_RU_JOYSTICK = 10,
    ECLINK_RU_SWITCH = 18,
    ECLINK_RU_ENCODER = 34,
    ECLINK_RU_ENCODER_SWITCH = 35,
    ECLINK_RU_SPARE = 36,
};

/** Offsets in the output data (TS-0007 §9). */
enum {
    ECLINK_OUT_PCO = 0,
    ECLINK_OUT_CCO = 1,
    ECLINK_OUT_PAO = 2,
    ECLINK_OUT_CAO = 3,
    ECLINK_OUT_COMMAND_RU = 4,
    ECLINK_OUT_COMMAND = 6,
    ECLINK_OUT_SPARE = 22,
    ECLINK_OUT_PERIODIC_SIZE = 24,
    ECLINK_OUT_PERIODIC_BLOCK = 26,
    ECLINK_OUT_PERIODIC_SPARE = 27,
    ECLINK_OUT_PERIODIC = 28,
};

/** Bits of FMAP (TS-0007 §2.1). */
enum { ECLINK_FMAP_INPUT = 1, ECLINK_FMAP_COMMANDS = 2, ECLINK_FMAP_PERIODIC = 4, ECLINK_FMAP_MULTIARM = 8 };

/** BU state (§8.1). */
enum {
    ECLINK_BU_INITIAL = 0x00,
    ECLINK_BU_STOPPED = 0x01,
    ECLINK_BU_LINK_ERROR = 0x02,
    ECLINK_BU_BLOCKED = 0x03,
    ECLINK_BU_FAILED = 0x04,
    ECLINK_BU_DISARMED = 0x10,
    ECLINK_BU_ARMED = 0x11,
};

/** Link status (§8.2). */
enum {
    ECLINK_LINK_UNUSED = 0,
    ECLINK_LINK_OPERATIONAL = 1,
    ECLINK_LINK_NONE = 2,
    ECLINK_LINK_ERROR = 3,
    ECLINK_LINK_INTERFACE_ERROR = 4,
    ECLINK_LINK_DATA_ERROR = 5,
    ECLINK_LINK_PASSIVE = 6,
    ECLINK_LINK_FALLBACK = 7,
};

/** RU state (§8.3). */
enum { ECLINK_RU_INITIAL = 0, ECLINK_RU_ARMED = 2, ECLINK_RU_ENABLED = 3, ECLINK_RU_STOPPED = 4, ECLINK_RU_FAILED = 5 };

/** Equipment of a switch position (§8.5). */
typedef enum eclink_equipment {
    ECLINK_NOT_FITTED,
    ECLINK_PUSHBUTTON,     /* 0, 1 */
    ECLINK_TWO_POSITION,   /* 0, 1 */
    ECLINK_THREE_POSITION, /* -1, 0, 1 */
    ECLINK_POTENTIOMETER,  /* 0..1000 */
    ECLINK_BUTTON_LED,     /* 0, 1, plus 2 when lit */
    ECLINK_DUAL_LED,       /* 0 off, 1 green, 2 red, 3 amber */
    ECLINK_EQUIPMENT_COUNT
} eclink_equipment_t;

enum { ECLINK_RUS = 8, ECLINK_MOST_ARMED = 3, ECLINK_JOYSTICKS = 4, ECLINK_SWITCHES = 8, ECLINK_QUEUE = 16 };

/**
 * Longest time without a change of PCO, without CAO after a command (§10.1, §10.4), without a read of the inputs (Input
 * Only), and over Modbus without the required request of the mode. An EtherCAT master that leaves OP keeps the unit for
 * the same time.
 */
#define ECLINK_SUPERVISION_NS 2000000000ull

/**
 * Largest set of periodic data: 256 blocks (§10.4). The host's buffer has room for two sets: the last complete one, and
 * the one under assembly. Without the buffer the unit counts sets and keeps no content.
 */
enum { ECLINK_PERIODIC_ROOM = 51200, ECLINK_BUFFER = 2 * ECLINK_PERIODIC_ROOM };

typedef struct eclink_command {
    uint16_t ru; /* id of the sending or receiving remote (0: all) */
    uint8_t data[ECLINK_COMMAND_BYTES];
} eclink_command_t;

/** Commands in the order of their arrival. A full queue refuses new ones. */
typedef struct eclink_queue {
    eclink_command_t commands[ECLINK_QUEUE];
    uint8_t first;
    uint8_t count;
} eclink_queue_t;

/** The path to a remote unit. */
typedef enum eclink_path {
    ECLINK_PATH_NONE,   /* out of communication */
    ECLINK_PATH_C_LINK, /* on fallback */
    ECLINK_PATH_FULL,   /* G-Link or cable */
} eclink_path_t;

enum { ECLINK_NOT_FORCED = -1 };

/** A remote unit, as signals `ruN.*`. */
typedef struct eclink_ru {
    uint16_t id;   /* unique */
    uint8_t on;    /* switched on and in radio range */
    uint8_t stop;  /* stop switch pressed */
    uint8_t shock; /* free fall or shock detected */
    uint8_t failed;
    uint8_t disabled; /* 0 enabled, 1 tilt, 2 inactivity, 3 popup */
    uint8_t battery;
    uint8_t rssi;
    uint8_t cable;
    uint8_t docked;
    uint8_t g_link_lost;
    uint8_t encoder;
    uint8_t encoder_switch;
    int16_t joystick[ECLINK_JOYSTICKS];
    int16_t switches[ECLINK_SWITCHES];
    uint8_t fitted[ECLINK_SWITCHES]; /* eclink_equipment_t */
    int16_t forced_c_link;           /* a link status of §8.2, or ECLINK_NOT_FORCED */
    int16_t forced_g_link;

    uint8_t armed; /* this member and the following ones: results of the base unit, lost with its power */
    uint8_t state;
    int16_t c_link;
    int16_t g_link;
    eclink_path_t path;
    uint8_t command[ECLINK_COMMAND_BYTES];  /* a write sends it */
    uint8_t received[ECLINK_COMMAND_BYTES]; /* the last command from the controller */
    uint32_t received_count;
    uint32_t periodic_count; /* sets of periodic data shown */
    eclink_queue_t to_ru;
    bool periodic_waits;       /* a set waits for room on the link */
    uint8_t sent;              /* its commands that C-Link has yet to transfer, on fallback */
    bool vlap;                 /* the remote has a VLAP */
    uint32_t commands_dropped; /* commands of `to_ru` lost with its communication */
} eclink_ru_t;

/** Cause of the base unit's state. The plant has the texts. */
typedef enum eclink_why {
    ECLINK_WHY_NONE,
    ECLINK_WHY_DISABLED, /* faults of the EC-Link (§8.2, §11), the worse of two first */
    ECLINK_WHY_MODULE,
    ECLINK_WHY_CONFIGURATION,
    ECLINK_WHY_NO_DATA,
    ECLINK_WHY_NOT_READ,
    ECLINK_WHY_PCO,
    ECLINK_WHY_CAO,
    ECLINK_WHY_SELF,
    ECLINK_WHY_EG_NO_LINK, /* in the order of the EG-Link's status, from ECLINK_LINK_NONE on */
    ECLINK_WHY_EG_ERROR,
    ECLINK_WHY_EG_INTERFACE,
    ECLINK_WHY_EG_DATA,
    ECLINK_WHY_LOST, /* this and the following: combined with the number of a remote, from 1 */
    ECLINK_WHY_FAILED,
    ECLINK_WHY_STOP,
    ECLINK_WHY_SHOCK,
} eclink_why_t;

/* A cause with the number of a remote, for `bu.cause`. */
static inline uint16_t eclink_why(unsigned int number, eclink_why_t why)
{
    return (uint16_t)(number << 8 | (unsigned int)why);
}

/** The base unit, as signals `bu.*`. */
typedef struct eclink_bu {
    uint8_t enabled; /* 0: mode Disabled */
    uint8_t vlaps;
    uint8_t eg_link;
    uint8_t failed;
    uint8_t module_error;
    uint8_t report_passive;       /* EC-C9: byte 36 is 6, not 0, while no RU is armed */
    uint8_t lock_errors;          /* strict reading of §11: an EC-Link error remains until a power cycle */
    uint32_t command_lifetime_ms; /* commands from the remotes that wait longer are dropped; 0: never */

    uint8_t state;  /* this member and the following ones: results, lost with its power */
    uint8_t frozen; /* the input data do not change */
    uint8_t restart;
    uint8_t ec_link;
    uint8_t es_link; /* relays closed */
    uint8_t unarmed;
    uint8_t armed;
    uint8_t pci, cci, pai, cai;
    uint16_t fault;              /* eclink_why_t up to ECLINK_WHY_CAO: the message on the display */
    uint16_t cause;              /* eclink_why(): cause of a state that is not Armed or Disarmed */
    uint8_t modbus;              /* a controller is active over Modbus TCP */
    uint32_t overflows;          /* commands from the remotes refused by a full queue */
    uint32_t commands_lost;      /* commands from the controller skipped by CCO */
    uint32_t commands_unknown;   /* ... to an id that no remote has */
    uint32_t commands_unreached; /* ... acknowledged without a remote to receive them */
    uint32_t commands_expired;   /* commands from the remotes that outlived command_lifetime_ms */
    uint32_t cco_resyncs;        /* first outputs whose CCO was neither the last value nor the last value plus one */
    uint32_t pco_jumps;          /* changes of PCO by other than one */
    uint32_t periodic_sets;
    uint32_t periodic_errors;
    uint32_t periodic_skipped;    /* blocks of a set whose block 0 is missing */
    uint32_t periodic_unfinished; /* sets that never became complete */
    uint32_t periodic_lost;       /* blocks missing in them */
    uint16_t periodic_size;       /* of the last complete set */
    uint16_t periodic_pending;    /* size of the set under assembly; 0: none */
    uint16_t periodic_missing;    /* missing blocks of this set */
    uint32_t periodic_check;      /* CRC-32 of the last complete set */
} eclink_bu_t;

/** The set of periodic output data under assembly. */
typedef struct eclink_periodic {
    uint8_t have[32]; /* a bit for each block */
    uint8_t shown;    /* half of the buffer with the last complete set */
} eclink_periodic_t;

/** Numbers 0..7 of remotes, in the order of entry. */
typedef struct eclink_list {
    uint8_t numbers[ECLINK_MOST_ARMED];
    uint8_t count;
} eclink_list_t;

typedef struct eclink {
    ect_standard_t standard;
    const ect_host_t *host;
    uint8_t fmap;
    bool in_op;         /* an EtherCAT master has the unit */
    bool exchanging;    /* process data flow */
    bool good_once;     /* a good exchange has occurred since power-on */
    bool outputs_known; /* outputs have arrived since data began to flow */
    bool pco_alive;
    bool config_refused; /* configuration needed by the controller to leave `refused_in` */
    uint8_t refused_in;
    uint8_t locked; /* with lock_errors: the remaining fault of the EC-Link */
    uint8_t last_pco, last_cco;
    bool cci_waits; /* the command in the input data is not acknowledged */
    bool cao_late;  /* ... and its timeout has passed */
    bool cco_waits; /* a remote has no room yet for `waiting` */
    uint64_t pco_deadline_ns;
    uint64_t cao_deadline_ns;
    uint64_t read_deadline_ns;   /* Input Only: deadline of the next read of the inputs */
    uint64_t modbus_deadline_ns; /* deadline of the controller's next required request; ECT_NEVER: no request so far */
    uint64_t hold_deadline_ns;   /* an EtherCAT master that has left OP keeps the outputs until this time */
    uint64_t update_ns;          /* next time at which PCI counts */

    uint8_t inputs[ECLINK_INPUT_BYTES];
    uint8_t outputs[ECLINK_OUTPUT_BYTES];
    uint8_t input_numbers[ECLINK_INPUT_BYTES]; /* 3001h: the same fields in the host's byte order */
    uint8_t output_numbers[ECLINK_OUT_PERIODIC];
    eclink_bu_t bu; /* with `ru`: the operator's side; its surroundings outlast a power cycle */
    eclink_ru_t ru[ECLINK_RUS];
    eclink_list_t armed; /* together with `lost` at most as many as may be armed */
    eclink_list_t lost;  /* lost while armed: a remote keeps its place until it is rearmed or replaced */

    bool remotes_due; /* a signal was set or a remote disarmed since the last update of the remotes: nothing else
                         changes them */
    eclink_command_t waiting; /* the command of last_cco */
    eclink_queue_t from_ru;
    uint64_t sent_ns[ECLINK_QUEUE]; /* times at which they were sent */
    eclink_periodic_t periodic;
} eclink_t;

/* @return whether a link status is an error: 2 to 5 of §8.2. */
static inline bool eclink_is_error(int link_status)
{
    return link_status >= ECLINK_LINK_NONE && link_status <= ECLINK_LINK_DATA_ERROR;
}

/* @return whether the mode has a function, ECLINK_FMAP_... */
static inline bool eclink_has(const eclink_t *unit, unsigned int function)
{
    return (unit->fmap & function) != 0;
}

void eclink_init(void *instance, const ect_host_t *host, uint64_t now_ns);
uint16_t eclink_state_change(void *instance, uint8_t from, uint8_t to, uint64_t now_ns);
uint16_t eclink_al_error(void *instance, uint8_t state, uint16_t code, uint64_t now_ns);
void eclink_outputs(void *instance, uint64_t now_ns);
void eclink_inputs_read(void *instance, uint64_t now_ns);
uint64_t eclink_tick(void *instance, uint64_t now_ns);
ect_reason_t eclink_sdo_read(void *instance, uint16_t index, uint16_t subindex, ect_span_t *instead);
/* 3001h or 3002h. The offset of an entry in the instance, minus `base`, is the offset of the field in the image. */
const ect_object_t *eclink_fields(const eclink_t *unit, bool inputs, size_t *base);

/* base_unit.c */
/* Records the required request of a Modbus controller, which keeps data flowing: a write of outputs, or a read of
 * inputs in a mode without outputs. */
void eclink_modbus_came(eclink_t *unit, uint64_t now_ns);
/* Computes links, BU state, relays, message and cause. */
void eclink_evaluate(eclink_t *unit);

/* commands.c */
/* Queues a command from a remote. @return false: the queue is full */
bool eclink_command_from_ru(eclink_t *unit, const eclink_command_t *command, uint64_t now_ns);
void eclink_command_to_rus(eclink_t *unit);
/* Passes the controller's command to its remotes and acknowledges it, as soon as all of them have room. */
void eclink_pass_command(eclink_t *unit);
void eclink_show_command(eclink_t *unit, uint64_t now_ns);
void eclink_command_outputs(eclink_t *unit, bool first, uint64_t now_ns);

/* periodic.c */
/* Takes the block in the outputs. Call it once for each block. */
void eclink_periodic_outputs(eclink_t *unit);
/* Drops the set under assembly. */
void eclink_periodic_drop(eclink_t *unit);
/* @return the last complete set, bu.periodic_size bytes; NULL without a buffer. */
const uint8_t *eclink_periodic_set(const eclink_t *unit);

/* remotes.c */
void eclink_remotes_update(eclink_t *unit);
void eclink_remotes_publish(const eclink_t *unit, uint8_t *inputs);
bool eclink_reachable(const eclink_ru_t *ru);
/* @return the reason for the user; NULL: the remote can be reached */
const char *eclink_why_unreachable(const eclink_ru_t *ru);
const char *eclink_arm(eclink_t *unit, unsigned int number, bool armed);

/* modbus.c */
extern const ect_modbus_t eclink_modbus;

/* fields.c */
extern const ect_field_t eclink_states[]; /* for the plant */

#endif
