/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A heater as an EtherCAT device: the master says how warm it is to get, the heater how warm it is and how hard it
 * works. Temperatures are in 0.1 °C.
 */
#ifndef HEATER_H
#define HEATER_H

#include "seams/plant.h"
#include "seams/standard.h"

typedef struct heater {
    ect_standard_t standard; /* always the first member */

    /* what the master sees */
    int16_t set_point;   /* 7000h:1, process data */
    int16_t temperature; /* 6000h:1, process data */
    uint8_t power;       /* 6000h:2, process data, per cent */
    int16_t highest;     /* 8000h:1, a setting */

    /* what stands outside: on a PC a person sets it, on a board the program reads it from the hardware */
    int16_t sensed;
    uint8_t broken; /* the wire of the sensor */

    /* its own */
    const ect_host_t *host;
    bool live; /* in OP: the set point counts */
    bool told; /* of the broken sensor */
} heater_t;

extern const ect_device_t heater;

/* For the PC only: the signals by which a person plays what stands outside. */
extern const ect_plant_t heater_plant;

#endif
