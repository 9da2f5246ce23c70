/* SPDX-License-Identifier: MIT */
/* A board without storage: MMIO_FLASH_DRIVER is not set. */
#include <stddef.h>

#include "board.h"

const ect_storage_t *board_storage(void)
{
    return NULL;
}
