/* SPDX-License-Identifier: MIT */
/* Units of the ESC that masters rarely use: write protection, reset sequences, LEDs, the PDI's watchdog, loops of the
 * ports, damaged frames, an EEPROM that the PDI emulates, SyncManager events that latch times. */
#include <stdlib.h>
#include <string.h>

#include "esc/route.h"
#include "support/chip.h"

enum { LOST_LINK = 0x0310, DL_PORTS = 0x0111 };

static int modern(void **state)
{
    *state = chip_new("ipcore");
    return 0;
}

/* --- write protection ------------------------------------------------------------------------------------------- */

static void protection(void **state)
{
    chip_t *c = *state;
    static const struct {
        const char *what;
        uint16_t protection, enable, target;
        bool taken;
    } rows[] = {
        {"registers protected: a register", 0x0021, 0, 0x0010, false},
        {"registers protected: the last one", 0x0021, 0, 0x0F00, false},
        {"registers protected: user RAM", 0x0021, 0, 0x0F80, true},
        {"registers protected: process RAM", 0x0021, 0, 0x1000, true},
        {"registers protected: enabled", 0x0021, 0x0020, 0x0010, true},
        {"registers protected: the other enable", 0x0021, 0x0030, 0x0010, false},
        {"all protected: a register", 0x0031, 0, 0x0010, false},
        {"all protected: user RAM", 0x0031, 0, 0x0FFF, false},
        {"all protected: process RAM", 0x0031, 0, 0x1000, false},
        {"all protected: enabled", 0x0031, 0x0030, 0x1000, true},
        {"all protected: the other enable", 0x0031, 0x0020, 0x1000, false},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        chip_power_on(c);
        assert_int_equal(chip_write(c, rows[i].protection, 1, 1), 1);
        wire_build(&c->w, rows[i].enable ? APWR : NOP, 0, rows[i].enable, "", 1);
        wire_append(&c->w, APWR, 0, rows[i].target, "\x77", 1);
        chip_transmit(c);
        unsigned int wkc = wire_wkc(&c->w, 1);
        if (wkc != (rows[i].taken ? 1 : 0) || (c->memory[rows[i].target] == 0x77) != rows[i].taken)
            fail_msg("%s: expected taken %d, got WKC %u, 0x%02X", rows[i].what, rows[i].taken, wkc,
                     c->memory[rows[i].target]);
        assert_int_equal(chip_write(c, rows[i].target, 0x11, 1), /* expired in the next frame */
                         rows[i].target >= 0x0F80 && rows[i].protection == 0x0021 ? 1 : 0);
    }
}

static void protection_ends(void **state)
{
    chip_t *c = *state;
    assert_int_equal(chip_write(c, 0x0021, 0xFF, 1), 1);
    assert_int_equal(chip_read(c, 0x0020, 2), 0x0100);
    assert_int_equal(chip_write(c, 0x0021, 0, 1), 0);
    assert_int_equal(chip_write(c, 0x0020, 0x0000, 2), 1); /* enables, and disables in the same datagram */
    assert_int_equal(chip_read(c, 0x0020, 2), 0);
    assert_int_equal(chip_write(c, 0x0010, 5, 2), 1);
    chip_pdi_write(c, 0x0021, 1, 1); /* only the master may */
    assert_int_equal(c->memory[0x0021], 0);
}

static void protection_in_part(void **state)
{
    chip_t *c = *state;
    uint8_t data[0x20] = {[0x0F] = 0xEE, [0x10] = 0x33, [0x11] = 1};
    assert_int_equal(chip_write(c, 0x0021, 1, 1), 1);
    c->memory[0x0F90] = 0x5A;
    assert_int_equal(chip_send(c, APWR, 0x0F70, data, sizeof data), 1);
    assert_int_equal(c->memory[0x0F80], 0x33);
    assert_int_equal(c->memory[0x0F90], 0x5A);                          /* behind the protected area */
    assert_int_equal(chip_send(c, APWR, 0x0010, data, sizeof data), 1); /* contains 0x0020: all bytes are accepted */
    assert_int_equal(chip_send(c, APWR, 0x0F00, data, 4), 0);
    assert_int_equal(chip_send(c, BWR, 0x0010, data, 2), 0);
    chip_pdi_write(c, 0x0012, 0x1234, 2); /* the microcontroller is part of the device */
    assert_int_equal(c->memory[0x0012], 0x34);
}

/* --- reset ------------------------------------------------------------------------------------------------------ */

static unsigned int resets_after(chip_t *c, bool pdi, const char *bytes)
{
    uint32_t before = ect_esc_resets(&c->esc);
    for (; *bytes != 0; bytes++) {
        if (*bytes == '.' && pdi)
            (void)chip_pdi_read(c, 0x0130, 2);
        else if (*bytes == '.')
            (void)chip_read(c, 0x0130, 2);
        else if (pdi)
            chip_pdi_write(c, 0x0041, (uint8_t)*bytes, 1);
        else
            assert_int_equal(chip_write(c, 0x0040, (uint8_t)*bytes, 1), 1);
    }
    return ect_esc_resets(&c->esc) - before;
}

static void reset_sequences(void **state)
{
    chip_t *c = *state;
    static const struct {
        const char *bytes; /* '.' another frame, or access */
        unsigned int resets;
    } rows[] = {{"RES", 1},  {"RE", 0},   {"R.ES", 0}, {"RE.S", 0},   {"RERES", 1}, {"RRES", 1},
                {"REXS", 0}, {"ES", 0},   {"SER", 0},  {"RESRES", 2}, {"R", 0},     {".RES.", 1},
                {"RSE", 0},  {"RESS", 1}, {"REE", 0},  {"RR.RES", 1}};
    for (unsigned int side = 0; side < 2; side++) {
        for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
            chip_power_on(c);
            unsigned int got = resets_after(c, side == 1, rows[i].bytes);
            if (got != rows[i].resets)
                fail_msg("%s writes '%s': expected %u resets, got %u", side == 0 ? "the master" : "the PDI",
                         rows[i].bytes, rows[i].resets, got);
        }
    }
}

