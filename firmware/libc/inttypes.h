/* SPDX-License-Identifier: MIT */
/** @file C11 §7.8 as far as it is asked for: the types of stdint.h, which the compiler has. Nobody prints on a board.
 */
#include <stdint.h>
