/* SPDX-License-Identifier: MIT */
/* `ectwin list --modules` of models that no file has: the command reads the modules of the model, and no others. */
#define _GNU_SOURCE
#include "command_lines.h"

#include "esi/twin.h"

static size_t modules, slots;

const ect_esi_device_t *__real_ect_esi_twin_model(const ect_esi_twin_t *twin);
const ect_esi_device_t *__wrap_ect_esi_twin_model(const ect_esi_twin_t *twin);

/* The model of the file with fewer modules and slots: the other ones lie behind their end. */
const ect_esi_device_t *__wrap_ect_esi_twin_model(const ect_esi_twin_t *twin)
{
    static ect_esi_device_t model;
    model = *__real_ect_esi_twin_model(twin);
    model.module_count = modules < model.module_count ? modules : model.module_count;
    model.slot_count = slots < model.slot_count ? slots : model.slot_count;
    return &model;
}

#define IN  "0x00000110  IN                       IO           slots 1*,2-4  Two inputs of 16 bits\n"
#define OUT "0x00000120  OUT                      IO           slots 1-4  An output of 32 bits\n"

static void the_modules_of_the_model(void **state)
{
    static const struct {
        size_t modules, slots;
        int status;
        const char *text;
    } rows[] = {
        {99, 99, 0, IN OUT},
        {2, 99, 0, IN OUT},
        {1, 99, 0, IN},
        {0, 99, 0, ""},
        {99, 0, 2, "ectwin list: RACK has no slots: it takes no modules\n"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        modules = rows[i].modules;
        slots = rows[i].slots;
        command_expect(&(command_line_t){.line = "list --modules esi:" ESI_FILES "/modular.xml#RACK",
                                         .status = rows[i].status,
                                         .text = rows[i].text},
                       NULL, 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"the modules of a model are listed, and none behind them", the_modules_of_the_model, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests_name("Lists of modules", tests, commands_begin, commands_end);
}
