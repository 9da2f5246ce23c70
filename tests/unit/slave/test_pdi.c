/* SPDX-License-Identifier: MIT */
/* The slave behind its PDI: the number of accesses, and the behaviour after a failed access or a reset. */
#include <stdio.h>
#include <string.h>

#include "devices/optoncdt2300/optoncdt2300.h"
#include "support/testdev.h"
#include "support/wire.h"

#define COUNT(a) (sizeof(a) / sizeof((a)[0]))

enum { SM0 = 0x1000, SM1 = 0x1080, SM2 = 0x1200, SM3 = 0x1300, SIZE = 128, IMAGE = 3 };
enum { INIT = ECT_STATE_INIT, PREOP = ECT_STATE_PREOP, SAFEOP = ECT_STATE_SAFEOP, OP = ECT_STATE_OP };
enum { ERR = ECT_AL_ERROR, ACK = ECT_AL_ACKNOWLEDGE };

/* --- a PDI that counts and fails --------------------------------------------------------------------------------- */

typedef enum fault {
    NO_FAULT,
    FAIL_BEFORE, /* the access does not happen */
    FAIL_AFTER,  /* it is executed, but reported as failed */
    RESET,       /* the slave's processor restarts here */
} fault_t;

typedef struct rig {
    wire_t w;
    ect_pdi_t real;
    ect_pdi_t pdi;
    ect_slave_t *slave;
    unsigned int accesses;
    unsigned int bytes;
    unsigned int fault_at; /* the access that fails, counted from 1; 0: none */
    fault_t fault;
    uint16_t fault_address; /* the next access that begins here fails; 0: none */
    uint8_t last_counter;   /* of the slave's mails; 0: none so far */
    bool dead;              /* between a RESET and the restart */
    char lie[96];           /* the first wrong AL status */
} rig_t;

static const uint8_t *memory(const rig_t *r)
{
    return ((const ect_esc_t *)r->real.ctx)->memory;
}

static bool sm_off(const rig_t *r, unsigned int n)
{
    return (memory(r)[ECT_REG_SM + ECT_SM_SIZE * n + ECT_SM_PDI_CONTROL] & ECT_SM_PDI_DISABLE) != 0;
}

/* Compares AL status with the actual state of the slave. */
static void check_truth(rig_t *r)
{
    const testdev_t *t = r->slave->config.instance;
    uint8_t s = memory(r)[ECT_REG_AL_STATUS] & 0x0F;
    bool no_inputs = (~memory(r)[ECT_REG_SM + 3 * ECT_SM_SIZE + ECT_SM_STATUS] & ECT_SM_STATUS_BUFFER) == 0;
    if (r->lie[0] != 0)
        return;
    for (unsigned int n = 0; n < 4; n++) {
        bool want_off = n < 2 ? s == INIT : s < SAFEOP;
        if (sm_off(r, n) != want_off)
            (void)snprintf(r->lie, sizeof r->lie, "state %u reported with SM%u %s", s, n, want_off ? "on" : "off");
    }
    if (s >= SAFEOP && no_inputs)
        (void)snprintf(r->lie, sizeof r->lie, "state %u reported without inputs", s);
    if (s != OP && (t->out_u16 != 0 || t->out_bool != 0))
        (void)snprintf(r->lie, sizeof r->lie, "state %u reported with outputs 0x%04X", s, t->out_u16);
}

static fault_t next_access(rig_t *r, uint16_t address)
{
    bool now = ++r->accesses == r->fault_at;
    if (r->fault_address != 0 && address == r->fault_address) {
        r->fault_address = 0;
        now = true;
    }
    if (now && r->fault == RESET)
        r->dead = true;
    if (r->dead)
        return FAIL_BEFORE;
    return now ? r->fault : NO_FAULT;
}

static int rig_read(void *ctx, uint16_t address, void *buffer, uint16_t length)
{
    rig_t *r = ctx;
    fault_t fault = next_access(r, address);
    r->bytes += length;
    if (fault != FAIL_BEFORE)
        (void)r->real.read(r->real.ctx, address, buffer, length);
    if (fault != NO_FAULT)
        memset(buffer, 0xA5, length); /* undefined, according to the seam */
    return fault == NO_FAULT ? 0 : -1;
}

static int rig_write(void *ctx, uint16_t address, const void *buffer, uint16_t length)
{
    rig_t *r = ctx;
    fault_t fault = next_access(r, address);
    r->bytes += length;
    if (fault != FAIL_BEFORE) {
        (void)r->real.write(r->real.ctx, address, buffer, length);
        if (address == ECT_REG_AL_STATUS)
            check_truth(r);
    }
    return fault == NO_FAULT ? 0 : -1;
}

/* Power-on; repeated after a failure, as in a main loop. */
static void start_slave(rig_t *r)
{
    int result = -1;
    for (unsigned int n = 0; n < 3 && result != 0; n++) {
        ect_slave_config_t config = r->slave->config;
        r->dead = false;
        memset(config.mailbox, 0xC3, ect_slave_memory(config.device).mailbox);
        memset(config.instance, 0, config.device->instance_size);
        result = ect_slave_init(r->slave, &config, r->w.now_ns);
        assert_true(result == 0 || result == -3);
    }
    assert_int_equal(result, 0);
}

