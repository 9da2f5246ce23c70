/* SPDX-License-Identifier: MIT */
/* Network files that ectwin writes: read back they are the same bus, and played they bring it to OP. */
#define _GNU_SOURCE
#include "../esi/from_text.h"
#include "bus_of_twins.h"

#include <stdlib.h>
#include <unistd.h>

#include "bus/chain/catalogue.h"
#include "eni/bus.h"
#include "eni/write.h"
#include "esi/twin.h"
#include "wire/bytes.h"
#include "wire/registers.h"

enum { SLAVES = 12, CYCLE_US = 2000, CYCLES = 20 };

/* Devices of the catalogue. */
static const struct {
    const char *title, *devices;
} buses[] = {
    {"a camera", "fzm1"},
    {"a base unit", "vr-bu-ect-map1"},
    {"a base unit with other process data", "vr-bu-ect-map3"},
    {"a base unit with large process data", "vr-bu-ect-map7"},
    {"a base unit for several arms", "vr-bu-ect-multiarm"},
    {"a distance sensor", "optoncdt2300"},
    {"a drive with a short mailbox", "pmctendo-dd5"},
    {"one of each", "fzm1,vr-bu-ect-map1,vr-bu-ect-map3,vr-bu-ect-map7,vr-bu-ect-multiarm,optoncdt2300,pmctendo-dd5"},
};

typedef struct written {
    ect_arena_t arena;
    ect_eni_part_t parts[SLAVES];
    size_t count;
    const char *file;
    size_t length;
    ect_eni_t *eni;
} written_t;

static void add_part(written_t *w, const char *name)
{
    const ect_product_t *product = ect_catalogue_find(name);
    assert_non_null(product);
    ect_eni_part_t *part = &w->parts[w->count++];
    *part = (ect_eni_part_t){.device = product->device, .identity = product->device->identity};
    part->identity.serial = (uint32_t)w->count;
}

static void write_parts(const char *title, written_t *w)
{
    char why[400] = "";
    w->file = ect_eni_write(&w->arena, w->parts, w->count, CYCLE_US, &w->length, why, sizeof why);
    w->eni = w->file != NULL ? ect_eni_parse("w.xml", w->file, w->length, why, sizeof why) : NULL;
    if (w->eni == NULL)
        fail_msg("%s: %s", title, why);
}

static void write_devices(const char *title, const char *devices, written_t *w)
{
    char names[300];
    (void)snprintf(names, sizeof names, "%s", devices);
    *w = (written_t){.count = 0};
    for (char *rest = names, *name = strtok_r(rest, ",", &rest); name != NULL; name = strtok_r(NULL, ",", &rest))
        add_part(w, name);
    write_parts(title, w);
}

static void drop(written_t *w)
{
    ect_eni_close(w->eni);
    ect_arena_free(&w->arena);
}

static void play(const char *title, const written_t *w, const char *device)
{
    bus_of_twins_t b;
    const char *const words[] = {"--quiet", device};
    bus_open(&b, 2, words);
    ect_eni_player_t player = {.eni = w->eni, .wire = &b.wire};
    bool fine = ect_eni_play(&player, ECT_ENI_OPERATIONAL);
    for (unsigned int i = 0; fine && i < CYCLES; i++)
        fine = ect_eni_play_cycle(&player);
    if (!fine)
        fail_msg("%s on %s: %s", title, device, b.lines);
    ectwin_bus_close(b.bus);
}

static void CF_N02_a_written_file_brings_its_devices_to_OP_with_every_counter_as_expected(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof buses / sizeof buses[0]; i++) {
        written_t w;
        write_devices(buses[i].title, buses[i].devices, &w);
        play(buses[i].title, &w, buses[i].devices);
        drop(&w);
    }
}

/* The twins of the file alone are made of the file and nothing else. */
static void CF_N02_a_written_file_brings_the_twins_that_it_makes_to_OP(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof buses / sizeof buses[0]; i++) {
        char path[] = "/tmp/eni-XXXXXX", device[40];
        written_t w;
        write_devices(buses[i].title, buses[i].devices, &w);
        const int fd = mkstemp(path);
        assert_true(fd >= 0 && write(fd, w.file, w.length) == (ssize_t)w.length);
        (void)close(fd);
        (void)snprintf(device, sizeof device, "eni:%s", path);
        play(buses[i].title, &w, device);
        (void)unlink(path);
        drop(&w);
    }
}

static void CF_N01_a_written_file_is_read_as_the_same_bus(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof buses / sizeof buses[0]; i++) {
        written_t w;
        write_devices(buses[i].title, buses[i].devices, &w);
        const ect_eni_network_t *network = ect_eni_network(w.eni);
        assert_int_equal(network->slave_count, w.count);
        for (size_t k = 0; k < w.count; k++) {
            const ect_eni_slave_t *slave = &network->slaves[k];
            const ect_device_t *device = w.parts[k].device;
            char why[400] = "";
            assert_int_equal(slave->vendor_id, device->identity.vendor_id);
            assert_int_equal(slave->product_code, device->identity.product_code);
            assert_int_equal(slave->revision, device->identity.revision);
            assert_int_equal(slave->serial, k + 1);
            assert_int_equal((uint16_t)slave->place.value, (uint16_t)(0 - k));
            assert_string_equal(slave->physics, device->physics);
            ect_esi_t *esi = ect_eni_device(w.eni, k, why, sizeof why);
            ect_esi_twin_t *twin = ect_esi_twin_take(esi, "", NULL, 0, why, sizeof why);
            if (twin == NULL)
                fail_msg("%s: %s", device->name, why);
            const ect_device_t *made = ect_esi_twin_product(twin)->device;
            assert_int_equal(made->sm_count, device->sm_count);
            assert_int_equal(made->mailbox_protocols, device->mailbox_protocols);
            for (unsigned int n = 0; n < device->sm_count; n++) {
                assert_int_equal(made->sm[n].type, device->sm[n].type);
                assert_int_equal(made->sm[n].start, device->sm[n].start);
                assert_int_equal(made->sm[n].control, device->sm[n].control);
                assert_int_equal(ect_device_sm_bytes(made, n), ect_device_sm_bytes(device, n));
            }
            ect_esi_twin_free(twin);
        }
        drop(&w);
    }
}

/* Texts that a master needs, and that reading back does not show. */
static void CF_N01_a_written_file_has_frames_checks_and_mailbox_of_the_device(void **state)
{
    static const char *const texts[] = {"<Destination>FFFFFFFFFFFF</Destination>",
                                        "<Source>020000000001</Source>",
                                        "<EtherType>A488</EtherType>",
                                        "<Comment>vendor id</Comment>",
                                        "<Comment>product code</Comment>",
                                        "<Comment>revision</Comment>",
                                        "<RevisionNo>65536</RevisionNo>",
                                        "<Mailbox DataLinkLayer=\"true\">"};
    written_t w;
    (void)state;
    write_devices("a camera", "fzm1", &w);
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++) {
        if (strstr(w.file, texts[i]) == NULL)
            fail_msg("expected %s", texts[i]);
    }
    drop(&w);
    ect_device_t device = *ect_catalogue_find("fzm1")->device;
    device.general_flags = ECT_GENERAL_GIVEN | ECT_GENERAL_ID_AL_STATUS;
    w = (written_t){.count = 0};
    add_part(&w, "fzm1");
    w.parts[0].device = &device;
    write_parts("a camera that repeats no mails", &w);
    assert_null(strstr(w.file, "DataLinkLayer=\"true\""));
    assert_non_null(strstr(w.file, "<Mailbox"));
    drop(&w);
}

