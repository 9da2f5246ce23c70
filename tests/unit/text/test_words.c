/* SPDX-License-Identifier: MIT */
/* Words for numbers: AL states, AL status codes, SDO abort codes, emergencies; durations; and the lines about mistakes.
 */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "text/abort.h"
#include "text/al_status.h"
#include "text/argument.h"
#include "text/emergency.h"
#include "text/mistake.h"
#include "text/state.h"

#define COUNT(table) (sizeof(table) / sizeof((table)[0]))

/* --- codes -------------------------------------------------------------------------------------------------------- */

/* ETG.1000.6, table 11; ETG.1020. */
static const uint16_t al_status_codes[] = {
    0x0000, 0x0001, 0x0002, 0x0011, 0x0012, 0x0013, 0x0014, 0x0015, 0x0016, 0x0017, 0x0018, 0x0019, 0x001A,
    0x001B, 0x001C, 0x001D, 0x001E, 0x001F, 0x0020, 0x0021, 0x0022, 0x0023, 0x0024, 0x0025, 0x0026, 0x0027,
    0x0028, 0x002C, 0x002D, 0x0030, 0x0035, 0x0036, 0x0050, 0x0051, 0x0060, 0x0061, 0x0070,
};

static void each_AL_status_code_has_words_of_its_own(void **state)
{
    (void)state;
    size_t next = 0;
    for (uint32_t code = 0; code <= UINT16_MAX; code++) {
        const char *text = ect_al_status_text((uint16_t)code);
        const bool known = next < COUNT(al_status_codes) && al_status_codes[next] == code;
        if ((text != NULL) != known)
            fail_msg("0x%04X: %s", (unsigned int)code, text != NULL ? text : "no words");
        for (size_t i = 0; known && i < next; i++)
            assert_string_not_equal(text, ect_al_status_text(al_status_codes[i]));
        next += known;
    }
    assert_string_equal(ect_al_status_text(0x0011), "invalid state change requested");
    assert_string_equal(ect_al_status_text(0x001B), "process data watchdog");
    assert_string_equal(ect_al_status_text(0x0070), "module idents differ");
}

/* ETG.1000.6, table 41. */
static const uint32_t abort_codes[] = {
    0x05030000, 0x05040000, 0x05040001, 0x05040005, 0x06010000, 0x06010001, 0x06010002, 0x06010003, 0x06010004,
    0x06010005, 0x06010006, 0x06020000, 0x06040041, 0x06040042, 0x06040043, 0x06040047, 0x06060000, 0x06070010,
    0x06070012, 0x06070013, 0x06090011, 0x06090030, 0x06090031, 0x06090032, 0x06090033, 0x06090036, 0x060A0023,
    0x08000000, 0x08000020, 0x08000021, 0x08000022, 0x08000023, 0x08000024,
};

static void each_SDO_abort_code_has_words_of_its_own(void **state)
{
    (void)state;
    for (size_t i = 0; i < COUNT(abort_codes); i++) {
        const char *text = ect_abort_text(abort_codes[i]);
        if (text == NULL)
            fail_msg("0x%08X has no words", (unsigned int)abort_codes[i]);
        for (size_t k = 0; k < i; k++)
            assert_string_not_equal(text, ect_abort_text(abort_codes[k]));
    }
    for (uint32_t code = 0x05000000; code < 0x08010000; code += (code & 0xFF) == 0xFF ? 0xFF01 : 1) {
        bool known = false;
        for (size_t i = 0; i < COUNT(abort_codes); i++)
            known |= abort_codes[i] == code;
        if ((ect_abort_text(code) != NULL) != known)
            fail_msg("0x%08X: %s", (unsigned int)code, known ? "no words" : ect_abort_text(code));
    }
    assert_string_equal(ect_abort_text(0x05030000), "the toggle bit did not change");
    assert_string_equal(ect_abort_text(0x06010002), "the object is read-only");
    assert_string_equal(ect_abort_text(0x08000024), "no data");
}

/* ETG.1020, table of error codes. */
static void each_emergency_has_the_words_of_its_class(void **state)
{
    static const struct {
        uint8_t first, last;
        const char *text;
    } classes[] = {
        {0x00, 0x00, "error reset or no error"},
        {0x01, 0x0F, "unknown error"},
        {0x10, 0x10, "generic error"},
        {0x11, 0x1F, "unknown error"},
        {0x20, 0x20, "current"},
        {0x21, 0x21, "current at the input"},
        {0x22, 0x22, "current inside the device"},
        {0x23, 0x23, "current at the output"},
        {0x24, 0x2F, "current"},
        {0x30, 0x30, "voltage"},
        {0x31, 0x31, "mains voltage"},
        {0x32, 0x32, "voltage inside the device"},
        {0x33, 0x33, "output voltage"},
        {0x34, 0x3F, "voltage"},
        {0x40, 0x40, "temperature"},
        {0x41, 0x41, "ambient temperature"},
        {0x42, 0x42, "device temperature"},
        {0x43, 0x4F, "temperature"},
        {0x50, 0x5F, "device hardware"},
        {0x60, 0x60, "device software"},
        {0x61, 0x61, "internal software"},
        {0x62, 0x62, "user software"},
        {0x63, 0x63, "data set"},
        {0x64, 0x6F, "device software"},
        {0x70, 0x7F, "additional modules"},
        {0x80, 0x80, "monitoring"},
        {0x81, 0x81, "communication"},
        {0x82, 0x82, "protocol"},
        {0x83, 0x8F, "monitoring"},
        {0x90, 0x9F, "external error"},
        {0xA0, 0xAF, "state machine"},
        {0xB0, 0xEF, "unknown error"},
        {0xF0, 0xF0, "additional functions"},
        {0xF1, 0xFE, "unknown error"},
        {0xFF, 0xFF, "device-specific error"},
    };
    unsigned int codes = 0;
    (void)state;
    for (size_t i = 0; i < COUNT(classes); i++) {
        for (unsigned int code = classes[i].first * 256u; code <= classes[i].last * 256u + 255; code++, codes++) {
            if (strcmp(ect_emergency_text((uint16_t)code), classes[i].text) != 0)
                fail_msg("0x%04X: expected %s, got %s", code, classes[i].text, ect_emergency_text((uint16_t)code));
        }
    }
    assert_int_equal(codes, 65536);
}

