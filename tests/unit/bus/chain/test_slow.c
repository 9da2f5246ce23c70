/* SPDX-License-Identifier: MIT */
/* Twins whose microcontroller takes time (bus/chain/slow.h): late states, late mails, old inputs, the times of a board.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bus/chain/settings.h"
#include "bus/chain/slow.h"
#include "devices/eclink/eclink.h"
#include "devices/fzm1/fzm1.h"
#include "devices/pmctendo/pmctendo.h"
#include "sii/fit.h"
#include "support/chip.h"
#include "support/testdev.h"
#include "support/wire.h"

#define US 1000ull

static void open_slow(wire_t *w, const ect_device_t *device, const ect_slow_config_t *slow)
{
    ect_twin_config_t twin = ect_twin_default(device, NULL);
    twin.slow = *slow;
    wire_open_twins(w, &twin, 1);
}

/* Time until a register has a value, in steps; fails after 1 s. */
static uint64_t wait_for(wire_t *w, uint16_t address, uint8_t mask, uint8_t value, uint64_t step_ns)
{
    uint64_t begin_ns = w->now_ns;
    while ((wire_read8(w, 0, address) & mask) != value) {
        if (w->now_ns - begin_ns > 1000 * MS)
            fail_msg("0x%04X never shows 0x%02X", address, value);
        wire_advance(w, step_ns);
    }
    return w->now_ns - begin_ns;
}

static uint64_t until_state(wire_t *w, uint8_t state)
{
    return wait_for(w, ECT_REG_AL_STATUS, 0xFF, state, 100 * US);
}

/* Requests a state. @return ns until AL status shows it */
static uint64_t change(wire_t *w, uint8_t state)
{
    assert_int_equal(wire_write16(w, 0, ECT_REG_AL_CONTROL, state), 1);
    return until_state(w, state);
}

static void expect_between(const char *what, uint64_t got_ns, uint64_t minimum_ns, uint64_t maximum_ns)
{
    if (got_ns < minimum_ns || got_ns > maximum_ns)
        fail_msg("%s: expected %llu to %llu us, got %llu us", what, (unsigned long long)(minimum_ns / US),
                 (unsigned long long)(maximum_ns / US), (unsigned long long)(got_ns / US));
}

static void late_states(void **state)
{
    const ect_slow_config_t slow = {.al = {5 * MS, 100 * MS}, .seed = 3};
    uint64_t least = UINT64_MAX, most = 0;
    wire_t w;
    (void)state;
    open_slow(&w, &testdev, &slow);
    wire_configure_mailbox(&w, 0);
    for (unsigned int n = 0; n < 40; n++) {
        uint64_t took = change(&w, n % 2 == 0 ? ECT_STATE_PREOP : ECT_STATE_INIT);
        expect_between("a change of state", took, 5 * MS, 100 * MS + 100 * US);
        least = took < least ? took : least;
        most = took > most ? took : most;
    }
    assert_true(least < 20 * MS && most > 80 * MS);
    wire_close(&w);
}

/* AL control is not locked during the delay of the slave: the last request applies. */
static void changed_request(void **state)
{
    const ect_slow_config_t slow = {.al = {20 * MS, 20 * MS}};
    wire_t w;
    (void)state;
    open_slow(&w, &testdev, &slow);
    wire_configure_mailbox(&w, 0);
    assert_int_equal(wire_write16(&w, 0, ECT_REG_AL_CONTROL, ECT_STATE_OP), 1);
    wire_advance(&w, 10 * MS);
    assert_int_equal(wire_write16(&w, 0, ECT_REG_AL_CONTROL, ECT_STATE_PREOP), 1);
    expect_between("the second request", until_state(&w, ECT_STATE_PREOP), 20 * MS, 20 * MS + 100 * US);
    assert_int_equal(wire_read16(&w, 0, ECT_REG_AL_STATUS_CODE), 0);
    wire_close(&w);
}