/* @return the timeout of the wait for the state after a transition; 0: there is no such wait */
static unsigned int timeout_of(const written_t *w, unsigned int transition)
{
    const ect_eni_slave_t *slave = slave_of(w->eni, 0);
    for (size_t i = 0; i < slave->command_count; i++) {
        const ect_eni_command_t *command = &slave->commands[i];
        if (command->ado == ECT_REG_AL_STATUS && (command->transitions & transition) != 0)
            return command->validate.timeout_ms;
    }
    return 0;
}

static void each_transition_has_the_timeout_of_the_device(void **state)
{
    static const struct {
        ect_timeouts_t timeouts;
        unsigned int ms[6]; /* IP, PS, SO, OS, SP, PI */
    } rows[] = {
        {{0}, {3000, 10000, 10000, 200, 5000, 5000}},
        {{.preop_ms = 11, .safeop_op_ms = 22, .back_to_safeop_ms = 33, .back_to_init_ms = 44},
         {11, 22, 22, 33, 44, 44}},
    };
    static const unsigned int transitions[] = {ECT_ENI_IP, ECT_ENI_PS, ECT_ENI_SO, ECT_ENI_OS, ECT_ENI_SP, ECT_ENI_PI};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_device_t device = *ect_catalogue_find("fzm1")->device;
        written_t w = {.count = 0};
        device.timeouts = rows[i].timeouts;
        add_part(&w, "fzm1");
        w.parts[0].device = &device;
        write_parts("timeouts", &w);
        for (size_t k = 0; k < 6; k++)
            assert_int_equal(timeout_of(&w, transitions[k]), rows[i].ms[k]);
        drop(&w);
    }
}

static void ENI_013_the_sizes_of_a_SyncManager_come_back(void **state)
{
    static const struct {
        uint16_t minimum, maximum;
    } rows[] = {{0, 0}, {1, 1}, {0, 34}, {34, 0}, {34, 1486}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_device_t device = *ect_catalogue_find("fzm1")->device;
        written_t w = {.count = 0};
        device.sm[0].minimum = device.sm[2].minimum = rows[i].minimum;
        device.sm[0].maximum = device.sm[2].maximum = rows[i].maximum;
        add_part(&w, "fzm1");
        w.parts[0].device = &device;
        write_parts("sizes", &w);
        for (unsigned int n = 0; n <= 2; n += 2) {
            const ect_eni_sm_t *sm = &slave_of(w.eni, 0)->sms[n];
            if (sm->minimum != rows[i].minimum || sm->maximum != rows[i].maximum)
                fail_msg("SyncManager %u: expected %u to %u bytes, got %u to %u", n, rows[i].minimum, rows[i].maximum,
                         (unsigned int)sm->minimum, (unsigned int)sm->maximum);
        }
        assert_int_equal(strstr(w.file, "<MinSize>0<") == NULL && strstr(w.file, "<MaxSize>0<") == NULL, true);
        drop(&w);
    }
}

static const ect_dc_mode_t *clock_of(const ect_device_t *device)
{
    for (unsigned int i = 0; i < device->dc_mode_count; i++) {
        if (device->dc_modes[i].assign_activate != 0)
            return &device->dc_modes[i];
    }
    return NULL;
}

enum { MAILS = 7, BYTES = 40 };

/* Mails of each protocol, in the order of a network file. */
static const uint8_t writes[] = "\x02\0\x21\x43\x65\x87"
                                "a & b.bin\0\x01\x02",
                     reads[] = "\x01\0\0\0\0\0log";
static const uint8_t bytes[BYTES] = {10, 0, 0, 5};
static const ect_init_mail_t mails[MAILS] = {
    {.transitions = "IP", .protocol = ECT_MAILBOX_TYPE_AOE, .comment = "NetId", .size = 38, .data = bytes},
    {.transitions = "IP PS", .protocol = ECT_MAILBOX_TYPE_EOE, .type = 2, .size = 16, .data = bytes},
    {.transitions = "PS", .protocol = ECT_MAILBOX_TYPE_EOE, .type = 6, .disabled = true},
    {.transitions = "PS",
     .protocol = ECT_MAILBOX_TYPE_SOE,
     .type = ECT_INIT_WRITES,
     .drive = 1,
     .elements = 0x40,
     .idn = 0x8102,
     .size = 2,
     .data = bytes},
    {.transitions = "SO", .protocol = ECT_MAILBOX_TYPE_SOE, .type = ECT_INIT_READS, .elements = 0xC8, .idn = 17},
    {.transitions = "PS",
     .protocol = ECT_MAILBOX_TYPE_FOE,
     .type = ECT_ENI_FOE_WRITES,
     .size = sizeof writes - 1,
     .data = writes},
    {.transitions = "PS",
     .protocol = ECT_MAILBOX_TYPE_FOE,
     .type = ECT_ENI_FOE_READS,
     .size = sizeof reads,
     .data = reads}};

/* A device with commands of each kind: CoE, the mails above, and a mailbox for BOOT. */
static ect_device_t device_with_commands(const ect_device_t *like)
{
    static const uint8_t value[4] = {1, 2, 3, 4};
    static const ect_init_command_t commands[] = {
        {.transitions = "IP PS OS", .index = 0x1018, .subindex = 1, .upload = true},
        {.transitions = "PS", .comment = "gain", .index = 0x8000, .subindex = 1, .size = 2, .data = value},
        {.transitions = "PS", .index = 0x8001, .complete = true, .size = 4, .data = value},
        {.transitions = "SO", .index = 0x8002, .subindex = 255, .disabled = true, .size = 1, .data = value}};
    ect_device_t device = *like;
    device.mailbox_protocols =
        ECT_MAILBOX_AOE | ECT_MAILBOX_EOE | ECT_MAILBOX_COE | ECT_MAILBOX_FOE | ECT_MAILBOX_SOE | ECT_MAILBOX_VOE;
    device.init_commands = commands;
    device.init_command_count = sizeof commands / sizeof commands[0];
    device.init_mails = mails;
    device.init_mail_count = MAILS;
    device.boot_out = (ect_boot_mailbox_t){.start = 0x1000, .length = 512};
    device.boot_in = (ect_boot_mailbox_t){.start = 0x1200, .length = 256};
    return device;
}

/* Three slaves: the second at port B of the first, in a hot-connect group, with an alias; both with clocks. The third
 * at port C of the first, in a group without a name, with commands of each kind. */
static void write_known(written_t *w)
{
    *w = (written_t){.count = 0};
    add_part(w, "fzm1");
    add_part(w, "pmctendo-dd5");
    w->parts[0].clock = clock_of(w->parts[0].device);
    w->parts[1].clock = clock_of(w->parts[1].device);
    w->parts[1].alias = 7;
    w->parts[1].up_port = 1;
    w->parts[1].group = "Tool";
    w->parts[1].members = 1;
    const ect_device_t commanded = device_with_commands(w->parts[1].device);
    add_part(w, "pmctendo-dd5");
    w->parts[2].device = &commanded;
    w->parts[2].identity.serial = 0x80000001; /* written as a signed number */
    w->parts[2].up = 0;
    w->parts[2].up_port = 2;
    w->parts[2].group = "";
    w->parts[2].members = 2;
    write_parts("known", w);
}