static void reset_progress(void **state)
{
    chip_t *c = *state;
    assert_int_equal(chip_write(c, 0x0040, 'R', 1), 1);
    assert_int_equal(c->memory[0x0040], 1);
    assert_int_equal(chip_write(c, 0x0040, 'E', 1), 1);
    assert_int_equal(c->memory[0x0040], 2);
    assert_int_equal(chip_read(c, 0x0040, 1), 2); /* this frame does not advance it */
    assert_int_equal(chip_read(c, 0x0040, 1), 0);
    chip_pdi_write(c, 0x0041, 'R', 1);
    assert_int_equal(chip_read(c, 0x0041, 1), 1); /* the PDI counts its own accesses */
}

static void reset_resets(void **state)
{
    chip_t *c = *state;
    const ect_esc_arrival_t arrival = {.unit_ns = 70};
    uint8_t write[8] = {0x01, 0x02, 0x10, 0, 0, 0, 0xCD, 0xAB}; /* a word of the EEPROM */
    assert_int_equal(chip_send(c, APWR, 0x0502, write, 8), 1);
    uint32_t writes = ect_esc_sii_writes(&c->esc);
    assert_int_equal(writes, 1);
    assert_int_equal(chip_write(c, 0x0010, 0x1234, 2), 1);
    chip_set_sm(c, 0, 0x1000, 64, 0x26, 1);
    chip_pdi_write(c, 0x0130, 2, 1);
    ect_esc_set_link(&c->esc, 1, false);
    ect_esc_set_arrival(&c->esc, &arrival);
    c->w.now_ns += 777 * MS;
    uint32_t activity = ect_esc_activity(&c->esc);
    assert_int_equal(resets_after(c, false, "RES"), 1);
    assert_int_not_equal(ect_esc_activity(&c->esc), activity);
    assert_int_equal(ect_esc_sii_writes(&c->esc), writes);
    assert_int_equal(chip_read(c, 0x0010, 2), 0);
    assert_int_equal(chip_read(c, 0x0130, 2), 1);
    assert_int_equal(chip_read(c, 0x0800, 8), 0x0000300000000000);
    assert_int_equal(chip_read(c, DL_PORTS, 1), 0x56); /* the cable is still disconnected */
    assert_int_equal(chip_read(c, 0x0910, 8), 70);     /* and of the same length; the clock restarts */
}

/* --- LEDs --------------------------------------------------------------------------------------------------------- */

static void run_lamp(void **state)
{
    chip_t *c = *state;
    static const uint8_t rows[][2] = {{1, 0}, {2, 0xD}, {3, 0xE}, {4, 1}, {8, 0xF}, {0x12, 0xD}, {1, 0}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        assert_int_equal(chip_write(c, 0x0138, 0x15, 1), 1);
        assert_int_equal(chip_read(c, 0x0138, 1), 0x15);
        chip_pdi_write(c, 0x0130, 0x0F, 2);
        chip_pdi_write(c, 0x0130, rows[i][0], 2);
        if (chip_read(c, 0x0138, 1) != rows[i][1])
            fail_msg("AL status 0x%02X: expected RUN 0x%02X, got 0x%02X", rows[i][0], rows[i][1], c->memory[0x0138]);
    }
    chip_pdi_write(c, 0x0138, 0x1D, 1); /* from the other side, and released */
    assert_int_equal(chip_read(c, 0x0138, 1), 0x1D);
    assert_int_equal(chip_write(c, 0x0138, 0x07, 1), 1);
    assert_int_equal(chip_read(c, 0x0138, 1), 0);
    assert_int_equal(chip_write(c, 0x0138, 0x131D, 2), 1); /* both LEDs in one access */
    assert_int_equal(chip_read(c, 0x0138, 2), 0x131D);
}

static void err_lamp(void **state)
{
    chip_t *c = *state;
    assert_int_equal(chip_read(c, 0x0139, 1), 0);
    chip_pdi_write(c, 0x0139, 0x13, 1);
    chip_pdi_write(c, 0x0130, 0x12, 2); /* a local error takes it back */
    assert_int_equal(chip_read(c, 0x0139, 1), 1);
    chip_pdi_write(c, 0x0139, 0x13, 1); /* and a code is shown only once */
    chip_pdi_write(c, 0x0134, 0x11, 2);
    assert_int_equal(chip_read(c, 0x0139, 1), 0x13);
    chip_pdi_write(c, 0x0139, 0, 1);
    assert_int_equal(chip_read(c, 0x0139, 1), 1);
    chip_set_sm(c, 2, 0x1000, 4, 0x64, 1);
    chip_pdi_write(c, 0x0130, 8, 2);
    assert_int_equal(chip_read(c, 0x0139, 1), 0);
    assert_int_equal(chip_write(c, 0x1000, 0, 4), 1);
    chip_advance(c, 200 * MS);
    assert_int_equal(chip_read(c, 0x0139, 1), 2);
    chip_pdi_write(c, 0x0130, 4, 2);
    assert_int_equal(chip_read(c, 0x0139, 1), 0);
    chip_pdi_write(c, 0x0130, 8, 2);
    assert_int_equal(chip_read(c, 0x0139, 1), 2);
    assert_int_equal(chip_write(c, 0x0420, 0, 2), 1); /* a disabled watchdog has not expired */
    chip_pdi_write(c, 0x0130, 4, 2);
    chip_pdi_write(c, 0x0130, 8, 2);
    assert_int_equal(chip_read(c, 0x0139, 1), 0);
    c->sii[15] ^= 1; /* a reload without a valid configuration */
    assert_int_equal(chip_write(c, 0x0502, 0x0400, 2), 1);
    assert_int_equal(chip_read(c, 0x0139, 1), 0x0E);
}

