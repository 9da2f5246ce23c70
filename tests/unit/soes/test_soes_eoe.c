/* SPDX-License-Identifier: MIT */
/* EoE of a SOES application: its callbacks and the twelve functions of the address. EOE-060 to EOE-062. */
#include <string.h>

#include "seams/eoe.h"
#include "seams/standard.h"
#include "soes/describe.h"
#include "soes/ect_soes.h"
#include "soes/esc_eoe.h"
#include "soes/everything.h"
#include "soes/hal.h"
#include "soes/internal.h"
#include "support/wire.h"

enum { MAIL_HEADER = 6, HEADER = 4, LAST = 1, ROOM = 1600, NOTHING = -1 };

static wire_t w;
static ect_device_t description;
static esc_cfg_t config;

/* The application's side. */
static struct {
    uint8_t in[ROOM], out[ROOM];
    size_t in_length;
    unsigned int got, taken, freed, polls, fragments, loads, stores;
    bool full, without_payload;
    int to_send; /* length of the frame that waits */
    int result;  /* of store_ethernet_settings */
    uint32_t stored_ip;
} app;

static void get_buffer(eoe_pbuf_t *buffer)
{
    app.got++;
    buffer->payload = app.full ? NULL : app.in;
}

static void free_buffer(eoe_pbuf_t *buffer)
{
    assert_ptr_equal(buffer->payload, app.out);
    app.freed++;
}

static int load(void)
{
    uint8_t mac[6] = {2, 0, 0x5E, 0x10, 0x20, 0x30};
    app.loads++;
    return EOE_ecat_set_mac(0, mac);
}

static int store(void)
{
    app.stores++;
    assert_int_equal(EOE_ecat_get_ip(0, &app.stored_ip), 0);
    return app.result;
}

static void take(uint8_t port, eoe_pbuf_t *buffer)
{
    assert_int_equal(port, 0);
    assert_ptr_equal(buffer->payload, app.in);
    app.in_length = buffer->len;
    app.taken++;
}

static int fetch(uint8_t port, eoe_pbuf_t *buffer)
{
    int length = app.to_send;
    assert_int_equal(port, 0);
    app.polls++;
    app.to_send = 0;
    buffer->payload = app.without_payload ? NULL : app.out;
    return length;
}

static void fragment_sent(void)
{
    app.fragments++;
}

static eoe_cfg_t callbacks;

static uint64_t now(void)
{
    return w.now_ns;
}

static void poll_application(wire_t *wire)
{
    (void)ect_esc_tick(hal.esc, wire->now_ns);
    ecat_slv();
}

static int setup(void **state)
{
    (void)state;
    memset(&w, 0, sizeof w);
    memset(&hal, 0, sizeof hal);
    memset(&everything, 0, sizeof everything);
    memset(&app, 0, sizeof app);
    memset(&ect_soes_instance, 0, sizeof ect_soes_instance); /* power-off */
    callbacks = (eoe_cfg_t){get_buffer, free_buffer, load, store, take, fetch, fragment_sent};
    config = (esc_cfg_t){.watchdog_cnt = 100000};
    EOE_config(&callbacks);
    ect_soes_describe(&description);
    description.instance_size = sizeof(ect_standard_t);
    wire_open_one(&w, &description); /* its own slave is never polled: only the chip is used */
    hal.esc = ect_chain_esc(w.chain, 0);
    w.poll = poll_application;
    ect_soes_clock(now);
    ecat_slv_init(&config);
    wire_go(&w, 0, ECT_STATE_PREOP);
    return 0;
}

static int teardown(void **state)
{
    (void)state;
    wire_close(&w);
    return 0;
}

static void send_data(const uint8_t *data, size_t length)
{
    assert_int_equal(wire_mail_request(&w, 0, ECT_MAILBOX_TYPE_EOE, data, (uint16_t)length), 1);
}

static int receive(uint8_t data[ROOM])
{
    uint8_t mail[ROOM];
    int length = wire_mail_receive(&w, 0, mail, sizeof mail);
    if (length < 0)
        return NOTHING;
    assert_int_equal(mail[5] & 0x0F, ECT_MAILBOX_TYPE_EOE);
    memcpy(data, mail + MAIL_HEADER, (size_t)length);
    return length;
}

static void send_frame(unsigned int length)
{
    uint8_t data[HEADER + 54] = {0, LAST};
    ect_store_le16(data + 2, (uint16_t)((length + 31) / 32 << 6));
    for (unsigned int i = 0; i < length; i++)
        data[HEADER + i] = (uint8_t)(i + 1);
    send_data(data, HEADER + length);
}

static void frames_to_the_application(void **state)
{
    (void)state;
    send_frame(48);
    assert_int_equal(app.taken, 1);
    assert_int_equal(app.in_length, 48);
    assert_int_equal(app.in[47], 48);
    app.full = true;
    send_frame(48);
    assert_int_equal(app.taken, 1);
    app.full = false;
    send_frame(50);
    assert_int_equal(app.taken, 2);
    callbacks.get_buffer = NULL;
    send_frame(48);
    assert_int_equal(app.taken, 2);
}

