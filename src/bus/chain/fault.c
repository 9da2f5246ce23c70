/* SPDX-License-Identifier: MIT */
#include "bus/chain/fault.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bus/chain/words.h"
#include "seams/device.h"
#include "seams/random.h"
#include "wire/assert.h"

/* The parameter of each kind of fault. */
typedef enum amount { NO_AMOUNT, MICROSECONDS, BYTES, SIGNED, BIT, NANOSECONDS, MILLISECONDS, STEP, REGISTER } amount_t;

/* Parts that a kind may have in addition to its amount. */
enum {
    WIRE = 1,        /* "wire N" */
    COUNTED = 2,     /* "every N", "5%", "3rd" */
    CODE = 4,        /* a hexadecimal number of 16 bits ... */
    LONG_CODE = 8,   /* ... or a larger one, of 32 bits */
    STATE = 16,      /* the name of a state */
    TO_STATE = 32,   /* "to" and the name of a state */
    OBJECT = 64,     /* an object */
    OF_OBJECT = 128, /* "of" and an object */
    DATA = 256,      /* "data" and five bytes */
    NEEDS_CODE = 512,
    NEEDS_STATE = 1024,
};

typedef struct kind {
    const char *name, *second; /* the second word of a name of two words */
    amount_t amount;
    int32_t minimum, maximum;
    unsigned int parts;
} kind_t;

static const kind_t kinds[ECT_FAULT_KINDS] = {
    [ECT_FAULT_DROP] = {"drop", NULL, NO_AMOUNT, 0, 0, WIRE},
    [ECT_FAULT_DAMAGE] = {"damage", NULL, NO_AMOUNT, 0, 0, WIRE},
    [ECT_FAULT_DELAY] = {"delay", NULL, MICROSECONDS, 1, 10000000, WIRE},
    [ECT_FAULT_DUPLICATE] = {"duplicate", NULL, NO_AMOUNT, 0, 0, WIRE},
    [ECT_FAULT_REORDER] = {"reorder", NULL, NO_AMOUNT, 0, 0, WIRE},
    [ECT_FAULT_TRUNCATE] = {"truncate", NULL, BYTES, 1, 1500, WIRE},
    [ECT_FAULT_CORRUPT] = {"corrupt", NULL, NO_AMOUNT, 0, 0, WIRE},
    [ECT_FAULT_COUNTER] = {"counter", NULL, SIGNED, -32768, 32767, WIRE},
    [ECT_FAULT_OFF] = {"off", NULL, NO_AMOUNT, 0, 0, 0},
    [ECT_FAULT_HANG] = {"hang", NULL, NO_AMOUNT, 0, 0, 0},
    [ECT_FAULT_RESUME] = {"resume", NULL, NO_AMOUNT, 0, 0, 0},
    [ECT_FAULT_RESET] = {"reset", NULL, NO_AMOUNT, 0, 0, 0},
    [ECT_FAULT_IDENTITY] = {"identity", NULL, NO_AMOUNT, 0, 0, 0},
    [ECT_FAULT_LOSE_EVENT] = {"lose-event", NULL, NO_AMOUNT, 0, 0, 0},
    [ECT_FAULT_EEPROM_BUSY] = {"eeprom", "busy", NO_AMOUNT, 0, 0, 0},
    [ECT_FAULT_EEPROM_NACK] = {"eeprom", "nack", NO_AMOUNT, 0, 0, 0},
    [ECT_FAULT_EEPROM_FLIP] = {"eeprom", "flip", BIT, 0, 15, 0},
    [ECT_FAULT_EEPROM_OK] = {"eeprom", "ok", NO_AMOUNT, 0, 0, 0},
    [ECT_FAULT_CLOCK] = {"clock", NULL, NANOSECONDS, INT32_MIN, INT32_MAX, 0},
    [ECT_FAULT_PDI_ERROR] = {"pdi-error", NULL, NO_AMOUNT, 0, 0, 0},
    [ECT_FAULT_TO] = {"to", NULL, NO_AMOUNT, 0, 0, STATE | NEEDS_STATE | CODE},
    [ECT_FAULT_INIT] = {"init", NULL, NO_AMOUNT, 0, 0, CODE},
    [ECT_FAULT_EMERGENCY] = {"emergency", NULL, REGISTER, 0, 255, CODE | NEEDS_CODE | DATA},
    [ECT_FAULT_AL] = {"al", NULL, NO_AMOUNT, 0, 0, CODE | NEEDS_CODE | TO_STATE},
    [ECT_FAULT_AL_REFUSE] = {"al", "refuse", NO_AMOUNT, 0, 0, CODE | NEEDS_CODE | TO_STATE},
    [ECT_FAULT_AL_NEVER] = {"al", "never", NO_AMOUNT, 0, 0, TO_STATE},
    [ECT_FAULT_ABORT] = {"abort", NULL, STEP, 1, 1000000, COUNTED | OBJECT | LONG_CODE | NEEDS_CODE},
    [ECT_FAULT_MAIL_TOGGLE] = {"mail", "toggle", NO_AMOUNT, 0, 0, COUNTED | OF_OBJECT},
    [ECT_FAULT_MAIL_COUNTER] = {"mail", "counter", NO_AMOUNT, 0, 0, COUNTED | OF_OBJECT},
    [ECT_FAULT_MAIL_TYPE] = {"mail", "type", NO_AMOUNT, 0, 0, COUNTED | OF_OBJECT},
    [ECT_FAULT_MAIL_LENGTH] = {"mail", "length", NO_AMOUNT, 0, 0, COUNTED | OF_OBJECT},
    [ECT_FAULT_MAIL_LATE] = {"mail", "late", MILLISECONDS, 1, 60000, COUNTED | OF_OBJECT},
    [ECT_FAULT_MAIL_TWICE] = {"mail", "twice", NO_AMOUNT, 0, 0, COUNTED | OF_OBJECT},
    [ECT_FAULT_MAIL_LOST] = {"mail", "lost", NO_AMOUNT, 0, 0, COUNTED | OF_OBJECT},
    [ECT_FAULT_PDO_SIZE] = {"pdo-size", NULL, SIGNED, -1024, 1024, 0},
};