static void rig_open(rig_t *r, fault_t fault, unsigned int at)
{
    memset(r, 0, sizeof *r);
    wire_open_one(&r->w, &testdev);
    r->w.manual_poll = true;
    r->slave = (ect_slave_t *)(uintptr_t)ect_chain_slave(r->w.chain, 0);
    r->real = *r->slave->config.pdi;
    r->pdi = (ect_pdi_t){.ctx = r, .read = rig_read, .write = rig_write};
    r->slave->config.pdi = &r->pdi;
    r->fault = fault;
    r->fault_at = at;
    start_slave(r);
}

static void rig_close(rig_t *r)
{
    wire_close(&r->w);
}

static void poll_once(rig_t *r)
{
    (void)ect_slave_poll(r->slave, r->w.now_ns);
    if (r->dead)
        start_slave(r);
}

static unsigned int polled(rig_t *r)
{
    unsigned int before = r->accesses;
    poll_once(r);
    return r->accesses - before;
}

/* The slave's main loop for some milliseconds. */
static void run(rig_t *r, unsigned int ms)
{
    for (unsigned int n = 0; n < ms; n++) {
        r->w.now_ns += MS;
        (void)ect_esc_tick(ect_chain_esc(r->w.chain, 0), r->w.now_ns);
        poll_once(r);
    }
}

static uint8_t al(rig_t *r, uint16_t *code)
{
    uint8_t bytes[6] = {0};
    assert_int_equal(wire_read(&r->w, 0, ECT_REG_AL_STATUS, bytes, 6), 1);
    if (code)
        *code = ect_load_le16(bytes + 4);
    return bytes[0];
}

static int outputs(rig_t *r, uint8_t value)
{
    uint8_t image[IMAGE];
    memset(image, value, sizeof image);
    return wire_write(&r->w, 0, SM2, image, IMAGE);
}

/* --- a master that starts the slave ------------------------------------------------------------------------------ */

/* Waits for a state; requests it a second time if `again`. A request that the ESC does not accept is repeated until it
 * does. */
static bool await(rig_t *r, uint16_t request, bool again)
{
    uint8_t state = request & 0x0F;
    bool taken = false;
    for (unsigned int n = 0; n < 40; n++) {
        if (!taken || (again && n == 20))
            taken = wire_write16(&r->w, 0, ECT_REG_AL_CONTROL, request) == 1;
        if (state == OP)
            (void)outputs(r, 0);
        run(r, 1);
        if (taken && al(r, NULL) == state)
            return true;
    }
    return false;
}

/* The next mail; a mail with the counter of the previous one is a repetition and is ignored. */
static bool fetch(rig_t *r, uint8_t mail[SIZE])
{
    for (unsigned int n = 0; n < 10; n++) {
        run(r, 1);
        if (wire_read(&r->w, 0, SM1, mail, SIZE) != 1)
            continue;
        uint8_t counter = (mail[5] >> 4) & 7;
        if (counter == r->last_counter)
            continue;
        r->last_counter = counter;
        return true;
    }
    return false;
}

/* One expedited SDO; the reply must match the request, with zeros behind its end. */
static bool sdo(rig_t *r, uint8_t command, uint32_t value, uint8_t mail[SIZE], bool again)
{
    uint8_t request[SIZE] = {10};
    r->w.mail_counter = (uint8_t)(r->w.mail_counter % 7 + 1);
    request[5] = (uint8_t)(3 | (r->w.mail_counter << 4));
    request[7] = 0x20;
    request[8] = command;
    ect_store_le16(request + 9, 0x2000);
    ect_store_le32(request + 12, value);
    (void)wire_write(&r->w, 0, SM0, request, SIZE);
    bool got = fetch(r, mail);
    if (!got && again) {
        (void)wire_write(&r->w, 0, SM0, request, SIZE);
        got = fetch(r, mail);
    }
    if (!got)
        return false;
    if (ect_load_le16(mail) != 10 || (mail[5] & 0x8F) != 3 || (mail[5] & 0x70) == 0 ||
        mail[8] != (command == 0x23 ? 0x60 : 0x43) || ect_load_le16(mail + 9) != 0x2000)
        fail_msg("a wrong reply to command 0x%02X: length %u, header 0x%02X, command 0x%02X", command,
                 ect_load_le16(mail), mail[5], mail[8]);
    for (unsigned int i = 16; i < SIZE; i++) {
        if (mail[i] != 0)
            fail_msg("byte %u behind the end of a reply is 0x%02X", i, mail[i]);
    }
    return true;
}

