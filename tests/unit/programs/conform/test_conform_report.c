/* SPDX-License-Identifier: MIT */
/* Reports: escaping, counts, the verdict first, histograms; the record of frames; the hash of the ESI file. */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include <cmocka.h>

#include "bus/capture/pcapng.h"
#include "conform_support.h"
#include "sha256.h"

static char *written;
static size_t written_size;

static FILE *to_memory(void)
{
    return open_memstream(&written, &written_size);
}

static const char *escaped(const char *text)
{
    static char copy[200];
    FILE *to = to_memory();
    cf_put_escaped(to, text);
    fclose(to);
    snprintf(copy, sizeof copy, "%s", written);
    free(written);
    return copy;
}

static void escaping(void **state)
{
    (void)state;
    assert_string_equal(escaped("a<b & \"c\">d"), "a&lt;b &amp; &quot;c&quot;&gt;d");
    assert_string_equal(escaped("line\nline\ttab\x01\x7F"), "line\nline?tab??");
    assert_string_equal(escaped("\x1F ~"), "? ~"); /* the last control character, the first and the last other one */
    assert_string_equal(escaped("M\xC3\xBCller \xE2\x82\xAC \xF0\x9F\x99\x82"),
                        "M\xC3\xBCller \xE2\x82\xAC \xF0\x9F\x99\x82");
    assert_string_equal(escaped("\xFC"), "?");                /* Latin-1 */
    assert_string_equal(escaped("\xC0\xAF"), "??");           /* overlong */
    assert_string_equal(escaped("\xE0\x80\xAF"), "???");      /* overlong */
    assert_string_equal(escaped("\xED\xA0\x80"), "???");      /* a surrogate */
    assert_string_equal(escaped("\xF4\x90\x80\x80"), "????"); /* beyond U+10FFFF */
    assert_string_equal(escaped("\xC3"), "?");                /* cut off by the end */
    assert_string_equal(escaped("\xE2\x82"), "??");           /* cut off by the end */
    assert_string_equal(escaped("\xE2\x82x"), "??x");
    assert_string_equal(escaped("\xED\x9F\xBF\xEE\x80\x80"), "\xED\x9F\xBF\xEE\x80\x80");
    assert_string_equal(escaped(""), "");
}

/* The first and the last sequence of each well-formed kind pass; their neighbours do not. */
static void utf8_limits(void **state)
{
    static const char *const good[] = {"\xC2\x80",         "\xDF\xBF",         "\xE0\xA0\x80",     "\xE0\xBF\xBF",
                                       "\xE1\x80\x80",     "\xEC\xBF\xBF",     "\xED\x80\x80",     "\xED\x9F\xBF",
                                       "\xEE\x80\x80",     "\xEF\xBF\xBF",     "\xF0\x90\x80\x80", "\xF0\xBF\xBF\xBF",
                                       "\xF1\x80\x80\x80", "\xF3\xBF\xBF\xBF", "\xF4\x80\x80\x80", "\xF4\x8F\xBF\xBF"};
    static const char *const bad[] = {"\xC1\xBF",         "\xC2\x7F",         "\xC2\xC0",         "\xE0\x9F\xBF",
                                      "\xE0\xC0\x80",     "\xE1\x7F\x80",     "\xEC\xC0\x80",     "\xED\xA0\x80",
                                      "\xEE\x7F\x80",     "\xEF\xC0\x80",     "\xF0\x8F\xBF\xBF", "\xF0\xC0\x80\x80",
                                      "\xF1\x7F\x80\x80", "\xF3\xC0\x80\x80", "\xF4\x90\x80\x80", "\xF5\x80\x80\x80",
                                      "\xE1\x80\x7F",     "\xE1\x80\xC0",     "\xF1\x80\x80\x7F", "\x80"};
    (void)state;
    for (size_t i = 0; i < sizeof good / sizeof good[0]; i++)
        assert_string_equal(escaped(good[i]), good[i]);
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++)
        assert_int_equal(escaped(bad[i])[0], '?');
}

