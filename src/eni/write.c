/* SPDX-License-Identifier: MIT */
/* The network around the slaves: master, cyclic frames, process image. */
#include "eni/write.h"

#include <stdio.h>

#include "eni/read.h"
#include "eni/write_slave.h"
#include "esc/route.h"
#include "wire/registers.h"

enum {
    FRAME_MOST = ECT_ENI_DATA + 12,
    OVERHEAD = ECT_DATAGRAM_DATA + ECT_DATAGRAM_COUNTER,
    STATE_BYTES = 2,
    SLAVES_MOST = UINT16_MAX - 1000,
    FMMU_AREA = 256,
    SM_AREA = 128,
    TIMES_AREA = 32, /* starts with the system time */
    SYSTEM_TIME_BYTES = 4,
    STATES_MOST = 8 * ECT_ENI_DATA
};

/* A cyclic command. */
typedef struct chunk {
    uint8_t command;
    uint32_t address, offset;
    size_t length;
    unsigned int counter;
} chunk_t;

typedef struct network {
    const ect_eni_part_t *parts;
    size_t count;
    uint32_t cycle_us;
    chunk_t *chunks;
    size_t chunk_count;
    uint32_t bytes[2]; /* outputs, inputs */
    size_t states;     /* mailboxes in the logical memory, a bit each */
    size_t reference;  /* slave with the reference clock; `count`: none */
} network_t;

static void add_chunk(ect_arena_t *arena, network_t *n, const chunk_t *chunk)
{
    n->chunks = ect_arena_grow(arena, n->chunks, n->chunk_count, sizeof *n->chunks);
    n->chunks[n->chunk_count++] = *chunk;
}

/* Divides the process data of one direction into commands, between slaves only. */
static void plan(ect_arena_t *arena, network_t *n, bool inputs)
{
    const uint32_t base = inputs ? ENI_LOGICAL_INPUTS : ENI_LOGICAL_OUTPUTS;
    chunk_t chunk = {.command = inputs ? ECT_LRD : ECT_LWR, .address = base};
    for (size_t i = 0; i < n->count; i++) {
        const uint32_t bytes = eni_bytes(n->parts[i].device, inputs);
        if (chunk.length > 0 && chunk.length + bytes > ECT_ENI_DATA) {
            add_chunk(arena, n, &chunk);
            chunk = (chunk_t){.command = chunk.command, .address = base + n->bytes[inputs], .offset = n->bytes[inputs]};
        }
        chunk.length += bytes;
        chunk.counter += bytes > 0;
        n->bytes[inputs] += bytes;
    }
    if (chunk.length > 0)
        add_chunk(arena, n, &chunk);
}

/* Gives each mailbox with a free FMMU a bit, if one datagram can contain all bits. */
static void plan_states(network_t *n)
{
    for (size_t i = 0; i < n->count; i++)
        n->states += eni_has_state(n->parts[i].device);
    n->states = n->states <= STATES_MOST ? n->states : 0;
}

static void plan_clock(network_t *n)
{
    while (n->reference < n->count && n->parts[n->reference].clock == NULL)
        n->reference++;
}

static size_t state_bytes(const network_t *n)
{
    return (n->states + 7) / 8;
}

/* --- master ------------------------------------------------------------------------------------------------------- */

static void write_clear(ect_xml_writer_t *xml, const network_t *n, const char *comment, uint16_t ado, size_t length)
{
    static const uint8_t zeros[FMMU_AREA];
    const eni_init_t init = {.transition = "IP",
                             .comment = comment,
                             .command = ECT_BWR,
                             .ado = ado,
                             .data = zeros,
                             .length = length,
                             .counter = n->count,
                             .before_slave = true};
    eni_write_init(xml, &init);
}

/* Only slaves with a clock process these commands. */
static void set_clocks(ect_xml_writer_t *xml, const char *comment, uint16_t ado, const uint8_t *data, size_t length)
{
    const eni_init_t init = {.transition = "IP",
                             .comment = comment,
                             .command = ECT_BWR,
                             .ado = ado,
                             .data = data,
                             .length = length,
                             .uncounted = true,
                             .before_slave = true};
    eni_write_init(xml, &init);
}

static void write_clocks(ect_xml_writer_t *xml, const network_t *n)
{
    static const uint8_t zeros[TIMES_AREA], speed[] = {0x00, 0x10}, filter[] = {0x00, 0x0C};
    if (n->reference == n->count)
        return;
    set_clocks(xml, "clear DC system time", ECT_REG_DC_SYSTEM_TIME, zeros, sizeof zeros);
    set_clocks(xml, "clear DC activation", ECT_REG_DC_ACTIVATION, zeros, 1);
    set_clocks(xml, "reset DC speed", ECT_REG_DC_SPEED_START, speed, sizeof speed);
    set_clocks(xml, "set DC filter", ECT_REG_DC_FILTER, filter, sizeof filter);
}

