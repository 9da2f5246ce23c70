/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Twin: a running device made from an ESI file. Stack, chain and commands treat it like a compiled device.
 *
 * The twin has the identity, layout, PDOs, dictionary and clocks of the file, but no behaviour: inputs are set by
 * signals (or by SDO), outputs are readable as signals, and return to their defaults when the twin leaves OP.
 * ::ect_esi_twin_behave adds the behaviour of a CiA 402 drive, a CiA 404 measuring device or a CiA 406 encoder.
 * Notes list every feature of the file that the twin does not have.
 *
 * Host only. Context: mainline.
 */
#ifndef ECT_ESI_TWIN_H
#define ECT_ESI_TWIN_H

#include "esi/read.h"
#include "seams/plant.h"
#include "wire/linkage.h"

/** A module for a slot, selected by the user. */
typedef struct ect_module_choice {
    unsigned int slot; /**< from 0 */
    uint32_t ident;
} ect_module_choice_t;

ECT_C_BEGIN

/** A product made from a file, the owner of all results. */
typedef struct ect_esi_twin ect_esi_twin_t;

/**
 * Makes a twin from an open file.
 * @param esi    remains the caller's; must be open until the twin is freed
 * @param model  from ::ect_esi_select of this file
 * @param modules, module_count  modules for slots; other slots have the presets of the file
 * @param[out] text, room  the reason of the failure, one line
 * @return the twin; NULL: no supported ESC can have the layout of the model
 */
ect_esi_twin_t *ect_esi_twin_of(const ect_esi_t *esi, const ect_esi_device_t *model, const ect_module_choice_t *modules,
                                size_t module_count, char *text, size_t room);

/**
 * Opens a file and makes a twin, which owns the file.
 * @param path, selector  see ::ect_esi_open and ::ect_esi_select
 * @return the twin; NULL: the file cannot be read, or as ::ect_esi_twin_of
 */
ect_esi_twin_t *ect_esi_twin_make(const char *path, const char *selector, const ect_module_choice_t *modules,
                                  size_t module_count, char *text, size_t room);

/**
 * Makes a twin from an open file, which the twin then owns.
 * @param esi  closed on failure; NULL: opening has failed, `text` has the reason
 * @param selector  see ::ect_esi_select
 * @return as ::ect_esi_twin_make
 */
ect_esi_twin_t *ect_esi_twin_take(ect_esi_t *esi, const char *selector, const ect_module_choice_t *modules,
                                  size_t module_count, char *text, size_t room);

/** The behaviour of a twin. */
typedef enum ect_behaviour {
    ECT_BEHAVIOUR_BY_FILE, /**< an encoder if ProfileNo is 406, a measuring device if it is 404; a drive if the file has
                              controlword 6040h and statusword 6041h of an axis, or SoE drives with S-0-0134 and
                              S-0-0135 */
    ECT_BEHAVIOUR_NONE,    /**< no behaviour */
    ECT_BEHAVIOUR_CIA402,  /**< a drive */
    ECT_BEHAVIOUR_CIA404,  /**< a measuring device */
    ECT_BEHAVIOUR_CIA406,  /**< an encoder */
} ect_behaviour_t;

/**
 * Sets the behaviour of a twin: encoders of CiA 406 with a position 6004h, 6008h or 6020h, and the signals encoder1 to
 * encoder8 of their shafts; inputs of CiA 404 with a process value 6130h, 7130h or 9130h, and the signals measure1 to
 * measure32 of their sensors; or axes of CiA 402 at 6000h, 6800h to 9800h, with the objects of the file, else an axis
 * for each SoE drive, with its IDNs; and the signals axis1 to axis8 of their surroundings. A note lists the axes with
 * their modes, and the objects of the profile that the drive does not simulate. Call it once, before the first power-on
 * of the twin. The description of the device remains that of the file.
 * @param[out] text, room  the reason of the failure, one line
 * @return false: ECT_BEHAVIOUR_CIA402 and the file has no axis, ECT_BEHAVIOUR_CIA404 and it has no process value, or
 * ECT_BEHAVIOUR_CIA406 and it has no position; the twin is without behaviour
 */
bool ect_esi_twin_behave(ect_esi_twin_t *twin, ect_behaviour_t behaviour, char *text, size_t room);

/** The product, valid until the twin is freed. */
const ect_product_t *ect_esi_twin_product(const ect_esi_twin_t *twin);

/** @return features of the file that the twin does not have, one line each. @param[out] count  may be 0 */
const char *const *ect_esi_twin_notes(const ect_esi_twin_t *twin, size_t *count);

/** @return the model of the twin */
const ect_esi_device_t *ect_esi_twin_model(const ect_esi_twin_t *twin);

/** @return the file of the twin */
const ect_esi_t *ect_esi_twin_file(const ect_esi_twin_t *twin);

/**
 * Makes another twin of the same device with all slots empty, as a file describes a modular device.
 * @return to be freed before `twin`; NULL: the device has no slots, modules were selected for `twin`, or out of memory
 */
ect_esi_twin_t *ect_esi_twin_without_modules(const ect_esi_twin_t *twin);

/** Frees a twin, whose product must no longer be in a chain. NULL: no effect */
void ect_esi_twin_free(ect_esi_twin_t *twin);

/**
 * Returns the objects of a description as reported by SDO information: those of a clone may lack rights and lengths
 * that the use of an entry requires.
 * @return `object_count` objects, in the order of the device's own; without a difference, or for a description that is
 * not of a twin: device->objects
 */
const ect_object_t *ect_esi_reported(const ect_device_t *device);

ECT_C_END

#endif
