/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The words of a line typed by a user: a fault, a step of a script.
 *
 * This file uses no clock and no heap. Context: any.
 */
#ifndef ECT_BUS_CHAIN_WORDS_H
#define ECT_BUS_CHAIN_WORDS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus/chain/names.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** Maximum words of a line; sizes of a line and of a message about a line, with terminator. */
enum { ECT_WORDS_MOST = 40, ECT_WORDS_ROOM = 256, ECT_WORDS_MESSAGE = 256 };

/** The words of a line, and the next word to read. Zeroed before ::ect_words_cut, except `message` and `names`. */
typedef struct ect_words {
    char room[ECT_WORDS_ROOM];
    const char *word[ECT_WORDS_MOST + 1]; /**< NULL after the last word */
    size_t at;                            /**< index of the next word */
    char *message;                        /**< ECT_WORDS_MESSAGE bytes of the caller: the reason of a failure */
    const ect_names_t *names;             /**< of twins; NULL: none */
} ect_words_t;

/** Limits of a kind of line. */
typedef struct ect_words_limits {
    const char *name;       /**< in messages: "a fault" */
    const char *separators; /**< characters between words */
    size_t characters;      /**< maximum, 1..ECT_WORDS_ROOM - 1 */
    size_t words;           /**< maximum, 1..ECT_WORDS_MOST */
} ect_words_limits_t;

/** Splits a text, which is copied, into words. @return false: too long or too many words; `message` has the reason */
bool ect_words_cut(ect_words_t *words, const ect_words_limits_t *limits, const char *text);

/** @return the next word, without reading it; NULL: none */
static inline const char *ect_words_next(const ect_words_t *words)
{
    return words->word[words->at];
}

/** Reads the next word if it equals `word`. @return whether it does */
bool ect_words_take(ect_words_t *words, const char *word);

/** Reads the next word if it is the name of a twin. @return the number of the twin, from 1; 0: another word */
uint16_t ect_words_take_twin(ect_words_t *words);

/**
 * Writes the message "EXPECTED, not 'FOUND'".
 * @param expected  at most 215 characters are used
 * @param found  at most 60 characters are used, or fewer if `expected` is long; NULL: nothing
 * @return false
 */
bool ect_words_wrong(ect_words_t *words, const char *expected, const char *found);

ECT_C_END

#endif