static uint64_t upload(wire_t *w)
{
    static const uint8_t request[10] = {0, 0x20, 0x40, 0x18, 0x10, 1};
    uint8_t mail[128];
    assert_int_equal(wire_mail_request(w, 0, ECT_MAILBOX_TYPE_COE, request, sizeof request), 1);
    uint64_t took = wait_for(w, 0x080D, 0x08, 0x08, 100 * US);
    assert_int_equal(wire_mail_receive(w, 0, mail, sizeof mail), 10);
    return took;
}

static void late_mails(void **state)
{
    const ect_slow_config_t slow = {.mailbox = {5 * MS, 50 * MS}, .seed = 3};
    uint64_t least = UINT64_MAX, most = 0;
    wire_t w;
    (void)state;
    open_slow(&w, &testdev, &slow);
    wire_go(&w, 0, ECT_STATE_PREOP);
    for (unsigned int n = 0; n < 40; n++) {
        uint64_t took = upload(&w);
        expect_between("a reply", took, 5 * MS, 50 * MS + 100 * US);
        least = took < least ? took : least;
        most = took > most ? took : most;
    }
    assert_true(least < 15 * MS && most > 40 * MS);
    wire_close(&w);
}

/* The slave reads no mail while the master fetches no reply: after the delay no poll is needed. */
static void mail_left(void **state)
{
    static const uint8_t request[10] = {0, 0x20, 0x40, 0x18, 0x10, 1};
    const ect_slow_config_t slow = {.mailbox = {5 * MS, 5 * MS}};
    wire_t w;
    (void)state;
    open_slow(&w, &testdev, &slow);
    wire_go(&w, 0, ECT_STATE_PREOP);
    for (unsigned int mails = 0; wire_mail_request(&w, 0, ECT_MAILBOX_TYPE_COE, request, sizeof request) == 1;
         mails++) {
        assert_true(mails < 4);
        w.now_ns += 10 * MS;
        assert_true(ect_chain_poll(w.chain, w.now_ns) > w.now_ns);
    }
    wire_close(&w);
}

static void go_to_op(wire_t *w)
{
    wire_configure_mailbox(w, 0);
    (void)change(w, ECT_STATE_PREOP);
    wire_configure_process_data(w, 0);
    (void)change(w, ECT_STATE_SAFEOP);
    assert_int_equal(wire_outputs(w, 0, 0), 1);
    (void)change(w, ECT_STATE_OP);
}

/* Cycles of 1 ms. A slave that is later than a cycle has, in every second one, the outputs of the cycle before. */
static void old_inputs(void **state)
{
    static const struct {
        ect_slow_range_t jitter;
        unsigned int late_least, late_most; /* of 20 cycles */
    } rows[] = {{{0, 0}, 0, 0}, {{200 * US, 700 * US}, 0, 0}, {{1200 * US, 1200 * US}, 9, 11}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const ect_slow_config_t slow = {.jitter = rows[i].jitter, .seed = 5};
        unsigned int late = 0;
        wire_t w;
        open_slow(&w, &testdev, &slow);
        go_to_op(&w);
        wire_advance(&w, 5 * MS);
        for (unsigned int cycle = 1; cycle <= 20; cycle++) {
            assert_int_equal(wire_outputs(&w, 0, (uint8_t)cycle), 1);
            wire_advance(&w, 1 * MS);
            unsigned int seen = testdev_of(&w, 0)->out_u16 & 0xFF;
            assert_true(seen + 1 >= cycle);
            late += seen != cycle;
        }
        if (late < rows[i].late_least || late > rows[i].late_most)
            fail_msg("row %zu: %u cycles with old outputs", i, late);
        wire_close(&w);
    }
}

/* "12.3" from nanoseconds. */
static const char *in_us(uint64_t ns, char text[16])
{
    unsigned int tenths = (unsigned int)((ns + 50) / 100);
    (void)snprintf(text, 16, "%u.%u", tenths / 10, tenths % 10);
    return text;
}

