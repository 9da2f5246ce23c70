/* SPDX-License-Identifier: MIT */
/* Descriptions with one thing wrong in each, and the line that names it (check/check.h). */
#include "check/check.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support/confdev.h"
#include "support/copy.h"
#include "support/every.h"
#include "support/gauge.h"
#include "support/terminal.h"
#include "support/testdev.h"
#include "support/wire.h"

/* A device, what is done to a copy of it, and a part of the line that follows. */
typedef struct row {
    const char *name;
    const ect_device_t *device;
    void (*spoil)(copy_t *c);
    const char *want;
} row_t;

#define OBJECT(index)     copy_object(c, index)
#define ENTRY(index, sub) copy_entry(c, index, sub)
#define D                 c->device

/* X(name, device, what is done to it, a part of the line) */
#define NAMES(X)                                                                                                       \
    X(no_name, confdev, D.name = NULL, "name is missing")                                                              \
    X(name_empty, confdev, D.name = "", "name is missing")                                                             \
    X(name_upper, confdev, D.name = "Confdev", "name: 'Confdev' contains a character other than lower case")           \
    X(name_underscore, confdev, D.name = "conf_dev", "'conf_dev' contains a character other")                          \
    X(no_summary, confdev, D.summary = NULL, "summary is missing")                                                     \
    X(no_vendor, confdev, D.vendor_name = NULL, "vendor_name is missing")                                              \
    X(no_type, confdev, D.type_name = NULL, "type_name is missing")                                                    \
    X(type_long, confdev, D.type_name = "a name that has, on the whole, more than 40", "longer than 40")               \
    X(type_control, confdev, D.type_name = "tab\there", "has the character 09h")                                       \
    X(full_name, confdev, D.full_name = "", "full_name is missing")                                                    \
    X(no_group, confdev, D.group_type = NULL, "group_type is missing")                                                 \
    X(no_group_name, confdev, D.group_name = NULL, "group_name is missing")                                            \
    X(no_version, gauge, D.hardware_version = NULL, "1009h:0: the description has no such text")                       \
    X(empty_version, gauge, D.software_version = "", "software_version is missing")                                    \
    X(no_physics, confdev, D.physics = NULL, "physics: one letter for each port")                                      \
    X(physics_five, confdev, D.physics = "YYYYY", "physics: one letter for each port")                                 \
    X(physics_x, confdev, D.physics = "YX", "physics: one letter for each port")

