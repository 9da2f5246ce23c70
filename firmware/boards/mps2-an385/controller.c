/* SPDX-License-Identifier: MIT */
#include "controller.h"

#include "cpu.h"
#include "esc/esc.h"
#include "lan9118.h"
#include "mps2.h"
#include "ports/virtual/virtual.h"

static lan9118_t mac;
static ect_esc_t esc;
static ect_pdi_t inner; /* the PDI of `esc`, for callers that have disabled interrupts */
static uint8_t memory[ECT_ESC_MEMORY_SIZE(CONTROLLER_RAM_KB)];
static uint8_t sii[CONTROLLER_SII];
static uint32_t frame[LAN9118_BUFFER / sizeof(uint32_t)];
static uint64_t wake_ns; /* end of the sleep of mainline */

/* --- in interrupts, or with interrupts off ------------------------------------------------------------------------ */

/* Advances the controller's own time, and sets the alarm for its next deadline. Mainline is already awake if it is due.
 */
static void pass_time(void)
{
    uint64_t now_ns = mps2_now_ns();
    uint64_t next_ns = ect_esc_tick(&esc, now_ns);
    mps2_alarm(wake_ns > now_ns && wake_ns < next_ns ? wake_ns : next_ns);
}

static void ethernet(void)
{
    size_t length;
    lan9118_acknowledge(&mac);
    while ((length = lan9118_receive(&mac, frame, sizeof frame)) > 0) {
        if (ect_esc_process(&esc, (uint8_t *)frame, length, mps2_now_ns()) == ECT_FRAME_FORWARD)
            (void)lan9118_send(&mac, frame, length);
    }
    pass_time();
}

void cpu_systick(void)
{
    pass_time();
}

CPU_VECTORS static const cpu_handler_t vectors[MPS2_INTERRUPT_ETHERNET + 1] = {
    [MPS2_INTERRUPT_ETHERNET] = ethernet,
};

/* --- mainline ----------------------------------------------------------------------------------------------------- */

static int pdi_read(void *ctx, uint16_t address, void *buffer, uint16_t length)
{
    (void)ctx;
    uint32_t before = cpu_interrupts_off();
    int result = inner.read(inner.ctx, address, buffer, length);
    cpu_interrupts_restore(before);
    return result;
}

static int pdi_write(void *ctx, uint16_t address, const void *buffer, uint16_t length)
{
    (void)ctx;
    uint32_t before = cpu_interrupts_off();
    int result = inner.write(inner.ctx, address, buffer, length);
    cpu_interrupts_restore(before);
    return result;
}

static int pdi_event(void *ctx, uint32_t *event)
{
    (void)ctx;
    uint32_t before = cpu_interrupts_off();
    int result = inner.al_event(inner.ctx, event);
    cpu_interrupts_restore(before);
    return result;
}

static const ect_pdi_t pdi = {.ctx = &esc, .read = pdi_read, .write = pdi_write, .al_event = pdi_event};

const ect_pdi_t *controller_pdi(void)
{
    return &pdi;
}

uint8_t *controller_sii(void)
{
    return sii;
}

controller_result_t controller_init(const ect_esc_personality_t *personality, uint32_t sii_size)
{
    const ect_esc_config_t config = {.personality = personality, .memory = memory, .sii = sii, .sii_size = sii_size};
    if (sii_size > sizeof sii || ect_esc_init(&esc, &config, mps2_now_ns()) != 0)
        return CONTROLLER_BAD_SII;
    inner = ect_virtual_pdi(&esc);
    if (!lan9118_init(&mac, MPS2_ETHERNET))
        return CONTROLLER_NO_ETHERNET;
    cpu_interrupt_enable(MPS2_INTERRUPT_ETHERNET);
    return CONTROLLER_OK;
}

void controller_wait(uint64_t until_ns)
{
    static uint32_t seen;
    uint32_t before = cpu_interrupts_off();
    wake_ns = until_ns;
    if (seen == ect_esc_activity(&esc) && mps2_now_ns() < until_ns) {
        pass_time();
        cpu_sleep();
    }
    cpu_interrupts_restore(before); /* the interrupt that has ended the sleep runs here */
    seen = ect_esc_activity(&esc);
}