static const char *unit_of(amount_t amount)
{
    return amount == MICROSECONDS ? "us" : amount == NANOSECONDS ? "ns" : amount == MILLISECONDS ? "ms" : "";
}

/* The word before an optional amount; NULL: the amount is mandatory. */
static const char *word_of(amount_t amount)
{
    return amount == STEP ? "step" : amount == REGISTER ? "register" : NULL;
}

_Static_assert((int)ECT_WORDS_MESSAGE <= (int)ECT_FAULT_MESSAGE, "the room includes a message about words");

static const ect_words_limits_t limits = {"a fault", " ", ECT_FAULT_TEXT - 1, 12};

/* Reads a word that consists of a number and its unit. */
static bool number(ect_words_t *r, const char *unit, long long minimum, long long maximum, long long *value)
{
    const char *word = ect_words_next(r);
    char what[80], *end = NULL;
    long long got = word ? strtoll(word, &end, 10) : 0;
    snprintf(what, sizeof what, "expected a whole number from %lld to %lld%s%s", minimum, maximum, *unit ? " " : "",
             unit);
    if (!word || end == word || strcmp(end, unit) != 0 || got < minimum || got > maximum)
        return ect_words_wrong(r, what, word);
    *value = got;
    r->at++;
    return true;
}

static void drop_words(ect_words_t *r, size_t at, size_t count)
{
    memmove(&r->word[at], &r->word[at + count], (ECT_WORDS_MOST + 1 - at - count) * sizeof r->word[0]);
}

static bool is_kind(const ect_words_t *r, size_t at, const kind_t *kind)
{
    if (strcmp(r->word[at], kind->name) != 0)
        return false;
    return !kind->second || (r->word[at + 1] && strcmp(r->word[at + 1], kind->second) == 0);
}

