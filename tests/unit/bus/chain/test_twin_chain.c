/* SPDX-License-Identifier: MIT */
/* A chain of twins: their identities, their order, and the descriptions that are refused (chain.h). */
#include "bus/chain/chain.h"

#include <string.h>

#include "bus/chain/catalogue.h"
#include "bus/chain/steady.h"
#include "devices/eclink/eclink.h"
#include "slave/indicator.h"
#include "support/testdev.h"
#include "support/wire.h"

static void unusable_descriptions(void **state)
{
    ect_twin_config_t twins[2] = {ect_twin_default(&testdev, NULL), ect_twin_default(&testdev, NULL)};
    ect_device_t device = testdev;
    (void)state;
    twins[1].device = &device;
    device.esc = "et9999";
    assert_null(ect_chain_new(twins, 2, 0));
    device = testdev;
    device.sii_size = 256;
    assert_null(ect_chain_new(twins, 2, 0));
    device = testdev;
    ect_chain_t *chain = ect_chain_new(twins, 2, 0);
    assert_non_null(chain);
    assert_int_equal(ect_chain_count(chain), 2);
    ect_chain_free(chain);
    ect_chain_free(NULL);
}

static void overridden_identity(void **state)
{
    ect_twin_config_t twin = ect_twin_default(&testdev, NULL);
    wire_t w = {.now_ns = 1000 * MS};
    uint8_t address[2];
    (void)state;
    assert_memory_equal(&twin.identity, &testdev.identity, sizeof twin.identity);
    assert_int_equal(twin.alias, 0);
    twin.identity = (ect_identity_t){0x01020304, 0x05060708, 0x090A0B0C, 0x0D0E0F10};
    twin.alias = 0x1234;
    w.chain = ect_chain_new(&twin, 1, w.now_ns);
    assert_non_null(w.chain);
    ect_store_le16(address, WIRE_STATION);
    assert_int_equal(wire_send(&w, APWR, 0, ECT_REG_STATION_ADDRESS, address, 2), 1);
    assert_int_equal(wire_read16(&w, 0, 0x0012), 0x1234);
    wire_go(&w, 0, ECT_STATE_PREOP);
    const uint32_t want[] = {0x01020304, 0x05060708, 0x090A0B0C, 0x0D0E0F10};
    for (uint8_t n = 1; n <= 4; n++) {
        uint8_t data[4];
        size_t size = sizeof data;
        assert_int_equal(wire_sdo_upload(&w, 0, 0x1018, n, false, data, &size), 0);
        assert_int_equal(ect_load_le32(data), want[n - 1]);
    }
    wire_close(&w);
}

static void found_by_alias(void **state)
{
    static const struct {
        uint16_t alias;
        size_t found;
    } rows[] = {{7, 1}, {17, 2}, {18, 0}, {0xFFFF, 4}};
    static const uint16_t aliases[] = {7, 17, 17, 0xFFFF};
    ect_twin_config_t twins[4];
    (void)state;
    for (size_t i = 0; i < 4; i++) {
        twins[i] = ect_twin_default(&testdev, NULL);
        twins[i].alias = aliases[i];
    }
    ect_chain_t *chain = ect_chain_new(twins, 4, 0);
    assert_non_null(chain);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
        assert_int_equal(ect_chain_find_alias(chain, rows[i].alias), rows[i].found);
    ect_store_le16(ect_chain_esc(chain, 3)->memory + ECT_REG_STATION_ALIAS, 21); /* as a reload of the EEPROM does */
    assert_int_equal(ect_chain_find_alias(chain, 21), 4);
    ect_chain_free(chain);
}

static void order_of_the_wire(void **state)
{
    const ect_device_t *devices[40];
    wire_t w;
    (void)state;
    for (size_t i = 0; i < 40; i++)
        devices[i] = i % 5 == 4 ? &testdev : ect_catalogue_at(i % 5)->device;
    wire_open(&w, devices, 40);
    assert_int_equal(ect_chain_count(w.chain), 40);
    uint8_t data[2] = {0};
    assert_int_equal(wire_send(&w, BRD, 0, 0x0000, data, 1), 40);
    for (size_t i = 0; i < 40; i++) {
        assert_ptr_equal(wire_device(&w, i), devices[i]);
        assert_int_equal(wire_read8(&w, i, 0x0000), ect_esc_personality(devices[i]->esc)->type);
        wire_go(&w, i, ECT_STATE_PREOP);
    }
    /* Two ports open on the way, one at the end. */
    assert_int_equal(wire_read16(&w, 0, 0x0110) >> 8, 0x5A);
    assert_int_equal(wire_read16(&w, 39, 0x0110) >> 8, 0x56);
    wire_close(&w);
}

static void source_address(void **state)
{
    (void)state;
    for (int keep = 0; keep <= 1; keep++) {
        ect_twin_config_t twin = ect_twin_default(&testdev, NULL);
        wire_t w = {.now_ns = 1000 * MS};
        uint8_t data = 0;
        twin.keep_source_mac = keep != 0;
        w.chain = ect_chain_new(&twin, 1, w.now_ns);
        assert_non_null(w.chain);
        assert_int_equal(wire_send(&w, BRD, 0, 0, &data, 1), 1);
        assert_int_equal(w.frame[6], keep != 0 ? 0x01 : 0x03);
        wire_close(&w);
    }
}

