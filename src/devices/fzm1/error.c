/* SPDX-License-Identifier: MIT */
/* ERR and its causes (Q179 §4-2), and why something that was asked for was not done. */
#include <string.h>

#include "devices/fzm1/instance.h"

/* Text behind text, cut where the room ends. */
static void append(char *to, const char *text)
{
    size_t used = strlen(to);
    size_t length = strlen(text);
    length = length < FZM1_CAUSE - used ? length : FZM1_CAUSE - used;
    memcpy(to + used, text, length);
}

static void tell(fzm1_t *u)
{
    static const char *const causes[] = {"DSA did not come", "DSA stayed on", "results lost: 16 wait already",
                                         "EXE stayed on", "set by hand"};
    u->err = u->errors != 0;
    memset(u->error_cause, 0, sizeof u->error_cause);
    for (unsigned int i = 0; i < sizeof causes / sizeof causes[0]; i++) {
        if ((u->errors >> i & 1) == 0)
            continue;
        append(u->error_cause, u->error_cause[0] ? "; " : "");
        append(u->error_cause, causes[i]);
    }
}

void fzm1_set_error(fzm1_t *u, fzm1_error_t error)
{
    u->errors |= (uint8_t)error;
    tell(u);
}

void fzm1_end_errors(fzm1_t *u, unsigned int errors)
{
    u->errors &= (uint8_t)~errors;
    tell(u);
}

void fzm1_refuse(fzm1_refusal_t *refusal, const char *why)
{
    refusal->count++;
    memset(refusal->cause, 0, sizeof refusal->cause);
    append(refusal->cause, why);
}