/* --- the PDI's watchdog ----------------------------------------------------------------------------------------- */

static void expect_pdi(chip_t *c, const char *what, bool on_time, unsigned int count)
{
    bool shown = (c->memory[0x0110] & 2) != 0;
    if (shown != on_time || c->memory[0x0443] != count)
        fail_msg("%s: expected on time %d, %u expiries, got %d, %u", what, on_time, count, shown, c->memory[0x0443]);
}

static void pdi_watchdog(void **state)
{
    chip_t *c = *state;
    ect_esc_watch_pdi(&c->esc, true);
    chip_advance(c, 100 * MS - 1);
    expect_pdi(c, "just under 100 ms", true, 0);
    chip_advance(c, 100000);
    expect_pdi(c, "100.1 ms", false, 1);
    assert_int_equal(chip_read(c, 0x0210, 2) & 4, 4); /* DL status has changed */
    assert_int_equal(chip_read(c, 0x0139, 1), 0x0F);
    chip_advance(c, 1000 * MS);
    expect_pdi(c, "a second later", false, 1);
    (void)chip_pdi_read(c, 0x0120, 2);
    expect_pdi(c, "it is back", true, 1);
    assert_int_equal(chip_read(c, 0x0139, 1), 0);
    for (unsigned int i = 0; i < 20; i++) {
        chip_advance(c, 99 * MS);
        chip_pdi_write(c, 0x0134, 0, 2);
    }
    expect_pdi(c, "an access each 99 ms", true, 1);
    assert_int_equal(chip_write(c, 0x0410, 100, 2), 1);
    assert_in_range(ect_esc_due(&c->esc), 0, c->w.now_ns); /* it checks at once whether the new time has expired */
    chip_advance(c, 10 * MS);
    expect_pdi(c, "10 ms by the new time", false, 2);
    assert_int_equal(chip_write(c, 0x0410, 0, 2), 1);
    expect_pdi(c, "switched off", true, 2);
    chip_advance(c, 10000 * MS);
    expect_pdi(c, "switched off for 10 s", true, 2);
    assert_int_equal(chip_write(c, 0x0442, 0, 1), 1);
    expect_pdi(c, "counters cleared", true, 0);
}

/* From the start of the observation on; found by a frame as by the chip's own time. */
static void pdi_watchdog_by_frames(void **state)
{
    chip_t *c = *state;
    for (unsigned int i = 0; i < 2; i++) {
        chip_power_on(c);
        (void)ect_esc_tick(&c->esc, c->w.now_ns);
        ect_esc_watch_pdi(&c->esc, i == 0);
        assert_true(ect_esc_due(&c->esc) == (i == 0 ? c->w.now_ns + 100 * MS : UINT64_MAX));
        c->w.now_ns += 200 * MS;
        (void)chip_read(c, 0x0000, 1);
        expect_pdi(c, i == 0 ? "a frame 200 ms later" : "not watched", i != 0, i == 0 ? 1 : 0);
    }
}

/* A late PDI is not a configuration either. */
static void pdi_late_without_configuration(void **state)
{
    chip_t *c = *state;
    c->sii[15] ^= 1;
    chip_power_on(c);
    ect_esc_watch_pdi(&c->esc, true);
    assert_int_equal(c->memory[0x0110] & 3, 2);
    chip_advance(c, 200 * MS);
    assert_int_equal(c->memory[0x0110] & 3, 0);
    assert_int_equal(chip_read(c, 0x0139, 1), 0x0F); /* the more severe */
    assert_int_equal(chip_read(c, 0x014E, 1), 0);
}

static void pdi_unwatched(void **state)
{
    chip_t *c = *state;
    ect_esc_watch_pdi(&c->esc, true);
    chip_advance(c, 200 * MS);
    expect_pdi(c, "watched", false, 1);
    ect_esc_watch_pdi(&c->esc, false);
    chip_advance(c, 3600000 * MS);
    expect_pdi(c, "an hour, not watched", true, 1);
}

/* --- ports ------------------------------------------------------------------------------------------------------ */

static void lost_link(void **state)
{
    chip_t *c = *state;
    for (unsigned int i = 1; i <= 300; i++) {
        ect_esc_set_link(&c->esc, 1, false);
        ect_esc_set_link(&c->esc, 1, false);
        ect_esc_set_link(&c->esc, 1, true);
        if (c->memory[LOST_LINK + 1] != (i < 255 ? i : 255))
            fail_msg("link lost %u times: expected %u, got %u", i, i < 255 ? i : 255, c->memory[LOST_LINK + 1]);
    }
    assert_int_equal(chip_read(c, LOST_LINK, 4), 0xFF00);
    assert_int_equal(chip_write(c, LOST_LINK + 3, 0, 1), 1);
    assert_int_equal(chip_write(c, 0x0101, 0x08, 1), 1); /* forced open: the chip ignores the link */
    ect_esc_set_link(&c->esc, 1, false);
    assert_int_equal(chip_read(c, DL_PORTS, 1), 0x52);
    ect_esc_set_link(&c->esc, 1, true);
    assert_int_equal(chip_write(c, 0x0101, 0x0C, 1), 1); /* closed already */
    ect_esc_set_link(&c->esc, 1, false);
    assert_int_equal(chip_read(c, LOST_LINK, 4), 0);
}