/* A chip clears as many FMMUs and SyncManagers as it has; its working counter does not depend on the number. */
static void write_master(ect_xml_writer_t *xml, const network_t *n)
{
    static const uint8_t broadcast[] = {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF}, own[] = {0x02, 0, 0, 0, 0, 0x01},
                         type[] = {0xA4, 0x88}, init_state[] = {1, 0}, mask[] = {0x0F, 0};
    const eni_init_t count = {.transition = "IP",
                              .comment = "all slaves are present, in INIT",
                              .command = ECT_BRD,
                              .ado = ECT_REG_AL_STATUS,
                              .length = STATE_BYTES,
                              .counter = n->count,
                              .before_slave = true,
                              .expected = init_state,
                              .mask = mask,
                              .timeout_ms = 3000};
    ect_xml_open(xml, "Master");
    ect_xml_open(xml, "Info");
    ect_xml_text(xml, "Name", "EtherCAT Master");
    ect_xml_bytes(xml, "Destination", broadcast, sizeof broadcast);
    ect_xml_bytes(xml, "Source", own, sizeof own);
    ect_xml_bytes(xml, "EtherType", type, sizeof type);
    ect_xml_close(xml);
    if (n->states > 0) {
        ect_xml_open(xml, "MailboxStates");
        ect_xml_number(xml, "StartAddr", ENI_LOGICAL_STATES);
        ect_xml_number(xml, "Count", (int64_t)n->states);
        ect_xml_close(xml);
    }
    ect_xml_open(xml, "InitCmds");
    eni_write_init(xml, &count);
    write_clear(xml, n, "clear the FMMUs", ECT_REG_FMMU, FMMU_AREA);
    write_clear(xml, n, "clear the SyncManagers", ECT_REG_SM, SM_AREA);
    write_clocks(xml, n);
    ect_xml_close(xml);
    ect_xml_close(xml);
}

/* --- cyclic frames ------------------------------------------------------------------------------------------------ */

static void write_states(ect_xml_writer_t *xml, bool preop)
{
    if (preop)
        ect_xml_text(xml, "State", "PREOP");
    ect_xml_text(xml, "State", "SAFEOP");
    ect_xml_text(xml, "State", "OP");
}

static void write_chunk(ect_xml_writer_t *xml, const chunk_t *chunk)
{
    const bool inputs = chunk->command == ECT_LRD;
    ect_xml_open(xml, "Cmd");
    write_states(xml, false);
    ect_xml_text(xml, "Comment", inputs ? "inputs" : "outputs");
    ect_xml_number(xml, "Cmd", chunk->command);
    ect_xml_number(xml, "Addr", chunk->address);
    ect_xml_number(xml, "DataLength", (int64_t)chunk->length);
    ect_xml_number(xml, "Cnt", chunk->counter);
    ect_xml_number(xml, "InputOffs", inputs ? chunk->offset : 0);
    ect_xml_number(xml, "OutputOffs", inputs ? 0 : chunk->offset);
    ect_xml_close(xml);
}

static void write_state_command(ect_xml_writer_t *xml, const network_t *n)
{
    ect_xml_open(xml, "Cmd");
    write_states(xml, true);
    ect_xml_text(xml, "Comment", "states of all slaves");
    ect_xml_number(xml, "Cmd", ECT_BRD);
    ect_xml_number(xml, "Adp", 0);
    ect_xml_number(xml, "Ado", ECT_REG_AL_STATUS);
    ect_xml_number(xml, "DataLength", STATE_BYTES);
    ect_xml_number(xml, "Cnt", (int64_t)n->count);
    ect_xml_number(xml, "InputOffs", n->bytes[1]);
    ect_xml_number(xml, "OutputOffs", 0);
    ect_xml_close(xml);
}

/* Writes the command that distributes the reference clock. @return bytes in the frame */
static size_t write_clock_command(ect_xml_writer_t *xml, const network_t *n)
{
    if (n->reference == n->count)
        return 0;
    ect_xml_open(xml, "Cmd");
    write_states(xml, true);
    ect_xml_text(xml, "Comment", "system time of the reference clock");
    ect_xml_number(xml, "Cmd", ECT_FRMW);
    ect_xml_number(xml, "Adp", (int64_t)(ENI_FIRST_STATION + n->reference));
    ect_xml_number(xml, "Ado", ECT_REG_DC_SYSTEM_TIME);
    ect_xml_number(xml, "DataLength", SYSTEM_TIME_BYTES);
    ect_xml_number(xml, "InputOffs", (int64_t)(n->bytes[1] + STATE_BYTES + state_bytes(n)));
    ect_xml_number(xml, "OutputOffs", 0);
    ect_xml_close(xml);
    return SYSTEM_TIME_BYTES + OVERHEAD;
}

