/* SPDX-License-Identifier: MIT */
/*
 * The base unit: its rhythm, what it makes of the links, and what it tells the controller (TS-0007 §8, §10, §11).
 *
 * Input data change every 125 ms and then PCI counts; what happens in between waits for that. Supervision does not
 * wait: BU state, relays and message follow at once, and the controller sees them with the next input data.
 */
#include <string.h>

#include "devices/eclink/instance.h"
#include "wire/bytes.h"

#define UPDATE_NS 125000000ull /* §10.3 */

static uint8_t fmap_of(const ect_device_t *device)
{
    uint16_t outputs = ect_device_bytes(device, ECT_SM_OUTPUTS);
    uint16_t inputs = ect_device_bytes(device, ECT_SM_INPUTS);
    return (uint8_t)(ECLINK_FMAP_INPUT | (outputs > 0 ? ECLINK_FMAP_COMMANDS : 0) |
                     (outputs > ECLINK_OUT_PERIODIC_SIZE ? ECLINK_FMAP_PERIODIC : 0) |
                     (inputs > ECLINK_IN_RU + ECLINK_IN_RU_STRIDE ? ECLINK_FMAP_MULTIARM : 0));
}

/* --- links, message, state ---------------------------------------------------------------------------------------- */

static bool command_late(const eclink_t *unit)
{
    return unit->cao_deadline_ns == 0;
}

/* Why the EC-Link is not in order. NULL: it is. */
static const char *fault(const eclink_t *unit, uint8_t *status, const char **message)
{
    *message = "";
    *status = ECLINK_LINK_UNUSED;
    if (!unit->bu.enabled)
        return NULL;
    *status = ECLINK_LINK_INTERFACE_ERROR;
    *message = "EC: Module Error";
    if (unit->bu.module_error)
        return "the fieldbus module reports an error";
    *status = ECLINK_LINK_ERROR;
    *message = "EC: Cfg. Error";
    if (!unit->exchanging && unit->config_refused)
        return "the controller's configuration was refused";
    *status = ECLINK_LINK_NONE;
    *message = "EC: No Data";
    if (!unit->exchanging)
        return "no process data from the controller";
    *status = ECLINK_LINK_DATA_ERROR;
    *message = "EC: Bad data";
    if (eclink_has(unit, ECLINK_FMAP_PERIODIC) && !unit->pco_alive)
        return "PCO does not increment";
    if (eclink_has(unit, ECLINK_FMAP_COMMANDS) && command_late(unit))
        return "CAO does not acknowledge a command";
    *status = ECLINK_LINK_OPERATIONAL;
    *message = "";
    return NULL;
}

static bool eg_link_bad(const eclink_t *unit)
{
    return unit->bu.eg_link >= ECLINK_LINK_NONE && unit->bu.eg_link <= ECLINK_LINK_DATA_ERROR;
}

static bool any_armed_stopped(const eclink_t *unit)
{
    for (unsigned int i = 0; i < unit->armed_count; i++) {
        if (unit->ru[unit->armed[i]].state >= ECLINK_RU_STOPPED)
            return true;
    }
    return false;
}

static uint8_t bu_state(const eclink_t *unit, bool ec_link_bad)
{
    if (unit->bu.failed)
        return ECLINK_BU_FAILED;
    if (ec_link_bad && !unit->good_once)
        return ECLINK_BU_INITIAL;
    if (ec_link_bad || eg_link_bad(unit))
        return ECLINK_BU_LINK_ERROR;
    if (unit->blocked != 0)
        return ECLINK_BU_BLOCKED;
    if (any_armed_stopped(unit))
        return ECLINK_BU_STOPPED;
    return unit->armed_count > 0 ? ECLINK_BU_ARMED : ECLINK_BU_DISARMED;
}

static void put_text(char *to, size_t room, const char *text)
{
    size_t length = strlen(text);
    length = length < room - 1 ? length : room - 1;
    memcpy(to, text, length);
    to[length] = 0;
}

static void evaluate(eclink_t *unit)
{
    const char *message;
    const char *cause = fault(unit, &unit->bu.ec_link, &message);
    eclink_remotes_update(unit);
    unit->good_once |= cause == NULL && unit->bu.enabled;
    unit->bu.state = bu_state(unit, cause != NULL);
    unit->bu.es_link = unit->bu.state >= ECLINK_BU_DISARMED;
    put_text(unit->bu.message, sizeof unit->bu.message, message);
    const char *otherwise = unit->bu.enabled ? "" : "EC-Link is disabled";
    put_text(unit->bu.cause, sizeof unit->bu.cause, cause ? cause : otherwise);
}

/* --- from the stack ----------------------------------------------------------------------------------------------- */

void eclink_init(void *instance, const ect_host_t *host, uint64_t now_ns)
{
    eclink_t *unit = instance;
    unit->host = host;
    unit->fmap = fmap_of(unit->standard.device);
    unit->update_ns = now_ns + UPDATE_NS;
    unit->pco_deadline_ns = ECT_NEVER;
    unit->cao_deadline_ns = ECT_NEVER;
    unit->bu.enabled = 1;
    unit->bu.vlaps = 3;
    for (unsigned int i = 0; i < ECLINK_RUS; i++) {
        unit->ru[i].id = (uint16_t)(i + 1);
        unit->ru[i].battery = 100;
        unit->ru[i].rssi = 100;
        memset(unit->ru[i].fitted, ECLINK_PUSHBUTTON, 4);
    }
    evaluate(unit);
}

static void stop_exchange(eclink_t *unit)
{
    unit->exchanging = false;
    unit->outputs_known = false;
    unit->pco_alive = false;
    unit->pco_deadline_ns = ECT_NEVER;
    unit->cao_deadline_ns = ECT_NEVER;
}