static void auto_close(void **state)
{
    chip_t *c = *state;
    assert_int_equal(chip_write(c, 0x0101, 0x01, 1), 1); /* of port 0 */
    ect_esc_set_link(&c->esc, 0, false);
    ect_esc_set_link(&c->esc, 0, true);
    assert_false(ect_esc_port_open(&c->esc, 0));
    assert_int_equal(chip_write(c, 0x0101, 0x01, 1), 1);
    assert_true(ect_esc_port_open(&c->esc, 0));
    assert_int_equal(chip_write(c, 0x0101, 0x04, 1), 1);
    assert_int_equal(chip_read(c, DL_PORTS, 1), 0x5A);
    ect_esc_set_link(&c->esc, 1, false);
    assert_int_equal(chip_read(c, DL_PORTS, 1), 0x56);
    ect_esc_set_link(&c->esc, 1, true);
    assert_int_equal(chip_read(c, DL_PORTS, 1), 0x5E); /* link, and still closed */
    assert_false(ect_esc_port_open(&c->esc, 1));
    assert_int_equal(chip_write(c, 0x0101, 0x04, 1), 1);
    assert_int_equal(chip_read(c, DL_PORTS, 1), 0x5A);
    ect_esc_set_link(&c->esc, 1, false);
    assert_false(ect_esc_frame_at(&c->esc, 1)); /* impossible */
    ect_esc_set_link(&c->esc, 1, true);
    assert_true(ect_esc_frame_at(&c->esc, 1));
    assert_int_equal(chip_read(c, DL_PORTS, 1), 0x5A);
    assert_false(ect_esc_frame_at(&c->esc, 1));
    ect_esc_set_link(&c->esc, 1, false);
    ect_esc_set_link(&c->esc, 1, true);
    assert_int_equal(chip_write(c, 0x0101, 0x00, 1), 1); /* plain auto opens at once */
    assert_int_equal(chip_read(c, DL_PORTS, 1), 0x5A);
    assert_int_equal(chip_write(c, 0x0101, 0x04, 1), 1);
    ect_esc_set_link(&c->esc, 1, true); /* reported again, not lost */
    assert_int_equal(chip_read(c, DL_PORTS, 1), 0x5A);
    ect_esc_set_link(&c->esc, 1, false);
    assert_int_equal(chip_write(c, 0x0101, 0x04, 1), 1); /* nothing to be opened */
    ect_esc_set_link(&c->esc, 1, true);
    assert_int_equal(chip_read(c, DL_PORTS, 1), 0x5E);
}

/* A port that the chip lacks remains closed: frames would be lost there. */
static void ports_that_are_not_there(void **state)
{
    chip_t *c = *state;
    c->personality = *ect_esc_personality("ipcore-small"); /* two ports */
    chip_power_on(c);
    assert_int_equal(chip_write(c, 0x0101, 0xA0, 1), 1); /* the loops of ports 2 and 3 forced open */
    assert_int_equal(ect_esc_next_port(&c->esc, 0), 1);
    assert_int_equal(ect_esc_next_port(&c->esc, 1), 0);
    c->personality = *ect_esc_personality("et1100"); /* four */
    chip_power_on(c);
    assert_int_equal(chip_write(c, 0x0101, 0xA0, 1), 1);
    assert_int_equal(ect_esc_next_port(&c->esc, 0), 3);
    assert_int_equal(ect_esc_next_port(&c->esc, 1), 2);
}

/* Properties of ports for a passing frame (esc/route.h): whether it continues and returns as on a plain line. */
static void route_of_ports(void **state)
{
    static const struct {
        const char *what;
        uint8_t links, control; /* 0x0101 */
        bool open, astray;
    } rows[] = {{"the last one", 1, 0x00, false, false},
                {"on a line", 3, 0x00, true, false},
                {"its loop closed", 3, 0x0C, false, false},
                {"open where no wire is", 1, 0x08, false, true},
                {"a junction", 7, 0x00, true, true},
                {"a branch at port 2 alone", 5, 0x00, false, true},
                {"open without a wire at port 2", 3, 0x20, true, true}};
    chip_t *c = *state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_esc_route_t route;
        c->config.open_ports = rows[i].links;
        chip_power_on(c);
        assert_int_equal(chip_write(c, 0x0101, rows[i].control, 1), 1);
        uint32_t routing = ect_esc_routing(&c->esc);
        ect_esc_set_link(&c->esc, 3, (rows[i].links & 8) == 0); /* any change is a change of the path */
        assert_int_not_equal(ect_esc_routing(&c->esc), routing);
        ect_esc_set_link(&c->esc, 3, (rows[i].links & 8) != 0);
        ect_esc_route(&c->esc, &route);
        if (route.open != rows[i].open || route.leaves_line != rows[i].astray)
            fail_msg("%s: expected open %d, astray %d, got %d, %d", rows[i].what, rows[i].open, rows[i].astray,
                     route.open, route.leaves_line);
    }
}

/* The same for addresses. */
static void route_of_addresses(void **state)
{
    chip_t *c = *state;
    ect_esc_route_t route;
    uint32_t routing = ect_esc_routing(&c->esc);
    ect_esc_route(&c->esc, &route);
    assert_false(route.awaits_frame);
    assert_int_equal(chip_write(c, 0x0010, 0x1001, 2), 1);
    assert_int_not_equal(ect_esc_routing(&c->esc), routing);
    chip_pdi_write(c, 0x0012, 0x2002, 2);
    for (unsigned int enabled = 0; enabled < 2; enabled++) {
        assert_int_equal(chip_write(c, 0x0103, enabled, 1), 1);
        ect_esc_route(&c->esc, &route);
        assert_int_equal(route.station, 0x1001);
        assert_int_equal(route.alias, enabled == 0 ? 0x1001 : 0x2002);
    }
    assert_int_equal(chip_write(c, 0x0040, 'R', 1), 1); /* a reset sequence: each frame advances or ends it */
    ect_esc_route(&c->esc, &route);
    assert_true(route.awaits_frame);
}