/* The file is checked in; `test_eni_write --write` replaces it, for a review of the difference. */
static void CF_N01_a_known_bus_has_the_file_of_the_tests_byte_for_byte(void **state)
{
    char *known = NULL;
    size_t room = 0;
    unsigned int number = 0;
    written_t w;
    (void)state;
    write_known(&w);
    FILE *file = fopen(ENI_FILES "/written.xml", "re");
    assert_non_null(file);
    const char *at = w.file;
    for (ssize_t length; (length = getline(&known, &room, file)) > 0; at += length) {
        number++;
        if (strncmp(at, known, (size_t)length) != 0)
            fail_msg("written.xml:%u: expected %s  got %.*s", number, known, (int)strcspn(at, "\n"), at);
    }
    assert_string_equal(at, "");
    assert_true(number > 100);
    (void)fclose(file);
    free(known);
    drop(&w);
}

/* A bit for each mailbox whose slave has a free FMMU: one command reads those of a bus, also of a single slave. */
static void ENI_020_the_states_of_mailboxes_are_read_with_one_command(void **state)
{
    static const char command[] = "<Comment>states of the mailboxes</Comment>";
    (void)state;
    for (size_t i = 0; i < sizeof buses / sizeof buses[0]; i++) {
        written_t w;
        bool any = false;
        write_devices(buses[i].title, buses[i].devices, &w);
        for (size_t k = 0; k < w.count; k++)
            any = any || slave_of(w.eni, k)->mailbox.status_bit.given;
        const char *first = strstr(w.file, command);
        if ((first != NULL) != any || (first != NULL && strstr(first + 1, command) != NULL))
            fail_msg("%s: mailboxes with a bit: %d, commands: %s", buses[i].title, any,
                     first == NULL ? "none" : "one or more");
        drop(&w);
    }
}

static void ENI_010_ENI_021_place_and_alias_of_a_slave_come_back(void **state)
{
    written_t w = {.count = 0};
    ect_eni_place_t place;
    char why[400] = "";
    (void)state;
    for (unsigned int i = 0; i < 4; i++)
        add_part(&w, "fzm1");
    w.parts[1].alias = 17;
    w.parts[3].up = 1;
    w.parts[3].up_port = 2;
    write_parts("a tree", &w);
    assert_int_equal(ect_eni_alias(slave_of(w.eni, 0)), 0);
    assert_int_equal(ect_eni_alias(slave_of(w.eni, 1)), 17);
    assert_true(ect_eni_place(w.eni, 2, &place, why, sizeof why));
    assert_int_equal(place.up, 1);
    assert_int_equal(place.port, 1);
    assert_true(ect_eni_place(w.eni, 3, &place, why, sizeof why));
    assert_int_equal(place.up, 1);
    assert_int_equal(place.port, 2);
    drop(&w);
}

static void ENI_017_the_image_holds_every_command_and_its_variables_do_not_overlap(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof buses / sizeof buses[0]; i++) {
        written_t w;
        write_devices(buses[i].title, buses[i].devices, &w);
        const ect_eni_network_t *network = ect_eni_network(w.eni);
        for (size_t k = 0; k < network->cyclics[0].frame_count; k++) {
            const ect_eni_frame_t *frame = &network->cyclics[0].frames[k];
            for (size_t n = 0; n < frame->command_count; n++) {
                const ect_eni_command_t *command = &frame->commands[n];
                const ect_eni_image_t *image = command->command == 11 ? &network->outputs : &network->inputs;
                const uint32_t offset = command->command == 11 ? command->output_offset : command->input_offset;
                assert_true(offset + command->data.length <= image->bytes);
            }
        }
        const ect_eni_image_t *images[] = {&network->inputs, &network->outputs};
        for (size_t k = 0; k < 2; k++) {
            uint32_t end = 0;
            for (size_t n = 0; n < images[k]->variable_count; n++) {
                assert_true(images[k]->variables[n].offset >= end);
                end = images[k]->variables[n].offset + images[k]->variables[n].bits;
            }
            assert_true(end <= images[k]->bytes * 8);
        }
        drop(&w);
    }
}

static const ect_eni_command_t *command_at(const ect_eni_slave_t *slave, unsigned int transition, uint16_t ado)
{
    for (size_t i = 0; i < slave->command_count; i++) {
        if ((slave->commands[i].transitions & transition) != 0 && slave->commands[i].ado == ado)
            return &slave->commands[i];
    }
    return NULL;
}

/* The second SyncManager begins with a byte of its own. */
static void ENI_017_variables_of_two_SyncManagers_follow_each_other(void **state)
{
#define TX_PDO(index, sm, entry, bits, type)                                                                           \
    "<TxPdo Sm='" sm "'><Index>" index "</Index><Name>P</Name><Entry><Index>" entry "</Index><SubIndex>1</SubIndex>"   \
    "<BitLen>" bits "</BitLen><Name>E</Name><DataType>" type "</DataType></Entry></TxPdo>"
    static const char text[] =
        ESI_DEVICE("<Sm StartAddress='#x1000' ControlByte='#x20' Enable='1'>Inputs</Sm>"
                   "<Sm StartAddress='#x1100' ControlByte='#x20' Enable='1'>Inputs</Sm>" TX_PDO("#x1A00", "0", "#x6000",
                                                                                                "3", "BIT3")
                       TX_PDO("#x1A01", "1", "#x6010", "16", "UINT") TX_PDO("#x1A02", "1", "#x6020", "8", "USINT"));
    static const struct {
        uint32_t offset, bits;
    } rows[] = {{0, 3}, {8, 16}, {24, 8}, {32, 3}, {40, 16}, {56, 8}};
    written_t w = {.count = 2};
    (void)state;
    made_t made = make_text("two SyncManagers", text);
    const ect_device_t *device = ect_esi_twin_product(made.twin)->device;
    w.parts[0] = w.parts[1] = (ect_eni_part_t){.device = device, .identity = device->identity};
    write_parts("two SyncManagers", &w);
    const ect_eni_image_t *inputs = &ect_eni_network(w.eni)->inputs;
    assert_int_equal(inputs->variable_count, sizeof rows / sizeof rows[0]);
    for (size_t i = 0; i < inputs->variable_count; i++) {
        assert_int_equal(inputs->variables[i].offset, rows[i].offset);
        assert_int_equal(inputs->variables[i].bits, rows[i].bits);
    }
    for (unsigned int n = 0; n < 2; n++) {
        const ect_eni_command_t *fmmu = command_at(slave_of(w.eni, 1), ECT_ENI_PS, (uint16_t)(ECT_REG_FMMU + 16 * n));
        assert_non_null(fmmu);
        assert_int_equal(ect_load_le32(fmmu->data.bytes), 0x01000004 + n);
        assert_int_equal(ect_load_le16(fmmu->data.bytes + 8), 0x1000 + 0x100 * n);
    }
    drop(&w);
    free_made(&made);
}

