/* SPDX-License-Identifier: MIT */
/**
 * @file
 * Fields: named bits of an entry, and the names of its values, from the product's manual. The table is separate from
 * the object list: the running slave does not read it, so a firmware does not link it. The plant (seams/plant.h) names
 * the table; `ectwin doc`, `ectwin esi` and `ectwin list-signals` read it.
 */
#ifndef ECT_SEAMS_FIELDS_H
#define ECT_SEAMS_FIELDS_H

#include <stdbool.h>
#include <stdint.h>

/** The name of a value. The last element of a list has the name NULL. */
typedef struct ect_value_name {
    int64_t value;
    const char *name;
} ect_value_name_t;

/**
 * A field of an entry. A table ends with index 0. Several products may share one: a field of an entry that a product
 * does not have is ignored. Unused bits have no field.
 */
typedef struct ect_field {
    uint16_t index;
    uint8_t subindex;
    uint8_t bit;                    /**< the lowest one, 0 to 63 */
    uint8_t width;                  /**< bits, 1 to 64; 0: the whole entry */
    bool open;                      /**< values without a name are numbers, e.g. error codes in place of a distance */
    const char *name;               /**< of the manual; NULL: the entry's name */
    const char *meaning;            /**< one line; NULL: the name is enough */
    const ect_value_name_t *values; /**< constant list; NULL: a number, or a bit that is on or off */
    const char *signal; /**< the signal with the value, of an array without number ("ru.state"); NULL: none */
} ect_field_t;

/** A bit of an entry: ECT_FIELD_BIT(0x2200, 1, 2, "READY", "the next STEP is taken", "ready") */
#define ECT_FIELD_BIT(entry_index, sub, number, text, what, shown_by)                                                  \
    {.index = (entry_index),                                                                                           \
     .subindex = (sub),                                                                                                \
     .bit = (number),                                                                                                  \
     .width = 1,                                                                                                       \
     .name = (text),                                                                                                   \
     .meaning = (what),                                                                                                \
     .signal = (shown_by)}

/** An entry whose values have names. */
#define ECT_FIELD_VALUES(entry_index, sub, list, shown_by)                                                             \
    {.index = (entry_index), .subindex = (sub), .values = (list), .signal = (shown_by)}

#endif