static void not_ethercat(void **state)
{
    wire_t w;
    (void)state;
    wire_open_one(&w, &testdev);
    wire_build(&w, BRD, 0, 0, "", 1);
    w.frame[12] = 0x08;
    assert_false(wire_transmit(&w));
    wire_close(&w);
}

/* The earliest deadline of all twins; without one, never. */
static void deadlines(void **state)
{
    const ect_device_t *unit = &ect_eclink_map1;
    ect_twin_config_t twins[3] = {ect_twin_default(&testdev, NULL), ect_twin_default(unit, &ect_eclink_plant),
                                  ect_twin_default(&testdev, NULL)};
    (void)state;
    ect_chain_t *chain = ect_chain_new(twins, 1, 5 * MS);
    assert_true(ect_chain_poll(chain, 5 * MS) == ECT_NEVER);
    assert_true(ect_chain_poll(chain, 6 * MS) == ECT_NEVER);
    ect_chain_free(chain);
    chain = ect_chain_new(twins, 3, 5 * MS);
    assert_true(ect_chain_poll(chain, 5 * MS) == 130 * MS);
    assert_true(ect_chain_poll(chain, 100 * MS) == 130 * MS);
    assert_true(ect_chain_poll(chain, 130 * MS) == 255 * MS);
    ect_chain_free(chain);
}

static void starts_off_the_bus(void *instance, const ect_host_t *host, uint64_t now_ns)
{
    testdev.init(instance, host, now_ns);
    host->off_bus(host->ctx, true);
}

/* As a unit whose fieldbus is switched off in its settings. */
static void off_from_the_start(void **state)
{
    ect_device_t device = testdev;
    const ect_twin_config_t twins[] = {ect_twin_default(&testdev, NULL), ect_twin_default(&device, NULL),
                                       ect_twin_default(&testdev, NULL)};
    uint8_t data = 0;
    wire_t w = {.now_ns = 1000 * MS};
    (void)state;
    device.init = starts_off_the_bus;
    w.chain = ect_chain_new(twins, 3, w.now_ns);
    assert_non_null(w.chain);
    wire_poll(&w);
    assert_int_equal(wire_send(&w, BRD, 0, 0, &data, 1), 1);
    assert_int_equal(ect_chain_esc(w.chain, 0)->memory[0x0111], 0x56); /* no link at port 1 */
    testdev_of(&w, 1)->host->off_bus(testdev_of(&w, 1)->host->ctx, false);
    ect_chain_wake(w.chain, 1);
    wire_poll(&w);
    assert_int_equal(wire_send(&w, BRD, 0, 0, &data, 1), 3);
    wire_close(&w);
}

/* Every 10 ms from 1 s on: off the bus, back, and so on. */
static uint64_t leaves_and_returns(void *instance, uint64_t now_ns)
{
    const ect_host_t *host = ((const testdev_t *)instance)->host;
    host->off_bus(host->ctx, now_ns / (10 * MS) % 2 != 0);
    return (now_ns / (10 * MS) + 1) * 10 * MS;
}

/* No frame and no other twin is needed for the change of the links. */
static void off_by_itself(void **state)
{
    ect_device_t device = testdev;
    const ect_twin_config_t twins[] = {ect_twin_default(&testdev, NULL), ect_twin_default(&device, NULL),
                                       ect_twin_default(&testdev, NULL)};
    wire_t w;
    (void)state;
    device.tick = leaves_and_returns;
    wire_open_twins(&w, twins, 3);
    w.manual_poll = true;
    for (unsigned int n = 0; n < 6; n++) {
        uint8_t data = 0;
        w.now_ns = 2000 * MS + n * 10 * MS;
        (void)ect_chain_poll(w.chain, w.now_ns);
        assert_int_equal(wire_send(&w, BRD, 0, 0, &data, 1), n % 2 == 0 ? 3 : 1);
        (void)ect_chain_poll(w.chain,
                             w.now_ns); /* the twins that the frame has reached: none is due at the next time */
    }
    wire_close(&w);
}

/* The ESC raises the event at the poll of its deadline: no frame and no other poll is needed. */
static void watchdog_at_its_deadline(void **state)
{
    uint64_t next_ns = 0;
    wire_t w;
    (void)state;
    wire_open_one(&w, &testdev);
    wire_go(&w, 0, ECT_STATE_OP);
    assert_int_equal(wire_outputs(&w, 0, 0), 1);
    w.now_ns += ECT_INDICATOR_TRAFFIC_NS / 2;
    uint64_t late_ns = w.now_ns + 1000 * MS;
    for (uint64_t at = w.now_ns; at < late_ns && ect_chain_slave(w.chain, 0)->state == ECT_STATE_OP; at = next_ns) {
        w.now_ns = at;
        next_ns = ect_chain_poll(w.chain, at);
        assert_true(next_ns > at);
    }
    assert_int_equal(ect_chain_slave(w.chain, 0)->state, ECT_STATE_SAFEOP);
    assert_int_equal(ect_chain_slave(w.chain, 0)->code, 0x001B);
    wire_close(&w);
}

