/* SPDX-License-Identifier: MIT */
/* The reader of slaves over the wire of a run (steps/reader.h): its datagrams, its results as verdicts. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "conform_support.h"
#include "steps/engine.h"
#include "steps/reader.h"

enum { SII = 256, MARK = 0x8C, CONTENT = MARK + 4 };

static uint8_t sii[SII], image[ECT_READER_SII];
static size_t image_size;
static unsigned int others; /* datagrams that address neither the slave nor all slaves */
static unsigned int others_of_reader, counter_afterwards;
static int left;      /* frames before all are lost; negative: none is lost */
static uint16_t busy; /* bits of the EEPROM's status */

/* An EEPROM behind the registers, four bytes a read. */
static bool eeprom(cf_datagram_t *d)
{
    const uint16_t ado = (uint16_t)(d->address >> 16);
    others += d->command != CF_BRD && (d->address & 0xFFFF) != CF_STATION;
    if (d->command == CF_FPWR && ado == ECT_REG_SII_CONTROL && d->length == 6) {
        const uint8_t *command = d->data;
        memcpy(memory + ECT_REG_SII_DATA, sii + 2 * (size_t)ect_load_le16(command + 2), 4);
        ((uint8_t *)d->data)[1] = (uint8_t)(busy >> 8);
    }
    left -= left > 0;
    return left != 0;
}

static void start(cf_run_t *run)
{
    start_run(run);
    on_datagram = eeprom;
    others = busy = 0;
    left = -1;
    for (size_t i = 0; i < SII; i++)
        sii[i] = (uint8_t)(3 * i);
    ect_store_le16(sii + 0x7C, SII / 128 - 1);
    ect_store_le16(sii + 0x80, 30);
    ect_store_le16(sii + 0x82, 4);
    ect_store_le16(sii + MARK, 0xFFFF);
    memory[ECT_REG_SII_CONFIG] = memory[ECT_REG_SII_CONFIG + 1] = 0;
}

static void read_content(cf_t *c)
{
    others = 0;
    c->mail_counter = 5;
    ect_reader_t *reader = cf_reader_open(c);
    cf_reader_close(c, ect_reader_sii_content(reader, image, &image_size));
    others_of_reader = others;
    counter_afterwards = c->mail_counter;
}

static void the_content_is_read_by_the_station_address(void **state)
{
    cf_run_t run;
    cf_result_t result;
    (void)state;
    start(&run);
    if (run_one(&run, read_content, 0, &result) != CF_PASS)
        fail_msg("%s", result.reason);
    assert_int_equal(image_size, CONTENT);
    assert_memory_equal(image, sii, CONTENT);
    assert_int_equal(others_of_reader, 0);
    assert_int_equal(counter_afterwards, 5); /* no mail was sent */
    end_run(&run);
}

static void read_without_frames(cf_t *c)
{
    left = 1;
    read_content(c);
}

static void read_halfway(cf_t *c)
{
    left = 40;
    read_content(c);
}

static void read_without_acknowledge(cf_t *c)
{
    busy = 0x2000;
    read_content(c);
}

static void read_interrupted(cf_t *c)
{
    ect_reader_t *reader = cf_reader_open(c);
    cf_interrupted = 1;
    cf_reader_close(c, ect_reader_sii(reader, image, SII, &image_size));
}

static void read_too_late(cf_t *c)
{
    ect_reader_t *reader = cf_reader_open(c);
    c->engine->deadline_ns = 1;
    cf_reader_close(c, ECT_READER_STOPPED);
    (void)reader;
}

static void results_are_verdicts(void **state)
{
    static const struct {
        const char *title;
        void (*function)(cf_t *c);
        cf_verdict_t verdict;
        const char *reason;
    } cases[] = {
        {"no frame returns", read_without_frames, CF_FAIL, "no frame returns"},
        {"frames stop on the way", read_halfway, CF_FAIL, "no frame returns (0x050"},
        {"the EEPROM does not acknowledge", read_without_acknowledge, CF_FAIL, "the EEPROM does not acknowledge"},
        {"Ctrl-C", read_interrupted, CF_INTERRUPTED, "interrupted"},
        {"the time limit of the case", read_too_late, CF_FAIL, "time limit: not finished within"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        cf_run_t run;
        cf_result_t result;
        start(&run);
        const cf_verdict_t verdict = run_one(&run, cases[i].function, 0, &result);
        cf_interrupted = 0;
        if (verdict != cases[i].verdict || strstr(result.reason, cases[i].reason) == NULL)
            fail_msg("%s: got verdict %d, '%s'", cases[i].title, (int)verdict, result.reason);
        end_run(&run);
    }
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"The content of an EEPROM is read by the station address, the mail counter continues",
         the_content_is_read_by_the_station_address, NULL, NULL, NULL},
        {"Results of the reader are verdicts with its text", results_are_verdicts, NULL, NULL, NULL},
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Reader of ectwin-conform", tests, NULL, NULL);
}
