/* SPDX-License-Identifier: MIT */
/*
 * ectwin-conform: does the slave on this wire do what an EtherCAT slave must? Numbered cases, each with its evidence.
 *
 * This file is MIT; the program is linked with SOEM and as a binary covered by SOEM's licence, GPL-2.0 with an
 * exception.
 */
#define _GNU_SOURCE
#include <argp.h>
#include <errno.h>
#include <fnmatch.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "catalogue.h"
#include "probe.h"
#include "report/report.h"
#include "runner.h"
#include "steps/esi.h"

enum { EXIT_CLEAN = 0, EXIT_FAILED = 1, EXIT_NOTHING = 2, EXIT_USAGE = 64, EXIT_INTERRUPTED = 130 };
enum {
    OPTION_ONLY = 256,
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
    OPTION_FILE,
    OPTION_PASSWORD
};
enum { PROBE_MS = 60000, MOST_SECONDS = 3000 };

typedef struct args {
    const char *iface, *only, *skip, *output, *pcap, *esi, *schema, *power, *file;
    unsigned long slave, seconds, seed, password;
    uint32_t asked; /* of CF_ON_REQUEST */
    cf_report_t report;
    bool list, destructive, whole, emulated;
} args_t;

static const struct argp_option options[] = {
    {"interface", 'i', "IFACE", 0, "The network interface that the slave is on", 0},
    {"slave", OPTION_SLAVE, "N", 0, "Which slave of the segment, from 1; default 1", 0},
    {"esi", OPTION_ESI, "FILE[#TYPE]", 0,
     "Compare the slave with its ESI file too; without #TYPE with the device of its product code and revision", 0},
    {"schema", OPTION_SCHEMA, "FILE.xsd", 0, "Validate the ESI file against the ETG's EtherCATInfo.xsd", 0},
    {"only", OPTION_ONLY, "IDS", 0, "Run these cases only: CF-033,CF-04*", 0},
    {"skip", OPTION_SKIP, "IDS", 0, "Leave these cases out", 0},
    {"list", OPTION_LIST, NULL, 0, "List the cases (with --only, --skip: those chosen) and end", 0},
    {"format", OPTION_FORMAT, "FORMAT", 0, "text (default), json, junit or html", 0},
    {"output", 'o', "FILE", 0, "Write the report to FILE instead of standard output", 0},
    {"pcap", OPTION_PCAP, "FILE", 0, "Write the whole exchange to FILE (pcapng, for Wireshark)", 0},
    {"destructive", OPTION_DESTRUCTIVE, NULL, 0,
     "Also run cases that write the EEPROM or firmware; they put back what was there", 0},
    {"power", OPTION_POWER, "COMMAND", 0, "A shell command that switches the slave off and on, for cases that need it",
     0},
    {"file", OPTION_FILE, "NAME", 0,
     "A file that may be read by FoE, and with --destructive written and put back; for CF-084", 0},
    {"password", OPTION_PASSWORD, "N", 0, "What the slave wants for it, 1..4294967295", 0},
    {"long", OPTION_LONG, NULL, 0, "Do what takes long in full: an hour without a master, a million frames", 0},
    {"emulated", OPTION_EMULATED, NULL, 0,
     "The slave's processor is emulated and its time is not ours: skip cases that need real time", 0},
    {"stress", OPTION_STRESS, "SECONDS", OPTION_ARG_OPTIONAL,
     "Also SDO traffic, process data and changes of state at once, 10 s or so long", 1},
    {"fuzz", OPTION_FUZZ, "SECONDS", OPTION_ARG_OPTIONAL, "Also malformed mails and frames, 10 s or so long", 1},
    {"timing", OPTION_TIMING, NULL, 0, "Also measure how long things take, as histograms", 1},
    {"seed", OPTION_SEED, "N", 0, "What is random begins here; default 1", 1},
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

static bool chosen(const args_t *args, const cf_case_t *entry)
{
    if ((entry->needs & CF_ON_REQUEST & ~args->asked) != 0)
        return false;
    return (!args->only || matches(args->only, entry->id)) && (!args->skip || !matches(args->skip, entry->id));
}

static size_t count_chosen(const args_t *args)
{
    size_t count = 0;
    for (size_t s = 0; s < cf_catalogue_count; s++) {
        for (size_t i = 0; i < cf_catalogue[s]->count; i++)
            count += chosen(args, &cf_catalogue[s]->cases[i]);
    }
    return count;
}

static unsigned long number(struct argp_state *state, const char *option, const char *text, unsigned long most)
{
    char *end;
    errno = 0;
    unsigned long value = strtoul(text, &end, 10);
    if (*text < '0' || *text > '9' || *end != 0 || errno != 0 || value == 0 || value > most)
        argp_error(state, "%s takes a number from 1 to %lu; got '%s'", option, most, text);
    return value;
}

/* A case that is there on request, and the seconds that it takes. */
static void ask(struct argp_state *state, args_t *args, uint32_t what, const char *seconds)
{
    args->asked |= what;
    if (seconds)
        args->seconds = number(state, what == CF_STRESS ? "--stress" : "--fuzz", seconds, MOST_SECONDS);
}

static void check(struct argp_state *state, const args_t *args)
{
    if (!args->iface && !args->list)
        argp_error(state, "name the interface with -i IFACE; 'ip -br link' lists those there are");
    if (count_chosen(args) == 0)
        argp_error(state, "no case is left to run: --list shows their ids");
    if (args->schema && !args->esi)
        argp_error(state, "--schema validates an ESI file: name it with --esi FILE");
}

/* Those about what is tried, and with what it is compared. @return whether it was one of them */
static bool parse_more(int key, char *text, struct argp_state *state)
{
    args_t *args = state->input;
    switch (key) {
    case OPTION_ESI:
        args->esi = text;
        return true;
    case OPTION_SCHEMA:
        args->schema = text;
        return true;
    case OPTION_DESTRUCTIVE:
        args->destructive = true;
        return true;
    case OPTION_LONG:
        args->whole = true;
        return true;
    case OPTION_EMULATED:
        args->emulated = true;
        return true;
    case OPTION_POWER:
        args->power = text;
        return true;
    case OPTION_FILE:
        args->file = text;
        return true;
    case OPTION_PASSWORD:
        args->password = number(state, "--password", text, UINT32_MAX);
        return true;
    case OPTION_STRESS:
        ask(state, args, CF_STRESS, text);
        return true;
    case OPTION_FUZZ:
        ask(state, args, CF_FUZZ, text);
        return true;
    case OPTION_TIMING:
        ask(state, args, CF_TIMING, NULL);
        return true;
    case OPTION_SEED:
        args->seed = number(state, "--seed", text, UINT32_MAX);
        return true;
    default:
        return false;
    }
}

static error_t parse(int key, char *text, struct argp_state *state)
{
    args_t *args = state->input;
    switch (key) {
    case 'i':
        args->iface = text;
        return 0;
    case 'o':
        args->output = text;
        return 0;
    case OPTION_ONLY:
        args->only = text;
        return 0;
    case OPTION_SKIP:
        args->skip = text;
        return 0;
    case OPTION_SLAVE:
        args->slave = number(state, "--slave", text, 65535);
        return 0;
    case OPTION_LIST:
        args->list = true;
        return 0;
    case OPTION_FORMAT:
        args->report = find_format(text);
        if (!args->report)
            argp_error(state, "--format is text, json, junit or html; got '%s'", text);
        return 0;
    case OPTION_PCAP:
        args->pcap = text;
        return 0;
    case ARGP_KEY_END:
        check(state, args);
        return 0;
    default:
        return parse_more(key, text, state) ? 0 : ARGP_ERR_UNKNOWN;
    }
}

static void on_signal(int number)
{
    (void)number;
    cf_interrupted = cf_interrupted + 1;
}

static int list(const args_t *args)
{
    for (size_t s = 0; s < cf_catalogue_count; s++) {
        const cf_section_t *section = cf_catalogue[s];
        for (size_t i = 0; i < section->count; i++) {
            if (chosen(args, &section->cases[i]))
                printf("%s  %c  %c  %s\n", section->cases[i].id, section->letter, section->cases[i].class,
                       section->cases[i].title);
        }
    }
    return EXIT_CLEAN;
}

/* --- the run ------------------------------------------------------------------------------------------------------ */

static void progress(const cf_run_t *run, const cf_case_t *entry)
{
    static bool shown;
    if (isatty(STDERR_FILENO) == 0)
        return;
    if (entry)
        fprintf(stderr, "\r\033[K%zu of %zu  %s  %.60s", run->count + 1, run->planned, entry->id, entry->title);
    else if (shown)
        fprintf(stderr, "\r\033[K");
    shown = entry != NULL;
}

/* Probing is a step like a case: it may find a slave that does not answer. */
static bool probe(cf_run_t *run)
{
    cf_engine_t *e = &run->engine;
    cf_record_begin("ectwin-conform", "what the slave has");
    e->limit_ms = PROBE_MS;
    e->deadline_ns = cf_now_ns() + PROBE_MS * UINT64_C(1000000);
    e->running = true;
    if (setjmp(e->leave) == 0)
        cf_probe(&run->c);
    else
        fprintf(stderr, "ectwin-conform: slave %u cannot be examined: %s\n", run->c.facts.position + 1u, e->reason);
    bool done = e->running && e->reason[0] == 0;
    e->running = false;
    cf_evidence_t evidence = cf_record_end(0);
    cf_evidence_free(&evidence);
    return done;
}

static bool find_slave(cf_run_t *run, const args_t *args)
{
    cf_facts_t *f = &run->c.facts;
    f->slaves = cf_scan(&run->c);
    f->position = (uint16_t)(args->slave - 1);
    f->station = (uint16_t)(CF_STATION + f->position);
    f->ring = (uint16_t)-f->position;
    if (f->slaves >= args->slave)
        return probe(run);
    if (f->slaves == 0)
        fprintf(stderr, "ectwin-conform: no slave answers on '%s': is it powered, and its IN port on this cable?\n",
                args->iface);
    else
        fprintf(stderr, "ectwin-conform: there is no slave %lu: %u answer on '%s'\n", args->slave, f->slaves,
                args->iface);
    return false;
}

static void run_cases(cf_run_t *run, const args_t *args)
{
    for (size_t s = 0; s < cf_catalogue_count; s++) {
        const cf_section_t *section = cf_catalogue[s];
        for (size_t i = 0; i < section->count && cf_interrupted == 0; i++) {
            if (!chosen(args, &section->cases[i]))
                continue;
            progress(run, &section->cases[i]);
            cf_run_case(run, section, &section->cases[i], &run->results[run->count]);
            run->count++;
        }
    }
    progress(run, NULL);
}

static FILE *create(const char *path)
{
    FILE *file = fopen(path, "w");
    if (!file)
        fprintf(stderr, "ectwin-conform: cannot write '%s': %s\n", path, strerror(errno));
    return file;
}

static int verdict_of(const cf_run_t *run)
{
    if (cf_interrupted != 0)
        return EXIT_INTERRUPTED;
    return cf_count(run, NULL).of[CF_FAIL] > 0 ? EXIT_FAILED : EXIT_CLEAN;
}

static int report(const args_t *args, const cf_run_t *run)
{
    FILE *to = args->output ? create(args->output) : stdout;
    if (!to)
        return EXIT_NOTHING;
    args->report(to, run);
    bool good = fflush(to) == 0 && ferror(to) == 0;
    if (to != stdout)
        good = fclose(to) == 0 && good;
    if (good)
        return verdict_of(run);
    fprintf(stderr, "ectwin-conform: the report could not be written: %s\n", strerror(errno));
    return EXIT_NOTHING;
}

static void started(cf_run_t *run)
{
    time_t now = time(NULL);
    struct tm local;
    (void)strftime(run->started, sizeof run->started, "%Y-%m-%dT%H:%M:%S", localtime_r(&now, &local));
}

/* Which device of the file it is only the slave can tell. */
static bool choose_device(cf_run_t *run)
{
    char text[CF_ESI_TEXT];
    if (!run->c.esi)
        return true;
    bool chosen = cf_esi_choose(run->c.esi, &run->c.facts, text);
    if (!chosen)
        fprintf(stderr, "ectwin-conform: %s\n", text);
    run->esi = run->c.esi->title;
    return chosen;
}

static int examine(const args_t *args, cf_run_t *run)
{
    uint64_t start_ns = cf_now_ns();
    if (!find_slave(run, args))
        return cf_interrupted != 0 ? EXIT_INTERRUPTED : EXIT_NOTHING;
    if (!choose_device(run))
        return EXIT_NOTHING;
    run_cases(run, args);
    run->duration_ns = cf_now_ns() - start_ns;
    return report(args, run);
}

static int run_all(const args_t *args, cf_esi_t *esi)
{
    static cf_run_t run;
    const char *error = cf_port_open(&run.engine.port, args->iface);
    if (error) {
        fprintf(stderr, "ectwin-conform: cannot open '%s': %s\n", args->iface, error);
        return EXIT_NOTHING;
    }
    FILE *pcap = args->pcap ? create(args->pcap) : NULL;
    if (args->pcap && !pcap) {
        cf_port_close(run.engine.port);
        return EXIT_NOTHING;
    }
    cf_record_open(pcap);
    run.c.engine = &run.engine;
    run.c.esi = esi;
    run.c.destructive = args->destructive;
    run.c.whole = args->whole;
    run.c.emulated = args->emulated;
    run.c.power = args->power;
    run.c.file = args->file;
    run.c.password = (uint32_t)args->password;
    run.c.seconds = (uint32_t)args->seconds;
    run.engine.seed = args->seed;
    run.iface = args->iface;
    run.planned = count_chosen(args);
    run.results = calloc(run.planned, sizeof run.results[0]);
    started(&run);
    int status = run.results ? examine(args, &run) : EXIT_NOTHING;
    for (size_t i = 0; i < run.count; i++)
        cf_evidence_free(&run.results[i].evidence);
    free(run.results);
    for (size_t i = 0; i < run.engine.series_count; i++)
        free(run.engine.series[i].values_ns);
    free((void *)(uintptr_t)run.c.facts.sii);
    cf_port_close(run.engine.port);
    if (pcap && fclose(pcap) != 0)
        fprintf(stderr, "ectwin-conform: the capture could not be written: %s\n", strerror(errno));
    return status;
}

static int run_with_esi(const args_t *args)
{
    static cf_esi_t esi;
    char text[CF_ESI_TEXT];
    int status = EXIT_NOTHING;
    if (!args->esi || cf_esi_open(&esi, args->esi, args->schema, text))
        status = run_all(args, args->esi ? &esi : NULL);
    else
        fprintf(stderr, "ectwin-conform: %s\n", text);
    cf_esi_close(&esi);
    return status;
}

int main(int argc, char **argv)
{
    static const struct argp argp = {
        .options = options,
        .parser = parse,
        .doc =
            "Runs numbered conformance cases against an EtherCAT slave and reports, with the datagrams as evidence. "
            "The "
            "slave is taken through all its states: nothing that moves may be connected to its outputs.\v"
            "Exit codes: 0 all cases pass, warn or are skipped; 1 one fails; 2 no interface, no slave, or a file that "
            "cannot be read or written; 64 wrong usage; 130 interrupted (what ran is reported).",
    };
    const struct sigaction action = {.sa_handler = on_signal};
    args_t args = {.slave = 1, .seconds = 10, .seed = 1, .report = cf_report_text};
    argp_err_exit_status = EXIT_USAGE;
    argp_parse(&argp, argc, argv, ARGP_NO_ARGS, NULL, &args);
    if (args.list)
        return list(&args);
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    return run_with_esi(&args);
}
