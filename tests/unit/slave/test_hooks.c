/* SPDX-License-Identifier: MIT */
/* A device's reactions to an SDO: refuse, supply data, check a value before it is stored (device.h). */
#include <stdlib.h>
#include <string.h>

#include "seams/mailbox.h"
#include "support/testdev.h"
#include "support/wire.h"

enum { OCTETS = 1000, OWN_CODE = 0x0609ABCD };

/* Results of the hooks, and their calls; one slave at a time. */
static struct {
    ect_reason_t read_answer, write_answer;
    const void *supply;
    uint16_t supply_size;
    unsigned int reads, writes;
    uint16_t index, subindex, size;
    bool whole, stored_before;
} hooks;

static ect_reason_t sdo_read(void *instance, uint16_t index, uint16_t subindex, ect_span_t *instead)
{
    (void)instance;
    hooks.reads++;
    hooks.index = index;
    hooks.subindex = subindex;
    hooks.whole = instead == NULL;
    if (hooks.supply && instead)
        *instead = (ect_span_t){hooks.supply, hooks.supply_size};
    return hooks.read_answer;
}

static ect_reason_t sdo_write(void *instance, uint16_t index, uint8_t subindex, const void *data, uint16_t size)
{
    const testdev_t *t = instance;
    hooks.writes++;
    hooks.index = index;
    hooks.subindex = subindex;
    hooks.size = size;
    if (index == 0x2002)
        hooks.stored_before = memcmp(t->octets, data, size) == 0;
    return hooks.write_answer;
}

static void open_hooked(wire_t *w)
{
    static ect_device_t device;
    device = testdev;
    device.sdo_read = sdo_read;
    device.sdo_write = sdo_write;
    memset(&hooks, 0, sizeof hooks);
    wire_open_one(w, &device);
    wire_go(w, 0, ECT_STATE_PREOP);
}

static testdev_t *instance_of(wire_t *w)
{
    return ect_chain_slave(w->chain, 0)->config.instance;
}

static void expect_code(const char *what, uint32_t got, uint32_t want)
{
    if (got != want)
        fail_msg("%s: expected abort code %08X, got %08X", what, want, got);
}

static void read_refused(void **state)
{
    static const struct {
        ect_reason_t answer;
        uint32_t code;
    } rows[] = {{ECT_REASON_LOCAL_CONTROL, 0x08000021}, {ECT_REASON_STATE, 0x08000022}, {OWN_CODE, OWN_CODE}};
    uint8_t data[64];
    wire_t w;
    (void)state;
    open_hooked(&w);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        for (unsigned int complete = 0; complete < 2; complete++) {
            size_t size = sizeof data;
            hooks.read_answer = rows[i].answer;
            expect_code("read", wire_sdo_upload(&w, 0, 0x2006, complete ? 0 : 4, complete, data, &size), rows[i].code);
            assert_int_equal(hooks.index, 0x2006);
            assert_int_equal(hooks.subindex, complete ? ECT_WHOLE_OBJECT : 4);
            assert_int_equal(hooks.whole, complete);
        }
    }
    hooks.read_answer = ECT_OK;
    size_t size = sizeof data;
    expect_code("allowed again", wire_sdo_upload(&w, 0, 0x2006, 4, false, data, &size), 0);
    unsigned int before = hooks.reads;
    size = sizeof data;
    expect_code("the hook of an unreadable entry is not called", wire_sdo_upload(&w, 0, 0x2003, 0, false, data, &size),
                0x06010001);
    assert_int_equal(hooks.reads, before);
    wire_close(&w);
}

