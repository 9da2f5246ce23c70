/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Modules and slots of a modular device (ETG.5001), as its ESI file describes them.
 *
 * A slot of the file may occur several times. Places are numbered from 0, over all occurrences of all slots, in the
 * order of the file; a user and the objects F030h and F050h count them from 1. Pure. Context: any.
 */
#ifndef ECT_ESI_MODULES_H
#define ECT_ESI_MODULES_H

#include "esi/model.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** @return the number of places for modules */
unsigned int ect_esi_places(const ect_esi_device_t *device);

/**
 * @param number        of a place
 * @param[out] instance  occurrence of the slot at this place, from 0; NULL: not wanted
 * @return the slot; NULL: there is no such place
 */
const ect_esi_slot_t *ect_esi_slot_at(const ect_esi_device_t *device, unsigned int number, unsigned int *instance);

/** @return the module with that ident; NULL: the file has none */
const ect_esi_module_t *ect_esi_module(const ect_esi_device_t *device, uint32_t ident);

/** @return whether the slot accepts the module, by ident or class */
bool ect_esi_slot_takes(const ect_esi_slot_t *slot, const ect_esi_module_t *module);

/** @return whether the place exists and accepts a module of the file with that ident */
bool ect_esi_place_takes(const ect_esi_device_t *device, unsigned int number, uint32_t ident);

/** @return ident of the module that the file presets at a place, which must exist; 0: none */
uint32_t ect_esi_preset(const ect_esi_device_t *device, unsigned int number);

ECT_C_END

#endif
