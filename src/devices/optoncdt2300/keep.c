/* SPDX-License-Identifier: MIT */
/*
 * The selected values of the last records, in the order of 1A00h, in a ring. Its capacity equals three of the longest
 * exchanges: few long records or many short ones. A new selection begins with the last record.
 */
#include "devices/optoncdt2300/instance.h"

/* @return the number of records in the ring */
static uint32_t room(const opto_t *u)
{
    return u->mapped > 0 ? (uint32_t)OPTO_ROOM / u->mapped : 1;
}

static int32_t *place(opto_t *u, uint64_t number)
{
    return &u->kept[number % room(u) * u->mapped];
}

static void keep(opto_t *u, uint64_t number)
{
    int32_t *to = place(u, number);
    for (unsigned int n = 0; n < OPTO_VALUES; n++) {
        if (u->chosen[n])
            *to++ = u->record.value[n];
    }
    if (number - u->oldest >= room(u))
        u->oldest = number - room(u) + 1;
}

void opto_keep(opto_t *u)
{
    keep(u, u->taken++);
}

void opto_keep_last(opto_t *u)
{
    u->oldest = u->taken - 1;
    keep(u, u->oldest);
}

const int32_t *opto_kept(opto_t *u, uint64_t number)
{
    return place(u, number > u->oldest ? number : u->oldest);
}