#define OBJECTS(X)                                                                                                     \
    X(instance_small, confdev, D.instance_size = 4, "an instance begins with ect_standard_t")                          \
    X(objects_missing, confdev, D.objects = NULL, "objects: they are missing")                                         \
    X(object_twice, confdev, OBJECT(0x2101)->index = 0x2100, "2100h: objects are in ascending order")                  \
    X(object_order, confdev, OBJECT(0x6000)->index = 0x2000, "2000h: objects are in ascending order")                  \
    X(object_code, confdev, OBJECT(0x6000)->object_code = 5, "6000h: there is no object code 5")                       \
    X(object_name, confdev, OBJECT(0x6000)->name = NULL, "6000h: it has no name")                                      \
    X(no_entries, confdev, OBJECT(0x6000)->entries = NULL, "6000h: it has no entries")                                 \
    X(var_of_two, confdev, OBJECT(0x2100)->max_subindex = 1, "2100h: a VAR has one entry")                             \
    X(var_elsewhere, confdev, ENTRY(0x2100, 0)->subindex = 1, "2100h: a VAR has one entry, sub-index 0")               \
    X(domain_elsewhere, confdev, (OBJECT(0x2101)->object_code = ECT_OBJECT_DOMAIN, ENTRY(0x2101, 0)->subindex = 255),  \
      "2101h: a DOMAIN has one entry, sub-index 0")                                                                    \
    X(domain_of_five, confdev, OBJECT(0x6000)->object_code = ECT_OBJECT_DOMAIN, "6000h: a DOMAIN has one entry")       \
    X(not_counted, confdev, OBJECT(0x6000)->last = 0, "6000h: its entries are not counted")                            \
    X(max_too_high, confdev, OBJECT(0x6000)->max_subindex++, "6000h:0: it has 4 elements, but the last is 5")          \
    X(max_and_count_too_high, confdev, (OBJECT(0x6000)->max_subindex++, ENTRY(0x6000, 0)->value++),                    \
      "6000h: its last sub-index is 4, max_subindex is 5")                                                             \
    X(max_too_low, confdev, OBJECT(0x6000)->max_subindex--, "6000h:0: it has 4 elements, but the last is 3")           \
    X(entry_twice, confdev, ENTRY(0x6000, 3)->subindex = 2, "6000h: its entries are not in ascending order")           \
    X(entry_order, confdev, ENTRY(0x6000, 1)->subindex = 3, "6000h: its entries are not in ascending order")           \
    X(entry_beyond, confdev, ENTRY(0x6000, 4)->subindex = 9, "not up to 4: 9 comes after 3")                           \
    X(entry_missing, confdev, ENTRY(0x6000, 4)->subindex = 0, "6000h: its entries are not in ascending order")         \
    X(no_sub0, confdev, ENTRY(0x6000, 0)->data_type = ECT_TYPE_UNSIGNED16, "6000h: a record or array begins with")     \
    X(count_low, confdev, ENTRY(0x6000, 0)->value = 3, "6000h:0: it has 3 elements, but the last is 4")                \
    X(count_high, confdev, ENTRY(0x1600, 0)->value = 5, "1600h:0: it has 5 elements, but the last is 4")               \
    X(entry_name, confdev, ENTRY(0x6000, 2)->name = NULL, "6000h:2: it has no name")                                   \
    X(type_unknown, confdev, ENTRY(0x6000, 2)->data_type = 0x40, "6000h:2: its data type 0040h is none")               \
    X(type_none, confdev, ENTRY(0x6000, 2)->data_type = 0, "6000h:2: its data type 0000h is none")                     \
    X(type_length, confdev, ENTRY(0x6000, 2)->bit_length = 8, "6000h:2: its data type 0006h has 16 bits, not 8")       \
    X(text_bits, confdev, ENTRY(0x2101, 0)->bit_length = 33, "2101h:0: 33 bits are not whole bytes")                   \
    X(no_length, confdev, ENTRY(0x2101, 0)->bit_length = 0, "2101h:0: only an entry without memory")                   \
    X(access_unknown, confdev, ENTRY(0x6000, 2)->access |= 0x1000, "6000h:2: there is no access 1000h")                \
    X(shared_and_described, confdev, ENTRY(0x1018, 0)->access |= 0xA000, "1018h:0: it is either shared or")            \
    X(written_nowhere, confdev, ENTRY(0x1000, 0)->access = ECT_ACCESS_RW, "1000h:0: it can be written, but")           \
    X(command_ro, confdev, ENTRY(0x1010, 1)->access = ECT_ACCESS_RO | ECT_ACCESS_COMMAND,                              \
      "1010h:1: a command has to be writable")                                                                         \
    X(stored_nowhere, confdev, ENTRY(0x1000, 0)->access |= ECT_ACCESS_BACKUP, "1000h:0: a stored value has to be")     \
    X(outside, confdev, ENTRY(0x2100, 0)->data = AT(sizeof(confdev_t) - 3), "2100h:0: it ends at byte")                \
    X(far_outside, confdev, ENTRY(0x2100, 0)->data = AT(SIZE_MAX - 1), "beyond the instance of")                       \
    X(over_standard, confdev, ENTRY(0x2100, 0)->data = ECT_STANDARD(identity), "2100h:0: it lies in what belongs to")  \
    X(over_description, confdev, ENTRY(0x1018, 1)->data = AT(1), "1018h:1: it lies in what belongs to the stack")      \
    X(no_member, gauge, ENTRY(0x1000, 0)->data = AT(sizeof(ect_device_t)), "1000h:0: it is no member of")              \
    X(text_no_member, gauge, ENTRY(0x1008, 0)->data = AT(offsetof(ect_device_t, type_name) + 1), "1008h:0: it is no")  \
    X(value_large, confdev, ENTRY(0x1C00, 0)->data_type = ECT_TYPE_UNSIGNED16, "1C00h: a record or array begins")      \
    X(default_large, confdev, ENTRY(0x6000, 1)->value = 256, "6000h:1: its default 100h does not fit into 8 bits")     \
    X(default_negative, testdev, ENTRY(0x2005, 0)->value = 0xFFFF7FFF, "2005h:0: its default FFFF7FFFh does not fit")

#define DETAILS(X)                                                                                                     \
    X(details_missing, testdev, D.details = NULL, "details: they are missing")                                         \
    X(detail_of_nothing, testdev, c->details[0].subindex = 1, "details: there is no 2005h:1")                          \
    X(details_order, testdev, copy_detail(c, 0x2000, 0), "2000h:0 comes after 2005h:0")                                \
    X(details_twice, testdev, copy_detail(c, 0x2005, 0), "2005h:0 comes after 2005h:0")                                \
    X(limits_swapped, testdev, c->details[0].minimum = 300, "2005h:0: its minimum 300 is above its maximum 200")       \
    X(limit_beyond, testdev, c->details[0].maximum = 40000, "2005h:0: its limits -100 to 40000 are beyond its type")   \
    X(limit_below, testdev, c->details[0].minimum = -32769, "are beyond its type")                                     \
    X(default_low, testdev, ENTRY(0x2005, 0)->value = (uint32_t)-101,                                                  \
      "2005h:0: its default -101 is below its minimum")                                                                \
    X(default_high, testdev, ENTRY(0x2005, 0)->value = 201, "2005h:0: its default 201 is above its maximum 200")       \
    X(limits_of_text, testdev, (c->details[0].index = 0x2001, c->details[0].minimum = 0),                              \
      "2001h:0: only integers have limits")                                                                            \
    X(long_default_of_short, testdev, c->details[0].initial = "12", "2005h:0: a default of up to 32 bits is in")       \
    X(two_defaults, testdev,                                                                                           \
      (copy_detail(c, 0x2009, 0), c->details[1].initial = "12345678", ENTRY(0x2009, 0)->value = 1),                    \
      "2009h:0: it has two defaults")

