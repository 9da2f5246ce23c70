/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The instance of an FZM1.
 *
 * Each file includes only those below it; `fzm1.c`, the description, reaches them through its tables:
 *
 *   signals.c     the plant: the user's side
 *   settings.c    SDO writes
 *   controller.c  time and process data: due events in the order of their times, then the signals
 *   commands.c    EXE, FLG: the eleven commands
 *   restart.c     off, off the bus, power-on
 *   switch.c      switching scene and scene group; preparing scenes
 *   save.c        the record of "Save to unit", and the scenes of a group from memory or record
 *   measure.c     STEP, READY, BUSY: image input, the queue of images, results
 *   output.c      DSA, GATE: the output area, with and without handshaking
 *   view.c        the model of the cameras
 *   group.c       scenes of the current group in memory
 *   prepared.c    scenes that a user has prepared
 *   scene.c       a scene: the factory's, and the limits of its values
 *   expression.c  the expression of an output data
 *   error.c       ERR and its causes; reasons of refusals
 *
 * All times are nanoseconds of the caller's clock; ECT_NEVER: nothing is due.
 */
#ifndef ECT_DEVICES_FZM1_INSTANCE_H
#define ECT_DEVICES_FZM1_INSTANCE_H

#include <stdbool.h>

#include "seams/fields.h"
#include "seams/record.h"
#include "seams/standard.h"

/** Control signals of the command area (Q179 §4-1). */
enum { FZM1_EXE = 0x00000001, FZM1_STEP = 0x00000002, FZM1_DSA = 0x00010000 };

/** Control signals of the response area; FLG by OM-C4. */
enum {
    FZM1_FLG = 0x00000001,
    FZM1_BUSY = 0x00000002,
    FZM1_READY = 0x00000004,
    FZM1_OR = 0x00000008,
    FZM1_RUN = 0x00000010,
    FZM1_ERR = 0x00008000,
    FZM1_GATE = 0x00010000,
};

/** Command codes (§4-3): the word at +2 is the lower one. */
enum {
    FZM1_START_CONTINUOUS = 0x00101020,
    FZM1_END_CONTINUOUS = 0x00101030,
    FZM1_CLEAR = 0x00102010,
    FZM1_SAVE = 0x00103010,
    FZM1_RESTART = 0x0010F010,
    FZM1_GET_SCENE = 0x00201000,
    FZM1_GET_GROUP = 0x00202000,
    FZM1_SWITCH_SCENE = 0x00301000,
    FZM1_SWITCH_GROUP = 0x00302000,
    FZM1_GET_UNIT_DATA = 0x00401000,
    FZM1_SET_UNIT_DATA = 0x00501000,
};

/** External reference numbers of the Fieldbus Data Output item (§3-3). */
enum { FZM1_REF_JUDGEMENT = 0, FZM1_REF_DATA0 = 5, FZM1_REF_DATA7 = 12, FZM1_REF_FORMAT = 150 };

enum { FZM1_OK = 0, FZM1_NG = -1 };
enum { FZM1_NONE = 0, FZM1_HANDSHAKING = 1 };     /**< output control */
enum { FZM1_FIXED_POINT = 0, FZM1_FLOATING = 1 }; /**< output format */
enum { FZM1_DATA = 8, FZM1_UNITS = 8, FZM1_GROUPS = 32, FZM1_TEXT = 32 };
enum { FZM1_IMAGES = 16, FZM1_OUTPUTS = 16 };

/** Limits of the FZ family's values (OM-C6). */
#define FZM1_LARGEST 999999999.9999

enum { FZM1_SHORTEST_US = 100, FZM1_MINUTE_US = 60000000 };

enum { FZM1_SCENES = 128 }; /**< of a scene group */

/**
 * Sizes, smaller in a firmware for a board (ECT_SMALL). FZM1_KEPT: scenes of the current group in memory (about 620
 * bytes, twice); with fewer than FZM1_SCENES a switch reads the others, and only this number can be changed before a
 * save. FZM1_PREPARED: scenes that can be prepared (620 bytes). FZM1_TABLE: rows of the table (88 bytes). FZM1_TURNS:
 * places in the table, one for each scene and one for the rows of any scene. A board has no plant and needs one of
 * each.
 */
