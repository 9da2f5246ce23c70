/* SPDX-License-Identifier: MIT */
/** @file The charts of docs/devices, compiled in (charts.cmake), so that a page of HTML needs no other file. */
#ifndef ECTWIN_CHARTS_H
#define ECTWIN_CHARTS_H

#include <stddef.h>

typedef struct chart {
    const char *folder;  /**< of docs/devices: a device's name, or the beginning of the names of a family */
    const char *caption; /**< as docs/devices names the chart */
    const char *svg;     /**< not terminated */
    size_t length;
} chart_t;

/** In the order of the device's page; the last element has no folder. */
extern const chart_t charts[];

#endif
