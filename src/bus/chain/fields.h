/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Fields of a plant (seams/fields.h) as text: the named bits and values that belong to a signal.
 *
 * Context: any; the functions read constants.
 */
#ifndef ECT_BUS_CHAIN_FIELDS_H
#define ECT_BUS_CHAIN_FIELDS_H

#include "bus/chain/signals.h"

ECT_C_BEGIN

/** Room for a field as text, terminator included. Longer texts are truncated. */
enum { ECT_FIELD_TEXT = 512 };

/**
 * Finds the field of a signal. Cost: one comparison of names for each field.
 * @return the field, a constant of the plant; NULL: none for this signal
 */
const ect_field_t *ect_signal_field(const ect_signal_ref_t *ref);

/**
 * Writes the place of a field and the names of its values: "2200h:1 bit 2", or "2001h:8: 0 Initial, 1 Stopped". Values
 * of four or more decimal digits are hexadecimal.
 * @param[out] text  ECT_FIELD_TEXT bytes
 */
void ect_field_text(const ect_field_t *field, char *text);

/**
 * Writes only the names of a field's values: "0 Initial, 1 Stopped"; "" for none. @param[out] text ECT_FIELD_TEXT bytes
 */
void ect_field_values(const ect_field_t *field, char *text);

ECT_C_END

#endif
