/* SPDX-License-Identifier: MIT */
/**
 * @file
 * SOES's API: the layout of an application's slave. A name that the application's `ecat_options.h`, anywhere on the
 * include path, does not define has the value of this header.
 *
 * These are constants of the compiler: an application, its object list, its hardware file and src/soes must be compiled
 * with the same values.
 */
#ifndef ECT_SOES_OPTIONS_H
#define ECT_SOES_OPTIONS_H

#ifdef __has_include
#if __has_include(<ecat_options.h>)
#include <ecat_options.h>
#endif
#else
#include <ecat_options.h>
#endif

/** 1: files by FoE. */
#ifndef USE_FOE
#define USE_FOE 1
#endif
/** 1: Ethernet by EoE (soes/esc_eoe.h). */
#ifndef USE_EOE
#define USE_EOE 1
#endif

/** Bytes of a mailbox, and of a mailbox in BOOT. */
#ifndef MBXSIZE
#define MBXSIZE 128
#endif
#ifndef MBXSIZEBOOT
#define MBXSIZEBOOT 128
#endif
/** Not used, because this stack keeps one request and two replies. */
#ifndef MBXBUFFERS
#define MBXBUFFERS 3
#endif
/** Longest value in pieces, in mailbox sizes (ESCvar.mbxdata). */
#ifndef PREALLOC_FACTOR
#define PREALLOC_FACTOR 3
#endif

/** SyncManager 0, to the slave: start, length, last byte, control. */
#ifndef MBX0_sma
#define MBX0_sma 0x1000
#endif
#ifndef MBX0_sml
#define MBX0_sml MBXSIZE
#endif
#ifndef MBX0_sme
#define MBX0_sme (MBX0_sma + MBX0_sml - 1)
#endif
#ifndef MBX0_smc
#define MBX0_smc 0x26
#endif

/** SyncManager 1, from the slave. */
#ifndef MBX1_sma
#define MBX1_sma (MBX0_sma + MBX0_sml)
#endif
#ifndef MBX1_sml
#define MBX1_sml MBXSIZE
#endif
#ifndef MBX1_sme
#define MBX1_sme (MBX1_sma + MBX1_sml - 1)
#endif
#ifndef MBX1_smc
#define MBX1_smc 0x22
#endif

/** SyncManagers 0 and 1 in BOOT. */
#ifndef MBX0_sma_b
#define MBX0_sma_b 0x1000
#endif
#ifndef MBX0_sml_b
#define MBX0_sml_b MBXSIZEBOOT
#endif
#ifndef MBX0_sme_b
#define MBX0_sme_b (MBX0_sma_b + MBX0_sml_b - 1)
#endif
#ifndef MBX0_smc_b
#define MBX0_smc_b 0x26
#endif
#ifndef MBX1_sma_b
#define MBX1_sma_b (MBX0_sma_b + MBX0_sml_b)
#endif
#ifndef MBX1_sml_b
#define MBX1_sml_b MBXSIZEBOOT
#endif
#ifndef MBX1_sme_b
#define MBX1_sme_b (MBX1_sma_b + MBX1_sml_b - 1)
#endif
#ifndef MBX1_smc_b
#define MBX1_smc_b 0x22
#endif

/** SyncManager 2, outputs, and 3, inputs: start, control, whether the master enables it. */
#ifndef SM2_sma
#define SM2_sma 0x1100
#endif
#ifndef SM2_smc
#define SM2_smc 0x24
#endif
#ifndef SM2_act
#define SM2_act 1
#endif
#ifndef SM3_sma
#define SM3_sma 0x1180
#endif
#ifndef SM3_smc
#define SM3_smc 0x20
#endif
#ifndef SM3_act
#define SM3_act 1
#endif

/**
 * Limits of mapped entries and of their bytes. 0 mappings: process data are not entries, but the application's bytes
 * `uint8_t rxpdo[]` and `uint8_t txpdo[]`.
 */
#ifndef MAX_MAPPINGS_SM2
#define MAX_MAPPINGS_SM2 16
#endif
#ifndef MAX_MAPPINGS_SM3
#define MAX_MAPPINGS_SM3 16
#endif
#ifndef MAX_RXPDO_SIZE
#define MAX_RXPDO_SIZE 128
#endif
#ifndef MAX_TXPDO_SIZE
#define MAX_TXPDO_SIZE 128
#endif

#endif