static void a_slave_has_a_mailbox_with_a_protocol_and_two_SyncManagers(void **state)
{
#define SMS_AND(rest)                                                                                                  \
    ESI_DEVICE("<Sm StartAddress='#x1000' ControlByte='#x20' Enable='1'>Inputs</Sm>"                                   \
               "<Sm StartAddress='#x1100' ControlByte='#x20' Enable='1'>Inputs</Sm>" rest)
    static const struct {
        const char *what, *text;
        bool given, aoe, coe;
    } rows[] = {
        {"no protocol", SMS_AND(""), false, false, false},
        {"AoE", ESI_DEVICE(ESI_MAILBOX_SMS "<Mailbox><AoE/></Mailbox>"), true, true, false},
        {"CoE", ESI_DEVICE(ESI_MAILBOX_SMS "<Mailbox><CoE/></Mailbox>"), true, false, true},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        made_t made = make_text(rows[i].what, rows[i].text);
        const ect_device_t *device = ect_esi_twin_product(made.twin)->device;
        written_t w = {.count = 1};
        w.parts[0] = (ect_eni_part_t){.device = device, .identity = device->identity};
        write_parts(rows[i].what, &w);
        const ect_eni_mailbox_t *mailbox = &slave_of(w.eni, 0)->mailbox;
        if (mailbox->given != rows[i].given || mailbox->aoe != rows[i].aoe || mailbox->coe != rows[i].coe)
            fail_msg("%s: expected a mailbox %d, AoE %d, CoE %d, got %d, %d, %d", rows[i].what, rows[i].given,
                     rows[i].aoe, rows[i].coe, mailbox->given, mailbox->aoe, mailbox->coe);
        if (rows[i].given) {
            assert_int_equal(mailbox->send.start, 0x1000);
            assert_int_equal(mailbox->receive.start, 0x1080);
            assert_int_equal(mailbox->receive.length, 128);
        }
        drop(&w);
        free_made(&made);
    }
}

static void CF_N02_a_file_with_clocks_brings_its_devices_to_OP(void **state)
{
    static const char devices[] = "fzm1,pmctendo-dd5,optoncdt2300";
    written_t w;
    (void)state;
    write_devices("clocks", devices, &w);
    for (size_t i = 0; i < w.count; i++)
        w.parts[i].clock = clock_of(w.parts[i].device);
    assert_non_null(w.parts[0].clock);
    ect_eni_close(w.eni);
    write_parts("clocks", &w);
    play("clocks", &w, devices);
    drop(&w);
}

/* Values of one mode for a cycle of 2 ms. */
static void ENI_019_clocks_start_with_the_cycles_of_their_mode(void **state)
{
    static const struct {
        const char *title;
        ect_dc_mode_t mode;
        uint32_t sync0_ns, sync1_ns;
    } rows[] = {
        {"ENI-019: SYNC0 once a cycle", {.assign_activate = 0x0300}, 2000000, 0},
        {"ENI-019: a fixed cycle", {.assign_activate = 0x0300, .cycle_sync0_ns = 500000}, 500000, 0},
        {"ENI-019: every third cycle", {.assign_activate = 0x0300, .factor_sync0 = 3}, 6000000, 0},
        {"ENI-019: four in a cycle", {.assign_activate = 0x0300, .factor_sync0 = -4}, 500000, 0},
        {"ENI-019: SYNC1 with each SYNC0",
         {.assign_activate = 0x0700, .factor_sync1 = 1, .shift_sync1_ns = 1000},
         2000000,
         1000},
        {"ENI-019: SYNC1 with every second SYNC0",
         {.assign_activate = 0x0700, .factor_sync1 = 2, .shift_sync0_ns = -5, .shift_sync1_ns = 7},
         2000000,
         2000007},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        written_t w = {.count = 0};
        add_part(&w, "fzm1");
        add_part(&w, "fzm1");
        w.parts[1].clock = &rows[i].mode;
        write_parts(rows[i].title, &w);
        const ect_eni_slave_t *slave = slave_of(w.eni, 1);
        const ect_eni_command_t *cycles = command_at(slave, ECT_ENI_PS, 0x09A0);
        const ect_eni_command_t *start = command_at(slave, ECT_ENI_PS, 0x0990);
        const ect_eni_command_t *units = command_at(slave, ECT_ENI_PS, 0x0980);
        assert_false(slave_of(w.eni, 0)->clocked);
        assert_null(command_at(slave_of(w.eni, 0), ECT_ENI_PS, 0x0980));
        assert_true(slave->clocked && slave->cycle0_ns == rows[i].sync0_ns && slave->cycle1_ns == rows[i].sync1_ns &&
                    slave->shift_ns == rows[i].mode.shift_sync0_ns);
        assert_true(cycles != NULL && start != NULL && units != NULL && cycles < start && start < units);
        assert_int_equal(ect_load_le32(cycles->data.bytes), rows[i].sync0_ns);
        assert_int_equal(ect_load_le32(cycles->data.bytes + 4), rows[i].sync1_ns);
        assert_int_equal((int64_t)ect_load_le64(start->data.bytes), rows[i].mode.shift_sync0_ns);
        assert_int_equal(ect_load_le16(units->data.bytes), rows[i].mode.assign_activate);
        assert_non_null(command_at(slave, ECT_ENI_IP, 0x0980));
        assert_non_null(command_at(slave, ECT_ENI_OP, 0x0980));
        const ect_eni_command_t *first = &ect_eni_network(w.eni)->cyclics[0].frames[0].commands[0];
        assert_int_equal(first->command, 14); /* FRMW of the system time of slave 2 */
        assert_int_equal(first->adp, 1002);
        assert_int_equal(first->ado, 0x0910);
        assert_int_equal(first->counter, -1);
        drop(&w);
    }
}

/* A drive takes the cycle of the bus in 60C2h, 1 to 255 times a power of ten of a second. */
static void ENI_019_commands_that_a_tool_adapts_have_the_cycle_of_the_bus(void **state)
{
    static const struct {
        uint32_t cycle_us;
        const char *data[2]; /* of 60C2h:1 and :2, first and second byte of the text */
    } rows[] = {{1000, {"01", "fd"}}, {2000, {"02", "fd"}}, {250, {"19", "fb"}},    {10000, {"0a", "fd"}},
                {125, {"7d", "fa"}},  {62, {"3e", "fa"}},   {500000, {"32", "fe"}}, {1001, {"01", "fd"}}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char why[400] = "", want[2][64];
        written_t w = {.count = 0};
        add_part(&w, "pmctendo-dd5");
        w.file = ect_eni_write(&w.arena, w.parts, w.count, rows[i].cycle_us, &w.length, why, sizeof why);
        assert_non_null(w.file);
        for (unsigned int n = 0; n < 2; n++) {
            (void)snprintf(want[n], sizeof want[n], "<SubIndex>%u</SubIndex>", n + 1);
            const char *at = strstr(strstr(w.file, "<Index>24770</Index>"), want[n]);
            at = at != NULL ? strstr(at, "<Data>") : NULL;
            if (at == NULL || strncasecmp(at + 6, rows[i].data[n], 2) != 0)
                fail_msg("60C2h:%u at %u us: expected %s, got %.20s", n + 1, (unsigned int)rows[i].cycle_us,
                         rows[i].data[n], at != NULL ? at : "none");
        }
        drop(&w);
    }
}

