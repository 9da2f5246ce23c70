/* SPDX-License-Identifier: MIT */
/*
 * The base unit: its rhythm, supervision of its links, and the input data (TS-0007 §8, §10, §11).
 *
 * Input data change every 125 ms, and PCI counts each change. Supervision does not wait for this rhythm: BU state,
 * relays and message follow at once, and the controller reads them in the next input data.
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

/* EC-Link status for each fault (§8.2, §11). */
static uint8_t link_status(uint8_t fault)
{
    static const uint8_t status[] = {
        [ECLINK_WHY_NONE] = ECLINK_LINK_OPERATIONAL,       [ECLINK_WHY_DISABLED] = ECLINK_LINK_UNUSED,
        [ECLINK_WHY_MODULE] = ECLINK_LINK_INTERFACE_ERROR, [ECLINK_WHY_CONFIGURATION] = ECLINK_LINK_ERROR,
        [ECLINK_WHY_NO_DATA] = ECLINK_LINK_NONE,           [ECLINK_WHY_NOT_READ] = ECLINK_LINK_NONE,
        [ECLINK_WHY_PCO] = ECLINK_LINK_DATA_ERROR,         [ECLINK_WHY_CAO] = ECLINK_LINK_DATA_ERROR,
    };
    return status[fault];
}

static uint8_t why_silent(const eclink_t *unit)
{
    if (unit->config_refused)
        return ECLINK_WHY_CONFIGURATION;
    return unit->in_op && !eclink_has(unit, ECLINK_FMAP_COMMANDS) ? ECLINK_WHY_NOT_READ : ECLINK_WHY_NO_DATA;
}

static uint8_t present_fault(const eclink_t *unit)
{
    if (!unit->bu.enabled)
        return ECLINK_WHY_DISABLED;
    if (unit->bu.module_error)
        return ECLINK_WHY_MODULE;
    if (!unit->exchanging)
        return why_silent(unit);
    if (eclink_has(unit, ECLINK_FMAP_PERIODIC) && !unit->pco_alive)
        return ECLINK_WHY_PCO;
    return unit->cao_late ? ECLINK_WHY_CAO : ECLINK_WHY_NONE;
}

/* An error ends with its cause; in a strict reading (lock_errors) an error after the first good exchange remains. */
static uint8_t fault_of(eclink_t *unit)
{
    uint8_t fault = present_fault(unit);
    if (!unit->bu.lock_errors || fault == ECLINK_WHY_DISABLED)
        unit->locked = ECLINK_WHY_NONE;
    else if (unit->good_once && fault != ECLINK_WHY_NONE)
        unit->locked = fault;
    return unit->locked != ECLINK_WHY_NONE ? unit->locked : fault;
}

/* @return the first armed remote that stops the machine; NULL: none */
static const eclink_ru_t *stopped(const eclink_t *unit)
{
    for (unsigned int i = 0; i < unit->armed.count; i++) {
        const eclink_ru_t *ru = &unit->ru[unit->armed.numbers[i]];
        if (ru->state >= ECLINK_RU_STOPPED)
            return ru;
    }
    return NULL;
}

static uint8_t bu_state(const eclink_t *unit, bool ec_link_bad)
{
    if (unit->bu.failed)
        return ECLINK_BU_FAILED;
    if (ec_link_bad && (!unit->good_once || unit->locked != ECLINK_WHY_NONE))
        return ECLINK_BU_INITIAL;
    if (ec_link_bad || eclink_is_error(unit->bu.eg_link))
        return ECLINK_BU_LINK_ERROR;
    if (unit->lost.count > 0)
        return ECLINK_BU_BLOCKED;
    if (stopped(unit))
        return ECLINK_BU_STOPPED;
    return unit->armed.count > 0 ? ECLINK_BU_ARMED : ECLINK_BU_DISARMED;
}

static uint16_t why_stopped(const eclink_t *unit)
{
    const eclink_ru_t *ru = stopped(unit);
    eclink_why_t why = ru->failed ? ECLINK_WHY_FAILED : ru->stop ? ECLINK_WHY_STOP : ECLINK_WHY_SHOCK;
    return eclink_why((unsigned int)(ru - unit->ru) + 1, why);
}

/* @return the cause of a state other than Armed and Disarmed */
static uint16_t cause(const eclink_t *unit, uint8_t fault, bool ec_link_bad)
{
    switch (unit->bu.state) {
    case ECLINK_BU_FAILED:
        return ECLINK_WHY_SELF;
    case ECLINK_BU_LINK_ERROR:
        return ec_link_bad ? fault : (uint16_t)(ECLINK_WHY_EG_NO_LINK + unit->bu.eg_link - ECLINK_LINK_NONE);
    case ECLINK_BU_BLOCKED:
        return eclink_why(unit->lost.numbers[0] + 1u, ECLINK_WHY_LOST);
    case ECLINK_BU_STOPPED:
        return why_stopped(unit);
    default:
        return fault;
    }
}