static void expect_row(const char *board, const char *device, uint64_t bus_ns, uint64_t computing_ns)
{
    static char page[64 * 1024];
    char row[160], texts[3][16];
    FILE *file = fopen(PAGE, "r");
    assert_non_null(file);
    page[fread(page, 1, sizeof page - 1, file)] = 0;
    (void)fclose(file);
    (void)snprintf(row, sizeof row, "| `%s` | %s | %s | %s | %s |\n", board, device, in_us(bus_ns, texts[0]),
                   in_us(computing_ns, texts[1]), in_us(bus_ns + computing_ns, texts[2]));
    if (!strstr(page, row))
        fail_msg("docs/CHIPS.md lacks this row: %s", row);
}

/* The time between the frame with the outputs and the new inputs: bus, processor, and at most an idle poll before. */
static void expect_exchange(wire_t *w, const ect_device_t *device, uint64_t want_ns, uint64_t idle_ns)
{
    uint8_t image[512] = {0};
    for (unsigned int n = 0; n < 20; n++) {
        uint64_t took = 0;
        wire_advance(w, 2 * MS + n * 777);
        assert_int_equal(wire_outputs(w, 0, 0), 1);
        (void)wire_read(w, 0, device->sm[3].start, image, ect_device_sm_bytes(device, 3));
        for (; (ect_chain_esc(w->chain, 0)->memory[0x081D] & 1) == 0 && took < MS; took += 100)
            wire_advance(w, 100);
        expect_between(device->name, took, want_ns, want_ns + idle_ns + 100);
    }
}

/* The bytes of docs/LAN9252.md at 20 MHz and 1 us for each transfer, or 300 ns for each access of the bus; the
 * instructions that tests/check/cycles.sh compares with a Cortex-M4, at 1.5 cycles of 168 MHz. */
static void exchange_on_board(void **state)
{
    static const struct {
        const char *board;
        const ect_device_t *device;
        uint64_t bus_ns, instructions;
        uint64_t idle_bus_ns, idle_instructions;
    } rows[] = {
        {"lan9252-spi", &ect_eclink_map7, 406 * 400 + 18 * 1000, 3064, 21 * 400 + 3 * 1000, 564},
        {"lan9252-spi", &ect_fzm1, 138 * 400 + 10 * 1000, 2422, 21 * 400 + 3 * 1000, 564},
        {"lan9252-spi", &ect_pmctendo_dd5, 86 * 400 + 10 * 1000, 16484, 21 * 400 + 3 * 1000, 564},
        {"et1100-mmio", &ect_eclink_map7, 149 * 300, 6852, 2 * 300, 414},
        {"et1100-mmio", &ect_fzm1, 36 * 300, 2644, 2 * 300, 414},
        {"et1100-mmio", &ect_pmctendo_dd5, 8 * 300, 15990, 2 * 300, 414},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const ect_board_t *board = ect_board(rows[i].board);
        const ect_slow_config_t slow = {.board = board,
                                        .cycle_ns = ect_board_ns(ect_board_cycle(rows[i].device->name))};
        uint64_t computing_ns = rows[i].instructions * 1500 / 168;
        ect_device_t device;
        wire_t w;
        assert_true(ect_fit(rows[i].device, board->controller, &device));
        open_slow(&w, &device, &slow);
        go_to_op(&w);
        expect_exchange(&w, &device, rows[i].bus_ns + computing_ns - 10,
                        rows[i].idle_bus_ns + rows[i].idle_instructions * 1500 / 168 + 10);
        wire_close(&w);
        expect_row(rows[i].board, rows[i].device->name, rows[i].bus_ns, computing_ns);
    }
}

/* The same seed gives the same times, another seed gives others. */
static void seeds(void **state)
{
    uint64_t times[3];
    (void)state;
    for (size_t i = 0; i < 3; i++) {
        const ect_slow_config_t slow = {.al = {0, 100 * MS}, .seed = i < 2 ? 9 : 10};
        wire_t w;
        open_slow(&w, &testdev, &slow);
        wire_configure_mailbox(&w, 0);
        times[i] = change(&w, ECT_STATE_PREOP);
        wire_close(&w);
    }
    assert_int_equal(times[0], times[1]);
    assert_int_not_equal(times[0], times[2]);
}

/* The time between the entry of a frame into the chain and its arrival at port 0 of a twin, in 200 frames. The clock of
 * the twin began at its power-on. */