/* Nothing else requests a time, and no frame arrives: without a deadline of their own the lamps would flicker for ever.
 */
static void lamps_deadline(void **state)
{
    char text[ECT_SIGNAL_TEXT_ROOM];
    ect_signal_ref_t lamp;
    uint8_t data = 0;
    wire_t w;
    (void)state;
    wire_open_one(&w, &testdev);
    assert_int_equal(wire_send(&w, BRD, 0, 0, &data, 1), 1);
    uint64_t quiet = w.now_ns + ECT_INDICATOR_TRAFFIC_NS;
    assert_true(ect_chain_signal(w.chain, 0, "ecat.link_in", &lamp));
    assert_true(ect_chain_poll(w.chain, w.now_ns) == quiet);
    ect_signal_read(&lamp, text);
    assert_string_equal(text, "flickering");
    assert_true(ect_chain_poll(w.chain, quiet - 1) == quiet);
    ect_chain_show_lamps(w.chain, 0);
    ect_signal_read(&lamp, text);
    assert_string_equal(text, "flickering");
    assert_true(ect_chain_poll(w.chain, quiet) == ECT_NEVER);
    ect_chain_show_lamps(w.chain, 0);
    ect_signal_read(&lamp, text);
    assert_string_equal(text, "on");
    wire_close(&w);
}

/* The slave in SAFEOP with SYNC0 as an event; then 0x0981 alone is written, as some masters do, and a cycle of 1 ns. */
static void dense_sync0(void **state)
{
    const ect_product_t *product = ect_catalogue_find("fzm1");
    ect_device_t device = *product->device;
    ect_twin_config_t twin = ect_twin_default(&device, product->plant);
    uint8_t bytes[8];
    wire_t w;
    (void)state;
    device.esc_config[3] = 0x08; /* SYNC0 is an AL event */
    wire_open_twins(&w, &twin, 1);
    wire_go(&w, 0, ECT_STATE_SAFEOP);
    w.manual_poll = true;
    for (unsigned int cycle = 1; cycle <= 1000000; cycle *= 1000) {
        assert_int_equal(wire_write8(&w, 0, ECT_REG_DC_ACTIVATION, 0), 1);
        (void)ect_chain_poll(w.chain, w.now_ns);
        assert_int_equal(wire_read(&w, 0, ECT_REG_DC_SYSTEM_TIME, bytes, 8), 1);
        ect_store_le64(bytes, ect_load_le64(bytes) + 50000);
        assert_int_equal(wire_write(&w, 0, ECT_REG_DC_START_TIME, bytes, 8), 1);
        ect_store_le32(bytes, cycle);
        assert_int_equal(wire_write(&w, 0, ECT_REG_DC_SYNC0_CYCLE, bytes, 4), 1);
        (void)ect_chain_poll(w.chain, w.now_ns);
        assert_int_equal(wire_write8(&w, 0, ECT_REG_DC_ACTIVATION, 3), 1);
        uint64_t first = w.now_ns + 50000;
        assert_true(ect_chain_poll(w.chain, w.now_ns) <= first); /* woken in time for the first pulse */
        unsigned int polls = 0;
        for (uint64_t at = first; at < first + 10 * MS; polls++) {
            w.now_ns = at;
            uint64_t next = ect_chain_poll(w.chain, at);
            assert_true(next > at);
            at = next;
        }
        assert_true(polls <= 10 * MS / 25000 + 10);
        assert_true(polls >= 10);
    }
    wire_close(&w);
}

static void catalogue_names(void **state)
{
    const ect_product_t *product;
    size_t i;
    (void)state;
    for (i = 0; (product = ect_catalogue_at(i)) != NULL; i++) {
        const ect_device_t *device = product->device;
        assert_ptr_equal(ect_catalogue_find(device->name), product);
        assert_int_equal(strspn(device->name, "abcdefghijklmnopqrstuvwxyz0123456789-"), strlen(device->name));
        assert_true(strlen(device->type_name) <= 40);
        for (size_t k = 0; k < i; k++) {
            assert_int_not_equal(device->identity.product_code, ect_catalogue_at(k)->device->identity.product_code);
            assert_string_not_equal(device->type_name, ect_catalogue_at(k)->device->type_name);
        }
    }
    assert_true(i >= 4);
    assert_null(ect_catalogue_find("no-such-device"));
    assert_null(ect_catalogue_find(""));
}

static void cycle_the_power(wire_t *w)
{
    ect_chain_power_cycle(w->chain, w->now_ns);
}

static void want_a_restart(wire_t *w)
{
    testdev_of(w, 0)->host->restart(testdev_of(w, 0)->host->ctx);
    ect_chain_wake(w->chain, 0);
    (void)ect_chain_poll(w->chain, w->now_ns);
}

static void do_fault(wire_t *w, ect_fault_kind_t kind)
{
    const ect_fault_t fault = {.kind = kind, .slave = 1};
    ect_chain_fault(w->chain, &fault, w->now_ns);
}