static bool mailbox_works(rig_t *r, uint32_t value, bool again)
{
    uint8_t mail[SIZE];
    if (!sdo(r, 0x23, value, mail, again) || !sdo(r, 0x40, 0, mail, again))
        return false;
    if (ect_load_le32(mail + 12) != value)
        fail_msg("wrote 0x%08X, read back 0x%08X", value, ect_load_le32(mail + 12));
    /* a repetition may have left the same reply once more: ignore it */
    (void)(again && fetch(r, mail));
    return true;
}

static bool process_data_works(rig_t *r, uint8_t value)
{
    const testdev_t *t = r->slave->config.instance;
    uint8_t image[IMAGE];
    for (unsigned int n = 0; n < 5; n++) {
        (void)outputs(r, value);
        run(r, 1);
    }
    return al(r, NULL) == OP && t->out_u16 == (value == 0 ? 0 : value * 0x0101) &&
           wire_read(&r->w, 0, SM3, image, IMAGE) == 1;
}

static bool up_to_op(rig_t *r, bool again)
{
    wire_configure_process_data(&r->w, 0);
    if (!await(r, SAFEOP, again))
        return false;
    uint8_t image[IMAGE];
    if (wire_read(&r->w, 0, SM3, image, IMAGE) != 1)
        fail_msg("SAFEOP is reported, the inputs cannot be read");
    return await(r, OP, again) && process_data_works(r, 0xFF);
}

/* INIT, PREOP, SDO, SAFEOP, OP, PREOP, OP. */
static bool start(rig_t *r, bool again)
{
    if (!await(r, INIT | ACK, again))
        return false;
    wire_configure_mailbox(&r->w, 0);
    r->w.mail_counter = 0;
    r->last_counter = 0;
    if (!await(r, PREOP, again))
        return false;
    if ((wire_read8(&r->w, 0, ECT_REG_SM + 8 + ECT_SM_STATUS) & ECT_SM_STATUS_FULL) != 0)
        fail_msg("there is an unexpected mail in SM1");
    if (!mailbox_works(r, 0xCAFE0001, again) || !up_to_op(r, again) || !await(r, PREOP, again))
        return false;
    if (((const testdev_t *)r->slave->config.instance)->out_u16 != 0)
        fail_msg("outputs not safe in PREOP");
    return mailbox_works(r, 0x12345678, again) && up_to_op(r, again);
}

/* --- budget ------------------------------------------------------------------------------------------------------ */

static void go(rig_t *r, uint8_t state)
{
    rig_open(r, NO_FAULT, 0);
    r->w.manual_poll = false;
    wire_go(&r->w, 0, state);
    r->w.manual_poll = true;
    run(r, 2);
}

static void idle_budget(void **state)
{
    (void)state;
    static const uint8_t states[] = {INIT, PREOP, SAFEOP, OP};
    for (size_t s = 0; s < COUNT(states); s++) {
        rig_t r;
        go(&r, states[s]);
        for (unsigned int n = 0; n < 5; n++) {
            unsigned int count = polled(&r);
            if (count > 1)
                fail_msg("idle poll %u in state %u: %u accesses", n, states[s], count);
        }
        rig_close(&r);
    }
}

static void cyclic_budget(void **state)
{
    (void)state;
    static const uint8_t states[] = {SAFEOP, OP};
    for (size_t s = 0; s < COUNT(states); s++) {
        rig_t r;
        uint8_t image[IMAGE];
        go(&r, states[s]);
        for (unsigned int n = 0; n < 20; n++) {
            assert_int_equal(outputs(&r, (uint8_t)n), 1);
            assert_int_equal(wire_read(&r.w, 0, SM3, image, IMAGE), 1);
            unsigned int count = polled(&r);
            if (count > 3)
                fail_msg("cycle %u in state %u: %u accesses", n, states[s], count);
        }
        rig_close(&r);
    }
}

/* With a mailbox of any size: a mail and its last byte in each direction, and the registers that report them; in OP
 * the inputs follow. The first reply writes all of SM1, because the previous content is unknown. */
static void sdo_budget(void **state)
{
    (void)state;
    enum { MAIL = 16 + 1, EVENT = 4 };
    static const uint8_t commands[] = {0x40, 0x23};
    for (size_t c = 0; c < COUNT(commands); c++) {
        for (unsigned int in_op = 0; in_op <= 1; in_op++) {
            rig_t r;
            go(&r, in_op != 0 ? OP : PREOP);
            for (uint8_t n = 1; n <= 10; n++) {
                uint8_t mail[SIZE] = {10, 0,    0,           0,    0,   (uint8_t)((n % 7 + 1) << 4 | 3),
                                      0,  0x20, commands[c], 0x00, 0x20};
                assert_int_equal(wire_write(&r.w, 0, SM0, mail, SIZE), 1);
                unsigned int bytes = r.bytes;
                unsigned int count = polled(&r);
                assert_int_equal(wire_read(&r.w, 0, SM1, mail, SIZE), 1);
                assert_int_equal(mail[8], commands[c] == 0x40 ? 0x43 : 0x60);
                count += polled(&r);
                bytes = r.bytes - bytes;
                if (count > 7 || (n > 1 && bytes > 2 * (MAIL + EVENT) + in_op * IMAGE))
                    fail_msg("SDO %u, command 0x%02X: %u accesses, %u bytes", n, commands[c], count, bytes);
            }
            rig_close(&r);
        }
    }
}