static void measure_arrivals(wire_t *w, size_t position, uint64_t on_ns, uint32_t *least, uint32_t *most)
{
    *least = UINT32_MAX;
    *most = 0;
    for (unsigned int n = 0; n < 200; n++) {
        uint8_t port[4] = {0};
        wire_advance(w, 1 * MS);
        uint32_t sent_ns = (uint32_t)(w->now_ns - on_ns);
        assert_true(wire_send(w, BWR, 0, 0x0900, port, sizeof port) > 0);
        assert_int_equal(wire_read(w, position, 0x0900, port, sizeof port), 1);
        uint32_t late = ect_load_le32(port) - sent_ns;
        *least = late < *least ? late : *least;
        *most = late > *most ? late : *most;
    }
}

/* The delays are computed again after the reset. */
static void reset_the_second(wire_t *w)
{
    const ect_fault_t reset = {.kind = ECT_FAULT_RESET, .slave = 2};
    assert_null(ect_chain_fault(w->chain, &reset, w->now_ns));
    wire_poll(w);
    wire_assign_stations(w);
}

static void receive_times(void **state)
{
    enum { TWINS = 2, JITTER_NS = 40 };
    ect_twin_config_t twins[TWINS] = {ect_twin_default(&testdev, NULL), ect_twin_default(&testdev, NULL)};
    uint64_t on_ns[TWINS] = {1000 * MS, 1000 * MS};
    uint32_t without[TWINS], least, most;
    wire_t w;
    (void)state;
    wire_open_twins(&w, twins, TWINS);
    for (size_t i = 0; i < TWINS; i++) {
        measure_arrivals(&w, i, on_ns[i], &without[i], &most);
        assert_int_equal(most, without[i]);
        twins[i].slow = (ect_slow_config_t){.receive_ns = JITTER_NS, .seed = 2};
    }
    wire_close(&w);
    assert_true(without[1] > without[0] + JITTER_NS);
    wire_open_twins(&w, twins, TWINS);
    for (unsigned int times = 0; times < 2; times++) {
        for (size_t i = 0; i < TWINS; i++) {
            measure_arrivals(&w, i, on_ns[i], &least, &most);
            assert_int_equal(least, without[i]);
            assert_int_equal(most, without[i] + JITTER_NS);
        }
        reset_the_second(&w);
        on_ns[1] = w.now_ns;
    }
    wire_close(&w);
}

/* The time between the arrivals of a frame from the far end at ports 1 and 0 of the second twin, whose input is cut: no
 * frame arrives at port 0, which keeps its delay. */
static int32_t between_the_ports(wire_t *w)
{
    uint8_t any[4] = {0};
    wire_build(w, BWR, 0, 0x0900, any, sizeof any);
    assert_int_equal(ect_chain_pass(w->chain, ECT_END_OUT, w->frame, w->frame_length, w->now_ns), ECT_END_OUT);
    const uint8_t *times = ect_chain_esc(w->chain, 1)->memory + 0x0900;
    return (int32_t)(ect_load_le32(times) - ect_load_le32(times + 4));
}

/* Each change of a link computes the delays again: the jitter of the times before is no part of them. */
static void jitter_does_not_grow(void **state)
{
    enum { TWINS = 2, JITTER_NS = 40, CHANGES = 100 };
    const ect_setting_t pulled = {.name = "ecat.plug_in", .value = "0"};
    ect_twin_config_t twins[TWINS] = {ect_twin_default(&testdev, NULL), ect_twin_default(&testdev, NULL)};
    char message[ECT_SIGNAL_MESSAGE];
    int32_t before_ns;
    wire_t w;
    (void)state;
    for (size_t i = 0; i < TWINS; i++)
        twins[i].slow = (ect_slow_config_t){.receive_ns = JITTER_NS, .seed = 2};
    wire_open_twins(&w, twins, TWINS);
    ect_chain_set_link(w.chain, ECT_END_OUT, true);
    assert_true(ect_settings_apply(w.chain, 1, &pulled, 1, w.now_ns, message));
    wire_poll(&w);
    before_ns = between_the_ports(&w);
    for (unsigned int n = 0; n < CHANGES; n++) {
        ect_chain_set_link(w.chain, ECT_END_IN, n % 2 != 0);
        ect_chain_wake(w.chain, 1);
        wire_advance(&w, MS);
        assert_in_range(between_the_ports(&w) - before_ns + 4 * JITTER_NS, 0, 8 * JITTER_NS);
    }
    wire_close(&w);
}

