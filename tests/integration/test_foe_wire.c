/* SPDX-License-Identifier: MIT */
/*
 * Files of a twin's folder under SOEM: FOEread and FOEwrite, in PREOP, in OP, and in BOOT as SOEM's firm_update goes
 * there. usage: test_foe_wire IFACE FOLDER    (the twin has --files FOLDER --files-password 0x77)
 */
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "soem.h"

enum { SLAVE = 1, LONG = 20000, PASSWORD = 0x77, TIMEOUT_US = 2000000, GOES = 5 };

static const char *iface, *folder;
static soem_t master;
static uint8 sent[LONG], got[LONG + 1];

static const char *in(const char *name)
{
    static char path[500];
    (void)snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

/* SOEM waits 2 ms for a frame, and then sends it again. On a machine under load a mail arrives twice by that, its reply
 * comes twice (CF-024), and SOEM takes the second one for the next packet's: it has another go. */
static bool is_lost(int result)
{
    return result == 0 || result == EC_NOFRAME || result == -EC_ERR_TYPE_PACKET_ERROR ||
           result == -EC_ERR_TYPE_FOE_PACKETNUMBER || result == -EC_ERR_TYPE_FOE_BUF2SMALL; /* its words for that */
}

static int write_with(uint32 password, char *name, int size)
{
    int result = 0;
    for (int i = 0; i < GOES && is_lost(result); i++)
        result = ecx_FOEwrite(&master.context, SLAVE, name, password, size, sent, TIMEOUT_US);
    return result;
}

static int write_file(char *name, int size)
{
    return write_with(PASSWORD, name, size);
}

static int read_file(char *name, int *size)
{
    int result = 0;
    for (int i = 0; i < GOES && is_lost(result); i++) {
        *size = sizeof got;
        memset(got, 0, sizeof got);
        result = ecx_FOEread(&master.context, SLAVE, name, PASSWORD, size, got, TIMEOUT_US);
    }
    return result;
}

static void expect_done(const char *what, int size, int result)
{
    if (result <= 0)
        fail_msg("%s of %d bytes: expected a working counter, got %d", what, size, result);
}

static void expect_on_disk(const char *name, int size)
{
    static uint8 disk[LONG + 1];
    FILE *file = fopen(in(name), "rb");
    assert_non_null(file);
    assert_int_equal(fread(disk, 1, sizeof disk, file), size);
    assert_memory_equal(disk, sent, (size_t)size);
    (void)fclose(file);
}

static void there_and_back(int size)
{
    char name[] = "firmware.bin";
    int length;
    for (int i = 0; i < size; i++)
        sent[i] = (uint8)(i * 31 + size);
    expect_done("write", size, write_file(name, size));
    expect_on_disk(name, size);
    expect_done("read", size, read_file(name, &length));
    assert_int_equal(length, size);
    assert_memory_equal(got, sent, (size_t)size);
    assert_int_equal(unlink(in(name)), 0);
}

static void in_preop(void **state)
{
    (void)state;
    soem_open(&master, iface, 1);
    assert_true((master.slaves[SLAVE].mbx_proto & ECT_MBXPROT_FOE) != 0);
    const int full = master.slaves[SLAVE].mbx_l - 12;
    const int sizes[] = {1, full - 1, full, full + 1, 7 * full, LONG};
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++)
        there_and_back(sizes[i]);
    soem_close(&master);
}

static void refused(void **state)
{
    static char missing[] = "missing", above[] = "../firmware.bin", root[] = "/etc/passwd", good[] = "firmware.bin";
    int length = sizeof got;
    (void)state;
    soem_open(&master, iface, 1);
    assert_int_equal(read_file(missing, &length), -EC_ERR_TYPE_FOE_ERROR);
    assert_int_equal(write_file(above, 5), -EC_ERR_TYPE_FOE_FILE_NOTFOUND);
    assert_int_equal(write_file(root, 5), -EC_ERR_TYPE_FOE_FILE_NOTFOUND);
    assert_int_equal(write_with(PASSWORD + 1, good, 5), -EC_ERR_TYPE_FOE_ERROR);
    assert_int_equal(access(in(good), F_OK), -1);
    there_and_back(10);
    soem_close(&master);
}

static void in_op(void **state)
{
    (void)state;
    soem_open(&master, iface, 1);
    soem_map(&master);
    soem_operational(&master);
    there_and_back(500);
    soem_close(&master);
}

static void in_boot(void **state)
{
    (void)state;
    soem_open(&master, iface, 1);
    soem_boot(&master, SLAVE);
    there_and_back(LONG);
    soem_go(&master, SLAVE, EC_STATE_INIT);
    soem_close(&master);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        {"FoE over the wire: SOEM writes and reads files of any length in PREOP", in_preop, NULL, NULL, NULL},
        {"FoE over the wire: missing files, names that lead out of the folder and wrong passwords are refused", refused,
         NULL, NULL, NULL},
        {"FoE over the wire: files beside process data in OP", in_op, NULL, NULL, NULL},
        {"FoE over the wire: SOEM's way of a firmware update, in BOOT", in_boot, NULL, NULL, NULL},
    };
    if (argc < 3)
        return 2;
    iface = argv[1];
    folder = argv[2];
    if (argc > 3)
        cmocka_set_test_filter(argv[3]);
    return cmocka_run_group_tests_name("foe over the wire", tests, NULL, NULL);
}