static void be_reset(wire_t *w)
{
    do_fault(w, ECT_FAULT_RESET);
}

static void change_identity(wire_t *w)
{
    do_fault(w, ECT_FAULT_IDENTITY);
}

static uint64_t version_of(const wire_t *w)
{
    ect_chain_steady_t steady;
    assert_true(ect_chain_steady(w->chain, &steady));
    return steady.version;
}

/* Each way in which the first twin is powered on again. */
static const struct {
    const char *what;
    void (*happens)(wire_t *w);
} power_ons[] = {{"power cycle", cycle_the_power},
                 {"restart of the device", want_a_restart},
                 {"fault reset", be_reset},
                 {"fault identity", change_identity}};
enum { POWER_ONS = sizeof power_ons / sizeof power_ons[0] };

/* ect_host_t::buffer: the data of a device in it are cleared with all else. */
static void buffer_at_power_on(void **state)
{
    static const uint8_t zeros[64];
    ect_device_t device = testdev;
    (void)state;
    device.buffer_size = sizeof zeros;
    for (size_t i = 0; i < POWER_ONS; i++) {
        wire_t w;
        wire_open_one(&w, &device);
        memset(testdev_of(&w, 0)->host->buffer, 0x5A, sizeof zeros);
        power_ons[i].happens(&w);
        testdev_t *dev = testdev_of(&w, 0);
        if (dev->inits != 1 || memcmp(dev->host->buffer, zeros, sizeof zeros) != 0)
            fail_msg("%s: expected one start and a buffer of zeros, got %u and %02X...", power_ons[i].what, dev->inits,
                     *(const uint8_t *)dev->host->buffer);
        wire_close(&w);
    }
}

static void expect_replies(wire_t *w, const char *what, int want)
{
    uint8_t data = 0;
    wire_poll(w);
    int got = wire_send(w, BRD, 0, 0, &data, 1);
    if (got != want)
        fail_msg("%s: expected %d twins to reply, got %d", what, want, got);
}

static void on_the_bus_at_power_on(void **state)
{
    const ect_device_t *const devices[] = {&testdev, &testdev};
    (void)state;
    for (size_t i = 0; i < POWER_ONS; i++) {
        wire_t w;
        wire_open(&w, devices, 2);
        expect_replies(&w, "at first", 2);
        testdev_of(&w, 0)->host->off_bus(testdev_of(&w, 0)->host->ctx, true);
        ect_chain_wake(w.chain, 0);
        expect_replies(&w, "off the bus", NO_REPLY);
        power_ons[i].happens(&w);
        expect_replies(&w, power_ons[i].what, 2);
        wire_close(&w);
    }
}

/* The replies in advance of a twin before the power-on are not those of the twin after. The station address, whose
 * change alone changes the version, is 0 in both. */
static void version_at_power_on(void **state)
{
    const ect_twin_config_t twin = ect_twin_default(&testdev, NULL);
    (void)state;
    for (size_t i = 0; i < POWER_ONS; i++) {
        wire_t w = {.now_ns = 1000 * MS};
        w.chain = ect_chain_new(&twin, 1, w.now_ns);
        assert_non_null(w.chain);
        expect_replies(&w, "at first", 1);
        uint64_t before = version_of(&w);
        assert_int_equal(version_of(&w), before);
        power_ons[i].happens(&w);
        expect_replies(&w, power_ons[i].what, 1);
        if (version_of(&w) == before)
            fail_msg("%s: expected another version than %llu", power_ons[i].what, (unsigned long long)before);
        wire_close(&w);
    }
}

/* The last two take back what the others do to a frame. */
static void version_after_faults(void **state)
{
    static const char *const faults[] = {"abort 0x2000 0x08000020 slave 1",
                                         "to PREOP slave 1",
                                         "init slave 1",
                                         "emergency 0xFF00 slave 1",
                                         "lose-event slave 1",
                                         "pdi-error slave 1",
                                         "clock 5ns slave 1",
                                         "eeprom busy slave 1",
                                         "hang slave 1",
                                         "eeprom ok slave 1",
                                         "resume slave 1"};
    wire_t w;
    (void)state;
    wire_open_one(&w, &testdev);
    expect_replies(&w, "at first", 1);
    uint64_t before = version_of(&w);
    for (size_t i = 0; i < sizeof faults / sizeof faults[0]; i++) {
        char message[ECT_FAULT_MESSAGE];
        ect_fault_t fault;
        ect_chain_steady_t steady;
        assert_true(ect_fault_parse(faults[i], &fault, message));
        (void)ect_chain_fault(w.chain, &fault, w.now_ns);
        expect_replies(&w, faults[i], 1);
        if (ect_chain_steady(w.chain, &steady) && steady.version != before)
            fail_msg("%s: expected version %llu, got %llu", faults[i], (unsigned long long)before,
                     (unsigned long long)steady.version);
    }
    assert_int_equal(version_of(&w), before);
    wire_close(&w);
}