/* The length of a frame of the application, as the stack gets it: one that is too long is counted as dropped. */
static void lengths_of_frames(void **state)
{
    static const struct {
        int length;
        bool payload;
        unsigned int want, freed;
    } rows[] = {
        {0, true, 0, 0},
        {-1, true, 0, 0},
        {60, false, 0, 0},
        {1, true, 1, 1},
        {ECT_EOE_FRAME, true, ECT_EOE_FRAME, 1},
        {ECT_EOE_FRAME + 1, true, ECT_EOE_FRAME + 1, 1},
        {70000, true, ECT_EOE_FRAME + 1, 1},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint8_t frame[ECT_EOE_FRAME + 8], port = 7;
        memset(frame, 0xA5, sizeof frame);
        app.freed = 0;
        app.to_send = rows[i].length;
        app.without_payload = !rows[i].payload;
        const unsigned int got = ect_soes_network.fetch(&ect_soes_network, NULL, frame, &port);
        if (got != rows[i].want || app.freed != rows[i].freed || port != (got > 0 ? 0 : 7))
            fail_msg("%d bytes: expected %u and %u freed, got %u and %u, port %u", rows[i].length, rows[i].want,
                     rows[i].freed, got, app.freed, port);
        for (size_t n = got < ECT_EOE_FRAME ? got : ECT_EOE_FRAME; n < sizeof frame; n++)
            assert_int_equal(frame[n], 0xA5);
    }
}

static void frames_of_the_application(void **state)
{
    uint8_t data[ROOM];
    unsigned int polls = app.polls;
    (void)state;
    wire_poll(&w);
    assert_true(app.polls > polls); /* EOE-061: each turn, without a wake */
    for (unsigned int i = 0; i < 200; i++)
        app.out[i] = (uint8_t)(i * 5);
    app.to_send = 200;
    wire_poll(&w);
    assert_int_equal(app.freed, 1);
    unsigned int at = 0;
    for (int length; (length = receive(data)) != NOTHING;) {
        assert_memory_equal(data + HEADER, app.out + at, (size_t)length - HEADER);
        at += (unsigned int)length - HEADER;
    }
    assert_int_equal(at, 200);
    assert_int_equal(app.fragments, 6); /* 5 of 32 bytes in a mailbox of 64, and 40 */
    app.to_send = 1600;                 /* longer than a frame may be: dropped, and its buffer is returned */
    wire_poll(&w);
    assert_int_equal(receive(data), NOTHING);
    assert_int_equal(app.freed, 2);
    app.to_send = -1;
    wire_poll(&w);
    assert_int_equal(receive(data), NOTHING);
    assert_int_equal(app.freed, 2);
}

static void half_a_frame_is_dropped(void **state)
{
    uint8_t data[ROOM];
    (void)state;
    app.to_send = 200;
    wire_poll(&w);
    EOE_init();
    assert_int_equal(receive(data), HEADER + 32); /* that was in the mailbox already */
    assert_int_equal(receive(data), NOTHING);
}

static void settings(void **state)
{
    static const uint8_t set[] = {2, 1, 0, 0, 2, 0, 0, 0, 0x14, 0x0A, 0xA8, 0xC0}, get[] = {6, 1, 0, 0};
    static const struct {
        const char *what;
        int result;
        bool missing;
        uint8_t reply[2];
        uint32_t ip; /* afterwards, 0: none */
    } rows[] = {
        {"stored", 0, false, {0, 0}, 0xC0A80A14},
        {"EOE-035: no IP support", EOE_RESULT_NO_IP_SUPPORT, false, {1, 2}, 0},
        {"EOE-062: -1 becomes FFFFh", -1, false, {0xFF, 0xFF}, 0},
        {"EOE-035: no function", 0, true, {1, 2}, 0},
    };
    uint8_t data[ROOM];
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        uint32_t ip = 0;
        (void)teardown(state);
        (void)setup(state);
        app.result = rows[i].result;
        callbacks.store_ethernet_settings = rows[i].missing ? NULL : store;
        send_data(set, sizeof set);
        assert_int_equal(receive(data), HEADER);
        if (memcmp(data + 2, rows[i].reply, 2) != 0)
            fail_msg("%s: expected %02X%02Xh, got %02X%02Xh", rows[i].what, rows[i].reply[1], rows[i].reply[0], data[3],
                     data[2]);
        assert_int_equal(app.stores, !rows[i].missing);
        if (!rows[i].missing)
            assert_int_equal(app.stored_ip, 0xC0A80A14); /* the callback finds the new address */
        int known = EOE_ecat_get_ip(0, &ip);
        if ((known == 0) != (rows[i].ip != 0) || ip != rows[i].ip)
            fail_msg("%s: expected %08X, got %d with %08X", rows[i].what, rows[i].ip, known, ip);
    }
    send_data(get, sizeof get);
    assert_int_equal(receive(data), HEADER + 4 + 6);
    assert_int_equal(app.loads, 1);
    assert_int_equal(data[4], 1); /* the MAC that the callback has set */
}

