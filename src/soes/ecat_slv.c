/* SPDX-License-Identifier: MIT */
/* SOES's main loop around this stack. */
#include "soes/ecat_slv.h"

#include "soes/esc_foe.h"
#include "soes/internal.h"
#include "wire/bytes.h"
#include "wire/registers.h"

/* --- the way to the ESC ------------------------------------------------------------------------------------------- */

static int hal_read(void *ctx, uint16_t address, void *buffer, uint16_t length)
{
    (void)ctx;
    ESC_read(address, buffer, length);
    return 0;
}

static int hal_write(void *ctx, uint16_t address, const void *buffer, uint16_t length)
{
    (void)ctx;
    ESC_write(address, (void *)(uintptr_t)buffer, length);
    return 0;
}

/* The hardware file stores the event word with each access. */
static int hal_event(void *ctx, uint32_t *event)
{
    (void)ctx;
    *event = ESCvar.ALevent;
    return 0;
}

/* Reads the device id when AL control bit 5 requests it: the application's, or the station alias. */
static void look_up_id(const ect_pdi_t *below)
{
    uint8_t alias[2] = {0};
    uint16_t id = 0;
    if (ESCvar.get_device_id)
        id = ESCvar.get_device_id(&id) == 0 ? id : 0;
    else if (below->read(below->ctx, ECT_REG_STATION_ALIAS, alias, sizeof alias) >= 0)
        id = ect_load_le16(alias);
    ect_soes.slave.config.device_id = id;
}

static int read_over(void *ctx, uint16_t address, void *buffer, uint16_t length)
{
    const ect_pdi_t *below = ctx;
    int result = below->read(below->ctx, address, buffer, length);
    if (address == ECT_REG_AL_CONTROL && length == 2) {
        ESCvar.ALcontrol = ect_load_le16(buffer);
        ect_soes.requested = true;
        if ((ESCvar.ALcontrol & ESCREG_AL_ID_REQUEST) != 0)
            look_up_id(below);
    }
    return result;
}

/*
 * Sets the state of the application. On the way to SAFEOP the SyncManagers are already enabled: the first inputs are
 * written before the master reads the new state, and before DIG_process in an interrupt may write any.
 */
static void follow_state(uint8_t status)
{
    uint8_t state = status & ECT_AL_STATE_MASK;
    bool begins = state == ECT_STATE_SAFEOP && CC_ATOMIC_GET(ESCvar.App.state) == APPSTATE_IDLE;
    uint8_t app = state == ECT_STATE_OP       ? APPSTATE_INPUT | APPSTATE_OUTPUT
                  : state == ECT_STATE_SAFEOP ? APPSTATE_INPUT
                                              : APPSTATE_IDLE;
    if (begins)
        ect_soes_inputs();
    CC_ATOMIC_SET(ESCvar.App.state, app);
    ESCvar.MBXrun = state != ECT_STATE_INIT;
    ESCvar.ALstatus = status;
}

/* The AL event mask belongs to the SOES application: the stack's own mask is stored, not written. */
static int write_over(void *ctx, uint16_t address, const void *buffer, uint16_t length)
{
    const ect_pdi_t *below = ctx;
    if (address == ECT_REG_AL_EVENT_MASK) {
        ect_soes.wanted = ect_load_le16(buffer);
        if (ect_soes.slave.config.exchange_is_callers)
            return 0;
    }
    if (address == ECT_REG_AL_STATUS)
        follow_state(((const uint8_t *)buffer)[0]);
    if (address == ECT_REG_AL_STATUS_CODE)
        ESCvar.ALerror = ect_load_le16(buffer);
    return below->write(below->ctx, address, buffer, length);
}

static int event_over(void *ctx, uint32_t *event)
{
    const ect_pdi_t *below = ctx;
    return below->al_event(below->ctx, event);
}

/* --- the loop ----------------------------------------------------------------------------------------------------- */

static void wait_for_esc(const ect_pdi_t *pdi)
{
    uint8_t bytes[2] = {0};
    while (pdi->read(pdi->ctx, ECT_REG_DL_STATUS, bytes, sizeof bytes) < 0 || (bytes[0] & 1u) == 0)
        ;
    ESCvar.DLstatus = ect_load_le16(bytes);
}

