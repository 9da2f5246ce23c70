/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bus/chain/settings.h"
#include "bus/net/rights.h"
#include "bus_place.h"
#include "commands.h"
#include "connect_args.h"
#include "grow.h"
#include "network.h"
#include "panel_args.h"
#include "play_args.h"
#include "products.h"
#include "text/argument.h"
#include "twin_names.h"
#include "twin_storage.h"
#include "wire/bytes.h"
#include "wire/sii.h"

enum {
    KEY_VENDOR_ID = 0x100,
    KEY_PRODUCT_CODE,
    KEY_REVISION,
    KEY_SERIAL,
    KEY_ALIAS,
    KEY_KEEP_MAC,
    KEY_DROP,
    KEY_DELAY,
    KEY_DELAY_US,
    KEY_SEED,
    KEY_STORE,
    KEY_SET,
    KEY_REALTIME,
    KEY_BUSY_POLL,
    KEY_IN_KERNEL,
    KEY_BREAK,
    KEY_MODULE,
    KEY_BEHAVIOUR,
    KEY_CONNECT,
    KEY_FAULT,
    KEY_FAULTS,
    KEY_SCENARIO,
    KEY_PLAY,
    KEY_FILES,
    KEY_FILES_PASSWORD,
    KEY_MODBUS,
    KEY_UDP,
    KEY_NAME,
    KEY_PANEL,
    KEY_PCAP,
    KEY_PCAP_SIZE,
    KEY_RECORD,
    KEY_QUIET,
    KEY_ESI_DIR,
};

/* Default of --pcap-size. */
#define PCAP_SIZE 1000000000ull

/* Characters of a path in a message: the end, which has the name of the file. */
#define PATH_SHOWN 40

