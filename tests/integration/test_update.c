/* SPDX-License-Identifier: MIT */
/*
 * A firmware update of a board over FoE, step by step as SOEM's program firm_update does it.
 *
 * usage: test_update IFACE FILE DAMAGED FOREIGN VERSION NEXT [TEST]
 * Object 100Ah of the slave is VERSION, and NEXT with the firmware in FILE. DAMAGED is a file for the same product,
 * which the tests damage: FILE, or a shorter one, since a short mailbox takes long for a whole firmware. FOREIGN is a
 * file for another product. The tests follow each other.
 */
#include <stdio.h>
#include <string.h>

#include "soem.h"

enum { SLAVE = 1, MOST = 1 << 20, HEADER = 32, VERSION = 0x100A };

typedef struct file {
    uint8_t bytes[MOST];
    int size;
} file_t;

static const char *iface, *before, *after;
static char file_name[] = "firmware";
static soem_t master;
static file_t update, damage, foreign;

static void expect_version(const char *version)
{
    char text[32] = {0};
    int size = sizeof text - 1;
    assert_int_equal(soem_read(&master, SLAVE, VERSION, 0, false, text, &size), 0);
    assert_string_equal(text, version);
}

static void set_mailbox(ec_slavet *s, unsigned int sm, uint32 words)
{
    uint16 start = (uint16)words, length = (uint16)(words >> 16);
    s->SM[sm].StartAddr = htoes(start);
    s->SM[sm].SMlength = htoes(length);
    *(sm == 0 ? &s->mbx_wo : &s->mbx_ro) = start;
    *(sm == 0 ? &s->mbx_l : &s->mbx_rl) = length;
    ecx_FPWR(&master.port, s->configadr, (uint16)(ECT_REG_SM0 + 8 * sm), sizeof(ec_smt), &s->SM[sm], EC_TIMEOUTRET);
}

static void to_state(ec_slavet *s, uint16 state, int timeout_us)
{
    s->state = state;
    ecx_writestate(&master.context, SLAVE);
    assert_int_equal(ecx_statecheck(&master.context, SLAVE, state, timeout_us), state);
}

/* Each SyncManager is written in one datagram, and stays enabled while it is written. @return as ecx_FOEwrite */
static int firm_update(file_t *file, int bytes)
{
    ec_slavet *s = &master.slaves[SLAVE];
    soem_open(&master, iface, 1);
    expect_version(before);
    to_state(s, EC_STATE_INIT, 4 * EC_TIMEOUTSTATE);
    set_mailbox(s, 0, ecx_readeeprom(&master.context, SLAVE, ECT_SII_BOOTRXMBX, EC_TIMEOUTEEP));
    set_mailbox(s, 1, ecx_readeeprom(&master.context, SLAVE, ECT_SII_BOOTTXMBX, EC_TIMEOUTEEP));
    to_state(s, EC_STATE_BOOT, 10 * EC_TIMEOUTSTATE);
    int result = ecx_FOEwrite(&master.context, SLAVE, file_name, 0, bytes, file->bytes, EC_TIMEOUTSTATE);
    s->state = EC_STATE_INIT;
    ecx_writestate(&master.context, SLAVE);
    ecx_statecheck(&master.context, SLAVE, EC_STATE_INIT, EC_TIMEOUTSTATE); /* it may restart instead */
    ecx_close(&master.context);
    return result;
}

/* Room for the whole file is needed only where the damage is at its end. */
static void expect_refused(const char *title, file_t *file, int bytes)
{
    if (firm_update(file, bytes) > 0)
        fail_msg("a file that %s was taken", title);
}

static void damaged(void **state)
{
    static const struct {
        const char *title;
        int at; /* of a byte that is another one; -1: none */
        int less;
    } rows[] = {{"has another magic number", 0, 0},
                {"is for another address", 13, 0},
                {"has another version than it was made with", 24, 0},
                {"has another byte", HEADER + 5000, 0},
                {"ends early", -1, 100}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        if (rows[i].at >= 0)
            damage.bytes[rows[i].at] ^= 0x10;
        expect_refused(rows[i].title, &damage, damage.size - rows[i].less);
        if (rows[i].at >= 0)
            damage.bytes[rows[i].at] ^= 0x10;
    }
    soem_open(&master, iface, 1);
    expect_version(before);
    soem_close(&master);
}

static void another_product(void **state)
{
    (void)state;
    assert_int_equal(memcmp(foreign.bytes, update.bytes, 4), 0);
    expect_refused("is for another product", &foreign, foreign.size);
    update.bytes[16] ^= 1;
    expect_refused("is of another vendor", &update, update.size);
    update.bytes[16] ^= 1;
    soem_open(&master, iface, 1);
    expect_version(before);
    soem_close(&master);
}

static bool is_there(void)
{
    bool found = false;
    if (ecx_init(&master.context, iface) > 0)
        found = ecx_config_init(&master.context, FALSE) == 1;
    ecx_close(&master.context);
    return found;
}

static void renewed(void **state)
{
    (void)state;
    assert_true(firm_update(&update, update.size) > 0);
    for (int tries = 0; tries < 100 && !is_there(); tries++)
        osal_usleep(50000);
    soem_open(&master, iface, 1);
    expect_version(after);
    soem_map(&master);
    soem_operational(&master);
    for (int n = 0; n < 100; n++)
        assert_int_equal(soem_cycle(&master), soem_expected_wkc(&master));
    soem_close(&master);
}

static bool load(file_t *file, const char *path)
{
    FILE *from = fopen(path, "rb");
    file->size = from ? (int)fread(file->bytes, 1, MOST, from) : 0;
    if (from)
        (void)fclose(from);
    return file->size > HEADER;
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"FoE onto a board: the firmware of another product, or vendor, is refused", another_product, NULL, NULL, NULL},
        {"FoE onto a board: a damaged firmware is refused, and the old one stays", damaged, NULL, NULL, NULL},
        {"FoE onto a board: a new firmware runs after the way back to INIT", renewed, NULL, NULL, NULL},
    };
    if (argc < 7)
        return 1;
    iface = argv[1];
    before = argv[5];
    after = argv[6];
    if (!load(&update, argv[2]) || !load(&damage, argv[3]) || !load(&foreign, argv[4])) {
        fprintf(stderr, "test_update: cannot read '%s', '%s' or '%s'\n", argv[2], argv[3], argv[4]);
        return 1;
    }
    if (argc > 7)
        cmocka_set_test_filter(argv[7]);
    return cmocka_run_group_tests_name("update", tests, NULL, NULL);
}
