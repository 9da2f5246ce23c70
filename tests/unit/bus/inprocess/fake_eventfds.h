/* SPDX-License-Identifier: MIT */
/* Eventfds and memory of eventfds.c, for tests that plan their results. */
#ifndef TESTS_BUS_INPROCESS_FAKE_EVENTFDS_H
#define TESTS_BUS_INPROCESS_FAKE_EVENTFDS_H

#include "fakes.h"

int fake_eventfd(unsigned int value, int flags);
int fake_eventfd(unsigned int value, int flags)
{
    return (int)CALLED(eventfd, value, flags);
}

void *fake_calloc(size_t count, size_t size);
void *fake_calloc(size_t count, size_t size)
{
    return planned("calloc") != 0 ? NULL : calloc(count, size);
}

#endif
