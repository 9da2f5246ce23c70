/* SPDX-License-Identifier: MIT */
/*
 * One SOES application that uses each feature of SOES's lists and hooks (tests/soes/everything.c), from INIT to OP and
 * back: sparse records, process data out of them, Complete Access, short values, hooks, FoE, an emulated EEPROM.
 * docs/SOES.md lists the remaining differences from SOES's own stack.
 */
#include <stdio.h>
#include <string.h>

#include "seams/standard.h"
#include "soes/describe.h"
#include "soes/ect_soes.h"
#include "soes/esc_eep.h"
#include "soes/esc_foe.h"
#include "soes/everything.h"
#include "soes/hal.h"
#include "support/wire.h"

enum { INIT = ECT_STATE_INIT, PREOP = ECT_STATE_PREOP, SAFEOP = ECT_STATE_SAFEOP, OP = ECT_STATE_OP };

static wire_t w;
static ect_device_t description;
static esc_cfg_t config;
static char calls[500];

__attribute__((format(printf, 1, 2))) static void note(const char *format, ...)
{
    va_list arguments;
    size_t used = strlen(calls);
    va_start(arguments, format);
    (void)vsnprintf(calls + used, sizeof calls - used, format, arguments);
    va_end(arguments);
}

static void expect_calls(const char *want)
{
    if (strcmp(calls, want) != 0)
        fail_msg("expected the calls\n  %s\ngot\n  %s", want, calls);
    calls[0] = '\0';
}

static uint64_t now(void)
{
    return w.now_ns;
}

static void poll_application(wire_t *wire)
{
    (void)ect_esc_tick(hal.esc, wire->now_ns);
    ecat_slv();
}

static void power_on(void)
{
    memset(&hal, 0, sizeof hal);
    memset(&everything, 0, sizeof everything);
    calls[0] = '\0';
    ect_soes_describe(&description);
    description.instance_size = sizeof(ect_standard_t);
    wire_open_one(&w, &description); /* its own slave is never polled: only the chip is used */
    hal.esc = ect_chain_esc(w.chain, 0);
    w.poll = poll_application;
    ect_soes_clock(now);
    ecat_slv_init(&config);
}

static int plain(void **state)
{
    (void)state;
    memset(&w, 0, sizeof w);
    config = (esc_cfg_t){.watchdog_cnt = 100000};
    return 0;
}

static int close_all(void **state)
{
    (void)state;
    wire_close(&w);
    return 0;
}

static void open_in(uint8_t state)
{
    power_on();
    wire_go(&w, 0, state);
    calls[0] = '\0';
}

static void expect_upload(uint16_t index, uint8_t subindex, bool complete, const void *want, size_t length)
{
    uint8_t got[300];
    size_t size = sizeof got;
    uint32_t abort = wire_sdo_upload(&w, 0, index, subindex, complete, got, &size);
    if (abort != 0 || size != length || memcmp(got, want, length) != 0)
        fail_msg("%04Xh:%u: abort %08X, %zu bytes, or not as expected", index, subindex, abort, size);
}

/* --- sparse records ----------------------------------------------------------------------------------------------- */

static void sparse_process_data(void **state)
{
    uint8_t in[6], out = 0x99;
    (void)state;
    open_in(OP); /* SOES reaches it, too: 6000:12 and 7000:9 exist */
    everything.fifth = 0x0505;
    assert_int_equal(wire_write(&w, 0, SM2_sma, &out, 1), 1);
    assert_int_equal(everything.ninth, 0x99);
    assert_true(everything.outputs > 0);
    assert_int_equal(wire_read(&w, 0, SM3_sma, in, sizeof in), 1);
    assert_true(everything.twelfth - ect_load_le32(in) < 3);
    assert_int_equal(ect_load_le16(in + 4), 0x0505);
    assert_int_equal(ESCvar.sm3mappings, 2);
    assert_int_equal(SMmap3[0].obj->subindex, 12);
}

static void sparse_access(void **state)
{
    static const uint8_t whole[] = {20, 0, 0x03, 0x03, 0x20, 0x20, 0x20, 0x20};
    static const uint8_t other[] = {20, 0, 0x11, 0x22, 0x33, 0x44, 0x55, 0x66};
    uint8_t byte;
    size_t size = 1;
    (void)state;
    open_in(PREOP);
    expect_upload(0x8000, 20, false, "\x20\x20\x20\x20", 4);
    expect_upload(0x8000, 3, false, "\x03\x03", 2);
    assert_int_equal(wire_sdo_upload(&w, 0, 0x8000, 4, false, &byte, &size), ABORT_NOSUBINDEX);
    expect_upload(0x8000, 0, true, whole, sizeof whole);
    assert_int_equal(wire_sdo_download(&w, 0, 0x8000, 20, false, "\x01\x02\x03\x04", 4), 0);
    assert_int_equal(everything.twentieth, 0x04030201);
    assert_int_equal(wire_sdo_download(&w, 0, 0x8000, 0, true, other, sizeof other), 0);
    assert_int_equal(everything.third, 0x2211);
    assert_int_equal(everything.twentieth, 0x66554433);
    assert_int_equal(SDO_findsubindex(SDO_findobject(0x8000), 20), 2);
}