void eclink_evaluate(eclink_t *unit)
{
    uint8_t fault = fault_of(unit);
    bool ec_link_bad = fault > ECLINK_WHY_DISABLED;
    eclink_remotes_update(unit);
    unit->good_once |= fault == ECLINK_WHY_NONE;
    unit->bu.ec_link = link_status(fault);
    unit->bu.state = bu_state(unit, ec_link_bad);
    unit->bu.es_link = unit->bu.state >= ECLINK_BU_DISARMED;
    unit->bu.fault = fault;
    unit->bu.cause = cause(unit, fault, ec_link_bad);
}

/* --- from the stack ----------------------------------------------------------------------------------------------- */

/* Sets the surroundings of a new unit. */
static void outside_defaults(eclink_t *unit)
{
    unit->bu.enabled = 1;
    unit->bu.vlaps = 3;
    for (unsigned int i = 0; i < ECLINK_RUS; i++) {
        eclink_ru_t *ru = &unit->ru[i];
        ru->id = (uint16_t)(i + 1);
        ru->battery = 100;
        ru->rssi = 100;
        ru->forced_c_link = ECLINK_NOT_FORCED;
        ru->forced_g_link = ECLINK_NOT_FORCED;
        memset(ru->fitted, ECLINK_PUSHBUTTON, 4);
    }
}

#define ZERO_FROM(object, type, member)                                                                                \
    memset((uint8_t *)(object) + offsetof(type, member), 0, sizeof(type) - offsetof(type, member))

void eclink_init(void *instance, const ect_host_t *host, uint64_t now_ns)
{
    eclink_t *unit = instance;
    unit->host = host;
    unit->fmap = fmap_of(unit->standard.device);
    unit->update_ns = now_ns + UPDATE_NS;
    unit->pco_deadline_ns = ECT_NEVER;
    unit->cao_deadline_ns = ECT_NEVER;
    unit->read_deadline_ns = ECT_NEVER;
    unit->modbus_deadline_ns = ECT_NEVER;
    unit->hold_deadline_ns = ECT_NEVER;
    if (unit->ru[0].id == 0) /* no remote has that id: this is the first power-on */
        outside_defaults(unit);
    ZERO_FROM(&unit->bu, eclink_bu_t, state);
    for (unsigned int i = 0; i < ECLINK_RUS; i++)
        ZERO_FROM(&unit->ru[i], eclink_ru_t, armed);
    if (!unit->bu.enabled)
        host->off_bus(host->ctx, true);
    unit->remotes_due = true;
    eclink_evaluate(unit);
}

static void stop_exchange(eclink_t *unit)
{
    unit->exchanging = false;
    unit->outputs_known = false;
    unit->pco_alive = false;
    unit->cao_late = false;
    unit->pco_deadline_ns = ECT_NEVER;
    unit->cao_deadline_ns = ECT_NEVER;
    unit->read_deadline_ns = ECT_NEVER;
    eclink_periodic_drop(unit); /* an interruption ends a set */
}

/* Begins the flow of data in Input Only, which lasts while inputs are read; in other modes, while outputs arrive. */
static void begin_exchange(eclink_t *unit, uint64_t now_ns)
{
    if (eclink_has(unit, ECLINK_FMAP_COMMANDS))
        return;
    unit->exchanging = true;
    unit->read_deadline_ns = now_ns + ECLINK_SUPERVISION_NS;
}

static bool has_modbus(const eclink_t *unit)
{
    return unit->modbus_deadline_ns != ECT_NEVER;
}

/* Refuses OP while Modbus writes outputs: the bus that writes keeps the unit until it stops. */
uint16_t eclink_state_change(void *instance, uint8_t from, uint8_t to, uint64_t now_ns)
{
    eclink_t *unit = instance;
    if (to == ECT_STATE_OP && has_modbus(unit) && eclink_has(unit, ECLINK_FMAP_COMMANDS))
        return ECT_AL_UNSPECIFIED;
    unit->config_refused &= to <= unit->refused_in;
    unit->in_op = to == ECT_STATE_OP;
    if (to == ECT_STATE_OP)
        begin_exchange(unit, now_ns);
    else if (from == ECT_STATE_OP)
        unit->read_deadline_ns = ECT_NEVER;
    if (from == ECT_STATE_OP)
        unit->hold_deadline_ns = now_ns + ECLINK_SUPERVISION_NS;
    if (from == ECT_STATE_OP && !has_modbus(unit))
        stop_exchange(unit);
    eclink_evaluate(unit);
    return 0;
}

void eclink_inputs_read(void *instance, uint64_t now_ns)
{
    eclink_t *unit = instance;
    bool silent = !unit->exchanging;
    if (!unit->in_op)
        return;
    begin_exchange(unit, now_ns);
    if (silent)
        eclink_evaluate(unit);
}

static bool is_mismatch(uint16_t code)
{
    return (code >= ECT_AL_BOOT_MAILBOX && code <= ECT_AL_SM) ||
           (code >= ECT_AL_SM_TYPES && code <= ECT_AL_WATCHDOG_SETTING) ||
           (code >= ECT_AL_INPUT_MAPPING && code <= ECT_AL_NO_SYNC);
}

