/* SPDX-License-Identifier: MIT */
/**
 * @file
 * A SOES firmware as a twin on a PC: a hardware file (ESC_read, ESC_write, ESC_init, ESC_reset) with a software ESC and
 * a network interface behind it, in place of the one of the board.
 *
 * The firmware's own main loop runs as it is, its interface named on its command line, `-i IFACE`, whatever its main
 * makes of that; or main is one line:
 *
 *     int main(int argc, char **argv) { return ectwin_soes_main(argc, argv); }
 *
 * Options: `-i IFACE` the interface to answer on, or $ECTWIN_SOES_IFACE · `--sii FILE` the EEPROM's content, or
 * $ECTWIN_SOES_SII; without it it is made from SDOobjects and ecat_options.h.
 *
 * One slave a process: SOES's names are variables. Context: one thread. Frames are answered inside ESC_read of 0x0910,
 * which ecat_slv_poll reads once a turn, and of 0x0110; each waits for one, 1 ms at most, unless there is something to
 * do. SIGINT, SIGTERM and SIGHUP end the program in there, with status 0.
 */
#ifndef ECT_PORTS_ECTWIN_SOES_H
#define ECT_PORTS_ECTWIN_SOES_H

#include "wire/linkage.h"

ECT_C_BEGIN

/**
 * A main function: takes the options above and no others, then ecat_slv_init with what ectwin_soes_config() gives, then
 * ecat_slv for ever.
 * @return 1: wrong usage, with one line on standard error. Otherwise the function ends the program: 0 a signal, 2 the
 * interface or a file cannot be used
 */
int ectwin_soes_main(int argc, char **argv);

/**
 * The application's to define, for ::ectwin_soes_main: its configuration, which lives as long as the program. One that
 * does not gets no hooks, and a watchdog of 1000 turns.
 */
struct esc_cfg *ectwin_soes_config(void);

ECT_C_END

#endif