/* A reset during delayed writes: none of them reaches the chip afterwards. */
static void reset_under_way(void **state)
{
    const ect_slow_config_t slow = {.board = ect_board("lan9252-spi")};
    ect_device_t device;
    wire_t w;
    (void)state;
    assert_true(ect_fit(&testdev, &ect_fit_lan9252, &device));
    open_slow(&w, &device, &slow);
    wire_configure_mailbox(&w, 0);
    w.manual_poll = true;
    assert_int_equal(wire_write16(&w, 0, ECT_REG_AL_CONTROL, ECT_STATE_PREOP), 1);
    /* Until the poll has begun; AL status is written later. */
    for (unsigned int n = 0; n < 20 && ect_chain_slave(w.chain, 0)->state != ECT_STATE_PREOP; n++) {
        w.now_ns += 2 * US;
        (void)ect_chain_poll(w.chain, w.now_ns);
    }
    assert_int_equal(ect_chain_slave(w.chain, 0)->state, ECT_STATE_PREOP);
    assert_int_equal(ect_chain_esc(w.chain, 0)->memory[ECT_REG_AL_STATUS], ECT_STATE_INIT);
    ect_chain_power_cycle(w.chain, w.now_ns);
    w.manual_poll = false;
    wire_advance(&w, 10 * MS);
    assert_int_equal(ect_chain_esc(w.chain, 0)->memory[ECT_REG_AL_STATUS], ECT_STATE_INIT);
    wire_close(&w);
}

/* Writes reach the chip one after the other, at their times. A write that does not fit reaches it at once, after the
 * previous ones; so do all writes before a read. */
static void queue(void **state)
{
    const ect_slow_config_t config = {.board = ect_board("lan9252-spi")};
    static ect_slow_t slow;
    uint8_t data[64] = {0};
    chip_t *c = *state;
    ect_slow_init(&slow, &config, &c->esc, c->w.now_ns);
    ect_pdi_t pdi = ect_slow_pdi(&slow);
    assert_true(ect_slow_begins(&slow, c->w.now_ns));
    for (unsigned int n = 1; n <= sizeof slow.queue / sizeof data; n++) {
        memset(data, (int)n, sizeof data);
        assert_int_equal(pdi.write(pdi.ctx, 0x1000, data, sizeof data), 0);
        bool full = n > sizeof slow.queue / (sizeof data + 12);
        assert_int_equal(c->memory[0x1000], full ? n : 0);
        if (full)
            break;
    }
    (void)ect_slow_end(&slow, ECT_NEVER);
    assert_true(ect_slow_begins(&slow, slow.busy_ns));
    assert_int_equal(pdi.write(pdi.ctx, 0x1000, "\xA1", 1), 0);
    assert_int_equal(pdi.write(pdi.ctx, 0x1000, "\xA2", 1), 0);
    (void)ect_slow_end(&slow, ECT_NEVER);
    uint64_t first_ns = ect_slow_next(&slow, ECT_NEVER);
    ect_slow_run(&slow, first_ns - 1);
    assert_int_not_equal(c->memory[0x1000], 0xA1);
    ect_slow_run(&slow, first_ns);
    assert_int_equal(c->memory[0x1000], 0xA1);
    ect_slow_run(&slow, slow.busy_ns);
    assert_int_equal(c->memory[0x1000], 0xA2);
    assert_int_equal(ect_slow_next(&slow, ECT_NEVER), ECT_NEVER);
    assert_true(ect_slow_begins(&slow, slow.busy_ns));
    assert_int_equal(pdi.write(pdi.ctx, 0x1000, "\xA3", 1), 0);
    assert_int_equal(pdi.read(pdi.ctx, 0x1000, data, 1), 0);
    assert_int_equal(data[0], 0xA3);
}

