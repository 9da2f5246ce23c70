/* SPDX-License-Identifier: MIT */
#include "ports/mmio/mmio.h"

#include <stddef.h>
#include <string.h>

#include "wire/bytes.h"
#include "wire/registers.h"

/* A wide access stores the bytes in the order of the ESC, regardless of the processor's byte order. */
static void load_direct(const ect_mmio_t *esc, uint16_t address, uint8_t *to, unsigned int bytes)
{
    const volatile uint8_t *at = (const volatile uint8_t *)esc->base + address;
    if (bytes == 4) {
        uint32_t value = *(const volatile uint32_t *)(const volatile void *)at;
        memcpy(to, &value, bytes);
    } else if (bytes == 2) {
        uint16_t value = *(const volatile uint16_t *)(const volatile void *)at;
        memcpy(to, &value, bytes);
    } else {
        *to = *at;
    }
}

static void store_direct(const ect_mmio_t *esc, uint16_t address, const uint8_t *from, unsigned int bytes)
{
    volatile uint8_t *at = (volatile uint8_t *)esc->base + address;
    if (bytes == 4) {
        uint32_t value;
        memcpy(&value, from, bytes);
        *(volatile uint32_t *)(volatile void *)at = value;
    } else if (bytes == 2) {
        uint16_t value;
        memcpy(&value, from, bytes);
        *(volatile uint16_t *)(volatile void *)at = value;
    } else {
        *at = *from;
    }
}

static int load(const ect_mmio_t *esc, uint16_t address, uint8_t *to, unsigned int bytes)
{
    uint8_t word[4];
    uint32_t value = 0;
    if (!esc->load) {
        load_direct(esc, address, to, bytes);
        return 0;
    }
    int result = esc->load(esc->ctx, address, bytes, &value);
    ect_store_le32(word, value);
    memcpy(to, word, bytes);
    return result;
}

static int store(const ect_mmio_t *esc, uint16_t address, const uint8_t *from, unsigned int bytes)
{
    uint8_t word[4] = {0};
    if (!esc->store) {
        store_direct(esc, address, from, bytes);
        return 0;
    }
    memcpy(word, from, bytes);
    return esc->store(esc->ctx, address, bytes, ect_load_le32(word));
}

static unsigned int part(const ect_mmio_t *esc, uint32_t address, uint32_t left)
{
    return ect_pdi_part(address, left, esc->width != 0 ? esc->width : 4);
}

static int read(void *ctx, uint16_t address, void *buffer, uint16_t length)
{
    const ect_mmio_t *esc = ctx;
    uint8_t *to = buffer;
    for (uint32_t done = 0, bytes; done < length; done += bytes) {
        bytes = part(esc, address + done, length - done);
        if (load(esc, (uint16_t)(address + done), to + done, bytes) < 0)
            return -1;
    }
    return 0;
}

static int write(void *ctx, uint16_t address, const void *buffer, uint16_t length)
{
    const ect_mmio_t *esc = ctx;
    const uint8_t *from = buffer;
    for (uint32_t done = 0, bytes; done < length; done += bytes) {
        bytes = part(esc, address + done, length - done);
        if (store(esc, (uint16_t)(address + done), from + done, bytes) < 0)
            return -1;
    }
    return 0;
}

static int al_event(void *ctx, uint32_t *event)
{
    const ect_mmio_t *esc = ctx;
    return ect_pdi_line_event(esc->line(esc->ctx), read, ctx, event);
}

bool ect_mmio_ready(const ect_mmio_t *esc)
{
    uint8_t type = 0;
    uint8_t status = 0;
    return load(esc, ECT_REG_TYPE, &type, 1) >= 0 && load(esc, ECT_REG_DL_STATUS, &status, 1) >= 0 && type != 0 &&
           type != 0xFF && (status & 1u) != 0;
}

ect_pdi_t ect_mmio_pdi(const ect_mmio_t *esc)
{
    return (ect_pdi_t){
        .ctx = (void *)(uintptr_t)esc, .read = read, .write = write, .al_event = esc->line ? al_event : NULL};
}
