/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The virtual port: the PDI of a software ESC in the same process. Never fails, never waits.
 */
#ifndef ECT_PORTS_VIRTUAL_H
#define ECT_PORTS_VIRTUAL_H

#include "esc/esc.h"
#include "seams/pdi.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** @return the PDI of `esc`, which must outlive its use. Reading the event word is not an access. */
ect_pdi_t ect_virtual_pdi(ect_esc_t *esc);

/**
 * @return the PDI of `esc` with the interrupt line of a board: without an event if the line is inactive, else by
 * reading the register.
 */
ect_pdi_t ect_virtual_line_pdi(ect_esc_t *esc);

ECT_C_END

#endif