static void plugs_at_first(void **state)
{
    static const char *const names[] = {"ecat.plug_in", "ecat.plug_out", "ecat.plug_2", "ecat.plug_3"};
    wire_t w;
    (void)state;
    wire_open_one(&w, &testdev);
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        char text[ECT_SIGNAL_TEXT_ROOM];
        ect_signal_ref_t ref;
        assert_true(ect_chain_signal(w.chain, 0, names[i], &ref));
        ect_signal_read(&ref, text);
        assert_string_equal(text, "1");
    }
    wire_close(&w);
}

/* A program's own devices come after those of this tree. */
static void catalogue_grows(void **state)
{
    static const ect_product_t mine[] = {{&testdev, NULL}};
    size_t ours = 0;
    (void)state;
    while (ect_catalogue_at(ours))
        ours++;
    ect_catalogue_add(mine, 1);
    assert_ptr_equal(ect_catalogue_at(ours), &mine[0]);
    assert_null(ect_catalogue_at(ours + 1));
    assert_ptr_equal(ect_catalogue_find(testdev.name), &mine[0]);
    ect_catalogue_add(NULL, 0);
    assert_null(ect_catalogue_at(ours));
    assert_null(ect_catalogue_find(testdev.name));
}

/* --- work that must not be cut off -------------------------------------------------------------------------------- */

static bool busy(const void *instance)
{
    return ((const testdev_t *)instance)->u32 == 1;
}

static void unfinished_work(void **state)
{
    enum { TWINS = 4, NONE = 9 };
    static const ect_plant_t saves = {.unfinished = busy}, other = {0};
    static const struct {
        size_t busy;
        bool want;
    } rows[] = {{NONE, false}, {0, true}, {1, false}, {2, false}, {3, true}};
    const ect_twin_config_t twins[TWINS] = {ect_twin_default(&testdev, &saves), ect_twin_default(&testdev, &other),
                                            ect_twin_default(&testdev, NULL), ect_twin_default(&testdev, &saves)};
    wire_t w;
    (void)state;
    wire_open_twins(&w, twins, TWINS);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        for (size_t n = 0; n < TWINS; n++)
            testdev_of(&w, n)->u32 = n == rows[i].busy ? 1 : 2;
        assert_true(ect_chain_unfinished(w.chain) == rows[i].want);
    }
    wire_close(&w);
}

/* The blocks that ect_chain_memory has named. */
typedef struct blocks {
    size_t count;
    struct {
        const uint8_t *at;
        size_t size;
    } all[8];
} blocks_t;

static void take_block(void *ctx, void *at, size_t size)
{
    blocks_t *blocks = ctx;
    assert_in_range(blocks->count, 0, sizeof blocks->all / sizeof blocks->all[0] - 1);
    blocks->all[blocks->count].at = at;
    blocks->all[blocks->count++].size = size;
}

static void large_blocks(void **state)
{
    enum { TWINS = 50, LINE = 64 };
    ect_twin_config_t twins[TWINS];
    wire_t w;
    blocks_t blocks = {0};
    size_t of_twins = 0;
    (void)state;
    for (size_t n = 0; n < TWINS; n++)
        twins[n] = ect_twin_default(&testdev, NULL);
    wire_open_twins(&w, twins, TWINS);
    ect_chain_memory(w.chain, take_block, &blocks);
    assert_int_equal(blocks.count, 2);
    for (size_t b = 0; b < blocks.count; b++) {
        uint8_t sum = 0;
        for (size_t i = 0; i < blocks.all[b].size; i++)
            sum ^= blocks.all[b].at[i]; /* AddressSanitizer ends the test outside a block */
        (void)sum;
        for (size_t n = 0; n < TWINS; n++)
            of_twins += (const uint8_t *)ect_chain_esc(w.chain, n) >= blocks.all[b].at &&
                        (const uint8_t *)(ect_chain_esc(w.chain, n) + 1) <= blocks.all[b].at + blocks.all[b].size;
        if (b == 1)
            assert_true(ect_chain_esc(w.chain, 0)->config.memory == blocks.all[b].at);
    }
    assert_int_equal(of_twins, TWINS);
    const uint8_t *memory = ect_chain_esc(w.chain, 0)->config.memory;
    ptrdiff_t apart = ect_chain_esc(w.chain, 1)->config.memory - memory;
    assert_int_equal(apart % (2 * LINE), LINE); /* no register of all twins in a few sets of a cache */
    wire_close(&w);
}

/* Huge pages for these blocks would use all of a buffer, of which a device may never write most. */
static void buffers_are_in_no_large_block(void **state)
{
    enum { TWINS = 3 };
    const ect_device_t *device = &ect_eclink_map7;
    ect_twin_config_t twins[TWINS];
    wire_t w;
    blocks_t blocks = {0};
    (void)state;
    assert_true(device->buffer_size > 0);
    for (size_t n = 0; n < TWINS; n++)
        twins[n] = ect_twin_default(device, &ect_eclink_plant);
    wire_open_twins(&w, twins, TWINS);
    ect_chain_memory(w.chain, take_block, &blocks);
    for (size_t n = 0; n < TWINS; n++) {
        const uint8_t *buffer = ect_chain_slave(w.chain, n)->config.buffer;
        assert_non_null(buffer);
        for (size_t b = 0; b < blocks.count; b++)
            assert_true(buffer + device->buffer_size <= blocks.all[b].at ||
                        buffer >= blocks.all[b].at + blocks.all[b].size);
    }
    wire_close(&w);
}