/* The queue has room for a write of its whole size, initially and when all writes have reached the chip. */
static void whole_queue(void **state)
{
    enum { ENTRY = 12 };
    const ect_slow_config_t config = {.board = ect_board("lan9252-spi")};
    static ect_slow_t slow;
    static uint8_t data[sizeof slow.queue];
    chip_t *c = *state;
    ect_slow_init(&slow, &config, &c->esc, c->w.now_ns);
    ect_pdi_t pdi = ect_slow_pdi(&slow);
    uint64_t now_ns = c->w.now_ns;
    for (uint8_t n = 1; n <= 3; n++) {
        const uint16_t length = (uint16_t)(sizeof slow.queue - ENTRY + (n == 3 ? 1 : 0));
        memset(data, n, sizeof data);
        assert_true(ect_slow_begins(&slow, now_ns));
        assert_int_equal(pdi.write(pdi.ctx, 0x1000, data, length), 0);
        assert_int_equal(c->memory[0x1000], n == 3 ? 3 : n - 1); /* one byte more reaches the chip at once */
        (void)ect_slow_end(&slow, ECT_NEVER);
        now_ns = slow.busy_ns;
        ect_slow_run(&slow, now_ns);
        assert_int_equal(c->memory[0x1000], n);
    }
}

/* The main loop of a board without interrupt pin reads the event word without a pause. */
static void idle_reads(void **state)
{
    const ect_slow_config_t config = {.board = ect_board("lan9252-spi")};
    const uint64_t idle_ns = ect_board_access_ns(config.board, ECT_REG_AL_EVENT, 4, false);
    const struct {
        uint64_t since_ns, begins_ns; /* after the end of the last access */
    } rows[] = {{0, 0},
                {1, idle_ns},
                {idle_ns - 1, idle_ns},
                {idle_ns, idle_ns},
                {idle_ns + 1, 2 * idle_ns},
                {10 * idle_ns - 1, 10 * idle_ns},
                {10 * idle_ns, 10 * idle_ns}};
    chip_t *c = *state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        static ect_slow_t slow;
        const uint64_t end_ns = c->w.now_ns;
        ect_slow_init(&slow, &config, &c->esc, end_ns);
        bool begins = ect_slow_begins(&slow, end_ns + rows[i].since_ns);
        uint64_t got_ns = (begins ? end_ns + rows[i].since_ns : ect_slow_next(&slow, ECT_NEVER)) - end_ns;
        if (got_ns != rows[i].begins_ns)
            fail_msg("row %zu: expected the poll at %llu ns, got %llu ns", i, (unsigned long long)rows[i].begins_ns,
                     (unsigned long long)got_ns);
    }
}

/* Both ends of a range are drawn, and no value beyond; a range of many seconds is drawn in its whole width. */
static void random_delays(void **state)
{
    enum { DRAWS = 400 };
    static const struct {
        ect_slow_range_t range;
        uint64_t low_ns, high_ns; /* some values are below, some above */
    } rows[] = {{{5, 7}, 6, 6}, {{1, 2}, 2, 1}, {{7, 7}, 8, 6}, {{1000 * MS, 101000 * MS}, 10000 * MS, 90000 * MS}};
    chip_t *c = *state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const ect_slow_config_t config = {.jitter = rows[i].range, .seed = 4};
        ect_slow_t *slow = calloc(1, sizeof *slow);
        unsigned int low = 0, high = 0;
        assert_non_null(slow);
        ect_slow_init(slow, &config, &c->esc, 1000 * MS);
        for (unsigned int n = 0; n < DRAWS; n++) {
            assert_false(ect_slow_begins(slow, 1000 * MS));
            const uint64_t start_ns = ect_slow_next(slow, ECT_NEVER);
            const uint64_t delay_ns = start_ns - 1000 * MS;
            if (delay_ns < rows[i].range.min_ns || delay_ns > rows[i].range.max_ns)
                fail_msg("row %zu: %llu ns", i, (unsigned long long)delay_ns);
            low += delay_ns < rows[i].low_ns;
            high += delay_ns > rows[i].high_ns;
            assert_true(ect_slow_begins(slow, start_ns));
            (void)ect_slow_end(slow, ECT_NEVER);
        }
        assert_true(low >= DRAWS / 20 && high >= DRAWS / 20);
        free(slow);
    }
}