/* Lists the names, each once. @param second the first word of names of two words, to list the second ones; NULL: to
 * list the first words */
static void list_kinds(const char *first, char *list, size_t room)
{
    size_t used = 0;
    *list = 0;
    for (unsigned int i = 0; i < ECT_FAULT_KINDS; i++) {
        const char *word = first ? kinds[i].second : kinds[i].name;
        bool listed =
            first ? strcmp(kinds[i].name, first) == 0 && word : i == 0 || strcmp(word, kinds[i - 1].name) != 0;
        if (listed && used < room)
            used += (size_t)snprintf(list + used, room - used, "%s%s", used > 0 ? ", " : "", word);
    }
}

static bool no_kind(ect_words_t *r, size_t at)
{
    char list[ECT_FAULT_MESSAGE], what[ECT_FAULT_MESSAGE];
    list_kinds(r->word[at], list, sizeof list);
    if (r->word[at] && *list != 0) {
        snprintf(what, sizeof what, "expected one of %.120s after '%.20s'", list, r->word[at]);
        return ect_words_wrong(r, what, r->word[at + 1]);
    }
    list_kinds(NULL, list, sizeof list);
    snprintf(what, sizeof what, "expected %.245s", list);
    return ect_words_wrong(r, what, r->word[0]);
}

/* Finds the kind whose name begins with the word. @return ECT_FAULT_KINDS: none */
static unsigned int kind_at(const ect_words_t *r, size_t at)
{
    unsigned int i = ECT_FAULT_KINDS;
    while (i > 0 && !is_kind(r, at, &kinds[i - 1]))
        i--;
    return i > 0 ? i - 1 : ECT_FAULT_KINDS;
}

/* Finds the name of a kind and removes it from the words. The word "to" may also be a part of another kind. */
static bool read_kind(ect_words_t *r, ect_fault_t *fault)
{
    size_t almost = 0, found = 0;
    unsigned int kind = ECT_FAULT_KINDS;
    for (size_t at = 0; r->word[at]; at++) {
        unsigned int here = kind_at(r, at);
        char list[ECT_FAULT_MESSAGE];
        list_kinds(r->word[at], list, sizeof list);
        almost = *list != 0 ? at : almost;
        if (here == ECT_FAULT_KINDS || (kind != ECT_FAULT_KINDS && kind != ECT_FAULT_TO))
            continue;
        kind = here;
        found = at;
    }
    if (kind == ECT_FAULT_KINDS)
        return no_kind(r, almost);
    fault->kind = (ect_fault_kind_t)kind;
    drop_words(r, found, kinds[kind].second ? 2 : 1);
    return true;
}

/* The parts of a fault read so far, in addition to its kind. */
typedef struct parts {
    bool when, place, amount, code, state, data;
} parts_t;

static bool is_counted(const ect_fault_t *fault)
{
    return (kinds[fault->kind].parts & COUNTED) != 0;
}

/* Reads "every N", "frame N", "3rd", "N%". @return whether the next word begins such a part. @param[out] good on true,
 * whether the part is valid */
static bool read_when(ect_words_t *r, ect_fault_t *fault, bool *good)
{
    long long value = 0;
    const char *word = ect_words_next(r);
    if (ect_words_take(r, "every")) {
        fault->when = ECT_FAULT_EVERY;
        *good = number(r, "", 1, 1000000000, &value);
    } else if (!is_counted(fault) && ect_words_take(r, "frame")) {
        fault->when = ECT_FAULT_ONCE;
        *good = number(r, "", 1, 1000000000, &value);
    } else if (is_counted(fault) && ect_fault_ordinal(word) != 0) {
        fault->when = ECT_FAULT_ONCE;
        value = ect_fault_ordinal(word);
        r->at++;
    } else if (strchr(word, '%')) {
        fault->when = ECT_FAULT_SHARE;
        *good = number(r, "%", 0, 100, &value);
    } else {
        return false;
    }
    fault->number = (uint32_t)value;
    return true;
}

