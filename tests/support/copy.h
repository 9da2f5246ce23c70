/* SPDX-License-Identifier: MIT */
/** @file A copy of a description that may be changed: each table in memory of exactly its size, so that an access
 * beyond it is detected. */
#ifndef TESTS_SUPPORT_COPY_H
#define TESTS_SUPPORT_COPY_H

#include "seams/standard.h"

typedef struct copy {
    ect_device_t device;
    ect_object_t *objects; /* the device's, and so on */
    ect_entry_t **entries; /* those of object i; aliases of one table stay aliases */
    ect_detail_t *details; /* with room for one more */
    ect_pdo_t *pdos;       /* likewise */
    ect_dc_mode_t *dc_modes;
    uint16_t excludes[2];
} copy_t;

/* Ends the program when memory runs short. */
copy_t *copy_device(const ect_device_t *device);
void copy_free(copy_t *c);

ect_object_t *copy_object(copy_t *c, uint16_t index);
ect_entry_t *copy_entry(copy_t *c, uint16_t index, uint8_t subindex);
/* Adds an element to the second table, once. @return 0 */
int copy_detail(copy_t *c, uint16_t index, uint8_t subindex);
/* Adds properties of a PDO, once; `exclude` 0: none. @return 0 */
int copy_pdo(copy_t *c, uint16_t index, uint16_t flags, uint16_t exclude);

#endif