/* Data of any length: expedited, normal, segmented, empty. The next read returns the entry's own value again. */
static void read_supplied(void **state)
{
    static const uint16_t sizes[] = {0, 1, 4, 5, 100, 112, 113, 1000, 5000};
    static uint8_t supply[5000], got[6000];
    wire_t w;
    (void)state;
    open_hooked(&w);
    for (size_t i = 0; i < sizeof supply; i++)
        supply[i] = (uint8_t)(i * 11 + i / 251);
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        size_t size = sizeof got;
        hooks.supply = supply;
        hooks.supply_size = sizes[i];
        expect_code("supplied", wire_sdo_upload(&w, 0, 0x2000, 0, false, got, &size), 0);
        if (size != sizes[i] || memcmp(got, supply, size) != 0)
            fail_msg("%u bytes supplied: %zu came, or others", sizes[i], size);
        hooks.supply = NULL;
        size = sizeof got;
        expect_code("its own", wire_sdo_upload(&w, 0, 0x2000, 0, false, got, &size), 0);
        assert_int_equal(size, 4);
        assert_int_equal(ect_load_le32(got), 0x11223344);
    }
    wire_close(&w);
}

/* In as many segments as the mailbox requires: the device gets the whole value, once, before any of it is stored. */
static void long_write_checked(void **state)
{
    static uint8_t data[OCTETS], nothing[OCTETS];
    wire_t w;
    (void)state;
    open_hooked(&w);
    testdev_t *t = instance_of(&w);
    for (size_t i = 0; i < OCTETS; i++)
        data[i] = (uint8_t)(i + 1);
    hooks.write_answer = OWN_CODE;
    expect_code("refused", wire_sdo_download(&w, 0, 0x2002, 0, false, data, OCTETS), OWN_CODE);
    assert_int_equal(hooks.writes, 1);
    assert_int_equal(hooks.size, OCTETS);
    assert_memory_equal(t->octets, nothing, OCTETS);
    assert_int_equal(t->written, 0);
    hooks.write_answer = ECT_OK;
    expect_code("allowed", wire_sdo_download(&w, 0, 0x2002, 0, false, data, OCTETS), 0);
    assert_int_equal(hooks.writes, 2);
    assert_false(hooks.stored_before);
    assert_memory_equal(t->octets, data, OCTETS);
    assert_int_equal(t->written, 1);
    wire_close(&w);
}

static void staging_too_small(void **state)
{
    static uint8_t data[OCTETS], nothing[OCTETS];
    wire_t w;
    (void)state;
    open_hooked(&w);
    ect_slave_t *s = (ect_slave_t *)(uintptr_t)ect_chain_slave(w.chain, 0);
    memset(data, 0x5A, sizeof data);
    assert_int_equal(s->config.staging_size, OCTETS);
    s->config.staging_size = OCTETS - 1;
    expect_code("no room to collect it", wire_sdo_download(&w, 0, 0x2002, 0, false, data, OCTETS), 0x05040005);
    assert_memory_equal(instance_of(&w)->octets, nothing, OCTETS);
    assert_int_equal(hooks.writes, 0);
    s->config.staging_size = 0;
    uint32_t number = 77;
    expect_code("an expedited download needs no buffer", wire_sdo_download(&w, 0, 0x2000, 0, false, &number, 4), 0);
    wire_close(&w);
}

enum { MAILBOX = 128, LAST = MAILBOX - 1 };

static uint8_t built[MAILBOX]; /* the last mail that the hook was called with */
static uint16_t built_size;

static void mail(void *instance, uint8_t *mail, uint16_t size)
{
    (void)instance;
    memcpy(built, mail, MAILBOX);
    built_size = size;
    mail[12] ^= 0xFF;
    mail[LAST] = 0x5A;
}