/* Reads "slave N" or "wire N". @return as read_when() */
static bool read_place(ect_words_t *r, ect_fault_t *fault, bool *good)
{
    long long slave = 0;
    bool of_slave = !ect_fault_is_of_frames(fault) && fault->kind != ECT_FAULT_OFF;
    if (!(of_slave ? ect_words_take(r, "slave") : (kinds[fault->kind].parts & WIRE) != 0 && ect_words_take(r, "wire")))
        return false;
    fault->slave = ect_words_take_twin(r);
    if (fault->slave != 0)
        return true;
    const char *word = ect_words_next(r);
    bool named = word && ect_name_begins(word) > 0;
    *good = named ? ect_words_wrong(r, "expected the number or the name of a twin", word)
                  : number(r, "", 1, UINT16_MAX, &slave);
    fault->slave = (uint16_t)slave;
    return true;
}

static bool read_amount(ect_words_t *r, ect_fault_t *fault)
{
    const kind_t *kind = &kinds[fault->kind];
    long long amount = 0;
    if (!number(r, unit_of(kind->amount), kind->minimum, kind->maximum, &amount))
        return false;
    fault->amount = (int32_t)amount;
    return true;
}

/* Reads a code of 16 bits, or a larger one. @return as read_when() */
static bool read_code(ect_words_t *r, ect_fault_t *fault)
{
    char *end = NULL;
    const char *word = ect_words_next(r);
    bool is_long = (kinds[fault->kind].parts & LONG_CODE) != 0;
    unsigned long long code = strncmp(word, "0x", 2) == 0 ? strtoull(word, &end, 16) : 0;
    if (!end || end == word + 2 || *end != 0 || code < (is_long ? 0x10000 : 1) ||
        code > (is_long ? UINT32_MAX : UINT16_MAX))
        return false;
    fault->code = (uint32_t)code;
    r->at++;
    return true;
}

/* Reads "SAFEOP" or "to SAFEOP". @return as read_when() */
static bool read_state(ect_words_t *r, ect_fault_t *fault, bool *good)
{
    unsigned int parts = kinds[fault->kind].parts;
    bool to = (parts & TO_STATE) != 0 && ect_words_take(r, "to");
    const char *word = ect_words_next(r);
    if (!to && ((parts & STATE) == 0 || ect_fault_state(word) == 0))
        return false;
    fault->state = word ? ect_fault_state(word) : 0;
    *good = fault->state != 0 || ect_words_wrong(r, "expected INIT, PREOP, BOOT, SAFEOP or OP after 'to'", word);
    r->at += *good ? 1 : 0;
    return true;
}

/* Reads an object, or "of" and an object. @return as read_when() */
static bool read_object(ect_words_t *r, ect_fault_t *fault, bool *good)
{
    unsigned int parts = kinds[fault->kind].parts;
    bool of = (parts & OF_OBJECT) != 0 && ect_words_take(r, "of");
    const char *word = ect_words_next(r);
    if (!of && (parts & OBJECT) == 0)
        return false;
    bool is_one = word && ect_fault_read_object(word, &fault->object);
    *good = is_one || !of || ect_words_wrong(r, "expected an object as 0x1018 or 0x1018:1 after 'of'", word);
    r->at += is_one ? 1 : 0;
    return of || is_one;
}

static bool read_transfer(ect_words_t *r, ect_fault_t *fault)
{
    const char *word = ect_words_next(r);
    fault->object.transfer = word ? ect_fault_transfer(word) : ECT_FAULT_ANY_TRANSFER;
    r->at += fault->object.transfer != ECT_FAULT_ANY_TRANSFER;
    return fault->object.transfer != ECT_FAULT_ANY_TRANSFER;
}

