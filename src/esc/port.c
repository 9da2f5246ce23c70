/* SPDX-License-Identifier: MIT */
/* The ports: cabling and DL control determine link and loop bits of DL status (data sheet I §3, §4; II §2.4, §2.9). */
#include "esc/internal.h"

/* DL control has two bits for each port, from bit 8 on. */
enum { AUTO, AUTO_CLOSE, OPEN, CLOSED };

/* DL status has two bits for each port, from bit 8 on. */
enum { OPEN_WITHOUT_LINK, SHUT, COMMUNICATES, SHUT_IN_SPITE_OF_LINK };

enum { TEMPORARY = 0x02, PDI_ON_TIME = 0x02, FIRST_LINK = 0x10 };

/* "About one second", the duration of temporary loop settings. */
#define TEMPORARY_NS 1000000000ull

static bool has_link(const ect_esc_t *esc, unsigned int port)
{
    return (esc->config.open_ports & (1u << port)) != 0;
}

static unsigned int control_of(const ect_esc_t *esc, unsigned int port)
{
    return ((unsigned int)esc->memory[ECT_REG_DL_CONTROL + 1] >> (2 * port)) & 3u;
}

static unsigned int loop_state(const ect_esc_t *esc, unsigned int port)
{
    ECT_ASSERT(port < ECT_ESC_PORTS);
    bool link = has_link(esc, port);
    unsigned int control = control_of(esc, port);
    bool closed = (control == CLOSED && port != 0) || /* port 0 is the way back to the master */
                  (control == AUTO_CLOSE && (esc->held_ports & (1u << port)) != 0);
    if (closed)
        return link ? SHUT_IN_SPITE_OF_LINK : SHUT;
    return link ? COMMUNICATES : control == OPEN ? OPEN_WITHOUT_LINK : SHUT;
}

static bool is_shut(const ect_esc_t *esc, unsigned int port)
{
    unsigned int state = loop_state(esc, port);
    return state == SHUT || state == SHUT_IN_SPITE_OF_LINK || (esc->config.personality->ports & (1u << port)) == 0;
}

/* The ports in the order in which frames pass them. */
static void find_next_ports(ect_esc_t *esc)
{
    static const uint8_t after[ECT_ESC_PORTS] = {3, 2, 0, 1};
    for (unsigned int port = 0; port < ECT_ESC_PORTS; port++) {
        uint8_t next = after[port];
        while (next != 0 && is_shut(esc, next))
            next = after[next];
        esc->next_port[port] = next;
    }
    esc->port_changes++;
}

void ect_esc_update_dl_status(ect_esc_t *esc)
{
    uint8_t *status = esc->memory + ECT_REG_DL_STATUS;
    unsigned int value = (esc->sii_valid ? 1u : 0u) | (esc->pdi_late ? 0u : (unsigned int)PDI_ON_TIME);
    for (unsigned int port = 0; port < ECT_ESC_PORTS; port++) {
        value |= has_link(esc, port) ? (unsigned int)FIRST_LINK << port : 0u;
        value |= loop_state(esc, port) << (8 + 2 * port);
    }
    if (value != ect_load_le16(status)) {
        ect_esc_raise_ecat(esc, ECT_ECAT_EVENT_DL_STATUS);
        find_next_ports(esc);
    }
    esc->routing++;
    ect_store_le16(status, (uint16_t)value);
}

/* Writing "auto close" again opens a port that waits for it. */
static void open_held(ect_esc_t *esc)
{
    for (unsigned int port = 0; port < ECT_ESC_PORTS; port++) {
        if (has_link(esc, port) || control_of(esc, port) != AUTO_CLOSE)
            esc->held_ports &= (uint8_t)~(1u << port);
    }
}