#define PDOS(X)                                                                                                        \
    X(maps_nothing, confdev, ENTRY(0x1600, 1)->value = ECT_MAP(0x7000, 1, 0), "1600h:1: it maps nothing")              \
    X(maps_missing, confdev, ENTRY(0x1600, 1)->value = ECT_MAP(0x7001, 1, 8), "1600h:1: there is no 7001h:1 to map")   \
    X(maps_wrong_way, confdev, ENTRY(0x1600, 1)->value = ECT_MAP(0x6000, 1, 8), "6000h:1 must not be mapped in that")  \
    X(maps_other_length, confdev, ENTRY(0x1600, 1)->value = ECT_MAP(0x7000, 1, 16), "7000h:1 has 8 bits, not 16")      \
    X(map_type, confdev, (ENTRY(0x1601, 2)->data_type = ECT_TYPE_INTEGER32), "1601h:2: its data type is 0007h, not")   \
    X(assign_type, confdev, (ENTRY(0x1C12, 2)->data_type = ECT_TYPE_INTEGER16),                                        \
      "1C12h:2: its data type is 0006h, not 0003h")                                                                    \
    X(assigns_missing, confdev, ENTRY(0x1C12, 1)->value = 0x1602, "1C12h:1: there is no PDO 1602h")                    \
    X(assigns_wrong_way, confdev, ENTRY(0x1C12, 1)->value = 0x1A00, "1C12h:1: 1A00h is no PDO of that direction")      \
    X(assigns_twice, confdev, (ENTRY(0x1C12, 0)->value = 2, ENTRY(0x1C12, 2)->value = 0x1600),                         \
      "1C12h:2: 1600h is assigned twice")                                                                              \
    X(assignment_missing, terminal, OBJECT(0x1C10)->index = 0x1C0F, "SM0: it has process data, but there is no 1C10h") \
    X(assignment_too_many, terminal, D.sm_count = 2, "1C12h: SM2 has no process data")                                 \
    X(more_than_maximum, confdev, D.sm[3].maximum = 2, "SM3: its PDOs come to 3 bytes, more than its maximum 2")       \
    X(properties_missing, confdev, D.pdo_count = 1, "pdos: they are missing")                                          \
    X(property_of_nothing, confdev, copy_pdo(c, 0x1602, 0, 0), "pdos: there is no PDO 1602h")                          \
    X(property_of_object, confdev, copy_pdo(c, 0x2100, 0, 0), "pdos: there is no PDO 2100h")                           \
    X(property_unknown, confdev, copy_pdo(c, 0x1600, 0x0100, 0), "pdos: 1600h has the unknown property 0100h")         \
    X(excludes_nothing, confdev, copy_pdo(c, 0x1600, 0, 0x1602), "pdos: 1600h excludes 1602h, which is no other")      \
    X(excludes_an_object, confdev, copy_pdo(c, 0x1600, 0, 0x1018), "pdos: 1600h excludes 1018h, which is no other")    \
    X(excludes_itself, confdev, copy_pdo(c, 0x1600, 0, 0x1600), "pdos: 1600h excludes 1600h, which is no other")

