/* SPDX-License-Identifier: MIT */
/* The operator's side of a base unit: its signals `bu.*` and `ru1.*` .. `ru8.*`, and the effect of setting them. */
#include <string.h>

#include "devices/eclink/eclink.h"
#include "devices/eclink/instance.h"

#define COUNT(array) (sizeof(array) / sizeof((array)[0]))
#define BU(access, member, name, kind, minimum, maximum, unit, meaning)                                                \
    ECT_SIGNAL(eclink_bu_t, member, name, kind, access, minimum, maximum, unit, meaning)
#define RU(access, member, name, kind, minimum, maximum, unit, meaning)                                                \
    ECT_SIGNAL(eclink_ru_t, member, name, kind, access, minimum, maximum, unit, meaning)

static const ect_signal_t bu_signals[] = {
    BU(WRITE, enabled, "enabled", BOOL, 0, 1, NULL, "0: mode Disabled, no reply over EtherCAT or Modbus"),
    BU(WRITE, vlaps, "vlaps", U8, 0, 3, NULL, "VLAPs connected"),
    BU(WRITE, eg_link, "eg_link", U8, 0, 7, NULL, "EG-Link status, values of TS-0007 8.2; 2 to 5 are errors"),
    BU(WRITE, failed, "failed", BOOL, 0, 1, NULL, "self-diagnostics has found a fatal error"),
    BU(WRITE, module_error, "module_error", BOOL, 0, 1, NULL, "the fieldbus module reports an error"),
    BU(WRITE, report_passive, "report_passive", BOOL, 0, 1, NULL, "byte 36 is 6 instead of 0 while no RU is armed"),
    BU(WRITE, lock_errors, "lock_errors", BOOL, 0, 1, NULL,
       "an EC-Link error after the first good exchange stays until 'restart' (TS-0007 11 read strictly)"),
    BU(WRITE, command_lifetime_ms, "command_lifetime", U32, 0, 86400000, "ms",
       "drop commands from remote units that wait longer than this; 0: keep them"),
    BU(WRITE, frozen, "frozen", BOOL, 0, 1, NULL, "PCI and all input data do not change, the bus stays in OP"),
    BU(WRITE, restart, "restart", BOOL, 0, 1, NULL, "writing 1 cycles the power"),
    BU(READ, state, "state", U8, 0, 17, NULL, "BU state, values of TS-0007 8.1"),
    BU(READ, ec_link, "ec_link", U8, 0, 7, NULL, "EC-Link status"),
    BU(READ, es_link, "es_link", BOOL, 0, 1, NULL, "ES-Link relays closed"),
    BU(READ, armed, "armed", U8, 0, 3, NULL, "armed remote units"),
    BU(READ, unarmed, "unarmed", U8, 0, 8, NULL, "remote units in communication that are not armed"),
    BU(READ, fault, "message", DESCRIBED, 0, 19, NULL, "message on the display"),
    BU(READ, cause, "cause", DESCRIBED, 0, 63, NULL, "cause of a BU state other than Armed and Disarmed"),
    BU(READ, modbus, "modbus", BOOL, 0, 1, NULL, "a controller works over Modbus TCP"),
    BU(READ, pci, "pci", U8, 0, 255, NULL, "PCI"),
    BU(READ, cci, "cci", U8, 0, 255, NULL, "CCI"),
    BU(READ, pai, "pai", U8, 0, 255, NULL, "PAI"),
    BU(READ, cai, "cai", U8, 0, 255, NULL, "CAI"),
    BU(READ, overflows, "overflows", U32, 0, UINT32_MAX, NULL, "commands from remote units refused: queue full"),
    BU(READ, commands_lost, "commands_lost", U32, 0, UINT32_MAX, NULL,
       "commands from the controller skipped by CCO before CAI acknowledged them"),
    BU(READ, commands_unknown, "commands_unknown", U32, 0, UINT32_MAX, NULL,
       "commands from the controller to an id that no remote unit has"),
    BU(READ, commands_unreached, "commands_unreached", U32, 0, UINT32_MAX, NULL,
       "commands from the controller that CAI acknowledged and no remote unit in communication received"),
    BU(READ, commands_expired, "commands_expired", U32, 0, UINT32_MAX, NULL,
       "commands from remote units dropped after 'command_lifetime'"),
    BU(READ, cco_resyncs, "cco_resyncs", U32, 0, UINT32_MAX, NULL,
       "first outputs after an interruption whose CCO was taken as a start, not as a command"),
    BU(READ, pco_jumps, "pco_jumps", U32, 0, UINT32_MAX, NULL, "changes of PCO by another step than +1"),
    BU(READ, periodic_sets, "periodic_sets", U32, 0, UINT32_MAX, NULL, "complete sets of periodic data"),
    BU(READ, periodic_size, "periodic_size", U16, 0, 51200, "bytes", "size of the last complete set"),
    BU(READ, periodic_check, "periodic_check", U32, 0, UINT32_MAX, NULL, "CRC-32 of the last complete set"),
    BU(READ, periodic_pending, "periodic_pending", U16, 0, 51200, "bytes", "size of the set under assembly; 0: none"),
    BU(READ, periodic_missing, "periodic_missing", U16, 0, 256, "blocks", "missing in the set under assembly"),
    BU(READ, periodic_unfinished, "periodic_unfinished", U32, 0, UINT32_MAX, NULL, "sets that never became complete"),
    BU(READ, periodic_lost, "periodic_lost", U32, 0, UINT32_MAX, "blocks",
       "missing in the sets that never became complete"),
    BU(READ, periodic_skipped, "periodic_skipped", U32, 0, UINT32_MAX, "blocks", "of sets without their block 0"),
    BU(READ, periodic_errors, "periodic_errors", U32, 0, UINT32_MAX, NULL, "impossible sizes and block numbers"),
};

