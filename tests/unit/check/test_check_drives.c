/* SPDX-License-Identifier: MIT */
/* One mistake at a time in the description of SoE drives. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "check/check.h"
#include "support/soedev.h"

enum { MOST_IDNS = 40, MOST_OBJECTS = 16, LAST = 2 /* drive */ };

/* A description that can be changed. */
typedef struct subject {
    ect_device_t device;
    ect_soe_t soe;
    ect_soe_drive_t drives[ECT_SOE_DRIVES];
    ect_soe_idn_t idns[MOST_IDNS]; /* of drive 0 */
    ect_soe_idn_t last[MOST_IDNS]; /* of the last drive */
    ect_object_t objects[MOST_OBJECTS];
    const ect_protocol_t *protocols[2];
} subject_t;

static subject_t s;

static void fresh(void)
{
    s = (subject_t){.device = soedev, .soe = soedev_soe};
    assert_true(soedev_soe.drives[0].count <= MOST_IDNS && soedev.object_count <= MOST_OBJECTS);
    assert_true(soedev_soe.drive_count == LAST + 1 && soedev_soe.drives[LAST].count <= MOST_IDNS);
    memcpy(s.drives, soedev_soe.drives, soedev_soe.drive_count * sizeof s.drives[0]);
    memcpy(s.idns, soedev_soe.drives[0].idns, soedev_soe.drives[0].count * sizeof s.idns[0]);
    memcpy(s.objects, soedev.objects, soedev.object_count * sizeof s.objects[0]);
    s.drives[0].idns = s.idns;
    memcpy(s.last, soedev_soe.drives[LAST].idns, soedev_soe.drives[LAST].count * sizeof s.last[0]);
    s.drives[LAST].idns = s.last;
    s.soe.drives = s.drives;
    s.protocols[0] = &s.soe.protocol;
    s.device.protocols = s.protocols;
    s.device.objects = s.objects;
}

static ect_soe_idn_t *at(uint16_t idn)
{
    ect_soe_idn_t *found = NULL;
    for (unsigned int i = 0; i < s.drives[0].count; i++)
        found = s.idns[i].idn == idn ? &s.idns[i] : found;
    assert_non_null(found);
    return found;
}

static ect_object_t *object(uint16_t index)
{
    ect_object_t *found = NULL;
    for (unsigned int i = 0; i < s.device.object_count; i++)
        found = s.objects[i].index == index ? &s.objects[i] : found;
    assert_non_null(found);
    return found;
}

/* Entries of a mapping object that can be changed. */
static ect_entry_t entries[SOEDEV_MAPPED + 1];

static ect_entry_t *mapping(uint16_t index)
{
    ect_object_t *o = object(index);
    memcpy(entries, o->entries, sizeof entries);
    o->entries = entries;
    return entries;
}

static void constant(ect_entry_t *entry)
{
    entry->data = NULL;
    entry->access = ECT_ACCESS_RO;
}

/* Room for so many IDNs in a list, and in the buffer for its reply. */
static void with_room(ect_soe_idn_t *list, uint16_t idns)
{
    enum { MORE = 1024 };
    list->size = (uint16_t)(2 * idns);
    list->offset = s.device.instance_size;
    s.soe.buffer = s.device.instance_size + MORE;
    s.soe.buffer_size = MORE;
    s.device.instance_size += 2 * MORE;
}

#define S(n) at(ECT_SOE_S(n))
#define P(n) at(ECT_SOE_P(n))