#define CHIP(X)                                                                                                        \
    X(no_esc, confdev, D.esc = NULL, "there is no ESC ''")                                                             \
    X(unknown_esc, confdev, D.esc = "et1101", "there is no ESC 'et1101'; there are: np40, et1100, et1200, lan9252")    \
    X(sms_too_many, confdev, D.sm_count = 9, "sm_count: 9 SyncManagers are more than the ESC 'et1100' has, 8")         \
    X(fmmus_too_many, gauge, (D.esc = "lan9252", D.fmmu_count = 4), "fmmu_count: 4 FMMUs are more than")               \
    X(fmmu_role, gauge, D.fmmu[1] = 4, "FMMU1: there is no role 4")                                                    \
    X(sm_type, gauge, D.sm[2].type = 5, "SM2: there is no type 5")                                                     \
    X(virtual_type, terminal, (D.sm[2].flags = ECT_SM_FLAG_VIRTUAL, D.sm[2].role = ECT_SM_INPUTS),                     \
      "SM2: it is virtual, so its type is 0, not 4; `role` has its role")                                              \
    X(sm0_type, gauge, D.sm[0].type = ECT_SM_UNUSED, "SM0: with a mailbox its type is 1, not 0")                       \
    X(mailbox_elsewhere, gauge, D.sm[2].type = ECT_SM_MAILBOX_IN, "SM2: a mailbox is in SM0 and SM1")                  \
    X(mailbox_without, terminal, D.sm[0].type = ECT_SM_MAILBOX_OUT, "1C10h: SM0 has no process data")                  \
    X(direction, terminal, D.sm[1].control = 0x24, "SM1: control 24h has the opposite direction")                      \
    X(direction_out, terminal, D.sm[0].control = 0x60, "SM0: control 60h has the opposite direction")                  \
    X(mailbox_mode, gauge, D.sm[0].control = 0x24, "SM0: control 24h has the wrong mode")                              \
    X(process_mode, terminal, D.sm[1].control = 0x21, "SM1: control 21h has the wrong mode")                           \
    X(mailbox_short, gauge, D.sm[0].length = 33, "SM0: a mailbox has 34 to 1486 bytes, not 33 to 33")                  \
    X(mailbox_of_sdo, gauge, (D.coe_details = ECT_COE_SDO, D.protocols = sdo_only, D.sm[0].length = 15),               \
      "SM0: a mailbox has 16 to 1486 bytes, not 15 to 15")                                                             \
    X(mailbox_minimum_short, gauge, D.sm[0].minimum = 16, "SM0: a mailbox has 34 to 1486 bytes, not 16 to 64")         \
    X(mailbox_long, gauge, D.sm[1].maximum = 1487, "SM1: a mailbox has 34 to 1486 bytes, not 64 to 1487")              \
    X(mailbox_minimum, gauge, D.sm[0].minimum = 65, "SM0: its length 64 is not from its minimum 65")                   \
    X(mailbox_maximum, gauge, D.sm[0].maximum = 63, "SM0: its length 64 is not from its minimum 0 to its maximum 63")  \
    X(process_length, gauge, D.sm[3].length = 8, "SM3: length and minimum are a mailbox's")                            \
    X(process_long, gauge, D.sm[3].maximum = 1487, "SM3: 1487 bytes are more than a datagram holds")                   \
    X(below_memory, gauge, D.sm[3].start = 0x0FF8, "SM3: 0FF8h to 1027h are not in the memory of the ESC 'et1100'")    \
    X(beyond_memory, gauge, D.sm[3].start = 0x2FD1, "SM3: 2FD1h to 3000h are not in the memory of the ESC 'et1100'")   \
    X(overlap, gauge, D.sm[1].start = 0x103F, "SM1: it overlaps SM0")                                                  \
    X(overlap_of_buffers, terminal, D.sm[1].start = 0x1205, "SM2: it overlaps SM1 (process data in three buffers")     \
    X(boot_one, gauge, D.boot_out = ((ect_boot_mailbox_t){0x1400, 64}), "BOOT: its mailboxes have 34 to 1486 bytes")   \
    X(boot_overlap, gauge,                                                                                             \
      (D.boot_out = (ect_boot_mailbox_t){0x1400, 64}, D.boot_in = (ect_boot_mailbox_t){0x143F, 64}),                   \
      "BOOT: its two mailboxes overlap")                                                                               \
    X(boot_beyond, gauge,                                                                                              \
      (D.boot_out = (ect_boot_mailbox_t){0x1400, 64}, D.boot_in = (ect_boot_mailbox_t){0x2FE0, 64}),                   \
      "BOOT mailbox SM1: 2FE0h to 301Fh are not in the memory")                                                        \
    X(boot_without, terminal, D.boot_out = ((ect_boot_mailbox_t){0x1400, 64}), "BOOT: without a mailbox")              \
    X(no_sm1, gauge, (D.sm_count = 1, OBJECT(0x1C13)->index = 0x1C40), "sm_count: a mailbox needs SM0 and SM1")

#define OFFERS(X)                                                                                                      \
    X(not_served, gauge, D.mailbox_protocols |= ECT_MAILBOX_FOE, "it has FoE, the list 'protocols' does not serve it") \
    X(coe_not_named, gauge, D.mailbox_protocols = ECT_MAILBOX_FOE, "it has not CoE, the list 'protocols' serves it")   \
    X(protocol_unknown, gauge, D.mailbox_protocols |= 0x40, "mailbox_protocols: there is no protocol 40h")             \
    X(details_without_coe, terminal, D.coe_details = 1, "coe_details: without CoE there are none")                     \
    X(information_not_named, gauge, D.coe_details = ECT_COE_SDO, "ect_protocol_sdo_info and ECT_COE_SDO_INFO go")      \
    X(no_identity, gauge, OBJECT(0x1018)->index = 0x1019, "a device with CoE has 1000h and 1018h")                     \
    X(sm_types_other, gauge, D.sm_count = 5, "1C00h: it has 4 SyncManagers, the description 5")                        \
    X(identity_other, gauge, (ENTRY(0x1018, 2)->data = NULL, ENTRY(0x1018, 2)->value = 7),                             \
      "1018h:2: it has 7h, the description 7E59h")                                                                     \
    X(rhythm_without, confdev, D.cyclic = cyclic_function, "cyclic: it needs ect_service_rhythm, which calls it")      \
    X(sync_without, confdev, OBJECT(0x1C32)->index = 0x1C31, "ect_service_sync needs 1C32h:1 in memory")               \
    X(sync_outside, confdev, ENTRY(0x1C32, 1)->data = AT(sizeof(confdev_t) - 8), "ect_service_sync, from 1C32h:1 on")  \
    X(sync_crooked, confdev, ENTRY(0x1C32, 1)->data = AT(offsetof(confdev_t, sync) + 2), "are not aligned")            \
    X(diagnosis_without, confdev, OBJECT(0x10F3)->index = 0x10F4, "ect_service_diagnosis needs 10F3h:1")               \
    X(store_without, confdev, OBJECT(0x1010)->index = 0x100F, "ect_service_store needs 1010h:1 that can be written")   \
    X(modes_missing, confdev, D.dc_modes = NULL, "dc_modes: they, or their cycles, are missing")                       \
    X(cycles_missing, confdev, D.sync.dc_cycles_ns = NULL, "dc_modes: they, or their cycles, are missing")             \
    X(no_clocks, confdev, D.esc = "ipcore-small",                                                                      \
      "'DC' needs distributed clocks, which the ESC 'ipcore-small' has not")                                           \
    X(sync0_without_mode, confdev, D.dc_mode_count = 0, "sync: SYNC0 is supported, but no mode of dc_modes starts it") \
    X(inits_missing, gauge, D.init_command_count = 1, "init_commands: they are missing")                               \
    X(init_transition, gauge, init(c, "PS PX", 1), "1C12h:0 names transitions other than IP PS SO SP OP OS")           \
    X(mails_missing, gauge, D.init_mail_count = 1, "init_mails: they are missing")                                     \
    X(mail_transition, gauge, mail(c, "PX", 1), "init_mails: number 1 names transitions other than IP PS SO SP OP OS") \
    X(mail_data, gauge, mail(c, "PS", 2), "init_mails: number 1 has no data")                                          \
    X(init_separator, gauge, init(c, "PSSO", 1), "1C12h:0 names transitions other than IP PS SO SP OP OS")             \
    X(init_never, gauge, init(c, "", 1), "1C12h:0 names transitions other than IP PS SO SP OP OS")                     \
    X(init_empty, gauge, init(c, "PS", 0), "1C12h:0 has no data")                                                      \
    X(no_timeout, confdev, D.timeouts.safeop_op_ms = 0, "timeouts: preop_ms and safeop_op_ms are needed")              \
    X(sii_odd, confdev, D.sii_size = 2000, "sii_size: 2000 is not a multiple of 128")                                  \
    X(sii_none, confdev, D.sii_size = 0, "sii_size: 0 is not a multiple of 128")                                       \
    X(sii_small, confdev, D.sii_size = 256, "sii_size: the SII does not fit into 256 bytes")

