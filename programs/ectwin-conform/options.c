/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "options.h"

#include <argp.h>
#include <errno.h>
#include <fnmatch.h>
#include <stdlib.h>
#include <string.h>

#include "catalogue.h"
#include "text/argument.h"

enum {
    OPTION_ONLY = 256,
    OPTION_IN_PROCESS,
    OPTION_SKIP,
    OPTION_SLAVE,
    OPTION_ESI,
    OPTION_SCHEMA,
    OPTION_LIST,
    OPTION_FORMAT,
    OPTION_PCAP,
    OPTION_DESTRUCTIVE,
    OPTION_STRESS,
    OPTION_FUZZ,
    OPTION_TIMING,
    OPTION_SEED,
    OPTION_LONG,
    OPTION_EMULATED,
    OPTION_POWER,
    OPTION_PLUG,
    OPTION_FILE,
    OPTION_PASSWORD,
    OPTION_MOVE,
    OPTION_OPERATOR,
    OPTION_FIRMWARE
};
enum { MOST_SECONDS = 3000, DEFAULT_SECONDS = 10 };

static const struct argp_option options_[] = {
    {"interface", 'i', "IFACE", 0, "Network interface that the slave is connected to", 0},
    {"in-process", OPTION_IN_PROCESS, "DEVICE[,...]", 0,
     "In place of -i: judge twins in this process, on a virtual clock, without a network. 'ectwin list' lists the "
     "devices",
     0},
    {"slave", OPTION_SLAVE, "N", 0, "Position of the slave on the segment, from 1 (default 1)", 0},
    {"esi", OPTION_ESI, "FILE[#TYPE]", 0,
     "Compare the slave with its ESI file; without #TYPE, with the device of its product code and revision", 0},
    {"schema", OPTION_SCHEMA, "FILE.xsd", 0, "Validate the ESI file of --esi against the ETG's EtherCATInfo.xsd", 0},
    {"only", OPTION_ONLY, "IDS", 0, "Run only the cases that match these patterns: CF-033,CF-04*", 0},
    {"skip", OPTION_SKIP, "IDS", 0, "Skip the cases that match these patterns: CF-033,CF-04*", 0},
    {"list", OPTION_LIST, NULL, 0, "List the selected cases and exit", 0},
    {"format", OPTION_FORMAT, "FORMAT", 0, "Format of the report: text (default), json, junit or html", 0},
    {"output", 'o', "FILE", 0, "Write the report to FILE (default: standard output)", 0},
    {"operator", OPTION_OPERATOR, "NAME", 0, "Name of the operator for the HTML and JSON report", 0},
    {"firmware", OPTION_FIRMWARE, "VERSION", 0, "Firmware version of the slave for the HTML and JSON report", 0},
    {"pcap", OPTION_PCAP, "FILE", 0, "Record all frames to FILE (pcapng, for Wireshark)", 0},
    {"destructive", OPTION_DESTRUCTIVE, NULL, 0,
     "Run the cases that write the EEPROM or a file too; they restore the previous content", 0},
    {"power", OPTION_POWER, "COMMAND", 0,
     "Shell command that switches the slave off and on, for cases that need a power cycle", 0},
    {"plug", OPTION_PLUG, "COMMAND", 0,
     "Shell command that pulls and reinserts the slave's plug on the PC's side, for CF-096", 0},
    {"file", OPTION_FILE, "NAME", 0,
     "Name of a file that CF-084 reads by FoE, and with --destructive also writes and restores", 0},
    {"password", OPTION_PASSWORD, "N", 0, "FoE password of the file of --file, 1..4294967295 (default: none)", 0},
    {"move", OPTION_MOVE, "DISTANCE,SPEED,ACCELERATION", 0,
     "Run the cases that enable each axis of a CiA 402 drive and turn it (CF-D05 to CF-D17): up to DISTANCE from its "
     "place, each way, at SPEED with ACCELERATION, in the drive's units of 607Ah, 60FFh and 6083h. A case of homing "
     "sets the reference position. A torque-free axis coasts. Remove loads that may fall, secure the machine",
     0},
    {"long", OPTION_LONG, NULL, 0,
     "Run long procedures in full: an hour without a master (CF-049), a million frames (CF-094)", 0},
    {"emulated", OPTION_EMULATED, NULL, 0,
     "Skip cases that need real time, because the processor of the slave is emulated", 0},
    {"stress", OPTION_STRESS, "SECONDS", OPTION_ARG_OPTIONAL,
     "Add the case STRESS: SDO transfers, process data and state changes at once (default 10 s)", 1},
    {"fuzz", OPTION_FUZZ, "SECONDS", OPTION_ARG_OPTIONAL,
     "Add the case FUZZ: malformed mails and frames (default 10 s)", 1},
    {"timing", OPTION_TIMING, NULL, 0, "Add the case TIMING: histograms of round trips, state changes and process data",
     1},
    {"seed", OPTION_SEED, "N", 0, "Seed of the random generator of CF-094, STRESS and FUZZ, from 1 (default 1)", 1},
    {0},
};