/* The mistake, and the start of the line behind "protocols: SoE drive 0, "; or the whole line. */
#define MISTAKES(X)                                                                                                    \
    X(none, s.soe.notifies = true, NULL)                                                                               \
    X(mailbox_24, s.device.sm[1].minimum = 24, NULL)                                                                   \
    X(mailbox_23, s.device.sm[0].minimum = 23, "sm: with SoE both mailboxes have at least 24 bytes")                   \
    X(state_in_standard, s.soe.offset = 0, "the state or the buffer of SoE is not inside")                             \
    X(state_not_aligned, s.soe.offset += 2, "the state or the buffer of SoE is not inside")                            \
    X(state_beyond, s.soe.offset = s.device.instance_size - 8, "the state or the buffer of SoE is not inside")         \
    X(buffer_beyond, s.soe.buffer = s.device.instance_size - 8, "the state or the buffer of SoE is not inside")        \
    X(buffer_short, s.soe.buffer_size = 200, "the buffer of SoE has 200 bytes, the longest reply ")                    \
    X(no_drive, s.soe.drive_count = 0, "SoE has 1 to 8 drives")                                                        \
    X(nine_drives, s.soe.drive_count = 9, "SoE has 1 to 8 drives")                                                     \
    X(no_table, s.soe.drives = NULL, "SoE has 1 to 8 drives")                                                          \
    X(channels, s.device.soe_channels = 2, "soe_channels: 2, but SoE has 3 drives")                                    \
    X(no_channels, s.device.soe_channels = 0, "soe_channels: 0, but SoE has 3 drives")                                 \
    X(no_service, s.device.services = NULL, "services: SoE needs ect_service_soe")                                     \
    X(order, S(11)->idn = 1, "S-0-0001: IDNs ascend")                                                                  \
    X(command_list, S(99)->attribute |= ECT_SOE_LIST, "S-0-0099: a command has 16 bits and memory")                    \
    X(command_32, S(99)->attribute ^= ECT_SOE_16 | ECT_SOE_32, "S-0-0099: a command has 16 bits and memory")           \
    X(command_constant, S(99)->offset = 0, "S-0-0099: a command has 16 bits and memory")                               \
    X(list_limit, P(5)->flags = ECT_SOE_MAXIMUM, "P-0-0005: a list has no limits")                                     \
    X(list_used, P(5)->used = 21, "P-0-0005: the lengths of a list")                                                   \
    X(list_size, P(7)->size = 15, "P-0-0007: the lengths of a list")                                                   \
    X(list_part, (P(7)->used = 2, P(7)->content = "ab"), "P-0-0007: the lengths of a list")                            \
    X(list_content, P(8)->content = NULL, "P-0-0008: the content of the list is missing")                              \
    X(made_number, S(17)->attribute &= ~ECT_SOE_LIST, "S-0-0017: it is a list of 16 bits")                             \
    X(made_wide, S(187)->attribute ^= ECT_SOE_16 | ECT_SOE_32, "S-0-0187: it is a list of 16 bits")                    \
    X(memory_beyond, P(5)->offset = s.device.instance_size - 20, "P-0-0005: its memory is not inside")                 \
    X(memory_in_standard, P(1)->offset = 8, "P-0-0001: its memory is not inside")                                      \
    X(memory_odd, P(5)->offset++, "P-0-0005: its memory is not inside the instance, or not aligned")                   \
    X(memory_odd_number, P(4)->offset += 2, "P-0-0004: its memory is not inside the instance, or not aligned")         \
    X(mapping_none, S(47)->mapping = 0, "S-0-0047: its mapping is no entry of its length")                             \
    X(mapping_direction, S(84)->mapping = ECT_MAP(0x7000, 4, 16), "S-0-0084: its mapping is no entry")                 \
    X(mapping_bits, S(84)->mapping = ECT_MAP(0x6000, 4, 8), "S-0-0084: its mapping is no entry")                       \
    X(mapping_part, S(84)->mapping = ECT_MAP(0x6000, 3, 16), "S-0-0084: its mapping is no entry")                      \
    X(mapping_list, P(7)->flags = ECT_SOE_IN_MDT, "P-0-0007: its mapping is no entry of its length")                   \
    X(process_text, S(24)->attribute ^= ECT_SOE_LIST, "S-0-0024: it is a list of 16 bits with memory")                 \
    X(process_constant, S(16)->offset = 0, "S-0-0016: it is a list of 16 bits with memory")                            \
    X(process_no_object, s.drives[0].at = 0x1A05, "S-0-0016: the mapping object of its process data is missing")       \
    X(process_too_long, S(16)->size = 26, "S-0-0016: the mapping object of its process data has no memory")            \
    X(process_254, with_room(S(16), 254), "S-0-0016: the mapping object of its process data has no memory")            \
    X(process_255, with_room(S(16), 255), "S-0-0016: the mapping object of its process data is missing, or constant")  \
    X(process_count, constant(mapping(0x1A00)), "S-0-0016: the mapping object of its process data is missing")         \
    X(process_element, constant(mapping(0x1600) + 9), "S-0-0024: the mapping object of its process data has no")       \
    X(process_other_count, S(16)->used = 2, "S-0-0016: the mapping object of its process data has another default")    \
    X(process_other, S(24)->content = "\x2F\0\x24", "S-0-0024: the mapping object of its process data has another")    \
    X(process_unknown, S(24)->content = "\x24\0\x30", "S-0-0024: the mapping object of its process data has another")  \
    X(process_flag, S(47)->flags = 0, "S-0-0024: the mapping object of its process data has another default")          \
    X(last_order, s.last[1].idn = s.last[0].idn, "SoE drive 2, S-0-0016: IDNs ascend")                                 \
    X(second_no_object, s.drives[1].at = 0x1A05, "SoE drive 1, S-0-0016: the mapping object of its process data is")   \
    X(without_objects, s.drives[0].at = s.drives[0].mdt = 0, NULL)                                                     \
    X(own_soe, s.soe.protocol.request = s.soe.protocol.request ? other : NULL, NULL)

static uint16_t other(const ect_protocol_t *self, ect_slave_t *slave, const uint8_t *data, uint16_t length)
{
    (void)self;
    (void)slave;
    (void)data;
    (void)length;
    return ECT_MAILBOX_ERROR_SERVICE;
}

static void expect(const char *name, const char *want)
{
    char line[200];
    const bool good = ect_device_check(&s.device, line, sizeof line);
    if (want == NULL ? !good : good)
        fail_msg("%s: %s", name, good ? "nothing is reported" : line);
    if (want && !strstr(line, want))
        fail_msg("%s: expected '%s', got '%s'", name, want, line);
}

static void mistakes(void **state)
{
    (void)state;
#define X(name, change, want)                                                                                          \
    fresh();                                                                                                           \
    change;                                                                                                            \
    expect(#name, want);
    MISTAKES(X)
#undef X
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"SoE: each mistake in the description of drives is one line", mistakes, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