static void cyclic_function(void *instance, uint8_t events, uint64_t now_ns)
{
    (void)instance;
    (void)events;
    (void)now_ns;
}

/* The write of one init command of a device. */
/* The second of two mails; its data are missing. */
static void mail(copy_t *c, const char *transitions, uint16_t size)
{
    static ect_init_mail_t mails[2];
    mails[0] = (ect_init_mail_t){.transitions = "IP SO", .protocol = 2, .type = 6};
    mails[1] = (ect_init_mail_t){.transitions = transitions, .protocol = 2, .type = 2, .size = size};
    c->device.init_mails = mails;
    c->device.init_mail_count = 2;
}

static void init(copy_t *c, const char *transitions, uint16_t size)
{
    static const uint8_t data[2];
    static ect_init_command_t command;
    command = (ect_init_command_t){.transitions = transitions, .index = 0x1C12, .size = size, .data = data};
    c->device.init_commands = &command;
    c->device.init_command_count = 1;
}

static const ect_protocol_t *const sdo_only[] = {&ect_protocol_sdo, NULL};

#define AT(offset) ((void *)(uintptr_t)(offset))
#define FUNCTION(name, of, statement, want)                                                                            \
    static void name(copy_t *c)                                                                                        \
    {                                                                                                                  \
        (void)(statement);                                                                                             \
    }
#define ROW(name, of, statement, want) {#name, &(of), name, want},
#define ALL(X)                         NAMES(X) OBJECTS(X) DETAILS(X) PDOS(X) CHIP(X) OFFERS(X)

ALL(FUNCTION)
static const row_t rows[] = {ALL(ROW)};

static void each_wrong(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char text[ECT_CHECK_TEXT];
        copy_t *c = copy_device(rows[i].device);
        rows[i].spoil(c);
        bool good = ect_device_check(&c->device, text, sizeof text);
        if (good || !strstr(text, rows[i].want))
            fail_msg("%s of %s: expected '...%s...', got %s'%s'", rows[i].name, rows[i].device->name, rows[i].want,
                     good ? "nothing, " : "", text);
        assert_true(good == (text[0] == 0));
        assert_null(strchr(text, '\n'));
        copy_free(c);
    }
}

static void every_good(void **state)
{
    char text[ECT_CHECK_TEXT];
    (void)state;
    for (size_t i = 0; every_device(i); i++) {
        if (!ect_device_check(every_device(i), text, sizeof text))
            fail_msg("%s: %s", every_device(i)->name, text);
        if (!ect_plant_check(plant_of(every_device(i)), every_device(i), text, sizeof text))
            fail_msg("%s: %s", every_device(i)->name, text);
        assert_string_equal(text, "");
    }
}

static void cut_off(void **state)
{
    (void)state;
    copy_t *c = copy_device(&confdev);
    char whole[ECT_CHECK_TEXT];
    c->device.esc = "no such chip";
    assert_false(ect_device_check(&c->device, whole, sizeof whole));
    for (size_t room = 0; room <= strlen(whole) + 1; room++) {
        char *text = malloc(room > 0 ? room : 1); /* of just that size */
        assert_non_null(text);
        assert_false(ect_device_check(&c->device, text, room));
        if (room > 0 && (strlen(text) != room - 1 || strncmp(text, whole, room - 1) != 0))
            fail_msg("%zu bytes: '%s'", room, text);
        free(text);
    }
    copy_free(c);
}

