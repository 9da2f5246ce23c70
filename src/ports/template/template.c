/* SPDX-License-Identifier: MIT */
#include "ports/template/template.h"

/* @return 0; -1: not ready in time */
static int wait(const ect_window_t *w)
{
    for (unsigned int n = 0; n < w->patience; n++) {
        if ((w->load(w->ctx, ECT_WINDOW_COMMAND) & ECT_WINDOW_BEGIN) == 0)
            return 0;
    }
    return -1;
}

/* Begins an access of `bytes` bytes and waits for its end. */
static int command(const ect_window_t *w, uint32_t address, unsigned int bytes, uint32_t direction)
{
    w->store(w->ctx, ECT_WINDOW_COMMAND, ECT_WINDOW_BEGIN | direction | ECT_WINDOW_BYTES(bytes) | address);
    return wait(w);
}

static int read(void *ctx, uint16_t address, void *buffer, uint16_t length)
{
    const ect_window_t *w = ctx;
    uint8_t *to = buffer;
    if (wait(w) < 0) /* an abandoned access may still be under way */
        return -1;
    for (uint32_t done = 0, bytes; done < length; done += bytes) {
        bytes = ect_pdi_part(address + done, length - done, 4);
        if (command(w, address + done, bytes, ECT_WINDOW_READ) < 0)
            return -1;
        uint32_t data = w->load(w->ctx, ECT_WINDOW_DATA);
        for (unsigned int n = 0; n < bytes; n++)
            *to++ = (uint8_t)(data >> (8 * n));
    }
    return 0;
}

static int write(void *ctx, uint16_t address, const void *buffer, uint16_t length)
{
    const ect_window_t *w = ctx;
    const uint8_t *from = buffer;
    if (wait(w) < 0)
        return -1;
    for (uint32_t done = 0, bytes; done < length; done += bytes) {
        uint32_t data = 0;
        bytes = ect_pdi_part(address + done, length - done, 4);
        for (unsigned int n = 0; n < bytes; n++)
            data |= (uint32_t)*from++ << (8 * n);
        w->store(w->ctx, ECT_WINDOW_DATA, data);
        if (command(w, address + done, bytes, 0) < 0)
            return -1;
    }
    return 0;
}

ect_pdi_t ect_template_pdi(const ect_window_t *window)
{
    return (ect_pdi_t){.ctx = (void *)(uintptr_t)window, .read = read, .write = write, .al_event = 0};
}
