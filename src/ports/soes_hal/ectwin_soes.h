/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A SOES firmware as a twin on a PC: a hardware file (ESC_read, ESC_write, ESC_init, ESC_reset) over a software ESC and
 * a network interface, in place of the board's.
 *
 * The firmware's own main loop runs unchanged, with the interface on its command line, `-i IFACE`, which its main may
 * ignore; or main consists of one line:
 *
 *     int main(int argc, char **argv) { return ectwin_soes_main(argc, argv); }
 *
 * Options: `-i IFACE` the interface of the twin, or $ECTWIN_SOES_IFACE · `--sii FILE` the EEPROM's content, or
 * $ECTWIN_SOES_SII; default: made from SDOobjects and ecat_options.h.
 *
 * One slave for each process, because SOES's names are variables. Context: one thread. The ESC replies to frames within
 * ESC_read of 0x0910, which each ecat_slv_poll reads, and of 0x0110; each of these reads waits for a frame, at most 1
 * ms, unless the application has work. SIGINT, SIGTERM and SIGHUP end the program there, with status 0.
 */
#ifndef ECT_PORTS_ECTWIN_SOES_H
#define ECT_PORTS_ECTWIN_SOES_H

#include "wire/linkage.h"

ECT_C_BEGIN

/**
 * A main function: accepts only the options above, calls ecat_slv_init with the result of ectwin_soes_config(), then
 * ecat_slv in an endless loop.
 * @return 1: wrong usage, with one line on standard error. Otherwise the function ends the program: 0 a signal, 2 the
 * interface or a file cannot be used
 */
int ectwin_soes_main(int argc, char **argv);

/**
 * May be defined by the application, for ::ectwin_soes_main. @return the configuration, which must stay valid. Default:
 * no hooks, and a watchdog of 1000 calls.
 */
struct esc_cfg *ectwin_soes_config(void);

ECT_C_END

#endif