static bool read_data(ect_words_t *r, ect_fault_t *fault, bool *good)
{
    if ((kinds[fault->kind].parts & DATA) == 0 || !ect_words_take(r, "data"))
        return false;
    const char *word = ect_words_next(r);
    *good = word && strlen(word) == 2 * sizeof fault->data && strspn(word, "0123456789abcdefABCDEF") == strlen(word);
    if (!*good)
        (void)ect_words_wrong(r, "expected 10 hexadecimal digits after 'data'", word);
    for (size_t i = 0; *good && i < sizeof fault->data; i++) {
        const char digits[3] = {word[2 * i], word[2 * i + 1], 0};
        fault->data[i] = (uint8_t)strtoul(digits, NULL, 16);
    }
    r->at += *good ? 1 : 0;
    return true;
}

/* Reads a part of a fault above the wire. @return as read_when() */
static bool read_part_above(ect_words_t *r, ect_fault_t *fault, parts_t *parts, bool *good)
{
    unsigned int has = kinds[fault->kind].parts;
    if (!parts->code && (has & (CODE | LONG_CODE)) != 0 && read_code(r, fault))
        return parts->code = true;
    if (!parts->state && read_state(r, fault, good))
        return parts->state = true;
    if (!parts->data && read_data(r, fault, good))
        return parts->data = true;
    if (!fault->object.named && read_object(r, fault, good))
        return true;
    return is_counted(fault) && fault->object.transfer == ECT_FAULT_ANY_TRANSFER && read_transfer(r, fault);
}

/* Reads the amount, after its word if the kind has one. @return as read_when() */
static bool read_amount_part(ect_words_t *r, ect_fault_t *fault, bool *good)
{
    amount_t amount = kinds[fault->kind].amount;
    if (amount == NO_AMOUNT || (word_of(amount) && !ect_words_take(r, word_of(amount))))
        return false;
    *good = read_amount(r, fault);
    return true;
}

/* Reads the next part, of any kind. */
static bool read_part(ect_words_t *r, ect_fault_t *fault, parts_t *parts)
{
    bool good = true;
    bool of_frames = ect_fault_is_of_frames(fault);
    if (!parts->when && (of_frames || is_counted(fault)) && read_when(r, fault, &good))
        parts->when = true;
    else if (!parts->place && read_place(r, fault, &good))
        parts->place = true;
    else if (!fault->back && of_frames && ect_words_take(r, "back"))
        fault->back = true;
    else if (!read_part_above(r, fault, parts, &good)) {
        if (!good || parts->amount || !read_amount_part(r, fault, &good))
            return good && ect_words_wrong(r, "expected nothing more", ect_words_next(r));
        parts->amount = true;
    }
    return good;
}

static bool is_complete_above(ect_words_t *r, const ect_fault_t *fault, const parts_t *parts)
{
    unsigned int has = kinds[fault->kind].parts;
    if ((has & OBJECT) != 0 && !fault->object.named)
        return ect_words_wrong(r, "expected an object, as 0x1C12:1", NULL);
    if ((has & NEEDS_CODE) != 0 && !parts->code)
        return ect_words_wrong(
            r, (has & LONG_CODE) != 0 ? "expected an abort code, as 0x06040043" : "expected a code, as 0x001B", NULL);
    if ((has & NEEDS_STATE) != 0 && !parts->state)
        return ect_words_wrong(r, "expected INIT, PREOP, BOOT or SAFEOP", NULL);
    return fault->object.named || fault->object.transfer == ECT_FAULT_ANY_TRANSFER ||
           ect_words_wrong(r, "expected 'of' and an object with 'upload' or 'download'", NULL);
}

static bool is_complete(ect_words_t *r, const ect_fault_t *fault, const parts_t *parts)
{
    const kind_t *kind = &kinds[fault->kind];
    if (kind->amount != NO_AMOUNT && !word_of(kind->amount) && !parts->amount) {
        long long none;
        return number(r, unit_of(kind->amount), kind->minimum, kind->maximum, &none);
    }
    if (!is_complete_above(r, fault, parts))
        return false;
    if (fault->kind > ECT_FAULT_OFF && !parts->place)
        return ect_words_wrong(r, "expected 'slave N'", NULL);
    if (fault->kind == ECT_FAULT_DAMAGE && !parts->place)
        return ect_words_wrong(r, "expected 'wire N': damage happens on a wire", NULL);
    return !fault->back || parts->place || ect_words_wrong(r, "expected 'wire N' with 'back'", "back");
}