static void ENI_019_cycle_times_of_synchronisation_have_the_cycle_of_the_clock(void **state)
{
    static const uint8_t nothing[4] = {0};
    static const ect_init_command_t commands[] = {
        {.transitions = "PS", .index = 0x1C32, .subindex = 2, .adapts = true, .size = 4, .data = nothing},
        {.transitions = "PS", .index = 0x1C33, .subindex = 2, .size = 4, .data = nothing}};
    static const ect_dc_mode_t twice = {.assign_activate = 0x0300, .factor_sync0 = 2};
    written_t w = {.count = 0};
    (void)state;
    add_part(&w, "pmctendo-dd5");
    ect_device_t device = *w.parts[0].device;
    device.init_commands = commands;
    device.init_command_count = 2;
    w.parts[0].device = &device;
    w.parts[0].clock = &twice;
    write_parts("cycle times", &w);
    assert_non_null(strstr(w.file, "<Data>00093D00</Data>")); /* 4 ms */
    assert_non_null(strstr(w.file, "<Data>00000000</Data>")); /* 1C33h:2 is not one that a tool adapts */
    drop(&w);
}

/* The cycle of the bus is 2 ms. */
static void ENI_019_no_other_command_is_adapted(void **state)
{
    enum { COMMANDS = 17 };
    static const uint8_t own[] = {0x11, 0x22, 0x33, 0x44}, cycle[] = {0x80, 0x84, 0x1E, 0x00}, two[] = {2},
                         milliseconds[] = {0xFD};
    static const struct {
        uint16_t index;
        uint8_t subindex, size;
        bool adapts, complete;
        const uint8_t *want;
    } rows[COMMANDS] = {
        {0x1C32, 2, 4, true, false, cycle},        {0x1C33, 2, 4, true, false, cycle}, {0x1C32, 1, 4, true, false, own},
        {0x1C31, 2, 4, true, false, own},          {0x1C34, 2, 4, true, false, own},   {0x1C32, 2, 2, true, false, own},
        {0x1C32, 2, 4, true, true, own},           {0x1C32, 2, 4, false, false, own},  {0x60C2, 1, 1, true, false, two},
        {0x60C2, 2, 1, true, false, milliseconds}, {0x60C2, 0, 1, true, false, own},   {0x60C2, 3, 1, true, false, own},
        {0x60C2, 1, 2, true, false, own},          {0x68C2, 1, 1, true, false, two},   {0x60C3, 1, 1, true, false, own},
        {0x98C2, 2, 1, true, false, milliseconds}, {0xA0C2, 1, 1, true, false, own},
    };
    ect_init_command_t commands[COMMANDS];
    written_t w = {.count = 0};
    (void)state;
    for (size_t i = 0; i < COMMANDS; i++)
        commands[i] = (ect_init_command_t){.transitions = "PS",
                                           .index = rows[i].index,
                                           .subindex = rows[i].subindex,
                                           .size = rows[i].size,
                                           .adapts = rows[i].adapts,
                                           .complete = rows[i].complete,
                                           .data = own};
    add_part(&w, "pmctendo-dd5");
    ect_device_t device = *w.parts[0].device;
    device.init_commands = commands;
    device.init_command_count = COMMANDS;
    w.parts[0].device = &device;
    write_parts("adapted", &w);
    const ect_eni_mailbox_t *mailbox = &slave_of(w.eni, 0)->mailbox;
    assert_int_equal(mailbox->command_count, COMMANDS);
    for (size_t i = 0; i < COMMANDS; i++) {
        const ect_esi_bytes_t *data = &mailbox->commands[i].data;
        if (data->length != rows[i].size || memcmp(data->bytes, rows[i].want, rows[i].size) != 0)
            fail_msg("%04X:%u: got %zu bytes, %02X...", rows[i].index, rows[i].subindex, data->length, data->bytes[0]);
    }
    drop(&w);
}

static void ENI_020_mailboxes_have_a_bit_each(void **state)
{
    ect_device_t plain;
    written_t w = {.count = 0};
    (void)state;
    for (unsigned int i = 0; i < 3; i++)
        add_part(&w, "fzm1");
    plain = *w.parts[1].device;
    plain.esc = "none"; /* a chip without a known free FMMU */
    w.parts[1].device = &plain;
    write_parts("states", &w);
    const ect_eni_network_t *network = ect_eni_network(w.eni);
    assert_int_equal(network->status_start.value, 0x09000000);
    assert_int_equal(network->status_count, 2);
    assert_int_equal(slave_of(w.eni, 0)->mailbox.status_bit.value, 0);
    assert_false(slave_of(w.eni, 1)->mailbox.status_bit.given);
    assert_int_equal(slave_of(w.eni, 2)->mailbox.status_bit.value, 1);
    const uint8_t fmmu[16] = {0, 0, 0, 9, 1, 0, 1, 1, 0x0D, 0x08, 0, 1, 1};
    const ect_eni_command_t *command = command_at(slave_of(w.eni, 2), ECT_ENI_IP, 0x0620);
    assert_non_null(command);
    assert_memory_equal(command->data.bytes, fmmu, sizeof fmmu);
    command = &network->cyclics[0].frames[0].commands[1];
    assert_int_equal(command->command, 10);
    assert_int_equal(command->address, 0x09000000);
    assert_int_equal(command->data.length, 1);
    assert_int_equal(command->counter, 2);
    assert_int_equal(command->states, ECT_ENI_PREOP | ECT_ENI_SAFEOP | ECT_ENI_OPERATIONAL);
    drop(&w);
}

/* The bits of the ninth and the tenth slave lie in the second byte. */
static void ENI_020_more_than_eight_mailboxes_have_bits_in_several_bytes(void **state)
{
    enum { COUNT = 10 };
    written_t w = {.count = 0};
    (void)state;
    for (unsigned int i = 0; i < COUNT; i++)
        add_part(&w, "fzm1");
    write_parts("states", &w);
    const ect_eni_network_t *network = ect_eni_network(w.eni);
    assert_int_equal(network->status_count, COUNT);
    for (unsigned int i = 0; i < COUNT; i++) {
        const uint8_t bit = i % 8;
        const uint8_t fmmu[16] = {(uint8_t)(i / 8), 0, 0, 9, 1, 0, bit, bit, 0x0D, 0x08, 0, 1, 1};
        const ect_eni_command_t *command = command_at(slave_of(w.eni, i), ECT_ENI_IP, 0x0620);
        assert_non_null(command);
        assert_memory_equal(command->data.bytes, fmmu, sizeof fmmu);
        assert_int_equal(slave_of(w.eni, i)->mailbox.status_bit.value, i);
    }
    assert_int_equal(network->cyclics[0].frames[0].commands[1].data.length, 2);
    drop(&w);
}

static void ENI_020_the_FMMU_of_a_mailbox_is_behind_those_of_virtual_SyncManagers(void **state)
{
    static const struct {
        const char *esc;
        bool given;
    } rows[] = {{"et1100", true}, {"et1200", false}}; /* 8 and 3 FMMUs */
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_device_t device = *ect_catalogue_find("fzm1")->device;
        written_t w = {.count = 0};
        device.esc = rows[i].esc;
        device.sm_count = 5;
        device.sm[4] = (ect_sm_t){.start = 0x0990, .length = 8, .flags = ECT_SM_FLAG_VIRTUAL, .role = ECT_SM_INPUTS};
        add_part(&w, "fzm1");
        w.parts[0].device = &device;
        write_parts(rows[i].esc, &w);
        const ect_eni_slave_t *slave = slave_of(w.eni, 0);
        for (unsigned int n = 0; n < 3; n++) {
            const ect_eni_command_t *fmmu = command_at(slave, ECT_ENI_PS, (uint16_t)(ECT_REG_FMMU + 16 * n));
            assert_non_null(fmmu);
            assert_int_equal(ect_load_le16(fmmu->data.bytes + 8), n == 2 ? 0x0990 : device.sm[2 + n].start);
            assert_null(command_at(slave, ECT_ENI_IP, fmmu->ado));
        }
        const ect_eni_command_t *state_bit = command_at(slave, ECT_ENI_IP, ECT_REG_FMMU + 16 * 3);
        assert_int_equal(slave->mailbox.status_bit.given, rows[i].given);
        assert_int_equal(state_bit != NULL, rows[i].given);
        if (rows[i].given)
            assert_int_equal(ect_load_le16(state_bit->data.bytes + 8), 0x080D);
        drop(&w);
    }
}

