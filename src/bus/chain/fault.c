/* SPDX-License-Identifier: MIT */
#include "bus/chain/fault.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WORDS = 8 };

/* What stands behind the name of a kind. */
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

/* A text cut at its spaces, and how far it has been read. */
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

static bool read_kind(reader_t *r, ect_fault_t *fault)
{
    for (unsigned int i = 0; i < ECT_FAULT_KINDS; i++) {
        const kind_t *kind = &kinds[i];
        size_t before = r->at;
        if (!take(r, kind->name) || (kind->second && !take(r, kind->second))) {
            r->at = before;
            continue;
        }
        long long amount = 0;
        fault->kind = (ect_fault_kind_t)i;
        if (kind->amount != NO_AMOUNT && !number(r, unit_of(kind->amount), kind->minimum, kind->maximum, &amount))
            return false;
        fault->amount = (int32_t)amount;
        return true;
    }
    return wrong(r,
                 "expected drop, damage, delay, duplicate, reorder, truncate, corrupt, counter, off, hang, resume, "
                 "reset, identity, lose-event, eeprom busy|nack|flip|ok or clock",
                 r->words[r->at]);
}

static bool read_when(reader_t *r, ect_fault_t *fault)
{
    long long value = 0;
    const char *word = r->words[r->at];
    if (take(r, "every")) {
        fault->when = ECT_FAULT_EVERY;
        if (!number(r, "", 1, 1000000000, &value))
            return false;
    } else if (take(r, "frame")) {
        fault->when = ECT_FAULT_ONCE;
        if (!number(r, "", 1, 1000000000, &value))
            return false;
    } else if (word && strchr(word, '%')) {
        fault->when = ECT_FAULT_SHARE;
        if (!number(r, "%", 0, 100, &value))
            return false;
    }
    fault->number = (uint32_t)value;
    return true;
}

static bool read_place(reader_t *r, ect_fault_t *fault)
{
    long long slave = 0;
    bool of_slave = fault->kind > ECT_FAULT_OFF;
    bool named = of_slave ? take(r, "slave") : kinds[fault->kind].wire && take(r, "wire");
    if (of_slave && !named)
        return wrong(r, "expected 'slave N' at the end", r->words[r->at]);
    if (named && !number(r, "", 1, UINT16_MAX, &slave))
        return false;
    fault->slave = (uint16_t)slave;
    fault->back = named && !of_slave && take(r, "back");
    if (fault->kind == ECT_FAULT_DAMAGE && !named)
        return wrong(r, "expected 'wire N' at the end: damage happens on a wire", r->words[r->at]);
    return !r->words[r->at] || wrong(r, "expected nothing more", r->words[r->at]);
}

bool ect_fault_parse(const char *text, ect_fault_t *fault, char *message)
{
    reader_t reader = {.message = message};
    *fault = (ect_fault_t){0};
    return cut(&reader, text) && read_kind(&reader, fault) &&
           (!ect_fault_is_of_frames(fault) || read_when(&reader, fault)) && read_place(&reader, fault);
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

void ect_fault_print(const ect_fault_t *fault, char *text)
{
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
