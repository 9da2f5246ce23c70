/* SPDX-License-Identifier: MIT */
/** @file C11 §7.8 as far as it is needed: the types of stdint.h, which the compiler has. A board prints nothing.
 */
#include <stdint.h>