/* --- plants ------------------------------------------------------------------------------------------------------- */

typedef struct plant_row {
    const char *name;
    void (*spoil)(ect_plant_t *p, ect_signal_group_t *g, ect_signal_t *s);
    const char *want;
} plant_row_t;

#define FORTY "a123456789b123456789c123456789d123456789"
/* Offset of the last byte of the instance, in a group that begins behind ect_standard_t. */
#define LAST (sizeof(gauge_t) - sizeof(ect_standard_t) - 1)

#define PLANTS(X)                                                                                                      \
    X(modbus_empty, p->modbus = &modbus_of_nothing, "Modbus: a function, its connections or its idle time is missing") \
    X(groups_missing, p->signal_groups = NULL, "signals: their groups are missing")                                    \
    X(signals_missing, g->signals = NULL, "signals: those of 'p' are missing")                                         \
    X(one_signal_missing, (g->signals = NULL, g->signal_count = 1), "signals: those of 'p' are missing")               \
    X(prefix, g->prefix = "P", "signals: a prefix has lower case")                                                     \
    X(prefix_none, g->prefix = NULL, "signals: numbered ones need a prefix")                                           \
    X(one_without_a_prefix, (g->prefix = NULL, g->count = 1), "signals: numbered ones need a prefix")                  \
    X(none_without_a_prefix, (g->prefix = NULL, g->count = 0), NULL)                                                   \
    X(modbus_least, p->modbus = modbus_but(MODBUS_LEAST), NULL)                                                        \
    X(group_outside, g->offset = sizeof(gauge_t) - 8, "signals: the structures of 'p' are not inside the instance")    \
    X(group_count, g->count = 100, "signals: the structures of 'p' are not inside the instance")                       \
    X(signal_unnamed, s[0].name = NULL, "signal p.?: a name has lower case")                                           \
    X(signal_name, s[0].name = "A", "signal p.A: a name has lower case")                                               \
    X(signal_twice, s[1].name = "a", "signal p.a: there are two of that name")                                         \
    X(meaning, s[0].meaning = NULL, "a signal's meaning is missing")                                                   \
    X(signal_type, s[0].type = (ect_signal_type_t)20, "signal p.a: there is no such type")                             \
    X(range_empty, s[0].minimum = 5, "signal p.a: its range is empty, or beyond its type")                             \
    X(range_beyond, s[0].maximum = 256, "signal p.a: its range is empty, or beyond its type")                          \
    X(range_below, s[0].minimum = -1, "signal p.a: its range is empty, or beyond its type")                            \
    X(text_room, s[1].maximum = 128, "signal p.b: its range is empty, or beyond its type")                             \
    X(bytes_room, (s[1].type = ECT_SIGNAL_BYTES, s[1].maximum = 65), "signal p.b: its range is empty, or beyond")      \
    X(text_no_room, s[1].maximum = 0, "signal p.b: its maximum is its room")                                           \
    X(described_and_writable, s[1].type = ECT_SIGNAL_DESCRIBED, "signal p.b: a described signal is read only")         \
    X(signal_outside, s[1].offset = 30, "signal p.b: it is not inside its structure")                                  \
    X(modbus_whole, p->modbus = modbus_but(MODBUS_WHOLE), NULL)                                                        \
    X(modbus_read, p->modbus = modbus_but(MODBUS_READ), "Modbus: a function, its connections or its idle time")        \
    X(modbus_may_write, p->modbus = modbus_but(MODBUS_MAY_WRITE), "Modbus: a function, its connections or its idle")   \
    X(modbus_write, p->modbus = modbus_but(MODBUS_WRITE), "Modbus: a function, its connections or its idle time")      \
    X(modbus_connections, p->modbus = modbus_but(MODBUS_CONNECTIONS), "Modbus: a function, its connections or its")    \
    X(modbus_idle, p->modbus = modbus_but(MODBUS_IDLE), "Modbus: a function, its connections or its idle time")        \
    X(no_groups, (p->signal_groups = NULL, p->signal_group_count = 0), NULL)                                           \
    X(no_signals, (g->signals = NULL, g->signal_count = 0), NULL)                                                      \
    X(name_longest, s[0].name = FORTY, NULL)                                                                           \
    X(name_too_long, s[0].name = FORTY "a", ": a name has lower case, digits and '_', at most 40")                     \
    X(name_empty_signal, s[0].name = "", "signal p.: a name has lower case")                                           \
    X(prefix_longest, g->prefix = FORTY, NULL)                                                                         \
    X(prefix_too_long, g->prefix = FORTY "a", "signals: a prefix has lower case")                                      \
    X(prefix_empty, g->prefix = "", "signals: a prefix has lower case")                                                \
    X(twice_not_ascending, (s[0].name = "c", s[1].name = "c"), "signal p.c: there are two of that name")               \
    X(descending, (s[0].name = "c", s[1].name = "b"), NULL)                                                            \
    X(last_byte, s[0].offset = 9, NULL)                                                                                \
    X(behind_last_byte, s[0].offset = 10, "signal p.a: it is not inside its structure")                                \
    X(text_at_the_end, s[1].offset = 2, NULL)                                                                          \
    X(text_beyond_the_end, s[1].offset = 3, "signal p.b: it is not inside its structure")                              \
    X(bytes_at_the_end, (s[1].type = ECT_SIGNAL_BYTES, s[1].offset = 3), NULL)                                         \
    X(bytes_beyond_the_end, (s[1].type = ECT_SIGNAL_BYTES, s[1].offset = 4), "signal p.b: it is not inside")           \
    X(far_beyond, s[0].offset = UINT16_MAX, "signal p.a: it is not inside its structure")                              \
    X(alone_last_byte, (g->count = 1, s[0].offset = LAST), NULL)                                                       \
    X(alone_behind, (g->count = 1, s[0].offset = LAST + 1), "signal p.a: it is not inside its structure")              \
    X(unnumbered_last_byte, (g->count = 0, g->prefix = NULL, s[0].offset = LAST), NULL)                                \
    X(unnumbered_behind, (g->count = 0, g->prefix = NULL, s[0].offset = LAST + 1), "signal a: it is not inside")       \
    X(groups_fill_the_instance, (g->offset = sizeof(gauge_t) - 20, g->count = 2), NULL)                                \
    X(groups_one_too_far, (g->offset = sizeof(gauge_t) - 19, g->count = 2), "signals: the structures of 'p' are not")  \
    X(group_at_the_end, (g->offset = sizeof(gauge_t), g->count = 0, g->signal_count = 0), NULL)                        \
    X(group_behind_the_end, (g->offset = sizeof(gauge_t) + 1, g->count = 0, g->signal_count = 0),                      \
      "signals: the structures of 'p' are not inside the instance")                                                    \
    X(range_of_one, (s[0].minimum = 3, s[0].maximum = 3), NULL)                                                        \
    X(text_longest, (g->stride = 10, s[1].maximum = 8, s[1].offset = 1), NULL)                                         \
    X(text_minimum, s[1].minimum = 1, "signal p.b: its maximum is its room, its minimum 0")                            \
    X(bytes_no_room, (s[1].type = ECT_SIGNAL_BYTES, s[1].maximum = 0), "signal p.b: its maximum is its room")          \
    X(described_written,                                                                                               \
      (s[1].type = ECT_SIGNAL_DESCRIBED, p->signal_describe = describe_nothing, s[1].access = ECT_SIGNAL_WRITE),       \
      "signal p.b: a described signal is read only")                                                                   \
    X(described,                                                                                                       \
      (s[1].type = ECT_SIGNAL_DESCRIBED, p->signal_describe = describe_nothing, s[1].access = ECT_SIGNAL_READ), NULL)  \
    X(kept_whole,                                                                                                      \
      (p->outside_offset = sizeof(ect_standard_t), p->outside_size = sizeof(gauge_t) - sizeof(ect_standard_t)), NULL)  \
    X(kept_one_too_long,                                                                                               \
      (p->outside_offset = sizeof(ect_standard_t), p->outside_size = sizeof(gauge_t) - sizeof(ect_standard_t) + 1),    \
      "plant: its outside part is not inside the instance")                                                            \
    X(kept_too_early, (p->outside_offset = sizeof(ect_standard_t) - 1, p->outside_size = 1), "plant: its outside")     \
    X(kept_behind, (p->outside_offset = sizeof(gauge_t) + 1, p->outside_size = 1), "plant: its outside part")          \
    X(kept_nothing, (p->outside_offset = 0, p->outside_size = 0), NULL)                                                \
    X(kept_standard, (p->outside_offset = 8, p->outside_size = 8), "plant: its outside part is not inside")            \
    X(kept_beyond, (p->outside_offset = 60, p->outside_size = sizeof(gauge_t)), "plant: its outside part is not")