static const struct argp_option options[] = {
    {"vendor-id", KEY_VENDOR_ID, "[N:]ID", 0,
     "Vendor id of twin N, or of all twins without N, 0..4294967295 (default: the placeholder of the device). May be "
     "repeated",
     1},
    {"product-code", KEY_PRODUCT_CODE, "[N:]CODE", 0,
     "Product code of twin N, or of all twins without N, 0..4294967295 (default: that of the device). May be repeated",
     1},
    {"revision", KEY_REVISION, "[N:]NUMBER", 0,
     "Revision number of twin N, or of all twins without N, 0..4294967295 (default: that of the device). May be "
     "repeated",
     1},
    {"serial", KEY_SERIAL, "[N:]NUMBER", 0,
     "Serial number of twin N. Without N: of the first twin, and each further twin has the next number (default 1). "
     "May be repeated",
     1},
    {"alias", KEY_ALIAS, "[N:]ALIAS", 0,
     "Configured station alias and device id of twin N, 1..65535. Without N: of the first twin, and each further "
     "twin has the next number (default: none). May be repeated",
     1},
    {"keep-source-mac", KEY_KEEP_MAC, NULL, 0,
     "Leave the source address of frames unchanged (default: set bit 1 of its first byte, as an ESC does)", 1},
    {"store", KEY_STORE, "DIR", 0,
     "Keep saved parameters and EEPROM contents of the twins in this folder (default: in memory, until the end)", 1},
    {"files", KEY_FILES, "DIR", 0,
     "Serve the files of this folder by FoE, for reading and writing, also in BOOT (default: no files)", 1},
    {"files-password", KEY_FILES_PASSWORD, "N", 0,
     "Password that FoE requests for --files must have, 1..4294967295 (default: none)", 1},
    {"udp", KEY_UDP, "[ADDR:]PORT", 0,
     "Accept EtherCAT in UDP as well, at this address (default address 127.0.0.1; port 0: any free port). The twins "
     "accept frames from every sender",
     1},
    {"modbus", KEY_MODBUS, "[ADDR:]PORT", 0,
     "Serve one base unit by Modbus TCP as well, at this address (default address 127.0.0.1; port 0: any free port)",
     1},
    {"name", KEY_NAME, "NAME", 0,
     "Name of these twins for 'ectwin ps' and for the option -s of other commands (default: the process id)", 1},
    {"panel", KEY_PANEL, "TWIN[,TWIN...]", 0, "'ectwin panel' opens with the fronts of these twins, in this order", 1},
    {"module", KEY_MODULE, "[N:]SLOT=IDENT", 0,
     "ModuleIdent of the module in a slot of twin N (default 1), a modular device of an ESI file. May be repeated", 1},
    {"behaviour", KEY_BEHAVIOUR, "[N:]KIND", 0,
     "Behaviour of twin N of an ESI file, or of all twins without N: cia402, a drive for each axis; cia404, a "
     "measuring device; cia406, an encoder; or none (default: cia404 or cia406 if ProfileNo is 404 or 406, cia402 if "
     "the file has 6040h and 6041h). May be repeated",
     1},
    {"connect", KEY_CONNECT, "SIGNAL=SIGNAL", 0,
     "Set a signal from another one, N.NAME=M.NAME of twins N and M, modified by ,factor=F ,offset=O ,delay=10ms "
     ",invert (default: the unchanged value, at once). May be repeated",
     1},
    {"pcap", KEY_PCAP, "FILE", 0,
     "Write all frames to FILE (pcapng, for Wireshark), with faults, plugs, state changes, requests and saves as "
     "comments",
     1},
    {"pcap-size", KEY_PCAP_SIZE, "BYTES[K|M|G]", 0,
     "Maximum size of the file of --pcap, 66K or more, 0: no limit (default 1G). At the limit the older half is "
     "removed",
     1},
    {"record", KEY_RECORD, "FILE", 0,
     "Write FILE for 'ectwin replay': all frames, and all other input on which replies depend (docs/REPLAY.md)", 1},
    {"esi-dir", KEY_ESI_DIR, "DIR", 0,
     "Folder of ESI files. Each slave of eni:FILE is the device with the same vendor, product and revision there "
     "(default: a device from the ENI alone)",
     1},
    {"quiet", KEY_QUIET, NULL, 0, "Print no notes on standard error; errors and the ready line remain", 1},
    {"set", KEY_SET, "[N:]NAME=VALUE", 0,
     "Set a signal of twin N (default 1) before it starts; 'ectwin list-signals DEVICE' lists the names. May be "
     "repeated",
     1},
    {"drop", KEY_DROP, "PERCENT", 0,
     "Lose PERCENT of the frames, half of them on the way back; short for --fault 'drop PERCENT%'", 1},
    {"delay", KEY_DELAY, "PERCENT", 0,
     "Send PERCENT of the replies late, by --delay-us; short for --fault 'delay 3000us PERCENT%'", 1},
    {"delay-us", KEY_DELAY_US, "N", 0, "Delay of the replies that --delay selects, microseconds (default 3000)", 1},
    {"fault", KEY_FAULT, "FAULT", 0,
     "Inject a fault, such as 'drop 5%' or 'at 2.5s hang slave 2' (docs/FAULTS.md). May be repeated", 1},
    {"faults", KEY_FAULTS, "FILE", 0, "Inject the faults of FILE, one on each line, in the syntax of --fault", 1},
    {"scenario", KEY_SCENARIO, "FILE", 0,
     "Play the faults, signals and expectations of FILE, one on each line (docs/FAULTS.md). Each expectation is "
     "reported on standard error; the exit status is 3 when an expectation has failed and the run has succeeded",
     1},
    {"play", KEY_PLAY, "[N:]FILE[,...]", 0,
     "Play a table of signals of twin N (default 1) from a CSV file: the first line has names, among them 'time', in "
     "seconds since the start; each further line is set at its time. ,loop: repeat the table from the time of the "
     "last line on; ,every=5ms: interpolate lines every 5 ms (docs/COMMAND.md). May be repeated",
     1},
    {"seed", KEY_SEED, "N", 0,
     "Seed of the random generator that selects frames for --fault, drifts for --drift, delays and jitter (default 1)",
     1},
    {"break", KEY_BREAK, "CF-NNN", 0,
     "Deliberate defect of the first twin, which ectwin-conform must find; 'help' lists the defects", 1},
    {"realtime", KEY_REALTIME, "PRIO", OPTION_ARG_OPTIONAL,
     "Run with real-time priority 1 to 99 (SCHED_FIFO, default 50) and locked memory", 1},
    {"busy-poll", KEY_BUSY_POLL, NULL, 0,
     "Poll continuously: lower latency, one CPU core at 100 % (default: sleep until a frame comes)", 1},
    {"in-kernel", KEY_IN_KERNEL, NULL, 0,
     "Reply to recurring frames in the kernel (XDP), as root (default: every reply in this process)", 1},
    {0},
};

static uint32_t parse_number(const struct argp_state *state, const char *option, const char *text, uint32_t maximum)
{
    return (uint32_t)ect_argument_number(state, option, text, 0, maximum);
}

/* The value may also be the next word: no device begins with a digit. */
static int parse_priority(struct argp_state *state, const char *text)
{
    const char *next = state->next < state->argc ? state->argv[state->next] : "";
    if (!text && *next >= '0' && *next <= '9') {
        text = next;
        state->next++;
    }
    return text ? (int)ect_argument_number(state, "--realtime", text, ECT_RIGHTS_LOWEST, ECT_RIGHTS_HIGHEST) : 50;
}