bool ect_fault_parse_named(const char *text, const ect_names_t *names, ect_fault_t *fault, char *message)
{
    ect_words_t reader = {.message = message, .names = names};
    parts_t parts = {0};
    *fault = (ect_fault_t){0};
    if (!ect_words_cut(&reader, &limits, text) || !read_kind(&reader, fault))
        return false;
    while (ect_words_next(&reader)) {
        if (!read_part(&reader, fault, &parts))
            return false;
    }
    return is_complete(&reader, fault, &parts);
}

bool ect_fault_parse(const char *text, ect_fault_t *fault, char *message)
{
    return ect_fault_parse_named(text, NULL, fault, message);
}

/* --- words -------------------------------------------------------------------------------------------------------- */

static const struct {
    const char *name;
    uint8_t state;
} states[] = {{"INIT", ECT_STATE_INIT},
              {"PREOP", ECT_STATE_PREOP},
              {"BOOT", ECT_STATE_BOOT},
              {"SAFEOP", ECT_STATE_SAFEOP},
              {"OP", ECT_STATE_OP}};

uint8_t ect_fault_state(const char *name)
{
    for (size_t i = 0; i < sizeof states / sizeof states[0]; i++) {
        if (strcmp(states[i].name, name) == 0)
            return states[i].state;
    }
    return 0;
}

ect_fault_transfer_t ect_fault_transfer(const char *word)
{
    bool upload = strcmp(word, "upload") == 0;
    return upload ? ECT_FAULT_UPLOAD : strcmp(word, "download") == 0 ? ECT_FAULT_DOWNLOAD : ECT_FAULT_ANY_TRANSFER;
}

static const char *name_of(uint8_t state)
{
    size_t i = 0;
    while (states[i].state != state)
        i++;
    return states[i].name;
}

/* Reads one to four hexadecimal digits. @return the text after the digits; NULL: none, or more than four */
static const char *hexadecimal(const char *at, uint16_t *value)
{
    char *end = NULL;
    unsigned long number_ = isxdigit((unsigned char)*at) ? strtoul(at, &end, 16) : 0;
    *value = (uint16_t)number_;
    return end && end - at <= 4 ? end : NULL;
}

bool ect_fault_read_object(const char *text, ect_fault_object_t *object)
{
    uint16_t index, sub = 0;
    bool prefixed = strncmp(text, "0x", 2) == 0;
    const char *at = hexadecimal(text + (prefixed ? 2 : 0), &index);
    if (!at || (!prefixed && *at != 'h'))
        return false;
    at += !prefixed;
    if (*at == ':') {
        char *end = NULL;
        unsigned long value = isdigit((unsigned char)at[1]) ? strtoul(at + 1, &end, 0) : 256;
        sub = (uint16_t)value;
        if (value > 255)
            return false;
        object->has_sub = true;
        at = end;
    }
    object->named = *at == 0;
    object->index = index;
    object->sub = (uint8_t)sub;
    return object->named;
}

static const char *ordinal_end(uint32_t number_)
{
    static const char *const ends[] = {"th", "st", "nd", "rd"};
    bool teen = number_ % 100 >= 11 && number_ % 100 <= 13;
    return ends[!teen && number_ % 10 <= 3 ? number_ % 10 : 0];
}

uint32_t ect_fault_ordinal(const char *text)
{
    char *end = NULL;
    unsigned long value = isdigit((unsigned char)*text) ? strtoul(text, &end, 10) : 0;
    bool good = value >= 1 && value <= 1000000000 && strcmp(end, ordinal_end((uint32_t)value)) == 0;
    return good ? (uint32_t)value : 0;
}

bool ect_fault_applies(const ect_fault_t *fault, uint64_t count, uint32_t *seed)
{
    switch (fault->when) {
    case ECT_FAULT_SHARE:
        return ect_random_next(seed) % 100u < fault->number;
    case ECT_FAULT_EVERY:
        return count % fault->number == 0;
    case ECT_FAULT_ONCE:
        return count == fault->number;
    default:
        return true;
    }
}

