/* SPDX-License-Identifier: MIT */
#include "run_options.h"

const struct argp_option run_options[] = {
    {"interface", 'i', "IFACE", 0, "Network interface of the twins: a spare NIC, or one end of a veth pair", 0},
    {"output", 'o', "IFACE", 0,
     "Second interface, at the output of the last device, for a master with cable redundancy", 0},
    {0},
};

const struct argp_option with_options[] = {
    {"iface", KEY_IFACE, "NAME[,NAME]", 0,
     "Name of the interface for CMD (default ecat0). Two names: a second interface at the output of the last device, "
     "for cable redundancy; its name replaces {2} in ARG and is in $ECTWIN_IFACE2",
     0},
    {"external", KEY_EXTERNAL, "PROGRAM", 0,
     "A slave of your own in place of DEVICE: a shell command, to which ectwin adds -i and an interface (a firmware "
     "with ectwin's soes_hal, docs/SOES.md)",
     0},
    {"in-process", KEY_IN_PROCESS, NULL, 0,
     "Run the twins inside CMD, without a network, namespaces or privileges. Each process of CMD that opens the "
     "interface has its own bus. CMD must be linked dynamically with the C library (docs/IN-PROCESS.md)",
     0},
    {"virtual-time", KEY_VIRTUAL_TIME, NULL, 0,
     "With --in-process: run on a virtual clock, which advances only while CMD waits; runs are fast and repeatable", 0},
    {"plant", KEY_PLANT, "NAME", 0,
     "With --virtual-time: begin when the plant NAME has come, a program beside this one that reads and sets signals "
     "(docs/PLANTS.md)",
     0},
    {"require-private", KEY_REQUIRE_PRIVATE, NULL, 0,
     "Fail if no private user namespace or /sys can be created (default: run CMD with a warning)", 0},
    {"leave-children", KEY_LEAVE_CHILDREN, NULL, 0,
     "Do not end the processes that CMD has started when CMD ends (default: CMD runs in a PID namespace, and they "
     "end with it)",
     0},
    {0},
};

static error_t parse_with(int key, char *text, struct argp_state *state)
{
    with_words_t *words = state->input;
    switch (key) {
    case ARGP_KEY_INIT:
        state->child_inputs[0] = words->twins;
        return 0;
    case KEY_IN_PROCESS:
        words->in_process = true;
        return 0;
    case KEY_VIRTUAL_TIME:
        words->virtual_time = true;
        return 0;
    case KEY_PLANT:
        words->plant = text;
        return 0;
    case KEY_EXTERNAL:
        argp_error(state, "'--external' is no option of a bus, or lacks its value");
        return 0;
    case ARGP_KEY_ARG:
        if (words->devices)
            argp_error(state, "one list of devices is enough: separate them by commas");
        words->devices = text;
        return 0;
    case ARGP_KEY_END:
        if (!words->devices)
            argp_error(state, "name a device");
        twin_args_devices(words->twins, state, words->devices);
        return 0;
    default: /* options without effect on twins */
        return key >= KEY_IFACE && key < KEYS_OF_WITH_END ? 0 : ARGP_ERR_UNKNOWN;
    }
}

static const struct argp_child children_of_with[] = {{&twin_argp, 0, NULL, 0}, {0}};
const struct argp with_words_argp = {.options = with_options, .parser = parse_with, .children = children_of_with};

static error_t ignore_run(int key, char *text, struct argp_state *state)
{
    (void)text;
    (void)state;
    return key == 'i' || key == 'o' ? 0 : ARGP_ERR_UNKNOWN;
}

const struct argp run_words_argp = {.options = run_options, .parser = ignore_run};
