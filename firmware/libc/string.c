/* SPDX-License-Identifier: MIT */
/* Compiled with -ffreestanding, because a compiler would otherwise replace the loops by calls of these functions. */
#include <string.h>

#include <stdint.h>

void *memcpy(void *restrict to, const void *restrict from, size_t size)
{
    return memmove(to, from, size);
}

void *memmove(void *to, const void *from, size_t size)
{
    unsigned char *t = to;
    const unsigned char *f = from;
    if (t < f) {
        for (size_t n = 0; n < size; n++)
            t[n] = f[n];
    } else {
        for (size_t n = size; n > 0; n--)
            t[n - 1] = f[n - 1];
    }
    return to;
}

void *memset(void *to, int value, size_t size)
{
    unsigned char *t = to;
    for (size_t n = 0; n < size; n++)
        t[n] = (unsigned char)value;
    return to;
}

int memcmp(const void *a, const void *b, size_t size)
{
    const unsigned char *x = a, *y = b;
    for (size_t n = 0; n < size; n++) {
        if (x[n] != y[n])
            return x[n] < y[n] ? -1 : 1;
    }
    return 0;
}

void *memchr(const void *of, int value, size_t size)
{
    const unsigned char *bytes = of;
    for (size_t n = 0; n < size; n++) {
        if (bytes[n] == (unsigned char)value)
            return (void *)(uintptr_t)&bytes[n];
    }
    return NULL;
}

size_t strlen(const char *text)
{
    size_t length = 0;
    while (text[length] != '\0')
        length++;
    return length;
}

int strcmp(const char *a, const char *b)
{
    while (*a != '\0' && *a == *b) {
        a++;
        b++;
    }
    return (unsigned char)*a - (unsigned char)*b;
}
