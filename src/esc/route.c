/* SPDX-License-Identifier: MIT */
/* Properties of a controller that affect passing frames. */
#include "esc/route.h"

#include "esc/internal.h"

static void add_window(const ect_esc_t *esc, unsigned int n, ect_esc_route_t *route)
{
    const uint8_t *fmmu = ect_esc_fmmu_registers(esc, n);
    ect_esc_window_t window = {.first = ect_load_le32(fmmu + ECT_FMMU_LOGICAL),
                               .length = ect_load_le16(fmmu + ECT_FMMU_LENGTH),
                               .direction = fmmu[ECT_FMMU_TYPE] & (ECT_PART_READ | ECT_PART_WRITE)};
    if ((fmmu[ECT_FMMU_ACTIVATE] & 1u) == 0 || window.length == 0 || window.direction == 0)
        return;
    route->windows[route->window_count++] = window;
}

/* Whether frames go from port 0 to port 1 and back, or return at once: no junction, and no loop open without a link. */
static bool is_of_a_line(const ect_esc_t *esc)
{
    unsigned int next = ect_esc_next_port(esc, 0);
    return next == 0 || (next == 1 && ect_esc_port_open(esc, 1) && ect_esc_next_port(esc, 1) == 0);
}

void ect_esc_route(const ect_esc_t *esc, ect_esc_route_t *route)
{
    const uint8_t *m = esc->memory;
    *route = (ect_esc_route_t){
        .station = ect_load_le16(m + ECT_REG_STATION_ADDRESS),
        .alias = ect_esc_second_station(esc),
        .events = ect_esc_shown_events(esc),
        .al_status = ect_load_le16(m + ECT_REG_AL_STATUS),
        .al_status_new = (ect_load_le16(m + ECT_REG_ECAT_EVENT) & ECT_ECAT_EVENT_AL_STATUS) != 0,
        .open = ect_esc_port_open(esc, 1),
        .leaves_line = ect_esc_circulates(esc) || !is_of_a_line(esc),
        .marks_source = ect_esc_marks_source(esc),
        .awaits_frame = (esc->per_frame & ECT_FRAME_BEGINS) != 0,
        .takes_time = ect_esc_dc_follows(esc, ECT_SIDE_ECAT),
        .guards_writes = (m[ECT_REG_WRITE_PROTECTION] | m[ECT_REG_ESC_WRITE_PROTECTION]) != 0,
    };
    for (unsigned int n = 0; n < esc->config.personality->fmmu_count; n++)
        add_window(esc, n, route);
}
