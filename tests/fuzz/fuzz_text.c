/* SPDX-License-Identifier: MIT */
/* Texts of users and programs: faults with their moments, a slave's dictionary as JSON. */
#include <stdlib.h>
#include <string.h>

#include "bus/faults/scenario.h"
#include "facts/facts.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* A fault that is read is written, and reading the written text gives the same fault. */
static void read_faults(char *text)
{
    char message[ECT_FAULT_MESSAGE] = "", written[ECT_FAULT_TEXT], again[ECT_FAULT_TEXT];
    ect_scenario_t scenario = {0};
    ect_fault_t fault;
    if (!ect_scenario_read(&scenario, text, message) && message[0] == '\0')
        abort(); /* refused without a word */
    if (!ect_fault_parse(text, &fault, message))
        return;
    ect_fault_print(&fault, written);
    if (!ect_fault_parse(written, &fault, message))
        abort();
    ect_fault_print(&fault, again);
    if (strcmp(written, again) != 0)
        abort();
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    ect_facts_t facts = {.source = "input"};
    char *text = calloc(1, size + 1);
    if (!text)
        return 0;
    memcpy(text, data, size);
    read_faults(text);
    (void)ect_facts_of_dictionary(&facts, text);
    ect_facts_free(&facts);
    free(text);
    return 0;
}
