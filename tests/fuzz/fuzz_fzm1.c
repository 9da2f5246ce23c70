/* SPDX-License-Identifier: MIT */
/*
 * The FZM1 itself: the content of its memory at power-on, then random actions of a PLC, a user and a clock.
 * Input: a length, so many bytes that replace the beginning of a good record (its check value made right), then
 * operations.
 */
#include <stdlib.h>
#include <string.h>

#include "devices/fzm1/fzm1.h"
#include "devices/fzm1/instance.h"
#include "seams/record.h"

enum { BANK = 48 * 1024, OPERATION = 16 };

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static uint8_t banks[2][BANK];
static fzm1_t unit;
static bool off_bus, restart;

static int memory_read(void *ctx, unsigned int bank, uint32_t offset, void *buffer, uint32_t length)
{
    (void)ctx;
    memcpy(buffer, banks[bank] + offset, length);
    return 0;
}

static int memory_erase(void *ctx, unsigned int bank)
{
    (void)ctx;
    memset(banks[bank], 0xFF, BANK);
    return 0;
}

static int memory_write(void *ctx, unsigned int bank, uint32_t offset, const void *bytes, uint32_t length)
{
    (void)ctx;
    memcpy(banks[bank] + offset, bytes, length);
    return 0;
}

/* Every second question is answered. */
static int memory_flush(void *ctx, unsigned int bank, bool wait)
{
    static unsigned int questions;
    (void)ctx;
    (void)bank;
    return !wait && questions++ % 2 == 0 ? ECT_STORAGE_BUSY : 0;
}

static void host_off_bus(void *ctx, bool off)
{
    (void)ctx;
    off_bus = off;
}

static void host_restart(void *ctx)
{
    (void)ctx;
    restart = true;
}

static const ect_storage_t storage = {
    .bank_size = BANK, .read = memory_read, .erase = memory_erase, .write = memory_write, .flush = memory_flush};
static const ect_host_t host = {.off_bus = host_off_bus, .restart = host_restart, .storage = &storage};

static void power_on(uint64_t now_ns)
{
    memset(&unit, 0, sizeof unit - sizeof unit.plant);
    unit.standard.device = &ect_fzm1;
    const ect_od_t od = ect_device_od(&ect_fzm1, &unit);
    ect_od_set_defaults(&od);
    ect_fzm1.init(&unit, &host, now_ns);
}

static void spoil(const uint8_t *data, size_t size)
{
    uint8_t *bank = banks[ect_load_le32(banks[0]) == 0xFFFFFFFF ? 1 : 0];
    uint32_t length = ect_load_le32(bank + 8);
    memcpy(bank + ECT_RECORD_HEADER, data, size);
    uint32_t crc = ect_crc32(0xFFFFFFFF, bank + ECT_RECORD_HEADER, length);
    ect_store_le32(bank + 12, ect_record_check(crc, ect_load_le32(bank + 4), length));
}

/* Letters of expressions, and the end of the text. */
static void text_value(const uint8_t *b, uint8_t *value, size_t room)
{
    static const char letters[] = "DJG0123456789.+-*/() ~";
    for (size_t i = 0; i < room - 1 && i < 8; i++)
        value[i] = (uint8_t)letters[b[i] % sizeof letters];
}

/* A value of the signal's type and range. @return its size, 0: there is none */
static size_t signal_value(const ect_signal_t *signal, const uint8_t *b, uint8_t *value)
{
    int32_t number = (int32_t)ect_load_le32(b);
    double real = number;
    if (signal->type == ECT_SIGNAL_TEXT) {
        text_value(b, value, (size_t)signal->maximum + 1);
        return (size_t)signal->maximum + 1;
    }
    if (number < signal->minimum || number > signal->maximum)
        return 0;
    if (signal->type == ECT_SIGNAL_REAL) {
        memcpy(value, &real, sizeof real);
        return sizeof real;
    }
    memcpy(value, &number, sizeof number);
    return signal->type <= ECT_SIGNAL_U8 ? 1 : signal->type <= ECT_SIGNAL_U16 ? 2 : 4;
}

static void set_signal(const uint8_t *b, uint64_t now_ns)
{
    const ect_signal_group_t *group = &ect_fzm1_plant.signal_groups[(b[0] >> 2) % ect_fzm1_plant.signal_group_count];
    const ect_signal_t *signal = &group->signals[b[1] % group->signal_count];
    uint8_t value[256] = {0};
    size_t size = signal->access == ECT_SIGNAL_WRITE ? signal_value(signal, b + 2, value) : 0;
    if (size == 0 || ect_fzm1_plant.signal_write(&unit, signal, 0, value, now_ns))
        return;
    memcpy((uint8_t *)&unit + signal->offset, value, size);
    ect_fzm1_plant.signal_written(&unit, signal, 0, now_ns);
}

static void operate(const uint8_t *b, uint64_t *now_ns)
{
    static const uint8_t climb[] = {ECT_STATE_SAFEOP, ECT_STATE_OP};
    *now_ns += (uint64_t)ect_load_le16(b + 14) << (b[13] % 32);
    switch (b[0] % 4) {
    case 0:
        set_signal(b, *now_ns);
        break;
    case 1:
        (void)ect_fzm1.state_change(&unit, climb[b[1] & 1], climb[~b[1] & 1], *now_ns);
        break;
    default:
        unit.control_in = (uint32_t)(b[1] & 3) | (uint32_t)(b[1] & 4) << 14;
        unit.command_code = (b[2] & 0xF0u) << 8 | (uint32_t)(b[2] & 0x0F) << 20 | (b[3] & 1u) << 5 | (b[3] & 2u) << 3;
        for (unsigned int i = 0; i < 3; i++)
            unit.parameter[i] = (int8_t)b[4 + i] * (b[7] & 1 ? 1000 : 1);
        ect_fzm1.outputs(&unit, *now_ns);
        break;
    }
    if (ect_fzm1.tick(&unit, *now_ns) <= *now_ns)
        abort();
    if (restart)
        power_on(*now_ns);
    restart = false;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    uint64_t now_ns = 1;
    if (size < 2)
        return 0;
    memset(banks, 0xFF, sizeof banks);
    memset(&unit, 0, sizeof unit);
    power_on(now_ns);
    unit.scene.data[0] = 1;
    (void)fzm1_save(&unit);
    for (; fzm1_saving(&unit); now_ns += 1000000)
        (void)ect_fzm1.tick(&unit, now_ns);
    size_t part = ect_load_le16(data) % 400;
    part = part < size - 2 ? part : size - 2;
    if (part > 0)
        spoil(data + 2, part);
    power_on(now_ns);
    for (size_t at = 2 + part; at + OPERATION <= size; at += OPERATION)
        operate(data + at, &now_ns);
    return 0;
}