/* Get object description: the highest sub-index; get entry description: of the last entry. */
static void sparse_information(void **state)
{
    static const uint8_t object[] = {0x00, 0x80, 3, 0, 0, 0, 0x00, 0x60};
    static const uint8_t entry[] = {0x00, 0x80, 5, 0, 0, 0, 0x00, 0x60, 12, 0};
    uint8_t reply[100] = {0};
    (void)state;
    open_in(PREOP);
    assert_true(wire_coe(&w, 0, object, sizeof object, reply, sizeof reply) > 12);
    assert_int_equal(reply[2], 4);
    assert_int_equal(reply[10], 12);
    assert_memory_equal(reply + 12, "Sparse", 6);
    assert_true(wire_coe(&w, 0, entry, sizeof entry, reply, sizeof reply) > 16);
    assert_int_equal(reply[2], 6);
    assert_int_equal(ect_load_le16(reply + 10), DTYPE_UNSIGNED32);
    assert_int_equal(ect_load_le16(reply + 12), 32);
    assert_memory_equal(reply + 16, "Twelfth", 7);
}

/* --- values of other lengths -------------------------------------------------------------------------------------- */

/* Their memory has the values of the application. */
static void texts_without_defaults(void **state)
{
    (void)state;
    power_on();
    memcpy(everything.octets, "12345678", sizeof everything.octets);
    memcpy(everything.text, "abcdefg", 8);
    COE_initDefaultValues();
    assert_memory_equal(everything.octets, "12345678", sizeof everything.octets);
    assert_string_equal(everything.text, "abcdefg");
}

static void short_values(void **state)
{
    (void)state;
    open_in(PREOP);
    memset(everything.octets, 0xEE, sizeof everything.octets);
    assert_int_equal(wire_sdo_download(&w, 0, 0x8002, 0, false, "abc", 3), 0);
    assert_string_equal(everything.text, "abc");
    assert_int_equal(wire_sdo_download(&w, 0, 0x8001, 0, false, "12345678", 8), 0);
    expect_upload(0x8001, 0, false, "12345678", 8);
    assert_int_equal(wire_sdo_download(&w, 0, 0x8001, 0, false, "123", 3), 0x06070013); /* SOES takes it */
    expect_upload(0x8001, 0, false, "12345678", 8);
}

static uint32_t measure(uint16_t index, uint8_t subindex, void *data, size_t *size, uint16_t flags)
{
    note("%04X:%u %s%zu; ", index, subindex, (flags & COMPLETE_ACCESS_FLAG) != 0 ? "complete " : "", *size);
    if (index != 0x8003)
        return 0;
    memcpy(data, "measured", 8);
    *size = 8;
    return 0;
}

static void sizes_of_hooks(void **state)
{
    (void)state;
    config.pre_object_upload_hook = measure;
    open_in(PREOP);
    expect_upload(0x8003, 0, false, "measured", 8);
    expect_calls("8003:0 16; ");
    expect_upload(0x8000, 3, false, "\x03\x03", 2);
    expect_calls("8000:3 2; ");
}

/* --- states ------------------------------------------------------------------------------------------------------- */

static void before(uint8_t *as, uint8_t *an)
{
    note("%02X %02X state %u>", *as, *an, ESCvar.App.state);
}

static void after(uint8_t *as, uint8_t *an)
{
    (void)as;
    note("%02X state %u code %02X; ", *an, ESCvar.App.state, ESCvar.ALerror);
}

static void safe(void)
{
    note("safe; ");
}

static bool leaves;

static void leave(void)
{
    if (leaves)
        ESC_ALstatusgotoerror(ESCsafeop | ESCerror, ALERR_SYNCERROR);
    leaves = false;
}