static cf_report_t find_format(const char *name)
{
    static const struct {
        const char *name;
        cf_report_t report;
    } formats[] = {
        {"text", cf_report_text}, {"json", cf_report_json}, {"junit", cf_report_junit}, {"html", cf_report_html}};
    for (size_t i = 0; i < sizeof formats / sizeof formats[0]; i++) {
        if (strcmp(formats[i].name, name) == 0)
            return formats[i].report;
    }
    return NULL;
}

/* Whether an id matches one of the patterns, separated by commas. */
static bool matches(const char *patterns, const char *id)
{
    char pattern[64];
    for (const char *at = patterns; *at != 0;) {
        size_t length = strcspn(at, ",");
        snprintf(pattern, sizeof pattern, "%.*s", (int)length, at);
        if (fnmatch(pattern, id, 0) == 0)
            return true;
        at += length + (at[length] == ',');
    }
    return false;
}

bool cf_options_select(const cf_options_t *options, const cf_case_t *entry)
{
    if ((entry->needs & CF_ON_REQUEST & ~options->requested) != 0)
        return false;
    return (!options->only || matches(options->only, entry->id)) &&
           (!options->skip || !matches(options->skip, entry->id));
}

size_t cf_options_count(const cf_options_t *options)
{
    size_t count = 0;
    for (size_t s = 0; s < cf_catalogue_count; s++) {
        for (size_t i = 0; i < cf_catalogue[s]->count; i++)
            count += cf_options_select(options, &cf_catalogue[s]->cases[i]);
    }
    return count;
}

static unsigned long number(struct argp_state *state, const char *option, const char *text, unsigned long most)
{
    return (unsigned long)ect_argument_number(state, option, text, 1, most);
}

static void request(struct argp_state *state, uint32_t what, const char *seconds)
{
    cf_options_t *options = state->input;
    options->requested |= what;
    if (seconds)
        options->seconds = number(state, what == CF_STRESS ? "--stress" : "--fuzz", seconds, MOST_SECONDS);
}

static void check(struct argp_state *state, const cf_options_t *options)
{
    if (!options->iface && !options->in_process && !options->list)
        argp_error(state, "name the interface with -i IFACE; 'ip -br link' lists all interfaces");
    if (options->iface && options->in_process)
        argp_error(state, "-i and --in-process exclude each other: give one of them");
    if (cf_options_count(options) == 0)
        argp_error(state, "no case is selected: --list without --only and --skip shows all ids");
    if (options->schema && !options->esi)
        argp_error(state, "--schema validates an ESI file: name it with --esi FILE");
}