/* Parses a number of bytes with an optional K, M or G. */
static uint64_t parse_size(const struct argp_state *state, const char *text)
{
    static const struct {
        const char *name;
        uint64_t factor;
    } units[] = {{"", 1}, {"K", 1000}, {"M", 1000000}, {"G", 1000000000}};
    uint64_t number = 0;
    const char *unit = ect_number_begins(text, 0, UINT64_MAX / 1000000000, &number);
    for (size_t i = 0; unit && i < sizeof units / sizeof units[0]; i++) {
        uint64_t size = number * units[i].factor;
        if (strcmp(unit, units[i].name) == 0 && (size == 0 || size >= ECT_CAPTURE_SMALLEST))
            return size;
    }
    argp_error(state, "--pcap-size takes a number of bytes from %d, as 100M, or 0, not '%s'", ECT_CAPTURE_SMALLEST,
               text);
    return 0;
}

static void add_setting(twin_args_t *args, const struct argp_state *state, const char *text)
{
    if (!strchr(text, '='))
        argp_error(state, "--set takes NAME=VALUE, not '%s'", text);
    args->settings = grow(state, args->settings, args->setting_count, sizeof *args->settings);
    args->settings[args->setting_count++] = text;
}

static void add_connection(twin_args_t *args, const struct argp_state *state, const char *text)
{
    args->connections = grow(state, args->connections, args->connection_count, sizeof *args->connections);
    args->connections[args->connection_count++] = text;
}

static void add_module(twin_args_t *args, const struct argp_state *state, const char *text)
{
    const char *rest = text;
    twin_module_t module = {.twin = twin_of(args->names, &rest, 1), .text = text};
    if (module.twin == 0 || !product_parse_module(rest, &module.choice))
        argp_error(state, "--module takes SLOT=IDENT, as in 1=0x00000120, not '%s'", text);
    args->modules = grow(state, args->modules, args->module_count, sizeof *args->modules);
    args->modules[args->module_count++] = module;
}

static bool parse_behaviour(const char *word, ect_behaviour_t *behaviour)
{
    static const struct {
        const char *word;
        ect_behaviour_t behaviour;
    } words[] = {{"none", ECT_BEHAVIOUR_NONE},
                 {"cia402", ECT_BEHAVIOUR_CIA402},
                 {"cia404", ECT_BEHAVIOUR_CIA404},
                 {"cia406", ECT_BEHAVIOUR_CIA406}};
    for (size_t i = 0; i < sizeof words / sizeof words[0]; i++) {
        if (strcmp(word, words[i].word) == 0) {
            *behaviour = words[i].behaviour;
            return true;
        }
    }
    return false;
}

static void add_behaviour(twin_args_t *args, const struct argp_state *state, const char *text)
{
    const char *word = text;
    twin_behaviour_t one = {.twin = twin_of(args->names, &word, 0), .text = text};
    if ((word != text && one.twin == 0) || !parse_behaviour(word, &one.behaviour))
        argp_error(state,
                   "--behaviour takes cia402, cia404, cia406 or none, or one of them for a twin, as 2:none, not '%s'",
                   text);
    args->behaviours = grow(state, args->behaviours, args->behaviour_count, sizeof *args->behaviours);
    args->behaviours[args->behaviour_count++] = one;
}

/* The last option for a twin is valid; an option for all twins affects only those from files. */
static ect_behaviour_t behaviour_of(const twin_args_t *args, const char *name, size_t place)
{
    for (size_t i = args->behaviour_count; i-- > 0;) {
        const twin_behaviour_t *b = &args->behaviours[i];
        if (b->twin == place || (b->twin == 0 && product_file(name)))
            return b->behaviour;
    }
    return ECT_BEHAVIOUR_BY_FILE;
}

/* --- identity of the twins --------------------------------------------------------------------------------------- */

typedef struct identity_option {
    int key;
    const char *name;
    uint32_t minimum, maximum;
    bool counts_up; /* an option for all twins counts up from twin to twin */
} identity_option_t;

static const identity_option_t *identity_option(int key)
{
    static const identity_option_t known[] = {
        {KEY_VENDOR_ID, "--vendor-id", 0, UINT32_MAX, false},
        {KEY_PRODUCT_CODE, "--product-code", 0, UINT32_MAX, false},
        {KEY_REVISION, "--revision", 0, UINT32_MAX, false},
        {KEY_SERIAL, "--serial", 0, UINT32_MAX, true},
        {KEY_ALIAS, "--alias", 1, UINT16_MAX, true},
    };
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++) {
        if (known[i].key == key)
            return &known[i];
    }
    return NULL;
}