static const ect_signal_t ru_signals[] = {
    RU(WRITE, id, "id", U16, 1, 65535, NULL, "unique id"),
    RU(WRITE, on, "on", BOOL, 0, 1, NULL, "switched on and in range"),
    RU(WRITE, armed, "armed", BOOL, 0, 1, NULL, "armed by the operator"),
    RU(WRITE, stop, "stop", BOOL, 0, 1, NULL, "stop switch pressed"),
    RU(WRITE, shock, "shock", BOOL, 0, 1, NULL, "free fall or shock detected"),
    RU(WRITE, failed, "failed", BOOL, 0, 1, NULL, "internal error"),
    RU(WRITE, disabled, "disabled", U8, 0, 3, NULL, "movements: 0 enabled, disabled by 1 tilt, 2 inactivity, 3 popup"),
    RU(WRITE, battery, "battery", U8, 0, 100, "%", "battery level"),
    RU(WRITE, rssi, "rssi", U8, 0, 100, "%", "C-Link signal strength"),
    RU(WRITE, cable, "cable", BOOL, 0, 1, NULL, "operates on cable"),
    RU(WRITE, docked, "docked", BOOL, 0, 1, NULL, "in the docking station"),
    RU(WRITE, g_link_lost, "g_link_lost", BOOL, 0, 1, NULL, "out of reach of G-Link"),
    RU(WRITE, joystick[0], "joystick1", I16, -1000, 1000, NULL, "joystick 1, centre 0"),
    RU(WRITE, joystick[1], "joystick2", I16, -1000, 1000, NULL, "joystick 2, centre 0"),
    RU(WRITE, joystick[2], "joystick3", I16, -1000, 1000, NULL, "joystick 3, centre 0"),
    RU(WRITE, joystick[3], "joystick4", I16, -1000, 1000, NULL, "joystick 4, centre 0"),
    RU(WRITE, switches[0], "switch1", I16, -1, 1000, NULL, "switch 1, range as fitted"),
    RU(WRITE, switches[1], "switch2", I16, -1, 1000, NULL, "switch 2, range as fitted"),
    RU(WRITE, switches[2], "switch3", I16, -1, 1000, NULL, "switch 3, range as fitted"),
    RU(WRITE, switches[3], "switch4", I16, -1, 1000, NULL, "switch 4, range as fitted"),
    RU(WRITE, switches[4], "switch5", I16, -1, 1000, NULL, "switch 5, range as fitted"),
    RU(WRITE, switches[5], "switch6", I16, -1, 1000, NULL, "switch 6, range as fitted"),
    RU(WRITE, switches[6], "switch7", I16, -1, 1000, NULL, "switch 7, range as fitted"),
    RU(WRITE, switches[7], "switch8", I16, -1, 1000, NULL, "switch 8, range as fitted"),
    RU(WRITE, fitted[0], "fitted1", U8, 0, 6, NULL,
       "equipment of position 1: 0 nothing, 1 pushbutton, 2 two positions, 3 three positions, 4 potentiometer, 5 "
       "pushbutton with LED, 6 dual "
       "LED"),
    RU(WRITE, fitted[1], "fitted2", U8, 0, 6, NULL, "equipment of position 2, as fitted1"),
    RU(WRITE, fitted[2], "fitted3", U8, 0, 6, NULL, "equipment of position 3, as fitted1"),
    RU(WRITE, fitted[3], "fitted4", U8, 0, 6, NULL, "equipment of position 4, as fitted1"),
    RU(WRITE, fitted[4], "fitted5", U8, 0, 6, NULL, "equipment of position 5, as fitted1"),
    RU(WRITE, fitted[5], "fitted6", U8, 0, 6, NULL, "equipment of position 6, as fitted1"),
    RU(WRITE, fitted[6], "fitted7", U8, 0, 6, NULL, "equipment of position 7, as fitted1"),
    RU(WRITE, fitted[7], "fitted8", U8, 0, 6, NULL, "equipment of position 8, as fitted1"),
    RU(WRITE, encoder, "encoder", U8, 0, 255, NULL, "encoder value, wraps"),
    RU(WRITE, encoder_switch, "encoder_switch", BOOL, 0, 1, NULL, "encoder pushed down"),
    RU(WRITE, command, "command", BYTES, 0, ECLINK_COMMAND_BYTES, NULL, "a write sends a command to the controller"),
    RU(READ, state, "state", U8, 0, 5, NULL, "RU state, values of TS-0007 8.3"),
    RU(WRITE, c_link, "c_link", I16, -1, 7, NULL,
       "C-Link status of TS-0007 8.2; a write forces it, -1: as determined by the radio"),
    RU(WRITE, g_link, "g_link", I16, -1, 7, NULL,
       "G-Link status of TS-0007 8.2; a write forces it, -1: as determined by the radio"),
    RU(READ, received, "received", BYTES, 0, ECLINK_COMMAND_BYTES, NULL, "last command from the controller"),
    RU(READ, received_count, "received_count", U32, 0, UINT32_MAX, NULL, "commands received from the controller"),
    RU(READ, commands_dropped, "commands_dropped", U32, 0, UINT32_MAX, NULL,
       "commands from the controller, acknowledged, that waited for it when it left communication"),
    RU(READ, periodic_count, "periodic_count", U32, 0, UINT32_MAX, NULL, "sets of periodic data shown"),
};