/* --- services of a twin ------------------------------------------------------------------------------------------- */

static ect_bulk_t bulk_of(const void *instance)
{
    return (ect_bulk_t){.data = ((const testdev_t *)instance)->octets, .size = 3};
}

static void hang(wire_t *w)
{
    do_fault(w, ECT_FAULT_HANG);
}

static void leave_the_bus(wire_t *w)
{
    testdev_of(w, 0)->host->off_bus(testdev_of(w, 0)->host->ctx, true);
}

static void do_nothing(wire_t *w)
{
    (void)w;
}

static void services(void **state)
{
    static const ect_modbus_t modbus = {0};
    static const ect_plant_t plant = {.modbus = &modbus, .bulk = bulk_of}, other = {0};
    static const ect_protocol_t *const emergency_alone[] = {&ect_protocol_emergency, NULL};
    ect_device_t without_sdo = testdev, without_protocols = testdev;
    const struct {
        const char *title;
        const ect_device_t *device;
        const ect_plant_t *plant;
        void (*happens)(wire_t *w);
        bool modbus, bulk;
        const char *why; /* SDO is refused; NULL: it is not */
    } rows[] = {
        {"a twin at work", &testdev, &plant, do_nothing, true, true, NULL},
        {"a plant without them", &testdev, &other, do_nothing, false, false, NULL},
        {"no plant", &testdev, NULL, do_nothing, false, false, NULL},
        {"a twin that hangs", &testdev, &plant, hang, false, true, "its microcontroller hangs: 'resume' continues it"},
        {"a twin off the bus", &testdev, &plant, leave_the_bus, false, true, "it is switched off"},
        {"a device with other protocols", &without_sdo, &plant, do_nothing, true, true,
         "its device has no object dictionary"},
        {"a device without protocols", &without_protocols, &plant, hang, false, true,
         "its device has no object dictionary"},
    };
    (void)state;
    without_sdo.protocols = emergency_alone;
    without_protocols.protocols = NULL;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const ect_twin_config_t twins[] = {ect_twin_default(rows[i].device, rows[i].plant),
                                           ect_twin_default(&testdev, NULL)};
        const char *why = "nothing";
        void *instance = NULL;
        wire_t w;
        wire_open_twins(&w, twins, 2);
        rows[i].happens(&w);
        const ect_modbus_t *got = ect_chain_modbus(w.chain, 0, &instance);
        const ect_bulk_t bulk = ect_chain_bulk(w.chain, 0);
        const ect_slave_t *slave = ect_chain_sdo(w.chain, 0, &why);
        if ((got == &modbus) != rows[i].modbus || (bulk.size == 3) != rows[i].bulk || (slave == NULL) != (why != NULL))
            fail_msg("%s: Modbus %d, bulk %u, SDO %d", rows[i].title, got != NULL, (unsigned int)bulk.size,
                     slave != NULL);
        assert_ptr_equal(instance, testdev_of(&w, 0));
        assert_ptr_equal(bulk.data, rows[i].bulk ? testdev_of(&w, 0)->octets : NULL);
        assert_ptr_equal(slave, rows[i].why ? NULL : ect_chain_slave(w.chain, 0));
        assert_string_equal(why ? why : "", rows[i].why ? rows[i].why : "");
        assert_ptr_equal(ect_chain_sdo(w.chain, 1, &why), ect_chain_slave(w.chain, 1)); /* the other twin works */
        wire_close(&w);
    }
}

/* The twins that have run at a poll, in their order. */
typedef struct runs {
    char positions[8];
    size_t count;
    uint64_t now_ns;
} runs_t;

static void note_run(void *ctx, size_t position, uint64_t now_ns)
{
    runs_t *runs = ctx;
    assert_true(runs->count + 1 < sizeof runs->positions);
    runs->positions[runs->count++] = (char)('0' + position);
    runs->now_ns = now_ns;
}

static void observed(void **state)
{
    const ect_device_t *const devices[] = {&testdev, &testdev, &testdev};
    runs_t runs = {0};
    wire_t w;
    (void)state;
    wire_open(&w, devices, 3);
    w.now_ns += 1000 * MS;
    wire_poll(&w);
    ect_chain_observe(w.chain, ECT_CHAIN_CLIENTS, note_run, &runs);
    (void)ect_chain_poll(w.chain, w.now_ns);
    assert_string_equal(runs.positions, "");
    ect_chain_wake(w.chain, 2);
    ect_chain_wake(w.chain, 0);
    w.now_ns += MS;
    (void)ect_chain_poll(w.chain, w.now_ns);
    assert_string_equal(runs.positions, "02");
    assert_true(runs.now_ns == w.now_ns);
    ect_chain_observe(w.chain, ECT_CHAIN_CLIENTS, NULL, NULL);
    ect_chain_wake(w.chain, 1);
    (void)ect_chain_poll(w.chain, w.now_ns);
    assert_string_equal(runs.positions, "02");
    wire_close(&w);
}

