/* SPDX-License-Identifier: MIT */
/* Files that commands write: one ESI file for each family of devices. */
#define _GNU_SOURCE
#include "command_lines.h"

#include <dirent.h>

#include "devices/fzm1/fzm1.h"
#include "output.h"
#include "support/gauge.h"
#include "support/terminal.h"

/* Reads a file, and removes it. */
static void take_file(const char *path, char *content, size_t room)
{
    FILE *file = fopen(path, "rb");
    if (!file)
        fail_msg("%s does not exist", path);
    content[fread(content, 1, room - 1, file)] = '\0';
    fclose(file);
    unlink(path);
}

/* Appends the type of each device in an ESI file. */
static void add_types(const char *path, char *types, size_t room)
{
    static char content[1 << 20];
    take_file(path, content, sizeof content);
    for (const char *at = content; (at = strstr(at, "<Type ProductCode=")); at++) {
        const char *name = strchr(at, '>') + 1;
        const size_t used = strlen(types);
        snprintf(types + used, room - used, " %.*s", (int)strcspn(name, "<"), name);
    }
}

/* Devices of a family need not follow one another. */
static void a_file_for_each_family(void **state)
{
    static const struct {
        const char *file, *types;
    } rows[] = {{"all/ectwin-vr-bu.xml", " VR-BU-ECT-Map1 VR-BU-ECT-Map3 VR-BU-ECT-Map7 VR-BU-ECT-MultiArm"},
                {"all/ectwin-fzm1.xml", " FZM1 FZM1-B"},
                {"all/ectwin-optoncdt2300.xml", " ILD2300"},
                {"all/ectwin-pmctendo.xml", " PMCtendo DD5"},
                {"all/ectwin-test.xml", " GAUGE TERM-8"}};
    ect_device_t other = ect_fzm1;
    const ect_product_t products[] = {{&gauge, NULL}, {&other, NULL}, {&terminal, NULL}};
    (void)state;
    other.name = "fzm1-b";
    other.type_name = "FZM1-B";
    other.identity.product_code++;
    command_expect(&(command_line_t){.line = "esi --all -o all", .text = ""}, products, 3);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char types[200] = "";
        add_types(rows[i].file, types, sizeof types);
        if (strcmp(types, rows[i].types) != 0)
            fail_msg("%s: expected%s, got%s", rows[i].file, rows[i].types, types);
    }
    assert_int_equal(rmdir("all"), 0); /* no other file */
}

/* SOES has mailboxes in SyncManagers 0 and 1, outputs in 2, inputs in 3; the last two may be unused. */
static void sync_managers_of_soes(void **state)
{
    enum { OUT = ECT_SM_MAILBOX_OUT, IN = ECT_SM_MAILBOX_IN, OUTPUTS = ECT_SM_OUTPUTS, INPUTS = ECT_SM_INPUTS };
    static const struct {
        unsigned int types[4], count;
        bool suits;
    } rows[] = {
        {{OUT, IN, OUTPUTS, INPUTS}, 4, true},
        {{OUT, IN, ECT_SM_UNUSED, INPUTS}, 4, true},
        {{OUT, IN, OUTPUTS, ECT_SM_UNUSED}, 4, true},
        {{OUT, IN, ECT_SM_UNUSED, ECT_SM_UNUSED}, 4, true},
        {{OUT, IN, OUTPUTS, INPUTS}, 3, false},
        {{OUT, IN, OUTPUTS, INPUTS}, 5, false},
        {{ECT_SM_UNUSED, IN, OUTPUTS, INPUTS}, 4, false},
        {{OUT, ECT_SM_UNUSED, OUTPUTS, INPUTS}, 4, false},
        {{IN, OUT, OUTPUTS, INPUTS}, 4, false},
        {{OUT, IN, INPUTS, INPUTS}, 4, false},
        {{OUT, IN, INPUTS, OUTPUTS}, 4, false},
        {{OUT, IN, OUTPUTS, OUTPUTS}, 4, false},
        {{OUTPUTS, INPUTS, ECT_SM_UNUSED, ECT_SM_UNUSED}, 4, false},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ect_device_t device = ect_fzm1;
        device.sm_count = (uint8_t)rows[i].count;
        for (size_t n = 0; n < 4; n++)
            device.sm[n].type = (uint8_t)rows[i].types[n];
        if (output_suits_soes(&device) != rows[i].suits)
            fail_msg("row %zu: expected %d, got %d", i, rows[i].suits, !rows[i].suits);
    }
}

#define TEST(title, function) {title, function, NULL, NULL, NULL}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        TEST("`esi --all` writes a file for each family of devices", a_file_for_each_family),
        TEST("SOES has two mailboxes, outputs and inputs", sync_managers_of_soes),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Files of commands", tests, commands_begin, commands_end);
}