static const ect_signal_group_t groups[] = {
    {.prefix = "bu",
     .count = 0,
     .signal_count = COUNT(bu_signals),
     .offset = offsetof(eclink_t, bu),
     .signals = bu_signals},
    {.prefix = "ru",
     .count = ECLINK_RUS,
     .signal_count = COUNT(ru_signals),
     .offset = offsetof(eclink_t, ru),
     .stride = sizeof(eclink_ru_t),
     .signals = ru_signals},
};

/* --- from the user ------------------------------------------------------------------------------------------------ */

#define IS(signal, type, member) ((signal)->offset == offsetof(type, member))

static const char *send_command(eclink_t *unit, unsigned int number, const uint8_t *data, uint64_t now_ns)
{
    eclink_ru_t *ru = &unit->ru[number];
    eclink_command_t command = {.ru = ru->id};
    if (!eclink_has(unit, ECLINK_FMAP_COMMANDS))
        return "this mode (Input Only) has no commands";
    const char *refusal = eclink_why_unreachable(ru);
    if (refusal)
        return refusal;
    memcpy(command.data, data, sizeof command.data);
    if (!eclink_command_from_ru(unit, &command, now_ns)) {
        unit->bu.overflows++;
        return "the base unit's queue is full: the controller has to acknowledge in CAO first";
    }
    ru->sent++;
    return NULL;
}