/* --- the EEPROM --------------------------------------------------------------------------------------------------- */

typedef struct written {
    unsigned int calls;
    uint32_t size;
    uint8_t sii[4096];
} written_t;

static void note_written(void *ctx, const uint8_t *sii, uint32_t size)
{
    written_t *written = ctx;
    assert_in_range(size, 1, sizeof written->sii);
    written->calls++;
    written->size = size;
    memcpy(written->sii, sii, size);
}

static void eeprom_written(void **state)
{
    enum { WORD = 0x0030 };
    static const uint8_t write[] = {0x01, 0x02, WORD, 0, 0, 0, 0xA5, 0x5A};
    ect_twin_config_t twin = ect_twin_default(&testdev, NULL);
    written_t written = {0};
    wire_t w;
    (void)state;
    twin.sii_written = note_written;
    twin.sii_ctx = &written;
    wire_open_twins(&w, &twin, 1);
    wire_advance(&w, 10 * MS);
    assert_int_equal(written.calls, 0);
    for (unsigned int n = 1; n <= 2; n++) {
        assert_int_equal(wire_write(&w, 0, 0x0508, write + 6, 2), 1);
        assert_int_equal(wire_write(&w, 0, 0x0502, write, 6), 1);
        wire_advance(&w, 10 * MS);
        assert_int_equal(written.calls, n); /* once for each write */
    }
    assert_int_equal(written.size, testdev.sii_size);
    assert_int_equal(ect_load_le16(written.sii + 2 * WORD), 0x5AA5);
    wire_close(&w);
}

static void eeprom_as_given(void **state)
{
    static const uint8_t read[] = {0x00, 0x01, 0x40, 0, 0, 0};
    static uint8_t sii[4096];
    ect_twin_config_t twin = ect_twin_default(&testdev, NULL);
    (void)state;
    assert_in_range(testdev.sii_size, 0x84, sizeof sii);
    for (unsigned int given = 0; given < 2; given++) {
        uint8_t data[4];
        wire_t w;
        twin.sii = given != 0 ? sii : NULL;
        wire_open_twins(&w, &twin, 1);
        if (given == 0)
            memcpy(sii, ect_chain_esc(w.chain, 0)->config.sii, testdev.sii_size);
        memcpy(sii + 0x80, "\x12\x34\x56\x78", 4);
        assert_int_equal(wire_write(&w, 0, 0x0502, read, sizeof read), 1);
        wire_advance(&w, 10 * MS);
        assert_int_equal(wire_read(&w, 0, 0x0508, data, sizeof data), 1);
        assert_int_equal(ect_load_le32(data) == 0x78563412, given != 0);
        wire_close(&w);
    }
}

/* --- frames that have left in advance ----------------------------------------------------------------------------- */

/* While the chain catches up, outputs reach the device; its inputs are those of the frames that have left. */
static void catches_up(void **state)
{
    enum { INPUTS = 0x1300 };
    const ect_device_t *const devices[] = {&testdev, &testdev};
    wire_t w;
    (void)state;
    wire_open(&w, devices, 2);
    for (size_t i = 0; i < 2; i++)
        wire_go(&w, i, ECT_STATE_OP);
    w.manual_poll = true;
    for (uint8_t n = 1; n <= 3; n++) {
        uint8_t inputs[3];
        for (size_t i = 0; i < 2; i++)
            testdev_of(&w, i)->in_u16 = (uint16_t)(0x1100 * n + i);
        w.now_ns += MS;
        assert_int_equal(wire_outputs(&w, 1, n), 1);
        assert_true(ect_chain_catch_up(w.chain, w.now_ns) > w.now_ns);
        assert_int_equal(testdev_of(&w, 1)->out_u16, 0x0101 * n);
        assert_int_equal(wire_read(&w, 1, INPUTS, inputs, sizeof inputs), 1);
        assert_int_equal(ect_load_le16(inputs), n > 1 ? 0x1100 * (n - 1) + 1 : 0);
        (void)ect_chain_poll(w.chain, w.now_ns);
        assert_int_equal(wire_read(&w, 1, INPUTS, inputs, sizeof inputs), 1);
        assert_int_equal(ect_load_le16(inputs), 0x1100 * n + 1);
    }
    wire_close(&w);
}

static bool let_pass(void *ctx, ect_crossing_t *crossing)
{
    (void)ctx;
    (void)crossing;
    return true;
}

