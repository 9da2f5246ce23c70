/* SPDX-License-Identifier: MIT */
/*
 * The device on SOES's own stack: its functions behind SOES's hooks, its dictionary as an object list. Functions
 * missing from SOES's API are omitted (docs/SOES.md): emergencies, object services, delayed transitions.
 */
#include FIRMWARE_DEVICE_HEADER

#include <stddef.h>
#include <string.h>

#include "board.h"
#include "firmware.h"
#include "on_soes/objects.h"
#include "seams/standard.h"
#include "soes/describe.h"

static const ect_device_t *const device = &FIRMWARE_DEVICE;
static max_align_t memory[(FIRMWARE_MEMORY + sizeof(max_align_t) - 1) / sizeof(max_align_t)];
static void *const instance = memory;
static ect_od_t od;
static uint64_t tick_ns;
static bool restart;

/* --- requests of the device --------------------------------------------------------------------------------------- */

static void emergency(void *ctx, uint16_t code, uint8_t error_register, const uint8_t data[5])
{
    ect_standard_t *standard = instance;
    (void)ctx;
    (void)code;
    (void)data;
    standard->error_register = error_register;
}

static void drop(void *ctx, uint8_t state, uint16_t al_status_code)
{
    (void)ctx;
    ESC_ALstatusgotoerror(state | ESCerror, al_status_code);
}

static void transition_done(void *ctx, uint16_t al_status_code)
{
    (void)ctx;
    (void)al_status_code;
}

static void diagnose(void *ctx, uint8_t type, uint32_t code, uint16_t text_id, const uint16_t parameters[2])
{
    (void)ctx;
    (void)type;
    (void)code;
    (void)text_id;
    (void)parameters;
}

static void store(void *ctx)
{
    (void)ctx;
}

static void off_bus(void *ctx, bool off)
{
    (void)ctx;
    (void)off;
}

static void want_restart(void *ctx)
{
    (void)ctx;
    restart = true;
}

/* --- hooks -------------------------------------------------------------------------------------------------------- */

static void state_changed(uint8_t *as, uint8_t *an)
{
    uint8_t from = *as & ESCREG_AL_ERRACKMASK;
    uint8_t to = *as >> 4;
    bool refused = to > from && (*an & ESCerror) != 0;
    if (from == to || refused || !device->state_change)
        return;
    uint16_t code = device->state_change(instance, from, to, board_now_ns());
    if (to < from || code == 0 || code == ECT_AL_PENDING)
        return;
    *an = from | ESCerror;
    ESC_ALerror(code);
}

static void safe_outputs(void)
{
    if (device->safe_outputs)
        device->safe_outputs(instance, board_now_ns());
}

static void tick(void)
{
    uint64_t now_ns = board_now_ns();
    if ((ESCvar.ALevent & ESCREG_ALEVENT_SM3) != 0 && device->inputs_read)
        device->inputs_read(instance, now_ns);
    if (now_ns >= tick_ns && device->tick)
        tick_ns = device->tick(instance, now_ns);
}

void cb_set_outputs(void)
{
    tick_ns = 0;
    if (device->cyclic)
        device->cyclic(instance, ECT_CYCLIC_OUTPUTS, board_now_ns());
    if (device->outputs)
        device->outputs(instance, board_now_ns());
}

void cb_get_inputs(void)
{
    if (device->inputs)
        device->inputs(instance, board_now_ns());
}

static uint32_t abort_code(ect_reason_t reason)
{
    return reason == ECT_OK ? 0 : ect_abort_code(reason);
}

static ect_reason_t may_write(uint16_t index, uint8_t subindex, const void *data, size_t size)
{
    const ect_object_t *object = NULL;
    const ect_entry_t *entry = NULL;
    ect_reason_t reason = device->sdo_request ? device->sdo_request(instance, index, subindex) : (ect_reason_t)ECT_OK;
    if (reason == ECT_OK)
        reason = ect_od_lookup(&od, index, subindex, &object, &entry);
    if (reason == ECT_OK && size == ect_od_bytes(entry))
        reason = ect_od_check_limit(&od, index, entry, data);
    if (reason == ECT_OK && device->sdo_write)
        reason = device->sdo_write(instance, index, subindex, data, (uint16_t)size);
    return reason;
}

/* Handles Complete Access, for which SOES calls its hook once, not for each entry. */
static uint32_t before_download(uint16_t index, uint8_t subindex, void *data, size_t size, uint16_t flags)
{
    return (flags & COMPLETE_ACCESS_FLAG) != 0 ? 0 : abort_code(may_write(index, subindex, data, size));
}

static uint32_t after_download(uint16_t index, uint8_t subindex, uint16_t flags)
{
    (void)flags;
    tick_ns = 0;
    if (device->sdo_written)
        device->sdo_written(instance, index, subindex, board_now_ns());
    return 0;
}

static uint32_t before_upload(uint16_t index, uint8_t subindex, void *data, size_t *size, uint16_t flags)
{
    bool whole = (flags & COMPLETE_ACCESS_FLAG) != 0;
    ect_span_t instead = {0};
    ect_reason_t reason = device->sdo_request ? device->sdo_request(instance, index, subindex) : (ect_reason_t)ECT_OK;
    if (reason == ECT_OK && device->sdo_read)
        reason =
            device->sdo_read(instance, index, whole ? (uint16_t)ECT_WHOLE_OBJECT : subindex, whole ? NULL : &instead);
    if (instead.data && instead.size <= *size) {
        memcpy(data, instead.data, instead.size);
        *size = instead.size;
    }
    return abort_code(reason);
}

/* --- the device --------------------------------------------------------------------------------------------------- */

static void power_on(void)
{
    static ect_host_t host = {.emergency = emergency,
                              .drop = drop,
                              .transition_done = transition_done,
                              .diagnose = diagnose,
                              .store = store,
                              .off_bus = off_bus,
                              .restart = want_restart};
    ect_standard_t *standard = instance;
    host.storage = board_storage();
    od = ect_device_od(device, instance);
    if (device->instance_size > sizeof memory || !objects_make(device, instance))
        firmware_stop(); /* FIRMWARE_MEMORY, or the room in objects.c, is too small for this device */
    standard->device = device;
    standard->identity = device->identity;
    standard->identity.serial = board_serial() != 0 ? board_serial() : device->identity.serial;
    ect_od_set_defaults(&od);
    if (device->init)
        device->init(instance, &host, board_now_ns());
}

/* A hardware file with a software ESC makes the EEPROM from this description. */
void ect_soes_describe(ect_device_t *to)
{
    *to = *device;
}

esc_cfg_t *firmware_config(void)
{
    static esc_cfg_t config = {.watchdog_cnt = 1000,
                               .skip_default_initialization = true,
                               .post_state_change_hook = state_changed,
                               .application_hook = tick,
                               .safeoutput_override = safe_outputs,
                               .pre_object_download_hook = before_download,
                               .post_object_download_hook = after_download,
                               .pre_object_upload_hook = before_upload};
    power_on();
    return &config;
}

/* SOES reports no time of its next call. */
uint64_t firmware_turn(void)
{
    const ect_leds_t *leds = board_leds();
    uint8_t state = ESCvar.ALstatus & ESCREG_AL_ERRACKMASK;
    if (leds->run)
        leds->run(leds->ctx, state == ESCop);
    if (leds->err)
        leds->err(leds->ctx, (ESCvar.ALstatus & ESCerror) != 0);
    if (restart)
        board_reset();
    return 0;
}
