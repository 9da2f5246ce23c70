/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Links: entries of a vendor's dictionary as numbers in an instance. A profile over such a dictionary uses the existing
 * objects, in the widths of the dictionary, integer or floating point. A link of 0 bytes stands for a missing entry.
 *
 * Context: any. The functions access only the memory passed to them.
 */
#ifndef ECT_OD_LINK_H
#define ECT_OD_LINK_H

#include "od/od.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** The entry of a dictionary that contains a value. */
typedef struct ect_link {
    uint32_t offset; /**< in the instance */
    uint8_t bytes;   /**< bytes: 1, 2, 4, 8; 0: the dictionary has no such entry */
    bool is_signed, is_real;
    bool output; /**< mappable to outputs */
    bool given;  /**< the dictionary has a default for it */
} ect_link_t;

/**
 * Links to an entry.
 * @param od  entries with offsets into an instance; its instance is not used
 * @return a link; of 0 bytes: no such entry, or the entry is not a number of whole bytes
 */
ect_link_t ect_link_to(const ect_od_t *od, uint16_t index, uint8_t subindex);

/**
 * Links to element `number`, from 0, of an array or record; an array of one element may be a VAR.
 * @return as ::ect_link_to
 */
ect_link_t ect_link_to_element(const ect_od_t *od, uint16_t index, unsigned int number);

/**
 * @return the value in the instance: floating point rounded, numbers and infinities limited to ±2^53, NaN as 0; 0 for a
 * missing entry.
 */
int64_t ect_link_load(const void *instance, const ect_link_t *link);

/** Stores a value, limited to the range of the entry's type. */
void ect_link_store(void *instance, const ect_link_t *link, int64_t value);

/** As ::ect_link_load, with the fraction of floating point and without the limit; NaN is unchanged. */
double ect_link_load_real(const void *instance, const ect_link_t *link);

/**
 * As ::ect_link_store, with the fraction for a floating-point entry, else rounded; NaN is stored as 0 in an integer.
 */
void ect_link_store_real(void *instance, const ect_link_t *link, double value);

ECT_C_END

#endif
