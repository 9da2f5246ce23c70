/* SPDX-License-Identifier: MIT */
/* SOEM 1.4 against twins whose replies the input changes. Input: a byte that selects the steps of the master, a byte
 * that selects the twins, records (wire.h). */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ethercat.h"
#include "wire.h"

enum {
    STEP_MAP = 1,
    STEP_SDO = 2,
    STEP_LIST = 4,
    STEP_OP = 8,
    STEP_FOE = 16,
    STEP_SOE = 32,
    STEP_EOE = 64,
    STEP_RECOVER = 128,
    HEAD = 2,
    CYCLES = 5,
    VALUE = 40,     /* size of the caller's buffer for a value */
    ROOM = 1 << 17, /* for a file, for SoE and EoE */
    WRITTEN = 64,
    IMAGE = 1 << 20, /* sufficient for 200 slaves, because SOEM does not check the size of the image */
};

static struct {
    ecx_contextt context;
    int slavecount;
    boolean error;
    int64 dc_time;
    uint8 *image, *file, *value;
    ec_ODlistt *objects;
    ec_OElistt *entries;
    size_t sizes[13];
    void *blocks[13];
    size_t block_count;
} master;

static void *block(size_t size)
{
    void *memory = calloc(1, size);
    if (!memory)
        abort();
    master.sizes[master.block_count] = size;
    master.blocks[master.block_count++] = memory;
    return memory;
}

/* Allocates each list separately, so that the sanitizer detects an access beyond its end. */
static void allocate(void)
{
    ecx_contextt *c = &master.context;
    c->port = block(sizeof(ecx_portt));
    c->slavelist = block(EC_MAXSLAVE * sizeof(ec_slavet));
    c->grouplist = block(EC_MAXGROUP * sizeof(ec_groupt));
    c->esibuf = block(EC_MAXEEPBUF);
    c->esimap = block(EC_MAXEEPBITMAP * sizeof(uint32));
    c->elist = block(sizeof(ec_eringt));
    c->idxstack = block(sizeof(ec_idxstackT));
    c->SMcommtype = block(EC_MAX_MAPT * sizeof(ec_SMcommtypet));
    c->PDOassign = block(EC_MAX_MAPT * sizeof(ec_PDOassignt));
    c->PDOdesc = block(EC_MAX_MAPT * sizeof(ec_PDOdesct));
    c->eepSM = block(sizeof(ec_eepromSMt));
    c->eepFMMU = block(sizeof(ec_eepromFMMUt));
    c->slavecount = &master.slavecount;
    c->maxslave = EC_MAXSLAVE;
    c->maxgroup = EC_MAXGROUP;
    c->ecaterror = &master.error;
    c->DCtime = &master.dc_time;
    master.image = calloc(1, IMAGE);
    master.file = calloc(1, ROOM);
    master.value = calloc(1, VALUE);
    master.objects = calloc(1, sizeof *master.objects);
    master.entries = calloc(1, sizeof *master.entries);
    if (!master.image || !master.file || !master.value || !master.objects || !master.entries)
        abort();
}

static void clear(void)
{
    for (size_t i = 0; i < master.block_count; i++)
        memset(master.blocks[i], 0, master.sizes[i]);
    master.slavecount = 0;
    master.error = FALSE;
    master.dc_time = 0;
    master.context.esislave = 0;
}

/* --- steps of the master ------------------------------------------------------------------------------------------ */

static void read_objects(ecx_contextt *c, uint16 slave)
{
    int size = VALUE;
    (void)ecx_SDOread(c, slave, 0x1018, 1, FALSE, &size, master.value, EC_TIMEOUTRXM);
    size = VALUE;
    (void)ecx_SDOread(c, slave, 0x1008, 0, FALSE, &size, master.value, EC_TIMEOUTRXM);
    size = VALUE;
    (void)ecx_SDOread(c, slave, 0x1C12, 0, TRUE, &size, master.value, EC_TIMEOUTRXM);
    uint8 value[20] = {1};
    (void)ecx_SDOwrite(c, slave, 0x1C12, 0, FALSE, 1, value, EC_TIMEOUTRXM);
    (void)ecx_SDOwrite(c, slave, 0x8000, 1, FALSE, sizeof value, value, EC_TIMEOUTRXM);
}