static void transition_budget(void **state)
{
    (void)state;
    static const uint8_t walk[] = {PREOP, SAFEOP, OP, SAFEOP, PREOP, INIT, PREOP, SAFEOP, OP, PREOP, SAFEOP, OP, INIT};
    rig_t r;
    go(&r, INIT);
    wire_configure_mailbox(&r.w, 0);
    wire_configure_process_data(&r.w, 0);
    run(&r, 2);
    for (size_t i = 0; i < COUNT(walk); i++) {
        if (walk[i] == OP) {
            assert_int_equal(outputs(&r, 0), 1);
            run(&r, 1);
        }
        assert_int_equal(wire_write16(&r.w, 0, ECT_REG_AL_CONTROL, walk[i]), 1);
        unsigned int count = polled(&r);
        if (al(&r, NULL) != walk[i] || count > 10)
            fail_msg("step %zu to state %u: AL status 0x%02X, %u accesses", i, walk[i], al(&r, NULL), count);
    }
    rig_close(&r);
}

/* --- one access fails -------------------------------------------------------------------------------------------- */

static unsigned int accesses_of_a_start(void)
{
    rig_t r;
    rig_open(&r, NO_FAULT, 0);
    assert_true(start(&r, false));
    assert_int_equal(r.lie[0], 0);
    assert_int_equal(r.slave->pdi_errors, 0);
    unsigned int count = r.accesses;
    rig_close(&r);
    return count;
}

static void expect_truth(const rig_t *r, unsigned int k)
{
    if (r->lie[0] != 0)
        fail_msg("fault at access %u: %s", k, r->lie);
}

static void fails_before(void **state)
{
    (void)state;
    unsigned int count = accesses_of_a_start();
    for (unsigned int k = 1; k <= count; k++) {
        rig_t r;
        rig_open(&r, FAIL_BEFORE, k);
        bool first = start(&r, false);
        expect_truth(&r, k);
        if (!first)
            fail_msg("access %u does not happen: the start ends in AL status 0x%02X", k, al(&r, NULL));
        if (!start(&r, false))
            fail_msg("access %u did not happen: the second start ends in AL status 0x%02X", k, al(&r, NULL));
        expect_truth(&r, k);
        rig_close(&r);
    }
}

static void fails_after(void **state)
{
    (void)state;
    unsigned int count = accesses_of_a_start();
    for (unsigned int k = 1; k <= count; k++) {
        rig_t r;
        rig_open(&r, FAIL_AFTER, k);
        bool first = start(&r, true);
        expect_truth(&r, k);
        if (!first)
            fail_msg("access %u happens, and an error is reported: the start ends in AL status 0x%02X", k,
                     al(&r, NULL));
        if (!start(&r, false))
            fail_msg("access %u: the second start ends in AL status 0x%02X", k, al(&r, NULL));
        expect_truth(&r, k);
        rig_close(&r);
    }
}

static void resets(void **state)
{
    (void)state;
    unsigned int count = accesses_of_a_start();
    for (unsigned int k = 1; k <= count; k++) {
        rig_t r;
        rig_open(&r, RESET, k);
        (void)start(&r, true);
        expect_truth(&r, k);
        if (!start(&r, false))
            fail_msg("slave reset at access %u: the second start ends in AL status 0x%02X", k, al(&r, NULL));
        expect_truth(&r, k);
        rig_close(&r);
    }
}

/* Every access in a period fails, in any state: nothing changes, and then the slave continues. */
static void fails_for_a_while(void **state)
{
    (void)state;
    static const uint8_t states[] = {INIT, PREOP, SAFEOP, OP};
    for (size_t s = 0; s < COUNT(states); s++) {
        rig_t r;
        go(&r, states[s]);
        wire_write16(&r.w, 0, ECT_REG_WD_TIME_PD, 0);
        outputs(&r, 0x55);
        run(&r, 1);
        uint16_t out = testdev_of(&r.w, 0)->out_u16;
        r.fault = FAIL_BEFORE;
        for (unsigned int n = 0; n < 50; n++) {
            r.fault_at = r.accesses + 1;
            uint64_t next = ect_slave_poll(r.slave, r.w.now_ns);
            assert_true(next > r.w.now_ns && next <= r.w.now_ns + 10 * MS);
            assert_int_equal(r.slave->state, states[s]);
            r.w.now_ns += MS;
        }
        assert_int_equal(r.slave->pdi_errors, 50);
        assert_int_equal(testdev_of(&r.w, 0)->out_u16, out);
        run(&r, 3);
        assert_int_equal(al(&r, NULL), states[s]);
        assert_true(start(&r, false));
        expect_truth(&r, 0);
        rig_close(&r);
    }
}

/* --- particular accesses ----------------------------------------------------------------------------------------- */