/* Names of slaves: a byte that is no text becomes '?', well-formed UTF-8 stays. */
static void cleaning(void **state)
{
    static const struct {
        const char *text, *clean;
    } rows[] = {
        {"", ""},
        {"Drive 7", "Drive 7"},
        {"two\nlines", "two\nlines"},
        {"\x01tab\t\x1F end\x7F", "?tab?? end?"},
        {"\x80", "?"}, /* the first byte of no sequence */
        {"\xFF\xBFx", "??x"},
        {"M\xC3\xBCller \xE2\x82\xAC \xF0\x9F\x99\x82", "M\xC3\xBCller \xE2\x82\xAC \xF0\x9F\x99\x82"},
        {"\xC3", "?"}, /* cut off by the end */
        {"\xE2\x82x", "??x"},
        {"\xC2\x80\x7E", "\xC2\x80\x7E"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char text[40];
        snprintf(text, sizeof text, "%s", rows[i].text);
        cf_clean(text);
        assert_string_equal(text, rows[i].clean);
    }
}

/* --- a run of five cases in two sections -------------------------------------------------------------------------- */

static void nothing(cf_t *c)
{
    (void)c;
}

static const cf_case_t first_cases[] = {{"CF-901", "One <passes>", 'R', 0, 0, nothing},
                                        {"CF-902", "One fails", 'F', 0, 0, nothing}};
static const cf_case_t second_cases[] = {{"CF-903", "One warns", 'R', 0, 0, nothing},
                                         {"CF-904", "One is skipped", 'R', 0, 0, nothing},
                                         {"CF-905", "One is not judged", 'R', 0, 0, nothing}};
static CF_SECTION(first, 'X', "First & foremost", first_cases);
static CF_SECTION(second, 'Y', "Second", second_cases);

static cf_result_t results[5];
static cf_run_t run;

static void fill(void)
{
    static uint8_t step[] = "a step & more";
    static cf_item_t items[] = {{.kind = CF_ITEM_STEP, .frame = 7, .length = sizeof step, .bytes = step}};
    start_run(&run);
    results[0] = (cf_result_t){.section = &first, .entry = &first_cases[0], .verdict = CF_PASS};
    results[1] = (cf_result_t){.section = &first,
                               .entry = &first_cases[1],
                               .verdict = CF_FAIL,
                               .frame = 9,
                               .reason = "expected <1>, got 2",
                               .step = "the step",
                               .evidence = {.items = items, .count = 1, .first_frame = 7, .last_frame = 12}};
    results[2] = (cf_result_t){.section = &second, .entry = &second_cases[0], .verdict = CF_WARN, .reason = "unusual"};
    results[3] =
        (cf_result_t){.section = &second, .entry = &second_cases[1], .verdict = CF_SKIPPED, .reason = "no such"};
    results[4] = (cf_result_t){.section = &second,
                               .entry = &second_cases[2],
                               .verdict = CF_UNJUDGED,
                               .reason = "not judged since CF-902: no reply"};
    run.results = results;
    run.count = run.planned = 5;
    snprintf(run.c.facts.name, sizeof run.c.facts.name, "Slave <1>");
    run.c.facts.slaves = 3;
    run.c.facts.position = 1;
    run.c.facts.input_bytes = 6;
    run.c.facts.output_bytes = 9;
    run.c.facts.vendor = 0xE57;
    run.c.facts.type = 0x11;
}

static const char *report(cf_report_t write)
{
    FILE *to = to_memory();
    write(to, &run);
    fclose(to);
    end_run(&run);
    return written;
}

static void counts(void **state)
{
    (void)state;
    fill();
    cf_counts_t all = cf_count(&run, NULL), one = cf_count(&run, &first);
    for (int v = CF_PASS; v <= CF_UNJUDGED; v++)
        assert_int_equal(all.of[v], 1);
    assert_int_equal(all.of[CF_INTERRUPTED], 0);
    assert_int_equal(one.of[CF_PASS] + one.of[CF_FAIL], 2);
    assert_int_equal(one.of[CF_WARN] + one.of[CF_SKIPPED] + one.of[CF_UNJUDGED], 0);
    end_run(&run);
}

static void frames_text(void **state)
{
    char text[80];
    (void)state;
    fill();
    cf_frames_text(&results[1], text, sizeof text);
    assert_string_equal(text, "frames 7-12, seen in 9");
    for (size_t room = 12; room < 30; room++) { /* nothing is written behind the room */
        memset(text, 'x', sizeof text);
        cf_frames_text(&results[1], text, room);
        assert_int_equal(strlen(text), room - 1 < 22 ? room - 1 : 22);
        for (size_t at = room; at < sizeof text; at++)
            assert_int_equal(text[at], 'x');
    }
    results[1].verdict = CF_PASS;
    cf_frames_text(&results[1], text, sizeof text);
    assert_string_equal(text, "frames 7-12");
    cf_frames_text(&results[0], text, sizeof text);
    assert_string_equal(text, "");
    end_run(&run);
}

/* The report contains the texts in this order. */
static void in_order(const char *report_, const char *const *texts)
{
    const char *at = report_;
    for (; *texts; texts++) {
        const char *found = strstr(at, *texts);
        if (!found)
            fail_msg("'%s' is not behind the text before it", *texts);
        at = found;
    }
}

static void html(void **state)
{
    static const char *const texts[] = {
        "<title>Slave &lt;1&gt;: EtherCAT conformance",
        "prefers-color-scheme:dark",
        "@media print",
        "<div class=\"verdict fail\"><b>FAIL</b>",
        "5 of 5 cases ran: 1 pass, 1 warn, 1 fail, 1 skip, 1 not judged",
        "href=\"#CF-902\"",
        "href=\"#CF-905\"",
        "href=\"#CF-903\"",
        "vendor 0x00000E57",
        "class=\"blank\"",
        "type 0x11 revision 0",
        "6 bytes of inputs, 9 bytes of outputs",
        "slave 2 of 3 on test0",
        "2026-01-02, 0.0 s",
        "class=\"blank\"",
        "ectwin-conform 1.2.3",
        "ectwin-conform -i test0",
        "href=\"#from-CF-901\">X. First &amp; foremost</a></td><td class=\"n pass\">1</td><td class=\"n "
        "skip\">&middot;</td>"
        "<td class=\"n fail\">1</td><td class=\"n skip\">&middot;</td>"
        "<td class=\"n skip\">&middot;</td></tr>",
        "<tr><th>All</th><td class=\"n pass\">1</td><td class=\"n warn\">1</td>"
        "<td class=\"n fail\">1</td><td class=\"n unjudged\">1</td><td class=\"n skip\">1</td>",
        "<h2 id=\"from-CF-901\">X. First &amp; foremost",
        "id=\"CF-901\"",
        "One &lt;passes&gt;",
        "<div class=\"case failed\" id=\"CF-902\">",
        "expected &lt;1&gt;, got 2",
        "at: the step",
        "frames 7-12, seen in 9",
        "<span class=\"s\">a step &amp; more</span>",
        "id=\"CF-905\"",
        "</html>",
        NULL};
    (void)state;
    fill();
    in_order(report(cf_report_html), texts);
    assert_null(strstr(written, "SHA-256"));
    free(written);
    fill();
    run.count = 1; /* the first, which passes; Ctrl-C then */
    snprintf(run.esi_hash, sizeof run.esi_hash, "00ff");
    run.operator_ = "A & B";
    run.firmware = "7";
    assert_non_null(strstr(report(cf_report_html), "<b>INTERRUPTED</b>"));
    assert_non_null(strstr(written, "<code>00ff</code>"));
    assert_non_null(strstr(written, "A &amp; B"));
    assert_null(strstr(written, "class=\"blank\""));
    free(written);
    fill();
    run.count = run.planned = 1;
    assert_non_null(strstr(report(cf_report_html), "<div class=\"verdict pass\"><b>PASS</b>"));
    assert_null(strstr(written, "<ul>"));
    assert_null(strstr(written, "not judged."));
    free(written);
    fill();
    run.results = &results[2]; /* a warning alone passes, and has a link */
    run.count = run.planned = 1;
    assert_non_null(strstr(report(cf_report_html), "<b>PASS</b>"));
    assert_non_null(strstr(written, "<a href=\"#CF-903\">"));
    free(written);
    fill();
    run.results = &results[4]; /* a case that is not judged alone is no pass */
    run.count = run.planned = 1;
    assert_non_null(strstr(report(cf_report_html), "<div class=\"verdict fail\"><b>FAIL</b>"));
    free(written);
}

static void plain(void **state)
{
    static const char *const texts[] = {
        "slave 2 of 3 on test0: Slave <1>, vendor 0x00000E57 product 0x00000000 revision 0x00000000, ESC type 0x11",
        "ESI file: none given (--esi)",
        "X. First & foremost",
        "  pass CF-901",
        "  FAIL CF-902  One fails  (frames 7-12, seen in 9)",
        "expected <1>, got 2",
        "at: the step",
        "-- a step & more",
        "Y. Second",
        "unjudged CF-905",
        "5 of 5 cases in 0.0 s: 1 pass, 1 warn, 1 fail, 1 skip, 1 not judged\n",
        NULL};
    (void)state;
    fill();
    in_order(report(cf_report_text), texts);
    free(written);
}

static void machine_readable(void **state)
{
    static const char *const junit[] = {"tests=\"2\" failures=\"1\" errors=\"0\" skipped=\"0\"",
                                        "One &lt;passes&gt;",
                                        "<failure message=\"expected &lt;1&gt;, got 2\">",
                                        "a step &amp; more",
                                        "tests=\"3\" failures=\"0\" errors=\"1\" skipped=\"1\"",
                                        "<system-out>warn: unusual</system-out>",
                                        "<skipped message=\"no such\"/>",
                                        "<error message=\"not judged since CF-902",
                                        NULL};
    (void)state;
    fill();
    in_order(report(cf_report_junit), junit);
    free(written);
    fill();
    cJSON *json = cJSON_Parse(report(cf_report_json));
    free(written);
    assert_non_null(json);
    assert_int_equal(cJSON_GetArraySize(cJSON_GetObjectItem(json, "cases")), 5);
    assert_int_equal(cJSON_GetObjectItem(cJSON_GetObjectItem(json, "summary"), "unjudged")->valueint, 1);
    assert_string_equal(cJSON_GetObjectItem(json, "version")->valuestring, "1.2.3");
    assert_true(cJSON_IsNull(cJSON_GetObjectItem(json, "operator")));
    cJSON_Delete(json);
    fill(); /* a name in Latin-1 is no JSON */
    snprintf(run.c.facts.name, sizeof run.c.facts.name, "M\xFCller \xC3\xBC\x7F\t");
    json = cJSON_Parse(report(cf_report_json));
    free(written);
    assert_string_equal(cJSON_GetObjectItem(cJSON_GetObjectItem(json, "slave"), "name")->valuestring,
                        "M?ller \xC3\xBC??");
    cJSON_Delete(json);
}

/* --- histograms --------------------------------------------------------------------------------------------------- */

static void measures(cf_t *c)
{
    static const uint64_t values[] = {1000000001, 500, 1000, 1001, 2000, 5001};
    for (size_t i = 0; i < sizeof values / sizeof values[0]; i++)
        cf_measure(c, "a series", values[i]);
}

static void histograms(void **state)
{
    static const char *const texts[] = {
        "a series: 6 times, 0.5 us at least, 2.0 median, 1000000.0 for 99 %, 1000000.0 at most",
        "to   1 us      2 ####",
        "to   2 us      2 ####",
        "to   5 us      0 \n",
        "to  10 us      1 ##",
        "to    2 s      1 ##",
        NULL};
    cf_result_t result;
    (void)state;
    start_run(&run);
    assert_int_equal(run_one(&run, measures, 0, &result), CF_PASS);
    in_order(report(cf_report_text), texts);
    free(written);
}

/* --- the record --------------------------------------------------------------------------------------------------- */

static int wire[2];

static void exchange(uint8_t index, uint8_t value)
{
    uint8_t sent[60] = {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 1, 1, 1, 1, 1, 1, 0x88, 0xA4}, received[60];
    sent[17] = index;
    sent[26] = value;
    assert_int_equal(send(wire[0], sent, sizeof sent, 0), sizeof sent);
    assert_int_equal(recv(wire[1], received, sizeof received, 0), sizeof received);
}

/* A slave that is polled does not push the request out of the evidence: equal exchanges are one. */
static void polls_fold(void **state)
{
    (void)state;
    assert_int_equal(socketpair(AF_UNIX, SOCK_DGRAM, 0, wire), 0);
    cf_record_open(NULL);
    cf_record_source(NULL);
    cf_record_begin("CF-900", "title");
    exchange(1, 0x11);
    cf_record_step("polling");
    for (unsigned int i = 0; i < 1000; i++)
        exchange((uint8_t)i, 0x22);
    exchange(9, 0x33);
    assert_int_equal(cf_record_frame(), 2004);
    cf_evidence_t e = cf_record_end(100);
    assert_int_equal(e.count, 7);
    assert_int_equal(e.first_frame, 1);
    assert_int_equal(e.last_frame, 2004);
    assert_int_equal(e.items[0].bytes[26], 0x11);
    assert_int_equal(e.items[0].folded, 0);
    assert_string_equal((const char *)e.items[2].bytes, "polling");
    assert_int_equal(e.items[2].length, sizeof "polling");
    assert_int_equal(e.items[3].folded, 999);
    assert_int_equal(e.items[4].folded, 999);
    assert_int_equal(e.items[4].frame, 2002);
    assert_int_equal(e.items[6].bytes[26], 0x33);
    cf_evidence_free(&e);
    e = cf_record_end(100); /* each case has its own */
    assert_int_equal(e.count, 0);
    cf_evidence_free(&e);
    cf_record_close();
    close(wire[0]);
    close(wire[1]);
}

static void first_polls_fold(void **state)
{
    (void)state;
    assert_int_equal(socketpair(AF_UNIX, SOCK_DGRAM, 0, wire), 0);
    cf_record_open(NULL);
    exchange(1, 0x22);
    exchange(2, 0x22);
    cf_evidence_t e = cf_record_end(100);
    assert_int_equal(e.count, 2);
    assert_int_equal(e.items[0].folded, 1);
    assert_int_equal(e.items[1].folded, 1);
    cf_evidence_free(&e);
    cf_record_close();
    close(wire[0]);
    close(wire[1]);
}

static void short_frames_stay(void **state)
{
    enum { HEADERS = 17 }; /* Ethernet, EtherCAT, command: without the datagram's index */
    uint8_t frame[HEADERS + 1] = {0};
    (void)state;
    assert_int_equal(socketpair(AF_UNIX, SOCK_DGRAM, 0, wire), 0);
    cf_record_open(NULL);
    for (unsigned int i = 0; i < 4; i++) {
        const size_t length = i < 2 ? HEADERS : HEADERS + 1;
        assert_int_equal(send(wire[0], frame, length, 0), length);
        assert_int_equal(recv(wire[1], frame, sizeof frame, 0), length);
    }
    cf_evidence_t e = cf_record_end(100);
    assert_int_equal(e.count, 6); /* the two with an index are one */
    assert_int_equal(e.items[2].folded, 0);
    assert_int_equal(e.items[4].folded, 1);
    cf_evidence_free(&e);
    cf_record_close();
    close(wire[0]);
    close(wire[1]);
}

static void evidence_is_bounded(void **state)
{
    (void)state;
    assert_int_equal(socketpair(AF_UNIX, SOCK_DGRAM, 0, wire), 0);
    cf_record_open(NULL);
    cf_record_begin("CF-900", "title");
    cf_record_step(CF_CASE_BEGINS);
    for (unsigned int i = 0; i < 5; i++)
        exchange(0, (uint8_t)i);
    cf_evidence_t e = cf_record_end(100);
    assert_int_equal(e.count, 11);
    assert_int_equal(cf_evidence_start(&e), 1);
    cf_evidence_free(&e);
    for (unsigned int i = 0; i < CF_EVIDENCE_MAX; i++)
        exchange(0, (uint8_t)i);
    e = cf_record_end(6); /* the last ones */
    assert_int_equal(e.count, 6);
    assert_int_equal(e.items[5].bytes[26], (uint8_t)(CF_EVIDENCE_MAX - 1));
    assert_int_equal(e.items[0].bytes[26], (uint8_t)(CF_EVIDENCE_MAX - 3));
    assert_int_equal(cf_evidence_start(&e), 0);
    cf_evidence_free(&e);
    cf_record_close();
    close(wire[0]);
    close(wire[1]);
}

static void ring_of_evidence(void **state)
{
    (void)state;
    cf_record_open(NULL);
    for (unsigned int i = 0; i < CF_EVIDENCE_MAX + 3; i++)
        cf_record_step(i == 3 ? "the oldest that is kept" : i == CF_EVIDENCE_MAX + 2 ? "the newest" : "a step");
    cf_evidence_t e = cf_record_end(CF_EVIDENCE_MAX + 3);
    assert_int_equal(e.count, CF_EVIDENCE_MAX);
    assert_string_equal((const char *)e.items[0].bytes, "the oldest that is kept");
    assert_string_equal((const char *)e.items[CF_EVIDENCE_MAX - 1].bytes, "the newest");
    cf_evidence_free(&e);
    cf_record_close();
}

static void receptions_without_a_frame(void **state)
{
    uint8_t room[60];
    (void)state;
    assert_int_equal(socketpair(AF_UNIX, SOCK_DGRAM, 0, wire), 0);
    cf_record_open(NULL);
    assert_int_equal(recv(wire[1], room, sizeof room, MSG_DONTWAIT), -1); /* nothing has come */
    struct msghdr empty = {0};
    assert_int_equal(sendmsg(wire[0], &empty, 0), 0);
    assert_int_equal(recv(wire[1], room, sizeof room, 0), 0);
    assert_int_equal(cf_record_frame(), 0);
    exchange(0, 1);
    assert_int_equal(cf_record_frame(), 2);
    cf_evidence_t e = cf_record_end(10);
    assert_int_equal(e.count, 2);
    cf_evidence_free(&e);
    cf_record_close();
    close(wire[0]);
    close(wire[1]);
}

/* No station has a multicast address as its source. */
static void unicast_source(void **state)
{
    static const uint8_t mac[6] = {0x10, 0x22, 0x33, 0x44, 0x55, 0x66};
    (void)state;
    assert_int_equal(socketpair(AF_UNIX, SOCK_DGRAM, 0, wire), 0);
    cf_record_open(NULL);
    cf_record_source(mac);
    exchange(0, 1);
    uint8_t own[60] = {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0x02, 9, 9, 9, 9, 9, 0x88, 0xA4};
    assert_int_equal(send(wire[0], own, sizeof own, 0), sizeof own);
    uint8_t cut[12] = {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 1, 1, 1, 1, 1, 1}; /* addresses only, and less */
    assert_int_equal(send(wire[0], cut, sizeof cut, 0), sizeof cut);
    assert_int_equal(send(wire[0], cut, sizeof cut - 1, 0), sizeof cut - 1);
    cf_evidence_t e = cf_record_end(10);
    assert_int_equal(e.count, 5);
    assert_memory_equal(e.items[3].bytes + 6, mac, 6);
    assert_memory_equal(e.items[4].bytes, cut, sizeof cut - 1);
    assert_memory_equal(e.items[0].bytes + 6, mac, 6); /* as recorded */
    assert_memory_equal(e.items[1].bytes + 6, mac, 6); /* and as it left */
    for (unsigned int i = 0; i < 2; i++) {
        assert_int_equal(e.items[i].bytes[0], 0xFF); /* the rest is that of the sender */
        assert_int_equal(e.items[i].bytes[13], 0xA4);
        assert_int_equal(e.items[i].bytes[26], 1);
    }
    assert_memory_equal(e.items[2].bytes, own, sizeof own); /* a unicast address stays */
    cf_evidence_free(&e);
    cf_record_close();
    close(wire[0]);
    close(wire[1]);
}

/* Without a record, and beyond the longest frame of a capture, nothing is recorded. */
static void recorded_frames(void **state)
{
    static const uint8_t bytes[ECT_PCAPNG_FRAME_MOST + 1];
    static const struct {
        bool open;
        size_t length;
        uint32_t recorded;
    } rows[] = {
        {false, 60, 0}, {false, ECT_PCAPNG_FRAME_MOST + 1, 0}, {true, 1, 1},
        {true, 60, 1},  {true, ECT_PCAPNG_FRAME_MOST, 1},      {true, ECT_PCAPNG_FRAME_MOST + 1, 0},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        if (rows[i].open)
            cf_record_open(NULL);
        (void)send(-1, bytes, rows[i].length, 0); /* recorded before the socket refuses it */
        assert_int_equal(cf_record_frame(), rows[i].recorded);
        if (rows[i].open) {
            cf_evidence_t e = cf_record_end(10);
            assert_int_equal(e.count, rows[i].recorded);
            if (e.count > 0)
                assert_int_equal(e.items[0].length, rows[i].length);
            cf_evidence_free(&e);
        }
        cf_record_close();
    }
}

static uint32_t number_at(const uint8_t *at)
{
    uint32_t value;
    memcpy(&value, at, sizeof value);
    return value;
}

/* pcapng: a section, an interface of Ethernet in nanoseconds, a packet a frame; the first has the title as its comment.
 */
static void capture(void **state)
{
    static const uint8_t interface[] = {1, 0, 0, 0, 0, 0, 0, 0, 9, 0, 1, 0, 9, 0, 0, 0, 0, 0, 0, 0};
    (void)state;
    FILE *to = to_memory();
    assert_int_equal(socketpair(AF_UNIX, SOCK_DGRAM, 0, wire), 0);
    cf_record_open(to);
    cf_record_step("of the case before, which sent no frame after it");
    cf_record_begin("CF-900", "a title");
    cf_record_step("a step");
    exchange(1, 0x11);
    cf_evidence_t e = cf_record_end(10);
    const size_t flushed = written_size; /* a growing file has whole cases */
    cf_evidence_free(&e);
    cf_record_close();
    fclose(to);
    close(wire[0]);
    close(wire[1]);
    assert_int_equal(flushed, written_size);
    const uint8_t *at = (const uint8_t *)written;
    assert_int_equal(number_at(at), 0x0A0D0D0A);
    assert_int_equal(number_at(at + 4), 28);
    assert_int_equal(number_at(at + 8), 0x1A2B3C4D);
    assert_int_equal(number_at(at + 24), 28);
    at += 28;
    assert_int_equal(number_at(at), 1);
    assert_memory_equal(at + 8, interface, sizeof interface);
    at += number_at(at + 4);
    assert_int_equal(number_at(at), 6);
    assert_int_equal(number_at(at + 20), 60);
    assert_int_equal(number_at(at + 24), 60);
    assert_int_equal(at[28 + 26], 0x11);
    assert_int_equal(number_at(at + 88), 2 | 4 << 16); /* direction: outbound */
    assert_int_equal(number_at(at + 92), 2);
    assert_int_equal(number_at(at + 96), 1 | 21 << 16);
    assert_memory_equal(at + 100, "CF-900 a title\na step\0\0\0", 24);
    assert_int_equal(number_at(at + 124), 0);
    assert_int_equal(number_at(at + 4), 132);
    at += 132;
    assert_int_equal(number_at(at), 6);
    assert_int_equal(number_at(at + 92), 1); /* inbound, without a comment */
    assert_int_equal(number_at(at + 4), 104);
    at += 104;
    assert_ptr_equal(at, written + written_size);
    free(written);
}

/* The clocks of a test: both stand still, or are those of the machine. */
static struct timespec wall, monotonic;
static bool stopped;

int __real_clock_gettime(clockid_t clock, struct timespec *now);
int __wrap_clock_gettime(clockid_t clock, struct timespec *now);

int __wrap_clock_gettime(clockid_t clock, struct timespec *now)
{
    if (!stopped)
        return __real_clock_gettime(clock, now);
    *now = clock == CLOCK_REALTIME ? wall : monotonic;
    return 0;
}

/* A frame has the wall clock of the start plus the time since then, so that a step of that clock moves no frame. */
static void times_of_frames(void **state)
{
    static const struct timespec wall_at_start = {1700000000, 999999999}, start = {50, 999999999}, later = {53, 4};
    enum { HEADS = 60, TIME = 12 }; /* in front of the first packet, and in it */
    const uint64_t passed_ns = 2000000005, wanted_ns = UINT64_C(1700000000999999999) + passed_ns;
    uint8_t frame[60] = {0};
    (void)state;
    FILE *to = to_memory();
    stopped = true;
    wall = wall_at_start;
    monotonic = start;
    assert_int_equal(cf_now_ns(), UINT64_C(50999999999));
    cf_record_open(to);
    monotonic = later;
    wall.tv_sec += 3600;
    (void)send(-1, frame, sizeof frame, 0);
    cf_evidence_t e = cf_record_end(10);
    stopped = false;
    assert_int_equal(e.count, 1);
    assert_int_equal(e.items[0].time_ns, passed_ns);
    cf_evidence_free(&e);
    cf_record_close();
    fclose(to);
    const uint8_t *packet = (const uint8_t *)written + HEADS;
    assert_int_equal(number_at(packet), 6);
    assert_int_equal((uint64_t)number_at(packet + TIME) << 32 | number_at(packet + TIME + 4), wanted_ns);
    free(written);
}

/* --- SHA-256 ------------------------------------------------------------------------------------------------------ */

static void expect_hash(const char *text, size_t times, const char *hash)
{
    char hex[65];
    FILE *file = tmpfile();
    for (size_t i = 0; i < times; i++)
        fputs(text, file);
    rewind(file);
    cf_sha256(file, hex);
    assert_string_equal(hex, hash);
    fclose(file);
}

/* FIPS 180-4's examples, and the lengths around the end of a block. */
static void hashes(void **state)
{
    (void)state;
    expect_hash("", 1, "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
    expect_hash("abc", 1, "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    expect_hash("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq", 1,
                "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
    expect_hash("a", 1000000, "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
    expect_hash("a", 55, "9f4390f8d30c2dd92ec9f095b65e2b9ae9b0a925a5258e241c9f1e910f734318");
    expect_hash("a", 56, "b35439a4ac6f0948b6d6f9e3c6af0f5f590ce20f1bde7090ef7970686ec6738a");
    expect_hash("a", 64, "ffe054fe7ae0cb6dc65c3af9b61d5209f439851db43d0ba5997337df154668eb");
}

static void no_hash(void **state)
{
    char hex[65] = "another";
    (void)state;
    FILE *file = fopen("/dev/null", "w"); /* which takes no reads */
    assert_non_null(file);
    cf_sha256(file, hex);
    fclose(file);
    assert_string_equal(hex, "");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        {"The record keeps the newest items", ring_of_evidence, NULL, NULL, NULL},
        {"A reception without a byte is no frame", receptions_without_a_frame, NULL, NULL, NULL},
        {"The first two polls of a case fold", first_polls_fold, NULL, NULL, NULL},
        {"Frames without a datagram do not fold", short_frames_stay, NULL, NULL, NULL},
        {"A file that cannot be read has no hash", no_hash, NULL, NULL, NULL},
        cmocka_unit_test(cleaning),
        cmocka_unit_test(times_of_frames),
        cmocka_unit_test(recorded_frames),
        cmocka_unit_test(escaping),
        cmocka_unit_test(utf8_limits),
        cmocka_unit_test(capture),
        cmocka_unit_test(counts),
        cmocka_unit_test(frames_text),
        cmocka_unit_test(html),
        cmocka_unit_test(plain),
        cmocka_unit_test(machine_readable),
        cmocka_unit_test(histograms),
        cmocka_unit_test(polls_fold),
        cmocka_unit_test(evidence_is_bounded),
        cmocka_unit_test(unicast_source),
        cmocka_unit_test(hashes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