#ifdef ECT_SMALL
enum { FZM1_KEPT = 2, FZM1_PREPARED = 1, FZM1_TABLE = 1, FZM1_TURNS = 1 };
#else
enum { FZM1_KEPT = FZM1_SCENES, FZM1_PREPARED = 256, FZM1_TABLE = 256, FZM1_TURNS = FZM1_SCENES + 1 };
#endif

/** Source of a value, added to the scene's own; times have FIXED, RANDOM and TABLE. */
enum { FZM1_SOURCE_FIXED, FZM1_SOURCE_RAMP, FZM1_SOURCE_SINE, FZM1_SOURCE_RANDOM, FZM1_SOURCE_TABLE };

/** Causes of ERR, one bit each. */
typedef enum fzm1_error {
    FZM1_ERROR_NO_DSA = 0x01,
    FZM1_ERROR_DSA_STAYED = 0x02,
    FZM1_ERROR_LOST = 0x04,
    FZM1_ERROR_EXE = 0x08,
    FZM1_ERROR_BY_HAND = 0x10,
    FZM1_ERROR_ALL = 0x1F,
} fzm1_error_t;

/** Reason of a refusal. The plant has the texts. */
typedef enum fzm1_why {
    FZM1_DONE,
    FZM1_WHY_NO_UNIT,
    FZM1_WHY_NO_DATA,
    FZM1_WHY_JUDGEMENT_ONLY,
    FZM1_WHY_NOT_OUTPUT,
    FZM1_WHY_FORMAT_ONLY,
    FZM1_WHY_FORMAT_DATA,
    FZM1_WHY_NO_COMMAND,
    FZM1_WHY_RESTARTING,
    FZM1_WHY_TWO_COMMANDS,
    FZM1_WHY_EXECUTING,
    FZM1_WHY_BUSY_CONTINUOUS,
    FZM1_WHY_BUSY_MEASURING,
    FZM1_WHY_NO_EDGE,
    FZM1_WHY_UNREADY_RESTARTING,
    FZM1_WHY_UNREADY_NO_RUN,
    FZM1_WHY_UNREADY_CONTINUOUS,
    FZM1_WHY_UNREADY_SWITCHING,
    FZM1_WHY_UNREADY_IMAGE,
    FZM1_WHY_UNREADY_IMAGES,
    FZM1_WHY_NO_MEMORY,
    FZM1_WHY_MEMORY_SILENT,
    FZM1_WHY_MEMORY_FORGETS,
    FZM1_WHY_MEMORY_FULL,
    FZM1_WHY_CHANGED_FULL,
    FZM1_WHY_NO_SCENE,
    FZM1_WHY_NO_GROUP,
    FZM1_WHY_BUSY_BY_MASTER,
    FZM1_WHY_SAVING,
    FZM1_WHY_PREPARED_FULL,
    FZM1_WHY_DATA_RANGE,
    FZM1_WHY_NO_EXPRESSION,
    FZM1_WHY_JUDGEMENTS,
    FZM1_WHY_UNITS,
    FZM1_WHY_OUTPUT_UNIT,
    FZM1_WHY_FORMATS,
} fzm1_why_t;

/** The number of refusals, and the reason of the last one. */
typedef struct fzm1_refusal {
    uint32_t count;
    uint16_t why; /* fzm1_why_t */
} fzm1_refusal_t;

/** A scene: the flow of processing units, and their results. */
typedef struct fzm1_scene {
    double data[FZM1_DATA];
    int16_t judgement[FZM1_UNITS]; /* 1 OK, -1 NG */
    uint8_t units;                 /* in the flow */
    uint8_t output_unit;           /* number of Fieldbus Data Output, whose settings follow */
    uint8_t format;
    char comment[FZM1_DATA][FZM1_TEXT + 1];
    char expression[FZM1_DATA][FZM1_TEXT + 1]; /* "": the measured value of the same number */
} fzm1_scene_t;

/** A scene of the current group in memory. */
typedef struct fzm1_place {
    uint8_t number;
    bool changed; /* differs from the saved or prepared scene */
    fzm1_scene_t content;
} fzm1_place_t;

