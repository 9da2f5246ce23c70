/* SPDX-License-Identifier: MIT */
/* The option --eoe: the network of each twin, the hosts that are opened, and the lines about failures. Networks and
 * hosts are replaced. */
#define _GNU_SOURCE
#include "eoe_args.h"

#include <errno.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "support/testdev.h"

enum { TWINS = 3, OPTIONS = 3, LOG = 256 };

/* Calls, in order: a letter for each network and its twin's device, each host and each end. */
static struct {
    char text[LOG];
    unsigned int networks, hosts; /* calls */
    unsigned int fails_at;        /* the number of the call that fails, from 1; 0: none */
    int no_hosts;                 /* errno of ect_hosts_new; 0: succeeds */
} calls;

static void put(const char *format, ...)
{
    const size_t used = strlen(calls.text);
    va_list values;
    va_start(values, format);
    (void)vsnprintf(calls.text + used, sizeof calls.text - used, format, values);
    va_end(values);
}

ect_network_t *__real_ect_network_new(const ect_device_t *device, ect_network_kind_t kind);
ect_network_t *__wrap_ect_network_new(const ect_device_t *device, ect_network_kind_t kind);
ect_hosts_t *__wrap_ect_hosts_new(void);
const char *__wrap_ect_hosts_open(ect_hosts_t *hosts, const char *place, ect_network_t *network, size_t position,
                                  char *message);
void __wrap_ect_hosts_close(ect_hosts_t *hosts);

ect_network_t *__wrap_ect_network_new(const ect_device_t *device, ect_network_kind_t kind)
{
    static const char *const kinds[] = {
        [ECT_NETWORK_OWN] = "own", [ECT_NETWORK_ECHO] = "echo", [ECT_NETWORK_HOST] = "host"};
    put(" %s", kinds[kind]);
    return ++calls.networks == calls.fails_at ? NULL : __real_ect_network_new(device, kind);
}

static char some_hosts;

ect_hosts_t *__wrap_ect_hosts_new(void)
{
    put(" new");
    errno = calls.no_hosts;
    return calls.no_hosts != 0 ? NULL : (ect_hosts_t *)&some_hosts;
}

/* The name of a TAP is the place; that of a socket is its path. */
const char *__wrap_ect_hosts_open(ect_hosts_t *hosts, const char *place, ect_network_t *network, size_t position,
                                  char *message)
{
    assert_ptr_equal(hosts, &some_hosts);
    assert_non_null(network);
    put(" %s at %zu", place, position);
    (void)snprintf(message, ECT_PLACE_MESSAGE, "'%s' is taken", place);
    return ++calls.hosts == calls.fails_at ? NULL : place;
}

void __wrap_ect_hosts_close(ect_hosts_t *hosts)
{
    assert_ptr_equal(hosts, &some_hosts);
    put(" close");
}

static const ect_eoe_t eoe = {ECT_EOE_PROTOCOL, .ports = 1};
static const ect_protocol_t *protocols[TESTDEV_PROTOCOLS];
static ect_device_t with_eoe; /* the test device with EoE */

static int setup(void **state)
{
    (void)state;
    with_eoe = testdev_with(&eoe.protocol, protocols, ECT_MAILBOX_EOE, sizeof(testdev_t));
    return 0;
}

/* A row: options, and a letter for each twin: e with EoE, - without. */
typedef struct row {
    const char *options[OPTIONS + 1];
    const char *twins;
    bool alone; /* the command opens no TAPs and sockets */
    unsigned int fails_at;
    const char *calls;
    const char *message; /* NULL: success */
    const char *wrong;   /* the option at fault; NULL: as the message implies, none */
} row_t;

static void read_options(const row_t *row, eoe_args_t *args)
{
    char *words[2 * OPTIONS + 2] = {(char *)"ectwin run"};
    int count = 1;
    for (unsigned int i = 0; row->options[i]; i++) {
        words[count++] = (char *)"--eoe";
        words[count++] = (char *)row->options[i];
    }
    memset(&calls, 0, sizeof calls);
    calls.fails_at = row->fails_at;
    args->has_hosts = !row->alone;
    assert_int_equal(argp_parse(&eoe_argp, count, words, 0, NULL, args), 0);
}

/* Joins the networks of a row to its twins, of which the third has the name "gate". */
static bool join(const row_t *row, eoe_args_t *args, ect_twin_config_t twins[TWINS], char *message)
{
    const size_t count = strlen(row->twins);
    ect_names_t *names = ect_names_new(TWINS);
    assert_non_null(names);
    assert_true(ect_names_add(names, 2, "gate"));
    for (size_t i = 0; i < count; i++)
        twins[i] = ect_twin_default(row->twins[i] == 'e' ? &with_eoe : &testdev, NULL);
    const bool done = eoe_args_join(args, names, twins, count, message);
    ect_names_free(names);
    return done;
}

