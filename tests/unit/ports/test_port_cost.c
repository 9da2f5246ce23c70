/* SPDX-License-Identifier: MIT */
/*
 * The cost of a slave on a LAN9252: PDI accesses, transfers and bytes on the SPI, counted at the virtual chip, and the
 * time that the bytes take at 20 MHz. docs/LAN9252.md has the same table, line by line.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "devices/eclink/eclink.h"
#include "devices/fzm1/fzm1.h"
#include "ports/lan9252/cost.h"
#include "ports/lan9252/lan9252.h"
#include "ports/virtual/lan9252.h"
#include "sii/fit.h"
#include "support/wire.h"

typedef struct rig {
    wire_t w;
    ect_device_t device; /* as it is on this chip */
    ect_virtual_lan9252_t chip;
    ect_spi_t spi;
    ect_lan9252_t port;
    ect_pdi_t spi_pdi, pdi;
    ect_slave_t *slave;
    unsigned int accesses;
    unsigned int activation_reads; /* of 0x0981 */
} rig_t;

static int counted_read(void *ctx, uint16_t address, void *buffer, uint16_t length)
{
    rig_t *r = ctx;
    r->accesses++;
    r->activation_reads += address == ECT_REG_DC_ACTIVATION;
    return r->spi_pdi.read(r->spi_pdi.ctx, address, buffer, length);
}

static int counted_write(void *ctx, uint16_t address, const void *buffer, uint16_t length)
{
    rig_t *r = ctx;
    r->accesses++;
    return r->spi_pdi.write(r->spi_pdi.ctx, address, buffer, length);
}

static int counted_event(void *ctx, uint32_t *event)
{
    rig_t *r = ctx;
    uint32_t before = r->chip.transfers;
    int result = r->spi_pdi.al_event(r->spi_pdi.ctx, event);
    r->accesses += r->chip.transfers != before;
    return result;
}

static void no_pause(void *ctx, uint32_t us)
{
    ect_virtual_lan9252_pause(ctx, us);
}

static void rig_open(rig_t *r, const ect_device_t *device, bool with_line)
{
    memset(r, 0, sizeof *r);
    assert_true(ect_fit(device, &ect_fit_lan9252, &r->device));
    wire_open_one(&r->w, &r->device);
    r->slave = (ect_slave_t *)(uintptr_t)ect_chain_slave(r->w.chain, 0);
    r->chip.esc = ect_chain_esc(r->w.chain, 0);
    r->spi = (ect_spi_t){.ctx = &r->chip,
                         .transfer = ect_virtual_lan9252_transfer,
                         .line = with_line ? ect_virtual_lan9252_line : NULL,
                         .pause = no_pause};
    r->port = (ect_lan9252_t){.spi = &r->spi};
    assert_int_equal(ect_lan9252_start(&r->port), ECT_LAN9252_READY);
    r->spi_pdi = ect_lan9252_pdi(&r->port);
    r->pdi = (ect_pdi_t){
        .ctx = r, .read = counted_read, .write = counted_write, .al_event = r->spi_pdi.al_event ? counted_event : NULL};
    ect_slave_config_t config = r->slave->config;
    config.pdi = &r->pdi;
    memset(config.instance, 0, config.device->instance_size);
    assert_int_equal(ect_slave_init(r->slave, &config, r->w.now_ns), 0);
    wire_go(&r->w, 0, ECT_STATE_OP);
    r->w.manual_poll = true;
}

static void rig_close(rig_t *r)
{
    assert_int_equal(r->chip.mistakes, 0);
    assert_int_equal(r->slave->pdi_errors, 0);
    wire_close(&r->w);
}

static void poll_slave(rig_t *r)
{
    (void)ect_slave_poll(r->slave, r->w.now_ns);
}

/* --- measurements --------------------------------------------------------------------------------------------- */

static void idle(rig_t *r)
{
    poll_slave(r);
}

/* The master has written the outputs and read the inputs. */
static void exchange(rig_t *r)
{
    poll_slave(r);
}

static void before_exchange(rig_t *r)
{
    uint8_t image[1500];
    assert_int_equal(wire_outputs(&r->w, 0, 0x01), 1);
    const ect_sm_t *in = &r->device.sm[3];
    assert_int_equal(wire_read(&r->w, 0, in->start, image, ect_device_sm_bytes(&r->device, 3)), 1);
}

/* Object 1018h:1, from the request in SM0 to the poll that detects that the reply was fetched. */
static void sdo(rig_t *r)
{
    uint8_t reply[1500];
    poll_slave(r);
    assert_true(wire_mail_receive(&r->w, 0, reply, sizeof reply) > 0);
    poll_slave(r);
    assert_int_equal(reply[8], 0x43);
}

static void before_sdo(rig_t *r)
{
    uint8_t mail[1500] = {10, 0, 0, 0, 0, 0, 0, 0x20, 0x40, 0x18, 0x10, 1};
    static unsigned int counter;
    mail[5] = (uint8_t)(3 | (counter++ % 7 + 1) << 4);
    assert_int_equal(wire_write(&r->w, 0, r->device.sm[0].start, mail, r->device.sm[0].length), 1);
}

