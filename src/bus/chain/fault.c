/* SPDX-License-Identifier: MIT */
#include "bus/chain/fault.h"
#include "wire/assert.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WORDS = 8 };

/* The parameter of each kind of fault. */
typedef enum amount { NO_AMOUNT, MICROSECONDS, BYTES, SIGNED, BIT, NANOSECONDS } amount_t;

typedef struct kind {
    const char *name, *second; /* of two words: the second one */
    amount_t amount;
    int32_t minimum, maximum;
    bool wire; /* may name one */
} kind_t;

static const kind_t kinds[ECT_FAULT_KINDS] = {
    [ECT_FAULT_DROP] = {"drop", NULL, NO_AMOUNT, 0, 0, true},
    [ECT_FAULT_DAMAGE] = {"damage", NULL, NO_AMOUNT, 0, 0, true},
    [ECT_FAULT_DELAY] = {"delay", NULL, MICROSECONDS, 1, 10000000, true},
    [ECT_FAULT_DUPLICATE] = {"duplicate", NULL, NO_AMOUNT, 0, 0, true},
    [ECT_FAULT_REORDER] = {"reorder", NULL, NO_AMOUNT, 0, 0, true},
    [ECT_FAULT_TRUNCATE] = {"truncate", NULL, BYTES, 1, 1500, true},
    [ECT_FAULT_CORRUPT] = {"corrupt", NULL, NO_AMOUNT, 0, 0, true},
    [ECT_FAULT_COUNTER] = {"counter", NULL, SIGNED, -32768, 32767, true},
    [ECT_FAULT_OFF] = {"off", NULL, NO_AMOUNT, 0, 0, false},
    [ECT_FAULT_HANG] = {"hang", NULL, NO_AMOUNT, 0, 0, false},
    [ECT_FAULT_RESUME] = {"resume", NULL, NO_AMOUNT, 0, 0, false},
    [ECT_FAULT_RESET] = {"reset", NULL, NO_AMOUNT, 0, 0, false},
    [ECT_FAULT_IDENTITY] = {"identity", NULL, NO_AMOUNT, 0, 0, false},
    [ECT_FAULT_LOSE_EVENT] = {"lose-event", NULL, NO_AMOUNT, 0, 0, false},
    [ECT_FAULT_EEPROM_BUSY] = {"eeprom", "busy", NO_AMOUNT, 0, 0, false},
    [ECT_FAULT_EEPROM_NACK] = {"eeprom", "nack", NO_AMOUNT, 0, 0, false},
    [ECT_FAULT_EEPROM_FLIP] = {"eeprom", "flip", BIT, 0, 15, false},
    [ECT_FAULT_EEPROM_OK] = {"eeprom", "ok", NO_AMOUNT, 0, 0, false},
    [ECT_FAULT_CLOCK] = {"clock", NULL, NANOSECONDS, INT32_MIN, INT32_MAX, false},
};

static const char *unit_of(amount_t amount)
{
    return amount == MICROSECONDS ? "us" : amount == NANOSECONDS ? "ns" : "";
}

/* The words of a text, and the next one to read. */
typedef struct reader {
    char room[ECT_FAULT_TEXT];
    const char *words[WORDS + 1]; /* NULL behind the last one */
    size_t at;
    char *message;
} reader_t;

static bool wrong(reader_t *r, const char *what, const char *found)
{
    snprintf(r->message, ECT_FAULT_MESSAGE, "%s, not '%.60s'", what, found ? found : "");
    return false;
}

static bool cut(reader_t *r, const char *text)
{
    size_t count = 0;
    if (snprintf(r->room, sizeof r->room, "%s", text) >= (int)sizeof r->room)
        return wrong(r, "a fault is at most 95 characters long", text);
    for (char *rest = r->room; rest;) {
        char *space = strchr(rest, ' ');
        if (space)
            *space = 0;
        if (*rest != 0 && count == WORDS)
            return wrong(r, "a fault has at most 8 words", text);
        if (*rest != 0)
            r->words[count++] = rest;
        rest = space ? space + 1 : NULL;
    }
    return true;
}

static bool take(reader_t *r, const char *word)
{
    if (!r->words[r->at] || strcmp(r->words[r->at], word) != 0)
        return false;
    r->at++;
    return true;
}

/* A number with its unit behind it, in a word of its own. */
static bool number(reader_t *r, const char *unit, long long minimum, long long maximum, long long *value)
{
    const char *word = r->words[r->at];
    char what[80], *end = NULL;
    long long got = word ? strtoll(word, &end, 10) : 0;
    snprintf(what, sizeof what, "expected a number from %lld to %lld%s%s", minimum, maximum, *unit ? " " : "", unit);
    if (!word || end == word || strcmp(end, unit) != 0 || got < minimum || got > maximum)
        return wrong(r, what, word);
    *value = got;
    r->at++;
    return true;
}

static void drop_words(reader_t *r, size_t at, size_t count)
{
    memmove(&r->words[at], &r->words[at + count], (WORDS + 1 - at - count) * sizeof r->words[0]);
}

static bool is_kind(const reader_t *r, size_t at, const kind_t *kind)
{
    if (strcmp(r->words[at], kind->name) != 0)
        return false;
    return !kind->second || (r->words[at + 1] && strcmp(r->words[at + 1], kind->second) == 0);
}

/* Finds the name of a kind and takes it out of the words. */
static bool read_kind(reader_t *r, ect_fault_t *fault)
{
    for (size_t at = 0; r->words[at]; at++) {
        for (unsigned int i = 0; i < ECT_FAULT_KINDS; i++) {
            if (!is_kind(r, at, &kinds[i]))
                continue;
            fault->kind = (ect_fault_kind_t)i;
            drop_words(r, at, kinds[i].second ? 2 : 1);
            return true;
        }
    }
    return wrong(r,
                 "expected drop, damage, delay, duplicate, reorder, truncate, corrupt, counter, off, hang, resume, "
                 "reset, identity, lose-event, eeprom busy|nack|flip|ok or clock",
                 r->words[0]);
}