/* A device with process data of any length: those of virtual SyncManagers. */
static ect_device_t sized_device(bool mailbox, uint16_t outputs, uint16_t inputs)
{
    ect_device_t device = *ect_catalogue_find("fzm1")->device;
    const unsigned int first = mailbox ? 2 : 0;
    device.mailbox_protocols = mailbox ? device.mailbox_protocols : 0;
    device.init_command_count = 0;
    device.sm_count = (uint8_t)(first + 2);
    device.sm[first] = (ect_sm_t){.length = outputs, .flags = ECT_SM_FLAG_VIRTUAL, .role = ECT_SM_OUTPUTS};
    device.sm[first + 1] = (ect_sm_t){.length = inputs, .flags = ECT_SM_FLAG_VIRTUAL, .role = ECT_SM_INPUTS};
    return device;
}

/* The cyclic frames as text: each command has a name, an address, its bytes, its working counter and its place in the
 * process image. A bar ends a frame. */
static const char *frames_of(const ect_eni_t *eni)
{
    static char text[1000];
    static const char *const names[] = {[7] = "BRD", [10] = "LRD", [11] = "LWR", [14] = "FRMW"};
    const ect_eni_cyclic_t *cyclic = ect_eni_network(eni)->cyclics;
    size_t used = 0;
    for (size_t i = 0; i < cyclic->frame_count; i++) {
        const ect_eni_frame_t *frame = &cyclic->frames[i];
        for (size_t n = 0; n < frame->command_count; n++) {
            const ect_eni_command_t *c = &frame->commands[n];
            used +=
                (size_t)snprintf(text + used, sizeof text - used, "%s%s %X %zu x%d @%u", n > 0 ? ", " : "",
                                 names[c->command], c->address != 0 ? (unsigned int)c->address : c->ado, c->data.length,
                                 c->counter, (unsigned int)(c->command == 11 ? c->output_offset : c->input_offset));
            assert_int_equal(c->command == 11 ? c->input_offset : c->output_offset, 0);
        }
        used += (size_t)snprintf(text + used, sizeof text - used, "|");
    }
    return text;
}

