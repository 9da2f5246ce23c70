/* SPDX-License-Identifier: MIT */
/* Options of every program under AddressSanitizer: a trap of UBSan prints the place of the undefined operation. */
const char *__asan_default_options(void); /* NOLINT(bugprone-reserved-identifier): its name */

__attribute__((visibility("default"))) const char *__asan_default_options(void)
{
    return "handle_sigill=1";
}
