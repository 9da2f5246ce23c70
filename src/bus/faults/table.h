/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A table of signals over time: rows of values, each due at its time.
 *
 * This file uses no clock; memory comes from the heap. Context: the thread of the runner. Cost: a comparison while no
 * row is due.
 */
#ifndef ECT_BUS_FAULTS_TABLE_H
#define ECT_BUS_FAULTS_TABLE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus/chain/chain.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** Maximum columns of a table. */
enum { ECT_TABLE_COLUMNS = 128 };

/** A row. Private. */
typedef struct ect_table_row {
    uint64_t due_ns;
    char *values[]; /* by column; NULL: not set */
} ect_table_row_t;

/** Private, except `slave`. */
typedef struct ect_table {
    struct ect_table *next;
    uint16_t slave; /**< from 1 */
    size_t columns, count, room, done;
    uint64_t base_ns, period_ns; /* start of the present repetition, and length of a repetition; 0: played once */
    char *names[ECT_TABLE_COLUMNS];
    ect_table_row_t **rows;
} ect_table_t;

/**
 * Makes an empty table for one slave.
 * @param names  of the signals, `columns` (1..ECT_TABLE_COLUMNS) of them; copied
 * @return NULL: out of memory. To be freed with ::ect_table_free
 */
ect_table_t *ect_table_new(uint16_t slave, const char *const *names, size_t columns);

/**
 * Adds a row.
 * @param due_ns  since the beginning of the run, not before that of the previous row
 * @param values  by column; empty: the signal keeps its value. Copied
 * @return false: out of memory
 */
bool ect_table_add(ect_table_t *table, uint64_t due_ns, const char *const *values);

/**
 * Interpolates rows, one every `every_ns`: each cell lies on the line from the number above to the number below in the
 * same column, and is an integer between integers. Empty cells are interpolated, too.
 * @param every_ns  not 0
 * @return NULL, or the constant reason of a failure, after which the table can only be freed
 */
const char *ect_table_refine(ect_table_t *table, uint64_t every_ns);

/** Makes a table repeat from its beginning at the time of its last row, endlessly. @return false: this time is 0 */
bool ect_table_loop(ect_table_t *table);

/** Frees a table and all tables linked after it. NULL: no effect */
void ect_table_free(ect_table_t *table);

/**
 * Checks that the chain has the slave and the signals, and that these take each value.
 * @param[out] message  on failure the reason, one line for the user; ECT_SIGNAL_MESSAGE bytes
 */
bool ect_table_check(const ect_table_t *table, const ect_chain_t *chain, char *message);

/** @return the time since the beginning at which the next row is due; ECT_NEVER: none is left */
static inline uint64_t ect_table_due(const ect_table_t *table)
{
    return table->done < table->count ? table->base_ns + table->rows[table->done]->due_ns : ECT_NEVER;
}

/**
 * Sets the signals of the next row, all of them or none.
 * @param[out] message  on failure the reason, one line for the user; ECT_SIGNAL_MESSAGE bytes
 * @return whether they were set
 */
bool ect_table_play(ect_table_t *table, ect_chain_t *chain, uint64_t now_ns, char *message);

ECT_C_END

#endif