static const char *write_switch(const eclink_ru_t *ru, unsigned int position, int16_t value)
{
    static const struct {
        int16_t minimum, maximum;
        const char *range;
    } kinds[ECLINK_EQUIPMENT_COUNT] = {
        {0, 0, "no switch is fitted at this position: set 'fitted' first"},
        {0, 1, "a pushbutton has the values 0 and 1"},
        {0, 1, "a 2-position switch has the values 0 and 1"},
        {-1, 1, "a 3-position switch has the values -1, 0 and 1"},
        {0, 1000, "a potentiometer has the values 0 to 1000"},
        {0, 3, "a pushbutton with LED has the values 0 to 3"},
        {0, 3, "a dual LED has the values 0 to 3"},
    };
    uint8_t kind = ru->fitted[position];
    return value < kinds[kind].minimum || value > kinds[kind].maximum ? kinds[kind].range : NULL;
}

static const char *write_id(const eclink_t *unit, const eclink_ru_t *ru, uint16_t id)
{
    for (unsigned int i = 0; i < ECLINK_RUS; i++) {
        if (&unit->ru[i] != ru && unit->ru[i].id == id)
            return "another remote unit has this id, and ids are unique";
    }
    return NULL;
}

/* @return whether the signal is an element of an array of the remote. @param[out] position on true its number, from 0
 */
static bool is_element(const ect_signal_t *signal, size_t first, size_t size, size_t element, unsigned int *position)
{
    *position = (unsigned int)((signal->offset - first) / element);
    return signal->offset >= first && signal->offset < first + size;
}

/* Returns signals of two bytes. */
static const char *write_number(eclink_t *unit, eclink_ru_t *ru, const ect_signal_t *signal, int16_t value)
{
    unsigned int position;
    if (IS(signal, eclink_ru_t, id))
        return write_id(unit, ru, (uint16_t)value);
    if (is_element(signal, offsetof(eclink_ru_t, switches), sizeof ru->switches, sizeof value, &position))
        return write_switch(ru, position, value);
    int16_t *forced = IS(signal, eclink_ru_t, c_link)   ? &ru->forced_c_link
                      : IS(signal, eclink_ru_t, g_link) ? &ru->forced_g_link
                                                        : NULL;
    if (!forced)
        return NULL;
    *forced = value;
    return "";
}

static const char *write_ru(eclink_t *unit, const ect_signal_t *signal, unsigned int number, const void *value,
                            uint64_t now_ns)
{
    eclink_ru_t *ru = &unit->ru[number];
    const uint8_t *byte = value;
    unsigned int position;
    if (signal->type == ECT_SIGNAL_I16 || signal->type == ECT_SIGNAL_U16) {
        int16_t wanted;
        memcpy(&wanted, value, sizeof wanted);
        return write_number(unit, ru, signal, wanted);
    }
    if (IS(signal, eclink_ru_t, armed)) {
        const char *refusal = eclink_arm(unit, number, *byte != 0);
        return refusal ? refusal : "";
    }
    if (IS(signal, eclink_ru_t, command))
        return send_command(unit, number, byte, now_ns);
    if (is_element(signal, offsetof(eclink_ru_t, fitted), sizeof ru->fitted, 1, &position))
        ru->switches[position] = 0; /* another switch starts at rest */
    return NULL;
}

static const char *write_bu(eclink_t *unit, const ect_signal_t *signal, const void *value)
{
    const ect_host_t *host = unit->host;
    bool on = *(const uint8_t *)value != 0;
    if (IS(signal, eclink_bu_t, enabled) && host->off_bus)
        host->off_bus(host->ctx, !on);
    if (IS(signal, eclink_bu_t, restart) && on)
        host->restart(host->ctx);
    return NULL;
}

