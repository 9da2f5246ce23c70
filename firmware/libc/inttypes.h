/* SPDX-License-Identifier: MIT */
/** @file The necessary part of C11 §7.8: the types of stdint.h, which the compiler provides. A board prints no numbers.
 */
#include <stdint.h>