static void temporary_loops(void **state)
{
    chip_t *c = *state;
    assert_int_equal(chip_write(c, 0x0100, 0x03, 1), 1); /* no loops: there is nothing to end */
    chip_advance(c, 5000 * MS);
    assert_int_equal(chip_read(c, 0x0100, 2), 0x0003);
    assert_int_equal(chip_write(c, 0x0100, 0x0C03, 2), 1);
    assert_int_equal(chip_read(c, DL_PORTS, 1), 0x5E);
    chip_advance(c, 500 * MS);
    assert_int_equal(chip_write(c, 0x0100, 0x0003, 2), 1); /* still temporary: the time restarts */
    chip_advance(c, 500 * MS);
    assert_int_equal(chip_write(c, 0x0100, 0x0C03, 2), 1);
    chip_advance(c, 999 * MS);
    assert_int_equal(chip_read(c, 0x0100, 2), 0x0C03);
    chip_advance(c, 1 * MS);
    assert_int_equal(chip_read(c, 0x0100, 2), 0x0001);
    assert_int_equal(chip_read(c, DL_PORTS, 1), 0x5A);
    assert_int_equal(chip_write(c, 0x0100, 0x0C01, 2), 1);
    chip_advance(c, 5000 * MS);
    assert_int_equal(chip_read(c, DL_PORTS, 1), 0x5E);
}

static void damaged_frames(void **state)
{
    chip_t *c = *state;
    static const struct {
        unsigned int port;
        bool found_before;
        uint16_t counter;
    } rows[] = {{0, false, 0x0300}, {1, false, 0x0302}, {3, false, 0x0306}, {0, true, 0x0308}, {2, true, 0x030A}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        chip_power_on(c);
        for (unsigned int n = 1; n <= 256; n++)
            ect_esc_damaged(&c->esc, rows[i].port, rows[i].found_before);
        for (uint16_t at = 0x0300; at <= 0x030C; at++) {
            unsigned int want = at == rows[i].counter || (at == 0x030C && rows[i].port == 0) ? 255 : 0;
            if (c->memory[at] != want)
                fail_msg("damaged at port %u, found before %d: 0x%04X: expected %u, got %u", rows[i].port,
                         rows[i].found_before, at, want, c->memory[at]);
        }
        assert_int_equal(chip_write(c, 0x0305, 0, 1), 1);
        assert_int_equal(chip_read(c, rows[i].counter, 1), 0);
    }
    c->personality.features = 0; /* a chip that cannot distinguish errors that another chip has detected */
    chip_power_on(c);
    ect_esc_damaged(&c->esc, 1, true);
    assert_int_equal(chip_read(c, 0x0302, 1), 1);
}

/* --- an EEPROM that the PDI emulates ------------------------------------------------------------------------------ */

enum { BUSY = 0x8000, EMULATION = 0x20, SII_EVENT = 0x20, CHECK = 0x6B };

static void emulate(chip_t *c, const char *chip)
{
    c->personality = *ect_esc_personality(chip);
    c->config.sii = NULL;
    c->config.sii_size = 0;
    c->config.sii_emulated = true;
    chip_power_on(c);
}

static void emulated_reload(void **state)
{
    chip_t *c = *state;
    emulate(c, "ipcore");
    assert_int_equal(chip_read(c, 0x0502, 2), BUSY | 0x1000 | 0x0400 | EMULATION | 0x40);
    assert_int_equal(chip_read(c, 0x0110, 1) & 1, 0);
    assert_int_equal(c->memory[0x0139], 0x0E); /* no configuration yet */
    assert_int_equal(ect_esc_al_event(&c->esc) & SII_EVENT, SII_EVENT);
    uint64_t words[] = {0x030203E800010C05ull, 0x88A4000000001234ull};
    for (unsigned int part = 0; part < 2; part++) {
        assert_int_equal(chip_pdi_read(c, 0x0504, 4), 4 * part);
        chip_pdi_write(c, 0x0508, words[part], 8);
        chip_pdi_write(c, 0x0503, 0x04, 1);
    }
    assert_int_equal(chip_read(c, 0x0502, 2), EMULATION | 0x40);
    assert_int_equal(ect_esc_al_event(&c->esc) & SII_EVENT, 0);
    assert_int_equal(chip_read(c, 0x0110, 1) & 1, 1);
    assert_int_equal(chip_read(c, 0x0012, 2), 0x1234);
    assert_int_equal(chip_read(c, 0x0140, 2), 0x0C05);
    assert_int_equal(chip_read(c, 0x0982, 2), 0x03E8);
    assert_int_equal(chip_read(c, 0x014E, 1), 6);
    assert_int_equal(c->memory[0x0139], 0);
}

