/* SPDX-License-Identifier: MIT */
/* The ports: cabling and DL control make link and loop bits of DL status (data sheet I §4). */
#include "esc/internal.h"

static bool has_link(const ect_esc_t *esc, unsigned int port)
{
    return (esc->config.open_ports & (1u << port)) != 0;
}

/* Two bits a port, DL status bit 8 on: 01 closed, 10 open and communicating, 11 closed in spite of a link. */
static unsigned int loop_state(const ect_esc_t *esc, unsigned int port)
{
    enum { FORCED_OPEN = 2, FORCED_CLOSED = 3 };
    ECT_ASSERT(port < ECT_ESC_PORTS);
    bool link = has_link(esc, port);
    unsigned int control = ((unsigned int)esc->memory[ECT_REG_DL_CONTROL + 1] >> (2 * port)) & 3u;
    if (control == FORCED_CLOSED && port != 0) /* port 0 is the way back to the master */
        return link ? 3 : 1;
    return link ? 2 : control == FORCED_OPEN ? 0 : 1;
}

void ect_esc_update_dl_status(ect_esc_t *esc)
{
    uint8_t *status = esc->memory + ECT_REG_DL_STATUS;
    unsigned int value = (esc->sii_valid ? 1u : 0u) | 2u; /* the PDI watchdog is never late: same process */
    for (unsigned int port = 0; port < ECT_ESC_PORTS; port++) {
        value |= has_link(esc, port) ? 0x10u << port : 0u;
        value |= loop_state(esc, port) << (8 + 2 * port);
    }
    if (value != ect_load_le16(status))
        ect_esc_raise_ecat(esc, ECT_ECAT_EVENT_DL_STATUS);
    ect_store_le16(status, (uint16_t)value);
}

void ect_esc_set_link(ect_esc_t *esc, unsigned int port, bool link)
{
    ECT_ASSERT(port < ECT_ESC_PORTS);
    unsigned int mask = 1u << port;
    esc->config.open_ports = (uint8_t)(link ? esc->config.open_ports | mask : esc->config.open_ports & ~mask);
    ect_esc_update_dl_status(esc);
}

bool ect_esc_port_open(const ect_esc_t *esc, unsigned int port)
{
    return loop_state(esc, port) == 2;
}

bool ect_esc_circulates(const ect_esc_t *esc)
{
    return loop_state(esc, 0) == 1;
}
