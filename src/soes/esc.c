/* SPDX-License-Identifier: MIT */
/* Registers of the ESC, and the functions by which an application sets the state. */
#include "soes/esc.h"

#include "soes/internal.h"
#include "wire/bytes.h"
#include "wire/registers.h"

static uint32_t read_register(uint16_t address, uint16_t length)
{
    uint8_t bytes[4] = {0};
    ESC_read(address, bytes, length);
    return ect_load_le32(bytes);
}

static void write_register(uint16_t address, uint32_t value, uint16_t length)
{
    uint8_t bytes[4];
    ect_store_le32(bytes, value);
    ESC_write(address, bytes, length);
}

uint32_t ESC_ALeventread(void)
{
    return read_register(ESCREG_ALEVENT, 4);
}

void ESC_ALeventwrite(uint32_t event)
{
    write_register(ESCREG_ALEVENT, event, 4);
}

uint32_t ESC_ALeventmaskread(void)
{
    return read_register(ESCREG_ALEVENTMASK, 4);
}

void ESC_ALeventmaskwrite(uint32_t mask)
{
    write_register(ESCREG_ALEVENTMASK, mask, 4);
}

void ESC_SMstatus(uint8_t n)
{
    uint8_t *registers = (uint8_t *)&ESCvar.SM[n];
    registers[ECT_SM_STATUS] = (uint8_t)read_register((uint16_t)(ESCREG_SM0STATUS + n * ECT_SM_SIZE), 1);
}

uint8_t ESC_WDstatus(void)
{
    return (uint8_t)read_register(ESCREG_WDSTATUS, 2);
}

void ESC_ALerror(uint16_t errornumber)
{
    ESCvar.ALerror = errornumber;
    write_register(ESCREG_ALERROR, errornumber, 2);
}

void ESC_ALstatus(uint8_t status)
{
    ESCvar.ALstatus = status;
    write_register(ESCREG_ALSTATUS, status, 2);
}

/* Requests a lower state, which the state machine enters in mainline; until then the application gets no outputs. */
void ESC_ALstatusgotoerror(uint8_t status, uint16_t errornumber)
{
    const ect_host_t *host = ect_slave_host(&ect_soes.slave);
    uint8_t state = status & ESCREG_AL_ERRACKMASK;
    if (state >= ESCop || state >= (ESCvar.ALstatus & ESCREG_AL_ERRACKMASK) || state == 0)
        return;
    if ((CC_ATOMIC_GET(ESCvar.App.state) & APPSTATE_OUTPUT) != 0) {
        CC_ATOMIC_AND(ESCvar.App.state, APPSTATE_INPUT);
        ect_soes.outputs_safe = true;
        APP_safeoutput();
    }
    ect_soes.fall_code = errornumber;
    host->drop(host->ctx, state, errornumber != ALERR_NONE ? errornumber : ALERR_UNSPECIFIEDERROR);
}

void APP_safeoutput(void)
{
    if (ESCvar.safeoutput_override)
        ESCvar.safeoutput_override();
}

void ESC_config(esc_cfg_t *cfg)
{
    ESCvar = (_ESCvar){
        .use_interrupt = cfg->use_interrupt,
        .watchdogcnt = cfg->watchdog_cnt,
        .mb = {{MBX0_sma, MBX0_sml, MBX0_sme, MBX0_smc, 0}, {MBX1_sma, MBX1_sml, MBX1_sme, MBX1_smc, 0}},
        .mbboot = {{MBX0_sma_b, MBX0_sml_b, MBX0_sme_b, MBX0_smc_b, 0},
                   {MBX1_sma_b, MBX1_sml_b, MBX1_sme_b, MBX1_smc_b, 0}},
        .skip_default_initialization = cfg->skip_default_initialization,
        .set_defaults_hook = cfg->set_defaults_hook,
        .pre_state_change_hook = cfg->pre_state_change_hook,
        .post_state_change_hook = cfg->post_state_change_hook,
        .application_hook = cfg->application_hook,
        .safeoutput_override = cfg->safeoutput_override,
        .pre_object_download_hook = cfg->pre_object_download_hook,
        .post_object_download_hook = cfg->post_object_download_hook,
        .pre_object_upload_hook = cfg->pre_object_upload_hook,
        .post_object_upload_hook = cfg->post_object_upload_hook,
        .rxpdo_override = cfg->rxpdo_override,
        .txpdo_override = cfg->txpdo_override,
        .esc_hw_interrupt_enable = cfg->esc_hw_interrupt_enable,
        .esc_hw_interrupt_disable = cfg->esc_hw_interrupt_disable,
        .esc_hw_eep_handler = cfg->esc_hw_eep_handler,
        .esc_check_dc_handler = cfg->esc_check_dc_handler,
        .get_device_id = cfg->get_device_id,
        .activemb0 = &ESCvar.mb[0],
        .activemb1 = &ESCvar.mb[1],
        .activembxsize = MBXSIZE,
    };
}