typedef struct measured {
    unsigned int accesses, transfers, bytes;
} measured_t;

/* The second time: once through everything, the first reply and the device's own start are behind us. */
static measured_t measure(rig_t *r, void (*before)(rig_t *r), void (*what)(rig_t *r))
{
    measured_t m = {0};
    for (unsigned int n = 0; n < 3; n++) {
        if (before)
            before(r);
        r->accesses = r->chip.transfers = r->chip.bytes = 0;
        what(r);
        m = (measured_t){r->accesses, r->chip.transfers, r->chip.bytes};
    }
    return m;
}

/* --- the page ----------------------------------------------------------------------------------------------------- */

static char *page(void)
{
    static char text[64 * 1024];
    FILE *file = fopen(PAGE, "r");
    assert_non_null(file);
    text[fread(text, 1, sizeof text - 1, file)] = 0;
    (void)fclose(file);
    return text;
}

/* "12.3": SPI bytes at 20 MHz are 0.4 us each. */
static void expect_row(const char *device, const char *what, bool with_line, measured_t m)
{
    char row[160];
    (void)snprintf(row, sizeof row, "| %s | %s | %s | %u | %u | %u | %u.%u |\n", device, what, with_line ? "yes" : "no",
                   m.accesses, m.transfers, m.bytes, m.bytes * 4 / 10, m.bytes * 4 % 10);
    if (!strstr(page(), row))
        fail_msg("docs/LAN9252.md lacks this row: %s", row);
}

static void counted(void **state)
{
    static const struct {
        const char *name;
        const ect_device_t *device;
    } devices[] = {{"vr-bu-ect-map7", &ect_eclink_map7}, {"fzm1", &ect_fzm1}};
    (void)state;
    for (size_t d = 0; d < sizeof devices / sizeof devices[0]; d++) {
        for (int with_line = 0; with_line <= 1; with_line++) {
            rig_t r;
            rig_open(&r, devices[d].device, with_line != 0);
            expect_row(devices[d].name, "idle poll", with_line != 0, measure(&r, NULL, idle));
            expect_row(devices[d].name, "cyclic exchange", with_line != 0, measure(&r, before_exchange, exchange));
            expect_row(devices[d].name, "expedited SDO", with_line != 0, measure(&r, before_sdo, sdo));
            rig_close(&r);
        }
    }
}

static void expect_cost(rig_t *r, uint16_t address, uint16_t length, bool write)
{
    static uint8_t data[300];
    ect_lan9252_cost_t want = ect_lan9252_cost(address, length, write);
    r->chip.transfers = r->chip.bytes = 0;
    int result = write ? r->spi_pdi.write(r->spi_pdi.ctx, address, data, length)
                       : r->spi_pdi.read(r->spi_pdi.ctx, address, data, length);
    assert_int_equal(result, 0);
    if (r->chip.transfers != want.transfers || r->chip.bytes != want.bytes)
        fail_msg("%s of %u bytes at 0x%04X: the port needs %u transfers and %u bytes, ect_lan9252_cost has %u and %u",
                 write ? "write" : "read", length, address, r->chip.transfers, r->chip.bytes, want.transfers,
                 want.bytes);
}

/* User RAM, below 0x1000, is reached like registers; accesses may cross into process RAM. */
static void cost_function(void **state)
{
    rig_t r;
    (void)state;
    rig_open(&r, &ect_fzm1, false);
    for (uint16_t address = 0x0F80; address < 0x1080; address = (uint16_t)(address + (address < 0x0FF0 ? 13 : 1))) {
        for (uint16_t length = 1; length <= 300; length = (uint16_t)(length + (length < 70 ? 1 : 23))) {
            expect_cost(&r, address, length, false);
            expect_cost(&r, address, length, true);
        }
    }
    rig_close(&r);
}

static void activation_once(void **state)
{
    static const ect_device_t *const devices[] = {&ect_eclink_map7, &ect_fzm1};
    (void)state;
    for (size_t d = 0; d < sizeof devices / sizeof devices[0]; d++) {
        rig_t r;
        rig_open(&r, devices[d], false);
        r.w.manual_poll = false;
        wire_go(&r.w, 0, ECT_STATE_PREOP);
        r.activation_reads = 0;
        wire_configure_process_data(&r.w, 0);
        assert_int_equal(wire_al(&r.w, 0, ECT_STATE_SAFEOP, NULL), ECT_STATE_SAFEOP);
        assert_int_equal(r.activation_reads, 1);
        rig_close(&r);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"PDI budget: accesses and SPI bytes of poll, exchange and SDO are those of docs/LAN9252.md", counted, NULL,
         NULL, NULL},
        {"PDI budget: ect_lan9252_cost has the transfers and bytes that the port needs, at any address and length",
         cost_function, NULL, NULL, NULL},
        {"PDI budget: 0x0981 is read once on the way to SAFEOP", activation_once, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests_name("port_cost", tests, NULL, NULL);
}