static void add_identity(twin_args_t *args, const struct argp_state *state, int key, const char *text)
{
    const identity_option_t *option = identity_option(key);
    const char *colon = strchr(text, ':');
    const char *value = text;
    args->identities = grow(state, args->identities, args->identity_count, sizeof *args->identities);
    identity_setting_t *setting = &args->identities[args->identity_count++];
    *setting = (identity_setting_t){.key = key, .text = text, .twin = twin_of(args->names, &value, 0)};
    if (colon && (value == text || setting->twin == 0)) { /* no such name, or a number outside its range */
        char number[16];
        snprintf(number, sizeof number, "%.*s", (int)(colon - text), text);
        setting->twin = (size_t)ect_argument_number(state, "N in N:VALUE", number, 1, UINT16_MAX);
    }
    setting->value = (uint32_t)ect_argument_number(state, option->name, value, option->minimum, option->maximum);
}

static void apply_identity(const identity_setting_t *setting, ect_twin_config_t *twin, uint32_t value)
{
    switch (setting->key) {
    case KEY_VENDOR_ID:
        twin->identity.vendor_id = value;
        return;
    case KEY_PRODUCT_CODE:
        twin->identity.product_code = value;
        return;
    case KEY_REVISION:
        twin->identity.revision = value;
        return;
    case KEY_SERIAL:
        twin->identity.serial = value;
        return;
    default:
        twin->alias = (uint16_t)value;
    }
}

/* Refuses the option of a twin that the chain lacks. */
static void check_twin(const twin_args_t *args, const struct argp_state *parser, const char *option, size_t twin,
                       const char *text)
{
    bus_place_t place;
    if (twin > args->count)
        argp_error(bus_place_at(&place, parser, text), "%s %zu:…: the chain has %zu twin%s", option, twin, args->count,
                   args->count == 1 ? "" : "s");
}

static void check_files(const twin_args_t *args, const struct argp_state *parser)
{
    for (size_t i = 0; i < args->module_count; i++)
        check_twin(args, parser, "--module", args->modules[i].twin, args->modules[i].text);
    for (size_t i = 0; i < args->behaviour_count; i++)
        check_twin(args, parser, "--behaviour", args->behaviours[i].twin, args->behaviours[i].text);
}

/* In the order of the command line: later options override earlier ones. */
static void apply_identities(twin_args_t *args, const struct argp_state *parser)
{
    bus_place_t place;
    for (size_t w = 0; w < args->identity_count; w++) {
        const identity_setting_t *setting = &args->identities[w];
        const identity_option_t *option = identity_option(setting->key);
        const struct argp_state *state = bus_place_at(&place, parser, setting->text);
        check_twin(args, parser, option->name, setting->twin, setting->text);
        for (size_t i = 0; i < args->count; i++) {
            uint64_t value =
                (uint64_t)setting->value + (option->counts_up && setting->twin == 0 && !args->kinds ? i : 0);
            if (value > option->maximum)
                argp_error(state, "%s %u is too high for %zu twins: it counts up", option->name, setting->value,
                           args->count);
            if (setting->twin == 0 || setting->twin == i + 1)
                apply_identity(setting, &args->twins[i], (uint32_t)value);
        }
    }
}

/* --- options ------------------------------------------------------------------------------------------------------ */

static void add_fault(twin_args_t *args, const struct argp_state *state, const char *text, const char *where)
{
    char message[ECT_FAULT_MESSAGE];
    if (!ect_scenario_read(&args->scenario, text, message))
        argp_failure(state, EXIT_USAGE, 0, "%s: %s", where, message);
}

/* --drop and --delay. */
static void add_short_faults(twin_args_t *args, const struct argp_state *state)
{
    char text[ECT_FAULT_TEXT];
    snprintf(text, sizeof text, "drop %u%%", args->drop_percent);
    if (args->drop_percent > 0)
        add_fault(args, state, text, "--drop");
    snprintf(text, sizeof text, "delay %uus %u%%", args->delay_us, args->delay_percent);
    if (args->delay_percent > 0)
        add_fault(args, state, text, "--delay");
}

static void read_faults(twin_args_t *args, const struct argp_state *state, const char *option, const char *path)
{
    char *line = NULL;
    size_t room = 0;
    FILE *file = fopen(path, "re");
    if (!file)
        argp_failure(state, EXIT_OPEN, errno, "%s %s", option, path);
    for (unsigned int number = 1; file && getline(&line, &room, file) >= 0; number++) {
        char where[64];
        snprintf(where, sizeof where, "%.40s line %u",
                 path + (strlen(path) > PATH_SHOWN ? strlen(path) - PATH_SHOWN : 0), number);
        args->scenario.line = number;
        add_fault(args, state, line, where);
    }
    args->scenario.line = 0;
    free(line);
    if (file)
        fclose(file);
}

