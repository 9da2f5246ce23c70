/* SPDX-License-Identifier: MIT */
/*
 * ectwin-conform: numbered conformance cases for an EtherCAT slave, each with its evidence.
 *
 * This file is MIT; the program is linked with SOEM and as a binary covered by SOEM's licence, GPL-2.0 with an
 * exception.
 */
#define _GNU_SOURCE
#include <ctype.h>
#include <errno.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "catalogue.h"
#include "options.h"
#include "probe.h"
#include "runner.h"
#include "sha256.h"
#include "steps/esi.h"

enum { PROBE_MS = 60000, COMMAND = 2000 };

static void on_signal(int number)
{
    (void)number;
    cf_interrupted = cf_interrupted + 1;
}

static int list(const cf_options_t *options)
{
    for (size_t s = 0; s < cf_catalogue_count; s++) {
        const cf_section_t *section = cf_catalogue[s];
        for (size_t i = 0; i < section->count; i++) {
            if (cf_options_select(options, &section->cases[i]))
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

/* Probing has a time limit like a case: the slave may not reply. */
static bool probe(cf_run_t *run)
{
    cf_engine_t *e = &run->engine;
    cf_record_begin("ectwin-conform", "features of the slave");
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

static bool find_slave(cf_run_t *run, const cf_options_t *options)
{
    cf_facts_t *f = &run->c.facts;
    f->slaves = cf_scan(&run->c);
    f->position = (uint16_t)(options->slave - 1);
    f->station = (uint16_t)(CF_STATION + f->position);
    f->ring = (uint16_t)-f->position;
    if (f->slaves >= options->slave)
        return probe(run);
    if (f->slaves == 0)
        fprintf(stderr,
                "ectwin-conform: no slave replies on '%s': switch it on, and connect its IN port to this cable\n",
                options->iface);
    else
        fprintf(stderr, "ectwin-conform: there is no slave %lu: %u replied on '%s'\n", options->slave, f->slaves,
                options->iface);
    return false;
}

static void run_cases(cf_run_t *run, const cf_options_t *options)
{
    for (size_t s = 0; s < cf_catalogue_count; s++) {
        const cf_section_t *section = cf_catalogue[s];
        for (size_t i = 0; i < section->count && cf_interrupted == 0; i++) {
            if (!cf_options_select(options, &section->cases[i]))
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
    const cf_counts_t n = cf_count(run, NULL);
    return n.of[CF_FAIL] + n.of[CF_UNJUDGED] > 0 ? EXIT_FAILED : EXIT_CLEAN;
}

static int report(const cf_options_t *options, const cf_run_t *run)
{
    FILE *to = options->output ? create(options->output) : stdout;
    if (!to)
        return EXIT_NOTHING;
    options->report(to, run);
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

/* The identity of the slave selects the device of the file. */
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

static int examine(const cf_options_t *options, cf_run_t *run)
{
    uint64_t start_ns = cf_now_ns();
    if (!find_slave(run, options))
        return cf_interrupted != 0 ? EXIT_INTERRUPTED : EXIT_NOTHING;
    if (!choose_device(run))
        return EXIT_NOTHING;
    run_cases(run, options);
    run->duration_ns = cf_now_ns() - start_ns;
    return report(options, run);
}

/* Initialises the run from the options. */
static void set_up(cf_run_t *run, const cf_options_t *options, cf_esi_t *esi)
{
    run->c.engine = &run->engine;
    run->c.esi = esi;
    run->c.destructive = options->destructive;
    run->c.whole = options->whole;
    run->c.emulated = options->emulated;
    run->c.power = options->power;
    run->c.plug = options->plug;
    run->c.file = options->file;
    run->c.password = (uint32_t)options->password;
    run->c.move = options->move;
    run->c.seconds = (uint32_t)options->seconds;
    run->engine.seed = options->seed;
    run->iface = options->iface;
    run->operator_ = options->operator_;
    run->firmware = options->firmware;
    run->version = ECTWIN_VERSION;
    run->planned = cf_options_count(options);
    started(run);
}

static void release(cf_run_t *run)
{
    for (size_t i = 0; i < run->count; i++)
        cf_evidence_free(&run->results[i].evidence);
    free(run->results);
    free((void *)(uintptr_t)run->c.facts.sii);
    cf_engine_free(&run->engine);
    cf_record_close();
}

static int run_on_port(const cf_options_t *options, cf_run_t *run)
{
    FILE *pcap = options->pcap ? create(options->pcap) : NULL;
    if (options->pcap && !pcap)
        return EXIT_NOTHING;
    cf_record_open(pcap);
    run->results = calloc(run->planned, sizeof run->results[0]);
    int status = run->results ? examine(options, run) : EXIT_NOTHING;
    release(run);
    if (pcap && fclose(pcap) != 0)
        fprintf(stderr, "ectwin-conform: the capture could not be written: %s\n", strerror(errno));
    return status;
}

static int run_all(const cf_options_t *options, cf_run_t *run, cf_esi_t *esi)
{
    set_up(run, options, esi);
    const char *error = cf_port_open(&run->engine.port, options->iface);
    if (error) {
        fprintf(stderr, "ectwin-conform: cannot open '%s': %s\n", options->iface, error);
        return EXIT_NOTHING;
    }
    int status = run_on_port(options, run);
    cf_port_close(run->engine.port);
    return status;
}

static void hash_esi(cf_run_t *run, const cf_esi_t *esi)
{
    FILE *file = fopen(esi->path, "rb");
    if (!file)
        return;
    cf_sha256(file, run->esi_hash);
    (void)fclose(file);
}

static int run_with_esi(const cf_options_t *options, cf_run_t *run)
{
    static cf_esi_t esi;
    char text[CF_ESI_TEXT];
    int status = EXIT_NOTHING;
    if (!options->esi) {
        status = run_all(options, run, NULL);
    } else if (cf_esi_open(&esi, options->esi, options->schema, text)) {
        hash_esi(run, &esi);
        status = run_all(options, run, &esi);
    } else {
        fprintf(stderr, "ectwin-conform: %s\n", text);
    }
    cf_esi_close(&esi);
    return status;
}

/* --- the process -------------------------------------------------------------------------------------------------- */

static void add(char *line, const char *text)
{
    size_t used = strlen(line);
    snprintf(line + used, COMMAND - used, "%s", text);
}

static bool is_plain(const char *word)
{
    for (const char *at = word; *at != 0; at++) {
        if (!isalnum((unsigned char)*at) && !strchr("-_./=:,%+@", *at))
            return false;
    }
    return word[0] != 0;
}

static void add_quoted(char *line, const char *word)
{
    add(line, "'");
    for (const char *at = word; *at != 0; at++)
        add(line, *at == '\'' ? "'\\''" : (const char[]){*at, 0});
    add(line, "'");
}

/* The command line, quoted for a shell. */
static void join(char line[COMMAND], int argc, char **argv)
{
    line[0] = 0;
    for (int i = 0; i < argc; i++) {
        add(line, i > 0 ? " " : "");
        if (is_plain(argv[i]))
            add(line, argv[i]);
        else
            add_quoted(line, argv[i]);
    }
}

/* Reports lost output (a full disk) as a failure, of --help and --list too. EPIPE is none: the reader needs no more. */
static void check_output(void)
{
    errno = 0;
    if ((ferror(stdout) == 0 && fflush(stdout) == 0) || errno == EPIPE)
        return;
    fprintf(stderr, "ectwin-conform: cannot write to standard output: %s\n",
            errno != 0 ? strerror(errno) : "an earlier write failed");
    _exit(EXIT_NOTHING);
}

/* Buffers short output, as --help and --list, until the end, where a failure is reported. */
static void keep_output_together(void)
{
    static char room[16384];
    if (isatty(STDOUT_FILENO) == 0)
        (void)setvbuf(stdout, room, _IOFBF, sizeof room);
}

/* Runs this program again with twins in its process; the environment then names their interface. Returns on failure
 * only. */
static int restart_with_twins(const cf_options_t *options, int argc, char **argv)
{
    static char self[PATH_MAX], ectwin[PATH_MAX + 8];
    static char *const first[] = {ectwin, "with", "--in-process", "--virtual-time"};
    enum { FIRST = sizeof first / sizeof first[0] };
    char **words = calloc(FIRST + (size_t)argc + 3, sizeof *words);
    ssize_t length = readlink("/proc/self/exe", self, sizeof self - 1);
    if (!words || length <= 0) {
        fprintf(stderr, "ectwin-conform: cannot restart itself: %s\n", strerror(errno));
        return EXIT_NOTHING;
    }
    snprintf(ectwin, sizeof ectwin, "%.*sectwin", (int)(strrchr(self, '/') - self + 1), self);
    memcpy(words, first, sizeof first);
    words[FIRST] = (char *)(uintptr_t)options->in_process;
    words[FIRST + 1] = "--";
    words[FIRST + 2] = self;
    memcpy(words + FIRST + 3, argv + 1, ((size_t)argc - 1) * sizeof *words);
    execv(ectwin, words);
    fprintf(stderr, "ectwin-conform: cannot run '%s', which --in-process needs: %s; install ectwin again\n", ectwin,
            strerror(errno));
    free(words);
    return EXIT_NOTHING;
}

int main(int argc, char **argv)
{
    static cf_run_t run;
    static char command[COMMAND];
    const struct sigaction action = {.sa_handler = on_signal};
    cf_options_t options;
    keep_output_together();
    if (atexit(check_output) != 0)
        return EXIT_NOTHING;
    cf_options_parse(&options, argc, argv);
    if (options.list)
        return list(&options);
    if (options.in_process && !getenv("ECTWIN_INPROCESS"))
        return restart_with_twins(&options, argc, argv);
    if (options.in_process)
        options.iface = getenv("ECTWIN_IFACE");
    join(command, argc, argv);
    run.command = command;
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    return run_with_esi(&options, &run);
}
