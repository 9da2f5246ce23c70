/* SPDX-License-Identifier: MIT */
/*
 * The offers of a description with their needs (check/check.h): each mistake with the right case, so that each
 * condition is both true and false.
 */
#include <stdio.h>
#include <string.h>

#include "check/check.h"
#include "seams/aoe.h"
#include "seams/eoe.h"
#include "seams/services.h"
#include "support/confdev.h"
#include "support/copy.h"
#include "support/gauge.h"
#include "support/terminal.h"
#include "support/testdev.h"
#include "support/wire.h"

#define D                 c->device
#define OBJECT(index)     copy_object(c, index)
#define ENTRY(index, sub) copy_entry(c, index, sub)
#define PLACE(offset)     ((void *)(uintptr_t)(offset))

typedef struct row {
    const char *name;
    const ect_device_t *device;
    void (*change)(copy_t *c);
    const char *want; /* a part of the line, NULL: there is no mistake */
} row_t;

/* --- tables that a row puts in the place of the device's ---------------------------------------------------------- */

static const ect_protocol_t foe = {.type = ECT_MAILBOX_TYPE_FOE, .states = ECT_IN_PREOP_AND_ABOVE};
static const ect_service_t *const sync_only[] = {&ect_service_sync, NULL};
static const ect_service_t *const config_only[] = {&ect_service_pdo_config, NULL};
static const ect_service_t *const rhythm_last[] = {&ect_service_sync, &ect_service_rhythm, NULL};
static const ect_protocol_t *const foe_last[] = {&ect_protocol_sdo, &ect_protocol_sdo_info, &foe, NULL};
static const ect_protocol_t *const without_info[] = {&ect_protocol_emergency, &ect_protocol_sdo, NULL};
static const ect_protocol_t *const nothing[] = {NULL};
#define AOE_AT(name, at)                                                                                               \
    static const ect_aoe_t aoe_##name = {.protocol = ECT_AOE_PROTOCOL, .offset = (at)};                                \
    static const ect_protocol_t *const name[] = {&ect_protocol_sdo, &ect_protocol_sdo_info, &aoe_##name.protocol, NULL}
AOE_AT(aoe_first, sizeof(ect_standard_t));
AOE_AT(aoe_in_front, sizeof(ect_standard_t) - 1);
AOE_AT(aoe_last, sizeof(testdev_t) - sizeof(ect_aoe_state_t));
AOE_AT(aoe_across_the_end, sizeof(testdev_t) - sizeof(ect_aoe_state_t) + 1);
AOE_AT(aoe_beyond, sizeof(testdev_t) + 1);
static const ect_eoe_t eoe = {.protocol = ECT_EOE_PROTOCOL};
static const ect_protocol_t *const eoe_at_the_end[] = {&ect_protocol_sdo, &ect_protocol_sdo_info, &eoe.protocol, NULL};
static const ect_protocol_t *const eoe_in_the_middle[] = {&ect_protocol_sdo, &eoe.protocol, &ect_protocol_sdo_info,
                                                          NULL};
static const ect_dc_mode_t unnamed[] = {{.name = "DC", .assign_activate = 0x300}, {.name = NULL}};
static const ect_dc_mode_t free_run[] = {{.name = "FreeRun"}};
static const uint16_t three_excludes[] = {0x1600, 0x1601, 0x1A01, 0};
static const uint16_t three_with_one_wrong[] = {0x1600, 0x1601, 0x1602, 0};

static const ect_entry_t assigns_three[] = {ECT_ENTRY_COUNT(3), ECT_ENTRY_ASSIGN(1, 0x1A00),
                                            ECT_ENTRY_ASSIGN(2, 0x1A01), ECT_ENTRY_ASSIGN(3, 0x1A01)};
static const ect_entry_t assigns_a_hole[] = {ECT_ENTRY_COUNT(3), ECT_ENTRY_ASSIGN(1, 0x1A00),
                                             ECT_ENTRY_ASSIGN(3, 0x1A01)};
/* Two elements are in use, of which the second is missing. */
static const ect_entry_t assigns_up_to_a_hole[] = {ECT_ENTRY_COUNT(2), ECT_ENTRY_ASSIGN(1, 0x1A00),
                                                   ECT_ENTRY_ASSIGN(3, 0x1A01)};

static void entries(copy_t *c, uint16_t index, const ect_entry_t *table, uint8_t last)
{
    ect_object_t *o = copy_object(c, index);
    o->entries = table;
    o->last = last;
    o->max_subindex = (uint8_t)table[last].subindex;
}

static void excludes(copy_t *c, const uint16_t *list)
{
    (void)copy_pdo(c, 0x1A00, 0, 0x1A01);
    c->pdos[c->device.pdo_count - 1].excludes = list;
}

static void cyclic(void *instance, uint8_t events, uint64_t now_ns)
{
    (void)instance;
    (void)events;
    (void)now_ns;
}

/* Every object that a master may write, from 1600h to 1C2Fh, becomes read-only but one. */
static void writable_only(copy_t *c, uint16_t index)
{
    for (uint16_t i = 0; i < c->device.object_count; i++) {
        ect_object_t *o = &c->objects[i];
        for (unsigned int k = 0; k <= o->last && o->index >= 0x1600 && o->index < 0x1C30; k++) {
            if (o->index != index)
                c->entries[i][k].access = ECT_ACCESS_RO;
        }
    }
    c->device.services = config_only;
}

/* --- the rows ----------------------------------------------------------------------------------------------------- */

/* AoE served from `list`, with a reply mailbox of at least `length` bytes. */
static void serve_aoe(copy_t *c, const ect_protocol_t *const *list, uint16_t length)
{
    D.protocols = list;
    D.mailbox_protocols |= ECT_MAILBOX_AOE;
    D.sm[1].minimum = length;
}

/* The stack's EoE, with mailboxes of at least these bytes. */
static void serve_eoe(copy_t *c, const ect_protocol_t *const *list, uint16_t out, uint16_t in)
{
    D.protocols = list;
    D.mailbox_protocols |= ECT_MAILBOX_EOE;
    D.sm[0].minimum = out;
    D.sm[1].minimum = in;
}

/* X(name, device, what is done to it, a part of the line or NULL) */
#define PROTOCOLS(X)                                                                                                   \
    X(as_they_are, testdev, (void)0, NULL)                                                                             \
    X(one_more_served_and_named, testdev, (D.protocols = foe_last, D.mailbox_protocols |= ECT_MAILBOX_FOE), NULL)      \
    X(one_more_served, testdev, D.protocols = foe_last, "it has not FoE, the list 'protocols' serves it")              \
    X(one_more_named, testdev, D.mailbox_protocols |= ECT_MAILBOX_AOE, "it has AoE, the list 'protocols' does not")    \
    X(eoe_named, testdev, D.mailbox_protocols |= ECT_MAILBOX_EOE, "it has EoE, the list")                              \
    X(aoe, testdev, serve_aoe(c, aoe_first, 62), NULL)                                                                 \
    X(aoe_at_the_end, testdev, serve_aoe(c, aoe_last, 62), NULL)                                                       \
    X(aoe_at_61, testdev, serve_aoe(c, aoe_first, 61), "sm: with AoE both mailboxes have at least 62 bytes")           \
    X(aoe_in_standard, testdev, serve_aoe(c, aoe_in_front, 62), "the state of AoE is not inside the instance")         \
    X(aoe_over_the_end, testdev, serve_aoe(c, aoe_across_the_end, 62), "the state of AoE is not inside")               \
    X(aoe_far, testdev, serve_aoe(c, aoe_beyond, 62), "the state of AoE is not inside the instance")                   \
    X(eoe, testdev, serve_eoe(c, eoe_at_the_end, 42, 42), NULL)                                                        \
    X(eoe_at_41_out, testdev, serve_eoe(c, eoe_at_the_end, 41, 42), "sm: with EoE both mailboxes have at least 42")    \
    X(eoe_at_41_in, testdev, serve_eoe(c, eoe_at_the_end, 42, 41), "sm: with EoE both mailboxes have at least 42")     \
    X(eoe_not_the_last, testdev, serve_eoe(c, eoe_in_the_middle, 42, 42), "protocols: EoE is not the last; its fra")   \
    X(soe_named, testdev, D.mailbox_protocols |= ECT_MAILBOX_SOE, "it has SoE, the list")                              \
    X(voe_named, testdev, D.mailbox_protocols |= ECT_MAILBOX_VOE, "it has VoE, the list")                              \
    X(an_empty_list, testdev, D.protocols = nothing, "it has CoE, the list 'protocols' does not serve it")             \
    X(no_list, testdev, D.protocols = NULL, "it has CoE, the list 'protocols' does not serve it")                      \
    X(protocol_of_bit_7, testdev, D.mailbox_protocols |= 0x80, "there is no protocol 80h")                             \
    X(information_neither, testdev, (D.protocols = without_info, D.coe_details &= (uint8_t)~ECT_COE_SDO_INFO), NULL)   \
    X(information_not_served, testdev, D.protocols = without_info, "ect_protocol_sdo_info and ECT_COE_SDO_INFO go")    \
    X(no_device_type, testdev, OBJECT(0x1000)->index = 0x0FFF, "a device with CoE has 1000h and 1018h")                \
    X(no_identity, testdev, OBJECT(0x1018)->index = 0x1019, "a device with CoE has 1000h and 1018h")                   \
    X(details_without_coe, terminal, D.coe_details = 0x20, "coe_details: without CoE there are none")

/* Constants, where the device has them as such. */
#define CONSTANTS(X)                                                                                                   \
    X(sm_types, testdev, D.sm[2].type = ECT_SM_INPUTS, "1C12h:1: 1600h is no PDO of that direction")                   \
    X(types_of_four, testdev, constant(c, 0x1C00, 4, 3), "1C00h:4: it has 3h, the description 4h")                     \
    X(types_of_one, testdev, constant(c, 0x1C00, 1, 0), "1C00h:1: it has 0h, the description 1h")                      \
    X(vendor, testdev, constant(c, 0x1018, 1, 0xE58), "1018h:1: it has E58h, the description E57h")                    \
    X(product, testdev, constant(c, 0x1018, 2, 1), "1018h:2: it has 1h, the description 7E57h")                        \
    X(revision, testdev, constant(c, 0x1018, 3, 0x10003), "1018h:3: it has 10003h, the description 10002h")            \
    X(serial, testdev, constant(c, 0x1018, 4, 0), "1018h:4: it has 0h, the description 2Ah")                           \
    X(vendor_as_described, testdev, constant(c, 0x1018, 1, 0xE57), NULL)                                               \
    X(serial_as_described, testdev, constant(c, 0x1018, 4, 42), NULL)

static void constant(copy_t *c, uint16_t index, uint8_t subindex, uint32_t value)
{
    ect_entry_t *e = copy_entry(c, index, subindex);
    e->data = NULL;
    e->value = value;
    e->access = ECT_ACCESS_RO;
}

#define SERVICES(X)                                                                                                    \
    X(cyclic_with_rhythm, confdev, (D.cyclic = cyclic, D.services = rhythm_last), NULL)                                \
    X(cyclic_without_rhythm, confdev, (D.cyclic = cyclic, D.services = sync_only), "cyclic: it needs ect_service_rh")  \
    X(no_services, confdev, D.services = NULL, NULL)                                                                   \
    X(cyclic_alone, confdev, (D.cyclic = cyclic, D.services = NULL), "cyclic: it needs ect_service_rhythm")            \
    X(sync_of_outputs, confdev, (D.services = sync_only, OBJECT(0x1C33)->index = 0x1C34), NULL)                        \
    X(sync_of_outputs_missing, confdev, (D.services = sync_only, OBJECT(0x1C32)->index = 0x1C31), "needs 1C32h:1 in")  \
    X(sync_of_inputs_missing, gauge, D.services = sync_only, "ect_service_sync needs 1C33h:1 in memory")               \
    X(sync_at_the_end, confdev,                                                                                        \
      (D.services = sync_only, ENTRY(0x1C32, 1)->data = PLACE(sizeof(confdev_t) - sizeof(ect_sync_data_t))), NULL)     \
    X(sync_beyond_the_end, confdev,                                                                                    \
      (D.services = sync_only, ENTRY(0x1C32, 1)->data = PLACE(sizeof(confdev_t) - sizeof(ect_sync_data_t) + 4)),       \
      "ect_service_sync, from 1C32h:1 on, are not inside the instance")                                                \
    X(sync_at_the_beginning, confdev,                                                                                  \
      (D.services = sync_only, ENTRY(0x1C32, 1)->data = PLACE(sizeof(ect_standard_t))), NULL)                          \
    X(sync_without_memory, confdev,                                                                                    \
      (D.services = sync_only, ENTRY(0x1C32, 1)->data = NULL, ENTRY(0x1C32, 1)->access = ECT_ACCESS_RO),               \
      "ect_service_sync needs 1C32h:1 in memory")                                                                      \
    X(messages_too_few, confdev, (OBJECT(0x10F3)->max_subindex--, OBJECT(0x10F3)->last--, ENTRY(0x10F3, 0)->value--),  \
      "10F3h: it has 8 messages")                                                                                      \
    X(store_read_only, confdev, ENTRY(0x1010, 1)->access = ECT_ACCESS_RO, "ect_service_store needs 1010h:1 that can")  \
    X(configuration_of_a_mapping, confdev, writable_only(c, 0x1600), NULL)                                             \
    X(configuration_of_the_last_mapping, confdev, writable_only(c, 0x1A01), NULL)                                      \
    X(configuration_of_an_assignment, confdev, writable_only(c, 0x1C13), NULL)                                         \
    X(configuration_of_nothing, confdev, writable_only(c, 0), "has no assignment or mapping that can be written")

#define CLOCKS(X)                                                                                                      \
    X(no_mode_and_no_sync0, confdev, (D.dc_mode_count = 0, D.sync.supported = 3), NULL)                                \
    X(sync0_and_no_mode, confdev, (D.dc_mode_count = 0, D.sync.supported = 4), "SYNC0 is supported, but no mode of")   \
    X(second_mode_unnamed, confdev, (D.dc_modes = unnamed, D.dc_mode_count = 2), "dc_modes: a name is missing")        \
    X(first_mode_named, confdev, (D.dc_modes = unnamed, D.dc_mode_count = 1), NULL)                                    \
    X(no_cycles, confdev, (D.sync.dc_cycles_ns = NULL, D.sync.dc_cycle_count = 0), NULL)                               \
    X(free_run_without_clocks, confdev, (D.esc = "ipcore-small", D.dc_modes = free_run), NULL)

#define PDOS(X)                                                                                                        \
    X(excludes_three, confdev, excludes(c, three_excludes), NULL)                                                      \
    X(excludes_a_missing_third, confdev, excludes(c, three_with_one_wrong), "excludes 1602h, which is no other PDO")   \
    X(excludes_nothing, confdev, excludes(c, NULL), NULL)                                                              \
    X(third_assigned_twice, confdev, (D.services = NULL, entries(c, 0x1C13, assigns_three, 3)),                        \
      "1C13h:3: 1A01h is assigned twice")                                                                              \
    X(an_element_missing, confdev, (D.services = NULL, entries(c, 0x1C13, assigns_a_hole, 2)),                         \
      "1C13h: it has no element 2")                                                                                    \
    X(the_last_element_missing, confdev, (D.services = NULL, entries(c, 0x1C13, assigns_up_to_a_hole, 2)),             \
      "1C13h: it has no element 2")                                                                                    \
    X(a_padding, confdev, ENTRY(0x1600, 1)->value = ECT_MAP(0, 0, 8), NULL)                                            \
    X(an_index_of_1, confdev, ENTRY(0x1600, 1)->value = ECT_MAP(1, 0, 8), "1600h:1: there is no 0001h:0 to map")       \
    X(a_padding_of_nothing, confdev, ENTRY(0x1600, 1)->value = ECT_MAP(0, 0, 0), "1600h:1: it maps nothing")           \
    X(a_pdo_as_value, confdev, (D.services = NULL, single(c, 0x1601)), "1601h: a PDO is a record")                     \
    X(an_assignment_as_value, confdev, (D.services = NULL, single(c, 0x1C12)), "1C12h: an assignment is an array")     \
    X(empty_assignment_beyond, terminal, (D.sm_count = 2, ENTRY(0x1C12, 0)->value = 0), NULL)                          \
    X(as_much_as_the_maximum, confdev, D.sm[3].maximum = 3, NULL)

/* An object as a VAR of its sub-index 0. */
static void single(copy_t *c, uint16_t index)
{
    ect_object_t *o = copy_object(c, index);
    o->object_code = ECT_OBJECT_VAR;
    o->last = 0;
    o->max_subindex = 0;
}

#define OBJECTS(X)                                                                                                     \
    X(fewer_elements_in_1600h, confdev, ENTRY(0x1600, 0)->value = 0, NULL)                                             \
    X(fewer_elements_without_memory_in_1600h, confdev, fewer(c, 0x1600), NULL)                                         \
    X(fewer_elements_before_1600h, confdev, fewer(c, 0x15FF), "15FFh:0: it has 0 elements, but the last is 4")         \
    X(fewer_elements_in_1C3Fh, confdev, fewer(c, 0x1C3F), NULL)                                                        \
    X(fewer_elements_from_1C40h_on, confdev, fewer(c, 0x1C40), "1C40h:0: it has 0 elements, but the last is 4")        \
    X(positive_with_the_next_bit, testdev, (c->details[0].maximum = 32767, ENTRY(0x2005, 0)->value = 0x4000), NULL)    \
    X(negative_with_the_sign_alone, testdev, (c->details[0].minimum = -32768, ENTRY(0x2005, 0)->value = 0x8000), NULL) \
    X(default_of_a_command, testdev, ENTRY(0x2005, 0)->access |= ECT_ACCESS_COMMAND, NULL)                             \
    X(default_that_is_never_read, testdev, (ENTRY(0x2005, 0)->access = ECT_ACCESS_WO, ENTRY(0x2005, 0)->value = 201),  \
      NULL)                                                                                                            \
    X(limits_of_one_value, testdev, c->details[0].minimum = c->details[0].maximum = 5, NULL)

/* An object of four elements at another index, with a constant count of 0, in ascending order among the others. */
static void fewer(copy_t *c, uint16_t index)
{
    static const ect_entry_t four[] = {{0, ECT_TYPE_UNSIGNED8, 8, ECT_ACCESS_RO, "Number of entries", 0, NULL},
                                       {1, ECT_TYPE_UNSIGNED32, 32, ECT_ACCESS_RO, "Element", 0, NULL},
                                       {2, ECT_TYPE_UNSIGNED32, 32, ECT_ACCESS_RO, "Element", 0, NULL},
                                       {3, ECT_TYPE_UNSIGNED32, 32, ECT_ACCESS_RO, "Element", 0, NULL},
                                       {4, ECT_TYPE_UNSIGNED32, 32, ECT_ACCESS_RO, "Element", 0, NULL}};
    const uint16_t neighbour = index < 0x1C00 ? 0x1600 : 0x1C33;
    c->device.services = NULL;
    if (neighbour == 0x1600) {
        copy_entry(c, 0x1C12, 0)->value = 0;
        c->device.sm[2].maximum = 0;
    }
    copy_object(c, neighbour)->object_code = ECT_OBJECT_ARRAY;
    entries(c, neighbour, four, 4);
    copy_object(c, neighbour)->index = index;
}

#define FUNCTION(name, of, statement, want)                                                                            \
    static void change_##name(copy_t *c)                                                                               \
    {                                                                                                                  \
        (void)c;                                                                                                       \
        (void)(statement);                                                                                             \
    }
#define ROW(name, of, statement, want) {#name, &(of), change_##name, want},
#define ALL(X)                         PROTOCOLS(X) CONSTANTS(X) SERVICES(X) CLOCKS(X) PDOS(X) OBJECTS(X)

ALL(FUNCTION)
static const row_t rows[] = {ALL(ROW)};

static void each_offer(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char text[ECT_CHECK_TEXT];
        copy_t *c = copy_device(rows[i].device);
        rows[i].change(c);
        bool good = ect_device_check(&c->device, text, sizeof text);
        if (good != (rows[i].want == NULL) || (!good && strstr(text, rows[i].want) == NULL))
            fail_msg("%s of %s: expected %s, got '%s'", rows[i].name, rows[i].device->name,
                     rows[i].want != NULL ? rows[i].want : "no mistake", text);
        copy_free(c);
    }
}