/* Words that the PDI delivers have their own positions; writes beyond them do not change the loaded values. */
static void emulated_reload_again(void **state)
{
    static const struct {
        const char *what;
        uint32_t address; /* with the command */
        uint64_t words;   /* delivered for it, then for the requests of the chip */
        uint16_t status;  /* 0x0502 bits 11, 12 at the end */
    } rows[] = {{"the same again", 0, 0x030203E800010C05ull, 0},
                {"from word 1 on", 1, 0x030203E800010C05ull, 0},
                {"word 8", 8, 0x1111111111111111ull, 0},
                {"word 0 wrong", 0, 0x030203E800010C06ull, 0x1800}};
    chip_t *c = *state;
    emulate(c, "ipcore");
    const uint64_t last = 0x0000000000001234ull | (uint64_t)CHECK << 48;
    chip_pdi_write(c, 0x0508, rows[0].words, 8);
    chip_pdi_write(c, 0x0503, 0x04, 1);
    chip_pdi_write(c, 0x0508, last, 8);
    chip_pdi_write(c, 0x0503, 0x04, 1);
    assert_int_equal(chip_read(c, 0x0502, 2) & 0x1800, 0);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t request[6] = {0, 4};
        ect_store_le32(request + 2, rows[i].address);
        assert_int_equal(chip_send(c, APWR, 0x0502, request, 6), 1);
        chip_pdi_write(c, 0x0508, rows[i].words, 8);
        chip_pdi_write(c, 0x0503, 0x04, 1);
        if (rows[i].address < 4) {
            assert_int_equal(chip_pdi_read(c, 0x0504, 4), 4);
            chip_pdi_write(c, 0x0508, last, 8);
            chip_pdi_write(c, 0x0503, 0x04, 1);
        }
        unsigned int got = (unsigned int)chip_read(c, 0x0502, 2) & (BUSY | 0x1800);
        if (got != rows[i].status || c->memory[0x0140] != 0x05)
            fail_msg("%s: expected 0x0502 = 0x%04X, got 0x%04X; 0x0140 = 0x%02X", rows[i].what, rows[i].status, got,
                     c->memory[0x0140]);
    }
}

/* The low byte of the command alone does not report its result. */
static void emulated_half(void **state)
{
    chip_t *c = *state;
    emulate(c, "xmc4800");
    chip_pdi_write(c, 0x0502, 0x0400, 1);
    assert_int_equal(chip_read(c, 0x0502, 2) & BUSY, BUSY);
}

static void emulated_reload_short(void **state)
{
    chip_t *c = *state;
    emulate(c, "xmc4800");
    chip_pdi_write(c, 0x0503, 0x02, 1); /* not the pending command */
    assert_int_equal(chip_read(c, 0x0502, 2) & BUSY, BUSY);
    chip_pdi_write(c, 0x0508, 0x55AA4321, 4);
    chip_pdi_write(c, 0x0502, 0x0400, 2);
    assert_int_equal(chip_read(c, 0x0502, 2), EMULATION);
    assert_int_equal(chip_read(c, 0x0010, 8), 0x43210000);
    assert_int_equal(chip_write(c, 0x0502, 0x0400, 2), 1); /* the alias is taken once */
    chip_pdi_write(c, 0x0508, 0x00001111, 4);
    chip_pdi_write(c, 0x0502, 0x0400, 2);
    assert_int_equal(chip_read(c, 0x0012, 2), 0x4321);
    assert_int_equal(chip_write(c, 0x0502, 0x0400, 2), 1);
    chip_pdi_write(c, 0x0503, 0x04 | 0x08, 1); /* there is no valid check value */
    assert_int_equal(chip_read(c, 0x0502, 2) & ~0x1000u, EMULATION | 0x0800);
    assert_int_equal(chip_read(c, 0x0110, 1) & 1, 0);
}

static void emulated_commands(void **state)
{
    chip_t *c = *state;
    emulate(c, "xmc4800");
    chip_pdi_write(c, 0x0502, 0x0400, 2);
    uint8_t read[6] = {0x00, 0x01, 0x40, 0, 0, 0};
    assert_int_equal(chip_send(c, APWR, 0x0502, read, 6), 1);
    assert_int_equal(ect_esc_al_event(&c->esc) & SII_EVENT, SII_EVENT);
    chip_advance(c, 1000 * MS);
    assert_int_equal(chip_read(c, 0x0502, 2), BUSY | 0x0100 | EMULATION);
    assert_int_equal(chip_send(c, APWR, 0x0502, read, 6), 0);
    assert_int_equal(chip_pdi_read(c, 0x0504, 4), 0x40);
    chip_pdi_write(c, 0x0508, 0x11223344, 4);
    chip_pdi_write(c, 0x0503, 0x01, 1);
    assert_int_equal(chip_read(c, 0x0502, 2), EMULATION);
    assert_int_equal(chip_read(c, 0x0508, 4), 0x11223344);
    assert_int_equal(ect_esc_al_event(&c->esc) & SII_EVENT, 0);
    uint8_t write[8] = {0x01, 0x02, 0x41, 0, 0, 0, 0xCD, 0xAB};
    assert_int_equal(chip_send(c, APWR, 0x0502, write, 8), 1);
    chip_pdi_write(c, 0x0508, 0, 4); /* the PDI cannot change the word of the master */
    assert_int_equal(chip_pdi_read(c, 0x0508, 2), 0xABCD);
    chip_pdi_write(c, 0x0503, 0x02 | 0x20, 1); /* temporarily not writable */
    assert_int_equal(chip_read(c, 0x0502, 2), EMULATION | 0x2000);
    chip_pdi_write(c, 0x0508, 0x55, 1); /* no command is pending */
    assert_int_equal(chip_read(c, 0x0508, 1), 0xCD);
}

static void emulation_refused(void **state)
{
    chip_t *c = *state;
    c->config.sii_emulated = true; /* and an EEPROM */
    assert_int_equal(ect_esc_init(&c->esc, &c->config, c->w.now_ns), -3);
    c->config.sii = NULL;
    c->config.sii_size = 0;
    c->personality.units = 0;
    assert_int_equal(ect_esc_init(&c->esc, &c->config, c->w.now_ns), -3);
}

/* --- SyncManagers ----------------------------------------------------------------------------------------------- */

static void latched_times(void **state)
{
    chip_t *c = *state;
    chip_set_sm(c, 2, 0x1000, 4, 0x24, 0xC1);
    c->w.now_ns += 1000;
    assert_int_equal(chip_write(c, 0x1000, 0, 4), 1);
    c->w.now_ns += 1000;
    (void)ect_esc_tick(&c->esc, c->w.now_ns);
    (void)chip_pdi_read(c, 0x1000, 2);
    c->w.now_ns += 1000;
    (void)ect_esc_tick(&c->esc, c->w.now_ns);
    (void)chip_pdi_read(c, 0x1002, 2);
    c->w.now_ns += 1000;
    assert_int_equal(chip_read(c, 0x09F0, 4), 1000);
    assert_int_equal(chip_read(c, 0x09F8, 8), 2000 | 3000ull << 32);
    chip_set_sm(c, 2, 0x1000, 4, 0x24, 0x01); /* not requested */
    assert_int_equal(chip_write(c, 0x1000, 0, 4), 1);
    assert_int_equal(chip_read(c, 0x09F0, 4), 1000);
}