static void signal_written(void *instance, const ect_signal_t *signal, uint16_t number, uint64_t now_ns)
{
    eclink_t *unit = instance;
    (void)signal;
    (void)number;
    (void)now_ns;
    unit->remotes_due = true;
    eclink_evaluate(unit);
}

static const char *signal_write(void *instance, const ect_signal_t *signal, uint16_t number, const void *value,
                                uint64_t now_ns)
{
    eclink_t *unit = instance;
    const char *answer =
        number > 0 ? write_ru(unit, signal, number - 1u, value, now_ns) : write_bu(unit, signal, value);
    if (answer && *answer == 0)
        signal_written(unit, signal, number, now_ns);
    return answer;
}

static ect_bulk_t bulk(const void *instance)
{
    const eclink_t *unit = instance;
    return (ect_bulk_t){
        .data = eclink_periodic_set(unit), .size = unit->bu.periodic_size, .serial = unit->bu.periodic_sets};
}

/* --- texts -------------------------------------------------------------------------------------------------------- */

static const char *message_of(uint8_t fault)
{
    switch (fault) {
    case ECLINK_WHY_MODULE:
        return "EC: Module Error";
    case ECLINK_WHY_CONFIGURATION:
        return "EC: Cfg. Error";
    case ECLINK_WHY_NO_DATA:
    case ECLINK_WHY_NOT_READ:
        return "EC: No Data";
    case ECLINK_WHY_PCO:
    case ECLINK_WHY_CAO:
        return "EC: Bad data";
    default:
        return "";
    }
}

/* All texts are shorter than the room of their signals. */
static void put(char *text, const char *words)
{
    memcpy(text, words, strlen(words) + 1);
}

static void put_cause(uint16_t cause, char *text)
{
    static const char *const causes[] = {
        [ECLINK_WHY_NONE] = "",
        [ECLINK_WHY_DISABLED] = "EC-Link is disabled",
        [ECLINK_WHY_MODULE] = "the fieldbus module reports an error",
        [ECLINK_WHY_CONFIGURATION] = "the controller's configuration was refused",
        [ECLINK_WHY_NO_DATA] = "no process data from the controller",
        [ECLINK_WHY_NOT_READ] = "the controller does not read the input data",
        [ECLINK_WHY_PCO] = "PCO does not increment",
        [ECLINK_WHY_CAO] = "CAO does not acknowledge a command",
        [ECLINK_WHY_SELF] = "self-diagnostics has found a fatal internal error",
        [ECLINK_WHY_EG_NO_LINK] = "EG-Link: no link",
        [ECLINK_WHY_EG_ERROR] = "EG-Link: link error",
        [ECLINK_WHY_EG_INTERFACE] = "EG-Link: interface error",
        [ECLINK_WHY_EG_DATA] = "EG-Link: data error",
        [ECLINK_WHY_LOST] = "ru0: communication is lost; turn it on and rearm it",
        [ECLINK_WHY_FAILED] = "ru0: it has an internal error",
        [ECLINK_WHY_STOP] = "ru0: the stop switch is pressed",
        [ECLINK_WHY_SHOCK] = "ru0: free fall or shock was detected",
    };
    put(text, causes[cause & 0xFF]);
    if (cause >> 8 != 0)
        text[2] = (char)('0' + (cause >> 8));
}

static void signal_describe(const ect_signal_t *signal, uint16_t value, char *text)
{
    if (signal->offset == offsetof(eclink_bu_t, fault))
        put(text, message_of((uint8_t)value));
    else
        put_cause(value, text);
}

const ect_plant_t ect_eclink_plant = {
    .signal_groups = groups,
    .signal_group_count = COUNT(groups),
    .outside_offset = offsetof(eclink_t, bu),
    .outside_size = offsetof(eclink_t, armed) - offsetof(eclink_t, bu),
    .signal_write = signal_write,
    .signal_written = signal_written,
    .signal_describe = signal_describe,
    .bulk = bulk,
    .modbus = &eclink_modbus,
    .fields = eclink_states,
};