static void print_defect(void *ctx, const char *id, const char *what)
{
    (void)ctx;
    printf("%s %s\n", id, what);
}

static void choose_defect(twin_args_t *args, const struct argp_state *state, const char *id)
{
    if (strcmp(id, "help") == 0) {
        defect_list(print_defect, NULL);
        exit(EXIT_CLEAN);
    }
    if (!defect_choose(&args->defect, id))
        argp_error(state, "there is no defect for '%s'; '--break help' lists all defects", id);
    args->filter = (ect_filter_t){.before = defect_before, .after = defect_after, .ctx = &args->defect};
}

/* Options that may name a twin are parsed after the list of devices. */
static bool is_for_later(int key)
{
    static const int keys[] = {KEY_FAULT, KEY_FAULTS, KEY_SCENARIO, KEY_PLAY, KEY_MODULE, KEY_BEHAVIOUR};
    for (size_t i = 0; i < sizeof keys / sizeof keys[0]; i++) {
        if (keys[i] == key)
            return true;
    }
    return identity_option(key) != NULL;
}

static void keep_for_later(twin_args_t *args, const struct argp_state *state, int key, const char *text)
{
    args->later = grow(state, args->later, args->later_count, sizeof *args->later);
    args->later[args->later_count++] = (twin_later_t){.key = key, .text = text};
}

static void read_later(twin_args_t *args, const struct argp_state *state, const twin_later_t *one)
{
    switch (one->key) {
    case KEY_FAULT:
        add_fault(args, state, one->text, "--fault");
        return;
    case KEY_FAULTS:
        read_faults(args, state, "--faults", one->text);
        return;
    case KEY_SCENARIO:
        read_faults(args, state, "--scenario", one->text);
        return;
    case KEY_PLAY:
        play_args_add(args, state, one->text);
        return;
    case KEY_MODULE:
        add_module(args, state, one->text);
        return;
    case KEY_BEHAVIOUR:
        add_behaviour(args, state, one->text);
        return;
    default:
        add_identity(args, state, one->key, one->text);
    }
}

static void read_all_later(twin_args_t *args, const struct argp_state *state)
{
    bus_place_t place;
    for (size_t i = 0; i < args->later_count; i++) {
        twin_later_t *one = &args->later[i];
        const unsigned int before = ect_scenario_highest_slave(&args->scenario);
        read_later(args, bus_place_at(&place, state, one->text), one);
        one->steps = args->scenario.step_count;
        if (ect_scenario_highest_slave(&args->scenario) > before)
            args->farthest = one->text;
    }
}

