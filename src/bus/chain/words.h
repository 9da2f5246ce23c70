/* SPDX-License-Identifier: MIT */
/**
 * @file
 * The words of a line that a user types: a fault, a step of a script.
 *
 * No clock and no heap in here. Context: any.
 */
#ifndef ECT_BUS_CHAIN_WORDS_H
#define ECT_BUS_CHAIN_WORDS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus/chain/names.h"
#include "wire/linkage.h"

ECT_C_BEGIN

/** Most words of a line; room of a line, and of a message about one, terminators included. */
enum { ECT_WORDS_MOST = 40, ECT_WORDS_ROOM = 256, ECT_WORDS_MESSAGE = 256 };

/** The words of a line, and the next one to read. Zeroed but for `message` and `names` before ::ect_words_cut. */
typedef struct ect_words {
    char room[ECT_WORDS_ROOM];
    const char *word[ECT_WORDS_MOST + 1]; /**< NULL behind the last one */
    size_t at;                            /**< index of the next one */
    char *message;                        /**< ECT_WORDS_MESSAGE bytes of the caller: the reason of a failure */
    const ect_names_t *names;             /**< of twins; NULL: none */
} ect_words_t;

/** A kind of line. */
typedef struct ect_words_limits {
    const char *name;       /**< in messages: "a fault" */
    const char *separators; /**< characters between words */
    size_t characters;      /**< most, 1..ECT_WORDS_ROOM - 1 */
    size_t words;           /**< most, 1..ECT_WORDS_MOST */
} ect_words_limits_t;

/** Cuts a text, which is copied, into words. @return false: it is too long or has too many words, with the message */
bool ect_words_cut(ect_words_t *words, const ect_words_limits_t *limits, const char *text);

/** @return the next word, which stays the next one; NULL: there is none */
static inline const char *ect_words_next(const ect_words_t *words)
{
    return words->word[words->at];
}

/** Takes the next word if it is this one. @return whether it is */
bool ect_words_take(ect_words_t *words, const char *word);

/** Takes the next word if it is the name of a twin. @return the number of the twin, from 1; 0: it is none */
uint16_t ect_words_take_twin(ect_words_t *words);

/**
 * Writes the message "EXPECTED, not 'FOUND'".
 * @param expected  cut behind 215 characters
 * @param found  cut behind 60 characters, or less where `expected` is long; NULL: nothing
 * @return false
 */
bool ect_words_wrong(ect_words_t *words, const char *expected, const char *found);

ECT_C_END

#endif