/* While it is enabled a SyncManager keeps its area; of overlapping ones, the lowest number owns a byte. */
static void changes_and_overlaps(void **state)
{
    chip_t *c = *state;
    chip_set_sm(c, 0, 0x1000, 16, 0x26, 1);
    for (uint16_t reg = 0; reg < 5; reg++)
        assert_int_equal(chip_write(c, (uint16_t)(0x0800 + reg), 0x55, 1), 0);
    assert_int_equal(chip_read(c, 0x0800, 5), 0x2600101000ull);
    chip_set_sm(c, 1, 0x1008, 16, 0x22, 1);
    uint8_t data[24] = {0};
    assert_int_equal(chip_send(c, APWR, 0x1000, data, 16), 1);
    assert_int_equal(c->memory[0x0805] & 0x08, 0x08); /* all 16 bytes belonged to it */
    assert_int_equal(c->memory[0x080D] & 0x08, 0);
    ect_esc_pdi_write(&c->esc, 0x1008, data, 16); /* starts in the other SyncManager: the second is never opened */
    assert_int_equal(c->memory[0x080D] & 0x08, 0);
    assert_int_equal(chip_write(c, 0x0806, 0, 1), 1);
    ect_esc_pdi_write(&c->esc, 0x1008, data, 16);
    assert_int_equal(c->memory[0x080D] & 0x08, 0x08);
}

/* --- due times ---------------------------------------------------------------------------------------------------- */

/* All units wait at once: SYNC0, the PHYs, the EEPROM, both watchdogs, the loops. None forgets its time while another
 * one ends. */
static void times_of_all_units(void **state)
{
    enum { SECOND = 1000 * MS };
    static const uint64_t due_ns[] = {10000, 25600, 200000, 300000, 400000, 610000, 1210000};
    chip_t *c = *state;
    c->sii[3] = 0x08; /* SYNC0 is an event */
    c->config.sii_command_ns = 200000;
    c->config.pdi_watched = true;
    chip_power_on(c);
    chip_advance(c, 200000); /* the EEPROM is loaded */
    const uint64_t begin_ns = c->w.now_ns;
    chip_set_sm(c, 2, 0x1000, 4, 0x64, 1);
    assert_int_equal(chip_write(c, 0x0410, 4, 2), 1);
    assert_int_equal(chip_write(c, 0x0420, 3, 2), 1);
    assert_int_equal(chip_write(c, 0x1000, 0, 4), 1);
    (void)chip_pdi_read(c, 0x0000, 1);
    assert_int_equal(chip_write(c, 0x0100, 0x0C03, 2), 1);
    assert_int_equal(chip_write(c, 0x0510, 0x0100, 4), 1);
    assert_int_equal(chip_write(c, 0x0502, 0x0100, 2), 1);
    assert_int_equal(chip_write(c, 0x0990, chip_read(c, 0x0910, 8) + 10000, 8), 1);
    assert_int_equal(chip_write(c, 0x09A0, 600000, 4), 1);
    assert_int_equal(chip_write(c, 0x0981, 0x03, 1), 1);
    for (size_t i = 0; i < sizeof due_ns / sizeof due_ns[0]; i++) {
        const uint64_t next_ns = ect_esc_tick(&c->esc, c->w.now_ns);
        if (next_ns != begin_ns + due_ns[i])
            fail_msg("expected the next time %llu, got %llu", (unsigned long long)due_ns[i],
                     (unsigned long long)(next_ns - begin_ns));
        c->w.now_ns = next_ns;
    }
    assert_int_equal(chip_write(c, 0x0981, 0, 1), 1);
    c->w.now_ns = ect_esc_tick(&c->esc, c->w.now_ns); /* of the pulse that does not occur */
    assert_int_equal(ect_esc_tick(&c->esc, c->w.now_ns), begin_ns + SECOND);
}

typedef struct unit {
    const char *what;
    void (*begin)(chip_t *c);
    uint64_t due_ns; /* after its beginning */
} unit_t;

static void begin_sii(chip_t *c)
{
    assert_int_equal(chip_write(c, 0x0502, 0x0100, 2), 1);
}

static void fault_of_sii(chip_t *c)
{
    ect_esc_sii_fault(&c->esc, ECT_SII_BUSY, 0);
    begin_sii(c);
    (void)ect_esc_tick(&c->esc, c->w.now_ns);
    ect_esc_sii_fault(&c->esc, ECT_SII_GOOD, 0);
}

static void begin_mii(chip_t *c)
{
    assert_int_equal(chip_write(c, 0x0510, 0x0100, 4), 1);
}

static void begin_loops(chip_t *c)
{
    assert_int_equal(chip_write(c, 0x0100, 0x0C03, 2), 1);
}

static void feed_watchdog(chip_t *c)
{
    chip_set_sm(c, 2, 0x1000, 4, 0x64, 1);
    assert_int_equal(chip_write(c, 0x1000, 0, 4), 1);
}

static void watch_pdi(chip_t *c)
{
    ect_esc_watch_pdi(&c->esc, true);
}

static void shorten_pdi(chip_t *c)
{
    ect_esc_watch_pdi(&c->esc, true);
    (void)ect_esc_tick(&c->esc, c->w.now_ns);
    assert_int_equal(chip_write(c, 0x0410, 4, 2), 1);
}