/* Each frame is recorded, whether it takes the fast path or, with a guard, the path of the reference. */
static void lamps_after_any_frame(void **state)
{
    static const bool guarded[] = {false, true, true, false, false, true};
    const ect_device_t *const devices[] = {&testdev, &testdev};
    uint8_t data = 0;
    wire_t w;
    (void)state;
    wire_open(&w, devices, 2);
    w.manual_poll = true;
    for (size_t i = 0; i < sizeof guarded / sizeof guarded[0]; i++) {
        w.now_ns += ECT_INDICATOR_TRAFFIC_NS - 1;
        if (guarded[i])
            ect_chain_guard(w.chain, let_pass, NULL);
        assert_int_equal(wire_send(&w, BRD, 0, 0, &data, 1), 2);
        const uint64_t quiet_ns = w.now_ns + ECT_INDICATOR_TRAFFIC_NS;
        for (unsigned int n = 0; n < 2; n++) {
            const uint64_t next_ns = ect_chain_poll(w.chain, quiet_ns - 1 + n);
            assert_true(n == 0 ? next_ns == quiet_ns : next_ns == ECT_NEVER);
            for (size_t position = 0; position < 2; position++) {
                char text[ECT_SIGNAL_TEXT_ROOM];
                ect_signal_ref_t lamp;
                assert_true(ect_chain_signal(w.chain, position, "ecat.link_in", &lamp));
                ect_signal_read(&lamp, text);
                assert_string_equal(text, n == 0 ? "flickering" : "on");
            }
        }
        w.now_ns = quiet_ns;
    }
    wire_close(&w);
}

/* A twin that is powered on has no station address, also for a frame before the next poll. */
static void reset_between_polls(void **state)
{
    const ect_device_t *const devices[] = {&testdev, &testdev};
    uint8_t data = 0;
    wire_t w;
    (void)state;
    wire_open(&w, devices, 2);
    w.manual_poll = true;
    for (size_t i = 0; i < POWER_ONS; i++) {
        assert_int_equal(wire_read(&w, 0, 0, &data, 1), 1);
        power_ons[i].happens(&w);
        if (wire_read(&w, 0, 0, &data, 1) != 0)
            fail_msg("%s: the station address is still there", power_ons[i].what);
        assert_int_equal(wire_send(&w, BRD, 0, 0, &data, 1), 2);
        wire_assign_stations(&w);
    }
    wire_close(&w);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"CF-001: a chain with an unknown ESC or an EEPROM too small is refused", unusable_descriptions, NULL, NULL,
         NULL},
        {"ENI-021: a twin is found by its station alias or device id, the first one of several", found_by_alias, NULL,
         NULL, NULL},
        {"CF-057 CF-065: an installation's identity and alias reach 1018h and register 0012h", overridden_identity,
         NULL, NULL, NULL},
        {"CF-002 CF-010: 40 twins reply in the order of the wire", order_of_the_wire, NULL, NULL, NULL},
        {"CF-095: the source address has its bit set, or is unchanged if so configured", source_address, NULL, NULL,
         NULL},
        {"CF-013: a frame that is not EtherCAT does not return", not_ethercat, NULL, NULL, NULL},
        {"CF-083: the poll returns the earliest deadline of all twins", deadlines, NULL, NULL, NULL},
        {"CF-089: a SYNC0 of 1 ns wakes no more often than every 25 us; 0x0981 alone wakes in time", dense_sync0, NULL,
         NULL, NULL},
        {"a slave that is off the bus from its power-on ends the line before it, until it is on the bus",
         off_from_the_start, NULL, NULL, NULL},
        {"a slave that leaves the bus, or returns, at a time of its own changes the links at this time", off_by_itself,
         NULL, NULL, NULL},
        {"CF-042: the poll at which the watchdog expires already runs the slave", watchdog_at_its_deadline, NULL, NULL,
         NULL},
        {"the poll returns the time at which the link lamps stop flickering", lamps_deadline, NULL, NULL, NULL},
        {"a device's buffer is zero each time it is powered on", buffer_at_power_on, NULL, NULL, NULL},
        {"a twin that is off the bus is on the bus again when it is powered on", on_the_bus_at_power_on, NULL, NULL,
         NULL},
        {"replies in advance become invalid when a twin is powered on", version_at_power_on, NULL, NULL, NULL},
        {"replies in advance remain valid after a fault that restarts no twin", version_after_faults, NULL, NULL, NULL},
        {"all plugs of a twin are plugged in at first", plugs_at_first, NULL, NULL, NULL},
        {"a chain is unfinished while the plant of one of its twins reports work", unfinished_work, NULL, NULL, NULL},
        {"Modbus, mass data and SDO of a twin, and the reasons for their refusal", services, NULL, NULL, NULL},
        {"a poll reports each twin that has run", observed, NULL, NULL, NULL},
        {"a write of the master to the EEPROM is reported once, with the whole content", eeprom_written, NULL, NULL,
         NULL},
        {"a twin may have a given content of the EEPROM", eeprom_as_given, NULL, NULL, NULL},
        {"inputs remain until the chain has caught up with past frames", catches_up, NULL, NULL, NULL},
        {"link lamps flicker after each frame, until the time that the poll returns", lamps_after_any_frame, NULL, NULL,
         NULL},
        {"CF-001: a twin that is powered on has no station address for the next frame", reset_between_polls, NULL, NULL,
         NULL},
        {"the large blocks of a chain contain each ESC and its RAM", large_blocks, NULL, NULL, NULL},
        {"the large blocks of a chain contain no buffer of a device", buffers_are_in_no_large_block, NULL, NULL, NULL},
        {"CF-057: every device has a name and a product code of its own", catalogue_names, NULL, NULL, NULL},
        {"a program's own devices follow those of this tree in the catalogue", catalogue_grows, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Chain", tests, NULL, NULL);
}