static const fault_t both_faults[] = {FAIL_BEFORE, FAIL_AFTER};

static void arm(rig_t *r, fault_t fault, uint16_t address)
{
    r->fault = fault;
    r->fault_address = address;
}

static void al_control_not_lost(void **state)
{
    (void)state;
    for (size_t f = 0; f < COUNT(both_faults); f++) {
        rig_t r;
        go(&r, OP);
        arm(&r, both_faults[f], ECT_REG_AL_CONTROL);
        assert_int_equal(wire_write16(&r.w, 0, ECT_REG_AL_CONTROL, INIT), 1);
        run(&r, 10);
        if (al(&r, NULL) != INIT)
            fail_msg("the read of AL control failed %s the ESC saw it: AL status 0x%02X 10 ms later",
                     f == 0 ? "before" : "after", al(&r, NULL));
        rig_close(&r);
    }
}

static void sm_change_not_lost(void **state)
{
    (void)state;
    static const struct {
        unsigned int sm;
        uint8_t status;
        uint16_t code;
    } rows[] = {{0, INIT | ERR, 0x0016}, {1, INIT | ERR, 0x0016}, {2, PREOP | ERR, 0x001D}, {3, PREOP | ERR, 0x001E}};
    for (size_t f = 0; f < COUNT(both_faults); f++) {
        for (size_t i = 0; i < COUNT(rows); i++) {
            rig_t r;
            uint16_t code;
            go(&r, OP);
            outputs(&r, 0xFF);
            run(&r, 1);
            arm(&r, both_faults[f], ECT_REG_SM);
            wire_write8(&r.w, 0, (uint16_t)(ECT_REG_SM + 8 * rows[i].sm + ECT_SM_ACTIVATE), 0);
            run(&r, 10);
            uint8_t status = al(&r, &code);
            if (status != rows[i].status || code != rows[i].code || testdev_of(&r.w, 0)->out_u16 != 0)
                fail_msg("SM%u off, the read of the SMs failed %s the ESC saw it: AL status 0x%02X code 0x%04X",
                         rows[i].sm, f == 0 ? "before" : "after", status, code);
            rig_close(&r);
        }
    }
}

static void watchdog_not_lost(void **state)
{
    (void)state;
    for (size_t f = 0; f < COUNT(both_faults); f++) {
        rig_t r;
        uint16_t code;
        go(&r, OP);
        outputs(&r, 0xFF);
        run(&r, 1);
        arm(&r, both_faults[f], ECT_REG_WD_STATUS_PD);
        run(&r, 120);
        uint8_t status = al(&r, &code);
        if (status != (SAFEOP | ERR) || code != 0x001B || testdev_of(&r.w, 0)->out_u16 != 0)
            fail_msg("the read of the watchdog status failed %s the ESC saw it: AL status 0x%02X, outputs 0x%04X",
                     f == 0 ? "before" : "after", status, testdev_of(&r.w, 0)->out_u16);
        rig_close(&r);
    }
}

static void outputs_come_later(void **state)
{
    (void)state;
    rig_t r;
    go(&r, OP);
    arm(&r, FAIL_BEFORE, SM2);
    outputs(&r, 0x77);
    poll_once(&r);
    assert_int_equal(testdev_of(&r.w, 0)->out_u16, 0);
    run(&r, 2);
    assert_int_equal(testdev_of(&r.w, 0)->out_u16, 0x7777);
    arm(&r, FAIL_AFTER, SM2);
    outputs(&r, 0x11);
    poll_once(&r);
    assert_int_equal(testdev_of(&r.w, 0)->out_u16, 0x7777);
    outputs(&r, 0x22);
    poll_once(&r);
    assert_int_equal(testdev_of(&r.w, 0)->out_u16, 0x2222);
    rig_close(&r);
}

static void inputs_come_later(void **state)
{
    (void)state;
    for (size_t f = 0; f < COUNT(both_faults); f++) {
        rig_t r;
        uint8_t image[IMAGE];
        go(&r, SAFEOP);
        assert_int_equal(wire_read(&r.w, 0, SM3, image, IMAGE), 1);
        testdev_of(&r.w, 0)->in_u16 = 0x4321;
        arm(&r, both_faults[f], SM3);
        run(&r, 3);
        assert_int_equal(wire_read(&r.w, 0, SM3, image, IMAGE), 1);
        assert_int_equal(ect_load_le16(image), 0x4321);
        rig_close(&r);
    }
}

static void reply_comes_later(void **state)
{
    (void)state;
    for (size_t f = 0; f < COUNT(both_faults); f++) {
        rig_t r;
        uint8_t mail[SIZE];
        go(&r, PREOP);
        arm(&r, both_faults[f], SM1);
        assert_true(sdo(&r, 0x23, 0x99, mail, false));
        assert_int_equal(testdev_of(&r.w, 0)->written, 1);
        assert_int_equal(testdev_of(&r.w, 0)->u32, 0x99);
        rig_close(&r);
    }
}