static void states(void **state)
{
    (void)state;
    config.pre_state_change_hook = before;
    config.post_state_change_hook = after;
    config.safeoutput_override = safe;
    config.application_hook = leave;
    memset(&w, 0, sizeof w);
    power_on();
    expect_calls("safe; ");
    wire_go(&w, 0, OP);
    expect_calls(
        "21 01 state 0>02 state 0 code 00; 42 02 state 0>04 state 0 code 00; 84 04 state 1>08 state 1 code 00; ");
    assert_int_equal(wire_al(&w, 0, SAFEOP, NULL), SAFEOP);
    expect_calls("safe; 48 08 state 3>04 state 1 code 00; ");
    assert_int_equal(wire_al(&w, 0, OP, NULL), OP);
    calls[0] = '\0';
    leaves = true;
    wire_poll(&w);
    wire_poll(&w);
    expect_calls("safe; 48 08 state 1>14 state 1 code 1A; ");
    assert_int_equal(wire_al(&w, 0, OP | ECT_AL_ACKNOWLEDGE, NULL), OP);
    calls[0] = '\0';
    assert_int_equal(wire_write8(&w, 0, ECT_REG_SM + 2 * ECT_SM_SIZE + ECT_SM_ACTIVATE, 0),
                     1); /* by the stack itself */
    wire_poll(&w);
    assert_non_null(strstr(calls, ">14 state 1 ") ? calls : strstr(calls, ">12 state 0 "));
    assert_int_equal(wire_read8(&w, 0, ECT_REG_AL_STATUS) & ECT_AL_ERROR, ECT_AL_ERROR);
}

/* --- files, EEPROM ------------------------------------------------------------------------------------------------ */

static uint8_t stored[64], buffer[16];

static uint32_t store_file(foe_file_cfg_t *self, uint8_t *data, size_t length)
{
    memcpy(stored + self->address_offset, data, length);
    return 0;
}

static uint8_t foe(uint8_t operation, uint32_t number, const void *data, uint16_t length)
{
    uint8_t mail[128] = {0};
    w.mail_counter = (uint8_t)(w.mail_counter % 7 + 1);
    ect_store_le16(mail, (uint16_t)(6 + length));
    mail[5] = (uint8_t)(MBXFOE | w.mail_counter << 4);
    mail[6] = operation;
    ect_store_le32(mail + 8, number);
    memcpy(mail + 12, data, length);
    assert_int_equal(wire_mail_send(&w, 0, mail, (uint16_t)(12 + length)), 1);
    assert_true(wire_mail_receive(&w, 0, mail, sizeof mail) >= 6);
    return mail[6];
}

static void files(void **state)
{
    static foe_file_cfg_t list[] = {{.name = "notes", .max_data = 60, .write_function = store_file}};
    static foe_cfg_t cfg = {.fbuffer = buffer, .buffer_size = sizeof buffer, .n_files = 1, .files = list};
    (void)state;
    FOE_config(&cfg);
    open_in(OP);
    assert_int_equal(foe(FOE_OP_WRQ, 0, "notes", 5), FOE_OP_ACK);
    assert_int_equal(foe(FOE_OP_DATA, 1, "twenty bytes of a file", 22), FOE_OP_ACK);
    assert_memory_equal(stored, "twenty bytes of a file", 22);
    assert_int_equal(foe(FOE_OP_WRQ, 0, "other", 5), FOE_OP_ERR);
}

static uint8_t eeprom[32];

void EEP_init(void)
{
}

int8_t EEP_read(uint32_t addr, uint8_t *data, uint16_t size)
{
    memcpy(data, eeprom + addr, size);
    return 0;
}

int8_t EEP_write(uint32_t addr, uint8_t *data, uint16_t size)
{
    memcpy(eeprom + addr, data, size);
    return 0;
}

static void emulated_eeprom(void **state)
{
    (void)state;
    config.esc_hw_eep_handler = EEP_process;
    for (unsigned int n = 0; n < sizeof eeprom; n++)
        eeprom[n] = (uint8_t)n;
    open_in(PREOP);
    hal.emulated = true;
    hal.control[0] = 0x60;
    hal.control[1] = 0x80 | EEP_CMD_READ;
    hal.control[2] = 4;
    ecat_slv();
    assert_memory_equal(hal.data, eeprom + 8, 8);
    assert_int_equal(hal.acknowledged, 1);
    hal.emulated = false;
}

int main(void)
{
#define T(title, function) {title, function, plain, close_all, NULL}
    const struct CMUnitTest tests[] = {
        T("SOES: a TxPDO and an RxPDO map the last entries of sparse records, and OP is reached", sparse_process_data),
        T("SOES: the last entries of a sparse record, alone and by Complete Access, both ways", sparse_access),
        T("SOES: SDO information has the last entries of a sparse record", sparse_information),
        T("texts and octets have no default of the list", texts_without_defaults),
        T("SOES: a short text is taken, a short OCTET_STRING is refused and changes nothing", short_values),
        T("SOES: an upload hook sets the size of a value", sizes_of_hooks),
        T("SOES: outputs are safe at the start; hooks find App.state, ALerror, and 14h at a fall by error", states),
        T("SOES: FoE in OP", files),
        T("SOES: an emulated EEPROM", emulated_eeprom),
    };
    return cmocka_run_group_tests_name("soes_everything", tests, NULL, NULL);
}
