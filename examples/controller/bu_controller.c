/* SPDX-License-Identifier: MIT */
#include "bu_controller.h"

#include <string.h>

#define MS 1000000ull

enum { IN_PCI = 0, IN_CCI = 1, IN_PAI = 2, IN_CAI = 3, IN_COMMAND_RU = 4, IN_COMMAND = 6, IN_BU_STATE = 22 };
enum {
    OUT_PCO = 0,
    OUT_CCO = 1,
    OUT_CAO = 3,
    OUT_COMMAND_RU = 4,
    OUT_COMMAND = 6,
    OUT_SIZE = 24,
    OUT_BLOCK = 26,
    OUT_DATA = 28
};
enum { BLOCK_BYTES = 200, PERIODIC_OUTPUTS = 228, BU_DISARMED = 0x10 };
#define PCI_TIMEOUT_NS (500 * MS)
#define PCO_LATEST_NS  (500 * MS)

void bu_controller_start(bu_controller_t *c)
{
    c->running = false;
    c->safe = true;
}

/* Without known counters the last command counts as done. */
static void take_counters(bu_controller_t *c, const uint8_t *in, uint64_t now_ns)
{
    if (!c->counters_known) {
        c->cco = in[IN_CAI];
        c->cao = in[IN_CCI];
        c->counters_known = true;
    }
    c->pci = in[IN_PCI];
    c->pco = in[IN_PAI];
    c->pci_deadline_ns = now_ns + PCI_TIMEOUT_NS;
    c->pco_deadline_ns = now_ns + PCO_LATEST_NS;
    c->block = 0;
    c->running = true;
}

static void watch_pci(bu_controller_t *c, const uint8_t *in, uint64_t now_ns)
{
    if (in[IN_PCI] != c->pci) {
        c->pci = in[IN_PCI];
        c->pci_deadline_ns = now_ns + PCI_TIMEOUT_NS;
    }
    c->safe = now_ns >= c->pci_deadline_ns || in[IN_BU_STATE] < BU_DISARMED;
}

static void receive_command(bu_controller_t *c, const uint8_t *in)
{
    if (in[IN_CCI] == c->cao)
        return;
    uint16_t ru = (uint16_t)(in[IN_COMMAND_RU] << 8 | in[IN_COMMAND_RU + 1]);
    if (c->on_command && ru != 0) /* 0: the base unit was restarted, there is no command */
        c->on_command(c->ctx, ru, in + IN_COMMAND);
    c->cao = in[IN_CCI];
}

static void send_command(bu_controller_t *c, const uint8_t *in, uint8_t *out)
{
    if (!c->to_send || in[IN_CAI] != c->cco)
        return;
    out[OUT_COMMAND_RU] = (uint8_t)(c->send_ru >> 8);
    out[OUT_COMMAND_RU + 1] = (uint8_t)c->send_ru;
    memcpy(out + OUT_COMMAND, c->send_data, BU_COMMAND_BYTES);
    c->cco++;
    c->to_send = false;
}

static void write_block(bu_controller_t *c, uint8_t *out)
{
    size_t offset = (size_t)c->block * BLOCK_BYTES;
    size_t length = c->periodic_size - offset < BLOCK_BYTES ? c->periodic_size - offset : BLOCK_BYTES;
    out[OUT_SIZE] = (uint8_t)(c->periodic_size >> 8);
    out[OUT_SIZE + 1] = (uint8_t)c->periodic_size;
    out[OUT_BLOCK] = c->block;
    memset(out + OUT_DATA, 0, BLOCK_BYTES);
    memcpy(out + OUT_DATA, c->periodic + offset, length);
    c->block++;
    if ((size_t)c->block * BLOCK_BYTES >= c->periodic_size) {
        c->block = 0;
        c->sets_sent++;
    }
}

/* Writes the next block when PAI has acknowledged the last one. PCO counts in any case, because the base unit otherwise
 * reports an error. */
static void send_periodic(bu_controller_t *c, const uint8_t *in, uint8_t *out, uint64_t now_ns)
{
    bool taken = in[IN_PAI] == c->pco;
    if (!taken && now_ns < c->pco_deadline_ns)
        return;
    if (taken && c->periodic && c->periodic_size > 0)
        write_block(c, out);
    c->pco++;
    c->pco_deadline_ns = now_ns + PCO_LATEST_NS;
}

void bu_controller_step(bu_controller_t *c, const uint8_t *in, uint8_t *out, uint64_t now_ns)
{
    if (!c->running)
        take_counters(c, in, now_ns);
    watch_pci(c, in, now_ns);
    if (c->output_bytes == 0)
        return; /* Input Only */
    receive_command(c, in);
    send_command(c, in, out);
    if (c->output_bytes >= PERIODIC_OUTPUTS)
        send_periodic(c, in, out, now_ns);
    out[OUT_PCO] = c->pco;
    out[OUT_CCO] = c->cco;
    out[OUT_CAO] = c->cao;
}

bool bu_controller_send(bu_controller_t *c, uint16_t ru, const uint8_t command[BU_COMMAND_BYTES])
{
    if (c->to_send || c->output_bytes == 0)
        return false;
    c->send_ru = ru;
    memcpy(c->send_data, command, BU_COMMAND_BYTES);
    c->to_send = true;
    return true;
}