static void repeat_comes_later(void **state)
{
    (void)state;
    enum { ACTIVATE = ECT_REG_SM + 8 + ECT_SM_ACTIVATE, PDI = ECT_REG_SM + 8 + ECT_SM_PDI_CONTROL };
    static const uint16_t addresses[] = {ECT_REG_SM, SM1, PDI};
    for (size_t f = 0; f < COUNT(both_faults); f++) {
        for (size_t a = 0; a < COUNT(addresses); a++) {
            rig_t r;
            uint8_t mail[SIZE];
            go(&r, PREOP);
            assert_true(sdo(&r, 0x40, 0, mail, false));
            run(&r, 2);
            r.last_counter = 0;
            arm(&r, both_faults[f], addresses[a]);
            wire_write8(&r.w, 0, ACTIVATE, 1 | ECT_SM_ACTIVATE_REPEAT);
            for (unsigned int n = 0; n < 10; n++) {
                run(&r, 1);
                uint8_t pdi = wire_read8(&r.w, 0, PDI);
                uint8_t status = wire_read8(&r.w, 0, ECT_REG_SM + 8 + ECT_SM_STATUS);
                if ((pdi & ECT_SM_PDI_REPEAT_ACK) != 0 && (status & ECT_SM_STATUS_FULL) == 0)
                    fail_msg("access 0x%04X failed: acknowledged, and SM1 is empty", addresses[a]);
            }
            if ((wire_read8(&r.w, 0, PDI) & ECT_SM_PDI_REPEAT_ACK) == 0)
                fail_msg("access 0x%04X failed %s the ESC saw it: no repeat within 10 ms", addresses[a],
                         f == 0 ? "before" : "after");
            assert_int_equal(wire_read(&r.w, 0, SM1, mail, SIZE), 1);
            assert_int_equal(ect_load_le32(mail + 12), 0x11223344);
            rig_close(&r);
        }
    }
}

/* The lost mail is repeated before a newer one; each access of that fails once. */
static void repeat_older_with_fault(void **state)
{
    (void)state;
    enum { ACTIVATE = ECT_REG_SM + 8 + ECT_SM_ACTIVATE };
    for (unsigned int toggles = 1; toggles <= 2; toggles++) {
        for (unsigned int k = 1; k <= 8; k++) {
            rig_t r;
            uint8_t mail[SIZE];
            uint8_t lost[SIZE];
            uint8_t request[SIZE] = {10, 0, 0, 0, 0, 0x73, 0, 0x20, 0x40, 0x04, 0x20};
            go(&r, PREOP);
            if (toggles == 2)
                wire_write8(&r.w, 0, ACTIVATE, 1 | ECT_SM_ACTIVATE_REPEAT);
            assert_true(sdo(&r, 0x40, 0, mail, false));
            assert_true(sdo(&r, 0x40, 0, lost, false));
            assert_int_equal(wire_write(&r.w, 0, SM0, request, SIZE), 1);
            run(&r, 3);
            r.last_counter = 0;
            r.fault = FAIL_BEFORE;
            r.fault_at = r.accesses + k;
            wire_write8(&r.w, 0, ACTIVATE, toggles == 2 ? 1 : 1 | ECT_SM_ACTIVATE_REPEAT);
            run(&r, 10);
            assert_int_equal(wire_read8(&r.w, 0, ACTIVATE + 1) & ECT_SM_PDI_REPEAT_ACK, toggles == 2 ? 0 : 2);
            assert_true(fetch(&r, mail));
            assert_memory_equal(mail, lost, SIZE);
            assert_true(fetch(&r, mail));
            assert_int_equal(ect_load_le16(mail + 9), 0x2004);
            assert_false(fetch(&r, mail));
            rig_close(&r);
        }
    }
}

/* --- the event word without an access ---------------------------------------------------------------------------- */

static int event_fails(void *ctx, uint32_t *event)
{
    rig_t *r = ctx;
    if (r->fault_at != 0) {
        r->fault_at--;
        return -1;
    }
    return r->real.al_event(r->real.ctx, event);
}

static void event_word_fails(void **state)
{
    (void)state;
    rig_t r;
    go(&r, PREOP);
    r.pdi.al_event = event_fails;
    r.fault_at = 3;
    assert_int_equal(wire_write16(&r.w, 0, ECT_REG_AL_CONTROL, INIT), 1);
    unsigned int before = r.accesses;
    poll_once(&r);
    poll_once(&r);
    poll_once(&r);
    assert_int_equal(r.accesses, before);
    assert_int_equal(al(&r, NULL), PREOP);
    assert_int_equal(r.slave->pdi_errors, 3);
    poll_once(&r);
    assert_int_equal(al(&r, NULL), INIT);
    assert_int_equal(polled(&r), 0);
    rig_close(&r);
}

/* --- initialisation ---------------------------------------------------------------------------------------------- */

