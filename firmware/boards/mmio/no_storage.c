/* SPDX-License-Identifier: MIT */
/* A board that keeps nothing, for MMIO_FLASH_DRIVER names no file that would. */
#include <stddef.h>

#include "board.h"

const ect_storage_t *board_storage(void)
{
    return NULL;
}