/* A refused configuration remains the cause until the controller advances further, or another error occurs. */
uint16_t eclink_al_error(void *instance, uint8_t state, uint16_t code, uint64_t now_ns)
{
    eclink_t *unit = instance;
    (void)now_ns;
    if (code != ECT_AL_NO_ERROR) {
        unit->config_refused = is_mismatch(code);
        unit->refused_in = state;
        eclink_evaluate(unit);
    }
    return code;
}

static void watch_pco(eclink_t *unit, bool first, uint64_t now_ns)
{
    uint8_t step = (uint8_t)(unit->outputs[ECLINK_OUT_PCO] - unit->last_pco);
    if (!first && step == 0)
        return;
    unit->pco_alive = !first;
    unit->pco_deadline_ns = first ? ECT_NEVER : now_ns + ECLINK_SUPERVISION_NS;
    unit->bu.pco_jumps += !first && step != 1;
    eclink_periodic_outputs(unit);
}

void eclink_outputs(void *instance, uint64_t now_ns)
{
    eclink_t *unit = instance;
    bool first = !unit->outputs_known;
    unit->outputs_known = true;
    unit->exchanging = true;
    if (eclink_has(unit, ECLINK_FMAP_PERIODIC))
        watch_pco(unit, first, now_ns);
    unit->last_pco = unit->outputs[ECLINK_OUT_PCO];
    unit->bu.pai = unit->last_pco;
    if (eclink_has(unit, ECLINK_FMAP_COMMANDS))
        eclink_command_outputs(unit, first, now_ns);
} /* the tick that follows evaluates it */

void eclink_modbus_came(eclink_t *unit, uint64_t now_ns)
{
    unit->modbus_deadline_ns = now_ns + ECLINK_SUPERVISION_NS;
    unit->bu.modbus = 1;
    if (eclink_has(unit, ECLINK_FMAP_COMMANDS))
        eclink_outputs(unit, now_ns);
    unit->exchanging = true;
}

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

/* @return whether the deadline has passed, and clears it in this case */
static bool passed(uint64_t *deadline_ns, uint64_t now_ns)
{
    if (now_ns < *deadline_ns)
        return false;
    *deadline_ns = ECT_NEVER;
    return true;
}

/* In Input Only an EtherCAT master may read too, supervised by its own deadline. */
static void modbus_went(eclink_t *unit)
{
    unit->bu.modbus = 0;
    if (!unit->in_op)
        stop_exchange(unit);
    else
        unit->exchanging = unit->read_deadline_ns != ECT_NEVER;
}

static void supervise(eclink_t *unit, uint64_t now_ns)
{
    (void)passed(&unit->hold_deadline_ns, now_ns);
    if (passed(&unit->modbus_deadline_ns, now_ns))
        modbus_went(unit);
    if (passed(&unit->pco_deadline_ns, now_ns))
        unit->pco_alive = false;
    if (passed(&unit->cao_deadline_ns, now_ns))
        unit->cao_late = true;
    if (passed(&unit->read_deadline_ns, now_ns))
        unit->exchanging = has_modbus(unit);
}

/* Updates the input data. A late call neither shifts the rhythm nor repeats missed updates. */
uint64_t eclink_tick(void *instance, uint64_t now_ns)
{
    eclink_t *unit = instance;
    bool update = now_ns >= unit->update_ns;
    supervise(unit, now_ns);
    if (update) {
        if (unit->exchanging && !unit->bu.frozen && eclink_has(unit, ECLINK_FMAP_COMMANDS))
            eclink_show_command(unit, now_ns);
        eclink_command_to_rus(unit);
        unit->update_ns = unit->update_ns + UPDATE_NS > now_ns ? unit->update_ns + UPDATE_NS : now_ns + UPDATE_NS;
    }
    eclink_pass_command(unit);
    eclink_evaluate(unit);
    if (update && !unit->bu.frozen)
        publish(unit);
    return ect_earlier(ect_earlier(ect_earlier(unit->update_ns, unit->pco_deadline_ns),
                                   ect_earlier(unit->cao_deadline_ns, unit->read_deadline_ns)),
                       ect_earlier(unit->modbus_deadline_ns, unit->hold_deadline_ns));
}

/* --- 3001h, 3002h ------------------------------------------------------------------------------------------------- */

const ect_object_t *eclink_fields(const eclink_t *unit, bool inputs, size_t *base)
{
    const ect_od_t od = ect_device_od(unit->standard.device, NULL);
    *base = inputs ? offsetof(eclink_t, input_numbers) : offsetof(eclink_t, output_numbers);
    return ect_od_find(&od, inputs ? 0x3001 : 0x3002);
}

static void decode(const eclink_t *unit, bool inputs, uint8_t *numbers, const uint8_t *bytes)
{
    size_t base;
    const ect_object_t *object = eclink_fields(unit, inputs, &base);
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
    if (index == 0x3001)
        decode(unit, true, unit->input_numbers, unit->inputs);
    else if (index == 0x3002)
        decode(unit, false, unit->output_numbers, unit->outputs);
    return ECT_OK;
}