static void memory_needed(void **state)
{
    (void)state;
    ect_slave_memory_t need = ect_slave_memory(&testdev);
    assert_int_equal(need.instance, sizeof(testdev_t));
    assert_int_equal(need.mailbox, 128 + 2 * 256);
    assert_int_equal(need.process_data, 3);
    assert_int_equal(need.runs, 4);
    ect_device_t device = testdev;
    device.sm_count = 2;
    need = ect_slave_memory(&device);
    assert_int_equal(need.process_data, 0);
    device.sm_count = 1;
    need = ect_slave_memory(&device);
    assert_int_equal(need.mailbox, 0);
    device = testdev;
    device.sm[2].maximum = 40;
    need = ect_slave_memory(&device);
    assert_int_equal(need.process_data, 40);
    device.sm[3].maximum = 50;
    need = ect_slave_memory(&device);
    assert_int_equal(need.process_data, 50);
    device = testdev;
    device.sm_count = 2; /* a mailbox and no process data; the longest mailbox of each direction counts, in BOOT too */
    need = ect_slave_memory(&device);
    assert_int_equal(need.mailbox, 128 + 2 * 256);
    device.boot_out = (ect_boot_mailbox_t){0x1000, 300};
    device.boot_in = (ect_boot_mailbox_t){0x1200, 400};
    need = ect_slave_memory(&device);
    assert_int_equal(need.mailbox, 300 + 2 * 400);
    device = testdev;
    device.sm_count = 0;
    need = ect_slave_memory(&device);
    assert_int_equal(need.mailbox, 0);
    assert_int_equal(need.process_data, 0);
    need = ect_slave_memory(&ect_optoncdt2300); /* 1300 entries of 32 bits in 100 PDOs, and room for 1144 bytes */
    assert_int_equal(need.runs, 1144 / 4);
}

/* The buffer for values has the length of the longest one that a master may write. */
static void buffer_for_values(void **state)
{
    static const struct {
        uint16_t index; /* of the only object */
        size_t staging;
    } rows[] = {{0x1000, 0}, {0x1001, 0}, {0x1008, 0}, {0x2000, 4}, {0x2003, 2}, {0x2009, 8}, {0x2002, 1000}};
    (void)state;
    assert_int_equal(ect_slave_memory(&testdev).staging, 1000);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const ect_od_t od = ect_device_od(&testdev, NULL);
        ect_device_t device = testdev;
        device.objects = ect_od_find(&od, rows[i].index);
        device.object_count = 1;
        if (ect_slave_memory(&device).staging != rows[i].staging)
            fail_msg("0x%04X alone: expected %zu bytes, got %zu", rows[i].index, rows[i].staging,
                     ect_slave_memory(&device).staging);
        device.mailbox_protocols = 0;
        assert_int_equal(ect_slave_memory(&device).staging, 0);
    }
}

typedef struct giver {
    unsigned int left; /* pieces that it still provides */
    size_t given[8];
    unsigned int pieces;
    uint8_t memory[65536];
    size_t used;
} giver_t;

static void *give(void *ctx, size_t bytes)
{
    giver_t *g = ctx;
    void *piece = &g->memory[g->used];
    if (g->left == 0)
        return NULL;
    g->left--;
    g->given[g->pieces++] = bytes;
    g->used += bytes;
    return piece;
}

/* For the whole test device, for one without process data, for one without a mailbox as well, for one without
 * anything. */
static void memory_taken(void **state)
{
    static giver_t giver;
    static const uint8_t sm_counts[] = {4, 2, 0, 0};
    static const unsigned int pieces[] = {5, 4, 3, 2};
    (void)state;
    for (size_t i = 0; i < sizeof sm_counts; i++) {
        ect_device_t device = testdev;
        device.sm_count = sm_counts[i];
        if (pieces[i] == 2)
            device.instance_size = device.mailbox_protocols = 0;
        ect_slave_memory_t need = ect_slave_memory(&device);
        for (unsigned int left = 0; left <= pieces[i]; left++) {
            ect_slave_config_t config = {.device = &device, .buffer = &giver, .device_id = 7};
            giver = (giver_t){.left = left};
            assert_int_equal(ect_slave_take(&config, give, &giver), left == pieces[i]);
            assert_int_equal(giver.pieces, left);
            assert_ptr_equal(config.buffer, &giver);
            assert_int_equal(config.device_id, 7);
            if (left < pieces[i])
                continue;
            size_t whole = need.instance + (need.instance == 0) + need.mailbox + need.process_data +
                           (need.process_data == 0) + need.runs * sizeof(ect_pdo_run_t) + need.staging;
            assert_int_equal(giver.used, whole);
            assert_non_null(config.instance);
            assert_int_equal(config.mailbox != NULL, need.mailbox > 0);
            assert_non_null(config.process_data);
            assert_int_equal(config.runs != NULL, need.runs > 0);
            assert_int_equal(config.staging != NULL, need.staging > 0);
            assert_int_equal(config.process_size, need.process_data);
            assert_int_equal(config.run_count, need.runs);
            assert_int_equal(config.staging_size, need.staging);
        }
    }
}

