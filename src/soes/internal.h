/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Declarations shared by the files of soes/, and those of a firmware that serves a description of ectwin in place
 * of an object list: the three functions of application.c.
 *
 * From the lowest to the highest (tests/check/order.py):
 *
 *   state.c                         variables, time
 *   describe.c                      the description of an application
 *   esc_coe.c                       dictionary
 *   esc.c                           registers, and leaving a state
 *   esc_eep.c                       emulated EEPROM
 *   esc_foe.c esc_eoe.c             files, Ethernet frames
 *   application.c                   a slave out of SDOobjects and the hooks
 *   ecat_slv.c                      the loop
 *
 * SOES's API has one slave a program, and names that are variables: they live in here.
 */
#ifndef ECT_SOES_INTERNAL_H
#define ECT_SOES_INTERNAL_H

#include "seams/eoe.h"
#include "seams/foe.h"
#include "seams/standard.h"
#include "slave/slave.h"
#include "soes/ecat_slv.h"
#include "soes/esc.h"

typedef struct ect_soes {
    ect_slave_t slave;
    ect_pdi_t below; /* the way to the ESC: that of the slave's configuration, or ESC_read and ESC_write */
    ect_pdi_t pdi;   /* the same, looked over: ESCvar shows what passes */
    uint64_t (*clock)(void);
    uint64_t now_ns; /* without a clock */
    uint64_t due_ns;
    uint32_t esc_time;
    volatile int watchdog;
    uint16_t wanted;    /* AL events that the stack has work for */
    uint16_t fall_code; /* AL status code of the last ESC_ALstatusgotoerror */
    bool requested;     /* the master has written AL control: a lower state is no fall by error */
    bool outputs_safe;  /* already, before the state machine leaves OP */
} ect_soes_t;

extern ect_soes_t ect_soes;

/* --- state.c ------------------------------------------------------------------------------------------------------ */
uint64_t ect_soes_now(void);
/* Follows the ESC's time, its lower half. */
void ect_soes_follow_time(uint32_t time);

/* --- esc_foe.c ---------------------------------------------------------------------------------------------------- */
/* The instance of an application's slave. */
typedef struct ect_soes_instance {
    ect_standard_t standard;
    ect_foe_transfer_t transfer;
#if USE_EOE
    ect_eoe_state_t eoe;
#endif
} ect_soes_instance_t;
extern ect_soes_instance_t ect_soes_instance;

extern const ect_foe_t ect_soes_files;

/* --- esc_eoe.c, with USE_EOE -------------------------------------------------------------------------------------- */
extern const ect_eoe_t ect_soes_network;
/* In the device's init: the address has the parts that the application has set before ecat_slv_init. */
void ect_soes_network_init(void);

/* --- application.c, or the firmware ------------------------------------------------------------------------------- */
/* The configuration of the slave; `pdi` NULL: ESC_read and ESC_write. Once, in ecat_slv_init. */
ect_slave_config_t ect_soes_slave_config(void);
/* The exchange, as DIG_process wants it; inputs in SAFEOP and OP, and on the way to SAFEOP. */
void ect_soes_outputs(void);
void ect_soes_inputs(void);

#endif
