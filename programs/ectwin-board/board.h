/* SPDX-License-Identifier: MIT */
/** @file ectwin-board: one of the devices on a LAN9252 behind SPI, on Linux. A library, so that a test is the command
 * too. */
#ifndef ECTWIN_BOARD_H
#define ECTWIN_BOARD_H

/** The whole command. @return its exit status */
int ectwin_board_main(int argc, char **argv);

#endif
