/* SPDX-License-Identifier: MIT */
/* A hardware file of SOES, compiled with the application and the headers of its stack, ectwin's or SOES's own. */
#include <ecat_slv.h>
#include <esc.h>

#include "ports/soes_hal/ectwin_soes.h"
#include "ports/soes_hal/hal.h"
#include "soes/describe.h"

void ESC_read(uint16_t address, void *buf, uint16_t len)
{
    ESCvar.ALevent = ect_soes_hal_read(address, buf, len);
}

void ESC_write(uint16_t address, void *buf, uint16_t len)
{
    ESCvar.ALevent = ect_soes_hal_write(address, buf, len);
}

void ESC_init(const esc_cfg_t *cfg)
{
    static ect_device_t device;
    (void)cfg;
    ect_soes_describe(&device);
    ect_soes_hal_init(&device);
}

void ESC_reset(void)
{
    ect_soes_hal_reset();
}

/*
 * Called by SOES's esc_eep.c, which an application that lists SOES's sources links with or without an emulated EEPROM.
 * The software ESC has an EEPROM of its own; a hardware file of the application takes precedence.
 */
void EEP_init(void);
int8_t EEP_read(uint32_t addr, uint8_t *data, uint16_t size);
int8_t EEP_write(uint32_t addr, uint8_t *data, uint16_t size);

__attribute__((weak)) void EEP_init(void)
{
}

/* The parameters are those of SOES. */
/* NOLINTBEGIN(readability-non-const-parameter) */
__attribute__((weak)) int8_t EEP_read(uint32_t addr, uint8_t *data, uint16_t size)
{
    (void)addr;
    (void)data;
    (void)size;
    return -1;
}

__attribute__((weak)) int8_t EEP_write(uint32_t addr, uint8_t *data, uint16_t size)
{
    (void)addr;
    (void)data;
    (void)size;
    return -1;
}
/* NOLINTEND(readability-non-const-parameter) */

__attribute__((weak)) esc_cfg_t *ectwin_soes_config(void)
{
    static esc_cfg_t config = {.watchdog_cnt = 1000};
    return &config;
}

int ectwin_soes_main(int argc, char **argv)
{
    if (!ect_soes_hal_arguments(argc, argv))
        return 1;
    ecat_slv_init(ectwin_soes_config());
    for (;;)
        ecat_slv();
}