/* A frame has up to 1498 bytes of datagrams, a datagram up to 1486 bytes of data; the headers take 12 each. */
static void ENI_016_ENI_017_commands_fill_datagrams_and_frames_between_slaves(void **state)
{
    enum { MOST = 3 };
    static const struct {
        const char *title;
        bool mailbox, clock;
        uint16_t bytes[MOST][2]; /* outputs and inputs of each slave; none: the end */
        uint32_t inputs;         /* bytes of the process image */
        const char *frames;
    } rows[] = {
        {"a full frame",
         false,
         false,
         {{730, 730}},
         732,
         "BRD 130 2 x1 @730, LWR 10000 730 x1 @0, LRD 1000000 730 x1 @0|"},
        {"a byte more",
         false,
         false,
         {{730, 731}},
         733,
         "BRD 130 2 x1 @731, LWR 10000 730 x1 @0|LRD 1000000 731 x1 @0|"},
        {"a full frame with a clock",
         false,
         true,
         {{722, 722}},
         728,
         "FRMW 910 4 x-1 @724, BRD 130 2 x1 @722, LWR 10000 722 x1 @0, LRD 1000000 722 x1 @0|"},
        {"a byte more with a clock",
         false,
         true,
         {{723, 722}},
         728,
         "FRMW 910 4 x-1 @724, BRD 130 2 x1 @722, LWR 10000 723 x1 @0|LRD 1000000 722 x1 @0|"},
        {"a full frame with a mailbox",
         true,
         false,
         {{723, 724}},
         727,
         "BRD 130 2 x1 @724, LRD 9000000 1 x1 @726, LWR 10000 723 x1 @0, LRD 1000000 724 x1 @0|"},
        {"a byte more with a mailbox",
         true,
         false,
         {{724, 724}},
         727,
         "BRD 130 2 x1 @724, LRD 9000000 1 x1 @726, LWR 10000 724 x1 @0|LRD 1000000 724 x1 @0|"},
        {"mailboxes and clocks",
         true,
         true,
         {{1, 2}, {3, 4}},
         13,
         "FRMW 910 4 x-1 @9, BRD 130 2 x2 @6, LRD 9000000 1 x2 @8, LWR 10000 4 x2 @0, LRD 1000000 6 x2 @0|"},
        {"a full datagram", false, false, {{0, 743}, {0, 743}}, 1488, "BRD 130 2 x2 @1486|LRD 1000000 1486 x2 @0|"},
        {"two datagrams",
         false,
         false,
         {{0, 743}, {0, 744}},
         1489,
         "BRD 130 2 x2 @1487, LRD 1000000 743 x1 @0|LRD 10002E7 744 x1 @743|"},
        {"a second frame that is full",
         false,
         false,
         {{1000, 0}, {737, 737}},
         739,
         "BRD 130 2 x2 @737, LWR 10000 1000 x1 @0|LWR 103E8 737 x1 @1000, LRD 1000000 737 x1 @0|"},
        {"a second frame and a third",
         false,
         false,
         {{1000, 0}, {737, 0}, {0, 738}},
         740,
         "BRD 130 2 x3 @738, LWR 10000 1000 x1 @0|LWR 103E8 737 x1 @1000|LRD 1000000 738 x1 @0|"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_device_t devices[MOST];
        uint32_t outputs = 0;
        written_t w = {.count = 0};
        for (size_t n = 0; n < MOST && rows[i].bytes[n][0] + rows[i].bytes[n][1] > 0; n++) {
            devices[n] = sized_device(rows[i].mailbox, rows[i].bytes[n][0], rows[i].bytes[n][1]);
            add_part(&w, "fzm1");
            w.parts[n].device = &devices[n];
            w.parts[n].clock = rows[i].clock ? clock_of(&devices[n]) : NULL;
            outputs += rows[i].bytes[n][0];
        }
        write_parts(rows[i].title, &w);
        if (strcmp(frames_of(w.eni), rows[i].frames) != 0)
            fail_msg("%s: expected %s\n  got      %s", rows[i].title, rows[i].frames, frames_of(w.eni));
        assert_int_equal(ect_eni_network(w.eni)->inputs.bytes, rows[i].inputs);
        assert_int_equal(ect_eni_network(w.eni)->outputs.bytes, outputs);
        drop(&w);
    }
}

static void an_unknown_role_of_a_SyncManager_has_no_type(void **state)
{
    static const struct {
        uint8_t role;
        const char *type; /* NULL: no element */
    } rows[] = {{0, NULL}, {1, "MBoxOut"}, {2, "MBoxIn"}, {3, "Outputs"}, {4, "Inputs"}, {5, ""}, {255, ""}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_device_t device = *ect_catalogue_find("fzm1")->device;
        written_t w = {.count = 0};
        device.sm_count = 5;
        device.sm[4] = (ect_sm_t){.flags = ECT_SM_FLAG_VIRTUAL, .role = rows[i].role};
        add_part(&w, "fzm1");
        w.parts[0].device = &device;
        write_parts("roles", &w);
        const ect_eni_sm_t *sm = &slave_of(w.eni, 0)->sms[4];
        assert_int_equal(sm->given, rows[i].type != NULL);
        if (rows[i].type != NULL)
            assert_string_equal(sm->type, rows[i].type);
        drop(&w);
    }
}

static void ENI_007_a_disabled_command_stays_disabled(void **state)
{
    char why[400] = "";
    ect_device_t device;
    ect_init_command_t commands[2];
    written_t w = {.count = 0};
    (void)state;
    add_part(&w, "pmctendo-dd5");
    device = *w.parts[0].device;
    assert_true(device.init_command_count >= 2);
    memcpy(commands, device.init_commands, sizeof commands);
    commands[1].disabled = true;
    device.init_commands = commands;
    device.init_command_count = 2;
    w.parts[0].device = &device;
    write_parts("disabled", &w);
    const ect_eni_mailbox_t *mailbox = &slave_of(w.eni, 0)->mailbox;
    assert_int_equal(mailbox->command_count, 2);
    assert_false(mailbox->commands[0].disabled);
    assert_true(mailbox->commands[1].disabled);
    ect_esi_t *esi = ect_eni_device(w.eni, 0, why, sizeof why);
    ect_esi_twin_t *twin = ect_esi_twin_take(esi, "", NULL, 0, why, sizeof why);
    assert_non_null(twin);
    const ect_device_t *made = ect_esi_twin_product(twin)->device;
    assert_int_equal(made->init_command_count, 2);
    assert_false(made->init_commands[0].disabled);
    assert_true(made->init_commands[1].disabled);
    ect_esi_twin_free(twin);
    drop(&w);
}

static void ENI_025_mails_of_AoE_EoE_SoE_and_FoE_come_back(void **state)
{
    char why[400] = "";
    written_t w = {.count = 0};
    (void)state;
    add_part(&w, "pmctendo-dd5");
    ect_device_t device = *w.parts[0].device;
    device.mailbox_protocols |= ECT_MAILBOX_AOE | ECT_MAILBOX_EOE | ECT_MAILBOX_SOE | ECT_MAILBOX_FOE;
    device.init_mails = mails;
    device.init_mail_count = MAILS;
    w.parts[0].device = &device;
    write_parts("mails", &w);
    assert_int_equal(slave_of(w.eni, 0)->mailbox.mail_count, MAILS);
    assert_int_equal(slave_of(w.eni, 0)->mailbox.others, 2); /* FoE is not sent */
    ect_esi_t *esi = ect_eni_device(w.eni, 0, why, sizeof why);
    ect_esi_twin_t *twin = ect_esi_twin_take(esi, "", NULL, 0, why, sizeof why);
    assert_non_null(twin);
    const ect_device_t *made = ect_esi_twin_product(twin)->device;
    assert_int_equal(made->soe_channels, 2);
    assert_int_equal(made->init_mail_count, MAILS);
    for (size_t i = 0; i < MAILS; i++) {
        const ect_init_mail_t *to = &made->init_mails[i], *from = &mails[i];
        if (to->protocol != from->protocol || to->type != from->type || to->drive != from->drive ||
            to->elements != from->elements || to->idn != from->idn || to->disabled != from->disabled ||
            to->size != from->size)
            fail_msg("mail %zu: protocol %u, type %u, IDN 0x%04X, %u bytes", i, to->protocol, to->type, to->idn,
                     to->size);
        assert_string_equal(to->transitions, from->transitions);
        assert_int_equal(to->comment != NULL, from->comment != NULL);
        if (from->size > 0)
            assert_memory_equal(to->data, from->data, from->size);
    }
    ect_esi_twin_free(twin);
    drop(&w);
}

/* Behind its header an FoE request has a name that ends within the mail. */
static void ENI_025_a_mail_of_FoE_without_a_name_has_no_operation(void **state)
{
    static const uint8_t request[] = {1, 0, 0, 0, 0, 0, 'a', 0, 7};
    static const struct {
        uint16_t size;
        const char *text; /* NULL: no operation */
    } rows[] = {{0, NULL},
                {5, NULL},
                {6, NULL},
                {7, NULL},
                {8, "<OpCode>1</OpCode><FileName>a</FileName></InitCmd>"},
                {9, "<OpCode>1</OpCode><FileName>a</FileName><Data>07</Data></InitCmd>"}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const ect_init_mail_t mail = {
            .transitions = "PS", .protocol = ECT_MAILBOX_TYPE_FOE, .type = 1, .size = rows[i].size, .data = request};
        written_t w = {.count = 0};
        char command[200] = "";
        add_part(&w, "pmctendo-dd5");
        ect_device_t device = *w.parts[0].device;
        device.init_mails = &mail;
        device.init_mail_count = 1;
        w.parts[0].device = &device;
        write_parts("FoE", &w);
        const char *at = strstr(strstr(w.file, "<FoE>"), "<Timeout>2000</Timeout>") + strlen("<Timeout>2000</Timeout>");
        for (const char *end = strstr(at, "</InitCmd>") + strlen("</InitCmd>"); at < end; at++) {
            if (*at != ' ' && *at != '\n')
                strncat(command, at, 1);
        }
        assert_string_equal(command, rows[i].text != NULL ? rows[i].text : "</InitCmd>");
        drop(&w);
    }
}

/* Commands of an ESI file, by way of its twin. */
static void ENI_025_commands_of_an_ESI_file_are_those_of_the_written_file(void **state)
{
    char why[400] = "";
    written_t w = {.count = 0};
    (void)state;
    ect_esi_t *file = ect_esi_open(ESI_FILES "/soe.xml", why, sizeof why);
    ect_esi_twin_t *twin = ect_esi_twin_take(file, "TWO", NULL, 0, why, sizeof why);
    if (twin == NULL)
        fail_msg("%s", why);
    const ect_device_t *device = ect_esi_twin_product(twin)->device;
    w.parts[w.count++] = (ect_eni_part_t){.device = device, .identity = device->identity};
    write_parts("drives", &w);
    const ect_eni_mailbox_t *mailbox = &slave_of(w.eni, 0)->mailbox;
    assert_int_equal(mailbox->mail_count, 5);
    assert_int_equal(mailbox->mails[3].drive, 1);
    assert_int_equal(mailbox->mails[3].idn, 32);
    assert_int_equal(mailbox->mails[3].elements, 0x40);
    assert_int_equal(mailbox->mails[3].type, ECT_INIT_WRITES);
    assert_int_equal(mailbox->mails[4].transitions, ECT_ENI_IP);
    assert_memory_equal(mailbox->mails[4].data.bytes, "\x04\x00\x08\x00\x41\x42\x0D\x0A", 8);
    drop(&w);
    ect_esi_twin_free(twin);
}

static void ENI_006_uploads_and_transitions_come_back(void **state)
{
    char why[400] = "";
    static const uint8_t value[2] = {1, 2};
    static const ect_init_command_t commands[] = {
        {.transitions = "IP PS OS", .index = 0x1018, .subindex = 1, .upload = true},
        {.transitions = "PS", .index = 0x8000, .subindex = 1, .size = 2, .data = value}};
    written_t w = {.count = 0};
    (void)state;
    add_part(&w, "pmctendo-dd5");
    ect_device_t device = *w.parts[0].device;
    device.init_commands = commands;
    device.init_command_count = 2;
    w.parts[0].device = &device;
    write_parts("uploads", &w);
    const ect_eni_mailbox_t *mailbox = &slave_of(w.eni, 0)->mailbox;
    assert_int_equal(mailbox->command_count, 2);
    assert_false(mailbox->commands[0].download);
    assert_int_equal(mailbox->commands[0].transitions, ECT_ENI_IP | ECT_ENI_PS | ECT_ENI_OS);
    assert_true(mailbox->commands[1].download);
    ect_esi_t *esi = ect_eni_device(w.eni, 0, why, sizeof why);
    ect_esi_twin_t *twin = ect_esi_twin_take(esi, "", NULL, 0, why, sizeof why);
    assert_non_null(twin);
    const ect_device_t *made = ect_esi_twin_product(twin)->device;
    assert_int_equal(made->init_command_count, 2);
    assert_true(made->init_commands[0].upload);
    assert_string_equal(made->init_commands[0].transitions, "IP PS OS");
    assert_false(made->init_commands[1].upload);
    assert_string_equal(made->init_commands[1].transitions, "PS");
    ect_esi_twin_free(twin);
    drop(&w);
}

static void ENI_021_a_hot_connect_group_comes_back(void **state)
{
    written_t w = {.count = 0};
    (void)state;
    for (unsigned int i = 0; i < 4; i++)
        add_part(&w, "fzm1");
    w.parts[1].group = "Tool";
    w.parts[1].members = 2;
    w.parts[3].group = "";
    w.parts[3].members = 1;
    write_parts("groups", &w);
    assert_null(slave_of(w.eni, 0)->group);
    assert_string_equal(slave_of(w.eni, 1)->group, "Tool");
    assert_int_equal(slave_of(w.eni, 1)->members, 2);
    assert_null(slave_of(w.eni, 2)->group);
    assert_string_equal(slave_of(w.eni, 3)->group, "");
    assert_int_equal(slave_of(w.eni, 3)->members, 1);
    drop(&w);
}

/* Nine base units have more process data than a datagram. */
static void process_data_beyond_a_datagram_are_several_commands(void **state)
{
    written_t w = {.count = 0};
    char devices[400] = "";
    size_t commands = 0;
    (void)state;
    for (unsigned int i = 0; i < 10; i++) {
        add_part(&w, "vr-bu-ect-map7");
        (void)snprintf(devices + strlen(devices), sizeof devices - strlen(devices), "%svr-bu-ect-map7",
                       i > 0 ? "," : "");
    }
    write_parts("ten base units", &w);
    const ect_eni_cyclic_t *cyclic = ect_eni_network(w.eni)->cyclics;
    for (size_t i = 0; i < cyclic->frame_count; i++)
        commands += cyclic->frames[i].command_count;
    assert_true(commands > 3);
    play("ten base units", &w, devices);
    drop(&w);
}

static void a_file_of_no_slave_or_of_too_many_is_refused(void **state)
{
    char why[400] = "";
    ect_arena_t arena = {0};
    size_t length = 0;
    const ect_eni_part_t part = {.device = NULL};
    (void)state;
    assert_null(ect_eni_write(&arena, &part, 0, 1, &length, why, sizeof why));
    assert_string_equal(why, "a network file has 1 to 64535 slaves, not 0");
    assert_null(ect_eni_write(&arena, &part, 64536, 1, &length, why, sizeof why));
    assert_string_equal(why, "a network file has 1 to 64535 slaves, not 64536");
    ect_arena_free(&arena);
}

static int write_file(void)
{
    written_t w;
    write_known(&w);
    FILE *file = fopen(ENI_FILES "/written.xml", "we");
    const bool written = file != NULL && fwrite(w.file, 1, w.length, file) == w.length;
    const bool closed = file != NULL && fclose(file) == 0;
    drop(&w);
    return written && closed ? EXIT_SUCCESS : EXIT_FAILURE;
}

int main(int argc, char **argv)
{
    if (argc > 1 && strcmp(argv[1], "--write") == 0)
        return write_file();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(CF_N02_a_written_file_brings_its_devices_to_OP_with_every_counter_as_expected),
        cmocka_unit_test(CF_N02_a_written_file_brings_the_twins_that_it_makes_to_OP),
        cmocka_unit_test(CF_N01_a_written_file_is_read_as_the_same_bus),
        cmocka_unit_test(CF_N01_a_written_file_has_frames_checks_and_mailbox_of_the_device),
        cmocka_unit_test(each_transition_has_the_timeout_of_the_device),
        cmocka_unit_test(a_slave_has_a_mailbox_with_a_protocol_and_two_SyncManagers),
        cmocka_unit_test(ENI_013_the_sizes_of_a_SyncManager_come_back),
        cmocka_unit_test(CF_N01_a_known_bus_has_the_file_of_the_tests_byte_for_byte),
        cmocka_unit_test(ENI_020_the_states_of_mailboxes_are_read_with_one_command),
        cmocka_unit_test(ENI_010_ENI_021_place_and_alias_of_a_slave_come_back),
        cmocka_unit_test(ENI_017_the_image_holds_every_command_and_its_variables_do_not_overlap),
        cmocka_unit_test(ENI_017_variables_of_two_SyncManagers_follow_each_other),
        cmocka_unit_test(CF_N02_a_file_with_clocks_brings_its_devices_to_OP),
        cmocka_unit_test(ENI_019_clocks_start_with_the_cycles_of_their_mode),
        cmocka_unit_test(ENI_019_commands_that_a_tool_adapts_have_the_cycle_of_the_bus),
        cmocka_unit_test(ENI_019_cycle_times_of_synchronisation_have_the_cycle_of_the_clock),
        cmocka_unit_test(ENI_019_no_other_command_is_adapted),
        cmocka_unit_test(ENI_020_mailboxes_have_a_bit_each),
        cmocka_unit_test(ENI_020_more_than_eight_mailboxes_have_bits_in_several_bytes),
        cmocka_unit_test(ENI_020_the_FMMU_of_a_mailbox_is_behind_those_of_virtual_SyncManagers),
        cmocka_unit_test(ENI_016_ENI_017_commands_fill_datagrams_and_frames_between_slaves),
        cmocka_unit_test(an_unknown_role_of_a_SyncManager_has_no_type),
        cmocka_unit_test(ENI_025_mails_of_AoE_EoE_SoE_and_FoE_come_back),
        cmocka_unit_test(ENI_025_a_mail_of_FoE_without_a_name_has_no_operation),
        cmocka_unit_test(ENI_025_commands_of_an_ESI_file_are_those_of_the_written_file),
        cmocka_unit_test(ENI_006_uploads_and_transitions_come_back),
        cmocka_unit_test(ENI_007_a_disabled_command_stays_disabled),
        cmocka_unit_test(ENI_021_a_hot_connect_group_comes_back),
        cmocka_unit_test(process_data_beyond_a_datagram_are_several_commands),
        cmocka_unit_test(a_file_of_no_slave_or_of_too_many_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
