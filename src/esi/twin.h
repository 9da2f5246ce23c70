/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Twin: a device of an ESI file as one that runs. Nothing in stack, chain or command knows that it was made at run
 * time.
 *
 * The twin has the identity, layout, PDOs, dictionary and clocks of the file, and by itself no behaviour: inputs are
 * what somebody sets through signals (or a master by SDO), outputs are shown, and go to their defaults when OP is left.
 * ::ect_esi_twin_behave makes a drive of CiA 402 move.
 * Notes list every feature of the file that the twin does not have.
 *
 * Host only. Context: mainline.
 */
#ifndef ECT_ESI_TWIN_H
#define ECT_ESI_TWIN_H

#include "esi/read.h"
#include "seams/plant.h"
#include "wire/linkage.h"

/** The choice of a user: a module for a slot. */
typedef struct ect_module_choice {
    unsigned int slot; /**< from 0 */
    uint32_t ident;
} ect_module_choice_t;

ECT_C_BEGIN

/** A product made from a file; owns all that it hands out. */
typedef struct ect_esi_twin ect_esi_twin_t;

/**
 * Makes a twin of a file that is open.
 * @param esi    stays the caller's; open until the twin is freed
 * @param model  from ::ect_esi_select of this file
 * @param modules, module_count  modules for slots; other slots have the presets of the file
 * @param[out] text, room  the reason of the failure, one line
 * @return the twin, or NULL: the model describes something that no ESC of ours can be
 */
ect_esi_twin_t *ect_esi_twin_of(const ect_esi_t *esi, const ect_esi_device_t *model, const ect_module_choice_t *modules,
                                size_t module_count, char *text, size_t room);

/**
 * Makes a twin that has its file for itself.
 * @param path, selector  see ::ect_esi_open and ::ect_esi_select
 * @return the twin, or NULL: the file cannot be read, or as of ::ect_esi_twin_of
 */
ect_esi_twin_t *ect_esi_twin_make(const char *path, const char *selector, const ect_module_choice_t *modules,
                                  size_t module_count, char *text, size_t room);

/**
 * Makes a twin that has an open file for itself.
 * @param esi  the twin's from now on, closed on failure; NULL: not open, `text` has the reason
 * @param selector  see ::ect_esi_select
 * @return as of ::ect_esi_twin_make
 */
ect_esi_twin_t *ect_esi_twin_take(ect_esi_t *esi, const char *selector, const ect_module_choice_t *modules,
                                  size_t module_count, char *text, size_t room);

/** The behaviour of a twin. */
typedef enum ect_behaviour {
    ECT_BEHAVIOUR_BY_FILE, /**< a drive, if the file has control word and status word 6040h and 6041h of an axis */
    ECT_BEHAVIOUR_NONE,    /**< a shell */
    ECT_BEHAVIOUR_CIA402,  /**< a drive */
} ect_behaviour_t;

/**
 * Gives a twin its behaviour: axes of CiA 402 at 6000h, 6800h to 9800h, with the objects that the file has, and the
 * signals axis1 to axis8 of their surroundings. A note lists the axes with their modes, and the objects of the
 * profile that the drive does not simulate. Once, before the first power-on of the twin; the description of the device
 * stays that of the file.
 * @param[out] text, room  the reason of the failure, one line
 * @return false: ECT_BEHAVIOUR_CIA402, and the file has no axis; the twin is a shell
 */
bool ect_esi_twin_behave(ect_esi_twin_t *twin, ect_behaviour_t behaviour, char *text, size_t room);

/** The product, valid until the twin is freed. */
const ect_product_t *ect_esi_twin_product(const ect_esi_twin_t *twin);

/** Features of the file that the twin does not have, a line each. @param[out] count  may be 0 */
const char *const *ect_esi_twin_notes(const ect_esi_twin_t *twin, size_t *count);

/** The model that it was made from. */
const ect_esi_device_t *ect_esi_twin_model(const ect_esi_twin_t *twin);

/** The file that it was made from. */
const ect_esi_t *ect_esi_twin_file(const ect_esi_twin_t *twin);

/**
 * Makes another twin of the same device with all slots empty, as a file describes a modular device.
 * @return to be freed before `twin`; NULL: the device has no slots, modules were chosen for `twin`, or there is no
 *         memory left
 */
ect_esi_twin_t *ect_esi_twin_without_modules(const ect_esi_twin_t *twin);

/** Frees it; no chain may use its product any more. NULL is allowed. */
void ect_esi_twin_free(ect_esi_twin_t *twin);

ECT_C_END

#endif
