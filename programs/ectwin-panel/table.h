/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The signals of a bus as the control protocol describes and reports them (docs/CONTROL.md), for pages that take
 * changes at their own pace. No socket, no clock.
 */
#ifndef ECTWIN_PANEL_TABLE_H
#define ECTWIN_PANEL_TABLE_H

#include <cjson/cJSON.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    TABLE_SIGNALS = 4096, /**< most signals; a connection to a twin watches no more */
    TABLE_SLOTS = 2 * TABLE_SIGNALS,
};

typedef struct table_signal {
    char *text;       /**< the line that describes it, JSON, as it came */
    char *name;       /**< in the memory of `text`'s allocation */
    long slave;       /**< from 1 */
    char *value;      /**< JSON */
    uint32_t changed; /**< number of its last change; 0: it has no value yet */
} table_signal_t;

/** A zeroed table is empty. */
typedef struct table {
    size_t count;
    uint32_t changes;            /**< number of the last change */
    uint16_t slots[TABLE_SLOTS]; /**< position in `signals` + 1, by the hash of slave and name; 0: free */
    table_signal_t signals[TABLE_SIGNALS];
} table_t;

/** Adds the signal that a line of a reply to `list` describes. @return false: there is no room, or the line is not one
 * of `list` */
bool table_add(table_t *table, const char *text, const cJSON *line);

/** Takes a line of `watch`. @return false: an unknown signal, or no such line */
bool table_change(table_t *table, const char *text, const cJSON *line);

/** @return position of the signal of a line; TABLE_SIGNALS: unknown */
size_t table_find(table_t *table, const cJSON *line);

/** Forgets all signals. */
void table_clear(table_t *table);

#endif
