/* SPDX-License-Identifier: MIT */
/* The user's side: settings, scene, plant and results by name, and the effect of setting them. */
#include <string.h>

#include "devices/fzm1/fzm1.h"
#include "devices/fzm1/instance.h"

#define R(member, name, kind, minimum, maximum, unit, meaning)                                                         \
    ECT_SIGNAL(fzm1_t, member, name, kind, READ, minimum, maximum, unit, meaning)
#define W(member, name, kind, minimum, maximum, unit, meaning)                                                         \
    ECT_SIGNAL(fzm1_t, member, name, kind, WRITE, minimum, maximum, unit, meaning)
#define CHOICE(member, name, maximum, turn, meaning) ECT_SIGNAL_CHOICE(fzm1_t, member, name, 0, maximum, turn, meaning)

#define LARGEST 999999999

enum { CAUSE = 96 }; /* the longest */

/* A scene, at `base` in the instance. */
#define SCENE_DATA(base, n)                                                                                            \
    W(base.data[n - 1], "data" #n, REAL, -LARGEST, LARGEST, NULL, "measured value D" #n " of the scene")
#define SCENE_COMMENT(base, n) W(base.comment[n - 1], "comment" #n, TEXT, 0, FZM1_TEXT, NULL, "comment on data " #n)
#define SCENE_EXPRESSION(base, n)                                                                                      \
    W(base.expression[n - 1], "expression" #n, TEXT, 0, FZM1_TEXT, NULL,                                               \
      "data " #n " of D1 to D8, JG, JG0 to JG7, numbers, + - * / ( ); empty: D" #n)
#define SCENE(base)                                                                                                    \
    EIGHT_OF(SCENE_DATA, base), W(base.units, "units", U8, 1, FZM1_UNITS, NULL, "processing units in the flow"),       \
        W(base.output_unit, "output_unit", U8, 0, FZM1_UNITS - 1, NULL,                                                \
          "number of the unit that is Fieldbus Data Output"),                                                          \
        JUDGEMENTS(base), W(base.format, "output_format", U8, 0, 1, NULL, "0 fixed point, 1 floating point"),          \
        EIGHT_OF(SCENE_EXPRESSION, base), EIGHT_OF(SCENE_COMMENT, base)
#define JUDGEMENT(base, n)                                                                                             \
    W(base.judgement[n], "judgement" #n, I16, -1, 1, NULL, "judgement of unit " #n ": 1 OK, -1 NG")
#define JUDGEMENTS(base)                                                                                               \
    JUDGEMENT(base, 0), JUDGEMENT(base, 1), JUDGEMENT(base, 2), JUDGEMENT(base, 3), JUDGEMENT(base, 4),                \
        JUDGEMENT(base, 5), JUDGEMENT(base, 6), JUDGEMENT(base, 7)
#define EIGHT_OF(F, base) F(base, 1), F(base, 2), F(base, 3), F(base, 4), F(base, 5), F(base, 6), F(base, 7), F(base, 8)

#define SOURCE(n)                                                                                                      \
    W(plant.source[n - 1], "source" #n, U8, 0, 4, NULL,                                                                \
      "data " #n ": 0 as it is, plus 1 ramp, 2 sine, 3 random; 4 from the table")
#define AMPLITUDE(n) W(plant.amplitude[n - 1], "amplitude" #n, REAL, -LARGEST, LARGEST, NULL, "of ramp, sine, random")
#define PERIOD(n)    W(plant.period[n - 1], "period" #n, U32, 1, INT32_MAX, "measurements", "of ramp and sine")
#define ROW(n)       W(plant.row.data[n - 1], "row" #n, REAL, -LARGEST, LARGEST, NULL, "data " #n " of the next row")
#define RESULT(n)                                                                                                      \
    R(last.data[n - 1], "result" #n, REAL, -LARGEST - 1, LARGEST + 1, NULL, "data " #n " of the last measurement")
#define OUTPUT(n) R(output[n - 1], "output" #n, I32, INT32_MIN, INT32_MAX, NULL, "data " #n " in the output area")
#define EIGHT(F)  F(1), F(2), F(3), F(4), F(5), F(6), F(7), F(8)

static const ect_signal_t signals[] = {
    W(trigger, "trigger", BOOL, 0, 1, NULL, "writing 1 measures, as the rising edge of STEP does"),
    CHOICE(scene_number, "scene", FZM1_SCENES - 1, 2, "current scene"),
    CHOICE(scene_group, "scene_group", FZM1_GROUPS - 1, 1, "current scene group; begins with its scene 0"),
    W(plant.judgement, "judgement", I16, -1, 1, NULL,
      "of all units, in the next measurements: 0 each its own, 1 OK, -1 NG"),
    W(run, "run", BOOL, 0, 1, NULL, "RUN window shown; without it nothing is measured"),
    W(err, "err", BOOL, 0, 1, NULL, "controller error; writing sets or clears it"),
    W(plant.camera, "camera", U8, 0, 2, NULL, "0: 0.3, 1: 2, 2: 5 million pixels; 16, 4, 1 images may wait"),
    W(plant.node_address, "node_address", U8, 0, 9, NULL, "switch on the front; takes effect at the next restart"),

    W(settings.fieldbus, "fieldbus", BOOL, 0, 1, NULL, "0 OFF, 1 EtherCAT; saved, from the next restart on"),
    W(settings.output_control, "output_control", U8, 0, 1, NULL, "0 None, 1 Handshaking"),
    W(settings.output_period, "output_period", U16, 20, 50000, "0.1 ms", "None: time from one output to the next"),
    W(settings.output_time, "output_time", U16, 10, 10000, "0.1 ms", "None: time with GATE on"),
    W(settings.output_repeat, "output_repeat", BOOL, 0, 1, NULL,
      "None: the last result again when there is no new one"),
    W(settings.timeout, "timeout", U16, 5, 1200, "0.1 s", "Handshaking: longest wait for DSA"),
    W(settings.exe_timeout, "exe_timeout", U16, 0, 1200, "0.1 s", "longest time with EXE on after FLG; 0: no limit"),

    SCENE(scene),
    EIGHT(SOURCE),
    EIGHT(AMPLITUDE),
    EIGHT(PERIOD),
    W(plant.seed, "seed", U32, 1, INT32_MAX, NULL, "random seed; a write restarts the random values"),
    EIGHT(ROW),
    W(plant.row.scene, "row_scene", I16, -1, FZM1_SCENES - 1, NULL,
      "scene of the next row; -1: of those without rows of their own"),
    W(plant.row.judgement, "row_judgement", I16, -1, 1, NULL, "judgement of the next row; 0: each unit its own"),
    W(plant.row.image_input_us, "row_image_input", U32, 0, FZM1_MINUTE_US, "us", "of the next row; 0 as set"),
    W(plant.row.processing_us, "row_processing", U32, 0, FZM1_MINUTE_US, "us", "of the next row; 0 as set"),
    W(row_add, "row_add", BOOL, 0, 1, NULL, "writing 1 adds the row_ signals and row1 to row8 to the table as a row"),
    W(row_clear, "row_clear", BOOL, 0, 1, NULL, "writing 1 empties the table"),
    R(plant.rows, "rows", U16, 0, FZM1_TABLE, NULL,
      "rows of the table; the measurements of a scene use its rows in a loop"),

    W(plant.image_input_us, "image_input", U32, FZM1_SHORTEST_US, FZM1_MINUTE_US, "us",
      "time with READY off for a camera image"),
    W(plant.processing_us, "processing", U32, FZM1_SHORTEST_US, FZM1_MINUTE_US, "us", "time to measure an image"),
    W(plant.time_source, "time_source", U8, 0, 4, NULL,
      "image_input and processing: 0 as set, 3 random (normal), 4 from the table"),
    W(plant.image_input_spread_us, "image_input_spread", U32, 0, FZM1_MINUTE_US, "us", "standard deviation, if random"),
    W(plant.processing_spread_us, "processing_spread", U32, 0, FZM1_MINUTE_US, "us", "standard deviation, if random"),
    W(plant.command_us, "command_time", U32, 0, FZM1_MINUTE_US, "us", "from EXE to FLG"),
    W(plant.switch_us, "switch_time", U32, 0, FZM1_MINUTE_US, "us", "time with BUSY on to switch a scene or group"),
    W(plant.start_ms, "start_time", U32, 1, 600000, "ms", "time off the bus in a restart"),
    W(plant.sdo_abort, "sdo_abort", U32, 0, INT32_MAX, NULL, "abort code that refuses the next SDO request; 0 none"),
    W(save, "save", BOOL, 0, 1, NULL, "writing 1 saves to the unit: `saves` or `saves_failed` counts at its end"),
    W(restart, "restart", BOOL, 0, 1, NULL, "writing 1 restarts the controller"),

    R(exe_level, "exe", BOOL, 0, 1, NULL, "EXE, from the master"),
    R(step_level, "step", BOOL, 0, 1, NULL, "STEP, from the master"),
    R(dsa_level, "dsa", BOOL, 0, 1, NULL, "DSA, from the master"),
    R(ready, "ready", BOOL, 0, 1, NULL, "READY"),
    R(busy, "busy", BOOL, 0, 1, NULL, "BUSY"),
    R(flg_level, "flg", BOOL, 0, 1, NULL, "FLG"),
    R(gate_level, "gate", BOOL, 0, 1, NULL, "GATE"),
    R(overall_ng, "or", BOOL, 0, 1, NULL, "OR: the overall judgement is NG"),
    R(continuous_level, "continuous", BOOL, 0, 1, NULL, "continuous measurement"),
    R(errors, "error_cause", DESCRIBED, 0, CAUSE, NULL, "causes of ERR"),
    R(step_ignored.count, "steps_ignored", U32, 0, INT32_MAX, NULL, "edges of STEP that measured nothing"),
    R(step_ignored.why, "step_ignored_cause", DESCRIBED, 0, CAUSE, NULL,
      "reason why the last of these edges measured nothing"),
    R(exe_ignored.count, "exes_ignored", U32, 0, INT32_MAX, NULL, "edges of EXE that began no command"),
    R(exe_ignored.why, "exe_ignored_cause", DESCRIBED, 0, CAUSE, NULL,
      "reason why the last of these edges began no command"),
    R(refused.count, "commands_refused", U32, 0, INT32_MAX, NULL, "commands refused with response code -1"),
    R(refused.why, "command_refused_cause", DESCRIBED, 0, CAUSE, NULL, "reason of the last refusal"),
    R(saving_level, "saving", BOOL, 0, 1, NULL, "the unit is being saved"),
    R(saves, "saves", U32, 0, INT32_MAX, NULL, "complete saves"),
    R(save_failed.count, "saves_failed", U32, 0, INT32_MAX, NULL, "saves that failed"),
    R(save_failed.why, "save_failed_cause", DESCRIBED, 0, CAUSE, NULL, "reason of the last failure"),
    R(exposures, "exposures", U32, 0, INT32_MAX, NULL, "image inputs begun since power-on"),
    R(measurements, "measurements", U32, 0, INT32_MAX, NULL, "since power-on"),
    R(outputs, "outputs", U32, 0, INT32_MAX, NULL, "data output since power-on"),
    R(discarded, "discarded", U32, 0, INT32_MAX, NULL, "results dropped without DSA or by Clear"),
    R(lost, "lost", U32, 0, INT32_MAX, NULL, "results lost because 16 others waited for output"),
    R(image_count, "images", U8, 0, FZM1_IMAGES, NULL, "images that wait to be measured"),
    R(output_count, "pending", U8, 0, FZM1_OUTPUTS, NULL, "results that wait to be output"),
    R(last.overall, "overall", I16, -1, 1, NULL, "overall judgement of the last measurement, 0: none"),
    EIGHT(RESULT),
    EIGHT(OUTPUT),
};

/* Any scene of any group, present or not: `group` and `scene` open it, the others change it at once. */
static const ect_signal_t edit[] = {
    CHOICE(plant.edit.group, "group", FZM1_GROUPS - 1, 1, "group of the scene to read and to change"),
    CHOICE(plant.edit.scene, "scene", FZM1_SCENES - 1, 2, "number of the scene; a write of group or scene opens it"),
    SCENE(plant.edit.content),
    R(plant.prepared_count, "prepared", U16, 0, FZM1_PREPARED, NULL, "scenes changed here and not saved"),
    W(prepared_clear, "clear", BOOL, 0, 1, NULL, "writing 1 discards them when their group is loaded again"),
};

static const ect_signal_group_t groups[] = {
    {.signal_count = sizeof signals / sizeof signals[0], .signals = signals},
    {.prefix = "edit", .signal_count = sizeof edit / sizeof edit[0], .signals = edit},
};

#define IS(signal, member) ((signal)->offset == offsetof(fzm1_t, member))

/* --- texts -------------------------------------------------------------------------------------------------------- */

/* Texts of the reasons; empty: no refusal. */
static const char *in_words(fzm1_why_t why)
{
    static const char *const words[] = {
        [FZM1_DONE] = "",
        [FZM1_WHY_NO_UNIT] = "the scene has no such unit",
        [FZM1_WHY_NO_DATA] = "units have no data of this number",
        [FZM1_WHY_JUDGEMENT_ONLY] = "the unit is not Fieldbus Data Output, and has its judgement only",
        [FZM1_WHY_NOT_OUTPUT] = "the unit is not Fieldbus Data Output: nothing of it can be set",
        [FZM1_WHY_FORMAT_ONLY] = "only the output format, number 150, can be set",
        [FZM1_WHY_FORMAT_DATA] = "the output format is 0 or 1, as a thousandfold 0 or 1000",
        [FZM1_WHY_NO_COMMAND] = "there is no such command code",
        [FZM1_WHY_RESTARTING] = "the controller restarts",
        [FZM1_WHY_TWO_COMMANDS] = "two commands are under way already",
        [FZM1_WHY_EXECUTING] = "another command is executed",
        [FZM1_WHY_BUSY_CONTINUOUS] = "BUSY is on: a continuous measurement runs",
        [FZM1_WHY_BUSY_MEASURING] = "BUSY is on: a measurement runs",
        [FZM1_WHY_NO_EDGE] = "it was on when OP began: no edge",
        [FZM1_WHY_UNREADY_RESTARTING] = "READY is off: the controller restarts",
        [FZM1_WHY_UNREADY_NO_RUN] = "READY is off: the RUN window is not shown",
        [FZM1_WHY_UNREADY_CONTINUOUS] = "READY is off: a continuous measurement runs",
        [FZM1_WHY_UNREADY_SWITCHING] = "READY is off: a scene is being switched",
        [FZM1_WHY_UNREADY_IMAGE] = "READY is off: an image is being taken in",
        [FZM1_WHY_UNREADY_IMAGES] = "READY is off: as many images wait as the camera may have",
        [FZM1_WHY_NO_MEMORY] = "there is no memory: start the twin with --store DIR",
        [FZM1_WHY_MEMORY_SILENT] = "the memory does not answer",
        [FZM1_WHY_MEMORY_FORGETS] = "the memory does not keep writes",
        [FZM1_WHY_MEMORY_FULL] = "the memory does not respond, or has no space for all scenes",
        [FZM1_WHY_CHANGED_FULL] = "as many scenes are changed as there is room for: save them first",
        [FZM1_WHY_NO_SCENE] = "there is no such scene",
        [FZM1_WHY_NO_GROUP] = "there is no such scene group",
        [FZM1_WHY_BUSY_BY_MASTER] = "BUSY is on: a measurement or a command of the master is under way",
        [FZM1_WHY_SAVING] = "the unit is being saved",
        [FZM1_WHY_PREPARED_FULL] = ("as many scenes are prepared as there is room for: 'save' keeps those of the "
                                    "current group, 'edit.clear' forgets all"),
        [FZM1_WHY_DATA_RANGE] = "data go from -999999999.9999 to 999999999.9999",
        [FZM1_WHY_NO_EXPRESSION] = "no expression: D1 to D8, JG, JG0 to JG7, numbers, + - * / ( )",
        [FZM1_WHY_JUDGEMENTS] = "a unit finds 1 (OK) or -1 (NG)",
        [FZM1_WHY_UNITS] = "a flow has 1 to 8 units",
        [FZM1_WHY_OUTPUT_UNIT] =
            "'output_unit' has to be one of the flow's: the number of 'units' is one more than the last one's",
        [FZM1_WHY_FORMATS] = "the output format is 0 or 1",
    };
    return words[why];
}

/* Appends a text, truncated at the end of the room. */
static void append(char *to, const char *text)
{
    size_t used = strlen(to);
    size_t length = strlen(text);
    length = length < CAUSE - used ? length : CAUSE - used;
    memcpy(to + used, text, length);
    to[used + length] = 0;
}

static void append_errors(char *text, uint16_t errors)
{
    static const char *const causes[] = {"no DSA", "DSA stayed on", "results lost: 16 wait already", "EXE stayed on",
                                         "set manually"};
    for (unsigned int i = 0; i < sizeof causes / sizeof causes[0]; i++) {
        if ((errors >> i & 1) == 0)
            continue;
        append(text, text[0] ? "; " : "");
        append(text, causes[i]);
    }
}

static void signal_describe(const ect_signal_t *signal, uint16_t value, char *text)
{
    text[0] = 0;
    if (IS(signal, errors))
        append_errors(text, value);
    else
        append(text, in_words((fzm1_why_t)value));
}

/* --- from the user ------------------------------------------------------------------------------------------------ */

/* The abort codes of an FZM1 (Q179 §1-1). */
static bool known_abort(uint32_t code)
{
    static const uint32_t codes[] = {0x05030000, 0x05040000, 0x05040001, 0x05040005, 0x06010000, 0x06010001, 0x06010002,
                                     0x06020000, 0x06040041, 0x06040042, 0x06040043, 0x06040047, 0x06060000, 0x06070010,
                                     0x06070012, 0x06070013, 0x06090011, 0x06090030, 0x06090031, 0x06090032, 0x06090036,
                                     0x08000000, 0x08000020, 0x08000021, 0x08000022, 0x08000023};
    for (unsigned int i = 0; i < sizeof codes / sizeof codes[0]; i++) {
        if (codes[i] == code)
            return true;
    }
    return code == 0;
}

static const char *add_row(fzm1_t *u)
{
    if (u->plant.rows == FZM1_TABLE)
        return "the table is full: empty it with row_clear";
    u->plant.table[u->plant.rows++] = u->plant.row;
    return "";
}

static const char *clear_rows(fzm1_t *u)
{
    u->plant.rows = 0;
    memset(u->plant.turns, 0, sizeof u->plant.turns);
    return "";
}

static const char *clear_prepared(fzm1_t *u)
{
    u->plant.prepared_count = 0;
    return "";
}

static const char *save(fzm1_t *u)
{
    return in_words(fzm1_saving(u) ? FZM1_WHY_SAVING : fzm1_save(u));
}

static const char *trigger(fzm1_t *u)
{
    fzm1_why_t why = fzm1_not_ready(u);
    if (why == FZM1_DONE)
        fzm1_step(u);
    return in_words(why);
}

static const char *restart(fzm1_t *u)
{
    if (u->starting == 0)
        fzm1_begin_restart(u);
    return "";
}

/* Handles buttons: 1 presses, 0 has no effect. @return NULL: another signal */
static const char *press(fzm1_t *u, const ect_signal_t *signal, uint8_t value)
{
    static const struct {
        uint32_t offset;
        const char *(*action)(fzm1_t *u);
    } buttons[] = {{offsetof(fzm1_t, trigger), trigger},      {offsetof(fzm1_t, save), save},
                   {offsetof(fzm1_t, restart), restart},      {offsetof(fzm1_t, row_add), add_row},
                   {offsetof(fzm1_t, row_clear), clear_rows}, {offsetof(fzm1_t, prepared_clear), clear_prepared}};
    for (size_t i = 0; i < sizeof buttons / sizeof buttons[0]; i++) {
        if (signal->offset == buttons[i].offset)
            return value ? buttons[i].action(u) : "";
    }
    return NULL;
}

/* Handles scenes to switch to, or to open. @return NULL: another signal */
static const char *choose(fzm1_t *u, const ect_signal_t *signal, uint8_t number)
{
    fzm1_why_t why;
    if (IS(signal, scene_number) || IS(signal, scene_group))
        why = fzm1_switch_by_hand(u, IS(signal, scene_group), number);
    else if (IS(signal, plant.edit.group))
        why = fzm1_edit_open(u, number, u->plant.edit.scene);
    else if (IS(signal, plant.edit.scene))
        why = fzm1_edit_open(u, u->plant.edit.group, number);
    else
        return NULL;
    return in_words(why);
}

static const char *write_byte(fzm1_t *u, const ect_signal_t *signal, uint8_t value)
{
    if (IS(signal, err) && value)
        fzm1_set_error(u, FZM1_ERROR_BY_HAND);
    if (IS(signal, err) && !value)
        fzm1_end_errors(u, FZM1_ERROR_ALL);
    if (IS(signal, run) && !value)
        u->continuous = false;
    if (IS(signal, settings.output_control) && value != u->settings.output_control)
        fzm1_output_reset(u);
    const char *chosen = choose(u, signal, value);
    return chosen ? chosen : press(u, signal, value);
}

static const char *write_number(fzm1_t *u, const ect_signal_t *signal, uint32_t value)
{
    if (IS(signal, settings.output_period) && !fzm1_time_fits(u->settings.output_time, (uint16_t)value))
        return "the output time must be shorter than the period: set 'output_time' first";
    if (IS(signal, settings.output_time) && !fzm1_time_fits((uint16_t)value, u->settings.output_period))
        return "the output time must be shorter than the period: set 'output_period' first";
    if (IS(signal, plant.sdo_abort) && !known_abort(value))
        return "not one of the 26 abort codes of the FZM1";
    if (IS(signal, settings.output_period))
        fzm1_output_new_period(u, (uint16_t)value);
    return NULL;
}

/* --- scenes ------------------------------------------------------------------------------------------------------- */

static bool inside(const ect_signal_t *signal, size_t scene)
{
    return signal->offset >= scene && signal->offset < scene + sizeof(fzm1_scene_t);
}

/* Checks a value of a scene at `base` in the instance for consistency with the other values. */
static const char *write_scene(fzm1_t *u, const ect_signal_t *signal, size_t base, const void *value)
{
    static const size_t sizes[] = {[ECT_SIGNAL_U8] = 1, [ECT_SIGNAL_I16] = 2, [ECT_SIGNAL_REAL] = sizeof(double)};
    size_t size = signal->type == ECT_SIGNAL_TEXT ? (size_t)signal->maximum + 1 : sizes[signal->type];
    fzm1_scene_t scene;
    memcpy(&scene, (uint8_t *)u + base, sizeof scene);
    memcpy((uint8_t *)&scene + (signal->offset - base), value, size);
    fzm1_why_t why = fzm1_scene_fault(&scene);
    if (why != FZM1_DONE)
        return in_words(why);
    return base == offsetof(fzm1_t, scene) ? NULL : in_words(fzm1_edit_change(u, &scene));
}

static const char *signal_write(void *instance, const ect_signal_t *signal, uint16_t number, const void *value,
                                uint64_t now_ns)
{
    static const size_t scenes[] = {offsetof(fzm1_t, scene), offsetof(fzm1_t, plant.edit.content)};
    fzm1_t *u = instance;
    uint16_t half;
    uint32_t word;
    (void)number;
    (void)fzm1_tick(u, now_ns);
    for (unsigned int i = 0; i < 2; i++) {
        if (inside(signal, scenes[i]))
            return write_scene(u, signal, scenes[i], value);
    }
    switch (signal->type) {
    case ECT_SIGNAL_BOOL:
    case ECT_SIGNAL_U8:
        return write_byte(u, signal, *(const uint8_t *)value);
    case ECT_SIGNAL_U16:
        memcpy(&half, value, sizeof half);
        return write_number(u, signal, half);
    case ECT_SIGNAL_U32:
        memcpy(&word, value, sizeof word);
        return write_number(u, signal, word);
    default:
        return NULL;
    }
}

static void signal_written(void *instance, const ect_signal_t *signal, uint16_t number, uint64_t now_ns)
{
    fzm1_t *u = instance;
    (void)number;
    (void)now_ns;
    if (IS(signal, plant.seed))
        u->plant.random = u->plant.time_random = u->plant.seed;
}

static uint16_t station_alias(const void *instance)
{
    const fzm1_t *u = instance;
    return u->plant.node_address;
}

static bool unfinished(const void *instance)
{
    return fzm1_saving(instance);
}

const ect_plant_t ect_fzm1_plant = {
    .signal_groups = groups,
    .signal_group_count = sizeof groups / sizeof groups[0],
    .outside_offset = offsetof(fzm1_t, plant),
    .outside_size = sizeof(fzm1_plant_t),
    .station_alias = station_alias,
    .unfinished = unfinished,
    .signal_write = signal_write,
    .signal_written = signal_written,
    .signal_describe = signal_describe,
    .fields = fzm1_fields,
};