/** Scenes of a group. A scene without a place has its factory state; if `partial`, its prepared or saved state. */
typedef struct fzm1_group {
    fzm1_place_t places[FZM1_KEPT];
    uint8_t count;
    bool partial;
} fzm1_group_t;

/** Result of a measurement. */
typedef struct fzm1_result {
    double data[FZM1_DATA];
    int16_t judgement[FZM1_UNITS];
    int16_t overall;
    uint32_t row_processing_us; /* the table's value, 0: none */
} fzm1_result_t;

/** System data: the setting windows (§3-2). */
typedef struct fzm1_settings {
    uint8_t fieldbus; /* 0 OFF, 1 EtherCAT */
    uint8_t output_control;
    uint8_t output_repeat;  /* without handshaking and without a new result: repeat the last result */
    uint16_t output_period; /* 0.1 ms */
    uint16_t output_time;   /* 0.1 ms */
    uint16_t timeout;       /* 0.1 s */
    uint16_t exe_timeout;   /* 0.1 s, 0: none */
} fzm1_settings_t;

typedef struct fzm1_row {
    double data[FZM1_DATA];
    int16_t scene;                          /* -1: any */
    int16_t judgement;                      /* 0: separate for each unit */
    uint32_t image_input_us, processing_us; /* 0: as set */
} fzm1_row_t;

/** A scene that a user has prepared. */
typedef struct fzm1_prepared {
    uint8_t group, scene;
    fzm1_scene_t content;
} fzm1_prepared_t;

/** The surroundings, which outlast a restart: the switch on the front, the cameras and their view. */
typedef struct fzm1_plant {
    bool known;
    uint8_t node_address;
    uint8_t camera; /* 0: 0.3, 1: 2, 2: 5 million pixels */
    uint32_t image_input_us;
    uint32_t processing_us;
    uint8_t time_source;
    uint32_t image_input_spread_us; /* standard deviation */
    uint32_t processing_spread_us;
    uint32_t command_us;
    uint32_t switch_us;
    uint32_t start_ms;
    int16_t judgement; /* 0: separate for each unit */
    uint8_t source[FZM1_DATA];
    double amplitude[FZM1_DATA];
    uint32_t period[FZM1_DATA]; /* measurements */
    uint32_t seed;
    uint32_t random, time_random; /* two generators, so that values do not depend on the times */
    uint32_t shots;
    fzm1_row_t row; /* the next row to be added */
    uint16_t rows;
    fzm1_row_t table[FZM1_TABLE];
    uint16_t turns[FZM1_TURNS]; /* used rows, by their scene; the last element: rows of any scene */
    uint32_t sdo_abort;         /* abort code that refuses the next SDO request */
    fzm1_prepared_t edit;       /* the scene opened by the user */
    fzm1_prepared_t prepared[FZM1_PREPARED];
    uint16_t prepared_count;
} fzm1_plant_t;

/** A save under way. */
typedef struct fzm1_saving {
    uint8_t phase;
    uint16_t scene; /* next scene of the current group */
    uint32_t own;   /* its next scene in the previous record */
    uint32_t from;  /* next scene of the other groups in the previous record */
    ect_record_t to;
    uint64_t due_ns;
    fzm1_why_t failure; /* of the last one */
} fzm1_saving_t;