void ecat_slv_init(esc_cfg_t *config)
{
    ESC_config(config);
    ESC_init(config);
    ect_slave_config_t made_of = ect_soes_slave_config();
    ect_soes.below =
        made_of.pdi ? *made_of.pdi : (ect_pdi_t){.read = hal_read, .write = hal_write, .al_event = hal_event};
    ect_soes.pdi = (ect_pdi_t){.ctx = &ect_soes.below,
                               .read = read_over,
                               .write = write_over,
                               .al_event = ect_soes.below.al_event ? event_over : NULL};
    made_of.pdi = &ect_soes.pdi;
    wait_for_esc(&ect_soes.pdi);
    ect_soes.watchdog = ESCvar.watchdogcnt;
    while (ect_slave_init(&ect_soes.slave, &made_of, ect_soes_now()) == -3)
        ; /* the ESC does not respond at present */
}

static void step(void)
{
    uint8_t time[4];
    ect_soes.requested = false;
    if (ect_soes.pdi.read(ect_soes.pdi.ctx, ECT_REG_DC_SYSTEM_TIME, time, sizeof time) >= 0) {
        ESCvar.Time = ect_load_le32(time);
        ect_soes_follow_time(ESCvar.Time);
    }
    if (USE_EOE)
        ect_mailbox_wake(&ect_soes.slave); /* a SOES application does not announce frames, so its callback is polled */
    ect_soes.due_ns = ect_slave_mainline(&ect_soes.slave, ect_soes_now());
}

void ecat_slv_poll(void)
{
    step();
    if (ESCvar.esc_hw_eep_handler)
        ESCvar.esc_hw_eep_handler();
}

/* @return the stack's events that it waits for, and all events that are not the stack's */
static uint32_t wanted(void)
{
    const uint32_t ours = ESCREG_ALEVENT_CONTROL | ESCREG_ALEVENT_SMCHANGE | ESCREG_ALEVENT_SM0 | ESCREG_ALEVENT_SM1;
    return ~ours | ect_soes.wanted;
}

void ecat_slv_worker(uint32_t event_mask)
{
    enum { STEPS = 16 }; /* an event that remains after these steps activates the line again */
    for (unsigned int n = 0; n < STEPS; n++) {
        ecat_slv_poll();
        CC_ATOMIC_SET(ESCvar.ALevent, ESC_ALeventread());
        if ((ESCvar.ALevent & event_mask & wanted()) == 0)
            break;
    }
    ESC_ALeventmaskwrite(ESC_ALeventmaskread() | (event_mask & wanted()));
}

/* --- the pieces of a loop ----------------------------------------------------------------------------------------- */

void ESC_state(void)
{
    step();
}

void ESC_sm_act_event(void)
{
}

uint8_t ESC_mbxprocess(void)
{
    return 0;
}

void ESC_xoeprocess(void)
{
}

void ESC_coeprocess(void)
{
}

void ESC_foeprocess(void)
{
}

/* --- the exchange ------------------------------------------------------------------------------------------------- */

void APP_setwatchdog(int watchdogcnt)
{
    CC_ATOMIC_SET(ESCvar.watchdogcnt, watchdogcnt);
}

static void count_watchdog(void)
{
    bool outputs = (CC_ATOMIC_GET(ESCvar.App.state) & APPSTATE_OUTPUT) != 0;
    if (CC_ATOMIC_GET(ect_soes.watchdog) > 0)
        CC_ATOMIC_SUB(ect_soes.watchdog, 1);
    if (!outputs)
        CC_ATOMIC_SET(ect_soes.watchdog, ESCvar.watchdogcnt);
    else if (CC_ATOMIC_GET(ect_soes.watchdog) <= 0 && ESCvar.ESC_SM2_sml > 0)
        ESC_ALstatusgotoerror(ESCsafeop | ESCerror, ALERR_WATCHDOG);
}

void DIG_process(uint8_t flags)
{
    if ((flags & DIG_PROCESS_WD_FLAG) != 0)
        count_watchdog();
    if ((flags & DIG_PROCESS_OUTPUTS_FLAG) != 0)
        ect_soes_outputs();
    if ((flags & DIG_PROCESS_APP_HOOK_FLAG) != 0 && ESCvar.application_hook)
        ESCvar.application_hook();
    if ((flags & DIG_PROCESS_INPUTS_FLAG) != 0 && CC_ATOMIC_GET(ESCvar.App.state) != APPSTATE_IDLE)
        ect_soes_inputs();
}

void ecat_slv(void)
{
    ecat_slv_poll();
    DIG_process(DIG_PROCESS_WD_FLAG | DIG_PROCESS_OUTPUTS_FLAG | DIG_PROCESS_APP_HOOK_FLAG | DIG_PROCESS_INPUTS_FLAG);
}