/* --- mailboxes of the BOOT state ---------------------------------------------------------------------------------- */

/* The BOOT mailboxes of testdev: 34 to 1486 bytes, apart, in 8 KB from 1000h. */
static void boot_mailboxes(void **state)
{
    static const struct {
        const char *what;
        ect_boot_mailbox_t out, in;
        const char *want;
    } table[] = {
        {"none", {0, 0}, {0, 0}, NULL},
        {"the shortest", {0x1000, 34}, {0x1100, 34}, NULL},
        {"too short to the slave", {0x1000, 33}, {0x1100, 34}, "have 34 to 1486 bytes both, not 33 and 34"},
        {"too short from the slave", {0x1000, 34}, {0x1100, 33}, "have 34 to 1486 bytes both, not 34 and 33"},
        {"the longest", {0x1000, 1486}, {0x1800, 1486}, NULL},
        {"too long to the slave", {0x1000, 1487}, {0x1800, 128}, "not 1487 and 128"},
        {"too long from the slave", {0x1000, 128}, {0x1800, 1487}, "not 128 and 1487"},
        {"one way alone", {0x1000, 128}, {0x1100, 0}, "not 128 and 0"},
        {"the other way alone", {0x1000, 0}, {0x1100, 128}, "not 0 and 128"},
        {"side by side", {0x1000, 128}, {0x1080, 128}, NULL},
        {"in the other order", {0x1080, 128}, {0x1000, 128}, NULL},
        {"one byte of both", {0x1000, 128}, {0x107F, 128}, "its two mailboxes overlap"},
        {"one byte of both, in the other order", {0x107F, 128}, {0x1000, 128}, "its two mailboxes overlap"},
        {"the last byte of the memory", {0x1000, 128}, {0x2F80, 128}, NULL},
        {"a byte beyond the memory", {0x1000, 128}, {0x2F81, 128}, "SM1: 2F81h to 3000h are not in the memory"},
        {"a byte before the memory", {0x0FFF, 128}, {0x1100, 128}, "SM0: 0FFFh to 107Eh are not in the memory"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        char text[ECT_CHECK_TEXT];
        copy_t *c = copy_device(&testdev);
        c->device.boot_out = table[i].out;
        c->device.boot_in = table[i].in;
        bool good = ect_device_check(&c->device, text, sizeof text);
        if (good != (table[i].want == NULL) || (!good && strstr(text, table[i].want) == NULL))
            fail_msg("%s: expected %s, got '%s'", table[i].what, table[i].want != NULL ? table[i].want : "no mistake",
                     text);
        copy_free(c);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"CF-057 CF-058 CF-060 CF-061 CF-062 CF-067 each offer of a description with its need, and without", each_offer,
         NULL, NULL, NULL},
        {"CF-027 mailboxes of the BOOT state at the bounds of their lengths and places", boot_mailboxes, NULL, NULL,
         NULL},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