uint16_t eclink_state_change(void *instance, uint8_t from, uint8_t to, uint64_t now_ns)
{
    eclink_t *unit = instance;
    (void)now_ns;
    unit->config_refused &= to <= unit->refused_in;
    if (to == ECT_STATE_OP)
        unit->exchanging = !eclink_has(unit, ECLINK_FMAP_COMMANDS); /* with outputs, their coming decides */
    else if (from == ECT_STATE_OP)
        stop_exchange(unit);
    evaluate(unit);
    return 0;
}

static bool says_mismatch(uint16_t code)
{
    return (code >= ECT_AL_BOOT_MAILBOX && code <= ECT_AL_SM) ||
           (code >= ECT_AL_SM_TYPES && code <= ECT_AL_WATCHDOG_SETTING) ||
           (code >= ECT_AL_INPUT_MAPPING && code <= ECT_AL_NO_SYNC);
}

/* A refused configuration stays the reason until the controller gets further, or something else is wrong. */
void eclink_al_error(void *instance, uint8_t state, uint16_t code, uint64_t now_ns)
{
    eclink_t *unit = instance;
    (void)now_ns;
    if (code == 0)
        return;
    unit->config_refused = says_mismatch(code);
    unit->refused_in = state;
    evaluate(unit);
}

void eclink_outputs(void *instance, uint64_t now_ns)
{
    eclink_t *unit = instance;
    bool first = !unit->outputs_known;
    unit->outputs_known = true;
    unit->exchanging = true;
    if (first || unit->outputs[ECLINK_OUT_PCO] != unit->last_pco) {
        unit->pco_alive = !first;
        unit->pco_deadline_ns = first ? ECT_NEVER : now_ns + ECLINK_SUPERVISION_NS;
    }
    if (eclink_has(unit, ECLINK_FMAP_PERIODIC))
        eclink_periodic_outputs(unit, first);
    unit->last_pco = unit->outputs[ECLINK_OUT_PCO];
    unit->bu.pai = unit->last_pco;
    if (eclink_has(unit, ECLINK_FMAP_COMMANDS))
        eclink_command_outputs(unit, first, now_ns);
} /* what follows from it is evaluated by the tick that follows */

static void publish(eclink_t *unit)
{
    uint8_t *in = unit->inputs;
    unit->bu.pci++;
    in[ECLINK_IN_PCI] = unit->bu.pci;
    in[ECLINK_IN_CCI] = unit->bu.cci;
    in[ECLINK_IN_PAI] = unit->bu.pai;
    in[ECLINK_IN_CAI] = unit->bu.cai;
    in[ECLINK_IN_BU_STATE] = unit->bu.state;
    in[ECLINK_IN_VLAPS] = unit->bu.vlaps;
    in[ECLINK_IN_UNARMED] = unit->bu.unarmed;
    in[ECLINK_IN_EG_LINK] = unit->bu.eg_link;
    in[ECLINK_IN_EC_LINK] = unit->bu.ec_link;
    eclink_remotes_publish(unit, in);
}

static void supervise(eclink_t *unit, uint64_t now_ns)
{
    if (now_ns >= unit->pco_deadline_ns) {
        unit->pco_alive = false;
        unit->pco_deadline_ns = ECT_NEVER;
    }
    if (unit->cao_deadline_ns != 0 && now_ns >= unit->cao_deadline_ns)
        unit->cao_deadline_ns = 0; /* late, until it is acknowledged */
}

/* Late calls do not shift the rhythm, and do not make up for missed updates. */
uint64_t eclink_tick(void *instance, uint64_t now_ns)
{
    eclink_t *unit = instance;
    supervise(unit, now_ns);
    if (now_ns >= unit->update_ns) {
        if (unit->exchanging && eclink_has(unit, ECLINK_FMAP_COMMANDS))
            eclink_show_command(unit, now_ns);
        eclink_command_to_rus(unit);
        evaluate(unit);
        publish(unit);
        unit->update_ns += UPDATE_NS;
        if (unit->update_ns <= now_ns)
            unit->update_ns = now_ns + UPDATE_NS;
    } else {
        evaluate(unit);
    }
    uint64_t next = unit->update_ns < unit->pco_deadline_ns ? unit->update_ns : unit->pco_deadline_ns;
    return unit->cao_deadline_ns != 0 && unit->cao_deadline_ns < next ? unit->cao_deadline_ns : next;
}

/* --- 3001h, 3002h ------------------------------------------------------------------------------------------------- */

/* Where the fields stand is what the entries of the object say. */
static void decode(uint8_t *numbers, const uint8_t *bytes, uintptr_t base, const ect_object_t *object)
{
    for (unsigned int i = 1; i <= object->max_subindex; i++) {
        const ect_entry_t *entry = &object->entries[i];
        size_t offset = (uintptr_t)entry->data - base;
        if (entry->bit_length == 16) {
            uint16_t number = ect_load_be16(bytes + offset);
            memcpy(numbers + offset, &number, sizeof number);
        } else {
            memcpy(numbers + offset, bytes + offset, ect_od_bytes(entry));
        }
    }
}

ect_reason_t eclink_sdo_read(void *instance, uint16_t index, uint16_t subindex, ect_span_t *instead)
{
    eclink_t *unit = instance;
    (void)subindex;
    (void)instead;
    const ect_od_t od = ect_device_od(unit->standard.device, NULL);
    if (index == 0x3001)
        decode(unit->input_numbers, unit->inputs, offsetof(eclink_t, input_numbers), ect_od_find(&od, index));
    else if (index == 0x3002)
        decode(unit->output_numbers, unit->outputs, offsetof(eclink_t, output_numbers), ect_od_find(&od, index));
    return ECT_OK;
}
