/* SPDX-License-Identifier: MIT */
/* The functions of firmware/board.h. The board writes the name of its device and each AL state to its serial line. */
#include "board.h"

#include "controller.h"
#include "cpu.h"
#include "mps2.h"
#include "ports/flash/flash.h"
#include "sii/sii.h"
#include "soes/describe.h"
#include "wire/registers.h"

enum { STORAGE = 0x80000 };

static _Noreturn void stop(const char *why)
{
    mps2_print(why);
    for (;;)
        cpu_sleep();
}

void board_init(int argc, char **argv)
{
    ect_device_t device;
    (void)argc;
    (void)argv;
    mps2_init();
    ect_soes_describe(&device);
    if (ect_sii_write(&device, NULL, 0, controller_sii(), CONTROLLER_SII) < 0)
        stop("the EEPROM is too small\n");
    if (controller_init(ect_esc_personality(device.esc), device.sii_size) != CONTROLLER_OK)
        stop("the Ethernet controller does not answer\n");
    mps2_print(device.name);
    mps2_print("\n");
}

uint64_t board_now_ns(void)
{
    return mps2_now_ns();
}

const ect_pdi_t *board_pdi(void)
{
    return controller_pdi();
}

static const char *state_name(uint8_t state)
{
    static const char *const names[] = {[ECT_STATE_INIT] = "INIT\n",
                                        [ECT_STATE_PREOP] = "PREOP\n",
                                        [ECT_STATE_BOOT] = "BOOT\n",
                                        [ECT_STATE_SAFEOP] = "SAFEOP\n",
                                        [ECT_STATE_OP] = "OP\n"};
    return state < sizeof names / sizeof names[0] && names[state] ? names[state] : "?\n";
}

void board_turn(uint64_t until_ns)
{
    static uint8_t told;
    uint8_t status;
    const ect_pdi_t *pdi = controller_pdi();
    if (pdi->read(pdi->ctx, ECT_REG_AL_STATUS, &status, 1) >= 0 && (status & 0x0F) != told) {
        told = status & 0x0F;
        mps2_print(state_name(told));
    }
    controller_wait(until_ns);
}

void board_reset(void)
{
    cpu_reset();
}

/* This board has no flash: the storage is memory that outlasts a reset, not a power-off. */
const ect_storage_t *board_storage(void)
{
    static uint8_t kept[2 * STORAGE] CPU_KEPT;
    static ect_flash_t flash = {.area = {0, STORAGE}, .area_size = STORAGE, .memory = kept};
    static ect_storage_t storage;
    storage = ect_flash_storage(&flash);
    return &storage;
}

uint16_t board_switches(void)
{
    return 0;
}

uint32_t board_serial(void)
{
    return 0;
}

static void light_run(void *ctx, bool lit)
{
    (void)ctx;
    mps2_led(0, lit);
}

static void light_err(void *ctx, bool lit)
{
    (void)ctx;
    mps2_led(1, lit);
}

const ect_leds_t *board_leds(void)
{
    static const ect_leds_t leds = {.run = light_run, .err = light_err};
    return &leds;
}