/* --- writing ------------------------------------------------------------------------------------------------------ */

typedef struct writer {
    char *text;
    size_t used;
    const ect_names_t *names;
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

static void put_hexadecimal(writer_t *w, uint32_t value, int digits)
{
    char word[32];
    snprintf(word, sizeof word, "0x%0*X", digits, (unsigned int)value);
    put(w, word);
}

static void put_object(writer_t *w, const ect_fault_t *fault)
{
    char word[32];
    const ect_fault_object_t *object = &fault->object;
    if (!object->named)
        return;
    if (fault->kind != ECT_FAULT_ABORT)
        put(w, "of");
    snprintf(word, sizeof word, object->has_sub ? "0x%04X:%u" : "0x%04X", object->index, object->sub);
    put(w, word);
    if (object->transfer != ECT_FAULT_ANY_TRANSFER)
        put(w, object->transfer == ECT_FAULT_UPLOAD ? "upload" : "download");
}

static void put_when(writer_t *w, const ect_fault_t *fault)
{
    if (fault->when == ECT_FAULT_SHARE) {
        put_number(w, fault->number, "%");
    } else if (fault->when == ECT_FAULT_ONCE && is_counted(fault)) {
        put_number(w, fault->number, ordinal_end(fault->number));
    } else if (fault->when != ECT_FAULT_ALWAYS) {
        put(w, fault->when == ECT_FAULT_EVERY ? "every" : "frame");
        put_number(w, fault->number, "");
    }
}

static void put_state(writer_t *w, const ect_fault_t *fault)
{
    if (fault->state == 0)
        return;
    if ((kinds[fault->kind].parts & TO_STATE) != 0)
        put(w, "to");
    put(w, name_of(fault->state));
}

static void put_data(writer_t *w, const ect_fault_t *fault)
{
    char word[2 * sizeof fault->data + 1];
    static const uint8_t none[sizeof fault->data];
    if (memcmp(fault->data, none, sizeof none) == 0)
        return;
    for (size_t i = 0; i < sizeof fault->data; i++)
        snprintf(word + 2 * i, 3, "%02x", fault->data[i]);
    put(w, "data");
    put(w, word);
}

static void put_amount(writer_t *w, const ect_fault_t *fault)
{
    amount_t amount = kinds[fault->kind].amount;
    if (amount == NO_AMOUNT || (word_of(amount) && fault->amount == 0))
        return;
    if (word_of(amount))
        put(w, word_of(amount));
    put_number(w, fault->amount, unit_of(amount));
}

static void put_place(writer_t *w, const ect_fault_t *fault)
{
    if (fault->slave == 0)
        return;
    put(w, ect_fault_is_of_frames(fault) ? "wire" : "slave");
    const char *name = ect_names_at(w->names, fault->slave - 1u);
    if (name && w->used + strlen(name) + sizeof " back" < ECT_FAULT_TEXT)
        put(w, name);
    else
        put_number(w, fault->slave, "");
    if (fault->back)
        put(w, "back");
}

void ect_fault_print(const ect_fault_t *fault, char *text)
{
    ect_fault_print_named(fault, NULL, text);
}

void ect_fault_print_named(const ect_fault_t *fault, const ect_names_t *names, char *text)
{
    ECT_ASSERT(fault->kind < ECT_FAULT_KINDS);
    const kind_t *kind = &kinds[fault->kind];
    writer_t w = {.text = text, .names = names};
    put(&w, kind->name);
    if (kind->second)
        put(&w, kind->second);
    put_object(&w, fault);
    put_state(&w, fault);
    if (fault->code != 0)
        put_hexadecimal(&w, fault->code, (kind->parts & LONG_CODE) != 0 ? 8 : 4);
    put_amount(&w, fault);
    put_data(&w, fault);
    put_when(&w, fault);
    put_place(&w, fault);
}