/* A restart continues with the random numbers; a new twin begins with its seed. */
static void random_after_a_restart(void **state)
{
    const ect_slow_config_t config = {.jitter = {1, 1000 * MS}, .seed = 4};
    uint64_t delays[3][3];
    chip_t *c = *state;
    for (unsigned int run = 0; run < 3; run++) {
        ect_slow_t *slow = calloc(1, sizeof *slow);
        assert_non_null(slow);
        ect_slow_init(slow, &config, &c->esc, 0);
        for (unsigned int n = 0; n < 3; n++) {
            if (run == 1 && n > 0)
                ect_slow_init(slow, &slow->config, &c->esc, 0);
            assert_false(ect_slow_begins(slow, 0));
            delays[run][n] = ect_slow_next(slow, ECT_NEVER);
            assert_true(ect_slow_begins(slow, delays[run][n]));
        }
        free(slow);
    }
    assert_memory_equal(delays[0], delays[1], sizeof delays[0]);
    assert_memory_equal(delays[0], delays[2], sizeof delays[0]);
    assert_true(delays[0][0] != delays[0][1]);
}

/* The code of the device runs once in each poll, at the first access to a buffer of process data. */
static void time_of_the_device(void **state)
{
    enum { CYCLE_NS = 1000000, BUFFER = 0x1100 };
    static const struct {
        const char *title;
        unsigned int n;
        uint16_t start;
        uint8_t control, activate;
        bool process_data;
    } rows[] = {
        {"a buffer", 0, BUFFER, 0x00, 1, true},     {"written by the master", 2, BUFFER, 0x24, 1, true},
        {"the last one", 7, BUFFER, 0x20, 1, true}, {"a mailbox", 2, BUFFER, 0x26, 1, false},
        {"disabled", 2, BUFFER, 0x24, 0, false},    {"another buffer", 2, BUFFER + 1, 0x24, 1, false},
    };
    const ect_slow_config_t config = {.board = ect_board("lan9252-spi"), .cycle_ns = CYCLE_NS};
    static ect_slow_t slow;
    chip_t *c = *state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t *sm = c->memory + ECT_REG_SM + rows[i].n * ECT_SM_SIZE;
        memset(c->memory + ECT_REG_SM, 0, 8 * ECT_SM_SIZE);
        ect_store_le16(sm + ECT_SM_START, rows[i].start);
        sm[ECT_SM_CONTROL] = rows[i].control;
        sm[ECT_SM_ACTIVATE] = rows[i].activate;
        memset(&slow, 0, sizeof slow);
        ect_slow_init(&slow, &config, &c->esc, c->w.now_ns);
        const ect_pdi_t pdi = ect_slow_pdi(&slow);
        for (unsigned int poll = 0; poll < 2; poll++) {
            const uint64_t begin_ns = slow.busy_ns;
            uint8_t byte;
            assert_true(ect_slow_begins(&slow, begin_ns));
            (void)pdi.read(pdi.ctx, BUFFER, &byte, 1);
            (void)pdi.read(pdi.ctx, BUFFER, &byte, 1);
            (void)ect_slow_end(&slow, ECT_NEVER);
            const uint64_t accesses_ns = 2 * ect_board_access_ns(config.board, BUFFER, 1, false);
            const uint64_t device_ns = slow.busy_ns - begin_ns - accesses_ns;
            if (device_ns != (rows[i].process_data ? CYCLE_NS : 0))
                fail_msg("%s: expected the time of the device: %d, got %llu ns", rows[i].title, rows[i].process_data,
                         (unsigned long long)device_ns);
        }
    }
}

