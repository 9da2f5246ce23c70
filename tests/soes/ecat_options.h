/* SPDX-License-Identifier: MIT */
/* The layout of the tests' application. APP_RAW: process data are bytes of its own, no entries. */
#ifndef APP_ECAT_OPTIONS_H
#define APP_ECAT_OPTIONS_H

#define USE_FOE 1
#ifndef USE_EOE
#define USE_EOE 0
#endif
#ifndef MBXSIZE
#define MBXSIZE 64
#endif
#define MBXSIZEBOOT 128
#define SM2_sma     0x1200
#define SM3_sma     0x1400
#define SM2_smc     0x64
#define SM3_smc     0x20
#ifdef APP_RAW
#define MAX_MAPPINGS_SM2 0
#define MAX_MAPPINGS_SM3 0
#else
#define MAX_MAPPINGS_SM2 4
#define MAX_MAPPINGS_SM3 4
#define MAX_RXPDO_SIZE   6
#define MAX_TXPDO_SIZE   6
#endif

#endif
