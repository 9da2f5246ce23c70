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

/** The PDI of `esc`, which must outlive its use. Reading the event word is free of charge. */
ect_pdi_t ect_virtual_pdi(ect_esc_t *esc);

/** The same with the interrupt line of a board: while it is down there is no event, else the register is read. */
ect_pdi_t ect_virtual_line_pdi(ect_esc_t *esc);

ECT_C_END

#endif
