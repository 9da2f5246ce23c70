/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Declarations shared by the files of soes/. A firmware with an ectwin description in place of an object list defines
 * the three functions of application.c itself.
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
 * SOES's API has one slave for each program, and names that are variables, which this folder defines.
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
    ect_pdi_t below; /* access to the ESC: the slave's configuration, or ESC_read and ESC_write */
    ect_pdi_t pdi;   /* the same access, which also updates ESCvar */
    uint64_t (*clock)(void);
    uint64_t now_ns; /* time without a clock */
    uint64_t due_ns;
    uint32_t esc_time;
    volatile int watchdog;
    uint16_t wanted;    /* AL events that the stack waits for */
    uint16_t fall_code; /* AL status code of the last ESC_ALstatusgotoerror */
    bool requested;     /* the master has written AL control: a lower state is not caused by an error */
    bool outputs_safe;  /* outputs are safe, before the state machine leaves OP */
} ect_soes_t;

extern ect_soes_t ect_soes;

/* --- state.c ------------------------------------------------------------------------------------------------------ */
uint64_t ect_soes_now(void);
/* Follows the lower half of the ESC's time. */
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
/* Copies the parts of the address that the application has set before ecat_slv_init; called in the device's init. */
void ect_soes_network_init(void);

/* --- application.c, or the firmware ------------------------------------------------------------------------------- */
/* Returns the configuration of the slave; `pdi` NULL: ESC_read and ESC_write. Called once, in ecat_slv_init. */
ect_slave_config_t ect_soes_slave_config(void);
/* Parts of the exchange for DIG_process; inputs in SAFEOP and OP, and on the way to SAFEOP. */
void ect_soes_outputs(void);
void ect_soes_inputs(void);

#endif
