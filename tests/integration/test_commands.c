/* SPDX-License-Identifier: MIT */
/*
 * Commands between controller and remote unit on a bus that loses frames: each arrives exactly once and in order.
 * usage: ectwin with --in-process [--virtual-time] --fault "at slave 1 OP drop 10%" vr-bu-ect-map7 --
 *        test_commands {} COUNT
 * COUNT: commands of each side. tools/dev/commands.sh runs a million.
 */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bu_controller.h"
#include "plant.h"
#include "soem.h"

enum { REPLY_TIMEOUT_US = 100, CYCLE_US = 20000 };
enum { QUEUED_MOST = 4, HEX = 2 * BU_COMMAND_BYTES, NUMBER = 8 /* digits at the end of a command */ };

typedef struct side {
    uint32_t sent, received;
} side_t;

static const char *iface;
static uint32_t wanted;
static soem_t master;
static bu_controller_t controller;
static side_t by_operator, by_controller;
static uint64_t cycles, lost_cycles;
static uint8_t screen[4321];
/* FNV-1a over the times and inputs of all cycles: equal in equal runs. */
static uint64_t hash = 0xCBF29CE484222325u;

static void add_to_hash(const void *data, size_t length)
{
    const uint8_t *bytes = data;
    for (size_t i = 0; i < length; i++)
        hash = (hash ^ bytes[i]) * 0x100000001B3u;
}

static void on_command(void *ctx, uint16_t ru, const uint8_t *command)
{
    (void)ctx;
    uint32_t number =
        (uint32_t)command[12] << 24 | (uint32_t)command[13] << 16 | (uint32_t)command[14] << 8 | command[15];
    assert_int_equal(ru, 1);
    assert_int_equal(number, ++by_operator.received);
}

static void operate(void)
{
    char command[HEX + 1];
    if (by_operator.sent == wanted || by_operator.sent - by_operator.received == QUEUED_MOST)
        return;
    snprintf(command, sizeof command, "%0*d%08" PRIx32, HEX - NUMBER, 0, ++by_operator.sent);
    plant_set("ru1.command", command);
}

/* The unit's last command has the number of all that it has received. */
static void assert_received(void)
{
    char last[HEX + 1];
    snprintf(last, sizeof last, "%s", plant_get("ru1.received"));
    uint32_t count = (uint32_t)plant_number("ru1.received_count");
    assert_int_equal(strtoul(last + HEX - NUMBER, NULL, 16), count);
    assert_in_range(count, by_controller.received, by_controller.sent);
    by_controller.received = count;
}

static void send_numbered(void)
{
    uint8_t command[BU_COMMAND_BYTES] = {0};
    uint32_t number = by_controller.sent + 1;
    for (unsigned int i = 0; i < 4; i++)
        command[BU_COMMAND_BYTES - 1 - i] = (uint8_t)(number >> 8 * i);
    if (by_controller.sent == wanted || !bu_controller_send(&controller, 1, command))
        return;
    by_controller.sent = number;
    assert_received();
}

static void cycle(void)
{
    ecx_send_processdata(&master.context);
    int counter = ecx_receive_processdata(&master.context, REPLY_TIMEOUT_US);
    osal_usleep(CYCLE_US);
    uint64_t now_ns = soem_now();
    add_to_hash(&now_ns, sizeof now_ns);
    add_to_hash(master.slaves[1].inputs, master.slaves[1].Ibytes);
    cycles++;
    lost_cycles += counter != soem_expected_wkc(&master);
    bu_controller_step(&controller, master.slaves[1].inputs, master.slaves[1].outputs, now_ns);
}

static void commands_arrive_exactly_once_and_in_order(void **state)
{
    (void)state;
    soem_open(&master, iface, 1);
    plant_set("ru1.on", "1");
    soem_map(&master);
    controller = (bu_controller_t){.on_command = on_command,
                                   .output_bytes = master.slaves[1].Obytes,
                                   .periodic = screen,
                                   .periodic_size = sizeof screen};
    bu_controller_start(&controller);
    soem_operational(&master);
    uint64_t since_ns = soem_now();
    while (controller.safe)
        cycle();
    plant_set("ru1.armed", "1");
    while (by_operator.received < wanted || by_controller.received < wanted) {
        cycle();
        operate();
        send_numbered();
        if (by_controller.sent == wanted)
            assert_received();
        if (cycles > 20ull * (wanted + 1000))
            fail_msg("in %" PRIu64 " cycles only %u and %u of %u commands", cycles, by_operator.received,
                     by_controller.received, wanted);
    }
    for (unsigned int i = 0; i < 100; i++) /* a second command with the same number would come now */
        cycle();
    assert_received();
    print_message("%u commands each way, %" PRIu64 " cycles in %.0f s of bus, %.1f %% lost, %u sets, hash %016" PRIx64
                  "\n",
                  wanted, cycles, (double)(soem_now() - since_ns) / 1e9, 100.0 * (double)lost_cycles / (double)cycles,
                  controller.sets_sent, hash);
    assert_true(lost_cycles > 0);
    soem_close(&master);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"ECL-023 ECL-025 ECL-050 commands both ways arrive exactly once and in order where frames are lost",
         commands_arrive_exactly_once_and_in_order, NULL, NULL, NULL},
    };
    if (argc < 3) {
        print_error("usage: test_commands INTERFACE COUNT\n");
        return 1;
    }
    iface = argv[1];
    wanted = (uint32_t)strtoul(argv[2], NULL, 10);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
