/* SPDX-License-Identifier: MIT */
#include "bus/chain/words.h"

#include <stdio.h>
#include <string.h>

#include "wire/assert.h"

bool ect_words_wrong(ect_words_t *w, const char *expected, const char *found)
{
    enum { EXPECTED = 215, FOUND = 60 };
    size_t length = strlen(expected);
    size_t left = ECT_WORDS_MESSAGE - sizeof ", not ''" - (length < EXPECTED ? length : EXPECTED);
    snprintf(w->message, ECT_WORDS_MESSAGE, "%.*s, not '%.*s'", EXPECTED, expected, (int)(left < FOUND ? left : FOUND),
             found ? found : "");
    return false;
}

bool ect_words_cut(ect_words_t *w, const ect_words_limits_t *limits, const char *text)
{
    char expected[80];
    size_t count = 0;
    ECT_ASSERT(limits->characters < sizeof w->room && limits->words <= ECT_WORDS_MOST);
    if (strlen(text) > limits->characters) {
        snprintf(expected, sizeof expected, "%s is at most %zu characters long", limits->name, limits->characters);
        return ect_words_wrong(w, expected, text);
    }
    snprintf(w->room, sizeof w->room, "%s", text);
    for (char *at = w->room + strspn(w->room, limits->separators); *at != 0; at += strspn(at, limits->separators)) {
        if (count == limits->words) {
            snprintf(expected, sizeof expected, "%s has at most %zu words", limits->name, limits->words);
            return ect_words_wrong(w, expected, text);
        }
        w->word[count++] = at;
        at += strcspn(at, limits->separators);
        if (*at != 0)
            *at++ = 0;
    }
    return true;
}

uint16_t ect_words_take_twin(ect_words_t *w)
{
    const char *word = ect_words_next(w);
    size_t number = word ? ect_names_find(w->names, word, strlen(word)) : 0;
    w->at += number > 0;
    return (uint16_t)number;
}

bool ect_words_take(ect_words_t *w, const char *word)
{
    if (!ect_words_next(w) || strcmp(ect_words_next(w), word) != 0)
        return false;
    w->at++;
    return true;
}