static void networks_of_twins(void **state)
{
    static const row_t rows[] = {
        {.twins = "---", .calls = ""},
        {.twins = "e-e", .calls = " own own"},
        {.options = {"echo"}, .twins = "e-e", .calls = " echo own"},
        {.options = {"echo"}, .twins = "--e", .calls = " echo"},
        {.options = {"3:echo"}, .twins = "e-e", .calls = " echo own"},
        {.options = {"gate:tap7"}, .twins = "e-e", .calls = " host own"},
        {.options = {"unix:/s"}, .twins = "-e-", .calls = " host"},
        {.options = {"3:unix:/s", "1:echo"}, .twins = "eee", .calls = " host echo own"},
        {.options = {"1:tap", "2:echo", "gate:tap7"}, .twins = "eee", .calls = " host echo host"},
        {.options = {"echo"}, .twins = "e", .alone = true, .calls = " echo"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        eoe_args_t args = {0};
        ect_twin_config_t twins[TWINS];
        char message[EOE_MESSAGE];
        read_options(&rows[i], &args);
        if (!join(&rows[i], &args, twins, message))
            fail_msg("row %zu: %s", i, message);
        assert_string_equal(calls.text, rows[i].calls);
        for (size_t n = 0; rows[i].twins[n]; n++) { /* each twin with EoE has the signals */
            assert_int_equal(args.networks[n] != NULL, rows[i].twins[n] == 'e');
            assert_ptr_equal(twins[n].beside.plant, rows[i].twins[n] == 'e' ? &ect_network_plant : NULL);
        }
        eoe_args_free(&args);
        assert_int_equal(args.count, 0);
    }
}

static void networks_that_are_refused(void **state)
{
    static const row_t rows[] = {
        {.options = {"echo"},
         .twins = "---",
         .calls = "",
         .message = "--eoe echo: no twin has EoE: take a device whose ESI file has Mailbox/EoE",
         .wrong = "echo"},
        {.options = {"1:echo", "2:tap7"},
         .twins = "e-e",
         .calls = " echo",
         .message = "--eoe 2:tap7: twin 2, testdev, has no EoE: take a device whose ESI file has Mailbox/EoE",
         .wrong = "2:tap7"},
        {.options = {"2:echo"},
         .twins = "e",
         .calls = "",
         .message = "--eoe 2:echo: the chain has 1 twin",
         .wrong = "2:echo"},
        {.options = {"4:echo"},
         .twins = "eee",
         .calls = "",
         .message = "--eoe 4:echo: the chain has 3 twins",
         .wrong = "4:echo"},
        {.options = {"gate:echo"},
         .twins = "ee",
         .calls = "",
         .message = "--eoe gate:echo: the chain has 2 twins",
         .wrong = "gate:echo"},
        {.options = {"axis:echo"},
         .twins = "e",
         .calls = "",
         .message = "--eoe axis:echo: no twin is named 'axis': name it in the list, as axis=DEVICE",
         .wrong = "axis:echo"},
        {.options = {"gate:echo", "3:tap"},
         .twins = "eee",
         .calls = " echo",
         .message = "--eoe 3:tap: twin 3 has a network already: leave one of the two out",
         .wrong = "3:tap"},
        {.options = {"echo", "tap"},
         .twins = "ee",
         .calls = " echo",
         .message = "--eoe tap: twin 1 has a network already: leave one of the two out",
         .wrong = "tap"},
        {.options = {"1:echo", "2:tap", "3:unix:/s"},
         .twins = "eee",
         .alone = true,
         .calls = "",
         .message =
             "--eoe 2:tap needs a process of the twins' own: 'ectwin run', or 'ectwin with' without --in-process",
         .wrong = "2:tap"},
        {.options = {"echo"},
         .twins = "e",
         .fails_at = 1,
         .calls = " echo",
         .message = "not enough memory",
         .wrong = "echo"},
        {.options = {"2:echo", "1:tap"},
         .twins = "eee",
         .fails_at = 2,
         .calls = " echo host",
         .message = "not enough memory",
         .wrong = "1:tap"},
        {.twins = "eee", .fails_at = 2, .calls = " own own", .message = "not enough memory"},
        {.options = {"3:echo"},
         .twins = "eee",
         .fails_at = 3,
         .calls = " echo own own",
         .message = "not enough memory",
         .wrong = "3:echo"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        eoe_args_t args = {0};
        ect_twin_config_t twins[TWINS];
        char message[EOE_MESSAGE] = "before";
        read_options(&rows[i], &args);
        if (join(&rows[i], &args, twins, message))
            fail_msg("row %zu: no refusal", i);
        assert_string_equal(message, rows[i].message);
        assert_string_equal(calls.text, rows[i].calls);
        assert_string_equal(args.wrong ? args.wrong : "", rows[i].wrong ? rows[i].wrong : "");
        eoe_args_free(&args);
    }
}

/* Opens the hosts. @param[out] text  of standard error */
static bool open_and_read(const eoe_args_t *args, bool quiet, ect_hosts_t **hosts, char *message, char text[LOG])
{
    FILE *file = tmpfile();
    assert_non_null(file);
    fflush(stderr);
    const int before = dup(STDERR_FILENO);
    assert_int_equal(dup2(fileno(file), STDERR_FILENO), STDERR_FILENO);
    const bool done = eoe_args_open(args, "ectwin run", quiet, hosts, message);
    fflush(stderr);
    assert_int_equal(dup2(before, STDERR_FILENO), STDERR_FILENO);
    close(before);
    rewind(file);
    text[fread(text, 1, LOG - 1, file)] = '\0';
    fclose(file);
    return done;
}

#define AT(twin, name) "ectwin run: the network of twin " twin " is at '" name "'\n"

static void hosts_that_are_opened(void **state)
{
    static const struct {
        row_t row;
        bool quiet;
        int no_hosts;
        const char *text;
    } rows[] = {
        {{.twins = "e", .calls = ""}, false, EMFILE, ""},
        {{.options = {"echo"}, .twins = "e", .calls = ""}, false, EMFILE, ""},
        {{.options = {"tap7"}, .twins = "-e", .calls = " new tap7 at 1"}, false, 0, AT("2", "tap7")},
        {{.options = {"tap7"}, .twins = "-e", .calls = " new tap7 at 1"}, true, 0, ""},
        {{.options = {"echo", "gate:unix:/s"}, .twins = "eee", .calls = " new unix:/s at 2"},
         false,
         0,
         AT("3", "unix:/s")},
        {{.options = {"2:tap7", "echo", "gate:tap8"}, .twins = "eee", .calls = " new tap7 at 1 tap8 at 2"},
         false,
         0,
         AT("2", "tap7") AT("3", "tap8")},
        {{.options = {"tap7"}, .twins = "e", .calls = " new", .message = "--eoe: Too many open files"},
         false,
         EMFILE,
         ""},
        {{.options = {"tap7"},
          .twins = "e",
          .fails_at = 1,
          .calls = " new tap7 at 0 close",
          .message = "--eoe tap7: 'tap7' is taken"},
         false,
         0,
         ""},
        {{.options = {"1:tap7", "2:tap8", "3:tap9"},
          .twins = "eee",
          .fails_at = 2,
          .calls = " new tap7 at 0 tap8 at 1 close",
          .message = "--eoe 2:tap8: 'tap8' is taken"},
         false,
         0,
         AT("1", "tap7")},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const row_t *row = &rows[i].row;
        eoe_args_t args = {0};
        ect_twin_config_t twins[TWINS];
        ect_hosts_t *hosts = (ect_hosts_t *)&hosts;
        char message[EOE_MESSAGE] = "before", text[LOG];
        read_options(row, &args);
        calls.fails_at = 0;
        assert_true(join(row, &args, twins, message));
        memset(&calls, 0, sizeof calls);
        calls.fails_at = row->fails_at;
        calls.no_hosts = rows[i].no_hosts;
        const bool done = open_and_read(&args, rows[i].quiet, &hosts, message, text);
        if (done != !row->message || strcmp(text, rows[i].text) != 0)
            fail_msg("row %zu: got %d, '%s', '%s'", i, done, message, text);
        assert_string_equal(calls.text, row->calls);
        if (row->message)
            assert_string_equal(message, row->message);
        if (done && strncmp(row->calls, " new", 4) == 0)
            assert_ptr_equal(hosts, &some_hosts);
        else
            assert_null(hosts);
        eoe_args_free(&args);
    }
}

/* The first TAP or socket of the options. */
static void host_of_options(void **state)
{
    static const struct {
        row_t row;
        const char *host;
    } rows[] = {
        {{.options = {NULL}}, NULL},
        {{.options = {"echo", "2:echo"}}, NULL},
        {{.options = {"tap"}}, "tap"},
        {{.options = {"echo", "2:unix:/s", "3:tap"}}, "2:unix:/s"},
        {{.options = {"echo", "2:echo", "gate:tapX"}}, "gate:tapX"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        eoe_args_t args = {0};
        read_options(&rows[i].row, &args);
        const char *host = eoe_args_host(&args);
        assert_string_equal(host ? host : "none", rows[i].host ? rows[i].host : "none");
        eoe_args_free(&args);
    }
}

#define TEST(title, function) {title, function, NULL, NULL, NULL}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        TEST("EOE: each twin with EoE has a network: that of its option, or its own", networks_of_twins),
        TEST("EOE: an option that fits no twin, and a network without memory, are refused with a line",
             networks_that_are_refused),
        TEST("EOE: each TAP and socket is opened for its twin; after a failure all are closed", hosts_that_are_opened),
        TEST("EOE: the first option with a TAP or a socket is found", host_of_options),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Option --eoe", tests, setup, NULL);
}