/* @return bytes in the frame */
static size_t write_mailbox_command(ect_xml_writer_t *xml, const network_t *n)
{
    if (n->states == 0)
        return 0;
    ect_xml_open(xml, "Cmd");
    write_states(xml, true);
    ect_xml_text(xml, "Comment", "states of the mailboxes");
    ect_xml_number(xml, "Cmd", ECT_LRD);
    ect_xml_number(xml, "Addr", ENI_LOGICAL_STATES);
    ect_xml_number(xml, "DataLength", (int64_t)state_bytes(n));
    ect_xml_number(xml, "Cnt", (int64_t)n->states);
    ect_xml_number(xml, "InputOffs", n->bytes[1] + STATE_BYTES);
    ect_xml_number(xml, "OutputOffs", 0);
    ect_xml_close(xml);
    return state_bytes(n) + OVERHEAD;
}

static void write_cyclic(ect_xml_writer_t *xml, const network_t *n)
{
    size_t used = STATE_BYTES + OVERHEAD;
    ect_xml_open(xml, "Cyclic");
    ect_xml_number(xml, "CycleTime", n->cycle_us);
    ect_xml_open(xml, "Frame");
    used += write_clock_command(xml, n);
    write_state_command(xml, n);
    used += write_mailbox_command(xml, n);
    for (size_t i = 0; i < n->chunk_count; i++) {
        const size_t bytes = n->chunks[i].length + OVERHEAD;
        if (used + bytes > FRAME_MOST) {
            ect_xml_close(xml);
            ect_xml_open(xml, "Frame");
            used = 0;
        }
        write_chunk(xml, &n->chunks[i]);
        used += bytes;
    }
    ect_xml_close(xml);
    ect_xml_close(xml);
}

/* Places states, mailbox states and system time after the inputs of the slaves. */
static size_t own_bytes(const network_t *n)
{
    return STATE_BYTES + state_bytes(n) + (n->reference < n->count ? SYSTEM_TIME_BYTES : 0);
}

static void write_image(ect_xml_writer_t *xml, const network_t *n, bool inputs)
{
    uint32_t offset = 0;
    ect_xml_open(xml, inputs ? "Inputs" : "Outputs");
    ect_xml_number(xml, "ByteSize", inputs ? (int64_t)(n->bytes[1] + own_bytes(n)) : (int64_t)n->bytes[0]);
    for (size_t i = 0; i < n->count; i++) {
        eni_write_variables(xml, n->parts[i].device, i, inputs, offset);
        offset += eni_bytes(n->parts[i].device, inputs);
    }
    ect_xml_close(xml);
}

static void write_network(ect_xml_writer_t *xml, const void *what)
{
    const network_t *n = what;
    eni_share_t share = {.cycle_us = n->cycle_us};
    int bit = 0;
    ect_xml_open(xml, "EtherCATConfig");
    ect_xml_attribute(xml, "Version", "1.3");
    ect_xml_open(xml, "Config");
    write_master(xml, n);
    for (size_t i = 0; i < n->count; i++) {
        share.state_bit = n->states > 0 && eni_has_state(n->parts[i].device) ? bit++ : -1;
        share.reference = i == n->reference;
        eni_write_slave(xml, n->parts, i, &share);
        share.offsets[0] += eni_bytes(n->parts[i].device, false);
        share.offsets[1] += eni_bytes(n->parts[i].device, true);
    }
    write_cyclic(xml, n);
    ect_xml_open(xml, "ProcessImage");
    write_image(xml, n, true);
    write_image(xml, n, false);
    ect_xml_close(xml);
    ect_xml_close(xml);
    ect_xml_close(xml);
}

const char *ect_eni_write(ect_arena_t *arena, const ect_eni_part_t *parts, size_t count, uint32_t cycle_us,
                          size_t *length, char *text, size_t room)
{
    network_t n = {.parts = parts, .count = count, .cycle_us = cycle_us};
    if (count == 0 || count > SLAVES_MOST) {
        (void)snprintf(text, room, "a network file has 1 to %d slaves, not %zu", (int)SLAVES_MOST, count);
        return NULL;
    }
    plan_states(&n);
    plan_clock(&n);
    plan(arena, &n, false);
    plan(arena, &n, true);
    return ect_xml_file(arena, write_network, &n, length, text, room);
}