static error_t parse_option(int key, char *text, struct argp_state *state)
{
    twin_args_t *args = state->input;
    if (is_for_later(key)) {
        keep_for_later(args, state, key, text);
        return 0;
    }
    switch (key) {
    case KEY_DROP:
        args->drop_percent = (uint8_t)parse_number(state, "--drop", text, 100);
        return 0;
    case KEY_DELAY:
        args->delay_percent = (uint8_t)parse_number(state, "--delay", text, 100);
        return 0;
    case KEY_DELAY_US:
        args->delay_us = parse_number(state, "--delay-us", text, 10000000);
        return 0;
    case KEY_SEED:
        args->scenario.seed = parse_number(state, "--seed", text, UINT32_MAX);
        return 0;
    case KEY_STORE:
        if (*text == 0)
            argp_error(state, "--store takes a folder");
        args->store = text;
        return 0;
    case KEY_ESI_DIR:
        args->esi_dir = text;
        return 0;
    case KEY_FILES:
        args->files = text;
        return 0;
    case KEY_PCAP:
        args->pcap = text;
        return 0;
    case KEY_RECORD:
        args->record = text;
        return 0;
    case KEY_PCAP_SIZE:
        args->pcap_size = parse_size(state, text);
        return 0;
    case KEY_FILES_PASSWORD:
        args->files_password = parse_number(state, "--files-password", text, UINT32_MAX);
        return 0;
    case KEY_UDP:
        args->udp = text;
        return 0;
    case KEY_MODBUS:
        args->modbus = text;
        return 0;
    case KEY_NAME:
        if (ect_endpoint_unfit(text))
            argp_error(state, "--name '%s': %s", text, ect_endpoint_unfit(text));
        args->about.name = text;
        return 0;
    case KEY_PANEL:
        args->about.panel = text;
        return 0;
    case KEY_BREAK:
        choose_defect(args, state, text);
        return 0;
    case KEY_REALTIME:
        args->realtime = parse_priority(state, text);
        return 0;
    case KEY_QUIET:
        args->quiet = true;
        product_quiet();
        return 0;
    case KEY_BUSY_POLL:
        args->busy_poll = true;
        return 0;
    case KEY_IN_KERNEL:
        args->in_kernel = true;
        return 0;
    case KEY_CONNECT:
        add_connection(args, state, text);
        return 0;
    case KEY_SET:
        add_setting(args, state, text);
        return 0;
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &args->wiring;
        state->child_inputs[1] = &args->eoe;
        args->delay_us = 3000;
        args->scenario.seed = 1;
        args->pcap_size = PCAP_SIZE;
        return 0;
    case KEY_KEEP_MAC:
        args->keep_source_mac = true;
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

/* Keys of options lie between ARGP_KEY_ARG and the keys of argp's events. */
static error_t parse(int key, char *text, struct argp_state *state)
{
    bus_place_t place;
    twin_args_t *args = state->input;
    struct argp_state *at = bus_place_at(&place, state, text);
    error_t error = parse_option(key, text, at);
    state->next = at->next;
    args->given = args->given || (error == 0 && key > ARGP_KEY_ARG && key < ARGP_KEY_END);
    return error;
}

static const struct argp_child children[] = {{&wiring_argp, 0, NULL, 0}, {&eoe_argp, 0, NULL, 0}, {0}};

const struct argp twin_argp = {.options = options, .parser = parse, .children = children};

bool twin_args_given(const twin_args_t *args)
{
    return args->given || args->wiring.count > 0 || args->eoe.count > 0;
}

/* Finds a product by name, with the modules of its position in the chain. @return NULL: see message */
static const ect_product_t *find_product(const twin_args_t *args, const char *name, size_t place, char *message)
{
    ect_module_choice_t *choices = calloc(args->module_count + 1, sizeof *choices);
    size_t count = 0;
    for (size_t i = 0; choices && i < args->module_count; i++) {
        if (args->modules[i].twin == place)
            choices[count++] = args->modules[i].choice;
    }
    const ect_product_t *product =
        choices ? product_find(name, choices, count, behaviour_of(args, name, place), message) : NULL;
    free(choices);
    return product;
}

/* Serial number and alias of a file's EEPROM image are kept unless replaced by an option. */
static void keep_image(ect_twin_config_t *twin)
{
    if (twin->device->identity.serial != 0)
        twin->identity.serial = twin->device->identity.serial;
    twin->alias = ect_load_le16(twin->device->sii + ECT_SII_AT_ALIAS);
}

static void add_twin(twin_args_t *args, const struct argp_state *state, const char *name)
{
    bus_place_t place;
    char message[PRODUCT_MESSAGE] = "out of memory";
    const ect_product_t *product = find_product(args, name, args->count + 1, message);
    if (!product)
        argp_failure(bus_place_at_twin(&place, state, args->count + 1), EXIT_USAGE, 0, "%s", message);
    args->twins = grow(state, args->twins, args->count, sizeof *args->twins);
    ect_twin_config_t *twin = &args->twins[args->count++];
    *twin = ect_twin_default(product->device, product->plant);
    twin->keep_source_mac = args->keep_source_mac;
    twin->identity.serial = args->kinds ? 1 : (uint32_t)args->count;
    if (twin->device->sii)
        keep_image(twin);
}

/* Adds the twins of a network file. */
static void add_network(twin_args_t *args, const struct argp_state *parser, const char *path)
{
    bus_place_t place;
    const struct argp_state *state = bus_place_at_twin(&place, parser, args->count + 1);
    char message[PRODUCT_MESSAGE];
    network_names_t network;
    size_t first = args->count;
    if (!network_names(&network, path, args->esi_dir, args->quiet, message))
        argp_failure(state, EXIT_OPEN, 0, "%s", message);
    if (args->count + network.count > UINT16_MAX)
        argp_error(state, "eni:%s: more than %d twins in all", path, UINT16_MAX);
    for (size_t i = 0; i < network.count; i++)
        add_twin(args, state, network.names[i]);
    network_names_free(&network);
    if (!network_apply(path, args->twins, first, message))
        argp_failure(state, EXIT_USAGE, 0, "%s", message);
}

void twin_args_devices(twin_args_t *args, const struct argp_state *state, const char *list)
{
    bus_place_t place;
    listed_device_t one;
    args->about.devices = list;
    args->names = names_of_devices(state, list);
    args->wiring.names = args->scenario.names = args->names;
    read_all_later(args, state);
    add_short_faults(args, state);
    char *copy = strdup(list);
    char *rest = copy;
    while (listed_device_next(state, &rest, &one)) {
        const char *network = network_path(one.device);
        if (network && one.count > 1)
            argp_error(state, "a count is for one device, and eni:%s is a bus: write it once", network);
        if (network && rest)
            argp_error(state, "no device follows behind eni:%s, a bus of any length: put that last", network);
        if (network)
            add_network(args, state, network);
        for (size_t i = 0; i < one.count && !network; i++)
            add_twin(args, state, one.device);
    }
    free(copy);
    check_files(args, state);
    apply_identities(args, state);
    if (ect_scenario_highest_slave(&args->scenario) > args->count)
        argp_error(bus_place_at(&place, state, args->farthest), "a fault names slave %u, but the chain has %zu",
                   ect_scenario_highest_slave(&args->scenario), args->count);
    wiring_args_apply(&args->wiring, state, args->twins, args->count, args->scenario.seed);
}

/* --- power-on ----------------------------------------------------------------------------------------------------- */

static bool outlasts_power(const ect_signal_ref_t *ref)
{
    const uint8_t *instance = ref->instance;
    return (size_t)(ref->value - instance) - ref->plant->outside_offset < ref->plant->outside_size;
}

/* A setting of one twin, split at '='. */
typedef struct named {
    char name[ECT_SIGNAL_NAME];
    const char *value;
} named_t;

/* Splits a setting. @return false: of another twin */
static bool take_apart(const twin_args_t *args, const char *setting, size_t slave, named_t *named)
{
    if (twin_of(args->names, &setting, 1) != slave)
        return false;
    const char *value = strchr(setting, '=');
    snprintf(named->name, sizeof named->name, "%.*s", (int)(value - setting), setting);
    named->value = value + 1;
    return true;
}

static bool is_outside(const ect_chain_t *chain, size_t slave, const char *name)
{
    ect_signal_ref_t ref;
    return ect_chain_signal(chain, slave - 1, name, &ref) && outlasts_power(&ref);
}

/* @return the value of the setting that a message is about, whose text is that of the option; NULL: about none */
static const char *refused_of(const ect_chain_t *chain, size_t position, const ect_setting_t *settings, size_t count,
                              const char *message)
{
    char why[ECT_SIGNAL_MESSAGE];
    ect_setting_place_t place;
    for (size_t i = 0; i < count; i++) {
        const ect_setting_t *one = &settings[i];
        if (!ect_settings_find(chain, position, one->name, &place, why) ||
            !ect_signal_check(&place.ref, one->value, why))
            return one->value;
        const size_t length = strlen(place.ref.name);
        if (strncmp(message, place.ref.name, length) == 0 && message[length] == ':') /* the device refuses the value */
            return one->value;
    }
    return NULL;
}

/* Applies the settings of one twin: all, or only those of signals that survive a power cycle. @return false: failure */
static bool apply(const twin_args_t *args, ect_chain_t *chain, size_t slave, bool outside_only, const char *who,
                  uint64_t now_ns)
{
    char message[ECT_SIGNAL_MESSAGE] = "out of memory";
    named_t *named = calloc(args->setting_count, sizeof *named);
    ect_setting_t *settings = calloc(args->setting_count, sizeof *settings);
    size_t count = 0;
    for (size_t i = 0; named && settings && i < args->setting_count; i++) {
        named_t *one = &named[count];
        if (!take_apart(args, args->settings[i], slave, one) || (outside_only && !is_outside(chain, slave, one->name)))
            continue;
        settings[count++] = (ect_setting_t){.name = one->name, .value = one->value};
    }
    bool done = named && settings && ect_settings_apply(chain, slave - 1, settings, count, now_ns, message);
    if (!done)
        twin_args_report_option(args, who,
                                settings && count > 0 ? refused_of(chain, slave - 1, settings, count, message) : NULL,
                                "--set: %s", message);
    free(named);
    free(settings);
    return done;
}

static bool all_for_a_twin(const twin_args_t *args, const char *who)
{
    for (size_t i = 0; i < args->setting_count; i++) {
        const char *setting = args->settings[i];
        size_t slave = twin_of(args->names, &setting, 1);
        if (slave < 1 || slave > args->count) {
            twin_args_report_option(args, who, setting,
                                    "--set %.80s: twins are counted from 1 to the number of devices",
                                    args->settings[i]);
            return false;
        }
    }
    return true;
}

/* Sets first the surroundings, which devices read at power-on, then all signals. */
static bool apply_all(const twin_args_t *args, ect_chain_t *chain, const char *who, uint64_t now_ns)
{
    if (!all_for_a_twin(args, who))
        return false;
    for (unsigned int round = 0; round < 2 && args->setting_count > 0; round++) {
        for (size_t slave = 1; slave <= args->count; slave++) {
            if (!apply(args, chain, slave, round == 0, who, now_ns))
                return false;
        }
        if (round == 0)
            ect_chain_power_cycle(chain, now_ns);
    }
    return true;
}

static bool connect_all(const twin_args_t *args, ect_chain_t *chain, const char *who)
{
    char message[CONNECT_MESSAGE];
    size_t wrong;
    if (!connect_args_apply(chain, args->connections, args->connection_count, &wrong, message)) {
        twin_args_report_option(args, who, args->connection_count > 0 ? args->connections[wrong] : NULL, "%s", message);
        return false;
    }
    if (panel_args_check(chain, args->about.panel, message))
        return true;
    twin_args_report_option(args, who, args->about.panel, "%s", message);
    return false;
}

static bool name_all(const twin_args_t *args, ect_chain_t *chain, const char *who)
{
    char message[ECT_SIGNAL_MESSAGE], place[BUS_PLACE];
    if (ect_chain_set_names(chain, args->names, message))
        return true;
    const char *name = strchr(message, '\'') ? strchr(message, '\'') + 1 : ""; /* the first word in quotes */
    const size_t twin = ect_names_find(args->names, name, strcspn(name, "'"));
    twin_args_report(args, who, "%s%s", bus_place_of_twin(place, twin), message);
    return false;
}

/* @return the option with a step of the script */
static const char *option_of_step(const twin_args_t *args, const ect_scenario_step_t *step)
{
    const size_t index = (size_t)(step - args->scenario.steps);
    for (size_t i = 0; i < args->later_count; i++) {
        if (args->later[i].steps > index)
            return args->later[i].text;
    }
    return NULL;
}

/* @return the n-th --play, from 0 */
static const char *option_of_table(const twin_args_t *args, size_t n)
{
    for (size_t i = 0; i < args->later_count; i++) {
        if (args->later[i].key == KEY_PLAY && n-- == 0)
            return args->later[i].text;
    }
    return NULL;
}

/* Reports wrong names and values of a script at power-on, not at the time of the step. */
static bool check_scenario(const twin_args_t *args, const ect_chain_t *chain, const char *who)
{
    char message[ECT_STEP_MESSAGE];
    const ect_scenario_step_t *step = ect_scenario_check(&args->scenario, chain, message);
    if (step)
        twin_args_report_option(args, who, option_of_step(args, step), "'%s': %s", step->text, message);
    size_t n = 0;
    for (const ect_table_t *table = args->scenario.tables; table && !step; table = table->next, n++) {
        if (ect_table_check(table, chain, message))
            continue;
        twin_args_report_option(args, who, option_of_table(args, n), "--play: %s", message);
        return false;
    }
    return !step;
}

int twin_args_power_on(twin_args_t *args, const char *who, uint64_t now_ns, ect_chain_t **chain)
{
    char message[EOE_MESSAGE];
    *chain = NULL;
    args->power_on_ns = now_ns;
    if (!twin_storage_open(args, who))
        return EXIT_OPEN;
    if (!eoe_args_join(&args->eoe, args->names, args->twins, args->count, message)) {
        twin_args_report_option(args, who, args->eoe.wrong, "%s", message);
        return EXIT_USAGE;
    }
    *chain = ect_chain_new(args->twins, args->count, now_ns);
    if (!*chain) {
        twin_args_report(args, who, "not enough memory for %zu twins", args->count);
        return EXIT_RUN;
    }
    if (name_all(args, *chain, who) && apply_all(args, *chain, who, now_ns) && connect_all(args, *chain, who) &&
        check_scenario(args, *chain, who))
        return EXIT_CLEAN;
    ect_chain_free(*chain);
    *chain = NULL;
    return EXIT_USAGE;
}

void twin_args_free(twin_args_t *args)
{
    for (size_t i = 0; args->memories && i < args->count; i++)
        ect_memory_close(args->memories[i]);
    free(args->memories);
    for (size_t i = 0; args->eeproms && i < args->count; i++)
        ect_eeprom_close(args->eeproms[i]);
    free(args->eeproms);
    for (size_t i = 0; args->opened && i < args->count; i++)
        ect_files_close(args->opened[i]);
    free(args->opened);
    content_free(&args->content);
    ect_table_free(args->scenario.tables);
    args->scenario.tables = NULL;
    ect_names_free(args->names);
    args->names = NULL;
    free(args->joined);
    args->joined = NULL;
    free(args->later);
    free(args->settings);
    free(args->identities);
    wiring_args_free(&args->wiring);
    eoe_args_free(&args->eoe);
    free(args->modules);
    free(args->behaviours);
    free(args->connections);
    free(args->twins);
    args->twins = NULL;
}