/* The parts of a fault that have been read, beside its kind. */
typedef struct parts {
    bool when, place, amount;
} parts_t;

/* "every N", "frame N", "N%". @return whether the next word begins one; then in *good whether it is right */
static bool read_when(reader_t *r, ect_fault_t *fault, bool *good)
{
    long long value = 0;
    const char *word = r->words[r->at];
    if (take(r, "every")) {
        fault->when = ECT_FAULT_EVERY;
        *good = number(r, "", 1, 1000000000, &value);
    } else if (take(r, "frame")) {
        fault->when = ECT_FAULT_ONCE;
        *good = number(r, "", 1, 1000000000, &value);
    } else if (strchr(word, '%')) {
        fault->when = ECT_FAULT_SHARE;
        *good = number(r, "%", 0, 100, &value);
    } else {
        return false;
    }
    fault->number = (uint32_t)value;
    return true;
}

/* "slave N", or "wire N". @return as read_when() */
static bool read_place(reader_t *r, ect_fault_t *fault, bool *good)
{
    long long slave = 0;
    bool of_slave = !ect_fault_is_of_frames(fault) && fault->kind != ECT_FAULT_OFF;
    if (!(of_slave ? take(r, "slave") : kinds[fault->kind].wire && take(r, "wire")))
        return false;
    *good = number(r, "", 1, UINT16_MAX, &slave);
    fault->slave = (uint16_t)slave;
    return true;
}

static bool read_amount(reader_t *r, ect_fault_t *fault)
{
    const kind_t *kind = &kinds[fault->kind];
    long long amount = 0;
    if (!number(r, unit_of(kind->amount), kind->minimum, kind->maximum, &amount))
        return false;
    fault->amount = (int32_t)amount;
    return true;
}

/* The next part, whichever it is. */
static bool read_part(reader_t *r, ect_fault_t *fault, parts_t *parts)
{
    bool good = true;
    if (!parts->when && ect_fault_is_of_frames(fault) && read_when(r, fault, &good)) {
        parts->when = true;
    } else if (!parts->place && read_place(r, fault, &good)) {
        parts->place = true;
    } else if (!fault->back && ect_fault_is_of_frames(fault) && take(r, "back")) {
        fault->back = true;
    } else if (!parts->amount && kinds[fault->kind].amount != NO_AMOUNT) {
        parts->amount = true;
        good = read_amount(r, fault);
    } else {
        return wrong(r, "expected nothing more", r->words[r->at]);
    }
    return good;
}

static bool is_complete(reader_t *r, const ect_fault_t *fault, const parts_t *parts)
{
    const kind_t *kind = &kinds[fault->kind];
    if (kind->amount != NO_AMOUNT && !parts->amount) {
        long long none;
        return number(r, unit_of(kind->amount), kind->minimum, kind->maximum, &none);
    }
    if (fault->kind > ECT_FAULT_OFF && !parts->place)
        return wrong(r, "expected 'slave N'", NULL);
    if (fault->kind == ECT_FAULT_DAMAGE && !parts->place)
        return wrong(r, "expected 'wire N': damage happens on a wire", NULL);
    return !fault->back || parts->place || wrong(r, "expected 'wire N' with 'back'", "back");
}

bool ect_fault_parse(const char *text, ect_fault_t *fault, char *message)
{
    reader_t reader = {.message = message};
    parts_t parts = {0};
    *fault = (ect_fault_t){0};
    if (!cut(&reader, text) || !read_kind(&reader, fault))
        return false;
    while (reader.words[reader.at]) {
        if (!read_part(&reader, fault, &parts))
            return false;
    }
    return is_complete(&reader, fault, &parts);
}

/* --- writing ------------------------------------------------------------------------------------------------------ */

typedef struct writer {
    char *text;
    size_t used;
} writer_t;

static void put(writer_t *w, const char *word)
{
    int length = snprintf(w->text + w->used, ECT_FAULT_TEXT - w->used, "%s%s", w->used > 0 ? " " : "", word);
    w->used += length > 0 ? (size_t)length : 0;
}

static void put_number(writer_t *w, long long number_, const char *unit)
{
    char word[32];
    snprintf(word, sizeof word, "%lld%s", number_, unit);
    put(w, word);
}

const char *ect_fault_word(size_t kind)
{
    return kind < ECT_FAULT_KINDS ? kinds[kind].name : NULL;
}

void ect_fault_print(const ect_fault_t *fault, char *text)
{
    ECT_ASSERT(fault->kind < ECT_FAULT_KINDS);
    const kind_t *kind = &kinds[fault->kind];
    writer_t w = {.text = text};
    put(&w, kind->name);
    if (kind->second)
        put(&w, kind->second);
    if (kind->amount != NO_AMOUNT)
        put_number(&w, fault->amount, unit_of(kind->amount));
    if (fault->when == ECT_FAULT_SHARE)
        put_number(&w, fault->number, "%");
    if (fault->when == ECT_FAULT_EVERY || fault->when == ECT_FAULT_ONCE) {
        put(&w, fault->when == ECT_FAULT_EVERY ? "every" : "frame");
        put_number(&w, fault->number, "");
    }
    if (fault->slave == 0)
        return;
    put(&w, ect_fault_is_of_frames(fault) ? "wire" : "slave");
    put_number(&w, fault->slave, "");
    if (fault->back)
        put(&w, "back");
}
