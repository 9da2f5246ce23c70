/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A heater as an EtherCAT device: the master sets the temperature, the heater reports its temperature and its power.
 * Temperatures are in 0.1 °C.
 */
#ifndef HEATER_H
#define HEATER_H

#include "seams/plant.h"
#include "seams/standard.h"

typedef struct heater {
    ect_standard_t standard; /* always the first member */

    /* objects of the master */
    int16_t set_point;   /* 7000h:1, process data */
    int16_t temperature; /* 6000h:1, process data */
    uint8_t power;       /* 6000h:2, process data, per cent */
    int16_t highest;     /* 8000h:1, a setting */

    /* the surroundings: set by a user on a PC, read from the hardware on a board */
    int16_t sensed;
    uint8_t broken; /* the wire of the sensor */

    int16_t peak; /* highest temperature since the last clear of the peak; by VoE */

    /* its own */
    const ect_host_t *host;
    bool live;     /* in OP: the set point applies */
    bool reported; /* the broken sensor */
} heater_t;

extern const ect_device_t heater;

enum { HEATER_VENDOR = 0x00000E57 }; /* vendor ID, in the identity and in VoE mails */

/**
 * A protocol of the vendor (VoE, ETG.1000.6): a mail has the vendor ID (4 bytes), a service (2 bytes), and its data.
 * The reply repeats the six bytes; the reply to HEATER_READ_PEAK continues with the peak (2 bytes).
 */
enum { HEATER_READ_PEAK = 1, HEATER_CLEAR_PEAK = 2 };

/* For the PC only: signals in place of the surroundings. */
extern const ect_plant_t heater_plant;

#endif