/* The Modbus side of a base unit without one of its parts. */
enum {
    MODBUS_WHOLE,
    MODBUS_READ,
    MODBUS_MAY_WRITE,
    MODBUS_WRITE,
    MODBUS_CONNECTIONS,
    MODBUS_IDLE,
    MODBUS_LEAST,
    MODBUS_PARTS
};

static const ect_modbus_t *modbus_but(unsigned int missing)
{
    static ect_modbus_t sides[MODBUS_PARTS];
    ect_modbus_t *m = &sides[missing];
    for (size_t i = 0; every_product(i) != NULL; i++) {
        const ect_plant_t *plant = plant_of(every_product(i));
        if (plant != NULL && plant->modbus != NULL)
            *m = *plant->modbus;
    }
    assert_true(m->connections > 0);
    m->read = missing == MODBUS_READ ? NULL : m->read;
    m->may_write = missing == MODBUS_MAY_WRITE ? NULL : m->may_write;
    m->write = missing == MODBUS_WRITE ? NULL : m->write;
    m->connections = missing == MODBUS_CONNECTIONS ? 0 : missing == MODBUS_LEAST ? 1 : m->connections;
    m->idle_ms = missing == MODBUS_IDLE ? 0 : missing == MODBUS_LEAST ? 1 : m->idle_ms;
    return m;
}

static void describe_nothing(const ect_signal_t *signal, uint16_t value, char *text)
{
    (void)signal;
    (void)value;
    *text = '\0';
}