typedef struct fzm1 {
    ect_standard_t standard;
    ect_sync_data_t sync;

    /* process data */
    uint32_t control_in, command_code;
    int32_t parameter[3];
    uint32_t control_out, response_code, result_code;
    int32_t response_data;
    int32_t output[FZM1_DATA];

    const ect_host_t *host;
    uint64_t time_ns; /* all events up to this time are processed */
    uint32_t levels;  /* last control signals */
    bool levels_known;

    fzm1_settings_t settings;
    fzm1_scene_t scene;   /* the current one */
    fzm1_group_t group;   /* as of the last switch of a scene */
    fzm1_group_t loading; /* the next group while it is loaded; during a save: the current scene as written, first */
    uint8_t scene_number, scene_group;
    uint64_t switched_due_ns; /* switched manually: BUSY until this time */

    ect_record_t record; /* the saved one */
    int8_t record_found; /* 1 found; 0 none; -1 the memory has not responded */
    fzm1_saving_t saving;

    /* measurement */
    uint8_t run; /* RUN window shown */
    bool continuous;
    fzm1_result_t last;                /* all 0: no measurement yet */
    fzm1_result_t images[FZM1_IMAGES]; /* taken and waiting, oldest first */
    uint8_t first_image, image_count;
    uint64_t image_due_ns, processing_due_ns;

    /* command */
    bool executing, switching, flg;
    bool awaits_save;
    bool exe_fell;            /* since the command was taken */
    bool next_exe_fell;       /* since the next one was */
    uint32_t code, next_code; /* next_code: taken while the other is executed; 0: none */
    int32_t arguments[3];
    uint64_t command_due_ns, flg_due_ns;

    /* output */
    bool gate, dsa_was_off;
    bool to_repeat;    /* a result was output and not yet cleared */
    bool gate_changed; /* in this poll: without handshaking only one change, so that the master can read each */
    int32_t waiting[FZM1_OUTPUTS][FZM1_DATA];
    uint8_t first_output, output_count;
    uint64_t poll_ns; /* time of this poll */
    uint64_t gate_due_ns, next_output_ns, dsa_due_ns;

    /* restart */
    uint8_t starting; /* 0 no, 1 signals off, 2 off the bus */
    uint64_t start_due_ns;

    /* as signals */
    uint8_t ready, busy, overall_ng, err;
    uint16_t errors; /* fzm1_error_t, causes of `err` */
    uint8_t exe_level, step_level, dsa_level, gate_level, flg_level, continuous_level;
    uint8_t trigger, save, restart, row_add, row_clear;
    uint8_t saving_level, prepared_clear;
    uint32_t exposures, measurements, outputs, discarded, lost, saves;
    fzm1_refusal_t step_ignored, exe_ignored, refused, save_failed;

    fzm1_plant_t plant; /* outlasts power: see ect_plant_t */
} fzm1_t;

/* settings.c */
/* GATE must fall before the next output (OM-C13). */
static inline bool fzm1_time_fits(uint16_t output_time, uint16_t output_period)
{
    return output_time < output_period;
}
ect_reason_t fzm1_sdo_request(void *instance, uint16_t index, uint8_t subindex);
ect_reason_t fzm1_sdo_write(void *instance, uint16_t index, uint8_t subindex, const void *data, uint16_t size);
void fzm1_sdo_written(void *instance, uint16_t index, uint8_t subindex, uint64_t now_ns);

/* controller.c: functions called by the stack */
void fzm1_init(void *instance, const ect_host_t *host, uint64_t now_ns);
uint16_t fzm1_state_change(void *instance, uint8_t from, uint8_t to, uint64_t now_ns);
void fzm1_outputs(void *instance, uint64_t now_ns);
uint64_t fzm1_tick(void *instance, uint64_t now_ns);

/* commands.c */
void fzm1_exe(fzm1_t *u, bool rising);
void fzm1_command_due(fzm1_t *u);

/* restart.c */
void fzm1_all_off(fzm1_t *u);
void fzm1_begin_restart(fzm1_t *u);
void fzm1_restart_due(fzm1_t *u);

/* switch.c: each returns FZM1_DONE, or the reason of a refusal */
fzm1_why_t fzm1_switch_scene(fzm1_t *u, uint32_t number);
fzm1_why_t fzm1_switch_group(fzm1_t *u, uint32_t number);
fzm1_why_t fzm1_switch_by_hand(fzm1_t *u, bool group, uint32_t number);
void fzm1_switch_due(fzm1_t *u);
fzm1_why_t fzm1_edit_open(fzm1_t *u, uint8_t group, uint8_t scene); /* opens a scene in plant.edit */
fzm1_why_t fzm1_edit_change(fzm1_t *u, const fzm1_scene_t *content);

/* save.c */
fzm1_why_t fzm1_save(fzm1_t *u); /* begins */
bool fzm1_saving(const fzm1_t *u);
void fzm1_save_due(fzm1_t *u);
void fzm1_save_reset(fzm1_t *u); /* power-on: no save is under way */
void fzm1_load(fzm1_t *u);       /* at power-on */
/* Loads a group into u->group and one of its scenes into *scene, or only a scene, in its prepared or saved state.
 * @return false: the memory does not respond */