static void config_checked(void **state)
{
    (void)state;
    rig_t r;
    rig_open(&r, NO_FAULT, 0);
    ect_slave_t slave;
    for (unsigned int row = 0; row < 9; row++) {
        static const int want[] = {0, -1, -1, -1, -1, -2, -2, -2, -2};
        ect_slave_config_t c = r.slave->config;
        ect_pdi_t pdi = r.pdi;
        c.pdi = &pdi;
        c.device = row == 1 ? NULL : c.device;
        c.pdi = row == 2 ? NULL : c.pdi;
        pdi.read = row == 3 ? NULL : pdi.read;
        pdi.write = row == 4 ? NULL : pdi.write;
        c.instance = row == 5 ? NULL : c.instance;
        c.mailbox = row == 6 ? NULL : c.mailbox;
        c.process_data = row == 7 ? NULL : c.process_data;
        c.runs = row == 8 ? NULL : c.runs;
        int got = ect_slave_init(&slave, &c, 0);
        if (got != want[row])
            fail_msg("row %u: expected %d, got %d", row, want[row], got);
    }
    rig_close(&r);
}

static void init_fails(void **state)
{
    (void)state;
    for (size_t f = 0; f < COUNT(both_faults); f++) {
        rig_t r;
        rig_open(&r, NO_FAULT, 0);
        ect_slave_config_t c = r.slave->config;
        unsigned int before = r.accesses;
        assert_int_equal(ect_slave_init(r.slave, &c, 0), 0);
        unsigned int needed = r.accesses - before;
        for (unsigned int k = 1; k <= needed; k++) {
            r.fault = both_faults[f];
            r.fault_at = r.accesses + k;
            assert_int_equal(ect_slave_init(r.slave, &c, 0), -3);
        }
        rig_close(&r);
    }
}

static void identity_default(void **state)
{
    (void)state;
    rig_t r;
    rig_open(&r, NO_FAULT, 0);
    ect_slave_config_t c = r.slave->config;
    ect_identity_t other = {1, 2, 3, 4};
    const ect_identity_t *held = &((testdev_t *)c.instance)->standard.identity;
    c.identity = &other;
    assert_int_equal(ect_slave_init(r.slave, &c, 0), 0);
    assert_memory_equal(held, &other, sizeof other);
    c.identity = NULL;
    assert_int_equal(ect_slave_init(r.slave, &c, 0), 0);
    assert_memory_equal(held, &testdev.identity, sizeof other);
    rig_close(&r);
}

#define T(title, function) {title, function, NULL, NULL, NULL}

int main(int argc, char **argv)
{
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    const struct CMUnitTest tests[] = {
        T("PDI budget: an idle poll makes at most 1 access, in every state", idle_budget),
        T("PDI budget: a cycle, outputs in and inputs out, makes at most 3 accesses", cyclic_budget),
        T("PDI budget: an expedited SDO makes at most 7 accesses, of 42 bytes, whatever the mailbox's size",
          sdo_budget),
        T("PDI budget: a state change makes at most 10 accesses", transition_budget),
        T("CF-047: any one access of two starts is not executed: the slave continues with correct reports, and starts "
          "again",
          fails_before),
        T("CF-047: any one access is executed and reports an error: correct states and mails, and the slave starts "
          "again",
          fails_after),
        T("CF-047: the slave is reset at any access: correct states and mails, safe outputs, and it starts again",
          resets),
        T("CF-047: the PDI fails for a while in every state: the state is kept, errors are counted, then the slave "
          "continues",
          fails_for_a_while),
        T("CF-041: a request is executed although the read of AL control failed", al_control_not_lost),
        T("CF-022: an SM change has its effect although the read of the SMs failed", sm_change_not_lost),
        T("CF-042: the watchdog drops to SAFEOP though the read of its status failed", watchdog_not_lost),
        T("CF-048: outputs whose read failed are applied in the next poll or the next cycle", outputs_come_later),
        T("CF-048: inputs whose write failed are written again", inputs_come_later),
        T("CF-024: a reply whose write failed is sent later, the request is executed once", reply_comes_later),
        T("CF-023: a repeat request is served although one of its accesses failed, the mail before the acknowledge",
          repeat_comes_later),
        T("CF-023: with a newer mail in SM1, a repeat survives a failure of any of its accesses",
          repeat_older_with_fault),
        T("CF-041: an event word that cannot be read delays the work, and is counted", event_word_fails),
        T("Initialisation: the memory needed follows from the description", memory_needed),
        T("Initialisation: the buffer fits the longest value that can be written", buffer_for_values),
        T("Initialisation: the memory is allocated piece by piece, none without need; too little is reported",
          memory_taken),
        T("Initialisation: a missing member is refused, -1 device or PDI, -2 a buffer", config_checked),
        T("Initialisation: -3 when any of its accesses fails", init_fails),
        T("Initialisation: identity of the installation, or of the description", identity_default),
    };
    return cmocka_run_group_tests_name("PDI", tests, NULL, NULL);
}
