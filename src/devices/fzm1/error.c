/* SPDX-License-Identifier: MIT */
/* ERR and its causes (Q179 §4-2), and the reasons of refusals. */
#include "devices/fzm1/instance.h"

void fzm1_set_error(fzm1_t *u, fzm1_error_t error)
{
    u->errors |= (uint16_t)error;
    u->err = true;
}

void fzm1_end_errors(fzm1_t *u, unsigned int errors)
{
    u->errors &= (uint16_t)~errors;
    u->err = u->errors != 0;
}

void fzm1_refuse(fzm1_refusal_t *refusal, fzm1_why_t why)
{
    refusal->count++;
    refusal->why = (uint16_t)why;
}