static const ect_modbus_t modbus_of_nothing = {.connections = 4, .idle_ms = 1000};

#define PLANT_FUNCTION(name, statement, want)                                                                          \
    static void plant_##name(ect_plant_t *p, ect_signal_group_t *g, ect_signal_t *s)                                   \
    {                                                                                                                  \
        (void)p;                                                                                                       \
        (void)g;                                                                                                       \
        (void)s;                                                                                                       \
        (void)(statement);                                                                                             \
    }
#define PLANT_ROW(name, statement, want) {#name, plant_##name, want},
PLANTS(PLANT_FUNCTION)
static const plant_row_t plant_rows[] = {{"nothing", NULL, NULL}, PLANTS(PLANT_ROW)};

static void each_plant_wrong(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof plant_rows / sizeof plant_rows[0]; i++) {
        char text[ECT_CHECK_TEXT];
        ect_signal_t signals[] = {{.name = "a", .meaning = "A", .type = ECT_SIGNAL_U8, .maximum = 3},
                                  {.name = "b", .meaning = "B", .type = ECT_SIGNAL_TEXT, .maximum = 7, .offset = 1}};
        ect_signal_group_t group = {.prefix = "p",
                                    .count = 2,
                                    .signal_count = 2,
                                    .offset = sizeof(ect_standard_t),
                                    .stride = 10,
                                    .signals = signals};
        ect_plant_t plant = {.signal_groups = &group, .signal_group_count = 1};
        if (plant_rows[i].spoil)
            plant_rows[i].spoil(&plant, &group, signals);
        bool good = ect_plant_check(&plant, &gauge, text, sizeof text);
        if (good != !plant_rows[i].want || (plant_rows[i].want && !strstr(text, plant_rows[i].want)))
            fail_msg("%s: expected '...%s...', got '%s'", plant_rows[i].name,
                     plant_rows[i].want ? plant_rows[i].want : "", text);
    }
}

/* Lowest and highest bound of each type, and the bytes that a value takes in its structure. */
static void each_type_has_its_range_and_its_size(void **state)
{
    static const struct {
        ect_signal_type_t type;
        int64_t lowest, highest;
        uint16_t bytes;
    } types[] = {{ECT_SIGNAL_BOOL, 0, 1, 1},
                 {ECT_SIGNAL_U8, 0, UINT8_MAX, 1},
                 {ECT_SIGNAL_I8, INT8_MIN, INT8_MAX, 1},
                 {ECT_SIGNAL_U16, 0, UINT16_MAX, 2},
                 {ECT_SIGNAL_I16, INT16_MIN, INT16_MAX, 2},
                 {ECT_SIGNAL_U32, 0, UINT32_MAX, 4},
                 {ECT_SIGNAL_I32, INT32_MIN, INT32_MAX, 4},
                 {ECT_SIGNAL_U64, 0, INT64_MAX, 8},
                 {ECT_SIGNAL_I64, INT64_MIN, INT64_MAX, 8},
                 {ECT_SIGNAL_REAL32, INT64_MIN, INT64_MAX, 4},
                 {ECT_SIGNAL_REAL, INT64_MIN, INT64_MAX, 8}};
    (void)state;
    for (size_t i = 0; i < sizeof types / sizeof types[0]; i++) {
        char text[ECT_CHECK_TEXT];
        ect_signal_t s = {
            .name = "a", .meaning = "A", .type = types[i].type, .offset = (uint16_t)(20 - types[i].bytes)};
        const ect_signal_group_t group = {.prefix = "p",
                                          .count = 2,
                                          .signal_count = 1,
                                          .offset = sizeof(ect_standard_t),
                                          .stride = 20,
                                          .signals = &s};
        const ect_plant_t plant = {.signal_groups = &group, .signal_group_count = 1};
        s.minimum = types[i].lowest;
        s.maximum = types[i].highest;
        if (!ect_plant_check(&plant, &gauge, text, sizeof text))
            fail_msg("type %u: %s", (unsigned int)s.type, text);
        s.offset++;
        assert_false(ect_plant_check(&plant, &gauge, text, sizeof text));
        assert_string_equal(text, "signal p.a: it is not inside its structure");
        s.offset--;
        if (types[i].highest < INT64_MAX) {
            s.maximum = types[i].highest + 1;
            assert_false(ect_plant_check(&plant, &gauge, text, sizeof text));
            s.maximum = types[i].highest;
        }
        if (types[i].lowest > INT64_MIN) {
            s.minimum = types[i].lowest - 1;
            assert_false(ect_plant_check(&plant, &gauge, text, sizeof text));
        }
    }
}

int main(int argc, char **argv)
{
#define T(title, test) {title, test, NULL, NULL, NULL}
    const struct CMUnitTest tests[] = {
        T("every device and every plant is described well", every_good),
        T("CF-057 CF-067 CF-077: each member of a description that can be wrong is found, and named in a line",
          each_wrong),
        T("each member of a plant that can be wrong is found, and named in a line", each_plant_wrong),
        T("each type of signal has its range and its size", each_type_has_its_range_and_its_size),
        T("the line is cut off where its room ends", cut_off),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Descriptions", tests, NULL, NULL);
}
