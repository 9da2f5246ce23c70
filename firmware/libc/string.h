/* SPDX-License-Identifier: MIT */
/** @file The functions of the C library that the core uses (C11 §7.24), for a compiler without one.
 */
#ifndef FIRMWARE_STRING_H
#define FIRMWARE_STRING_H

#include <stddef.h>

void *memcpy(void *restrict to, const void *restrict from, size_t size);
void *memmove(void *to, const void *from, size_t size);
void *memset(void *to, int value, size_t size);
int memcmp(const void *a, const void *b, size_t size);
void *memchr(const void *of, int value, size_t size);
size_t strlen(const char *text);
int strcmp(const char *a, const char *b);

#endif