void ect_esc_port_control(ect_esc_t *esc, const ect_access_t *access, uint16_t address, uint16_t length)
{
    static const uint8_t writable[4] = {0x03, 0xFF, 0x4F, 0x01};
    uint8_t *control = esc->memory + ECT_REG_DL_CONTROL;
    uint8_t loops = esc->loops_revert_ns != UINT64_MAX ? esc->kept_loops : control[1];
    bool loops_written = address <= ECT_REG_DL_CONTROL + 1 && address + length > ECT_REG_DL_CONTROL + 1;
    for (uint16_t i = 0; i < length; i++) {
        uint16_t at = (uint16_t)(address - ECT_REG_DL_CONTROL + i);
        control[at] = (uint8_t)((control[at] & ~writable[at]) | (access->data[i] & writable[at]));
    }
    if (loops_written) {
        bool temporary = (control[0] & TEMPORARY) != 0;
        esc->kept_loops = loops;
        esc->loops_revert_ns = temporary ? esc->now_ns + TEMPORARY_NS : UINT64_MAX;
        ect_esc_expect(esc, esc->loops_revert_ns);
        open_held(esc);
    }
    ect_esc_update_dl_status(esc);
    esc->activity++; /* paths of frames, and the time of the next tick, may have changed */
}

void ect_esc_port_tick(ect_esc_t *esc)
{
    if (esc->now_ns < esc->loops_revert_ns) {
        ect_esc_expect(esc, esc->loops_revert_ns);
        return;
    }
    esc->loops_revert_ns = UINT64_MAX;
    esc->memory[ECT_REG_DL_CONTROL + 1] = esc->kept_loops;
    esc->memory[ECT_REG_DL_CONTROL] &= (uint8_t)~TEMPORARY;
    ect_esc_update_dl_status(esc);
}

void ect_esc_set_link(ect_esc_t *esc, unsigned int port, bool link)
{
    ECT_ASSERT(port < ECT_ESC_PORTS);
    unsigned int mask = 1u << port;
    bool lost = !link && loop_state(esc, port) == COMMUNICATES && control_of(esc, port) <= AUTO_CLOSE;
    esc->config.open_ports = (uint8_t)(link ? esc->config.open_ports | mask : esc->config.open_ports & ~mask);
    if (lost)
        ect_esc_count(esc, (uint16_t)(ECT_REG_LOST_LINK + port));
    if (lost && control_of(esc, port) == AUTO_CLOSE)
        esc->held_ports = (uint8_t)(esc->held_ports | mask);
    ect_esc_update_dl_status(esc);
}

bool ect_esc_frame_at(ect_esc_t *esc, unsigned int port)
{
    unsigned int mask = 1u << port;
    if ((esc->held_ports & mask) == 0 || !has_link(esc, port))
        return false;
    esc->held_ports = (uint8_t)(esc->held_ports & ~mask);
    ect_esc_update_dl_status(esc);
    return ect_esc_port_open(esc, port);
}

bool ect_esc_port_open(const ect_esc_t *esc, unsigned int port)
{
    return loop_state(esc, port) == COMMUNICATES;
}

bool ect_esc_circulates(const ect_esc_t *esc)
{
    return loop_state(esc, 0) == SHUT;
}

void ect_esc_damaged(ect_esc_t *esc, unsigned int port, bool found_before)
{
    ECT_ASSERT(port < ECT_ESC_PORTS);
    bool apart = found_before && (esc->config.personality->features & ECT_FEATURE_FCS) != 0;
    unsigned int counter = apart ? ECT_REG_FORWARDED_ERROR + port : ECT_REG_RX_ERROR + 2 * port;
    ect_esc_count(esc, (uint16_t)counter);
    if (port == 0)
        ect_esc_count(esc, ECT_REG_PROCESSING_ERROR);
}

/* The chip sets the "locally administered" bit of the source address, which identifies a frame on its way back. */
bool ect_esc_marks_source(const ect_esc_t *esc)
{
    return (esc->memory[ECT_REG_DL_CONTROL] & 0x01) != 0 && !esc->config.keep_source_mac;
}
