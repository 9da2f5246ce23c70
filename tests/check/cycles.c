/* SPDX-License-Identifier: MIT */
/*
 * On a Cortex-M4 in QEMU: the instructions of slave stack, device and port, for each device behind its controller in
 * OP. The controller, the chip in front of it and the master are software here, and do not count. Each line is
 * DEVICE BOARD WORK COUNTED COMPUTED; a twin like that board uses the latter (bus/chain/slow_config.h).
 *
 * With -icount shift=10 an instruction takes 1024 ns, and the timer of the board counts each 40 ns.
 */
#include <stddef.h>
#include <string.h>

#include "bus/chain/slow_config.h"
#include "cpu.h"
#include "devices/eclink/eclink.h"
#include "devices/fzm1/fzm1.h"
#include "devices/optoncdt2300/optoncdt2300.h"
#include "devices/pmctendo/pmctendo.h"
#include "esc/esc.h"
#include "esc/personality.h"
#include "ports/lan9252/lan9252.h"
#include "ports/mmio/mmio.h"
#include "ports/virtual/lan9252.h"
#include "semihosting.h"
#include "sii/fit.h"
#include "sii/sii.h"
#include "slave/slave.h"

enum { TICKS = 256, INSTRUCTIONS = 10 }; /* so many ticks are so many instructions */
enum { MS = 1000000, APRD = 1, APWR = 2, HEADERS = 16, DATAGRAM = 10, COUNTER = 2, LARGEST = 1400, TRIES = 100 };

static max_align_t memory[4096];
static size_t used;
static uint8_t esc_memory[ECT_ESC_MEMORY_SIZE(60)], sii[8192], buffer[65536], frame[1514];
static uint32_t window[65536 / 4];
static ect_esc_t esc;
static ect_virtual_lan9252_t chip;
static ect_lan9252_t lan9252;
static ect_slave_t slave;
static ect_device_t device;
static uint64_t now_ns;

/* --- the count ---------------------------------------------------------------------------------------------------- */

#define TIMER_CONTROL REGISTER(0x40000000)
#define TIMER_VALUE   REGISTER(0x40000004)
#define TIMER_RELOAD  REGISTER(0x40000008)

static struct {
    uint32_t since, ticks; /* the timer counts down */
    uint32_t pauses;
    uint32_t pause_ticks; /* that a pause itself costs */
    uint32_t computed;
} count;

static inline void count_on(void)
{
    count.since = TIMER_VALUE;
}

static inline void count_off(void)
{
    count.ticks += count.since - TIMER_VALUE;
    count.pauses++;
}

static void count_new(void)
{
    count.ticks = count.pauses = count.computed = 0;
    count_on();
}

static uint32_t counted(void)
{
    uint32_t ticks = count.ticks - count.pauses * count.pause_ticks;
    return (ticks * INSTRUCTIONS + TICKS / 2) / TICKS;
}

static void calibrate(void)
{
    TIMER_RELOAD = TIMER_VALUE = UINT32_MAX;
    TIMER_CONTROL = 1;
    count_new();
    count_off();
    count.pause_ticks = count.ticks;
}

static _Noreturn void fail(const char *text)
{
    semihosting_write(text);
    semihosting_write("\n");
    semihosting_end(false);
}

_Noreturn void board_fault(void)
{
    fail("a fault");
}

static void *take(void *ctx, size_t bytes)
{
    void *taken = &memory[used];
    (void)ctx;
    used += (bytes + sizeof memory[0] - 1) / sizeof memory[0];
    if (used > sizeof memory / sizeof memory[0])
        fail("more memory");
    memset(taken, 0, bytes);
    return taken;
}

/* --- the controller ----------------------------------------------------------------------------------------------- */

static int transfer(void *ctx, uint8_t *bytes, uint16_t length)
{
    count_off();
    int result = ect_virtual_lan9252_transfer(ctx, bytes, length);
    count_on();
    return result;
}

static const ect_spi_t spi = {.ctx = &chip, .transfer = transfer};
static const ect_mmio_t mmio = {.base = window, .width = 2};
static ect_pdi_t port;
static const ect_board_t *board;
static bool mapped; /* the port moves bytes of the window, which the controller here does not know */

