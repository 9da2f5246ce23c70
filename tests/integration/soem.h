/* SPDX-License-Identifier: MIT */
/**
 * @file
 * SOEM with a context of its own, for integration tests: an unmodified master on the other end of the wire.
 */
#ifndef TESTS_INTEGRATION_SOEM_H
#define TESTS_INTEGRATION_SOEM_H

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "ethercat.h"

typedef struct soem {
    ecx_contextt context;
    ecx_portt port;
    ecx_redportt second_port;
    ec_slavet slaves[EC_MAXSLAVE];
    int slave_count;
    ec_groupt groups[EC_MAXGROUP];
    uint8 sii_buffer[EC_MAXEEPBUF];
    uint32 sii_map[EC_MAXEEPBITMAP];
    ec_eringt errors;
    ec_idxstackT index_stack;
    boolean error;
    int64 dc_time;
    ec_SMcommtypet sm_types[EC_MAX_MAPT];
    ec_PDOassignt assignments[EC_MAX_MAPT];
    ec_PDOdesct descriptions[EC_MAX_MAPT];
    ec_eepromSMt sii_sm;
    ec_eepromFMMUt sii_fmmu;
    uint8 image[8192];
} soem_t;

/* Monotonic time, nanoseconds. */
uint64_t soem_now(void);

/* Factor on SOEM's own timeouts for replies; 200 without a call. */
void soem_patience(unsigned int times);

/* Opens the interface and takes all slaves to PREOP; asserts that `expected` are there. Their watchdog of process data
 * is 60 s from then on: a busy machine may keep a master from its next cycle for longer than the 100 ms of a chip's
 * reset. */
void soem_open(soem_t *m, const char *iface, int expected);
/* The same with a second interface at the other end of the chain: cable redundancy. */
void soem_open_redundant(soem_t *m, const char *iface, const char *second, int expected);
void soem_close(soem_t *m);
/* Another watchdog of process data for all slaves, from the next cycle on; 0: none. */
void soem_watchdog(soem_t *m, unsigned int ms);

/* Takes one to BOOT, with the mailboxes that its SII has for BOOT. */
void soem_boot(soem_t *m, uint16 slave);

/* Maps all slaves (mapping from CoE) and takes them to SAFEOP. */
void soem_map(soem_t *m);
/* All slaves to OP, with process data going; asserts that they get there. */
void soem_operational(soem_t *m);
/* One exchange of process data, however long it takes; @return working counter */
int soem_exchange(soem_t *m);
/* The same, and a pause after it as of a cycle. */
int soem_cycle(soem_t *m);
int soem_expected_wkc(const soem_t *m);
/* Cycles until a predicate holds, `ms` at most; @return whether it did */
bool soem_until(soem_t *m, bool (*holds)(soem_t *m), unsigned int ms);

/* Requests a state of one slave (0: all) with acknowledge; asserts that it is reached. */
void soem_go(soem_t *m, uint16 slave, uint16 state);
/* Requests without waiting, then reads state and AL status code back after the slave had time. */
uint16 soem_request(soem_t *m, uint16 slave, uint16 state, uint16 *code);

/* Reads the states until this slave has this one, its error flag included; @return its state then, or after 30 s */
uint16 soem_await(soem_t *m, uint16 slave, uint16 state);

/* An SDO read; @return 0 or the abort code. *size: room in, bytes out. */
uint32 soem_read(soem_t *m, uint16 slave, uint16 index, uint8 subindex, bool complete, void *data, int *size);
uint32 soem_write(soem_t *m, uint16 slave, uint16 index, uint8 subindex, bool complete, const void *data, int size);

#endif