static void each_AL_state_has_its_name_and_its_error(void **state)
{
    static const char *const names[16] = {[1] = "INIT", [2] = "PREOP", [3] = "BOOT", [4] = "SAFEOP", [8] = "OP"};
    (void)state;
    for (unsigned int value = 0; value < 256; value++) {
        char expected[32];
        const unsigned int number = value & 0x0F;
        if (names[number] != NULL)
            (void)snprintf(expected, sizeof expected, "%s%s", names[number], (value & 0x10) != 0 ? " + error" : "");
        else
            (void)snprintf(expected, sizeof expected, "state %u%s", number, (value & 0x10) != 0 ? " + error" : "");
        assert_string_equal(ect_state_text(value), expected);
    }
}

/* --- numbers ------------------------------------------------------------------------------------------------------ */

static void a_duration_is_a_number_and_its_unit(void **state)
{
    static const struct {
        const char *text;
        uint64_t ns; /* 0: none */
    } rows[] = {
        {"1us", 1000},     {"7ms", 7000000}, {"2s", 2000000000}, {"1000000s", UINT64_C(1000000000000000)},
        {"0x10us", 16000}, {"0s", 0},        {"1000001s", 0},    {"5", 0},
        {"5 s", 0},        {"ms", 0},        {"-1s", 0},         {"1sec", 0},
        {"1S", 0},         {"", 0},          {"1m", 0},          {"1ns", 0},
    };
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        uint64_t ns = 77;
        if (ect_number_time(rows[i].text, &ns) != (rows[i].ns != 0) || ns != (rows[i].ns != 0 ? rows[i].ns : 77))
            fail_msg("'%s': got %llu", rows[i].text, (unsigned long long)ns);
    }
}

static void an_option_takes_a_number_in_its_range(void **state)
{
    static const struct {
        const char *text;
        uint64_t value;
        const char *error; /* the end of it; NULL: none */
    } rows[] = {
        {"3", 3, NULL},
        {"0x5", 5, NULL},
        {"2", 3, "--seed takes a number from 3 to 5, not '2'\n"},
        {"6", 3, "--seed takes a number from 3 to 5, not '6'\n"},
        {"x", 3, "--seed takes a number from 3 to 5, not 'x'\n"},
    };
    static const struct argp argp = {.doc = "Tests"};
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        char *said = NULL;
        size_t length = 0;
        char name[] = "test";
        FILE *stream = open_memstream(&said, &length);
        assert_non_null(stream);
        struct argp_state at = {
            .root_argp = &argp, .name = name, .err_stream = stream, .out_stream = stream, .flags = ARGP_NO_EXIT};
        assert_int_equal(ect_argument_number(&at, "--seed", rows[i].text, 3, 5), rows[i].value);
        assert_int_equal(fclose(stream), 0);
        if (rows[i].error == NULL)
            assert_int_equal(length, 0);
        else if (strstr(said, rows[i].error) == NULL)
            fail_msg("'%s': got %s", rows[i].text, said);
        free(said);
    }
}

/* --- mistakes ----------------------------------------------------------------------------------------------------- */

static void the_first_mistake_of_a_file_is_one_line(void **state)
{
    char text[40] = "";
    ect_mistake_t mistake = {.path = "f.yaml", .text = text, .room = sizeof text};
    (void)state;
    ect_mistake(&mistake, 7, "'%s' is %d", "a\n\x1F\x7F\xC3\xA4 ~", 5);
    assert_true(mistake.failed);
    assert_string_equal(text, "f.yaml:7: 'a???\xC3\xA4 ~' is 5");
    ect_mistake(&mistake, 8, "another");
    assert_string_equal(text, "f.yaml:7: 'a???\xC3\xA4 ~' is 5");
}

static void a_mistake_is_cut_at_its_room(void **state)
{
    char text[12], why[400];
    ect_mistake_t mistake = {.path = "f", .text = text, .room = sizeof text - 1};
    (void)state;
    text[11] = '+';
    memset(why, 'x', sizeof why - 1);
    why[sizeof why - 1] = '\0';
    ect_mistake(&mistake, 1, "%s", why);
    assert_string_equal(text, "f:1: xxxxx");
    assert_int_equal(text[11], '+');

    char all[400] = "";
    mistake = (ect_mistake_t){.path = "f", .text = all, .room = sizeof all};
    ect_mistake(&mistake, 1, "%s", why);
    assert_int_equal(strlen(all), 5 + 299);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_AL_status_code_has_words_of_its_own),
        cmocka_unit_test(each_SDO_abort_code_has_words_of_its_own),
        cmocka_unit_test(each_emergency_has_the_words_of_its_class),
        cmocka_unit_test(each_AL_state_has_its_name_and_its_error),
        cmocka_unit_test(a_duration_is_a_number_and_its_unit),
        cmocka_unit_test(an_option_takes_a_number_in_its_range),
        cmocka_unit_test(the_first_mistake_of_a_file_is_one_line),
        cmocka_unit_test(a_mistake_is_cut_at_its_room),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
