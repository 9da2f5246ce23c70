/* SPDX-License-Identifier: MIT */
/* Decisions on requests of a browser to the panel (request.h), and the files that it may get. */
#include "request.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "content.h"

enum { PORT = 8123 };

static void hosts(void **state)
{
    static const struct {
        const char *host;
        unsigned int port;
        bool ours;
    } rows[] = {
        {"127.0.0.1:8123", PORT, true},
        {"localhost:8123", PORT, true},
        {"[::1]:8123", PORT, true},
        {"192.168.1.5:8123", PORT, true},
        {"127.0.0.1", 80, true},
        {"[::1]", 80, true},
        {"127.0.0.1:80", 80, true},
        {"127.0.0.1", PORT, false},
        {"127.0.0.1:8124", PORT, false},
        {"127.0.0.1:81230", PORT, false},
        {"127.0.0.1:", 80, false},
        {"127.0.0.1:8123 ", PORT, false},
        {"evil.example:8123", PORT, false},
        {"", PORT, false},
        {":8123", PORT, false},
        {"[]:8123", PORT, false},
        {"[::1:8123", PORT, false},
        {"[::1", PORT, false},
        {"[::1\0:8123", PORT, false}, /* nothing is read behind its end */
        {"[127.0.0.1]:8123", PORT, false},
        {"[localhost]:8123", PORT, false},
        {"::1:8123", PORT, false},
        {"localhost.evil.example:8123", PORT, false},
        {"127.0.0.1.evil.example:8123", PORT, false},
        {"LOCALHOST:8123", PORT, false},
        {"2130706433:8123", PORT, false},
        {"0x7f.1:8123", PORT, false},
        {"aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa:8123", PORT, false},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        if (request_host_is_ours(rows[i].host, rows[i].port) != rows[i].ours)
            fail_msg("Host '%s'", rows[i].host);
    }
}

/* With and without brackets; 63 letters have room. */
static void long_hosts(void **state)
{
    static const int lengths[] = {62, 63, 64, 65, 66, 1000, 4000};
    char text[4096];
    (void)state;
    for (size_t i = 0; i < sizeof lengths / sizeof lengths[0]; i++) {
        snprintf(text, sizeof text, "%0*d:8123", lengths[i], 0);
        assert_false(request_host_is_ours(text, PORT));
        snprintf(text, sizeof text, "[%0*d]:8123", lengths[i], 0);
        assert_false(request_host_is_ours(text, PORT));
        snprintf(text, sizeof text, "[::%0*d]:8123", lengths[i] - 2, 1);
        assert_false(request_host_is_ours(text, PORT));
    }
}

static void origins(void **state)
{
    static const struct {
        const char *origin, *host;
        bool ours;
    } rows[] = {
        {"http://127.0.0.1:8123", "127.0.0.1:8123", true},
        {"https://127.0.0.1:8123", "127.0.0.1:8123", false},
        {"http://localhost:8123", "127.0.0.1:8123", false},
        {"http://127.0.0.1:81234", "127.0.0.1:8123", false},
        {"http://127.0.0.1:812", "127.0.0.1:8123", false},
        {"http:/x127.0.0.1:8123", "127.0.0.1:8123", false},
        {"xttp://127.0.0.1:8123", "127.0.0.1:8123", false},
        {"null", "127.0.0.1:8123", false},
        {"", "127.0.0.1:8123", false},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        if (request_origin_is_ours(rows[i].origin, rows[i].host) != rows[i].ours)
            fail_msg("Origin '%s'", rows[i].origin);
    }
}

static void tokens(void **state)
{
    static const uint8_t bits[16] = {0, 1, 0xFF};
    char token[REQUEST_TOKEN];
    char other[REQUEST_TOKEN + 1];
    (void)state;
    request_write_token(bits, token);
    assert_string_equal(token, "0001ff00000000000000000000000000");
    assert_true(request_token_is_right(token, token));
    assert_false(request_token_is_right("", token));
    assert_false(request_token_is_right("", ""));
    for (size_t i = 0; i < strlen(token); i++) {
        strcpy(other, token);
        other[i] ^= 1;
        assert_false(request_token_is_right(other, token));
        other[i] = 0;
        assert_false(request_token_is_right(other, token));
    }
    strcat(strcpy(other, token), "0");
    assert_false(request_token_is_right(other, token));
}

static void addresses(void **state)
{
    static const struct {
        const char *address;
        bool numeric, loopback;
    } rows[] = {{"127.0.0.1", true, true}, {"127.1.2.3", true, true},   {"::1", true, true},
                {"0.0.0.0", true, false},  {"128.0.0.1", true, false},  {"fe80::1", true, false},
                {"::", true, false},       {"localhost", false, false}, {"127.1", false, false}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        if (request_is_numeric(rows[i].address) != rows[i].numeric ||
            request_is_loopback(rows[i].address) != rows[i].loopback)
            fail_msg("%s", rows[i].address);
    }
}

static void requests(void **state)
{
    static const struct {
        const char *text;
        bool taken, in_view;
    } rows[] = {
        {"{\"op\":\"set\",\"name\":\"a\",\"value\":1}", true, false},
        {"{\"op\":\"fault\",\"fault\":\"off\"}", true, false},
        {"{\"op\":\"write\"}", true, false},
        {"{\"op\":\"objects\"}", true, true},
        {"{\"op\":\"read\"}", true, true},
        {"{\"op\":\"pdos\"}", true, true},
        {"{\"op\":\"wires\"}", true, true},
        {"{\"op\":\"counters\"}", true, true},
        {"{\"op\":\"waves\"}", true, true},
        {"{\"op\":\"wave\"}", true, false},
        {"{\"op\":\"capture\"}", true, false},
        {"{\"op\":\"watch\"}", false, false},
        {"{\"op\":\"words\"}", false, false},
        {"{\"op\":1}", false, false},
        {"{\"OP\":\"set\"}", false, false},
        {"{}", false, false},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        cJSON *request = cJSON_Parse(rows[i].text);
        assert_non_null(request);
        assert_true((request_refused(request, false) == NULL) == rows[i].taken);
        assert_true((request_refused(request, true) == NULL) == rows[i].in_view);
        cJSON_Delete(request);
    }
}

static void files(void **state)
{
    static const char *const others[] = {"",          "//", "/.", "/../index.html", "/index.html", "/%69ndex.html",
                                         "index.html"};
    (void)state;
    assert_non_null(content_find("/"));
    assert_string_equal(content_find("/")->type, "text/html; charset=utf-8");
    for (size_t i = 0; i < sizeof others / sizeof *others; i++)
        assert_null(content_find(others[i]));
    for (const content_t *content = contents; content->path; content++)
        assert_true(content->length > 0 && content->type[0] != 0);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"SEC: Host is a numeric address or localhost, with the port", hosts, NULL, NULL, NULL},
        {"SEC: a Host of any length is compared or refused", long_hosts, NULL, NULL, NULL},
        {"SEC: Origin is that of the pages", origins, NULL, NULL, NULL},
        {"SEC: the token is compared whole", tokens, NULL, NULL, NULL},
        {"Addresses of this machine alone need no warning", addresses, NULL, NULL, NULL},
        {"SEC: a page sends known requests alone, with --view those that change nothing", requests, NULL, NULL, NULL},
        {"SEC: paths are those of the files in the program", files, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Panel: requests", tests, NULL, NULL);
}