/* A device changes a complete mail before the master reads it, and a repetition is the changed mail. */
static void mails_changed(void **state)
{
    enum { ACTIVATE = ECT_REG_SM + ECT_SM_SIZE + ECT_SM_ACTIVATE };
    static const uint8_t upload[] = {0x00, 0x20, 0x40, 0x00, 0x20, 0, 0, 0, 0, 0};
    ect_device_t device = testdev;
    uint8_t got[MAILBOX], again[MAILBOX];
    wire_t w;
    (void)state;
    device.mail = mail;
    wire_open_one(&w, &device);
    wire_go(&w, 0, ECT_STATE_PREOP);
    assert_int_equal(wire_mail_request(&w, 0, ECT_MAILBOX_TYPE_COE, upload, sizeof upload), 1);
    assert_int_equal(wire_mail_receive(&w, 0, got, sizeof got), 10);
    assert_int_equal(built_size, MAILBOX);
    assert_int_equal(ect_load_le16(built), 10);
    assert_int_equal(built[5], ECT_MAILBOX_TYPE_COE | 1 << 4);
    assert_int_equal(ect_load_le32(built + 12), 0x11223344);
    assert_int_equal(ect_load_le32(got + 12), 0x112233BB);
    assert_int_equal(got[LAST], 0x5A);
    wire_write8(&w, 0, ACTIVATE, wire_read8(&w, 0, ACTIVATE) ^ ECT_SM_ACTIVATE_REPEAT);
    assert_int_equal(wire_mail_receive(&w, 0, again, sizeof again), 10);
    assert_memory_equal(again, got, sizeof got);
    wire_close(&w);
}

/* A device that waits for nothing has its time once more after each entry that a master has written, and only then. */
static void time_after_a_write(void **state)
{
    uint32_t number = 77;
    uint8_t data[OCTETS] = {0};
    size_t size = sizeof data;
    wire_t w;
    (void)state;
    wire_open_one(&w, &testdev);
    wire_go(&w, 0, ECT_STATE_PREOP);
    const testdev_t *t = instance_of(&w);
    const unsigned int before = t->ticks;
    expect_code("read", wire_sdo_upload(&w, 0, 0x2000, 0, false, data, &size), 0);
    assert_int_equal(t->ticks, before);
    expect_code("written", wire_sdo_download(&w, 0, 0x2000, 0, false, &number, 4), 0);
    assert_int_equal(t->ticks, before + 1);
    expect_code("written in segments", wire_sdo_download(&w, 0, 0x2002, 0, false, data, OCTETS), 0);
    assert_int_equal(t->ticks, before + 2);
    expect_code("refused", wire_sdo_download(&w, 0, 0x1000, 0, false, &number, 4), 0x06010002);
    assert_int_equal(t->ticks, before + 2);
    wire_close(&w);
}

/* A device's buffer: of its size, zero, at the same address after a power cycle with new content; or missing. */
static void buffer(void **state)
{
    ect_device_t device = testdev;
    wire_t w;
    (void)state;
    wire_open_one(&w, &device);
    assert_null(instance_of(&w)->host->buffer);
    wire_close(&w);
    device.buffer_size = 100000;
    assert_int_equal(ect_slave_memory(&device).buffer, 100000);
    wire_open_one(&w, &device);
    uint8_t *memory = instance_of(&w)->host->buffer;
    assert_non_null(memory);
    assert_int_equal(memory[0] | memory[99999], 0);
    memory[0] = memory[99999] = 1;
    ect_chain_power_cycle(w.chain, w.now_ns);
    assert_ptr_equal(instance_of(&w)->host->buffer, memory);
    assert_int_equal(memory[0] | memory[99999], 0);
    wire_close(&w);
}

int main(int argc, char **argv)
{
#define T(title, test) {title, test, NULL, NULL, NULL}
    const struct CMUnitTest tests[] = {
        T("CF-070: a device refuses a read, of an entry and of a whole object, with a reason or its own code",
          read_refused),
        T("CF-069: a device supplies the data of a read, at any length", read_supplied),
        T("CF-070: the device gets a long value as a whole before any part is stored", long_write_checked),
        T("CF-070: a long value without a buffer is refused as out of memory, and changes nothing", staging_too_small),
        T("a device changes a mail to the master, which is also repeated so", mails_changed),
        T("a device has its time after an entry was written", time_after_a_write),
        T("a device has its big buffer, zero at each power-on, if the host supplies one", buffer),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("Hooks", tests, NULL, NULL);
}