bool fzm1_load_group(fzm1_t *u, uint8_t group, uint8_t number, fzm1_scene_t *scene);
bool fzm1_load_scene(fzm1_t *u, uint8_t group, uint8_t number, fzm1_scene_t *scene);
bool fzm1_scene(fzm1_t *u, uint8_t number, fzm1_scene_t *scene); /* of the current group; likewise */
/* Changes a scene of the current group. */
fzm1_why_t fzm1_keep_scene(fzm1_t *u, uint8_t number, const fzm1_scene_t *content);

/* measure.c */
fzm1_why_t fzm1_not_ready(const fzm1_t *u); /* reason why READY is off */
bool fzm1_busy(const fzm1_t *u);
void fzm1_step(fzm1_t *u); /* READY is on */
void fzm1_measure_due(fzm1_t *u);
void fzm1_measure_put_off(fzm1_t *u, uint64_t ns); /* delays the present image input and processing */
void fzm1_start_continuous(fzm1_t *u);
void fzm1_clear(fzm1_t *u); /* returns to the state without a measurement */

/* output.c */
void fzm1_output_put(fzm1_t *u, const double *data); /* lost if sixteen results wait */
void fzm1_output_discard(fzm1_t *u);                 /* drops the waiting results */
void fzm1_output_begin(fzm1_t *u);                   /* begin of OP: DSA must first be off */
void fzm1_output_end(fzm1_t *u);                     /* end of OP: GATE falls, and the wait for DSA ends */
bool fzm1_output_step(fzm1_t *u); /* makes one possible change of GATE; @return whether GATE has changed */
void fzm1_output_due(fzm1_t *u);
void fzm1_output_reset(fzm1_t *u);
void fzm1_output_new_period(fzm1_t *u, uint16_t period); /* 0.1 ms; valid from the next output on */
uint64_t fzm1_output_next(const fzm1_t *u);
int32_t fzm1_fixed_point(double value);

/* view.c */
uint64_t fzm1_image_input_ns(fzm1_t *u); /* of the next image */
uint64_t fzm1_processing_ns(fzm1_t *u, const fzm1_result_t *image);
void fzm1_take_image(fzm1_t *u, fzm1_result_t *image);

/* group.c */
const fzm1_scene_t *fzm1_group_find(const fzm1_group_t *group, uint8_t number); /* NULL: the scene has no place */
void fzm1_group_add(fzm1_group_t *group, uint8_t number,
                    const fzm1_scene_t *content); /* unchanged; without a free place no effect */
/* Marks the scene as changed if `content` differs from `before`. @return false: all places have changed scenes */
bool fzm1_group_change(fzm1_group_t *group, uint8_t number, const fzm1_scene_t *before, const fzm1_scene_t *content);
void fzm1_group_saved(fzm1_group_t *group);

/* prepared.c */
fzm1_prepared_t *fzm1_prepared_find(fzm1_t *u, uint8_t group, uint8_t scene);            /* NULL: not prepared */
bool fzm1_prepare(fzm1_t *u, uint8_t group, uint8_t scene, const fzm1_scene_t *content); /* false: no room */
void fzm1_prepared_forget(fzm1_t *u, uint8_t group);

/* scene.c */
void fzm1_default_scene(fzm1_scene_t *scene);
fzm1_why_t fzm1_scene_fault(const fzm1_scene_t *scene); /* FZM1_DONE: valid */

/* expression.c */
/* @return false: `text` is no expression; *value is then unchanged */
bool fzm1_expression(const char *text, const fzm1_result_t *of, double *value);

/* error.c */
void fzm1_set_error(fzm1_t *u, fzm1_error_t error);
void fzm1_end_errors(fzm1_t *u, unsigned int errors); /* FZM1_ERROR_... */
void fzm1_refuse(fzm1_refusal_t *refusal, fzm1_why_t why);

/* fields.c */
extern const ect_field_t fzm1_fields[]; /* for the plant */

#endif