static void address_functions(void **state)
{
    static const struct {
        int (*set)(uint8_t, uint32_t);
        int (*get)(uint8_t, uint32_t *);
    } numbers[] = {{EOE_ecat_set_ip, EOE_ecat_get_ip},
                   {EOE_ecat_set_subnet, EOE_ecat_get_subnet},
                   {EOE_ecat_set_gateway, EOE_ecat_get_gateway},
                   {EOE_ecat_set_dns_ip, EOE_ecat_get_dns_ip}};
    uint8_t mac[6] = {2, 1, 2, 3, 4, 5}, got_mac[6];
    char name[33];
    char long_name[] = "0123456789012345678901234567890123456789";
    (void)state;
    for (uint32_t i = 0; i < 4; i++) {
        uint32_t value = 0;
        assert_int_equal(numbers[i].get(0, &value), -1);
        assert_int_equal(numbers[i].set(1, 1), -1);
        assert_int_equal(numbers[i].set(0, 0xC0A80001 + i), 0);
        assert_int_equal(numbers[i].get(1, &value), -1);
        assert_int_equal(numbers[i].get(0, &value), 0);
        assert_int_equal(value, 0xC0A80001 + i);
    }
    assert_int_equal(EOE_ecat_get_mac(0, got_mac), -1);
    assert_int_equal(EOE_ecat_set_mac(0, mac), 0);
    assert_int_equal(EOE_ecat_get_mac(0, got_mac), 0); /* SOES keeps this -1 until a master has set one */
    assert_memory_equal(got_mac, mac, 6);
    assert_int_equal(EOE_ecat_get_dns_name(0, name), -1);
    assert_int_equal(EOE_ecat_set_dns_name(0, long_name), 0);
    assert_int_equal(EOE_ecat_get_dns_name(0, name), 0);
    assert_memory_equal(name, long_name, 32);
    assert_int_equal(EOE_ecat_set_dns_name(1, long_name), -1);
}

/* As applications of SOES start: the address and EOE_init come before ecat_slv_init. */
static void before_the_slave(void **state)
{
    static const uint8_t get_ip[] = {6, 1, 0, 0};
    uint8_t mac[6] = {2, 1, 2, 3, 4, 5}, got[6], data[ROOM];
    uint32_t ip = 0;
    (void)state;
    memset(&ect_soes, 0, sizeof ect_soes);
    callbacks.load_eth_settings = NULL;
    EOE_config(&callbacks);
    EOE_init();
    assert_int_equal(EOE_ecat_set_mac(0, mac), 0);
    assert_int_equal(EOE_ecat_set_ip(0, 0xC0A80A14), 0);
    assert_int_equal(EOE_ecat_get_ip(0, &ip), 0);
    ect_soes_clock(now);
    ecat_slv_init(&config);
    wire_go(&w, 0, ECT_STATE_PREOP);
    assert_int_equal(EOE_ecat_get_mac(0, got), 0);
    assert_memory_equal(got, mac, sizeof mac);
    send_data(get_ip, sizeof get_ip);
    assert_int_equal(receive(data), HEADER + 4 + 6 + 4);
    assert_memory_equal(data + HEADER + 4, mac, sizeof mac);
}

static void without_callbacks(void **state)
{
    static const uint8_t set[] = {2, 1, 0, 0, 2, 0, 0, 0, 0x14, 0x0A, 0xA8, 0xC0};
    uint8_t data[ROOM];
    (void)state;
    EOE_config(NULL);
    send_frame(48);
    wire_poll(&w);
    send_data(set, sizeof set);
    assert_int_equal(receive(data), HEADER);
    assert_int_equal(ect_load_le16(data + 2), EOE_RESULT_NO_IP_SUPPORT);
    assert_int_equal(app.got, 0);
}

int main(void)
{
    static const struct CMUnitTest tests[] = {
        {"EOE-016 EOE-060: a frame is delivered in the application's buffer", frames_to_the_application, setup,
         teardown, NULL},
        {"EOE-061: fetch_send_buffer is called in each turn", frames_of_the_application, setup, teardown, NULL},
        {"EOE-060: a frame has its length, none without a payload; a longer one than fits is too long",
         lengths_of_frames, setup, teardown, NULL},
        {"EOE-060: EOE_init drops half a frame", half_a_frame_is_dropped, setup, teardown, NULL},
        {"EOE-035 EOE-036 EOE-062: the result of store_ethernet_settings is the master's", settings, setup, teardown,
         NULL},
        {"EOE-060 EOE-062: addresses are numbers, with -1 for unknown", address_functions, setup, teardown, NULL},
        {"EOE-060: an address that is set before ecat_slv_init is kept, and EOE_init may be called there",
         before_the_slave, setup, teardown, NULL},
        {"EOE-060: without EOE_config set IP is refused and frames are dropped", without_callbacks, setup, teardown,
         NULL},
    };
    return cmocka_run_group_tests_name("EoE of SOES's API", tests, NULL, NULL);
}
