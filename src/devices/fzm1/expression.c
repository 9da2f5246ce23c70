/* SPDX-License-Identifier: MIT */
/*
 * The expression of an output data (Q179 §3-2, "Expression"): D1 to D8, the measured values; JG, the overall judgement,
 * and JG0 to JG7, those of units, 1 or -1; numbers; + - * / and parentheses. The syntax is ectwin's, because Q179 does
 * not define one.
 */
#include <stddef.h>

#include "devices/fzm1/instance.h"

enum { DEEPEST = 8 /* nesting of parentheses and signs */ };

typedef struct reader {
    const char *at;
    const fzm1_result_t *measured;
    unsigned int depth;
    bool good;
} reader_t;

static double sum(reader_t *r);
static double factor(reader_t *r);

/* Reads a character if the text continues with it. @return whether the character was read */
static bool take(reader_t *r, char c)
{
    while (*r->at == ' ')
        r->at++;
    if (*r->at != c)
        return false;
    r->at++;
    return true;
}

static bool digit(const reader_t *r)
{
    return *r->at >= '0' && *r->at <= '9';
}

static double number(reader_t *r)
{
    double value = 0, place = 1;
    if (!digit(r))
        r->good = false;
    for (; digit(r); r->at++)
        value = 10 * value + (*r->at - '0');
    if (*r->at != '.')
        return value;
    for (r->at++; digit(r); r->at++) {
        place /= 10;
        value += place * (*r->at - '0');
    }
    return value;
}

static double measured(reader_t *r)
{
    unsigned int n = (unsigned int)(*r->at - '1');
    if (n >= FZM1_DATA) {
        r->good = false;
        return 0;
    }
    r->at++;
    return r->measured->data[n];
}

static double judgement(reader_t *r)
{
    if (!take(r, 'G')) {
        r->good = false;
        return 0;
    }
    if (!digit(r))
        return r->measured->overall;
    unsigned int unit = (unsigned int)(*r->at++ - '0');
    r->good &= unit < FZM1_UNITS;
    return unit < FZM1_UNITS ? r->measured->judgement[unit] : 0;
}

static double signed_factor(reader_t *r)
{
    if (take(r, '-'))
        return -factor(r);
    if (take(r, '(')) {
        double value = sum(r);
        r->good &= take(r, ')');
        return value;
    }
    if (take(r, 'D'))
        return measured(r);
    return take(r, 'J') ? judgement(r) : number(r);
}

/* Limits the depth of an expression, and with it the stack. */
static double factor(reader_t *r)
{
    if (++r->depth > DEEPEST)
        r->good = false;
    double value = r->good ? signed_factor(r) : 0;
    r->depth--;
    return value;
}

static double product(reader_t *r)
{
    double value = factor(r);
    while (r->good) {
        if (take(r, '*')) {
            value *= factor(r);
        } else if (take(r, '/')) {
            double by = factor(r);
            value = by < 0 || by > 0 ? value / by : 0; /* a division by 0 results in 0 */
        } else {
            break;
        }
    }
    return value;
}

static double sum(reader_t *r)
{
    double value = product(r);
    while (r->good) {
        if (take(r, '+'))
            value += product(r);
        else if (take(r, '-'))
            value -= product(r);
        else
            break;
    }
    return value;
}

bool fzm1_expression(const char *text, const fzm1_result_t *of, double *value)
{
    reader_t r = {.at = text, .measured = of, .good = true};
    double result = sum(&r);
    if (!r.good || !take(&r, 0))
        return false;
    *value = result;
    return true;
}