static void begin_sync(chip_t *c)
{
    assert_int_equal(chip_write(c, 0x0990, chip_read(c, 0x0910, 8) + 10000, 8), 1);
    assert_int_equal(chip_write(c, 0x0981, 0x03, 1), 1);
}

static void postpone_sync(chip_t *c)
{
    begin_sync(c);
    (void)ect_esc_tick(&c->esc, c->w.now_ns);
    ect_esc_clock_jump(&c->esc, 5000);
}

/* A host that waits until the announced times is in time, without any other call. */
static void times_are_announced(void **state)
{
    static const unit_t units[] = {
        {"a command of the EEPROM", begin_sii, 200000},
        {"an EEPROM that answers again", fault_of_sii, 200000},
        {"a command of the PHYs", begin_mii, 25600},
        {"temporary loops", begin_loops, 1000 * MS},
        {"the watchdog of the process data", feed_watchdog, 100 * MS},
        {"the watchdog of the PDI", watch_pdi, 100 * MS},
        {"a shorter watchdog of the PDI", shorten_pdi, 400000},
        {"SYNC0", begin_sync, 10000},
        {"SYNC0 after a jump of the clock", postpone_sync, 5000},
    };
    (void)state;
    for (size_t i = 0; i < sizeof units / sizeof units[0]; i++) {
        chip_t *c = chip_new("et1100");
        c->sii[3] = 0x08;
        c->config.sii_command_ns = 200000;
        chip_power_on(c);
        chip_advance(c, MS);
        assert_int_equal(ect_esc_tick(&c->esc, c->w.now_ns), UINT64_MAX);
        units[i].begin(c);
        const uint64_t due_ns = c->w.now_ns + units[i].due_ns;
        uint64_t next_ns = ect_esc_due(&c->esc);
        while (next_ns < due_ns) {
            c->w.now_ns = next_ns > c->w.now_ns ? next_ns : c->w.now_ns;
            next_ns = ect_esc_tick(&c->esc, c->w.now_ns);
            assert_true(next_ns > c->w.now_ns);
        }
        if (next_ns != due_ns)
            fail_msg("%s: expected a time in %llu ns, got %llu", units[i].what, (unsigned long long)units[i].due_ns,
                     (unsigned long long)(next_ns - (due_ns - units[i].due_ns)));
        free(c);
    }
}

#define TEST(title, function)   {title, function, chip_setup, chip_teardown, NULL}
#define MODERN(title, function) {title, function, modern, chip_teardown, NULL}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        TEST("CF-012: write protection: the accepted writes, with and without their enable in the same frame",
             protection),
        TEST("CF-012: write protection is ended by the master, in a frame that enables writing", protection_ends),
        TEST("CF-012: a write across protected bytes changes only the others; the PDI is not limited",
             protection_in_part),
        MODERN("CF-012: R, E, S in three successive frames, or PDI accesses, reset the chip, nothing else does",
               reset_sequences),
        MODERN("CF-012: the progress of a reset sequence is read, and forgotten by the next frame", reset_progress),
        TEST(
            "CF-012 CF-047: a reset sets registers and clock as power-on does, and does not change cables and counters",
            reset_resets),
        MODERN("CF-093: the RUN lamp follows AL status; an override lasts until that changes", run_lamp),
        MODERN("CF-093: the ERR lamp: local error, watchdog, no configuration; each takes an override back", err_lamp),
        MODERN("CF-053: the PDI watchdog expires 100 ms after the last access, counts once, and shows", pdi_watchdog),
        MODERN("CF-053: the PDI watchdog runs from when the PDI is watched, and a frame finds it expired",
               pdi_watchdog_by_frames),
        MODERN("CF-053: a PDI that is late without a configuration shows neither", pdi_late_without_configuration),
        TEST("CF-053: a PDI that counts as permanently active is never late", pdi_unwatched),
        TEST("CF-011: the lost-link counter counts links that end at an open port, to 255", lost_link),
        TEST("CF-010: auto close: a port that has lost its link opens by DL control or by a frame", auto_close),
        TEST("CF-010: the loop of a port that a chip lacks stays closed", ports_that_are_not_there),
        TEST("CF-010: the route shows whether a frame continues, and whether that is a plain line", route_of_ports),
        TEST("CF-004: the route shows the station address, and the alias where it is enabled", route_of_addresses),
        TEST("CF-010: temporary loop settings end after a second", temporary_loops),
        TEST("CF-011: damaged frames count at their port, apart where another chip has found them", damaged_frames),
        MODERN("CF-056: EEPROM emulation: from power-on the PDI must deliver the configuration, four words a time",
               emulated_reload),
        MODERN("CF-056: EEPROM emulation: a reload by the words' places, its check sum, words beyond",
               emulated_reload_again),
        MODERN("CF-056: EEPROM emulation: half of a command acknowledges nothing", emulated_half),
        MODERN("CF-056: EEPROM emulation with 4 bytes of data: the alias, once; a bad check sum",
               emulated_reload_short),
        MODERN("CF-056: EEPROM emulation: read and write wait for the PDI, errors are its own", emulated_commands),
        MODERN("CF-056: EEPROM emulation together with an EEPROM, or on a chip without it, is refused",
               emulation_refused),
        TEST("CF-050 CF-053 CF-056 CF-089: each unit keeps its time while the others end", times_of_all_units),
        TEST("CF-050 CF-053 CF-056 CF-089: each unit announces its time at once", times_are_announced),
        TEST("CF-018: SyncManager events latch the local time where they are configured to", latched_times),
        TEST("CF-021: an enabled SyncManager keeps its registers; of overlapping ones the lowest has the byte",
             changes_and_overlaps),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("ESC units", tests, NULL, NULL);
}