/* Between two polls accesses take no time and are not delayed: they are those of the chain. */
static void accesses_between_polls(void **state)
{
    const ect_slow_config_t config = {.board = ect_board("lan9252-spi")};
    static ect_slow_t slow;
    chip_t *c = *state;
    uint32_t event;
    uint8_t byte = 0;
    memset(&slow, 0, sizeof slow);
    ect_slow_init(&slow, &config, &c->esc, c->w.now_ns);
    const ect_pdi_t pdi = ect_slow_pdi(&slow);
    assert_int_equal(pdi.write(pdi.ctx, 0x1000, "\xA1", 1), 0);
    assert_int_equal(c->memory[0x1000], 0xA1);
    assert_int_equal(pdi.read(pdi.ctx, 0x1000, &byte, 1), 0);
    assert_int_equal(byte, 0xA1);
    assert_int_equal(pdi.al_event(pdi.ctx, &event), 0);
    assert_true(slow.now_ns == c->w.now_ns);
    assert_true(ect_slow_next(&slow, ECT_NEVER) == ECT_NEVER);
    assert_true(ect_slow_begins(&slow, c->w.now_ns));
    assert_int_equal(pdi.al_event(pdi.ctx, &event), 0);
    assert_true(slow.now_ns == c->w.now_ns + ect_board_access_ns(config.board, ECT_REG_AL_EVENT, 4, false));
}

static void boards(void **state)
{
    (void)state;
    assert_ptr_equal(ect_board("lan9252-spi"), ect_board_at(0));
    assert_ptr_equal(ect_board("et1100-mmio"), ect_board_at(1));
    assert_null(ect_board("lan9252"));
    assert_null(ect_board_at(2));
}

/* Instructions as tests/check/cycles.sh counts them; a device without a count has none. */
static void cycles_of_devices(void **state)
{
    static const struct {
        const char *device;
        uint32_t instructions;
    } rows[] = {{"fzm1", 430}, {"optoncdt2300", 33000}, {"pmctendo-dd5", 14700}, {"pmctendo", 0}, {"", 0}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
        assert_int_equal(ect_board_cycle(rows[i].device), rows[i].instructions);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(boards),
        {"the cycle of a device has its instructions", cycles_of_devices, NULL, NULL, NULL},
        {"AL status follows a request after the delay, at random within its range", late_states, NULL, NULL, NULL},
        {"a request replaces the one that the slave has not processed yet", changed_request, NULL, NULL, NULL},
        {"the reply to a mail comes after the delay", late_mails, NULL, NULL, NULL},
        {"a mail that the slave cannot read yet causes no poll after the delay", mail_left, NULL, NULL, NULL},
        {"outputs reach a slave that is late by more than a cycle in the next cycle", old_inputs, NULL, NULL, NULL},
        {"PDI budget: the exchange of a twin like a board takes the time of its bus and of its instructions",
         exchange_on_board, NULL, NULL, NULL},
        {"the same seed gives the same delays", seeds, NULL, NULL, NULL},
        {"a delay is at random within its range, both ends included", random_delays, chip_setup, chip_teardown, NULL},
        {"a restart continues with the random delays", random_after_a_restart, chip_setup, chip_teardown, NULL},
        {"the time of the device's own code counts once in a poll with process data", time_of_the_device, chip_setup,
         chip_teardown, NULL},
        {"accesses between polls take no time", accesses_between_polls, chip_setup, chip_teardown, NULL},
        {"receive times are those of the chain and a jitter, also after a reset", receive_times, NULL, NULL, NULL},
        {"the jitter of receive times does not grow with changes of links", jitter_does_not_grow, NULL, NULL, NULL},
        {"a poll of a board begins with the next read of the event word", idle_reads, chip_setup, chip_teardown, NULL},
        {"the queue of a board's writes has its whole room again when it is empty", whole_queue, chip_setup,
         chip_teardown, NULL},
        {"writes of a board reach the chip at their times, or at once if they do not fit or before a read", queue,
         chip_setup, chip_teardown, NULL},
        {"a power cycle discards the delayed writes of a board", reset_under_way, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests_name("slow twins", tests, NULL, NULL);
}
