/* SPDX-License-Identifier: MIT */
/* Network files with anything in them: each is refused with one line, or its first slaves become twins and have a
 * place. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "eni/bus.h"
#include "esi/twin.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { SLAVES_MOST = 4, MESSAGE = 300 };

static void try_slave(const ect_eni_t *eni, size_t i)
{
    char text[MESSAGE] = "";
    ect_eni_place_t place;
    if (ect_eni_place(eni, i, &place, text, sizeof text) ? place.port != 0 && place.up >= i : text[0] == '\0')
        abort();
    text[0] = '\0';
    ect_esi_t *esi = ect_eni_device(eni, i, text, sizeof text);
    ect_esi_twin_t *twin = ect_esi_twin_take(esi, "", NULL, 0, text, sizeof text);
    if (twin == NULL && (text[0] == '\0' || strchr(text, '\n') != NULL))
        abort();
    ect_esi_twin_free(twin);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char text[MESSAGE] = "";
    ect_eni_t *eni = ect_eni_parse("input", data, size, text, sizeof text);
    if (eni == NULL && (text[0] == '\0' || strchr(text, '\n') != NULL))
        abort();
    for (size_t i = 0; eni != NULL && i < ect_eni_network(eni)->slave_count && i < SLAVES_MOST; i++)
        try_slave(eni, i);
    ect_eni_close(eni);
    return 0;
}