static int read(void *ctx, uint16_t address, void *to, uint16_t length)
{
    int result = port.read(ctx, address, to, length);
    count_off();
    if (mapped)
        (void)ect_esc_pdi_read(&esc, address, to, length);
    count.computed += board->instructions(address, length, false);
    count_on();
    return result;
}

static int write(void *ctx, uint16_t address, const void *from, uint16_t length)
{
    int result = port.write(ctx, address, from, length);
    count_off();
    if (mapped)
        (void)ect_esc_pdi_write(&esc, address, from, length);
    count.computed += board->instructions(address, length, true);
    count_on();
    return result;
}

static ect_pdi_t behind_port(void)
{
    mapped = strcmp(board->name, "et1100-mmio") == 0;
    if (mapped)
        return ect_mmio_pdi(&mmio);
    chip = (ect_virtual_lan9252_t){.esc = &esc};
    lan9252 = (ect_lan9252_t){.spi = &spi};
    if (ect_lan9252_start(&lan9252) != ECT_LAN9252_READY)
        fail("the chip does not start");
    return ect_lan9252_pdi(&lan9252);
}

static void power_on(const ect_device_t *of)
{
    static ect_pdi_t pdi;
    if (!ect_fit(of, board->controller, &device))
        fail("it does not fit");
    if (ect_sii_write(&device, NULL, 0, sii, sizeof sii) < 0)
        fail("no EEPROM");
    const ect_esc_config_t config = {.personality = ect_esc_personality(device.esc),
                                     .memory = esc_memory,
                                     .sii = sii,
                                     .sii_size = device.sii_size,
                                     .open_ports = 1};
    used = 0;
    now_ns += MS;
    if (ect_esc_init(&esc, &config, now_ns) != 0)
        fail("no controller");
    (void)ect_esc_tick(&esc, now_ns += MS);
    port = behind_port();
    pdi = (ect_pdi_t){.ctx = port.ctx, .read = read, .write = write};
    ect_slave_config_t slave_config = {.device = &device, .pdi = &pdi, .identity = &device.identity, .buffer = buffer};
    if (!ect_slave_take(&slave_config, take, NULL) || ect_slave_init(&slave, &slave_config, now_ns) != 0)
        fail("no slave");
}

/* --- the master --------------------------------------------------------------------------------------------------- */

static void poll(void)
{
    (void)ect_slave_poll(&slave, now_ns);
}

/* @return its working counter */
static unsigned int datagram(uint8_t command, uint16_t address, void *data, uint16_t length)
{
    static const uint8_t ethernet[] = {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 1, 1, 1, 1, 1, 1, 0x88, 0xA4, 0, 0x10};
    uint8_t *d = frame + HEADERS;
    memset(frame, 0, HEADERS + DATAGRAM);
    memcpy(frame, ethernet, sizeof ethernet);
    d[0] = command;
    ect_store_le16(d + 4, address);
    ect_store_le16(d + 6, length);
    memcpy(d + DATAGRAM, data, length);
    ect_store_le16(d + DATAGRAM + length, 0);
    (void)ect_esc_process(&esc, frame, (size_t)HEADERS + DATAGRAM + length + COUNTER, now_ns += 1000);
    memcpy(data, d + DATAGRAM, length);
    return ect_load_le16(d + DATAGRAM + length);
}

static void expect(unsigned int counter, const char *text)
{
    if (counter != 1)
        fail(text);
}

static void configure(void)
{
    for (unsigned int n = 0; n < device.sm_count; n++) {
        const ect_sm_t *sm = &device.sm[n];
        uint16_t length = ect_device_sm_bytes(&device, n);
        uint8_t registers[ECT_SM_SIZE] = {0};
        ect_store_le16(registers + ECT_SM_START, sm->start);
        ect_store_le16(registers + ECT_SM_LENGTH, length);
        registers[ECT_SM_CONTROL] = sm->control;
        registers[ECT_SM_ACTIVATE] = length > 0;
        if (sm->type != ECT_SM_UNUSED)
            expect(datagram(APWR, (uint16_t)(ECT_REG_SM + ECT_SM_SIZE * n), registers, sizeof registers), "no SM");
    }
}