/* @return where an option stores its text; NULL: another kind of option */
static const char **text_option(cf_options_t *options, int key)
{
    const struct {
        int key;
        const char **place;
    } table[] = {{'i', &options->iface},
                 {'o', &options->output},
                 {OPTION_IN_PROCESS, &options->in_process},
                 {OPTION_ONLY, &options->only},
                 {OPTION_SKIP, &options->skip},
                 {OPTION_PCAP, &options->pcap},
                 {OPTION_ESI, &options->esi},
                 {OPTION_SCHEMA, &options->schema},
                 {OPTION_POWER, &options->power},
                 {OPTION_PLUG, &options->plug},
                 {OPTION_FILE, &options->file},
                 {OPTION_OPERATOR, &options->operator_},
                 {OPTION_FIRMWARE, &options->firmware}};
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        if (table[i].key == key)
            return table[i].place;
    }
    return NULL;
}

static bool *flag_option(cf_options_t *options, int key)
{
    switch (key) {
    case OPTION_LIST:
        return &options->list;
    case OPTION_DESTRUCTIVE:
        return &options->destructive;
    case OPTION_LONG:
        return &options->whole;
    case OPTION_EMULATED:
        return &options->emulated;
    default:
        return NULL;
    }
}

/* Three numbers from 1 to 2^31 - 1, separated by commas. */
static void read_move(struct argp_state *state, cf_move_t *move, const char *text)
{
    int64_t *const values[] = {&move->distance, &move->speed, &move->acceleration};
    enum { COUNT = sizeof values / sizeof values[0] };
    const char *at = text;
    for (size_t i = 0; i < COUNT; i++) {
        char number_[16];
        const size_t length = strcspn(at, ",");
        if (length >= sizeof number_ || (at[length] == ',') != (i + 1 < COUNT))
            argp_error(state, "--move takes three numbers, DISTANCE,SPEED,ACCELERATION; got '%s'", text);
        snprintf(number_, sizeof number_, "%.*s", (int)length, at);
        *values[i] = (int64_t)number(state, "--move", number_, INT32_MAX);
        at += length + 1;
    }
}

static error_t parse_value(int key, char *text, struct argp_state *state)
{
    cf_options_t *options = state->input;
    switch (key) {
    case OPTION_SLAVE:
        options->slave = number(state, "--slave", text, UINT16_MAX);
        return 0;
    case OPTION_MOVE:
        read_move(state, &options->move, text);
        return 0;
    case OPTION_PASSWORD:
        options->password = number(state, "--password", text, UINT32_MAX);
        return 0;
    case OPTION_SEED:
        options->seed = number(state, "--seed", text, UINT32_MAX);
        return 0;
    case OPTION_STRESS:
        request(state, CF_STRESS, text);
        return 0;
    case OPTION_FUZZ:
        request(state, CF_FUZZ, text);
        return 0;
    case OPTION_TIMING:
        request(state, CF_TIMING, NULL);
        return 0;
    case OPTION_FORMAT:
        options->report = find_format(text);
        if (!options->report)
            argp_error(state, "--format is text, json, junit or html; got '%s'", text);
        return 0;
    case ARGP_KEY_END:
        check(state, options);
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static error_t parse(int key, char *text, struct argp_state *state)
{
    const char **place = text_option(state->input, key);
    bool *flag = flag_option(state->input, key);
    if (place)
        *place = text;
    else if (flag)
        *flag = true;
    else
        return parse_value(key, text, state);
    return 0;
}

void cf_options_parse(cf_options_t *options, int argc, char **argv)
{
    static const struct argp argp = {
        .options = options_,
        .parser = parse,
        .doc = "Runs numbered conformance cases against an EtherCAT slave and reports the verdicts with the datagrams "
               "as evidence. The slave passes through all its states: disconnect actuators first. Without --move no "
               "axis of a drive is enabled.\v"
               "Exit codes: 0 all cases pass, warn or are skipped; 1 a case fails or is not judged; 2 no interface, no "
               "slave, or a file that cannot be read or written; 64 wrong usage; 130 interrupted, with a report of the "
               "cases that ran.",
    };
    *options = (cf_options_t){.slave = 1, .seconds = DEFAULT_SECONDS, .seed = 1, .report = cf_report_text};
    argp_err_exit_status = EXIT_USAGE;
    argp_program_version = "ectwin-conform " ECTWIN_VERSION;
    argp_parse(&argp, argc, argv, ARGP_NO_ARGS, NULL, options);
}