static void read_dictionary(ecx_contextt *c, uint16 slave)
{
    enum { OBJECTS = 3 };
    memset(master.objects, 0, sizeof *master.objects);
    if (ecx_readODlist(c, slave, master.objects) <= 0)
        return;
    for (uint16 i = 0; i < master.objects->Entries && i < OBJECTS; i++) {
        (void)ecx_readODdescription(c, i, master.objects);
        memset(master.entries, 0, sizeof *master.entries);
        if (master.objects->MaxSub[i] < 8)
            (void)ecx_readOE(c, i, master.objects, master.entries);
    }
}

static void exchange(ecx_contextt *c)
{
    (void)ecx_statecheck(c, 0, EC_STATE_SAFE_OP, EC_TIMEOUTSTATE);
    c->slavelist[0].state = EC_STATE_OPERATIONAL;
    (void)ecx_send_processdata(c);
    (void)ecx_receive_processdata(c, EC_TIMEOUTRET);
    (void)ecx_writestate(c, 0);
    for (int i = 0; i < CYCLES; i++) {
        (void)ecx_send_processdata(c);
        (void)ecx_receive_processdata(c, EC_TIMEOUTRET);
        (void)ecx_statecheck(c, 0, EC_STATE_OPERATIONAL, 2000);
    }
    (void)ecx_readstate(c);
}

static void use_mailbox(ecx_contextt *c, uint16 slave, unsigned int steps)
{
    char name[] = "file";
    int size = ROOM;
    if (steps & STEP_FOE)
        (void)ecx_FOEread(c, slave, name, 0, &size, master.file, EC_TIMEOUTRXM);
    if (steps & STEP_FOE)
        (void)ecx_FOEwrite(c, slave, name, 0, WRITTEN, master.file, EC_TIMEOUTRXM);
    size = ROOM;
    if (steps & STEP_SOE)
        (void)ecx_SoEread(c, slave, 0, EC_SOE_VALUE_B, 15, &size, master.file, EC_TIMEOUTRXM);
    if (steps & STEP_EOE) {
        eoe_param_t address;
        memset(&address, 0, sizeof address);
        size = ROOM;
        (void)ecx_EOEgetIp(c, slave, 0, &address, EC_TIMEOUTRXM);
        (void)ecx_EOErecv(c, slave, 0, &size, master.file, EC_TIMEOUTRXM);
    }
}

static void run(unsigned int steps)
{
    ecx_contextt *c = &master.context;
    if (!ecx_init(c, "twins"))
        return;
    if (ecx_config_init(c, FALSE) > 0) {
        if (steps & STEP_SDO)
            read_objects(c, 1);
        if (steps & STEP_LIST)
            read_dictionary(c, 1);
        if (steps & STEP_MAP) {
            (void)ecx_config_map_group(c, master.image, 0);
            (void)ecx_configdc(c);
        }
        if (steps & STEP_OP)
            exchange(c);
        use_mailbox(c, 1, steps);
        if (steps & STEP_RECOVER) {
            (void)ecx_reconfig_slave(c, 1, 500);
            c->slavelist[1].state = EC_STATE_NONE;
            (void)ecx_recover_slave(c, 1, 500);
        }
        while (ecx_iserror(c))
            (void)ecx_elist2string(c);
    }
    ecx_close(c);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static const char *const devices[] = {"vr-bu-ect-map1", "fzm1", "pmctendo-dd5", "optoncdt2300,vr-bu-ect-map7"};
    if (size < HEAD)
        return 0;
    if (master.block_count == 0)
        allocate();
    clear();
    wire_begin(devices[data[1] % 4], data + HEAD, size - HEAD);
    run(data[0]);
    unsigned int sent = wire_end();
    if (getenv("FUZZ_MASTER_VERBOSE"))
        fprintf(stderr, "%u frames, %d slaves\n", sent, master.slavecount);
    return 0;
}

#ifdef FUZZ_MAIN
/* For AFL, and for replays without libFuzzer: processes each named file, or standard input. */
static void run_file(FILE *file)
{
    static uint8_t data[65536];
    (void)LLVMFuzzerTestOneInput(data, fread(data, 1, sizeof data, file));
}

int main(int argc, char *argv[])
{
    if (argc < 2)
        run_file(stdin);
    for (int i = 1; i < argc; i++) {
        FILE *file = fopen(argv[i], "rb");
        if (!file) {
            perror(argv[i]);
            return 1;
        }
        run_file(file);
        fclose(file);
    }
    return 0;
}
#endif