static void exchange(uint8_t value)
{
    static uint8_t image[LARGEST];
    for (unsigned int n = 0; n < device.sm_count; n++) {
        uint16_t length = ect_device_sm_bytes(&device, n);
        memset(image, value, sizeof image);
        if (length > 0 && device.sm[n].type == ECT_SM_OUTPUTS)
            expect(datagram(APWR, device.sm[n].start, image, length), "no outputs");
        if (length > 0 && device.sm[n].type == ECT_SM_INPUTS)
            (void)datagram(APRD, device.sm[n].start, image, length);
    }
}

static void enter(uint8_t state)
{
    uint8_t control[2] = {(uint8_t)(state | ECT_AL_ACKNOWLEDGE)};
    uint8_t status[6] = {0};
    expect(datagram(APWR, ECT_REG_AL_CONTROL, control, sizeof control), "no AL control");
    for (unsigned int n = 0; n < TRIES && status[0] != state; n++) {
        now_ns += MS;
        (void)ect_esc_tick(&esc, now_ns);
        poll();
        expect(datagram(APRD, ECT_REG_AL_STATUS, status, sizeof status), "no AL status");
    }
    if (status[0] != state)
        fail("it does not enter the state");
}

static void operate(void)
{
    configure();
    enter(ECT_STATE_PREOP);
    enter(ECT_STATE_SAFEOP);
    exchange(0);
    poll();
    enter(ECT_STATE_OP);
}

/* --- what is counted ---------------------------------------------------------------------------------------------- */

static void print_number(uint32_t number, char end)
{
    char digits[12] = {0};
    char *at = &digits[sizeof digits - 1];
    *--at = end;
    do
        *--at = (char)('0' + number % 10);
    while ((number /= 10) > 0);
    semihosting_write(at);
}

static void print(const char *work, uint32_t cycle)
{
    semihosting_write(device.name);
    semihosting_write(" ");
    semihosting_write(board->name);
    semihosting_write(" ");
    semihosting_write(work);
    semihosting_write(" ");
    print_number(counted(), ' ');
    print_number(count.computed + cycle, '\n');
}

static void counted_poll(void)
{
    count_on();
    poll();
    count_off();
}

/* Object 1018h:1, and the poll that detects that the reply was fetched. */
static void upload(uint8_t counter)
{
    static uint8_t mail[LARGEST];
    memset(mail, 0, sizeof mail);
    memcpy(mail, (const uint8_t[]){10, 0, 0, 0, 0, (uint8_t)(3 | counter << 4), 0, 0x20, 0x40, 0x18, 0x10, 1}, 12);
    expect(datagram(APWR, device.sm[0].start, mail, device.sm[0].length), "no mail");
    counted_poll();
    expect(datagram(APRD, device.sm[1].start, mail, device.sm[1].length), "no reply");
    counted_poll();
    if (mail[8] != 0x43)
        fail("another reply");
}

/* The third time, as in tests/unit/ports/test_port_cost.c: the device's own start is over. */
static void run(void)
{
    enum { ROUNDS = 3 };
    for (uint8_t k = 1; k <= ROUNDS; k++) {
        now_ns += MS;
        count_new();
        counted_poll();
        if (k == ROUNDS)
            print("idle", 0);
        exchange(1);
        count_new();
        counted_poll();
        if (k == ROUNDS)
            print("exchange", ect_board_cycle(device.name));
        count_new();
        upload(k);
        if (k == ROUNDS)
            print("sdo", 0);
    }
}

int main(void)
{
    static const ect_device_t *const devices[] = {&ect_eclink_map1,     &ect_eclink_map3, &ect_eclink_map7,
                                                  &ect_eclink_multiarm, &ect_fzm1,        &ect_optoncdt2300,
                                                  &ect_pmctendo_dd5};
    calibrate();
    for (size_t b = 0; (board = ect_board_at(b)); b++) {
        for (size_t n = 0; n < sizeof devices / sizeof devices[0]; n++) {
            power_on(devices[n]);
            operate();
            run();
        }
    }
    semihosting_end(true);
}
